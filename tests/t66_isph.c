/* Incompressible SPH: water at rest, divergence, decay of vortices, waves, singular systems, bad input. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81, pi = 3.14159265358979323846;

/* A tank of L = 4 H, in 3D with a width of 2 H; jittered if asked for. */
static flow_world tank(flow_plan plan, double height, double jitter) {
  plan.incompressible = true;
  if (!plan.kernel) plan.kernel = SPH_KERNEL_WENDLAND_C2;
  if (plan.ratio == 0) plan.ratio = 1.5;
  flow_world w = flow_open(plan);
  const double lo[3] = {0, 0, 0};
  const double hi2[2] = {4 * height, height}, hi3[3] = {4 * height, 2 * height, height};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, w.dim == 2 ? hi2 : hi3, rho0));
  if (w.dim == 2) {
    const double corners[] = {0, 3 * height, 0, 0, 4 * height, 0, 4 * height, 3 * height};
    SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, corners, false, &w.wall));
  } else {
    const double top[3] = {4 * height, 2 * height, 3 * height};
    SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 3, lo, top, 1u << 5, &w.wall));
  }
  if (jitter > 0) flow_jitter(&w, jitter, 7);
  flow_build(&w);
  return w;
}

/* Largest error of the pressure over rho g H, and the root of its mean square. */
static double pressure_error(const flow_world *w, double height, double *rms) {
  double *x = flow_read(w, SPH_POSITION), *p = flow_read(w, SPH_PRESSURE), most = 0, sum = 0;
  const sph_index n = sph_particles_count(w->water);
  for (sph_index k = 0; k < n; k++) {
    const double error = p[k] / (rho0 * g * height) - 1 + x[w->dim * k + w->dim - 1] / height;
    most = fmax(most, fabs(error));
    sum += error * error;
  }
  if (rms) *rms = sqrt(sum / (double)n);
  free(x);
  free(p);
  return most;
}

static double largest_speed(const flow_world *w) {
  double *v = flow_read(w, SPH_VELOCITY);
  const double most = flow_largest((int64_t)sph_particles_count(w->water) * w->dim, v);
  free(v);
  return most;
}

static void water_at_rest_stays_at_rest(void) {
  const struct {
    int dim;
    sph_kernel_type kernel;
    double ratio;
    sph_interpolator_type boundary;
  } cases[] = {{2, SPH_KERNEL_WENDLAND_C2, 1.5, SPH_INTERPOLATOR_IMPROVED_SHEPARD},
               {2, SPH_KERNEL_CUBIC_SPLINE, 1.2, SPH_INTERPOLATOR_MLS_LINEAR},
               {3, SPH_KERNEL_WENDLAND_C2, 1.5, SPH_INTERPOLATOR_IMPROVED_SHEPARD}};
  for (int k = 0; k < 3; k++) {
    const double height = cases[k].dim == 2 ? 0.2 : 0.08;
    flow_world w = tank((flow_plan){.dim = cases[k].dim,
                                    .dx = 0.01,
                                    .kernel = cases[k].kernel,
                                    .ratio = cases[k].ratio,
                                    .boundary = cases[k].boundary,
                                    .precision = SPH_PRECISION_DOUBLE},
                        height, 0);
    double force[3];
    flow_steps(&w, 40);
    SPH_TEST_BELOW(pressure_error(&w, height, NULL), 1e-5);
    SPH_TEST_BELOW(largest_speed(&w), 1e-5 * sqrt(g * height));
    SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
    const double area = w.dim == 2 ? 4 * height : 8 * height * height;
    SPH_TEST_CLOSE(force[w.dim - 1], -rho0 * g * height * area, 1e-4, 0);
    SPH_TEST_BELOW(fabs(force[0]), 1e-4 * rho0 * g * height * area);
    flow_free(&w);
  }
}

