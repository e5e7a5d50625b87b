/** @file
 * Solid walls: polylines in 2D, boxes in 2D and 3D, plane quadrilaterals in 3D, at rest, in
 * prescribed motion or driven by the water.
 */
#ifndef SPH_WALL_H
#define SPH_WALL_H

#include <sph/body.h>

SPH_BEGIN_DECLS

/** What a wall does to the velocity along it. */
typedef enum sph_slip {
  SPH_FREE_SLIP = 0, /**< the fluid slides along the wall: the default */
  SPH_NO_SLIP = 1    /**< the fluid sticks to the wall */
} sph_slip;

/** Sides of a box to leave open: the low and the high end of direction d (0, 1, 2). */
#define SPH_SIDE_LO(d) (1u << (2 * (d)))
#define SPH_SIDE_HI(d) (2u << (2 * (d)))

/** Prescribed translation of a wall: writes displacement from where the wall was created [m],
 * velocity [m/s] and acceleration [m/s^2] at time t [s], each [dim] and zero before the call.
 * The three must belong together: velocity is the rate of displacement, acceleration that of
 * velocity.
 */
typedef void (*sph_wall_motion)(double t, double *displacement, double *velocity,
                                double *acceleration, void *user);

/** Prescribed rotation of a wall: writes angle from where the wall was created [rad], rate [rad/s] and
 * acceleration [rad/s^2] at time t [s], zero before the call. The three must belong together.
 */
typedef void (*sph_wall_rotation)(double t, double *angle, double *rate, double *acceleration,
                                  void *user);

/** Motion of a wall by the water's force on it, from one step to the next: called once a step, before
 * anything moves, with the force in the middle of the step [dim, N, in 2D N/m; positive towards the
 * solid], put on from the evaluations before. Displacement
 * from where the wall was created [m], velocity [m/s] and acceleration [m/s^2], each [dim], hold the
 * state at t (zero at first) and are to hold that at t + dt on return. A status that is not SPH_OK ends
 * the step with it; walls whose drivers ran before have moved then.
 */
typedef sph_status (*sph_wall_driver)(double t, double dt, const double *force,
                                      double *displacement, double *velocity, double *acceleration,
                                      void *user);

