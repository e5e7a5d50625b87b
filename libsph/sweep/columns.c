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
  sphi_free(context, columns->entry);
  sphi_free(context, columns->entry_scratch);
  sphi_free(context, columns->column_of);
  memset(columns, 0, sizeof *columns);
}

static uint64_t hash_key(int32_t k0, int32_t k1) {
  uint64_t h = ((uint64_t)(uint32_t)k0 << 32 | (uint32_t)k1) * 0x9e3779b97f4a7c15ull;
  return h ^ h >> 29;
}

int32_t sphi_columns_find(const sphi_columns *columns, int32_t k0, int32_t k1) {
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
  sphi_free(context, columns->entry);
  sphi_free(context, columns->entry_scratch);
  sphi_free(context, columns->column_of);
  columns->order = SPHI_NEW(context, wanted, int32_t);
  columns->z = SPHI_NEW(context, wanted, double);
  columns->entry = SPHI_NEW(context, wanted, sphi_column_entry);
  columns->entry_scratch = SPHI_NEW(context, wanted, sphi_column_entry);
  columns->column_of = SPHI_NEW(context, wanted, int32_t);
  bool ok = columns->order && columns->z && columns->entry && columns->entry_scratch &&
            columns->column_of;
  for (int d = 0; d < SPHI_MAX_DIM; d++) {
    sphi_free(context, columns->fixed[d]);
    columns->fixed[d] = d < columns->dim ? SPHI_NEW(context, wanted, uint32_t) : NULL;
    ok = ok && (d >= columns->dim || columns->fixed[d]);
  }
  columns->point_capacity = ok ? wanted : 0;
  return ok;
}

static bool reserve_table(sph_context *context, sphi_columns *columns, int64_t entries) {
  int64_t size = 64;
  while (size < 2 * entries) size *= 2;
  if (size > columns->table_capacity) {
    sphi_free(context, columns->table);
    columns->table = SPHI_NEW(context, size, int32_t);
    columns->table_capacity = columns->table ? size : 0;
    if (!columns->table) return false;
  }
  columns->table_size = size;
  for (int64_t k = 0; k < size; k++) columns->table[k] = -1;
  return true;
}

/* Column number across direction d of a coordinate; false if it does not fit. */
static bool column_number(const sphi_columns *columns, const sphi_frame *frame, int d, double x,
                          int32_t *number) {
  const double base = frame->periodic[d] ? frame->lo[d] : frame->origin[d];
  if (!(fabs(x - base) < 1e9 * columns->width[d])) return false;
  const double k = floor((sphi_frame_wrap(frame, d, x) - base) / columns->width[d]);
  *number = (int32_t)k;
  if (columns->around[d] && *number >= columns->around[d]) *number = columns->around[d] - 1;
  return true;
}

/* Gives every point its column, numbered by first appearance. */
static sph_status find_columns(sph_context *context, sphi_columns *columns, const sphi_frame *frame,
                               double *const *x, const char *owner) {
  columns->columns = 0;
  if (!reserve_table(context, columns, 64))
    return SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory for the cell grid", owner);
  for (int32_t i = 0; i < columns->n; i++) {
    int32_t k[2] = {0, 0}, unused;
    bool fits = true;
    for (int d = 0; d < columns->dim; d++)
      fits =
          column_number(columns, frame, d, x[d][i], d < columns->dim - 1 ? &k[d] : &unused) && fits;
    if (!fits)
      return SPHI_ERROR(context, SPH_E_DIVERGED,
                        "%s: point %d at (%g, %g, %g) is not finite or too far away to be sorted",
                        owner, i, x[0][i], x[1][i], columns->dim == 3 ? x[2][i] : 0.0);
    int32_t c = sphi_columns_find(columns, k[0], k[1]);
    if (c < 0) {
      c = columns->columns;
      if (!sphi_reserve(context, (void **)&columns->key, &columns->column_capacity, c + 1,
                        2 * sizeof *columns->key))
        return SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory for the cell grid", owner);
      columns->key[2 * c] = k[0];
      columns->key[2 * c + 1] = k[1];
      columns->columns++;
      if (2 * (int64_t)columns->columns > columns->table_size) {
        if (!reserve_table(context, columns, 2 * (int64_t)columns->columns))
          return SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory for the cell grid", owner);
        for (int32_t o = 0; o < columns->columns; o++) table_put(columns, o);
      } else {
        table_put(columns, c);
      }
    }
    columns->column_of[i] = c;
  }
  return SPH_OK;
}

