/* The hybrid particle-mesh method from the inside. */
#ifndef SPHI_FLIP_IMPL_H
#define SPHI_FLIP_IMPL_H

#include <sph/flip.h>

#include "integrator/integrator_impl.h"
#include "mesh/mesh_impl.h"

/* What loops over particles need of a cell: a corner, the gradients of the hats of the other two, the
 * velocity at the corners and in the middle, and what is added to (1 - alpha) times that of particles. */
typedef struct flip_record {
  double x[2], g1[2], g2[2];
  double u[4][2], kick[4][2];
} flip_record;

/* What particles need to be carried along; the cell they are in stays as it is. */
typedef struct flip_carry {
  const flip_record *record;
  const int64_t *start;
  const int32_t *order, *corner;
  const double *pressure;
  double *x[2], *v[2], *p;
  double dt, pic;
  uint8_t *left; /* [n] set for those that leave their cell, which stay where they are */
} flip_carry;

/* What a node on walls keeps to: u . n = h for up to two normals. */
typedef struct flip_hold {
  int32_t node;
  int normals;
  double n[2][2], h[2];
} flip_hold;

typedef struct flip {
  sph_mesh *mesh;
  sph_solver *solver, *mass_solver; /* the second once it is needed */
  double gravity[2], density[2], viscosity[2];
  double theta;        /* of the volume's correction */
  double alpha, share; /* of PIC: the caller's, < 0: none; that of the step */
  sph_flip_smoothing smoothing;
  bool lumped, mass_weighted, no_slip, spreads;
  int fewest, most;
  int open; /* tag, 0: none */
  sph_flip_stats stats;
  int field;          /* number of the field "cell" */
  int64_t revision;   /* of the particles that `cell` and the rest are of; -1: none */
  int64_t mesh_moves; /* revision of the mesh that particles were located in */
  double rate;        /* largest |u| / l of the last step [1/s] */
  double shortest;    /* smallest l, which is sqrt(2 A) */
  double usual;       /* particles in a cell when they were located first */

  /* Of the particles. */
  int32_t *cell, *order; /* [n] storage order; by cells, those of a cell in storage order */
  uint8_t *left;         /* [n] by flip_carry */
  int64_t cell_capacity, order_capacity, left_capacity;
  int64_t *start; /* [cells + 1] in `order` */

  /* Of the cells. */
  double *rho, *u[2];        /* [cells] means */
  double *spread, *weight;   /* [cells] scratch; in r */
  double *volume;            /* [cells, 3] of particles, shared out to the corners by their hats */
  int32_t *partner;          /* [cells] the other half of a square, or the cell itself */
  double *star[2], *next[2]; /* [cells] velocity before and after pressure acts */
  uint8_t *mixed, *smooth, *filled;
  flip_record *record;
  double *stress[3]; /* [nodes] xx, yy, xy */

  /* Of the nodes. */
  double *pressure, *right, *push[2]; /* grad p / rho */
  double *source;                     /* wanted: integral of N_a div u */
  double *mass;                       /* lumped: a third of the areas around */
  double *velocity[2], *before[2],
      *after[2];        /* nodes of U^(n+1); by mass at both ends of the step */
  uint8_t *held, *near; /* p = 0 there; scratch */

  /* Of the boundary: outward normal velocity of edges at the step's start and end. */
  double *normal_velocity[2];
  int32_t holds;
  flip_hold *hold[2]; /* at the step's start and end */

  /* The matrix: all pairs of nodes of a cell. */
  int64_t *row_start;
  int32_t *columns,
      *slot; /* slot [touches, 3]: places in values of a cell's corners in a node's row */
  double *values, *mass_values;

  /* New particles; those to be removed have cell -1. */
  double *fresh; /* [fresh_count, FLIP_FRESH] */
  int64_t fresh_capacity, fresh_count;

  /* Means of density after `now_step` steps, for levels. */
  double *now_rho, *now_count; /* [cells] */
  int64_t now_step, now_revision;
} flip;

/* Numbers of a new particle: place, velocity, density, mass, volume, cell. */
enum { FLIP_FRESH = 8 };

/* How far particles are put from a wall that they have crossed, in parts of the way to the cell's middle. */
#define FLIP_BACK 1e-6

static inline flip *flip_of(const sph_integrator *flow) { return flow->data; }
static inline double **flip_field(const sph_integrator *flow, int number) {
  return flow->particles->field[number].data;
}

/* Velocities of records at a point of a cell with these barycentric coordinates: (1) of
 * docs/theory/flip.md. */
static inline void flip_mix(const double *values, double s0, double s1, double s2, double *out) {
  const double low = s0 < s1 ? s0 : s1, least = low < s2 ? low : s2; /* without branches */
  for (int d = 0; d < 2; d++)
    out[d] = (s0 - least) * values[d] + (s1 - least) * values[2 + d] +
             (s2 - least) * values[4 + d] + 3 * least * values[6 + d];
}

/* flip.c: whether a flow is of this method; places of particles that the caller gave or changed. */
sph_status sphi_flip_check(const sph_integrator *flow);
sph_status sphi_flip_refresh(sph_integrator *flow);

/* flip_keep.c */
sph_status sphi_flip_keep(sph_integrator *flow, sphi_keep *keep);

/* flip_measure.c: what probes ask for, see sphi_method. */
sph_status sphi_flip_evaluate(sph_integrator *flow, int64_t count, const double *x,
                              double *pressure, double *velocity, double *filling);

/* flip_cells.c: places of all particles; SPH_E_ARGUMENT names one that is outside, unless the paddle has just
 * gone over it. */
sph_status sphi_flip_locate(sph_integrator *flow, bool moved);
/* Order by cells. */
sph_status sphi_flip_sort(sph_integrator *flow);
/* (1): means, cells without particles, cells with both fluids and around them. */
void sphi_flip_gather(sph_integrator *flow);

/* flip_density.c: which cells share densities; (11) and (12), over the means. */
void sphi_flip_pair_cells(flip *s);
void sphi_flip_spread_density(sph_integrator *flow);

/* flip_seed.c: particles into cells that have few, out of those that have many. */
sph_status sphi_flip_reseed(sph_integrator *flow);
void sphi_flip_remove_gone(sph_integrator *flow);

/* flip_pressure.c */
sph_status sphi_flip_make_matrix(sph_integrator *flow);
/* Areas around nodes and what nodes on walls keep to, `when` 0 or 1: at the start of a step or its end. */
void sphi_flip_measure(sph_integrator *flow, int when);
/* (3) and (4): from s->star to s->next. */
sph_status sphi_flip_project(sph_integrator *flow, double dt);
/* flip_smooth.c: (2), and the smoothing of (4). */
void sphi_flip_predict(sph_integrator *flow, double dt);
sph_status sphi_flip_push(sph_integrator *flow, double dt);

/* flip_particles.c: (5) and (6). */
void sphi_flip_reconstruct(sph_integrator *flow);
sph_status sphi_flip_advance(sph_integrator *flow, double dt);

#endif
