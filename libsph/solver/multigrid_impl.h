/* The hierarchy of multigrid: how it is made (multigrid_levels.c) and used (multigrid.c). */
#ifndef SPHI_MULTIGRID_IMPL_H
#define SPHI_MULTIGRID_IMPL_H

#include "solver/solver_impl.h"

enum { SPHI_MULTIGRID_LEVELS = 24, SPHI_MULTIGRID_DENSE = 64 };

/* Rows of a matrix in double, from start[i] to end[i]. */
typedef struct sphi_rows {
  const int64_t *start, *end;
  const int32_t *columns;
  const double *values;
} sphi_rows;

/* A level holds I - D^-1 A in float: smoothing is a sum then. A is without its weak entries, which are
 * added to the diagonal instead. A row has first the entries of its block before it, then those of its
 * block behind it, then all others. */
typedef struct sphi_level {
  int64_t n;
  sphi_blocks blocks;
  int64_t *start;
  int32_t *before, *inside, *total; /* how many of a row's entries, from its start on */
  int32_t *columns;
  float *values;
  float *weight,
      *inverse_weight;  /* diagonal over the largest of the finest level; 0 if it vanishes */
  float *r, *z, *first; /* D^-1 times the right-hand side, the result, and it half-way */
  float *x, *v, *c;     /* of the coarse levels; x[n] = 0 */
  /* The next level: rows of no aggregate have the number `aggregates`. */
  int64_t aggregates;
  int32_t *aggregate, *member_start, *member_end, *members;
  /* A of a coarse level. */
  int64_t *a_start, *a_end;
  int32_t *a_columns;
  double *a_values;
  int64_t capacity, entries, a_entries;
} sphi_level;

typedef struct sphi_multigrid {
  sphi_level levels[SPHI_MULTIGRID_LEVELS];
  int count;
  bool dense; /* the last level is solved by its factors */
  double factors[SPHI_MULTIGRID_DENSE][SPHI_MULTIGRID_DENSE];
  int pivots[SPHI_MULTIGRID_DENSE];
  double largest;    /* diagonal of the finest level */
  uint32_t *markers; /* [threads][aggregates] */
  int64_t marker_capacity;
} sphi_multigrid;

/* Makes the levels of solver->matrix; false without memory. */
bool sphi_multigrid_make(sph_solver *solver, sphi_multigrid *grid);
void sphi_multigrid_free(sph_context *context, sphi_multigrid *grid);

#endif