static double root_mean_square(int64_t n, const double *values) {
  double sum = 0;
  for (int64_t k = 0; k < n; k++) sum += values[k] * values[k];
  return sqrt(sum / (double)n);
}

/* Particles moved by up to a fifth of a spacing: pressures stay those of still water, and nothing is set in
 * motion for good. */
static void water_in_disorder_comes_to_rest(void) {
  const double height = 0.2;
  flow_world w = tank((flow_plan){.dx = 0.01}, height, 0.2);
  flow_steps(&w, 500);
  double *v = flow_read(&w, SPH_VELOCITY), force[2];
  const int64_t n = (int64_t)sph_particles_count(w.water);
  double rms;
  SPH_TEST_BELOW(pressure_error(&w, height, &rms), 0.05); /* one particle at the surface */
  SPH_TEST_BELOW(rms, 0.005);
  SPH_TEST_BELOW(root_mean_square(2 * n, v), 0.005 * sqrt(g * height));
  SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
  SPH_TEST_CLOSE(force[1], -rho0 * g * height * 4 * height, 0.005, 0);
  free(v);
  flow_free(&w);
}

/* What a projection takes from a field without divergence is nothing, and from a gradient all of it. */
static void projection_removes_gradients_alone(void) {
  for (int curl = 0; curl < 2; curl++) {
    const double k = 2 * pi;
    flow_world w = flow_open((flow_plan){
        .dx = 0.04, .kernel = SPH_KERNEL_WENDLAND_C2, .ratio = 1.5, .incompressible = true});
    const double lo[2] = {0, 0}, hi[2] = {1, 1};
    SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
    flow_jitter(&w, 0.2, 3);
    double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
    const int64_t n = (int64_t)sph_particles_count(w.water);
    for (int64_t i = 0; i < n; i++) {
      const double sx = sin(k * x[2 * i]), cx = cos(k * x[2 * i]);
      const double sy = sin(k * x[2 * i + 1]), cy = cos(k * x[2 * i + 1]);
      v[2 * i] = sx * cy;
      v[2 * i + 1] = curl ? -cx * sy : cx * sy;
    }
    flow_write(&w, SPH_VELOCITY, v);
    flow_build(&w);
    SPH_TEST_OK(w.context, sph_isph_set_periodic(w.flow, 0, 0, 1));
    SPH_TEST_OK(w.context, sph_isph_set_periodic(w.flow, 1, 0, 1));
    SPH_TEST_OK(w.context, sph_isph_set_gravity(w.flow, (const double[]){0, 0}));
    SPH_TEST_OK(w.context, sph_isph_set_surface_threshold(w.flow, 0));
    SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-6));
    sph_energy before, after;
    SPH_TEST_OK(w.context, sph_isph_get_energy(w.flow, &before));
    flow_steps(&w, 2);
    SPH_TEST_OK(w.context, sph_isph_get_energy(w.flow, &after));
    if (curl)
      SPH_TEST_CLOSE(after.kinetic, before.kinetic, 0.01, 0);
    else
      SPH_TEST_BELOW(after.kinetic, 0.01 * before.kinetic);
    free(x);
    free(v);
    flow_free(&w);
  }
}

/* A drop that its own motion stretches: semi-axes of the exact solution for u = (-A x, A y) on the unit disc,
 * a b = 1, A' = A^2 (a^2 - b^2)/(a^2 + b^2). */
