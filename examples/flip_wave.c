/* Waves of water and air by the hybrid particle-mesh method: a standing wave in a basin, a solitary wave of a
 * piston, and one that breaks over a submerged bar.
 *
 * Physics    water of 1000 and air of 1 kg/m^3 under an open top, without viscosity; triangles of leg l, of
 *            which each has the square of --divisions particles at the start.
 *            standing: 20 m long, one wave long, d = 5 m, H/d = 0.1, antinode in the middle
 *            solitary: 15 x 0.6 m, d = 0.3 m, H/d = 0.2 or 0.35, 8 s
 *            bar:      13 x 1 m, d = 0.4 m, H/d = 0.625, a bar of 0.25 m between 6 and 11 m, 6.5 s
 * Reference  Maljaars et al. (2017), section 3, whose tables of sizes are lost: see docs/flip.md;
 *            linear theory (standing), Rayleigh's solitary wave and its speed
 * Build      cc -O2 flip_wave.c common/example.c -o flip_wave -lsph -lm
 * Run        ./flip_wave --case solitary --height-ratio 0.35 --out wave.out --vtk 80
 * Expect     last line: "flip_wave: no particle got lost"
 *
 * TEST: --quick
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/example.h"

static const double pi = 3.14159265358979323846, gravity = 9.81, water = 1000, air = 1;
enum { GAUGES = 4, MOST_SAMPLES = 4096, POINTS = 41 };

typedef struct setup {
  const char *flow, *out, *summary;
  double cell, length, height, depth, height_ratio, end, dt, alpha, theta;
  int divisions, threads, vtk;
  bool global, quick;
  double gauge[GAUGES];
} setup;

typedef struct run {
  sph_context *context;
  sph_mesh *mesh;
  sph_particles *particles;
  sph_integrator *integrator;
  sph_wave *wave;
  sph_paddle *paddle;
  int samples;
  double pressure_error[2]; /* half a period and a period after the start */
  double t[MOST_SAMPLES], level[GAUGES][MOST_SAMPLES], kinetic[MOST_SAMPLES], mode[MOST_SAMPLES];
} run;

static const double bar[] = {0, 0, 6, 0, 7.5, 0.25, 9.5, 0.25, 11, 0, 13, 0};

static double period_of(const setup *s) {
  const double k = 2 * pi / s->length;
  return 2 * pi / sqrt(gravity * k * tanh(k * s->depth));
}

static void parse(int argc, char **argv, setup *s) {
  *s = (setup){
      .flow = "standing", .out = "", .summary = "", .divisions = 3, .alpha = -1, .theta = 0.1};
  const example_option options[] = {
      OPTION_TEXT("--case", s->flow, "standing, solitary or bar"),
      OPTION_NUMBER("--cell", s->cell, 1e-3, 1, "leg of the triangles [m]; 0: as the case wants"),
      OPTION_INTEGER("--divisions", s->divisions, 1, 5, "squared: particles of a triangle"),
      OPTION_NUMBER("--height-ratio", s->height_ratio, 0.01, 0.79, "height of the wave, H/d"),
      OPTION_NUMBER("--alpha", s->alpha, -1, 1, "share of PIC; -1: by the step"),
      OPTION_NUMBER("--volume", s->theta, 0, 1, "correction of volumes"),
      OPTION_NUMBER("--dt", s->dt, 0, 1, "time step [s]; 0: by the limits"),
      OPTION_NUMBER("--end", s->end, 0, 1000, "end [s]; 0: as the case wants"),
      OPTION_FLAG("--global", s->global, "smooth grad p / rho everywhere, consistently"),
      OPTION_INTEGER("--threads", s->threads, 0, 1024, "0: one for each processor"),
      OPTION_TEXT("--out", s->out, "folder for gauges and VTK; without it none"),
      OPTION_INTEGER("--vtk", s->vtk, 0, 100000, "frames for ParaView"),
      OPTION_TEXT("--summary", s->summary, "file for the figures as JSON"),
      OPTION_FLAG("--quick", s->quick, "coarse and short: a test that it runs")};
  example_parse(argc, argv, "waves of water and air by particles and a mesh",
                (int)(sizeof options / sizeof options[0]), options);
  const bool standing = strcmp(s->flow, "standing") == 0, over = strcmp(s->flow, "bar") == 0;
  if (!standing && !over && strcmp(s->flow, "solitary") != 0)
    example_refuse("--case", "\"%s\" is none of standing, solitary, bar", s->flow);
  if (s->vtk > 0 && *s->out == '\0') example_refuse("--vtk", "wants a folder, --out");
  s->length = standing ? 20 : over ? 13 : 15;
  s->height = standing ? 7 : over ? 1 : 0.6;
  s->depth = standing ? 5 : over ? 0.4 : 0.3;
  if (s->height_ratio == 0) s->height_ratio = standing ? 0.1 : over ? 0.625 : 0.2;
  if (s->cell == 0) s->cell = standing ? 0.1 : over ? 0.035 : 0.025;
  if (s->quick) s->cell *= 4;
  if (s->end == 0) s->end = standing ? 4.5 * period_of(s) : over ? 6.5 : 8;
  if (s->quick) s->end *= 0.1;
  static const double gauges[3][GAUGES] = {{10, 5, 1, 15}, {3, 6, 9, 12}, {3, 5.5, 7.5, 10}};
  memcpy(s->gauge, gauges[standing ? 0 : over ? 2 : 1], sizeof s->gauge);
}

