/* Geometry of walls: boxes over halves of the facet range, and the nearest point. Facets that
 * follow each other are near each other in practice, so the range itself is the tree. */
#include "wall/wall_geometry.h"

enum { LEAF = 4 };

static void grow_box(double *box, const double *lo, const double *hi) {
  for (int d = 0; d < 3; d++) {
    box[d] = fmin(box[d], lo[d]);
    box[3 + d] = fmax(box[3 + d], hi[d]);
  }
}

static void build_node(sph_wall *wall, size_t node, int begin, int end) {
  double *box = wall->node[node];
  for (int d = 0; d < 3; d++) {
    box[d] = INFINITY;
    box[3 + d] = -INFINITY;
  }
  if (end - begin <= LEAF) {
    const int corners = wall->dim == 2 ? 2 : 4;
    for (int k = begin; k < end; k++)
      for (int c = 0; c < corners; c++)
        grow_box(box, wall->facet[k].corner[c], wall->facet[k].corner[c]);
    return;
  }
  const int middle = begin + (end - begin) / 2;
  build_node(wall, 2 * node + 1, begin, middle);
  build_node(wall, 2 * node + 2, middle, end);
  grow_box(box, wall->node[2 * node + 1], wall->node[2 * node + 1] + 3);
  grow_box(box, wall->node[2 * node + 2], wall->node[2 * node + 2] + 3);
}

static void finish_facet(sphi_wall_facet *facet, int dim) {
  const int corners = dim == 2 ? 2 : 4;
  for (int c = 0; c < corners; c++)
    for (int d = 0; d < 3; d++) facet->middle[d] += facet->corner[c][d] / corners;
  double along[3], across[3];
  if (dim == 2) {
    sphi_subtract(facet->corner[1], facet->corner[0], along);
    facet->normal[0] = -along[1];
    facet->normal[1] = along[0];
  } else {
    sphi_subtract(facet->corner[2], facet->corner[0], along);
    sphi_subtract(facet->corner[3], facet->corner[1], across);
    sphi_cross(along, across, facet->normal);
    for (int c = 0; c < 4; c++) {
      sphi_subtract(facet->corner[(c + 1) % 4], facet->corner[c], along);
      sphi_subtract(facet->corner[(c + 3) % 4], facet->corner[c], across);
      facet->angle[c] = acos(
          fmax(-1, fmin(1, sphi_dot(along, across) / (sphi_length(along) * sphi_length(across)))));
    }
  }
  const double length = sphi_length(facet->normal);
  for (int d = 0; d < 3; d++) facet->normal[d] = facet->normal[d] / length + 0.0; /* no -0 */
}

sph_status sphi_wall_finish_facets(sph_wall *wall) {
  size_t leaves = 1;
  while (leaves < (size_t)wall->facets) leaves *= 2;
  wall->node = sphi_alloc(wall->context, 2 * leaves, sizeof *wall->node);
  SPH_CHECK(wall->context, wall->node, SPH_E_MEMORY, "wall: no memory for %d facets", wall->facets);
  for (int k = 0; k < wall->facets; k++) finish_facet(&wall->facet[k], wall->dim);
  build_node(wall, 0, 0, wall->facets);
  const double *box = wall->node[0];
  for (int d = 0; d < 3; d++) {
    wall->size = fmax(wall->size, fmax(fabs(box[d]), fabs(box[3 + d])));
    wall->size = fmax(wall->size, box[3 + d] - box[d]);
  }
  return SPH_OK;
}

/* Nearest point of the segment; *end is 0 or 1 at its ends and -1 between them. */
static double closest_on_segment(const double *x, const double *a, const double *b, double *foot,
                                 int *end) {
  double ab[3], ax[3];
  sphi_subtract(b, a, ab);
  sphi_subtract(x, a, ax);
  const double t = sphi_dot(ax, ab) / sphi_dot(ab, ab);
  *end = t <= 1e-12 ? 0 : t >= 1 - 1e-12 ? 1 : -1;
  for (int d = 0; d < 3; d++) foot[d] = *end == 0 ? a[d] : *end == 1 ? b[d] : a[d] + t * ab[d];
  return sphi_gap(x, foot);
}

/* Nearest point of the facet, and the angle that the facet spans around it. */
static double closest_on_facet(const sph_wall *wall, const sphi_wall_facet *facet, const double *x,
                               double *foot, double *angle) {
  int end;
  *angle = 1;
  if (wall->dim == 2) return closest_on_segment(x, facet->corner[0], facet->corner[1], foot, &end);
  double from[3], best = INFINITY;
  sphi_subtract(x, facet->middle, from);
  const double height = sphi_dot(from, facet->normal);
  for (int d = 0; d < 3; d++) foot[d] = x[d] - height * facet->normal[d];
  bool inside = true;
  for (int c = 0; c < 4 && inside; c++) {
    double along[3], inward[3], to[3];
    sphi_subtract(facet->corner[(c + 1) % 4], facet->corner[c], along);
    sphi_cross(facet->normal, along, inward);
    sphi_subtract(foot, facet->corner[c], to);
    inside = sphi_dot(to, inward) > 1e-12 * wall->size * sphi_length(along);
  }
  if (inside) {
    *angle = 2 * SPHI_WALL_PI;
    return fabs(height);
  }
  for (int c = 0; c < 4; c++) {
    double on_edge[3];
    const double distance =
        closest_on_segment(x, facet->corner[c], facet->corner[(c + 1) % 4], on_edge, &end);
    if (distance >= best) continue;
    best = distance;
    memcpy(foot, on_edge, sizeof on_edge);
    *angle = end < 0 ? SPHI_WALL_PI : facet->angle[(c + end) % 4];
  }
  return best;
}

