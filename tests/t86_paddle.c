/* Laws of paddles against their equations, printed and computed numbers. */
#include "paddle_world.h"
#include "wave/wave_impl.h"

static sph_wave *new_wave(int theory, double height, double depth) {
  sph_wave *wave = NULL;
  SPH_TEST_OK(context, sph_wave_create_solitary(context, (sph_solitary_theory)theory, height, depth,
                                                g, &wave));
  warning[0] = 0; /* what the wave says of itself */
  return wave;
}

static sph_paddle *new_solitary(int theory, double height, double depth, double start_time) {
  sph_wave *wave = new_wave(theory, height, depth);
  sph_paddle *paddle = NULL;
  SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, start_time, &paddle));
  sph_wave_destroy(&wave);
  return paddle;
}

static double middle_of(const sph_paddle *paddle) {
  return 0.5 * (sph_paddle_start(paddle) + sph_paddle_end(paddle));
}

static void every_law_has_its_row(void) {
  CU_ASSERT_EQUAL(sph_paddle_type_count(), 7);
  for (int k = 1; k <= sph_paddle_type_count(); k++) {
    CU_ASSERT(strcmp(sph_paddle_type_name((sph_paddle_type)k), "unknown") != 0);
    CU_ASSERT(strlen(sph_paddle_type_summary((sph_paddle_type)k)) > 10);
    CU_ASSERT(strlen(sph_paddle_type_source((sph_paddle_type)k)) > 5);
    start();
    sph_paddle *paddle;
    SPH_TEST_OK(context, create_any(context, k, &paddle));
    CU_ASSERT_EQUAL(sph_paddle_get_type(paddle), k);
    sph_paddle_destroy(&paddle);
    CU_ASSERT_PTR_NULL(paddle);
    stop();
  }
  CU_ASSERT_STRING_EQUAL(sph_paddle_type_name(SPH_PADDLE_SOLITARY), "solitary");
  CU_ASSERT_STRING_EQUAL(sph_paddle_type_name((sph_paddle_type)0), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_paddle_type_summary((sph_paddle_type)8), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_paddle_type_source((sph_paddle_type)-1), "unknown");
}

/* ------------------------------------------------------------------------------ every law */

/* Central differences of sixth order. */
static motion differences(const sph_paddle *paddle, double t, double h) {
  static const double weight[] = {0.75, -0.15, 1.0 / 60};
  motion d = {0, 0, 0};
  for (int k = 1; k <= 3; k++) {
    const motion after = at(paddle, t + k * h), before = at(paddle, t - k * h);
    d.v += weight[k - 1] * (after.x - before.x) / h;
    d.a += weight[k - 1] * (after.v - before.v) / h;
  }
  return d;
}

/* Across the seams of a law differences are only as good as its last continuous derivative. */
static void check_differences(const sph_paddle *paddle, int seams, const double *seam) {
  const double from = fmax(sph_paddle_start(paddle), -3), h = 2e-4;
  const double to = fmin(sph_paddle_end(paddle), from + 9);
  double largest_v = 0, largest_a = 0, worst_v = 0, worst_a = 0;
  uint64_t seed = 5;
  for (int k = 0; k < 2000; k++) {
    const double t = from - 0.1 + (to - from + 0.2) * sph_test_random(&seed);
    bool near = false;
    for (int s = 0; s < seams; s++) near = near || fabs(t - seam[s]) <= 3 * h;
    if (near) continue;
    const motion m = at(paddle, t), d = differences(paddle, t, h);
    largest_v = fmax(largest_v, fabs(m.v));
    largest_a = fmax(largest_a, fabs(m.a));
    worst_v = fmax(worst_v, fabs(m.v - d.v));
    worst_a = fmax(worst_a, fabs(m.a - d.a));
  }
  CU_ASSERT(largest_v > 0 && largest_a > 0);
  SPH_TEST_BELOW(worst_v / largest_v, 2e-10);
  SPH_TEST_BELOW(worst_a / largest_a, 2e-10);
}

static void rates_belong_together(void) {
  for (int type = 1; type <= sph_paddle_type_count(); type++) {
    start();
    sph_paddle *paddle;
    SPH_TEST_OK(context, create_any(context, type, &paddle));
    double seam[16] = {sph_paddle_start(paddle), sph_paddle_end(paddle)};
    int seams = 2;
    if (type <= SPH_PADDLE_SOLITARY_CLOSED) { /* where the ends go over into the law */
      SPH_TEST_OK(context, sph_paddle_set_ends(paddle, 0.01, 0.1));
      seam[1] = sph_paddle_end(paddle);
      seam[seams++] = seam[0] + 0.1;
      seam[seams++] = seam[1] - 0.1;
    } else if (type == SPH_PADDLE_SERIES) {
      const double knots[] = {0.7, 1.2, 2, 2.1};
      for (int k = 0; k < 4; k++) seam[seams++] = knots[k];
    } else if (type != SPH_PADDLE_FUNCTION) {
      SPH_TEST_OK(context, sph_paddle_set_ramp(paddle, 1.25));
      seam[seams++] = 1.25;
    }
    check_differences(paddle, seams, seam);
    sph_paddle_destroy(&paddle);
    stop();
  }
}

