/* Worlds for tests of the pair sweep: fluid and ghosts, one step's operators over them, and the same
 * sums as plain double loops. Internal headers allowed. */
#ifndef SWEEP_WORLD_H
#define SWEEP_WORLD_H

#include "particles/particles_impl.h"
#include "sph_test.h"
#include "sweep/variant.h"
#include "wcsph/ops.h"

static const double rho0 = 1000, c0 = 20, delta = 0.1, alpha = 0.02;

/* ------------------------------------------------------------------------------------ a world */

typedef struct ghost_set {
  int n;
  double *x[3], *v[3], *volume, *p, *s;
} ghost_set;

typedef struct world {
  sph_context *context;
  sph_kernel *kernel;
  sph_particles *particles;
  int dim;
  bool periodic[3];
  double lo[3], hi[3];
  double dx, lambda_min;
  ghost_set ghosts;
  sphi_frame frame;
  sphi_columns columns, ghost_columns;
} world;

static double *new_numbers(int64_t n) {
  double *numbers = calloc((size_t)n + 1, sizeof *numbers);
  CU_ASSERT_FATAL(numbers != NULL);
  return numbers;
}

/* f and f'/q are polynomials that the table of a caller's kernel holds exactly where it matters. */
static double user_w(double q, void *user) {
  (void)user;
  const double t = 1 - 0.25 * q * q;
  return t * t;
}
static double user_dw(double q, void *user) {
  (void)user;
  return -q * (1 - 0.25 * q * q);
}

/* False if the build has no kernels of the caller's own. */
static bool make_kernel(world *w, int type, double h) {
  sph_status status;
  if (type == SPH_KERNEL_USER)
    status = sph_kernel_create_user(w->context, w->dim, h, 2, user_w, user_dw, NULL, &w->kernel);
  else
    status = sph_kernel_create(w->context, (sph_kernel_type)type, w->dim, h, &w->kernel);
  CU_ASSERT(status == SPH_OK || (type == SPH_KERNEL_USER && status == SPH_E_UNAVAILABLE));
  return status == SPH_OK;
}

static void add_fluid(world *w, int n, const double *x) {
  SPH_TEST_OK(w->context, sph_particles_create(w->context, w->dim, 0.1 * w->dx, &w->particles));
  SPH_TEST_OK(w->context, sph_particles_add(w->particles, n, x, rho0, NULL));
  uint64_t state = 123;
  const double cell = pow(w->dx, w->dim);
  sphi_field *field = w->particles->field;
  for (int i = 0; i < n; i++) {
    const double m = rho0 * cell * (0.9 + 0.2 * sph_test_random(&state));
    const double rho = rho0 * (0.99 + 0.02 * sph_test_random(&state));
    field[SPHI_M].data[0][i] = m;
    field[SPHI_RHO].data[0][i] = rho;
    field[SPHI_VOL].data[0][i] = m / rho;
    field[SPHI_P].data[0][i] = c0 * c0 * (rho - rho0);
    for (int d = 0; d < w->dim; d++) field[SPHI_V].data[d][i] = 2 * sph_test_random(&state) - 1;
  }
}

static void add_ghosts(world *w, int n, const double *lo, const double *hi) {
  ghost_set *g = &w->ghosts;
  g->n = n;
  uint64_t state = 321;
  for (int d = 0; d < w->dim; d++) {
    g->x[d] = new_numbers(n);
    g->v[d] = new_numbers(n);
    for (int k = 0; k < n; k++) {
      g->x[d][k] = lo[d] + (hi[d] - lo[d]) * floor(0x1p20 * sph_test_random(&state)) * 0x1p-20;
      g->v[d][k] = 2 * sph_test_random(&state) - 1;
    }
  }
  g->volume = new_numbers(n);
  g->p = new_numbers(n);
  g->s = new_numbers(n);
  for (int k = 0; k < n; k++) {
    g->volume[k] = pow(w->dx, w->dim) * (0.5 + sph_test_random(&state));
    g->p[k] = 4000 * (2 * sph_test_random(&state) - 1);
    g->s[k] = sph_test_random(&state) < 0.5;
  }
}

