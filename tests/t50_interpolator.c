/* Interpolators: consistency, convergence, ladder, against a plain sum over all particles, errors. */
#include "any_interpolator.h"

enum { MAX_POINTS = 96 };

static const double pi = 3.14159265358979323846;
static const char *const field_f[] = {"f"};

/* A block of fluid with a wall at 0 in every direction, and points in and around it. */
typedef struct setup {
  sph_context *context;
  sph_particles *particles;
  sph_kernel *kernel;
  sph_interpolator *interpolator;
  int dim;
  double dx;
  sph_index n;
  double *x, *f;
  int points;
  double at[3 * MAX_POINTS], values[4 * MAX_POINTS];
  int rungs[MAX_POINTS];
} setup;

/* A caller's kernel is normalised by GSL. */
#ifdef SPHI_GSL
enum { USER_KERNELS = 1 };
#else
enum { USER_KERNELS = 0 };
#endif

static double kernel_user_w(double q, void *user) {
  (void)user;
  return q < 1 ? (1 - q * q) * (1 - q * q) : 0;
}

static double kernel_user_dw(double q, void *user) {
  (void)user;
  return q < 1 ? -4 * q * (1 - q * q) : 0;
}

/* Support 3.9 spacings, the paper's choice, whatever the kernel. */
static void set_method(setup *s, int kernel_type, int type) {
  sph_interpolator_destroy(&s->interpolator);
  sph_kernel_destroy(&s->kernel);
  const double support = 3.9 * s->dx;
  if (kernel_type == SPH_KERNEL_USER) {
    SPH_TEST_OK(s->context, sph_kernel_create_user(s->context, s->dim, support, 1, kernel_user_w,
                                                   kernel_user_dw, NULL, &s->kernel));
  } else {
    const double ratio =
        kernel_type == SPH_KERNEL_QUINTIC_SPLINE || kernel_type == SPH_KERNEL_GAUSSIAN ? 3 : 2;
    SPH_TEST_OK(s->context, sph_kernel_create(s->context, (sph_kernel_type)kernel_type, s->dim,
                                              support / ratio, &s->kernel));
  }
  any_create(s->context, type, s->kernel, &s->interpolator);
}

static void set_context(setup *s, const sph_allocator *allocator) {
  memset(s, 0, sizeof *s);
  if (allocator)
    SPH_TEST_OK(NULL, sph_context_create_with_allocator(allocator, &s->context));
  else
    SPH_TEST_OK(NULL, sph_context_create(&s->context));
}

/* Particles of spacing dx at x [n, dim], with a field "f". */
static void set_particles(setup *s, int dim, double dx, sph_index n, const double *x) {
  s->dim = dim;
  s->dx = dx;
  s->n = n;
  SPH_TEST_OK(s->context, sph_particles_create(s->context, dim, dx, &s->particles));
  SPH_TEST_OK(s->context, sph_particles_set_name(s->particles, "water"));
  s->x = malloc((size_t)(n * dim) * sizeof(double));
  s->f = malloc((size_t)n * sizeof(double));
  memcpy(s->x, x, (size_t)(n * dim) * sizeof(double));
  /* Added at places of their own and moved, so that a test may let particles coincide. */
  double *apart = malloc((size_t)(n * dim) * sizeof(double));
  for (sph_index i = 0; i < n; i++)
    for (int d = 0; d < dim; d++) apart[i * dim + d] = d == 0 ? dx * i : 0;
  SPH_TEST_OK(s->context, sph_particles_add(s->particles, n, apart, 1000, NULL));
  SPH_TEST_OK(s->context, sph_particles_write(s->particles, SPH_POSITION, s->x, (int64_t)n * dim));
  SPH_TEST_OK(s->context, sph_particles_add_field(s->particles, "f", 1, "Pa"));
  free(apart);
}

static void set_block(setup *s, int dim, double dx, const int *cells, double jitter) {
  uint64_t seed = 7 + (uint64_t)dim;
  const int layers = dim == 3 ? cells[2] : 1;
  double *x = malloc((size_t)(cells[0] * cells[1] * layers * dim) * sizeof(double));
  sph_index n = 0;
  for (int i = 0; i < cells[0]; i++)
    for (int j = 0; j < cells[1]; j++)
      for (int k = 0; k < layers; k++, n++) {
        const int cell[3] = {i, j, k};
        for (int d = 0; d < dim; d++)
          x[n * dim + d] = dx * (cell[d] + 0.5 + jitter * (sph_test_random(&seed) - 0.5));
      }
  set_particles(s, dim, dx, n, x);
  free(x);
}

static void close_setup(setup *s) {
  sph_interpolator_destroy(&s->interpolator);
  sph_kernel_destroy(&s->kernel);
  sph_particles_destroy(&s->particles);
  sph_context_destroy(&s->context);
  free(s->x);
  free(s->f);
}

/* A third of the points inside, a third 0.3 to 2.7 spacings from one wall, a third from all walls. */
static void scatter_points(setup *s, int points, double extent) {
  uint64_t seed = 77;
  s->points = points;
  for (int k = 0; k < points; k++)
    for (int d = 0; d < s->dim; d++) {
      const double u = sph_test_random(&seed);
      const bool near_wall = k % 3 == 2 || (k % 3 == 1 && d == s->dim - 1);
      s->at[k * s->dim + d] = near_wall ? s->dx * (0.3 + 2.4 * u) : extent * (0.3 + 0.4 * u);
    }
}

static void fill_f(setup *s, double (*function)(const double *x, int dim)) {
  for (sph_index i = 0; i < s->n; i++) s->f[i] = function(s->x + i * s->dim, s->dim);
  SPH_TEST_OK(s->context, sph_particles_write(s->particles, "f", s->f, s->n));
}

