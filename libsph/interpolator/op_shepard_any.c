/* The weights of op_shepard.c with any exponents and scale. */
#define OPERATOR shepard_any
#include "sweep/pair.h"

#include "interpolator/ops.h"
#include "interpolator/power.h"

typedef struct op_targets {
  real inverse_radius2, mu_half, lambda_half, attenuation;
} op_targets;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)dim, (void)record, (void)stride, (void)first;
  t->inverse_radius2 = (real)a->inverse_radius2;
  t->mu_half = (real)a->mu_half;
  t->lambda_half = (real)a->lambda_half;
  t->attenuation = (real)a->attenuation;
}

SPHI_INLINE vreal op_weight(const int dim, const op_targets *t, const real *source, const pair *g) {
  (void)dim, (void)source;
  const vreal q2 = g->r2 * t->inverse_radius2; /* (r/R)^2 */
  const vreal distance = power(q2, t->mu_half);
  /* At the rim rounding may leave nothing of it, or less. */
  const vreal left = 1 - power(q2, t->lambda_half);
  const vreal rest = v_select(left > ROUNDING, left, v_set(ROUNDING));
  const vreal inverse = 1 / (distance * rest); /* one division for two */
  const vint far = power_is_far(q2, distance);
  const vreal exponent = v_where(far, t->attenuation * q2 * inverse * distance);
  const vint moderate = g->inside & (exponent < LARGEST_EXPONENT);
  const vreal attenuation = v_exp_minus(v_select(moderate, exponent, v_set(LARGEST_EXPONENT)));
  return v_where(g->inside, v_select(far, inverse * rest, v_set(LARGEST)) * attenuation); /* (1) */
}

#include "interpolator/weighted.inc.c"
