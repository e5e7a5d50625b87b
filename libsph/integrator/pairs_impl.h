/* What the pair functions of particle methods share; included by op_*.c files only. */
#ifndef SPHI_PAIRS_IMPL_H
#define SPHI_PAIRS_IMPL_H

#include "sweep/pair.h"

/* gw of a pair of fluid and ghost: zero where the fluid does not see the ghost. */
SPHI_INLINE vreal ghost_gw(const int dim, const real *ghost, const pair *g) {
  int32_t away;
  memcpy(&away, ghost + SPHI_GHOST_GATES(dim), sizeof away);
  vreal gw = g->gw;
  if (!away) return gw;
  const real *gate = ghost + (int64_t)away * SPHI_GHOST(dim);
  const int gates = (int)*gate++;
  for (int k = 0; k < gates; k++, gate += dim + 1) {
    vreal side = v_set(gate[dim] * g->constants->per_metre);
    for (int d = 0; d < dim; d++) side += gate[d] * g->dx[d];
    gw = v_where(side > 0, gw);
  }
  return gw;
}

/* 1/rho of `count` targets as the pairs have it: by the volumes that they are weighted with, so that
 * forces balance. */
SPHI_INLINE vreal over_density(const int dim, const void *record, const double *m, int32_t first,
                               int32_t count) {
  const int stride = SPHI_RECORD(dim);
  const real *volume = (const real *)record + (int64_t)first * stride + SPHI_RECORD_V(dim);
  return pair_lanes(volume, stride, 0) / lanes_load(m + first, count, 1);
}

#endif