static void evaluate(setup *s) {
  SPH_TEST_OK(s->context, sph_interpolator_evaluate(s->interpolator, s->particles, s->points, s->at,
                                                    1, field_f, s->values, s->rungs));
}

/* Every kernel and interpolator, in 2D and 3D; check(s, type) looks at one. */
static void for_all_methods(void (*check)(setup *s, int type),
                            double (*function)(const double *x, int dim)) {
  for (int dim = 2; dim <= 3; dim++) {
    setup s;
    set_context(&s, NULL);
    set_block(&s, dim, 0.01, (const int[]){14, 14, 14}, 0.4);
    fill_f(&s, function);
    scatter_points(&s, 60, 0.14);
    for (int kernel = 1; kernel <= sph_kernel_count(); kernel++)
      for (int k = 0; k < sph_interpolator_count(); k++) {
        if (kernel == SPH_KERNEL_USER && !USER_KERNELS) continue;
        set_method(&s, kernel, (int)sph_interpolator_at(k));
        check(&s, (int)sph_interpolator_at(k));
      }
    close_setup(&s);
  }
}

static void check_constant(setup *s, int type) {
  int own = 0;
  evaluate(s);
  for (int k = 0; k < s->points; k++) {
    SPH_TEST_CLOSE(s->values[k], 1234.5, 1e-12, 0);
    own += s->rungs[k] == type;
  }
  /* In the block's corners few neighbours bear a quadratic fit. */
  CU_ASSERT(own >= s->points - (type == SPH_INTERPOLATOR_MLS_QUADRATIC));
}

static void constants_are_exact(void) { for_all_methods(check_constant, constant); }

static void check_linear(setup *s, int type) {
  if (any_degree(type) > 0) {
    evaluate(s);
    for (int k = 0; k < s->points; k++)
      SPH_TEST_CLOSE(s->values[k], linear(s->at + k * s->dim, s->dim), 1e-11, 0);
  }
  SPH_TEST_OK(s->context,
              sph_interpolator_evaluate_compensated(s->interpolator, s->particles, s->points, s->at,
                                                    "f", any_slope, s->values, s->rungs));
  for (int k = 0; k < s->points; k++)
    SPH_TEST_CLOSE(s->values[k], linear(s->at + k * s->dim, s->dim), 1e-12, 0);
}

static void linear_fields_are_exact(void) { for_all_methods(check_linear, linear); }

/* sum phi_j f_j over all particles by the definition of phi_j, in long double. */
static double plain_sum(const setup *s, int type, const double *weight_of, const double *at) {
  const double *volume;
  SPH_TEST_OK(s->context, sph_particles_lease_read(s->particles, SPH_VOLUME, &volume));
  const any_case all = {.kernel = s->kernel,
                        .dim = s->dim,
                        .n = s->n,
                        .x = s->x,
                        .volume = volume,
                        .type = type,
                        .mu = weight_of[0],
                        .scale = weight_of[1],
                        .lambda = weight_of[2]};
  long double *phi = malloc((size_t)s->n * sizeof *phi), sum = 0;
  CU_ASSERT_FATAL(any_phi(&all, at, -1, phi));
  for (sph_index i = 0; i < s->n; i++) sum += phi[i] * s->f[i];
  free(phi);
  SPH_TEST_OK(s->context, sph_particles_release(s->particles, volume));
  return (double)sum;
}

static void check_plain_sum(setup *s, int type) {
  static const double weights[][3] = {{4, 1, 2}, {2, 2.0 / 3, 2}, {3, 0.8, 1.5}, {4, 1000, 4}};
  const size_t rows = any_shepard(type) ? 4 : 1;
  for (size_t row = 0; row < rows; row++) {
    const double *w = weights[row];
    SPH_TEST_OK(s->context, sph_interpolator_set_shepard(s->interpolator, w[0], w[1], w[2]));
    evaluate(s);
    /* The sums over particles replace a caller's kernel by piecewise cubics. */
    const bool tabulated = sph_kernel_get_type(s->kernel) == SPH_KERNEL_USER && !any_shepard(type);
    for (int k = 0; k < s->points; k += 5)
      SPH_TEST_CLOSE(s->values[k], plain_sum(s, s->rungs[k], w, s->at + k * s->dim), 0,
                     tabulated ? 1e-7 : 1e-12);
  }
}

static void plain_sums_agree(void) { for_all_methods(check_plain_sum, wavy); }

/* Still water with a standing wave on it, in units of rho g dx. */
static double wave_pressure(const double *x, int dim) {
  const double d = 0.3, a = 0.03, k = 2 * pi;
  (void)dim;
  return 9810 * ((d - x[1]) + a * cosh(k * x[1]) / cosh(k * d) * cos(k * x[0]));
}

static double rms_error(setup *s, double unit) {
  double sum = 0;
  for (int k = 0; k < s->points; k++) {
    const double error = (s->values[k] - wave_pressure(s->at + k * s->dim, s->dim)) / unit;
    sum += error * error;
  }
  return sqrt(sum / s->points);
}

