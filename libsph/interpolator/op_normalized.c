/* Normalised kernel, Huang et al. (2019) eq. (14)-(15): w = W V. */
#define OPERATOR normalized
#include "sweep/pair.h"

#include "interpolator/ops.h"

typedef struct op_targets {
  int unused;
} op_targets;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)dim, (void)record, (void)stride, (void)first;
  t->unused = 0;
}

SPHI_INLINE vreal op_weight(const int dim, const op_targets *t, const real *source, const pair *g) {
  (void)t;
  return g->w * source[SPHI_RECORD_V(dim)];
}

#include "interpolator/weighted.inc.c"
