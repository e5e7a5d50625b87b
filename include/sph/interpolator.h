/** @file
 * Interpolators: the value of a field between particles, also where the particles end.
 */
#ifndef SPH_INTERPOLATOR_H
#define SPH_INTERPOLATOR_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Kinds of interpolators; numbers 1 to sph_interpolator_count() without gaps, never renumbered.
 *
 * With x_k the point, x_j the particles within the support R, r = |x_j - x_k|, D = x_j - x_k:
 *
 *     I[f] = sum_j phi_j f_j,   sum_j phi_j = 1
 */
typedef enum sph_interpolator_type {
  /** phi = w / sum w, w = (r/R)^-mu exp(-mu (r/a)^2 / (1 - (r/R)^lambda)); exact at a particle, never
   * outside the range of the neighbours' values, first order */
  SPH_INTERPOLATOR_IMPROVED_SHEPARD = 1,
  SPH_INTERPOLATOR_NORMALIZED = 2, /**< phi = W V / sum W V; as above but not exact at a particle */
  /** phi = z . b W V with b = (1, D/h) and (sum b b W V) z = (1, 0, ...); exact for linear fields,
   * second order, may leave the range of the neighbours' values */
  SPH_INTERPOLATOR_MLS_LINEAR = 3
} sph_interpolator_type;

/** What gave the value at a point, ordered by order of accuracy. A method that the neighbours of a
 * point do not carry is replaced by SPH_RUNG_SHEPARD there.
 */
typedef enum sph_interpolator_rung {
  SPH_RUNG_NONE = 0,       /**< no particle within the support: the value is 0 and means nothing */
  SPH_RUNG_SHEPARD = 1,    /**< improved Shepard */
  SPH_RUNG_NORMALIZED = 2, /**< normalised kernel; sum W V >= 1e-4 */
  /** moving least squares; at least 5 neighbours in 2D and 8 in 3D, sum W V >= 1e-4, ratio of pivots
   * of the moment matrix >= 1e-7 (1e-3 in single precision), sum |phi| <= 3 */
  SPH_RUNG_LINEAR = 3
} sph_interpolator_rung;