static void a_drop_stretches_as_it_should(void) {
  const struct { double time, axis; } exact[] = {{0.4, 1.464774}, {1.0, 2.275516}, {2.0, 3.678985}};
  const double dx = 0.05;
  flow_world w = flow_open((flow_plan){
      .dx = dx, .kernel = SPH_KERNEL_WENDLAND_C2, .ratio = 1.5, .incompressible = true});
  double *x = malloc(2 * 41 * 41 * sizeof *x), *v = malloc(2 * 41 * 41 * sizeof *v);
  sph_index n = 0;
  for (int i = -20; i < 20; i++)
    for (int j = -20; j < 20; j++) {
      const double at[2] = {(i + 0.5) * dx, (j + 0.5) * dx};
      if (hypot(at[0], at[1]) >= 1) continue;
      x[2 * n] = at[0];
      x[2 * n + 1] = at[1];
      v[2 * n] = -at[0];
      v[2 * n + 1] = at[1];
      n++;
    }
  SPH_TEST_OK(w.context, sph_particles_add(w.water, n, x, rho0, NULL));
  SPH_TEST_OK(w.context, sph_particles_write(w.water, SPH_VELOCITY, v, 2 * n));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_isph_set_gravity(w.flow, (const double[]){0, 0}));
  SPH_TEST_OK(w.context,
              sph_isph_set_domain(w.flow, (const double[]){-5, -5}, (const double[]){5, 5}));
  sph_energy first, last;
  SPH_TEST_OK(w.context, sph_isph_get_energy(w.flow, &first));
  for (int k = 0; k < 3; k++) {
    double sum = 0;
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, exact[k].time));
    SPH_TEST_OK(w.context, sph_particles_read(w.water, SPH_POSITION, x, 2 * n));
    for (sph_index i = 0; i < n; i++) sum += x[2 * i + 1] * x[2 * i + 1];
    SPH_TEST_CLOSE(2 * sqrt(sum / (double)n), exact[k].axis, 0.01, 0);
  }
  SPH_TEST_OK(w.context, sph_isph_get_energy(w.flow, &last));
  SPH_TEST_CLOSE(last.kinetic, first.kinetic, 0.02, 0);
  free(x);
  free(v);
  flow_free(&w);
}

/* A column falls, meets the far wall and comes back: nothing is lost, nobody is given energy. */
static void a_dam_breaks_and_meets_the_wall(void) {
  const double height = 0.2, dx = 0.01;
  flow_world w = flow_open((flow_plan){.dx = dx,
                                       .kernel = SPH_KERNEL_WENDLAND_C2,
                                       .ratio = 1.5,
                                       .boundary = SPH_INTERPOLATOR_IMPROVED_SHEPARD,
                                       .incompressible = true});
  const double lo[2] = {0, 0}, hi[2] = {2 * height, height};
  const double right = 5.366 * height;
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  const double corners[] = {0, 8 * height, 0, 0, right, 0, right, 8 * height};
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, corners, false, &w.wall));
  flow_build(&w);
  sph_energy first, now;
  SPH_TEST_OK(w.context, sph_isph_get_energy(w.flow, &first));
  const double unit = sqrt(height / g);
  double most = first.total, arrival = 0;
  const int64_t n = (int64_t)sph_particles_count(w.water);
  while (sph_integrator_time(w.flow) < 6.5 * unit) {
    SPH_TEST_OK(w.context, sph_integrator_step(w.flow));
    SPH_TEST_OK(w.context, sph_isph_get_energy(w.flow, &now));
    most = fmax(most, now.total);
    double *x = flow_read(&w, SPH_POSITION);
    for (int64_t i = 0; i < n && arrival == 0; i++)
      if (x[2 * i] > right - dx) arrival = sph_integrator_time(w.flow);
    free(x);
  }
  SPH_TEST_CLOSE(arrival, 2.43 * unit, 0.05, 0);
  SPH_TEST_BELOW(most, 1.01 * first.total);
  SPH_TEST_BELOW(0.8 * first.total, now.total);
  flow_free(&w);
}

