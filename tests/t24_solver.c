/* Solvers: exactness, the pressures of particles, jumps, null spaces, warm starts, iteration counts. */
#include "solver_test.h"

static double norm(int64_t n, const double *a) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++) sum += a[i] * a[i];
  return sqrt(sum);
}

static double distance(int64_t n, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < n; i++) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sqrt(sum);
}

/* ||b - A x|| by plain loops. */
static double true_residual(const sparse *s, const double *x) {
  double *y = zeros(s->n);
  sparse_multiply(s, x, y);
  const double result = distance(s->n, s->b, y);
  free(y);
  return result;
}

/* Gauss elimination with row exchanges. */
static void solve_dense(const sparse *s, double *x) {
  const int n = (int)s->n;
  double *a = zeros((int64_t)n * n);
  for (int i = 0; i < n; i++) {
    for (int64_t k = s->row_start[i]; k < s->row_start[i + 1]; k++)
      a[i * n + s->columns[k]] += s->values[k];
    x[i] = s->b[i];
  }
  for (int k = 0; k < n; k++) {
    int p = k;
    for (int i = k + 1; i < n; i++)
      if (fabs(a[i * n + k]) > fabs(a[p * n + k])) p = i;
    for (int j = 0; j < n; j++) {
      const double swap = a[k * n + j];
      a[k * n + j] = a[p * n + j];
      a[p * n + j] = swap;
    }
    const double swap = x[k];
    x[k] = x[p];
    x[p] = swap;
    for (int i = k + 1; i < n; i++) {
      const double l = a[i * n + k] / a[k * n + k];
      for (int j = k; j < n; j++) a[i * n + j] -= l * a[k * n + j];
      x[i] -= l * x[k];
    }
  }
  for (int i = n - 1; i >= 0; i--) {
    for (int j = i + 1; j < n; j++) x[i] -= a[i * n + j] * x[j];
    x[i] /= a[i * n + i];
  }
  free(a);
}

/* Rows of random entries in random order and number, some with nothing but their diagonal. */
static sparse random_system(int64_t n, uint64_t seed, bool symmetric) {
  sparse s = sparse_new(n, n * n);
  double *a = zeros(n * n);
  for (int64_t i = 0; i < n; i++)
    for (int64_t j = 0; j < i; j++) {
      const double p = sparse_random(&seed), value = 2 * sparse_random(&seed) - 1.3;
      if (p > 0.15 || (i % 7 == 3) || (j % 7 == 3)) continue;
      a[i * n + j] = value;
      a[j * n + i] = symmetric ? value : value * sparse_random(&seed);
    }
  for (int64_t i = 0; i < n; i++) {
    double size = 0.2 + sparse_random(&seed);
    s.row_start[i + 1] = s.row_start[i];
    const int64_t turn = (int64_t)(sparse_random(&seed) * (double)n);
    for (int64_t m = 0; m < n; m++) {
      const int64_t j = (m + turn) % n;
      size += (symmetric ? 1 : 0.9) * fabs(a[i * n + j]);
      if (j != i && a[i * n + j] != 0) sparse_add(&s, i, (int32_t)j, a[i * n + j]);
    }
    sparse_add(&s, i, (int32_t)i, size);
    s.b[i] = 2 * sparse_random(&seed) - 1;
  }
  free(a);
  return s;
}

/* Every method with every preconditioner, against elimination. */
static void dense_agrees(void) {
  FOR_METHODS(kind)
  for (int p = 1; p <= sph_preconditioner_count(); p++)
    for (uint64_t seed = 1; seed <= 6; seed++) {
      sparse s = random_system(seed == 1 ? 1 : 12 * (int64_t)seed, seed, kind == SPH_SOLVER_CG);
      double *x = zeros(s.n), *expected = zeros(s.n);
      solve_dense(&s, expected);
      sph_solver *solver = solver_of((sph_solver_kind)kind, (sph_preconditioner)p);
      SPH_TEST_OK(context, sph_solver_set_tolerance(solver, 1e-12, 0));
      const sph_matrix matrix = matrix_of(&s);
      SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
      SPH_TEST_BELOW(distance(s.n, x, expected), 1e-9 * norm(s.n, expected));
      SPH_TEST_BELOW(true_residual(&s, x), 1.01e-12 * norm(s.n, s.b));
      free(x), free(expected), sparse_free(&s);
      sph_solver_destroy(&solver);
    }
}

