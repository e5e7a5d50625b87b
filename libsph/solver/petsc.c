/* PETSc's Krylov methods. A library built without PETSc has the row, but no solver.
 *
 * A run solves A e = r for what x lacks. Matrices and vectors are sequential, so that MPI is a condition
 * of PETSc's, not of the caller's.
 */
#include "solver/solver_impl.h"

#ifdef SPHI_PETSC
#include <petscksp.h>

typedef struct petsc {
  Mat a;
  Vec e, r;
  KSP ksp;
  PetscInt *counts, *columns; /* of rows, and of the row in hand */
  PetscScalar *values;
  int64_t capacity, longest;
} petsc;

/* Runs a call of PETSc's; its message is the context's. */
#define TRY_PETSC(solver, call)                     \
  do {                                              \
    const PetscErrorCode code = (call);             \
    if (code != 0) return complain((solver), code); \
  } while (0)

static sph_status complain(const sph_solver *solver, PetscErrorCode code) {
  const char *text = NULL;
  char *specific = NULL;
  PetscErrorMessage(code, &text, &specific);
  return SPHI_ERROR(solver->context, code == PETSC_ERR_MEM ? SPH_E_MEMORY : SPH_E_INTERNAL,
                    "solver \"petsc\": error %d, %.100s: %.400s", (int)code, text ? text : "",
                    specific ? specific : "");
}

/* Unless the caller did: without its signal handlers and its files of options. */
static sph_status initialise(const sph_solver *solver) {
  PetscBool done = PETSC_FALSE;
  TRY_PETSC(solver, PetscInitialized(&done));
  if (done) return SPH_OK;
  TRY_PETSC(solver, PetscOptionsSetValue(NULL, "-no_signal_handler", "true"));
  TRY_PETSC(solver, PetscOptionsSetValue(NULL, "-skip_petscrc", "true"));
  TRY_PETSC(solver, PetscInitializeNoArguments());
  return SPH_OK;
}

static void drop_objects(petsc *p) {
  (void)KSPDestroy(&p->ksp);
  (void)MatDestroy(&p->a);
  (void)VecDestroy(&p->e);
  (void)VecDestroy(&p->r);
}

static sph_status choose_preconditioner(const sph_solver *solver, petsc *p) {
  PC pc;
  const char *name = solver->preconditioner->name;
  PCType type = strcmp(name, "none") == 0     ? PCNONE
                : strcmp(name, "jacobi") == 0 ? PCJACOBI
                : strcmp(name, "ilu0") == 0   ? PCILU
                                              : PCGAMG;
#ifdef PETSC_HAVE_HYPRE
  if (strcmp(name, "multigrid") == 0) type = PCHYPRE;
#endif
  TRY_PETSC(solver, KSPGetPC(p->ksp, &pc));
  TRY_PETSC(solver, PCSetType(pc, type));
#ifdef PETSC_HAVE_HYPRE
  if (strcmp(type, PCHYPRE) == 0) TRY_PETSC(solver, PCHYPRESetType(pc, "boomeramg"));
#endif
  return SPH_OK;
}

static sph_status make_objects(const sph_solver *solver, petsc *p) {
  const PetscInt n = (PetscInt)solver->matrix.n;
  TRY_PETSC(solver, MatCreate(PETSC_COMM_SELF, &p->a));
  TRY_PETSC(solver, MatSetSizes(p->a, n, n, n, n));
  TRY_PETSC(solver, MatSetType(p->a, MATSEQAIJ));
  TRY_PETSC(solver, VecCreateSeq(PETSC_COMM_SELF, n, &p->e));
  TRY_PETSC(solver, VecDuplicate(p->e, &p->r));
  TRY_PETSC(solver, KSPCreate(PETSC_COMM_SELF, &p->ksp));
  TRY_PETSC(solver, KSPSetType(p->ksp, KSPBCGS));
  TRY_PETSC(solver, KSPSetPCSide(p->ksp, PC_RIGHT));
  TRY_PETSC(solver, KSPSetNormType(p->ksp, KSP_NORM_UNPRECONDITIONED));
  return choose_preconditioner(solver, p);
}

static bool make_room(const sph_solver *solver, petsc *p) {
  sph_context *context = solver->context;
  const sph_matrix *matrix = &solver->matrix;
  int64_t longest = 0;
  for (int64_t i = 0; i < matrix->n; i++)
    if (matrix->row_start[i + 1] - matrix->row_start[i] > longest)
      longest = matrix->row_start[i + 1] - matrix->row_start[i];
  if (matrix->n > p->capacity) {
    sphi_free(context, p->counts);
    p->counts = SPHI_NEW(context, matrix->n, PetscInt);
    p->capacity = p->counts ? matrix->n : 0;
  }
  if (longest > p->longest) {
    sphi_free(context, p->columns);
    sphi_free(context, p->values);
    p->columns = SPHI_NEW(context, longest, PetscInt);
    p->values = SPHI_NEW(context, longest, PetscScalar);
    p->longest = p->columns && p->values ? longest : 0;
  }
  return p->counts && p->columns && p->values;
}

