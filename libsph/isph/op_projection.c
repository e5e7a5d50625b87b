/* First pass over the pairs of incompressible SPH, over fluid and ghosts:
 *
 *   M_i = sum_j V_j x_ji (x) grad_i W_ij,   N_i = sum_j V_j grad_i W_ij                       (1)
 *   T_i = sum_j V_j (u_j - u_i) (x) grad_i W_ij                                               (2)
 *   C_i = sum_j V_j W_ij                                                                      (3)
 *
 * and the share of the ghosts in N. The trace of M is the divergence of positions, which tells the free surface.
 */
#define OPERATOR projection
#define OP_PRUNES 1
#include "integrator/pairs_impl.h"
#include "isph/ops.h"

typedef sphi_projection_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal v[3];
} op_targets;

typedef struct op_sums {
  vreal m[6]; /* xx yy xy | xx yy zz xy xz yz */
  vreal n[3];
  vreal shear[9], filling;
  vreal walls[3];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  (void)a, (void)first;
  for (int d = 0; d < dim; d++) t->v[d] = pair_lanes(record, stride, SPHI_RECORD_F(dim) + 1 + d);
}

/* Fluid and ghost records start alike, so one function serves both. */
SPHI_INLINE void add_pair(const int dim, const op_targets *t, const real *source, const pair *g,
                          vreal gw, op_sums *s) {
  vreal gradient[3];
  const real volume = source[SPHI_RECORD_V(dim)];
  pair_gradient(dim, gw, volume, g, gradient);
  const real *v = source + SPHI_RECORD_F(dim) + 1;
  for (int d = 0; d < dim; d++) {
    for (int e = 0; e < dim; e++) s->shear[d * dim + e] += (v[d] - t->v[d]) * gradient[e];
    s->n[d] += gradient[d];
    s->m[d] += gradient[d] * g->dx[d];
  }
  s->m[dim] += gradient[0] * g->dx[1];
  if (dim == 3) {
    s->m[4] += gradient[0] * g->dx[2];
    s->m[5] += gradient[1] * g->dx[2];
  }
  s->filling += volume * g->w;
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  (void)a;
  add_pair(dim, t, source, g, g->gw, s);
}

SPHI_INLINE void op_pair_second(const op_arguments *a, const int dim, const op_targets *t,
                                const real *source, const pair *g, op_sums *s) {
  (void)a;
  vreal gradient[3];
  const vreal gw = ghost_gw(dim, source, g);
  add_pair(dim, t, source, g, gw, s);
  pair_gradient(dim, gw, source[SPHI_RECORD_V(dim)], g, gradient);
  for (int d = 0; d < dim; d++) s->walls[d] += gradient[d];
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  for (int k = 0; k < dim * dim; k++) lanes_store((real *)a->shear[k] + first, count, s->shear[k]);
  lanes_store((real *)a->filling + first, count, s->filling);
  for (int d = 0; d < dim; d++) {
    lanes_store((real *)a->normal[d] + first, count, s->n[d]);
    lanes_store((real *)a->walls[d] + first, count, s->walls[d]);
  }
  for (int k = 0; k < (dim == 2 ? 3 : 6); k++)
    lanes_store((real *)a->moment[k] + first, count, -s->m[k]);
}

#include "sweep/pair_loop.inc.c"
