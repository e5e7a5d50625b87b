/* Meshes from the inside: topology, geometry of now, and where points are. */
#ifndef SPHI_MESH_IMPL_H
#define SPHI_MESH_IMPL_H

#include <sph/mesh.h>

#include "core/keep.h"

enum { SPHI_MESH_TAGS = 64, SPHI_MESH_NAME = 63, SPHI_MESH_MAX = 100000000 };

/* Barycentric coordinates down to minus this are inside: two roundings wide on any triangle of sound
 * shape, so that no point falls between neighbours. */
#define SPHI_MESH_EDGE 1e-12

struct sph_mesh {
  sph_context *context;
  int references;
  int32_t nodes, cells, edges, boundary; /* edges on the boundary come first */
  double *rest;                          /* [nodes, 2] */
  double *x;                             /* [nodes, 2] now */
  double *moved;                         /* [nodes, 2] scratch */
  int32_t *corner;                       /* [cells, 3] counterclockwise */
  int32_t *neighbour;   /* [cells, 3] opposite to a corner; -1 - edge on the boundary */
  double *area;         /* [cells] */
  double *gradient;     /* [cells, 3, 2] */
  int32_t *ends, *side; /* [edges, 2] nodes; cells left and right, -1: none */
  int32_t *tag;         /* [edges] */
  int64_t *touch_start; /* [nodes + 1] */
  int32_t *touch;       /* cells at a node in ascending order, as 3 cell + corner */
  int32_t *next, *last; /* [boundary] the edge that begins where one ends, and that before it */
  int tags;
  char name[SPHI_MESH_TAGS][SPHI_MESH_NAME + 1];

  sph_wall_motion motion; /* NULL: none */
  void *user;
  double reach, first; /* of the paddle; X_0 */
  double displacement, velocity;
  int64_t revision; /* changes with every move */

  /* Squares over the mesh at rest, with the cells whose boxes they touch. */
  bool squares_made;
  double lo[2], side_of_square;
  int32_t squares[2];
  int64_t *square_start;
  int32_t *square_cell;
};

void sphi_mesh_retain(sph_mesh *mesh);

/* What a mesh comes from, for messages: "mesh", or a file and the lines of its cells. */
typedef struct sphi_mesh_source {
  const char *what;
  const int64_t *line; /* [cells] or NULL */
} sphi_mesh_source;
/* "cell 12" or "cell 12 (line 345)". */
typedef struct sphi_mesh_words {
  char text[64];
} sphi_mesh_words;
sphi_mesh_words sphi_mesh_cell_words(const sphi_mesh_source *source, int64_t cell);
/* As sph_mesh_create. */
sph_status sphi_mesh_make(sph_context *context, const sphi_mesh_source *source, int64_t nodes,
                          const double *x, int64_t cells, const int32_t *corners, int64_t edges,
                          const int32_t *ends, const int32_t *tags, int tag_count,
                          const char *const *names, sph_mesh **out);
/* Neighbours, edges and cells at nodes. */
sph_status sphi_mesh_connect(sph_mesh *mesh, const sphi_mesh_source *source, int64_t edges,
                             const int32_t *ends, const int32_t *tags);
/* Areas and gradients for nodes at x; the first cell that is not sound, or -1. */
int32_t sphi_mesh_measure(sph_mesh *mesh, const double *x);

/* Squares for searches, unless they are there. */
sph_status sphi_mesh_prepare(sph_mesh *mesh);

/* Barycentric coordinates of a point. */
static inline void sphi_mesh_coordinates(const sph_mesh *mesh, int32_t cell, const double *x,
                                         double *share) {
  const double *first = mesh->x + 2 * (int64_t)mesh->corner[3 * (int64_t)cell];
  const double *g = mesh->gradient + 6 * (int64_t)cell;
  const double dx = x[0] - first[0], dy = x[1] - first[1];
  share[1] = g[2] * dx + g[3] * dy;
  share[2] = g[4] * dx + g[5] * dy;
  share[0] = 1 - share[1] - share[2];
}

/* The cell with the point, by a walk from `cell` (-1: by the squares alone), or -1, and then the edge of the
 * boundary where the walk ended. After sphi_mesh_prepare. */
int32_t sphi_mesh_walk(const sph_mesh *mesh, const double *x, int32_t cell, int32_t *stopped_by);
/* The point of the boundary nearest to one outside, as far as going along it from `edge` finds it, and its
 * edge. */
int32_t sphi_mesh_foot(const sph_mesh *mesh, const double *x, int32_t edge, double *foot);

/* What a checkpoint keeps of it: where the paddle has put its nodes. */
sph_status sphi_mesh_keep(sph_mesh *mesh, sphi_keep *keep);

#endif
