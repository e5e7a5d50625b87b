/* W lanes of reals, in the compilers' vector extensions.
 *
 * The build defines, once per variant: SPHI_VARIANT (suffix of external names), SPHI_LANES (W) and
 * SPHI_DOUBLE (0: float lanes, 1: double lanes). Formulas written with these types and functions
 * read like scalar C; with W = 1 they are the scalar reference.
 */
#ifndef SPHI_VREAL_H
#define SPHI_VREAL_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#ifndef SPHI_LANES
#define SPHI_LANES 1
#define SPHI_DOUBLE 1
#define SPHI_VARIANT scalar
#endif

#define SPHI_PASTE_(a, b) a##_##b
#define SPHI_PASTE(a, b) SPHI_PASTE_(a, b)
/* The external name of x in this variant. */
#define SPHI_NAME(x) SPHI_PASTE(x, SPHI_VARIANT)
#define SPHI_INLINE static inline __attribute__((always_inline, unused))

#if SPHI_DOUBLE
typedef double real;
typedef int64_t real_int;
#else
typedef float real;
typedef int32_t real_int;
#endif
typedef real vreal __attribute__((vector_size(sizeof(real) * SPHI_LANES)));
typedef real_int vint __attribute__((vector_size(sizeof(real) * SPHI_LANES)));

/* Every lane equal to x. */
SPHI_INLINE vreal v_set(real x) { return x - (vreal){0}; }

/* x where the mask is all ones, +0 where it is zero, whatever x holds there. */
SPHI_INLINE vreal v_where(vint mask, vreal x) { return (vreal)((vint)x & mask); }

SPHI_INLINE vreal v_select(vint mask, vreal yes, vreal no) {
  return (vreal)(((vint)yes & mask) | ((vint)no & ~mask));
}

/* max(x, 0) */
SPHI_INLINE vreal v_positive(vreal x) { return v_where(x > 0, x); }

SPHI_INLINE vreal v_sqrt(vreal x) {
  vreal y;
  for (int l = 0; l < SPHI_LANES; l++) y[l] = (real)(SPHI_DOUBLE ? sqrt(x[l]) : sqrtf((float)x[l]));
  return y;
}

/* After the last vector operation: upper halves of registers left in use slow down all that follows,
 * and compilers do not always clear them. */
SPHI_INLINE void v_leave(void) {
#ifdef __AVX__
  __builtin_ia32_vzeroupper();
#endif
}

/* exp(-t). Float: 0 <= t < 87, relative error below 2e-7; results beyond are not meaningful. */
SPHI_INLINE vreal v_exp_minus(vreal t) {
#if SPHI_DOUBLE
  vreal y;
  for (int l = 0; l < SPHI_LANES; l++) y[l] = exp(-t[l]);
  return y;
#else
  /* 2^y = 2^n 2^f, n the nearest integer: adding 1.5 * 2^23 leaves n in the low bits. */
  const float magic = 12582912.0f;
  const vreal y = t * -1.44269504088896341f;
  const vreal shifted = y + magic;
  const vreal f = y - (shifted - magic);
  /* 2^f on [-1/2, 1/2] by interpolation in the Chebyshev points, relative error 1e-7. */
  vreal p = 9.6760319e-3f + f * 1.3390863e-3f;
  p = 5.5503571e-2f + f * p;
  p = 2.4022107e-1f + f * p;
  p = 6.9314719e-1f + f * p;
  p = 1.0f + f * p;
  /* Unsigned: lanes that nobody asked for may hold any t. */
  typedef uint32_t vbits __attribute__((vector_size(sizeof(real) * SPHI_LANES)));
  return (vreal)((vbits)p + ((vbits)shifted << 23));
#endif
}

#endif
