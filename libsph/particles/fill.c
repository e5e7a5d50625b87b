/* Fills regions with particles on a lattice. Every region is the part of a box for which a function
 * says "inside". */
#include "particles/particles_impl.h"

/* What counts as a touch, in spacings: well above round-off, well below anything that matters. */
#define TOUCH 1e-6
/* Farther from the origin, in spacings, the round-off of positions would show in their distances. */
#define FARTHEST 1e12

typedef struct lattice {
  int dim;
  double lo[SPHI_MAX_DIM];
  double dx;
  int64_t n[SPHI_MAX_DIM]; /* 1 beyond the last dimension */
} lattice;

static sph_status make_lattice(const sph_particles *particles, const double *lo, const double *hi,
                               lattice *out) {
  sph_context *context = particles->context;
  const char *name = particles->name;
  const double dx = particles->spacing, farthest = FARTHEST * dx;
  *out = (lattice){.dim = particles->dim, .dx = dx, .n = {1, 1, 1}};
  SPH_CHECK(context, lo && hi, SPH_E_ARGUMENT, "particles \"%s\": lo and hi must not be NULL",
            name);
  double total = 1;
  double wide[SPHI_MAX_DIM] = {1, 1, 1};
  for (int d = 0; d < out->dim; d++) {
    const char axis = "xyz"[d];
    SPH_CHECK(context, fabs(lo[d]) <= farthest && fabs(hi[d]) <= farthest, SPH_E_ARGUMENT,
              "particles \"%s\": the region must be finite and within %g m of the origin (1e12 "
              "spacings), got %c from %g to %g m",
              name, farthest, axis, lo[d], hi[d]);
    wide[d] = floor((hi[d] - lo[d]) / dx + TOUCH);
    SPH_CHECK(
        context, wide[d] >= 1, SPH_E_ARGUMENT,
        "particles \"%s\": the region must be at least one spacing (%g m) wide along %c, got %g m "
        "from %g to %g m",
        name, dx, axis, hi[d] - lo[d], lo[d], hi[d]);
    out->lo[d] = lo[d];
    total *= wide[d];
  }
  SPH_TRY(sphi_particles_check_room(particles, total));
  for (int d = 0; d < out->dim; d++) out->n[d] = (int64_t)wide[d];
  return SPH_OK;
}

/* The points of the lattice that are inside (all if inside is NULL): *x [*count, dim], to be freed by
 * the caller, also after an error. */
static sph_status collect(const sph_particles *particles, const lattice *at,
                          sph_inside_function inside, void *user, void **x, int64_t *count) {
  sph_context *context = particles->context;
  const size_t bytes = (size_t)at->dim * sizeof(double);
  int64_t capacity = 0;
  const int64_t first = inside ? 1 : at->n[0] * at->n[1] * at->n[2];
  *count = 0;
  if (!sphi_reserve(context, x, &capacity, first, bytes)) goto memory;
  for (int64_t i = 0; i < at->n[0]; i++)
    for (int64_t j = 0; j < at->n[1]; j++)
      for (int64_t k = 0; k < at->n[2]; k++) {
        const double point[SPHI_MAX_DIM] = {at->lo[0] + ((double)i + 0.5) * at->dx,
                                            at->lo[1] + ((double)j + 0.5) * at->dx,
                                            at->lo[2] + ((double)k + 0.5) * at->dx};
        if (inside && !inside(point, user)) continue;
        if (!sphi_reserve(context, x, &capacity, *count + 1, bytes)) goto memory;
        memcpy((double *)*x + *count * at->dim, point, bytes);
        ++*count;
      }
  SPH_CHECK(
      context, *count > 0, SPH_E_ARGUMENT,
      "particles \"%s\": no point of the lattice with spacing %g m is inside the region; use a "
      "smaller spacing",
      particles->name, at->dx);
  return SPH_OK;
memory:
  return SPHI_ERROR(context, SPH_E_MEMORY,
                    "particles \"%s\": no memory for the positions of a region", particles->name);
}

static sph_status fill(sph_particles *particles, const double *lo, const double *hi, double density,
                       sph_inside_function inside, void *user) {
  lattice at;
  SPH_TRY(sphi_particles_check_density(particles, density));
  SPH_TRY(make_lattice(particles, lo, hi, &at));
  void *x = NULL;
  int64_t count = 0;
  sph_status status = collect(particles, &at, inside, user, &x, &count);
  if (status == SPH_OK)
    status = sphi_particles_check_distance(particles, count, x, 0.5 * particles->spacing, false);
  if (status == SPH_OK) status = sphi_particles_append(particles, count, x, density);
  sphi_free(particles->context, x);
  return status;
}

