/* The equations are those of sph_wcsph_create in <sph/wcsph.h>; ghosts take no part in diffusion and, the walls being
 * free-slip, in viscosity. */
#include "plain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LAMBDA_MIN 0.1 /* a gradient whose moment matrix is closer to singular is left out */
/* Numbers a particle in the array of sums: what the first pass wants. */
#define SUMS(dim) ((dim) == 2 ? 6 : 10)

/* Literal kernels and dimensions are folded in, as a careful author's compiler would do too. */
#define INLINE static inline __attribute__((always_inline))

static int allocate_points(plain_points *points, int dim, int32_t n) {
  const size_t count = (size_t)n + 1, vector = count * (size_t)dim, number = sizeof(double);
  points->n = n;
  points->x = calloc(vector, number);
  points->v = calloc(vector, number);
  points->p = calloc(count, number);
  points->volume = calloc(count, number);
  points->cell = calloc(count, sizeof *points->cell);
  points->order = calloc(count, sizeof *points->order);
  return points->x && points->v && points->p && points->volume && points->cell && points->order;
}

int plain_allocate(plain_flow *flow, int dim, int32_t particles, int32_t ghosts) {
  memset(flow, 0, sizeof *flow);
  const size_t count = (size_t)particles + 1, vector = count * (size_t)dim, number = sizeof(double);
  flow->dim = dim;
  const int points =
      allocate_points(&flow->fluid, dim, particles) && allocate_points(&flow->ghost, dim, ghosts);
  flow->m = calloc(count, number);
  flow->rho = calloc(count, number);
  flow->pairs.start = calloc(count, sizeof *flow->pairs.start);
  flow->ghosts.start = calloc(count, sizeof *flow->ghosts.start);
  flow->sums = calloc(count * SUMS(3), number);
  flow->gradient = calloc(vector, number);
  flow->lambda = calloc(count, number);
  flow->divergence = calloc(count, number);
  flow->acceleration = calloc(vector, number);
  flow->density_rate = calloc(count, number);
  return points && flow->m && flow->rho && flow->pairs.start && flow->ghosts.start && flow->sums &&
         flow->gradient && flow->lambda && flow->divergence && flow->acceleration &&
         flow->density_rate;
}

static void free_points(plain_points *points) {
  void *all[] = {points->x,    points->v,     points->p,    points->volume,
                 points->cell, points->order, points->first};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
}

void plain_free(plain_flow *flow) {
  void *all[] = {flow->m,           flow->rho,          flow->pairs.start,  flow->pairs.near,
                 flow->ghosts.near, flow->ghosts.start, flow->sums,         flow->lambda,
                 flow->gradient,    flow->divergence,   flow->acceleration, flow->density_rate};
  free_points(&flow->fluid);
  free_points(&flow->ghost);
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
  memset(flow, 0, sizeof *flow);
}

void plain_state(plain_flow *flow) {
  for (int32_t i = 0; i < flow->fluid.n; i++) {
    flow->fluid.p[i] = flow->c0 * flow->c0 * (flow->rho[i] - flow->rho0);
    flow->fluid.volume[i] = flow->m[i] / flow->rho[i];
  }
}

/* ------------------------------------------------------------------------------------- list */

typedef struct grid {
  int dim;
  double width, lo[3];
  int32_t cells[3], total;
} grid;

static void widen(const plain_points *points, int dim, int d, double *lo, double *hi) {
  for (int32_t i = 0; i < points->n; i++) {
    *lo = fmin(*lo, points->x[i * dim + d]);
    *hi = fmax(*hi, points->x[i * dim + d]);
  }
}

static grid grid_over(const plain_flow *flow) {
  grid g = {.dim = flow->dim, .width = flow->support, .cells = {1, 1, 1}, .total = 1};
  for (int d = 0; d < flow->dim; d++) {
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    widen(&flow->fluid, flow->dim, d, &lo, &hi);
    widen(&flow->ghost, flow->dim, d, &lo, &hi);
    g.lo[d] = lo;
    g.cells[d] = (int32_t)((hi - lo) / g.width) + 1;
    g.total *= g.cells[d];
  }
  return g;
}

