/* Every particle against every other: slow, and plain enough to be right. */
#include "search/search_impl.h"

static sph_status build(sph_search *search) {
  (void)search;
  return SPH_OK;
}

static sph_status collect(sph_search *search, const double *x, double r) {
  SPH_TRY(sphi_search_reserve(search, search->n));
  for (sph_index j = 0; j < search->n; j++) {
    const double distance = sphi_search_distance(search, x, j);
    if (distance < r) search->near[search->near_count++] = (sphi_near){distance, j};
  }
  return SPH_OK;
}

static sph_status collect_nearest(sph_search *search, const double *x, int64_t wanted) {
  (void)wanted;
  return collect(search, x, HUGE_VAL);
}

static int64_t count_after(const sph_search *search, sph_index i) {
  double x[SPHI_MAX_DIM];
  for (int d = 0; d < search->dim; d++) x[d] = search->x[d][i];
  int64_t count = 0;
  for (sph_index j = i + 1; j < search->n; j++)
    count += sphi_search_distance(search, x, j) < search->radius;
  return count;
}

const sphi_search_rows sphi_brute_force = {build, collect, collect_nearest, count_after};