sph_status sph_particles_fill_box(sph_particles *particles, const double *lo, const double *hi,
                                  double density) {
  if (!particles) return SPH_E_ARGUMENT;
  return fill(particles, lo, hi, density, NULL, NULL);
}

sph_status sph_particles_fill_predicate(sph_particles *particles, const double *lo,
                                        const double *hi, sph_inside_function inside, void *user,
                                        double density) {
  if (!particles) return SPH_E_ARGUMENT;
  SPH_CHECK(particles->context, inside, SPH_E_ARGUMENT, "particles \"%s\": inside must not be NULL",
            particles->name);
  return fill(particles, lo, hi, density, inside, user);
}

/* Layers of a column whose middle is at x [dim - 1], and their thickness. */
static sph_status find_layers(const sph_particles *particles, const lattice *at, double top,
                              const double *x, sph_surface_function surface, void *user,
                              int64_t *layers, double *thickness) {
  const int up = at->dim - 1;
  const double level = surface(x, user), height = level - at->lo[up];
  SPH_CHECK(
      particles->context, isfinite(level) && level <= top, SPH_E_ARGUMENT,
      "particles \"%s\": the surface must be finite and not above %g m, got %g m at (%g, %g) m",
      particles->name, top, level, x[0], at->dim == 3 ? x[1] : 0.0);
  *layers = height > 0 ? (int64_t)floor(height / at->dx + 0.5) : 0;
  *thickness = *layers > 0 ? height / (double)*layers : 0;
  return SPH_OK;
}

sph_status sph_particles_fill_surface(sph_particles *particles, const double *lo, const double *hi,
                                      sph_surface_function surface, void *user, double density) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  lattice at;
  SPH_CHECK(context, surface, SPH_E_ARGUMENT, "particles \"%s\": surface must not be NULL",
            particles->name);
  SPH_TRY(sphi_particles_check_density(particles, density));
  SPH_TRY(make_lattice(particles, lo, hi, &at));
  const int dim = at.dim;
  const int64_t rows = dim == 3 ? at.n[1] : 1;
  double *x = NULL, *thickness = NULL;
  int64_t count = 0;
  sph_status status = SPH_OK;
  for (int pass = 0; pass < 2 && status == SPH_OK; pass++) { /* counts, then fills */
    if (pass == 1) {
      status = sphi_particles_check_room(particles, (double)count);
      if (status == SPH_OK && count == 0)
        status = SPHI_ERROR(context, SPH_E_ARGUMENT,
                            "particles \"%s\": no column reaches half a spacing of %g m",
                            particles->name, at.dx);
      if (status != SPH_OK) break;
      x = SPHI_NEW(context, count * dim, double);
      thickness = SPHI_NEW(context, count, double);
      if (!x || !thickness) {
        status = SPHI_ERROR(context, SPH_E_MEMORY, "particles \"%s\": no memory for %lld positions",
                            particles->name, (long long)count);
        break;
      }
    }
    int64_t next = 0;
    for (int64_t c = 0; c < at.n[0] * rows && status == SPH_OK; c++) {
      const double middle[2] = {at.lo[0] + ((double)(c / rows) + 0.5) * at.dx,
                                at.lo[1] + ((double)(c % rows) + 0.5) * at.dx};
      int64_t layers = 0;
      double high = 0;
      status = find_layers(particles, &at, hi[dim - 1], middle, surface, user, &layers, &high);
      for (int64_t k = 0; k < layers && status == SPH_OK; k++, next++) {
        if (pass == 0 || next >= count) continue; /* a surface that changed cannot write beyond */
        memcpy(x + next * dim, middle, (size_t)(dim - 1) * sizeof *x);
        x[next * dim + dim - 1] = at.lo[dim - 1] + ((double)k + 0.5) * high;
        thickness[next] = high;
      }
    }
    count = pass == 0 || next < count ? next : count;
  }
  if (status == SPH_OK)
    status = sphi_particles_check_distance(particles, count, x, 0.5 * particles->spacing, false);
  if (status == SPH_OK) status = sphi_particles_append(particles, count, x, density);
  for (int64_t k = 0; k < count && status == SPH_OK; k++) {
    const sph_index i = particles->slot[particles->n - count + k];
    double *volume = &particles->field[SPHI_VOL].data[0][i];
    *volume *= thickness[k] / at.dx;
    particles->field[SPHI_M].data[0][i] = density * *volume;
  }
  sphi_free(context, x);
  sphi_free(context, thickness);
  return status;
}

