/* The levels of multigrid: aggregates of rows, sums over them, factors of the last level. */
#include "solver/multigrid_impl.h"

/* A neighbour is strong if its entry is at least this part of the row's largest; an entry is left out if
 * it is less than this part of the largest of both its rows. */
static const float strong = 0.25F;
static const double weak = 0.1;
/* A level that keeps more than this part of the rows is not worth having. */
static const double least_gain = 0.7;

static bool grow(sph_context *context, void *array, size_t count, size_t size) {
  void **slot = array;
  sphi_free(context, *slot);
  *slot = sphi_alloc(context, count, size);
  return *slot != NULL;
}

/* Room for a level of n rows and so many entries, and an eighth more. */
static bool make_room(sph_context *context, sphi_level *level, int64_t n, int64_t entries) {
  bool complete = true;
#define GROW(array, count) \
  complete = complete && grow(context, &level->array, (size_t)(count), sizeof *level->array)
  if (n > level->capacity) {
    const int64_t rows = n + n / 8;
    level->capacity = 0;
    GROW(start, rows), GROW(before, rows), GROW(inside, rows), GROW(total, rows);
    GROW(weight, rows), GROW(inverse_weight, rows);
    GROW(r, rows), GROW(z, rows), GROW(first, rows), GROW(x, rows + 1), GROW(v, rows);
    GROW(c, rows), GROW(aggregate, rows), GROW(member_start, rows), GROW(member_end, rows);
    GROW(members, rows), GROW(a_start, rows), GROW(a_end, rows);
    if (complete) level->capacity = rows;
  }
  if (entries > level->entries) {
    const int64_t most = entries + entries / 8;
    level->entries = 0;
    GROW(columns, most), GROW(values, most);
    if (complete) level->entries = most;
  }
#undef GROW
  return complete;
}

/* Room for the matrix of a coarse level. */
static bool make_matrix_room(sph_context *context, sphi_level *level, int64_t entries) {
  if (entries <= level->a_entries) return true;
  const int64_t most = entries + entries / 8;
  level->a_entries = 0;
  const bool complete = grow(context, &level->a_columns, (size_t)most, sizeof *level->a_columns) &&
                        grow(context, &level->a_values, (size_t)most, sizeof *level->a_values);
  if (complete) level->a_entries = most;
  return complete;
}

void sphi_multigrid_free(sph_context *context, sphi_multigrid *grid) {
  for (int l = 0; l < SPHI_MULTIGRID_LEVELS; l++) {
    sphi_level *level = &grid->levels[l];
    void *const arrays[] = {
        level->start,      level->before,  level->inside,    level->total,
        level->columns,    level->values,  level->weight,    level->inverse_weight,
        level->r,          level->z,       level->first,     level->x,
        level->v,          level->c,       level->aggregate, level->member_start,
        level->member_end, level->members, level->a_start,   level->a_end,
        level->a_columns,  level->a_values};
    for (size_t a = 0; a < sizeof arrays / sizeof arrays[0]; a++) sphi_free(context, arrays[a]);
  }
  sphi_free(context, grid->markers);
  sphi_free(context, grid);
}

/* The size of the largest entry of each row of block k beside the diagonal. */
static void find_largest(const sphi_level *level, const sphi_rows *rows, double *largest, int k) {
  for (int64_t i = sphi_block_first(&level->blocks, k); i < sphi_block_end(&level->blocks, k);
       i++) {
    double most = 0;
    for (int64_t m = rows->start[i]; m < rows->end[i]; m++) {
      const double size = rows->columns[m] == i ? 0 : fabs(rows->values[m]);
      most = size > most ? size : most;
    }
    largest[i] = most;
  }
}

/* Takes the entries of row i that are not weak, in their order; how many. The weak ones join the
 * diagonal, unless that left little of it. */
static int32_t take_entries(const sphi_rows *rows, const double *largest, int64_t i,
                            int32_t *restrict columns, float *restrict values, double *diagonal) {
  const double own = weak * largest[i];
  double d = 0, left_out = 0;
  int32_t count = 0;
  /* Without branches, which would be taken at random. */
  for (int64_t m = rows->start[i]; m < rows->end[i]; m++) {
    const int32_t j = rows->columns[m];
    const double a = rows->values[m], size = fabs(a);
    const bool beside = j != i, kept = beside & ((size >= own) | (size >= weak * largest[j]));
    columns[count] = j;
    values[count] = (float)a;
    count += kept;
    d += beside ? 0 : a;
    left_out += (kept | !beside) ? 0 : a;
  }
  *diagonal = fabs(d + left_out) > 0.5 * fabs(d) ? d + left_out : d;
  return count;
}