static void convergence_has_the_claimed_order(void) {
  double error[3][3];
  for (int level = 0; level < 3; level++) {
    const int cells[2] = {50 << level, 15 << level};
    setup s;
    set_context(&s, NULL);
    set_block(&s, 2, 0.02 / (1 << level), cells, 0.4);
    fill_f(&s, wave_pressure);
    uint64_t seed = 5;
    s.points = MAX_POINTS;
    for (int k = 0; k < s.points; k++) {
      s.at[2 * k] = 0.2 + 0.6 * sph_test_random(&seed);
      s.at[2 * k + 1] = s.dx * (0.3 + 2.4 * sph_test_random(&seed));
    }
    for (int k = 0; k < 3; k++) {
      set_method(&s, SPH_KERNEL_GAUSSIAN, (int)sph_interpolator_at(k));
      evaluate(&s);
      error[level][k] = rms_error(&s, 9810 * 0.3);
    }
    close_setup(&s);
  }
  for (int level = 0; level < 2; level++)
    for (int k = 0; k < 3; k++) {
      const double order = log2(error[level][k] / error[level + 1][k]);
      if (sph_interpolator_at(k) == SPH_INTERPOLATOR_MLS_LINEAR)
        SPH_TEST_CLOSE(order, 2, 0, 0.2);
      else
        SPH_TEST_CLOSE(order, 1.05, 0, 0.25);
    }
}

/* Mirror points of three layers of ghosts below the bottom. */
static void mirror_points(setup *s) {
  s->points = 0;
  for (int column = 20; column < 50; column++)
    for (int layer = 0; layer < 3; layer++) {
      s->at[2 * s->points] = s->dx * (column + 0.5);
      s->at[2 * s->points + 1] = s->dx * (layer + 0.5);
      s->points++;
    }
}

/* The numbers of the tables in docs/interpolator.md, to their last digit. */
static void lattice_near_a_wall_has_known_errors(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 2, 0.01, (const int[]){100, 30}, 0);
  fill_f(&s, wave_pressure);
  mirror_points(&s);
  set_method(&s, SPH_KERNEL_GAUSSIAN, SPH_INTERPOLATOR_NORMALIZED);
  const char *const position[] = {SPH_POSITION};
  double x[2 * MAX_POINTS], moment = 0;
  SPH_TEST_OK(s.context, sph_interpolator_evaluate(s.interpolator, s.particles, s.points, s.at, 1,
                                                   position, x, NULL));
  for (int k = 0; k < 2 * s.points; k++) moment += (x[k] - s.at[k]) * (x[k] - s.at[k]);
  SPH_TEST_CLOSE(sqrt(moment / s.points) / s.dx, 0.269, 0, 5e-4);
  evaluate(&s);
  SPH_TEST_CLOSE(rms_error(&s, 98.1), 0.269, 0, 5e-4);
  const double hydrostatic[2] = {0, -9810};
  SPH_TEST_OK(s.context,
              sph_interpolator_evaluate_compensated(s.interpolator, s.particles, s.points, s.at,
                                                    "f", hydrostatic, s.values, NULL));
  SPH_TEST_CLOSE(rms_error(&s, 98.1), 1.6e-4, 0, 5e-6);
  set_method(&s, SPH_KERNEL_GAUSSIAN, SPH_INTERPOLATOR_MLS_LINEAR);
  evaluate(&s);
  SPH_TEST_CLOSE(rms_error(&s, 98.1), 6.6e-4, 0, 5e-6);
  close_setup(&s);
}

static void shepard_stays_within_the_range_of_its_neighbours(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 2, 0.01, (const int[]){14, 14}, 0.4);
  for (sph_index i = 0; i < s.n; i++) s.f[i] = s.x[2 * i + 1] < 2 * s.dx ? -1 : 1;
  SPH_TEST_OK(s.context, sph_particles_write(s.particles, "f", s.f, s.n));
  scatter_points(&s, MAX_POINTS, 0.14);
  for (int k = 0; k < sph_interpolator_count(); k++) {
    const int type = (int)sph_interpolator_at(k);
    bool leaves = false;
    set_method(&s, SPH_KERNEL_WENDLAND_C4, type);
    evaluate(&s);
    for (int p = 0; p < s.points; p++) {
      leaves = leaves || fabs(s.values[p]) > 1.001;
      CU_ASSERT(fabs(s.values[p]) <= any_lebesgue(s.rungs[p]) + 1e-14);
    }
    CU_ASSERT_EQUAL(leaves, any_mls(type) || any_sfdi(type)); /* or the test would show nothing */
  }
  close_setup(&s);
}

static void shepard_returns_the_value_of_a_coincident_particle(void) {
  static const double mus[] = {1, 2, 3, 4, 16};
  for (int dim = 2; dim <= 3; dim++) {
    setup s;
    set_context(&s, NULL);
    set_block(&s, dim, 0.01, (const int[]){8, 8, 8}, 0.4);
    fill_f(&s, wavy);
    set_method(&s, SPH_KERNEL_CUBIC_SPLINE, SPH_INTERPOLATOR_IMPROVED_SHEPARD);
    s.points = 50;
    memcpy(s.at, s.x, (size_t)(s.points * dim) * sizeof(double));
    for (size_t k = 0; k < sizeof mus / sizeof mus[0]; k++) {
      SPH_TEST_OK(s.context, sph_interpolator_set_shepard(s.interpolator, mus[k], 1, 2));
      evaluate(&s);
      for (int p = 0; p < s.points; p++) SPH_TEST_CLOSE(s.values[p], s.f[p], 1e-15, 0);
    }
    close_setup(&s);
  }
}

