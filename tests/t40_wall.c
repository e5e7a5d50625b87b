/* Walls and their ghosts: lattices in tanks, corners of any angle, steps, obstacles, distances. */
#include "sph_test.h"

#include "wall/wall_impl.h" /* ghosts have no public name before a boundary owns them */

static const double pi = 3.14159265358979323846;
static sph_context *context;

static sph_wall *polyline(int vertices, const double *xy, bool closed) {
  sph_wall *wall = NULL;
  SPH_TEST_OK(context, sph_wall_create_polyline(context, vertices, xy, closed, &wall));
  return wall;
}

static sph_wall *box(int dim, const double *lo, const double *hi, unsigned open_sides) {
  sph_wall *wall = NULL;
  SPH_TEST_OK(context, sph_wall_create_box(context, dim, lo, hi, open_sides, &wall));
  return wall;
}

static sphi_ghost_points ghosts_of(const sph_wall *wall, double spacing, double depth) {
  sphi_ghost_points points = {0};
  SPH_TEST_OK(context, sphi_wall_make_ghosts(wall, spacing, depth, &points));
  return points;
}

static void finish(sph_wall *wall, sphi_ghost_points *points) {
  sphi_ghost_points_free(context, points);
  sph_wall_destroy(&wall);
  CU_ASSERT_PTR_NULL(wall);
}

static double sum(int64_t n, const double *values) {
  double total = 0;
  for (int64_t k = 0; k < n; k++) total += values[k];
  return total;
}

static double gap(int dim, const double *a, const double *b) {
  double square = 0;
  for (int d = 0; d < dim; d++) square += (a[d] - b[d]) * (a[d] - b[d]);
  return sqrt(square);
}

/* Of the ghosts that everybody sees. */
static double closest_pair(const sphi_ghost_points *p) {
  double best = INFINITY;
  for (int64_t i = 0; i < p->n; i++)
    for (int64_t j = 0; j < i; j++)
      if (p->gates[i] == 0 && p->gates[j] == 0)
        best = fmin(best, gap(p->dim, p->x + p->dim * i, p->x + p->dim * j));
  return best;
}

/* Distance to the line through the vertices, one segment after the other. */
static double line_distance(int vertices, const double *xy, bool closed, const double *x) {
  double best = INFINITY;
  for (int k = 0; k < vertices - !closed; k++) {
    const double *a = xy + 2 * k, *b = xy + 2 * ((k + 1) % vertices);
    const double length = gap(2, a, b), tx = (b[0] - a[0]) / length, ty = (b[1] - a[1]) / length;
    const double along = (x[0] - a[0]) * tx + (x[1] - a[1]) * ty;
    const double across = fabs((x[1] - a[1]) * tx - (x[0] - a[0]) * ty);
    best = fmin(best, along <= 0 ? gap(2, x, a) : along >= length ? gap(2, x, b) : across);
  }
  return best;
}

/* Winding number by angles: not 0 inside a polygon. */
static bool inside_polygon(int vertices, const double *xy, const double *x) {
  double angle = 0;
  for (int k = 0; k < vertices; k++) {
    const double *a = xy + 2 * k, *b = xy + 2 * ((k + 1) % vertices);
    const double ax = a[0] - x[0], ay = a[1] - x[1], bx = b[0] - x[0], by = b[1] - x[1];
    angle += atan2(ax * by - ay * bx, ax * bx + ay * by);
  }
  return fabs(angle) > pi;
}

/* What holds for every ghost: unit normal along x - foot, reflection or at least the same radius,
 * foot on the wall and nearest to the ghost, if it has no gates, and to its mirror, on the sides they
 * belong to. */
static void check_ghosts(const sph_wall *wall, const sphi_ghost_points *p, double spacing) {
  double worst_normal = 0, worst_radius = 0, worst_nearest = 0, worst_mirror = 0, worst_foot = 0;
  for (int64_t k = 0; k < p->n; k++) {
    const double *x = p->x + p->dim * k, *foot = p->foot + p->dim * k;
    const double *mirror = p->mirror + p->dim * k;
    double normal[3];
    sphi_ghost_normal(p, k, normal);
    const double s = gap(p->dim, x, foot);
    for (int d = 0; d < p->dim; d++)
      worst_normal = fmax(worst_normal, fabs(s * normal[d] - (x[d] - foot[d])));
    worst_radius = fmax(worst_radius, fabs(gap(p->dim, mirror, foot) - s));
    const double inside = -sphi_wall_distance(wall, x);
    worst_nearest = fmax(worst_nearest, p->gates[k] ? fmax(inside - s, -inside) : fabs(inside - s));
    worst_foot = fmax(worst_foot, fabs(sphi_wall_distance(wall, foot)));
    worst_mirror = fmax(worst_mirror, -sphi_wall_distance(wall, mirror));
    CU_ASSERT(p->volume[k] > 0);
    CU_ASSERT(p->area[k] >= 0 && (p->area[k] == 0 || !p->vertex[k]));
  }
  SPH_TEST_BELOW(worst_normal, 1e-9 * spacing);
  SPH_TEST_BELOW(worst_radius, 1e-9 * spacing);
  SPH_TEST_BELOW(worst_nearest, 1e-9 * spacing);
  SPH_TEST_BELOW(worst_foot, 1e-9 * spacing);
  SPH_TEST_BELOW(worst_mirror, 2e-9 * spacing);
}

/* All at (integer + 1/2) spacing, no two on one place but for those with gates. */
static void check_lattice(const sphi_ghost_points *p, double spacing) {
  double worst = 0;
  for (int64_t k = 0; k < p->n * p->dim; k++) {
    const double place = p->x[k] / spacing - 0.5;
    worst = fmax(worst, fabs(place - nearbyint(place)));
  }
  SPH_TEST_BELOW(worst, 1e-9);
  SPH_TEST_BELOW(spacing * (1 - 1e-9), closest_pair(p));
}

static bool sees(const sphi_ghost_points *p, int64_t k, const double *x) {
  double from_ghost[3] = {0};
  for (int d = 0; d < p->dim; d++) from_ghost[d] = x[d] - p->x[p->dim * k + d];
  return sphi_ghost_seen(p, k, from_ghost);
}

/* From random places in the fluid between lo and hi every place of the lattice that is in the solid and
 * no farther away than `reach` is seen once. */
static void check_views(const sph_wall *wall, const sphi_ghost_points *p, double spacing,
                        double reach, const double *lo, const double *hi) {
  const int dim = p->dim;
  uint64_t state = 5;
  int views = 0;
  for (int trial = 0; trial < (dim == 2 ? 1500 : 300); trial++) {
    double x[3] = {0};
    for (int d = 0; d < dim; d++) x[d] = lo[d] + (hi[d] - lo[d]) * sph_test_random(&state);
    if (sphi_wall_distance(wall, x) <= 0) continue;
    views++;
    int first[3] = {0, 0, 0}, size[3] = {1, 1, 1}, wrong = 0;
    for (int d = 0; d < dim; d++) {
      first[d] = (int)floor((x[d] - reach) / spacing);
      size[d] = (int)(2 * reach / spacing) + 2;
    }
    unsigned char seen[24 * 24 * 24] = {0};
    for (int64_t k = 0; k < p->n; k++) {
      if (gap(dim, x, p->x + dim * k) > reach || !sees(p, k, x)) continue;
      int at = 0;
      for (int d = dim - 1; d >= 0; d--)
        at = at * size[d] + (int)floor(p->x[dim * k + d] / spacing) - first[d];
      seen[at]++;
    }
    for (int at = 0; at < size[0] * size[1] * size[2]; at++) {
      const int cell[3] = {at % size[0], at / size[0] % size[1], at / size[0] / size[1]};
      double place[3];
      for (int d = 0; d < dim; d++) place[d] = (first[d] + cell[d] + 0.5) * spacing;
      const bool solid = gap(dim, x, place) <= reach && sphi_wall_distance(wall, place) < 0;
      wrong += seen[at] != solid;
    }
    CU_ASSERT_EQUAL(wrong, 0);
  }
  CU_ASSERT(views > 50);
}

