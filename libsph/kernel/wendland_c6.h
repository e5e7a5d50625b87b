/* Wendland's C6 polynomial, support 2 h; a = (1 - q/2)+.
 *
 *     2D, 3D  f = a^8 (1 + 4 q + 25/4 q^2 + 4 q^3)
 *             f'/q = -11/2 (1 + 7/2 q + 4 q^2) a^7
 *     1D      f = a^7 (1 + 7/2 q + 19/4 q^2 + 21/8 q^3)
 *             f'/q = -3/2 (3 + 9 q + 35/4 q^2) a^6
 *
 * Source: Wendland (1995), doi:10.1007/BF02123482; Dehnen and Aly (2012),
 * doi:10.1111/j.1365-2966.2012.21439.x, table 1, there with the support as unit; differs: none
 */
#ifndef SPHI_WENDLAND_C6_H
#define SPHI_WENDLAND_C6_H

#include "kernel/kernel_lanes.h"

SPHI_INLINE double sphi_wendland_c6_sigma(int dim) {
  const double pi = 3.14159265358979323846;
  return dim == 1 ? 55.0 / 64 : dim == 2 ? 39 / (14 * pi) : 1365 / (512 * pi);
}

/* f(q) */
SPHI_INLINE vreal sphi_wendland_c6_f(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(1 - (real)0.5 * q), a2 = a * a, a4 = a2 * a2;
  if (dim == 1) return a4 * a2 * a * (1 + (real)3.5 * q + q2 * ((real)4.75 + (real)2.625 * q));
  return a4 * a4 * (1 + 4 * q + q2 * ((real)6.25 + 4 * q));
}

/* f'(q)/q = slope g(q) */
SPHI_INLINE double sphi_wendland_c6_slope(int dim) { return dim == 1 ? -9.0 / 2 : -11.0 / 2; }

SPHI_INLINE vreal sphi_wendland_c6_g(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)k;
  const vreal q = v_sqrt(q2), a = v_positive(1 - (real)0.5 * q), a2 = a * a, a4 = a2 * a2;
  if (dim == 1) return a4 * a2 * (1 + 3 * q + (real)(35.0 / 12) * q2);
  return a4 * a2 * a * (1 + (real)3.5 * q + 4 * q2);
}

#endif
