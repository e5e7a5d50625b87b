/* The solitary wave of Euler's equations.
 *
 * In the frame of the wave the strip -1 < Im zeta < 0 is mapped onto the water, z(zeta) = x + i (y - 1),
 * in such a way that -c zeta is the complex potential. Of the surface, eta(alpha) solves Babenko's
 * equation, in which C has the symbol k coth k:
 *
 *     (c^2 C - 1) eta = eta C eta + C(eta^2)/2                                        (1)
 *
 * Clamond and Dutykh (2013), doi:10.1016/j.compfluid.2013.05.010, iterate on (1) after Petviashvili:
 * eta <- S^2 (c^2 C - 1)^-1 (right-hand side), where the factor S keeps the iterates from growing or
 * dying. Here c is not given but the height: each step takes the c that gives the crest its height.
 * That fixes the size of the iterates too, so S is left out, and it goes on past the fastest wave,
 * H/d = 0.796, where c no longer tells waves apart.
 *
 * With the amplitudes a_k of eta, step kappa of the wave numbers, and c_k = a_k/(1 - exp(-2 k kappa)),
 *
 *     z = zeta + (zeta + i) a_0 + i sum_k c_k (F^k - G^k)                             (2)
 *     F = exp(-i kappa zeta),  G = exp(i kappa (zeta + 2 i))
 *     u - i v = c - c/z'(zeta)                                                        (3)
 *
 * |F| and |G| are at most 1 in the water. */
#include <complex.h>

#include "wave/wave_list.h"

#ifdef SPHI_GSL
#include <gsl/gsl_fft_halfcomplex.h>
#include <gsl/gsl_fft_real.h>

static const double pi = 3.14159265358979323846;
/* Half of the periodic domain, in decay lengths: exp(-38) = 3e-17. */
static const double half_length = 38;

/* Half a wave, X >= 0: nodes of equal steps in alpha. */
struct sphi_wave_map {
  int modes;
  double kappa, mean; /* step of wave numbers, a_0 */
  double *c;          /* c_k, k = 1 .. modes, at [k - 1] */
  int nodes;
  double step;                     /* of alpha */
  double *x, *eta, *slope, *curve; /* eta, eta', eta'' as functions of x */
};

typedef struct solver {
  int n;                      /* points, a power of two; the crest is the first */
  double length;              /* half of the period in alpha */
  double height, mu;          /* H/d, c^2 - 1 */
  double *eta, *last, *a, *b; /* [n] */
  double *symbol, *excess;    /* k coth k, k coth k - 1 [n/2 + 1] */
} solver;

static void forward(double *values, int n) { gsl_fft_real_radix2_transform(values, 1, (size_t)n); }

static void inverse(double *spectrum, int n) {
  gsl_fft_halfcomplex_radix2_inverse(spectrum, 1, (size_t)n);
}

/* k coth k - 1, to the last digits also where it is small. */
static double coth_excess(double k) {
  const double q = k * k;
  return k < 0.1 ? q * (1.0 / 3 - q * (1.0 / 45 - q * (2.0 / 945 - q / 4725))) : k / tanh(k) - 1;
}

static void fill_symbols(const solver *s) {
  for (int k = 0; k <= s->n / 2; k++) {
    s->excess[k] = coth_excess(k * pi / s->length);
    s->symbol[k] = 1 + s->excess[k];
  }
}

/* The c^2 - 1 for which sum_k a_k/(c^2 C_k - 1) is the height, by Newton's method on a falling convex
 * function. */
static void fit_celerity(solver *s) {
  for (int step = 0; step < 60; step++) {
    double sum = 0, slope = 0;
    for (int k = 0; k <= s->n / 2; k++) {
      const double weight = k == 0 || k == s->n / 2 ? s->a[k] : 2 * s->a[k];
      const double linear = s->mu * s->symbol[k] + s->excess[k];
      sum += weight / linear;
      slope -= weight * s->symbol[k] / (linear * linear);
    }
    double change = (s->height * s->n - sum) / slope;
    if (s->mu + change <= 0) change = -0.5 * s->mu;
    s->mu += change;
    if (fabs(change) <= 1e-15 * s->mu) return;
  }
}

