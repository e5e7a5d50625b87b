/* Meshes as handles: creation, readers, and nodes that follow a paddle. */
#include "mesh/mesh_impl.h"

#include <inttypes.h>

/* Twice the area over the square of the longest edge below which a triangle is degenerate. */
static const double THIN = 2e-10;

void sphi_mesh_retain(sph_mesh *mesh) { mesh->references++; }

void sph_mesh_destroy(sph_mesh **mesh) {
  if (!mesh || !*mesh) return;
  sph_mesh *dead = *mesh;
  *mesh = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  void *const arrays[] = {dead->rest, dead->x,         dead->moved,        dead->corner,
                          dead->area, dead->neighbour, dead->gradient,     dead->ends,
                          dead->side, dead->tag,       dead->touch_start,  dead->touch,
                          dead->next, dead->last,      dead->square_start, dead->square_cell};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) sphi_free(context, arrays[k]);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

/* Twice the area of a triangle over the square of its longest edge. */
static double shape_of(const double *x, const int32_t *corner) {
  double longest = 0, cross = 0;
  for (int k = 0; k < 3; k++) {
    const double *a = x + 2 * (int64_t)corner[k], *b = x + 2 * (int64_t)corner[(k + 1) % 3];
    const double dx = b[0] - a[0], dy = b[1] - a[1];
    longest = fmax(longest, dx * dx + dy * dy);
    if (k == 0) {
      const double *c = x + 2 * (int64_t)corner[2];
      cross = dx * (c[1] - a[1]) - dy * (c[0] - a[0]);
    }
  }
  return longest > 0 ? cross / longest : 0;
}

