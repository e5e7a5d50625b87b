/* First pass over the pairs of delta-SPH, METHODS: Huang et al. (2019) eq. (6):
 *
 *   M_i = sum_j V_j x_ji (x) grad_i W_ij,   L_i = M_i^-1                                     (1)
 *   <grad rho>_i^L = L_i sum_j (rho_j - rho_i) grad_i W_ij V_j                               (2)
 *   D_i = sum_j (u_j - u_i) . grad_i W_ij V_j                                                (3)
 *
 * (1) and (2) over the fluid only: with one-sided support the pair terms of the density diffusion
 * still cancel for a linear density. (3) over fluid and ghosts.
 */
#define OPERATOR gradient
#define OP_BARE 1
#define OP_PRUNES 1
#include "integrator/pairs_impl.h"
#include "wcsph/ops.h"

typedef sphi_gradient_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal v[3], d;
} op_targets;

typedef struct op_sums {
  vreal m[6]; /* xx yy xy | xx yy zz xy xz yz */
  vreal b[3];
  vreal divergence;
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)first;
  for (int d = 0; d < dim; d++) t->v[d] = pair_lanes(record, stride, SPHI_RECORD_F(dim) + 1 + d);
  t->d = pair_lanes(record, stride, SPHI_RECORD_D(dim));
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  vreal gradient[3];
  pair_gradient(dim, g->gw, source[SPHI_RECORD_V(dim)], g, gradient);
  const real *v = source + SPHI_RECORD_F(dim) + 1;
  const vreal difference = source[SPHI_RECORD_D(dim)] - t->d;
  /* x_ji (x) grad W = -dx (x) grad W; the sign is put in at the end. */
  for (int d = 0; d < dim; d++) {
    s->divergence += (v[d] - t->v[d]) * gradient[d];
    s->b[d] += difference * gradient[d];
    s->m[d] += gradient[d] * g->dx[d];
  }
  s->m[dim] += gradient[0] * g->dx[1];
  if (dim == 3) {
    s->m[4] += gradient[0] * g->dx[2];
    s->m[5] += gradient[1] * g->dx[2];
  }
}

SPHI_INLINE void op_pair_second(const op_arguments *a, const int dim, const op_targets *t,
                                const real *source, const pair *g, op_sums *s) {
  (void)a;
  vreal gradient[3];
  pair_gradient(dim, ghost_gw(dim, source, g), source[SPHI_RECORD_V(dim)], g, gradient);
  const real *v = source + SPHI_RECORD_F(dim) + 1;
  for (int d = 0; d < dim; d++) s->divergence += (v[d] - t->v[d]) * gradient[d];
}

SPHI_INLINE void op_metres(const int dim, const pair_units *units, op_sums *s) {
  const real once = (real)(units->slope * units->length);
  const real twice = (real)(units->slope * units->length * units->length);
  s->divergence *= once;
  for (int d = 0; d < dim; d++) s->b[d] *= once;
  for (int k = 0; k < (dim == 2 ? 3 : 6); k++) s->m[k] *= twice;
}

/* Smallest eigenvalue of {xx yy xy}. */
SPHI_INLINE vreal smallest_eigenvalue_2(const vreal m[3]) {
  const vreal half = (real)0.5 * (m[0] - m[1]);
  return (real)0.5 * (m[0] + m[1]) - v_sqrt(half * half + m[2] * m[2]);
}

/* Smallest eigenvalue of {xx yy zz xy xz yz} by the trigonometric solution of its cubic. */
static double exact_eigenvalue_3(const double m[6]) {
  const double mean = (m[0] + m[1] + m[2]) / 3;
  const double a = m[0] - mean, b = m[1] - mean, c = m[2] - mean;
  const double off = m[3] * m[3] + m[4] * m[4] + m[5] * m[5];
  const double p = sqrt((a * a + b * b + c * c + 2 * off) / 6);
  if (p < 1e-12) return mean;
  const double determinant =
      a * (b * c - m[5] * m[5]) - m[3] * (m[3] * c - m[5] * m[4]) + m[4] * (m[3] * m[5] - b * m[4]);
  double cosine = determinant / (2 * p * p * p);
  cosine = cosine < -1 ? -1 : cosine > 1 ? 1 : cosine;
  return mean + 2 * p * cos(acos(cosine) / 3 + 2.0943951023931953);
}

/* The same, or a lower bound where that is above 1/2, by Gershgorin's circles: nobody asks what exactly
 * it is in there, and the exact one is dear. */
SPHI_INLINE vreal smallest_eigenvalue_3(const vreal m[6], int32_t count) {
  const vreal xy = v_abs(m[3]), xz = v_abs(m[4]), yz = v_abs(m[5]);
  const vreal x = m[0] - xy - xz, y = m[1] - xy - yz, z = m[2] - xz - yz;
  const vreal xy_least = v_select(x < y, x, y);
  vreal lambda = v_select(xy_least < z, xy_least, z);
  if (!v_bits_less(lambda, v_set((real)0.5))) return lambda;
  for (int32_t l = 0; l < count; l++) {
    if (lambda[l] >= (real)0.5) continue;
    double one[6];
    for (int k = 0; k < 6; k++) one[k] = (double)m[k][l];
    lambda[l] = (real)exact_eigenvalue_3(one);
  }
  return lambda;
}

SPHI_INLINE void solve_2(const vreal m[3], const vreal b[2], vreal g[2]) {
  const vreal over = 1 / (m[0] * m[1] - m[2] * m[2]);
  g[0] = over * (m[1] * b[0] - m[2] * b[1]);
  g[1] = over * (m[0] * b[1] - m[2] * b[0]);
}

SPHI_INLINE void solve_3(const vreal m[6], const vreal b[3], vreal g[3]) {
  const vreal c00 = m[1] * m[2] - m[5] * m[5], c01 = m[4] * m[5] - m[3] * m[2];
  const vreal c02 = m[3] * m[5] - m[1] * m[4], c11 = m[0] * m[2] - m[4] * m[4];
  const vreal c12 = m[3] * m[4] - m[0] * m[5], c22 = m[0] * m[1] - m[3] * m[3];
  const vreal over = 1 / (m[0] * c00 + m[3] * c01 + m[4] * c02);
  g[0] = over * (c00 * b[0] + c01 * b[1] + c02 * b[2]);
  g[1] = over * (c01 * b[0] + c11 * b[1] + c12 * b[2]);
  g[2] = over * (c02 * b[0] + c12 * b[1] + c22 * b[2]);
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  vreal m[6], g[3];
  for (int k = 0; k < (dim == 2 ? 3 : 6); k++) m[k] = -s->m[k];
  const vreal lambda = dim == 2 ? smallest_eigenvalue_2(m) : smallest_eigenvalue_3(m, count);
  lanes_store((real *)a->divergence + first, count, s->divergence);
  if (a->lambda) lanes_store((real *)a->lambda + first, count, lambda);
  if (!a->record) return;
  if (dim == 2)
    solve_2(m, s->b, g);
  else
    solve_3(m, s->b, g);
  real *record = (real *)a->record + (int64_t)first * SPHI_RECORD(dim) + SPHI_RECORD_G(dim);
  for (int d = 0; d < dim; d++) {
    g[d] = v_where(lambda >= (real)a->lambda_min, g[d]);
    for (int32_t l = 0; l < count; l++) record[l * SPHI_RECORD(dim) + d] = g[d][l];
  }
}

#include "sweep/pair_loop.inc.c"
