/** @file
 * Probes: time series of pressures, velocities, forces, the front, the surface, energies, or the
 * caller's own measure, recorded while a flow is stepped.
 *
 * A probe samples after every step of the integrator it was created on, or at a chosen interval, and
 * whenever sph_probe_sample is called. Sampling changes no result of the flow. Points and lines stay
 * where they were put, also when a wall moves, until sph_probe_follow ties them to it.
 */
#ifndef SPH_PROBE_H
#define SPH_PROBE_H

#include <sph/interpolator.h>
#include <sph/types.h>

SPH_BEGIN_DECLS

/** A measure of the caller's: writes one value a column for the flow as it is now. It may read
 * anything and change nothing. */
typedef void (*sph_probe_function)(const sph_integrator *flow, double *values, void *user);

/** Record the pressure at a point of the fluid or of a wall. Column p.
 *
 *     p = I[p] - rho0 f . sum_j phi_j (x_j - x),   0 where sum_j W_j V_j < 0.05                  (1)
 *
 * I is the normalized kernel mean of the fluid's particles with the flow's kernel and f the body
 * force: the second term of (1) accounts for the hydrostatic gradient, and at a wall at rest the
 * gradient along the normal is no other. sph_probe_set_interpolator chooses another I. Particles on a mesh
 * (sph/flip.h) have the mesh's pressure, 0 outside of it.
 *
 * Shape      x [dim]
 * Units      x m; p Pa
 * Ownership  copies x; the probe holds a reference to flow; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, x not finite, more than a support radius inside a wall or outside
 *            the domain (until sph_wcsph_set_domain: the box of walls and particles, larger by its
 *            size on every side), or the integrator has 256 probes; SPH_E_MEMORY
 * Source     Huang et al. (2019), eq. (8)-(9); differs: see docs/interpolator.md
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_pressure(sph_integrator *flow, const double *x,
                                                           sph_probe **out);

/** Record the mean pressure over the segment from a to b, for a gauge of finite size. Column p.
 *
 *     p = sum_k p(a + (k + 1/2)/n (b - a)) / n,   k = 0 ... n - 1
 *
 * Shape      a, b [dim]; points n >= 1
 * Units      a, b m; p Pa
 * Ownership  as sph_probe_create_pressure
 * Parallel   not while another call uses the context
 * Errors     as sph_probe_create_pressure, of every point; SPH_E_ARGUMENT points not 1 to 100000
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_pressure_average(sph_integrator *flow,
                                                                   const double *a, const double *b,
                                                                   int points, sph_probe **out);

/** Record the mean pressure over a circular plate that a 2D flow sees as a line. Column p.
 *
 *     p = int p(s) 2 sqrt(R^2 - s^2) ds / (pi R^2),   R = diameter/2
 *       = 2/(n + 1) sum_k sin^2(t_k) p(centre + R cos(t_k) along),   t_k = k pi/(n + 1), k = 1 ... n
 *
 * exact for pressures that are polynomials of s up to degree 2 n - 1.
 *
 * Shape      centre, along [2]; along a unit vector on the wall; points n >= 1
 * Units      centre, diameter m; p Pa
 * Ownership  as sph_probe_create_pressure
 * Parallel   not while another call uses the context
 * Errors     as sph_probe_create_pressure, of every point; SPH_E_ARGUMENT points not 1 to 100000, along
 *            not a unit vector to 1e-6, diameter not finite or <= 0; SPH_E_UNSUPPORTED a 3D flow
 * Source     Gauss-Chebyshev quadrature of the second kind, Abramowitz and Stegun 25.4.40;
 *            differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_pressure_disc(sph_integrator *flow,
                                                                const double *centre,
                                                                const double *along,
                                                                double diameter, int points,
                                                                sph_probe **out);

/** Record the velocity at a point, interpolated as by sph_probe_create_pressure; zero without fluid.
 * Columns v_x, v_y and in 3D v_z.
 *
 * Shape      x [dim]
 * Units      x m; velocity m/s
 * Ownership  as sph_probe_create_pressure
 * Parallel   not while another call uses the context
 * Errors     as sph_probe_create_pressure
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_velocity(sph_integrator *flow, const double *x,
                                                           sph_probe **out);

/** Choose how a probe of pressure or velocity interpolates: normalized (pressure, until called),
 * linear moving least squares (velocity, until called; exact for any linear field, but at a wall an
 * extrapolation in which single particles count more) or improved Shepard.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT probe NULL or unknown interpolator; SPH_E_TYPE a probe that does not
 *            interpolate, or particles on a mesh; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_set_interpolator(sph_probe *probe,
                                                            sph_interpolator_type type);

/** Tie the points of a probe of pressure, velocity or elevation to a wall, which takes them along:
 *
 *     x(t) = c + d(t) + R(t) (X - c),   a(t) the wall's acceleration there
 *
 * X are the points as they were given, which belong to the wall where it was created, c its pivot, d its
 * displacement and R its rotation; a line's direction turns along. Pressures of points take f - a in the
 * place of f, velocities are those in space. A second call ties them to another wall.
 *
 * Units      wall: number in the order of adding to boundary, from 0
 * Ownership  the probe holds a reference to boundary
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, boundary is not that of the flow, no such wall; SPH_E_TYPE a probe
 *            without points; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_follow(sph_probe *probe, sph_boundary *boundary,
                                                  int wall);

/** Record the force of the fluid on a wall, sph_boundary_read_force: of the last evaluation in the
 * step, zero before the first step. Columns f_x, f_y and in 3D f_z.
 *
 * Units      N (N/m in 2D), positive towards the solid along its normal
 * Ownership  holds references to flow and boundary; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, boundary is not that of the flow, no such wall, 256 probes;
 *            SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_force(sph_integrator *flow,
                                                        sph_boundary *boundary, int wall,
                                                        sph_probe **out);

/** Record the force of the fluid on a wall by sums over particles, sph_wcsph_read_reaction. Columns f_x, f_y
 * and in 3D f_z.
 *
 * Units      N (N/m in 2D), positive towards the solid
 * Ownership  as sph_probe_create_force
 * Parallel   not while another call uses the context
 * Errors     as sph_probe_create_force; SPH_E_TYPE a method without it
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_reaction(sph_integrator *flow,
                                                           sph_boundary *boundary, int wall,
                                                           sph_probe **out);

/** Record how far the fluid has come along an axis. Column front.
 *
 *     front = max_i sign x_i[axis] + dx/2
 *
 * over the particles that have at least 3 others within 2 dx (sph_probe_set_min_neighbours), so that
 * spray does not count; NaN if there is none. With sign = -1 this is the distance along minus the axis.
 *
 * Units      m; sign +1 or -1
 * Ownership  holds a reference to flow; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, no such axis, sign not +1 or -1, 256 probes; SPH_E_TYPE particles on a
 *            mesh; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_front(sph_integrator *flow, int axis, double sign,
                                                        sph_probe **out);

/** How many other particles within 2 dx make a particle part of the front.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT probe NULL, count not 0 to 1000; SPH_E_TYPE probe is not a front
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_set_min_neighbours(sph_probe *probe, int count);

/** Record the free surface along a line: a wave gauge, or the run-up where the line is on a wall.
 * Column elevation.
 *
 *     elevation = largest s in [0, length] with G(foot + s direction) >= 1/2, 0 if there is none   (1)
 *     G(x) = sum_fluid W V + 1/2 sum_ghosts W V                                                    (2)
 *
 * Sampled every dx/2 with linear interpolation between. The ghosts' half share makes (1) the plane
 * surface at any distance from the walls: the fluid fills half of what the walls leave open. With particles on
 * a mesh it is the length of the heavier fluid along the line, by the shares of cells.
 *
 * Shape      foot [dim]; direction [dim], a unit vector
 * Units      foot, length, elevation m
 * Ownership  copies foot and direction; holds a reference to flow; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, foot as x of sph_probe_create_pressure, direction not a unit vector
 *            to 1e-6, length not finite or <= 0 or more than 500000 dx, 256 probes; SPH_E_MEMORY
 * Source     own; half the kernel sum at a plane surface; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_elevation(sph_integrator *flow,
                                                            const double *foot,
                                                            const double *direction, double length,
                                                            sph_probe **out);

/** Record the energies of sph_wcsph_get_energy. Columns kinetic, potential, compressible, total.
 *
 * Units      J (J/m in 2D)
 * Ownership  holds a reference to flow; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, 256 probes; SPH_E_TYPE a method without energies; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_energy(sph_integrator *flow, sph_probe **out);

/** Record the fluid's mass and the number of its particles. Columns mass, particles.
 *
 * Units      kg (kg/m in 2D); a number
 * Ownership  holds a reference to flow; the caller destroys *out
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, 256 probes; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_mass(sph_integrator *flow, sph_probe **out);

/** Record what a function of the caller's measures.
 *
 * Shape      names [columns]; units [columns], or NULL: no units
 * Ownership  copies names and units; user must live as long as the probe; holds a reference to flow; the
 *            caller destroys *out
 * Parallel   not while another call uses the context; function runs on the thread that steps
 * Errors     SPH_E_ARGUMENT a NULL, columns not 1 to 256, a name empty, a name or unit with a comma, a
 *            quote or a control character, 256 probes; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_create_function(sph_integrator *flow, int columns,
                                                           const char *const *names,
                                                           const char *const *units,
                                                           sph_probe_function function, void *user,
                                                           sph_probe **out);

/** Stop recording, free the probe and set *probe to NULL. NULL is allowed.
 *
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_probe_destroy(sph_probe **probe);

/** Sample at the first step at or after each multiple of an interval, counted from the present time
 * (0, as until called: every step).
 *
 * Units      seconds >= 0 [s]
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT probe NULL, seconds not finite or < 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_set_interval(sph_probe *probe, double seconds);

/** Name the probe for messages and files; its kind ("pressure", "force" ...) until then.
 *
 * Ownership  name is copied
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, name empty or with a control character; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_set_name(sph_probe *probe, const char *name);

/** Name of the probe; "" if probe is NULL.
 *
 * Ownership  text in the probe, valid until it is renamed or destroyed
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_probe_name(const sph_probe *probe);

/** Sample now, in addition to the steps' samples.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT probe NULL, or the flow is not ready for a step; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_sample(sph_probe *probe);

/** Make room for a number of samples in all: until it is full, samples allocate nothing.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT probe NULL, samples < 0; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_reserve(sph_probe *probe, int64_t samples);

/** Forget all samples; the room for them stays.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT probe is NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_clear(sph_probe *probe);

/** Number of samples; 0 if probe is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_probe_count(const sph_probe *probe);

/** Number of columns, time not counted; 0 if probe is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_probe_columns(const sph_probe *probe);

/** Name of a column; "" if probe is NULL or there is no such column.
 *
 * Ownership  text in the probe, valid until it is destroyed
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_probe_column_name(const sph_probe *probe, int column);

/** Unit of a column, "" where there is none; "" if probe is NULL or there is no such column.
 *
 * Ownership  text in the probe, valid until it is destroyed
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_probe_column_unit(const sph_probe *probe, int column);

/** Read samples from ... from + count - 1.
 *
 * Shape      times [count]; values [count, columns]; either may be NULL
 * Units      times s; values as sph_probe_column_unit
 * Ownership  copies into the caller's arrays
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT probe NULL, or samples that are not there
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_read(const sph_probe *probe, int64_t from, int64_t count,
                                                double *times, double *values);

/** Read the latest sample.
 *
 * Shape      values [columns]
 * Units      as sph_probe_column_unit
 * Ownership  copies into the caller's array
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, or no sample yet
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_last(const sph_probe *probe, double *values);

/** Write all samples as comma-separated text.
 *
 *     # name: gauge 1
 *     # units: s,Pa
 *     t_s,p
 *     0.01,123.5
 *
 * Numbers have 17 digits and a decimal point in every locale. The file appears under its name when it
 * is complete; a failure leaves what was there.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, path empty; SPH_E_IO the file cannot be written; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_probe_write_csv(const sph_probe *probe, const char *path);

SPH_END_DECLS

#endif
