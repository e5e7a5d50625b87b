/* Where points are: walks over neighbours, a table of squares, feet on the boundary.
 *
 * The squares are those of the mesh at rest. A paddle's map is undone before they are looked at, so that
 * they hold however far it has moved. */
#include <inttypes.h>

#include "mesh/mesh_impl.h"

enum { MANY_STEPS = 4096, MOST_SQUARES = 1 << 26 };

/* Where what is at x now is at rest. */
static void undo_paddle(const sph_mesh *mesh, const double *x, double *rest) {
  rest[0] = x[0];
  rest[1] = x[1];
  if (!mesh->motion || mesh->displacement == 0 || x[0] >= mesh->first + mesh->reach) return;
  rest[0] = mesh->first +
            (x[0] - mesh->first - mesh->displacement) / (1 - mesh->displacement / mesh->reach);
}

static int32_t square_along(const sph_mesh *mesh, int d, double x) {
  const double k = floor((x - mesh->lo[d]) / mesh->side_of_square);
  return k < 0 ? 0 : k >= mesh->squares[d] ? mesh->squares[d] - 1 : (int32_t)k;
}

/* First and last squares of a cell's box. Within the cell that ends where the paddle's reach does the map is
 * not what moves its nodes, but is nowhere farther off than it is wide. */
static void box_of(const sph_mesh *mesh, int32_t c, int32_t *first, int32_t *last) {
  for (int d = 0; d < 2; d++) {
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    for (int k = 0; k < 3; k++) {
      const double at = mesh->rest[2 * (int64_t)mesh->corner[3 * (int64_t)c + k] + d];
      lo = fmin(lo, at);
      hi = fmax(hi, at);
    }
    const double end = mesh->first + mesh->reach, wide = hi - lo;
    const bool bent = d == 0 && mesh->motion && lo < end && hi > end;
    const double slack = bent ? wide : 1e-9 * wide;
    first[d] = square_along(mesh, d, lo - slack);
    last[d] = square_along(mesh, d, hi + slack);
  }
}

static void set_squares(sph_mesh *mesh) {
  double hi[2], area = 0;
  for (int d = 0; d < 2; d++) {
    mesh->lo[d] = HUGE_VAL;
    hi[d] = -HUGE_VAL;
    for (int32_t a = 0; a < mesh->nodes; a++) {
      mesh->lo[d] = fmin(mesh->lo[d], mesh->rest[2 * (int64_t)a + d]);
      hi[d] = fmax(hi[d], mesh->rest[2 * (int64_t)a + d]);
    }
  }
  const double wide = hi[0] - mesh->lo[0], high = hi[1] - mesh->lo[1];
  area = wide * high;
  /* About two cells to a square, but never many more squares than cells. */
  const double most = fmin(MOST_SQUARES, 4.0 * mesh->cells + 16);
  mesh->side_of_square = sqrt(2 * area / mesh->cells);
  while ((wide / mesh->side_of_square + 1) * (high / mesh->side_of_square + 1) > most)
    mesh->side_of_square *= 2;
  mesh->squares[0] = (int32_t)(wide / mesh->side_of_square) + 1;
  mesh->squares[1] = (int32_t)(high / mesh->side_of_square) + 1;
}

sph_status sphi_mesh_prepare(sph_mesh *mesh) {
  if (mesh->squares_made) return SPH_OK;
  sph_context *context = mesh->context;
  sphi_free(context, mesh->square_start);
  sphi_free(context, mesh->square_cell);
  mesh->square_cell = NULL;
  set_squares(mesh);
  const int64_t count = (int64_t)mesh->squares[0] * mesh->squares[1];
  mesh->square_start = SPHI_NEW(context, count + 1, int64_t);
  SPH_CHECK(context, mesh->square_start, SPH_E_MEMORY, "mesh: no memory for %" PRId64 " squares",
            count);
  /* Counts, then starts, then cells from the last down, which makes them ascend in each square. */
  for (int pass = 0; pass < 2; pass++) {
    for (int32_t k = 0; k < mesh->cells; k++) {
      const int32_t c = mesh->cells - 1 - k;
      int32_t first[2], last[2];
      box_of(mesh, c, first, last);
      for (int32_t j = first[1]; j <= last[1]; j++)
        for (int32_t i = first[0]; i <= last[0]; i++) {
          int64_t *start = &mesh->square_start[(int64_t)j * mesh->squares[0] + i];
          if (pass == 0)
            ++*start;
          else
            mesh->square_cell[--*start] = c;
        }
    }
    if (pass == 1) break;
    for (int64_t k = 0; k < count; k++)
      mesh->square_start[k] += k > 0 ? mesh->square_start[k - 1] : 0;
    mesh->square_start[count] = mesh->square_start[count - 1];
    mesh->square_cell = SPHI_NEW(context, mesh->square_start[count], int32_t);
    SPH_CHECK(context, mesh->square_cell, SPH_E_MEMORY,
              "mesh: no memory for %" PRId64 " cells in squares", mesh->square_start[count]);
  }
  mesh->squares_made = true;
  return SPH_OK;
}

