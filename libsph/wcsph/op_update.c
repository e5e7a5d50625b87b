/* What a step does to each particle alone, without neighbours: state, equation of state and records in
 * one pass over memory. A chunk of particles goes through short plain loops whose intermediate values
 * stay in the nearest cache; that is what compilers turn into vector instructions. */
#include "sweep/pair.h"
#include "wcsph/wcsph_impl.h"

enum { CHUNK = 32, FOLD = 8 };

typedef sphi_update_arguments update;

/* The state of the particles first .. first + count - 1. */
typedef struct chunk {
  int32_t first, count;
  const double *x[SPHI_MAX_DIM], *v[SPHI_MAX_DIM], *rho;
  double *p, *volume;
} chunk;

static const real zeros[CHUNK];

/* A chunk of an array of reals; zeros where there is none. */
SPHI_INLINE const real *reals(const void *array, int32_t first) {
  return array ? (const real *)array + first : zeros;
}

SPHI_INLINE void equation_of_state(const update *a, const chunk *c) {
  const double *restrict m = a->m + c->first;
  const double *restrict rho = c->rho;
  double *restrict p = c->p, *restrict volume = c->volume;
  const double rho0 = a->rho0, stiffness = a->stiffness;
  for (int i = 0; i < c->count; i++) volume[i] = m[i] / rho[i];
  if (a->gamma == 0) {
    for (int i = 0; i < c->count; i++) p[i] = stiffness * (rho[i] - rho0);
  } else if (a->gamma == 7) { /* water; a general power takes longer than all the rest */
    for (int i = 0; i < c->count; i++) {
      const double ratio = rho[i] / rho0, ratio2 = ratio * ratio;
      p[i] = stiffness * (ratio2 * ratio2 * ratio2 * ratio - 1);
    }
  } else {
    for (int i = 0; i < c->count; i++) p[i] = stiffness * (pow(rho[i] / rho0, a->gamma) - 1);
  }
}

/* Records of a chunk: all values, or positions, volume and pressure alone. */
SPHI_INLINE void write_records(const update *a, const int dim, const bool all, const chunk *c) {
  const int stride = SPHI_RECORD(dim);
  real *restrict record = (real *)a->record + (int64_t)c->first * stride;
  fixed place[SPHI_MAX_DIM][CHUNK];
  real value[SPHI_MAX_DIM + 3][CHUNK];
  for (int d = 0; d < dim; d++) {
#if SPHI_DOUBLE
    memcpy(place[d], c->x[d], (size_t)c->count * sizeof place[d][0]);
#else
    for (int i = 0; i < c->count; i++) place[d][i] = sphi_frame_fix(a->frame, d, c->x[d][i]);
#endif
  }
  for (int i = 0; i < c->count; i++) {
    value[0][i] = (real)c->volume[i];
    value[1][i] = (real)c->p[i];
  }
  if (all) {
    for (int d = 0; d < dim; d++)
      for (int i = 0; i < c->count; i++) value[2 + d][i] = (real)c->v[d][i];
    for (int i = 0; i < c->count; i++) value[2 + dim][i] = (real)(c->rho[i] - a->rho0);
  }
  for (int i = 0; i < c->count; i++, record += stride) {
    for (int d = 0; d < dim; d++) memcpy(record + d, &place[d][i], sizeof place[d][i]);
    for (int k = 0; k < (all ? dim + 3 : 2); k++) record[dim + k] = value[k][i];
  }
}

/* Where the records have particle i: the fields hold the state at the start of a Runge-Kutta step. */
SPHI_INLINE double recorded_place(const update *a, const int dim, int32_t i, int d) {
  fixed place;
  memcpy(&place, (const real *)a->record + (int64_t)i * SPHI_RECORD(dim) + d, sizeof place);
#if SPHI_DOUBLE
  return place;
#else
  const double x = a->x[d][i];
  return x + a->frame->unit[d] * (double)(int32_t)(place - sphi_frame_fix(a->frame, d, x));
#endif
}

