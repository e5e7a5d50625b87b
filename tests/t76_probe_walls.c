/* Probes that walls take along, and the force on walls by what their ghosts take from the fluid. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81;

typedef struct glide_of {
  double velocity[2];
} glide_of;

static void glide(double t, double *displacement, double *velocity, double *acceleration,
                  void *user) {
  const glide_of *of = user;
  (void)acceleration;
  for (int d = 0; d < 2; d++) {
    displacement[d] = of->velocity[d] * t;
    velocity[d] = of->velocity[d];
  }
}

static void spin(double t, double *angle, double *rate, double *acceleration, void *user) {
  (void)acceleration;
  *rate = *(const double *)user;
  *angle = 0.2 * *rate + *rate * t;
}

static void row_of(const flow_world *w, sph_probe *probe, double *values) {
  SPH_TEST_OK(w->context, sph_probe_sample(probe));
  SPH_TEST_OK(w->context, sph_probe_last(probe, values));
}

static double sample(const flow_world *w, sph_probe *probe) {
  double values[8] = {0};
  row_of(w, probe, values);
  return values[0];
}

/* Water in the corner of an open tank, out of balance, in a frame that glides. */
static flow_world gliding_tank(const glide_of *of, sph_stepper stepper) {
  flow_world w = flow_open((flow_plan){.dx = 0.02, .c0 = 20, .precision = SPH_PRECISION_DOUBLE});
  const double lo[2] = {0, 0}, hi[2] = {0.3, 0.2}, rim[2] = {0.5, 0.5};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, rim, SPH_SIDE_HI(1), &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, glide, (void *)of));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_integrator_set_stepper(w.flow, stepper));
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 5e-4));
  flow_linear_pressure(&w, rho0 * g * 0.2, (const double[]){0, -rho0 * g});
  double *v = flow_read(&w, SPH_VELOCITY);
  for (sph_index k = 0; k < sph_particles_count(w.water); k++)
    for (int d = 0; d < 2; d++) v[2 * k + d] = of->velocity[d];
  flow_write(&w, SPH_VELOCITY, v);
  free(v);
  return w;
}

enum { KINDS = 6 };

static void make_riders(const flow_world *w, sph_probe **probe) {
  static const double toe[2] = {0, 0.05}, top[2] = {0, 0.15}, up[2] = {0, 1},
                      inside[2] = {0.11, 0.06};
  SPH_TEST_OK(w->context, sph_probe_create_pressure(w->flow, toe, &probe[0]));
  SPH_TEST_OK(w->context, sph_probe_create_pressure_average(w->flow, toe, top, 7, &probe[1]));
  SPH_TEST_OK(w->context, sph_probe_create_pressure_disc(w->flow, inside, up, 0.08, 5, &probe[2]));
  SPH_TEST_OK(w->context, sph_probe_create_velocity(w->flow, inside, &probe[3]));
  SPH_TEST_OK(w->context, sph_probe_create_elevation(w->flow, toe, up, 0.4, &probe[4]));
  SPH_TEST_OK(w->context, sph_probe_create_elevation(w->flow, inside, up, 0.4, &probe[5]));
  for (int k = 0; k < KINDS; k++)
    SPH_TEST_OK(w->context, sph_probe_follow(probe[k], w->boundary, 0));
}

