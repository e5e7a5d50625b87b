/* Points sorted into columns, cut into clusters, and for each cluster the list of sources near it.
 *
 * Space is cut into columns along the last axis; a column's points are sorted along that axis. Only
 * columns that hold points exist. A table of the box around them finds them, or where that box is
 * mostly empty a hash table, so that the extent of the domain costs nothing. W consecutive points of a
 * column are a cluster: the targets that one pass of the pair loop updates together.
 */
#ifndef SPHI_COLUMNS_H
#define SPHI_COLUMNS_H

#include "core/internal.h"

/* How positions become numbers whose differences are exact: x = origin + unit * k, k modulo 2^32.
 * Candidates are always near each other, so the wrapped difference is the true one; in a periodic
 * direction unit * 2^32 is the period, and the wrapped difference is the nearest image. */
typedef struct sphi_frame {
  int dim;
  bool periodic[SPHI_MAX_DIM];
  double lo[SPHI_MAX_DIM];     /* periodic directions: the box starts here ... */
  double length[SPHI_MAX_DIM]; /* ... and is this long; 0 elsewhere */
  double origin[SPHI_MAX_DIM];
  double unit[SPHI_MAX_DIM], per_unit[SPHI_MAX_DIM];
  double step;  /* the unit of directions that are not periodic */
  bool uniform; /* none is: every direction has that unit */
} sphi_frame;

/* A frame for pairs closer than `radius`; origin is any point near the particles. */
void sphi_frame_set(sphi_frame *frame, int dim, const double *origin, double radius,
                    const bool *periodic, const double *lo, const double *hi);

static inline uint32_t sphi_frame_fix(const sphi_frame *frame, int d, double x) {
  return (uint32_t)(int64_t)((x - frame->origin[d]) * frame->per_unit[d]);
}

/* x moved into the periodic box. */
static inline double sphi_frame_wrap(const sphi_frame *frame, int d, double x) {
  if (!frame->periodic[d]) return x;
  const double y = x - frame->length[d] * floor((x - frame->lo[d]) / frame->length[d]);
  /* Rounding may leave either side; NaN stays. */
  return y < frame->lo[d] || y >= frame->lo[d] + frame->length[d] ? frame->lo[d] : y;
}

/* Difference of two coordinates, by the nearest image in a periodic direction. */
static inline double sphi_frame_difference(const sphi_frame *frame, int d, double a, double b) {
  const double dx = a - b;
  return frame->periodic[d] ? dx - frame->length[d] * rint(dx / frame->length[d]) : dx;
}

typedef struct sphi_columns {
  int dim;
  int32_t n;
  int32_t columns;
  double width[SPHI_MAX_DIM]; /* across the columns; along them only a scale */
  double per_width[SPHI_MAX_DIM];
  int32_t
      around[SPHI_MAX_DIM]; /* columns around a periodic direction, 0 where it is not periodic */
  int32_t *order;           /* [n] place in sorted order -> point */
  double *z;                /* [n] last coordinate, in the box where periodic, sorted order */
  uint32_t *fixed[SPHI_MAX_DIM]; /* [n + lanes] fixed-point positions, sorted order */
  int32_t *start;                /* [columns + 1] */
  int32_t *key;                  /* [columns][2] */
  int32_t low[2], size[2]; /* the box of columns that `table` covers; size 0: it is a hash table */
  int32_t *table;          /* column numbers, -1 where there is none */
  int64_t table_size;
  int32_t *bin; /* [n] scratch of sorting: place in the box or number of the column, then points */
  double *merged; /* [n] scratch of sorting */
  int32_t *fill;  /* scratch of sorting: counts and places of each thread's points */
  int64_t point_capacity, column_capacity, start_capacity, table_capacity, fill_capacity;
} sphi_columns;

void sphi_columns_free(sph_context *context, sphi_columns *columns);
/* Sorts n points, x[d][i]; rank NULL: the point's number. SPH_E_DIVERGED names a point whose column
 * number does not fit (not finite, or 10^9 columns away). */
sph_status sphi_columns_build(sph_context *context, sphi_columns *columns, const sphi_frame *frame,
                              double width, int32_t n, double *const *x, const int32_t *rank,
                              const char *owner);
/* The fixed-point positions again after the points moved without a new sort. */
void sphi_columns_fix(sph_context *context, sphi_columns *columns, const sphi_frame *frame,
                      double *const *x);
/* Number of the column at (k0, k1), or -1. */
int32_t sphi_columns_find(const sphi_columns *columns, int32_t k0, int32_t k1);
/* First place in column c whose z is not below `z`. */
int32_t sphi_columns_lower(const sphi_columns *columns, int32_t c, double z);
/* Column numbers (from..to across the columns, both included) within `radius` of the box lo..hi. */
typedef struct sphi_window {
  int32_t from[2], to[2];
} sphi_window;
void sphi_columns_window(const sphi_columns *columns, const sphi_frame *frame, const double *lo,
                         const double *hi, double radius, sphi_window *window);
/* The columns that exist in a window: at most `room` numbers are written; the count is returned (it
 * may exceed room). */
int32_t sphi_columns_in(const sphi_columns *columns, const sphi_window *window, int32_t room,
                        int32_t *found);
/* The pieces of column c with z in lo..hi, periodic images included: at most 3 (begin, end). */
int sphi_columns_range(const sphi_columns *columns, const sphi_frame *frame, int32_t c, double lo,
                       double hi, int32_t ranges[3][2]);

typedef struct sphi_clusters {
  int lanes;
  int32_t n;
  int32_t *first;  /* place of the first point in sorted order */
  int32_t *count;  /* 1..lanes */
  double *lo, *hi; /* [n][dim] bounding box, unwrapped */
  int64_t capacity, box_capacity;
} sphi_clusters;

void sphi_clusters_free(sph_context *context, sphi_clusters *clusters);
/* Cuts sorted points into clusters no longer than `extent` along the columns. */
sph_status sphi_clusters_build(sph_context *context, sphi_clusters *clusters,
                               const sphi_columns *columns, const sphi_frame *frame,
                               double *const *x, int lanes, double extent);

typedef struct sphi_list_entry {
  int64_t offset;
  int32_t part;
  int32_t count;
  int32_t near; /* the first of them are those to visit, see sphi_sweep.prune; all after a build */
} sphi_list_entry;

typedef struct sphi_list_part {
  uint32_t *source; /* places in the sources' sorted order */
  int64_t used, capacity;
} sphi_list_part;

typedef struct sphi_list {
  int32_t clusters;
  sphi_list_entry *entry;
  int64_t capacity;
  sphi_list_part *part;
  int32_t parts;
  int64_t total;
} sphi_list;

void sphi_list_free(sph_context *context, sphi_list *list);
/* For every cluster the sources within `radius` of its bounding box. */
sph_status sphi_list_build(sph_context *context, sphi_list *list, const sphi_frame *frame,
                           const sphi_clusters *targets, const sphi_columns *sources,
                           double radius);

#endif
