/* Particle sets: fields, ids, adding and removing, leases, memory. */
#include "sph_test.h"

#include "particles/particles_impl.h" /* sorting has no public name */

typedef struct heap {
  int64_t calls, open, fail_at; /* fail_at < 0: never */
} heap;

static void *heap_allocate(size_t bytes, void *user) {
  heap *h = user;
  if (h->calls++ == h->fail_at) return NULL;
  void *memory = malloc(bytes);
  if (memory) h->open++;
  return memory;
}

static void heap_release(void *memory, void *user) {
  ((heap *)user)->open--;
  free(memory);
}

/* The call on the set of bench b answers SPH_E_ARGUMENT with a message that contains `text`. */
#define REFUSED(call, text) SPH_TEST_STATUS(b.context, call, SPH_E_ARGUMENT, text)

/* Every test has its own context, and nothing may be left of it at the end. */
typedef struct bench {
  heap memory;
  sph_context *context;
  sph_particles *p;
} bench;

static void set_up(bench *b, int dim, double spacing) {
  *b = (bench){.memory = {.fail_at = -1}};
  const sph_allocator allocator = {heap_allocate, heap_release, &b->memory};
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &b->context) == SPH_OK);
  SPH_TEST_OK(b->context, sph_particles_create(b->context, dim, spacing, &b->p));
  SPH_TEST_OK(b->context, sph_particles_set_name(b->p, "water"));
}

static void tear_down(bench *b) {
  sph_context_destroy(&b->context);
  sph_particles_destroy(&b->p);
  CU_ASSERT(b->p == NULL);
  CU_ASSERT(b->memory.open == 0);
}

static double *read_all(const bench *b, const char *field) {
  int components = 0;
  SPH_TEST_OK(b->context, sph_particles_field_components(b->p, field, &components));
  const int64_t size = (int64_t)sph_particles_count(b->p) * components;
  double *values = malloc(((size_t)size + 1) * sizeof *values);
  CU_ASSERT_FATAL(values != NULL);
  SPH_TEST_OK(b->context, sph_particles_read(b->p, field, values, size));
  return values;
}

static int64_t *read_all_ids(const bench *b) {
  const sph_index n = sph_particles_count(b->p);
  int64_t *ids = malloc(((size_t)n + 1) * sizeof *ids);
  CU_ASSERT_FATAL(ids != NULL);
  SPH_TEST_OK(b->context, sph_particles_read_ids(b->p, ids, n));
  return ids;
}

/* Random places, one in each cell of a lattice 1 m wide, 16 cells a row: never closer than 0.4 m. */
static void random_places(int dim, int64_t count, double *x, uint64_t *seed) {
  for (int64_t k = 0; k < count; k++) {
    const int64_t row = dim == 2 ? k / 16 : k / 16 % 16;
    const double corner[3] = {(double)(k % 16), (double)row, (double)(k / 256)};
    for (int d = 0; d < dim; d++) x[k * dim + d] = corner[d] + 0.6 * sph_test_random(seed) - 7.3;
  }
}

static void add_random(bench *b, int64_t count, uint64_t seed) {
  const int dim = sph_particles_dim(b->p);
  double *x = malloc((size_t)(count * dim) * sizeof *x);
  CU_ASSERT_FATAL(x != NULL);
  random_places(dim, count, x, &seed);
  SPH_TEST_OK(b->context, sph_particles_add(b->p, count, x, 998.2, NULL));
  free(x);
}

static void write_random(bench *b, const char *field, uint64_t seed) {
  int components = 0;
  SPH_TEST_OK(b->context, sph_particles_field_components(b->p, field, &components));
  const int64_t size = (int64_t)sph_particles_count(b->p) * components;
  double *values = malloc((size_t)size * sizeof *values);
  CU_ASSERT_FATAL(values != NULL);
  for (int64_t k = 0; k < size; k++) values[k] = 0.1 + sph_test_random(&seed);
  SPH_TEST_OK(b->context, sph_particles_write(b->p, field, values, size));
  free(values);
}

