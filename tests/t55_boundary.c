/* Walls of fixed ghost particles: the mirror laws on fields for which they are exact, moving walls,
 * forces, counters, errors. Values are those of a step too short to change anything. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81;

/* Prescribed translation with constant acceleration; at time 0 it has velocity and no displacement. */
typedef struct ride {
  double velocity[3], acceleration[3];
} ride;

static void ride_motion(double t, double *displacement, double *velocity, double *acceleration,
                        void *user) {
  const ride *r = user;
  for (int d = 0; d < 3; d++) {
    const double v = r->velocity[d], a = r->acceleration[d];
    if (v == 0 && a == 0) continue;
    displacement[d] = v * t + 0.5 * a * t * t;
    velocity[d] = v + a * t;
    acceleration[d] = a;
  }
}

/* All values of the ghosts, by number of the ghost. */
typedef struct ghosts {
  int64_t n;
  double *x, *mirror, *foot, *normal, *v, *p, *volume, *rung;
} ghosts;

static double *ghost_values(const flow_world *w, sph_ghost_value what, int components) {
  const int64_t size = sph_boundary_count(w->boundary) * components;
  double *values = flow_room(size);
  SPH_TEST_OK(w->context, sph_boundary_read(w->boundary, what, values, size));
  return values;
}

static ghosts ghosts_read(const flow_world *w) {
  return (ghosts){.n = sph_boundary_count(w->boundary),
                  .x = ghost_values(w, SPH_GHOST_POSITION, w->dim),
                  .mirror = ghost_values(w, SPH_GHOST_MIRROR, w->dim),
                  .foot = ghost_values(w, SPH_GHOST_FOOT, w->dim),
                  .normal = ghost_values(w, SPH_GHOST_NORMAL, w->dim),
                  .v = ghost_values(w, SPH_GHOST_VELOCITY, w->dim),
                  .p = ghost_values(w, SPH_GHOST_PRESSURE, 1),
                  .volume = ghost_values(w, SPH_GHOST_VOLUME, 1),
                  .rung = ghost_values(w, SPH_GHOST_RUNG, 1)};
}

static void ghosts_free(ghosts *a) {
  double *all[] = {a->x, a->mirror, a->foot, a->normal, a->v, a->p, a->volume, a->rung};
  for (int k = 0; k < 8; k++) free(all[k]);
}

/* In a box a ghost mirrors at a facet exactly if its normal is along an axis. */
static bool on_facet(int dim, const double *normal) {
  double most = 0;
  for (int d = 0; d < dim; d++) most = fmax(most, fabs(normal[d]));
  return most > 1 - 1e-9;
}

/* A tank open above, half full of disordered particles. */
static flow_world tank_open(flow_plan plan, sph_slip slip, const ride *motion) {
  plan.dx = plan.dim == 3 ? 0.1 : 0.05;
  plan.c0 = 40;
  flow_world w = flow_open(plan);
  const double lo[3] = {0, 0, 0}, hi[3] = {1, w.dim == 2 ? 0.5 : 0.8, 0.5};
  const double top[3] = {1, w.dim == 2 ? 1.5 : 0.8, 1.5};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_jitter(&w, 0.15, 7);
  SPH_TEST_OK(w.context,
              sph_wall_create_box(w.context, w.dim, lo, top, SPH_SIDE_HI(w.dim - 1), &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_slip(w.wall, slip));
  if (motion)
    SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, ride_motion, (void *)(uintptr_t)motion));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_boundary_set_thin_threshold(w.boundary, 0));
  SPH_TEST_OK(w.context, sph_boundary_set_no_suction(w.boundary, false));
  return w;
}

enum { KINDS = 9 }; /* all but the caller's */
static const sph_interpolator_type kinds[KINDS] = {
    SPH_INTERPOLATOR_IMPROVED_SHEPARD, SPH_INTERPOLATOR_NORMALIZED,    SPH_INTERPOLATOR_MLS_LINEAR,
    SPH_INTERPOLATOR_CLASSIC_SHEPARD,  SPH_INTERPOLATOR_TUNED_SHEPARD, SPH_INTERPOLATOR_SFDI,
    SPH_INTERPOLATOR_SFDI_PRINTED,     SPH_INTERPOLATOR_MLS_QUADRATIC, SPH_INTERPOLATOR_NEAREST};

