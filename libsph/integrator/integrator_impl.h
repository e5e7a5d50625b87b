/* Integrators from the inside: what a method provides, and what measures may use of a flow. */
#ifndef SPHI_INTEGRATOR_IMPL_H
#define SPHI_INTEGRATOR_IMPL_H

#include <sph/integrator.h>

#include "boundary/boundary_impl.h"
#include "core/keep.h"
#include "particles/particles_impl.h"

struct sph_energy;

/* What is around the fluid, for measures that must know. */
typedef struct sphi_surroundings {
  const sph_boundary *boundary; /* NULL: no walls */
  bool periodic[SPHI_MAX_DIM];
  bool bounded; /* lo and hi are known; in periodic directions they mean nothing */
  double lo[SPHI_MAX_DIM], hi[SPHI_MAX_DIM];
} sphi_surroundings;

/* Velocities go down at `rate` times the square of the way from `from` to `to`, 0 to 1. */
typedef struct sphi_damping_zone {
  int axis;
  double from, to, rate;
} sphi_damping_zone;

enum { SPHI_ZONES = 16 };

/* What particle methods have in common: the fluid's surroundings and its lists. */
typedef struct sphi_cloud {
  sph_boundary *boundary; /* NULL: no walls */
  sphi_list ghost_list;
  void *ghost_record; /* scratch: those of one wall's ghosts */
  int64_t ghost_record_capacity;
  void *reaction[SPHI_MAX_DIM]; /* scratch: of the same */
  int64_t reaction_capacity[SPHI_MAX_DIM];
  double rho0, skin;
  sphi_body_force force;
  bool periodic[SPHI_MAX_DIM];
  double periodic_lo[SPHI_MAX_DIM], periodic_hi[SPHI_MAX_DIM];
  int zones;
  sphi_damping_zone zone[SPHI_ZONES];
  bool domain_given;
  double domain_lo[SPHI_MAX_DIM], domain_hi[SPHI_MAX_DIM];
  float *clear; /* by rank: no wall was nearer than clear - odometer [m]; 0: not known */
  int64_t clear_capacity;
  double
      odometer; /* how far apart or together particles and walls may have come since clear was 0 [m] */
  int acceleration; /* number of that field */
  bool prepared;    /* the boundary's arrays are there */
  bool stale;       /* lists are to be made anew, walls sorted, as after a checkpoint */
  bool packed;      /* records hold the state now */
  double travel;    /* how far a particle or wall may come in the step at hand [m] */
  double travelled; /* how far a particle or wall may have come since the lists were built [m] */
} sphi_cloud;

