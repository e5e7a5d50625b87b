/* Force on a wall by what its ghosts take from the momentum of the fluid. */
#include "wcsph/wcsph_impl.h"

/* A sum in storage order on one thread: the same bits for any number of them. */
static double sum_of(const sphi_variant *variant, const void *array, int32_t n) {
  double sum = 0;
  for (int32_t i = 0; i < n; i++)
    sum += variant->is_double ? ((const double *)array)[i] : (double)((const float *)array)[i];
  return sum;
}

sph_status sphi_wcsph_reaction(sph_integrator *flow, int wall, double *force) {
  wcsph *w = wcsph_of(flow);
  SPH_TRY(sphi_wcsph_refresh(flow));
  const sph_boundary *boundary = w->boundary;
  SPH_CHECK(flow->context,
            sphi_reserve(flow->context, &w->ghost_record, &w->ghost_record_capacity,
                         boundary->record_capacity, flow->variant->real_size),
            SPH_E_MEMORY, "wcsph: no memory for %d ghosts", boundary->wet_count);
  sphi_wall_state state;
  SPH_TRY(sphi_wall_state_at(boundary->wall[wall], flow->stats.time, &state));
  sphi_boundary_read_records(boundary, wall, &state, &flow->frame, flow->variant, w->ghost_record);
  const int dim = flow->particles->dim;
  sphi_sweep sweep = {.frame = &flow->frame,
                      .kernel = flow->kernel,
                      .targets = &flow->clusters,
                      .target = flow->record,
                      .target_stride = SPHI_RECORD(dim)};
  sweep.source[0].list = &w->ghost_list;
  sweep.source[0].record = w->ghost_record;
  sphi_reaction_arguments a = {{NULL}};
  for (int d = 0; d < dim; d++) a.force[d] = w->array[WCSPH_PUSH + d]; /* free between steps */
  sphi_sweep_run(flow->context, flow->variant, SPHI_OPERATOR_reaction, &sweep, &a);
  for (int d = 0; d < dim; d++) force[d] = sum_of(flow->variant, a.force[d], flow->particles->n);
  return SPH_OK;
}
