/* Systems to solve: the pressures of jittered particles, jumps of a coefficient, a graph's Laplacian. */
#ifndef SOLVER_WORLD_H
#define SOLVER_WORLD_H

#include <math.h>
#include <sph.h>
#include <stdlib.h>
#include <string.h>

typedef struct sparse {
  int64_t n, capacity;
  int64_t *row_start;
  int32_t *columns;
  double *values;
  double *b, *x; /* b = A x */
  double *place; /* [n][3] where the unknowns are */
} sparse;

static inline sph_matrix matrix_of(const sparse *s) {
  return (sph_matrix){s->n, s->row_start, s->columns, s->values};
}

static inline sparse sparse_new(int64_t n, int64_t entries) {
  sparse s = {.n = n, .capacity = entries};
  s.row_start = calloc((size_t)n + 1, sizeof *s.row_start);
  s.columns = calloc((size_t)entries, sizeof *s.columns);
  s.values = calloc((size_t)entries, sizeof *s.values);
  s.b = calloc((size_t)n, sizeof *s.b);
  s.x = calloc((size_t)n, sizeof *s.x);
  s.place = calloc((size_t)n * 3, sizeof *s.place);
  if (!s.row_start || !s.columns || !s.values || !s.b || !s.x || !s.place) abort();
  return s;
}

static inline void sparse_free(sparse *s) {
  free(s->row_start), free(s->columns), free(s->values), free(s->b), free(s->x), free(s->place);
  *s = (sparse){0};
}

static inline void sparse_multiply(const sparse *s, const double *x, double *y) {
  for (int64_t i = 0; i < s->n; i++) {
    double sum = 0;
    for (int64_t k = s->row_start[i]; k < s->row_start[i + 1]; k++)
      sum += s->values[k] * x[s->columns[k]];
    y[i] = sum;
  }
}

/* Adds to the entry of row i, the last so far, in this column. */
static inline void sparse_add(sparse *s, int64_t i, int32_t column, double value) {
  int64_t k = s->row_start[i];
  while (k < s->row_start[i + 1] && s->columns[k] != column) k++;
  if (k == s->capacity) abort();
  if (k == s->row_start[i + 1]) {
    s->row_start[i + 1]++;
    s->columns[k] = column;
    s->values[k] = 0;
  }
  s->values[k] += value;
}

