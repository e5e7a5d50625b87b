/** @file
 * Incompressible SPH by projection (Lee et al. 2008, Liang et al. 2017), behind an integrator.
 */
#ifndef SPH_ISPH_H
#define SPH_ISPH_H

#include <sph/boundary.h>
#include <sph/integrator.h>
#include <sph/kernel.h>
#include <sph/particles.h>
#include <sph/solver.h>

SPH_BEGIN_DECLS

/** Pressure gradients. */
typedef enum sph_isph_gradient {
  SPH_ISPH_GRADIENT_CORRECTED =
      1, /**< "corrected": differences and renormalised gradients, exact for linear pressures */
  SPH_ISPH_GRADIENT_CONSERVATIVE =
      2 /**< "conservative": sums of pressures, Liang et al. (2017) eq. (2), keeps momentum */
} sph_isph_gradient;

/** Laplacians of the pressure. */
typedef enum sph_isph_laplacian {
  SPH_ISPH_LAPLACIAN_CORRECTED = 1, /**< "corrected": Schwaiger (2008), for one-sided support */
  SPH_ISPH_LAPLACIAN_SIMPLE = 2     /**< "simple": Morris et al. (1997) */
} sph_isph_laplacian;

/** Pressures in walls. */
typedef enum sph_isph_walls {
  SPH_ISPH_WALLS_GHOSTS = 1,  /**< "ghosts": fixed ghosts, interpolated at mirror points */
  SPH_ISPH_WALLS_DUMMIES = 2, /**< "dummies": wall particles solved for, dummies behind that follow
                                   with the slope of rho (g - a_w) */
  SPH_ISPH_WALLS_DUMMIES_AS_PRINTED =
      3 /**< "dummies-as-printed": dummies with the pressure of the wall particle, velocities of the wall */
} sph_isph_walls;

