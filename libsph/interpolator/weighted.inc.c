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
  op_results r = {.carried = (v_widen(s->w) > 0) & (v_widen(s->gamma) >= a->gamma_min)};
  const vwide inverse = 1 / v_widen(s->w);
  for (int f = 0; f <= dim; f++) r.value[f] = v_widen(s->f[f]) * inverse;
  for (int d = 0; d < dim; d++) r.moment[d] = -v_widen(s->x[d]) * inverse;
  op_put(a, dim, first, count, s->n, s->gamma, &r);
}

#include "sweep/pair_loop.inc.c"
