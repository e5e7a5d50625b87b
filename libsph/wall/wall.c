/* Walls: the handle, its settings and its motion. */
#include <stdio.h>

#include "wall/wall_geometry.h"

void sphi_wall_retain(sph_wall *wall) { wall->references++; }

void sph_wall_destroy(sph_wall **wall) {
  if (!wall || !*wall) return;
  sph_wall *dead = *wall;
  *wall = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  sph_body_destroy(&dead->body);
  sphi_free(context, dead->name);
  sphi_free(context, dead->facet);
  sphi_free(context, dead->wedge);
  sphi_free(context, dead->corner);
  sphi_free(context, dead->node);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sph_wall_set_name(sph_wall *wall, const char *name) {
  if (!wall) return SPH_E_ARGUMENT;
  SPH_CHECK(wall->context, name && *name, SPH_E_ARGUMENT, "wall \"%s\": name must not be %s",
            wall->name, name ? "empty" : "NULL");
  char *copy = sphi_copy_text(wall->context, name);
  SPH_CHECK(wall->context, copy, SPH_E_MEMORY, "wall \"%s\": no memory for its name", wall->name);
  sphi_free(wall->context, wall->name);
  wall->name = copy;
  return SPH_OK;
}

const char *sph_wall_name(const sph_wall *wall) { return wall ? wall->name : ""; }
const char *sphi_wall_name(const sph_wall *wall) { return wall->name; }

sph_status sph_wall_set_slip(sph_wall *wall, sph_slip slip) {
  if (!wall) return SPH_E_ARGUMENT;
  SPH_CHECK(wall->context, slip == SPH_FREE_SLIP || slip == SPH_NO_SLIP, SPH_E_ARGUMENT,
            "wall \"%s\": slip must be SPH_FREE_SLIP (0) or SPH_NO_SLIP (1), got %d", wall->name,
            (int)slip);
  wall->slip = slip;
  return SPH_OK;
}

bool sphi_wall_no_slip(const sph_wall *wall) { return wall->slip == SPH_NO_SLIP; }

sph_status sph_wall_set_motion(sph_wall *wall, sph_wall_motion motion, void *user) {
  if (!wall) return SPH_E_ARGUMENT;
  SPH_CHECK(wall->context, !motion || !wall->driver, SPH_E_ARGUMENT,
            "wall \"%s\": it has a driver, which gives the motion", wall->name);
  wall->motion = motion;
  wall->motion_user = user;
  return SPH_OK;
}

sph_status sph_wall_set_rotation(sph_wall *wall, const double *pivot, const double *axis,
                                 sph_wall_rotation rotation, void *user) {
  if (!wall) return SPH_E_ARGUMENT;
  sph_context *context = wall->context;
  double unit[3] = {0, 0, 1}, length2 = 0;
  if (rotation) {
    SPH_CHECK(context, pivot, SPH_E_ARGUMENT, "wall \"%s\": pivot must not be NULL", wall->name);
    for (int d = 0; d < wall->dim; d++)
      SPH_CHECK(context, fabs(pivot[d]) <= SPHI_WALL_LARGEST, SPH_E_ARGUMENT,
                "wall \"%s\": pivot[%d] must be finite and at most %g m, got %g m", wall->name, d,
                SPHI_WALL_LARGEST, pivot[d]);
    SPH_CHECK(context, axis || wall->dim == 2, SPH_E_ARGUMENT,
              "wall \"%s\": axis must not be NULL in 3D", wall->name);
    for (int d = 0; d < 3 && wall->dim == 3; d++) length2 += axis[d] * axis[d];
    SPH_CHECK(context, wall->dim == 2 || (isfinite(length2) && length2 > 0), SPH_E_ARGUMENT,
              "wall \"%s\": axis (%g, %g, %g) must be finite and not zero", wall->name, axis[0],
              axis[1], axis[2]);
    for (int d = 0; d < 3 && wall->dim == 3; d++) unit[d] = axis[d] / sqrt(length2);
    for (int d = 0; d < wall->dim; d++) wall->pivot[d] = pivot[d];
    memcpy(wall->axis, unit, sizeof unit);
  }
  wall->rotation = rotation;
  wall->rotation_user = user;
  return SPH_OK;
}

sph_status sph_wall_set_driver(sph_wall *wall, sph_wall_driver driver, void *user) {
  if (!wall) return SPH_E_ARGUMENT;
  SPH_CHECK(wall->context, !driver || !wall->motion, SPH_E_ARGUMENT,
            "wall \"%s\": it has a prescribed motion, a driver cannot give it another", wall->name);
  SPH_CHECK(wall->context, !wall->body, SPH_E_ARGUMENT, "wall \"%s\": a body moves it", wall->name);
  wall->driver = driver;
  wall->driver_user = user;
  return SPH_OK;
}

static sph_status show_body(const sph_wall *wall, double *displacement, double *velocity,
                            double *acceleration) {
  double x, v, a;
  SPH_TRY(sph_body_get_state(wall->body, &x, &v, &a, NULL));
  for (int d = 0; d < wall->dim; d++) {
    displacement[d] = x * wall->direction[d];
    velocity[d] = v * wall->direction[d];
    acceleration[d] = a * wall->direction[d];
  }
  return SPH_OK;
}

static sph_status drive_by_body(double t, double dt, const double *force, double *displacement,
                                double *velocity, double *acceleration, void *user) {
  const sph_wall *wall = user;
  double along = 0;
  (void)t;
  for (int d = 0; d < wall->dim; d++) along += force[d] * wall->direction[d];
  SPH_TRY(sph_body_advance(wall->body, along, dt));
  return show_body(wall, displacement, velocity, acceleration);
}

sph_status sph_wall_set_body(sph_wall *wall, sph_body *body, const double *direction) {
  if (!wall) return SPH_E_ARGUMENT;
  sph_context *context = wall->context;
  SPH_CHECK(context, body && direction, SPH_E_ARGUMENT, "wall \"%s\": %s is NULL", wall->name,
            body ? "direction" : "body");
  double length2 = 0;
  for (int d = 0; d < wall->dim; d++) length2 += direction[d] * direction[d];
  SPH_CHECK(context, fabs(length2 - 1) <= 2e-6, SPH_E_ARGUMENT,
            "wall \"%s\": direction must be a unit vector, its length is %g", wall->name,
            sqrt(length2));
  SPH_CHECK(context, !wall->motion, SPH_E_ARGUMENT,
            "wall \"%s\": it has a prescribed motion, a body cannot give it another", wall->name);
  SPH_CHECK(context, !wall->driver, SPH_E_ARGUMENT,
            "wall \"%s\": it has a driver, a body cannot give it another motion", wall->name);
  SPH_TRY(sphi_body_take(body, context, wall->name));
  wall->driver = drive_by_body;
  wall->driver_user = wall;
  wall->body = body;
  memcpy(wall->direction, direction, (size_t)wall->dim * sizeof *direction);
  return show_body(wall, wall->to.displacement, wall->to.velocity, wall->to.acceleration);
}

bool sphi_wall_moves(const sph_wall *wall) {
  return wall->motion || wall->rotation || wall->driver;
}

bool sphi_wall_is_driven(const sph_wall *wall) { return wall->driver != NULL; }

int sph_wall_dim(const sph_wall *wall) { return wall ? wall->dim : 0; }
int sphi_wall_dim(const sph_wall *wall) { return wall->dim; }
int sph_wall_facet_count(const sph_wall *wall) { return wall ? wall->facets : 0; }

sph_status sph_wall_facet_normal(const sph_wall *wall, int facet, double *normal) {
  if (!wall) return SPH_E_ARGUMENT;
  SPH_CHECK(wall->context, normal, SPH_E_ARGUMENT, "wall \"%s\": normal must not be NULL",
            wall->name);
  SPH_CHECK(wall->context, facet >= 0 && facet < wall->facets, SPH_E_ARGUMENT,
            "wall \"%s\": facet must be 0 to %d, got %d", wall->name, wall->facets - 1, facet);
  memcpy(normal, wall->facet[facet].normal, (size_t)wall->dim * sizeof *normal);
  return SPH_OK;
}

static sph_status check_motion(const sph_wall *wall, double t, const char *what, int numbers,
                               const double *value) {
  for (int d = 0; d < numbers; d++)
    SPH_CHECK(wall->context, isfinite(value[d]), SPH_E_ARGUMENT,
              "wall \"%s\": %s[%d] from its motion must be finite at t = %g s, got %g", wall->name,
              what, d, t, value[d]);
  return SPH_OK;
}

/* A cubic through both ends of the step for the place, lines for velocity and acceleration: what a stop
 * takes from the velocity at once is no acceleration. */
static void between(const sph_wall *wall, double t, sphi_wall_state *state) {
  const sphi_wall_drive_state *a = &wall->from, *b = &wall->to;
  const double dt = b->t - a->t;
  const double s = dt > 0 ? fmin(fmax((t - a->t) / dt, 0), 1) : 1;
  for (int d = 0; d < wall->dim; d++) {
    const double way = b->displacement[d] - a->displacement[d];
    const double left = dt * a->velocity[d] - way, right = way - dt * b->velocity[d];
    state->displacement[d] =
        a->displacement[d] + s * way + s * (1 - s) * ((1 - s) * left + s * right);
    state->velocity[d] = (1 - s) * a->velocity[d] + s * b->velocity[d];
    state->acceleration[d] = (1 - s) * a->acceleration[d] + s * b->acceleration[d];
  }
}

/* Rodrigues' rotation by the angle about the axis. */
static void turn_by(const sph_wall *wall, double angle, double rate, double rate_change,
                    sphi_wall_state *state) {
  const double c = cos(angle), s = sin(angle), *axis = wall->axis;
  state->turns = true;
  for (int d = 0; d < 3; d++) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    for (int k = 0; k < 3; k++) state->turn[d][k] = (1 - c) * axis[d] * axis[k] + (d == k ? c : 0);
    state->turn[d][e] -= s * axis[f];
    state->turn[d][f] += s * axis[e];
    state->spin[d] = rate * axis[d];
    state->spin_rate[d] = rate_change * axis[d];
    state->pivot[d] = wall->pivot[d];
  }
}

