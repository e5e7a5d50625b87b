/* Filling regions: lattices, polygons, half spaces, predicates, and what is refused. */
#include "sph_test.h"

static void *counting_allocate(size_t bytes, void *user) {
  ++*(int64_t *)user;
  return malloc(bytes);
}

static void plain_release(void *memory, void *user) {
  (void)user;
  free(memory);
}

typedef struct bench {
  int64_t allocations;
  sph_context *context;
  sph_particles *p;
} bench;

/* The call on the set of bench b answers SPH_E_ARGUMENT with a message that contains `text`. */
#define REFUSED(call, text) SPH_TEST_STATUS(b.context, call, SPH_E_ARGUMENT, text)

static void set_up(bench *b, int dim, double spacing) {
  b->allocations = 0;
  const sph_allocator allocator = {counting_allocate, plain_release, &b->allocations};
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &b->context) == SPH_OK);
  SPH_TEST_OK(b->context, sph_particles_create(b->context, dim, spacing, &b->p));
  SPH_TEST_OK(b->context, sph_particles_set_name(b->p, "water"));
}

static void tear_down(bench *b) {
  sph_context_destroy(&b->context);
  sph_particles_destroy(&b->p);
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

static void box_is_a_half_offset_lattice(void) {
  for (int dim = 2; dim <= 3; dim++) {
    bench b;
    const double dx = 0.1, lo[3] = {-1, 2, 0.3}, hi[3] = {-0.7, 2.2, 0.8999}; /* 3 x 2 (x 5) */
    set_up(&b, dim, dx);
    const int64_t revision = sph_particles_revision(b.p);
    SPH_TEST_OK(b.context, sph_particles_fill_box(b.p, lo, hi, 1025.5));
    CU_ASSERT(sph_particles_revision(b.p) > revision);
    const int nz = dim == 3 ? 5 : 1;
    CU_ASSERT_FATAL(sph_particles_count(b.p) == 6 * nz);
    double *x = read_all(&b, SPH_POSITION), *v = read_all(&b, SPH_VELOCITY);
    double *rho = read_all(&b, SPH_DENSITY), *p = read_all(&b, SPH_PRESSURE);
    double *m = read_all(&b, SPH_MASS), *volume = read_all(&b, SPH_VOLUME);
    int64_t *ids = read_all_ids(&b);
    const double cell = dim == 2 ? 0.01 : 0.001;
    for (int k = 0; k < 6 * nz; k++) {
      const int place[3] = {k / (2 * nz), k / nz % 2, k % nz};
      for (int d = 0; d < dim; d++) {
        SPH_TEST_CLOSE(x[k * dim + d], lo[d] + (place[d] + 0.5) * dx, 1e-14, 1e-15);
        CU_ASSERT(v[k * dim + d] == 0);
      }
      CU_ASSERT(ids[k] == k && rho[k] == 1025.5 && p[k] == 0);
      SPH_TEST_CLOSE(volume[k], cell, 1e-14, 0);
      SPH_TEST_CLOSE(m[k], 1025.5 * cell, 1e-14, 0);
    }
    free(x), free(v), free(rho), free(p), free(m), free(volume), free(ids);
    tear_down(&b);
  }
}

static void fill_errors_change_nothing(void) {
  bench b;
  set_up(&b, 2, 0.1);
  sph_context *c = b.context;
  const double lo[2] = {0, 0}, hi[2] = {1, 1}, thin[2] = {1, 0.09}, far[2] = {1e12, 1};
  const double nan[2] = {1, NAN}, inf[2] = {INFINITY, 1}, huge[2] = {1e10, 1e10},
               big[2] = {5000, 5000};
  SPH_TEST_OK(c, sph_particles_fill_box(b.p, lo, hi, 1000));
  const int64_t revision = sph_particles_revision(b.p), calls = b.allocations;
  REFUSED(sph_particles_fill_box(b.p, NULL, hi, 1), "NULL");
  REFUSED(sph_particles_fill_box(b.p, lo, NULL, 1), "NULL");
  REFUSED(sph_particles_fill_box(b.p, hi, lo, 1), "from 1 to 0 m");
  REFUSED(sph_particles_fill_box(b.p, lo, thin, 1), "one spacing (0.1 m) wide along y, got 0.09");
  REFUSED(sph_particles_fill_box(b.p, lo, far, 1), "1e+12");
  REFUSED(sph_particles_fill_box(b.p, lo, nan, 1), "nan");
  REFUSED(sph_particles_fill_box(b.p, lo, inf, 1), "inf");
  static const double density[] = {0, -1, NAN, INFINITY, 5e-324};
  for (int k = 0; k < 5; k++) REFUSED(sph_particles_fill_box(b.p, lo, hi, density[k]), "density");
  REFUSED(sph_particles_fill_box(b.p, lo, huge, 1), "at most 2147482623 particles, got 1e+22");
  REFUSED(sph_particles_fill_box(b.p, lo, big, 1), "got 2500000100;");
  REFUSED(sph_particles_fill_predicate(b.p, lo, hi, NULL, NULL, 1), "NULL");
  REFUSED(sph_particles_add(b.p, INT32_MAX, lo, 1, NULL), "got 2147483747;");
  REFUSED(sph_particles_add(b.p, INT64_MAX, lo, 1, NULL), "got 9.22337203685478e+18;");
  CU_ASSERT(b.allocations == calls);
  CU_ASSERT(sph_particles_revision(b.p) == revision && sph_particles_count(b.p) == 100);
  tear_down(&b);
}

static double polygon_area(int vertices, const double *xy, double *perimeter) {
  double area = 0;
  *perimeter = 0;
  for (int k = 0; k < vertices; k++) {
    const double *a = xy + 2 * k, *c = xy + 2 * ((k + 1) % vertices);
    area += 0.5 * (a[0] * c[1] - a[1] * c[0]);
    *perimeter += hypot(c[0] - a[0], c[1] - a[1]);
  }
  return fabs(area);
}

static int polygon_count(double dx, int vertices, const double *xy) {
  bench b;
  set_up(&b, 2, dx);
  SPH_TEST_OK(b.context, sph_particles_fill_polygon(b.p, vertices, xy, 1000));
  const int count = sph_particles_count(b.p);
  tear_down(&b);
  return count;
}

static void polygon_holds_its_area(void) {
  static const double triangle[] = {0, 0, 3.17, 0.4, 1.3, 2.9};
  static const double notched[] = {0, 0, 4, 0, 4, 3, 2.5, 3, 2.1, 0.7, 1.6, 3, 0, 3};
  double drop[2 * 40], backwards[14];
  for (int k = 0; k < 40; k++) {
    const double angle = 2 * 3.14159265358979323846 * k / 40;
    drop[2 * k] = 5 + 1.5 * cos(angle);
    drop[2 * k + 1] = -3 + 0.75 * sin(angle);
  }
  const double *shapes[] = {triangle, notched, drop};
  const int vertices[] = {3, 7, 40};
  for (int s = 0; s < 3; s++)
    for (double dx = 0.1; dx > 0.01; dx *= 0.61) {
      double perimeter;
      const double area = polygon_area(vertices[s], shapes[s], &perimeter);
      const double filled = polygon_count(dx, vertices[s], shapes[s]) * dx * dx;
      SPH_TEST_CLOSE(filled, area, 0, 0.5 * dx * perimeter);
    }
  for (int k = 0; k < 7; k++) {
    backwards[2 * k] = notched[2 * (6 - k)];
    backwards[2 * k + 1] = notched[2 * (6 - k) + 1];
  }
  CU_ASSERT(polygon_count(0.03, 7, backwards) == polygon_count(0.03, 7, notched));
  static const double box[] = {0, 0, 1, 0, 1, 0.5, 0, 0.5};
  CU_ASSERT(polygon_count(0.05, 4, box) == 200);
}

static void polygons_share_an_edge(void) {
  /* The diagonal runs through lattice points: each belongs to one side. */
  static const double lower[] = {0, 0, 1, 0, 0, 1}, upper[] = {1, 0, 1, 1, 0, 1};
  bench b;
  set_up(&b, 2, 0.1);
  SPH_TEST_OK(b.context, sph_particles_fill_polygon(b.p, 3, lower, 1000));
  CU_ASSERT(sph_particles_count(b.p) == 45);
  SPH_TEST_OK(b.context, sph_particles_fill_polygon(b.p, 3, upper, 1000));
  CU_ASSERT(sph_particles_count(b.p) == 100);
  tear_down(&b);
}

static void bad_polygons_are_refused(void) {
  bench b;
  set_up(&b, 2, 0.1);
  static const double bow[] = {0, 0, 1, 1, 1, 0, 0, 1};
  static const double touching[] = {0, 0, 2, 0, 2, 1, 1, 0, 0, 1};
  static const double twice[] = {0, 0, 1, 0, 1, 1, 0, 0};
  static const double spike[] = {0, 0, 1, 0, 2, 0, 1, 0, 1, 1};
  static const double flat[] = {0, 0, 1, 1, 2, 2};
  static const double nan[] = {0, 0, 1, NAN, 1, 1};
  static const double far[] = {0, 0, 1, 0, 1e300, 1};
  static const double sliver[] = {0, 0, 1, 0.97, 1, 0.98};
  REFUSED(sph_particles_fill_polygon(b.p, 4, bow, 1), "edges 0");
  REFUSED(sph_particles_fill_polygon(b.p, 5, touching, 1), "edges 0");
  REFUSED(sph_particles_fill_polygon(b.p, 4, twice, 1),
          "vertices 3 and 0 of the polygon are both at (0, 0)");
  REFUSED(sph_particles_fill_polygon(b.p, 5, spike, 1), "must not turn back");
  REFUSED(sph_particles_fill_polygon(b.p, 3, flat, 1), "must not turn back");
  REFUSED(sph_particles_fill_polygon(b.p, 2, bow, 1), "got 2");
  REFUSED(sph_particles_fill_polygon(b.p, 3, NULL, 1), "NULL");
  REFUSED(sph_particles_fill_polygon(b.p, 3, nan, 1), "vertex 1, component 1");
  REFUSED(sph_particles_fill_polygon(b.p, 3, far, 1), "vertex 2, component 0");
  REFUSED(sph_particles_fill_polygon(b.p, 3, sliver, 1), "no point");
  CU_ASSERT(sph_particles_count(b.p) == 0);
  tear_down(&b);
  set_up(&b, 3, 0.1);
  REFUSED(sph_particles_fill_polygon(b.p, 3, sliver, 1), "dim 2, got 3");
  tear_down(&b);
}

typedef struct wedge {
  int dim;
  const double *points, *normals;
  int64_t calls;
} wedge;

static bool in_wedge(const double *x, void *user) {
  wedge *w = user;
  w->calls++;
  for (int k = 0; k < 2; k++) {
    double distance = 0;
    for (int d = 0; d < w->dim; d++)
      distance += (x[d] - w->points[k * w->dim + d]) * w->normals[k * w->dim + d];
    if (distance < 0) return false;
  }
  return true;
}

static bool nowhere(const double *x, void *user) {
  (void)x;
  (void)user;
  return false;
}

static double hill(const double *x, void *user) {
  const double *level = user;
  return level[0] + level[1] * x[0] * (level[2] != 0 ? 1 + level[2] * x[1] : 1);
}

/* Under a slope: the volume by the midpoint rule, the highest layer half its thickness below the
 * surface, layers within 1/(2 n) of the spacing. */
static void surfaces_are_met(void) {
  for (int dim = 2; dim <= 3; dim++) {
    bench b;
    set_up(&b, dim, 0.1);
    const double lo[3] = {0, dim == 2 ? 0.2 : -1, 0.2}, hi[3] = {2, dim == 2 ? 5 : 1, 5};
    double level[3] = {1.23, 0.3, dim == 3 ? 0.1 : 0}, bad[3] = {NAN, 0, 0};
    SPH_TEST_OK(b.context, sph_particles_fill_surface(b.p, lo, hi, hill, level, 1000));
    const sph_index n = sph_particles_count(b.p);
    double *x = calloc((size_t)n * 3, sizeof *x), *volume = calloc((size_t)n, sizeof *volume);
    double *mass = calloc((size_t)n, sizeof *mass), sum = 0, top_gap = 0;
    CU_ASSERT_FATAL(x != NULL && volume != NULL && mass != NULL);
    SPH_TEST_OK(b.context, sph_particles_read(b.p, SPH_POSITION, x, (int64_t)n * dim));
    SPH_TEST_OK(b.context, sph_particles_read(b.p, SPH_VOLUME, volume, n));
    SPH_TEST_OK(b.context, sph_particles_read(b.p, SPH_MASS, mass, n));
    for (sph_index i = 0; i < n; i++) {
      const double *at = x + (int64_t)i * dim, z = at[dim - 1];
      const double high = volume[i] / pow(0.1, dim - 1), s = hill(at, level);
      sum += volume[i];
      CU_ASSERT(fabs(high / 0.1 - 1) <= 0.1 / (2 * (s - 0.2)) * 1.1);
      SPH_TEST_CLOSE(mass[i], 1000 * volume[i], 1e-15, 0);
      const bool highest = i == n - 1 || x[((int64_t)i + 1) * dim + dim - 1] < z;
      if (highest) top_gap = fmax(top_gap, fabs(z + 0.5 * high - s));
    }
    const double breadth = dim == 2 ? 1 : 2;
    SPH_TEST_CLOSE(sum, breadth * (2 * (1.23 - 0.2) + 0.3 * 2), 1e-12, 0);
    SPH_TEST_BELOW(top_gap, 1e-12);
    REFUSED(sph_particles_fill_surface(b.p, lo, hi, NULL, NULL, 1), "surface must not be NULL");
    REFUSED(sph_particles_fill_surface(b.p, lo, hi, hill, bad, 1), "got nan m at (0.05");
    bad[0] = 5.1;
    REFUSED(sph_particles_fill_surface(b.p, lo, hi, hill, bad, 1), "not above 5 m, got 5.1");
    bad[0] = 0.24;
    REFUSED(sph_particles_fill_surface(b.p, lo, hi, hill, bad, 1), "no column reaches");
    REFUSED(sph_particles_fill_surface(b.p, lo, hi, hill, level, 1000), "overlapping");
    REFUSED(sph_particles_fill_surface(b.p, lo, hi, hill, level, -1), "density");
    CU_ASSERT_EQUAL(sph_particles_fill_surface(NULL, lo, hi, hill, level, 1), SPH_E_ARGUMENT);
    CU_ASSERT_EQUAL(sph_particles_count(b.p), n);
    free(x), free(volume), free(mass);
    tear_down(&b);
  }
}

static void half_spaces_equal_the_predicate(void) {
  const double lo[3] = {-0.5, 0.1, 2}, hi[3] = {0.7, 1.3, 2.8};
  const double points2[] = {0.113, 0.3, -0.21, 0.77}, normals2[] = {0.31, 0.9, 7, -3.3};
  const double points3[] = {0.113, 0.3, 2.4, -0.21, 0.77, 2},
               normals3[] = {0.31, 0.9, -1, 7, -3.3, 2};
  for (int dim = 2; dim <= 3; dim++) {
    bench a, b;
    set_up(&a, dim, 0.05);
    set_up(&b, dim, 0.05);
    wedge w = {dim, dim == 2 ? points2 : points3, dim == 2 ? normals2 : normals3, 0};
    SPH_TEST_OK(a.context,
                sph_particles_fill_half_spaces(a.p, lo, hi, 2, w.points, w.normals, 1000));
    SPH_TEST_OK(b.context, sph_particles_fill_predicate(b.p, lo, hi, in_wedge, &w, 1000));
    const int64_t lattice = 24 * 24 * (dim == 3 ? 16 : 1);
    const sph_index n = sph_particles_count(a.p);
    CU_ASSERT(w.calls == lattice);
    CU_ASSERT(n > 0 && n < lattice);
    CU_ASSERT_FATAL(n == sph_particles_count(b.p));
    double *x = read_all(&a, SPH_POSITION), *y = read_all(&b, SPH_POSITION);
    CU_ASSERT(memcmp(x, y, (size_t)(n * dim) * sizeof *x) == 0);
    free(x), free(y);
    tear_down(&a);
    tear_down(&b);
  }
}

static void planes_own_their_points(void) {
  bench b;
  set_up(&b, 2, 0.1);
  const double lo[2] = {0, 0}, hi[2] = {1, 1}, point[2] = {1, 0}, normal[2] = {-3, -3};
  SPH_TEST_OK(b.context, sph_particles_fill_half_spaces(b.p, lo, hi, 1, point, normal, 1000));
  CU_ASSERT(sph_particles_count(b.p) == 55);
  const double zero[2] = {0, 0}, nan[2] = {0, NAN}, below[2] = {0, -1}, down[2] = {0, -1};
  REFUSED(sph_particles_fill_half_spaces(b.p, lo, hi, 0, point, normal, 1), "got 0");
  REFUSED(sph_particles_fill_half_spaces(b.p, lo, hi, 1, NULL, normal, 1), "NULL");
  REFUSED(sph_particles_fill_half_spaces(b.p, lo, hi, 1, point, NULL, 1), "NULL");
  REFUSED(sph_particles_fill_half_spaces(b.p, lo, hi, 1, nan, normal, 1), "point 0, component 1");
  REFUSED(sph_particles_fill_half_spaces(b.p, lo, hi, 1, point, zero, 1), "normal 0");
  REFUSED(sph_particles_fill_half_spaces(b.p, lo, hi, 1, point, nan, 1), "normal 0");
  REFUSED(sph_particles_fill_half_spaces(b.p, lo, hi, 1, below, down, 1), "no point");
  REFUSED(sph_particles_fill_predicate(b.p, lo, hi, nowhere, NULL, 1), "no point");
  CU_ASSERT(sph_particles_count(b.p) == 55);
  tear_down(&b);
}

static void overlap_is_refused(void) {
  for (int dim = 2; dim <= 3; dim++) {
    bench b;
    set_up(&b, dim, 0.1);
    sph_context *c = b.context;
    const double lo[3] = {0, 0, 0}, hi[3] = {0.5, 0.5, 0.5};
    const double beside[3] = {0.5, 0, 0}, beyond[3] = {1, 0.5, 0.5};
    /* The last old column is at 0.45, the first new one at 0.5, then a bit closer than 0.5 dx. */
    const double near[3] = {0.45, 0, 0}, nearer[3] = {0.4499, 0, 0}, end[3] = {0.65, 0.5, 0.5};
    SPH_TEST_OK(c, sph_particles_fill_box(b.p, lo, hi, 1000));
    const int64_t revision = sph_particles_revision(b.p);
    const sph_index n = sph_particles_count(b.p);
    SPH_TEST_STATUS(
        c, sph_particles_fill_box(b.p, nearer, end, 1000), SPH_E_ARGUMENT,
        dim == 2 ? "fluid overlapping itself: a new particle at (0.4999, 0.05) m is 0.0499 m "
                   "from particle 20 at (0.45, 0.05) m"
                 : "a new particle at (0.4999, 0.05, 0.05) m is 0.0499 m from particle 100 "
                   "at (0.45, 0.05, 0.05) m");
    REFUSED(sph_particles_fill_box(b.p, lo, hi, 1000), "overlapping");
    CU_ASSERT(sph_particles_count(b.p) == n && sph_particles_revision(b.p) == revision);
    SPH_TEST_OK(c, sph_particles_fill_box(b.p, near, end, 1000));
    tear_down(&b);
    set_up(&b, dim, 0.1);
    SPH_TEST_OK(b.context, sph_particles_fill_box(b.p, lo, hi, 1000));
    SPH_TEST_OK(b.context, sph_particles_fill_box(b.p, beside, beyond, 1000));
    CU_ASSERT(sph_particles_count(b.p) == 2 * n);
    tear_down(&b);
  }
}

/* Brute force over the same points decides whether the set must refuse them. */
static void closeness_equals_brute_force(void) {
  uint64_t seed = 20;
  int refused = 0;
  for (int round = 0; round < 300; round++) {
    enum { N = 24, M = 60 }; /* enough new ones that chance does not find close pairs */
    const int dim = 2 + round % 2;
    double x[3 * (N + M)];
    for (int k = 0; k < dim * (N + M); k++)
      x[k] = (dim == 2 ? 9.0 : 2.6) * (sph_test_random(&seed) - 0.5);
    bench b;
    set_up(&b, dim, 1);
    int taken = 0;
    double kept[3 * N];
    for (int k = 0; k < N; k++) {
      if (sph_particles_add(b.p, 1, x + k * dim, 1000, NULL) != SPH_OK) continue;
      memcpy(kept + dim * taken++, x + k * dim, (size_t)dim * sizeof *x);
    }
    memcpy(x, kept, (size_t)(dim * taken) * sizeof *x);
    memmove(x + dim * taken, x + dim * N, (size_t)(dim * M) * sizeof *x);
    bool close = false;
    for (int i = taken; i < taken + M; i++)
      for (int j = 0; j < i; j++) {
        double r2 = 0;
        for (int d = 0; d < dim; d++) r2 += pow(x[i * dim + d] - x[j * dim + d], 2);
        if (r2 < 0.01) close = true;
      }
    const sph_status status = sph_particles_add(b.p, M, x + dim * taken, 1000, NULL);
    CU_ASSERT(status == (close ? SPH_E_ARGUMENT : SPH_OK));
    CU_ASSERT(sph_particles_count(b.p) == taken + (close ? 0 : M));
    refused += close;
    tear_down(&b);
  }
  CU_ASSERT(refused > 50 && refused < 250); /* Both answers have been tried. */
}

SPH_TEST_MAIN("particles_fill",
              {"a box is a lattice half a spacing from lo", box_is_a_half_offset_lattice},
              {"a refused fill changes nothing and allocates nothing", fill_errors_change_nothing},
              {"a polygon holds its area, either way round", polygon_holds_its_area},
              {"polygons with a common edge neither overlap nor leave a gap",
               polygons_share_an_edge},
              {"bad polygons are refused", bad_polygons_are_refused},
              {"columns fill up to a surface", surfaces_are_met},
              {"half spaces equal the same predicate", half_spaces_equal_the_predicate},
              {"points on a plane are inside; bad planes are refused", planes_own_their_points},
              {"fluid overlapping itself is refused", overlap_is_refused},
              {"closeness equals brute force", closeness_equals_brute_force})
