/* Probes on water at rest, whose pressure, forces, surface and energies are known. */
#define _POSIX_C_SOURCE 200809L
#include <stdint.h>
#include <unistd.h>

#include "sph_test.h"

static const double rho0 = 1000, g = 9.81, c0 = 40;
static const double width = 1, depth = 0.5, dx = 0.025;

typedef struct tank {
  int dim;
  sph_context *context;
  sph_kernel *kernel;
  sph_interpolator *interpolator;
  sph_wall *wall;
  sph_boundary *boundary;
  sph_particles *water;
  sph_integrator *flow;
} tank;

static int64_t allocations, allocations_left;

static void *counting_allocate(size_t bytes, void *user) {
  (void)user;
  if (allocations_left == 0) return NULL;
  allocations_left--;
  allocations++;
  return malloc(bytes);
}

static void counting_release(void *memory, void *user) {
  (void)user;
  free(memory);
}

/* Pressure of the test's state: linear in depth. */
static void set_pressure(tank *t, double slope_x, double slope_z, double constant) {
  const sph_index n = sph_particles_count(t->water);
  double *x = malloc((size_t)n * (size_t)t->dim * sizeof *x), *p = malloc((size_t)n * sizeof *p);
  SPH_TEST_OK(t->context, sph_particles_read(t->water, SPH_POSITION, x, (int64_t)n * t->dim));
  for (sph_index k = 0; k < n; k++)
    p[k] = constant + slope_x * x[t->dim * k] + slope_z * x[t->dim * k + t->dim - 1];
  SPH_TEST_OK(t->context, sph_wcsph_start_from_pressure(t->flow, n, p));
  free(x);
  free(p);
}

static void tank_start(tank *t, int dim) {
  *t = (tank){.dim = dim};
  const sph_allocator allocator = {counting_allocate, counting_release, NULL};
  allocations_left = INT64_MAX;
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &t->context) == SPH_OK);
  const double spacing = dim == 2 ? dx : 2 * dx;
  const double lo[3] = {0, 0, 0};
  const double hi[3] = {width, dim == 2 ? depth : 0.4, depth},
               top[3] = {width, dim == 2 ? 1 : 0.4, 1};
  SPH_TEST_OK(t->context, sph_kernel_create(t->context, SPH_KERNEL_WENDLAND_C2, dim, 1.5 * spacing,
                                            &t->kernel));
  SPH_TEST_OK(t->context, sph_interpolator_create(t->context, SPH_INTERPOLATOR_MLS_LINEAR,
                                                  t->kernel, &t->interpolator));
  SPH_TEST_OK(t->context,
              sph_wall_create_box(t->context, dim, lo, top, SPH_SIDE_HI(dim - 1), &t->wall));
  SPH_TEST_OK(t->context,
              sph_boundary_create(t->context, t->wall, spacing, t->interpolator, &t->boundary));
  SPH_TEST_OK(t->context, sph_particles_create(t->context, dim, spacing, &t->water));
  SPH_TEST_OK(t->context, sph_particles_fill_box(t->water, lo, hi, rho0));
  SPH_TEST_OK(t->context, sph_wcsph_create(t->context, t->kernel, t->water, t->boundary, &t->flow));
  SPH_TEST_OK(t->context, sph_wcsph_set_sound_speed(t->flow, c0));
  set_pressure(t, 0, -rho0 * g, rho0 * g * depth);
}

static void tank_stop(tank *t) {
  sph_integrator_destroy(&t->flow);
  sph_particles_destroy(&t->water);
  sph_boundary_destroy(&t->boundary);
  sph_wall_destroy(&t->wall);
  sph_interpolator_destroy(&t->interpolator);
  sph_kernel_destroy(&t->kernel);
  sph_context_destroy(&t->context);
}

/* The one value of a probe now. */
static double sample(tank *t, sph_probe *probe) {
  double values[8] = {0};
  SPH_TEST_OK(t->context, sph_probe_sample(probe));
  SPH_TEST_OK(t->context, sph_probe_last(probe, values));
  return values[0];
}

static void pressure_is_exact_when_linear(void) {
  for (int dim = 2; dim <= 3; dim++) {
    tank t;
    tank_start(&t, dim);
    /* On the wall, in corners, inside, and just below the surface. */
    const double places[][3] = {{0, 0.2, 0.1},   {0, 0, 0},         {width, 0, 0},
                                {0.5, 0.2, 0},   {0.53, 0.1, 0.31}, {width, 0.4, 0.25},
                                {0.3, 0.2, 0.49}};
    for (int k = 0; k < 7; k++) {
      const double *x = places[k];
      const double at[3] = {x[0], dim == 2 ? x[2] : x[1], x[2]};
      sph_probe *probe;
      SPH_TEST_OK(t.context, sph_probe_create_pressure(t.flow, at, &probe));
      SPH_TEST_CLOSE(sample(&t, probe), rho0 * g * (depth - x[2]), 0, 1e-3 * rho0 * g * depth);
      sph_probe_destroy(&probe);
    }
    tank_stop(&t);
  }
}

static void pressure_is_zero_without_fluid(void) {
  tank t;
  tank_start(&t, 2);
  const double dry[2] = {0, 0.9}, thin[2] = {0.5, depth + 2.2 * dx};
  sph_probe *probe;
  SPH_TEST_OK(t.context, sph_probe_create_pressure(t.flow, dry, &probe));
  SPH_TEST_CLOSE(sample(&t, probe), 0, 0, 0);
  sph_probe_destroy(&probe);
  SPH_TEST_OK(t.context, sph_probe_create_pressure(t.flow, thin, &probe));
  SPH_TEST_CLOSE(sample(&t, probe), 0, 0, 0);
  sph_probe_destroy(&probe);
  SPH_TEST_OK(t.context, sph_probe_create_velocity(t.flow, dry, &probe));
  SPH_TEST_CLOSE(sample(&t, probe), 0, 0, 0);
  sph_probe_destroy(&probe);
  tank_stop(&t);
}

