/* Evaluation of the rates and the time steppers of weakly compressible SPH. */
#include "wcsph/wcsph_impl.h"

/* Smallest eigenvalue of the moment matrix: below LAMBDA_MIN a gradient is not trusted, below
 * LAMBDA_ISOLATED a particle is a drop or a thread (Marrone et al. 2010). */
#define LAMBDA_MIN 0.1
#define LAMBDA_ISOLATED 0.2

typedef double *restrict array;

static double **field(const sph_integrator *flow, int number) {
  return flow->particles->field[number].data;
}

static sph_status reserve(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  const int32_t n = flow->particles->n;
  const int dim = flow->particles->dim;
  const int used = flow->stepper == SPH_STEPPER_RK4 ? WCSPH_ARRAYS : WCSPH_ARRAYS_PLAIN;
  bool ok = sphi_reserve(flow->context, (void **)&w->block, &w->block_capacity,
                         n / UPDATE_BLOCK + 1, sizeof *w->block);
  for (int k = 0; k < used && ok; k++) {
    const bool third = k == WCSPH_VISCOUS + 2 || k == WCSPH_OLD_X + 2 || k == WCSPH_OLD_V + 2 ||
                       k == WCSPH_SUM_X + 2 || k == WCSPH_SUM_V + 2;
    if (third && dim == 2) continue;
    ok = sphi_reserve(flow->context, (void **)&w->array[k], &w->array_capacity[k], n,
                      sizeof(double));
  }
  SPH_CHECK(flow->context, ok, SPH_E_MEMORY, "wcsph: no memory for %d particles", n);
  return SPH_OK;
}

/* Pressure and volume of particles begin..end-1 by their densities. */
static void apply_equation_of_state(sph_integrator *flow, int32_t begin, int32_t end) {
  const wcsph *w = wcsph_of(flow);
  const array rho = field(flow, SPHI_RHO)[0], m = field(flow, SPHI_M)[0];
  array p = field(flow, SPHI_P)[0], volume = field(flow, SPHI_VOL)[0];
  for (int32_t i = begin; i < end; i++) {
    p[i] = sphi_wcsph_pressure(w, rho[i]);
    volume[i] = m[i] / rho[i];
  }
}

/* Particles are updated in blocks, so that what one pass wrote is at hand in the next. */
static int32_t block_count(const sph_integrator *flow) {
  return (flow->particles->n + UPDATE_BLOCK - 1) / UPDATE_BLOCK;
}

static int32_t block_end(const sph_integrator *flow, int32_t block) {
  const int32_t end = (block + 1) * UPDATE_BLOCK, n = flow->particles->n;
  return end < n ? end : n;
}

/* Records from the fields: `all` values, or positions, volume and pressure alone (the density that the
 * diffusion sees then stays the one its gradient was taken of). */
static sphi_pack packing(sph_integrator *flow, bool all) {
  const wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  sphi_pack to = {.frame = &flow->frame,
                  .n = flow->particles->n,
                  .stride = SPHI_RECORD(dim),
                  .columns = all ? dim + 3 : 2,
                  .record = flow->record};
  to.value[0] = field(flow, SPHI_VOL)[0];
  to.value[1] = field(flow, SPHI_P)[0];
  for (int d = 0; d < dim; d++) {
    to.x[d] = field(flow, SPHI_X)[d];
    to.value[2 + d] = field(flow, SPHI_V)[d];
  }
  to.value[2 + dim] = field(flow, SPHI_RHO)[0];
  to.shift[2 + dim] = w->rho0;
  return to;
}

/* Pressures anew if `fresh`. */
static void pack(sph_integrator *flow, bool all, bool fresh) {
  const double begin = sphi_seconds();
  const sphi_pack to = packing(flow, all);
#pragma omp parallel for num_threads(flow->context->threads) schedule(static)
  for (int32_t block = 0; block < block_count(flow); block++) {
    const int32_t first = block * UPDATE_BLOCK, last = block_end(flow, block);
    if (fresh) apply_equation_of_state(flow, first, last);
    flow->variant->pack(&to, first, last);
  }
  flow->stats.seconds_pack += sphi_seconds() - begin;
}

