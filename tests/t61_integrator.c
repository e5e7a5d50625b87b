/* Time stepping: orders of convergence, stability limits, step control, errors. */
#include "flow_world.h"
#include "integrator/integrator_impl.h"

static const double rho0 = 1000, g = 9.81;
static const sph_stepper steppers[] = {SPH_STEPPER_SYMPLECTIC, SPH_STEPPER_VERLET, SPH_STEPPER_RK4};

/* Vortices in a periodic box without any dissipation, under a pressure that keeps all of the fluid in
 * compression. The kernel is smooth enough for fourth order to show. */
static flow_world vortices_open(sph_stepper stepper) {
  enum { N = 10 };
  const double U = 1, k = 2 * 3.14159265358979323846, lo[2] = {0, 0}, hi[2] = {1, 1},
               none[2] = {0, 0};
  flow_world w = flow_open((flow_plan){.dx = 1.0 / N,
                                       .c0 = 10,
                                       .kernel = SPH_KERNEL_WENDLAND_C6,
                                       .ratio = 1.8,
                                       .precision = SPH_PRECISION_DOUBLE});
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_jitter(&w, 0.1, 3);
  flow_build(&w);
  for (int d = 0; d < 2; d++) SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, d, 0, 1));
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, none));
  SPH_TEST_OK(w.context, sph_wcsph_set_artificial_viscosity(w.flow, 0));
  SPH_TEST_OK(w.context, sph_wcsph_set_diffusion(w.flow, SPH_DIFFUSION_NONE, 0));
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, stepper));
  double *x = flow_read(&w, SPH_POSITION), v[2 * N * N], p[N * N];
  for (int i = 0; i < N * N; i++) {
    v[2 * i] = U * sin(k * x[2 * i]) * cos(k * x[2 * i + 1]);
    v[2 * i + 1] = -U * cos(k * x[2 * i]) * sin(k * x[2 * i + 1]);
    p[i] = rho0 * U * U * (2 + 0.25 * (cos(2 * k * x[2 * i]) + cos(2 * k * x[2 * i + 1])));
  }
  flow_write(&w, SPH_VELOCITY, v);
  SPH_TEST_OK(w.context, sph_wcsph_start_from_pressure(w.flow, N * N, p));
  free(x);
  return w;
}

static double total_energy(const flow_world *w) {
  sph_energy e;
  SPH_TEST_OK(w->context, sph_wcsph_get_energy(w->flow, &e));
  return e.total;
}

/* Velocities at t = 0.16 and the relative change of energy until then. */
static double *vortices_run(sph_stepper stepper, double dt, double *change) {
  flow_world w = vortices_open(stepper);
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
  const double before = total_energy(&w);
  SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.16));
  *change = fabs(total_energy(&w) - before) / before;
  double *v = flow_read(&w, SPH_VELOCITY);
  flow_free(&w);
  return v;
}

static void steppers_have_their_order(void) {
  double energy;
  double *exact = vortices_run(SPH_STEPPER_RK4, 0.01 / 32, &energy);
  /* Without dissipation and with all of time resolved the pair sums conserve energy. */
  SPH_TEST_BELOW(energy, 1e-9);
  static const struct {
    sph_stepper stepper;
    double order, slack;
  } c[] = {
      {SPH_STEPPER_SYMPLECTIC, 1, 0.15}, {SPH_STEPPER_VERLET, 2, 0.15}, {SPH_STEPPER_RK4, 4, 0.2}};
  for (int k = 0; k < 3; k++) {
    double error[3];
    for (int halving = 0; halving < 3; halving++) {
      double *v = vortices_run(c[k].stepper, 0.008 / (1 << halving), &energy);
      error[halving] = flow_difference(200, v, exact);
      free(v);
    }
    SPH_TEST_CLOSE(log2(error[1] / error[2]), c[k].order, 0, c[k].slack);
    CU_ASSERT(error[2] > 1e-9 && error[0] < 0.2);
  }
  free(exact);
}

