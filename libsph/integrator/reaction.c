/* Force on a wall by what its ghosts take from the momentum of the fluid. */
#include "integrator/integrator_impl.h"

/* A sum in storage order on one thread: the same bits for any number of them. */
static double sum_of(const sphi_variant *variant, const void *array, int32_t n) {
  double sum = 0;
  for (int32_t i = 0; i < n; i++)
    sum += variant->is_double ? ((const double *)array)[i] : (double)((const float *)array)[i];
  return sum;
}

sph_status sphi_cloud_read_reaction(sph_integrator *flow, int wall, double *force) {
  sph_context *context = flow->context;
  sphi_cloud *c = &flow->cloud;
  SPH_CHECK(context, force, SPH_E_ARGUMENT, "%s: force is NULL", flow->method->name);
  SPH_CHECK(context, c->boundary, SPH_E_ARGUMENT, "%s: the flow has no walls", flow->method->name);
  SPH_CHECK(context, wall >= 0 && wall < c->boundary->walls, SPH_E_ARGUMENT,
            "%s: wall must be 0 to %d, got %d", flow->method->name, c->boundary->walls - 1, wall);
  SPH_TRY(flow->method->refresh(flow));
  const sph_boundary *boundary = c->boundary;
  SPH_CHECK(context,
            sphi_reserve(context, &c->ghost_record, &c->ghost_record_capacity,
                         boundary->record_capacity, flow->variant->real_size),
            SPH_E_MEMORY, "%s: no memory for %d ghosts", flow->method->name, boundary->wet_count);
  sphi_wall_state state;
  SPH_TRY(sphi_wall_state_at(boundary->wall[wall], flow->stats.time, &state));
  sphi_boundary_read_records(boundary, wall, &state, &flow->frame, flow->variant, c->ghost_record);
  const int dim = flow->particles->dim;
  sphi_sweep sweep = {.frame = &flow->frame,
                      .kernel = flow->kernel,
                      .targets = &flow->clusters,
                      .target = flow->record,
                      .target_stride = SPHI_RECORD(dim)};
  sweep.source[0].list = &c->ghost_list;
  sweep.source[0].record = c->ghost_record;
  sphi_reaction_arguments a = {{NULL}};
  for (int d = 0; d < dim; d++) {
    SPH_CHECK(context,
              sphi_reserve(context, &c->reaction[d], &c->reaction_capacity[d], flow->particles->n,
                           flow->variant->real_size),
              SPH_E_MEMORY, "%s: no memory for %d particles", flow->method->name,
              flow->particles->n);
    a.force[d] = c->reaction[d];
  }
  sphi_sweep_run(context, flow->variant, SPHI_OPERATOR_reaction, &sweep, &a);
  for (int d = 0; d < dim; d++) force[d] = sum_of(flow->variant, a.force[d], flow->particles->n);
  return SPH_OK;
}
