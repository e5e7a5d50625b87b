/* Search over the sorted columns that the pair sweep uses too: of the columns near a point, the pieces
 * near it. Columns are one radius wide. */
#include <float.h>

#include "search/search_impl.h"

/* A window as wide as a column reaches 3 columns across, or 4 with the margin for rounding. */
enum { NEAR_COLUMNS = 16 };

static sph_status build(sph_search *search) {
  SPH_TRY(sphi_columns_build(search->context, &search->columns, &search->frame, search->radius,
                             search->n, search->x, NULL, search->particles->name));
  const int64_t wanted = search->columns.columns;
  SPH_CHECK(search->context,
            sphi_reserve(search->context, (void **)&search->column, &search->column_capacity,
                         wanted + 1, sizeof *search->column),
            SPH_E_MEMORY, "search of particles \"%s\": no memory for %lld columns",
            search->particles->name, (long long)wanted);
  return SPH_OK;
}

/* r and what rounding of the coordinates may add to it. */
static double reach(const sph_search *search, const double *x, double r) {
  double largest = 0;
  for (int d = 0; d < search->dim; d++) {
    largest = fmax(largest, fmax(fabs(x[d]), fabs(search->frame.origin[d])));
    largest = fmax(largest, search->frame.length[d]);
  }
  return r * (1 + 1e-9) + 16 * DBL_EPSILON * largest;
}

static sph_status collect(sph_search *search, const double *x, double r) {
  const sphi_columns *columns = &search->columns;
  const int last = search->dim - 1;
  const double wide = reach(search, x, r);
  sphi_window window;
  sphi_columns_window(columns, &search->frame, x, x, wide, &window);
  const int32_t count = sphi_columns_in(columns, &window, columns->columns, search->column);
  for (int32_t c = 0; c < count; c++) {
    int32_t ranges[3][2];
    const int pieces = sphi_columns_range(columns, &search->frame, search->column[c],
                                          x[last] - wide, x[last] + wide, ranges);
    for (int piece = 0; piece < pieces; piece++) {
      SPH_TRY(sphi_search_reserve(search, ranges[piece][1] - ranges[piece][0]));
      for (int32_t k = ranges[piece][0]; k < ranges[piece][1]; k++) {
        const sph_index j = columns->order[k];
        const double distance = sphi_search_distance(search, x, j);
        if (distance < r) search->near[search->near_count++] = (sphi_near){distance, j};
      }
    }
  }
  return SPH_OK;
}

/* Looks in growing balls; when one is as wide as all the columns there are, looks everywhere. */
static sph_status collect_nearest(sph_search *search, const double *x, int64_t wanted) {
  double columns_across = 2;
  for (double r = search->radius; columns_across < search->columns.columns;
       r *= 2, columns_across *= 2) {
    search->near_count = 0;
    SPH_TRY(collect(search, x, r));
    if (search->near_count >= wanted) return SPH_OK;
  }
  search->near_count = 0;
  return sphi_brute_force.collect_nearest(search, x, wanted);
}

static int64_t count_after(const sph_search *search, sph_index i) {
  const sphi_columns *columns = &search->columns;
  const int last = search->dim - 1;
  double x[SPHI_MAX_DIM];
  for (int d = 0; d < search->dim; d++) x[d] = search->x[d][i];
  const double wide = reach(search, x, search->radius);
  sphi_window window;
  int32_t column[NEAR_COLUMNS];
  sphi_columns_window(columns, &search->frame, x, x, wide, &window);
  const int32_t found = sphi_columns_in(columns, &window, NEAR_COLUMNS, column);
  /* Coordinates so large that a radius is lost in their rounding. */
  if (found > NEAR_COLUMNS) return sphi_brute_force.count_after(search, i);
  int64_t count = 0;
  for (int32_t c = 0; c < found; c++) {
    int32_t ranges[3][2];
    const int pieces = sphi_columns_range(columns, &search->frame, column[c], x[last] - wide,
                                          x[last] + wide, ranges);
    for (int piece = 0; piece < pieces; piece++)
      for (int32_t k = ranges[piece][0]; k < ranges[piece][1]; k++) {
        const sph_index j = columns->order[k];
        count += j > i && sphi_search_distance(search, x, j) < search->radius;
      }
  }
  return count;
}

const sphi_search_rows sphi_cell_grid = {build, collect, collect_nearest, count_after};