/* One step of the iteration. Gives the largest change of eta, and the largest amplitude among the
 * highest tenth of the wave numbers relative to the largest of all. */
static double iterate(solver *s, double *tail) {
  const int n = s->n, half = n / 2;
  const size_t bytes = (size_t)n * sizeof(double);
  memcpy(s->last, s->eta, bytes);
  memcpy(s->a, s->eta, bytes);
  forward(s->a, n);
  for (int k = 0; k < n; k++) s->a[k] = k <= half ? s->a[k] * s->symbol[k] : 0; /* eta is even */
  inverse(s->a, n);
  for (int i = 0; i < n; i++) {
    s->a[i] *= s->eta[i];
    s->b[i] = s->eta[i] * s->eta[i];
  }
  forward(s->a, n);
  forward(s->b, n);
  for (int k = 0; k <= half; k++) s->a[k] += 0.5 * s->symbol[k] * s->b[k];
  fit_celerity(s);
  double top = 0, high = 0;
  for (int k = 0; k < n; k++) {
    s->eta[k] = k <= half ? s->a[k] / (s->mu * s->symbol[k] + s->excess[k]) : 0;
    top = fmax(top, fabs(s->eta[k]));
    if (k > 0.9 * half) high = fmax(high, fabs(s->eta[k]));
  }
  *tail = high / top;
  inverse(s->eta, n);
  double change = 0;
  for (int i = 0; i < n; i++) change = fmax(change, fabs(s->eta[i] - s->last[i]));
  return change;
}

static void solver_free(sph_context *context, solver *s) {
  double *const arrays[] = {s->eta, s->last, s->a, s->b, s->symbol, s->excess};
  for (int k = 0; k < 6; k++) sphi_free(context, arrays[k]);
}

/* The same surface on n points, or the starting one. */
static sph_status resize(sph_context *context, solver *s, int n, double decay) {
  solver finer = *s;
  finer.n = n;
  finer.eta = SPHI_NEW(context, n, double);
  finer.last = SPHI_NEW(context, n, double);
  finer.a = SPHI_NEW(context, n, double);
  finer.b = SPHI_NEW(context, n, double);
  finer.symbol = SPHI_NEW(context, n / 2 + 1, double);
  finer.excess = SPHI_NEW(context, n / 2 + 1, double);
  if (!finer.eta || !finer.last || !finer.a || !finer.b || !finer.symbol || !finer.excess) {
    solver_free(context, &finer);
    return SPHI_ERROR(context, SPH_E_MEMORY, "wave \"exact\": out of memory");
  }
  if (s->eta) {
    forward(s->eta, s->n);
    for (int k = 0; k <= s->n / 2; k++) finer.eta[k] = s->eta[k] * n / s->n;
    inverse(finer.eta, n);
  } else {
    for (int i = 0; i < n; i++) {
      const double alpha = fmin(i, n - i) * 2 * s->length / n, e = exp(-decay * alpha);
      finer.eta[i] = s->height * 4 * e / ((1 + e) * (1 + e));
    }
  }
  solver_free(context, s);
  *s = finer;
  fill_symbols(s);
  return SPH_OK;
}

/* Coarse grids first: they give finer ones a start. */
static sph_status solve(sph_context *context, solver *s, double decay) {
  enum { FIRST = 1024, LAST = 65536, STEPS = 2000 };
  const double tail_wanted = 1e-15, change_wanted = 1e-14;
  for (int n = FIRST; n <= LAST; n *= 2) {
    SPH_TRY(resize(context, s, n, decay));
    double change = INFINITY, tail = 1, enough = 0;
    for (int k = 0; k < STEPS && change > enough; k++) {
      change = iterate(s, &tail);
      enough = s->height * (tail > tail_wanted ? fmax(0.01 * tail, change_wanted) : change_wanted);
    }
    if (!isfinite(change)) break;
    if (tail <= tail_wanted && change <= s->height * change_wanted) return SPH_OK;
  }
  return SPHI_ERROR(context, SPH_E_NOT_CONVERGED,
                    "wave \"exact\": no solution for H/d = %g on %d points; use \"fenton\"",
                    s->height, LAST);
}

