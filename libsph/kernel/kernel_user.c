/* A caller's kernel: checks, normalisation by quadrature, table for the pair loops. */
#include "kernel/kernel_impl.h"

#ifdef SPHI_GSL
#include <gsl/gsl_integration.h>

/* Three intervals in each segment: four points make its cubic. */
enum { INTERVALS = 3 * SPHI_KERNEL_SEGMENTS };

typedef struct caller {
  int dim;
  double ratio;
  sph_kernel_function w, dw;
  void *user;
} caller;

typedef struct samples {
  double q[INTERVALS + 1], f[INTERVALS + 1], slope[INTERVALS + 1];
  double steepest; /* max |f'| */
} samples;

static sph_status sample(sph_context *context, const caller *c, samples *s) {
  s->steepest = 0;
  for (int k = 0; k <= INTERVALS; k++) {
    const double q = c->ratio * k / INTERVALS;
    const double f = c->w(q, c->user), slope = c->dw(q, c->user);
    SPH_CHECK(context, isfinite(f) && isfinite(slope), SPH_E_ARGUMENT,
              "kernel \"user\": w and dw must be finite on [0, %g], got w(%g) = %g, dw(%g) = %g",
              c->ratio, q, f, q, slope);
    s->q[k] = q;
    s->f[k] = f;
    s->slope[k] = slope;
    s->steepest = fmax(s->steepest, fabs(slope));
  }
  return SPH_OK;
}

static sph_status check_samples(sph_context *context, const samples *s) {
  const double f0 = s->f[0], end = s->f[INTERVALS], ratio = s->q[INTERVALS];
  SPH_CHECK(context, f0 >= 1e-12 && f0 <= 1e12, SPH_E_ARGUMENT,
            "kernel \"user\": w(0) must be in [1e-12, 1e12], got %g; scale w and dw", f0);
  SPH_CHECK(
      context, fabs(end) <= 1e-3 * f0, SPH_E_ARGUMENT,
      "kernel \"user\": w must end near zero, |w(%g)| <= 1e-3 w(0) = %g, got %g; use a larger "
      "ratio or subtract the end value",
      ratio, 1e-3 * f0, end);
  SPH_CHECK(
      context, fabs(s->slope[0]) <= 1e-6 * s->steepest, SPH_E_ARGUMENT,
      "kernel \"user\": dw(0) must be 0, got %g: a kernel with a tip has no gradient at r = 0",
      s->slope[0]);
  /* (f(b) - f(a)) / (b - a) is the mean of f', here by Simpson's rule. */
  double worst = 0, at = 0;
  for (int k = 0; k + 2 <= INTERVALS; k++) {
    const double difference = (s->f[k + 2] - s->f[k]) / (s->q[k + 2] - s->q[k]);
    const double mean = (s->slope[k] + 4 * s->slope[k + 1] + s->slope[k + 2]) / 6;
    if (fabs(difference - mean) <= worst) continue;
    worst = fabs(difference - mean);
    at = s->q[k + 1];
  }
  SPH_CHECK(context, worst <= 2e-3 * s->steepest, SPH_E_ARGUMENT,
            "kernel \"user\": dw must be the derivative of w within %g, its differences are off by "
            "%g at q = %g",
            2e-3 * s->steepest, worst, at);
  return SPH_OK;
}

static double integrand(double q, void *data) {
  const caller *c = data;
  return c->w(q, c->user) * (c->dim == 1 ? 1 : c->dim == 2 ? q : q * q);
}

/* GSL's adaptive drivers report by a global handler that aborts, its rules do not. */
static double integrate(caller *c, double a, double b, double tolerance, int depth) {
  const gsl_function function = {integrand, c};
  double result, error, magnitude, deviation;
  gsl_integration_qk21(&function, a, b, &result, &error, &magnitude, &deviation);
  if (!(error > tolerance) || depth == 0) return result;
  const double middle = 0.5 * (a + b);
  return integrate(c, a, middle, tolerance, depth - 1) +
         integrate(c, middle, b, tolerance, depth - 1);
}

/* 1/sigma = surface(1) int_0^ratio f(q) q^(dim-1) dq */
static double integral(caller *c, double f0) {
  enum { PANELS = 8, DEPTH = 14 };
  const double surface = c->dim == 1 ? 2 : (c->dim == 2 ? 2 : 4) * 3.14159265358979323846;
  const double tolerance = 1e-14 * f0 * pow(c->ratio, c->dim);
  double sum = 0;
  for (int k = 0; k < PANELS; k++)
    sum += integrate(c, c->ratio * k / PANELS, c->ratio * (k + 1) / PANELS, tolerance, DEPTH);
  return surface * sum;
}