static void new_set_is_empty(void) {
  bench b;
  set_up(&b, 3, 0.25);
  CU_ASSERT(sph_particles_count(b.p) == 0);
  CU_ASSERT(sph_particles_dim(b.p) == 3);
  CU_ASSERT(sph_particles_spacing(b.p) == 0.25);
  CU_ASSERT(sph_particles_revision(b.p) >= 1);
  CU_ASSERT(sph_particles_field_count(b.p) == 6);
  static const char *const names[] = {"position", "velocity", "density",
                                      "pressure", "mass",     "volume"};
  static const char *const units[] = {"m", "m/s", "kg/m^3", "Pa", "kg", "m^3"};
  for (int k = 0; k < 6; k++) {
    int components = 0;
    const char *unit = NULL;
    CU_ASSERT_STRING_EQUAL(sph_particles_field_name(b.p, k), names[k]);
    SPH_TEST_OK(b.context, sph_particles_field_components(b.p, names[k], &components));
    CU_ASSERT(components == (k < 2 ? 3 : 1));
    SPH_TEST_OK(b.context, sph_particles_field_unit(b.p, names[k], &unit));
    CU_ASSERT_STRING_EQUAL(unit, units[k]);
  }
  CU_ASSERT(sph_particles_field_name(b.p, 6) == NULL);
  CU_ASSERT(sph_particles_field_name(b.p, -1) == NULL);
  double none;
  const double *lease = NULL;
  SPH_TEST_OK(b.context, sph_particles_read(b.p, SPH_MASS, &none, 0));
  SPH_TEST_OK(b.context, sph_particles_read(b.p, SPH_MASS, NULL, 0));
  SPH_TEST_OK(b.context, sph_particles_read_ids(b.p, NULL, 0));
  SPH_TEST_OK(b.context, sph_particles_lease_read(b.p, SPH_MASS, &lease));
  SPH_TEST_OK(b.context, sph_particles_release(b.p, lease));
  tear_down(&b);
  set_up(&b, 2, 0.25);
  const char *unit = NULL;
  SPH_TEST_OK(b.context, sph_particles_field_unit(b.p, SPH_MASS, &unit));
  CU_ASSERT_STRING_EQUAL(unit, "kg/m");
  SPH_TEST_OK(b.context, sph_particles_field_unit(b.p, SPH_VOLUME, &unit));
  CU_ASSERT_STRING_EQUAL(unit, "m^2");
  tear_down(&b);
}