static void box_2d_continues_the_lattice(void) {
  const double lo[] = {0, 0}, hi[] = {1, 0.5}, dx = 0.1;
  sph_wall *wall = box(2, lo, hi, SPH_SIDE_HI(1));
  sphi_ghost_points p = ghosts_of(wall, dx, 0.39);
  CU_ASSERT_EQUAL(p.n, 10 * 4 + 2 * 5 * 4 + 2 * 16);
  CU_ASSERT_EQUAL(p.skipped, 0);
  check_lattice(&p, dx);
  check_ghosts(wall, &p, dx);
  SPH_TEST_CLOSE(sum(p.n, p.volume), (double)p.n * dx * dx, 1e-12, 0);
  SPH_TEST_CLOSE(sum(p.n, p.area), 2.0, 1e-12, 0);
  int corners = 0;
  for (int64_t k = 0; k < p.n; k++) {
    const double *x = p.x + 2 * k, *m = p.mirror + 2 * k;
    /* Each coordinate that is outside is reflected on its own, which at 90 degrees is both. */
    const double side = x[0] < 0 ? -x[0] : x[0] > 1 ? 2 - x[0] : x[0];
    SPH_TEST_CLOSE(m[0], side, 0, 1e-12);
    SPH_TEST_CLOSE(m[1], x[1] < 0 ? -x[1] : x[1], 0, 1e-12);
    CU_ASSERT_EQUAL(p.vertex[k], (x[0] < 0 || x[0] > 1) && x[1] < 0);
    corners += p.vertex[k];
    CU_ASSERT((p.area[k] > 0) == (!p.vertex[k] && gap(2, x, p.foot + 2 * k) < 0.06));
  }
  CU_ASSERT_EQUAL(corners, 32);
  finish(wall, &p);

  const double tank[] = {0, 0.5, 0, 0, 1, 0, 1, 0.5};
  wall = polyline(4, tank, false);
  p = ghosts_of(wall, dx, 0.4); /* 4 layers exactly */
  CU_ASSERT_EQUAL(p.n, 112);
  check_lattice(&p, dx);
  check_ghosts(wall, &p, dx);
  finish(wall, &p);
}

static void wall_at_120_degrees(void) {
  const double dx = 0.05, rise = 0.5, lean = rise * tan(pi / 6), D = 4 * dx;
  const double xy[] = {0, 0, 10, 0, 10 + lean, rise};
  sph_wall *wall = polyline(3, xy, false);
  double normal[2];
  SPH_TEST_OK(context, sph_wall_facet_normal(wall, 1, normal));
  SPH_TEST_CLOSE(-normal[0], sqrt(3) / 2, 1e-12, 0);
  SPH_TEST_CLOSE(-normal[1], -0.5, 1e-12, 0);
  sphi_ghost_points p = ghosts_of(wall, dx, 3.9 * dx);
  check_ghosts(wall, &p, dx);
  CU_ASSERT_EQUAL(p.skipped, 0);
  const double slope = gap(2, xy + 2, xy + 4);
  SPH_TEST_CLOSE(sum(p.n, p.volume), (10 + slope) * D + pi / 3 / 2 * D * D, 1e-9, 0);
  SPH_TEST_CLOSE(sum(p.n, p.area), 10 + slope, 1e-12, 0);
  SPH_TEST_BELOW(0.5 * dx, closest_pair(&p));
  int64_t at[3][4] = {{0}};
  for (int64_t k = 0; k < p.n; k++) {
    const double *x = p.x + 2 * k, *m = p.mirror + 2 * k, *f = p.foot + 2 * k;
    CU_ASSERT(m[1] > 0 && (m[0] - 10) * normal[0] + m[1] * normal[1] > 0);
    const double layer = gap(2, x, f) / dx - 0.5;
    SPH_TEST_CLOSE(layer, nearbyint(layer), 0, 1e-9);
    CU_ASSERT(layer < 3.5);
    at[p.vertex[k] ? 2 : f[1] > 1e-12][(int)nearbyint(layer)]++;
    if (p.vertex[k]) {
      SPH_TEST_CLOSE(m[0] + x[0], 20, 1e-12, 0);
      SPH_TEST_CLOSE(m[1] + x[1], 0, 0, 1e-12);
    }
  }
  for (int k = 0; k < 4; k++) {
    CU_ASSERT_EQUAL(at[0][k], 200);
    CU_ASSERT_EQUAL(at[1][k], lround(slope / dx));
    CU_ASSERT_EQUAL(at[2][k], k == 0 ? 1 : lround((k + 0.5) * pi / 3));
  }
  finish(wall, &p);
}

static void step_is_filled_for_every_view(void) {
  const double dx = 0.05, D = 0.2;
  const double xy[] = {0, 1, 0, 0, 1, 0, 1, 0.3, 2, 0.3, 2, 1};
  sph_wall *wall = polyline(6, xy, false);
  sphi_ghost_points p = ghosts_of(wall, dx, D);
  check_lattice(&p, dx);
  check_ghosts(wall, &p, dx);
  CU_ASSERT_EQUAL(p.skipped, 0);
  const double lo[] = {0, 0}, hi[] = {2, 0.75};
  check_views(wall, &p, dx, D, lo, hi);
  /* Both strips are whole, and there is a third set behind the edge. */
  const double strips = (1 + 1 + 0.3 + 1 + 0.7) * D, corners = 3 * D * D;
  double nose = 0, volume = 0;
  int gated[3] = {0};
  for (int64_t k = 0; k < p.n; k++) {
    const double *x = p.x + 2 * k, *f = p.foot + 2 * k, *m = p.mirror + 2 * k;
    gated[p.gates[k]]++;
    if (p.gates[k] < 2) {
      volume += p.volume[k];
      if (!p.gates[k]) SPH_TEST_CLOSE(gap(2, x, f), line_distance(6, xy, false, x), 0, 1e-12);
      continue;
    }
    CU_ASSERT(p.vertex[k] && x[0] > 1 && x[1] < 0.3 && gap(2, x, f) < D + 1e-12);
    SPH_TEST_CLOSE(m[0] + x[0], 2, 1e-12, 0);
    SPH_TEST_CLOSE(m[1] + x[1], 0.6, 1e-12, 0);
    nose += p.volume[k];
  }
  SPH_TEST_CLOSE(volume, strips + corners, 1e-9, 0);
  SPH_TEST_CLOSE(sum(p.n, p.area), 4.0, 1e-12, 0);
  CU_ASSERT_EQUAL(gated[1], 2 * 16);
  SPH_TEST_CLOSE(nose, gated[2] * dx * dx, 1e-9, 0);
  CU_ASSERT_EQUAL(gated[2], 13); /* the middles within 4 dx of the vertex */
  finish(wall, &p);
}

static void corners_near_each_other_are_filled_for_every_view(void) {
  const double dx = 0.05, D = 4 * dx, lo[] = {0, 0}, hi[] = {2, 0.75};
  /* A step lower than the ghosts are deep, up and down. */
  const double low[] = {0, 1, 0, 0, 1, 0, 1, 0.1, 2, 0.1, 2, 1};
  const double down[] = {0, 1, 0, 0.1, 1, 0.1, 1, 0, 2, 0, 2, 1};
  /* A sill whose two edges are 5 spacings apart, and one of 1 spacing. */
  const double sill[] = {0, 1, 0, 0, 1, 0, 1, 0.35, 1.25, 0.35, 1.25, 0, 2, 0, 2, 1};
  const double post[] = {0, 1, 0, 0, 1, 0, 1, 0.4, 1.05, 0.4, 1.05, 0, 2, 0, 2, 1};
  const struct {
    int vertices;
    const double *xy;
  } basins[] = {{6, low}, {6, down}, {8, sill}, {8, post}};
  for (int k = 0; k < 4; k++) {
    sph_wall *wall = polyline(basins[k].vertices, basins[k].xy, false);
    sphi_ghost_points p = ghosts_of(wall, dx, D);
    check_lattice(&p, dx);
    check_ghosts(wall, &p, dx);
    check_views(wall, &p, dx, k == 3 ? dx : D, lo, hi);
    finish(wall, &p);
  }
  /* Obstacles with sides of 7, 12 and 2 spacings; cut into pieces the sides see the same. */
  const double square[] = {0, 0, 0, 0.7, 0.7, 0.7, 0.7, 0}, a[] = {-0.5, -0.5}, b[] = {1.2, 1.2};
  const double pieces[] = {0,   0,   0,   0.3, 0,   0.7, 0.1, 0.7, 0.5, 0.7, 0.7,
                           0.7, 0.7, 0.6, 0.7, 0.2, 0.7, 0,   0.6, 0,   0.2, 0};
  const double plate[] = {0, 0, 0, 0.2, 1.2, 0.2, 1.2, 0};
  for (int k = 0; k < 3; k++) {
    sph_wall *wall =
        k == 2 ? polyline(4, plate, true) : polyline(k ? 11 : 4, k ? pieces : square, true);
    sphi_ghost_points p = ghosts_of(wall, 0.1, 0.4);
    check_lattice(&p, 0.1);
    check_ghosts(wall, &p, 0.1);
    check_views(wall, &p, 0.1, k == 2 ? 0.2 : 0.4, a, b);
    SPH_TEST_CLOSE(sum(p.n, p.area), 2.8, 1e-12, 0);
    finish(wall, &p);
  }
}

/* A clockwise pentagon with angles of all kinds, no side a multiple of the spacing. */
static const double pentagon[] = {0.1, 0.2, 0.35, 1.07, 1.21, 1.33, 1.52, 0.41, 0.83, -0.13};

