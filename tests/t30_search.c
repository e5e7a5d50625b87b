/* Neighbour search: the grid and the shipped brute force against a third one written here. */
#include "sph_test.h"

enum { POINTS = 2385 };

/* Counts what it hands out, and fails when told to. */
typedef struct counter {
  int64_t live, bytes, calls, fail_at; /* fail_at: number of the call that fails, 0 for none */
} counter;

static void *count_allocate(size_t bytes, void *user) {
  counter *c = user;
  if (++c->calls == c->fail_at) return NULL;
  size_t *memory = malloc(bytes + 64);
  if (!memory) return NULL;
  memory[0] = bytes;
  c->live++;
  c->bytes += (int64_t)bytes;
  return (char *)memory + 64;
}

static void count_release(void *memory, void *user) {
  counter *c = user;
  if (!memory) return;
  size_t *block = (size_t *)(void *)((char *)memory - 64);
  c->live--;
  c->bytes -= (int64_t)block[0];
  free(block);
}

/* A set with a search over it, and what the oracle needs. */
typedef struct scene {
  counter counted;
  sph_context *context;
  sph_particles *particles;
  sph_search *search;
  int dim, n;
  double radius;
  bool periodic[3];
  double lo[3], hi[3];
  double *x;
} scene;

static void scene_open(scene *s, int dim, int n, const double *x, double radius) {
  memset(s, 0, sizeof *s);
  const sph_allocator allocator = {count_allocate, count_release, &s->counted};
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &s->context) == SPH_OK);
  s->dim = dim;
  s->n = n;
  s->radius = radius;
  s->x = malloc(sizeof(double) * (size_t)(n * dim + 1));
  CU_ASSERT_FATAL(s->x != NULL);
  memcpy(s->x, x, sizeof(double) * (size_t)(n * dim));
  /* Far apart first: particles may be written anywhere, but not added on top of one another. */
  double *start = calloc((size_t)(n * dim + 1), sizeof *start);
  CU_ASSERT_FATAL(start != NULL);
  for (int i = 0; i < n; i++) start[i * dim] = i;
  SPH_TEST_OK(s->context, sph_particles_create(s->context, dim, 1, &s->particles));
  SPH_TEST_OK(s->context, sph_particles_set_name(s->particles, "water"));
  if (n) SPH_TEST_OK(s->context, sph_particles_add(s->particles, n, start, 1000, NULL));
  if (n)
    SPH_TEST_OK(s->context, sph_particles_write(s->particles, SPH_POSITION, x, (int64_t)n * dim));
  free(start);
  SPH_TEST_OK(s->context, sph_search_create(s->context, s->particles, radius, &s->search));
}

static void scene_periodic(scene *s, int axis, double lo, double hi) {
  s->periodic[axis] = true;
  s->lo[axis] = lo;
  s->hi[axis] = hi;
  SPH_TEST_OK(s->context, sph_search_set_periodic(s->search, axis, lo, hi));
}

static void scene_close(scene *s) {
  sph_search_destroy(&s->search);
  sph_particles_destroy(&s->particles);
  sph_context_destroy(&s->context);
  CU_ASSERT(s->counted.live == 0);
  CU_ASSERT(s->counted.bytes == 0);
  free(s->x);
}

typedef struct near {
  double distance;
  int index;
} near;

static int compare_near(const void *a, const void *b) {
  const near *k = a, *l = b;
  if (k->distance != l->distance) return k->distance < l->distance ? -1 : 1;
  return (k->index > l->index) - (k->index < l->index);
}

/* Distance along one axis over all images that can be the nearest. */
static double oracle_difference(const scene *s, int d, double a, double b) {
  double least = fabs(a - b);
  if (!s->periodic[d]) return least;
  const double length = s->hi[d] - s->lo[d];
  for (int image = -2; image <= 2; image++) least = fmin(least, fabs(a - b + image * length));
  return least;
}

static int oracle(const scene *s, const double *x, double radius, int without, near *found) {
  int count = 0;
  for (int j = 0; j < s->n; j++) {
    double sum = 0;
    for (int d = 0; d < s->dim; d++) {
      const double dx = oracle_difference(s, d, x[d], s->x[j * s->dim + d]);
      sum += dx * dx;
    }
    if (sqrt(sum) < radius && j != without) found[count++] = (near){sqrt(sum), j};
  }
  qsort(found, (size_t)count, sizeof *found, compare_near);
  return count;
}