static int sort_into_cells(const grid *g, plain_points *points) {
  const size_t total = (size_t)g->total;
  int32_t *first = calloc(total + 1, sizeof *first);
  points->first = first;
  if (!first) return 0;
  for (int32_t i = 0; i < points->n; i++) {
    int32_t cell = 0;
    for (int d = 0; d < g->dim; d++)
      cell = cell * g->cells[d] + (int32_t)((points->x[i * g->dim + d] - g->lo[d]) / g->width);
    points->cell[i] = cell;
    first[cell + 1]++;
  }
  for (size_t c = 0; c < total; c++) first[c + 1] += first[c];
  for (int32_t i = points->n - 1; i >= 0; i--) points->order[--first[points->cell[i] + 1]] = i;
  /* first[c + 1] now is the beginning of cell c. */
  memmove(first, first + 1, total * sizeof *first);
  first[total] = points->n;
  return 1;
}

static int make_room(plain_neighbours *list, int64_t more) {
  const int64_t wanted = list->used + more;
  if (wanted <= list->capacity) return 1;
  const int64_t capacity = wanted + wanted / 2;
  int32_t *near = realloc(list->near, (size_t)capacity * sizeof *near);
  if (!near) return 0;
  list->near = near;
  list->capacity = capacity;
  return 1;
}

INLINE double distance2(const double *x, const double *y, const int dim) {
  double r2 = 0;
  for (int d = 0; d < dim; d++) r2 += (x[d] - y[d]) * (x[d] - y[d]);
  return r2;
}

/* Appends those of `points` beyond number `after` that are near x and in the cells begin ... end - 1. */
INLINE int append(plain_neighbours *list, const double *x, const plain_points *points,
                  int32_t after, int32_t begin, int32_t end, double support, const int dim) {
  const int32_t from = points->first[begin], to = points->first[end];
  const double support2 = support * support;
  if (!make_room(list, to - from)) return 0;
  int64_t used = list->used;
  for (int32_t k = from; k < to; k++) {
    const int32_t j = points->order[k];
    if (j > after && distance2(x, points->x + j * dim, dim) < support2) list->near[used++] = j;
  }
  list->used = used;
  return 1;
}

/* The neighbours of particle i in the rows of cells about its own. */
INLINE int list_one(plain_flow *flow, const grid *g, int32_t i, const int dim) {
  const int last = dim - 1, planes = dim == 3 ? 1 : 0;
  const double *x = flow->fluid.x + i * dim, support = flow->support;
  int32_t at[3] = {0, 0, 0}, cell = flow->fluid.cell[i];
  for (int d = last; d >= 0; d--) at[d] = cell % g->cells[d], cell /= g->cells[d];
  const int32_t lo = at[last] > 0 ? at[last] - 1 : 0;
  const int32_t hi = at[last] + 1 < g->cells[last] ? at[last] + 1 : at[last];
  for (int a = -1; a <= 1; a++) {
    for (int b = -planes; b <= planes; b++) {
      const int32_t ca = at[0] + a, cb = dim == 3 ? at[1] + b : 0;
      if (ca < 0 || ca >= g->cells[0] || cb < 0 || (dim == 3 && cb >= g->cells[1])) continue;
      const int32_t row = (dim == 3 ? ca * g->cells[1] + cb : ca) * g->cells[last];
      const int32_t begin = row + lo, end = row + hi + 1;
      if (!append(&flow->pairs, x, &flow->fluid, i, begin, end, support, dim) ||
          !append(&flow->ghosts, x, &flow->ghost, -1, begin, end, support, dim))
        return 0;
    }
  }
  return 1;
}

static int list_all(plain_flow *flow, const grid *g) {
  flow->pairs.used = flow->ghosts.used = 0;
  for (int32_t i = 0; i < flow->fluid.n; i++) {
    if (!(flow->dim == 2 ? list_one(flow, g, i, 2) : list_one(flow, g, i, 3))) return 0;
    flow->pairs.start[i + 1] = flow->pairs.used;
    flow->ghosts.start[i + 1] = flow->ghosts.used;
  }
  return 1;
}

int plain_list(plain_flow *flow) {
  const grid g = grid_over(flow);
  const int done =
      sort_into_cells(&g, &flow->fluid) && sort_into_cells(&g, &flow->ghost) && list_all(flow, &g);
  free(flow->fluid.first);
  free(flow->ghost.first);
  flow->fluid.first = flow->ghost.first = NULL;
  return done;
}

