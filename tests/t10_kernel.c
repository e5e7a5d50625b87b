/* Kernels: normalisation, moments, derivatives, lane formulas, a caller's own, errors. */
#pragma GCC diagnostic ignored "-Wpsabi" /* vectors of 8 floats stay inside this file */
#define SPHI_LANES 8
#define SPHI_DOUBLE 0
#define SPHI_VARIANT test
#include "kernel/kernel_list.h"
#include "sph_test.h"

#define PI 3.14159265358979323846
#define BUILT_IN 6 /* kernels 1 to 6 come from a formula */

/* W at zero, sigma and the second moment per direction in h^2, written from the publications. */
static const struct expected {
  const char *name;
  double ratio, sigma[3], f0, second_moment[3], lattice;
} expected[BUILT_IN] = {
    {"cubic-spline", 2, {2.0 / 3, 10 / (7 * PI), 1 / PI}, 1, {1.0 / 3, 31.0 / 98, 0.3}, 1e-3},
    {"quintic-spline",
     3,
     {1.0 / 120, 7 / (478 * PI), 1 / (120 * PI)},
     66,
     {0.5, 0.4830892607, 7.0 / 15},
     1e-5},
    {"wendland-c2",
     2,
     {5.0 / 8, 7 / (4 * PI), 21 / (16 * PI)},
     1,
     {8.0 / 21, 5.0 / 18, 4.0 / 15},
     4e-3},
    {"wendland-c4",
     2,
     {3.0 / 4, 9 / (4 * PI), 495 / (256 * PI)},
     1,
     {4.0 / 15, 7.0 / 33, 8.0 / 39},
     2e-3},
    {"wendland-c6",
     2,
     {55.0 / 64, 78 / (28 * PI), 1365 / (512 * PI)},
     1,
     {8.0 / 39, 6.0 / 35, 1.0 / 6},
     1e-3},
    {"gaussian",
     3,
     {1 / 1.771674237695, 1 / 3.137715620251, 1 / 5.551921449675},
     1 - 1.2340980408667956e-4,
     {0.4987459, 0.4974980, 0.4954750},
     1e-3},
};

static sph_context *new_context(void) {
  sph_context *context = NULL;
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  return context;
}

static sph_kernel *new_kernel(sph_context *context, int type, int dim, double h) {
  sph_kernel *kernel = NULL;
  SPH_TEST_OK(context, sph_kernel_create(context, (sph_kernel_type)type, dim, h, &kernel));
  return kernel;
}

/* Surface of the unit sphere times r^(dim-1). */
static double shell(int dim, double r) {
  return dim == 1 ? 2 : dim == 2 ? 2 * PI * r : 4 * PI * r * r;
}

/* int W r^power dV by Gauss-Legendre with 5 points on panels of h/32, knots included. */
static double moment(const sph_kernel *kernel, int power) {
  const double x[5] = {0, 0.53846931010568309104, -0.53846931010568309104, 0.90617984593866399280,
                       -0.90617984593866399280};
  const double w[5] = {0.56888888888888888889, 0.47862867049936646804, 0.47862867049936646804,
                       0.23692688505618908751, 0.23692688505618908751};
  const double half = sph_kernel_get_h(kernel) / 64;
  const int panels = (int)(sph_kernel_get_support(kernel) / (2 * half) + 0.5);
  double sum = 0;
  for (int k = 0; k < panels; k++)
    for (int l = 0; l < 5; l++) {
      const double r = half * (2 * k + 1 + x[l]);
      sum += half * w[l] * sph_kernel_w(kernel, r) * shell(sph_kernel_get_dim(kernel), r) *
             pow(r, power);
    }
  return sum;
}

static void integral_is_one(void) {
  sph_context *context = new_context();
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      sph_kernel *kernel = new_kernel(context, type, dim, 0.37);
      SPH_TEST_CLOSE(moment(kernel, 0), 1, 1e-12, 0);
      sph_kernel_destroy(&kernel);
    }
  sph_context_destroy(&context);
}

