/* Improved Shepard interpolation, Huang et al. (2019) eq. (19)-(20) with the lost exponential:
 *
 *   w = (r/R)^-mu exp(-mu (r/a)^2 / (1 - (r/R)^lambda))    r < R                                  (1)
 *
 * The constant factor R^mu keeps w free of units. A particle nearer than 1e-6 R gets the largest
 * weight whatever mu is, and is returned as it is.
 */
#define OPERATOR shepard
#include "interpolator/ops.h"
#include "sweep/pair.h"

/* Weights from 1/LARGEST to LARGEST or so stay normal numbers when multiplied with any field. */
#if SPHI_DOUBLE
#define LARGEST ((real)1e150)
#define LARGEST_EXPONENT 600
#else
#define LARGEST ((real)1e24)
#define LARGEST_EXPONENT 60
#endif

typedef struct op_targets {
  real inverse_radius2, mu_half, lambda_half, attenuation;
} op_targets;

SPHI_INLINE void op_load(const sphi_interpolation_arguments *a, const int dim, const real *record,
                         const int stride, op_targets *t) {
  (void)dim, (void)record, (void)stride;
  t->inverse_radius2 = (real)a->inverse_radius2;
  t->mu_half = (real)a->mu_half;
  t->lambda_half = (real)a->lambda_half;
  t->attenuation = (real)a->attenuation;
}

/* t^exponent: the exponents of the literature without pow. */
SPHI_INLINE vreal power(vreal t, real exponent) {
  if (exponent == 1) return t;
  if (exponent == 2) return t * t;
  for (int l = 0; l < SPHI_LANES; l++) t[l] = (real)pow((double)t[l], (double)exponent);
  return t;
}

SPHI_INLINE vreal op_weight(const int dim, const op_targets *t, const real *source, const pair *g) {
  (void)dim, (void)source;
  const vreal q2 = g->r2 * t->inverse_radius2; /* (r/R)^2 */
  const vreal exponent = t->attenuation * q2 / (1 - power(q2, t->lambda_half));
  const vreal largest = v_set(LARGEST);
  const vreal inverse = 1 / power(q2, t->mu_half);
  const vint far = (q2 > (real)1e-12) & (inverse < largest);
  const vint moderate = g->inside & (exponent < LARGEST_EXPONENT);
  const vreal attenuation = v_exp_minus(v_select(moderate, exponent, v_set(LARGEST_EXPONENT)));
  return v_where(g->inside, v_select(far, inverse, largest) * attenuation); /* (1) */
}

#include "interpolator/weighted.inc.c"
