/* Weakly compressible SPH from the inside. */
#ifndef SPHI_WCSPH_IMPL_H
#define SPHI_WCSPH_IMPL_H

#include <sph/wcsph.h>

#include "boundary/boundary_impl.h"
#include "integrator/integrator_impl.h"
#include "wcsph/ops.h"

/* Arrays of one of the variant's reals a particle, in storage order. */
enum {
  WCSPH_DIVERGENCE,
  WCSPH_LAMBDA,
  WCSPH_DIFFUSION,
  WCSPH_PUSH,                      /* 3: acceleration by the pair sums */
  WCSPH_VISCOUS = WCSPH_PUSH + 3,  /* 3: viscous acceleration, frozen over a Runge-Kutta step */
  WCSPH_FIRST = WCSPH_VISCOUS + 3, /* 3: acceleration of the first stage */
  WCSPH_SUM = WCSPH_FIRST + 3,     /* 3: weighted sum of the stages' accelerations */
  WCSPH_SUM_RHO = WCSPH_SUM + 3,   /* the same of density rates */
  WCSPH_ARRAYS,
  WCSPH_ARRAYS_PLAIN = WCSPH_VISCOUS /* what steppers other than Runge-Kutta need */
};

typedef struct wcsph {
  double c0, gamma, alpha, nu, delta;
  sph_equation_of_state equation;
  sph_diffusion diffusion;
  void *array[WCSPH_ARRAYS];
  int64_t array_capacity[WCSPH_ARRAYS];
  sphi_extremes *block; /* of every UPDATE_BLOCK particles */
  int64_t block_capacity;
  bool accelerated; /* the acceleration field belongs to the state now (Verlet) */
} wcsph;

static inline wcsph *wcsph_of(const sph_integrator *flow) { return flow->data; }

/* Density of a pressure; NaN if there is none. */
double sphi_wcsph_density(const sph_integrator *flow, double p);
sph_status sphi_wcsph_refresh(sph_integrator *flow);
double sphi_wcsph_limit(const sph_integrator *flow, sph_limiter *limiter);
sph_status sphi_wcsph_step(sph_integrator *flow, double dt);
sph_status sphi_wcsph_keep(sph_integrator *flow, sphi_keep *keep);

#endif
