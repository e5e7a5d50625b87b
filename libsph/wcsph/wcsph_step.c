/* Evaluation of the rates and the time steppers of weakly compressible SPH. */
#include "wcsph/wcsph_impl.h"

/* Smallest eigenvalue of the moment matrix: below LAMBDA_MIN a gradient is not trusted, below
 * LAMBDA_ISOLATED a particle is a drop or a thread (Marrone et al. 2010). */
#define LAMBDA_MIN 0.1
#define LAMBDA_ISOLATED 0.2

typedef const double *restrict array;

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
    const bool third =
        k == WCSPH_PUSH + 2 || k == WCSPH_VISCOUS + 2 || k == WCSPH_FIRST + 2 || k == WCSPH_SUM + 2;
    if (third && dim == 2) continue;
    ok = sphi_reserve(flow->context, &w->array[k], &w->array_capacity[k], n,
                      flow->variant->real_size);
  }
  ok = ok && (!w->boundary || sphi_reserve(flow->context, (void **)&w->clear, &w->clear_capacity, n,
                                           sizeof *w->clear));
  SPH_CHECK(flow->context, ok, SPH_E_MEMORY, "wcsph: no memory for %d particles", n);
  return SPH_OK;
}

/* What every update needs of the flow. */
static sphi_update_arguments update_of(sph_integrator *flow, double t) {
  wcsph *w = wcsph_of(flow);
  const bool linear = w->equation == SPH_EOS_LINEAR;
  sphi_update_arguments a = {
      .frame = &flow->frame,
      .record = flow->record,
      .rho = field(flow, SPHI_RHO)[0],
      .m = field(flow, SPHI_M)[0],
      .rho0 = w->rho0,
      .stiffness = linear ? w->c0 * w->c0 : w->rho0 * w->c0 * w->c0 / w->gamma,
      .gamma = linear ? 0 : w->gamma,
      .force = w->force,
      .time = t,
      .all = true};
  for (int d = 0; d < flow->particles->dim; d++) {
    a.x[d] = field(flow, SPHI_X)[d];
    a.v[d] = field(flow, SPHI_V)[d];
    a.acceleration[d] = field(flow, w->acceleration)[d];
  }
  return a;
}

static int32_t block_count(const sph_integrator *flow) {
  return (flow->particles->n + UPDATE_BLOCK - 1) / UPDATE_BLOCK;
}

/* Runs an update over all particles; returns the first bad one by storage order, INT32_MAX if none. */
static int32_t run_update(sph_integrator *flow, int number, const sphi_update_arguments *a) {
  const sphi_update function = flow->variant->updates[number];
  const int32_t n = flow->particles->n, blocks = block_count(flow);
  int32_t bad = INT32_MAX;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) \
    reduction(min                                                             \
              : bad) if (blocks > 1)
  for (int32_t block = 0; block < blocks; block++) {
    const int32_t begin = block * UPDATE_BLOCK;
    const int32_t found = function(a, begin, n - begin < UPDATE_BLOCK ? n : begin + UPDATE_BLOCK);
    if (found < bad) bad = found;
  }
  return bad;
}

