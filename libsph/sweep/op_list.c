/* Candidate lists: for each cluster the sources within the radius of its bounding box. Also the
 * packing of records and the table of this variant's loops. */
#include "sweep/pair.h"

#if !SPHI_DOUBLE

/* The columns that the clusters at hand can have sources in, kept while the window stays the same. */
typedef struct near_columns {
  enum { NEAR_ROOM = 512 } room;
  sphi_window window;
  int32_t count;
  int32_t column[NEAR_ROOM];
  int32_t at[NEAR_ROOM]; /* where the last cluster's range began: the next one's is close */
} near_columns;

static void near_update(near_columns *near, const sphi_columns *sources, const sphi_frame *frame,
                        const double *lo, const double *hi, double radius) {
  sphi_window window;
  sphi_columns_window(sources, frame, lo, hi, radius, &window);
  if (near->count >= 0 && !memcmp(&window, &near->window, sizeof window)) return;
  near->window = window;
  near->count = sphi_columns_in(sources, &window, NEAR_ROOM, near->column);
  for (int32_t k = 0; k < near->count && k < NEAR_ROOM; k++)
    near->at[k] = sources->start[near->column[k]];
}

typedef struct box {
  vfixed center[SPHI_MAX_DIM];
  real half[SPHI_MAX_DIM], unit[SPHI_MAX_DIM];
  real radius2;
} box;

/* Appends the sources begin..end-1 that are near the box; past the capacity it only counts. */
SPHI_INLINE void append_range(const int dim, const box *b, const sphi_columns *sources,
                              sphi_list_part *part, int32_t begin, int32_t end) {
  if (part->used + (end - begin) + SPHI_LANES > part->capacity) {
    part->used += end - begin;
    return;
  }
  uint32_t *out = part->source + part->used;
  for (int32_t j = begin; j < end; j += SPHI_LANES) {
    vreal d2 = v_set(0);
    for (int d = 0; d < dim; d++) {
      vfixed x;
      memcpy(&x, sources->fixed[d] + j, sizeof x);
      vreal away = __builtin_convertvector((vint)(x - b->center[d]), vreal) * b->unit[d];
      away = v_positive(v_select(away > 0, away, -away) - b->half[d]);
      d2 += away * away;
    }
    const vint near = d2 < b->radius2;
    const int lanes = end - j < SPHI_LANES ? end - j : SPHI_LANES;
    for (int l = 0; l < lanes; l++) {
      *out = (uint32_t)(j + l);
      out -= near[l];
    }
  }
  part->used = out - part->source;
}

static void append_cluster(const int dim, sphi_list_part *part, const sphi_frame *frame,
                           const sphi_columns *sources, const double *lo, const double *hi,
                           double radius, near_columns *near) {
  box b;
  for (int d = 0; d < dim; d++) {
    const double half = 0.5 * (hi[d] - lo[d]);
    b.unit[d] = (real)frame->unit[d];
    b.half[d] = (real)(half * (1 + 1e-6) + 2 * frame->unit[d]); /* with room for rounding */
    b.center[d] = sphi_frame_fix(frame, d, lo[d] + half) - (vfixed){0};
  }
  b.radius2 = (real)(radius * radius * (1 + 1e-6));
  near_update(near, sources, frame, lo, hi, radius);
  for (int32_t k = 0; k < near->count && k < NEAR_ROOM; k++) {
    const int32_t c = near->column[k];
    if (frame->periodic[dim - 1]) {
      int32_t ranges[3][2];
      const int pieces =
          sphi_columns_range(sources, frame, c, lo[dim - 1] - radius, hi[dim - 1] + radius, ranges);
      for (int piece = 0; piece < pieces; piece++)
        append_range(dim, &b, sources, part, ranges[piece][0], ranges[piece][1]);
      continue;
    }
    double across2 = 0; /* distance between the box and the column, across */
    for (int d = 0; d < dim - 1; d++) {
      if (frame->periodic[d]) continue;
      const double left = frame->origin[d] + sources->key[2 * c + d] * sources->width[d];
      const double away = fmax(fmax(left - hi[d], lo[d] - left - sources->width[d]), 0);
      across2 += away * away;
    }
    if (across2 > radius * radius) continue;
    const double reach = sqrt(radius * radius - across2) * (1 + 1e-9);
    const double from = lo[dim - 1] - reach, to = hi[dim - 1] + reach;
    const int32_t start = sources->start[c], stop = sources->start[c + 1];
    const double *z = sources->z;
    int32_t begin = near->at[k];
    while (begin < stop && z[begin] < from) begin++;
    while (begin > start && z[begin - 1] >= from) begin--;
    near->at[k] = begin;
    int32_t end = begin;
    while (end < stop && z[end] <= to) end++;
    append_range(dim, &b, sources, part, begin, end);
  }
}

