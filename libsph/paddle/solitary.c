/* Solitary wave of any theory, equations (2) and (3) of <sph/paddle.h>.
 *
 * E(X) is tabulated: at the nodes the integral, and with elevation and slope there it is a quintic
 * between them. Velocity and acceleration follow from the same polynomial, so that the three belong
 * together to round-off. */
#include "paddle/paddle_impl.h"
#include "wave/wave_impl.h"

enum { INTERVALS = 1280 };
static const double table_end = 10; /* times 1/kappa: 1e-8 of the stroke is left there */

typedef struct node {
  double integral, elevation, slope;
} node;

typedef struct solitary_data {
  sphi_rise rise;
  double height, depth, celerity, step;
  node *table; /* [INTERVALS + 1] at X = k step */
} solitary_data;

/* E(X) and its two derivatives at X >= 0. */
static void integral_at(const solitary_data *data, double x, double *e) {
  const double at = fmin(x / data->step, INTERVALS);
  const int k = at < INTERVALS ? (int)at : INTERVALS - 1;
  const node *a = &data->table[k], *b = a + 1;
  const double h = data->step, s = at - k;
  /* In s: value, first and second derivative at both ends of the interval. */
  const double v1 = h * a->elevation, w1 = h * h * a->slope;
  const double rise = b->integral - a->integral - v1 - 0.5 * w1;
  const double turn = h * b->elevation - v1 - w1, bend = h * h * b->slope - w1;
  const double c3 = 10 * rise - 4 * turn + 0.5 * bend, c4 = -15 * rise + 7 * turn - bend;
  const double c5 = 6 * rise - 3 * turn + 0.5 * bend;
  e[0] = a->integral + s * (v1 + s * (0.5 * w1 + s * (c3 + s * (c4 + s * c5))));
  e[1] = (v1 + s * (w1 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / h;
  e[2] = (w1 + s * (6 * c3 + s * (12 * c4 + s * 20 * c5))) / (h * h);
}

/* With Z = -X: Z + E(Z)/d = c t, displacement E(Z)/d. */
static void endless_law(const sph_paddle *paddle, double time, double *motion) {
  const solitary_data *data = paddle->data;
  const double d = data->depth, way = data->celerity * time;
  /* 0 <= eta <= H brackets Z; there Newton's steps converge from the left, the bracket catches
   * profiles that are not convex enough. */
  double low = way / (1 + data->height / d), high = way, z = low, e[3];
  for (int k = 0; k < 60; k++) {
    integral_at(data, z, e);
    const double excess = z + e[0] / d - way;
    if (excess > 0)
      high = z;
    else
      low = z;
    double next = z - excess / (1 + e[1] / d);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const bool there = fabs(next - z) <= 4e-16 * way;
    z = next;
    if (there) break;
  }
  integral_at(data, z, e);
  const double total = d + e[1], c = data->celerity;
  motion[0] = e[0] / d;
  motion[1] = c * e[1] / total;
  motion[2] = c * c * d * d * e[2] / (total * total * total);
}

static sph_status tabulate(sph_paddle *paddle, const sph_wave *wave) {
  /* Gauss and Legendre's rule of four points on [0, 1]. */
  static const double place[] = {0.06943184420297371239, 0.33000947820757186760,
                                 0.66999052179242813240, 0.93056815579702628761};
  static const double weight[] = {0.17392742256872692869, 0.32607257743127307131,
                                  0.32607257743127307131, 0.17392742256872692869};
  solitary_data *data = paddle->data;
  data->table = SPHI_NEW(paddle->context, INTERVALS + 1, node);
  SPH_CHECK(paddle->context, data->table, SPH_E_MEMORY, "paddle \"%s\": out of memory",
            sphi_paddle_name(paddle->law));
  data->step = table_end / sph_wave_decay(wave) / INTERVALS;
  double integral = 0;
  for (int k = 0; k <= INTERVALS; k++) {
    node *it = &data->table[k];
    sphi_wave_profile(wave, k * data->step, &it->elevation, &it->slope);
    it->integral = integral;
    SPH_CHECK(paddle->context,
              it->elevation >= -1e-6 * data->height && it->elevation <= (1 + 1e-6) * data->height &&
                  isfinite(it->slope),
              SPH_E_ARGUMENT, "paddle \"%s\": the wave's elevation at %g m is %g m, not 0 to %g m",
              sphi_paddle_name(paddle->law), k * data->step, it->elevation, data->height);
    for (int j = 0; j < 4; j++) {
      double elevation, slope;
      sphi_wave_profile(wave, (k + place[j]) * data->step, &elevation, &slope);
      integral += data->step * weight[j] * elevation;
    }
  }
  const double volume = sph_wave_volume(wave), sum = 2 * data->table[INTERVALS].integral;
  SPH_CHECK(paddle->context, fabs(sum - volume) <= 1e-6 * volume, SPH_E_ARGUMENT,
            "paddle \"%s\": the wave's volume is %g m^2, but its elevation sums to %g m^2",
            sphi_paddle_name(paddle->law), volume, sum);
  return SPH_OK;
}

static void release(sph_paddle *paddle) {
  sphi_free(paddle->context, ((solitary_data *)paddle->data)->table);
}

static const sphi_paddle_law solitary_law = {.type = SPH_PADDLE_SOLITARY,
                                             .size = sizeof(solitary_data),
                                             .at = sphi_rise_at,
                                             .reshape = sphi_rise_refuse_flap,
                                             .release = release};

sph_status sph_paddle_create_solitary(sph_context *context, const sph_wave *wave, double start_time,
                                      sph_paddle **out) {
  SPHI_PADDLE_BEGIN(context, solitary_law, out);
  SPH_TRY(sphi_rise_check(context, &solitary_law, wave, start_time));
  sph_paddle *paddle = NULL;
  SPH_TRY(sphi_paddle_new(context, &solitary_law, &paddle));
  solitary_data *data = paddle->data;
  data->rise.law = endless_law;
  data->height = sph_wave_height(wave);
  data->depth = paddle->depth = sph_wave_depth(wave);
  data->celerity = sph_wave_celerity(wave);
  sph_status status;
  SPH_TRY_GOTO(tabulate(paddle, wave));
  paddle->stroke = sph_wave_volume(wave) / data->depth;
  SPH_TRY_GOTO(sphi_rise_begin(paddle, start_time));
  *out = paddle;
  return SPH_OK;
fail:
  sph_paddle_destroy(&paddle);
  return status;
}
