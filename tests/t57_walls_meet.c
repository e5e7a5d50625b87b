/* Walls of their own that meet in corners, move, turn and are driven: who has which place, what ghosts
 * there get, forces, and flows. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81, pi = 3.14159265358979323846;

enum { BED, LEFT, RIGHT, WALLS };

/* A tank of three walls that reach past each other: bed, left and right side. */
typedef struct three_walls {
  flow_world w;
  sph_wall *wall[WALLS];
  double length, depth;
} three_walls;

static three_walls open_tank(flow_plan plan, double length, double depth) {
  three_walls t = {.length = length, .depth = depth};
  t.w = flow_open(plan);
  sph_context *context = t.w.context;
  const double past = 8 * plan.dx, lo[2] = {0, 0}, hi[2] = {length, depth};
  const double bed[] = {-0.5, 0, length + 0.5, 0}, left[] = {0, 3 * depth, 0, -past};
  const double right[] = {length, -past, length, 3 * depth};
  const double *const lines[WALLS] = {bed, left, right};
  SPH_TEST_OK(context, sph_particles_fill_box(t.w.water, lo, hi, rho0));
  for (int k = 0; k < WALLS; k++)
    SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, lines[k], false, &t.wall[k]));
  return t;
}

static void build_tank(three_walls *t) {
  flow_world *w = &t->w;
  SPH_TEST_OK(w->context,
              sph_boundary_create(w->context, t->wall[0], w->dx, w->interpolator, &w->boundary));
  for (int k = 1; k < WALLS; k++)
    SPH_TEST_OK(w->context, sph_boundary_add_wall(w->boundary, t->wall[k]));
  SPH_TEST_OK(w->context, sph_wcsph_create(w->context, w->kernel, w->water, w->boundary, &w->flow));
  SPH_TEST_OK(w->context, sph_wcsph_set_sound_speed(w->flow, w->plan.c0));
}

static void close_tank(three_walls *t) {
  for (int k = 0; k < WALLS; k++) sph_wall_destroy(&t->wall[k]);
  flow_free(&t->w);
}

static double *ghost_values(const flow_world *w, sph_ghost_value what) {
  const int64_t n = sph_boundary_count(w->boundary) * (what <= SPH_GHOST_VELOCITY ? w->dim : 1);
  double *values = flow_room(n);
  SPH_TEST_OK(w->context, sph_boundary_read(w->boundary, what, values, n));
  return values;
}

/* At `user` for all times, at rest. */
static void stand(double t, double *displacement, double *velocity, double *acceleration,
                  void *user) {
  (void)t, (void)velocity, (void)acceleration;
  displacement[0] = *(const double *)user;
}

/* Wherever a side stands, the solid below and beside the water is filled once: the volumes of ghosts
 * add up to the area that the layers have, and in still water each holds the pressure of its place. */
static void corners_have_one_ghost_a_place(void) {
  const double dx = 0.05, depth = 0.5, length = 1;
  for (int k = 0; k < 7; k++) {
    double at = -dx * k / 6;
    three_walls t = open_tank((flow_plan){.dx = dx, .c0 = 40, .precision = SPH_PRECISION_DOUBLE},
                              length, depth);
    SPH_TEST_OK(t.w.context, sph_wall_set_motion(t.wall[LEFT], stand, &at));
    build_tank(&t);
    SPH_TEST_OK(t.w.context, sph_boundary_set_no_suction(t.w.boundary, false));
    SPH_TEST_OK(t.w.context, sph_boundary_set_thin_threshold(t.w.boundary, 0));
    const double slope[2] = {0, -rho0 * g};
    flow_linear_pressure(&t.w, rho0 * g * depth, slope);
    flow_evaluate(&t.w);
    double *x = ghost_values(&t.w, SPH_GHOST_POSITION), *v = ghost_values(&t.w, SPH_GHOST_VOLUME);
    double *p = ghost_values(&t.w, SPH_GHOST_PRESSURE), *m = ghost_values(&t.w, SPH_GHOST_MIRROR);
    double below = 0, left = 0, worst = 0;
    int hidden = 0, dry = 0;
    for (int64_t i = 0; i < sph_boundary_count(t.w.boundary); i++) {
      const double *y = x + 2 * i;
      const bool near = y[0] > at - 2 * dx && y[0] < length + 2 * dx && y[1] > -2 * dx;
      if (near && y[1] < 0) below += v[i];
      if (near && y[1] > 0 && y[1] < depth && y[0] < length / 2) left += v[i];
      hidden += near && y[1] < 0 && v[i] == 0;
      if (v[i] == 0) continue;
      worst = fmax(worst, fabs(p[i] - rho0 * g * (depth - y[1])) / (rho0 * g * depth));
      dry += m[2 * i] < at || m[2 * i] > length || m[2 * i + 1] < 0;
    }
    SPH_TEST_CLOSE(below, 2 * dx * (length - at + 4 * dx), 1e-12, 0);
    SPH_TEST_CLOSE(left, 2 * dx * depth, 1e-12, 0);
    SPH_TEST_BELOW(worst, 1e-9);
    CU_ASSERT(hidden > 0 && dry == 0);
    free(x), free(v), free(p), free(m);
    close_tank(&t);
  }
}

