/* Where facets meet: which vertices and edges leave a wedge in the solid, which 3D vertices a
 * corner. */
#include "wall/wall_geometry.h"

static sph_status add_wedge(sph_wall *wall, const double *a, const double *b, int first,
                            int second) {
  SPH_CHECK(wall->context,
            sphi_reserve(wall->context, (void **)&wall->wedge, &wall->wedge_capacity,
                         wall->wedges + 1, sizeof *wall->wedge),
            SPH_E_MEMORY, "wall: no memory for %lld edges", (long long)wall->wedges + 1);
  sphi_wall_wedge *wedge = &wall->wedge[wall->wedges++];
  memcpy(wedge->a, a, sizeof wedge->a);
  memcpy(wedge->b, b, sizeof wedge->b);
  wedge->facet[0] = first;
  wedge->facet[1] = second;
  return SPH_OK;
}

sph_status sphi_wall_join_2d(sph_wall *wall) {
  for (int k = 0; k < wall->facets; k++) {
    sphi_wall_facet *facet = &wall->facet[k];
    if (facet->link[1] < 0) continue;
    sphi_wall_facet *next = &wall->facet[facet->link[1]];
    double cross[3];
    sphi_cross(facet->normal, next->normal, cross);
    /* To the left the fluid's angle is 180 degrees - turn. */
    const double turn = atan2(cross[2], sphi_dot(facet->normal, next->normal));
    SPH_CHECK(wall->context, fabs(turn) < SPHI_WALL_PI - SPHI_WALL_FLAT, SPH_E_ARGUMENT,
              "wall: segments %d and %d double back at (%g, %g) m: the angle there must not be 0",
              k, facet->link[1], facet->corner[1][0], facet->corner[1][1]);
    if (turn > SPHI_WALL_FLAT)
      SPH_TRY(add_wedge(wall, facet->corner[1], facet->corner[1], k, facet->link[1]));
    else if (turn < -SPHI_WALL_FLAT) {
      const bool sharp = sphi_wall_opposed(wall, k, facet->link[1]);
      /* A sharp corner cuts the strip where the other facet is. */
      facet->clip[1] = next->clip[0] = sharp ? fmax(0, -1 / tan(-turn)) : tan(-turn / 2);
      facet->shares[1] = next->shares[0] = !sharp;
    }
  }
  return SPH_OK;
}

typedef struct sharing {
  const sph_wall *wall;
  const double *a, *b;
  double tolerance;
  int facet, other, count;
  bool reversed;
} sharing;

static bool visit_sharing(void *state, int other) {
  sharing *s = state;
  if (other == s->facet) return true;
  for (int c = 0; c < 4; c++) {
    const double *p = s->wall->facet[other].corner[c];
    const double *q = s->wall->facet[other].corner[(c + 1) % 4];
    const bool same = sphi_gap(p, s->a) <= s->tolerance && sphi_gap(q, s->b) <= s->tolerance;
    const bool reversed = sphi_gap(p, s->b) <= s->tolerance && sphi_gap(q, s->a) <= s->tolerance;
    if (!same && !reversed) continue;
    s->count++;
    s->other = other;
    s->reversed = reversed;
  }
  return true;
}

static void box_around(const double *x, double tolerance, double *lo, double *hi) {
  for (int d = 0; d < 3; d++) {
    lo[d] = x[d] - tolerance;
    hi[d] = x[d] + tolerance;
  }
}

static sph_status join_edge(sph_wall *wall, int k, int edge, double tolerance) {
  const sphi_wall_facet *facet = &wall->facet[k];
  sharing s = {wall, facet->corner[edge], facet->corner[(edge + 1) % 4], tolerance, k, -1, 0,
               false};
  double lo[3], hi[3];
  box_around(s.a, tolerance, lo, hi);
  sphi_wall_overlapping(wall, lo, hi, visit_sharing, &s);
  const double *a = s.a, *b = s.b;
  SPH_CHECK(
      wall->context, s.count <= 1, SPH_E_ARGUMENT,
      "wall: the edge (%g, %g, %g)-(%g, %g, %g) m of facet %d belongs to %d facets; at most 2",
      a[0], a[1], a[2], b[0], b[1], b[2], k, s.count + 1);
  if (!s.count || s.other < k) return SPH_OK;
  SPH_CHECK(
      wall->context, s.reversed, SPH_E_ARGUMENT,
      "wall: facets %d and %d share an edge but face opposite sides; reverse the corners of one", k,
      s.other);
  const sphi_wall_facet *other = &wall->facet[s.other];
  double cross[3], to[3];
  sphi_cross(facet->normal, other->normal, cross);
  const double turn = atan2(sphi_length(cross), sphi_dot(facet->normal, other->normal));
  SPH_CHECK(wall->context, turn < SPHI_WALL_PI - SPHI_WALL_FLAT, SPH_E_ARGUMENT,
            "wall: facets %d and %d are folded onto each other at (%g, %g, %g) m", k, s.other, a[0],
            a[1], a[2]);
  sphi_subtract(other->middle, a, to);
  if (turn > SPHI_WALL_FLAT && sphi_dot(to, facet->normal) > 0)
    SPH_TRY(add_wedge(wall, a, b, k, s.other));
  return SPH_OK;
}

