/* Searches: life, settings, update, and queries over whichever method was built. */
#include <stdio.h>

#include "search/search_impl.h"

static const double largest_coordinate = 1e100;

#define SEARCH_ERROR(search, code, format, ...)                              \
  SPHI_ERROR((search)->context, code, "search of particles \"%s\": " format, \
             (search)->particles->name, __VA_ARGS__)

sph_status sph_search_create(sph_context *context, const sph_particles *particles, double radius,
                             sph_search **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "search: out must not be NULL");
  *out = NULL;
  SPH_CHECK(context, context, SPH_E_ARGUMENT, "search: context must not be NULL");
  SPH_CHECK(context, particles, SPH_E_ARGUMENT, "search: particles must not be NULL");
  SPH_CHECK(context, particles->context == context, SPH_E_ARGUMENT,
            "search of particles \"%s\": the particles belong to another context", particles->name);
  SPH_CHECK(context, radius >= 1e-100 && radius <= largest_coordinate, SPH_E_ARGUMENT,
            "search of particles \"%s\": radius must be > 0 m (1e-100 to 1e100), got %g",
            particles->name, radius);
  sph_search *search = SPHI_NEW(context, 1, sph_search);
  SPH_CHECK(context, search, SPH_E_MEMORY, "search of particles \"%s\": no memory",
            particles->name);
  sphi_context_retain(context);
  search->context = context;
  /* The set is only read, but counting a reference writes to it. */
  search->particles = (sph_particles *)particles;
  sphi_particles_retain(search->particles);
  search->radius = radius;
  search->method = SPH_SEARCH_CELL_GRID;
  search->dim = particles->dim;
  *out = search;
  return SPH_OK;
}