static double gap_to_box(const double *x, const double *box) {
  double square = 0;
  for (int d = 0; d < 3; d++) {
    const double gap = fmax(0, fmax(box[d] - x[d], x[d] - box[3 + d]));
    square += gap * gap;
  }
  return sqrt(square);
}

typedef struct nearest_search {
  const sph_wall *wall;
  const double *x;
  double bound;
  const sphi_wall_side *side; /* NULL: among all facets */
  bool rivals;
  sphi_wall_nearest *sum; /* NULL while only the smallest distance is sought */
} nearest_search;

/* A facet that has x in front of it can have no ghost there. */
static bool is_sought(const nearest_search *search, int facet) {
  if (!search->side) return true;
  double from[3];
  sphi_subtract(search->x, search->wall->facet[facet].middle, from);
  if (sphi_dot(from, search->wall->facet[facet].normal) >= 0) return false;
  const bool rival = sphi_wall_is_rival(search->wall, search->side, facet);
  return search->rivals ? rival && !sphi_wall_is_known(search->wall, search->side, facet) : !rival;
}

static void search_leaf(nearest_search *search, int begin, int end) {
  for (int k = begin; k < end; k++) {
    const sphi_wall_facet *facet = &search->wall->facet[k];
    double foot[3], angle, from[3];
    const double distance = closest_on_facet(search->wall, facet, search->x, foot, &angle);
    if (distance > search->bound || !is_sought(search, k)) continue;
    if (!search->sum) {
      search->bound = distance;
      continue;
    }
    sphi_subtract(search->x, foot, from);
    search->sum->side += angle * sphi_dot(from, facet->normal);
    if (search->sum->facet >= 0 && search->sum->facet < k) continue;
    search->sum->facet = k;
    memcpy(search->sum->foot, foot, sizeof foot);
  }
}

static void search_node(nearest_search *search, size_t node, int begin, int end) {
  if (end - begin <= LEAF) {
    search_leaf(search, begin, end);
    return;
  }
  const int middle = begin + (end - begin) / 2;
  const double left = gap_to_box(search->x, search->wall->node[2 * node + 1]);
  const double right = gap_to_box(search->x, search->wall->node[2 * node + 2]);
  if (right < left && right <= search->bound) search_node(search, 2 * node + 2, middle, end);
  if (left <= search->bound) search_node(search, 2 * node + 1, begin, middle);
  if (right >= left && right <= search->bound) search_node(search, 2 * node + 2, middle, end);
}

void sphi_wall_find_nearest(const sph_wall *wall, const double *x, double bound, double tolerance,
                            sphi_wall_nearest *nearest) {
  sphi_wall_find_nearest_of(wall, x, bound, tolerance, NULL, false, nearest);
}

void sphi_wall_find_nearest_of(const sph_wall *wall, const double *x, double bound,
                               double tolerance, const sphi_wall_side *side, bool rivals,
                               sphi_wall_nearest *nearest) {
  *nearest = (sphi_wall_nearest){.distance = INFINITY, .facet = -1};
  nearest_search search = {wall, x, bound, side, rivals, NULL};
  search_node(&search, 0, 0, wall->facets);
  const double smallest = search.bound;
  search.bound = smallest + tolerance;
  search.sum = nearest;
  if (isfinite(search.bound)) search_node(&search, 0, 0, wall->facets);
  if (nearest->facet >= 0) nearest->distance = smallest;
}

typedef struct box_search {
  const sph_wall *wall;
  const double *lo, *hi;
  sphi_wall_visit visit;
  void *state;
} box_search;

static bool overlaps(const box_search *search, const double *box) {
  for (int d = 0; d < 3; d++)
    if (box[d] > search->hi[d] || box[3 + d] < search->lo[d]) return false;
  return true;
}

static bool search_box(const box_search *search, size_t node, int begin, int end) {
  if (!overlaps(search, search->wall->node[node])) return true;
  if (end - begin <= LEAF) {
    for (int k = begin; k < end; k++)
      if (!search->visit(search->state, k)) return false;
    return true;
  }
  const int middle = begin + (end - begin) / 2;
  return search_box(search, 2 * node + 1, begin, middle) &&
         search_box(search, 2 * node + 2, middle, end);
}

void sphi_wall_overlapping(const sph_wall *wall, const double *lo, const double *hi,
                           sphi_wall_visit visit, void *state) {
  const box_search search = {wall, lo, hi, visit, state};
  search_box(&search, 0, 0, wall->facets);
}
