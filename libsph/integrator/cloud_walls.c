/* Do walls and particles fit together, and do they stay apart? What is wrong with a particle. */
#include "integrator/integrator_impl.h"

/* In spacings: particles nearer to a wall touch it; deeper inside one they have crossed it. */
#define CONTACT 0.25
#define INSIDE 0.5
#define CLEAR 4 /* how far off a wall is looked for */

/* Distance of particle i to the nearest wall, or negative to the wall that it is deepest inside, and which;
 * HUGE_VAL farther away than `bound`. */
static double wall_distance(const sph_integrator *flow, int32_t i, double bound, int *wall) {
  const sph_boundary *boundary = flow->cloud.boundary;
  const int dim = boundary->dim;
  double nearest = HUGE_VAL;
  for (int k = 0; k < boundary->walls; k++) {
    double x[SPHI_MAX_DIM] = {0}, foot[SPHI_MAX_DIM] = {0};
    for (int d = 0; d < dim; d++) x[d] = flow->particles->field[SPHI_X].data[d][i];
    const double distance =
        sphi_wall_foot_now(boundary->wall[k], &boundary->state[k], x, bound, foot);
    if (distance >= nearest) continue;
    nearest = distance;
    *wall = k;
  }
  return nearest;
}

/* An end on a face of a periodic box is none: the wall goes on in the next period. */
static bool ends_at_period(const sph_integrator *flow, const double *end) {
  const sphi_cloud *c = &flow->cloud;
  for (int d = 0; d < flow->particles->dim; d++) {
    const double tolerance = 1e-9 * (c->periodic_hi[d] - c->periodic_lo[d]);
    if (c->periodic[d] && (fabs(end[d] - c->periodic_lo[d]) <= tolerance ||
                           fabs(end[d] - c->periodic_hi[d]) <= tolerance))
      return true;
  }
  return false;
}

sph_status sphi_cloud_check_walls(sph_integrator *flow) {
  const sph_boundary *boundary = flow->cloud.boundary;
  const sph_particles *particles = flow->particles;
  const int dim = particles->dim;
  const double reach = flow->kernel->support;
  double **x = particles->field[SPHI_X].data;
  for (sph_index k = 0; k < particles->n; k++) {
    const sph_index i = particles->slot[k];
    int wall = 0;
    const double distance = wall_distance(flow, i, reach, &wall);
    SPH_CHECK(flow->context, distance > 0, SPH_E_ARGUMENT,
              "particles \"%s\": particle %lld at (%g, %g, %g) m lies %g m inside wall \"%s\"",
              particles->name, (long long)particles->id[i], x[0][i], x[1][i],
              dim == 3 ? x[2][i] : 0.0, -distance, sphi_wall_name(boundary->wall[wall]));
  }
  for (int w = 0; w < boundary->walls; w++) {
    double ends[2 * SPHI_WALL_MAX_ENDS];
    const int count = sphi_wall_open_ends(boundary->wall[w], ends);
    for (int e = 0; e < count; e++) {
      double end[SPHI_MAX_DIM];
      sphi_wall_place(&boundary->state[w], dim, ends + dim * e, end);
      if (ends_at_period(flow, end)) continue;
      for (sph_index i = 0; i < particles->n; i++) {
        double r2 = 0;
        for (int d = 0; d < dim; d++) {
          const double away = x[d][i] - end[d];
          r2 += away * away;
        }
        SPH_CHECK(flow->context, r2 >= reach * reach, SPH_E_ARGUMENT,
                  "wall \"%s\" ends openly at (%g, %g) m with particle %lld only %g m away: fluid "
                  "would escape; extend the wall %g m beyond the fluid or close it",
                  sphi_wall_name(boundary->wall[w]), end[0], end[1], (long long)particles->id[i],
                  sqrt(r2), reach);
      }
    }
  }
  return SPH_OK;
}

typedef enum contact { CONTACT_NONE, CONTACT_STOPPED, CONTACT_CROSSED } contact;

/* Takes from particle i the speed with which it runs into a wall that it touches, or what of it would
 * carry it through the wall within dt; puts it back if it came a little way in. *clear becomes how far
 * it is from any wall at least. */
static contact stop_at_walls(sph_integrator *flow, int32_t i, double dt, double *clear) {
  const sph_boundary *boundary = flow->cloud.boundary;
  const int dim = boundary->dim;
  const double reach = CONTACT * flow->particles->spacing,
               depth = INSIDE * flow->particles->spacing;
  double **x = flow->particles->field[SPHI_X].data, **v = flow->particles->field[SPHI_V].data;
  contact found = CONTACT_NONE;
  *clear = HUGE_VAL;
  for (int k = 0; k < boundary->walls; k++) {
    const sphi_wall_state *wall = &boundary->state[k];
    double at[SPHI_MAX_DIM], foot[SPHI_MAX_DIM], wall_velocity[SPHI_MAX_DIM], speed2 = 0;
    for (int d = 0; d < dim; d++) at[d] = x[d][i];
    sphi_wall_velocity_at(wall, dim, at, wall_velocity, NULL);
    for (int d = 0; d < dim; d++) speed2 += pow(v[d][i] - wall_velocity[d], 2);
    /* What crossed did so within this step, in which it moved less than a spacing. */
    const double bound = fmax(flow->particles->spacing, 2 * sqrt(speed2) * dt);
    const double far = fmax(bound, CLEAR * flow->particles->spacing);
    const double distance = sphi_wall_foot_now(boundary->wall[k], wall, at, far, foot);
    *clear = fmin(*clear, fmin(fabs(distance), far));
    if (fabs(distance) > bound || distance == bound || distance == 0) continue;
    if (distance <= -depth) return CONTACT_CROSSED;
    double away = 0, off[SPHI_MAX_DIM]; /* speed off the wall, unit vector off the wall */
    for (int d = 0; d < dim; d++) {
      off[d] = (at[d] - foot[d]) / distance;
      away += (v[d][i] - wall_velocity[d]) * off[d];
    }
    if (distance < 0) {
      *clear = 0;
      for (int d = 0; d < dim; d++) x[d][i] = foot[d] + 1e-3 * reach * off[d];
    }
    const double slowest = distance < reach ? 0 : -distance / dt;
    if (away >= slowest) continue;
    for (int d = 0; d < dim; d++) v[d][i] += (slowest - away) * off[d];
    found = CONTACT_STOPPED;
  }
  return found;
}

