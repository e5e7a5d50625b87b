/* How long a step of weakly compressible SPH takes, phase by phase, against a plain loop over the same
 * particles in the same run. See README.md in this folder, and docs/performance.md. */
#include "plain.h"
#include "records.h"
#include "world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { REPEATS_MOST = 9, WARM_STEPS = 2 };

typedef struct options {
  bool quick;
  int repeats;
  const char *cases, *json, *compare, *from;
} options;

/* What the plain loop takes, in ns a particle: one list, and each pass. */
enum { LIST, CONVECTIVE, GRADIENT, RATES, PASSES };

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(const double *values, int count) {
  double sorted[REPEATS_MOST];
  memcpy(sorted, values, (size_t)count * sizeof *values);
  qsort(sorted, (size_t)count, sizeof *sorted, ascending);
  return count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
}

/* ------------------------------------------------------------------------------- plain loop */

static void plain_fill(plain_flow *flow, const flow_case *of, const state *s) {
  if (!plain_allocate(flow, s->dim, s->n)) {
    fputs("no memory for the plain loop\n", stderr);
    exit(1);
  }
  const size_t count = (size_t)s->n, vector = count * (size_t)s->dim;
  const bool gaussian = of->kernel == SPH_KERNEL_GAUSSIAN;
  flow->kernel = gaussian ? PLAIN_GAUSSIAN : PLAIN_WENDLAND_C2;
  flow->h = of->h_factor * of->spacing;
  flow->support = (gaussian ? 3 : 2) * flow->h;
  flow->c0 = world_sound_speed();
  /* The defaults of the library. */
  flow->rho0 = 1000;
  flow->delta = 0.1;
  flow->alpha = 0.02;
  flow->gravity = 9.81;
  memcpy(flow->x, s->x, vector * sizeof(double));
  memcpy(flow->v, s->v, vector * sizeof(double));
  memcpy(flow->m, s->m, count * sizeof(double));
  memcpy(flow->rho, s->rho, count * sizeof(double));
  plain_state(flow);
}

static void plain_list_or_exit(plain_flow *flow) {
  if (plain_list(flow)) return;
  fputs("no memory for the plain loop's list\n", stderr);
  exit(1);
}

