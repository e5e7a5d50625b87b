/* The methods and the preconditioners: one row each, and a file <stem>.c with its table
 * sphi_solver_<stem> or sphi_preconditioner_<stem>.
 *
 * X(id, ENUMERATOR, stem). The id is ABI: rows are added at the end, never removed or renumbered, and
 * include/sph/solver.h has the same enumerators. */
#ifndef SPHI_SOLVER_LIST_H
#define SPHI_SOLVER_LIST_H

#include "solver/solver_impl.h"

#define SPHI_SOLVER_LIST(X) \
  X(1, BICGSTAB, bicgstab)  \
  X(2, CG, cg)              \
  X(3, PETSC, petsc)        \
  X(4, GMRES, gmres)

#define SPHI_PRECONDITIONER_LIST(X) \
  X(1, NONE, none)                  \
  X(2, JACOBI, jacobi)              \
  X(3, ILU0, ilu0)                  \
  X(4, MULTIGRID, multigrid)

#define SPHI_SOLVER_EXTERN(id, enumerator, stem) extern const sphi_solver_method sphi_solver_##stem;
SPHI_SOLVER_LIST(SPHI_SOLVER_EXTERN)
#undef SPHI_SOLVER_EXTERN
#define SPHI_PRECONDITIONER_EXTERN(id, enumerator, stem) \
  extern const sphi_preconditioner sphi_preconditioner_##stem;
SPHI_PRECONDITIONER_LIST(SPHI_PRECONDITIONER_EXTERN)
#undef SPHI_PRECONDITIONER_EXTERN

#endif