sph_status sphi_wall_state_at(const sph_wall *wall, double t, sphi_wall_state *state) {
  memset(state, 0, sizeof *state);
  if (wall->driver) between(wall, t, state);
  if (wall->motion) {
    wall->motion(t, state->displacement, state->velocity, state->acceleration, wall->motion_user);
    SPH_TRY(check_motion(wall, t, "displacement", wall->dim, state->displacement));
    SPH_TRY(check_motion(wall, t, "velocity", wall->dim, state->velocity));
    SPH_TRY(check_motion(wall, t, "acceleration", wall->dim, state->acceleration));
  }
  if (!wall->rotation) return SPH_OK;
  double turn[3] = {0};
  wall->rotation(t, &turn[0], &turn[1], &turn[2], wall->rotation_user);
  SPH_TRY(check_motion(wall, t, "angle, its rate and acceleration", 3, turn));
  turn_by(wall, turn[0], turn[1], turn[2], state);
  return SPH_OK;
}

void sphi_wall_add_mass(sph_wall *wall, double mass) {
  if (wall->body) sphi_body_add_mass(wall->body, mass);
}

sph_status sphi_wall_drive(sph_wall *wall, double t, double dt, const double *force) {
  sphi_wall_drive_state next = wall->to;
  next.t = t + dt;
  wall->from = wall->to;
  wall->from.t = t;
  const sph_status status = wall->driver(t, dt, force, next.displacement, next.velocity,
                                         next.acceleration, wall->driver_user);
  if (status != SPH_OK && wall->body) return status;
  SPH_CHECK(wall->context, status == SPH_OK, status,
            "wall \"%s\": its driver stopped the run at t = %g s", wall->name, t);
  SPH_TRY(check_motion(wall, t + dt, "displacement", wall->dim, next.displacement));
  SPH_TRY(check_motion(wall, t + dt, "velocity", wall->dim, next.velocity));
  SPH_TRY(check_motion(wall, t + dt, "acceleration", wall->dim, next.acceleration));
  wall->to = next;
  return SPH_OK;
}

