/* Bodies on springs: exact motion, events, the printed rule, errors; bodies that move walls. */
#include "sph_test.h"

static sph_context *context;

static void context_opens(void) { CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK); }
static void context_closes(void) { sph_context_destroy(&context); }

static sph_body *body_of(double mass) {
  sph_body *body = NULL;
  SPH_TEST_OK(context, sph_body_create(context, mass, &body));
  CU_ASSERT_FATAL(body != NULL);
  return body;
}

static double place(const sph_body *body) {
  double x = NAN;
  CU_ASSERT(sph_body_get_state(body, &x, NULL, NULL, NULL) == SPH_OK);
  return x;
}

static double speed(const sph_body *body) {
  double v = NAN;
  CU_ASSERT(sph_body_get_state(body, NULL, &v, NULL, NULL) == SPH_OK);
  return v;
}

static double acceleration(const sph_body *body) {
  double a = NAN;
  CU_ASSERT(sph_body_get_state(body, NULL, NULL, &a, NULL) == SPH_OK);
  return a;
}

/* A step load on a spring: x = F/k (1 - cos w t), in steps of any length. */
static void oscillator_is_exact(void) {
  const double m = 250, k = 500, force = 60, w = sqrt(k / m);
  const double steps[] = {5e-4, 0.01, 0.3, 2, 40};
  for (size_t s = 0; s < sizeof steps / sizeof steps[0]; s++) {
    sph_body *body = body_of(m);
    SPH_TEST_OK(context, sph_body_set_spring(body, k, 0));
    const int count = (int)fmin(2000, 80 / steps[s]);
    double worst = 0;
    for (int n = 1; n <= count; n++) {
      SPH_TEST_OK(context, sph_body_advance(body, force, steps[s]));
      const double t = n * steps[s];
      worst = fmax(worst, fabs(place(body) - force / k * (1 - cos(w * t))) / (force / k));
      worst = fmax(worst, fabs(speed(body) - force / k * w * sin(w * t)) / (force / k * w));
      worst = fmax(worst, fabs(acceleration(body) - force / m * cos(w * t)) / (force / m));
    }
    SPH_TEST_BELOW(worst, 2e-13 * (1 + 0.01 * count));
    sph_body_destroy(&body);
  }
}

/* Under, at and over critical damping, and a damper without spring. */
static void damped_is_exact(void) {
  const double m = 2, v0 = 0.7, x0 = -0.3, force = 1.5;
  for (int mode = 0; mode < 4; mode++) {
    const double k = mode == 3 ? 0 : 8, c = mode == 0 ? 1.2 : mode == 1 ? 8 : 20;
    sph_body *body = body_of(m);
    SPH_TEST_OK(context, sph_body_set_spring(body, k, 0.1));
    SPH_TEST_OK(context, sph_body_set_damping(body, c));
    SPH_TEST_OK(context, sph_body_set_state(body, x0, v0));
    for (int n = 0; n < 7; n++) SPH_TEST_OK(context, sph_body_advance(body, force, 0.11));
    const double t = 7 * 0.11, gamma = 0.5 * c / m, to = k > 0 ? 0.1 + force / k : 0, y = x0 - to;
    const double d = gamma * gamma - k / m;
    double x;
    if (mode == 0)
      x = to + exp(-gamma * t) *
                   (y * cos(sqrt(-d) * t) + (v0 + gamma * y) / sqrt(-d) * sin(sqrt(-d) * t));
    else if (mode == 1)
      x = to + exp(-gamma * t) * (y + (v0 + gamma * y) * t);
    else if (mode == 2)
      x = to + exp(-gamma * t) *
                   (y * cosh(sqrt(d) * t) + (v0 + gamma * y) / sqrt(d) * sinh(sqrt(d) * t));
    else
      x = x0 + force / c * t + (v0 - force / c) * m / c * -expm1(-c / m * t);
    SPH_TEST_CLOSE(place(body), x, 1e-14, 0);
    sph_body_destroy(&body);
  }
}

