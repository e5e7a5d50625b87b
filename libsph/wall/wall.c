/* Walls: the handle, its settings and its motion. */
#include "wall/wall_geometry.h"

void sphi_wall_retain(sph_wall *wall) { wall->references++; }

void sph_wall_destroy(sph_wall **wall) {
  if (!wall || !*wall) return;
  sph_wall *dead = *wall;
  *wall = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
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
  wall->motion = motion;
  wall->motion_user = user;
  return SPH_OK;
}

bool sphi_wall_moves(const sph_wall *wall) { return wall->motion != NULL; }

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

sph_status sphi_wall_motion_at(const sph_wall *wall, double t, double *displacement,
                               double *velocity, double *acceleration) {
  double value[3][SPHI_MAX_DIM] = {{0}};
  if (wall->motion) {
    wall->motion(t, value[0], value[1], value[2], wall->motion_user);
    static const char *const names[] = {"displacement", "velocity", "acceleration"};
    for (int k = 0; k < 3; k++)
      for (int d = 0; d < wall->dim; d++)
        SPH_CHECK(wall->context, isfinite(value[k][d]), SPH_E_ARGUMENT,
                  "wall \"%s\": %s[%d] from its motion must be finite at t = %g s, got %g",
                  wall->name, names[k], d, t, value[k][d]);
  }
  const size_t bytes = (size_t)wall->dim * sizeof(double);
  memcpy(displacement, value[0], bytes);
  memcpy(velocity, value[1], bytes);
  memcpy(acceleration, value[2], bytes);
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
  double displacement[3], velocity[3], acceleration[3], reference[3];
  SPH_TRY(sphi_wall_motion_at(wall, t, displacement, velocity, acceleration));
  for (int d = 0; d < wall->dim; d++) {
    reference[d] = x[d] - displacement[d];
    SPH_CHECK(wall->context, fabs(reference[d]) <= SPHI_WALL_LARGEST, SPH_E_ARGUMENT,
              "wall \"%s\": displacement[%d] = %g m at t = %g s is too large", wall->name, d,
              displacement[d], t);
  }
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
