/* Waves against published and stored solutions, the equations they solve, and each other. */
#include "sph_test.h"
#include "wave/wave_impl.h"

#ifndef SPH_TEST_DATA
#define SPH_TEST_DATA "tests/data"
#endif

static const double pi = 3.14159265358979323846, g = 9.81;
static sph_context *context;

static void start(void) { CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK); }

static void stop(void) { sph_context_destroy(&context); }

/* In units of depth and gravity. */
static sph_wave *solitary(sph_solitary_theory theory, double ratio) {
  sph_wave *wave = NULL;
  SPH_TEST_OK(context, sph_wave_create_solitary(context, theory, ratio, 1, 1, &wave));
  return wave;
}

static double eta(const sph_wave *wave, double x) {
  double value = NAN;
  SPH_TEST_OK(context, sph_wave_elevation(wave, 0, 1, &x, &value));
  return value;
}

typedef struct flow {
  double u, v, p;
} flow;

static flow flow_at(const sph_wave *wave, double x, double y) {
  const double xy[2] = {x, y};
  double w[2], p;
  SPH_TEST_OK(context, sph_wave_velocity(wave, 0, 1, xy, w));
  SPH_TEST_OK(context, sph_wave_pressure(wave, 1, 0, 1, xy, &p));
  return (flow){w[0], w[1], p};
}

/* Derivative by differences of eighth order. */
static double derivative(const double *f, double h) {
  return (4.0 / 5 * (f[1] - f[-1]) - 1.0 / 5 * (f[2] - f[-2]) + 4.0 / 105 * (f[3] - f[-3]) -
          1.0 / 280 * (f[4] - f[-4])) /
         h;
}

/* u_x, u_y, v_x, v_y */
static void gradients(const sph_wave *wave, double x, double y, double h, double *d) {
  double f[4][9];
  for (int k = -4; k <= 4; k++) {
    const flow a = flow_at(wave, x + k * h, y), b = flow_at(wave, x, y + k * h);
    f[0][k + 4] = a.u;
    f[1][k + 4] = b.u;
    f[2][k + 4] = a.v;
    f[3][k + 4] = b.v;
  }
  for (int k = 0; k < 4; k++) d[k] = derivative(f[k] + 4, h);
}

#ifdef SPHI_GSL
/* Integral over X > 0 of what falls exponentially and is even: the trapezoidal rule converges
 * faster than any power. */
static double integral(const sph_wave *wave, double (*f)(const sph_wave *, double)) {
  const double h = 0.02, end = 40 / (2 * sph_wave_decay(wave));
  double sum = 0.5 * f(wave, 0);
  for (int k = 1; k * h < end; k++) sum += f(wave, k * h);
  return 2 * h * sum;
}

static double eta_squared(const sph_wave *wave, double x) { return eta(wave, x) * eta(wave, x); }
static double bed_speed(const sph_wave *wave, double x) { return flow_at(wave, x, 0).u; }

/* Reads numbers of a line of a CSV file; returns their number. */
static int read_numbers(const char *line, int most, double *values) {
  int count = 0;
  char *end = NULL;
  for (; count < most; count++, line = end + 1) {
    values[count] = strtod(line, &end);
    if (end == line) return count;
    if (*end != ',') return count + 1;
  }
  return count;
}

static FILE *open_data(const char *name) {
  char path[512];
  snprintf(path, sizeof path, SPH_TEST_DATA "/%s", name);
  FILE *file = fopen(path, "r");
  CU_ASSERT_FATAL(file != NULL);
  return file;
}

/* Of the exact wave: e, c^2, c, tail rate, volume, potential and kinetic energy, u at crest and at the
 * bed below. */
static const double published[7][9] = {
    {0.1, 1.09945337, 1.04854822, 0.516249, 0.755552, 0.025047, 0.025994, 0.100153, 0.09298},
    {0.2, 1.19758989, 1.09434450, 0.692058, 1.097656, 0.072295, 0.077478, 0.201266, 0.17346},
    {0.3, 1.29395861, 1.13752302, 0.807075, 1.370744, 0.134314, 0.148068, 0.304481, 0.24313},
    {0.4, 1.38786108, 1.17807516, 0.890525, 1.600507, 0.206925, 0.233932, 0.411354, 0.30299},
    {0.5, 1.47811967, 1.21577945, 0.953904, 1.791478, 0.285514, 0.330198, 0.524317, 0.35331},
    {0.6, 1.56247787, 1.24999115, 1.002700, 1.938825, 0.363515, 0.429219, 0.647930, 0.39349},
    {0.7, 1.63552176, 1.27887519, 1.038817, 2.026281, 0.429249, 0.516557, 0.793569, 0.4210}};

/* Measured against the exact wave in percent: celerity, surface/H, volume, velocity/H, pressure/H, the
 * latter three as in docs/theory/waves.md. */
