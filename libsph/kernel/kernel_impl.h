/* Kernels from the inside: what the pair loops need to evaluate one. */
#ifndef SPHI_KERNEL_IMPL_H
#define SPHI_KERNEL_IMPL_H

#include <sph/kernel.h>

#include "core/internal.h"

/* Piecewise cubics of a caller's kernel in q: segment s of SPHI_KERNEL_SEGMENTS equal ones over
 * the support holds f as c0 + c1 u + c2 u^2 + c3 u^3 with u in [0, 1], then f'/q likewise. */
enum { SPHI_KERNEL_SEGMENTS = 256 };

struct sph_kernel {
  sph_context *context;
  int references;
  int type; /* sph_kernel_type */
  int dim;
  double h;            /* smoothing length [m] */
  double ratio;        /* support radius / h */
  double support;      /* ratio * h [m] */
  double sigma;        /* normalisation: W = sigma h^-dim f(q), dW/dr = sigma h^-(dim+1) f'(q) */
  double norm_w;       /* sigma h^-dim: W = norm_w f(q) */
  double norm_g;       /* slope sigma h^-(dim+2): (dW/dr) / r = norm_g g(q) */
  double *table;       /* NULL, or [SPHI_KERNEL_SEGMENTS][8] */
  float *table_single; /* the same rounded to float */
  sph_kernel_function w, dw; /* a caller's kernel, as given */
  void *user;
};

void sphi_kernel_retain(sph_kernel *kernel);

/* The checks of dim and h that every kernel shares. */
sph_status sphi_kernel_check(sph_context *context, const char *name, int dim, double h);
/* A kernel with one reference from the members type to sigma and w, dw, user of `values`. */
sph_status sphi_kernel_new(sph_context *context, const sph_kernel *values, sph_kernel **out);

#endif
