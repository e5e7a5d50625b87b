/* Particles and cells: who is where, and the means of (1). */
#include <inttypes.h>

#include "flip/flip_impl.h"

enum { PARALLEL_FROM = 4096, LAYERS = 2 };

/* The cell of a point that may have come out of its cell; -1 outside. Walks lead to what is near, the
 * squares to what the caller has moved. */
static int32_t find(const sph_mesh *mesh, const double *x, int32_t hint, bool near,
                    int32_t *stopped_by) {
  double share[3];
  if (hint >= 0 && hint < mesh->cells && !near) {
    sphi_mesh_coordinates(mesh, hint, x, share);
    if (fmin(share[0], fmin(share[1], share[2])) >= -SPHI_MESH_EDGE) return hint;
    hint = -1;
  }
  return sphi_mesh_walk(mesh, x, hint, stopped_by);
}

sph_status sphi_flip_locate(sph_integrator *flow, bool moved) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  sph_particles *particles = flow->particles;
  const sph_mesh *mesh = s->mesh;
  const double begin = sphi_seconds();
  const int32_t n = particles->n;
  SPH_TRY(sphi_mesh_prepare(s->mesh));
  double **x = flip_field(flow, SPHI_X), *cell = flip_field(flow, s->field)[0];
  int32_t lost = INT32_MAX;
#pragma omp parallel for num_threads(context->threads) schedule(static) \
    reduction(min                                                       \
              : lost) if (n > PARALLEL_FROM)
  for (int32_t i = 0; i < n; i++) {
    const double at[2] = {x[0][i], x[1][i]};
    const double hint = cell[i];
    int32_t edge = -1;
    int32_t found =
        find(mesh, at, hint >= 0 && hint < mesh->cells ? (int32_t)hint : -1, moved, &edge);
    if (found < 0 && moved && edge >= 0) {
      double foot[2];
      found = mesh->side[2 * (int64_t)sphi_mesh_foot(mesh, at, edge, foot)];
    }
    if (found < 0 && i < lost) lost = i;
    cell[i] = found;
  }
  flow->stats.seconds_search += sphi_seconds() - begin;
  SPH_CHECK(context, lost == INT32_MAX, SPH_E_ARGUMENT,
            "flip: the mesh does not cover particles \"%s\": particle %" PRId64 " is at (%g, %g) m",
            particles->name, particles->id[lost], x[0][lost], x[1][lost]);
  return SPH_OK;
}

/* Places in `order` by counting; storage follows when it goes back at every sixteenth place. */
sph_status sphi_flip_sort(sph_integrator *flow) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  sph_particles *particles = flow->particles;
  const int32_t n = particles->n, cells = s->mesh->cells;
  const double begin = sphi_seconds(), *cell = flip_field(flow, s->field)[0];
  SPH_CHECK(
      context,
      sphi_reserve(context, (void **)&s->cell, &s->cell_capacity, n, sizeof *s->cell) &&
          sphi_reserve(context, (void **)&s->order, &s->order_capacity, n, sizeof *s->order) &&
          sphi_reserve(context, (void **)&s->left, &s->left_capacity, n, sizeof *s->left),
      SPH_E_MEMORY, "flip: no memory for %d particles", n);
  memset(s->start, 0, ((size_t)cells + 1) * sizeof *s->start);
  for (int32_t i = 0; i < n; i++) {
    s->cell[i] = (int32_t)cell[i];
    s->start[s->cell[i]]++;
  }
  for (int32_t c = 0; c < cells; c++) s->start[c + 1] += s->start[c];
  for (int32_t i = n - 1; i >= 0; i--) s->order[--s->start[s->cell[i]]] = i;
  int32_t jumps = 0;
  for (int32_t k = 1; k < n; k++) jumps += s->order[k] < s->order[k - 1];
  if (jumps > n / 16) {
    sphi_particles_permute(particles, s->order);
    for (int32_t k = 0; k < n; k++) {
      s->order[k] = k;
      s->cell[k] = (int32_t)cell[k];
    }
    flow->stats.builds++;
  }
  flow->stats.seconds_sort += sphi_seconds() - begin;
  return SPH_OK;
}