/* Three particles do not carry a linear interpolation: Shepard's weighted mean remains. */
static void pressure_of_few_particles_has_the_hydrostatic_gradient(void) {
  sph_context *context;
  sph_kernel *kernel;
  sph_particles *water;
  sph_integrator *flow;
  sph_probe *probe;
  SPH_TEST_OK(NULL, sph_context_create(&context));
  SPH_TEST_OK(context, sph_kernel_create(context, SPH_KERNEL_WENDLAND_C2, 2, 1.5 * dx, &kernel));
  SPH_TEST_OK(context, sph_particles_create(context, 2, dx, &water));
  const double x[] = {0, 0, dx, 0.2 * dx, 0.4 * dx, dx};
  SPH_TEST_OK(context, sph_particles_add(water, 3, x, rho0, NULL));
  SPH_TEST_OK(context, sph_wcsph_create(context, kernel, water, NULL, &flow));
  SPH_TEST_OK(context, sph_wcsph_set_sound_speed(flow, c0));
  double p[3];
  for (int k = 0; k < 3; k++) p[k] = 5000 - rho0 * g * x[2 * k + 1];
  SPH_TEST_OK(context, sph_wcsph_start_from_pressure(flow, 3, p));
  const double at[2] = {0.3 * dx, 0.5 * dx};
  SPH_TEST_OK(context, sph_probe_create_pressure(flow, at, &probe));
  SPH_TEST_OK(context, sph_probe_sample(probe));
  double value = 0;
  SPH_TEST_OK(context, sph_probe_last(probe, &value));
  SPH_TEST_CLOSE(value, 5000 - rho0 * g * at[1], 0, 1e-4 * rho0 * g * dx + 1e-5 * 5000);
  sph_probe_destroy(&probe);
  sph_integrator_destroy(&flow);
  sph_particles_destroy(&water);
  sph_kernel_destroy(&kernel);
  sph_context_destroy(&context);
}

static void averages_of_a_linear_pressure_are_its_middle(void) {
  tank t;
  tank_start(&t, 2);
  set_pressure(&t, 3000, -2000, 10000);
  const double a[2] = {0, 0.1}, b[2] = {0, 0.3}, centre[2] = {0, 0.2}, along[2] = {0, 1};
  const double bound = 1e-5 * 10000;
  for (int points = 1; points <= 9; points += 4) {
    sph_probe *mean, *disc;
    SPH_TEST_OK(t.context, sph_probe_create_pressure_average(t.flow, a, b, points, &mean));
    SPH_TEST_OK(t.context, sph_probe_set_interpolator(mean, SPH_INTERPOLATOR_MLS_LINEAR));
    SPH_TEST_CLOSE(sample(&t, mean), 10000 - 2000 * 0.2, 0, bound);
    SPH_TEST_OK(t.context,
                sph_probe_create_pressure_disc(t.flow, centre, along, 0.2, points, &disc));
    SPH_TEST_OK(t.context, sph_probe_set_interpolator(disc, SPH_INTERPOLATOR_MLS_LINEAR));
    SPH_TEST_CLOSE(sample(&t, disc), 10000 - 2000 * 0.2, 0, bound);
    sph_probe_destroy(&mean);
    sph_probe_destroy(&disc);
  }
  tank_stop(&t);
}

/* s^2 has the mean R^2/4 over a disc and R^2/3 over a segment. */
static void disc_weights_are_chords(void) {
  tank t;
  tank_start(&t, 2);
  const sph_index n = sph_particles_count(t.water);
  double *x = malloc(2 * (size_t)n * sizeof *x), *p = malloc((size_t)n * sizeof *p);
  SPH_TEST_OK(t.context, sph_particles_read(t.water, SPH_POSITION, x, 2 * (int64_t)n));
  const double middle = 0.5, radius = 0.3;
  for (sph_index k = 0; k < n; k++) p[k] = 1e5 * pow(x[2 * k] - middle, 2);
  SPH_TEST_OK(t.context, sph_wcsph_start_from_pressure(t.flow, n, p));
  const double centre[2] = {middle, 0.25}, along[2] = {1, 0};
  const double a[2] = {middle - radius, 0.25}, b[2] = {middle + radius, 0.25};
  sph_probe *disc, *mean, *point;
  SPH_TEST_OK(t.context,
              sph_probe_create_pressure_disc(t.flow, centre, along, 2 * radius, 16, &disc));
  SPH_TEST_OK(t.context, sph_probe_create_pressure_average(t.flow, a, b, 64, &mean));
  SPH_TEST_OK(t.context, sph_probe_create_pressure(t.flow, centre, &point));
  /* Smoothing adds the kernel's second moment everywhere: the same that is seen at the centre. */
  const double smoothing = sample(&t, point);
  SPH_TEST_CLOSE(sample(&t, disc) - smoothing, 1e5 * radius * radius / 4, 0.01, 0);
  SPH_TEST_CLOSE(sample(&t, mean) - smoothing, 1e5 * radius * radius / 3, 0.01, 0);
  sph_probe_destroy(&disc);
  sph_probe_destroy(&mean);
  sph_probe_destroy(&point);
  free(x);
  free(p);
  tank_stop(&t);
}

static void velocity_is_exact_when_linear(void) {
  for (int dim = 2; dim <= 3; dim++) {
    tank t;
    tank_start(&t, dim);
    const sph_index n = sph_particles_count(t.water);
    double *v = malloc((size_t)(n * dim) * sizeof *v);
    SPH_TEST_OK(t.context, sph_particles_read(t.water, SPH_POSITION, v, (int64_t)n * dim));
    for (sph_index k = 0; k < n; k++) {
      const double x = v[dim * k], y = v[dim * k + 1];
      v[dim * k] = 1 + y;
      v[dim * k + 1] = 2 * x - y;
      if (dim == 3) v[dim * k + 2] = 0.5 - x;
    }
    SPH_TEST_OK(t.context, sph_particles_write(t.water, SPH_VELOCITY, v, (int64_t)n * dim));
    const double at[3] = {0.31, 0.17, 0.23};
    sph_probe *probe;
    SPH_TEST_OK(t.context, sph_probe_create_velocity(t.flow, at, &probe));
    CU_ASSERT(sph_probe_columns(probe) == dim);
    CU_ASSERT_STRING_EQUAL(sph_probe_column_name(probe, 1), "v_y");
    CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(probe, 1), "m/s");
    sample(&t, probe);
    double value[3];
    SPH_TEST_OK(t.context, sph_probe_last(probe, value));
    SPH_TEST_CLOSE(value[0], 1.17, 0, 1e-4);
    SPH_TEST_CLOSE(value[1], 0.45, 0, 1e-4);
    if (dim == 3) SPH_TEST_CLOSE(value[2], 0.19, 0, 1e-4);
    sph_probe_destroy(&probe);
    free(v);
    tank_stop(&t);
  }
}