static void obstacle_strips_have_their_volumes(void) {
  const double dx = 0.04, D = 4 * dx;
  sph_wall *wall = polyline(5, pentagon, true);
  sphi_ghost_points p = ghosts_of(wall, dx, 3.9 * dx);
  check_ghosts(wall, &p, dx);
  double strips = 0, perimeter = 0, volume = 0;
  int sharp = 0;
  for (int k = 0; k < 5; k++) {
    const double *a = pentagon + 2 * k, *b = pentagon + 2 * ((k + 1) % 5),
                 *c = pentagon + 2 * ((k + 2) % 5);
    const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - b[0], vy = c[1] - b[1];
    const double turn = atan2(ux * vy - uy * vx, ux * vx + uy * vy);
    CU_ASSERT(turn < 0);
    perimeter += hypot(ux, uy);
    /* A blunt corner takes a triangle to its bisector from both strips, a sharp one what is outside. */
    const bool is_sharp = -turn > 80 * pi / 180;
    sharp += is_sharp;
    strips += hypot(ux, uy) * D - D * D * (is_sharp ? fmax(0, -1 / tan(-turn)) : tan(-turn / 2));
  }
  CU_ASSERT(sharp > 0 && sharp < 5);
  for (int64_t k = 0; k < p.n; k++) {
    const double *x = p.x + 2 * k;
    CU_ASSERT(inside_polygon(5, pentagon, x) && !inside_polygon(5, pentagon, p.mirror + 2 * k));
    if (!p.gates[k])
      SPH_TEST_CLOSE(gap(2, x, p.foot + 2 * k), line_distance(5, pentagon, true, x), 0, 1e-12);
    CU_ASSERT(!p.vertex[k] || p.gates[k] >= 2);
    if (!p.vertex[k]) volume += p.volume[k];
  }
  SPH_TEST_CLOSE(volume, strips, 1e-9, 0);
  SPH_TEST_CLOSE(sum(p.n, p.area), perimeter, 1e-12, 0);
  finish(wall, &p);
}

static void corner_of_60_degrees(void) {
  const double dx = 0.02, xy[] = {0.5, sqrt(3) / 2, 0, 0, 1, 0};
  sph_wall *wall = polyline(3, xy, false);
  sphi_ghost_points p = ghosts_of(wall, dx, 4 * dx);
  check_ghosts(wall, &p, dx);
  CU_ASSERT(p.skipped > 0);
  int corner = 0;
  double widest = 0, vertex_volume = 0;
  for (int64_t k = 0; k < p.n; k++) {
    const double *m = p.mirror + 2 * k, *x = p.x + 2 * k;
    CU_ASSERT(m[1] > -1e-12 && sqrt(3) * m[0] - m[1] > -1e-12);
    if (!p.vertex[k]) continue;
    corner++;
    vertex_volume += p.volume[k];
    /* phi about the outward bisector (210 degrees) becomes 0.9 phi 60/120 about the inward one. */
    const double from = atan2(-x[1], -x[0]) - pi / 6, to = atan2(m[1], m[0]) - pi / 6;
    SPH_TEST_CLOSE(to, 0.45 * from, 0, 1e-12);
    widest = fmax(widest, fabs(from));
  }
  CU_ASSERT_EQUAL(corner, 1 + 3 + 5 + 7);
  SPH_TEST_BELOW(0.8, widest);
  SPH_TEST_CLOSE(vertex_volume, 2 * pi / 3 / 2 * 16 * dx * dx, 1e-12, 0);
  finish(wall, &p);
}

static void box_3d_continues_the_lattice(void) {
  const double lo[] = {0, 0, 0}, hi[] = {0.5, 0.4, 0.3}, dx = 0.1;
  sph_wall *wall = box(3, lo, hi, 0);
  CU_ASSERT_EQUAL(sph_wall_facet_count(wall), 6);
  for (int k = 0; k < 6; k++) {
    double normal[3];
    SPH_TEST_OK(context, sph_wall_facet_normal(wall, k, normal));
    for (int d = 0; d < 3; d++) CU_ASSERT_EQUAL(normal[d], d == k / 2 ? (k % 2 ? -1 : 1) : 0);
  }
  sphi_ghost_points p = ghosts_of(wall, dx, 0.25);
  CU_ASSERT_EQUAL(p.n, 11 * 10 * 9 - 5 * 4 * 3);
  CU_ASSERT_EQUAL(p.skipped, 0);
  check_lattice(&p, dx);
  check_ghosts(wall, &p, dx);
  SPH_TEST_CLOSE(sum(p.n, p.area), 2 * (0.2 + 0.15 + 0.12), 1e-12, 0);
  SPH_TEST_CLOSE(sum(p.n, p.volume), (double)p.n * dx * dx * dx, 1e-12, 0);
  for (int64_t k = 0; k < p.n; k++) {
    int outside = 0;
    for (int d = 0; d < 3; d++) {
      const double x = p.x[3 * k + d], in = fmin(fmax(x, 0), hi[d]);
      outside += x != in;
      SPH_TEST_CLOSE(p.foot[3 * k + d], in, 0, 1e-12);
      SPH_TEST_CLOSE(p.mirror[3 * k + d], 2 * in - x, 0, 1e-12);
    }
    CU_ASSERT_EQUAL(p.vertex[k], outside > 1);
  }
  finish(wall, &p);

  wall = box(3, lo, hi, SPH_SIDE_HI(2));
  CU_ASSERT_EQUAL(sph_wall_facet_count(wall), 5);
  p = ghosts_of(wall, dx, 0.3);
  CU_ASSERT_EQUAL(p.n, 11 * 10 * 6 - 5 * 4 * 3);
  check_lattice(&p, dx);
  check_ghosts(wall, &p, dx);
  finish(wall, &p);
}

/* Six faces of the hexahedron over bottom[4] and top[4], both counterclockwise from above; normals
 * inwards, or outwards if `obstacle`. */
static void hexahedron(const double bottom[4][3], const double top[4][3], bool obstacle,
                       double faces[6][4][3]) {
  for (int k = 0; k < 4; k++) {
    const int n = (k + 1) % 4;
    memcpy(faces[0][k], bottom[k], 24);
    memcpy(faces[1][3 - k], top[k], 24);
    memcpy(faces[2 + k][0], bottom[n], 24);
    memcpy(faces[2 + k][1], bottom[k], 24);
    memcpy(faces[2 + k][2], top[k], 24);
    memcpy(faces[2 + k][3], top[n], 24);
  }
  for (int f = 0; obstacle && f < 6; f++)
    for (int k = 0; k < 2; k++)
      for (int d = 0; d < 3; d++) {
        const double kept = faces[f][k][d];
        faces[f][k][d] = faces[f][3 - k][d];
        faces[f][3 - k][d] = kept;
      }
}

static void facets_know_edges_and_corners(void) {
  const double bottom[4][3] = {{0, 0, 0}, {0.5, 0, 0}, {0.5, 0.4, 0}, {0, 0.4, 0}};
  const double top[4][3] = {{0, 0, 0.3}, {0.5, 0, 0.3}, {0.5, 0.4, 0.3}, {0, 0.4, 0.3}};
  double faces[6][4][3];
  hexahedron(bottom, top, false, faces);
  sph_wall *wall = NULL;
  SPH_TEST_OK(context, sph_wall_create_facets(context, 6, faces[0][0], &wall));
  sphi_ghost_points p = ghosts_of(wall, 0.1, 0.2);
  CU_ASSERT_EQUAL(p.n, 9 * 8 * 7 - 5 * 4 * 3);
  check_lattice(&p, 0.1);
  check_ghosts(wall, &p, 0.1);
  finish(wall, &p);

  hexahedron(bottom, top, true, faces);
  SPH_TEST_OK(context, sph_wall_create_facets(context, 6, faces[0][0], &wall));
  p = ghosts_of(wall, 0.1, 0.1);
  CU_ASSERT_EQUAL(p.n, 2 * (20 + 15 + 12) + 4 * (5 + 4 + 3) + 8); /* of facets, edges, corners */
  check_ghosts(wall, &p, 0.1);
  SPH_TEST_CLOSE(sum(p.n, p.area), 2 * (0.2 + 0.15 + 0.12), 1e-12, 0);
  for (int64_t k = 0; k < p.n; k++) CU_ASSERT((p.area[k] > 0) == !p.vertex[k]);
  finish(wall, &p);

  SPH_TEST_OK(context, sph_wall_create_facets(context, 6, faces[0][0], &wall));
  const double lo[] = {-0.3, -0.3, -0.3}, hi[] = {0.8, 0.7, 0.6};
  p = ghosts_of(wall, 0.1, 0.4); /* deeper than the box is high */
  check_lattice(&p, 0.1);
  check_ghosts(wall, &p, 0.1);
  check_views(wall, &p, 0.1, 0.3, lo, hi);
  finish(wall, &p);
}

static void quad(double face[4][3], int axis, double at, double a0, double b0, double a1, double b1,
                 bool up) {
  const double a[4] = {a0, a1, a1, a0}, b[4] = {b0, b0, b1, b1};
  for (int k = 0; k < 4; k++) {
    const int c = up ? k : 3 - k; /* counterclockwise from the axis' positive end */
    face[k][axis] = at;
    face[k][(axis + 1) % 3] = a[c];
    face[k][(axis + 2) % 3] = b[c];
  }
}

