#include "measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flops.h"
#include "mesh.h"
#include "plain.h"
#include "table.h"

enum { WARM_STEPS = 2, YARDSTICK_STEPS = 10 };

/* What the plain loop takes, in ns a particle: one list, and each pass. */
enum { LIST, CONVECTIVE, GRADIENT, RATES, PASSES };

typedef double samples[REPEATS_MOST];

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

double median(const double *values, int count) {
  samples sorted;
  if (count == 0) return 0;
  memcpy(sorted, values, (size_t)count * sizeof *values);
  qsort(sorted, (size_t)count, sizeof *sorted, ascending);
  return count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
}

/* Mean over the evaluations of a step: a Runge-Kutta step has all sums in the first alone. */
static double mean_evaluation(double all, double convective, double evaluations) {
  return (all + (evaluations - 1) * convective) / evaluations;
}

/* ------------------------------------------------------------------------------- plain loop */

/* The library's rates of a state, and the ghosts that it took for them: those of a step so short that
 * nothing changes on the way. */
typedef struct answer {
  double *acceleration, *density_rate;
  ghosts ghosts;
} answer;

static const double SHORT_STEP = 1e-9; /* s */

static void answer_open(answer *of, const flow_case *shape, const state *s, bool diffusive) {
  world w;
  const int64_t vector = (int64_t)s->n * s->dim;
  world_open(&w, shape, SPH_ISA_AUTO, 1, SYMPLECTIC, s);
  if (!diffusive) {
    OK(&w, sph_wcsph_set_diffusion(w.flow, SPH_DIFFUSION_NONE, 0));
    OK(&w, sph_wcsph_set_artificial_viscosity(w.flow, 0));
  }
  OK(&w, sph_integrator_set_dt(w.flow, SHORT_STEP));
  world_step(&w, 1);
  of->acceleration = numbers_new(vector);
  of->density_rate = numbers_new(s->n);
  OK(&w, sph_particles_read(w.particles, "acceleration", of->acceleration, vector));
  OK(&w, sph_particles_read(w.particles, SPH_DENSITY, of->density_rate, s->n));
  for (int32_t i = 0; i < s->n; i++)
    of->density_rate[i] = (of->density_rate[i] - s->rho[i]) / SHORT_STEP;
  world_read_ghosts(&w, &of->ghosts);
  world_close(&w);
}

static void answer_close(answer *of) {
  free(of->acceleration);
  free(of->density_rate);
  ghosts_free(&of->ghosts);
}

static void copy(double *to, const double *from, int64_t n) {
  memcpy(to, from, (size_t)n * sizeof *to);
}

static void plain_fill(plain_flow *flow, const flow_case *of, const state *s, const ghosts *g) {
  if (!plain_allocate(flow, s->dim, s->n, g->n)) {
    fputs("no memory for the plain loop\n", stderr);
    exit(1);
  }
  const bool gaussian = of->kernel == SPH_KERNEL_GAUSSIAN;
  flow->kernel = gaussian ? PLAIN_GAUSSIAN : PLAIN_WENDLAND_C2;
  flow->h = of->h_factor * of->spacing;
  flow->support = (gaussian ? 3 : 2) * flow->h;
  flow->c0 = world_sound_speed(of);
  /* The defaults of the library. */
  flow->rho0 = 1000;
  flow->delta = 0.1;
  flow->alpha = 0.02;
  flow->gravity = 9.81;
  copy(flow->fluid.x, s->x, (int64_t)s->n * s->dim);
  copy(flow->fluid.v, s->v, (int64_t)s->n * s->dim);
  copy(flow->m, s->m, s->n);
  copy(flow->rho, s->rho, s->n);
  copy(flow->ghost.x, g->x, (int64_t)g->n * s->dim);
  copy(flow->ghost.v, g->v, (int64_t)g->n * s->dim);
  copy(flow->ghost.p, g->p, g->n);
  copy(flow->ghost.volume, g->volume, g->n);
  plain_state(flow);
}

static void plain_list_or_exit(plain_flow *flow) {
  if (plain_list(flow)) return;
  fputs("no memory for the plain loop's list\n", stderr);
  exit(1);
}