/* n particles placed by `place` around the origin, support 1; every method at points around. */
static void check_ladder(int dim, sph_index n, void (*place)(double *x, int dim, uint64_t *seed)) {
  uint64_t seed = (uint64_t)n;
  double x[3 * 48] = {0};
  for (sph_index i = 0; i < n; i++) place(x + i * dim, dim, &seed);
  for (int d = 0; d < dim; d++) x[n * dim + d] = d == 0 ? 50 : 0; /* sets are never empty */
  setup s;
  set_context(&s, NULL);
  set_particles(&s, dim, 0.25, n + 1, x);
  fill_f(&s, linear);
  s.points = 6;
  for (int k = 0; k < s.points; k++)
    for (int d = 0; d < dim; d++)
      s.at[k * dim + d] = k == 0 ? 0 : k == 5 ? 1e200 : 0.6 * k * (sph_test_random(&seed) - 0.5);
  for (int k = 0; k < sph_interpolator_count(); k++) {
    const int type = (int)sph_interpolator_at(k);
    set_method(&s, SPH_KERNEL_GAUSSIAN, type);
    SPH_TEST_OK(s.context,
                sph_interpolator_evaluate_compensated(s.interpolator, s.particles, s.points, s.at,
                                                      "f", any_slope, s.values, s.rungs));
    for (int p = 0; p < s.points; p++) {
      const double *at = s.at + p * dim;
      const int rung = s.rungs[p];
      int neighbours = 0;
      for (sph_index i = 0; i < s.n; i++) {
        double r2 = 0;
        for (int d = 0; d < dim; d++) r2 += (x[i * dim + d] - at[d]) * (x[i * dim + d] - at[d]);
        neighbours += r2 < 3.9 * 3.9 * 0.25 * 0.25;
      }
      CU_ASSERT_EQUAL(rung == 0, neighbours == 0);
      CU_ASSERT(any_step(type, rung) >= 0);
      if (rung) CU_ASSERT(neighbours >= any_neighbours(rung, dim));
      SPH_TEST_CLOSE(s.values[p], neighbours ? linear(at, dim) : 0, 1e-10, 0);
    }
  }
  close_setup(&s);
}

static void place_anywhere(double *x, int dim, uint64_t *seed) {
  for (int d = 0; d < dim; d++) x[d] = 1.2 * (sph_test_random(seed) - 0.5);
}

static void place_on_a_line(double *x, int dim, uint64_t *seed) {
  const double t = sph_test_random(seed) - 0.5;
  for (int d = 0; d < dim; d++) x[d] = 0.1 + 0.5 * (d + 1) * t;
}

static void place_on_an_axis(double *x, int dim, uint64_t *seed) {
  memset(x, 0, (size_t)dim * sizeof *x);
  x[dim - 1] = sph_test_random(seed) - 0.5;
}

static void place_in_a_plane(double *x, int dim, uint64_t *seed) {
  place_anywhere(x, dim, seed);
  x[0] = 0.3 - (dim == 3 ? 0.7 : 0.4) * x[1];
}

static void place_at_one_point(double *x, int dim, uint64_t *seed) {
  (void)seed;
  for (int d = 0; d < dim; d++) x[d] = 0.125;
}

static void every_number_of_neighbours_gives_a_value_and_a_rung(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (sph_index n = 0; n <= 40; n += n < 12 ? 1 : 7) check_ladder(dim, n, place_anywhere);
}

static void degenerate_neighbours_give_a_value_and_a_rung(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (sph_index n = 1; n <= 40; n += 13) {
      check_ladder(dim, n, place_on_a_line);
      check_ladder(dim, n, place_on_an_axis);
      check_ladder(dim, n, place_in_a_plane);
      check_ladder(dim, n, place_at_one_point);
    }
}

/* Neighbours on one side only, further and further away: no method may amplify without bound. */
static void rungs_go_down_with_the_distance_from_the_particles(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 2, 0.01, (const int[]){20, 20}, 0.4);
  fill_f(&s, wavy);
  double largest = 0;
  for (sph_index i = 0; i < s.n; i++) largest = fmax(largest, fabs(s.f[i]));
  s.points = 60;
  for (int k = 0; k < s.points; k++) s.at[2 * k] = 0.1, s.at[2 * k + 1] = 0.01 - 0.001 * k;
  for (int k = 0; k < sph_interpolator_count(); k++) {
    const int type = (int)sph_interpolator_at(k);
    set_method(&s, SPH_KERNEL_GAUSSIAN, type);
    evaluate(&s);
    CU_ASSERT_EQUAL(s.rungs[0], type);
    CU_ASSERT_EQUAL(s.rungs[s.points - 1], 0);
    int lower = 0;
    for (int p = 0; p < s.points; p++) {
      if (p > 0) CU_ASSERT(any_step(type, s.rungs[p]) >= any_step(type, s.rungs[p - 1]));
      CU_ASSERT(fabs(s.values[p]) <= (any_lebesgue(s.rungs[p]) + 1e-12) * largest);
      lower += s.rungs[p] && s.rungs[p] != type;
    }
    CU_ASSERT((lower > 0) == (!any_shepard(type) && type != SPH_INTERPOLATOR_NEAREST));
  }
  close_setup(&s);
}

static void instruction_sets_agree(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 3, 0.01, (const int[]){12, 12, 12}, 0.4);
  fill_f(&s, wavy);
  scatter_points(&s, 80, 0.12);
  for (int k = 0; k < sph_interpolator_count(); k++) {
    set_method(&s, SPH_KERNEL_GAUSSIAN, (int)sph_interpolator_at(k));
    double baseline[MAX_POINTS];
    for (int isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
      if (sph_context_set_isa(s.context, (sph_isa)isa) != SPH_OK) continue;
      evaluate(&s);
      if (isa == SPH_ISA_BASELINE) memcpy(baseline, s.values, sizeof baseline);
      for (int p = 0; p < s.points; p++) SPH_TEST_CLOSE(s.values[p], baseline[p], 0, 1e-13);
    }
  }
  close_setup(&s);
}

