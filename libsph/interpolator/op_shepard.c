/* Improved Shepard interpolation, Huang et al. (2019) eq. (19)-(20) with the lost exponential:
 *
 *   w = (r/R)^-mu exp(-mu (r/a)^2 / (1 - (r/R)^lambda))    r < R                                  (1)
 *
 * The constant factor R^mu keeps w free of units. A particle nearer than 1e-6 R gets the largest
 * weight whatever mu is, and is returned as it is. Here lambda is 2, and mu is 2 or 4; op_shepard_any.c has
 * the rest.
 */
#define OPERATOR shepard
#include "sweep/pair.h"

#include "interpolator/ops.h"
#include "interpolator/power.h"

typedef struct op_targets {
  real inverse_radius2, attenuation;
  real rest_min; /* of 1 - (r/R)^2, where the exponent is as large as it may be */
  bool square;   /* mu is 4 */
} op_targets;

/* The weight of the last source is power exp(-exponent). It is added one source later: processors do not
 * see far enough to do something else while they wait for the steps of the exponential. */
typedef struct op_sums {
  vreal n, gamma, w, f[4], x[3];
  vreal power, exponent, dx[3];
  const real *source; /* NULL: there is none yet */
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)dim, (void)record, (void)stride, (void)first;
  t->inverse_radius2 = (real)a->inverse_radius2;
  t->attenuation = (real)a->attenuation;
  t->rest_min = (real)fmax(a->attenuation / LARGEST_EXPONENT, (double)ROUNDING);
  t->square = a->mu_half == 2;
}

SPHI_INLINE void add_last(const int dim, const real *source, op_sums *s) {
  const vreal w = s->power * v_exp_minus(s->exponent);
  s->w += w;
  for (int f = 0; f <= dim; f++) s->f[f] += w * source[SPHI_RECORD_F(dim) + f];
  for (int d = 0; d < dim; d++) s->x[d] += w * s->dx[d];
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  s->n += v_where(g->inside, v_set(1));
  s->gamma += g->w * source[SPHI_RECORD_V(dim)];
  /* Limits by the larger of two, which costs less than a choice. */
  const real least = (real)1e-12;
  const vreal q2 = g->r2 * t->inverse_radius2; /* (r/R)^2 */
  const vreal off = v_positive(q2 - least) + least;
  const vreal rest = v_positive((1 - t->rest_min) - q2) + t->rest_min;
  const vreal inverse = v_reciprocal(off * rest);
  const vreal steep = inverse * rest;
  /* Zero outside, since the exponential of just anything may be a denormal number, which is slow. */
  const vreal exponent = v_where(g->inside, (t->attenuation * off) * (off * inverse));
  const vreal power = t->square ? steep * steep : v_select(q2 > least, steep, v_set(LARGEST));
  add_last(dim, s->source ? s->source : source, s);
  s->exponent = exponent;
  s->power = v_where(g->inside, power); /* (1) */
  for (int d = 0; d < dim; d++) s->dx[d] = g->dx[d];
  s->source = source;
}
#define op_pair_second op_pair

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  op_sums all = *s;
  if (all.source) add_last(dim, all.source, &all);
  op_put_mean(a, dim, first, count, all.n, all.gamma, all.w, all.f, all.x);
}

#include "sweep/pair_loop.inc.c"
