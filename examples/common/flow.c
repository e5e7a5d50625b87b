/* What the examples of flows share, see flow.h. */
#include "flow.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

double *example_flow_read(const example_flow *f, const char *field, int components) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water) * components;
  double *values = example_numbers(n);
  OK(sph_particles_read(f->water, field, values, n));
  return values;
}

static bool is_incompressible(const example_scheme *s) { return strcmp(s->method, "isph") == 0; }

static sph_isph_walls walls_of(const example_scheme *s) {
  static const char *const names[] = {[SPH_ISPH_WALLS_GHOSTS] = "ghosts",
                                      [SPH_ISPH_WALLS_DUMMIES] = "dummies",
                                      [SPH_ISPH_WALLS_DUMMIES_AS_PRINTED] = "dummies-as-printed"};
  if (*s->walls == '\0') return SPH_ISPH_WALLS_GHOSTS;
  if (!is_incompressible(s)) example_refuse("--walls", "is for --method isph");
  for (int k = SPH_ISPH_WALLS_GHOSTS; k < (int)(sizeof names / sizeof names[0]); k++)
    if (strcmp(s->walls, names[k]) == 0) return (sph_isph_walls)k;
  example_refuse("--walls", "\"%s\" is none of ghosts, dummies, dummies-as-printed", s->walls);
  return SPH_ISPH_WALLS_GHOSTS;
}

void example_flow_open(const example_scheme *s, int dim, double dx, example_flow *f) {
  sph_context *context = NULL;
  sph_kernel_type kernel;
  if (!is_incompressible(s) && strcmp(s->method, "wcsph") != 0)
    example_refuse("--method", "\"%s\" is neither wcsph nor isph", s->method);
  (void)walls_of(s); /* refuses before anything is made */
  OK(sph_context_create(&context));
  f->context = context;
  OK(sph_context_set_threads(context, example_threads(s->threads)));
  OK(sph_context_set_isa(context, example_isa(s->isa)));
  OK(sph_kernel_find(context, s->kernel, &kernel));
  OK(sph_kernel_create(context, kernel, dim, s->h_ratio * dx, &f->kernel));
  OK(sph_particles_create(context, dim, dx, &f->water));
  OK(sph_particles_set_name(f->water, "water"));
}

static sph_diffusion diffusion_of(const char *name) {
  static const char *const names[] = {[SPH_DIFFUSION_NONE] = "none",
                                      [SPH_DIFFUSION_MOLTENI] = "molteni",
                                      [SPH_DIFFUSION_DELTA] = "delta"};
  for (int k = 0; k < (int)(sizeof names / sizeof names[0]); k++)
    if (strcmp(name, names[k]) == 0) return (sph_diffusion)k;
  example_refuse("--diffusion", "\"%s\" is none of none, molteni, delta", name);
  return SPH_DIFFUSION_DELTA;
}

void example_flow_solve(const example_scheme *s, double c0, example_flow *f) {
  sph_context *context = f->context;
  const double dx = sph_particles_spacing(f->water);
  sph_interpolator_type interpolator;
  sph_stepper stepper;
  OK(sph_interpolator_find(context, s->interpolator, &interpolator));
  OK(sph_interpolator_create(context, interpolator, f->kernel, &f->interpolator));
  OK(sph_boundary_create(context, f->tank, dx, f->interpolator, &f->ghosts));
  for (int k = 0; k < EXAMPLE_WALLS; k++)
    if (f->more[k]) OK(sph_boundary_add_wall(f->ghosts, f->more[k]));
  if (is_incompressible(s)) {
    OK(sph_isph_create(context, f->kernel, f->water, f->ghosts, &f->integrator));
    OK(sph_isph_set_laminar_viscosity(f->integrator, s->nu));
    OK(sph_isph_set_walls(f->integrator, walls_of(s)));
    OK(sph_integrator_set_courant(f->integrator, s->courant));
    OK(sph_integrator_set_dt(f->integrator, s->dt));
    return;
  }
  OK(sph_wcsph_create(context, f->kernel, f->water, f->ghosts, &f->integrator));
  OK(sph_wcsph_set_sound_speed(f->integrator, c0));
  OK(sph_wcsph_set_artificial_viscosity(f->integrator, s->alpha));
  OK(sph_wcsph_set_laminar_viscosity(f->integrator, s->nu));
  OK(sph_wcsph_set_diffusion(f->integrator, diffusion_of(s->diffusion), s->delta));
  if (*s->stepper != '\0') {
    OK(sph_stepper_find(context, s->stepper, &stepper));
    OK(sph_integrator_set_stepper(f->integrator, stepper));
  }
  OK(sph_integrator_set_courant(f->integrator, s->courant));
  OK(sph_integrator_set_dt(f->integrator, s->dt));
}

void example_flow_start(const example_scheme *s, example_flow *f, const double *pressure) {
  sph_context *context = f->context;
  if (!is_incompressible(s))
    OK(sph_wcsph_start_from_pressure(f->integrator, sph_particles_count(f->water), pressure));
}

static const char checkpoint_file[] = "checkpoint.sph";

void example_flow_resume(const example_checkpoints *c, const char *folder, example_flow *f) {
  sph_context *context = f->context;
  if ((c->every > 0 || c->resume) && *folder == '\0')
    example_refuse(c->resume ? "--resume" : "--checkpoint", "wants a folder, --out");
  f->checkpoint_every = c->every;
  f->checkpoint_folder = folder;
  if (!c->resume) return;
  OK(sph_integrator_read_checkpoint(f->integrator, example_path(folder, checkpoint_file)));
  f->from = sph_integrator_time(f->integrator);
  f->steps_before = sph_integrator_steps(f->integrator);
}

