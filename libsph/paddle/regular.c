/* Regular waves of first order and, for a piston, of Madsen's second order. */
#include "paddle/paddle_impl.h"

/* Crest to trough of A sin s + B sin 2s: 4 B c^2 + A c - 2 B = 0 for c = cos s there. */
static double stroke_of(double a, double b) {
  const double c = 4 * b / (a + sqrt(a * a + 32 * b * b));
  return 2 * sqrt(1 - c * c) * (a + 2 * b * c);
}

static sph_status reshape(sph_paddle *paddle, double hinge) {
  const sphi_sum *sum = paddle->data;
  SPH_CHECK(paddle->context, sum->second == 0, SPH_E_UNSUPPORTED,
            "paddle \"%s\": order 2 is the law of a piston; use order 1 for a flap",
            sphi_paddle_name(paddle->law));
  SPH_TRY(sphi_sum_strokes(paddle, &hinge));
  paddle->stroke = sum->component[0].stroke;
  return SPH_OK;
}

static const sphi_paddle_law regular_law = {.type = SPH_PADDLE_REGULAR,
                                            .size = sizeof(sphi_sum),
                                            .at = sphi_sum_at,
                                            .reshape = reshape,
                                            .release = sphi_sum_release};

/* (2) of sph_paddle_create_regular(). */
static double second_harmonic(double height, double depth, double kd, double stroke) {
  const double sinh_kd = sinh(kd);
  return height * height / (32 * depth) *
         (3 / (tanh(kd) * sinh_kd * sinh_kd) - 2 * stroke / height);
}

static sph_status fill(sph_paddle *paddle, int order, double height, double period, double gravity,
                       double phase) {
  sphi_sum *sum = paddle->data;
  sphi_component *it = sum->component;
  const double depth = paddle->depth;
  SPH_TRY(sph_wave_dispersion(paddle->context, period, depth, gravity, &it->wave_number));
  it->frequency = 1 / period;
  it->amplitude = 0.5 * height;
  it->phase = -phase;
  SPH_TRY(sphi_sum_strokes(paddle, NULL));
  const double kd = it->wave_number * depth;
  if (order == 2) sum->second = second_harmonic(height, depth, kd, it->stroke);
  paddle->stroke = stroke_of(0.5 * it->stroke, sum->second);
  SPH_CHECK(paddle->context, isfinite(paddle->stroke), SPH_E_ARGUMENT,
            "paddle \"%s\": no finite stroke makes waves of %g Hz at a depth of %g m",
            sphi_paddle_name(paddle->law), it->frequency, depth);
  sphi_paddle_warn_breaking(paddle, height, it->wave_number);
  const double length = 2 * SPHI_PI / it->wave_number;
  const double ursell = height * length * length / (depth * depth * depth);
  if (order == 2 && ursell > 8 * SPHI_PI * SPHI_PI / 3)
    sphi_log(paddle->context, SPH_LOG_WARNING,
             "paddle \"%s\": H L^2/d^3 = %g is above 8 pi^2/3 = 26.3, where the second order has a "
             "second crest (Madsen)",
             sphi_paddle_name(paddle->law), ursell);
  return SPH_OK;
}

sph_status sph_paddle_create_regular(sph_context *context, int order, double height, double period,
                                     double depth, double gravity, double phase, sph_paddle **out) {
  SPHI_PADDLE_BEGIN(context, regular_law, out);
  SPH_CHECK(context, order == 1 || order == 2, SPH_E_ARGUMENT,
            "paddle \"regular\": order must be 1 or 2, got %d", order);
  const sphi_paddle_value values[] = {{"height", "m", height},
                                      {"period", "s", period},
                                      {"depth", "m", depth},
                                      {"gravity", "m/s^2", gravity}};
  SPH_TRY(sphi_paddle_check_positive(context, &regular_law, 4, values));
  SPH_CHECK(context, isfinite(phase), SPH_E_ARGUMENT,
            "paddle \"regular\": phase must be finite, got %g", phase);
  sph_paddle *paddle = NULL;
  SPH_TRY(sphi_paddle_new(context, &regular_law, &paddle));
  sph_status status;
  SPH_TRY_GOTO(sphi_sum_begin(paddle, 1, depth, period));
  SPH_TRY_GOTO(fill(paddle, order, height, period, gravity, phase));
  *out = paddle;
  return SPH_OK;
fail:
  sph_paddle_destroy(&paddle);
  return status;
}
