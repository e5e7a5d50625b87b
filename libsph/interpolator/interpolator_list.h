/* The interpolators: one row each.
 *
 * X(id, ENUMERATOR, operator, BELOW, "name", "summary", "source"). The id is ABI: rows are added at the
 * end, never removed or renumbered, and include/sph/interpolator.h has the same enumerators.
 * op_<operator>.c is the pair loop with what makes values of its sums. BELOW takes over where a point's
 * neighbours do not carry the method; NONE ends the ladder.
 */
#ifndef SPHI_INTERPOLATOR_LIST_H
#define SPHI_INTERPOLATOR_LIST_H

#define SPHI_INTERPOLATOR_LIST(X)                                                         \
  X(1, IMPROVED_SHEPARD, shepard, NEAREST, "improved-shepard",                            \
    "inverse distance weights that end smoothly at the support; exact at particles",      \
    "Huang et al. (2019), eq. (19)-(20), the lost exponential of (20) restored")          \
  X(2, NORMALIZED, normalized, IMPROVED_SHEPARD, "normalized",                            \
    "kernel weights divided by their sum", "Huang et al. (2019), eq. (14)-(15)")          \
  X(3, MLS_LINEAR, mls_linear, IMPROVED_SHEPARD, "mls-linear",                            \
    "moving least squares with a linear basis; exact for linear fields",                  \
    "Huang et al. (2019), eq. (8)-(9)")                                                   \
  X(4, CLASSIC_SHEPARD, classic_shepard, NEAREST, "classic-shepard",                      \
    "inverse distance weights cut off at the support; exact at particles",                \
    "Shepard (1968); Huang et al. (2019), eq. (17)-(18)")                                 \
  X(5, TUNED_SHEPARD, shepard, NEAREST, "tuned-shepard",                                  \
    "improved Shepard with mu = 2 and a = 2 h",                                           \
    "own; the weights of Huang et al. (2019), eq. (19)-(20)")                             \
  X(6, SFDI, sfdi, NORMALIZED, "sfdi",                                                    \
    "kernel weights and the gradient at the nearest particle; exact for linear fields",   \
    "Huang et al. (2019), eq. (11)-(12), with the gradient of Ma (2008)")                 \
  X(7, SFDI_PRINTED, sfdi, NORMALIZED, "sfdi-printed",                                    \
    "SFDI without the cross terms of its gradient", "Huang et al. (2019), eq. (11)-(12)") \
  X(8, MLS_QUADRATIC, mls_quadratic, MLS_LINEAR, "mls-quadratic",                         \
    "moving least squares with a quadratic basis; exact for quadratic fields",            \
    "Huang et al. (2019), eq. (8)-(9)")                                                   \
  X(9, NEAREST, nearest, NONE, "nearest", "the value of the nearest particle", "own")     \
  X(10, USER, weights, IMPROVED_SHEPARD, "user", "the caller's weights", "the caller")

#endif
