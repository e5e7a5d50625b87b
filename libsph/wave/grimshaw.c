/* Grimshaw's third order, J. Fluid Mech. 46 (1971), 611, with S = sech^2(alpha X), T = tanh:
 *
 *     alpha = sqrt(3 e/4) (1 - 5 e/8 + 71 e^2/128),   c^2 = 1 + e - e^2/20 - 3 e^3/70            (1)
 *     eta = e S - 3/4 e^2 S T^2 + e^3 (5/8 S T^2 - 101/80 S^2 T^2)                               (2)
 *
 * and u, v as below; T^2 = 1 - S makes (2) a series in S. */
#include "wave/wave_list.h"

static sph_status prepare(sph_wave *wave) {
  const double e = wave->ratio, e2 = e * e, e3 = e2 * e;
  wave->decay = sqrt(0.75 * e) * (1 - 5.0 / 8 * e + 71.0 / 128 * e2);
  wave->celerity = sqrt(1 + e - e2 / 20 - 3.0 / 70 * e3);
  wave->elevation[0] = e - 0.75 * e2 + 5.0 / 8 * e3;
  wave->elevation[1] = 0.75 * e2 - 151.0 / 80 * e3;
  wave->elevation[2] = 101.0 / 80 * e3;
  wave->volume = sphi_wave_series_volume(wave);
  return SPH_OK;
}

static void velocity(const sph_wave *wave, double X, double y, double *w) {
  const double C = cosh(wave->decay * X), S = 1 / (C * C), T = tanh(wave->decay * X);
  const double e = wave->ratio, Y = y * y;
  const double u2 = -S / 4 + S * S + Y * (1.5 * S - 2.25 * S * S);
  const double u3 = S * (19.0 / 40 + S * (1.0 / 5 - S * 6.0 / 5)) +
                    Y * S * (-3.0 / 2 + S * (-15.0 / 4 + S * 15.0 / 2)) +
                    Y * Y * S * (-3.0 / 8 + S * (45.0 / 16 - S * 45.0 / 16));
  w[0] = e * (S - e * (u2 + e * u3));
  const double v2 = S * (3.0 / 8 + 2 * S) + Y * S * (0.5 - 1.5 * S);
  const double v3 = S * (49.0 / 640 + S * (-17.0 / 20 - S * 18.0 / 5)) +
                    Y * S * (-13.0 / 16 + S * (-25.0 / 16 + S * 15.0 / 2)) +
                    Y * Y * S * (-3.0 / 40 + S * (9.0 / 8 - S * 27.0 / 16));
  w[1] = sqrt(3 * e) * y * T * e * (S - e * (v2 + e * v3));
}

const sphi_wave_theory sphi_wave_grimshaw = {
    .name = "grimshaw",
    .summary = "third order in H/d",
    .source = "Grimshaw (1971)",
    .good_to = 0.3,
    .known_to = 0.8332,
    .prepare = prepare,
    .profile = sphi_wave_series_profile,
    .velocity = velocity,
    .pressure = sphi_wave_bernoulli,
};