static void map_free(sph_wave *wave) {
  sphi_wave_map *map = wave->map;
  if (!map) return;
  double *const arrays[] = {map->c, map->x, map->eta, map->slope, map->curve};
  for (int k = 0; k < 5; k++) sphi_free(wave->context, arrays[k]);
  sphi_free(wave->context, map);
  wave->map = NULL;
}

static double coth(double k) { return 1 / tanh(k); }

/* Values of sum_k factor(k) a_k cos(k alpha), or sin, on the first half of a grid of `n` points. */
typedef enum quantity { ETA, ETA_1, ETA_2, X_PERIODIC, X_1, X_2 } quantity;
static void synthesize(const double *spectrum, int modes, double kappa, quantity what, int n,
                       double *work, double *half) {
  memset(work, 0, (size_t)n * sizeof *work);
  const bool odd = what == ETA_1 || what == X_PERIODIC || what == X_2;
  for (int k = what == ETA || what == X_1 ? 0 : 1; k <= modes; k++) {
    const double q = k * kappa;
    const double C = 1 + coth_excess(q);
    const double factor = what == ETA          ? 1
                          : what == ETA_1      ? q
                          : what == ETA_2      ? -q * q
                          : what == X_PERIODIC ? -coth(q)
                          : what == X_1        ? C
                                               : q * C;
    work[odd ? n - k : k] = factor * spectrum[k]; /* imaginary or real part */
  }
  inverse(work, n);
  memcpy(half, work, ((size_t)n / 2 + 1) * sizeof *half);
}

/* The table of the surface, on a grid twice as fine as the solution's. */
static sph_status build_table(sph_wave *wave, const solver *s) {
  sphi_wave_map *map = wave->map;
  const int n = 2 * s->n, nodes = n / 2 + 1;
  double *const work = SPHI_NEW(wave->context, n + 2 * nodes, double);
  map->x = SPHI_NEW(wave->context, nodes, double);
  map->eta = SPHI_NEW(wave->context, nodes, double);
  map->slope = SPHI_NEW(wave->context, nodes, double);
  map->curve = SPHI_NEW(wave->context, nodes, double);
  const bool enough = work && map->x && map->eta && map->slope && map->curve;
  if (enough) {
    double *const x1 = work + n, *const x2 = x1 + nodes;
    double *const spectrum = s->a; /* of the finer grid */
    for (int k = 0; k <= map->modes; k++) spectrum[k] *= 2;
    synthesize(spectrum, map->modes, map->kappa, ETA, n, work, map->eta);
    synthesize(spectrum, map->modes, map->kappa, ETA_1, n, work, map->slope);
    synthesize(spectrum, map->modes, map->kappa, ETA_2, n, work, map->curve);
    synthesize(spectrum, map->modes, map->kappa, X_PERIODIC, n, work, map->x);
    synthesize(spectrum, map->modes, map->kappa, X_1, n, work, x1);
    synthesize(spectrum, map->modes, map->kappa, X_2, n, work, x2);
    map->nodes = nodes;
    map->step = 2 * s->length / n;
    for (int i = 0; i < nodes; i++) {
      map->x[i] += (1 + map->mean) * i * map->step;
      x1[i] += 1;
      map->slope[i] /= x1[i];
      map->curve[i] = (map->curve[i] - map->slope[i] * x2[i]) / (x1[i] * x1[i]);
      const double weight = i == 0 || i == nodes - 1 ? map->step : 2 * map->step;
      wave->volume += weight * map->eta[i] * x1[i]; /* integral of eta dx */
    }
  }
  sphi_free(wave->context, work);
  SPH_CHECK(wave->context, enough, SPH_E_MEMORY, "wave \"exact\": out of memory");
  return SPH_OK;
}