static const struct {
  sph_solitary_theory theory;
  double celerity[6], surface[6], volume[6], velocity[6], pressure[6];
} errors[] = {{SPH_SOLITARY_BOUSSINESQ,
               {0.02, 0.10, 0.23, 0.44, 0.74, 1.19},
               {2.0, 3.6, 4.7, 5.3, 5.5, 5.3},
               {-3.3, -5.9, -7.7, -8.7, -8.8, -7.7},
               {2.1, 4.1, 6.0, 7.7, 9.3, 10.9},
               {2.0, 3.6, 4.8, 7.8, 10.9, 14.1}},
              {SPH_SOLITARY_KDV,
               {0.14, 0.52, 1.10, 1.86, 2.81, 4.00},
               {2.0, 3.6, 4.7, 5.3, 5.5, 5.3},
               {-3.3, -5.9, -7.7, -8.7, -8.8, -7.7},
               {2.1, 4.0, 5.8, 7.6, 9.7, 12.7},
               {2.0, 3.6, 5.2, 8.6, 12.5, 16.6}},
              {SPH_SOLITARY_RAYLEIGH,
               {0.02, 0.10, 0.23, 0.44, 0.74, 1.19},
               {1.2, 2.6, 4.3, 6.5, 9.1, 12.6},
               {1.4, 3.1, 5.2, 8.0, 11.6, 16.7},
               {1.2, 2.6, 4.5, 7.0, 10.1, 14.1},
               {1.2, 2.6, 4.4, 6.5, 9.1, 12.4}},
              {SPH_SOLITARY_GRIMSHAW,
               {0.000, 0.003, 0.015, 0.05, 0.14, 0.33},
               {0.018, 0.138, 0.43, 0.92, 1.57, 2.2},
               {-0.03, -0.20, -0.64, -1.4, -2.4, -3.3},
               {0.23, 1.8, 5.8, 13.9, 28.8, 53.6},
               {0.22, 1.6, 4.9, 10.6, 19.3, 32.3}},
              {SPH_SOLITARY_FENTON,
               {0, 0, 0, 0, 0.002, 0.017},
               {0, 0, 0.0027, 0.036, 0.257, 1.25},
               {0, 0, 0, -0.05, -0.4, -2.0},
               {0, 0, 0.0037, 0.055, 0.49, 3.0},
               {0, 0, 0.0033, 0.042, 0.295, 1.49}}};

static void exact_has_published_values(void) {
  start();
  for (int k = 0; k < 7; k++) {
    const double *row = published[k];
    sph_wave *wave = solitary(SPH_SOLITARY_EXACT, row[0]);
    const double c = sph_wave_celerity(wave), M = sph_wave_volume(wave);
    SPH_TEST_CLOSE(c * c, row[1], 0, 6e-9);
    SPH_TEST_CLOSE(c, row[2], 0, 6e-9);
    SPH_TEST_CLOSE(2 * sph_wave_decay(wave), row[3], 0, 6e-7);
    SPH_TEST_CLOSE(M, row[4], 0, 6e-7);
    SPH_TEST_CLOSE(sph_wave_stroke(wave), row[4], 0, 6e-7);
    SPH_TEST_CLOSE(0.5 * integral(wave, eta_squared), row[5], 0, 6e-7);
    /* 2 T = c (c M - C), C the circulation along the bed (McCowan 1891) */
    SPH_TEST_CLOSE(0.5 * c * (c * M - integral(wave, bed_speed)), row[6], 0, 6e-7);
    SPH_TEST_CLOSE(flow_at(wave, 0, 2).u, row[7], 0, 6e-7);
    SPH_TEST_CLOSE(flow_at(wave, 0, 0).u, row[8], 0, k == 6 ? 6e-5 : 6e-6);
    sph_wave_destroy(&wave);
  }
  stop();
}

static void exact_has_stored_integrals(void) {
  start();
  FILE *file = open_data("solitary_exact_integral_properties.csv");
  char line[1024];
  double v[13];
  int rows = 0;
  while (fgets(line, sizeof line, file)) {
    if (read_numbers(line, 13, v) < 13) continue;
    sph_wave *wave = solitary(SPH_SOLITARY_EXACT, v[0]);
    sph_wave *third = solitary(SPH_SOLITARY_GRIMSHAW, v[0]);
    sph_wave *first = solitary(SPH_SOLITARY_BOUSSINESQ, v[0]);
    const double c = sph_wave_celerity(wave), M = sph_wave_volume(wave);
    const double V = 0.5 * integral(wave, eta_squared);
    const double T = 0.5 * c * (c * M - integral(wave, bed_speed));
    const flow bed = flow_at(wave, 0, 0);
    SPH_TEST_CLOSE(c, v[1], 1e-11, 0);
    SPH_TEST_CLOSE(sph_wave_celerity(first), v[2], 1e-10, 0);
    SPH_TEST_CLOSE(sph_wave_celerity(third), v[3], 1e-11, 0);
    SPH_TEST_CLOSE(M, v[4], 1e-11, 0);
    SPH_TEST_CLOSE(sph_wave_volume(first), v[5], 1e-11, 0);
    SPH_TEST_CLOSE(V, v[6], 1e-10, 0);
    SPH_TEST_CLOSE(T, v[7], 1e-10, 0);
    SPH_TEST_CLOSE(V + T, v[8], 1e-10, 0);
    SPH_TEST_CLOSE(c * M, v[9], 1e-11, 0);
    SPH_TEST_CLOSE(flow_at(wave, 0, 2).u, v[10], 1e-10, 0);
    SPH_TEST_CLOSE(bed.u, v[11], 1e-11, 0);
    SPH_TEST_CLOSE(bed.p, v[12], 1e-11, 0);
    sph_wave_destroy(&first);
    sph_wave_destroy(&third);
    sph_wave_destroy(&wave);
    rows++;
  }
  fclose(file);
  CU_ASSERT_EQUAL(rows, 15);
  stop();
}