/* No jump at a seam: the values a moment before and after differ by what their rates make. */
static void motion_is_continuous(void) {
  const double e = 1e-7;
  for (int type = 1; type <= SPH_PADDLE_FOCUSED; type++) {
    start();
    sph_paddle *paddle;
    SPH_TEST_OK(context, create_any(context, type, &paddle));
    const double from = sph_paddle_start(paddle), to = sph_paddle_end(paddle);
    double seam[4] = {from, from + 1.6, from + 1.5, from};
    if (type <= SPH_PADDLE_SOLITARY_CLOSED) {
      SPH_TEST_OK(context, sph_paddle_set_ends(paddle, 0.004, 0.15));
      seam[1] = from + 0.15;
      seam[2] = sph_paddle_end(paddle);
      seam[3] = seam[2] - 0.15;
      CU_ASSERT(seam[2] < to);
    }
    for (int k = 0; k < 4; k++) {
      const motion a = at(paddle, seam[k] - e), b = at(paddle, seam[k] + e);
      SPH_TEST_CLOSE(b.x - a.x, 2 * e * a.v, 0, 1e-11);
      SPH_TEST_CLOSE(b.v - a.v, 2 * e * a.a, 0, 1e-10);
      SPH_TEST_CLOSE(b.a, a.a, 0, 2e-5);
    }
    sph_paddle_destroy(&paddle);
    stop();
  }
}

static void at_rest_outside(void) {
  for (int type = 1; type <= SPH_PADDLE_SERIES; type++) {
    start();
    sph_paddle *paddle;
    SPH_TEST_OK(context, create_any(context, type, &paddle));
    const double from = sph_paddle_start(paddle), to = sph_paddle_end(paddle);
    const double before[] = {from, from - 1e-9, from - 100, -1e300};
    for (int k = 0; k < 4; k++) {
      const motion m = at(paddle, before[k]);
      CU_ASSERT(m.x == 0 && m.v == 0 && m.a == 0);
    }
    if (isfinite(to)) {
      const motion m = at(paddle, to), later = at(paddle, 1e300);
      CU_ASSERT(m.v == 0 && m.a == 0 && later.v == 0 && later.a == 0 && m.x == later.x);
      SPH_TEST_CLOSE(m.x, type == SPH_PADDLE_SERIES ? 0.16 : sph_paddle_stroke(paddle), 1e-12, 0);
    }
    /* The same motion, later. */
    SPH_TEST_OK(context, sph_paddle_set_start(paddle, from + 3));
    CU_ASSERT_EQUAL(sph_paddle_start(paddle), from + 3);
    const motion late = at(paddle, from + 4.125);
    SPH_TEST_OK(context, sph_paddle_set_start(paddle, from));
    const motion early = at(paddle, from + 1.125);
    SPH_TEST_CLOSE(late.x, early.x, 0, 1e-14);
    SPH_TEST_CLOSE(late.a, early.a, 0, 1e-12);
    sph_paddle_destroy(&paddle);
    stop();
  }
}

/* ------------------------------------------------------------------------- solitary waves */

static void printed_values(void) {
  start();
  const struct {
    int theory;
    double depth, height, kappa, celerity, stroke, duration, fastest;
  } row[] = {{SPH_SOLITARY_BOUSSINESQ, 0.2, 0.1, 3.0619, 1.7155, 0.32660, 1.6373, 0.5718},
             {SPH_SOLITARY_RAYLEIGH, 0.2, 0.1, 2.5, 1.7155, 0.4, 2.0052, 0.5718},
             {SPH_SOLITARY_BOUSSINESQ, 0.25, 0.15, 2.6833, 1.9809, 0.44721, 1.6556, 0.74284},
             {SPH_SOLITARY_RAYLEIGH, 0.25, 0.15, 2.1213, 1.9809, 0.56569, 2.0942, 0.74284}};
  for (int k = 0; k < 4; k++) {
    sph_wave *wave = new_wave(row[k].theory, row[k].height, row[k].depth);
    SPH_TEST_CLOSE(sph_wave_decay(wave), row[k].kappa, 0, 5e-5);
    SPH_TEST_CLOSE(sph_wave_celerity(wave), row[k].celerity, 0, 5e-5);
    for (int closed = 0; closed < 2; closed++) {
      sph_paddle *paddle;
      SPH_TEST_OK(context, closed ? sph_paddle_create_solitary_closed(context, wave, 0, &paddle)
                                  : sph_paddle_create_solitary(context, wave, 0, &paddle));
      SPH_TEST_CLOSE(sph_paddle_stroke(paddle), row[k].stroke, 0, 5e-6);
      SPH_TEST_CLOSE(sph_paddle_end(paddle), row[k].duration, closed ? 0.05 : 0.005, 0);
      const motion m = at(paddle, middle_of(paddle));
      SPH_TEST_CLOSE(m.v, row[k].fastest, closed ? 0.5 : 0, 5e-5);
      SPH_TEST_CLOSE(m.x, row[k].stroke / 2, 0, 5e-6);
      /* Mass: what the paddle sweeps is the wave. */
      SPH_TEST_CLOSE(sph_paddle_stroke(paddle) * row[k].depth, sph_wave_volume(wave), 1e-14, 0);
      sph_paddle_destroy(&paddle);
    }
    sph_wave_destroy(&wave);
  }
  WARNED(NULL);
  stop();
}

/* Reads the next row of numbers, with a name first if `name` is set. */
static int next_row(FILE *file, bool name, int count, double *value) {
  char line[1024];
  while (fgets(line, sizeof line, file)) {
    char *from = line;
    if (name) from = strchr(line, ',') ? strchr(line, ',') + 1 : line;
    char *end;
    (void)strtod(from, &end);
    if (line[0] == '#' || end == from) continue;
    int k = 0;
    for (; k < count; k++, from = end + (*end == ',')) {
      value[k] = strtod(from, &end);
      if (end == from) break;
    }
    return k;
  }
  return 0;
}