static sph_status build_map(sph_wave *wave, const solver *s) {
  sph_context *context = wave->context;
  wave->map = SPHI_NEW(context, 1, sphi_wave_map);
  SPH_CHECK(context, wave->map, SPH_E_MEMORY, "wave \"exact\": out of memory");
  sphi_wave_map *map = wave->map;
  memcpy(s->a, s->eta, (size_t)s->n * sizeof(double));
  forward(s->a, s->n);
  double top = 0;
  for (int k = 0; k < s->n / 2; k++) top = fmax(top, fabs(s->a[k]));
  map->modes = s->n / 2 - 1;
  while (map->modes > 1 && fabs(s->a[map->modes]) <= 1e-16 * top) map->modes--;
  map->kappa = pi / s->length;
  map->mean = s->a[0] / s->n;
  map->c = SPHI_NEW(context, map->modes, double);
  SPH_CHECK(context, map->c, SPH_E_MEMORY, "wave \"exact\": out of memory");
  for (int k = 1; k <= map->modes; k++)
    map->c[k - 1] = -2 * s->a[k] / s->n / expm1(-2 * k * map->kappa);
  return build_table(wave, s);
}

/* The tail exp(-q |X|) obeys c^2 = tan q/q. tan q - c^2 q is convex, so that Newton's method falls
 * onto the root from its right, where q = sqrt(3 (c^2 - 1)) is. */
static double tail_rate(double mu) {
  double q = sqrt(3 * mu);
  for (int k = 0; k < 100; k++) {
    const double cosine = cos(q),
                 change = (tan(q) - (1 + mu) * q) / (1 / (cosine * cosine) - 1 - mu);
    q -= change;
    if (!(change > 1e-15 * q)) break;
  }
  return q;
}

static sph_status prepare(sph_wave *wave) {
  const double e = wave->ratio, third_order = e * (1 - e / 20 - 3.0 / 70 * e * e);
  const double decay = tail_rate(third_order);
  solver s = {.height = e, .mu = third_order, .length = half_length / decay};
  sph_status status = solve(wave->context, &s, decay);
  if (status == SPH_OK) {
    wave->celerity = sqrt(1 + s.mu);
    wave->decay = 0.5 * tail_rate(s.mu);
    status = build_map(wave, &s);
  }
  solver_free(wave->context, &s);
  return status;
}

/* The node at or before x >= 0, which is before the last node. */
static int find_node(const sphi_wave_map *map, double x) {
  int low = 0, high = map->nodes - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (map->x[middle] <= x)
      low = middle;
    else
      high = middle;
  }
  return low;
}

/* The quintic with value, slope and curvature of two nodes. */
static void profile(const sph_wave *wave, double X, double *elevation, double *slope) {
  const sphi_wave_map *map = wave->map;
  const double x = fabs(X);
  *elevation = *slope = 0;
  if (x >= map->x[map->nodes - 1]) return;
  const int i = find_node(map, x);
  const double h = map->x[i + 1] - map->x[i], t = (x - map->x[i]) / h;
  const double a0 = map->eta[i], a1 = h * map->slope[i], a2 = 0.5 * h * h * map->curve[i];
  const double d0 = map->eta[i + 1] - a0 - a1 - a2;
  const double d1 = h * map->slope[i + 1] - a1 - 2 * a2;
  const double d2 = 0.5 * h * h * map->curve[i + 1] - a2;
  const double a3 = 10 * d0 - 4 * d1 + d2, a4 = -15 * d0 + 7 * d1 - 2 * d2;
  const double a5 = 6 * d0 - 3 * d1 + d2;
  *elevation = a0 + t * (a1 + t * (a2 + t * (a3 + t * (a4 + t * a5))));
  *slope = (a1 + t * (2 * a2 + t * (3 * a3 + t * (4 * a4 + t * 5 * a5)))) / h;
  if (X < 0) *slope = -*slope;
}

