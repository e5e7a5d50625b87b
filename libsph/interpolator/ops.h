/* Arguments and sums of the operators of interpolation. */
#ifndef SPHI_INTERPOLATOR_OPS_H
#define SPHI_INTERPOLATOR_OPS_H

#include <stdint.h>

typedef struct sphi_interpolation_arguments {
  double *sums; /* [rows][n]: row s of target k at sums[s * n + k] */
  int64_t n;
  double inverse_radius2; /* the rest is for Shepard: 1/R^2, */
  double mu_half;         /* mu/2, */
  double lambda_half;     /* lambda/2, */
  double attenuation;     /* mu (R/a)^2 */
} sphi_interpolation_arguments;

/* Rows of every operator: N and Gamma = sum W V. */
enum { SPHI_SUM_N, SPHI_SUM_GAMMA, SPHI_SUM_FIRST };

/* Weighted means: sum w, then sum w f of each field, then sum w (x_i - x_j). */
#define SPHI_SUM_W SPHI_SUM_FIRST
#define SPHI_SUM_F (SPHI_SUM_FIRST + 1)
#define SPHI_SUM_X(dim) (SPHI_SUM_F + (dim) + 1)
#define SPHI_WEIGHTED_SUMS(dim) (SPHI_SUM_X(dim) + (dim))

/* Least squares, with d = x_i - x_j: sum W V d, then sum W V d d (xx xy yy | xx xy xz yy yz zz), then
 * for each field sum W V f and sum W V f d. */
#define SPHI_SUM_D SPHI_SUM_FIRST
#define SPHI_SUM_DD(dim) (SPHI_SUM_FIRST + (dim))
#define SPHI_SUM_FD(dim) (SPHI_SUM_DD(dim) + (dim) * ((dim) + 1) / 2)
#define SPHI_LINEAR_SUMS(dim) (SPHI_SUM_FD(dim) + ((dim) + 1) * ((dim) + 1))

#endif