static void stored_parameters(void) {
  start();
  FILE *file = fopen(SPH_TEST_DATA "/computed_goring_piston_parameters.csv", "r");
  CU_ASSERT_FATAL(file != NULL);
  double row[6]; /* d, H, kappa, c, T_f, stroke */
  int rows = 0;
  for (; next_row(file, true, 6, row) == 6; rows++) {
    sph_wave *wave = new_wave(SPH_SOLITARY_BOUSSINESQ, row[1], row[0]);
    sph_paddle *paddle;
    SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, 0, &paddle));
    SPH_TEST_CLOSE(sph_wave_decay(wave), row[2], 1e-6, 0);
    SPH_TEST_CLOSE(sph_wave_celerity(wave), row[3], 1e-6, 0);
    SPH_TEST_CLOSE(sph_paddle_stroke(paddle), row[5], 1e-6, 0);
    SPH_TEST_CLOSE(sph_paddle_end(paddle), row[4], 0.005, 0);
    /* Within T_f the endless law does tanh 3.8 of the stroke. */
    SPH_TEST_OK(context, sph_paddle_set_ends(paddle, 1e-6, 0));
    const double t = middle_of(paddle);
    const double done = at(paddle, t + row[4] / 2).x - at(paddle, t - row[4] / 2).x;
    SPH_TEST_CLOSE(done / sph_paddle_stroke(paddle), 0.99900, 0, 5e-6);
    sph_paddle_destroy(&paddle);
    sph_wave_destroy(&wave);
  }
  fclose(file);
  CU_ASSERT_EQUAL(rows, 7);
  stop();
}

/* The stored law runs from tanh K = -tanh A to tanh A with A = 3.8 + H/d, and jumps at both ends. */
static void stored_motion(void) {
  start();
  const struct {
    const char *path;
    double height;
  } tank[] = {{SPH_TEST_DATA "/computed_liang_tank_H0.1_fixed.csv", 0.02},
              {SPH_TEST_DATA "/computed_liang_tank_H0.5_fixed.csv", 0.1}};
  const double d = 0.2;
  for (int k = 0; k < 2; k++) {
    const double H = tank[k].height, kappa = sqrt(3 * H / (4 * d * d * d)), A = 3.8 + H / d;
    const double c = sqrt(g * (d + H)), unit = H / (kappa * d);
    const double middle = (A / kappa + unit * tanh(A)) / c;
    sph_paddle *paddle = new_solitary(SPH_SOLITARY_BOUSSINESQ, H, d, 0);
    SPH_TEST_OK(context, sph_paddle_set_ends(paddle, 1e-6, 0));
    SPH_TEST_OK(context, sph_paddle_set_start(paddle, middle - middle_of(paddle)));
    FILE *file = fopen(tank[k].path, "r");
    CU_ASSERT_FATAL(file != NULL);
    double row[3], worst_x = 0, worst_v = 0; /* t, x, u */
    int rows = 0;
    for (; next_row(file, false, 3, row) == 3; rows++) {
      if (row[0] == 0 || row[0] >= 2 * middle) continue;
      const motion m = at(paddle, row[0]);
      worst_x = fmax(worst_x, fabs(m.x - unit * (1 - tanh(A)) - row[1]));
      worst_v = fmax(worst_v, fabs(m.v - row[2]));
    }
    fclose(file);
    CU_ASSERT(rows > 500);
    SPH_TEST_BELOW(worst_x, 1e-6);
    SPH_TEST_BELOW(worst_v, 1e-6);
    sph_paddle_destroy(&paddle);
  }
  stop();
}

static void implicit_law(void) {
  start();
  for (int k = 1; k <= 7; k++) {
    const double d = 0.25, H = 0.1 * k * d;
    const int theory = k % 2 ? SPH_SOLITARY_RAYLEIGH : SPH_SOLITARY_BOUSSINESQ;
    sph_wave *wave = new_wave(theory, H, d);
    const double kappa = sph_wave_decay(wave), c = sph_wave_celerity(wave);
    sph_paddle *paddle;
    SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, -1, &paddle));
    SPH_TEST_OK(context, sph_paddle_set_ends(paddle, 1e-5, 0));
    const double middle = middle_of(paddle), S = sph_paddle_stroke(paddle);
    double worst[3] = {0};
    for (int j = -200; j <= 200; j++) {
      const double t = j / 200.0 * 5 / (kappa * c);
      const motion m = at(paddle, middle + t);
      const double theta = kappa * (c * t - (m.x - S / 2)), eta = H / pow(cosh(theta), 2);
      const double v = c * eta / (d + eta);
      const double a = -2 * kappa * c * d * eta * tanh(theta) * (c - v) / pow(d + eta, 2);
      worst[0] = fmax(worst[0], fabs(m.x - S / 2 - H / (kappa * d) * tanh(theta)) / S);
      worst[1] = fmax(worst[1], fabs(m.v - v) / c);
      worst[2] = fmax(worst[2], fabs(m.a - a) / (kappa * c * c));
    }
    SPH_TEST_BELOW(worst[0], 1e-13);
    SPH_TEST_BELOW(worst[1], 1e-12);
    SPH_TEST_BELOW(worst[2], 1e-9);
    sph_paddle_destroy(&paddle);
    sph_wave_destroy(&wave);
  }
  stop();
}

/* Of the wave at the paddle, from v = c eta/(d + eta). */
static double elevation_of(double d, double c, motion m) { return d * m.v / (c - m.v); }