static sph_status update_ghosts(sph_integrator *flow, double t) {
  wcsph *w = wcsph_of(flow);
  if (!w->boundary) return SPH_OK;
  const double begin = sphi_seconds();
  if (sphi_boundary_moves(w->boundary)) SPH_TRY(sphi_boundary_move(w->boundary, t));
  sphi_boundary_update(w->boundary, &flow->frame, flow->variant, flow->record, &w->force, t,
                       w->rho0);
  flow->stats.seconds_boundary += sphi_seconds() - begin;
  return SPH_OK;
}

static void run(sph_integrator *flow, int operator_index, const void *arguments) {
  const double begin = sphi_seconds();
  const wcsph *w = wcsph_of(flow);
  sphi_sweep sweep = {.frame = &flow->frame,
                      .kernel = flow->kernel,
                      .targets = &flow->clusters,
                      .target = flow->record,
                      .target_stride = SPHI_RECORD(flow->particles->dim),
                      .prune = flow->kernel->support + 2 * w->travel};
  sweep.source[0].list = &flow->list;
  sweep.source[0].record = flow->record;
  if (w->boundary) {
    sweep.source[1].list = &w->ghost_list;
    sweep.source[1].record = w->boundary->record;
  }
  sphi_sweep_run(flow->context, flow->variant, operator_index, &sweep, arguments);
  flow->stats.seconds_pairs += sphi_seconds() - begin;
}

/* Divergence, and the density gradient if the diffusion needs it. */
static void run_gradient(sph_integrator *flow) {
  const wcsph *w = wcsph_of(flow);
  const sphi_gradient_arguments a = {
      .record = w->diffusion == SPH_DIFFUSION_DELTA ? flow->record : NULL,
      .divergence = w->array[WCSPH_DIVERGENCE],
      .lambda = w->array[WCSPH_LAMBDA],
      .lambda_min = LAMBDA_MIN};
  run(flow, SPHI_OPERATOR_gradient, &a);
}

/* Acceleration by pressure and viscosity into the acceleration field (the viscous part apart if
 * `split`), density diffusion into its array. */
static void run_momentum(sph_integrator *flow, bool split) {
  wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  const double h = flow->kernel->h;
  sphi_momentum_arguments a = {
      .diffusion = w->diffusion == SPH_DIFFUSION_NONE ? NULL : w->array[WCSPH_DIFFUSION],
      .rho = field(flow, SPHI_RHO)[0],
      .lambda = w->diffusion == SPH_DIFFUSION_DELTA ? w->array[WCSPH_LAMBDA] : NULL,
      .lambda_min = LAMBDA_MIN,
      .viscosity = w->alpha * h * w->c0 + 2 * (dim + 2) * w->nu,
      .delta = w->delta * h * w->c0,
      .rho0 = w->rho0};
  for (int d = 0; d < dim; d++) {
    a.acceleration[d] = field(flow, w->acceleration)[d];
    a.viscous[d] = split ? w->array[WCSPH_VISCOUS + d] : NULL;
  }
  run(flow, SPHI_OPERATOR_momentum, &a);
  flow->stats.evaluations++;
}

static sph_status report_bad(sph_integrator *flow, int32_t i, double dt);

/* Adds the body force at the places of particles begin..end-1 to their accelerations. Returns the first
 * whose values cannot be, INT32_MAX if none: a later evaluation would spread them over its neighbours. */
static int32_t add_body_force(sph_integrator *flow, double t, int32_t begin, int32_t end) {
  const wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  double **a = field(flow, w->acceleration), **x = field(flow, SPHI_X);
  const array rho = field(flow, SPHI_RHO)[0];
  for (int32_t i = begin; i < end && w->force.function; i++) {
    double f[SPHI_MAX_DIM] = {0}, at[SPHI_MAX_DIM];
    for (int d = 0; d < dim; d++) at[d] = x[d][i];
    w->force.function(t, at, f, w->force.user);
    for (int d = 0; d < dim; d++) a[d][i] += f[d];
  }
  for (int d = 0; d < dim; d++) {
    array along = a[d];
    const double constant = w->force.constant[d];
    for (int32_t i = begin; i < end; i++) along[i] += constant;
  }
  for (int32_t i = begin; i < end; i++) {
    double a2 = 0;
    for (int d = 0; d < dim; d++) a2 += a[d][i] * a[d][i];
    if (!(a2 < HUGE_VAL && rho[i] > 0)) return i;
  }
  return INT32_MAX;
}