/* The rows of A, which may hold a column twice and in any order. */
static sph_status fill_matrix(const sph_solver *solver, petsc *p) {
  const sph_matrix *matrix = &solver->matrix;
  for (int64_t i = 0; i < matrix->n; i++)
    p->counts[i] = (PetscInt)(matrix->row_start[i + 1] - matrix->row_start[i]);
  TRY_PETSC(solver, MatSeqAIJSetPreallocation(p->a, 0, p->counts));
  for (int64_t i = 0; i < matrix->n; i++) {
    const int64_t first = matrix->row_start[i];
    const PetscInt row = (PetscInt)i;
    for (int64_t m = 0; m < p->counts[i]; m++) {
      p->columns[m] = matrix->columns[first + m];
      p->values[m] = matrix->values[first + m];
    }
    TRY_PETSC(solver, MatSetValues(p->a, 1, &row, p->counts[i], p->columns, p->values, ADD_VALUES));
  }
  TRY_PETSC(solver, MatAssemblyBegin(p->a, MAT_FINAL_ASSEMBLY));
  TRY_PETSC(solver, MatAssemblyEnd(p->a, MAT_FINAL_ASSEMBLY));
  return SPH_OK;
}

static sph_status set_up(sph_solver *solver, petsc *p) {
  if (!solver->kept || !p->ksp) {
    drop_objects(p);
    SPH_TRY(make_objects(solver, p));
  }
  SPH_TRY(fill_matrix(solver, p));
  TRY_PETSC(solver, KSPSetReusePreconditioner(p->ksp, solver->kept ? PETSC_TRUE : PETSC_FALSE));
  TRY_PETSC(solver, KSPSetOperators(p->ksp, p->a, p->a));
  TRY_PETSC(solver, KSPSetUp(p->ksp));
  return SPH_OK;
}

static sph_status setup(sph_solver *solver) {
  sph_context *context = solver->context;
  const sph_matrix *matrix = &solver->matrix;
  SPH_CHECK(context,
            sizeof(PetscInt) > 4 || matrix->row_start[matrix->n] - matrix->row_start[0] < INT32_MAX,
            SPH_E_UNAVAILABLE, "solver \"petsc\": this PETSc counts entries to 2^31 - 1");
  if (!solver->method_state) solver->method_state = SPHI_NEW(context, 1, petsc);
  petsc *p = solver->method_state;
  SPH_CHECK(context, p && make_room(solver, p), SPH_E_MEMORY,
            "solver \"petsc\": out of memory for %lld rows", (long long)matrix->n);
  SPH_TRY(initialise(solver));
  (void)PetscPushErrorHandler(PetscReturnErrorHandler, NULL);
  const sph_status status = set_up(solver, p);
  if (status != SPH_OK) drop_objects(p);
  (void)PetscPopErrorHandler();
  return status;
}

/* x + e, with A e = r. */
static sph_status correct(sph_solver *solver, petsc *p, double *x) {
  const int64_t n = solver->matrix.n;
  const double *r = solver->vectors[SPHI_VECTOR_R];
  PetscScalar *to;
  const PetscScalar *from;
  PetscInt iterations = 0;
  TRY_PETSC(solver, VecGetArray(p->r, &to));
  for (int64_t i = 0; i < n; i++) to[i] = r[i] * solver->scale;
  TRY_PETSC(solver, VecRestoreArray(p->r, &to));
  TRY_PETSC(solver, KSPSetTolerances(p->ksp, 0.9 * solver->target * solver->scale, 0, PETSC_DEFAULT,
                                     (PetscInt)(solver->pause - solver->stats.iterations)));
  TRY_PETSC(solver, KSPSolve(p->ksp, p->r, p->e));
  TRY_PETSC(solver, KSPGetIterationNumber(p->ksp, &iterations));
  solver->stats.iterations += iterations;
  TRY_PETSC(solver, VecGetArrayRead(p->e, &from));
  bool finite = true;
  for (int64_t i = 0; i < n; i++) finite = finite && isfinite(from[i]);
  for (int64_t i = 0; i < n && finite; i++) x[i] += from[i] / solver->scale;
  TRY_PETSC(solver, VecRestoreArrayRead(p->e, &from));
  return SPH_OK;
}

static sph_status iterate(sph_solver *solver, double *x) {
  (void)PetscPushErrorHandler(PetscReturnErrorHandler, NULL);
  const sph_status status = correct(solver, solver->method_state, x);
  (void)PetscPopErrorHandler();
  return status;
}

static void release(sph_solver *solver) {
  petsc *p = solver->method_state;
  if (!p) return;
  PetscBool gone = PETSC_FALSE;
  (void)PetscFinalized(&gone); /* by the caller, before this solver */
  if (!gone) drop_objects(p);
  sphi_free(solver->context, p->counts);
  sphi_free(solver->context, p->columns);
  sphi_free(solver->context, p->values);
  sphi_free(solver->context, p);
}

#define AVAILABLE true
#else
#define AVAILABLE false
#endif

const sphi_solver_method sphi_solver_petsc = {
    .name = "petsc",
    .summary = "PETSc's stabilised biconjugate gradients and preconditioners",
    .available = AVAILABLE,
#ifdef SPHI_PETSC
    .iterate = iterate,
    .setup = setup,
    .release = release,
#endif
};