/* Times one list and each pass once, ns a particle, as measurement number k. */
static void plain_time(plain_flow *flow, samples ns[PASSES], int k) {
  const double scale = 1e9 / flow->fluid.n;
  double mark[PASSES + 1];
  mark[LIST] = clock_now();
  plain_list_or_exit(flow);
  mark[CONVECTIVE] = clock_now();
  plain_convective(flow);
  mark[GRADIENT] = clock_now();
  plain_gradient(flow);
  mark[RATES] = clock_now();
  plain_rates(flow);
  mark[PASSES] = clock_now();
  for (int p = 0; p < PASSES; p++) ns[p][k] = scale * (mark[p + 1] - mark[p]);
}

/* Largest difference of two arrays in terms of the largest number of the second. */
static double difference(const double *a, const double *b, int64_t n) {
  double off = 0, most = 0;
  for (int64_t k = 0; k < n; k++) {
    off = fmax(off, fabs(a[k] - b[k]));
    most = fmax(most, fabs(b[k]));
  }
  return off / most;
}

/* The library does not leave drops and threads in tension: their densities are set to the reference at
 * the end of a step. */
static void relieve_drops(plain_flow *flow) {
  const double isolated = 0.2;
  for (int32_t i = 0; i < flow->fluid.n; i++)
    if (flow->lambda[i] < isolated)
      flow->density_rate[i] = fmax(flow->density_rate[i], (flow->rho0 - flow->rho[i]) / SHORT_STEP);
}

static double disagreement(plain_flow *plain, const answer *of) {
  relieve_drops(plain);
  const int32_t n = plain->fluid.n;
  return fmax(difference(of->acceleration, plain->acceleration, (int64_t)n * plain->dim),
              difference(of->density_rate, plain->density_rate, n));
}

/* Makes the plain loop of a state and its lists. Two speeds can only be compared if both compute the
 * same: returns by how much the rates of any particle differ, with all terms and with the convective
 * ones alone. */
static double plain_open(plain_flow *plain, const flow_case *of, const state *s) {
  answer full, convective;
  answer_open(&full, of, s, true);
  answer_open(&convective, of, s, false);
  plain_fill(plain, of, s, &full.ghosts);
  plain_list_or_exit(plain);
  plain_gradient(plain);
  plain_rates(plain);
  double off = disagreement(plain, &full);
  plain_convective(plain);
  off = fmax(off, disagreement(plain, &convective));
  answer_close(&full);
  answer_close(&convective);
  return off;
}

/* ----------------------------------------------------------------------------------- library */

enum { SEARCH, PACK, BOUNDARY, PAIRS, ROWS, SETUP, ITERATIONS, UPDATE, OBSERVERS, OTHER, PHASES };

/* Readings of the clocks, at the end of some steps. */
typedef struct reading {
  double wall, seconds[OTHER];
  int64_t evaluations, builds, list_entries, iterations;
} reading;

static reading read_clocks(const world *w) {
  sph_integrator_stats s;
  sph_solver_stats solver = {.iterations = 0};
  OK(w, sph_integrator_get_stats(w->flow, &s));
  if (w->solver) OK(w, sph_solver_get_stats(w->solver, &solver));
  return (reading){.wall = clock_now(),
                   .seconds = {[SEARCH] = s.seconds_sort + s.seconds_search,
                               [PACK] = s.seconds_pack,
                               [BOUNDARY] = s.seconds_boundary,
                               [PAIRS] = s.seconds_pairs,
                               [ROWS] = s.seconds_solver - solver.total_seconds_setup -
                                        solver.total_seconds_iterations,
                               [SETUP] = solver.total_seconds_setup,
                               [ITERATIONS] = solver.total_seconds_iterations,
                               [UPDATE] = s.seconds_update,
                               [OBSERVERS] = s.seconds_observers},
                   .evaluations = s.evaluations,
                   .builds = s.builds,
                   .list_entries = s.list_entries,
                   .iterations = solver.total_iterations};
}

