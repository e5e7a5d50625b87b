/* Shepard's interpolation, Huang et al. (2019) eq. (17)-(18), cut off at the support:
 *
 *   w = (r/R)^-mu    r < R                                                                          (1)
 */
#define OPERATOR classic_shepard
#include "sweep/pair.h"

#include "interpolator/ops.h"
#include "interpolator/power.h"

typedef struct op_targets {
  real inverse_radius2, mu_half;
} op_targets;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)dim, (void)record, (void)stride, (void)first;
  t->inverse_radius2 = (real)a->inverse_radius2;
  t->mu_half = (real)a->mu_half;
}

SPHI_INLINE vreal op_weight(const int dim, const op_targets *t, const real *source, const pair *g) {
  (void)dim, (void)source;
  const vreal q2 = g->r2 * t->inverse_radius2; /* (r/R)^2 */
  const vreal distance = power(q2, t->mu_half);
  const vint far = power_is_far(q2, distance);
  return v_where(g->inside, v_select(far, 1 / distance, v_set(LARGEST))); /* (1) */
}

#include "interpolator/weighted.inc.c"