static double surface(const double *x, void *user) {
  const setup *s = user;
  if (strcmp(s->flow, "standing") != 0) return s->depth;
  return s->depth + 0.5 * s->height_ratio * s->depth * cos(2 * pi / s->length * x[0]);
}

static void create(setup *s, run *r) {
  sph_context *context;
  if (sph_context_create(&r->context) != SPH_OK) exit(1);
  context = r->context;
  OK(sph_context_set_threads(context, example_threads(s->threads)));
  const int columns = (int)lround(s->length / s->cell), rows = (int)lround(s->height / s->cell);
  const double level[] = {0, 0, 15, 0};
  if (strcmp(s->flow, "bar") == 0)
    OK(sph_mesh_create_flume_polyline(context, 6, bar, s->height, columns, rows, &r->mesh));
  else if (strcmp(s->flow, "solitary") == 0)
    OK(sph_mesh_create_flume_polyline(context, 2, level, s->height, columns, rows, &r->mesh));
  else
    OK(sph_mesh_create_flume(context, 0, s->length, s->height, columns, rows, NULL, NULL,
                             &r->mesh));
  OK(sph_particles_create(context, 2, s->cell / s->divisions / sqrt(2), &r->particles));
  OK(sph_flip_fill(r->mesh, r->particles, s->divisions, surface, s, water, air));
  OK(sph_flip_create(context, r->mesh, r->particles, &r->integrator));
  OK(sph_flip_set_densities(r->integrator, air, water));
  OK(sph_flip_set_pic_share(r->integrator, s->alpha));
  OK(sph_flip_set_volume_correction(r->integrator, s->theta));
  if (s->global) OK(sph_flip_set_smoothing(r->integrator, SPH_FLIP_SMOOTHING_GLOBAL, false));
  if (s->dt > 0) OK(sph_integrator_set_dt(r->integrator, s->dt));
  if (strcmp(s->flow, "standing") == 0) return;
  OK(sph_wave_create_solitary(context, SPH_SOLITARY_RAYLEIGH, s->height_ratio * s->depth, s->depth,
                              gravity, &r->wave));
  OK(sph_paddle_create_solitary(context, r->wave, 0, &r->paddle));
  const double reach = strcmp(s->flow, "bar") == 0 ? 5.5 : s->length;
  OK(sph_flip_set_paddle(r->integrator, sph_paddle_motion, r->paddle, reach));
}

static double bed_at(const setup *s, double x) {
  int k = 1;
  if (strcmp(s->flow, "bar") != 0) return 0;
  while (k < 5 && bar[2 * k] < x) k++;
  const double share = (x - bar[2 * k - 2]) / (bar[2 * k] - bar[2 * k - 2]);
  return bar[2 * k - 1] + share * (bar[2 * k + 1] - bar[2 * k - 1]);
}

/* Levels by the water in strips of four cells' width, and the surface's part in cos(2 pi x/length), which is
 * the standing wave. Both are sums over particles, finer than a cell. */
static void weigh(const setup *s, run *r) {
  const sph_context *context = r->context;
  const int64_t n = sph_particles_count(r->particles);
  double *x = example_numbers(2 * n), *m = example_numbers(n), *rho = example_numbers(n);
  double strip[GAUGES] = {0}, mode = 0;
  OK(sph_particles_read(r->particles, SPH_POSITION, x, 2 * n));
  OK(sph_particles_read(r->particles, SPH_MASS, m, n));
  OK(sph_particles_read(r->particles, SPH_DENSITY, rho, n));
  for (int64_t i = 0; i < n; i++) {
    if (rho[i] < 0.5 * water) continue;
    for (int k = 0; k < GAUGES; k++)
      if (fabs(x[2 * i] - s->gauge[k]) < 2 * s->cell) strip[k] += m[i];
    mode += m[i] * cos(2 * pi / s->length * x[2 * i]);
  }
  for (int k = 0; k < GAUGES; k++)
    r->level[k][r->samples] = bed_at(s, s->gauge[k]) + strip[k] / (water * 4 * s->cell);
  r->mode[r->samples] = 2 * mode / (water * s->length);
  free(x);
  free(m);
  free(rho);
}

