/* Initial pressures against published numbers, a stored table, differences and integrations. */
#include "sph_test.h"

#ifndef SPH_TEST_DATA
#define SPH_TEST_DATA "tests/data"
#endif

static const double L = 1.2, H = 0.6, g = 9.81, rho0 = 1000.0, weight = 1000.0 * 9.81 * 0.6;
static sph_context *context;

static void start(void) { CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK); }
static void stop(void) { sph_context_destroy(&context); }

static double column(double length, double height, double c0, double x, double y) {
  const double xy[2] = {x, y};
  double p = NAN;
  SPH_TEST_OK(context,
              sph_initial_dam_break_pressure(context, length, height, g, rho0, c0, 1, xy, &p));
  return p;
}

static void published_values(void) {
  start();
  const double c0 = 20 * sqrt(g * H);
  /* Published from finite sums: 1e-7 rho0 g H is 6e-4 Pa. The last is the sum of 4000 terms, which
   * leaves out half of the next term: rho0 g/(L l^2), l = 4000 pi/L. */
  SPH_TEST_CLOSE(column(L, H, c0, 0, 0), 5486.519, 0, 1e-3);
  SPH_TEST_CLOSE(column(L, H, 0, 0, 0), 5474.334673 + rho0 * g / L / pow(4000 * acos(-1.0) / L, 2),
                 0, 1e-6);
  const double ratios[] = {0.93213, 0.76747, 0.60744, 0.45155, 0.29904, 0.14890};
  for (int k = 0; k < 6; k++)
    SPH_TEST_CLOSE(column(L, H, c0, 0, k * H / 6) / weight, ratios[k], 0, 6e-6);
  SPH_TEST_CLOSE(column(L, H, c0, L / 2, 0) / weight, 0.82539, 0, 6e-6);
  SPH_TEST_CLOSE(column(L, H, c0, 0.9 * L, 0) / weight, 0.36287, 0, 6e-6);
  stop();
}

static void stored_table(void) {
  start();
  FILE *file = fopen(SPH_TEST_DATA "/computed_dambreak_initial_pressure_H0.6_L1.2.csv", "r");
  CU_ASSERT_FATAL(file != NULL);
  const double x[] = {0.0, 0.3, 0.6, 0.9, 1.05, 1.15};
  char line[512];
  int rows = 0;
  while (fgets(line, sizeof line, file)) {
    if (line[0] == '#' || line[0] == 'y') continue;
    char *at = line;
    const double y = strtod(at, &at);
    for (int k = 0; k < 6; k++) {
      const double expected = strtod(at + 1, &at);
      /* The table sums 4000 terms. At the bed these are sin((2n + 1) a) b_n with falling b_n, so that
       * what is left out is less than b_4000/sin(a) (Abel). */
      const double a = acos(-1.0) * (L - x[k]) / (2 * L), l = 4000 * acos(-1.0) / L;
      const double left_out = 2 * rho0 * g / (L * l * l) / sin(a);
      SPH_TEST_CLOSE(column(L, H, 0, x[k], y), expected, 1e-9, y == 0 ? left_out : 1e-9);
    }
    rows++;
  }
  fclose(file);
  CU_ASSERT_EQUAL(rows, 13);
  stop();
}

/* The first terms of equation (3) as it stands. */
static double long_series(double length, double height, double c0, double x, double y,
                          int64_t terms) {
  double sum = 0;
  for (int64_t n = terms - 1; n >= 0; n--) {
    const double l = ((double)n + 0.5) * acos(-1.0) / length, kappa = c0 > 0 ? g / (c0 * c0) : 0.0;
    sum += (n % 2 ? -1 : 1) * cos(l * x) * exp(-l * y) * (1 - exp(-2 * l * (height - y))) /
           (l * (l - kappa * tanh(l * height)) * (1 + exp(-2 * l * height)));
  }
  return 2 * rho0 * g / length * sum;
}

static void agrees_with_long_series(void) {
  start();
  uint64_t seed = 7;
  const double shapes[][2] = {{1.2, 0.6}, {0.3, 2.0}, {30.0, 0.5}, {1.0, 1.0}};
  const double mach[] = {0, 20, 3, 0.0};
  double worst = 0;
  for (int s = 0; s < 4; s++)
    for (int m = 0; m < 4; m++) {
      const double length = shapes[s][0], height = shapes[s][1];
      /* The last speed is close to the least that the bed condition allows. */
      const double l0 = acos(-1.0) / (2 * length);
      const double c0 = m < 3 ? mach[m] * sqrt(g * height) : sqrt(1.2 * g * tanh(l0 * height) / l0);
      for (int k = 0; k < 12; k++) {
        const double x = length * sph_test_random(&seed);
        const double depth = sph_test_random(&seed), y = height * (0.02 + 0.98 * depth * depth);
        const int64_t terms = 10 + (int64_t)(12 * length / y);
        const double expected = long_series(length, height, c0, x, y, terms);
        const double error =
            fabs(column(length, height, c0, x, y) - expected) / (rho0 * g * height);
        worst = fmax(worst, error);
      }
    }
  SPH_TEST_BELOW(worst, 1e-9);
  stop();
}

