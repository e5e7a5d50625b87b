/* Walls from the inside: what the boundary needs of them. */
#ifndef SPHI_WALL_IMPL_H
#define SPHI_WALL_IMPL_H

#include <sph/wall.h>

#include "core/keep.h"
#include "sweep/variant.h"

/* Ghost points behind a wall in its reference position (displacement zero), n of them. All vectors
 * [n, dim]. mirror = 2 foot - x but where the foot is an edge with less than 90 degrees of fluid. */
typedef struct sphi_ghost_points {
  int dim;
  int64_t n, capacity;
  double *x, *mirror; /* the ghost, and its image in the fluid */
  double *foot;       /* the nearest point of the wall */
  double *volume;     /* [n] m^dim */
  /* [n] m^(dim-1): the piece of wall surface that the ghost stands for in force sums; 0 but for the
   * first layer on facets. */
  double *area;
  uint8_t *vertex; /* [n] 1 where the foot is an edge or corner: the whole velocity reflects */
  /* Several ghosts fill the same place behind a sharp solid corner, and `gates` planes tell who sees
   * which: fluid at x_f does while a . (x_f - x) + a[dim] > 0 m for each of the ghost's planes a. */
  uint8_t *gates; /* [n] 0 for most, SPHI_GATES(dim) at most */
  int32_t *gated; /* [n] number of those that have gates, of each that has */
  int64_t gated_count, gate_capacity;
  double *gate;    /* [gated_count, SPHI_GATES(dim), dim + 1] */
  int64_t skipped; /* places left out because they or their mirror are on the wrong side */
} sphi_ghost_points;

/* The planes of ghost k, [gates[k], dim + 1]. */
static inline const double *sphi_ghost_gates(const sphi_ghost_points *points, int64_t k) {
  return points->gate + (int64_t)points->gated[k] * SPHI_GATES(points->dim) * (points->dim + 1);
}

/* Unit vector of x - foot of ghost k: out of the fluid. */
static inline void sphi_ghost_normal(const sphi_ghost_points *points, int64_t k, double *normal) {
  const int dim = points->dim;
  double s2 = 0;
  for (int d = 0; d < dim; d++) {
    normal[d] = points->x[dim * k + d] - points->foot[dim * k + d];
    s2 += normal[d] * normal[d];
  }
  for (int d = 0; d < dim; d++) normal[d] /= sqrt(s2);
}

/* Whether fluid at `from_ghost` from ghost k sees it. */
static inline bool sphi_ghost_seen(const sphi_ghost_points *points, int64_t k,
                                   const double *from_ghost) {
  const int dim = points->dim;
  for (int g = 0; g < points->gates[k]; g++) {
    const double *gate = sphi_ghost_gates(points, k) + g * (dim + 1);
    double side = gate[dim];
    for (int d = 0; d < dim; d++) side += gate[d] * from_ghost[d];
    if (!(side > 0)) return false;
  }
  return true;
}

/* Where a wall is and how it moves: turned about the pivot from its reference position, then displaced. */
typedef struct sphi_wall_state {
  double displacement[SPHI_MAX_DIM], velocity[SPHI_MAX_DIM], acceleration[SPHI_MAX_DIM];
  bool turns; /* what follows counts */
  double pivot[SPHI_MAX_DIM];
  double turn[SPHI_MAX_DIM][SPHI_MAX_DIM];
  double spin[3], spin_rate[3]; /* rad/s, rad/s^2 */
} sphi_wall_state;

/* A direction of the reference position as it is now. */
static inline void sphi_wall_turn(const sphi_wall_state *state, int dim, const double *reference,
                                  double *now) {
  for (int d = 0; d < dim; d++) {
    now[d] = state->turns ? 0 : reference[d];
    for (int e = 0; e < dim && state->turns; e++) now[d] += state->turn[d][e] * reference[e];
  }
}

/* A direction of now as it is in the reference position. */
static inline void sphi_wall_turn_back(const sphi_wall_state *state, int dim, const double *now,
                                       double *reference) {
  for (int d = 0; d < dim; d++) {
    reference[d] = state->turns ? 0 : now[d];
    for (int e = 0; e < dim && state->turns; e++) reference[d] += state->turn[e][d] * now[e];
  }
}

