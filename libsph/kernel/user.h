/* A caller's kernel in the pair loops: piecewise cubics in q, see kernel_impl.h. */
#ifndef SPHI_USER_H
#define SPHI_USER_H

#include "kernel/kernel_lanes.h"

/* A caller's kernel brings its own normalisation. */
SPHI_INLINE double sphi_user_sigma(int dim) {
  (void)dim;
  return 1;
}

/* The piecewise cubic whose coefficients start at `first` in each row of the table. */
SPHI_INLINE vreal sphi_user_piece(vreal q2, const sphi_kernel_lanes *k, int first) {
  const vint inside = q2 < k->ratio2;
  const vreal position = k->segments_per_q * v_sqrt(v_where(inside, q2));
  vreal u, c0, c1, c2, c3;
  for (int l = 0; l < SPHI_LANES; l++) {
    int segment = (int)position[l];
    if (segment > SPHI_KERNEL_SEGMENTS - 1) segment = SPHI_KERNEL_SEGMENTS - 1;
    const real *c = k->table + 8 * segment + first;
    u[l] = position[l] - (real)segment;
    c0[l] = c[0], c1[l] = c[1], c2[l] = c[2], c3[l] = c[3];
  }
  return v_where(inside, c0 + u * (c1 + u * (c2 + u * c3)));
}

/* f(q) */
SPHI_INLINE vreal sphi_user_f(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim;
  return sphi_user_piece(q2, k, 0);
}

/* f'(q)/q = slope g(q) */
SPHI_INLINE double sphi_user_slope(int dim) {
  (void)dim;
  return 1;
}

SPHI_INLINE vreal sphi_user_g(vreal q2, int dim, const sphi_kernel_lanes *k) {
  (void)dim;
  return sphi_user_piece(q2, k, 4);
}

#endif