double sphi_wall_foot(const sph_wall *wall, const double *x, double bound, double *foot) {
  double point[3] = {0}, largest = wall->size;
  for (int d = 0; d < wall->dim; d++) {
    point[d] = x[d];
    largest = fmax(largest, fabs(x[d]));
  }
  sphi_wall_nearest nearest;
  sphi_wall_find_nearest(wall, point, bound, 1e-12 * largest, &nearest);
  if (!(nearest.distance <= bound)) return HUGE_VAL;
  for (int d = 0; d < wall->dim; d++) foot[d] = nearest.foot[d];
  return nearest.side < 0 ? -nearest.distance : nearest.distance;
}

double sphi_wall_foot_now(const sph_wall *wall, const sphi_wall_state *state, const double *x,
                          double bound, double *foot) {
  const int dim = wall->dim;
  double reference[SPHI_MAX_DIM], at[SPHI_MAX_DIM];
  sphi_wall_refer(state, dim, x, reference);
  double distance = sphi_wall_foot(wall, reference, bound, at);
  if (distance == HUGE_VAL) return distance;
  double ends[2 * SPHI_WALL_MAX_ENDS];
  const int count = distance < 0 ? sphi_wall_open_ends(wall, ends) : 0;
  for (int e = 0; e < count; e++)
    if (hypot(at[0] - ends[2 * e], at[1] - ends[2 * e + 1]) < 1e-9 * fabs(distance))
      distance = -distance;
  sphi_wall_place(state, dim, at, foot);
  return distance;
}

