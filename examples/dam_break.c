/* A column of water collapses, runs along a dry bed and hits a wall: delta-SPH with fixed ghosts.
 *
 * Physics    column L x H = 1.2 x 0.6 m in an open tank 5.366 H long; the gate vanishes at t = 0, the
 *            pressure at that instant solves Laplace's equation. Linear equation of state with
 *            c0 = 20 sqrt(g H), density diffusion delta = 0.1, artificial viscosity alpha = 0.02.
 *            With --dim 3 a column of 1.0 x 0.5 x 0.5 m in a box of 2.0 x 0.5 x 1.5 m.
 * Reference  Huang et al. (2019), section 4.2; measured wall pressure: Buchner (2002); fronts: Martin and
 *            Moyce (1952), Koshizuka and Oka (1996)
 * Build      cc -O2 dam_break.c common/example.c common/flow.c -o dam_break -lsph -lm
 * Run        ./dam_break --dx 0.01 --out dam_break.out --summary dam_break.json
 * Expect     last line: "dam_break: nothing left the tank"
 *
 * TEST: --quick
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/flow.h"

/* Places: x along the tank, in 3D y across it; height is the last axis, `up`. */
typedef struct setup {
  double dx, length, height, tank, width, top, end, gravity, density, c0;
  int dim, up, vtk, pictures;
  bool quick;
  example_scheme scheme;
  example_checkpoints checkpoints;
  const char *out, *summary;
} setup;

static void parse(int argc, char **argv, setup *s) {
  *s = (setup){.dim = 2, .width = 0.5, .end = 7.4, .gravity = 9.81, .density = 1000};
  s->scheme = (example_scheme)EXAMPLE_SCHEME;
  s->scheme.c0_factor = 20;
  s->scheme.kernel = s->out = s->summary = "";
  s->scheme.h_ratio = 0;
  const example_option options[] = {
      OPTION_INTEGER("--dim", s->dim, 2, 3, "2 or 3 dimensions"),
      OPTION_NUMBER("--dx", s->dx, 1e-5, 1, "spacing [m]; 0.004, 3D 0.5/31"),
      OPTION_NUMBER("--length", s->length, 1e-3, 100, "length L of the column [m]; 1.2, 3D 1"),
      OPTION_NUMBER("--height", s->height, 1e-3, 100, "height H of the column [m]; 0.6, 3D 0.5"),
      OPTION_NUMBER("--tank", s->tank, 1e-3, 1000, "length of the tank [m]; 5.366 H, 3D 4 H"),
      OPTION_NUMBER("--width", s->width, 1e-3, 100, "width in 3D [m]"),
      OPTION_NUMBER("--top", s->top, 1e-3, 1000,
                    "height of the side walls [m], of the lid in 3D; 8 H, 3D 3 H"),
      OPTION_NUMBER("--end-t-star", s->end, 1e-6, 1000, "end, t sqrt(g/H)"),
      EXAMPLE_SCHEME_OPTIONS(s->scheme, "; gaussian, 3D wendland-c2", "; 1.3, 3D 1.5"),
      EXAMPLE_CHECKPOINT_OPTIONS(s->checkpoints),
      OPTION_TEXT("--out", s->out, "folder for CSV, pictures and VTK; without it none"),
      OPTION_TEXT("--summary", s->summary, "file for the figures as JSON"),
      OPTION_INTEGER("--vtk", s->vtk, 0, 100000, "frames for ParaView"),
      OPTION_INTEGER("--pictures", s->pictures, 0, 1000, "frames as text for gnuplot"),
      OPTION_FLAG("--quick", s->quick, "coarse and short: a test that it runs")};
  example_parse(argc, argv, "dam break with delta-SPH and fixed ghost particles",
                (int)(sizeof options / sizeof options[0]), options);
  const bool flat = s->dim == 2;
  if (s->height == 0) s->height = flat ? 0.6 : 0.5;
  if (s->length == 0) s->length = flat ? 1.2 : 1.0;
  if (s->tank == 0) s->tank = flat ? 5.366 * s->height : 4 * s->height;
  if (s->top == 0) s->top = flat ? 8 * s->height : 3 * s->height;
  if (s->scheme.h_ratio == 0) s->scheme.h_ratio = flat ? 1.3 : 1.5;
  if (*s->scheme.kernel == '\0') s->scheme.kernel = flat ? "gaussian" : "wendland-c2";
  if (s->quick) s->end = fmin(s->end, 2.8);
  if (s->dx == 0) s->dx = flat ? (s->quick ? 0.03 : 0.004) : (s->quick ? 0.5 / 8 : 0.5 / 31);
  if (s->tank < s->length + s->dx)
    example_refuse("--tank", "must exceed the column, got %g", s->tank);
  if ((s->vtk > 0 || s->pictures > 0) && *s->out == '\0')
    example_refuse(s->vtk > 0 ? "--vtk" : "--pictures", "wants a folder, --out");
  s->c0 = s->scheme.c0_factor * sqrt(s->gravity * s->height);
  s->up = s->dim - 1;
}

