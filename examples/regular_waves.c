/* Regular or irregular waves run along a flume into a damping zone: delta-SPH with fixed ghosts.
 *
 * Physics    a flume of still depth d, a piston or a flap hinged at the bed at its left end, a wall at the
 *            right, before which a zone takes the waves out. Lengths are in wavelengths of linear theory.
 *            Linear equation of state with c0 = 10 sqrt(g (d + H)), density diffusion delta = 0.1,
 *            artificial viscosity alpha = 0.01.
 * Reference  Airy and Stokes waves; Biesel (1951) and Madsen (1971) for the paddle; reflection by least
 *            squares over gauges, Mansard and Funke (1980): docs/validation_waves.md
 * Build      cc -O2 regular_waves.c common/example.c common/flow.c common/flume.c -o regular_waves -lsph -lm
 * Run        ./regular_waves --theory stokes2 --out waves.out --summary waves.json
 * Expect     last line: "regular_waves: nothing left the flume"
 *
 * TEST: --quick
 */
#include <complex.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/flume.h"

static const double pi = 3.14159265358979323846;

typedef struct setup {
  example_flume flume;
  example_scheme scheme;
  example_checkpoints checkpoints;
  double kd, wavelengths, zone, rate, periods, seed;
  double k, period; /* of linear theory */
  int vtk, pictures;
  bool quick;
  const char *paddle, *theory, *out, *summary;
} setup;

static void parse(int argc, char **argv, setup *s) {
  *s = (setup){.flume = EXAMPLE_FLUME, .scheme = example_flume_scheme()};
  example_flume *flume = &s->flume;
  s->paddle = "piston";
  s->theory = "stokes2";
  s->out = s->summary = "";
  flume->depth = 0.25;
  flume->height_ratio = 0.15;
  s->kd = 1.5;
  s->wavelengths = 3;
  s->zone = 1;
  s->rate = 10;
  s->periods = 3;
  s->seed = 1;
  const example_option options[] = {
      OPTION_NUMBER("--dx", flume->dx, 1e-5, 1, "spacing [m]; d/40"),
      OPTION_NUMBER("--depth", flume->depth, 1e-3, 100, "depth d of still water [m]"),
      OPTION_NUMBER("--height-ratio", flume->height_ratio, 1e-3, 0.6, "H/d; jonswap: of Hs"),
      OPTION_NUMBER("--kd", s->kd, 0.1, 6, "wave number times depth; jonswap: of the peak"),
      OPTION_TEXT("--theory", s->theory, "airy, stokes2, jonswap: first, second order, irregular"),
      OPTION_TEXT("--paddle", s->paddle, "piston or flap"),
      OPTION_NUMBER("--length", s->wavelengths, 3, 1000, "flume [wavelengths]"),
      OPTION_NUMBER("--zone", s->zone, 0.1, 100, "damping zone at its end [wavelengths]"),
      OPTION_NUMBER("--rate", s->rate, 0, 1e6, "of the zone times the period; 0: no zone"),
      OPTION_NUMBER("--periods", s->periods, 1, 10000, "periods that the figures are taken from"),
      OPTION_NUMBER("--seed", s->seed, 0, 1e15, "jonswap: of the phases"),
      EXAMPLE_SCHEME_OPTIONS(s->scheme, "", ""),
      EXAMPLE_CHECKPOINT_OPTIONS(s->checkpoints),
      OPTION_TEXT("--out", s->out, "folder for CSV, pictures and VTK; without it none"),
      OPTION_TEXT("--summary", s->summary, "file for the figures as JSON"),
      OPTION_INTEGER("--vtk", s->vtk, 0, 100000, "frames for ParaView"),
      OPTION_INTEGER("--pictures", s->pictures, 0, 1000, "frames as text for gnuplot"),
      OPTION_FLAG("--quick", s->quick, "coarse and short: a test that it runs")};
  example_parse(argc, argv, "waves of a wave maker in a flume with delta-SPH",
                (int)(sizeof options / sizeof options[0]), options);
  if (strcmp(s->theory, "airy") != 0 && strcmp(s->theory, "stokes2") != 0 &&
      strcmp(s->theory, "jonswap") != 0)
    example_refuse("--theory", "\"%s\" is none of airy, stokes2, jonswap", s->theory);
  if (strcmp(s->paddle, "piston") != 0 && strcmp(s->paddle, "flap") != 0)
    example_refuse("--paddle", "\"%s\" is neither piston nor flap", s->paddle);
  if (strcmp(s->paddle, "flap") == 0 && strcmp(s->theory, "stokes2") == 0)
    example_refuse("--paddle", "the second order is for pistons; a flap wants --theory airy");
  if (s->zone + 2 > s->wavelengths)
    example_refuse("--zone", "must leave 2 wavelengths of the flume's %g, for the gauges, got %g",
                   s->wavelengths, s->zone);
  if ((s->vtk > 0 || s->pictures > 0) && *s->out == '\0')
    example_refuse(s->vtk > 0 ? "--vtk" : "--pictures", "wants a folder, --out");
  s->k = s->kd / flume->depth;
  s->period = 2 * pi / sqrt(flume->gravity * s->k * tanh(s->kd));
  if (flume->dx == 0) flume->dx = flume->depth / (s->quick ? 10 : 40);
  flume->length = s->wavelengths * 2 * pi / s->k;
  flume->motion = "";
  flume->start = "paddle";
}

