/* Wendland's C4 polynomial, support 2 h; a = (1 - q/2)+.
 *
 *     2D, 3D  f = a^6 (1 + 3 q + 35/12 q^2)    f'/q = -14/3 (1 + 5/2 q) a^5
 *     1D      f = a^5 (1 + 5/2 q + 2 q^2)      f'/q = -7/2 (1 + 2 q) a^4
 *
 * Source: Wendland (1995), doi:10.1007/BF02123482; Dehnen and Aly (2012),
 * doi:10.1111/j.1365-2966.2012.21439.x, table 1, there with the support as unit; differs: none
 */
#ifndef SPHI_WENDLAND_C4_H
#define SPHI_WENDLAND_C4_H

#include "kernel/kernel_lanes.h"

SPHI_INLINE double sphi_wendland_c4_sigma(int dim) {
  const double pi = 3.14159265358979323846;
  return dim == 1 ? 3.0 / 4 : dim == 2 ? 9 / (4 * pi) : 495 / (256 * pi);
}

/* f(q) */
SPHI_INLINE vreal sphi_wendland_c4_f(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(1 - (real)0.5 * q), a2 = a * a, a4 = a2 * a2;
  if (dim == 1) return a4 * a * (1 + (real)2.5 * q + 2 * q2);
  return a4 * a2 * (1 + 3 * q + (real)(35.0 / 12) * q2);
}

/* f'(q)/q = slope g(q) */
SPHI_INLINE double sphi_wendland_c4_slope(int dim) { return dim == 1 ? -7.0 / 2 : -14.0 / 3; }

SPHI_INLINE vreal sphi_wendland_c4_g(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(1 - (real)0.5 * q), a2 = a * a, a4 = a2 * a2;
  if (dim == 1) return a4 * (1 + 2 * q);
  return a4 * a * (1 + (real)2.5 * q);
}

#endif
