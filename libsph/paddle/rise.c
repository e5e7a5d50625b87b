/* What the laws of solitary waves share: the middle of an endless law between two smooth ends. */
#include "paddle/paddle_impl.h"
#include "wave/wave_impl.h"

/* Share of the stroke left to each smooth end: with the smooth end's own duration of 1/(kappa c) the
 * motion takes as long as the law that is cut at tanh 3.8. */
static const double default_fraction_at = 2.8;

sph_status sphi_rise_check(sph_context *context, const sphi_paddle_law *law, const sph_wave *wave,
                           double start_time) {
  const char *name = sphi_paddle_name(law);
  SPH_CHECK(context, wave, SPH_E_ARGUMENT, "paddle \"%s\": wave is NULL", name);
  SPH_CHECK(context, isfinite(start_time), SPH_E_ARGUMENT,
            "paddle \"%s\": start time must be finite, got %g s", name, start_time);
  SPH_CHECK(context, sphi_wave_is_solitary(wave), SPH_E_TYPE,
            "paddle \"%s\": the wave must be a solitary one", name);
  const double steepness = sph_wave_height(wave) / sph_wave_depth(wave);
  if (steepness > 0.78)
    sphi_log(context, SPH_LOG_WARNING,
             "paddle \"%s\": height/depth = %g is above 0.78, where solitary waves break (McCowan)",
             name, steepness);
  return SPH_OK;
}

/* The law rises monotonically to half the stroke. */
static double time_of(const sph_paddle *paddle, double displacement) {
  const sphi_rise *rise = paddle->data;
  double motion[3], low = 0, high = 1;
  for (rise->law(paddle, high, motion); motion[0] < displacement; rise->law(paddle, high, motion))
    high *= 2;
  for (int k = 0; k < 200 && high - low > 1e-16 * high; k++) {
    const double middle = 0.5 * (low + high);
    rise->law(paddle, middle, motion);
    if (motion[0] < displacement)
      low = middle;
    else
      high = middle;
  }
  return 0.5 * (low + high);
}

static sph_status set_ends(sph_paddle *paddle, double fraction, double duration) {
  sphi_rise *rise = paddle->data;
  const double edge = time_of(paddle, (0.5 - fraction) * paddle->stroke);
  double motion[3];
  rise->law(paddle, edge, motion);
  const double left = 0.5 * paddle->stroke - motion[0], unit = left / motion[1];
  SPH_CHECK(paddle->context, duration <= 3 * unit, SPH_E_ARGUMENT,
            "paddle \"%s\": the end's duration must be at most %g s for %g of the stroke, got %g s",
            sphi_paddle_name(paddle->law), 3 * unit, fraction, duration);
  const double end = duration > 0 ? duration : 2 * unit;
  /* c0 + c1 + c2 = 1, 3 c0 + 4 c1 + 5 c2 = slope, 6 c0 + 12 c1 + 20 c2 = bend */
  const double slope = end / unit, bend = -motion[2] * end * end / left;
  rise->c[2] = 0.5 * (bend - 6 * slope + 12);
  rise->c[1] = slope - 3 - 2 * rise->c[2];
  rise->c[0] = 1 - rise->c[1] - rise->c[2];
  rise->edge = edge;
  rise->half = edge + end;
  rise->left = left;
  paddle->duration = 2 * rise->half;
  return SPH_OK;
}

sph_status sphi_rise_begin(sph_paddle *paddle, double start_time) {
  paddle->start = start_time;
  paddle->after = paddle->stroke;
  return set_ends(paddle, 0.5 * (1 - tanh(default_fraction_at)), 0);
}

void sphi_rise_at(const sph_paddle *paddle, double since, double *motion) {
  const sphi_rise *rise = paddle->data;
  const double time = since - rise->half, after = fabs(time);
  if (after < rise->edge) {
    rise->law(paddle, after, motion);
  } else {
    const double end = rise->half - rise->edge, s = fmax(0, rise->half - after) / end;
    const double *c = rise->c;
    motion[0] = 0.5 * paddle->stroke - rise->left * s * s * s * (c[0] + s * (c[1] + s * c[2]));
    motion[1] = rise->left / end * s * s * (3 * c[0] + s * (4 * c[1] + s * 5 * c[2]));
    motion[2] = -rise->left / (end * end) * s * (6 * c[0] + s * (12 * c[1] + s * 20 * c[2]));
  }
  motion[0] = 0.5 * paddle->stroke + (time < 0 ? -motion[0] : motion[0]);
  if (time < 0) motion[2] = -motion[2];
}

sph_status sphi_rise_refuse_flap(sph_paddle *paddle, double hinge) {
  return SPHI_ERROR(
      paddle->context, SPH_E_UNSUPPORTED,
      "paddle \"%s\": a solitary wave's law is that of a piston, not of a flap hinged "
      "at %g m",
      sphi_paddle_name(paddle->law), hinge);
}

sph_status sph_paddle_set_ends(sph_paddle *paddle, double fraction, double duration) {
  if (!paddle) return SPH_E_ARGUMENT;
  sph_context *context = paddle->context;
  const char *name = sphi_paddle_name(paddle->law);
  SPH_CHECK(context, paddle->law->at == sphi_rise_at, SPH_E_TYPE,
            "paddle \"%s\": only solitary waves have such ends", name);
  SPH_CHECK(context, fraction >= 1e-6 && fraction <= 0.1, SPH_E_ARGUMENT,
            "paddle \"%s\": the ends' fraction of the stroke must be 1e-6 to 0.1, got %g", name,
            fraction);
  SPH_CHECK(context, isfinite(duration) && duration >= 0, SPH_E_ARGUMENT,
            "paddle \"%s\": the end's duration must be >= 0 s, got %g", name, duration);
  return set_ends(paddle, fraction, duration);
}
