/* The loop that the library is measured against: delta-SPH as one would write it down first, in scalar
 * double over a list of neighbours, each pair of fluid visited once. */
#ifndef PLAIN_H
#define PLAIN_H

#include <stdint.h>

typedef enum plain_kernel { PLAIN_GAUSSIAN, PLAIN_WENDLAND_C2 } plain_kernel;

/* Vectors are [n, dim]. */
typedef struct plain_points {
  int32_t n;
  double *x, *v, *p, *volume;
  int32_t *cell, *order, *first; /* of the list's cell grid; first lives while a list is built */
} plain_points;

/* Neighbours of particle i are near[start[i]] ... near[start[i + 1] - 1]. */
typedef struct plain_neighbours {
  int64_t *start; /* [n + 1] */
  int32_t *near;
  int64_t used, capacity;
} plain_neighbours;

/* A fluid and the ghosts of free-slip walls, which push it and take part in its divergence. */
typedef struct plain_flow {
  /* To be filled by the caller: numbers, the fluid's x and v, m, rho, and everything of the ghosts. */
  int dim;
  plain_kernel kernel;
  double h, support, c0, rho0, delta, alpha, gravity;
  plain_points fluid, ghost;
  double *m, *rho;

  plain_neighbours pairs;  /* fluid j > i */
  plain_neighbours ghosts; /* of the fluid */
  double *sums;            /* [n, 10] sums of the pass in work */
  double *gradient, *lambda, *divergence;
  double *acceleration, *density_rate; /* the result */
} plain_flow;

/* Allocates every array; 0 if there is no memory. */
int plain_allocate(plain_flow *flow, int dim, int32_t particles, int32_t ghosts);
void plain_free(plain_flow *flow);

/* The fluid's pressures and volumes from its densities. */
void plain_state(plain_flow *flow);
/* Finds the neighbours by a grid of cells as wide as the support; 0 if there is no memory. */
int plain_list(plain_flow *flow);
/* First pass: moment matrix, renormalised density gradient, divergence. */
void plain_gradient(plain_flow *flow);
/* Second pass: acceleration and density rate with viscosity and density diffusion. */
void plain_rates(plain_flow *flow);
/* The convective part alone, in one pass: pressure and divergence. */
void plain_convective(plain_flow *flow);

#endif
