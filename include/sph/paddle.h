/** @file
 * Wave makers: displacement, velocity and acceleration of a piston or a hinged flap at any time, for
 * solitary, regular, irregular and focused waves, time series and a caller's function.
 */
#ifndef SPH_PADDLE_H
#define SPH_PADDLE_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Laws of motion; numbers 1 to sph_paddle_type_count() without gaps, never renumbered. */
typedef enum sph_paddle_type {
  SPH_PADDLE_SOLITARY = 1,        /**< one wave of permanent form, implicit law */
  SPH_PADDLE_SOLITARY_CLOSED = 2, /**< the same in closed form */
  SPH_PADDLE_REGULAR = 3,         /**< waves of one period, first or second order */
  SPH_PADDLE_IRREGULAR = 4,       /**< a sea of random phases from a spectrum */
  SPH_PADDLE_FOCUSED = 5,         /**< components of a spectrum whose crests meet */
  SPH_PADDLE_SERIES = 6,          /**< displacements at given times, from memory or a file */
  SPH_PADDLE_FUNCTION = 7         /**< a caller's function */
} sph_paddle_type;

/** Shapes of wave spectra. */
typedef enum sph_spectrum {
  SPH_SPECTRUM_JONSWAP = 1,          /**< growing wind sea, peak enhanced by gamma */
  SPH_SPECTRUM_PIERSON_MOSKOWITZ = 2 /**< fully developed sea: JONSWAP with gamma = 1 */
} sph_spectrum;

/** A caller's law: writes displacement [m], velocity [m/s] and acceleration [m/s^2] at time t [s].
 * The three must belong together: velocity is the rate of displacement, acceleration that of
 * velocity. It must be thread-safe where the paddle is evaluated from several threads.
 */
typedef void (*sph_paddle_function)(double t, double *displacement, double *velocity,
                                    double *acceleration, void *user);

