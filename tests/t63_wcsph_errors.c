/* Weakly compressible SPH refuses what cannot work, and stops when a run has gone wrong. */
#include "flow_world.h"
#include "integrator/integrator_impl.h"

static const double rho0 = 1000, g = 9.81;
static const sph_stepper steppers[] = {SPH_STEPPER_SYMPLECTIC, SPH_STEPPER_VERLET, SPH_STEPPER_RK4};

/* Water 1 x 0.5 m in a tank of 1 x 1 m at rest. */
static flow_world tank_open(flow_plan plan) {
  plan.dx = 0.05;
  flow_world w = flow_open(plan);
  const double lo[2] = {0, 0}, hi[2] = {1, 0.5}, top[2] = {1, 1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, top, SPH_SIDE_HI(1), &w.wall));
  flow_build(&w);
  if (plan.c0 > 0) {
    const double slope[2] = {0, -rho0 * g};
    flow_linear_pressure(&w, rho0 * g * 0.5, slope);
  }
  return w;
}

static void creation_errors(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.05});
  sph_context *c = w.context;
  char place;
  sph_integrator *out = (sph_integrator *)&place;
  SPH_TEST_STATUS(c, sph_wcsph_create(c, w.kernel, w.water, NULL, &out), SPH_E_ARGUMENT,
                  "particles \"water\" are none; fill the set first");
  CU_ASSERT_PTR_NULL(out);
  const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1};
  SPH_TEST_OK(c, sph_particles_fill_box(w.water, lo, hi, rho0));
  CU_ASSERT_EQUAL(sph_wcsph_create(NULL, w.kernel, w.water, NULL, &out), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_wcsph_create(c, NULL, w.water, NULL, &out), SPH_E_ARGUMENT,
                  "kernel is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_create(c, w.kernel, NULL, NULL, &out), SPH_E_ARGUMENT,
                  "particles is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_create(c, w.kernel, w.water, NULL, NULL), SPH_E_ARGUMENT,
                  "out is NULL");
  for (int dim = 1; dim <= 3; dim += 2) {
    sph_kernel *kernel;
    char text[64];
    snprintf(text, sizeof text, "the kernel has dimension %d, particles \"water\" have 2", dim);
    SPH_TEST_OK(c, sph_kernel_create(c, SPH_KERNEL_WENDLAND_C2, dim, 0.07, &kernel));
    out = (sph_integrator *)&place;
    SPH_TEST_STATUS(c, sph_wcsph_create(c, kernel, w.water, NULL, &out), SPH_E_ARGUMENT, text);
    CU_ASSERT_PTR_NULL(out);
    sph_kernel_destroy(&kernel);
  }
  /* Walls of another dimension. */
  sph_kernel *kernel;
  sph_interpolator *interpolator;
  SPH_TEST_OK(c, sph_kernel_create(c, SPH_KERNEL_GAUSSIAN, 3, w.h, &kernel));
  SPH_TEST_OK(c, sph_interpolator_create(c, SPH_INTERPOLATOR_MLS_LINEAR, kernel, &interpolator));
  sph_wall *box;
  SPH_TEST_OK(c, sph_wall_create_box(c, 3, lo, hi, 0, &box));
  sph_boundary *boundary;
  SPH_TEST_OK(c, sph_boundary_create(c, box, 0.2, interpolator, &boundary));
  SPH_TEST_STATUS(c, sph_wcsph_create(c, w.kernel, w.water, boundary, &out), SPH_E_ARGUMENT,
                  "the boundary has dimension 3");
  sph_boundary_destroy(&boundary);
  sph_wall_destroy(&box);
  sph_interpolator_destroy(&interpolator);
  sph_kernel_destroy(&kernel);
  /* Ghosts that do not fill the kernel's support. */
  SPH_TEST_OK(c, sph_wall_create_box(c, 2, lo, hi, 0, &w.wall));
  SPH_TEST_OK(c, sph_kernel_create(c, SPH_KERNEL_GAUSSIAN, 2, 0.99 * w.h, &kernel));
  SPH_TEST_OK(c, sph_interpolator_create(c, SPH_INTERPOLATOR_MLS_LINEAR, kernel, &interpolator));
  SPH_TEST_OK(c, sph_boundary_create(c, w.wall, w.dx, interpolator, &boundary));
  SPH_TEST_STATUS(c, sph_wcsph_create(c, w.kernel, w.water, boundary, &out), SPH_E_ARGUMENT,
                  "give the interpolator a kernel of at least that support");
  sph_boundary_destroy(&boundary);
  sph_interpolator_destroy(&interpolator);
  sph_kernel_destroy(&kernel);
  /* Nothing was added to the set on the way; a field of that name must fit. */
  CU_ASSERT_EQUAL(sph_particles_field_count(w.water), 6);
  SPH_TEST_OK(c, sph_particles_add_field(w.water, "acceleration", 1, "m/s^2"));
  SPH_TEST_STATUS(c, sph_wcsph_create(c, w.kernel, w.water, NULL, &out), SPH_E_ARGUMENT,
                  "field \"acceleration\" must have 2 components, it has 1");
  CU_ASSERT_PTR_NULL(out);
  flow_free(&w);
}

