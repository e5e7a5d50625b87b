#include "world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define LENGTH 1.2
#define WIDTH 0.48
#define HEIGHT 0.6
#define TANK 3.22
#define RIM 1.0
#define DENSITY 1000.0
#define GRAVITY 9.81

const flow_case flow_cases[] = {
    {"dam2d-gaussian", 2, SPH_KERNEL_GAUSSIAN, 0.004, 1.3, 40, {5, 12}, true},
    {"dam2d-wendland", 2, SPH_KERNEL_WENDLAND_C2, 0.004, 1.5, 40, {5, 12}, true},
    {"dam3d-wendland", 3, SPH_KERNEL_WENDLAND_C2, 0.015, 1.3, 20, {2, 5}, true},
    {"dam3d-wide", 3, SPH_KERNEL_WENDLAND_C2, 0.015, 1.5, 20, {2, 5}, false},
    {"dam3d-large", 3, SPH_KERNEL_WENDLAND_C2, 0.0075, 1.3, 4, {1, 3}, false},
};
const int flow_case_count = sizeof flow_cases / sizeof *flow_cases;

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

double world_sound_speed(void) { return 20 * sqrt(GRAVITY * HEIGHT); }

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

/* A number in [-1, 1) from a counter: the same on every machine. */
static double noise(uint64_t k) {
  k += 0x9e3779b97f4a7c15u;
  k = (k ^ (k >> 30)) * 0xbf58476d1ce4e5b9u;
  k = (k ^ (k >> 27)) * 0x94d049bb133111ebu;
  k ^= k >> 31;
  return (double)(k >> 11) * 0x1p-52 - 1;
}

/* The lattice a little disordered, in the velocity field (2 x, ..., -2 y)/s of a column half way down,
 * so that lists age as they do in a run, under the pressure of the dam break's first instant. */
static void start(world *w) {
  const int dim = w->of->dim;
  const int32_t n = sph_particles_count(w->particles);
  double *x = numbers_new((int64_t)n * dim), *v = numbers_new((int64_t)n * dim);
  double *xy = numbers_new(2 * (int64_t)n), *p = numbers_new(n);
  OK(w, sph_particles_read(w->particles, SPH_POSITION, x, (int64_t)n * dim));
  for (int32_t i = 0; i < n; i++) {
    for (int d = 0; d < dim; d++)
      x[i * dim + d] += 0.1 * w->of->spacing * noise((uint64_t)(i * dim + d));
    xy[2 * i] = x[i * dim];
    xy[2 * i + 1] = x[i * dim + dim - 1];
    v[i * dim] = 2 * xy[2 * i];
    v[i * dim + dim - 1] = -2 * xy[2 * i + 1];
  }
  OK(w, sph_particles_write(w->particles, SPH_POSITION, x, (int64_t)n * dim));
  OK(w, sph_particles_write(w->particles, SPH_VELOCITY, v, (int64_t)n * dim));
  OK(w, sph_initial_dam_break_pressure(w->context, LENGTH, HEIGHT, GRAVITY, DENSITY,
                                       world_sound_speed(), n, xy, p));
  OK(w, sph_wcsph_start_from_pressure(w->flow, n, p));
  free(x);
  free(v);
  free(xy);
  free(p);
}

static void restore(world *w, const state *from) {
  const int64_t n = from->n;
  OK(w, sph_particles_write(w->particles, SPH_POSITION, from->x, n * from->dim));
  OK(w, sph_particles_write(w->particles, SPH_VELOCITY, from->v, n * from->dim));
  OK(w, sph_particles_write(w->particles, SPH_DENSITY, from->rho, n));
  OK(w, sph_particles_write(w->particles, SPH_MASS, from->m, n));
}

void world_open(world *w, const flow_case *of, sph_isa isa, int threads, sph_stepper stepper,
                const state *from) {
  memset(w, 0, sizeof *w);
  w->of = of;
  const int dim = of->dim;
  const double dx = of->spacing;
  const double lo[3] = {0, 0, 0}, hi2[2] = {LENGTH, HEIGHT}, hi3[3] = {LENGTH, WIDTH, HEIGHT};
  const double tank2[2] = {TANK, RIM}, tank3[3] = {TANK, WIDTH, RIM};
  const sph_allocator allocator = {allocate, release, &w->held};
  world_check(sph_context_create_with_allocator(&allocator, &w->context), NULL, "context");
  OK(w, sph_context_set_threads(w->context, threads));
  OK(w, sph_context_set_isa(w->context, isa));
  OK(w, sph_kernel_create(w->context, of->kernel, dim, of->h_factor * dx, &w->kernel));
  OK(w, sph_particles_create(w->context, dim, dx, &w->particles));
  OK(w, sph_particles_fill_box(w->particles, lo, dim == 2 ? hi2 : hi3, DENSITY));
  OK(w, sph_wall_create_box(w->context, dim, lo, dim == 2 ? tank2 : tank3, SPH_SIDE_HI(dim - 1),
                            &w->wall));
  OK(w, sph_interpolator_create(w->context, SPH_INTERPOLATOR_IMPROVED_SHEPARD, w->kernel,
                                &w->interpolator));
  OK(w, sph_boundary_create(w->context, w->wall, dx, w->interpolator, &w->boundary));
  OK(w, sph_wcsph_create(w->context, w->kernel, w->particles, w->boundary, &w->flow));
  OK(w, sph_wcsph_set_sound_speed(w->flow, world_sound_speed()));
  OK(w, sph_integrator_set_stepper(w->flow, stepper));
  if (from)
    restore(w, from);
  else
    start(w);
}

void world_close(world *w) {
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

bool world_is_free(const flow_case *of, const double *x) {
  const double ratio = of->kernel == SPH_KERNEL_GAUSSIAN ? 3 : 2;
  const double reach = ratio * of->h_factor * of->spacing;
  const bool between = of->dim == 2 || (x[1] > reach && x[1] < WIDTH - reach);
  return between && x[0] > reach && x[0] < TANK - reach && x[of->dim - 1] > reach;
}
