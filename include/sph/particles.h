/** @file
 * Particle sets: positions, velocities and any other field by name, ids that never change, and the
 * ways to fill a set. Everything is handed over in id order, whatever the order inside.
 */
#ifndef SPH_PARTICLES_H
#define SPH_PARTICLES_H

#include <sph/types.h>

/* Fields that every set has. */
#define SPH_POSITION "position" /**< dim components, m */
#define SPH_VELOCITY "velocity" /**< dim components, m/s */
#define SPH_DENSITY "density"   /**< kg/m^3, > 0 */
#define SPH_PRESSURE "pressure" /**< Pa */
#define SPH_MASS "mass"         /**< kg, in 2D kg/m, > 0 */
#define SPH_VOLUME "volume"     /**< m^dim, > 0 */

SPH_BEGIN_DECLS

/** Says whether a point is to become a particle.
 * x is [dim] in m; user is what the caller gave along. It must not call the library on the set that is
 * being filled.
 */
typedef bool (*sph_inside_function)(const double *x, void *user);

/** Level of a surface, along the last direction [m], above a place x [dim - 1] in m; user is what the
 * caller gave along. It must not call the library on the set that is being filled.
 */
typedef double (*sph_surface_function)(const double *x, void *user);

/** Create an empty set of particles, called "particles" until it is named.
 *
 * Units      dim 2 or 3; spacing in m, the distance of neighbours at rest, 1e-100 to 1e100
 * Ownership  the caller destroys *out; it holds a reference to the context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context or out NULL, dim or spacing out of range; SPH_E_MEMORY;
 *            *out is NULL after an error
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_create(sph_context *context, int dim, double spacing,
                                                      sph_particles **out);

/** Release the caller's reference and set *particles to NULL. NULL is allowed.
 *
 * Ownership  the memory, leases still open included, goes with the last handle that uses the set
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_particles_destroy(sph_particles **particles);

/** Name the set; messages carry the name.
 *
 * Ownership  copies name: 1 to 63 bytes without control characters
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT particles NULL, name NULL or not as above; SPH_E_MEMORY, name unchanged
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_set_name(sph_particles *particles, const char *name);

/** Name of the set; "" if particles is NULL.
 *
 * Ownership  text in the set, valid until it is renamed or destroyed
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_particles_name(const sph_particles *particles);

/** Number of particles; 0 if particles is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API sph_index sph_particles_count(const sph_particles *particles);

/** Dimension of space, 2 or 3; 0 if particles is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_particles_dim(const sph_particles *particles);

/** Spacing given at creation; 0 if particles is NULL.
 *
 * Units      m
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API double sph_particles_spacing(const sph_particles *particles);

/** A number >= 1 that grows with every fill, add, remove, write and released write lease; 0 if
 * particles is NULL. What was built from an older revision is stale.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_particles_revision(const sph_particles *particles);

/** Add a field of the caller's own, zero for all particles present and to come.
 *
 * Shape      components 1 to 9 a particle
 * Units      unit is text, "1" for a pure number, up to 31 bytes
 * Ownership  copies name (1 to 63 letters, digits, '_', '-' or '.') and unit (no control characters, no
 *            '"', '<', '>' or '&')
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT an argument is NULL or not as above, or the field exists; SPH_E_MEMORY; the
 *            set is unchanged after an error
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_add_field(sph_particles *particles, const char *name,
                                                         int components, const char *unit);

/** Number of fields, the six built-in ones included; 0 if particles is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_particles_field_count(const sph_particles *particles);

/** Name of field k in order of creation; NULL if particles is NULL or there is no field k.
 *
 * Ownership  text in the set, valid as long as the set
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_particles_field_name(const sph_particles *particles, int k);

/** Number of components of a field.
 *
 * Ownership  writes *components unless it fails
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT an argument is NULL; SPH_E_NAME no such field
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_field_components(const sph_particles *particles,
                                                                const char *field, int *components);

/** Unit of a field.
 *
 * Ownership  sets *unit, unless it fails, to text in the set, valid as long as the set
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT an argument is NULL; SPH_E_NAME no such field
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_field_unit(const sph_particles *particles,
                                                          const char *field, const char **unit);

/** Fill a box with a lattice of particles at rest and without pressure.
 *
 *     x = lo + (i + 1/2) dx,  i = 0 .. floor((hi - lo) / dx + 1e-6) - 1  in each direction        (1)
 *     volume = dx^dim,  mass = density volume                                                     (2)
 *
 * The last direction runs fastest; ids follow. The box need not be a multiple of the spacing: what is
 * left over stays empty at the side of hi.
 *
 * Shape      lo, hi [dim]
 * Units      lo, hi m, at most 1e12 spacings from the origin; density kg/m^3
 * Ownership  borrows all arguments
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL; a number is not finite or out of range; the box is less
 *            than a spacing wide in some direction; the particles present and the points of the
 *            lattice are more than 2147482623; a new particle is closer than half a spacing to an old
 *            one (both positions are named); a lease is open; SPH_E_MEMORY; the set is unchanged after an error
 * Source     the usual Cartesian arrangement of SPH particles; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_fill_box(sph_particles *particles, const double *lo,
                                                        const double *hi, double density);

/** Fill a simple polygon in 2D: the points of its bounding box's lattice, sph_particles_fill_box (1),
 * that are inside.
 *
 * Vertices run either way round, and the last is not the first repeated. A lattice point on an edge
 * counts as moved by 1e-6 dx to the right (and 0.6e-6 dx up), so that of two polygons with a common
 * edge one has it. The time grows with the square of the number of vertices.
 *
 * Shape      xy [vertices, 2], vertices >= 3
 * Units      xy m, at most 1e12 spacings from the origin; density kg/m^3
 * Ownership  borrows all arguments
 * Parallel   not while another call uses the context
 * Errors     as sph_particles_fill_box; SPH_E_ARGUMENT the set is 3D, vertices < 3, neighbouring vertices
 *            coincide, two edges meet elsewhere than at their common vertex, no lattice point is inside
 * Source     even-odd rule, Shimrat (1962), doi:10.1145/368637.368653; differs: counts along columns
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_fill_polygon(sph_particles *particles, int vertices,
                                                            const double *xy, double density);

/** Fill a convex region: the points of a box's lattice, sph_particles_fill_box (1), for which
 *
 *     (x - point_k) . normal_k >= 0  for all k, to 1e-6 dx                                        (1)
 *
 * Shape      lo, hi [dim]; points, normals [planes, dim], planes >= 1
 * Units      lo, hi, points m; normals of any length but 0; density kg/m^3
 * Ownership  borrows all arguments
 * Parallel   not while another call uses the context
 * Errors     as sph_particles_fill_box; SPH_E_ARGUMENT planes < 1, a point or normal is not finite, a
 *            normal's length is not between 1e-100 and 1e100, no lattice point is inside
 * Source     definition; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_fill_half_spaces(sph_particles *particles,
                                                                const double *lo, const double *hi,
                                                                int planes, const double *points,
                                                                const double *normals,
                                                                double density);

/** Fill the part of a box that a function chooses: points of the box's lattice, sph_particles_fill_box
 * (1), for which inside(x, user) is true.
 *
 * Shape      lo, hi [dim]
 * Units      lo, hi m; density kg/m^3
 * Ownership  borrows all arguments; inside is called once a lattice point, in the order of the ids
 * Parallel   not while another call uses the context; inside runs on the calling thread
 * Errors     as sph_particles_fill_box; SPH_E_ARGUMENT inside is NULL or true nowhere
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_fill_predicate(sph_particles *particles,
                                                              const double *lo, const double *hi,
                                                              sph_inside_function inside,
                                                              void *user, double density);

/** Fill from a level bed up to a surface: in each column of the lattice as many equal layers as fit best,
 * so that the surface is met exactly and particles differ little in mass.
 *
 *     columns as in sph_particles_fill_box (1), s the surface above the middle of the column          (1)
 *     n = round((s - lo) / dx) layers, z = lo + (k + 1/2) (s - lo)/n,  k = 0 ... n - 1             (2)
 *     volume = dx^(dim-1) (s - lo)/n,  mass = density volume                                          (3)
 *
 * Columns of less than half a spacing stay empty. The last element of lo is the bed's, that of hi a level
 * above the surface.
 *
 * Shape      lo, hi [dim]
 * Units      lo, hi m; density kg/m^3
 * Ownership  borrows all arguments; surface is called twice a column
 * Parallel   not while another call uses the context; surface runs on the calling thread
 * Errors     as sph_particles_fill_box; SPH_E_ARGUMENT surface is NULL, a level is not finite or above
 *            hi, no column is filled
 * Source     own; differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_fill_surface(sph_particles *particles,
                                                            const double *lo, const double *hi,
                                                            sph_surface_function surface,
                                                            void *user, double density);

/** Add particles at any positions, at rest and without pressure; volume and mass as
 * sph_particles_fill_box (2).
 *
 * Shape      x [count, dim]; ids [count] or NULL
 * Units      x m; density kg/m^3
 * Ownership  borrows x; writes the new ids, in the order of x, unless ids is NULL or it fails
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT particles NULL, x NULL though count > 0, count < 0, the set would exceed
 *            2147482623 particles, a number is not finite, density <= 0, a new particle is closer than
 *            a tenth of a spacing to another, new or old (both positions are named), a lease is open;
 *            SPH_E_MEMORY; the set is unchanged after an error, and if count is 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_add(sph_particles *particles, int64_t count,
                                                   const double *x, double density, int64_t *ids);

/** Remove particles by id. The others keep their ids; removed ids are never given again.
 *
 * Shape      ids [count], in any order
 * Ownership  borrows ids, allocates nothing
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT particles NULL, ids NULL though count > 0, count < 0, an id is unknown or
 *            given twice, a lease is open; the set is unchanged after an error, and if count is 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_remove(sph_particles *particles, int64_t count,
                                                      const int64_t *ids);

/** Ids of all particles, ascending: the order of every array that goes in or out.
 *
 * Shape      ids [size], size = number of particles
 * Ownership  fills ids, allocates nothing
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT particles NULL, ids NULL though size > 0, wrong size
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_read_ids(const sph_particles *particles,
                                                        int64_t *ids, int64_t size);

/** Copy a field out, in id order.
 *
 * Shape      values [n] or [n, components]; size = n components
 * Units      the field's, see sph_particles_field_unit
 * Ownership  fills values, allocates nothing
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT particles or field NULL, values NULL though size > 0, wrong size; SPH_E_NAME
 *            no such field
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_read(const sph_particles *particles,
                                                    const char *field, double *values,
                                                    int64_t size);

/** Replace a field, in id order. Fields are independent: a new density leaves the mass as it is.
 * Positions may be anywhere; only fills and sph_particles_add look at distances.
 *
 * Shape      values [n] or [n, components]; size = n components
 * Units      the field's, see sph_particles_field_unit
 * Ownership  borrows values, allocates nothing
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT particles or field NULL, values NULL though size > 0, wrong size, a value is
 *            not finite or, for density, mass and volume, not > 0; SPH_E_NAME no such field; the field
 *            is unchanged after an error
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_write(sph_particles *particles, const char *field,
                                                     const double *values, int64_t size);

/** Lease a field for reading: one array in id order with the values of now.
 *
 * Shape      *values [n] or [n, components]
 * Units      the field's, see sph_particles_field_unit
 * Ownership  *values belongs to the set; close it with sph_particles_release. While any lease is open,
 *            particles cannot be added or removed. *values is NULL after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT an argument is NULL; SPH_E_NAME no such field; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_lease_read(const sph_particles *particles,
                                                          const char *field, const double **values);

/** Lease a field for writing: as sph_particles_lease_read, but what the array holds when it is released
 * replaces the field.
 *
 * Shape      *values [n] or [n, components]
 * Units      the field's, see sph_particles_field_unit
 * Ownership  as sph_particles_lease_read
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT an argument is NULL; SPH_E_NAME no such field; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_lease_write(sph_particles *particles,
                                                           const char *field, double **values);

/** Close a lease. A write lease's values replace the field, as by sph_particles_write.
 *
 * Shape      values is what sph_particles_lease_read or _write gave
 * Units      the field's, see sph_particles_field_unit
 * Ownership  values is freed, also when its contents are refused
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT particles NULL; values is no open lease of this set; a write lease holds a
 *            value that sph_particles_write refuses: the lease is closed, the field unchanged
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_particles_release(const sph_particles *particles,
                                                       const double *values);

SPH_END_DECLS

#endif