int32_t sphi_mesh_measure(sph_mesh *mesh, const double *x) {
  for (int32_t c = 0; c < mesh->cells; c++)
    if (!(shape_of(x, mesh->corner + 3 * (int64_t)c) > THIN)) return c;
  for (int32_t c = 0; c < mesh->cells; c++) {
    const int32_t *corner = mesh->corner + 3 * (int64_t)c;
    const double *p[3];
    for (int k = 0; k < 3; k++) p[k] = x + 2 * (int64_t)corner[k];
    const double twice =
        (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    double *g = mesh->gradient + 6 * (int64_t)c;
    for (int k = 0; k < 3; k++) { /* grad N_k = (y_l - y_m, x_m - x_l)/(2 A) */
      const double *l = p[(k + 1) % 3], *m = p[(k + 2) % 3];
      g[2 * k] = (l[1] - m[1]) / twice;
      g[2 * k + 1] = (m[0] - l[0]) / twice;
    }
    mesh->area[c] = 0.5 * twice;
  }
  return -1;
}

static sph_status check_names(sph_context *context, const char *what, int count,
                              const char *const *names) {
  SPH_CHECK(context, count >= 0 && count <= SPHI_MESH_TAGS, SPH_E_ARGUMENT,
            "%s: tags must be 0 to %d, got %d", what, SPHI_MESH_TAGS, count);
  for (int k = 0; k < count; k++) {
    SPH_CHECK(context, names[k] && *names[k] && strlen(names[k]) <= SPHI_MESH_NAME, SPH_E_ARGUMENT,
              "%s: the name of tag %d must have 1 to %d bytes", what, k + 1, SPHI_MESH_NAME);
    for (int j = 0; j < k; j++)
      SPH_CHECK(context, strcmp(names[j], names[k]) != 0, SPH_E_ARGUMENT,
                "%s: tags %d and %d have one name, \"%s\"", what, j + 1, k + 1, names[k]);
  }
  return SPH_OK;
}

static sph_status check_input(sph_context *context, const sphi_mesh_source *source, int64_t nodes,
                              const double *x, int64_t cells, const int32_t *corners) {
  const char *what = source->what;
  SPH_CHECK(context, nodes >= 3 && nodes <= SPHI_MESH_MAX, SPH_E_ARGUMENT,
            "%s: nodes must be 3 to %d, got %" PRId64, what, SPHI_MESH_MAX, nodes);
  SPH_CHECK(context, cells >= 1 && cells <= SPHI_MESH_MAX, SPH_E_ARGUMENT,
            "%s: cells must be 1 to %d, got %" PRId64, what, SPHI_MESH_MAX, cells);
  for (int64_t k = 0; k < 2 * nodes; k++)
    SPH_CHECK(context, fabs(x[k]) <= 1e100, SPH_E_ARGUMENT,
              "%s: a coordinate of node %" PRId64 " must be finite and at most 1e100 m, got %g",
              what, k / 2, x[k]);
  for (int64_t c = 0; c < cells; c++) {
    const int32_t *corner = corners + 3 * c;
    for (int k = 0; k < 3; k++)
      SPH_CHECK(context, corner[k] >= 0 && corner[k] < nodes, SPH_E_ARGUMENT,
                "%s: %s has node %d for a corner, not 0 to %" PRId64, what,
                sphi_mesh_cell_words(source, c).text, corner[k], nodes - 1);
    const double shape = shape_of(x, corner);
    SPH_CHECK(context, shape > -THIN, SPH_E_ARGUMENT,
              "%s: %s is inverted: its corners %d, %d, %d run clockwise", what,
              sphi_mesh_cell_words(source, c).text, corner[0], corner[1], corner[2]);
    SPH_CHECK(context, shape > THIN, SPH_E_ARGUMENT,
              "%s: %s is degenerate: its corners %d, %d, %d are on a line", what,
              sphi_mesh_cell_words(source, c).text, corner[0], corner[1], corner[2]);
  }
  return SPH_OK;
}

/* Copies what has been checked and makes the rest of it. */
static sph_status fill(sph_mesh *mesh, const sphi_mesh_source *source, const double *x,
                       const int32_t *corners, int64_t edges, const int32_t *ends,
                       const int32_t *tags) {
  sph_context *context = mesh->context;
  const size_t nodes = (size_t)mesh->nodes, cells = (size_t)mesh->cells;
  mesh->rest = SPHI_NEW(context, 2 * nodes, double);
  mesh->x = SPHI_NEW(context, 2 * nodes, double);
  mesh->moved = SPHI_NEW(context, 2 * nodes, double);
  mesh->corner = SPHI_NEW(context, 3 * cells, int32_t);
  mesh->area = SPHI_NEW(context, cells, double);
  mesh->gradient = SPHI_NEW(context, 6 * cells, double);
  SPH_CHECK(context,
            mesh->rest && mesh->x && mesh->moved && mesh->corner && mesh->area && mesh->gradient,
            SPH_E_MEMORY, "%s: no memory for %d nodes and %d cells", source->what, mesh->nodes,
            mesh->cells);
  memcpy(mesh->rest, x, 2 * nodes * sizeof *x);
  memcpy(mesh->x, x, 2 * nodes * sizeof *x);
  memcpy(mesh->corner, corners, 3 * cells * sizeof *corners);
  SPH_TRY(sphi_mesh_connect(mesh, source, edges, ends, tags));
  mesh->first = HUGE_VAL;
  for (int32_t a = 0; a < mesh->nodes; a++) {
    SPH_CHECK(context, mesh->touch_start[a + 1] > mesh->touch_start[a], SPH_E_ARGUMENT,
              "%s: node %d at (%g, %g) m is of no triangle", source->what, a, x[2 * (int64_t)a],
              x[2 * (int64_t)a + 1]);
    mesh->first = fmin(mesh->first, x[2 * (int64_t)a]);
  }
  sphi_mesh_measure(mesh, mesh->x);
  mesh->revision = 1;
  return SPH_OK;
}

sph_status sphi_mesh_make(sph_context *context, const sphi_mesh_source *source, int64_t nodes,
                          const double *x, int64_t cells, const int32_t *corners, int64_t edges,
                          const int32_t *ends, const int32_t *tags, int tag_count,
                          const char *const *names, sph_mesh **out) {
  SPH_TRY(check_names(context, source->what, tag_count, names));
  SPH_TRY(check_input(context, source, nodes, x, cells, corners));
  sph_mesh *mesh = SPHI_NEW(context, 1, sph_mesh);
  SPH_CHECK(context, mesh, SPH_E_MEMORY, "%s: out of memory", source->what);
  sphi_context_retain(context);
  mesh->context = context;
  mesh->references = 1;
  mesh->nodes = (int32_t)nodes;
  mesh->cells = (int32_t)cells;
  mesh->tags = tag_count;
  for (int k = 0; k < tag_count; k++) memcpy(mesh->name[k], names[k], strlen(names[k]));
  const sph_status status = fill(mesh, source, x, corners, edges, ends, tags);
  if (status == SPH_OK)
    *out = mesh;
  else
    sph_mesh_destroy(&mesh);
  return status;
}

sph_status sph_mesh_create(sph_context *context, int64_t nodes, const double *x, int64_t cells,
                           const int32_t *corners, int64_t edges, const int32_t *ends,
                           const int32_t *tags, int tag_count, const char *const *names,
                           sph_mesh **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, x && corners && out, SPH_E_ARGUMENT, "mesh: %s is NULL",
            !x         ? "x"
            : !corners ? "corners"
                       : "out");
  SPH_CHECK(context, edges >= 0 && edges <= SPHI_MESH_MAX, SPH_E_ARGUMENT,
            "mesh: edges must be 0 to %d, got %" PRId64, SPHI_MESH_MAX, edges);
  SPH_CHECK(context, edges == 0 || (ends && tags), SPH_E_ARGUMENT, "mesh: ends or tags is NULL");
  SPH_CHECK(context, tag_count <= 0 || names, SPH_E_ARGUMENT, "mesh: names is NULL");
  const sphi_mesh_source source = {.what = "mesh"};
  return sphi_mesh_make(context, &source, nodes, x, cells, corners, edges, ends, tags, tag_count,
                        names, out);
}

