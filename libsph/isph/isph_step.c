/* A step of incompressible SPH: velocities without pressure, the pressure that takes their divergence away,
 * velocities with it. */
#include "isph/isph_impl.h"

/* In spacings, the farthest that a particle is shifted in a step. */
static const double SHIFT_MAX = 0.1;

/* Time steps over sqrt(h / g): forces on walls are noisy from three times this on. What particles suffer in
 * impacts is no limit, since pressures would grow with shorter steps. */
static const double FALL = 0.07;

/* Over the same, what no flow needs: a particle has got an absurd speed. */
static const double LEAST = 1e-5;

static double **field(const sph_integrator *flow, int number) {
  return flow->particles->field[number].data;
}

static sph_status reserve(sph_integrator *flow, int32_t n) {
  isph *s = isph_of(flow);
  bool ok = sphi_reserve(flow->context, (void **)&s->open, &s->open_capacity, n, sizeof *s->open);
  for (int k = 0; k < ISPH_ARRAYS && ok; k++)
    ok = sphi_reserve(flow->context, &s->array[k], &s->array_capacity[k], (int64_t)n + SPHI_PAD,
                      flow->variant->real_size);
  for (int d = 0; d < flow->particles->dim && ok; d++)
    ok = sphi_reserve(flow->context, (void **)&s->between[d], &s->between_capacity[d], n,
                      sizeof *s->between[d]);
  SPH_CHECK(flow->context, ok, SPH_E_MEMORY, "isph: no memory for %d particles", n);
  return SPH_OK;
}

void sphi_isph_pack(sph_integrator *flow, double *const *v, const double *last) {
  const double begin = sphi_seconds();
  const int dim = flow->particles->dim;
  sphi_pack pack = {.frame = &flow->frame,
                    .n = flow->particles->n,
                    .stride = SPHI_RECORD(dim),
                    .columns = dim + 3,
                    .record = flow->record};
  for (int d = 0; d < dim; d++) {
    pack.x[d] = field(flow, SPHI_X)[d];
    pack.value[2 + d] = v[d];
  }
  pack.value[0] = field(flow, SPHI_VOL)[0];
  pack.value[1] = field(flow, SPHI_P)[0];
  pack.value[2 + dim] = last;
  sphi_pack_run(flow->context, flow->variant, &pack);
  flow->stats.seconds_pack += sphi_seconds() - begin;
}

/* Densities are the reference density, masses those of the volumes. */
static void set_masses(sph_integrator *flow) {
  const double *volume = field(flow, SPHI_VOL)[0];
  double *m = field(flow, SPHI_M)[0], *rho = field(flow, SPHI_RHO)[0];
  for (int32_t i = 0; i < flow->particles->n; i++) {
    rho[i] = flow->cloud.rho0;
    m[i] = volume[i] * rho[i];
  }
}

/* How the ghosts' pressures follow from the fluid's where it is now. */
static sph_status find_rows(sph_integrator *flow, double t) {
  sph_boundary *boundary = flow->cloud.boundary;
  const double begin = sphi_seconds();
  if (!boundary) return SPH_OK;
  if (sphi_boundary_moves(boundary)) SPH_TRY(sphi_boundary_move(boundary, t));
  SPH_TRY(sphi_boundary_rows(boundary, &flow->frame, field(flow, SPHI_X), field(flow, SPHI_VOL)[0],
                             &flow->cloud.force, t, flow->cloud.rho0, &isph_of(flow)->rows));
  if (isph_of(flow)->walls != SPH_ISPH_WALLS_GHOSTS) SPH_TRY(sphi_isph_dummies_rows(flow, t));
  flow->stats.seconds_boundary += sphi_seconds() - begin;
  return SPH_OK;
}

/* Velocities at the end of the step but for the pressure, from records of positions there and velocities at
 * its start. */
