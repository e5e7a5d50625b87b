/* Solvers from the inside: the tables that methods and preconditioners fill, and vector operations.
 *
 * Rows are cut into blocks that depend on n alone. A sum is the sum of the blocks' sums in their order,
 * whichever thread makes them: the same bits with any number of threads.
 */
#ifndef SPHI_SOLVER_IMPL_H
#define SPHI_SOLVER_IMPL_H

#include <sph/solver.h>

#include "core/internal.h"

enum { SPHI_SOLVER_MAX_BLOCKS = 64 };

/* Vectors that methods work with. */
typedef enum sphi_solver_vector {
  SPHI_VECTOR_START, /* x at the start of a run */
  SPHI_VECTOR_BEST,  /* the x of least residual, where that is not the last */
  SPHI_VECTOR_R,     /* the residual */
  SPHI_VECTOR_P,
  SPHI_VECTOR_V,
  SPHI_VECTOR_P_HAT,
  SPHI_VECTOR_S_HAT,
  SPHI_VECTOR_T,
  SPHI_VECTOR_R_FIRST,
  SPHI_SOLVER_VECTORS
} sphi_solver_vector;

typedef struct sphi_preconditioner {
  const char *name, *summary;
  /* Makes the preconditioner of solver->matrix; the state is kept and used again. */
  sph_status (*setup)(sph_solver *solver);
  /* z = M r; r is finite, the rows that fix their unknown are zero in r. */
  void (*apply)(sph_solver *solver, const double *r, double *z);
  void (*release)(sph_solver *solver);
} sphi_preconditioner;

typedef struct sphi_solver_method {
  const char *name, *summary;
  bool available;
  /* Iterates from x, whose residual is in SPHI_VECTOR_R and r_norm > target, until the residual is below
   * target, `pause` is reached or the method breaks down; leaves the best x. */
  sph_status (*iterate)(sph_solver *solver, double *x);
  /* OPTIONAL: the method has preconditioners of its own and makes them here, unless solver->kept; what
   * it keeps is released by the other. */
  sph_status (*setup)(sph_solver *solver);
  void (*release)(sph_solver *solver);
} sphi_solver_method;

/* Equal blocks of rows: `size` of them each, the last less. */
typedef struct sphi_blocks {
  int64_t n, size;
  int count, threads;
} sphi_blocks;

struct sph_solver {
  sph_context *context;
  const sphi_solver_method *method;
  const sphi_preconditioner *preconditioner;
  double relative, absolute;
  int limit, reuse;
  bool null_space;
  /* The system in hand. */
  sph_matrix matrix;
  const double *b;
  sphi_blocks blocks;
  double target;
  double r_norm;            /* of the residual in SPHI_VECTOR_R */
  double scale;             /* 1/||r|| at the start, for preconditioners in float */
  double *inverse_diagonal; /* [n] */
  double *largest_beside;   /* [n] the size of a row's largest entry beside the diagonal */
  double largest_diagonal;
  int32_t *fixed; /* rows with nothing but their diagonal: those of a block from its first row on */
  int32_t fixed_count[SPHI_SOLVER_MAX_BLOCKS];
  int64_t free_rows;
  double *vectors[SPHI_SOLVER_VECTORS];
  int64_t capacity;
  /* The preconditioner kept: of so many rows, by this table, for so many solves more. */
  const sphi_preconditioner *made;
  int64_t made_rows, first_iterations;
  int uses_left;
  bool kept;          /* it was made for an earlier solve */
  int64_t pause;      /* iterations after which a run ends */
  void *state;        /* the preconditioner's */
  void *method_state; /* the method's */
  sph_solver_stats stats;
};

sphi_blocks sphi_blocks_of(const sph_context *context, int64_t n);
static inline int64_t sphi_block_first(const sphi_blocks *blocks, int k) {
  return k * blocks->size;
}
static inline int64_t sphi_block_end(const sphi_blocks *blocks, int k) {
  const int64_t end = (k + 1) * blocks->size;
  return end < blocks->n ? end : blocks->n;
}
static inline double sphi_block_sum(const sphi_blocks *blocks, const double *sums) {
  double sum = 0;
  for (int k = 0; k < blocks->count; k++) sum += sums[k];
  return sum;
}

/* Row i of A times x. */
static inline double sphi_row_times(const sph_matrix *matrix, int64_t i, const double *x) {
  const int32_t *restrict columns = matrix->columns;
  const double *restrict values = matrix->values;
  const int64_t end = matrix->row_start[i + 1];
  int64_t k = matrix->row_start[i];
  double s0 = 0, s1 = 0;
  for (; k + 1 < end; k += 2) {
    s0 += values[k] * x[columns[k]];
    s1 += values[k + 1] * x[columns[k + 1]];
  }
  if (k < end) s0 += values[k] * x[columns[k]];
  return s0 + s1;
}

/* The sum of entries `m` to `end` of a row of a preconditioner times z. */
static inline float sphi_part_times(const int32_t *restrict columns, const float *restrict values,
                                    const float *z, int32_t m, int32_t end) {
  float s0 = 0, s1 = 0;
  for (; m + 1 < end; m += 2) {
    s0 += values[m] * z[columns[m]];
    s1 += values[m + 1] * z[columns[m + 1]];
  }
  if (m < end) s0 += values[m] * z[columns[m]];
  return s0 + s1;
}

/* The next solve makes its preconditioner: the rows have other numbers than before. */
void sphi_solver_renumbered(sph_solver *solver);
/* y = A x, without its mean where the null space is asked for; u.y and y.y. */
void sphi_solver_multiply(const sph_solver *solver, const double *x, double *y, const double *u,
                          double *uy, double *yy);
/* r -= alpha v; ||r||. */
double sphi_solver_subtract(const sph_solver *solver, double *r, double alpha, const double *v);
double sphi_solver_dot(const sph_solver *solver, const double *a, const double *b);
/* r = b - A x, without its mean where the null space is asked for; ||r||. */
double sphi_solver_residual(const sph_solver *solver, const double *b, const double *x, double *r);
/* Takes the mean over the rows that are free out of them. */
void sphi_solver_project(const sph_solver *solver, double *x);

#endif