/* Gauges stand an eighth of a wavelength apart, from 1 1/8 wavelengths on. */
enum { GAUGES = 8, THEORY = GAUGES, ENERGY, PROBES };
static const char *const files[PROBES] = {"gauge0.csv", "gauge1.csv", "gauge2.csv", "gauge3.csv",
                                          "gauge4.csv", "gauge5.csv", "gauge6.csv", "gauge7.csv",
                                          "theory.csv", "energy.csv"};
static double gauge_place(const setup *s, int g) { return 2 * pi / s->k * (9 + g) / 8; }

/* The figures are taken once energy has been at the end of the flume and back at the gauges, and the last
 * waves of the smooth start with it. */
static double settled(const setup *s) {
  const double group = 0.5 * (1 + 2 * s->kd / sinh(2 * s->kd)); /* over celerity */
  return s->quick ? 2 * s->period : (2 * s->wavelengths - 1.5) / group * s->period + 2 * s->period;
}

static void create_paddle(const setup *s, sph_context *context, example_waves *w) {
  const example_flume *flume = &s->flume;
  const double H = flume->height_ratio * flume->depth;
  if (strcmp(s->theory, "jonswap") == 0) {
    /* Groups must not repeat within the run. */
    const int components = (int)fmax(50, 3 * (settled(s) / s->period + s->periods));
    OK(sph_paddle_create_spectrum(context, SPH_SPECTRUM_JONSWAP, H, s->period, 3.3, flume->depth,
                                  flume->gravity, components, (uint64_t)s->seed, &w->paddle));
  } else {
    const int order = strcmp(s->theory, "stokes2") == 0 ? 2 : 1;
    OK(sph_paddle_create_regular(context, order, H, s->period, flume->depth, flume->gravity, 0,
                                 &w->paddle));
    OK(sph_wave_create_regular(context, order, H, s->period, flume->depth, flume->gravity,
                               &w->wave));
  }
  w->flap = strcmp(s->paddle, "flap") == 0;
  if (w->flap) OK(sph_paddle_set_flap(w->paddle, 0));
}

/* The theory's elevations at the gauges: of the regular wave, or linear, summed over the components. */
typedef struct expected {
  const setup *s;
  const sph_context *context;
  const example_waves *waves;
} expected;
static void look_at_theory(const sph_integrator *flow, double *values, void *user) {
  const expected *of = user;
  const sph_context *context = of->context;
  const double t = sph_integrator_time(flow);
  for (int g = 0; g < GAUGES; g++) {
    const double x = gauge_place(of->s, g);
    double f, k, a, phase;
    values[g] = 0;
    if (of->waves->wave) {
      OK(sph_wave_elevation(of->waves->wave, t, 1, &x, &values[g]));
      continue;
    }
    for (int j = 0; j < sph_paddle_component_count(of->waves->paddle); j++) {
      OK(sph_paddle_get_component(of->waves->paddle, j, &f, &k, &a, &phase, NULL));
      values[g] += a * cos(k * x - 2 * pi * f * t + phase);
    }
  }
}