void example_flow_checkpoint(const example_flow *f) {
  sph_context *context = f->context;
  sph_integrator_stats now;
  if (f->checkpoint_every == 0) return;
  OK(sph_integrator_get_stats(f->integrator, &now));
  const double every = f->checkpoint_every;
  if (floor(now.time / every) > floor((now.time - now.dt) / every))
    OK(sph_integrator_write_checkpoint(f->integrator,
                                       example_path(f->checkpoint_folder, checkpoint_file)));
}

const char *example_flow_path(const example_flow *f, const char *folder, const char *file) {
  char name[256];
  const char *dot = strrchr(file, '.');
  const int stem = dot != NULL ? (int)(dot - file) : (int)strlen(file);
  if (f->from == 0) return example_path(folder, file);
  snprintf(name, sizeof name, "%.*s_from_%.6g%s", stem, file, f->from, file + stem);
  return example_path(folder, name);
}

void example_flow_destroy(example_flow *f) {
  sph_output_destroy(&f->vtk);
  for (int k = 0; k < EXAMPLE_PROBES; k++) sph_probe_destroy(&f->probes[k]);
  sph_integrator_destroy(&f->integrator);
  sph_boundary_destroy(&f->ghosts);
  sph_interpolator_destroy(&f->interpolator);
  for (int k = 0; k < EXAMPLE_WALLS; k++) sph_wall_destroy(&f->more[k]);
  sph_wall_destroy(&f->tank);
  sph_particles_destroy(&f->water);
  sph_kernel_destroy(&f->kernel);
  sph_context_destroy(&f->context);
}

bool example_frame_due(double t, double end, int frames, int done) {
  const double part = t >= end ? 1 : t / end;
  return done < frames && part * (frames - 1) >= done;
}

int example_frames_before(const example_flow *f, double end, int frames) {
  int done = 0;
  while (f->from > 0 && example_frame_due(f->from, end, frames, done)) done++;
  return done;
}

void example_flow_write_series(const example_flow *f, const char *folder, int count,
                               const char *const *files) {
  sph_context *context = f->context;
  for (int k = 0; k < count; k++)
    OK(sph_probe_write_csv(f->probes[k], example_flow_path(f, folder, files[k])));
}

void example_summary_flow(example_summary *summary, const example_flow *f, double wall_seconds) {
  sph_context *context = f->context;
  sph_integrator_stats stats;
  sph_boundary_counts counts;
  OK(sph_integrator_get_stats(f->integrator, &stats));
  OK(sph_boundary_get_counts(f->ghosts, &counts));
  const int64_t particles = sph_particles_count(f->water);
  const double work = (double)particles * (double)(stats.steps - f->steps_before);
  example_summary_integer(summary, "particles", particles);
  example_summary_integer(summary, "steps", stats.steps);
  example_summary_number(summary, "time_end_s", stats.time);
  example_summary_number(summary, "wall_seconds", wall_seconds);
  example_summary_number(summary, "cpu_seconds", (double)clock() / CLOCKS_PER_SEC);
  example_summary_number(summary, "ns_per_particle_step", 1e9 * wall_seconds / work);
  example_summary_number(summary, "pairs_per_second", (double)stats.pairs / stats.seconds_pairs);
  example_summary_number(summary, "pair_seconds", stats.seconds_pairs);
  example_summary_number(summary, "ghost_seconds", stats.seconds_boundary);
  example_summary_number(summary, "list_seconds", stats.seconds_sort + stats.seconds_search);
  example_summary_number(summary, "update_seconds", stats.seconds_update + stats.seconds_pack);
  sph_solver *solver;
  sph_solver_stats solved = {0};
  if (sph_isph_get_solver(f->integrator, &solver) == SPH_OK)
    OK(sph_solver_get_stats(solver, &solved));
  example_summary_integer(summary, "solver_iterations", solved.total_iterations);
  example_summary_number(summary, "solver_seconds", stats.seconds_solver);
  example_summary_number(summary, "probe_seconds", stats.seconds_observers);
  example_summary_integer(summary, "threads", sph_context_get_threads(context));
  example_summary_text(summary, "isa", sph_isa_name(sph_context_get_isa(context)));
  example_summary_integer(summary, "neighbour_lists_built", stats.builds);
  example_summary_integer(summary, "wall_contacts", stats.contacts);
  example_summary_integer(summary, "ghosts", counts.ghosts);
  example_summary_integer(summary, "ghosts_active", counts.active);
  example_summary_integer(summary, "ghosts_thin", counts.thin);
  static const char *const by_type[] = {
      [SPH_INTERPOLATOR_IMPROVED_SHEPARD] = "ghosts_improved_shepard",
      [SPH_INTERPOLATOR_NORMALIZED] = "ghosts_normalized",
      [SPH_INTERPOLATOR_MLS_LINEAR] = "ghosts_mls_linear",
      [SPH_INTERPOLATOR_CLASSIC_SHEPARD] = "ghosts_classic_shepard",
      [SPH_INTERPOLATOR_TUNED_SHEPARD] = "ghosts_tuned_shepard",
      [SPH_INTERPOLATOR_SFDI] = "ghosts_sfdi",
      [SPH_INTERPOLATOR_SFDI_PRINTED] = "ghosts_sfdi_printed",
      [SPH_INTERPOLATOR_MLS_QUADRATIC] = "ghosts_mls_quadratic",
      [SPH_INTERPOLATOR_NEAREST] = "ghosts_nearest"};
  for (size_t k = 1; k < sizeof by_type / sizeof by_type[0]; k++)
    if (counts.by_type[k] > 0) example_summary_integer(summary, by_type[k], counts.by_type[k]);
  example_summary_integer(summary, "ghosts_fallback", counts.fallback);
}