static void contexts_do_not_mix(void) {
  flow_world a = tank_open((flow_plan){.c0 = 0}), b = tank_open((flow_plan){.c0 = 0});
  sph_integrator *out = NULL;
  SPH_TEST_STATUS(a.context, sph_wcsph_create(a.context, b.kernel, a.water, NULL, &out),
                  SPH_E_ARGUMENT, "of another context");
  SPH_TEST_STATUS(a.context, sph_wcsph_create(a.context, a.kernel, b.water, NULL, &out),
                  SPH_E_ARGUMENT, "of another context");
  SPH_TEST_STATUS(a.context, sph_wcsph_create(a.context, a.kernel, a.water, b.boundary, &out),
                  SPH_E_ARGUMENT, "of another context");
  sph_boundary *boundary = NULL;
  SPH_TEST_STATUS(a.context,
                  sph_boundary_create(a.context, a.wall, a.dx, b.interpolator, &boundary),
                  SPH_E_ARGUMENT, "of another context");
  flow_free(&a);
  flow_free(&b);
}

/* A boundary keeps one flow's neighbours: a second flow has to have its own. */
static void a_boundary_serves_one_flow(void) {
  flow_world w = tank_open((flow_plan){.c0 = 40});
  sph_integrator *second = NULL;
  SPH_TEST_STATUS(w.context, sph_wcsph_create(w.context, w.kernel, w.water, w.boundary, &second),
                  SPH_E_ARGUMENT, "another integrator");
  CU_ASSERT_PTR_NULL(second);
  flow_steps(&w, 3);
  sph_integrator_destroy(&w.flow);
  SPH_TEST_OK(w.context, sph_wcsph_create(w.context, w.kernel, w.water, w.boundary, &w.flow));
  SPH_TEST_OK(w.context, sph_wcsph_set_sound_speed(w.flow, 40));
  flow_steps(&w, 3);
  flow_free(&w);
}