/* Pressures of particles: the solution to 1e-6 of b, what is reported is true, and the rows that fix
 * their unknown are exact. */
static void water_is_solved(void) {
  const struct { int dim, nx, ny, nz; } cases[] = {{2, 40, 20, 1}, {2, 300, 8, 1}, {3, 12, 12, 12}};
  for (size_t c = 0; c < sizeof cases / sizeof cases[0]; c++) {
    sparse s = sparse_water(cases[c].dim, cases[c].nx, cases[c].ny, cases[c].nz, 0.2, 5);
    const sph_matrix matrix = matrix_of(&s);
    for (int p = 1; p <= sph_preconditioner_count(); p++) {
      double *x = zeros(s.n);
      sph_solver *solver =
          solver_of(p % 2 ? SPH_SOLVER_BICGSTAB : SPH_SOLVER_GMRES, (sph_preconditioner)p);
      for (int64_t i = 0; i < s.n; i++) x[i] = 1 + (double)(i % 3);
      SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
      const sph_solver_stats stats = stats_of(solver);
      SPH_TEST_BELOW(true_residual(&s, x), 1.0001e-6 * norm(s.n, s.b));
      SPH_TEST_CLOSE(stats.residual, true_residual(&s, x), 1e-6, 0);
      SPH_TEST_CLOSE(stats.target, 1e-6 * norm(s.n, s.b), 1e-12, 0);
      SPH_TEST_BELOW(distance(s.n, x, s.x), 1e-4 * norm(s.n, s.x));
      for (int64_t i = 0; i < s.n; i++)
        if (s.row_start[i + 1] - s.row_start[i] == 1) CU_ASSERT(x[i] == s.b[i]);
      CU_ASSERT(stats.solves == 1 && stats.iterations == stats.total_iterations);
      CU_ASSERT(stats.seconds_setup >= 0 && stats.seconds_iterations > 0);
      free(x);
      sph_solver_destroy(&solver);
    }
    sparse_free(&s);
  }
}

/* Signs, units and the size of rows do not matter. */
static void scaling_is_harmless(void) {
  sparse s = sparse_water(2, 60, 30, 1, 0.2, 3);
  const sph_matrix matrix = matrix_of(&s);
  int64_t plain[8] = {0};
  for (int variant = 0; variant < 4; variant++) {
    const double a = variant == 1 ? -1 : variant == 2 ? 1e25 : variant == 3 ? 1e-25 : 1;
    const double b = variant == 1 ? 1 : variant == 2 ? 1e60 : variant == 3 ? 1e-60 : 1;
    for (int64_t k = 0; k < s.row_start[s.n]; k++) s.values[k] *= a;
    for (int64_t i = 0; i < s.n; i++) s.b[i] *= b;
    for (int p = 1; p <= sph_preconditioner_count(); p++) {
      double *x = zeros(s.n);
      sph_solver *solver = solver_of(SPH_SOLVER_BICGSTAB, (sph_preconditioner)p);
      SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
      for (int64_t i = 0; i < s.n; i++) x[i] *= a / b;
      SPH_TEST_BELOW(distance(s.n, x, s.x), 1e-4 * norm(s.n, s.x));
      if (variant == 0) plain[p] = stats_of(solver).iterations;
      if (p == SPH_PRECONDITIONER_MULTIGRID)
        CU_ASSERT(llabs(stats_of(solver).iterations - plain[p]) <= 2);
      free(x);
      sph_solver_destroy(&solver);
    }
    for (int64_t k = 0; k < s.row_start[s.n]; k++) s.values[k] /= a;
    for (int64_t i = 0; i < s.n; i++) s.b[i] /= b;
  }
  sparse_free(&s);
}

