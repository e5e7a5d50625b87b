/* What the tests of solvers share: a context that each suite opens and closes, and solvers made of it. */
#ifndef SPH_SOLVER_TEST_H
#define SPH_SOLVER_TEST_H

#include "solver_world.h"
#include "sph_test.h"

static sph_context *context;

static inline void context_opens(void) { CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK); }
static inline void context_closes(void) { sph_context_destroy(&context); }

/* The methods that every build has. */
#define FOR_METHODS(kind)                                \
  for (int kind = 1; kind <= sph_solver_count(); kind++) \
    if (kind != SPH_SOLVER_PETSC)

static inline sph_solver *solver_of(sph_solver_kind kind, sph_preconditioner preconditioner) {
  sph_solver *solver = NULL;
  SPH_TEST_OK(context, sph_solver_create(context, kind, &solver));
  SPH_TEST_OK(context, sph_solver_set_preconditioner(solver, preconditioner));
  return solver;
}

static inline sph_solver_stats stats_of(const sph_solver *solver) {
  sph_solver_stats stats = {0};
  CU_ASSERT(sph_solver_get_stats(solver, &stats) == SPH_OK);
  return stats;
}

static inline double *zeros(int64_t n) {
  double *x = calloc((size_t)n, sizeof *x);
  CU_ASSERT_FATAL(x != NULL);
  return x;
}

#endif
