/* What Boussinesq, KdV and Rayleigh share: eta = H sech^2(kappa X) and the field of a long wave.
 *
 * With h = 1 + eta and U = c eta/h, the mean over the depth that conserves mass exactly,
 *
 *     u = U + (h^2/6 - y^2/2) U''                                                     (1)
 *     v = -y U' - (h^2 y - y^3)/6 U''' - h h' y U''/3                                 (2)
 *     p = h - y - (h^2 - y^2)/2 [(U - c) U'' - U'^2]                                  (3)
 *
 * (1) is the parabola of an irrotational flow to the first dispersive order, and has the mean U. (2)
 * follows from incompressibility and v = 0 at y = 0; bed and surface are streamlines of (1), (2) in the
 * frame of the wave. (3) is the vertical momentum balance of the leading part v = -y U' (Serre 1953). */
#ifndef SPHI_WAVE_LONG_WAVE_H
#define SPHI_WAVE_LONG_WAVE_H

#include "wave/wave_impl.h"

/* wave->decay = kappa is given. */
void sphi_wave_long_prepare(sph_wave *wave);
void sphi_wave_long_velocity(const sph_wave *wave, double X, double y, double *velocity);
double sphi_wave_long_pressure(const sph_wave *wave, double X, double y);

#endif