/* Number of places where a query's answer is not the oracle's. */
static int differences(const near *expected, int64_t expected_count, const sph_index *index,
                       const double *distance, int64_t count) {
  int wrong = count != expected_count;
  for (int64_t k = 0; k < count && k < expected_count; k++)
    wrong += index[k] != expected[k].index ||
             !(fabs(distance[k] - expected[k].distance) <= 1e-14 * (1 + expected[k].distance));
  return wrong;
}

typedef struct answers {
  near *expected;
  sph_index *index;
  double *distance;
} answers;

static answers answers_open(int n) {
  const answers a = {malloc(sizeof(near) * (size_t)(n + 1)),
                     malloc(sizeof(sph_index) * (size_t)(n + 1)),
                     malloc(sizeof(double) * (size_t)(n + 1))};
  CU_ASSERT_FATAL(a.expected && a.index && a.distance);
  return a;
}

static void answers_close(answers *a) {
  free(a->expected);
  free(a->index);
  free(a->distance);
}

/* Both methods against the oracle: near every stride-th particle, near points, nearest, pairs. */
static void check_scene(scene *s, int stride, int points, const double *box_lo,
                        const double *box_hi) {
  answers a = answers_open(s->n);
  for (int method = 0; method < 2; method++) {
    SPH_TEST_OK(s->context, sph_search_set_method(s->search, (sph_search_method)method));
    SPH_TEST_OK(s->context, sph_search_update(s->search));
    int wrong = 0;
    int64_t count, pairs;
    for (int i = 0; i < s->n; i += stride) {
      const int expected = oracle(s, s->x + i * s->dim, s->radius, i, a.expected);
      SPH_TEST_OK(s->context,
                  sph_search_find_near_particle(s->search, i, s->n, a.index, a.distance, &count));
      wrong += differences(a.expected, expected, a.index, a.distance, count);
    }
    uint64_t state = 99;
    for (int k = 0; k < points; k++) {
      double x[3] = {0, 0, 0};
      for (int d = 0; d < s->dim; d++) {
        const double size = box_hi[d] - box_lo[d];
        x[d] = box_lo[d] - 0.3 * size + 1.6 * size * sph_test_random(&state);
      }
      int expected = oracle(s, x, s->radius, -1, a.expected);
      SPH_TEST_OK(s->context,
                  sph_search_find_near_point(s->search, x, s->n, a.index, a.distance, &count));
      wrong += differences(a.expected, expected, a.index, a.distance, count);
      const int wanted = k % 5 == 0   ? 1
                         : k % 5 == 1 ? 4
                         : k % 5 == 2 ? 33
                         : k % 5 == 3 ? 200
                                      : s->n + 7;
      expected = oracle(s, x, HUGE_VAL, -1, a.expected);
      SPH_TEST_OK(s->context,
                  sph_search_find_nearest(s->search, x, wanted, a.index, a.distance, &count));
      wrong += differences(a.expected, wanted < expected ? wanted : expected, a.index, a.distance,
                           count);
    }
    CU_ASSERT_EQUAL(wrong, 0);
    int64_t expected_pairs = 0;
    if (method == 0 && stride == 1)
      for (int i = 0; i < s->n; i++)
        expected_pairs += oracle(s, s->x + i * s->dim, s->radius, i, a.expected);
    SPH_TEST_OK(s->context, sph_search_count_pairs(s->search, &pairs));
    if (method == 0 && stride == 1) CU_ASSERT_EQUAL(2 * pairs, expected_pairs);
    int64_t pairs_again = 0;
    SPH_TEST_OK(s->context, sph_search_set_method(s->search, (sph_search_method)(1 - method)));
    SPH_TEST_OK(s->context, sph_search_update(s->search));
    SPH_TEST_OK(s->context, sph_search_count_pairs(s->search, &pairs_again));
    CU_ASSERT_EQUAL(pairs, pairs_again);
  }
  answers_close(&a);
}

static void random_points(int dim, int n, double lo, double hi, uint64_t seed, double *x) {
  for (int k = 0; k < n * dim; k++) x[k] = lo + (hi - lo) * sph_test_random(&seed);
}

static const double unit_lo[3] = {0, 0, 0}, unit_hi[3] = {1, 1, 1};

static void test_random(void) {
  static double x[3 * POINTS];
  for (int dim = 2; dim <= 3; dim++) {
    /* Some points lie outside the box: where it is periodic, they are images of points inside. */
    random_points(dim, POINTS, -0.125, 1.125, 5, x);
    for (int mask = 0; mask < 1 << dim; mask++) {
      scene s;
      scene_open(&s, dim, POINTS, x, dim == 2 ? 0.06 : 0.13);
      for (int d = 0; d < dim; d++)
        if (mask >> d & 1) scene_periodic(&s, d, 0, 1);
      check_scene(&s, mask == (1 << dim) - 1 ? 1 : 31, 20, unit_lo, unit_hi);
      scene_close(&s);
    }
  }
}

