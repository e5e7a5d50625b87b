/* Floating-point operations: how many the sums need, and how many the processor could do. */
#ifndef FLOPS_H
#define FLOPS_H

#include "world.h"

/* Operations a pair as the formulas have them, seen from one particle: README.md tells how they are
 * counted. */
typedef struct flops {
  double gradient, rates, convective;
} flops;

/* With another particle, and with a ghost of a free-slip wall. */
flops flops_of_pair(int dim, sph_kernel_type kernel);
flops flops_of_ghost(int dim, sph_kernel_type kernel);

/* Single precision, best of some short loops without any memory traffic: 1e9 operations a second. */
double flops_peak(sph_isa isa, int threads);

#endif
