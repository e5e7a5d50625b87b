/* Incomplete factors without fill-in, A ~ L U, of each block of rows by itself.
 *
 * Meijerink and van der Vorst (1977), doi:10.1090/S0025-5718-1977-0438681-4. Entries between blocks are
 * left out, so that blocks are independent. Factors are those of D^-1 A, kept in float.
 */
#include "solver/solver_impl.h"

typedef struct factors {
  int64_t *start;          /* [n] rows of a block lie together */
  int32_t *before, *total; /* entries of a row in L, and in all */
  int32_t *columns;        /* ascending */
  float *values;           /* L, then U without its diagonal, divided by it */
  float *inverse;          /* 1/diagonal of U */
  float *z;
  double *row;    /* [threads][block size] the row in hand, spread out */
  int32_t *place; /* [threads][block size] 1 + place of a column in the row in hand */
  int64_t capacity, entries, rows;
} factors;

static bool grow(sph_context *context, void *array, int64_t count, size_t size) {
  void **slot = array;
  sphi_free(context, *slot);
  *slot = sphi_alloc(context, (size_t)count, size);
  return *slot != NULL;
}

static bool make_room(sph_solver *solver, factors *f) {
  sph_context *context = solver->context;
  const int64_t n = solver->matrix.n, spread = solver->blocks.size * solver->blocks.threads;
  const int64_t entries = solver->matrix.row_start[n] - solver->matrix.row_start[0];
  bool complete = true;
#define GROW(array, count) \
  complete = complete && grow(context, &f->array, (count), sizeof *f->array)
  if (n > f->capacity) {
    const int64_t rows = n + n / 8;
    f->capacity = 0;
    GROW(start, rows), GROW(before, rows), GROW(total, rows), GROW(inverse, rows), GROW(z, rows);
    if (complete) f->capacity = rows;
  }
  if (entries > f->entries) {
    const int64_t most = entries + entries / 8;
    f->entries = 0;
    GROW(columns, most), GROW(values, most);
    if (complete) f->entries = most;
  }
  if (spread > f->rows) {
    f->rows = 0;
    GROW(row, spread), GROW(place, spread);
    if (complete) f->rows = spread;
  }
#undef GROW
  return complete;
}

/* The columns of row i in its block, sorted, and the row of D^-1 A spread out. */
static int32_t take_row(const sph_solver *solver, int64_t i, int64_t first, int64_t end,
                        int32_t *columns, double *row, int32_t *place) {
  const sph_matrix *matrix = &solver->matrix;
  int32_t count = 0;
  for (int64_t m = matrix->row_start[i]; m < matrix->row_start[i + 1]; m++) {
    const int32_t j = matrix->columns[m];
    if (j < first || j >= end) continue;
    if (!place[j - first]) {
      int32_t at = count++;
      for (; at > 0 && columns[at - 1] > j; at--) columns[at] = columns[at - 1];
      columns[at] = j;
      place[j - first] = 1;
      row[j - first] = 0;
    }
    row[j - first] += matrix->values[m] * solver->inverse_diagonal[i];
  }
  return count;
}

static void factorise_block(const sph_solver *solver, factors *f, int k, double *row,
                            int32_t *place) {
  const int64_t first = sphi_block_first(&solver->blocks, k);
  const int64_t end = sphi_block_end(&solver->blocks, k);
  int64_t to = solver->matrix.row_start[first] - solver->matrix.row_start[0];
  for (int64_t i = first; i < end; i++) {
    int32_t *columns = f->columns + to;
    float *values = f->values + to;
    const int32_t count = take_row(solver, i, first, end, columns, row, place);
    int32_t before = 0;
    for (; columns[before] < i; before++) {
      /* Row i less l times row p of U, where both have entries. */
      const int32_t p = columns[before];
      const double l = row[p - first];
      const int32_t *others = f->columns + f->start[p];
      const float *factor = f->values + f->start[p];
      for (int32_t m = f->before[p] + 1; m < f->total[p]; m++)
        if (place[others[m] - first]) row[others[m] - first] -= l * (double)factor[m];
    }
    /* U's rows are kept divided by their diagonal, so l is what multiplies z itself. */
    double diagonal = row[i - first];
    if (fabs(diagonal) < 1e-3) diagonal = diagonal < 0 ? -1e-3 : 1e-3;
    for (int32_t m = 0; m < count; m++) {
      const int32_t j = columns[m] - (int32_t)first;
      values[m] = (float)(m <= before ? row[j] : row[j] / diagonal);
      place[j] = 0;
    }
    f->start[i] = to;
    f->before[i] = before;
    f->total[i] = count;
    f->inverse[i] = (float)(1 / diagonal);
    to += count;
  }
}

static sph_status setup(sph_solver *solver) {
  sph_context *context = solver->context;
  const sphi_blocks *blocks = &solver->blocks;
  if (!solver->state) solver->state = SPHI_NEW(context, 1, factors);
  factors *f = solver->state;
  SPH_CHECK(context, f && make_room(solver, f), SPH_E_MEMORY,
            "solver \"%s\": out of memory for the factors of %lld rows", solver->method->name,
            (long long)solver->matrix.n);
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    factorise_block(solver, f, k, f->row + blocks->size * sphi_thread(),
                    f->place + blocks->size * sphi_thread());
  return SPH_OK;
}

static float part(const factors *f, int64_t i, int32_t m, int32_t end) {
  return sphi_part_times(f->columns + f->start[i], f->values + f->start[i], f->z, m, end);
}

static void apply(sph_solver *solver, const double *r, double *z) {
  const factors *f = solver->state;
  const sphi_blocks *blocks = &solver->blocks;
  /* Not beyond the range of float. */
  const double in = solver->scale * solver->largest_diagonal, out = 1 / in;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    const int64_t first = sphi_block_first(blocks, k), end = sphi_block_end(blocks, k);
    for (int64_t i = first; i < end; i++)
      f->z[i] = ((float)(r[i] * (solver->inverse_diagonal[i] * in)) - part(f, i, 0, f->before[i])) *
                f->inverse[i];
    for (int64_t i = end - 1; i >= first; i--) {
      f->z[i] -= part(f, i, f->before[i] + 1, f->total[i]);
      z[i] = (double)f->z[i] * out;
    }
  }
}

static void release(sph_solver *solver) {
  factors *f = solver->state;
  if (f) {
    void *const arrays[] = {f->start,   f->before, f->total, f->columns, f->values,
                            f->inverse, f->z,      f->row,   f->place};
    for (size_t a = 0; a < sizeof arrays / sizeof arrays[0]; a++)
      sphi_free(solver->context, arrays[a]);
    sphi_free(solver->context, f);
  }
  solver->state = NULL;
}

const sphi_preconditioner sphi_preconditioner_ilu0 = {
    .name = "ilu0",
    .summary = "incomplete factors of blocks of rows, no fill-in",
    .setup = setup,
    .apply = apply,
    .release = release,
};