/* Vortices in a box that repeats: u decays by exp(-2 nu k^2 t). No surface: the system is singular. */
static void vortices_decay_as_they_should(void) {
  const double nu = 0.01, side = 1, k = 2 * pi / side;
  double error[2];
  for (int fine = 0; fine < 2; fine++) {
    flow_world w = flow_open((flow_plan){.dx = fine ? 0.02 : 0.04,
                                         .kernel = SPH_KERNEL_WENDLAND_C2,
                                         .ratio = 1.8,
                                         .incompressible = true});
    const double lo[2] = {0, 0}, hi[2] = {side, side};
    SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
    double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
    const sph_index n = sph_particles_count(w.water);
    for (sph_index i = 0; i < n; i++) {
      v[2 * i] = sin(k * x[2 * i]) * cos(k * x[2 * i + 1]);
      v[2 * i + 1] = -cos(k * x[2 * i]) * sin(k * x[2 * i + 1]);
    }
    flow_write(&w, SPH_VELOCITY, v);
    flow_build(&w);
    SPH_TEST_OK(w.context, sph_isph_set_periodic(w.flow, 0, 0, side));
    SPH_TEST_OK(w.context, sph_isph_set_periodic(w.flow, 1, 0, side));
    SPH_TEST_OK(w.context, sph_isph_set_gravity(w.flow, (const double[]){0, 0}));
    SPH_TEST_OK(w.context, sph_isph_set_laminar_viscosity(w.flow, nu));
    SPH_TEST_OK(w.context, sph_isph_set_surface_threshold(w.flow, 0));
    SPH_TEST_OK(w.context, sph_integrator_set_courant(w.flow, 0.1));
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.3));
    int64_t surface = -1;
    SPH_TEST_OK(w.context, sph_isph_count_surface(w.flow, &surface));
    CU_ASSERT(surface == 0);
    sph_energy energy;
    SPH_TEST_OK(w.context, sph_isph_get_energy(w.flow, &energy));
    const double exact = 0.25 * rho0 * side * side * exp(-4 * nu * k * k * 0.3);
    error[fine] = fabs(energy.kinetic / exact - 1);
    double *p = flow_read(&w, SPH_PRESSURE), mean = 0, size = 0;
    for (sph_index i = 0; i < n; i++) {
      mean += p[i] / n;
      size = fmax(size, fabs(p[i]));
    }
    SPH_TEST_BELOW(fabs(mean), 1e-3 * size); /* of all pressures, those with zero mean */
    free(x);
    free(v);
    free(p);
    flow_free(&w);
  }
  SPH_TEST_BELOW(error[1], 0.05);
  SPH_TEST_BELOW(error[1], 0.8 * error[0]);
}

/* A standing wave of one wavelength: its period is that of linear theory within 1 %. */
static void a_standing_wave_swings_in_its_period(void) {
  const double depth = 0.2, length = 0.8, height = 0.02, k = 2 * pi / length;
  flow_world w = flow_open((flow_plan){.dx = 0.01,
                                       .kernel = SPH_KERNEL_WENDLAND_C2,
                                       .ratio = 1.5,
                                       .boundary = SPH_INTERPOLATOR_IMPROVED_SHEPARD,
                                       .incompressible = true});
  const double lo[2] = {0, 0}, hi[2] = {length, depth};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  const double corners[] = {0, 3 * depth, 0, 0, length, 0, length, 3 * depth};
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, corners, false, &w.wall));
  /* Flat, with the velocities of a wave that passes through rest. */
  const double omega = sqrt(g * k * tanh(k * depth)), period = 2 * pi / omega;
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  const sph_index n = sph_particles_count(w.water);
  for (sph_index i = 0; i < n; i++) {
    const double speed = 0.5 * height * omega / sinh(k * depth);
    v[2 * i] = -speed * cosh(k * x[2 * i + 1]) * sin(k * x[2 * i]);
    v[2 * i + 1] = speed * sinh(k * x[2 * i + 1]) * cos(k * x[2 * i]);
  }
  flow_write(&w, SPH_VELOCITY, v);
  free(v);
  flow_build(&w);
  /* The amplitude of the mode in the momentum goes through zero at 1/4 and 3/4 of a period. */
  double zeros[2] = {0}, before = 1, time_before = 0;
  for (int found = 0; found < 2 && sph_integrator_time(w.flow) < 2 * period;) {
    SPH_TEST_OK(w.context, sph_integrator_step(w.flow));
    double *xs = flow_read(&w, SPH_POSITION), *vs = flow_read(&w, SPH_VELOCITY), mode = 0;
    for (sph_index i = 0; i < n; i++) mode -= vs[2 * i] * sin(k * xs[2 * i]);
    const double t = sph_integrator_time(w.flow);
    if (before * mode < 0)
      zeros[found++] = time_before + (t - time_before) * before / (before - mode);
    before = mode;
    time_before = t;
    free(xs);
    free(vs);
  }
  SPH_TEST_CLOSE(2 * (zeros[1] - zeros[0]), period, 0.01, 0);
  free(x);
  flow_free(&w);
}