static void test_small_boxes(void) {
  double x[3 * 150];
  const double sizes[] = {1, 1.2, 1.49, 1.51}; /* 2 or 3 columns around: 2 radii are 1 */
  for (int dim = 2; dim <= 3; dim++)
    for (int size = 0; size < 4; size++) {
      scene s;
      random_points(dim, 150, 0, sizes[size], 7, x);
      scene_open(&s, dim, 150, x, 0.5);
      for (int d = 0; d < dim; d++) scene_periodic(&s, d, 0, sizes[size]);
      check_scene(&s, 1, 30, unit_lo, unit_hi);
      scene_close(&s);
    }
}

static void test_clusters_and_lattices(void) {
  static double x[3 * 1000];
  for (int dim = 2; dim <= 3; dim++) {
    scene s;
    /* Three clumps of very different density, with points on top of one another. */
    uint64_t state = 3;
    for (int i = 0; i < 1000; i++)
      for (int d = 0; d < dim; d++)
        x[i * dim + d] = (i % 3 == d ? 0.9 : 0.1) +
                         (i % 10 == 0 ? 0 : pow(0.01, 1 + i % 3) * sph_test_random(&state));
    scene_open(&s, dim, 1000, x, 0.004);
    check_scene(&s, 9, 20, unit_lo, unit_hi);
    scene_close(&s);
    /* A lattice with a radius of exactly 2 spacings: equal distances everywhere, and the points at
     * the radius itself are not near. The points are on the edges of columns too. */
    const int side = dim == 2 ? 24 : 9;
    int n = 0;
    for (int k = 0; k < (dim == 2 ? side * side : side * side * side); k++, n++)
      for (int d = 0, rest = k; d < dim; d++, rest /= side) x[n * dim + d] = rest % side / 16.0;
    scene_open(&s, dim, n, x, 0.125);
    check_scene(&s, 1, 20, unit_lo, unit_hi);
    sph_index index[40];
    double distance[40];
    int64_t count;
    const int middle =
        dim == 2 ? side * (side / 2) + side / 2 : (side * side + side + 1) * (side / 2);
    SPH_TEST_OK(s.context,
                sph_search_find_near_particle(s.search, middle, 40, index, distance, &count));
    CU_ASSERT_EQUAL(count, dim == 2 ? 8 : 26);
    scene_close(&s);
    scene_open(&s, dim, n, x, 0.125);
    for (int d = 0; d < dim; d++) scene_periodic(&s, d, 0, side / 16.0);
    check_scene(&s, 1, 20, unit_lo, unit_hi);
    int64_t pairs;
    SPH_TEST_OK(s.context, sph_search_count_pairs(s.search, &pairs));
    CU_ASSERT_EQUAL(pairs, (int64_t)n * (dim == 2 ? 8 : 26) / 2);
    scene_close(&s);
  }
}

static void test_outliers(void) {
  static double x[3 * POINTS];
  for (int dim = 2; dim <= 3; dim++) {
    int64_t bytes[2];
    for (int far = 0; far < 2; far++) {
      random_points(dim, POINTS, 0, 1, 11, x);
      for (int i = 0; far && i < POINTS; i += 397) /* alone, and one pair */
        for (int d = 0; d < dim; d++) x[i * dim + d] = 1e6 * (d + 1) * (i % 2 ? 1 : -1) + i;
      if (far)
        for (int d = 0; d < dim; d++) x[397 * dim + d] = x[d] + 0.03;
      scene s;
      scene_open(&s, dim, POINTS, x, 0.1);
      const int64_t before = s.counted.bytes;
      SPH_TEST_OK(s.context, sph_search_update(s.search));
      bytes[far] = s.counted.bytes - before;
      check_scene(&s, 13, 10, unit_lo, unit_hi);
      int64_t count;
      sph_index index = -1;
      double distance;
      SPH_TEST_OK(s.context,
                  sph_search_find_near_particle(s.search, 0, 1, &index, &distance, &count));
      if (far) CU_ASSERT(count == 1 && index == 397);
      scene_close(&s);
    }
    SPH_TEST_BELOW((double)bytes[1], 1.05 * (double)bytes[0]);
    SPH_TEST_BELOW((double)bytes[1], 200.0 * POINTS);
  }
}

