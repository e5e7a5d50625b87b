#include "table.h"

#include "world.h"

static void head_incompressible(void) {
  puts(
      "  stepper    isa      thr ns/step |search  pack ghosts pairs rows set-up iter. update "
      "probes "
      "other |iter.  ns delta solve/ step/ bytes speed alloc");
  puts(
      "                                  |     %     %      %     %    %      %     %      %      "
      "% "
      "    % |/step           delta delta          up /step");
}

static void row_incompressible(const record *r) {
  const double share = 100 / r->evaluation_ns;
  printf("  %-10s %-8s %3.0f %7.0f |%6.1f %5.1f %6.1f %5.1f %4.1f %6.1f %5.1f %6.1f %6.1f %5.1f |",
         r->stepper, r->isa, r->threads, r->step_ns, share * r->search_ns, share * r->pack_ns,
         share * r->boundary_ns, share * r->pairs_ns, share * r->rows_ns, share * r->setup_ns,
         share * r->iterations_ns, share * r->update_ns, share * r->observers_ns,
         share * r->other_ns);
  printf("%5.1f %9.1f %6.2f %5.2f %5.0f ", r->iterations, r->delta_ns, r->solver_to_delta,
         r->step_to_delta, r->bytes);
}

static void head_mesh(void) {
  puts(
      "  stepper    isa      thr ns/step |  sort means  rows set-up iter. carry other |iter. bytes "
      "speed alloc");
  puts(
      "                                  |     %     %     %      %     %     %     % |/step       "
      "  up /step");
}

static void row_mesh(const record *r) {
  const double share = 100 / r->step_ns;
  printf("  %-10s %-8s %3.0f %7.0f |%6.1f %5.1f %5.1f %6.1f %5.1f %5.1f %5.1f |%5.1f %5.0f ",
         r->stepper, r->isa, r->threads, r->step_ns, share * r->search_ns, share * r->pack_ns,
         share * r->rows_ns, share * r->setup_ns, share * r->iterations_ns, share * r->update_ns,
         share * r->other_ns, r->iterations, r->bytes);
}

static void row_compressible(const record *r) {
  const double share = 100 / r->evaluation_ns;
  printf("  %-10s %-8s %3.0f %7.0f %7.1f |%6.1f %5.1f %6.1f %5.1f %6.1f %6.1f %5.1f |", r->stepper,
         r->isa, r->threads, r->step_ns, r->evaluation_ns, share * r->search_ns, share * r->pack_ns,
         share * r->boundary_ns, share * r->pairs_ns, share * r->update_ns, share * r->observers_ns,
         share * r->other_ns);
  printf("%7.1f %6.2f %6.2f %6.2f %5.2f %4.1f %4.1f %5.0f ", r->pairs_ns, r->ratio_pairs,
         r->ratio_list, r->step_to_pairs, 1e-9 * r->pairs_per_second, 100 * r->peak_fraction,
         r->list_entries, r->bytes);
}

void table_head(int number) {
  if (number == ISPH) {
    head_incompressible();
    return;
  }
  if (number == FLIP) {
    head_mesh();
    return;
  }
  puts(
      "  stepper    isa      thr ns/step ns/eval |search  pack ghosts pairs update probes other "
      "|ns pair plain/  +list  eval/ Gpair peak list bytes speed alloc");
  puts(
      "                                          |     %     %      %     %      %      %     % "
      "|   sums  pairs         pairs    /s    %                up /step");
}

void table_row(const record *r) {
  if (r->delta_ns > 0)
    row_incompressible(r);
  else if (r->iterations_ns > 0)
    row_mesh(r);
  else
    row_compressible(r);
  if (r->speed_up > 0)
    printf("%5.2f", r->speed_up);
  else
    printf("%5s", "");
  printf(" %5.2f\n", r->allocations_per_step);
  fflush(stdout);
}
