/** @file
 * Stepping a flow in time, whatever the method behind it.
 */
#ifndef SPH_INTEGRATOR_H
#define SPH_INTEGRATOR_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Body force per mass at a place and time: writes force [dim] in m/s^2. Called from several threads. */
typedef void (*sph_body_force)(double t, const double *x, double *force, void *user);

/** Energies of the fluid.
 * potential = - sum_i m_i g . x_i for the constant gravity alone; compressible = work stored by the
 * equation of state from rho0. */
typedef struct sph_energy {
  double kinetic, potential, compressible, total; /**< J (J/m in 2D) */
} sph_energy;

/** Time stepping schemes. */
typedef enum sph_stepper {
  SPH_STEPPER_SYMPLECTIC =
      1,                  /**< "symplectic": symplectic Euler, one evaluation a step, first order */
  SPH_STEPPER_VERLET = 2, /**< "verlet": kick-drift-kick, one evaluation a step, second order */
  SPH_STEPPER_RK4 = 3     /**< "rk4": Runge-Kutta with frozen diffusion, four evaluations a step */
} sph_stepper;

/** What limited the last time step. */
typedef enum sph_limiter {
  SPH_LIMITER_FIXED = 0,        /**< the caller's step */
  SPH_LIMITER_SOUND = 1,        /**< h / c0 */
  SPH_LIMITER_ACCELERATION = 2, /**< sqrt(h / |a|) */
  SPH_LIMITER_VISCOSITY = 3,    /**< h^2 / nu */
  SPH_LIMITER_END = 4,          /**< the time that sph_integrator_advance goes to */
  SPH_LIMITER_VELOCITY = 5      /**< h / |u| */
} sph_limiter;

/** Where the time goes, and what the last step was like. Sums since the integrator was created. */
typedef struct sph_integrator_stats {
  int64_t steps;
  double time;          /**< s */
  double dt;            /**< last step [s] */
  sph_limiter limiter;  /**< of the last step */
  int64_t evaluations;  /**< force evaluations */
  int64_t builds;       /**< neighbour lists built */
  int64_t list_entries; /**< of the fluid's lists now: candidates, a cluster of targets each */
  int64_t pairs;    /**< of particles with neighbours or ghosts that sums have gone through, also
                              those that the lists hold beyond the support */
  int64_t contacts; /**< times a particle that touched a wall was stopped from entering it */
  double max_speed; /**< m/s, at the end of the last step */
  double max_acceleration;  /**< m/s^2 */
  double seconds_sort;      /**< particles sorted: columns, storage order, clusters */
  double seconds_search;    /**< lists; walls that move are sorted for theirs */
  double seconds_pack;      /**< equation of state and records */
  double seconds_boundary;  /**< ghosts: interpolation and assignment */
  double seconds_pairs;     /**< sums over pairs; pairs / seconds_pairs is their rate */
  double seconds_solver;    /**< pressure equation: rows and solution */
  double seconds_update;    /**< new positions, velocities, densities; checks */
  double seconds_observers; /**< probes that sample every step; lists they ask for count above */
} sph_integrator_stats;

/** Release the caller's reference and set *integrator to NULL. NULL is allowed.
 *
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_integrator_destroy(sph_integrator **integrator);

/** Choose the time stepping scheme; SPH_STEPPER_RK4 until called.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL or unknown scheme, or the fixed step in use is beyond
 *            its stability limit; SPH_E_TYPE a method with a scheme of its own
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_set_stepper(sph_integrator *integrator,
                                                            sph_stepper stepper);

/** The time stepping scheme called `name`.
 *
 * Ownership  fills *stepper
 * Parallel   thread-safe per context
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_NAME unknown, with the nearest name suggested
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_stepper_find(sph_context *context, const char *name,
                                                  sph_stepper *stepper);

/** Step with a fixed time step instead of one that follows the stability limits (0: follow again).
 *
 * Units      dt >= 0 [s]
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, dt not finite or < 0, or beyond the largest stable step
 *            of the scheme for sound waves, see sph_integrator_stable_dt
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_set_dt(sph_integrator *integrator, double dt);

/** Courant number of steps that follow the limits; the scheme's own until called (0: its own again).
 *
 *     dt = min(courant h / c0, 0.25 sqrt(h / max |a|), 0.125 h^2 / nu)
 *
 * Defaults: 0.4 (symplectic, verlet) or 0.65 (rk4) of the lattice limit of the kernel, see
 * sph_integrator_stable_dt: with density diffusion 0.49, 0.49 and 2.0 for the Gaussian kernel.
 *
 * Of incompressible flow, which has no sound, it is the share of h that the fastest particle goes in a step,
 * 0.25 until called and 0.5 at most: dt = min(courant h / max |u|, 0.07 sqrt(h / |g|), 0.125 h^2 / nu).
 *
 * Units      dimensionless
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator NULL, courant not finite, < 0 or beyond stability
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_set_courant(sph_integrator *integrator,
                                                            double courant);

/** Largest time step that is stable for sound waves on a regular lattice with the chosen scheme and
 * kernel; disordered particles need about 0.7 of it. 0 if integrator is NULL.
 *
 * Units      s
 * Parallel   thread-safe for reading
 * Errors     none
 * Source     von Neumann analysis of the linearised scheme, docs/theory/time_stepping.md
 * Since      0.1
 */
