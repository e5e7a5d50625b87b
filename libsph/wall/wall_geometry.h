/* Geometry of walls, for the files of this folder only. Points are [3] with z = 0 in 2D. */
#ifndef SPHI_WALL_GEOMETRY_H
#define SPHI_WALL_GEOMETRY_H

#include "body/body_impl.h"
#include "wall/wall_impl.h"

#define SPHI_WALL_PI 3.14159265358979323846
/* Below this turn [rad] two facets count as one plane, within it of a half turn as folded. */
#define SPHI_WALL_FLAT 1e-6
/* Cosine of the turn (80 degrees) from which a solid corner is sharp. */
#define SPHI_WALL_SHARP 0.17364817766693041
/* Coordinates of this size or less can be squared and cubed without overflow. */
#define SPHI_WALL_LARGEST 1e100

typedef struct sphi_wall_facet {
  double corner[4][3]; /* 2 of them in 2D */
  double normal[3];    /* unit, into the fluid */
  double middle[3];
  double angle[4]; /* inner angles; 3D only */
  int link[2];     /* 2D: the facets before and after, or -1 at an open end */
  double clip[2];  /* 2D: at re-entrant ends, at depth s the strip begins clip*s inside */
  bool shares[2];  /* 2D: the corner there is blunt, its bisector divides the solid */
} sphi_wall_facet;

/* The solid wedge behind a vertex (2D, a = b) or edge a to b (3D) with less than 180 degrees of
 * fluid. */
typedef struct sphi_wall_wedge {
  double a[3], b[3];
  int facet[2];
} sphi_wall_wedge;

/* The solid corner behind a 3D vertex: facet[2] is perpendicular to the two others. */
typedef struct sphi_wall_corner {
  double x[3];
  int facet[3];
} sphi_wall_corner;

/* Where a driver has put a wall at a time. */
typedef struct sphi_wall_drive_state {
  double t, displacement[3], velocity[3], acceleration[3];
} sphi_wall_drive_state;

struct sph_wall {
  sph_context *context;
  int references;
  char *name;
  int dim;
  sph_slip slip;
  sph_wall_motion motion;
  void *motion_user;
  sph_wall_rotation rotation;
  void *rotation_user;
  double pivot[3], axis[3];
  sph_wall_driver driver;
  void *driver_user;
  sphi_wall_drive_state from, to; /* of the driven step */
  sph_body *body;                 /* of the driver, or NULL */
  double direction[3];
  int facets;
  sphi_wall_facet *facet;
  int64_t wedges, wedge_capacity;
  sphi_wall_wedge *wedge;
  int64_t corners, corner_capacity;
  sphi_wall_corner *corner;
  double (
      *node)[6]; /* bounding boxes over halves of the facet range, children of k at 2k+1, 2k+2 */
  double size;   /* largest coordinate or extent: the scale of round-off */
};

typedef struct sphi_wall_nearest {
  double distance; /* INFINITY if no facet is within the bound */
  double side;     /* its sign says on which side x is: > 0 in the fluid */
  double foot[3];  /* on the lowest of the nearest facets */
  int facet;       /* that facet, or -1 */
} sphi_wall_nearest;

/* Facets whose distance is within `tolerance` of the smallest count as nearest. */
void sphi_wall_find_nearest(const sph_wall *wall, const double *x, double bound, double tolerance,
                            sphi_wall_nearest *nearest);

/* Another side of the solid with ghosts at the same place. */
typedef struct sphi_wall_rival {
  int owner, facet; /* `facet` is opposed to this owner of the place */
  double distance;
  bool meets; /* they meet in an edge of the wall near the place */
} sphi_wall_rival;
enum { SPHI_WALL_RIVALS = 5 }; /* the other sides of a box */
/* What a place in the solid belongs to: a facet or those of a wedge or corner. */
typedef struct sphi_wall_side {
  int owners, owner[3];
  int rivals;
  sphi_wall_rival rival[SPHI_WALL_RIVALS]; /* nearest first */
} sphi_wall_side;
/* Who sees a ghost at x: fluid where p . (x_fluid - x) + p[3] > 0 for each plane p. */
typedef struct sphi_wall_gates {
  int count;
  double plane[SPHI_GATES(3)][4];
} sphi_wall_gates;

/* Two sides of one solid that meet in a sharp edge, or would if they went on: each is behind the other
 * and they do not face about the same way. */
bool sphi_wall_opposed(const sph_wall *wall, int facet, int other);
/* The facet is opposed to an owner. */
bool sphi_wall_is_rival(const sph_wall *wall, const sphi_wall_side *side, int facet);
/* The facet lies in the plane of a known rival or one parallel to it. */
bool sphi_wall_is_known(const sph_wall *wall, const sphi_wall_side *side, int facet);
/* The nearest facet that has x behind it, among the rivals that are not known yet or among all that are
 * no rivals. */
void sphi_wall_find_nearest_of(const sph_wall *wall, const double *x, double bound,
                               double tolerance, const sphi_wall_side *side, bool rivals,
                               sphi_wall_nearest *nearest);
/* The nearest rivals that have ghosts at x. */
void sphi_wall_find_rivals(const sph_wall *wall, const double *x, double depth, double tolerance,
                           sphi_wall_side *side);
/* Gates of the side's own ghost at x. */
void sphi_wall_gate_side(const sph_wall *wall, const sphi_wall_side *side, const double *x,
                         sphi_wall_gates *gates);
/* Foot and gates of the reflection through the edge or vertex that an owner has in common with the
 * rivals in `which`, one bit each, and the facet `also` if that is not -1. False if there is none,
 * or if the rival's ghosts give it. */
bool sphi_wall_gate_nose(const sph_wall *wall, const sphi_wall_side *side, int which, int also,
                         const double *x, double tolerance, double *foot, sphi_wall_gates *gates);

typedef bool (*sphi_wall_visit)(void *state, int facet); /* false stops */
void sphi_wall_overlapping(const sph_wall *wall, const double *lo, const double *hi,
                           sphi_wall_visit visit, void *state);

/* Normals, middles, bounding boxes; the facets' corners must be set. */
sph_status sphi_wall_finish_facets(sph_wall *wall);
/* Folds, re-entrant clips and wedges; needs finished facets and, in 2D, their links. */
sph_status sphi_wall_join_2d(sph_wall *wall);
sph_status sphi_wall_join_3d(sph_wall *wall);

static inline double sphi_dot(const double *a, const double *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline void sphi_subtract(const double *a, const double *b, double *c) {
  for (int d = 0; d < 3; d++) c[d] = a[d] - b[d];
}
static inline void sphi_cross(const double *a, const double *b, double *c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}
static inline double sphi_length(const double *a) { return sqrt(sphi_dot(a, a)); }
static inline double sphi_gap(const double *a, const double *b) {
  double c[3];
  sphi_subtract(a, b, c);
  return sphi_length(c);
}

#endif
