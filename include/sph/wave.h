/** @file
 * Waves of permanent form over a level bed: elevation, velocity and pressure of solitary waves by six
 * theories and of regular waves by two. A wave needs no particles.
 */
#ifndef SPH_WAVE_H
#define SPH_WAVE_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Theories of the solitary wave; numbers 1 to sph_solitary_theory_count() without gaps, never
 * renumbered. Equations and measured errors are in docs/theory/waves.md.
 */
typedef enum sph_solitary_theory {
  SPH_SOLITARY_BOUSSINESQ = 1, /**< sech^2, c^2 = g (d + H) */
  SPH_SOLITARY_KDV = 2,        /**< the same profile, c = sqrt(g d) (1 + H/(2 d)) */
  SPH_SOLITARY_RAYLEIGH =
      3, /**< a longer sech^2, c^2 = g (d + H); also Serre's and Green-Naghdi's */
  SPH_SOLITARY_GRIMSHAW = 4, /**< third order in H/d */
  SPH_SOLITARY_FENTON = 5,   /**< ninth order in H/d */
  SPH_SOLITARY_EXACT = 6     /**< numerical solution of Euler's equations; needs GSL */
} sph_solitary_theory;

/** Create a solitary wave that travels towards +x, its crest at x = 0 at time 0.
 *
 *     eta(x, t) = F(X),  X = direction (x - x0) - c (t - t0)                                     (1)
 *
 * Warnings through the log: H/d above 0.78, where McCowan (1894) lets a solitary wave break, or so
 * large that surface or flow of the theory are off by more than a tenth of H: 0.3 for Grimshaw, 0.6 for
 * Fenton, 0.4 for Boussinesq, KdV and Rayleigh.
 *
 * Units      height H of the crest above still water m; depth d m; gravity m s^-2
 * Ownership  the caller destroys *out (NULL after an error); it holds a reference to the context
 * Parallel   not while another call uses the context; the wave itself may then be read from several
 *            threads
 * Errors     SPH_E_ARGUMENT context or out NULL, unknown theory, height, depth or gravity not finite
 *            or not > 0 or so different that c or H/d leaves the range of double, H/d below 1e-8,
 *            above 0.8332 for Grimshaw and Fenton (no higher solitary wave exists) or above 0.79 for
 *            the exact one (its crest is too sharp for the method); SPH_E_UNAVAILABLE the exact one
 *            in a library built without GSL; SPH_E_NOT_CONVERGED the exact one; SPH_E_MEMORY
 * Source     sph_solitary_theory_source(); differs: docs/theory/waves.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wave_create_solitary(sph_context *context,
                                                          sph_solitary_theory theory, double height,
                                                          double depth, double gravity,
                                                          sph_wave **out);

/** Create a regular progressive wave towards +x with a crest at x = 0 at time 0 and zero mean level.
 *
 *     eta = a cos k X + order 2: (k a^2/4) (3 - s^2)/s^3 cos 2 k X,  a = H/2, s = tanh k d         (1)
 *
 * Warnings through the log: H/L above 0.142 tanh k d, where Miche (1944) lets it break; with order 2,
 * H L^2/d^3 above 8 pi^2/3, where the second harmonic is too large for the expansion.
 *
 * Units      order 1 (Airy) or 2 (Stokes); height H from trough to crest m; period s; depth d m;
 *            gravity m s^-2
 * Ownership  as sph_wave_create_solitary
 * Parallel   as sph_wave_create_solitary
 * Errors     SPH_E_ARGUMENT context or out NULL, order not 1 or 2, height, period, depth or gravity
 *            not finite or not > 0 or beyond the range of double together, a trough that could reach
 *            the bed; SPH_E_MEMORY
 * Source     Dean and Dalrymple (1991), chapters 3 and 11; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wave_create_regular(sph_context *context, int order,
                                                         double height, double period, double depth,
                                                         double gravity, sph_wave **out);

/** Release the caller's reference and set *wave to NULL. NULL is allowed.
 *
 * Ownership  the memory goes when the last handle made from it is destroyed
 * Parallel   not while another call uses the wave or its context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_wave_destroy(sph_wave **wave);

/** Say where the crest is at which time, and where it goes.
 *
 * Units      x0 m; t0 s; direction +1 towards +x, -1 towards -x
 * Parallel   not while another call uses the wave
 * Errors     SPH_E_ARGUMENT wave NULL, x0 or t0 not finite, direction not +1 or -1
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wave_set_origin(sph_wave *wave, double x0, double t0,
                                                     int direction);

/** Elevation of the surface above still water.
 *
 * Shape      x, elevation [n]
 * Units      t s; x, elevation m
 * Ownership  borrows x, fills the caller's elevation; the two may be the same array
 * Parallel   not while another call uses the wave's context; points are shared among the context's
 *            threads, the result does not depend on their number
 * Errors     SPH_E_ARGUMENT wave NULL, n < 0, an array NULL with n > 0, t or a coordinate not finite
 *            or too far away; nothing is written then
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wave_elevation(const sph_wave *wave, double t, int64_t n,
                                                    const double *x, double *elevation);

/** Velocity of the water; points above the surface have that of the surface below them.
 *
 * The field belongs to the theory, to its order: docs/theory/waves.md.
 *
 * Shape      xy, velocity [n, 2]
 * Units      t s; x m; y m from the bed; velocity m s^-1
 * Ownership  borrows xy, fills the caller's velocity; the two may be the same array
 * Parallel   as sph_wave_elevation
 * Errors     as sph_wave_elevation; also a point below the bed, y < 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wave_velocity(const sph_wave *wave, double t, int64_t n,
                                                   const double *xy, double *velocity);

/** Pressure in the water, zero above the surface.
 *
 * Grimshaw, Fenton and exact: Bernoulli's equation in the frame of the wave, with the velocity of
 * sph_wave_velocity(). The others: the pressure of the theory, docs/theory/waves.md.
 *
 * Shape      xy [n, 2]; pressure [n]
 * Units      density kg m^-3; t s; x m; y m from the bed; pressure Pa
 * Ownership  borrows xy, fills the caller's pressure; the two must not overlap
 * Parallel   as sph_wave_elevation
 * Errors     as sph_wave_velocity; also density not finite or not > 0, or density gravity depth
 *            beyond the range of double
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wave_pressure(const sph_wave *wave, double density, double t,
                                                   int64_t n, const double *xy, double *pressure);

/** Wave number of a linear wave: omega^2 = g k tanh(k d), omega = 2 pi/period.
 *
 * Units      period s; depth m; gravity m s^-2; wave_number m^-1
 * Ownership  fills the caller's *wave_number, untouched after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context or wave_number NULL, period, depth or gravity not finite or not
 *            > 0 or beyond the range of double together
 * Source     Airy (1845); differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wave_dispersion(sph_context *context, double period,
                                                     double depth, double gravity,
                                                     double *wave_number);

/** Height H of the wave; NaN if wave is NULL.
 *
 * Units      m
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_height(const sph_wave *wave);

/** Depth of still water; NaN if wave is NULL.
 *
 * Units      m
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_depth(const sph_wave *wave);

/** Gravity; NaN if wave is NULL.
 *
 * Units      m s^-2
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_gravity(const sph_wave *wave);

/** Celerity c, always > 0; NaN if wave is NULL.
 *
 * Units      m s^-1
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_celerity(const sph_wave *wave);

/** Decay kappa of a solitary wave: eta falls as exp(-2 kappa |X|) far from the crest, and is
 * H sech^2(kappa X) by Boussinesq, KdV and Rayleigh. NaN for a regular wave or NULL.
 *
 * Units      m^-1
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_decay(const sph_wave *wave);

/** Volume of a solitary wave, the integral of eta over x; NaN for a regular wave or NULL.
 *
 * Units      m^2, per metre of crest
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_volume(const sph_wave *wave);

/** Stroke of a piston that displaces a solitary wave's volume, volume/depth, which is also how far the
 * wave carries the water; NaN for a regular wave or NULL.
 *
 * Units      m
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_stroke(const sph_wave *wave);

/** Length of a regular wave; NaN for a solitary one or NULL.
 *
 * Units      m
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_length(const sph_wave *wave);

/** Period of a regular wave; NaN for a solitary one or NULL.
 *
 * Units      s
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_period(const sph_wave *wave);

/** Wave number k of a regular wave; NaN for a solitary one or NULL.
 *
 * Units      m^-1
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_wave_number(const sph_wave *wave);

/** Name of the wave's theory, for example "rayleigh" or "airy"; "" if wave is NULL.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_wave_name(const sph_wave *wave);

/** Run-up R of a solitary wave above still water at a vertical wall, e = H/d.
 *
 *     order 1: R/d = 2 e,  2: + e^2/2 (Byatt-Smith),  3: + 3 e^3/4 (Su and Mirie)                  (1)
 *
 * Order 3 is within 1 % of the fully nonlinear run-up up to e = 0.4, 1.6 % below at 0.5 and 8 % below
 * at 0.6.
 *
 * Units      m
 * Parallel   thread-safe
 * Errors     none: NaN for a regular wave, NULL or another order
 * Source     Byatt-Smith, J. Fluid Mech. 49 (1971), 625; Su and Mirie, J. Fluid Mech. 98 (1980), 509;
 *            differs: none
 * Since      0.1
 */
