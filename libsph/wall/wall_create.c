/* Walls: the three ways to make one, and the checks of what the caller gave. */
#include "wall/wall_geometry.h"

static sph_status check_coordinates(sph_context *context, int64_t count, const double *values,
                                    const char *what) {
  for (int64_t k = 0; k < count; k++)
    SPH_CHECK(context, fabs(values[k]) <= SPHI_WALL_LARGEST, SPH_E_ARGUMENT,
              "wall: %s[%lld] must be finite and at most %g m, got %g m", what, (long long)k,
              SPHI_WALL_LARGEST, values[k]);
  return SPH_OK;
}

/* A wall with `facets` facets at zero. */
static sph_status wall_new(sph_context *context, int dim, int facets, sph_wall **out) {
  sph_wall *wall = SPHI_NEW(context, 1, sph_wall);
  if (!wall) goto fail;
  wall->context = context;
  wall->references = 1;
  wall->dim = dim;
  wall->facets = facets;
  wall->name = sphi_copy_text(context, "wall");
  wall->facet = SPHI_NEW(context, facets, sphi_wall_facet);
  if (!wall->name || !wall->facet) goto fail;
  for (int k = 0; k < facets; k++) wall->facet[k].link[0] = wall->facet[k].link[1] = -1;
  sphi_context_retain(context);
  *out = wall;
  return SPH_OK;
fail:
  if (wall) {
    sphi_free(context, wall->name);
    sphi_free(context, wall->facet);
    sphi_free(context, wall);
  }
  return SPHI_ERROR(context, SPH_E_MEMORY, "wall: no memory for %d facets", facets);
}

static double cross_2d(const double *o, const double *a, const double *b) {
  return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

static double gap_to_segment(const double *x, const double *a, const double *b) {
  const double ab[2] = {b[0] - a[0], b[1] - a[1]};
  double t = ((x[0] - a[0]) * ab[0] + (x[1] - a[1]) * ab[1]) / (ab[0] * ab[0] + ab[1] * ab[1]);
  t = fmin(1, fmax(0, t));
  return hypot(x[0] - a[0] - t * ab[0], x[1] - a[1] - t * ab[1]);
}

static bool segments_meet(const sphi_wall_facet *f, const sphi_wall_facet *g, double tolerance) {
  const double *a = f->corner[0], *b = f->corner[1], *c = g->corner[0], *d = g->corner[1];
  if (gap_to_segment(a, c, d) <= tolerance || gap_to_segment(b, c, d) <= tolerance ||
      gap_to_segment(c, a, b) <= tolerance || gap_to_segment(d, a, b) <= tolerance)
    return true;
  return (cross_2d(a, b, c) > 0) != (cross_2d(a, b, d) > 0) &&
         (cross_2d(c, d, a) > 0) != (cross_2d(c, d, b) > 0);
}

typedef struct meeting {
  const sph_wall *wall;
  double tolerance;
  int facet, other; /* other: -1 until found */
} meeting;

static bool visit_meeting(void *state, int other) {
  meeting *m = state;
  const sphi_wall_facet *facet = &m->wall->facet[m->facet];
  if (other <= m->facet || facet->link[0] == other || facet->link[1] == other) return true;
  if (!segments_meet(facet, &m->wall->facet[other], m->tolerance)) return true;
  m->other = other;
  return false;
}

static sph_status check_no_meeting(const sph_wall *wall) {
  meeting m = {wall, 1e-12 * wall->size, 0, -1};
  for (m.facet = 0; m.facet < wall->facets; m.facet++) {
    const sphi_wall_facet *facet = &wall->facet[m.facet];
    double lo[3], hi[3];
    for (int d = 0; d < 3; d++) {
      lo[d] = fmin(facet->corner[0][d], facet->corner[1][d]) - m.tolerance;
      hi[d] = fmax(facet->corner[0][d], facet->corner[1][d]) + m.tolerance;
    }
    sphi_wall_overlapping(wall, lo, hi, visit_meeting, &m);
    if (m.other >= 0) {
      const double *a = facet->corner[0], *b = facet->corner[1];
      const double *c = wall->facet[m.other].corner[0], *e = wall->facet[m.other].corner[1];
      return SPHI_ERROR(
          wall->context, SPH_E_ARGUMENT,
          "wall: segments %d (%g, %g)-(%g, %g) and %d (%g, %g)-(%g, %g) cross or touch; "
          "a polygon is given without repeating its first vertex, with closed = true",
          m.facet, a[0], a[1], b[0], b[1], m.other, c[0], c[1], e[0], e[1]);
    }
  }
  return SPH_OK;
}

static sph_status finish_polyline(sph_wall *wall) {
  SPH_TRY(sphi_wall_finish_facets(wall));
  SPH_TRY(sphi_wall_join_2d(wall));
  return check_no_meeting(wall);
}

sph_status sph_wall_create_polyline(sph_context *context, int vertices, const double *xy,
                                    bool closed, sph_wall **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, xy && out, SPH_E_ARGUMENT, "wall: %s must not be NULL", xy ? "out" : "xy");
  SPH_CHECK(context, vertices >= (closed ? 3 : 2), SPH_E_ARGUMENT,
            "wall: %s needs at least %d vertices, got %d",
            closed ? "a closed polyline" : "a polyline", closed ? 3 : 2, vertices);
  SPH_TRY(check_coordinates(context, 2 * (int64_t)vertices, xy, "xy"));
  const int facets = closed ? vertices : vertices - 1;
  for (int k = 0; k < facets; k++) {
    const int next = k + 1 < vertices ? k + 1 : 0;
    const double *a = xy + 2 * (int64_t)k, *b = xy + 2 * (int64_t)next;
    const double scale = fmax(fmax(fabs(a[0]), fabs(a[1])), fmax(fabs(b[0]), fabs(b[1])));
    SPH_CHECK(context, hypot(a[0] - b[0], a[1] - b[1]) > 1e-12 * scale, SPH_E_ARGUMENT,
              "wall: vertices %d and %d coincide at (%g, %g) m; give each vertex once", k, next,
              a[0], a[1]);
  }
  sph_wall *wall = NULL;
  SPH_TRY(wall_new(context, 2, facets, &wall));
  for (int k = 0; k < facets; k++) {
    const int next = k + 1 < vertices ? k + 1 : 0;
    sphi_wall_facet *facet = &wall->facet[k];
    memcpy(facet->corner[0], xy + 2 * (int64_t)k, 2 * sizeof *xy);
    memcpy(facet->corner[1], xy + 2 * (int64_t)next, 2 * sizeof *xy);
    facet->link[0] = k > 0 ? k - 1 : closed ? facets - 1 : -1;
    facet->link[1] = k + 1 < facets ? k + 1 : closed ? 0 : -1;
  }
  const sph_status status = finish_polyline(wall);
  if (status != SPH_OK) {
    sph_wall_destroy(&wall);
    return status;
  }
  *out = wall;
  return SPH_OK;
}

