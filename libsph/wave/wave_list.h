/* The theories: one row each, and a file <stem>.c with its table sphi_wave_<stem>.
 *
 * X(id, ENUMERATOR, stem). The id is ABI: rows are added at the end, never removed or renumbered, and
 * include/sph/wave.h has the same enumerators. Of regular waves the id is the order. */
#ifndef SPHI_WAVE_LIST_H
#define SPHI_WAVE_LIST_H

#include "wave/wave_impl.h"

#define SPHI_SOLITARY_LIST(X)  \
  X(1, BOUSSINESQ, boussinesq) \
  X(2, KDV, kdv)               \
  X(3, RAYLEIGH, rayleigh)     \
  X(4, GRIMSHAW, grimshaw)     \
  X(5, FENTON, fenton)         \
  X(6, EXACT, exact)

#define SPHI_REGULAR_LIST(X) \
  X(1, AIRY, airy)           \
  X(2, STOKES, stokes)

#define SPHI_WAVE_EXTERN(id, enumerator, stem) extern const sphi_wave_theory sphi_wave_##stem;
SPHI_SOLITARY_LIST(SPHI_WAVE_EXTERN)
SPHI_REGULAR_LIST(SPHI_WAVE_EXTERN)
#undef SPHI_WAVE_EXTERN

#endif