/* With the default dissipation and steps energy falls; what oscillates on the way is small. */
static void energy_falls(void) {
  for (int k = 0; k < 3; k++) {
    flow_world w = vortices_open(steppers[k]);
    SPH_TEST_OK(w.context, sph_wcsph_set_diffusion(w.flow, SPH_DIFFUSION_DELTA, 0.1));
    SPH_TEST_OK(w.context, sph_wcsph_set_artificial_viscosity(w.flow, 0.02));
    const double first = total_energy(&w);
    double least = first, growth = 0;
    for (int step = 0; step < 100; step++) {
      flow_steps(&w, 1);
      const double now = total_energy(&w);
      growth = fmax(growth, (now - least) / first);
      least = fmin(least, now);
    }
    SPH_TEST_BELOW(growth, 1e-3);
    SPH_TEST_BELOW(least / first, 0.99);
    flow_free(&w);
  }
}

/* A lattice in a periodic box with a little noise: how much the kinetic energy grew in `steps`. */
static double noise_growth(sph_kernel_type kernel, double ratio, int dim, sph_stepper stepper,
                           double delta, double alpha, double times_rule, int steps) {
  const int side = (int)ceil(2 * 3.05 * ratio) > 10 ? (int)ceil(2 * 3.05 * ratio) : 10;
  flow_world w = flow_open((flow_plan){.dim = dim,
                                       .dx = 1.0 / side,
                                       .c0 = 10,
                                       .kernel = kernel,
                                       .ratio = ratio,
                                       .precision = SPH_PRECISION_DOUBLE});
  const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1}, none[3] = {0, 0, 0};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_stir(&w, 1e-7, 9);
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_skin(w.flow, 0.001));
  for (int d = 0; d < dim; d++) SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, d, 0, 1));
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, none));
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, stepper));
  SPH_TEST_OK(w.context, sph_wcsph_set_artificial_viscosity(w.flow, alpha));
  SPH_TEST_OK(w.context, sph_wcsph_set_diffusion(
                             w.flow, delta > 0 ? SPH_DIFFUSION_DELTA : SPH_DIFFUSION_NONE, delta));
  const double limit = sph_integrator_stable_dt(w.flow);
  w.flow->fixed_dt = times_rule * limit; /* past the check of sph_integrator_set_dt */
  sph_energy before, after = {0};
  SPH_TEST_OK(w.context, sph_wcsph_get_energy(w.flow, &before));
  bool stopped = false;
  for (int k = 0; k < steps && !stopped; k++) stopped = sph_integrator_step(w.flow) != SPH_OK;
  SPH_TEST_OK(w.context, sph_wcsph_get_energy(w.flow, &after));
  flow_free(&w);
  return stopped ? HUGE_VAL : (after.kinetic + after.compressible) / before.kinetic;
}

typedef struct limit_row {
  sph_kernel_type kernel;
  double ratio;
  double conservative, diffusive,
      rk4; /* lattice limit over the rule, docs/theory/time_stepping.md */
} limit_row;

static const limit_row limits[] = {
    {SPH_KERNEL_GAUSSIAN, 1.3, 2.33 / 2.11, 1.25 / 1.23, 3.27 / 3.08},
    {SPH_KERNEL_QUINTIC_SPLINE, 1.3, 2.31 / 2.08, 1.24 / 1.22, 3.24 / 3.03},
    {SPH_KERNEL_CUBIC_SPLINE, 1.2, 1.87 / 1.68, 0.99 / 0.98, 2.62 / 2.45},
    {SPH_KERNEL_WENDLAND_C2, 1.5, 1.78 / 1.58, 0.95 / 0.92, 2.49 / 2.30},
    {SPH_KERNEL_WENDLAND_C4, 2.0, 1.53 / 1.38, 0.82 / 0.81, 2.15 / 2.01},
    {SPH_KERNEL_WENDLAND_C6, 2.0, 1.38 / 1.24, 0.73 / 0.72, 1.81 / 1.81}};

static void stable_below_the_limit(void) {
  for (size_t k = 0; k < sizeof limits / sizeof limits[0]; k++)
    for (int s = 0; s < 3; s++) {
      const double with =
          noise_growth(limits[k].kernel, limits[k].ratio, 2, steppers[s], 0.1, 0.02, 0.98, 150);
      SPH_TEST_BELOW(with, 1.5);
      const double without =
          noise_growth(limits[k].kernel, limits[k].ratio, 2, steppers[s], 0, 0, 0.98, 150);
      SPH_TEST_BELOW(without, 8); /* symplectic schemes keep a neighbour of the energy */
    }
  SPH_TEST_BELOW(noise_growth(SPH_KERNEL_GAUSSIAN, 1.3, 3, SPH_STEPPER_RK4, 0.1, 0.02, 0.98, 30),
                 1.5);
  SPH_TEST_BELOW(noise_growth(SPH_KERNEL_GAUSSIAN, 1.3, 2, SPH_STEPPER_RK4, 1, 0.02, 0.98, 150),
                 1.5);
}

