/* From the mesh to the particles: a continuous velocity, (5) and (6).
 *
 * The velocity is that of Maljaars et al. (2017): linear on the three triangles between a cell's middle, where
 * it is u_K, and its sides, with the nodes' means at the corners:
 *
 *     U(x) = sum_a (s_a - s) u_a + 3 s u_K,  s_a barycentric coordinates, s their least               (1)
 */
#include <inttypes.h>

#include "flip/flip_impl.h"

enum { PARALLEL_FROM = 2048, BLOCK = 256 };

/* Means at nodes by area, with which surfaces go along, or by mass, with which particles get the momentum that
 * cells have; then what walls prescribe. */
static void node_velocities(const sph_integrator *flow, double *const *u, bool by_mass,
                            const flip_hold *hold, double *const *out) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->nodes > PARALLEL_FROM)
  for (int32_t a = 0; a < mesh->nodes; a++) {
    double sum[2] = {0}, all = 0;
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++) {
      const int32_t c = mesh->touch[t] / 3;
      const double weight = by_mass ? mesh->area[c] * s->rho[c] : mesh->area[c];
      all += weight;
      for (int d = 0; d < 2; d++) sum[d] += weight * u[d][c];
    }
    for (int d = 0; d < 2; d++) out[d][a] = sum[d] / all;
  }
  for (int32_t k = 0; k < s->holds; k++) {
    const flip_hold *w = &hold[k];
    double v[2] = {out[0][w->node], out[1][w->node]};
    if (w->normals == 2) {
      const double det = w->n[0][0] * w->n[1][1] - w->n[0][1] * w->n[1][0];
      v[0] = (w->h[0] * w->n[1][1] - w->h[1] * w->n[0][1]) / det;
      v[1] = (w->h[1] * w->n[0][0] - w->h[0] * w->n[1][0]) / det;
    } else if (s->no_slip) {
      for (int d = 0; d < 2; d++) v[d] = w->h[0] * w->n[0][d];
    } else {
      const double off = v[0] * w->n[0][0] + v[1] * w->n[0][1] - w->h[0];
      for (int d = 0; d < 2; d++) v[d] -= off * w->n[0][d];
    }
    for (int d = 0; d < 2; d++) out[d][w->node] = v[d];
  }
}

void sphi_flip_reconstruct(sph_integrator *flow) {
  flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  node_velocities(flow, s->next, false, s->hold[1], s->velocity);
  node_velocities(flow, s->u, s->mass_weighted, s->hold[0], s->before);
  node_velocities(flow, s->next, s->mass_weighted, s->hold[1], s->after);
  double rate2 = 0, speed2 = 0;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) \
    reduction(max                                                             \
              : rate2, speed2) if (mesh->cells > PARALLEL_FROM)
  for (int32_t c = 0; c < mesh->cells; c++) {
    flip_record *r = &s->record[c];
    const int32_t *corner = mesh->corner + 3 * (int64_t)c;
    const double *g = mesh->gradient + 6 * (int64_t)c;
    for (int d = 0; d < 2; d++) {
      r->x[d] = mesh->x[2 * (int64_t)corner[0] + d];
      r->g1[d] = g[2 + d];
      r->g2[d] = g[4 + d];
      for (int k = 0; k < 3; k++) {
        r->u[k][d] = s->velocity[d][corner[k]];
        r->kick[k][d] = s->after[d][corner[k]] - (1 - s->share) * s->before[d][corner[k]];
      }
      r->u[3][d] = s->next[d][c];
      r->kick[3][d] = s->next[d][c] - (1 - s->share) * s->u[d][c];
    }
    double most2 = 0;
    for (int k = 0; k < 4; k++) {
      const double v2 = r->u[k][0] * r->u[k][0] + r->u[k][1] * r->u[k][1];
      most2 = v2 > most2 ? v2 : most2;
    }
    speed2 = fmax(speed2, most2);
    rate2 = fmax(rate2, most2 / (2 * mesh->area[c]));
  }
  s->rate = sqrt(rate2);
  flow->stats.max_speed = sqrt(speed2);
}

/* Barycentric coordinates of x in a cell; whether it is in it. */
static inline bool within(const flip_record *r, const double *x, double *share) {
  const double dx = x[0] - r->x[0], dy = x[1] - r->x[1];
  share[1] = r->g1[0] * dx + r->g1[1] * dy;
  share[2] = r->g2[0] * dx + r->g2[1] * dy;
  share[0] = 1 - share[1] - share[2];
  const double low = share[0] < share[1] ? share[0] : share[1]; /* one branch for all three */
  return (low < share[2] ? low : share[2]) >= -SPHI_MESH_EDGE;
}

/* The cell for a point that has left `cell`, with coordinates in it; outside, those of the nearest point of
 * the boundary, and its edge. */
static int32_t elsewhere(const flip *s, const double *x, int32_t cell, double *share,
                         int32_t *edge) {
  const sph_mesh *mesh = s->mesh;
  int32_t stopped_by = -1;
  int32_t found = sphi_mesh_walk(mesh, x, cell, &stopped_by);
  *edge = -1;
  if (found >= 0 || stopped_by < 0) {
    found = found >= 0 ? found : cell;
    within(&s->record[found], x, share);
    return found;
  }
  double foot[2];
  *edge = sphi_mesh_foot(mesh, x, stopped_by, foot);
  found = mesh->side[2 * (int64_t)*edge];
  within(&s->record[found], foot, share);
  return found;
}