/* Dropped on a stop it stays there; a force lets it go again. */
static void stops_stop(void) {
  sph_body *body = body_of(1);
  SPH_TEST_OK(context, sph_body_set_stops(body, -0.1, 0.2));
  SPH_TEST_OK(context, sph_body_advance(body, -2, 0.3)); /* x = -t^2 = -0.09 */
  SPH_TEST_CLOSE(place(body), -0.09, 1e-15, 0);
  SPH_TEST_OK(context, sph_body_advance(body, -2, 0.3));
  CU_ASSERT(place(body) == -0.1 && speed(body) == 0 && acceleration(body) == 0);
  SPH_TEST_OK(context, sph_body_advance(body, -2, 1));
  CU_ASSERT(place(body) == -0.1 && speed(body) == 0);
  SPH_TEST_OK(context, sph_body_advance(body, 2, 0.5));
  SPH_TEST_CLOSE(place(body), 0.15, 1e-15, 0);
  SPH_TEST_OK(context, sph_body_advance(body, 2, 0.5));
  CU_ASSERT(place(body) == 0.2 && speed(body) == 0);
  sph_body_destroy(&body);

  /* Within a step: back to the stop by a spring, where it stays. */
  body = body_of(1);
  SPH_TEST_OK(context, sph_body_set_spring(body, 4, 0));
  SPH_TEST_OK(context, sph_body_set_stops(body, 0, HUGE_VAL));
  SPH_TEST_OK(context, sph_body_set_state(body, 0, 1));
  SPH_TEST_OK(context, sph_body_advance(body, 0, 10));
  CU_ASSERT(place(body) == 0 && speed(body) == 0);
  sph_body_destroy(&body);
}

/* An oscillator with Coulomb friction loses 4 R/k of its swing a period, and sticks. */
static void friction_sticks(void) {
  const double k = 4, start = 1, r = 0.3;
  const double half = acos(-1.0) / 2;
  sph_body *body = body_of(1);
  SPH_TEST_OK(context, sph_body_set_spring(body, k, 0));
  SPH_TEST_OK(context, sph_body_set_friction(body, r, r));
  SPH_TEST_OK(context, sph_body_set_state(body, start, 0));
  double swing = start;
  for (int n = 1; n <= 20; n++) {
    SPH_TEST_OK(context, sph_body_advance(body, 0, half));
    if (k * swing > r) swing = swing - 2 * r / k;
    SPH_TEST_CLOSE(fabs(place(body)), fabs(swing), 1e-12, 0);
  }
  CU_ASSERT(speed(body) == 0 && k * fabs(place(body)) <= r);
  SPH_TEST_OK(context, sph_body_advance(body, 0.1, 1));
  CU_ASSERT(speed(body) == 0);
  /* More friction at rest than in motion: it holds up to there, then slips. */
  SPH_TEST_OK(context, sph_body_set_state(body, 0, 0));
  SPH_TEST_OK(context, sph_body_set_friction(body, 0.5, 0.2));
  SPH_TEST_OK(context, sph_body_advance(body, 0.5, 1));
  CU_ASSERT(place(body) == 0);
  SPH_TEST_OK(context, sph_body_advance(body, 0.6, 0.1));
  SPH_TEST_CLOSE(place(body), 0.4 / k * (1 - cos(0.2)), 1e-14, 0);
  sph_body_destroy(&body);
}

static void thresholds_hold(void) {
  for (int kind = 0; kind < 2; kind++) {
    sph_body *body = body_of(2);
    SPH_TEST_OK(context, sph_body_set_stops(body, 0, HUGE_VAL));
    SPH_TEST_OK(context, sph_body_set_threshold(body, 10, (sph_threshold)kind));
    SPH_TEST_OK(context, sph_body_advance(body, 10, 1));
    CU_ASSERT(place(body) == 0 && acceleration(body) == 0);
    SPH_TEST_OK(context, sph_body_advance(body, 14, 1));
    const double a = (kind == 0 ? 4.0 : 14.0) / 2;
    SPH_TEST_CLOSE(place(body), 0.5 * a, 1e-14, 0);
    SPH_TEST_CLOSE(acceleration(body), a, 1e-14, 0);
    SPH_TEST_OK(context, sph_body_advance(body, -6, 0.1));
    SPH_TEST_CLOSE(acceleration(body), kind == 0 ? 0 : -3, 1e-14, 0);
    sph_body_destroy(&body);
  }
}

/* METHODS: a step load, error over amplitude 3.5e-4 at dt = 5e-4, first order; through the stop the
 * velocity goes on. */
