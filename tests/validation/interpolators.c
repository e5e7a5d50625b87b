/* What each interpolator is worth behind a wall: errors, costs, water at rest, pressures under impact.
 *
 *   interpolators consistency | cost | rest | impact [--quick]
 *   interpolators plain KIND DX FOLDER
 *   interpolators corner X_OVER_H PICTURE ...
 *
 * Every command prints lines of tab-separated figures; interpolators.sh makes the page of them.
 */
#include <math.h>
#include <sph.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define OK(call) check((call), context, #call)
#define KINDS_MOST 32

static const double pi = 3.14159265358979323846, gravity = 9.81, density = 1000;
static bool quick;

/* ------------------------------------------------------------------------------------- helpers */

static void check(sph_status status, const sph_context *context, const char *call) {
  if (status == SPH_OK) return;
  fprintf(stderr, "%s: %s\n", call, sph_context_message(context));
  exit(1);
}

static double *numbers(int64_t n) {
  double *all = calloc((size_t)n + 1, sizeof *all);
  if (all) return all;
  fputs("interpolators: no memory\n", stderr);
  exit(1);
}

static double now(void) {
  struct timespec t;
  timespec_get(&t, TIME_UTC);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* A number in [-1/2, 1/2) from a counter: the same on every machine. */
static double noise(uint64_t k) {
  k += 0x9e3779b97f4a7c15u;
  k = (k ^ (k >> 30)) * 0xbf58476d1ce4e5b9u;
  k = (k ^ (k >> 27)) * 0x94d049bb133111ebu;
  k ^= k >> 31;
  return (double)(k >> 11) * 0x1p-53 - 0.5;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Sorted values: the one that a share of them does not exceed. */
static double quantile(const double *sorted, int64_t count, double share) {
  return count > 0 ? sorted[(int64_t)(share * (double)(count - 1) + 0.5)] : NAN;
}

static double median(double *values, int64_t count) {
  if (count == 0) return NAN;
  qsort(values, (size_t)count, sizeof *values, ascending);
  return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

/* Kinds with a formula of their own: all but the caller's. */
static int kinds(sph_interpolator_type *list) {
  int count = 0;
  for (int k = 0; k < sph_interpolator_count() && count < KINDS_MOST; k++)
    if (sph_interpolator_at(k) != SPH_INTERPOLATOR_USER) list[count++] = sph_interpolator_at(k);
  return count;
}

static sph_context *new_context(int threads) {
  sph_context *context = NULL;
  check(sph_context_create(&context), context, "context");
  OK(sph_context_set_threads(context, threads));
  return context;
}

/* --------------------------------------------------------------------------------- consistency */

/* Still water 0.3 m deep under a standing wave of amplitude 0.03 m and length 1 m. */
static const double depth = 0.3, amplitude = 0.03;

static double wave_pressure(int dim, const double *x) {
  const double k = 2 * pi, kappa = dim == 2 ? k : sqrt(2) * k, y = x[dim - 1];
  const double shape = dim == 2 ? cos(k * x[0]) : cos(k * x[0]) * cos(k * x[1]);
  return density * gravity *
         (depth - y + amplitude * cosh(kappa * y) / cosh(kappa * depth) * shape);
}

/* Moves every particle off its lattice point, evenly within a square of side jitter dx, and gives it
 * the pressure of the wave. */
static void jitter_particles(sph_context *context, sph_particles *set, const double *lattice,
                             double jitter, uint64_t seed) {
  const int dim = sph_particles_dim(set);
  const int64_t n = sph_particles_count(set);
  double *x = numbers(n * dim), *p = numbers(n);
  for (int64_t k = 0; k < n * dim; k++)
    x[k] = lattice[k] +
           jitter * sph_particles_spacing(set) * noise(seed * 0x100000001b3u + (uint64_t)k);
  for (int64_t i = 0; i < n; i++) p[i] = wave_pressure(dim, x + i * dim);
  OK(sph_particles_write(set, SPH_POSITION, x, n * dim));
  OK(sph_particles_write(set, SPH_PRESSURE, p, n));
  free(x);
  free(p);
}

/* Errors at points in groups: sums of squares, and points that another kind had to answer for. */
enum { WALL, CORNER, SURFACE, ABOVE, GROUPS, PLACES = 6, WALL_COLUMNS = 80, LAYERS = 3 };
enum { ROOM = LAYERS * (WALL_COLUMNS + 2 * LAYERS + 1) };
typedef struct errors {
  double square[GROUPS];
  int64_t shifted[GROUPS];
} errors;

/* Without groups all points are the wall's. */
static void add_errors(sph_context *context, const sph_interpolator *interpolator,
                       const sph_particles *set, int64_t points, const double *at, bool compensated,
                       const int *group, errors *sum) {
  const int dim = sph_particles_dim(set);
  const char *const names[] = {SPH_PRESSURE};
  double gradient[3] = {0, 0, 0}, values[ROOM];
  int rungs[ROOM];
  gradient[dim - 1] = -density * gravity;
  if (compensated)
    OK(sph_interpolator_evaluate_compensated(interpolator, set, points, at, SPH_PRESSURE, gradient,
                                             values, rungs));
  else
    OK(sph_interpolator_evaluate(interpolator, set, points, at, 1, names, values, rungs));
  for (int64_t k = 0; k < points; k++) {
    const double error = values[k] - wave_pressure(dim, at + k * dim);
    sum->square[group ? group[k] : WALL] += error * error;
    sum->shifted[group ? group[k] : WALL] += rungs[k] != sph_interpolator_get_type(interpolator);
  }
}

/* Mirror points of three layers of ghosts: behind the bed, behind a corner, and behind a side wall where
 * the water ends, below and above the surface. */
static int64_t mirror_points(double dx, double *at, int *group, int64_t *count) {
  int64_t n = 0;
  for (int layer = 0; layer < LAYERS; layer++) {
    const double off = (layer + 0.5) * dx;
    for (int i = 0; i < WALL_COLUMNS; i++, n++) {
      at[2 * n] = (i + 10.5) * dx;
      at[2 * n + 1] = off;
      group[n] = WALL;
    }
    for (int row = 0; row < LAYERS; row++, n++) {
      at[2 * n] = off;
      at[2 * n + 1] = (row + 0.5) * dx;
      group[n] = CORNER;
    }
    for (int row = -LAYERS; row <= 0; row++, n++) {
      at[2 * n] = off;
      at[2 * n + 1] = depth + (row + 0.5) * dx;
      group[n] = row < 0 ? SURFACE : ABOVE;
    }
  }
  for (int64_t k = 0; k < n; k++) count[group[k]]++;
  return n;
}

/* rms errors / (rho g dx) at dx = 0.01 m by kind, compensation and place: the wall on the lattice, with
 * jitter 0.2 and 0.6, the corner, below and above the surface with 0.2. shift: share of the points of the
 * wall with jitter 0.6 and above the surface that went down the ladder. */
static void measure_places(sph_context *context, int count, sph_interpolator *const *all,
                           double error[KINDS_MOST][2][PLACES], double shift[KINDS_MOST][2]) {
  const double dx = 0.01, jitters[] = {0, 0.2, 0.6}, lo[] = {0, 0}, hi[] = {1, depth};
  const int seeds = quick ? 4 : 40;
  double at[2 * ROOM];
  int group[ROOM];
  int64_t points[GROUPS] = {0};
  const int64_t n = mirror_points(dx, at, group, points);
  sph_particles *set;
  OK(sph_particles_create(context, 2, dx, &set));
  OK(sph_particles_fill_box(set, lo, hi, density));
  const int64_t particles = sph_particles_count(set);
  double *lattice = numbers(2 * particles);
  OK(sph_particles_read(set, SPH_POSITION, lattice, 2 * particles));
  for (int j = 0; j < 3; j++) {
    errors sum[KINDS_MOST][2] = {{{{0}, {0}}}};
    const int repeats = j == 0 ? 1 : seeds;
    for (int seed = 0; seed < repeats; seed++) {
      jitter_particles(context, set, lattice, jitters[j], (uint64_t)seed + 1);
      for (int k = 0; k < count; k++)
        for (int c = 0; c < 2; c++) add_errors(context, all[k], set, n, at, c, group, &sum[k][c]);
    }
    for (int k = 0; k < count; k++)
      for (int c = 0; c < 2; c++)
        for (int g = 0; g < GROUPS; g++)
          if (g == WALL || j == 1)
            error[k][c][g == WALL ? j : 2 + g] =
                sqrt(sum[k][c].square[g] / (double)(repeats * points[g])) /
                (density * gravity * dx);
    for (int k = 0; k < count && j > 0; k++)
      shift[k][j == 1] = (double)sum[k][0].shifted[j == 1 ? ABOVE : WALL] /
                         (double)(repeats * points[j == 1 ? ABOVE : WALL]);
  }
  free(lattice);
  sph_particles_destroy(&set);
}

/* rms error / (rho g d) near the bed at one spacing, on particles with jitter 0.2: patches of the bed at
 * random places, large enough for the support of the points in their middle. */
static void measure_spacing(sph_context *context, int dim, double dx, int count,
                            const sph_interpolator_type *list, double error[KINDS_MOST][2]) {
  enum { WIDE = 16, HIGH = 8, MIDDLE = 6 };
  const int patches = quick ? 4 : 32;
  double at[3 * LAYERS * MIDDLE * MIDDLE];
  errors sum[KINDS_MOST][2] = {{{{0}, {0}}}};
  sph_interpolator *all[KINDS_MOST];
  sph_kernel *kernel;
  OK(sph_kernel_create(context, SPH_KERNEL_GAUSSIAN, dim, 1.3 * dx, &kernel));
  for (int k = 0; k < count; k++) OK(sph_interpolator_create(context, list[k], kernel, &all[k]));
  int64_t n = 0;
  for (int patch = 0; patch < patches; patch++) {
    double lo[3] = {0, 0, 0}, hi[3];
    for (int d = 0; d < dim - 1; d++) lo[d] = 0.5 + noise((uint64_t)(1000 + 2 * patch + d));
    for (int d = 0; d < dim; d++) hi[d] = lo[d] + (d == dim - 1 ? HIGH : WIDE) * dx;
    sph_particles *set;
    OK(sph_particles_create(context, dim, dx, &set));
    OK(sph_particles_fill_box(set, lo, hi, density));
    const int64_t particles = sph_particles_count(set);
    double *lattice = numbers(dim * particles);
    OK(sph_particles_read(set, SPH_POSITION, lattice, dim * particles));
    jitter_particles(context, set, lattice, 0.2, (uint64_t)patch + 1);
    n = 0;
    for (int layer = 0; layer < LAYERS; layer++)
      for (int j = 0; j < (dim == 2 ? 1 : MIDDLE); j++)
        for (int i = 0; i < MIDDLE; i++, n++) {
          at[n * dim] = lo[0] + ((WIDE - MIDDLE) / 2 + i + 0.5) * dx;
          at[n * dim + 1] = lo[1] + ((WIDE - MIDDLE) / 2 + j + 0.5) * dx;
          at[n * dim + dim - 1] = (layer + 0.5) * dx;
        }
    for (int k = 0; k < count; k++)
      for (int c = 0; c < 2; c++) add_errors(context, all[k], set, n, at, c, NULL, &sum[k][c]);
    free(lattice);
    sph_particles_destroy(&set);
  }
  for (int k = 0; k < count; k++)
    for (int c = 0; c < 2; c++)
      error[k][c] =
          sqrt(sum[k][c].square[WALL] / (double)(n * patches)) / (density * gravity * depth);
  for (int k = 0; k < count; k++) sph_interpolator_destroy(&all[k]);
  sph_kernel_destroy(&kernel);
}

/* Lines: kind, compensated, six errors, order in 2D and 3D, two shares of points off their kind. */
static void consistency(void) {
  sph_context *context = new_context(1);
  sph_interpolator_type list[KINDS_MOST];
  const int count = kinds(list);
  static double error[KINDS_MOST][2][PLACES], coarse[KINDS_MOST][2], fine[KINDS_MOST][2];
  static double shift[KINDS_MOST][2];
  double order[KINDS_MOST][2][2];
  sph_interpolator *all[KINDS_MOST];
  sph_kernel *kernel;
  OK(sph_kernel_create(context, SPH_KERNEL_GAUSSIAN, 2, 0.013, &kernel));
  for (int k = 0; k < count; k++) OK(sph_interpolator_create(context, list[k], kernel, &all[k]));
  measure_places(context, count, all, error, shift);
  for (int dim = 2; dim <= 3; dim++) {
    measure_spacing(context, dim, 0.02, count, list, coarse);
    measure_spacing(context, dim, 0.0025, count, list, fine);
    for (int k = 0; k < count; k++)
      for (int c = 0; c < 2; c++) order[k][c][dim - 2] = log2(coarse[k][c] / fine[k][c]) / 3;
  }
  for (int k = 0; k < count; k++)
    for (int c = 0; c < 2; c++) {
      printf("%s\t%d", sph_interpolator_name(list[k]), c);
      for (int place = 0; place < PLACES; place++) printf("\t%.3g", error[k][c][place]);
      printf("\t%.2f\t%.2f", order[k][c][0], order[k][c][1]);
      printf("\t%.4f\t%.4f\n", shift[k][0], shift[k][1]);
    }
  for (int k = 0; k < count; k++) sph_interpolator_destroy(&all[k]);
  sph_kernel_destroy(&kernel);
  sph_context_destroy(&context);
}

/* --------------------------------------------------------------------------------------- flows */

/* A column of water in the corner of a tank, at rest where it fills the tank. */
typedef struct flow_case {
  const char *name;
  int dim;
  sph_kernel_type kernel;
  double spacing, h_factor, length, height, width, tank, top, c0_factor;
  bool lid;
} flow_case;

typedef struct state {
  int64_t n;
  double *x, *v, *rho, *m;
} state;

typedef struct flow {
  const flow_case *of;
  sph_context *context;
  sph_kernel *kernel;
  sph_particles *water;
  sph_wall *wall;
  sph_interpolator *interpolator;
  sph_boundary *ghosts;
  sph_integrator *integrator;
} flow;

static flow_case plane_dam_break(double dx) {
  return (flow_case){.name = "2d",
                     .dim = 2,
                     .kernel = SPH_KERNEL_GAUSSIAN,
                     .spacing = dx,
                     .h_factor = 1.3,
                     .length = 1.2,
                     .height = 0.6,
                     .tank = 3.2196,
                     .top = 4.8,
                     .c0_factor = 20};
}

/* Laplace's pressure in the column, that of water at rest where it fills the tank. */
static void start(flow *f) {
  sph_context *context = f->context;
  const flow_case *of = f->of;
  const int dim = of->dim;
  const int64_t n = sph_particles_count(f->water);
  const double c0 = of->c0_factor * sqrt(gravity * of->height);
  double *x = numbers(n * dim), *section = numbers(2 * n), *p = numbers(n);
  OK(sph_particles_read(f->water, SPH_POSITION, x, n * dim));
  for (int64_t i = 0; i < n; i++) {
    section[2 * i] = x[i * dim];
    section[2 * i + 1] = p[i] = x[i * dim + dim - 1];
  }
  if (of->length < of->tank)
    OK(sph_initial_dam_break_pressure(context, of->length, of->height, gravity, density, c0, n,
                                      section, p));
  else
    OK(sph_initial_hydrostatic(context, of->height, gravity, density, c0, n, p, p));
  OK(sph_wcsph_start_from_pressure(f->integrator, n, p));
  free(x);
  free(section);
  free(p);
}

/* A flow at its start, or where `from` is. */
static void open_flow(flow *f, const flow_case *of, sph_interpolator_type type, bool compensation,
                      int threads, const state *from) {
  memset(f, 0, sizeof *f);
  f->of = of;
  sph_context *context = f->context = new_context(threads);
  const int dim = of->dim;
  const double lo[3] = {0, 0, 0},
               column[3] = {of->length, dim == 2 ? of->height : of->width, of->height};
  const double tank[3] = {of->tank, dim == 2 ? of->top : of->width, of->top};
  OK(sph_kernel_create(context, of->kernel, dim, of->h_factor * of->spacing, &f->kernel));
  OK(sph_particles_create(context, dim, of->spacing, &f->water));
  OK(sph_particles_fill_box(f->water, lo, column, density));
  OK(sph_wall_create_box(context, dim, lo, tank, of->lid ? 0 : SPH_SIDE_HI(dim - 1), &f->wall));
  OK(sph_interpolator_create(context, type, f->kernel, &f->interpolator));
  OK(sph_interpolator_set_compensation(f->interpolator, compensation));
  OK(sph_boundary_create(context, f->wall, of->spacing, f->interpolator, &f->ghosts));
  OK(sph_wcsph_create(context, f->kernel, f->water, f->ghosts, &f->integrator));
  OK(sph_wcsph_set_sound_speed(f->integrator, of->c0_factor * sqrt(gravity * of->height)));
  if (!from) {
    start(f);
    return;
  }
  OK(sph_particles_write(f->water, SPH_POSITION, from->x, from->n * dim));
  OK(sph_particles_write(f->water, SPH_VELOCITY, from->v, from->n * dim));
  OK(sph_particles_write(f->water, SPH_DENSITY, from->rho, from->n));
  OK(sph_particles_write(f->water, SPH_MASS, from->m, from->n));
}

static void close_flow(flow *f) {
  sph_integrator_destroy(&f->integrator);
  sph_boundary_destroy(&f->ghosts);
  sph_interpolator_destroy(&f->interpolator);
  sph_wall_destroy(&f->wall);
  sph_particles_destroy(&f->water);
  sph_kernel_destroy(&f->kernel);
  sph_context_destroy(&f->context);
}

static state read_state(const flow *f) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water), vector = n * f->of->dim;
  state s = {n, numbers(vector), numbers(vector), numbers(n), numbers(n)};
  OK(sph_particles_read(f->water, SPH_POSITION, s.x, vector));
  OK(sph_particles_read(f->water, SPH_VELOCITY, s.v, vector));
  OK(sph_particles_read(f->water, SPH_DENSITY, s.rho, n));
  OK(sph_particles_read(f->water, SPH_MASS, s.m, n));
  return s;
}

static void free_state(state *s) {
  free(s->x);
  free(s->v);
  free(s->rho);
  free(s->m);
  memset(s, 0, sizeof *s);
}

/* ---------------------------------------------------------------------------------------- cost */

/* What is not the boundary's is the same work for every kind: it serves as the clock, so that a processor
 * which slows down for a while does no harm. */
enum { REPEATS_MOST = 15 };
typedef struct timing {
  double part[REPEATS_MOST]; /* boundary / what is not the boundary's */
  double evaluations;        /* a step */
  sph_boundary_counts counts;
} timing;

/* Measures some steps; returns what is not the boundary's, s a step. */
static double time_flow(const flow_case *of, sph_interpolator_type type, const state *from,
                        int warm, int steps, timing *t, int repeat) {
  flow f;
  sph_integrator_stats before, after;
  open_flow(&f, of, type, true, 1, from);
  sph_context *context = f.context;
  for (int k = 0; k < warm; k++) OK(sph_integrator_step(f.integrator));
  OK(sph_integrator_get_stats(f.integrator, &before));
  const double begin = now();
  for (int k = 0; k < steps; k++) OK(sph_integrator_step(f.integrator));
  const double all = now() - begin;
  OK(sph_integrator_get_stats(f.integrator, &after));
  OK(sph_boundary_get_counts(f.ghosts, &t->counts));
  const double boundary = after.seconds_boundary - before.seconds_boundary;
  t->part[repeat] = boundary / (all - boundary);
  t->evaluations = (double)(after.evaluations - before.evaluations) / steps;
  close_flow(&f);
  return (all - boundary) / steps;
}

/* Lines: case, kind, ms a step, ms in the boundary, share of the step, ns a ghost and evaluation, active
 * ghosts, those of them on a fall-back, particles. */
static void time_case(const flow_case *of, int warm, int steps) {
  static timing times[KINDS_MOST];
  static double rest_of_step[KINDS_MOST * REPEATS_MOST];
  sph_interpolator_type list[KINDS_MOST];
  const int count = kinds(list), repeats = quick ? 3 : 9;
  int measured = 0;
  flow f;
  open_flow(&f, of, SPH_INTERPOLATOR_IMPROVED_SHEPARD, true, sph_processor_count(), NULL);
  sph_context *context = f.context;
  OK(sph_integrator_advance(f.integrator, (quick ? 0.2 : 1) * sqrt(of->height / gravity)));
  state fallen = read_state(&f);
  close_flow(&f);
  for (int repeat = 0; repeat < repeats; repeat++)
    for (int turn = 0; turn < count; turn++) {
      const int k = (turn + repeat) % count;
      rest_of_step[measured++] = time_flow(of, list[k], &fallen, warm, steps, &times[k], repeat);
    }
  const double common = median(rest_of_step, measured);
  for (int k = 0; k < count; k++) {
    timing *t = &times[k];
    const double boundary = common * median(t->part, repeats), step = common + boundary;
    printf("%s\t%s\t%.6g\t%.6g\t%.4f\t%.6g\t%lld\t%lld\t%lld\n", of->name,
           sph_interpolator_name(list[k]), 1e3 * step, 1e3 * boundary, boundary / step,
           1e9 * boundary / (t->evaluations * (double)t->counts.active),
           (long long)t->counts.active, (long long)t->counts.fallback, (long long)fallen.n);
  }
  free_state(&fallen);
}

static void cost(void) {
  const flow_case plane = plane_dam_break(quick ? 0.02 : 0.004);
  const flow_case space = {.name = "3d",
                           .dim = 3,
                           .kernel = SPH_KERNEL_WENDLAND_C2,
                           .spacing = quick ? 0.5 / 8 : 0.5 / 21,
                           .h_factor = 1.5,
                           .length = 1,
                           .height = 0.5,
                           .width = 0.5,
                           .tank = 2,
                           .top = 1.5,
                           .c0_factor = 20,
                           .lid = true};
  time_case(&plane, 2, 6);
  time_case(&space, 1, 2);
}

/* ---------------------------------------------------------------------------------------- rest */

/* Lines: kind, compensated, rms over particles and times of p - exact / (rho g H), largest such rms of
 * one time, rms velocity / sqrt(g H) at the end. The tank of Huang et al. (2019), section 4.1. */
static void rest(void) {
  const flow_case tank = {.name = "rest",
                          .dim = 2,
                          .kernel = SPH_KERNEL_GAUSSIAN,
                          .spacing = quick ? 0.02 : 0.01,
                          .h_factor = 1.3,
                          .length = 1,
                          .height = 0.3,
                          .tank = 1,
                          .top = 0.45,
                          .c0_factor = 10};
  const double end = quick ? 0.2 : 1, sample = 0.01, bar = density * gravity * tank.height;
  sph_interpolator_type list[KINDS_MOST];
  const int count = kinds(list), samples = (int)(end / sample + 0.5);
  for (int k = 0; k < 2 * count; k++) {
    flow f;
    open_flow(&f, &tank, list[k / 2], k % 2, 1, NULL);
    sph_context *context = f.context;
    const int64_t n = sph_particles_count(f.water);
    double *x = numbers(2 * n), *p = numbers(n), *y = numbers(n);
    double sum = 0, largest = 0, speed = 0;
    for (int s = 1; s <= samples; s++) {
      double square = 0;
      OK(sph_integrator_advance(f.integrator, s * sample));
      OK(sph_particles_read(f.water, SPH_POSITION, x, 2 * n));
      OK(sph_particles_read(f.water, SPH_PRESSURE, p, n));
      for (int64_t i = 0; i < n; i++) y[i] = x[2 * i + 1];
      OK(sph_initial_hydrostatic(context, tank.height, gravity, density,
                                 tank.c0_factor * sqrt(gravity * tank.height), n, y, y));
      for (int64_t i = 0; i < n; i++) square += (p[i] - y[i]) * (p[i] - y[i]) / (double)n;
      sum += square / samples;
      largest = fmax(largest, square);
    }
    OK(sph_particles_read(f.water, SPH_VELOCITY, x, 2 * n));
    for (int64_t i = 0; i < 2 * n; i++) speed += x[i] * x[i] / (double)n;
    printf("%s\t%d\t%.4g\t%.4g\t%.4g\n", sph_interpolator_name(list[k / 2]), k % 2, sqrt(sum) / bar,
           sqrt(largest) / bar, sqrt(speed / (gravity * tank.height)));
    fflush(stdout);
    free(x);
    free(p);
    free(y);
    close_flow(&f);
  }
}

/* -------------------------------------------------------------------------------------- impact */

/* Weights that leave out the particle at the point itself. */
enum { LEAVE_SHEPARD, LEAVE_NORMALIZED, LEAVE_LINEAR, LEAVE_WAYS };

static double leave_one(int way, double r, double support, double kernel, double volume) {
  const double s = r / support, t = s * s;
  if (r < 1e-9 * support || t >= 1) return 0;
  if (way != LEAVE_SHEPARD) return kernel * volume;
  return exp(fmax(-4 * t / (1 - t), -700)) / (t * t);
}

/* Linear least squares, by elimination; false where the neighbours do not carry them. */
static bool leave_linear(int n, const double *offset, const double *w, double support,
                         double *phi) {
  double m[3][4] = {{0, 0, 0, 1}};
  for (int j = 0; j < n; j++) {
    const double b[3] = {1, offset[2 * j] / support, offset[2 * j + 1] / support};
    for (int r = 0; r < 3; r++)
      for (int c = 0; c < 3; c++) m[r][c] += w[j] * b[r] * b[c];
  }
  const double scale = m[0][0];
  for (int k = 0; k < 3; k++) {
    if (!(m[k][k] > 1e-4 * scale)) return false;
    for (int r = 0; r < 3; r++) {
      const double factor = m[r][k] / m[k][k];
      for (int c = k; r != k && c < 4; c++) m[r][c] -= factor * m[k][c];
    }
  }
  double sum = 0;
  for (int j = 0; j < n; j++) {
    phi[j] = w[j] * (m[0][3] / m[0][0] + m[1][3] / m[1][1] * offset[2 * j] / support +
                     m[2][3] / m[2][2] * offset[2 * j + 1] / support);
    sum += fabs(phi[j]);
  }
  return sum <= 3;
}

/* Where false is given the ladder would answer with the particle itself: the rung tells, and the particle
 * is left out of the comparison for every way. */
static bool leave_weights(int dim, int n, const double *offset, const double *kernel,
                          const double *volume, double support, double *weights, void *user) {
  const int way = *(const int *)user;
  double sum = 0;
  int others = 0;
  for (int j = 0; j < n; j++) {
    weights[j] =
        leave_one(way, hypot(offset[dim * j], offset[dim * j + 1]), support, kernel[j], volume[j]);
    sum += weights[j];
    others += weights[j] > 0;
  }
  if (others < 5 || !(sum > 1e-4)) return false;
  if (way == LEAVE_LINEAR) {
    double w[512];
    if (n > 512) return false;
    memcpy(w, weights, (size_t)n * sizeof *w);
    return leave_linear(n, offset, w, support, weights);
  }
  for (int j = 0; j < n; j++) weights[j] /= sum;
  return true;
}

/* What a prediction knows of the gradient: nothing, gravity, rho (g - a) of each particle with a of now or
 * the mean over the last step. */
enum { PLAIN, HYDROSTATIC, GRADIENT, GRADIENT_LATE, TREATMENTS };

typedef struct snapshot {
  state now;
  double *p, *a, *late; /* pressures, accelerations now, mean accelerations of the step before */
} snapshot;

/* The flow at a time, the pressure and the accelerations there. */
static snapshot take_snapshot(flow *f, double t) {
  sph_context *context = f->context;
  OK(sph_integrator_advance(f->integrator, t));
  state before = read_state(f);
  const double t0 = sph_integrator_time(f->integrator);
  OK(sph_integrator_step(f->integrator));
  const double dt = sph_integrator_time(f->integrator) - t0;
  snapshot s = {.now = read_state(f)};
  const int64_t n = s.now.n;
  s.p = numbers(n);
  s.a = numbers(2 * n);
  s.late = numbers(2 * n);
  OK(sph_particles_read(f->water, SPH_PRESSURE, s.p, n));
  for (int64_t i = 0; i < 2 * n; i++) s.late[i] = (s.now.v[i] - before.v[i]) / dt;
  free_state(&before);
  /* Accelerations of now: those of a step so short that nothing moves. */
  const double tiny = 1e-9;
  flow still;
  open_flow(&still, f->of, SPH_INTERPOLATOR_IMPROVED_SHEPARD, true, 1, &s.now);
  context = still.context;
  OK(sph_integrator_set_stepper(still.integrator, SPH_STEPPER_SYMPLECTIC));
  OK(sph_integrator_set_dt(still.integrator, tiny));
  OK(sph_integrator_step(still.integrator));
  OK(sph_particles_read(still.water, SPH_VELOCITY, s.a, 2 * n));
  for (int64_t i = 0; i < 2 * n; i++) s.a[i] = (s.a[i] - s.now.v[i]) / tiny;
  close_flow(&still);
  return s;
}

static void free_snapshot(snapshot *s) {
  free_state(&s->now);
  free(s->p);
  free(s->a);
  free(s->late);
}

/* Predictions at points that are particles, from the others. With G_j the gradient at a particle,
 * sum phi_j (p_j + G_j . (x - x_j)) = I[p] + x . I[G] - I[G . x]. */
static void predict(sph_context *context, const sph_interpolator *interpolator, sph_particles *set,
                    const snapshot *s, int treatment, int64_t points, const double *at,
                    double *values, int *rungs) {
  const double down[2] = {0, -density * gravity};
  const char *const names[] = {SPH_PRESSURE, "gradient", "shift"};
  const int64_t n = s->now.n;
  if (treatment == PLAIN) {
    OK(sph_interpolator_evaluate(interpolator, set, points, at, 1, names, values, rungs));
    return;
  }
  if (treatment == HYDROSTATIC) {
    OK(sph_interpolator_evaluate_compensated(interpolator, set, points, at, SPH_PRESSURE, down,
                                             values, rungs));
    return;
  }
  const double *a = treatment == GRADIENT ? s->a : s->late;
  double *gradient = numbers(2 * n), *shift = numbers(n), *all = numbers(4 * points);
  for (int64_t i = 0; i < n; i++) {
    gradient[2 * i] = -s->now.rho[i] * a[2 * i];
    gradient[2 * i + 1] = -s->now.rho[i] * (gravity + a[2 * i + 1]);
    shift[i] = gradient[2 * i] * s->now.x[2 * i] + gradient[2 * i + 1] * s->now.x[2 * i + 1];
  }
  OK(sph_particles_write(set, "gradient", gradient, 2 * n));
  OK(sph_particles_write(set, "shift", shift, n));
  OK(sph_interpolator_evaluate(interpolator, set, points, at, 3, names, all, rungs));
  for (int64_t k = 0; k < points; k++)
    values[k] =
        all[4 * k] + at[2 * k] * all[4 * k + 1] + at[2 * k + 1] * all[4 * k + 2] - all[4 * k + 3];
  free(gradient);
  free(shift);
  free(all);
}

enum { MAIN_RUNS = 2 * TREATMENTS + 1 }; /* Shepard and normalized in every way, linear plain */

typedef struct tally {
  double square[MAIN_RUNS], push;
  double *error[MAIN_RUNS];
  int64_t n, left_out;
} tally;

/* Adds the errors of one snapshot, of the particles within three spacings of the bed or the right wall. */
static void compare_predictions(const flow_case *of, const snapshot *s, tally *t) {
  sph_context *context = new_context(1);
  const double lo[] = {0, 0}, hi[] = {of->length, of->height}, reach = 3 * of->spacing;
  const int64_t n = s->now.n;
  sph_particles *set;
  sph_kernel *kernel;
  double *at = numbers(2 * n), *exact = numbers(n), *values = numbers(n * MAIN_RUNS);
  int *rungs = calloc((size_t)n + 1, sizeof *rungs);
  bool *bad = calloc((size_t)n + 1, sizeof *bad);
  if (!rungs || !bad) exit(1);
  OK(sph_kernel_create(context, of->kernel, 2, of->h_factor * of->spacing, &kernel));
  OK(sph_particles_create(context, 2, of->spacing, &set));
  OK(sph_particles_fill_box(set, lo, hi, density));
  OK(sph_particles_add_field(set, "gradient", 2, "Pa/m"));
  OK(sph_particles_add_field(set, "shift", 1, "Pa"));
  OK(sph_particles_write(set, SPH_POSITION, s->now.x, 2 * n));
  OK(sph_particles_write(set, SPH_PRESSURE, s->p, n));
  int64_t points = 0;
  for (int64_t i = 0; i < n; i++) {
    const double *x = s->now.x + 2 * i;
    if (x[1] > reach && x[0] < of->tank - reach) continue;
    memcpy(at + 2 * points, x, 2 * sizeof *x);
    exact[points++] = s->p[i];
    const double pushed = hypot(s->a[2 * i], s->a[2 * i + 1]) / gravity;
    t->push += pushed * pushed;
  }
  for (int run = 0; run < MAIN_RUNS; run++) {
    int way = run / TREATMENTS;
    sph_interpolator *interpolator;
    OK(sph_interpolator_create_user(context, kernel, leave_weights, &way, &interpolator));
    predict(context, interpolator, set, s, run % TREATMENTS, points, at, values + run * n, rungs);
    for (int64_t k = 0; k < points; k++) bad[k] = bad[k] || rungs[k] != SPH_INTERPOLATOR_USER;
    sph_interpolator_destroy(&interpolator);
  }
  for (int run = 0; run < MAIN_RUNS; run++) {
    double *grown = realloc(t->error[run], (size_t)(t->n + points + 1) * sizeof *grown);
    if (!grown) exit(1);
    t->error[run] = grown;
    int64_t kept = t->n;
    for (int64_t k = 0; k < points; k++) {
      if (bad[k]) continue;
      const double error = (values[run * n + k] - exact[k]) / (density * gravity * of->height);
      t->square[run] += error * error;
      grown[kept++] = fabs(error);
    }
  }
  for (int64_t k = 0; k < points; k++) bad[k] ? t->left_out++ : t->n++;
  free(at);
  free(exact);
  free(values);
  free(rungs);
  free(bad);
  sph_particles_destroy(&set);
  sph_kernel_destroy(&kernel);
  sph_context_destroy(&context);
}

/* Lines: t*, particles, left out, rms |a| / g, then of every way the rms of the errors / (rho g H), their
 * 0.9 quantile and their median. Each
 * is of five moments, 0.02 sqrt(H/g) apart. */
static void impact(void) {
  static const double stars[] = {0.5, 2.6, 6.3};
  enum { MOMENTS = 5 };
  const flow_case of = plane_dam_break(quick ? 0.03 : 0.01);
  const double unit = sqrt(of.height / gravity);
  flow f;
  open_flow(&f, &of, SPH_INTERPOLATOR_IMPROVED_SHEPARD, true, sph_processor_count(), NULL);
  for (int k = 0; k < (quick ? 2 : 3); k++) {
    tally t = {0};
    for (int m = 0; m < MOMENTS; m++) {
      snapshot s = take_snapshot(&f, (stars[k] + 0.02 * (m - MOMENTS / 2)) * unit);
      compare_predictions(&of, &s, &t);
      free_snapshot(&s);
    }
    printf("%.2f\t%lld\t%lld\t%.3g", stars[k], (long long)t.n, (long long)t.left_out,
           sqrt(t.push / (double)(t.n + t.left_out)));
    for (int run = 0; run < MAIN_RUNS; run++) {
      const double middle = median(t.error[run], t.n);
      printf("\t%.3g\t%.3g\t%.3g", sqrt(t.square[run] / (double)t.n),
             quantile(t.error[run], t.n, 0.9), middle);
    }
    printf("\n");
    for (int run = 0; run < MAIN_RUNS; run++) free(t.error[run]);
  }
  close_flow(&f);
}

/* --------------------------------------------------------------------------------------- plain */

/* A picture as the examples write it, places / H and pressures / (rho g H). */
static void write_picture(const flow *f, const char *path) {
  sph_context *context = f->context;
  const double height = f->of->height, bar = density * gravity * height;
  const int64_t n = sph_particles_count(f->water);
  double *x = numbers(2 * n), *p = numbers(n);
  OK(sph_particles_read(f->water, SPH_POSITION, x, 2 * n));
  OK(sph_particles_read(f->water, SPH_PRESSURE, p, n));
  FILE *file = fopen(path, "w");
  if (!file) {
    fprintf(stderr, "interpolators: cannot write %s\n", path);
    exit(1);
  }
  fprintf(file, "# t_star %.4f spacing_over_H %.9g\n",
          sph_integrator_time(f->integrator) * sqrt(gravity / height), f->of->spacing / height);
  for (int64_t i = 0; i < n; i++)
    fprintf(file, "%.5f %.5f %.5f\n", x[2 * i] / height, x[2 * i + 1] / height, p[i] / bar);
  fclose(file);
  free(x);
  free(p);
}

/* The dam break of the examples without compensation, as in the paper: P1 into FOLDER/plain_KIND_p1.csv,
 * pictures from 3 to 5 into FOLDER/plain_KIND_00.txt to _10.txt. */
static void plain(const char *kind, double dx, const char *folder) {
  const flow_case of = plane_dam_break(dx);
  const double unit = sqrt(of.height / gravity), p1[] = {of.tank, 0.115};
  sph_interpolator_type type;
  char path[512];
  flow f;
  sph_probe *probe;
  sph_context *context = new_context(1);
  OK(sph_interpolator_find(context, kind, &type));
  sph_context_destroy(&context);
  open_flow(&f, &of, type, false, 1, NULL);
  context = f.context;
  OK(sph_probe_create_pressure(f.integrator, p1, &probe));
  OK(sph_probe_set_interval(probe, 0.005 * unit));
  for (int k = 0; k <= 10; k++) {
    OK(sph_integrator_advance(f.integrator, (3 + 0.2 * k) * unit));
    snprintf(path, sizeof path, "%s/plain_%s_%02d.txt", folder, kind, k);
    write_picture(&f, path);
  }
  OK(sph_integrator_advance(f.integrator, 7.4 * unit));
  snprintf(path, sizeof path, "%s/plain_%s_p1.csv", folder, kind);
  OK(sph_probe_write_csv(probe, path));
  sph_probe_destroy(&probe);
  close_flow(&f);
}

/* -------------------------------------------------------------------------------------- corner */

/* How rough the pressure is at the foot of the wall at x: of the particles within ten spacings of the
 * corner, rms of p less the mean of the neighbours within two spacings, and less the plane through them. */
static bool roughness(const char *path, double wall, double rough[2]) {
  FILE *file = fopen(path, "r");
  double spacing = 0;
  if (!file || fscanf(file, "# t_star %*f spacing_over_H %lf\n", &spacing) != 1) {
    if (file) fclose(file);
    return false;
  }
  double(*row)[3] = NULL, x, y, p;
  size_t n = 0, inside = 0;
  for (char line[256]; fgets(line, sizeof line, file);) {
    if (sscanf(line, "%lf %lf %lf", &x, &y, &p) != 3) continue;
    if (hypot(x - wall, y) > 12.1 * spacing) continue;
    double(*grown)[3] = realloc(row, (n + 1) * sizeof *row);
    if (!grown) exit(1);
    row = grown;
    row[n][0] = x;
    row[n][1] = y;
    row[n++][2] = p;
  }
  fclose(file);
  rough[0] = rough[1] = 0;
  for (size_t i = 0; i < n; i++) {
    if (hypot(row[i][0] - wall, row[i][1]) > 10 * spacing) continue;
    double m[3][4] = {{0}}, mean = 0;
    int count = 0;
    for (size_t j = 0; j < n; j++) {
      const double b[3] = {1, (row[j][0] - row[i][0]) / spacing, (row[j][1] - row[i][1]) / spacing};
      if (j == i || hypot(b[1], b[2]) > 2) continue;
      for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) m[r][c] += b[r] * b[c];
      for (int r = 0; r < 3; r++) m[r][3] += b[r] * row[j][2];
      mean += row[j][2];
      count++;
    }
    if (count < 4) continue;
    for (int k = 0; k < 3; k++)
      for (int r = 0; r < 3; r++) {
        const double factor = m[r][k] / m[k][k];
        for (int c = k; r != k && c < 4; c++) m[r][c] -= factor * m[k][c];
      }
    rough[0] += pow(row[i][2] - mean / count, 2);
    rough[1] += pow(row[i][2] - m[0][3] / m[0][0], 2);
    inside++;
  }
  for (int k = 0; k < 2; k++) rough[k] = sqrt(rough[k] / (double)inside);
  free(row);
  return inside > 0;
}

