/* Measures of the hybrid particle-mesh method: values at points, levels, energies. */
#include <inttypes.h>

#include "flip/flip_impl.h"

/* Values at a point of a cell; each may be NULL. */
static void value_at(const flip *s, int32_t c, const double *x, double *pressure,
                     double *velocity) {
  const int32_t *corner = s->mesh->corner + 3 * (int64_t)c;
  double share[3];
  sphi_mesh_coordinates(s->mesh, c, x, share);
  if (pressure) {
    *pressure = 0;
    for (int l = 0; l < 3; l++) *pressure += share[l] * s->pressure[corner[l]];
  }
  if (velocity) flip_mix(s->record[c].u[0], share[0], share[1], share[2], velocity);
}

sph_status sph_flip_evaluate(const sph_integrator *integrator, int64_t count, const double *x,
                             double *pressure, double *velocity) {
  SPH_TRY(sphi_flip_check(integrator));
  sph_context *context = integrator->context;
  flip *s = flip_of(integrator);
  SPH_CHECK(context, x && count >= 0, SPH_E_ARGUMENT,
            "flip: x must be given, and count >= 0, got %" PRId64, count);
  SPH_TRY(sphi_mesh_prepare(s->mesh));
  for (int64_t k = 0; k < count; k++) {
    int32_t unused = -1;
    SPH_CHECK(context, sphi_finite(2, x + 2 * k), SPH_E_ARGUMENT,
              "flip: point %" PRId64 " is not finite", k);
    const int32_t c = sphi_mesh_walk(s->mesh, x + 2 * k, -1, &unused);
    SPH_CHECK(context, c >= 0, SPH_E_ARGUMENT,
              "flip: point %" PRId64 " at (%g, %g) m is outside the mesh", k, x[2 * k],
              x[2 * k + 1]);
    value_at(s, c, x + 2 * k, pressure ? pressure + k : NULL, velocity ? velocity + 2 * k : NULL);
  }
  return SPH_OK;
}

/* Where the vertical line through x cuts a triangle: from lo to hi; false: nowhere. */
static bool cut(const sph_mesh *mesh, int32_t c, double x, double *lo, double *hi) {
  const int32_t *corner = mesh->corner + 3 * (int64_t)c;
  const int left = (mesh->x[2 * (int64_t)corner[0]] < x) + (mesh->x[2 * (int64_t)corner[1]] < x) +
                   (mesh->x[2 * (int64_t)corner[2]] < x);
  if (left == 0 || left == 3) return false;
  *lo = HUGE_VAL;
  *hi = -HUGE_VAL;
  for (int k = 0; k < 3; k++) {
    const double *a = mesh->x + 2 * (int64_t)corner[k];
    const double *b = mesh->x + 2 * (int64_t)corner[(k + 1) % 3];
    if ((a[0] < x) == (b[0] < x)) continue;
    const double y = a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0]));
    *lo = fmin(*lo, y);
    *hi = fmax(*hi, y);
  }
  return *lo < *hi;
}

/* Means of density for the particles as they are; without any, what the last step took. */
static void average_now(sph_integrator *flow) {
  flip *s = flip_of(flow);
  const sph_particles *particles = flow->particles;
  if (s->now_step == flow->stats.steps && s->now_revision == particles->revision) return;
  const size_t bytes = (size_t)s->mesh->cells * sizeof(double);
  const double *cell = flip_field(flow, s->field)[0], *rho = flip_field(flow, SPHI_RHO)[0];
  memset(s->now_rho, 0, bytes);
  memset(s->now_count, 0, bytes);
  for (int32_t i = 0; i < particles->n; i++) {
    s->now_rho[(int32_t)cell[i]] += rho[i];
    s->now_count[(int32_t)cell[i]]++;
  }
  for (int32_t c = 0; c < s->mesh->cells; c++)
    s->now_rho[c] = s->now_count[c] > 0 ? s->now_rho[c] / s->now_count[c] : s->rho[c];
  s->now_step = flow->stats.steps;
  s->now_revision = particles->revision;
}

/* The share of heavy fluid in a cell, by average_now. */
static double heavy_share(const flip *s, int32_t c) {
  const double range = s->density[1] - s->density[0];
  const double share = range > 0 ? (s->now_rho[c] - s->density[0]) / range : 1;
  return share < 0 ? 0 : share > 1 ? 1 : share;
}

/* For probes: as sph_flip_evaluate, but 0 outside the mesh. */
sph_status sphi_flip_evaluate(sph_integrator *flow, int64_t count, const double *x,
                              double *pressure, double *velocity, double *filling) {
  const flip *s = flip_of(flow);
  SPH_TRY(sphi_flip_refresh(flow));
  SPH_TRY(sphi_mesh_prepare(s->mesh));
  if (filling) average_now(flow);
  for (int64_t k = 0; k < count; k++) {
    int32_t unused = -1;
    const int32_t c = sphi_mesh_walk(s->mesh, x + 2 * k, -1, &unused);
    if (pressure) pressure[k] = 0;
    for (int d = 0; d < 2 && velocity; d++) velocity[2 * k + d] = 0;
    if (filling) filling[k] = c >= 0 ? heavy_share(s, c) : 0;
    if (c >= 0)
      value_at(s, c, x + 2 * k, pressure ? pressure + k : NULL, velocity ? velocity + 2 * k : NULL);
  }
  return SPH_OK;
}

sph_status sph_flip_find_level(sph_integrator *integrator, double x, double *level) {
  SPH_TRY(sphi_flip_check(integrator));
  sph_context *context = integrator->context;
  flip *s = flip_of(integrator);
  SPH_CHECK(context, level && isfinite(x), SPH_E_ARGUMENT, "flip: level must be given, x finite");
  SPH_TRY(sphi_flip_refresh(integrator));
  average_now(integrator);
  double bottom = HUGE_VAL, height = 0, lo, hi;
  for (int32_t c = 0; c < s->mesh->cells; c++) {
    if (!cut(s->mesh, c, x, &lo, &hi)) continue;
    bottom = fmin(bottom, lo);
    height += (hi - lo) * heavy_share(s, c);
  }
  SPH_CHECK(context, bottom < HUGE_VAL, SPH_E_ARGUMENT, "flip: there is no cell at x = %g m", x);
  *level = bottom + height;
  return SPH_OK;
}

sph_status sph_flip_get_energy(const sph_integrator *integrator, sph_energy *out) {
  SPH_TRY(sphi_flip_check(integrator));
  SPH_CHECK(integrator->context, out, SPH_E_ARGUMENT, "flip: energy is NULL");
  const double *g = flip_of(integrator)->gravity, *m = flip_field(integrator, SPHI_M)[0];
  double **x = flip_field(integrator, SPHI_X), **v = flip_field(integrator, SPHI_V);
  sph_energy sum = {0};
  for (int32_t i = 0; i < integrator->particles->n; i++) {
    sum.kinetic += 0.5 * m[i] * (v[0][i] * v[0][i] + v[1][i] * v[1][i]);
    sum.potential -= m[i] * (g[0] * x[0][i] + g[1] * x[1][i]);
  }
  sum.total = sum.kinetic + sum.potential;
  *out = sum;
  return SPH_OK;
}
