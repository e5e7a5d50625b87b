/* Integrators from the inside: what a method provides, and what measures may use of a flow. */
#ifndef SPHI_INTEGRATOR_IMPL_H
#define SPHI_INTEGRATOR_IMPL_H

#include <sph/integrator.h>

#include "interpolator/gather_impl.h"
#include "particles/particles_impl.h"

struct sph_energy;

/* What is around the fluid, for measures that must know. */
typedef struct sphi_surroundings {
  const sph_boundary *boundary; /* NULL: no walls */
  bool periodic[SPHI_MAX_DIM];
  bool bounded; /* lo and hi are known; in periodic directions they mean nothing */
  double lo[SPHI_MAX_DIM], hi[SPHI_MAX_DIM];
} sphi_surroundings;

/* A particle method: one table a method, at the end of its file. */
typedef struct sphi_method {
  const char *name;
  /* Everything up to date for the state now: lists, records, pressure. Called before the first step
   * and before anything is measured. */
  sph_status (*refresh)(sph_integrator *flow);
  /* Time step the limits allow now, and which limit; 0 if it cannot be told. */
  double (*limit)(const sph_integrator *flow, sph_limiter *limiter);
  sph_status (*step)(sph_integrator *flow, double dt);
  /* Largest stable courant number c0 dt / h of a stepper on a lattice, and the default one. */
  double (*stable_courant)(const sph_integrator *flow, sph_stepper stepper);
  double (*stable_dt)(const sph_integrator *flow, double courant);
  void (*destroy)(sph_integrator *flow);
  /* For measures, each may be NULL. Gradient of pressure in fluid that accelerates all alike, rho0 times
   * the body force at x now less the acceleration; the zeroed surroundings are filled in; energies now; what
   * the ghosts of a wall take from the fluid's momentum. */
  void (*pressure_gradient)(const sph_integrator *flow, const double *x, const double *acceleration,
                            double *gradient);
  void (*surroundings)(const sph_integrator *flow, sphi_surroundings *out);
  sph_status (*energy)(const sph_integrator *flow, struct sph_energy *energy);
  sph_status (*reaction)(sph_integrator *flow, int wall, double *force);
} sphi_method;

/* Called after every step; an error stops the run. Observers are called in the order of adding. */
typedef sph_status (*sphi_observe)(void *observer, sph_integrator *flow);

enum { SPHI_MAX_OBSERVERS = 256 };

struct sph_integrator {
  sph_context *context;
  int references;
  const sphi_method *method;
  void *data; /* the method's own */
  sph_stepper stepper;
  double fixed_dt; /* 0: follow the limits */
  double courant;  /* 0: the stepper's default */
  double end;      /* HUGE_VAL, or where sph_integrator_advance goes */
  sph_integrator_stats stats;
  int observers;
  void *observer[SPHI_MAX_OBSERVERS];
  sphi_observe observe[SPHI_MAX_OBSERVERS];

  /* The cloud of fluid particles, kept by particle methods and read by measures. */
  sph_particles *particles;
  sph_kernel *kernel;
  const sphi_variant *variant;
  sphi_frame frame;
  sphi_columns columns; /* of the particles, which are stored in its order */
  sphi_clusters clusters;
  sphi_list list;
  void *record; /* fluid records, SPHI_RECORD(dim) reals each */
  int64_t record_capacity;
  double list_radius; /* support + skin */
  int64_t revision;   /* of the particles when the lists were built; -1: never */
};

void sphi_integrator_retain(sph_integrator *flow);
/* For methods: the common part, on which the method then sets data; stepper rk4. */
sph_status sphi_integrator_create(sph_context *context, const sphi_method *method,
                                  sph_particles *particles, sph_kernel *kernel,
                                  sph_integrator **out);
sph_status sphi_integrator_observe(sph_integrator *flow, sphi_observe observe, void *observer);
void sphi_integrator_forget(sph_integrator *flow, void *observer);
/* The caller's courant number, or the stepper's default for the kernel. */
double sphi_integrator_courant(const sph_integrator *flow);

/* Sorts the particles into columns and storage order, wraps periodic positions, cuts clusters, lists
 * the pairs. Timed as sort and search; counts a build. */
sph_status sphi_integrator_build(sph_integrator *flow, double radius);

/* Interpolates pressure and velocity at a gather's points from the fluid as it is now; sorts and
 * lists anew when *build is not the present build. Results as sphi_gather_evaluate. */
sph_status sphi_integrator_gather(sph_integrator *flow, sphi_gather *gather,
                                  const sph_interpolator *interpolator, int64_t *build);

#endif