/* Times one list and each pass once, ns a particle, as measurement number k. */
static void plain_time(plain_flow *flow, double ns[PASSES][REPEATS_MOST], int k) {
  const double scale = 1e9 / flow->n;
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

/* Largest difference of the two codes' accelerations and density rates away from walls, in terms of the
 * largest of them: two speeds can only be compared if both compute the same. The library's rates come
 * from a step so short that nothing changes on the way. */
static double disagreement(const flow_case *of, const state *s, const plain_flow *plain) {
  const double dt = 1e-9;
  world w;
  world_open(&w, of, SPH_ISA_AUTO, 1, SPH_STEPPER_SYMPLECTIC, s);
  OK(&w, sph_integrator_set_dt(w.flow, dt));
  world_step(&w, 1);
  double *a = numbers_new((int64_t)s->n * s->dim), *rho = numbers_new(s->n);
  OK(&w, sph_particles_read(w.particles, "acceleration", a, (int64_t)s->n * s->dim));
  OK(&w, sph_particles_read(w.particles, SPH_DENSITY, rho, s->n));
  double off[2] = {0, 0}, most[2] = {0, 0};
  for (int32_t i = 0; i < s->n; i++) {
    if (!world_is_free(of, s->x + i * s->dim)) continue;
    for (int d = 0; d < s->dim; d++) {
      const double other = plain->acceleration[i * s->dim + d];
      off[0] = fmax(off[0], fabs(a[i * s->dim + d] - other));
      most[0] = fmax(most[0], fabs(other));
    }
    off[1] = fmax(off[1], fabs((rho[i] - s->rho[i]) / dt - plain->density_rate[i]));
    most[1] = fmax(most[1], fabs(plain->density_rate[i]));
  }
  free(a);
  free(rho);
  world_close(&w);
  return fmax(off[0] / most[0], off[1] / most[1]);
}

/* ----------------------------------------------------------------------------------- library */

enum { SEARCH, PACK, BOUNDARY, PAIRS, UPDATE, OTHER, PHASES };

static void phases_of(const sph_integrator_stats *s, double *seconds) {
  seconds[SEARCH] = s->seconds_search;
  seconds[PACK] = s->seconds_pack;
  seconds[BOUNDARY] = s->seconds_boundary;
  seconds[PAIRS] = s->seconds_pairs;
  seconds[UPDATE] = s->seconds_update;
}

/* Repeats of some steps; each phase is the median over the repeats. Lists are not built in every
 * repeat: theirs is the median cost of a build times the number of builds. With one thread the plain
 * loop runs after each repeat, so that both meet the machine in the same mood. */
static void measure_phases(world *w, int steps, int repeats, plain_flow *plain, record *r) {
  double ns[PHASES][REPEATS_MOST], build[REPEATS_MOST], loop[PASSES][REPEATS_MOST];
  const double n = sph_particles_count(w->particles);
  sph_integrator_stats first, before, after;
  int builds = 0;
  world_step(w, WARM_STEPS);
  OK(w, sph_integrator_get_stats(w->flow, &first));
  before = first;
  const int64_t calls = w->held.calls;
  for (int k = 0; k < repeats; k++) {
    double old[PHASES], now[PHASES], sum = 0;
    const double begin = clock_now();
    world_step(w, steps);
    const double wall = clock_now() - begin;
    OK(w, sph_integrator_get_stats(w->flow, &after));
    phases_of(&before, old);
    phases_of(&after, now);
    const double scale = 1e9 / (n * (double)(after.evaluations - before.evaluations));
    for (int p = 0; p < OTHER; p++) {
      sum += now[p] - old[p];
      ns[p][k] = scale * (now[p] - old[p]);
    }
    ns[OTHER][k] = scale * (wall - sum);
    const int64_t built = after.builds - before.builds;
    if (built > 0) build[builds++] = 1e9 / n * (now[SEARCH] - old[SEARCH]) / (double)built;
    before = after;
    if (r->threads == 1) plain_time(plain, loop, k);
  }
  const double evaluations = (double)(after.evaluations - first.evaluations);
  r->allocations_per_step = (double)(w->held.calls - calls) / (steps * repeats);
  r->steps = steps * repeats;
  r->evaluations_per_step = evaluations / r->steps;
  r->builds_per_step = (double)(after.builds - first.builds) / r->steps;
  r->build_ns = builds > 0 ? median(build, builds) : 0;
  r->search_ns = r->build_ns * r->builds_per_step / r->evaluations_per_step;
  r->pack_ns = median(ns[PACK], repeats);
  r->boundary_ns = median(ns[BOUNDARY], repeats);
  r->pairs_ns = median(ns[PAIRS], repeats);
  r->update_ns = median(ns[UPDATE], repeats);
  r->other_ns = median(ns[OTHER], repeats);
  r->evaluation_ns =
      r->search_ns + r->pack_ns + r->boundary_ns + r->pairs_ns + r->update_ns + r->other_ns;
  r->step_ns = r->evaluation_ns * r->evaluations_per_step;
  r->list_entries = (double)after.list_entries / n;
  if (r->threads > 1) return;
  /* The same sums: a Runge-Kutta step has the full ones once in four evaluations. */
  const double full = median(loop[GRADIENT], repeats) + median(loop[RATES], repeats);
  const bool once_in_four = r->evaluations_per_step > 3;
  r->plain_list_ns = median(loop[LIST], repeats);
  r->plain_pairs_ns = once_in_four ? (full + 3 * median(loop[CONVECTIVE], repeats)) / 4 : full;
}

static void measure_flow(const flow_case *of, const state *s, sph_isa isa, int threads,
                         sph_stepper stepper, plain_flow *plain, int repeats, record *r) {
  const bool runge_kutta = stepper == SPH_STEPPER_RK4;
  world w;
  world_open(&w, of, isa, threads, stepper, s);
  snprintf(r->name, sizeof r->name, "%s", of->name);
  snprintf(r->stepper, sizeof r->stepper, "%s", runge_kutta ? "rk4" : "symplectic");
  snprintf(r->isa, sizeof r->isa, "%s", sph_isa_name(isa));
  r->threads = threads;
  r->particles = s->n;
  r->ghosts = (double)sph_boundary_count(w.boundary);
  measure_phases(&w, of->steps[runge_kutta ? 0 : 1], repeats, plain, r);
  r->bytes = (double)w.held.now / s->n;
  r->bytes_peak = (double)w.held.peak / s->n;
  world_close(&w);

  r->neighbours = 2 * (double)plain->start[plain->n] / plain->n;
  r->ratio_pairs = r->plain_pairs_ns / r->pairs_ns;
  const double lists = r->plain_list_ns * r->builds_per_step / r->evaluations_per_step;
  r->ratio_list = (r->plain_pairs_ns + lists) / (r->pairs_ns + r->search_ns);
  r->step_to_pairs = r->evaluation_ns / r->pairs_ns;
  r->pairs_per_second = 1e9 * r->neighbours / r->pairs_ns;
}

/* ------------------------------------------------------------------------------------- table */

static void print_head(void) {
  puts(
      "  stepper    isa      thr ns/step ns/eval |search   pack ghosts  pairs update  other "
      "|ns pair plain/  +list  eval/  list bytes speed alloc");
  puts(
      "                                          |     %      %      %      %      %      % "
      "|   sums  pairs         pairs                up /step");
}

static void print_record(const record *r) {
  const double share = 100 / r->evaluation_ns;
  printf("  %-10s %-8s %3.0f %7.0f %7.1f |%6.1f %6.1f %6.1f %6.1f %6.1f %6.1f |", r->stepper,
         r->isa, r->threads, r->step_ns, r->evaluation_ns, share * r->search_ns, share * r->pack_ns,
         share * r->boundary_ns, share * r->pairs_ns, share * r->update_ns, share * r->other_ns);
  printf("%7.1f %6.2f %6.2f %6.2f %5.1f %5.0f ", r->pairs_ns, r->ratio_pairs, r->ratio_list,
         r->step_to_pairs, r->list_entries, r->bytes);
  if (r->speed_up > 0)
    printf("%5.2f", r->speed_up);
  else
    printf("%5s", "");
  printf(" %5.2f\n", r->allocations_per_step);
  fflush(stdout);
}

static bool isa_is_available(sph_isa isa) {
  sph_context *context = NULL;
  world_check(sph_context_create(&context), NULL, "context");
  const bool available = sph_context_set_isa(context, isa) == SPH_OK;
  sph_context_destroy(&context);
  return available;
}

/* Every instruction set, scheme and number of threads for one state. */
static void measure_all(const flow_case *of, const state *s, plain_flow *plain, int repeats,
                        records *all) {
  static const sph_stepper steppers[] = {SPH_STEPPER_RK4, SPH_STEPPER_SYMPLECTIC};
  const int processors = sph_processor_count();
  for (int k = 0; k < 2; k++) {
    for (sph_isa isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
      if (!isa_is_available(isa)) continue;
      record alone = {0};
      for (int threads = 1; threads <= processors; threads += processors > 1 ? processors - 1 : 1) {
        if (all->count == RECORDS_MOST) return;
        record *r = &all->entry[all->count++];
        *r = (record){.plain_list_ns = alone.plain_list_ns, .plain_pairs_ns = alone.plain_pairs_ns};
        measure_flow(of, s, isa, threads, steppers[k], plain, repeats, r);
        if (threads == 1) alone = *r;
        if (threads > 1) r->speed_up = alone.step_ns / r->step_ns;
        print_record(r);
      }
    }
  }
}

static void measure_case(const flow_case *of, const options *o, records *all) {
  flow_case shape = *of;
  if (o->quick) {
    shape.spacing *= 2;
    shape.warm_up = 10;
  }
  world w;
  state s;
  world_open(&w, &shape, SPH_ISA_AUTO, sph_processor_count(), SPH_STEPPER_RK4, NULL);
  world_step(&w, shape.warm_up);
  world_read(&w, &s);
  const double ghosts = (double)sph_boundary_count(w.boundary);
  world_close(&w);

  plain_flow plain;
  plain_fill(&plain, &shape, &s);
  double ns[PASSES][REPEATS_MOST], loop[PASSES];
  plain_list_or_exit(&plain); /* once to get the memory */
  for (int k = 0; k < o->repeats; k++) plain_time(&plain, ns, k);
  for (int p = 0; p < PASSES; p++) loop[p] = median(ns[p], o->repeats);
  const double off = disagreement(&shape, &s, &plain);
  printf("\n%s: %d particles, %.0f ghosts, %s h = %g dx, %.1f neighbours a particle\n", shape.name,
         s.n, ghosts, sph_kernel_name(shape.kernel), shape.h_factor,
         2 * (double)plain.start[s.n] / s.n);
  printf(
      "  plain loop, 1 thread, ns a particle: list %.0f, gradient %.0f, rates %.0f, both %.0f, "
      "convective alone %.0f\n  largest difference of its rates from the library's: %.1e\n",
      loop[LIST], loop[GRADIENT], loop[RATES], loop[GRADIENT] + loop[RATES], loop[CONVECTIVE], off);
  if (!(off < 1e-3)) {
    fprintf(stderr, "%s: the two do not compute the same sums\n", shape.name);
    exit(1);
  }
  print_head();
  measure_all(&shape, &s, &plain, o->repeats, all);
  plain_free(&plain);
  state_free(&s);
}

/* ----------------------------------------------------------------------------------- options */

static void usage(FILE *to) {
  fputs(
      "usage: bench [--quick] [--cases NAME,...] [--repeats 1..9] [--json FILE]\n"
      "             [--compare OLD.json [--from NEW.json]]\n"
      "  --quick    fewer particles and repeats: seconds, for a first look\n"
      "  --cases    which flows, or \"all\"; one of:",
      to);
  for (int k = 0; k < flow_case_count; k++)
    fprintf(to, " %s%s", flow_cases[k].name, flow_cases[k].usual ? "" : " (not by default)");
  fputs(
      "\n  --repeats  measurements that each median is taken of (5, with --quick 3)\n"
      "  --json     write what was measured to a file\n"
      "  --compare  compare with a file of this machine; status 1 if a step is 10 % slower\n"
      "  --from     compare this file instead of measuring\n",
      to);
}

static void refuse(const char *option, const char *why) {
  fprintf(stderr, "bench: %s: %s\n", option, why);
  usage(stderr);
  exit(2);
}

/* True if the comma-separated list has the name. */
static bool is_listed(const char *list, const char *name) {
  const size_t length = strlen(name);
  for (const char *at = list; at; at = strchr(at, ',')) {
    at += *at == ',';
    if (!strncmp(at, name, length) && (at[length] == ',' || !at[length])) return true;
  }
  return false;
}

static bool is_chosen(const options *o, int k) {
  if (!o->cases) return flow_cases[k].usual;
  return !strcmp(o->cases, "all") || is_listed(o->cases, flow_cases[k].name);
}

static void parse(int argc, char **argv, options *o) {
  for (int k = 1; k < argc; k++) {
    const char *option = argv[k];
    if (!strcmp(option, "--help")) {
      usage(stdout);
      exit(0);
    }
    if (!strcmp(option, "--quick")) {
      o->quick = true;
      continue;
    }
    if (k + 1 == argc) refuse(option, "unknown, or a value is missing");
    const char *value = argv[++k];
    if (!strcmp(option, "--cases"))
      o->cases = value;
    else if (!strcmp(option, "--json"))
      o->json = value;
    else if (!strcmp(option, "--compare"))
      o->compare = value;
    else if (!strcmp(option, "--from"))
      o->from = value;
    else if (!strcmp(option, "--repeats") && strlen(value) == 1 && *value >= '1' && *value <= '9')
      o->repeats = *value - '0';
    else
      refuse(option, "unknown, or its value is");
  }
  if (o->repeats == 0) o->repeats = o->quick ? 3 : 5;
  if (o->from && !o->compare) refuse("--from", "needs --compare");
  int chosen = 0;
  for (int k = 0; k < flow_case_count; k++) chosen += is_chosen(o, k);
  if (chosen == 0) refuse("--cases", "names no flow");
}

static bool measure(const options *o, records *now) {
  records_machine(now);
  const double begin = clock_now(), load = machine_load();
  printf("%s, %d processors, load %.2f\n%s", now->cpu, sph_processor_count(), load,
         sph_build_info());
  for (int k = 0; k < flow_case_count; k++)
    if (is_chosen(o, k)) measure_case(&flow_cases[k], o, now);
  printf("\nmeasured in %.0f s, load now %.2f\n", clock_now() - begin, machine_load());
  if (!o->json) return true;
  if (!records_write(now, o->json, load, machine_load())) return false;
  printf("wrote %s\n", o->json);
  return true;
}

int main(int argc, char **argv) {
  static records old, now;
  options o = {0};
  parse(argc, argv, &o);
  if (o.compare && !records_read(&old, o.compare)) return 2;
  if (o.from ? !records_read(&now, o.from) : !measure(&o, &now)) return 2;
  if (o.compare && !records_compare(&old, &now, 0.1)) return 1;
  return 0;
}