static void null_is_answered(void) {
  const double x[3] = {0};
  double y[3], *write = y;
  const double *read = x;
  const int64_t id = 0;
  int64_t ids[1];
  int c;
  const char *unit;
  sph_particles *none = NULL;
  sph_particles_destroy(NULL);
  sph_particles_destroy(&none);
  CU_ASSERT_STRING_EQUAL(sph_particles_name(NULL), "");
  CU_ASSERT(sph_particles_count(NULL) == 0);
  CU_ASSERT(sph_particles_dim(NULL) == 0);
  CU_ASSERT(sph_particles_spacing(NULL) == 0);
  CU_ASSERT(sph_particles_revision(NULL) == 0);
  CU_ASSERT(sph_particles_field_count(NULL) == 0);
  CU_ASSERT(sph_particles_field_name(NULL, 0) == NULL);
  CU_ASSERT(sph_particles_set_name(NULL, "a") == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_add_field(NULL, "a", 1, "1") == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_field_components(NULL, "a", &c) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_field_unit(NULL, "a", &unit) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_fill_box(NULL, x, x, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_fill_polygon(NULL, 3, x, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_fill_half_spaces(NULL, x, x, 1, x, x, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_fill_predicate(NULL, x, x, NULL, NULL, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_add(NULL, 1, x, 1, NULL) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_remove(NULL, 1, &id) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_read_ids(NULL, ids, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_read(NULL, SPH_MASS, y, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_write(NULL, SPH_MASS, x, 1) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_particles_lease_read(NULL, SPH_MASS, &read) == SPH_E_ARGUMENT && !read);
  CU_ASSERT(sph_particles_lease_write(NULL, SPH_MASS, &write) == SPH_E_ARGUMENT && !write);
  CU_ASSERT(sph_particles_release(NULL, x) == SPH_E_ARGUMENT);
}

static void creation_is_checked(void) {
  bench b;
  set_up(&b, 2, 1);
  sph_particles *p = b.p;
  CU_ASSERT(sph_particles_create(NULL, 2, 1, &p) == SPH_E_ARGUMENT && p == NULL);
  REFUSED(sph_particles_create(b.context, 2, 1, NULL), "out");
  REFUSED(sph_particles_create(b.context, 1, 1, &p), "dim must be 2 or 3, got 1");
  REFUSED(sph_particles_create(b.context, 4, 1, &p), "got 4");
  static const double bad[] = {0, -0.01, INFINITY, NAN, 1e-300, 1e300};
  for (int k = 0; k < 6; k++) {
    p = b.p;
    REFUSED(sph_particles_create(b.context, 2, bad[k], &p), "spacing must be > 0 m");
    CU_ASSERT(p == NULL);
  }
  REFUSED(sph_particles_create(b.context, 2, -0.01, &p), "got -0.01");
  tear_down(&b);
}

static void messages_carry_the_name(void) {
  bench b;
  set_up(&b, 2, 1);
  sph_particles *plain = NULL;
  SPH_TEST_OK(b.context, sph_particles_create(b.context, 2, 1, &plain));
  CU_ASSERT_STRING_EQUAL(sph_particles_name(plain), "particles");
  CU_ASSERT_STRING_EQUAL(sph_particles_name(b.p), "water");
  REFUSED(sph_particles_remove(plain, -1, NULL),
          "particles \"particles\": count must be >= 0, got -1");
  REFUSED(sph_particles_remove(b.p, -1, NULL), "particles \"water\": count must be >= 0, got -1");
  char name[65];
  memset(name, 'a', 64);
  name[64] = 0;
  REFUSED(sph_particles_set_name(b.p, NULL), "NULL");
  REFUSED(sph_particles_set_name(b.p, ""), "got 0");
  REFUSED(sph_particles_set_name(b.p, name), "got 64");
  REFUSED(sph_particles_set_name(b.p, "a\nb"), "0x0a at byte 1");
  CU_ASSERT_STRING_EQUAL(sph_particles_name(b.p), "water");
  SPH_TEST_OK(b.context, sph_particles_set_name(b.p, name + 1));
  CU_ASSERT_STRING_EQUAL(sph_particles_name(b.p), name + 1);
  sph_particles_destroy(&plain);
  tear_down(&b);
}

static void own_fields_are_zero_and_kept(void) {
  bench b;
  set_up(&b, 2, 1);
  add_random(&b, 50, 1);
  SPH_TEST_OK(b.context, sph_particles_add_field(b.p, "stress", 9, "Pa"));
  SPH_TEST_OK(b.context, sph_particles_add_field(b.p, "dye_1.a-b", 1, "m³"));
  CU_ASSERT(sph_particles_field_count(b.p) == 8);
  double *zero = read_all(&b, "stress");
  for (int k = 0; k < 450; k++) CU_ASSERT(zero[k] == 0);
  free(zero);
  write_random(&b, "stress", 7);
  double *before = read_all(&b, "stress");
  /* A removal leaves a used place behind; who takes it starts from zero. */
  const int64_t id = 49;
  SPH_TEST_OK(b.context, sph_particles_remove(b.p, 1, &id));
  const double x[2] = {100, 100};
  SPH_TEST_OK(b.context, sph_particles_add(b.p, 1, x, 1000, NULL));
  double *after = read_all(&b, "stress");
  CU_ASSERT(memcmp(before, after, 49 * 9 * sizeof *before) == 0);
  for (int k = 49 * 9; k < 50 * 9; k++) CU_ASSERT(after[k] == 0);
  free(before);
  free(after);
  const char *unit = NULL;
  SPH_TEST_OK(b.context, sph_particles_field_unit(b.p, "dye_1.a-b", &unit));
  CU_ASSERT_STRING_EQUAL(unit, "m³");
  tear_down(&b);
}

static void field_errors_are_answered(void) {
  bench b;
  set_up(&b, 2, 1);
  sph_context *c = b.context;
  char name[65];
  memset(name, 'a', 64);
  name[64] = 0;
  REFUSED(sph_particles_add_field(b.p, NULL, 1, "1"), "NULL");
  REFUSED(sph_particles_add_field(b.p, "a", 1, NULL), "NULL");
  REFUSED(sph_particles_add_field(b.p, "", 1, "1"), "got 0");
  REFUSED(sph_particles_add_field(b.p, name, 1, "1"), "got 64");
  REFUSED(sph_particles_add_field(b.p, "a b", 1, "1"), "0x20 at byte 1");
  REFUSED(sph_particles_add_field(b.p, "a", 1, ""), "unit");
  REFUSED(sph_particles_add_field(b.p, "a", 1, name), "got 64");
  REFUSED(sph_particles_add_field(b.p, "a", 1, "a<b"), "0x3c at byte 1");
  REFUSED(sph_particles_add_field(b.p, "a", 0, "1"), "1 to 9, got 0");
  REFUSED(sph_particles_add_field(b.p, "a", 10, "1"), "got 10");
  REFUSED(sph_particles_add_field(b.p, "mass", 1, "kg"), "exists already");
  CU_ASSERT(sph_particles_field_count(b.p) == 6);
  int components = 77;
  const char *unit = name;
  const double *read = NULL;
  double *write = NULL;
  SPH_TEST_STATUS(c, sph_particles_field_components(b.p, "presure", &components), SPH_E_NAME,
                  "unknown field \"presure\"; did you mean \"pressure\"?");
  SPH_TEST_STATUS(c, sph_particles_field_unit(b.p, "posiition", &unit), SPH_E_NAME,
                  "did you mean \"position\"?");
  SPH_TEST_STATUS(c, sph_particles_field_unit(b.p, "zzzzzzzzzzzz", &unit), SPH_E_NAME,
                  "unknown field \"zzzzzzzzzzzz\"; call sph_particles_add_field");
  CU_ASSERT(components == 77 && unit == name);
  REFUSED(sph_particles_field_components(b.p, NULL, &components), "NULL");
  REFUSED(sph_particles_field_components(b.p, "mass", NULL), "NULL");
  REFUSED(sph_particles_field_unit(b.p, NULL, &unit), "NULL");
  REFUSED(sph_particles_field_unit(b.p, "mass", NULL), "NULL");
  SPH_TEST_STATUS(c, sph_particles_read(b.p, "mas", NULL, 0), SPH_E_NAME, "\"mass\"");
  SPH_TEST_STATUS(c, sph_particles_write(b.p, "mas", NULL, 0), SPH_E_NAME, "\"mass\"");
  REFUSED(sph_particles_read(b.p, NULL, NULL, 0), "NULL");
  REFUSED(sph_particles_write(b.p, NULL, NULL, 0), "NULL");
  SPH_TEST_STATUS(c, sph_particles_lease_read(b.p, "mas", &read), SPH_E_NAME, "\"mass\"");
  SPH_TEST_STATUS(c, sph_particles_lease_write(b.p, "mas", &write), SPH_E_NAME, "\"mass\"");
  REFUSED(sph_particles_lease_read(b.p, NULL, &read), "NULL");
  REFUSED(sph_particles_lease_write(b.p, NULL, &write), "NULL");
  REFUSED(sph_particles_lease_read(b.p, "mass", NULL), "NULL");
  REFUSED(sph_particles_lease_write(b.p, "mass", NULL), "NULL");
  tear_down(&b);
}

static void additions_are_checked(void) {
  bench b;
  set_up(&b, 2, 0.1);
  sph_context *c = b.context;
  const double x[] = {0, 0, -0.005, 0.005}, good[] = {0, 0, 0.01, 0, 1e300, -1e300},
               nan[] = {0, 0, 1, NAN};
  int64_t ids[3] = {-5, -5, -5};
  SPH_TEST_STATUS(
      c, sph_particles_add(b.p, 2, x, 1000, ids), SPH_E_ARGUMENT,
      "a new particle at (-0.005, 0.005) m is 0.00707107 m from another new one at (0, 0) m; "
      "they must be at least 0.01 m apart");
  REFUSED(sph_particles_add(b.p, 2, nan, 1000, ids), "new particle 1, component 1");
  REFUSED(sph_particles_add(b.p, -1, x, 1000, ids), "got -1");
  REFUSED(sph_particles_add(b.p, 1, NULL, 1000, ids), "NULL");
  REFUSED(sph_particles_add(b.p, 1, x, -3, ids), "got -3");
  CU_ASSERT(sph_particles_count(b.p) == 0 && ids[0] == -5 && ids[1] == -5);
  const double zeros[] = {-0.0, -0.0, 0.004, 0.004}; /* minus zero is in the cell of zero */
  REFUSED(sph_particles_add(b.p, 2, zeros, 1000, ids), "at (0.004, 0.004) m");
  const int64_t revision = sph_particles_revision(b.p);
  SPH_TEST_OK(c, sph_particles_add(b.p, 0, NULL, 1000, NULL));
  CU_ASSERT(sph_particles_revision(b.p) == revision);
  SPH_TEST_OK(c, sph_particles_add(b.p, 3, good, 1000, ids));
  CU_ASSERT(ids[0] == 0 && ids[1] == 1 && ids[2] == 2);
  CU_ASSERT(sph_particles_revision(b.p) > revision);
  REFUSED(sph_particles_add(b.p, 1, x + 2, 1000, ids), "from particle 0 at");
  REFUSED(sph_particles_add(b.p, 1, good + 4, 1000, ids), "from particle 2");
  tear_down(&b);
}

static void ids_survive_removal(void) {
  bench b;
  set_up(&b, 3, 1);
  sph_context *c = b.context;
  add_random(&b, 500, 3);
  write_random(&b, SPH_VELOCITY, 4);
  double *before = read_all(&b, SPH_VELOCITY);
  int64_t gone[250];
  for (int k = 0; k < 250; k++) gone[k] = (k * 7 + 3) % 250 * 2; /* the even ones, shuffled */
  const int64_t revision = sph_particles_revision(b.p);
  SPH_TEST_OK(c, sph_particles_remove(b.p, 250, gone));
  CU_ASSERT(sph_particles_revision(b.p) > revision);
  CU_ASSERT_FATAL(sph_particles_count(b.p) == 250);
  int64_t *ids = read_all_ids(&b);
  double *after = read_all(&b, SPH_VELOCITY);
  for (int k = 0; k < 250; k++) {
    CU_ASSERT(ids[k] == 2 * k + 1);
    CU_ASSERT(memcmp(after + 3 * k, before + 3 * (2 * k + 1), 3 * sizeof *after) == 0);
  }
  free(ids), free(before), free(after);
  const int64_t unknown[] = {1, 2}, twice[] = {7, 1, 7}, last = 499, beyond = 500;
  const int64_t calls = b.memory.calls, now = sph_particles_revision(b.p);
  REFUSED(sph_particles_remove(b.p, 2, unknown), "no particle has id 2");
  REFUSED(sph_particles_remove(b.p, 3, twice), "id 7 is given twice");
  REFUSED(sph_particles_remove(b.p, 1, &beyond), "id 500");
  REFUSED(sph_particles_remove(b.p, -2, twice), "got -2");
  REFUSED(sph_particles_remove(b.p, 1, NULL), "NULL");
  SPH_TEST_OK(c, sph_particles_remove(b.p, 0, NULL));
  CU_ASSERT(sph_particles_count(b.p) == 250 && sph_particles_revision(b.p) == now);
  SPH_TEST_OK(c, sph_particles_remove(b.p, 1, &last));
  CU_ASSERT(b.memory.calls == calls); /* Removing needs no memory. */
  const double x[3] = {100, 100, 100};
  int64_t id = 0;
  SPH_TEST_OK(c, sph_particles_add(b.p, 1, x, 1000, &id));
  CU_ASSERT(id == 500); /* 499 is not given again. */
  tear_down(&b);
}

/* A permutation of 0..n-1 (Fisher and Yates). */
static sph_index *shuffle(sph_index n, uint64_t *seed) {
  sph_index *order = malloc(((size_t)n + 1) * sizeof *order);
  CU_ASSERT_FATAL(order != NULL);
  for (sph_index k = 0; k < n; k++) order[k] = k;
  for (sph_index k = n - 1; k > 0; k--) {
    const sph_index other = (sph_index)(sph_test_random(seed) * (k + 1)), kept = order[k];
    order[k] = order[other];
    order[other] = kept;
  }
  return order;
}

static void sorting_is_invisible(void) {
  bench b;
  set_up(&b, 2, 1);
  uint64_t seed = 99;
  add_random(&b, 20011, 5); /* enough for the threaded loops */
  if (sph_context_set_threads(b.context, 2) != SPH_OK)
    CU_ASSERT(sph_context_get_threads(b.context) == 1);
  SPH_TEST_OK(b.context, sph_particles_add_field(b.p, "tensor", 4, "1"));
  static const char *const fields[] = {SPH_POSITION, SPH_VELOCITY, SPH_DENSITY, "tensor"};
  for (int f = 1; f < 4; f++) write_random(&b, fields[f], 10 + (uint64_t)f);
  for (int round = 0; round < 3; round++) {
    double *before[4];
    for (int f = 0; f < 4; f++) before[f] = read_all(&b, fields[f]);
    int64_t *ids_before = read_all_ids(&b);
    const sph_index n = sph_particles_count(b.p);
    const int64_t revision = sph_particles_revision(b.p), calls = b.memory.calls;
    sph_index *order = shuffle(n, &seed);
    const double first = b.p->field[SPHI_X].data[0][order[0]];
    sphi_particles_permute(b.p, order);
    CU_ASSERT(b.p->field[SPHI_X].data[0][0] == first);
    free(order);
    CU_ASSERT(sph_particles_revision(b.p) == revision && b.memory.calls == calls);
    for (sph_index k = 0; k < n; k++)
      CU_ASSERT_FATAL(b.p->slot[b.p->rank[k]] == k && b.p->id[k] == ids_before[b.p->rank[k]]);
    int components[4] = {2, 2, 1, 4};
    for (int f = 0; f < 4; f++) {
      double *after = read_all(&b, fields[f]);
      CU_ASSERT(memcmp(after, before[f], (size_t)(n * components[f]) * sizeof *after) == 0);
      free(after), free(before[f]);
    }
    int64_t *ids = read_all_ids(&b);
    CU_ASSERT(memcmp(ids, ids_before, (size_t)n * sizeof *ids) == 0);
    /* Take some out of the shuffled set, and write through it, before the next round. */
    int64_t gone[3] = {ids[n - 1], ids[17], ids[n / 2]};
    free(ids), free(ids_before);
    double *density = read_all(&b, SPH_DENSITY);
    SPH_TEST_OK(b.context, sph_particles_remove(b.p, 3, gone));
    double *kept = read_all(&b, SPH_DENSITY);
    CU_ASSERT(memcmp(density, kept, 17 * sizeof *kept) == 0);
    CU_ASSERT(memcmp(density + 18, kept + 17, (size_t)(n / 2 - 18) * sizeof *kept) == 0);
    CU_ASSERT(
        memcmp(density + n / 2 + 1, kept + n / 2 - 1, (size_t)(n - n / 2 - 2) * sizeof *kept) == 0);
    free(density), free(kept);
    write_random(&b, SPH_VELOCITY, 50 + (uint64_t)round);
  }
  tear_down(&b);
}

static void writes_are_checked(void) {
  bench b;
  set_up(&b, 2, 1);
  sph_context *c = b.context;
  add_random(&b, 4, 6);
  const int64_t first = 0;
  SPH_TEST_OK(c, sph_particles_remove(b.p, 1, &first));
  double values[8] = {1, 2, 3, 4, 5, 6, 7, 8}, back[8];
  int64_t ids[3];
  const int64_t revision = sph_particles_revision(b.p);
  SPH_TEST_OK(c, sph_particles_write(b.p, SPH_VELOCITY, values, 6));
  CU_ASSERT(sph_particles_revision(b.p) > revision);
  SPH_TEST_OK(c, sph_particles_read(b.p, SPH_VELOCITY, back, 6));
  CU_ASSERT(memcmp(values, back, 6 * sizeof *back) == 0);
  REFUSED(sph_particles_read(b.p, SPH_VELOCITY, back, 8),
          "velocity of 3 particles with 2 components has 6 values, got size 8");
  REFUSED(sph_particles_write(b.p, SPH_VELOCITY, values, 3), "got size 3");
  REFUSED(sph_particles_read_ids(b.p, ids, 4), "has 3 values, got size 4");
  REFUSED(sph_particles_read_ids(b.p, NULL, 3), "NULL");
  REFUSED(sph_particles_read(b.p, SPH_MASS, NULL, 3), "NULL");
  REFUSED(sph_particles_write(b.p, SPH_MASS, NULL, 3), "NULL");
  const int64_t now = sph_particles_revision(b.p);
  values[3] = NAN;
  REFUSED(sph_particles_write(b.p, SPH_VELOCITY, values, 6),
          "velocity of the particle with id 2, component 1, must be finite, got nan");
  values[3] = INFINITY;
  REFUSED(sph_particles_write(b.p, SPH_POSITION, values, 6), "got inf");
  static const char *const positive[] = {SPH_MASS, SPH_VOLUME, SPH_DENSITY};
  const double bad[] = {0, -1, NAN};
  for (int f = 0; f < 3; f++)
    for (int k = 0; k < 3; k++) {
      double *before = read_all(&b, positive[f]);
      values[2] = bad[k];
      REFUSED(sph_particles_write(b.p, positive[f], values, 3),
              "id 3, component 0, must be finite and > 0 ");
      double *after = read_all(&b, positive[f]);
      CU_ASSERT(memcmp(before, after, 3 * sizeof *after) == 0);
      free(before), free(after);
    }
  CU_ASSERT(sph_particles_revision(b.p) == now);
  values[2] = -1;
  SPH_TEST_OK(c, sph_particles_write(b.p, SPH_PRESSURE, values, 3)); /* suction is allowed */
  tear_down(&b);
}

static void leases_hand_fields_over(void) {
  bench b;
  set_up(&b, 3, 1);
  sph_context *c = b.context;
  add_random(&b, 100, 8);
  write_random(&b, SPH_VELOCITY, 9);
  uint64_t seed = 1;
  sph_index *order = shuffle(100, &seed);
  double *expected = read_all(&b, SPH_VELOCITY);
  sphi_particles_permute(b.p, order);
  const int64_t revision = sph_particles_revision(b.p);
  const sph_particles *reader = b.p;
  const double *read = NULL;
  double *write = NULL;
  SPH_TEST_OK(c, sph_particles_lease_read(reader, SPH_VELOCITY, &read));
  CU_ASSERT(memcmp(read, expected, 300 * sizeof *read) == 0);
  SPH_TEST_OK(c, sph_particles_lease_write(b.p, SPH_VELOCITY, &write));
  CU_ASSERT(memcmp(write, expected, 300 * sizeof *write) == 0);
  for (int k = 0; k < 300; k++) expected[k] = write[k] = 3 * write[k] + k;
  /* Sorting and new fields while leases are open do no harm. */
  sphi_particles_permute(b.p, order);
  for (int k = 0; k < 20; k++) {
    char name[24];
    snprintf(name, sizeof name, "extra%d", k);
    SPH_TEST_OK(c, sph_particles_add_field(b.p, name, 1, "1"));
  }
  CU_ASSERT(sph_particles_revision(b.p) == revision);
  SPH_TEST_OK(c, sph_particles_release(reader, read));
  CU_ASSERT(sph_particles_revision(b.p) == revision);
  SPH_TEST_OK(c, sph_particles_release(b.p, write));
  CU_ASSERT(sph_particles_revision(b.p) > revision);
  double *after = read_all(&b, SPH_VELOCITY);
  CU_ASSERT(memcmp(after, expected, 300 * sizeof *after) == 0);
  free(after), free(expected), free(order);
  tear_down(&b);
}

static void lease_errors_are_answered(void) {
  bench b;
  set_up(&b, 2, 1);
  sph_context *c = b.context;
  add_random(&b, 20, 8);
  const double *read = NULL, lo[2] = {50, 50}, hi[2] = {52, 52}, far[2] = {90, 90};
  double *write = NULL, *before = read_all(&b, SPH_DENSITY);
  const int64_t id = 0, revision = sph_particles_revision(b.p);
  SPH_TEST_OK(c, sph_particles_lease_read(b.p, SPH_MASS, &read));
  REFUSED(sph_particles_fill_box(b.p, lo, hi, 1000), "1 leases are open");
  REFUSED(sph_particles_add(b.p, 1, far, 1000, NULL), "leases are open");
  REFUSED(sph_particles_remove(b.p, 1, &id), "leases are open");
  REFUSED(sph_particles_release(b.p, lo), "none of the 1 open leases");
  REFUSED(sph_particles_release(b.p, NULL), "none of the 1 open leases");
  SPH_TEST_OK(c, sph_particles_release(b.p, read));
  REFUSED(sph_particles_release(b.p, read), "none of the 0 open leases");
  SPH_TEST_OK(c, sph_particles_lease_write(b.p, SPH_DENSITY, &write));
  write[3] = 5;
  write[17] = 0;
  SPH_TEST_STATUS(
      c, sph_particles_release(b.p, write), SPH_E_ARGUMENT,
      "density of the particle with id 17, component 0, must be finite and > 0 kg/m^3, got 0");
  double *after = read_all(&b, SPH_DENSITY);
  CU_ASSERT(memcmp(before, after, 20 * sizeof *after) == 0);
  CU_ASSERT(sph_particles_revision(b.p) == revision);
  free(before), free(after);
  SPH_TEST_OK(c, sph_particles_remove(b.p, 1, &id)); /* The lease is closed. */
  /* tear_down finds these two freed with the set. */
  SPH_TEST_OK(c, sph_particles_lease_write(b.p, SPH_DENSITY, &write));
  SPH_TEST_OK(c, sph_particles_lease_read(b.p, SPH_DENSITY, &read));
  tear_down(&b);
}

static void references_keep_a_set_alive(void) {
  bench b;
  set_up(&b, 2, 1);
  sph_particles *kept = b.p;
  sphi_particles_retain(kept);
  sph_particles_destroy(&b.p);
  CU_ASSERT(b.p == NULL && b.memory.open > 0);
  CU_ASSERT_STRING_EQUAL(sph_particles_name(kept), "water");
  b.p = kept;
  tear_down(&b);
}

/* Everything about a set that a failed call must leave as it was. */
typedef struct snapshot {
  sph_index n;
  int fields;
  int64_t revision, leases;
  double sum;
} snapshot;

static snapshot take_snapshot(const bench *b) {
  snapshot s = {sph_particles_count(b->p), sph_particles_field_count(b->p),
                sph_particles_revision(b->p), b->p->leases->count, 0};
  double weight = 1;
  for (int f = 0; f < s.fields; f++) {
    const char *name = sph_particles_field_name(b->p, f);
    int components = 0;
    SPH_TEST_OK(b->context, sph_particles_field_components(b->p, name, &components));
    double *values = read_all(b, name);
    for (int64_t k = 0; k < (int64_t)s.n * components; k++) s.sum += values[k] * (weight += 0.37);
    free(values);
  }
  return s;
}

typedef sph_status (*attempt)(bench *b);

static sph_status try_name(bench *b) { return sph_particles_set_name(b->p, "oil"); }

static sph_status try_field(bench *b) { return sph_particles_add_field(b->p, "dye", 3, "1"); }

static sph_status try_box(bench *b) {
  const double lo[2] = {20, 0}, hi[2] = {40, 20};
  return sph_particles_fill_box(b->p, lo, hi, 1000);
}

static sph_status try_polygon(bench *b) {
  const double xy[6] = {20, 0, 60, 0, 20, 40};
  return sph_particles_fill_polygon(b->p, 3, xy, 1000);
}

static sph_status try_half_space(bench *b) {
  const double lo[2] = {20, 0}, hi[2] = {40, 20}, point[2] = {30, 0}, normal[2] = {1, 0.2};
  return sph_particles_fill_half_spaces(b->p, lo, hi, 1, point, normal, 1000);
}

static bool right_of(const double *x, void *user) { return x[0] > *(const double *)user; }

static sph_status try_predicate(bench *b) {
  const double lo[2] = {20, 0}, hi[2] = {40, 20};
  double left = 30;
  return sph_particles_fill_predicate(b->p, lo, hi, right_of, &left, 1000);
}

static sph_status try_add(bench *b) {
  double x[400];
  for (int k = 0; k < 200; k++) {
    x[2 * k] = 30 + k;
    x[2 * k + 1] = 0.5 * k;
  }
  return sph_particles_add(b->p, 200, x, 1000, NULL);
}

static sph_status try_lease(bench *b) {
  double *values = NULL;
  const sph_status status = sph_particles_lease_write(b->p, SPH_POSITION, &values);
  CU_ASSERT((values != NULL) == (status == SPH_OK));
  if (status != SPH_OK) return status;
  return sph_particles_release(b->p, values);
}

static sph_status try_create(bench *b) {
  sph_particles *p = b->p;
  const sph_status status = sph_particles_create(b->context, 3, 0.1, &p);
  CU_ASSERT((p != NULL) == (status == SPH_OK));
  sph_particles_destroy(&p);
  return status;
}

static void failing_memory_changes_nothing(void) {
  static const attempt attempts[] = {try_name,    try_field,      try_box,
                                     try_polygon, try_half_space, try_predicate,
                                     try_add,     try_lease,      try_create};
  for (size_t a = 0; a < sizeof attempts / sizeof attempts[0]; a++) {
    bool done = false;
    for (int64_t k = 0; k < 100 && !done; k++) {
      bench b;
      set_up(&b, 2, 1);
      add_random(&b, 60, 11);
      write_random(&b, SPH_VELOCITY, 12);
      /* With the list of fields full, one field more makes it grow. */
      while (b.p->fields < b.p->field_capacity) {
        char name[24];
        snprintf(name, sizeof name, "f%d", b.p->fields);
        SPH_TEST_OK(b.context, sph_particles_add_field(b.p, name, 1, "1"));
      }
      const snapshot before = take_snapshot(&b);
      const int64_t open = b.memory.open;
      b.memory.fail_at = b.memory.calls + k;
      const sph_status status = attempts[a](&b);
      b.memory.fail_at = -1;
      done = status == SPH_OK;
      if (!done) {
        CU_ASSERT(status == SPH_E_MEMORY && sph_context_status(b.context) == SPH_E_MEMORY);
        CU_ASSERT(strstr(sph_context_message(b.context), "no memory") != NULL);
        CU_ASSERT(b.memory.open == open);
        const snapshot after = take_snapshot(&b);
        CU_ASSERT(memcmp(&before, &after, sizeof after) == 0);
        CU_ASSERT_STRING_EQUAL(sph_particles_name(b.p), "water");
        CU_ASSERT(attempts[a](&b) == SPH_OK); /* The set is usable: it works the second time. */
      } else {
        CU_ASSERT(k >= 1);
      }
      tear_down(&b);
    }
    CU_ASSERT(done);
  }
}

static void growth_keeps_the_values(void) {
  bench b;
  set_up(&b, 2, 1);
  uint64_t seed = 31;
  for (int k = 0; k < 1000; k++) {
    const double x[2] = {k, sph_test_random(&seed)};
    SPH_TEST_OK(b.context, sph_particles_add(b.p, 1, x, 1 + k, NULL));
  }
  double *x = read_all(&b, SPH_POSITION), *rho = read_all(&b, SPH_DENSITY);
  seed = 31;
  for (int k = 0; k < 1000; k++)
    CU_ASSERT(x[2 * k] == k && x[2 * k + 1] == sph_test_random(&seed) && rho[k] == 1 + k);
  free(x), free(rho);
  tear_down(&b);
}

SPH_TEST_MAIN("particles", {"a new set is empty and has six fields", new_set_is_empty},
              {"NULL is answered by every function", null_is_answered},
              {"creation refuses bad dimensions and spacings", creation_is_checked},
              {"messages carry the name", messages_carry_the_name},
              {"own fields are zero until written, also in used places",
               own_fields_are_zero_and_kept},
              {"every field error is answered", field_errors_are_answered},
              {"additions are checked", additions_are_checked},
              {"ids survive removal and are not given again", ids_survive_removal},
              {"sorting is invisible", sorting_is_invisible},
              {"writes are checked and leave the field alone when refused", writes_are_checked},
              {"leases hand fields over in id order", leases_hand_fields_over},
              {"lease errors are answered", lease_errors_are_answered},
              {"references keep a set alive", references_keep_a_set_alive},
              {"failing memory changes nothing and leaks nothing", failing_memory_changes_nothing},
              {"growth keeps the values", growth_keeps_the_values})