enum { MEETING_MAX = 64 };

typedef struct meeting {
  const sph_wall *wall;
  const double *x;
  double tolerance;
  int count, facet[MEETING_MAX], corner[MEETING_MAX];
} meeting;

static bool visit_meeting(void *state, int facet) {
  meeting *m = state;
  for (int c = 0; c < 4; c++) {
    if (sphi_gap(m->wall->facet[facet].corner[c], m->x) > m->tolerance) continue;
    if (m->count == MEETING_MAX) return false;
    m->facet[m->count] = facet;
    m->corner[m->count++] = c;
  }
  return true;
}

/* No facet at the vertex looks away from an edge of another: the solid behind it has the vertex as
 * its nearest point of the wall. */
static bool is_concave(const meeting *m) {
  for (int k = 0; k < m->count; k++) {
    const double *normal = m->wall->facet[m->facet[k]].normal;
    for (int e = 0; e < m->count; e++) {
      const sphi_wall_facet *facet = &m->wall->facet[m->facet[e]];
      for (int step = 1; step <= 3; step += 2) {
        double along[3];
        sphi_subtract(facet->corner[(m->corner[e] + step) % 4], facet->corner[m->corner[e]], along);
        if (sphi_dot(normal, along) < -SPHI_WALL_FLAT * sphi_length(along)) return false;
      }
    }
  }
  return true;
}

static sph_status join_corner(sph_wall *wall, int k, int c, double tolerance) {
  meeting m = {.wall = wall, .x = wall->facet[k].corner[c], .tolerance = tolerance};
  double lo[3], hi[3];
  box_around(m.x, tolerance, lo, hi);
  sphi_wall_overlapping(wall, lo, hi, visit_meeting, &m);
  if (m.facet[0] != k || m.corner[0] != c) return SPH_OK; /* done from the lowest facet */
  int distinct[4], directions = 0;
  for (int j = 0; j < m.count && directions < 4; j++) {
    bool known = false;
    for (int i = 0; i < directions; i++)
      known = known || sphi_gap(wall->facet[m.facet[j]].normal, wall->facet[distinct[i]].normal) <
                           SPHI_WALL_FLAT;
    if (!known) distinct[directions++] = m.facet[j];
  }
  if (directions < 3 || !is_concave(&m)) return SPH_OK;
  SPH_CHECK(wall->context, directions == 3, SPH_E_UNSUPPORTED,
            "wall: more than three directions of facets meet in the concave corner (%g, %g, %g) m",
            m.x[0], m.x[1], m.x[2]);
  for (int last = 2; last >= 0; last--) {
    const int first = distinct[(last + 1) % 3], second = distinct[(last + 2) % 3];
    const double *normal = wall->facet[distinct[last]].normal;
    if (fabs(sphi_dot(normal, wall->facet[first].normal)) > 1e-9 ||
        fabs(sphi_dot(normal, wall->facet[second].normal)) > 1e-9)
      continue;
    SPH_CHECK(wall->context,
              sphi_reserve(wall->context, (void **)&wall->corner, &wall->corner_capacity,
                           wall->corners + 1, sizeof *wall->corner),
              SPH_E_MEMORY, "wall: no memory for %lld corners", (long long)wall->corners + 1);
    sphi_wall_corner *corner = &wall->corner[wall->corners++];
    memcpy(corner->x, m.x, sizeof corner->x);
    corner->facet[0] = first < second ? first : second;
    corner->facet[1] = first < second ? second : first;
    corner->facet[2] = distinct[last];
    return SPH_OK;
  }
  return SPHI_ERROR(
      wall->context, SPH_E_UNSUPPORTED,
      "wall: in the concave corner (%g, %g, %g) m of facets %d, %d and %d one facet must "
      "be perpendicular to the two others",
      m.x[0], m.x[1], m.x[2], distinct[0], distinct[1], distinct[2]);
}

sph_status sphi_wall_join_3d(sph_wall *wall) {
  const double tolerance = 1e-9 * wall->size;
  for (int k = 0; k < wall->facets; k++)
    for (int c = 0; c < 4; c++) SPH_TRY(join_edge(wall, k, c, tolerance));
  for (int k = 0; k < wall->facets; k++)
    for (int c = 0; c < 4; c++) SPH_TRY(join_corner(wall, k, c, tolerance));
  return SPH_OK;
}