/* Velocity of the fluid b + A x with A = 0 for `uniform`. */
static void check_velocity_law(flow_plan plan, sph_slip slip, const ride *motion, bool uniform) {
  static const double b[3] = {1.3, -0.7, 0.4};
  static const double A[3][3] = {{0.9, -1.7, 0.3}, {0.6, 1.1, -0.8}, {-1.2, 0.5, 0.7}};
  flow_world w = tank_open(plan, slip, motion);
  const int dim = w.dim;
  const sph_index n = sph_particles_count(w.water);
  double *x = flow_read(&w, SPH_POSITION), *v = flow_room((int64_t)n * dim);
  for (sph_index i = 0; i < n; i++)
    for (int d = 0; d < dim; d++) {
      v[dim * i + d] = b[d];
      for (int e = 0; e < dim && !uniform; e++) v[dim * i + d] += A[d][e] * x[dim * i + e];
    }
  flow_write(&w, SPH_VELOCITY, v);
  flow_evaluate(&w);
  ghosts all = ghosts_read(&w);
  double worst = 0;
  int64_t facets = 0, corners = 0;
  for (int64_t k = 0; k < all.n; k++) {
    if (all.rung[k] == 0 || (!uniform && all.rung[k] != SPH_INTERPOLATOR_MLS_LINEAR)) continue;
    const double *normal = all.normal + dim * k;
    const bool facet = on_facet(dim, normal);
    facets += facet;
    corners += !facet;
    double u[3], across = 0;
    for (int d = 0; d < dim; d++) {
      u[d] = b[d];
      for (int e = 0; e < dim && !uniform; e++) u[d] += A[d][e] * all.mirror[dim * k + e];
      across += (u[d] - (motion ? motion->velocity[d] : 0)) * normal[d];
    }
    for (int d = 0; d < dim; d++) {
      const double wall = motion ? motion->velocity[d] : 0;
      const double law =
          slip == SPH_NO_SLIP || !facet ? 2 * wall - u[d] : u[d] - 2 * across * normal[d];
      worst = fmax(worst, fabs(all.v[dim * k + d] - law));
    }
  }
  CU_ASSERT(facets > 50 && corners > 10);
  SPH_TEST_BELOW(worst, plan.precision == SPH_PRECISION_DOUBLE ? 1e-11 : 1e-5);
  ghosts_free(&all);
  free(x);
  free(v);
  flow_free(&w);
}

static const ride rides = {{0.8, -0.3, 0.5}, {2.5, -1.5, 0.7}};

static void uniform_velocity_reflects(void) {
  for (int k = 0; k < KINDS; k++)
    for (int moving = 0; moving < 2; moving++)
      for (int dim = 2; dim <= 3; dim++) {
        const flow_plan plan = {
            .dim = dim, .boundary = kinds[k], .precision = SPH_PRECISION_DOUBLE};
        check_velocity_law(plan, SPH_FREE_SLIP, moving ? &rides : NULL, true);
        check_velocity_law(plan, SPH_NO_SLIP, moving ? &rides : NULL, true);
      }
}

static void linear_velocity_reflects(void) {
  for (int precision = 0; precision < 2; precision++)
    for (int dim = 2; dim <= 3; dim++) {
      const flow_plan plan = {.dim = dim, .precision = (sph_precision)precision};
      check_velocity_law(plan, SPH_FREE_SLIP, NULL, false);
      check_velocity_law(plan, SPH_NO_SLIP, &rides, false);
    }
}

static void push_right(double t, const double *x, double *force, void *user) {
  (void)t;
  (void)x;
  force[0] = *(const double *)user;
}

/* Fluid at rest in the frame of the wall: p = constant + rho0 (f - a) . x at fluid and ghosts. */
static void check_pressure_law(flow_plan plan, const ride *motion, double extra) {
  flow_world w = tank_open(plan, SPH_FREE_SLIP, motion);
  const int dim = w.dim;
  double slope[3] = {0, 0, 0};
  slope[dim - 1] = -rho0 * g;
  slope[0] += rho0 * extra;
  for (int d = 0; motion && d < dim; d++) slope[d] -= rho0 * motion->acceleration[d];
  if (extra != 0) SPH_TEST_OK(w.context, sph_wcsph_set_body_force(w.flow, push_right, &extra));
  const double constant = 5000;
  flow_linear_pressure(&w, constant, slope);
  flow_evaluate(&w);
  ghosts all = ghosts_read(&w);
  double worst = 0;
  int64_t active = 0;
  for (int64_t k = 0; k < all.n; k++) {
    if (all.rung[k] == 0) continue;
    double p = constant;
    for (int d = 0; d < dim; d++) p += slope[d] * all.x[dim * k + d];
    worst = fmax(worst, fabs(all.p[k] - p) / constant);
    active++;
  }
  CU_ASSERT(active > 60);
  SPH_TEST_BELOW(worst, plan.precision == SPH_PRECISION_DOUBLE ? 1e-10 : 1e-5);
  ghosts_free(&all);
  flow_free(&w);
}

