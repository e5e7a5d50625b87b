/* What a checkpoint keeps of walls and ghosts. Lists are none of it: they are made anew. */
#include <inttypes.h>
#include <stdio.h>

#include "boundary/boundary_impl.h"

/* Numbers of a wall's state; of a wet ghost: pressures and velocity. */
enum { STATE = 4 * SPHI_MAX_DIM + 1 + SPHI_MAX_DIM * SPHI_MAX_DIM + 6, VALUES = 2 + SPHI_MAX_DIM };

static sph_status keep_state(sph_boundary *boundary, int wall, sphi_keep *keep) {
  char name[SPHI_KEEP_NAME];
  sphi_wall_state *state = &boundary->state[wall];
  double turns = state->turns, *at[STATE];
  int n = 0;
  for (int d = 0; d < SPHI_MAX_DIM; d++) {
    double *const of_axis[] = {&state->displacement[d], &state->velocity[d],
                               &state->acceleration[d], &state->pivot[d],
                               &state->spin[d],         &state->spin_rate[d]};
    for (size_t k = 0; k < sizeof of_axis / sizeof of_axis[0]; k++) at[n++] = of_axis[k];
    for (int e = 0; e < SPHI_MAX_DIM; e++) at[n++] = &state->turn[d][e];
  }
  at[n++] = &turns;
  snprintf(name, sizeof name, "wall/%d/state", wall);
  SPH_TRY(sphi_keep_reals(keep, name, n, at));
  if (keep->act == SPHI_KEEP_LOAD) state->turns = turns != 0;
  return SPH_OK;
}

static sph_status keep_forces(sph_boundary *boundary, sphi_keep *keep) {
  double known = boundary->known;
  double *const numbers[] = {&boundary->evaluated, &boundary->before, &known};
  SPH_TRY(sphi_keep_reals(keep, "boundary/times", 3, numbers));
  if (keep->act == SPHI_KEEP_LOAD) boundary->known = known != 0;
  return sphi_keep_section(keep, "boundary/forces", SPHI_KEEP_REALS,
                           (int64_t)boundary->walls * SPHI_MAX_DIM, boundary->force);
}

static sph_status write_wet(const sph_boundary *boundary, sphi_keep *keep) {
  sph_context *context = boundary->context;
  const int32_t n = boundary->wet_count;
  int32_t *ghost = SPHI_NEW(context, 2 * (int64_t)n, int32_t);
  double *values = SPHI_NEW(context, (int64_t)n * VALUES, double);
  sph_status status = SPH_OK;
  if (!ghost || !values)
    status = SPHI_ERROR(context, SPH_E_MEMORY, "boundary: no memory for %d ghosts", n);
  for (int32_t k = 0; k < n && status == SPH_OK; k++) {
    const sphi_wet_ghost *wet = &boundary->wet[k];
    double *of = values + (int64_t)k * VALUES;
    ghost[k] = wet->ghost;
    ghost[n + k] = wet->rung;
    of[0] = wet->p;
    of[1] = wet->wall_pressure;
    memcpy(of + 2, wet->v, sizeof wet->v);
  }
  if (status == SPH_OK)
    status = sphi_keep_section(keep, "ghosts/which", SPHI_KEEP_INDICES, 2 * (int64_t)n, ghost);
  if (status == SPH_OK)
    status = sphi_keep_section(keep, "ghosts/values", SPHI_KEEP_REALS, (int64_t)n * VALUES, values);
  sphi_free(context, ghost);
  sphi_free(context, values);
  return status;
}

