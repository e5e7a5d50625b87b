/* From the operators' sums to values: one target at a time, and down the ladder where a target's
 * neighbours do not carry the method. */
#include "interpolator/interpolator_impl.h"
#include "interpolator/interpolator_list.h"
#include "interpolator/ops.h"

/* Below this sum of kernel weights they are mostly the rounding of the kernel near its end. */
static const double gamma_min = 1e-4;
/* Bound of sum |phi|: how much larger than the sources' largest an interpolated value can be. */
static const double lebesgue_max = 3;
/* Smallest ratio of pivots. Moments in float carry errors of 1e-6, which this bounds to 1e-3 of the
 * smallest pivot; neighbours that are flatter than 3 % of h are the price. */
static const double pivot_min_double = 1e-7, pivot_min_single = 1e-3;

enum { PENDING = 255 }; /* a rung: this target goes down the ladder */

void sphi_interpolation_free(sph_context *context, sphi_interpolation *work) {
  sphi_free(context, work->value);
  sphi_free(context, work->moment);
  sphi_free(context, work->gamma);
  sphi_free(context, work->neighbours);
  sphi_free(context, work->rung);
  sphi_free(context, work->sums);
  sphi_free(context, work->retry);
  memset(work, 0, sizeof *work);
}

sph_status sphi_interpolation_reserve(const sph_interpolator *interpolator, int dim, int32_t n,
                                      sphi_interpolation *work) {
  sph_context *context = interpolator->context;
  const int rows = interpolator->type == SPH_INTERPOLATOR_MLS_LINEAR ? SPHI_LINEAR_SUMS(dim)
                                                                     : SPHI_WEIGHTED_SUMS(dim);
  /* Every array holds its elements for the same number of targets, also after a failure. */
  struct {
    void **array;
    int64_t count;
    size_t size;
  } arrays[] = {{(void **)&work->value, dim + 1, sizeof(double)},
                {(void **)&work->moment, dim, sizeof(double)},
                {(void **)&work->gamma, 1, sizeof(double)},
                {(void **)&work->neighbours, 1, sizeof(int32_t)},
                {(void **)&work->rung, 1, sizeof(uint8_t)},
                {(void **)&work->retry, 1, sizeof(int32_t)}};
  bool complete = true;
  if (n > work->capacity || dim > work->dim) {
    for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) {
      sphi_free(context, *arrays[k].array);
      *arrays[k].array = sphi_alloc(context, (size_t)(arrays[k].count * n), arrays[k].size);
      complete = complete && *arrays[k].array;
    }
    work->capacity = complete ? n : 0;
    work->dim = dim;
  }
  if ((int64_t)rows * n > work->sums_capacity) {
    sphi_free(context, work->sums);
    work->sums = SPHI_NEW(context, (int64_t)rows * n, double);
    work->sums_capacity = work->sums ? (int64_t)rows * n : 0;
    complete = complete && work->sums;
  }
  SPH_CHECK(context, complete, SPH_E_MEMORY, "interpolator \"%s\": no memory for %d points",
            sph_interpolator_name(interpolator->type), n);
  return SPH_OK;
}

/* I[f] = sum w f / sum w, and the first moment sum w (x_j - x_k) / sum w where it is asked for. */
static void finish_weighted(const sphi_interpolation *work, int32_t k, bool compensation) {
  const int64_t n = work->n;
  const int dim = work->dim;
  const double *sums = work->sums + k;
  const double inverse = 1 / sums[SPHI_SUM_W * n];
  for (int f = 0; f <= dim; f++) work->value[f * n + k] = sums[(SPHI_SUM_F + f) * n] * inverse;
  for (int d = 0; d < dim; d++)
    work->moment[d * n + k] = compensation ? -sums[(SPHI_SUM_X(dim) + d) * n] * inverse : 0;
}