static void exact_has_stored_profiles(void) {
  start();
  FILE *file = open_data("solitary_exact_profiles.csv");
  const double ratios[] = {0.1, 0.2, 0.3, 0.35, 0.4, 0.5, 0.6, 0.625, 0.7};
  sph_wave *waves[9];
  for (int k = 0; k < 9; k++) waves[k] = solitary(SPH_SOLITARY_EXACT, ratios[k]);
  char line[1024];
  double v[10], worst = 0;
  int rows = 0;
  while (fgets(line, sizeof line, file)) {
    if (read_numbers(line, 10, v) < 10) continue;
    for (int k = 0; k < 9; k++) {
      worst = fmax(worst, fabs(eta(waves[k], v[0]) - v[k + 1]));
      worst = fmax(worst, fabs(eta(waves[k], -v[0]) - v[k + 1]));
    }
    rows++;
  }
  fclose(file);
  CU_ASSERT_EQUAL(rows, 401);
  SPH_TEST_BELOW(worst, 1e-9); /* the table's own error */
  for (int k = 0; k < 9; k++) sph_wave_destroy(&waves[k]);
  stop();
}

static void exact_has_stored_fields(void) {
  start();
  for (int k = 0; k < 2; k++) {
    sph_wave *wave = solitary(SPH_SOLITARY_EXACT, k ? 0.6 : 0.2);
    FILE *file = open_data(k ? "computed_solitary_exact_field_H0.6.csv"
                             : "computed_solitary_exact_field_H0.2.csv");
    char line[512];
    double v[5], worst = 0;
    int rows = 0;
    while (fgets(line, sizeof line, file)) {
      if (read_numbers(line, 5, v) < 5) continue;
      const flow f = flow_at(wave, v[0], v[1] + 1), back = flow_at(wave, -v[0], v[1] + 1);
      worst = fmax(worst, fabs(f.u - v[2]) + fabs(f.v - v[3]) + fabs(f.p - v[4]));
      worst = fmax(worst, fabs(f.u - back.u) + fabs(f.v + back.v) + fabs(f.p - back.p));
      rows++;
    }
    fclose(file);
    CU_ASSERT_EQUAL(rows, 1331);
    SPH_TEST_BELOW(worst, 2e-8); /* nine digits are stored, also of the places */
    sph_wave_destroy(&wave);
  }
  stop();
}

static void exact_solves_eulers_equations(void) {
  start();
  const double ratios[] = {1e-4, 0.05, 0.3, 0.6, 0.7, 0.79};
  for (int r = 0; r < 6; r++) {
    const double e = ratios[r], h = 0.01;
    sph_wave *wave = solitary(SPH_SOLITARY_EXACT, e);
    const double c = sph_wave_celerity(wave), rate = 2 * sph_wave_decay(wave);
    double surface = 0, streamline = 0, rotation = 0, divergence = 0;
    uint64_t seed = 5;
    for (int k = 0; k < 300; k++) {
      const double q = sph_test_random(&seed), X = (2 * (k % 2) - 1) * 10 / rate * q * q;
      double height, slope;
      sphi_wave_profile(wave, X, &height, &slope);
      const flow top = flow_at(wave, X, 1 + height - 1e-12);
      surface = fmax(surface, fabs(top.p));
      streamline = fmax(streamline, fabs((top.u - c) * slope - top.v));
      /* The flow goes on above the surface only by its value there. */
      const double y = (1 + eta(wave, fabs(X) + 5 * h) - 5 * h) * sph_test_random(&seed);
      if (y < 5 * h || r > 3) continue;
      double d[4];
      gradients(wave, X, y, h, d);
      divergence = fmax(divergence, fabs(d[0] + d[3]));
      rotation = fmax(rotation, fabs(d[1] - d[2]));
    }
    SPH_TEST_BELOW(surface, 2e-11);
    SPH_TEST_BELOW(streamline, 2e-9);
    SPH_TEST_BELOW(divergence, 1e-9);
    SPH_TEST_BELOW(rotation, 1e-9);
    /* A particle on the crest, by Bernoulli's equation. */
    SPH_TEST_CLOSE(flow_at(wave, 0, 1 + e).u, c - sqrt(c * c - 2 * e), 1e-9, 0);
    SPH_TEST_CLOSE(3 * 0.5 * integral(wave, eta_squared), (c * c - 1) * sph_wave_volume(wave), 1e-9,
                   0);
    SPH_TEST_CLOSE(tan(rate) / rate, c * c, 1e-13, 0);
    const double far = 12 / rate;
    SPH_TEST_CLOSE(log(eta(wave, far) / eta(wave, far + 1)), rate, 1e-4, 0);
    SPH_TEST_CLOSE(eta(wave, 0), e, 1e-13, 0);
    CU_ASSERT(eta(wave, 100 / rate) == 0 && flow_at(wave, -100 / rate, 0.5).u == 0);
    SPH_TEST_CLOSE(flow_at(wave, 100 / rate, 0.25).p, 0.75, 1e-15, 0);
    sph_wave_destroy(&wave);
  }
  stop();
}

/* |actual| has the printed digits of `expected`, 0 standing for less than `zero`. */
static void test_percent(double actual, double expected, double zero, double half_digit) {
  if (expected == 0)
    SPH_TEST_BELOW(fabs(actual), zero);
  else
    SPH_TEST_CLOSE(actual, expected, 0.026, half_digit);
}