static void printed_rule(void) {
  const double m = 250, k = 500, w = sqrt(k / m), load = 50;
  double error[2] = {0};
  for (int fine = 0; fine < 2; fine++) {
    const double dt = fine ? 2.5e-4 : 5e-4;
    sph_body *body = body_of(m);
    SPH_TEST_OK(context, sph_body_set_spring(body, k, 0));
    SPH_TEST_OK(context, sph_body_set_stops(body, 0, HUGE_VAL));
    SPH_TEST_OK(context, sph_body_set_threshold(body, 100, SPH_THRESHOLD_PRELOAD));
    SPH_TEST_OK(context, sph_body_set_rule(body, SPH_BODY_AS_PRINTED));
    for (int n = 1; n * dt < 4; n++) {
      SPH_TEST_OK(context, sph_body_advance(body, 100 + load, dt));
      error[fine] = fmax(error[fine], fabs(place(body) * k / load - (1 - cos(w * n * dt))));
    }
    sph_body_destroy(&body);
  }
  SPH_TEST_CLOSE(error[0], 3.5e-4, 0, 0.02);
  SPH_TEST_CLOSE(error[0] / error[1], 2, 0, 0.01);
  sph_body *body = body_of(m);
  SPH_TEST_OK(context, sph_body_set_spring(body, k, 0));
  SPH_TEST_OK(context, sph_body_set_stops(body, 0, HUGE_VAL));
  SPH_TEST_OK(context, sph_body_set_rule(body, SPH_BODY_AS_PRINTED));
  SPH_TEST_OK(context, sph_body_set_state(body, 1e-3, -0.5));
  SPH_TEST_OK(context, sph_body_advance(body, 0, 0.01));
  CU_ASSERT(place(body) == 0);
  SPH_TEST_CLOSE(speed(body), -0.5 - 0.01 * k * 1e-3 / m, 1e-15, 0);
  sph_body_destroy(&body);
}

