/* Stepping, time-step control, and the cloud of particles that methods and measures share. */
#include "integrator/integrator_impl.h"

/* Share of the lattice limit that disordered particles bear with a margin, see
 * docs/theory/time_stepping.md. */
static const struct {
  sph_stepper stepper;
  const char *name;
  double share;
} steppers[] = {{SPH_STEPPER_SYMPLECTIC, "symplectic", 0.4},
                {SPH_STEPPER_VERLET, "verlet", 0.4},
                {SPH_STEPPER_RK4, "rk4", 0.65}};

enum { STEPPERS = sizeof steppers / sizeof steppers[0] };

double sphi_integrator_courant(const sph_integrator *flow) {
  if (flow->courant > 0) return flow->courant;
  if (flow->method->courant > 0) return flow->method->courant;
  double share = 0;
  for (int k = 0; k < STEPPERS; k++)
    if (steppers[k].stepper == flow->stepper) share = steppers[k].share;
  return share * flow->method->stable_courant(flow, flow->stepper);
}

void sphi_integrator_retain(sph_integrator *flow) { flow->references++; }

void sph_integrator_destroy(sph_integrator **integrator) {
  if (!integrator || !*integrator) return;
  sph_integrator *dead = *integrator;
  *integrator = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  if (dead->data) dead->method->destroy(dead);
  sphi_cloud_free(dead);
  sphi_columns_free(context, &dead->columns);
  sphi_clusters_free(context, &dead->clusters);
  sphi_list_free(context, &dead->list);
  sphi_free(context, dead->record);
  sph_particles_destroy(&dead->particles);
  sph_kernel_destroy(&dead->kernel);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sphi_integrator_create(sph_context *context, const sphi_method *method,
                                  sph_particles *particles, sph_kernel *kernel,
                                  sph_integrator **out) {
  sph_integrator *flow = SPHI_NEW(context, 1, sph_integrator);
  SPH_CHECK(context, flow, SPH_E_MEMORY, "%s: no memory", method->name);
  sphi_context_retain(context);
  flow->context = context;
  flow->references = 1;
  flow->method = method;
  flow->stepper = SPH_STEPPER_RK4;
  flow->end = HUGE_VAL;
  flow->revision = -1;
  flow->particles = particles;
  sphi_particles_retain(particles);
  flow->kernel = kernel;
  sphi_kernel_retain(kernel);
  flow->variant = sphi_variant_find(context->isa, context->precision);
  *out = flow;
  return SPH_OK;
}

sph_status sphi_integrator_check_method(const sph_integrator *flow, const sphi_method *method) {
  if (!flow) return SPH_E_ARGUMENT;
  SPH_CHECK(flow->context, flow->method == method, SPH_E_TYPE,
            "integrator: this setting is of \"%s\", the integrator is \"%s\"", method->name,
            flow->method->name);
  return SPH_OK;
}

sph_status sph_stepper_find(sph_context *context, const char *name, sph_stepper *stepper) {
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, name && stepper, SPH_E_ARGUMENT, "stepper: %s is NULL",
            name ? "stepper" : "name");
  const char *names[STEPPERS];
  for (int k = 0; k < STEPPERS; k++) {
    names[k] = steppers[k].name;
    if (strcmp(name, names[k])) continue;
    *stepper = steppers[k].stepper;
    return SPH_OK;
  }
  const char *near = sphi_nearest_name(name, STEPPERS, names);
  return SPHI_ERROR(context, SPH_E_NAME, "unknown stepper \"%s\"; did you mean \"%s\"?", name,
                    near ? near : names[0]);
}

/* Stable step in seconds; 0 while the method cannot tell it yet. */
static double stable_dt(const sph_integrator *flow, sph_stepper stepper) {
  return flow->method->stable_dt(flow, flow->method->stable_courant(flow, stepper));
}

sph_status sph_integrator_set_stepper(sph_integrator *integrator, sph_stepper stepper) {
  if (!integrator) return SPH_E_ARGUMENT;
  sph_context *context = integrator->context;
  SPH_CHECK(context, stepper >= SPH_STEPPER_SYMPLECTIC && stepper <= SPH_STEPPER_RK4,
            SPH_E_ARGUMENT, "integrator: stepper must be one of sph_stepper, got %d", (int)stepper);
  SPH_CHECK(context, integrator->method->courant == 0, SPH_E_TYPE,
            "integrator: \"%s\" has a stepper of its own", integrator->method->name);
  const double limit = stable_dt(integrator, stepper);
  SPH_CHECK(context, limit == 0 || integrator->fixed_dt <= limit, SPH_E_ARGUMENT,
            "integrator: time step %g s is beyond the stable %g s of this stepper",
            integrator->fixed_dt, limit);
  const double most = integrator->method->stable_courant(integrator, stepper);
  SPH_CHECK(context, integrator->courant <= most, SPH_E_ARGUMENT,
            "integrator: courant number %g is beyond the stable %g of this stepper",
            integrator->courant, most);
  integrator->stepper = stepper;
  integrator->revision = -1; /* steppers carry different things from step to step */
  return SPH_OK;
}

