/* Ghost points behind a wall: the foot of each is its nearest point on the wall, its mirror the
 * reflection through the foot.
 *
 * On a facet that is the mirror image; behind a concave vertex or edge the reflection through it.
 * Source: Huang et al. (2019) for flat walls and corners; differs: vertices of any angle, blunt
 * re-entrant corners divided by the nearest facet, sharp ones seen from each side in its own way,
 * compressed mirrors where the fluid's angle is < 90. */
#include "wall/wall_geometry.h"

/* A place in the solid relative to the vertex or edge it belongs to. */
typedef struct wedge_place {
  double offset[3], mirror[3], area;
} wedge_place;

typedef struct ghost_maker {
  const sph_wall *wall;
  sphi_ghost_points *out;
  double spacing, depth, tolerance; /* depth: of all layers */
  int layers;
  wedge_place *place; /* of the wedge at hand */
  int64_t places, place_capacity;
  int64_t *number; /* ghost of each cell of the first layer of the facet at hand, or -1 */
  int64_t number_capacity;
} ghost_maker;

void sphi_ghost_points_free(sph_context *context, sphi_ghost_points *points) {
  sphi_free(context, points->x);
  sphi_free(context, points->mirror);
  sphi_free(context, points->foot);
  sphi_free(context, points->volume);
  sphi_free(context, points->area);
  sphi_free(context, points->vertex);
  sphi_free(context, points->gates);
  sphi_free(context, points->gated);
  sphi_free(context, points->gate);
  *points = (sphi_ghost_points){0};
}

static bool reserve_points(sph_context *context, sphi_ghost_points *p, int64_t count) {
  if (count <= p->capacity) return true;
  const size_t vector = (size_t)p->dim * sizeof(double);
  struct {
    void **array;
    size_t size;
  } const arrays[] = {{(void **)&p->x, vector},
                      {(void **)&p->mirror, vector},
                      {(void **)&p->foot, vector},
                      {(void **)&p->volume, sizeof(double)},
                      {(void **)&p->area, sizeof(double)},
                      {(void **)&p->vertex, 1},
                      {(void **)&p->gates, 1},
                      {(void **)&p->gated, sizeof *p->gated}};
  int64_t grown = p->capacity;
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) {
    grown = p->capacity; /* an array that a failure left larger is still at least this large */
    if (!sphi_reserve(context, arrays[k].array, &grown, count, arrays[k].size)) return false;
  }
  p->capacity = grown;
  return true;
}

/* Room for the gates of one more ghost. */
static bool reserve_gates(sph_context *context, sphi_ghost_points *p) {
  return sphi_reserve(context, (void **)&p->gate, &p->gate_capacity, p->gated_count + 1,
                      (size_t)SPHI_GATES(p->dim) * ((size_t)p->dim + 1) * sizeof(double));
}

static sph_status no_memory(const ghost_maker *maker) {
  return SPHI_ERROR(maker->wall->context, SPH_E_MEMORY, "wall \"%s\": no memory for %lld ghosts",
                    maker->wall->name, (long long)maker->out->n + 1);
}

/* Equal intervals of about `spacing`; the small shift keeps 10.5 from depending on round-off. */
static double intervals(double length, double spacing) {
  return fmax(1, floor(length / spacing + 0.5 + 1e-9));
}

static bool in_solid(const ghost_maker *maker, const double *x, double bound) {
  sphi_wall_nearest nearest;
  sphi_wall_find_nearest(maker->wall, x, bound + maker->tolerance, maker->tolerance, &nearest);
  return nearest.side <= 0;
}

/* Whether the solid reaches from the foot to x without fluid between. */
static bool solid_between(const ghost_maker *maker, const double *x, const double *foot) {
  const double s = sphi_gap(x, foot), steps = ceil(s / maker->spacing);
  for (double k = 0.5; k < steps; k++) {
    double at[3];
    for (int d = 0; d < 3; d++) at[d] = foot[d] + k / steps * (x[d] - foot[d]);
    if (!in_solid(maker, at, s)) return false;
  }
  return true;
}

/* Whether `foot` is the nearest point of the wall to a ghost at x, or the one on the lowest facet
 * if several are equally near, but for rivals beyond sharp corners: those have ghosts of their own
 * here. Counts places that are not in the solid at all. */