/* Sorts as integrators do: columns, then the particles' storage in the order of the columns. */
static void sort_world(world *w, double width) {
  sph_particles *particles = w->particles;
  double *const *x = particles->field[SPHI_X].data;
  double origin[3] = {0, 0, 0};
  for (int d = 0; d < w->dim; d++) origin[d] = x[d][particles->slot[0]];
  const double support = sph_kernel_get_support(w->kernel);
  sphi_frame_set(&w->frame, w->dim, origin, support, w->periodic, w->lo, w->hi);
  SPH_TEST_OK(w->context, sphi_columns_build(w->context, &w->columns, &w->frame, width,
                                             particles->n, x, particles->rank, "fluid"));
  sphi_particles_permute(particles, w->columns.order);
  for (int k = 0; k < particles->n; k++) w->columns.order[k] = k;
  sphi_columns_fix(w->context, &w->columns, &w->frame, x);
  SPH_TEST_OK(w->context, sphi_columns_build(w->context, &w->ghost_columns, &w->frame, width,
                                             w->ghosts.n, w->ghosts.x, NULL, "ghosts"));
}

static void close_world(world *w) {
  sphi_columns_free(w->context, &w->columns);
  sphi_columns_free(w->context, &w->ghost_columns);
  for (int d = 0; d < 3; d++) {
    free(w->ghosts.x[d]);
    free(w->ghosts.v[d]);
  }
  free(w->ghosts.volume);
  free(w->ghosts.p);
  free(w->ghosts.s);
  sph_particles_destroy(&w->particles);
  sph_kernel_destroy(&w->kernel);
  sph_context_destroy(&w->context);
}

/* A lattice of side^dim points with spacing dx, moved by up to jitter dx; coordinates are multiples of
 * 2^-30, so that adding whole numbers is exact. */
static int lattice(int dim, int side, double dx, double jitter, const double *shift, double *x) {
  int n = 1;
  for (int d = 0; d < dim; d++) n *= side;
  uint64_t state = 77;
  for (int i = 0; i < n; i++)
    for (int d = 0, rest = i; d < dim; d++, rest /= side) {
      const double at = dx * (rest % side + 0.5 + jitter * (2 * sph_test_random(&state) - 1));
      x[i * dim + d] = floor(at * 0x1p30) * 0x1p-30 + (shift ? shift[d] : 0);
    }
  return n;
}

enum { OPEN, PERIODIC, SHIFTED, APART, SETTINGS };

/* Fluid in a box with a free surface around, or periodic in every axis, with ghosts in and around it.
 * APART: a second copy of everything, very far away. */
static bool open_world(world *w, int dim, int type, int setting) {
  const int side = dim == 2 ? 16 : 9;
  const double dx = 0.03125,
               h = (type == SPH_KERNEL_QUINTIC_SPLINE || type == SPH_KERNEL_GAUSSIAN ? 1.1 : 1.6) *
                   dx;
  memset(w, 0, sizeof *w);
  CU_ASSERT_FATAL(sph_context_create(&w->context) == SPH_OK);
  w->dim = dim;
  w->dx = dx;
  w->lambda_min = 0.1;
  if (!make_kernel(w, type, h)) {
    sph_context_destroy(&w->context);
    return false;
  }
  const double far[3] = {1024, -2048, 512};
  const double *shift = setting == SHIFTED ? far : NULL;
  double *x = new_numbers(2 * 3 * 1000);
  int n = lattice(dim, side, dx, 0.3, shift, x);
  double lo[3], hi[3];
  for (int d = 0; d < dim; d++) {
    lo[d] = (shift ? shift[d] : 0) - 4 * dx;
    hi[d] = (shift ? shift[d] : 0) + (side + 4) * dx;
    if (setting != PERIODIC) continue;
    w->periodic[d] = true;
    w->lo[d] = lo[d] = 0;
    w->hi[d] = hi[d] = side * dx;
  }
  if (setting == APART) {
    for (int k = 0; k < n * dim; k++) x[n * dim + k] = x[k] + 131072;
    n *= 2;
  }
  add_fluid(w, n, x);
  add_ghosts(w, setting == APART ? 2 * 150 : 150, lo, hi);
  for (int k = 150; k < w->ghosts.n; k++)
    for (int d = 0; d < dim; d++) w->ghosts.x[d][k] = w->ghosts.x[d][k - 150] + 131072;
  sort_world(w, 0.5 * sph_kernel_get_support(w->kernel));
  free(x);
  return true;
}

/* ------------------------------------------------------------------------- what operators give */