/* A column collapses in a tank at rest and in one that glides, which has no other lists and ghosts. */
static void riders_read_what_fixed_probes_read_at_rest(void) {
  static const double scale[KINDS] = {1000, 1000, 1000, 1, 0.1, 0.1};
  const glide_of none = {{0, 0}}, along = {{0.7, 0.3}};
  for (int stepper = SPH_STEPPER_SYMPLECTIC; stepper <= SPH_STEPPER_RK4; stepper++) {
    flow_world still = gliding_tank(&none, (sph_stepper)stepper);
    flow_world moves = gliding_tank(&along, (sph_stepper)stepper);
    sph_probe *fixed[KINDS], *rider[KINDS];
    make_riders(&still, fixed);
    make_riders(&moves, rider);
    for (int k = 0; k < KINDS; k++)
      SPH_TEST_OK(moves.context, sph_probe_set_interval(rider[k], 0.01));
    for (int k = 0; k < 160; k++) {
      flow_steps(&still, 1);
      flow_steps(&moves, 1);
      for (int p = 0; p < KINDS && k % 8 == 0; p++) {
        double at_rest[2] = {0}, riding[2] = {0};
        row_of(&still, fixed[p], at_rest);
        row_of(&moves, rider[p], riding);
        if (p == 3)
          for (int d = 0; d < 2; d++) riding[d] -= along.velocity[d];
        for (int d = 0; d < (p == 3 ? 2 : 1); d++)
          SPH_TEST_CLOSE(riding[d], at_rest[d], 0, 1e-8 * scale[p]);
      }
    }
    double speed[2];
    row_of(&still, fixed[3], speed);
    CU_ASSERT(hypot(speed[0], speed[1]) > 0.1);
    for (int k = 0; k < KINDS; k++) {
      sph_probe_destroy(&fixed[k]);
      sph_probe_destroy(&rider[k]);
    }
    flow_free(&still);
    flow_free(&moves);
  }
}

/* The particles' mean lies off the wall: what is between them is the gradient in the wall's frame. */
static void pressure_at_an_accelerated_wall_is_exact(void) {
  double a = 4;
  flow_world w = flow_open((flow_plan){.dx = 0.02, .c0 = 20, .precision = SPH_PRECISION_DOUBLE});
  const double lo[2] = {0, 0}, hi[2] = {0.3, 0.2}, x[2] = {0, 0};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, hi, 0, &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, flow_accelerate, &a));
  flow_build(&w);
  flow_linear_pressure(&w, 5000, (const double[]){-rho0 * a, -rho0 * g});
  sph_probe *probe;
  SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, x, &probe));
  CU_ASSERT(fabs(sample(&w, probe) - 5000) > 20);
  SPH_TEST_OK(w.context, sph_probe_follow(probe, w.boundary, 0));
  SPH_TEST_CLOSE(sample(&w, probe), 5000, 1e-10, 0);
  sph_probe_destroy(&probe);
  flow_free(&w);
}

/* A piston pushes water up: a line and a gauge on it read what new ones do that are put where it is. */
static void run_up_on_a_piston_is_that_where_the_piston_is(void) {
  const glide_of of = {{0.2, 0}};
  flow_world w = flow_open((flow_plan){.dx = 0.02, .c0 = 20});
  const double lo[2] = {0, 0}, hi[2] = {0.6, 0.2}, up[2] = {0, 1};
  const double front[] = {0, 0.8, 0, -0.2}, bed[] = {-0.5, 0, 0.6, 0, 0.6, 0.8};
  sph_wall *tank;
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 3, bed, false, &tank));
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 2, front, false, &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_motion(w.wall, glide, (void *)&of));
  SPH_TEST_OK(w.context, sph_boundary_create(w.context, tank, w.dx, w.interpolator, &w.boundary));
  SPH_TEST_OK(w.context, sph_boundary_add_wall(w.boundary, w.wall));
  SPH_TEST_OK(w.context, sph_wcsph_create(w.context, w.kernel, w.water, w.boundary, &w.flow));
  SPH_TEST_OK(w.context, sph_wcsph_set_sound_speed(w.flow, w.plan.c0));
  flow_linear_pressure(&w, rho0 * g * 0.2, (const double[]){0, -rho0 * g});
  const double toe[2] = {0, 0}, gauge[2] = {0, 0.06};
  sph_probe *line, *point;
  SPH_TEST_OK(w.context, sph_probe_create_elevation(w.flow, toe, up, 0.5, &line));
  SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, gauge, &point));
  SPH_TEST_OK(w.context, sph_probe_follow(line, w.boundary, 1));
  SPH_TEST_OK(w.context, sph_probe_follow(point, w.boundary, 1));
  SPH_TEST_CLOSE(sample(&w, line), 0.2, 0, 0.3 * w.dx);
  double most = 0;
  for (int k = 1; k <= 5; k++) {
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.1 * k));
    const double way = 0.2 * sph_integrator_time(w.flow);
    const double toe_now[2] = {way, 0}, gauge_now[2] = {way, 0.06};
    sph_probe *line_now, *point_now;
    SPH_TEST_OK(w.context, sph_probe_create_elevation(w.flow, toe_now, up, 0.5, &line_now));
    SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, gauge_now, &point_now));
    SPH_TEST_CLOSE(sample(&w, line), sample(&w, line_now), 0, 1e-5);
    SPH_TEST_CLOSE(sample(&w, point), sample(&w, point_now), 0, 1e-3 * rho0 * g * 0.2);
    most = fmax(most, sample(&w, line));
    sph_probe_destroy(&line_now);
    sph_probe_destroy(&point_now);
  }
  CU_ASSERT(most > 0.21); /* the water that the piston takes the room of */
  sph_probe_destroy(&line);
  sph_probe_destroy(&point);
  sph_wall_destroy(&tank);
  flow_free(&w);
}

