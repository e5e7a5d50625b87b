/* Conjugate gradients, in the form that allows a preconditioner which is not quite linear.
 *
 * Hestenes and Stiefel (1952); beta after Notay (2000), doi:10.1137/S1064827599362314. z = M r:
 *
 *     v = A p,  alpha = z . r/p . v,  x += alpha p,  r -= alpha v                                   (1)
 *     beta = z' . (r' - r)/z . r = -alpha z' . v/z . r,  p = z' + beta p                            (2)
 */
#include "solver/solver_impl.h"

/* Products below this part of their factors' norms are rounding errors: the method has broken down. */
static const double nothing = 1e-14;

typedef struct run {
  double *x, *r, *p, *v, *z;
} run;

/* z . r, z . v and z . z. */
static void products(const sph_solver *solver, const run *w, double *zr, double *zv, double *zz) {
  const sphi_blocks *blocks = &solver->blocks;
  double zr_sums[SPHI_SOLVER_MAX_BLOCKS], zv_sums[SPHI_SOLVER_MAX_BLOCKS];
  double zz_sums[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double zr_sum = 0, zv_sum = 0, zz_sum = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      zr_sum += w->z[i] * w->r[i];
      zv_sum += w->z[i] * w->v[i];
      zz_sum += w->z[i] * w->z[i];
    }
    zr_sums[k] = zr_sum;
    zv_sums[k] = zv_sum;
    zz_sums[k] = zz_sum;
  }
  *zr = sphi_block_sum(blocks, zr_sums);
  *zv = sphi_block_sum(blocks, zv_sums);
  *zz = sphi_block_sum(blocks, zz_sums);
}

/* x += alpha p, then p = z + beta p. */
static void advance(const sph_solver *solver, const run *w, double alpha, double beta) {
  const sphi_blocks *blocks = &solver->blocks;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      w->x[i] += alpha * w->p[i];
      w->p[i] = w->z[i] + beta * w->p[i];
    }
}

static sph_status iterate(sph_solver *solver, double *x) {
  double **vectors = solver->vectors;
  const run w = {.x = x,
                 .r = vectors[SPHI_VECTOR_R],
                 .p = vectors[SPHI_VECTOR_P],
                 .v = vectors[SPHI_VECTOR_V],
                 .z = vectors[SPHI_VECTOR_P_HAT]};
  const size_t bytes = (size_t)solver->matrix.n * sizeof(double);
  double best = solver->r_norm, rho, zv, zz, pv, vv;
  memset(w.v, 0, bytes);
  memset(w.p, 0, bytes);
  solver->preconditioner->apply(solver, w.r, w.z);
  products(solver, &w, &rho, &zv, &zz);
  bool sound = rho > nothing * solver->r_norm * sqrt(zz) && isfinite(zz);
  advance(solver, &w, 0, 0);
  while (sound && solver->stats.iterations < solver->pause && solver->r_norm > solver->target) {
    solver->stats.iterations++;
    sphi_solver_multiply(solver, w.p, w.v, w.p, &pv, &vv);
    if (!(pv > 0) || !isfinite(vv)) break; /* not positive definite */
    const double alpha = rho / pv, norm = sphi_solver_subtract(solver, w.r, alpha, w.v);
    if (!isfinite(norm)) break;
    if (norm > best && solver->r_norm == best) memcpy(vectors[SPHI_VECTOR_BEST], x, bytes);
    if (norm < best) best = norm;
    double beta = 0;
    if (norm > solver->target) {
      const double last = rho;
      solver->preconditioner->apply(solver, w.r, w.z);
      products(solver, &w, &rho, &zv, &zz);
      beta = -alpha * zv / last;
      sound = rho > nothing * norm * sqrt(zz) && isfinite(zz);
    }
    advance(solver, &w, alpha, beta);
    solver->r_norm = norm;
  }
  if (solver->r_norm > best) memcpy(x, vectors[SPHI_VECTOR_BEST], bytes);
  return SPH_OK;
}

const sphi_solver_method sphi_solver_cg = {
    .name = "cg",
    .summary = "conjugate gradients, for symmetric positive definite matrices",
    .available = true,
    .iterate = iterate,
};
