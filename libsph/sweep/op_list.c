/* Candidate lists: for each cluster the sources within the radius of its bounding box. Also the
 * packing of records and the table of this variant's loops. */
#include "sweep/pair.h"

#if !SPHI_DOUBLE

/* The columns that clusters in one cell of the sources' columns can have sources in. */
typedef struct near_columns {
  enum { NEAR_ROOM = 512 } room;
  double from[SPHI_MAX_DIM], to[SPHI_MAX_DIM]; /* that cell; more than one if columns differ */
  int32_t count;
  int32_t column[NEAR_ROOM];
  double middle[SPHI_MAX_DIM - 1][NEAR_ROOM]; /* of the columns, across */
  int32_t at[NEAR_ROOM]; /* where the last cluster's range began: the next one's is close */
} near_columns;

SPHI_INLINE void near_update(const int dim, near_columns *near, const sphi_columns *sources,
                             const sphi_frame *frame, const double *lo, const double *hi,
                             double radius) {
  double left[SPHI_MAX_DIM] = {0}, right[SPHI_MAX_DIM] = {0};
  bool same = near->count >= 0;
  for (int d = 0; d < dim - 1; d++) {
    const double base = frame->origin[d];
    const double from = floor((lo[d] - base) * sources->per_width[d]);
    const double to = floor((hi[d] - base) * sources->per_width[d]);
    same = same && from == near->from[d] && to == near->to[d];
    near->from[d] = from;
    near->to[d] = to;
    left[d] = base + from * sources->width[d];
    right[d] = base + (to + 1) * sources->width[d];
  }
  if (same) return;
  sphi_window window;
  sphi_columns_window(sources, frame, left, right, radius * (1 + 1e-6), &window);
  near->count = sphi_columns_in(sources, &window, NEAR_ROOM, near->column);
  for (int32_t k = 0; k < near->count && k < NEAR_ROOM; k++) {
    const int32_t *key = sources->key + 2 * near->column[k];
    for (int d = 0; d < dim - 1; d++)
      near->middle[d][k] = frame->origin[d] + (key[d] + 0.5) * sources->width[d];
    const int32_t start = sources->start[near->column[k]];
    const int32_t first = sphi_columns_lower(sources, near->column[k], lo[dim - 1] - radius);
    near->at[k] = start + (first - start) / SPHI_LANES * SPHI_LANES;
  }
}

/* Writes j + l for every bit l that is set, in order, and what comes after up to a whole vector; returns
 * how many are set. */
