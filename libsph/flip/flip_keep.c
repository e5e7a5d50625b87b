/* What a checkpoint keeps of the hybrid method: its mesh, what the next step starts from, what is measured. */
#include <inttypes.h>

#include "flip/flip_impl.h"
#include "solver/solver_impl.h"

static sph_status keep_stats(flip *s, sphi_keep *keep) {
  sph_flip_stats *stats = &s->stats;
  int64_t *const counts[] = {&stats->mixed_cells, &stats->empty_cells, &stats->fewest,
                             &stats->most,        &stats->entered,     &stats->left,
                             &stats->split,       &stats->merged};
  double *const numbers[] = {&stats->divergence, &stats->divergence_left, &s->rate, &s->usual};
  SPH_TRY(sphi_keep_wholes(keep, "flip/counts", sizeof counts / sizeof counts[0], counts));
  return sphi_keep_reals(keep, "flip/numbers", sizeof numbers / sizeof numbers[0], numbers);
}

/* Particles that the mesh has cells for. */
static sph_status check_cells(const sph_integrator *flow, sphi_keep *keep) {
  const int32_t cells = flip_of(flow)->mesh->cells;
  int64_t count;
  const double *cell = sphi_keep_find(keep, "field/cell", SPHI_KEEP_REALS, &count);
  for (int32_t k = 0; k < keep->n; k++)
    SPH_CHECK(flow->context, cell[k] >= 0 && cell[k] < cells && cell[k] == floor(cell[k]),
              SPH_E_ARGUMENT,
              "checkpoint \"%s\": section \"field/cell\": %g at %d is none of %d cells", keep->path,
              cell[k], k, cells);
  return SPH_OK;
}

sph_status sphi_flip_keep(sph_integrator *flow, sphi_keep *keep) {
  flip *s = flip_of(flow);
  const int64_t cells = s->mesh->cells, nodes = s->mesh->nodes;
  SPH_TRY(sphi_mesh_keep(s->mesh, keep));
  if (keep->act == SPHI_KEEP_CHECK) {
    SPH_TRY(check_cells(flow, keep));
    SPH_TRY(sphi_mesh_prepare(s->mesh));
  }
  SPH_TRY(keep_stats(s, keep));
  SPH_TRY(sphi_keep_section(keep, "flip/pressure", SPHI_KEEP_REALS, nodes, s->pressure));
  SPH_TRY(sphi_keep_section(keep, "flip/density", SPHI_KEEP_REALS, cells, s->rho));
  for (int d = 0; d < 2; d++) {
    static const char *const before[] = {"flip/before/0", "flip/before/1"};
    static const char *const after[] = {"flip/after/0", "flip/after/1"};
    SPH_TRY(sphi_keep_section(keep, before[d], SPHI_KEEP_REALS, cells, s->u[d]));
    SPH_TRY(sphi_keep_section(keep, after[d], SPHI_KEEP_REALS, cells, s->next[d]));
  }
  SPH_TRY(sphi_keep_section(keep, "flip/records", SPHI_KEEP_REALS,
                            cells * (int64_t)(sizeof *s->record / sizeof(double)), s->record));
  if (keep->act == SPHI_KEEP_CHECK) return SPH_OK;
  /* Both runs go on with preconditioners made anew. */
  sphi_solver_renumbered(s->solver);
  if (s->mass_solver) sphi_solver_renumbered(s->mass_solver);
  if (keep->act == SPHI_KEEP_WRITE) return SPH_OK;
  sphi_flip_measure(flow, 1);
  s->revision = flow->particles->revision;
  s->mesh_moves = s->mesh->revision;
  s->now_revision = -1;
  return SPH_OK;
}