/* Bottom, right, top, left: counterclockwise, so the fluid is inside. */
static sph_status fill_box_2d(sph_wall *wall, const double *lo, const double *hi, unsigned open) {
  static const unsigned sides[4] = {SPH_SIDE_LO(1), SPH_SIDE_HI(0), SPH_SIDE_HI(1), SPH_SIDE_LO(0)};
  const double corner[4][2] = {{lo[0], lo[1]}, {hi[0], lo[1]}, {hi[0], hi[1]}, {lo[0], hi[1]}};
  int number[4], count = 0;
  for (int k = 0; k < 4; k++) number[k] = open & sides[k] ? -1 : count++;
  for (int k = 0; k < 4; k++) {
    if (number[k] < 0) continue;
    sphi_wall_facet *facet = &wall->facet[number[k]];
    memcpy(facet->corner[0], corner[k], sizeof corner[k]);
    memcpy(facet->corner[1], corner[(k + 1) % 4], sizeof corner[k]);
    facet->link[0] = number[(k + 3) % 4];
    facet->link[1] = number[(k + 1) % 4];
  }
  SPH_TRY(sphi_wall_finish_facets(wall));
  return sphi_wall_join_2d(wall);
}

static sph_status fill_box_3d(sph_wall *wall, const double *lo, const double *hi, unsigned open) {
  int count = 0;
  for (int side = 0; side < 6; side++) {
    if (open & 1u << side) continue;
    /* Around +d: (lo, lo) (hi, lo) (hi, hi) (lo, hi) in the two other directions. */
    const int d = side / 2, u = (d + 1) % 3, v = (d + 2) % 3, high = side % 2;
    sphi_wall_facet *facet = &wall->facet[count++];
    for (int k = 0; k < 4; k++) {
      const int turn = high ? (4 - k) % 4 : k;
      facet->corner[k][d] = high ? hi[d] : lo[d];
      facet->corner[k][u] = turn == 1 || turn == 2 ? hi[u] : lo[u];
      facet->corner[k][v] = turn >= 2 ? hi[v] : lo[v];
    }
  }
  SPH_TRY(sphi_wall_finish_facets(wall));
  return sphi_wall_join_3d(wall);
}