enum {
  DIVERGENCE,
  LAMBDA,
  GRADIENT,
  PRESSURE,
  VISCOUS,
  TOTAL,
  DIFFUSION,
  RATES,
  RATES_DIVERGENCE,
  QUANTITIES
};
static const char *const quantity_names[QUANTITIES] = {"divergence", "lambda",  "gradient",
                                                       "pressure",   "viscous", "total",
                                                       "diffusion",  "rates",   "rates divergence"};

/* [n][3] each, in id order. */
typedef struct results {
  int n;
  double *q[QUANTITIES];
} results;

static results new_results(int n) {
  results r = {.n = n};
  for (int q = 0; q < QUANTITIES; q++) r.q[q] = new_numbers(3 * (int64_t)n);
  return r;
}

static void free_results(results *r) {
  for (int q = 0; q < QUANTITIES; q++) free(r->q[q]);
}

/* max |a - b| / max |b| */
static double largest_error(const double *a, const double *b, int64_t n) {
  double error = 0, largest = 0;
  for (int64_t k = 0; k < n; k++) {
    if (!(fabs(a[k] - b[k]) <= error)) error = fabs(a[k] - b[k]); /* takes NaN too */
    if (fabs(b[k]) > largest) largest = fabs(b[k]);
  }
  return error / (largest + 1e-300);
}

typedef struct engine {
  const sphi_variant *variant;
  sphi_clusters clusters;
  sphi_list list, ghost_list;
  void *record, *ghost_record;
  sphi_sweep sweep;
} engine;

static void pack_fluid(const world *w, engine *e) {
  const sphi_field *field = w->particles->field;
  const int dim = w->dim, n = w->particles->n;
  sphi_pack pack = {.frame = &w->frame, .n = n, .stride = SPHI_RECORD(dim), .columns = dim + 3};
  pack.value[0] = field[SPHI_VOL].data[0];
  pack.value[1] = field[SPHI_P].data[0];
  pack.value[dim + 2] = field[SPHI_RHO].data[0];
  pack.shift[dim + 2] = rho0;
  for (int d = 0; d < dim; d++) {
    pack.x[d] = field[SPHI_X].data[d];
    pack.value[2 + d] = field[SPHI_V].data[d];
  }
  pack.record = e->record = calloc((size_t)(n + SPHI_PAD) * SPHI_RECORD(3), e->variant->real_size);
  CU_ASSERT_FATAL(pack.record != NULL);
  sphi_pack_run(w->context, e->variant, &pack);
}

static void pack_ghosts(const world *w, engine *e) {
  const ghost_set *g = &w->ghosts;
  const int dim = w->dim;
  sphi_pack pack = {.frame = &w->frame,
                    .n = g->n,
                    .stride = SPHI_GHOST(dim),
                    .order = w->ghost_columns.order,
                    .columns = dim + 3};
  pack.value[0] = g->volume;
  pack.value[1] = g->p;
  pack.value[dim + 2] = g->s;
  for (int d = 0; d < dim; d++) {
    pack.x[d] = g->x[d];
    pack.value[2 + d] = g->v[d];
  }
  pack.record = e->ghost_record =
      calloc((size_t)(g->n + SPHI_PAD) * SPHI_GHOST(3), e->variant->real_size);
  CU_ASSERT_FATAL(pack.record != NULL);
  sphi_pack_run(w->context, e->variant, &pack);
}

static void open_engine(const world *w, const sphi_variant *variant, engine *e) {
  memset(e, 0, sizeof *e);
  e->variant = variant;
  const double support = sph_kernel_get_support(w->kernel);
  double *const *x = w->particles->field[SPHI_X].data;
  SPH_TEST_OK(w->context, sphi_clusters_build(w->context, &e->clusters, &w->columns, &w->frame, x,
                                              variant->lanes, 0.7 * support));
  SPH_TEST_OK(w->context,
              sphi_list_build(w->context, &e->list, &w->frame, &e->clusters, &w->columns, support));
  pack_fluid(w, e);
  e->sweep = (sphi_sweep){.frame = &w->frame,
                          .kernel = w->kernel,
                          .targets = &e->clusters,
                          .target = e->record,
                          .target_stride = SPHI_RECORD(w->dim)};
  e->sweep.source[0].list = &e->list;
  e->sweep.source[0].record = e->record;
  if (!w->ghosts.n) return;
  SPH_TEST_OK(w->context, sphi_list_build(w->context, &e->ghost_list, &w->frame, &e->clusters,
                                          &w->ghost_columns, support));
  pack_ghosts(w, e);
  e->sweep.source[1].list = &e->ghost_list;
  e->sweep.source[1].record = e->ghost_record;
}