/* By Runge and Kutta, for every theory that this build has. */
static void solves_the_differential_equation(void) {
  start();
  int theories = 0;
  for (int theory = SPH_SOLITARY_BOUSSINESQ; theory <= SPH_SOLITARY_EXACT; theory++)
    for (int k = 1; k <= 3; k++) {
      const double d = 0.2, H = 0.2 * k * d;
      sph_wave *wave = NULL;
      const sph_status status =
          sph_wave_create_solitary(context, (sph_solitary_theory)theory, H, d, g, &wave);
      if (status == SPH_E_UNSUPPORTED || status == SPH_E_UNAVAILABLE) continue;
      CU_ASSERT_FATAL(status == SPH_OK);
      theories++;
      const double c = sph_wave_celerity(wave);
      sph_paddle *paddle;
      SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, 0, &paddle));
      SPH_TEST_OK(context, sph_paddle_set_ends(paddle, 1e-4, 0.01));
      SPH_TEST_CLOSE(sph_paddle_stroke(paddle) * d, sph_wave_volume(wave), 1e-12, 0);
      double crest, level;
      sphi_wave_profile(wave, 0, &crest, &level);
      SPH_TEST_CLOSE(elevation_of(d, c, at(paddle, middle_of(paddle))), crest, 1e-12, 0);
      /* From the middle on: dx/dt = c eta/(d + eta). */
      const double S = sph_paddle_stroke(paddle), middle = middle_of(paddle);
      const double length = 0.5 * sph_paddle_end(paddle) - 0.01, h = length / 4000;
      double x = S / 2, worst = 0;
      for (int j = 0; j < 4000; j++) {
        double rate[4], shift = 0;
        for (int s = 0; s < 4; s++) {
          shift = s == 0 ? 0 : s == 3 ? h : h / 2;
          const double X = x + (s ? shift * rate[s - 1] : 0) - S / 2 - c * (j * h + shift);
          double eta, slope;
          sphi_wave_profile(wave, X, &eta, &slope);
          rate[s] = c * eta / (d + eta);
        }
        x += h / 6 * (rate[0] + 2 * rate[1] + 2 * rate[2] + rate[3]);
        worst = fmax(worst, fabs(x - at(paddle, middle + (j + 1) * h).x));
      }
      SPH_TEST_BELOW(worst / S, 1e-10);
      sph_paddle_destroy(&paddle);
      sph_wave_destroy(&wave);
    }
  CU_ASSERT(theories >= 6);
  stop();
}

static void closed_form_is_near(void) {
  start();
  const struct {
    double steepness, distance, digit;
  } row[] = {{0.2, 3.1e-3, 5e-5}, {0.35, 8.5e-3, 5e-5}, {0.5, 1.6e-2, 5e-4}, {0.6, 2.1e-2, 5e-4}};
  for (int k = 0; k < 4; k++) {
    sph_wave *wave = new_wave(SPH_SOLITARY_RAYLEIGH, row[k].steepness * 0.2, 0.2);
    sph_paddle *implicit, *closed;
    SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, 0, &implicit));
    SPH_TEST_OK(context, sph_paddle_create_solitary_closed(context, wave, 0, &closed));
    const double S = sph_paddle_stroke(implicit), kappa = sph_wave_decay(wave);
    const double c = sph_wave_celerity(wave), H = sph_wave_height(wave), d = 0.2;
    double worst = 0;
    for (int j = -2000; j <= 2000; j++) {
      const double t = j / 2000.0 * 2.5 / (kappa * c), T = tanh(kappa * c * t);
      const double x = at(closed, middle_of(closed) + t).x;
      SPH_TEST_CLOSE(x - S / 2, H / kappa * T / (d + H * (1 - T * T)), 0, 1e-14);
      worst = fmax(worst, fabs(x - at(implicit, middle_of(implicit) + t).x));
    }
    SPH_TEST_CLOSE(worst / S, row[k].distance, 0, row[k].digit);
    sph_paddle_destroy(&implicit);
    sph_paddle_destroy(&closed);
    sph_wave_destroy(&wave);
  }
  stop();
}

static void smooth_ends(void) {
  start();
  const double fraction[] = {1e-6, 5e-4, 0.00368, 0.02, 0.1};
  sph_wave *wave = new_wave(SPH_SOLITARY_BOUSSINESQ, 0.12, 0.2);
  for (int closed = 0; closed < 2; closed++) {
    sph_paddle *paddle;
    SPH_TEST_OK(context, closed ? sph_paddle_create_solitary_closed(context, wave, 2, &paddle)
                                : sph_paddle_create_solitary(context, wave, 2, &paddle));
    for (int k = 0; k < 5; k++)
      for (int j = 0; j < 2; j++) {
        SPH_TEST_OK(context, sph_paddle_set_ends(paddle, fraction[k], j ? 0.02 : 0));
        CU_ASSERT_EQUAL(sph_paddle_start(paddle), 2);
        const double length = sph_paddle_end(paddle) - 2;
        double before = 0, fastest = 0;
        for (int s = 0; s <= 5000; s++) {
          const motion m = at(paddle, 2 + length * s / 5000);
          CU_ASSERT(m.v >= 0 && m.x >= before);
          before = m.x;
          fastest = fmax(fastest, m.v);
        }
        SPH_TEST_CLOSE(before, sph_paddle_stroke(paddle), 1e-12, 0);
        CU_ASSERT(at(paddle, 2 + 1e-6).v <= 1e-3 * fastest);
        const motion a = at(paddle, 2 + 0.3 * length), b = at(paddle, 2 + 0.7 * length);
        SPH_TEST_CLOSE(a.x + b.x, sph_paddle_stroke(paddle), 1e-12, 0);
        SPH_TEST_CLOSE(a.a, -b.a, 1e-9, 1e-12);
      }
    sph_paddle_destroy(&paddle);
  }
  /* The default stays near the endless law, as one does that is cut at tanh 3.8. */
  sph_paddle *usual, *endless;
  SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, 0, &usual));
  SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, 0, &endless));
  SPH_TEST_OK(context, sph_paddle_set_ends(endless, 1e-6, 0));
  double worst = 0;
  for (int k = -2000; k <= 2000; k++) {
    const double t = 0.5 * k / 2000 * sph_paddle_end(endless);
    worst = fmax(worst,
                 fabs(at(usual, middle_of(usual) + t).x - at(endless, middle_of(endless) + t).x));
  }
  SPH_TEST_BELOW(worst / sph_paddle_stroke(usual), 0.7e-3);
  sph_paddle_destroy(&usual);
  sph_paddle_destroy(&endless);
  sph_wave_destroy(&wave);
  stop();
}