void sphi_cloud_forget_walls(sph_integrator *flow) {
  sphi_cloud *c = &flow->cloud;
  if (!c->boundary) return;
  memset(c->clear, 0, (size_t)flow->particles->n * sizeof *c->clear);
  c->odometer = 0;
}

/* Finding the nearest point of a wall takes long, and most particles near walls are not that near: what
 * was clear of all walls stays so until it, or a wall, can have come that far. */
sph_status sphi_cloud_stop_at_walls(sph_integrator *flow, double dt) {
  sphi_cloud *c = &flow->cloud;
  if (!c->boundary) return SPH_OK;
  const double spacing = flow->particles->spacing, wall_speed = sphi_cloud_wall_speed(flow);
  const double fastest = flow->stats.max_speed + dt * flow->stats.max_acceleration;
  if (c->odometer > 1000 * spacing) sphi_cloud_forget_walls(flow); /* else its digits get lost */
  const double odometer = c->odometer;
  const sph_index *rank = flow->particles->rank; /* unlike storage, builds leave it */
  double **v = flow->particles->field[SPHI_V].data;
  int64_t touched = 0;
  int32_t bad = INT32_MAX;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) \
    reduction(+ : touched) reduction(min : bad)
  for (int32_t k = 0; k < flow->clusters.n; k++) {
    if (c->ghost_list.entry[k].count == 0) continue;
    for (int32_t l = 0; l < flow->clusters.count[k]; l++) {
      const int32_t i = flow->clusters.first[k] + l;
      float *known = &c->clear[rank[i]];
      double speed2 = 0;
      for (int d = 0; d < flow->particles->dim; d++) speed2 += v[d][i] * v[d][i];
      const double speed = sqrt(speed2), travel = dt * (fmax(fastest, speed) + wall_speed);
      const double bound = fmax(spacing, 2 * dt * (speed + wall_speed));
      if ((double)*known - odometer - travel > 1.001 * bound) continue;
      double clear;
      const contact found = stop_at_walls(flow, i, dt, &clear);
      *known = (float)(clear + odometer);
      touched += found == CONTACT_STOPPED;
      if (found == CONTACT_CROSSED && i < bad) bad = i;
    }
  }
  flow->stats.contacts += touched;
  if (bad == INT32_MAX) return SPH_OK;
  const sph_particles *particles = flow->particles;
  double **x = particles->field[SPHI_X].data;
  int wall = 0;
  const double distance = wall_distance(flow, bad, HUGE_VAL, &wall);
  return SPHI_ERROR(flow->context, SPH_E_DIVERGED,
                    "particles \"%s\": particle %lld at (%g, %g, %g) m, time %g s, crossed wall "
                    "\"%s\" by %g m",
                    particles->name, (long long)particles->id[bad], x[0][bad], x[1][bad],
                    particles->dim == 3 ? x[2][bad] : 0.0, flow->stats.time,
                    sphi_wall_name(c->boundary->wall[wall]), -distance);
}

sph_status sphi_cloud_report(const sph_integrator *flow, int32_t i, double dt) {
  const sph_particles *particles = flow->particles;
  const int dim = particles->dim;
  const sphi_field *field = particles->field;
  double *const *x = field[SPHI_X].data, *const *v = field[SPHI_V].data;
  double *const *a = field[flow->cloud.acceleration].data;
  const double rho = field[SPHI_RHO].data[0][i];
  double speed2 = 0, push2 = 0;
  bool outside = false;
  for (int d = 0; d < dim; d++) {
    speed2 += v[d][i] * v[d][i];
    push2 += a[d][i] * a[d][i];
    outside = outside || (!flow->cloud.periodic[d] && !(x[d][i] >= flow->cloud.domain_lo[d] &&
                                                        x[d][i] <= flow->cloud.domain_hi[d]));
  }
  const char *what = "left the domain: distance";
  double value = 0;
  if (!isfinite(push2)) {
    what = "has an acceleration that is not finite: |a|";
    value = sqrt(push2);
  } else if (!isfinite(speed2)) {
    what = "has a velocity that is not finite: |v|";
    value = sqrt(speed2);
  } else if (!(isfinite(rho) && rho > 0)) {
    what = "has a density that is not positive: rho";
    value = rho;
  } else if (sqrt(speed2) * dt > particles->spacing) {
    what = "moved more than its spacing in one step: |v| dt";
    value = sqrt(speed2) * dt;
  } else if (outside) {
    value = 0;
    for (int d = 0; d < dim; d++) {
      const double away =
          fmax(flow->cloud.domain_lo[d] - x[d][i], x[d][i] - flow->cloud.domain_hi[d]);
      if (!flow->cloud.periodic[d] && !(away < value)) value = away;
    }
  }
  return SPHI_ERROR(
      flow->context, SPH_E_DIVERGED,
      "particles \"%s\": particle %lld at (%g, %g, %g) m, time %g s, step %g s, %s = %g",
      particles->name, (long long)particles->id[i], x[0][i], x[1][i], dim == 3 ? x[2][i] : 0.0,
      flow->stats.time + dt, dt, what, value);
}