/* A block of water at rest, and a small wall beside it whose arm sweeps through: the line's far end comes
 * on ten times as fast as the wall, which alone makes the flow list anew. */
static void lines_sweep_with_a_wall_that_rotates(void) {
  double rate = 1;
  const double from = 0.5, dx = 0.02;
  flow_world w = flow_open((flow_plan){.dx = dx, .c0 = 10});
  const double lo[2] = {0, 0}, hi[2] = {1, 1}, pivot[2] = {-0.3, 0.5};
  const double hub[] = {-0.35, 0.45, -0.35, 0.55, -0.25, 0.55, -0.25, 0.45}; /* clockwise */
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, hub, true, &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_rotation(w.wall, pivot, NULL, spin, &rate));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, (const double[]){0, 0}));
  SPH_TEST_OK(w.context, sph_integrator_set_dt(w.flow, 2e-3));
  const double foot[2] = {pivot[0] + from, pivot[1]}, along[2] = {1, 0};
  sph_probe *line;
  SPH_TEST_OK(w.context, sph_probe_create_elevation(w.flow, foot, along, 1.2, &line));
  SPH_TEST_OK(w.context, sph_probe_follow(line, w.boundary, 0));
  for (int k = 0; k <= 20; k++) {
    const double angle = rate * (0.2 + sph_integrator_time(w.flow));
    const double end = fmin(1.3 / cos(angle), 0.5 / sin(angle));
    SPH_TEST_CLOSE(sample(&w, line), end - from, 0, 0.7 * dx); /* corners are round */
    flow_steps(&w, 15);
  }
  sph_probe_destroy(&line);
  flow_free(&w);
}

/* A point far away from the wall that takes it round, about an axis in space. */
static void points_turn_in_space(void) {
  double rate = 2.5;
  flow_world w =
      flow_open((flow_plan){.dim = 3, .dx = 0.1, .c0 = 20, .precision = SPH_PRECISION_DOUBLE});
  const double lo[3] = {-1, -1, -1}, hi[3] = {1, 1, 1};
  const double plate[] = {3, -1, -1, 3, -1, 1, 3, 1, 1, 3, 1, -1};
  const double pivot[3] = {0.1, 0, -0.1}, axis[3] = {1, 2, 2}, x[3] = {0.7, 0.2, -0.3};
  const double slope[3] = {100, -300, 500};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_facets(w.context, 1, plate, &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_rotation(w.wall, pivot, axis, spin, &rate));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, (const double[]){0, 0, 0}));
  sph_probe *probe;
  SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, x, &probe));
  SPH_TEST_OK(w.context, sph_probe_set_interpolator(probe, SPH_INTERPOLATOR_MLS_LINEAR));
  SPH_TEST_OK(w.context, sph_probe_follow(probe, w.boundary, 0));
  for (int k = 0; k < 3; k++) {
    flow_linear_pressure(&w, 5000, slope);
    const double angle = rate * (0.2 + sph_integrator_time(w.flow)), c = cos(angle), s = sin(angle);
    double arm[3], at[3], along = 0, p = 5000;
    for (int d = 0; d < 3; d++) {
      arm[d] = x[d] - pivot[d];
      along += arm[d] * axis[d] / 3;
    }
    for (int d = 0; d < 3; d++) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      at[d] = pivot[d] + c * arm[d] + s * (axis[e] * arm[f] - axis[f] * arm[e]) / 3 +
              (1 - c) * along * axis[d] / 3;
      p += slope[d] * at[d];
    }
    SPH_TEST_CLOSE(sample(&w, probe), p, 1e-9, 0);
    flow_linear_pressure(&w, 0, (const double[]){0, 0, 0});
    double *v = flow_read(&w, SPH_VELOCITY);
    memset(v, 0, 3 * (size_t)sph_particles_count(w.water) * sizeof *v);
    flow_write(&w, SPH_VELOCITY, v);
    free(v);
    flow_steps(&w, 4); /* at rest: nothing but the wall moves */
  }
  sph_probe_destroy(&probe);
  flow_free(&w);
}