/* Nanoseconds a particle of each repeat: phases an evaluation, and builds of those that had some. */
typedef struct times {
  samples phase[PHASES], build, loop[PASSES];
  int repeats, builds;
} times;

static void add_repeat(times *t, const reading *before, const reading *after, double n) {
  const double scale = 1e9 / (n * (double)(after->evaluations - before->evaluations));
  const int k = t->repeats++;
  t->phase[OTHER][k] = scale * (after->wall - before->wall);
  for (int p = 0; p < OTHER; p++) {
    t->phase[p][k] = scale * (after->seconds[p] - before->seconds[p]);
    t->phase[OTHER][k] -= t->phase[p][k];
  }
  const int64_t builds = after->builds - before->builds;
  if (builds > 0)
    t->build[t->builds++] =
        1e9 / n * (after->seconds[SEARCH] - before->seconds[SEARCH]) / (double)builds;
}

/* Each phase is the median over the repeats. Lists are not built in every repeat: theirs is the median
 * cost of a build times the number of builds. */
static void fill_phases(record *r, const times *t) {
  r->build_ns = median(t->build, t->builds);
  r->search_ns = r->build_ns * r->builds_per_step / r->evaluations_per_step;
  r->pack_ns = median(t->phase[PACK], t->repeats);
  r->boundary_ns = median(t->phase[BOUNDARY], t->repeats);
  r->pairs_ns = median(t->phase[PAIRS], t->repeats);
  r->rows_ns = median(t->phase[ROWS], t->repeats);
  r->setup_ns = median(t->phase[SETUP], t->repeats);
  r->iterations_ns = median(t->phase[ITERATIONS], t->repeats);
  r->update_ns = median(t->phase[UPDATE], t->repeats);
  r->observers_ns = median(t->phase[OBSERVERS], t->repeats);
  r->other_ns = median(t->phase[OTHER], t->repeats);
  r->evaluation_ns = r->search_ns + r->pack_ns + r->boundary_ns + r->pairs_ns + r->rows_ns +
                     r->setup_ns + r->iterations_ns + r->update_ns + r->observers_ns + r->other_ns;
  r->step_ns = r->evaluation_ns * r->evaluations_per_step;
}

static void fill_plain(record *r, const samples loop[PASSES], int repeats) {
  const double full = median(loop[GRADIENT], repeats) + median(loop[RATES], repeats);
  r->plain_list_ns = median(loop[LIST], repeats);
  r->plain_pairs_ns =
      mean_evaluation(full, median(loop[CONVECTIVE], repeats), r->evaluations_per_step);
}

/* Some steps as one repeat; `before` becomes the reading after them. */
static void step_and_add(world *w, int steps, reading *before, times *t) {
  before->wall = clock_now();
  world_step(w, steps);
  const reading after = read_clocks(w);
  add_repeat(t, before, &after, sph_particles_count(w->particles));
  *before = after;
}

/* What steps and builds come to between two readings. */
static void fill_counts(record *r, const reading *first, const reading *last, int steps) {
  r->steps = steps;
  r->evaluations_per_step = (double)(last->evaluations - first->evaluations) / steps;
  r->builds_per_step = (double)(last->builds - first->builds) / steps;
  r->iterations = (double)(last->iterations - first->iterations) / steps;
}

/* An evaluation of weakly compressible SPH, probes left out, as the measure of incompressible SPH. */
static void fill_delta(record *r, const reading *first, const reading *last, const times *t) {
  record delta = {.steps = 0};
  fill_counts(&delta, first, last, YARDSTICK_STEPS * t->repeats);
  fill_phases(&delta, t);
  r->delta_ns = delta.evaluation_ns - delta.observers_ns;
  r->solver_to_delta = (r->rows_ns + r->setup_ns + r->iterations_ns) / r->delta_ns;
  r->step_to_delta = (r->step_ns - r->observers_ns) / r->delta_ns;
}

/* Repeats of some steps. After each run some of `delta` (NULL: nothing), and the plain loop where r has no
 * times of it yet, so that all meet the machine in the same mood. */
