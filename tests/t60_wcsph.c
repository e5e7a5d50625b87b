/* Weakly compressible SPH: symmetries, same bits, no allocation, equations of state, diffusion and
 * viscosity against exact results. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81, pi = 3.14159265358979323846;
static const sph_stepper steppers[] = {SPH_STEPPER_SYMPLECTIC, SPH_STEPPER_VERLET, SPH_STEPPER_RK4};

/* A free drop, disordered, with random velocities and pressures, without gravity. */
static flow_world drop_open(flow_plan plan) {
  plan.dx = plan.dim == 3 ? 0.1 : 0.05;
  plan.c0 = 40;
  flow_world w = flow_open(plan);
  const double lo[3] = {-0.5, -0.4, -0.4}, hi[3] = {0.5, 0.4, 0.4}, none[3] = {0, 0, 0};
  const double far[3] = {1e3, 1e3, 1e3}, near[3] = {-1e3, -1e3, -1e3};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_jitter(&w, 0.2, 11);
  flow_stir(&w, 0.7, 12);
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, none));
  SPH_TEST_OK(w.context, sph_wcsph_set_domain(w.flow, near, far));
  const sph_index n = sph_particles_count(w.water);
  double *p = flow_room(n);
  uint64_t seed = 13;
  for (sph_index i = 0; i < n; i++) p[i] = 3000 * sph_test_random(&seed);
  SPH_TEST_OK(w.context, sph_wcsph_start_from_pressure(w.flow, n, p));
  free(p);
  return w;
}

/* sum m v or sum m a over the particles, in units of sum m |.|; largest component. */
static double total(const flow_world *w, const char *field) {
  double *m = flow_read(w, SPH_MASS), *a = flow_read(w, field), worst = 0;
  for (int d = 0; d < w->dim; d++) {
    double sum = 0, size = 0;
    for (sph_index i = 0; i < sph_particles_count(w->water); i++) {
      sum += m[i] * a[w->dim * i + d];
      size += m[i] * fabs(a[w->dim * i + d]);
    }
    worst = fmax(worst, fabs(sum) / size);
  }
  free(m);
  free(a);
  return worst;
}

static void momentum_is_conserved(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (int k = 0; k < 3; k++)
      for (int tait = 0; tait < 2; tait++) {
        flow_world w = drop_open((flow_plan){.dim = dim, .precision = SPH_PRECISION_DOUBLE});
        SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[k]));
        SPH_TEST_OK(w.context, sph_wcsph_set_laminar_viscosity(w.flow, 1e-3));
        if (tait) SPH_TEST_OK(w.context, sph_wcsph_set_equation_of_state(w.flow, SPH_EOS_TAIT, 7));
        /* Give the drop no momentum, so that what it gains stands out. */
        const sph_index n = sph_particles_count(w.water);
        double *m = flow_read(&w, SPH_MASS), *v = flow_read(&w, SPH_VELOCITY);
        for (int d = 0; d < dim; d++) {
          double sum = 0, mass = 0;
          for (sph_index i = 0; i < n; i++) sum += m[i] * v[dim * i + d], mass += m[i];
          for (sph_index i = 0; i < n; i++) v[dim * i + d] -= sum / mass;
        }
        flow_write(&w, SPH_VELOCITY, v);
        flow_steps(&w, 1);
        SPH_TEST_BELOW(total(&w, "acceleration"), 1e-14);
        flow_steps(&w, dim == 2 ? 30 : 8);
        SPH_TEST_BELOW(total(&w, "acceleration"), 1e-14);
        SPH_TEST_BELOW(total(&w, SPH_VELOCITY), 1e-13);
        free(m);
        free(v);
        flow_free(&w);
      }
}

static void momentum_single(void) {
  flow_world w = drop_open((flow_plan){.dim = 2});
  flow_steps(&w, 31);
  SPH_TEST_BELOW(total(&w, "acceleration"), 1e-7);
  flow_free(&w);
}

static void galilean(void) {
  static const double U[3] = {7, -3, 5};
  for (int k = 0; k < 3; k++)
    for (int dim = 2; dim <= 3; dim++) {
      double *x[2], *v[2], *rho[2], time = 0;
      int64_t size = 0;
      for (int moving = 0; moving < 2; moving++) {
        flow_world w = drop_open((flow_plan){.dim = dim, .precision = SPH_PRECISION_DOUBLE});
        size = (int64_t)sph_particles_count(w.water) * dim;
        SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[k]));
        SPH_TEST_OK(w.context, sph_wcsph_set_laminar_viscosity(w.flow, 1e-3));
        SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 0.4 * w.h / 40));
        v[moving] = flow_read(&w, SPH_VELOCITY);
        for (int64_t i = 0; i < size && moving; i++) v[moving][i] += U[i % dim];
        flow_write(&w, SPH_VELOCITY, v[moving]);
        free(v[moving]);
        flow_steps(&w, dim == 2 ? 40 : 12);
        x[moving] = flow_read(&w, SPH_POSITION);
        v[moving] = flow_read(&w, SPH_VELOCITY);
        rho[moving] = flow_read(&w, SPH_DENSITY);
        time = sph_integrator_time(w.flow);
        flow_free(&w);
      }
      for (int64_t i = 0; i < size; i++) {
        x[1][i] -= time * U[i % dim];
        v[1][i] -= U[i % dim];
      }
      SPH_TEST_BELOW(flow_difference(size, x[0], x[1]), 1e-11);
      SPH_TEST_BELOW(flow_difference(size, v[0], v[1]), 1e-9);
      SPH_TEST_BELOW(flow_difference(size / dim, rho[0], rho[1]) / rho0, 1e-11);
      for (int j = 0; j < 2; j++) free(x[j]), free(v[j]), free(rho[j]);
    }
}

