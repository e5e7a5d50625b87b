/* Waves as handles: origin, getters, evaluation at points. */
#include "wave/wave_impl.h"

/* Points a rounding error below the bed are at the bed. */
static const double below_bed = 1e-9; /* in depths */

sph_status sphi_wave_new(sph_context *context, const sphi_wave_theory *theory,
                         const sph_wave *values, sph_wave **out) {
  sph_wave *wave = SPHI_NEW(context, 1, sph_wave);
  SPH_CHECK(context, wave, SPH_E_MEMORY, "wave \"%s\": out of memory", theory->name);
  *wave = *values;
  wave->references = 1;
  wave->theory = theory;
  wave->direction = 1;
  wave->context = context;
  sphi_context_retain(context);
  const sph_status status = theory->prepare(wave);
  if (status == SPH_OK)
    *out = wave;
  else
    sph_wave_destroy(&wave);
  return status;
}

void sphi_wave_retain(sph_wave *wave) { wave->references++; }

void sph_wave_destroy(sph_wave **wave) {
  if (!wave || !*wave) return;
  sph_wave *dead = *wave;
  *wave = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  if (dead->theory->release) dead->theory->release(dead);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sph_wave_set_origin(sph_wave *wave, double x0, double t0, int direction) {
  if (!wave) return SPH_E_ARGUMENT;
  const char *name = wave->theory->name;
  SPH_CHECK(wave->context, isfinite(x0), SPH_E_ARGUMENT, "wave \"%s\": x0 must be finite, got %g",
            name, x0);
  SPH_CHECK(wave->context, isfinite(t0), SPH_E_ARGUMENT, "wave \"%s\": t0 must be finite, got %g",
            name, t0);
  SPH_CHECK(wave->context, direction == 1 || direction == -1, SPH_E_ARGUMENT,
            "wave \"%s\": direction must be +1 or -1, got %d", name, direction);
  wave->x0 = x0;
  wave->t0 = t0;
  wave->direction = direction;
  return SPH_OK;
}

bool sphi_wave_is_solitary(const sph_wave *wave) { return wave->theory->good_to > 0; }

double sphi_wave_celerity(const sph_wave *wave) { return wave->celerity * wave->speed; }

void sphi_wave_profile(const sph_wave *wave, double ahead, double *elevation, double *slope) {
  wave->theory->profile(wave, ahead / wave->depth, elevation, slope);
  *elevation *= wave->depth;
}

double sphi_wave_bernoulli(const sph_wave *wave, double X, double y) {
  double w[2];
  wave->theory->velocity(wave, X, y, w);
  /* c^2 - (u - c)^2 - v^2 without the difference of nearly equal numbers. */
  return 0.5 * (w[0] * (2 * wave->celerity - w[0]) - w[1] * w[1]) + (1 - y);
}

double sph_wave_height(const sph_wave *wave) { return wave ? wave->height : NAN; }

double sph_wave_depth(const sph_wave *wave) { return wave ? wave->depth : NAN; }

double sph_wave_gravity(const sph_wave *wave) { return wave ? wave->gravity : NAN; }

double sph_wave_celerity(const sph_wave *wave) { return wave ? sphi_wave_celerity(wave) : NAN; }

double sph_wave_decay(const sph_wave *wave) { return wave ? wave->decay / wave->depth : NAN; }

double sph_wave_volume(const sph_wave *wave) {
  return wave ? wave->volume * wave->depth * wave->depth : NAN;
}

double sph_wave_stroke(const sph_wave *wave) { return wave ? wave->volume * wave->depth : NAN; }

double sph_wave_number(const sph_wave *wave) {
  return wave ? wave->wave_number / wave->depth : NAN;
}

double sph_wave_length(const sph_wave *wave) {
  return wave ? 2 * 3.14159265358979323846 / wave->wave_number * wave->depth : NAN;
}

double sph_wave_period(const sph_wave *wave) {
  return wave ? sph_wave_length(wave) / sphi_wave_celerity(wave) : NAN;
}

const char *sph_wave_name(const sph_wave *wave) { return wave ? wave->theory->name : ""; }

/* X in depths. */
static double ahead_of_crest(const sph_wave *wave, double t, double x) {
  return (wave->direction * (x - wave->x0) - sphi_wave_celerity(wave) * (t - wave->t0)) /
         wave->depth;
}

/* Points of one coordinate, or of two with y >= 0. */
static sph_status check_points(const sph_wave *wave, double t, int64_t n, int dim,
                               const double *points, const void *result) {
  sph_context *context = wave->context;
  const char *name = wave->theory->name;
  SPH_CHECK(context, isfinite(t), SPH_E_ARGUMENT, "wave \"%s\": time must be finite, got %g", name,
            t);
  SPH_CHECK(context, n >= 0, SPH_E_ARGUMENT, "wave \"%s\": number of points must be >= 0, got %lld",
            name, (long long)n);
  SPH_CHECK(context, n == 0 || (points && result), SPH_E_ARGUMENT,
            "wave \"%s\": %s must not be NULL", name,
            points     ? "the array of results"
            : dim == 1 ? "x"
                       : "xy");
  for (int64_t k = 0; k < n; k++) {
    const double x = points[dim * k];
    SPH_CHECK(context, isfinite(ahead_of_crest(wave, t, x)), SPH_E_ARGUMENT,
              "wave \"%s\": x of point %lld must be finite and not too far away, got %g", name,
              (long long)k, x);
    if (dim == 1) continue;
    const double y = points[2 * k + 1];
    SPH_CHECK(context, isfinite(y) && y >= -below_bed * wave->depth, SPH_E_ARGUMENT,
              "wave \"%s\": y of point %lld must be >= 0, counted from the bed, got %g", name,
              (long long)k, y);
  }
  return SPH_OK;
}

sph_status sph_wave_elevation(const sph_wave *wave, double t, int64_t n, const double *x,
                              double *elevation) {
  if (!wave) return SPH_E_ARGUMENT;
  SPH_TRY(check_points(wave, t, n, 1, x, elevation));
#ifdef _OPENMP
#pragma omp parallel for num_threads(wave->context->threads) schedule(static, 256) if (n > 1024)
#endif
  for (int64_t k = 0; k < n; k++) {
    double eta, slope;
    wave->theory->profile(wave, ahead_of_crest(wave, t, x[k]), &eta, &slope);
    elevation[k] = eta * wave->depth;
  }
  return SPH_OK;
}

/* The top of the water at X, in depths. */
static double surface(const sph_wave *wave, double X) {
  double eta, slope;
  wave->theory->profile(wave, X, &eta, &slope);
  return 1 + eta;
}

sph_status sph_wave_velocity(const sph_wave *wave, double t, int64_t n, const double *xy,
                             double *velocity) {
  if (!wave) return SPH_E_ARGUMENT;
  SPH_TRY(check_points(wave, t, n, 2, xy, velocity));
#ifdef _OPENMP
#pragma omp parallel for num_threads(wave->context->threads) schedule(static, 64) if (n > 256)
#endif
  for (int64_t k = 0; k < n; k++) {
    const double X = ahead_of_crest(wave, t, xy[2 * k]);
    const double y = fmin(fmax(xy[2 * k + 1] / wave->depth, 0), surface(wave, X));
    double w[2];
    wave->theory->velocity(wave, X, y, w);
    velocity[2 * k] = wave->direction * wave->speed * w[0];
    velocity[2 * k + 1] = wave->speed * w[1];
  }
  return SPH_OK;
}

sph_status sph_wave_pressure(const sph_wave *wave, double density, double t, int64_t n,
                             const double *xy, double *pressure) {
  if (!wave) return SPH_E_ARGUMENT;
  const double unit = density * wave->gravity * wave->depth;
  SPH_CHECK(wave->context, isfinite(density) && density > 0 && isfinite(unit), SPH_E_ARGUMENT,
            "wave \"%s\": density must be > 0 kg/m^3 and density gravity depth finite, got %g",
            wave->theory->name, density);
  SPH_TRY(check_points(wave, t, n, 2, xy, pressure));
#ifdef _OPENMP
#pragma omp parallel for num_threads(wave->context->threads) schedule(static, 64) if (n > 256)
#endif
  for (int64_t k = 0; k < n; k++) {
    const double X = ahead_of_crest(wave, t, xy[2 * k]), y = fmax(xy[2 * k + 1] / wave->depth, 0);
    pressure[k] = y < surface(wave, X) ? unit * wave->theory->pressure(wave, X, y) : 0.0;
  }
  return SPH_OK;
}