static void measure_phases(world *w, world *delta, int steps, int repeats, plain_flow *plain,
                           record *r) {
  const bool with_plain = r->plain_pairs_ns == 0;
  times t = {.repeats = 0}, delta_t = {.repeats = 0};
  reading delta_first = {.wall = 0}, delta_before = {.wall = 0};
  world_step(w, WARM_STEPS);
  if (delta) {
    world_step(delta, WARM_STEPS);
    delta_before = delta_first = read_clocks(delta);
  }
  const reading first = read_clocks(w);
  const int64_t calls = w->held.calls;
  reading before = first;
  for (int k = 0; k < repeats; k++) {
    step_and_add(w, steps, &before, &t);
    if (delta) step_and_add(delta, YARDSTICK_STEPS, &delta_before, &delta_t);
    if (with_plain) plain_time(plain, t.loop, k);
  }
  fill_counts(r, &first, &before, steps * repeats);
  r->allocations_per_step = (double)(w->held.calls - calls) / r->steps;
  r->list_entries = (double)before.list_entries / sph_particles_count(w->particles);
  fill_phases(r, &t);
  if (delta) fill_delta(r, &delta_first, &delta_before, &delta_t);
  if (with_plain) fill_plain(r, (const samples *)t.loop, repeats);
}

/* What follows from times and neighbours. */
static void fill_rates(record *r, const flow_case *of, double peak) {
  const flops pair = flops_of_pair(of->dim, of->kernel),
              ghost = flops_of_ghost(of->dim, of->kernel);
  const double full = r->neighbours * (pair.gradient + pair.rates) +
                      r->ghost_neighbours * (ghost.gradient + ghost.rates);
  const double convective =
      r->neighbours * pair.convective + r->ghost_neighbours * ghost.convective;
  const double lists = r->plain_list_ns * r->builds_per_step / r->evaluations_per_step;
  r->ratio_pairs = r->plain_pairs_ns / r->pairs_ns;
  r->ratio_list = (r->plain_pairs_ns + lists) / (r->pairs_ns + r->search_ns);
  r->step_to_pairs = r->evaluation_ns / r->pairs_ns;
  r->pairs_per_second = 1e9 * (r->neighbours + r->ghost_neighbours) / r->pairs_ns;
  r->flops = mean_evaluation(full, convective, r->evaluations_per_step);
  r->peak_gflops = peak;
  r->peak_fraction = r->flops / r->pairs_ns / peak;
}

static double neighbours(const plain_flow *plain) {
  return 2 * (double)plain->pairs.used / plain->fluid.n;
}

static double ghost_neighbours(const plain_flow *plain) {
  return (double)plain->ghosts.used / plain->fluid.n;
}

static void choose_preconditioner(const world *w, int chosen, record *r) {
  const sph_preconditioner p = (sph_preconditioner)chosen;
  OK(w, sph_solver_set_preconditioner(w->solver, p));
  snprintf(r->stepper, sizeof r->stepper, "isph-%.9s", sph_preconditioner_name(p));
}

static void measure_flow(const flow_case *of, const state *s, sph_isa isa, int threads, int chosen,
                         plain_flow *plain, const selection *what, record *r) {
  world w, delta;
  const bool incompressible = schemes[chosen].incompressible;
  snprintf(r->stepper, sizeof r->stepper, "%s", schemes[chosen].name);
  world_open(&w, of, isa, threads, chosen, s);
  if (incompressible) world_open(&delta, of, isa, threads, SYMPLECTIC, s);
  if (incompressible && what->preconditioner) choose_preconditioner(&w, what->preconditioner, r);
  snprintf(r->name, sizeof r->name, "%s", of->name);
  snprintf(r->isa, sizeof r->isa, "%s", sph_isa_name(isa));
  r->threads = threads;
  r->particles = s->n;
  r->ghosts = (double)sph_boundary_count(w.boundary);
  r->neighbours = neighbours(plain);
  r->ghost_neighbours = ghost_neighbours(plain);
  measure_phases(&w, incompressible ? &delta : NULL, of->steps[chosen], what->repeats, plain, r);
  r->bytes = (double)w.held.now / s->n;
  r->bytes_peak = (double)w.held.peak / s->n;
  world_close(&w);
  if (incompressible)
    world_close(&delta);
  else
    fill_rates(r, of, flops_peak(isa, threads));
}

