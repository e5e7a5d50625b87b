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

static sph_status reserve(sph_integrator *flow, int32_t n) {
  wcsph *w = wcsph_of(flow);
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
      .rho0 = flow->cloud.rho0,
      .stiffness = linear ? w->c0 * w->c0 : flow->cloud.rho0 * w->c0 * w->c0 / w->gamma,
      .gamma = linear ? 0 : w->gamma,
      .force = flow->cloud.force,
      .time = t,
      .all = true};
  for (int d = 0; d < flow->particles->dim; d++) {
    a.x[d] = field(flow, SPHI_X)[d];
    a.v[d] = field(flow, SPHI_V)[d];
    a.acceleration[d] = field(flow, flow->cloud.acceleration)[d];
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

/* Divergence, and the density gradient if the diffusion needs it. */
static void run_gradient(sph_integrator *flow) {
  const wcsph *w = wcsph_of(flow);
  const sphi_gradient_arguments a = {
      .record = w->diffusion == SPH_DIFFUSION_DELTA ? flow->record : NULL,
      .divergence = w->array[WCSPH_DIVERGENCE],
      .lambda = w->array[WCSPH_LAMBDA],
      .lambda_min = LAMBDA_MIN};
  sphi_cloud_sweep(flow, SPHI_OPERATOR_gradient, &a);
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
      .rho0 = flow->cloud.rho0};
  for (int d = 0; d < dim; d++) {
    a.acceleration[d] = w->array[WCSPH_PUSH + d];
    a.viscous[d] = split ? w->array[WCSPH_VISCOUS + d] : NULL;
  }
  sphi_cloud_sweep(flow, SPHI_OPERATOR_momentum, &a);
  flow->stats.evaluations++;
}

static void run_rates(sph_integrator *flow) {
  const wcsph *w = wcsph_of(flow);
  sphi_rates_arguments a = {.divergence = w->array[WCSPH_DIVERGENCE],
                            .record = flow->record,
                            .m = field(flow, SPHI_M)[0]};
  for (int d = 0; d < flow->particles->dim; d++) a.acceleration[d] = w->array[WCSPH_PUSH + d];
  sphi_cloud_sweep(flow, SPHI_OPERATOR_rates, &a);
  flow->stats.evaluations++;
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
    a->lo[d] = flow->cloud.periodic[d] ? -HUGE_VAL : flow->cloud.domain_lo[d];
    a->hi[d] = flow->cloud.periodic[d] ? HUGE_VAL : flow->cloud.domain_hi[d];
  }
  const int32_t bad = run_update(flow, SPHI_UPDATE_move, a);
  sphi_extremes all = {0, 0};
  for (int32_t block = 0; block < block_count(flow); block++) {
    all.speed2 = fmax(all.speed2, w->block[block].speed2);
    all.acceleration2 = fmax(all.acceleration2, w->block[block].acceleration2);
  }
  flow->stats.max_speed = sqrt(all.speed2);
  flow->stats.max_acceleration = sqrt(all.acceleration2);
  return bad == INT32_MAX ? SPH_OK : sphi_cloud_report(flow, bad, dt);
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
  flow->cloud.packed = true;
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
  return bad == INT32_MAX ? SPH_OK : sphi_cloud_report(flow, bad, dt);
}

/* Symplectic Euler, written from the density on: density with the velocities now, velocities with the
 * new density, positions with the new velocities. */
static sph_status step_symplectic(sph_integrator *flow, double dt) {
  const wcsph *w = wcsph_of(flow);
  const double t = flow->stats.time;
  SPH_TRY(sphi_cloud_update_ghosts(flow, t, 0));
  run_gradient(flow);
  sphi_update_arguments a = update_of(flow, t);
  a.next = dt;
  a.divergence = w->array[WCSPH_DIVERGENCE];
  a.all = false;
  move(flow, &a);
  SPH_TRY(sphi_cloud_update_ghosts(flow, t, 0));
  run_momentum(flow, false);
  SPH_TRY(kick(flow, t, dt, 1, true));
  sphi_cloud_damp(flow, dt);
  SPH_TRY(sphi_cloud_stop_at_walls(flow, dt));
  return finish(flow, dt, dt, dt);
}

