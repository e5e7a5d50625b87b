#include "sweep/columns.h"

#include <stdlib.h>

void sphi_frame_set(sphi_frame *frame, int dim, const double *origin, double radius,
                    const bool *periodic, const double *lo, const double *hi) {
  memset(frame, 0, sizeof *frame);
  frame->dim = dim;
  frame->step = ldexp(radius, -24); /* differences below the radius are exact in float */
  frame->uniform = true;
  for (int d = 0; d < dim; d++) {
    frame->origin[d] = origin[d];
    frame->unit[d] = frame->step;
    if (periodic && periodic[d]) {
      frame->periodic[d] = true;
      frame->uniform = false;
      frame->lo[d] = frame->origin[d] = lo[d];
      frame->length[d] = hi[d] - lo[d];
      frame->unit[d] = ldexp(frame->length[d], -32);
    }
    frame->per_unit[d] = 1 / frame->unit[d];
  }
}

void sphi_columns_free(sph_context *context, sphi_columns *columns) {
  sphi_free(context, columns->order);
  sphi_free(context, columns->z);
  for (int d = 0; d < SPHI_MAX_DIM; d++) sphi_free(context, columns->fixed[d]);
  sphi_free(context, columns->start);
  sphi_free(context, columns->key);
  sphi_free(context, columns->table);
  sphi_free(context, columns->bin);
  sphi_free(context, columns->merged);
  sphi_free(context, columns->fill);
  memset(columns, 0, sizeof *columns);
}

static uint64_t hash_key(int32_t k0, int32_t k1) {
  uint64_t h = ((uint64_t)(uint32_t)k0 << 32 | (uint32_t)k1) * 0x9e3779b97f4a7c15ull;
  return h ^ h >> 29;
}

int32_t sphi_columns_find(const sphi_columns *columns, int32_t k0, int32_t k1) {
  if (columns->size[0]) {
    const uint32_t a0 = (uint32_t)k0 - (uint32_t)columns->low[0];
    const uint32_t a1 = (uint32_t)k1 - (uint32_t)columns->low[1];
    if (a0 >= (uint32_t)columns->size[0] || a1 >= (uint32_t)columns->size[1]) return -1;
    return columns->table[(int64_t)a0 * columns->size[1] + a1];
  }
  if (!columns->table_size) return -1;
  const uint64_t mask = (uint64_t)columns->table_size - 1;
  for (uint64_t at = hash_key(k0, k1) & mask;; at = (at + 1) & mask) {
    const int32_t c = columns->table[at];
    if (c < 0 || (columns->key[2 * c] == k0 && columns->key[2 * c + 1] == k1)) return c;
  }
}

static void table_put(sphi_columns *columns, int32_t c) {
  const uint64_t mask = (uint64_t)columns->table_size - 1;
  uint64_t at = hash_key(columns->key[2 * c], columns->key[2 * c + 1]) & mask;
  while (columns->table[at] >= 0) at = (at + 1) & mask;
  columns->table[at] = c;
}

static bool reserve_points(sph_context *context, sphi_columns *columns, int32_t n) {
  const int64_t room = (int64_t)n + 16; /* the pair loops read a whole vector past the end */
  if (room <= columns->point_capacity) return true;
  int64_t wanted = columns->point_capacity + columns->point_capacity / 2;
  if (wanted < room) wanted = room;
  sphi_free(context, columns->order);
  sphi_free(context, columns->z);
  sphi_free(context, columns->bin);
  sphi_free(context, columns->merged);
  columns->order = SPHI_NEW(context, wanted, int32_t);
  columns->z = SPHI_NEW(context, wanted, double);
  columns->bin = SPHI_NEW(context, wanted, int32_t);
  columns->merged = SPHI_NEW(context, wanted, double);
  bool ok = columns->order && columns->z && columns->bin && columns->merged;
  for (int d = 0; d < SPHI_MAX_DIM; d++) {
    sphi_free(context, columns->fixed[d]);
    columns->fixed[d] = d < columns->dim ? SPHI_NEW(context, wanted, uint32_t) : NULL;
    ok = ok && (d >= columns->dim || columns->fixed[d]);
  }
  columns->point_capacity = ok ? wanted : 0;
  return ok;
}

static bool reserve_table(sph_context *context, sphi_columns *columns, int64_t size) {
  columns->table_size = 0;
  if (!sphi_reserve(context, (void **)&columns->table, &columns->table_capacity, size,
                    sizeof *columns->table))
    return false;
  columns->table_size = size;
  return true;
}