/* The body force where the records have the particles. */
SPHI_INLINE void body_force(const update *a, const int dim, int32_t first, int32_t count,
                            double (*force)[CHUNK]) {
  for (int d = 0; d < dim; d++)
    for (int i = 0; i < count; i++) force[d][i] = a->force.constant[d];
  for (int i = 0; i < count && a->force.function; i++) {
    double f[SPHI_MAX_DIM] = {0}, at[SPHI_MAX_DIM];
    for (int d = 0; d < dim; d++) at[d] = recorded_place(a, dim, first + i, d);
    a->force.function(a->time, at, f, a->force.user);
    for (int d = 0; d < dim; d++) force[d][i] += f[d];
  }
}

/* The first particle whose acceleration is not finite or density not positive, INT32_MAX if none: a
 * later evaluation would spread them over its neighbours. */
SPHI_INLINE int32_t first_bad(int32_t first, int32_t count, const double *push2,
                              const double *rho) {
  int64_t wrong = 0;
  for (int i = 0; i < count; i++) wrong += ((push2[i] < HUGE_VAL) & (rho[i] > 0)) ? 0 : 1;
  if (!wrong) return INT32_MAX;
  int32_t i = 0;
  while (push2[i] < HUGE_VAL && rho[i] > 0) i++;
  return first + i;
}

/* One Runge-Kutta stage. Its velocities are v + next * push, so that positions follow from the pushes of
 * the stages before; only these are kept, in the precision of the pair sums, whose rounding theirs adds
 * little to: they enter the state, which stays in double, times a part of a step. */
SPHI_INLINE int32_t stage_chunk(const update *a, const int dim, const bool initial,
                                const bool final, int32_t first, int32_t count) {
  const int stride = SPHI_RECORD(dim);
  const double next = a->next, past = a->past;
  double force[SPHI_MAX_DIM][CHUNK], push2[CHUNK], rho_now[CHUNK];
  double x_new[SPHI_MAX_DIM][CHUNK], v_new[SPHI_MAX_DIM][CHUNK], rho_new[CHUNK];
  body_force(a, dim, first, count, force);
  const real *record = (const real *)a->record + (int64_t)first * stride + SPHI_RECORD_D(dim);
  for (int i = 0; i < count; i++) rho_now[i] = a->rho0 + (double)record[(int64_t)i * stride];
  {
    double *restrict rho = a->rho + first;
    real *restrict rho_sum = (real *)a->rho_sum + first;
    const real *restrict divergence = reals(a->divergence, first);
    const real *restrict diffusion = reals(a->diffusion, first);
    for (int i = 0; i < count; i++) {
      const double rate = (double)diffusion[i] - rho_now[i] * (double)divergence[i];
      const double sum = initial ? 0 : (double)rho_sum[i];
      rho_new[i] = rho[i] + next * rate + (final ? past * sum : 0);
      if (!final) rho_sum[i] = (real)(initial ? rate : sum + 2 * rate);
      if (final) rho[i] = rho_new[i];
      push2[i] = 0;
    }
  }
  for (int d = 0; d < dim; d++) {
    double *restrict x = a->x[d] + first, *restrict v = a->v[d] + first;
    double *restrict acceleration = a->acceleration[d] + first;
    real *restrict push_sum = (real *)a->sum[d] + first;
    real *restrict push_first = (real *)a->first[d] + first;
    const real *restrict pressure = reals(a->push[d], first);
    const real *restrict viscous = reals(a->viscous[d], first);
    const double drift = a->drift, drift_sum = a->drift_sum, drift_first = a->drift_first;
    for (int i = 0; i < count; i++) {
      const double along = force[d][i] + (double)pressure[i];
      const double push = along + (double)viscous[i];
      const double sum = initial ? 0 : (double)push_sum[i];
      const double before = initial ? 0 : drift_sum * sum + drift_first * (double)push_first[i];
      x_new[d][i] = x[i] + drift * v[i] + before;
      v_new[d][i] = v[i] + next * push + (final ? past * sum : 0);
      push2[i] += push * push;
      if (initial) push_first[i] = (real)push;
      if (!final) push_sum[i] = (real)(initial ? push : sum + 2 * push);
      if (final) {
        x[i] = x_new[d][i];
        v[i] = v_new[d][i];
        acceleration[i] = along;
      }
    }
  }
  const int32_t bad = first_bad(first, count, push2, rho_now);
  if (bad < INT32_MAX) { /* what the report tells */
    for (int d = 0; d < dim; d++)
      a->acceleration[d][bad] = force[d][bad - first] + (double)((const real *)a->push[d])[bad] +
                                (double)((const real *)a->viscous[d])[bad];
    a->rho[bad] = rho_now[bad - first];
    return bad;
  }
  if (final) return INT32_MAX;
  double p[CHUNK], volume[CHUNK];
  chunk c = {.first = first, .count = count, .rho = rho_new, .p = p, .volume = volume};
  for (int d = 0; d < dim; d++) {
    c.x[d] = x_new[d];
    c.v[d] = v_new[d];
  }
  equation_of_state(a, &c);
  write_records(a, dim, true, &c);
  return INT32_MAX;
}