static void settings_refuse(void) {
  flow_world w = tank_open((flow_plan){.c0 = 40});
  sph_context *c = w.context;
  sph_integrator *f = w.flow;
  static const double bad[] = {-1, NAN, INFINITY, -INFINITY};
  const double zero[2] = {0, 0}, nan[2] = {0, NAN}, infinite[2] = {INFINITY, 0};
  for (int k = 0; k < 4; k++) {
    SPH_TEST_STATUS(c, sph_wcsph_set_sound_speed(f, bad[k]), SPH_E_ARGUMENT,
                    "sound speed must be > 0");
    SPH_TEST_STATUS(c, sph_wcsph_set_reference_density(f, bad[k]), SPH_E_ARGUMENT,
                    "must be > 0 kg/m^3");
    SPH_TEST_STATUS(c, sph_wcsph_set_equation_of_state(f, SPH_EOS_TAIT, bad[k]), SPH_E_ARGUMENT,
                    "gamma must be > 0");
    SPH_TEST_STATUS(c, sph_wcsph_set_diffusion(f, SPH_DIFFUSION_DELTA, bad[k]), SPH_E_ARGUMENT,
                    "delta must be 0 to 1");
    SPH_TEST_STATUS(c, sph_wcsph_set_artificial_viscosity(f, bad[k]), SPH_E_ARGUMENT,
                    "alpha must be 0 to 1");
    SPH_TEST_STATUS(c, sph_wcsph_set_laminar_viscosity(f, bad[k]), SPH_E_ARGUMENT,
                    "viscosity must be >= 0");
    SPH_TEST_STATUS(c, sph_wcsph_set_skin(f, bad[k]), SPH_E_ARGUMENT, "skin must be 0.001 to 0.5");
  }
  SPH_TEST_STATUS(c, sph_wcsph_set_sound_speed(f, 0), SPH_E_ARGUMENT, "got 0");
  SPH_TEST_STATUS(c, sph_wcsph_set_reference_density(f, 0), SPH_E_ARGUMENT, "got 0");
  SPH_TEST_STATUS(c, sph_wcsph_set_equation_of_state(f, SPH_EOS_TAIT, 0), SPH_E_ARGUMENT, "got 0");
  SPH_TEST_STATUS(c, sph_wcsph_set_equation_of_state(f, (sph_equation_of_state)3, 7),
                  SPH_E_ARGUMENT, "got 3");
  SPH_TEST_STATUS(c, sph_wcsph_set_equation_of_state(f, (sph_equation_of_state)0, 7),
                  SPH_E_ARGUMENT, "got 0");
  SPH_TEST_STATUS(c, sph_wcsph_set_diffusion(f, (sph_diffusion)3, 0.1), SPH_E_ARGUMENT, "got 3");
  SPH_TEST_STATUS(c, sph_wcsph_set_diffusion(f, (sph_diffusion)-1, 0.1), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(c, sph_wcsph_set_diffusion(f, SPH_DIFFUSION_DELTA, 1.01), SPH_E_ARGUMENT, "1.01");
  SPH_TEST_STATUS(c, sph_wcsph_set_artificial_viscosity(f, 1.01), SPH_E_ARGUMENT, "1.01");
  SPH_TEST_STATUS(c, sph_wcsph_set_skin(f, 0.0009), SPH_E_ARGUMENT, "0.0009");
  SPH_TEST_STATUS(c, sph_wcsph_set_skin(f, 0.51), SPH_E_ARGUMENT, "0.51");
  SPH_TEST_STATUS(c, sph_wcsph_set_gravity(f, NULL), SPH_E_ARGUMENT, "gravity is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_set_gravity(f, nan), SPH_E_ARGUMENT, "gravity must be finite");
  SPH_TEST_STATUS(c, sph_wcsph_set_domain(f, NULL, zero), SPH_E_ARGUMENT, "lo is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_set_domain(f, zero, NULL), SPH_E_ARGUMENT, "hi is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_set_domain(f, zero, zero), SPH_E_ARGUMENT, "lo < hi in direction 0");
  SPH_TEST_STATUS(c, sph_wcsph_set_domain(f, zero, infinite), SPH_E_ARGUMENT,
                  "lo < hi in direction 0");
  SPH_TEST_STATUS(c, sph_wcsph_set_domain(f, nan, infinite), SPH_E_ARGUMENT, "lo < hi");
  SPH_TEST_STATUS(c, sph_wcsph_set_periodic(f, -1, 0, 1), SPH_E_ARGUMENT,
                  "axis must be 0 to 1, got -1");
  SPH_TEST_STATUS(c, sph_wcsph_set_periodic(f, 2, 0, 1), SPH_E_ARGUMENT,
                  "axis must be 0 to 1, got 2");
  SPH_TEST_STATUS(c, sph_wcsph_set_periodic(f, 0, 1, 1), SPH_E_ARGUMENT, "lo < hi");
  SPH_TEST_STATUS(c, sph_wcsph_set_periodic(f, 0, NAN, 1), SPH_E_ARGUMENT, "lo < hi");
  SPH_TEST_STATUS(c, sph_wcsph_set_periodic(f, 0, 0, INFINITY), SPH_E_ARGUMENT, "lo < hi");
  SPH_TEST_OK(c, sph_wcsph_set_skin(f, 0.05));
  const double reach = 2 * w.support * 1.05;
  SPH_TEST_STATUS(c, sph_wcsph_set_periodic(f, 0, 0, 0.999 * reach), SPH_E_ARGUMENT,
                  "shorter than twice the support");
  /* None of it took: the tank goes on as it would without. */
  flow_world untouched = tank_open((flow_plan){.c0 = 40});
  SPH_TEST_OK(untouched.context, sph_wcsph_set_skin(untouched.flow, 0.05));
  flow_steps(&w, 10);
  flow_steps(&untouched, 10);
  double *x = flow_read(&w, SPH_POSITION), *y = flow_read(&untouched, SPH_POSITION);
  CU_ASSERT_EQUAL(memcmp(x, y, 400 * sizeof *x), 0);
  free(x);
  free(y);
  flow_free(&untouched);
  SPH_TEST_OK(c, sph_wcsph_set_periodic(f, 0, -1, -1 + 1.001 * reach));
  SPH_TEST_STATUS(c, sph_wcsph_set_skin(f, 0.2), SPH_E_ARGUMENT, "shorter than twice the support");
  flow_free(&w);
}

static void values_refuse(void) {
  flow_world w = tank_open((flow_plan){.c0 = 40});
  sph_context *c = w.context;
  sph_integrator *f = w.flow;
  const sph_index n = sph_particles_count(w.water);
  double *p = flow_room(n), *density = flow_room(n), *before = flow_read(&w, SPH_DENSITY);
  SPH_TEST_STATUS(c, sph_wcsph_density_of_pressure(f, n, NULL, density), SPH_E_ARGUMENT,
                  "pressure is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_density_of_pressure(f, n, p, NULL), SPH_E_ARGUMENT,
                  "density is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_density_of_pressure(f, -1, p, density), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(c, sph_wcsph_start_from_pressure(f, n, NULL), SPH_E_ARGUMENT, "pressure is NULL");
  SPH_TEST_STATUS(c, sph_wcsph_start_from_pressure(f, n - 1, p), SPH_E_ARGUMENT,
                  "for 200 particles");
  static const double bad[] = {NAN, INFINITY, -1.7e6};
  for (int k = 0; k < 3; k++) {
    p[7] = bad[k];
    density[3] = -5;
    SPH_TEST_STATUS(c, sph_wcsph_density_of_pressure(f, n, p, density), SPH_E_ARGUMENT,
                    "(entry 7)");
    CU_ASSERT_EQUAL(density[3], -5);
    SPH_TEST_STATUS(c, sph_wcsph_start_from_pressure(f, n, p), SPH_E_ARGUMENT, "(entry 7)");
  }
  double *after = flow_read(&w, SPH_DENSITY);
  CU_ASSERT_EQUAL(memcmp(before, after, (size_t)n * sizeof *before), 0);
  SPH_TEST_STATUS(c, sph_wcsph_get_energy(f, NULL), SPH_E_ARGUMENT, "energy is NULL");
  free(p);
  free(density);
  free(before);
  free(after);
  flow_free(&w);
}

static void sound_speed_is_needed(void) {
  flow_world w = tank_open((flow_plan){.c0 = 0});
  sph_context *c = w.context;
  double p = 0, density = 0;
  sph_energy e;
  CU_ASSERT_EQUAL(sph_integrator_stable_dt(w.flow), 0);
  SPH_TEST_STATUS(c, sph_integrator_step(w.flow), SPH_E_ARGUMENT, "call sph_wcsph_set_sound_speed");
  SPH_TEST_STATUS(c, sph_integrator_advance(w.flow, 1), SPH_E_ARGUMENT, "sound speed is not set");
  SPH_TEST_STATUS(c, sph_wcsph_get_energy(w.flow, &e), SPH_E_ARGUMENT, "sound speed is not set");
  SPH_TEST_STATUS(c, sph_wcsph_density_of_pressure(w.flow, 1, &p, &density), SPH_E_ARGUMENT,
                  "sound speed is not set");
  double *many = flow_room(200);
  SPH_TEST_STATUS(c, sph_wcsph_start_from_pressure(w.flow, 200, many), SPH_E_ARGUMENT,
                  "sound speed is not set");
  free(many);
  CU_ASSERT_EQUAL(sph_integrator_steps(w.flow), 0);
  CU_ASSERT_EQUAL(sph_integrator_time(w.flow), 0);
  SPH_TEST_OK(c, sph_wcsph_set_sound_speed(w.flow, 40));
  flow_steps(&w, 2);
  flow_free(&w);
}

/* Every function of this method on NULL and on an integrator of another method. */
static void no_destroy(sph_integrator *flow) { (void)flow; }
static double any_courant(const sph_integrator *flow, sph_stepper stepper) {
  (void)flow;
  (void)stepper;
  return 1;
}
static double any_dt(const sph_integrator *flow, double courant) {
  (void)flow;
  return courant;
}

static void all_setters(sph_integrator *f, sph_status expected) {
  const double zero[2] = {0, 0}, one[2] = {1, 1};
  double value[2] = {0, 0};
  sph_energy e;
  CU_ASSERT_EQUAL(sph_wcsph_set_sound_speed(f, 30), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_reference_density(f, 1000), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_equation_of_state(f, SPH_EOS_TAIT, 7), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_gravity(f, zero), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_body_force(f, NULL, NULL), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_diffusion(f, SPH_DIFFUSION_DELTA, 0.1), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_artificial_viscosity(f, 0.1), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_laminar_viscosity(f, 0.1), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_periodic(f, 0, 0, 10), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_domain(f, zero, one), expected);
  CU_ASSERT_EQUAL(sph_wcsph_set_skin(f, 0.1), expected);
  CU_ASSERT_EQUAL(sph_wcsph_density_of_pressure(f, 1, zero, value), expected);
  CU_ASSERT_EQUAL(sph_wcsph_start_from_pressure(f, 1, zero), expected);
  CU_ASSERT_EQUAL(sph_wcsph_get_energy(f, &e), expected);
}

static void other_methods_are_refused(void) {
  static const sphi_method other = {
      .name = "other", .stable_courant = any_courant, .stable_dt = any_dt, .destroy = no_destroy};
  flow_world w = tank_open((flow_plan){.c0 = 40});
  sph_integrator *flow = NULL;
  SPH_TEST_OK(w.context, sphi_integrator_create(w.context, &other, w.water, w.kernel, &flow));
  all_setters(NULL, SPH_E_ARGUMENT);
  all_setters(flow, SPH_E_TYPE);
  CU_ASSERT(strstr(sph_context_message(w.context), "the integrator is \"other\"") != NULL);
  sph_integrator_destroy(&flow);
  flow_free(&w);
}

static void fluid_inside_a_wall(void) {
  flow_world w = tank_open((flow_plan){.c0 = 40});
  double *x = flow_read(&w, SPH_POSITION);
  const double keep = x[2 * 137];
  x[2 * 137] = -0.01;
  flow_write(&w, SPH_POSITION, x);
  SPH_TEST_STATUS(w.context, sph_integrator_step(w.flow), SPH_E_ARGUMENT,
                  "particle 137 at (-0.01,");
  CU_ASSERT(strstr(sph_context_message(w.context), "lies 0.01 m inside wall \"wall\"") != NULL);
  CU_ASSERT_EQUAL(sph_integrator_steps(w.flow), 0);
  double *y = flow_read(&w, SPH_POSITION);
  CU_ASSERT_EQUAL(memcmp(x, y, 400 * sizeof *x), 0);
  x[2 * 137] = keep; /* corrected, the flow goes on */
  flow_write(&w, SPH_POSITION, x);
  flow_steps(&w, 3);
  free(x);
  free(y);
  flow_free(&w);
}

static void shifted(double t, double *displacement, double *velocity, double *acceleration,
                    void *user) {
  (void)t;
  (void)velocity;
  (void)acceleration;
  displacement[0] = *(const double *)user;
}

/* A wall that its motion puts elsewhere from the start is looked for there. */
static void moved_walls_are_checked_where_they_are(void) {
  double shift = 5;
  flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 40});
  double lo[2] = {5, 0}, hi[2] = {6, 0.5};
  const double wall_lo[2] = {0, 0}, wall_hi[2] = {1, 1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context,
              sph_wall_create_box(w.context, 2, wall_lo, wall_hi, SPH_SIDE_HI(1), &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, shifted, &shift));
  flow_build(&w);
  flow_steps(&w, 3);
  sph_boundary_counts counts;
  SPH_TEST_OK(w.context, sph_boundary_get_counts(w.boundary, &counts));
  CU_ASSERT(counts.active > 50);
  flow_free(&w);
  for (int k = 0; k < 2; k++) { /* a column that such a wall would cut */
    w = flow_open((flow_plan){.dx = 0.05, .c0 = 40});
    lo[0] = k == 0 ? 0 : 4.5;
    hi[0] = lo[0] + 1;
    SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
    SPH_TEST_OK(w.context,
                sph_wall_create_box(w.context, 2, wall_lo, wall_hi, SPH_SIDE_HI(1), &w.wall));
    SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, shifted, &shift));
    flow_build(&w);
    if (k == 0)
      flow_steps(&w, 1); /* where the wall was drawn is no wall */
    else
      SPH_TEST_STATUS(w.context, sph_integrator_step(w.flow), SPH_E_ARGUMENT, "inside wall");
    flow_free(&w);
  }
}

