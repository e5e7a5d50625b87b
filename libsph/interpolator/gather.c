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

sph_status sphi_gather_reserve(sph_context *context, sphi_gather *gather,
                               const sph_interpolator *interpolator, int dim, int32_t n,
                               size_t real_size) {
  bool ok = true;
  int64_t capacity = gather->capacity;
  for (int d = 0; d < dim; d++) {
    capacity = gather->capacity;
    ok = ok && sphi_reserve(context, (void **)&gather->x[d], &capacity, n, sizeof(double));
  }
  if (ok) gather->capacity = capacity;
  ok = ok && sphi_reserve(context, &gather->record, &gather->record_capacity,
                          ((int64_t)n + SPHI_PAD) * dim, real_size);
  SPH_CHECK(context, ok, SPH_E_MEMORY, "no memory for %d interpolation points", n);
  gather->n = n;
  return sphi_interpolation_reserve(interpolator, dim, n, &gather->work);
}

sph_status sphi_gather_sort(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                            const sphi_variant *variant, double spacing, double radius) {
  gather->packed = false;
  SPH_TRY(sphi_columns_build(context, &gather->columns, frame,
                             sphi_column_width(frame->dim, variant->lanes, spacing), gather->n,
                             gather->x, NULL, "interpolation points"));
  return sphi_clusters_build(context, &gather->clusters, &gather->columns, frame, gather->x,
                             variant->lanes, radius);
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

sph_status sphi_gather_list(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                            const sph_interpolator *interpolator, const sphi_columns *sources,
                            double radius) {
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
  gather->work.n = gather->n;
  for (int32_t c = 0; c < all->n; c++) {
    if (gather->list.entry[c].count == 0) {
      set_dry(gather, frame->dim, all->first[c], all->count[c]);
      continue;
    }
    wet->first[wet->n] = all->first[c];
    wet->count[wet->n] = all->count[c];
    gather->list.entry[wet->n++] = gather->list.entry[c];
  }
  gather->list.clusters = wet->n;
  return sphi_interpolation_reserve_list(interpolator, all->lanes, &gather->list, &gather->work);
}

void sphi_gather_evaluate(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                          const sph_interpolator *interpolator, const sphi_variant *variant,
                          const void *record) {
  if (!gather->packed) {
    sphi_pack pack = {.frame = frame,
                      .n = gather->n,
                      .stride = frame->dim,
                      .order = gather->columns.order,
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
