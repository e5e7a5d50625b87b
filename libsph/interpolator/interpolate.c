/* Evaluation at targets: the interpolator's own operator, then down the ladder where a target's
 * neighbours do not carry the method. */
#include "interpolator/interpolator_list.h"
#include "interpolator/ops.h"

/* Below this sum of kernel weights they are mostly the rounding of the kernel near its end. */
static const double gamma_min = 1e-4;

void sphi_interpolation_free(sph_context *context, sphi_interpolation *work) {
  sphi_free(context, work->value);
  sphi_free(context, work->moment);
  sphi_free(context, work->gradient);
  sphi_free(context, work->gamma);
  sphi_free(context, work->neighbours);
  sphi_free(context, work->rung);
  sphi_free(context, work->retry);
  sphi_free(context, work->nearest);
  sphi_free(context, work->collected);
  memset(work, 0, sizeof *work);
}

static bool is_sfdi(sph_interpolator_type type) {
  return type == SPH_INTERPOLATOR_SFDI || type == SPH_INTERPOLATOR_SFDI_PRINTED;
}

sph_status sphi_interpolation_reserve(const sph_interpolator *interpolator, int dim, int32_t n,
                                      sphi_interpolation *work) {
  sph_context *context = interpolator->context;
  if (n <= work->capacity && dim <= work->dim && (work->nearest || !is_sfdi(interpolator->type)) &&
      (work->gradient || !work->gradients))
    return SPH_OK;
  /* Every array holds its elements for the same number of targets, also after a failure. */
  struct {
    void **array;
    int64_t count;
    size_t size;
  } arrays[] = {
      {(void **)&work->value, dim + 1, sizeof(double)},
      {(void **)&work->moment, dim, sizeof(double)},
      {(void **)&work->gradient, work->gradients ? (dim + 1) * dim : 0, sizeof(double)},
      {(void **)&work->gamma, 1, sizeof(double)},
      {(void **)&work->neighbours, 1, sizeof(int32_t)},
      {(void **)&work->rung, 1, sizeof(uint8_t)},
      {(void **)&work->retry, 1, sizeof(int32_t)},
      {(void **)&work->nearest, is_sfdi(interpolator->type) ? 2 * dim + 1 : 0, sizeof(double)}};
  bool complete = true;
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) {
    sphi_free(context, *arrays[k].array);
    *arrays[k].array = NULL;
    if (arrays[k].count == 0) continue;
    /* Lanes past the last target read on. */
    *arrays[k].array =
        sphi_alloc(context, (size_t)(arrays[k].count * n + SPHI_PAD), arrays[k].size);
    complete = complete && *arrays[k].array;
  }
  work->capacity = complete ? n : 0;
  work->dim = dim;
  SPH_CHECK(context, complete, SPH_E_MEMORY, "interpolator \"%s\": no memory for %d points",
            sph_interpolator_name(interpolator->type), n);
  return SPH_OK;
}

sph_status sphi_interpolation_reserve_list(const sph_interpolator *interpolator, int lanes,
                                           const sphi_list *list, sphi_interpolation *work) {
  if (interpolator->type != SPH_INTERPOLATOR_USER) return SPH_OK;
  sph_context *context = interpolator->context;
  for (int32_t c = 0; c < list->clusters; c++)
    if (list->entry[c].count > work->room) work->room = list->entry[c].count + SPHI_PAD;
  SPH_CHECK(context,
            sphi_reserve(context, (void **)&work->collected, &work->collected_capacity,
                         context->threads * lanes * SPHI_COLLECTED(work->dim) * work->room,
                         sizeof(double)),
            SPH_E_MEMORY, "interpolator \"%s\": no memory for %lld neighbours",
            sph_interpolator_name(interpolator->type), (long long)work->room);
  work->threads = context->threads;
  return SPH_OK;
}

/* The clusters that hold a pending target, in order. */
static int32_t collect_pending(const sphi_clusters *targets, const sphi_interpolation *work) {
  int32_t count = 0;
  if (targets->n == 0 || !memchr(work->rung, SPHI_PENDING, (size_t)work->n)) return 0;
  for (int32_t c = 0; c < targets->n; c++) {
    const uint8_t *rung = work->rung + targets->first[c];
    bool pending = false;
    for (int32_t l = 0; l < targets->count[c]; l++) pending = pending || rung[l] == SPHI_PENDING;
    if (pending) work->retry[count++] = c;
  }
  return count;
}

