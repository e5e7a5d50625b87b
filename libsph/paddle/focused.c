/* A focused group: components whose crests meet at one place and time. */
#include "paddle/paddle_impl.h"

static double sum_of_strokes(const sphi_sum *sum) {
  double strokes = 0;
  for (int k = 0; k < sum->components; k++) strokes += sum->component[k].stroke;
  return strokes;
}

static sph_status reshape(sph_paddle *paddle, double hinge) {
  SPH_TRY(sphi_sum_strokes(paddle, &hinge));
  paddle->stroke = sum_of_strokes(paddle->data);
  return SPH_OK;
}

static const sphi_paddle_law focused_law = {.type = SPH_PADDLE_FOCUSED,
                                            .size = sizeof(sphi_sum),
                                            .at = sphi_sum_at,
                                            .reshape = reshape,
                                            .release = sphi_sum_release};

/* Energy travels with the group velocity c/2 (1 + 2 kd/sinh 2kd), slowest at the highest frequency. */
static void warn_of_late_energy(const sph_paddle *paddle, double distance, double time) {
  const sphi_sum *sum = paddle->data;
  for (int k = 0; k < sum->components; k++) {
    const sphi_component *it = &sum->component[k];
    const double kd2 = 2 * it->wave_number * paddle->depth;
    const double speed = SPHI_PI * it->frequency / it->wave_number * (1 + kd2 / (sinh(kd2)));
    if (distance <= speed * time) continue;
    sphi_log(
        paddle->context, SPH_LOG_WARNING,
        "paddle \"%s\": components from %g Hz on need more than %g s to the focus at %g m, which "
        "is at %g s",
        sphi_paddle_name(paddle->law), it->frequency, distance / speed, distance, time);
    return;
  }
}

static sph_status fill(sph_paddle *paddle, const sphi_sea *sea, double distance, double time,
                       double amplitude) {
  sphi_sum *sum = paddle->data;
  double peak, total = 0;
  SPH_TRY(sphi_sea_fill(paddle, sea, &peak));
  for (int k = 0; k < sum->components; k++) total += sum->component[k].amplitude;
  for (int k = 0; k < sum->components; k++) {
    sphi_component *it = &sum->component[k];
    it->amplitude *= amplitude / total;
    it->phase = 2 * SPHI_PI * it->frequency * time - it->wave_number * distance;
  }
  SPH_TRY(sphi_sum_strokes(paddle, NULL));
  paddle->stroke = sum_of_strokes(sum);
  sphi_paddle_warn_breaking(paddle, 2 * amplitude, peak);
  warn_of_late_energy(paddle, distance, time);
  const double again = 1 / (sum->component[1].frequency - sum->component[0].frequency);
  if (again < time)
    sphi_log(
        paddle->context, SPH_LOG_WARNING,
        "paddle \"%s\": the group repeats every %g s, before its focus at %g s; take more than "
        "%d components",
        sphi_paddle_name(paddle->law), again, time, sum->components);
  return SPH_OK;
}

sph_status sph_paddle_create_focused(sph_context *context, sph_spectrum spectrum,
                                     double peak_period, double gamma, double depth, double gravity,
                                     int components, double focus_distance, double focus_time,
                                     double amplitude, sph_paddle **out) {
  SPHI_PADDLE_BEGIN(context, focused_law, out);
  const sphi_sea sea = {spectrum, peak_period, gamma, depth, gravity, components};
  SPH_TRY(sphi_sea_check(context, &focused_law, &sea));
  const sphi_paddle_value values[] = {{"focus distance", "m", focus_distance},
                                      {"focus time", "s", focus_time},
                                      {"amplitude", "m", amplitude}};
  SPH_TRY(sphi_paddle_check_positive(context, &focused_law, 3, values));
  sph_paddle *paddle = NULL;
  SPH_TRY(sphi_paddle_new(context, &focused_law, &paddle));
  sph_status status;
  SPH_TRY_GOTO(sphi_sum_begin(paddle, components, depth, peak_period));
  SPH_TRY_GOTO(fill(paddle, &sea, focus_distance, focus_time, amplitude));
  *out = paddle;
  return SPH_OK;
fail:
  sph_paddle_destroy(&paddle);
  return status;
}
