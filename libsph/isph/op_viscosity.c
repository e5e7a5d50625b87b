/* Laminar viscosity, Morris et al. (1997): a_i = 2 nu sum_j V_j (dW/dr)/r (u_i - u_j), over fluid and ghosts,
 * whose mirrored velocities drag where walls do. */
#define OPERATOR viscosity
#include "integrator/pairs_impl.h"
#include "isph/ops.h"

typedef sphi_viscosity_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal v[3];
} op_targets;

typedef struct op_sums {
  vreal a[3];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)first;
  for (int d = 0; d < dim; d++) t->v[d] = pair_lanes(record, stride, SPHI_RECORD_F(dim) + 1 + d);
}

SPHI_INLINE void add_pair(const int dim, const op_targets *t, const real *source, vreal gw,
                          op_sums *s) {
  const vreal weight = gw * source[SPHI_RECORD_V(dim)];
  const real *v = source + SPHI_RECORD_F(dim) + 1;
  for (int d = 0; d < dim; d++) s->a[d] += weight * (t->v[d] - v[d]);
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  add_pair(dim, t, source, g->gw, s);
}

SPHI_INLINE void op_pair_second(const op_arguments *a, const int dim, const op_targets *t,
                                const real *source, const pair *g, op_sums *s) {
  (void)a;
  add_pair(dim, t, source, ghost_gw(dim, source, g), s);
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  for (int d = 0; d < dim; d++)
    lanes_store((real *)a->acceleration[d] + first, count, (real)(2 * a->nu) * s->a[d]);
}

#include "sweep/pair_loop.inc.c"
