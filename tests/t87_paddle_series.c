/* Paddles from series, files and functions, and what paddles refuse. */
#include <locale.h>
#include <unistd.h>

#include "paddle_world.h"

enum { MANY = 20000 };

static sph_paddle *new_series(int64_t n, const double *t, const double *x) {
  sph_paddle *paddle = NULL;
  SPH_TEST_OK(context, sph_paddle_create_series(context, n, t, x, &paddle));
  return paddle;
}

/* A cubic with velocity zero at both ends is its own clamped spline. */
static void cubics_are_exact(void) {
  start();
  const double t[] = {1, 1.1, 1.7, 2.05, 3.9, 4}, length = 3;
  double x[6];
  for (int k = 0; k < 6; k++) {
    const double s = (t[k] - 1) / length;
    x[k] = 0.02 + 0.3 * s * s * (3 - 2 * s);
  }
  sph_paddle *paddle = new_series(6, t, x);
  for (int k = 0; k <= 300; k++) {
    const double s = k / 300.0;
    const motion m = at(paddle, 1 + length * s);
    SPH_TEST_CLOSE(m.x, 0.02 + 0.3 * s * s * (3 - 2 * s), 0, 1e-15);
    SPH_TEST_CLOSE(m.v, 0.3 * 6 * s * (1 - s) / length, 0, 1e-14);
    if (k > 0 && k < 300) SPH_TEST_CLOSE(m.a, 0.3 * (6 - 12 * s) / (length * length), 0, 2e-13);
  }
  CU_ASSERT(sph_paddle_start(paddle) == 1 && sph_paddle_end(paddle) == 4);
  SPH_TEST_CLOSE(sph_paddle_stroke(paddle), 0.3, 1e-14, 0);
  CU_ASSERT(at(paddle, 0.5).x == x[0] && at(paddle, 9).x == x[5] && at(paddle, 9).v == 0);
  WARNED("acceleration jumps by 0.2 m/s^2 at the start and 0.2 m/s^2 at the end");
  sph_paddle_destroy(&paddle);
  /* Two points: the cubic between two places at rest. */
  paddle = new_series(2, t, x);
  SPH_TEST_CLOSE(at(paddle, 1.05).x, 0.5 * (x[0] + x[1]), 1e-14, 0);
  SPH_TEST_CLOSE(at(paddle, 1.05).v, 1.5 * (x[1] - x[0]) / 0.1, 1e-12, 0);
  sph_paddle_destroy(&paddle);
  stop();
}

/* Starts and ends at rest, also in acceleration: x = sin^4 over one arch. */
static double arch(double t) { return pow(sin(t), 4); }

static double spline_error(int n, double *rate_error) {
  static double t[MANY], x[MANY];
  for (int k = 0; k < n; k++) { /* uneven, but by a smooth rule */
    const double s = (double)k / (n - 1);
    t[k] = pi * (s + 0.1 * sin(2 * pi * s) / pi);
    x[k] = arch(t[k]);
  }
  t[n - 1] = pi;
  sph_paddle *paddle = new_series(n, t, x);
  double worst = 0;
  *rate_error = 0;
  for (int k = 0; k <= 5000; k++) {
    const double s = pi * k / 5000;
    const motion m = at(paddle, s);
    worst = fmax(worst, fabs(m.x - arch(s)));
    *rate_error = fmax(*rate_error, fabs(m.v - 4 * pow(sin(s), 3) * cos(s)));
  }
  sph_paddle_destroy(&paddle);
  return worst;
}

static void fourth_order(void) {
  start();
  double rate[3];
  const double error[] = {spline_error(51, &rate[0]), spline_error(101, &rate[1]),
                          spline_error(201, &rate[2])};
  WARNED(NULL);
  for (int k = 0; k < 2; k++) {
    SPH_TEST_CLOSE(log2(error[k] / error[k + 1]), 4, 0, 0.15);
    SPH_TEST_CLOSE(log2(rate[k] / rate[k + 1]), 3, 0, 0.15);
  }
  stop();
}