enum { P1_DISC, P1_POINT, P1_EDGE, FRONT, COLUMN, ENERGY, MASS, PROBES };
static const char *const files[PROBES] = {"p1_plate.csv", "p1_point.csv", "p1_edge.csv",
                                          "front.csv",    "column.csv",   "energy.csv",
                                          "mass.csv"};

/* What is measured between the steps; NaN until it happens. */
typedef struct moments {
  double asymmetry_early, cavity_closes;
} moments;

static void start_from_laplace(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  double *x = example_numbers(n * (s->dim + 3)), *section = x + n * s->dim,
         *pressure = section + 2 * n;
  OK(sph_particles_read(f->water, SPH_POSITION, x, n * s->dim));
  for (int64_t i = 0; i < n; i++) {
    section[2 * i] = x[i * s->dim];
    section[2 * i + 1] = x[i * s->dim + s->up];
  }
  OK(sph_initial_dam_break_pressure(context, s->length, s->height, s->gravity, s->density, s->c0, n,
                                    section, pressure));
  example_flow_start(&s->scheme, f, pressure);
  free(x);
}

static void create_flow(const setup *s, example_flow *f) {
  const double lo[3] = {0, 0, 0};
  const double column[3] = {s->length, s->dim == 2 ? s->height : s->width, s->height};
  const double tank[3] = {s->tank, s->dim == 2 ? s->top : s->width, s->top};
  example_flow_open(&s->scheme, s->dim, s->dx, f);
  sph_context *context = f->context;
  OK(sph_particles_fill_box(f->water, lo, column, s->density));
  /* The tank is open above, so high that no splash gets out; the box in 3D has a lid. */
  OK(sph_wall_create_box(context, s->dim, lo, tank, s->dim == 2 ? SPH_SIDE_HI(1) : 0, &f->tank));
  example_flow_solve(&s->scheme, s->c0, f);
  start_from_laplace(s, f);
}

/* Buchner's gauge is a plate of 90 mm centred 0.16 m above the bed of his tank, H = 0.6 m; P1 is its
 * lower edge, 0.19 H, where published computations are compared with it. Other columns get them in
 * proportion. In 3D the plate is a segment across it. Sampled at 0.8 kHz. */
static void create_probes(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const double sample = 0.005 * sqrt(s->height / s->gravity);
  const double middle = 0.16 / 0.6 * s->height, diameter = 0.09 / 0.6 * s->height;
  double point[3] = {s->tank, s->width / 2, 0}, below[3], above[3], foot[3] = {0, s->width / 2, 0};
  const double up[3] = {0, s->dim == 2, s->dim == 3};
  foot[s->up] = 0;
  point[s->up] = middle;
  memcpy(below, point, sizeof below);
  memcpy(above, point, sizeof above);
  below[s->up] -= diameter / 2;
  above[s->up] += diameter / 2;
  sph_integrator *flow = f->integrator;
  if (s->dim == 2)
    OK(sph_probe_create_pressure_disc(flow, point, up, diameter, 9, &f->probes[P1_DISC]));
  else
    OK(sph_probe_create_pressure_average(flow, below, above, 9, &f->probes[P1_DISC]));
  OK(sph_probe_create_pressure(flow, point, &f->probes[P1_POINT]));
  OK(sph_probe_create_pressure(flow, below, &f->probes[P1_EDGE]));
  OK(sph_probe_create_front(flow, 0, 1, &f->probes[FRONT]));
  OK(sph_probe_create_elevation(flow, foot, up, s->top, &f->probes[COLUMN]));
  OK(sph_probe_create_energy(flow, &f->probes[ENERGY]));
  OK(sph_probe_create_mass(flow, &f->probes[MASS]));
  for (int k = 0; k < PROBES; k++) OK(sph_probe_set_interval(f->probes[k], sample));
  for (int k = 0; k < PROBES; k++) OK(sph_probe_sample(f->probes[k]));
  if (s->vtk == 0) return;
  OK(sph_output_create_vtk(context, example_flow_path(f, s->out, "vtk"), "water", &f->vtk));
  OK(sph_output_add_field(f->vtk, SPH_VELOCITY));
  OK(sph_output_add_field(f->vtk, SPH_PRESSURE));
  OK(sph_output_add_field(f->vtk, SPH_DENSITY));
}

