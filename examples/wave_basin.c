/* Waves by three methods side by side: particles and a mesh, incompressible and weakly compressible SPH. A standing
 * wave in a basin, a solitary wave of a piston, and one that breaks over a submerged bar.
 *
 * Physics    water of 1000 kg/m^3 without viscosity (delta-SPH: alpha = 0.01), with --method flip under air of
 *            1 kg/m^3 and an open top. flip: triangles of leg l, of which each has the square of --divisions
 *            particles at the start; SPH: particles l/2 apart.
 *            standing: 20 m long, one wave long, d = 5 m, H/d = 0.1, antinode in the middle
 *            solitary: 15 x 0.6 m, d = 0.3 m, H/d = 0.2 or 0.35, 8 s
 *            bar:      13 x 1 m, d = 0.4 m, H/d = 0.625, a bar of 0.25 m between 6 and 11 m, 6.5 s
 * Reference  Maljaars et al. (2017), section 3, whose tables of sizes are lost: see docs/flip.md;
 *            linear theory (standing), Fenton's solitary wave (crest), Rayleigh's (piston, speed)
 * Build      cc -O2 wave_basin.c common/example.c common/flow.c -o wave_basin -lsph -lm
 * Run        ./wave_basin --case solitary --height-ratio 0.35 --out wave.out --vtk 80
 * Expect     last line: "wave_basin: reached the end"
 *
 * TEST: --quick
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/flow.h"

static const double pi = 3.14159265358979323846, gravity = 9.81, water = 1000, air = 1;
enum { GAUGES = 4, MOST_SAMPLES = 4096, POINTS = 41 };

typedef struct setup {
  example_scheme scheme;
  const char *flow, *out, *summary;
  double cell, length, height, depth, height_ratio, end, pic, theta;
  int divisions, vtk, pictures;
  bool global, quick, meshed;
  double gauge[GAUGES];
} setup;

typedef struct run {
  example_flow flow; /* without ghosts where there is a mesh */
  sph_mesh *mesh;
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

static bool is_case(const setup *s, const char *name) { return strcmp(s->flow, name) == 0; }