static bool belongs(ghost_maker *maker, const double *x, const double *foot, sphi_wall_side *side) {
  sphi_wall_nearest nearest;
  const double s = sphi_gap(x, foot), tolerance = maker->tolerance;
  if (!in_solid(maker, x, s)) {
    maker->out->skipped++;
    return false;
  }
  sphi_wall_find_nearest_of(maker->wall, x, s + tolerance, tolerance, side, false, &nearest);
  if (nearest.distance < s - tolerance || sphi_gap(nearest.foot, foot) > 1e-6 * maker->spacing)
    return false;
  sphi_wall_find_nearest(maker->wall, x, s, 0, &nearest);
  sphi_wall_find_rivals(maker->wall, x, fmax(maker->depth, s + tolerance), tolerance, side);
  if (side->rivals == 0) return nearest.distance >= s - tolerance;
  if (solid_between(maker, x, foot)) return true;
  maker->out->skipped++;
  return false;
}

static bool mirror_in_fluid(const ghost_maker *maker, const double *mirror, const double *foot) {
  sphi_wall_nearest nearest;
  const double bound = sphi_gap(mirror, foot) + maker->tolerance;
  sphi_wall_find_nearest(maker->wall, mirror, bound, maker->tolerance, &nearest);
  return nearest.side >= 0 || nearest.distance <= maker->tolerance;
}

/* Appends the ghost at x unless its mirror is in the solid; *number is its index or -1. */
static sph_status add_ghost(ghost_maker *maker, const double *x, const double *mirror,
                            const double *foot, double volume, bool vertex,
                            const sphi_wall_gates *gates, int64_t *number) {
  sphi_ghost_points *out = maker->out;
  *number = -1;
  if (!mirror_in_fluid(maker, mirror, foot)) {
    out->skipped++;
    return SPH_OK;
  }
  if (!reserve_points(maker->wall->context, out, out->n + 1) ||
      (gates->count > 0 && !reserve_gates(maker->wall->context, out)))
    return no_memory(maker);
  for (int d = 0; d < out->dim; d++) {
    const int64_t k = out->n * out->dim + d;
    out->x[k] = x[d];
    out->mirror[k] = mirror[d];
    out->foot[k] = foot[d];
  }
  out->volume[out->n] = volume;
  out->area[out->n] = 0;
  out->vertex[out->n] = vertex;
  out->gates[out->n] = (uint8_t)gates->count;
  if (gates->count > 0) out->gated[out->n] = (int32_t)out->gated_count++;
  for (int g = 0; g < gates->count; g++) {
    double *gate =
        out->gate + ((int64_t)out->gated[out->n] * SPHI_GATES(out->dim) + g) * (out->dim + 1);
    memcpy(gate, gates->plane[g], (size_t)out->dim * sizeof *gate);
    gate[out->dim] = gates->plane[g][3];
  }
  *number = out->n++;
  return SPH_OK;
}

/* Cuts the interval of cell j at a re-entrant end of a 2D strip, or extends it to there if the next
 * cell's middle is beyond, so that each layer fills its length exactly: the cell's near boundary,
 * counted from that end. Where the strips of both facets have a ghost on the bisector only one of
 * the two is kept, with its whole interval. */
static double near_boundary(const ghost_maker *maker, int facet, int end, double j, double width,
                            double s) {
  const sphi_wall_facet *self = &maker->wall->facet[facet];
  const double left = j * width, lo = self->clip[end] * s;
  if (lo <= 0) return left;
  const sphi_wall_facet *other = &maker->wall->facet[self->link[end]];
  const double other_length = sphi_gap(other->corner[0], other->corner[1]);
  const double other_width = other_length / intervals(other_length, maker->spacing);
  const double tolerance = 1e-8 * maker->spacing, cell = floor(lo / width);
  const bool tie = self->shares[end] && fabs((cell + 0.5) * width - lo) < tolerance;
  if (tie && fabs(other_width - width) < tolerance) return left;
  const double before = left - 0.5 * width; /* the middle of the cell before */
  const bool first = self->shares[end] && facet < self->link[end];
  return before < lo + (first ? -tolerance : tolerance) ? lo : left;
}

typedef struct cells {
  double nu, nv, width; /* width: of the intervals in 2D */
} cells;