static inline double sparse_random(uint64_t *state) {
  uint64_t z = (*state += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* The inverse of a symmetric or other matrix of dim 2 or 3, by cofactors. */
static inline void small_inverse(int dim, double m[3][3], double out[3][3]) {
  double a[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int i = 0; i < dim; i++)
    for (int j = 0; j < dim; j++) a[i][j] = m[i][j];
  double c[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const int p = (i + 1) % 3, q = (i + 2) % 3, r = (j + 1) % 3, t = (j + 2) % 3;
      c[i][j] = a[p][r] * a[q][t] - a[p][t] * a[q][r];
    }
  const double d = a[0][0] * c[0][0] + a[0][1] * c[0][1] + a[0][2] * c[0][2];
  for (int i = 0; i < dim; i++)
    for (int j = 0; j < dim; j++) out[i][j] = c[j][i] / d;
}

/* A block of water of count[] particles a side, dx = 1/count[dim - 1], jittered by so much of dx. */
typedef struct water {
  int dim, count[3];
  double dx, h, *x;
} water;

typedef struct neighbour {
  int32_t column;
  double away[3], gradient[3], f; /* x_j - x_i, grad_i W, F */
} neighbour;

/* The place of lattice point `at`, mirrored at sides and bottom, and whose image it is; -1: air. */
static inline int32_t image(const water *w, const int *at, double *x) {
  int64_t index = 0;
  int own[3];
  for (int d = 0; d < w->dim; d++) {
    const int n = w->count[d];
    if (d == w->dim - 1 && at[d] >= n) return -1;
    own[d] = at[d] < 0 ? -1 - at[d] : at[d] >= n ? 2 * n - 1 - at[d] : at[d];
    index = index * n + own[d];
  }
  for (int d = 0; d < w->dim; d++) {
    const double own_x = w->x[3 * index + d];
    x[d] = at[d] < 0 ? -own_x : at[d] >= w->count[d] ? 2 * w->count[d] * w->dx - own_x : own_x;
  }
  return (int32_t)index;
}

/* dW/dr of the cubic spline. */
static inline double spline_slope(int dim, double h, double r) {
  const double q = r / h, sigma = dim == 2 ? 10 / (7 * acos(-1.0)) : 1 / acos(-1.0);
  const double slope = q >= 2 ? 0 : q < 1 ? -3 * q + 2.25 * q * q : -0.75 * (2 - q) * (2 - q);
  return sigma * slope / pow(h, dim + 1);
}

static inline int neighbours_of(const water *w, const int *at, const double *xi, neighbour *list) {
  int count = 0, to[3], reach = 3, last = w->dim == 3 ? reach : 0;
  for (int a = -reach; a <= reach; a++)
    for (int b = -reach; b <= reach; b++)
      for (int c = -last; c <= last; c++) {
        double x[3], square = 0;
        to[0] = at[0] + a, to[1] = at[1] + b, to[2] = at[2] + c;
        if (a == 0 && b == 0 && c == 0) continue;
        neighbour *one = &list[count];
        one->column = image(w, to, x);
        if (one->column < 0) continue;
        for (int d = 0; d < w->dim; d++) {
          one->away[d] = x[d] - xi[d];
          square += one->away[d] * one->away[d];
        }
        const double r = sqrt(square), slope = spline_slope(w->dim, w->h, r);
        if (slope == 0) continue;
        for (int d = 0; d < w->dim; d++) one->gradient[d] = -slope / r * one->away[d];
        one->f = -slope / r * square / (square + 0.01 * w->h * w->h);
        count++;
      }
  return count;
}

/* A row of -Laplace(p) by Morris with the correction of Schwaiger (2008), mirrored at walls; p = 0 at the
 * surface, where div r < 1.5 (2.4). */
static inline void pressure_row(const water *w, const int *at, int64_t i, sparse *s) {
  const int dim = w->dim;
  const double volume = pow(w->dx, dim), *xi = w->x + 3 * i;
  neighbour list[512];
  const int count = neighbours_of(w, at, xi, list);
  double moment[3][3] = {{0}}, gamma[3][3] = {{0}}, normal[3] = {0}, l[3][3], g[3][3];
  double divergence = 0, trace = 0;
  for (int k = 0; k < count; k++)
    for (int d = 0; d < dim; d++) {
      normal[d] += volume * list[k].gradient[d];
      divergence += volume * list[k].away[d] * list[k].gradient[d];
      for (int e = 0; e < dim; e++) {
        moment[d][e] += volume * list[k].away[d] * list[k].gradient[e];
        gamma[d][e] += volume * list[k].f * list[k].away[d] * list[k].away[e];
      }
    }
  s->row_start[i + 1] = s->row_start[i];
  sparse_add(s, i, (int32_t)i, 0);
  if (divergence < (dim == 2 ? 1.5 : 2.4)) {
    sparse_add(s, i, (int32_t)i, 1);
    return;
  }
  small_inverse(dim, moment, l);
  small_inverse(dim, gamma, g);
  for (int d = 0; d < dim; d++) trace += g[d][d] / dim;
  for (int k = 0; k < count; k++) {
    double along = 0; /* N . (L grad W) */
    for (int d = 0; d < dim; d++)
      for (int e = 0; e < dim; e++) along += normal[d] * l[e][d] * list[k].gradient[e];
    const double a = trace * volume * 2 * (list[k].f - along);
    sparse_add(s, i, list[k].column, -a);
    sparse_add(s, i, (int32_t)i, a);
  }
}

/* Pressures of a block of water. The unknowns run along the last axis first. */
static inline sparse sparse_water(int dim, int nx, int ny, int nz, double jitter, uint64_t seed) {
  water w = {.dim = dim, .count = {nx, ny, nz}};
  const int64_t n = (int64_t)nx * ny * (dim == 3 ? nz : 1);
  w.dx = 1.0 / w.count[dim - 1];
  w.h = 1.2 * w.dx;
  sparse s = sparse_new(n, n * (dim == 3 ? 96 : 32));
  w.x = s.place;
  for (int64_t i = 0; i < n; i++) {
    const int at[3] = {(int)(dim == 3 ? i / ((int64_t)ny * nz) : i / ny),
                       (int)(dim == 3 ? i / nz % ny : i % ny), (int)(dim == 3 ? i % nz : 0)};
    for (int d = 0; d < dim; d++)
      w.x[3 * i + d] = (at[d] + 0.5 + jitter * (2 * sparse_random(&seed) - 1)) * w.dx;
  }
  for (int64_t i = 0; i < n; i++) {
    const int at[3] = {(int)(dim == 3 ? i / ((int64_t)ny * nz) : i / ny),
                       (int)(dim == 3 ? i / nz % ny : i % ny), (int)(dim == 3 ? i % nz : 0)};
    pressure_row(&w, at, i, &s);
    const double *x = w.x + 3 * i, up = 1 - x[dim - 1], length = nx * w.dx;
    const bool surface = s.row_start[i + 1] - s.row_start[i] == 1;
    s.x[i] = surface ? 0 : up + 0.2 * sin(1.5 * up) * cos(2 * acos(-1.0) * x[0] / length);
  }
  sparse_multiply(&s, s.x, s.b);
  return s;
}

/* Five-point finite volumes of -div(k grad p) on nx ny cells of the unit square, k = ratio below a wavy
 * line and 1 above, p = 0 at the top, no flux elsewhere: symmetric. */
static inline sparse sparse_jump(int nx, int ny, double ratio) {
  sparse s = sparse_new((int64_t)nx * ny, (int64_t)nx * ny * 5);
  const double dx = 1.0 / nx, dy = 1.0 / ny, pi = acos(-1.0);
  for (int i = 0; i < nx; i++)
    for (int j = 0; j < ny; j++) {
      const int64_t row = (int64_t)i * ny + j;
      const int to[4][2] = {{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}};
      s.row_start[row + 1] = s.row_start[row];
      sparse_add(&s, row, (int32_t)row, 0);
      double k[5];
      for (int m = 0; m < 5; m++) {
        const double x = ((m < 4 ? to[m][0] : i) + 0.5) * dx,
                     y = ((m < 4 ? to[m][1] : j) + 0.5) * dy;
        k[m] = y < 0.6 + 0.1 * sin(4 * pi * x) ? ratio : 1;
      }
      for (int m = 0; m < 4; m++) {
        const double shape = m < 2 ? dy / dx : dx / dy;
        const bool inside = to[m][0] >= 0 && to[m][0] < nx && to[m][1] >= 0 && to[m][1] < ny;
        const double flux = shape * 2 * k[4] * k[m] / (k[4] + k[m]);
        if (inside) sparse_add(&s, row, to[m][0] * ny + to[m][1], -flux);
        if (inside || to[m][1] == ny)
          sparse_add(&s, row, (int32_t)row, inside ? flux : 2 * shape * k[4]);
      }
      const double x = (i + 0.5) * dx, y = (j + 0.5) * dy;
      s.x[row] = (1 - y) * (1 + 0.5 * cos(3 * pi * x)) + 0.1 * sin(5 * y);
    }
  sparse_multiply(&s, s.x, s.b);
  return s;
}

#endif