static void open_ends_under_water(void) {
  for (int side = 0; side < 2; side++) {
    flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 40});
    const double lo[2] = {0, 0}, hi[2] = {1, 0.5};
    const double low = 0.4, high = 1;
    const double line[] = {0, side ? high : low, 0, 0, 1, 0, 1, side ? low : high};
    SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
    SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, line, false, &w.wall));
    SPH_TEST_OK(w.context, sph_wall_set_name(w.wall, "basin"));
    flow_build(&w);
    SPH_TEST_STATUS(w.context, sph_integrator_step(w.flow), SPH_E_ARGUMENT,
                    side ? "wall \"basin\" ends openly at (1, 0.4) m"
                         : "wall \"basin\" ends openly at (0, 0.4) m");
    CU_ASSERT(strstr(sph_context_message(w.context), "extend the wall") != NULL);
    CU_ASSERT_EQUAL(sph_integrator_steps(w.flow), 0);
    flow_free(&w);
  }
}

/* A floor that ends where a periodic box does goes on in the next period. */
static void periodic_floor_has_no_ends(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 40, .precision = SPH_PRECISION_DOUBLE});
  const double lo[2] = {0, 0}, hi[2] = {1, 0.5}, floor_line[] = {0, 0, 1, 0};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 2, floor_line, false, &w.wall));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, 0, 0, 1));
  const double slope[2] = {0, -rho0 * g};
  flow_linear_pressure(&w, rho0 * g * 0.5, slope);
  double *v = flow_room(400);
  for (int k = 0; k < 200; k++) v[2 * k] = 1.5;
  flow_write(&w, SPH_VELOCITY, v);
  double *before = flow_read(&w, SPH_POSITION);
  SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 1));
  double *after = flow_read(&w, SPH_POSITION), *u = flow_read(&w, SPH_VELOCITY);
  double worst = 0, slower = 0;
  for (int k = 0; k < 200; k++) {
    worst = fmax(worst, fabs(after[2 * k + 1] - before[2 * k + 1])); /* rows stay rows */
    slower = fmax(slower, fabs(u[2 * k] - 1.5));
  }
  SPH_TEST_BELOW(worst, 0.1 * w.dx);
  SPH_TEST_BELOW(slower, 1e-3);
  free(v);
  free(u);
  free(before);
  free(after);
  flow_free(&w);
}