/* A coefficient that jumps by 1000: CG, and multigrid needs few iterations. */
static void jumps_are_solved(void) {
  for (int size = 50; size <= 200; size *= 2) {
    sparse s = sparse_jump(size, size, 1000);
    const sph_matrix matrix = matrix_of(&s);
    for (int p = 1; p <= sph_preconditioner_count(); p++) {
      if (size > 50 && p != SPH_PRECONDITIONER_MULTIGRID) continue;
      double *x = zeros(s.n);
      sph_solver *solver = solver_of(SPH_SOLVER_CG, (sph_preconditioner)p);
      SPH_TEST_OK(context, sph_solver_set_tolerance(solver, 1e-8, 0));
      SPH_TEST_OK(context, sph_solver_set_limit(solver, 5000));
      SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
      SPH_TEST_BELOW(distance(s.n, x, s.x), 1e-4 * norm(s.n, s.x));
      if (p == SPH_PRECONDITIONER_MULTIGRID) CU_ASSERT(stats_of(solver).iterations <= 40);
      free(x);
      sph_solver_destroy(&solver);
    }
    sparse_free(&s);
  }
}

/* Iterations of multigrid from 2,000 to 32,000 unknowns. */
static void multigrid_scales(sph_solver_kind kind, int64_t most) {
  int64_t first = 0;
  for (int size = 32; size <= 128; size *= 2) {
    sparse s = sparse_water(2, 2 * size, size, 1, 0.2, 9);
    const sph_matrix matrix = matrix_of(&s);
    double *x = zeros(s.n);
    sph_solver *solver = solver_of(kind, SPH_PRECONDITIONER_MULTIGRID);
    SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
    const int64_t iterations = stats_of(solver).iterations;
    if (first == 0) first = iterations;
    CU_ASSERT(iterations <= most && iterations <= first + 4);
    free(x), sparse_free(&s);
    sph_solver_destroy(&solver);
  }
}

static void multigrid_scales_in_both(void) {
  multigrid_scales(SPH_SOLVER_BICGSTAB, 14);
  multigrid_scales(SPH_SOLVER_GMRES, 20); /* of half the work each */
}

/* However many iterations: generalised residuals never grow, through new starts, and are what is
 * reported; with as many directions as unknowns nothing is left. */
static void minimal_residuals_never_grow(void) {
  sparse s = sparse_water(2, 60, 30, 1, 0.2, 7), small = random_system(24, 5, false);
  const sph_matrix matrix = matrix_of(&s), smaller = matrix_of(&small);
  const int kept = 80; /* more than a cycle has */
  double *x = zeros(s.n), last = norm(s.n, s.b);
  sph_solver *solver = solver_of(SPH_SOLVER_GMRES, SPH_PRECONDITIONER_JACOBI);
  for (int limit = 1; limit <= kept; limit++) {
    memset(x, 0, (size_t)s.n * sizeof *x);
    SPH_TEST_OK(context, sph_solver_set_limit(solver, limit));
    SPH_TEST_STATUS(context, sph_solver_solve(solver, &matrix, s.b, x), SPH_E_NOT_CONVERGED,
                    "\"gmres\"");
    const double residual = true_residual(&s, x);
    SPH_TEST_BELOW(residual, last * (1 + 1e-12));
    SPH_TEST_CLOSE(stats_of(solver).residual, residual, 1e-9, 0);
    CU_ASSERT(stats_of(solver).iterations == limit);
    last = residual;
  }
  SPH_TEST_BELOW(last, 0.2 * norm(s.n, s.b));
  SPH_TEST_OK(context, sph_solver_set_preconditioner(solver, SPH_PRECONDITIONER_NONE));
  SPH_TEST_OK(context, sph_solver_set_limit(solver, 24));
  SPH_TEST_OK(context, sph_solver_set_tolerance(solver, 1e-12, 0));
  memset(x, 0, (size_t)s.n * sizeof *x);
  SPH_TEST_OK(context, sph_solver_solve(solver, &smaller, small.b, x));
  free(x), sparse_free(&s), sparse_free(&small);
  sph_solver_destroy(&solver);
}

