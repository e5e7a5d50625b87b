/* Moving least squares, Huang et al. (2019) eq. (8)-(9). With X = (x_j - x)/h and the basis b of all
 * products of its components up to degree ORDER:
 *
 *   I[f] = z . sum W V b f,   (sum W V b b) z = (1, 0, ...)                                         (1)
 *
 * Moments and right-hand sides are summed in one pass. With phi_j = (z . b_j) W_j V_j the inequality of
 * Cauchy and Schwarz gives
 *
 *   (sum |phi|)^2 <= sum W V sum W V (z . b)^2 = sum W V z_0                                        (2)
 *
 * Before: OPERATOR, ORDER (1 or 2).
 *
 * The products of one degree are sorted so that those of the next are X times all of them, Y times
 * those without X, Z times the last: XX XY XZ YY YZ ZZ.
 */
#include "sweep/pair.h"

#include "interpolator/ops.h"

/* Products of up to `degree` factors of dim. */
#define PRODUCTS(dim, degree)                       \
  ((dim) == 2 ? ((degree) + 1) * ((degree) + 2) / 2 \
              : ((degree) + 1) * ((degree) + 2) * ((degree) + 3) / 6)
#define BASIS(dim) PRODUCTS(dim, ORDER)
#define MOMENTS(dim) PRODUCTS(dim, 2 * ORDER)

typedef struct op_targets {
  real inverse_h;
} op_targets;

typedef struct op_sums {
  vreal n, moment[MOMENTS(3)], field[4][BASIS(3)];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)dim, (void)record, (void)stride, (void)first;
  t->inverse_h = (real)a->inverse_h;
}

/* product[to..] = x product[from..] */
SPHI_INLINE void op_times(vreal *product, int to, int from, const int count, vreal x) {
  for (int k = 0; k < count; k++) product[to + k] = x * product[from + k];
}

/* All products, each times product[0]. */
SPHI_INLINE void op_products(const int dim, const vreal *x, vreal *product) {
  if (dim == 2) {
    op_times(product, 1, 0, 1, x[0]);
    op_times(product, 2, 0, 1, x[1]);
    op_times(product, 3, 1, 2, x[0]);
    op_times(product, 5, 2, 1, x[1]);
#if ORDER == 2
    op_times(product, 6, 3, 3, x[0]);
    op_times(product, 9, 5, 1, x[1]);
    op_times(product, 10, 6, 4, x[0]);
    op_times(product, 14, 9, 1, x[1]);
#endif
    return;
  }
  op_times(product, 1, 0, 1, x[0]);
  op_times(product, 2, 0, 1, x[1]);
  op_times(product, 3, 0, 1, x[2]);
  op_times(product, 4, 1, 3, x[0]);
  op_times(product, 7, 2, 2, x[1]);
  op_times(product, 9, 3, 1, x[2]);
#if ORDER == 2
  op_times(product, 10, 4, 6, x[0]);
  op_times(product, 16, 7, 3, x[1]);
  op_times(product, 19, 9, 1, x[2]);
  op_times(product, 20, 10, 10, x[0]);
  op_times(product, 30, 16, 4, x[1]);
  op_times(product, 34, 19, 1, x[2]);
#endif
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  vreal x[SPHI_MAX_DIM], product[MOMENTS(3)];
  for (int d = 0; d < dim; d++) x[d] = -g->dx[d] * t->inverse_h;
  product[0] = g->w * source[SPHI_RECORD_V(dim)];
  op_products(dim, x, product);
  s->n += v_where(g->inside, v_set(1));
  for (int k = 0; k < MOMENTS(dim); k++) s->moment[k] += product[k];
  for (int f = 0; f <= dim; f++) {
    const real value = source[SPHI_RECORD_F(dim) + f];
    for (int k = 0; k < BASIS(dim); k++) s->field[f][k] += product[k] * value;
  }
}
#define op_pair_second op_pair

/* Where the product of b[i] and b[j] is among the moments. */
SPHI_INLINE int op_moment(const int dim, int i, int j) {
  static const int8_t power[2][BASIS(3)][3] = {
#if ORDER == 1
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}
#else
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {1, 1, 0}, {0, 2, 0}},
    {{0, 0, 0},
     {1, 0, 0},
     {0, 1, 0},
     {0, 0, 1},
     {2, 0, 0},
     {1, 1, 0},
     {1, 0, 1},
     {0, 2, 0},
     {0, 1, 1},
     {0, 0, 2}}
#endif
  };
  const int8_t *a = power[dim - 2][i], *b = power[dim - 2][j];
  const int y = a[1] + b[1], z = a[2] + b[2], rest = y + z, degree = a[0] + b[0] + rest;
  const int place = dim == 2 ? y : rest * (rest + 1) / 2 + z;
  return (degree == 0 ? 0 : PRODUCTS(dim, degree - 1)) + place;
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  const int size = BASIS(dim);
  const vwide gamma = v_widen(s->moment[0]), inverse = 1 / gamma;
  vwide m[BASIS(3) * BASIS(3)], z[BASIS(3)];
  for (int i = 0; i < size; i++)
    for (int j = 0; j <= i; j++)
      m[i * size + j] = v_widen(s->moment[op_moment(dim, i, j)]) * inverse;
  op_results r = {.carried = op_factorise(size, m, a->pivot_min) & (gamma >= a->gamma_min) &
                             (v_widen(s->n) >= (double)a->neighbours_min)};
  for (int d = 0; d <= (a->to->gradient ? dim : 0); d++) {
    for (int k = 0; k < size; k++) z[k] = (vwide){0} + (k == d);
    op_solve(size, m, z);
    if (d == 0) r.carried &= z[0] <= a->lebesgue_max * a->lebesgue_max; /* (2) */
    for (int f = 0; f <= dim; f++) {
      vwide sum = {0};
      for (int k = 0; k < size; k++) sum += z[k] * v_widen(s->field[f][k]);
      if (d == 0)
        r.value[f] = sum * inverse;
      else
        r.gradient[f][d - 1] = sum * inverse * a->inverse_h;
    }
  }
  op_put(a, dim, first, count, s->n, s->moment[0], &r);
}

#include "sweep/pair_loop.inc.c"