static sph_status predict(sph_integrator *flow, double t, double dt) {
  isph *s = isph_of(flow);
  const int dim = flow->particles->dim;
  const int32_t n = flow->particles->n;
  const sphi_body_force *force = &flow->cloud.force;
  double **x = field(flow, SPHI_X), **v = field(flow, SPHI_V);
  if (s->nu > 0) {
    sphi_viscosity_arguments a = {.nu = s->nu};
    for (int d = 0; d < dim; d++) a.acceleration[d] = s->array[ISPH_PUSH + d];
    SPH_TRY(sphi_cloud_update_ghosts(flow, t + dt, 0));
    sphi_cloud_sweep(flow, SPHI_OPERATOR_viscosity, &a);
  }
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) if (n > 1024)
  for (int32_t i = 0; i < n; i++) {
    double f[SPHI_MAX_DIM] = {0}, at[SPHI_MAX_DIM];
    for (int d = 0; d < dim; d++) at[d] = x[d][i];
    if (force->function) force->function(t, at, f, force->user);
    for (int d = 0; d < dim; d++)
      s->between[d][i] = v[d][i] + dt * (force->constant[d] + f[d] +
                                         (s->nu > 0 ? isph_get(flow, ISPH_PUSH + d, i) : 0));
  }
  return SPH_OK;
}

/* The pressure for the positions in the records, and what it does to velocities. */
static sph_status project(sph_integrator *flow, double t, double dt) {
  isph *s = isph_of(flow);
  const int dim = flow->particles->dim;
  sphi_isph_pack(flow, s->between, s->open);
  SPH_TRY(sphi_cloud_update_ghosts(flow, t, dt));
  if (flow->cloud.boundary && s->walls != SPH_ISPH_WALLS_GHOSTS)
    sphi_isph_dummies_velocities(flow, t, dt);
  sphi_projection_arguments a = {.filling = s->array[ISPH_FILLING]};
  for (int k = 0; k < dim * dim; k++) a.shear[k] = s->array[ISPH_SHEAR + k];
  for (int d = 0; d < dim; d++) {
    a.normal[d] = s->array[ISPH_NORMAL + d];
    a.walls[d] = s->array[ISPH_WALLS + d];
  }
  for (int k = 0; k < (dim == 2 ? 3 : 6); k++) a.moment[k] = s->array[ISPH_MOMENT + k];
  sphi_cloud_sweep(flow, SPHI_OPERATOR_projection, &a);
  return sphi_isph_solve(flow, dt);
}

/* Acceleration by the pressures: -grad p / rho0. */
static void push(sph_integrator *flow) {
  isph *s = isph_of(flow);
  sphi_isph_pack(flow, s->between, s->open);
  sphi_rates_arguments a = {
      .divergence = s->array[ISPH_DIVERGENCE], .record = flow->record, .m = field(flow, SPHI_M)[0]};
  for (int d = 0; d < flow->particles->dim; d++) a.acceleration[d] = s->array[ISPH_PUSH + d];
  sphi_cloud_sweep(flow, SPHI_OPERATOR_rates, &a);
  flow->stats.evaluations++;
}

/* The corrected acceleration of particle i: differences of pressure with renormalised gradients, exact for
 * linear pressures; where it is open, air in the place of the neighbours that are missing. */
static void correct(const sph_integrator *flow, int32_t i, double *a) {
  const int dim = flow->particles->dim;
  const double p = field(flow, SPHI_P)[0][i] / flow->cloud.rho0, open = isph_of(flow)->open[i];
  double plain[SPHI_MAX_DIM];
  for (int d = 0; d < dim; d++) plain[d] = a[d] + 2 * p * isph_get(flow, ISPH_NORMAL + d, i);
  isph_times_moment(flow, i, plain, a);
  for (int d = 0; d < dim && open > 0; d++)
    a[d] += open * (plain[d] - a[d]) - p * isph_get(flow, ISPH_AIR + d, i);
}

/* Takes from `by` what goes along `normal`; `both` ways, or only that way. */
static void remove_part(int dim, const double *normal, bool both, double *by) {
  double size2 = 0, along = 0;
  for (int d = 0; d < dim; d++) {
    size2 += normal[d] * normal[d];
    along += normal[d] * by[d];
  }
  for (int d = 0; d < dim && size2 > 0 && (both || along > 0); d++)
    by[d] -= along / size2 * normal[d];
}

/* How particle i is shifted against the gradient of the filling, so that particles do not line up along
 * streamlines: Lind et al. (2012). Near the surface only along it, and not where it meets a wall; never towards
 * a wall: ghosts do not move with particles, and would not push them back. */
