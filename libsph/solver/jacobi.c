/* The diagonal as preconditioner. */
#include "solver/solver_impl.h"

static sph_status setup(sph_solver *solver) {
  (void)solver;
  return SPH_OK;
}

static void apply(sph_solver *solver, const double *r, double *z) {
  const sphi_blocks *blocks = &solver->blocks;
  const double *inverse = solver->inverse_diagonal;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++)
      z[i] = inverse[i] * r[i];
}

static void release(sph_solver *solver) { (void)solver; }

const sphi_preconditioner sphi_preconditioner_jacobi = {
    .name = "jacobi",
    .summary = "the diagonal",
    .setup = setup,
    .apply = apply,
    .release = release,
};