typedef struct poison {
  double time, x, y, value;
} poison;

/* Not finite for the one particle near (x, y) from a time on; nothing before. */
static void poisoned(double t, const double *x, double *force, void *user) {
  const poison *p = user;
  if (t >= p->time && fabs(x[0] - p->x) < 0.02 && fabs(x[1] - p->y) < 0.02) force[1] = p->value;
}

static void check_stopped(const flow_world *w, int64_t id, const char *quantity) {
  const char *message = sph_context_message(w->context);
  char name[64];
  snprintf(name, sizeof name, "particles \"water\": particle %lld at (", (long long)id);
  if (!strstr(message, name) || !strstr(message, quantity))
    printf("\n%s, not %s %s", message, name, quantity);
  CU_ASSERT(strstr(message, name) != NULL);
  CU_ASSERT(strstr(message, ") m, time ") != NULL);
  CU_ASSERT(strstr(message, quantity) != NULL);
  /* Everything can still be read. */
  double *x = flow_read(w, SPH_POSITION), *v = flow_read(w, SPH_VELOCITY),
         *rho = flow_read(w, SPH_DENSITY);
  const sph_index n = sph_particles_count(w->water);
  int bad = 0;
  for (sph_index i = 0; i < n; i++)
    bad += !(isfinite(x[2 * i]) && isfinite(x[2 * i + 1]) && isfinite(v[2 * i]) && rho[i] > 0);
  CU_ASSERT(bad <= 1);
  int64_t *ids = calloc((size_t)(n > 0 ? n : 1), sizeof *ids);
  SPH_TEST_OK(w->context, sph_particles_read_ids(w->water, ids, n));
  for (sph_index i = 0; i < n; i++) CU_ASSERT_EQUAL(ids[i], i);
  sph_integrator_stats stats;
  SPH_TEST_OK(w->context, sph_integrator_get_stats(w->flow, &stats));
  free(x);
  free(v);
  free(rho);
  free(ids);
}