static void theories_have_their_errors(void) {
  start();
  for (int r = 0; r < 6; r++) {
    const double e = 0.1 * (r + 1);
    sph_wave *exact = solitary(SPH_SOLITARY_EXACT, e);
    for (size_t t = 0; t < sizeof errors / sizeof errors[0]; t++) {
      sph_wave *wave = solitary(errors[t].theory, e);
      double surface = 0, velocity = 0, pressure = 0;
      for (int k = 0; k <= 200; k++) {
        const double x = 0.05 * k, a = eta(wave, x), b = eta(exact, x);
        surface = fmax(surface, fabs(a - b));
        for (int j = 0; j <= 20; j++) {
          const double y = (1 + fmin(a, b)) * j / 20 * (1 - 1e-12);
          const flow f = flow_at(wave, x, y), f0 = flow_at(exact, x, y);
          velocity = fmax(velocity, hypot(f.u - f0.u, f.v - f0.v));
          pressure = fmax(pressure, fabs(f.p - f0.p));
        }
      }
      test_percent(100 * (sph_wave_celerity(wave) / sph_wave_celerity(exact) - 1),
                   errors[t].celerity[r], 6e-4, 5e-3);
      test_percent(100 * surface / e, errors[t].surface[r], 5e-4, 0);
      test_percent(100 * (sph_wave_volume(wave) / sph_wave_volume(exact) - 1), errors[t].volume[r],
                   5e-3, 5e-3);
      test_percent(100 * velocity / e, errors[t].velocity[r], 5e-4, 0);
      test_percent(100 * pressure / e, errors[t].pressure[r], 5e-4, 0);
      sph_wave_destroy(&wave);
    }
    sph_wave_destroy(&exact);
  }
  stop();
}
#endif

static bool available(int theory) {
#ifdef SPHI_GSL
  return theory >= 1;
#else
  return theory != SPH_SOLITARY_EXACT;
#endif
}

/* All waves that this build has: theories 1 to 6, then regular waves of order 1 and 2. */
enum { KINDS = 8 };
static sph_status create_any(sph_context *in, int kind, double height, double depth, double gravity,
                             sph_wave **out) {
  if (kind <= 6)
    return sph_wave_create_solitary(in, (sph_solitary_theory)kind, height, depth, gravity, out);
  return sph_wave_create_regular(in, kind - 6, height, 6 * sqrt(depth / gravity), depth, gravity,
                                 out);
}

static sph_wave *any_wave(int kind, double height, double depth, double gravity) {
  sph_wave *wave = NULL;
  SPH_TEST_OK(context, create_any(context, kind, height, depth, gravity, &wave));
  return wave;
}

static void theories_are_as_written(void) {
  start();
  const double e = 0.3;
  const double kappa[] = {sqrt(0.75 * e), sqrt(0.75 * e), sqrt(0.75 * e / (1 + e))};
  const double celerity[] = {sqrt(1 + e), 1 + e / 2, sqrt(1 + e)};
  for (int t = 1; t <= 3; t++) {
    sph_wave *wave = solitary((sph_solitary_theory)t, e);
    SPH_TEST_CLOSE(sph_wave_decay(wave), kappa[t - 1], 1e-15, 0);
    SPH_TEST_CLOSE(sph_wave_celerity(wave), celerity[t - 1], 1e-15, 0);
    SPH_TEST_CLOSE(sph_wave_volume(wave), 2 * e / kappa[t - 1], 1e-15, 0);
    SPH_TEST_CLOSE(eta(wave, 1.3), e / pow(cosh(kappa[t - 1] * 1.3), 2), 1e-14, 0);
    sph_wave_destroy(&wave);
  }
  sph_wave *third = solitary(SPH_SOLITARY_GRIMSHAW, e), *ninth = solitary(SPH_SOLITARY_FENTON, e);
  const double a = sph_wave_decay(third), s = 1 / cosh(a), t = tanh(a); /* at X = 1 */
  SPH_TEST_CLOSE(eta(third, 1),
                 e * s * s - 0.75 * e * e * s * s * t * t +
                     e * e * e * (5.0 / 8 * s * s * t * t - 101.0 / 80 * pow(s, 4) * t * t),
                 1e-14, 0);
  for (int k = 0; k < 2; k++) {
    sph_wave *wave = k ? ninth : third;
    double sum = 0.5 * eta(wave, 0);
    for (int i = 1; i < 1000; i++) sum += eta(wave, 0.05 * i);
    SPH_TEST_CLOSE(sph_wave_volume(wave), 2 * 0.05 * sum, 1e-12, 0);
  }
  /* The series agree to the third order. */
  sph_wave *low = solitary(SPH_SOLITARY_GRIMSHAW, 1e-3),
           *high = solitary(SPH_SOLITARY_FENTON, 1e-3);
  SPH_TEST_CLOSE(eta(low, 20), eta(high, 20), 0, 2e-12);
  for (int k = 0; k <= 4; k++) {
    const flow f = flow_at(low, 10, 0.25 * k), f9 = flow_at(high, 10, 0.25 * k);
    SPH_TEST_CLOSE(f.u, f9.u, 0, 2e-12);
    SPH_TEST_CLOSE(f.v, f9.v, 0, 2e-12);
    SPH_TEST_CLOSE(f.p, f9.p, 0, 4e-12);
  }
  sph_wave_destroy(&low);
  sph_wave_destroy(&high);
  sph_wave_destroy(&third);
  sph_wave_destroy(&ninth);
  stop();
}

