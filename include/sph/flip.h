/** @file
 * Hybrid particle-mesh flow of two fluids (Maljaars et al. 2017), behind an integrator: particles carry
 * velocity and density, a mesh of triangles the pressure. 2D.
 */
#ifndef SPH_FLIP_H
#define SPH_FLIP_H

#include <sph/integrator.h>
#include <sph/mesh.h>
#include <sph/particles.h>
#include <sph/solver.h>

SPH_BEGIN_DECLS

/** Where grad p / rho is made continuous before it acts on velocities. */
typedef enum sph_flip_smoothing {
  SPH_FLIP_SMOOTHING_NONE = 1,      /**< nowhere: divergence is zero to the solver's tolerance */
  SPH_FLIP_SMOOTHING_INTERFACE = 2, /**< in cells with both fluids and two layers around them */
  SPH_FLIP_SMOOTHING_GLOBAL = 3     /**< everywhere, as printed */
} sph_flip_smoothing;

/** What the last step was like, and sums since the integrator was created. */
typedef struct sph_flip_stats {
  int64_t mixed_cells;  /**< with both fluids, or densities between, in the last step */
  int64_t empty_cells;  /**< without particles, in the last step */
  int64_t fewest, most; /**< particles in a cell, in the last step */
  double divergence;    /**< largest of the nodes' weak divergences after the last step [1/s] */
  double
      divergence_left; /**< largest without the smoothing: what the solver's tolerance leaves [1/s] */
  int64_t entered, left; /**< particles through the open boundary */
  int64_t split, merged; /**< particles in cells that had few or many */
} sph_flip_stats;