static bool reserve_hash(sph_context *context, sphi_columns *columns, int64_t entries) {
  int64_t size = 64;
  while (size < 2 * entries) size *= 2;
  if (!reserve_table(context, columns, size)) return false;
  for (int64_t k = 0; k < size; k++) columns->table[k] = -1;
  return true;
}

static bool reserve_columns(sph_context *context, sphi_columns *columns, int64_t count) {
  return sphi_reserve(context, (void **)&columns->key, &columns->column_capacity, count,
                      2 * sizeof *columns->key) &&
         sphi_reserve(context, (void **)&columns->start, &columns->start_capacity, count + 1,
                      sizeof *columns->start);
}

static const double too_far = 1e9; /* columns from the origin */

/* Columns from the origin to a coordinate. */
static inline double column_place(const sphi_columns *columns, const sphi_frame *frame, int d,
                                  double x) {
  return (sphi_frame_wrap(frame, d, x) - frame->origin[d]) * columns->per_width[d];
}

/* The whole columns in a place, which is not too far; floor() is a call where processors may be old. */
static inline int32_t column_number(const sphi_columns *columns, int d, double place) {
  int32_t number = (int32_t)place;
  number -= number > place;
  if (columns->around[d] && number >= columns->around[d]) number = columns->around[d] - 1;
  return number;
}

/* True if a point can be sorted; k: its column's numbers. */
static inline bool point_column(const sphi_columns *columns, const sphi_frame *frame, const int dim,
                                double *const *x, int32_t i, int32_t k[2]) {
  bool fits = true;
  k[0] = k[1] = 0;
  for (int d = 0; d < dim; d++) {
    /* Periodic or not, the coordinate itself must not be far. */
    fits = fits && fabs((x[d][i] - frame->origin[d]) * columns->per_width[d]) < too_far;
    if (d < dim - 1 && fits)
      k[d] = column_number(columns, d, column_place(columns, frame, d, x[d][i]));
  }
  return fits;
}

static sph_status refuse_point(sph_context *context, const sphi_columns *columns,
                               const sphi_frame *frame, double *const *x, const char *owner) {
  int32_t i = 0, k[2];
  while (point_column(columns, frame, columns->dim, x, i, k)) i++;
  return SPHI_ERROR(context, SPH_E_DIVERGED,
                    "%s: point %d at (%g, %g, %g) is not finite or too far away to be sorted",
                    owner, i, x[0][i], x[1][i], columns->dim == 3 ? x[2][i] : 0.0);
}

/* ------------------------------------------------------------------------- which columns exist */

/* One sort: what its threads share. */
typedef struct sorting {
  sphi_columns *columns;
  const sphi_frame *frame;
  double *const *x;
  const int32_t *rank;
  int parts;    /* shares of the points, in order, and of the columns */
  int64_t bins; /* columns, or places of the box */
  bool hashed;
} sorting;

static int32_t share(int32_t n, int part, int parts) {
  return (int32_t)((int64_t)n * part / parts);
}

/* The box of all columns; SPH_E_DIVERGED if a point has none. */
static sph_status find_box(sph_context *context, const sorting *s, const char *owner, int64_t lo[2],
                           int64_t hi[2]) {
  const int32_t n = s->columns->n;
  int32_t lo0 = INT32_MAX, lo1 = INT32_MAX, hi0 = INT32_MIN, hi1 = INT32_MIN, bad = 0;
#pragma omp parallel for num_threads(s->parts) schedule(static) if (s->parts > 1) \
    reduction(min : lo0, lo1) reduction(max : hi0, hi1) reduction(+ : bad)
  for (int32_t i = 0; i < n; i++) {
    int32_t k[2];
    if (!point_column(s->columns, s->frame, s->columns->dim, s->x, i, k)) {
      bad++;
      continue;
    }
    lo0 = k[0] < lo0 ? k[0] : lo0;
    lo1 = k[1] < lo1 ? k[1] : lo1;
    hi0 = k[0] > hi0 ? k[0] : hi0;
    hi1 = k[1] > hi1 ? k[1] : hi1;
  }
  if (bad) return refuse_point(context, s->columns, s->frame, s->x, owner);
  lo[0] = lo0;
  lo[1] = lo1;
  hi[0] = hi0;
  hi[1] = hi1;
  return SPH_OK;
}

