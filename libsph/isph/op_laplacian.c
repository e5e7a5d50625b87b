/* Entries of the pressure equation, a pair each, METHODS: Schwaiger (2008), with the moments of op_projection:
 *
 *   a_ij = -2 s_i V_j (dW/dr)/r (1 + q_i . x_ij),   s_i = tr(M_i^-1) / dim,   q_i = M_i^-1 N_i   (1)
 *
 * For one pair sum_j a_ij (p_j - p_i) is the Laplacian of p. Lanes of a cluster lie together, its sources one
 * after the other, as the lists have them. With the open shares o in the place of densities in the records of the
 * fluid, sum_j a_ij o_j x_ji tells where the surface is, and particles there that are closer than dx and
 * approach get
 *
 *   B_i = sum_j max(o_i, o_j) V_j/(V_i + V_j) (1 - r/dx)+ (u_ji . x_ij)+ x_ij/r^2             (2)
 */
#define OPERATOR laplacian
#include "integrator/pairs_impl.h"
#include "isph/ops.h"

typedef sphi_laplacian_arguments op_arguments;
#define OP_STRIDE(dim) SPHI_RECORD(dim)
#define OP_STRIDE_SECOND(dim) SPHI_GHOST(dim)

typedef struct op_targets {
  vreal q[3], scale;
  vreal v[3], volume, open;
  real *out[2];
} op_targets;

typedef struct op_sums {
  int64_t done[2];
  vreal sum, count, up[3], collision[3];
} op_sums;

SPHI_INLINE void op_load(const op_arguments *a, const int dim, const real *record, const int stride,
                         int32_t first, op_targets *t) {
  t->volume = pair_lanes(record, stride, SPHI_RECORD_V(dim));
  t->open = pair_lanes(record, stride, SPHI_RECORD_D(dim));
  for (int d = 0; d < dim; d++) t->v[d] = pair_lanes(record, stride, SPHI_RECORD_F(dim) + 1 + d);
  for (int d = 0; d < dim; d++) t->q[d] = pair_lanes((const real *)a->q[d] + first, 1, 0);
  t->scale = pair_lanes((const real *)a->scale + first, 1, 0);
  for (int s = 0; s < 2; s++) t->out[s] = (real *)a->entry[s] + a->place[s][first];
}

SPHI_INLINE vreal add_pair(const int dim, const op_targets *t, const int list, real volume,
                           const pair *g, vreal gw, op_sums *s) {
  vreal tilt = v_set(1);
  for (int d = 0; d < dim; d++) tilt += t->q[d] * g->dx[d];
  const vreal entry = v_where(g->r2 > 0, -2 * volume * gw * t->scale * tilt);
  memcpy(t->out[list] + SPHI_LANES * s->done[list]++, &entry, sizeof entry);
  return entry;
}

SPHI_INLINE void op_pair(const op_arguments *a, const int dim, const op_targets *t,
                         const real *source, const pair *g, op_sums *s) {
  const vreal entry = add_pair(dim, t, 0, source[SPHI_RECORD_V(dim)], g, g->gw, s);
  s->sum += entry;
  s->count += v_where(entry != 0, v_set(1));
  const real dx = (real)a->spacing, volume = source[SPHI_RECORD_V(dim)];
  const real open = source[SPHI_RECORD_D(dim)], *v = source + SPHI_RECORD_F(dim) + 1;
  vreal approach = v_set(0);
  for (int d = 0; d < dim; d++) approach += (v[d] - t->v[d]) * g->dx[d];
  const vreal close = v_positive(1 - v_sqrt(g->r2) * (1 / dx)) * v_positive(approach);
  const vreal push = (open + v_positive(t->open - open)) * close * volume /
                     ((t->volume + volume) * (g->r2 + (real)1e-6 * dx * dx));
  for (int d = 0; d < dim; d++) {
    s->up[d] -= entry * open * g->dx[d];
    s->collision[d] += push * g->dx[d];
  }
}

SPHI_INLINE void op_pair_second(const op_arguments *a, const int dim, const op_targets *t,
                                const real *source, const pair *g, op_sums *s) {
  (void)a;
  (void)add_pair(dim, t, 1, source[SPHI_RECORD_V(dim)], g, ghost_gw(dim, source, g), s);
}

SPHI_INLINE void op_store(const op_arguments *a, const int dim, int32_t first, int32_t count,
                          const op_targets *t, const op_sums *s) {
  (void)t;
  lanes_store((real *)a->sum + first, count, s->sum);
  lanes_store((real *)a->count + first, count, s->count);
  for (int d = 0; d < dim; d++) {
    lanes_store((real *)a->up[d] + first, count, s->up[d]);
    lanes_store((real *)a->collision[d] + first, count, s->collision[d]);
  }
}

#include "sweep/pair_loop.inc.c"
