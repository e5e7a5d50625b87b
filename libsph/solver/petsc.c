/* PETSc's Krylov methods. A library built without PETSc has the row, but no solver. */
#include "solver/solver_impl.h"

const sphi_solver_method sphi_solver_petsc = {
    .name = "petsc",
    .summary = "PETSc's stabilised biconjugate gradients",
    .available = false,
};
