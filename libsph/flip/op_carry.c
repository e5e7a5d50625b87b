/* (5) and (6) for the particles that stay in their cell during a step: as many at a time as a register of 32 (baseline
 * 16) bytes holds, since cells have few particles, with the cell's record in registers. Those that leave it are marked, for sphi_flip_advance to do one by one. */
#include "flip/flip_impl.h"
#include "sweep/vreal.h"

#ifdef __AVX__
#define SOME 4
#else
#define SOME 2
#endif

typedef double some __attribute__((vector_size(SOME * sizeof(double))));
typedef int64_t mask __attribute__((vector_size(SOME * sizeof(int64_t))));

SPHI_INLINE some lesser(some a, some b) {
  const mask less = a < b;
  return (some)(((mask)a & less) | ((mask)b & ~less));
}

/* Barycentric coordinates of places; all ones where they are in the cell. */
SPHI_INLINE mask share_of(const flip_record *r, const some *x, some *share) {
  const some dx = x[0] - r->x[0], dy = x[1] - r->x[1];
  share[1] = r->g1[0] * dx + r->g1[1] * dy;
  share[2] = r->g2[0] * dx + r->g2[1] * dy;
  share[0] = 1 - share[1] - share[2];
  return lesser(lesser(share[0], share[1]), share[2]) >= -SPHI_MESH_EDGE;
}

SPHI_INLINE void mix(const double (*value)[2], const some *share, some *out) {
  const some least = lesser(lesser(share[0], share[1]), share[2]);
  for (int d = 0; d < 2; d++)
    out[d] = (share[0] - least) * value[0][d] + (share[1] - least) * value[1][d] +
             (share[2] - least) * value[2][d] + 3 * least * value[3][d];
}

/* Up to some particles of cell c, from place k of the order on. */
SPHI_INLINE void carry(const flip_carry *a, const flip_record *r, int32_t c, int64_t k,
                       int64_t count) {
  const int32_t *corner = a->corner + 3 * (int64_t)c;
  some x[2], v[2], share[3], u[2], kick[2], k2[2], k3[2], at[2];
  double from[4][SOME];
  for (int l = 0; l < SOME; l++) {
    const int32_t i = a->order[k + (l < count ? l : count - 1)];
    for (int d = 0; d < 2; d++) {
      from[d][l] = a->x[d][i];
      from[2 + d][l] = a->v[d][i];
    }
  }
  memcpy(x, from, sizeof x);
  memcpy(v, from + 2, sizeof v);
  mask stays = share_of(r, x, share);
  mix(r->u, share, u);
  mix(r->kick, share, kick);
  for (int d = 0; d < 2; d++) {
    v[d] = (1 - a->pic) * v[d] + kick[d];
    at[d] = x[d] + 0.5 * a->dt * u[d];
  }
  stays &= share_of(r, at, share);
  mix(r->u, share, k2);
  for (int d = 0; d < 2; d++) at[d] = x[d] + 0.75 * a->dt * k2[d];
  stays &= share_of(r, at, share);
  mix(r->u, share, k3);
  for (int d = 0; d < 2; d++) x[d] += a->dt / 9 * (2 * u[d] + 3 * k2[d] + 4 * k3[d]);
  stays &= share_of(r, x, share);
  const some p = share[0] * a->pressure[corner[0]] + share[1] * a->pressure[corner[1]] +
                 share[2] * a->pressure[corner[2]];
  const some size = (some)((mask)v[0] & INT64_MAX) + (some)((mask)v[1] & INT64_MAX);
  stays &= size < 1e100;
  for (int l = 0; l < SOME && l < count; l++) {
    const int32_t i = a->order[k + l];
    a->left[i] = !stays[l];
    if (!stays[l]) continue;
    for (int d = 0; d < 2; d++) {
      a->x[d][i] = x[d][l];
      a->v[d][i] = v[d][l];
    }
    a->p[i] = p[l];
  }
}

int32_t SPHI_NAME(sphi_carry_update)(const void *arguments, int32_t begin, int32_t end);
int32_t SPHI_NAME(sphi_carry_update)(const void *arguments, int32_t begin, int32_t end) {
  const flip_carry *a = arguments;
  for (int32_t c = begin; c < end; c++)
    for (int64_t k = a->start[c]; k < a->start[c + 1]; k += SOME)
      carry(a, &a->record[c], c, k, a->start[c + 1] - k);
  v_leave();
  return INT32_MAX;
}