/* Velocities by accelerations; these by the pushes if there are any. */
SPHI_INLINE int32_t kick_chunk(const update *a, const int dim, int32_t first, int32_t count) {
  const double next = a->next;
  double force[SPHI_MAX_DIM][CHUNK], push2[CHUNK];
  for (int i = 0; i < count; i++) push2[i] = 0;
  body_force(a, dim, first, count, force);
  for (int d = 0; d < dim; d++) {
    double *restrict v = a->v[d] + first, *restrict acceleration = a->acceleration[d] + first;
    const real *restrict push = reals(a->push[d], first);
    if (a->push[d])
      for (int i = 0; i < count; i++) acceleration[i] = force[d][i] + (double)push[i];
    for (int i = 0; i < count; i++) {
      v[i] += next * acceleration[i];
      push2[i] += acceleration[i] * acceleration[i];
    }
  }
  return first_bad(first, count, push2, a->rho + first);
}

SPHI_INLINE double largest(const double *value, int32_t count) {
  double most[FOLD] = {0};
  int32_t i = 0;
  for (; i + FOLD <= count; i += FOLD)
    for (int l = 0; l < FOLD; l++) most[l] = value[i + l] > most[l] ? value[i + l] : most[l];
  for (; i < count; i++) most[0] = value[i] > most[0] ? value[i] : most[0];
  for (int l = 1; l < FOLD; l++) most[0] = most[l] > most[0] ? most[l] : most[0];
  return most[0];
}

/* Extremes after a step. Returns the first particle that is fast, far away, or not finite. */
SPHI_INLINE int32_t check_chunk(const update *a, const int dim, const chunk *c,
                                sphi_extremes *extremes) {
  double speed2[CHUNK], push2[CHUNK];
  int64_t good[CHUNK], wrong = 0;
  for (int i = 0; i < c->count; i++) {
    speed2[i] = push2[i] = 0;
    good[i] = ((c->rho[i] > 0) & (c->rho[i] < HUGE_VAL)) ? 1 : 0;
  }
  for (int d = 0; d < dim; d++) {
    const double *restrict acceleration = a->acceleration[d] + c->first;
    const double *restrict x = c->x[d], *restrict v = c->v[d];
    const double lo = a->lo[d], hi = a->hi[d];
    for (int i = 0; i < c->count; i++) {
      speed2[i] += v[i] * v[i];
      push2[i] += acceleration[i] * acceleration[i];
      good[i] = ((x[i] >= lo) & (x[i] <= hi)) ? good[i] : 0;
    }
  }
  for (int i = 0; i < c->count; i++) {
    good[i] = ((speed2[i] <= a->most2) & (push2[i] < HUGE_VAL)) ? good[i] : 0;
    wrong += 1 - good[i];
  }
  extremes->speed2 = fmax(extremes->speed2, largest(speed2, c->count));
  extremes->acceleration2 = fmax(extremes->acceleration2, largest(push2, c->count));
  if (!wrong) return INT32_MAX;
  int32_t i = 0;
  while (good[i]) i++;
  return c->first + i;
}

