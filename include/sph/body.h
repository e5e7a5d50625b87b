/** @file
 * Bodies with one degree of freedom: a mass on a spring with damper, friction and stops, held by a
 * threshold, that a force drives. Usable alone, or as what moves a wall (sph_wall_set_body).
 */
#ifndef SPH_BODY_H
#define SPH_BODY_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** How a threshold holds a body. */
typedef enum sph_threshold {
  SPH_THRESHOLD_PRELOAD =
      0, /**< only what of the force exceeds it counts, at all times: the default */
  SPH_THRESHOLD_RELEASE =
      1 /**< it holds the body at its lower stop; off there the whole force counts */
} sph_threshold;

/** How a body moves in a step. */
typedef enum sph_body_rule {
  SPH_BODY_CONSISTENT =
      0, /**< exact for a constant force, at rest when it meets a stop: the default */
  SPH_BODY_AS_PRINTED = 1 /**< semi-implicit Euler, the velocity goes on through the lower stop */
} sph_body_rule;

/** Create a body at rest at x = 0.
 *
 *     m x'' = F* - k (x - x0) - c x' - R sign(x'),   lower <= x <= upper                            (1)
 *     F* = max(F - F0, 0)   SPH_THRESHOLD_PRELOAD                                                 (2)
 *     F* = F                SPH_THRESHOLD_RELEASE, once F > F0 + k (lower - x0) has let it go       (3)
 *
 * until called with other values k = c = R = F0 = 0 and no stops, and F* = F.
 *
 * Units      mass kg, or kg/m beside forces in N/m of a 2D flow
 * Ownership  the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, mass not finite or <= 0; SPH_E_MEMORY
 * Source     (2) Liang et al. (2017) eq. (16)-(18), Huang et al. (2019) eq. (26)-(28); (3) own
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_create(sph_context *context, double mass, sph_body **out);

/** Release the caller's reference and set *body to NULL. NULL is allowed.
 *
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_body_destroy(sph_body **body);

/** Spring of stiffness k that pulls towards x0.
 *
 * Units      stiffness N/m (N/m^2 in 2D), >= 0; rest m
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT body NULL, stiffness not finite or < 0, rest not finite
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_set_spring(sph_body *body, double stiffness, double rest);

/** Damper c.
 *
 * Units      N s/m (N s/m^2 in 2D), >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT body NULL, damping not finite or < 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_set_damping(sph_body *body, double damping);

/** Coulomb friction: `kinetic` R against the motion; a body at rest stays so while the other forces are
 * not above `at_rest`.
 *
 * Units      N (N/m in 2D), at_rest >= kinetic >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT body NULL, not finite, kinetic < 0 or at_rest < kinetic
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_set_friction(sph_body *body, double at_rest,
                                                       double kinetic);

/** Threshold F0 of the force, and what it does.
 *
 * Units      N (N/m in 2D), >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT body NULL, force not finite or < 0, kind unknown; (3) without a lower stop
 *            when the body is moved
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_set_threshold(sph_body *body, double force,
                                                        sph_threshold kind);

/** Stops: the body comes to rest where it meets one.
 *
 * Units      m; lower < upper, -INFINITY and INFINITY for none
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT body NULL, a NaN, lower >= upper, the body is not between them
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_set_stops(sph_body *body, double lower, double upper);

/** Choose how it moves.
 *
 *     v += dt a,  x = max(x + dt v, lower),  a = (F* - k (x - x0) - c v)/m      SPH_BODY_AS_PRINTED
 *
 * Friction and upper stop are no part of the printed rule.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT body NULL, rule unknown
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_set_rule(sph_body *body, sph_body_rule rule);

/** Put the body somewhere, before it moves a wall.
 *
 * Units      m, m/s
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT body NULL, not finite, outside the stops, or it moves a wall already
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_set_state(sph_body *body, double displacement,
                                                    double velocity);

/** Where the body is. Each pointer may be NULL.
 *
 * Units      m, m/s, m/s^2, and the force of the last step, N (N/m in 2D)
 * Ownership  fills the caller's numbers
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT body NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_get_state(const sph_body *body, double *displacement,
                                                    double *velocity, double *acceleration,
                                                    double *force);

/** Move a body under a constant force for a time. A body that moves a wall is moved by the flow.
 *
 * Units      N (N/m in 2D), s, dt >= 0
 * Parallel   not while another call uses the body
 * Errors     SPH_E_ARGUMENT body NULL, not finite, dt < 0 or more than 10^6 of the body's own times
 *            min(sqrt(m/k), m/c), a threshold that releases without a lower stop; SPH_E_DIVERGED its
 *            place is not finite any more; the body is then where it was
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_body_advance(sph_body *body, double force, double dt);

SPH_END_DECLS

#endif
