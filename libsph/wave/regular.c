/* Regular waves: dispersion, creation. */
#include "wave/wave_list.h"

static const double pi = 3.14159265358979323846;

#define COUNT_ROW(id, enumerator, stem) +1
enum { ORDERS = 0 SPHI_REGULAR_LIST(COUNT_ROW) };
#undef COUNT_ROW
#define ROW_TABLE(id, enumerator, stem) [(id)-1] = &sphi_wave_##stem,
static const sphi_wave_theory *const theories[ORDERS] = {SPHI_REGULAR_LIST(ROW_TABLE)};
#undef ROW_TABLE

/* The q with q tanh q = y, y > 0: Newton's method on a convex increasing function, from a start that
 * is right at both ends. */
static double solve_dispersion(double y) {
  double q = y / sqrt(tanh(y));
  for (int k = 0; k < 30; k++) {
    const double t = tanh(q), change = (q * t - y) / (t + q * (1 - t * t));
    q -= change;
    if (fabs(change) <= 1e-15 * q) break;
  }
  return q;
}

static sph_status check(sph_context *context, const char *name, double period, double depth,
                        double gravity) {
  const struct {
    const char *name, *unit;
    double value;
  } positive[] = {{"period", "s", period}, {"depth", "m", depth}, {"gravity", "m/s^2", gravity}};
  for (int k = 0; k < 3; k++)
    SPH_CHECK(context, isfinite(positive[k].value) && positive[k].value > 0, SPH_E_ARGUMENT,
              "wave \"%s\": %s must be > 0 %s, got %g", name, positive[k].name, positive[k].unit,
              positive[k].value);
  const double y = 2 * pi / period * (2 * pi / period) * depth / gravity;
  SPH_CHECK(context,
            y >= 1e-16 && y <= 1e16 && isnormal(gravity * depth) && isnormal(depth * depth),
            SPH_E_ARGUMENT,
            "wave \"%s\": period %g s, depth %g m and gravity %g m/s^2 do not go together, "
            "omega^2 d/g = %g",
            name, period, depth, gravity, y);
  return SPH_OK;
}

/* k d */
static double relative_depth(double period, double depth, double gravity) {
  return solve_dispersion(2 * pi / period * (2 * pi / period) * depth / gravity);
}

sph_status sph_wave_dispersion(sph_context *context, double period, double depth, double gravity,
                               double *wave_number) {
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, wave_number, SPH_E_ARGUMENT, "dispersion: wave_number must not be NULL");
  SPH_TRY(check(context, "dispersion", period, depth, gravity));
  *wave_number = relative_depth(period, depth, gravity) / depth;
  return SPH_OK;
}

static void warn(sph_context *context, const char *name, int order, double ratio, double k) {
  const double steepness = ratio * k / (2 * pi), limit = 0.142 * tanh(k);
  if (steepness > limit)
    sphi_log(context, SPH_LOG_WARNING,
             "wave \"%s\": H/L = %g is above 0.142 tanh kd = %g, where a wave breaks (Miche 1944)",
             name, steepness, limit);
  const double ursell = ratio * (2 * pi / k) * (2 * pi / k), bound = 8 * pi * pi / 3;
  if (order >= 2 && ursell > bound)
    sphi_log(
        context, SPH_LOG_WARNING,
        "wave \"%s\": H L^2/d^3 = %g is above 8 pi^2/3 = %g, where the second order of Stokes's "
        "expansion gives troughs crests of their own",
        name, ursell, bound);
}

sph_status sph_wave_create_regular(sph_context *context, int order, double height, double period,
                                   double depth, double gravity, sph_wave **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "wave: out must not be NULL");
  *out = NULL;
  SPH_CHECK(context, context, SPH_E_ARGUMENT, "wave: context must not be NULL");
  SPH_CHECK(context, order >= 1 && order <= ORDERS, SPH_E_ARGUMENT,
            "wave: order of a regular wave must be 1 to %d, got %d", ORDERS, order);
  const sphi_wave_theory *table = theories[order - 1];
  SPH_CHECK(context, isfinite(height) && height > 0, SPH_E_ARGUMENT,
            "wave \"%s\": height must be > 0 m, got %g", table->name, height);
  SPH_TRY(check(context, table->name, period, depth, gravity));
  const double k = relative_depth(period, depth, gravity);
  const sph_wave values = {.height = height,
                           .depth = depth,
                           .gravity = gravity,
                           .speed = sqrt(gravity * depth),
                           .ratio = height / depth,
                           .celerity = sqrt(tanh(k) / k),
                           .decay = NAN,
                           .volume = NAN,
                           .wave_number = k};
  SPH_TRY(sphi_wave_new(context, table, &values, out));
  warn(context, table->name, order, values.ratio, k);
  return SPH_OK;
}