static bool entry_before(const sphi_column_entry *a, const sphi_column_entry *b) {
  return a->z < b->z || (a->z == b->z && a->rank < b->rank);
}

/* Merge sort on runs of 16 by insertion: linear for points that are nearly in order. */
static void sort_entries(sphi_column_entry *entry, sphi_column_entry *scratch, int32_t n) {
  enum { RUN = 16 };
  for (int32_t begin = 0; begin < n; begin += RUN) {
    const int32_t end = begin + RUN < n ? begin + RUN : n;
    for (int32_t k = begin + 1; k < end; k++) {
      const sphi_column_entry moving = entry[k];
      int32_t at = k;
      for (; at > begin && entry_before(&moving, &entry[at - 1]); at--) entry[at] = entry[at - 1];
      entry[at] = moving;
    }
  }
  for (int32_t run = RUN; run < n; run *= 2) {
    for (int32_t begin = 0; begin + run < n; begin += 2 * run) {
      const int32_t middle = begin + run, end = middle + run < n ? middle + run : n;
      if (!entry_before(&entry[middle], &entry[middle - 1])) continue;
      memcpy(scratch, entry + begin, (size_t)run * sizeof *entry);
      int32_t a = 0, b = middle, out = begin;
      while (a < run && b < end)
        entry[out++] = entry_before(&entry[b], &scratch[a]) ? entry[b++] : scratch[a++];
      while (a < run) entry[out++] = scratch[a++];
    }
    if (run > INT32_MAX / 2) break;
  }
}

static int compare_keys(const void *a, const void *b) {
  const int32_t *k = a, *l = b;
  if (k[0] != l[0]) return k[0] < l[0] ? -1 : 1;
  return (k[1] > l[1]) - (k[1] < l[1]);
}

/* Numbers the columns by position instead of by first appearance; start[] becomes offsets. */
static sph_status order_columns(sph_context *context, sphi_columns *columns, const char *owner) {
  const int32_t count = columns->columns;
  if (!sphi_reserve(context, (void **)&columns->start, &columns->start_capacity,
                    2 * (int64_t)count + 2, sizeof *columns->start))
    return SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory for the cell grid", owner);
  int32_t *renumber = columns->start + count + 1;
  int32_t(*sorted)[3] = (int32_t(*)[3])(void *)columns->entry_scratch; /* 12 <= 16 bytes a point */
  for (int32_t c = 0; c < count; c++) {
    sorted[c][0] = columns->key[2 * c];
    sorted[c][1] = columns->key[2 * c + 1];
    sorted[c][2] = c;
  }
  qsort(sorted, (size_t)count, sizeof sorted[0], compare_keys);
  for (int32_t c = 0; c < count; c++) {
    columns->key[2 * c] = sorted[c][0];
    columns->key[2 * c + 1] = sorted[c][1];
    renumber[sorted[c][2]] = c;
  }
  for (int64_t k = 0; k < columns->table_size; k++)
    if (columns->table[k] >= 0) columns->table[k] = renumber[columns->table[k]];
  memset(columns->start, 0, (size_t)(count + 1) * sizeof *columns->start);
  for (int32_t i = 0; i < columns->n; i++) {
    columns->column_of[i] = renumber[columns->column_of[i]];
    columns->start[columns->column_of[i] + 1]++;
  }
  for (int32_t c = 0; c < count; c++) columns->start[c + 1] += columns->start[c];
  return SPH_OK;
}