/* The bed and the left side are one wall, a block that stands on the bed is the other. */
static void force_of_a_column_is_half_rho_g_h2(void) {
  tank t;
  tank_start(&t, 2);
  sph_integrator_destroy(&t.flow);
  sph_boundary_destroy(&t.boundary);
  sph_wall_destroy(&t.wall);
  sph_particles_destroy(&t.water);
  sph_kernel_destroy(&t.kernel);
  sph_interpolator_destroy(&t.interpolator);
  const double bed[] = {0, 1, 0, 0, width + 0.5, 0}, lo[2] = {0, 0}, hi[2] = {width, depth};
  const double block[] = {width, 0, width, 1, width + 0.3, 1, width + 0.3, 0}; /* clockwise */
  sph_wall *second;
  SPH_TEST_OK(t.context,
              sph_kernel_create(t.context, SPH_KERNEL_WENDLAND_C2, 2, 0.75 * dx, &t.kernel));
  SPH_TEST_OK(t.context, sph_interpolator_create(t.context, SPH_INTERPOLATOR_MLS_LINEAR, t.kernel,
                                                 &t.interpolator));
  SPH_TEST_OK(t.context, sph_wall_create_polyline(t.context, 3, bed, false, &t.wall));
  SPH_TEST_OK(t.context, sph_wall_create_polyline(t.context, 4, block, true, &second));
  SPH_TEST_OK(t.context,
              sph_boundary_create(t.context, t.wall, dx / 2, t.interpolator, &t.boundary));
  SPH_TEST_OK(t.context, sph_boundary_add_wall(t.boundary, second));
  SPH_TEST_OK(t.context, sph_particles_create(t.context, 2, dx / 2, &t.water));
  SPH_TEST_OK(t.context, sph_particles_fill_box(t.water, lo, hi, rho0));
  SPH_TEST_OK(t.context, sph_wcsph_create(t.context, t.kernel, t.water, t.boundary, &t.flow));
  SPH_TEST_OK(t.context, sph_wcsph_set_sound_speed(t.flow, c0));
  set_pressure(&t, 0, -rho0 * g, rho0 * g * depth);
  sph_probe *left, *right;
  SPH_TEST_OK(t.context, sph_probe_create_force(t.flow, t.boundary, 0, &left));
  SPH_TEST_OK(t.context, sph_probe_create_force(t.flow, t.boundary, 1, &right));
  CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(left, 0), "N/m");
  CU_ASSERT(sample(&t, left) == 0);
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  double f[2];
  const double half = 0.5 * rho0 * g * depth * depth;
  CU_ASSERT(sph_probe_count(left) == 2 && sph_probe_count(right) == 1);
  SPH_TEST_OK(t.context, sph_probe_last(left, f));
  SPH_TEST_CLOSE(f[0], -half, 0.01, 0);
  SPH_TEST_OK(t.context, sph_probe_last(right, f));
  SPH_TEST_CLOSE(f[0], half, 0.01, 0);
  sph_probe_destroy(&left);
  sph_probe_destroy(&right);
  sph_wall_destroy(&second);
  tank_stop(&t);
}

/* In a box the sides cancel, and the bed carries the weight. */
static void force_on_a_tank_is_the_weight(void) {
  tank t;
  tank_start(&t, 2);
  sph_probe *probe;
  SPH_TEST_OK(t.context, sph_probe_create_force(t.flow, t.boundary, 0, &probe));
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  double f[2];
  SPH_TEST_OK(t.context, sph_probe_last(probe, f));
  const double weight = rho0 * g * depth * width;
  SPH_TEST_CLOSE(f[0], 0, 0, 1e-3 * weight);
  SPH_TEST_CLOSE(f[1], -weight, 0.01, 0);
  sph_probe_destroy(&probe);
  tank_stop(&t);
}

static void elevation_is_the_surface_inside_and_along_walls(void) {
  for (int dim = 2; dim <= 3; dim++) {
    tank t;
    tank_start(&t, dim);
    const double spacing = dim == 2 ? dx : 2 * dx, y = dim == 2 ? 0 : 0.2;
    const double up[3] = {0, dim == 2 ? 1 : 0, 1}, along[3] = {1, 0, 0};
    /* Inside, along a wall, in a corner, near a wall, from half the depth. */
    const double feet[][3] = {
        {0.513, y, 0}, {0, y, 0}, {width, 0, 0}, {0.6 * spacing, y, 0}, {0.3, y, 0.25}};
    for (int k = 0; k < 5; k++) {
      const double foot[3] = {feet[k][0], dim == 2 ? feet[k][2] : feet[k][1], feet[k][2]};
      sph_probe *probe;
      SPH_TEST_OK(t.context, sph_probe_create_elevation(t.flow, foot, up, 0.9, &probe));
      SPH_TEST_CLOSE(sample(&t, probe), depth - feet[k][2], 0, 0.3 * spacing);
      sph_probe_destroy(&probe);
    }
    sph_probe *dry, *full;
    const double high[3] = {0.1, dim == 2 ? 0.7 : 0.2, 0.7}, deep[3] = {0.1, 0.2, 0.2};
    SPH_TEST_OK(t.context, sph_probe_create_elevation(t.flow, high, along, 0.8, &dry));
    SPH_TEST_CLOSE(sample(&t, dry), 0, 0, 0);
    SPH_TEST_OK(t.context, sph_probe_create_elevation(t.flow, deep, along, 0.8, &full));
    SPH_TEST_CLOSE(sample(&t, full), 0.8, 1e-12, 0);
    sph_probe_destroy(&dry);
    sph_probe_destroy(&full);
    /* A dry wall line is dry, though ghosts fill half of every support. */
    const double wall_foot[3] = {0, dim == 2 ? 0.7 : 0.2, 0.7};
    SPH_TEST_OK(t.context, sph_probe_create_elevation(t.flow, wall_foot, up, 0.25, &dry));
    SPH_TEST_CLOSE(sample(&t, dry), 0, 0, 0);
    sph_probe_destroy(&dry);
    tank_stop(&t);
  }
}

static void glide(double t, double *displacement, double *velocity, double *acceleration,
                  void *user) {
  (void)user, (void)acceleration;
  displacement[0] = t;
  velocity[0] = 1;
}

