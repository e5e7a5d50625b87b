/* Flexible generalised minimal residuals: any matrix, and preconditioners that are not quite linear.
 *
 * Saad (1993), doi:10.1137/0914028. z_k = M v_k:
 *
 *     h_jk = v_j . A z_k (j <= k),  h_k+1,k v_k+1 = A z_k - sum_j h_jk v_j                          (1)
 *     x += sum_k y_k z_k,  y: || ||r|| e_0 - H y || least                                           (2)
 *
 * H becomes triangular by Givens' rotations as it grows, so that the residual is known at every step.
 */
#include "solver/solver_impl.h"

/* Directions of a cycle, after which the method starts again from its residual. */
enum { CYCLE = 30, TOGETHER = 4 };

/* A new direction that keeps less than this of its length is made orthogonal once more; less than that
 * is nothing but rounding errors. */
static const double much = 0.1, nothing = 1e-14;

/* Vectors are made as they are needed: most solves need few. */
typedef struct basis {
  int64_t rows;
  double *v[CYCLE + 1], *z[CYCLE];
} basis;

typedef struct cycle {
  double h[CYCLE][CYCLE + 1]; /* columns of H, triangular above the diagonal */
  double cosine[CYCLE], sine[CYCLE], g[CYCLE + 1];
  int count;
} cycle;

static void release(sph_solver *solver) {
  basis *b = solver->method_state;
  if (!b) return;
  for (int k = 0; k <= CYCLE; k++) sphi_free(solver->context, b->v[k]);
  for (int k = 0; k < CYCLE; k++) sphi_free(solver->context, b->z[k]);
  sphi_free(solver->context, b);
  solver->method_state = NULL;
}

/* Room for direction k of this solve's rows. */
static bool make_room(sph_solver *solver, int k) {
  basis *b = solver->method_state;
  if (b && b->rows < solver->matrix.n) release(solver);
  if (!solver->method_state) {
    b = solver->method_state = SPHI_NEW(solver->context, 1, basis);
    if (!b) return false;
    b->rows = solver->capacity;
  }
  b = solver->method_state;
  if (!b->v[0]) b->v[0] = SPHI_NEW(solver->context, b->rows, double);
  if (!b->z[k]) b->z[k] = SPHI_NEW(solver->context, b->rows, double);
  if (!b->v[k + 1]) b->v[k + 1] = SPHI_NEW(solver->context, b->rows, double);
  return b->v[0] && b->z[k] && b->v[k + 1];
}

/* h_j = v_j . w for `count` of them, in block k. Vectors that are missing are the first, for nothing. */
static void dots_of_block(const sphi_blocks *blocks, int k, double *const *v, int count,
                          const double *w, double *h) {
  const int64_t first = sphi_block_first(blocks, k), end = sphi_block_end(blocks, k);
  for (int j = 0; j < count; j += TOGETHER) {
    const double *v0 = v[j], *v1 = j + 1 < count ? v[j + 1] : v0;
    const double *v2 = j + 2 < count ? v[j + 2] : v0, *v3 = j + 3 < count ? v[j + 3] : v0;
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
    for (int64_t i = first; i < end; i++) {
      s0 += v0[i] * w[i];
      s1 += v1[i] * w[i];
      s2 += v2[i] * w[i];
      s3 += v3[i] * w[i];
    }
    h[j] = s0;
    h[j + 1] = s1;
    h[j + 2] = s2;
    h[j + 3] = s3;
  }
}

/* to += sum_j h_j v_j in block k. */
static void add_in_block(const sphi_blocks *blocks, int k, double *const *v, const double *h,
                         int count, double *restrict to) {
  const int64_t first = sphi_block_first(blocks, k), end = sphi_block_end(blocks, k);
  for (int j = 0; j < count; j += TOGETHER) {
    const double *v0 = v[j], *v1 = j + 1 < count ? v[j + 1] : v0;
    const double *v2 = j + 2 < count ? v[j + 2] : v0, *v3 = j + 3 < count ? v[j + 3] : v0;
    const double h0 = h[j], h1 = j + 1 < count ? h[j + 1] : 0;
    const double h2 = j + 2 < count ? h[j + 2] : 0, h3 = j + 3 < count ? h[j + 3] : 0;
    for (int64_t i = first; i < end; i++)
      to[i] += h0 * v0[i] + h1 * v1[i] + (h2 * v2[i] + h3 * v3[i]);
  }
}

/* Takes from w what it has of the first `count` directions, and adds that to h; ||w|| after. */
static double make_orthogonal(const sph_solver *solver, double *const *v, int count, double *w,
                              double *h) {
  const sphi_blocks *blocks = &solver->blocks;
  double parts[SPHI_SOLVER_MAX_BLOCKS][CYCLE + TOGETHER], minus[CYCLE];
  double squares[SPHI_SOLVER_MAX_BLOCKS];
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) dots_of_block(blocks, k, v, count, w, parts[k]);
  for (int j = 0; j < count; j++) {
    minus[j] = 0;
    for (int k = 0; k < blocks->count; k++) minus[j] -= parts[k][j];
    h[j] -= minus[j];
  }
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) {
    double square = 0;
    add_in_block(blocks, k, v, minus, count, w);
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++)
      square += w[i] * w[i];
    squares[k] = square;
  }
  return sqrt(sphi_block_sum(blocks, squares));
}

