/* The operators that are weighted means, I[f] = sum w f / sum w.
 *
 * Before: OPERATOR, op_targets, op_load and
 *   op_weight(dim, &t, source, &g)    the weight of one source for W targets, zero outside the support
 * After: the loops.
 */
typedef sphi_interpolation_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_RECORD(dim)

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
  for (int32_t l = 0; l < count; l++) {
    double *sums = a->sums + first + l;
    sums[SPHI_SUM_N * a->n] = (double)s->n[l];
    sums[SPHI_SUM_GAMMA * a->n] = (double)s->gamma[l];
    sums[SPHI_SUM_W * a->n] = (double)s->w[l];
    for (int f = 0; f <= dim; f++) sums[(SPHI_SUM_F + f) * a->n] = (double)s->f[f][l];
    for (int d = 0; d < dim; d++) sums[(SPHI_SUM_X(dim) + d) * a->n] = (double)s->x[d][l];
  }
}

#include "sweep/pair_loop.inc.c"