/** Create a 2D wall from the line through the vertices; the fluid is on the left of someone who
 * walks along it.
 *
 * A tank is top left, bottom left, bottom right, top right. With `closed` the last vertex is joined
 * to the first: a counterclockwise polygon is a basin, a clockwise one an obstacle. Facet k goes
 * from vertex k to vertex k + 1.
 *
 * Shape      xy [vertices, 2]; vertices >= 2, or >= 3 if closed
 * Units      xy in m
 * Ownership  xy is copied; the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, too few vertices, a coordinate not finite or above
 *            1e100, equal neighbours, segments that double back (angle 0 or 360 degrees), cross
 *            or touch each other (both are named); SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_create_polyline(sph_context *context, int vertices,
                                                          const double *xy, bool closed,
                                                          sph_wall **out);

/** Create the walls of a box with the fluid inside.
 *
 * Facets in 2D: bottom, right, top, left; in 3D: low x, high x, low y, high y, low z, high z; open
 * sides are left out and the others counted on. An open top is SPH_SIDE_HI(1) in 2D and
 * SPH_SIDE_HI(2) in 3D.
 *
 * Shape      lo, hi [dim]; dim 2 or 3
 * Units      lo, hi in m
 * Ownership  lo and hi are copied; the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, dim not 2 or 3, a coordinate not finite or above
 *            1e100, hi <= lo, open_sides has bits of no side or opens every side; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_create_box(sph_context *context, int dim,
                                                     const double *lo, const double *hi,
                                                     unsigned open_sides, sph_wall **out);

/** Create a 3D wall from plane convex quadrilaterals, corners counterclockwise as the fluid sees
 * them, so that the right-hand rule gives the normal into the fluid.
 *
 * Facets that meet share a whole edge: corners are one where they differ by less than 1e-9 of the
 * largest coordinate or extent. A T junction is not recognised as shared. Facets must not
 * cut through each other, which is not checked.
 *
 * Shape      corners [facets, 4, 3]; facets >= 1
 * Units      corners in m
 * Ownership  corners is copied; the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, facets < 1, a coordinate not finite or above 1e100,
 *            a facet degenerate, not convex or out of its plane by more than 1e-6 of its size, an
 *            edge of three facets, neighbours with opposed normals or folded onto each other;
 *            SPH_E_UNSUPPORTED a concave corner where no facet is perpendicular to the two others,
 *            or where facets of more than three directions meet; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_create_facets(sph_context *context, int facets,
                                                        const double *corners, sph_wall **out);

/** Release the caller's reference and set *wall to NULL. NULL is allowed.
 *
 * Ownership  the memory goes when the last boundary made from it is destroyed
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_wall_destroy(sph_wall **wall);

/** Name the wall for messages and output; "wall" until then.
 *
 * Ownership  name is copied
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT wall or name is NULL, name is empty; SPH_E_MEMORY (the old name stays)
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_set_name(sph_wall *wall, const char *name);

/** Name of the wall; "" if wall is NULL.
 *
 * Ownership  text in the wall, valid until it is renamed or destroyed
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_wall_name(const sph_wall *wall);

/** Choose free slip (the default) or no slip, before a boundary is made from the wall.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT wall is NULL or slip is not one of sph_slip
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_set_slip(sph_wall *wall, sph_slip slip);

/** Give the whole wall a prescribed translation (NULL: fixed, the default), before a boundary is
 * made from it.
 *
 * Ownership  user is kept as it is and must live as long as the wall
 * Parallel   not while another call uses the context; motion is called from the thread that calls
 *            the library
 * Errors     SPH_E_ARGUMENT wall is NULL, or has a driver or a body
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_set_motion(sph_wall *wall, sph_wall_motion motion,
                                                     void *user);

/** Let the whole wall rotate about a fixed axis (NULL rotation: not, the default), before a boundary is
 * made from it. A translation by sph_wall_set_motion carries the pivot along.
 *
 *     x = c + d + R(angle) (X - c),   c the pivot, d the displacement, X the place at creation
 *
 * Shape      pivot [dim]; axis [3] by the right-hand rule, not used in 2D, where angles count
 *            counterclockwise
 * Units      pivot m; axis any length
 * Ownership  pivot and axis are copied; user is kept as it is and must live as long as the wall
 * Parallel   not while another call uses the context; rotation is called from the thread that calls
 *            the library
 * Errors     SPH_E_ARGUMENT wall is NULL; with a rotation: pivot NULL, not finite or above 1e100, in
 *            3D axis NULL, not finite or zero
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_set_rotation(sph_wall *wall, const double *pivot,
                                                       const double *axis,
                                                       sph_wall_rotation rotation, void *user);

/** Let the caller's solver move the wall by the force on it (NULL: not, the default), before a boundary
 * is made from it. Within a step the wall follows the cubic through both ends.
 *
 * Ownership  user is kept as it is and must live as long as the wall
 * Parallel   not while another call uses the context; driver is called from the thread that steps
 * Errors     SPH_E_ARGUMENT wall is NULL, has a prescribed translation or is moved by a body
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_set_driver(sph_wall *wall, sph_wall_driver driver,
                                                     void *user);

/** Let a body move the wall along a direction, by the part along it of the water's force: a driver.
 *
 * Shape      direction [dim], a unit vector
 * Ownership  holds a reference to body, which moves one wall at most and which the flow then moves;
 *            copies direction
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, direction not a unit vector to 1e-6, the wall has a prescribed motion
 *            or a driver, the body moves another wall or is of another context
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_set_body(sph_wall *wall, sph_body *body,
                                                   const double *direction);

/** Dimension of the wall, 2 or 3; 0 if wall is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_wall_dim(const sph_wall *wall);

/** Number of facets (segments in 2D); 0 if wall is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_wall_facet_count(const sph_wall *wall);

/** Unit normal of a facet of the wall where it was created, into the fluid.
 *
 * Shape      normal [dim]
 * Units      dimensionless
 * Ownership  the caller owns normal
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT wall or normal is NULL, no such facet
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_facet_normal(const sph_wall *wall, int facet,
                                                       double *normal);

/** Signed distance from a point to the wall as it stands at time t: positive on the fluid side.
 *
 *     |distance| = min over the wall's points y of |x - y|
 *     sign = sign of sum_k w_k (x - foot_k) . n_k over the facets k that are nearest
 *
 * with n_k into the fluid and w_k the angle that facet k spans around its nearest point foot_k. Far
 * from the ends of an open wall the sign means little.
 *
 * Shape      x [dim]; distance one number
 * Units      m; t in s
 * Ownership  the caller owns x and distance
 * Parallel   thread-safe for reading if the wall's motion is
 * Errors     SPH_E_ARGUMENT a pointer is NULL, t or x not finite, x above 1e100, or the wall's
 *            motion gave a value that is not finite; distance is then left alone
 * Source     Baerentzen and Aanaes (2005), doi:10.1109/TVCG.2005.49, angle-weighted pseudonormal;
 *            differs: also used between facets that are equally near without touching
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wall_distance(const sph_wall *wall, double t, const double *x,
                                                   double *distance);

SPH_END_DECLS

#endif
