/* Quintic B-spline M6, support 3 h.
 *
 *     f = (3 - q)+^5 - 6 (2 - q)+^5 + 15 (1 - q)+^5
 *     f'/q = -120 + 120 q^2 - 50 q^3  (q < 1),  (-5 (3 - q)+^4 + 30 (2 - q)+^4) / q  (q >= 1)
 *
 * Source: Morris, Fox and Zhu (1997), doi:10.1006/jcph.1997.5776; differs: none
 */
#ifndef SPHI_QUINTIC_SPLINE_H
#define SPHI_QUINTIC_SPLINE_H

#include "kernel/kernel_lanes.h"

SPHI_INLINE double sphi_quintic_spline_sigma(int dim) {
  const double pi = 3.14159265358979323846;
  return dim == 1 ? 1.0 / 120 : dim == 2 ? 7 / (478 * pi) : 1 / (120 * pi);
}

/* f(q) */
SPHI_INLINE vreal sphi_quintic_spline_f(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim, (void)k;
  const vreal q = v_sqrt(q2);
  const vreal a = v_positive(3 - q), b = v_positive(2 - q), c = v_positive(1 - q);
  const vreal a2 = a * a, b2 = b * b, c2 = c * c;
  return a2 * a2 * a - 6 * (b2 * b2 * b) + 15 * (c2 * c2 * c);
}

/* f'(q)/q = slope g(q) */
SPHI_INLINE double sphi_quintic_spline_slope(int dim) {
  (void)dim;
  return -5;
}

SPHI_INLINE vreal sphi_quintic_spline_g(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim, (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(3 - q), b = v_positive(2 - q);
  const vreal a2 = a * a, b2 = b * b;
  const vint inner = q2 < 1;
  /* The divisor is kept away from zero where the quotient is not used. */
  const vreal outer = (a2 * a2 - 6 * (b2 * b2)) / v_select(inner, v_set(1), q);
  return v_select(inner, 24 - q2 * (24 - 10 * q), outer);
}

#endif
