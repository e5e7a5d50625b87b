/* A solitary wave, made by a piston, pushes a seawall that a spring holds: delta-SPH with fixed ghosts.
 *
 * Physics    a tank of still depth d = 0.2 m, 2.5 m from piston to seawall; the wall of mass m, per metre,
 *            on a spring k moves along the tank by the water's force, of which only what exceeds 1.1
 *            times the static force counts; a stop holds it where it was. --rule release lets the whole
 *            force act once it moves, --rule printed steps as the papers print it.
 *            Linear equation of state with c0 = 10 sqrt(g (d + H)), density diffusion delta = 0.1,
 *            artificial viscosity alpha = 0.01.
 * Reference  Liang et al. (2017), eq. (16)-(18); Huang et al. (2019), section 4.4: H/d = 0.5, m = 250 kg/m,
 *            k = 10 N/m; exact potential flow of the same tank: docs/validation.md
 * Build      cc -O2 movable_seawall.c common/example.c common/flow.c common/flume.c -o movable_seawall -lsph -lm
 * Run        ./movable_seawall --mass 250 --stiffness 10 --out seawall.out --summary seawall.json
 * Expect     last line: "movable_seawall: nothing left the tank"
 *
 * TEST: --quick
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/flume.h"

typedef struct setup {
  example_flume flume;
  example_scheme scheme;
  example_checkpoints checkpoints;
  double mass, stiffness, damping, threshold;
  int vtk, pictures;
  bool fixed, quick;
  const char *rule, *out, *summary;
} setup;

static void parse(int argc, char **argv, setup *s) {
  *s = (setup){.flume = EXAMPLE_FLUME, .scheme = example_flume_scheme()};
  s->rule = "preload";
  s->out = s->summary = "";
  s->flume.start = "paddle";
  s->flume.theory = "boussinesq";
  s->flume.depth = 0.2;
  s->flume.length = 2.5;
  s->flume.height_ratio = 0.5;
  s->mass = 250;
  s->stiffness = 10;
  s->threshold = 1.1;
  const example_option options[] = {
      OPTION_NUMBER("--mass", s->mass, 1e-6, 1e9, "m of the seawall [kg/m]"),
      OPTION_NUMBER("--stiffness", s->stiffness, 0, 1e12, "k of its spring [N/m per m]"),
      OPTION_NUMBER("--damping", s->damping, 0, 1e12, "c of its damper [N s/m per m]"),
      OPTION_NUMBER("--threshold", s->threshold, 0, 1e6, "in static forces 1/2 rho g d^2"),
      OPTION_TEXT("--rule", s->rule, "preload, release, printed"),
      OPTION_FLAG("--fixed", s->fixed, "the seawall does not move"),
      EXAMPLE_FLUME_OPTIONS(s->flume),
      EXAMPLE_SCHEME_OPTIONS(s->scheme, "", ""),
      EXAMPLE_CHECKPOINT_OPTIONS(s->checkpoints),
      OPTION_TEXT("--out", s->out, "folder for CSV, pictures and VTK; without it none"),
      OPTION_TEXT("--summary", s->summary, "file for the figures as JSON"),
      OPTION_INTEGER("--vtk", s->vtk, 0, 100000, "frames for ParaView"),
      OPTION_INTEGER("--pictures", s->pictures, 0, 1000, "frames as text for gnuplot"),
      OPTION_FLAG("--quick", s->quick, "coarse and short: a test that it runs")};
  example_parse(argc, argv, "a solitary wave at a seawall on a spring with delta-SPH",
                (int)(sizeof options / sizeof options[0]), options);
  if (strcmp(s->rule, "preload") != 0 && strcmp(s->rule, "release") != 0 &&
      strcmp(s->rule, "printed") != 0)
    example_refuse("--rule", "\"%s\" is none of preload, release, printed", s->rule);
  example_flume *flume = &s->flume;
  if (flume->dx == 0) flume->dx = flume->depth / (s->quick ? 8 : 25);
  if (flume->end == 0) flume->end = s->quick ? 2.4 : 4;
  if ((s->vtk > 0 || s->pictures > 0) && *s->out == '\0')
    example_refuse(s->vtk > 0 ? "--vtk" : "--pictures", "wants a folder, --out");
  example_flume_complete(flume);
}

enum { FORCE, RUN_UP, BED, BODY, ENERGY, PROBES };
static const char *const files[PROBES] = {"force.csv", "run_up.csv", "bed.csv", "wall.csv",
                                          "energy.csv"};

static sph_body *create_body(const setup *s, sph_context *context) {
  const double held =
      s->threshold * 0.5 * s->flume.density * s->flume.gravity * s->flume.depth * s->flume.depth;
  sph_body *body;
  OK(sph_body_create(context, s->mass, &body));
  OK(sph_body_set_spring(body, s->stiffness, 0));
  OK(sph_body_set_damping(body, s->damping));
  OK(sph_body_set_stops(body, 0, INFINITY));
  OK(sph_body_set_threshold(
      body, held, strcmp(s->rule, "release") == 0 ? SPH_THRESHOLD_RELEASE : SPH_THRESHOLD_PRELOAD));
  if (strcmp(s->rule, "printed") == 0) OK(sph_body_set_rule(body, SPH_BODY_AS_PRINTED));
  return body;
}

static void look_at_body(const sph_integrator *flow, double *values, void *user) {
  (void)flow;
  if (user && sph_body_get_state(user, &values[0], &values[1], &values[2], &values[3]) != SPH_OK)
    values[0] = NAN;
}

/* Force, run-up and the pressure at the foot belong to the wall wherever it is. */
static void create_probes(const setup *s, example_flow *f, sph_body *body) {
  sph_context *context = f->context;
  const example_flume *flume = &s->flume;
  const double foot[2] = {flume->length, 0}, up[2] = {0, 1};
  static const char *const names[] = {"x", "v", "a", "force"};
  static const char *const units[] = {"m", "m/s", "m/s^2", "N/m"};
  const int wall = body ? FLUME_RIGHT : FLUME_BED;
  OK(sph_probe_create_force(f->integrator, f->ghosts, wall, &f->probes[FORCE]));
  OK(sph_probe_create_elevation(f->integrator, foot, up, 4 * flume->depth, &f->probes[RUN_UP]));
  OK(sph_probe_follow(f->probes[RUN_UP], f->ghosts, wall));
  OK(sph_probe_create_pressure(f->integrator, foot, &f->probes[BED]));
  OK(sph_probe_follow(f->probes[BED], f->ghosts, wall));
  OK(sph_probe_create_function(f->integrator, 4, names, units, look_at_body, body,
                               &f->probes[BODY]));
  OK(sph_probe_create_energy(f->integrator, &f->probes[ENERGY]));
  example_flume_watch(flume, f, PROBES, FORCE, s->vtk, s->out);
}