static void hydrostatic_pressure_is_exact(void) {
  for (int k = 0; k < KINDS; k++)
    for (int precision = 0; precision < 2; precision++)
      for (int dim = 2; dim <= 3; dim++)
        check_pressure_law(
            (flow_plan){.dim = dim, .boundary = kinds[k], .precision = (sph_precision)precision},
            NULL, 0);
}

static void accelerated_tank_is_exact(void) {
  for (int k = 0; k < KINDS; k++)
    for (int precision = 0; precision < 2; precision++)
      for (int dim = 2; dim <= 3; dim++)
        check_pressure_law(
            (flow_plan){.dim = dim, .boundary = kinds[k], .precision = (sph_precision)precision},
            &rides, 1.75);
}

/* sum W V of the fluid at a point */
static double kernel_sum(const flow_world *w, const double *x, const double *volume,
                         const double *at) {
  double sum = 0;
  for (sph_index i = 0; i < sph_particles_count(w->water); i++) {
    double r2 = 0;
    for (int d = 0; d < w->dim; d++) r2 += pow(x[w->dim * i + d] - at[d], 2);
    sum += sph_kernel_w(w->kernel, sqrt(r2)) * volume[i];
  }
  return sum;
}

/* Without compensation: p = I[p] + rho0 f . (x - x_m) with the interpolator's own I. */
static void without_compensation_plain(void) {
  for (int k = 0; k < KINDS; k++) {
    flow_world w = tank_open((flow_plan){.boundary = kinds[k], .precision = SPH_PRECISION_DOUBLE},
                             SPH_FREE_SLIP, NULL);
    SPH_TEST_OK(w.context, sph_interpolator_set_compensation(w.interpolator, false));
    const double slope[2] = {300, -rho0 * g};
    flow_linear_pressure(&w, 5000, slope);
    flow_evaluate(&w);
    ghosts all = ghosts_read(&w);
    double *value = flow_room(all.n);
    int *rung = calloc((size_t)all.n, sizeof *rung);
    const char *const name[] = {SPH_PRESSURE};
    SPH_TEST_OK(w.context, sph_interpolator_evaluate(w.interpolator, w.water, all.n, all.mirror, 1,
                                                     name, value, rung));
    double *x = flow_read(&w, SPH_POSITION), *volume = flow_read(&w, SPH_VOLUME);
    double worst = 0, off = 0;
    for (int64_t j = 0; j < all.n; j++) {
      if (all.rung[j] == 0) {
        CU_ASSERT(rung[j] == 0 || kernel_sum(&w, x, volume, all.x + 2 * j) == 0);
        continue;
      }
      CU_ASSERT_EQUAL((int)all.rung[j], rung[j]);
      const double p = value[j] - rho0 * g * (all.x[2 * j + 1] - all.mirror[2 * j + 1]);
      worst = fmax(worst, fabs(all.p[j] - p) / 5000);
      off =
          fmax(off, fabs(p - 5000 - slope[0] * all.x[2 * j] - slope[1] * all.x[2 * j + 1]) / 5000);
    }
    SPH_TEST_BELOW(worst, 1e-11);
    CU_ASSERT(off > 1e-3); /* this field is not exact then: the option has an effect */
    free(x);
    free(volume);
    free(value);
    free(rung);
    ghosts_free(&all);
    flow_free(&w);
  }
}

static void geometry_mirrors(void) {
  for (int dim = 2; dim <= 3; dim++) {
    flow_world w = tank_open((flow_plan){.dim = dim}, SPH_FREE_SLIP, NULL);
    ghosts all = ghosts_read(&w);
    double worst = 0, deepest = 0;
    for (int64_t k = 0; k < all.n; k++) {
      double depth = 0, along = 0;
      for (int d = 0; d < dim; d++) {
        const double *x = all.x + dim * k, *foot = all.foot + dim * k,
                     *mirror = all.mirror + dim * k;
        worst = fmax(worst, fabs(x[d] + mirror[d] - 2 * foot[d]));
        depth += (x[d] - foot[d]) * (x[d] - foot[d]);
        along += (foot[d] - x[d]) * all.normal[dim * k + d];
      }
      worst = fmax(worst, fabs(along - sqrt(depth))); /* the normal points into the fluid */
      if (on_facet(dim, all.normal + dim * k)) deepest = fmax(deepest, sqrt(depth));
    }
    SPH_TEST_BELOW(worst, 1e-13);
    CU_ASSERT(deepest > w.support - 0.51 * w.dx && deepest < w.support + 0.5 * w.dx);
    /* Before the first evaluation nothing acts. */
    CU_ASSERT_EQUAL(flow_largest(all.n, all.p), 0);
    CU_ASSERT_EQUAL(flow_largest(all.n * dim, all.v), 0);
    CU_ASSERT_EQUAL(flow_largest(all.n, all.volume), 0);
    sph_boundary_counts counts;
    SPH_TEST_OK(w.context, sph_boundary_get_counts(w.boundary, &counts));
    CU_ASSERT_EQUAL(counts.ghosts, all.n);
    CU_ASSERT_EQUAL(counts.inactive, all.n);
    CU_ASSERT_EQUAL(counts.active, 0);
    double force[3] = {1, 1, 1};
    SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
    CU_ASSERT_EQUAL(flow_largest(dim, force), 0);
    ghosts_free(&all);
    flow_free(&w);
  }
}