static void mean_of_cell(const sph_integrator *flow, int32_t c) {
  const flip *s = flip_of(flow);
  const double *rho = flip_field(flow, SPHI_RHO)[0], *m = flip_field(flow, SPHI_M)[0];
  const double *volume = flip_field(flow, SPHI_VOL)[0];
  double **v = flip_field(flow, SPHI_V), **x = flip_field(flow, SPHI_X);
  double density = 0, u[2] = {0}, mass = 0, filled = 0, middle[2] = {0}, share[3] = {0},
         lo = HUGE_VAL, hi = 0;
  for (int64_t k = s->start[c]; k < s->start[c + 1]; k++) {
    const int32_t i = s->order[k];
    const double weight = s->mass_weighted ? m[i] : 1;
    density += rho[i];
    filled += volume[i];
    mass += weight;
    for (int d = 0; d < 2; d++) {
      u[d] += weight * v[d][i];
      middle[d] += volume[i] * x[d][i];
    }
    lo = rho[i] < lo ? rho[i] : lo;
    hi = rho[i] > hi ? rho[i] : hi;
  }
  const int64_t count = s->start[c + 1] - s->start[c];
  for (int d = 0; d < 2 && filled > 0; d++) middle[d] /= filled;
  if (filled > 0) sphi_mesh_coordinates(s->mesh, c, middle, share); /* hats are linear */
  for (int k = 0; k < 3; k++) s->volume[3 * (int64_t)c + k] = filled * share[k];
  s->filled[c] = count > 0;
  s->mixed[c] = hi - lo > 1e-3 * (s->density[1] - s->density[0]);
  if (count == 0) return;
  s->rho[c] = density / (double)count;
  for (int d = 0; d < 2; d++) s->u[d][c] = u[d] / mass;
}

/* Cells without particles take the mean of neighbours that have values, layer by layer: those filled in
 * one pass count from the next on. */
static void fill_empty(flip *s) {
  const sph_mesh *mesh = s->mesh;
  bool some = true;
  for (uint8_t pass = 1; some && pass < UINT8_MAX; pass++) {
    some = false;
    for (int32_t c = 0; c < mesh->cells; c++) {
      if (s->filled[c]) continue;
      double rho = 0, u[2] = {0};
      int count = 0;
      for (int k = 0; k < 3; k++) {
        const int32_t b = mesh->neighbour[3 * (int64_t)c + k];
        if (b < 0 || !s->filled[b] || s->filled[b] > pass) continue;
        rho += s->rho[b];
        for (int d = 0; d < 2; d++) u[d] += s->u[d][b];
        count++;
      }
      if (count == 0) continue;
      s->rho[c] = rho / count;
      for (int d = 0; d < 2; d++) s->u[d][c] = u[d] / count;
      s->filled[c] = (uint8_t)(pass + 1);
      some = true;
    }
  }
  for (int32_t c = 0; c < mesh->cells; c++) { /* farther from all particles than that */
    if (s->filled[c]) continue;
    s->rho[c] = s->density[0];
    s->u[0][c] = s->u[1][c] = 0;
  }
}

/* Cells with both fluids, and those within some layers of nodes around them. */
static void mark_interface(flip *s) {
  const sph_mesh *mesh = s->mesh;
  memcpy(s->smooth, s->mixed, (size_t)mesh->cells);
  for (int layer = 0; layer < LAYERS; layer++) {
    memset(s->near, 0, (size_t)mesh->nodes);
    for (int64_t k = 0; k < 3 * (int64_t)mesh->cells; k++)
      if (s->smooth[k / 3]) s->near[mesh->corner[k]] = 1;
    for (int64_t k = 0; k < 3 * (int64_t)mesh->cells; k++)
      if (s->near[mesh->corner[k]]) s->smooth[k / 3] = 1;
  }
}

void sphi_flip_gather(sph_integrator *flow) {
  flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  const double begin = sphi_seconds();
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->cells > PARALLEL_FROM)
  for (int32_t c = 0; c < mesh->cells; c++) mean_of_cell(flow, c);
  sph_flip_stats *stats = &s->stats;
  stats->mixed_cells = stats->empty_cells = stats->most = 0;
  stats->fewest = flow->particles->n;
  for (int32_t c = 0; c < mesh->cells; c++) {
    const int64_t count = s->start[c + 1] - s->start[c];
    stats->empty_cells += count == 0;
    if (count < stats->fewest) stats->fewest = count;
    if (count > stats->most) stats->most = count;
  }
  if (stats->empty_cells > 0) fill_empty(s);
  if (s->spreads) sphi_flip_spread_density(flow);
  for (int32_t c = 0; c < mesh->cells; c++) stats->mixed_cells += s->mixed[c];
  if (stats->mixed_cells > 0)
    mark_interface(s);
  else
    memset(s->smooth, 0, (size_t)mesh->cells);
  flow->stats.seconds_pack += sphi_seconds() - begin;
}
