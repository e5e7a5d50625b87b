/* A flow with all that it needs, in one struct, for tests of boundaries, methods and integrators. */
#ifndef SPH_FLOW_WORLD_H
#define SPH_FLOW_WORLD_H

#include "sph_test.h"

typedef struct flow_plan {
  int dim;                        /* 0: 2 */
  double dx;                      /* spacing */
  sph_kernel_type kernel;         /* 0: Gaussian */
  double ratio;                   /* h / dx; 0: 1.3 */
  double c0;                      /* 0: not set */
  sph_interpolator_type boundary; /* 0: MLS linear */
  sph_precision precision;
  sph_isa isa;
  int threads; /* 0: 1 */
  bool incompressible;
  const sph_allocator *allocator;
} flow_plan;

typedef struct flow_world {
  flow_plan plan;
  int dim;
  double dx, h, support;
  sph_context *context;
  sph_kernel *kernel;
  sph_interpolator *interpolator;
  sph_wall *wall; /* NULL: no walls */
  sph_boundary *boundary;
  sph_particles *water;
  sph_integrator *flow;
} flow_world;

/* Context, kernel, interpolator and an empty particle set. The caller then fills the set, makes a
 * wall if there is to be one, and calls flow_build. */
static inline flow_world flow_open(flow_plan plan) {
  if (!plan.dim) plan.dim = 2;
  if (!plan.kernel) plan.kernel = SPH_KERNEL_GAUSSIAN;
  if (plan.ratio == 0) plan.ratio = 1.3;
  if (!plan.boundary) plan.boundary = SPH_INTERPOLATOR_MLS_LINEAR;
  if (!plan.threads) plan.threads = 1;
#ifndef _OPENMP
  plan.threads = 1;
#endif
  flow_world w = {.plan = plan, .dim = plan.dim, .dx = plan.dx, .h = plan.ratio * plan.dx};
  CU_ASSERT_FATAL(sph_context_create_with_allocator(plan.allocator, &w.context) == SPH_OK);
  SPH_TEST_OK(w.context, sph_context_set_precision(w.context, plan.precision));
  SPH_TEST_OK(w.context, sph_context_set_isa(w.context, plan.isa));
  SPH_TEST_OK(w.context, sph_context_set_threads(w.context, plan.threads));
  SPH_TEST_OK(w.context, sph_kernel_create(w.context, plan.kernel, plan.dim, w.h, &w.kernel));
  w.support = sph_kernel_get_support(w.kernel);
  SPH_TEST_OK(w.context,
              sph_interpolator_create(w.context, plan.boundary, w.kernel, &w.interpolator));
  SPH_TEST_OK(w.context, sph_particles_create(w.context, plan.dim, plan.dx, &w.water));
  SPH_TEST_OK(w.context, sph_particles_set_name(w.water, "water"));
  return w;
}

static inline void flow_build(flow_world *w) {
  if (w->wall)
    SPH_TEST_OK(w->context,
                sph_boundary_create(w->context, w->wall, w->dx, w->interpolator, &w->boundary));
  if (w->plan.incompressible) {
    SPH_TEST_OK(w->context,
                sph_isph_create(w->context, w->kernel, w->water, w->boundary, &w->flow));
    return;
  }
  SPH_TEST_OK(w->context, sph_wcsph_create(w->context, w->kernel, w->water, w->boundary, &w->flow));
  if (w->plan.c0 > 0) SPH_TEST_OK(w->context, sph_wcsph_set_sound_speed(w->flow, w->plan.c0));
}

static inline void flow_free(flow_world *w) {
  sph_integrator_destroy(&w->flow);
  sph_boundary_destroy(&w->boundary);
  sph_wall_destroy(&w->wall);
  sph_interpolator_destroy(&w->interpolator);
  sph_particles_destroy(&w->water);
  sph_kernel_destroy(&w->kernel);
  sph_context_destroy(&w->context);
}

