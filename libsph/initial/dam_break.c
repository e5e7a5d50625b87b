/* Pressure of a dam-break column just after the gate is gone, equation (3) of <sph/initial.h>.
 *
 * With s = L - x, (-1)^n cos(l_n x) = sin(l_n s), and with kappa = g/c0^2 the part of (3) that
 * converges slowly near the bed is
 *
 *     (2/L) sum_n sin(l_n s) e^(-l_n y) (1/l_n^2 + kappa/l_n^3)
 *         = (8 L/pi^2) Im chi_2(e^-w) + (16 kappa L^2/pi^3) Im chi_3(e^-w),
 *     w = pi (y - i s) / (2 L),    chi_m(z) = sum_{k odd} z^k / k^m    (Legendre's chi function)
 *
 * What is left has terms of the order of e^(-l_n y) kappa^2/l_n^4 and e^(-l_n (2H - y))/l_n^2 and is
 * summed until a bound on its tail is small enough. All lengths below are in column heights: H = 1. */
#include <complex.h>
#include <sph/initial.h>

#include "core/internal.h"

static const double pi = 3.14159265358979323846;
static const double tolerance = 1e-12;    /* bound on the tail, relative to rho0 g H */
static const double longest_column = 1e3; /* length/height: beyond, the parts cancel too much */
static const double least_bracket = 1e-6; /* least l_0 - kappa tanh(l_0 H), relative to l_0 */

typedef struct column {
  double length;
  double kappa;    /* g/c0^2, 0 for an incompressible fluid */
  double pressure; /* rho0 g H in Pa */
} column;

/* sum_m (-1)^(m+1) / m^(2k), Dirichlet's eta function at 2k. */
static double eta_even(int k) {
  static const double low[] = {
      0.82246703342411321824, 0.94703282949724591758, 0.9855510912974351041,
      0.99623300185264789923, 0.99903950759827156564, 0.99975768514385819085,
      0.99993917034597971817, 0.99998476421490610644, 0.99999618786961011348,
      0.99999904661158152212, 0.99999976161323082255};
  if (k <= (int)(sizeof low / sizeof low[0])) return low[k - 1];
  return 1.0 - pow(4.0, -k) + pow(9.0, -k);
}

/* Im chi_2 and Im chi_3 at e^-w, for Re w >= 0 and |Im w| <= pi/2. */
static void chi_imaginary(double complex w, double *chi2, double *chi3) {
  const double a = creal(w), b = cimag(w);
  *chi2 = *chi3 = 0.0;
  if (a > 1.0) {
    for (int k = 1; k * a < 45.0; k += 2) {
      const double term = -exp(-k * a) * sin(k * b) / ((double)k * k);
      *chi2 += term;
      *chi3 += term / k;
    }
    return;
  }
  if (a == 0.0 && b == 0.0) return;
  /* d chi_3/dw = -chi_2, d chi_2/dw = ln(tanh(w/2))/2, and
   * ln tanh(w/2) = ln(w/2) + sum_k (-1)^k eta(2k)/k (w/pi)^(2k), integrated term by term. */
  const double complex u = -(w / pi) * (w / pi); /* |u| < 0.36 */
  double complex power = 1.0, once = 0.0, twice = 0.0;
  for (int k = 1; k <= 40; k++) {
    power *= u;
    const double complex term = eta_even(k) / (k * (2.0 * k + 1.0)) * power;
    once += term;
    twice += term / (2.0 * k + 2.0);
  }
  const double complex logarithm = clog(0.5 * w);
  *chi2 = 0.5 * cimag(w * (logarithm - 1.0 + once));
  *chi3 = -0.125 * pi * pi * b - 0.5 * cimag(w * w * (0.5 * logarithm - 0.75 + twice));
}

/* Whether the terms from number `terms` on sum to less than the tolerance. A convex f obeys
 * f(l_n) <= (L/pi) times its integral over l_n -+ pi/(2L), so the tail is at most an integral from
 * m = terms pi/L on. */
static bool tail_is_small(const column *c, double y, double terms) {
  const double m = terms * pi / c->length, a = 2.0 - y;
  if (m < 2.0 * c->kappa) return false; /* from there on 1/(l - kappa) <= 2/l */
  const double compressible = 4.0 / (3.0 * pi) * c->kappa * c->kappa / (m * m * m) * exp(-m * y);
  const double depth = 12.0 / pi * exp(-m * a) / m * fmin(1.0, 1.0 / (a * m));
  return compressible + depth <= tolerance;
}

static int64_t term_count(const column *c, double y) {
  int64_t low = 0, high = 1; /* not small at low, small at high */
  while (!tail_is_small(c, y, (double)high)) {
    low = high;
    high *= 2;
  }
  while (high - low > 1) {
    const int64_t middle = low + (high - low) / 2;
    if (tail_is_small(c, y, (double)middle))
      high = middle;
    else
      low = middle;
  }
  return high;
}

