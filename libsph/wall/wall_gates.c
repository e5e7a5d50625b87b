/* Sharp solid corners: which other sides of the solid have ghosts at the same place, and from where
 * the fluid sees each.
 *
 * Fluid around a convex corner of the solid falls into cells, nearest to a facet, an edge or a vertex.
 * From the cell of a facet one sees the solid filled with the mirror image of that cell, from the cell
 * of an edge or vertex with the reflection through it. Then the ghost of particle j acts on i where the
 * ghost of i acts on j, and as grad_j W(x_j - R x_i) = -R grad_i W(x_i - R x_j) under any of these
 * reflections R, the work of the wall, the sum of V_i V_j (p_j u_i + p_i R u_j) . grad_i W(x_i - R x_j),
 * cancels by pairs. Source: own. */
#include "wall/wall_geometry.h"

static double height_over(const sphi_wall_facet *facet, const double *x) {
  double from[3];
  sphi_subtract(x, facet->middle, from);
  return sphi_dot(from, facet->normal);
}

bool sphi_wall_opposed(const sph_wall *wall, int facet, int other) {
  const sphi_wall_facet *a = &wall->facet[facet], *b = &wall->facet[other];
  const double behind = -1e-9 * wall->size;
  return sphi_dot(a->normal, b->normal) < SPHI_WALL_SHARP && height_over(a, b->middle) < behind &&
         height_over(b, a->middle) < behind;
}

bool sphi_wall_is_rival(const sph_wall *wall, const sphi_wall_side *side, int facet) {
  for (int k = 0; k < side->owners; k++)
    if (sphi_wall_opposed(wall, side->owner[k], facet)) return true;
  return false;
}

bool sphi_wall_is_known(const sph_wall *wall, const sphi_wall_side *side, int facet) {
  for (int k = 0; k < side->rivals; k++)
    if (sphi_dot(wall->facet[facet].normal, wall->facet[side->rival[k].facet].normal) >
        1 - SPHI_WALL_FLAT)
      return true;
  return false;
}

/* x = foot + sum f_k normal_k, with the foot where the planes of the n facets meet; dual_k is the
 * gradient of f_k. */
typedef struct meeting_planes {
  double f[3], dual[3][3], foot[3];
} meeting_planes;