static void slope_is_the_derivative(void) {
  start();
  uint64_t seed = 9;
  for (int kind = 1; kind <= KINDS; kind++) {
    if (!available(kind)) continue;
    sph_wave *wave = any_wave(kind, 0.24, 0.4, g);
    CU_ASSERT(sphi_wave_is_solitary(wave) == (kind <= 6));
    for (int k = 0; k < 50; k++) {
      const double X = 4 * (sph_test_random(&seed) - 0.5), h = 0.004;
      double f[9], height, slope, unused;
      for (int i = 0; i < 9; i++) sphi_wave_profile(wave, X + (i - 4) * h, &f[i], &unused);
      sphi_wave_profile(wave, X, &height, &slope);
      SPH_TEST_CLOSE(slope, derivative(f + 4, h), 0, kind == 6 ? 1e-8 : 1e-9);
      SPH_TEST_CLOSE(height, eta(wave, X), 0, 1e-15);
    }
    sph_wave_destroy(&wave);
  }
  stop();
}

/* The exact wave has a test of its own. */
static void flows_of_the_theories(void) {
  start();
  for (int t = 1; t <= 5; t++) {
    const bool series = t >= SPH_SOLITARY_GRIMSHAW;
    double rotation[2] = {0, 0}, kinematic[2] = {0, 0};
    for (int r = 0; r < 2; r++) {
      const double e = r ? 0.1 : 0.2;
      sph_wave *wave = solitary((sph_solitary_theory)t, e);
      const double c = sph_wave_celerity(wave);
      for (int k = 0; k < 40; k++) {
        const double X = 0.2 * k - 3.9, h = 0.02;
        double height, slope, d[4];
        sphi_wave_profile(wave, X, &height, &slope);
        const flow top = flow_at(wave, X, 1 + height - 1e-13);
        kinematic[r] = fmax(kinematic[r], fabs((top.u - c) * slope - top.v));
        if (!series) SPH_TEST_BELOW(fabs(top.p), 1e-12);
        SPH_TEST_CLOSE(flow_at(wave, X, 0).v, 0, 0, 0);
        gradients(wave, X, 0.1 + 0.8 * k / 40, h, d);
        if (t != SPH_SOLITARY_GRIMSHAW) SPH_TEST_BELOW(fabs(d[0] + d[3]), 1e-10);
        rotation[r] = fmax(rotation[r], fabs(d[1] - d[2]));
        /* What goes through a section in the frame of the wave is what comes: int u dy = c eta. */
        static const double node[] = {-0.9061798459386640, -0.5384693101056831, 0,
                                      0.5384693101056831, 0.9061798459386640};
        static const double weight[] = {0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                        0.4786286704993665, 0.2369268850561891};
        double flux = 0;
        for (int i = 0; i < 5; i++)
          flux += 0.5 * (1 + height) * weight[i] *
                  flow_at(wave, X, 0.5 * (1 + height) * (1 + node[i])).u;
        SPH_TEST_CLOSE(flux, c * height, 0, !series ? 1e-14 : t == 4 ? 2 * pow(e, 4) : 1e-5 * e);
      }
      sph_wave_destroy(&wave);
    }
    /* The surface is a streamline, or one to the theory's order. */
    if (series) {
      const double order = log2(kinematic[0] / kinematic[1]);
      SPH_TEST_CLOSE(order, t == SPH_SOLITARY_GRIMSHAW ? 4.7 : 10.4, 0, t == 4 ? 0.3 : 1);
    } else {
      SPH_TEST_BELOW(kinematic[0], 1e-12);
    }
    SPH_TEST_BELOW(t <= 3 ? 2.3 : t == 4 ? 3.5 : 8.5, log2(rotation[0] / rotation[1]));
    SPH_TEST_BELOW(rotation[0], t <= 3 ? 0.02 : t == 4 ? 2e-2 : 1e-6);
  }
  stop();
}

static void dispersion_is_solved(void) {
  start();
  for (double kd = 1e-3; kd < 51; kd *= 1.17) {
    const double d = 0.37, omega = sqrt(g * kd / d * tanh(kd));
    double k = NAN;
    SPH_TEST_OK(context, sph_wave_dispersion(context, 2 * pi / omega, d, g, &k));
    SPH_TEST_CLOSE(g * k * tanh(k * d), omega * omega, 4e-15, 0);
    SPH_TEST_CLOSE(k * d, kd, 1e-14, 0);
  }
  /* Published periods of standing waves of length 20 m. */
  const double rows[][2] = {{2, 4.796}, {4.5, 3.797}, {5, 3.73723}, {10, 3.586}};
  for (int r = 0; r < 4; r++) {
    double k;
    SPH_TEST_OK(context, sph_wave_dispersion(context, rows[r][1], rows[r][0], g, &k));
    SPH_TEST_CLOSE(2 * pi / k, 20, 3e-4, 0);
  }
  stop();
}

