/* Damping zones: velocities go down as they should, and waves do not come back. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81, pi = 3.14159265358979323846;

/* Nothing but the zone acts on a block that glides without pressure. */
static void all_beyond_the_zone_decays_at_the_full_rate(void) {
  for (int dim = 2; dim <= 3; dim++) {
    for (int stepper = SPH_STEPPER_SYMPLECTIC; stepper <= SPH_STEPPER_RK4; stepper++) {
      flow_world w =
          flow_open((flow_plan){.dim = dim, .dx = 0.1, .c0 = 20, .threads = 1 + stepper % 2});
      const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1}, u[3] = {0.7, -0.4, 0.2};
      SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
      flow_build(&w);
      SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, (sph_stepper)stepper));
      SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, (const double[]){0, 0, 0}));
      double *v = flow_read(&w, SPH_VELOCITY);
      const sph_index n = sph_particles_count(w.water);
      for (sph_index k = 0; k < n; k++)
        for (int d = 0; d < dim; d++) v[dim * k + d] = u[d];
      flow_write(&w, SPH_VELOCITY, v);
      free(v);
      SPH_TEST_OK(w.context, sph_wcsph_add_damping_zone(w.flow, 0, -2, -1, 3));
      SPH_TEST_OK(w.context, sph_wcsph_add_damping_zone(w.flow, dim - 1, 5, 4, 4));
      SPH_TEST_OK(w.context, sph_wcsph_add_damping_zone(w.flow, 1, 4, 5, 100)); /* before it */
      SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.2));
      v = flow_read(&w, SPH_VELOCITY);
      double *x = flow_read(&w, SPH_POSITION), most = 0;
      for (sph_index k = 0; k < n; k++)
        for (int d = 0; d < dim; d++)
          most = fmax(most, fabs(v[dim * k + d] - u[d] * exp(-7 * 0.2)));
      SPH_TEST_BELOW(most, 1e-12);
      /* Steps of 7 % of the decay move on by a first-order sum of it. */
      SPH_TEST_CLOSE(x[0] - 0.05, u[0] * (1 - exp(-7 * 0.2)) / 7, 0.06, 0);
      free(v);
      free(x);
      flow_free(&w);
    }
  }
}

/* Particles glide along a zone's lines, each at its own rate; so slowly that they hardly shear. Along the
 * other axis, which repeats, they pass the end of the box before lists are made anew. */
static void rates_rise_with_the_square_of_the_way(void) {
  for (int low_end = 0; low_end <= 1; low_end++) {
    flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 1, .precision = SPH_PRECISION_DOUBLE});
    const double lo[2] = {0, 0}, hi[2] = {2, 1}, u = 1e-6, rate = 12;
    SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
    flow_build(&w);
    SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, 1, 0, 1));
    SPH_TEST_OK(w.context, sph_wcsph_set_artificial_viscosity(w.flow, 0));
    SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, (const double[]){0, 0}));
    const double from = low_end ? 1.7 : 0.5, to = low_end ? 0.4 : 1.4;
    SPH_TEST_OK(w.context, sph_wcsph_add_damping_zone(w.flow, 0, from, to, rate));
    const sph_index n = sph_particles_count(w.water);
    double *v = flow_read(&w, SPH_VELOCITY), *x = flow_read(&w, SPH_POSITION);
    for (sph_index k = 0; k < n; k++) v[2 * k + 1] = u;
    flow_write(&w, SPH_VELOCITY, v);
    free(v);
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.3));
    v = flow_read(&w, SPH_VELOCITY);
    double most = 0;
    for (sph_index k = 0; k < n; k++) {
      const double way = fmin(fmax((x[2 * k] - from) / (to - from), 0), 1);
      most = fmax(most, fabs(v[2 * k + 1] / u - exp(-rate * way * way * 0.3)));
    }
    SPH_TEST_BELOW(most, 1e-5);
    free(v);
    free(x);
    flow_free(&w);
  }
}

/* Past the end of a box that repeats is its beginning, also before lists are made anew. */
static void zones_know_of_periods(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 20});
  const double lo[2] = {0, 0}, hi[2] = {1, 1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, 0, 0, 1));
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, (const double[]){0, 0}));
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-3));
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  const sph_index n = sph_particles_count(w.water);
  for (sph_index k = 0; k < n; k++) {
    x[2 * k] += 0.025 - 5e-4; /* the last column is just before the end */
    v[2 * k] = 1;
  }
  flow_write(&w, SPH_POSITION, x);
  flow_write(&w, SPH_VELOCITY, v);
  free(x);
  free(v);
  SPH_TEST_OK(w.context, sph_wcsph_add_damping_zone(w.flow, 0, 0.99, 0.995, 10));
  flow_steps(&w, 1);
  x = flow_read(&w, SPH_POSITION);
  v = flow_read(&w, SPH_VELOCITY);
  int past = 0;
  for (sph_index k = 0; k < n; k++) {
    past += x[2 * k] > 1;
    SPH_TEST_CLOSE(v[2 * k], 1, 1e-12, 0);
  }
  CU_ASSERT(past == 20);
  free(x);
  free(v);
  flow_free(&w);
}