static void step_in_a_tank_in_3d(void) {
  /* 1 m long, 0.4 m wide, 0.6 m high, from x = 0.5 m on the bed is at 0.3 m. */
  double faces[12][4][3];
  quad(faces[0], 2, 0, 0, 0, 0.5, 0.4, true);
  quad(faces[1], 2, 0.3, 0.5, 0, 1, 0.4, true);
  quad(faces[2], 0, 0.5, 0, 0, 0.4, 0.3, false);
  quad(faces[3], 0, 0, 0, 0, 0.4, 0.3, true);
  quad(faces[4], 0, 0, 0, 0.3, 0.4, 0.6, true);
  quad(faces[5], 0, 1, 0, 0.3, 0.4, 0.6, false);
  for (int side = 0; side < 2; side++) {
    const double y = side ? 0.4 : 0;
    quad(faces[6 + side], 1, y, 0, 0, 0.3, 0.5, !side);
    quad(faces[8 + side], 1, y, 0.3, 0, 0.6, 0.5, !side);
    quad(faces[10 + side], 1, y, 0.3, 0.5, 0.6, 1, !side);
  }
  sph_wall *wall = NULL;
  SPH_TEST_OK(context, sph_wall_create_facets(context, 12, faces[0][0], &wall));
  sphi_ghost_points p = ghosts_of(wall, 0.1, 0.2);
  const double lo[] = {0, 0, 0}, hi[] = {1, 0.4, 0.4};
  check_lattice(&p, 0.1);
  check_ghosts(wall, &p, 0.1);
  check_views(wall, &p, 0.1, 0.2, lo, hi);
  finish(wall, &p);
}

static void leaning_wall_in_3d(void) {
  /* The tank with a wall at 120 degrees, 0.4 m wide: the section's ghosts, extruded, and behind the
   * side walls its corners. */
  const double lean = 0.5 * tan(pi / 6), dx = 0.05, D = 4 * dx;
  const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 0.4, 0}, {0, 0.4, 0}};
  const double top[4][3] = {{0, 0, 0.5}, {1 + lean, 0, 0.5}, {1 + lean, 0.4, 0.5}, {0, 0.4, 0.5}};
  double faces[6][4][3];
  hexahedron(bottom, top, false, faces);
  memcpy(faces[1], faces[5], sizeof faces[1]); /* open top */
  sph_wall *wall = NULL;
  SPH_TEST_OK(context, sph_wall_create_facets(context, 5, faces[0][0], &wall));
  sphi_ghost_points p = ghosts_of(wall, dx, D);
  check_ghosts(wall, &p, dx);
  const double slope = hypot(lean, 0.5), side = 0.5 * (1 + lean / 2);
  const double section = (0.5 + 1 + slope) * D + D * D + pi / 6 * D * D;
  SPH_TEST_CLOSE(sum(p.n, p.volume), section * (0.4 + 2 * D) + 2 * side * D, 1e-9, 0);
  SPH_TEST_CLOSE(sum(p.n, p.area), 0.4 * (0.5 + 1 + slope) + 2 * side, 1e-12, 0);
  CU_ASSERT_EQUAL(p.skipped, 0);
  finish(wall, &p);
}

static void distance_matches_brute_force(void) {
  /* A basin with a re-entrant spike, then the same line as an obstacle. */
  const double basin[] = {0,   0,   1.1, 0.1,  1.5, -0.3, 2,   0,    2.1,
                          1.4, 1.2, 1.3, 1.05, 0.3, 0.8,  1.5, -0.2, 1.1};
  double obstacle[18];
  for (int k = 0; k < 9; k++) memcpy(obstacle + 2 * k, basin + 2 * (8 - k), 2 * sizeof *basin);
  sph_wall *in = polyline(9, basin, true), *out = polyline(9, obstacle, true);
  uint64_t state = 7;
  for (int k = 0; k < 3000; k++) {
    const double x[2] = {-1 + 4 * sph_test_random(&state), -1 + 3.5 * sph_test_random(&state)};
    double found, reversed;
    SPH_TEST_OK(context, sph_wall_distance(in, 0, x, &found));
    SPH_TEST_OK(context, sph_wall_distance(out, 0, x, &reversed));
    const double size = line_distance(9, basin, true, x);
    SPH_TEST_CLOSE(found, inside_polygon(9, basin, x) ? size : -size, 1e-12, 1e-14);
    SPH_TEST_CLOSE(reversed, -found, 1e-12, 1e-14);
  }
  sph_wall_destroy(&in);
  sph_wall_destroy(&out);

  const double lo[] = {-1, 0, 2}, hi[] = {0, 0.5, 4};
  sph_wall *wall = box(3, lo, hi, 0);
  for (int k = 0; k < 3000; k++) {
    double x[3], inner = INFINITY, outer = 0, found;
    for (int d = 0; d < 3; d++) {
      x[d] = lo[d] + (hi[d] - lo[d]) * (-0.5 + 2 * sph_test_random(&state));
      const double depth = fmin(x[d] - lo[d], hi[d] - x[d]);
      inner = fmin(inner, depth);
      outer += depth < 0 ? depth * depth : 0;
    }
    SPH_TEST_OK(context, sph_wall_distance(wall, 0, x, &found));
    SPH_TEST_CLOSE(found, outer > 0 ? -sqrt(outer) : inner, 1e-12, 1e-14);
  }
  sph_wall_destroy(&wall);
}

static void distance_sign_at_mixed_corners(void) {
  /* The floor around a sharp pyramid stump: random points above and in it. */
  const double b[4][3] = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};
  const double t[4][3] = {{-0.1, -0.1, 1}, {0.1, -0.1, 1}, {0.1, 0.1, 1}, {-0.1, 0.1, 1}};
  double faces[9][4][3], stump[6][4][3];
  hexahedron(b, t, true, stump);
  memcpy(faces, stump[1], 5 * sizeof stump[0]);
  for (int k = 0; k < 4; k++) { /* four trapezia of floor out to 2 m */
    const int n = (k + 1) % 4;
    for (int d = 0; d < 3; d++) {
      faces[5 + k][0][d] = 4 * b[k][d];
      faces[5 + k][1][d] = 4 * b[n][d];
      faces[5 + k][2][d] = b[n][d];
      faces[5 + k][3][d] = b[k][d];
    }
  }
  sph_wall *wall = NULL;
  SPH_TEST_OK(context, sph_wall_create_facets(context, 9, faces[0][0], &wall));
  uint64_t state = 11;
  int solid = 0;
  for (int k = 0; k < 4000; k++) {
    const double x[3] = {-1 + 2 * sph_test_random(&state), -1 + 2 * sph_test_random(&state),
                         -0.6 + 2 * sph_test_random(&state)};
    const double half = 0.5 - 0.4 * x[2];
    const bool inside = x[2] < 0 || (x[2] < 1 && fabs(x[0]) < half && fabs(x[1]) < half);
    double distance;
    SPH_TEST_OK(context, sph_wall_distance(wall, 0, x, &distance));
    CU_ASSERT((distance < 0) == inside);
    solid += inside;
  }
  CU_ASSERT(solid > 1000 && solid < 3000);
  sphi_ghost_points p = ghosts_of(wall, 0.1, 0.3);
  check_ghosts(wall, &p, 0.1);
  finish(wall, &p);
}

static void rotation_turns_the_ghosts(void) {
  const double xy[] = {0, 1, 0, 0, 1, 0, 1, 0.3, 1.7, 0.3, 2, 1}, angle = 0.7371, dx = 0.05;
  double turned[12];
  const double c = cos(angle), s = sin(angle);
  for (int k = 0; k < 6; k++) {
    turned[2 * k] = c * xy[2 * k] - s * xy[2 * k + 1] + 3;
    turned[2 * k + 1] = s * xy[2 * k] + c * xy[2 * k + 1] - 5;
  }
  sph_wall *a = polyline(6, xy, false), *b = polyline(6, turned, false);
  sphi_ghost_points p = ghosts_of(a, dx, 0.2), q = ghosts_of(b, dx, 0.2);
  CU_ASSERT_EQUAL_FATAL(p.n, q.n);
  CU_ASSERT_EQUAL(p.skipped, q.skipped);
  double worst = 0;
  for (int64_t k = 0; k < p.n; k++) {
    const double *const from[] = {p.x + 2 * k, p.mirror + 2 * k, p.foot + 2 * k};
    const double *const to[] = {q.x + 2 * k, q.mirror + 2 * k, q.foot + 2 * k};
    for (int j = 0; j < 3; j++) {
      worst = fmax(worst, fabs(c * from[j][0] - s * from[j][1] + 3 - to[j][0]));
      worst = fmax(worst, fabs(s * from[j][0] + c * from[j][1] - 5 - to[j][1]));
    }
    worst = fmax(worst, fabs(p.volume[k] - q.volume[k]) / dx);
    worst = fmax(worst, fabs(p.area[k] - q.area[k]));
    CU_ASSERT_EQUAL(p.vertex[k], q.vertex[k]);
  }
  SPH_TEST_BELOW(worst, 1e-12);
  sphi_ghost_points_free(context, &q);
  sph_wall_destroy(&b);
  finish(a, &p);
}

