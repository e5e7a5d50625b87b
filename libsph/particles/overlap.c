/* Finds points that are too close, with a hashed grid: time grows with the number of points only,
 * however far apart they are. */
#include <stdio.h>

#include "particles/particles_impl.h"

typedef struct grid {
  int dim;
  double cell; /* the minimum distance: what is closer is in a neighbouring cell */
  double lo[SPHI_MAX_DIM], hi[SPHI_MAX_DIM]; /* around all points that will be inserted */
  const double *x;                           /* [count, dim] */
  uint64_t mask;
  sph_index *head; /* [mask + 1] the first point of a bucket, plus 1 */
  sph_index *next; /* [count] the following one, plus 1 */
} grid;

/* Cells are numbered in double: no position is too far away for it. */
static uint64_t bucket(const grid *g, const double *cell) {
  uint64_t hash = 0;
  for (int d = 0; d < g->dim; d++) {
    const double number = cell[d] + 0.0; /* makes -0 the same as 0 */
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    /* The low bits of small whole numbers in double are all 0: bring the high ones down first. */
    hash = (hash ^ bits ^ (bits >> 32)) * 0x9e3779b97f4a7c15u;
    hash = (hash ^ (hash >> 32)) * 0xbf58476d1ce4e5b9u;
    hash ^= hash >> 32;
  }
  return hash & g->mask;
}

static void insert(grid *g, sph_index k) {
  double cell[SPHI_MAX_DIM] = {0};
  for (int d = 0; d < g->dim; d++) cell[d] = floor(g->x[(int64_t)k * g->dim + d] / g->cell);
  const uint64_t b = bucket(g, cell);
  g->next[k] = g->head[b];
  g->head[b] = k + 1;
}

/* An inserted point closer than the cell size (to 1e-6 of it) to x, or -1. */
static sph_index find_close(const grid *g, const double *x) {
  const double limit = g->cell * (1 - 1e-6);
  double cell[SPHI_MAX_DIM] = {0};
  for (int d = 0; d < g->dim; d++) {
    if (!(x[d] >= g->lo[d] - g->cell && x[d] <= g->hi[d] + g->cell)) return -1;
    cell[d] = floor(x[d] / g->cell);
  }
  const int cells = g->dim == 2 ? 9 : 27;
  for (int c = 0; c < cells; c++) {
    const double near[SPHI_MAX_DIM] = {cell[0] + (c % 3 - 1), cell[1] + (c / 3 % 3 - 1),
                                       cell[2] + (c / 9 - 1)};
    for (sph_index k = g->head[bucket(g, near)]; k; k = g->next[k - 1]) {
      double r2 = 0;
      for (int d = 0; d < g->dim; d++) {
        const double dx = g->x[(int64_t)(k - 1) * g->dim + d] - x[d];
        r2 += dx * dx;
      }
      if (r2 < limit * limit) return k - 1;
    }
  }
  return -1;
}

enum { PLACE = 96 };

static void print_place(char text[PLACE], int dim, const double *x) {
  if (dim == 2)
    snprintf(text, PLACE, "(%.9g, %.9g)", x[0], x[1]);
  else
    snprintf(text, PLACE, "(%.9g, %.9g, %.9g)", x[0], x[1], x[2]);
}

/* `id` is that of the particle at x, or -1 if that one is new too. */
static sph_status report(const sph_particles *particles, const double *added, const double *x,
                         int64_t id, double minimum) {
  char there[PLACE], here[PLACE], which[32] = "another new one";
  print_place(here, particles->dim, added);
  print_place(there, particles->dim, x);
  if (id >= 0) snprintf(which, sizeof which, "particle %lld", (long long)id);
  double r2 = 0;
  for (int d = 0; d < particles->dim; d++) r2 += (added[d] - x[d]) * (added[d] - x[d]);
  return SPHI_ERROR(
      particles->context, SPH_E_ARGUMENT,
      "particles \"%s\": fluid overlapping itself: a new particle at %s m is %g m from %s "
      "at %s m; they must be at least %g m apart",
      particles->name, here, sqrt(r2), which, there, minimum);
}

static sph_status check(const sph_particles *particles, grid *g, int64_t count, bool among) {
  for (int64_t k = 0; k < count; k++) {
    const double *x = g->x + k * g->dim;
    const sph_index other = among ? find_close(g, x) : -1;
    if (other >= 0) return report(particles, x, g->x + (int64_t)other * g->dim, -1, g->cell);
    insert(g, (sph_index)k);
  }
  for (sph_index r = 0; r < particles->n; r++) {
    const sph_index slot = particles->slot[r];
    double x[SPHI_MAX_DIM] = {0};
    for (int d = 0; d < g->dim; d++) x[d] = particles->field[SPHI_X].data[d][slot];
    const sph_index added = find_close(g, x);
    if (added >= 0)
      return report(particles, g->x + (int64_t)added * g->dim, x, particles->id[slot], g->cell);
  }
  return SPH_OK;
}

sph_status sphi_particles_check_distance(const sph_particles *particles, int64_t count,
                                         const double *x, double minimum, bool among) {
  if (particles->n == 0 && (!among || count < 2)) return SPH_OK;
  sph_context *context = particles->context;
  grid g = {.dim = particles->dim, .cell = minimum, .x = x};
  for (int d = 0; d < g.dim; d++) {
    g.lo[d] = g.hi[d] = x[d];
    for (int64_t k = 1; k < count; k++) {
      g.lo[d] = fmin(g.lo[d], x[k * g.dim + d]);
      g.hi[d] = fmax(g.hi[d], x[k * g.dim + d]);
    }
  }
  uint64_t buckets = 16;
  while (buckets < 2 * (uint64_t)count) buckets *= 2;
  g.mask = buckets - 1;
  g.head = SPHI_NEW(context, buckets, sph_index);
  g.next = SPHI_NEW(context, count, sph_index);
  sph_status status;
  if (g.head && g.next)
    status = check(particles, &g, count, among);
  else
    status =
        SPHI_ERROR(context, SPH_E_MEMORY, "particles \"%s\": no memory to compare %lld positions",
                   particles->name, (long long)count);
  sphi_free(context, g.head);
  sphi_free(context, g.next);
  return status;
}