/* Puts a row's entries into the order of sphi_level. */
static void order_entries(sphi_level *level, int64_t i, int64_t first, int64_t end) {
  int32_t *restrict columns = level->columns + level->start[i];
  float *restrict values = level->values + level->start[i];
  int32_t before = 0, at = 0, inside = level->total[i];
  while (at < inside) {
    const int32_t j = columns[at];
    const float value = values[at];
    const bool outside = j < first || j >= end;
    if (!outside && j > i) {
      at++;
      continue;
    }
    const int32_t to = outside ? --inside : before++;
    columns[at] = columns[to];
    values[at] = values[to];
    columns[to] = j;
    values[to] = value;
    at += !outside;
  }
  level->before[i] = before;
  level->inside[i] = inside;
}

/* I - D^-1 A of block k without weak entries; weights are diagonals over `unit`. */
static void split_block(sphi_level *level, const sphi_rows *rows, const double *largest,
                        double unit, int k) {
  const int64_t first = sphi_block_first(&level->blocks, k);
  const int64_t end = sphi_block_end(&level->blocks, k);
  for (int64_t i = first; i < end; i++) {
    const int64_t to = rows->start[i] - rows->start[0];
    double diagonal;
    level->start[i] = to;
    level->total[i] =
        take_entries(rows, largest, i, level->columns + to, level->values + to, &diagonal);
    order_entries(level, i, first, end);
    const float scale = diagonal != 0 ? (float)(-1 / diagonal) : 0;
    for (int32_t m = 0; m < level->total[i]; m++) level->values[to + m] *= scale;
    level->weight[i] = (float)(diagonal / unit);
    level->inverse_weight[i] = diagonal != 0 ? (float)(unit / diagonal) : 0;
  }
}

/* Numbers of a row without aggregate: one that may join, and one that never will. */
enum { LONELY = -1, APART = INT32_MIN };

#define FOR_STRONG(i, m, j)                                                         \
  for (int64_t m = level->start[i], j; m < level->start[i] + level->inside[i]; m++) \
    if (level->values[m] >= bound[i] && (j = level->columns[m], true))

/* The aggregate, of the first `whole`, of the strongest neighbour of row i that has one. */
static int32_t strongest_aggregate(const sphi_level *level, const float *bound, int64_t i,
                                   int32_t whole) {
  float strongest = 0;
  int32_t best = LONELY;
  FOR_STRONG(i, m, j) {
    const int32_t c = level->aggregate[j];
    if (c < 0 || c >= whole || level->values[m] <= strongest) continue;
    strongest = level->values[m];
    best = c;
  }
  return best;
}

/* Puts the rows of block k into aggregates of a row and its strong neighbours in the block, numbered from
 * 0; how many. After Vanek, Mandel and Brezina (1996), doi:10.1007/BF02238511, algorithm 5.1. */
static int32_t aggregate_block(sphi_level *level, int k) {
  const int64_t first = sphi_block_first(&level->blocks, k);
  const int64_t end = sphi_block_end(&level->blocks, k);
  int32_t *aggregate = level->aggregate, count = 0;
  float *bound = level->first; /* free while levels are made */
  for (int64_t i = first; i < end; i++) {
    float most = 0;
    for (int64_t m = level->start[i]; m < level->start[i] + level->total[i]; m++)
      if (level->values[m] > most) most = level->values[m];
    bound[i] = strong * most;
    aggregate[i] = most > 0 ? LONELY : APART;
  }
  for (int64_t i = first; i < end; i++) {
    if (aggregate[i] != LONELY) continue;
    bool taken = false;
    FOR_STRONG(i, m, j) taken |= aggregate[j] >= 0;
    if (taken) continue;
    FOR_STRONG(i, m, j) if (aggregate[j] == LONELY) aggregate[j] = count;
    aggregate[i] = count++;
  }
  const int32_t whole = count;
  for (int64_t i = first; i < end; i++)
    if (aggregate[i] == LONELY) {
      const int32_t c = strongest_aggregate(level, bound, i, whole);
      /* Those that have joined stay unseen by the others until all have: -2, -3 .. */
      if (c >= 0) aggregate[i] = -2 - c;
    }
  for (int64_t i = first; i < end; i++)
    if (aggregate[i] < LONELY && aggregate[i] != APART) aggregate[i] = -2 - aggregate[i];
  for (int64_t i = first; i < end; i++) {
    if (aggregate[i] != LONELY) continue;
    FOR_STRONG(i, m, j) if (aggregate[j] == LONELY) aggregate[j] = count;
    aggregate[i] = count++;
  }
  return count;
}
#undef FOR_STRONG

