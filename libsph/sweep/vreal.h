/* W lanes of reals, in the compilers' vector extensions.
 *
 * The build defines, once per variant: SPHI_VARIANT (suffix of external names), SPHI_LANES (W) and
 * SPHI_DOUBLE (0: float lanes, 1: double lanes). Formulas written with these types and functions
 * read like scalar C; with W = 1 they are the scalar reference.
 */
#ifndef SPHI_VREAL_H
#define SPHI_VREAL_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

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
/* Where one register holds the float lanes, intrinsics say what vector extensions cannot. */
#if !SPHI_DOUBLE && SPHI_LANES == 16 && defined(__AVX512F__)
#define SPHI_FLOAT16 1
#elif !SPHI_DOUBLE && SPHI_LANES == 8 && defined(__AVX__)
#define SPHI_FLOAT8 1
#elif !SPHI_DOUBLE && SPHI_LANES == 4 && defined(__SSE2__)
#define SPHI_FLOAT4 1
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

/* max(x, 0); not-a-number stays. */
SPHI_INLINE vreal v_positive(vreal x) {
#if SPHI_FLOAT16
  return (vreal)_mm512_max_ps(_mm512_setzero_ps(), (__m512)x);
#elif SPHI_FLOAT8
  return (vreal)_mm256_max_ps(_mm256_setzero_ps(), (__m256)x);
#elif SPHI_FLOAT4
  return (vreal)_mm_max_ps(_mm_setzero_ps(), (__m128)x);
#else
  return v_where(~(x <= 0), x);
#endif
}

SPHI_INLINE vreal v_abs(vreal x) { return v_select(x < 0, -x, x); }

/* Bit l is set where lane l of a is less than that of b. */
SPHI_INLINE unsigned v_bits_less(vreal a, vreal b) {
#if SPHI_FLOAT16
  return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
#elif SPHI_FLOAT8
  return (unsigned)_mm256_movemask_ps((__m256)(a < b));
#elif SPHI_FLOAT4
  return (unsigned)_mm_movemask_ps((__m128)(a < b));
#else
  const vint less = a < b;
  unsigned bits = 0;
  for (int l = 0; l < SPHI_LANES; l++) bits |= (unsigned)(less[l] & 1) << l;
  return bits;
#endif
}

SPHI_INLINE vreal v_sqrt(vreal x) {
  vreal y;
  for (int l = 0; l < SPHI_LANES; l++) y[l] = (real)(SPHI_DOUBLE ? sqrt(x[l]) : sqrtf((float)x[l]));
  return y;
}

/* 1/x for normal x. Float: by an estimate and one step of Newton's method, relative error 2e-7. */
SPHI_INLINE vreal v_reciprocal(vreal x) {
#if SPHI_FLOAT16
  const vreal y = (vreal)_mm512_rcp14_ps((__m512)x);
#elif SPHI_FLOAT8
  const vreal y = (vreal)_mm256_rcp_ps((__m256)x);
#elif SPHI_FLOAT4
  const vreal y = (vreal)_mm_rcp_ps((__m128)x);
#else
  return 1 / x;
#endif
#if SPHI_FLOAT16 || SPHI_FLOAT8 || SPHI_FLOAT4
  return y + y * (1 - x * y);
#endif
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

/* exp(-t) for 0 <= t <= 9 as a power of a polynomial, whose terms are paired to shorten the chain of
 * operations. Error in float below 5e-7, and 3e-5 relative where it is smallest; in double 2e-15 relative.
 * One lane is the reference and takes the library's. */
SPHI_INLINE vreal v_exp_minus_to_9(vreal t) {
#if SPHI_LANES == 1
  return v_set((real)exp(-(double)t[0]));
#elif SPHI_DOUBLE
  const vreal t2 = t * t, t4 = t2 * t2;
  const vreal a =
      (1 + t * -0.1249999999999995) + t2 * (0.0078124999999969113 + t * -0.00032552083332576537);
  const vreal b = (1.0172526032022896e-05 + t * -2.5431314371900675e-07) +
                  t2 * (5.2981870718911428e-09 + t * -9.4609375178960517e-11);
  const vreal c = (1.4780258589277338e-12 + t * -2.0490766619463717e-14) +
                  t2 * (2.5229662242640829e-16 + t * -2.6127551836389687e-18) +
                  t4 * 1.7407880483418788e-20;
  const vreal p = a + t4 * (b + t4 * c), p2 = p * p, p4 = p2 * p2;
  return p4 * p4;
#else
  const vreal t2 = t * t;
  const vreal a = 0.99999994f + t * -0.249998897f, b = 0.0312467664f + t * -0.00260064867f;
  const vreal c = 0.000160913929f + t * -7.61320143e-06f;
  const vreal d = 2.54624098e-07f + t * -4.44253123e-09f;
  const vreal p = a + t2 * (b + t2 * (c + t2 * d)), p2 = p * p;
  return p2 * p2;
#endif
}

#endif