/* sum_k c_k w^k and sum_k k c_k w^k, k = 1 .. terms, in plain real arithmetic: complex products would
 * look for NaNs. */
static void power_sums(const double *c, int terms, double complex w, double complex *sum,
                       double complex *weighted) {
  const double r = creal(w), i = cimag(w);
  double sr = 0, si = 0, wr = 0, wi = 0;
  for (int k = terms; k >= 1; k--) {
    const double pr = sr + c[k - 1], qr = wr + k * c[k - 1];
    sr = pr * r - si * i;
    si = pr * i + si * r;
    wr = qr * r - wi * i;
    wi = qr * i + wi * r;
  }
  *sum = sr + I * si;
  *weighted = wr + I * wi;
}

/* How many powers of a number exp(-rate) matter. */
static int terms_of(const sphi_wave_map *map, double rate) {
  const double terms = 40 / fmax(rate, 1e-300);
  return terms < map->modes ? (int)terms + 1 : map->modes;
}

/* z(zeta) by (2) and its derivative. */
static void map_point(const sphi_wave_map *map, double complex zeta, double complex *z,
                      double complex *slope) {
  const double kappa = map->kappa, beta = cimag(zeta);
  double complex f, f1, g, g1;
  power_sums(map->c, terms_of(map, -kappa * beta), cexp(-I * kappa * zeta), &f, &f1);
  power_sums(map->c, terms_of(map, kappa * (beta + 2)), cexp(I * kappa * (zeta + 2 * I)), &g, &g1);
  *z = zeta + (zeta + I) * map->mean + I * (f - g);
  *slope = 1 + map->mean + kappa * (f1 + g1);
}

/* Newton's method for z(zeta) = X + i (y - 1), from the place with the same x at the surface. */
static void velocity(const sph_wave *wave, double X, double y, double *w) {
  const sphi_wave_map *map = wave->map;
  const double x = fabs(X);
  w[0] = w[1] = 0;
  if (x >= map->x[map->nodes - 1]) return;
  const int i = find_node(map, x);
  const double part = (x - map->x[i]) / (map->x[i + 1] - map->x[i]);
  const double top = map->eta[i] + part * (map->eta[i + 1] - map->eta[i]);
  double complex zeta = (i + part) * map->step + I * fmin((y - 1 - top) / (1 + top), 0);
  double complex slope = 1;
  for (int step = 0; step < 50; step++) {
    double complex z;
    map_point(map, zeta, &z, &slope);
    const double complex change = (z - (x + I * (y - 1))) / slope;
    zeta -= change;
    if (cimag(zeta) > map->step)
      zeta = creal(zeta); /* not far out of the water: (2) diverges there */
    if (cabs(change) <= 1e-11) break;
  }
  const double complex flow = wave->celerity * (1 - 1 / slope);
  w[0] = creal(flow);
  w[1] = X < 0 ? cimag(flow) : -cimag(flow);
}
#else
static sph_status prepare(sph_wave *wave) {
  return SPHI_ERROR(wave->context, SPH_E_UNAVAILABLE,
                    "wave \"exact\": its Fourier transforms need a build with GSL; make configure "
                    "GSL=1, or use \"fenton\"");
}
#endif

const sphi_wave_theory sphi_wave_exact = {
    .name = "exact",
    .summary = "numerical solution of Euler's equations by a conformal map",
    .source = "Babenko (1987); Clamond and Dutykh (2013)",
    .good_to = 0.79,
    .known_to = 0.79,
    .prepare = prepare,
#ifdef SPHI_GSL
    .release = map_free,
    .profile = profile,
    .velocity = velocity,
    .pressure = sphi_wave_bernoulli,
#endif
};