static void sample(const setup *s, run *r) {
  const sph_context *context = r->context;
  sph_energy energy;
  if (r->samples == MOST_SAMPLES) return;
  r->t[r->samples] = sph_integrator_time(r->integrator);
  weigh(s, r);
  OK(sph_flip_get_energy(r->integrator, &energy));
  r->kinetic[r->samples++] = energy.kinetic;
}

static void write_frame(const setup *s, const run *r, int number) {
  sph_context *context = r->context;
  const int64_t nodes = sph_mesh_node_count(r->mesh), cells = sph_mesh_cell_count(r->mesh);
  double *pressure = example_numbers(nodes), *rho = example_numbers(cells);
  double *velocity = example_numbers(2 * cells);
  OK(sph_flip_read_pressure(r->integrator, pressure, nodes));
  OK(sph_flip_read_cells(r->integrator, rho, velocity, cells));
  const sph_mesh_field at_nodes = {"pressure", "Pa", 1, pressure};
  const sph_mesh_field of_cells[] = {{"density", "kg/m^3", 1, rho},
                                     {"velocity", "m/s", 2, velocity}};
  char name[32];
  snprintf(name, sizeof name, "mesh_%06d.vtu", number);
  OK(sph_mesh_write_vtk(r->mesh, example_path(s->out, name), sph_integrator_time(r->integrator), 1,
                        &at_nodes, 2, of_cells));
  free(pressure);
  free(rho);
  free(velocity);
}

/* Pressures from bed to surface in the middle now, beside linear theory: (18) of Maljaars et al. (2017). */
static double pressure_error(const setup *s, run *r) {
  sph_context *context = r->context;
  const double k = 2 * pi / s->length, omega = sqrt(gravity * k * tanh(k * s->depth));
  const double a = 0.5 * s->height_ratio * s->depth, t = sph_integrator_time(r->integrator);
  double x[2 * POINTS], p[POINTS], most = 0;
  for (int i = 0; i < POINTS; i++) {
    x[2 * i] = 0.5 * s->length;
    x[2 * i + 1] = (s->depth - 2 * a) * i / (POINTS - 1);
  }
  OK(sph_flip_evaluate(r->integrator, POINTS, x, p, NULL));
  for (int i = 0; i < POINTS; i++) {
    const double z = x[2 * i + 1];
    const double wave = -a * cosh(k * z) / cosh(k * s->depth) * cos(omega * t);
    most = fmax(most, fabs(p[i] - water * gravity * (s->depth - z + wave) -
                           air * gravity * (s->height - s->depth)));
  }
  return most / (water * gravity * s->depth);
}

static void advance(const setup *s, run *r) {
  const sph_context *context = r->context;
  example_progress progress = {.start = example_clock()};
  const int count = s->quick ? 36 : 900, every = s->vtk > 0 ? (count + s->vtk - 1) / s->vtk : count;
  for (int k = 0, frame = 0; k <= count; k++) {
    if (k > 0) OK(sph_integrator_advance(r->integrator, s->end * k / count));
    sample(s, r);
    for (int half = 1; half <= 2; half++)
      if (fabs(s->end * k / count - 0.5 * half * period_of(s)) < 1e-9)
        r->pressure_error[half - 1] = pressure_error(s, r);
    if (s->vtk > 0 && k > 0 && k % every == 0) write_frame(s, r, frame++);
    example_progress_show(&progress, r->integrator, s->end);
  }
  example_progress_end(&progress);
}

/* ---- figures ---- */

/* The k-th time from 0 on when a series crosses a level upwards (or downwards), by straight lines. */
static double crossing(const run *r, const double *v, double level, bool upwards, int k) {
  for (int i = 1; i < r->samples; i++) {
    const double a = v[i - 1] - level, b = v[i] - level;
    if ((upwards ? a < 0 && b >= 0 : a > 0 && b <= 0) && k-- == 0)
      return r->t[i - 1] + (r->t[i] - r->t[i - 1]) * a / (a - b);
  }
  return NAN;
}

static double largest(const run *r, const double *v, double from, double to) {
  double most = -HUGE_VAL;
  for (int i = 0; i < r->samples; i++)
    if (r->t[i] >= from && r->t[i] <= to) most = fmax(most, v[i]);
  return most;
}

/* The period by the first passes of the mode through 0 and those three periods later; what kinetic energy and
 * the mode lose in four. */
