/** @file
 * Initial pressures of known states: the column of a dam break just after the gate is gone, and water
 * at rest.
 */
#ifndef SPH_INITIAL_H
#define SPH_INITIAL_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Pressure in a water column at the instant when the gate at x = length is removed.
 *
 * The column is 0 <= x <= length, 0 <= y <= height, its wall at x = 0 and its bed at y = 0:
 *
 *     p_xx + p_yy = 0,  p_x = 0 at x = 0,  p = 0 at x = length and y = height                    (1)
 *     p_y = -(rho0 + p/c0^2) g at y = 0                                                          (2)
 *     p = (2 rho0 g / L) sum_n (-1)^n cos(l_n x) e^(-l_n y) (1 - e^(-2 l_n (H - y)))
 *         / {l_n [l_n - (g/c0^2) tanh(l_n H)] (1 + e^(-2 l_n H))},  l_n = (n + 1/2) pi / L       (3)
 *
 * The slowly converging part of (3) is summed in closed form and the rest as a series, so that the
 * error is below 1e-9 rho0 g H at every point, the bed included.
 *
 * Shape      xy [n, 2]; pressure [n]
 * Units      length, height, xy m; gravity m s^-2; density kg m^-3; sound_speed m s^-1, 0 for an
 *            incompressible fluid (the term p/c0^2 of (2) left out); pressure Pa
 * Ownership  borrows xy, fills the caller's pressure; the two must not overlap
 * Parallel   thread-safe; points are shared among the context's threads, the result does not depend
 *            on their number
 * Errors     SPH_E_ARGUMENT a pointer is NULL, n < 0, length, height, gravity or density not > 0,
 *            length > 1000 height, sound_speed < 0 or so small that (2) has no bounded solution
 *            (c0^2 l_0 <= g tanh(l_0 H)) or nearly none (the bracket of (3) below 1e-6 l_0 at n = 0),
 *            a point outside the column, density gravity height beyond the range of double
 * Source     Poisson problem and series (3) of the linear equation of state p = c0^2 (rho - rho0);
 *            differs: the factor sin(l_n x) sometimes printed for the coefficients is
 *            sin(l_n L) = (-1)^n
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_initial_dam_break_pressure(sph_context *context, double length,
                                                                double height, double gravity,
                                                                double density, double sound_speed,
                                                                int64_t n, const double *xy,
                                                                double *pressure);

/** Pressure of water at rest below a horizontal surface, zero above it.
 *
 *     dp/dy = -rho g, rho = rho0 + p/c0^2, p = 0 at the surface:
 *     p = rho0 c0^2 (exp(g (surface_level - y)/c0^2) - 1)                                        (1)
 *     p = rho0 g (surface_level - y)                           for an incompressible fluid       (2)
 *
 * Shape      y [n]; pressure [n]
 * Units      surface_level, y m; gravity m s^-2; density kg m^-3; sound_speed m s^-1, 0 for (2);
 *            pressure Pa
 * Ownership  borrows y, fills the caller's pressure; the two may be the same array
 * Parallel   thread-safe
 * Errors     SPH_E_ARGUMENT a pointer is NULL, n < 0, a number is not finite, gravity or sound_speed
 *            < 0, density not > 0, a pressure beyond the range of double
 * Source     exact integral of the linear equation of state p = c0^2 (rho - rho0); differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_initial_hydrostatic(sph_context *context, double surface_level,
                                                         double gravity, double density,
                                                         double sound_speed, int64_t n,
                                                         const double *y, double *pressure);

SPH_END_DECLS

#endif