static void thin_gaps_and_thin_solids(void) {
  /* A channel narrower than the ghosts are deep: mirrors beyond the other side are left out. */
  const double lo[] = {0, 0}, hi[] = {1, 0.12}, dx = 0.05;
  sph_wall *wall = box(2, lo, hi, SPH_SIDE_LO(0) | SPH_SIDE_HI(0));
  double ends[2 * SPHI_WALL_MAX_ENDS];
  CU_ASSERT_EQUAL(sphi_wall_open_ends(wall, ends), 4);
  sphi_ghost_points p = ghosts_of(wall, dx, 0.2);
  CU_ASSERT_EQUAL(p.n, 2 * 20 * 2);
  CU_ASSERT_EQUAL(p.skipped, 2 * 20 * 2);
  check_ghosts(wall, &p, dx);
  finish(wall, &p);
  /* A plate thinner than the ghosts are deep: each side has all of it, nothing beyond. */
  const double plate[] = {0, 0, 0, 0.1, 1, 0.1, 1, 0};
  wall = polyline(4, plate, true);
  p = ghosts_of(wall, dx, 0.2);
  int strips = 0;
  for (int64_t k = 0; k < p.n; k++) strips += !p.vertex[k];
  CU_ASSERT_EQUAL(strips, 2 * 20 * 2 + 2 * 2 * 4);
  CU_ASSERT(p.skipped > 0);
  SPH_TEST_CLOSE(sum(p.n, p.area), 2.2, 1e-12, 0);
  check_ghosts(wall, &p, dx);
  finish(wall, &p);
}

static void ten_thousand_segments(void) {
  enum { N = 10000 };
  static double xy[2 * N];
  for (int side = 0; side < 2; side++) { /* basin, then obstacle */
    for (int k = 0; k < N; k++) {
      const double angle = (side ? -1 : 1) * 2 * pi * k / N;
      xy[2 * k] = cos(angle);
      xy[2 * k + 1] = sin(angle);
    }
    sph_wall *wall = polyline(N, xy, true);
    const double dx = 4 * pi / N, D = 3 * dx, sign = side ? -1 : 1;
    sphi_ghost_points p = ghosts_of(wall, dx, D);
    SPH_TEST_CLOSE(sum(p.n, p.volume), pi * D * (2 + sign * D), 1e-6, 0);
    SPH_TEST_CLOSE(sum(p.n, p.area), 2 * pi, 1e-6, 0);
    CU_ASSERT_EQUAL(p.n, side ? 3 * N : 6 * N);
    finish(wall, &p);
  }
}

static void coarse_circle_is_not_overfilled(void) {
  /* Behind the sides of a round pile the solid narrows, and the ghosts' volumes with it. */
  double xy[48];
  for (int k = 0; k < 24; k++) {
    xy[2 * k] = cos(-2 * pi * k / 24);
    xy[2 * k + 1] = sin(-2 * pi * k / 24);
  }
  sph_wall *wall = polyline(24, xy, true);
  const double dx = 0.25, inner = cos(pi / 24) - 3 * dx, outer = cos(pi / 24);
  sphi_ghost_points p = ghosts_of(wall, dx, 3 * dx);
  SPH_TEST_CLOSE(sum(p.n, p.volume), 24 * tan(pi / 24) * (outer * outer - inner * inner), 1e-9, 0);
  finish(wall, &p);
}

static void swing(double t, double *displacement, double *velocity, double *acceleration,
                  void *user) {
  const double a = *(const double *)user;
  displacement[0] = a * sin(t);
  velocity[0] = a * cos(t);
  acceleration[0] = -a * sin(t);
}

static void motion_moves_the_wall(void) {
  const double lo[] = {0, 0}, hi[] = {1, 1}, x[] = {0.1, 0.5}, outside[] = {-0.1, 0.5};
  double amplitude = 0.2, distance;
  sphi_wall_state now;
  sph_wall *wall = box(2, lo, hi, 0);
  CU_ASSERT(!sphi_wall_moves(wall));
  SPH_TEST_OK(context, sphi_wall_state_at(wall, 3, &now));
  for (int d = 0; d < 2; d++)
    CU_ASSERT(now.displacement[d] == 0 && now.velocity[d] == 0 && now.acceleration[d] == 0);
  SPH_TEST_OK(context, sph_wall_set_motion(wall, swing, &amplitude));
  CU_ASSERT(sphi_wall_moves(wall));
  SPH_TEST_OK(context, sph_wall_distance(wall, pi / 2, x, &distance));
  SPH_TEST_CLOSE(distance, -0.1, 1e-12, 0);
  SPH_TEST_OK(context, sph_wall_distance(wall, -pi / 2, outside, &distance));
  SPH_TEST_CLOSE(distance, 0.1, 1e-12, 0);
  SPH_TEST_OK(context, sphi_wall_state_at(wall, 0.3, &now));
  SPH_TEST_CLOSE(now.displacement[0], 0.2 * sin(0.3), 1e-15, 0);
  SPH_TEST_CLOSE(now.velocity[0], 0.2 * cos(0.3), 1e-15, 0);
  SPH_TEST_CLOSE(now.acceleration[0], -0.2 * sin(0.3), 1e-15, 0);
  CU_ASSERT(now.displacement[1] == 0 && now.velocity[1] == 0 && now.acceleration[1] == 0);
  amplitude = NAN;
  distance = 7;
  SPH_TEST_STATUS(context, sph_wall_distance(wall, 1, x, &distance), SPH_E_ARGUMENT,
                  "displacement[0] from its motion must be finite at t = 1 s");
  CU_ASSERT_EQUAL(distance, 7);
  amplitude = 1e150;
  SPH_TEST_STATUS(context, sph_wall_distance(wall, 1, x, &distance), SPH_E_ARGUMENT, "too large");
  SPH_TEST_OK(context, sph_wall_set_motion(wall, NULL, NULL));
  SPH_TEST_OK(context, sph_wall_distance(wall, 1, x, &distance));
  SPH_TEST_CLOSE(distance, 0.1, 1e-12, 0);
  sph_wall_destroy(&wall);
}

static void tilt(double t, double *angle, double *rate, double *acceleration, void *user) {
  const double a = *(const double *)user;
  *angle = a * sin(2 * t);
  *rate = 2 * a * cos(2 * t);
  *acceleration = -4 * a * sin(2 * t);
}

/* A point that rides with a wall in both motions: its velocity and acceleration by central differences of
 * its place, and back to where it came from. */
static void rotation_carries_points(void) {
  double amplitude = 0.7, shift = 0.2;
  const double xy[] = {0, 1, 0, 0}, corners[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const double pivot[] = {0.1, -0.2, 0.3}, axis[] = {1, -2, 0.5}, point[] = {0.4, 0.8, -0.6};
  for (int dim = 2; dim <= 3; dim++) {
    sph_wall *wall = NULL;
    if (dim == 2)
      wall = polyline(2, xy, false);
    else
      SPH_TEST_OK(context, sph_wall_create_facets(context, 1, corners, &wall));
    SPH_TEST_OK(context,
                sph_wall_set_rotation(wall, pivot, dim == 2 ? NULL : axis, tilt, &amplitude));
    CU_ASSERT(sphi_wall_moves(wall));
    SPH_TEST_OK(context, sph_wall_set_motion(wall, swing, &shift));
    const double t = 0.4, dt = 1e-3;
    double at[5][3], v[3], a[3], back[3];
    sphi_wall_state now;
    for (int k = 0; k < 5; k++) {
      SPH_TEST_OK(context, sphi_wall_state_at(wall, t + (k - 2) * dt, &now));
      sphi_wall_place(&now, dim, point, at[k]);
    }
    SPH_TEST_OK(context, sphi_wall_state_at(wall, t, &now));
    sphi_wall_velocity_at(&now, dim, at[2], v, a);
    sphi_wall_refer(&now, dim, at[2], back);
    for (int d = 0; d < dim; d++) {
      const double slope = (at[0][d] - 8 * at[1][d] + 8 * at[3][d] - at[4][d]) / (12 * dt);
      const double bend =
          (-at[0][d] + 16 * at[1][d] - 30 * at[2][d] + 16 * at[3][d] - at[4][d]) / (12 * dt * dt);
      SPH_TEST_CLOSE(v[d], slope, 1e-10, 0);
      SPH_TEST_CLOSE(a[d], bend, 1e-7, 0);
      SPH_TEST_CLOSE(back[d], point[d], 1e-15, 0);
    }
    sph_wall_destroy(&wall);
  }
  /* Counterclockwise by 30 degrees about the foot: what was vertical leans to the left. */
  sph_wall *flap = polyline(2, xy, false);
  const double foot[] = {0, 0}, x[] = {1, 0};
  double distance;
  amplitude = pi / 6;
  SPH_TEST_OK(context, sph_wall_set_rotation(flap, foot, NULL, tilt, &amplitude));
  SPH_TEST_OK(context, sph_wall_distance(flap, pi / 4, x, &distance));
  SPH_TEST_CLOSE(distance, 1, 1e-12, 0); /* its nearest point is the hinge */
  const double above[] = {1 - 0.5, sqrt(3) / 2};
  SPH_TEST_OK(context, sph_wall_distance(flap, pi / 4, above, &distance));
  SPH_TEST_CLOSE(distance, sqrt(3) / 2 * 1.0, 1e-12, 0);
  amplitude = NAN;
  SPH_TEST_STATUS(context, sph_wall_distance(flap, 1, x, &distance), SPH_E_ARGUMENT,
                  "angle, its rate and acceleration[0] from its motion must be finite");
  SPH_TEST_OK(context, sph_wall_set_rotation(flap, NULL, NULL, NULL, NULL));
  CU_ASSERT(!sphi_wall_moves(flap));
  sph_wall_destroy(&flap);
}

/* The point of a wall that was turned by an angle about the axis through the pivot, then displaced. */
static void carry(const double *pivot, const double *axis, double angle, const double *shift,
                  const double *from, double *to) {
  const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  double arm[3], unit[3], along = 0;
  for (int d = 0; d < 3; d++) {
    arm[d] = from[d] - pivot[d];
    unit[d] = axis[d] / length;
    along += arm[d] * unit[d];
  }
  for (int d = 0; d < 3; d++) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    const double round = unit[e] * arm[f] - unit[f] * arm[e];
    to[d] = pivot[d] + shift[d] + along * unit[d] + cos(angle) * (arm[d] - along * unit[d]) +
            sin(angle) * round;
  }
}