static void unstable_above_it(void) {
  for (size_t k = 0; k < sizeof limits / sizeof limits[0]; k++)
    for (int s = 0; s < 3; s++) {
      const bool rk4 = steppers[s] == SPH_STEPPER_RK4;
      const double with = 1.15 * (rk4 ? limits[k].rk4 : limits[k].diffusive);
      const double without = 1.15 * (rk4 ? limits[k].rk4 : limits[k].conservative);
      CU_ASSERT(noise_growth(limits[k].kernel, limits[k].ratio, 2, steppers[s], 0.1, 0.02, with,
                             400) > 1e3);
      CU_ASSERT(noise_growth(limits[k].kernel, limits[k].ratio, 2, steppers[s], 0, 0, without,
                             400) > 1e3);
    }
}

/* A tank at rest. */
static flow_world tank_open(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 40});
  const double lo[2] = {0, 0}, hi[2] = {1, 0.5}, top[2] = {1, 1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, top, SPH_SIDE_HI(1), &w.wall));
  flow_build(&w);
  const double slope[2] = {0, -rho0 * g};
  flow_linear_pressure(&w, rho0 * g * 0.5, slope);
  return w;
}

static sph_integrator_stats stats_of(const flow_world *w) {
  sph_integrator_stats s;
  SPH_TEST_OK(w->context, sph_integrator_get_stats(w->flow, &s));
  return s;
}

static void the_limit_is_reported(void) {
  static const struct {
    double nu, gravity;
    sph_limiter limiter;
  } c[] = {{0, 9.81, SPH_LIMITER_SOUND},
           {0, 2e4, SPH_LIMITER_ACCELERATION},
           {2, 9.81, SPH_LIMITER_VISCOSITY}};
  for (int k = 0; k < 3; k++)
    for (int s = 0; s < 3; s++) {
      flow_world w = tank_open();
      const double down[2] = {0, -c[k].gravity};
      SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, down));
      SPH_TEST_OK(w.context, sph_wcsph_set_laminar_viscosity(w.flow, c[k].nu));
      SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[s]));
      SPH_TEST_OK(w.context, sph_integrator_set_courant(w.flow, 0.3));
      flow_steps(&w, 1); /* before it, only the body force is known of the accelerations */
      const sph_integrator_stats now = stats_of(&w);
      CU_ASSERT_EQUAL(now.limiter, c[k].limiter);
      const double nu = c[k].nu + 0.02 * w.h * 40 / 8;
      const double dt[] = {0.3 * w.h / 40, 0.25 * sqrt(w.h / c[k].gravity), 0.125 * w.h * w.h / nu};
      SPH_TEST_CLOSE(now.dt, dt[k], 1e-12, 0);
      flow_steps(&w, 1);
      SPH_TEST_CLOSE(stats_of(&w).dt, k == 1 ? 0.25 * sqrt(w.h / now.max_acceleration) : dt[k],
                     1e-12, 0);
      /* A fixed step is what it is. */
      SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-4));
      flow_steps(&w, 1);
      CU_ASSERT_EQUAL(stats_of(&w).limiter, SPH_LIMITER_FIXED);
      CU_ASSERT_EQUAL(stats_of(&w).dt, 1e-4);
      SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 0));
      flow_steps(&w, 1);
      CU_ASSERT_EQUAL(stats_of(&w).limiter, c[k].limiter);
      flow_free(&w);
    }
}

