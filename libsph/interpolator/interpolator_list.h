/* The interpolators: one row each.
 *
 * X(id, ENUMERATOR, operator, "name", "summary", "source"). The id is ABI: rows are added at the end,
 * never removed or renumbered, and include/sph/interpolator.h has the same enumerators.
 * op_<operator>.c is the pair loop.
 */
#ifndef SPHI_INTERPOLATOR_LIST_H
#define SPHI_INTERPOLATOR_LIST_H

#define SPHI_INTERPOLATOR_LIST(X)                                                    \
  X(1, IMPROVED_SHEPARD, shepard, "improved-shepard",                                \
    "inverse distance weights that end smoothly at the support; exact at particles", \
    "Huang et al. (2019), eq. (19)-(20), the lost exponential of (20) restored")     \
  X(2, NORMALIZED, normalized, "normalized", "kernel weights divided by their sum",  \
    "Huang et al. (2019), eq. (14)-(15)")                                            \
  X(3, MLS_LINEAR, mls_linear, "mls-linear",                                         \
    "moving least squares with a linear basis; exact for linear fields",             \
    "Huang et al. (2019), eq. (8)-(9)")

#endif
