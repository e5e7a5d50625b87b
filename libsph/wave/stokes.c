/* Stokes's second order (1847) with zero mean level, a = H/2, s = tanh k, omega^2 = k s, added to the
 * linear wave:
 *
 *     eta_2 = (k a^2/4) (3 - s^2)/s^3 cos 2 k X                                           (1)
 *     u_2 = 3/4 a^2 omega k cosh(2 k y)/sinh^4(k) cos 2 k X                               (2)
 *     v_2 = 3/4 a^2 omega k sinh(2 k y)/sinh^4(k) sin 2 k X
 *     p_2 = 3/2 a^2 k/sinh(2 k) [cosh(2 k y)/sinh^2(k) - 1/3] cos 2 k X
 *           - 1/2 a^2 k/sinh(2 k) [cosh(2 k y) - 1]                                       (3) */
#include "wave/regular.h"
#include "wave/wave_list.h"

/* The amplitude of (1). */
static double second(const sph_wave *wave) {
  const double k = wave->wave_number, a = 0.5 * wave->ratio, s = tanh(k);
  return 0.25 * k * a * a * (3 - s * s) / (s * s * s);
}

static sph_status prepare(sph_wave *wave) {
  SPH_CHECK(
      wave->context, 0.5 * wave->ratio + second(wave) < 1, SPH_E_ARGUMENT,
      "wave \"stokes\": the amplitudes %g and %g depths of the two harmonics must sum to less "
      "than 1, or troughs reach the bed",
      0.5 * wave->ratio, second(wave));
  return SPH_OK;
}

static void profile(const sph_wave *wave, double X, double *elevation, double *slope) {
  const double k = wave->wave_number, a = 0.5 * wave->ratio, b = second(wave);
  *elevation = a * cos(k * X) + b * cos(2 * k * X);
  *slope = -k * (a * sin(k * X) + 2 * b * sin(2 * k * X));
}

static void velocity(const sph_wave *wave, double X, double y, double *w) {
  const double k = wave->wave_number, a = 0.5 * wave->ratio, omega = k * wave->celerity;
  const double first = a * omega, harmonic = 0.75 * a * a * omega * k;
  /* exp(2 k (y - 2)) (1 +- exp(-4 k y)) 8/(1 - exp(-2 k))^4 */
  const double Q = -expm1(-2 * k), top = 8 * exp(2 * k * (y - 2)) / (Q * Q * Q * Q);
  w[0] = first * sphi_cosh_sinh(k, y) * cos(k * X) +
         harmonic * top * (1 + exp(-4 * k * y)) * cos(2 * k * X);
  w[1] = first * sphi_sinh_ratio(k, y) * sin(k * X) -
         harmonic * top * expm1(-4 * k * y) * sin(2 * k * X);
}

static double pressure(const sph_wave *wave, double X, double y) {
  const double k = wave->wave_number, a = 0.5 * wave->ratio, Q = -expm1(-2 * k);
  const double deep = exp(-2 * k), part = 2 * k * a * a / -expm1(-4 * k);
  /* part exp(-2 k) = a^2 k/sinh(2 k) */
  const double bracket = 2 * exp(2 * k * (y - 1)) * (1 + exp(-4 * k * y)) / (Q * Q) - 1.0 / 3;
  const double lift = expm1(-2 * k * y), square = exp(2 * k * (y - 1)) * lift * lift / 2;
  return 1 - y + a * sphi_cosh_ratio(k, y) * cos(k * X) +
         1.5 * part * deep * bracket * cos(2 * k * X) - 0.5 * part * square;
}

const sphi_wave_theory sphi_wave_stokes = {
    .name = "stokes",
    .summary = "second order in the steepness",
    .source = "Stokes (1847)",
    .prepare = prepare,
    .profile = profile,
    .velocity = velocity,
    .pressure = pressure,
};
