/* Searches from the inside. Positions are copied in id order at every update, so that later sorts of
 * the particles' storage do not matter. */
#ifndef SPHI_SEARCH_IMPL_H
#define SPHI_SEARCH_IMPL_H

#include <sph/search.h>

#include "particles/particles_impl.h"
#include "sweep/columns.h"

typedef struct sphi_near {
  double distance;
  sph_index index;
} sphi_near;

typedef struct sphi_search_rows {
  sph_status (*build)(sph_search *search);
  /* Appends the particles at a distance below r from x (in the box) to search->near. */
  sph_status (*collect)(sph_search *search, const double *x, double r);
  /* Appends at least `wanted` particles, the nearest ones among them; wanted <= n. */
  sph_status (*collect_nearest)(sph_search *search, const double *x, int64_t wanted);
  /* Particles j > i closer to i than the radius; thread-safe. */
  int64_t (*count_after)(const sph_search *search, sph_index i);
} sphi_search_rows;

extern const sphi_search_rows sphi_cell_grid, sphi_brute_force;

struct sph_search {
  sph_context *context;
  sph_particles *particles;
  double radius;
  sph_search_method method;
  bool periodic[SPHI_MAX_DIM]; /* as set; in force from the next update on */
  double lo[SPHI_MAX_DIM], hi[SPHI_MAX_DIM];

  const sphi_search_rows *rows; /* NULL: not built. What follows is as built. */
  int64_t revision;
  int dim;
  sph_index n;
  sphi_frame frame;
  double *x[SPHI_MAX_DIM]; /* [n] in id order, in the box where periodic */
  int64_t capacity;
  sphi_columns columns;

  sphi_near *near; /* what a query found so far */
  int64_t near_count, near_capacity;
  int32_t *column; /* columns of a window */
  int64_t column_capacity;
};

static inline double sphi_search_distance(const sph_search *search, const double *x, sph_index j) {
  double sum = 0;
  for (int d = 0; d < search->dim; d++) {
    const double dx = sphi_frame_difference(&search->frame, d, x[d], search->x[d][j]);
    sum += dx * dx;
  }
  return sqrt(sum);
}

/* Room for `count` more entries of search->near. */
sph_status sphi_search_reserve(sph_search *search, int64_t count);

#endif