static double pressure_at(const column *c, double x, double y) {
  const double L = c->length, s = L - x;
  if (s <= 0.0 || y >= 1.0) return 0.0;
  const double step = pi / L, first = 0.5 * step;
  const int64_t terms = term_count(c, y);
  /* By recurrence: wave = e^(-l (y - i s)), top = e^(-2 l (1 - y)), bed = e^(-2 l). */
  double complex wave = cexp(-first * (y - I * s));
  const double complex wave_ratio = cexp(-step * (y - I * s));
  double top = exp(-2.0 * first * (1.0 - y)), bed = exp(-2.0 * first);
  const double top_ratio = exp(-2.0 * step * (1.0 - y)), bed_ratio = exp(-2.0 * step);
  double sum = 0.0;
  for (int64_t n = 0; n < terms; n++) {
    const double l = first + (double)n * step, kappa = c->kappa;
    /* The term of (3) less 1/l^2 + kappa/l^3, multiplied out so that nothing cancels. */
    const double left = kappa * kappa * (1.0 - bed) - 2.0 * kappa * l * bed - l * l * (top + bed);
    const double bracket = l * (1.0 + bed) - kappa * (1.0 - bed);
    sum += cimag(wave) * left / (l * l * l * bracket);
    wave *= wave_ratio;
    top *= top_ratio;
    bed *= bed_ratio;
  }
  double chi2, chi3;
  chi_imaginary(first * (y - I * s), &chi2, &chi3);
  const double closed =
      8.0 * L / (pi * pi) * chi2 + 16.0 * c->kappa * L * L / (pi * pi * pi) * chi3;
  return c->pressure * (closed + 2.0 / L * sum);
}

static sph_status check_column(sph_context *context, double length, double height, double gravity,
                               double density, double sound_speed) {
  const struct {
    const char *name, *unit;
    double value;
  } positive[] = {{"length", "m", length},
                  {"height", "m", height},
                  {"gravity", "m/s^2", gravity},
                  {"density", "kg/m^3", density}};
  for (int k = 0; k < 4; k++)
    SPH_CHECK(context, isfinite(positive[k].value) && positive[k].value > 0, SPH_E_ARGUMENT,
              "dam-break pressure: %s must be > 0 %s, got %g", positive[k].name, positive[k].unit,
              positive[k].value);
  SPH_CHECK(context, length <= longest_column * height, SPH_E_ARGUMENT,
            "dam-break pressure: length must be at most %g heights, got %g m of %g m",
            longest_column, length, height);
  SPH_CHECK(context, isfinite(sound_speed) && sound_speed >= 0, SPH_E_ARGUMENT,
            "dam-break pressure: sound speed must be >= 0 m/s, got %g", sound_speed);
  if (sound_speed == 0) return SPH_OK;
  const double l = 0.5 * pi / length, least = sqrt(gravity * tanh(l * height) / l);
  SPH_CHECK(context, sound_speed * sound_speed * (1.0 - least_bracket) > least * least,
            SPH_E_ARGUMENT,
            "dam-break pressure: sound speed must be > %g m/s for a bounded solution, got %g; "
            "use 0 for an incompressible fluid",
            least, sound_speed);
  return SPH_OK;
}

sph_status sph_initial_dam_break_pressure(sph_context *context, double length, double height,
                                          double gravity, double density, double sound_speed,
                                          int64_t n, const double *xy, double *pressure) {
  if (!context) return SPH_E_ARGUMENT;
  SPH_TRY(check_column(context, length, height, gravity, density, sound_speed));
  SPH_CHECK(context, n >= 0, SPH_E_ARGUMENT,
            "dam-break pressure: number of points must be >= 0, got %lld", (long long)n);
  SPH_CHECK(context, n == 0 || (xy && pressure), SPH_E_ARGUMENT, "dam-break pressure: %s is NULL",
            xy ? "pressure" : "xy");
  const column c = {.length = length / height,
                    .kappa = sound_speed > 0 ? gravity / sound_speed * (height / sound_speed) : 0.0,
                    .pressure = density * gravity * height};
  SPH_CHECK(context, isfinite(c.pressure), SPH_E_ARGUMENT,
            "dam-break pressure: density %g, gravity %g and height %g give no finite pressure",
            density, gravity, height);
  for (int64_t k = 0; k < n; k++) {
    const double x = xy[2 * k], y = xy[2 * k + 1];
    SPH_CHECK(context, x >= 0 && x <= length && y >= 0 && y <= height, SPH_E_ARGUMENT,
              "dam-break pressure: point %lld (%g, %g) m must be in the column 0 <= x <= %g, "
              "0 <= y <= %g",
              (long long)k, x, y, length, height);
  }
#ifdef _OPENMP
#pragma omp parallel for num_threads(context->threads) schedule(static, 64) if (n > 256)
#endif
  for (int64_t k = 0; k < n; k++)
    pressure[k] = pressure_at(&c, xy[2 * k] / height, xy[2 * k + 1] / height);
  return SPH_OK;
}