static inline double *flow_room(int64_t count) {
  double *room = calloc((size_t)count + 1, sizeof *room);
  CU_ASSERT_FATAL(room != NULL);
  return room;
}

/* A field in id order, to be freed by the caller. */
static inline double *flow_read(const flow_world *w, const char *field) {
  int components = 0;
  SPH_TEST_OK(w->context, sph_particles_field_components(w->water, field, &components));
  const int64_t size = (int64_t)sph_particles_count(w->water) * components;
  double *values = flow_room(size);
  SPH_TEST_OK(w->context, sph_particles_read(w->water, field, values, size));
  return values;
}

static inline void flow_write(const flow_world *w, const char *field, const double *values) {
  int components = 0;
  SPH_TEST_OK(w->context, sph_particles_field_components(w->water, field, &components));
  SPH_TEST_OK(w->context, sph_particles_write(w->water, field, values,
                                              (int64_t)sph_particles_count(w->water) * components));
}

/* Moves every particle by up to `amount` spacings in each direction. */
static inline void flow_jitter(const flow_world *w, double amount, uint64_t seed) {
  double *x = flow_read(w, SPH_POSITION);
  for (int64_t k = 0; k < (int64_t)sph_particles_count(w->water) * w->dim; k++)
    x[k] += amount * w->dx * (2 * sph_test_random(&seed) - 1);
  flow_write(w, SPH_POSITION, x);
  free(x);
}

/* Random velocities of up to `speed` in each direction. */
static inline void flow_stir(const flow_world *w, double speed, uint64_t seed) {
  double *v = flow_read(w, SPH_VELOCITY);
  for (int64_t k = 0; k < (int64_t)sph_particles_count(w->water) * w->dim; k++)
    v[k] = speed * (2 * sph_test_random(&seed) - 1);
  flow_write(w, SPH_VELOCITY, v);
  free(v);
}

/* Starts from the pressure constant + slope . x. */
static inline void flow_linear_pressure(const flow_world *w, double constant, const double *slope) {
  const sph_index n = sph_particles_count(w->water);
  double *x = flow_read(w, SPH_POSITION), *p = flow_room(n);
  for (sph_index k = 0; k < n; k++) {
    p[k] = constant;
    for (int d = 0; d < w->dim; d++) p[k] += slope[d] * x[w->dim * k + d];
  }
  SPH_TEST_OK(w->context, sph_wcsph_start_from_pressure(w->flow, n, p));
  free(x);
  free(p);
}

static inline void flow_steps(const flow_world *w, int steps) {
  for (int k = 0; k < steps; k++) SPH_TEST_OK(w->context, sph_integrator_step(w->flow));
}

/* Evaluates everything for the state now without changing it: a step too short to be felt. */
static inline void flow_evaluate(const flow_world *w) {
  SPH_TEST_OK(w->context, sph_integrator_set_dt(w->flow, 1e-25));
  SPH_TEST_OK(w->context, sph_integrator_step(w->flow));
  SPH_TEST_OK(w->context, sph_integrator_set_dt(w->flow, 0));
}

/* Motion of a wall along x with the constant acceleration *user from t = 0. */
static inline void flow_accelerate(double t, double *displacement, double *velocity,
                                   double *acceleration, void *user) {
  const double a = *(const double *)user;
  displacement[0] = 0.5 * a * t * t;
  velocity[0] = a * t;
  acceleration[0] = a;
}

static inline double flow_largest(int64_t count, const double *a) {
  double most = 0;
  for (int64_t k = 0; k < count; k++) {
    if (!(fabs(a[k]) < HUGE_VAL)) return NAN;
    most = fmax(most, fabs(a[k]));
  }
  return most;
}

static inline double flow_difference(int64_t count, const double *a, const double *b) {
  double most = 0;
  for (int64_t k = 0; k < count; k++) {
    if (!(fabs(a[k] - b[k]) < HUGE_VAL)) return NAN;
    most = fmax(most, fabs(a[k] - b[k]));
  }
  return most;
}

#endif
