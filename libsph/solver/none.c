/* No preconditioner. */
#include "solver/solver_impl.h"

static sph_status setup(sph_solver *solver) {
  (void)solver;
  return SPH_OK;
}

static void apply(sph_solver *solver, const double *r, double *z) {
  memcpy(z, r, (size_t)solver->matrix.n * sizeof *z);
}

static void release(sph_solver *solver) { (void)solver; }

const sphi_preconditioner sphi_preconditioner_none = {
    .name = "none",
    .summary = "no preconditioner",
    .setup = setup,
    .apply = apply,
    .release = release,
};