/* Most places that a box may have. */
static int64_t box_limit(const sphi_columns *columns) { return (int64_t)columns->n + 1024; }

/* Chooses the box, with a rim for points that move, or none if it would be mostly empty. */
static sph_status choose_box(sph_context *context, sorting *s, const char *owner) {
  sphi_columns *columns = s->columns;
  int64_t lo[2], hi[2], places = 1;
  SPH_TRY(find_box(context, s, owner, lo, hi));
  columns->size[0] = columns->size[1] = 0;
  for (int d = 0; d < 2 && places <= box_limit(columns); d++) {
    const int64_t rim = d < columns->dim - 1 ? 1 + (hi[d] - lo[d]) / 16 : 0;
    lo[d] -= rim;
    hi[d] += rim;
    places *= hi[d] - lo[d] + 1;
  }
  if (places > box_limit(columns)) return SPH_OK;
  for (int d = 0; d < 2; d++) {
    columns->low[d] = (int32_t)lo[d];
    columns->size[d] = (int32_t)(hi[d] - lo[d] + 1);
  }
  return SPH_OK;
}

static int compare_keys(const void *a, const void *b) {
  const int32_t *k = a, *l = b;
  if (k[0] != l[0]) return k[0] < l[0] ? -1 : 1;
  return (k[1] > l[1]) - (k[1] < l[1]);
}

/* Without a box: gives every point its column and finds the columns by hash, numbered by position. */
static sph_status hash_points(sph_context *context, const sorting *s, const char *owner) {
  sphi_columns *columns = s->columns;
  SPH_CHECK(context, reserve_hash(context, columns, 64), SPH_E_MEMORY,
            "%s: no memory for the cell grid", owner);
  columns->columns = 0;
  for (int32_t i = 0; i < columns->n; i++) {
    int32_t k[2];
    if (!point_column(columns, s->frame, columns->dim, s->x, i, k))
      return refuse_point(context, columns, s->frame, s->x, owner);
    int32_t c = i > 0 ? columns->bin[i - 1] : -1;
    if (c < 0 || columns->key[2 * c] != k[0] || columns->key[2 * c + 1] != k[1])
      c = sphi_columns_find(columns, k[0], k[1]);
    if (c < 0) {
      c = columns->columns;
      SPH_CHECK(context, reserve_columns(context, columns, (int64_t)c + 1), SPH_E_MEMORY,
                "%s: no memory for the cell grid", owner);
      columns->key[2 * c] = k[0];
      columns->key[2 * c + 1] = k[1];
      columns->columns++;
      if (2 * (int64_t)columns->columns > columns->table_size) {
        SPH_CHECK(context, reserve_hash(context, columns, 2 * (int64_t)columns->columns),
                  SPH_E_MEMORY, "%s: no memory for the cell grid", owner);
        for (int32_t o = 0; o < columns->columns; o++) table_put(columns, o);
      } else {
        table_put(columns, c);
      }
    }
    columns->bin[i] = c;
  }
  const int32_t count = columns->columns;
  int32_t(*old)[2] = (int32_t(*)[2])(void *)columns->merged, *renumber = columns->start;
  memcpy(old, columns->key, (size_t)count * sizeof *old);
  qsort(columns->key, (size_t)count, sizeof *old, compare_keys);
  for (int64_t k = 0; k < columns->table_size; k++) columns->table[k] = -1;
  for (int32_t c = 0; c < count; c++) table_put(columns, c);
  for (int32_t c = 0; c < count; c++)
    renumber[c] = sphi_columns_find(columns, old[c][0], old[c][1]);
  for (int32_t i = 0; i < columns->n; i++) columns->bin[i] = renumber[columns->bin[i]];
  return SPH_OK;
}

/* --------------------------------------------------------------------------------------- sorting */

static int32_t *counts_of(const sorting *s, int part) { return s->columns->fill + part * s->bins; }

/* Where the points of a part go, bin by bin; one part alone needs no counts beside its places. */
static int32_t *places_of(const sorting *s, int part) {
  return counts_of(s, s->parts > 1 ? s->parts + part : 0);
}