/* In 3D a wall that was displaced and turned is the wall that was created there. */
static void moved_walls_are_where_they_would_be_created(void) {
  const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 0.4, 0}, {0, 0.4, 0}};
  const double top[4][3] = {{0, 0, 0.5}, {1.3, 0, 0.5}, {1.3, 0.4, 0.5}, {0, 0.4, 0.5}};
  const double pivot[] = {0.1, -0.2, 0.3}, axis[] = {1, -2, 0.5}, t = 0.4;
  double amplitude = 0.9, shift = 0.2, at[4][3], above[4][3], faces[6][4][3];
  const double angle = amplitude * sin(2 * t), displaced[3] = {shift * sin(t), 0, 0};
  for (int k = 0; k < 4; k++) {
    carry(pivot, axis, angle, displaced, bottom[k], at[k]);
    carry(pivot, axis, angle, displaced, top[k], above[k]);
  }
  for (int obstacle = 0; obstacle < 2; obstacle++) {
    sph_wall *moved = NULL, *there = NULL;
    hexahedron(bottom, top, obstacle, faces);
    SPH_TEST_OK(context, sph_wall_create_facets(context, 6, faces[0][0], &moved));
    SPH_TEST_OK(context, sph_wall_set_rotation(moved, pivot, axis, tilt, &amplitude));
    SPH_TEST_OK(context, sph_wall_set_motion(moved, swing, &shift));
    hexahedron((const double(*)[3])at, (const double(*)[3])above, obstacle, faces);
    SPH_TEST_OK(context, sph_wall_create_facets(context, 6, faces[0][0], &there));
    uint64_t state = 3;
    int inside = 0;
    for (int k = 0; k < 3000; k++) {
      double x[3], found, expected;
      for (int d = 0; d < 3; d++) x[d] = -0.7 + 2.4 * sph_test_random(&state);
      SPH_TEST_OK(context, sph_wall_distance(moved, t, x, &found));
      SPH_TEST_OK(context, sph_wall_distance(there, 0, x, &expected));
      SPH_TEST_CLOSE(found, expected, 1e-12, 1e-14);
      inside += found > 0;
    }
    CU_ASSERT(inside > 50 && inside < 2950);
    sph_wall_destroy(&moved);
    sph_wall_destroy(&there);
  }
}

static sph_status drive(double t, double dt, const double *force, double *displacement,
                        double *velocity, double *acceleration, void *user) {
  (void)t;
  if (*(const double *)user < 0) return SPH_E_ARGUMENT;
  acceleration[0] = force[0] / *(const double *)user;
  displacement[0] += dt * velocity[0] + 0.5 * dt * dt * acceleration[0];
  velocity[0] += dt * acceleration[0];
  return SPH_OK;
}

static void driver_moves_the_wall(void) {
  const double xy[] = {0, 1, 0, 0}, force[] = {6, 0};
  double mass = 2;
  sph_wall *wall = polyline(2, xy, false);
  SPH_TEST_OK(context, sph_wall_set_driver(wall, drive, &mass));
  CU_ASSERT(sphi_wall_moves(wall) && sphi_wall_is_driven(wall));
  sphi_wall_state now;
  SPH_TEST_OK(context, sphi_wall_state_at(wall, 0, &now));
  CU_ASSERT(now.displacement[0] == 0 && now.velocity[0] == 0);
  for (int k = 0; k < 4; k++) SPH_TEST_OK(context, sphi_wall_drive(wall, 0.5 * k, 0.5, force));
  for (int k = 0; k <= 4; k++) {
    const double t = 1.5 + 0.125 * k;
    SPH_TEST_OK(context, sphi_wall_state_at(wall, t, &now));
    SPH_TEST_CLOSE(now.displacement[0], 1.5 * t * t, 1e-14, 0);
    SPH_TEST_CLOSE(now.velocity[0], 3 * t, 1e-14, 0);
    SPH_TEST_CLOSE(now.acceleration[0], 3, 1e-14, 0);
  }
  SPH_TEST_STATUS(context, sph_wall_set_motion(wall, swing, &mass), SPH_E_ARGUMENT, "has a driver");
  mass = -1;
  SPH_TEST_STATUS(context, sphi_wall_drive(wall, 2, 0.5, force), SPH_E_ARGUMENT,
                  "its driver stopped the run at t = 2 s");
  mass = NAN;
  SPH_TEST_STATUS(context, sphi_wall_drive(wall, 2, 0.5, force), SPH_E_ARGUMENT,
                  "displacement[0] from its motion must be finite at t = 2.5 s");
  sph_wall_destroy(&wall);
}

static void bad_motions_are_refused(void) {
  const double lo[] = {0, 0, 0}, hi[] = {1, 1, 1}, foot[] = {0, 0, 0}, up[] = {0, 0, 1};
  const double no_place[] = {0, NAN, 0}, far[] = {0, 1e101, 0};
  const double none[] = {0, 0, 0}, bad[] = {0, NAN, 1}, endless[] = {INFINITY, 0, 0};
  double amplitude = 0.1;
  for (int dim = 2; dim <= 3; dim++) {
    sph_wall *wall = box(dim, lo, hi, 0);
    SPH_TEST_STATUS(context, sph_wall_set_rotation(wall, NULL, up, tilt, &amplitude),
                    SPH_E_ARGUMENT, "wall \"wall\": pivot must not be NULL");
    SPH_TEST_STATUS(context, sph_wall_set_rotation(wall, no_place, up, tilt, &amplitude),
                    SPH_E_ARGUMENT, "pivot[1] must be finite");
    SPH_TEST_STATUS(context, sph_wall_set_rotation(wall, far, up, tilt, &amplitude), SPH_E_ARGUMENT,
                    "at most 1e+100 m, got 1e+101 m");
    CU_ASSERT(!sphi_wall_moves(wall));
    if (dim == 3) {
      SPH_TEST_STATUS(context, sph_wall_set_rotation(wall, foot, NULL, tilt, &amplitude),
                      SPH_E_ARGUMENT, "axis must not be NULL in 3D");
      SPH_TEST_STATUS(context, sph_wall_set_rotation(wall, foot, none, tilt, &amplitude),
                      SPH_E_ARGUMENT, "axis (0, 0, 0) must be finite and not zero");
      SPH_TEST_STATUS(context, sph_wall_set_rotation(wall, foot, bad, tilt, &amplitude),
                      SPH_E_ARGUMENT, "must be finite and not zero");
      SPH_TEST_STATUS(context, sph_wall_set_rotation(wall, foot, endless, tilt, &amplitude),
                      SPH_E_ARGUMENT, "axis (inf, 0, 0) must be finite");
      CU_ASSERT(!sphi_wall_moves(wall));
    } else { /* no axis is looked at in 2D */
      SPH_TEST_OK(context, sph_wall_set_rotation(wall, foot, bad, tilt, &amplitude));
      SPH_TEST_OK(context, sph_wall_set_rotation(wall, NULL, NULL, NULL, NULL));
    }
    /* A wall has one translation, prescribed or by a driver, and a rotation besides. */
    SPH_TEST_OK(context, sph_wall_set_motion(wall, swing, &amplitude));
    SPH_TEST_STATUS(context, sph_wall_set_driver(wall, drive, &amplitude), SPH_E_ARGUMENT,
                    "it has a prescribed motion");
    CU_ASSERT(!sphi_wall_is_driven(wall));
    SPH_TEST_OK(context, sph_wall_set_motion(wall, NULL, NULL));
    SPH_TEST_OK(context, sph_wall_set_driver(wall, drive, &amplitude));
    SPH_TEST_STATUS(context, sph_wall_set_motion(wall, swing, &amplitude), SPH_E_ARGUMENT,
                    "it has a driver");
    SPH_TEST_OK(context, sph_wall_set_motion(wall, NULL, NULL));
    SPH_TEST_OK(context, sph_wall_set_rotation(wall, foot, up, tilt, &amplitude));
    SPH_TEST_OK(context, sph_wall_set_driver(wall, NULL, NULL));
    CU_ASSERT(!sphi_wall_is_driven(wall));
    SPH_TEST_OK(context, sph_wall_set_motion(wall, swing, &amplitude));
    sph_wall_destroy(&wall);
  }
}

