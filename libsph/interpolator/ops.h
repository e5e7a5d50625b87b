/* What the operators of interpolation share: arguments, and from sums to values for W targets. */
#ifndef SPHI_INTERPOLATOR_OPS_H
#define SPHI_INTERPOLATOR_OPS_H

#include "interpolator/interpolator_impl.h"

enum { SPHI_PENDING = 255 }; /* a rung: this target goes down the ladder */

typedef struct sphi_interpolation_arguments {
  const sphi_interpolation *to;
  uint8_t type;        /* the rung of targets that carry the method */
  bool again;          /* only targets whose rung is SPHI_PENDING */
  bool printed;        /* SFDI without cross terms */
  double gamma_min;    /* sum W V below which the method is not carried, */
  int neighbours_min;  /* neighbours, */
  double pivot_min;    /* smallest ratio of pivots, */
  double lebesgue_max; /* and bound of sum |phi| above which it is not */
  double inverse_h;
  double inverse_radius2;           /* Shepard: 1/R^2, */
  double mu_half;                   /* mu/2, */
  double lambda_half;               /* lambda/2, */
  double attenuation;               /* mu (R/a)^2 */
  sph_interpolator_weights weights; /* the caller's */
  void *user;
  double support;
} sphi_interpolation_arguments;

#ifdef SPHI_PAIR_H
typedef sphi_interpolation_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_RECORD(dim)

/* Sums are finished in double. */
typedef double vwide __attribute__((vector_size(sizeof(double) * SPHI_LANES)));
typedef int64_t vwide_mask __attribute__((vector_size(sizeof(double) * SPHI_LANES)));
SPHI_INLINE vwide v_widen(vreal x) { return __builtin_convertvector(x, vwide); }

SPHI_INLINE vwide v_wide_select(vwide_mask mask, vwide yes, vwide no) {
  return (vwide)(((vwide_mask)yes & mask) | ((vwide_mask)no & ~mask));
}

typedef struct op_results {
  vwide value[4];       /* dim + 1 fields */
  vwide moment[3];      /* sum phi (x_j - x_i) */
  vwide gradient[4][3]; /* where a->to->gradient is asked for and the method has them */
  vwide_mask carried;
} op_results;

/* Writes values[l] to out[l] where `open`, 0 where not `carried`. */
SPHI_INLINE void op_put_values(double *restrict out, int32_t count, const bool *open,
                               const bool *carried, const vwide *values) {
  for (int32_t l = 0; l < count; l++)
    if (open[l]) out[l] = carried[l] ? (*values)[l] : 0;
}

/* Writes what was found for `count` targets from `first` on. */
SPHI_INLINE void op_put(const op_arguments *a, const int dim, int32_t first, int32_t count, vreal n,
                        vreal gamma, const op_results *r) {
  const sphi_interpolation *to = a->to;
  const int64_t rows = to->n;
  uint8_t *restrict rung = to->rung + first;
  int32_t *restrict neighbours = to->neighbours + first;
  double *restrict sum = to->gamma + first;
  bool open[SPHI_LANES] = {false}, carried[SPHI_LANES] = {false};
  for (int32_t l = 0; l < count; l++) {
    open[l] = !a->again || rung[l] == SPHI_PENDING;
    carried[l] = r->carried[l] && n[l] > 0;
    for (int f = 0; f <= dim; f++) carried[l] = carried[l] && fabs(r->value[f][l]) < HUGE_VAL;
    if (!open[l]) continue;
    neighbours[l] = (int32_t)n[l];
    sum[l] = (double)gamma[l];
    rung[l] = n[l] == 0 ? 0 : carried[l] ? a->type : SPHI_PENDING;
  }
  for (int f = 0; f <= dim; f++)
    op_put_values(to->value + f * rows + first, count, open, carried, &r->value[f]);
  for (int f = 0; f <= dim && to->gradient; f++)
    for (int d = 0; d < dim; d++)
      op_put_values(to->gradient + (f * dim + d) * rows + first, count, open, carried,
                    &r->gradient[f][d]);
  if (!to->compensation) memset(carried, 0, sizeof carried);
  for (int d = 0; d < dim; d++)
    op_put_values(to->moment + d * rows + first, count, open, carried, &r->moment[d]);
}

/* The same of weighted means: f and x are sum w f and sum w (x_i - x_j), w is sum w. */
SPHI_INLINE void op_put_mean(const op_arguments *a, const int dim, int32_t first, int32_t count,
                             vreal n, vreal gamma, vreal w, const vreal *f, const vreal *x) {
  const vwide sum = v_widen(w), inverse = 1 / sum;
  op_results r = {.carried = (sum > 0) & (v_widen(gamma) >= a->gamma_min)};
  for (int k = 0; k <= dim; k++) r.value[k] = v_widen(f[k]) * inverse;
  for (int d = 0; d < dim; d++) r.moment[d] = -v_widen(x[d]) * inverse;
  op_put(a, dim, first, count, n, gamma, &r);
}

/* The symmetric matrix m[size][size], of which the lower triangle is given, becomes L D L^T in place: D
 * in the diagonal. False in lanes whose ratio of pivots is below pivot_min. */
SPHI_INLINE vwide_mask op_factorise(const int size, vwide *m, double pivot_min) {
  vwide largest = m[0], smallest = m[0];
  for (int j = 0; j < size; j++) {
    vwide *row = m + j * size;
    for (int k = 0; k < j; k++) row[j] -= row[k] * row[k] * m[k * size + k];
    const vwide pivot = row[j], inverse = 1 / pivot;
    largest = v_wide_select(pivot > largest, pivot, largest);
    smallest = v_wide_select(pivot < smallest, pivot, smallest);
    for (int i = j + 1; i < size; i++) {
      vwide *below = m + i * size;
      for (int k = 0; k < j; k++) below[j] -= below[k] * row[k] * m[k * size + k];
      below[j] *= inverse;
    }
  }
  return (smallest >= pivot_min * largest) & (largest > 0);
}

/* z becomes the solution of L D L^T x = z. */
SPHI_INLINE void op_solve(const int size, const vwide *m, vwide *z) {
  for (int i = 0; i < size; i++)
    for (int k = 0; k < i; k++) z[i] -= m[i * size + k] * z[k];
  for (int i = size - 1; i >= 0; i--) {
    z[i] /= m[i * size + i];
    for (int k = i + 1; k < size; k++) z[i] -= m[k * size + i] * z[k];
  }
}
#endif

#endif