static void close_engine(const world *w, engine *e) {
  sphi_clusters_free(w->context, &e->clusters);
  sphi_list_free(w->context, &e->list);
  sphi_list_free(w->context, &e->ghost_list);
  free(e->record);
  free(e->ghost_record);
}

/* Number k of an array of the variant's reals. */
static double real_value(const sphi_variant *variant, const void *array, int64_t k) {
  return variant->is_double ? ((const double *)array)[k] : (double)((const float *)array)[k];
}

/* One step's three operators; scratch[s] are [n] arrays of the variant's reals in storage order. */
static void run_engine(const world *w, engine *e, results *out) {
  const int n = w->particles->n, dim = w->dim;
  const double *m = w->particles->field[SPHI_M].data[0];
  const sph_index *rank = w->particles->rank;
  void *scratch[9];
  for (int s = 0; s < 9; s++) scratch[s] = new_numbers(n);
#define KEEP(quantity, component, values) \
  for (int k = 0; k < n; k++)             \
  out->q[quantity][3 * rank[k] + (component)] = real_value(e->variant, values, k)
  sphi_gradient_arguments gradient = {e->record, scratch[0], scratch[1], w->lambda_min};
  sphi_sweep_run(w->context, e->variant, SPHI_OPERATOR_gradient, &e->sweep, &gradient);
  KEEP(DIVERGENCE, 0, scratch[0]);
  KEEP(LAMBDA, 0, scratch[1]);
  for (int k = 0; k < n; k++)
    for (int d = 0; d < dim; d++)
      out->q[GRADIENT][3 * rank[k] + d] =
          real_value(e->variant, e->record, (int64_t)k * SPHI_RECORD(dim) + SPHI_RECORD_G(dim) + d);
  sphi_momentum_arguments momentum = {.acceleration = {scratch[2], scratch[3], scratch[4]},
                                      .viscous = {scratch[5], scratch[6], scratch[7]},
                                      .diffusion = scratch[8],
                                      .record = e->record,
                                      .m = m,
                                      .lambda = scratch[1],
                                      .lambda_min = w->lambda_min,
                                      .viscosity = alpha * w->kernel->h * c0,
                                      .delta = delta * w->kernel->h * c0,
                                      .rho0 = rho0};
  sphi_sweep_run(w->context, e->variant, SPHI_OPERATOR_momentum, &e->sweep, &momentum);
  for (int d = 0; d < dim; d++) {
    KEEP(PRESSURE, d, scratch[2 + d]);
    KEEP(VISCOUS, d, scratch[5 + d]);
    momentum.viscous[d] = NULL;
  }
  KEEP(DIFFUSION, 0, scratch[8]);
  momentum.diffusion = NULL;
  sphi_sweep_run(w->context, e->variant, SPHI_OPERATOR_momentum, &e->sweep, &momentum);
  for (int d = 0; d < dim; d++) KEEP(TOTAL, d, scratch[2 + d]);
  sphi_rates_arguments rates = {{scratch[2], scratch[3], scratch[4]}, scratch[0], e->record, m};
  sphi_sweep_run(w->context, e->variant, SPHI_OPERATOR_rates, &e->sweep, &rates);
  for (int d = 0; d < dim; d++) KEEP(RATES, d, scratch[2 + d]);
  KEEP(RATES_DIVERGENCE, 0, scratch[0]);
  for (int s = 0; s < 9; s++) free(scratch[s]);
}

static void run_world(const world *w, const sphi_variant *variant, results *out) {
  engine e;
  open_engine(w, variant, &e);
  run_engine(w, &e, out);
  close_engine(w, &e);
}

/* ----------------------------------------------------------------------------- plain double loops */

static double difference(const world *w, int d, double a, double b) {
  const double length = w->hi[d] - w->lo[d];
  double dx = a - b;
  if (!w->periodic[d]) return dx;
  while (dx > 0.5 * length) dx -= length;
  while (dx < -0.5 * length) dx += length;
  return dx;
}