/* ---- readers ---- */

int64_t sph_mesh_node_count(const sph_mesh *mesh) { return mesh ? mesh->nodes : 0; }
int64_t sph_mesh_cell_count(const sph_mesh *mesh) { return mesh ? mesh->cells : 0; }
int64_t sph_mesh_edge_count(const sph_mesh *mesh) { return mesh ? mesh->edges : 0; }
int sph_mesh_tag_count(const sph_mesh *mesh) { return mesh ? mesh->tags : 0; }

const char *sph_mesh_tag_name(const sph_mesh *mesh, int tag) {
  return mesh && tag >= 1 && tag <= mesh->tags ? mesh->name[tag - 1] : "";
}

sph_status sph_mesh_find_tag(const sph_mesh *mesh, const char *name, int *tag) {
  if (!mesh) return SPH_E_ARGUMENT;
  sph_context *context = mesh->context;
  SPH_CHECK(context, name && tag, SPH_E_ARGUMENT, "mesh: %s is NULL", name ? "tag" : "name");
  const char *names[SPHI_MESH_TAGS];
  for (int k = 0; k < mesh->tags; k++) {
    names[k] = mesh->name[k];
    if (strcmp(name, names[k]) != 0) continue;
    *tag = k + 1;
    return SPH_OK;
  }
  const char *near = sphi_nearest_name(name, mesh->tags, names);
  SPH_CHECK(context, near, SPH_E_NAME, "mesh: no tag \"%.100s\"; there are %d others", name,
            mesh->tags);
  return SPHI_ERROR(context, SPH_E_NAME, "mesh: no tag \"%.100s\"; did you mean \"%s\"?", name,
                    near);
}

static sph_status check_read(const sph_mesh *mesh, const char *what, const void *array,
                             int64_t size, int64_t wanted) {
  if (!mesh) return SPH_E_ARGUMENT;
  SPH_CHECK(mesh->context, array, SPH_E_ARGUMENT, "mesh: %s is NULL", what);
  SPH_CHECK(mesh->context, size == wanted, SPH_E_ARGUMENT,
            "mesh: size of %s must be %" PRId64 ", got %" PRId64, what, wanted, size);
  return SPH_OK;
}

sph_status sph_mesh_read_nodes(const sph_mesh *mesh, double *x, int64_t size) {
  SPH_TRY(check_read(mesh, "x", x, size, 2 * sph_mesh_node_count(mesh)));
  memcpy(x, mesh->x, (size_t)size * sizeof *x);
  return SPH_OK;
}

sph_status sph_mesh_read_cells(const sph_mesh *mesh, int32_t *corners, int64_t size) {
  SPH_TRY(check_read(mesh, "corners", corners, size, 3 * sph_mesh_cell_count(mesh)));
  memcpy(corners, mesh->corner, (size_t)size * sizeof *corners);
  return SPH_OK;
}

sph_status sph_mesh_read_neighbours(const sph_mesh *mesh, int32_t *neighbours, int64_t size) {
  SPH_TRY(check_read(mesh, "neighbours", neighbours, size, 3 * sph_mesh_cell_count(mesh)));
  for (int64_t k = 0; k < size; k++)
    neighbours[k] = mesh->neighbour[k] < 0 ? -1 : mesh->neighbour[k];
  return SPH_OK;
}

sph_status sph_mesh_read_edges(const sph_mesh *mesh, int32_t *ends, int32_t *cells, int32_t *tags,
                               int64_t size) {
  SPH_TRY(check_read(mesh, "edges", mesh, size, sph_mesh_edge_count(mesh)));
  if (ends) memcpy(ends, mesh->ends, 2 * (size_t)size * sizeof *ends);
  if (cells) memcpy(cells, mesh->side, 2 * (size_t)size * sizeof *cells);
  if (tags) memcpy(tags, mesh->tag, (size_t)size * sizeof *tags);
  return SPH_OK;
}

sph_status sph_mesh_read_areas(const sph_mesh *mesh, double *areas, int64_t size) {
  SPH_TRY(check_read(mesh, "areas", areas, size, sph_mesh_cell_count(mesh)));
  memcpy(areas, mesh->area, (size_t)size * sizeof *areas);
  return SPH_OK;
}