static void settings_and_references(void) {
  const double xy[] = {0, 1, 0, 0, 1, 0};
  sph_wall *wall = polyline(3, xy, false);
  double ends[2 * SPHI_WALL_MAX_ENDS];
  CU_ASSERT_EQUAL(sphi_wall_open_ends(wall, ends), 2);
  CU_ASSERT(ends[0] == 0 && ends[1] == 1 && ends[2] == 1 && ends[3] == 0);
  CU_ASSERT_STRING_EQUAL(sph_wall_name(wall), "wall");
  CU_ASSERT(!sphi_wall_no_slip(wall));
  SPH_TEST_OK(context, sph_wall_set_name(wall, "tank"));
  SPH_TEST_OK(context, sph_wall_set_slip(wall, SPH_NO_SLIP));
  CU_ASSERT_STRING_EQUAL(sph_wall_name(wall), "tank");
  CU_ASSERT(sphi_wall_no_slip(wall));
  CU_ASSERT(sph_wall_dim(wall) == 2 && sph_wall_facet_count(wall) == 2);
  SPH_TEST_STATUS(context, sph_wall_set_name(wall, ""), SPH_E_ARGUMENT, "wall \"tank\": name");
  SPH_TEST_STATUS(context, sph_wall_set_name(wall, NULL), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_wall_set_slip(wall, (sph_slip)2), SPH_E_ARGUMENT, "got 2");
  double normal[2], distance;
  SPH_TEST_STATUS(context, sph_wall_facet_normal(wall, 2, normal), SPH_E_ARGUMENT, "0 to 1, got 2");
  SPH_TEST_STATUS(context, sph_wall_facet_normal(wall, -1, normal), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(context, sph_wall_facet_normal(wall, 0, NULL), SPH_E_ARGUMENT, "normal");
  SPH_TEST_STATUS(context, sph_wall_distance(wall, 0, NULL, &distance), SPH_E_ARGUMENT, "x must");
  SPH_TEST_STATUS(context, sph_wall_distance(wall, 0, xy, NULL), SPH_E_ARGUMENT, "distance must");
  SPH_TEST_STATUS(context, sph_wall_distance(wall, NAN, xy, &distance), SPH_E_ARGUMENT, "t must");
  const double bad[] = {0, INFINITY};
  SPH_TEST_STATUS(context, sph_wall_distance(wall, 0, bad, &distance), SPH_E_ARGUMENT, "x[1]");
  CU_ASSERT(sph_wall_set_name(NULL, "a") == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wall_set_slip(NULL, SPH_NO_SLIP) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wall_set_motion(NULL, NULL, NULL) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wall_set_rotation(NULL, NULL, NULL, NULL, NULL) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wall_set_driver(NULL, NULL, NULL) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wall_facet_normal(NULL, 0, normal) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wall_distance(NULL, 0, xy, &distance) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wall_dim(NULL) == 0 && sph_wall_facet_count(NULL) == 0 && !*sph_wall_name(NULL));
  sph_wall *second = wall;
  sphi_wall_retain(second);
  sph_wall_destroy(&wall);
  CU_ASSERT_STRING_EQUAL(sph_wall_name(second), "tank");
  sph_wall_destroy(&second);
  sph_wall_destroy(&second);
  sph_wall_destroy(NULL);
}

#define REFUSE_LINE(text, closed, ...)                                                            \
  do {                                                                                            \
    const double t_xy[] = {__VA_ARGS__};                                                          \
    wall = (sph_wall *)&wall;                                                                     \
    SPH_TEST_STATUS(                                                                              \
        context, sph_wall_create_polyline(context, (int)(sizeof t_xy / 16), t_xy, closed, &wall), \
        SPH_E_ARGUMENT, text);                                                                    \
    CU_ASSERT_PTR_NULL(wall);                                                                     \
  } while (0)

static void bad_polylines_and_boxes_are_refused(void) {
  sph_wall *wall = NULL;
  const double lo[] = {0, 0, 0}, hi[] = {1, 1, 1}, low[] = {1, -1, 1}, bad[] = {1, NAN, 1};
  REFUSE_LINE("at least 2 vertices, got 1", false, 0, 0);
  REFUSE_LINE("at least 3 vertices, got 2", true, 0, 0, 1, 0);
  REFUSE_LINE("xy[3] must be finite", false, 0, 0, 1, NAN);
  REFUSE_LINE("xy[0]", false, 1e101, 0, 1, 0);
  REFUSE_LINE("vertices 1 and 2 coincide", false, 0, 0, 1, 0, 1, 0, 2, 0);
  REFUSE_LINE("vertices 3 and 0 coincide", true, 0, 0, 1, 0, 1, 1, 0, 0);
  REFUSE_LINE("segments 0 and 1 double back at (1, 0)", false, 0, 0, 1, 0, 0.5, 0);
  REFUSE_LINE("segments 1 and 2 double back at (2, 0)", true, 0, 0, 1, 0, 2, 0);
  REFUSE_LINE("segments 0 (0, 0)-(2, 0) and 2 (2, 1)-(1, -1)", false, 0, 0, 2, 0, 2, 1, 1, -1);
  REFUSE_LINE("segments 0 (0, 0)-(2, 0) and 2", false, 0, 0, 2, 0, 2, 1, 1, 0);
  REFUSE_LINE("closed = true", false, 0, 0, 1, 0, 1, 1, 0, 0);
  REFUSE_LINE("segments 1 (1, 0)-(0, 1) and 3", true, 0, 0, 1, 0, 0, 1, 1, 1);
  SPH_TEST_STATUS(context, sph_wall_create_polyline(context, 3, NULL, false, &wall), SPH_E_ARGUMENT,
                  "xy must");
  SPH_TEST_STATUS(context, sph_wall_create_polyline(context, 2, lo, false, NULL), SPH_E_ARGUMENT,
                  "out must");
  CU_ASSERT(sph_wall_create_polyline(NULL, 2, lo, false, &wall) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 4, lo, hi, 0, &wall), SPH_E_ARGUMENT,
                  "got 4");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 2, NULL, hi, 0, &wall), SPH_E_ARGUMENT,
                  "lo");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 2, lo, NULL, 0, &wall), SPH_E_ARGUMENT,
                  "hi");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 2, lo, hi, 0, NULL), SPH_E_ARGUMENT, "out");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 3, lo, low, 0, &wall), SPH_E_ARGUMENT,
                  "hi[1] must be above lo[1] = 0 m, got -1 m");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 3, lo, bad, 0, &wall), SPH_E_ARGUMENT,
                  "hi[1]");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 3, bad, hi, 0, &wall), SPH_E_ARGUMENT,
                  "lo[1]");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 2, lo, hi, SPH_SIDE_HI(2), &wall),
                  SPH_E_ARGUMENT, "got 0x20");
  SPH_TEST_STATUS(context, sph_wall_create_box(context, 2, lo, hi, 15, &wall), SPH_E_ARGUMENT,
                  "keep at least one side");
  CU_ASSERT(sph_wall_create_box(NULL, 2, lo, hi, 0, &wall) == SPH_E_ARGUMENT);
  CU_ASSERT_PTR_NULL(wall);
}

#define REFUSE_FACETS(count, code, text)                                                          \
  do {                                                                                            \
    wall = (sph_wall *)&wall;                                                                     \
    SPH_TEST_STATUS(context, sph_wall_create_facets(context, count, f[0][0], &wall), code, text); \
    CU_ASSERT_PTR_NULL(wall);                                                                     \
  } while (0)