static void test_distant_origin(void) {
  static double x[3 * 500];
  for (int dim = 2; dim <= 3; dim++) {
    const double lo[3] = {4e8, -7e8, 1e8}, hi[3] = {4e8 + 1, -7e8 + 1, 1e8 + 1};
    uint64_t state = 21;
    for (int k = 0; k < 500 * dim; k++)
      x[k] = lo[k % dim] + 0x1p-20 * floor(0x1p20 * sph_test_random(&state));
    scene s;
    scene_open(&s, dim, 500, x, 0.2);
    check_scene(&s, 1, 20, lo, hi);
    scene_close(&s);
    /* Coordinates so large that a radius is a rounding error. */
    for (int k = 0; k < 60 * dim; k++) x[k] = 1e15 + floor(3 * sph_test_random(&state));
    scene_open(&s, dim, 60, x, 0.0625);
    check_scene(&s, 1, 0, lo, hi);
    scene_close(&s);
  }
}

static void test_room(void) {
  static double x[2 * 300];
  random_points(2, 300, 0, 1, 17, x);
  scene s;
  scene_open(&s, 2, 300, x, 0.3);
  SPH_TEST_OK(s.context, sph_search_update(s.search));
  answers a = answers_open(300);
  const double point[2] = {0.5, 0.4};
  const int expected = oracle(&s, point, 0.3, -1, a.expected);
  CU_ASSERT(expected > 20);
  for (int room = 0; room <= expected + 1; room++) {
    for (int k = 0; k <= 300; k++) {
      a.index[k] = -7;
      a.distance[k] = -7;
    }
    int64_t count = 0;
    SPH_TEST_OK(s.context, sph_search_find_near_point(s.search, point, room, room ? a.index : NULL,
                                                      room ? a.distance : NULL, &count));
    CU_ASSERT_EQUAL(count, expected);
    const int written = room < expected ? room : expected;
    CU_ASSERT(differences(a.expected, written, a.index, a.distance, written) == 0);
    CU_ASSERT(a.index[written] == -7 && a.distance[written] == -7);
  }
  int64_t found = -1;
  SPH_TEST_OK(s.context, sph_search_find_nearest(s.search, point, 0, NULL, NULL, &found));
  CU_ASSERT_EQUAL(found, 0);
  SPH_TEST_OK(s.context, sph_search_find_nearest(s.search, point, 5, a.index, a.distance, &found));
  CU_ASSERT_EQUAL(found, 5);
  CU_ASSERT(differences(a.expected, 5, a.index, a.distance, 5) == 0);
  answers_close(&a);
  scene_close(&s);
}

static void test_insertion_order(void) {
  static double x[3 * POINTS], shuffled[3 * POINTS];
  int place[POINTS];
  random_points(3, POINTS, 0, 1, 31, x);
  uint64_t state = 32;
  for (int i = 0; i < POINTS; i++) {
    const int k = (int)((i + 1) * sph_test_random(&state));
    place[i] = place[k];
    place[k] = i;
  }
  for (int i = 0; i < POINTS; i++) memcpy(shuffled + 3 * i, x + 3 * place[i], 3 * sizeof(double));
  scene s, t;
  scene_open(&s, 3, POINTS, x, 0.12);
  scene_open(&t, 3, POINTS, shuffled, 0.12);
  SPH_TEST_OK(s.context, sph_search_update(s.search));
  SPH_TEST_OK(t.context, sph_search_update(t.search));
  answers a = answers_open(POINTS), b = answers_open(POINTS);
  int wrong = 0;
  for (int i = 0; i < POINTS; i++) {
    int64_t count = 0, other = 0;
    SPH_TEST_OK(s.context, sph_search_find_near_particle(s.search, place[i], POINTS, a.index,
                                                         a.distance, &count));
    SPH_TEST_OK(t.context,
                sph_search_find_near_particle(t.search, i, POINTS, b.index, b.distance, &other));
    wrong += count != other || memcmp(a.distance, b.distance, (size_t)count * sizeof(double)) != 0;
    for (int64_t k = 0; k < count; k++) wrong += place[b.index[k]] != a.index[k];
  }
  CU_ASSERT_EQUAL(wrong, 0);
  answers_close(&a);
  answers_close(&b);
  scene_close(&s);
  scene_close(&t);
}

