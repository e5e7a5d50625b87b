/* Ghost pressures as sums over those of the fluid, for methods that solve for pressures. */
#include "boundary/boundary_impl.h"

/* In spacings, how far from the nearest particle a mirror point is that is in the fluid, and one that is not. */
static const double INSIDE = 0.7, OUTSIDE = 0.95;

/* The row of wet ghost k, whose mirror point has `count` sources listed. */
static void make_row(sph_boundary *boundary, const int dim, const sphi_frame *frame,
                     double *const *x, const double *volume, const sphi_body_force *force, double t,
                     double rho0, int32_t k, const uint32_t *source, int32_t count,
                     sphi_ghost_rows *rows) {
  const sph_kernel *kernel = boundary->interpolator->kernel;
  sphi_wet_ghost *ghost = &boundary->wet[k];
  int32_t *column = rows->column + rows->first[k];
  double *weight = rows->weight + rows->first[k], away[SPHI_MAX_DIM] = {0};
  double gamma = 0, nearest2 = HUGE_VAL, moment[SPHI_MAX_DIM] = {0}, push[SPHI_MAX_DIM];
  int32_t kept = 0;
  rows->count[k] = 0;
  rows->at_ghost[k] = rows->at_foot[k] = 0;
  for (int32_t s = 0; s < count; s++) {
    const int32_t j = (int32_t)source[s];
    double r2 = 0;
    for (int d = 0; d < dim; d++) {
      away[d] = sphi_frame_difference(frame, d, x[d][j], boundary->mirrors.x[d][k]);
      r2 += away[d] * away[d];
    }
    if (r2 >= kernel->support * kernel->support) continue;
    nearest2 = fmin(nearest2, r2);
    column[kept] = j;
    weight[kept] = volume[j] * sph_kernel_w(kernel, sqrt(r2));
    for (int d = 0; d < dim; d++) moment[d] += weight[kept] * away[d];
    gamma += weight[kept++];
  }
  const double nearest = sqrt(nearest2) / boundary->spacing;
  ghost->immersed = fmin(fmax((OUTSIDE - nearest) / (OUTSIDE - INSIDE), 0), 1);
  if (ghost->immersed == 0 || !(gamma > boundary->thin)) return;
  for (int32_t s = 0; s < kept; s++) weight[s] /= gamma;
  rows->at_ghost[k] = rows->at_foot[k] = sphi_wall_gradient(boundary, dim, k, force, t, rho0, push);
  for (int d = 0; d < dim; d++) {
    rows->at_ghost[k] += push[d] * (ghost->to_ghost[d] - moment[d] / gamma);
    rows->at_foot[k] += push[d] * (ghost->to_foot[d] - moment[d] / gamma);
  }
  rows->count[k] = kept;
}

void sphi_ghost_rows_free(sph_context *context, sphi_ghost_rows *rows) {
  sphi_free(context, rows->first);
  sphi_free(context, rows->count);
  sphi_free(context, rows->at_ghost);
  sphi_free(context, rows->at_foot);
  sphi_free(context, rows->column);
  sphi_free(context, rows->weight);
  memset(rows, 0, sizeof *rows);
}

static sph_status reserve_rows(sph_context *context, sphi_ghost_rows *rows, int64_t ghosts,
                               int64_t entries) {
  struct {
    void **array;
    int64_t *capacity, count;
    size_t size;
  } const arrays[] = {
      {(void **)&rows->first, &rows->capacity[0], ghosts, sizeof *rows->first},
      {(void **)&rows->count, &rows->capacity[1], ghosts, sizeof *rows->count},
      {(void **)&rows->at_ghost, &rows->capacity[2], ghosts, sizeof *rows->at_ghost},
      {(void **)&rows->at_foot, &rows->capacity[3], ghosts, sizeof *rows->at_foot},
      {(void **)&rows->column, &rows->capacity[4], entries, sizeof *rows->column},
      {(void **)&rows->weight, &rows->capacity[5], entries, sizeof *rows->weight}};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) {
    const int64_t count = arrays[k].count, head = count > *arrays[k].capacity ? count / 4 : 0;
    SPH_CHECK(context,
              sphi_reserve(context, arrays[k].array, arrays[k].capacity, count + head + 1,
                           arrays[k].size),
              SPH_E_MEMORY, "boundary: no memory for rows of %lld ghosts", (long long)ghosts);
  }
  return SPH_OK;
}

sph_status sphi_boundary_rows(sph_boundary *boundary, const sphi_frame *frame, double *const *x,
                              const double *volume, const sphi_body_force *force, double t,
                              double rho0, sphi_ghost_rows *rows) {
  sph_context *context = boundary->context;
  const sphi_gather *mirrors = &boundary->mirrors;
  const sphi_list *list = &mirrors->list;
  int64_t entries = 0;
  for (int32_t c = 0; c < mirrors->wet.n; c++)
    entries += (int64_t)list->entry[c].count * mirrors->wet.count[c];
  SPH_TRY(reserve_rows(context, rows, boundary->wet_count, entries));
  entries = 0;
  for (int32_t c = 0; c < mirrors->wet.n; c++)
    for (int32_t l = 0; l < mirrors->wet.count[c]; l++) {
      rows->first[mirrors->wet.first[c] + l] = entries;
      entries += list->entry[c].count;
    }
#pragma omp parallel for num_threads(context->threads) \
    schedule(dynamic, 16) if (boundary->wet_count > 64)
  for (int32_t c = 0; c < mirrors->wet.n; c++) {
    const sphi_list_entry *entry = &list->entry[c];
    const uint32_t *source = list->part[entry->part].source + entry->offset;
    for (int32_t l = 0; l < mirrors->wet.count[c]; l++)
      make_row(boundary, boundary->dim, frame, x, volume, force, t, rho0, mirrors->wet.first[c] + l,
               source, entry->count, rows);
  }
  return SPH_OK;
}

void sphi_boundary_set_pressures(sph_boundary *boundary, const sphi_variant *variant,
                                 const sphi_ghost_rows *rows, const double *p) {
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    sphi_wet_ghost *wet = &boundary->wet[k];
    double sum = 0;
    for (int32_t s = 0; s < rows->count[k]; s++)
      sum += rows->weight[rows->first[k] + s] * p[rows->column[rows->first[k] + s]];
    wet->p = sum + rows->at_ghost[k];
    wet->wall_pressure = sum + rows->at_foot[k];
    sphi_put_real(boundary->record, variant->is_double,
                  (int64_t)k * SPHI_GHOST(boundary->dim) + boundary->dim + 1, wet->p);
  }
}
