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

/* How an operator sees lengths and slopes. Physics in few words wants metres; the loops that take most
 * of a step do without the factors that are the same for all pairs, and put them in at the end:
 *   PAIR_METRES  dx in metres, gw = (dW/dr)/r
 *   PAIR_BARE    dx in units of `length`, gw without its factor `slope`
 *   PAIR_SCALED  the same where directions are periodic, which have fixed-point units of their own */
enum { PAIR_METRES, PAIR_BARE, PAIR_SCALED };

/* Constants of one sweep, in the loop's arithmetic; lengths in the operator's units. */
typedef struct pair_constants {
  real unit[SPHI_MAX_DIM];   /* float: lengths a fixed-point step */
  real period[SPHI_MAX_DIM]; /* double: periods and their inverses, 0 where not periodic */
  real inverse_period[SPHI_MAX_DIM];
  real inverse_h2;
  real norm_w, norm_g; /* W = norm_w f(q), gw = norm_g g(q) */
  real radius2;
  real per_metre; /* lengths a metre */
  real prune2;
  sphi_kernel_lanes lanes;
} pair_constants;

/* What turns bare sums into those of metres: 1 where they are already. */
typedef struct pair_units {
  double length, slope;
} pair_units;

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
SPHI_INLINE vreal pair_difference(vfixed xi, fixed xj, const int view, const pair_constants *c,
                                  const int d) {
#if SPHI_DOUBLE
  const vreal dx = xi - xj;
  if (view == PAIR_BARE) return dx;
  vreal image = dx * c->inverse_period[d];
  for (int l = 0; l < SPHI_LANES; l++) image[l] = rint(image[l]);
  return dx - image * c->period[d];
#else
  const vreal dx = __builtin_convertvector((vint)(xi - xj), vreal);
  return view == PAIR_BARE ? dx : dx * c->unit[d];
#endif
}

/* Where the source is: dx and r2. */
SPHI_INLINE void pair_place(const int dim, const int view, const pair_constants *c,
                            const vfixed *xi, const real *source, pair *g) {
  for (int d = 0; d < dim; d++) {
    fixed xj;
    memcpy(&xj, source + d, sizeof xj);
    g->dx[d] = pair_difference(xi[d], xj, view, c, d);
    g->r2 = d == 0 ? g->dx[d] * g->dx[d] : g->r2 + g->dx[d] * g->dx[d];
  }
}

/* What follows from that. */
SPHI_INLINE void pair_kernel(const int kernel, const int dim, const int view,
                             const pair_constants *c, pair *g) {
  const vreal q2 = g->r2 * c->inverse_h2;
  g->inside = g->r2 < c->radius2;
  g->kernel = kernel;
  g->dim = dim;
  g->constants = c;
  g->w = c->norm_w * kernel_f(kernel, q2, dim, &c->lanes);
  g->gw = kernel_g(kernel, q2, dim, &c->lanes);
  if (view == PAIR_METRES) g->gw *= c->norm_g;
}

/* The pair's kernel at another squared distance. */
SPHI_INLINE vreal pair_w(const pair *g, vreal r2) {
  const pair_constants *c = g->constants;
  return c->norm_w * kernel_f(g->kernel, r2 * c->inverse_h2, g->dim, &c->lanes);
}

/* grad_i W_ij V_j */
SPHI_INLINE void pair_gradient(const int dim, vreal gw, real volume, const pair *g,
                               vreal *gradient) {
  const vreal gwv = gw * volume;
  for (int d = 0; d < dim; d++) gradient[d] = gwv * g->dx[d];
}

SPHI_INLINE pair_units pair_constants_set(pair_constants *c, const int view,
                                          const sphi_sweep *sweep) {
  const sph_kernel *kernel = sweep->kernel;
  const bool bare = view != PAIR_METRES;
  const double length = bare && !SPHI_DOUBLE ? sweep->frame->step : 1;
  const double h = kernel->h / length, support = kernel->support / length;
  for (int d = 0; d < sweep->frame->dim; d++) {
    c->unit[d] = (real)(sweep->frame->unit[d] / length);
    c->period[d] = (real)sweep->frame->length[d];
    c->inverse_period[d] = sweep->frame->periodic[d] ? (real)(1 / sweep->frame->length[d]) : 0;
  }
  c->inverse_h2 = (real)(1 / (h * h));
  c->norm_w = (real)kernel->norm_w;
  c->norm_g = (real)kernel->norm_g;
  c->radius2 = (real)(support * support);
  c->per_metre = (real)(1 / length);
  const double prune = sweep->prune > 0 ? sweep->prune / length : HUGE_VAL;
  c->prune2 = (real)(prune * prune);
  c->lanes = sphi_kernel_lanes_of(kernel);
  return (pair_units){length, bare ? kernel->norm_g : 1};
}

/* `count` lanes from an array of doubles, the others `rest`. */
SPHI_INLINE vreal lanes_load(const double *from, int32_t count, real rest) {
  typedef double vdouble __attribute__((vector_size(sizeof(double) * SPHI_LANES)));
  vdouble x;
  if (count == SPHI_LANES)
    memcpy(&x, from, sizeof x);
  else
    for (int l = 0; l < SPHI_LANES; l++) x[l] = l < count ? from[l] : (double)rest;
  return __builtin_convertvector(x, vreal);
}

/* The first `count` lanes into an array. */
SPHI_INLINE void lanes_store(real *restrict to, int32_t count, vreal x) {
  if (count == SPHI_LANES)
    memcpy(to, &x, sizeof x);
  else
    for (int32_t l = 0; l < count; l++) to[l] = x[l];
}

/* Lanes of one value of consecutive records; lanes past the cluster's end read the padding. */
SPHI_INLINE vreal pair_lanes(const real *record, const int stride, const int at) {
  vreal x;
  for (int l = 0; l < SPHI_LANES; l++) x[l] = record[l * stride + at];
  return x;
}

#endif