static cells count_cells(const ghost_maker *maker, const sphi_wall_facet *facet) {
  cells c = {1, 1, 0};
  const double u = sphi_gap(facet->corner[0], facet->corner[1]);
  if (maker->wall->dim == 2) {
    c.nu = intervals(u, maker->spacing);
    c.width = u / c.nu;
    return c;
  }
  c.nu = intervals((u + sphi_gap(facet->corner[2], facet->corner[3])) / 2, maker->spacing);
  c.nv = intervals((sphi_gap(facet->corner[0], facet->corner[3]) +
                    sphi_gap(facet->corner[1], facet->corner[2])) /
                       2,
                   maker->spacing);
  return c;
}

/* The point of the facet at fractions u, v of its sides. */
static void facet_point(const ghost_maker *maker, const sphi_wall_facet *facet, double u, double v,
                        double *x) {
  const double(*c)[3] = facet->corner;
  for (int d = 0; d < 3; d++)
    x[d] = maker->wall->dim == 2 ? (1 - u) * c[0][d] + u * c[1][d]
                                 : (1 - v) * ((1 - u) * c[0][d] + u * c[1][d]) +
                                       v * ((1 - u) * c[3][d] + u * c[2][d]);
}

/* Middle of cell (i, j), put into the facet's plane, and the cell's length or area. */
static double facet_cell(const ghost_maker *maker, const sphi_wall_facet *facet, cells c, double i,
                         double j, double *middle) {
  facet_point(maker, facet, (i + 0.5) / c.nu, (j + 0.5) / c.nv, middle);
  if (maker->wall->dim == 2) return c.width;
  double from[3], corner[4][3], diagonal[2][3], normal[3];
  sphi_subtract(middle, facet->middle, from);
  const double height = sphi_dot(from, facet->normal);
  for (int d = 0; d < 3; d++) middle[d] -= height * facet->normal[d];
  for (int k = 0; k < 4; k++)
    facet_point(maker, facet, (i + (k == 1 || k == 2)) / c.nu, (j + (k >= 2)) / c.nv, corner[k]);
  sphi_subtract(corner[2], corner[0], diagonal[0]);
  sphi_subtract(corner[3], corner[1], diagonal[1]);
  sphi_cross(diagonal[0], diagonal[1], normal);
  return sphi_length(normal) / 2;
}

/* Gives the surface of cells without a ghost in the first layer to the nearest cell that has one,
 * so that forces on the facet stay whole. */
static void spread_area(ghost_maker *maker, const sphi_wall_facet *facet, cells c) {
  const int64_t nu = (int64_t)c.nu, nv = (int64_t)c.nv;
  for (int64_t j = 0; j < nv; j++)
    for (int64_t i = 0; i < nu; i++) {
      int64_t found = maker->number[j * nu + i];
      for (int64_t ring = 1; found < 0 && (ring < nu || ring < nv); ring++) {
        int64_t best = INT64_MAX;
        for (int64_t q = j > ring ? j - ring : 0; q < nv && q <= j + ring; q++) {
          const int64_t rim = q == j - ring || q == j + ring ? 1 : 2 * ring;
          for (int64_t p = i - ring; p < nu && p <= i + ring; p += rim) {
            const int64_t gap = (p - i) * (p - i) + (q - j) * (q - j);
            if (p < 0 || gap >= best || maker->number[q * nu + p] < 0) continue;
            best = gap;
            found = maker->number[q * nu + p];
          }
        }
      }
      double middle[3];
      if (found >= 0)
        maker->out->area[found] += facet_cell(maker, facet, c, (double)i, (double)j, middle);
    }
}

/* The reflection of x through an edge or vertex of the owners and the rivals in `which`. */
static sph_status add_nose(ghost_maker *maker, const sphi_wall_side *side, int which,
                           const double *x, double volume) {
  double foot[3], mirror[3];
  sphi_wall_gates gates;
  for (int k = -1; k < side->owners; k++) {
    /* Behind a side wall at the end of the edge it is that wall's image of the reflection. */
    const int also = k < 0 ? -1 : side->owner[k];
    if (!sphi_wall_gate_nose(maker->wall, side, which, also, x, maker->tolerance, foot, &gates))
      continue;
    if (sphi_gap(x, foot) > maker->depth) continue; /* out of sight from beyond the foot */
    for (int d = 0; d < 3; d++) mirror[d] = 2 * foot[d] - x[d];
    if (!mirror_in_fluid(maker, mirror, foot)) continue;
    int64_t number;
    return add_ghost(maker, x, mirror, foot, volume, true, &gates, &number);
  }
  return SPH_OK;
}

