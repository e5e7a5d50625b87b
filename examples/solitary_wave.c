/* A solitary wave runs up a fixed wall, vertical or inclined: delta-SPH with fixed ghosts.
 *
 * Physics    a flume of still depth d with a wave of height H that a piston makes (--start paddle), or that
 *            is there at t = 0 with surface, velocity and pressure of a theory (--start theory).
 *            Linear equation of state with c0 = 10 sqrt(g (d + H)), density diffusion delta = 0.1,
 *            artificial viscosity alpha = 0.01.
 * Reference  Huang et al. (2019), section 4.3: d = 0.25 m, H = 0.15 m, wall of 120 degrees; exact potential
 *            flow of the same wave at the same wall: docs/validation.md
 * Build      cc -O2 solitary_wave.c common/example.c common/flow.c common/flume.c -o solitary_wave -lsph -lm
 * Run        ./solitary_wave --wall inclined --out solitary.out --summary solitary.json
 * Expect     last line: "solitary_wave: nothing left the flume"
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
  int vtk, pictures;
  bool quick;
  const char *wall, *out, *summary;
} setup;

static void parse(int argc, char **argv, setup *s) {
  *s = (setup){.flume = EXAMPLE_FLUME, .scheme = example_flume_scheme()};
  s->wall = "vertical";
  s->out = s->summary = "";
  s->flume.start = "theory";
  s->flume.depth = 0.25;
  s->flume.height_ratio = 0.6;
  s->flume.angle = 0;
  const example_option options[] = {
      OPTION_TEXT("--wall", s->wall, "vertical or inclined"),
      OPTION_NUMBER("--angle", s->flume.angle, 0, 180, "of the wall, in the water; inclined 120"),
      EXAMPLE_FLUME_OPTIONS(s->flume),
      EXAMPLE_SCHEME_OPTIONS(s->scheme, "", ""),
      EXAMPLE_CHECKPOINT_OPTIONS(s->checkpoints),
      OPTION_TEXT("--out", s->out, "folder for CSV, pictures and VTK; without it none"),
      OPTION_TEXT("--summary", s->summary, "file for the figures as JSON"),
      OPTION_INTEGER("--vtk", s->vtk, 0, 100000, "frames for ParaView"),
      OPTION_INTEGER("--pictures", s->pictures, 0, 1000, "frames as text for gnuplot"),
      OPTION_FLAG("--quick", s->quick, "coarse and short: a test that it runs")};
  example_parse(argc, argv, "a solitary wave at a fixed wall with delta-SPH",
                (int)(sizeof options / sizeof options[0]), options);
  if (strcmp(s->wall, "vertical") != 0 && strcmp(s->wall, "inclined") != 0)
    example_refuse("--wall", "\"%s\" is neither vertical nor inclined", s->wall);
  example_flume *flume = &s->flume;
  if (flume->angle == 0) flume->angle = strcmp(s->wall, "inclined") == 0 ? 120 : 90;
  if (flume->dx == 0) flume->dx = flume->depth / (s->quick ? 10 : 25);
  if (flume->length == 0) flume->length = 40 * flume->depth;
  if (flume->length < 19 * flume->depth)
    example_refuse("--length", "must be 19 depths at least, for the gauges, got %g m",
                   flume->length);
  if ((s->vtk > 0 || s->pictures > 0) && *s->out == '\0')
    example_refuse(s->vtk > 0 ? "--vtk" : "--pictures", "wants a folder, --out");
  example_flume_complete(flume);
}

/* Gauges stand 18, 15, 12 and 9 depths before the toe, the last 5 depths behind the left side. */
enum { P0, P1, FORCE, RUN_UP, GAUGE, GAUGES = 5, BED = GAUGE + GAUGES, ENERGY, PROBES };
static const char *const files[PROBES] = {"p0.csv",     "p1.csv",     "force.csv",  "run_up.csv",
                                          "gauge0.csv", "gauge1.csv", "gauge2.csv", "gauge3.csv",
                                          "gauge4.csv", "bed.csv",    "energy.csv"};