/* The formulas of the books, in plain hyperbolic functions and units. */
static void regular_waves_are_as_written(void) {
  start();
  const double H = 0.12, T = 2.1, d = 0.7, rho = 998, t = 0.37;
  for (int order = 1; order <= 2; order++) {
    sph_wave *wave = NULL;
    SPH_TEST_OK(context, sph_wave_create_regular(context, order, H, T, d, g, &wave));
    const double k = sph_wave_number(wave), w = 2 * pi / T, a = H / 2;
    SPH_TEST_CLOSE(w * w, g * k * tanh(k * d), 1e-14, 0);
    SPH_TEST_CLOSE(sph_wave_period(wave), T, 1e-14, 0);
    SPH_TEST_CLOSE(sph_wave_length(wave), 2 * pi / k, 1e-14, 0);
    SPH_TEST_CLOSE(sph_wave_celerity(wave), w / k, 1e-14, 0);
    const double sh = sinh(k * d), ch = cosh(k * d);
    for (int n = 0; n < 60; n++) {
      const double x = 0.11 * n - 2, q = k * x - w * t, on = order - 1;
      double height, p;
      SPH_TEST_OK(context, sph_wave_elevation(wave, t, 1, &x, &height));
      SPH_TEST_CLOSE(height,
                     a * cos(q) + on * pi * H * H / (8 * 2 * pi / k) * ch / (sh * sh * sh) *
                                      (2 + cosh(2 * k * d)) * cos(2 * q),
                     0, 1e-15);
      const double y = (d + height) * (n % 7) / 6.0001, z = y - d, xy[2] = {x, y};
      double v[2];
      SPH_TEST_OK(context, sph_wave_velocity(wave, t, 1, xy, v));
      SPH_TEST_OK(context, sph_wave_pressure(wave, rho, t, 1, xy, &p));
      const double c1 = cosh(k * y), s1 = sinh(k * y), c2 = cosh(2 * k * y), s2 = sinh(2 * k * y);
      const double b = on * 0.75 * a * a * w * k / pow(sh, 4);
      SPH_TEST_CLOSE(v[0], a * w * c1 / sh * cos(q) + b * c2 * cos(2 * q), 0, 1e-14);
      SPH_TEST_CLOSE(v[1], a * w * s1 / sh * sin(q) + b * s2 * sin(2 * q), 0, 1e-14);
      const double f = on * rho * g * pi * H * H / (2 * pi / k) / sinh(2 * k * d);
      SPH_TEST_CLOSE(p,
                     -rho * g * z + rho * g * a * c1 / ch * cos(q) +
                         0.75 * f * (c2 / (sh * sh) - 1.0 / 3) * cos(2 * q) - 0.25 * f * (c2 - 1),
                     0, 1e-10);
    }
    sph_wave_destroy(&wave);
  }
  stop();
}

/* Kinematic and dynamic condition at the surface fail by the next order of the height. */
static void regular_waves_have_their_order(void) {
  start();
  for (int order = 1; order <= 2; order++) {
    double error[2][2] = {{0}};
    for (int r = 0; r < 2; r++) {
      sph_wave *wave = NULL;
      SPH_TEST_OK(context,
                  sph_wave_create_regular(context, order, r ? 0.01 : 0.02, 5, 1, 1, &wave));
      const double c = sph_wave_celerity(wave), L = sph_wave_length(wave);
      for (int k = 0; k < 100; k++) {
        double height, slope;
        sphi_wave_profile(wave, k * L / 100, &height, &slope);
        const flow f = flow_at(wave, k * L / 100, (1 + height) * (1 - 1e-14));
        error[0][r] = fmax(error[0][r], fabs((f.u - c) * slope - f.v));
        error[1][r] = fmax(error[1][r], fabs(f.p));
      }
      sph_wave_destroy(&wave);
    }
    for (int k = 0; k < 2; k++) SPH_TEST_CLOSE(log2(error[k][0] / error[k][1]), order + 1, 0, 0.05);
  }
  /* Deep and very shallow water overflow nowhere, and take the limits. */
  sph_wave *deep = NULL, *shallow = NULL;
  SPH_TEST_OK(context, sph_wave_create_regular(context, 2, 0.1, 1, 2000, g, &deep));
  const double k = sph_wave_number(deep), a = 0.05, xy[2] = {0, 2000}, w = 2 * pi;
  double v[2], p;
  SPH_TEST_CLOSE(k, w * w / g, 1e-14, 0);
  SPH_TEST_CLOSE(eta(deep, 0), a + k * a * a / 2, 1e-13, 0);
  SPH_TEST_OK(context, sph_wave_velocity(deep, 0, 1, xy, v));
  SPH_TEST_OK(context, sph_wave_pressure(deep, 1, 0, 1, xy, &p));
  SPH_TEST_CLOSE(v[0], a * w, 1e-11, 0);
  SPH_TEST_CLOSE(p, g * (a - k * a * a / 2), 1e-9, 0);
  SPH_TEST_OK(context, sph_wave_create_regular(context, 1, 1e-9, 1e4, 1, 1, &shallow));
  SPH_TEST_CLOSE(sph_wave_celerity(shallow), 1, 1e-6, 0);
  SPH_TEST_CLOSE(flow_at(shallow, 0, 0.5).u, 0.5e-9, 1e-6, 0);
  sph_wave_destroy(&deep);
  sph_wave_destroy(&shallow);
  stop();
}