static void create_probes(expected *of, example_flow *f) {
  sph_context *context = f->context;
  const example_flume *flume = &of->s->flume;
  static const char *const names[GAUGES] = {"gauge0", "gauge1", "gauge2", "gauge3",
                                            "gauge4", "gauge5", "gauge6", "gauge7"};
  static const char *const units[GAUGES] = {"m", "m", "m", "m", "m", "m", "m", "m"};
  for (int g = 0; g < GAUGES; g++) {
    const double foot[2] = {gauge_place(of->s, g), 0}, up[2] = {0, 1};
    OK(sph_probe_create_elevation(f->integrator, foot, up, 2 * flume->depth, &f->probes[g]));
  }
  OK(sph_probe_create_function(f->integrator, GAUGES, names, units, look_at_theory, of,
                               &f->probes[THEORY]));
  OK(sph_probe_create_energy(f->integrator, &f->probes[ENERGY]));
  example_flume_watch(flume, f, PROBES, -1, of->s->vtk, of->s->out);
}

/* 2/(hi - lo) times the integral of (v - mean) exp(i omega t). */
static double complex harmonic(const example_series *series, double omega, double lo, double hi) {
  const double mean = example_series_mean(series, lo, hi);
  double complex sum = 0;
  double span = 0;
  for (int64_t n = 1; n < series->n; n++) {
    const double *t = series->t + n, *v = series->v + n, dt = t[0] - t[-1];
    if (t[-1] < lo || t[0] > hi) continue;
    sum += 0.5 * dt * (v[0] - mean) * cexp(I * omega * t[0]);
    sum += 0.5 * dt * (v[-1] - mean) * cexp(I * omega * t[-1]);
    span += dt;
  }
  return 2 * sum / span;
}

/* Least squares for eta_g = a exp(i k_a x_g) + b exp(i k_b x_g); returns the rms of what is left. */
static double fit(const setup *s, const double complex *eta, double ka, double kb,
                  double complex *a, double complex *b) {
  double complex ea = 0, eb = 0, ab = 0;
  double left = 0;
  for (int g = 0; g < GAUGES; g++) {
    const double x = gauge_place(s, g);
    ea += cexp(-I * ka * x) * eta[g];
    eb += cexp(-I * kb * x) * eta[g];
    ab += cexp(I * (kb - ka) * x);
  }
  const double det = GAUGES * GAUGES - creal(ab * conj(ab));
  *a = (GAUGES * ea - ab * eb) / det;
  *b = (GAUGES * eb - conj(ab) * ea) / det;
  for (int g = 0; g < GAUGES; g++) {
    const double x = gauge_place(s, g);
    const double d = cabs(eta[g] - *a * cexp(I * ka * x) - *b * cexp(I * kb * x));
    left += d * d / GAUGES;
  }
  return sqrt(left);
}

/* Incident and reflected wave of the first harmonic with the wave number that suits them best, bound and free
 * wave of the second. */
static void summarise_regular(const setup *s, sph_context *context, const example_series *gauges,
                              double lo, double hi, example_summary *summary) {
  const double d = s->flume.depth, H = s->flume.height_ratio * d, omega = 2 * pi / s->period;
  double complex first[GAUGES], second[GAUGES], in, out;
  double best = INFINITY, k = NAN, free_k = 0;
  for (int g = 0; g < GAUGES; g++) {
    first[g] = harmonic(&gauges[g], omega, lo, hi);
    second[g] = harmonic(&gauges[g], 2 * omega, lo, hi);
  }
  for (int n = -1000; n <= 1000; n++) {
    const double trial = s->k * (1 + 1e-4 * n), left = fit(s, first, trial, -trial, &in, &out);
    if (left < best) {
      best = left;
      k = trial;
    }
  }
  fit(s, first, k, -k, &in, &out);
  example_summary_number(summary, "height_over_h", 2 * cabs(in) / H);
  example_summary_number(summary, "wavelength_over_theory", s->k / k);
  example_summary_number(summary, "reflection", cabs(out) / cabs(in));
  example_summary_number(summary, "left_over_h", 2 * best / H);
  const double tk = tanh(s->kd), stokes = s->k * H * H / 16 * (3 - tk * tk) / (tk * tk * tk);
  OK(sph_wave_dispersion(context, 0.5 * s->period, d, s->flume.gravity, &free_k));
  fit(s, second, 2 * k, free_k, &in, &out);
  example_summary_number(summary, "bound_second_over_stokes", cabs(in) / stokes);
  example_summary_number(summary, "free_second_over_stokes", cabs(out) / stokes);
}