/* A tank that glides with its water: the line starts inside and ends on the wall. */
static void elevation_follows_moving_walls(void) {
  tank t;
  tank_start(&t, 2);
  sph_integrator_destroy(&t.flow);
  sph_boundary_destroy(&t.boundary);
  SPH_TEST_OK(t.context, sph_wall_set_motion(t.wall, glide, NULL));
  SPH_TEST_OK(t.context, sph_boundary_create(t.context, t.wall, dx, t.interpolator, &t.boundary));
  SPH_TEST_OK(t.context, sph_wcsph_create(t.context, t.kernel, t.water, t.boundary, &t.flow));
  SPH_TEST_OK(t.context, sph_wcsph_set_sound_speed(t.flow, c0));
  set_pressure(&t, 0, -rho0 * g, rho0 * g * depth);
  const sph_index n = sph_particles_count(t.water);
  double *v = calloc(2 * (size_t)n, sizeof *v);
  for (sph_index k = 0; k < n; k++) v[2 * k] = 1;
  SPH_TEST_OK(t.context, sph_particles_write(t.water, SPH_VELOCITY, v, 2 * (int64_t)n));
  free(v);
  const double foot[2] = {0.1, 0.02}, high[2] = {0.1, 0.65}, up[2] = {0, 1};
  sph_probe *wet, *dry;
  SPH_TEST_OK(t.context, sph_probe_create_elevation(t.flow, foot, up, 0.9, &wet));
  SPH_TEST_OK(t.context, sph_probe_create_elevation(t.flow, high, up, 0.3, &dry));
  for (int k = 0; k <= 5; k++) {
    SPH_TEST_OK(t.context, sph_integrator_advance(t.flow, 0.02 * k));
    SPH_TEST_CLOSE(sample(&t, wet), depth - foot[1], 0, 0.3 * dx);
    SPH_TEST_CLOSE(sample(&t, dry), 0, 0, 0);
  }
  sph_probe_destroy(&wet);
  sph_probe_destroy(&dry);
  tank_stop(&t);
}

/* A layer without walls in a box that repeats: points one period away see the same. */
static void periodic_images_are_seen(void) {
  tank t;
  tank_start(&t, 2);
  sph_integrator_destroy(&t.flow);
  SPH_TEST_OK(t.context, sph_wcsph_create(t.context, t.kernel, t.water, NULL, &t.flow));
  SPH_TEST_OK(t.context, sph_wcsph_set_sound_speed(t.flow, c0));
  SPH_TEST_OK(t.context, sph_wcsph_set_periodic(t.flow, 0, 0, width));
  set_pressure(&t, 0, -rho0 * g, rho0 * g * depth);
  const double up[2] = {0, 1};
  for (int k = -2; k <= 2; k++) {
    const double x[2] = {0.01 + k * width, 0.2};
    sph_probe *line, *point;
    SPH_TEST_OK(t.context, sph_probe_create_elevation(t.flow, x, up, 0.6, &line));
    SPH_TEST_OK(t.context, sph_probe_create_pressure(t.flow, x, &point));
    SPH_TEST_CLOSE(sample(&t, line), depth - 0.2, 0, 0.3 * dx);
    SPH_TEST_CLOSE(sample(&t, point), rho0 * g * (depth - 0.2), 1e-3, 0);
    sph_probe_destroy(&line);
    sph_probe_destroy(&point);
  }
  tank_stop(&t);
}

static void front_ignores_spray(void) {
  tank t;
  tank_start(&t, 2);
  const double drops[] = {0.31, 0.8, 0.33, 0.8, 0.6, 0.9}; /* a pair and a single one */
  SPH_TEST_OK(t.context, sph_particles_add(t.water, 3, drops, rho0, NULL));
  sph_probe *up, *down, *right;
  SPH_TEST_OK(t.context, sph_probe_create_front(t.flow, 1, 1, &up));
  SPH_TEST_OK(t.context, sph_probe_create_front(t.flow, 1, -1, &down));
  SPH_TEST_OK(t.context, sph_probe_create_front(t.flow, 0, 1, &right));
  SPH_TEST_CLOSE(sample(&t, up), depth, 0, 1e-9);
  SPH_TEST_CLOSE(sample(&t, down), 0, 0, 1e-9);
  SPH_TEST_CLOSE(sample(&t, right), width, 0, 1e-9);
  SPH_TEST_OK(t.context, sph_probe_set_min_neighbours(up, 1));
  SPH_TEST_CLOSE(sample(&t, up), 0.8 + 0.5 * dx, 0, 1e-9);
  SPH_TEST_OK(t.context, sph_probe_set_min_neighbours(up, 0));
  SPH_TEST_CLOSE(sample(&t, up), 0.9 + 0.5 * dx, 0, 1e-9);
  SPH_TEST_OK(t.context, sph_probe_set_min_neighbours(up, 1000));
  CU_ASSERT(isnan(sample(&t, up)));
  SPH_TEST_STATUS(t.context, sph_probe_set_min_neighbours(up, -1), SPH_E_ARGUMENT, "0 to 1000");
  SPH_TEST_STATUS(t.context, sph_probe_set_min_neighbours(up, 1001), SPH_E_ARGUMENT, "0 to 1000");
  CU_ASSERT(sph_probe_set_min_neighbours(NULL, 3) == SPH_E_ARGUMENT);
  sph_probe_destroy(&up);
  sph_probe_destroy(&down);
  sph_probe_destroy(&right);
  tank_stop(&t);
}

static void energies_and_mass_are_sums(void) {
  tank t;
  tank_start(&t, 2);
  set_pressure(&t, 0, 0, 16000); /* rho = rho0 + 10 everywhere */
  const sph_index n = sph_particles_count(t.water);
  double *v = malloc(2 * (size_t)n * sizeof *v);
  for (sph_index k = 0; k < n; k++) {
    v[2 * k] = 3;
    v[2 * k + 1] = -4;
  }
  SPH_TEST_OK(t.context, sph_particles_write(t.water, SPH_VELOCITY, v, 2 * (int64_t)n));
  sph_probe *energy, *mass;
  SPH_TEST_OK(t.context, sph_probe_create_energy(t.flow, &energy));
  SPH_TEST_OK(t.context, sph_probe_create_mass(t.flow, &mass));
  sample(&t, energy);
  double e[4], m[2];
  const double total = 1010 * width * depth;
  SPH_TEST_OK(t.context, sph_probe_last(energy, e));
  SPH_TEST_CLOSE(e[0], 0.5 * total * 25, 1e-12, 0);
  SPH_TEST_CLOSE(e[1], total * g * depth / 2, 1e-12, 0);
  SPH_TEST_CLOSE(e[2], total * c0 * c0 * (log(1.01) + 1 / 1.01 - 1), 1e-9, 0);
  SPH_TEST_CLOSE(e[3], e[0] + e[1] + e[2], 1e-14, 0);
  sample(&t, mass);
  SPH_TEST_OK(t.context, sph_probe_last(mass, m));
  SPH_TEST_CLOSE(m[0], total, 1e-12, 0);
  CU_ASSERT(m[1] == n);
  CU_ASSERT_STRING_EQUAL(sph_probe_column_name(energy, 2), "compressible");
  CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(energy, 2), "J/m");
  CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(mass, 1), "");
  sph_probe_destroy(&energy);
  sph_probe_destroy(&mass);
  free(v);
  tank_stop(&t);
}