static void constants_are_published(void) {
  sph_context *context = new_context();
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      const struct expected *e = &expected[type - 1];
      const double h = 0.013;
      sph_kernel *kernel = new_kernel(context, type, dim, h);
      SPH_TEST_CLOSE(sph_kernel_get_normalization(kernel), e->sigma[dim - 1], 1e-12, 0);
      SPH_TEST_CLOSE(sph_kernel_w(kernel, 0), e->sigma[dim - 1] * e->f0 / pow(h, dim), 1e-12, 0);
      SPH_TEST_CLOSE(sph_kernel_get_support(kernel), e->ratio * h, 1e-15, 0);
      CU_ASSERT(sph_kernel_get_h(kernel) == h);
      CU_ASSERT(sph_kernel_get_dim(kernel) == dim);
      CU_ASSERT(sph_kernel_get_type(kernel) == type);
      SPH_TEST_CLOSE(moment(kernel, 2) / (dim * h * h), e->second_moment[dim - 1], 1e-6, 0);
      sph_kernel_destroy(&kernel);
    }
  sph_context_destroy(&context);
}

/* The polynomials as printed, away from the truncated powers that the library uses. */
static double printed(int type, int dim, double q) {
  const double a = 1 - q / 2;
  switch (type) {
    case 1: return q < 1 ? 1 - 1.5 * q * q + 0.75 * q * q * q : 0.25 * pow(2 - q, 3);
    case 2:
      return pow(3 - q, 5) - (q < 2 ? 6 * pow(2 - q, 5) : 0) + (q < 1 ? 15 * pow(1 - q, 5) : 0);
    case 3: return dim == 1 ? pow(a, 3) * (1 + 1.5 * q) : pow(a, 4) * (1 + 2 * q);
    case 4:
      return dim == 1 ? pow(a, 5) * (1 + 2.5 * q + 2 * q * q)
                      : pow(a, 6) * (1 + 3 * q + 35 * q * q / 12);
    case 5:
      return dim == 1 ? pow(a, 7) * (1 + 3.5 * q + 4.75 * q * q + 2.625 * q * q * q)
                      : pow(a, 8) * (1 + 4 * q + 6.25 * q * q + 4 * q * q * q);
    default: return exp(-q * q) - exp(-9.0);
  }
}

static void values_are_the_printed_polynomials(void) {
  sph_context *context = new_context();
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      sph_kernel *kernel = new_kernel(context, type, dim, 1);
      const double sigma = sph_kernel_get_normalization(kernel);
      const double ratio = sph_kernel_get_support(kernel);
      for (int k = 0; k < 200; k++) {
        const double q = ratio * k / 200;
        SPH_TEST_CLOSE(sph_kernel_w(kernel, q), sigma * printed(type, dim, q), 0,
                       1e-13 * sph_kernel_w(kernel, 0));
      }
      sph_kernel_destroy(&kernel);
    }
  sph_context_destroy(&context);
}

/* Sums over a square lattice with h = 2 dx: sum V W x, and sum V (dW/dr / r) x_a x_b. */
static void lattice_sums(const sph_kernel *kernel, double dx, double *first, double *gradient) {
  const int dim = sph_kernel_get_dim(kernel), n = (int)(sph_kernel_get_support(kernel) / dx) + 1;
  const double volume = pow(dx, dim);
  for (int k = -n; k <= n; k++)
    for (int l = dim > 1 ? -n : 0; l <= (dim > 1 ? n : 0); l++)
      for (int m = dim > 2 ? -n : 0; m <= (dim > 2 ? n : 0); m++) {
        const double x[3] = {dx * k, dx * l, dx * m};
        const double r = sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
        for (int a = 0; a < dim; a++) {
          first[a] += volume * sph_kernel_w(kernel, r) * x[a];
          for (int b = 0; r > 0 && b < dim; b++)
            gradient[3 * a + b] -= volume * sph_kernel_dw(kernel, r) / r * x[a] * x[b];
        }
      }
}

static void lattice_moments(void) {
  sph_context *context = new_context();
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      const double dx = 0.01, h = 2 * dx;
      sph_kernel *kernel = new_kernel(context, type, dim, h);
      double first[3] = {0}, gradient[9] = {0};
      lattice_sums(kernel, dx, first, gradient);
      for (int a = 0; a < dim; a++) {
        SPH_TEST_CLOSE(first[a], 0, 0, 1e-13 * h);
        for (int b = 0; b < dim; b++)
          SPH_TEST_CLOSE(gradient[3 * a + b], a == b, 0,
                         a == b ? expected[type - 1].lattice : 1e-13);
      }
      sph_kernel_destroy(&kernel);
    }
  sph_context_destroy(&context);
}

