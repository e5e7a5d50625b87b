/* The parameter study of Liang et al. (2017): solitary waves at a seawall on a spring, over wave heights, stiffnesses
 * and masses.
 *
 * Physics    the tank of movable_seawall: still depth h = 0.2 m, 2.5 m from piston to seawall, which moves by the force
 *            above 1.1 times the static one; the piston, after Goring with the first-order wave, is in the
 *            middle of its stroke at t = 1 s. One run for every H/h, k and m.
 * Reference  Liang et al. (2017), figures 13-15, beside ours by `make liang`
 * Build      cc -O2 seawall_study.c common/[a-z]*.c -o seawall_study -lsph -lm -lpthread
 * Run        ./seawall_study --out seawall_study.csv; stopped, the same again goes on; seawall_study_plots.gp
 * Expect     last line: "seawall_study: 300 of 300 runs, 0 failed"
 *
 * TEST: --quick
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/flume.h"
#include "common/study.h"

typedef struct setup {
  example_flume flume;
  example_scheme scheme;
  study_list heights, stiffnesses, masses;
  int processors, most;
  bool retry, quick;
  const char *out;
} setup;

static void parse(int argc, char **argv, setup *s) {
  *s = (setup){.flume = EXAMPLE_FLUME, .scheme = example_flume_scheme()};
  example_flume *flume = &s->flume;
  const char *heights = "", *stiffnesses = "", *masses = "";
  s->scheme.method = "isph";
  s->scheme.threads = 1;
  s->out = "seawall_study.csv";
  flume->start = "paddle";
  flume->theory = "boussinesq";
  flume->depth = 0.2;
  flume->length = 2.5;
  flume->paddle_middle = 1;
  flume->end = 4;
  const example_option options[] = {
      OPTION_TEXT("--heights", heights, "H/h, as 0.3,0.5; 0.2,0.3,0.4,0.5,0.6"),
      OPTION_TEXT("--stiffnesses", stiffnesses,
                  "k [N/m per m]; 0.01,10,50,100,500,1e3,1e4,1e5,1e6,1e7"),
      OPTION_TEXT("--masses", masses, "m [kg/m]; 50,100,175,250,375,500"),
      OPTION_NUMBER("--dx", flume->dx, 1e-5, 0.1, "spacing [m]; 0.008"),
      OPTION_TEXT("--theory", flume->theory, "boussinesq, kdv, rayleigh, grimshaw, fenton, exact"),
      OPTION_NUMBER("--end-time", flume->end, 0.1, 1000, "end of each run [s]"),
      OPTION_NUMBER("--paddle-middle", flume->paddle_middle, 0.1, 1000,
                    "when the piston is in the middle of its stroke [s]"),
      EXAMPLE_SCHEME_OPTIONS(s->scheme, "", ""),
      OPTION_INTEGER("--processors", s->processors, 0, 1024, "runs at a time; 0: one each"),
      OPTION_INTEGER("--runs", s->most, 0, 1000000, "stop after so many; 0: when all are done"),
      OPTION_FLAG("--retry", s->retry, "runs that failed before once more"),
      OPTION_TEXT("--out", s->out, "CSV, with a row a run; one that is there is gone on with"),
      OPTION_FLAG("--quick", s->quick, "eight runs, coarse and short: a test that it runs")};
  example_parse(argc, argv, "the parameter study of Liang et al. (2017)",
                (int)(sizeof options / sizeof options[0]), options);
  if (s->scheme.threads != 1)
    example_refuse("--threads", "a run of the study has one; --processors is how many at a time");
  if (*heights == '\0') heights = s->quick ? "0.3,0.5" : "0.2,0.3,0.4,0.5,0.6";
  if (*stiffnesses == '\0')
    stiffnesses = s->quick ? "10,1e7" : "0.01,10,50,100,500,1e3,1e4,1e5,1e6,1e7";
  if (*masses == '\0') masses = s->quick ? "50,500" : "50,100,175,250,375,500";
  s->heights = study_list_parse("--heights", heights, 0.01, 10);
  s->stiffnesses = study_list_parse("--stiffnesses", stiffnesses, 0, 1e12);
  s->masses = study_list_parse("--masses", masses, 1e-6, 1e9);
  if (flume->dx == 0) flume->dx = s->quick ? 0.04 : 0.008;
  if (s->quick) flume->end = fmin(flume->end, 2.6);
  example_flume_complete(flume);
}

enum { FORCE, RUN_UP, BODY, PROBES };
enum { F_MAX, F_TIME, R_MAX, R_TIME, ONSET, X_MAX, X_TIME, X_END, LOST, STEPS, SECONDS, FIGURES };
static const char columns[] =
    "H_over_h,k_N_per_m2,m_kg_per_m,F_max_over_F_static,F_max_time_s,R_over_h,R_time_s,onset_s,X_"
    "max_over_h,X_max_time_s,"
    "X_end_over_h,particles_lost,steps,seconds,status,message";

/* A run and what it holds, so that it can be given back when the run fails. */
typedef struct run {
  const setup *of;
  study_row *row;
  example_flume flume;
  example_flow flow;
  example_waves waves;
  sph_body *body;
} run;