static void waves_travel(void) {
  start();
  for (int kind = 1; kind <= KINDS; kind++) {
    if (!available(kind)) continue;
    sph_wave *wave = any_wave(kind, 0.08, 0.4, g), *other = any_wave(kind, 0.08, 0.4, g);
    const double c = sph_wave_celerity(wave), x0 = 3.7, t0 = -1.2, t = 0.9;
    SPH_TEST_CLOSE(eta(wave, 0), kind == 8 ? 0.0446 : kind == 7 ? 0.04 : 0.08, 0, 5e-5);
    for (int direction = -1; direction <= 1; direction += 2) {
      SPH_TEST_OK(context, sph_wave_set_origin(other, x0, t0, direction));
      for (int k = 0; k < 40; k++) {
        const double X = 0.05 * k - 1, xy[2] = {X, 0.012 * k};
        const double there[2] = {x0 + direction * (X + c * (t - t0)), xy[1]};
        double a, b, v[2], w[2], p, q;
        SPH_TEST_OK(context, sph_wave_elevation(wave, 0, 1, &xy[0], &a));
        SPH_TEST_OK(context, sph_wave_elevation(other, t, 1, &there[0], &b));
        SPH_TEST_CLOSE(b, a, 0, 1e-14);
        if (fabs(xy[1] - 0.4 - a) < 1e-12) continue;
        SPH_TEST_OK(context, sph_wave_velocity(wave, 0, 1, xy, v));
        SPH_TEST_OK(context, sph_wave_velocity(other, t, 1, there, w));
        SPH_TEST_CLOSE(w[0], direction * v[0], 0, 1e-13);
        SPH_TEST_CLOSE(w[1], v[1], 0, 1e-13);
        SPH_TEST_OK(context, sph_wave_pressure(wave, 1, 0, 1, xy, &p));
        SPH_TEST_OK(context, sph_wave_pressure(other, 1, t, 1, there, &q));
        SPH_TEST_CLOSE(q, p, 0, 1e-12);
      }
    }
    sph_wave_destroy(&other);
    sph_wave_destroy(&wave);
  }
  stop();
}

static void unit_invariance(void) {
  start();
  for (int kind = 1; kind <= KINDS; kind++) {
    if (!available(kind)) continue;
    /* Metres, kilogrammes and seconds; millimetres, grammes and milliseconds. */
    sph_wave *wave = any_wave(kind, 0.12, 0.4, 9.81), *big = any_wave(kind, 120, 400, 9.81e-3);
    SPH_TEST_CLOSE(sph_wave_celerity(big), sph_wave_celerity(wave), 1e-14, 0);
    if (kind <= 6) {
      SPH_TEST_CLOSE(1e3 * sph_wave_decay(big), sph_wave_decay(wave), 1e-12, 0);
      SPH_TEST_CLOSE(1e-6 * sph_wave_volume(big), sph_wave_volume(wave), 1e-12, 0);
    }
    for (int k = 0; k < 20; k++) {
      const double xy[2] = {0.1 * k, 0.023 * k}, mm[2] = {100.0 * k, 23.0 * k};
      double v[2], w[2], p, q;
      SPH_TEST_OK(context, sph_wave_velocity(wave, 0.3, 1, xy, v));
      SPH_TEST_OK(context, sph_wave_velocity(big, 300, 1, mm, w));
      SPH_TEST_OK(context, sph_wave_pressure(wave, 1000, 0.3, 1, xy, &p));
      SPH_TEST_OK(context, sph_wave_pressure(big, 1e-3, 300, 1, mm, &q));
      SPH_TEST_CLOSE(w[0], v[0], 0, 1e-12);
      SPH_TEST_CLOSE(w[1], v[1], 0, 1e-12);
      SPH_TEST_CLOSE(1e3 * q * 1e3, p, 0, 1e-8); /* g/(mm ms^2) = 1e6 Pa */
    }
    sph_wave_destroy(&wave);
    sph_wave_destroy(&big);
  }
  stop();
}

static void points_outside_the_water(void) {
  start();
  for (int kind = 1; kind <= KINDS; kind++) {
    if (!available(kind)) continue;
    sph_wave *wave = any_wave(kind, 0.1, 0.4, g);
    for (int k = 0; k < 30; k++) {
      const double x = 0.1 * k - 1.5, top = 0.4 + eta(wave, x);
      const flow at = flow_at(wave, x, top * (1 - 1e-13)), above = flow_at(wave, x, top + 0.3);
      SPH_TEST_CLOSE(above.u, at.u, 0, 1e-11);
      SPH_TEST_CLOSE(above.v, at.v, 0, 1e-11);
      CU_ASSERT(above.p == 0);
      const flow bed = flow_at(wave, x, 0), below = flow_at(wave, x, -1e-12);
      CU_ASSERT(below.u == bed.u && below.v == 0 && bed.v == 0 && below.p == bed.p);
    }
    /* Far from a solitary wave the water is at rest. */
    if (kind <= 6) {
      const flow far = flow_at(wave, 1e9, 0.1);
      CU_ASSERT(far.u == 0 && far.v == 0);
      SPH_TEST_CLOSE(far.p, g * 0.3, 1e-14, 0);
    }
    sph_wave_destroy(&wave);
  }
  stop();
}

