#include "world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define DENSITY 1000.0
#define GRAVITY 9.81

/* Places: x along the tank, in 3D y across it; height is the last axis. The top is open. */
struct basin {
  double length, width, height; /* of the water */
  double tank, rim;             /* length and height of the tank */
  /* Velocities [n, dim] and pressures [n] at positions x [n, dim]. */
  void (*start)(const world *w, int32_t n, const double *x, double *v, double *p);
};

static void start_column(const world *w, int32_t n, const double *x, double *v, double *p);
static void start_wave(const world *w, int32_t n, const double *x, double *v, double *p);
static void start_rest(const world *w, int32_t n, const double *x, double *v, double *p);

static const basin dam = {1.2, 0.48, 0.6, 3.22, 1.0, start_column};
static const basin flume = {10, 0, 0.25, 10, 0.5, start_wave};
static const basin rest = {2, 0, 0.5, 2, 1, start_rest};

#define GAUSSIAN SPH_KERNEL_GAUSSIAN
#define WENDLAND SPH_KERNEL_WENDLAND_C2
const flow_case flow_cases[] = {
    {"dam2d-gaussian", &dam, 2, GAUSSIAN, 0.004, 1.3, 40, {4, 10}, true},
    {"dam2d-wendland", &dam, 2, WENDLAND, 0.004, 1.5, 40, {4, 10}, true},
    {"dam2d-narrow", &dam, 2, WENDLAND, 0.004, 1.3, 40, {4, 10}, true},
    {"flume2d", &flume, 2, GAUSSIAN, 0.01, 1.3, 40, {8, 20}, true},
    {"dam3d-wendland", &dam, 3, WENDLAND, 0.015, 1.3, 20, {2, 4}, true},
    {"dam3d-wide", &dam, 3, WENDLAND, 0.015, 1.5, 20, {2, 4}, false},
    {"dam3d-large", &dam, 3, WENDLAND, 0.12 / 17, 1.3, 4, {1, 3}, false},
    /* Four steps share a preconditioner, so that all repeats have as many of them. */
    {"rest2d", &rest, 2, WENDLAND, 0.5 / 45, 1.5, 1, {[ISPH] = 8}, true},
    {"rest2d-medium", &rest, 2, WENDLAND, 0.5 / 112, 1.5, 1, {[ISPH] = 4}, false},
    {"rest2d-large", &rest, 2, WENDLAND, 0.5 / 224, 1.5, 1, {[ISPH] = 4}, false},
    {.name = "mesh2d", .dim = 2, .spacing = 0.025, .steps = {[FLIP] = 10}, .usual = true},
};
const int flow_case_count = sizeof flow_cases / sizeof *flow_cases;

const scheme schemes[SCHEMES] = {[RK4] = {"rk4", false, SPH_STEPPER_RK4},
                                 [SYMPLECTIC] = {"symplectic", false, SPH_STEPPER_SYMPLECTIC},
                                 [ISPH] = {.name = "isph", .incompressible = true},
                                 [FLIP] = {.name = "flip"}};

void world_check(sph_status status, const sph_context *context, const char *call) {
  if (status == SPH_OK) return;
  fprintf(stderr, "%s: %s\n", call, sph_context_message(context));
  exit(1);
}

double *numbers_new(int64_t n) {
  double *numbers = calloc((size_t)n + 1, sizeof *numbers);
  if (numbers) return numbers;
  fputs("no memory\n", stderr);
  exit(1);
}

