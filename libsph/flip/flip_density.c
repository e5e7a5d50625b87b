/* Densities as the pressure equation takes them: (11) and (12) of docs/theory/flip.md. */
#include "flip/flip_impl.h"

enum { PARALLEL_FROM = 4096 };

/* Particles are as wide as this times the square root of their volume: as the legs of the triangles that
 * cells were divided into for them. */
static const double WIDTH = 1.4142135623730951;

/* Two cells that are across the longest side from each other: the halves of a square, mostly. */
void sphi_flip_pair_cells(flip *s) {
  const sph_mesh *mesh = s->mesh;
  for (int32_t c = 0; c < mesh->cells; c++) {
    const int32_t *corner = mesh->corner + 3 * (int64_t)c;
    double longest = 0;
    for (int k = 0; k < 3; k++) {
      const double *a = mesh->rest + 2 * (int64_t)corner[(k + 1) % 3];
      const double *b = mesh->rest + 2 * (int64_t)corner[(k + 2) % 3];
      const double length = hypot(b[0] - a[0], b[1] - a[1]);
      if (length <= longest) continue;
      longest = length;
      s->partner[c] = mesh->neighbour[3 * (int64_t)c + k];
    }
  }
  for (int32_t c = 0; c < mesh->cells; c++) {
    const int32_t b = s->partner[c];
    if (b < 0 || s->partner[b] != c) s->partner[c] = c;
  }
}

/* A side of a cell: its inward normal, and the normal's product with a point on it. */
typedef struct side {
  double n[2], at;
} side;

static side side_of(const sph_mesh *mesh, int32_t c, int k) {
  const double *g = mesh->gradient + 6 * (int64_t)c + 2 * k;
  const double *x = mesh->x + 2 * (int64_t)mesh->corner[3 * (int64_t)c + (k + 1) % 3];
  const double size = hypot(g[0], g[1]);
  side s = {.n = {g[0] / size, g[1] / size}};
  s.at = s.n[0] * x[0] + s.n[1] * x[1];
  return s;
}

/* Share of a particle that is beyond a side: half of one on that side, and none of one that is half its width
 * away. */
static double beyond(const side *s, double x, double y, double width) {
  return fmax(0, 0.5 - (s->n[0] * x + s->n[1] * y - s->at) / width);
}

/* Adds volumes and masses of what is in cell c to sums[2], with what reaches over from its neighbours. */
static void add_cell(const sph_integrator *flow, int32_t c, double *sums) {
  const flip *s = flip_of(flow);
  const double *volume = flip_field(flow, SPHI_VOL)[0], *rho = flip_field(flow, SPHI_RHO)[0];
  double **x = flip_field(flow, SPHI_X);
  const int32_t *neighbour = s->mesh->neighbour + 3 * (int64_t)c;
  const side sides[3] = {side_of(s->mesh, c, 0), side_of(s->mesh, c, 1), side_of(s->mesh, c, 2)};
  for (int64_t k = s->start[c]; k < s->start[c + 1]; k++) {
    const int32_t i = s->order[k];
    const double width = WIDTH * sqrt(volume[i]);
    double left = 1;
    for (int e = 0; e < 3; e++)
      if (neighbour[e] >= 0) left -= beyond(&sides[e], x[0][i], x[1][i], width);
    if (left <= 0) continue;
    sums[0] += left * volume[i];
    sums[1] += left * volume[i] * rho[i];
  }
  for (int e = 0; e < 3; e++) {
    const int32_t b = neighbour[e];
    if (b < 0) continue;
    const side outside = {.n = {-sides[e].n[0], -sides[e].n[1]}, .at = -sides[e].at};
    for (int64_t k = s->start[b]; k < s->start[b + 1]; k++) {
      const int32_t i = s->order[k];
      const double share = beyond(&outside, x[0][i], x[1][i], WIDTH * sqrt(volume[i]));
      sums[0] += share * volume[i];
      sums[1] += share * volume[i] * rho[i];
    }
  }
}

static bool near_interface(const flip *s, int32_t c) {
  const double least = 1e-3 * (s->density[1] - s->density[0]);
  bool near = s->mixed[c];
  for (int k = 0; k < 3; k++) {
    const int32_t b = s->mesh->neighbour[3 * (int64_t)c + k];
    near = near || (b >= 0 && (s->mixed[b] || fabs(s->rho[b] - s->rho[c]) > least));
  }
  return near;
}

void sphi_flip_spread_density(sph_integrator *flow) {
  flip *s = flip_of(flow);
  const int32_t cells = s->mesh->cells;
  const double least = 1e-3 * (s->density[1] - s->density[0]);
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (cells > PARALLEL_FROM)
  for (int32_t c = 0; c < cells; c++) {
    const int32_t b = s->partner[c];
    if (b < c) continue;
    double sums[2] = {0};
    s->spread[c] = s->rho[c];
    s->spread[b] = s->rho[b];
    if (!near_interface(s, c) && (b == c || !near_interface(s, b))) continue;
    add_cell(flow, c, sums);
    if (b != c) add_cell(flow, b, sums);
    if (sums[0] > 0) s->spread[c] = s->spread[b] = sums[1] / sums[0];
  }
  for (int32_t c = 0; c < cells; c++) {
    const bool between =
        s->spread[c] > s->density[0] + least && s->spread[c] < s->density[1] - least;
    s->mixed[c] = s->mixed[c] || between;
    s->rho[c] = s->spread[c];
  }
}