sph_status sph_integrator_set_dt(sph_integrator *integrator, double dt) {
  if (!integrator) return SPH_E_ARGUMENT;
  SPH_CHECK(integrator->context, isfinite(dt) && dt >= 0, SPH_E_ARGUMENT,
            "integrator: time step must be >= 0 s, got %g", dt);
  const double limit = stable_dt(integrator, integrator->stepper);
  SPH_CHECK(integrator->context, limit == 0 || dt <= limit, SPH_E_ARGUMENT,
            "integrator: time step %g s is unstable; the limit of this stepper is %g s", dt, limit);
  if (limit > 0 && dt > 0.7 * limit)
    sphi_log(integrator->context, SPH_LOG_WARNING,
             "integrator: time step %g s is above 0.7 of the lattice limit %g s", dt, limit);
  integrator->fixed_dt = dt;
  return SPH_OK;
}

sph_status sph_integrator_set_courant(sph_integrator *integrator, double courant) {
  if (!integrator) return SPH_E_ARGUMENT;
  const double limit = integrator->method->stable_courant(integrator, integrator->stepper);
  SPH_CHECK(integrator->context, isfinite(courant) && courant >= 0 && courant <= limit,
            SPH_E_ARGUMENT, "integrator: courant number must be 0 to %g, got %g", limit, courant);
  integrator->courant = courant;
  return SPH_OK;
}

double sph_integrator_stable_dt(const sph_integrator *integrator) {
  return integrator ? stable_dt(integrator, integrator->stepper) : 0;
}

double sph_integrator_time(const sph_integrator *integrator) {
  return integrator ? integrator->stats.time : 0;
}

int64_t sph_integrator_steps(const sph_integrator *integrator) {
  return integrator ? integrator->stats.steps : 0;
}

sph_particles *sph_integrator_particles(const sph_integrator *integrator) {
  return integrator ? integrator->particles : NULL;
}

sph_status sph_integrator_get_stats(const sph_integrator *integrator, sph_integrator_stats *stats) {
  if (!integrator) return SPH_E_ARGUMENT;
  SPH_CHECK(integrator->context, stats, SPH_E_ARGUMENT, "integrator: stats is NULL");
  *stats = integrator->stats;
  return SPH_OK;
}

sph_status sphi_integrator_observe(sph_integrator *flow, sphi_observe observe, void *observer) {
  SPH_CHECK(flow->context, flow->observers < SPHI_MAX_OBSERVERS, SPH_E_ARGUMENT,
            "integrator: at most %d probes sample every step", SPHI_MAX_OBSERVERS);
  flow->observer[flow->observers] = observer;
  flow->observe[flow->observers++] = observe;
  return SPH_OK;
}

void sphi_integrator_forget(sph_integrator *flow, void *observer) {
  int kept = 0;
  for (int k = 0; k < flow->observers; k++) {
    if (flow->observer[k] == observer) continue;
    flow->observer[kept] = flow->observer[k];
    flow->observe[kept++] = flow->observe[k];
  }
  flow->observers = kept;
}

static double seconds_of_step(const sph_integrator_stats *s) {
  return s->seconds_sort + s->seconds_search + s->seconds_pack + s->seconds_boundary +
         s->seconds_pairs + s->seconds_solver + s->seconds_update;
}