static void count_particles(const sph_integrator *flow, double *values, void *user) {
  values[0] = sph_particles_count(sph_integrator_particles(flow));
  values[1] = *(const double *)user;
}

static void functions_of_the_caller_are_sampled(void) {
  tank t;
  tank_start(&t, 2);
  double other = 7;
  const char *const names[] = {"particles", "other"}, *const units[] = {"", "kg m^2"};
  sph_probe *probe;
  SPH_TEST_OK(t.context,
              sph_probe_create_function(t.flow, 2, names, units, count_particles, &other, &probe));
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  other = 8;
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  double times[2], values[4];
  CU_ASSERT_FATAL(sph_probe_count(probe) == 2);
  SPH_TEST_OK(t.context, sph_probe_read(probe, 0, 2, times, values));
  CU_ASSERT(values[0] == sph_particles_count(t.water) && values[1] == 7 && values[3] == 8);
  CU_ASSERT(times[0] > 0 && times[1] == sph_integrator_time(t.flow));
  CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(probe, 1), "kg m^2");
  sph_probe_destroy(&probe);
  SPH_TEST_OK(t.context,
              sph_probe_create_function(t.flow, 2, names, NULL, count_particles, &other, &probe));
  CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(probe, 1), "");
  sph_probe_destroy(&probe);
  tank_stop(&t);
}

static void interval_chooses_the_first_step_at_or_after(void) {
  tank t;
  tank_start(&t, 2);
  const double dt = 1.0 / 4096;
  SPH_TEST_OK(t.context, sph_integrator_set_dt(t.flow, dt));
  sph_probe *every, *some, *rare;
  SPH_TEST_OK(t.context, sph_probe_create_mass(t.flow, &every));
  SPH_TEST_OK(t.context, sph_probe_create_mass(t.flow, &some));
  SPH_TEST_OK(t.context, sph_probe_create_mass(t.flow, &rare));
  SPH_TEST_OK(t.context, sph_probe_set_interval(some, 2.5 * dt));
  SPH_TEST_OK(t.context, sph_probe_set_interval(rare, 4 * dt));
  for (int k = 0; k < 10; k++) SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  double times[16];
  CU_ASSERT(sph_probe_count(every) == 10);
  CU_ASSERT_FATAL(sph_probe_count(some) == 4 && sph_probe_count(rare) == 2);
  SPH_TEST_OK(t.context, sph_probe_read(some, 0, 4, times, NULL));
  CU_ASSERT(times[0] == 3 * dt && times[1] == 5 * dt && times[2] == 8 * dt && times[3] == 10 * dt);
  SPH_TEST_OK(t.context, sph_probe_read(rare, 0, 2, times, NULL));
  CU_ASSERT(times[0] == 4 * dt && times[1] == 8 * dt);
  SPH_TEST_OK(t.context, sph_probe_set_interval(rare, 0));
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  CU_ASSERT(sph_probe_count(rare) == 3);
  SPH_TEST_OK(t.context, sph_probe_clear(rare));
  CU_ASSERT(sph_probe_count(rare) == 0);
  SPH_TEST_STATUS(t.context, sph_probe_set_interval(rare, -1), SPH_E_ARGUMENT, "interval must be");
  SPH_TEST_STATUS(t.context, sph_probe_set_interval(rare, NAN), SPH_E_ARGUMENT, "interval must be");
  CU_ASSERT(sph_probe_set_interval(NULL, 1) == SPH_E_ARGUMENT);
  sph_probe_destroy(&every);
  sph_probe_destroy(&some);
  sph_probe_destroy(&rare);
  tank_stop(&t);
}

enum { KINDS = 9 };

/* One probe of every kind. */
static void make_all(tank *t, sph_probe **probe) {
  static const double at[3] = {0.2, 0.2, 0.2}, b[3] = {0.4, 0.3, 0.2}, up[3] = {0, 1, 0};
  SPH_TEST_OK(t->context, sph_probe_create_pressure(t->flow, at, &probe[0]));
  SPH_TEST_OK(t->context, sph_probe_create_pressure_average(t->flow, at, b, 5, &probe[1]));
  SPH_TEST_OK(t->context, sph_probe_create_velocity(t->flow, at, &probe[2]));
  SPH_TEST_OK(t->context, sph_probe_create_force(t->flow, t->boundary, 0, &probe[3]));
  SPH_TEST_OK(t->context, sph_probe_create_front(t->flow, 0, 1, &probe[4]));
  SPH_TEST_OK(t->context, sph_probe_create_elevation(t->flow, at, up, 0.4, &probe[5]));
  SPH_TEST_OK(t->context, sph_probe_create_energy(t->flow, &probe[6]));
  SPH_TEST_OK(t->context, sph_probe_create_mass(t->flow, &probe[7]));
  SPH_TEST_OK(t->context, sph_probe_create_reaction(t->flow, t->boundary, 0, &probe[8]));
}

/* Positions, velocities and densities after steps, with and without probes. */
static void run_steps(bool probes, sph_stepper stepper, int steps, double *state, int64_t *size) {
  tank t;
  sph_probe *probe[KINDS] = {NULL};
  tank_start(&t, 2);
  SPH_TEST_OK(t.context, sph_integrator_set_stepper(t.flow, stepper));
  set_pressure(&t, -8000, -rho0 * g, 12000); /* out of balance: it moves */
  if (probes) make_all(&t, probe);
  for (int k = 0; k < steps; k++) {
    SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
    if (probes && k % 3 == 0)
      for (int p = 0; p < KINDS; p++) SPH_TEST_OK(t.context, sph_probe_sample(probe[p]));
  }
  const int64_t n = sph_particles_count(t.water);
  SPH_TEST_OK(t.context, sph_particles_read(t.water, SPH_POSITION, state, 2 * n));
  SPH_TEST_OK(t.context, sph_particles_read(t.water, SPH_VELOCITY, state + 2 * n, 2 * n));
  SPH_TEST_OK(t.context, sph_particles_read(t.water, SPH_DENSITY, state + 4 * n, n));
  *size = 5 * n;
  for (int p = 0; p < KINDS; p++) sph_probe_destroy(&probe[p]);
  tank_stop(&t);
}

