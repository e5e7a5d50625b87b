/* Airy's linear wave (1845), a = H/2, omega^2 = k tanh k:
 *
 *     eta = a cos k X                                                                 (1)
 *     u = a omega cosh(k y)/sinh(k) cos k X,   v = a omega sinh(k y)/sinh(k) sin k X   (2)
 *     p = 1 - y + a cosh(k y)/cosh(k) cos k X                                         (3) */
#include "wave/regular.h"
#include "wave/wave_list.h"

static sph_status prepare(sph_wave *wave) {
  SPH_CHECK(wave->context, wave->ratio < 2, SPH_E_ARGUMENT,
            "wave \"airy\": height must be < 2 depths, or troughs reach the bed, got %g",
            wave->ratio);
  return SPH_OK;
}

static void profile(const sph_wave *wave, double X, double *elevation, double *slope) {
  const double k = wave->wave_number, a = 0.5 * wave->ratio;
  *elevation = a * cos(k * X);
  *slope = -a * k * sin(k * X);
}

static void velocity(const sph_wave *wave, double X, double y, double *w) {
  const double k = wave->wave_number, speed = 0.5 * wave->ratio * k * wave->celerity;
  w[0] = speed * sphi_cosh_sinh(k, y) * cos(k * X);
  w[1] = speed * sphi_sinh_ratio(k, y) * sin(k * X);
}

static double pressure(const sph_wave *wave, double X, double y) {
  const double k = wave->wave_number;
  return 1 - y + 0.5 * wave->ratio * sphi_cosh_ratio(k, y) * cos(k * X);
}

const sphi_wave_theory sphi_wave_airy = {
    .name = "airy",
    .summary = "linear wave",
    .source = "Airy (1845)",
    .prepare = prepare,
    .profile = profile,
    .velocity = velocity,
    .pressure = pressure,
};
