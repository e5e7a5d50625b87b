/* The free surface: how far each particle is open to the air. Everything fades in and out, since pressures
 * that jump when a particle comes to the surface or goes give it energy. */
#include "isph/isph_impl.h"

/* Of the threshold's dim, how much above it particles begin to be open, and below it are; shares of the
 * threshold between which no cover counts any more. */
static const double ABOVE = 0.025, BELOW = 0.075, SPARSE = 0.4, DENSE = 0.6;
/* In spacings, what is nearer covers a particle and what is farther does not; the same for cosines of the
 * angle to the outward normal. */
static const double NEAR = 1.8, FAR = 2.2, AHEAD = 0.8, ASIDE = 0.62;
/* In spacings, what depth below the surface is at least. */
static const double SHALLOW = 0.25;
/* Neighbours within 1.5 spacings: fewer than a corner of the fluid has make a thread. */
static const double NEXT = 1.5;
#define FEW(dim) ((dim) == 2 ? 3 : 5)

/* 0 at x = none, 1 at x = all, a straight line between. */
static inline double ramp(double x, double none, double all) {
  return fmin(fmax((x - none) / (all - none), 0), 1);
}

/* How much something `away` from a particle covers it in the direction of `normal`, of length `size`. */
static inline double covers(int dim, const double *away, const double *normal, double size,
                            double spacing) {
  double r2 = 0, up = 0;
  for (int d = 0; d < dim; d++) {
    r2 += away[d] * away[d];
    up += away[d] * normal[d];
  }
  if (!(up > 0) || r2 >= FAR * FAR * spacing * spacing) return 0;
  const double r = sqrt(r2);
  return ramp(r / spacing, FAR, NEAR) * ramp(up / (r * size), ASIDE, AHEAD);
}

/* How much fluid and walls cover particle i of a cluster. */
static double cover(const sph_integrator *flow, int32_t cluster, int32_t i) {
  const int dim = flow->particles->dim;
  const double spacing = flow->particles->spacing;
  const sph_boundary *boundary = flow->cloud.boundary;
  double *const *x = flow->particles->field[SPHI_X].data;
  double outward[SPHI_MAX_DIM], away[SPHI_MAX_DIM], size = 0, most = 0;
  for (int d = 0; d < dim; d++) {
    outward[d] = -isph_get(flow, ISPH_NORMAL + d, i);
    size += outward[d] * outward[d];
  }
  size = sqrt(size);
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  for (int32_t k = 0; k < near->near; k++) {
    for (int d = 0; d < dim; d++)
      away[d] = sphi_frame_difference(&flow->frame, d, x[d][source[k]], x[d][i]);
    most = fmax(most, covers(dim, away, outward, size, spacing));
  }
  if (!boundary) return most;
  near = &flow->cloud.ghost_list.entry[cluster];
  source = flow->cloud.ghost_list.part[near->part].source + near->offset;
  for (int32_t k = 0; k < near->near; k++) {
    const sphi_wet_ghost *ghost = &boundary->wet[source[k]];
    if (ghost->volume == 0) continue;
    for (int d = 0; d < dim; d++)
      away[d] = sphi_frame_difference(&flow->frame, d, boundary->x[d][ghost->ghost], x[d][i]);
    most = fmax(most, ghost->immersed * covers(dim, away, outward, size, spacing));
  }
  return most;
}

/* Drops and threads at a wall, whose ghosts make up for the neighbours that they lack: nothing holds the
 * pressure of their rows. */
static bool is_thread(const sph_integrator *flow, int32_t cluster, int32_t i) {
  const int dim = flow->particles->dim;
  const double spacing = flow->particles->spacing;
  double *const *x = flow->particles->field[SPHI_X].data;
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  double off[SPHI_MAX_DIM], away[SPHI_MAX_DIM], size = 0;
  int next = -1; /* itself */
  if (!flow->cloud.boundary || flow->cloud.ghost_list.entry[cluster].near == 0) return false;
  for (int d = 0; d < dim; d++) {
    off[d] = -isph_get(flow, ISPH_WALLS + d, i);
    size += off[d] * off[d];
  }
  size = sqrt(size);
  for (int32_t k = 0; k < near->near && next < FEW(dim); k++) {
    double r2 = 0;
    for (int d = 0; d < dim; d++) {
      away[d] = sphi_frame_difference(&flow->frame, d, x[d][source[k]], x[d][i]);
      r2 += away[d] * away[d];
    }
    if (covers(dim, away, off, size, spacing) > 0.5) return false;
    next += r2 < NEXT * NEXT * spacing * spacing;
  }
  return next < FEW(dim);
}

/* The share of particle i that is open, from the divergence of positions. */
static double open_share(const sph_integrator *flow, int32_t cluster, int32_t i, double trace) {
  const double threshold = isph_of(flow)->threshold, dim = flow->particles->dim;
  double open = ramp(trace, threshold + ABOVE * dim, threshold - BELOW * dim);
  if (threshold == 0) return 0;
  if (open > 0)
    open *= 1 - cover(flow, cluster, i) * ramp(trace, SPARSE * threshold, DENSE * threshold);
  return open < 1 && is_thread(flow, cluster, i) ? 1 : open;
}

/* How far particle i is below the surface: as far as the filling says. That follows particles which a wave
 * stretches or squeezes, where half a spacing would be wrong by as much. */
static double depth_of(const sph_integrator *flow, int32_t i) {
  const isph *s = isph_of(flow);
  const double reach = flow->kernel->support, filling = isph_get(flow, ISPH_FILLING, i);
  const double above = filling - s->surface_filling;
  int low = 0, high = ISPH_DEPTHS - 1; /* above is between those of low and high */
  if (above >= s->above[high]) return reach;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    *(above < s->above[middle] ? &high : &low) = middle;
  }
  const double between = (above - s->above[low]) / (s->above[high] - s->above[low]);
  const double depth = (low + between) * reach / (ISPH_DEPTHS - 1);
  return fmax(depth, SHALLOW * flow->particles->spacing);
}

void sphi_isph_find_surface(sph_integrator *flow) {
  isph *s = isph_of(flow);
  int64_t surface = 0, open = 0;
#pragma omp parallel for num_threads(flow->context->threads) schedule(dynamic, 16) \
    reduction(+ : surface, open)
  for (int32_t c = 0; c < flow->clusters.n; c++)
    for (int32_t l = 0; l < flow->clusters.count[c]; l++) {
      const int32_t i = flow->clusters.first[c] + l;
      double trace = 0;
      for (int d = 0; d < flow->particles->dim; d++) trace += isph_get(flow, ISPH_MOMENT + d, i);
      isph_put(flow, ISPH_TRACE, i, trace);
      s->open[i] = open_share(flow, c, i, trace);
      if (s->open[i] > 0) isph_put(flow, ISPH_DEPTH, i, depth_of(flow, i));
      surface += s->open[i] >= 0.5;
      open += s->open[i] > 0;
    }
  s->surface_count = surface;
  s->has_surface = open > 0;
}