static sph_status add_body_forces(sph_integrator *flow, double t, double dt) {
  int32_t bad = INT32_MAX;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) reduction(min : bad)
  for (int32_t block = 0; block < block_count(flow); block++) {
    const int32_t found = add_body_force(flow, t, block * UPDATE_BLOCK, block_end(flow, block));
    if (found < bad) bad = found;
  }
  return bad == INT32_MAX ? SPH_OK : report_bad(flow, bad, dt);
}

/* y += factor * rate for positions, velocities or densities; at most one array a direction. */
static void advance(sph_integrator *flow, int directions, double *const *y, double factor,
                    double *const *rate) {
#pragma omp parallel for num_threads(flow->context->threads) schedule(static)
  for (int32_t i = 0; i < flow->particles->n; i++)
    for (int d = 0; d < directions; d++) y[d][i] += factor * rate[d][i];
}

/* rho += -dt rho D */
static void advance_density(sph_integrator *flow, double dt) {
  array rho = field(flow, SPHI_RHO)[0];
  const array divergence = wcsph_of(flow)->array[WCSPH_DIVERGENCE];
#pragma omp parallel for num_threads(flow->context->threads) schedule(static)
  for (int32_t i = 0; i < flow->particles->n; i++) rho[i] -= dt * rho[i] * divergence[i];
}

static void advance_diffusion(sph_integrator *flow, double dt) {
  const wcsph *w = wcsph_of(flow);
  double *rate = w->array[WCSPH_DIFFUSION];
  if (w->diffusion != SPH_DIFFUSION_NONE) advance(flow, 1, field(flow, SPHI_RHO), dt, &rate);
}

static sph_status report_bad(sph_integrator *flow, int32_t i, double dt) {
  const wcsph *w = wcsph_of(flow);
  const sph_particles *particles = flow->particles;
  const int dim = particles->dim;
  double **x = field(flow, SPHI_X), **v = field(flow, SPHI_V), **a = field(flow, w->acceleration);
  const double rho = field(flow, SPHI_RHO)[0][i];
  double speed2 = 0, push2 = 0;
  bool outside = false;
  for (int d = 0; d < dim; d++) {
    speed2 += v[d][i] * v[d][i];
    push2 += a[d][i] * a[d][i];
    outside =
        outside || (!w->periodic[d] && !(x[d][i] >= w->domain_lo[d] && x[d][i] <= w->domain_hi[d]));
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
      const double away = fmax(w->domain_lo[d] - x[d][i], x[d][i] - w->domain_hi[d]);
      if (!w->periodic[d] && !(away < value)) value = away;
    }
  }
  return SPHI_ERROR(
      flow->context, SPH_E_DIVERGED,
      "particles \"%s\": particle %lld at (%g, %g, %g) m, time %g s, step %g s, %s = %g",
      particles->name, (long long)particles->id[i], x[0][i], x[1][i], dim == 3 ? x[2][i] : 0.0,
      flow->stats.time + dt, dt, what, value);
}

