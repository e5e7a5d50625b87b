/* What a checkpoint keeps of a particle set. */
#include <inttypes.h>
#include <stdio.h>

#include "particles/particles_impl.h"

/* Ranks are places of their own, and ids ascend with them. */
static sph_status check_order(sph_particles *particles, sphi_keep *keep, int64_t next_id) {
  sph_context *context = particles->context;
  const int32_t n = keep->n;
  int64_t count;
  const int64_t *id = sphi_keep_find(keep, "particles/id", SPHI_KEEP_WHOLES, &count);
  const int32_t *rank = sphi_keep_find(keep, "particles/rank", SPHI_KEEP_INDICES, &count);
  int32_t *slot = particles->scratch;
  for (int32_t r = 0; r < n; r++) slot[r] = -1;
  for (int32_t k = 0; k < n; k++) {
    SPH_CHECK(context, rank[k] >= 0 && rank[k] < n && slot[rank[k]] < 0, SPH_E_ARGUMENT,
              "checkpoint \"%s\": section \"particles/rank\": %d at %d is no place of its own",
              keep->path, rank[k], k);
    slot[rank[k]] = k;
  }
  int64_t before = -1;
  for (int32_t r = 0; r < n; r++) {
    const int64_t now = id[slot[r]];
    SPH_CHECK(context, now > before && now < next_id, SPH_E_ARGUMENT,
              "checkpoint \"%s\": section \"particles/id\": %" PRId64 " follows %" PRId64
              " below %" PRId64,
              keep->path, now, before, next_id);
    before = now;
  }
  return SPH_OK;
}

static sph_status check_positive(const sph_particles *particles, sphi_keep *keep, int field) {
  char name[SPHI_KEEP_NAME];
  int64_t count;
  snprintf(name, sizeof name, "field/%s", particles->field[field].name);
  const double *values = sphi_keep_find(keep, name, SPHI_KEEP_REALS, &count);
  for (int32_t k = 0; k < keep->n; k++)
    SPH_CHECK(particles->context, values[k] > 0, SPH_E_ARGUMENT,
              "checkpoint \"%s\": section \"%s\": %g at %d must be > 0", keep->path, name,
              values[k], k);
  return SPH_OK;
}

/* How many there are, and room for them. */
static sph_status keep_count(sph_particles *particles, sphi_keep *keep, int64_t *n) {
  sph_context *context = particles->context;
  int64_t *const numbers[] = {n, &particles->next_id};
  SPH_TRY(sphi_keep_wholes(keep, "particles/counts", 2, numbers));
  if (keep->act != SPHI_KEEP_CHECK) return SPH_OK;
  int64_t count;
  const int64_t *there = sphi_keep_find(keep, "particles/counts", SPHI_KEEP_WHOLES, &count);
  SPH_CHECK(context, there[0] >= 1 && there[0] <= SPHI_MAX_PARTICLES, SPH_E_ARGUMENT,
            "checkpoint \"%s\": section \"particles/counts\": %" PRId64 " particles", keep->path,
            there[0]);
  SPH_CHECK(context, particles->leases->count == 0, SPH_E_ARGUMENT,
            "particles \"%s\": %" PRId64
            " leases are open, so that a checkpoint cannot be read; call sph_particles_release "
            "first",
            particles->name, particles->leases->count);
  *n = there[0];
  return SPH_OK;
}

sph_status sphi_particles_keep(sph_particles *particles, sphi_keep *keep) {
  const double dim = particles->dim;
  int64_t n = particles->n;
  SPH_TRY(sphi_keep_common(keep, "particles/dim", 1, &dim));
  SPH_TRY(sphi_keep_common(keep, "particles/spacing", 1, &particles->spacing));
  SPH_TRY(keep_count(particles, keep, &n));
  keep->n = (int32_t)n;
  SPH_TRY(sphi_keep_section(keep, "particles/id", SPHI_KEEP_WHOLES, n, particles->id));
  SPH_TRY(sphi_keep_section(keep, "particles/rank", SPHI_KEEP_INDICES, n, particles->rank));
  for (int f = 0; f < particles->fields; f++) {
    char name[SPHI_KEEP_NAME];
    const sphi_field *field = &particles->field[f];
    snprintf(name, sizeof name, "field/%s", field->name);
    for (int c = 0; c < field->components; c++) {
      if (field->components > 1) snprintf(name, sizeof name, "field/%s/%d", field->name, c);
      SPH_TRY(sphi_keep_section(keep, name, SPHI_KEEP_REALS, n, field->data[c]));
    }
  }
  if (keep->act == SPHI_KEEP_CHECK) {
    int64_t count;
    const int64_t *counts = sphi_keep_find(keep, "particles/counts", SPHI_KEEP_WHOLES, &count);
    SPH_TRY(check_positive(particles, keep, SPHI_RHO));
    SPH_TRY(check_positive(particles, keep, SPHI_M));
    SPH_TRY(check_positive(particles, keep, SPHI_VOL));
    SPH_CHECK(particles->context, sphi_particles_reserve(particles, n), SPH_E_MEMORY,
              "particles \"%s\": no memory for %" PRId64 " particles", particles->name, n);
    SPH_TRY(check_order(particles, keep, counts[1]));
  }
  if (keep->act == SPHI_KEEP_LOAD) {
    particles->n = (sph_index)n;
    for (sph_index k = 0; k < n; k++) particles->slot[particles->rank[k]] = k;
    particles->revision++;
  }
  return SPH_OK;
}