static void shift(const sph_integrator *flow, int32_t i, double *by) {
  const isph *s = isph_of(flow);
  const int dim = flow->particles->dim;
  double up[SPHI_MAX_DIM], walls[SPHI_MAX_DIM], size2 = 0, up2 = 0, walls2 = 0;
  for (int d = 0; d < dim; d++) {
    by[d] = -s->shifting * pow(flow->kernel->h, 2) * isph_get(flow, ISPH_NORMAL + d, i);
    up[d] = isph_get(flow, ISPH_UP + d, i);
    walls[d] = isph_get(flow, ISPH_WALLS + d, i);
    up2 += up[d] * up[d];
    walls2 += walls[d] * walls[d];
  }
  const bool still = s->open[i] >= 0.5 || (up2 > 0 && walls2 > 0);
  remove_part(dim, up, true, by);
  remove_part(dim, walls, false, by);
  for (int d = 0; d < dim; d++) size2 += by[d] * by[d];
  const double most = SHIFT_MAX * flow->particles->spacing, size = sqrt(size2);
  for (int d = 0; d < dim; d++) by[d] *= still ? 0 : fmin(1, most / fmax(size, most * 1e-9));
}

sph_status sphi_isph_step(sph_integrator *flow, double dt) {
  isph *s = isph_of(flow);
  sphi_cloud *c = &flow->cloud;
  const int dim = flow->particles->dim;
  const int32_t n = flow->particles->n;
  double **x = field(flow, SPHI_X), **v = field(flow, SPHI_V), **a = field(flow, c->acceleration);
  const double t = flow->stats.time;
  if (c->boundary && sphi_boundary_is_driven(c->boundary))
    SPH_TRY(sphi_boundary_drive(c->boundary, t, dt, c->rho0));
  c->packed = false;
  c->travel = sphi_cloud_travel_in(flow, dt);
  if (flow->stats.max_speed * dt > flow->particles->spacing)
    for (int32_t i = 0; i < n; i++) {
      double speed2 = 0;
      for (int d = 0; d < dim; d++) speed2 += v[d][i] * v[d][i];
      if (sqrt(speed2) * dt > flow->particles->spacing) return sphi_cloud_report(flow, i, dt);
    }
  for (int d = 0; d < dim; d++)
    for (int32_t i = 0; i < n; i++) x[d][i] += dt * v[d][i];
  sphi_isph_pack(flow, v, s->open);
  sph_status status = find_rows(flow, t + dt);
  if (status == SPH_OK) status = predict(flow, t, dt);
  if (status == SPH_OK) status = project(flow, t + dt, dt);
  if (status != SPH_OK) { /* as it was, with the best pressure there is */
    for (int d = 0; d < dim; d++)
      for (int32_t i = 0; i < n; i++) x[d][i] -= dt * v[d][i];
    return status;
  }
  push(flow);
  const double begin = sphi_seconds();
  double most_speed2 = 0, most_push2 = 0;
  int32_t bad = INT32_MAX;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) if (n > 1024) \
    reduction(max                                                                           \
              : most_speed2, most_push2) reduction(min                                      \
                                                   : bad)
  for (int32_t i = 0; i < n; i++) {
    double by[SPHI_MAX_DIM], force[SPHI_MAX_DIM], speed2 = 0, push2 = 0;
    for (int d = 0; d < dim; d++) force[d] = isph_get(flow, ISPH_PUSH + d, i);
    if (s->gradient == SPH_ISPH_GRADIENT_CORRECTED) correct(flow, i, force);
    for (int d = 0; d < dim; d++) {
      const double now =
          s->between[d][i] + dt * force[d] + s->collisions * isph_get(flow, ISPH_COLLISION + d, i);
      a[d][i] = (now - v[d][i]) / dt;
      x[d][i] += 0.5 * dt * (now - v[d][i]);
      v[d][i] = now;
      speed2 += now * now;
      push2 += a[d][i] * a[d][i];
    }
    shift(flow, i, by);
    bool fine = push2 < HUGE_VAL && speed2 * dt * dt <= pow(flow->particles->spacing, 2);
    for (int d = 0; d < dim; d++) {
      x[d][i] += by[d];
      fine = fine && (c->periodic[d] || (x[d][i] >= c->domain_lo[d] && x[d][i] <= c->domain_hi[d]));
    }
    if (!fine && i < bad) bad = i;
    most_speed2 = fmax(most_speed2, speed2);
    most_push2 = fmax(most_push2, push2);
  }
  if (bad < INT32_MAX) return sphi_cloud_report(flow, bad, dt);
  flow->stats.max_speed = sqrt(most_speed2);
  flow->stats.max_acceleration = sqrt(most_push2);
  sphi_cloud_damp(flow, dt);
  SPH_TRY(sphi_cloud_stop_at_walls(flow, dt));
  sphi_cloud_has_moved(flow, dt);
  flow->stats.seconds_update += sphi_seconds() - begin;
  return SPH_OK;
}