/* The ghost of one side of the solid at x unless another side has it, and the reflections through sharp
 * edges and vertices near it. */
static sph_status add_ghosts(ghost_maker *maker, const sphi_wall_side *behind, const double *x,
                             const double *mirror, const double *foot, double volume, bool vertex,
                             int64_t *number) {
  sphi_wall_side side = *behind;
  sphi_wall_gates gates;
  *number = -1;
  if (!belongs(maker, x, foot, &side)) return SPH_OK;
  sphi_wall_gate_side(maker->wall, &side, x, &gates);
  SPH_TRY(add_ghost(maker, x, mirror, foot, volume, vertex, &gates, number));
  for (int which = 1; which < 1 << side.rivals; which++)
    SPH_TRY(add_nose(maker, &side, which, x, volume));
  return SPH_OK;
}

static sph_status make_strip(ghost_maker *maker, int k) {
  const sphi_wall_facet *facet = &maker->wall->facet[k];
  const sphi_wall_side side = {.owners = 1, .owner = {k}};
  const cells c = count_cells(maker, facet);
  const int64_t nu = (int64_t)c.nu, nv = (int64_t)c.nv;
  if (!sphi_reserve(maker->wall->context, (void **)&maker->number, &maker->number_capacity, nu * nv,
                    sizeof *maker->number))
    return no_memory(maker);
  for (int layer = 0; layer < maker->layers; layer++) {
    const double s = (layer + 0.5) * maker->spacing;
    for (int64_t cell = 0; cell < nu * nv; cell++) {
      const double i = (double)(cell % nu), j = (double)(cell / nu);
      double foot[3], x[3], mirror[3];
      double volume = maker->spacing * facet_cell(maker, facet, c, i, j, foot);
      int64_t number = -1;
      for (int d = 0; d < 3; d++) {
        x[d] = foot[d] - s * facet->normal[d];
        mirror[d] = foot[d] + s * facet->normal[d];
      }
      if (maker->wall->dim == 2 && (facet->clip[0] > 0 || facet->clip[1] > 0))
        volume = maker->spacing * (c.nu * c.width - near_boundary(maker, k, 0, i, c.width, s) -
                                   near_boundary(maker, k, 1, c.nu - 1 - i, c.width, s));
      if (volume > 0) SPH_TRY(add_ghosts(maker, &side, x, mirror, foot, volume, false, &number));
      if (layer == 0) maker->number[cell] = number;
    }
    if (layer == 0) spread_area(maker, facet, c);
  }
  return SPH_OK;
}

/* The cross-section behind an edge: u and e are perpendicular, the wedge spans `opening` from u. */
typedef struct section {
  double u[3], e[3], opening;
  bool square;
} section;

static section wedge_section(const sph_wall *wall, const int *facet) {
  section s = {.square = false};
  double v[3];
  for (int d = 0; d < 3; d++) {
    s.u[d] = -wall->facet[facet[0]].normal[d];
    v[d] = -wall->facet[facet[1]].normal[d];
  }
  const double cosine = sphi_dot(s.u, v);
  for (int d = 0; d < 3; d++) s.e[d] = v[d] - cosine * s.u[d];
  const double sine = sphi_length(s.e);
  for (int d = 0; d < 3; d++) s.e[d] /= sine;
  s.opening = atan2(sine, cosine);
  s.square = fabs(cosine) < 1e-9;
  return s;
}

static double ring_places(const ghost_maker *maker, const section *s, int ring) {
  return intervals((ring + 0.5) * maker->spacing * s->opening, maker->spacing);
}

static double count_places(const ghost_maker *maker, const section *s) {
  if (s->square) return (double)maker->layers * maker->layers;
  double count = 0;
  for (int ring = 0; ring < maker->layers; ring++) count += ring_places(maker, s, ring);
  return count;
}

