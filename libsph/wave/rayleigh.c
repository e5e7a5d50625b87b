/* Rayleigh (1876), Serre (1953), Green and Naghdi (1976): kappa^2 = 3 e/(4 (1 + e)), c^2 = 1 + e. */
#include "wave/long_wave.h"
#include "wave/wave_list.h"

static sph_status prepare(sph_wave *wave) {
  wave->decay = sqrt(0.75 * wave->ratio / (1 + wave->ratio));
  wave->celerity = sqrt(1 + wave->ratio);
  sphi_wave_long_prepare(wave);
  return SPH_OK;
}

const sphi_wave_theory sphi_wave_rayleigh = {
    .name = "rayleigh",
    .summary = "sech^2 profile that is longer than Boussinesq's, c^2 = g (d + H)",
    .source = "Rayleigh (1876); Serre (1953)",
    .good_to = 0.4,
    .known_to = INFINITY,
    .prepare = prepare,
    .profile = sphi_wave_series_profile,
    .velocity = sphi_wave_long_velocity,
    .pressure = sphi_wave_long_pressure,
};