static void poison_is_found(void) {
  static const double values[] = {NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 3; k++) {
    flow_world w = tank_open((flow_plan){.c0 = 40});
    poison p = {.time = 0.01, .x = 0.625, .y = 0.225, .value = values[k]};
    SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[k]));
    SPH_TEST_OK(w.context, sph_wcsph_set_body_force(w.flow, poisoned, &p));
    CU_ASSERT_EQUAL(sph_integrator_advance(w.flow, 1), SPH_E_DIVERGED);
    check_stopped(&w, 12 * 10 + 4, "not finite"); /* column 12, row 4 of 10 */
    CU_ASSERT(sph_integrator_time(w.flow) > 0.005 && sph_integrator_time(w.flow) < 0.013);
    flow_free(&w);
  }
}

static void too_fast_is_found(void) {
  for (int k = 0; k < 3; k++) {
    flow_world w = tank_open((flow_plan){.c0 = 40});
    SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[k]));
    flow_steps(&w, 5);
    double *v = flow_read(&w, SPH_VELOCITY);
    v[2 * 94 + 1] = 1e4;
    flow_write(&w, SPH_VELOCITY, v);
    CU_ASSERT_EQUAL(sph_integrator_step(w.flow), SPH_E_DIVERGED);
    check_stopped(&w, 94, "moved more than its spacing in one step: |v| dt = ");
    CU_ASSERT_EQUAL(sph_integrator_steps(w.flow), 5);
    free(v);
    flow_free(&w);
  }
}