typedef struct row {
  int operator_index;
  sph_interpolator_type below;
} row;

static row row_of(sph_interpolator_type type) {
  enum { SPH_INTERPOLATOR_NONE = 0 };
  switch (type) {
#define ROW_CASE(id, enumerator, operator_name, below, name, summary, source) \
  case SPH_INTERPOLATOR_##enumerator:                                         \
    return (row){SPHI_OPERATOR_##operator_name, (sph_interpolator_type)SPH_INTERPOLATOR_##below};
    SPHI_INTERPOLATOR_LIST(ROW_CASE)
#undef ROW_CASE
  }
  return (row){SPHI_OPERATOR_nearest, (sph_interpolator_type)0};
}

/* Whether Shepard's weights need no powers in general, and end smoothly where the support does. */
static bool is_plain(const sph_interpolator *interpolator) {
  const double mu = interpolator->mu;
  return interpolator->lambda == 2 && (mu == 2 || mu == 4) &&
         mu <= 6 * interpolator->scale * interpolator->scale;
}

/* What a method asks of a target's neighbours. The smallest ratio of pivots in single precision keeps
 * the errors of moments, 1e-6, small against the smallest pivot. SFDI's bound of sum |phi| is about
 * twice the sum: with 3 it would turn away points at plain walls. */
static void set_conditions(sphi_interpolation_arguments *a, sph_interpolator_type type, int dim,
                           bool is_double) {
  const bool quadratic = type == SPH_INTERPOLATOR_MLS_QUADRATIC;
  const bool shepard = type == SPH_INTERPOLATOR_IMPROVED_SHEPARD ||
                       type == SPH_INTERPOLATOR_TUNED_SHEPARD ||
                       type == SPH_INTERPOLATOR_CLASSIC_SHEPARD;
  a->type = (uint8_t)type;
  a->printed = type == SPH_INTERPOLATOR_SFDI_PRINTED;
  a->gamma_min = shepard ? 0 : gamma_min;
  a->neighbours_min = quadratic ? (dim == 2 ? 10 : 16) : dim == 2 ? 5 : 8;
  a->pivot_min = is_double ? 1e-7 : quadratic ? 1e-5 : 1e-3;
  a->lebesgue_max = is_sfdi(type) ? 6 : 3;
}

void sphi_interpolate(const sph_interpolator *interpolator, const sphi_variant *variant,
                      sphi_sweep *sweep, sphi_interpolation *work) {
  sph_context *context = interpolator->context;
  const double support = interpolator->kernel->support;
  work->dim = sweep->frame->dim;
  work->compensation = interpolator->compensation;
  sphi_interpolation_arguments a = {
      .to = work,
      .inverse_h = 1 / interpolator->kernel->h,
      .inverse_radius2 = 1 / (support * support),
      .mu_half = interpolator->mu / 2,
      .lambda_half = interpolator->lambda / 2,
      .attenuation = interpolator->mu / (interpolator->scale * interpolator->scale),
      .weights = interpolator->weights,
      .user = interpolator->user,
      .support = support};
  sweep->kernel = interpolator->kernel;
  sweep->subset = NULL;
  /* There may be more threads than there were when the list was made: room is for those. */
  const int threads = context->threads;
  if (interpolator->type == SPH_INTERPOLATOR_USER && threads > work->threads)
    context->threads = work->threads;
  for (sph_interpolator_type type = interpolator->type; type; type = row_of(type).below) {
    if (is_sfdi(type)) {
      set_conditions(&a, SPH_INTERPOLATOR_NEAREST, work->dim, variant->is_double);
      sphi_sweep_run(context, variant, SPHI_OPERATOR_nearest, sweep, &a);
    }
    set_conditions(&a, type, work->dim, variant->is_double);
    int operator_index = row_of(type).operator_index;
    if (operator_index == SPHI_OPERATOR_shepard && !is_plain(interpolator))
      operator_index = SPHI_OPERATOR_shepard_any;
    sphi_sweep_run(context, variant, operator_index, sweep, &a);
    sweep->subset = work->retry;
    sweep->subset_count = collect_pending(sweep->targets, work);
    if (sweep->subset_count == 0) break;
    a.again = true;
  }
  context->threads = threads;
  sweep->subset = NULL;
  sweep->subset_count = 0;
}