SPHI_INLINE int store_numbers(uint32_t *out, int32_t j, unsigned bits) {
#if SPHI_FLOAT16
  const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  const __m512i number = _mm512_add_epi32(lane, _mm512_set1_epi32(j));
  /* Compressed in a register: compressing to memory is slow on some processors. */
  _mm512_storeu_si512(out, _mm512_maskz_compress_epi32((__mmask16)bits, number));
  return __builtin_popcount(bits);
#else
  typedef uint32_t four __attribute__((vector_size(16)));
  static const four lane[16] = {{0},    {0},       {1},       {0, 1},      {2},    {0, 2},
                                {1, 2}, {0, 1, 2}, {3},       {0, 3},      {1, 3}, {0, 1, 3},
                                {2, 3}, {0, 2, 3}, {1, 2, 3}, {0, 1, 2, 3}};
  static const uint8_t count[16] = {0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
  int stored = 0;
  for (int l = 0; l < SPHI_LANES; l += 4) {
    const unsigned set = bits >> l & 15;
    const four number = lane[set] + (uint32_t)(j + l);
    memcpy(out + stored, &number, sizeof number);
    stored += count[set];
  }
  return stored;
#endif
}

typedef struct box {
  vfixed center[SPHI_MAX_DIM];
  vreal half[SPHI_MAX_DIM], unit[SPHI_MAX_DIM];
  vreal radius2;
  double tell; /* less than how far apart places look the same in fixed point */
} box;

/* Appends the sources near the box from `begin` on, before `end` and the first block of lanes whose
 * coordinate along the column is above `to`; past the capacity it only counts. Fixed point cannot tell
 * sources from others far along the column, and blocks reach there where it is sparse: `from` and `to`
 * then bound every source. */
SPHI_INLINE void append_range(const int dim, const box *b, const sphi_columns *sources,
                              sphi_list_part *part, int32_t begin, int32_t end, double from,
                              double to) {
  const double *z = sources->z;
  uint32_t past_capacity[SPHI_LANES];
  int64_t used = part->used;
  for (int32_t j = begin; j < end && z[j] <= to; j += SPHI_LANES) {
    vreal d2 = v_set(0);
    for (int d = 0; d < dim; d++) {
      vfixed x;
      memcpy(&x, sources->fixed[d] + j, sizeof x);
      vreal away = __builtin_convertvector((vint)(x - b->center[d]), vreal);
      away = (vreal)((vint)away & INT32_MAX); /* without its sign */
      away = v_positive(away * b->unit[d] - b->half[d]);
      d2 += away * away;
    }
    unsigned near = v_bits_less(d2, b->radius2);
    const int32_t count = end - j < SPHI_LANES ? end - j : SPHI_LANES;
    if (count < SPHI_LANES) near &= (1u << count) - 1;
    if (z[j] < from - b->tell || z[j + count - 1] > to + b->tell)
      for (int32_t l = 0; l < count; l++)
        if (z[j + l] < from || z[j + l] > to) near &= ~(1u << l);
    uint32_t *out = used + SPHI_LANES <= part->capacity ? part->source + used : past_capacity;
    used += store_numbers(out, j, near);
  }
  part->used = used;
}

/* Squared distances across the columns between a cluster's box and the columns near it. */
SPHI_INLINE void column_gaps(const int dim, const near_columns *near, const sphi_columns *sources,
                             const sphi_frame *frame, const double *lo, const double *hi,
                             double *gap2) {
  const int32_t count = near->count < NEAR_ROOM ? near->count : NEAR_ROOM;
  for (int d = 0; d < dim - 1; d++) {
    const double center = 0.5 * (lo[d] + hi[d]), half = 0.5 * (hi[d] - lo[d] + sources->width[d]);
    const double length = frame->length[d], per_length = frame->periodic[d] ? 1 / length : 0;
    for (int32_t k = 0; k < count; k++) {
      double apart = near->middle[d][k] - center;
      apart -= length * rint(apart * per_length);
      double gap = fabs(apart) - half;
      gap = gap > 0 ? gap : 0;
      gap2[k] = d == 0 ? gap * gap : gap2[k] + gap * gap;
    }
  }
}

SPHI_INLINE void append_cluster(const int dim, sphi_list_part *part, const sphi_frame *frame,
                                const sphi_columns *sources, const double *lo, const double *hi,
                                double radius, near_columns *near) {
  near_update(dim, near, sources, frame, lo, hi, radius);
  if (near->count == 0) return;
  box b;
  for (int d = 0; d < dim; d++) {
    const double half = 0.5 * (hi[d] - lo[d]);
    b.unit[d] = v_set((real)frame->unit[d]);
    b.half[d] = v_set((real)(half * (1 + 1e-6) + 2 * frame->unit[d])); /* with room for rounding */
    b.center[d] = sphi_frame_fix(frame, d, lo[d] + half) - (vfixed){0};
  }
  b.radius2 = v_set((real)(radius * radius * (1 + 1e-6)));
  b.tell = 32 * radius;
  const double *z = sources->z;
  double gap2[NEAR_ROOM];
  column_gaps(dim, near, sources, frame, lo, hi, gap2);
  for (int32_t k = 0; k < near->count && k < NEAR_ROOM; k++) {
    if (gap2[k] > radius * radius) continue;
    const int32_t c = near->column[k];
    if (frame->periodic[dim - 1]) {
      int32_t ranges[3][2];
      const int pieces =
          sphi_columns_range(sources, frame, c, lo[dim - 1] - radius, hi[dim - 1] + radius, ranges);
      for (int piece = 0; piece < pieces; piece++)
        append_range(dim, &b, sources, part, ranges[piece][0], ranges[piece][1], -HUGE_VAL,
                     HUGE_VAL);
      continue;
    }
    const double reach = sqrt(radius * radius - gap2[k]) * (1 + 1e-9);
    const double from = lo[dim - 1] - reach, to = hi[dim - 1] + reach;
    /* Whole blocks of lanes, counted from the start of the column so that where the range begins does not
     * depend on the clusters before. */
    const int32_t start = sources->start[c], stop = sources->start[c + 1];
    int32_t begin = near->at[k];
    while (begin + SPHI_LANES < stop && z[begin + SPHI_LANES - 1] < from) begin += SPHI_LANES;
    while (begin > start && z[begin - 1] >= from) begin -= SPHI_LANES;
    near->at[k] = begin;
    append_range(dim, &b, sources, part, begin, stop, from, to);
  }
}

static void list_rows(sphi_list *list, int32_t part, const sphi_frame *frame,
                      const sphi_clusters *targets, const sphi_columns *sources, double radius,
                      int32_t begin, int32_t end) {
  near_columns near;
  near.count = -1;
  sphi_list_part *p = &list->part[part];
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
#define UPDATE_DECLARE(name) \
  int32_t SPHI_NAME(sphi_##name##_update)(const void *arguments, int32_t begin, int32_t end);
SPHI_UPDATE_LIST(UPDATE_DECLARE)
#undef UPDATE_DECLARE

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
    .updates =
        {
#define UPDATE_ROW(name) [SPHI_UPDATE_##name] = SPHI_NAME(sphi_##name##_update),
            SPHI_UPDATE_LIST(UPDATE_ROW)
#undef UPDATE_ROW
        },
    .pack = pack_run,
#if !SPHI_DOUBLE
    .list = list_rows,
#endif
};