/* Significant heights, 4 standard deviations, and how far surface and linear theory are apart, over all
 * gauges. */
static void summarise_irregular(const example_series *gauges, const example_series *theories,
                                double lo, double hi, example_summary *summary) {
  double here = 0, theory = 0, apart = 0;
  for (int g = 0; g < GAUGES; g++) {
    const double mean = example_series_mean(&gauges[g], lo, hi);
    for (int64_t n = 0; n < gauges[g].n; n++) {
      const double v = gauges[g].v[n] - mean, linear = theories[g].v[n];
      if (gauges[g].t[n] < lo || gauges[g].t[n] > hi) continue;
      here += v * v;
      theory += linear * linear;
      apart += (v - linear) * (v - linear);
    }
  }
  example_summary_number(summary, "height_over_h", sqrt(here / theory));
  example_summary_number(summary, "apart_over_rms", sqrt(apart / theory));
}

static void summarise(const setup *s, const example_flow *f, double hi, example_summary *summary) {
  sph_context *context = f->context;
  example_series gauges[GAUGES], theories[GAUGES];
  for (int g = 0; g < GAUGES; g++) {
    gauges[g] = example_series_read(context, f->probes[g], 0);
    theories[g] = example_series_read(context, f->probes[THEORY], g);
  }
  example_summary_text(summary, "theory", s->theory);
  example_summary_text(summary, "paddle", s->paddle);
  example_summary_number(summary, "dx_m", s->flume.dx);
  example_summary_number(summary, "height_ratio", s->flume.height_ratio);
  example_summary_number(summary, "period_s", s->period);
  example_summary_number(summary, "wavelength_m", 2 * pi / s->k);
  example_summary_number(summary, "figures_from_s", settled(s));
  if (strcmp(s->theory, "jonswap") == 0)
    summarise_irregular(gauges, theories, settled(s), hi, summary);
  else
    summarise_regular(s, context, gauges, settled(s), hi, summary);
  for (int g = 0; g < GAUGES; g++) {
    free(gauges[g].t);
    free(theories[g].t);
  }
}

int main(int argc, char **argv) {
  setup s;
  example_flow f = {0};
  example_waves w = {0};
  example_summary summary = {0};
  parse(argc, argv, &s);
  const example_flume *flume = &s.flume;
  example_flow_open(&s.scheme, 2, flume->dx, &f);
  sph_context *context = f.context;
  expected of = {&s, context, &w};
  create_paddle(&s, context, &w);
  example_flume_build(flume, &s.scheme, NULL, &f, &w);
  if (s.rate > 0) {
    const bool projects = strcmp(s.scheme.method, "isph") == 0;
    OK((projects ? sph_isph_add_damping_zone : sph_wcsph_add_damping_zone)(
        f.integrator, 0, flume->length - s.zone * 2 * pi / s.k, flume->length, s.rate / s.period));
  }
  example_flow_resume(&s.checkpoints, s.out, &f);
  create_probes(&of, &f);
  /* A few samples more than the figures want. */
  const double hi = settled(&s) + s.periods * s.period, start = example_clock();
  const double end = hi + 0.1 * sqrt(flume->depth / flume->gravity);
  const sph_status status = example_flume_run(flume, &f, end, s.vtk, s.pictures, s.out);
  const double seconds = example_clock() - start;

  /* A run that stopped still tells what it has measured. */
  summarise(&s, &f, hi, &summary);
  const int64_t lost = example_flume_count_lost(&f);
  example_summary_integer(&summary, "particles_lost", lost);
  example_summary_flow(&summary, &f, seconds);
  if (*s.out != '\0') example_flow_write_series(&f, s.out, PROBES, files);
  example_summary_write(&summary, s.summary);
  example_check(status, context, "sph_integrator_step(flow)");
  example_flow_destroy(&f);
  example_waves_destroy(&w);
  if (lost > 0) printf("regular_waves: %lld particles left the flume\n", (long long)lost);
  if (lost == 0) printf("regular_waves: nothing left the flume\n");
  return lost > 0;
}