static void derivative_is_of_the_value(void) {
  sph_context *context = new_context();
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      const double h = 0.7, e = 1e-5 * h;
      sph_kernel *kernel = new_kernel(context, type, dim, h);
      const double scale = sph_kernel_w(kernel, 0) / h;
      CU_ASSERT(sph_kernel_dw(kernel, 0) == 0);
      for (int k = 1; k < 400; k++) {
        const double r = (sph_kernel_get_support(kernel) - e) * k / 400;
        const double difference =
            (sph_kernel_w(kernel, r + e) - sph_kernel_w(kernel, r - e)) / (2 * e);
        SPH_TEST_CLOSE(sph_kernel_dw(kernel, r), difference, 0, 1e-9 * scale);
      }
      sph_kernel_destroy(&kernel);
    }
  sph_context_destroy(&context);
}

static void falls_to_zero_and_stays(void) {
  sph_context *context = new_context();
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      sph_kernel *kernel = new_kernel(context, type, dim, 0.7);
      const double support = sph_kernel_get_support(kernel);
      int rises = 0, slopes = 0;
      for (int k = 1; k < 1000; k++) {
        const double r = support * k / 1000;
        rises += !(sph_kernel_w(kernel, r) < sph_kernel_w(kernel, support * (k - 1) / 1000));
        rises += !(sph_kernel_w(kernel, r) > 0);
        slopes += !(sph_kernel_dw(kernel, r) < 0);
      }
      CU_ASSERT(rises == 0);
      CU_ASSERT(slopes == 0);
      SPH_TEST_BELOW(sph_kernel_w(kernel, support * (1 - 1e-9)), 1e-7 * sph_kernel_w(kernel, 0));
      const double beyond[] = {support, nextafter(support, 10), 1.1 * support, 20, 1e200, INFINITY};
      for (int k = 0; k < 6; k++) {
        CU_ASSERT(sph_kernel_w(kernel, beyond[k]) == 0);
        CU_ASSERT(sph_kernel_dw(kernel, beyond[k]) == 0);
      }
      sph_kernel_destroy(&kernel);
    }
  sph_context_destroy(&context);
}

static void arrays_equal_single_points(void) {
  sph_context *context = new_context();
  enum { N = 1000 };
  double r[N], w[N], dw[N], only[N];
  uint64_t seed = 10;
  for (int k = 0; k < N; k++) r[k] = 4 * sph_test_random(&seed);
  r[0] = 0;
  for (int type = 1; type <= BUILT_IN; type++) {
    sph_kernel *kernel = new_kernel(context, type, 2, 1.1);
    SPH_TEST_OK(context, sph_kernel_evaluate(kernel, N, r, w, dw));
    int different = 0;
    for (int k = 0; k < N; k++)
      different += w[k] != sph_kernel_w(kernel, r[k]) || dw[k] != sph_kernel_dw(kernel, r[k]);
    CU_ASSERT(different == 0);
    SPH_TEST_OK(context, sph_kernel_evaluate(kernel, N, r, only, NULL));
    CU_ASSERT(memcmp(only, w, sizeof w) == 0);
    SPH_TEST_OK(context, sph_kernel_evaluate(kernel, N, r, NULL, only));
    CU_ASSERT(memcmp(only, dw, sizeof dw) == 0);
    memcpy(only, r, sizeof r); /* in place */
    SPH_TEST_OK(context, sph_kernel_evaluate(kernel, N, only, only, dw));
    CU_ASSERT(memcmp(only, w, sizeof w) == 0);
    SPH_TEST_OK(context, sph_kernel_evaluate(kernel, 0, NULL, w, NULL));
    sph_kernel_destroy(&kernel);
  }
  sph_context_destroy(&context);
}

SPHI_INLINE vreal lane_f(int type, const vreal *q2, int dim, const sphi_kernel_lanes *lanes) {
  switch ((sph_kernel_type)type) {
#define LANES_F(id, enumerator, stem, name, ratio, summary, source) \
  case SPH_KERNEL_##enumerator:                                     \
    return dim == 1 ? sphi_##stem##_f(*q2, 1, lanes) : sphi_##stem##_f(*q2, 2, lanes);
    SPHI_KERNEL_LIST(LANES_F)
  }
  return v_set(NAN);
}

SPHI_INLINE vreal lane_g(int type, const vreal *q2, int dim, const sphi_kernel_lanes *lanes) {
  switch ((sph_kernel_type)type) {
#define LANES_G(id, enumerator, stem, name, ratio, summary, source) \
  case SPH_KERNEL_##enumerator:                                     \
    return dim == 1 ? sphi_##stem##_g(*q2, 1, lanes) : sphi_##stem##_g(*q2, 2, lanes);
    SPHI_KERNEL_LIST(LANES_G)
  }
  return v_set(NAN);
}