/* ------------------------------------------------------------------------------- pair sums */

typedef struct constants {
  double norm, inverse_h2, inverse_2h;
} constants;

static constants constants_of(const plain_flow *flow) {
  const double pi = 3.14159265358979323846, end = exp(-9.0);
  double sigma;
  if (flow->kernel == PLAIN_WENDLAND_C2)
    sigma = flow->dim == 2 ? 7 / (4 * pi) : 21 / (16 * pi);
  else
    sigma = 1 / (flow->dim == 2 ? pi * (1 - 10 * end) : pi * (sqrt(pi) * erf(3.0) - 42 * end));
  return (constants){sigma * pow(flow->h, -flow->dim - 2), 1 / (flow->h * flow->h), 0.5 / flow->h};
}

/* (dW/dr)/r */
INLINE double kernel_slope(const constants *c, const plain_kernel kernel, double r2) {
  if (kernel == PLAIN_GAUSSIAN) return -2 * c->norm * exp(-r2 * c->inverse_h2);
  const double a = 1 - sqrt(r2) * c->inverse_2h;
  return -5 * c->norm * a * a * a;
}

typedef struct pair {
  double dx[3], r2, approach; /* x_i - x_j, its square, (v_j - v_i) . (x_i - x_j) */
} pair;

INLINE pair pair_of(const plain_points *own, int32_t i, const plain_points *other, int32_t j,
                    const int dim) {
  pair g = {.r2 = 0};
  for (int d = 0; d < dim; d++) {
    g.dx[d] = own->x[i * dim + d] - other->x[j * dim + d];
    g.r2 += g.dx[d] * g.dx[d];
    g.approach += (other->v[j * dim + d] - own->v[i * dim + d]) * g.dx[d];
  }
  return g;
}

static void clear_sums(plain_flow *flow) {
  memset(flow->sums, 0, (size_t)flow->fluid.n * SUMS(flow->dim) * sizeof *flow->sums);
}

/* What particle i gathered itself, onto what its neighbours have given it. */
INLINE void add_sums(plain_flow *flow, int32_t i, const double *gathered, const int dim) {
  double *sums = flow->sums + (int64_t)i * SUMS(dim);
  for (int k = 0; k < SUMS(dim); k++) sums[k] += gathered[k];
}

/* Sums of a particle: divergence, b[dim], moment matrix xx yy (zz) xy (xz yz). */
INLINE void gradient_pairs(plain_flow *flow, const plain_kernel kernel, const int dim) {
  const constants c = constants_of(flow);
  const plain_points fluid = flow->fluid, ghost = flow->ghost;
  const double *rho = flow->rho;
  const int matrix = 1 + dim;
  for (int32_t i = 0; i < fluid.n; i++) {
    double si[SUMS(3)] = {0};
    for (int64_t k = flow->pairs.start[i]; k < flow->pairs.start[i + 1]; k++) {
      const int32_t j = flow->pairs.near[k];
      double *sj = flow->sums + (int64_t)j * SUMS(dim);
      const pair g = pair_of(&fluid, i, &fluid, j, dim);
      const double slope = kernel_slope(&c, kernel, g.r2);
      const double gi = slope * fluid.volume[j], gj = slope * fluid.volume[i];
      const double difference = rho[j] - rho[i];
      si[0] += gi * g.approach;
      sj[0] += gj * g.approach;
      int at = matrix + dim;
      for (int d = 0; d < dim; d++) {
        si[1 + d] += gi * difference * g.dx[d];
        sj[1 + d] += gj * difference * g.dx[d];
        si[matrix + d] -= gi * g.dx[d] * g.dx[d];
        sj[matrix + d] -= gj * g.dx[d] * g.dx[d];
        for (int e = d + 1; e < dim; e++, at++) {
          si[at] -= gi * g.dx[d] * g.dx[e];
          sj[at] -= gj * g.dx[d] * g.dx[e];
        }
      }
    }
    for (int64_t k = flow->ghosts.start[i]; k < flow->ghosts.start[i + 1]; k++) {
      const int32_t j = flow->ghosts.near[k];
      const pair g = pair_of(&fluid, i, &ghost, j, dim);
      si[0] += kernel_slope(&c, kernel, g.r2) * ghost.volume[j] * g.approach;
    }
    add_sums(flow, i, si, dim);
  }
}