/* From the solution nothing is done, from near it less than from afar. */
static void warm_starts_pay(void) {
  sparse s = sparse_water(2, 80, 40, 1, 0.2, 2);
  const sph_matrix matrix = matrix_of(&s);
  double *x = zeros(s.n);
  sph_solver *solver = solver_of(SPH_SOLVER_BICGSTAB, SPH_PRECONDITIONER_MULTIGRID);
  SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
  const int64_t cold = stats_of(solver).iterations;
  SPH_TEST_CLOSE(stats_of(solver).initial_residual, norm(s.n, s.b), 1e-12, 0);
  const double before = x[77];
  SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
  CU_ASSERT(stats_of(solver).iterations == 0 && x[77] == before);
  for (int64_t i = 0; i < s.n; i++) x[i] = s.x[i] * (1 + 0.01 * cos(9 * s.place[3 * i]));
  SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
  CU_ASSERT(stats_of(solver).iterations < cold);
  SPH_TEST_OK(context, sph_solver_set_tolerance(solver, 0, 1e3 * norm(s.n, s.b)));
  memset(x, 0, (size_t)s.n * sizeof *x);
  SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
  CU_ASSERT(stats_of(solver).iterations == 0 && stats_of(solver).solves == 4);
  free(x), sparse_free(&s);
  sph_solver_destroy(&solver);
}

/* A kept preconditioner is made anew when its time is over, when it is of no use, or for another n. */
static void preconditioners_are_kept(void) {
  sparse s = sparse_water(2, 60, 30, 1, 0.2, 2), other = sparse_water(2, 40, 20, 1, 0.2, 2);
  sparse jump = sparse_jump(60, 30, 1000);
  const sph_matrix matrix = matrix_of(&s), smaller = matrix_of(&other), strange = matrix_of(&jump);
  for (int p = SPH_PRECONDITIONER_ILU0; p <= sph_preconditioner_count(); p++) {
    double *x = zeros(s.n);
    sph_solver *solver = solver_of(SPH_SOLVER_BICGSTAB, (sph_preconditioner)p);
    SPH_TEST_OK(context, sph_solver_set_reuse(solver, 3));
    for (int n = 1; n <= 9; n++) {
      memset(x, 0, (size_t)s.n * sizeof *x);
      SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
      SPH_TEST_BELOW(distance(s.n, x, s.x), 1e-4 * norm(s.n, s.x));
      CU_ASSERT(stats_of(solver).setups == (n + 3) / 4);
    }
    memset(x, 0, (size_t)s.n * sizeof *x);
    SPH_TEST_OK(context, sph_solver_solve(solver, &smaller, other.b, x));
    CU_ASSERT(stats_of(solver).setups == 4);
    SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
    CU_ASSERT(stats_of(solver).setups == 5);
    memset(x, 0, (size_t)s.n * sizeof *x);
    SPH_TEST_OK(context, sph_solver_set_limit(solver, 5000));
    SPH_TEST_OK(context, sph_solver_solve(solver, &strange, jump.b, x));
    SPH_TEST_OK(context, sph_solver_solve(solver, &strange, jump.b, x));
    SPH_TEST_OK(context, sph_solver_set_reuse(solver, 0));
    SPH_TEST_OK(context, sph_solver_solve(solver, &strange, jump.b, x));
    SPH_TEST_BELOW(true_residual(&jump, x), 1.0001e-6 * norm(jump.n, jump.b));
    free(x);
    sph_solver_destroy(&solver);
  }
  sparse_free(&s), sparse_free(&other), sparse_free(&jump);
}

