#include "interpolator/gather_impl.h"

double sphi_column_width(int dim, int lanes, double spacing) {
  return spacing * (dim == 2 ? sqrt(lanes) : cbrt(lanes));
}

void sphi_gather_free(sph_context *context, sphi_gather *gather) {
  for (int d = 0; d < SPHI_MAX_DIM; d++) sphi_free(context, gather->x[d]);
  sphi_columns_free(context, &gather->columns);
  sphi_clusters_free(context, &gather->clusters);
  sphi_clusters_free(context, &gather->wet);
  sphi_list_free(context, &gather->list);
  sphi_free(context, gather->record);
  sphi_interpolation_free(context, &gather->work);
  memset(gather, 0, sizeof *gather);
}

sph_status sphi_gather_reserve_points(sph_context *context, sphi_gather *gather, int dim,
                                      int32_t n) {
  bool ok = true;
  int64_t capacity = gather->capacity;
  for (int d = 0; d < dim; d++) {
    capacity = gather->capacity;
    ok = ok && sphi_reserve(context, (void **)&gather->x[d], &capacity, n, sizeof(double));
  }
  SPH_CHECK(context, ok, SPH_E_MEMORY, "no memory for %d interpolation points", n);
  gather->capacity = capacity;
  gather->n = n;
  return SPH_OK;
}

static sph_status reserve_results(sph_context *context, sphi_gather *gather,
                                  const sph_interpolator *interpolator, int dim, int32_t n,
                                  size_t real_size) {
  SPH_CHECK(context,
            sphi_reserve(context, &gather->record, &gather->record_capacity,
                         ((int64_t)n + SPHI_PAD) * dim, real_size),
            SPH_E_MEMORY, "no memory for %d interpolation points", n);
  return sphi_interpolation_reserve(interpolator, dim, n, &gather->work);
}

sph_status sphi_gather_reserve(sph_context *context, sphi_gather *gather,
                               const sph_interpolator *interpolator, int dim, int32_t n,
                               size_t real_size) {
  SPH_TRY(sphi_gather_reserve_points(context, gather, dim, n));
  return reserve_results(context, gather, interpolator, dim, n, real_size);
}

sph_status sphi_gather_sort(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                            const sphi_variant *variant, double spacing, double radius) {
  gather->packed = false;
  SPH_TRY(sphi_columns_build(context, &gather->columns, frame,
                             sphi_column_width(frame->dim, variant->lanes, spacing), gather->n,
                             gather->x, NULL, "interpolation points"));
  gather->order = gather->columns.order;
  return sphi_clusters_build(context, &gather->clusters, &gather->columns, frame, gather->x,
                             variant->lanes, radius);
}

/* How many points from `first` on go into one cluster, and its box. */
static int32_t cut_one(const sphi_gather *gather, const sphi_frame *frame, int32_t first, int lanes,
                       double extent, double *lo, double *hi) {
  const int dim = frame->dim;
  for (int d = 0; d < dim; d++) {
    lo[d] = HUGE_VAL;
    hi[d] = -HUGE_VAL;
  }
  int32_t count = 0;
  for (; count < lanes && first + count < gather->n; count++) {
    double left[SPHI_MAX_DIM], right[SPHI_MAX_DIM];
    bool fits = true;
    for (int d = 0; d < dim; d++) {
      const double at = sphi_frame_wrap(frame, d, gather->x[d][first + count]);
      left[d] = at < lo[d] ? at : lo[d];
      right[d] = at > hi[d] ? at : hi[d];
      fits = fits && right[d] - left[d] <= extent;
    }
    if (!fits) break;
    memcpy(lo, left, (size_t)dim * sizeof *lo);
    memcpy(hi, right, (size_t)dim * sizeof *hi);
  }
  return count;
}

static bool reserve_cut(sph_context *context, sphi_clusters *clusters, int32_t n, int dim) {
  if (n <= clusters->capacity && (int64_t)n * dim <= clusters->box_capacity) return true;
  struct {
    void **array;
    int64_t count;
    size_t size;
  } const arrays[] = {{(void **)&clusters->first, n, sizeof *clusters->first},
                      {(void **)&clusters->count, n, sizeof *clusters->count},
                      {(void **)&clusters->lo, (int64_t)n * dim, sizeof *clusters->lo},
                      {(void **)&clusters->hi, (int64_t)n * dim, sizeof *clusters->hi}};
  int64_t capacity[4] = {clusters->capacity, clusters->capacity, clusters->box_capacity,
                         clusters->box_capacity};
  bool ok = true;
  for (int k = 0; k < 4; k++)
    ok =
        ok && sphi_reserve(context, arrays[k].array, &capacity[k], arrays[k].count, arrays[k].size);
  if (!ok) return false; /* arrays that grew all the same hold at least what the capacities say */
  clusters->capacity = capacity[0];
  clusters->box_capacity = capacity[2];
  return true;
}

