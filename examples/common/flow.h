/* What the examples of flows share: weakly compressible or incompressible SPH in a tank with fixed ghosts. */
#ifndef EXAMPLE_FLOW_H
#define EXAMPLE_FLOW_H

#include "example.h"

/* How a flow is computed. Initialise it with EXAMPLE_SCHEME and change what the case wants. */
typedef struct example_scheme {
  double c0_factor, h_ratio, courant, dt, alpha, nu, delta;
  int threads;
  const char *method, *walls, *interpolator, *kernel, *stepper, *diffusion, *isa;
} example_scheme;
#define EXAMPLE_SCHEME                                                                             \
  {                                                                                                \
    .c0_factor = 10, .h_ratio = 1.3, .alpha = 0.02, .delta = 0.1, .method = "wcsph", .walls = "",  \
    .interpolator = "improved-shepard", .kernel = "gaussian", .stepper = "", .diffusion = "delta", \
    .isa = "auto"                                                                                  \
  }

/* Rows of an option table; the last two texts are put after those of --kernel and --h. */
#define EXAMPLE_SCHEME_OPTIONS(s, of_kernel, of_h)                                           \
  OPTION_TEXT("--method", (s).method, "wcsph or isph"),                                      \
      OPTION_TEXT("--walls", (s).walls, "of isph: ghosts, dummies, dummies-as-printed"),     \
      OPTION_NUMBER("--c0", (s).c0_factor, 5, 200, "sound speed / sqrt(g H)"),               \
      OPTION_TEXT("--interpolator", (s).interpolator, "improved-shepard, mls-linear, ..."),  \
      OPTION_TEXT("--kernel", (s).kernel, "gaussian, wendland-c2, ..." of_kernel),           \
      OPTION_NUMBER("--h", (s).h_ratio, 0.8, 4, "smoothing length / dx" of_h),               \
      OPTION_TEXT("--stepper", (s).stepper,                                                  \
                  "symplectic, verlet, rk4; without it the library's own"),                  \
      OPTION_NUMBER("--courant", (s).courant, 0, 10, "Courant number, 0: the scheme's own"), \
      OPTION_NUMBER("--dt", (s).dt, 0, 1, "fixed step [s], 0: follow the limits"),           \
      OPTION_NUMBER("--alpha", (s).alpha, 0, 1, "artificial viscosity"),                     \
      OPTION_NUMBER("--viscosity", (s).nu, 0, 1, "laminar, besides [m^2/s]"),                \
      OPTION_TEXT("--diffusion", (s).diffusion, "of density: none, molteni, delta"),         \
      OPTION_NUMBER("--delta", (s).delta, 0, 1, "coefficient of the density diffusion"),     \
      OPTION_INTEGER("--threads", (s).threads, 0, 1024, "0: one for each processor"),        \
      OPTION_TEXT("--isa", (s).isa, "auto, baseline, avx2, avx512")

/* Checkpoints of a run: every so many seconds of flow time into a folder, and whether to go on from there. */
typedef struct example_checkpoints {
  double every; /* 0: none */
  bool resume;
} example_checkpoints;
#define EXAMPLE_CHECKPOINT_OPTIONS(c)                                                             \
  OPTION_NUMBER("--checkpoint", (c).every, 0, 1e9, "flow time between checkpoints in --out [s]"), \
      OPTION_FLAG("--resume", (c).resume, "go on from the checkpoint in --out")

/* Everything that a run holds, in the order of creation. What a case does not have stays NULL. */
enum { EXAMPLE_PROBES = 24, EXAMPLE_WALLS = 2 };
typedef struct example_flow {
  sph_context *context;
  sph_kernel *kernel;
  sph_particles *water;
  sph_wall *tank, *more[EXAMPLE_WALLS]; /* walls of their own, numbers 1 ... in the boundary */
  sph_interpolator *interpolator;
  sph_boundary *ghosts;
  sph_integrator *integrator;
  sph_probe *probes[EXAMPLE_PROBES];
  sph_output *vtk;
  double checkpoint_every, from; /* time and steps at which this part of the run begins */
  int64_t steps_before;
  const char *checkpoint_folder;
} example_flow;

/* Position, velocity, pressure and so on of all particles, components one after the other. */
double *example_flow_read(const example_flow *f, const char *field, int components);

/* First the context, the kernel and water without particles. */
void example_flow_open(const example_scheme *s, int dim, double dx, example_flow *f);
/* Then, with the water filled in and the tank created, the ghosts and the scheme. */
void example_flow_solve(const example_scheme *s, double c0, example_flow *f);
/* Pressures at the start, where a method does not find them itself. */
void example_flow_start(const example_scheme *s, example_flow *f, const double *pressure);
/* Then, before probes are created, whether the run goes on from a checkpoint, and writes some. */
void example_flow_resume(const example_checkpoints *c, const char *folder, example_flow *f);
/* After each step: a checkpoint, if one is due. */
void example_flow_checkpoint(const example_flow *f);
/* As example_path; files of a run that went on have the time from which it did in their names. */
const char *example_flow_path(const example_flow *f, const char *folder, const char *file);
void example_flow_destroy(example_flow *f);

/* Whether a run that has written `done` of its frames, evenly from 0 to end, owes one at time t. Frames
 * are taken at the first step at or after their time: they do not change the steps. */
bool example_frame_due(double t, double end, int frames, int done);
/* How many of them a run that goes on finds written. */
int example_frames_before(const example_flow *f, double end, int frames);

/* Writes the first `count` probes as CSV into a folder. */
void example_flow_write_series(const example_flow *f, const char *folder, int count,
                               const char *const *files);

/* What every flow has: particles, steps, times, threads, rungs of the interpolator. */
void example_summary_flow(example_summary *summary, const example_flow *f, double wall_seconds);

#endif
