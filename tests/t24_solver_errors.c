/* Solvers: names, settings, malformed systems, limits, breakdown, no memory. */
#include "solver_test.h"

static double residual_norm(const sparse *s, const double *x) {
  double *y = zeros(s->n), sum = 0;
  sparse_multiply(s, x, y);
  for (int64_t i = 0; i < s->n; i++) sum += (s->b[i] - y[i]) * (s->b[i] - y[i]);
  free(y);
  return sqrt(sum);
}

static void names_are_found(void) {
  sph_solver_kind kind = SPH_SOLVER_CG;
  sph_preconditioner preconditioner = SPH_PRECONDITIONER_NONE;
  for (int k = 1; k <= sph_solver_count(); k++) {
    SPH_TEST_OK(context, sph_solver_find(context, sph_solver_kind_name((sph_solver_kind)k), &kind));
    CU_ASSERT((int)kind == k);
    CU_ASSERT(strlen(sph_solver_kind_summary(kind)) > 5);
  }
  for (int k = 1; k <= sph_preconditioner_count(); k++) {
    const char *name = sph_preconditioner_name((sph_preconditioner)k);
    SPH_TEST_OK(context, sph_preconditioner_find(context, name, &preconditioner));
    CU_ASSERT((int)preconditioner == k);
    CU_ASSERT(strlen(sph_preconditioner_summary(preconditioner)) > 5);
  }
  kind = SPH_SOLVER_CG;
  SPH_TEST_STATUS(context, sph_solver_find(context, "bicgstag", &kind), SPH_E_NAME,
                  "did you mean \"bicgstab\"");
  SPH_TEST_STATUS(context, sph_solver_find(context, "quite another thing", &kind), SPH_E_NAME,
                  "unknown solver");
  SPH_TEST_STATUS(context, sph_preconditioner_find(context, "multigird", &preconditioner),
                  SPH_E_NAME, "did you mean \"multigrid\"");
  SPH_TEST_STATUS(context, sph_solver_find(context, NULL, &kind), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_preconditioner_find(context, "none", NULL), SPH_E_ARGUMENT, "NULL");
  CU_ASSERT(kind == SPH_SOLVER_CG);
  CU_ASSERT_STRING_EQUAL(sph_solver_kind_name((sph_solver_kind)0), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_solver_kind_summary((sph_solver_kind)99), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_preconditioner_name((sph_preconditioner)0), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_preconditioner_summary((sph_preconditioner)99), "unknown");
}