/* --------------------------------------------------------------------------- regular waves */

static sph_paddle *new_regular(int order, double height, double period, double depth) {
  sph_paddle *paddle = NULL;
  SPH_TEST_OK(context,
              sph_paddle_create_regular(context, order, height, period, depth, g, 0, &paddle));
  return paddle;
}

static double transfer_of(const sph_paddle *paddle) {
  double a, stroke;
  SPH_TEST_OK(context, sph_paddle_get_component(paddle, 0, NULL, NULL, &a, NULL, &stroke));
  CU_ASSERT_EQUAL(stroke, sph_paddle_stroke(paddle));
  return 2 * a / stroke;
}

static void stored_transfer(void) {
  start();
  FILE *file = fopen(SPH_TEST_DATA "/computed_wavemaker_transfer_functions.csv", "r");
  CU_ASSERT_FATAL(file != NULL);
  double row[7]; /* d, T, k, wavelength, kd, piston, flap */
  int rows = 0;
  for (; next_row(file, false, 7, row) == 7; rows++) {
    sph_paddle *paddle = new_regular(1, 0.01, row[1], row[0]);
    double f, k, phase;
    SPH_TEST_OK(context, sph_paddle_get_component(paddle, 0, &f, &k, NULL, &phase, NULL));
    SPH_TEST_CLOSE(f, 1 / row[1], 1e-15, 0);
    SPH_TEST_CLOSE(k, row[2], 1e-6, 0);
    SPH_TEST_CLOSE(transfer_of(paddle), row[5], 1e-6, 0);
    SPH_TEST_OK(context, sph_paddle_set_flap(paddle, 0));
    SPH_TEST_CLOSE(transfer_of(paddle), row[6], 1e-6, 0);
    sph_paddle_destroy(&paddle);
  }
  fclose(file);
  CU_ASSERT_EQUAL(rows, 7);
  const double printed[2][2] = {{0.981789, 0.528088}, {1.681579, 1.041238}};
  for (int n = 1; n <= 2; n++) {
    sph_paddle *paddle = new_regular(1, 0.01, 2 * pi / sqrt(g * n * tanh(n)), 1);
    SPH_TEST_CLOSE(transfer_of(paddle), printed[n - 1][0], 0, 1e-6);
    SPH_TEST_OK(context, sph_paddle_set_flap(paddle, 0));
    SPH_TEST_CLOSE(transfer_of(paddle), printed[n - 1][1], 0, 1e-6);
    sph_paddle_destroy(&paddle);
  }
  stop();
}

/* H/S by Simpson's rule for a hinge at l. */
static double quadrature(double k, double d, double l) {
  const int n = 2000;
  const double from = fmax(l, 0), h = (d - from) / n;
  double sum = 0;
  for (int j = 0; j <= n; j++) {
    const double y = from + j * h;
    sum += (j == 0 || j == n ? 1 : j % 2 ? 4 : 2) * (y - l) / (d - l) * cosh(k * y);
  }
  return 4 * sinh(k * d) * k * sum * h / 3 / (sinh(2 * k * d) + 2 * k * d);
}

static void raised_hinge(void) {
  start();
  const double d = 0.5, hinge[] = {0, 0.1, 0.25, 0.45, 0.499, -0.2, -3};
  for (int n = 0; n < 4; n++) {
    const double kd = (double[]){0.05, 0.7, 3, 12}[n];
    for (int j = 0; j < 7; j++) {
      sph_paddle *paddle = new_regular(1, 1e-4, 2 * pi / sqrt(g * kd / d * tanh(kd)), d);
      SPH_TEST_OK(context, sph_paddle_set_flap(paddle, hinge[j]));
      SPH_TEST_CLOSE(transfer_of(paddle), quadrature(kd / d, d, hinge[j]), 1e-8, 0);
      sph_paddle_destroy(&paddle);
    }
  }
  /* A hinge far below is a piston; long waves have H/S = kd and kd/2, short ones 2. */
  sph_paddle *paddle = new_regular(1, 1e-4, 1.3, d);
  const double piston = transfer_of(paddle);
  SPH_TEST_OK(context, sph_paddle_set_flap(paddle, -1e9));
  SPH_TEST_CLOSE(transfer_of(paddle), piston, 1e-8, 0);
  sph_paddle_destroy(&paddle);
  const double tiny = 1e-6;
  paddle = new_regular(1, 1e-9, 2 * pi / sqrt(g * tiny / d * tanh(tiny)), d);
  SPH_TEST_CLOSE(transfer_of(paddle), tiny, 1e-9, 0);
  SPH_TEST_OK(context, sph_paddle_set_flap(paddle, 0));
  SPH_TEST_CLOSE(transfer_of(paddle), tiny / 2, 1e-9, 0);
  sph_paddle_destroy(&paddle);
  paddle = new_regular(1, 1e-6, 2 * pi / sqrt(g * 900 / d), d);
  SPH_TEST_CLOSE(transfer_of(paddle), 2, 1e-12, 0);
  SPH_TEST_OK(context, sph_paddle_set_flap(paddle, 0));
  SPH_TEST_CLOSE(transfer_of(paddle), 2 * (1 - 1 / 900.0), 1e-12, 0);
  sph_paddle_destroy(&paddle);
  stop();
}

