/* The nearest particle: its value, or where it is and what it carries for SFDI. Of several at the same
 * distance the first in the list counts. */
#define OPERATOR nearest
#include "sweep/pair.h"

#include "interpolator/ops.h"

typedef struct op_targets {
  int unused;
} op_targets;

typedef struct op_sums {
  vreal n, gamma, r2, x[3], f[4];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)dim, (void)record, (void)stride, (void)first;
  t->unused = 0;
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a, (void)t;
  const vint near = g->inside & ((s->n == 0) | (g->r2 < s->r2));
  s->n += v_where(g->inside, v_set(1));
  s->gamma += g->w * source[SPHI_RECORD_V(dim)];
  s->r2 = v_select(near, g->r2, s->r2);
  for (int d = 0; d < dim; d++) s->x[d] = v_select(near, g->dx[d], s->x[d]);
  for (int f = 0; f <= dim; f++)
    s->f[f] = v_select(near, v_set(source[SPHI_RECORD_F(dim) + f]), s->f[f]);
}
#define op_pair_second op_pair

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  op_results r = {.carried = v_widen(s->n) > 0};
  for (int f = 0; f <= dim; f++) r.value[f] = v_widen(s->f[f]);
  for (int d = 0; d < dim; d++) r.moment[d] = -v_widen(s->x[d]);
  op_put(a, dim, first, count, s->n, s->gamma, &r);
  double *nearest = a->to->nearest;
  for (int32_t l = 0; l < count && nearest; l++) {
    for (int d = 0; d < dim; d++) nearest[d * a->to->n + first + l] = (double)s->x[d][l];
    for (int f = 0; f <= dim; f++) nearest[(dim + f) * a->to->n + first + l] = (double)s->f[f][l];
  }
}

#include "sweep/pair_loop.inc.c"