static void exact_to_the_bed(void) {
  start();
  const double c0 = 20 * sqrt(g * H), y[] = {0, 1e-9, 1e-6, 1e-4, 0.002};
  for (int k = 0; k < 5; k++)
    for (int j = 0; j < 4; j++) {
      const double x = L * (double[]){0, 0.31, 0.5, 0.9}[j];
      const int64_t terms = 200000;
      const double expected =
          0.5 * (long_series(L, H, c0, x, y[k], terms) + long_series(L, H, c0, x, y[k], terms + 1));
      /* Less than 2 L/(pi^2 H sin(pi/20) terms^2) = 7e-11 of rho0 g H is left out there. */
      SPH_TEST_CLOSE(column(L, H, c0, x, y[k]) / weight, expected / weight, 0, 1e-9);
    }
  stop();
}

/* The two ways to sum the closed part meet where pi y/(2L) = 1; pressure is smooth there. */
static void smooth_across_branches(void) {
  start();
  const double y = 2 * 0.3 / acos(-1.0), e = 1e-9;
  for (int k = 0; k <= 4; k++) {
    const double x = 0.3 * k / 4;
    const double below = column(0.3, 2.0, 30, x, y - e), above = column(0.3, 2.0, 30, x, y + e);
    SPH_TEST_BELOW(fabs(above - below) / (rho0 * g * 2.0), 5e-9);
    SPH_TEST_CLOSE(below, long_series(0.3, 2.0, 30, x, y - e, 60), 0, 1e-9 * rho0 * g * 2.0);
  }
  stop();
}

static void solves_laplace(void) {
  start();
  uint64_t seed = 11;
  const double c0 = 5 * sqrt(g * H), d = 0.004;
  for (int k = 0; k < 40; k++) {
    const double x = 0.05 + (L - 0.1) * sph_test_random(&seed);
    const double y = 0.05 + (H - 0.1) * sph_test_random(&seed);
    double p[3][3];
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++) p[i][j] = column(L, H, c0, x + (i - 1) * d, y + (j - 1) * d);
    /* The nine-point stencil is of sixth order for harmonic functions. */
    const double laplace = (4 * (p[0][1] + p[2][1] + p[1][0] + p[1][2]) + p[0][0] + p[0][2] +
                            p[2][0] + p[2][2] - 20 * p[1][1]) /
                           (6 * d * d);
    SPH_TEST_BELOW(fabs(laplace) * H * H / weight, 2e-3);
  }
  stop();
}

/* Derivative at the first of five points d apart, fourth order. */
static double one_sided(const double *p, double d) {
  return (-25 * p[0] + 48 * p[1] - 36 * p[2] + 16 * p[3] - 3 * p[4]) / (12 * d);
}

static void obeys_boundary_conditions(void) {
  start();
  const double speeds[] = {0, 5 * sqrt(g * H), 20 * sqrt(g * H)}, d = 0.002;
  for (int s = 0; s < 3; s++) {
    const double c0 = speeds[s];
    for (int k = 1; k < 10; k++) {
      const double x = L * k / 12.0, y = H * k / 10.0;
      double bed[5], wall[5];
      for (int j = 0; j < 5; j++) {
        bed[j] = column(L, H, c0, x, j * d);
        wall[j] = column(L, H, c0, j * d, y);
      }
      const double rho = c0 > 0 ? rho0 + bed[0] / (c0 * c0) : rho0;
      SPH_TEST_CLOSE(one_sided(bed, d), -rho * g, 2e-6, 0);
      SPH_TEST_CLOSE(one_sided(wall, d), 0, 0, 2e-6 * rho0 * g);
      CU_ASSERT_EQUAL(column(L, H, c0, L, y), 0);
      CU_ASSERT_EQUAL(column(L, H, c0, x, H), 0);
    }
  }
  stop();
}

static void unit_invariance(void) {
  start();
  const double xy[2] = {0.31, 0.17}, big[2] = {310, 170}; /* the latter in mm, g, ms */
  double p, q;
  SPH_TEST_OK(context, sph_initial_dam_break_pressure(context, L, H, g, rho0, 30, 1, xy, &p));
  SPH_TEST_OK(context,
              sph_initial_dam_break_pressure(context, 1200, 600, 0.00981, 1e-3, 30, 1, big, &q));
  SPH_TEST_CLOSE(q / (1e-3 * 0.00981 * 600), p / weight, 1e-13, 0);
  const double huge[2] = {0.31e200, 0.17e200};
  SPH_TEST_OK(context, sph_initial_dam_break_pressure(context, L * 1e200, H * 1e200, g, rho0,
                                                      30e100, 1, huge, &q));
  SPH_TEST_CLOSE(q / (weight * 1e200), p / weight, 1e-13, 0);
  stop();
}

