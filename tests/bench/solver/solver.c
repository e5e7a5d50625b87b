/* Measures the solvers and prints the tables of docs/solver.md.
 *
 *   solver [--quick]      8,000 unknowns alone
 *
 * Pressures of particles (tests/solver_world.h) are solved from a field that is wrong by 1 %, once as a
 * smooth wave and once at random, to 1e-6 of ||b||. Numbers of threads take turns; the times are the
 * least of all runs: what the machine does where nobody disturbs it.
 */
#include <stdio.h>

#include "../../solver_world.h"

typedef struct row {
  sph_solver_kind kind;
  sph_preconditioner preconditioner;
  bool kept; /* the preconditioner is that of the particles a tenth of a spacing ago */
} row;

typedef struct timing {
  double setup, iterations;
} timing;

static void fail(const sph_context *context, const char *what) {
  fprintf(stderr, "solver: %s: %s\n", what, sph_context_message(context));
  exit(1);
}

/* 1 % off: along a wave, or each unknown by itself. */
static void guess(const sparse *s, bool random, double *x) {
  uint64_t seed = 3;
  for (int64_t i = 0; i < s->n; i++) {
    const double wave = cos(9 * s->place[3 * i]) * cos(4 * s->place[3 * i + 1]);
    x[i] = s->x[i] * (1 + 0.01 * (random ? 2 * sparse_random(&seed) - 1 : wave));
  }
}

static sph_solver *solver_of(sph_context *context, const row *r, const sparse *before, double *x) {
  sph_solver *solver = NULL;
  if (sph_solver_create(context, r->kind, &solver) != SPH_OK ||
      sph_solver_set_preconditioner(solver, r->preconditioner) != SPH_OK ||
      sph_solver_set_limit(solver, 10000) != SPH_OK)
    fail(context, "solver");
  if (!r->kept) return solver;
  const sph_matrix matrix = matrix_of(before);
  guess(before, false, x);
  if (sph_solver_set_reuse(solver, 1000000) != SPH_OK ||
      sph_solver_solve(solver, &matrix, before->b, x) != SPH_OK)
    fail(context, "before");
  return solver;
}

static void measure(const row *r, const sparse *s, const sparse *before, const char *name,
                    int runs) {
  double *x = calloc((size_t)s->n, sizeof *x);
  timing times[2] = {{INFINITY, INFINITY}, {INFINITY, INFINITY}};
  sph_context *contexts[2] = {NULL, NULL};
  sph_solver *solvers[2] = {NULL, NULL};
  sph_solver_stats stats = {0};
  const int counts = sph_processor_count() > 1 ? 2 : 1;
  const sph_matrix matrix = matrix_of(s);
  if (!x) exit(1);
  for (int t = 0; t < counts; t++) {
    if (sph_context_create(&contexts[t]) != SPH_OK ||
        sph_context_set_threads(contexts[t], t + 1) != SPH_OK)
      fail(contexts[t], "context");
    solvers[t] = solver_of(contexts[t], r, before, x);
  }
  for (int n = -1; n < runs; n++) /* the first run finds the memory */
    for (int t = 0; t < counts; t++) {
      guess(s, false, x);
      if (sph_solver_solve(solvers[t], &matrix, s->b, x) != SPH_OK ||
          sph_solver_get_stats(solvers[t], &stats) != SPH_OK)
        fail(contexts[t], name);
      if (n < 0) continue;
      times[t].setup = fmin(times[t].setup, 1e3 * stats.seconds_setup);
      times[t].iterations = fmin(times[t].iterations, 1e3 * stats.seconds_iterations);
    }
  const int64_t smooth_iterations = stats.iterations;
  guess(s, true, x);
  if (sph_solver_solve(solvers[0], &matrix, s->b, x) != SPH_OK ||
      sph_solver_get_stats(solvers[0], &stats) != SPH_OK)
    fail(contexts[0], name);
  const int64_t random_iterations = stats.iterations;
  printf("| %s | %s, %s%s | %lld | %lld |", name, sph_solver_kind_name(r->kind),
         sph_preconditioner_name(r->preconditioner), r->kept ? " kept" : "",
         (long long)smooth_iterations, (long long)random_iterations);
  for (int t = 0; t < counts; t++)
    printf(" %.2f + %.2f = %.2f |", times[t].setup, times[t].iterations,
           times[t].setup + times[t].iterations);
  printf("\n");
  fflush(stdout);
  for (int t = 0; t < counts; t++) {
    sph_solver_destroy(&solvers[t]);
    sph_context_destroy(&contexts[t]);
  }
  free(x);
}

