/* What a pair function sees: W targets as vectors, one source as scalars, and their geometry.
 * Included by op_*.c files only. */
#ifndef SPHI_PAIR_H
#define SPHI_PAIR_H

#include "kernel/kernel_list.h"
#include "sweep/variant.h"
#include "sweep/vreal.h"

#if SPHI_DOUBLE
typedef double fixed;
typedef vreal vfixed;
#else
typedef uint32_t fixed;
typedef uint32_t vfixed __attribute__((vector_size(sizeof(real) * SPHI_LANES)));
#endif

/* Constants of one sweep, in the loop's arithmetic. */
typedef struct pair_constants {
  real unit[SPHI_MAX_DIM];   /* float: metres a fixed-point step */
  real period[SPHI_MAX_DIM]; /* double: periods and their inverses, 0 where not periodic */
  real inverse_period[SPHI_MAX_DIM];
  real inverse_h2;
  real norm_w, norm_g; /* W = norm_w f(q), (dW/dr)/r = norm_g f'(q)/q */
  real radius2;
  sphi_kernel_lanes lanes;
} pair_constants;

typedef struct pair {
  vreal dx[SPHI_MAX_DIM]; /* x_i - x_j */
  vreal r2;
  vreal w;     /* W(r) */
  vreal gw;    /* (dW/dr)/r: grad_i W_ij = gw dx */
  vint inside; /* all ones where r is below the support */
  int kernel, dim;
  const pair_constants *constants;
} pair;

SPHI_INLINE vreal kernel_f(const int kernel, vreal q2, const int dim, const sphi_kernel_lanes *k) {
  switch (kernel) {
#define KERNEL_CASE(id, enumerator, stem, name, ratio, summary, source) \
  case id: return sphi_##stem##_f(q2, dim, k);
    SPHI_KERNEL_LIST(KERNEL_CASE)
#undef KERNEL_CASE
  }
  return q2;
}

SPHI_INLINE vreal kernel_g(const int kernel, vreal q2, const int dim, const sphi_kernel_lanes *k) {
  switch (kernel) {
#define KERNEL_CASE(id, enumerator, stem, name, ratio, summary, source) \
  case id: return sphi_##stem##_g(q2, dim, k);
    SPHI_KERNEL_LIST(KERNEL_CASE)
#undef KERNEL_CASE
  }
  return q2;
}

/* Difference of positions; periodic directions give the nearest image in both arithmetics. */
SPHI_INLINE vreal pair_difference(vfixed xi, fixed xj, const pair_constants *c, const int d) {
#if SPHI_DOUBLE
  const vreal dx = xi - xj;
  vreal image = dx * c->inverse_period[d];
  for (int l = 0; l < SPHI_LANES; l++) image[l] = rint(image[l]);
  return dx - image * c->period[d];
#else
  return __builtin_convertvector((vint)(xi - xj), vreal) * c->unit[d];
#endif
}

SPHI_INLINE void pair_geometry(const int kernel, const int dim, const pair_constants *c,
                               const vfixed *xi, const real *source, pair *g) {
  fixed xj[SPHI_MAX_DIM];
  memcpy(xj, source, sizeof(real) * (size_t)dim);
  g->r2 = v_set(0);
  for (int d = 0; d < dim; d++) {
    g->dx[d] = pair_difference(xi[d], xj[d], c, d);
    g->r2 += g->dx[d] * g->dx[d];
  }
  const vreal q2 = g->r2 * c->inverse_h2;
  g->inside = g->r2 < c->radius2;
  g->kernel = kernel;
  g->dim = dim;
  g->constants = c;
  g->w = c->norm_w * kernel_f(kernel, q2, dim, &c->lanes);
  g->gw = c->norm_g * kernel_g(kernel, q2, dim, &c->lanes);
}

/* The pair's kernel at another squared distance. */
SPHI_INLINE vreal pair_w(const pair *g, vreal r2) {
  const pair_constants *c = g->constants;
  return c->norm_w * kernel_f(g->kernel, r2 * c->inverse_h2, g->dim, &c->lanes);
}

SPHI_INLINE void pair_constants_set(pair_constants *c, const sphi_sweep *sweep) {
  const sph_kernel *kernel = sweep->kernel;
  const double h = kernel->h;
  for (int d = 0; d < sweep->frame->dim; d++) {
    c->unit[d] = (real)sweep->frame->unit[d];
    c->period[d] = (real)sweep->frame->length[d];
    c->inverse_period[d] = sweep->frame->periodic[d] ? (real)(1 / sweep->frame->length[d]) : 0;
  }
  c->inverse_h2 = (real)(1 / (h * h));
  c->norm_w = (real)kernel->norm_w;
  c->norm_g = (real)kernel->norm_g;
  c->radius2 = (real)(kernel->support * kernel->support);
  c->lanes = sphi_kernel_lanes_of(kernel);
}

/* Lanes of one value of consecutive records; lanes past the cluster's end read the padding. */
SPHI_INLINE vreal pair_lanes(const real *record, const int stride, const int at) {
  vreal x;
  for (int l = 0; l < SPHI_LANES; l++) x[l] = record[l * stride + at];
  return x;
}

#endif
