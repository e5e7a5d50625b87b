/** @file
 * Solvers of sparse linear systems A x = b: Krylov methods with preconditioners, for the pressures of
 * incompressible flow and for a caller's own systems.
 */
#ifndef SPH_SOLVER_H
#define SPH_SOLVER_H

#include <sph/types.h>

SPH_BEGIN_DECLS

/** Methods; numbers 1 to sph_solver_count() without gaps, never renumbered. */
typedef enum sph_solver_kind {
  SPH_SOLVER_BICGSTAB = 1, /**< stabilised biconjugate gradients, for any matrix */
  SPH_SOLVER_CG = 2,       /**< conjugate gradients, for symmetric positive definite ones */
  SPH_SOLVER_PETSC = 3,    /**< PETSc's BiCGStab, in a library built with PETSC=1 */
  SPH_SOLVER_GMRES = 4     /**< flexible generalised minimal residuals, for any matrix */
} sph_solver_kind;

/** Preconditioners; numbers 1 to sph_preconditioner_count() without gaps, never renumbered. */
typedef enum sph_preconditioner {
  SPH_PRECONDITIONER_NONE = 1,
  SPH_PRECONDITIONER_JACOBI = 2,   /**< the diagonal */
  SPH_PRECONDITIONER_ILU0 = 3,     /**< incomplete factors of blocks of rows, no fill-in */
  SPH_PRECONDITIONER_MULTIGRID = 4 /**< multigrid of aggregates: the default */
} sph_preconditioner;

/** A square matrix by rows, the caller's arrays. The entries of row i are those from row_start[i] to
 * row_start[i + 1], in any order; each row has its diagonal. A row without others fixes its unknown.
 */
typedef struct sph_matrix {
  int64_t n;                /**< rows, 1 to 2^31 - 1 */
  const int64_t *row_start; /**< [n + 1], never less than the one before */
  const int32_t *columns;   /**< 0 to n - 1 */
  const double *values;
} sph_matrix;

/** What the last solve was like, and sums since the solver was created. Norms are Euclidean. */
typedef struct sph_solver_stats {
  int64_t iterations;        /**< of the last solve */
  double initial_residual;   /**< ||b - A x|| at its start */
  double residual;           /**< at its end, of the x handed back */
  double target;             /**< what it had to reach: max(relative ||b||, absolute) */
  double seconds_setup;      /**< checks and preconditioner of the last solve */
  double seconds_iterations; /**< everything else of it */
  int64_t solves;
  int64_t setups; /**< preconditioners made */
  int64_t total_iterations;
  int64_t restarts; /**< times a method broke down and began anew from its residual */
  double total_seconds_setup;
  double total_seconds_iterations;
} sph_solver_stats;

/** Create a solver: tolerances 1e-6 and 0, at most 1000 iterations, multigrid.
 *
 * Ownership  the caller destroys *out, which holds a reference to context
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT a NULL, unknown kind; SPH_E_UNAVAILABLE SPH_SOLVER_PETSC in a library
 *            built without; SPH_E_MEMORY
 * Source     BiCGStab: van der Vorst (1992), doi:10.1137/0913035; CG: Hestenes and Stiefel (1952);
 *            GMRES: Saad (1993), doi:10.1137/0914028, starting again after 30 iterations; differs: all
 *            restart from the residual where they break down
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_create(sph_context *context, sph_solver_kind kind,
                                                   sph_solver **out);

/** Release the solver and set *solver to NULL. NULL is allowed.
 *
 * Parallel   not while another call uses the context
 * Errors     none
 * Since      0.1
 */
SPH_API void sph_solver_destroy(sph_solver **solver);