sph_status sph_mesh_read_gradients(const sph_mesh *mesh, double *gradients, int64_t size) {
  SPH_TRY(check_read(mesh, "gradients", gradients, size, 6 * sph_mesh_cell_count(mesh)));
  memcpy(gradients, mesh->gradient, (size_t)size * sizeof *gradients);
  return SPH_OK;
}

/* ---- motion ---- */

sph_status sph_mesh_set_paddle(sph_mesh *mesh, sph_wall_motion motion, void *user, double reach) {
  if (!mesh) return SPH_E_ARGUMENT;
  SPH_CHECK(mesh->context, !motion || (isfinite(reach) && reach > 0), SPH_E_ARGUMENT,
            "mesh: the paddle's reach must be finite and > 0 m, got %g", reach);
  mesh->motion = motion;
  mesh->user = user;
  mesh->reach = reach;
  mesh->squares_made = false;
  memcpy(mesh->x, mesh->rest, 2 * (size_t)mesh->nodes * sizeof *mesh->x);
  sphi_mesh_measure(mesh, mesh->x);
  mesh->displacement = mesh->velocity = 0;
  mesh->revision++;
  return SPH_OK;
}

/* Puts nodes where they are with the paddle there; the first cell that this folds, which changes nothing, or -1. */
static int32_t place(sph_mesh *mesh, double displacement, double velocity) {
  double *x = mesh->moved;
  for (int32_t a = 0; a < mesh->nodes; a++) {
    const double *rest = mesh->rest + 2 * (int64_t)a;
    const double share = 1 - (rest[0] - mesh->first) / mesh->reach;
    x[2 * (int64_t)a] = rest[0] + (share > 0 ? displacement * share : 0);
    x[2 * (int64_t)a + 1] = rest[1];
  }
  const int32_t bad = sphi_mesh_measure(mesh, x);
  if (bad >= 0) return bad;
  mesh->moved = mesh->x;
  mesh->x = x;
  mesh->displacement = displacement;
  mesh->velocity = velocity;
  mesh->revision++;
  return -1;
}

sph_status sph_mesh_move(sph_mesh *mesh, double t) {
  if (!mesh) return SPH_E_ARGUMENT;
  sph_context *context = mesh->context;
  SPH_CHECK(context, isfinite(t), SPH_E_ARGUMENT, "mesh: time must be finite, got %g", t);
  if (!mesh->motion) return SPH_OK;
  double displacement[SPHI_MAX_DIM] = {0}, velocity[SPHI_MAX_DIM] = {0},
         acceleration[SPHI_MAX_DIM] = {0};
  mesh->motion(t, displacement, velocity, acceleration, mesh->user);
  SPH_CHECK(context, isfinite(displacement[0]) && isfinite(velocity[0]), SPH_E_ARGUMENT,
            "mesh: at %g s the paddle is at %g m with %g m/s, which must be finite", t,
            displacement[0], velocity[0]);
  const int32_t bad = place(mesh, displacement[0], velocity[0]);
  if (bad >= 0) {
    const double *at = mesh->rest + 2 * (int64_t)mesh->corner[3 * (int64_t)bad];
    return SPHI_ERROR(context, SPH_E_ARGUMENT,
                      "mesh: the paddle at %g m folds cell %d, at rest at (%g, %g) m; its reach is "
                      "%g m",
                      displacement[0], bad, at[0], at[1], mesh->reach);
  }
  return SPH_OK;
}

sph_status sphi_mesh_keep(sph_mesh *mesh, sphi_keep *keep) {
  const bool moves = mesh->motion != NULL;
  const double nodes = mesh->nodes, cells = mesh->cells, paddles = moves;
  double displacement = mesh->displacement, velocity = mesh->velocity;
  double *const at[] = {&displacement, &velocity};
  SPH_TRY(sphi_keep_common(keep, "mesh/nodes", 1, &nodes));
  SPH_TRY(sphi_keep_common(keep, "mesh/cells", 1, &cells));
  SPH_TRY(sphi_keep_common(keep, "mesh/paddles", 1, &paddles));
  SPH_TRY(sphi_keep_reals(keep, "mesh/paddle", 2, at));
  if (keep->act == SPHI_KEEP_CHECK) {
    int64_t count;
    const double *there = sphi_keep_find(keep, "mesh/paddle", SPHI_KEEP_REALS, &count);
    const int64_t revision = mesh->revision;
    const bool fits = !moves || place(mesh, there[0], there[1]) < 0;
    if (moves) place(mesh, displacement, velocity);
    mesh->revision = revision;
    SPH_CHECK(mesh->context, fits, SPH_E_ARGUMENT,
              "checkpoint \"%s\": \"mesh/paddle\": the paddle at %g m folds cells of the mesh",
              keep->path, there[0]);
  }
  if (keep->act == SPHI_KEEP_LOAD && moves) place(mesh, displacement, velocity);
  return SPH_OK;
}
