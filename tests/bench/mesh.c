/* Particles and a mesh: water and air in a flume whose left end moves to and fro, so that particles are located
 * anew in every step. */
#include "mesh.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "table.h"

static const double LENGTH = 15, HEIGHT = 0.6, DEPTH = 0.3; /* m */
enum { DIVISIONS = 3, WARM_STEPS = 20 };

typedef struct flow {
  memory held;
  sph_context *context;
  sph_mesh *mesh;
  sph_particles *particles;
  sph_integrator *flow;
  sph_solver *solver;
} flow;

static double level(const double *x, void *user) {
  (void)x, (void)user;
  return DEPTH;
}

/* A tenth of the depth, in two seconds there and back. */
static void to_and_fro(double t, double *displacement, double *velocity, double *acceleration,
                       void *user) {
  (void)user;
  const double omega = 3.14159265358979323846, half = 0.05 * DEPTH;
  displacement[0] = half * (1 - cos(omega * t));
  velocity[0] = half * omega * sin(omega * t);
  acceleration[0] = half * omega * omega * cos(omega * t);
}

static void open_flow(flow *f, const flow_case *of, sph_isa isa, int threads) {
  *f = (flow){.held = {0}};
  const sph_allocator allocator = memory_allocator(&f->held);
  const int columns = (int)lround(LENGTH / of->spacing), rows = (int)lround(HEIGHT / of->spacing);
  world_check(sph_context_create_with_allocator(&allocator, &f->context), NULL, "context");
  OK(f, sph_context_set_threads(f->context, threads));
  OK(f, sph_context_set_isa(f->context, isa));
  OK(f, sph_mesh_create_flume(f->context, 0, LENGTH, HEIGHT, columns, rows, NULL, NULL, &f->mesh));
  OK(f, sph_particles_create(f->context, 2, of->spacing / DIVISIONS / sqrt(2), &f->particles));
  OK(f, sph_flip_fill(f->mesh, f->particles, DIVISIONS, level, NULL, 1000, 1));
  OK(f, sph_flip_create(f->context, f->mesh, f->particles, &f->flow));
  OK(f, sph_flip_set_paddle(f->flow, to_and_fro, NULL, LENGTH));
  OK(f, sph_flip_get_solver(f->flow, &f->solver));
}

static void close_flow(flow *f) {
  sph_integrator_destroy(&f->flow);
  sph_particles_destroy(&f->particles);
  sph_mesh_destroy(&f->mesh);
  sph_context_destroy(&f->context);
}

enum { SORT, MEANS, ROWS, SETUP, ITERATIONS, CARRY, OTHER, PHASES };

typedef struct reading {
  double wall, seconds[OTHER];
  int64_t iterations;
} reading;

static reading read_clocks(const flow *f) {
  sph_integrator_stats s;
  sph_solver_stats solver;
  OK(f, sph_integrator_get_stats(f->flow, &s));
  OK(f, sph_solver_get_stats(f->solver, &solver));
  return (reading){.wall = clock_now(),
                   .seconds = {[SORT] = s.seconds_sort + s.seconds_search,
                               [MEANS] = s.seconds_pack,
                               [ROWS] = s.seconds_solver - solver.total_seconds_setup -
                                        solver.total_seconds_iterations,
                               [SETUP] = solver.total_seconds_setup,
                               [ITERATIONS] = solver.total_seconds_iterations,
                               [CARRY] = s.seconds_update},
                   .iterations = solver.total_iterations};
}

static void step(const flow *f, int steps) {
  for (int k = 0; k < steps; k++) OK(f, sph_integrator_step(f->flow));
}

static void measure(const flow_case *of, sph_isa isa, int threads, int repeats, record *r) {
  flow f;
  double phase[PHASES][REPEATS_MOST];
  const int steps = of->steps[FLIP];
  open_flow(&f, of, isa, threads);
  step(&f, WARM_STEPS);
  const reading first = read_clocks(&f);
  const int64_t calls = f.held.calls;
  reading before = first;
  for (int k = 0; k < repeats; k++) {
    step(&f, steps);
    const reading after = read_clocks(&f);
    const double scale = 1e9 / (steps * (double)sph_particles_count(f.particles));
    phase[OTHER][k] = scale * (after.wall - before.wall);
    for (int p = 0; p < OTHER; p++) {
      phase[p][k] = scale * (after.seconds[p] - before.seconds[p]);
      phase[OTHER][k] -= phase[p][k];
    }
    before = after;
  }
  snprintf(r->name, sizeof r->name, "%s", of->name);
  snprintf(r->stepper, sizeof r->stepper, "%s", schemes[FLIP].name);
  snprintf(r->isa, sizeof r->isa, "%s", sph_isa_name(isa));
  r->threads = threads;
  r->particles = (double)sph_particles_count(f.particles);
  r->steps = steps * repeats;
  r->evaluations_per_step = 1;
  r->iterations = (double)(before.iterations - first.iterations) / r->steps;
  r->allocations_per_step = (double)(f.held.calls - calls) / r->steps;
  r->bytes = (double)f.held.now / r->particles;
  r->bytes_peak = (double)f.held.peak / r->particles;
  r->search_ns = median(phase[SORT], repeats);
  r->pack_ns = median(phase[MEANS], repeats);
  r->rows_ns = median(phase[ROWS], repeats);
  r->setup_ns = median(phase[SETUP], repeats);
  r->iterations_ns = median(phase[ITERATIONS], repeats);
  r->update_ns = median(phase[CARRY], repeats);
  r->other_ns = median(phase[OTHER], repeats);
  r->step_ns = r->evaluation_ns = r->search_ns + r->pack_ns + r->rows_ns + r->setup_ns +
                                  r->iterations_ns + r->update_ns + r->other_ns;
  close_flow(&f);
}

void measure_mesh(const flow_case *of, const selection *what, records *all) {
  flow_case shape = *of;
  if (what->scheme >= 0 && what->scheme != FLIP) return;
  if (what->quick) shape.spacing *= 2;
  printf("\n%s: triangles of %g m, %d particles each, water and air\n", shape.name, shape.spacing,
         DIVISIONS * DIVISIONS);
  table_head(FLIP);
  for (sph_isa isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
    const int processors = sph_processor_count();
    const int counts[2] = {what->threads ? what->threads : 1, processors};
    if ((what->isa != SPH_ISA_AUTO && isa != what->isa) || !isa_is_available(isa)) continue;
    const record *alone = NULL;
    for (int k = 0; k < (what->threads || processors == 1 ? 1 : 2); k++) {
      if (all->count == RECORDS_MOST) return;
      record *r = &all->entry[all->count++];
      *r = (record){.plain_pairs_ns = 0};
      measure(&shape, isa, counts[k], what->repeats, r);
      if (alone) r->speed_up = alone->step_ns / r->step_ns;
      if (!alone) alone = r;
      table_row(r);
    }
  }
}
