/* Gaussian cut at Q h and shifted so that it ends at zero, Q = 3.
 *
 *     f = exp(-q^2) - exp(-Q^2)    f'/q = -2 exp(-q^2)    (q < Q; f' ends with a jump of 7.4e-4)
 *     1/sigma = sqrt(pi) erf(Q) - 2 Q exp(-Q^2)                                       (1D)
 *               pi (1 - (1 + Q^2) exp(-Q^2))                                          (2D)
 *               pi^(3/2) erf(Q) - (2 pi Q + 4/3 pi Q^3) exp(-Q^2)                     (3D)
 *
 * Source: Huang et al. (2019), eq. (7); differs: that is the 2D form, 1D and 3D derived likewise
 */
#ifndef SPHI_GAUSSIAN_H
#define SPHI_GAUSSIAN_H

#include "kernel/kernel_lanes.h"

SPHI_INLINE double sphi_gaussian_sigma(int dim) {
  const double pi = 3.14159265358979323846, cut = 3, end = exp(-cut * cut);
  if (dim == 1) return 1 / (sqrt(pi) * erf(cut) - 2 * cut * end);
  if (dim == 2) return 1 / (pi * (1 - (1 + cut * cut) * end));
  return 1 / (pi * (sqrt(pi) * erf(cut) - (2 + 4.0 / 3 * cut * cut) * cut * end));
}

/* f(q) */
SPHI_INLINE vreal sphi_gaussian_f(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim, (void)k;
  return v_where(q2 < 9, v_exp_minus_to_9(q2) - (real)1.2340980408667956e-4);
}

/* f'(q)/q = slope g(q) */
SPHI_INLINE double sphi_gaussian_slope(int dim) {
  (void)dim;
  return -2;
}

SPHI_INLINE vreal sphi_gaussian_g(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim, (void)k;
  return v_where(q2 < 9, v_exp_minus_to_9(q2));
}

#endif
