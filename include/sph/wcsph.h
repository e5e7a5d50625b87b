/** @file
 * Weakly compressible delta-SPH with fixed ghost particles (Huang et al. 2019), behind an integrator.
 */
#ifndef SPH_WCSPH_H
#define SPH_WCSPH_H

#include <sph/boundary.h>
#include <sph/integrator.h>
#include <sph/kernel.h>
#include <sph/particles.h>

SPH_BEGIN_DECLS

/** How density differences are smoothed. */
typedef enum sph_diffusion {
  SPH_DIFFUSION_NONE = 0,    /**< "none" */
  SPH_DIFFUSION_MOLTENI = 1, /**< "molteni": Molteni and Colagrossi (2009), without gradients */
  SPH_DIFFUSION_DELTA = 2 /**< "delta": with renormalised gradients, Huang et al. (2019) eq. (5) */
} sph_diffusion;

/** Pressure from density. */
typedef enum sph_equation_of_state {
  SPH_EOS_LINEAR = 1, /**< p = c0^2 (rho - rho0) */
  SPH_EOS_TAIT = 2    /**< p = (rho0 c0^2 / gamma) ((rho/rho0)^gamma - 1) */
} sph_equation_of_state;

/** Create the flow of `particles` inside `boundary` (NULL: no walls).
 *
 *     Drho_i/Dt = -rho_i sum_j (u_j - u_i) . grad_i W_ij V_j + delta h c0 sum_j psi_ij . grad_i W_ij V_j
 *     Du_i/Dt   = -(1/rho_i) sum_j (p_i + p_j) grad_i W_ij V_j + f
 *                 + (alpha h c0 + 2 (dim + 2) nu) (rho0/rho_i) sum_j pi_ij grad_i W_ij V_j
 *     psi_ij = 2 (rho_j - rho_i) x_ji / |x_ji|^2 - (<grad rho>_i + <grad rho>_j)
 *     pi_ij  = (u_j - u_i) . x_ji / |x_ji|^2,   V_j = m_j / rho_j
 *
 * Two guards act after every step. Drops and threads, particles whose moment matrix
 * sum_j V_j x_ji (x) grad_i W_ij has an eigenvalue below 0.2, are not left in tension: a density below
 * rho0 becomes rho0. Particles within a quarter of a spacing of a wall, or about to pass it, lose the
 * speed with which they run into it, and those that came less than half a spacing into one are put
 * back; sph_integrator_stats counts these contacts.
 *
 * Defaults: delta 0.1, alpha 0.02, nu 0, rho0 1000 kg/m^3, linear equation of state, gravity 9.81
 * m/s^2 along minus the last axis, rk4 steps. The sound speed has no default.
 *
 * Ownership  holds references to kernel, particles and boundary; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, dimensions that differ, no particles, handles of another context,
 *            a boundary that another integrator has, ghosts that do not fill the kernel's support;
 *            SPH_E_MEMORY
 * Source     Huang et al. (2019), eq. (5)-(6); differs: the viscous prefactor is rho0 c0 instead of
 *            rho_i c, so that pairs conserve momentum (Antuono et al. 2010); ghosts take no part in
 *            the density diffusion
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_create(sph_context *context, sph_kernel *kernel,
                                                  sph_particles *particles, sph_boundary *boundary,
                                                  sph_integrator **out);

/** Sound speed c0: at least 10 times the largest speed keeps density within 1 %. Needed before the
 * first step.
 *
 * Units      m/s, > 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, c0 not finite or <= 0, or a fixed time step in use that
 *            would be unstable; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_sound_speed(sph_integrator *integrator, double c0);

/** Reference density rho0.
 *
 * Units      kg/m^3, > 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, density not finite or <= 0; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_reference_density(sph_integrator *integrator,
                                                                 double density);

/** Equation of state; gamma is used by SPH_EOS_TAIT alone (7 for water).
 *
 * Units      gamma dimensionless, > 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, unknown equation, gamma not finite or <= 0; SPH_E_TYPE
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_equation_of_state(sph_integrator *integrator,
                                                                 sph_equation_of_state equation,
                                                                 double gamma);

/** Constant body force per mass.
 *
 * Shape      gravity [dim]
 * Units      m/s^2
 * Ownership  copied
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, not finite; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_gravity(sph_integrator *integrator,
                                                       const double *gravity);

/** Body force per mass by a function, in addition to gravity (NULL: none).
 *
 * Units      m/s^2
 * Ownership  user must live as long as the integrator
 * Parallel   the function is called from several threads at once
 * Errors     SPH_E_ARGUMENT integrator NULL; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_body_force(sph_integrator *integrator,
                                                          sph_body_force function, void *user);

/** Density diffusion and its coefficient.
 *
 * Units      delta dimensionless, 0 to 1
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, unknown kind, delta out of range, or a fixed time step or
 *            Courant number in use that would be unstable; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_diffusion(sph_integrator *integrator,
                                                         sph_diffusion kind, double delta);

/** Artificial viscosity coefficient alpha; acts like nu = alpha h c0 / (2 (dim + 2)).
 *
 * Units      dimensionless, 0 to 1
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, alpha out of range; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_artificial_viscosity(sph_integrator *integrator,
                                                                    double alpha);

/** Laminar kinematic viscosity nu, in addition to the artificial one.
 *
 * Units      m^2/s, >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, nu not finite or < 0; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_laminar_viscosity(sph_integrator *integrator,
                                                                 double nu);

/** Make one direction periodic.
 *
 * Units      lo < hi [m]
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, no such axis, lo >= hi, a support radius larger than
 *            half the box; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_periodic(sph_integrator *integrator, int axis,
                                                        double lo, double hi);

/** Box that particles may not leave. Until called: what walls and particles take up at the first
 * step, larger by that size on every side.
 *
 * Shape      lo, hi [dim]
 * Units      m
 * Ownership  copied
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, not finite, lo >= hi; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_domain(sph_integrator *integrator, const double *lo,
                                                      const double *hi);

/** Add a zone that takes waves out, so that they do not come back from the end of a tank. In every step dt
 *
 *     u_i <- u_i exp(-dt rate xi^2),   xi = (x_i[axis] - from) / (to - from), within 0 and 1
 *
 * so that all particles beyond `to` are damped at the full rate, and none before `from`; to < from is a zone
 * towards the low end. Where zones overlap their rates add up. A zone of one wavelength with a rate of about
 * 10 / wave period leaves little to come back. It also stops a current, and walls that move in it.
 *
 * Units      from, to m; rate 1/s, > 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, no such axis, from and to not finite or equal, rate not finite
 *            or <= 0, more than 16 zones; SPH_E_TYPE another method
 * Source     Larsen and Dancy (1983), Open boundaries in short wave simulations; differs: the profile xi^2,
 *            and velocities alone
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_add_damping_zone(sph_integrator *integrator, int axis,
                                                            double from, double to, double rate);

/** Largest distance beyond the support that neighbour lists reach, so that they last several steps;
 * below it the distance follows the speed of the flow.
 *
 * Units      fraction of the support radius, 0.001 to 0.5; 0.25 until called
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, out of range; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_set_skin(sph_integrator *integrator, double skin);

/** Density at which the equation of state gives a pressure: what to write into the particles (and
 * mass = density * volume) when a run starts from a known pressure.
 *
 * Shape      pressure, density [n]
 * Units      Pa, kg/m^3
 * Ownership  copies into the caller's array
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, n < 0, sound speed not set, a pressure no density gives; SPH_E_TYPE
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_density_of_pressure(const sph_integrator *integrator,
                                                               int64_t n, const double *pressure,
                                                               double *density);

/** Start from a pressure: sets density by the equation of state, and mass so that every particle
 * keeps its volume.
 *
 * Shape      pressure [n] in id order; n must be the number of particles
 * Units      Pa
 * Ownership  copied
 * Parallel   not while another call uses the context
 * Errors     as sph_wcsph_density_of_pressure
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_start_from_pressure(sph_integrator *integrator,
                                                               int64_t n, const double *pressure);

/** Energies now.
 *
 *     compressible: linear   sum_i m_i c0^2 (ln(rho/rho0) + rho0/rho - 1)
 *
 * Ownership  fills *energy
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, sound speed not set; SPH_E_TYPE another method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_get_energy(const sph_integrator *integrator,
                                                      sph_energy *energy);

/** Force of the fluid on one wall by sums over particles: what the pressure of its ghosts takes from the
 * momentum of the fluid.
 *
 *     F = sum_i sum_g V_i V_g (p_i + p_g) grad_i W_ig,   i in the fluid, g a ghost of the wall
 *
 * Over all walls these forces are what gravity gives less what the momentum gains, to rounding, without the
 * drag of no-slip walls; sph_boundary_read_force, a sum over the wall's surface, is nearer to the force on
 * parts of it and less noisy. Particles and places are those of now, the ghosts' pressures those of the
 * last evaluation; zero before the first step.
 *
 * Shape      wall: number in the order of adding to the boundary, from 0; force [dim]
 * Units      N (N/m in 2D), on the wall: positive towards the solid
 * Ownership  copies into the caller's array
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, no such wall, sound speed not set, what a first step refuses;
 *            SPH_E_TYPE another method; SPH_E_MEMORY
 * Source     Liang et al. (2017), eq. (14), with the sum over the wall's particles that it leaves out; differs:
 *            volumes in the place of m/rho, fixed ghosts
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_wcsph_read_reaction(sph_integrator *integrator, int wall,
                                                         double *force);

SPH_END_DECLS

#endif