static void settings_are_checked(void) {
  sph_solver *solver = NULL;
  sph_solver_stats stats;
  SPH_TEST_STATUS(context, sph_solver_create(context, (sph_solver_kind)0, &solver), SPH_E_ARGUMENT,
                  "got 0");
  SPH_TEST_STATUS(context, sph_solver_create(context, SPH_SOLVER_CG, NULL), SPH_E_ARGUMENT, "NULL");
  CU_ASSERT(sph_solver_create(NULL, SPH_SOLVER_CG, &solver) == SPH_E_ARGUMENT && !solver);
  solver = solver_of(SPH_SOLVER_CG, SPH_PRECONDITIONER_JACOBI);
  SPH_TEST_STATUS(context, sph_solver_set_preconditioner(solver, (sph_preconditioner)77),
                  SPH_E_ARGUMENT, "got 77");
  SPH_TEST_STATUS(context, sph_solver_set_tolerance(solver, -1, 0), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(context, sph_solver_set_tolerance(solver, NAN, 0), SPH_E_ARGUMENT, "nan");
  SPH_TEST_STATUS(context, sph_solver_set_tolerance(solver, 0.1, -2), SPH_E_ARGUMENT, "got -2");
  SPH_TEST_STATUS(context, sph_solver_set_tolerance(solver, 0, 0), SPH_E_ARGUMENT, "must be > 0");
  SPH_TEST_STATUS(context, sph_solver_set_limit(solver, -3), SPH_E_ARGUMENT, "got -3");
  SPH_TEST_STATUS(context, sph_solver_set_reuse(solver, -4), SPH_E_ARGUMENT, "got -4");
  SPH_TEST_STATUS(context, sph_solver_get_stats(solver, NULL), SPH_E_ARGUMENT, "stats");
  CU_ASSERT(sph_solver_set_preconditioner(NULL, SPH_PRECONDITIONER_NONE) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_solver_set_tolerance(NULL, 1, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_solver_set_limit(NULL, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_solver_set_null_space(NULL, true) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_solver_set_reuse(NULL, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_solver_get_stats(NULL, &stats) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_solver_solve(NULL, NULL, NULL, NULL) == SPH_E_ARGUMENT);
  sph_solver_destroy(&solver);
  CU_ASSERT(solver == NULL);
  sph_solver_destroy(&solver);
  sph_solver_destroy(NULL);
}

/* Each fault is named with its row, and x stays as it was. */
static void faults_are_named(void) {
  int64_t row_start[] = {0, 2, 5, 7};
  int32_t columns[] = {0, 1, 0, 1, 2, 1, 2};
  double values[] = {2, -1, -1, 2, -1, -1, 2}, b[] = {1, 2, 3}, x[] = {4, 5, 6};
  sph_matrix matrix = {3, row_start, columns, values};
  sph_solver *solver = solver_of(SPH_SOLVER_BICGSTAB, SPH_PRECONDITIONER_MULTIGRID);
#define REFUSED(change, undo, text)                                                          \
  do {                                                                                       \
    change;                                                                                  \
    SPH_TEST_STATUS(context, sph_solver_solve(solver, &matrix, b, x), SPH_E_ARGUMENT, text); \
    undo;                                                                                    \
  } while (0)
  REFUSED(matrix.n = 0, matrix.n = 3, "got 0");
  REFUSED(matrix.n = 1ll << 31, matrix.n = 3, "2147483648");
  REFUSED(matrix.columns = NULL, matrix.columns = columns, "arrays of the matrix");
  REFUSED(row_start[0] = -1, row_start[0] = 0, "row 0");
  REFUSED(row_start[1] = 6, row_start[1] = 2, "row 1 starts at 6 and ends before, at 5");
  REFUSED(columns[4] = 3, columns[4] = 2, "row 1 has column 3, not 0 to 2");
  REFUSED(columns[6] = -1, columns[6] = 2, "row 2 has column -1");
  REFUSED(values[5] = NAN, values[5] = -1, "row 2 has a value that is not finite");
  REFUSED(values[0] = -INFINITY, values[0] = 2, "row 0 has a value that is not finite");
  REFUSED(columns[0] = 2, columns[0] = 0, "row 0 has no diagonal");
  REFUSED(values[3] = 0, values[3] = 2, "row 1 has a diagonal that is zero");
  REFUSED(b[2] = NAN, b[2] = 3, "b of row 2 must be finite, got nan");
  REFUSED(x[1] = INFINITY, x[1] = 5, "x of row 1 must be finite, got inf");
  REFUSED(b[1] = 1e200, b[1] = 2, "||b||");
#undef REFUSED
  SPH_TEST_STATUS(context, sph_solver_solve(solver, NULL, b, x), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_solver_solve(solver, &matrix, NULL, x), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_solver_solve(solver, &matrix, b, NULL), SPH_E_ARGUMENT, "NULL");
  CU_ASSERT(x[0] == 4 && x[1] == 5 && x[2] == 6 && stats_of(solver).solves == 0);
  SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, b, x));
  SPH_TEST_CLOSE(x[0], 2.5, 1e-5, 0);
  SPH_TEST_CLOSE(x[1], 4, 1e-5, 0);
  SPH_TEST_CLOSE(x[2], 3.5, 1e-5, 0);
  /* A guess beyond all bounds is dropped. */
  x[0] = 1e308, x[1] = -1e308;
  SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, b, x));
  SPH_TEST_CLOSE(x[1], 4, 1e-5, 0);
  memset(b, 0, sizeof b);
  SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, b, x));
  CU_ASSERT(x[0] == 0 && x[1] == 0 && x[2] == 0);
  sph_solver_destroy(&solver);
}

