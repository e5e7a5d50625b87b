/** @file
 * Output: frames of particles, points or meshes as VTK files and the series that lists them, for ParaView.
 */
#ifndef SPH_OUTPUT_H
#define SPH_OUTPUT_H

#include <sph/mesh.h>
#include <sph/types.h>

SPH_BEGIN_DECLS

/** Create a series of VTK XML files: directory/name_000000.vtp (of meshes .vtu), _000001 ... and
 * directory/name.pvd, which lists them with their times.
 *
 * The directory is created unless it exists; its parent must exist. No file is written yet. Files of an
 * earlier series of the same name are replaced one by one as frames are written.
 *
 * Ownership  copies directory and name; the caller destroys *out; it holds a reference to the context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, directory or name is empty, name contains '/' or a
 *            control character; SPH_E_IO the directory cannot be created or is not a directory;
 *            SPH_E_MEMORY; *out is NULL after an error
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_output_create_vtk(sph_context *context, const char *directory,
                                                       const char *name, sph_output **out);

/** Release the output and set *output to NULL. NULL is allowed. The files stay.
 *
 * Ownership  frees the output's memory and its reference to the context
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_output_destroy(sph_output **output);

/** Choose a field for sph_output_write, in addition to those chosen before. Without any choice all
 * fields of the set but the position are written. Positions and ids always are.
 *
 * Ownership  copies field; whether a set has it is checked when a frame is written
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, field is empty or was chosen before; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_output_add_field(sph_output *output, const char *field);

/** Choose the arithmetic of positions and fields in the files: Float32 (true, the default) or Float64.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT output is NULL
 * Since      0.1
 */
SPH_API sph_status sph_output_set_single(sph_output *output, bool single);

/** Write one frame of a particle set and bring the list up to date.
 *
 * The file has the positions and vertices, the chosen fields with their units, the particles' ids as
 * the Int64 array "id", all in id order, and the time. Positions and fields of two components get a
 * third, 0, so that ParaView takes them as vectors. Beyond the range of Float32 numbers become
 * infinite. Both files are written under a temporary name, *.tmp, and renamed when complete: a run that is
 * stopped at any time leaves a series that can be read.
 *
 * Units      time s, larger than that of the frame before
 * Ownership  borrows all arguments
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL, time is not finite or does not increase, the series has frames
 *            of meshes; SPH_E_NAME the
 *            set lacks a chosen field; SPH_E_IO a file cannot be written: the message has its name
 *            and the system's reason, no part of the frame is left, earlier frames and their list are
 *            intact, and the next call may succeed; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_output_write(sph_output *output,
                                                  const sph_particles *particles, double time);

/** Write one frame of points that are no particles, as sph_output_write but without ids and units.
 *
 * Shape      x [count, dim]; names, components, values [fields]; values[k] [count, components[k]],
 *            components 1 to 9
 * Units      x m; time s, larger than that of the frame before
 * Ownership  borrows all arguments
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a pointer is NULL (values and x may be if count is 0, the arrays of fields
 *            if fields is 0), count < 0 or above 2147483647, fields < 0, dim not 2 or 3, x not finite,
 *            a name empty or given twice, components out of range, time as for sph_output_write;
 *            SPH_E_IO as sph_output_write; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_output_write_points(sph_output *output, int64_t count, int dim,
                                                         const double *x, int fields,
                                                         const char *const *names,
                                                         const int *components,
                                                         const double *const *values, double time);

/** Write one frame of a mesh as it is now, with fields at its nodes and of its cells: the file is that of
 * sph_mesh_write_vtk(), Float64 always. Frames of one series are all of meshes, or none is.
 *
 * Units      time s, larger than that of the frame before
 * Ownership  borrows all arguments
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT output or mesh NULL, mesh of another context, the series has frames of
 *            particles or points, fields as for sph_mesh_write_vtk(), time as for sph_output_write();
 *            SPH_E_IO as sph_output_write(); SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_output_write_mesh(sph_output *output, const sph_mesh *mesh,
                                                       int node_fields,
                                                       const sph_mesh_field *at_nodes,
                                                       int cell_fields,
                                                       const sph_mesh_field *of_cells, double time);

/** Number of complete frames; 0 if output is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_output_frame_count(const sph_output *output);

SPH_END_DECLS

#endif