static void sampling_changes_no_bit(void) {
  static double with[8192], without[8192];
  for (int stepper = SPH_STEPPER_SYMPLECTIC; stepper <= SPH_STEPPER_RK4; stepper++) {
    int64_t size = 0, size_without = 0;
    run_steps(true, (sph_stepper)stepper, 60, with, &size);
    run_steps(false, (sph_stepper)stepper, 60, without, &size_without);
    CU_ASSERT_FATAL(size == size_without && size > 0);
    CU_ASSERT(memcmp(with, without, (size_t)size * sizeof *with) == 0);
  }
}

static void reserved_probes_allocate_nothing(void) {
  tank t;
  sph_probe *probe[KINDS];
  tank_start(&t, 2);
  make_all(&t, probe);
  for (int p = 0; p < KINDS; p++) SPH_TEST_OK(t.context, sph_probe_reserve(probe[p], 1000));
  for (int k = 0; k < 30; k++) SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  const int64_t before = allocations;
  for (int k = 0; k < 60; k++) SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  CU_ASSERT(allocations == before);
  if (allocations != before) printf("\n%d allocations", (int)(allocations - before));
  CU_ASSERT(sph_probe_count(probe[0]) == 90);
  SPH_TEST_STATUS(t.context, sph_probe_reserve(probe[0], -1), SPH_E_ARGUMENT, "samples must be");
  SPH_TEST_STATUS(t.context, sph_probe_reserve(probe[0], INT64_MAX), SPH_E_MEMORY, "no memory");
  CU_ASSERT(sph_probe_reserve(NULL, 1) == SPH_E_ARGUMENT);
  /* The series grows by itself, too, and keeps what it had. */
  SPH_TEST_OK(t.context, sph_probe_clear(probe[7]));
  for (int k = 0; k < 1500; k++) SPH_TEST_OK(t.context, sph_probe_sample(probe[7]));
  double values[2];
  SPH_TEST_OK(t.context, sph_probe_read(probe[7], 3, 1, NULL, values));
  CU_ASSERT(sph_probe_count(probe[7]) == 1500 && values[1] == sph_particles_count(t.water));
  for (int p = 0; p < KINDS; p++) sph_probe_destroy(&probe[p]);
  tank_stop(&t);
}

static void failing_allocations_leak_nothing(void) {
  tank t;
  tank_start(&t, 2);
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  static const double at[2] = {0.2, 0.2}, up[2] = {0, 1};
  const char *const names[] = {"a", "b"};
  double other = 1;
  int failures = 0;
  for (int kind = 0; kind < 4; kind++) {
    for (int64_t room = 0;; room++) {
      sph_probe *probe = (sph_probe *)&t;
      allocations_left = room;
      const sph_status status =
          kind == 0   ? sph_probe_create_pressure(t.flow, at, &probe)
          : kind == 1 ? sph_probe_create_elevation(t.flow, at, up, 0.3, &probe)
          : kind == 2
              ? sph_probe_create_force(t.flow, t.boundary, 0, &probe)
              : sph_probe_create_function(t.flow, 2, names, names, count_particles, &other, &probe);
      allocations_left = INT64_MAX;
      if (status == SPH_OK) {
        sph_probe_destroy(&probe);
        break;
      }
      CU_ASSERT(status == SPH_E_MEMORY && !probe);
      failures++;
    }
  }
  CU_ASSERT(failures > 20);
  sph_probe *probe;
  SPH_TEST_OK(t.context, sph_probe_create_mass(t.flow, &probe));
  allocations_left = 0;
  SPH_TEST_STATUS(t.context, sph_probe_sample(probe), SPH_E_MEMORY, "no memory for sample 0");
  SPH_TEST_STATUS(t.context, sph_probe_set_name(probe, "other"), SPH_E_MEMORY, "no memory");
  allocations_left = INT64_MAX;
  CU_ASSERT(sph_probe_count(probe) == 0);
  CU_ASSERT_STRING_EQUAL(sph_probe_name(probe), "mass");
  sph_probe_destroy(&probe);
  tank_stop(&t);
}