/* Moves particles on, and makes their records. */
static void move(sph_integrator *flow, const sphi_update_arguments *a) {
  const double begin = sphi_seconds();
  run_update(flow, SPHI_UPDATE_move, a);
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
  flow->stats.pairs += sphi_sweep_pairs(&sweep);
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

/* Acceleration by pressure and viscosity (the viscous part apart if `split`), density diffusion. */
static void run_momentum(sph_integrator *flow, bool split) {
  wcsph *w = wcsph_of(flow);
  const int dim = flow->particles->dim;
  const double h = flow->kernel->h;
  sphi_momentum_arguments a = {
      .diffusion = w->diffusion == SPH_DIFFUSION_NONE ? NULL : w->array[WCSPH_DIFFUSION],
      .record = flow->record,
      .m = field(flow, SPHI_M)[0],
      .lambda = w->diffusion == SPH_DIFFUSION_DELTA ? w->array[WCSPH_LAMBDA] : NULL,
      .lambda_min = LAMBDA_MIN,
      .viscosity = w->alpha * h * w->c0 + 2 * (dim + 2) * w->nu,
      .delta = w->delta * h * w->c0,
      .rho0 = w->rho0};
  for (int d = 0; d < dim; d++) {
    a.acceleration[d] = w->array[WCSPH_PUSH + d];
    a.viscous[d] = split ? w->array[WCSPH_VISCOUS + d] : NULL;
  }
  run(flow, SPHI_OPERATOR_momentum, &a);
  flow->stats.evaluations++;
}

static void run_rates(sph_integrator *flow) {
  const wcsph *w = wcsph_of(flow);
  sphi_rates_arguments a = {.divergence = w->array[WCSPH_DIVERGENCE],
                            .record = flow->record,
                            .m = field(flow, SPHI_M)[0]};
  for (int d = 0; d < flow->particles->dim; d++) a.acceleration[d] = w->array[WCSPH_PUSH + d];
  run(flow, SPHI_OPERATOR_rates, &a);
  flow->stats.evaluations++;
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

/* Does a move, and finds the largest speed and acceleration after it; stops at the first bad particle by
 * storage order. Pressures and volumes go into the fields, so that what a caller reads belongs together. */
static sph_status move_and_check(sph_integrator *flow, sphi_update_arguments *a, double dt) {
  wcsph *w = wcsph_of(flow);
  a->p = field(flow, SPHI_P)[0];
  a->volume = field(flow, SPHI_VOL)[0];
  a->extremes = w->block;
  a->most2 = pow(flow->particles->spacing / dt, 2);
  for (int d = 0; d < flow->particles->dim; d++) {
    a->lo[d] = w->periodic[d] ? -HUGE_VAL : w->domain_lo[d];
    a->hi[d] = w->periodic[d] ? HUGE_VAL : w->domain_hi[d];
  }
  const int32_t bad = run_update(flow, SPHI_UPDATE_move, a);
  sphi_extremes all = {0, 0};
  for (int32_t block = 0; block < block_count(flow); block++) {
    all.speed2 = fmax(all.speed2, w->block[block].speed2);
    all.acceleration2 = fmax(all.acceleration2, w->block[block].acceleration2);
  }
  flow->stats.max_speed = sqrt(all.speed2);
  flow->stats.max_acceleration = sqrt(all.acceleration2);
  return bad == INT32_MAX ? SPH_OK : report_bad(flow, bad, dt);
}

/* The end of a step: positions on by `drift`, densities by their diffusion over `diffuse`. Drops and
 * threads cannot be in tension: nothing holds them together, and a density that stayed low from the
 * moment they came off would tear at whatever they meet next. */
static sph_status finish(sph_integrator *flow, double dt, double drift, double diffuse) {
  wcsph *w = wcsph_of(flow);
  sphi_update_arguments a = update_of(flow, 0);
  a.drift = drift;
  a.next = diffuse;
  if (diffuse > 0 && w->diffusion != SPH_DIFFUSION_NONE) a.diffusion = w->array[WCSPH_DIFFUSION];
  a.lambda = w->array[WCSPH_LAMBDA];
  a.lambda_isolated = LAMBDA_ISOLATED;
  const sph_status status = move_and_check(flow, &a, dt);
  w->packed = true;
  return status;
}

/* Velocities on by the accelerations now, made of the pair sums if these are `fresh`. */
static sph_status kick(sph_integrator *flow, double t, double dt, double part, bool fresh) {
  wcsph *w = wcsph_of(flow);
  sphi_update_arguments a = update_of(flow, t);
  a.next = part * dt;
  for (int d = 0; d < flow->particles->dim && fresh; d++) a.push[d] = w->array[WCSPH_PUSH + d];
  if (!fresh) a.force.function = NULL;
  const int32_t bad = run_update(flow, SPHI_UPDATE_kick, &a);
  return bad == INT32_MAX ? SPH_OK : report_bad(flow, bad, dt);
}

/* Rate at which damping zones take velocity from a particle. */
static double damping_rate(const sph_integrator *flow, int32_t i) {
  const wcsph *w = wcsph_of(flow);
  double rate = 0;
  for (int k = 0; k < w->zones; k++) {
    const damping_zone *zone = &w->zone[k];
    const double x = sphi_frame_wrap(&flow->frame, zone->axis, field(flow, SPHI_X)[zone->axis][i]);
    const double way = fmin(fmax((x - zone->from) / (zone->to - zone->from), 0), 1);
    rate += zone->rate * way * way;
  }
  return rate;
}

/* Takes from velocities what damping zones do in a step. An exponential never turns them, however long the
 * step; accelerations stay, since pressures do not know of velocities. */
static void damp(sph_integrator *flow, double dt) {
  double **v = field(flow, SPHI_V);
  const int32_t n = flow->particles->n;
  if (wcsph_of(flow)->zones == 0) return;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) if (n > UPDATE_BLOCK)
  for (int32_t i = 0; i < n; i++) {
    const double rate = damping_rate(flow, i);
    if (rate == 0) continue;
    const double factor = exp(-dt * rate);
    for (int d = 0; d < flow->particles->dim; d++) v[d][i] *= factor;
  }
}

/* Symplectic Euler, written from the density on: density with the velocities now, velocities with the
 * new density, positions with the new velocities. */
static sph_status step_symplectic(sph_integrator *flow, double dt) {
  const wcsph *w = wcsph_of(flow);
  const double t = flow->stats.time;
  SPH_TRY(update_ghosts(flow, t));
  run_gradient(flow);
  sphi_update_arguments a = update_of(flow, t);
  a.next = dt;
  a.divergence = w->array[WCSPH_DIVERGENCE];
  a.all = false;
  move(flow, &a);
  SPH_TRY(update_ghosts(flow, t));
  run_momentum(flow, false);
  SPH_TRY(kick(flow, t, dt, 1, true));
  damp(flow, dt);
  SPH_TRY(sphi_wcsph_stop_at_walls(flow, dt));
  return finish(flow, dt, dt, dt);
}

/* Kick, drift, kick: the density rate at the middle of the drift. */
static sph_status step_verlet(sph_integrator *flow, double dt) {
  wcsph *w = wcsph_of(flow);
  const double t = flow->stats.time;
  if (!w->accelerated) {
    SPH_TRY(update_ghosts(flow, t));
    run_gradient(flow);
    run_momentum(flow, false);
  }
  SPH_TRY(kick(flow, t, dt, 0.5, !w->accelerated));
  SPH_TRY(sphi_wcsph_stop_at_walls(flow, dt));
  sphi_update_arguments a = update_of(flow, t);
  a.drift = 0.5 * dt;
  move(flow, &a);
  SPH_TRY(update_ghosts(flow, t + 0.5 * dt));
  run_gradient(flow);
  a.next = dt;
  a.divergence = w->array[WCSPH_DIVERGENCE];
  a.all = false;
  move(flow, &a);
  SPH_TRY(update_ghosts(flow, t + dt));
  run_momentum(flow, false);
  SPH_TRY(kick(flow, t + dt, dt, 0.5, true));
  damp(flow, dt);
  w->accelerated = true;
  return finish(flow, dt, 0, dt);
}

/* Runge-Kutta 4 with the diffusive terms of the first stage kept through the step. A stage's state is in
 * the records alone; the fields keep the old state until the last one. With a_k the accelerations of the
 * stages and a' = 2 a_1 + 2 a_2, weights 1 2 2 1 over 6 make
 *
 *   v_new = v + dt (a_0 + a' + a_3) / 6,    x_new = x + dt v + dt^2 (a_0 + a_1 + a_2) / 6. */
static sph_status step_rk4(sph_integrator *flow, double dt) {
  static const struct {
    double place;                         /* of the stage in the step */
    double next;                          /* of the state after it */
    double past;                          /* the sums' part of it */
    double drift, drift_sum, drift_first; /* [dt], [dt^2] */
    int update;
  } stage[4] = {
      {0, 0.5, 0, 0.5, 0, 0, SPHI_UPDATE_initial_stage},
      {0.5, 0.5, 0, 0.5, 0, 0.25, SPHI_UPDATE_middle_stage},
      {0.5, 1, 0, 1, 0.25, -0.25, SPHI_UPDATE_middle_stage}, /* (sum - first) / 2 = a_1 */
      {1, 1 / 6.0, 1 / 6.0, 1, 1 / 12.0, 1 / 12.0, SPHI_UPDATE_final_stage},
  };
  wcsph *w = wcsph_of(flow);
  for (int k = 0; k < 4; k++) {
    const double t = flow->stats.time + stage[k].place * dt;
    SPH_TRY(update_ghosts(flow, t));
    if (k == 0) {
      run_gradient(flow);
      run_momentum(flow, true);
    } else {
      run_rates(flow);
    }
    sphi_update_arguments a = update_of(flow, t);
    a.next = stage[k].next * dt;
    a.past = stage[k].past * dt;
    a.drift = stage[k].drift * dt;
    a.drift_sum = stage[k].drift_sum * dt * dt;
    a.drift_first = stage[k].drift_first * dt * dt;
    a.divergence = w->array[WCSPH_DIVERGENCE];
    if (w->diffusion != SPH_DIFFUSION_NONE) a.diffusion = w->array[WCSPH_DIFFUSION];
    a.rho_sum = w->array[WCSPH_SUM_RHO];
    for (int d = 0; d < flow->particles->dim; d++) {
      a.push[d] = w->array[WCSPH_PUSH + d];
      a.viscous[d] = w->array[WCSPH_VISCOUS + d];
      a.first[d] = w->array[WCSPH_FIRST + d];
      a.sum[d] = w->array[WCSPH_SUM + d];
    }
    const int32_t bad = run_update(flow, stage[k].update, &a);
    if (bad < INT32_MAX) return report_bad(flow, bad, dt);
  }
  damp(flow, dt);
  SPH_TRY(sphi_wcsph_stop_at_walls(flow, dt));
  return finish(flow, dt, 0, 0);
}

double sphi_wcsph_wall_speed(const wcsph *w) {
  return w->boundary ? sphi_boundary_speed(w->boundary) : 0;
}

/* How far a particle or wall may come in a time step. */
static double travel_in(const sph_integrator *flow, double dt) {
  return dt * fmax(flow->stats.max_speed + dt * flow->stats.max_acceleration,
                   sphi_wcsph_wall_speed(wcsph_of(flow)));
}

sph_status sphi_wcsph_step(sph_integrator *flow, double dt) {
  wcsph *w = wcsph_of(flow);
  const double begin = sphi_seconds();
  const double others =
      flow->stats.seconds_pack + flow->stats.seconds_boundary + flow->stats.seconds_pairs;
  if (w->boundary && sphi_boundary_is_driven(w->boundary)) {
    /* Before the first step nothing has pushed yet. */
    if (flow->stats.steps == 0) SPH_TRY(update_ghosts(flow, flow->stats.time));
    SPH_TRY(sphi_boundary_drive(w->boundary, flow->stats.time, dt));
  }
  w->packed = false;
  w->travel = travel_in(flow, dt);
  if (flow->stats.max_speed * dt > flow->particles->spacing) {
    sphi_update_arguments a = update_of(flow, 0);
    SPH_TRY(move_and_check(flow, &a, dt));
  }
  const sph_status status = flow->stepper == SPH_STEPPER_SYMPLECTIC ? step_symplectic(flow, dt)
                            : flow->stepper == SPH_STEPPER_VERLET   ? step_verlet(flow, dt)
                                                                    : step_rk4(flow, dt);
  const double wall_speed = sphi_wcsph_wall_speed(w);
  const double speed = flow->stats.max_speed + 0.5 * dt * flow->stats.max_acceleration;
  w->travelled += dt * fmax(speed, wall_speed);
  w->odometer += dt * (speed + wall_speed);
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

/* Share of the support by which the lists reach farther. Longer lists cost the first sums of a step and
 * the ghosts, shorter ones have to be made more often: 0.9 sqrt(travel/support) is the best or within 3 %
 * of it in tanks of 2D and 3D, measured from 0.5 to 1.2. One step must fit in any case. */
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
  /* Positions jumped by a period where there is one. */
  if (!w->prepared || w->periodic[0] || w->periodic[1] || w->periodic[2])
    sphi_wcsph_forget_walls(flow);
  if (!w->boundary) return SPH_OK;
  const double begin = sphi_seconds();
  const bool moves = sphi_boundary_moves(w->boundary);
  if (moves || !w->prepared) {
    SPH_TRY(sphi_boundary_move(w->boundary, flow->stats.time));
    SPH_TRY(sphi_boundary_sort(w->boundary, &flow->frame, flow->variant));
  }
  /* Two particles come nearer by twice what one travels; walls at rest do not come to meet it. */
  const double margin = (moves ? 1 : 0.5) * (radius - flow->kernel->support);
  /* What one wall mirrors for another comes by up to twice the other's way. */
  const double mirrored = (moves && w->boundary->walls > 1 ? 1.5 : 1) * margin;
  SPH_TRY(sphi_list_build(flow->context, &w->ghost_list, &flow->frame, &flow->clusters,
                          &w->boundary->columns, flow->kernel->support + margin));
  SPH_TRY(sphi_boundary_list(w->boundary, &flow->frame, flow->variant, &flow->columns,
                             w->boundary->interpolator->kernel->support + mirrored,
                             &w->ghost_list));
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
    SPH_TRY(sphi_boundary_prepare(w->boundary));
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
  if (!w->packed) {
    sphi_update_arguments a = update_of(flow, flow->stats.time);
    a.p = field(flow, SPHI_P)[0];
    a.volume = field(flow, SPHI_VOL)[0];
    move(flow, &a);
  }
  w->packed = true;
  return SPH_OK;
}