static void bad_facets_are_refused(void) {
  const double bottom[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const double top[4][3] = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const double skew[4][3] = {{-0.3, -0.2, 1}, {1.3, -0.2, 1}, {1.3, 1.2, 1}, {-0.3, 1.2, 1}};
  double good[6][4][3], f[6][4][3];
  sph_wall *wall = NULL;
  hexahedron(bottom, top, false, good);
#define RESET() memcpy(f, good, sizeof f)
  RESET();
  REFUSE_FACETS(0, SPH_E_ARGUMENT, "got 0");
  f[1][0][2] += 2e-5;
  REFUSE_FACETS(6, SPH_E_ARGUMENT, "facet 1 is not plane");
  RESET();
  f[2][1][0] = INFINITY;
  REFUSE_FACETS(6, SPH_E_ARGUMENT, "corners[27]");
  RESET();
  f[0][2][0] = f[0][2][1] = 0.2;
  REFUSE_FACETS(6, SPH_E_ARGUMENT, "facet 0 is not convex at corner 2");
  RESET();
  memcpy(f[0][1], f[0][0], 24);
  REFUSE_FACETS(6, SPH_E_ARGUMENT, "facet 0 is not convex");
  memcpy(f[0][2], f[0][0], 24);
  REFUSE_FACETS(6, SPH_E_ARGUMENT, "facet 0 is degenerate");
  RESET();
  for (int k = 0; k < 4; k++) memcpy(f[5][k], good[5][3 - k], 24);
  REFUSE_FACETS(6, SPH_E_ARGUMENT, "facets 0 and 5 share an edge but face opposite sides");
  RESET();
  memcpy(f[1], f[0], sizeof f[0]);
  REFUSE_FACETS(3, SPH_E_ARGUMENT, "belongs to 3 facets");
  for (int k = 0; k < 4; k++) memcpy(f[1][k], good[0][3 - k], 24);
  REFUSE_FACETS(2, SPH_E_ARGUMENT, "folded onto each other");
  hexahedron(bottom, skew, false, f);
  REFUSE_FACETS(6, SPH_E_UNSUPPORTED, "concave corner (0, 0, 0) m");
  SPH_TEST_STATUS(context, sph_wall_create_facets(context, 1, NULL, &wall), SPH_E_ARGUMENT,
                  "corners");
  SPH_TEST_STATUS(context, sph_wall_create_facets(context, 1, good[0][0], NULL), SPH_E_ARGUMENT,
                  "out");
  CU_ASSERT(sph_wall_create_facets(NULL, 1, good[0][0], &wall) == SPH_E_ARGUMENT);
}

static void bad_ghost_requests_are_refused(void) {
  const double lo[] = {0, 0, 0}, hi[] = {1, 1, 1};
  sph_wall *wall = box(2, lo, hi, 0), *solid = box(3, lo, hi, 0);
  sphi_ghost_points p = ghosts_of(wall, 0.1, 0.2);
  const int64_t n = p.n;
  SPH_TEST_STATUS(context, sphi_wall_make_ghosts(wall, 0, 1, &p), SPH_E_ARGUMENT, "spacing");
  SPH_TEST_STATUS(context, sphi_wall_make_ghosts(wall, NAN, 1, &p), SPH_E_ARGUMENT, "spacing");
  SPH_TEST_STATUS(context, sphi_wall_make_ghosts(wall, 1, -1, &p), SPH_E_ARGUMENT, "depth");
  SPH_TEST_STATUS(context, sphi_wall_make_ghosts(wall, 1e-7, 1, &p), SPH_E_ARGUMENT, "layers");
  SPH_TEST_STATUS(context, sphi_wall_make_ghosts(wall, 1e-9, 3e-9, &p), SPH_E_ARGUMENT,
                  "at most 2147483647");
  SPH_TEST_STATUS(context, sphi_wall_make_ghosts(solid, 0.1, 0.2, &p), SPH_E_ARGUMENT, "3D ghosts");
  CU_ASSERT_EQUAL(p.n, n);
  SPH_TEST_OK(context, sphi_wall_make_ghosts(wall, 0.1, 0.2, &p)); /* appends */
  CU_ASSERT_EQUAL(p.n, 2 * n);
  CU_ASSERT(!memcmp(p.x, p.x + 2 * n, (size_t)n * 16));
  sph_wall_destroy(&solid);
  finish(wall, &p);
}

typedef struct counter {
  int left, live;
} counter;

static void *counted_allocate(size_t bytes, void *user) {
  counter *c = user;
  if (c->left-- <= 0) return NULL;
  c->live++;
  return malloc(bytes);
}

static void counted_release(void *memory, void *user) {
  ((counter *)user)->live--;
  free(memory);
}

static void lack_of_memory_is_reported(void) {
  counter c = {1000, 0};
  const sph_allocator allocator = {counted_allocate, counted_release, &c};
  const double lo[] = {0, 0, 0}, hi[] = {1, 1, 1}, xy[] = {0, 1, 0, 0, 1, 0, 1.2, 1};
  sph_context *poor = NULL;
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &poor) == SPH_OK);
  int failures = 0;
  for (int dim = 2; dim <= 3; dim++)
    for (int allowed = 0;; allowed++) {
      c.left = allowed;
      sph_wall *wall = NULL;
      sphi_ghost_points p = {0};
      sph_status status = dim == 2 ? sph_wall_create_polyline(poor, 4, xy, false, &wall)
                                   : sph_wall_create_box(poor, 3, lo, hi, 0, &wall);
      CU_ASSERT((status == SPH_OK) == (wall != NULL));
      if (status == SPH_OK) {
        status = sph_wall_set_name(wall, "other");
        CU_ASSERT_STRING_EQUAL(sph_wall_name(wall), status == SPH_OK ? "other" : "wall");
      }
      if (status == SPH_OK) {
        status = sphi_wall_make_ghosts(wall, 0.25, 0.5, &p);
        CU_ASSERT((status == SPH_OK) == (p.n > 0));
      }
      sphi_ghost_points_free(poor, &p);
      sph_wall_destroy(&wall);
      CU_ASSERT_EQUAL(c.live, 1); /* the context */
      if (status == SPH_OK) break;
      CU_ASSERT(status == SPH_E_MEMORY && strstr(sph_context_message(poor), "no memory"));
      failures++;
    }
  CU_ASSERT(failures > 20);
  sph_context_destroy(&poor);
  CU_ASSERT_EQUAL(c.live, 0);
}

static void a_wall_keeps_its_context(void) {
  sph_context *own = NULL;
  CU_ASSERT_FATAL(sph_context_create(&own) == SPH_OK);
  const double lo[] = {0, 0}, hi[] = {1, 1};
  sph_wall *wall = NULL;
  SPH_TEST_OK(own, sph_wall_create_box(own, 2, lo, hi, 0, &wall));
  sph_context_destroy(&own);
  double distance = 0;
  CU_ASSERT(sph_wall_distance(wall, 0, hi, &distance) == SPH_OK && distance == 0);
  sph_wall_destroy(&wall);
}

static void context_opens(void) { CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK); }
static void context_closes(void) {
  sph_context_destroy(&context);
  CU_ASSERT_PTR_NULL(context);
}

SPH_TEST_MAIN("wall", {"context opens", context_opens},
              {"ghosts of a 2D tank continue the fluid's lattice", box_2d_continues_the_lattice},
              {"wall at 120 degrees: layers, wedge, mirrors, volume", wall_at_120_degrees},
              {"the solid behind a step is filled for every view", step_is_filled_for_every_view},
              {"corners near each other are filled for every view",
               corners_near_each_other_are_filled_for_every_view},
              {"the strips of an obstacle have their volumes", obstacle_strips_have_their_volumes},
              {"mirrors of a 60 degree corner are in the fluid", corner_of_60_degrees},
              {"ghosts of a 3D box continue the lattice over edges and corners",
               box_3d_continues_the_lattice},
              {"facets find their shared edges and corners", facets_know_edges_and_corners},
              {"a step in a 3D tank is filled for every view", step_in_a_tank_in_3d},
              {"a leaning wall in 3D fills its section times the width", leaning_wall_in_3d},
              {"distance equals brute force, sign by winding number", distance_matches_brute_force},
              {"distance has the right sign where convex and concave edges meet",
               distance_sign_at_mixed_corners},
              {"a rotated wall gives rotated ghosts", rotation_turns_the_ghosts},
              {"thin gaps and thin solids keep only valid ghosts", thin_gaps_and_thin_solids},
              {"10000 segments: the ring's volume and surface", ten_thousand_segments},
              {"a coarse round pile is not overfilled", coarse_circle_is_not_overfilled},
              {"a prescribed motion moves the wall", motion_moves_the_wall},
              {"a rotation carries points with its velocity and acceleration",
               rotation_carries_points},
              {"a wall displaced and turned in 3D is the one created there",
               moved_walls_are_where_they_would_be_created},
              {"a driver moves the wall from step to step", driver_moves_the_wall},
              {"bad rotations, and two translations, are refused", bad_motions_are_refused},
              {"settings, getters and references", settings_and_references},
              {"bad polylines and boxes are refused", bad_polylines_and_boxes_are_refused},
              {"bad facets are refused", bad_facets_are_refused},
              {"bad ghost requests are refused", bad_ghost_requests_are_refused},
              {"lack of memory is reported and leaks nothing", lack_of_memory_is_reported},
              {"a wall keeps its context alive", a_wall_keeps_its_context},
              {"context closes", context_closes})
