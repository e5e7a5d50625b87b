/* The equations are those of sph_wcsph_create in <sph/wcsph.h>, without ghosts. */
#include "plain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LAMBDA_MIN 0.1 /* a gradient whose moment matrix is closer to singular is left out */
/* Numbers a particle in the array of sums: what the first pass wants. */
#define SUMS(dim) ((dim) == 2 ? 6 : 10)

/* Literal kernels and dimensions are folded in, as a careful author's compiler would do too. */
#define INLINE static inline __attribute__((always_inline))

int plain_allocate(plain_flow *flow, int dim, int32_t n) {
  memset(flow, 0, sizeof *flow);
  const size_t count = (size_t)n, vector = count * (size_t)dim, number = sizeof(double);
  flow->dim = dim;
  flow->n = n;
  flow->x = calloc(vector, number);
  flow->v = calloc(vector, number);
  flow->m = calloc(count, number);
  flow->rho = calloc(count, number);
  flow->p = calloc(count, number);
  flow->volume = calloc(count, number);
  flow->start = calloc(count + 1, sizeof *flow->start);
  flow->cell = calloc(count, sizeof *flow->cell);
  flow->order = calloc(count, sizeof *flow->order);
  flow->sums = calloc(count * SUMS(3), number);
  flow->gradient = calloc(vector, number);
  flow->lambda = calloc(count, number);
  flow->divergence = calloc(count, number);
  flow->acceleration = calloc(vector, number);
  flow->density_rate = calloc(count, number);
  return flow->x && flow->v && flow->m && flow->rho && flow->p && flow->volume && flow->start &&
         flow->cell && flow->order && flow->sums && flow->gradient && flow->lambda &&
         flow->divergence && flow->acceleration && flow->density_rate;
}

void plain_free(plain_flow *flow) {
  void *all[] = {
      flow->x,           flow->v,      flow->m,        flow->rho,        flow->p,
      flow->near,        flow->start,  flow->cell,     flow->order,      flow->volume,
      flow->sums,        flow->lambda, flow->gradient, flow->divergence, flow->acceleration,
      flow->density_rate};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
  memset(flow, 0, sizeof *flow);
}

void plain_state(plain_flow *flow) {
  for (int32_t i = 0; i < flow->n; i++) {
    flow->p[i] = flow->c0 * flow->c0 * (flow->rho[i] - flow->rho0);
    flow->volume[i] = flow->m[i] / flow->rho[i];
  }
}

/* ------------------------------------------------------------------------------------- list */

typedef struct grid {
  double lo[3];
  int32_t cells[3];
  int32_t *first; /* [cells + 1] */
} grid;

static int sort_into_cells(plain_flow *flow, grid *g) {
  const int dim = flow->dim;
  size_t total = 1;
  for (int d = 0; d < 3; d++) g->cells[d] = 1, g->lo[d] = 0;
  for (int d = 0; d < dim; d++) {
    double hi = flow->x[d];
    g->lo[d] = flow->x[d];
    for (int32_t i = 1; i < flow->n; i++) {
      g->lo[d] = fmin(g->lo[d], flow->x[i * dim + d]);
      hi = fmax(hi, flow->x[i * dim + d]);
    }
    g->cells[d] = (int32_t)((hi - g->lo[d]) / flow->support) + 1;
    total *= (size_t)g->cells[d];
  }
  g->first = calloc(total + 1, sizeof *g->first);
  if (!g->first) return 0;
  for (int32_t i = 0; i < flow->n; i++) {
    int32_t cell = 0;
    for (int d = 0; d < dim; d++)
      cell = cell * g->cells[d] + (int32_t)((flow->x[i * dim + d] - g->lo[d]) / flow->support);
    flow->cell[i] = cell;
    g->first[cell + 1]++;
  }
  for (size_t c = 0; c < total; c++) g->first[c + 1] += g->first[c];
  for (int32_t i = flow->n - 1; i >= 0; i--) flow->order[--g->first[flow->cell[i] + 1]] = i;
  /* first[c + 1] now is the beginning of cell c. */
  memmove(g->first, g->first + 1, total * sizeof *g->first);
  g->first[total] = flow->n;
  return 1;
}

