/* Lists of the fluid and of the ghosts near it, and what moves them on. */
#include "integrator/integrator_impl.h"

/* Below so many particles starting threads costs more than it gains. */
enum { PARALLEL_FROM = 512 };

static double **field(const sph_integrator *flow, int number) {
  return flow->particles->field[number].data;
}

double sphi_cloud_wall_speed(const sph_integrator *flow) {
  return flow->cloud.boundary ? sphi_boundary_speed(flow->cloud.boundary) : 0;
}

double sphi_cloud_travel_in(const sph_integrator *flow, double dt) {
  return dt * fmax(flow->stats.max_speed + dt * flow->stats.max_acceleration,
                   sphi_cloud_wall_speed(flow));
}

void sphi_cloud_has_moved(sph_integrator *flow, double dt) {
  sphi_cloud *c = &flow->cloud;
  const double wall_speed = sphi_cloud_wall_speed(flow);
  const double speed = flow->stats.max_speed + 0.5 * dt * flow->stats.max_acceleration;
  c->travelled += dt * fmax(speed, wall_speed);
  c->odometer += dt * (speed + wall_speed);
}

/* How far a particle or wall may come in the next step. */
static double next_travel(const sph_integrator *flow) {
  sph_limiter unused;
  return sphi_cloud_travel_in(
      flow, flow->fixed_dt > 0 ? flow->fixed_dt : flow->method->limit(flow, &unused));
}

/* Share of the support by which the lists reach farther. Longer lists cost the first sums of a step and
 * the ghosts, shorter ones have to be made more often: 0.9 sqrt(travel/support) is the best or within 3 %
 * of it in tanks of 2D and 3D, measured from 0.5 to 1.2. One step must fit in any case. */
static double choose_skin(const sph_integrator *flow) {
  const double travel = next_travel(flow) / flow->kernel->support;
  const double best = fmin(fmax(0.9 * sqrt(travel), 0.02), flow->cloud.skin);
  return fmin(fmax(best, 2.2 * travel), 0.5);
}

static sph_status build(sph_integrator *flow) {
  sphi_cloud *c = &flow->cloud;
  /* The first lists are as long as any later ones, so that these find room. */
  const double skin = fmax(choose_skin(flow), c->prepared ? 0 : c->skin);
  const double radius = flow->kernel->support * (1 + skin);
  SPH_TRY(sphi_integrator_build(flow, radius));
  c->travelled = 0;
  c->packed = false;
  /* Positions jumped by a period where there is one. */
  if (!c->prepared || c->stale || c->periodic[0] || c->periodic[1] || c->periodic[2])
    sphi_cloud_forget_walls(flow);
  if (!c->boundary) return SPH_OK;
  const double begin = sphi_seconds();
  const bool moves = sphi_boundary_moves(c->boundary);
  if (moves || !c->prepared || c->stale) {
    SPH_TRY(sphi_boundary_move(c->boundary, flow->stats.time));
    SPH_TRY(sphi_boundary_sort(c->boundary, &flow->frame, flow->variant));
  }
  /* Two particles come nearer by twice what one travels; walls at rest do not come to meet it. */
  const double margin = (moves ? 1 : 0.5) * (radius - flow->kernel->support);
  /* What one wall mirrors for another comes by up to twice the other's way. */
  const double mirrored = (moves && c->boundary->walls > 1 ? 1.5 : 1) * margin;
  SPH_TRY(sphi_list_build(flow->context, &c->ghost_list, &flow->frame, &flow->clusters,
                          &c->boundary->columns, flow->kernel->support + margin));
  SPH_TRY(sphi_boundary_list(c->boundary, &flow->frame, flow->variant, &flow->columns,
                             c->boundary->interpolator->kernel->support + mirrored,
                             &c->ghost_list));
  flow->stats.seconds_search += sphi_seconds() - begin;
  return SPH_OK;
}

sph_status sphi_cloud_build(sph_integrator *flow) {
  const sph_status status = build(flow);
  if (status == SPH_OK)
    flow->cloud.stale = false;
  else
    flow->revision = -1; /* whatever is half done is done anew */
  return status;
}

/* Bounding box of particles and ghosts, made larger by its own size. */
static void default_domain(sph_integrator *flow) {
  sphi_cloud *c = &flow->cloud;
  for (int d = 0; d < flow->particles->dim; d++) {
    const double *x = field(flow, SPHI_X)[d];
    double lo = x[0], hi = x[0];
    for (int32_t i = 1; i < flow->particles->n; i++) {
      lo = fmin(lo, x[i]);
      hi = fmax(hi, x[i]);
    }
    for (int64_t k = 0; c->boundary && k < c->boundary->points.n; k++) {
      const double at = c->boundary->points.x[flow->particles->dim * k + d];
      lo = fmin(lo, at);
      hi = fmax(hi, at);
    }
    const double size = fmax(hi - lo, flow->kernel->support);
    c->domain_lo[d] = lo - size;
    c->domain_hi[d] = hi + size;
  }
}

