/* Weakly compressible SPH from the inside. */
#ifndef SPHI_WCSPH_IMPL_H
#define SPHI_WCSPH_IMPL_H

#include <sph/wcsph.h>

#include "boundary/boundary_impl.h"
#include "integrator/integrator_impl.h"
#include "wcsph/ops.h"

/* Arrays of one value a particle, in storage order. */
enum {
  WCSPH_DIVERGENCE,
  WCSPH_LAMBDA,
  WCSPH_DIFFUSION,
  WCSPH_RATE,    /* D rho / D t of a Runge-Kutta stage */
  WCSPH_VISCOUS, /* 3: viscous acceleration, frozen over a Runge-Kutta step */
  WCSPH_OLD_X = WCSPH_VISCOUS + 3,
  WCSPH_OLD_V = WCSPH_OLD_X + 3,
  WCSPH_OLD_RHO = WCSPH_OLD_V + 3,
  WCSPH_SUM_X, /* 3: weighted sums of the stages' rates */
  WCSPH_SUM_V = WCSPH_SUM_X + 3,
  WCSPH_SUM_RHO = WCSPH_SUM_V + 3,
  WCSPH_ARRAYS,
  WCSPH_ARRAYS_PLAIN = WCSPH_RATE /* what steppers other than Runge-Kutta need */
};

typedef struct wcsph {
  sph_boundary *boundary; /* NULL: no walls */
  sphi_list ghost_list;
  double c0, rho0, gamma, alpha, nu, delta, skin;
  sph_equation_of_state equation;
  sph_diffusion diffusion;
  sphi_body_force force;
  bool periodic[SPHI_MAX_DIM];
  double periodic_lo[SPHI_MAX_DIM], periodic_hi[SPHI_MAX_DIM];
  bool domain_given;
  double domain_lo[SPHI_MAX_DIM], domain_hi[SPHI_MAX_DIM];
  double *array[WCSPH_ARRAYS];
  int64_t array_capacity[WCSPH_ARRAYS];
  sphi_extremes *block; /* of every UPDATE_BLOCK particles */
  int64_t block_capacity;
  int acceleration; /* number of that field */
  bool prepared;    /* the boundary's arrays are there */
  bool packed;      /* records hold the state now */
  bool accelerated; /* the acceleration field belongs to the state now (Verlet) */
  double travel;    /* how far a particle or wall may come in the step at hand [m] */
  double travelled; /* how far a particle or wall may have come since the lists were built [m] */
} wcsph;

/* In spacings: particles nearer to a wall touch it; deeper inside one they have crossed it. */
#define WCSPH_CONTACT 0.25
#define WCSPH_INSIDE 0.5

enum { UPDATE_BLOCK = 512 };

static inline wcsph *wcsph_of(const sph_integrator *flow) { return flow->data; }

double sphi_wcsph_pressure(const wcsph *w, double rho);
/* Density of a pressure; NaN if there is none. */
double sphi_wcsph_density(const wcsph *w, double p);
sph_status sphi_wcsph_refresh(sph_integrator *flow);
double sphi_wcsph_limit(const sph_integrator *flow, sph_limiter *limiter);
sph_status sphi_wcsph_step(sph_integrator *flow, double dt);
/* The walls and particles fit together: nothing inside a wall, no open end under water. */
sph_status sphi_wcsph_check_walls(sph_integrator *flow);
/* Particles nearer to a wall than WCSPH_CONTACT spacings lose the speed at which they approach it, and
 * faster ones what would carry them through it within dt: jets thinner than the support would
 * otherwise pass between ghosts. Those that came in all the same, by less than WCSPH_INSIDE, are put
 * back; one that is deeper inside has crossed, which is an error. */
sph_status sphi_wcsph_stop_at_walls(sph_integrator *flow, double dt);

#endif