static void threads_give_the_same_bits(void) {
  start();
  enum { N = 1000 };
  static double xy[2 * N], one[N], two[N];
  uint64_t seed = 3;
  for (int k = 0; k < N; k++) {
    xy[2 * k] = L * sph_test_random(&seed);
    xy[2 * k + 1] = k % 10 ? H * sph_test_random(&seed) : 0;
  }
  SPH_TEST_OK(context, sph_initial_dam_break_pressure(context, L, H, g, rho0, 40, N, xy, one));
  if (sph_context_set_threads(context, 2) == SPH_OK) {
    SPH_TEST_OK(context, sph_initial_dam_break_pressure(context, L, H, g, rho0, 40, N, xy, two));
    CU_ASSERT(memcmp(one, two, sizeof one) == 0);
  }
  stop();
}

static void dam_break_refusals(void) {
  start();
  double p[2] = {-7, -7};
  const double xy[4] = {0.1, 0.1, 0.2, 0.2};
  const struct {
    double v[5];
    const char *text;
  } bad[] = {{{0, H, g, rho0, 0}, "length must be > 0 m, got 0"},
             {{NAN, H, g, rho0, 0}, "length must be"},
             {{L, -1, g, rho0, 0}, "height must be > 0 m, got -1"},
             {{L, H, 0, rho0, 0}, "gravity must be > 0 m/s^2, got 0"},
             {{L, H, g, INFINITY, 0}, "density must be > 0 kg/m^3, got inf"},
             {{601, H, g, rho0, 0}, "length must be at most 1000 heights"},
             {{L, H, g, rho0, -1}, "sound speed must be >= 0 m/s, got -1"},
             {{L, H, g, rho0, NAN}, "sound speed must be >= 0 m/s, got nan"},
             {{L, H, g, rho0, 2.0}, "sound speed must be > 2.2"},
             {{L, H, 1e300, 1e300, 0}, "give no finite pressure"}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    const double *v = bad[k].v;
    SPH_TEST_STATUS(context,
                    sph_initial_dam_break_pressure(context, v[0], v[1], v[2], v[3], v[4], 2, xy, p),
                    SPH_E_ARGUMENT, bad[k].text);
  }
  const double outside[][2] = {{-1e-9, 0.1}, {1.3, 0.1}, {0.1, -0.5},
                               {0.1, 0.7},   {NAN, 0},   {0, NAN}};
  for (int k = 0; k < 6; k++) {
    const double points[4] = {0.1, 0.1, outside[k][0], outside[k][1]};
    SPH_TEST_STATUS(context,
                    sph_initial_dam_break_pressure(context, L, H, g, rho0, 0, 2, points, p),
                    SPH_E_ARGUMENT, "point 1 (");
  }
  SPH_TEST_STATUS(context, sph_initial_dam_break_pressure(context, L, H, g, rho0, 0, 2, NULL, p),
                  SPH_E_ARGUMENT, "xy is NULL");
  SPH_TEST_STATUS(context, sph_initial_dam_break_pressure(context, L, H, g, rho0, 0, 2, xy, NULL),
                  SPH_E_ARGUMENT, "pressure is NULL");
  SPH_TEST_STATUS(context, sph_initial_dam_break_pressure(context, L, H, g, rho0, 0, -1, xy, p),
                  SPH_E_ARGUMENT, "number of points must be >= 0, got -1");
  CU_ASSERT_EQUAL(sph_initial_dam_break_pressure(NULL, L, H, g, rho0, 0, 2, xy, p), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_initial_dam_break_pressure(context, L, H, g, rho0, 0, 0, NULL, NULL), SPH_OK);
  CU_ASSERT(p[0] == -7 && p[1] == -7);
  stop();
}

