/** @file
 * Fixed ghost particles: walls that push, drag and reflect the fluid by the values interpolated at
 * mirror points.
 */
#ifndef SPH_BOUNDARY_H
#define SPH_BOUNDARY_H

#include <sph/interpolator.h>
#include <sph/wall.h>

SPH_BEGIN_DECLS

enum {
  SPH_BOUNDARY_TYPES = 32 /**< room in sph_boundary_counts.by_type */
};

/** How the ghosts got their values at the last evaluation. */
typedef struct sph_boundary_counts {
  int64_t ghosts;   /**< all of them */
  int64_t active;   /**< those that act on the fluid: sum of by_type */
  int64_t inactive; /**< no fluid near the mirror point or the ghost: the ghost takes no part */
  int64_t
      thin; /**< of the active: kernel sum below the threshold, zero pressure and the wall's velocity */
  /** of the active: by the kind that gave their values, indexed by sph_interpolator_type; [0] the
   * inactive */
  int64_t by_type[SPH_BOUNDARY_TYPES];
  int64_t fallback; /**< of the active: another kind than the one that was chosen */
  int64_t skipped;  /**< places without a ghost: their mirror point lies outside the fluid's side */
} sph_boundary_counts;

/** What sph_boundary_read gives of every ghost. */
typedef enum sph_ghost_value {
  SPH_GHOST_POSITION = 0, /**< [n, dim] m */
  SPH_GHOST_MIRROR = 1,   /**< [n, dim] m */
  SPH_GHOST_FOOT = 2,     /**< [n, dim] m: nearest point of its side of the wall */
  SPH_GHOST_NORMAL = 3,   /**< [n, dim] unit vector into the fluid */
  SPH_GHOST_VELOCITY = 4, /**< [n, dim] m/s, at the last evaluation */
  SPH_GHOST_PRESSURE = 5, /**< [n] Pa, at the last evaluation */
  SPH_GHOST_VOLUME = 6,   /**< [n] m^dim; zero while the ghost is inactive */
  SPH_GHOST_RUNG = 7 /**< [n] sph_interpolator_type that gave the values at the last evaluation, 0
                               for none */
} sph_ghost_value;

/** Create the ghosts behind a wall.
 *
 * Layers at spacing/2, 3 spacing/2, ... fill the support radius of the interpolator's kernel. The
 * mirror point of a ghost x is 2 x_w - x with x_w the nearest point of the wall's side. With values I[.]
 * interpolated at the mirror point x_m from the fluid alone, the wall's velocity u_w and acceleration a_w at
 * x_w, and the body force f:
 *
 *     u = I[u] - 2 ((I[u] - u_w) . n) n          free slip                                 (1)
 *     u = 2 u_w - I[u]                           no slip, and behind edges and corners      (2)
 *     p = I[p] + rho0 (f - a_w) . (x - x_m)      dp/dn = rho (f - a_w) . n at the wall      (3)
 *
 * Units      spacing > 0 [m], that of the fluid
 * Ownership  holds references to wall and interpolator; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, spacing not finite or <= 0, dimensions that differ, an
 *            interpolator of another context;
 *            SPH_E_UNSUPPORTED a corner that has no mirror rule; SPH_E_MEMORY
 * Source     Huang et al. (2019), section 2.2; Marrone et al. (2011); differs: (3) has the wall's
 *            acceleration and the vector from mirror to ghost, where the paper prints d and 2 d
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_boundary_create(sph_context *context, sph_wall *wall,
                                                     double spacing, sph_interpolator *interpolator,
                                                     sph_boundary **out);

/** Release the caller's reference and set *boundary to NULL. NULL is allowed.
 *
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_boundary_destroy(sph_boundary **boundary);

/** Add the ghosts of another wall, before an integrator uses the boundary.
 *
 * Walls may reach past each other, and move so, as a piston does over a bed: let each go on behind the
 * other by more than the kernel's support. A place behind several walls belongs to the one whose nearest
 * point is in the fluid, and in the wedge of a corner to a moving wall before one at rest and to a later
 * one before an earlier one; ghosts there are mirrored by both. Pieces of wall behind another wall carry no
 * force. Corners that are not square and do not move are better given as one wall.
 *
 * Ownership  holds a reference to wall
 * Parallel   not while another call uses the context
 * Errors     as sph_boundary_create; SPH_E_ARGUMENT an integrator uses the boundary already
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_boundary_add_wall(sph_boundary *boundary, sph_wall *wall);

/** Forbid suction: pressures of ghosts below zero become zero, so that the fluid comes off walls as
 * it does where air gets in (on until called with false). Without it thin jets cling to walls.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT boundary is NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_boundary_set_no_suction(sph_boundary *boundary, bool on);

/** Kernel sum at the mirror point below which a ghost gets zero pressure and the wall's velocity.
 *
 * Units      0 <= threshold < 0.5; 0.05 until called
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT boundary NULL, threshold not finite or out of range
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_boundary_set_thin_threshold(sph_boundary *boundary,
                                                                 double threshold);

/** Number of ghosts; 0 if boundary is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_boundary_count(const sph_boundary *boundary);

/** How the ghosts got their values at the last evaluation.
 *
 * Ownership  fills *counts
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_boundary_get_counts(const sph_boundary *boundary,
                                                         sph_boundary_counts *counts);

/** Read one value of every ghost.
 *
 * Shape      values [count] or [count, dim] as sph_ghost_value says; size = number of doubles
 * Units      SI, see sph_ghost_value
 * Ownership  copies into the caller's array
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, unknown value, size not that of the value
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_boundary_read(const sph_boundary *boundary,
                                                   sph_ghost_value what, double *values,
                                                   int64_t size);

/** Force of the fluid on one wall at the last evaluation: integral of the wall pressure.
 *
 *     F = sum_k p_k A_k n_k,   p_k = I[p] + rho0 (f - a_w) . (x_w - x_m)
 *
 * Shape      wall: number in the order of adding, from 0; force [dim]
 * Units      N (N/m in 2D), on the wall: positive towards the solid
 * Ownership  copies into the caller's array
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, no such wall
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_boundary_read_force(const sph_boundary *boundary, int wall,
                                                         double *force);

SPH_END_DECLS

#endif
