/* Wendland's C2 polynomial, support 2 h; a = (1 - q/2)+.
 *
 *     2D, 3D  f = a^4 (1 + 2 q)      f'/q = -5 a^3
 *     1D      f = a^3 (1 + 3/2 q)    f'/q = -3 a^2
 *
 * Source: Wendland (1995), doi:10.1007/BF02123482; Dehnen and Aly (2012),
 * doi:10.1111/j.1365-2966.2012.21439.x, table 1, there with the support as unit; differs: none
 */
#ifndef SPHI_WENDLAND_C2_H
#define SPHI_WENDLAND_C2_H

#include "kernel/kernel_lanes.h"

SPHI_INLINE double sphi_wendland_c2_sigma(int dim) {
  const double pi = 3.14159265358979323846;
  return dim == 1 ? 5.0 / 8 : dim == 2 ? 7 / (4 * pi) : 21 / (16 * pi);
}

/* f(q) */
SPHI_INLINE vreal sphi_wendland_c2_f(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(1 - (real)0.5 * q);
  if (dim == 1) return a * a * a * (1 + (real)1.5 * q);
  const vreal a2 = a * a;
  return a2 * a2 * (1 + 2 * q);
}

/* f'(q)/q = slope g(q) */
SPHI_INLINE double sphi_wendland_c2_slope(int dim) { return dim == 1 ? -3 : -5; }

SPHI_INLINE vreal sphi_wendland_c2_g(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)k;
  const vreal a = v_positive(1 - (real)0.5 * v_sqrt(q2));
  return dim == 1 ? a * a : a * a * a;
}

#endif
