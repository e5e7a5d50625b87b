/* Ghosts from the inside: what a method calls during a step. */
#ifndef SPHI_BOUNDARY_IMPL_H
#define SPHI_BOUNDARY_IMPL_H

#include <sph/boundary.h>

#include "interpolator/gather_impl.h"
#include "wall/wall_impl.h"

enum { SPHI_MAX_WALLS = 64 };

/* Body force per mass: a constant, plus a function of position and time if there is one. */
typedef struct sphi_body_force {
  double constant[SPHI_MAX_DIM];
  void (*function)(double t, const double *x, double *force, void *user);
  void *user;
} sphi_body_force;

/* A ghost that takes part: what does not change, and its values by the fluid at its mirror point. */
typedef struct sphi_wet_ghost {
  int32_t ghost;
  uint8_t wall;
  bool reflects; /* the whole velocity, not only what is across the wall */
  uint8_t rung;
  bool live;     /* what follows changes as walls move, other than by a displacement */
  int8_t second; /* a wall that the mirror point was in, and is mirrored by once more; or -1 */
  double
      immersed; /* share of the volume whose mirror image is in the fluid; 1 for methods without rows */
  double volume, area;
  double to_ghost[SPHI_MAX_DIM], to_foot[SPHI_MAX_DIM]; /* from the mirror point */
  double normal[SPHI_MAX_DIM];
  double across[SPHI_MAX_DIM],
      second_normal[SPHI_MAX_DIM]; /* second: from the mirror point before */
  double p, wall_pressure, v[SPHI_MAX_DIM];
} sphi_wet_ghost;

/* The values of a wet ghost, while lists are made anew. */
typedef struct sphi_ghost_values {
  int32_t ghost;
  uint8_t rung;
  double p, wall_pressure, v[SPHI_MAX_DIM];
} sphi_ghost_values;

struct sph_boundary {
  sph_context *context;
  int references;
  int dim;
  double spacing;
  sph_interpolator *interpolator;
  int walls;
  sph_wall *wall[SPHI_MAX_WALLS];
  sphi_wall_state state[SPHI_MAX_WALLS];
  double arm[SPHI_MAX_WALLS]; /* of the wall's farthest ghost about the pivot */
  bool no_suction;
  bool
      leaves_air; /* a method's wish: ghosts whose mirror points are above the surface have no volume */
  double thin;
  bool taken;               /* an integrator holds it */
  bool in_use;              /* an integrator has stepped with it: no more walls */
  sphi_ghost_points points; /* reference positions, in order of creation */
  uint8_t *wall_of;         /* [n] */
  int64_t wall_of_capacity;
  double *x[SPHI_MAX_DIM]; /* [n] present positions */
  int32_t *order;  /* [n] ghosts along a curve through the mirror points that leaves no place far */
  int64_t ordered; /* how many ghosts it holds */
  int32_t *place;  /* [n] ghost -> wet ghost, -1 */
  uint8_t *near;   /* [n] to choose */
  sph_boundary_counts counts;
  sphi_columns columns; /* of all ghosts */
  /* Ghosts that fluid lists or that have a piece of wall to push on, and whose mirror points have fluid
   * near: in the order of their mirror points, and so are their records, which gates follow. */
  sphi_gather mirrors;
  int32_t *chosen; /* scratch: number of a wet ghost */
  sphi_wet_ghost *wet;
  int32_t wet_count;
  void *record;
  bool moved;       /* since the places in the records */
  double evaluated; /* time of the last evaluation */
  bool known;       /* forces on driven walls at a time before: */
  double force[SPHI_MAX_WALLS][SPHI_MAX_DIM], before;
  sphi_ghost_values *kept; /* scratch */
  int64_t chosen_capacity, wet_capacity, record_capacity, kept_capacity;
};

void sphi_boundary_retain(sph_boundary *boundary);
/* Allocates what steps need, for the ghosts there are now. */
sph_status sphi_boundary_prepare(sph_boundary *boundary);
bool sphi_boundary_moves(const sph_boundary *boundary);
/* Of the fastest place of a wall that has ghosts [m/s]. */
double sphi_boundary_speed(const sph_boundary *boundary);
/* Motion of driven walls from t to t + dt, by the forces of the last two evaluations before steps, put on
 * to the middle of this one: a force that lags feeds sound waves between walls. An incompressible fluid has no
 * sound, and a `density`: forces are as they are, and bodies carry the mass of fluid that moves with them. */
bool sphi_boundary_is_driven(const sph_boundary *boundary);
sph_status sphi_boundary_drive(sph_boundary *boundary, double t, double dt, double density);
/* Share of the volume of ghost k, as it stands now, that it has to itself beside other walls' ghosts. */
double sphi_boundary_share(const sph_boundary *boundary, int64_t k);
/* Where the walls are at time t, without their ghosts. */
sph_status sphi_boundary_place_walls(sph_boundary *boundary, double t);
/* Puts walls, ghosts and mirror points where they are at time t. */
sph_status sphi_boundary_move(sph_boundary *boundary, double t);
/* Sorts the ghosts anew. */
sph_status sphi_boundary_sort(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant);
/* Chooses the ghosts that take part until the next list, lists the fluid near their mirror points, and
 * leaves them alone in `near`, the fluid's list of ghosts, by the places of their records. */
