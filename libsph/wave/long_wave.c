/* The field of a long wave, equations (1) to (3) of long_wave.h. */
#include "wave/long_wave.h"

void sphi_wave_long_prepare(sph_wave *wave) {
  wave->elevation[0] = wave->ratio;
  wave->volume = sphi_wave_series_volume(wave);
}

/* h, h' and U with three derivatives. */
typedef struct column {
  double h, h1, U, U1, U2, U3;
} column;

static column column_at(const sph_wave *wave, double X) {
  const double k = wave->decay, C = cosh(k * X), S = 1 / (C * C), T = tanh(k * X);
  const double c = wave->celerity, eta = wave->ratio * S, h = 1 + eta;
  const double e1 = -2 * k * eta * T; /* derivatives of eta */
  const double e2 = k * k * eta * (4 - 6 * S), e3 = k * k * (4 - 12 * S) * e1;
  /* U = c (1 - 1/h) */
  return (column){.h = h,
                  .h1 = e1,
                  .U = c * eta / h,
                  .U1 = c * e1 / (h * h),
                  .U2 = c * (e2 - 2 * e1 * e1 / h) / (h * h),
                  .U3 = c * (e3 + (6 * e1 * e1 / h - 6 * e2) * e1 / h) / (h * h)};
}

void sphi_wave_long_velocity(const sph_wave *wave, double X, double y, double *velocity) {
  const column at = column_at(wave, X);
  const double h = at.h;
  velocity[0] = at.U + (h * h / 6 - y * y / 2) * at.U2;
  velocity[1] = -y * (at.U1 + (h * h - y * y) / 6 * at.U3 + h * at.h1 * at.U2 / 3);
}

double sphi_wave_long_pressure(const sph_wave *wave, double X, double y) {
  const column at = column_at(wave, X);
  const double bracket = (at.U - wave->celerity) * at.U2 - at.U1 * at.U1;
  return (at.h - y) * (1 - (at.h + y) / 2 * bracket);
}