static void counters_add_up(void) {
  for (int k = 0; k < KINDS; k++) {
    flow_world w = tank_open((flow_plan){.boundary = kinds[k], .precision = SPH_PRECISION_DOUBLE},
                             SPH_FREE_SLIP, NULL);
    const double threshold = 0.3;
    SPH_TEST_OK(w.context, sph_boundary_set_thin_threshold(w.boundary, threshold));
    flow_stir(&w, 1, 3);
    const double slope[2] = {0, -rho0 * g};
    flow_linear_pressure(&w, 5000, slope);
    flow_evaluate(&w);
    ghosts all = ghosts_read(&w);
    double *x = flow_read(&w, SPH_POSITION), *volume = flow_read(&w, SPH_VOLUME);
    sph_boundary_counts counts;
    SPH_TEST_OK(w.context, sph_boundary_get_counts(w.boundary, &counts));
    int64_t rungs[SPH_BOUNDARY_TYPES] = {0}, thin = 0, active = 0;
    for (int64_t j = 0; j < all.n; j++) {
      rungs[(int)all.rung[j]]++;
      CU_ASSERT_EQUAL(all.volume[j] == 0, all.rung[j] == 0);
      const double sum = kernel_sum(&w, x, volume, all.mirror + 2 * j);
      CU_ASSERT(fabs(sum - threshold) > 1e-9);
      if (all.rung[j] == 0) {
        CU_ASSERT(sum == 0 || kernel_sum(&w, x, volume, all.x + 2 * j) == 0);
      } else {
        SPH_TEST_CLOSE(all.volume[j], w.dx * w.dx, 0.5, 0);
        thin += sum < threshold;
      }
      if (sum < threshold || all.rung[j] == 0) {
        CU_ASSERT_EQUAL(all.p[j], 0);
        CU_ASSERT_EQUAL(all.v[2 * j], 0);
        CU_ASSERT_EQUAL(all.v[2 * j + 1], 0);
      } else {
        CU_ASSERT(all.p[j] > 0);
      }
    }
    CU_ASSERT_EQUAL(counts.ghosts, all.n);
    CU_ASSERT_EQUAL(counts.inactive, rungs[0]);
    CU_ASSERT_EQUAL(counts.active, all.n - counts.inactive);
    for (int type = 0; type < SPH_BOUNDARY_TYPES; type++) {
      CU_ASSERT_EQUAL(counts.by_type[type], rungs[type]);
      if (type > 0) active += rungs[type];
    }
    CU_ASSERT_EQUAL(active, counts.active);
    CU_ASSERT_EQUAL(counts.thin, thin);
    CU_ASSERT(thin > 0 && counts.inactive > 0);
    const int64_t chosen = counts.by_type[kinds[k]];
    CU_ASSERT_EQUAL(counts.fallback, counts.active - chosen);
    CU_ASSERT(chosen > counts.active / 2);
    if (kinds[k] == SPH_INTERPOLATOR_MLS_LINEAR) CU_ASSERT(counts.fallback > 0);
    free(x);
    free(volume);
    ghosts_free(&all);
    flow_free(&w);
  }
}

static void suction_is_optional(void) {
  flow_world w = tank_open((flow_plan){.precision = SPH_PRECISION_DOUBLE}, SPH_FREE_SLIP, NULL);
  const double none[2] = {0, 0};
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, none));
  double push[2];
  const double slope[2] = {400, 0}; /* -200 Pa on the left, 200 Pa on the right */
  for (int on = 0; on < 2; on++) {
    SPH_TEST_OK(w.context, sph_boundary_set_no_suction(w.boundary, on));
    flow_linear_pressure(&w, -200, slope);
    flow_evaluate(&w);
    ghosts all = ghosts_read(&w);
    int64_t low = 0, high = 0, zero = 0;
    for (int64_t k = 0; k < all.n; k++) {
      if (all.rung[k] == 0) continue;
      low += all.p[k] < 0;
      high += all.p[k] > 0;
      zero += all.p[k] == 0;
    }
    CU_ASSERT(high > 20);
    CU_ASSERT(on ? low == 0 && zero > 20 : low > 20);
    double force[2];
    SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
    push[on] = force[0];
    ghosts_free(&all);
  }
  /* The right wall is pushed and, where that is allowed, the left one pulled as much. */
  CU_ASSERT(push[1] > 100);
  SPH_TEST_CLOSE(push[0], 2 * push[1], 0.1, 0);
  flow_free(&w);
}