/* Counts a part's points in every bin; false if one is not in the box. */
static inline __attribute__((always_inline)) bool count_points(const sorting *s, const int dim,
                                                               int part) {
  const sphi_columns *columns = s->columns;
  int32_t *count = counts_of(s, part), *bin = columns->bin;
  memset(count, 0, (size_t)s->bins * sizeof *count);
  const int32_t end = share(columns->n, part + 1, s->parts);
  for (int32_t i = share(columns->n, part, s->parts); i < end; i++) {
    if (!s->hashed) {
      int32_t k[2];
      if (!point_column(columns, s->frame, dim, s->x, i, k)) return false;
      const uint32_t a0 = (uint32_t)k[0] - (uint32_t)columns->low[0];
      const uint32_t a1 = (uint32_t)k[1] - (uint32_t)columns->low[1];
      if (a0 >= (uint32_t)columns->size[0] || a1 >= (uint32_t)columns->size[1]) return false;
      bin[i] = (int32_t)(a0 * (uint32_t)columns->size[1] + a1);
    }
    count[bin[i]]++;
  }
  return true;
}

/* The places of a part's points from the counts of all; every part works them out for itself, since
 * waiting for one that did it for all would take longer. The first part writes the columns too. */
static void find_places(const sorting *s, int part) {
  sphi_columns *columns = s->columns;
  int32_t *place = places_of(s, part);
  int32_t at = 0, c = 0;
  for (int64_t b = 0; b < s->bins; b++) {
    const int32_t begin = at;
    int32_t own = at;
    for (int p = 0; p < s->parts; p++) {
      const int32_t count = counts_of(s, p)[b];
      at += count;
      if (p < part) own += count;
    }
    place[b] = own;
    if (part > 0) continue;
    if (!s->hashed) columns->table[b] = at > begin ? c : -1;
    if (at == begin) continue;
    columns->start[c] = begin;
    if (!s->hashed) {
      columns->key[2 * c] = columns->low[0] + (int32_t)(b / columns->size[1]);
      columns->key[2 * c + 1] = columns->low[1] + (int32_t)(b % columns->size[1]);
    }
    c++;
  }
  if (part > 0) return;
  columns->start[c] = columns->n;
  columns->columns = c;
}

static void place_points(const sorting *s, int part) {
  sphi_columns *columns = s->columns;
  const int last = columns->dim - 1;
  int32_t *place = places_of(s, part);
  const int32_t end = share(columns->n, part + 1, s->parts);
  for (int32_t i = share(columns->n, part, s->parts); i < end; i++) {
    const int32_t at = place[columns->bin[i]]++;
    columns->order[at] = i;
    columns->z[at] = sphi_frame_wrap(s->frame, last, s->x[last][i]);
  }
}

/* Whether point a goes before point b of the same column. */
static inline bool goes_before(double za, int32_t a, double zb, int32_t b, const int32_t *rank) {
  return za < zb || (za == zb && (rank ? rank[a] < rank[b] : a < b));
}

/* Merge sort on runs of 16 by insertion, in which what is in order already costs nothing: linear for
 * points that are nearly in order. The scratch holds n of each. */
static void sort_column(double *z, int32_t *point, double *z_left, int32_t *left, int32_t n,
                        const int32_t *rank) {
  enum { RUN = 16 };
  for (int32_t begin = 0; begin < n; begin += RUN) {
    const int32_t end = n - begin > RUN ? begin + RUN : n;
    for (int32_t k = begin + 1; k < end; k++) {
      const double z_moving = z[k];
      const int32_t moving = point[k];
      int32_t at = k;
      for (; at > begin && goes_before(z_moving, moving, z[at - 1], point[at - 1], rank); at--) {
        z[at] = z[at - 1];
        point[at] = point[at - 1];
      }
      z[at] = z_moving;
      point[at] = moving;
    }
  }
  for (int64_t run = RUN; run < n; run *= 2) {
    for (int64_t begin = 0; begin + run < n; begin += 2 * run) {
      const int32_t middle = (int32_t)(begin + run);
      const int32_t end = n - middle > run ? (int32_t)(middle + run) : n;
      int32_t out = middle;
      while (out > begin && goes_before(z[middle], point[middle], z[out - 1], point[out - 1], rank))
        out--;
      const int32_t count = middle - out;
      memcpy(z_left, z + out, (size_t)count * sizeof *z);
      memcpy(left, point + out, (size_t)count * sizeof *point);
      for (int32_t a = 0, b = middle; a < count; out++) {
        const bool right = b < end && goes_before(z[b], point[b], z_left[a], left[a], rank);
        z[out] = right ? z[b] : z_left[a];
        point[out] = right ? point[b++] : left[a++];
      }
    }
  }
}