/* Rotated by 90 degrees in the plane of the axes a and b: (a, b) -> (-b, a). */
static void rotate(int64_t vectors, int dim, int a, int b, double *x) {
  for (int64_t i = 0; i < vectors; i++) {
    const double keep = x[dim * i + a];
    x[dim * i + a] = -x[dim * i + b];
    x[dim * i + b] = keep;
  }
}

/* A collapsing column in a tank; the whole of it rotated if `turned`. */
static flow_world turned_tank(int dim, bool turned) {
  flow_world w = flow_open((flow_plan){
      .dim = dim, .dx = dim == 2 ? 0.05 : 0.1, .c0 = 40, .precision = SPH_PRECISION_DOUBLE});
  const double lo[3] = {0, 0, 0}, hi[3] = {0.6, dim == 2 ? 0.8 : 0.6, 0.8};
  double wall_lo[3] = {0, 0, 0}, wall_hi[3] = {1.2, dim == 2 ? 2 : 0.6, 2};
  double gravity[3] = {0, 0, 0};
  gravity[dim - 1] = -g;
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_jitter(&w, 0.1, 21);
  flow_stir(&w, 0.5, 22);
  unsigned open = SPH_SIDE_HI(dim - 1);
  if (turned) { /* the last axis turns into minus the first */
    const sph_index n = sph_particles_count(w.water);
    double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
    rotate(n, dim, 0, dim - 1, x);
    rotate(n, dim, 0, dim - 1, v);
    rotate(1, dim, 0, dim - 1, gravity);
    flow_write(&w, SPH_POSITION, x);
    flow_write(&w, SPH_VELOCITY, v);
    free(x);
    free(v);
    wall_lo[0] = -2;
    wall_hi[0] = 0;
    wall_hi[dim - 1] = 1.2;
    open = SPH_SIDE_LO(0);
  }
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, dim, wall_lo, wall_hi, open, &w.wall));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, gravity));
  return w;
}

static void rotation_changes_nothing(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (int k = 0; k < 3; k++) {
      flow_world a = turned_tank(dim, false), b = turned_tank(dim, true);
      SPH_TEST_OK(a.context, sph_integrator_set_stepper(a.flow, steppers[k]));
      SPH_TEST_OK(b.context, sph_integrator_set_stepper(b.flow, steppers[k]));
      flow_steps(&a, dim == 2 ? 30 : 8);
      flow_steps(&b, dim == 2 ? 30 : 8);
      const sph_index n = sph_particles_count(a.water);
      double *x = flow_read(&a, SPH_POSITION), *y = flow_read(&b, SPH_POSITION);
      double *p = flow_read(&a, SPH_PRESSURE), *q = flow_read(&b, SPH_PRESSURE);
      rotate(n, dim, 0, dim - 1, x);
      SPH_TEST_CLOSE(sph_integrator_time(a.flow), sph_integrator_time(b.flow), 1e-12, 0);
      SPH_TEST_BELOW(flow_difference((int64_t)n * dim, x, y), 1e-11);
      SPH_TEST_BELOW(flow_difference(n, p, q) / flow_largest(n, p), 1e-8);
      free(x);
      free(y);
      free(p);
      free(q);
      flow_free(&a);
      flow_free(&b);
    }
}

typedef struct units {
  double length, mass, time; /* how many of them make a metre, a kilogram, a second */
} units;

static void shake(double t, double *displacement, double *velocity, double *acceleration,
                  void *user) {
  const units *u = user;
  const double omega = 30, amplitude = 0.004, s = t / u->time;
  displacement[0] = amplitude * (1 - cos(omega * s)) * u->length;
  velocity[0] = amplitude * omega * sin(omega * s) * u->length / u->time;
  acceleration[0] = amplitude * omega * omega * cos(omega * s) * u->length / (u->time * u->time);
}

typedef struct figures {
  double *x, *v, *rho, *p, time, energy[4], force[2], pressure, elevation, front, acceleration;
  sph_index n;
} figures;