static double largest_speed(const sph_integrator *flow) {
  double **v = field(flow, SPHI_V), most2 = 0;
  for (int32_t i = 0; i < flow->particles->n; i++) {
    double v2 = 0;
    for (int d = 0; d < flow->particles->dim; d++) v2 += v[d][i] * v[d][i];
    most2 = fmax(most2, v2);
  }
  return sqrt(most2);
}

sph_status sphi_cloud_prepare(sph_integrator *flow) {
  sphi_cloud *c = &flow->cloud;
  sph_context *context = flow->context;
  const sph_particles *particles = flow->particles;
  SPH_CHECK(context, particles->n > 0, SPH_E_ARGUMENT, "%s: particles \"%s\" are none",
            flow->method->name, particles->name);
  SPH_CHECK(context,
            !c->boundary || sphi_reserve(context, (void **)&c->clear, &c->clear_capacity,
                                         particles->n, sizeof *c->clear),
            SPH_E_MEMORY, "%s: no memory for %d particles", flow->method->name, particles->n);
  double origin[SPHI_MAX_DIM];
  for (int d = 0; d < particles->dim; d++)
    origin[d] = particles->field[SPHI_X].data[d][particles->slot[0]];
  sphi_frame_set(&flow->frame, particles->dim, origin, flow->kernel->support, c->periodic,
                 c->periodic_lo, c->periodic_hi);
  if (c->boundary) {
    SPH_TRY(sphi_boundary_place_walls(c->boundary, flow->stats.time));
    SPH_TRY(sphi_cloud_check_walls(flow));
    SPH_TRY(sphi_boundary_prepare(c->boundary));
  }
  flow->stats.max_speed = largest_speed(flow); /* lists must reach as far as a step goes */
  if (flow->stats.max_acceleration == 0) { /* before the first step only the body force is known */
    const double *g = c->force.constant;
    flow->stats.max_acceleration = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  }
  c->prepared = false;
  SPH_TRY(sphi_cloud_build(flow));
  /* The places of the density gradient must be zero where no gradient is taken. */
  memset(flow->record, 0, (size_t)flow->record_capacity * flow->variant->real_size);
  c->prepared = true;
  if (!c->domain_given) default_domain(flow);
  return SPH_OK;
}

bool sphi_cloud_reaches(const sph_integrator *flow) {
  const double reach = 0.5 * (flow->list_radius - flow->kernel->support);
  return !flow->cloud.stale && flow->cloud.travelled + next_travel(flow) <= reach;
}

sph_status sphi_cloud_update_ghosts(sph_integrator *flow, double t, double ahead) {
  sphi_cloud *c = &flow->cloud;
  if (!c->boundary) return SPH_OK;
  const double begin = sphi_seconds();
  if (sphi_boundary_moves(c->boundary)) SPH_TRY(sphi_boundary_move(c->boundary, t));
  sphi_boundary_update(c->boundary, &flow->frame, flow->variant, flow->record, &c->force, t,
                       c->rho0, ahead);
  flow->stats.seconds_boundary += sphi_seconds() - begin;
  return SPH_OK;
}

void sphi_cloud_sweep(sph_integrator *flow, int operator_index, const void *arguments) {
  const double begin = sphi_seconds();
  const sphi_cloud *c = &flow->cloud;
  sphi_sweep sweep = {.frame = &flow->frame,
                      .kernel = flow->kernel,
                      .targets = &flow->clusters,
                      .target = flow->record,
                      .target_stride = SPHI_RECORD(flow->particles->dim),
                      .prune = flow->kernel->support + 2 * c->travel};
  sweep.source[0].list = &flow->list;
  sweep.source[0].record = flow->record;
  if (c->boundary) {
    sweep.source[1].list = &c->ghost_list;
    sweep.source[1].record = c->boundary->record;
  }
  sphi_sweep_run(flow->context, flow->variant, operator_index, &sweep, arguments);
  flow->stats.pairs += sphi_sweep_pairs(&sweep);
  flow->stats.seconds_pairs += sphi_seconds() - begin;
}

/* Rate at which damping zones take velocity from a particle. */
static double damping_rate(const sph_integrator *flow, int32_t i) {
  const sphi_cloud *c = &flow->cloud;
  double rate = 0;
  for (int k = 0; k < c->zones; k++) {
    const sphi_damping_zone *zone = &c->zone[k];
    const double x = sphi_frame_wrap(&flow->frame, zone->axis, field(flow, SPHI_X)[zone->axis][i]);
    const double way = fmin(fmax((x - zone->from) / (zone->to - zone->from), 0), 1);
    rate += zone->rate * way * way;
  }
  return rate;
}

/* Takes from velocities what damping zones do in a step. An exponential never turns them, however long the
 * step; accelerations stay, since pressures do not know of velocities. */
void sphi_cloud_damp(sph_integrator *flow, double dt) {
  double **v = field(flow, SPHI_V);
  const int32_t n = flow->particles->n;
  if (flow->cloud.zones == 0) return;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) if (n > PARALLEL_FROM)
  for (int32_t i = 0; i < n; i++) {
    const double rate = damping_rate(flow, i);
    if (rate == 0) continue;
    const double factor = exp(-dt * rate);
    for (int d = 0; d < flow->particles->dim; d++) v[d][i] *= factor;
  }
}