sph_status sphi_boundary_list(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant, const sphi_columns *fluid, double radius,
                              sphi_list *near);
/* Interpolates from the fluid's records, assigns velocity and pressure, packs the ghosts' records. With
 * velocities that a step `ahead` has only the body force in, walls are taken as if it moved them too, and
 * their own acceleration not: what is then projected has their velocity. 0 otherwise. */
void sphi_boundary_update(sph_boundary *boundary, const sphi_frame *frame,
                          const sphi_variant *variant, const void *record,
                          const sphi_body_force *force, double t, double rho0, double ahead);
/* Copies the ghosts' records, boundary->record_capacity reals: places and volumes of those of one wall, whose
 * state is given, with the pressures of the last evaluation; the others' volumes are zero. */
void sphi_boundary_read_records(const sph_boundary *boundary, int wall,
                                const sphi_wall_state *state, const sphi_frame *frame,
                                const sphi_variant *variant, void *record);

/* Pressures of the wet ghosts by those of the fluid: p_g = sum_k weight_k p_column(k) + at_ghost, and at its
 * foot on the wall the same sum + at_foot. */
typedef struct sphi_ghost_rows {
  int64_t *first;  /* [wet] */
  int32_t *count;  /* [wet] 0: no fluid near, or too little of it */
  int32_t *column; /* numbers of particles in storage order */
  double *weight;
  double *at_ghost, *at_foot; /* [wet] Pa */
  int64_t capacity[6];
} sphi_ghost_rows;

void sphi_ghost_rows_free(sph_context *context, sphi_ghost_rows *rows);
/* Rows for the fluid at x with these volumes, walls as they are at time t: weights of the kernel, with which
 * water at rest is exact. Ghosts whose mirror
 * points are not in the fluid lose their volume at the next update. */
sph_status sphi_boundary_rows(sph_boundary *boundary, const sphi_frame *frame, double *const *x,
                              const double *volume, const sphi_body_force *force, double t,
                              double rho0, sphi_ghost_rows *rows);
/* Pressures of ghosts and walls by rows from the fluid's p, into the records too. */
void sphi_boundary_set_pressures(sph_boundary *boundary, const sphi_variant *variant,
                                 const sphi_ghost_rows *rows, const double *p);

/* What a checkpoint keeps: places of walls, what ghosts have of the last evaluation, forces on driven walls. */
sph_status sphi_boundary_keep(sph_boundary *boundary, sphi_keep *keep);

/* For libsph/boundary only. */

/* Makes wet ghost k of a ghost, without values. */
void sphi_boundary_make_wet(sph_boundary *boundary, int32_t k, int32_t ghost);

/* A number into record `k` at `at`. */
static inline void sphi_put_real(void *record, bool is_double, int64_t at, double value) {
  if (is_double)
    ((double *)record)[at] = value;
  else
    ((float *)record)[at] = (float)value;
}

/* Pressure gradient at the foot of wet ghost k that keeps fluid at rest beside the wall: rho0 (f - a_w); the
 * return value is what a second wall adds on the first part of the way from the mirror point. */
static inline __attribute__((always_inline)) double sphi_wall_gradient(const sph_boundary *boundary,
                                                                       const int dim, int32_t k,
                                                                       const sphi_body_force *force,
                                                                       double t, double rho0,
                                                                       double *gradient) {
  const sphi_wet_ghost *ghost = &boundary->wet[k];
  double f[SPHI_MAX_DIM] = {0}, at[SPHI_MAX_DIM], velocity[SPHI_MAX_DIM],
         acceleration[SPHI_MAX_DIM], more = 0;
  for (int d = 0; d < dim; d++) at[d] = boundary->mirrors.x[d][k] + ghost->to_foot[d];
  if (force->function) force->function(t, at, f, force->user);
  sphi_wall_velocity_at(&boundary->state[ghost->wall], dim, at, velocity, acceleration);
  for (int d = 0; d < dim; d++) gradient[d] = rho0 * (force->constant[d] + f[d] - acceleration[d]);
  if (ghost->second < 0) return 0;
  double second_acceleration[SPHI_MAX_DIM];
  for (int d = 0; d < dim; d++) at[d] = boundary->mirrors.x[d][k] + 0.5 * ghost->across[d];
  sphi_wall_velocity_at(&boundary->state[ghost->second], dim, at, velocity, second_acceleration);
  for (int d = 0; d < dim; d++)
    more += rho0 * (acceleration[d] - second_acceleration[d]) * ghost->across[d];
  return more;
}

#endif
