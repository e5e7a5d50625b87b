/* Cubic B-spline M4, support 2 h.
 *
 *     f = (2 - q)+^3 / 4 - (1 - q)+^3
 *     f'/q = -3 + 9/4 q  (q < 1),  -3/4 (2 - q)+^2 / q  (q >= 1)
 *
 * Source: Monaghan and Lattanzio (1985), A&A 149, 135; differs: none
 */
#ifndef SPHI_CUBIC_SPLINE_H
#define SPHI_CUBIC_SPLINE_H

#include "kernel/kernel_lanes.h"

SPHI_INLINE double sphi_cubic_spline_sigma(int dim) {
  const double pi = 3.14159265358979323846;
  return dim == 1 ? 2.0 / 3 : dim == 2 ? 10 / (7 * pi) : 1 / pi;
}

/* f(q) */
SPHI_INLINE vreal sphi_cubic_spline_f(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim, (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(2 - q), b = v_positive(1 - q);
  return (real)0.25 * a * a * a - b * b * b;
}

/* f'(q)/q = slope g(q) */
SPHI_INLINE double sphi_cubic_spline_slope(int dim) {
  (void)dim;
  return -3;
}

SPHI_INLINE vreal sphi_cubic_spline_g(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim, (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(2 - q);
  const vint inner = q2 < 1;
  /* The divisor is kept away from zero where the quotient is not used. */
  const vreal outer = (real)0.25 * a * a / v_select(inner, v_set(1), q);
  return v_select(inner, 1 - (real)0.75 * q, outer);
}

#endif