static void files_read_back_to_the_bit(void) {
  tank t;
  tank_start(&t, 2);
  char directory[] = "/tmp/sph_t75_XXXXXX", path[64], line[256];
  CU_ASSERT_FATAL(mkdtemp(directory) != NULL);
  snprintf(path, sizeof path, "%s/gauge.csv", directory);
  sph_probe *probe;
  const double at[2] = {0.3, 0.1};
  SPH_TEST_OK(t.context, sph_probe_create_velocity(t.flow, at, &probe));
  SPH_TEST_OK(t.context, sph_probe_set_name(probe, "gauge 1"));
  for (int k = 0; k < 5; k++) SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  SPH_TEST_OK(t.context, sph_probe_write_csv(probe, path));
  double times[5], values[10];
  SPH_TEST_OK(t.context, sph_probe_read(probe, 0, 5, times, values));
  FILE *file = fopen(path, "r");
  CU_ASSERT_FATAL(file != NULL);
  const char *const head[] = {"# name: gauge 1\n", "# units: s,m/s,m/s\n", "t_s,v_x,v_y\n"};
  for (int k = 0; k < 3; k++) {
    CU_ASSERT_FATAL(fgets(line, sizeof line, file) != NULL);
    CU_ASSERT_STRING_EQUAL(line, head[k]);
  }
  for (int k = 0; k < 5; k++) {
    double row[3];
    CU_ASSERT_FATAL(fscanf(file, "%lf,%lf,%lf\n", &row[0], &row[1], &row[2]) == 3);
    CU_ASSERT(row[0] == times[k] && row[1] == values[2 * k] && row[2] == values[2 * k + 1]);
  }
  CU_ASSERT(fgetc(file) == EOF);
  fclose(file);
  remove(path);
  snprintf(path, sizeof path, "%s/missing/gauge.csv", directory);
  SPH_TEST_STATUS(t.context, sph_probe_write_csv(probe, path), SPH_E_IO, "missing/gauge.csv");
  CU_ASSERT(access(path, F_OK) != 0);
  SPH_TEST_STATUS(t.context, sph_probe_write_csv(probe, NULL), SPH_E_ARGUMENT, "path is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_write_csv(probe, ""), SPH_E_ARGUMENT, "path is empty");
  CU_ASSERT(sph_probe_write_csv(NULL, path) == SPH_E_ARGUMENT);
  sph_probe_destroy(&probe);
  rmdir(directory);
  tank_stop(&t);
}

static void points_outside_are_refused(void) {
  tank t;
  tank_start(&t, 2);
  sph_probe *probe;
  const double support = sph_kernel_get_support(t.kernel);
  const double nan_x[2] = {NAN, 0}, far[2] = {10, 0.2}, inside[2] = {0.5, -1.2 * support};
  const double shallow[2] = {0.5, -0.5 * support}, good[2] = {0.5, 0.2};
  const double up[2] = {0, 1}, skew[2] = {0.5, 0.5};
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure(t.flow, nan_x, &probe), SPH_E_ARGUMENT,
                  "not finite");
  CU_ASSERT(!probe);
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure(t.flow, far, &probe), SPH_E_ARGUMENT,
                  "probe outside the domain: point (10, 0.2, 0)");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure(t.flow, inside, &probe), SPH_E_ARGUMENT,
                  "probe outside the domain: point (0.5, -0.09, 0)");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_average(t.flow, good, inside, 40, &probe),
                  SPH_E_ARGUMENT, "inside wall \"wall\"");
  SPH_TEST_STATUS(t.context, sph_probe_create_velocity(t.flow, inside, &probe), SPH_E_ARGUMENT,
                  "outside");
  SPH_TEST_STATUS(t.context, sph_probe_create_elevation(t.flow, inside, up, 1, &probe),
                  SPH_E_ARGUMENT, "outside");
  SPH_TEST_OK(t.context, sph_probe_create_pressure(t.flow, shallow, &probe));
  sph_probe_destroy(&probe);
  const double lo[2] = {-0.5, -0.5}, hi[2] = {11, 2};
  SPH_TEST_OK(t.context, sph_wcsph_set_domain(t.flow, lo, hi));
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure(t.flow, (const double[2]){0.5, 2.1}, &probe),
                  SPH_E_ARGUMENT, "along axis 1");
  SPH_TEST_STATUS(t.context, sph_probe_create_elevation(t.flow, good, skew, 1, &probe),
                  SPH_E_ARGUMENT, "direction must be a unit vector");
  SPH_TEST_STATUS(t.context, sph_probe_create_elevation(t.flow, good, up, 0, &probe),
                  SPH_E_ARGUMENT, "length must be > 0");
  SPH_TEST_STATUS(t.context, sph_probe_create_elevation(t.flow, good, up, NAN, &probe),
                  SPH_E_ARGUMENT, "length must be > 0");
  SPH_TEST_STATUS(t.context, sph_probe_create_elevation(t.flow, good, up, 1e6, &probe),
                  SPH_E_ARGUMENT, "length must be > 0");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_average(t.flow, good, good, 0, &probe),
                  SPH_E_ARGUMENT, "points must be 1 to 100000");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_disc(t.flow, good, skew, 0.1, 3, &probe),
                  SPH_E_ARGUMENT, "along must be a unit vector");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_disc(t.flow, good, up, 0, 3, &probe),
                  SPH_E_ARGUMENT, "diameter must be > 0");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_disc(t.flow, good, up, INFINITY, 3, &probe),
                  SPH_E_ARGUMENT, "diameter must be > 0");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_disc(t.flow, good, up, 0.1, 200000, &probe),
                  SPH_E_ARGUMENT, "points must be");
  CU_ASSERT(!probe);
  tank_stop(&t);
  tank_start(&t, 3);
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_disc(t.flow, up, up, 0.1, 3, &probe),
                  SPH_E_UNSUPPORTED, "2D");
  tank_stop(&t);
}