static void test_threads(void) {
  static double x[3 * POINTS];
  random_points(3, POINTS, 0, 1, 41, x);
  scene s;
  scene_open(&s, 3, POINTS, x, 0.2);
  int64_t pairs[2] = {0, 0};
  for (int k = 0; k < 2; k++) {
    const sph_status status = sph_context_set_threads(s.context, k + 1);
    if (status == SPH_E_UNAVAILABLE) {
      scene_close(&s);
      return;
    }
    CU_ASSERT(status == SPH_OK);
    SPH_TEST_OK(s.context, sph_search_update(s.search));
    SPH_TEST_OK(s.context, sph_search_count_pairs(s.search, &pairs[k]));
  }
  CU_ASSERT(pairs[0] == pairs[1] && pairs[0] > POINTS);
  scene_close(&s);
}

static void test_stale(void) {
  double x[2 * 20];
  random_points(2, 20, 0, 1, 51, x);
  scene s;
  scene_open(&s, 2, 20, x, 0.4);
  sph_index index[20];
  double distance[20];
  int64_t count = -3;
#define EVERY_QUERY_IS_STALE(text)                                                               \
  do {                                                                                           \
    SPH_TEST_STATUS(s.context,                                                                   \
                    sph_search_find_near_point(s.search, x, 20, index, distance, &count),        \
                    SPH_E_STALE, text);                                                          \
    SPH_TEST_STATUS(s.context,                                                                   \
                    sph_search_find_near_particle(s.search, 0, 20, index, distance, &count),     \
                    SPH_E_STALE, text);                                                          \
    SPH_TEST_STATUS(s.context, sph_search_find_nearest(s.search, x, 3, index, distance, &count), \
                    SPH_E_STALE, text);                                                          \
    SPH_TEST_STATUS(s.context, sph_search_count_pairs(s.search, &count), SPH_E_STALE, text);     \
    CU_ASSERT_EQUAL(count, -3);                                                                  \
  } while (0)
  EVERY_QUERY_IS_STALE("search of particles \"water\": not built yet; call sph_search_update()");
  SPH_TEST_OK(s.context, sph_search_update(s.search));
  SPH_TEST_OK(s.context, sph_search_count_pairs(s.search, &count));
  count = -3;
  const long long built = sph_particles_revision(s.particles);
  const int64_t removed = 4;
  char text[128];
  for (int change = 0; change < 3; change++) {
    const double extra[2] = {5, 5};
    if (change == 0) SPH_TEST_OK(s.context, sph_particles_write(s.particles, SPH_POSITION, x, 40));
    if (change == 1) SPH_TEST_OK(s.context, sph_particles_remove(s.particles, 1, &removed));
    if (change == 2) SPH_TEST_OK(s.context, sph_particles_add(s.particles, 1, extra, 1000, NULL));
    snprintf(text, sizeof text,
             "built at revision %lld, particles at %lld; call sph_search_update()", built,
             (long long)sph_particles_revision(s.particles));
    EVERY_QUERY_IS_STALE(text);
  }
  SPH_TEST_OK(s.context, sph_search_update(s.search));
  SPH_TEST_OK(s.context, sph_search_find_nearest(s.search, x, 30, index, distance, &count));
  CU_ASSERT_EQUAL(count, 20);
  scene_close(&s);
}

static void test_settings_wait_for_update(void) {
  const double x[4] = {0.05, 0.5, 0.95, 0.5};
  scene s;
  scene_open(&s, 2, 2, x, 0.2);
  int64_t pairs = -1;
  SPH_TEST_OK(s.context, sph_search_update(s.search));
  SPH_TEST_OK(s.context, sph_search_set_periodic(s.search, 0, 0, 1));
  SPH_TEST_OK(s.context, sph_search_count_pairs(s.search, &pairs));
  CU_ASSERT_EQUAL(pairs, 0);
  SPH_TEST_OK(s.context, sph_search_update(s.search));
  SPH_TEST_OK(s.context, sph_search_count_pairs(s.search, &pairs));
  CU_ASSERT_EQUAL(pairs, 1);
  scene_close(&s);
}

static void test_few_particles(void) {
  const double x[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5};
  for (int n = 0; n <= 2; n++) {
    scene s;
    scene_open(&s, 3, n, x, 0.2);
    for (int method = 0; method < 2; method++) {
      SPH_TEST_OK(s.context, sph_search_set_method(s.search, (sph_search_method)method));
      SPH_TEST_OK(s.context, sph_search_update(s.search));
      int64_t count = -1, pairs = -1;
      sph_index index[3];
      double distance[3];
      SPH_TEST_OK(s.context, sph_search_find_near_point(s.search, x, 3, index, distance, &count));
      CU_ASSERT_EQUAL(count, n);
      SPH_TEST_OK(s.context, sph_search_find_nearest(s.search, x, 3, index, distance, &count));
      CU_ASSERT_EQUAL(count, n);
      const double far[3] = {1e100, -1e100, 0};
      SPH_TEST_OK(s.context, sph_search_find_nearest(s.search, far, 3, index, distance, &count));
      CU_ASSERT_EQUAL(count, n);
      SPH_TEST_OK(s.context, sph_search_find_near_point(s.search, far, 0, NULL, NULL, &count));
      CU_ASSERT_EQUAL(count, 0);
      SPH_TEST_OK(s.context, sph_search_count_pairs(s.search, &pairs));
      CU_ASSERT_EQUAL(pairs, n == 2);
    }
    scene_close(&s);
  }
}