/* A tank that is shaken, in units of the caller's; results in SI. */
static figures shaken_tank(units u, flow_plan plan, double nu, double gravity,
                           sph_stepper stepper) {
  const double speed = u.length / u.time, density = u.mass / pow(u.length, 3);
  plan.dx = 0.05 * u.length;
  plan.c0 = 40 * speed;
  plan.precision = SPH_PRECISION_DOUBLE;
  flow_world w = flow_open(plan);
  const double lo[2] = {0, 0}, hi[2] = {1 * u.length, 0.5 * u.length},
               top[2] = {1 * u.length, 1 * u.length};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0 * density));
  flow_jitter(&w, 0.1, 5);
  flow_stir(&w, 0.3 * speed, 6);
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, top, SPH_SIDE_HI(1), &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, shake, &u));
  flow_build(&w);
  const double down[2] = {0, -gravity * speed / u.time};
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, down));
  SPH_TEST_OK(w.context, sph_wcsph_set_reference_density(w.flow, rho0 * density));
  SPH_TEST_OK(w.context, sph_wcsph_set_laminar_viscosity(w.flow, nu * u.length * speed));
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, stepper));
  const double gauge[2] = {0.5 * u.length, 0}, up[2] = {0, 1};
  sph_probe *pressure, *elevation, *front;
  SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, gauge, &pressure));
  SPH_TEST_OK(w.context, sph_probe_create_elevation(w.flow, gauge, up, 0.9 * u.length, &elevation));
  SPH_TEST_OK(w.context, sph_probe_create_front(w.flow, 0, 1, &front));
  flow_steps(&w, 40);
  figures f = {.n = sph_particles_count(w.water), .time = sph_integrator_time(w.flow) / u.time};
  f.x = flow_read(&w, SPH_POSITION);
  f.v = flow_read(&w, SPH_VELOCITY);
  f.rho = flow_read(&w, SPH_DENSITY);
  f.p = flow_read(&w, SPH_PRESSURE);
  const double pascal = density * speed * speed;
  for (int64_t i = 0; i < 2 * (int64_t)f.n; i++) f.x[i] /= u.length, f.v[i] /= speed;
  for (sph_index i = 0; i < f.n; i++) f.rho[i] /= density, f.p[i] /= pascal;
  sph_energy e;
  SPH_TEST_OK(w.context, sph_wcsph_get_energy(w.flow, &e));
  const double joule = pascal * u.length * u.length; /* J/m */
  f.energy[0] = e.kinetic / joule;
  f.energy[1] = e.potential / joule;
  f.energy[2] = e.compressible / joule;
  f.energy[3] = e.total / joule;
  SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 0, f.force));
  f.force[0] /= pascal * u.length;
  f.force[1] /= pascal * u.length;
  SPH_TEST_OK(w.context, sph_probe_last(pressure, &f.pressure));
  SPH_TEST_OK(w.context, sph_probe_last(elevation, &f.elevation));
  SPH_TEST_OK(w.context, sph_probe_last(front, &f.front));
  f.pressure /= pascal;
  f.elevation /= u.length;
  f.front /= u.length;
  sph_integrator_stats stats;
  SPH_TEST_OK(w.context, sph_integrator_get_stats(w.flow, &stats));
  f.acceleration = stats.max_acceleration / speed * u.time;
  sph_probe_destroy(&pressure);
  sph_probe_destroy(&elevation);
  sph_probe_destroy(&front);
  flow_free(&w);
  return f;
}

static void compare_figures(figures *a, figures *b) {
  const int64_t n = a->n;
  CU_ASSERT_EQUAL(a->n, b->n);
  SPH_TEST_CLOSE(b->time, a->time, 1e-9, 0);
  SPH_TEST_BELOW(flow_difference(2 * n, a->x, b->x), 1e-10);
  SPH_TEST_BELOW(flow_difference(2 * n, a->v, b->v), 1e-9);
  SPH_TEST_BELOW(flow_difference(n, a->rho, b->rho) / rho0, 1e-10);
  SPH_TEST_BELOW(flow_difference(n, a->p, b->p) / flow_largest(n, a->p), 1e-8);
  for (int k = 0; k < 4; k++)
    SPH_TEST_CLOSE(b->energy[k], a->energy[k], 1e-9, 1e-9 * fabs(a->energy[3]));
  for (int k = 0; k < 2; k++)
    SPH_TEST_CLOSE(b->force[k], a->force[k], 1e-8, 1e-8 * fabs(a->force[1]));
  SPH_TEST_CLOSE(b->pressure, a->pressure, 1e-8, 0);
  SPH_TEST_CLOSE(b->elevation, a->elevation, 1e-8, 0);
  SPH_TEST_CLOSE(b->front, a->front, 1e-9, 0);
  SPH_TEST_CLOSE(b->acceleration, a->acceleration, 1e-8, 0);
  CU_ASSERT(a->elevation > 0.3 && a->front > 0.9 && a->pressure != 0);
  figures *both[] = {a, b};
  for (int k = 0; k < 2; k++)
    free(both[k]->x), free(both[k]->v), free(both[k]->rho), free(both[k]->p);
}

static void units_change_nothing(void) {
  static const units si = {1, 1, 1}, other[] = {{1000, 1000, 1000}, {1e-3, 1e6, 3.6}};
  static const struct {
    double nu, gravity; /* sound, acceleration and viscosity limit the step in turn */
    sph_stepper stepper;
    sph_kernel_type kernel;
    sph_interpolator_type boundary;
  } c[] = {{1e-3, 9.81, SPH_STEPPER_SYMPLECTIC, SPH_KERNEL_GAUSSIAN, SPH_INTERPOLATOR_MLS_LINEAR},
           {0, 9.81, SPH_STEPPER_RK4, SPH_KERNEL_WENDLAND_C2, SPH_INTERPOLATOR_IMPROVED_SHEPARD},
           {0.5, 9.81, SPH_STEPPER_VERLET, SPH_KERNEL_QUINTIC_SPLINE, SPH_INTERPOLATOR_NORMALIZED},
           {0, 5e3, SPH_STEPPER_VERLET, SPH_KERNEL_CUBIC_SPLINE, SPH_INTERPOLATOR_MLS_LINEAR}};
  for (int k = 0; k < 4; k++)
    for (int j = 0; j < 2; j++) {
      const flow_plan plan = {.kernel = c[k].kernel, .boundary = c[k].boundary};
      figures a = shaken_tank(si, plan, c[k].nu, c[k].gravity, c[k].stepper);
      figures b = shaken_tank(other[j], plan, c[k].nu, c[k].gravity, c[k].stepper);
      compare_figures(&a, &b);
    }
}

