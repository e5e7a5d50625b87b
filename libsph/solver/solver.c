/* Solvers as handles: names, settings, checks of the system, and the frame of a solve. */
#include "solver/solver_list.h"

#define SOLVER_AGREES(id, enumerator, stem)             \
  _Static_assert(SPH_SOLVER_##enumerator == (id),       \
                 "solver.h and solver_list.h disagree " \
                 "on " #stem);
SPHI_SOLVER_LIST(SOLVER_AGREES)
#undef SOLVER_AGREES
#define PRECONDITIONER_AGREES(id, enumerator, stem)       \
  _Static_assert(SPH_PRECONDITIONER_##enumerator == (id), \
                 "solver.h and solver_list.h disagree on " #stem);
SPHI_PRECONDITIONER_LIST(PRECONDITIONER_AGREES)
#undef PRECONDITIONER_AGREES

#define SOLVER_ROW(id, enumerator, stem) &sphi_solver_##stem,
static const sphi_solver_method *const methods[] = {SPHI_SOLVER_LIST(SOLVER_ROW)};
#undef SOLVER_ROW
#define PRECONDITIONER_ROW(id, enumerator, stem) &sphi_preconditioner_##stem,
static const sphi_preconditioner *const preconditioners[] = {
    SPHI_PRECONDITIONER_LIST(PRECONDITIONER_ROW)};
#undef PRECONDITIONER_ROW
enum {
  METHODS = sizeof methods / sizeof methods[0],
  PRECONDITIONERS = sizeof preconditioners / sizeof preconditioners[0],
  /* Runs of a method that may follow each other without a smaller residual. */
  IDLE_RUNS = 2
};

static bool known_method(int kind) { return kind >= 1 && kind <= METHODS; }
static bool known_preconditioner(int kind) { return kind >= 1 && kind <= PRECONDITIONERS; }

int sph_solver_count(void) { return METHODS; }

const char *sph_solver_kind_name(sph_solver_kind kind) {
  return known_method((int)kind) ? methods[(int)kind - 1]->name : "unknown";
}

const char *sph_solver_kind_summary(sph_solver_kind kind) {
  return known_method((int)kind) ? methods[(int)kind - 1]->summary : "unknown";
}

int sph_preconditioner_count(void) { return PRECONDITIONERS; }

const char *sph_preconditioner_name(sph_preconditioner kind) {
  return known_preconditioner((int)kind) ? preconditioners[(int)kind - 1]->name : "unknown";
}

const char *sph_preconditioner_summary(sph_preconditioner kind) {
  return known_preconditioner((int)kind) ? preconditioners[(int)kind - 1]->summary : "unknown";
}

/* The number from 1 on of `name`. */
static sph_status find(sph_context *context, const char *what, const char *name, int count,
                       const char *const names[], int *number) {
  for (int k = 0; k < count; k++) {
    if (strcmp(name, names[k]) != 0) continue;
    *number = k + 1;
    return SPH_OK;
  }
  const char *nearest = sphi_nearest_name(name, count, names);
  SPH_CHECK(context, nearest, SPH_E_NAME, "unknown %s \"%.100s\"; one is \"%s\"", what, name,
            names[0]);
  return SPHI_ERROR(context, SPH_E_NAME, "unknown %s \"%.100s\"; did you mean \"%s\"?", what, name,
                    nearest);
}

sph_status sph_solver_find(sph_context *context, const char *name, sph_solver_kind *kind) {
  SPH_CHECK(context, context && name && kind, SPH_E_ARGUMENT,
            "solver: context, name and kind must not be NULL");
  const char *names[METHODS];
  int number = 0;
  for (int k = 0; k < METHODS; k++) names[k] = methods[k]->name;
  SPH_TRY(find(context, "solver", name, METHODS, names, &number));
  *kind = (sph_solver_kind)number;
  return SPH_OK;
}

sph_status sph_preconditioner_find(sph_context *context, const char *name,
                                   sph_preconditioner *preconditioner) {
  SPH_CHECK(context, context && name && preconditioner, SPH_E_ARGUMENT,
            "solver: context, name and preconditioner must not be NULL");
  const char *names[PRECONDITIONERS];
  int number = 0;
  for (int k = 0; k < PRECONDITIONERS; k++) names[k] = preconditioners[k]->name;
  SPH_TRY(find(context, "preconditioner", name, PRECONDITIONERS, names, &number));
  *preconditioner = (sph_preconditioner)number;
  return SPH_OK;
}

sph_status sph_solver_create(sph_context *context, sph_solver_kind kind, sph_solver **out) {
  if (out) *out = NULL;
  SPH_CHECK(context, context && out, SPH_E_ARGUMENT, "solver: context and out must not be NULL");
  SPH_CHECK(context, known_method((int)kind), SPH_E_ARGUMENT,
            "solver: kind must be one of sph_solver_kind, 1 to %d, got %d", METHODS, (int)kind);
  const sphi_solver_method *method = methods[(int)kind - 1];
  SPH_CHECK(context, method->available, SPH_E_UNAVAILABLE,
            "solver \"%s\": the library was built without it; make configure PETSC=1",
            method->name);
  sph_solver *solver = SPHI_NEW(context, 1, sph_solver);
  SPH_CHECK(context, solver, SPH_E_MEMORY, "solver \"%s\": out of memory", method->name);
  solver->context = context;
  sphi_context_retain(context);
  solver->method = method;
  solver->preconditioner = &sphi_preconditioner_multigrid;
  solver->relative = 1e-6;
  solver->limit = 1000;
  *out = solver;
  return SPH_OK;
}

/* The preconditioner kept, with its memory. */
static void forget(sph_solver *solver) {
  if (solver->made) solver->made->release(solver);
  solver->made = NULL;
  solver->uses_left = 0;
}

static void release_vectors(sph_solver *solver) {
  sph_context *context = solver->context;
  for (int v = 0; v < SPHI_SOLVER_VECTORS; v++) {
    sphi_free(context, solver->vectors[v]);
    solver->vectors[v] = NULL;
  }
  sphi_free(context, solver->inverse_diagonal);
  sphi_free(context, solver->largest_beside);
  sphi_free(context, solver->fixed);
  solver->inverse_diagonal = NULL;
  solver->largest_beside = NULL;
  solver->fixed = NULL;
  solver->capacity = 0;
}

void sph_solver_destroy(sph_solver **solver) {
  if (!solver || !*solver) return;
  sph_solver *dead = *solver;
  *solver = NULL;
  sph_context *context = dead->context;
  forget(dead);
  if (dead->method->release) dead->method->release(dead);
  release_vectors(dead);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sph_solver_set_preconditioner(sph_solver *solver, sph_preconditioner preconditioner) {
  if (!solver) return SPH_E_ARGUMENT;
  SPH_CHECK(solver->context, known_preconditioner((int)preconditioner), SPH_E_ARGUMENT,
            "solver \"%s\": preconditioner must be one of sph_preconditioner, 1 to %d, got %d",
            solver->method->name, PRECONDITIONERS, (int)preconditioner);
  if (solver->preconditioner != preconditioners[(int)preconditioner - 1]) forget(solver);
  solver->preconditioner = preconditioners[(int)preconditioner - 1];
  return SPH_OK;
}

sph_status sph_solver_set_tolerance(sph_solver *solver, double relative, double absolute) {
  if (!solver) return SPH_E_ARGUMENT;
  SPH_CHECK(solver->context, relative >= 0 && relative <= 1, SPH_E_ARGUMENT,
            "solver \"%s\": relative tolerance must be 0 to 1, got %g", solver->method->name,
            relative);
  SPH_CHECK(solver->context, isfinite(absolute) && absolute >= 0, SPH_E_ARGUMENT,
            "solver \"%s\": absolute tolerance must be >= 0, got %g", solver->method->name,
            absolute);
  SPH_CHECK(solver->context, relative > 0 || absolute > 0, SPH_E_ARGUMENT,
            "solver \"%s\": one of the two tolerances must be > 0", solver->method->name);
  solver->relative = relative;
  solver->absolute = absolute;
  return SPH_OK;
}

sph_status sph_solver_set_limit(sph_solver *solver, int iterations) {
  if (!solver) return SPH_E_ARGUMENT;
  SPH_CHECK(solver->context, iterations >= 0, SPH_E_ARGUMENT,
            "solver \"%s\": limit of iterations must be >= 0, got %d", solver->method->name,
            iterations);
  solver->limit = iterations;
  return SPH_OK;
}

sph_status sph_solver_set_null_space(sph_solver *solver, bool constant) {
  if (!solver) return SPH_E_ARGUMENT;
  solver->null_space = constant;
  return SPH_OK;
}

sph_status sph_solver_set_reuse(sph_solver *solver, int solves) {
  if (!solver) return SPH_E_ARGUMENT;
  SPH_CHECK(solver->context, solves >= 0, SPH_E_ARGUMENT,
            "solver \"%s\": solves that keep a preconditioner must be >= 0, got %d",
            solver->method->name, solves);
  solver->reuse = solves;
  if (solver->uses_left > solves) solver->uses_left = solves;
  return SPH_OK;
}

sph_status sph_solver_get_stats(const sph_solver *solver, sph_solver_stats *stats) {
  if (!solver) return SPH_E_ARGUMENT;
  SPH_CHECK(solver->context, stats, SPH_E_ARGUMENT, "solver \"%s\": stats must not be NULL",
            solver->method->name);
  *stats = solver->stats;
  return SPH_OK;
}

/* ---- the system ---- */

/* What is wrong with a row. */
typedef enum fault {
  SOUND,
  RANGE_OF_COLUMN,
  NOT_FINITE,
  NO_DIAGONAL,
  ZERO_DIAGONAL,
  B_NOT_FINITE,
  X_NOT_FINITE
} fault;

/* Looks at row i; adds up its diagonal and finds the size of the largest entry beside it. Sizes are
 * compared as the numbers that their bits are, among which those of infinity and NaN are the largest. */
static fault look_at_row(const sph_matrix *matrix, int64_t i, double *diagonal, double *largest) {
  const uint64_t sign = 1ull << 63;
  double d = 0;
  bool has_diagonal = false;
  uint64_t most = 0;
  uint32_t last = 0; /* of the columns, where negative ones are beyond all others */
  for (int64_t k = matrix->row_start[i]; k < matrix->row_start[i + 1]; k++) {
    const int32_t column = matrix->columns[k];
    uint64_t bits;
    memcpy(&bits, &matrix->values[k], sizeof bits);
    bits &= ~sign;
    if ((uint32_t)column > last) last = (uint32_t)column;
    if (column == i) {
      d += matrix->values[k];
      has_diagonal = true;
    } else if (bits > most)
      most = bits;
  }
  *diagonal = d;
  memcpy(largest, &most, sizeof most);
  if (last >= (uint32_t)matrix->n) return RANGE_OF_COLUMN;
  if (!isfinite(*largest) || !isfinite(d)) return NOT_FINITE;
  if (!has_diagonal) return NO_DIAGONAL;
  return d == 0 || !isfinite(1 / d) ? ZERO_DIAGONAL : SOUND;
}

/* Rows of block k: diagonals, and the rows that fix their unknown. The first fault, and its row. */
static fault look_at_block(sph_solver *solver, int k, const double *x, int64_t *row,
                           double *largest) {
  int32_t *fixed = solver->fixed + sphi_block_first(&solver->blocks, k), count = 0;
  *largest = 0;
  for (int64_t i = sphi_block_first(&solver->blocks, k); i < sphi_block_end(&solver->blocks, k);
       i++) {
    double diagonal, beside;
    fault found = look_at_row(&solver->matrix, i, &diagonal, &beside);
    if (found == SOUND && !isfinite(solver->b[i])) found = B_NOT_FINITE;
    if (found == SOUND && !isfinite(x[i])) found = X_NOT_FINITE;
    if (found != SOUND) {
      *row = i;
      return found;
    }
    solver->inverse_diagonal[i] = 1 / diagonal;
    solver->largest_beside[i] = beside;
    if (beside == 0) fixed[count++] = (int32_t)i;
    if (fabs(diagonal) > *largest) *largest = fabs(diagonal);
  }
  solver->fixed_count[k] = count;
  return SOUND;
}

static sph_status complain(const sph_solver *solver, fault found, int64_t row, const double *x) {
  sph_context *context = solver->context;
  const sph_matrix *matrix = &solver->matrix;
  const char *name = solver->method->name;
  const long long i = row;
  int64_t k = matrix->row_start[row];
  switch (found) {
    case RANGE_OF_COLUMN:
      while (matrix->columns[k] >= 0 && matrix->columns[k] < matrix->n) k++;
      return SPHI_ERROR(context, SPH_E_ARGUMENT,
                        "solver \"%s\": row %lld has column %d, not 0 to %lld", name, i,
                        matrix->columns[k], (long long)matrix->n - 1);
    case NOT_FINITE:
      return SPHI_ERROR(context, SPH_E_ARGUMENT,
                        "solver \"%s\": row %lld has a value that is not finite", name, i);
    case NO_DIAGONAL:
      return SPHI_ERROR(context, SPH_E_ARGUMENT, "solver \"%s\": row %lld has no diagonal", name,
                        i);
    case ZERO_DIAGONAL:
      return SPHI_ERROR(context, SPH_E_ARGUMENT,
                        "solver \"%s\": row %lld has a diagonal that is zero", name, i);
    case B_NOT_FINITE:
      return SPHI_ERROR(context, SPH_E_ARGUMENT,
                        "solver \"%s\": b of row %lld must be finite, got %g", name, i,
                        solver->b[row]);
    case X_NOT_FINITE:
      return SPHI_ERROR(context, SPH_E_ARGUMENT,
                        "solver \"%s\": x of row %lld must be finite, got %g", name, i, x[row]);
    case SOUND: break;
  }
  return SPH_OK;
}

static sph_status look_at_system(sph_solver *solver, const double *x) {
  const sphi_blocks *blocks = &solver->blocks;
  fault found[SPHI_SOLVER_MAX_BLOCKS];
  int64_t row[SPHI_SOLVER_MAX_BLOCKS];
  double largest[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    found[k] = look_at_block(solver, k, x, &row[k], &largest[k]);
  solver->free_rows = blocks->n;
  solver->largest_diagonal = 0;
  for (int k = 0; k < blocks->count; k++) {
    if (found[k] != SOUND) return complain(solver, found[k], row[k], x);
    solver->free_rows -= solver->fixed_count[k];
    if (largest[k] > solver->largest_diagonal) solver->largest_diagonal = largest[k];
  }
  return SPH_OK;
}

static sph_status look_at_arguments(sph_solver *solver, const sph_matrix *matrix, const double *b,
                                    const double *x) {
  sph_context *context = solver->context;
  const char *name = solver->method->name;
  SPH_CHECK(context, matrix && b && x, SPH_E_ARGUMENT,
            "solver \"%s\": matrix, b and x must not be NULL", name);
  SPH_CHECK(context, matrix->n >= 1 && matrix->n <= INT32_MAX, SPH_E_ARGUMENT,
            "solver \"%s\": rows must be 1 to 2^31 - 1, got %lld", name, (long long)matrix->n);
  SPH_CHECK(context, matrix->row_start && matrix->columns && matrix->values, SPH_E_ARGUMENT,
            "solver \"%s\": the arrays of the matrix must not be NULL", name);
  SPH_CHECK(context, matrix->row_start[0] >= 0, SPH_E_ARGUMENT,
            "solver \"%s\": row 0 must not start before 0, got %lld", name,
            (long long)matrix->row_start[0]);
  for (int64_t i = 0; i < matrix->n; i++)
    SPH_CHECK(context, matrix->row_start[i + 1] >= matrix->row_start[i], SPH_E_ARGUMENT,
              "solver \"%s\": row %lld starts at %lld and ends before, at %lld", name, (long long)i,
              (long long)matrix->row_start[i], (long long)matrix->row_start[i + 1]);
  return SPH_OK;
}

static sph_status make_vectors(sph_solver *solver, int64_t n) {
  if (n <= solver->capacity) return SPH_OK;
  sph_context *context = solver->context;
  release_vectors(solver);
  bool complete = true;
  for (int v = 0; v < SPHI_SOLVER_VECTORS && complete; v++) {
    solver->vectors[v] = SPHI_NEW(context, n, double);
    complete = solver->vectors[v] != NULL;
  }
  if (complete) solver->inverse_diagonal = SPHI_NEW(context, n, double);
  if (solver->inverse_diagonal) solver->largest_beside = SPHI_NEW(context, n, double);
  if (solver->largest_beside) solver->fixed = SPHI_NEW(context, n, int32_t);
  if (!solver->fixed) {
    release_vectors(solver);
    return SPHI_ERROR(context, SPH_E_MEMORY, "solver \"%s\": out of memory for %lld rows",
                      solver->method->name, (long long)n);
  }
  solver->capacity = n;
  return SPH_OK;
}

void sphi_solver_renumbered(sph_solver *solver) { solver->uses_left = 0; }

/* ---- a solve ---- */

/* Makes the preconditioner, or keeps the one there is. */
static sph_status make_preconditioner(sph_solver *solver) {
  solver->kept = solver->uses_left > 0 && solver->made_rows == solver->matrix.n;
  sph_status status = SPH_OK;
  if (solver->method->setup)
    status = solver->method->setup(solver);
  else if (!solver->kept) {
    solver->made = solver->preconditioner;
    status = solver->preconditioner->setup(solver);
  }
  if (status != SPH_OK) {
    forget(solver);
    return status;
  }
  if (solver->kept) {
    solver->uses_left--;
    return SPH_OK;
  }
  solver->made_rows = solver->matrix.n;
  solver->uses_left = solver->reuse;
  solver->first_iterations = -1;
  solver->stats.setups++;
  return SPH_OK;
}

/* Unknowns that their row fixes. The residual of these rows is zero then, and stays so. */
static void set_fixed(const sph_solver *solver, double *x) {
  for (int k = 0; k < solver->blocks.count; k++) {
    const int32_t *fixed = solver->fixed + sphi_block_first(&solver->blocks, k);
    for (int32_t f = 0; f < solver->fixed_count[k]; f++)
      x[fixed[f]] = solver->b[fixed[f]] * solver->inverse_diagonal[fixed[f]];
  }
}

/* ||b||, without its mean where the null space is asked for. */
static double norm_of_b(const sph_solver *solver) {
  if (!solver->null_space) return sqrt(sphi_solver_dot(solver, solver->b, solver->b));
  double *copy = solver->vectors[SPHI_VECTOR_R];
  memcpy(copy, solver->b, (size_t)solver->matrix.n * sizeof *copy);
  sphi_solver_project(solver, copy);
  return sqrt(sphi_solver_dot(solver, copy, copy));
}

/* Runs the method until the residual, computed anew from x, is below the target. A preconditioner that
 * was kept gets twice the iterations of its first solve. */
static sph_status run(sph_solver *solver, double *x) {
  const size_t bytes = (size_t)solver->matrix.n * sizeof(double);
  double *r = solver->vectors[SPHI_VECTOR_R], *start = solver->vectors[SPHI_VECTOR_START];
  sph_solver_stats *stats = &solver->stats;
  int idle = 0;
  solver->pause = solver->limit;
  if (solver->kept && 2 * solver->first_iterations + 10 < solver->limit)
    solver->pause = 2 * solver->first_iterations + 10;
  while (solver->r_norm > solver->target && stats->iterations < solver->limit && idle < IDLE_RUNS) {
    const double before = solver->r_norm;
    solver->scale = 1 / before;
    memcpy(start, x, bytes);
    SPH_TRY(solver->method->iterate(solver, x));
    solver->r_norm = sphi_solver_residual(solver, solver->b, x, r);
    if (!(solver->r_norm < before)) {
      memcpy(x, start, bytes);
      solver->r_norm = sphi_solver_residual(solver, solver->b, x, r);
    }
    if (solver->r_norm <= solver->target) break;
    idle = solver->r_norm < 0.9 * before ? 0 : idle + 1;
    if (stats->iterations < solver->pause)
      stats->restarts++;
    else if (solver->kept && stats->iterations < solver->limit) {
      solver->uses_left = idle = 0;
      solver->pause = solver->limit;
      SPH_TRY(make_preconditioner(solver));
    }
  }
  if (solver->null_space) sphi_solver_project(solver, x);
  return SPH_OK;
}

static sph_status verdict(sph_solver *solver, double b_norm) {
  sph_solver_stats *stats = &solver->stats;
  stats->residual = solver->r_norm;
  if (solver->first_iterations < 0) solver->first_iterations = stats->iterations;
  const bool reached = solver->r_norm <= solver->target;
  if (!reached || 2 * stats->iterations > 3 * solver->first_iterations + 2) solver->uses_left = 0;
  SPH_CHECK(solver->context, reached, SPH_E_NOT_CONVERGED,
            "solver \"%s\", \"%s\": after %lld of at most %d iterations the residual is %.3g, "
            "%.3g of ||b||, not below %.3g",
            solver->method->name, solver->preconditioner->name, (long long)stats->iterations,
            solver->limit, solver->r_norm, solver->r_norm / b_norm, solver->target);
  return SPH_OK;
}

sph_status sph_solver_solve(sph_solver *solver, const sph_matrix *matrix, const double *b,
                            double *x) {
  if (!solver) return SPH_E_ARGUMENT;
  const double begin = sphi_seconds();
  sph_solver_stats *stats = &solver->stats;
  SPH_TRY(look_at_arguments(solver, matrix, b, x));
  SPH_TRY(make_vectors(solver, matrix->n));
  solver->matrix = *matrix;
  solver->b = b;
  solver->blocks = sphi_blocks_of(solver->context, matrix->n);
  SPH_TRY(look_at_system(solver, x));
  const double b_norm = norm_of_b(solver);
  SPH_CHECK(solver->context, isfinite(b_norm), SPH_E_ARGUMENT,
            "solver \"%s\": ||b|| is beyond the largest number", solver->method->name);
  SPH_TRY(make_preconditioner(solver));
  const double middle = sphi_seconds();
  solver->target = fmax(solver->relative * b_norm, solver->absolute);
  stats->iterations = 0;
  set_fixed(solver, x);
  if (b_norm == 0) memset(x, 0, (size_t)matrix->n * sizeof *x);
  solver->r_norm = sphi_solver_residual(solver, b, x, solver->vectors[SPHI_VECTOR_R]);
  if (!isfinite(solver->r_norm)) { /* a guess beyond all bounds */
    memset(x, 0, (size_t)matrix->n * sizeof *x);
    set_fixed(solver, x);
    solver->r_norm = sphi_solver_residual(solver, b, x, solver->vectors[SPHI_VECTOR_R]);
  }
  stats->initial_residual = solver->r_norm;
  stats->target = solver->target;
  sph_status status = run(solver, x);
  if (status == SPH_OK) status = verdict(solver, b_norm);
  stats->solves++;
  stats->total_iterations += stats->iterations;
  stats->seconds_setup = middle - begin;
  stats->seconds_iterations = sphi_seconds() - middle;
  stats->total_seconds_setup += stats->seconds_setup;
  stats->total_seconds_iterations += stats->seconds_iterations;
  return status;
}