/* dx = x_i - x_j and grad_i W; false outside the support. */
static bool kernel_gradient(const world *w, const double *xi, const double *xj, double *dx,
                            double *r2, double *grad) {
  *r2 = 0;
  for (int d = 0; d < w->dim; d++) {
    dx[d] = difference(w, d, xi[d], xj[d]);
    *r2 += dx[d] * dx[d];
  }
  const double r = sqrt(*r2);
  if (r >= sph_kernel_get_support(w->kernel) || r == 0) return false;
  const double slope = sph_kernel_dw(w->kernel, r);
  for (int d = 0; d < w->dim; d++) grad[d] = slope * dx[d] / r;
  return true;
}

/* Eigenvalues of a symmetric matrix by Jacobi's rotations: the smallest one. */
static double smallest_eigenvalue(int dim, const double matrix[3][3]) {
  double m[3][3];
  memcpy(m, matrix, sizeof m);
  for (int sweep = 0; sweep < 30; sweep++)
    for (int p = 0; p < dim; p++)
      for (int q = p + 1; q < dim; q++) {
        const double angle = 0.5 * atan2(2 * m[p][q], m[q][q] - m[p][p]), c = cos(angle),
                     s = sin(angle);
        for (int k = 0; k < dim; k++) {
          const double a = m[k][p], b = m[k][q];
          m[k][p] = c * a - s * b;
          m[k][q] = s * a + c * b;
        }
        for (int k = 0; k < dim; k++) {
          const double a = m[p][k], b = m[q][k];
          m[p][k] = c * a - s * b;
          m[q][k] = s * a + c * b;
        }
      }
  return fmin(fmin(m[0][0], m[1][1]), dim == 3 ? m[2][2] : HUGE_VAL);
}

/* x in m x = b by elimination with pivots. */
static void solve(int dim, const double matrix[3][3], const double *b, double *x) {
  double a[3][4];
  for (int r = 0; r < dim; r++) {
    for (int c = 0; c < dim; c++) a[r][c] = matrix[r][c];
    a[r][dim] = b[r];
  }
  for (int c = 0; c < dim; c++) {
    int pivot = c;
    for (int r = c + 1; r < dim; r++)
      if (fabs(a[r][c]) > fabs(a[pivot][c])) pivot = r;
    for (int k = 0; k <= dim; k++) {
      const double t = a[c][k];
      a[c][k] = a[pivot][k];
      a[pivot][k] = t;
    }
    for (int r = 0; r < dim; r++) {
      const double factor = r == c ? 0 : a[r][c] / a[c][c];
      for (int k = 0; k <= dim; k++) a[r][k] -= factor * a[c][k];
    }
  }
  for (int c = 0; c < dim; c++) x[c] = a[c][dim] / a[c][c];
}

typedef struct point {
  double x[3], v[3], volume, p, rho;
} point;

static point *plain_fluid(const world *w) {
  const int n = w->particles->n;
  point *fluid = calloc((size_t)n, sizeof *fluid);
  CU_ASSERT_FATAL(fluid != NULL);
  const sphi_field *field = w->particles->field;
  for (int i = 0; i < n; i++) {
    const int k = w->particles->slot[i];
    for (int d = 0; d < w->dim; d++) {
      fluid[i].x[d] = field[SPHI_X].data[d][k];
      fluid[i].v[d] = field[SPHI_V].data[d][k];
    }
    fluid[i].volume = field[SPHI_VOL].data[0][k];
    fluid[i].p = field[SPHI_P].data[0][k];
    fluid[i].rho = field[SPHI_RHO].data[0][k];
  }
  return fluid;
}

/* pi_ij = (u_j - u_i) . x_ji / |x_ji|^2 */
static double velocity_term(int dim, const double *vi, const double *vj, const double *dx,
                            double r2) {
  double sum = 0;
  for (int d = 0; d < dim; d++) sum += (vj[d] - vi[d]) * -dx[d];
  return sum / r2;
}