/* dp/dy = -(rho0 + p/c0^2) g downwards from the surface by the classical Runge-Kutta method. */
static double integrated(double depth, double c0) {
  const int steps = 2000;
  const double d = depth / steps;
  double p = 0;
  for (int k = 0; k < steps; k++) {
    const double k1 = (rho0 + p / (c0 * c0)) * g;
    const double k2 = (rho0 + (p + d / 2 * k1) / (c0 * c0)) * g;
    const double k3 = (rho0 + (p + d / 2 * k2) / (c0 * c0)) * g;
    const double k4 = (rho0 + (p + d * k3) / (c0 * c0)) * g;
    p += d / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return p;
}

static void hydrostatic_obeys_its_equation(void) {
  start();
  const double y[] = {-3, -0.5, 0, 0.4, 1.19, 1.2, 5};
  const double speeds[] = {4, 10, 1500};
  for (int s = 0; s < 3; s++) {
    double p[7];
    SPH_TEST_OK(context, sph_initial_hydrostatic(context, 1.2, g, rho0, speeds[s], 7, y, p));
    for (int k = 0; k < 5; k++) SPH_TEST_CLOSE(p[k], integrated(1.2 - y[k], speeds[s]), 1e-11, 0);
    CU_ASSERT(p[5] == 0 && p[6] == 0);
  }
  stop();
}

static void hydrostatic_incompressible(void) {
  start();
  double y[] = {0, 0.5, 1.2, 2}, p[4];
  SPH_TEST_OK(context, sph_initial_hydrostatic(context, 1.2, g, rho0, 0, 4, y, p));
  SPH_TEST_CLOSE(p[0], rho0 * g * 1.2, 1e-15, 0);
  SPH_TEST_CLOSE(p[1], rho0 * g * 0.7, 1e-15, 0);
  CU_ASSERT(p[2] == 0 && p[3] == 0);
  double in_place[] = {0, 0.5, 1.2, 2};
  SPH_TEST_OK(context, sph_initial_hydrostatic(context, 1.2, g, rho0, 1e8, 4, in_place, in_place));
  for (int k = 0; k < 4; k++) SPH_TEST_CLOSE(in_place[k], p[k], 1e-14, 0);
  SPH_TEST_OK(context, sph_initial_hydrostatic(context, 1.2, 0, rho0, 10, 4, y, p));
  CU_ASSERT(p[0] == 0);
  stop();
}

static void hydrostatic_refusals(void) {
  start();
  const double y[2] = {0, 1};
  double p[2] = {-7, -7};
  const struct {
    double v[4];
    const char *text;
  } bad[] = {{{NAN, g, rho0, 0}, "surface level must be finite, got nan"},
             {{1, -1, rho0, 0}, "gravity must be >= 0 m/s^2, got -1"},
             {{1, g, 0, 0}, "density must be > 0 kg/m^3, got 0"},
             {{1, g, rho0, -3}, "sound speed must be >= 0 m/s, got -3"},
             {{1, g, rho0, 0.05}, "point 0 is 1 m deep, too deep"},
             {{1, g, rho0, 1e-200}, "point 0 is 1 m deep, too deep"}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    const double *v = bad[k].v;
    SPH_TEST_STATUS(context, sph_initial_hydrostatic(context, v[0], v[1], v[2], v[3], 2, y, p),
                    SPH_E_ARGUMENT, bad[k].text);
  }
  const double broken[2] = {0, NAN};
  SPH_TEST_STATUS(context, sph_initial_hydrostatic(context, 1, g, rho0, 0, 2, broken, p),
                  SPH_E_ARGUMENT, "y of point 1 must be finite, got nan");
  SPH_TEST_STATUS(context, sph_initial_hydrostatic(context, 1, g, rho0, 0, 2, NULL, p),
                  SPH_E_ARGUMENT, "y is NULL");
  SPH_TEST_STATUS(context, sph_initial_hydrostatic(context, 1, g, rho0, 0, 2, y, NULL),
                  SPH_E_ARGUMENT, "pressure is NULL");
  SPH_TEST_STATUS(context, sph_initial_hydrostatic(context, 1, g, rho0, 0, -2, y, p),
                  SPH_E_ARGUMENT, "number of points must be >= 0, got -2");
  CU_ASSERT_EQUAL(sph_initial_hydrostatic(NULL, 1, g, rho0, 0, 2, y, p), SPH_E_ARGUMENT);
  CU_ASSERT(p[0] == -7 && p[1] == -7);
  stop();
}

SPH_TEST_MAIN(
    "initial", {"dam-break pressure has the published values", published_values},
    {"dam-break pressure agrees with the stored table", stored_table},
    {"dam-break pressure agrees with the plain series for many shapes and sound speeds",
     agrees_with_long_series},
    {"dam-break pressure is exact to 1e-9 down to the bed", exact_to_the_bed},
    {"dam-break pressure is smooth where its two evaluations meet", smooth_across_branches},
    {"dam-break pressure is harmonic", solves_laplace},
    {"dam-break pressure obeys its boundary conditions", obeys_boundary_conditions},
    {"dam-break pressure does not depend on the units", unit_invariance},
    {"dam-break pressure has the same bits with two threads", threads_give_the_same_bits},
    {"dam-break pressure refuses bad arguments", dam_break_refusals},
    {"hydrostatic pressure obeys its differential equation", hydrostatic_obeys_its_equation},
    {"hydrostatic pressure without compressibility is rho g depth", hydrostatic_incompressible},
    {"hydrostatic pressure refuses bad arguments", hydrostatic_refusals})