/* A standing wave in a tank of two wavelengths, of which the second may be a zone: the largest kinetic energy
 * before it, in parts of the first, once the energy of either of the two waves that it is made of has gone
 * through the zone and come back. */
static double energy_that_comes_back(double rate) {
  const double depth = 0.2, wave = 1, k = 2 * pi / wave, kd = k * depth, height = 0.015;
  const double omega = sqrt(g * k * tanh(kd));
  const double group = 0.5 * omega / k * (1 + 2 * kd / sinh(2 * kd)), back = 4 * wave / group;
  flow_world w =
      flow_open((flow_plan){.dx = 0.02, .c0 = 18, .kernel = SPH_KERNEL_WENDLAND_C2, .ratio = 1.7});
  const double lo[2] = {0, 0}, hi[2] = {2 * wave, depth}, rim[2] = {2 * wave, 0.6};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, rim, SPH_SIDE_HI(1), &w.wall));
  flow_build(&w);
  flow_linear_pressure(&w, rho0 * g * depth, (const double[]){0, -rho0 * g});
  const sph_index n = sph_particles_count(w.water);
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  double first = 0, most = 0;
  for (sph_index i = 0; i < n; i++) {
    const double up = height * omega / sinh(kd), kx = k * x[2 * i], ky = k * x[2 * i + 1];
    v[2 * i] = up * cosh(ky) * sin(kx);
    v[2 * i + 1] = -up * sinh(ky) * cos(kx);
    if (x[2 * i] < wave) first += v[2 * i] * v[2 * i] + v[2 * i + 1] * v[2 * i + 1];
  }
  flow_write(&w, SPH_VELOCITY, v);
  if (rate > 0) SPH_TEST_OK(w.context, sph_wcsph_add_damping_zone(w.flow, 0, wave, 2 * wave, rate));
  free(x);
  free(v);
  for (int sample = 0; sample <= 8; sample++) {
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, back + sample * pi / omega / 8));
    x = flow_read(&w, SPH_POSITION);
    v = flow_read(&w, SPH_VELOCITY);
    double now = 0;
    for (sph_index i = 0; i < n; i++)
      if (x[2 * i] < wave) now += v[2 * i] * v[2 * i] + v[2 * i + 1] * v[2 * i + 1];
    most = fmax(most, now);
    free(x);
    free(v);
  }
  flow_free(&w);
  return most / first;
}

static void waves_do_not_come_back_from_a_zone_of_one_wavelength(void) {
  const double period = 2 * pi / sqrt(2 * pi * g * tanh(2 * pi * 0.2));
  const double open = energy_that_comes_back(0);
  const double damped = energy_that_comes_back(10 / period);
  SPH_TEST_BELOW(0.2, open); /* what viscosity leaves in five periods */
  SPH_TEST_BELOW(damped, 0.05 * open);
}

static void wrong_zones_are_refused(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.1, .c0 = 20});
  const double lo[2] = {0, 0}, hi[2] = {1, 1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_build(&w);
  sph_context *c = w.context;
  CU_ASSERT(sph_wcsph_add_damping_zone(NULL, 0, 0, 1, 10) == SPH_E_ARGUMENT);
  for (int axis = -1; axis <= 2; axis += 3)
    SPH_TEST_STATUS(c, sph_wcsph_add_damping_zone(w.flow, axis, 0, 1, 10), SPH_E_ARGUMENT,
                    "axis must be 0 to 1");
  const double ends[][2] = {{1, 1}, {NAN, 1}, {0, NAN}, {0, INFINITY}, {-1.7e308, 1.7e308}};
  for (int k = 0; k < 5; k++)
    SPH_TEST_STATUS(c, sph_wcsph_add_damping_zone(w.flow, 0, ends[k][0], ends[k][1], 10),
                    SPH_E_ARGUMENT, "needs two ends");
  const double rates[] = {0, -1, NAN, INFINITY};
  for (int k = 0; k < 4; k++)
    SPH_TEST_STATUS(c, sph_wcsph_add_damping_zone(w.flow, 0, 0, 1, rates[k]), SPH_E_ARGUMENT,
                    "rate of a damping zone must be > 0");
  for (int k = 0; k < 16; k++) SPH_TEST_OK(c, sph_wcsph_add_damping_zone(w.flow, k % 2, 0, 1, 10));
  SPH_TEST_STATUS(c, sph_wcsph_add_damping_zone(w.flow, 0, 0, 1, 10), SPH_E_ARGUMENT,
                  "at most 16 damping zones");
  flow_steps(&w, 1);
  flow_free(&w);
}

SPH_TEST_MAIN("damping zones",
              {"all beyond a zone decays at the full rate",
               all_beyond_the_zone_decays_at_the_full_rate},
              {"rates rise with the square of the way", rates_rise_with_the_square_of_the_way},
              {"zones know of periods", zones_know_of_periods},
              {"waves do not come back from a zone of one wavelength",
               waves_do_not_come_back_from_a_zone_of_one_wavelength},
              {"wrong zones are refused", wrong_zones_are_refused})