/* False if the normals are not independent. */
static bool find_meeting(const sph_wall *wall, int n, const int *facet, const double *x,
                         meeting_planes *m) {
  double gram[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, inverse[3][3];
  for (int k = 0; k < n; k++)
    for (int l = 0; l < n; l++)
      gram[k][l] = sphi_dot(wall->facet[facet[k]].normal, wall->facet[facet[l]].normal);
  for (int k = 0; k < 3; k++) sphi_cross(gram[(k + 1) % 3], gram[(k + 2) % 3], inverse[k]);
  const double determinant = sphi_dot(gram[0], inverse[0]);
  if (determinant < 1e-2) return false;
  *m = (meeting_planes){.f = {0}};
  for (int d = 0; d < 3; d++) m->foot[d] = x[d];
  for (int k = 0; k < n; k++) {
    for (int l = 0; l < n; l++) {
      const sphi_wall_facet *other = &wall->facet[facet[l]];
      m->f[k] += inverse[k][l] / determinant * height_over(other, x);
      for (int d = 0; d < 3; d++) m->dual[k][d] += inverse[k][l] / determinant * other->normal[d];
    }
    for (int d = 0; d < 3; d++) m->foot[d] -= m->f[k] * wall->facet[facet[k]].normal[d];
  }
  return true;
}

static bool on_wall(const sph_wall *wall, const double *x, double tolerance) {
  sphi_wall_nearest nearest;
  sphi_wall_find_nearest(wall, x, tolerance, 0, &nearest);
  return nearest.facet >= 0;
}

/* One more gate, if there is room: where normal . (x_fluid - x) + value > 0, all times `sign`. */
static void add_gate(const sph_wall *wall, const double *normal, double value, double sign,
                     sphi_wall_gates *gates) {
  if (gates->count == SPHI_GATES(wall->dim)) return;
  const double size = sphi_length(normal);
  double *plane = gates->plane[gates->count++];
  for (int d = 0; d < 3; d++) plane[d] = sign * normal[d] / size;
  plane[3] = sign * value / size;
}

/* Where the height over `own` is above that over `rival`. */
static void add_bisector(const sph_wall *wall, int own, int rival, const double *x,
                         sphi_wall_gates *gates) {
  const sphi_wall_facet *a = &wall->facet[own], *b = &wall->facet[rival];
  double normal[3];
  sphi_subtract(a->normal, b->normal, normal);
  add_gate(wall, normal, height_over(a, x) - height_over(b, x), 1, gates);
}

void sphi_wall_find_rivals(const sph_wall *wall, const double *x, double depth, double tolerance,
                           sphi_wall_side *side) {
  for (side->rivals = 0; side->rivals < SPHI_WALL_RIVALS; side->rivals++) {
    sphi_wall_nearest other, claim;
    sphi_wall_find_nearest_of(wall, x, depth, tolerance, side, true, &other);
    if (other.facet < 0) return;
    const sphi_wall_side theirs = {.owners = 1, .owner = {other.facet}};
    sphi_wall_find_nearest_of(wall, x, other.distance + tolerance, tolerance, &theirs, false,
                              &claim);
    if (claim.distance < other.distance - tolerance ||
        sphi_gap(claim.foot, other.foot) > 1e3 * tolerance)
      return; /* it has no ghosts here */
    sphi_wall_rival *rival = &side->rival[side->rivals];
    *rival = (sphi_wall_rival){.facet = other.facet, .distance = other.distance};
    for (int k = side->owners - 1; k >= 0; k--)
      if (sphi_wall_opposed(wall, side->owner[k], other.facet)) rival->owner = side->owner[k];
    meeting_planes m;
    rival->meets = find_meeting(wall, 2, (int[]){rival->owner, rival->facet}, x, &m) &&
                   on_wall(wall, m.foot, 1e3 * tolerance);
  }
}

void sphi_wall_gate_side(const sph_wall *wall, const sphi_wall_side *side, const double *x,
                         sphi_wall_gates *gates) {
  gates->count = 0;
  for (int k = 0; k < side->rivals; k++) {
    const sphi_wall_rival *rival = &side->rival[k];
    meeting_planes m;
    if (rival->meets && find_meeting(wall, 2, (int[]){rival->owner, rival->facet}, x, &m))
      add_gate(wall, m.dual[1], m.f[1], -1, gates); /* short of the edge */
    else
      add_bisector(wall, rival->owner, rival->facet, x, gates);
  }
  /* Where the solid's angle is below 90 degrees, fluid behind the facet can be short of the edge. */
  for (int k = 0; k < side->rivals; k++) {
    const sphi_wall_rival *rival = &side->rival[k];
    const double cosine =
        sphi_dot(wall->facet[rival->owner].normal, wall->facet[rival->facet].normal);
    if (rival->meets && cosine < -1e-9) add_bisector(wall, rival->owner, rival->facet, x, gates);
  }
}

/* Whether a's ghosts give the places to the reflections through the edge of a and b: one rule for all
 * pieces of both sides, and in 2D for any direction of the axes. */
static bool leads(const sph_wall *wall, int a, int b) {
  const double *m = wall->facet[a].normal, *n = wall->facet[b].normal;
  if (wall->dim == 2) return m[0] * n[1] - m[1] * n[0] < 0;
  for (int d = 0; d < 3; d++)
    if (fabs(m[d] - n[d]) > SPHI_WALL_FLAT) return m[d] < n[d];
  return false;
}

bool sphi_wall_gate_nose(const sph_wall *wall, const sphi_wall_side *side, int which, int also,
                         const double *x, double tolerance, double *foot, sphi_wall_gates *gates) {
  int facet[4], n = 0;
  for (int k = 0; k < side->rivals; k++) {
    const sphi_wall_rival *rival = &side->rival[k];
    if (!(which & (1 << k))) continue;
    if (n == wall->dim) return false;
    if (n == 0) facet[n++] = rival->owner;
    if (rival->owner != facet[0] || !rival->meets || !leads(wall, facet[0], rival->facet))
      return false;
    facet[n++] = rival->facet;
  }
  const int gated = n;
  if (also >= 0 && (also == facet[0] || n == wall->dim)) return false;
  if (also >= 0) facet[n++] = also;
  meeting_planes m;
  if (!find_meeting(wall, n, facet, x, &m) || !on_wall(wall, m.foot, 1e3 * tolerance)) return false;
  memcpy(foot, m.foot, sizeof m.foot);
  gates->count = 0;
  for (int k = 0; k < gated; k++) add_gate(wall, m.dual[k], m.f[k], 1, gates);
  for (int k = 0; k < side->rivals && gated < wall->dim; k++) {
    facet[gated] = side->rival[k].facet;
    if (!(which & (1 << k)) && side->rival[k].meets && find_meeting(wall, gated + 1, facet, x, &m))
      add_gate(wall, m.dual[gated], m.f[gated], -1, gates);
  }
  return true;
}