/* Wet ghosts that the boundary has, each once; and room for them. */
static sph_status check_wet(sph_boundary *boundary, sphi_keep *keep) {
  sph_context *context = boundary->context;
  const int64_t ghosts = boundary->points.n;
  int64_t twice = 0;
  const int32_t *which = sphi_keep_find(keep, "ghosts/which", SPHI_KEEP_INDICES, &twice);
  const int64_t n = twice / 2;
  SPH_CHECK(context, which && twice % 2 == 0 && n <= ghosts, SPH_E_ARGUMENT,
            "checkpoint \"%s\": section \"ghosts/which\" has %" PRId64
            " numbers, the flow has %" PRId64 " ghosts",
            keep->path, twice, ghosts);
  SPH_TRY(sphi_keep_section(keep, "ghosts/values", SPHI_KEEP_REALS, n * VALUES, NULL));
  if (boundary->ordered != ghosts) { /* of a flow that has not stepped */
    const bool in_use = boundary->in_use;
    SPH_TRY(sphi_boundary_prepare(boundary));
    boundary->in_use = in_use;
  }
  memset(boundary->near, 0, (size_t)ghosts * sizeof *boundary->near);
  for (int64_t k = 0; k < n; k++) {
    const bool fits = which[k] >= 0 && which[k] < ghosts && which[n + k] >= 0 &&
                      which[n + k] < SPH_BOUNDARY_TYPES && !boundary->near[which[k]];
    SPH_CHECK(context, fits, SPH_E_ARGUMENT,
              "checkpoint \"%s\": section \"ghosts/which\": ghost %d at %" PRId64
              " with rung %d, of %" PRId64 " ghosts",
              keep->path, which[k], k, which[n + k], ghosts);
    boundary->near[which[k]] = 1;
  }
  const int32_t before = boundary->mirrors.n;
  const sph_status status =
      sphi_gather_reserve_points(context, &boundary->mirrors, boundary->dim, (int32_t)n);
  boundary->mirrors.n = before;
  SPH_TRY(status);
  SPH_CHECK(context,
            sphi_reserve(context, (void **)&boundary->wet, &boundary->wet_capacity, n,
                         sizeof *boundary->wet),
            SPH_E_MEMORY, "boundary: no memory for %" PRId64 " ghosts", n);
  return SPH_OK;
}

static void load_wet(sph_boundary *boundary, sphi_keep *keep) {
  int64_t twice = 0, size = 0;
  const int32_t *which = sphi_keep_find(keep, "ghosts/which", SPHI_KEEP_INDICES, &twice);
  const double *values = sphi_keep_find(keep, "ghosts/values", SPHI_KEEP_REALS, &size);
  const int32_t n = (int32_t)(twice / 2);
  for (int64_t k = 0; k < boundary->points.n; k++) boundary->place[k] = -1;
  boundary->wet_count = boundary->mirrors.n = n;
  for (int32_t k = 0; k < n; k++) {
    const double *of = values + (int64_t)k * VALUES;
    sphi_wet_ghost *wet = &boundary->wet[k];
    sphi_boundary_make_wet(boundary, k, which[k]);
    wet->rung = (uint8_t)which[n + k];
    wet->p = of[0];
    wet->wall_pressure = of[1];
    memcpy(wet->v, of + 2, sizeof wet->v);
  }
}

sph_status sphi_boundary_keep(sph_boundary *boundary, sphi_keep *keep) {
  const double walls = boundary->walls, ghosts = (double)boundary->points.n;
  SPH_TRY(sphi_keep_common(keep, "boundary/walls", 1, &walls));
  SPH_TRY(sphi_keep_common(keep, "boundary/ghosts", 1, &ghosts));
  SPH_TRY(sphi_keep_common(keep, "boundary/spacing", 1, &boundary->spacing));
  for (int w = 0; w < boundary->walls; w++) {
    SPH_TRY(keep_state(boundary, w, keep));
    SPH_TRY(sphi_wall_keep(boundary->wall[w], w, keep));
  }
  if (keep->act == SPHI_KEEP_WRITE) SPH_TRY(write_wet(boundary, keep));
  if (keep->act == SPHI_KEEP_CHECK) SPH_TRY(check_wet(boundary, keep));
  if (keep->act == SPHI_KEEP_LOAD) {
    SPH_TRY(sphi_boundary_prepare(boundary)); /* needs no memory after the check */
    load_wet(boundary, keep);
  }
  return keep_forces(boundary, keep);
}