typedef struct outcome {
  int64_t size; /* of x */
  double *x, *v, *rho;
} outcome;

/* A column that collapses into a tank, optionally watched by probes, a search and reads. */
static outcome collapse(flow_plan plan, sph_stepper stepper, int steps, bool watched) {
  plan.dx = plan.dim == 3 ? 0.1 : 0.04;
  plan.c0 = 40;
  flow_world w = flow_open(plan);
  const int dim = w.dim;
  const double lo[3] = {0, 0, 0}, hi[3] = {0.8, dim == 2 ? 0.8 : 0.6, 0.8};
  const double top[3] = {1.6, dim == 2 ? 2 : 0.6, 2};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_jitter(&w, 0.05, 31);
  flow_stir(&w, 1, 32);
  SPH_TEST_OK(w.context,
              sph_wall_create_box(w.context, dim, lo, top, SPH_SIDE_HI(dim - 1), &w.wall));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_skin(w.flow, 0.02)); /* many builds */
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, stepper));
  sph_probe *probe[5] = {NULL};
  sph_search *search = NULL;
  if (watched) {
    const double at[3] = {0.4, 0, 0}, up[3] = {0, dim == 2, dim == 3};
    SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, at, &probe[0]));
    SPH_TEST_OK(w.context, sph_probe_create_front(w.flow, 0, 1, &probe[1]));
    SPH_TEST_OK(w.context, sph_probe_create_elevation(w.flow, at, up, 1.5, &probe[2]));
    SPH_TEST_OK(w.context, sph_probe_create_energy(w.flow, &probe[3]));
    SPH_TEST_OK(w.context, sph_probe_create_force(w.flow, w.boundary, 0, &probe[4]));
    SPH_TEST_OK(w.context, sph_search_create(w.context, w.water, w.support, &search));
  }
  for (int k = 0; k < steps; k++) {
    flow_steps(&w, 1);
    if (!watched || k % 7) continue;
    int64_t pairs = 0;
    SPH_TEST_OK(w.context, sph_search_update(search));
    SPH_TEST_OK(w.context, sph_search_count_pairs(search, &pairs));
    CU_ASSERT(pairs > 0);
    free(flow_read(&w, SPH_PRESSURE));
    SPH_TEST_OK(w.context, sph_probe_sample(probe[0]));
  }
  outcome o = {.size = (int64_t)sph_particles_count(w.water) * dim};
  o.x = flow_read(&w, SPH_POSITION);
  o.v = flow_read(&w, SPH_VELOCITY);
  o.rho = flow_read(&w, SPH_DENSITY);
  for (int k = 0; k < 5; k++) sph_probe_destroy(&probe[k]);
  sph_search_destroy(&search);
  flow_free(&w);
  return o;
}

static void outcome_free(outcome *o) { free(o->x), free(o->v), free(o->rho); }

static bool same_bits(const outcome *a, const outcome *b, int dim) {
  const size_t bytes = (size_t)a->size * sizeof(double);
  return a->size == b->size && !memcmp(a->x, b->x, bytes) && !memcmp(a->v, b->v, bytes) &&
         !memcmp(a->rho, b->rho, bytes / (size_t)dim);
}

static void threads_change_no_bit(void) {
#ifdef _OPENMP
  /* Few steps: on a busy machine two threads wait for each other. */
  for (int k = 0; k < 3; k++) {
    const int dim = k < 2 ? 2 : 3;
    flow_plan plan = {.dim = dim,
                      .threads = 1,
                      .precision = k == 1 ? SPH_PRECISION_DOUBLE : SPH_PRECISION_SINGLE};
    outcome a = collapse(plan, steppers[k], 4, false);
    plan.threads = 2;
    outcome b = collapse(plan, steppers[k], 4, false);
    CU_ASSERT(same_bits(&a, &b, dim));
    outcome_free(&a);
    outcome_free(&b);
  }
#endif
}

static void watching_changes_no_bit(void) {
  for (int k = 0; k < 4; k++) {
    const int dim = k < 3 ? 2 : 3;
    const flow_plan plan = {.dim = dim};
    outcome a = collapse(plan, steppers[k % 3], 60, false),
            b = collapse(plan, steppers[k % 3], 60, true);
    CU_ASSERT(same_bits(&a, &b, dim));
    outcome_free(&a);
    outcome_free(&b);
  }
}

static bool has_isa(sph_isa isa) {
  sph_context *context = NULL;
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  const bool has = sph_context_set_isa(context, isa) == SPH_OK;
  sph_context_destroy(&context);
  return has;
}