/* Ghosts, mirror points and feet go with the wall; what is read is that of the last evaluation. */
static void ghosts_move_with_the_wall(void) {
  for (int dim = 2; dim <= 3; dim++) {
    flow_world w = tank_open((flow_plan){.dim = dim}, SPH_FREE_SLIP, &rides);
    SPH_TEST_OK(w.context, sph_boundary_set_thin_threshold(w.boundary, 0.05));
    SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_VERLET));
    ghosts before = ghosts_read(&w);
    const sph_index n = sph_particles_count(w.water);
    double *v = flow_room((int64_t)n * dim);
    for (int64_t k = 0; k < (int64_t)n * dim; k++) v[k] = rides.velocity[k % dim];
    flow_write(&w, SPH_VELOCITY, v);
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.01));
    const double t = sph_integrator_time(w.flow);
    ghosts after = ghosts_read(&w);
    for (int64_t k = 0; k < after.n * dim; k++) {
      const int d = (int)(k % dim);
      const double s = rides.velocity[d] * t + 0.5 * rides.acceleration[d] * t * t;
      const double *const now[] = {after.x, after.mirror, after.foot};
      const double *const then[] = {before.x, before.mirror, before.foot};
      for (int j = 0; j < 3; j++)
        if (!(fabs(now[j][k] - then[j][k] - s) < 1e-14))
          CU_FAIL_FATAL("a ghost did not move along");
    }
    CU_ASSERT_EQUAL(memcmp(after.normal, before.normal, (size_t)(after.n * dim) * sizeof(double)),
                    0);
    ghosts_free(&before);
    ghosts_free(&after);
    free(v);
    flow_free(&w);
  }
}

/* A closed box that falls freely with its fluid, full of it: nothing happens in its frame. */
static void fluid_falls_with_its_box(void) {
  static const ride fall = {{0.3, 0.1, 0}, {0, -9.81, 0}};
  for (int k = 0; k < KINDS; k++) {
    flow_world w = flow_open(
        (flow_plan){.dx = 0.05, .c0 = 40, .boundary = kinds[k], .precision = SPH_PRECISION_DOUBLE});
    const double lo[2] = {0, 0}, hi[2] = {1, 0.6};
    SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
    SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, hi, 0, &w.wall));
    SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, ride_motion, (void *)(uintptr_t)&fall));
    flow_build(&w);
    const sph_index n = sph_particles_count(w.water);
    double *x = flow_read(&w, SPH_POSITION), *v = flow_room(2 * (int64_t)n);
    for (int64_t j = 0; j < 2 * (int64_t)n; j++) v[j] = fall.velocity[j % 2];
    flow_write(&w, SPH_VELOCITY, v);
    SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_RK4));
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.1));
    double *y = flow_read(&w, SPH_POSITION), worst = 0;
    for (int64_t j = 0; j < 2 * (int64_t)n; j++)
      worst = fmax(
          worst, fabs(y[j] - x[j] - 0.1 * fall.velocity[j % 2] - 0.005 * fall.acceleration[j % 2]));
    SPH_TEST_BELOW(worst, 1e-12);
    free(x);
    free(v);
    free(y);
    flow_free(&w);
  }
}

static void tank_forces(void) {
  for (int dim = 2; dim <= 3; dim++) {
    flow_world w =
        tank_open((flow_plan){.dim = dim, .precision = SPH_PRECISION_DOUBLE}, SPH_FREE_SLIP, NULL);
    /* Above the surface the pressure is none. */
    SPH_TEST_OK(w.context, sph_boundary_set_no_suction(w.boundary, true));
    const double depth = 0.5, breadth = dim == 2 ? 1 : 0.8;
    double slope[3] = {0, 0, 0};
    slope[dim - 1] = -rho0 * g;
    flow_linear_pressure(&w, rho0 * g * depth, slope);
    flow_evaluate(&w);
    double force[3];
    SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
    const double weight = rho0 * g * depth * 1 * breadth;
    SPH_TEST_CLOSE(force[dim - 1], -weight, 1e-9, 0); /* sides cancel, the bottom carries all */
    for (int d = 0; d < dim - 1; d++) SPH_TEST_CLOSE(force[d], 0, 0, 1e-9 * weight);
    flow_free(&w);
  }
}