/** Create the flow of `particles` inside `boundary` (NULL: no walls).
 *
 * A step of dt, with W, V and ghosts at r* = r^n + dt u^n:
 *
 *     u*_i = u_i^n + dt (nu lap u_i + g)
 *     sum_j a_ij (p_j - p_i) - o_i c_i p_i = (rho0/dt) (tr(T_i L_i) + theta (1 - C_i/C0) |u_i|/h)
 *     a_ij = -2 s_i V_j (dW/dr)/r (1 + (1 - o_i) x_ij . L_i N_i),   s_i = tr(L_i)/dim
 *     u_i^(n+1) = u*_i - dt (grad p)_i / rho0 + (collisions)
 *     r_i^(n+1) = r_i^n + dt/2 (u_i^n + u_i^(n+1)) + (shift)
 *
 * L_i is the inverse of M_i = sum_j V_j x_ji (x) grad W; N_i = sum_j V_j grad W; C_i = sum_j V_j W;
 * T_i = sum_j V_j (u*_j - u*_i) (x) grad W. o_i is the share of i that is at the free surface, half a spacing
 * above it, and c_i = 4 s_i |N_i|/dx. Ghosts have the pressure of their mirror point and of the force and
 * acceleration of the wall. Until set otherwise: rho0 = 1000, g = (0, -9.81) or (0, 0, -9.81), nu = 0, corrected
 * gradient and Laplacian, theta = 0.02, shifting 0.5, collisions 1. The first step, or the first probe, makes
 * the pressure of the state at the start.
 *
 * Ownership  references to all are kept; a boundary belongs to one integrator at a time. The particles get
 *            a field "acceleration"; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, dimensions that differ, no particles, handles of another context, ghosts
 *            less deep than the kernel's support, a boundary in use; SPH_E_MEMORY
 * Source     Lee et al. (2008); Liang et al. (2017), eqs. (2)-(13), with the corrections of docs/theory/isph.md;
 *            differs: r* of the old velocity, fixed ghosts
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_create(sph_context *context, sph_kernel *kernel,
                                                 sph_particles *particles, sph_boundary *boundary,
                                                 sph_integrator **out);

/** Density of the fluid; 1000 until called. Particles keep their volumes, and get the masses of these.
 *
 * Units      kg/m^3, > 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, density not finite or <= 0; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_reference_density(sph_integrator *integrator,
                                                                double density);

/** Constant body force per mass; (0, -9.81) or (0, 0, -9.81) until called.
 *
 * Shape      gravity [dim]
 * Units      m/s^2
 * Ownership  copied
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, not finite; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_gravity(sph_integrator *integrator,
                                                      const double *gravity);

/** Body force per mass of place and time, in addition to gravity; NULL: none.
 *
 * Ownership  borrows function and user until replaced
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_body_force(sph_integrator *integrator,
                                                         sph_body_force function, void *user);

/** Laminar kinematic viscosity nu; 0 until called.
 *
 * Units      m^2/s, >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, nu not finite or < 0; SPH_E_TYPE another method
 * Source     Morris et al. (1997); Liang et al. (2017), eq. (3)
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_laminar_viscosity(sph_integrator *integrator,
                                                                double nu);

/** Choose the pressure gradient.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, unknown kind; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_gradient(sph_integrator *integrator,
                                                       sph_isph_gradient kind);

/** Choose the Laplacian of the pressure.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, unknown kind; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_laplacian(sph_integrator *integrator,
                                                        sph_isph_laplacian kind);

/** Choose where the pressures of ghosts come from; SPH_ISPH_WALLS_GHOSTS until called.
 *
 * With dummies the layer of ghosts next to a wall's surface, one for each place of the spacing, are wall
 * particles: unknowns of the pressure equation. The ghosts behind have the pressure of the nearest wall
 * particle of their wall.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, unknown kind; SPH_E_TYPE another method
 * Source     Liang et al. (2017), section 2; Koshizuka, Nobe & Oka (1998); differs: wall particles are half a
 *            spacing behind the surface, and without fluid at their mirror point have no volume;
 *            SPH_ISPH_WALLS_DUMMIES has gravity and the wall's acceleration in velocities and pressures
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_walls(sph_integrator *integrator,
                                                    sph_isph_walls kind);

/** Particles whose divergence of positions, dim in the bulk, is below this are open to the air, unless one
 * within about 2 spacings and 45 degrees of the outward normal covers them; 1.75 in 2D and 2.7 in 3D until
 * called, 0 for a fluid without surface. They get there by degrees, over a tenth of dim.
 *
 * Units      dimensionless, 0 to below dim
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Source     Lee et al. (2008); Liang et al. (2017), eq. (13), with the sign set right; Marrone et al. (2010),
 *            doi:10.1016/j.jcp.2010.01.019, for what covers; differs: a plain cone
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_surface_threshold(sph_integrator *integrator,
                                                                double threshold);

/** Share of a particle's lack or surplus of filling that goes while it moves by h; 0.02 until called, 0:
 * none. Near the surface only a surplus counts.
 *
 * Units      dimensionless, 0 to 1
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Source     Asai et al. (2012), doi:10.1155/2012/139583; differs: filling instead of density, at a rate of
 *            |u|/h instead of 1/dt, with which pressures would grow as steps get shorter
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_density_correction(sph_integrator *integrator,
                                                                 double theta);

/** Shift particles by -factor h^2 grad C in a step, 0.1 spacings at most, near the surface only along it and
 * never towards a wall; 0.5 until called, 0: not at all.
 *
 * Units      dimensionless, 0 to 0.5
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Source     Lind et al. (2012), doi:10.1016/j.jcp.2011.10.027; differs: velocities are not interpolated anew
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_shifting(sph_integrator *integrator, double factor);

/** Particles closer than a spacing lose this share, growing from 0 at a spacing to all of it at none, of the
 * speed at which they approach; 1 until called, 0: none. Momentum is kept; at the surface, where nothing
 * else holds particles apart, it is what calms them.
 *
 * Units      dimensionless, 0 to 1
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Source     Koshizuka, Nobe & Oka (1998), doi:10.1002/(SICI)1097-0363(19980415)26:7<751::AID-FLD671>3.0.CO;2-C;
 *            differs: a share that grows with nearness
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_collisions(sph_integrator *integrator, double share);

/** Make one direction periodic.
 *
 * Units      lo < hi [m]
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, no such axis, lo >= hi, a support radius larger than half the
 *            box; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_periodic(sph_integrator *integrator, int axis,
                                                       double lo, double hi);

/** Box that particles may not leave, see sph_wcsph_set_domain().
 *
 * Shape      lo, hi [dim]
 * Units      m
 * Ownership  copied
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, not finite, lo >= hi; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_domain(sph_integrator *integrator, const double *lo,
                                                     const double *hi);

/** Add a zone that takes waves out, see sph_wcsph_add_damping_zone().
 *
 * Units      from, to m; rate 1/s, > 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, no such axis, from and to not finite or equal, rate not finite
 *            or <= 0, more than 16 zones; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_add_damping_zone(sph_integrator *integrator, int axis,
                                                           double from, double to, double rate);

/** Largest distance beyond the support that neighbour lists reach, see sph_wcsph_set_skin().
 *
 * Units      fraction of the support radius, 0.001 to 0.5; 0.25 until called
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_skin(sph_integrator *integrator, double skin);

/** The kind of solver for the pressure equation; SPH_SOLVER_GMRES until called. It has the settings of a new
 * integrator's, and pointers from sph_isph_get_solver() are no longer valid.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, unknown kind; SPH_E_UNAVAILABLE SPH_SOLVER_PETSC in a library built
 *            without; SPH_E_MEMORY; SPH_E_TYPE another method; then the solver is the one before
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_set_solver(sph_integrator *integrator,
                                                     sph_solver_kind kind);

/** The solver of the pressure equation, for settings and numbers: to 1e-6 from the last pressure, with a
 * preconditioner kept for 3 solves while particles keep their numbers.
 *
 * A step whose equation is not solved within the solver's limit is SPH_E_NOT_CONVERGED: particles and time
 * are as before the step, with the best pressure that was found; set another limit or tolerance and
 * step again.
 *
 * Ownership  *solver belongs to the integrator: not to be destroyed
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_get_solver(const sph_integrator *integrator,
                                                     sph_solver **solver);

/** Particles on the free surface at the last solution; 0: the system was singular, and pressures have zero
 * mean.
 *
 * Ownership  fills *count
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_count_surface(const sph_integrator *integrator,
                                                        int64_t *count);

/** Energies now; `compressible` is 0.
 *
 * Ownership  fills *energy
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_get_energy(const sph_integrator *integrator,
                                                     sph_energy *energy);

/** Force of the fluid on one wall by sums over particles, see sph_wcsph_read_reaction().
 *
 * Shape      wall: number in the order of adding to the boundary, from 0; force [dim]
 * Units      N (N/m in 2D), on the wall: positive towards the solid
 * Ownership  copies into the caller's array
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, no such wall, what a first step refuses; SPH_E_TYPE another method;
 *            SPH_E_MEMORY
 * Source     Liang et al. (2017), eq. (14), with the sum over the wall's particles that it leaves out
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_isph_read_reaction(sph_integrator *integrator, int wall,
                                                        double *force);

SPH_END_DECLS

#endif