/* Each side carries half rho g H^2, the bed the weight above it, whatever of them lies hidden. */
static void forces_end_at_corners(void) {
  const double dx = 0.05, depth = 0.5, length = 1;
  for (int k = 0; k < 5; k++) {
    double at = -dx * k / 5;
    three_walls t = open_tank((flow_plan){.dx = dx, .c0 = 40, .precision = SPH_PRECISION_DOUBLE},
                              length, depth);
    SPH_TEST_OK(t.w.context, sph_wall_set_motion(t.wall[LEFT], stand, &at));
    build_tank(&t);
    SPH_TEST_OK(t.w.context, sph_boundary_set_thin_threshold(t.w.boundary, 0));
    const double slope[2] = {0, -rho0 * g};
    flow_linear_pressure(&t.w, rho0 * g * depth, slope);
    flow_evaluate(&t.w);
    double force[WALLS][2];
    for (int wall = 0; wall < WALLS; wall++)
      SPH_TEST_OK(t.w.context, sph_boundary_read_force(t.w.boundary, wall, force[wall]));
    const double side = 0.5 * rho0 * g * depth * depth;
    SPH_TEST_CLOSE(force[LEFT][0], -side, 1e-9, 0);
    SPH_TEST_CLOSE(force[RIGHT][0], side, 1e-9, 0);
    SPH_TEST_CLOSE(force[BED][1], -rho0 * g * depth * (length - at), 1e-9, 0);
    SPH_TEST_CLOSE(force[BED][0], 0, 0, 1e-9 * side);
    close_tank(&t);
  }
}

/* Left and right side move towards each other: a ghost in a corner reflects in both walls, each in its
 * own frame, and the pressure knows both accelerations. */
typedef struct uniform_motion {
  double velocity, acceleration;
} uniform_motion;
static void slide(double t, double *displacement, double *velocity, double *acceleration,
                  void *user) {
  const uniform_motion *m = user;
  displacement[0] = m->velocity * t + 0.5 * m->acceleration * t * t;
  velocity[0] = m->velocity + m->acceleration * t;
  acceleration[0] = m->acceleration;
}

