/* Points that a wall takes along. */
#include "probe/probe_impl.h"

void sphi_probe_points_free(sph_context *context, sphi_probe_points *points) {
  sphi_gather_free(context, &points->gather);
  sphi_free(context, points->reference);
  sphi_free(context, points->asked);
  sphi_free(context, points->answer);
  sph_interpolator_destroy(&points->interpolator);
  sph_boundary_destroy(&points->boundary);
}

sph_status sphi_probe_prepare(sph_probe *probe) {
  sphi_probe_points *points = probe->data;
  const int64_t n = (int64_t)points->gather.n * probe->flow->particles->dim;
  if (!probe->flow->method->evaluate) return SPH_OK;
  points->asked = SPHI_NEW(probe->context, n, double);
  points->answer = SPHI_NEW(probe->context, n, double);
  SPH_CHECK(probe->context, points->asked && points->answer, SPH_E_MEMORY,
            "probe \"%s\": no memory for %d points", probe->name, points->gather.n);
  return SPH_OK;
}

const double *sphi_probe_places(sphi_probe_points *points, int dim) {
  for (int32_t k = 0; k < points->gather.n; k++)
    for (int d = 0; d < dim; d++) points->asked[(int64_t)dim * k + d] = points->gather.x[d][k];
  return points->asked;
}

/* Puts the points where the wall has them now. Lists reach as far as a particle and a point may have come,
 * half the skin each, since they were made; the flow makes them anew for walls as well, but points far out
 * on a wall that rotates are faster than all of it, and the gather may be listed after the flow. */
static sph_status take_along(sph_probe *probe, sphi_probe_points *points) {
  const sph_integrator *flow = probe->flow;
  const int dim = flow->particles->dim;
  const sph_wall *wall = points->boundary->wall[points->wall];
  if (!sphi_wall_moves(wall)) return SPH_OK;
  SPH_TRY(sphi_wall_state_at(wall, flow->stats.time, &points->now));
  double way2 = 0;
  for (int32_t k = 0; k < points->gather.n; k++) {
    const double *reference = points->reference + (int64_t)dim * k;
    double x[SPHI_MAX_DIM], before[SPHI_MAX_DIM], step2 = 0;
    sphi_wall_place(&points->now, dim, reference, x);
    sphi_wall_place(&points->listed, dim, reference, before);
    for (int d = 0; d < dim; d++) {
      points->gather.x[d][k] = x[d];
      step2 += (x[d] - before[d]) * (x[d] - before[d]);
    }
    way2 = fmax(way2, step2);
  }
  points->gather.packed = false;
  if (sqrt(way2) > 0.5 * (flow->list_radius - flow->kernel->support)) points->build = -1;
  if (points->build != flow->stats.builds) points->listed = points->now;
  return SPH_OK;
}

sph_status sphi_probe_gather(sph_probe *probe) {
  sphi_probe_points *points = probe->data;
  sph_integrator *flow = probe->flow;
  SPH_TRY(flow->method->refresh(flow));
  if (points->boundary) SPH_TRY(take_along(probe, points));
  return sphi_integrator_gather(flow, &points->gather, points->interpolator, &points->build);
}

sph_status sph_probe_follow(sph_probe *probe, sph_boundary *boundary, int wall) {
  if (!probe) return SPH_E_ARGUMENT;
  sph_context *context = probe->context;
  SPH_CHECK(context, probe->kind->has_points, SPH_E_TYPE,
            "probe \"%s\": it has no points that a wall could take along", probe->name);
  SPH_TRY(sphi_probe_check_wall(probe->flow, probe->name, boundary, wall));
  sphi_probe_points *points = probe->data;
  const int dim = probe->flow->particles->dim;
  if (!points->reference) {
    points->reference = SPHI_NEW(context, (int64_t)points->gather.n * dim, double);
    SPH_CHECK(context, points->reference, SPH_E_MEMORY, "probe \"%s\": no memory for %d points",
              probe->name, points->gather.n);
    for (int32_t k = 0; k < points->gather.n; k++)
      for (int d = 0; d < dim; d++)
        points->reference[(int64_t)dim * k + d] = points->gather.x[d][k];
    points->boundary = boundary;
    sphi_boundary_retain(boundary);
  }
  for (int32_t k = 0; k < points->gather.n; k++)
    for (int d = 0; d < dim; d++) points->gather.x[d][k] = points->reference[(int64_t)dim * k + d];
  points->now = (sphi_wall_state){0};
  points->wall = wall;
  points->build = -1;
  return SPH_OK;
}