/* q from 0 to 11 in float lanes against the scalar functions of a kernel with h = 1. */
static void compare_lanes(const sph_kernel *kernel, double g0) {
  const int type = sph_kernel_get_type(kernel), dim = sph_kernel_get_dim(kernel);
  const double sigma = sph_kernel_get_normalization(kernel), ratio = sph_kernel_get_support(kernel);
  const double f0 = sph_kernel_w(kernel, 0) / sigma;
  const double g_over_dw = kernel->norm_w / (kernel->norm_g * kernel->h * kernel->h);
  const sphi_kernel_lanes lanes = sphi_kernel_lanes_of(kernel);
  double worst_f = 0, worst_g = 0;
  int nonzero = 0;
  for (int k = 0; k < 22000; k += SPHI_LANES) {
    vreal q2;
    for (int l = 0; l < SPHI_LANES; l++) q2[l] = (float)pow(0.0005 * (k + l), 2);
    if (k == 16000) q2[3] = (float)(ratio * ratio); /* exactly at the end */
    const vreal f = lane_f(type, &q2, dim, &lanes), g = lane_g(type, &q2, dim, &lanes);
    for (int l = 0; l < SPHI_LANES; l++) {
      const double q = sqrt((double)q2[l]);
      nonzero += q >= ratio && (f[l] != 0 || g[l] != 0);
      if (q >= ratio) continue;
      const double exact_g = (q > 0 ? sph_kernel_dw(kernel, q) / (q * sigma) : g0) * g_over_dw;
      worst_f = fmax(worst_f, fabs(f[l] - sph_kernel_w(kernel, q) / sigma));
      worst_g = fmax(worst_g, fabs(g[l] - exact_g));
      if (isnan(f[l]) || isnan(g[l])) nonzero++;
    }
  }
  CU_ASSERT(nonzero == 0);
  SPH_TEST_BELOW(worst_f, 3e-6 * f0);
  SPH_TEST_BELOW(worst_g, 3e-6 * fabs(g0 * g_over_dw)); /* |g| is largest at q = 0 */
}

static void float_lanes_equal_scalars(void) {
  sph_context *context = new_context();
  const double g0[BUILT_IN][2] = {{-3, -3},          {-120, -120}, {-3, -5},
                                  {-3.5, -14.0 / 3}, {-4.5, -5.5}, {-2, -2}};
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      sph_kernel *kernel = new_kernel(context, type, dim, 1);
      compare_lanes(kernel, g0[type - 1][dim > 1]);
      sph_kernel_destroy(&kernel);
    }
  sph_context_destroy(&context);
}

/* Wendland C2 with an odd factor, as a caller would write it. */
static double own_w(double q, void *user) {
  return *(double *)user * pow(1 - q / 2, 4) * (1 + 2 * q);
}
static double own_dw(double q, void *user) { return *(double *)user * -5 * q * pow(1 - q / 2, 3); }

#ifdef SPHI_GSL
static void user_kernel_is_the_built_in(void) {
  sph_context *context = new_context();
  double factor = 3.7;
  for (int dim = 2; dim <= 3; dim++) {
    const double h = 0.02;
    sph_kernel *own = NULL, *built_in = new_kernel(context, SPH_KERNEL_WENDLAND_C2, dim, h);
    SPH_TEST_OK(context, sph_kernel_create_user(context, dim, h, 2, own_w, own_dw, &factor, &own));
    CU_ASSERT(sph_kernel_get_type(own) == SPH_KERNEL_USER);
    CU_ASSERT(sph_kernel_get_support(own) == sph_kernel_get_support(built_in));
    SPH_TEST_CLOSE(sph_kernel_get_normalization(own) * factor,
                   sph_kernel_get_normalization(built_in), 1e-13, 0);
    for (int k = 0; k <= 110; k++) {
      const double r = 2 * h * k / 100;
      SPH_TEST_CLOSE(sph_kernel_w(own, r), sph_kernel_w(built_in, r), 1e-12, 0);
      SPH_TEST_CLOSE(sph_kernel_dw(own, r), sph_kernel_dw(built_in, r), 1e-12, 0);
    }
    double r[3] = {0, 0.013, 0.05}, w[3], dw[3];
    SPH_TEST_OK(context, sph_kernel_evaluate(own, 3, r, w, dw));
    for (int k = 0; k < 3; k++)
      CU_ASSERT(w[k] == sph_kernel_w(own, r[k]) && dw[k] == sph_kernel_dw(own, r[k]));
    sph_kernel_destroy(&own);
    sph_kernel_destroy(&built_in);
  }
  sph_context_destroy(&context);
}