static void threads_give_the_same_bits(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 3, 0.01, (const int[]){12, 12, 12}, 0.4);
  fill_f(&s, wavy);
  scatter_points(&s, MAX_POINTS, 0.12);
  for (int k = 0; k < sph_interpolator_count(); k++) {
    set_method(&s, SPH_KERNEL_WENDLAND_C2, (int)sph_interpolator_at(k));
    SPH_TEST_OK(s.context, sph_context_set_threads(s.context, 1));
    evaluate(&s);
    double one[MAX_POINTS];
    memcpy(one, s.values, sizeof one);
    if (sph_context_set_threads(s.context, 2) != SPH_OK) continue; /* built without OpenMP */
    evaluate(&s);
    CU_ASSERT(memcmp(one, s.values, sizeof one) == 0);
  }
  close_setup(&s);
}

static void fields_together_are_fields_alone(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 2, 0.01, (const int[]){12, 12}, 0.4);
  fill_f(&s, wavy);
  scatter_points(&s, 20, 0.12);
  const char *const names[] = {SPH_POSITION, "f", SPH_DENSITY, SPH_VELOCITY, "f"};
  enum { COMPONENTS = 7 };
  double together[COMPONENTS * MAX_POINTS];
  for (int k = 0; k < sph_interpolator_count(); k++) {
    set_method(&s, SPH_KERNEL_WENDLAND_C2, (int)sph_interpolator_at(k));
    SPH_TEST_OK(s.context, sph_interpolator_evaluate(s.interpolator, s.particles, s.points, s.at, 5,
                                                     names, together, NULL));
    for (int f = 0, first = 0; f < 5; f++) {
      const int components = f == 0 || f == 3 ? 2 : 1;
      SPH_TEST_OK(s.context, sph_interpolator_evaluate(s.interpolator, s.particles, s.points, s.at,
                                                       1, names + f, s.values, s.rungs));
      for (int p = 0; p < s.points; p++)
        CU_ASSERT(memcmp(together + p * COMPONENTS + first, s.values + p * components,
                         (size_t)components * sizeof(double)) == 0);
      first += components;
    }
  }
  close_setup(&s);
}

static void units_of_length_do_not_matter(void) {
  double reference[30 * 32];
  CU_ASSERT_FATAL(sph_interpolator_count() <= 32);
  for (int unit = 0; unit < 3; unit++) {
    static const double scales[] = {1, 1024, 0x1p-20};
    setup s, metres;
    set_context(&s, NULL);
    set_context(&metres, NULL);
    set_block(&metres, 2, 0.01, (const int[]){12, 12}, 0.4);
    fill_f(&metres, wavy);
    for (int k = 0; k < 2 * metres.n; k++) metres.x[k] *= scales[unit];
    set_particles(&s, 2, 0.01 * scales[unit], metres.n, metres.x);
    SPH_TEST_OK(s.context, sph_particles_write(s.particles, "f", metres.f, s.n));
    for (int k = 0; k < sph_interpolator_count(); k++) {
      scatter_points(&s, 30, 0.12 * scales[unit]);
      set_method(&s, SPH_KERNEL_GAUSSIAN, (int)sph_interpolator_at(k));
      evaluate(&s);
      if (unit == 0) memcpy(reference + 30 * k, s.values, 30 * sizeof(double));
      for (int p = 0; p < 30; p++) SPH_TEST_CLOSE(s.values[p], reference[30 * k + p], 0, 1e-12);
    }
    close_setup(&s);
    close_setup(&metres);
  }
}

static void kernels_far_wider_or_narrower_than_the_spacing_work(void) {
  static const double paper[] = {4, 1, 2};
  for (int dim = 2; dim <= 3; dim++) {
    setup s;
    set_context(&s, NULL);
    set_block(&s, dim, 0.001, (const int[]){12, 12, 12}, 0.4);
    fill_f(&s, linear);
    scatter_points(&s, 12, 0.012);
    sph_interpolator_destroy(&s.interpolator);
    SPH_TEST_OK(s.context,
                sph_kernel_create(s.context, SPH_KERNEL_WENDLAND_C2, dim, 0.25, &s.kernel));
    SPH_TEST_OK(s.context, sph_interpolator_create(s.context, SPH_INTERPOLATOR_IMPROVED_SHEPARD,
                                                   s.kernel, &s.interpolator));
    evaluate(&s); /* support 500 spacings */
    for (int p = 0; p < s.points; p++)
      SPH_TEST_CLOSE(s.values[p],
                     plain_sum(&s, SPH_INTERPOLATOR_IMPROVED_SHEPARD, paper, s.at + p * dim), 1e-12,
                     0);
    close_setup(&s);
  }
  /* Support 1/128 with particles twice the range of fixed point, 256 supports, apart. */
  setup s;
  set_context(&s, NULL);
  set_particles(&s, 2, 10, 5, (const double[]){0, 0, 2, 0, 4, 0, 0, 2, 0, 4});
  for (int i = 0; i < 5; i++) s.f[i] = i + 1;
  SPH_TEST_OK(s.context, sph_particles_write(s.particles, "f", s.f, 5));
  SPH_TEST_OK(s.context,
              sph_kernel_create(s.context, SPH_KERNEL_WENDLAND_C2, 2, 0x1p-8, &s.kernel));
  SPH_TEST_OK(s.context, sph_interpolator_create(s.context, SPH_INTERPOLATOR_NORMALIZED, s.kernel,
                                                 &s.interpolator));
  s.points = 5;
  memcpy(s.at, s.x, 10 * sizeof(double));
  evaluate(&s);
  for (int i = 0; i < 5; i++) SPH_TEST_CLOSE(s.values[i], i + 1, 1e-15, 0);
  close_setup(&s);
}

