/* Inverse powers of distances, as Shepard's weights have them. Included by op_*.c files only. */
#ifndef SPHI_POWER_H
#define SPHI_POWER_H

#include "sweep/vreal.h"

/* Weights from 1/LARGEST to LARGEST or so stay normal numbers when multiplied with any field. */
#if SPHI_DOUBLE
#define LARGEST ((real)1e150)
#define LARGEST_EXPONENT 600
#define ROUNDING ((real)1e-15)
#else
#define LARGEST ((real)1e24)
#define LARGEST_EXPONENT 60
#define ROUNDING ((real)1e-6)
#endif

/* Apart, because it would be stamped into every loop. */
static __attribute__((noinline)) vreal power_of_any(vreal t, real exponent) {
  for (int l = 0; l < SPHI_LANES; l++) t[l] = (real)pow((double)t[l], (double)exponent);
  return t;
}

/* t^exponent: the exponents of the literature without pow. */
SPHI_INLINE vreal power(vreal t, real exponent) {
  if (exponent == 1) return t;
  if (exponent == 2) return t * t;
  return power_of_any(t, exponent);
}

/* Whether q2^exponent may be divided by. A particle nearer than 1e-6 R (q2 = 1e-12) gets the
 * largest weight whatever the exponent, so that it is returned as it is. */
SPHI_INLINE vint power_is_far(vreal q2, vreal raised) {
  return (q2 > (real)1e-12) & (raised > 1 / LARGEST);
}

#endif