bool isa_is_available(sph_isa isa) {
  sph_context *context = NULL;
  world_check(sph_context_create(&context), NULL, "context");
  const bool available = sph_context_set_isa(context, isa) == SPH_OK;
  sph_context_destroy(&context);
  return available;
}

/* One thread and all, or as many as were asked for. */
static void measure_threads(const flow_case *of, const state *s, sph_isa isa, int chosen,
                            plain_flow *plain, const selection *what, records *all) {
  const int processors = sph_processor_count();
  const int counts[2] = {what->threads ? what->threads : 1, processors};
  const record *first = NULL;
  for (int k = 0; k < (what->threads || processors == 1 ? 1 : 2); k++) {
    if (all->count == RECORDS_MOST) return;
    record *r = &all->entry[all->count++];
    *r = (record){.plain_pairs_ns = 0};
    if (first) r->plain_list_ns = first->plain_list_ns, r->plain_pairs_ns = first->plain_pairs_ns;
    measure_flow(of, s, isa, counts[k], chosen, plain, what, r);
    if (first) r->speed_up = first->step_ns / r->step_ns;
    if (!first) first = r;
    table_row(r);
  }
}

static void measure_all(const flow_case *of, const state *s, plain_flow *plain,
                        const selection *what, records *all) {
  for (int chosen = 0; chosen < SCHEMES; chosen++) {
    if (!of->steps[chosen] || (what->scheme >= 0 && chosen != what->scheme)) continue;
    table_head(chosen);
    for (sph_isa isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
      if (what->isa != SPH_ISA_AUTO && isa != what->isa) continue;
      if (isa_is_available(isa)) measure_threads(of, s, isa, chosen, plain, what, all);
    }
  }
}

/* A state some way from the start; returns the number of ghosts. */
static int64_t make_state(const flow_case *of, state *s) {
  world w;
  world_open(&w, of, SPH_ISA_AUTO, sph_processor_count(), RK4, NULL);
  world_step(&w, of->warm_up);
  world_read(&w, s);
  const int64_t count = sph_boundary_count(w.boundary);
  world_close(&w);
  return count;
}

static void print_plain(plain_flow *plain, int repeats) {
  samples ns[PASSES];
  double loop[PASSES];
  for (int k = 0; k < repeats; k++) plain_time(plain, ns, k);
  for (int p = 0; p < PASSES; p++) loop[p] = median(ns[p], repeats);
  printf(
      "  plain loop, 1 thread, ns a particle: list %.0f, gradient %.0f, rates %.0f, both %.0f, "
      "convective alone %.0f\n",
      loop[LIST], loop[GRADIENT], loop[RATES], loop[GRADIENT] + loop[RATES], loop[CONVECTIVE]);
}

void measure_case(const flow_case *of, const selection *what, records *all) {
  flow_case shape = *of;
  if (!of->basin) {
    measure_mesh(of, what, all);
    return;
  }
  if (what->scheme >= 0 && !of->steps[what->scheme]) return;
  if (what->quick) {
    shape.spacing *= 2;
    if (shape.warm_up > 10) shape.warm_up = 10;
  }
  state s;
  plain_flow plain;
  const int64_t ghost_count = make_state(&shape, &s);
  const double off = plain_open(&plain, &shape, &s);
  printf(
      "\n%s: %d particles, %lld ghosts, %s h = %g dx, a particle has %.1f neighbours and %.1f "
      "ghosts\n",
      shape.name, s.n, (long long)ghost_count, sph_kernel_name(shape.kernel), shape.h_factor,
      neighbours(&plain), ghost_neighbours(&plain));
  print_plain(&plain, what->repeats);
  printf("  largest difference of its rates from the library's: %.1e\n", off);
  if (!(off < 1e-3)) {
    fprintf(stderr, "%s: the two do not compute the same sums\n", shape.name);
    exit(1);
  }
  measure_all(&shape, &s, &plain, what, all);
  plain_free(&plain);
  state_free(&s);
}