static void names_find_kinds(void) {
  sph_context *context;
  SPH_TEST_OK(NULL, sph_context_create(&context));
  CU_ASSERT_EQUAL(sph_interpolator_count(), 10);
  for (int k = 0; k < sph_interpolator_count(); k++) {
    sph_interpolator_type type = (sph_interpolator_type)0;
    CU_ASSERT_EQUAL((int)sph_interpolator_at(k), k + 1);
    SPH_TEST_OK(context, sph_interpolator_find(
                             context, sph_interpolator_name(sph_interpolator_at(k)), &type));
    CU_ASSERT_EQUAL(type, sph_interpolator_at(k));
    CU_ASSERT_STRING_NOT_EQUAL(sph_interpolator_summary(type), "unknown");
    CU_ASSERT_STRING_NOT_EQUAL(sph_interpolator_source(type), "unknown");
  }
  CU_ASSERT_EQUAL((int)sph_interpolator_at(-1), 0);
  CU_ASSERT_EQUAL((int)sph_interpolator_at(10), 0);
  CU_ASSERT_STRING_EQUAL(sph_interpolator_name((sph_interpolator_type)11), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_interpolator_summary((sph_interpolator_type)0), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_interpolator_source((sph_interpolator_type)-1), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_interpolator_name((sph_interpolator_type)0), "none");
  sph_interpolator_type type = (sph_interpolator_type)9;
  SPH_TEST_STATUS(context, sph_interpolator_find(context, "mls-linera", &type), SPH_E_NAME,
                  "unknown interpolator \"mls-linera\"; did you mean \"mls-linear\"?");
  SPH_TEST_STATUS(context, sph_interpolator_find(context, "?", &type), SPH_E_NAME,
                  "unknown interpolator \"?\"");
  SPH_TEST_STATUS(context, sph_interpolator_find(context, NULL, &type), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_interpolator_find(context, "normalized", NULL), SPH_E_ARGUMENT,
                  "NULL");
  CU_ASSERT_EQUAL(sph_interpolator_find(NULL, "normalized", &type), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL((int)type, 9);
  sph_context_destroy(&context);
}

static void creation_checks_its_arguments(void) {
  sph_context *context, *other;
  sph_kernel *kernel, *line;
  SPH_TEST_OK(NULL, sph_context_create(&context));
  SPH_TEST_OK(NULL, sph_context_create(&other));
  SPH_TEST_OK(context, sph_kernel_create(context, SPH_KERNEL_GAUSSIAN, 2, 1, &kernel));
  SPH_TEST_OK(context, sph_kernel_create(context, SPH_KERNEL_GAUSSIAN, 1, 1, &line));
  sph_interpolator *i = (sph_interpolator *)context;
  const sph_interpolator_type mls = SPH_INTERPOLATOR_MLS_LINEAR;
  SPH_TEST_STATUS(context, sph_interpolator_create(context, mls, kernel, NULL), SPH_E_ARGUMENT,
                  "out");
  SPH_TEST_STATUS(context, sph_interpolator_create(context, mls, NULL, &i), SPH_E_ARGUMENT,
                  "kernel");
  CU_ASSERT_PTR_NULL(i);
  CU_ASSERT_EQUAL(sph_interpolator_create(NULL, mls, kernel, &i), SPH_E_ARGUMENT);
  SPH_TEST_STATUS(context, sph_interpolator_create(context, (sph_interpolator_type)11, kernel, &i),
                  SPH_E_ARGUMENT, "1 to 10, got 11");
  SPH_TEST_STATUS(context, sph_interpolator_create(context, SPH_INTERPOLATOR_USER, kernel, &i),
                  SPH_E_ARGUMENT, "use sph_interpolator_create_user");
  CU_ASSERT_PTR_NULL(i);
  SPH_TEST_STATUS(context, sph_interpolator_create(context, mls, line, &i), SPH_E_ARGUMENT,
                  "dim of the kernel must be 2 or 3, got 1");
  SPH_TEST_STATUS(other, sph_interpolator_create(other, mls, kernel, &i), SPH_E_ARGUMENT,
                  "another context");
  SPH_TEST_OK(context, sph_interpolator_create(context, mls, kernel, &i));
  CU_ASSERT_EQUAL(sph_interpolator_get_type(i), mls);
  CU_ASSERT_EQUAL(sph_interpolator_get_type(NULL), 0);
  const double bad[][3] = {{0.9, 1, 2}, {17, 1, 2},  {NAN, 1, 2}, {4, 0.01, 2}, {4, 1e7, 2},
                           {4, NAN, 2}, {4, 1, 0.1}, {4, 1, 20},  {4, 1, NAN}};
  const char *const texts[] = {"mu",    "mu",     "mu",     "scale", "scale",
                               "scale", "lambda", "lambda", "lambda"};
  for (int k = 0; k < 9; k++)
    SPH_TEST_STATUS(context, sph_interpolator_set_shepard(i, bad[k][0], bad[k][1], bad[k][2]),
                    SPH_E_ARGUMENT, texts[k]);
  CU_ASSERT_EQUAL(sph_interpolator_set_shepard(NULL, 4, 1, 2), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_interpolator_set_compensation(NULL, true), SPH_E_ARGUMENT);
  SPH_TEST_OK(context, sph_interpolator_set_compensation(i, false));
  /* In any order: the interpolator keeps kernel and context alive. */
  sph_kernel_destroy(&kernel);
  sph_kernel_destroy(&line);
  sph_context_destroy(&context);
  sph_context_destroy(&other);
  sph_interpolator_destroy(&i);
  CU_ASSERT_PTR_NULL(i);
  sph_interpolator_destroy(&i);
  sph_interpolator_destroy(NULL);
}

static void evaluation_checks_its_arguments(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 2, 0.01, (const int[]){6, 6}, 0.4);
  fill_f(&s, linear);
  scatter_points(&s, 5, 0.06);
  set_method(&s, SPH_KERNEL_GAUSSIAN, SPH_INTERPOLATOR_NORMALIZED);
  const sph_interpolator *i = s.interpolator;
  for (int k = 0; k < 5; k++) s.values[k] = -7, s.rungs[k] = -7;
  const char *const unknown[] = {"pressur"}, *const null[] = {NULL},
                    *const velocity[] = {"f", "velocity"};
#define FAILS(code, text, ...) \
  SPH_TEST_STATUS(s.context, sph_interpolator_evaluate(__VA_ARGS__), code, text)
  CU_ASSERT_EQUAL(
      sph_interpolator_evaluate(NULL, s.particles, 5, s.at, 1, field_f, s.values, s.rungs),
      SPH_E_ARGUMENT);
  FAILS(SPH_E_ARGUMENT, "source", i, NULL, 5, s.at, 1, field_f, s.values, s.rungs);
  FAILS(SPH_E_ARGUMENT, "points must be", i, s.particles, -1, s.at, 1, field_f, s.values, s.rungs);
  FAILS(SPH_E_ARGUMENT, "points must be", i, s.particles, INT64_MAX, s.at, 1, field_f, s.values,
        s.rungs);
  FAILS(SPH_E_ARGUMENT, "at must not be NULL", i, s.particles, 5, NULL, 1, field_f, s.values,
        s.rungs);
  FAILS(SPH_E_ARGUMENT, "values must not be NULL", i, s.particles, 5, s.at, 1, field_f, NULL,
        s.rungs);
  FAILS(SPH_E_ARGUMENT, "fields must be >= 1, got 0", i, s.particles, 5, s.at, 0, field_f, s.values,
        s.rungs);
  FAILS(SPH_E_ARGUMENT, "names must not", i, s.particles, 5, s.at, 1, NULL, s.values, s.rungs);
  FAILS(SPH_E_ARGUMENT, "names[0]", i, s.particles, 5, s.at, 1, null, s.values, s.rungs);
  FAILS(SPH_E_NAME, "did you mean \"pressure\"?", i, s.particles, 5, s.at, 1, unknown, s.values,
        s.rungs);
  s.at[7] = NAN;
  FAILS(SPH_E_ARGUMENT, "point 3 must be finite", i, s.particles, 5, s.at, 1, field_f, s.values,
        s.rungs);
  s.at[7] = 0.01;
  const double slopes[] = {0, INFINITY};
#define FAILS_COMPENSATED(text, ...)                                                             \
  SPH_TEST_STATUS(s.context, sph_interpolator_evaluate_compensated(__VA_ARGS__), SPH_E_ARGUMENT, \
                  text)
  CU_ASSERT_EQUAL(sph_interpolator_evaluate_compensated(NULL, s.particles, 5, s.at, "f", any_slope,
                                                        s.values, s.rungs),
                  SPH_E_ARGUMENT);
  FAILS_COMPENSATED("name and gradient", i, s.particles, 5, s.at, NULL, any_slope, s.values,
                    s.rungs);
  FAILS_COMPENSATED("name and gradient", i, s.particles, 5, s.at, "f", NULL, s.values, s.rungs);
  FAILS_COMPENSATED("gradient must be finite", i, s.particles, 5, s.at, "f", slopes, s.values,
                    s.rungs);
  FAILS_COMPENSATED("\"velocity\" has 2 components", i, s.particles, 5, s.at, "velocity", any_slope,
                    s.values, s.rungs);
  for (int k = 0; k < 5; k++) CU_ASSERT(s.values[k] == -7 && s.rungs[k] == -7);
  SPH_TEST_OK(s.context,
              sph_interpolator_evaluate(i, s.particles, 0, NULL, 2, velocity, NULL, NULL));
  close_setup(&s);
}