/* Kick, drift, kick: the density rate at the middle of the drift. */
static sph_status step_verlet(sph_integrator *flow, double dt) {
  wcsph *w = wcsph_of(flow);
  const double t = flow->stats.time;
  if (!w->accelerated) {
    SPH_TRY(sphi_cloud_update_ghosts(flow, t, 0));
    run_gradient(flow);
    run_momentum(flow, false);
  }
  SPH_TRY(kick(flow, t, dt, 0.5, !w->accelerated));
  SPH_TRY(sphi_cloud_stop_at_walls(flow, dt));
  sphi_update_arguments a = update_of(flow, t);
  a.drift = 0.5 * dt;
  move(flow, &a);
  SPH_TRY(sphi_cloud_update_ghosts(flow, t + 0.5 * dt, 0));
  run_gradient(flow);
  a.next = dt;
  a.divergence = w->array[WCSPH_DIVERGENCE];
  a.all = false;
  move(flow, &a);
  SPH_TRY(sphi_cloud_update_ghosts(flow, t + dt, 0));
  run_momentum(flow, false);
  SPH_TRY(kick(flow, t + dt, dt, 0.5, true));
  sphi_cloud_damp(flow, dt);
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
    SPH_TRY(sphi_cloud_update_ghosts(flow, t, 0));
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
    if (bad < INT32_MAX) return sphi_cloud_report(flow, bad, dt);
  }
  sphi_cloud_damp(flow, dt);
  SPH_TRY(sphi_cloud_stop_at_walls(flow, dt));
  return finish(flow, dt, 0, 0);
}

sph_status sphi_wcsph_step(sph_integrator *flow, double dt) {
  const double begin = sphi_seconds();
  const double others =
      flow->stats.seconds_pack + flow->stats.seconds_boundary + flow->stats.seconds_pairs;
  if (flow->cloud.boundary && sphi_boundary_is_driven(flow->cloud.boundary)) {
    /* Before the first step nothing has pushed yet. */
    if (flow->stats.steps == 0) SPH_TRY(sphi_cloud_update_ghosts(flow, flow->stats.time, 0));
    SPH_TRY(sphi_boundary_drive(flow->cloud.boundary, flow->stats.time, dt, 0));
  }
  flow->cloud.packed = false;
  flow->cloud.travel = sphi_cloud_travel_in(flow, dt);
  if (flow->stats.max_speed * dt > flow->particles->spacing) {
    sphi_update_arguments a = update_of(flow, 0);
    SPH_TRY(move_and_check(flow, &a, dt));
  }
  const sph_status status = flow->stepper == SPH_STEPPER_SYMPLECTIC ? step_symplectic(flow, dt)
                            : flow->stepper == SPH_STEPPER_VERLET   ? step_verlet(flow, dt)
                                                                    : step_rk4(flow, dt);
  sphi_cloud_has_moved(flow, dt);
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

/* Everything that depends on particles the caller gave or changed. */
static sph_status prepare(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  SPH_CHECK(flow->context, w->c0 > 0, SPH_E_ARGUMENT,
            "wcsph: the sound speed is not set; call sph_wcsph_set_sound_speed");
  SPH_TRY(reserve(flow, flow->particles->n));
  SPH_TRY(sphi_cloud_prepare(flow));
  w->accelerated = false;
  return SPH_OK;
}

sph_status sphi_wcsph_refresh(sph_integrator *flow) {
  if (flow->revision != flow->particles->revision) {
    SPH_TRY(prepare(flow));
  } else if (!sphi_cloud_reaches(flow)) {
    SPH_TRY(sphi_cloud_build(flow));
  }
  if (!flow->cloud.packed) {
    sphi_update_arguments a = update_of(flow, flow->stats.time);
    a.p = field(flow, SPHI_P)[0];
    a.volume = field(flow, SPHI_VOL)[0];
    move(flow, &a);
  }
  flow->cloud.packed = true;
  return SPH_OK;
}

sph_status sphi_wcsph_keep(sph_integrator *flow, sphi_keep *keep) {
  wcsph *w = wcsph_of(flow);
  int64_t stepper = flow->stepper, accelerated = w->accelerated;
  int64_t *const numbers[] = {&stepper, &accelerated};
  SPH_CHECK(flow->context, keep->act != SPHI_KEEP_CHECK || w->c0 > 0, SPH_E_ARGUMENT,
            "wcsph: the sound speed is not set; call sph_wcsph_set_sound_speed");
  SPH_TRY(sphi_cloud_keep(flow, keep));
  SPH_TRY(sphi_keep_wholes(keep, "wcsph/stepper", 2, numbers));
  if (keep->act == SPHI_KEEP_CHECK) SPH_TRY(reserve(flow, keep->n));
  if (keep->act == SPHI_KEEP_LOAD)
    w->accelerated = accelerated && stepper == (int64_t)flow->stepper;
  return SPH_OK;
}