static void leaving_is_found(void) {
  for (int set = 0; set < 2; set++) {
    flow_world w = tank_open((flow_plan){.c0 = 40});
    const double lo[2] = {-0.5, -0.5}, hi[2] = {1.5, 0.9};
    if (set) SPH_TEST_OK(w.context, sph_wcsph_set_domain(w.flow, lo, hi));
    double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
    x[2 * 55 + 1] = 0.8; /* thrown up */
    v[2 * 55 + 1] = 10;
    flow_write(&w, SPH_POSITION, x);
    flow_write(&w, SPH_VELOCITY, v);
    CU_ASSERT_EQUAL(sph_integrator_advance(w.flow, 1), SPH_E_DIVERGED);
    check_stopped(&w, 55, "left the domain: distance = ");
    free(x);
    x = flow_read(&w, SPH_POSITION);
    /* Until set: the box of walls, ghosts and particles, larger by its size on every side. */
    const double y = x[2 * 55 + 1];
    CU_ASSERT(set ? y > 0.9 && y < 0.96 : y > 2 && y < 2.5);
    free(x);
    free(v);
    flow_free(&w);
  }
}

/* Alone and fast, a drop of spray passes what a wall can do against it. */
static void crossing_is_found(void) {
  flow_world w = tank_open((flow_plan){.c0 = 12});
  const double none[2] = {0, 0};
  flow_linear_pressure(&w, 0, none);
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, none));
  SPH_TEST_OK(w.context, sph_wcsph_set_sound_speed(w.flow, 0.5)); /* it is hardly felt */
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_SYMPLECTIC));
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 4e-3));
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  x[2 * 33] = 0.93;
  x[2 * 33 + 1] = 0.8;
  v[2 * 33] = 11;
  flow_write(&w, SPH_POSITION, x);
  flow_write(&w, SPH_VELOCITY, v);
  CU_ASSERT_EQUAL(sph_integrator_advance(w.flow, 0.05), SPH_E_DIVERGED);
  check_stopped(&w, 33, "crossed wall \"wall\" by ");
  free(x);
  free(v);
  flow_free(&w);
}