/** Create a piston's law for a solitary wave of any theory.
 *
 * The paddle moves with the mean velocity over the depth of the wave that passes it:
 *
 *     dx_b/dt = c eta / (d + eta), eta at X = x_b - S/2 - c (t - t_m)                            (1)
 *     x_b - S/2 = -E(X)/d, E(X) = integral of eta from 0 to X, so that                           (2)
 *     X + E(X)/d = -c (t - t_m), solved by Newton's method                                       (3)
 *
 * (2) is the exact integral of (1) for any profile: dX/dt = -c d/(d + eta). It runs from 0 to the
 * stroke S = volume/d, without end; the last pieces are replaced by polynomials that bring the
 * paddle to rest, see sph_paddle_set_ends(). The middle t_m of the motion is halfway between
 * sph_paddle_start() and sph_paddle_end().
 * A warning tells when height/depth is above 0.78, where solitary waves break (McCowan 1894).
 *
 * Units      start_time s, when the paddle starts to move
 * Ownership  wave is only read, here; the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, start_time not finite, a wave whose surface is not
 *            between 0 and its height; SPH_E_TYPE wave is not solitary; SPH_E_MEMORY
 * Source     Goring (1978), Caltech report KH-R-38; for sech^2 profiles (2) is his law
 *            x_b = H/(kappa d) tanh(kappa (c t - x_b)); differs: any profile, smooth ends
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_solitary(sph_context *context,
                                                            const sph_wave *wave, double start_time,
                                                            sph_paddle **out);

/** Create a piston's law for a solitary wave in closed form.
 *
 *     x_b - S/2 = H T / (kappa (d + H (1 - T^2))), T = tanh(kappa c (t - t_m))                   (1)
 *
 * This is one step of Newton's method for the implicit law of sph_paddle_create_solitary(), from the
 * middle of the stroke: the two differ by 0.31, 1.6 and 2.1 % of the stroke at H/d = 0.2, 0.5, 0.6.
 * Everything else is as there.
 *
 * Units      start_time s, when the paddle starts to move
 * Ownership  as sph_paddle_create_solitary
 * Parallel   not while another call uses the context
 * Errors     as sph_paddle_create_solitary; SPH_E_UNSUPPORTED the profile is not H sech^2(kappa X)
 * Source     Guizien and Barthelemy (2002), doi:10.1080/00221680209499946; differs: smooth ends
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_solitary_closed(sph_context *context,
                                                                   const sph_wave *wave,
                                                                   double start_time,
                                                                   sph_paddle **out);

/** Create a law for regular waves, with a smooth start of one period from t = 0.
 *
 *     x_b = S/2 sin(w t + phase)                                             order 1             (1)
 *         + H^2/(32 d) (3 cosh kd/sinh^3 kd - 2 S/H) sin(2 w t + 2 phase)    order 2             (2)
 *     H/S = 4 sinh(kd) (k I) / (sinh 2kd + 2kd), I = integral of s(y) cosh(k y) over the depth   (3)
 *
 * with s = 1 for a piston, and for a flap see sph_paddle_set_flap(). Order 2 suppresses the free
 * wave of twice the frequency. Warnings tell when H L^2/d^3 > 8 pi^2/3, where (2) has a second crest
 * (Madsen 1971), and when H/L > 0.142 tanh kd, where waves break (Miche 1944).
 *
 * Units      height, depth m; period s; gravity m s^-2; phase rad
 * Ownership  the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT out or context is NULL, order not 1 or 2, a number not finite, height,
 *            period, depth or gravity not > 0, no finite stroke; SPH_E_MEMORY
 * Source     Biesel (1951) for (3); Madsen (1971), doi:10.1029/JC076i036p08672, for (2);
 *            differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_regular(sph_context *context, int order,
                                                           double height, double period,
                                                           double depth, double gravity,
                                                           double phase, sph_paddle **out);

/** Create a first-order law for irregular waves, with a smooth start of one peak period from t = 0.
 *
 *     s(f) = f^-5 exp(-5/4 (fp/f)^4) gamma^exp(-(f/fp - 1)^2/(2 sigma^2)), sigma = 0.07, 0.09
 *            below and above fp = 1/peak_period                                                  (1)
 *     f_j = fp (1/2 + 5/2 (j + 1/2)/components), a_j^2 proportional to s(f_j)                    (2)
 *     sum of a_j^2/2 = significant_height^2/16                                                   (3)
 *     x_b = sum S_j/2 sin(w_j t - e_j), S_j from a_j as for regular waves                        (4)
 *
 * Frequencies have equal distances df = 5/2 fp/components, so groups repeat after 1/df: take more
 * components than 5/2 of the peak periods to be run. The phases e_j in [0, 2 pi) are the numbers of
 * splitmix64 that follow seed, the same on every machine. Warnings tell when waves of this height
 * and the peak period break (Miche), and when the shortest component is below depth/1000.
 *
 * Units      significant_height, depth m; peak_period s; gamma dimensionless, usually 3.3, and 1 for
 *            Pierson-Moskowitz; gravity m s^-2; components 10 to 100000
 * Ownership  the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT out or context is NULL, unknown spectrum, a number not finite,
 *            significant_height, peak_period, depth or gravity not > 0, gamma not in [1, 20] or not
 *            1 for Pierson-Moskowitz, components out of range, no finite stroke; SPH_E_MEMORY
 * Source     Hasselmann et al. (1973), Dtsch. hydrogr. Z. A8(12); Pierson and Moskowitz (1964),
 *            doi:10.1029/JZ069i024p05181; differs: scaled to (3) between fp/2 and 3 fp
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_spectrum(
    sph_context *context, sph_spectrum spectrum, double significant_height, double peak_period,
    double gamma, double depth, double gravity, int components, uint64_t seed, sph_paddle **out);

/** Create a first-order law for a focused group, with a smooth start of one peak period from t = 0.
 *
 *     a_j proportional to s(f_j), (1) and (2) of sph_paddle_create_spectrum(), sum a_j = amplitude
 *     x_b = sum S_j/2 sin(w_j (t - focus_time) + k_j focus_distance)                             (1)
 *
 * so that linear waves have their crests together at focus_distance from the paddle at focus_time,
 * counted from the start. The amplitudes are those of the mean highest crest of a Gaussian sea.
 * Warnings tell when a component's energy cannot reach the focus by then, when the group repeats
 * before (1/df < focus_time), when the crest breaks (2 amplitude over the peak's wavelength, Miche),
 * and when the shortest component is below depth/1000.
 *
 * Units      peak_period, focus_time s; gamma as there; depth, focus_distance, amplitude m; gravity
 *            m s^-2; components 10 to 100000
 * Ownership  the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT out or context is NULL, unknown spectrum, a number not finite, amplitude,
 *            peak_period, depth, gravity, focus_distance or focus_time not > 0, gamma or components
 *            as there, no finite stroke; SPH_E_MEMORY
 * Source     Tromans, Anaturk and Hagemeijer (1991), ISOPE; differs: discrete components
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_focused(
    sph_context *context, sph_spectrum spectrum, double peak_period, double gamma, double depth,
    double gravity, int components, double focus_distance, double focus_time, double amplitude,
    sph_paddle **out);

/** Create a law from displacements at given times: a cubic spline, at rest before and after them.
 *
 * The spline passes through all points, has continuous velocity and acceleration between the first
 * and the last time, and velocity zero at both, so that velocity never jumps. Acceleration jumps
 * there from and to zero by what the spline has; a warning tells when that is more than half of the
 * largest acceleration within: the series then does not start or end at rest.
 *
 * Shape      t, displacement [n]; n >= 2
 * Units      t s; displacement m
 * Ownership  t and displacement are copied; the caller destroys *out, which holds a reference to
 *            context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, n < 2, a number not finite, a time not after the one
 *            before (with its index), velocities that overflow; SPH_E_MEMORY
 * Source     clamped cubic spline, de Boor (1978), chapter IV; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_series(sph_context *context, int64_t n,
                                                          const double *t,
                                                          const double *displacement,
                                                          sph_paddle **out);

/** Create the law of sph_paddle_create_series() from two columns of a file of comma-separated values.
 *
 * The first line that is neither empty nor starts with '#' names the columns; such lines are passed
 * over everywhere. Names and numbers may stand in double quotes and between blanks. Numbers have a
 * decimal point whatever the locale is. Lines end with LF or CR LF and have at most 65535 bytes.
 *
 * Units      the columns' numbers in s and m
 * Ownership  borrows the texts; the file is closed on return; the caller destroys *out, which holds a
 *            reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, less than two rows, a time not after the one before or
 *            a number not finite (with line); SPH_E_NAME no column of that name, or two; SPH_E_IO the
 *            file cannot be read, a line has another number of fields than the header, is too long,
 *            or has a field that is no number (with line); SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_csv(sph_context *context, const char *path,
                                                       const char *time_column,
                                                       const char *displacement_column,
                                                       sph_paddle **out);

/** Create a law from a caller's function, which is asked at every time.
 *
 * Ownership  user is kept as it is and must live as long as the paddle; the caller destroys *out,
 *            which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, function or out is NULL; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_create_function(sph_context *context,
                                                            sph_paddle_function function,
                                                            void *user, sph_paddle **out);

/** Release the paddle and set *paddle to NULL. NULL is allowed.
 *
 * Ownership  no wall may use the paddle any more
 * Parallel   not while another call uses the paddle or its context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_paddle_destroy(sph_paddle **paddle);

/** Move the whole law in time so that it starts at start_time.
 *
 * Units      s
 * Parallel   not while another call uses the paddle or its context
 * Errors     SPH_E_ARGUMENT paddle is NULL, start_time not finite; SPH_E_TYPE a caller's function
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_set_start(sph_paddle *paddle, double start_time);

/** Choose how the endless law of a solitary wave starts and ends.
 *
 * The first and the last fraction of the stroke are left to the polynomial
 *
 *     x_b = x_1 s^3 (a + b s + c s^2), s = (t - start)/duration                                  (1)
 *
 * (mirrored at the end), which is at rest at s = 0, also in acceleration, and goes over into the law
 * at s = 1 with the same displacement, velocity and acceleration. It never moves backwards. The start
 * stays where it is, the end follows. The default is fraction (1 - tanh 2.8)/2 = 0.37 %, duration
 * 2 x_1/v_1 = 1/(kappa c): the whole motion then takes 2/(kappa c) (3.8 + H/d) within 0.5 %, as
 * Goring's, which is cut where 0.05 % of the stroke is left.
 *
 * Units      fraction 1e-6 to 0.1; duration s, > 0 and at most 3 x_1/v_1, or 0 for 2 x_1/v_1
 * Parallel   not while another call uses the paddle or its context
 * Errors     SPH_E_ARGUMENT paddle is NULL, fraction or duration out of range; SPH_E_TYPE not a law
 *            of solitary waves
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_set_ends(sph_paddle *paddle, double fraction,
                                                     double duration);

/** Choose the duration T of the smooth start of regular, irregular and focused waves.
 *
 *     x_b is multiplied with s^3 (10 - 15 s + 6 s^2), s = (t - start)/T in [0, 1]                (1)
 *
 * so that displacement, velocity and acceleration are continuous. The default is the (peak) period.
 *
 * Units      duration s, > 0
 * Parallel   not while another call uses the paddle or its context
 * Errors     SPH_E_ARGUMENT paddle is NULL, duration not finite or not > 0; SPH_E_TYPE the law has
 *            no such start
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_set_ramp(sph_paddle *paddle, double duration);

/** Tell the depth of still water at the paddle of a time series or a caller's function, which know
 * none; a flap needs it.
 *
 * Units      m
 * Parallel   not while another call uses the paddle or its context
 * Errors     SPH_E_ARGUMENT paddle is NULL, depth not finite or not > 0, or not above the hinge of a
 *            flap; SPH_E_TYPE the law has its depth already
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_set_depth(sph_paddle *paddle, double depth);

/** Make the wave maker a flap that is hinged at a height above the bed, instead of a piston.
 *
 * Displacements are then those of the flap at still water level, and
 *
 *     angle = atan(displacement/(depth - hinge_height))                                          (1)
 *     s(y) = (y - l)/(d - l) for y > l = hinge_height, 0 below, in (3) of
 *            sph_paddle_create_regular()                                                         (2)
 *     k I = sinh kd - (cosh kd - cosh(k max(l, 0)))/(k (d - l))                                  (3)
 *
 * The strokes of regular, irregular and focused waves are found anew. A hinge below the bed
 * (hinge_height < 0) stands for a paddle that also moves at the bed.
 *
 * Units      m; 0: at the bed
 * Parallel   not while another call uses the paddle or its context
 * Errors     SPH_E_ARGUMENT paddle is NULL, hinge_height not finite or not < depth, no depth known
 *            (sph_paddle_set_depth), no finite stroke; SPH_E_UNSUPPORTED solitary waves and regular
 *            waves of order 2, whose laws are those of a piston
 * Source     Biesel (1951) for the hinge at the bed; Dean and Dalrymple (1991), chapter 6; differs:
 *            none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_set_flap(sph_paddle *paddle, double hinge_height);

/** Displacement, velocity and acceleration at time t; of a flap those at still water level.
 *
 * Shape      three numbers; any of the pointers may be NULL
 * Units      t s; m, m s^-1, m s^-2
 * Ownership  the caller owns the numbers, which stay as they are after an error
 * Parallel   thread-safe for reading if a caller's function is
 * Errors     SPH_E_ARGUMENT paddle is NULL, t not finite, a caller's function gave a number that is
 *            not finite
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_at(const sph_paddle *paddle, double t,
                                               double *displacement, double *velocity,
                                               double *acceleration);

/** Angle of a flap from the vertical, its rate and acceleration at time t.
 *
 * Shape      three numbers; any of the pointers may be NULL
 * Units      t s; rad, rad s^-1, rad s^-2
 * Ownership  the caller owns the numbers, which stay as they are after an error
 * Parallel   thread-safe for reading if a caller's function is
 * Errors     as sph_paddle_at; SPH_E_TYPE the paddle is a piston
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_angle_at(const sph_paddle *paddle, double t,
                                                     double *angle, double *rate,
                                                     double *acceleration);

/** The motion along +x of a wall: sph_wall_set_motion(wall, sph_paddle_motion, paddle).
 *
 * Writes element 0 of the three; a flap, which no translation describes, gives NaN, which the wall
 * refuses.
 *
 * Shape      displacement, velocity, acceleration [dim] of the wall
 * Units      t s; m, m s^-1, m s^-2
 * Ownership  paddle is a sph_paddle, which must live as long as the wall
 * Parallel   thread-safe for reading if a caller's function is
 * Errors     none; NULL gives NaN
 * Since      0.1
 */