SPH_API double sph_integrator_stable_dt(const sph_integrator *integrator);

/** Do one time step.
 *
 * A value that is not finite, a density that is not positive, a particle that moved more than its
 * spacing in the step, crossed a wall or left the domain stops the run: the error names particle,
 * position, time and quantity, and the particles stay readable as they are.
 *
 * Parallel   not while another call uses the context; threads inside as the context says
 * Errors     SPH_E_ARGUMENT integrator NULL, or the particles or walls do not fit together (first
 *            step, or after the caller changed the particles); SPH_E_DIVERGED; SPH_E_NOT_CONVERGED
 *            the pressure equation of incompressible flow, see sph_isph_get_solver(); SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_step(sph_integrator *integrator);

/** Step until time t is reached; the last step is shortened to end there.
 *
 * Units      t [s], not before the present time
 * Parallel   as sph_integrator_step
 * Errors     as sph_integrator_step; SPH_E_ARGUMENT t not finite or in the past
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_advance(sph_integrator *integrator, double t);

/** Present time; 0 if integrator is NULL.
 *
 * Units      s
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_integrator_time(const sph_integrator *integrator);

/** Steps done; 0 if integrator is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_integrator_steps(const sph_integrator *integrator);

/** Counters and times.
 *
 * Ownership  fills *stats
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_get_stats(const sph_integrator *integrator,
                                                          sph_integrator_stats *stats);

/** The particles that the integrator moves.
 *
 * Ownership  a reference owned by the integrator: not to be destroyed; NULL if integrator is NULL
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API sph_particles *sph_integrator_particles(const sph_integrator *integrator);

/** Write all that a run needs to go on, whatever its method: particles with all their fields, time, steps and what
 * steers them, walls and bodies where they are, and the method's own state.
 *
 * A run that reads the file goes on with the same bits as the one that wrote it, on the same kind of processor with
 * the same precision, for any number of threads. As lists are made at times that depend on what was before, both make
 * them anew at their next step: writing changes the last digits of the run that writes. What is pending is done first,
 * as by sph_integrator_step: a flow that has not stepped, or whose particles the caller has changed, is prepared.
 * A file that fails is removed, and what was under the name before stays.
 *
 * Format     docs/checkpoint.md
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator or path NULL, path empty; SPH_E_IO; SPH_E_DIVERGED a number is not finite;
 *            errors of sph_integrator_step before it steps; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_write_checkpoint(sph_integrator *integrator,
                                                                 const char *path);

/** Take a run over from a file, on handles that were made with the settings of those that wrote it: method, kernel,
 * spacing, names of fields, walls with their motions and bodies, periodic box, mesh. Number and order of particles come
 * from the file; the flow may have stepped before, so that it goes back or on.
 *
 * Settings of the method, steppers and time steps are not in the file: those of the flow hold. Not taken over are
 * series of probes, which go on from the new time, outputs, leases, and what a caller's own functions remember.
 * Everything is checked before anything changes: after an error the flow is as it was.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT integrator or path NULL, path empty, leases are open, or the file is of another flow: the
 *            message names section and value; SPH_E_IO the file cannot be read, is damaged, of another version or
 *            byte order; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_integrator_read_checkpoint(sph_integrator *integrator,
                                                                const char *path);

SPH_END_DECLS

#endif