sph_status sphi_gather_cut(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                           const sphi_variant *variant, double extent) {
  sphi_clusters *clusters = &gather->clusters;
  const int dim = frame->dim;
  gather->packed = false;
  gather->order = NULL;
  clusters->lanes = variant->lanes;
  clusters->n = 0;
  for (int32_t first = 0; first < gather->n;) {
    SPH_CHECK(context, reserve_cut(context, clusters, clusters->n + 1, dim), SPH_E_MEMORY,
              "no memory for clusters of %d interpolation points", gather->n);
    const int32_t c = clusters->n++;
    clusters->first[c] = first;
    clusters->count[c] = cut_one(gather, frame, first, variant->lanes, extent,
                                 clusters->lo + (int64_t)dim * c, clusters->hi + (int64_t)dim * c);
    first += clusters->count[c];
  }
  return SPH_OK;
}

static void set_dry(sphi_gather *gather, int dim, int32_t first, int32_t count) {
  sphi_interpolation *work = &gather->work;
  for (int32_t k = first; k < first + count; k++) {
    work->rung[k] = 0;
    work->gamma[k] = 0;
    work->neighbours[k] = 0;
    for (int f = 0; f <= dim; f++) work->value[(int64_t)f * work->n + k] = 0;
    for (int d = 0; d < dim; d++) work->moment[(int64_t)d * work->n + k] = 0;
    for (int g = 0; g < (dim + 1) * dim && work->gradient; g++)
      work->gradient[(int64_t)g * work->n + k] = 0;
  }
}

/* Lists all clusters, and makes room for those that are wet. */
static sph_status list_all(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                           const sphi_columns *sources, double radius) {
  const sphi_clusters *all = &gather->clusters;
  sphi_clusters *wet = &gather->wet;
  SPH_TRY(sphi_list_build(context, &gather->list, frame, all, sources, radius));
  int64_t capacity = wet->capacity;
  SPH_CHECK(
      context,
      sphi_reserve(context, (void **)&wet->first, &capacity, all->n, sizeof *wet->first) &&
          sphi_reserve(context, (void **)&wet->count, &wet->capacity, all->n, sizeof *wet->count),
      SPH_E_MEMORY, "no memory for %d clusters of interpolation points", all->n);
  wet->lanes = all->lanes;
  wet->n = 0;
  return SPH_OK;
}

/* Cluster c is the next wet one, its points from `first` on. */
static void add_wet(sphi_gather *gather, int32_t c, int32_t first) {
  sphi_clusters *wet = &gather->wet;
  wet->first[wet->n] = first;
  wet->count[wet->n] = gather->clusters.count[c];
  gather->list.entry[wet->n++] = gather->list.entry[c];
}

sph_status sphi_gather_list(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                            const sph_interpolator *interpolator, const sphi_columns *sources,
                            double radius) {
  const sphi_clusters *all = &gather->clusters;
  SPH_TRY(list_all(context, gather, frame, sources, radius));
  gather->work.n = gather->n;
  for (int32_t c = 0; c < all->n; c++) {
    if (gather->list.entry[c].count == 0)
      set_dry(gather, frame->dim, all->first[c], all->count[c]);
    else
      add_wet(gather, c, all->first[c]);
  }
  gather->list.clusters = gather->wet.n;
  return sphi_interpolation_reserve_list(interpolator, all->lanes, &gather->list, &gather->work);
}

sph_status sphi_gather_list_wet(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                                const sph_interpolator *interpolator, const sphi_columns *sources,
                                double radius, const sphi_variant *variant, int32_t *point) {
  const sphi_clusters *all = &gather->clusters;
  SPH_TRY(list_all(context, gather, frame, sources, radius));
  int32_t n = 0;
  for (int32_t c = 0; c < all->n; c++) {
    if (gather->list.entry[c].count == 0) continue;
    const int32_t first = all->first[c], count = all->count[c];
    add_wet(gather, c, n);
    for (int d = 0; d < frame->dim; d++)
      memmove(gather->x[d] + n, gather->x[d] + first, (size_t)count * sizeof *gather->x[d]);
    memmove(point + n, point + first, (size_t)count * sizeof *point);
    n += count;
  }
  gather->n = n;
  gather->list.clusters = gather->wet.n;
  /* With head room, since how many are wet varies a little. */
  const int32_t room = n <= gather->work.capacity ? n : n + n / 8 + 16;
  SPH_TRY(reserve_results(context, gather, interpolator, frame->dim, room, variant->real_size));
  gather->work.n = n;
  return sphi_interpolation_reserve_list(interpolator, all->lanes, &gather->list, &gather->work);
}

void sphi_gather_evaluate(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                          const sph_interpolator *interpolator, const sphi_variant *variant,
                          const void *record) {
  if (!gather->packed) {
    sphi_pack pack = {.frame = frame,
                      .n = gather->n,
                      .stride = frame->dim,
                      .order = gather->order,
                      .record = gather->record};
    for (int d = 0; d < frame->dim; d++) pack.x[d] = gather->x[d];
    sphi_pack_run(context, variant, &pack);
    gather->packed = true;
  }
  sphi_sweep sweep = {.frame = frame,
                      .kernel = interpolator->kernel,
                      .targets = &gather->wet,
                      .target = gather->record,
                      .target_stride = frame->dim};
  sweep.source[0].list = &gather->list;
  sweep.source[0].record = record;
  sphi_interpolate(interpolator, variant, &sweep, &gather->work);
}