/* Water that rotates with its tank as a rigid body, without forces. */
static void points_in_a_tank_that_rotates_read_a_rigid_body(void) {
  double rate = 1.5;
  flow_world w =
      flow_open((flow_plan){.dx = 0.025, .c0 = 20, .kernel = SPH_KERNEL_WENDLAND_C2, .ratio = 1.6});
  const double lo[2] = {-0.5, -0.5}, hi[2] = {0.5, 0.5}, zero[2] = {0, 0}, x[2] = {0.5, 0.1};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  const double c = cos(0.2 * rate), s = sin(0.2 * rate);
  double *place = flow_read(&w, SPH_POSITION), *v = flow_read(&w, SPH_VELOCITY);
  const sph_index n = sph_particles_count(w.water);
  double *p = flow_room(n);
  for (sph_index k = 0; k < n; k++) {
    double *y = place + 2 * k;
    const double at[2] = {c * y[0] - s * y[1], s * y[0] + c * y[1]};
    memcpy(y, at, sizeof at);
    v[2 * k] = -rate * y[1];
    v[2 * k + 1] = rate * y[0];
    p[k] = 2000 + 0.5 * rho0 * rate * rate * (y[0] * y[0] + y[1] * y[1]);
  }
  flow_write(&w, SPH_POSITION, place);
  flow_write(&w, SPH_VELOCITY, v);
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, hi, 0, &w.wall));
  SPH_TEST_OK(w.context, sph_wall_set_rotation(w.wall, zero, NULL, spin, &rate));
  flow_build(&w);
  SPH_TEST_OK(w.context, sph_wcsph_set_gravity(w.flow, zero));
  SPH_TEST_OK(w.context, sph_wcsph_start_from_pressure(w.flow, n, p));
  sph_probe *pressure, *velocity;
  SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, x, &pressure));
  SPH_TEST_OK(w.context, sph_probe_create_velocity(w.flow, x, &velocity));
  SPH_TEST_OK(w.context, sph_probe_follow(pressure, w.boundary, 0));
  SPH_TEST_OK(w.context, sph_probe_follow(velocity, w.boundary, 0));
  const double r2 = x[0] * x[0] + x[1] * x[1], swing = 0.5 * rho0 * rate * rate * r2;
  for (int k = 0; k <= 5; k++) {
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.1 * k));
    double u[2];
    const double angle = rate * (0.2 + 0.1 * k) + atan2(x[1], x[0]);
    SPH_TEST_CLOSE(sample(&w, pressure), 2000 + swing, 0, 0.1 * swing);
    row_of(&w, velocity, u);
    SPH_TEST_CLOSE(u[0], -rate * sqrt(r2) * sin(angle), 0, 0.02 * rate);
    SPH_TEST_CLOSE(u[1], rate * sqrt(r2) * cos(angle), 0, 0.02 * rate);
  }
  sph_probe_destroy(&pressure);
  sph_probe_destroy(&velocity);
  free(place);
  free(v);
  free(p);
  flow_free(&w);
}

