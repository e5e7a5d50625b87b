/* Particles that come and go: the first ones, those that cells lack, those that they have too many of. */
#include <inttypes.h>

#include "flip/flip_impl.h"

enum { MOST_DIVISIONS = 16 };

/* Corners' shares of the middle of triangle k of divisions^2 equal ones: rows of upright triangles and of
 * those between them. */
static void middle_of(int divisions, int k, double *share) {
  int row = (int)sqrt((double)k);
  while (row * row > k) row--;
  while ((row + 1) * (row + 1) <= k) row++;
  const int place = k - row * row; /* 0 to 2 row, odd ones are upside down */
  const double size = 1.0 / divisions, third = place % 2 ? 2.0 / 3 : 1.0 / 3;
  share[1] = size * (place / 2 + third);
  share[2] = size * (row - place / 2 - (place % 2 ? 1 : 0) + third);
  share[0] = 1 - share[1] - share[2];
}

static void place_in(const sph_mesh *mesh, int32_t cell, const double *share, double *x) {
  const int32_t *corner = mesh->corner + 3 * (int64_t)cell;
  for (int d = 0; d < 2; d++) {
    x[d] = 0;
    for (int k = 0; k < 3; k++) x[d] += share[k] * mesh->x[2 * (int64_t)corner[k] + d];
  }
}

static sph_status check_fill(const sph_mesh *mesh, const sph_particles *particles, int divisions,
                             double below, double above) {
  sph_context *context = particles->context;
  SPH_CHECK(context, mesh->context == context, SPH_E_ARGUMENT,
            "flip: the mesh is of another context");
  SPH_CHECK(context, particles->dim == 2, SPH_E_ARGUMENT,
            "flip: particles \"%s\" must be 2D, they are %dD", particles->name, particles->dim);
  SPH_CHECK(context, divisions >= 1 && divisions <= MOST_DIVISIONS, SPH_E_ARGUMENT,
            "flip: divisions must be 1 to %d, got %d", MOST_DIVISIONS, divisions);
  SPH_TRY(sphi_particles_check_density(particles, below));
  SPH_TRY(sphi_particles_check_density(particles, above));
  return sphi_particles_check_room(particles, (double)mesh->cells * divisions * divisions);
}

sph_status sph_flip_fill(const sph_mesh *mesh, sph_particles *particles, int divisions,
                         sph_surface_function surface, void *user, double below, double above) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  SPH_CHECK(context, mesh, SPH_E_ARGUMENT, "flip: mesh is NULL");
  SPH_TRY(check_fill(mesh, particles, divisions, below, above));
  const int each = divisions * divisions;
  const int64_t first = particles->n, count = (int64_t)mesh->cells * each;
  double *x = SPHI_NEW(context, 2 * count, double), *rho = SPHI_NEW(context, count, double);
  sph_status status = SPH_OK;
  if (!x || !rho)
    status = SPHI_ERROR(context, SPH_E_MEMORY, "flip: no memory for %" PRId64 " particles", count);
  for (int64_t k = 0; k < count && status == SPH_OK; k++) {
    double share[3];
    middle_of(divisions, (int)(k % each), share);
    place_in(mesh, (int32_t)(k / each), share, x + 2 * k);
    const double level = surface ? surface(x + 2 * k, user) : HUGE_VAL;
    if (isnan(level))
      status = SPHI_ERROR(context, SPH_E_ARGUMENT,
                          "flip: the surface's level at x = %g m is not a number", x[2 * k]);
    rho[k] = x[2 * k + 1] < level ? below : above;
  }
  if (status == SPH_OK) status = sphi_particles_append(particles, count, x, below);
  for (int64_t k = 0; k < count && status == SPH_OK; k++) {
    const double volume = mesh->area[k / each] / each;
    particles->field[SPHI_RHO].data[0][first + k] = rho[k];
    particles->field[SPHI_VOL].data[0][first + k] = volume;
    particles->field[SPHI_M].data[0][first + k] = rho[k] * volume;
  }
  sphi_free(context, x);
  sphi_free(context, rho);
  return status;
}

/* ---- cells with few or many ---- */

