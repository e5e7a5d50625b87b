/* Entries of the pressure equation, a pair each, METHODS: Schwaiger (2008), with the moments of op_projection:
 *
 *   a_ij = -2 s_i V_j (dW/dr)/r (1 + q_i . x_ij),   s_i = tr(M_i^-1) / dim,   q_i = M_i^-1 N_i   (1)
 *
 * For one pair sum_j a_ij (p_j - p_i) is the Laplacian of p. Lanes of a cluster lie together, its sources one
 * after the other, as the lists have them.
 */
#define OPERATOR laplacian
#include "integrator/pairs_impl.h"
#include "isph/ops.h"

typedef sphi_laplacian_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal q[3], scale;
  real *out[2];
} op_targets;

typedef struct op_sums {
  int64_t done[2];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)record, (void)stride;
  for (int d = 0; d < dim; d++) t->q[d] = pair_lanes((const real *)a->q[d] + first, 1, 0);
  t->scale = pair_lanes((const real *)a->scale + first, 1, 0);
  for (int s = 0; s < 2; s++) t->out[s] = (real *)a->entry[s] + a->place[s][first];
}

SPHI_INLINE void add_pair(const int dim, const op_targets *t, const int list, real volume,
                          const pair *g, vreal gw, op_sums *s) {
  vreal tilt = v_set(1);
  for (int d = 0; d < dim; d++) tilt += t->q[d] * g->dx[d];
  const vreal entry = -2 * volume * gw * t->scale * tilt;
  memcpy(t->out[list] + SPHI_LANES * s->done[list]++, &entry, sizeof entry);
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  add_pair(dim, t, 0, source[SPHI_RECORD_V(dim)], g, g->gw, s);
}

SPHI_INLINE void op_pair_second(const op_arguments *a, const int dim, const op_targets *t,
                                const real *source, const pair *g, op_sums *s) {
  (void)a;
  add_pair(dim, t, 1, source[SPHI_RECORD_V(dim)], g, ghost_gw(dim, source, g), s);
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)a, (void)dim, (void)first, (void)count, (void)t, (void)s;
}

#include "sweep/pair_loop.inc.c"
