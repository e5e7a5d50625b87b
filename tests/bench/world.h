/* The flows that are measured, made through the public interface. */
#ifndef WORLD_H
#define WORLD_H

#include <sph.h>
#include <stdbool.h>
#include <stdint.h>

/* The schemes that are measured: steppers of weakly compressible SPH, incompressible SPH, particles with a mesh. */
enum { RK4, SYMPLECTIC, ISPH, FLIP, SCHEMES };
typedef struct scheme {
  const char *name;
  bool incompressible;
  sph_stepper stepper; /* unless incompressible */
} scheme;
extern const scheme schemes[SCHEMES];

typedef struct basin basin; /* water in a tank, and how it starts */

typedef struct flow_case {
  const char *name;
  const basin *basin; /* NULL: the mesh's own, see mesh.c */
  int dim;
  sph_kernel_type kernel;
  double spacing;     /* m; legs of triangles */
  double h_factor;    /* h / spacing */
  int warm_up;        /* steps before anything is measured */
  int steps[SCHEMES]; /* steps a repeat; 0: not measured with that scheme */
  bool usual;         /* measured unless --cases says otherwise */
} flow_case;

extern const flow_case flow_cases[];
extern const int flow_case_count;

/* Everything about the particles that a new flow needs to go on: vectors are [n, dim]. */
typedef struct state {
  int dim;
  int32_t n;
  double *x, *v, *rho, *m;
} state;

/* Ghosts that act on the fluid, as the last evaluation had them. */
typedef struct ghosts {
  int32_t n;
  double *x, *v, *p, *volume;
} ghosts;

/* Memory that the library holds. */
typedef struct memory {
  int64_t now, peak, calls;
} memory;

typedef struct world {
  const flow_case *of;
  memory held;
  sph_context *context;
  sph_kernel *kernel;
  sph_particles *particles;
  sph_wall *wall;
  sph_interpolator *interpolator;
  sph_boundary *boundary;
  sph_integrator *flow;
  sph_solver *solver; /* of incompressible SPH, part of the flow; NULL: there is none */
  sph_probe *gauge;
} world;

/* An allocator that counts. */
sph_allocator memory_allocator(memory *held);

/* On failure says what the library says and ends the program. */
#define OK(world, call) world_check(call, (world)->context, #call)
void world_check(sph_status status, const sph_context *context, const char *call);

/* A flow at its start, or where `from` is (NULL: at its start, if compressible), with a pressure gauge on
 * the wall that samples every step. */
void world_open(world *w, const flow_case *of, sph_isa isa, int threads, int chosen,
                const state *from);
void world_close(world *w);

void world_step(world *w, int steps);
void world_read(const world *w, state *s);
void state_free(state *s);
void world_read_ghosts(const world *w, ghosts *g);
void ghosts_free(ghosts *g);

double world_sound_speed(const flow_case *of);

/* Memory for n numbers, or the end of the program. */
double *numbers_new(int64_t n);

/* Seconds since some moment. */
double clock_now(void);

#endif