/* Largest speed and acceleration after a step; stops at the first bad particle by storage order. */
static sph_status check_state(sph_integrator *flow, double dt) {
  wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  double **x = field(flow, SPHI_X), **v = field(flow, SPHI_V), **a = field(flow, w->acceleration);
  const array rho = field(flow, SPHI_RHO)[0];
  const double most2 = pow(flow->particles->spacing / dt, 2);
#pragma omp parallel for num_threads(flow->context->threads) schedule(static)
  for (int32_t block = 0; block < block_count(flow); block++) {
    const int32_t end = block_end(flow, block);
    sphi_extremes found = {0, 0, -1};
    for (int32_t i = block * UPDATE_BLOCK; i < end; i++) {
      double v2 = 0, a2 = 0;
      bool inside = true;
      for (int d = 0; d < dim; d++) {
        v2 += v[d][i] * v[d][i];
        a2 += a[d][i] * a[d][i];
        inside = inside &&
                 (w->periodic[d] || (x[d][i] >= w->domain_lo[d] && x[d][i] <= w->domain_hi[d]));
      }
      const bool good = v2 <= most2 && a2 < HUGE_VAL && inside && rho[i] > 0 && rho[i] < HUGE_VAL;
      if (!good && found.bad < 0) found.bad = i;
      if (v2 > found.speed2) found.speed2 = v2;
      if (a2 > found.acceleration2) found.acceleration2 = a2;
    }
    w->block[block] = found;
  }
  sphi_extremes all = {0, 0, -1};
  for (int32_t block = block_count(flow) - 1; block >= 0; block--) {
    if (w->block[block].bad >= 0) all.bad = w->block[block].bad;
    all.speed2 = fmax(all.speed2, w->block[block].speed2);
    all.acceleration2 = fmax(all.acceleration2, w->block[block].acceleration2);
  }
  flow->stats.max_speed = sqrt(all.speed2);
  flow->stats.max_acceleration = sqrt(all.acceleration2);
  return all.bad < 0 ? SPH_OK : report_bad(flow, all.bad, dt);
}

/* Drops and threads cannot be in tension: nothing holds them together, and a density that stayed low
 * from the moment they came off would tear at whatever they meet next. Then pressures and volumes, so
 * that what a caller reads belongs together. */
static void finish_densities(sph_integrator *flow) {
  const wcsph *w = wcsph_of(flow);
  array rho = field(flow, SPHI_RHO)[0];
  const array lambda = w->array[WCSPH_LAMBDA];
#pragma omp parallel for num_threads(flow->context->threads) schedule(static)
  for (int32_t block = 0; block < block_count(flow); block++) {
    const int32_t first = block * UPDATE_BLOCK, last = block_end(flow, block);
    for (int32_t i = first; i < last; i++)
      if (lambda[i] < LAMBDA_ISOLATED && rho[i] < w->rho0) rho[i] = w->rho0;
    apply_equation_of_state(flow, first, last);
  }
}

/* Symplectic Euler, written from the density on: density with the velocities now, velocities with the
 * new density, positions with the new velocities. */
static sph_status step_symplectic(sph_integrator *flow, double dt) {
  const wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  const double t = flow->stats.time;
  SPH_TRY(update_ghosts(flow, t));
  run_gradient(flow);
  advance_density(flow, dt);
  pack(flow, false, true);
  SPH_TRY(update_ghosts(flow, t));
  run_momentum(flow, false);
  SPH_TRY(add_body_forces(flow, t, dt));
  advance(flow, dim, field(flow, SPHI_V), dt, field(flow, w->acceleration));
  SPH_TRY(sphi_wcsph_stop_at_walls(flow, dt));
  advance(flow, dim, field(flow, SPHI_X), dt, field(flow, SPHI_V));
  advance_diffusion(flow, dt);
  return SPH_OK;
}

/* Kick, drift, kick: the density rate at the middle of the drift. */
static sph_status step_verlet(sph_integrator *flow, double dt) {
  wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  const double t = flow->stats.time;
  double **x = field(flow, SPHI_X), **v = field(flow, SPHI_V), **a = field(flow, w->acceleration);
  if (!w->accelerated) {
    SPH_TRY(update_ghosts(flow, t));
    run_gradient(flow);
    run_momentum(flow, false);
    SPH_TRY(add_body_forces(flow, t, dt));
  }
  advance(flow, dim, v, 0.5 * dt, a);
  SPH_TRY(sphi_wcsph_stop_at_walls(flow, dt));
  advance(flow, dim, x, 0.5 * dt, v);
  pack(flow, true, true);
  SPH_TRY(update_ghosts(flow, t + 0.5 * dt));
  run_gradient(flow);
  advance(flow, dim, x, 0.5 * dt, v);
  advance_density(flow, dt);
  pack(flow, false, true);
  SPH_TRY(update_ghosts(flow, t + dt));
  run_momentum(flow, false);
  SPH_TRY(add_body_forces(flow, t + dt, dt));
  advance(flow, dim, v, 0.5 * dt, a);
  advance_diffusion(flow, dt);
  w->accelerated = true;
  return SPH_OK;
}