/** Choose the preconditioner; SPH_PRECONDITIONER_MULTIGRID until called.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT solver NULL, preconditioner unknown
 * Source     multigrid: Notay (2010), doi:10.1553/etna_vol37s123; differs: aggregates of a row and its
 *            strong neighbours instead of pairs of pairs
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_set_preconditioner(sph_solver *solver,
                                                               sph_preconditioner preconditioner);

/** A solve ends once ||b - A x|| <= max(relative ||b||, absolute); 1e-6 and 0 until called.
 *
 * Units      relative 0 to 1, one of the two > 0; absolute that of b, >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT solver NULL, a number not finite or out of range, or both 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_set_tolerance(sph_solver *solver, double relative,
                                                          double absolute);

/** At most so many iterations; 1000 until called.
 *
 * Units      iterations >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT solver NULL, iterations < 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_set_limit(sph_solver *solver, int iterations);

/** Say that A 1 = 0, as where no pressure is prescribed anywhere.
 *
 * Such a system has a solution for some b alone. What is solved is A x = b - c with the number c that
 * makes it solvable (the mean of b if A is symmetric), and of all x the one with zero mean. Rows that
 * fix their unknown take no part in c and means. The residual is without its mean.
 *
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT solver NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_set_null_space(sph_solver *solver, bool constant);

/** Keep a preconditioner for so many solves after its own, while the number of rows stays; 0 until
 * called. It is made anew before, if a solve took half as many iterations again as its first, or failed.
 *
 * Units      solves >= 0
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT solver NULL, solves < 0
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_set_reuse(sph_solver *solver, int solves);

/** Solve A x = b from the guess x.
 *
 * Shape      b, x [n]
 * Ownership  borrows matrix, its arrays and b, which must not overlap x, for the call
 * Parallel   not while another call uses the context; the threads of the context, whose number does not
 *            change a bit of x
 * Errors     SPH_E_ARGUMENT a NULL, n out of range, a row that is malformed, has no diagonal, a zero or
 *            a value that is not finite there; b or x not finite: x is as it was. SPH_E_NOT_CONVERGED
 *            the limit was reached, or the method broke down time and again: x has the least residual
 *            met. SPH_E_UNAVAILABLE PETSc lacks what was asked for; SPH_E_INTERNAL PETSc failed;
 *            SPH_E_MEMORY: x is as it was, or has a smaller residual
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_solve(sph_solver *solver, const sph_matrix *matrix,
                                                  const double *b, double *x);

/** Counters, norms and times.
 *
 * Ownership  fills *stats
 * Parallel   thread-safe for reading
 * Errors     SPH_E_ARGUMENT a NULL
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_get_stats(const sph_solver *solver,
                                                      sph_solver_stats *stats);

/** The method with this name; the message of a failure suggests the nearest one.
 *
 * Ownership  *kind is untouched after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, name or kind NULL; SPH_E_NAME no such method
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_solver_find(sph_context *context, const char *name,
                                                 sph_solver_kind *kind);

/** Number of methods: they are the numbers 1 to this one, also those this library was built without.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_solver_count(void);

/** Name of a method, for example "bicgstab"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_solver_kind_name(sph_solver_kind kind);

/** What a method is, in a line; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_solver_kind_summary(sph_solver_kind kind);

/** The preconditioner with this name; the message of a failure suggests the nearest one.
 *
 * Ownership  *preconditioner is untouched after an error
 * Parallel   not while another call uses the context
 * Errors     SPH_E_ARGUMENT context, name or preconditioner NULL; SPH_E_NAME no such preconditioner
 * Since      0.1
 */
SPH_API SPH_NODISCARD sph_status sph_preconditioner_find(sph_context *context, const char *name,
                                                         sph_preconditioner *preconditioner);

/** Number of preconditioners: they are the numbers 1 to this one.
 *
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API int sph_preconditioner_count(void);

/** Name of a preconditioner, for example "multigrid"; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_preconditioner_name(sph_preconditioner preconditioner);

/** What a preconditioner is, in a line; "unknown" for any other number.
 *
 * Ownership  static text
 * Parallel   thread-safe
 * Errors     none
 * Since      0.1
 */
SPH_API const char *sph_preconditioner_summary(sph_preconditioner preconditioner);

SPH_END_DECLS

#endif
