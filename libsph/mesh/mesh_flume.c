/* Meshes of flumes: columns between a bed and a level top. */
#include <inttypes.h>

#include "mesh/mesh_impl.h"

enum { BED = 1, LEFT, RIGHT, TOP, FLUME_TAGS = TOP };

/* Columns stand at these places, on this bed. */
typedef struct flume {
  const double *x, *bed; /* [columns + 1] */
  double top;
  int columns, rows;
} flume;

static int32_t node_of(const flume *f, int i, int j) { return i * (f->rows + 1) + j; }

static void make_cells(const flume *f, double *x, int32_t *corner) {
  for (int i = 0; i <= f->columns; i++)
    for (int j = 0; j <= f->rows; j++) {
      double *at = x + 2 * (int64_t)node_of(f, i, j);
      at[0] = f->x[i];
      at[1] = j == f->rows ? f->top : f->bed[i] + j * ((f->top - f->bed[i]) / f->rows);
    }
  for (int i = 0; i < f->columns; i++)
    for (int j = 0; j < f->rows; j++) {
      int32_t *at = corner + 6 * ((int64_t)i * f->rows + j);
      const int32_t low = node_of(f, i, j), right = node_of(f, i + 1, j);
      const int32_t up = node_of(f, i, j + 1), far = node_of(f, i + 1, j + 1);
      const int32_t rising[6] = {low, right, far, low, far, up};
      const int32_t falling[6] = {low, right, up, right, far, up};
      memcpy(at, (i + j) % 2 ? falling : rising, sizeof rising);
    }
}

static void make_edges(const flume *f, int32_t *ends, int32_t *tags) {
  int64_t k = 0;
  for (int i = 0; i < f->columns; i++)
    for (int side = 0; side < 2; side++, k++) {
      ends[2 * k] = node_of(f, i, side ? f->rows : 0);
      ends[2 * k + 1] = node_of(f, i + 1, side ? f->rows : 0);
      tags[k] = side ? TOP : BED;
    }
  for (int j = 0; j < f->rows; j++)
    for (int side = 0; side < 2; side++, k++) {
      ends[2 * k] = node_of(f, side ? f->columns : 0, j);
      ends[2 * k + 1] = node_of(f, side ? f->columns : 0, j + 1);
      tags[k] = side ? RIGHT : LEFT;
    }
}

static sph_status make(sph_context *context, const flume *f, sph_mesh **out) {
  static const char *const names[FLUME_TAGS] = {"bed", "left", "right", "top"};
  const int64_t nodes = ((int64_t)f->columns + 1) * (f->rows + 1);
  const int64_t cells = 2 * (int64_t)f->columns * f->rows;
  const int64_t edges = 2 * ((int64_t)f->columns + f->rows);
  for (int i = 0; i <= f->columns; i++)
    SPH_CHECK(context, isfinite(f->bed[i]) && f->bed[i] < f->top, SPH_E_ARGUMENT,
              "mesh: the bed at x = %g m must be finite and below the top, %g m, got %g m", f->x[i],
              f->top, f->bed[i]);
  double *x = SPHI_NEW(context, 2 * nodes, double);
  int32_t *corner = SPHI_NEW(context, 3 * cells, int32_t);
  int32_t *ends = SPHI_NEW(context, 2 * edges, int32_t);
  int32_t *tags = SPHI_NEW(context, edges, int32_t);
  sph_status status = SPH_OK;
  if (x && corner && ends && tags) {
    make_cells(f, x, corner);
    make_edges(f, ends, tags);
    const sphi_mesh_source source = {.what = "mesh"};
    status = sphi_mesh_make(context, &source, nodes, x, cells, corner, edges, ends, tags,
                            FLUME_TAGS, names, out);
  } else {
    status = SPHI_ERROR(context, SPH_E_MEMORY, "mesh: no memory for %" PRId64 " cells", cells);
  }
  sphi_free(context, x);
  sphi_free(context, corner);
  sphi_free(context, ends);
  sphi_free(context, tags);
  return status;
}

static sph_status check_flume(sph_context *context, double from, double to, double top, int columns,
                              int rows) {
  SPH_CHECK(context, isfinite(from) && isfinite(to) && from < to, SPH_E_ARGUMENT,
            "mesh: a flume must be from one place to another on its right, got %g to %g m", from,
            to);
  SPH_CHECK(context, isfinite(top), SPH_E_ARGUMENT, "mesh: the top must be finite, got %g m", top);
  SPH_CHECK(context,
            columns >= 1 && rows >= 1 &&
                2 * (int64_t)columns <= (int64_t)SPHI_MESH_MAX / 2 / ((int64_t)rows + 1),
            SPH_E_ARGUMENT,
            "mesh: columns and rows must be >= 1 and make at most %d cells, got %d and %d",
            SPHI_MESH_MAX / 2, columns, rows);
  return SPH_OK;
}