/** Create the flow of `particles` in `mesh`. A step of dt, with cells K, hat functions N_a and cells' and
 * nodes' values by their indices:
 *
 *     rho_K = mean of rho_p,  u_K = mean of u_p,   p in K                                              (1)
 *     u*_K = u_K + dt (g + (1/(rho_K A_K)) int_K div sigma)                                            (2)
 *     sum_K (A_K/rho_K) grad N_a . grad p = (1/dt) (sum_K A_K grad N_a . u*_K - int N_a h ds)           (3)
 *     u_K^(n+1) = u*_K - dt (grad p)_K / rho_K, smoothed near the interface                             (4)
 *     u_p^(n+1) = (1 - alpha) (u_p + U^(n+1)(x_p) - U^n(x_p)) + alpha U^(n+1)(x_p)                      (5)
 *     dx_p/dt = U^(n+1)(x_p), Ralston's third-order Runge-Kutta                                        (6)
 *
 * h is the outward normal velocity of walls, p = 0 on the open boundary. U is continuous: the nodes' means
 * of u_K, by area in (6) and by mass in (5), with the walls' normal velocities, and u_K in the middle of
 * cells, linear on the three triangles between.
 *
 * Until set otherwise: g = (0, -9.81), alpha = dt sqrt(|g|/l) with l = sqrt(2 A_K) of the smallest cell,
 * densities 1 and 1000, no viscosity, correction of volumes 0.05, velocities weighed with masses, densities
 * that follow the level, smoothing at the interface with lumped masses, the tag "top" open if the mesh has
 * it, all else walls with free slip, cells kept at 4 to 50 particles. The particles get a field "cell"; their pressure is that of the last step.
 * The integrator moves the mesh.
 *
 * Ownership  references to all are kept; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, particles not 2D, no particles, handles of another context, a field
 *            "cell" of other than one component; SPH_E_MEMORY
 * Source     Maljaars et al. (2017), eqs. (1)-(17), with the corrections of docs/theory/flip.md; differs:
 *            lumped smoothing at the interface alone, masses as weights, densities that follow the
 *            level, correction of volumes
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_create(sph_context *context, sph_mesh *mesh,
                                                 sph_particles *particles, sph_integrator **out);

/** Fill a mesh with particles at rest: divisions^2 in each cell, in the middles of as many equal triangles,
 * each with its share of the cell's area, of the density `below` where y < surface(x), else `above`.
 *
 * Shape      divisions 1 to 16
 * Units      densities kg/m^3
 * Ownership  borrows all arguments; surface (NULL: all is `below`) is called once a particle with x [1]
 * Parallel   not while another call uses the context; surface runs on the calling thread
 * Errors     SPH_E_ARGUMENT a NULL, divisions out of range, handles of different contexts, particles not
 *            2D, densities not finite or <= 0, a level that is NaN, a lease is open, the set would be too
 *            large; SPH_E_MEMORY; the set is unchanged after an error
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_fill(const sph_mesh *mesh, sph_particles *particles,
                                               int divisions, sph_surface_function surface,
                                               void *user, double below, double above);

/** Constant body force per mass; (0, -9.81) until called.
 *
 * Shape      gravity [2]
 * Units      m/s^2
 * Ownership  copied
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, not finite; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_gravity(sph_integrator *integrator,
                                                      const double *gravity);

/** Densities of the two fluids; 1 and 1000 until called. Particles keep theirs: what enters through the open
 * boundary is of the light one, the surface is where the mean of the two is, and viscosities go with them.
 *
 * Units      kg/m^3, 0 < light <= heavy
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, not as above; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_densities(sph_integrator *integrator, double light,
                                                        double heavy);

/** Dynamic viscosities of the two fluids; 0 until called. In between they go with the density.
 *
 *     div sigma, sigma = mu (grad u + grad u^T), with sigma at nodes; dt <= rho l^2/(8 mu)             (1)
 *
 * Units      Pa s, >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, not finite or < 0; SPH_E_TYPE another method
 * Source     Maljaars et al. (2017), eqs. (11)-(12); differs: lumped masses
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_viscosities(sph_integrator *integrator, double light,
                                                          double heavy);

/** Let the fluid stick to walls, which takes a viscosity to be felt; false until called.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_no_slip(sph_integrator *integrator, bool no_slip);

/** Share of the mesh's velocity in a particle's new one, (5) of sph_flip_create. It damps like a viscosity of
 * about 0.15 alpha l^2/dt. Until called, and with a number < 0, it is dt sqrt(|g|/l), so that this does not
 * depend on the step; 0.02 without gravity.
 *
 * Units      dimensionless, 0 (FLIP) to 1 (PIC)
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, NaN or > 1; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_pic_share(sph_integrator *integrator, double alpha);

/** Share of a surplus or lack of particles' volume around a node that goes in a time sqrt(l/|g|), by a
 * divergence that (3) of sph_flip_create asks for; 0.05 until called, 0: none, as printed.
 *
 * Units      dimensionless, 0 to 1
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Source     own: smoothing leaves divergences, with which particles gather
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_volume_correction(sph_integrator *integrator,
                                                                double theta);

/** Choose where and how grad p / rho is projected onto continuous functions: with lumped masses, the default,
 * or with the consistent mass matrix, as printed.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, unknown value; SPH_E_TYPE another method
 * Source     Maljaars et al. (2017), eqs. (16)-(17); differs: see docs/theory/flip.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_smoothing(sph_integrator *integrator,
                                                        sph_flip_smoothing where, bool lumped);

/** Weigh velocities with masses in (1) of sph_flip_create, and those of nodes, which keeps the momentum of
 * cells with both fluids; true until called, false as printed.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_mass_weighted(sph_integrator *integrator,
                                                            bool weighted);

/** Let densities near the interface follow the level continuously: particles that are near a side count on both
 * sides, and the two cells of a square have one density, (11) and (12) of docs/theory/flip.md; true until
 * called, false as printed: means over the particles that are inside.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_spread_density(sph_integrator *integrator,
                                                             bool spread);

/** Choose the part of the boundary that is open, with p = 0, by its tag's name; NULL: none. Then the
 * pressure is known up to a constant, and the one with zero mean is taken.
 *
 * Ownership  borrows tag
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL; SPH_E_NAME no such tag; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_open(sph_integrator *integrator, const char *tag);

/** Let the left end be a paddle, see sph_mesh_set_paddle(); the mesh moves to the present time.
 *
 * Units      reach m
 * Ownership  borrows motion (NULL: none) and user until replaced
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT as sph_mesh_set_paddle and sph_mesh_move; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_paddle(sph_integrator *integrator,
                                                     sph_wall_motion motion, void *user,
                                                     double reach);

/** Keep cells at `fewest` to `most` particles; 4 and 50 until called, 0 for no such bound.
 *
 * Cells at the open boundary get particles of the light fluid. Elsewhere, in cells of one fluid, the largest
 * particle is split, or the two nearest ones are merged: mass, volume and momentum stay.
 *
 * Units      particles, fewest 0 to 100, most 0 or at least 2 fewest
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_set_reseeding(sph_integrator *integrator, int fewest,
                                                        int most);

/** The solver of the pressure equation, for settings and numbers: GMRES to 1e-8 from the last pressure. What a
 * step does that is not solved within its limit is as for sph_isph_get_solver().
 *
 * Ownership  *solver belongs to the integrator: not to be destroyed
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_get_solver(const sph_integrator *integrator,
                                                     sph_solver **solver);

/** Copy out the nodes' pressures of the last step, 0 before the first.
 *
 * Shape      pressure [nodes]; size = nodes
 * Units      Pa
 * Ownership  fills pressure
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, wrong size; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_read_pressure(const sph_integrator *integrator,
                                                        double *pressure, int64_t size);

/** Copy out the cells' densities and velocities that the last step made.
 *
 * Shape      density [cells], velocity [cells, 2]; size = cells
 * Units      kg/m^3, m/s
 * Ownership  fills density and velocity, either of which may be NULL
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT integrator NULL, wrong size; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_read_cells(const sph_integrator *integrator,
                                                     double *density, double *velocity,
                                                     int64_t size);

/** Pressure and velocity of the last step at points.
 *
 * Shape      x [count, 2]; pressure [count]; velocity [count, 2]
 * Units      m; Pa; m/s
 * Ownership  fills pressure and velocity, either of which may be NULL
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator or x NULL, count < 0, a point not finite or outside the mesh (it is
 *            named; some may have been filled in); SPH_E_TYPE another method; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_evaluate(const sph_integrator *integrator, int64_t count,
                                                   const double *x, double *pressure,
                                                   double *velocity);

/** Level that the heavy fluid above x would have without the light one in between, by the cells' densities:
 * the lowest point of the mesh there and the heights of cells, each times its share of heavy fluid.
 *
 * Units      x, *level m
 * Ownership  fills *level
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, no cell at x; SPH_E_TYPE another method; what a first step refuses
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_find_level(sph_integrator *integrator, double x,
                                                     double *level);

/** Counters of the last step and of all.
 *
 * Ownership  fills *stats
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_get_stats(const sph_integrator *integrator,
                                                    sph_flip_stats *stats);

/** Energies of the particles now; `compressible` is 0.
 *
 * Ownership  fills *energy
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_flip_get_energy(const sph_integrator *integrator,
                                                     sph_energy *energy);

SPH_END_DECLS

#endif
