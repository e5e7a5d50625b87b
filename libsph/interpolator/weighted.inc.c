/* The operators that are weighted means, I[f] = sum w f / sum w.
 *
 * Before: OPERATOR, op_targets, op_load and
 *   op_weight(dim, &t, source, &g)    the weight of one source for W targets, zero outside the support
 * After: the loops.
 */
typedef struct op_sums {
  vreal n, gamma, w, f[4], x[3];
} op_sums;

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  const vreal w = op_weight(dim, t, source, g);
  s->n += v_where(g->inside, v_set(1));
  s->gamma += g->w * source[SPHI_RECORD_V(dim)];
  s->w += w;
  for (int f = 0; f <= dim; f++) s->f[f] += w * source[SPHI_RECORD_F(dim) + f];
  for (int d = 0; d < dim; d++) s->x[d] += w * g->dx[d];
}
#define op_pair_second op_pair

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  op_put_mean(a, dim, first, count, s->n, s->gamma, s->w, s->f, s->x);
}

#include "sweep/pair_loop.inc.c"
