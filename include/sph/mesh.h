/** @file
 * Meshes of triangles in 2D: flumes over any bed, files of Gmsh, a caller's own; where points are in them;
 * nodes that follow a paddle.
 */
#ifndef SPH_MESH_H
#define SPH_MESH_H

#include <sph/types.h>
#include <sph/wall.h>

SPH_BEGIN_DECLS

typedef struct sph_mesh sph_mesh;

/** Level of the bed [m] at x [m]; user is what the caller gave along. */
typedef double (*sph_mesh_profile)(double x, void *user);

/** A field for sph_mesh_write_vtk. */
typedef struct sph_mesh_field {
  const char *name;
  const char *unit;     /**< NULL: none */
  int components;       /**< 1 to 9 */
  const double *values; /**< [nodes or cells, components] */
} sph_mesh_field;

/** Create a mesh of the caller's triangles, whose corners run counterclockwise.
 *
 * Every node is a corner of some triangle, every edge belongs to one or two of them, which do not overlap
 * at it. Tags name parts of the boundary: edge k, from node ends[k][0] to ends[k][1] or back, is of
 * names[tags[k] - 1]. Edges on the boundary that are not given have tag 0, named "".
 *
 * Shape      x [nodes, 2]; corners [cells, 3]; ends [edges, 2]; tags [edges]; names [tag_count];
 *            edges and tag_count may be 0, and their arrays NULL then
 * Units      x m
 * Ownership  copies all arrays; the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, fewer than 3 nodes or 1 cell, more than 10^8 of either or of edges, a
 *            coordinate not finite or above 1e100, a corner that is no node, a triangle that is inverted,
 *            degenerate (area below 1e-10 of the square of its longest edge) or there twice, an edge of more
 *            than two, triangles that overlap at an edge, a node of no triangle, an edge that is none of the
 *            mesh's or has two tags, a tag out of range, a name empty, longer than 63 bytes or given twice,
 *            more than 64 names; the message names the cell; SPH_E_MEMORY; *out is NULL after an error
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_create(sph_context *context, int64_t nodes,
                                                 const double *x, int64_t cells,
                                                 const int32_t *corners, int64_t edges,
                                                 const int32_t *ends, const int32_t *tags,
                                                 int tag_count, const char *const *names,
                                                 sph_mesh **out);

/** Create the mesh of a flume: columns of equal width, each cut into rows of equal height between bed and
 * top, each of them into two triangles, by diagonals that rise and fall by turns.
 *
 *     x = from + i (to - from)/columns,  y = bed(x) + j (top - bed(x))/rows                           (1)
 *
 * The boundary has the tags "bed" (1), "left" (2), "right" (3) and "top" (4).
 *
 * Units      from, to, top m
 * Ownership  borrows bed (NULL: a level bed at 0), which is called once a column and once more; the caller
 *            destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context; bed runs on the calling thread
 * Errors     as sph_mesh_create; SPH_E_ARGUMENT from >= to, columns or rows < 1, a bed that is not finite or
 *            not below top (the place is named)
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_create_flume(sph_context *context, double from, double to,
                                                       double top, int columns, int rows,
                                                       sph_mesh_profile bed, void *user,
                                                       sph_mesh **out);

/** Create the mesh of a flume whose bed is a polyline: a slope, a step that leans, a submerged bar.
 *
 * The nodes of a column are moved to a vertex that is less than half a column away, so that slopes begin
 * where they should.
 *
 * Shape      xy [vertices, 2], vertices >= 2, x increasing; the first and the last are the ends of the flume
 * Units      xy, top m
 * Ownership  borrows xy; as sph_mesh_create_flume
 * Parallel   not while another call uses the context
 * Errors     as sph_mesh_create_flume; SPH_E_ARGUMENT vertices < 2 or as many as columns or more, a vertex
 *            not finite or not right of the one before, two vertices within a column
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_create_flume_polyline(sph_context *context, int vertices,
                                                                const double *xy, double top,
                                                                int columns, int rows,
                                                                sph_mesh **out);

/** Read a mesh from a file of Gmsh: MSH ASCII, versions 2.2 and 4.1.
 *
 * Read are triangles of 3 nodes and lines of 2, whose physical groups are the tags, in the order of their
 * numbers; a group without a name is called by its number. Points are passed over, as are nodes of no
 * triangle and lines of no group. Triangles that all run clockwise are turned round.
 *
 * Units      coordinates of the file are m; z is the same everywhere
 * Ownership  the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     as sph_mesh_create; SPH_E_IO the file cannot be read, ends early, is binary, has another
 *            version, lacks $Nodes or $Elements, or has a line that is malformed, a count or number out of
 *            range, a coordinate that is not finite (the line is named); SPH_E_UNSUPPORTED elements of
 *            other kinds
 * Source     Gmsh reference manual, file formats; differs: parametric nodes, periodic and ghost entities
 *            and partitions are not read
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_create_gmsh(sph_context *context, const char *path,
                                                      sph_mesh **out);

/** Release the caller's reference and set *mesh to NULL. NULL is allowed.
 *
 * Ownership  the memory goes with the last handle that uses the mesh
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_mesh_destroy(sph_mesh **mesh);

/** Number of nodes; 0 if mesh is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_mesh_node_count(const sph_mesh *mesh);

/** Number of triangles; 0 if mesh is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_mesh_cell_count(const sph_mesh *mesh);

/** Number of edges; 0 if mesh is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int64_t sph_mesh_edge_count(const sph_mesh *mesh);

/** Number of tags: they are the numbers 1 to this one; 0 if mesh is NULL.
 *
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_mesh_tag_count(const sph_mesh *mesh);

/** Name of a tag; "" if there is no such tag.
 *
 * Ownership  text in the mesh, valid as long as it
 * Parallel   thread-safe for reading
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_mesh_tag_name(const sph_mesh *mesh, int tag);

/** The tag of this name; the message of a failure suggests the nearest one.
 *
 * Ownership  *tag is untouched after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL; SPH_E_NAME no such tag
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_find_tag(const sph_mesh *mesh, const char *name,
                                                   int *tag);

/** Copy out where the nodes are now.
 *
 * Shape      x [nodes, 2]; size = 2 nodes
 * Units      m
 * Ownership  fills x
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, wrong size
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_read_nodes(const sph_mesh *mesh, double *x, int64_t size);

/** Copy out the triangles' corners, counterclockwise.
 *
 * Shape      corners [cells, 3]; size = 3 cells
 * Ownership  fills corners
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, wrong size
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_read_cells(const sph_mesh *mesh, int32_t *corners,
                                                     int64_t size);

/** Copy out the triangles' neighbours: [c, k] is opposite to corner k of c, -1 on the boundary.
 *
 * Shape      neighbours [cells, 3]; size = 3 cells
 * Ownership  fills neighbours
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, wrong size
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_read_neighbours(const sph_mesh *mesh, int32_t *neighbours,
                                                          int64_t size);

/** Copy out the edges: ends, the cell on the left of the way from the first end to the second and that on
 * the right (-1: none), and tags (0: none). The cell on the left is never -1.
 *
 * Shape      ends, cells [edges, 2]; tags [edges]; size = edges
 * Ownership  fills ends, cells and tags, each of which may be NULL
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT mesh NULL, wrong size
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_read_edges(const sph_mesh *mesh, int32_t *ends,
                                                     int32_t *cells, int32_t *tags, int64_t size);

/** Copy out the triangles' areas, as they are now.
 *
 * Shape      areas [cells]; size = cells
 * Units      m^2
 * Ownership  fills areas
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, wrong size
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_read_areas(const sph_mesh *mesh, double *areas,
                                                     int64_t size);

/** Copy out the gradients of the hat functions, as they are now: [c, k] of the one that is 1 at corner k.
 *
 * Shape      gradients [cells, 3, 2]; size = 6 cells
 * Units      1/m
 * Ownership  fills gradients
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL, wrong size
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_read_gradients(const sph_mesh *mesh, double *gradients,
                                                         int64_t size);

/** Find the triangles that points are in, -1 for points outside. A point on an edge, to 1e-12 of the
 * triangle, is in the triangle of lowest number there.
 *
 * The search walks from the triangle that cells has already, if it is one, to its neighbours; where the
 * boundary stops it, a table of squares says the rest. The result does not depend on where it began.
 *
 * Shape      x [count, 2]; cells [count]
 * Units      x m
 * Ownership  replaces cells
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL though count > 0, count < 0, a coordinate not finite; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_locate(sph_mesh *mesh, int64_t count, const double *x,
                                                 int32_t *cells);

/** Let the nodes follow a paddle at the left end, X_0 the smallest x at rest and X_f = X_0 + reach:
 *
 *     x_a = X_a + x_b(t) (1 - (X_a - X_0)/reach)  for X_a < X_f                                       (1)
 *
 * Until the next sph_mesh_move the nodes are at rest. Where the bed slopes within reach, it is carried along
 * too: keep the reach to where it is level.
 *
 * Units      reach m, > 0 and larger than any displacement
 * Ownership  borrows motion (NULL: none) and user until replaced; element 0 of
 *            what motion writes is used, as by sph_paddle_motion
 * Parallel   not while another call uses the context; motion runs on the thread that calls the library
 * Errors     SPH_E_ARGUMENT mesh NULL, reach not finite or <= 0
 * Source     Maljaars et al. (2017); differs: none
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_set_paddle(sph_mesh *mesh, sph_wall_motion motion,
                                                     void *user, double reach);

/** Move the nodes to where they are at time t; nothing without a paddle.
 *
 * Units      t s
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT mesh NULL, t or the paddle's place not finite, a place that inverts or flattens a
 *            triangle (it is named): the mesh is as it was
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_move(sph_mesh *mesh, double t);

/** Write the mesh as it is now, with fields at its nodes and of its cells, as a VTK XML UnstructuredGrid
 * (.vtu); edges on the boundary are lines, which have the array "tag", 0 for triangles; fields of cells are 0
 * there. Numbers are Float64, in the manner of sph_output_write.
 *
 * Units      time s
 * Ownership  borrows all arguments
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT mesh or path NULL, a count < 0 or its array NULL though it is not 0, time not
 *            finite, a field with a name that is NULL, empty or given twice, with components out of range or
 *            values NULL; SPH_E_IO the file cannot be written, what was there before still is; SPH_E_MEMORY
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_mesh_write_vtk(const sph_mesh *mesh, const char *path,
                                                    double time, int node_fields,
                                                    const sph_mesh_field *at_nodes, int cell_fields,
                                                    const sph_mesh_field *of_cells);

SPH_END_DECLS

#endif