double sphi_wall_distance(const sph_wall *wall, const double *x) {
  double foot[3];
  return sphi_wall_foot(wall, x, INFINITY, foot);
}

sph_status sph_wall_distance(const sph_wall *wall, double t, const double *x, double *distance) {
  if (!wall) return SPH_E_ARGUMENT;
  SPH_CHECK(wall->context, x && distance, SPH_E_ARGUMENT, "wall \"%s\": %s must not be NULL",
            wall->name, x ? "distance" : "x");
  SPH_CHECK(wall->context, isfinite(t), SPH_E_ARGUMENT, "wall \"%s\": t must be finite, got %g s",
            wall->name, t);
  for (int d = 0; d < wall->dim; d++)
    SPH_CHECK(wall->context, fabs(x[d]) <= SPHI_WALL_LARGEST, SPH_E_ARGUMENT,
              "wall \"%s\": x[%d] must be finite and at most %g m, got %g m", wall->name, d,
              SPHI_WALL_LARGEST, x[d]);
  sphi_wall_state state;
  double reference[3];
  SPH_TRY(sphi_wall_state_at(wall, t, &state));
  sphi_wall_refer(&state, wall->dim, x, reference);
  for (int d = 0; d < wall->dim; d++)
    SPH_CHECK(wall->context, fabs(reference[d]) <= SPHI_WALL_LARGEST, SPH_E_ARGUMENT,
              "wall \"%s\": displacement[%d] = %g m at t = %g s is too large", wall->name, d,
              state.displacement[d], t);
  *distance = sphi_wall_distance(wall, reference);
  return SPH_OK;
}

int sphi_wall_open_ends(const sph_wall *wall, double *points) {
  int count = 0;
  if (wall->dim != 2) return 0;
  for (int k = 0; k < wall->facets; k++)
    for (int end = 0; end < 2; end++)
      if (wall->facet[k].link[end] < 0 && count < SPHI_WALL_MAX_ENDS)
        memcpy(points + 2 * count++, wall->facet[k].corner[end], 2 * sizeof *points);
  return count;
}

static sph_status keep_place(const sph_wall *wall, int number, const char *what,
                             sphi_wall_drive_state *state, sphi_keep *keep) {
  char name[SPHI_KEEP_NAME];
  double *at[1 + 3 * SPHI_MAX_DIM] = {&state->t};
  for (int d = 0; d < wall->dim; d++) {
    at[1 + 3 * d] = &state->displacement[d];
    at[2 + 3 * d] = &state->velocity[d];
    at[3 + 3 * d] = &state->acceleration[d];
  }
  snprintf(name, sizeof name, "wall/%d/%s", number, what);
  return sphi_keep_reals(keep, name, 1 + 3 * wall->dim, at);
}

sph_status sphi_wall_keep(sph_wall *wall, int number, sphi_keep *keep) {
  char name[SPHI_KEEP_NAME];
  if (!wall->driver) return SPH_OK;
  SPH_TRY(keep_place(wall, number, "from", &wall->from, keep));
  SPH_TRY(keep_place(wall, number, "to", &wall->to, keep));
  snprintf(name, sizeof name, "wall/%d/body", number);
  return wall->body ? sphi_body_keep(wall->body, name, keep) : SPH_OK;
}