static void defaults_are_shares_of_the_limit(void) {
  static const double share[] = {0.4, 0.4, 0.65};
  flow_world w = tank_open();
  for (int s = 0; s < 3; s++) {
    SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[s]));
    flow_steps(&w, 1);
    SPH_TEST_CLOSE(stats_of(&w).dt, share[s] * sph_integrator_stable_dt(w.flow), 1e-12, 0);
    SPH_TEST_OK(w.context, sph_integrator_set_courant(w.flow, 0.25));
    flow_steps(&w, 1);
    SPH_TEST_CLOSE(stats_of(&w).dt, 0.25 * w.h / 40, 1e-12, 0);
    SPH_TEST_OK(w.context, sph_integrator_set_courant(w.flow, 0));
    flow_steps(&w, 1);
    SPH_TEST_CLOSE(stats_of(&w).dt, share[s] * sph_integrator_stable_dt(w.flow), 1e-12, 0);
  }
  flow_free(&w);
  /* Runge-Kutta 4 is what a new flow steps with: a step evaluates four times. */
  w = tank_open();
  flow_steps(&w, 3);
  CU_ASSERT_EQUAL(stats_of(&w).evaluations, 12);
  flow_free(&w);
}

static void advance_ends_exactly(void) {
  for (int fixed = 0; fixed < 2; fixed++) {
    flow_world w = tank_open();
    const double dt = 7e-4;
    if (fixed) SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
    static const double times[] = {0.01, 0.0100001, 0.0107, 0.03, 0.0301};
    for (int k = 0; k < 5; k++) {
      SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, times[k]));
      CU_ASSERT_EQUAL(sph_integrator_time(w.flow), times[k]);
      CU_ASSERT_EQUAL(stats_of(&w).time, times[k]);
      CU_ASSERT_EQUAL(stats_of(&w).limiter, SPH_LIMITER_END);
    }
    const int64_t steps = sph_integrator_steps(w.flow);
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.0301)); /* already there */
    CU_ASSERT_EQUAL(sph_integrator_steps(w.flow), steps);
    SPH_TEST_STATUS(w.context, sph_integrator_advance(w.flow, 0.03), SPH_E_ARGUMENT,
                    "cannot advance from 0.0301 s to 0.03 s");
    SPH_TEST_STATUS(w.context, sph_integrator_advance(w.flow, NAN), SPH_E_ARGUMENT,
                    "cannot advance");
    SPH_TEST_STATUS(w.context, sph_integrator_advance(w.flow, INFINITY), SPH_E_ARGUMENT,
                    "cannot advance");
    CU_ASSERT_EQUAL(sph_integrator_time(w.flow), 0.0301);
    /* Afterwards steps go on at full length. */
    flow_steps(&w, 1);
    CU_ASSERT_EQUAL(stats_of(&w).limiter, fixed ? SPH_LIMITER_FIXED : SPH_LIMITER_SOUND);
    flow_free(&w);
  }
}

/* No sliver of a last step: the last two are even. */
static void last_steps_are_even(void) {
  flow_world w = tank_open();
  const double dt = 1e-3;
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
  SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 4.02 * dt));
  CU_ASSERT_EQUAL(sph_integrator_steps(w.flow), 5);
  SPH_TEST_CLOSE(stats_of(&w).dt, 0.51 * dt, 1e-9, 0);
  SPH_TEST_OK(w.context,
              sph_integrator_advance(w.flow, 10.02 * dt)); /* whole steps, in spite of rounding */
  CU_ASSERT_EQUAL(sph_integrator_steps(w.flow), 11);
  SPH_TEST_CLOSE(stats_of(&w).dt, dt, 1e-6, 0);
  flow_free(&w);
}