static void fix_points(sphi_columns *columns, const sphi_frame *frame, double *const *x,
                       int32_t begin, int32_t end) {
  for (int d = 0; d < frame->dim; d++)
    for (int32_t k = begin; k < end; k++)
      columns->fixed[d][k] = sphi_frame_fix(frame, d, x[d][columns->order[k]]);
}

/* First column that starts at `place` or later. */
static int32_t column_from(const sphi_columns *columns, int32_t place) {
  int32_t first = 0, last = columns->columns;
  while (first < last) {
    const int32_t middle = first + (last - first) / 2;
    if (columns->start[middle] < place)
      first = middle + 1;
    else
      last = middle;
  }
  return first;
}

static void sort_columns(const sorting *s, int part) {
  sphi_columns *columns = s->columns;
  const int32_t from = column_from(columns, share(columns->n, part, s->parts));
  const int32_t to = column_from(columns, share(columns->n, part + 1, s->parts));
  for (int32_t c = from; c < to; c++) {
    const int32_t begin = columns->start[c], end = columns->start[c + 1];
    sort_column(columns->z + begin, columns->order + begin, columns->merged + begin,
                columns->bin + begin, end - begin, s->rank);
    fix_points(columns, s->frame, s->x, begin, end);
  }
}

/* False if a point is not in the box. */
static bool sort_points(const sorting *s) {
  int outside = 0;
#pragma omp parallel num_threads(s->parts) if (s->parts > 1)
  {
#pragma omp for schedule(static, 1) reduction(+ : outside)
    for (int p = 0; p < s->parts; p++)
      outside += !(s->columns->dim == 2 ? count_points(s, 2, p) : count_points(s, 3, p));
    if (outside == 0) {
#pragma omp for schedule(static, 1)
      for (int p = 0; p < s->parts; p++) {
        find_places(s, p);
        place_points(s, p);
      }
#pragma omp for schedule(static, 1) nowait
      for (int p = 0; p < s->parts; p++) sort_columns(s, p);
    }
  }
  return outside == 0;
}

static sph_status find_order(sph_context *context, sorting *s, const char *owner) {
  sphi_columns *columns = s->columns;
  const int threads = s->parts;
  const int64_t places = (int64_t)columns->size[0] * columns->size[1];
  bool known = places > 0 && places <= box_limit(columns);
  for (;;) {
    s->parts = threads;
    if (!known) SPH_TRY(choose_box(context, s, owner));
    s->hashed = columns->size[0] == 0;
    if (s->hashed) SPH_TRY(hash_points(context, s, owner));
    s->bins = s->hashed ? columns->columns : (int64_t)columns->size[0] * columns->size[1];
    /* The counts of all parts take less memory than the points. */
    if (s->parts > columns->n / s->bins) s->parts = (int)(columns->n / s->bins);
    if (s->parts < 1) s->parts = 1;
    const int64_t rows = s->parts > 1 ? 2 * s->parts : 1;
    const int64_t most = s->bins < columns->n ? s->bins : columns->n;
    SPH_CHECK(context,
              sphi_reserve(context, (void **)&columns->fill, &columns->fill_capacity,
                           rows * s->bins, sizeof *columns->fill) &&
                  reserve_columns(context, columns, most) &&
                  (s->hashed || reserve_table(context, columns, s->bins)),
              SPH_E_MEMORY, "%s: no memory for the cell grid", owner);
    if (sort_points(s)) return SPH_OK;
    known = false;
  }
}

/* Below this many points starting threads costs more than it gains. */
enum { PARALLEL_FROM = 8192, BOXES_PARALLEL_FROM = 65536 };

sph_status sphi_columns_build(sph_context *context, sphi_columns *columns, const sphi_frame *frame,
                              double width, int32_t n, double *const *x, const int32_t *rank,
                              const char *owner) {
  const int dim = frame->dim;
  columns->dim = dim;
  columns->n = n;
  columns->columns = 0;
  for (int d = 0; d < dim; d++) {
    columns->width[d] = width;
    columns->around[d] = 0;
    if (frame->periodic[d] && d < dim - 1) {
      const double around = floor(frame->length[d] / width);
      columns->around[d] = around < 1 ? 1 : around > 1e9 ? 1000000000 : (int32_t)around;
      columns->width[d] = frame->length[d] / columns->around[d];
    }
    columns->per_width[d] = 1 / columns->width[d];
  }
  if (n == 0) {
    columns->size[0] = columns->size[1] = 0;
    columns->table_size = 0;
    return SPH_OK;
  }
  sorting s = {.columns = columns,
               .frame = frame,
               .x = x,
               .rank = rank,
               .parts = n < PARALLEL_FROM ? 1 : context->threads};
  sph_status status = SPH_OK;
  if (reserve_points(context, columns, n))
    status = find_order(context, &s, owner);
  else
    status = SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory to sort %d points", owner, n);
  if (status != SPH_OK) {
    columns->n = columns->columns = columns->size[0] = columns->size[1] = 0;
    columns->table_size = 0;
  }
  return status;
}