sph_status sph_mesh_create_flume(sph_context *context, double from, double to, double top,
                                 int columns, int rows, sph_mesh_profile bed, void *user,
                                 sph_mesh **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "mesh: out is NULL");
  SPH_TRY(check_flume(context, from, to, top, columns, rows));
  double *x = SPHI_NEW(context, 2 * ((int64_t)columns + 1), double);
  SPH_CHECK(context, x, SPH_E_MEMORY, "mesh: no memory for %d columns", columns);
  double *level = x + columns + 1;
  for (int i = 0; i <= columns; i++) {
    x[i] = i == columns ? to : from + i * ((to - from) / columns);
    level[i] = bed ? bed(x[i], user) : 0;
  }
  const flume f = {.x = x, .bed = level, .top = top, .columns = columns, .rows = rows};
  const sph_status status = make(context, &f, out);
  sphi_free(context, x);
  return status;
}

/* Level of a polyline at x between its ends. */
static double level_at(int vertices, const double *xy, double x) {
  int k = 1;
  while (k < vertices - 1 && xy[2 * k] < x) k++;
  const double *a = xy + 2 * (k - 1), *b = xy + 2 * k;
  const double share = (x - a[0]) / (b[0] - a[0]);
  return share <= 0 ? a[1] : share >= 1 ? b[1] : a[1] + share * (b[1] - a[1]);
}

static sph_status check_vertices(sph_context *context, int vertices, const double *xy,
                                 int columns) {
  SPH_CHECK(context, vertices >= 2 && vertices <= columns + 1, SPH_E_ARGUMENT,
            "mesh: the bed must have 2 vertices to one a column, %d, got %d", columns + 1,
            vertices);
  for (int k = 0; k < vertices; k++) {
    SPH_CHECK(context, sphi_finite(2, xy + 2 * k), SPH_E_ARGUMENT,
              "mesh: vertex %d of the bed is not finite", k);
    SPH_CHECK(context, k == 0 || xy[2 * k] > xy[2 * k - 2], SPH_E_ARGUMENT,
              "mesh: vertex %d of the bed, at x = %g m, must be right of the one before, at %g m",
              k, xy[2 * k], k ? xy[2 * k - 2] : 0.0);
  }
  return SPH_OK;
}

sph_status sph_mesh_create_flume_polyline(sph_context *context, int vertices, const double *xy,
                                          double top, int columns, int rows, sph_mesh **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, xy && out, SPH_E_ARGUMENT, "mesh: %s is NULL", xy ? "out" : "xy");
  SPH_CHECK(context, columns >= 1 && rows >= 1, SPH_E_ARGUMENT,
            "mesh: columns and rows must be >= 1, got %d and %d", columns, rows);
  SPH_TRY(check_vertices(context, vertices, xy, columns));
  const double from = xy[0], to = xy[2 * (vertices - 1)], width = (to - from) / columns;
  SPH_TRY(check_flume(context, from, to, top, columns, rows));
  double *x = SPHI_NEW(context, 2 * ((int64_t)columns + 1), double);
  SPH_CHECK(context, x, SPH_E_MEMORY, "mesh: no memory for %d columns", columns);
  double *level = x + columns + 1;
  for (int i = 0; i <= columns; i++) x[i] = i == columns ? to : from + i * width;
  sph_status status = SPH_OK;
  for (int k = 1, before = 0; k < vertices - 1 && status == SPH_OK; k++) {
    const int i = (int)floor((xy[2 * k] - from) / width + 0.5);
    if (i <= before || i >= columns)
      status = SPHI_ERROR(context, SPH_E_ARGUMENT,
                          "mesh: vertex %d of the bed, at x = %g m, and its neighbour are within a "
                          "column of %g m",
                          k, xy[2 * k], width);
    else
      x[i] = xy[2 * k];
    before = i;
  }
  for (int i = 0; i <= columns; i++) level[i] = level_at(vertices, xy, x[i]);
  const flume f = {.x = x, .bed = level, .top = top, .columns = columns, .rows = rows};
  if (status == SPH_OK) status = make(context, &f, out);
  sphi_free(context, x);
  return status;
}