typedef struct half_spaces {
  int dim, planes;
  double touch;
  const double *points, *normals;
} half_spaces;

static double length(int dim, const double *vector) {
  double sum = 0;
  for (int d = 0; d < dim; d++) sum += vector[d] * vector[d];
  return sqrt(sum);
}

/* (x - point_k) . normal_k >= 0 for all k                                                        (1) */
static bool inside_half_spaces(const double *x, void *user) {
  const half_spaces *region = user;
  const int dim = region->dim;
  for (int k = 0; k < region->planes; k++) {
    const double *point = region->points + (size_t)k * (size_t)dim;
    const double *normal = region->normals + (size_t)k * (size_t)dim;
    double distance = 0;
    for (int d = 0; d < dim; d++) distance += (x[d] - point[d]) * normal[d];
    if (!(distance >= -region->touch * length(dim, normal))) return false;
  }
  return true;
}

sph_status sph_particles_fill_half_spaces(sph_particles *particles, const double *lo,
                                          const double *hi, int planes, const double *points,
                                          const double *normals, double density) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  const int dim = particles->dim;
  SPH_CHECK(
      context, planes >= 1, SPH_E_ARGUMENT,
      "particles \"%s\": planes must be >= 1, got %d; use sph_particles_fill_box without planes",
      particles->name, planes);
  SPH_CHECK(context, points && normals, SPH_E_ARGUMENT,
            "particles \"%s\": points and normals must not be NULL", particles->name);
  for (int k = 0; k < planes; k++) {
    const double *point = points + (size_t)k * (size_t)dim;
    const double *normal = normals + (size_t)k * (size_t)dim;
    for (int d = 0; d < dim; d++)
      SPH_CHECK(context, isfinite(point[d]), SPH_E_ARGUMENT,
                "particles \"%s\": point %d, component %d, must be finite, got %g", particles->name,
                k, d, point[d]);
    const double norm = length(dim, normal);
    SPH_CHECK(context, norm >= 1e-100 && norm <= 1e100, SPH_E_ARGUMENT,
              "particles \"%s\": normal %d must have a length > 0 (1e-100 to 1e100), got %g",
              particles->name, k, norm);
  }
  half_spaces region = {dim, planes, TOUCH * particles->spacing, points, normals};
  return fill(particles, lo, hi, density, inside_half_spaces, &region);
}

typedef struct polygon {
  int vertices;
  const double *xy;
  double shift;  /* a lattice point on an edge counts as moved by this to the right and a bit up */
  double column; /* the x that the crossings below belong to */
  int crossings; /* -1 before the first column */
  double *y;     /* [vertices] where edges cross the column */
} polygon;

static void cross_column(polygon *region, double x) {
  region->column = x;
  region->crossings = 0;
  const double moved = x + region->shift;
  for (int k = 0; k < region->vertices; k++) {
    const double *a = region->xy + 2 * (size_t)k;
    const double *b = region->xy + 2 * (size_t)((k + 1) % region->vertices);
    if ((a[0] <= moved) == (b[0] <= moved)) continue;
    region->y[region->crossings++] = a[1] + (moved - a[0]) * ((b[1] - a[1]) / (b[0] - a[0]));
  }
}

/* Inside when an odd number of edges lies below. Lattice points come column by column. */
static bool inside_polygon(const double *x, void *user) {
  polygon *region = user;
  if (region->crossings < 0 || x[0] != region->column) cross_column(region, x[0]);
  const double moved = x[1] + 0.618 * region->shift;
  bool inside = false;
  for (int k = 0; k < region->crossings; k++)
    if (region->y[k] < moved) inside = !inside;
  return inside;
}