/* A particle method: one table a method, at the end of its file. */
typedef struct sphi_method {
  const char *name;
  /* Everything up to date for the state now: lists, records, pressure. Called before the first step
   * and before anything is measured. */
  sph_status (*refresh)(sph_integrator *flow);
  /* Time step the limits allow now, and which limit; 0 if it cannot be told. */
  double (*limit)(const sph_integrator *flow, sph_limiter *limiter);
  sph_status (*step)(sph_integrator *flow, double dt);
  double
      courant; /* the default of methods that have one stepper, their own; 0: steppers have theirs */
  /* Largest stable courant number c0 dt / h of a stepper on a lattice, and the step of one. */
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
  /* Of methods whose particles have no neighbours to interpolate from: at points [n, dim] the pressure [n], velocity
   * [n, dim] and share of the heavier fluid [n], each may be NULL; 0 where there is no flow. */
  sph_status (*evaluate)(sph_integrator *flow, int64_t n, const double *x, double *pressure,
                         double *velocity, double *filling);
  /* What a checkpoint keeps besides the run, the particles and their cloud. */
  sph_status (*keep)(sph_integrator *flow, sphi_keep *keep);
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
  sphi_cloud cloud;
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

/* For methods: checks what the caller gave and makes the common part with it. */
sph_status sphi_cloud_create(sph_context *context, const sphi_method *method, sph_kernel *kernel,
                             sph_particles *particles, sph_boundary *boundary,
                             sph_integrator **out);
void sphi_cloud_free(sph_integrator *flow);
/* Settings behind those of the methods, which see that the integrator is theirs. */
sph_status sphi_integrator_check_method(const sph_integrator *flow, const sphi_method *method);
sph_status sphi_cloud_set_reference_density(sph_integrator *flow, double density);
sph_status sphi_cloud_set_gravity(sph_integrator *flow, const double *gravity);
sph_status sphi_cloud_set_body_force(sph_integrator *flow, sph_body_force function, void *user);
sph_status sphi_cloud_set_periodic(sph_integrator *flow, int axis, double lo, double hi);
sph_status sphi_cloud_set_domain(sph_integrator *flow, const double *lo, const double *hi);
sph_status sphi_cloud_add_damping_zone(sph_integrator *flow, int axis, double from, double to,
                                       double rate);
sph_status sphi_cloud_set_skin(sph_integrator *flow, double skin);
void sphi_cloud_pressure_gradient(const sph_integrator *flow, const double *x,
                                  const double *acceleration, double *gradient);
void sphi_cloud_surroundings(const sph_integrator *flow, sphi_surroundings *out);

/* What a checkpoint keeps of walls, frame and domain. */
sph_status sphi_cloud_keep(sph_integrator *flow, sphi_keep *keep);
/* Frame, walls and lists for particles that the caller gave or changed, whose arrays the method has made. */
sph_status sphi_cloud_prepare(sph_integrator *flow);
/* Sorts and lists everything for the positions now. */
sph_status sphi_cloud_build(sph_integrator *flow);
/* Whether lists hold for another step. */
bool sphi_cloud_reaches(const sph_integrator *flow);
/* Walls and ghosts as they are at time t, by the fluid's records; ahead as of sphi_boundary_update. */
sph_status sphi_cloud_update_ghosts(sph_integrator *flow, double t, double ahead);
/* An operator over fluid and ghosts. */
void sphi_cloud_sweep(sph_integrator *flow, int operator_index, const void *arguments);
/* Takes from velocities what damping zones do in a step. An exponential never turns them, however long the
 * step; accelerations stay, since pressures do not know of velocities. */
void sphi_cloud_damp(sph_integrator *flow, double dt);
/* How far a particle or wall may come in a time step; then that it was done. */
double sphi_cloud_travel_in(const sph_integrator *flow, double dt);
void sphi_cloud_has_moved(sph_integrator *flow, double dt);
/* Speed of the fastest wall now. */
double sphi_cloud_wall_speed(const sph_integrator *flow);
/* op_rates: pressure and divergence together, without diffusive terms. */
typedef struct sphi_rates_arguments {
  void *acceleration[3];
  void *divergence;
  const void *record; /* of the targets */
  const double *m;    /* [n] */
} sphi_rates_arguments;

/* op_reaction, over ghosts alone; arrays have the reals of the variant: the ghosts' pressure term. */
typedef struct sphi_reaction_arguments {
  void *force[3]; /* [n] on the ghosts */
} sphi_reaction_arguments;

/* Force on a wall by the pressures of its ghosts of the last evaluation and of the fluid now. */
sph_status sphi_cloud_read_reaction(sph_integrator *flow, int wall, double *force);
/* The walls and particles fit together: nothing inside a wall, no open end under water. */
sph_status sphi_cloud_check_walls(sph_integrator *flow);
/* Particles that touch a wall lose the speed at which they approach it, and faster ones what would carry
 * them through it within dt: jets thinner than the support would otherwise pass between ghosts. Those that
 * came a little way in all the same are put back; one that is deeper inside has crossed, which is an
 * error. */
sph_status sphi_cloud_stop_at_walls(sph_integrator *flow, double dt);
/* SPH_E_DIVERGED with what is wrong with particle i, by storage order, after a step dt. */
sph_status sphi_cloud_report(const sph_integrator *flow, int32_t i, double dt);
/* After particles or walls came elsewhere otherwise than by steps. */
void sphi_cloud_forget_walls(sph_integrator *flow);

#endif