sph_status sph_wall_create_box(sph_context *context, int dim, const double *lo, const double *hi,
                               unsigned open_sides, sph_wall **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, lo && hi && out, SPH_E_ARGUMENT, "wall: %s must not be NULL",
            !lo   ? "lo"
            : !hi ? "hi"
                  : "out");
  SPH_CHECK(context, dim == 2 || dim == 3, SPH_E_ARGUMENT,
            "wall: dim of a box must be 2 or 3, got %d", dim);
  SPH_TRY(check_coordinates(context, dim, lo, "lo"));
  SPH_TRY(check_coordinates(context, dim, hi, "hi"));
  for (int d = 0; d < dim; d++)
    SPH_CHECK(context, hi[d] - lo[d] > 1e-12 * fmax(fabs(lo[d]), fabs(hi[d])), SPH_E_ARGUMENT,
              "wall: hi[%d] must be above lo[%d] = %g m, got %g m", d, d, lo[d], hi[d]);
  const unsigned all = (1u << (2 * dim)) - 1;
  SPH_CHECK(context, (open_sides & ~all) == 0, SPH_E_ARGUMENT,
            "wall: open_sides of a box in %dD must be made of 0x1 to 0x%x, got 0x%x", dim,
            1u << (2 * dim - 1), open_sides);
  SPH_CHECK(context, open_sides != all, SPH_E_ARGUMENT,
            "wall: open_sides 0x%x leaves no wall; keep at least one side", open_sides);
  int facets = 0;
  for (int side = 0; side < 2 * dim; side++) facets += !(open_sides & 1u << side);
  sph_wall *wall = NULL;
  SPH_TRY(wall_new(context, dim, facets, &wall));
  const sph_status status =
      dim == 2 ? fill_box_2d(wall, lo, hi, open_sides) : fill_box_3d(wall, lo, hi, open_sides);
  if (status != SPH_OK) {
    sph_wall_destroy(&wall);
    return status;
  }
  *out = wall;
  return SPH_OK;
}

/* Plane, convex, with some area: the normal comes from the diagonals. */
static sph_status check_facet(sph_context *context, int number, const double *corners) {
  double diagonal[2][3], normal[3], size = 0;
  sphi_subtract(corners + 6, corners, diagonal[0]);
  sphi_subtract(corners + 9, corners + 3, diagonal[1]);
  sphi_cross(diagonal[0], diagonal[1], normal);
  for (int a = 0; a < 4; a++)
    for (int b = 0; b < a; b++) size = fmax(size, sphi_gap(corners + 3 * a, corners + 3 * b));
  const double area2 = sphi_length(normal);
  SPH_CHECK(context, area2 > 1e-9 * size * size, SPH_E_ARGUMENT,
            "wall: facet %d is degenerate: area %g m^2 at a size of %g m", number, area2 / 2, size);
  for (int d = 0; d < 3; d++) normal[d] /= area2;
  for (int k = 0; k < 4; k++) {
    double before[3], after[3], turn[3], out_of_plane[3];
    const double *c = corners + 3 * k;
    sphi_subtract(c, corners + 3 * ((k + 3) % 4), before);
    sphi_subtract(corners + 3 * ((k + 1) % 4), c, after);
    for (int d = 0; d < 3; d++)
      out_of_plane[d] = c[d] - (corners[d] + corners[3 + d] + corners[6 + d] + corners[9 + d]) / 4;
    SPH_CHECK(context, fabs(sphi_dot(out_of_plane, normal)) <= 1e-6 * size, SPH_E_ARGUMENT,
              "wall: facet %d is not plane: corner %d is %g m off at a size of %g m; split it",
              number, k, fabs(sphi_dot(out_of_plane, normal)), size);
    sphi_cross(before, after, turn);
    SPH_CHECK(context, sphi_dot(turn, normal) > 1e-9 * size * size, SPH_E_ARGUMENT,
              "wall: facet %d is not convex at corner %d (%g, %g, %g) m; split it", number, k, c[0],
              c[1], c[2]);
  }
  return SPH_OK;
}

sph_status sph_wall_create_facets(sph_context *context, int facets, const double *corners,
                                  sph_wall **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, corners && out, SPH_E_ARGUMENT, "wall: %s must not be NULL",
            corners ? "out" : "corners");
  SPH_CHECK(context, facets >= 1, SPH_E_ARGUMENT, "wall: facets must be at least 1, got %d",
            facets);
  SPH_TRY(check_coordinates(context, 12 * (int64_t)facets, corners, "corners"));
  for (int k = 0; k < facets; k++) SPH_TRY(check_facet(context, k, corners + 12 * (int64_t)k));
  sph_wall *wall = NULL;
  SPH_TRY(wall_new(context, 3, facets, &wall));
  for (int k = 0; k < facets; k++)
    memcpy(wall->facet[k].corner, corners + 12 * (int64_t)k, sizeof wall->facet[k].corner);
  sph_status status = sphi_wall_finish_facets(wall);
  if (status == SPH_OK) status = sphi_wall_join_3d(wall);
  if (status != SPH_OK) {
    sph_wall_destroy(&wall);
    return status;
  }
  *out = wall;
  return SPH_OK;
}