void sphi_columns_fix(sph_context *context, sphi_columns *columns, const sphi_frame *frame,
                      double *const *x) {
  const int parts = columns->n < PARALLEL_FROM ? 1 : context->threads;
#pragma omp parallel for num_threads(parts) schedule(static, 1) if (parts > 1)
  for (int p = 0; p < parts; p++)
    fix_points(columns, frame, x, share(columns->n, p, parts), share(columns->n, p + 1, parts));
}

int32_t sphi_columns_lower(const sphi_columns *columns, int32_t c, double z) {
  int32_t begin = columns->start[c], end = columns->start[c + 1];
  while (begin < end) {
    const int32_t middle = begin + (end - begin) / 2;
    if (columns->z[middle] < z)
      begin = middle + 1;
    else
      end = middle;
  }
  return begin;
}

void sphi_columns_window(const sphi_columns *columns, const sphi_frame *frame, const double *lo,
                         const double *hi, double radius, sphi_window *window) {
  *window = (sphi_window){{0, 0}, {0, 0}};
  for (int d = 0; d < columns->dim - 1; d++) {
    const double from = floor((lo[d] - radius - frame->origin[d]) * columns->per_width[d]);
    const double to = floor((hi[d] + radius - frame->origin[d]) * columns->per_width[d]);
    window->from[d] = from > -1e9 ? from < 1e9 ? (int32_t)from : 1000000000 : -1000000000;
    window->to[d] = to > -1e9 ? to < 1e9 ? (int32_t)to : 1000000000 : -1000000000;
    if (columns->around[d] && window->to[d] - window->from[d] + 1 >= columns->around[d]) {
      window->from[d] = 0;
      window->to[d] = columns->around[d] - 1;
    }
  }
}

int32_t sphi_columns_in(const sphi_columns *columns, const sphi_window *window, int32_t room,
                        int32_t *found) {
  const int32_t *from = window->from, *to = window->to;
  int32_t count = 0;
  if (((int64_t)to[0] - from[0] + 1) * ((int64_t)to[1] - from[1] + 1) > columns->columns) {
    /* A wide window asks the columns that exist rather than the places where one could be. */
    for (int32_t c = 0; c < columns->columns; c++) {
      bool inside = true;
      for (int d = 0; d < columns->dim - 1; d++) {
        const int32_t k = columns->key[2 * c + d], n = columns->around[d];
        const int32_t wrapped = n ? from[d] + ((k - from[d]) % n + n) % n : k;
        inside = inside && wrapped >= from[d] && wrapped <= to[d];
      }
      if (!inside) continue;
      if (count < room) found[count] = c;
      count++;
    }
    return count;
  }
  for (int32_t k0 = from[0]; k0 <= to[0]; k0++) {
    for (int32_t k1 = from[1]; k1 <= to[1]; k1++) {
      int32_t k[2] = {k0, k1};
      for (int d = 0; d < columns->dim - 1; d++) {
        const int32_t n = columns->around[d];
        if (n) k[d] = (k[d] % n + n) % n;
      }
      const int32_t c = sphi_columns_find(columns, k[0], k[1]);
      if (c < 0) continue;
      if (count < room) found[count] = c;
      count++;
    }
  }
  return count;
}