static void first_and_second_order(void) {
  start();
  for (int n = 0; n < 3; n++) {
    const double d = 0.4, kd = (double[]){0.8, 1.5, 3}[n], H = 0.03, phase = 0.7;
    const double omega = sqrt(g * kd / d * tanh(kd)), T = 2 * pi / omega;
    sph_paddle *one, *two;
    SPH_TEST_OK(context, sph_paddle_create_regular(context, 1, H, T, d, g, phase, &one));
    SPH_TEST_OK(context, sph_paddle_create_regular(context, 2, H, T, d, g, phase, &two));
    const double S = sph_paddle_stroke(one);
    /* As Madsen prints it. */
    const double n1 = 0.5 * (1 + 2 * kd / sinh(2 * kd)), a = H / 2;
    const double second = a * a / (2 * d * tanh(kd)) * (3 / (4 * pow(sinh(kd), 2)) - n1 / 2);
    double low = 0, high = 0;
    for (int k = 0; k <= 4000; k++) {
      const double t = 2 * T + T * k / 4000, s = omega * t + phase;
      SPH_TEST_CLOSE(at(one, t).x, S / 2 * sin(s), 0, 1e-14);
      SPH_TEST_CLOSE(at(two, t).x, S / 2 * sin(s) + second * sin(2 * s), 0, 1e-14);
      SPH_TEST_CLOSE(at(two, t).v, omega * (S / 2 * cos(s) + 2 * second * cos(2 * s)), 0, 1e-13);
      low = fmin(low, at(two, t).x);
      high = fmax(high, at(two, t).x);
    }
    SPH_TEST_CLOSE(sph_paddle_stroke(two), high - low, 2e-6, 0);
    CU_ASSERT(sph_paddle_end(one) == INFINITY);
    CU_ASSERT_EQUAL(sph_paddle_component_count(two), 1);
    double p;
    SPH_TEST_OK(context, sph_paddle_get_component(two, 0, NULL, NULL, NULL, &p, NULL));
    CU_ASSERT_EQUAL(p, -phase);
    /* The ramp, halfway. */
    SPH_TEST_OK(context, sph_paddle_set_ramp(one, 2 * T));
    SPH_TEST_CLOSE(at(one, T).x, 0.5 * S / 2 * sin(phase), 1e-12, 0);
    sph_paddle_destroy(&one);
    sph_paddle_destroy(&two);
  }
  stop();
}

/* --------------------------------------------------------------- irregular, focused waves */

typedef struct part {
  double f, k, a, phase, stroke;
} part;

static part part_of(const sph_paddle *paddle, int n) {
  part p = {0};
  SPH_TEST_OK(context, sph_paddle_get_component(paddle, n, &p.f, &p.k, &p.a, &p.phase, &p.stroke));
  return p;
}

static sph_paddle *new_sea(sph_spectrum spectrum, double gamma, int components, uint64_t seed) {
  sph_paddle *paddle = NULL;
  SPH_TEST_OK(context, sph_paddle_create_spectrum(context, spectrum, 0.06, 1.4, gamma, 0.5, g,
                                                  components, seed, &paddle));
  return paddle;
}

static void spectrum_has_its_height_and_shape(void) {
  start();
  const int N = 250;
  for (int k = 0; k < 2; k++) {
    const double gamma = k ? 1 : 3.3, fp = 1 / 1.4;
    sph_paddle *paddle =
        new_sea(k ? SPH_SPECTRUM_PIERSON_MOSKOWITZ : SPH_SPECTRUM_JONSWAP, gamma, N, 3);
    CU_ASSERT_EQUAL(sph_paddle_component_count(paddle), N);
    double m0 = 0, strokes = 0, highest = 0, peak = 0;
    for (int n = 0; n < N; n++) {
      const part p = part_of(paddle, n);
      m0 += p.a * p.a / 2;
      strokes += p.stroke * p.stroke / 8;
      if (p.a > highest) highest = p.a, peak = p.f;
      SPH_TEST_CLOSE(p.f, fp * (0.5 + 2.5 * (n + 0.5) / N), 1e-14, 0);
      SPH_TEST_CLOSE(g * p.k * tanh(p.k * 0.5), pow(2 * pi * p.f, 2), 1e-12, 0);
      const double kd = 0.5 * p.k;
      SPH_TEST_CLOSE(2 * p.a / p.stroke, 4 * pow(sinh(kd), 2) / (sinh(2 * kd) + 2 * kd), 1e-12, 0);
      /* The shape, against the component at the peak's place. */
      const part other = part_of(paddle, 50);
      const double r = p.f / fp, q = other.f / fp, sr = r <= 1 ? 0.07 : 0.09;
      const double sq = q <= 1 ? 0.07 : 0.09;
      const double ratio = pow(q / r, 5) * exp(1.25 * (pow(q, -4) - pow(r, -4))) *
                           pow(gamma, exp(-pow((r - 1) / sr, 2) / 2)) /
                           pow(gamma, exp(-pow((q - 1) / sq, 2) / 2));
      SPH_TEST_CLOSE(p.a * p.a / (other.a * other.a), ratio, 1e-11, 0);
    }
    SPH_TEST_CLOSE(4 * sqrt(m0), 0.06, 1e-12, 0);
    SPH_TEST_CLOSE(sph_paddle_stroke(paddle), 4 * sqrt(strokes), 1e-12, 0);
    SPH_TEST_CLOSE(peak, fp, 0, 0.5001 * 2.5 * fp / N);
    sph_paddle_destroy(&paddle);
  }
  WARNED(NULL);
  stop();
}