/* Bottom, left and right as walls of their own, and a block in the water. */
static void forces_wall_by_wall(void) {
  for (int k = 0; k < KINDS; k++) {
    flow_world w = flow_open((flow_plan){
        .dx = 0.025, .c0 = 40, .boundary = kinds[k], .precision = SPH_PRECISION_DOUBLE});
    const double depth = 0.5, block = 0.2;
    const double outline[] = {0, 1.5, 0, 0, 1, 0, 1, 1.5};
    const double square[] = {0.4, 0.15, 0.4, 0.35, 0.6, 0.35, 0.6, 0.15};
    const double lo[2] = {0, 0}, hi[2] = {1, depth};
    SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
    double *x = flow_read(&w, SPH_POSITION);
    const sph_index n = sph_particles_count(w.water);
    int64_t *ids = calloc((size_t)n, sizeof *ids), inside = 0;
    SPH_TEST_OK(w.context, sph_particles_read_ids(w.water, ids, n));
    for (sph_index i = 0; i < n; i++)
      if (fabs(x[2 * i] - 0.5) < 0.1 && fabs(x[2 * i + 1] - 0.25) < 0.1) ids[inside++] = ids[i];
    SPH_TEST_OK(w.context, sph_particles_remove(w.water, inside, ids));
    CU_ASSERT_EQUAL(inside, 64);
    SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, outline, false, &w.wall));
    SPH_TEST_OK(w.context,
                sph_boundary_create(w.context, w.wall, w.dx, w.interpolator, &w.boundary));
    sph_wall *obstacle;
    SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, square, true, &obstacle));
    SPH_TEST_OK(w.context, sph_wall_set_name(obstacle, "block"));
    const int64_t count = sph_boundary_count(w.boundary);
    SPH_TEST_OK(w.context, sph_boundary_add_wall(w.boundary, obstacle));
    CU_ASSERT(sph_boundary_count(w.boundary) > count);
    sph_wall_destroy(&obstacle);
    SPH_TEST_OK(w.context, sph_boundary_set_no_suction(w.boundary, true));
    SPH_TEST_OK(w.context, sph_boundary_set_thin_threshold(w.boundary, 0));
    SPH_TEST_OK(w.context, sph_wcsph_create(w.context, w.kernel, w.water, w.boundary, &w.flow));
    SPH_TEST_OK(w.context, sph_wcsph_set_sound_speed(w.flow, 40));
    const double slope[2] = {0, -rho0 * g};
    flow_linear_pressure(&w, rho0 * g * depth, slope);
    flow_evaluate(&w);
    double force[2];
    SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
    SPH_TEST_CLOSE(force[1], -rho0 * g * depth, 1e-9, 0);
    SPH_TEST_CLOSE(force[0], 0, 0, 1e-6);
    SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 1, force));
    SPH_TEST_CLOSE(force[1], rho0 * g * block * block, 1e-9, 0); /* Archimedes */
    /* At re-entrant corners one of two facets takes the pressure a spacing away. */
    SPH_TEST_CLOSE(force[0], 0, 0, 1.001 * rho0 * g * w.dx * w.dx);
    SPH_TEST_STATUS(w.context, sph_boundary_read_force(w.boundary, 2, force), SPH_E_ARGUMENT,
                    "0 to 1, got 2");
    free(x);
    free(ids);
    flow_free(&w);
  }
}

/* One vertical wall alone: half rho g H^2. */
static void force_on_a_side(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 40, .precision = SPH_PRECISION_DOUBLE});
  const double lo[2] = {0, 0}, hi[2] = {1, 0.5}, up[] = {0, 1.5, 0, -0.5};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 2, up, false, &w.wall));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_boundary_set_no_suction(w.boundary, true));
  SPH_TEST_OK(w.context, sph_boundary_set_thin_threshold(w.boundary, 0.3));
  const double slope[2] = {0, -rho0 * g};
  flow_linear_pressure(&w, rho0 * g * 0.5, slope);
  flow_evaluate(&w);
  double force[2];
  SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, force));
  /* Below y = 0 there is no fluid; the two rows that still see some carry rho g (H - y) each. */
  ghosts all = ghosts_read(&w);
  double expected = 0, below = 0;
  for (int64_t k = 0; k < all.n; k++) {
    if (all.x[2 * k] < -0.6 * w.dx || all.rung[k] == 0) continue;
    const double y = all.foot[2 * k + 1], p = rho0 * g * (0.5 - y);
    if (y > 0 && y < 0.5) expected -= p * w.dx;
    if (y < 0 && all.p[k] > 0) below -= p * w.dx;
  }
  SPH_TEST_CLOSE(expected, -0.5 * rho0 * g * 0.25, 1e-12, 0);
  SPH_TEST_CLOSE(force[0], expected + below, 1e-9, 0);
  SPH_TEST_CLOSE(force[1], 0, 0, 1e-9);
  ghosts_free(&all);
  flow_free(&w);
}