static void corners_reflect_in_both_walls(void) {
  const double dx = 0.05, depth = 0.5, length = 1, u[2] = {0.3, -0.2};
  uniform_motion motion = {0.7, 5};
  three_walls t =
      open_tank((flow_plan){.dx = dx, .c0 = 40, .precision = SPH_PRECISION_DOUBLE}, length, depth);
  SPH_TEST_OK(t.w.context, sph_wall_set_motion(t.wall[LEFT], slide, &motion));
  build_tank(&t);
  SPH_TEST_OK(t.w.context, sph_boundary_set_no_suction(t.w.boundary, false));
  SPH_TEST_OK(t.w.context, sph_boundary_set_thin_threshold(t.w.boundary, 0));
  const int64_t n = sph_particles_count(t.w.water);
  double *v = flow_room(2 * n);
  for (int64_t i = 0; i < 2 * n; i++) v[i] = u[i % 2];
  flow_write(&t.w, SPH_VELOCITY, v);
  free(v);
  const double slope[2] = {-rho0 * motion.acceleration, -rho0 * g}; /* exact beside the piston */
  flow_linear_pressure(&t.w, rho0 * g * depth, slope);
  flow_evaluate(&t.w);
  double *x = ghost_values(&t.w, SPH_GHOST_POSITION),
         *volume = ghost_values(&t.w, SPH_GHOST_VOLUME);
  double *p = ghost_values(&t.w, SPH_GHOST_PRESSURE), *w = ghost_values(&t.w, SPH_GHOST_VELOCITY);
  int corner = 0;
  for (int64_t i = 0; i < sph_boundary_count(t.w.boundary); i++) {
    const double *y = x + 2 * i;
    if (volume[i] == 0 || y[0] > length / 2) continue;
    const bool beside = y[0] < 0, under = y[1] < 0;
    SPH_TEST_CLOSE(w[2 * i], beside ? 2 * motion.velocity - u[0] : u[0], 0, 1e-9);
    SPH_TEST_CLOSE(w[2 * i + 1], under ? -u[1] : u[1], 0, 1e-9);
    const double exact = rho0 * g * (depth - y[1]) - rho0 * motion.acceleration * y[0];
    SPH_TEST_CLOSE(p[i], exact, 0, 1e-9 * rho0 * g * depth);
    corner += beside && under;
  }
  CU_ASSERT(corner >= 9);
  free(x), free(volume), free(p), free(w);
  close_tank(&t);
}

/* A flap turned about its foot: ghosts, mirrors and normals are those of a wall created leaning, and the
 * velocity of the wall grows with the distance from the hinge. */
typedef struct tilt {
  double angle, rate, acceleration;
} tilt;
static void hold_tilt(double t, double *angle, double *rate, double *acceleration, void *user) {
  const tilt *of = user;
  (void)t;
  *angle = of->angle;
  *rate = of->rate;
  *acceleration = of->acceleration;
}