/* Rates of one Runge-Kutta stage into the sums with its weight; then the next stage's state, or after
 * the last stage (next = 0) the new one. */
static void advance_stage(sph_integrator *flow, double weight, double next, int32_t begin,
                          int32_t end) {
  wcsph *w = wcsph_of(flow);
  const bool last = next == 0;
  double *const *of = w->array;
  const array divergence = of[WCSPH_DIVERGENCE], diffusion = of[WCSPH_DIFFUSION],
              rho_old = of[WCSPH_OLD_RHO];
  array rho = field(flow, SPHI_RHO)[0], rho_sum = of[WCSPH_SUM_RHO];
  const bool diffuse = w->diffusion != SPH_DIFFUSION_NONE;
  for (int32_t i = begin; i < end; i++) {
    const double rate = (diffuse ? diffusion[i] : 0) - rho[i] * divergence[i];
    const double sum = rho_sum[i] + weight * rate;
    rho_sum[i] = sum;
    rho[i] = rho_old[i] + (last ? sum : next * rate);
  }
  for (int d = 0; d < flow->particles->dim; d++) {
    array x = field(flow, SPHI_X)[d], v = field(flow, SPHI_V)[d];
    array x_sum = of[WCSPH_SUM_X + d], v_sum = of[WCSPH_SUM_V + d];
    const array x_old = of[WCSPH_OLD_X + d], v_old = of[WCSPH_OLD_V + d],
                a = field(flow, w->acceleration)[d], viscous = of[WCSPH_VISCOUS + d];
    for (int32_t i = begin; i < end; i++) {
      const double push = a[i] + viscous[i], speed = v[i];
      const double x_new = x_sum[i] + weight * speed, v_new = v_sum[i] + weight * push;
      x_sum[i] = x_new;
      v_sum[i] = v_new;
      x[i] = x_old[i] + (last ? x_new : next * speed);
      v[i] = v_old[i] + (last ? v_new : next * push);
    }
  }
}

/* What follows the pair sums of a stage, ending with the records of the next. */
static sph_status finish_stage(sph_integrator *flow, double t, double dt, double weight,
                               double next) {
  const sphi_pack to = packing(flow, true);
  int32_t bad = INT32_MAX;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) reduction(min : bad)
  for (int32_t block = 0; block < block_count(flow); block++) {
    const int32_t first = block * UPDATE_BLOCK, last = block_end(flow, block);
    const int32_t found = add_body_force(flow, t, first, last);
    if (found < bad) bad = found;
    if (found < INT32_MAX) continue;
    advance_stage(flow, weight, next, first, last);
    if (next == 0) continue;
    apply_equation_of_state(flow, first, last);
    flow->variant->pack(&to, first, last);
  }
  return bad == INT32_MAX ? SPH_OK : report_bad(flow, bad, dt);
}

static void copy_state(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  const size_t bytes = (size_t)flow->particles->n * sizeof(double);
  memcpy(w->array[WCSPH_OLD_RHO], field(flow, SPHI_RHO)[0], bytes);
  memset(w->array[WCSPH_SUM_RHO], 0, bytes);
  for (int d = 0; d < flow->particles->dim; d++) {
    memcpy(w->array[WCSPH_OLD_X + d], field(flow, SPHI_X)[d], bytes);
    memcpy(w->array[WCSPH_OLD_V + d], field(flow, SPHI_V)[d], bytes);
    memset(w->array[WCSPH_SUM_X + d], 0, bytes);
    memset(w->array[WCSPH_SUM_V + d], 0, bytes);
  }
}

/* Runge-Kutta 4 with the diffusive terms of the first stage kept through the step. */
static sph_status step_rk4(sph_integrator *flow, double dt) {
  static const double weight[4] = {1, 2, 2, 1}, place[4] = {0, 0.5, 0.5, 1};
  wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  copy_state(flow);
  for (int k = 0; k < 4; k++) {
    const double t = flow->stats.time + place[k] * dt;
    SPH_TRY(update_ghosts(flow, t));
    if (k == 0) {
      run_gradient(flow);
      run_momentum(flow, true);
    } else {
      sphi_rates_arguments a = {.divergence = w->array[WCSPH_DIVERGENCE],
                                .rho = field(flow, SPHI_RHO)[0]};
      for (int d = 0; d < dim; d++) a.acceleration[d] = field(flow, w->acceleration)[d];
      run(flow, SPHI_OPERATOR_rates, &a);
      flow->stats.evaluations++;
    }
    SPH_TRY(finish_stage(flow, t, dt, weight[k] * dt / 6, k < 3 ? place[k + 1] * dt : 0));
  }
  SPH_TRY(sphi_wcsph_stop_at_walls(flow, dt));
  return SPH_OK;
}