static void twice_differentiable(void) {
  start();
  enum { N = 60 };
  double t[N], x[N];
  uint64_t seed = 9;
  for (int k = 0; k < N; k++) {
    t[k] = (k ? t[k - 1] : -3) + 0.05 + sph_test_random(&seed);
    x[k] = sph_test_random(&seed);
  }
  sph_paddle *paddle = new_series(N, t, x);
  double low = INFINITY, high = -INFINITY;
  for (int k = 1; k < N - 1; k++) {
    const motion a = at(paddle, nextafter(t[k], -9)), b = at(paddle, t[k]);
    SPH_TEST_CLOSE(b.x, x[k], 0, 1e-14);
    SPH_TEST_CLOSE(a.x, b.x, 0, 1e-12);
    SPH_TEST_CLOSE(a.v, b.v, 0, 1e-11);
    SPH_TEST_CLOSE(a.a, b.a, 0, 1e-9);
  }
  for (int k = 0; k <= 200000; k++) {
    const double y = at(paddle, t[0] + (t[N - 1] - t[0]) * k / 200000).x;
    low = fmin(low, y);
    high = fmax(high, y);
  }
  SPH_TEST_CLOSE(sph_paddle_stroke(paddle), high - low, 1e-6, 0);
  CU_ASSERT(sph_paddle_stroke(paddle) >= high - low);
  sph_paddle_destroy(&paddle);
  stop();
}

/* ---------------------------------------------------------------------------------- files */

static char path[64];

static void write_file(const char *text, size_t bytes) {
  snprintf(path, sizeof path, "/tmp/sph_paddle_%ld.csv", (long)getpid());
  FILE *file = fopen(path, "wb");
  CU_ASSERT_FATAL(file != NULL);
  CU_ASSERT_FATAL(fwrite(text, 1, bytes, file) == bytes);
  fclose(file);
}

static sph_status read_text(const char *text, sph_paddle **out) {
  write_file(text, strlen(text));
  const sph_status status = sph_paddle_create_csv(context, path, "t", "x", out);
  remove(path);
  return status;
}

static void round_trip(void) {
  start();
  static double t[MANY], x[MANY];
  static char text[MANY * 80];
  size_t length = (size_t)snprintf(text, sizeof text, "# made by a test\nx, t ,other\n");
  uint64_t seed = 2;
  for (int k = 0; k < MANY; k++) {
    t[k] = 0.01 * k + 0.005 * sph_test_random(&seed);
    x[k] = sph_test_random(&seed) - 0.5;
    length +=
        (size_t)snprintf(text + length, sizeof text - length, "%.17g,%.17g,a%d\n", x[k], t[k], k);
  }
  sph_paddle *one = new_series(MANY, t, x), *two;
  SPH_TEST_OK(context, read_text(text, &two));
  for (int k = 0; k < 2000; k++) {
    const motion a = at(one, 0.0987 * k), b = at(two, 0.0987 * k);
    CU_ASSERT(memcmp(&a, &b, sizeof a) == 0);
  }
  sph_paddle_destroy(&one);
  sph_paddle_destroy(&two);
  stop();
}

static void forms_of_files(void) {
  start();
  const char *const same[] = {"t,x\n0,0\n1,0.5\n2,1\n",
                              "\n# c\n\nt,x\r\n0,0\r\n# in between\r\n1,0.5\r\n\r\n2,1",
                              "\xef\xbb\xbf\"t\", \"x\"\n 0 ,\t0\n1e0,+5e-1\n\"2\",\"1\"\n",
                              "name,x,\"a,b\",t\nfoo,0,\"1,2\",0\nbar,0.5,,1\n,1,nan,2\n"};
  double quarter = 0;
  for (int k = 0; k < 4; k++) {
    sph_paddle *paddle;
    SPH_TEST_OK(context, read_text(same[k], &paddle));
    const double x = at(paddle, 0.5).x;
    if (k == 0) quarter = x;
    CU_ASSERT(x == quarter && at(paddle, 1).x == 0.5 && sph_paddle_end(paddle) == 2);
    sph_paddle_destroy(&paddle);
  }
  /* The decimal point does not depend on the locale. */
  if (setlocale(LC_ALL, "de_DE.UTF-8") || setlocale(LC_ALL, "fr_FR.UTF-8")) {
    sph_paddle *paddle;
    SPH_TEST_OK(context, read_text(same[0], &paddle));
    CU_ASSERT(at(paddle, 1).x == 0.5);
    sph_paddle_destroy(&paddle);
    setlocale(LC_ALL, "C");
  }
  stop();
}