static void start_at_rest(const flow_world *w, double depth) {
  double slope[3] = {0};
  slope[w->dim - 1] = -rho0 * g;
  flow_linear_pressure(w, rho0 * g * depth, slope);
}

/* A bed, a left and a right side of their own that reach past each other into the corners: in 3D a trough
 * that repeats along the second axis, 2D the same where `repeats` is false. */
enum { WALLS = 3 };

typedef struct trough {
  flow_world w;
  sph_wall *wall[WALLS];
  double length, depth;
} trough;

static trough open_trough(flow_plan plan, double length, double depth, sph_slip slip) {
  trough t = {.w = flow_open(plan), .length = length, .depth = depth};
  flow_world *w = &t.w;
  const double a = -0.5, b = length + 0.5, past = -0.4, top = 3 * depth, y = 0.4;
  const double plane[WALLS][4] = {{a, 0, b, 0}, {0, top, 0, past}, {length, past, length, top}};
  const double lo[3] = {0, 0, 0}, hi[3] = {length, w->dim == 2 ? depth : y, depth};
  SPH_TEST_OK(w->context, sph_particles_fill_box(w->water, lo, hi, rho0));
  for (int k = 0; k < WALLS; k++) {
    const double *p = plane[k];
    const double corners[] = {p[0], 0, p[1], p[2], 0, p[3], p[2], y, p[3], p[0], y, p[1]};
    if (w->dim == 2)
      SPH_TEST_OK(w->context, sph_wall_create_polyline(w->context, 2, p, false, &t.wall[k]));
    else
      SPH_TEST_OK(w->context, sph_wall_create_facets(w->context, 1, corners, &t.wall[k]));
    SPH_TEST_OK(w->context, sph_wall_set_slip(t.wall[k], slip));
  }
  SPH_TEST_OK(w->context,
              sph_boundary_create(w->context, t.wall[0], w->dx, w->interpolator, &w->boundary));
  for (int k = 1; k < WALLS; k++)
    SPH_TEST_OK(w->context, sph_boundary_add_wall(w->boundary, t.wall[k]));
  SPH_TEST_OK(w->context, sph_wcsph_create(w->context, w->kernel, w->water, w->boundary, &w->flow));
  SPH_TEST_OK(w->context, sph_wcsph_set_sound_speed(w->flow, w->plan.c0));
  if (w->dim == 3) SPH_TEST_OK(w->context, sph_wcsph_set_periodic(w->flow, 1, 0, y));
  start_at_rest(w, depth);
  return t;
}

static void close_trough(trough *t) {
  for (int k = 0; k < WALLS; k++) sph_wall_destroy(&t->wall[k]);
  flow_free(&t->w);
}