/* Members of the aggregates of block k, which get the numbers from `base` on; rows of none get `none`. */
static void list_members(sphi_level *level, int k, int32_t base, int32_t count, int32_t none) {
  const int64_t first = sphi_block_first(&level->blocks, k);
  const int64_t end = sphi_block_end(&level->blocks, k);
  int32_t *starts = level->member_start + base, *ends = level->member_end + base;
  for (int32_t c = 0; c < count; c++) ends[c] = 0;
  for (int64_t i = first; i < end; i++)
    if (level->aggregate[i] >= 0) ends[level->aggregate[i]]++;
  int32_t at = (int32_t)first;
  for (int32_t c = 0; c < count; c++) {
    starts[c] = at;
    at += ends[c];
    ends[c] = starts[c];
  }
  for (int64_t i = first; i < end; i++) {
    const int32_t c = level->aggregate[i];
    if (c >= 0) level->members[ends[c]++] = (int32_t)i;
    level->aggregate[i] = c >= 0 ? base + c : none;
  }
}

/* Aggregates of all rows; the first of each block in c_first[blocks + 1]. */
static void aggregate_rows(sphi_level *level, int32_t *c_first) {
  const sphi_blocks *blocks = &level->blocks;
  int32_t counts[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) counts[k] = aggregate_block(level, k);
  c_first[0] = 0;
  for (int k = 0; k < blocks->count; k++) c_first[k + 1] = c_first[k] + counts[k];
  level->aggregates = c_first[blocks->count];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    list_members(level, k, c_first[k], counts[k], c_first[blocks->count]);
}

/* Rows c_first to c_end of the coarse matrix, from entry `to` on: sums of the entries between two
 * aggregates. False: they are more than `room`. */
static bool sum_rows(const sphi_level *fine, sphi_level *coarse, int32_t c_first, int32_t c_end,
                     int64_t to, int64_t room, uint32_t *markers) {
  const int64_t stop = to + room;
  for (int32_t c = c_first; c < c_end; c++) {
    int32_t *restrict columns = coarse->a_columns + to;
    double *restrict values = coarse->a_values + to;
    uint32_t count = 1;
    double size = 0;
    if (to >= stop) return false;
    columns[0] = c;
    values[0] = 0;
    markers[c] = 0;
    for (int32_t m = fine->member_start[c]; m < fine->member_end[c]; m++) {
      const int64_t i = fine->members[m];
      const double weight = (double)fine->weight[i];
      values[0] += weight;
      size += fabs(weight);
      for (int64_t e = fine->start[i]; e < fine->start[i] + fine->total[i]; e++) {
        const int32_t j = fine->aggregate[fine->columns[e]];
        if (j >= fine->aggregates) continue;
        const double value = -weight * (double)fine->values[e];
        const uint32_t at = markers[j]; /* of whatever row; the column there tells */
        if (at < count && columns[at] == j) {
          values[at] += value;
          continue;
        }
        if (to + count >= stop) return false;
        markers[j] = count;
        columns[count] = j;
        values[count++] = value;
      }
    }
    /* What is left of a diagonal whose row sums to zero is rounding. */
    if (fabs(values[0]) <= 1e-6 * size) values[0] = 0;
    coarse->a_start[c] = to;
    to += count;
    coarse->a_end[c] = to;
  }
  return true;
}

/* Moves the rows of the blocks together. */
static void pack_rows(sphi_level *coarse, int blocks, const int32_t *c_first) {
  int64_t to = 0;
  for (int k = 0; k < blocks; k++) {
    if (c_first[k] == c_first[k + 1]) continue;
    const int64_t from = coarse->a_start[c_first[k]];
    const int64_t count = coarse->a_end[c_first[k + 1] - 1] - from;
    if (from != to) {
      memmove(coarse->a_columns + to, coarse->a_columns + from, (size_t)count * sizeof(int32_t));
      memmove(coarse->a_values + to, coarse->a_values + from, (size_t)count * sizeof(double));
      for (int32_t c = c_first[k]; c < c_first[k + 1]; c++) {
        coarse->a_start[c] += to - from;
        coarse->a_end[c] += to - from;
      }
    }
    to += count;
  }
}