static void plain_gradient(const world *w, const point *fluid, int i, results *out) {
  const int dim = w->dim;
  double m[3][3] = {{0}}, b[3] = {0, 0, 0}, divergence = 0, dx[3], grad[3], r2;
  for (int j = 0; j < w->particles->n; j++) {
    if (!kernel_gradient(w, fluid[i].x, fluid[j].x, dx, &r2, grad)) continue;
    for (int d = 0; d < dim; d++) {
      for (int e = 0; e < dim; e++) m[d][e] += -dx[d] * grad[e] * fluid[j].volume;
      b[d] += (fluid[j].rho - fluid[i].rho) * grad[d] * fluid[j].volume;
      divergence += (fluid[j].v[d] - fluid[i].v[d]) * grad[d] * fluid[j].volume;
    }
  }
  for (int j = 0; j < w->ghosts.n; j++) {
    double xj[3] = {0, 0, 0};
    for (int d = 0; d < dim; d++) xj[d] = w->ghosts.x[d][j];
    if (!kernel_gradient(w, fluid[i].x, xj, dx, &r2, grad)) continue;
    for (int d = 0; d < dim; d++)
      divergence += (w->ghosts.v[d][j] - fluid[i].v[d]) * grad[d] * w->ghosts.volume[j];
  }
  out->q[DIVERGENCE][3 * i] = out->q[RATES_DIVERGENCE][3 * i] = divergence;
  out->q[LAMBDA][3 * i] = smallest_eigenvalue(dim, (const double(*)[3])m);
  if (out->q[LAMBDA][3 * i] >= w->lambda_min)
    solve(dim, (const double(*)[3])m, b, out->q[GRADIENT] + 3 * i);
}

static void plain_momentum(const world *w, const point *fluid, int i, results *out) {
  const int dim = w->dim;
  const double h = sph_kernel_get_h(w->kernel);
  double pressure[3] = {0}, viscous[3] = {0}, diffusion = 0, dx[3], grad[3], r2;
  for (int j = 0; j < w->particles->n; j++) {
    if (!kernel_gradient(w, fluid[i].x, fluid[j].x, dx, &r2, grad)) continue;
    const double pi = velocity_term(dim, fluid[i].v, fluid[j].v, dx, r2);
    for (int d = 0; d < dim; d++) {
      pressure[d] += (fluid[i].p + fluid[j].p) * grad[d] * fluid[j].volume;
      viscous[d] += pi * grad[d] * fluid[j].volume;
      const double psi = 2 * (fluid[j].rho - fluid[i].rho) * -dx[d] / r2 -
                         (out->q[GRADIENT][3 * i + d] + out->q[GRADIENT][3 * j + d]);
      diffusion += psi * grad[d] * fluid[j].volume;
    }
  }
  for (int j = 0; j < w->ghosts.n; j++) {
    double xj[3] = {0}, vj[3] = {0};
    for (int d = 0; d < dim; d++) {
      xj[d] = w->ghosts.x[d][j];
      vj[d] = w->ghosts.v[d][j];
    }
    if (!kernel_gradient(w, fluid[i].x, xj, dx, &r2, grad)) continue;
    const double pi = w->ghosts.s[j] * velocity_term(dim, fluid[i].v, vj, dx, r2);
    for (int d = 0; d < dim; d++) {
      pressure[d] += (fluid[i].p + w->ghosts.p[j]) * grad[d] * w->ghosts.volume[j];
      viscous[d] += pi * grad[d] * w->ghosts.volume[j];
    }
  }
  for (int d = 0; d < dim; d++) {
    const int at = 3 * i + d;
    out->q[PRESSURE][at] = out->q[RATES][at] = -pressure[d] / fluid[i].rho;
    out->q[VISCOUS][at] = alpha * h * c0 * rho0 / fluid[i].rho * viscous[d];
    out->q[TOTAL][at] = out->q[PRESSURE][at] + out->q[VISCOUS][at];
  }
  if (out->q[LAMBDA][3 * i] >= w->lambda_min) out->q[DIFFUSION][3 * i] = delta * h * c0 * diffusion;
}

static void plain_loops(const world *w, results *out) {
  point *fluid = plain_fluid(w);
  for (int i = 0; i < w->particles->n; i++) plain_gradient(w, fluid, i, out);
  for (int i = 0; i < w->particles->n; i++) plain_momentum(w, fluid, i, out);
  free(fluid);
}

/* The next variant that this processor has; `at` starts at 0. */
static const sphi_variant *next_variant(world *w, int *at) {
  for (;;) {
    const int k = (*at)++;
    if (k == 0) return sphi_variant_reference();
    if (k > 6) return NULL;
    const sph_isa isa = (sph_isa)(SPH_ISA_BASELINE + (k - 1) / 2);
    if (sph_context_set_isa(w->context, isa) != SPH_OK) continue;
    const sphi_variant *variant = sphi_variant_find(isa, (sph_precision)((k - 1) % 2));
    if (variant) return variant;
  }
}

#endif