static void test_setting_errors(void) {
  double x[2 * 20];
  random_points(2, 20, 0, 1, 61, x);
  scene s;
  scene_open(&s, 2, 20, x, 0.25);
  sph_context *c = s.context;
  sph_search *none = (sph_search *)(void *)&s;
  SPH_TEST_STATUS(c, sph_search_create(c, s.particles, 1, NULL), SPH_E_ARGUMENT,
                  "out must not be NULL");
  CU_ASSERT(sph_search_create(NULL, s.particles, 1, &none) == SPH_E_ARGUMENT && !none);
  SPH_TEST_STATUS(c, sph_search_create(c, NULL, 1, &none), SPH_E_ARGUMENT,
                  "particles must not be NULL");
  const double radii[] = {0, -1, NAN, INFINITY, 1e-101, 1e101};
  for (int k = 0; k < 6; k++) {
    none = (sph_search *)(void *)&s;
    SPH_TEST_STATUS(c, sph_search_create(c, s.particles, radii[k], &none), SPH_E_ARGUMENT,
                    "search of particles \"water\": radius must be > 0 m");
    CU_ASSERT(!none);
  }
  sph_context *other = NULL;
  CU_ASSERT_FATAL(sph_context_create(&other) == SPH_OK);
  SPH_TEST_STATUS(other, sph_search_create(other, s.particles, 1, &none), SPH_E_ARGUMENT,
                  "belong to another context");
  sph_context_destroy(&other);

  CU_ASSERT(sph_search_set_method(NULL, SPH_SEARCH_CELL_GRID) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_search_set_method(s.search, (sph_search_method)2), SPH_E_ARGUMENT,
                  "method must be one of sph_search_method, got 2");
  CU_ASSERT(sph_search_set_periodic(NULL, 0, 0, 1) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_search_set_periodic(s.search, -1, 0, 1), SPH_E_ARGUMENT,
                  "axis must be 0 to 1, got -1");
  SPH_TEST_STATUS(c, sph_search_set_periodic(s.search, 2, 0, 1), SPH_E_ARGUMENT,
                  "axis must be 0 to 1, got 2");
  const double bounds[][2] = {{1, 1}, {1, 0}, {NAN, 1}, {0, NAN}, {-INFINITY, 1}, {0, INFINITY}};
  for (int k = 0; k < 6; k++)
    SPH_TEST_STATUS(c, sph_search_set_periodic(s.search, 0, bounds[k][0], bounds[k][1]),
                    SPH_E_ARGUMENT, "needs finite lo < hi");
  SPH_TEST_STATUS(
      c, sph_search_set_periodic(s.search, 1, 0, 0.499), SPH_E_ARGUMENT,
      "support larger than half the periodic box along axis 1: radius 0.25 m, box 0.499 m");
  sph_search_destroy(NULL);
  none = NULL;
  sph_search_destroy(&none);
  scene_close(&s);
}