static void flaps_turn(void) {
  const double dx = 0.05, depth = 0.5, length = 1, hinge[2] = {0, 0};
  tilt lean = {pi / 12, 0.4, 3}; /* counterclockwise: the flap's top goes to -x, off the water */
  const double past = 8 * dx, c = cos(lean.angle), s = sin(lean.angle);
  three_walls t =
      open_tank((flow_plan){.dx = dx, .c0 = 40, .precision = SPH_PRECISION_DOUBLE}, length, depth);
  SPH_TEST_OK(t.w.context, sph_wall_set_rotation(t.wall[LEFT], hinge, NULL, hold_tilt, &lean));
  build_tank(&t);
  SPH_TEST_OK(t.w.context, sph_boundary_set_no_suction(t.w.boundary, false));
  SPH_TEST_OK(t.w.context, sph_boundary_set_thin_threshold(t.w.boundary, 0));
  const double slope[2] = {0, -rho0 * g};
  flow_linear_pressure(&t.w, rho0 * g * depth, slope);
  flow_evaluate(&t.w);
  /* The same wall, created where it is. */
  const double leaning[] = {-3 * depth * s, 3 * depth * c, past * s, -past * c};
  sph_wall *wall;
  sph_boundary *alone;
  sph_context *context = t.w.context;
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, leaning, false, &wall));
  SPH_TEST_OK(context, sph_boundary_create(context, wall, dx, t.w.interpolator, &alone));
  const int64_t n = sph_boundary_count(alone);
  double *there = flow_room(2 * n);
  SPH_TEST_OK(context, sph_boundary_read(alone, SPH_GHOST_POSITION, there, 2 * n));
  double *x = ghost_values(&t.w, SPH_GHOST_POSITION), *foot = ghost_values(&t.w, SPH_GHOST_FOOT);
  double *u = ghost_values(&t.w, SPH_GHOST_VELOCITY), *p = ghost_values(&t.w, SPH_GHOST_PRESSURE);
  double *volume = ghost_values(&t.w, SPH_GHOST_VOLUME),
         *normal = ghost_values(&t.w, SPH_GHOST_NORMAL);
  double *rung = ghost_values(&t.w, SPH_GHOST_RUNG);
  /* The flap's ghosts follow the bed's. */
  int64_t first = 0, seen = 0;
  while (!(x[2 * first + 1] > 0.1)) first++;
  while (first > 0 && fabs(normal[2 * first - 2] - c) < 1e-9) first--;
  for (int64_t k = 0; k < n; k++) {
    const int64_t i = first + k;
    for (int d = 0; d < 2; d++) SPH_TEST_CLOSE(x[2 * i + d], there[2 * k + d], 0, 1e-12);
    SPH_TEST_CLOSE(normal[2 * i], c, 0, 1e-12);
    SPH_TEST_CLOSE(normal[2 * i + 1], s, 0, 1e-12);
    if (volume[i] == 0 || foot[2 * i + 1] < 0 || foot[2 * i + 1] > 0.8 * depth) continue;
    /* Water at rest: the ghost has twice the wall's velocity across it, and the pressure that belongs to
     * gravity and to the wall's acceleration at the foot. */
    const double r = hypot(foot[2 * i], foot[2 * i + 1]),
                 to = hypot(x[2 * i] - foot[2 * i], x[2 * i + 1] - foot[2 * i + 1]);
    for (int d = 0; d < 2; d++)
      SPH_TEST_CLOSE(u[2 * i + d], -2 * lean.rate * r * (d == 0 ? c : s), 0, 1e-9);
    /* Where the flap has left a gap a fall-back extrapolates. */
    if (rung[i] != SPH_INTERPOLATOR_MLS_LINEAR) continue;
    const double out = lean.acceleration * r; /* along the outward normal */
    SPH_TEST_CLOSE(p[i], rho0 * g * (depth - x[2 * i + 1]) - rho0 * out * 2 * to, 0,
                   1e-9 * rho0 * g * depth);
    seen++;
  }
  CU_ASSERT(seen > 10);
  free(x), free(foot), free(u), free(p), free(volume), free(normal), free(there), free(rung);
  sph_boundary_destroy(&alone);
  sph_wall_destroy(&wall);
  close_tank(&t);
}

/* Values of the last evaluation outlive new lists. */
static void values_outlive_lists(void) {
  three_walls t = open_tank((flow_plan){.dx = 0.05, .c0 = 40}, 1, 0.5);
  build_tank(&t);
  const double slope[2] = {0, -rho0 * g};
  flow_linear_pressure(&t.w, rho0 * g * 0.5, slope);
  flow_steps(&t.w, 3);
  double before[2], after[2], foot[2] = {0.5, 0}, up[2] = {0, 1};
  SPH_TEST_OK(t.w.context, sph_boundary_read_force(t.w.boundary, RIGHT, before));
  double *p = ghost_values(&t.w, SPH_GHOST_PRESSURE), *x = flow_read(&t.w, SPH_POSITION);
  flow_write(&t.w, SPH_POSITION, x); /* all lists are out of date */
  sph_probe *gauge;
  SPH_TEST_OK(t.w.context, sph_probe_create_elevation(t.w.flow, foot, up, 1, &gauge));
  SPH_TEST_OK(t.w.context, sph_probe_sample(gauge));
  SPH_TEST_OK(t.w.context, sph_boundary_read_force(t.w.boundary, RIGHT, after));
  double *again = ghost_values(&t.w, SPH_GHOST_PRESSURE);
  CU_ASSERT(before[0] > 0 && before[0] == after[0]);
  CU_ASSERT(!memcmp(p, again, (size_t)sph_boundary_count(t.w.boundary) * sizeof *p));
  free(p), free(x), free(again);
  sph_probe_destroy(&gauge);
  close_tank(&t);
}

/* Water holds a wall on a damped spring where rho g h^2/2 = k x, h = A/(L + x), in the mean over the
 * sloshing; sound between the walls does not grow. With 1 and 2 threads the same bits. */