static void stats_grow(void) {
  flow_world w = tank_open();
  const sph_integrator_stats none = stats_of(&w);
  CU_ASSERT(none.steps == 0 && none.time == 0 && none.evaluations == 0 && none.builds == 0 &&
            none.dt == 0);
  flow_stir(&w, 0.5, 3);
  sph_probe *probe;
  SPH_TEST_OK(w.context, sph_probe_create_energy(w.flow, &probe));
  sph_integrator_stats before = none;
  for (int k = 1; k <= 40; k++) {
    flow_steps(&w, 1);
    const sph_integrator_stats now = stats_of(&w);
    CU_ASSERT(now.steps == k && sph_integrator_steps(w.flow) == k);
    CU_ASSERT(now.time > before.time && now.time == sph_integrator_time(w.flow));
    SPH_TEST_CLOSE(now.time, before.time + now.dt, 1e-14, 0);
    CU_ASSERT(now.evaluations > before.evaluations);
    CU_ASSERT(now.builds >= before.builds && now.builds >= 1 && now.contacts >= before.contacts);
    /* At least a particle's own pair, in every evaluation. */
    CU_ASSERT(now.pairs - before.pairs >=
              sph_particles_count(w.water) * (now.evaluations - before.evaluations));
    CU_ASSERT(now.list_entries > 0 && now.max_speed > 0 && now.max_acceleration > 0);
    CU_ASSERT(now.seconds_sort >= before.seconds_sort &&
              now.seconds_search >= before.seconds_search &&
              now.seconds_pack >= before.seconds_pack);
    CU_ASSERT(now.seconds_boundary >= before.seconds_boundary &&
              now.seconds_pairs >= before.seconds_pairs);
    CU_ASSERT(now.seconds_update >= before.seconds_update &&
              now.seconds_observers >= before.seconds_observers);
    /* The largest speed and acceleration are those of the particles. */
    double *v = flow_read(&w, SPH_VELOCITY), most = 0;
    for (sph_index i = 0; i < sph_particles_count(w.water); i++)
      most = fmax(most, hypot(v[2 * i], v[2 * i + 1]));
    SPH_TEST_CLOSE(now.max_speed, most, 1e-12, 0);
    free(v);
    before = now;
  }
  CU_ASSERT(before.builds > 1);
  CU_ASSERT(before.seconds_pairs > 0 && before.seconds_sort > 0 && before.seconds_search > 0);
  CU_ASSERT(before.seconds_boundary > 0);
  sph_probe_destroy(&probe);
  flow_free(&w);
}

/* Particles that touch a wall and still approach it are stopped, and counted. */
static void contacts_are_counted(void) {
  flow_world w = tank_open();
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  x[2 * 4] = 0.1 * w.dx; /* a particle of the first column, pressed to the wall */
  v[2 * 4] = -3;
  flow_write(&w, SPH_POSITION, x);
  flow_write(&w, SPH_VELOCITY, v);
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_SYMPLECTIC));
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-4));
  flow_steps(&w, 1);
  CU_ASSERT(stats_of(&w).contacts >= 1);
  free(x);
  x = flow_read(&w, SPH_POSITION);
  CU_ASSERT(x[2 * 4] > 0);
  free(x);
  free(v);
  flow_free(&w);
}

/* A step that nothing braked carries a particle 0.3 dx into the wall: it is put back, and stopped. */
static void crossed_is_put_back(void) {
  flow_world w = tank_open();
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_RK4));
  const double dt = 0.01 * sph_integrator_stable_dt(w.flow);
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
  x[2 * 4] = 0.3 * w.dx;
  v[2 * 4] = -0.6 * w.dx / dt;
  flow_write(&w, SPH_POSITION, x);
  flow_write(&w, SPH_VELOCITY, v);
  flow_steps(&w, 1);
  CU_ASSERT(stats_of(&w).contacts >= 1);
  free(x);
  free(v);
  x = flow_read(&w, SPH_POSITION);
  v = flow_read(&w, SPH_VELOCITY);
  CU_ASSERT(x[2 * 4] > 0 && x[2 * 4] < 0.01 * w.dx);
  CU_ASSERT(v[2 * 4] > -1e-9 * w.dx / dt);
  free(x);
  free(v);
  flow_free(&w);
}

static double warnings;
static void count_warnings(sph_log_level level, const char *message, void *user) {
  (void)user;
  if (level == SPH_LOG_WARNING && strstr(message, "above 0.7 of the lattice limit")) warnings++;
}

