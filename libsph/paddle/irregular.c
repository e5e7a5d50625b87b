/* Irregular waves: a spectrum with random phases. */
#include "paddle/paddle_impl.h"

/* 4 standard deviations of the displacement. */
static double significant_stroke(const sphi_sum *sum) {
  double squares = 0;
  for (int k = 0; k < sum->components; k++)
    squares += 0.125 * sum->component[k].stroke * sum->component[k].stroke;
  return 4 * sqrt(squares);
}

static sph_status reshape(sph_paddle *paddle, double hinge) {
  SPH_TRY(sphi_sum_strokes(paddle, &hinge));
  paddle->stroke = significant_stroke(paddle->data);
  return SPH_OK;
}

static const sphi_paddle_law irregular_law = {.type = SPH_PADDLE_IRREGULAR,
                                              .size = sizeof(sphi_sum),
                                              .at = sphi_sum_at,
                                              .reshape = reshape,
                                              .release = sphi_sum_release};

/* splitmix64 of Steele, Lea and Flood (2014), doi:10.1145/2660193.2660195; uniform in [0, 1). */
static double next_number(uint64_t *state) {
  uint64_t z = (*state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static sph_status fill(sph_paddle *paddle, const sphi_sea *sea, double significant_height,
                       uint64_t seed) {
  sphi_sum *sum = paddle->data;
  double peak, variance = 0;
  SPH_TRY(sphi_sea_fill(paddle, sea, &peak));
  for (int k = 0; k < sum->components; k++) variance += 0.5 * sum->component[k].amplitude;
  for (int k = 0; k < sum->components; k++) {
    sphi_component *it = &sum->component[k];
    it->amplitude = 0.25 * significant_height * sqrt(it->amplitude / variance);
    it->phase = 2 * SPHI_PI * next_number(&seed);
  }
  SPH_TRY(sphi_sum_strokes(paddle, NULL));
  paddle->stroke = significant_stroke(sum);
  sphi_paddle_warn_breaking(paddle, significant_height, peak);
  return SPH_OK;
}

sph_status sph_paddle_create_spectrum(sph_context *context, sph_spectrum spectrum,
                                      double significant_height, double peak_period, double gamma,
                                      double depth, double gravity, int components, uint64_t seed,
                                      sph_paddle **out) {
  SPHI_PADDLE_BEGIN(context, irregular_law, out);
  const sphi_sea sea = {spectrum, peak_period, gamma, depth, gravity, components};
  SPH_TRY(sphi_sea_check(context, &irregular_law, &sea));
  const sphi_paddle_value height = {"significant height", "m", significant_height};
  SPH_TRY(sphi_paddle_check_positive(context, &irregular_law, 1, &height));
  sph_paddle *paddle = NULL;
  SPH_TRY(sphi_paddle_new(context, &irregular_law, &paddle));
  sph_status status;
  SPH_TRY_GOTO(sphi_sum_begin(paddle, components, depth, peak_period));
  SPH_TRY_GOTO(fill(paddle, &sea, significant_height, seed));
  *out = paddle;
  return SPH_OK;
fail:
  sph_paddle_destroy(&paddle);
  return status;
}
