/* What tests know about every interpolator: how to make it, its ladder, what it promises, and its weights
 * by their definition. */
#ifndef SPH_ANY_INTERPOLATOR_H
#define SPH_ANY_INTERPOLATOR_H

#include "sph_test.h"

/* A caller's weights: those of normalized, on its condition. */
static inline bool any_weights(int dim, int n, const double *offset, const double *kernel,
                               const double *volume, double support, double *weights, void *user) {
  (void)dim, (void)offset, (void)support, (void)user;
  double sum = 0;
  for (int k = 0; k < n; k++) sum += kernel[k] * volume[k];
  for (int k = 0; k < n; k++) weights[k] = kernel[k] * volume[k] / sum;
  return sum >= 1e-4;
}

static inline void any_create(sph_context *context, int type, sph_kernel *kernel,
                              sph_interpolator **out) {
  if (type == SPH_INTERPOLATOR_USER)
    SPH_TEST_OK(context, sph_interpolator_create_user(context, kernel, any_weights, NULL, out));
  else
    SPH_TEST_OK(context,
                sph_interpolator_create(context, (sph_interpolator_type)type, kernel, out));
}

/* Fields to interpolate. */
static inline double constant(const double *x, int dim) {
  (void)x, (void)dim;
  return 1234.5;
}

static const double any_slope[3] = {370, -9810, 150};

static inline double linear(const double *x, int dim) {
  double f = 2943;
  for (int d = 0; d < dim; d++) f += any_slope[d] * x[d];
  return f;
}

static inline double wavy(const double *x, int dim) {
  return sin(23 * x[0]) + cos(31 * x[1]) + (dim == 3 ? sin(17 * x[2] + 1) : 0);
}

static inline bool any_sfdi(int type) {
  return type == SPH_INTERPOLATOR_SFDI || type == SPH_INTERPOLATOR_SFDI_PRINTED;
}

static inline bool any_mls(int type) {
  return type == SPH_INTERPOLATOR_MLS_LINEAR || type == SPH_INTERPOLATOR_MLS_QUADRATIC;
}

static inline bool any_shepard(int type) {
  return type == SPH_INTERPOLATOR_IMPROVED_SHEPARD || type == SPH_INTERPOLATOR_CLASSIC_SHEPARD ||
         type == SPH_INTERPOLATOR_TUNED_SHEPARD;
}

/* Degree of the fields that are exact anywhere. */
static inline int any_degree(int type) {
  return type == SPH_INTERPOLATOR_MLS_QUADRATIC                                 ? 2
         : type == SPH_INTERPOLATOR_MLS_LINEAR || type == SPH_INTERPOLATOR_SFDI ? 1
                                                                                : 0;
}

/* Bound of sum |phi|. */
static inline double any_lebesgue(int type) {
  return any_sfdi(type)                                                                  ? 6
         : type == SPH_INTERPOLATOR_MLS_LINEAR || type == SPH_INTERPOLATOR_MLS_QUADRATIC ? 3
                                                                                         : 1;
}

/* Neighbours that a kind asks for. */
static inline int any_neighbours(int type, int dim) {
  return type == SPH_INTERPOLATOR_MLS_QUADRATIC ? (dim == 2 ? 10 : 16)
         : any_mls(type) || any_sfdi(type)      ? (dim == 2 ? 5 : 8)
                                                : 1;
}

/* How far down the documented ladder of `type` a rung is: 0 itself, 9 none, -1 not on it. */
static inline int any_step(int type, int rung) {
  for (int step = 0; type; step++) {
    if (rung == type) return step;
    type = type == SPH_INTERPOLATOR_MLS_QUADRATIC      ? SPH_INTERPOLATOR_MLS_LINEAR
           : any_sfdi(type)                            ? SPH_INTERPOLATOR_NORMALIZED
           : type == SPH_INTERPOLATOR_NEAREST          ? 0
           : type == SPH_INTERPOLATOR_IMPROVED_SHEPARD ? SPH_INTERPOLATOR_NEAREST
                                                       : SPH_INTERPOLATOR_IMPROVED_SHEPARD;
  }
  return rung == 0 ? 9 : -1;
}

/* m x = b in place by Gauss with pivots; false if singular. */
static inline bool any_solve(int size, long double m[10][10], long double *b) {
  for (int k = 0; k < size; k++) {
    int pivot = k;
    for (int i = k + 1; i < size; i++)
      if (fabsl(m[i][k]) > fabsl(m[pivot][k])) pivot = i;
    if (m[pivot][k] == 0) return false;
    for (int l = 0; l < size; l++) {
      const long double swap = m[k][l];
      m[k][l] = m[pivot][l];
      m[pivot][l] = swap;
    }
    const long double swap = b[k];
    b[k] = b[pivot];
    b[pivot] = swap;
    for (int i = k + 1; i < size; i++) {
      const long double factor = m[i][k] / m[k][k];
      for (int l = k; l < size; l++) m[i][l] -= factor * m[k][l];
      b[i] -= factor * b[k];
    }
  }
  for (int k = size - 1; k >= 0; k--) {
    for (int l = k + 1; l < size; l++) b[k] -= m[k][l] * b[l];
    b[k] /= m[k][k];
  }
  return true;
}

/* Particles, and a kind with the parameters mu, a/R and lambda of Shepard's weight. */
typedef struct any_case {
  const sph_kernel *kernel;
  int dim;
  sph_index n;
  const double *x, *volume;
  int type;
  double mu, scale, lambda;
} any_case;