double clock_now(void) {
  struct timespec now;
  timespec_get(&now, TIME_UTC);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double world_sound_speed(const flow_case *of) { return 20 * sqrt(GRAVITY * of->basin->height); }

/* The size of a block stands in front of it, in the room that alignment wants there. */
enum { FRONT = 64 };

static void *allocate(size_t bytes, void *user) {
  memory *held = user;
  if (bytes > SIZE_MAX - FRONT) return NULL;
  unsigned char *block = malloc(bytes + FRONT);
  if (!block) return NULL;
  memcpy(block, &bytes, sizeof bytes);
  held->calls++;
  held->now += (int64_t)bytes;
  if (held->now > held->peak) held->peak = held->now;
  return block + FRONT;
}

static void release(void *pointer, void *user) {
  memory *held = user;
  if (!pointer) return;
  unsigned char *block = (unsigned char *)pointer - FRONT;
  size_t bytes;
  memcpy(&bytes, block, sizeof bytes);
  held->now -= (int64_t)bytes;
  free(block);
}

sph_allocator memory_allocator(memory *held) { return (sph_allocator){allocate, release, held}; }

/* A number in [-1, 1) from a counter: the same on every machine. */
static double noise(uint64_t k) {
  k += 0x9e3779b97f4a7c15u;
  k = (k ^ (k >> 30)) * 0xbf58476d1ce4e5b9u;
  k = (k ^ (k >> 27)) * 0x94d049bb133111ebu;
  k ^= k >> 31;
  return (double)(k >> 11) * 0x1p-52 - 1;
}

/* The velocity field (2 x, ..., -2 y)/s of a column half way down, so that lists age as they do in a
 * run, under the pressure of the dam break's first instant. */
static void start_column(const world *w, int32_t n, const double *x, double *v, double *p) {
  const basin *in = w->of->basin;
  const int dim = w->of->dim;
  double *section = numbers_new(2 * (int64_t)n);
  for (int32_t i = 0; i < n; i++) {
    section[2 * i] = x[i * dim];
    section[2 * i + 1] = x[i * dim + dim - 1];
    v[i * dim] = 2 * section[2 * i];
    v[i * dim + dim - 1] = -2 * section[2 * i + 1];
  }
  OK(w, sph_initial_dam_break_pressure(w->context, in->length, in->height, GRAVITY, DENSITY,
                                       world_sound_speed(w->of), n, section, p));
  free(section);
}

/* The velocities of a solitary wave of a fifth of the depth in the middle of a flume, under a surface
 * that is still flat: u = sqrt(g/d) a / cosh^2(k (x - L/2)), and -y du/dx upward. */
static void start_wave(const world *w, int32_t n, const double *x, double *v, double *p) {
  const double depth = w->of->basin->height, wave = 0.2 * depth;
  const double k = sqrt(0.75 * wave / depth) / depth, crest = sqrt(GRAVITY / depth) * wave;
  for (int32_t i = 0; i < n; i++) {
    const double along = k * (x[2 * i] - 0.5 * w->of->basin->length), y = x[2 * i + 1];
    v[2 * i] = crest / (cosh(along) * cosh(along));
    v[2 * i + 1] = 2 * k * y * tanh(along) * v[2 * i];
    p[i] = DENSITY * GRAVITY * (depth - y);
  }
}

/* Nothing moves but what the disorder of the lattice sets off. */
static void start_rest(const world *w, int32_t n, const double *x, double *v, double *p) {
  memset(v, 0, 2 * (size_t)n * sizeof *v);
  for (int32_t i = 0; i < n; i++)
    p[i] = DENSITY * GRAVITY * fmax(w->of->basin->height - x[2 * i + 1], 0);
}

/* The lattice a little disordered, with the velocities and pressures of its case. */
static void start(world *w) {
  const int dim = w->of->dim;
  const int32_t n = sph_particles_count(w->particles);
  const int64_t vector = (int64_t)n * dim;
  double *x = numbers_new(vector), *v = numbers_new(vector), *p = numbers_new(n);
  OK(w, sph_particles_read(w->particles, SPH_POSITION, x, vector));
  for (int64_t k = 0; k < vector; k++) x[k] += 0.1 * w->of->spacing * noise((uint64_t)k);
  w->of->basin->start(w, n, x, v, p);
  OK(w, sph_particles_write(w->particles, SPH_POSITION, x, vector));
  OK(w, sph_particles_write(w->particles, SPH_VELOCITY, v, vector));
  OK(w, sph_wcsph_start_from_pressure(w->flow, n, p));
  free(x);
  free(v);
  free(p);
}

static void restore(world *w, const state *from) {
  const int64_t n = from->n;
  OK(w, sph_particles_write(w->particles, SPH_POSITION, from->x, n * from->dim));
  OK(w, sph_particles_write(w->particles, SPH_VELOCITY, from->v, n * from->dim));
  OK(w, sph_particles_write(w->particles, SPH_DENSITY, from->rho, n));
  OK(w, sph_particles_write(w->particles, SPH_MASS, from->m, n));
}

/* Buchner's plate, but on the wet wall: from 0.115/0.6 to 0.205/0.6 of the water's height. */
static void create_gauge(world *w) {
  const basin *in = w->of->basin;
  double below[3] = {0, in->width / 2, 0}, above[3] = {0, in->width / 2, 0};
  below[w->of->dim - 1] = 0.115 / 0.6 * in->height;
  above[w->of->dim - 1] = 0.205 / 0.6 * in->height;
  OK(w, sph_probe_create_pressure_average(w->flow, below, above, 9, &w->gauge));
}

static void create_tank(world *w) {
  const basin *in = w->of->basin;
  const int dim = w->of->dim;
  const double lo[3] = {0, 0, 0};
  const double water[3] = {in->length, dim == 2 ? in->height : in->width, in->height};
  const double tank[3] = {in->tank, dim == 2 ? in->rim : in->width, in->rim};
  OK(w, sph_particles_fill_box(w->particles, lo, water, DENSITY));
  OK(w, sph_wall_create_box(w->context, dim, lo, tank, SPH_SIDE_HI(dim - 1), &w->wall));
}

static void create_flow(world *w, const scheme *s) {
  if (s->incompressible) {
    OK(w, sph_isph_create(w->context, w->kernel, w->particles, w->boundary, &w->flow));
    OK(w, sph_isph_get_solver(w->flow, &w->solver));
    return;
  }
  OK(w, sph_wcsph_create(w->context, w->kernel, w->particles, w->boundary, &w->flow));
  OK(w, sph_wcsph_set_sound_speed(w->flow, world_sound_speed(w->of)));
  OK(w, sph_integrator_set_stepper(w->flow, s->stepper));
}

void world_open(world *w, const flow_case *of, sph_isa isa, int threads, int chosen,
                const state *from) {
  memset(w, 0, sizeof *w);
  w->of = of;
  const sph_allocator allocator = memory_allocator(&w->held);
  world_check(sph_context_create_with_allocator(&allocator, &w->context), NULL, "context");
  OK(w, sph_context_set_threads(w->context, threads));
  OK(w, sph_context_set_isa(w->context, isa));
  OK(w, sph_kernel_create(w->context, of->kernel, of->dim, of->h_factor * of->spacing, &w->kernel));
  OK(w, sph_particles_create(w->context, of->dim, of->spacing, &w->particles));
  create_tank(w);
  OK(w, sph_interpolator_create(w->context, SPH_INTERPOLATOR_IMPROVED_SHEPARD, w->kernel,
                                &w->interpolator));
  OK(w, sph_boundary_create(w->context, w->wall, of->spacing, w->interpolator, &w->boundary));
  create_flow(w, &schemes[chosen]);
  create_gauge(w);
  if (from)
    restore(w, from);
  else
    start(w);
}

void world_close(world *w) {
  sph_probe_destroy(&w->gauge);
  sph_integrator_destroy(&w->flow);
  sph_boundary_destroy(&w->boundary);
  sph_interpolator_destroy(&w->interpolator);
  sph_wall_destroy(&w->wall);
  sph_particles_destroy(&w->particles);
  sph_kernel_destroy(&w->kernel);
  sph_context_destroy(&w->context);
}

void world_step(world *w, int steps) {
  for (int k = 0; k < steps; k++) OK(w, sph_integrator_step(w->flow));
}

void world_read(const world *w, state *s) {
  s->dim = w->of->dim;
  s->n = sph_particles_count(w->particles);
  const int64_t n = s->n, vector = n * s->dim;
  s->x = numbers_new(vector);
  s->v = numbers_new(vector);
  s->rho = numbers_new(n);
  s->m = numbers_new(n);
  OK(w, sph_particles_read(w->particles, SPH_POSITION, s->x, vector));
  OK(w, sph_particles_read(w->particles, SPH_VELOCITY, s->v, vector));
  OK(w, sph_particles_read(w->particles, SPH_DENSITY, s->rho, n));
  OK(w, sph_particles_read(w->particles, SPH_MASS, s->m, n));
}

void state_free(state *s) {
  free(s->x);
  free(s->v);
  free(s->rho);
  free(s->m);
  memset(s, 0, sizeof *s);
}

static void read_ghosts(const world *w, sph_ghost_value what, int64_t size, double **values) {
  *values = numbers_new(size);
  OK(w, sph_boundary_read(w->boundary, what, *values, size));
}

void world_read_ghosts(const world *w, ghosts *g) {
  const int dim = w->of->dim;
  const int64_t n = sph_boundary_count(w->boundary), vector = n * dim;
  read_ghosts(w, SPH_GHOST_POSITION, vector, &g->x);
  read_ghosts(w, SPH_GHOST_VELOCITY, vector, &g->v);
  read_ghosts(w, SPH_GHOST_PRESSURE, n, &g->p);
  read_ghosts(w, SPH_GHOST_VOLUME, n, &g->volume);
  g->n = 0;
  for (int64_t k = 0; k < n; k++) {
    if (g->volume[k] == 0) continue;
    memmove(g->x + dim * g->n, g->x + dim * k, (size_t)dim * sizeof *g->x);
    memmove(g->v + dim * g->n, g->v + dim * k, (size_t)dim * sizeof *g->v);
    g->p[g->n] = g->p[k];
    g->volume[g->n++] = g->volume[k];
  }
}

void ghosts_free(ghosts *g) {
  free(g->x);
  free(g->v);
  free(g->p);
  free(g->volume);
  memset(g, 0, sizeof *g);
}
