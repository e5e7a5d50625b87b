/** @file
 * Neighbour search: which particles are near a point, near a particle, or nearest.
 */
#ifndef SPH_SEARCH_H
#define SPH_SEARCH_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** How neighbours are found; the answers are the same. */
typedef enum sph_search_method {
  SPH_SEARCH_CELL_GRID = 0,  /**< sorted columns: the default; see docs/search.md */
  SPH_SEARCH_BRUTE_FORCE = 1 /**< every particle against every other: the reference */
} sph_search_method;

/** Create a search over a set of particles. It is empty until sph_search_update().
 *
 * Units      radius m, 1e-100 to 1e100
 * Ownership  the caller destroys *out; it holds references to the context and the particles
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, particles or out NULL, the particles belong to another context,
 *            radius out of range; SPH_E_MEMORY; *out is NULL after an error
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_create(sph_context *context,
                                                   const sph_particles *particles, double radius,
                                                   sph_search **out);

/** Release the search and set *search to NULL. NULL is allowed.
 *
 * Ownership  the memory goes now; the particles stay as long as somebody else holds them
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_search_destroy(sph_search **search);

/** Choose how the next update builds and how queries after it look.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT search NULL or unknown method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_set_method(sph_search *search,
                                                       sph_search_method method);

/** Make space periodic along one axis, from the next update on: distances are to the nearest image.
 * Particles outside lo to hi count as the image inside.
 *
 * Units      lo < hi in m, at most 1e100 from 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT search NULL, axis not 0 to dim - 1, lo or hi not as above, the radius is
 *            more than half of hi - lo
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_set_periodic(sph_search *search, int axis, double lo,
                                                         double hi);

/** Build for the positions of now and remember the particles' revision.
 *
 * The memory depends on the number of particles, not on how far apart they are.
 *
 * Parallel   not while another call uses the context; uses the context's threads
 * Errors     SPH_E_ARGUMENT search NULL; SPH_E_DIVERGED a particle, named by id and position, is not
 *            finite or more than 1e9 radii away from the others along an axis: nothing changed, and
 *            the search can be updated again; SPH_E_MEMORY: the search is as before its first update
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_update(sph_search *search);

/** Particles at a distance below the radius from a point, nearest first, equals by index.
 *
 * *count is how many there are. It may exceed room: then the nearest `room` are written, and nothing
 * past them.
 *
 * Shape      x [dim]; index, distance [room], either NULL only if room is 0; count [1]
 * Units      x m, at most 1e100 from 0; index is a position in id order; distance m
 * Ownership  fills index, distance and count, none of them after an error; the search's workspace may
 *            grow
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT search, x or count NULL, room < 0, an array NULL though room > 0, x out of
 *            range; SPH_E_STALE the particles changed since sph_search_update(); SPH_E_MEMORY: the
 *            search still works
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_find_near_point(sph_search *search, const double *x,
                                                            int64_t room, sph_index *index,
                                                            double *distance, int64_t *count);

/** Particles at a distance below the radius from particle i, without itself, nearest first.
 *
 * Shape      i is a position in id order; the rest as sph_search_find_near_point
 * Units      as sph_search_find_near_point
 * Ownership  as sph_search_find_near_point
 * Parallel   not while another call uses the context
 * Errors     as sph_search_find_near_point; SPH_E_ARGUMENT i is not 0 to n - 1
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_find_near_particle(sph_search *search, sph_index i,
                                                               int64_t room, sph_index *index,
                                                               double *distance, int64_t *count);

/** The k particles nearest to a point, whatever the radius, nearest first, equals by index.
 *
 * Shape      x [dim]; index, distance [k], either NULL only if k is 0; found [1]
 * Units      x m, at most 1e100 from 0; index is a position in id order; distance m
 * Ownership  fills index and distance up to *found = min(k, number of particles), nothing after an
 *            error; the search's workspace may grow
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT search, x or found NULL, k < 0, an array NULL though k > 0, x out of range;
 *            SPH_E_STALE the particles changed since sph_search_update(); SPH_E_MEMORY: the search
 *            still works
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_find_nearest(sph_search *search, const double *x,
                                                         int64_t k, sph_index *index,
                                                         double *distance, int64_t *found);

/** Number of unordered pairs of particles closer than the radius.
 *
 * Shape      pairs [1]
 * Ownership  writes *pairs unless it fails, allocates nothing
 * Parallel   not while another call uses the context; uses the context's threads
 * Errors     SPH_E_ARGUMENT an argument is NULL; SPH_E_STALE the particles changed since
 *            sph_search_update()
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_search_count_pairs(sph_search *search, int64_t *pairs);

SPH_END_DECLS

#endif