sph_status sph_integrator_step(sph_integrator *integrator) {
  if (!integrator) return SPH_E_ARGUMENT;
  sph_integrator *flow = integrator;
  SPH_TRY(flow->method->refresh(flow));
  sph_limiter limiter = SPH_LIMITER_FIXED;
  double dt = flow->fixed_dt > 0 ? flow->fixed_dt : flow->method->limit(flow, &limiter);
  SPH_CHECK(flow->context, dt > 0, SPH_E_DIVERGED, "integrator: time step %g s at time %g s", dt,
            flow->stats.time);
  const double left = flow->end - flow->stats.time;
  if (left < dt * (1 + 1e-9)) {
    dt = left;
    limiter = SPH_LIMITER_END;
  } else if (left < 2 * dt) {
    dt = left / 2; /* two even steps rather than one tiny last one */
    limiter = SPH_LIMITER_END;
  }
  SPH_TRY(flow->method->step(flow, dt));
  flow->stats.dt = dt;
  flow->stats.limiter = limiter;
  flow->stats.steps++;
  flow->stats.time = left < dt * (1 + 1e-9) ? flow->end : flow->stats.time + dt;
  const double begin = sphi_seconds(), elsewhere = seconds_of_step(&flow->stats);
  for (int k = 0; k < flow->observers; k++) SPH_TRY(flow->observe[k](flow->observer[k], flow));
  flow->stats.seconds_observers +=
      sphi_seconds() - begin - (seconds_of_step(&flow->stats) - elsewhere);
  return SPH_OK;
}

sph_status sph_integrator_advance(sph_integrator *integrator, double t) {
  if (!integrator) return SPH_E_ARGUMENT;
  SPH_CHECK(integrator->context, isfinite(t) && t >= integrator->stats.time, SPH_E_ARGUMENT,
            "integrator: cannot advance from %g s to %g s", integrator->stats.time, t);
  integrator->end = t;
  sph_status status = SPH_OK;
  while (status == SPH_OK && integrator->stats.time < t) status = sph_integrator_step(integrator);
  integrator->end = HUGE_VAL;
  return status;
}

sph_status sphi_integrator_build(sph_integrator *flow, double radius) {
  sph_context *context = flow->context;
  sph_particles *particles = flow->particles;
  const double begin = sphi_seconds();
  const int dim = particles->dim;
  const int32_t n = particles->n;
  double **x = particles->field[SPHI_X].data;
  for (int d = 0; d < dim; d++) {
    if (!flow->frame.periodic[d]) continue;
#pragma omp parallel for num_threads(context->threads) schedule(static) if (n > 16384)
    for (int32_t i = 0; i < n; i++) x[d][i] = sphi_frame_wrap(&flow->frame, d, x[d][i]);
  }
  SPH_CHECK(context,
            sphi_reserve(context, &flow->record, &flow->record_capacity,
                         ((int64_t)n + SPHI_PAD) * SPHI_RECORD(dim), flow->variant->real_size),
            SPH_E_MEMORY, "%s: no memory for %d records", flow->method->name, n);
  const double width = sphi_column_width(dim, flow->variant->lanes, particles->spacing);
  SPH_TRY(sphi_columns_build(context, &flow->columns, &flow->frame, width, n, x, particles->rank,
                             particles->name));
  sphi_particles_permute(particles, flow->columns.order);
  for (int32_t k = 0; k < n; k++) flow->columns.order[k] = k;
  /* Clusters are cut short where particles are sparse, not where a column is merely narrow. */
  SPH_TRY(sphi_clusters_build(context, &flow->clusters, &flow->columns, &flow->frame, x,
                              flow->variant->lanes, 2 * flow->kernel->support));
  const double sorted = sphi_seconds();
  flow->stats.seconds_sort += sorted - begin;
  SPH_TRY(
      sphi_list_build(context, &flow->list, &flow->frame, &flow->clusters, &flow->columns, radius));
  flow->list_radius = radius;
  flow->revision = particles->revision;
  flow->stats.builds++;
  flow->stats.list_entries = flow->list.total;
  flow->stats.seconds_search += sphi_seconds() - sorted;
  return SPH_OK;
}

sph_status sphi_integrator_gather(sph_integrator *flow, sphi_gather *gather,
                                  const sph_interpolator *interpolator, int64_t *build) {
  SPH_TRY(flow->method->refresh(flow));
  SPH_CHECK(flow->context, flow->revision >= 0, SPH_E_TYPE,
            "integrator: the method \"%s\" has no neighbours to interpolate from",
            flow->method->name);
  if (*build != flow->stats.builds) {
    SPH_TRY(sphi_gather_sort(flow->context, gather, &flow->frame, flow->variant,
                             flow->particles->spacing, flow->kernel->support));
    SPH_TRY(sphi_gather_list(flow->context, gather, &flow->frame, interpolator, &flow->columns,
                             flow->list_radius));
    *build = flow->stats.builds;
  }
  sphi_gather_evaluate(flow->context, gather, &flow->frame, interpolator, flow->variant,
                       flow->record);
  return SPH_OK;
}