static void spring_finds_its_place(void) {
  const double dx = 0.02, depth = 0.2, length = 0.5, k = 4000, along[2] = {1, 0};
  double early[2] = {0};
  for (int threads = 1; threads <= 2; threads++) {
    three_walls t = open_tank(
        (flow_plan){
            .dx = dx, .c0 = 20, .boundary = SPH_INTERPOLATOR_IMPROVED_SHEPARD, .threads = threads},
        length, depth);
    sph_body *body;
    SPH_TEST_OK(t.w.context, sph_body_create(t.w.context, 40, &body));
    SPH_TEST_OK(t.w.context, sph_body_set_spring(body, k, 0));
    SPH_TEST_OK(t.w.context, sph_body_set_damping(body, 600));
    SPH_TEST_OK(t.w.context, sph_wall_set_body(t.wall[RIGHT], body, along));
    build_tank(&t);
    const int64_t n = sph_particles_count(t.w.water);
    double *x = flow_read(&t.w, SPH_POSITION), *y = flow_room(n), *p = flow_room(n);
    for (int64_t i = 0; i < n; i++) y[i] = x[2 * i + 1];
    SPH_TEST_OK(t.w.context, sph_initial_hydrostatic(t.w.context, depth, g, rho0, 20, n, y, p));
    SPH_TEST_OK(t.w.context, sph_wcsph_start_from_pressure(t.w.flow, n, p));
    SPH_TEST_OK(t.w.context, sph_integrator_advance(t.w.flow, 0.3));
    SPH_TEST_OK(t.w.context, sph_body_get_state(body, &early[threads - 1], NULL, NULL, NULL));
    double mean = 0, exact = 0, at, force[2], least = HUGE_VAL, most = 0;
    enum { SAMPLES = 50 };
    for (int s = 0; s < SAMPLES && threads == 1; s++) {
      SPH_TEST_OK(t.w.context, sph_integrator_advance(t.w.flow, 2 + 0.04 * s));
      SPH_TEST_OK(t.w.context, sph_body_get_state(body, &at, NULL, NULL, NULL));
      SPH_TEST_OK(t.w.context, sph_boundary_read_force(t.w.boundary, RIGHT, force));
      mean += at / SAMPLES;
      least = fmin(least, force[0]);
      most = fmax(most, force[0]);
    }
    for (int it = 0; it < 50; it++)
      exact = 0.5 * rho0 * g * pow(depth * length / (length + exact), 2) / k;
    if (threads == 1) {
      SPH_TEST_CLOSE(mean, exact, 0.02, 0);
      SPH_TEST_CLOSE(least, k * exact, 0.2, 0);
      SPH_TEST_CLOSE(most, k * exact, 0.2, 0);
    }
    free(x), free(y), free(p);
    sph_body_destroy(&body);
    close_tank(&t);
  }
  CU_ASSERT(early[0] > 0.03 && early[0] == early[1]);
}

/* A tank of five plates in 3D that reach past each other: bed, both ends, both sides. */
enum { PLATES = 5, END = 1 };
typedef struct five_plates {
  flow_world w;
  sph_wall *wall[PLATES];
} five_plates;

static const double size[3] = {0.5, 0.4, 0.4}; /* length, width and depth of the water */

/* A plate across an axis that reaches `past` the water. */
static sph_wall *open_plate(sph_context *context, int axis, bool high, double past) {
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  double corners[4][3];
  sph_wall *wall = NULL;
  for (int k = 0; k < 4; k++) {
    const int turn = high ? 3 - k : k; /* counterclockwise as the water sees it */
    corners[k][axis] = high ? size[axis] : 0;
    corners[k][a] = turn == 0 || turn == 3 ? -past : size[a] + past;
    corners[k][b] = turn < 2 ? -past : size[b] + past;
  }
  SPH_TEST_OK(context, sph_wall_create_facets(context, 1, corners[0], &wall));
  return wall;
}