static void look_at_body(const sph_integrator *flow, double *values, void *user) {
  (void)flow;
  if (sph_body_get_state(user, &values[0], NULL, NULL, NULL) != SPH_OK) values[0] = NAN;
}

static void create(run *r) {
  const example_flume *flume = &r->flume;
  example_flow *f = &r->flow;
  const double h = flume->depth, held = 1.1 * 0.5 * flume->density * flume->gravity * h * h;
  const double foot[2] = {flume->length, 0}, up[2] = {0, 1};
  static const char *const names[] = {"x"}, *const units[] = {"m"};
  example_flow_open(&r->of->scheme, 2, flume->dx, f);
  sph_context *context = f->context;
  OK(sph_body_create(context, r->row->keys[2], &r->body));
  OK(sph_body_set_spring(r->body, r->row->keys[1], 0));
  OK(sph_body_set_stops(r->body, 0, INFINITY));
  OK(sph_body_set_threshold(r->body, held, SPH_THRESHOLD_PRELOAD));
  example_flume_create(flume, &r->of->scheme, r->body, f, &r->waves);
  OK(sph_probe_create_force(f->integrator, f->ghosts, FLUME_RIGHT, &f->probes[FORCE]));
  OK(sph_probe_create_elevation(f->integrator, foot, up, 4 * h, &f->probes[RUN_UP]));
  OK(sph_probe_follow(f->probes[RUN_UP], f->ghosts, FLUME_RIGHT));
  OK(sph_probe_create_function(f->integrator, 1, names, units, look_at_body, r->body,
                               &f->probes[BODY]));
}

/* As movable_seawall has them, docs/examples.md. */
static void measure(const run *r, double *figures) {
  const sph_context *context = r->flow.context;
  const double h = r->flume.depth, window = 0.1 * sqrt(h / r->flume.gravity);
  const double still = 0.5 * r->flume.density * r->flume.gravity * h * h;
  const double arrival = example_flume_arrival(&r->flume, &r->waves);
  example_series force = example_series_read(context, r->flow.probes[FORCE], 0);
  example_series run_up = example_series_read(context, r->flow.probes[RUN_UP], 0);
  example_series place = example_series_read(context, r->flow.probes[BODY], 0);
  const example_peak push = example_series_peak(&force, 0, INFINITY, 5 * window);
  const example_peak rise = example_series_peak(&run_up, 0, INFINITY, window);
  const example_peak far = example_series_peak(&place, 0, INFINITY, window);
  figures[F_MAX] = push.v / still;
  figures[F_TIME] = push.t;
  figures[R_MAX] = (rise.v - example_series_mean(&run_up, 0.2 * arrival, 0.4 * arrival)) / h;
  figures[R_TIME] = rise.t;
  figures[ONSET] = example_series_reach(&place, 1e-3 * h);
  figures[X_MAX] = far.v / h;
  figures[X_TIME] = far.t;
  figures[X_END] = place.v[place.n - 1] / h;
  figures[LOST] = (double)example_flume_count_lost(&r->flow);
  free(force.t);
  free(run_up.t);
  free(place.t);
}