/* A point of the reference position as it is now. */
static inline void sphi_wall_place(const sphi_wall_state *state, int dim, const double *reference,
                                   double *now) {
  double arm[SPHI_MAX_DIM];
  for (int d = 0; d < dim; d++) arm[d] = reference[d] - state->pivot[d];
  sphi_wall_turn(state, dim, arm, now);
  for (int d = 0; d < dim; d++) now[d] += state->pivot[d] + state->displacement[d];
}

/* A point of now as it is in the reference position. */
static inline void sphi_wall_refer(const sphi_wall_state *state, int dim, const double *now,
                                   double *reference) {
  double arm[SPHI_MAX_DIM];
  for (int d = 0; d < dim; d++) arm[d] = now[d] - state->pivot[d] - state->displacement[d];
  sphi_wall_turn_back(state, dim, arm, reference);
  for (int d = 0; d < dim; d++) reference[d] += state->pivot[d];
}

/* Velocity of the wall at a point of now, and its acceleration (NULL: not asked for). */
static inline void sphi_wall_velocity_at(const sphi_wall_state *state, int dim, const double *x,
                                         double *velocity, double *acceleration) {
  for (int d = 0; d < dim; d++) {
    velocity[d] = state->velocity[d];
    if (acceleration) acceleration[d] = state->acceleration[d];
  }
  if (!state->turns) return;
  double arm[3] = {0}, round[3];
  for (int d = 0; d < dim; d++) arm[d] = x[d] - state->pivot[d] - state->displacement[d];
  const double *w = state->spin, *rate = state->spin_rate;
  for (int d = 0; d < 3; d++) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    round[d] = w[e] * arm[f] - w[f] * arm[e];
  }
  for (int d = 0; d < dim; d++) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    velocity[d] += round[d];
    if (acceleration)
      acceleration[d] += rate[e] * arm[f] - rate[f] * arm[e] + w[e] * round[f] - w[f] * round[e];
  }
}

void sphi_wall_retain(sph_wall *wall);
int sphi_wall_dim(const sph_wall *wall);
const char *sphi_wall_name(const sph_wall *wall);
bool sphi_wall_no_slip(const sph_wall *wall);
bool sphi_wall_moves(const sph_wall *wall);
/* Appends the ghosts of `wall` in ceil(depth/spacing) layers at spacing/2, 3/2 spacing ... from it;
 * out is zeroed by the caller before its first use and holds ghosts of one dimension. Errors:
 * SPH_E_ARGUMENT spacing or depth not > 0, more than 2^31 - 1 ghosts; SPH_E_MEMORY; out->n is then as
 * before. */
sph_status sphi_wall_make_ghosts(const sph_wall *wall, double spacing, double depth,
                                 sphi_ghost_points *out);
void sphi_ghost_points_free(sph_context *context, sphi_ghost_points *points);
/* Where the wall is at time t. A motion that is not finite is SPH_E_ARGUMENT, and a driven wall has none
 * but within its step. */
sph_status sphi_wall_state_at(const sph_wall *wall, double t, sphi_wall_state *state);
/* Whether a driver moves it; then its motion from t to t + dt under that force. */
bool sphi_wall_is_driven(const sph_wall *wall);
/* See sphi_body_add_mass; a wall without a body has no use for it. */
void sphi_wall_add_mass(sph_wall *wall, double mass);
sph_status sphi_wall_drive(sph_wall *wall, double t, double dt, const double *force);
/* Signed distance [m] to the wall in its reference position: positive in the fluid; by the nearest
 * point of the wall, so far from an open wall's ends the sign means little. */
double sphi_wall_distance(const sph_wall *wall, const double *x);
/* The same within `bound` of the wall, HUGE_VAL beyond, with the nearest point of the wall in foot. */
double sphi_wall_foot(const sph_wall *wall, const double *x, double bound, double *foot);
/* The same of a wall as it is now, foot too; beyond an open end there is no inside. */
double sphi_wall_foot_now(const sph_wall *wall, const sphi_wall_state *state, const double *x,
                          double bound, double *foot);
/* The open ends of a 2D wall in reference position: points [SPHI_WALL_MAX_ENDS, 2]; returns how
 * many: 0, 2, or 4 for a box with two opposite open sides; 0 in 3D. */
#define SPHI_WALL_MAX_ENDS 4
int sphi_wall_open_ends(const sph_wall *wall, double *points);

/* What a checkpoint keeps of wall `number`: where a driver has put it, and its body. */
sph_status sphi_wall_keep(sph_wall *wall, int number, sphi_keep *keep);

#endif