/* Pure Neumann: rows that sum to zero, the mean of x is zero and A x = b - c. */
static void null_space_is_projected(void) {
  FOR_METHODS(kind) {
    sparse s = kind == SPH_SOLVER_CG ? sparse_jump(60, 40, 10) : sparse_water(2, 60, 30, 1, 0.2, 4);
    double *x = zeros(s.n), *y = zeros(s.n);
    uint64_t seed = 3;
    for (int64_t i = 0; i < s.n; i++) { /* the diagonal is in front */
      double sum = 0;
      for (int64_t k = s.row_start[i] + 1; k < s.row_start[i + 1]; k++) sum += s.values[k];
      s.values[s.row_start[i]] = s.row_start[i + 1] - s.row_start[i] > 1 ? -sum : 1;
      s.b[i] = s.row_start[i + 1] - s.row_start[i] > 1 ? sparse_random(&seed) - 0.2 : 7;
    }
    /* Water that nothing holds: entries towards the surface are taken out. */
    for (int64_t i = 0; i < s.n; i++)
      for (int64_t k = s.row_start[i] + 1; k < s.row_start[i + 1]; k++) {
        const int64_t j = s.columns[k];
        if (s.row_start[j + 1] - s.row_start[j] > 1) continue;
        s.values[s.row_start[i]] += s.values[k];
        s.values[k] = 0;
      }
    const sph_matrix matrix = matrix_of(&s);
    for (int p = 1; p <= sph_preconditioner_count(); p++) {
      sph_solver *solver = solver_of((sph_solver_kind)kind, (sph_preconditioner)p);
      SPH_TEST_OK(context, sph_solver_set_null_space(solver, true));
      SPH_TEST_OK(context, sph_solver_set_tolerance(solver, 1e-8, 0));
      for (int64_t i = 0; i < s.n; i++) x[i] = 5;
      SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s.b, x));
      double sum = 0, least = INFINITY, most = -INFINITY;
      int64_t free_rows = 0;
      sparse_multiply(&s, x, y);
      for (int64_t i = 0; i < s.n; i++) {
        if (s.row_start[i + 1] - s.row_start[i] == 1) {
          CU_ASSERT(x[i] == 7);
          continue;
        }
        free_rows++;
        sum += x[i];
        least = fmin(least, s.b[i] - y[i]);
        most = fmax(most, s.b[i] - y[i]);
      }
      SPH_TEST_CLOSE(sum / (double)free_rows, 0, 0, 1e-10 * norm(s.n, x));
      SPH_TEST_BELOW(most - least, 1e-6);
      if (kind == SPH_SOLVER_CG) SPH_TEST_CLOSE(most, 0.3, 0, 0.02); /* the mean of b */
      sph_solver_destroy(&solver);
    }
    free(x), free(y), sparse_free(&s);
  }
}

/* The same bits with one and more threads, blocks or not. */
static void threads_agree(void) {
  sparse s = sparse_water(2, 100, 50, 1, 0.2, 6), jump = sparse_jump(70, 70, 1000);
  const int threads[] = {1, 2, 3};
  for (int p = 1; p <= sph_preconditioner_count(); p++) FOR_METHODS(kind)
  for (int null_space = 0; null_space < 2; null_space++) {
    const sparse *system = kind == SPH_SOLVER_CG ? &jump : &s;
    const sph_matrix matrix = matrix_of(system);
    double *x[3];
    for (int t = 0; t < 3; t++) {
      x[t] = zeros(system->n);
      /* A build without OpenMP has one thread; it compares one with one. */
      if (sph_context_set_threads(context, threads[t]) != SPH_OK)
        SPH_TEST_OK(context, sph_context_set_threads(context, 1));
      sph_solver *solver = solver_of((sph_solver_kind)kind, (sph_preconditioner)p);
      SPH_TEST_OK(context, sph_solver_set_null_space(solver, null_space != 0));
      SPH_TEST_OK(context, sph_solver_set_limit(solver, 6));
      const sph_status status = sph_solver_solve(solver, &matrix, system->b, x[t]);
      CU_ASSERT(status == SPH_OK || status == SPH_E_NOT_CONVERGED);
      sph_solver_destroy(&solver);
    }
    CU_ASSERT(memcmp(x[0], x[1], (size_t)system->n * sizeof *x[0]) == 0);
    CU_ASSERT(memcmp(x[0], x[2], (size_t)system->n * sizeof *x[0]) == 0);
    for (int t = 0; t < 3; t++) free(x[t]);
  }
  SPH_TEST_OK(context, sph_context_set_threads(context, 1));
  sparse_free(&s), sparse_free(&jump);
}