/** Create an interpolator. The kernel gives the support radius R, and W where the method uses it.
 *
 * Ownership  the caller destroys *out (NULL after an error); it holds references to context and kernel
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, kernel or out NULL, unknown type, a kernel of another context or
 *            with dim 1; SPH_E_MEMORY
 * Source     Huang et al. (2019), see sph_interpolator_source(); equations in docs/interpolator.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_create(sph_context *context,
                                                         sph_interpolator_type type,
                                                         sph_kernel *kernel,
                                                         sph_interpolator **out);

/** Release the caller's reference and set *interpolator to NULL. NULL is allowed.
 *
 * Ownership  the memory goes when the last handle made from it is destroyed
 * Parallel   not while another call uses the interpolator or its context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_interpolator_destroy(sph_interpolator **interpolator);

/** The kind of interpolator with this name; the message of a failure suggests the nearest one.
 *
 * Ownership  *type is untouched after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, name or type NULL; SPH_E_NAME no such interpolator
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_find(sph_context *context, const char *name,
                                                       sph_interpolator_type *type);

/** Number of kinds of interpolators.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_interpolator_count(void);

/** Kind k of them, k = 0 to sph_interpolator_count() - 1, for lists and menus; 0 for any other k.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API sph_interpolator_type sph_interpolator_at(int k);

/** Name of a kind, for example "mls-linear"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_interpolator_name(sph_interpolator_type type);

/** One line about a kind; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_interpolator_summary(sph_interpolator_type type);

/** The publication a kind is taken from; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_interpolator_source(sph_interpolator_type type);

/** Name of a rung: "none", "shepard", "normalized", "linear"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_interpolator_rung_name(sph_interpolator_rung rung);

/** Kind of an interpolator; 0 if interpolator is NULL.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_interpolator_get_type(const sph_interpolator *interpolator);

/** Whether boundaries that use this interpolator compensate for the hydrostatic gradient: true at first.
 * sph_interpolator_evaluate() knows no gradient and sph_interpolator_evaluate_compensated() is told one;
 * neither looks at this.
 *
 *     p(x) = I[p + rho0 (f - a) . (x - x_j)]                                       (1)
 *
 * Linear methods are exact without it.
 *
 * Parallel   not while another call uses the interpolator
 * Errors     SPH_E_ARGUMENT interpolator is NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_set_compensation(sph_interpolator *interpolator,
                                                                   bool compensation);

/** Choose the weight of improved Shepard, also where it only replaces another method.
 *
 *     w = (r/R)^-mu exp(-mu (r/a)^2 / (1 - (r/R)^lambda)),   r < R                 (1)
 *
 * At first mu = 4, a/R = 1, lambda = 2. mu = 2 with a = 2 h errs about 0.6 times as much. mu of 2 or 4
 * with lambda 2 or 4 is evaluated without pow and is several times faster.
 *
 * Units      mu 1 to 16; scale = a/R 0.05 to 1e6; lambda 0.5 to 16
 * Parallel   not while another call uses the interpolator
 * Errors     SPH_E_ARGUMENT interpolator NULL, a number out of range; nothing changes then
 * Source     Huang et al. (2019), eq. (19)-(20); differs: the exponential that (20) lost is restored, and
 *            the scale a makes it free of units
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_set_shepard(sph_interpolator *interpolator,
                                                              double mu, double scale,
                                                              double lambda);

/** Interpolate fields of a particle set to points, in double precision.
 *
 *     values[k] = sum_j phi_j(at[k]) f_j                                           (1)
 *
 * A point without any particle within the support gets the value 0 and SPH_RUNG_NONE. Any point is
 * allowed, in or outside the particles. The particles' volumes are the V of W V. Results do not depend
 * on the number of threads.
 *
 * Shape      at [points, dim]; names [fields]; values [points, components], the components of all
 *            fields in the order of names; rungs [points], sph_interpolator_rung, or NULL
 * Units      at m; values the fields'
 * Ownership  borrows all arguments; values and rungs are written only if it succeeds
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT interpolator, source, names or a name NULL, at or values NULL though
 *            points > 0, points < 0, fields < 1, source empty, of another context or of another dim
 *            than the kernel, a point, a position or a value not finite, a volume not > 0 (index or
 *            id is named), particles more than about 1e9 supports apart; SPH_E_NAME no such field;
 *            SPH_E_MEMORY
 * Source     Huang et al. (2019), eq. (8)-(9), (14)-(15), (19)-(20); differs: see docs/interpolator.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_evaluate(const sph_interpolator *interpolator,
                                                           const sph_particles *source,
                                                           int64_t points, const double *at,
                                                           int fields, const char *const *names,
                                                           double *values, int *rungs);

/** Interpolate a scalar field whose gradient is known in the mean, in double precision.
 *
 *     values[k] = sum_j phi_j (f_j + gradient . (at[k] - x_j))                     (1)
 *
 * Exact for fields with this gradient, for every method: for a pressure at rest in a frame that moves
 * with the acceleration a, gradient = rho0 (f - a) with f the body force per mass.
 *
 * Shape      at [points, dim]; gradient [dim]; values [points]; rungs [points] or NULL
 * Units      at m; gradient the field's per m; values the field's
 * Ownership  borrows all arguments; values and rungs are written only if it succeeds
 * Parallel   not while another call uses the context
 * Errors     as sph_interpolator_evaluate; SPH_E_ARGUMENT name or gradient NULL, gradient not finite, a
 *            field with more than one component
 * Source     own; for an interpolator that reproduces constants it adds first-order consistency for
 *            the known part of the field; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_evaluate_compensated(
    const sph_interpolator *interpolator, const sph_particles *source, int64_t points,
    const double *at, const char *name, const double *gradient, double *values, int *rungs);

SPH_END_DECLS

#endif
