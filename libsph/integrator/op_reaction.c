/* What the pressure of ghosts takes from the momentum of the fluid: the force on them,
 * V_i sum_g (p_i + p_g) grad_i W_ig V_g. */
#define OPERATOR reaction
#define OP_BARE 1
#include "integrator/integrator_impl.h"
#include "integrator/pairs_impl.h"

typedef sphi_reaction_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_GHOST(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal p, volume;
} op_targets;

typedef struct op_sums {
  vreal push[3];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)first;
  t->p = pair_lanes(record, stride, SPHI_RECORD_F(dim));
  t->volume = pair_lanes(record, stride, SPHI_RECORD_V(dim));
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *ghost, const pair *g, op_sums *s) {
  (void)a;
  vreal gradient[3];
  pair_gradient(dim, ghost_gw(dim, ghost, g), ghost[SPHI_RECORD_V(dim)], g, gradient);
  const vreal push = t->p + ghost[SPHI_RECORD_F(dim)];
  for (int d = 0; d < dim; d++) s->push[d] += push * gradient[d];
}
#define op_pair_second op_pair

SPHI_INLINE void op_metres(const int dim, const pair_units *units, op_sums *s) {
  const real factor = (real)(units->slope * units->length);
  for (int d = 0; d < dim; d++) s->push[d] *= factor;
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  for (int d = 0; d < dim; d++)
    lanes_store((real *)a->force[d] + first, count, t->volume * s->push[d]);
}

#include "sweep/pair_loop.inc.c"
