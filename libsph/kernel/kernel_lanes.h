/* What the formula of a kernel may need besides q^2, in the arithmetic of this build variant. */
#ifndef SPHI_KERNEL_LANES_H
#define SPHI_KERNEL_LANES_H

#include "kernel/kernel_impl.h"
#include "sweep/vreal.h"

/* Only a caller's kernel reads these; the formulas of the others are literals. */
typedef struct sphi_kernel_lanes {
  const real *table;   /* [SPHI_KERNEL_SEGMENTS][8], see kernel_impl.h; NULL for the others */
  real ratio2;         /* (support radius / h)^2 */
  real segments_per_q; /* SPHI_KERNEL_SEGMENTS / ratio */
} sphi_kernel_lanes;

SPHI_INLINE sphi_kernel_lanes sphi_kernel_lanes_of(const sph_kernel *kernel) {
  return (sphi_kernel_lanes) {
#if SPHI_DOUBLE
    .table = kernel->table,
#else
    .table = kernel->table_single,
#endif
    .ratio2 = (real)(kernel->ratio * kernel->ratio),
    .segments_per_q = (real)(SPHI_KERNEL_SEGMENTS / kernel->ratio)
  };
}

#endif