static void instruction_sets_agree(void) {
  for (int dim = 2; dim <= 3; dim++) {
    flow_plan plan = {.dim = dim, .isa = SPH_ISA_BASELINE, .precision = SPH_PRECISION_DOUBLE};
    const int steps = dim == 2 ? 30 : 10;
    outcome oracle = collapse(plan, SPH_STEPPER_SYMPLECTIC, steps, false);
    for (int precision = 0; precision < 2; precision++)
      for (int isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
        if (!has_isa((sph_isa)isa)) continue;
        plan.isa = (sph_isa)isa;
        plan.precision = (sph_precision)precision;
        outcome o = collapse(plan, SPH_STEPPER_SYMPLECTIC, steps, false);
        const double bound = precision ? 1e-11 : 3e-6; /* of a length of 1 m and a speed of 1 m/s */
        SPH_TEST_BELOW(flow_difference(o.size, o.x, oracle.x), bound);
        SPH_TEST_BELOW(flow_difference(o.size, o.v, oracle.v), 100 * bound);
        SPH_TEST_BELOW(flow_difference(o.size / dim, o.rho, oracle.rho) / rho0, bound);
        outcome_free(&o);
      }
    outcome_free(&oracle);
  }
}

static int64_t allocations;

static void *counting_allocate(size_t bytes, void *user) {
  (void)user;
  allocations++;
  return malloc(bytes);
}

static void counting_release(void *memory, void *user) {
  (void)user;
  free(memory);
}

static void steps_allocate_nothing(void) {
  const sph_allocator allocator = {counting_allocate, counting_release, NULL};
  for (int dim = 2; dim <= 3; dim++)
    for (int k = 0; k < 3; k++) {
      flow_world w = flow_open(
          (flow_plan){.dim = dim, .dx = dim == 2 ? 0.05 : 0.1, .c0 = 40, .allocator = &allocator});
      const double lo[3] = {0, 0, 0}, hi[3] = {1, 0.5, 0.5}, top[3] = {1, dim == 2 ? 1 : 0.5, 1};
      SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
      SPH_TEST_OK(w.context,
                  sph_wall_create_box(w.context, dim, lo, top, SPH_SIDE_HI(dim - 1), &w.wall));
      flow_build(&w);
      double slope[3] = {0, 0, 0};
      slope[dim - 1] = -rho0 * g;
      flow_linear_pressure(&w, rho0 * g * 0.5, slope);
      SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[k]));
      SPH_TEST_OK(w.context, sph_wcsph_set_skin(w.flow, 0.002)); /* lists are built often */
      sph_probe *probe;
      SPH_TEST_OK(w.context, sph_probe_create_energy(w.flow, &probe));
      SPH_TEST_OK(w.context, sph_probe_reserve(probe, 100));
      flow_steps(&w, 30);
      sph_integrator_stats before, after;
      SPH_TEST_OK(w.context, sph_integrator_get_stats(w.flow, &before));
      const int64_t warm = allocations;
      flow_steps(&w, 50);
      CU_ASSERT_EQUAL(allocations - warm, 0);
      SPH_TEST_OK(w.context, sph_integrator_get_stats(w.flow, &after));
      CU_ASSERT(after.builds >= before.builds + 3);
      sph_probe_destroy(&probe);
      flow_free(&w);
    }
}

/* p(rho) of the two equations, as published. */
static double law(bool tait, double gamma, double c0, double rho) {
  return tait ? rho0 * c0 * c0 / gamma * (pow(rho / rho0, gamma) - 1) : c0 * c0 * (rho - rho0);
}

static void equations_of_state(void) {
  static const double pressures[] = {-20000, -300, 0, 1e-3, 981, 5886, 2e5};
  enum { N = 7 };
  for (int k = 0; k < 4; k++) {
    const bool tait = k > 0;
    const double gamma = k == 2 ? 1 : k == 3 ? 1.4 : 7, c0 = 30;
    flow_world w = flow_open((flow_plan){.dx = 1, .c0 = c0, .precision = SPH_PRECISION_DOUBLE});
    double x[2 * N], density[N], read[N];
    for (int i = 0; i < N; i++) x[2 * i] = 10.0 * i, x[2 * i + 1] = 0; /* each alone */
    SPH_TEST_OK(w.context, sph_particles_add(w.water, N, x, rho0, NULL));
    flow_build(&w);
    if (tait) SPH_TEST_OK(w.context, sph_wcsph_set_equation_of_state(w.flow, SPH_EOS_TAIT, gamma));
    SPH_TEST_OK(w.context, sph_wcsph_density_of_pressure(w.flow, N, pressures, density));
    for (int i = 0; i < N; i++)
      SPH_TEST_CLOSE(law(tait, gamma, c0, density[i]), pressures[i], 1e-11, 1e-8);
    SPH_TEST_OK(w.context, sph_wcsph_start_from_pressure(w.flow, N, pressures));
    SPH_TEST_OK(w.context, sph_particles_read(w.water, SPH_DENSITY, read, N));
    for (int i = 0; i < N; i++) CU_ASSERT_EQUAL(read[i], density[i]);
    SPH_TEST_OK(w.context, sph_particles_read(w.water, SPH_MASS, read, N));
    for (int i = 0; i < N; i++)
      SPH_TEST_CLOSE(read[i], density[i] * 1 * 1, 1e-15, 0); /* volume dx^2 */
    /* Compressible energy is the work from rho0 on: int p / rho^2 d rho, by Simpson's rule. */
    double work = 0;
    for (int i = 0; i < N; i++) {
      enum { CUTS = 400 };
      const double step = (density[i] - rho0) / CUTS;
      for (int j = 0; j <= CUTS; j++) {
        const double rho = rho0 + j * step, weight = j == 0 || j == CUTS ? 1 : j % 2 ? 4 : 2;
        work += density[i] * weight * step / 3 * law(tait, gamma, c0, rho) / (rho * rho);
      }
    }
    sph_energy e;
    SPH_TEST_OK(w.context, sph_wcsph_get_energy(w.flow, &e));
    SPH_TEST_CLOSE(e.compressible, work, 1e-9, 0);
    CU_ASSERT_EQUAL(e.kinetic, 0);
    SPH_TEST_CLOSE(e.total, e.kinetic + e.potential + e.compressible, 1e-15, 0);
    /* The flow gives the pressures back; but a lone particle bears no tension. */
    flow_evaluate(&w);
    SPH_TEST_OK(w.context, sph_particles_read(w.water, SPH_PRESSURE, read, N));
    for (int i = 0; i < N; i++) SPH_TEST_CLOSE(read[i], fmax(pressures[i], 0), 1e-11, 1e-8);
    const double none = -1.001 * rho0 * c0 * c0 / (tait ? gamma : 1);
    SPH_TEST_STATUS(w.context, sph_wcsph_density_of_pressure(w.flow, 1, &none, read),
                    SPH_E_ARGUMENT, "no density gives pressure");
    flow_free(&w);
  }
}