static void unstable_steps_are_refused(void) {
  flow_world w = tank_open();
  sph_context *c = w.context;
  SPH_TEST_OK(c, sph_context_set_log(c, count_warnings, NULL));
  for (int s = 0; s < 3; s++) {
    SPH_TEST_OK(c, sph_integrator_set_stepper(w.flow, steppers[s]));
    const double limit = sph_integrator_stable_dt(w.flow);
    SPH_TEST_STATUS(c, sph_integrator_set_dt(w.flow, 1.001 * limit), SPH_E_ARGUMENT,
                    "is unstable; the limit");
    SPH_TEST_STATUS(c, sph_integrator_set_courant(w.flow, 1.001 * limit * 40 / w.h), SPH_E_ARGUMENT,
                    "courant number must be 0 to");
    warnings = 0;
    SPH_TEST_OK(c, sph_integrator_set_dt(w.flow, 0.69 * limit));
    CU_ASSERT_EQUAL(warnings, 0);
    SPH_TEST_OK(c, sph_integrator_set_dt(w.flow, 0.99 * limit));
    CU_ASSERT_EQUAL(warnings, 1);
    SPH_TEST_OK(c, sph_integrator_set_courant(w.flow, 0.99 * limit * 40 / w.h));
    SPH_TEST_OK(c, sph_integrator_set_courant(w.flow, 0));
    SPH_TEST_OK(c, sph_integrator_set_dt(w.flow, 0));
  }
  /* What would make the step in use unstable is refused, and nothing changes. */
  const double limit = sph_integrator_stable_dt(w.flow);
  SPH_TEST_OK(c, sph_integrator_set_dt(w.flow, 0.7 * limit));
  SPH_TEST_STATUS(c, sph_integrator_set_stepper(w.flow, SPH_STEPPER_SYMPLECTIC), SPH_E_ARGUMENT,
                  "beyond the stable");
  SPH_TEST_STATUS(c, sph_wcsph_set_sound_speed(w.flow, 80), SPH_E_ARGUMENT,
                  "call sph_integrator_set_dt first");
  SPH_TEST_STATUS(c, sph_wcsph_set_diffusion(w.flow, SPH_DIFFUSION_DELTA, 1), SPH_E_ARGUMENT,
                  "call sph_integrator_set_dt first");
  CU_ASSERT_EQUAL(sph_integrator_stable_dt(w.flow), limit);
  flow_steps(&w, 2);
  CU_ASSERT_EQUAL(stats_of(&w).dt, 0.7 * limit);
  CU_ASSERT_EQUAL(stats_of(&w).evaluations, 8);
  SPH_TEST_OK(c, sph_integrator_set_dt(w.flow, 0));
  SPH_TEST_OK(c, sph_integrator_set_courant(w.flow, 2));
  SPH_TEST_STATUS(c, sph_integrator_set_stepper(w.flow, SPH_STEPPER_VERLET), SPH_E_ARGUMENT,
                  "courant number 2 is beyond the stable");
  SPH_TEST_STATUS(c, sph_wcsph_set_diffusion(w.flow, SPH_DIFFUSION_DELTA, 1), SPH_E_ARGUMENT,
                  "courant number 2");
  flow_free(&w);
}

static void argument_errors(void) {
  flow_world w = tank_open();
  sph_context *c = w.context;
  sph_integrator *none = NULL;
  sph_integrator_destroy(NULL);
  sph_integrator_destroy(&none);
  CU_ASSERT_EQUAL(sph_integrator_set_stepper(NULL, SPH_STEPPER_RK4), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_integrator_set_dt(NULL, 0), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_integrator_set_courant(NULL, 0), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_integrator_step(NULL), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_integrator_advance(NULL, 1), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_integrator_stable_dt(NULL), 0);
  CU_ASSERT_EQUAL(sph_integrator_time(NULL), 0);
  CU_ASSERT_EQUAL(sph_integrator_steps(NULL), 0);
  CU_ASSERT_PTR_NULL(sph_integrator_particles(NULL));
  CU_ASSERT_PTR_EQUAL(sph_integrator_particles(w.flow), w.water);
  sph_integrator_stats stats;
  CU_ASSERT_EQUAL(sph_integrator_get_stats(NULL, &stats), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_integrator_get_stats(w.flow, NULL), SPH_E_ARGUMENT, "stats is NULL");
  SPH_TEST_STATUS(c, sph_integrator_set_stepper(w.flow, (sph_stepper)0), SPH_E_ARGUMENT, "got 0");
  SPH_TEST_STATUS(c, sph_integrator_set_stepper(w.flow, (sph_stepper)4), SPH_E_ARGUMENT, "got 4");
  static const double bad[] = {-1e-9, NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 4; k++) {
    SPH_TEST_STATUS(c, sph_integrator_set_dt(w.flow, bad[k]), SPH_E_ARGUMENT, "time step");
    SPH_TEST_STATUS(c, sph_integrator_set_courant(w.flow, bad[k]), SPH_E_ARGUMENT,
                    "courant number must be");
  }
  sph_stepper stepper = SPH_STEPPER_RK4;
  CU_ASSERT_EQUAL(sph_stepper_find(NULL, "rk4", &stepper), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_stepper_find(c, NULL, &stepper), SPH_E_ARGUMENT, "name is NULL");
  SPH_TEST_STATUS(c, sph_stepper_find(c, "rk4", NULL), SPH_E_ARGUMENT, "stepper is NULL");
  SPH_TEST_STATUS(c, sph_stepper_find(c, "rk5", &stepper), SPH_E_NAME, "did you mean \"rk4\"?");
  SPH_TEST_STATUS(c, sph_stepper_find(c, "simplectic", &stepper), SPH_E_NAME,
                  "did you mean \"symplectic\"?");
  CU_ASSERT_EQUAL(stepper, SPH_STEPPER_RK4);
  static const char *const names[] = {"symplectic", "verlet", "rk4"};
  for (int k = 0; k < 3; k++) {
    SPH_TEST_OK(c, sph_stepper_find(c, names[k], &stepper));
    CU_ASSERT_EQUAL(stepper, steppers[k]);
  }
  flow_free(&w);
}

