/* Products, sums and residuals over blocks of rows. */
#include "solver/solver_impl.h"

/* Rows of a block: enough to be worth a thread. */
static const int64_t least_rows = 1024;

sphi_blocks sphi_blocks_of(const sph_context *context, int64_t n) {
  sphi_blocks blocks = {.n = n, .size = (n + SPHI_SOLVER_MAX_BLOCKS - 1) / SPHI_SOLVER_MAX_BLOCKS};
  if (blocks.size < least_rows) blocks.size = least_rows;
  blocks.count = (int)((n + blocks.size - 1) / blocks.size);
  blocks.threads = context->threads < blocks.count ? context->threads : blocks.count;
  return blocks;
}

/* What is to be taken off the rows that are free so that their mean is 0; `sum` is that of all rows. */
static double free_mean(const sph_solver *solver, double sum, const double *x) {
  for (int k = 0; k < solver->blocks.count; k++) {
    const int32_t *fixed = solver->fixed + sphi_block_first(&solver->blocks, k);
    for (int32_t f = 0; f < solver->fixed_count[k]; f++) sum -= x[fixed[f]];
  }
  return solver->free_rows > 0 ? sum / (double)solver->free_rows : 0;
}

/* x - mean in the free rows of block k. */
static void take_off(const sph_solver *solver, int k, double mean, double *x) {
  const int64_t end = sphi_block_end(&solver->blocks, k);
  const int32_t *fixed = solver->fixed + sphi_block_first(&solver->blocks, k);
  const int32_t *last = fixed + solver->fixed_count[k];
  for (int64_t i = sphi_block_first(&solver->blocks, k); i < end; i++) {
    if (fixed < last && *fixed == i)
      fixed++;
    else
      x[i] -= mean;
  }
}

void sphi_solver_project(const sph_solver *solver, double *x) {
  const sphi_blocks *blocks = &solver->blocks;
  double sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) sum += x[i];
    sums[k] = sum;
  }
  const double mean = free_mean(solver, sphi_block_sum(blocks, sums), x);
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) take_off(solver, k, mean, x);
}

double sphi_solver_dot(const sph_solver *solver, const double *a, const double *b) {
  const sphi_blocks *blocks = &solver->blocks;
  double sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++)
      sum += a[i] * b[i];
    sums[k] = sum;
  }
  return sphi_block_sum(blocks, sums);
}

void sphi_solver_multiply(const sph_solver *solver, const double *x, double *y, const double *u,
                          double *uy, double *yy) {
  const sphi_blocks *blocks = &solver->blocks;
  double uy_sums[SPHI_SOLVER_MAX_BLOCKS], yy_sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double uy_sum = 0, yy_sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      const double value = sphi_row_times(&solver->matrix, i, x);
      y[i] = value;
      uy_sum += u[i] * value;
      yy_sum += value * value;
    }
    uy_sums[k] = uy_sum;
    yy_sums[k] = yy_sum;
  }
  if (solver->null_space) {
    sphi_solver_project(solver, y);
    *uy = sphi_solver_dot(solver, u, y);
    *yy = sphi_solver_dot(solver, y, y);
  } else {
    *uy = sphi_block_sum(blocks, uy_sums);
    *yy = sphi_block_sum(blocks, yy_sums);
  }
}

double sphi_solver_subtract(const sph_solver *solver, double *r, double alpha, const double *v) {
  const sphi_blocks *blocks = &solver->blocks;
  double sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      const double left = r[i] - alpha * v[i];
      r[i] = left;
      sum += left * left;
    }
    sums[k] = sum;
  }
  return sqrt(sphi_block_sum(blocks, sums));
}

double sphi_solver_residual(const sph_solver *solver, const double *b, const double *x, double *r) {
  const sphi_blocks *blocks = &solver->blocks;
  double sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      const double value = b[i] - sphi_row_times(&solver->matrix, i, x);
      r[i] = value;
      sum += value * value;
    }
    sums[k] = sum;
  }
  if (!solver->null_space) return sqrt(sphi_block_sum(blocks, sums));
  sphi_solver_project(solver, r);
  return sqrt(sphi_solver_dot(solver, r, r));
}
