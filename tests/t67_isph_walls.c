/* Walls of incompressible SPH: fixed ghosts, dummy particles, and those as printed. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81;
static const sph_isph_walls kinds[] = {SPH_ISPH_WALLS_GHOSTS, SPH_ISPH_WALLS_DUMMIES,
                                       SPH_ISPH_WALLS_DUMMIES_AS_PRINTED};

/* Water of L = 4 H on a lattice, in 3D 2 H wide, in an open tank, or to the lid of a closed one. */
static flow_world tank(flow_plan plan, double height, bool lid, sph_isph_walls walls) {
  plan.incompressible = true;
  plan.kernel = SPH_KERNEL_WENDLAND_C2;
  plan.ratio = 1.5;
  flow_world w = flow_open(plan);
  const double lo[3] = {0, 0, 0};
  const double water[3] = {4 * height, w.dim == 2 ? height : 2 * height, height};
  double top[3] = {water[0], water[1], water[2]};
  if (!lid) top[w.dim - 1] *= 3;
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, water, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, w.dim, lo, top,
                                             lid ? 0 : 1u << (2 * w.dim - 1), &w.wall));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_isph_set_walls(w.flow, walls));
  return w;
}

/* The largest error of pressures over rho g H, from those of still water. */
static double pressure_error(const flow_world *w, double height) {
  double *x = flow_read(w, SPH_POSITION), *p = flow_read(w, SPH_PRESSURE), most = 0;
  const int64_t n = (int64_t)sph_particles_count(w->water);
  for (int64_t k = 0; k < n; k++)
    most = fmax(most, fabs(p[k] / (rho0 * g * height) - 1 + x[w->dim * (k + 1) - 1] / height));
  free(x);
  free(p);
  return most;
}

static double bottom_force(const flow_world *w, double height) {
  double force[3];
  SPH_TEST_OK(w->context, sph_boundary_read_force(w->boundary, 0, force));
  return -force[w->dim - 1] /
         (rho0 * g * height * (w->dim == 2 ? 4 * height : 8 * height * height));
}

static void still_water_is_exact_with_dummies(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (int k = 0; k < 2; k++) {
      const double height = dim == 2 ? 0.2 : 0.08;
      flow_world w = tank(
          (flow_plan){
              .dim = dim, .dx = 0.01, .precision = k ? SPH_PRECISION_SINGLE : SPH_PRECISION_DOUBLE},
          height, false, SPH_ISPH_WALLS_DUMMIES);
      flow_steps(&w, 20);
      SPH_TEST_BELOW(pressure_error(&w, height), 1e-4);
      SPH_TEST_CLOSE(bottom_force(&w, height), 1, 1e-3, 0);
      flow_free(&w);
    }
}

/* The layer that knows no gravity is missing in the pressure. */
static void still_water_is_too_light_as_printed(void) {
  const double height = 0.25;
  flow_world w = tank((flow_plan){.dx = 0.01, .precision = SPH_PRECISION_DOUBLE}, height, false,
                      SPH_ISPH_WALLS_DUMMIES_AS_PRINTED);
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-4));
  flow_steps(&w, 1);
  SPH_TEST_CLOSE(bottom_force(&w, height), 0.94, 0, 0.02);
  flow_free(&w);
}

/* Full to the lid, so that pressures are exact up to a constant: p = -rho (a x + g z). */
static void a_closed_tank_may_accelerate(void) {
  double a = 3;
  for (int dim = 2; dim <= 3; dim++) {
    const double height = dim == 2 ? 0.2 : 0.08;
    flow_world w = tank((flow_plan){.dim = dim, .dx = 0.01, .precision = SPH_PRECISION_DOUBLE},
                        height, true, SPH_ISPH_WALLS_DUMMIES);
    SPH_TEST_OK(w.context, sph_isph_set_surface_threshold(w.flow, 0));
    SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, flow_accelerate, &a));
    SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 1e-3));
    flow_steps(&w, 5);
    double *x = flow_read(&w, SPH_POSITION), *p = flow_read(&w, SPH_PRESSURE), most = 0, mean = 0;
    const int64_t n = (int64_t)sph_particles_count(w.water);
    for (int64_t k = 0; k < n; k++) {
      p[k] += rho0 * (a * x[dim * k] + g * x[dim * (k + 1) - 1]);
      mean += p[k] / (double)n;
    }
    for (int64_t k = 0; k < n; k++) most = fmax(most, fabs(p[k] - mean));
    SPH_TEST_BELOW(most, 1e-4 * rho0 * g * 4 * height);
    free(x);
    free(p);
    flow_free(&w);
  }
}

static void one_and_two_threads_give_the_same_bits(void) {
  for (int kind = 1; kind < 3; kind++) {
    double *x[2];
    int64_t n = 0;
    for (int k = 0; k < 2; k++) {
      flow_world w = tank((flow_plan){.dx = 0.015, .threads = 1 + k}, 0.3, false, kinds[kind]);
      flow_jitter(&w, 0.1, 5);
      flow_steps(&w, 20);
      x[k] = flow_read(&w, SPH_POSITION);
      n = (int64_t)sph_particles_count(w.water) * 2;
      flow_free(&w);
    }
    CU_ASSERT(memcmp(x[0], x[1], (size_t)n * sizeof *x[0]) == 0);
    free(x[0]);
    free(x[1]);
  }
}

/* From step to step, each takes over from the other and water stays where it is. */
static void walls_may_be_chosen_between_steps(void) {
  flow_world w = tank((flow_plan){.dx = 0.01}, 0.2, false, SPH_ISPH_WALLS_DUMMIES);
  for (int k = 0; k < 6; k++) {
    SPH_TEST_OK(w.context, sph_isph_set_walls(w.flow, kinds[k % 2]));
    flow_steps(&w, 5);
    SPH_TEST_BELOW(pressure_error(&w, 0.2), 1e-3);
  }
  SPH_TEST_STATUS(w.context, sph_isph_set_walls(w.flow, (sph_isph_walls)0), SPH_E_ARGUMENT,
                  "one of sph_isph_walls, got 0");
  SPH_TEST_STATUS(w.context, sph_isph_set_walls(w.flow, (sph_isph_walls)4), SPH_E_ARGUMENT,
                  "got 4");
  CU_ASSERT(sph_isph_set_walls(NULL, SPH_ISPH_WALLS_GHOSTS) == SPH_E_ARGUMENT);
  flow_free(&w);
}

/* Whichever block of memory is missing, the status says so and nothing leaks. */
static void any_allocation_may_fail(void) {
  for (int allowed = 20; allowed < 400; allowed += 7) {
    sph_test_memory memory = {1 << 30, 0};
    const sph_allocator allocator = {sph_test_allocate, sph_test_release, &memory};
    flow_world w =
        tank((flow_plan){.dx = 0.05, .allocator = &allocator}, 0.3, false, SPH_ISPH_WALLS_DUMMIES);
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

SPH_TEST_MAIN("walls of incompressible SPH",
              {"still water is exact with dummies", still_water_is_exact_with_dummies},
              {"still water is too light as printed", still_water_is_too_light_as_printed},
              {"a closed tank may accelerate", a_closed_tank_may_accelerate},
              {"one and two threads give the same bits", one_and_two_threads_give_the_same_bits},
              {"walls may be chosen between steps", walls_may_be_chosen_between_steps},
              {"any allocation may fail", any_allocation_may_fail})
