/* Stabilised biconjugate gradients, preconditioned from the right, so that r is the residual of x.
 *
 * Van der Vorst (1992), doi:10.1137/0913035. p_hat = M p, s_hat = M s:
 *
 *     v = A p_hat,  alpha = rho/(r0 . v),  s = r - alpha v                                          (1)
 *     t = A s_hat,  omega = t . s/t . t,   r = s - omega t,  x += alpha p_hat + omega s_hat         (2)
 *     beta = (rho'/rho) (alpha/omega),     p = r + beta (p - omega v)                               (3)
 */
#include "solver/solver_impl.h"

/* Products below this part of their factors' norms are rounding errors: the method has broken down. */
static const double nothing = 1e-14;

typedef struct run {
  double *x, *r, *p, *v, *p_hat, *s_hat, *t, *r_first;
  double rho, alpha, omega;
} run;

/* r = s - omega t; ||r|| and r0 . r. */
static double full_step(const sph_solver *solver, const run *w, double *rho) {
  const sphi_blocks *blocks = &solver->blocks;
  double norms[SPHI_SOLVER_MAX_BLOCKS], rhos[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double norm = 0, product = 0;
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      const double r = w->r[i] - w->omega * w->t[i];
      w->r[i] = r;
      norm += r * r;
      product += w->r_first[i] * r;
    }
    norms[k] = norm;
    rhos[k] = product;
  }
  *rho = sphi_block_sum(blocks, rhos);
  return sqrt(sphi_block_sum(blocks, norms));
}

/* x += alpha p_hat + omega s_hat, and (3). */
static void advance(const sph_solver *solver, const run *w, double beta) {
  const sphi_blocks *blocks = &solver->blocks;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++) {
      w->x[i] += w->alpha * w->p_hat[i] + w->omega * w->s_hat[i];
      w->p[i] = w->r[i] + beta * (w->p[i] - w->omega * w->v[i]);
    }
}

/* One step. False: the method broke down, and x is that of the last r_norm. */
static bool step(sph_solver *solver, run *w, double r_first_norm, double *best) {
  const size_t bytes = (size_t)solver->matrix.n * sizeof(double);
  double product, square;
  solver->preconditioner->apply(solver, w->p, w->p_hat);
  sphi_solver_multiply(solver, w->p_hat, w->v, w->r_first, &product, &square);
  if (!(fabs(product) > nothing * r_first_norm * sqrt(square)) || !isfinite(square)) return false;
  w->alpha = w->rho / product;
  const double s_norm = sphi_solver_subtract(solver, w->r, w->alpha, w->v);
  w->omega = 0;
  double rho = 0, norm = s_norm;
  bool sound = isfinite(s_norm);
  if (sound && s_norm > solver->target) {
    solver->preconditioner->apply(solver, w->r, w->s_hat);
    sphi_solver_multiply(solver, w->s_hat, w->t, w->r, &product, &square);
    sound = fabs(product) > nothing * s_norm * sqrt(square) && isfinite(square);
    if (sound) {
      w->omega = product / square;
      norm = full_step(solver, w, &rho);
      sound = isfinite(norm);
    }
  }
  if (!isfinite(norm)) return false;
  if (norm > *best && solver->r_norm == *best)
    memcpy(solver->vectors[SPHI_VECTOR_BEST], w->x, bytes);
  if (norm < *best) *best = norm;
  advance(solver, w, w->omega != 0 ? rho / w->rho * (w->alpha / w->omega) : 0);
  solver->r_norm = norm;
  sound = sound && fabs(rho) > nothing * r_first_norm * norm;
  w->rho = rho;
  return sound;
}

static sph_status iterate(sph_solver *solver, double *x) {
  double **vectors = solver->vectors;
  run w = {.x = x,
           .r = vectors[SPHI_VECTOR_R],
           .p = vectors[SPHI_VECTOR_P],
           .v = vectors[SPHI_VECTOR_V],
           .p_hat = vectors[SPHI_VECTOR_P_HAT],
           .s_hat = vectors[SPHI_VECTOR_S_HAT],
           .t = vectors[SPHI_VECTOR_T],
           .r_first = vectors[SPHI_VECTOR_R_FIRST]};
  const size_t bytes = (size_t)solver->matrix.n * sizeof(double);
  const double r_first_norm = solver->r_norm;
  memcpy(w.r_first, w.r, bytes);
  memcpy(w.p, w.r, bytes);
  memset(w.s_hat, 0, bytes);
  w.rho = r_first_norm * r_first_norm;
  double best = r_first_norm;
  while (solver->stats.iterations < solver->pause && solver->r_norm > solver->target) {
    solver->stats.iterations++;
    if (!step(solver, &w, r_first_norm, &best)) break;
  }
  if (solver->r_norm > best) memcpy(x, vectors[SPHI_VECTOR_BEST], bytes);
  return SPH_OK;
}

const sphi_solver_method sphi_solver_bicgstab = {
    .name = "bicgstab",
    .summary = "stabilised biconjugate gradients, for any matrix",
    .available = true,
    .iterate = iterate,
};