INLINE double distance2(const double *x, int32_t i, int32_t j, const int dim) {
  double r2 = 0;
  for (int d = 0; d < dim; d++) {
    const double dx = x[i * dim + d] - x[j * dim + d];
    r2 += dx * dx;
  }
  return r2;
}

/* Appends the neighbours of i in one row of cells; the room is there. */
INLINE int64_t append(plain_flow *flow, int32_t i, int32_t begin, int32_t end, int64_t used,
                      const int dim) {
  const double support2 = flow->support * flow->support;
  for (int32_t k = begin; k < end; k++) {
    const int32_t j = flow->order[k];
    if (j > i && distance2(flow->x, i, j, dim) < support2) flow->near[used++] = j;
  }
  return used;
}

static int make_room(plain_flow *flow, int64_t wanted) {
  if (wanted <= flow->capacity) return 1;
  const int64_t capacity = wanted + wanted / 2;
  int32_t *near = realloc(flow->near, (size_t)capacity * sizeof *near);
  if (!near) return 0;
  flow->near = near;
  flow->capacity = capacity;
  return 1;
}

int plain_list(plain_flow *flow) {
  grid g;
  if (!sort_into_cells(flow, &g)) return 0;
  const int dim = flow->dim, last = dim - 1;
  int64_t used = 0;
  for (int32_t i = 0; i < flow->n; i++) {
    flow->start[i] = used;
    int32_t at[3] = {0, 0, 0}, cell = flow->cell[i];
    for (int d = last; d >= 0; d--) at[d] = cell % g.cells[d], cell /= g.cells[d];
    const int32_t along_lo = at[last] > 0 ? at[last] - 1 : 0;
    const int32_t along_hi = at[last] + 1 < g.cells[last] ? at[last] + 1 : at[last];
    const int planes = dim == 3 ? 1 : 0;
    for (int a = -1; a <= 1; a++) {
      for (int b = -planes; b <= planes; b++) {
        const int32_t ca = at[0] + a, cb = dim == 3 ? at[1] + b : 0;
        if (ca < 0 || ca >= g.cells[0] || cb < 0 || (dim == 3 && cb >= g.cells[1])) continue;
        const int32_t row = (dim == 3 ? ca * g.cells[1] + cb : ca) * g.cells[last];
        const int32_t begin = g.first[row + along_lo], end = g.first[row + along_hi + 1];
        if (!make_room(flow, used + end - begin)) {
          free(g.first);
          return 0;
        }
        used =
            dim == 2 ? append(flow, i, begin, end, used, 2) : append(flow, i, begin, end, used, 3);
      }
    }
  }
  flow->start[flow->n] = used;
  free(g.first);
  return 1;
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

static void clear_sums(plain_flow *flow) {
  memset(flow->sums, 0, (size_t)flow->n * SUMS(flow->dim) * sizeof *flow->sums);
}

/* What particle i gathered itself, onto what its neighbours have given it. */
INLINE void add_sums(plain_flow *flow, int32_t i, const double *gathered, const int dim) {
  double *sums = flow->sums + (int64_t)i * SUMS(dim);
  for (int k = 0; k < SUMS(dim); k++) sums[k] += gathered[k];
}

/* Sums of a particle: divergence, b[dim], moment matrix xx yy (zz) xy (xz yz). */
INLINE void gradient_pairs(plain_flow *flow, const plain_kernel kernel, const int dim) {
  const constants c = constants_of(flow);
  const double *x = flow->x, *v = flow->v, *rho = flow->rho, *volume = flow->volume;
  const int matrix = 1 + dim;
  for (int32_t i = 0; i < flow->n; i++) {
    double si[SUMS(3)] = {0};
    for (int64_t k = flow->start[i]; k < flow->start[i + 1]; k++) {
      const int32_t j = flow->near[k];
      double *sj = flow->sums + (int64_t)j * SUMS(dim);
      double dx[3], r2 = 0, approach = 0;
      for (int d = 0; d < dim; d++) {
        dx[d] = x[i * dim + d] - x[j * dim + d];
        r2 += dx[d] * dx[d];
        approach += (v[j * dim + d] - v[i * dim + d]) * dx[d];
      }
      const double slope = kernel_slope(&c, kernel, r2);
      const double gi = slope * volume[j], gj = slope * volume[i];
      const double difference = rho[j] - rho[i];
      si[0] += gi * approach;
      sj[0] += gj * approach;
      int at = matrix + dim;
      for (int d = 0; d < dim; d++) {
        si[1 + d] += gi * difference * dx[d];
        sj[1 + d] += gj * difference * dx[d];
        si[matrix + d] -= gi * dx[d] * dx[d];
        sj[matrix + d] -= gj * dx[d] * dx[d];
        for (int e = d + 1; e < dim; e++, at++) {
          si[at] -= gi * dx[d] * dx[e];
          sj[at] -= gj * dx[d] * dx[e];
        }
      }
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
  const double *x = flow->x, *v = flow->v, *rho = flow->rho, *volume = flow->volume;
  const double *p = flow->p, *gradient = flow->gradient;
  const double viscosity = flow->alpha * flow->h * flow->c0 * flow->rho0;
  for (int32_t i = 0; i < flow->n; i++) {
    double si[SUMS(3)] = {0};
    for (int64_t k = flow->start[i]; k < flow->start[i + 1]; k++) {
      const int32_t j = flow->near[k];
      double *sj = flow->sums + (int64_t)j * SUMS(dim);
      double dx[3], r2 = 0, approach = 0, psi = -2 * (rho[j] - rho[i]);
      for (int d = 0; d < dim; d++) {
        dx[d] = x[i * dim + d] - x[j * dim + d];
        r2 += dx[d] * dx[d];
        approach += (v[j * dim + d] - v[i * dim + d]) * dx[d];
        psi -= (gradient[i * dim + d] + gradient[j * dim + d]) * dx[d];
      }
      const double slope = kernel_slope(&c, kernel, r2);
      const double gi = slope * volume[j], gj = slope * volume[i];
      const double push = -(p[i] + p[j]) - viscosity * approach / r2;
      for (int d = 0; d < dim; d++) {
        si[d] += gi * push * dx[d];
        sj[d] -= gj * push * dx[d];
      }
      si[dim] += gi * psi;
      sj[dim] -= gj * psi;
    }
    add_sums(flow, i, si, dim);
  }
}

/* Sums of a particle: force[dim], divergence. */
INLINE void convective_pairs(plain_flow *flow, const plain_kernel kernel, const int dim) {
  const constants c = constants_of(flow);
  const double *x = flow->x, *v = flow->v, *volume = flow->volume, *p = flow->p;
  for (int32_t i = 0; i < flow->n; i++) {
    double si[SUMS(3)] = {0};
    for (int64_t k = flow->start[i]; k < flow->start[i + 1]; k++) {
      const int32_t j = flow->near[k];
      double *sj = flow->sums + (int64_t)j * SUMS(dim);
      double dx[3], r2 = 0, approach = 0;
      for (int d = 0; d < dim; d++) {
        dx[d] = x[i * dim + d] - x[j * dim + d];
        r2 += dx[d] * dx[d];
        approach += (v[j * dim + d] - v[i * dim + d]) * dx[d];
      }
      const double slope = kernel_slope(&c, kernel, r2), push = -(p[i] + p[j]);
      const double gi = slope * volume[j], gj = slope * volume[i];
      for (int d = 0; d < dim; d++) {
        si[d] += gi * push * dx[d];
        sj[d] -= gj * push * dx[d];
      }
      si[dim] += gi * approach;
      sj[dim] += gj * approach;
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
  for (int32_t i = 0; i < flow->n; i++) {
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
  for (int32_t i = 0; i < flow->n; i++) {
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
  for (int32_t i = 0; i < flow->n; i++) {
    const double *s = flow->sums + (int64_t)i * SUMS(dim);
    double *a = flow->acceleration + i * dim;
    for (int d = 0; d < dim; d++) a[d] = s[d] / flow->rho[i];
    a[dim - 1] -= flow->gravity;
    flow->density_rate[i] = -flow->rho[i] * s[dim];
  }
}