static void energies_are_sums(void) {
  flow_world w = drop_open((flow_plan){.dim = 3});
  const double gravity[3] = {1.5, -2.5, -9};
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, gravity));
  double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY),
         *m = flow_read(&w, SPH_MASS);
  double kinetic = 0, potential = 0;
  for (sph_index i = 0; i < sph_particles_count(w.water); i++)
    for (int d = 0; d < 3; d++) {
      kinetic += 0.5 * m[i] * v[3 * i + d] * v[3 * i + d];
      potential -= m[i] * gravity[d] * x[3 * i + d];
    }
  sph_energy e;
  SPH_TEST_OK(w.context, sph_wcsph_get_energy(w.flow, &e));
  SPH_TEST_CLOSE(e.kinetic, kinetic, 1e-12, 0);
  SPH_TEST_CLOSE(e.potential, potential, 1e-9, 0);
  free(x);
  free(v);
  free(m);
  flow_free(&w);
}

/* A periodic box of 1 x 1 with N x N particles at rest; density rho0 (1 + epsilon cos kx). */
static flow_world wave_box(int N, double epsilon, double *amplitude_k) {
  flow_world w = flow_open((flow_plan){.dx = 1.0 / N, .c0 = 40, .precision = SPH_PRECISION_DOUBLE});
  const double lo[2] = {0, 0}, hi[2] = {1, 1}, none[2] = {0, 0}, k = 2 * pi;
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  flow_build(&w);
  for (int d = 0; d < 2; d++) SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, d, 0, 1));
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, none));
  const sph_index n = sph_particles_count(w.water);
  double *x = flow_read(&w, SPH_POSITION), *p = flow_room(n);
  for (sph_index i = 0; i < n; i++) p[i] = 1600 * rho0 * epsilon * cos(k * x[2 * i]);
  SPH_TEST_OK(w.context, sph_wcsph_start_from_pressure(w.flow, n, p));
  *amplitude_k = k;
  free(x);
  free(p);
  return w;
}

/* Component of (after - before)/dt along cos kx, and the rest. */
static double project(sph_index n, const double *x, double k, double dt, const double *before,
                      const double *after, int stride, double *sum) {
  double along = 0;
  *sum = 0;
  for (sph_index i = 0; i < n; i++) {
    const double rate = (after[stride * i] - before[stride * i]) / dt;
    along += 2 * rate * cos(k * x[2 * i]) / n;
    *sum += rate / n;
  }
  return along;
}

static void diffusion_has_its_rate(void) {
  const double epsilon = 1e-3, dt = 1e-6, delta = 0.1;
  double rate[3], expected[3];
  for (int kind = SPH_DIFFUSION_NONE; kind <= SPH_DIFFUSION_DELTA; kind++) {
    double k, sum;
    flow_world w = wave_box(24, epsilon, &k);
    SPH_TEST_OK(w.context, sph_wcsph_set_diffusion(w.flow, (sph_diffusion)kind, delta));
    SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_SYMPLECTIC));
    SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
    double *x = flow_read(&w, SPH_POSITION), *before = flow_read(&w, SPH_DENSITY);
    flow_steps(&w, 1);
    double *after = flow_read(&w, SPH_DENSITY);
    rate[kind] = project(sph_particles_count(w.water), x, k, dt, before, after, 1, &sum);
    SPH_TEST_CLOSE(sum, 0, 0,
                   1e-6); /* density is moved, not made: by volume, as volumes are equal */
    /* The Gaussian's response to a wave: -k^2 without gradients, -k^4 h^2 3/8 with them. */
    const double s = pow(k * w.h, 2) / 4, scale = delta * w.h * 40 * rho0 * epsilon;
    expected[SPH_DIFFUSION_NONE] = 0;
    expected[SPH_DIFFUSION_MOLTENI] = -scale * 4 / (w.h * w.h) * (1 - exp(-s));
    expected[SPH_DIFFUSION_DELTA] = expected[SPH_DIFFUSION_MOLTENI] + scale * k * k * exp(-2 * s);
    free(x);
    free(before);
    free(after);
    flow_free(&w);
  }
  CU_ASSERT_EQUAL(rate[SPH_DIFFUSION_NONE], 0);
  SPH_TEST_CLOSE(rate[SPH_DIFFUSION_MOLTENI], expected[SPH_DIFFUSION_MOLTENI], 0.01, 0);
  SPH_TEST_CLOSE(rate[SPH_DIFFUSION_DELTA], expected[SPH_DIFFUSION_DELTA], 0.1, 0);
  CU_ASSERT(rate[SPH_DIFFUSION_DELTA] < 0);
}