/* The cubic through y at u = 0, 1/3, 2/3, 1. */
static void cubic_through(const double *y, double *c) {
  c[0] = y[0];
  c[1] = 0.5 * (-11 * y[0] + 18 * y[1] - 9 * y[2] + 2 * y[3]);
  c[2] = 0.5 * (18 * y[0] - 45 * y[1] + 36 * y[2] - 9 * y[3]);
  c[3] = 0.5 * (-9 * y[0] + 27 * y[1] - 27 * y[2] + 9 * y[3]);
}

static bool tabulate(const samples *s, sph_kernel *kernel) {
  double g[INTERVALS + 1];
  for (int k = 1; k <= INTERVALS; k++) g[k] = s->slope[k] / s->q[k];
  g[0] = 4 * g[1] - 6 * g[2] + 4 * g[3] - g[4]; /* its limit, by the cubic through the next four */
  bool fits = true;                             /* also as float */
  for (int k = 0; k < SPHI_KERNEL_SEGMENTS; k++) {
    double *row = kernel->table + 8 * (size_t)k;
    cubic_through(s->f + 3 * (size_t)k, row);
    cubic_through(g + 3 * (size_t)k, row + 4);
    for (int l = 0; l < 8; l++) {
      fits = fits && fabs(row[l]) < 1e30;
      kernel->table_single[8 * (size_t)k + (size_t)l] = fits ? (float)row[l] : 0;
    }
  }
  return fits;
}

static sph_status create(sph_context *context, double h, caller *c, samples *s, sph_kernel **out) {
  SPH_TRY(sample(context, c, s));
  SPH_TRY(check_samples(context, s));
  const double norm = integral(c, s->f[0]);
  SPH_CHECK(context, isfinite(norm) && norm > 0, SPH_E_ARGUMENT,
            "kernel \"user\": the integral of w must be > 0, got %g", norm);
  const sph_kernel values = {.type = SPH_KERNEL_USER,
                             .dim = c->dim,
                             .h = h,
                             .ratio = c->ratio,
                             .sigma = 1 / norm,
                             .w = c->w,
                             .dw = c->dw,
                             .user = c->user};
  sph_kernel *kernel;
  SPH_TRY(sphi_kernel_new(context, &values, &kernel));
  kernel->table = SPHI_NEW(context, 8 * SPHI_KERNEL_SEGMENTS, double);
  kernel->table_single = SPHI_NEW(context, 8 * SPHI_KERNEL_SEGMENTS, float);
  sph_status status = SPH_OK;
  if (!kernel->table || !kernel->table_single)
    status = SPHI_ERROR(context, SPH_E_MEMORY, "kernel \"user\": out of memory");
  else if (!tabulate(s, kernel))
    status = SPHI_ERROR(context, SPH_E_ARGUMENT,
                        "kernel \"user\": dw(q)/q overflows on [0, %g]; scale w, dw and ratio",
                        c->ratio);
  if (status == SPH_OK)
    *out = kernel;
  else
    sph_kernel_destroy(&kernel);
  return status;
}
#endif

sph_status sph_kernel_create_user(sph_context *context, int dim, double h, double ratio,
                                  sph_kernel_function w, sph_kernel_function dw, void *user,
                                  sph_kernel **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "kernel \"user\": out must not be NULL");
  *out = NULL;
  SPH_CHECK(context, context && w && dw, SPH_E_ARGUMENT,
            "kernel \"user\": context, w and dw must not be NULL");
  SPH_TRY(sphi_kernel_check(context, "user", dim, h));
  SPH_CHECK(context, isfinite(ratio) && ratio > 0, SPH_E_ARGUMENT,
            "kernel \"user\": ratio of support to h must be finite and > 0, got %g", ratio);
#ifdef SPHI_GSL
  samples *s = SPHI_NEW(context, 1, samples);
  SPH_CHECK(context, s, SPH_E_MEMORY, "kernel \"user\": out of memory");
  caller c = {dim, ratio, w, dw, user};
  const sph_status status = create(context, h, &c, s, out);
  sphi_free(context, s);
  return status;
#else
  (void)user;
  return SPHI_ERROR(
      context, SPH_E_UNAVAILABLE,
      "kernel \"user\": its normalisation needs a build with GSL; make configure GSL=1");
#endif
}