/* How far particles are from the mirror image of their partners in y: 3D alone, where the lattice was
 * filled with the last direction running fastest. */
static double asymmetry(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  const int64_t up = (int64_t)(s->height / s->dx + 1e-6),
                across = (int64_t)(s->width / s->dx + 1e-6);
  double *x = example_numbers(3 * n), worst = 0;
  OK(sph_particles_read(f->water, SPH_POSITION, x, 3 * n));
  for (int64_t i = 0; i < n; i++) {
    const int64_t j = i / up % across, partner = i + (across - 1 - 2 * j) * up;
    const double *a = x + 3 * i, *b = x + 3 * partner;
    worst = fmax(worst, fabs(a[0] - b[0]));
    worst = fmax(worst, fabs(a[1] + b[1] - s->width));
    worst = fmax(worst, fabs(a[2] - b[2]));
  }
  free(x);
  return worst / s->dx;
}

/* Paints the air that hangs together with cell `start` (4-connected); returns its number of cells. */
static int64_t flood(bool *air, int columns, int64_t cells, int64_t start, int64_t *stack) {
  int64_t count = 0, waiting = 0;
  if (!air[start]) return 0;
  air[start] = false;
  stack[waiting++] = start;
  for (; waiting > 0; count++) {
    const int64_t c = stack[--waiting];
    const int64_t next[4] = {c % columns > 0 ? c - 1 : c, (c + 1) % columns > 0 ? c + 1 : c,
                             c - columns, c + columns};
    for (int k = 0; k < 4; k++) {
      if (next[k] < 0 || next[k] >= cells || !air[next[k]]) continue;
      air[next[k]] = false;
      stack[waiting++] = next[k];
    }
  }
  return count;
}

/* Area of the largest region of air that water and walls cut off from the air above, 2D alone: what the
 * plunging jet encloses when its tip reaches the water on the bed. Water is each cell of 2 dx with a
 * particle in it, so that a gap below 2 to 4 dx counts as closed. */
static double enclosed_air(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const int columns = (int)(s->tank / (2 * s->dx)), rows = (int)(s->top / (2 * s->dx));
  const double wide = s->tank / columns, high = s->top / rows;
  const int64_t n = sph_particles_count(f->water), cells = (int64_t)columns * rows;
  double *x = example_numbers(2 * n);
  bool *air = example_memory(cells, sizeof *air);
  int64_t *stack = example_memory(cells, sizeof *stack), largest = 0;
  OK(sph_particles_read(f->water, SPH_POSITION, x, 2 * n));
  for (int64_t c = 0; c < cells; c++) air[c] = true;
  for (int64_t i = 0; i < n; i++) {
    const double column = floor(x[2 * i] / wide), row = floor(x[2 * i + 1] / high);
    if (column >= 0 && column < columns && row >= 0 && row < rows)
      air[(int64_t)row * columns + (int64_t)column] = false;
  }
  for (int64_t c = cells - columns; c < cells; c++) flood(air, columns, cells, c, stack);
  for (int64_t c = 0; c < cells; c++) {
    const int64_t region = flood(air, columns, cells, c, stack);
    if (region > largest) largest = region;
  }
  free(stack);
  free(air);
  free(x);
  return (double)largest * wide * high;
}

/* Measures and writes between the steps, which stay as they are. */
static sph_status run(const setup *s, example_flow *f, moments *m) {
  sph_context *context = f->context;
  const double second = sqrt(s->height / s->gravity), end = s->end * second;
  example_progress progress = {0};
  sph_status status = SPH_OK;
  double look = 4 * second;
  int frame = example_frames_before(f, end, s->vtk);
  int picture = example_frames_before(f, end, s->pictures);
  const bool whole = f->from == 0; /* what happens once may have happened */
  for (;;) {
    const double t = sph_integrator_time(f->integrator);
    if (example_frame_due(t, end, s->vtk, frame)) {
      OK(sph_output_write(f->vtk, f->water, t));
      frame++;
    }
    if (example_frame_due(t, end, s->pictures, picture))
      example_picture_write(context, f->water, s->out, picture++, t, s->height, s->gravity,
                            s->density);
    if (whole && s->dim == 3 && isnan(m->asymmetry_early) && t >= second)
      m->asymmetry_early = asymmetry(s, f);
    if (whole && s->dim == 2 && isnan(m->cavity_closes) && t >= look) {
      if (enclosed_air(s, f) > 0.01 * s->height * s->height) m->cavity_closes = t;
      look += 0.02 * second;
    }
    if (t >= end) break;
    status = sph_integrator_step(f->integrator);
    if (status != SPH_OK) break;
    example_flow_checkpoint(f);
    example_progress_show(&progress, f->integrator, end);
  }
  example_progress_end(&progress);
  return status;
}

