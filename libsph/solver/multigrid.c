/* Multigrid of aggregates as preconditioner: one cycle from zero.
 *
 * A level smooths with a Gauss-Seidel sweep forwards before and backwards after the correction of the
 * level below, within blocks of rows; between blocks values are those of before the sweep, so that blocks
 * are independent. Below the finest level a correction is two steps of conjugate residuals, each
 * preconditioned with a cycle of its level: the K-cycle of Notay and Vassilevski (2008),
 * doi:10.1002/nla.542.
 */
#include "solver/multigrid_impl.h"

/* A second step is taken if the first leaves more than this of the residual. */
static const double good_enough = 0.25;

/* The residual that the finest level takes and the result that it gives, in units of the matrix. */
typedef struct transfer {
  const double *r;
  double *z, in, out;
} transfer;

static void cycle(sphi_multigrid *grid, int l, const transfer *finest);

/* Smoothing forwards from zero in block k, z = r + (entries before) z, and what the block's other entries
 * make of it: the residual but for other blocks. It goes where the result will be. */
static void forwards(const sphi_level *level, int k) {
  const float *restrict r = level->r;
  float *first = level->first;
  const int64_t begin = sphi_block_first(&level->blocks, k);
  const int64_t end = sphi_block_end(&level->blocks, k);
  for (int64_t i = begin; i < end; i++)
    first[i] = r[i] + sphi_part_times(level->columns + level->start[i],
                                      level->values + level->start[i], first, 0, level->before[i]);
  for (int64_t i = begin; i < end; i++)
    level->z[i] = sphi_part_times(level->columns + level->start[i], level->values + level->start[i],
                                  first, level->before[i], level->inside[i]);
}

/* Sums of residuals over aggregates: the right-hand side of the next level. */
static void restrict_residual(const sphi_level *level, sphi_level *coarse) {
  const int threads = level->blocks.threads;
  (void)threads; /* without OpenMP */
#pragma omp parallel for num_threads(threads) schedule(static) if (threads > 1)
  for (int64_t c = 0; c < coarse->n; c++) {
    float sum = 0;
    for (int32_t m = level->member_start[c]; m < level->member_end[c]; m++) {
      const int32_t i = level->members[m];
      float residual = level->z[i];
      if (level->total[i] > level->inside[i])
        residual +=
            sphi_part_times(level->columns + level->start[i], level->values + level->start[i],
                            level->first, level->inside[i], level->total[i]);
      sum += level->weight[i] * residual;
    }
    coarse->r[c] = sum * coarse->inverse_weight[c];
  }
}

/* Adds the correction of the next level and smooths backwards in block k. */
static void backwards(const sphi_level *level, const float *correction, int k) {
  const int32_t *restrict aggregate = level->aggregate;
  const float *restrict first = level->first;
  float *z = level->z;
  const int64_t begin = sphi_block_first(&level->blocks, k);
  const int64_t end = sphi_block_end(&level->blocks, k);
  for (int64_t i = begin; i < end; i++) z[i] = first[i] + correction[aggregate[i]];
  for (int64_t i = end - 1; i >= begin; i--) {
    const int32_t *restrict columns = level->columns + level->start[i];
    const float *restrict values = level->values + level->start[i];
    float sum = level->r[i] + sphi_part_times(columns, values, z, 0, level->inside[i]);
    for (int32_t m = level->inside[i]; m < level->total[i]; m++)
      sum += values[m] * (first[columns[m]] + correction[aggregate[columns[m]]]);
    z[i] = sum;
  }
}

/* v = D^-1 A z, and the products v.r, v.v, v.c with the diagonal as weight. */
static void multiply(const sphi_level *level, float *v, double *vr, double *vv, double *vc) {
  const sphi_blocks *blocks = &level->blocks;
  const float *restrict z = level->z;
  double r_sums[SPHI_SOLVER_MAX_BLOCKS], v_sums[SPHI_SOLVER_MAX_BLOCKS];
  double c_sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double r_sum = 0, v_sum = 0, c_sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      const float sum =
          z[i] - sphi_part_times(level->columns + level->start[i], level->values + level->start[i],
                                 z, 0, level->total[i]);
      const float weighted = fabsf(level->weight[i]) * sum;
      r_sum += (double)(weighted * level->r[i]);
      v_sum += (double)(weighted * sum);
      c_sum += (double)(weighted * level->v[i]);
      v[i] = sum;
    }
    r_sums[k] = r_sum;
    v_sums[k] = v_sum;
    c_sums[k] = c_sum;
  }
  *vr = sphi_block_sum(blocks, r_sums);
  *vv = sphi_block_sum(blocks, v_sums);
  *vc = sphi_block_sum(blocks, c_sums);
}