/* The figures; docs/examples.md says what each one is. Forces are means over half of sqrt(d/g), about the
 * time that sound takes from surface to bed and back; run-up is counted from the level that its gauge shows
 * before the wave is there. */
static void summarise(const setup *s, example_flow *f, const example_waves *w,
                      example_summary *summary) {
  const sph_context *context = f->context;
  const example_flume *flume = &s->flume;
  const double arrival = example_flume_arrival(flume, w);
  const double d = flume->depth, window = 0.1 * sqrt(d / flume->gravity);
  const double still = 0.5 * flume->density * flume->gravity * d * d;
  example_series force = example_series_read(context, f->probes[FORCE], 0);
  example_series run_up = example_series_read(context, f->probes[RUN_UP], 0);
  example_series place = example_series_read(context, f->probes[BODY], 0);
  const example_peak push = example_series_peak(&force, 0, INFINITY, 5 * window);
  const example_peak rise = example_series_peak(&run_up, 0, INFINITY, window);
  const double level = example_series_mean(&run_up, 0.2 * arrival, 0.4 * arrival);
  const example_peak far = example_series_peak(&place, 0, INFINITY, window);
  example_summary_text(summary, "rule", s->fixed ? "fixed" : s->rule);
  example_summary_text(summary, "interpolator", s->scheme.interpolator);
  example_summary_number(summary, "dx_m", flume->dx);
  example_summary_number(summary, "height_ratio", flume->height_ratio);
  example_summary_number(summary, "mass", s->mass);
  example_summary_number(summary, "stiffness", s->stiffness);
  example_summary_number(summary, "force_max_over_static", push.v / still);
  example_summary_number(summary, "force_max_time_s", push.t);
  example_summary_number(summary, "run_up_over_d", (rise.v - level) / d);
  example_summary_number(summary, "run_up_time_s", rise.t);
  example_summary_number(summary, "displacement_max_over_d", far.v / d);
  example_summary_number(summary, "displacement_max_time_s", far.t);
  example_summary_number(summary, "displacement_end_over_d", place.v[place.n - 1] / d);
  example_summary_number(summary, "moves_from_s", example_series_reach(&place, 1e-3 * d));
  free(force.t);
  free(run_up.t);
  free(place.t);
}

int main(int argc, char **argv) {
  setup s;
  example_flow f = {0};
  example_waves w = {0};
  example_summary summary = {0};
  parse(argc, argv, &s);
  example_flow_open(&s.scheme, 2, s.flume.dx, &f);
  sph_body *body = s.fixed ? NULL : create_body(&s, f.context);
  example_flume_create(&s.flume, &s.scheme, body, &f, &w);
  example_flow_resume(&s.checkpoints, s.out, &f);
  create_probes(&s, &f, body);
  const double start = example_clock();
  const sph_status status = example_flume_run(&s.flume, &f, s.flume.end, s.vtk, s.pictures, s.out);
  const double seconds = example_clock() - start;

  /* A run that stopped still tells what it has measured. */
  summarise(&s, &f, &w, &summary);
  const int64_t lost = example_flume_count_lost(&f);
  example_summary_integer(&summary, "particles_lost", lost);
  example_summary_flow(&summary, &f, seconds);
  if (*s.out != '\0') example_flow_write_series(&f, s.out, PROBES, files);
  example_summary_write(&summary, s.summary);
  example_check(status, f.context, "sph_integrator_step(flow)");
  example_flow_destroy(&f);
  example_waves_destroy(&w);
  sph_body_destroy(&body);
  if (lost > 0) printf("movable_seawall: %lld particles left the tank\n", (long long)lost);
  if (lost == 0) printf("movable_seawall: nothing left the tank\n");
  return lost > 0;
}