/* Positions and densities on, then pressures and records. */
SPHI_INLINE int32_t move_chunk(const update *a, const int dim, int32_t first, int32_t count,
                               sphi_extremes *extremes) {
  double p[CHUNK], volume[CHUNK];
  chunk c = {.first = first,
             .count = count,
             .rho = a->rho + first,
             .p = a->p ? a->p + first : p,
             .volume = a->volume ? a->volume + first : volume};
  for (int d = 0; d < dim; d++) {
    double *restrict x = a->x[d] + first;
    const double *restrict v = a->v[d] + first;
    const double drift = a->drift;
    if (drift > 0)
      for (int i = 0; i < count; i++) x[i] += drift * v[i];
    c.x[d] = x;
    c.v[d] = v;
  }
  double *restrict rho = a->rho + first;
  if (a->divergence) {
    const real *restrict divergence = reals(a->divergence, first);
    for (int i = 0; i < count; i++) rho[i] -= a->next * rho[i] * (double)divergence[i];
  }
  if (a->diffusion) {
    const real *restrict diffusion = reals(a->diffusion, first);
    for (int i = 0; i < count; i++) rho[i] += a->next * (double)diffusion[i];
  }
  if (a->lambda) {
    const real *restrict lambda = reals(a->lambda, first);
    const double rho0 = a->rho0;
    for (int i = 0; i < count; i++)
      rho[i] = ((lambda[i] < (real)a->lambda_isolated) & (rho[i] < rho0)) ? rho0 : rho[i];
  }
  equation_of_state(a, &c);
  const int32_t bad = extremes ? check_chunk(a, dim, &c, extremes) : INT32_MAX;
  if (a->all)
    write_records(a, dim, true, &c);
  else
    write_records(a, dim, false, &c);
  return bad;
}

/* The loops for both dimensions: `call` does one chunk. */
#define UPDATE_LOOP(name, call)                                                        \
  SPHI_INLINE int32_t name(const update *a, const int dim, int32_t begin, int32_t end, \
                           sphi_extremes *extremes) {                                  \
    (void)extremes;                                                                    \
    int32_t bad = INT32_MAX;                                                           \
    for (int32_t first = begin; first < end; first += CHUNK) {                         \
      const int32_t count = end - first < CHUNK ? end - first : CHUNK;                 \
      const int32_t found = call;                                                      \
      if (found < bad) bad = found;                                                    \
    }                                                                                  \
    return bad;                                                                        \
  }
UPDATE_LOOP(initial_stage, stage_chunk(a, dim, true, false, first, count))
UPDATE_LOOP(middle_stage, stage_chunk(a, dim, false, false, first, count))
UPDATE_LOOP(final_stage, stage_chunk(a, dim, false, true, first, count))
UPDATE_LOOP(kick, kick_chunk(a, dim, first, count))
UPDATE_LOOP(move, move_chunk(a, dim, first, count, extremes))
#undef UPDATE_LOOP

#define UPDATE_STAMP(name)                                                                        \
  int32_t SPHI_NAME(sphi_##name##_update)(const void *arguments, int32_t begin, int32_t end);     \
  int32_t SPHI_NAME(sphi_##name##_update)(const void *arguments, int32_t begin, int32_t end) {    \
    const update *a = arguments;                                                                  \
    sphi_extremes *extremes = a->extremes ? &a->extremes[begin / UPDATE_BLOCK] : NULL;            \
    if (extremes) *extremes = (sphi_extremes){0, 0};                                              \
    const int32_t bad =                                                                           \
        a->frame->dim == 2 ? name(a, 2, begin, end, extremes) : name(a, 3, begin, end, extremes); \
    v_leave();                                                                                    \
    return bad;                                                                                   \
  }
UPDATE_STAMP(initial_stage)
UPDATE_STAMP(middle_stage)
UPDATE_STAMP(final_stage)
UPDATE_STAMP(kick)
UPDATE_STAMP(move)
#undef UPDATE_STAMP