/* r -= alpha v, c = z; the squares of r before and after. */
static void first_step(const sphi_level *level, float alpha, double *before, double *after) {
  const sphi_blocks *blocks = &level->blocks;
  double old_sums[SPHI_SOLVER_MAX_BLOCKS], new_sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double old_sum = 0, new_sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      const float old = level->r[i], r = old - alpha * level->v[i];
      const float weight = fabsf(level->weight[i]);
      old_sum += (double)(weight * old * old);
      new_sum += (double)(weight * r * r);
      level->r[i] = r;
      level->c[i] = level->z[i];
    }
    old_sums[k] = old_sum;
    new_sums[k] = new_sum;
  }
  *before = sphi_block_sum(blocks, old_sums);
  *after = sphi_block_sum(blocks, new_sums);
}

/* x = a c + b z. */
static void combine(const sphi_level *level, float a, float b) {
  const sphi_blocks *blocks = &level->blocks;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++)
      level->x[i] = a * level->c[i] + b * level->z[i];
}

static void solve_dense(const sphi_multigrid *grid, const sphi_level *level) {
  const int n = (int)level->n;
  double x[SPHI_MULTIGRID_DENSE];
  for (int i = 0; i < n; i++) x[i] = (double)level->r[i];
  for (int k = 0; k < n; k++) {
    const double swap = x[grid->pivots[k]];
    x[grid->pivots[k]] = x[k];
    x[k] = swap;
  }
  for (int i = 0; i < n; i++)
    for (int j = 0; j < i; j++) x[i] -= grid->factors[i][j] * x[j];
  for (int i = n - 1; i >= 0; i--) {
    for (int j = i + 1; j < n; j++) x[i] -= grid->factors[i][j] * x[j];
    x[i] *= grid->factors[i][i];
  }
  for (int i = 0; i < n; i++) level->x[i] = (float)x[i];
}

/* x of a coarse level from its r, which it spends. */
static void correct(sphi_multigrid *grid, int l) {
  sphi_level *level = &grid->levels[l];
  if (l + 1 == grid->count && grid->dense) {
    solve_dense(grid, level);
    return;
  }
  double vr, vv, unused, before, after;
  cycle(grid, l, NULL);
  multiply(level, level->v, &vr, &vv, &unused);
  if (!(vv > 0)) {
    memset(level->x, 0, (size_t)level->n * sizeof *level->x);
    return;
  }
  const double alpha = vr / vv;
  first_step(level, (float)alpha, &before, &after);
  if (after <= good_enough * good_enough * before) {
    combine(level, (float)alpha, 0);
    return;
  }
  double wr, ww, wv;
  cycle(grid, l, NULL);
  multiply(level, level->first, &wr, &ww, &wv);
  /* The part of w = A z that v has not: r has nothing of v left. */
  const double share = wv / vv, rest_square = ww - share * wv;
  const double beta = rest_square > 1e-6 * ww ? wr / rest_square : 0;
  combine(level, (float)(alpha - beta * share), (float)beta);
}

static void take(const sphi_level *level, const transfer *finest, int k) {
  for (int64_t i = sphi_block_first(&level->blocks, k); i < sphi_block_end(&level->blocks, k); i++)
    level->r[i] = (float)(finest->r[i] * finest->in) * level->inverse_weight[i];
}

static void give(const sphi_level *level, const transfer *finest, int k) {
  for (int64_t i = sphi_block_first(&level->blocks, k); i < sphi_block_end(&level->blocks, k); i++)
    finest->z[i] = (double)level->z[i] * finest->out;
}

/* z of level l from its r, which the finest level takes from the caller's. */
static void cycle(sphi_multigrid *grid, int l, const transfer *finest) {
  sphi_level *level = &grid->levels[l];
  const sphi_blocks *blocks = &level->blocks;
  const bool last = l + 1 == grid->count;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    if (finest) take(level, finest, k);
    forwards(level, k);
  }
  if (!last) {
    restrict_residual(level, level + 1);
    correct(grid, l + 1);
  }
  const float none = 0, *correction = last ? &none : level[1].x;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    backwards(level, correction, k);
    if (finest) give(level, finest, k);
  }
}

static sph_status setup(sph_solver *solver) {
  sph_context *context = solver->context;
  if (!solver->state) solver->state = SPHI_NEW(context, 1, sphi_multigrid);
  SPH_CHECK(context, solver->state && sphi_multigrid_make(solver, solver->state), SPH_E_MEMORY,
            "solver \"%s\": out of memory for the multigrid of %lld rows", solver->method->name,
            (long long)solver->matrix.n);
  return SPH_OK;
}

static void apply(sph_solver *solver, const double *r, double *z) {
  sphi_multigrid *grid = solver->state;
  const transfer finest = {r, z, solver->scale, 1 / (solver->scale * grid->largest)};
  cycle(grid, 0, &finest);
}

static void release(sph_solver *solver) {
  if (solver->state) sphi_multigrid_free(solver->context, solver->state);
  solver->state = NULL;
}

const sphi_preconditioner sphi_preconditioner_multigrid = {
    .name = "multigrid",
    .summary = "K-cycle over aggregates of rows, Gauss-Seidel within blocks",
    .setup = setup,
    .apply = apply,
    .release = release,
};
