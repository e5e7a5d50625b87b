/* Ratios of hyperbolic functions that regular waves share, without overflow in deep water. */
#ifndef SPHI_WAVE_REGULAR_H
#define SPHI_WAVE_REGULAR_H

#include "wave/wave_impl.h"

/* cosh(k y)/cosh(k) */
static inline double sphi_cosh_ratio(double k, double y) {
  return exp(k * (y - 1)) * (1 + exp(-2 * k * y)) / (1 + exp(-2 * k));
}

/* cosh(k y)/sinh(k) */
static inline double sphi_cosh_sinh(double k, double y) {
  return exp(k * (y - 1)) * (1 + exp(-2 * k * y)) / -expm1(-2 * k);
}

/* sinh(k y)/sinh(k) */
static inline double sphi_sinh_ratio(double k, double y) {
  return exp(k * (y - 1)) * expm1(-2 * k * y) / expm1(-2 * k);
}

#endif