static void seeds(void) {
  start();
  sph_paddle *a = new_sea(SPH_SPECTRUM_JONSWAP, 3.3, 60, 1234567);
  sph_paddle *b = new_sea(SPH_SPECTRUM_JONSWAP, 3.3, 60, 1234567);
  sph_paddle *c = new_sea(SPH_SPECTRUM_JONSWAP, 3.3, 60, 1234568);
  for (int k = 0; k < 200; k++) {
    const motion p = at(a, 0.37 * k), q = at(b, 0.37 * k), r = at(c, 0.37 * k);
    CU_ASSERT(memcmp(&p, &q, sizeof p) == 0);
    CU_ASSERT(k == 0 || p.x != r.x);
  }
  /* First number of splitmix64 for this seed, as published. */
  SPH_TEST_CLOSE(part_of(a, 0).phase, 2 * pi * ((double)(6457827717110365317u >> 11) * 0x1p-53),
                 1e-15, 0);
  double mean = 0;
  for (int n = 0; n < 60; n++) {
    const double phase = part_of(a, n).phase;
    CU_ASSERT(phase >= 0 && phase < 2 * pi);
    mean += phase / 60;
  }
  SPH_TEST_CLOSE(mean, pi, 0, 3 * 2 * pi / sqrt(12 * 60));
  double x = 0;
  for (int n = 0; n < 60; n++) {
    const part p = part_of(a, n);
    x += p.stroke / 2 * sin(2 * pi * p.f * 7.3 - p.phase);
  }
  SPH_TEST_CLOSE(at(a, 7.3).x, x, 0, 1e-14);
  sph_paddle_destroy(&a);
  sph_paddle_destroy(&b);
  sph_paddle_destroy(&c);
  stop();
}

static void crests_meet(void) {
  start();
  const double distance = 5, time = 15, amplitude = 0.04;
  sph_paddle *paddle;
  SPH_TEST_OK(context, sph_paddle_create_focused(context, SPH_SPECTRUM_JONSWAP, 1.5, 3.3, 0.5, g,
                                                 80, distance, time, amplitude, &paddle));
  WARNED(NULL);
  double eta = 0, strokes = 0;
  for (int n = 0; n < 80; n++) {
    const part p = part_of(paddle, n);
    const double phase = p.k * distance - 2 * pi * p.f * time + p.phase;
    SPH_TEST_CLOSE(phase, 0, 0, 1e-12);
    eta += p.a * cos(phase);
    strokes += p.stroke;
  }
  SPH_TEST_CLOSE(eta, amplitude, 1e-12, 0);
  SPH_TEST_CLOSE(sph_paddle_stroke(paddle), strokes, 1e-12, 0);
  for (int k = 0; k < 1000; k++) CU_ASSERT(fabs(at(paddle, 0.03 * k).x) < strokes / 2);
  sph_paddle_destroy(&paddle);
  stop();
}

/* ---------------------------------------------------------------------------------- flaps */

static void flap_turns(void) {
  start();
  for (int type = SPH_PADDLE_REGULAR; type <= SPH_PADDLE_FUNCTION; type++) {
    sph_paddle *paddle;
    if (type == SPH_PADDLE_REGULAR)
      paddle = new_regular(1, 0.05, 1.6, 0.4);
    else
      SPH_TEST_OK(context, create_any(context, type, &paddle));
    if (type >= SPH_PADDLE_SERIES) SPH_TEST_OK(context, sph_paddle_set_depth(paddle, 0.4));
    const double before = sph_paddle_stroke(paddle);
    SPH_TEST_OK(context, sph_paddle_set_flap(paddle, 0.1));
    if (type < SPH_PADDLE_SERIES) CU_ASSERT(sph_paddle_stroke(paddle) > 1.1 * before);
    const double t = 1.4, h = 1e-3;
    double angle, rate, turn, q[7], w[7];
    SPH_TEST_OK(context, sph_paddle_angle_at(paddle, t, &angle, &rate, &turn));
    SPH_TEST_CLOSE(0.3 * tan(angle), at(paddle, t).x, 1e-14, 0);
    for (int k = 0; k < 7; k++)
      SPH_TEST_OK(context, sph_paddle_angle_at(paddle, t + (k - 3) * h, &q[k], &w[k], NULL));
    const double dq = 0.75 * (q[4] - q[2]) - 0.15 * (q[5] - q[1]) + (q[6] - q[0]) / 60;
    const double dw = 0.75 * (w[4] - w[2]) - 0.15 * (w[5] - w[1]) + (w[6] - w[0]) / 60;
    SPH_TEST_CLOSE(dq / h, rate, 1e-10, 1e-11);
    SPH_TEST_CLOSE(dw / h, turn, 1e-10, 1e-11);
    sph_paddle_destroy(&paddle);
  }
  stop();
}

/* ---------------------------------------------------------------------------------- walls */

static void drives_a_wall(void) {
  start();
  sph_paddle *paddle = new_solitary(SPH_SOLITARY_RAYLEIGH, 0.1, 0.2, 0);
  const double xy[] = {0, 0.5, 0, 0};
  sph_wall *wall;
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, xy, false, &wall));
  SPH_TEST_OK(context, sph_wall_set_motion(wall, sph_paddle_motion, paddle));
  for (int k = 0; k <= 20; k++) {
    const double t = 0.12 * k, x[2] = {1, 0.25};
    double distance;
    SPH_TEST_OK(context, sph_wall_distance(wall, t, x, &distance));
    SPH_TEST_CLOSE(distance, 1 - at(paddle, t).x, 1e-15, 0);
  }
  sph_wall_destroy(&wall);
  sph_paddle_destroy(&paddle);
  /* A flap turns a wall about its hinge: still water level moves by the displacement. */
  paddle = new_regular(1, 0.05, 1.6, 0.4);
  SPH_TEST_OK(context, sph_paddle_set_flap(paddle, 0));
  double u[3] = {0}, v[3] = {0}, w[3] = {0};
  sph_paddle_motion(1, u, v, w, paddle);
  CU_ASSERT(isnan(u[0]) && isnan(v[0]) && isnan(w[0]) && u[1] == 0 && v[2] == 0);
  u[0] = 0;
  sph_paddle_motion(1, u, v, w, NULL);
  CU_ASSERT(isnan(u[0]));
  const double hinge[2] = {0, 0};
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, xy, false, &wall));
  SPH_TEST_OK(context, sph_wall_set_rotation(wall, hinge, NULL, sph_paddle_rotation, paddle));
  for (int k = 1; k <= 20; k++) {
    const double t = 0.17 * k, level[2] = {at(paddle, t).x, 0.4}, ahead[2] = {level[0] + 0.01, 0.4};
    double distance;
    CU_ASSERT(level[0] != 0);
    SPH_TEST_OK(context, sph_wall_distance(wall, t, level, &distance));
    SPH_TEST_CLOSE(distance, 0, 0, 1e-15);
    SPH_TEST_OK(context, sph_wall_distance(wall, t, ahead, &distance));
    SPH_TEST_CLOSE(distance, 0.01 * 0.4 / hypot(0.4, level[0]), 1e-12, 0);
  }
  sph_wall_destroy(&wall);
  sph_paddle_rotation(1, &u[0], &v[0], &w[0], NULL);
  CU_ASSERT(isnan(u[0]) && isnan(v[0]) && isnan(w[0]));
  sph_paddle_destroy(&paddle);
  stop();
}