/* The velocity of the spline through a computed tank's displacements is the tank's. */
static void computed_tank(void) {
  start();
  sph_paddle *paddle;
  SPH_TEST_OK(context,
              sph_paddle_create_csv(context, SPH_TEST_DATA "/computed_liang_tank_H0.5_fixed.csv",
                                    "t_s", "x_piston_m", &paddle));
  SPH_TEST_CLOSE(sph_paddle_stroke(paddle), 0.3264784, 0, 1e-6);
  /* Rows of the file. */
  SPH_TEST_CLOSE(at(paddle, 0.8210098).v, 0.5321209, 0, 1e-6);
  SPH_TEST_CLOSE(at(paddle, 0.8210098).x, 0.1114219, 0, 1e-9);
  SPH_TEST_CLOSE(at(paddle, 0.9138196).v, 0.5718391, 0, 1e-6);
  sph_paddle_destroy(&paddle);
  SPH_TEST_STATUS(
      context,
      sph_paddle_create_csv(context, SPH_TEST_DATA "/computed_liang_tank_H0.5_fixed.csv", "t_s",
                            "x_piston", &paddle),
      SPH_E_NAME, "did you mean \"x_piston_m\"?");
  stop();
}

static void hostile_files(void) {
  start();
  const struct {
    const char *text;
    sph_status status;
    const char *message;
  } bad[] = {
      {"", SPH_E_IO, "has no header line"},
      {"# only\n\n# comments", SPH_E_IO, "has no header line"},
      {"t,x\n", SPH_E_ARGUMENT, "at least 2 rows, got 0"},
      {"t,x\n0,0\n", SPH_E_ARGUMENT, "at least 2 rows, got 1"},
      {"t,y\n0,0\n1,1\n", SPH_E_NAME, "line 1: no column is named \"x\"; did you mean \"t\"?"},
      {"# a\nt,x,t\n0,0,0\n", SPH_E_NAME, "line 2: two columns are named \"t\""},
      {"t,x\n0,0\n1\n", SPH_E_IO, "line 3: 1 fields, the header has 2"},
      {"t,x\n0,0\n1,2,3\n", SPH_E_IO, "line 3: 3 fields, the header has 2"},
      {"t,x\n0,0\n1,2 3\n", SPH_E_IO, "column \"x\" has \"2 3\", which is no number"},
      {"t,x\n0,0\n1,\n", SPH_E_IO, "line 3: column \"x\" has \"\", which is no number"},
      {"t,x\n0,0\none,1\n", SPH_E_IO, "column \"t\" has \"one\", which is no number"},
      {"t,x\n0,0\n1,0.5e\n", SPH_E_IO, "which is no number"},
      {"t,x\n0,0\n1,nan\n", SPH_E_ARGUMENT, "line 3: column \"x\" must be finite, got \"nan\""},
      {"t,x\n0,0\n1e999,1\n", SPH_E_ARGUMENT, "line 3: column \"t\" must be finite"},
      {"t,x\n0,0\n\n1,1\n1,2\n", SPH_E_ARGUMENT,
       "line 5: time 1 s must be after the one before, 1 s"},
      {"t,x\n0,0\n2,1\n1,2\n", SPH_E_ARGUMENT,
       "line 4: time 1 s must be after the one before, 2 s"},
      {"t,x\n0,\"0\n1,1\n", SPH_E_IO, "line 2: a quote does not end"}};
  sph_paddle *paddle = NULL;
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    SPH_TEST_STATUS(context, read_text(bad[k].text, &paddle), bad[k].status, bad[k].message);
    CU_ASSERT_PTR_NULL(paddle);
  }
  write_file("t,x\n0,0\n1,\0001\n", 13);
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, path, "t", "x", &paddle), SPH_E_IO,
                  "line 3: a zero byte; this is no text");
  static char wide[70000];
  memset(wide, 'a', sizeof wide);
  write_file(wide, sizeof wide);
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, path, "t", "x", &paddle), SPH_E_IO,
                  "line 1: longer than 65535 bytes");
  memset(wide, ',', sizeof wide);
  write_file(wide, 60000);
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, path, "t", "x", &paddle), SPH_E_IO,
                  "line 1: more than 4096 fields");
  /* Noise. */
  uint64_t seed = 4;
  for (int k = 0; k < 300; k++) {
    char noise[200] = "t,x\n0,0\n";
    for (int j = 8; j < 199; j++)
      noise[j] = "0123456789.,,\n\n\"-e# \r\x01"[(int)(sph_test_random(&seed) * 21)];
    const sph_status status = read_text(noise, &paddle);
    CU_ASSERT(status == SPH_OK || status == SPH_E_IO || status == SPH_E_ARGUMENT);
    CU_ASSERT((paddle != NULL) == (status == SPH_OK));
    sph_paddle_destroy(&paddle);
  }
  remove(path);
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, path, "t", "x", &paddle), SPH_E_IO,
                  "cannot be opened: No such file");
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, "/tmp", "t", "x", &paddle), SPH_E_IO,
                  "cannot be read: ");
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, "/dev/zero", "t", "x", &paddle), SPH_E_IO,
                  "line 1: a zero byte");
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, NULL, "t", "x", &paddle), SPH_E_ARGUMENT,
                  "must not be NULL");
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, path, NULL, "x", &paddle), SPH_E_ARGUMENT,
                  "must not be NULL");
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, path, "t", NULL, &paddle), SPH_E_ARGUMENT,
                  "must not be NULL");
  SPH_TEST_STATUS(context, sph_paddle_create_csv(context, path, "t", "x", NULL), SPH_E_ARGUMENT,
                  "out is NULL");
  CU_ASSERT_EQUAL(sph_paddle_create_csv(NULL, path, "t", "x", &paddle), SPH_E_ARGUMENT);
  stop();
}