/* > 0 when c is to the left of the line from a to b. */
static double side(const double *a, const double *b, const double *c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

static bool boxes_overlap(const double *a, const double *b, const double *c, const double *d) {
  for (int k = 0; k < 2; k++)
    if (fmax(a[k], b[k]) < fmin(c[k], d[k]) || fmax(c[k], d[k]) < fmin(a[k], b[k])) return false;
  return true;
}

/* Do the closed segments ab and cd have a point in common? */
static bool segments_meet(const double *a, const double *b, const double *c, const double *d) {
  if (!boxes_overlap(a, b, c, d)) return false;
  const double ab_c = side(a, b, c), ab_d = side(a, b, d), cd_a = side(c, d, a),
               cd_b = side(c, d, b);
  const bool apart_ab = (ab_c > 0 && ab_d > 0) || (ab_c < 0 && ab_d < 0);
  const bool apart_cd = (cd_a > 0 && cd_b > 0) || (cd_a < 0 && cd_b < 0);
  return !apart_ab && !apart_cd;
}

/* Does the edge bc turn back over ab? */
static bool folds_back(const double *a, const double *b, const double *c) {
  const double forward = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
  return side(a, b, c) == 0 && forward < 0;
}

static sph_status check_corners(const sph_particles *particles, int vertices, const double *xy) {
  for (int i = 0; i < vertices; i++) {
    const int end = (i + 1) % vertices;
    const double *a = xy + 2 * (size_t)i, *b = xy + 2 * (size_t)end;
    SPH_CHECK(
        particles->context, a[0] != b[0] || a[1] != b[1], SPH_E_ARGUMENT,
        "particles \"%s\": vertices %d and %d of the polygon are both at (%g, %g) m; leave one "
        "out, the polygon closes itself",
        particles->name, i, end, a[0], a[1]);
    SPH_CHECK(particles->context, !folds_back(a, b, xy + 2 * (size_t)((end + 1) % vertices)),
              SPH_E_ARGUMENT,
              "particles \"%s\": the polygon must not turn back on itself, but does at vertex %d, "
              "(%g, %g) m",
              particles->name, end, b[0], b[1]);
  }
  return SPH_OK;
}

static sph_status check_simple(const sph_particles *particles, int vertices, const double *xy) {
  SPH_TRY(check_corners(particles, vertices, xy));
  for (int i = 0; i < vertices; i++) {
    const double *a = xy + 2 * (size_t)i, *b = xy + 2 * (size_t)((i + 1) % vertices);
    for (int j = i + 2; j < vertices; j++) {
      const int end = (j + 1) % vertices;
      if (end == i) continue;
      const double *c = xy + 2 * (size_t)j, *d = xy + 2 * (size_t)end;
      SPH_CHECK(
          particles->context, !segments_meet(a, b, c, d), SPH_E_ARGUMENT,
          "particles \"%s\": the polygon must not intersect itself, but edges %d, (%g, %g) to "
          "(%g, %g) m, and %d, (%g, %g) to (%g, %g) m, meet",
          particles->name, i, a[0], a[1], b[0], b[1], j, c[0], c[1], d[0], d[1]);
    }
  }
  return SPH_OK;
}

sph_status sph_particles_fill_polygon(sph_particles *particles, int vertices, const double *xy,
                                      double density) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  const char *name = particles->name;
  SPH_CHECK(context, particles->dim == 2, SPH_E_ARGUMENT,
            "particles \"%s\": a polygon needs a set with dim 2, got %d; use "
            "sph_particles_fill_half_spaces or sph_particles_fill_predicate",
            name, particles->dim);
  SPH_CHECK(context, vertices >= 3, SPH_E_ARGUMENT,
            "particles \"%s\": a polygon must have at least 3 vertices, got %d", name, vertices);
  SPH_CHECK(context, xy, SPH_E_ARGUMENT, "particles \"%s\": xy must not be NULL", name);
  double lo[2] = {xy[0], xy[1]}, hi[2] = {xy[0], xy[1]};
  for (size_t k = 0; k < 2 * (size_t)vertices; k++) {
    SPH_CHECK(
        context, fabs(xy[k]) <= FARTHEST * particles->spacing, SPH_E_ARGUMENT,
        "particles \"%s\": vertex %zu, component %zu, must be finite and within %g m of the origin "
        "(1e12 spacings), got %g",
        name, k / 2, k % 2, FARTHEST * particles->spacing, xy[k]);
    lo[k % 2] = fmin(lo[k % 2], xy[k]);
    hi[k % 2] = fmax(hi[k % 2], xy[k]);
  }
  SPH_TRY(check_simple(particles, vertices, xy));
  polygon region = {.vertices = vertices, .xy = xy, .shift = TOUCH * particles->spacing};
  region.crossings = -1;
  region.y = SPHI_NEW(context, vertices, double);
  SPH_CHECK(context, region.y, SPH_E_MEMORY, "particles \"%s\": no memory for %d vertices", name,
            vertices);
  const sph_status status = fill(particles, lo, hi, density, inside_polygon, &region);
  sphi_free(context, region.y);
  return status;
}
