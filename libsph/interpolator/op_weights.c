/* The caller's weights: neighbours are collected for each target and handed over. */
#define OPERATOR weights
#ifdef _OPENMP
#include <omp.h>
#endif

#include "sweep/pair.h"

#include "interpolator/ops.h"

typedef struct op_targets {
  int64_t room;
  double *offset[SPHI_LANES], *kernel[SPHI_LANES], *volume[SPHI_LANES], *field[SPHI_LANES],
      *weights[SPHI_LANES];
} op_targets;

typedef struct op_sums {
  vreal n, gamma;
} op_sums;

/* Every thread has room for the neighbours of W targets, see sphi_interpolation_reserve_list(). */
SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)record, (void)stride, (void)first;
  const int64_t room = a->to->room;
#ifdef _OPENMP
  const int64_t thread = omp_get_thread_num();
#else
  const int64_t thread = 0;
#endif
  double *next = a->to->collected + thread * SPHI_LANES * room * SPHI_COLLECTED(dim);
  for (int l = 0; l < SPHI_LANES; l++) {
    t->offset[l] = next;
    t->kernel[l] = t->offset[l] + room * dim;
    t->volume[l] = t->kernel[l] + room;
    t->field[l] = t->volume[l] + room;
    t->weights[l] = t->field[l] + room * (dim + 1);
    next = t->weights[l] + room;
  }
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  for (int l = 0; l < SPHI_LANES; l++) {
    if (!g->inside[l]) continue;
    const int64_t k = (int64_t)s->n[l];
    for (int d = 0; d < dim; d++) t->offset[l][k * dim + d] = -(double)g->dx[d][l];
    t->kernel[l][k] = (double)g->w[l];
    t->volume[l][k] = (double)source[SPHI_RECORD_V(dim)];
    for (int f = 0; f <= dim; f++)
      t->field[l][k * (dim + 1) + f] = (double)source[SPHI_RECORD_F(dim) + f];
  }
  s->n += v_where(g->inside, v_set(1));
  s->gamma += g->w * source[SPHI_RECORD_V(dim)];
}
#define op_pair_second op_pair

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  op_results r;
  memset(&r, 0, sizeof r);
  for (int l = 0; l < count; l++) {
    const int n = (int)s->n[l];
    if (n == 0 || !a->weights(dim, n, t->offset[l], t->kernel[l], t->volume[l], a->support,
                              t->weights[l], a->user))
      continue;
    r.carried[l] = -1;
    for (int k = 0; k < n; k++) {
      const double weight = t->weights[l][k];
      for (int f = 0; f <= dim; f++) r.value[f][l] += weight * t->field[l][k * (dim + 1) + f];
      for (int d = 0; d < dim; d++) r.moment[d][l] += weight * t->offset[l][k * dim + d];
    }
  }
  op_put(a, dim, first, count, s->n, s->gamma, &r);
}

#include "sweep/pair_loop.inc.c"