static bool has_petsc(void) {
  sph_context *context = NULL;
  sph_solver *solver = NULL;
  const bool has = sph_context_create(&context) == SPH_OK &&
                   sph_solver_create(context, SPH_SOLVER_PETSC, &solver) == SPH_OK;
  sph_solver_destroy(&solver);
  sph_context_destroy(&context);
  return has;
}

static void measure_all(const char *name, const sparse *s, const sparse *before, bool symmetric,
                        bool large) {
  const row rows[] = {{SPH_SOLVER_BICGSTAB, SPH_PRECONDITIONER_JACOBI, false},
                      {SPH_SOLVER_BICGSTAB, SPH_PRECONDITIONER_ILU0, false},
                      {SPH_SOLVER_BICGSTAB, SPH_PRECONDITIONER_MULTIGRID, false},
                      {SPH_SOLVER_BICGSTAB, SPH_PRECONDITIONER_MULTIGRID, true},
                      {SPH_SOLVER_GMRES, SPH_PRECONDITIONER_MULTIGRID, false},
                      {SPH_SOLVER_GMRES, SPH_PRECONDITIONER_MULTIGRID, true},
                      {SPH_SOLVER_CG, SPH_PRECONDITIONER_MULTIGRID, false},
                      {SPH_SOLVER_PETSC, SPH_PRECONDITIONER_ILU0, false},
                      {SPH_SOLVER_PETSC, SPH_PRECONDITIONER_MULTIGRID, false}};
  const bool petsc = has_petsc();
  char title[80];
  snprintf(title, sizeof title, "%s, %lld rows of %.0f", name, (long long)s->n,
           (double)s->row_start[s->n] / (double)s->n);
  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
    if (rows[k].kept && symmetric) continue;
    if (rows[k].kind == SPH_SOLVER_CG && !symmetric) continue;
    if (rows[k].kind == SPH_SOLVER_PETSC && !petsc) continue;
    const bool slow = rows[k].preconditioner != SPH_PRECONDITIONER_MULTIGRID;
    measure(&rows[k], s, before, title, !large ? 25 : slow ? 1 : 5);
  }
}

int main(int count, char **arguments) {
  const bool quick = count > 1 && strcmp(arguments[1], "--quick") == 0;
  if (count > 1 && !quick) {
    fprintf(stderr, "usage: %s [--quick]\n", arguments[0]);
    return 2;
  }
  const struct {
    const char *name;
    int dim, small[3], large[3];
  } waters[] = {{"dam 2:1", 2, {126, 63, 1}, {632, 316, 1}},
                {"flume 40:1", 2, {566, 14, 1}, {2828, 71, 1}},
                {"block 3D", 3, {20, 20, 20}, {58, 58, 58}}};
  printf(
      "| system | solver | iterations, smooth error | random error | 1 thread: set-up + "
      "iterations [ms] | 2 threads |\n|---|---|---|---|---|---|\n");
  for (int large = 0; large < (quick ? 1 : 2); large++) {
    for (size_t c = 0; c < sizeof waters / sizeof waters[0]; c++) {
      const int *size = large ? waters[c].large : waters[c].small;
      /* Both with the same random numbers: particles have moved by up to a tenth of their spacing. */
      sparse before = sparse_water(waters[c].dim, size[0], size[1], size[2], 0.1, 7);
      sparse now = sparse_water(waters[c].dim, size[0], size[1], size[2], 0.2, 7);
      measure_all(waters[c].name, &now, &before, false, large != 0);
      sparse_free(&before), sparse_free(&now);
    }
    const int side = large ? 447 : 90;
    sparse jump = sparse_jump(side, side, 1000);
    measure_all("jump 1000:1", &jump, NULL, true, large != 0);
    sparse_free(&jump);
  }
  return 0;
}