static void evaluation_checks_the_particles(void) {
  setup s;
  set_context(&s, NULL);
  set_block(&s, 2, 0.01, (const int[]){6, 6}, 0.4);
  fill_f(&s, linear);
  scatter_points(&s, 5, 0.06);
  set_method(&s, SPH_KERNEL_GAUSSIAN, SPH_INTERPOLATOR_NORMALIZED);
  const sph_interpolator *i = s.interpolator;
  for (int k = 0; k < 5; k++) s.values[k] = -7, s.rungs[k] = -7;
  sph_context *context;
  sph_particles *empty, *deep, *other;
  SPH_TEST_OK(NULL, sph_context_create(&context));
  SPH_TEST_OK(s.context, sph_particles_create(s.context, 2, 1, &empty));
  SPH_TEST_OK(s.context, sph_particles_create(s.context, 3, 1, &deep));
  SPH_TEST_OK(context, sph_particles_create(context, 2, 1, &other));
  FAILS(SPH_E_ARGUMENT, "empty", i, empty, 5, s.at, 1, field_f, s.values, s.rungs);
  FAILS(SPH_E_ARGUMENT, "are 3D; create the kernel with dim = 3", i, deep, 5, s.at, 1, field_f,
        s.values, s.rungs);
  FAILS(SPH_E_ARGUMENT, "another context", i, other, 5, s.at, 1, field_f, s.values, s.rungs);
  s.x[5] = 1e9;
  SPH_TEST_OK(s.context, sph_particles_write(s.particles, SPH_POSITION, s.x, 2 * (int64_t)s.n));
  FAILS(SPH_E_ARGUMENT, "too far for a support", i, s.particles, 5, s.at, 1, field_f, s.values,
        s.rungs);
  for (int k = 0; k < 5; k++) CU_ASSERT(s.values[k] == -7 && s.rungs[k] == -7);
  sph_particles_destroy(&empty);
  sph_particles_destroy(&deep);
  sph_particles_destroy(&other);
  sph_context_destroy(&context);
  close_setup(&s);
}

