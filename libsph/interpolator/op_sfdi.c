/* Simplified finite difference interpolation, Huang et al. (2019) eq. (11)-(12), with i the particle
 * nearest to the point x, d = x_j - x_i, q = W(|d|)/|d|^2 and R0 = sum W (x_j - x) / sum W:
 *
 *   I[f] = sum W f / sum W - R0 . g,   g = A^-1 b,                                                  (1)
 *   A = sum q d (x) d,   b = sum q (f_j - f_i) d                                                    (2)
 *
 * which is exact for linear fields (Ma 2008). As printed, A is its diagonal alone. x_i and f_i come
 * from op_nearest.
 *
 * With z = A^-1 R0 the weights are W_j / sum W - q z . d for j other than i, and what makes their sum 1
 * for i. By the inequality of Cauchy and Schwarz
 *
 *   sum |phi| <= 1 + 2 sum q |z . d| <= 1 + 2 sqrt(sum q  z . A z)                                  (3)
 */
#define OPERATOR sfdi
#include "sweep/pair.h"

#include "interpolator/ops.h"

typedef struct op_targets {
  vreal x[3], f[4]; /* x - x_i, f_i */
  real coincident2;
} op_targets;

typedef struct op_sums {
  vreal n, gamma, w, f[4], x[3], q, a[6], b[4][3];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)record, (void)stride;
  t->coincident2 = (real)(1e-12 / a->inverse_radius2);
  for (int l = 0; l < SPHI_LANES; l++) {
    for (int d = 0; d < dim; d++) t->x[d][l] = (real)a->to->nearest[d * a->to->n + first + l];
    for (int f = 0; f <= dim; f++)
      t->f[f][l] = (real)a->to->nearest[(dim + f) * a->to->n + first + l];
  }
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  vreal d[SPHI_MAX_DIM], d2 = v_set(0);
  for (int e = 0; e < dim; e++) {
    d[e] = t->x[e] - g->dx[e];
    d2 += d[e] * d[e];
  }
  const vreal w = v_where(g->inside, g->w);
  const vreal q = v_where(g->inside & (d2 > t->coincident2), pair_w(g, d2) / d2);
  s->n += v_where(g->inside, v_set(1));
  s->gamma += w * source[SPHI_RECORD_V(dim)];
  s->w += w;
  s->q += q;
  for (int e = 0; e < dim; e++) s->x[e] += w * g->dx[e];
  int product = 0;
  for (int e = 0; e < dim; e++)
    for (int c = e; c < dim; c++) s->a[product++] += q * d[e] * d[c];
  for (int f = 0; f <= dim; f++) {
    const real value = source[SPHI_RECORD_F(dim) + f];
    s->f[f] += w * value;
    for (int e = 0; e < dim; e++) s->b[f][e] += q * (value - t->f[f]) * d[e];
  }
}
#define op_pair_second op_pair

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  vwide full[3][3], m[9], z[3], r0[3];
  int product = 0;
  for (int e = 0; e < dim; e++)
    for (int c = e; c < dim; c++) full[e][c] = full[c][e] = v_widen(s->a[product++]);
  for (int e = 0; e < dim; e++)
    for (int c = 0; c < dim; c++) m[e * dim + c] = a->printed && e != c ? (vwide){0} : full[e][c];
  op_results r = {.carried = op_factorise(dim, m, a->pivot_min) & (v_widen(s->w) > 0) &
                             (v_widen(s->gamma) >= a->gamma_min) &
                             (v_widen(s->n) >= (double)a->neighbours_min)};
  const vwide inverse = 1 / v_widen(s->w);
  for (int e = 0; e < dim; e++) z[e] = r0[e] = -v_widen(s->x[e]) * inverse;
  op_solve(dim, m, z);
  vwide spread = {0}; /* z . A z */
  for (int e = 0; e < dim; e++) {
    r.moment[e] = r0[e];
    for (int c = 0; c < dim; c++) {
      spread += z[e] * full[e][c] * z[c];
      r.moment[e] -= z[c] * full[c][e];
    }
  }
  const double most = (a->lebesgue_max - 1) / 2;
  r.carried &= v_widen(s->q) * spread <= most * most; /* (3) */
  for (int f = 0; f <= dim; f++) {
    r.value[f] = v_widen(s->f[f]) * inverse;
    for (int e = 0; e < dim; e++) {
      r.gradient[f][e] = v_widen(s->b[f][e]);
      r.value[f] -= z[e] * r.gradient[f][e];
    }
    if (a->to->gradient) op_solve(dim, m, r.gradient[f]);
  }
  op_put(a, dim, first, count, s->n, s->gamma, &r);
}

#include "sweep/pair_loop.inc.c"