/* All walls accelerate at once. At the surface the pressure stays 0, so that only a part of the water's mass
 * is felt: 1 - sum_n 8 tanh(k h) / ((k L)^3 h/L), k L = (2n + 1) pi, by potential flow. */
static void water_has_its_mass_in_a_tank_that_starts(void) {
  const double height = 0.2;
  double a = 1;
  flow_world w = tank((flow_plan){.dx = 0.01, .precision = SPH_PRECISION_DOUBLE}, height, 0);
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, flow_accelerate, &a));
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-3));
  flow_steps(&w, 1);
  double force[2];
  SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
  double share = 1;
  for (int n = 0; n < 1000; n++) {
    const double kl = (2 * n + 1) * pi;
    share -= 8 * tanh(kl / 4) / (kl * kl * kl / 4);
  }
  SPH_TEST_CLOSE(-force[0], share * rho0 * 4 * height * height * a, 0.03, 0);
  flow_free(&w);
}

static void one_and_two_threads_give_the_same_bits(void) {
  double *x[2];
  int64_t n = 0;
  for (int k = 0; k < 2; k++) {
    flow_world w = tank((flow_plan){.dx = 0.015, .threads = 1 + k}, 0.3, 0.1);
    flow_steps(&w, 20);
    x[k] = flow_read(&w, SPH_POSITION);
    n = (int64_t)sph_particles_count(w.water) * 2;
    flow_free(&w);
  }
  CU_ASSERT(memcmp(x[0], x[1], (size_t)n * sizeof *x[0]) == 0);
  free(x[0]);
  free(x[1]);
}

/* Other solvers find the same pressures, to their tolerance. */
static void any_solver_will_do(void) {
  double *p[2];
  int64_t n = 0;
  for (int k = 0; k < 2; k++) {
    flow_world w = tank((flow_plan){.dx = 0.02, .precision = SPH_PRECISION_DOUBLE}, 0.2, 0.1);
    sph_solver *solver = NULL;
    sph_status status = SPH_OK;
    if (k) {
      status = sph_isph_set_solver(w.flow, SPH_SOLVER_PETSC);
      if (status == SPH_E_UNAVAILABLE)
        SPH_TEST_OK(w.context, sph_isph_set_solver(w.flow, SPH_SOLVER_BICGSTAB));
      else
        SPH_TEST_OK(w.context, status);
      SPH_TEST_STATUS(w.context, sph_isph_set_solver(w.flow, (sph_solver_kind)9), SPH_E_ARGUMENT,
                      "9");
    }
    SPH_TEST_OK(w.context, sph_isph_get_solver(w.flow, &solver));
    SPH_TEST_OK(w.context, sph_solver_set_tolerance(solver, 1e-10, 0));
    if (k && status == SPH_E_UNAVAILABLE)
      SPH_TEST_OK(w.context, sph_solver_set_preconditioner(solver, SPH_PRECONDITIONER_ILU0));
    SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-3));
    flow_steps(&w, 3);
    p[k] = flow_read(&w, SPH_PRESSURE);
    n = (int64_t)sph_particles_count(w.water);
    flow_free(&w);
  }
  SPH_TEST_BELOW(flow_difference(n, p[0], p[1]), 1e-6 * rho0 * g * 0.2);
  free(p[0]);
  free(p[1]);
}