static five_plates open_plates(double dx, double *at) {
  const double lo[3] = {0}, slope[3] = {0, 0, -rho0 * g};
  const flow_plan plan = {.dim = 3, .dx = dx, .c0 = 40, .precision = SPH_PRECISION_DOUBLE};
  five_plates t = {.w = flow_open(plan)};
  sph_context *context = t.w.context;
  SPH_TEST_OK(context, sph_particles_fill_box(t.w.water, lo, size, rho0));
  for (int k = 0; k < PLATES; k++)
    t.wall[k] = open_plate(context, k == 0 ? 2 : (k - 1) / 2, k > 0 && k % 2 == 0, 8 * dx);
  SPH_TEST_OK(context, sph_wall_set_motion(t.wall[END], stand, at));
  t.w.wall = t.wall[0];
  SPH_TEST_OK(context, sph_boundary_create(context, t.w.wall, dx, t.w.interpolator, &t.w.boundary));
  for (int k = 1; k < PLATES; k++)
    SPH_TEST_OK(context, sph_boundary_add_wall(t.w.boundary, t.wall[k]));
  SPH_TEST_OK(context, sph_boundary_set_no_suction(t.w.boundary, false));
  SPH_TEST_OK(context, sph_boundary_set_thin_threshold(t.w.boundary, 0));
  SPH_TEST_OK(context, sph_wcsph_create(context, t.w.kernel, t.w.water, t.w.boundary, &t.w.flow));
  SPH_TEST_OK(context, sph_wcsph_set_sound_speed(t.w.flow, plan.c0));
  flow_linear_pressure(&t.w, rho0 * g * size[2], slope);
  return t;
}

static void close_plates(five_plates *t) {
  for (int k = 1; k < PLATES; k++) sph_wall_destroy(&t->wall[k]);
  flow_free(&t->w);
}

/* The same in 3D. Edges reflect in both walls; corners of three walls are filled once too, and hold the
 * pressure of their place. */
static void corners_have_one_ghost_a_place_in_3d(void) {
  const double dx = 0.05, u[3] = {0.3, -0.2, 0.1};
  for (int k = 0; k < 4; k++) {
    double at = -dx * k / 3;
    five_plates t = open_plates(dx, &at);
    const int64_t n = 3 * (int64_t)sph_particles_count(t.w.water);
    double *moving = flow_room(n);
    for (int64_t i = 0; i < n; i++) moving[i] = u[i % 3];
    flow_write(&t.w, SPH_VELOCITY, moving);
    flow_evaluate(&t.w);
    double *x = ghost_values(&t.w, SPH_GHOST_POSITION), *v = ghost_values(&t.w, SPH_GHOST_VOLUME);
    double *p = ghost_values(&t.w, SPH_GHOST_PRESSURE), *m = ghost_values(&t.w, SPH_GHOST_MIRROR);
    double *w = ghost_values(&t.w, SPH_GHOST_VELOCITY), below = 0, beside = 0, behind = 0;
    double worst_pressure = 0, worst_velocity = 0;
    int dry = 0, by_walls[4] = {0};
    for (int64_t i = 0; i < sph_boundary_count(t.w.boundary); i++) {
      const double *y = x + 3 * i, *from = m + 3 * i;
      if (v[i] == 0) continue;
      const bool across[3] = {y[0] < at || y[0] > size[0], y[1] < 0 || y[1] > size[1], y[2] < 0};
      const int walls = across[0] + across[1] + across[2];
      by_walls[walls]++;
      worst_pressure = fmax(worst_pressure, fabs(p[i] - rho0 * g * (size[2] - y[2])));
      if (y[0] > at - 2 * dx && y[0] < size[0] + 2 * dx && y[1] > -2 * dx &&
          y[1] < size[1] + 2 * dx && y[2] > -2 * dx && y[2] < size[2])
        *(across[2] ? &below : across[1] ? &beside : &behind) += v[i];
      if (walls == 3) continue;
      for (int d = 0; d < 3; d++)
        worst_velocity = fmax(worst_velocity, fabs(w[3 * i + d] - (across[d] ? -u[d] : u[d])));
      dry += from[0] < at || from[0] > size[0] || from[1] < 0 || from[1] > size[1] || from[2] < 0;
    }
    const double length = size[0] - at + 4 * dx;
    SPH_TEST_CLOSE(below, 2 * dx * length * (size[1] + 4 * dx), 1e-12, 0);
    SPH_TEST_CLOSE(beside, 4 * dx * length * size[2], 1e-12, 0);
    SPH_TEST_CLOSE(behind, 4 * dx * size[1] * size[2], 1e-12, 0);
    SPH_TEST_BELOW(worst_pressure, 1e-9 * rho0 * g * size[2]);
    SPH_TEST_BELOW(worst_velocity, 1e-9);
    CU_ASSERT(by_walls[0] == 0 && by_walls[1] > 0 && by_walls[2] > 0 && by_walls[3] > 0);
    CU_ASSERT_EQUAL(dry, 0);
    free(moving), free(x), free(v), free(p), free(m), free(w);
    close_plates(&t);
  }
}