static double through_built_in_w(double q, void *user) { return sph_kernel_w(user, q); }
static double through_built_in_dw(double q, void *user) { return sph_kernel_dw(user, q); }

static void any_kernel_can_be_tabulated(void) {
  sph_context *context = new_context();
  for (int type = 1; type <= BUILT_IN; type++)
    for (int dim = 1; dim <= 3; dim++) {
      sph_kernel *built_in = new_kernel(context, type, dim, 1), *own = NULL;
      const double ratio = sph_kernel_get_support(built_in), w0 = sph_kernel_w(built_in, 0);
      /* The Gaussian ends with a jump of f', and beyond the end the built-in returns zero. */
      const double end = type == SPH_KERNEL_GAUSSIAN ? nextafter(ratio, 0) : ratio;
      SPH_TEST_OK(context, sph_kernel_create_user(context, dim, 1, end, through_built_in_w,
                                                  through_built_in_dw, built_in, &own));
      SPH_TEST_CLOSE(sph_kernel_get_normalization(own), 1, 2e-13, 0);
      double worst_f = 0, worst_g = 0, g0 = 0;
      for (int k = 9999; k >= 1; k--) {
        const double q = ratio * k / 10000, position = q / end * SPHI_KERNEL_SEGMENTS;
        const int segment = (int)position;
        const double u = position - segment, *c = own->table + 8 * segment;
        g0 = sph_kernel_dw(built_in, q) / q;
        worst_f = fmax(worst_f,
                       fabs(c[0] + u * (c[1] + u * (c[2] + u * c[3])) - sph_kernel_w(built_in, q)));
        worst_g = fmax(worst_g, fabs(c[4] + u * (c[5] + u * (c[6] + u * c[7])) - g0));
      }
      SPH_TEST_BELOW(worst_f, 1e-8 * w0);
      if (type != SPH_KERNEL_CUBIC_SPLINE) SPH_TEST_BELOW(worst_g, 1e-7 * fabs(g0));
      compare_lanes(own, own->table[4]);
      sph_kernel_destroy(&own);
      sph_kernel_destroy(&built_in);
    }
  sph_context_destroy(&context);
}

static double narrow(double q, void *user) { return (void)user, exp(-400 * q * q); }
static double narrow_dw(double q, void *user) { return -800 * q * narrow(q, user); }

static void quadrature_refines(void) {
  sph_context *context = new_context();
  for (int dim = 1; dim <= 3; dim++) {
    sph_kernel *kernel = NULL;
    SPH_TEST_OK(context,
                sph_kernel_create_user(context, dim, 1, 2, narrow, narrow_dw, NULL, &kernel));
    SPH_TEST_CLOSE(sph_kernel_get_normalization(kernel), pow(400 / PI, 0.5 * dim), 1e-13, 0);
    sph_kernel_destroy(&kernel);
  }
  sph_context_destroy(&context);
}

static double not_finite(double q, void *user) { return q > 1 ? NAN : own_w(q, user); }
static double not_finite_dw(double q, void *user) { return q > 1 ? INFINITY : own_dw(q, user); }
static double hat(double q, void *user) { return (void)user, 1 - q / 2; }
static double hat_dw(double q, void *user) { return (void)q, (void)user, -0.5; }
static double zero(double q, void *user) { return (void)q, (void)user, 0; }
static double minus_dw(double q, void *user) { return -own_dw(q, user); }
static double cosine(double q, void *user) { return (void)user, cos(PI * q / 4) * cos(PI * q); }
static double cosine_dw(double q, void *user) {
  (void)user;
  return -PI / 4 * sin(PI * q / 4) * cos(PI * q) - PI * cos(PI * q / 4) * sin(PI * q);
}