/* Where the limit is reached x has the least residual so far, that of the guess if need be. */
static void limits_keep_the_best(void) {
  sparse s = sparse_water(2, 80, 40, 1, 0.2, 2), jump = sparse_jump(70, 70, 1000);
  double *x = zeros(jump.n > s.n ? jump.n : s.n);
  FOR_METHODS(kind) {
    const sparse *system = kind == SPH_SOLVER_CG ? &jump : &s;
    const sph_matrix matrix = matrix_of(system);
    for (int p = 1; p <= sph_preconditioner_count(); p++) {
      double last = INFINITY;
      sph_solver *solver = solver_of((sph_solver_kind)kind, (sph_preconditioner)p);
      SPH_TEST_OK(context, sph_solver_set_tolerance(solver, 1e-13, 0));
      for (int limit = 0; limit < 24; limit += 1 + limit / 4) {
        for (int64_t i = 0; i < system->n; i++)
          x[i] = system->x[i] * (1 + 0.01 * cos(9 * system->place[3 * i]));
        SPH_TEST_OK(context, sph_solver_set_limit(solver, limit));
        const sph_status status = sph_solver_solve(solver, &matrix, system->b, x);
        const sph_solver_stats stats = stats_of(solver);
        const double residual = residual_norm(system, x);
        CU_ASSERT(stats.iterations <= limit);
        if (limit < 8) CU_ASSERT(status == SPH_E_NOT_CONVERGED && stats.iterations == limit);
        if (status != SPH_OK) CU_ASSERT(strstr(sph_context_message(context), "iterations") != NULL);
        SPH_TEST_CLOSE(residual, stats.residual, 1e-6, 1e-11 * stats.initial_residual);
        CU_ASSERT(residual <= 1.0000001 * stats.initial_residual);
        CU_ASSERT(residual <= 1.0000001 * last + 1e-11 * stats.initial_residual);
        last = residual;
      }
      sph_solver_destroy(&solver);
    }
  }
  free(x), sparse_free(&s), sparse_free(&jump);
}

/* Methods break down on matrices they are not for, and say so; none loops or leaves a NaN. */
static void breakdown_is_told(void) {
  const int64_t row_start[] = {0, 2, 4}, singular_start[] = {0, 2, 4};
  const int32_t columns[] = {0, 1, 0, 1};
  const double turning[] = {1e-9, 1, -1, 1e-9}, indefinite[] = {1, 2, 2, 1}, one[] = {1, 1, 1, 1};
  const double b[] = {1, 0}, start[] = {0, 0};
  const struct {
    const int64_t *row_start;
    const double *values;
  } cases[] = {{row_start, turning}, {row_start, indefinite}, {singular_start, one}};
  FOR_METHODS(kind)
  for (int p = 1; p <= sph_preconditioner_count(); p++)
    for (int c = 0; c < 3; c++) {
      double x[2] = {start[0], start[1]};
      const sph_matrix matrix = {2, cases[c].row_start, columns, cases[c].values};
      sph_solver *solver = solver_of((sph_solver_kind)kind, (sph_preconditioner)p);
      const sph_status status = sph_solver_solve(solver, &matrix, b, x);
      const double *a = cases[c].values;
      const double left = hypot(b[0] - a[0] * x[0] - a[1] * x[1], b[1] - a[2] * x[0] - a[3] * x[1]);
      if (status == SPH_OK)
        SPH_TEST_BELOW(left, 1.0001e-6);
      else
        CU_ASSERT(status == SPH_E_NOT_CONVERGED && isfinite(x[0]) && isfinite(x[1]) && left <= 1);
      if (c == 2) CU_ASSERT(status == SPH_E_NOT_CONVERGED);
      sph_solver_destroy(&solver);
    }
}