/* A motion that jumps without a velocity to match leaves particles at rest 0.8 dx inside a wall. */
static void a_wall_that_jumps_over_particles_is_found(void) {
  double shift = 0;
  flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 40});
  const double lo[2] = {0, 0}, hi[2] = {1, 0.5}, top[2] = {1.5, 1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, top, SPH_SIDE_HI(1), &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, shifted, &shift));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-9));
  flow_steps(&w, 2);
  shift = 1.3 * w.dx;
  CU_ASSERT_EQUAL(sph_integrator_step(w.flow), SPH_E_DIVERGED);
  CU_ASSERT(strstr(sph_context_message(w.context), "crossed wall \"wall\" by ") != NULL);
  flow_free(&w);
}

/* Nine particles that fly apart so fast that the middle one's density would turn negative. */
static void negative_density_is_found(void) {
  flow_world w =
      flow_open((flow_plan){.dx = 0.1, .c0 = 20, .kernel = SPH_KERNEL_WENDLAND_C2, .ratio = 1});
  const double lo[2] = {-0.15, -0.15}, hi[2] = {0.15, 0.15};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_SYMPLECTIC));
  const double dt = 0.9 * sph_integrator_stable_dt(w.flow);
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
  double *x = flow_read(&w, SPH_POSITION);
  for (int i = 0; i < 18; i++) x[i] *= 0.65 / dt;
  flow_write(&w, SPH_VELOCITY, x);
  CU_ASSERT_EQUAL(sph_integrator_step(w.flow), SPH_E_DIVERGED);
  CU_ASSERT(strstr(sph_context_message(w.context), "particle 4 at (") != NULL);
  CU_ASSERT(strstr(sph_context_message(w.context), "density that is not positive: rho = -") !=
            NULL);
  free(x);
  flow_free(&w);
}

static void after_a_stop(void) {
  flow_world w = tank_open((flow_plan){.c0 = 40});
  poison p = {.time = 0, .x = 0.625, .y = 0.225, .value = NAN};
  SPH_TEST_OK(w.context, sph_wcsph_set_body_force(w.flow, poisoned, &p));
  CU_ASSERT_EQUAL(sph_integrator_step(w.flow), SPH_E_DIVERGED);
  /* A caller that goes on regardless gets errors, not a crash. */
  for (int k = 0; k < 3; k++) CU_ASSERT_NOT_EQUAL(sph_integrator_step(w.flow), SPH_OK);
  flow_free(&w);
}

SPH_TEST_MAIN("wcsph errors", {"creation errors", creation_errors},
              {"handles of two contexts do not mix", contexts_do_not_mix},
              {"a boundary serves one flow at a time", a_boundary_serves_one_flow},
              {"settings out of range are refused and change nothing", settings_refuse},
              {"values that no density gives are refused", values_refuse},
              {"without a sound speed nothing runs", sound_speed_is_needed},
              {"NULL and other methods are refused", other_methods_are_refused},
              {"a particle inside a wall is named", fluid_inside_a_wall},
              {"walls are checked where their motion puts them",
               moved_walls_are_checked_where_they_are},
              {"walls that end under water are refused", open_ends_under_water},
              {"a periodic floor has no ends", periodic_floor_has_no_ends},
              {"a force that is not finite stops the run", poison_is_found},
              {"a particle faster than a spacing a step stops the run", too_fast_is_found},
              {"a particle that leaves the domain stops the run", leaving_is_found},
              {"a particle that crosses a wall stops the run", crossing_is_found},
              {"a wall that jumps over particles stops the run",
               a_wall_that_jumps_over_particles_is_found},
              {"a negative density stops the run", negative_density_is_found},
              {"stepping on after a stop is refused", after_a_stop})