static void threads_give_the_same_bits(void) {
  start();
  enum { N = 3000 };
  static double xy[2 * N], one[2 * N], two[2 * N];
  uint64_t seed = 3;
  for (int kind = 1; kind <= KINDS; kind++) {
    if (!available(kind)) continue;
    sph_wave *wave = any_wave(kind, 0.1, 0.4, g);
    for (int k = 0; k < N; k++) {
      xy[2 * k] = 4 * sph_test_random(&seed) - 2;
      xy[2 * k + 1] = 0.5 * sph_test_random(&seed);
    }
    for (int what = 0; what < 3; what++) {
      double *const results[] = {one, two};
      for (int threads = 1; threads <= 2; threads++) {
        if (sph_context_set_threads(context, threads) != SPH_OK) break; /* built without OpenMP */
        double *result = results[threads - 1];
        memset(two, 0, sizeof two);
        if (what == 0) SPH_TEST_OK(context, sph_wave_elevation(wave, 0.1, N, xy, result));
        if (what == 1) SPH_TEST_OK(context, sph_wave_velocity(wave, 0.1, N, xy, result));
        if (what == 2) SPH_TEST_OK(context, sph_wave_pressure(wave, 1, 0.1, N, xy, result));
      }
      if (sph_context_get_threads(context) == 2)
        CU_ASSERT(memcmp(one, two, what == 1 ? sizeof one : sizeof one / 2) == 0);
    }
    /* In place. */
    memcpy(two, xy, sizeof xy);
    SPH_TEST_OK(context, sph_wave_velocity(wave, 0.1, N, xy, one));
    SPH_TEST_OK(context, sph_wave_velocity(wave, 0.1, N, two, two));
    CU_ASSERT(memcmp(one, two, sizeof one) == 0);
    sph_wave_destroy(&wave);
  }
  stop();
}

static void reflection_formulas(void) {
  start();
  /* e, fully nonlinear run-up, orders 2 and 3, largest force over that at rest */
  const double rows[][5] = {
      {0.05, 0.1013, 0.1013, 0.1013, 1.2069}, {0.1, 0.2056, 0.2050, 0.2058, 1.4245},
      {0.2, 0.4241, 0.4200, 0.4260, 1.8725},  {0.25, 0.5395, 0.5312, 0.5430, 2.0922},
      {0.3, 0.6602, 0.6450, 0.6653, 2.3014},  {0.35, 0.7875, 0.7612, 0.7934, 2.4954},
      {0.4, 0.9237, 0.8800, 0.9280, 2.6779},  {0.43, 1.0110, 0.9525, 1.0121, 2.7889},
      {0.45, 1.0721, 1.0012, 1.0696, 2.8647}, {0.5, 1.2384, 1.1250, 1.2188, 3.0618},
      {0.55, 1.4321, 1.2513, 1.3760, 3.2700}, {0.6, 1.6677, 1.3800, 1.5420, 3.4888}};
  for (size_t r = 0; r < sizeof rows / sizeof rows[0]; r++) {
    const double e = rows[r][0], d = 0.4;
    sph_wave *wave = NULL;
    SPH_TEST_OK(context,
                sph_wave_create_solitary(context, SPH_SOLITARY_FENTON, e * d, d, g, &wave));
    SPH_TEST_CLOSE(sph_wave_runup(wave, 1) / d, 2 * e, 1e-14, 0);
    SPH_TEST_CLOSE(sph_wave_runup(wave, 2) / d, rows[r][2], 0, 6e-5);
    SPH_TEST_CLOSE(sph_wave_runup(wave, 3) / d, rows[r][3], 0, 6e-5);
    const double within = e <= 0.4 ? 0.01 : e <= 0.5 ? 0.017 : 0.08;
    SPH_TEST_CLOSE(sph_wave_runup(wave, 3) / d, rows[r][1], within, 0);
    const double force = sph_wave_wall_force(wave, 1000) / (500 * g * d * d);
    if (e <= 0.5) SPH_TEST_CLOSE(force, rows[r][4], e <= 0.4 ? 0.007 : 0.021, 0);
    SPH_TEST_BELOW(e <= 0.45 ? 0 : force, e <= 0.45 ? 1 : rows[r][4]);
    CU_ASSERT(isnan(sph_wave_runup(wave, 0)) && isnan(sph_wave_runup(wave, 4)));
    sph_wave_destroy(&wave);
  }
  sph_wave *airy = any_wave(7, 0.1, 1, g);
  CU_ASSERT(isnan(sph_wave_runup(airy, 1)) && isnan(sph_wave_wall_force(airy, 1000)));
  CU_ASSERT(isnan(sph_wave_runup(NULL, 1)) && isnan(sph_wave_wall_force(NULL, 1000)));
  sph_wave_destroy(&airy);
  stop();
}

#ifdef SPHI_GSL
#define EXACT_TESTS                                                                        \
  {"the exact wave has the published numbers", exact_has_published_values},                \
      {"the exact wave has the stored integrals", exact_has_stored_integrals},             \
      {"the exact wave has the stored profiles within 1e-9 d", exact_has_stored_profiles}, \
      {"the exact wave has the stored flow within 2e-8", exact_has_stored_fields},         \
      {"the exact wave solves Euler's equations, its integrals are consistent",            \
       exact_solves_eulers_equations},                                                     \
      {"the theories differ from the exact wave by what is documented",                    \
       theories_have_their_errors},
#else
#define EXACT_TESTS
#endif

SPH_TEST_MAIN(
    "wave", EXACT_TESTS{"profiles, celerities and series are as written", theories_are_as_written},
    {"slopes are derivatives of profiles, of every wave", slope_is_the_derivative},
    {"flows conserve mass, have no divergence, and rotation of the theory's order",
     flows_of_the_theories},
    {"the dispersion relation is solved to round-off", dispersion_is_solved},
    {"regular waves have the formulas of the books", regular_waves_are_as_written},
    {"regular waves fail by the next order, and take the limits", regular_waves_have_their_order},
    {"waves travel both ways from any origin", waves_travel},
    {"results do not depend on units", unit_invariance},
    {"points above the surface and at the bed", points_outside_the_water},
    {"one and two threads give the same bits, also in place", threads_give_the_same_bits},
    {"run-up and force at a wall against the fully nonlinear ones", reflection_formulas})