static double gauge_place(const example_flume *s, int k) {
  return k == GAUGES - 1 ? 5 * s->depth : s->length - (18 - 3 * k) * s->depth;
}

static void create_probes(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const example_flume *flume = &s->flume;
  const double depth = flume->depth;
  double low[2], high[2], toe[2], along[2], up[2] = {0, 1};
  example_flume_on_wall(flume, 0.2 * depth, low);
  example_flume_on_wall(flume, 0.6 * depth, high);
  example_flume_on_wall(flume, 0, toe);
  for (int d = 0; d < 2; d++)
    along[d] = (low[d] - toe[d]) / hypot(low[0] - toe[0], low[1] - toe[1]);
  OK(sph_probe_create_pressure(f->integrator, low, &f->probes[P0]));
  OK(sph_probe_create_pressure(f->integrator, high, &f->probes[P1]));
  OK(sph_probe_create_force(f->integrator, f->ghosts, FLUME_BED, &f->probes[FORCE]));
  OK(sph_probe_create_elevation(f->integrator, toe, along, 4.5 * depth / along[1],
                                &f->probes[RUN_UP]));
  for (int k = 0; k < GAUGES; k++) {
    const double foot[2] = {gauge_place(flume, k), 0};
    OK(sph_probe_create_elevation(f->integrator, foot, up, 3 * depth, &f->probes[GAUGE + k]));
  }
  const double bed[2] = {gauge_place(flume, 3), 0};
  OK(sph_probe_create_pressure(f->integrator, bed, &f->probes[BED]));
  OK(sph_probe_create_energy(f->integrator, &f->probes[ENERGY]));
  example_flume_watch(flume, f, PROBES, FORCE, s->vtk, s->out);
}

/* How much the pressures of single particles scatter: rms of p less the parabola fitted through the
 * neighbours, between the first gauge and the fourth. */
static double roughness(const setup *s, const example_flow *f) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  const char *const field = SPH_PRESSURE;
  sph_interpolator *fit;
  double *x = example_flow_read(f, SPH_POSITION, 2), *p = example_flow_read(f, field, 1),
         *smooth = example_numbers(n), sum = 0;
  int *rungs = example_memory(n, sizeof *rungs);
  int64_t count = 0;
  OK(sph_interpolator_create(context, SPH_INTERPOLATOR_MLS_QUADRATIC, f->kernel, &fit));
  OK(sph_interpolator_evaluate(fit, f->water, n, x, 1, &field, smooth, rungs));
  for (int64_t i = 0; i < n; i++) {
    const bool between =
        x[2 * i] >= gauge_place(&s->flume, 0) && x[2 * i] <= gauge_place(&s->flume, 3);
    if (!between || rungs[i] != SPH_INTERPOLATOR_MLS_QUADRATIC) continue;
    sum += (p[i] - smooth[i]) * (p[i] - smooth[i]);
    count++;
  }
  sph_interpolator_destroy(&fit);
  free(x);
  free(p);
  free(smooth);
  free(rungs);
  return count > 0 ? sqrt(sum / (double)count) : NAN;
}

/* The figures; docs/examples.md says what each one is. Peaks of pressure and force are means over half of
 * sqrt(d/g), about the time that sound takes from surface to bed and back; run-up is counted from the
 * level that its gauge shows before the wave is there. */