static inline long double any_distance(const any_case *c, sph_index j, const double *at) {
  long double r2 = 0;
  for (int d = 0; d < c->dim; d++) {
    const long double offset = (long double)c->x[j * c->dim + d] - at[d];
    r2 += offset * offset;
  }
  return sqrtl(r2);
}

static inline long double any_kernel(const any_case *c, long double r) {
  return sph_kernel_w(c->kernel, (double)r);
}

/* 1, X, Y, Z and for degree 2 all their products. */
static inline int any_basis(const any_case *c, int degree, const long double *x, long double *b) {
  int size = 0;
  b[size++] = 1;
  for (int d = 0; d < c->dim; d++) b[size++] = x[d];
  for (int d = 0; d < c->dim && degree == 2; d++)
    for (int e = d; e < c->dim; e++) b[size++] = x[d] * x[e];
  return size;
}

static inline bool any_phi_mls(const any_case *c, const double *at, int derivative,
                               long double *phi) {
  const long double support = sph_kernel_get_support(c->kernel);
  const int degree = any_degree(c->type);
  long double m[10][10] = {{0}}, z[10] = {0}, b[10];
  z[derivative + 1] = derivative < 0 ? 1 : 1 / support;
  for (int pass = 0; pass < 2; pass++) {
    int size = 0;
    for (sph_index j = 0; j < c->n; j++) {
      const long double r = any_distance(c, j, at);
      if (pass == 1) phi[j] = 0;
      if (r >= support) continue;
      long double x[3] = {0};
      for (int d = 0; d < c->dim; d++) x[d] = ((long double)c->x[j * c->dim + d] - at[d]) / support;
      size = any_basis(c, degree, x, b);
      const long double w = any_kernel(c, r) * c->volume[j];
      for (int k = 0; k < size; k++) {
        for (int l = 0; l < size && pass == 0; l++) m[k][l] += w * b[k] * b[l];
        if (pass == 1) phi[j] += w * z[k] * b[k];
      }
    }
    if (size == 0 || (pass == 0 && !any_solve(size, m, z))) return false;
  }
  return true;
}

static inline bool any_phi_sfdi(const any_case *c, const double *at, int derivative,
                                long double *phi) {
  const long double support = sph_kernel_get_support(c->kernel);
  const int dim = c->dim;
  sph_index i = -1;
  long double a[10][10] = {{0}}, r0[10] = {0}, sum = 0;
  for (sph_index j = 0; j < c->n; j++) {
    const long double r = any_distance(c, j, at);
    phi[j] = 0;
    if (r >= support) continue;
    if (i < 0 || r < any_distance(c, i, at)) i = j;
    phi[j] = any_kernel(c, r);
    sum += phi[j];
    for (int d = 0; d < dim; d++) r0[d] += phi[j] * ((long double)c->x[j * dim + d] - at[d]);
  }
  if (i < 0 || sum == 0) return false;
  const double *xi = c->x + i * dim;
  for (int pass = 0; pass < 2; pass++) {
    for (sph_index j = 0; j < c->n; j++) {
      const long double r = any_distance(c, j, xi);
      if (any_distance(c, j, at) >= support || r <= 1e-6L * support) continue;
      const long double q = any_kernel(c, r) / (r * r);
      long double along = 0;
      for (int d = 0; d < dim; d++) {
        const long double offset = (long double)c->x[j * dim + d] - xi[d];
        for (int e = 0; e < dim && pass == 0; e++)
          if (d == e || c->type == SPH_INTERPOLATOR_SFDI)
            a[d][e] += q * offset * ((long double)c->x[j * dim + e] - xi[e]);
        along += q * r0[d] * offset;
      }
      if (pass == 0) continue;
      phi[j] += derivative < 0 ? -along : along;
      phi[i] -= derivative < 0 ? -along : along;
    }
    if (pass == 1) break;
    for (sph_index j = 0; j < c->n; j++) phi[j] = derivative < 0 ? phi[j] / sum : 0;
    for (int d = 0; d < dim; d++) r0[d] = derivative < 0 ? r0[d] / sum : d == derivative;
    if (!any_solve(dim, a, r0)) return false;
  }
  return true;
}

/* phi [n] by its definition in long double; with derivative 0 to dim - 1 the weights of that component
 * of the gradient. False where there is none. */
static inline bool any_phi(const any_case *c, const double *at, int derivative, long double *phi) {
  if (any_mls(c->type)) return any_phi_mls(c, at, derivative, phi);
  if (any_sfdi(c->type)) return any_phi_sfdi(c, at, derivative, phi);
  const double support = sph_kernel_get_support(c->kernel);
  long double sum = 0, least = 2;
  sph_index nearest = 0;
  for (sph_index j = 0; j < c->n; j++) {
    const long double r = any_distance(c, j, at), s = r / support;
    phi[j] = 0;
    if (s >= 1) continue;
    if (s < least) nearest = j, least = s;
    if (!any_shepard(c->type))
      phi[j] = any_kernel(c, r) * c->volume[j];
    else
      phi[j] = powl(fmaxl(s, 1e-6L), -c->mu);
    if (any_shepard(c->type) && c->type != SPH_INTERPOLATOR_CLASSIC_SHEPARD)
      phi[j] *= expl(-c->mu * s * s / (c->scale * c->scale) / (1 - powl(s, c->lambda)));
    sum += phi[j];
  }
  for (sph_index j = 0; j < c->n; j++)
    phi[j] = c->type == SPH_INTERPOLATOR_NEAREST ? (long double)(j == nearest) : phi[j] / sum;
  return least < 1 && (sum > 0 || c->type == SPH_INTERPOLATOR_NEAREST);
}

#endif