/* A caller's changes between steps are taken up: steps go on as from the new state. */
static void changes_are_taken_up(void) {
  for (int s = 0; s < 3; s++) {
    flow_world a = tank_open(), b = tank_open();
    SPH_TEST_OK(a.context, sph_integrator_set_stepper(a.flow, steppers[s]));
    SPH_TEST_OK(b.context, sph_integrator_set_stepper(b.flow, steppers[s]));
    flow_steps(&a, 4);
    /* b starts with what a has after four steps, a is told its own state. */
    static const char *const fields[] = {SPH_POSITION, SPH_VELOCITY, SPH_DENSITY, SPH_MASS};
    for (int k = 0; k < 4; k++) {
      double *values = flow_read(&a, fields[k]);
      flow_write(&a, fields[k], values);
      flow_write(&b, fields[k], values);
      free(values);
    }
    SPH_TEST_OK(a.context, sph_integrator_set_dt(a.flow, 1e-3));
    SPH_TEST_OK(b.context, sph_integrator_set_dt(b.flow, 1e-3));
    flow_steps(&a, 5);
    flow_steps(&b, 5);
    double *x = flow_read(&a, SPH_POSITION), *y = flow_read(&b, SPH_POSITION);
    SPH_TEST_BELOW(flow_difference(400, x, y), 1e-8);
    free(x);
    free(y);
    /* Particles that are added or removed belong to the flow from then on. */
    const double drop[2] = {0.5, 0.8};
    const int64_t first = 0;
    int64_t id = 0;
    SPH_TEST_OK(a.context, sph_particles_add(a.water, 1, drop, rho0, &id));
    SPH_TEST_OK(a.context, sph_particles_remove(a.water, 1, &first));
    flow_steps(&a, 10);
    double *v = flow_read(&a, SPH_VELOCITY);
    SPH_TEST_CLOSE(v[2 * 199 + 1], -g * 0.01, 1e-6, 0); /* the drop falls freely */
    free(v);
    flow_free(&a);
    flow_free(&b);
  }
}

SPH_TEST_MAIN("integrator", {"steppers have their orders", steppers_have_their_order},
              {"energy falls with the default dissipation", energy_falls},
              {"noise does not grow below the limit, every kernel and stepper",
               stable_below_the_limit},
              {"noise grows above the lattice limit", unstable_above_it},
              {"what limits a step is told", the_limit_is_reported},
              {"default steps are shares of the limit", defaults_are_shares_of_the_limit},
              {"advance ends exactly at its time", advance_ends_exactly},
              {"the last two steps are even", last_steps_are_even},
              {"counters and times grow", stats_grow},
              {"contacts with walls are stopped and counted", contacts_are_counted},
              {"a particle that came into a wall is put back", crossed_is_put_back},
              {"unstable steps are refused", unstable_steps_are_refused},
              {"argument errors", argument_errors},
              {"changes by the caller are taken up", changes_are_taken_up})