/* The matrix of the coarse level. A quarter of the entries nearly always suffices. */
static bool make_coarse(sph_context *context, sphi_multigrid *grid, const sphi_level *fine,
                        const int32_t *c_first, sphi_level *coarse) {
  const sphi_blocks *blocks = &fine->blocks;
  const int64_t n = fine->aggregates;
  const int64_t span = fine->start[fine->n - 1] + fine->total[fine->n - 1];
  if (n * blocks->threads > grid->marker_capacity) {
    grid->marker_capacity = 0;
    if (!grow(context, &grid->markers, (size_t)(n + n / 8) * (size_t)blocks->threads,
              sizeof *grid->markers))
      return false;
    grid->marker_capacity = (n + n / 8) * blocks->threads;
  }
  for (int part = 4; part >= 1; part -= 3) {
    bool fits[SPHI_SOLVER_MAX_BLOCKS], all = true;
    if (!make_room(context, coarse, n, 0) || !make_matrix_room(context, coarse, span / part + 1))
      return false;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
    for (int k = 0; k < blocks->count; k++) {
      const int64_t last = sphi_block_end(blocks, k) - 1;
      const int64_t first = fine->start[sphi_block_first(blocks, k)];
      const int64_t end = fine->start[last] + fine->total[last];
      fits[k] = sum_rows(fine, coarse, c_first[k], c_first[k + 1], first / part,
                         end / part - first / part, grid->markers + n * sphi_thread());
    }
    for (int k = 0; k < blocks->count; k++) all = all && fits[k];
    if (all) break;
  }
  pack_rows(coarse, blocks->count, c_first);
  return true;
}

/* Factors of D^-1 A with row exchanges; a pivot of nothing stands for an unknown that is left zero. */
static void factorise(sphi_multigrid *grid, const sphi_level *level) {
  const int n = (int)level->n;
  double(*a)[SPHI_MULTIGRID_DENSE] = grid->factors;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++) a[i][j] = i == j;
    for (int64_t m = level->start[i]; m < level->start[i] + level->total[i]; m++)
      a[i][level->columns[m]] -= (double)level->values[m];
  }
  for (int k = 0; k < n; k++) {
    int pivot = k;
    for (int i = k + 1; i < n; i++)
      if (fabs(a[i][k]) > fabs(a[pivot][k])) pivot = i;
    grid->pivots[k] = pivot;
    if (pivot != k)
      for (int j = 0; j < n; j++) {
        const double swap = a[k][j];
        a[k][j] = a[pivot][j];
        a[pivot][j] = swap;
      }
    a[k][k] = fabs(a[k][k]) > 1e-6 ? 1 / a[k][k] : 0;
    for (int i = k + 1; i < n; i++) {
      const double factor = a[i][k] *= a[k][k];
      if (factor != 0)
        for (int j = k + 1; j < n; j++) a[i][j] -= factor * a[k][j];
    }
  }
}

bool sphi_multigrid_make(sph_solver *solver, sphi_multigrid *grid) {
  sph_context *context = solver->context;
  const sph_matrix *matrix = &solver->matrix;
  sphi_rows rows = {matrix->row_start, matrix->row_start + 1, matrix->columns, matrix->values};
  sphi_level *level = grid->levels;
  double unit = grid->largest = solver->largest_diagonal;
  level->n = matrix->n;
  for (int l = 0;; l++, level++) {
    const sphi_blocks blocks = level->blocks = sphi_blocks_of(context, level->n);
    if (!make_room(context, level, level->n, rows.end[level->n - 1] - rows.start[0])) return false;
    double *largest = solver->largest_beside;
    if (l > 0) { /* those of the finest level are not needed any more */
#pragma omp parallel for num_threads(blocks.threads) schedule(static) if (blocks.threads > 1)
      for (int k = 0; k < blocks.count; k++) find_largest(level, &rows, largest, k);
    }
#pragma omp parallel for num_threads(blocks.threads) schedule(static) if (blocks.threads > 1)
    for (int k = 0; k < blocks.count; k++) split_block(level, &rows, largest, unit, k);
    unit = 1; /* coarse matrices are sums of weights */
    grid->count = l + 1;
    grid->dense = level->n <= SPHI_MULTIGRID_DENSE;
    if (grid->dense) break;
    int32_t c_first[SPHI_SOLVER_MAX_BLOCKS + 1];
    aggregate_rows(level, c_first);
    if (level->aggregates == 0 || l + 1 == SPHI_MULTIGRID_LEVELS ||
        (double)level->aggregates > least_gain * (double)level->n) {
      memset(level->aggregate, 0, (size_t)level->n * sizeof *level->aggregate);
      break;
    }
    if (!make_coarse(context, grid, level, c_first, level + 1)) return false;
    level[1].n = level->aggregates;
    level[1].x[level[1].n] = 0; /* what rows of no aggregate get */
    rows = (sphi_rows){level[1].a_start, level[1].a_end, level[1].a_columns, level[1].a_values};
  }
  if (grid->dense) factorise(grid, level);
  return true;
}
