/** @file
 * Interpolators: the value of a field between particles, also where the particles end.
 */
#ifndef SPH_INTERPOLATOR_H
#define SPH_INTERPOLATOR_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Kinds of interpolators; numbers 1 to sph_interpolator_count() without gaps, never renumbered.
 *
 * With x_k the point, x_j the particles within the support R, r = |x_j - x_k|, D = x_j - x_k, W the
 * kernel and V the volumes:
 *
 *     I[f] = sum_j phi_j f_j,   sum_j phi_j = 1
 *
 * Also what gave the value at a point: 0 if there is no particle within the support, or the kind that
 * its neighbours carry. A kind whose condition (in brackets) they do not meet gives way to the next one
 * of its ladder:
 *
 *     mls-quadratic -> mls-linear -> improved-shepard -> nearest
 *     sfdi, sfdi-printed -> normalized -> improved-shepard -> nearest
 *     normalized, user -> improved-shepard -> nearest
 *     the kinds of Shepard -> nearest
 */
typedef enum sph_interpolator_type {
  /** phi = w / sum w, w = (r/R)^-mu exp(-mu (r/a)^2 / (1 - (r/R)^lambda)); exact at a particle, never
   * outside the range of the neighbours' values, first order [one neighbour] */
  SPH_INTERPOLATOR_IMPROVED_SHEPARD = 1,
  /** phi = W V / sum W V; as above but not exact at a particle [sum W V >= 1e-4] */
  SPH_INTERPOLATOR_NORMALIZED = 2,
  /** phi = z . b W V with b = (1, D/h) and (sum b b W V) z = (1, 0, ...); exact for linear fields,
   * second order, may leave the range of the neighbours' values [5 neighbours in 2D, 8 in 3D,
   * sum W V >= 1e-4, ratio of pivots of the moment matrix >= 1e-7 (1e-3 in single precision),
   * sum |phi| <= 3] */
  SPH_INTERPOLATOR_MLS_LINEAR = 3,
  /** Shepard's own: w = (r/R)^-mu, cut off at R; as improved Shepard [one neighbour] */
  SPH_INTERPOLATOR_CLASSIC_SHEPARD = 4,
  /** improved Shepard that begins with mu = 2, a = 2 h instead of mu = 4, a = R [one neighbour] */
  SPH_INTERPOLATOR_TUNED_SHEPARD = 5,
  /** I[f] = sum W f / sum W - R0 . g: the mean taken back to the point by the gradient g at the nearest
   * particle, R0 = sum W D / sum W; exact for linear fields, second order [as mls-linear, with the
   * matrix of the gradient and sum |phi| <= 6] */
  SPH_INTERPOLATOR_SFDI = 6,
  /** sfdi with the gradient as Huang et al. (2019) print it, without its cross terms: exact for linear
   * fields only where the neighbours lie symmetrically */
  SPH_INTERPOLATOR_SFDI_PRINTED = 7,
  /** mls-linear with the products of second degree in b; exact for quadratic fields, third order [10
   * neighbours in 2D, 16 in 3D, sum W V >= 1e-4, ratio of pivots >= 1e-7 (1e-5), sum |phi| <= 3] */
  SPH_INTERPOLATOR_MLS_QUADRATIC = 8,
  SPH_INTERPOLATOR_NEAREST = 9, /**< the value of the nearest particle [one neighbour] */
  SPH_INTERPOLATOR_USER = 10    /**< the caller's weights, see sph_interpolator_create_user() */
} sph_interpolator_type;

/** Create an interpolator. The kernel gives the support radius R, and W where the method uses it.
 *
 * Ownership  the caller destroys *out (NULL after an error); it holds references to context and kernel
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, kernel or out NULL, unknown type, a kernel of another context or
 *            with dim 1, or SPH_INTERPOLATOR_USER, which sph_interpolator_create_user() makes;
 *            SPH_E_MEMORY
 * Source     Huang et al. (2019), see sph_interpolator_source(); equations in docs/interpolator.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_create(sph_context *context,
                                                         sph_interpolator_type type,
                                                         sph_kernel *kernel,
                                                         sph_interpolator **out);

/** The caller's weights at one point, from its neighbours. Called by several threads at once.
 *
 * Shape      offset [n, dim] x_j - x_k; kernel [n] W(r); volume [n]; weights [n] to be written: phi_j
 * Units      m, 1/m^dim, m^dim
 * Returns    true, or false where the neighbours do not carry the method: the ladder goes on there, as
 *            it does where a weight is not finite
 */
typedef bool (*sph_interpolator_weights)(int dim, int n, const double *offset, const double *kernel,
                                         const double *volume, double support, double *weights,
                                         void *user);

/** Create an interpolator with the caller's own weights. They should add up to 1.
 *
 * Ownership  as sph_interpolator_create; user must live as long as the interpolator
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT as sph_interpolator_create, or weights NULL; SPH_E_MEMORY
 * Source     own; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_create_user(sph_context *context,
                                                              sph_kernel *kernel,
                                                              sph_interpolator_weights weights,
                                                              void *user, sph_interpolator **out);

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

/** Name of a kind, for example "mls-linear"; "none" for 0, "unknown" for any other number.
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

/** Choose the weight of Shepard's methods, also where improved Shepard only replaces another one.
 *
 *     w = (r/R)^-mu exp(-mu (r/a)^2 / (1 - (r/R)^lambda)),   r < R                 (1)
 *
 * At first mu = 4, a/R = 1, lambda = 2; for tuned-shepard mu = 2, a = 2 h. Classic Shepard has mu alone.
 * mu of 2 or 4 with lambda 2 or 4 is evaluated without pow and is several times faster.
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
 * A point without any particle within the support gets the value 0 and the rung 0. Any point is
 * allowed, in or outside the particles. The particles' volumes are the V of W V. Results do not depend
 * on the number of threads.
 *
 * Shape      at [points, dim]; names [fields]; values [points, components], the components of all
 *            fields in the order of names; rungs [points], the kind that gave the
 *            value (sph_interpolator_type) or 0 for none; or NULL
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

/** Interpolate gradients of fields of a particle set to points, in double precision, by the methods that
 * have one: sfdi (both) and mls (both).
 *
 *     gradients[k, c, d] = d I[f_c] / d x_d at at[k]                               (1)
 *
 * of the linear or quadratic field that the method fits; sfdi's is that at the nearest particle. Points
 * whose neighbours do not carry such a method get gradients 0, and their rung says so.
 *
 * Shape      at [points, dim]; names [fields]; values [points, components] or NULL; gradients [points,
 *            components, dim]; rungs [points] or NULL
 * Units      at m; gradients the fields' per m
 * Ownership  borrows all arguments; the outputs are written only if it succeeds
 * Parallel   not while another call uses the context
 * Errors     as sph_interpolator_evaluate; SPH_E_ARGUMENT gradients NULL though points > 0;
 *            SPH_E_UNSUPPORTED a method without gradients
 * Source     Huang et al. (2019), eq. (8)-(9), (11)-(12); differs: see docs/interpolator.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_interpolator_evaluate_gradient(
    const sph_interpolator *interpolator, const sph_particles *source, int64_t points,
    const double *at, int fields, const char *const *names, double *values, double *gradients,
    int *rungs);

SPH_END_DECLS

#endif