static void wrong_arguments_are_refused(void) {
  tank t, other;
  tank_start(&t, 2);
  tank_start(&other, 2);
  sph_probe *probe = (sph_probe *)&t;
  const double x[2] = {0.5, 0.2};
  const char *names[] = {"a", "b"}, *units[] = {"m", "s"};
  CU_ASSERT(sph_probe_create_pressure(NULL, x, &probe) == SPH_E_ARGUMENT && !probe);
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure(t.flow, NULL, &probe), SPH_E_ARGUMENT,
                  "x is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure(t.flow, x, NULL), SPH_E_ARGUMENT,
                  "out is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_average(t.flow, x, NULL, 3, &probe),
                  SPH_E_ARGUMENT, "b is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_pressure_disc(t.flow, x, NULL, 1, 3, &probe),
                  SPH_E_ARGUMENT, "along is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_velocity(t.flow, NULL, &probe), SPH_E_ARGUMENT,
                  "x is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_elevation(t.flow, x, NULL, 1, &probe), SPH_E_ARGUMENT,
                  "direction is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_force(t.flow, NULL, 0, &probe), SPH_E_ARGUMENT,
                  "boundary is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_force(t.flow, other.boundary, 0, &probe),
                  SPH_E_ARGUMENT, "not the one");
  SPH_TEST_STATUS(t.context, sph_probe_create_force(t.flow, t.boundary, 1, &probe), SPH_E_ARGUMENT,
                  "wall must be 0 to 0, got 1");
  SPH_TEST_STATUS(t.context, sph_probe_create_front(t.flow, 2, 1, &probe), SPH_E_ARGUMENT,
                  "axis must be");
  SPH_TEST_STATUS(t.context, sph_probe_create_front(t.flow, 0, 0.5, &probe), SPH_E_ARGUMENT,
                  "sign must be");
  SPH_TEST_STATUS(t.context, sph_probe_create_energy(t.flow, NULL), SPH_E_ARGUMENT, "out is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_mass(t.flow, NULL), SPH_E_ARGUMENT, "out is NULL");
  SPH_TEST_STATUS(t.context,
                  sph_probe_create_function(t.flow, 2, NULL, units, count_particles, NULL, &probe),
                  SPH_E_ARGUMENT, "names is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_create_function(t.flow, 2, names, units, NULL, NULL, &probe),
                  SPH_E_ARGUMENT, "function is NULL");
  SPH_TEST_STATUS(t.context,
                  sph_probe_create_function(t.flow, 0, names, units, count_particles, NULL, &probe),
                  SPH_E_ARGUMENT, "columns must be 1 to 256");
  names[1] = "";
  SPH_TEST_STATUS(t.context,
                  sph_probe_create_function(t.flow, 2, names, units, count_particles, NULL, &probe),
                  SPH_E_ARGUMENT, "column 1 is empty");
  names[1] = "a,b";
  SPH_TEST_STATUS(t.context,
                  sph_probe_create_function(t.flow, 2, names, units, count_particles, NULL, &probe),
                  SPH_E_ARGUMENT, "comma");
  names[1] = "b";
  units[0] = "m\n";
  SPH_TEST_STATUS(t.context,
                  sph_probe_create_function(t.flow, 2, names, units, count_particles, NULL, &probe),
                  SPH_E_ARGUMENT, "column 0 has a comma");
  SPH_TEST_OK(t.context, sph_probe_create_mass(t.flow, &probe));
  SPH_TEST_STATUS(t.context, sph_probe_set_name(probe, NULL), SPH_E_ARGUMENT, "name is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_set_name(probe, ""), SPH_E_ARGUMENT, "name is empty");
  SPH_TEST_STATUS(t.context, sph_probe_set_name(probe, "a\nb"), SPH_E_ARGUMENT,
                  "control character");
  CU_ASSERT(sph_probe_set_name(NULL, "a") == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(t.context, sph_probe_set_min_neighbours(probe, 1), SPH_E_TYPE, "\"front\"");
  double values[2];
  SPH_TEST_STATUS(t.context, sph_probe_last(probe, values), SPH_E_ARGUMENT, "no sample yet");
  SPH_TEST_STATUS(t.context, sph_probe_last(probe, NULL), SPH_E_ARGUMENT, "values is NULL");
  SPH_TEST_STATUS(t.context, sph_probe_read(probe, 0, 1, NULL, values), SPH_E_ARGUMENT,
                  "has 0 samples");
  SPH_TEST_STATUS(t.context, sph_probe_read(probe, -1, 0, NULL, values), SPH_E_ARGUMENT, "from -1");
  SPH_TEST_OK(t.context, sph_probe_read(probe, 0, 0, NULL, values));
  CU_ASSERT(sph_probe_read(NULL, 0, 0, NULL, NULL) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_probe_last(NULL, values) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_probe_sample(NULL) == SPH_E_ARGUMENT && sph_probe_clear(NULL) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_probe_count(NULL) == 0 && sph_probe_columns(NULL) == 0);
  CU_ASSERT_STRING_EQUAL(sph_probe_name(NULL), "");
  CU_ASSERT_STRING_EQUAL(sph_probe_column_name(probe, 2), "");
  CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(probe, -1), "");
  sph_probe_destroy(&probe);
  sph_probe_destroy(&probe);
  sph_probe_destroy(NULL);
  tank_stop(&t);
  tank_stop(&other);
}

static void a_flow_that_is_not_ready_cannot_be_sampled(void) {
  tank t;
  tank_start(&t, 2);
  sph_integrator *flow;
  sph_probe *probe;
  const double x[2] = {0.5, 0.2};
  SPH_TEST_OK(t.context, sph_wcsph_create(t.context, t.kernel, t.water, NULL, &flow));
  SPH_TEST_OK(t.context, sph_probe_create_pressure(flow, x, &probe));
  SPH_TEST_STATUS(t.context, sph_probe_sample(probe), SPH_E_ARGUMENT, "sound speed is not set");
  CU_ASSERT(sph_probe_count(probe) == 0);
  sph_probe_destroy(&probe);
  sph_integrator_destroy(&flow);
  tank_stop(&t);
}

static void probes_outlive_the_callers_handles(void) {
  tank t;
  tank_start(&t, 2);
  sph_probe *probe[KINDS], *many[256], *one_more;
  make_all(&t, probe);
  for (int k = KINDS; k < 256; k++) SPH_TEST_OK(t.context, sph_probe_create_mass(t.flow, &many[k]));
  SPH_TEST_STATUS(t.context, sph_probe_create_mass(t.flow, &one_more), SPH_E_ARGUMENT,
                  "at most 256");
  CU_ASSERT(!one_more);
  for (int k = KINDS; k < 256; k++) sph_probe_destroy(&many[k]);
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  sph_context *context = t.context;
  /* A stopped probe is not sampled; the others are. */
  sph_probe_destroy(&probe[1]);
  SPH_TEST_OK(t.context, sph_integrator_step(t.flow));
  CU_ASSERT(sph_probe_count(probe[0]) == 2 && sph_probe_count(probe[2]) == 2);
  tank_stop(&t);
  for (int p = 0; p < KINDS; p++) {
    if (p != 1) SPH_TEST_OK(context, sph_probe_sample(probe[p]));
    sph_probe_destroy(&probe[p]);
  }
}

SPH_TEST_MAIN("probe",
              {"a linear pressure is exact on walls, in corners and inside",
               pressure_is_exact_when_linear},
              {"pressure and velocity are zero without fluid", pressure_is_zero_without_fluid},
              {"few particles carry the hydrostatic gradient",
               pressure_of_few_particles_has_the_hydrostatic_gradient},
              {"means of a linear pressure are that of the middle",
               averages_of_a_linear_pressure_are_its_middle},
              {"a disc's weights are its chords", disc_weights_are_chords},
              {"a linear velocity is exact", velocity_is_exact_when_linear},
              {"a column pushes its ends with rho g H^2 / 2", force_of_a_column_is_half_rho_g_h2},
              {"water at rest pushes with its weight", force_on_a_tank_is_the_weight},
              {"elevation is the surface inside and along walls",
               elevation_is_the_surface_inside_and_along_walls},
              {"elevation follows moving walls", elevation_follows_moving_walls},
              {"periodic images are seen", periodic_images_are_seen},
              {"the front leaves out spray", front_ignores_spray},
              {"energies and mass are those of a known state", energies_and_mass_are_sums},
              {"functions of the caller are sampled", functions_of_the_caller_are_sampled},
              {"an interval takes the first step at or after it",
               interval_chooses_the_first_step_at_or_after},
              {"sampling changes no bit of the flow", sampling_changes_no_bit},
              {"reserved probes allocate nothing in steps", reserved_probes_allocate_nothing},
              {"failing allocations leave nothing behind", failing_allocations_leak_nothing},
              {"files read back to the bit", files_read_back_to_the_bit},
              {"points outside are refused and named", points_outside_are_refused},
              {"wrong arguments are refused", wrong_arguments_are_refused},
              {"a flow that is not ready cannot be sampled",
               a_flow_that_is_not_ready_cannot_be_sampled},
              {"probes outlive the caller's handles", probes_outlive_the_callers_handles})
