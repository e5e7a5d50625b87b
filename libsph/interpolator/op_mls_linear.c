/* Moving least squares with the basis b = (1, x_j - x_i), Huang et al. (2019) eq. (8)-(9): the
 * moments sum W V b b and the right-hand sides sum W V b f. They are solved in interpolate.c. */
#define OPERATOR mls_linear
#include "interpolator/ops.h"
#include "sweep/pair.h"

typedef sphi_interpolation_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_RECORD(dim)

typedef struct op_targets {
  int unused;
} op_targets;

typedef struct op_sums {
  vreal n, gamma, d[3], dd[6], f[4], fd[4][3];
} op_sums;

SPHI_INLINE void op_load(const sphi_interpolation_arguments *a, const int dim, const real *record,
                         const int stride, op_targets *t) {
  (void)a, (void)dim, (void)record, (void)stride;
  t->unused = 0;
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a, (void)t;
  const vreal w = g->w * source[SPHI_RECORD_V(dim)];
  const real *f = source + SPHI_RECORD_F(dim);
  s->n += v_where(g->inside, v_set(1));
  s->gamma += w;
  for (int k = 0; k <= dim; k++) s->f[k] += w * f[k];
  int product = 0;
  for (int d = 0; d < dim; d++) {
    const vreal wd = w * g->dx[d];
    s->d[d] += wd;
    for (int e = d; e < dim; e++) s->dd[product++] += wd * g->dx[e];
    for (int k = 0; k <= dim; k++) s->fd[k][d] += wd * f[k];
  }
}
#define op_pair_second op_pair

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  for (int32_t l = 0; l < count; l++) {
    double *sums = a->sums + first + l;
    sums[SPHI_SUM_N * a->n] = (double)s->n[l];
    sums[SPHI_SUM_GAMMA * a->n] = (double)s->gamma[l];
    for (int d = 0; d < dim; d++) sums[(SPHI_SUM_D + d) * a->n] = (double)s->d[d][l];
    for (int e = 0; e < dim * (dim + 1) / 2; e++)
      sums[(SPHI_SUM_DD(dim) + e) * a->n] = (double)s->dd[e][l];
    for (int k = 0; k <= dim; k++) {
      double *field = sums + (SPHI_SUM_FD(dim) + k * (dim + 1)) * a->n;
      field[0] = (double)s->f[k][l];
      for (int d = 0; d < dim; d++) field[(1 + d) * a->n] = (double)s->fd[k][d][l];
    }
  }
}

#include "sweep/pair_loop.inc.c"