/* One line a picture: both roughnesses / (rho g H). */
static int corner(int count, char **argument) {
  for (int k = 1; k < count; k++) {
    double rough[2];
    if (!roughness(argument[k], atof(argument[0]), rough)) {
      fprintf(stderr, "interpolators: %s is no picture with particles in the corner\n",
              argument[k]);
      return 1;
    }
    printf("%.4g\t%.4g\n", rough[0], rough[1]);
  }
  return 0;
}

int main(int argc, char **argv) {
  const char *command = argc > 1 ? argv[1] : "";
  quick = argc > 2 && strcmp(argv[2], "--quick") == 0;
  if (strcmp(command, "corner") == 0 && argc > 3) return corner(argc - 2, argv + 2);
  if (strcmp(command, "plain") == 0 && argc == 5) {
    plain(argv[2], atof(argv[3]), argv[4]);
    return 0;
  }
  static const struct {
    const char *name;
    void (*run)(void);
  } commands[] = {{"consistency", consistency}, {"cost", cost}, {"rest", rest}, {"impact", impact}};
  for (size_t k = 0; k < sizeof commands / sizeof *commands; k++) {
    if (strcmp(command, commands[k].name) != 0) continue;
    commands[k].run();
    return 0;
  }
  fputs(
      "usage: interpolators consistency | cost | rest | impact [--quick]\n"
      "       interpolators plain KIND DX FOLDER\n"
      "       interpolators corner X_OVER_H PICTURE ...\n",
      stderr);
  return 2;
}