/* to = scale from */
static void scale_vector(const sph_solver *solver, double scale, const double *from, double *to) {
  const sphi_blocks *blocks = &solver->blocks;
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++)
    for (int64_t i = sphi_block_first(blocks, k); i < sphi_block_end(blocks, k); i++)
      to[i] = scale * from[i];
}

/* Turns column k of H, whose last entry is `below`, and the right-hand side. */
static void rotate(cycle *c, int k, double below) {
  double *h = c->h[k];
  for (int j = 0; j < k; j++) {
    const double upper = c->cosine[j] * h[j] + c->sine[j] * h[j + 1];
    h[j + 1] = c->cosine[j] * h[j + 1] - c->sine[j] * h[j];
    h[j] = upper;
  }
  const double size = hypot(h[k], below);
  c->cosine[k] = size > 0 ? h[k] / size : 1;
  c->sine[k] = size > 0 ? below / size : 0;
  h[k] = size;
  c->g[k + 1] = -c->sine[k] * c->g[k];
  c->g[k] *= c->cosine[k];
}

/* x += sum_k y_k z_k. */
static void advance(const sph_solver *solver, cycle *c, double *x) {
  const sphi_blocks *blocks = &solver->blocks;
  const basis *b = solver->method_state;
  double y[CYCLE];
  for (int k = c->count - 1; k >= 0; k--) {
    y[k] = c->g[k];
    for (int j = k + 1; j < c->count; j++) y[k] -= c->h[j][k] * y[j];
    y[k] /= c->h[k][k];
  }
#pragma omp parallel for num_threads(blocks->threads) schedule(static) if (blocks->threads > 1)
  for (int k = 0; k < blocks->count; k++) add_in_block(blocks, k, b->z, y, c->count, x);
}

/* One direction more. False: it has nothing new, and does not count unless it ends the residual. */
static bool step(sph_solver *solver, cycle *c) {
  const basis *b = solver->method_state;
  const int k = c->count;
  double *w = b->v[k + 1], unused, square, below;
  memset(c->h[k], 0, sizeof c->h[k]);
  solver->preconditioner->apply(solver, b->v[k], b->z[k]);
  sphi_solver_multiply(solver, b->z[k], w, b->v[k], &unused, &square);
  if (!isfinite(square)) return false;
  below = make_orthogonal(solver, b->v, k + 1, w, c->h[k]);
  if (below < much * sqrt(square)) below = make_orthogonal(solver, b->v, k + 1, w, c->h[k]);
  if (!(below > nothing * sqrt(square))) below = 0;
  rotate(c, k, below);
  if (!(c->h[k][k] > nothing * sqrt(square))) return false;
  c->count++;
  solver->r_norm = fabs(c->g[k + 1]);
  if (below > 0) scale_vector(solver, 1 / below, w, w);
  return below > 0;
}

/* Directions until the residual is small enough, no iteration is left for another one, or none is new. */
static sph_status run_cycle(sph_solver *solver, cycle *c) {
  c->count = 0;
  c->g[0] = solver->r_norm;
  while (c->count < CYCLE && solver->stats.iterations < solver->pause &&
         solver->r_norm > solver->target) {
    SPH_CHECK(solver->context, make_room(solver, c->count), SPH_E_MEMORY,
              "solver \"%s\": out of memory for direction %d of %lld rows", solver->method->name,
              c->count + 1, (long long)solver->matrix.n);
    const basis *b = solver->method_state;
    if (c->count == 0)
      scale_vector(solver, 1 / solver->r_norm, solver->vectors[SPHI_VECTOR_R], b->v[0]);
    solver->stats.iterations++;
    if (!step(solver, c)) break;
  }
  return SPH_OK;
}

static sph_status iterate(sph_solver *solver, double *x) {
  double last = HUGE_VAL;
  solver->scale = 1; /* directions have length 1 */
  while (solver->r_norm < last) {
    cycle c;
    last = solver->r_norm;
    const sph_status status = run_cycle(solver, &c);
    if (status != SPH_OK) { /* x as it was */
      memcpy(x, solver->vectors[SPHI_VECTOR_START], (size_t)solver->matrix.n * sizeof *x);
      return status;
    }
    advance(solver, &c, x);
    if (solver->stats.iterations >= solver->pause || solver->r_norm <= solver->target) break;
    solver->r_norm = sphi_solver_residual(solver, solver->b, x, solver->vectors[SPHI_VECTOR_R]);
  }
  return SPH_OK;
}

const sphi_solver_method sphi_solver_gmres = {
    .name = "gmres",
    .summary = "flexible generalised minimal residuals, for any matrix",
    .available = true,
    .iterate = iterate,
    .release = release,
};
