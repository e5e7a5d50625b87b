/* What the laws that are sums of linear waves share: transfer, strokes, smooth start, evaluation. */
#include "paddle/paddle_impl.h"

/* sinh(a) e^-b, also where sinh overflows. */
static double sinh_scaled(double a, double b) { return -0.5 * exp(a - b) * expm1(-2 * a); }

/* (3) of sph_paddle_set_flap() and of sph_paddle_create_regular(), numerator and denominator times
 * e^(-2 kd); differences of cosh are products of sinh. */
double sphi_paddle_transfer(double wave_number, double depth, const double *hinge) {
  const double kd = wave_number * depth;
  double shape = sinh_scaled(kd, kd);
  if (hinge) {
    const double from = wave_number * fmax(*hinge, 0), sum = 0.5 * (kd + from);
    const double half = 0.5 * (kd - from);
    shape -= 2 * sinh_scaled(sum, sum) * sinh_scaled(half, half) / (wave_number * (depth - *hinge));
  }
  return 4 * sinh_scaled(kd, kd) * shape / (sinh_scaled(2 * kd, 2 * kd) + 2 * kd * exp(-2 * kd));
}

void sphi_paddle_warn_breaking(const sph_paddle *paddle, double height, double wave_number) {
  const double steepness = height * wave_number / (2 * SPHI_PI);
  const double limit = 0.142 * tanh(wave_number * paddle->depth);
  if (steepness > limit)
    sphi_log(paddle->context, SPH_LOG_WARNING,
             "paddle \"%s\": height/wavelength = %g is above 0.142 tanh kd = %g, where waves break "
             "(Miche)",
             sphi_paddle_name(paddle->law), steepness, limit);
}

sph_status sphi_sum_begin(sph_paddle *paddle, int components, double depth, double ramp) {
  sphi_sum *sum = paddle->data;
  sum->component = SPHI_NEW(paddle->context, components, sphi_component);
  SPH_CHECK(paddle->context, sum->component, SPH_E_MEMORY, "paddle \"%s\": out of memory",
            sphi_paddle_name(paddle->law));
  sum->components = components;
  sum->ramp = ramp;
  paddle->depth = depth;
  return SPH_OK;
}

static double stroke_of(const sph_paddle *paddle, const sphi_component *it, const double *hinge) {
  return 2 * it->amplitude / sphi_paddle_transfer(it->wave_number, paddle->depth, hinge);
}

sph_status sphi_sum_strokes(sph_paddle *paddle, const double *hinge) {
  sphi_sum *sum = paddle->data;
  for (int k = 0; k < sum->components; k++) {
    const double stroke = stroke_of(paddle, &sum->component[k], hinge);
    SPH_CHECK(paddle->context, isfinite(stroke) && stroke > 0, SPH_E_ARGUMENT,
              "paddle \"%s\": no finite stroke makes waves of %g Hz at a depth of %g m",
              sphi_paddle_name(paddle->law), sum->component[k].frequency, paddle->depth);
  }
  for (int k = 0; k < sum->components; k++)
    sum->component[k].stroke = stroke_of(paddle, &sum->component[k], hinge);
  return SPH_OK;
}

void sphi_sum_at(const sph_paddle *paddle, double since, double *motion) {
  const sphi_sum *sum = paddle->data;
  double x = 0, v = 0, a = 0;
  for (int k = 0; k < sum->components; k++) {
    const sphi_component *it = &sum->component[k];
    const double omega = 2 * SPHI_PI * it->frequency, at = omega * since - it->phase;
    const double part = 0.5 * it->stroke * sin(at), rate = 0.5 * it->stroke * omega * cos(at);
    x += part;
    v += rate;
    a -= omega * omega * part;
    if (sum->second != 0) {
      x += sum->second * sin(2 * at);
      v += 2 * omega * sum->second * cos(2 * at);
      a -= 4 * omega * omega * sum->second * sin(2 * at);
    }
  }
  if (since < sum->ramp) { /* (1) of sph_paddle_set_ramp() and its derivatives */
    const double T = sum->ramp, s = since / T, r = s * s * s * (10 + s * (6 * s - 15));
    const double r1 = 30 * s * s * (1 - s) * (1 - s) / T;
    const double r2 = 60 * s * (1 - s) * (1 - 2 * s) / (T * T);
    a = r2 * x + 2 * r1 * v + r * a;
    v = r1 * x + r * v;
    x *= r;
  }
  motion[0] = x;
  motion[1] = v;
  motion[2] = a;
}

void sphi_sum_release(sph_paddle *paddle) {
  sphi_free(paddle->context, ((sphi_sum *)paddle->data)->component);
}

sphi_sum *sphi_sum_of(const sph_paddle *paddle) {
  return paddle->law->at == sphi_sum_at ? paddle->data : NULL;
}