static void parse(int argc, char **argv, setup *s) {
  *s = (setup){.scheme = EXAMPLE_SCHEME,
               .flow = "standing",
               .out = "",
               .summary = "",
               .divisions = 3,
               .pic = -1,
               .theta = 0.05};
  s->scheme.method = "flip";
  s->scheme.kernel = "wendland-c2";
  s->scheme.h_ratio = 2;
  s->scheme.alpha = 0.01;
  const example_option options[] = {
      OPTION_TEXT("--case", s->flow, "standing, solitary or bar"),
      EXAMPLE_SCHEME_OPTIONS(s->scheme, " (SPH)", " (SPH)"),
      OPTION_NUMBER("--cell", s->cell, 1e-3, 1,
                    "l [m]: legs of triangles, two spacings of SPH; 0: as the case wants"),
      OPTION_INTEGER("--divisions", s->divisions, 1, 5, "flip: squared, particles of a triangle"),
      OPTION_NUMBER("--height-ratio", s->height_ratio, 0.01, 0.79, "height of the wave, H/d"),
      OPTION_NUMBER("--pic", s->pic, -1, 1, "flip: share of PIC; -1: by the step"),
      OPTION_NUMBER("--volume", s->theta, 0, 1, "flip: correction of volumes"),
      OPTION_FLAG("--global", s->global, "flip: smooth grad p / rho everywhere, consistently"),
      OPTION_NUMBER("--end", s->end, 0, 1000, "end [s]; 0: as the case wants"),
      OPTION_TEXT("--out", s->out, "folder for gauges, pictures and VTK; without it none"),
      OPTION_INTEGER("--vtk", s->vtk, 0, 100000, "frames for ParaView; flip: of the mesh"),
      OPTION_INTEGER("--pictures", s->pictures, 0, 1000, "frames as text for gnuplot"),
      OPTION_TEXT("--summary", s->summary, "file for the figures as JSON"),
      OPTION_FLAG("--quick", s->quick, "coarse and short: a test that it runs")};
  example_parse(argc, argv, "waves by three methods", (int)(sizeof options / sizeof options[0]),
                options);
  s->meshed = strcmp(s->scheme.method, "flip") == 0;
  const bool standing = is_case(s, "standing"), over = is_case(s, "bar");
  if (!standing && !over && !is_case(s, "solitary"))
    example_refuse("--case", "\"%s\" is none of standing, solitary, bar", s->flow);
  if (!s->meshed && strcmp(s->scheme.method, "isph") != 0 && strcmp(s->scheme.method, "wcsph") != 0)
    example_refuse("--method", "\"%s\" is none of flip, isph, wcsph", s->scheme.method);
  if (s->meshed && *s->scheme.walls != '\0') example_refuse("--walls", "is for --method isph");
  if ((s->vtk > 0 || s->pictures > 0) && *s->out == '\0')
    example_refuse(s->vtk > 0 ? "--vtk" : "--pictures", "wants a folder, --out");
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

static double bed_at(const setup *s, double x) {
  int k = 1;
  if (!is_case(s, "bar")) return 0;
  while (k < 5 && bar[2 * k] < x) k++;
  const double share = (x - bar[2 * k - 2]) / (bar[2 * k] - bar[2 * k - 2]);
  return bar[2 * k - 1] + share * (bar[2 * k + 1] - bar[2 * k - 1]);
}

static double surface(const double *x, void *user) {
  const setup *s = user;
  if (!is_case(s, "standing")) return s->depth;
  return s->depth + 0.5 * s->height_ratio * s->depth * cos(2 * pi / s->length * x[0]);
}

static void create_paddle(const setup *s, run *r) {
  sph_context *context = r->flow.context;
  OK(sph_wave_create_solitary(context, SPH_SOLITARY_RAYLEIGH, s->height_ratio * s->depth, s->depth,
                              gravity, &r->wave));
  OK(sph_paddle_create_solitary(context, r->wave, 0, &r->paddle));
}

/* ---- particles and a mesh ---- */

static void create_meshed(setup *s, run *r) {
  example_flow *f = &r->flow;
  if (sph_context_create(&f->context) != SPH_OK) exit(1);
  sph_context *context = f->context;
  OK(sph_context_set_threads(context, example_threads(s->scheme.threads)));
  const int columns = (int)lround(s->length / s->cell), rows = (int)lround(s->height / s->cell);
  const double level[] = {0, 0, 15, 0};
  if (is_case(s, "bar"))
    OK(sph_mesh_create_flume_polyline(context, 6, bar, s->height, columns, rows, &r->mesh));
  else if (is_case(s, "solitary"))
    OK(sph_mesh_create_flume_polyline(context, 2, level, s->height, columns, rows, &r->mesh));
  else
    OK(sph_mesh_create_flume(context, 0, s->length, s->height, columns, rows, NULL, NULL,
                             &r->mesh));
  OK(sph_particles_create(context, 2, s->cell / s->divisions / sqrt(2), &f->water));
  OK(sph_flip_fill(r->mesh, f->water, s->divisions, surface, s, water, air));
  OK(sph_flip_create(context, r->mesh, f->water, &f->integrator));
  OK(sph_flip_set_densities(f->integrator, air, water));
  OK(sph_flip_set_pic_share(f->integrator, s->pic));
  OK(sph_flip_set_volume_correction(f->integrator, s->theta));
  if (s->global) OK(sph_flip_set_smoothing(f->integrator, SPH_FLIP_SMOOTHING_GLOBAL, false));
  if (s->scheme.dt > 0) OK(sph_integrator_set_dt(f->integrator, s->scheme.dt));
  if (is_case(s, "standing")) return;
  create_paddle(s, r);
  OK(sph_flip_set_paddle(f->integrator, sph_paddle_motion, r->paddle,
                         is_case(s, "bar") ? 5.5 : s->length));
}

/* ---- SPH ---- */

/* Columns from the bed to the surface, their rows evenly stretched. */
static void fill(setup *s, example_flow *f) {
  sph_context *context = f->context;
  const double dx = sph_particles_spacing(f->water);
  const int columns = (int)lround(s->length / dx), most = (int)(s->height / dx) + 1;
  double *x = example_numbers(2 * (int64_t)columns * most);
  double *volume = example_numbers((int64_t)columns * most);
  int64_t n = 0;
  for (int i = 0; i < columns; i++) {
    const double at = (i + 0.5) * s->length / columns, low = bed_at(s, at);
    const double high = surface(&at, s) - low;
    const int rows = (int)lround(high / dx);
    for (int j = 0; j < rows; j++, n++) {
      x[2 * n] = at;
      x[2 * n + 1] = low + (j + 0.5) * high / rows;
      volume[n] = s->length / columns * high / rows;
    }
  }
  OK(sph_particles_add(f->water, n, x, water, NULL));
  OK(sph_particles_write(f->water, SPH_VOLUME, volume, n));
  free(x);
  free(volume);
}

/* Bed and right side, and a left side of its own that may be the piston. Walls reach past each other, so that
 * the corner is filled wherever the piston is. */
static void create_walls(const setup *s, run *r) {
  example_flow *f = &r->flow;
  sph_context *context = f->context;
  const double past = sph_kernel_get_support(f->kernel) + 2 * sph_particles_spacing(f->water);
  const double top = 2 * s->height, left[] = {0, top, 0, -past};
  double bed[2 * 7] = {0, 0, s->length, 0};
  const int corners = is_case(s, "bar") ? 6 : 2;
  if (corners == 6) memcpy(bed, bar, sizeof bar);
  bed[0] = -past - s->depth;
  bed[2 * corners] = s->length;
  bed[2 * corners + 1] = top;
  OK(sph_wall_create_polyline(context, corners + 1, bed, false, &f->tank));
  OK(sph_wall_create_polyline(context, 2, left, false, &f->more[0]));
  if (r->paddle) OK(sph_wall_set_motion(f->more[0], sph_paddle_motion, r->paddle));
}

/* Of linear theory at the top of the swing, hydrostatic without a wave. */
static void start(setup *s, run *r) {
  example_flow *f = &r->flow;
  const int64_t n = sph_particles_count(f->water);
  const double k = 2 * pi / s->length;
  double *x = example_flow_read(f, SPH_POSITION, 2), *p = example_numbers(n);
  for (int64_t i = 0; i < n; i++) {
    const double eta = surface(x + 2 * i, s) - s->depth, z = fmin(x[2 * i + 1], s->depth);
    p[i] = fmax(
        0, water * gravity * (s->depth - x[2 * i + 1] + eta * cosh(k * z) / cosh(k * s->depth)));
  }
  example_flow_start(&s->scheme, f, p);
  free(x);
  free(p);
}

static void create_sph(setup *s, run *r) {
  example_flow *f = &r->flow;
  example_flow_open(&s->scheme, 2, 0.5 * s->cell, f);
  if (!is_case(s, "standing")) create_paddle(s, r);
  fill(s, f);
  create_walls(s, r);
  example_flow_solve(&s->scheme,
                     s->scheme.c0_factor * sqrt(gravity * s->depth * (1 + s->height_ratio)), f);
  start(s, r);
}

/* ---- what is measured ---- */

typedef struct water_view {
  int64_t n;
  double *x, *v, *m, *rho;
} water_view;

static water_view look(const run *r) {
  const example_flow *f = &r->flow;
  return (water_view){sph_particles_count(f->water), example_flow_read(f, SPH_POSITION, 2),
                      example_flow_read(f, SPH_VELOCITY, 2), example_flow_read(f, SPH_MASS, 1),
                      example_flow_read(f, SPH_DENSITY, 1)};
}

static void look_away(water_view *view) {
  free(view->x);
  free(view->v);
  free(view->m);
  free(view->rho);
}

/* How much a particle counts for the level at a distance: a bell whose integral is 1, wide enough for columns of
 * particles that come and go not to show. */
static double bell(const setup *s, double away) {
  const double reach = 4 * s->cell, q2 = away * away / (reach * reach);
  return q2 < 1 ? 15 / (16 * reach) * (1 - q2) * (1 - q2) : 0;
}

/* Levels, the surface's part in cos(2 pi x/length), which is the
 * standing wave, and the water's kinetic energy. All are sums over particles, finer than a cell. */
static void sample(const setup *s, run *r) {
  if (r->samples == MOST_SAMPLES) return;
  water_view w = look(r);
  double volume[GAUGES] = {0}, mode = 0, kinetic = 0;
  for (int64_t i = 0; i < w.n; i++) {
    if (w.rho[i] < 0.5 * water) continue;
    for (int k = 0; k < GAUGES; k++)
      volume[k] += w.m[i] / water * bell(s, w.x[2 * i] - s->gauge[k]);
    mode += w.m[i] * cos(2 * pi / s->length * w.x[2 * i]);
    kinetic += 0.5 * w.m[i] * (w.v[2 * i] * w.v[2 * i] + w.v[2 * i + 1] * w.v[2 * i + 1]);
  }
  look_away(&w);
  for (int k = 0; k < GAUGES; k++) r->level[k][r->samples] = bed_at(s, s->gauge[k]) + volume[k];
  r->mode[r->samples] = 2 * mode / (water * s->length);
  r->kinetic[r->samples] = kinetic;
  r->t[r->samples++] = sph_integrator_time(r->flow.integrator);
}

/* Where the crest is now and how high: of the parabola through the highest level and those two cells beside
 * it. */
static void find_crest(const setup *s, const run *r, double *place, double *height) {
  const int points = (int)(s->length / s->cell) + 1, apart = 2;
  double *level = example_numbers(points);
  water_view w = look(r);
  for (int64_t i = 0; i < w.n; i++) {
    const int at = (int)(w.x[2 * i] / s->cell);
    for (int k = at - 4; k <= at + 5 && w.rho[i] > 0.5 * water; k++)
      if (k >= 0 && k < points) level[k] += w.m[i] / water * bell(s, w.x[2 * i] - k * s->cell);
  }
  look_away(&w);
  int best = 4;
  for (int k = 4; k + 4 < points; k++)
    if (level[k] > level[best]) best = k;
  const double left = level[best - apart], right = level[best + apart];
  const double slope = 0.5 * (right - left), bend = right + left - 2 * level[best];
  const double off = bend < 0 ? fmin(fmax(-slope / bend, -1), 1) : 0;
  *place = (best + apart * off) * s->cell;
  *height = level[best] + off * (slope + 0.5 * bend * off) - s->depth;
  free(level);
}

static void write_frame(const run *r) {
  sph_context *context = r->flow.context;
  const double time = sph_integrator_time(r->flow.integrator);
  if (!r->mesh) {
    OK(sph_output_write(r->flow.vtk, r->flow.water, time));
    return;
  }
  const int64_t nodes = sph_mesh_node_count(r->mesh), cells = sph_mesh_cell_count(r->mesh);
  double *pressure = example_numbers(nodes), *rho = example_numbers(cells);
  double *velocity = example_numbers(2 * cells);
  OK(sph_flip_read_pressure(r->flow.integrator, pressure, nodes));
  OK(sph_flip_read_cells(r->flow.integrator, rho, velocity, cells));
  const sph_mesh_field at_nodes = {"pressure", "Pa", 1, pressure};
  const sph_mesh_field of_cells[] = {{"density", "kg/m^3", 1, rho},
                                     {"velocity", "m/s", 2, velocity}};
  OK(sph_output_write_mesh(r->flow.vtk, r->mesh, 1, &at_nodes, 2, of_cells, time));
  free(pressure);
  free(rho);
  free(velocity);
}

/* The water's particles as text: place and speed. */
static void write_picture(const setup *s, const run *r, int number) {
  char name[32];
  snprintf(name, sizeof name, "picture_%03d.txt", number);
  FILE *file = fopen(example_path(s->out, name), "w");
  if (!file) example_refuse("--out", "\"%s\": a file cannot be written there", s->out);
  water_view w = look(r);
  fprintf(file, "# t_s %.6g spacing_m %.6g\n# x_m y_m speed_m_per_s\n",
          sph_integrator_time(r->flow.integrator), sph_particles_spacing(r->flow.water));
  for (int64_t i = 0; i < w.n; i++)
    if (w.rho[i] > 0.5 * water)
      fprintf(file, "%.5g %.5g %.4g\n", w.x[2 * i], w.x[2 * i + 1],
              hypot(w.v[2 * i], w.v[2 * i + 1]));
  look_away(&w);
  if (fclose(file) != 0) example_refuse("--out", "\"%s\": the disk is full", s->out);
}

/* Pressures from bed to surface in the middle now, beside linear theory: (18) of Maljaars et al. (2017). */
static double pressure_error(const setup *s, run *r) {
  sph_context *context = r->flow.context;
  const double k = 2 * pi / s->length, omega = sqrt(gravity * k * tanh(k * s->depth));
  const double a = 0.5 * s->height_ratio * s->depth;
  const double t = sph_integrator_time(r->flow.integrator);
  double x[2 * POINTS], p[POINTS], most = 0;
  for (int i = 0; i < POINTS; i++) {
    x[2 * i] = 0.5 * s->length;
    x[2 * i + 1] = (s->depth - 2 * a) * i / (POINTS - 1);
  }
  if (s->meshed) {
    OK(sph_flip_evaluate(r->flow.integrator, POINTS, x, p, NULL));
  } else {
    const char *const field = SPH_PRESSURE;
    sph_interpolator *fit;
    OK(sph_interpolator_create(context, SPH_INTERPOLATOR_MLS_LINEAR, r->flow.kernel, &fit));
    OK(sph_interpolator_evaluate(fit, r->flow.water, POINTS, x, 1, &field, p, NULL));
    sph_interpolator_destroy(&fit);
  }
  for (int i = 0; i < POINTS; i++) {
    const double z = x[2 * i + 1];
    const double wave = -a * cosh(k * z) / cosh(k * s->depth) * cos(omega * t);
    const double above = s->meshed ? air * gravity * (s->height - s->depth) : 0;
    most = fmax(most, fabs(p[i] - water * gravity * (s->depth - z + wave) - above));
  }
  return most / (water * gravity * s->depth);
}

/* To the end; the processor's seconds that it took the library. */
static double advance(const setup *s, run *r) {
  const sph_context *context = r->flow.context;
  example_progress progress = {.start = example_clock()};
  const int count = s->quick ? 36 : 900, every = s->vtk > 0 ? (count + s->vtk - 1) / s->vtk : count;
  int picture = 0;
  double seconds = 0;
  if (s->vtk > 0)
    OK(sph_output_create_vtk(r->flow.context, example_path(s->out, "vtk"),
                             s->meshed ? "mesh" : "water", &r->flow.vtk));
  for (int k = 0; k <= count; k++) {
    const double t = s->end * k / count;
    const clock_t begin = clock();
    if (k > 0) OK(sph_integrator_advance(r->flow.integrator, t));
    seconds += (double)(clock() - begin) / CLOCKS_PER_SEC;
    sample(s, r);
    for (int half = 1; half <= 2; half++)
      if (fabs(t - 0.5 * half * period_of(s)) < 1e-9)
        r->pressure_error[half - 1] = pressure_error(s, r);
    if (s->vtk > 0 && k > 0 && k % every == 0) write_frame(r);
    if (example_frame_due(t, s->end, s->pictures, picture)) write_picture(s, r, picture++);
    example_progress_show(&progress, r->flow.integrator, s->end);
  }
  example_progress_end(&progress);
  return seconds;
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
  if (is_case(s, "bar")) return;
  /* The wave passes the piston's middle in the middle of its stroke. */
  sph_context *context = r->flow.context;
  sph_wave *fenton;
  double place = NAN, height = NAN;
  OK(sph_wave_create_solitary(context, SPH_SOLITARY_FENTON, H, s->depth, gravity, &fenton));
  const double middle = 0.5 * (sph_paddle_start(r->paddle) + sph_paddle_end(r->paddle));
  const double expected =
      0.5 * sph_paddle_stroke(r->paddle) + sph_wave_celerity(fenton) * (s->end - middle);
  sph_wave_destroy(&fenton);
  find_crest(s, r, &place, &height);
  example_summary_number(summary, "crest_over_h", height / H);
  example_summary_number(summary, "crest_behind_theory_over_d", (expected - place) / s->depth);
}

static void summarise_mesh(const run *r, example_summary *summary) {
  const sph_context *context = r->flow.context;
  sph_integrator_stats stats;
  sph_flip_stats flip;
  sph_solver_stats solver;
  sph_solver *of;
  OK(sph_integrator_get_stats(r->flow.integrator, &stats));
  OK(sph_flip_get_stats(r->flow.integrator, &flip));
  OK(sph_flip_get_solver(r->flow.integrator, &of));
  OK(sph_solver_get_stats(of, &solver));
  example_summary_integer(summary, "cells", sph_mesh_cell_count(r->mesh));
  example_summary_integer(summary, "particles", sph_particles_count(r->flow.water));
  example_summary_integer(summary, "steps", stats.steps);
  example_summary_number(summary, "iterations_a_step",
                         (double)solver.total_iterations / (double)solver.solves);
  example_summary_number(summary, "solver_seconds", stats.seconds_solver);
  example_summary_number(summary, "particle_seconds", stats.seconds_update);
  example_summary_number(summary, "sort_and_mean_seconds", stats.seconds_sort + stats.seconds_pack);
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
  if (s.meshed)
    create_meshed(&s, &r);
  else
    create_sph(&s, &r);
  example_summary summary = {0};
  example_summary_text(&summary, "case", s.flow);
  example_summary_text(&summary, "method", s.scheme.method);
  example_summary_number(&summary, "cell_m", s.cell);
  const double seconds = advance(&s, &r);
  if (is_case(&s, "standing") && !s.quick) summarise_standing(&s, &r, &summary);
  if (!is_case(&s, "standing") && !s.quick) summarise_solitary(&s, &r, &summary);
  example_summary_number(&summary, "processor_seconds", seconds);
  example_summary_number(&summary, "peak_memory_mb", example_peak_memory());
  if (s.meshed)
    summarise_mesh(&r, &summary);
  else
    example_summary_flow(&summary, &r.flow, seconds);
  if (*s.out) write_gauges(&s, &r);
  example_summary_write(&summary, s.summary);
  example_flow_destroy(&r.flow);
  sph_paddle_destroy(&r.paddle);
  sph_wave_destroy(&r.wave);
  sph_mesh_destroy(&r.mesh);
  printf("wave_basin: reached the end\n");
  return 0;
}