static void simulate(void *user) {
  run *r = user;
  create(r);
  const sph_context *context = r->flow.context;
  example_flume_watch(&r->flume, &r->flow, PROBES, FORCE, 0, "");
  while (sph_integrator_time(r->flow.integrator) < r->flume.end)
    OK(sph_integrator_step(r->flow.integrator));
  measure(r, r->row->figures);
}

static void compute(study_row *row, void *user) {
  const setup *s = user;
  run r = {.of = s, .row = row, .flume = s->flume};
  sph_integrator_stats stats;
  const double start = example_clock();
  r.flume.height_ratio = row->keys[0];
  const sph_status status = example_attempt(simulate, &r, row->message);
  snprintf(row->status, sizeof row->status, "%s", sph_status_name(status));
  if (r.flow.integrator && sph_integrator_get_stats(r.flow.integrator, &stats) == SPH_OK)
    row->figures[STEPS] = (double)stats.steps;
  row->figures[SECONDS] = example_clock() - start;
  example_flow_destroy(&r.flow);
  example_waves_destroy(&r.waves);
  sph_body_destroy(&r.body);
}

/* All that figures depend on; a tank is made for it, so that settings that nothing can be computed with end the
 * program before any run. */
static char *describe(const setup *s) {
  const example_scheme *c = &s->scheme;
  study_row row = {.keys = {0.3, 100, 50}};
  run r = {.of = s, .row = &row, .flume = s->flume};
  char *header = example_memory(2048, 1);
  r.flume.height_ratio = row.keys[0];
  create(&r);
  snprintf(
      header, 2048,
      "# solitary waves at a seawall on a spring, by seawall_study of libsph %s\n"
      "# tank: h=%g m, length=%g m, theory=%s, paddle_middle=%g s, end=%g s, dx=%g m\n"
      "# scheme: method=%s, interpolator=%s, kernel=%s, h=%g dx, stepper=%s, courant=%g, dt=%g s, "
      "c0=%g, alpha=%g, viscosity=%g m2/s, diffusion=%s, delta=%g, isa=%s\n%s\n",
      sph_version(), s->flume.depth, s->flume.length, s->flume.theory, s->flume.paddle_middle,
      s->flume.end, s->flume.dx, c->method, c->interpolator, c->kernel, c->h_ratio, c->stepper,
      c->courant, c->dt, c->c0_factor, c->alpha, c->nu, c->diffusion, c->delta,
      sph_isa_name(sph_context_get_isa(r.flow.context)), columns);
  example_flow_destroy(&r.flow);
  example_waves_destroy(&r.waves);
  sph_body_destroy(&r.body);
  return header;
}

int main(int argc, char **argv) {
  setup s;
  parse(argc, argv, &s);
  char *header = describe(&s);
  study_table table = {.path = s.out, .header = header, .figures = FIGURES};
  study_open(&table, s.retry);
  const int all = s.heights.count * s.stiffnesses.count * s.masses.count;
  study_row *rows = example_memory(all, sizeof *rows);
  int count = 0, done = 0, failed = 0;
  for (int n = 0; n < all; n++) {
    const int a = n / (s.stiffnesses.count * s.masses.count), b = n / s.masses.count;
    const study_row row = {.keys = {s.heights.values[a],
                                    s.stiffnesses.values[b % s.stiffnesses.count],
                                    s.masses.values[n % s.masses.count]}};
    const study_row *old = study_find(&table, row.keys);
    if (!old && (s.most == 0 || count < s.most)) rows[count++] = row;
    if (old) failed += study_failed(old);
    done += old != NULL;
  }
  study_run(&table, count, rows, example_threads(s.processors), compute, &s);
  for (int n = 0; n < count; n++) failed += study_failed(&rows[n]);
  study_close(&table);
  free(rows);
  free(header);
  printf("seawall_study: %d of %d runs, %d failed\n", done + count, all, failed);
  return failed > 0;
}
