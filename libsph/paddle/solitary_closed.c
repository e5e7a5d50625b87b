/* Solitary wave in closed form, after Guizien and Barthelemy. */
#include "paddle/paddle_impl.h"
#include "wave/wave_impl.h"

typedef struct closed_data {
  sphi_rise rise;
  double height, depth, celerity, decay;
} closed_data;

/* x = f(T), T = tanh(kappa c t), f = H T/(kappa D), D = d + H (1 - T^2). */
static void endless_law(const sph_paddle *paddle, double time, double *motion) {
  const closed_data *data = paddle->data;
  const double H = data->height, rate = data->decay * data->celerity;
  const double sech = 1 / cosh(rate * time), T = tanh(rate * time),
               D = data->depth + H * sech * sech;
  const double unit = H / data->decay, top = data->depth + H + H * T * T;
  const double first = unit * top / (D * D);                                    /* f' */
  const double second = unit * (2 * H * T * D + 4 * H * T * top) / (D * D * D); /* f'' */
  const double speed = rate * sech * sech;                                      /* dT/dt */
  motion[0] = unit * T / D;
  motion[1] = first * speed;
  motion[2] = second * speed * speed - 2 * rate * T * first * speed;
}

static const sphi_paddle_law closed_law = {.type = SPH_PADDLE_SOLITARY_CLOSED,
                                           .size = sizeof(closed_data),
                                           .at = sphi_rise_at,
                                           .reshape = sphi_rise_refuse_flap};

sph_status sph_paddle_create_solitary_closed(sph_context *context, const sph_wave *wave,
                                             double start_time, sph_paddle **out) {
  SPHI_PADDLE_BEGIN(context, closed_law, out);
  SPH_TRY(sphi_rise_check(context, &closed_law, wave, start_time));
  const closed_data values = {.rise = {.law = endless_law},
                              .height = sph_wave_height(wave),
                              .depth = sph_wave_depth(wave),
                              .celerity = sph_wave_celerity(wave),
                              .decay = sph_wave_decay(wave)};
  for (int k = 0; k <= 16; k++) {
    double elevation, slope;
    const double theta = 0.25 * k, sech = 1 / cosh(theta);
    sphi_wave_profile(wave, theta / values.decay, &elevation, &slope);
    SPH_CHECK(
        context, fabs(elevation - values.height * sech * sech) <= 1e-9 * values.height,
        SPH_E_UNSUPPORTED,
        "paddle \"%s\": the profile must be H sech^2(kappa X); use sph_paddle_create_solitary",
        sphi_paddle_name(&closed_law));
  }
  sph_paddle *paddle = NULL;
  SPH_TRY(sphi_paddle_new(context, &closed_law, &paddle));
  *(closed_data *)paddle->data = values;
  paddle->depth = values.depth;
  paddle->stroke = 2 * values.height / (values.decay * values.depth);
  const sph_status status = sphi_rise_begin(paddle, start_time);
  if (status == SPH_OK)
    *out = paddle;
  else
    sph_paddle_destroy(&paddle);
  return status;
}