static void creation_errors(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.05});
  sph_context *c = w.context;
  const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1};
  SPH_TEST_OK(c, sph_wall_create_box(c, 2, lo, hi, 0, &w.wall));
  char place;
  sph_boundary *out = (sph_boundary *)&place;
  CU_ASSERT_EQUAL(sph_boundary_create(NULL, w.wall, 0.05, w.interpolator, &out), SPH_E_ARGUMENT);
  CU_ASSERT_PTR_NULL(out);
  SPH_TEST_STATUS(c, sph_boundary_create(c, NULL, 0.05, w.interpolator, &out), SPH_E_ARGUMENT,
                  "wall is NULL");
  SPH_TEST_STATUS(c, sph_boundary_create(c, w.wall, 0.05, NULL, &out), SPH_E_ARGUMENT,
                  "interpolator is NULL");
  SPH_TEST_STATUS(c, sph_boundary_create(c, w.wall, 0.05, w.interpolator, NULL), SPH_E_ARGUMENT,
                  "out is NULL");
  static const double spacings[] = {0, -0.05, NAN, INFINITY};
  for (int k = 0; k < 4; k++) {
    out = (sph_boundary *)&place;
    SPH_TEST_STATUS(c, sph_boundary_create(c, w.wall, spacings[k], w.interpolator, &out),
                    SPH_E_ARGUMENT, "spacing must be > 0 m, got ");
    CU_ASSERT_PTR_NULL(out);
  }
  SPH_TEST_STATUS(c, sph_boundary_create(c, w.wall, 1e-9, w.interpolator, &out), SPH_E_ARGUMENT,
                  "");
  CU_ASSERT_PTR_NULL(out);
  sph_wall *box;
  SPH_TEST_OK(c, sph_wall_create_box(c, 3, lo, hi, 0, &box));
  SPH_TEST_OK(c, sph_wall_set_name(box, "cube"));
  SPH_TEST_STATUS(c, sph_boundary_create(c, box, 0.05, w.interpolator, &out), SPH_E_ARGUMENT,
                  "wall \"cube\" has dimension 3");
  CU_ASSERT_PTR_NULL(out);
  SPH_TEST_OK(c, sph_boundary_create(c, w.wall, 0.05, w.interpolator, &w.boundary));
  CU_ASSERT_EQUAL(sph_boundary_add_wall(NULL, w.wall), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_boundary_add_wall(w.boundary, NULL), SPH_E_ARGUMENT, "wall is NULL");
  const int64_t count = sph_boundary_count(w.boundary);
  SPH_TEST_STATUS(c, sph_boundary_add_wall(w.boundary, box), SPH_E_ARGUMENT, "\"cube\"");
  CU_ASSERT_EQUAL(sph_boundary_count(w.boundary), count);
  sph_wall_destroy(&box);
  CU_ASSERT_EQUAL(sph_boundary_count(NULL), 0);
  sph_boundary_destroy(NULL);
  flow_free(&w);
}

static void too_many_walls(void) {
  flow_world w = flow_open((flow_plan){.dx = 0.05});
  const double line[] = {0, 0, 0.2, 0};
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 2, line, false, &w.wall));
  SPH_TEST_OK(w.context, sph_boundary_create(w.context, w.wall, w.dx, w.interpolator, &w.boundary));
  for (int k = 1; k < 64; k++) SPH_TEST_OK(w.context, sph_boundary_add_wall(w.boundary, w.wall));
  SPH_TEST_STATUS(w.context, sph_boundary_add_wall(w.boundary, w.wall), SPH_E_ARGUMENT,
                  "at most 64 walls");
  flow_free(&w);
}