static void user_kernel_checks_its_functions(void) {
  sph_context *context = new_context();
  double factor = 1, tiny = 1e-13, huge = 1e13;
  const struct {
    sph_kernel_function w, dw;
    double ratio, *user;
    const char *text;
  } wrong[] = {
      {not_finite, own_dw, 2, &factor, "w and dw must be finite on [0, 2], got w(1.00"},
      {own_w, not_finite_dw, 2, &factor, "must be finite"},
      {own_w, own_dw, 1.5, &factor,
       "w must end near zero, |w(1.5)| <= 1e-3 w(0) = 0.001, got 0.0156"},
      {own_w, own_dw, 2, &tiny, "w(0) must be in [1e-12, 1e12], got 1e-13; scale w and dw"},
      {own_w, own_dw, 2, &huge, "w(0) must be in [1e-12, 1e12]"},
      {zero, own_dw, 2, &factor, "w(0) must be in [1e-12, 1e12], got 0"},
      {hat, hat_dw, 2, &factor, "dw(0) must be 0, got -0.5"},
      {own_w, minus_dw, 2, &factor, "dw must be the derivative of w within"},
      {own_w, zero, 2, &factor, "dw must be the derivative of w within"},
      {cosine, cosine_dw, 2, &factor, "the integral of w must be > 0, got -"},
  };
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
    sph_kernel *kernel = (sph_kernel *)context;
    SPH_TEST_STATUS(context,
                    sph_kernel_create_user(context, 2, 1, wrong[k].ratio, wrong[k].w, wrong[k].dw,
                                           wrong[k].user, &kernel),
                    SPH_E_ARGUMENT, wrong[k].text);
    CU_ASSERT(kernel == NULL);
  }
  sph_context_destroy(&context);
}
#else
static void user_kernel_needs_gsl(void) {
  sph_context *context = new_context();
  double factor = 1;
  sph_kernel *kernel = (sph_kernel *)context;
  SPH_TEST_STATUS(context,
                  sph_kernel_create_user(context, 2, 1, 2, own_w, own_dw, &factor, &kernel),
                  SPH_E_UNAVAILABLE, "needs a build with GSL; make configure GSL=1");
  CU_ASSERT(kernel == NULL);
  sph_context_destroy(&context);
}
#endif

static void names_and_rows(void) {
  sph_context *context = new_context();
  CU_ASSERT(sph_kernel_count() == BUILT_IN + 1);
  for (int type = 1; type <= sph_kernel_count(); type++) {
    sph_kernel_type found = (sph_kernel_type)0;
    const char *name = sph_kernel_name((sph_kernel_type)type);
    SPH_TEST_OK(context, sph_kernel_find(context, name, &found));
    CU_ASSERT((int)found == type);
    CU_ASSERT_STRING_EQUAL(name, type <= BUILT_IN ? expected[type - 1].name : "user");
    CU_ASSERT(strlen(sph_kernel_summary((sph_kernel_type)type)) > 10);
    CU_ASSERT(strlen(sph_kernel_source((sph_kernel_type)type)) > 5);
  }
  CU_ASSERT_STRING_EQUAL(sph_kernel_name((sph_kernel_type)0), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_kernel_summary((sph_kernel_type)8), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_kernel_source((sph_kernel_type)-1), "unknown");
  sph_kernel_type type = SPH_KERNEL_GAUSSIAN;
  SPH_TEST_STATUS(context, sph_kernel_find(context, "wendland-c3", &type), SPH_E_NAME,
                  "unknown kernel \"wendland-c3\"; did you mean \"wendland-c2\"?");
  SPH_TEST_STATUS(context, sph_kernel_find(context, "", &type), SPH_E_NAME, "unknown kernel \"\"");
  SPH_TEST_STATUS(context, sph_kernel_find(context, "a name far from all of them", &type),
                  SPH_E_NAME, "unknown kernel");
  SPH_TEST_STATUS(context, sph_kernel_find(context, NULL, &type), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_kernel_find(context, "user", NULL), SPH_E_ARGUMENT, "NULL");
  CU_ASSERT(sph_kernel_find(NULL, "user", &type) == SPH_E_ARGUMENT);
  CU_ASSERT(type == SPH_KERNEL_GAUSSIAN);
  sph_context_destroy(&context);
}

/* sph_kernel_create or, for SPH_KERNEL_USER, sph_kernel_create_user with good functions. */
static sph_status create_any(sph_context *context, int type, int dim, double h, sph_kernel **out) {
  static double factor = 1;
  if (type == SPH_KERNEL_USER)
    return sph_kernel_create_user(context, dim, h, 2, own_w, own_dw, &factor, out);
  return sph_kernel_create(context, (sph_kernel_type)type, dim, h, out);
}

