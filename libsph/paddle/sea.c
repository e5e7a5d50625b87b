/* Spectra cut into components of equal bandwidth, for irregular and focused waves. */
#include "paddle/paddle_impl.h"

/* Frequencies over that of the peak. Outside is 1.5 % of a Pierson-Moskowitz sea, less of others. */
static const double lowest = 0.5, highest = 3.0;

sph_status sphi_sea_check(sph_context *context, const sphi_paddle_law *law, const sphi_sea *sea) {
  const char *name = sphi_paddle_name(law);
  SPH_CHECK(
      context,
      sea->spectrum == SPH_SPECTRUM_JONSWAP || sea->spectrum == SPH_SPECTRUM_PIERSON_MOSKOWITZ,
      SPH_E_ARGUMENT, "paddle \"%s\": spectrum must be one of sph_spectrum, got %d", name,
      (int)sea->spectrum);
  const sphi_paddle_value values[] = {{"peak period", "s", sea->peak_period},
                                      {"depth", "m", sea->depth},
                                      {"gravity", "m/s^2", sea->gravity}};
  SPH_TRY(sphi_paddle_check_positive(context, law, 3, values));
  SPH_CHECK(context, sea->gamma >= 1 && sea->gamma <= 20, SPH_E_ARGUMENT,
            "paddle \"%s\": gamma must be 1 to 20, got %g", name, sea->gamma);
  SPH_CHECK(context, sea->gamma == 1 || sea->spectrum == SPH_SPECTRUM_JONSWAP, SPH_E_ARGUMENT,
            "paddle \"%s\": gamma must be 1 for Pierson-Moskowitz, got %g", name, sea->gamma);
  SPH_CHECK(context, sea->components >= 10 && sea->components <= 100000, SPH_E_ARGUMENT,
            "paddle \"%s\": components must be 10 to 100000, got %d", name, sea->components);
  return SPH_OK;
}

/* (1) of sph_paddle_create_spectrum(), q = f/fp. */
static double density(double gamma, double q) {
  const double sigma = q <= 1 ? 0.07 : 0.09, z = (q - 1) / sigma;
  return pow(q, -5) * exp(-1.25 * pow(q, -4)) * pow(gamma, exp(-0.5 * z * z));
}

sph_status sphi_sea_fill(sph_paddle *paddle, const sphi_sea *sea, double *peak) {
  sph_context *context = paddle->context;
  sphi_sum *sum = paddle->data;
  double wave_number = 0;
  for (int k = 0; k < sum->components; k++) {
    sphi_component *it = &sum->component[k];
    const double q = lowest + (highest - lowest) * (k + 0.5) / sum->components;
    SPH_TRY(
        sph_wave_dispersion(context, sea->peak_period / q, sea->depth, sea->gravity, &wave_number));
    it->frequency = q / sea->peak_period;
    it->wave_number = wave_number;
    it->amplitude = density(sea->gamma, q) / density(sea->gamma, 1);
  }
  if (2 * SPHI_PI / wave_number < 1e-3 * sea->depth)
    sphi_log(context, SPH_LOG_WARNING,
             "paddle \"%s\": the shortest component of %g m is below depth/1000 = %g m",
             sphi_paddle_name(paddle->law), 2 * SPHI_PI / wave_number, 1e-3 * sea->depth);
  return sph_wave_dispersion(context, sea->peak_period, sea->depth, sea->gravity, peak);
}