static void summarise_standing(const setup *s, const run *r, example_summary *summary) {
  const double period = period_of(s), a = 0.5 * s->height_ratio * s->depth;
  const double first = crossing(r, r->mode, 0, true, 0), later = crossing(r, r->mode, 0, true, 3);
  example_summary_number(summary, "period_theory_s", period);
  example_summary_number(summary, "period_over_theory", (later - first) / 3 / period);
  const double before = largest(r, r->kinetic, 0, 0.5 * period);
  const double after = largest(r, r->kinetic, 4 * period, 4.5 * period);
  example_summary_number(summary, "energy_lost_in_4_periods", 1 - after / before);
  example_summary_number(summary, "mode_after_4_periods",
                         largest(r, r->mode, 3.75 * period, 4.25 * period) / a);
  example_summary_number(summary, "pressure_error_half_period", r->pressure_error[0]);
  example_summary_number(summary, "pressure_error_period", r->pressure_error[1]);
}

/* When a wave passes a gauge: the mean of times, weighed with what is above a third of its height. */
static double passing(const setup *s, const run *r, int gauge) {
  const double base = s->depth + (largest(r, r->level[gauge], 0, s->end) - s->depth) / 3;
  double sum = 0, moment = 0;
  for (int i = 0; i < r->samples; i++) {
    const double above = fmax(0, r->level[gauge][i] - base);
    sum += above;
    moment += above * r->t[i];
  }
  return moment / sum;
}

/* Heights at gauges, and the wave's speed between the first two. */
static void summarise_solitary(const setup *s, const run *r, example_summary *summary) {
  static const char *const keys[GAUGES] = {"gauge0_over_h", "gauge1_over_h", "gauge2_over_h",
                                           "gauge3_over_h"};
  const double H = s->height_ratio * s->depth;
  for (int k = 0; k < GAUGES; k++)
    example_summary_number(summary, keys[k], (largest(r, r->level[k], 0, s->end) - s->depth) / H);
  const double time = passing(s, r, 1) - passing(s, r, 0);
  example_summary_number(summary, "celerity_over_theory",
                         (s->gauge[1] - s->gauge[0]) / time / sph_wave_celerity(r->wave));
}

static void summarise_run(const run *r, double seconds, example_summary *summary) {
  const sph_context *context = r->context;
  sph_integrator_stats stats;
  sph_flip_stats flip;
  sph_solver_stats solver;
  sph_solver *of;
  OK(sph_integrator_get_stats(r->integrator, &stats));
  OK(sph_flip_get_stats(r->integrator, &flip));
  OK(sph_flip_get_solver(r->integrator, &of));
  OK(sph_solver_get_stats(of, &solver));
  example_summary_integer(summary, "cells", sph_mesh_cell_count(r->mesh));
  example_summary_integer(summary, "particles", sph_particles_count(r->particles));
  example_summary_integer(summary, "steps", stats.steps);
  example_summary_number(summary, "iterations_a_step",
                         (double)solver.total_iterations / (double)solver.solves);
  example_summary_number(summary, "seconds", seconds);
  example_summary_number(summary, "seconds_solver", stats.seconds_solver);
  example_summary_number(summary, "seconds_particles", stats.seconds_update);
  example_summary_number(summary, "seconds_sort_and_means",
                         stats.seconds_sort + stats.seconds_pack);
  example_summary_integer(summary, "entered", flip.entered);
  example_summary_integer(summary, "left", flip.left);
  example_summary_integer(summary, "put_back", stats.contacts);
}

static void write_gauges(const setup *s, const run *r) {
  FILE *file = fopen(example_path(s->out, "gauges.csv"), "w");
  if (!file) example_refuse("--out", "\"%s\": a file cannot be written there", s->out);
  fprintf(file, "t_s,level0_m,level1_m,level2_m,level3_m,mode_m,kinetic_J_per_m\n");
  for (int i = 0; i < r->samples; i++)
    fprintf(file, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", r->t[i], r->level[0][i], r->level[1][i],
            r->level[2][i], r->level[3][i], r->mode[i], r->kinetic[i]);
  if (fclose(file) != 0) example_refuse("--out", "\"%s\": the disk is full", s->out);
}

int main(int argc, char **argv) {
  setup s;
  static run r;
  parse(argc, argv, &s);
  create(&s, &r);
  example_summary summary = {0};
  example_summary_text(&summary, "case", s.flow);
  example_summary_number(&summary, "cell_m", s.cell);
  const double begin = example_clock();
  const bool standing = strcmp(s.flow, "standing") == 0;
  advance(&s, &r);
  if (standing && !s.quick) summarise_standing(&s, &r, &summary);
  if (!standing && !s.quick) summarise_solitary(&s, &r, &summary);
  summarise_run(&r, example_clock() - begin, &summary);
  if (*s.out) write_gauges(&s, &r);
  example_summary_write(&summary, s.summary);
  sph_paddle_destroy(&r.paddle);
  sph_wave_destroy(&r.wave);
  sph_integrator_destroy(&r.integrator);
  sph_particles_destroy(&r.particles);
  sph_mesh_destroy(&r.mesh);
  sph_context_destroy(&r.context);
  printf("flip_wave: no particle got lost\n");
  return 0;
}