static void test_query_errors(void) {
  double x[2 * 20];
  random_points(2, 20, 0, 1, 61, x);
  scene s;
  scene_open(&s, 2, 20, x, 0.25);
  sph_context *c = s.context;
  CU_ASSERT(sph_search_update(NULL) == SPH_E_ARGUMENT);
  SPH_TEST_OK(c, sph_search_update(s.search));
  int64_t pairs = 0, pairs_after = 0;
  SPH_TEST_OK(c, sph_search_count_pairs(s.search, &pairs));

  sph_index index[2] = {-7, -7};
  double distance[2] = {-7, -7};
  int64_t count = -7;
  CU_ASSERT(sph_search_find_near_point(NULL, x, 2, index, distance, &count) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_search_find_near_particle(NULL, 0, 2, index, distance, &count) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_search_find_nearest(NULL, x, 2, index, distance, &count) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_search_count_pairs(NULL, &count) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(c, sph_search_count_pairs(s.search, NULL), SPH_E_ARGUMENT,
                  "pairs must not be NULL");
  const double bad[3][2] = {{NAN, 0}, {0, INFINITY}, {1e101, 0}};
  for (int k = 0; k < 3; k++) {
    SPH_TEST_STATUS(c, sph_search_find_near_point(s.search, bad[k], 2, index, distance, &count),
                    SPH_E_ARGUMENT, k == 1 ? "x[1] must be finite" : "x[0] must be finite");
    SPH_TEST_STATUS(c, sph_search_find_nearest(s.search, bad[k], 2, index, distance, &count),
                    SPH_E_ARGUMENT, k == 1 ? "x[1] must be finite" : "x[0] must be finite");
  }
#define NEAR_POINT(...) sph_search_find_near_point(s.search, __VA_ARGS__), SPH_E_ARGUMENT
#define NEAR_PARTICLE(...) sph_search_find_near_particle(s.search, __VA_ARGS__), SPH_E_ARGUMENT
#define NEAREST(...) sph_search_find_nearest(s.search, __VA_ARGS__), SPH_E_ARGUMENT
#define REFUSED(call, text) SPH_TEST_STATUS_(c, call, text)
#define SPH_TEST_STATUS_(context, ...) SPH_TEST_STATUS(context, __VA_ARGS__)
  REFUSED(NEAR_POINT(NULL, 2, index, distance, &count), "x must not be NULL");
  REFUSED(NEAR_POINT(x, -1, index, distance, &count), "room must be >= 0, got -1");
  REFUSED(NEAR_POINT(x, 2, NULL, distance, &count), "index must not be NULL");
  REFUSED(NEAR_POINT(x, 2, index, NULL, &count), "distance must not be NULL");
  REFUSED(NEAR_POINT(x, 2, index, distance, NULL), "count must not be NULL");
  REFUSED(NEAR_PARTICLE(-1, 2, index, distance, &count), "i must be 0 to 19, got -1");
  REFUSED(NEAR_PARTICLE(20, 2, index, distance, &count), "i must be 0 to 19, got 20");
  REFUSED(NEAR_PARTICLE(0, -1, index, distance, &count), "room must be >= 0, got -1");
  REFUSED(NEAR_PARTICLE(0, 2, NULL, distance, &count), "index must not be NULL");
  REFUSED(NEAR_PARTICLE(0, 2, index, NULL, &count), "distance must not be NULL");
  REFUSED(NEAR_PARTICLE(0, 2, index, distance, NULL), "count must not be NULL");
  REFUSED(NEAREST(NULL, 2, index, distance, &count), "x must not be NULL");
  REFUSED(NEAREST(x, -1, index, distance, &count), "k must be >= 0, got -1");
  REFUSED(NEAREST(x, 2, NULL, distance, &count), "index must not be NULL");
  REFUSED(NEAREST(x, 2, index, NULL, &count), "distance must not be NULL");
  REFUSED(NEAREST(x, 2, index, distance, NULL), "found must not be NULL");
  CU_ASSERT(count == -7 && index[0] == -7 && distance[0] == -7);
  SPH_TEST_OK(c, sph_search_count_pairs(s.search, &pairs_after));
  CU_ASSERT_EQUAL(pairs, pairs_after);
  scene_close(&s);
}

static void test_lost_particles(void) {
  double x[2 * 20];
  random_points(2, 20, 0, 1, 71, x);
  for (int who = 0; who < 20; who += 19) { /* also the first, which could be the origin */
    scene s;
    scene_open(&s, 2, 20, x, 0.5);
    const int64_t removed = 3;
    SPH_TEST_OK(s.context, sph_particles_remove(s.particles, 1, &removed));
    double moved[38];
    memcpy(moved, x, sizeof moved);
    const int at = who ? 18 : 0;
    for (int method = 0; method < 2; method++) {
      SPH_TEST_OK(s.context, sph_search_set_method(s.search, (sph_search_method)method));
      moved[2 * at + 1] = 1e12;
      SPH_TEST_OK(s.context, sph_particles_write(s.particles, SPH_POSITION, moved, 38));
      char text[128];
      snprintf(text, sizeof text, "particle %d at (%g, 1e+12) m is more than 1e9 radii", who,
               moved[2 * at]);
      SPH_TEST_STATUS(s.context, sph_search_update(s.search), SPH_E_DIVERGED, text);
      SPH_TEST_STATUS(s.context, sph_search_update(s.search), SPH_E_DIVERGED, text);
      moved[2 * at + 1] = 0.9e8; /* allowed */
      SPH_TEST_OK(s.context, sph_particles_write(s.particles, SPH_POSITION, moved, 38));
      SPH_TEST_OK(s.context, sph_search_update(s.search));
    }
    scene_close(&s);
  }
}

static void test_memory(void) {
  static double x[3 * 400];
  random_points(3, 400, 0, 1, 81, x);
  scene s;
  scene_open(&s, 3, 400, x, 0.3);
  answers a = answers_open(400);
  sph_search_destroy(&s.search);
  const int64_t live = s.counted.live;
  int failures = 0;
  for (int64_t fail = 1;; fail++) {
    s.counted.fail_at = s.counted.calls + fail;
    int64_t count = -7;
    sph_status status = sph_search_create(s.context, s.particles, 0.3, &s.search);
    if (status == SPH_OK) {
      status = sph_search_update(s.search);
      if (status == SPH_OK) {
        status = sph_search_find_nearest(s.search, x, 400, a.index, a.distance, &count);
        CU_ASSERT(status == SPH_OK || count == -7);
      } else {
        SPH_TEST_STATUS(s.context, sph_search_count_pairs(s.search, &count), SPH_E_STALE,
                        "not built yet");
      }
      s.counted.fail_at = 0;
      SPH_TEST_OK(s.context, sph_search_update(s.search));
      SPH_TEST_OK(s.context,
                  sph_search_find_nearest(s.search, x, 400, a.index, a.distance, &count));
      CU_ASSERT(differences(a.expected, oracle(&s, x, HUGE_VAL, -1, a.expected), a.index,
                            a.distance, count) == 0);
    } else {
      CU_ASSERT(s.search == NULL);
    }
    sph_search_destroy(&s.search);
    CU_ASSERT_EQUAL(s.counted.live, live);
    if (status == SPH_OK) break;
    CU_ASSERT(status == SPH_E_MEMORY);
    failures++;
  }
  CU_ASSERT(failures > 8);
  /* The second round of anything allocates nothing. */
  SPH_TEST_OK(s.context, sph_search_create(s.context, s.particles, 0.3, &s.search));
  int64_t calls = 0;
  for (int round = 0; round < 2; round++) {
    calls = s.counted.calls;
    int64_t count;
    SPH_TEST_OK(s.context, sph_search_update(s.search));
    for (int i = 0; i < 400; i += 7) {
      SPH_TEST_OK(s.context,
                  sph_search_find_near_particle(s.search, i, 400, a.index, a.distance, &count));
      SPH_TEST_OK(s.context,
                  sph_search_find_nearest(s.search, x + 3 * i, 400, a.index, a.distance, &count));
    }
    SPH_TEST_OK(s.context, sph_search_count_pairs(s.search, &count));
  }
  CU_ASSERT_EQUAL(s.counted.calls, calls);
  answers_close(&a);
  scene_close(&s);
}

static void test_references(void) {
  double x[2 * 20];
  random_points(2, 20, 0, 1, 91, x);
  scene s;
  scene_open(&s, 2, 20, x, 0.5);
  sph_context *context = s.context;
  sph_particles_destroy(&s.particles);
  sph_context_destroy(&s.context);
  int64_t pairs = 0;
  SPH_TEST_OK(context, sph_search_update(s.search));
  SPH_TEST_OK(context, sph_search_count_pairs(s.search, &pairs));
  CU_ASSERT(pairs > 0);
  scene_close(&s);
}

SPH_TEST_MAIN("search",
              {"grid equals brute force on 2385 random points, 2D and 3D, periodic in any axes",
               test_random},
              {"grid equals brute force in periodic boxes of 2 or 3 columns", test_small_boxes},
              {"grid equals brute force for clumps, coincident points and lattices",
               test_clusters_and_lattices},
              {"particles 1e7 radii away are found and cost no memory", test_outliers},
              {"large coordinates lose no neighbour", test_distant_origin},
              {"the nearest fill the room, nothing past it is written", test_room},
              {"neighbours do not depend on the order of insertion", test_insertion_order},
              {"pairs do not depend on the number of threads", test_threads},
              {"queries after a change of the particles are stale", test_stale},
              {"settings are in force from the next update", test_settings_wait_for_update},
              {"no, one or two coincident particles work", test_few_particles},
              {"wrong settings are named", test_setting_errors},
              {"wrong arguments of queries are named and change nothing", test_query_errors},
              {"a particle too far away is named", test_lost_particles},
              {"failed allocations leak nothing, second rounds allocate nothing", test_memory},
              {"a search outlives the caller's references", test_references})
