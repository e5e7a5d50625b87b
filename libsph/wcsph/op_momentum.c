/* Second pass over the pairs of delta-SPH, Huang et al. (2019) eq. (5) with the prefactors of the
 * diffusive terms as Antuono et al. (2010) and Marrone et al. (2011) have them:
 *
 *   a_i = -(1/rho_i) sum_j (p_i + p_j) grad_i W_ij V_j
 *         + K (rho0/rho_i) sum_j pi_ij grad_i W_ij V_j,   pi_ij = (u_j - u_i) . x_ji / |x_ji|^2  (1)
 *   B_i = delta h c0 sum_j psi_ij . grad_i W_ij V_j,                                             (2)
 *         psi_ij = 2 (rho_j - rho_i) x_ji / |x_ji|^2 - (<grad rho>_i + <grad rho>_j)
 *
 * K = alpha h c0 for artificial viscosity, + 2 (dim + 2) nu for a laminar one. Ghosts push; they drag
 * only where the wall is no-slip; they take no part in (2), so that no mass diffuses into walls.
 */
#define OPERATOR momentum
#define OP_BARE 1
#include "integrator/pairs_impl.h"
#include "wcsph/ops.h"

typedef sphi_momentum_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal v[3], p, d, g[3];
} op_targets;

typedef struct op_sums {
  vreal pressure[3], viscous[3], diffusion, difference;
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)first;
  t->p = pair_lanes(record, stride, SPHI_RECORD_F(dim));
  t->d = pair_lanes(record, stride, SPHI_RECORD_D(dim));
  for (int d = 0; d < dim; d++) {
    t->v[d] = pair_lanes(record, stride, SPHI_RECORD_F(dim) + 1 + d);
    t->g[d] = pair_lanes(record, stride, SPHI_RECORD_G(dim) + d);
  }
}

/* (u_j - u_i) . x_ij / |x_ij|^2, zero for a particle with itself: |x|^2 is kept off zero, by one
 * fixed-point step where those are the unit. */
SPHI_INLINE vreal approach_rate(const int dim, const op_targets *t, const real *v, const pair *g) {
  vreal approach = v_set(0);
  for (int d = 0; d < dim; d++) approach += (v[d] - t->v[d]) * g->dx[d];
  return approach * v_reciprocal(g->r2 + (real)(SPHI_DOUBLE ? 1e-30 : 1));
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  vreal gradient[3];
  pair_gradient(dim, g->gw, source[SPHI_RECORD_V(dim)], g, gradient);
  const vreal push = t->p + source[SPHI_RECORD_F(dim)];
  /* pi_ij has x_ji where approach_rate has x_ij: the sign is put in at the end. */
  const vreal drag = approach_rate(dim, t, source + SPHI_RECORD_F(dim) + 1, g);
  /* psi . grad W = -gw [2 (rho_j - rho_i) + (g_i + g_j) . x_ij]: the quotient by |x|^2 cancels. */
  const real *gj = source + SPHI_RECORD_G(dim);
  const vreal difference = source[SPHI_RECORD_D(dim)] - t->d;
  s->difference += g->gw * source[SPHI_RECORD_V(dim)] * difference;
  for (int d = 0; d < dim; d++) {
    s->diffusion += (t->g[d] + gj[d]) * gradient[d];
    s->pressure[d] += push * gradient[d];
    s->viscous[d] += drag * gradient[d];
  }
}

SPHI_INLINE void op_pair_second(const op_arguments *a, const int dim, const op_targets *t,
                                const real *source, const pair *g, op_sums *s) {
  (void)a;
  vreal gradient[3];
  pair_gradient(dim, ghost_gw(dim, source, g), source[SPHI_RECORD_V(dim)], g, gradient);
  const vreal push = t->p + source[SPHI_RECORD_F(dim)];
  const vreal drag =
      source[SPHI_GHOST_S(dim)] * approach_rate(dim, t, source + SPHI_RECORD_F(dim) + 1, g);
  for (int d = 0; d < dim; d++) {
    s->pressure[d] += push * gradient[d];
    s->viscous[d] += drag * gradient[d];
  }
}

SPHI_INLINE void op_metres(const int dim, const pair_units *units, op_sums *s) {
  const real slope = (real)units->slope, once = (real)(units->slope * units->length);
  s->diffusion = once * s->diffusion + 2 * slope * s->difference;
  for (int d = 0; d < dim; d++) {
    s->pressure[d] *= once;
    s->viscous[d] *= slope;
  }
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  const vreal over_rho = over_density(dim, a->record, a->m, first, count);
  const vreal viscosity = (real)(a->viscosity * a->rho0) * over_rho;
  for (int d = 0; d < dim; d++) {
    const vreal pressure = -over_rho * s->pressure[d], viscous = -viscosity * s->viscous[d];
    const vreal both = a->viscous[d] ? pressure : pressure + viscous;
    lanes_store((real *)a->acceleration[d] + first, count, both);
    if (a->viscous[d]) lanes_store((real *)a->viscous[d] + first, count, viscous);
  }
  if (!a->diffusion) return;
  vreal diffusion = -(real)a->delta * s->diffusion;
  for (int32_t l = 0; l < count && a->lambda; l++)
    if (((const real *)a->lambda)[first + l] < (real)a->lambda_min) diffusion[l] = 0;
  lanes_store((real *)a->diffusion + first, count, diffusion);
}

#include "sweep/pair_loop.inc.c"
