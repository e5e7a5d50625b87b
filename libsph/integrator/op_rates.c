/* The convective part of delta-SPH alone, for the later stages of Runge-Kutta steps with frozen
 * diffusion: a_i = -(1/rho_i) sum_j (p_i + p_j) grad_i W_ij V_j and
 * D_i = sum_j (u_j - u_i) . grad_i W_ij V_j, over fluid and ghosts. */
#define OPERATOR rates
#define OP_BARE 1
#include "integrator/integrator_impl.h"
#include "integrator/pairs_impl.h"

typedef sphi_rates_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal v[3], p;
} op_targets;

typedef struct op_sums {
  vreal pressure[3], divergence;
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)first;
  t->p = pair_lanes(record, stride, SPHI_RECORD_F(dim));
  for (int d = 0; d < dim; d++) t->v[d] = pair_lanes(record, stride, SPHI_RECORD_F(dim) + 1 + d);
}

/* Fluid and ghost records start alike, so one function serves both. */
SPHI_INLINE void add_pair(const int dim, const op_targets *t, const real *source, const pair *g,
                          vreal gw, op_sums *s) {
  vreal gradient[3];
  pair_gradient(dim, gw, source[SPHI_RECORD_V(dim)], g, gradient);
  const vreal push = t->p + source[SPHI_RECORD_F(dim)];
  const real *v = source + SPHI_RECORD_F(dim) + 1;
  for (int d = 0; d < dim; d++) {
    s->pressure[d] += push * gradient[d];
    s->divergence += (v[d] - t->v[d]) * gradient[d];
  }
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  add_pair(dim, t, source, g, g->gw, s);
}

SPHI_INLINE void op_pair_second(const op_arguments *a, const int dim, const op_targets *t,
                                const real *source, const pair *g, op_sums *s) {
  (void)a;
  add_pair(dim, t, source, g, ghost_gw(dim, source, g), s);
}

SPHI_INLINE void op_metres(const int dim, const pair_units *units, op_sums *s) {
  const real factor = (real)(units->slope * units->length);
  for (int d = 0; d < dim; d++) s->pressure[d] *= factor;
  s->divergence *= factor;
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  const vreal over_rho = over_density(dim, a->record, a->m, first, count);
  for (int d = 0; d < dim; d++)
    lanes_store((real *)a->acceleration[d] + first, count, -over_rho * s->pressure[d]);
  lanes_store((real *)a->divergence + first, count, s->divergence);
}

#include "sweep/pair_loop.inc.c"
