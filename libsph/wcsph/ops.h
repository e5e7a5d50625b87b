/* Arguments of the operators of weakly compressible SPH. Arrays are in storage order. */
#ifndef SPHI_WCSPH_OPS_H
#define SPHI_WCSPH_OPS_H

#ifdef SPHI_PAIR_H
/* gw of a pair of fluid and ghost: zero where the fluid does not see the ghost. */
SPHI_INLINE vreal ghost_gw(const int dim, const real *ghost, const pair *g) {
  const real *gate = ghost + SPHI_GHOST_GATES(dim);
  const int gates = (int)*gate++;
  vreal gw = g->gw;
  for (int k = 0; k < gates; k++, gate += dim + 1) {
    vreal side = v_set(gate[dim] * g->constants->per_metre);
    for (int d = 0; d < dim; d++) side += gate[d] * g->dx[d];
    gw = v_where(side > 0, gw);
  }
  return gw;
}
#endif

/* op_gradient: geometry and velocity. */
typedef struct sphi_gradient_arguments {
  void *record;       /* fluid records: the gradient g is written into them; NULL: leave them */
  double *divergence; /* [n] sum_j (u_j - u_i) . grad_i W_ij V_j, ghosts included */
  double
      *lambda; /* [n] smallest eigenvalue of the moment matrix M_i: 1 with full support; or NULL */
  double lambda_min; /* below it the gradient is set to zero */
} sphi_gradient_arguments;

/* op_momentum: everything that needs the pressure or the density gradient. */
typedef struct sphi_momentum_arguments {
  double *acceleration[3]; /* [n] pressure and, where `viscous` is NULL, viscosity */
  double *viscous[3];      /* [n] viscosity alone, or NULL */
  double *diffusion;       /* [n] density diffusion [kg/m^3/s], or NULL */
  const double *rho;       /* [n] */
  const double *lambda;    /* [n] or NULL; diffusion is dropped below lambda_min */
  double lambda_min;
  double viscosity; /* alpha h c0 + 2 (dim + 2) nu [m^2/s] */
  double delta;     /* delta h c0 [m^2/s] */
  double rho0;
} sphi_momentum_arguments;

/* op_rates: pressure and divergence together, without diffusive terms. */
typedef struct sphi_rates_arguments {
  double *acceleration[3];
  double *divergence;
  const double *rho;
} sphi_rates_arguments;

#endif