static wedge_place *add_place(ghost_maker *maker) {
  if (!sphi_reserve(maker->wall->context, (void **)&maker->place, &maker->place_capacity,
                    maker->places + 1, sizeof *maker->place))
    return NULL;
  return &maker->place[maker->places++];
}

/* The lattice that continues both strips. */
static sph_status make_square(ghost_maker *maker, const section *s) {
  for (int k = 0; k < maker->layers; k++)
    for (int l = 0; l < maker->layers; l++) {
      wedge_place *place = add_place(maker);
      if (!place) return no_memory(maker);
      for (int d = 0; d < 3; d++) {
        place->offset[d] = maker->spacing * ((k + 0.5) * s->u[d] + (l + 0.5) * s->e[d]);
        place->mirror[d] = -place->offset[d];
      }
      place->area = maker->spacing * maker->spacing;
    }
  return SPH_OK;
}

/* Rings of radius spacing/2, 3/2 spacing ... each split evenly. Where the fluid's angle is below 90
 * degrees the reflection through the vertex would leave it, so that directions are compressed about
 * the bisector. */
static sph_status make_rings(ghost_maker *maker, const section *s) {
  const double fluid = SPHI_WALL_PI - s->opening;
  const double compression = s->opening > SPHI_WALL_PI / 2 + 1e-9 ? 0.9 * fluid / s->opening : 1;
  for (int ring = 0; ring < maker->layers; ring++) {
    const double r = (ring + 0.5) * maker->spacing, n = ring_places(maker, s, ring);
    for (double k = 0; k < n; k++) {
      wedge_place *place = add_place(maker);
      if (!place) return no_memory(maker);
      const double angle = (k + 0.5) / n * s->opening;
      const double image = s->opening / 2 + compression * (angle - s->opening / 2);
      for (int d = 0; d < 3; d++) {
        place->offset[d] = r * (cos(angle) * s->u[d] + sin(angle) * s->e[d]);
        place->mirror[d] = -r * (cos(image) * s->u[d] + sin(image) * s->e[d]);
      }
      place->area = r * s->opening * maker->spacing / n;
    }
  }
  return SPH_OK;
}

static sph_status make_places(ghost_maker *maker, const int *facet) {
  const section s = wedge_section(maker->wall, facet);
  maker->places = 0;
  return s.square ? make_square(maker, &s) : make_rings(maker, &s);
}

/* A ghost at each place of the wedge seen from `foot`, moved by `shift` into the solid. */
static sph_status make_wedge_ghosts(ghost_maker *maker, const double *foot, const double *shift,
                                    double depth, const sphi_wall_side *side) {
  for (int64_t k = 0; k < maker->places; k++) {
    const wedge_place *place = &maker->place[k];
    double x[3], mirror[3];
    for (int d = 0; d < 3; d++) {
      x[d] = foot[d] + place->offset[d] + shift[d];
      mirror[d] = foot[d] + place->mirror[d] - shift[d];
    }
    int64_t number;
    SPH_TRY(add_ghosts(maker, side, x, mirror, foot, place->area * depth, true, &number));
  }
  return SPH_OK;
}

static double wedge_intervals(const ghost_maker *maker, const sphi_wall_wedge *wedge) {
  return maker->wall->dim == 2 ? 1 : intervals(sphi_gap(wedge->a, wedge->b), maker->spacing);
}

static sph_status make_wedge(ghost_maker *maker, const sphi_wall_wedge *wedge) {
  static const double no_shift[3] = {0};
  const sphi_wall_side side = {.owners = 2, .owner = {wedge->facet[0], wedge->facet[1]}};
  SPH_TRY(make_places(maker, wedge->facet));
  const double n = wedge_intervals(maker, wedge);
  const double depth = maker->wall->dim == 2 ? 1 : sphi_gap(wedge->a, wedge->b) / n;
  for (double k = 0; k < n; k++) {
    double foot[3];
    for (int d = 0; d < 3; d++)
      foot[d] = maker->wall->dim == 2 ? wedge->a[d]
                                      : wedge->a[d] + (k + 0.5) / n * (wedge->b[d] - wedge->a[d]);
    SPH_TRY(make_wedge_ghosts(maker, foot, no_shift, depth, &side));
  }
  return SPH_OK;
}