/* ------------------------------------------------------------------------------- refusals */

static void series_refusals(void) {
  start();
  sph_paddle *p = (sph_paddle *)&p;
  const double t[] = {0, 1, 1, 2}, back[] = {0, 2, 1.5}, x[] = {0, 1, 2, 3};
  const double broken[] = {0, NAN, 2}, endless[] = {0, 1, INFINITY}, wide[] = {-1e308, 1e308};
  const double near[] = {0, 1e-300, 1};
  const struct {
    int64_t n;
    const double *t, *x;
    const char *text;
  } bad[] = {{4, t, x, "time 2, 1 s, must be after time 1, 1 s"},
             {3, back, x, "time 2, 1.5 s, must be after time 1, 2 s"},
             {3, broken, x, "time 1 must be finite, got nan s"},
             {3, endless, x, "time 2 must be finite, got inf s"},
             {3, x, broken, "displacement 1 must be finite, got nan m"},
             {1, x, x, "at least 2 points, got 1"},
             {-5, x, x, "at least 2 points, got -5"},
             {2, NULL, x, "t is NULL"},
             {2, x, NULL, "displacement is NULL"},
             {2, wide, x, "overflows after point 0"},
             {3, near, x, "overflows after point 0"}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    SPH_TEST_STATUS(context, sph_paddle_create_series(context, bad[k].n, bad[k].t, bad[k].x, &p),
                    SPH_E_ARGUMENT, bad[k].text);
    CU_ASSERT_PTR_NULL(p);
  }
  SPH_TEST_STATUS(context, sph_paddle_create_series(context, 2, x, x, NULL), SPH_E_ARGUMENT,
                  "out is NULL");
  CU_ASSERT_EQUAL(sph_paddle_create_series(NULL, 2, x, x, &p), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(context, sph_paddle_create_function(context, NULL, NULL, &p), SPH_E_ARGUMENT,
                  "function is NULL");
  SPH_TEST_STATUS(context, sph_paddle_create_function(context, swing, NULL, NULL), SPH_E_ARGUMENT,
                  "out is NULL");
  CU_ASSERT_EQUAL(sph_paddle_create_function(NULL, swing, NULL, &p), SPH_E_ARGUMENT);
  stop();
}

static void solitary_refusals(void) {
  start();
  sph_wave *wave;
  SPH_TEST_OK(context,
              sph_wave_create_solitary(context, SPH_SOLITARY_RAYLEIGH, 0.1, 0.2, g, &wave));
  typedef sph_status create(sph_context *, const sph_wave *, double, sph_paddle **);
  create *const of[] = {sph_paddle_create_solitary, sph_paddle_create_solitary_closed};
  for (int k = 0; k < 2; k++) {
    sph_paddle *p = NULL;
    SPH_TEST_STATUS(context, of[k](context, NULL, 0, &p), SPH_E_ARGUMENT, "wave is NULL");
    SPH_TEST_STATUS(context, of[k](context, wave, NAN, &p), SPH_E_ARGUMENT,
                    "start time must be finite, got nan s");
    SPH_TEST_STATUS(context, of[k](context, wave, 0, NULL), SPH_E_ARGUMENT, "out is NULL");
    CU_ASSERT_EQUAL(of[k](NULL, wave, 0, &p), SPH_E_ARGUMENT);
    SPH_TEST_OK(context, of[k](context, wave, 0, &p));
    const double end = sph_paddle_end(p);
    SPH_TEST_STATUS(context, sph_paddle_set_ends(p, 1e-7, 0), SPH_E_ARGUMENT,
                    "must be 1e-6 to 0.1, got 1e-07");
    SPH_TEST_STATUS(context, sph_paddle_set_ends(p, NAN, 0), SPH_E_ARGUMENT, "got nan");
    SPH_TEST_STATUS(context, sph_paddle_set_ends(p, 0.2, 0), SPH_E_ARGUMENT, "got 0.2");
    SPH_TEST_STATUS(context, sph_paddle_set_ends(p, 0.01, -1), SPH_E_ARGUMENT,
                    "duration must be >= 0 s, got -1");
    SPH_TEST_STATUS(context, sph_paddle_set_ends(p, 0.01, 5), SPH_E_ARGUMENT,
                    "duration must be at most 0.");
    SPH_TEST_STATUS(context, sph_paddle_set_flap(p, 0), SPH_E_UNSUPPORTED, "that of a piston");
    SPH_TEST_STATUS(context, sph_paddle_set_ramp(p, 1), SPH_E_TYPE, "have a ramp");
    SPH_TEST_STATUS(context, sph_paddle_set_depth(p, 1), SPH_E_TYPE, "have a depth already, 0.2 m");
    CU_ASSERT_EQUAL(sph_paddle_end(p), end);
    sph_paddle_destroy(&p);
  }
  CU_ASSERT_EQUAL(sph_paddle_set_ends(NULL, 0.01, 0), SPH_E_ARGUMENT);
  sph_wave_destroy(&wave);
  SPH_TEST_OK(context, sph_wave_create_regular(context, 1, 0.05, 1.5, 0.4, g, &wave));
  for (int k = 0; k < 2; k++) {
    sph_paddle *p = NULL;
    SPH_TEST_STATUS(context, of[k](context, wave, 0, &p), SPH_E_TYPE, "must be a solitary one");
    CU_ASSERT_PTR_NULL(p);
  }
  sph_wave_destroy(&wave);
  /* Profiles that are no sech^2 have no closed form. */
  SPH_TEST_OK(context, sph_wave_create_solitary(context, SPH_SOLITARY_FENTON, 0.06, 0.2, g, &wave));
  sph_paddle *closed = NULL;
  SPH_TEST_STATUS(context, sph_paddle_create_solitary_closed(context, wave, 0, &closed),
                  SPH_E_UNSUPPORTED, "use sph_paddle_create_solitary");
  sph_wave_destroy(&wave);
  stop();
}

static void wave_refusals(void) {
  start();
  sph_paddle *p;
  const struct {
    int order;
    double v[5];
    const char *text;
  } regular[] = {{0, {0.1, 1, 1, g, 0}, "order must be 1 or 2, got 0"},
                 {3, {0.1, 1, 1, g, 0}, "order must be 1 or 2, got 3"},
                 {1, {0, 1, 1, g, 0}, "height must be > 0 m, got 0"},
                 {1, {0.1, NAN, 1, g, 0}, "period must be > 0 s, got nan"},
                 {1, {0.1, 1, -1, g, 0}, "depth must be > 0 m, got -1"},
                 {2, {0.1, 1, 1, INFINITY, 0}, "gravity must be > 0 m/s^2, got inf"},
                 {2, {0.1, 1, 1, g, NAN}, "phase must be finite, got nan"},
                 {2, {1e300, 1, 1, g, 0}, "no finite stroke makes waves of 1 Hz"}};
  for (size_t k = 0; k < sizeof regular / sizeof regular[0]; k++) {
    const double *v = regular[k].v;
    SPH_TEST_STATUS(
        context,
        sph_paddle_create_regular(context, regular[k].order, v[0], v[1], v[2], v[3], v[4], &p),
        SPH_E_ARGUMENT, regular[k].text);
    CU_ASSERT_PTR_NULL(p);
  }
  SPH_TEST_STATUS(context, sph_paddle_create_regular(context, 1, 0.1, 1, 1, g, 0, NULL),
                  SPH_E_ARGUMENT, "out is NULL");
  CU_ASSERT_EQUAL(sph_paddle_create_regular(NULL, 1, 0.1, 1, 1, g, 0, &p), SPH_E_ARGUMENT);
  const struct {
    int kind, components;
    double v[5]; /* height, period, gamma, depth, gravity */
    const char *text;
  } sea[] = {{0, 50, {0.1, 1, 3.3, 1, g}, "spectrum must be one of sph_spectrum, got 0"},
             {3, 50, {0.1, 1, 1, 1, g}, "spectrum must be one of sph_spectrum, got 3"},
             {1, 9, {0.1, 1, 3.3, 1, g}, "components must be 10 to 100000, got 9"},
             {1, 100001, {0.1, 1, 3.3, 1, g}, "components must be 10 to 100000, got 100001"},
             {1, 50, {0.1, 0, 3.3, 1, g}, "peak period must be > 0 s, got 0"},
             {1, 50, {0.1, 1, 0.9, 1, g}, "gamma must be 1 to 20, got 0.9"},
             {1, 50, {0.1, 1, NAN, 1, g}, "gamma must be 1 to 20, got nan"},
             {2, 50, {0.1, 1, 3.3, 1, g}, "gamma must be 1 for Pierson-Moskowitz, got 3.3"},
             {1, 50, {0.1, 1, 3.3, NAN, g}, "depth must be > 0 m, got nan"},
             {1, 50, {0.1, 1, 3.3, 1, -1}, "gravity must be > 0 m/s^2, got -1"},
             {1, 50, {-1, 1, 3.3, 1, g}, " must be > 0 m, got -1"}};
  for (size_t k = 0; k < sizeof sea / sizeof sea[0]; k++) {
    const double *v = sea[k].v;
    const sph_spectrum kind = (sph_spectrum)sea[k].kind;
    SPH_TEST_STATUS(context,
                    sph_paddle_create_spectrum(context, kind, v[0], v[1], v[2], v[3], v[4],
                                               sea[k].components, 1, &p),
                    SPH_E_ARGUMENT, sea[k].text);
    CU_ASSERT_PTR_NULL(p);
    SPH_TEST_STATUS(context,
                    sph_paddle_create_focused(context, kind, v[1], v[2], v[3], v[4],
                                              sea[k].components, 5, 10, v[0], &p),
                    SPH_E_ARGUMENT, sea[k].text);
    CU_ASSERT_PTR_NULL(p);
  }
  SPH_TEST_STATUS(
      context,
      sph_paddle_create_focused(context, SPH_SPECTRUM_JONSWAP, 1, 3.3, 1, g, 50, NAN, 1, 0.1, &p),
      SPH_E_ARGUMENT, "focus distance must be > 0 m, got nan");
  SPH_TEST_STATUS(
      context,
      sph_paddle_create_focused(context, SPH_SPECTRUM_JONSWAP, 1, 3.3, 1, g, 50, 1, 0, 0.1, &p),
      SPH_E_ARGUMENT, "focus time must be > 0 s, got 0");
  SPH_TEST_STATUS(
      context,
      sph_paddle_create_focused(context, SPH_SPECTRUM_JONSWAP, 1, 3.3, 1, g, 50, 1, 1, 0.1, NULL),
      SPH_E_ARGUMENT, "out is NULL");
  SPH_TEST_STATUS(
      context,
      sph_paddle_create_spectrum(context, SPH_SPECTRUM_JONSWAP, 0.1, 1, 3.3, 1, g, 50, 1, NULL),
      SPH_E_ARGUMENT, "out is NULL");
  CU_ASSERT_EQUAL(
      sph_paddle_create_spectrum(NULL, SPH_SPECTRUM_JONSWAP, 0.1, 1, 3.3, 1, g, 50, 1, &p),
      SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(
      sph_paddle_create_focused(NULL, SPH_SPECTRUM_JONSWAP, 1, 3.3, 1, g, 50, 1, 1, 0.1, &p),
      SPH_E_ARGUMENT);
  stop();
}

static void spoiled(double t, double *x, double *v, double *a, void *user) {
  (void)user;
  *x = *a = t;
  *v = t < 1 ? 0 : NAN;
}

static void handle_refusals(void) {
  start();
  sph_paddle *p;
  double x = -7, v = -7, a = -7;
  SPH_TEST_OK(context, sph_paddle_create_function(context, spoiled, NULL, &p));
  SPH_TEST_STATUS(context, sph_paddle_at(p, 2, &x, &v, &a), SPH_E_ARGUMENT,
                  "velocity must be finite, got nan at t = 2 s");
  SPH_TEST_STATUS(context, sph_paddle_at(p, NAN, &x, &v, &a), SPH_E_ARGUMENT,
                  "t must be finite, got nan s");
  CU_ASSERT(x == -7 && v == -7 && a == -7);
  SPH_TEST_OK(context, sph_paddle_at(p, 0.5, NULL, NULL, NULL));
  SPH_TEST_STATUS(context, sph_paddle_set_start(p, 1), SPH_E_TYPE, "no start");
  SPH_TEST_STATUS(context, sph_paddle_set_ends(p, 0.01, 0), SPH_E_TYPE, "only solitary waves");
  SPH_TEST_STATUS(context, sph_paddle_set_ramp(p, 1), SPH_E_TYPE, "have a ramp");
  SPH_TEST_STATUS(context, sph_paddle_angle_at(p, 0, &x, &v, &a), SPH_E_TYPE,
                  "sph_paddle_set_flap");
  SPH_TEST_STATUS(context, sph_paddle_set_flap(p, 0), SPH_E_ARGUMENT, "sph_paddle_set_depth()");
  SPH_TEST_STATUS(context, sph_paddle_set_depth(p, 0), SPH_E_ARGUMENT,
                  "depth must be > 0 m, got 0");
  SPH_TEST_OK(context, sph_paddle_set_depth(p, 0.5));
  SPH_TEST_STATUS(context, sph_paddle_set_flap(p, 0.5), SPH_E_ARGUMENT,
                  "hinge height must be below the depth of 0.5 m, got 0.5 m");
  SPH_TEST_STATUS(context, sph_paddle_set_flap(p, NAN), SPH_E_ARGUMENT, "got nan m");
  SPH_TEST_STATUS(context, sph_paddle_set_flap(p, -INFINITY), SPH_E_ARGUMENT, "got -inf m");
  SPH_TEST_OK(context, sph_paddle_set_flap(p, 0.4));
  SPH_TEST_STATUS(context, sph_paddle_set_depth(p, 0.3), SPH_E_ARGUMENT,
                  "above the flap's hinge at 0.4 m, got 0.3 m");
  SPH_TEST_STATUS(context, sph_paddle_angle_at(p, 2, &x, &v, &a), SPH_E_ARGUMENT, "got nan");
  SPH_TEST_STATUS(context, sph_paddle_get_component(p, 0, &x, NULL, NULL, NULL, NULL),
                  SPH_E_ARGUMENT, "got 0");
  CU_ASSERT(x == -7 && v == -7 && a == -7);
  sph_paddle_destroy(&p);
  SPH_TEST_OK(context, sph_paddle_create_regular(context, 2, 0.05, 1, 1, g, 0, &p));
  SPH_TEST_STATUS(context, sph_paddle_set_flap(p, 0), SPH_E_UNSUPPORTED, "use order 1 for a flap");
  SPH_TEST_STATUS(context, sph_paddle_set_ramp(p, 0), SPH_E_ARGUMENT, "ramp must be > 0 s, got 0");
  SPH_TEST_STATUS(context, sph_paddle_set_start(p, INFINITY), SPH_E_ARGUMENT, "got inf s");
  SPH_TEST_STATUS(context, sph_paddle_set_depth(p, 2), SPH_E_TYPE, "have a depth already, 1 m");
  SPH_TEST_STATUS(context, sph_paddle_get_component(p, 1, &x, NULL, NULL, NULL, NULL),
                  SPH_E_ARGUMENT, "component must be 0 to 0, got 1");
  SPH_TEST_STATUS(context, sph_paddle_get_component(p, -1, &x, NULL, NULL, NULL, NULL),
                  SPH_E_ARGUMENT, "component must be 0 to 0, got -1");
  sph_paddle_destroy(&p);
  CU_ASSERT_EQUAL(sph_paddle_at(NULL, 0, &x, &v, &a), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_paddle_angle_at(NULL, 0, &x, &v, &a), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_paddle_set_start(NULL, 0), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_paddle_set_ramp(NULL, 1), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_paddle_set_depth(NULL, 1), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_paddle_set_flap(NULL, 0), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_paddle_get_component(NULL, 0, &x, NULL, NULL, NULL, NULL), SPH_E_ARGUMENT);
  CU_ASSERT(isnan(sph_paddle_stroke(NULL)) && isnan(sph_paddle_start(NULL)));
  CU_ASSERT(isnan(sph_paddle_end(NULL)) && sph_paddle_get_type(NULL) == 0);
  CU_ASSERT_EQUAL(sph_paddle_component_count(NULL), 0);
  sph_paddle_destroy(&p);
  sph_paddle_destroy(NULL);
  stop();
}

/* --------------------------------------------------------------------------------- memory */

static void failed_allocations_leave_nothing(void) {
  sph_test_memory m = {1, 0};
  const sph_allocator allocator = {sph_test_allocate, sph_test_release, &m};
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &context) == SPH_OK);
  write_file("t,x\n0,0\n1,1\n2,1\n", 16);
  for (int type = 1; type <= sph_paddle_type_count() + 1; type++) {
    int failures = 0;
    for (sph_status status = SPH_E_MEMORY; status != SPH_OK; failures++) {
      sph_paddle *paddle = NULL;
      m.allowed = failures;
      status = type <= sph_paddle_type_count()
                   ? create_any(context, type, &paddle)
                   : sph_paddle_create_csv(context, path, "t", "x", &paddle);
      CU_ASSERT_FATAL(status == SPH_E_MEMORY || status == SPH_OK);
      CU_ASSERT((paddle != NULL) == (status == SPH_OK));
      if (paddle) { /* outlives the handle, and needs no memory */
        m.allowed = 0;
        double x;
        CU_ASSERT(sph_paddle_at(paddle, 1.1, &x, NULL, NULL) == SPH_OK);
      }
      sph_paddle_destroy(&paddle);
      CU_ASSERT_EQUAL(m.live, 1);
    }
    CU_ASSERT(failures >= 3);
  }
  remove(path);
  m.allowed = 100;
  sph_paddle *last;
  CU_ASSERT_FATAL(create_any(context, SPH_PADDLE_SOLITARY, &last) == SPH_OK);
  sph_context_destroy(&context);
  CU_ASSERT(sph_paddle_stroke(last) > 0.39);
  sph_paddle_destroy(&last);
  CU_ASSERT_EQUAL(m.live, 0);
}

SPH_TEST_MAIN("paddle series", {"clamped cubics are reproduced", cubics_are_exact},
              {"splines converge with order 4, velocities with order 3", fourth_order},
              {"splines are twice continuously differentiable", twice_differentiable},
              {"a series survives a file to the last bit", round_trip},
              {"files may have comments, quotes, other columns, any line end", forms_of_files},
              {"the motion of a computed tank can be read", computed_tank},
              {"hostile files are refused with their line", hostile_files},
              {"bad series are refused", series_refusals},
              {"bad solitary laws are refused", solitary_refusals},
              {"bad regular, irregular and focused waves are refused", wave_refusals},
              {"handles refuse what they cannot do", handle_refusals},
              {"failed allocations are reported and leak nothing",
               failed_allocations_leave_nothing})