/* Disordered water splashes in a trough; momentum changes by gravity and by what all walls take. */
static void reactions_of_all_walls_balance_the_momentum(void) {
  for (int dim = 2; dim <= 3; dim++) {
    for (int single = 0; single <= 1; single++) {
      double bits[2][WALLS][3] = {{{0}}};
      for (int threads = 1; threads <= 2; threads++) {
        trough t = open_trough(
            (flow_plan){.dim = dim,
                        .dx = dim == 2 ? 0.02 : 0.05,
                        .c0 = 20,
                        .precision = single ? SPH_PRECISION_SINGLE : SPH_PRECISION_DOUBLE,
                        .kernel = SPH_KERNEL_WENDLAND_C2,
                        .ratio = dim == 2 ? 1.8 : 1.3,
                        .threads = threads},
            0.6, 0.3, SPH_NO_SLIP);
        flow_jitter(&t.w, 0.1, 7);
        flow_stir(&t.w, 0.3, 8);
        flow_steps(&t.w, 20);
        flow_evaluate(&t.w);
        const sph_index n = sph_particles_count(t.w.water);
        double *m = flow_read(&t.w, SPH_MASS), *a = flow_read(&t.w, "acceleration");
        double left[3] = {0}, size = 0;
        for (int k = 0; k < WALLS; k++) {
          double *force = bits[threads - 1][k];
          SPH_TEST_OK(t.w.context, sph_wcsph_read_reaction(t.w.flow, k, force));
          for (int d = 0; d < dim; d++) {
            left[d] += force[d];
            size += fabs(force[d]);
          }
        }
        for (sph_index i = 0; i < n; i++) {
          for (int d = 0; d < dim; d++) left[d] += m[i] * a[dim * i + d];
          left[dim - 1] += m[i] * g;
        }
        CU_ASSERT(size > 1000 * 9 * 0.6 * 0.3 * (dim == 2 ? 1 : 0.4));
        for (int d = 0; d < dim; d++) SPH_TEST_CLOSE(left[d], 0, 0, (single ? 1e-5 : 1e-12) * size);
        free(m);
        free(a);
        close_trough(&t);
      }
      CU_ASSERT(memcmp(bits[0], bits[1], sizeof bits[0]) == 0);
    }
  }
}

/* Sides reach past the bed, and have the corners' ghosts: what remains is the lattice's quadrature, 0.991 for
 * the cubic and 1.0007 for the quintic spline here. */
static void still_water_pushes_sides_by_half_rho_g_h2(void) {
  static const struct {
    int dim;
    sph_kernel_type kernel;
    double ratio, dx;
  } row[] = {{2, SPH_KERNEL_WENDLAND_C2, 1.6, 0.01},
             {2, SPH_KERNEL_CUBIC_SPLINE, 1.2, 0.01},
             {2, SPH_KERNEL_GAUSSIAN, 1.3, 0.01},
             {2, SPH_KERNEL_QUINTIC_SPLINE, 1.3, 0.01},
             {3, SPH_KERNEL_WENDLAND_C2, 1.4, 0.04}};
  for (int k = 0; k < (int)(sizeof row / sizeof row[0]); k++) {
    trough t = open_trough((flow_plan){.dim = row[k].dim,
                                       .dx = row[k].dx,
                                       .c0 = 40,
                                       .kernel = row[k].kernel,
                                       .ratio = row[k].ratio},
                           0.6, 0.4, SPH_FREE_SLIP);
    const double thick = t.w.dim == 2 ? 1 : 0.4, half = 0.5 * rho0 * g * 0.4 * 0.4 * thick;
    sph_probe *left, *right, *bed;
    SPH_TEST_OK(t.w.context, sph_probe_create_reaction(t.w.flow, t.w.boundary, 0, &bed));
    SPH_TEST_OK(t.w.context, sph_probe_create_reaction(t.w.flow, t.w.boundary, 1, &left));
    SPH_TEST_OK(t.w.context, sph_probe_create_reaction(t.w.flow, t.w.boundary, 2, &right));
    CU_ASSERT_STRING_EQUAL(sph_probe_column_unit(left, 0), t.w.dim == 2 ? "N/m" : "N");
    CU_ASSERT_STRING_EQUAL(sph_probe_name(left), "reaction");
    CU_ASSERT(sample(&t.w, left) == 0);
    flow_evaluate(&t.w);
    SPH_TEST_CLOSE(sample(&t.w, left), -half, 0.01, 0);
    SPH_TEST_CLOSE(sample(&t.w, right), half, 0.01, 0);
    SPH_TEST_CLOSE(sample(&t.w, bed), 0, 0, 1e-4 * half);
    double force[3][3] = {{0}};
    row_of(&t.w, bed, force[0]);
    row_of(&t.w, left, force[1]);
    row_of(&t.w, right, force[2]);
    const int up = t.w.dim - 1;
    SPH_TEST_CLOSE(force[0][up] + force[1][up] + force[2][up], -rho0 * g * 0.6 * 0.4 * thick, 0.03,
                   0);
    sph_probe_destroy(&left);
    sph_probe_destroy(&right);
    sph_probe_destroy(&bed);
    close_trough(&t);
  }
}