int sphi_columns_range(const sphi_columns *columns, const sphi_frame *frame, int32_t c, double lo,
                       double hi, int32_t ranges[3][2]) {
  const int last = frame->dim - 1;
  if (!frame->periodic[last]) {
    ranges[0][0] = sphi_columns_lower(columns, c, lo);
    ranges[0][1] = sphi_columns_lower(columns, c, nextafter(hi, HUGE_VAL));
    return ranges[0][0] < ranges[0][1];
  }
  const double length = frame->length[last], start = frame->lo[last];
  if (hi - lo >= length) {
    ranges[0][0] = columns->start[c];
    ranges[0][1] = columns->start[c + 1];
    return ranges[0][0] < ranges[0][1];
  }
  const double shift = length * floor((lo - start) / length);
  int count = 0;
  for (int image = 0; image < 2; image++) {
    const double a = lo - shift - image * length, b = hi - shift - image * length;
    ranges[count][0] = sphi_columns_lower(columns, c, a);
    ranges[count][1] = sphi_columns_lower(columns, c, nextafter(b, HUGE_VAL));
    count += ranges[count][0] < ranges[count][1];
  }
  return count;
}

void sphi_clusters_free(sph_context *context, sphi_clusters *clusters) {
  sphi_free(context, clusters->first);
  sphi_free(context, clusters->count);
  sphi_free(context, clusters->lo);
  sphi_free(context, clusters->hi);
  memset(clusters, 0, sizeof *clusters);
}

static bool reserve_clusters(sph_context *context, sphi_clusters *clusters, int64_t count,
                             int dim) {
  int64_t capacity[4] = {clusters->capacity, clusters->capacity, clusters->box_capacity,
                         clusters->box_capacity};
  const bool ok =
      sphi_reserve(context, (void **)&clusters->first, &capacity[0], count, sizeof(int32_t)) &&
      sphi_reserve(context, (void **)&clusters->count, &capacity[1], count, sizeof(int32_t)) &&
      sphi_reserve(context, (void **)&clusters->lo, &capacity[2], count * dim, sizeof(double)) &&
      sphi_reserve(context, (void **)&clusters->hi, &capacity[3], count * dim, sizeof(double));
  clusters->capacity = capacity[0] < capacity[1] ? capacity[0] : capacity[1];
  clusters->box_capacity = capacity[2] < capacity[3] ? capacity[2] : capacity[3];
  return ok;
}

/* Cuts the columns and returns how many clusters that makes; NULL: only counts them. */
static int32_t cut(const sphi_columns *columns, int lanes, double extent, sphi_clusters *clusters) {
  int32_t n = 0;
  for (int32_t c = 0; c < columns->columns; c++) {
    const int32_t end = columns->start[c + 1];
    for (int32_t first = columns->start[c]; first < end;) {
      const double *z = columns->z + first;
      int32_t count = end - first < lanes ? end - first : lanes;
      while (z[count - 1] - z[0] > extent) count--;
      if (clusters) {
        clusters->first[n] = first;
        clusters->count[n] = count;
      }
      n++;
      first += count;
    }
  }
  return n;
}

sph_status sphi_clusters_build(sph_context *context, sphi_clusters *clusters,
                               const sphi_columns *columns, const sphi_frame *frame,
                               double *const *x, int lanes, double extent) {
  const int dim = columns->dim;
  clusters->lanes = lanes;
  clusters->n = 0;
  const int32_t count = cut(columns, lanes, extent, NULL);
  /* With head room, since how many it takes varies a little from sort to sort. */
  if (count > clusters->capacity || (int64_t)count * dim > clusters->box_capacity)
    SPH_CHECK(context, reserve_clusters(context, clusters, (int64_t)count + count / 8 + 16, dim),
              SPH_E_MEMORY, "no memory for %d clusters of particles", count);
  clusters->n = cut(columns, lanes, extent, clusters);
#pragma omp parallel for num_threads(context->threads) \
    schedule(static) if (columns->n >= BOXES_PARALLEL_FROM)
  for (int32_t k = 0; k < clusters->n; k++) {
    const int32_t *point = columns->order + clusters->first[k];
    const int32_t last = clusters->count[k] - 1;
    for (int d = 0; d < dim - 1; d++) {
      double lo = HUGE_VAL, hi = -HUGE_VAL;
      for (int32_t l = 0; l <= last; l++) {
        const double at = sphi_frame_wrap(frame, d, x[d][point[l]]);
        lo = at < lo ? at : lo;
        hi = at > hi ? at : hi;
      }
      clusters->lo[dim * k + d] = lo;
      clusters->hi[dim * k + d] = hi;
    }
    clusters->lo[dim * k + dim - 1] = columns->z[clusters->first[k]];
    clusters->hi[dim * k + dim - 1] = columns->z[clusters->first[k] + last];
  }
  return SPH_OK;
}