static void functions(void) {
  start();
  double calls = 0;
  sph_paddle *paddle;
  SPH_TEST_OK(context, sph_paddle_create_function(context, swing, &calls, &paddle));
  CU_ASSERT(sph_paddle_start(paddle) == -INFINITY && sph_paddle_end(paddle) == INFINITY);
  CU_ASSERT(isnan(sph_paddle_stroke(paddle)));
  const motion m = at(paddle, -2.5);
  CU_ASSERT(calls == 1 && m.x == 0.1 * (1 - cos(-2.5)) && m.v == 0.1 * sin(-2.5));
  sph_paddle_destroy(&paddle);
  stop();
}

static void warnings_cite_their_criterion(void) {
  start();
  sph_wave *wave = NULL;
  SPH_TEST_OK(context,
              sph_wave_create_solitary(context, SPH_SOLITARY_BOUSSINESQ, 0.17, 0.2, g, &wave));
  warning[0] = 0;
  sph_paddle *paddle;
  SPH_TEST_OK(context, sph_paddle_create_solitary(context, wave, 0, &paddle));
  WARNED("height/depth = 0.85 is above 0.78, where solitary waves break (McCowan)");
  sph_paddle_destroy(&paddle);
  sph_wave_destroy(&wave);
  sph_paddle_destroy((paddle = new_regular(1, 0.14, 1, 1), &paddle));
  WARNED(NULL);
  sph_paddle_destroy((paddle = new_regular(1, 0.23, 1, 1), &paddle));
  WARNED("waves break (Miche)");
  sph_paddle_destroy((paddle = new_regular(2, 0.05, 3, 0.3), &paddle));
  WARNED("above 8 pi^2/3 = 26.3, where the second order has a second crest (Madsen)");
  sph_paddle_destroy((paddle = new_regular(1, 0.05, 3, 0.3), &paddle));
  WARNED(NULL);
  SPH_TEST_OK(context, sph_paddle_create_spectrum(context, SPH_SPECTRUM_JONSWAP, 0.3, 1, 3.3, 0.5,
                                                  g, 50, 1, &paddle));
  WARNED("waves break (Miche)");
  sph_paddle_destroy(&paddle);
  SPH_TEST_OK(context, sph_paddle_create_spectrum(context, SPH_SPECTRUM_JONSWAP, 1e-5, 0.05, 3.3, 2,
                                                  g, 50, 1, &paddle));
  WARNED("is below depth/1000 = 0.002 m");
  sph_paddle_destroy(&paddle);
  const struct {
    double distance, time, amplitude;
    int components;
    const char *text;
  } focus[] = {{5, 15, 0.04, 80, NULL},
               {20, 15, 0.04, 80, "to the focus at 20 m, which is at 15 s"},
               {5, 15, 0.4, 80, "waves break (Miche)"},
               {5, 60, 0.04, 80, "the group repeats every 48 s, before its focus at 60 s"}};
  for (int k = 0; k < 4; k++) {
    SPH_TEST_OK(context, sph_paddle_create_focused(context, SPH_SPECTRUM_JONSWAP, 1.5, 3.3, 0.5, g,
                                                   focus[k].components, focus[k].distance,
                                                   focus[k].time, focus[k].amplitude, &paddle));
    WARNED(focus[k].text);
    sph_paddle_destroy(&paddle);
  }
  stop();
}

SPH_TEST_MAIN(
    "paddle", {"every law has its row and its table", every_law_has_its_row},
    {"velocity and acceleration are the rates of every law", rates_belong_together},
    {"motion is continuous up to acceleration where laws go over into each other",
     motion_is_continuous},
    {"every law is at rest before its start and after its end", at_rest_outside},
    {"solitary laws have the printed strokes, durations and speeds", printed_values},
    {"solitary laws agree with the stored table", stored_parameters},
    {"the law of Boussinesq's wave is the one of the computed tanks", stored_motion},
    {"the law of sech^2 profiles is Goring's", implicit_law},
    {"the law of every theory solves its differential equation", solves_the_differential_equation},
    {"the closed form is as far from the implicit law as printed", closed_form_is_near},
    {"smooth ends keep the stroke and never move backwards", smooth_ends},
    {"transfer functions agree with the stored table", stored_transfer},
    {"flaps of any hinge agree with a quadrature, and have their limits", raised_hinge},
    {"regular laws are Biesel's and Madsen's", first_and_second_order},
    {"irregular waves have the height and the shape asked for", spectrum_has_its_height_and_shape},
    {"the same seed gives the same bits, another one another sea", seeds},
    {"crests of a focused group meet", crests_meet},
    {"angles of flaps follow from the displacement", flap_turns},
    {"a paddle drives a wall", drives_a_wall}, {"a caller's function is asked", functions},
    {"warnings cite their criterion", warnings_cite_their_criterion})