/* Ghosts are where the wall is, also where a stepper evaluates them at the beginning of its steps. */
static void reactions_do_not_know_of_a_frame_that_glides(void) {
  const glide_of none = {{0, 0}}, along = {{0.7, 0.3}};
  for (int stepper = SPH_STEPPER_SYMPLECTIC; stepper <= SPH_STEPPER_RK4; stepper++) {
    flow_world still = gliding_tank(&none, (sph_stepper)stepper);
    flow_world moves = gliding_tank(&along, (sph_stepper)stepper);
    for (int k = 0; k < 40; k++) {
      double at_rest[2], riding[2];
      flow_steps(&still, 1);
      flow_steps(&moves, 1);
      SPH_TEST_OK(still.context, sph_wcsph_read_reaction(still.flow, 0, at_rest));
      SPH_TEST_OK(moves.context, sph_wcsph_read_reaction(moves.flow, 0, riding));
      for (int d = 0; d < 2; d++) SPH_TEST_CLOSE(riding[d], at_rest[d], 0, 1e-8 * 600);
      CU_ASSERT(at_rest[1] < -100);
    }
    flow_free(&still);
    flow_free(&moves);
  }
}

static int64_t allocations_left;

static void *limited_allocate(size_t bytes, void *user) {
  (void)user;
  return allocations_left-- > 0 ? malloc(bytes) : NULL;
}

static void plain_release(void *memory, void *user) {
  (void)user;
  free(memory);
}

