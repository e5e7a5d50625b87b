/* Water at rest under the linear equation of state. */
#include <sph/initial.h>

#include "core/internal.h"

/* p = rho0 c0^2 (exp(g depth/c0^2) - 1), or rho0 g depth without compressibility. */
static double pressure_at(double depth, double gravity, double density, double sound_speed) {
  if (depth <= 0) return 0.0;
  if (sound_speed == 0) return density * gravity * depth;
  const double c2 = sound_speed * sound_speed;
  return density * c2 * expm1(gravity / c2 * depth);
}

sph_status sph_initial_hydrostatic(sph_context *context, double surface_level, double gravity,
                                   double density, double sound_speed, int64_t n, const double *y,
                                   double *pressure) {
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, isfinite(surface_level), SPH_E_ARGUMENT,
            "hydrostatic pressure: surface level must be finite, got %g", surface_level);
  SPH_CHECK(context, isfinite(gravity) && gravity >= 0, SPH_E_ARGUMENT,
            "hydrostatic pressure: gravity must be >= 0 m/s^2, got %g", gravity);
  SPH_CHECK(context, isfinite(density) && density > 0, SPH_E_ARGUMENT,
            "hydrostatic pressure: density must be > 0 kg/m^3, got %g", density);
  SPH_CHECK(context, isfinite(sound_speed) && sound_speed >= 0, SPH_E_ARGUMENT,
            "hydrostatic pressure: sound speed must be >= 0 m/s, got %g", sound_speed);
  SPH_CHECK(context, n >= 0, SPH_E_ARGUMENT,
            "hydrostatic pressure: number of points must be >= 0, got %lld", (long long)n);
  SPH_CHECK(context, n == 0 || (y && pressure), SPH_E_ARGUMENT, "hydrostatic pressure: %s is NULL",
            y ? "pressure" : "y");
  for (int64_t k = 0; k < n; k++) {
    SPH_CHECK(context, isfinite(y[k]), SPH_E_ARGUMENT,
              "hydrostatic pressure: y of point %lld must be finite, got %g", (long long)k, y[k]);
    SPH_CHECK(context, isfinite(pressure_at(surface_level - y[k], gravity, density, sound_speed)),
              SPH_E_ARGUMENT,
              "hydrostatic pressure: point %lld is %g m deep, too deep for a sound speed of %g m/s",
              (long long)k, surface_level - y[k], sound_speed);
  }
  for (int64_t k = 0; k < n; k++)
    pressure[k] = pressure_at(surface_level - y[k], gravity, density, sound_speed);
  return SPH_OK;
}