static void bad_input(void) {
  sph_body *body = NULL;
  SPH_TEST_STATUS(context, sph_body_create(context, 0, &body), SPH_E_ARGUMENT,
                  "mass must be > 0 kg, got 0");
  SPH_TEST_STATUS(context, sph_body_create(context, -1, &body), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(context, sph_body_create(context, NAN, &body), SPH_E_ARGUMENT, "nan");
  SPH_TEST_STATUS(context, sph_body_create(context, 1, NULL), SPH_E_ARGUMENT, "out is NULL");
  CU_ASSERT(sph_body_create(NULL, 1, &body) == SPH_E_ARGUMENT && body == NULL);
  body = body_of(1);
  SPH_TEST_STATUS(context, sph_body_set_spring(body, -2, 0), SPH_E_ARGUMENT,
                  "stiffness must be >= 0");
  SPH_TEST_STATUS(context, sph_body_set_spring(body, 2, NAN), SPH_E_ARGUMENT,
                  "rest must be finite");
  SPH_TEST_STATUS(context, sph_body_set_damping(body, -2), SPH_E_ARGUMENT, "damping must be >= 0");
  SPH_TEST_STATUS(context, sph_body_set_friction(body, 1, 2), SPH_E_ARGUMENT,
                  "friction at rest must be at least the kinetic 2 N, got 1");
  SPH_TEST_STATUS(context, sph_body_set_friction(body, 1, -2), SPH_E_ARGUMENT, "kinetic friction");
  SPH_TEST_STATUS(context, sph_body_set_friction(body, NAN, 2), SPH_E_ARGUMENT, "friction at rest");
  SPH_TEST_STATUS(context, sph_body_set_threshold(body, INFINITY, SPH_THRESHOLD_PRELOAD),
                  SPH_E_ARGUMENT, "threshold must be >= 0 N, got inf");
  SPH_TEST_STATUS(context, sph_body_set_threshold(body, 1, (sph_threshold)7), SPH_E_ARGUMENT,
                  "got 7");
  SPH_TEST_STATUS(context, sph_body_set_rule(body, (sph_body_rule)7), SPH_E_ARGUMENT, "got 7");
  SPH_TEST_STATUS(context, sph_body_set_stops(body, 1, 1), SPH_E_ARGUMENT, "lower stop");
  SPH_TEST_STATUS(context, sph_body_set_stops(body, NAN, 1), SPH_E_ARGUMENT, "lower stop");
  SPH_TEST_STATUS(context, sph_body_set_stops(body, 0.5, 1), SPH_E_ARGUMENT, "it is at 0 m");
  SPH_TEST_OK(context, sph_body_set_stops(body, -1, 1));
  SPH_TEST_STATUS(context, sph_body_set_state(body, 2, 0), SPH_E_ARGUMENT, "displacement 2 m");
  SPH_TEST_STATUS(context, sph_body_set_state(body, 0, NAN), SPH_E_ARGUMENT, "velocity");
  SPH_TEST_STATUS(context, sph_body_advance(body, NAN, 1), SPH_E_ARGUMENT, "force must be finite");
  SPH_TEST_STATUS(context, sph_body_advance(body, 1, -1), SPH_E_ARGUMENT,
                  "dt must be >= 0 s, got -1");
  SPH_TEST_OK(context, sph_body_set_spring(body, 1e12, 0));
  SPH_TEST_STATUS(context, sph_body_advance(body, 1, 10), SPH_E_ARGUMENT,
                  "10^6 times its own time");
  sph_body_destroy(&body);
  body = body_of(1e-300);
  SPH_TEST_STATUS(context, sph_body_advance(body, 1e300, 10), SPH_E_DIVERGED, "takes it from 0");
  CU_ASSERT(place(body) == 0);
  SPH_TEST_OK(context, sph_body_set_threshold(body, 1, SPH_THRESHOLD_RELEASE));
  SPH_TEST_STATUS(context, sph_body_advance(body, 1, 1), SPH_E_ARGUMENT, "lower stop");
  sph_body_destroy(&body);
  CU_ASSERT(sph_body_set_spring(NULL, 1, 0) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_set_damping(NULL, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_set_friction(NULL, 1, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_set_threshold(NULL, 1, SPH_THRESHOLD_PRELOAD) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_set_stops(NULL, 0, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_set_rule(NULL, SPH_BODY_CONSISTENT) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_set_state(NULL, 0, 0) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_get_state(NULL, NULL, NULL, NULL, NULL) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_body_advance(NULL, 0, 0) == SPH_E_ARGUMENT);
  sph_body_destroy(&body);
  sph_body_destroy(NULL);
}

static sph_status own_driver(double t, double dt, const double *force, double *displacement,
                             double *velocity, double *acceleration, void *user) {
  (void)t, (void)dt, (void)force, (void)displacement, (void)velocity, (void)acceleration;
  (void)user;
  return SPH_OK;
}

static void walls_take_bodies(void) {
  const double xy[] = {0, 1, 0, 0}, along[] = {0.6, 0.8}, crooked[] = {1, 1};
  sph_wall *wall = NULL, *other = NULL;
  sph_body *body = body_of(1);
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, xy, false, &wall));
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, xy, false, &other));
  SPH_TEST_STATUS(context, sph_wall_set_body(wall, NULL, along), SPH_E_ARGUMENT, "body is NULL");
  SPH_TEST_STATUS(context, sph_wall_set_body(wall, body, NULL), SPH_E_ARGUMENT,
                  "direction is NULL");
  SPH_TEST_STATUS(context, sph_wall_set_body(wall, body, crooked), SPH_E_ARGUMENT, "unit vector");
  CU_ASSERT(sph_wall_set_body(NULL, body, along) == SPH_E_ARGUMENT);
  SPH_TEST_OK(context, sph_body_set_state(body, 0.5, 0));
  SPH_TEST_OK(context, sph_wall_set_body(wall, body, along));
  SPH_TEST_STATUS(context, sph_wall_set_body(other, body, along), SPH_E_ARGUMENT, "another wall");
  SPH_TEST_OK(context, sph_wall_set_driver(other, own_driver, NULL));
  sph_body *spare = body_of(1);
  SPH_TEST_STATUS(context, sph_wall_set_body(other, spare, along), SPH_E_ARGUMENT, "has a driver");
  SPH_TEST_OK(context, sph_wall_set_driver(other, NULL, NULL));
  SPH_TEST_OK(context, sph_wall_set_body(other, spare, along)); /* it was not taken before */
  sph_body_destroy(&spare);
  SPH_TEST_STATUS(context, sph_wall_set_driver(wall, NULL, NULL), SPH_E_ARGUMENT,
                  "a body moves it");
  SPH_TEST_STATUS(context, sph_body_set_state(body, 0, 0), SPH_E_ARGUMENT, "moves a wall");
  const double x[] = {1.3, 0.5};
  double distance = NAN;
  SPH_TEST_OK(context, sph_wall_distance(wall, 0, x, &distance));
  SPH_TEST_CLOSE(distance, 1, 1e-14, 0);
  sph_body_destroy(&body); /* the wall keeps it */
  SPH_TEST_OK(context, sph_wall_distance(wall, 0, x, &distance));
  sph_wall_destroy(&wall);
  sph_wall_destroy(&other);
}

SPH_TEST_MAIN("body", {"context opens", context_opens},
              {"a step load on a spring is exact in steps of any length", oscillator_is_exact},
              {"damped motion is exact", damped_is_exact},
              {"a body comes to rest at its stops", stops_stop},
              {"friction takes its share and holds", friction_sticks},
              {"thresholds hold and let go", thresholds_hold},
              {"the printed rule is first order and passes its stop", printed_rule},
              {"bad input", bad_input}, {"walls take bodies", walls_take_bodies},
              {"context closes", context_closes})