/* M / M_00 with the basis (1, (x_j - x_k) / h); only the lower triangle. */
static void scaled_moments(const sphi_interpolation *work, const double *sums, double h,
                           double m[4][4]) {
  const int64_t n = work->n;
  const int dim = work->dim;
  const double inverse = 1 / sums[SPHI_SUM_GAMMA * n];
  m[0][0] = 1;
  int product = SPHI_SUM_DD(dim);
  for (int d = 0; d < dim; d++) {
    m[d + 1][0] = -sums[(SPHI_SUM_D + d) * n] * inverse / h; /* the sums have x_k - x_j */
    for (int e = d; e < dim; e++) m[e + 1][d + 1] = sums[product++ * n] * inverse / (h * h);
  }
}

/* Solves m z = e_1 by m = L D L^T; false if the ratio of pivots is below pivot_min. L replaces m. */
static bool solve_first(int size, double m[4][4], double pivot_min, double z[4]) {
  double pivot[4], largest = 0;
  for (int j = 0; j < size; j++) {
    pivot[j] = m[j][j];
    for (int k = 0; k < j; k++) pivot[j] -= m[j][k] * m[j][k] * pivot[k];
    if (pivot[j] > largest) largest = pivot[j];
    if (!(pivot[j] >= pivot_min * largest)) return false;
    for (int i = j + 1; i < size; i++) {
      for (int k = 0; k < j; k++) m[i][j] -= m[i][k] * m[j][k] * pivot[k];
      m[i][j] /= pivot[j];
    }
  }
  for (int i = 0; i < size; i++) {
    z[i] = i == 0;
    for (int k = 0; k < i; k++) z[i] -= m[i][k] * z[k];
  }
  for (int i = size - 1; i >= 0; i--) {
    z[i] /= pivot[i];
    for (int k = i + 1; k < size; k++) z[i] -= m[k][i] * z[k];
  }
  /* A later pivot may have been the largest. */
  for (int j = 0; j < size; j++)
    if (pivot[j] < pivot_min * largest) return false;
  return true;
}

/* I[f] = z . sum W V b f with M z = e_1; false if the neighbours do not carry it.
 *
 * With phi_j = (z . b_j) W_j V_j the inequality of Cauchy and Schwarz gives
 * (sum |phi|)^2 <= sum W V sum W V (z . b)^2 = M_00 z M z = M_00 z_0. */
static bool finish_linear(const sphi_interpolation *work, int32_t k, double h, double pivot_min) {
  const int64_t n = work->n;
  const int dim = work->dim;
  const double *sums = work->sums + k;
  double m[4][4] = {{0}}, z[4] = {0};
  scaled_moments(work, sums, h, m);
  if (!solve_first(dim + 1, m, pivot_min, z)) return false;
  if (!(z[0] <= lebesgue_max * lebesgue_max)) return false;
  const double inverse = 1 / sums[SPHI_SUM_GAMMA * n];
  for (int f = 0; f <= dim; f++) {
    const double *rows = sums + (SPHI_SUM_FD(dim) + f * (dim + 1)) * n;
    double value = z[0] * rows[0];
    for (int d = 0; d < dim; d++) value -= z[d + 1] * rows[(d + 1) * n] / h;
    work->value[f * n + k] = value * inverse;
  }
  for (int d = 0; d < dim; d++) work->moment[d * n + k] = 0;
  return true;
}

/* Finishes one target of the interpolator's own operator, or leaves it pending. */
static void finish(const sph_interpolator *interpolator, const sphi_interpolation *work, int32_t k,
                   double pivot_min) {
  const int64_t n = work->n;
  const int dim = work->dim, neighbours_min = dim == 2 ? 5 : 8;
  const int neighbours = (int)work->sums[SPHI_SUM_N * n + k];
  const double gamma = work->sums[SPHI_SUM_GAMMA * n + k];
  work->neighbours[k] = neighbours;
  work->gamma[k] = gamma;
  if (neighbours == 0) {
    work->rung[k] = SPH_RUNG_NONE;
    for (int f = 0; f <= dim; f++) work->value[f * n + k] = 0;
    for (int d = 0; d < dim; d++) work->moment[d * n + k] = 0;
    return;
  }
  work->rung[k] = PENDING;
  switch (interpolator->type) {
    case SPH_INTERPOLATOR_IMPROVED_SHEPARD:
      finish_weighted(work, k, interpolator->compensation);
      work->rung[k] = SPH_RUNG_SHEPARD;
      return;
    case SPH_INTERPOLATOR_NORMALIZED:
      if (!(gamma >= gamma_min)) return;
      finish_weighted(work, k, interpolator->compensation);
      work->rung[k] = SPH_RUNG_NORMALIZED;
      return;
    case SPH_INTERPOLATOR_MLS_LINEAR:
      if (neighbours >= neighbours_min && gamma >= gamma_min &&
          finish_linear(work, k, interpolator->kernel->h, pivot_min))
        work->rung[k] = SPH_RUNG_LINEAR;
      return;
  }
}