/* Tension stays where the fluid holds together, and goes where nothing does. */
static void tension_needs_company(void) {
  double k;
  flow_world w = wave_box(16, 1e-3, &k);
  double *before = flow_read(&w, SPH_DENSITY);
  flow_evaluate(&w);
  double *after = flow_read(&w, SPH_DENSITY);
  const sph_index n = sph_particles_count(w.water);
  CU_ASSERT_EQUAL(memcmp(before, after, (size_t)n * sizeof *before), 0);
  double least = rho0;
  for (sph_index i = 0; i < n; i++) least = fmin(least, after[i]);
  CU_ASSERT(least < 0.9995 * rho0);
  free(before);
  free(after);
  flow_free(&w);
  /* Two drops: a pair of particles, one compressed; a block, of which the corners are the least held. */
  w = flow_open((flow_plan){.dx = 0.1, .c0 = 40});
  const double lo[2] = {0, 0}, hi[2] = {1, 1}, pair[4] = {3, 0, 3.1, 0};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_particles_add(w.water, 2, pair, rho0, NULL));
  flow_build(&w);
  double p[102];
  for (int i = 0; i < 102; i++) p[i] = i == 101 ? 500 : -500;
  SPH_TEST_OK(w.context, sph_wcsph_start_from_pressure(w.flow, 102, p));
  flow_evaluate(&w);
  double *pressure = flow_read(&w, SPH_PRESSURE);
  SPH_TEST_CLOSE(pressure[100], 0, 0, 1e-6);
  SPH_TEST_CLOSE(pressure[101], 500, 1e-9, 0);
  SPH_TEST_CLOSE(pressure[55], -500, 1e-9, 0); /* inside the block */
  SPH_TEST_CLOSE(pressure[50], -500, 1e-9, 0); /* at its plane surface */
  free(pressure);
  flow_free(&w);
}

/* With renormalised gradients a linear density does not diffuse, pair by pair, surface or not. */
static void linear_density_stays(void) {
  double largest[3];
  for (int dim = 2; dim <= 3; dim++) {
    for (int kind = SPH_DIFFUSION_MOLTENI; kind <= SPH_DIFFUSION_DELTA; kind++) {
      flow_world w = drop_open((flow_plan){.dim = dim, .precision = SPH_PRECISION_DOUBLE});
      flow_stir(&w, 0, 1);
      const double slope[3] = {1000, -3000, 500}, dt = 1e-6;
      flow_linear_pressure(&w, 3000, slope);
      SPH_TEST_OK(w.context, sph_wcsph_set_diffusion(w.flow, (sph_diffusion)kind, 0.1));
      SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, SPH_STEPPER_SYMPLECTIC));
      SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
      double *before = flow_read(&w, SPH_DENSITY);
      flow_steps(&w, 1);
      double *after = flow_read(&w, SPH_DENSITY);
      largest[kind] = flow_difference(sph_particles_count(w.water), before, after) / dt;
      free(before);
      free(after);
      flow_free(&w);
    }
    CU_ASSERT(largest[SPH_DIFFUSION_MOLTENI] > 0.1);
    SPH_TEST_BELOW(largest[SPH_DIFFUSION_DELTA], 1e-6);
  }
}

/* A shear wave u_y = U cos kx in a box at rest decays with -nu k^2. */
static void viscosity_has_its_rate(void) {
  static const double U = 0.1, dt = 1e-6;
  for (int laminar = 0; laminar < 2; laminar++)
    for (int j = 0; j < 3; j++) {
      double k, sum;
      flow_world w = wave_box(24, 0, &k);
      const double nu = laminar ? 0.01 : 0.02 * w.h * 40 / 8;
      SPH_TEST_OK(w.context, sph_wcsph_set_artificial_viscosity(w.flow, laminar ? 0 : 0.02));
      SPH_TEST_OK(w.context, sph_wcsph_set_laminar_viscosity(w.flow, laminar ? nu : 0));
      SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[j]));
      SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, dt));
      const sph_index n = sph_particles_count(w.water);
      double *x = flow_read(&w, SPH_POSITION), *before = flow_room(2 * (int64_t)n);
      for (sph_index i = 0; i < n; i++) before[2 * i + 1] = U * cos(k * x[2 * i]);
      flow_write(&w, SPH_VELOCITY, before);
      flow_steps(&w, 1);
      double *after = flow_read(&w, SPH_VELOCITY);
      const double rate = project(n, x, k, dt, before + 1, after + 1, 2, &sum);
      SPH_TEST_CLOSE(rate, -nu * k * k * U, 0.08, 0); /* 0.117/0.125 on this lattice, and k h */
      SPH_TEST_CLOSE(sum, 0, 0, 1e-9);
      free(x);
      free(before);
      free(after);
      flow_free(&w);
    }
}