/* Particles behind the walls, or above the lid that the box has in 3D: an open tank gets its drops back. */
static int64_t count_lost(const setup *s, example_flow *f, int64_t at_start) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  double *x = example_numbers(n * s->dim);
  int64_t lost = at_start - n;
  OK(sph_particles_read(f->water, SPH_POSITION, x, n * s->dim));
  for (int64_t i = 0; i < n; i++) {
    const double *at = x + i * s->dim;
    const bool beside = s->dim == 3 && (at[1] < 0 || at[1] > s->width || at[2] > s->top);
    lost += beside || at[0] < 0 || at[0] > s->tank || at[s->up] < 0;
  }
  free(x);
  return lost;
}

/* The figures; docs/examples.md says what each one is. t* = t sqrt(g/H). */
static void summarise(const setup *s, example_flow *f, const moments *m, example_summary *summary) {
  sph_context *context = f->context;
  const double second = sqrt(s->gravity / s->height);
  const double bar = s->density * s->gravity * s->height;
  example_series front = example_series_read(context, f->probes[FRONT], 0);
  example_series disc = example_series_read(context, f->probes[P1_DISC], 0);
  example_series point = example_series_read(context, f->probes[P1_POINT], 0);
  example_series edge = example_series_read(context, f->probes[P1_EDGE], 0);
  example_series energy = example_series_read(context, f->probes[ENERGY], 3);
  const example_peak first = example_series_peak(&edge, 0, 3 / second, 0.1 / second);
  const example_peak last = example_series_peak(&edge, 5 / second, INFINITY, 0.1 / second);
  double growth = 0, lowest = energy.v[0];
  for (int64_t k = 0; k < energy.n; k++) {
    lowest = fmin(lowest, energy.v[k]);
    growth = fmax(growth, energy.v[k] - lowest);
  }
  example_summary_number(summary, "dx_m", s->dx);
  example_summary_number(summary, "front_arrival_t_star",
                         second * example_series_reach(&front, s->tank - s->dx));
  example_summary_number(summary, "p1_first_peak_t_star", second * first.t);
  example_summary_number(summary, "p1_first_peak_over_rho_g_h", first.v / bar);
  const double plateau = example_series_mean(&edge, 3 / second, 5 / second);
  example_summary_number(summary, "p1_plateau_mean_over_rho_g_h", plateau / bar);
  example_summary_number(summary, "plate_plateau_mean_over_rho_g_h",
                         example_series_mean(&disc, 3 / second, 5 / second) / bar);
  example_summary_number(summary, "plate_centre_plateau_mean_over_rho_g_h",
                         example_series_mean(&point, 3 / second, 5 / second) / bar);
  example_summary_number(summary, "p1_second_peak_t_star", second * last.t);
  example_summary_number(summary, "p1_second_peak_over_rho_g_h", last.v / bar);
  if (s->dim == 2)
    example_summary_number(summary, "cavity_closes_t_star", second * m->cavity_closes);
  example_summary_number(summary, "energy_growth_max_rel", growth / fabs(energy.v[0]));
  example_summary_number(summary, "energy_end_rel", energy.v[energy.n - 1] / energy.v[0]);
  if (s->dim == 3) {
    example_summary_number(summary, "asymmetry_early_max_over_dx", m->asymmetry_early);
    example_summary_number(summary, "asymmetry_end_max_over_dx", asymmetry(s, f));
  }
  free(front.t);
  free(disc.t);
  free(point.t);
  free(edge.t);
  free(energy.t);
}

int main(int argc, char **argv) {
  setup s;
  example_flow f = {0};
  moments m = {NAN, NAN};
  example_summary summary = {0};
  parse(argc, argv, &s);
  create_flow(&s, &f);
  example_flow_resume(&s.checkpoints, s.out, &f);
  create_probes(&s, &f);
  const int64_t particles = sph_particles_count(f.water);
  const double start = example_clock();
  const sph_status status = run(&s, &f, &m);
  const double seconds = example_clock() - start;

  /* A run that stopped still tells what it has measured. */
  summarise(&s, &f, &m, &summary);
  const int64_t lost = count_lost(&s, &f, particles);
  example_summary_integer(&summary, "particles_lost", lost);
  example_summary_flow(&summary, &f, seconds);
  if (*s.out != '\0') example_flow_write_series(&f, s.out, PROBES, files);
  example_summary_write(&summary, s.summary);
  example_check(status, f.context, "sph_integrator_step(flow)");
  example_flow_destroy(&f);
  if (lost > 0) printf("dam_break: %lld particles left the tank\n", (long long)lost);
  if (lost == 0) printf("dam_break: nothing left the tank\n");
  return lost > 0;
}