/* The clusters that hold a pending target, in order. */
static int32_t collect_pending(const sphi_clusters *targets, const sphi_interpolation *work) {
  int32_t count = 0;
  for (int32_t c = 0; c < targets->n; c++) {
    const uint8_t *rung = work->rung + targets->first[c];
    bool pending = false;
    for (int32_t l = 0; l < targets->count[c]; l++) pending = pending || rung[l] == PENDING;
    if (pending) work->retry[count++] = c;
  }
  return count;
}

static int operator_of(sph_interpolator_type type) {
  switch (type) {
#define OPERATOR_CASE(id, enumerator, operator_name, name, summary, source) \
  case SPH_INTERPOLATOR_##enumerator: return SPHI_OPERATOR_##operator_name;
    SPHI_INTERPOLATOR_LIST(OPERATOR_CASE)
#undef OPERATOR_CASE
  }
  return SPHI_OPERATOR_shepard;
}

/* Every particle within the support has a positive Shepard weight: this never fails. */
static void retry(const sph_interpolator *interpolator, const sphi_variant *variant,
                  sphi_sweep *sweep, const sphi_interpolation *work,
                  const sphi_interpolation_arguments *arguments) {
  const sphi_clusters *targets = sweep->targets;
  sweep->subset = work->retry;
  sweep->subset_count = collect_pending(targets, work);
  if (sweep->subset_count > 0) {
    sphi_sweep_run(interpolator->context, variant, SPHI_OPERATOR_shepard, sweep, arguments);
    for (int32_t c = 0; c < sweep->subset_count; c++) {
      const int32_t cluster = work->retry[c], first = targets->first[cluster];
      for (int32_t k = first; k < first + targets->count[cluster]; k++) {
        if (work->rung[k] != PENDING) continue;
        finish_weighted(work, k, interpolator->compensation);
        work->rung[k] = SPH_RUNG_SHEPARD;
      }
    }
  }
  sweep->subset = NULL;
  sweep->subset_count = 0;
}

void sphi_interpolate(const sph_interpolator *interpolator, const sphi_variant *variant,
                      sphi_sweep *sweep, sphi_interpolation *work) {
  const sphi_clusters *targets = sweep->targets;
  const double support = interpolator->kernel->support;
  const double pivot_min = variant->is_double ? pivot_min_double : pivot_min_single;
  const sphi_interpolation_arguments arguments = {
      .sums = work->sums,
      .n = work->n,
      .inverse_radius2 = 1 / (support * support),
      .mu_half = interpolator->mu / 2,
      .lambda_half = interpolator->lambda / 2,
      .attenuation = interpolator->mu / (interpolator->scale * interpolator->scale)};
  work->dim = sweep->frame->dim;
  sweep->kernel = interpolator->kernel;
  sweep->subset = NULL;
  sphi_sweep_run(interpolator->context, variant, operator_of(interpolator->type), sweep,
                 &arguments);
#pragma omp parallel for num_threads(interpolator->context->threads) \
    schedule(static) if (targets->n > 8)
  for (int32_t c = 0; c < targets->n; c++)
    for (int32_t k = targets->first[c]; k < targets->first[c] + targets->count[c]; k++)
      finish(interpolator, work, k, pivot_min);
  retry(interpolator, variant, sweep, work, &arguments);
}
