#include "interpolator/gather_impl.h"

double sphi_column_width(int dim, int lanes, double spacing) {
  return spacing * (dim == 2 ? sqrt(lanes) : cbrt(lanes));
}

void sphi_gather_free(sph_context *context, sphi_gather *gather) {
  for (int d = 0; d < SPHI_MAX_DIM; d++) sphi_free(context, gather->x[d]);
  sphi_columns_free(context, &gather->columns);
  sphi_clusters_free(context, &gather->clusters);
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
  SPH_TRY(sphi_columns_build(context, &gather->columns, frame,
                             sphi_column_width(frame->dim, variant->lanes, spacing), gather->n,
                             gather->x, NULL, "interpolation points"));
  return sphi_clusters_build(context, &gather->clusters, &gather->columns, frame, gather->x,
                             variant->lanes, radius);
}

sph_status sphi_gather_list(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                            const sphi_columns *sources, double radius) {
  return sphi_list_build(context, &gather->list, frame, &gather->clusters, sources, radius);
}

void sphi_gather_evaluate(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                          const sph_interpolator *interpolator, const sphi_variant *variant,
                          const void *record) {
  sphi_pack pack = {.frame = frame,
                    .n = gather->n,
                    .stride = frame->dim,
                    .order = gather->columns.order,
                    .record = gather->record};
  for (int d = 0; d < frame->dim; d++) pack.x[d] = gather->x[d];
  sphi_pack_run(context, variant, &pack);
  sphi_sweep sweep = {.frame = frame,
                      .kernel = interpolator->kernel,
                      .targets = &gather->clusters,
                      .target = gather->record,
                      .target_stride = frame->dim};
  sweep.source[0].list = &gather->list;
  sweep.source[0].record = record;
  gather->work.n = gather->n;
  sphi_interpolate(interpolator, variant, &sweep, &gather->work);
}