static void list_rows(sphi_list *list, int32_t part, const sphi_frame *frame,
                      const sphi_clusters *targets, const sphi_columns *sources, double radius,
                      int32_t begin, int32_t end) {
  near_columns near;
  near.count = -1;
  sphi_list_part *p = &list->part[part];
  p->used = 0;
  for (int32_t c = begin; c < end; c++) {
    const int64_t offset = p->used;
    const double *lo = targets->lo + (int64_t)frame->dim * c;
    const double *hi = targets->hi + (int64_t)frame->dim * c;
    if (frame->dim == 2)
      append_cluster(2, p, frame, sources, lo, hi, radius, &near);
    else
      append_cluster(3, p, frame, sources, lo, hi, radius, &near);
    if (near.count > NEAR_ROOM) {
      p->used = -1;
      return;
    }
    const int32_t count = (int32_t)(p->used - offset);
    list->entry[c] = (sphi_list_entry){offset, part, count, count};
  }
  v_leave();
}
#endif

SPHI_INLINE void pack_records(const int dim, const sphi_pack *pack, int32_t begin, int32_t end) {
  for (int32_t entry = begin; entry < end; entry++) {
    const int32_t k = pack->place ? pack->place[entry] : entry;
    const int32_t i = pack->order ? pack->order[k] : k;
    real *record = (real *)pack->record + (int64_t)k * pack->stride;
    for (int d = 0; d < dim; d++) {
#if SPHI_DOUBLE
      const fixed x = pack->x[d][i];
#else
      const fixed x = sphi_frame_fix(pack->frame, d, pack->x[d][i]);
#endif
      memcpy(record + d, &x, sizeof x);
    }
    for (int c = 0; c < pack->columns; c++)
      record[dim + c] = (real)(pack->value[c][i] - pack->shift[c]);
  }
}

static void pack_run(const sphi_pack *pack, int32_t begin, int32_t end) {
  if (pack->frame->dim == 2)
    pack_records(2, pack, begin, end);
  else
    pack_records(3, pack, begin, end);
  v_leave();
}

#define LOOPS_DECLARE(name) \
  extern const sphi_loop SPHI_NAME(sphi_##name##_loops)[SPHI_KERNEL_ROWS][2];
SPHI_OPERATOR_LIST(LOOPS_DECLARE)
#undef LOOPS_DECLARE

extern const sphi_variant SPHI_NAME(sphi_variant);
const sphi_variant SPHI_NAME(sphi_variant) = {
    .lanes = SPHI_LANES,
    .is_double = SPHI_DOUBLE,
    .real_size = sizeof(real),
    .loops =
        {
#define LOOPS_ROW(name) [SPHI_OPERATOR_##name] = SPHI_NAME(sphi_##name##_loops),
            SPHI_OPERATOR_LIST(LOOPS_ROW)
#undef LOOPS_ROW
        },
    .pack = pack_run,
#if !SPHI_DOUBLE
    .list = list_rows,
#endif
};