static void swing_flap(double t, double *angle, double *rate, double *acceleration, void *user) {
  const double most = *(const double *)user, omega = 2 * pi / 0.8;
  const double ramp = t < 0.8 ? 0.5 * (1 - cos(pi * t / 0.8)) : 1;
  const double slope = t < 0.8 ? 0.5 * pi / 0.8 * sin(pi * t / 0.8) : 0;
  const double bend = t < 0.8 ? 0.5 * pow(pi / 0.8, 2) * cos(pi * t / 0.8) : 0;
  const double s = sin(omega * t), c = cos(omega * t);
  *angle = most * ramp * s;
  *rate = most * (slope * s + ramp * omega * c);
  *acceleration = most * (bend * s + 2 * slope * omega * c - ramp * omega * omega * s);
}

/* A flap swings through three periods: it makes waves, no particle leaves the tank, the energy stays of the
 * size of what the flap puts in, and 1 and 2 threads give the same bits. */
static void flaps_make_waves(void) {
  const double dx = 0.02, depth = 0.2, length = 0.6, hinge[2] = {0, 0}, rest[2] = {0, -rho0 * g};
  const sph_index n = 300;
  double *early[2] = {NULL}, lean = 0.12;
  for (int threads = 2; threads >= 1; threads--) {
    three_walls t = open_tank(
        (flow_plan){
            .dx = dx, .c0 = 15, .boundary = SPH_INTERPOLATOR_IMPROVED_SHEPARD, .threads = threads},
        length, depth);
    SPH_TEST_OK(t.w.context, sph_wall_set_rotation(t.wall[LEFT], hinge, NULL, swing_flap, &lean));
    build_tank(&t);
    flow_linear_pressure(&t.w, rho0 * g * depth, rest);
    sph_probe *energy;
    SPH_TEST_OK(t.w.context, sph_probe_create_energy(t.w.flow, &energy));
    SPH_TEST_OK(t.w.context, sph_probe_sample(energy));
    double start[4], now[4], most = 0, swing = 0;
    SPH_TEST_OK(t.w.context, sph_probe_last(energy, start));
    const int count = threads == 2 ? 16 : 48;
    for (int k = 1; k <= count; k++) {
      SPH_TEST_OK(t.w.context, sph_integrator_advance(t.w.flow, 0.05 * k));
      SPH_TEST_OK(t.w.context, sph_probe_last(energy, now));
      most = fmax(most, fabs(now[3] - start[3]));
      swing = fmax(swing, now[0]);
      if (k == 16) early[threads - 1] = flow_read(&t.w, SPH_POSITION);
    }
    if (threads == 1) {
      CU_ASSERT_EQUAL(sph_particles_count(t.w.water), n);
      double *x = flow_read(&t.w, SPH_POSITION), nearest = HUGE_VAL;
      for (sph_index i = 0; i < n; i++)
        for (int k = 0; k < WALLS; k++) {
          double distance;
          SPH_TEST_OK(t.w.context, sph_wall_distance(t.wall[k], sph_integrator_time(t.w.flow),
                                                     x + 2 * i, &distance));
          nearest = fmin(nearest, distance);
        }
      SPH_TEST_BELOW(0, nearest);
      SPH_TEST_BELOW(0.005 * start[3], swing);
      SPH_TEST_BELOW(most, 0.05 * start[3]);
      free(x);
    }
    sph_probe_destroy(&energy);
    close_tank(&t);
  }
  CU_ASSERT(!memcmp(early[0], early[1], 2 * (size_t)n * sizeof *early[0]));
  free(early[0]), free(early[1]);
}