static void creation_checks_arguments(void) {
  sph_context *context = new_context();
  sph_kernel *kernel = NULL;
  const int types[] = {SPH_KERNEL_WENDLAND_C2, SPH_KERNEL_USER};
  for (int k = 0; k < 2; k++) {
    const int t = types[k];
    SPH_TEST_STATUS(context, create_any(context, t, 0, 1, &kernel), SPH_E_ARGUMENT,
                    "dim must be 1 to 3, got 0");
    SPH_TEST_STATUS(context, create_any(context, t, 4, 1, &kernel), SPH_E_ARGUMENT,
                    "dim must be 1 to 3, got 4");
    SPH_TEST_STATUS(context, create_any(context, t, 2, 0, &kernel), SPH_E_ARGUMENT,
                    "h must be finite and > 0 m, got 0");
    SPH_TEST_STATUS(context, create_any(context, t, 2, -0.01, &kernel), SPH_E_ARGUMENT,
                    "got -0.01");
    SPH_TEST_STATUS(context, create_any(context, t, 2, NAN, &kernel), SPH_E_ARGUMENT, "got nan");
    SPH_TEST_STATUS(context, create_any(context, t, 2, INFINITY, &kernel), SPH_E_ARGUMENT,
                    "got inf");
    SPH_TEST_STATUS(context, create_any(context, t, 2, 1, NULL), SPH_E_ARGUMENT,
                    "out must not be NULL");
    kernel = (sph_kernel *)context;
    CU_ASSERT(create_any(NULL, t, 2, 1, &kernel) == SPH_E_ARGUMENT);
    CU_ASSERT(kernel == NULL);
  }
  for (int t = 1; t <= sph_kernel_count(); t++) {
#ifndef SPHI_GSL
    if (t == SPH_KERNEL_USER) continue;
#endif
    SPH_TEST_STATUS(context, create_any(context, t, 3, 1e-70, &kernel), SPH_E_ARGUMENT,
                    "h = 1e-70 m overflows in h^-5");
    SPH_TEST_STATUS(context, create_any(context, t, 3, 1e90, &kernel), SPH_E_ARGUMENT,
                    "h = 1e+90 m overflows in h^-5");
  }
  const int unknown[] = {0, 8, -1};
  for (int k = 0; k < 3; k++)
    SPH_TEST_STATUS(context, sph_kernel_create(context, (sph_kernel_type)unknown[k], 2, 1, &kernel),
                    SPH_E_ARGUMENT, "type must be one of sph_kernel_type, 1 to 7, got");
  SPH_TEST_STATUS(context, sph_kernel_create(context, SPH_KERNEL_USER, 2, 1, &kernel),
                  SPH_E_ARGUMENT, "call sph_kernel_create_user()");
  double factor = 1;
  SPH_TEST_STATUS(context, sph_kernel_create_user(context, 2, 1, 2, NULL, own_dw, &factor, &kernel),
                  SPH_E_ARGUMENT, "w and dw must not be NULL");
  SPH_TEST_STATUS(context, sph_kernel_create_user(context, 2, 1, 2, own_w, NULL, &factor, &kernel),
                  SPH_E_ARGUMENT, "w and dw must not be NULL");
  const double ratios[] = {0, -1, NAN, INFINITY};
  for (int k = 0; k < 4; k++)
    SPH_TEST_STATUS(
        context, sph_kernel_create_user(context, 2, 1, ratios[k], own_w, own_dw, &factor, &kernel),
        SPH_E_ARGUMENT, "ratio of support to h must be finite and > 0, got");
  CU_ASSERT(kernel == NULL);
  sph_context_destroy(&context);
}

static void evaluation_checks_arguments(void) {
  sph_context *context = new_context();
  sph_kernel *kernel = new_kernel(context, SPH_KERNEL_GAUSSIAN, 2, 1);
  double r[3] = {0.5, 1, -1e-9}, w[3] = {7, 7, 7}, dw[3] = {7, 7, 7};
  SPH_TEST_STATUS(context, sph_kernel_evaluate(kernel, 3, r, w, dw), SPH_E_ARGUMENT,
                  "kernel \"gaussian\": distance r[2] must be >= 0 m, got -1e-09");
  r[1] = NAN;
  SPH_TEST_STATUS(context, sph_kernel_evaluate(kernel, 3, r, w, dw), SPH_E_ARGUMENT,
                  "r[1] must be >= 0 m, got nan");
  SPH_TEST_STATUS(context, sph_kernel_evaluate(kernel, -1, r, w, dw), SPH_E_ARGUMENT,
                  "n must be >= 0, got -1");
  SPH_TEST_STATUS(context, sph_kernel_evaluate(kernel, 1, NULL, w, dw), SPH_E_ARGUMENT,
                  "r must not be NULL");
  SPH_TEST_STATUS(context, sph_kernel_evaluate(kernel, 1, r, NULL, NULL), SPH_E_ARGUMENT,
                  "must not both be NULL");
  CU_ASSERT(sph_kernel_evaluate(NULL, 1, r, w, dw) == SPH_E_ARGUMENT);
  for (int k = 0; k < 3; k++) CU_ASSERT(w[k] == 7 && dw[k] == 7);
  CU_ASSERT(isnan(sph_kernel_w(NULL, 1)) && isnan(sph_kernel_dw(NULL, 1)));
  CU_ASSERT(isnan(sph_kernel_w(kernel, NAN)) && isnan(sph_kernel_dw(kernel, NAN)));
  CU_ASSERT(isnan(sph_kernel_w(kernel, -1)) && isnan(sph_kernel_dw(kernel, -1)));
  CU_ASSERT(isnan(sph_kernel_get_h(NULL)) && isnan(sph_kernel_get_support(NULL)));
  CU_ASSERT(isnan(sph_kernel_get_normalization(NULL)));
  CU_ASSERT(sph_kernel_get_dim(NULL) == 0 && sph_kernel_get_type(NULL) == 0);
  sph_kernel_destroy(&kernel);
  sph_context_destroy(&context);
}