/* U^(n+1) at a point near `cell`. */
static inline void velocity_near(const flip *s, int32_t cell, const double *x, double *u) {
  double share[3];
  int32_t edge;
  const flip_record *r = &s->record[cell];
  if (!within(r, x, share)) r = &s->record[elsewhere(s, x, cell, share, &edge)];
  flip_mix(r->u[0], share[0], share[1], share[2], u);
}

/* How a particle ended. */
typedef enum fate { INSIDE, PUT_BACK, LEFT, BAD } fate;

/* (5) and (6) for one particle. */
static inline fate advance(const sph_integrator *flow, int32_t i, double dt) {
  const flip *s = flip_of(flow);
  double **field_x = flip_field(flow, SPHI_X), **field_v = flip_field(flow, SPHI_V);
  double *cell = flip_field(flow, s->field)[0];
  double x[2] = {field_x[0][i], field_x[1][i]}, share[3], u[2], kick[2], k2[2], k3[2], at[2];
  int32_t c = s->cell[i], edge = -1;
  if (!within(&s->record[c], x, share)) c = elsewhere(s, x, c, share, &edge);
  const flip_record *r = &s->record[c];
  flip_mix(r->u[0], share[0], share[1], share[2], u);
  flip_mix(r->kick[0], share[0], share[1], share[2], kick);
  for (int d = 0; d < 2; d++) {
    field_v[d][i] = (1 - s->share) * field_v[d][i] + kick[d];
    at[d] = x[d] + 0.5 * dt * u[d];
  }
  velocity_near(s, c, at, k2);
  for (int d = 0; d < 2; d++) at[d] = x[d] + 0.75 * dt * k2[d];
  velocity_near(s, c, at, k3);
  for (int d = 0; d < 2; d++) x[d] += dt / 9 * (2 * u[d] + 3 * k2[d] + 4 * k3[d]);
  if (!(fabs(x[0]) + fabs(x[1]) + fabs(field_v[0][i]) + fabs(field_v[1][i]) < 1e100)) return BAD;
  edge = -1;
  if (!within(&s->record[c], x, share)) c = elsewhere(s, x, c, share, &edge);
  fate end = INSIDE;
  if (edge >= 0 && s->open && s->mesh->tag[edge] == s->open) {
    end = LEFT;
  } else if (edge >= 0) {
    end = PUT_BACK;
    const int32_t *corner = s->mesh->corner + 3 * (int64_t)c;
    for (int d = 0; d < 2; d++) {
      double middle = 0;
      x[d] = 0;
      for (int k = 0; k < 3; k++) {
        const double p = s->mesh->x[2 * (int64_t)corner[k] + d];
        middle += p / 3;
        x[d] += share[k] * p;
      }
      x[d] += FLIP_BACK * (middle - x[d]);
    }
    within(&s->record[c], x, share);
  }
  const int32_t *corner = s->mesh->corner + 3 * (int64_t)c;
  flip_field(flow, SPHI_P)[0][i] = share[0] * s->pressure[corner[0]] +
                                   share[1] * s->pressure[corner[1]] +
                                   share[2] * s->pressure[corner[2]];
  for (int d = 0; d < 2; d++) field_x[d][i] = x[d];
  cell[i] = end == LEFT ? -1 : c;
  return end;
}

/* All particles that stay in their cell. */
static void carry_along(sph_integrator *flow, double dt) {
  const flip *s = flip_of(flow);
  const int32_t cells = s->mesh->cells, blocks = (cells + BLOCK - 1) / BLOCK;
  const flip_carry a = {.record = s->record,
                        .start = s->start,
                        .order = s->order,
                        .corner = s->mesh->corner,
                        .pressure = s->pressure,
                        .x = {flip_field(flow, SPHI_X)[0], flip_field(flow, SPHI_X)[1]},
                        .v = {flip_field(flow, SPHI_V)[0], flip_field(flow, SPHI_V)[1]},
                        .p = flip_field(flow, SPHI_P)[0],
                        .dt = dt,
                        .pic = s->share,
                        .left = s->left};
  const sphi_update update = flow->variant->updates[SPHI_UPDATE_carry];
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) if (blocks > 1)
  for (int32_t b = 0; b < blocks; b++)
    update(&a, b * BLOCK, (b + 1) * BLOCK < cells ? (b + 1) * BLOCK : cells);
}

sph_status sphi_flip_advance(sph_integrator *flow, double dt) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  const sph_particles *particles = flow->particles;
  const double begin = sphi_seconds();
  const int32_t n = particles->n;
  int32_t bad = INT32_MAX;
  int64_t back = 0, left = 0;
  carry_along(flow, dt);
#pragma omp parallel for num_threads(context->threads) schedule(static) \
    reduction(min : bad) reduction(+ : back, left) if (n > PARALLEL_FROM)
  for (int32_t i = 0; i < n; i++) {
    if (!s->left[i]) continue;
    const fate end = advance(flow, i, dt);
    back += end == PUT_BACK;
    left += end == LEFT;
    if (end == BAD && i < bad) bad = i;
  }
  flow->stats.contacts += back;
  flow->stats.seconds_update += sphi_seconds() - begin;
  SPH_CHECK(context, bad == INT32_MAX, SPH_E_DIVERGED,
            "flip: particle %" PRId64
            " at (%g, %g) m got a velocity or place that is not finite "
            "in the step of %g s at time %g s",
            particles->id[bad], particles->field[SPHI_X].data[0][bad],
            particles->field[SPHI_X].data[1][bad], dt, flow->stats.time);
  s->stats.left += left;
  if (left > 0) sphi_flip_remove_gone(flow);
  return SPH_OK;
}
