/* The loop that the library is measured against: delta-SPH as one would write it down first, in scalar
 * double over a list of neighbours, each pair visited once. */
#ifndef PLAIN_H
#define PLAIN_H

#include <stdint.h>

typedef enum plain_kernel { PLAIN_GAUSSIAN, PLAIN_WENDLAND_C2 } plain_kernel;

/* A fluid without walls. The caller fills everything down to `rho`; vectors are [n, dim]. */
typedef struct plain_flow {
  int dim;
  int32_t n;
  plain_kernel kernel;
  double h, support, c0, rho0, delta, alpha, gravity;
  double *x, *v, *m, *rho;

  double *p, *volume;
  int64_t *start; /* [n + 1] neighbours j > i of particle i are near[start[i]] ... */
  int32_t *near;
  int64_t capacity;
  int32_t *cell, *order; /* of the list's cell grid */
  double *sums;          /* [n, 10] sums of the pass in work */
  double *gradient, *lambda, *divergence;
  double *acceleration, *density_rate; /* the result */
} plain_flow;

/* Allocates every array for n particles; 0 if there is no memory. */
int plain_allocate(plain_flow *flow, int dim, int32_t n);
void plain_free(plain_flow *flow);

/* Pressures and volumes from the densities. */
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