/* PETSc, where the library has it, solves the same systems; where not, it says so. */
static void petsc_solves(void) {
  sparse systems[] = {sparse_water(2, 60, 30, 1, 0.2, 5), sparse_jump(40, 40, 1000)};
  sph_solver *solver = NULL;
  const sph_status status = sph_solver_create(context, SPH_SOLVER_PETSC, &solver);
  if (status == SPH_OK) sph_solver_destroy(&solver);
  if (status != SPH_OK)
    SPH_TEST_STATUS(context, sph_solver_create(context, SPH_SOLVER_PETSC, &solver),
                    SPH_E_UNAVAILABLE, "PETSC=1");
  for (int p = 1; p <= sph_preconditioner_count() && status == SPH_OK; p++)
    for (int c = 0; c < 2; c++) {
      if (c == 1 && p == SPH_PRECONDITIONER_NONE) continue; /* thousands of iterations */
      const sparse *s = &systems[c];
      const sph_matrix matrix = matrix_of(s);
      double *x = zeros(s->n);
      solver = solver_of(SPH_SOLVER_PETSC, (sph_preconditioner)p);
      SPH_TEST_OK(context, sph_solver_set_tolerance(solver, 1e-8, 0));
      SPH_TEST_OK(context, sph_solver_set_reuse(solver, 1));
      for (int n = 1; n <= 4; n++) {
        memset(x, 0, (size_t)s->n * sizeof *x);
        SPH_TEST_OK(context, sph_solver_solve(solver, &matrix, s->b, x));
        SPH_TEST_BELOW(true_residual(s, x), 1.0001e-8 * norm(s->n, s->b));
        CU_ASSERT(stats_of(solver).iterations > 0 && stats_of(solver).setups == (n + 1) / 2);
      }
      SPH_TEST_OK(context, sph_solver_set_limit(solver, 1));
      memset(x, 0, (size_t)s->n * sizeof *x);
      SPH_TEST_STATUS(context, sph_solver_solve(solver, &matrix, s->b, x), SPH_E_NOT_CONVERGED,
                      "1 of at most 1 iterations");
      SPH_TEST_BELOW(true_residual(s, x), 1.0000001 * norm(s->n, s->b));
      free(x);
      sph_solver_destroy(&solver);
    }
  sparse_free(&systems[0]), sparse_free(&systems[1]);
}

SPH_TEST_MAIN("solver", {"context opens", context_opens},
              {"every method and preconditioner agrees with elimination", dense_agrees},
              {"pressures of particles are found", water_is_solved},
              {"signs, units and sizes do not matter", scaling_is_harmless},
              {"conjugate gradients solve jumps of 1000", jumps_are_solved},
              {"multigrid needs as many iterations at 32,000 unknowns as at 2,000",
               multigrid_scales_in_both},
              {"minimal residuals never grow", minimal_residuals_never_grow},
              {"warm starts pay", warm_starts_pay},
              {"preconditioners are kept as long as asked for", preconditioners_are_kept},
              {"a constant null space is projected out", null_space_is_projected},
              {"any number of threads gives the same bits", threads_agree},
              {"PETSc solves the same systems, if it is there", petsc_solves},
              {"context closes", context_closes})