/* Numbers in [0, 1) that depend on the step, the cell and k alone. */
static double scatter(int64_t step, int32_t cell, int k) {
  uint64_t z = (uint64_t)step * UINT64_C(0x9e3779b97f4a7c15) +
               (uint64_t)cell * UINT64_C(0xd1342543de82ef95) +
               (uint64_t)k * UINT64_C(0x2545f4914f6cdd1d);
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

static bool touches_open(const flip *s, int32_t c) {
  for (int k = 0; k < 3; k++)
    if (s->held[s->mesh->corner[3 * (int64_t)c + k]]) return true;
  return false;
}

/* Room for one more new particle in cell c, at a place in it that `k` chooses; NULL without memory. */
static double *add_fresh(sph_integrator *flow, int32_t c, int k) {
  flip *s = flip_of(flow);
  if (!sphi_reserve(flow->context, (void **)&s->fresh, &s->fresh_capacity,
                    (s->fresh_count + 1) * FLIP_FRESH, sizeof *s->fresh))
    return NULL;
  double *fresh = s->fresh + FLIP_FRESH * s->fresh_count++;
  const int64_t step = flow->stats.steps;
  double a = scatter(step, c, 2 * k), b = scatter(step, c, 2 * k + 1);
  if (a + b > 1) {
    a = 1 - a;
    b = 1 - b;
  }
  /* A little inside, so that rounding puts it nowhere else. */
  const double share[3] = {1.0 / 3 + 0.99 * (1 - a - b - 1.0 / 3), 1.0 / 3 + 0.99 * (a - 1.0 / 3),
                           1.0 / 3 + 0.99 * (b - 1.0 / 3)};
  place_in(s->mesh, c, share, fresh);
  fresh[7] = c;
  return fresh;
}

/* The light fluid comes in with the velocity of the last step's mesh, or that of the cell's particles. */
static bool let_in(sph_integrator *flow, int32_t c, int count) {
  flip *s = flip_of(flow);
  for (int k = 0; k < count; k++) {
    double *fresh = add_fresh(flow, c, k);
    if (!fresh) return false;
    fresh[2] = s->next[0][c];
    fresh[3] = s->next[1][c];
    fresh[4] = s->density[0];
    fresh[6] = s->mesh->area[c] / s->usual;
    fresh[5] = fresh[4] * fresh[6];
  }
  s->stats.entered += count;
  return true;
}

/* The particle with most mass gives half of it to a new one, as often as it takes. */
static bool split(sph_integrator *flow, int32_t c, int count) {
  flip *s = flip_of(flow);
  double *m = flip_field(flow, SPHI_M)[0], *volume = flip_field(flow, SPHI_VOL)[0];
  for (int k = 0; k < count; k++) {
    int32_t i = s->order[s->start[c]];
    for (int64_t j = s->start[c]; j < s->start[c + 1]; j++)
      if (m[s->order[j]] > m[i]) i = s->order[j];
    double *fresh = add_fresh(flow, c, k);
    if (!fresh) return false;
    m[i] *= 0.5;
    volume[i] *= 0.5;
    for (int d = 0; d < 2; d++) fresh[2 + d] = flip_field(flow, SPHI_V)[d][i];
    fresh[4] = flip_field(flow, SPHI_RHO)[0][i];
    fresh[5] = m[i];
    fresh[6] = volume[i];
  }
  s->stats.split += count;
  return true;
}

/* The two nearest particles of a cell become one, the first of them, at their centre of mass. The last place
 * in the cell's part of `order` takes the other's, which goes. */
static void merge(sph_integrator *flow, int32_t c, int64_t *count) {
  flip *s = flip_of(flow);
  double **x = flip_field(flow, SPHI_X), **v = flip_field(flow, SPHI_V);
  double *m = flip_field(flow, SPHI_M)[0], *volume = flip_field(flow, SPHI_VOL)[0];
  int32_t *order = s->order + s->start[c];
  double least = HUGE_VAL;
  int64_t first = 0, second = 1;
  for (int64_t j = 0; j < *count; j++)
    for (int64_t k = j + 1; k < *count; k++) {
      const double dx = x[0][order[j]] - x[0][order[k]], dy = x[1][order[j]] - x[1][order[k]];
      if (dx * dx + dy * dy >= least) continue;
      least = dx * dx + dy * dy;
      first = j;
      second = k;
    }
  const int32_t i = order[first], j = order[second];
  const double share = m[j] / (m[i] + m[j]);
  for (int d = 0; d < 2; d++) {
    x[d][i] += share * (x[d][j] - x[d][i]);
    v[d][i] += share * (v[d][j] - v[d][i]);
  }
  m[i] += m[j];
  volume[i] += volume[j];
  flip_field(flow, s->field)[0][j] = -1;
  order[second] = order[--*count];
  s->stats.merged++;
}

static bool of_one_fluid(const sph_integrator *flow, int32_t c) {
  const flip *s = flip_of(flow);
  const double *rho = flip_field(flow, SPHI_RHO)[0];
  for (int64_t k = s->start[c] + 1; k < s->start[c + 1]; k++)
    if (rho[s->order[k]] != rho[s->order[s->start[c]]]) return false;
  return true;
}

static bool balance(sph_integrator *flow, int32_t c) {
  flip *s = flip_of(flow);
  int64_t count = s->start[c + 1] - s->start[c];
  if (count < s->fewest && s->open && touches_open(s, c))
    return let_in(flow, c, s->fewest - (int)count);
  if (count > 0 && count < s->fewest && of_one_fluid(flow, c))
    return split(flow, c, s->fewest - (int)count);
  if (s->most > 0 && count > s->most && of_one_fluid(flow, c))
    while (count > s->most) merge(flow, c, &count);
  return true;
}

static sph_status add_all(sph_integrator *flow) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  sph_particles *particles = flow->particles;
  const int64_t first = particles->n, count = s->fresh_count;
  double *x = SPHI_NEW(context, 2 * count, double);
  SPH_CHECK(context, x, SPH_E_MEMORY, "flip: no memory for %" PRId64 " particles", count);
  for (int64_t k = 0; k < count; k++) memcpy(x + 2 * k, s->fresh + FLIP_FRESH * k, 2 * sizeof *x);
  const sph_status status = sphi_particles_append(particles, count, x, s->density[0]);
  sphi_free(context, x);
  SPH_TRY(status);
  for (int64_t k = 0; k < count; k++) {
    const double *fresh = s->fresh + FLIP_FRESH * k;
    for (int d = 0; d < 2; d++) particles->field[SPHI_V].data[d][first + k] = fresh[2 + d];
    particles->field[SPHI_RHO].data[0][first + k] = fresh[4];
    particles->field[SPHI_M].data[0][first + k] = fresh[5];
    particles->field[SPHI_VOL].data[0][first + k] = fresh[6];
    particles->field[s->field].data[0][first + k] = fresh[7];
  }
  return SPH_OK;
}