static void no_memory(void) {
  sparse s = sparse_water(2, 80, 40, 1, 0.2, 2), small = sparse_water(2, 20, 10, 1, 0.2, 2);
  double *x = zeros(s.n);
  FOR_METHODS(kind)
  for (int p = 1; p <= sph_preconditioner_count(); p++) {
    bool made = false;
    for (int allowed = 0; !made && allowed < 400; allowed++) {
      sph_test_memory memory = {1000, 0};
      const sph_allocator allocator = {sph_test_allocate, sph_test_release, &memory};
      sph_context *own = NULL;
      sph_solver *solver = NULL;
      CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &own) == SPH_OK);
      memory.allowed = allowed;
      sph_status status = sph_solver_create(own, (sph_solver_kind)kind, &solver);
      if (status == SPH_OK) status = sph_solver_set_preconditioner(solver, (sph_preconditioner)p);
      const sph_matrix matrices[] = {matrix_of(&small), matrix_of(&s)};
      const double *const b[] = {small.b, s.b};
      for (int m = 0; m < 2 && status == SPH_OK; m++) {
        x[0] = 3;
        status = sph_solver_solve(solver, &matrices[m], b[m], x);
        if (status == SPH_E_MEMORY) CU_ASSERT(x[0] == 3);
        if (kind == SPH_SOLVER_CG && status == SPH_E_NOT_CONVERGED) status = SPH_OK;
        memset(x, 0, (size_t)s.n * sizeof *x);
      }
      CU_ASSERT(status == SPH_OK || status == SPH_E_MEMORY);
      made = status == SPH_OK;
      sph_solver_destroy(&solver);
      sph_context_destroy(&own);
      CU_ASSERT(memory.live == 0);
    }
    CU_ASSERT(made);
  }
  free(x), sparse_free(&s), sparse_free(&small);
}

/* Once sizes have settled, a solve asks for no memory. */
static void memory_settles(void) {
  sparse s = sparse_water(2, 80, 40, 1, 0.2, 2);
  const sph_matrix matrix = matrix_of(&s);
  double *x = zeros(s.n);
  FOR_METHODS(kind)
  for (int p = SPH_PRECONDITIONER_JACOBI; p <= sph_preconditioner_count(); p++) {
    if (kind == SPH_SOLVER_CG) continue; /* the matrix is not symmetric */
    sph_test_memory memory = {1000, 0};
    const sph_allocator allocator = {sph_test_allocate, sph_test_release, &memory};
    sph_context *own = NULL;
    sph_solver *solver = NULL;
    SPH_TEST_OK(own, sph_context_create_with_allocator(&allocator, &own));
    SPH_TEST_OK(own, sph_solver_create(own, (sph_solver_kind)kind, &solver));
    SPH_TEST_OK(own, sph_solver_set_preconditioner(solver, (sph_preconditioner)p));
    for (int n = 0; n < 3; n++) {
      memset(x, 0, (size_t)s.n * sizeof *x);
      SPH_TEST_OK(own, sph_solver_solve(solver, &matrix, s.b, x));
      memory.allowed = 0;
    }
    sph_solver_destroy(&solver);
    sph_context_destroy(&own);
    CU_ASSERT(memory.live == 0);
  }
  free(x), sparse_free(&s);
}

SPH_TEST_MAIN("solver errors", {"context opens", context_opens},
              {"names are found", names_are_found}, {"settings are checked", settings_are_checked},
              {"faults are named with their row", faults_are_named},
              {"limits keep the best x", limits_keep_the_best},
              {"breakdown is told", breakdown_is_told}, {"without memory nothing leaks", no_memory},
              {"a solve takes no memory once sizes have settled", memory_settles},
              {"context closes", context_closes})
