/* Checkpoints of flows: what every method keeps, to a file and back. */
#include "core/keep.h"

#include "integrator/integrator_impl.h"

static sph_status keep_stats(sph_integrator *flow, sphi_keep *keep) {
  sph_integrator_stats *s = &flow->stats;
  const int64_t builds = s->builds;
  int64_t limiter = s->limiter;
  int64_t *const counts[] = {&s->steps,        &limiter,  &s->evaluations, &s->builds,
                             &s->list_entries, &s->pairs, &s->contacts};
  double *const numbers[] = {&s->time,           &s->dt,
                             &s->max_speed,      &s->max_acceleration,
                             &s->seconds_sort,   &s->seconds_search,
                             &s->seconds_pack,   &s->seconds_boundary,
                             &s->seconds_pairs,  &s->seconds_solver,
                             &s->seconds_update, &s->seconds_observers};
  SPH_TRY(sphi_keep_wholes(keep, "run/counts", sizeof counts / sizeof counts[0], counts));
  SPH_TRY(sphi_keep_reals(keep, "run/numbers", sizeof numbers / sizeof numbers[0], numbers));
  if (keep->act != SPHI_KEEP_LOAD) return SPH_OK;
  s->limiter = (sph_limiter)limiter;
  /* Measures know by this number whether their lists are of the lists now: it never goes back. */
  if (s->builds < builds) s->builds = builds;
  return SPH_OK;
}

sph_status sphi_cloud_keep(sph_integrator *flow, sphi_keep *keep) {
  sphi_cloud *c = &flow->cloud;
  sph_context *context = flow->context;
  const double walls = c->boundary != NULL, support = flow->kernel->support;
  double origin[SPHI_MAX_DIM], lo[SPHI_MAX_DIM], hi[SPHI_MAX_DIM], periods[3 * SPHI_MAX_DIM] = {0};
  double *at[3 * SPHI_MAX_DIM];
  for (int d = 0; d < SPHI_MAX_DIM; d++) {
    origin[d] = flow->frame.origin[d];
    lo[d] = c->domain_lo[d];
    hi[d] = c->domain_hi[d];
    at[d] = &origin[d];
    at[SPHI_MAX_DIM + d] = &lo[d];
    at[2 * SPHI_MAX_DIM + d] = &hi[d];
    if (!c->periodic[d]) continue;
    periods[3 * d] = 1;
    periods[3 * d + 1] = c->periodic_lo[d];
    periods[3 * d + 2] = c->periodic_hi[d];
  }
  SPH_TRY(sphi_keep_common(keep, "cloud/support", 1, &support));
  SPH_TRY(sphi_keep_common(keep, "cloud/periods", 3 * SPHI_MAX_DIM, periods));
  SPH_TRY(sphi_keep_common(keep, "cloud/boundaries", 1, &walls));
  SPH_TRY(sphi_keep_reals(keep, "cloud/frame", 3 * SPHI_MAX_DIM, at));
  if (keep->act == SPHI_KEEP_CHECK)
    SPH_CHECK(context,
              !c->boundary || sphi_reserve(context, (void **)&c->clear, &c->clear_capacity, keep->n,
                                           sizeof *c->clear),
              SPH_E_MEMORY, "%s: no memory for %d particles", flow->method->name, keep->n);
  if (c->boundary) SPH_TRY(sphi_boundary_keep(c->boundary, keep));
  if (keep->act != SPHI_KEEP_LOAD) return SPH_OK;
  sphi_frame_set(&flow->frame, flow->particles->dim, origin, support, c->periodic, c->periodic_lo,
                 c->periodic_hi);
  for (int d = 0; d < SPHI_MAX_DIM && !c->domain_given; d++) {
    c->domain_lo[d] = lo[d];
    c->domain_hi[d] = hi[d];
  }
  c->prepared = true;
  c->packed = false;
  flow->revision = flow->particles->revision;
  return SPH_OK;
}

static sph_status keep_all(sph_integrator *flow, sphi_keep *keep) {
  char name[SPHI_KEEP_NAME] = "method/";
  double whole = 1; /* the name tells the rest */
  strcat(name, flow->method->name);
  SPH_TRY(sphi_keep_common(keep, name, 1, &whole));
  SPH_TRY(sphi_particles_keep(flow->particles, keep));
  SPH_TRY(keep_stats(flow, keep));
  return flow->method->keep(flow, keep);
}

static sph_status check_arguments(const sph_integrator *flow, const char *path) {
  if (!flow) return SPH_E_ARGUMENT;
  SPH_CHECK(flow->context, path && *path, SPH_E_ARGUMENT, "checkpoint: path is %s",
            path ? "empty" : "NULL");
  return SPH_OK;
}

sph_status sph_integrator_write_checkpoint(sph_integrator *integrator, const char *path) {
  sph_integrator *flow = integrator;
  sphi_keep keep;
  SPH_TRY(check_arguments(flow, path));
  SPH_TRY(flow->method->refresh(flow));
  SPH_TRY(sphi_keep_create(flow->context, path, &keep));
  sph_status status = keep_all(flow, &keep);
  if (status == SPH_OK) status = sphi_keep_finish(&keep);
  sphi_keep_close(&keep);
  if (status == SPH_OK) flow->cloud.stale = true; /* as in the run that will go on from it */
  return status;
}

sph_status sph_integrator_read_checkpoint(sph_integrator *integrator, const char *path) {
  sph_integrator *flow = integrator;
  sphi_keep keep;
  SPH_TRY(check_arguments(flow, path));
  SPH_TRY(sphi_keep_open(flow->context, path, &keep));
  sph_status status = keep_all(flow, &keep);
  if (status == SPH_OK) status = sphi_keep_all_asked(&keep);
  if (status == SPH_OK) {
    keep.act = SPHI_KEEP_LOAD;
    status = keep_all(flow, &keep);
    flow->cloud.stale = true;
  }
  sphi_keep_close(&keep);
  return status;
}
