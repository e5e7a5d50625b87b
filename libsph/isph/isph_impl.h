/* Incompressible SPH from the inside. */
#ifndef SPHI_ISPH_IMPL_H
#define SPHI_ISPH_IMPL_H

#include <sph/isph.h>

#include "integrator/integrator_impl.h"
#include "isph/ops.h"
#include "solver/solver_impl.h"

/* Arrays of one of the variant's reals a particle, in storage order, with SPHI_PAD more. */
enum {
  ISPH_DIVERGENCE,
  ISPH_FILLING,
  ISPH_NORMAL,                     /* 3 */
  ISPH_WALLS = ISPH_NORMAL + 3,    /* 3 */
  ISPH_MOMENT = ISPH_WALLS + 3,    /* 6; its inverse once `sphi_isph_prepare_rows` has run */
  ISPH_SHEAR = ISPH_MOMENT + 6,    /* 9 */
  ISPH_COLLISION = ISPH_SHEAR + 9, /* 3 */
  ISPH_AIR = ISPH_COLLISION + 3,   /* 3: what air adds to the pressure gradient, over p_i */
  ISPH_UP = ISPH_AIR + 3,          /* 3: towards the surface, for those near it */
  ISPH_TILT = ISPH_UP + 3,         /* 3 */
  ISPH_PUSH = ISPH_TILT + 3,       /* 3: acceleration by a sum over pairs */
  ISPH_SCALE = ISPH_PUSH + 3,
  ISPH_TRACE,
  ISPH_DEPTH,
  ISPH_SUM,
  ISPH_COUNT,
  ISPH_ARRAYS
};

enum { ISPH_DEPTHS = 65 };

/* Walls of dummy particles. Ghosts are numbered as in the boundary, wet ones by their records. */
typedef struct isph_dummies {
  int32_t n;        /* wall particles that take part: unknowns behind those of the fluid */
  int32_t ghosts;   /* that `owner` knows */
  int32_t *owner;   /* [ghosts] the wall particle that a ghost follows, a ghost, or -1 */
  double *kept;     /* [ghosts] last pressures of wall particles */
  int32_t *unknown; /* [wet] its number, -1 for those that follow */
  int32_t *wet;     /* [n] back */
  int64_t *start;   /* [n + 1] fluid near each */
  int32_t *fluid;
  int64_t *room;  /* [n] where rows start in `column` and `value` */
  int32_t *count; /* [n] their lengths */
  int32_t *column;
  double *value;
  double *p; /* [particles + n] */
  int64_t capacity[11];
} isph_dummies;

typedef struct isph {
  double nu, threshold, theta, shifting, collisions;
  sph_isph_gradient gradient;
  sph_isph_laplacian laplacian;
  sph_isph_walls walls;
  sph_solver *solver;
  double filled;             /* sum of V W over the lattice that particles were laid on */
  double full;               /* sum of the entries of a row there */
  double surface_filling;    /* sum of V W half a spacing below a surface of the lattice */
  double above[ISPH_DEPTHS]; /* that of a fluid at depths 0 to the support, less this one */
  void *array[ISPH_ARRAYS];
  int64_t array_capacity[ISPH_ARRAYS];
  double *between[SPHI_MAX_DIM]; /* [n] velocities before pressure acts */
  int64_t between_capacity[SPHI_MAX_DIM];
  double *open; /* [n] share of a particle that is at the free surface, 0 to 1 */
  int64_t open_capacity;
  int64_t surface_count; /* of those that are open by half and more */
  bool has_surface;
  int64_t *place[2]; /* see op_laplacian */
  int64_t place_capacity[2];
  void *entry[2];
  int64_t entry_capacity[2];
  sphi_ghost_rows rows;
  isph_dummies dummies;
  int64_t *row_start; /* the matrix */
  int32_t *columns;
  double *values, *right;
  int64_t row_capacity, column_capacity, value_capacity, right_capacity;
  int32_t *mark; /* [threads][unknowns] scratch */
  int64_t mark_capacity;
} isph;

static inline isph *isph_of(const sph_integrator *flow) { return flow->data; }

static inline double isph_get(const sph_integrator *flow, int array, int64_t i) {
  const void *at = isph_of(flow)->array[array];
  return flow->variant->is_double ? ((const double *)at)[i] : (double)((const float *)at)[i];
}

static inline void isph_put(const sph_integrator *flow, int array, int64_t i, double value) {
  void *at = isph_of(flow)->array[array];
  if (flow->variant->is_double)
    ((double *)at)[i] = value;
  else
    ((float *)at)[i] = (float)value;
}

/* The packed symmetric matrix of particle i in ISPH_MOMENT, {xx yy xy} or {xx yy zz xy xz yz}, times v. */
static inline void isph_times_moment(const sph_integrator *flow, int64_t i, const double *v,
                                     double *out) {
  static const int at[2][3][3] = {{{0, 2}, {2, 1}}, {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}}};
  const int dim = flow->particles->dim;
  for (int d = 0; d < dim; d++) {
    out[d] = 0;
    for (int e = 0; e < dim; e++)
      out[d] += isph_get(flow, ISPH_MOMENT + at[dim - 2][d][e], i) * v[e];
  }
}

/* Who is at the free surface, from the sums of op_projection. */
void sphi_isph_find_surface(sph_integrator *flow);
/* Records of the fluid as its fields are, with these velocities and `last` in the place of densities. */
void sphi_isph_pack(sph_integrator *flow, double *const *v, const double *last);
sph_status sphi_isph_refresh(sph_integrator *flow);
double sphi_isph_limit(const sph_integrator *flow, sph_limiter *limiter);
sph_status sphi_isph_step(sph_integrator *flow, double dt);
sph_status sphi_isph_keep(sph_integrator *flow, sphi_keep *keep);
/* Entry `at` of the fluid's list (0) or the ghosts' (1). */
static inline double isph_entry(const sph_integrator *flow, int list, int64_t at) {
  const void *entry = isph_of(flow)->entry[list];
  return flow->variant->is_double ? ((const double *)entry)[at]
                                  : (double)((const float *)entry)[at];
}

/* Finds the surface, makes the pressure equation for velocities whose divergence has been summed, and solves
 * it for the particles' pressures and the ghosts'. What does not converge leaves the best there is. */
sph_status sphi_isph_solve(sph_integrator *flow, double dt);

/* Tilt, scale (returned) and divergence of the row of a wall particle from its sums. */
double sphi_isph_tilt(const sph_integrator *flow, const double *moment, const double *normal,
                      const double *shear, double *tilt, double *divergence);
void sphi_isph_dummies_free(sph_context *context, isph_dummies *dummies);
/* Rows of ghosts for those interpolated before: each has the pressure of its wall particle. */
sph_status sphi_isph_dummies_rows(sph_integrator *flow, double t);
/* Velocities of wall and dummy particles, into the ghosts' records. */
void sphi_isph_dummies_velocities(sph_integrator *flow, double t, double dt);
/* The rows of the wall particles, from the fluid's entries of ghosts, and their right-hand sides. */
sph_status sphi_isph_dummies_matrix(sph_integrator *flow, double dt);

#endif