/* Speed of the fastest wall now. */
static double wall_speed(const wcsph *w) {
  double most = 0;
  for (int k = 0; w->boundary && k < w->boundary->walls; k++) {
    const double *v = w->boundary->state[k].velocity;
    most = fmax(most, sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
  }
  return most;
}

/* How far a particle or wall may come in a time step. */
static double travel_in(const sph_integrator *flow, double dt) {
  return dt * fmax(flow->stats.max_speed + dt * flow->stats.max_acceleration,
                   wall_speed(wcsph_of(flow)));
}

sph_status sphi_wcsph_step(sph_integrator *flow, double dt) {
  wcsph *w = wcsph_of(flow);
  const double begin = sphi_seconds();
  const double others =
      flow->stats.seconds_pack + flow->stats.seconds_boundary + flow->stats.seconds_pairs;
  w->packed = false;
  w->travel = travel_in(flow, dt);
  if (flow->stats.max_speed * dt > flow->particles->spacing) SPH_TRY(check_state(flow, dt));
  if (flow->stepper == SPH_STEPPER_SYMPLECTIC)
    SPH_TRY(step_symplectic(flow, dt));
  else if (flow->stepper == SPH_STEPPER_VERLET)
    SPH_TRY(step_verlet(flow, dt));
  else
    SPH_TRY(step_rk4(flow, dt));
  finish_densities(flow);
  const sph_status status = check_state(flow, dt);
  w->travelled +=
      dt * fmax(flow->stats.max_speed + 0.5 * dt * flow->stats.max_acceleration, wall_speed(w));
  const double now =
      flow->stats.seconds_pack + flow->stats.seconds_boundary + flow->stats.seconds_pairs;
  flow->stats.seconds_update += sphi_seconds() - begin - (now - others);
  return status;
}

double sphi_wcsph_limit(const sph_integrator *flow, sph_limiter *limiter) {
  const wcsph *w = wcsph_of(flow);
  const double h = flow->kernel->h;
  double dt = sphi_integrator_courant(flow) * h / w->c0;
  *limiter = SPH_LIMITER_SOUND;
  const double push = flow->stats.max_acceleration;
  if (push > 0 && 0.25 * sqrt(h / push) < dt) {
    dt = 0.25 * sqrt(h / push);
    *limiter = SPH_LIMITER_ACCELERATION;
  }
  const double nu = w->nu + w->alpha * h * w->c0 / (2 * (flow->particles->dim + 2));
  if (nu > 0 && 0.125 * h * h / nu < dt) {
    dt = 0.125 * h * h / nu;
    *limiter = SPH_LIMITER_VISCOSITY;
  }
  return dt;
}

/* The same for the next step. */
static double next_travel(const sph_integrator *flow) {
  sph_limiter unused;
  return travel_in(flow, flow->fixed_dt > 0 ? flow->fixed_dt : sphi_wcsph_limit(flow, &unused));
}

/* Share of the support by which the lists reach farther. With a build as dear as half a step's pair
 * sums, and list lengths that grow 1.3 times as fast as the skin, its cost and that of building anew
 * balance at 0.9 sqrt(travel/support). One step must fit in any case. */
static double choose_skin(const sph_integrator *flow) {
  const double travel = next_travel(flow) / flow->kernel->support;
  const double best = fmin(fmax(0.9 * sqrt(travel), 0.02), wcsph_of(flow)->skin);
  return fmin(fmax(best, 2.2 * travel), 0.5);
}

/* Sorts and lists everything for the positions now. */
static sph_status build(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  /* The first lists are as long as any later ones, so that these find room. */
  const double skin = fmax(choose_skin(flow), w->prepared ? 0 : w->skin);
  const double radius = flow->kernel->support * (1 + skin);
  SPH_TRY(sphi_integrator_build(flow, radius));
  w->travelled = 0;
  w->packed = false;
  if (!w->boundary) return SPH_OK;
  const double begin = sphi_seconds();
  const bool moves = sphi_boundary_moves(w->boundary);
  if (moves || !w->prepared) {
    SPH_TRY(sphi_boundary_move(w->boundary, flow->stats.time));
    SPH_TRY(sphi_boundary_sort(w->boundary, &flow->frame, flow->variant));
  }
  /* Two particles come nearer by twice what one travels; walls at rest do not come to meet it. */
  const double margin = (moves ? 1 : 0.5) * (radius - flow->kernel->support);
  SPH_TRY(sphi_boundary_list(w->boundary, &flow->frame, flow->variant, &flow->columns,
                             w->boundary->interpolator->kernel->support + margin));
  SPH_TRY(sphi_list_build(flow->context, &w->ghost_list, &flow->frame, &flow->clusters,
                          &w->boundary->columns, flow->kernel->support + margin));
  flow->stats.seconds_search += sphi_seconds() - begin;
  return SPH_OK;
}

/* Bounding box of particles and ghosts, made larger by its own size. */
static void default_domain(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  for (int d = 0; d < flow->particles->dim; d++) {
    const array x = field(flow, SPHI_X)[d];
    double lo = x[0], hi = x[0];
    for (int32_t i = 1; i < flow->particles->n; i++) {
      lo = fmin(lo, x[i]);
      hi = fmax(hi, x[i]);
    }
    for (int64_t k = 0; w->boundary && k < w->boundary->points.n; k++) {
      const double at = w->boundary->points.x[flow->particles->dim * k + d];
      lo = fmin(lo, at);
      hi = fmax(hi, at);
    }
    const double size = fmax(hi - lo, flow->kernel->support);
    w->domain_lo[d] = lo - size;
    w->domain_hi[d] = hi + size;
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

/* Everything that depends on particles the caller gave or changed. */
static sph_status prepare(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  sph_context *context = flow->context;
  const sph_particles *particles = flow->particles;
  SPH_CHECK(context, w->c0 > 0, SPH_E_ARGUMENT,
            "wcsph: the sound speed is not set; call sph_wcsph_set_sound_speed");
  SPH_CHECK(context, particles->n > 0, SPH_E_ARGUMENT, "wcsph: particles \"%s\" are none",
            particles->name);
  SPH_TRY(reserve(flow));
  double origin[SPHI_MAX_DIM];
  for (int d = 0; d < particles->dim; d++)
    origin[d] = particles->field[SPHI_X].data[d][particles->slot[0]];
  sphi_frame_set(&flow->frame, particles->dim, origin, flow->kernel->support, w->periodic,
                 w->periodic_lo, w->periodic_hi);
  if (w->boundary) {
    SPH_TRY(sphi_boundary_place_walls(w->boundary, flow->stats.time));
    SPH_TRY(sphi_wcsph_check_walls(flow));
    SPH_TRY(sphi_boundary_prepare(w->boundary, flow->variant));
  }
  flow->stats.max_speed = largest_speed(flow); /* lists must reach as far as a step goes */
  if (flow->stats.max_acceleration == 0) { /* before the first step only the body force is known */
    const double *g = w->force.constant;
    flow->stats.max_acceleration = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  }
  w->prepared = false;
  SPH_TRY(build(flow));
  /* The places of the density gradient must be zero where no gradient is taken. */
  memset(flow->record, 0, (size_t)flow->record_capacity * flow->variant->real_size);
  w->prepared = true;
  apply_equation_of_state(flow, 0, particles->n);
  w->accelerated = false;
  if (!w->domain_given) default_domain(flow);
  return SPH_OK;
}

sph_status sphi_wcsph_refresh(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  if (flow->revision != flow->particles->revision) {
    SPH_TRY(prepare(flow));
  } else {
    const double reach = 0.5 * (flow->list_radius - flow->kernel->support);
    if (w->travelled + next_travel(flow) > reach) SPH_TRY(build(flow));
  }
  if (!w->packed) pack(flow, true, false);
  w->packed = true;
  return SPH_OK;
}