/* An allocator that fails at one call and counts what is alive. */
typedef struct counting {
  int64_t alive, calls, fail_at;
} counting;

static void *counting_allocate(size_t bytes, void *user) {
  counting *c = user;
  if (c->calls++ == c->fail_at) return NULL;
  c->alive++;
  return malloc(bytes);
}

static void counting_release(void *memory, void *user) {
  counting *c = user;
  if (memory) c->alive--;
  free(memory);
}

/* One call, with gradients where the method has them. */
static sph_status evaluate_all(setup *s, double *gradients) {
  const int type = sph_interpolator_get_type(s->interpolator);
  return any_mls(type) || any_sfdi(type)
             ? sph_interpolator_evaluate_gradient(s->interpolator, s->particles, s->points, s->at,
                                                  1, field_f, s->values, gradients, s->rungs)
             : sph_interpolator_evaluate(s->interpolator, s->particles, s->points, s->at, 1,
                                         field_f, s->values, s->rungs);
}

static void running_out_of_memory_leaves_nothing_behind(void) {
  counting c = {0, 0, -1};
  const sph_allocator allocator = {counting_allocate, counting_release, &c};
  setup s;
  set_context(&s, &allocator);
  set_block(&s, 2, 0.01, (const int[]){6, 6}, 0.4);
  fill_f(&s, linear);
  scatter_points(&s, 5, 0.06);
  for (int k = 0; k < sph_interpolator_count(); k++) {
    c.fail_at = -1;
    set_method(&s, SPH_KERNEL_GAUSSIAN, (int)sph_interpolator_at(k));
    sph_interpolator *made;
    c.calls = c.fail_at = 0;
    SPH_TEST_STATUS(
        s.context, sph_interpolator_create(s.context, SPH_INTERPOLATOR_NORMALIZED, s.kernel, &made),
        SPH_E_MEMORY, "memory");
    CU_ASSERT_PTR_NULL(made);
    c.calls = c.fail_at = 0;
    SPH_TEST_STATUS(s.context,
                    sph_interpolator_create_user(s.context, s.kernel, any_weights, NULL, &made),
                    SPH_E_MEMORY, "memory");
    CU_ASSERT_PTR_NULL(made);
    const int64_t alive = c.alive;
    sph_status status = SPH_E_MEMORY;
    int failures = 0;
    for (; status != SPH_OK && failures < 200; failures++) {
      double gradients[10];
      for (int p = 0; p < 5; p++) s.values[p] = -7, s.rungs[p] = -7;
      for (int p = 0; p < 10; p++) gradients[p] = -7;
      c.calls = 0;
      c.fail_at = failures;
      status = evaluate_all(&s, gradients);
      CU_ASSERT_EQUAL(c.alive, alive);
      if (status == SPH_OK) break;
      CU_ASSERT_EQUAL(status, SPH_E_MEMORY);
      for (int p = 0; p < 5; p++) CU_ASSERT(s.values[p] == -7 && s.rungs[p] == -7);
      for (int p = 0; p < 10; p++) CU_ASSERT(gradients[p] == -7);
    }
    CU_ASSERT(status == SPH_OK && failures > 10);
  }
  close_setup(&s);
  CU_ASSERT_EQUAL(c.alive, 0);
}

SPH_TEST_MAIN("interpolator", {"names find kinds and suggest", names_find_kinds},
              {"creation and settings check their arguments", creation_checks_its_arguments},
              {"constants are exact for every kernel and interpolator", constants_are_exact},
              {"linear fields are exact for MLS and SFDI, and for all with compensation",
               linear_fields_are_exact},
              {"plain sums over all particles agree", plain_sums_agree},
              {"rms error of a wave has order 2 for MLS and 1 for the others",
               convergence_has_the_claimed_order},
              {"errors on a lattice near a wall are the published ones",
               lattice_near_a_wall_has_known_errors},
              {"Shepard and normalized stay within the range of their neighbours",
               shepard_stays_within_the_range_of_its_neighbours},
              {"Shepard returns the value of a coincident particle",
               shepard_returns_the_value_of_a_coincident_particle},
              {"every number of neighbours gives a value and a rung",
               every_number_of_neighbours_gives_a_value_and_a_rung},
              {"degenerate neighbours give a value and a rung",
               degenerate_neighbours_give_a_value_and_a_rung},
              {"rungs go down with the distance from the particles",
               rungs_go_down_with_the_distance_from_the_particles},
              {"instruction sets agree to rounding", instruction_sets_agree},
              {"threads give the same bits", threads_give_the_same_bits},
              {"fields together are the same bits as alone", fields_together_are_fields_alone},
              {"units of length do not matter", units_of_length_do_not_matter},
              {"kernels far wider or narrower than the spacing work",
               kernels_far_wider_or_narrower_than_the_spacing_work},
              {"evaluation checks its arguments", evaluation_checks_its_arguments},
              {"evaluation checks the particles", evaluation_checks_the_particles},
              {"running out of memory leaves nothing behind",
               running_out_of_memory_leaves_nothing_behind})