void sph_search_destroy(sph_search **search) {
  if (!search || !*search) return;
  sph_search *dead = *search;
  *search = NULL;
  sph_context *context = dead->context;
  sphi_columns_free(context, &dead->columns);
  for (int d = 0; d < SPHI_MAX_DIM; d++) sphi_free(context, dead->x[d]);
  sphi_free(context, dead->near);
  sphi_free(context, dead->column);
  sph_particles_destroy(&dead->particles);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sph_search_set_method(sph_search *search, sph_search_method method) {
  if (!search) return SPH_E_ARGUMENT;
  if (method != SPH_SEARCH_CELL_GRID && method != SPH_SEARCH_BRUTE_FORCE)
    return SEARCH_ERROR(search, SPH_E_ARGUMENT, "method must be one of sph_search_method, got %d",
                        (int)method);
  search->method = method;
  return SPH_OK;
}

sph_status sph_search_set_periodic(sph_search *search, int axis, double lo, double hi) {
  if (!search) return SPH_E_ARGUMENT;
  if (axis < 0 || axis >= search->dim)
    return SEARCH_ERROR(search, SPH_E_ARGUMENT, "axis must be 0 to %d, got %d", search->dim - 1,
                        axis);
  if (!(fabs(lo) <= largest_coordinate && fabs(hi) <= largest_coordinate && lo < hi))
    return SEARCH_ERROR(search, SPH_E_ARGUMENT,
                        "periodic axis %d needs finite lo < hi, got %g m to %g m", axis, lo, hi);
  if (search->radius > 0.5 * (hi - lo))
    return SEARCH_ERROR(search, SPH_E_ARGUMENT,
                        "support larger than half the periodic box along axis %d: radius %g m, box "
                        "%g m; widen the box or take a smaller radius",
                        axis, search->radius, hi - lo);
  search->periodic[axis] = true;
  search->lo[axis] = lo;
  search->hi[axis] = hi;
  return SPH_OK;
}

static double median(double a, double b, double c) { return fmax(fmin(a, b), fmin(fmax(a, b), c)); }

/* A point near the particles, also if one of them is lost: the middle of three, in each direction. */
static void find_origin(const sph_search *search, double *origin) {
  const sph_particles *particles = search->particles;
  const sph_index n = particles->n;
  for (int d = 0; d < search->dim; d++) {
    const double *x = particles->field[SPHI_X].data[d];
    origin[d] =
        n ? median(x[particles->slot[0]], x[particles->slot[n / 2]], x[particles->slot[n - 1]]) : 0;
    if (!isfinite(origin[d])) origin[d] = 0;
  }
}

/* All positions are finite and have a place in the grid. */
static sph_status check_positions(const sph_search *search, const double *origin) {
  const sph_particles *particles = search->particles;
  const double most = 1e9 * search->radius;
  for (sph_index i = 0; i < particles->n; i++) {
    const sph_index at = particles->slot[i];
    double x[SPHI_MAX_DIM] = {0};
    bool finite = true, close = true;
    for (int d = 0; d < search->dim; d++) {
      x[d] = particles->field[SPHI_X].data[d][at];
      const double from = search->periodic[d] ? search->lo[d] : origin[d];
      finite = finite && isfinite(x[d]);
      close = close && fabs(x[d] - from) <= 0.999 * most;
    }
    if (finite && close) continue;
    char where[96];
    if (search->dim == 2)
      snprintf(where, sizeof where, "(%g, %g)", x[0], x[1]);
    else
      snprintf(where, sizeof where, "(%g, %g, %g)", x[0], x[1], x[2]);
    if (!finite)
      return SEARCH_ERROR(search, SPH_E_DIVERGED,
                          "particle %lld at %s m is not finite; write its position or remove it",
                          (long long)particles->id[at], where);
    return SEARCH_ERROR(
        search, SPH_E_DIVERGED,
        "particle %lld at %s m is more than 1e9 radii (%g m) from the others; write "
        "its position or remove it",
        (long long)particles->id[at], where, most);
  }
  return SPH_OK;
}

static sph_status copy_positions(sph_search *search) {
  const sph_particles *particles = search->particles;
  const sph_index n = particles->n;
  if (n > search->capacity) {
    search->capacity = 0;
    bool ok = true;
    for (int d = 0; d < search->dim; d++) {
      sphi_free(search->context, search->x[d]);
      search->x[d] = SPHI_NEW(search->context, n, double);
      ok = ok && search->x[d];
    }
    if (!ok) return SEARCH_ERROR(search, SPH_E_MEMORY, "no memory for %d positions", (int)n);
    search->capacity = n;
  }
  for (int d = 0; d < search->dim; d++) {
    const double *x = particles->field[SPHI_X].data[d];
    double *to = search->x[d];
#pragma omp parallel for num_threads(search->context->threads) schedule(static)
    for (sph_index i = 0; i < n; i++)
      to[i] = sphi_frame_wrap(&search->frame, d, x[particles->slot[i]]);
  }
  search->n = n;
  return SPH_OK;
}

sph_status sphi_search_reserve(sph_search *search, int64_t count) {
  if (!sphi_reserve(search->context, (void **)&search->near, &search->near_capacity,
                    search->near_count + count, sizeof *search->near))
    return SEARCH_ERROR(search, SPH_E_MEMORY, "no memory for %lld neighbours",
                        (long long)(search->near_count + count));
  return SPH_OK;
}

sph_status sph_search_update(sph_search *search) {
  if (!search) return SPH_E_ARGUMENT;
  double origin[SPHI_MAX_DIM] = {0};
  find_origin(search, origin);
  SPH_TRY(check_positions(search, origin));
  search->rows = NULL;
  sphi_frame_set(&search->frame, search->dim, origin, search->radius, search->periodic, search->lo,
                 search->hi);
  SPH_TRY(copy_positions(search));
  const sphi_search_rows *rows =
      search->method == SPH_SEARCH_BRUTE_FORCE ? &sphi_brute_force : &sphi_cell_grid;
  SPH_TRY(rows->build(search));
  search->near_count = 0;
  SPH_TRY(sphi_search_reserve(search, 256));
  search->revision = search->particles->revision;
  search->rows = rows;
  return SPH_OK;
}

static sph_status check_fresh(const sph_search *search) {
  if (!search->rows)
    return SEARCH_ERROR(search, SPH_E_STALE, "%s", "not built yet; call sph_search_update()");
  if (search->revision != search->particles->revision)
    return SEARCH_ERROR(search, SPH_E_STALE,
                        "built at revision %lld, particles at %lld; call sph_search_update()",
                        (long long)search->revision, (long long)search->particles->revision);
  return SPH_OK;
}

static sph_status check_arrays(const sph_search *search, int64_t room, const sph_index *index,
                               const double *distance, const int64_t *count) {
  if (room < 0)
    return SEARCH_ERROR(search, SPH_E_ARGUMENT, "room must be >= 0, got %lld", (long long)room);
  if (!count || (room > 0 && !(index && distance)))
    return SEARCH_ERROR(search, SPH_E_ARGUMENT, "%s must not be NULL",
                        !count   ? "count"
                        : !index ? "index"
                                 : "distance");
  return SPH_OK;
}

static sph_status check_point(const sph_search *search, const double *x) {
  if (!x) return SEARCH_ERROR(search, SPH_E_ARGUMENT, "%s must not be NULL", "x");
  for (int d = 0; d < search->dim; d++)
    if (!(fabs(x[d]) <= largest_coordinate))
      return SEARCH_ERROR(search, SPH_E_ARGUMENT, "x[%d] must be finite and at most %g m, got %g m",
                          d, largest_coordinate, x[d]);
  return SPH_OK;
}

static bool near_before(const sphi_near *a, const sphi_near *b) {
  return a->distance < b->distance || (a->distance == b->distance && a->index < b->index);
}

static void sift_down(sphi_near *near, int64_t at, int64_t n) {
  const sphi_near moving = near[at];
  for (int64_t child; (child = 2 * at + 1) < n; at = child) {
    if (child + 1 < n && near_before(&near[child], &near[child + 1])) child++;
    if (!near_before(&moving, &near[child])) break;
    near[at] = near[child];
  }
  near[at] = moving;
}

/* Sorts the first `wanted` of n to the front: a heap of them, which every nearer one enters. */
static void sort_nearest(sphi_near *near, int64_t n, int64_t wanted) {
  if (wanted > n) wanted = n;
  if (wanted <= 0) return;
  for (int64_t k = wanted / 2; k-- > 0;) sift_down(near, k, wanted);
  for (int64_t k = wanted; k < n; k++) {
    if (!near_before(&near[k], &near[0])) continue;
    near[0] = near[k];
    sift_down(near, 0, wanted);
  }
  for (int64_t k = wanted - 1; k > 0; k--) {
    const sphi_near farthest = near[0];
    near[0] = near[k];
    near[k] = farthest;
    sift_down(near, 0, k);
  }
}

static void write_nearest(sph_search *search, int64_t room, sph_index *index, double *distance) {
  sort_nearest(search->near, search->near_count, room);
  for (int64_t k = 0; k < room && k < search->near_count; k++) {
    index[k] = search->near[k].index;
    distance[k] = search->near[k].distance;
  }
}

/* x moved into the box that was built for. */
static void wrap_point(const sph_search *search, const double *x, double *wrapped) {
  for (int d = 0; d < search->dim; d++) wrapped[d] = sphi_frame_wrap(&search->frame, d, x[d]);
}

sph_status sph_search_find_near_point(sph_search *search, const double *x, int64_t room,
                                      sph_index *index, double *distance, int64_t *count) {
  if (!search) return SPH_E_ARGUMENT;
  SPH_TRY(check_point(search, x));
  SPH_TRY(check_arrays(search, room, index, distance, count));
  SPH_TRY(check_fresh(search));
  double wrapped[SPHI_MAX_DIM];
  wrap_point(search, x, wrapped);
  search->near_count = 0;
  SPH_TRY(search->rows->collect(search, wrapped, search->radius));
  write_nearest(search, room, index, distance);
  *count = search->near_count;
  return SPH_OK;
}

sph_status sph_search_find_near_particle(sph_search *search, sph_index i, int64_t room,
                                         sph_index *index, double *distance, int64_t *count) {
  if (!search) return SPH_E_ARGUMENT;
  SPH_TRY(check_arrays(search, room, index, distance, count));
  SPH_TRY(check_fresh(search));
  if (i < 0 || i >= search->n)
    return SEARCH_ERROR(search, SPH_E_ARGUMENT, "i must be 0 to %d, got %d", (int)search->n - 1,
                        (int)i);
  double x[SPHI_MAX_DIM];
  for (int d = 0; d < search->dim; d++) x[d] = search->x[d][i];
  search->near_count = 0;
  SPH_TRY(search->rows->collect(search, x, search->radius));
  for (int64_t k = 0; k < search->near_count; k++) {
    if (search->near[k].index != i) continue;
    search->near[k] = search->near[--search->near_count];
    break;
  }
  write_nearest(search, room, index, distance);
  *count = search->near_count;
  return SPH_OK;
}

sph_status sph_search_find_nearest(sph_search *search, const double *x, int64_t k, sph_index *index,
                                   double *distance, int64_t *found) {
  if (!search) return SPH_E_ARGUMENT;
  SPH_TRY(check_point(search, x));
  if (k < 0) return SEARCH_ERROR(search, SPH_E_ARGUMENT, "k must be >= 0, got %lld", (long long)k);
  if (!found || (k > 0 && !(index && distance)))
    return SEARCH_ERROR(search, SPH_E_ARGUMENT, "%s must not be NULL",
                        !found   ? "found"
                        : !index ? "index"
                                 : "distance");
  SPH_TRY(check_fresh(search));
  const int64_t wanted = k < search->n ? k : search->n;
  double wrapped[SPHI_MAX_DIM];
  wrap_point(search, x, wrapped);
  search->near_count = 0;
  if (wanted > 0) SPH_TRY(search->rows->collect_nearest(search, wrapped, wanted));
  write_nearest(search, wanted, index, distance);
  *found = wanted;
  return SPH_OK;
}

sph_status sph_search_count_pairs(sph_search *search, int64_t *pairs) {
  if (!search) return SPH_E_ARGUMENT;
  if (!pairs) return SEARCH_ERROR(search, SPH_E_ARGUMENT, "%s must not be NULL", "pairs");
  SPH_TRY(check_fresh(search));
  int64_t sum = 0;
#pragma omp parallel for num_threads(search->context->threads) schedule(static) reduction(+ : sum)
  for (sph_index i = 0; i < search->n; i++) sum += search->rows->count_after(search, i);
  *pairs = sum;
  return SPH_OK;
}
