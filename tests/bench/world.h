/* The flows that are measured: collapsing columns of water, made through the public interface. */
#ifndef WORLD_H
#define WORLD_H

#include <sph.h>
#include <stdbool.h>
#include <stdint.h>

/* A water column in the corner of a tank. */
typedef struct flow_case {
  const char *name;
  int dim;
  sph_kernel_type kernel;
  double spacing;  /* m */
  double h_factor; /* h / spacing */
  int warm_up;     /* steps before anything is measured */
  int steps[2];    /* steps a repeat: rk4, symplectic */
  bool usual;      /* measured unless --cases says otherwise */
} flow_case;

extern const flow_case flow_cases[];
extern const int flow_case_count;

/* Everything about the particles that a new flow needs to go on: vectors are [n, dim]. */
typedef struct state {
  int dim;
  int32_t n;
  double *x, *v, *rho, *m;
} state;

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
} world;

/* On failure says what the library says and ends the program. */
#define OK(world, call) world_check(call, (world)->context, #call)
void world_check(sph_status status, const sph_context *context, const char *call);

/* A flow at its start, or where `from` is (NULL: at its start). */
void world_open(world *w, const flow_case *of, sph_isa isa, int threads, sph_stepper stepper,
                const state *from);
void world_close(world *w);

void world_step(world *w, int steps);
void world_read(const world *w, state *s);
void state_free(state *s);

/* True where no ghost acts: farther than the support from every wall. */
bool world_is_free(const flow_case *of, const double *x);
double world_sound_speed(void);

/* Memory for n numbers, or the end of the program. */
double *numbers_new(int64_t n);

/* Seconds since some moment. */
double clock_now(void);

#endif