SPH_API double sph_wave_runup(const sph_wave *wave, int order);

/** Largest force of a solitary wave on a vertical wall, per metre of wall, e = H/d.
 *
 *     F = rho g d^2/2 (1 + 4 e + 3 e^2 - 6 e^3)                                                    (1)
 *
 * To the square of e this is the hydrostatic force (1 + R/d)^2 at run-up less the dispersive 2 e^2;
 * the last term is fitted to fully nonlinear results. Within 0.7 % of them up to e = 0.4, 2 % below
 * at 0.5; above, the force has two maxima and (1) is too small.
 *
 * Units      density kg m^-3; N m^-1
 * Parallel   thread-safe
 * Errors     none: NaN for a regular wave or NULL
 * Source     derived and fitted, see docs/theory/waves.md; differs: none
 * Since      0.1
 */
SPH_API double sph_wave_wall_force(const sph_wave *wave, double density);

/** The theory with this name; the message of a failure suggests the nearest one.
 *
 * Ownership  *theory is untouched after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, name or theory NULL; SPH_E_NAME no such theory
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solitary_theory_find(sph_context *context, const char *name,
                                                          sph_solitary_theory *theory);

/** Number of theories: they are the numbers 1 to this one, for lists and menus.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_solitary_theory_count(void);

/** Name of a theory, for example "fenton"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_solitary_theory_name(sph_solitary_theory theory);

/** One line about a theory; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_solitary_theory_summary(sph_solitary_theory theory);

/** The publication a theory is taken from; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_solitary_theory_source(sph_solitary_theory theory);

SPH_END_DECLS

#endif