/* Nothing moves, time stands still, and another limit lets the run go on. */
static void what_does_not_converge_can_go_on(void) {
  flow_world w = tank((flow_plan){.dx = 0.01}, 0.2, 0.1);
  sph_solver *solver = NULL;
  flow_steps(&w, 3);
  SPH_TEST_OK(w.context, sph_isph_get_solver(w.flow, &solver));
  SPH_TEST_OK(w.context, sph_solver_set_limit(solver, 0));
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  const double time = sph_integrator_time(w.flow);
  SPH_TEST_STATUS(w.context, sph_integrator_step(w.flow), SPH_E_NOT_CONVERGED, "residual");
  double *x1 = flow_read(&w, SPH_POSITION), *v1 = flow_read(&w, SPH_VELOCITY);
  const int64_t n = (int64_t)sph_particles_count(w.water) * 2;
  CU_ASSERT(sph_integrator_time(w.flow) == time);
  SPH_TEST_BELOW(flow_difference(n, x, x1), 1e-15);
  CU_ASSERT(flow_difference(n, v, v1) == 0);
  SPH_TEST_OK(w.context, sph_solver_set_limit(solver, 1000));
  flow_steps(&w, 3);
  SPH_TEST_BELOW(time, sph_integrator_time(w.flow));
  free(x);
  free(v);
  free(x1);
  free(v1);
  flow_free(&w);
}

/* Spray: a drop of one particle falls freely, and hurts nobody. */
static void a_lone_particle_falls(void) {
  flow_world w = tank((flow_plan){.dx = 0.01}, 0.2, 0);
  const double drop[2] = {0.4, 0.45};
  SPH_TEST_OK(w.context, sph_particles_add(w.water, 1, drop, rho0, NULL));
  SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.1));
  double *x = flow_read(&w, SPH_POSITION), *p = flow_read(&w, SPH_PRESSURE);
  const sph_index last = sph_particles_count(w.water) - 1;
  SPH_TEST_CLOSE(x[2 * last + 1], 0.45 - 0.5 * g * 0.01, 0, 2e-4);
  SPH_TEST_CLOSE(x[2 * last], 0.4, 0, 1e-9);
  CU_ASSERT(p[last] == 0);
  free(x);
  free(p);
  flow_free(&w);
}