static void failed_allocations_leave_nothing(void) {
  sph_test_memory m = {1, 0};
  const sph_allocator allocator = {sph_test_allocate, sph_test_release, &m};
  sph_context *context = NULL;
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &context) == SPH_OK);
  for (int type = 1; type <= sph_kernel_count(); type++) {
#ifndef SPHI_GSL
    if (type == SPH_KERNEL_USER) continue;
#endif
    const int needed = type == SPH_KERNEL_USER ? 4 : 1; /* a user kernel has tables and samples */
    for (int k = 0; k <= needed; k++) {
      sph_kernel *kernel = NULL;
      m.allowed = k;
      const sph_status status = create_any(context, type, 2, 1, &kernel);
      CU_ASSERT(status == (k < needed ? SPH_E_MEMORY : SPH_OK));
      CU_ASSERT((kernel != NULL) == (k == needed));
      if (status != SPH_OK)
        CU_ASSERT(strstr(sph_context_message(context), "out of memory") != NULL);
      sph_kernel_destroy(&kernel);
      CU_ASSERT(m.live == 1);
    }
  }
  sph_context_destroy(&context);
  CU_ASSERT(m.live == 0);
}

static void kernel_outlives_the_context_handle(void) {
  sph_test_memory m = {100, 0};
  const sph_allocator allocator = {sph_test_allocate, sph_test_release, &m};
  sph_context *context = NULL;
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &context) == SPH_OK);
  sph_kernel *kernel = new_kernel(context, SPH_KERNEL_GAUSSIAN, 2, 1);
  sph_context_destroy(&context);
  CU_ASSERT(sph_kernel_w(kernel, 0.5) > 0);
  sph_kernel_destroy(&kernel);
  CU_ASSERT(kernel == NULL);
  CU_ASSERT(m.live == 0);
  sph_kernel_destroy(&kernel);
  sph_kernel_destroy(NULL);
}

#ifdef SPHI_GSL
#define USER_KERNEL_TESTS                                                                         \
  {"the quadrature refines where a user kernel is narrow", quadrature_refines},                   \
      {"a user kernel reproduces wendland-c2 and its sigma", user_kernel_is_the_built_in},        \
      {"tables of every kernel reach 1e-8 and serve float lanes", any_kernel_can_be_tabulated}, { \
    "a user kernel with wrong functions is refused", user_kernel_checks_its_functions             \
  }
#else
#define USER_KERNEL_TESTS \
  { "a user kernel is unavailable without GSL", user_kernel_needs_gsl }
#endif

SPH_TEST_MAIN(
    "kernel", {"integral is 1 for every kernel in 1D, 2D and 3D", integral_is_one},
    {"sigma, W(0), support and second moment are the published ones", constants_are_published},
    {"W equals the polynomials as printed", values_are_the_printed_polynomials},
    {"first moment is 0 and sum V grad W x is I on a lattice", lattice_moments},
    {"dW/dr equals central differences of W", derivative_is_of_the_value},
    {"W falls monotonically and is exactly 0 from the support on", falls_to_zero_and_stays},
    {"arrays equal single points bit by bit", arrays_equal_single_points},
    {"float lanes equal the scalar functions, exactly 0 outside", float_lanes_equal_scalars},
    USER_KERNEL_TESTS, {"names are found, unknown ones get a suggestion", names_and_rows},
    {"creation refuses wrong arguments", creation_checks_arguments},
    {"evaluation refuses wrong arguments and writes nothing", evaluation_checks_arguments},
    {"failed allocations are reported and leak nothing", failed_allocations_leave_nothing},
    {"a kernel outlives the handle of its context", kernel_outlives_the_context_handle})
