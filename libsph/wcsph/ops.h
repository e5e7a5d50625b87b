/* Arguments of the operators of weakly compressible SPH. Arrays are in storage order; those that are
 * `void *` have the reals of the variant, since they hold what pair sums give, or sums of that. */
#ifndef SPHI_WCSPH_OPS_H
#define SPHI_WCSPH_OPS_H

#include "integrator/integrator_impl.h"

/* op_gradient: geometry and velocity. */
typedef struct sphi_gradient_arguments {
  void *record;     /* fluid records: the gradient g is written into them; NULL: leave them */
  void *divergence; /* [n] sum_j (u_j - u_i) . grad_i W_ij V_j, ghosts included */
  void *lambda; /* [n] smallest eigenvalue of the moment matrix M_i: 1 with full support; or NULL */
  double lambda_min; /* below it the gradient is set to zero */
} sphi_gradient_arguments;

/* op_momentum: everything that needs the pressure or the density gradient. */
typedef struct sphi_momentum_arguments {
  void *acceleration[3]; /* [n] pressure and, where `viscous` is NULL, viscosity */
  void *viscous[3];      /* [n] viscosity alone, or NULL */
  void *diffusion;       /* [n] density diffusion [kg/m^3/s], or NULL */
  const void *record;    /* of the targets */
  const double *m;       /* [n] */
  const void *lambda;    /* [n] or NULL; diffusion is dropped below lambda_min */
  double lambda_min;
  double viscosity; /* alpha h c0 + 2 (dim + 2) nu [m^2/s] */
  double delta;     /* delta h c0 [m^2/s] */
  double rho0;
} sphi_momentum_arguments;

/* Largest speed and acceleration over some particles. */
typedef struct sphi_extremes {
  double speed2, acceleration2;
} sphi_extremes;

/* Updates are called for blocks of so many particles, the last perhaps shorter. */
enum { UPDATE_BLOCK = 512 };

/* op_update, a step's work on each particle alone. What an update does not need may be left out.
 *
 *   stages   x + drift v + drift_sum sum + drift_first first, v and rho + next rate (+ past sum of
 *            rates): of the records before the final stage, which leaves them; then of the fields
 *   kick     v += next acceleration, after acceleration = force + push if there are pushes
 *   move     x += drift v; rho += next (diffusion - rho divergence), of these those that are given;
 *            pressure, volume, records
 */
typedef struct sphi_update_arguments {
  const sphi_frame *frame;
  void *record;
  double *x[3], *v[3], *acceleration[3], *rho;
  const double *m;
  double *p, *volume;            /* NULL: go into the records alone */
  double rho0, stiffness, gamma; /* p = stiffness ((rho/rho0)^gamma - 1), or for gamma = 0 linear:
                                    stiffness (rho - rho0) */
  sphi_body_force force;
  double time;                                               /* for the body force */
  const void *push[3], *viscous[3], *divergence, *diffusion; /* as the pair sums left them */
  void *first[3], *sum[3], *rho_sum; /* of the stages so far, with weights 1, 2, 2 */
  double drift, drift_sum, drift_first, next, past;
  bool all; /* move: whole records, or positions, volumes and pressures alone */
  /* move: densities below rho0 become rho0 where lambda is below lambda_isolated; NULL: nowhere. */
  const void *lambda;
  double lambda_isolated;
  /* move: checks the state if there are extremes, one for each block; infinite bounds are none. */
  sphi_extremes *extremes;
  double lo[3], hi[3];
  double most2; /* of a speed, squared */
} sphi_update_arguments;

#endif