static void use_errors(void) {
  flow_world w = tank_open((flow_plan){.dim = 2}, SPH_FREE_SLIP, NULL);
  sph_context *c = w.context;
  CU_ASSERT_EQUAL(sph_boundary_set_no_suction(NULL, true), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_boundary_set_thin_threshold(NULL, 0.1), SPH_E_ARGUMENT);
  static const double thresholds[] = {-0.01, 0.5, NAN, INFINITY};
  for (int k = 0; k < 4; k++)
    SPH_TEST_STATUS(c, sph_boundary_set_thin_threshold(w.boundary, thresholds[k]), SPH_E_ARGUMENT,
                    "thin threshold must be 0 to 0.5, got ");
  sph_boundary_counts counts;
  CU_ASSERT_EQUAL(sph_boundary_get_counts(NULL, &counts), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_boundary_get_counts(w.boundary, NULL), SPH_E_ARGUMENT, "counts is NULL");
  const int64_t n = sph_boundary_count(w.boundary);
  double *room = flow_room(2 * n);
  CU_ASSERT_EQUAL(sph_boundary_read(NULL, SPH_GHOST_PRESSURE, room, n), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_boundary_read(w.boundary, SPH_GHOST_PRESSURE, NULL, n), SPH_E_ARGUMENT,
                  "values is NULL");
  SPH_TEST_STATUS(c, sph_boundary_read(w.boundary, (sph_ghost_value)8, room, n), SPH_E_ARGUMENT,
                  "got 8");
  SPH_TEST_STATUS(c, sph_boundary_read(w.boundary, (sph_ghost_value)-1, room, n), SPH_E_ARGUMENT,
                  "got -1");
  for (int what = SPH_GHOST_POSITION; what <= SPH_GHOST_RUNG; what++) {
    const int64_t right = what <= SPH_GHOST_VELOCITY ? 2 * n : n;
    SPH_TEST_STATUS(c, sph_boundary_read(w.boundary, (sph_ghost_value)what, room, right - 1),
                    SPH_E_ARGUMENT, "size must be");
    SPH_TEST_OK(c, sph_boundary_read(w.boundary, (sph_ghost_value)what, room, right));
  }
  double force[2];
  CU_ASSERT_EQUAL(sph_boundary_read_force(NULL, 0, force), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_boundary_read_force(w.boundary, 0, NULL), SPH_E_ARGUMENT, "force is NULL");
  SPH_TEST_STATUS(c, sph_boundary_read_force(w.boundary, -1, force), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(c, sph_boundary_read_force(w.boundary, 1, force), SPH_E_ARGUMENT, "got 1");
  /* Once a flow has stepped with it, a boundary gets no more walls. */
  flow_evaluate(&w);
  SPH_TEST_STATUS(c, sph_boundary_add_wall(w.boundary, w.wall), SPH_E_ARGUMENT, "comes too late");
  CU_ASSERT_EQUAL(sph_boundary_count(w.boundary), n);
  free(room);
  flow_free(&w);
}

static void bad_motion(double t, double *displacement, double *velocity, double *acceleration,
                       void *user) {
  (void)displacement;
  (void)acceleration;
  if (t > *(const double *)user) velocity[0] = NAN;
}

static void motion_must_be_finite(void) {
  double when = 0.01;
  flow_world w = tank_open((flow_plan){.dim = 2}, SPH_FREE_SLIP, NULL);
  sph_integrator_destroy(&w.flow);
  sph_boundary_destroy(&w.boundary);
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, bad_motion, &when));
  flow_build(&w);
  const double slope[2] = {0, -rho0 * g};
  flow_linear_pressure(&w, rho0 * g * 0.5, slope);
  CU_ASSERT_NOT_EQUAL(sph_integrator_advance(w.flow, 1), SPH_OK);
  CU_ASSERT(strstr(sph_context_message(w.context), "finite") != NULL);
  CU_ASSERT(sph_integrator_time(w.flow) >= 0.005 && sph_integrator_time(w.flow) < 0.05);
  double *x = flow_read(&w, SPH_POSITION);
  CU_ASSERT(flow_largest(2 * (int64_t)sph_particles_count(w.water), x) < 1.2);
  free(x);
  flow_free(&w);
}

SPH_TEST_MAIN("boundary", {"ghosts mirror at the nearest point of the wall", geometry_mirrors},
              {"uniform velocity reflects exactly, free and no slip, moving or not",
               uniform_velocity_reflects},
              {"linear velocity reflects exactly with MLS", linear_velocity_reflects},
              {"hydrostatic pressure continues exactly into the wall",
               hydrostatic_pressure_is_exact},
              {"pressure in an accelerated tank continues exactly", accelerated_tank_is_exact},
              {"without compensation the interpolator alone gives I[p]",
               without_compensation_plain},
              {"counters and thin threshold agree with kernel sums", counters_add_up},
              {"suction can be forbidden", suction_is_optional},
              {"ghosts move with the wall", ghosts_move_with_the_wall},
              {"fluid that falls with its box stays at rest in it", fluid_falls_with_its_box},
              {"a tank carries the weight of its water", tank_forces},
              {"a block feels its buoyancy", forces_wall_by_wall},
              {"a vertical wall feels the pressure of its wet part", force_on_a_side},
              {"creation errors", creation_errors}, {"a boundary holds 64 walls", too_many_walls},
              {"errors of reading and setting", use_errors},
              {"motion that is not finite stops the run", motion_must_be_finite})