double sphi_isph_limit(const sph_integrator *flow, sph_limiter *limiter) {
  const isph *s = isph_of(flow);
  const double h = flow->kernel->h, *g = flow->cloud.force.constant;
  const double speed = fmax(flow->stats.max_speed, sphi_cloud_wall_speed(flow));
  const double push = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  double dt = HUGE_VAL;
  *limiter = SPH_LIMITER_VELOCITY;
  if (speed > 0) dt = sphi_integrator_courant(flow) * h / speed;
  if (push > 0 && FALL * sqrt(h / push) < dt) {
    dt = FALL * sqrt(h / push);
    *limiter = SPH_LIMITER_ACCELERATION;
  }
  if (s->nu > 0 && 0.125 * h * h / s->nu < dt) {
    dt = 0.125 * h * h / s->nu;
    *limiter = SPH_LIMITER_VISCOSITY;
  }
  return push > 0 && dt < LEAST * sqrt(h / push) ? 0 : dt;
}

/* The pressure that the state has before any step. */
static sph_status start(sph_integrator *flow) {
  sph_limiter unused;
  const double t = flow->stats.time;
  const double dt = flow->fixed_dt > 0 ? flow->fixed_dt : sphi_isph_limit(flow, &unused);
  SPH_CHECK(flow->context, isfinite(dt), SPH_E_ARGUMENT,
            "isph: nothing moves and nothing pushes, so that the time step has no limit; call "
            "sph_integrator_set_dt");
  flow->cloud.travel = sphi_cloud_travel_in(flow, dt);
  sphi_isph_pack(flow, field(flow, SPHI_V), isph_of(flow)->open);
  SPH_TRY(find_rows(flow, t));
  SPH_TRY(predict(flow, t, dt));
  SPH_TRY(project(flow, t, dt));
  flow->cloud.packed = false;
  return SPH_OK;
}

sph_status sphi_isph_refresh(sph_integrator *flow) {
  if (flow->revision != flow->particles->revision) {
    SPH_TRY(reserve(flow, flow->particles->n));
    set_masses(flow);
    SPH_TRY(sphi_cloud_prepare(flow));
    sphi_solver_renumbered(isph_of(flow)->solver);
    const sph_status status = start(flow);
    if (status != SPH_OK) flow->revision = -1;
    SPH_TRY(status);
  } else if (!sphi_cloud_reaches(flow)) {
    SPH_TRY(sphi_cloud_build(flow));
    sphi_solver_renumbered(isph_of(flow)->solver);
  }
  if (!flow->cloud.packed) sphi_isph_pack(flow, field(flow, SPHI_V), isph_of(flow)->open);
  flow->cloud.packed = true;
  return SPH_OK;
}

sph_status sphi_isph_keep(sph_integrator *flow, sphi_keep *keep) {
  isph *s = isph_of(flow);
  int64_t has_surface = s->has_surface;
  int64_t *const counts[] = {&s->surface_count, &has_surface};
  SPH_TRY(sphi_cloud_keep(flow, keep));
  if (keep->act == SPHI_KEEP_CHECK) SPH_TRY(reserve(flow, keep->n));
  SPH_TRY(sphi_keep_wholes(keep, "isph/surface", 2, counts));
  SPH_TRY(sphi_keep_section(keep, "isph/open", SPHI_KEEP_REALS, keep->n, s->open));
  if (keep->act == SPHI_KEEP_LOAD) s->has_surface = has_surface != 0;
  if (keep->act != SPHI_KEEP_CHECK) s->dummies.ghosts = 0; /* both runs forget pressures of walls */
  return SPH_OK;
}