static void summarise(const setup *s, example_flow *f, const example_waves *w,
                      example_summary *summary) {
  const sph_context *context = f->context;
  const example_flume *flume = &s->flume;
  const double d = flume->depth, second = sqrt(d / flume->gravity);
  const double bar = flume->density * flume->gravity * d, H = flume->height_ratio * d;
  const double sine = sin(flume->angle * 3.14159265358979323846 / 180);
  static const char *const height_keys[] = {"gauge0_height_over_h", "gauge1_height_over_h",
                                            "gauge2_height_over_h", "gauge3_height_over_h",
                                            "gauge4_height_over_h"};
  const double arrival = example_flume_arrival(flume, w);
  example_peak peaks[GAUGE + GAUGES];
  double passes[GAUGES], still = d;
  for (int k = 0; k < GAUGE + GAUGES; k++) {
    example_series series = example_series_read(context, f->probes[k], 0);
    /* The wave at a gauge, before what the wall sends back. */
    const double last = k < GAUGE ? INFINITY : arrival;
    peaks[k] = example_series_peak(&series, 0, last, (k < RUN_UP ? 0.5 : 0.1) * second);
    if (k == RUN_UP) still = example_series_mean(&series, 0.2 * arrival, 0.4 * arrival);
    if (k >= GAUGE) passes[k - GAUGE] = example_series_reach(&series, d + 0.5 * H);
    free(series.t);
  }
  example_summary_text(summary, "wall", s->wall);
  example_summary_text(summary, "start", flume->start);
  example_summary_text(summary, "interpolator", s->scheme.interpolator);
  example_summary_number(summary, "dx_m", flume->dx);
  example_summary_number(summary, "height_ratio", flume->height_ratio);
  /* Horizontal; the normal force and its static value are both larger by 1/sine. */
  example_summary_number(summary, "force_max_over_static", peaks[FORCE].v / (0.5 * bar * d));
  example_summary_number(summary, "force_max_time_s", peaks[FORCE].t);
  example_summary_number(summary, "p0_max_over_rho_g_d", peaks[P0].v / bar);
  example_summary_number(summary, "p0_max_after_force_s", peaks[P0].t - peaks[FORCE].t);
  example_summary_number(summary, "p1_max_over_rho_g_d", peaks[P1].v / bar);
  example_summary_number(summary, "p1_max_after_force_s", peaks[P1].t - peaks[FORCE].t);
  example_summary_number(summary, "run_up_over_d", (peaks[RUN_UP].v - still) * sine / d);
  example_summary_number(summary, "run_up_time_s", peaks[RUN_UP].t);
  for (int k = 0; k < GAUGES; k++)
    example_summary_number(summary, height_keys[k], (peaks[GAUGE + k].v - d) / H);
  /* By when the front passes at half the height. */
  const double way = gauge_place(flume, 3) - gauge_place(flume, 1);
  example_summary_number(summary, "celerity_over_theory",
                         way / (passes[3] - passes[1]) / sph_wave_celerity(w->wave));
  example_series bed = example_series_read(context, f->probes[BED], 0);
  const double crest = peaks[GAUGE + 3].t;
  example_summary_number(
      summary, "bed_noise_over_rho_g_d",
      example_series_noise(&bed, crest - 2 * second, crest + 2 * second, 0.5 * second) / bar);
  example_summary_number(summary, "pressure_roughness_over_rho_g_d", roughness(s, f) / bar);
  free(bed.t);
  example_series energy = example_series_read(context, f->probes[ENERGY], 3);
  example_summary_number(
      summary, "energy_lost_gauge0_to_3_j",
      example_series_mean(&energy, peaks[GAUGE].t - 0.25 * second, peaks[GAUGE].t + 0.25 * second) -
          example_series_mean(&energy, crest - 0.25 * second, crest + 0.25 * second));
  example_summary_number(summary, "energy_end_minus_start_j", energy.v[energy.n - 1] - energy.v[0]);
  free(energy.t);
}

int main(int argc, char **argv) {
  setup s;
  example_flow f = {0};
  example_waves w = {0};
  example_summary summary = {0};
  parse(argc, argv, &s);
  example_flow_open(&s.scheme, 2, s.flume.dx, &f);
  example_flume_create(&s.flume, &s.scheme, NULL, &f, &w);
  example_flow_resume(&s.checkpoints, s.out, &f);
  create_probes(&s, &f);
  const double after = 5 * sqrt(s.flume.depth / s.flume.gravity);
  const double end = s.flume.end > 0 ? s.flume.end : example_flume_arrival(&s.flume, &w) + after;
  const double start = example_clock();
  const sph_status status = example_flume_run(&s.flume, &f, end, s.vtk, s.pictures, s.out);
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
  if (lost > 0) printf("solitary_wave: %lld particles left the flume\n", (long long)lost);
  if (lost == 0) printf("solitary_wave: nothing left the flume\n");
  return lost > 0;
}