/* The cell of lowest number with the point, by the squares. */
static int32_t look_up(const sph_mesh *mesh, const double *x) {
  double rest[2], share[3];
  undo_paddle(mesh, x, rest);
  const int64_t square =
      (int64_t)square_along(mesh, 1, rest[1]) * mesh->squares[0] + square_along(mesh, 0, rest[0]);
  for (int64_t k = mesh->square_start[square]; k < mesh->square_start[square + 1]; k++) {
    const int32_t c = mesh->square_cell[k];
    sphi_mesh_coordinates(mesh, c, x, share);
    if (fmin(share[0], fmin(share[1], share[2])) >= -SPHI_MESH_EDGE) return c;
  }
  return -1;
}

/* Goes over the edge that the point is farthest beyond; on the boundary over the other one that it is beyond,
 * if there is one. */
int32_t sphi_mesh_walk(const sph_mesh *mesh, const double *x, int32_t cell, int32_t *stopped_by) {
  for (int step = 0; cell >= 0 && step < MANY_STEPS; step++) {
    double share[3], least = -SPHI_MESH_EDGE;
    sphi_mesh_coordinates(mesh, cell, x, share);
    int over = -1;
    bool outside = false;
    for (int k = 0; k < 3; k++) {
      if (share[k] >= -SPHI_MESH_EDGE) continue;
      const int32_t beyond = mesh->neighbour[3 * (int64_t)cell + k];
      outside = true;
      if (beyond < 0)
        *stopped_by = -1 - beyond;
      else if (share[k] < least) {
        least = share[k];
        over = k;
      }
    }
    if (!outside) return cell;
    if (over < 0) break;
    cell = mesh->neighbour[3 * (int64_t)cell + over];
  }
  return look_up(mesh, x);
}

/* Nearest point of an edge; its place along it, 0 to 1, and the square of the distance. */
static double foot_on(const sph_mesh *mesh, const double *x, int32_t edge, double *foot,
                      double *place) {
  const double *a = mesh->x + 2 * (int64_t)mesh->ends[2 * (int64_t)edge];
  const double *b = mesh->x + 2 * (int64_t)mesh->ends[2 * (int64_t)edge + 1];
  const double dx = b[0] - a[0], dy = b[1] - a[1];
  const double s = ((x[0] - a[0]) * dx + (x[1] - a[1]) * dy) / (dx * dx + dy * dy);
  *place = s < 0 ? 0 : s > 1 ? 1 : s;
  foot[0] = a[0] + *place * dx;
  foot[1] = a[1] + *place * dy;
  return (x[0] - foot[0]) * (x[0] - foot[0]) + (x[1] - foot[1]) * (x[1] - foot[1]);
}

int32_t sphi_mesh_foot(const sph_mesh *mesh, const double *x, int32_t edge, double *foot) {
  double place, distance2 = foot_on(mesh, x, edge, foot, &place);
  for (int step = 0; step < MANY_STEPS && (place == 0 || place == 1); step++) {
    const int32_t to = place == 0 ? mesh->last[edge] : mesh->next[edge];
    double other[2], there;
    const double other2 = foot_on(mesh, x, to, other, &there);
    if (!(other2 < distance2)) break;
    distance2 = other2;
    edge = to;
    place = there;
    foot[0] = other[0];
    foot[1] = other[1];
  }
  return edge;
}

sph_status sph_mesh_locate(sph_mesh *mesh, int64_t count, const double *x, int32_t *cells) {
  if (!mesh) return SPH_E_ARGUMENT;
  sph_context *context = mesh->context;
  SPH_CHECK(context, count >= 0, SPH_E_ARGUMENT, "mesh: count must be >= 0, got %" PRId64, count);
  SPH_CHECK(context, count == 0 || (x && cells), SPH_E_ARGUMENT, "mesh: %s is NULL",
            x ? "cells" : "x");
  for (int64_t k = 0; k < count; k++)
    SPH_CHECK(context, sphi_finite(2, x + 2 * k), SPH_E_ARGUMENT,
              "mesh: point %" PRId64 " is not finite", k);
  SPH_TRY(sphi_mesh_prepare(mesh));
#pragma omp parallel for num_threads(context->threads) schedule(static) if (count > 4096)
  for (int64_t k = 0; k < count; k++) {
    const bool guess = cells[k] >= 0 && cells[k] < mesh->cells;
    int32_t unused = -1;
    int32_t found =
        guess ? sphi_mesh_walk(mesh, x + 2 * k, cells[k], &unused) : look_up(mesh, x + 2 * k);
    if (found >= 0 && guess) { /* on an edge others may have it too */
      double share[3];
      sphi_mesh_coordinates(mesh, found, x + 2 * k, share);
      if (fmin(share[0], fmin(share[1], share[2])) <= 4 * SPHI_MESH_EDGE)
        found = look_up(mesh, x + 2 * k);
    }
    cells[k] = found;
  }
  return SPH_OK;
}