/* Ranks close up in their order; in storage the last particles take the places of those that go. */
void sphi_flip_remove_gone(sph_integrator *flow) {
  flip *s = flip_of(flow);
  sph_particles *particles = flow->particles;
  const double *cell = flip_field(flow, s->field)[0];
  sph_index kept = 0, last = particles->n;
  for (sph_index r = 0; r < particles->n; r++)
    if (cell[particles->slot[r]] >= 0) particles->rank[particles->slot[r]] = kept++;
  for (sph_index k = 0; k < kept; k++) {
    if (cell[k] >= 0) continue;
    do last--;
    while (cell[last] < 0);
    for (int f = 0; f < particles->fields; f++)
      for (int d = 0; d < particles->field[f].components; d++)
        particles->field[f].data[d][k] = particles->field[f].data[d][last];
    particles->id[k] = particles->id[last];
    particles->rank[k] = particles->rank[last];
  }
  for (sph_index k = 0; k < kept; k++) particles->slot[particles->rank[k]] = k;
  particles->n = kept;
  s->revision = ++particles->revision;
}

sph_status sphi_flip_reseed(sph_integrator *flow) {
  flip *s = flip_of(flow);
  const int64_t merged = s->stats.merged;
  s->fresh_count = 0;
  for (int32_t c = 0; c < s->mesh->cells; c++) {
    const int64_t count = s->start[c + 1] - s->start[c];
    if (count >= s->fewest && (s->most == 0 || count <= s->most)) continue;
    SPH_CHECK(flow->context, balance(flow, c), SPH_E_MEMORY,
              "flip: no memory for particles in cell %d", c);
  }
  if (s->fresh_count == 0 && s->stats.merged == merged) return SPH_OK;
  if (s->fresh_count > 0) SPH_TRY(add_all(flow));
  sphi_flip_remove_gone(flow);
  return sphi_flip_sort(flow);
}