static void wrong_settings_are_refused(void) {
  flow_world w = tank((flow_plan){.dx = 0.02}, 0.2, 0);
  sph_context *c = w.context;
  sph_integrator *none = NULL;
  CU_ASSERT(sph_isph_create(NULL, w.kernel, w.water, NULL, &none) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_isph_create(c, NULL, w.water, NULL, &none), SPH_E_ARGUMENT,
                  "isph: kernel is NULL");
  SPH_TEST_STATUS(c, sph_isph_create(c, w.kernel, w.water, w.boundary, &none), SPH_E_ARGUMENT,
                  "another integrator has this boundary");
  CU_ASSERT(none == NULL);
  SPH_TEST_STATUS(c, sph_isph_set_laminar_viscosity(w.flow, -1), SPH_E_ARGUMENT,
                  "viscosity must be >= 0");
  SPH_TEST_STATUS(c, sph_isph_set_laminar_viscosity(w.flow, NAN), SPH_E_ARGUMENT,
                  "viscosity must be >= 0");
  SPH_TEST_STATUS(c, sph_isph_set_gradient(w.flow, (sph_isph_gradient)3), SPH_E_ARGUMENT,
                  "gradient must be one of");
  SPH_TEST_STATUS(c, sph_isph_set_laplacian(w.flow, (sph_isph_laplacian)0), SPH_E_ARGUMENT,
                  "Laplacian must be one of");
  SPH_TEST_STATUS(c, sph_isph_set_surface_threshold(w.flow, 2), SPH_E_ARGUMENT, "below 2");
  SPH_TEST_STATUS(c, sph_isph_set_density_correction(w.flow, -0.1), SPH_E_ARGUMENT, "0 to 1");
  SPH_TEST_STATUS(c, sph_isph_set_shifting(w.flow, NAN), SPH_E_ARGUMENT, "0 to 0.5");
  SPH_TEST_STATUS(c, sph_isph_set_collisions(w.flow, 2), SPH_E_ARGUMENT, "0 to 1, got 2");
  SPH_TEST_STATUS(c, sph_isph_set_reference_density(w.flow, 0), SPH_E_ARGUMENT,
                  "reference density must be > 0");
  SPH_TEST_STATUS(c, sph_isph_get_solver(w.flow, NULL), SPH_E_ARGUMENT, "solver is NULL");
  SPH_TEST_STATUS(c, sph_isph_count_surface(w.flow, NULL), SPH_E_ARGUMENT, "count is NULL");
  SPH_TEST_STATUS(c, sph_isph_get_energy(w.flow, NULL), SPH_E_ARGUMENT, "energy is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_set_sound_speed(w.flow, 10), SPH_E_TYPE,
                  "this setting is of \"wcsph\", the integrator is \"isph\"");
  SPH_TEST_STATUS(c, sph_integrator_set_stepper(w.flow, SPH_STEPPER_RK4), SPH_E_TYPE,
                  "has a stepper of its own");
  SPH_TEST_STATUS(c, sph_integrator_set_courant(w.flow, 1), SPH_E_ARGUMENT, "courant number");
  flow_free(&w);
  w = flow_open((flow_plan){.dx = 0.1});
  const double lo[2] = {0, 0}, hi[2] = {1, 1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_build(&w);
  SPH_TEST_STATUS(w.context, sph_isph_set_shifting(w.flow, 0.1), SPH_E_TYPE,
                  "this setting is of \"isph\"");
  flow_free(&w);
}

/* Whichever block of memory is missing, the status says so and nothing leaks. */
static void any_allocation_may_fail(void) {
  for (int allowed = 20; allowed < 400; allowed += 7) {
    sph_test_memory memory = {1 << 30, 0};
    const sph_allocator allocator = {sph_test_allocate, sph_test_release, &memory};
    flow_world w = tank((flow_plan){.dx = 0.05, .allocator = &allocator}, 0.3, 0);
    memory.allowed = allowed - 20;
    const sph_status status = sph_integrator_step(w.flow);
    CU_ASSERT(status == SPH_OK || status == SPH_E_MEMORY);
    memory.allowed = 1 << 30;
    SPH_TEST_OK(w.context, sph_integrator_step(w.flow));
    flow_free(&w);
    CU_ASSERT(memory.live == 0);
    if (status == SPH_OK) return;
  }
  CU_FAIL("a step wants more than 380 blocks of memory");
}

SPH_TEST_MAIN("incompressible SPH", {"water at rest stays at rest", water_at_rest_stays_at_rest},
              {"water in disorder comes to rest", water_in_disorder_comes_to_rest},
              {"projection removes gradients alone", projection_removes_gradients_alone},
              {"a drop stretches as it should", a_drop_stretches_as_it_should},
              {"a dam breaks and meets the wall", a_dam_breaks_and_meets_the_wall},
              {"vortices decay as they should", vortices_decay_as_they_should},
              {"a standing wave swings in its period", a_standing_wave_swings_in_its_period},
              {"water has its mass in a tank that starts",
               water_has_its_mass_in_a_tank_that_starts},
              {"one and two threads give the same bits", one_and_two_threads_give_the_same_bits},
              {"any solver will do", any_solver_will_do},
              {"what does not converge can go on", what_does_not_converge_can_go_on},
              {"a lone particle falls", a_lone_particle_falls},
              {"wrong settings are refused", wrong_settings_are_refused},
              {"any allocation may fail", any_allocation_may_fail})
