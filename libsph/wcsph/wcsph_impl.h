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

/* Velocities go down at `rate` times the square of the way from `from` to `to`, 0 to 1. */
typedef struct damping_zone {
  int axis;
  double from, to, rate;
} damping_zone;

enum { WCSPH_ZONES = 16 };

typedef struct wcsph {
  sph_boundary *boundary; /* NULL: no walls */
  sphi_list ghost_list;
  void *ghost_record; /* scratch: those of one wall's ghosts */
  int64_t ghost_record_capacity;
  double c0, rho0, gamma, alpha, nu, delta, skin;
  sph_equation_of_state equation;
  sph_diffusion diffusion;
  sphi_body_force force;
  bool periodic[SPHI_MAX_DIM];
  double periodic_lo[SPHI_MAX_DIM], periodic_hi[SPHI_MAX_DIM];
  int zones;
  damping_zone zone[WCSPH_ZONES];
  bool domain_given;
  double domain_lo[SPHI_MAX_DIM], domain_hi[SPHI_MAX_DIM];
  void *array[WCSPH_ARRAYS];
  int64_t array_capacity[WCSPH_ARRAYS];
  float *clear; /* by rank: no wall was nearer than clear - odometer [m]; 0: not known */
  int64_t clear_capacity;
  double
      odometer; /* how far apart or together particles and walls may have come since clear was 0 [m] */
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
#define WCSPH_CLEAR 4 /* how far off a wall is looked for */

static inline wcsph *wcsph_of(const sph_integrator *flow) { return flow->data; }

/* Density of a pressure; NaN if there is none. */
double sphi_wcsph_density(const wcsph *w, double p);
sph_status sphi_wcsph_refresh(sph_integrator *flow);
double sphi_wcsph_limit(const sph_integrator *flow, sph_limiter *limiter);
sph_status sphi_wcsph_step(sph_integrator *flow, double dt);
/* Force on a wall by the pressures of its ghosts of the last evaluation and of the fluid now. */
sph_status sphi_wcsph_reaction(sph_integrator *flow, int wall, double *force);
/* The walls and particles fit together: nothing inside a wall, no open end under water. */
sph_status sphi_wcsph_check_walls(sph_integrator *flow);
/* Particles nearer to a wall than WCSPH_CONTACT spacings lose the speed at which they approach it, and
 * faster ones what would carry them through it within dt: jets thinner than the support would
 * otherwise pass between ghosts. Those that came in all the same, by less than WCSPH_INSIDE, are put
 * back; one that is deeper inside has crossed, which is an error. */
sph_status sphi_wcsph_stop_at_walls(sph_integrator *flow, double dt);
/* After particles or walls came elsewhere otherwise than by steps. */
void sphi_wcsph_forget_walls(sph_integrator *flow);
/* Speed of the fastest wall now. */
double sphi_wcsph_wall_speed(const wcsph *w);

#endif