static sph_status give_up(double t, double dt, const double *force, double *displacement,
                          double *velocity, double *acceleration, void *user) {
  (void)force, (void)displacement, (void)velocity, (void)acceleration;
  return t + dt > *(const double *)user ? SPH_E_UNSUPPORTED : SPH_OK;
}

/* A caller's driver that gives up ends that step with its status, and the message names the wall. */
static void drivers_stop_steps(void) {
  const double slope[2] = {0, -rho0 * g};
  double last = 0.02;
  three_walls t = open_tank((flow_plan){.dx = 0.05, .c0 = 40}, 1, 0.5);
  SPH_TEST_OK(t.w.context, sph_wall_set_name(t.wall[RIGHT], "gate"));
  SPH_TEST_OK(t.w.context, sph_wall_set_driver(t.wall[RIGHT], give_up, &last));
  build_tank(&t);
  flow_linear_pressure(&t.w, rho0 * g * 0.5, slope);
  SPH_TEST_STATUS(t.w.context, sph_integrator_advance(t.w.flow, 1), SPH_E_UNSUPPORTED,
                  "wall \"gate\": its driver stopped the run at t = 0.0");
  const double stopped = sph_integrator_time(t.w.flow);
  CU_ASSERT(stopped > 0.5 * last && stopped <= last);
  double *x = flow_read(&t.w, SPH_POSITION);
  /* What it stopped is as it was, and goes on when the driver does. */
  SPH_TEST_STATUS(t.w.context, sph_integrator_step(t.w.flow), SPH_E_UNSUPPORTED, "\"gate\"");
  double *again = flow_read(&t.w, SPH_POSITION);
  CU_ASSERT(!memcmp(x, again, 2 * (size_t)sph_particles_count(t.w.water) * sizeof *x));
  last = 1;
  SPH_TEST_OK(t.w.context, sph_integrator_step(t.w.flow));
  CU_ASSERT(sph_integrator_time(t.w.flow) > stopped);
  free(x), free(again);
  close_tank(&t);
}

/* A particle behind one wall is found though another is nearer. */
static void particles_behind_walls_are_found(void) {
  const double dx = 0.05;
  three_walls t = open_tank((flow_plan){.dx = dx, .c0 = 40}, 1, 0.5);
  build_tank(&t);
  double *x = flow_read(&t.w, SPH_POSITION);
  x[0] = -0.2 * dx;
  x[1] = 0.1 * dx;
  flow_write(&t.w, SPH_POSITION, x);
  SPH_TEST_OK(t.w.context, sph_wall_set_name(t.wall[LEFT], "left side"));
  SPH_TEST_STATUS(t.w.context, sph_integrator_step(t.w.flow), SPH_E_ARGUMENT,
                  "lies 0.01 m inside wall \"left side\"");
  free(x);
  close_tank(&t);
}

SPH_TEST_MAIN("walls that meet",
              {"overlapping walls give a corner one ghost a place", corners_have_one_ghost_a_place},
              {"and so they do in 3D", corners_have_one_ghost_a_place_in_3d},
              {"forces end where another wall begins", forces_end_at_corners},
              {"ghosts in a corner reflect in both walls", corners_reflect_in_both_walls},
              {"a flap turns with its ghosts, velocity and acceleration", flaps_turn},
              {"values of the last evaluation outlive new lists", values_outlive_lists},
              {"particles behind a wall are found", particles_behind_walls_are_found},
              {"a wall on a damped spring finds its place", spring_finds_its_place},
              {"a flap swings through three periods", flaps_make_waves},
              {"a driver that gives up stops the step", drivers_stop_steps})