/* A free drop across the seam of a periodic box moves as it does in the middle. */
static void periodic_seam_is_seamless(void) {
  double *y[2], *u[2];
  int64_t size = 0;
  for (int seam = 0; seam < 2; seam++) {
    flow_world w = drop_open((flow_plan){.dim = 2, .precision = SPH_PRECISION_DOUBLE});
    size = 2 * (int64_t)sph_particles_count(w.water);
    double *x = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
    for (int64_t i = 0; i < size; i++) {
      x[i] += i % 2 == 0 && seam ? 1.5 : 0;
      v[i] += i % 2 == 0 ? 2 : 0;
    }
    flow_write(&w, SPH_POSITION, x);
    flow_write(&w, SPH_VELOCITY, v);
    SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, 0, -2, 2));
    SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 8e-4));
    flow_steps(&w, 60);
    y[seam] = flow_read(&w, SPH_POSITION);
    u[seam] = flow_read(&w, SPH_VELOCITY);
    for (int64_t i = 0; i < size; i += 2) {
      CU_ASSERT(y[seam][i] >= -2.1 && y[seam][i] < 2.1);
      if (seam && y[seam][i] < 0) y[seam][i] += 4;
      if (seam) y[seam][i] -= 1.5;
    }
    free(x);
    free(v);
    flow_free(&w);
  }
  SPH_TEST_BELOW(flow_difference(size, y[0], y[1]), 1e-11);
  SPH_TEST_BELOW(flow_difference(size, u[0], u[1]), 1e-9);
  for (int j = 0; j < 2; j++) free(y[j]), free(u[j]);
}

/* Twice the support is the least a period may be; speed must not make the lists reach around it. */
static void least_period(void) {
  for (int k = 0; k < 3; k++) {
    double *x[2], time = 0;
    int64_t size = 0;
    static const double U[2] = {12, -9};
    for (int moving = 0; moving < 2; moving++) {
      const double dx = 0.05, skin = 0.01, none[2] = {0, 0}, lo[2] = {0, 0};
      flow_world w = flow_open((flow_plan){.dx = dx,
                                           .c0 = 40,
                                           .kernel = SPH_KERNEL_WENDLAND_C2,
                                           .ratio = 1.98,
                                           .precision = SPH_PRECISION_DOUBLE});
      const double hi[2] = {8 * dx, 8 * dx};
      SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
      flow_jitter(&w, 0.2, 3);
      flow_stir(&w, 0.5, 4);
      flow_build(&w);
      SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, none));
      SPH_TEST_OK(w.context, sph_wcsph_set_skin(w.flow, skin));
      for (int d = 0; d < 2; d++)
        SPH_TEST_OK(w.context, sph_wcsph_set_periodic(w.flow, d, 0, hi[d]));
      SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, steppers[k]));
      SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 0.5 * sph_integrator_stable_dt(w.flow)));
      size = 2 * (int64_t)sph_particles_count(w.water);
      double *v = flow_read(&w, SPH_VELOCITY);
      for (int64_t i = 0; i < size && moving; i++) v[i] += U[i % 2];
      flow_write(&w, SPH_VELOCITY, v);
      free(v);
      flow_steps(&w, 30);
      time = sph_integrator_time(w.flow);
      x[moving] = flow_read(&w, SPH_POSITION);
      flow_free(&w);
    }
    double worst = 0;
    for (int64_t i = 0; i < size; i++) {
      const double apart = x[1][i] - x[0][i] - time * U[i % 2];
      worst = fmax(worst, fabs(remainder(apart, 0.4)));
    }
    SPH_TEST_BELOW(worst, 1e-11);
    free(x[0]);
    free(x[1]);
  }
}

SPH_TEST_MAIN("wcsph", {"pairs conserve momentum to round-off", momentum_is_conserved},
              {"and in single precision to its round-off", momentum_single},
              {"a drop moves alike at any constant velocity", galilean},
              {"turned by 90 degrees everything turns along", rotation_changes_nothing},
              {"mm, g, ms give the flow of m, kg, s", units_change_nothing},
              {"1 and 2 threads give the same bits", threads_change_no_bit},
              {"probes, searches and reads change no bit", watching_changes_no_bit},
              {"instruction sets and precisions agree to rounding", instruction_sets_agree},
              {"steps allocate nothing once warm", steps_allocate_nothing},
              {"equations of state invert, and store the work they took", equations_of_state},
              {"energies are the sums over the particles", energies_are_sums},
              {"density diffuses at the analytic rate", diffusion_has_its_rate},
              {"tension goes where nothing holds it", tension_needs_company},
              {"a linear density does not diffuse", linear_density_stays},
              {"viscosity damps shear at the analytic rate", viscosity_has_its_rate},
              {"nothing happens at the seam of a periodic box", periodic_seam_is_seamless},
              {"the least period serves at any speed", least_period})