sph_status sphi_columns_build(sph_context *context, sphi_columns *columns, const sphi_frame *frame,
                              double width, int32_t n, double *const *x, const int32_t *rank,
                              const char *owner) {
  const int dim = frame->dim;
  columns->dim = dim;
  columns->n = n;
  for (int d = 0; d < dim; d++) {
    columns->width[d] = width;
    columns->around[d] = 0;
    if (!frame->periodic[d] || d == dim - 1) continue;
    const double around = floor(frame->length[d] / width);
    columns->around[d] = around < 1 ? 1 : around > 1e9 ? 1000000000 : (int32_t)around;
    columns->width[d] = frame->length[d] / columns->around[d];
  }
  if (!reserve_points(context, columns, n)) {
    columns->n = columns->columns = 0;
    return SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory to sort %d points", owner, n);
  }
  SPH_TRY(find_columns(context, columns, frame, x, owner));
  SPH_TRY(order_columns(context, columns, owner));
  int32_t *fill = columns->start + columns->columns + 1; /* the renumbering is done with */
  memcpy(fill, columns->start, (size_t)columns->columns * sizeof *fill);
  for (int32_t i = 0; i < n; i++) {
    const int32_t at = fill[columns->column_of[i]]++;
    columns->entry[at].z = sphi_frame_wrap(frame, dim - 1, x[dim - 1][i]);
    columns->entry[at].rank = rank ? rank[i] : i;
    columns->entry[at].point = i;
  }
#pragma omp parallel for num_threads(context->threads) schedule(static) if (n > 1024)
  for (int32_t c = 0; c < columns->columns; c++) {
    const int32_t begin = columns->start[c], end = columns->start[c + 1];
    sort_entries(columns->entry + begin, columns->entry_scratch + begin, end - begin);
    for (int32_t k = begin; k < end; k++) {
      columns->order[k] = columns->entry[k].point;
      columns->z[k] = columns->entry[k].z;
    }
  }
  sphi_columns_fix(context, columns, frame, x);
  return SPH_OK;
}

void sphi_columns_fix(sph_context *context, sphi_columns *columns, const sphi_frame *frame,
                      double *const *x) {
  (void)context; /* without OpenMP nobody asks it for its threads */
  for (int d = 0; d < frame->dim; d++) {
    uint32_t *fixed = columns->fixed[d];
    const double *from = x[d];
#pragma omp parallel for num_threads(context->threads) schedule(static) if (columns->n > 1024)
    for (int32_t k = 0; k < columns->n; k++)
      fixed[k] = sphi_frame_fix(frame, d, from[columns->order[k]]);
  }
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
    const double base = frame->periodic[d] ? frame->lo[d] : frame->origin[d];
    const double from = floor((lo[d] - radius - base) / columns->width[d]);
    const double to = floor((hi[d] + radius - base) / columns->width[d]);
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

sph_status sphi_clusters_build(sph_context *context, sphi_clusters *clusters,
                               const sphi_columns *columns, const sphi_frame *frame,
                               double *const *x, int lanes, double extent) {
  const int dim = columns->dim;
  clusters->lanes = lanes;
  clusters->n = 0;
  /* Where particles are dense a cluster is full; the bound counts the ends of columns as well. */
  for (int32_t c = 0; c < columns->columns; c++) {
    const int32_t end = columns->start[c + 1];
    for (int32_t first = columns->start[c]; first < end;) {
      int32_t count = 1;
      while (count < lanes && first + count < end &&
             columns->z[first + count] - columns->z[first] <= extent)
        count++;
      const int32_t k = clusters->n;
      if ((int64_t)k + 1 > clusters->capacity || ((int64_t)k + 1) * dim > clusters->box_capacity)
        SPH_CHECK(context, reserve_clusters(context, clusters, (int64_t)k + 1, dim), SPH_E_MEMORY,
                  "no memory for %d clusters of particles", k + 1);
      clusters->first[k] = first;
      clusters->count[k] = count;
      clusters->n++;
      first += count;
    }
  }
#pragma omp parallel for num_threads(context->threads) schedule(static) if (clusters->n > 64)
  for (int32_t k = 0; k < clusters->n; k++) {
    for (int d = 0; d < dim; d++) {
      double lo = HUGE_VAL, hi = -HUGE_VAL;
      const int32_t *point = columns->order + clusters->first[k];
      for (int32_t l = 0; l < clusters->count[k]; l++) {
        const double at = sphi_frame_wrap(frame, d, x[d][point[l]]);
        if (at < lo) lo = at;
        if (at > hi) hi = at;
      }
      clusters->lo[dim * k + d] = lo;
      clusters->hi[dim * k + d] = hi;
    }
  }
  return SPH_OK;
}