static void wrong_walls_are_refused(void) {
  const sph_allocator allocator = {limited_allocate, plain_release, NULL};
  allocations_left = INT64_MAX;
  flow_world w = flow_open((flow_plan){.dx = 0.05, .c0 = 20, .allocator = &allocator});
  const glide_of none = {{0, 0}};
  flow_world other = gliding_tank(&none, SPH_STEPPER_RK4);
  const double lo[2] = {0, 0}, hi[2] = {0.5, 0.5}, x[2] = {0, 0.2};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, hi, 0, &w.wall));
  flow_build(&w);
  flow_linear_pressure(&w, rho0 * g * 0.5, (const double[]){0, -rho0 * g});
  sph_probe *probe, *mass;
  SPH_TEST_OK(w.context, sph_probe_create_pressure(w.flow, x, &probe));
  SPH_TEST_OK(w.context, sph_probe_create_mass(w.flow, &mass));
  CU_ASSERT(sph_probe_follow(NULL, w.boundary, 0) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(w.context, sph_probe_follow(probe, NULL, 0), SPH_E_ARGUMENT, "boundary is NULL");
  SPH_TEST_STATUS(w.context, sph_probe_follow(probe, other.boundary, 0), SPH_E_ARGUMENT,
                  "not the one");
  SPH_TEST_STATUS(w.context, sph_probe_follow(probe, w.boundary, 1), SPH_E_ARGUMENT,
                  "wall must be 0 to 0, got 1");
  SPH_TEST_STATUS(w.context, sph_probe_follow(probe, w.boundary, -1), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(w.context, sph_probe_follow(mass, w.boundary, 0), SPH_E_TYPE, "no points");
  allocations_left = 0;
  SPH_TEST_STATUS(w.context, sph_probe_follow(probe, w.boundary, 0), SPH_E_MEMORY, "no memory");
  allocations_left = INT64_MAX;
  const double before = sample(&w, probe);
  SPH_TEST_OK(w.context, sph_probe_follow(probe, w.boundary, 0));
  SPH_TEST_OK(w.context, sph_probe_follow(probe, w.boundary, 0));
  CU_ASSERT(sample(&w, probe) == before); /* a wall at rest */
  flow_free(&other);
  /* The probe keeps the boundary, and with it the wall. */
  sph_boundary_destroy(&w.boundary);
  sph_wall_destroy(&w.wall);
  CU_ASSERT(sample(&w, probe) == before);
  sph_probe_destroy(&probe);
  sph_probe_destroy(&mass);
  flow_free(&w);
}

static void wrong_reactions_are_refused(void) {
  const sph_allocator allocator = {limited_allocate, plain_release, NULL};
  allocations_left = INT64_MAX;
  flow_world w = flow_open((flow_plan){.dx = 0.05, .allocator = &allocator});
  const double lo[2] = {0, 0}, hi[2] = {0.5, 0.5};
  double force[2] = {3, 4};
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, hi, 0, &w.wall));
  flow_build(&w);
  CU_ASSERT(sph_wcsph_read_reaction(NULL, 0, force) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(w.context, sph_wcsph_read_reaction(w.flow, 0, NULL), SPH_E_ARGUMENT,
                  "force is NULL");
  SPH_TEST_STATUS(w.context, sph_wcsph_read_reaction(w.flow, 1, force), SPH_E_ARGUMENT,
                  "wall must be 0 to 0, got 1");
  SPH_TEST_STATUS(w.context, sph_wcsph_read_reaction(w.flow, -1, force), SPH_E_ARGUMENT, "got -1");
  SPH_TEST_STATUS(w.context, sph_wcsph_read_reaction(w.flow, 0, force), SPH_E_ARGUMENT,
                  "sound speed is not set");
  SPH_TEST_OK(w.context, sph_wcsph_set_sound_speed(w.flow, 20));
  flow_steps(&w, 1);
  allocations_left = 0;
  SPH_TEST_STATUS(w.context, sph_wcsph_read_reaction(w.flow, 0, force), SPH_E_MEMORY, "no memory");
  allocations_left = INT64_MAX;
  CU_ASSERT(force[0] == 3 && force[1] == 4);
  SPH_TEST_OK(w.context, sph_wcsph_read_reaction(w.flow, 0, force));
  sph_probe *probe;
  SPH_TEST_STATUS(w.context, sph_probe_create_reaction(w.flow, NULL, 0, &probe), SPH_E_ARGUMENT,
                  "\"reaction\": boundary is NULL");
  SPH_TEST_STATUS(w.context, sph_probe_create_reaction(w.flow, w.boundary, 1, &probe),
                  SPH_E_ARGUMENT, "wall must be 0 to 0");
  SPH_TEST_STATUS(w.context, sph_probe_create_reaction(w.flow, w.boundary, 0, NULL), SPH_E_ARGUMENT,
                  "out is NULL");
  CU_ASSERT(sph_probe_create_reaction(NULL, w.boundary, 0, &probe) == SPH_E_ARGUMENT && !probe);
  sph_integrator_destroy(&w.flow);
  SPH_TEST_OK(w.context, sph_wcsph_create(w.context, w.kernel, w.water, NULL, &w.flow));
  SPH_TEST_STATUS(w.context, sph_wcsph_read_reaction(w.flow, 0, force), SPH_E_ARGUMENT, "no walls");
  flow_free(&w);
}

SPH_TEST_MAIN(
    "probes on walls",
    {"riders read what fixed probes read in the tank at rest",
     riders_read_what_fixed_probes_read_at_rest},
    {"the pressure at an accelerated wall is exact", pressure_at_an_accelerated_wall_is_exact},
    {"the run-up on a piston is that where the piston is",
     run_up_on_a_piston_is_that_where_the_piston_is},
    {"lines sweep with a wall that rotates", lines_sweep_with_a_wall_that_rotates},
    {"points turn in space", points_turn_in_space},
    {"points in a tank that rotates read a rigid body",
     points_in_a_tank_that_rotates_read_a_rigid_body},
    {"wrong walls are refused", wrong_walls_are_refused},
    {"reactions of all walls balance the momentum", reactions_of_all_walls_balance_the_momentum},
    {"still water pushes sides by rho g H^2 / 2", still_water_pushes_sides_by_half_rho_g_h2},
    {"reactions do not know of a frame that glides", reactions_do_not_know_of_a_frame_that_glides},
    {"wrong reactions are refused", wrong_reactions_are_refused})