static sph_status make_corner(ghost_maker *maker, const sphi_wall_corner *corner) {
  const sphi_wall_side side = {.owners = 3,
                               .owner = {corner->facet[0], corner->facet[1], corner->facet[2]}};
  SPH_TRY(make_places(maker, corner->facet));
  const double *normal = maker->wall->facet[corner->facet[2]].normal;
  for (int layer = 0; layer < maker->layers; layer++) {
    double shift[3];
    for (int d = 0; d < 3; d++) shift[d] = -(layer + 0.5) * maker->spacing * normal[d];
    SPH_TRY(make_wedge_ghosts(maker, corner->x, shift, maker->spacing, &side));
  }
  return SPH_OK;
}

/* How many places there are to try, at most. */
static double count_ghosts(const ghost_maker *maker) {
  const sph_wall *wall = maker->wall;
  double count = 0;
  for (int k = 0; k < wall->facets; k++) {
    const cells c = count_cells(maker, &wall->facet[k]);
    count += c.nu * c.nv * maker->layers;
  }
  for (int64_t k = 0; k < wall->wedges; k++) {
    const section s = wedge_section(wall, wall->wedge[k].facet);
    count += count_places(maker, &s) * wedge_intervals(maker, &wall->wedge[k]);
  }
  for (int64_t k = 0; k < wall->corners; k++) {
    const section s = wedge_section(wall, wall->corner[k].facet);
    count += count_places(maker, &s) * maker->layers;
  }
  return count;
}

static sph_status make_all(ghost_maker *maker) {
  const sph_wall *wall = maker->wall;
  for (int k = 0; k < wall->facets; k++) SPH_TRY(make_strip(maker, k));
  for (int64_t k = 0; k < wall->wedges; k++) SPH_TRY(make_wedge(maker, &wall->wedge[k]));
  for (int64_t k = 0; k < wall->corners; k++) SPH_TRY(make_corner(maker, &wall->corner[k]));
  return SPH_OK;
}

sph_status sphi_wall_make_ghosts(const sph_wall *wall, double spacing, double depth,
                                 sphi_ghost_points *out) {
  sph_context *context = wall->context;
  SPH_CHECK(context, isfinite(spacing) && spacing > 0, SPH_E_ARGUMENT,
            "wall \"%s\": spacing of its ghosts must be > 0 m, got %g", wall->name, spacing);
  SPH_CHECK(context, isfinite(depth) && depth > 0, SPH_E_ARGUMENT,
            "wall \"%s\": depth of its ghosts must be > 0 m, got %g", wall->name, depth);
  SPH_CHECK(context, out->n == 0 || out->dim == wall->dim, SPH_E_ARGUMENT,
            "wall \"%s\": its %dD ghosts cannot follow %dD ones", wall->name, wall->dim, out->dim);
  const double layers = fmax(1, ceil(depth / spacing - 1e-9));
  SPH_CHECK(context, layers <= 10000, SPH_E_ARGUMENT,
            "wall \"%s\": depth %g m is %g layers of %g m; at most 10000", wall->name, depth,
            layers, spacing);
  ghost_maker maker = {.wall = wall,
                       .out = out,
                       .spacing = spacing,
                       .depth = layers * spacing,
                       .tolerance = fmax(1e-9 * spacing, 1e-14 * wall->size),
                       .layers = (int)layers};
  const double count = count_ghosts(&maker);
  SPH_CHECK(context, (double)out->n + count <= INT32_MAX, SPH_E_ARGUMENT,
            "wall \"%s\": spacing %g m asks for %g ghosts; at most %d", wall->name, spacing, count,
            INT32_MAX);
  const int64_t n = out->n, skipped = out->skipped, gated = out->gated_count;
  if (n == 0 && out->dim != wall->dim) {
    sphi_ghost_points_free(context, out);
    out->dim = wall->dim;
    out->skipped = skipped;
  }
  /* At once, so that no half of the room stays empty. */
  const sph_status status =
      reserve_points(context, out, n + (int64_t)count) ? make_all(&maker) : no_memory(&maker);
  sphi_free(context, maker.place);
  sphi_free(context, maker.number);
  if (status != SPH_OK) {
    out->n = n;
    out->skipped = skipped;
    out->gated_count = gated;
  }
  return status;
}
