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

typedef struct sphi_wall_state {
  double displacement[SPHI_MAX_DIM], velocity[SPHI_MAX_DIM], acceleration[SPHI_MAX_DIM];
} sphi_wall_state;

struct sph_boundary {
  sph_context *context;
  int references;
  int dim;
  double spacing;
  sph_interpolator *interpolator;
  int walls;
  sph_wall *wall[SPHI_MAX_WALLS];
  sphi_wall_state state[SPHI_MAX_WALLS];
  bool no_suction;
  double thin;
  bool taken;               /* an integrator holds it */
  bool in_use;              /* an integrator has stepped with it: no more walls */
  sphi_ghost_points points; /* reference positions, in order of creation */
  int32_t *wall_of;         /* [n] */
  int64_t wall_of_capacity;
  double *x[SPHI_MAX_DIM]; /* [n] present positions */
  double *v[SPHI_MAX_DIM];
  double *p, *volume, *drag, *wall_pressure;
  uint8_t *rung;
  sph_boundary_counts counts;
  sphi_gather mirrors;  /* mirrors.x: present mirror points */
  sphi_columns columns; /* of the ghosts */
  void *record;         /* of the ghosts, in the order of columns */
  int32_t *place;       /* [n] ghost -> record */
  int32_t *wet;         /* records of ghosts whose mirror points are evaluated */
  int32_t wet_count;
};

void sphi_boundary_retain(sph_boundary *boundary);
/* Allocates what steps need, for the ghosts there are now. */
sph_status sphi_boundary_prepare(sph_boundary *boundary, const sphi_variant *variant);
bool sphi_boundary_moves(const sph_boundary *boundary);
/* Where the walls are at time t, without their ghosts. */
sph_status sphi_boundary_place_walls(sph_boundary *boundary, double t);
/* Puts walls, ghosts and mirror points where they are at time t. */
sph_status sphi_boundary_move(sph_boundary *boundary, double t);
/* Sorts ghosts and mirror points anew. */
sph_status sphi_boundary_sort(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant);
/* Lists the fluid near the mirror points; the ghosts of those without any take no part until the next
 * list. */
sph_status sphi_boundary_list(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant, const sphi_columns *fluid,
                              double radius);
/* Interpolates from the fluid's records, assigns velocity and pressure, packs the ghosts' records. */
void sphi_boundary_update(sph_boundary *boundary, const sphi_frame *frame,
                          const sphi_variant *variant, const void *record,
                          const sphi_body_force *force, double t, double rho0);

#endif