SPH_API void sph_paddle_motion(double t, double *displacement, double *velocity,
                               double *acceleration, void *paddle);

/** The rotation of a wall that is a flap: sph_wall_set_rotation(wall, hinge, NULL, sph_paddle_rotation,
 * paddle), with the water on the +x side.
 *
 * Writes minus the angle of sph_paddle_angle_at(): a flap that leans towards +x has turned clockwise,
 * which is negative in 2D. In 3D, z up, the axis is (0, -1, 0). A piston gives NaN, which the wall refuses.
 *
 * Units      t s; rad, rad s^-1, rad s^-2
 * Ownership  paddle is a sph_paddle, which must live as long as the wall
 * Parallel   thread-safe for reading if a caller's function is
 * Errors     none; NULL gives NaN
 * Since      0.1
 */
SPH_API void sph_paddle_rotation(double t, double *angle, double *rate, double *acceleration,
                                 void *paddle);

/** How far the paddle moves: solitary waves, from rest to rest; regular waves and time series,
 * between the extremes; irregular waves, 4 standard deviations; focused waves, the sum of the
 * components' strokes, which no time exceeds. NaN for a caller's function and NULL.
 *
 * Units      m
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_paddle_stroke(const sph_paddle *paddle);

/** When the paddle starts to move; -infinity for a caller's function, NaN for NULL.
 *
 * Units      s
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_paddle_start(const sph_paddle *paddle);

/** When the paddle is at rest again; infinity where it never is, NaN for NULL.
 *
 * Units      s
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_paddle_end(const sph_paddle *paddle);

/** Law of the paddle; 0 if paddle is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_paddle_get_type(const sph_paddle *paddle);

/** Number of linear components of regular, irregular and focused waves; 0 for other laws and NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_paddle_component_count(const sph_paddle *paddle);

/** One linear component: far from the paddle, with t from sph_paddle_start() and x from the paddle's
 * mean position, it is
 *
 *     eta = amplitude cos(wave_number x - 2 pi frequency t + phase)                              (1)
 *     x_b = stroke/2 sin(2 pi frequency t - phase)                                               (2)
 *
 * Shape      five numbers; any of the pointers may be NULL
 * Units      frequency Hz; wave_number 1/m; amplitude, stroke m; phase rad
 * Ownership  the caller owns the numbers, which stay as they are after an error
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT paddle is NULL, no such component
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_paddle_get_component(const sph_paddle *paddle, int component,
                                                          double *frequency, double *wave_number,
                                                          double *amplitude, double *phase,
                                                          double *stroke);

/** Number of laws: they are the numbers 1 to this one, for lists and menus.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_paddle_type_count(void);

/** Name of a law, for example "solitary"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_paddle_type_name(sph_paddle_type type);

/** One line about a law; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_paddle_type_summary(sph_paddle_type type);

/** The publication a law is taken from; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_paddle_type_source(sph_paddle_type type);

SPH_END_DECLS

#endif