static void solve_2(const double *b, const double *m, double *gradient, double *lambda) {
  *lambda = 0.5 * (m[0] + m[1]) - sqrt(0.25 * (m[0] - m[1]) * (m[0] - m[1]) + m[2] * m[2]);
  const double inverse = *lambda < LAMBDA_MIN ? 0 : 1 / (m[0] * m[1] - m[2] * m[2]);
  gradient[0] = (m[1] * b[0] - m[2] * b[1]) * inverse;
  gradient[1] = (m[0] * b[1] - m[2] * b[0]) * inverse;
}

/* The smallest eigenvalue by the trigonometric solution of the characteristic polynomial. */
static void solve_3(const double *b, const double *m, double *gradient, double *lambda) {
  const double xx = m[0], yy = m[1], zz = m[2], xy = m[3], xz = m[4], yz = m[5];
  const double mean = (xx + yy + zz) / 3, p = xx - mean, q = yy - mean, s = zz - mean;
  const double size = sqrt((p * p + q * q + s * s + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  const double shifted = p * (q * s - yz * yz) - xy * (xy * s - yz * xz) + xz * (xy * yz - q * xz);
  const double cosine = size > 1e-12 ? shifted / (2 * size * size * size) : 1;
  *lambda = mean + 2 * size * cos(acos(fmax(-1, fmin(1, cosine))) / 3 + 2.0943951023931953);
  const double cxx = yy * zz - yz * yz, cxy = xz * yz - xy * zz, cxz = xy * yz - yy * xz;
  const double inverse = *lambda < LAMBDA_MIN ? 0 : 1 / (xx * cxx + xy * cxy + xz * cxz);
  gradient[0] = (cxx * b[0] + cxy * b[1] + cxz * b[2]) * inverse;
  gradient[1] = (cxy * b[0] + (xx * zz - xz * xz) * b[1] + (xy * xz - xx * yz) * b[2]) * inverse;
  gradient[2] = (cxz * b[0] + (xy * xz - xx * yz) * b[1] + (xx * yy - xy * xy) * b[2]) * inverse;
}

/* Sums of a particle: force[dim], diffusion. */
INLINE void rates_pairs(plain_flow *flow, const plain_kernel kernel, const int dim) {
  const constants c = constants_of(flow);
  const plain_points fluid = flow->fluid, ghost = flow->ghost;
  const double *rho = flow->rho, *gradient = flow->gradient;
  const double viscosity = flow->alpha * flow->h * flow->c0 * flow->rho0;
  for (int32_t i = 0; i < fluid.n; i++) {
    double si[SUMS(3)] = {0};
    for (int64_t k = flow->pairs.start[i]; k < flow->pairs.start[i + 1]; k++) {
      const int32_t j = flow->pairs.near[k];
      double *sj = flow->sums + (int64_t)j * SUMS(dim);
      const pair g = pair_of(&fluid, i, &fluid, j, dim);
      const double slope = kernel_slope(&c, kernel, g.r2);
      const double gi = slope * fluid.volume[j], gj = slope * fluid.volume[i];
      const double push = -(fluid.p[i] + fluid.p[j]) - viscosity * g.approach / g.r2;
      double psi = -2 * (rho[j] - rho[i]);
      for (int d = 0; d < dim; d++) {
        psi -= (gradient[i * dim + d] + gradient[j * dim + d]) * g.dx[d];
        si[d] += gi * push * g.dx[d];
        sj[d] -= gj * push * g.dx[d];
      }
      si[dim] += gi * psi;
      sj[dim] -= gj * psi;
    }
    for (int64_t k = flow->ghosts.start[i]; k < flow->ghosts.start[i + 1]; k++) {
      const int32_t j = flow->ghosts.near[k];
      const pair g = pair_of(&fluid, i, &ghost, j, dim);
      const double gi = kernel_slope(&c, kernel, g.r2) * ghost.volume[j];
      for (int d = 0; d < dim; d++) si[d] -= gi * (fluid.p[i] + ghost.p[j]) * g.dx[d];
    }
    add_sums(flow, i, si, dim);
  }
}

/* Sums of a particle: force[dim], divergence. */
INLINE void convective_pairs(plain_flow *flow, const plain_kernel kernel, const int dim) {
  const constants c = constants_of(flow);
  const plain_points fluid = flow->fluid, ghost = flow->ghost;
  for (int32_t i = 0; i < fluid.n; i++) {
    double si[SUMS(3)] = {0};
    for (int64_t k = flow->pairs.start[i]; k < flow->pairs.start[i + 1]; k++) {
      const int32_t j = flow->pairs.near[k];
      double *sj = flow->sums + (int64_t)j * SUMS(dim);
      const pair g = pair_of(&fluid, i, &fluid, j, dim);
      const double slope = kernel_slope(&c, kernel, g.r2), push = -(fluid.p[i] + fluid.p[j]);
      const double gi = slope * fluid.volume[j], gj = slope * fluid.volume[i];
      for (int d = 0; d < dim; d++) {
        si[d] += gi * push * g.dx[d];
        sj[d] -= gj * push * g.dx[d];
      }
      si[dim] += gi * g.approach;
      sj[dim] += gj * g.approach;
    }
    for (int64_t k = flow->ghosts.start[i]; k < flow->ghosts.start[i + 1]; k++) {
      const int32_t j = flow->ghosts.near[k];
      const pair g = pair_of(&fluid, i, &ghost, j, dim);
      const double gi = kernel_slope(&c, kernel, g.r2) * ghost.volume[j];
      for (int d = 0; d < dim; d++) si[d] -= gi * (fluid.p[i] + ghost.p[j]) * g.dx[d];
      si[dim] += gi * g.approach;
    }
    add_sums(flow, i, si, dim);
  }
}

/* One loop for each kernel and dimension. */
#define STAMP(pass, flow)                   \
  do {                                      \
    clear_sums(flow);                       \
    if ((flow)->kernel == PLAIN_GAUSSIAN) { \
      if ((flow)->dim == 2)                 \
        pass(flow, PLAIN_GAUSSIAN, 2);      \
      else                                  \
        pass(flow, PLAIN_GAUSSIAN, 3);      \
    } else {                                \
      if ((flow)->dim == 2)                 \
        pass(flow, PLAIN_WENDLAND_C2, 2);   \
      else                                  \
        pass(flow, PLAIN_WENDLAND_C2, 3);   \
    }                                       \
  } while (0)

void plain_gradient(plain_flow *flow) {
  STAMP(gradient_pairs, flow);
  const int dim = flow->dim;
  for (int32_t i = 0; i < flow->fluid.n; i++) {
    const double *s = flow->sums + (int64_t)i * SUMS(dim);
    flow->divergence[i] = s[0];
    if (dim == 2)
      solve_2(s + 1, s + 3, flow->gradient + 2 * i, flow->lambda + i);
    else
      solve_3(s + 1, s + 4, flow->gradient + 3 * i, flow->lambda + i);
  }
}

void plain_rates(plain_flow *flow) {
  STAMP(rates_pairs, flow);
  const int dim = flow->dim;
  for (int32_t i = 0; i < flow->fluid.n; i++) {
    const double *s = flow->sums + (int64_t)i * SUMS(dim);
    double *a = flow->acceleration + i * dim;
    for (int d = 0; d < dim; d++) a[d] = s[d] / flow->rho[i];
    a[dim - 1] -= flow->gravity;
    const double diffusion =
        flow->lambda[i] < LAMBDA_MIN ? 0 : flow->delta * flow->h * flow->c0 * s[dim];
    flow->density_rate[i] = -flow->rho[i] * flow->divergence[i] + diffusion;
  }
}

void plain_convective(plain_flow *flow) {
  STAMP(convective_pairs, flow);
  const int dim = flow->dim;
  for (int32_t i = 0; i < flow->fluid.n; i++) {
    const double *s = flow->sums + (int64_t)i * SUMS(dim);
    double *a = flow->acceleration + i * dim;
    for (int d = 0; d < dim; d++) a[d] = s[d] / flow->rho[i];
    a[dim - 1] -= flow->gravity;
    flow->density_rate[i] = -flow->rho[i] * s[dim];
  }
}
