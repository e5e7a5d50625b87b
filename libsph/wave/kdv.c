/* Korteweg and de Vries (1895): kappa^2 = 3 e/4, c = 1 + e/2. */
#include "wave/long_wave.h"
#include "wave/wave_list.h"

static sph_status prepare(sph_wave *wave) {
  wave->decay = sqrt(0.75 * wave->ratio);
  wave->celerity = 1 + wave->ratio / 2;
  sphi_wave_long_prepare(wave);
  return SPH_OK;
}

const sphi_wave_theory sphi_wave_kdv = {
    .name = "kdv",
    .summary = "Boussinesq's profile, c = sqrt(g d) (1 + H/(2 d))",
    .source = "Korteweg and de Vries (1895)",
    .good_to = 0.4,
    .known_to = INFINITY,
    .prepare = prepare,
    .profile = sphi_wave_series_profile,
    .velocity = sphi_wave_long_velocity,
    .pressure = sphi_wave_long_pressure,
};
