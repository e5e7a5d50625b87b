/* The pair sweep from the inside: lists against brute force, operators against plain double loops.
 *
 * Errors are relative to the largest value of a quantity over all particles. */
#include "sweep_world.h"

/* In 3D the smallest eigenvalue may be given as a lower bound where that is above 1/2. */
static void take_bounds(int dim, results *r, const results *plain) {
  int wrong = 0;
  for (int i = 0; i < 3 * r->n && dim == 3; i += 3) {
    double *given = r->q[LAMBDA] + i;
    const double lambda = plain->q[LAMBDA][i];
    if (!(*given >= 0.5 && lambda >= 0.5)) continue;
    wrong += *given > lambda + 5e-6;
    *given = lambda;
  }
  CU_ASSERT_EQUAL(wrong, 0);
}

static void compare_settings(int setting) {
  double worst[2][QUANTITIES] = {{0}, {0}};
  for (int dim = 2; dim <= 3; dim++)
    for (int type = 1; type <= SPHI_KERNEL_ROWS; type++) {
      world w;
      if (!open_world(&w, dim, type, setting)) continue;
      results plain = new_results(w.particles->n);
      plain_loops(&w, &plain);
      const sphi_variant *variant;
      for (int at = 0; (variant = next_variant(&w, &at));) {
        results r = new_results(w.particles->n);
        run_world(&w, variant, &r);
        take_bounds(dim, &r, &plain);
        for (int q = 0; q < QUANTITIES; q++) {
          const double error = largest_error(r.q[q], plain.q[q], 3 * (int64_t)r.n);
          const double bound = variant->is_double ? 1e-11 : 5e-6;
          if (!(error < bound))
            printf("\n%dD, %s, setting %d, %d lanes, %s, %s:", dim,
                   sph_kernel_name((sph_kernel_type)type), setting, variant->lanes,
                   variant->is_double ? "double" : "float", quantity_names[q]);
          SPH_TEST_BELOW(error, bound);
          if (!(error <= worst[variant->is_double][q])) worst[variant->is_double][q] = error;
        }
        free_results(&r);
      }
      free_results(&plain);
      close_world(&w);
    }
  if (getenv("SPH_TEST_SHOW"))
    for (int q = 0; q < QUANTITIES; q++)
      printf("\nsetting %d, %s: float %.2g, double %.2g", setting, quantity_names[q], worst[0][q],
             worst[1][q]);
}

static void test_open(void) { compare_settings(OPEN); }
static void test_periodic(void) { compare_settings(PERIODIC); }

/* Error of the float variant against the plain loops, of each quantity, particles from..to-1. */
static void float_errors(int dim, int setting, int part, double *error) {
  world w;
  CU_ASSERT_FATAL(open_world(&w, dim, SPH_KERNEL_WENDLAND_C2, setting));
  const int n = w.particles->n, from = part == 2 ? n / 2 : 0, to = part == 1 ? n / 2 : n;
  results plain = new_results(n), r = new_results(n);
  plain_loops(&w, &plain);
  run_world(&w, sphi_variant_find(w.context->isa, SPH_PRECISION_SINGLE), &r);
  take_bounds(dim, &r, &plain);
  for (int q = 0; q < QUANTITIES; q++)
    error[q] = largest_error(r.q[q] + 3 * (int64_t)from, plain.q[q] + 3 * (int64_t)from,
                             3 * (int64_t)(to - from));
  free_results(&r);
  free_results(&plain);
  close_world(&w);
}

static void test_far_away(void) {
  for (int dim = 2; dim <= 3; dim++) {
    double near[QUANTITIES], shifted[QUANTITIES], here[QUANTITIES], there[QUANTITIES];
    float_errors(dim, OPEN, 0, near);
    float_errors(dim, SHIFTED, 0, shifted);
    float_errors(dim, APART, 1, here);
    float_errors(dim, APART, 2, there);
    for (int q = 0; q < QUANTITIES; q++) {
      SPH_TEST_BELOW(shifted[q], 2 * near[q] + 2e-7);
      SPH_TEST_BELOW(there[q], 2 * here[q] + 2e-7);
      SPH_TEST_BELOW(there[q], 5e-6);
      if (getenv("SPH_TEST_SHOW"))
        printf("\n%dD %s: near %.2g, at 1000 m %.2g, apart %.2g %.2g", dim, quantity_names[q],
               near[q], shifted[q], here[q], there[q]);
    }
  }
}

static void test_threads(void) {
  for (int dim = 2; dim <= 3; dim++) {
    world w;
    CU_ASSERT_FATAL(open_world(&w, dim, SPH_KERNEL_GAUSSIAN, PERIODIC));
    const sphi_variant *variant;
    for (int at = 0; (variant = next_variant(&w, &at));) {
      results one = new_results(w.particles->n), two = new_results(w.particles->n);
      SPH_TEST_OK(w.context, sph_context_set_threads(w.context, 1));
      run_world(&w, variant, &one);
      if (sph_context_set_threads(w.context, 2) == SPH_OK) {
        run_world(&w, variant, &two);
        for (int q = 0; q < QUANTITIES; q++)
          CU_ASSERT(!memcmp(one.q[q], two.q[q], sizeof(double) * 3 * (size_t)one.n));
      }
      free_results(&one);
      free_results(&two);
    }
    close_world(&w);
  }
}

static int64_t near_entries(const sphi_list *list) {
  int64_t sum = 0;
  for (int32_t c = 0; c < list->clusters; c++) sum += list->entry[c].near;
  return sum;
}

/* A number that depends on which entries a list has, not on their order. */
static uint64_t list_contents(const sphi_list *list) {
  uint64_t sum = 0;
  for (int32_t c = 0; c < list->clusters; c++) {
    const sphi_list_entry *entry = &list->entry[c];
    for (int32_t k = 0; k < entry->count; k++) {
      uint64_t state = ((uint64_t)c << 32) + list->part[entry->part].source[entry->offset + k];
      sph_test_random(&state);
      sum += state;
    }
  }
  return sum;
}

/* Convective sums of all particles as the lists are now: [4][n] reals. */
static void run_rates(const world *w, engine *e, void *sums) {
  const size_t size = e->variant->real_size * (size_t)w->particles->n;
  sphi_rates_arguments a = {.divergence = (char *)sums + 3 * size,
                            .record = e->record,
                            .m = w->particles->field[SPHI_M].data[0]};
  for (int d = 0; d < w->dim; d++) a.acceleration[d] = (char *)sums + (size_t)d * size;
  sphi_sweep_run(w->context, e->variant, SPHI_OPERATOR_rates, &e->sweep, &a);
}

/* What is left out adds exactly nothing, what is kept stays in order: the sums keep their bits. */
static void check_pruning(const world *w, const sphi_variant *variant, double radius) {
  engine e;
  open_engine(w, variant, &e);
  const double support = sph_kernel_get_support(w->kernel);
  const int n = w->particles->n;
  SPH_TEST_OK(w->context, sphi_list_build(w->context, &e.list, &w->frame, &e.clusters, &w->columns,
                                          radius * support));
  SPH_TEST_OK(w->context, sphi_list_build(w->context, &e.ghost_list, &w->frame, &e.clusters,
                                          &w->ghost_columns, 1.4 * support));
  double *all = new_numbers(4 * n), *pruned = new_numbers(4 * n), *unused = new_numbers(n);
  run_rates(w, &e, all);
  const uint64_t contents = list_contents(&e.list), ghosts = list_contents(&e.ghost_list);
  const int64_t full = near_entries(&e.list), full_ghosts = near_entries(&e.ghost_list);
  sphi_gradient_arguments gradient = {NULL, unused, NULL, 0};
  int64_t before = 0;
  for (int k = 0; k < 3; k++) {
    e.sweep.prune = (1 + 0.1 * k) * support;
    sphi_sweep_run(w->context, variant, SPHI_OPERATOR_gradient, &e.sweep, &gradient);
    run_rates(w, &e, pruned);
    CU_ASSERT(!memcmp(all, pruned, 4 * sizeof(double) * (size_t)n));
    CU_ASSERT(near_entries(&e.list) >= before && near_entries(&e.list) < full);
    CU_ASSERT(near_entries(&e.ghost_list) < full_ghosts);
    CU_ASSERT(list_contents(&e.list) == contents && list_contents(&e.ghost_list) == ghosts);
    before = near_entries(&e.list);
  }
  free(all);
  free(pruned);
  free(unused);
  close_engine(w, &e);
}

static void test_pruning(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (int setting = OPEN; setting <= PERIODIC; setting++) {
      world w;
      CU_ASSERT_FATAL(open_world(&w, dim, SPH_KERNEL_WENDLAND_C2, setting));
      const sphi_variant *variant;
      for (int at = 0; (variant = next_variant(&w, &at));) {
        check_pruning(&w, variant, 1.4);
        /* More far entries than can be put aside at once. */
        if (setting == OPEN) check_pruning(&w, variant, 20);
      }
      close_world(&w);
    }
}

static void test_subset(void) {
  world w;
  CU_ASSERT_FATAL(open_world(&w, 3, SPH_KERNEL_WENDLAND_C4, OPEN));
  const sphi_variant *variant = sphi_variant_find(w.context->isa, SPH_PRECISION_SINGLE);
  engine e;
  open_engine(&w, variant, &e);
  const int n = w.particles->n, clusters = e.clusters.n;
  float *all = calloc((size_t)n, sizeof *all), *some = calloc((size_t)n, sizeof *some);
  int32_t *subset = calloc((size_t)clusters, sizeof *subset);
  CU_ASSERT_FATAL(all != NULL && some != NULL && subset != NULL);
  sphi_gradient_arguments a = {NULL, all, NULL, 0};
  sphi_sweep_run(w.context, variant, SPHI_OPERATOR_gradient, &e.sweep, &a);
  for (int c = clusters - 1; c >= 0; c -= 3) subset[e.sweep.subset_count++] = c;
  for (int i = 0; i < n; i++) some[i] = -1e30f;
  e.sweep.subset = subset;
  a.divergence = some;
  sphi_sweep_run(w.context, variant, SPHI_OPERATOR_gradient, &e.sweep, &a);
  int wrong = 0;
  for (int c = 0; c < clusters; c++)
    for (int l = 0; l < e.clusters.count[c]; l++) {
      const int i = e.clusters.first[c] + l;
      wrong += (clusters - 1 - c) % 3 == 0 ? some[i] != all[i] : some[i] != -1e30f;
    }
  CU_ASSERT_EQUAL(wrong, 0);
  free(all);
  free(some);
  free(subset);
  close_engine(&w, &e);
  close_world(&w);
}

/* Points of one set against clusters of another: counts sources that are missing, listed twice, or
 * farther from the box than the radius. */
static void count_list_faults(const world *w, const engine *e, const sphi_list *list, int n,
                              double *const *y, const int32_t *order, double radius, int *missing,
                              int *twice, int *far) {
  double *const *x = w->particles->field[SPHI_X].data;
  int *times = calloc((size_t)n + 1, sizeof *times);
  CU_ASSERT_FATAL(times != NULL);
  for (int c = 0; c < e->clusters.n; c++) {
    const sphi_list_entry entry = list->entry[c];
    const uint32_t *near = list->part[entry.part].source + entry.offset;
    for (int k = 0; k < entry.count; k++) times[near[k]]++;
    for (int place = 0; place < n; place++) {
      const int j = order ? order[place] : place;
      bool inside = false;
      double box2 = 0;
      for (int l = 0; l < e->clusters.count[c]; l++) {
        double r2 = 0;
        for (int d = 0; d < w->dim; d++) {
          const double dx = difference(w, d, x[d][e->clusters.first[c] + l], y[d][j]);
          r2 += dx * dx;
        }
        inside = inside || sqrt(r2) < radius;
      }
      for (int d = 0; d < w->dim; d++) {
        const double lo = e->clusters.lo[w->dim * c + d], hi = e->clusters.hi[w->dim * c + d];
        const double away = fabs(difference(w, d, y[d][j], 0.5 * (lo + hi))) - 0.5 * (hi - lo);
        box2 += away > 0 ? away * away : 0;
      }
      *missing += inside && !times[place];
      *twice += times[place] > 1;
      *far += times[place] && sqrt(box2) > radius * (1 + 1e-5);
      times[place] = 0;
    }
  }
  free(times);
}

/* Stacked: at equal places as fixed point sees them, which repeats every 256 radii. */
typedef enum placing { SPREAD, CLUMPED, STACKED } placing;

static void check_lists(int dim, int mask, double size, double width, int threads, placing places) {
  const double radius = 0.5;
  world w;
  memset(&w, 0, sizeof w);
  CU_ASSERT_FATAL(sph_context_create(&w.context) == SPH_OK);
  if (sph_context_set_threads(w.context, threads) != SPH_OK) threads = 1;
  w.dim = dim;
  w.dx = 1e-6;
  CU_ASSERT_FATAL(make_kernel(&w, SPH_KERNEL_WENDLAND_C2, radius / 2));
  double x[3 * 120];
  uint64_t state = (uint64_t)(mask + 10 * dim);
  const double zero[3] = {-0.2, -0.2, -0.2}, end[3] = {size + 0.2, size + 0.2, size + 0.2};
  for (int k = 0; k < 120 * dim; k++) {
    const double u = sph_test_random(&state);
    x[k] = places == CLUMPED ? (k % 7 == 0 ? 0 : size) + 1e-3 * (u - 0.5) : size * (1.1 * u - 0.05);
    if (places == CLUMPED && k % 11 == 0) x[k] = k % 2 ? -0.5 * size : 30 * size;
    if (places == STACKED && k % dim == dim - 1) x[k] += 256 * radius * (k / dim % 3);
  }
  for (int d = 0; d < dim; d++)
    if (mask >> d & 1) {
      w.periodic[d] = true;
      w.lo[d] = 0;
      w.hi[d] = size;
    }
  add_fluid(&w, 120, x);
  add_ghosts(&w, 90, zero, end);
  sort_world(&w, width);
  const sphi_variant *variant;
  for (int at = 0; (variant = next_variant(&w, &at));) {
    engine e;
    open_engine(&w, variant, &e);
    int missing = 0, twice = 0, far = 0;
    count_list_faults(&w, &e, &e.list, 120, w.particles->field[SPHI_X].data, NULL, radius, &missing,
                      &twice, &far);
    count_list_faults(&w, &e, &e.ghost_list, 90, w.ghosts.x, w.ghost_columns.order, radius,
                      &missing, &twice, &far);
    if (missing || twice || far)
      printf("\n%dD, periodic %d, size %g, width %g, %d lanes: %d missing, %d twice, %d far", dim,
             mask, size, width, variant->lanes, missing, twice, far);
    CU_ASSERT(missing == 0 && twice == 0 && far == 0);
    close_engine(&w, &e);
  }
  close_world(&w);
}

static void test_lists(void) {
  const double sizes[] = {1, 1.01, 1.3, 1.52, 4};
  for (int dim = 2; dim <= 3; dim++)
    for (int mask = 0; mask < 1 << dim; mask++)
      for (int k = 0; k < 5; k++) {
        const double width = k == 0 ? 0.5 : k == 1 ? 0.2 : k == 2 ? 0.25 : k == 3 ? 0.5 : 0.11;
        check_lists(dim, mask, sizes[k], width, 1 + (k == 1 && mask == 1), SPREAD);
        if (k == 2 || k == 3)
          check_lists(dim, mask, sizes[k], width, 1 + (k == 3 && mask == 2), CLUMPED);
        if (!(mask >> (dim - 1) & 1)) check_lists(dim, mask, sizes[k], width, 1, STACKED);
      }
}

/* ------------------------------------------------------------------------------------- sorting */

/* Points and what is made of them. */
typedef struct sorted {
  int dim, n;
  bool periodic;
  double *x[3];
  int32_t *rank;
  sphi_frame frame;
  sphi_columns columns;
  sphi_clusters clusters;
  sphi_list list;
} sorted;

enum { MANY = 20000 };
static const double column_width = 0.03125;

/* Random points in a box of length 1, many of them at equal heights. */
static sorted new_sorted(int dim, bool periodic) {
  sorted s = {.dim = dim, .n = MANY, .periodic = periodic};
  uint64_t state = 99;
  for (int d = 0; d < dim; d++) {
    s.x[d] = new_numbers(MANY);
    for (int i = 0; i < MANY; i++)
      s.x[d][i] = d < dim - 1 ? sph_test_random(&state) : floor(64 * sph_test_random(&state)) / 64;
  }
  s.rank = calloc(MANY, sizeof *s.rank);
  CU_ASSERT_FATAL(s.rank != NULL);
  for (int i = 0; i < MANY; i++) s.rank[i] = (i * 7919 + 11) % MANY;
  return s;
}

static void forget_sort(sph_context *context, sorted *s) {
  sphi_columns_free(context, &s->columns);
  sphi_clusters_free(context, &s->clusters);
  sphi_list_free(context, &s->list);
}

static void free_sorted(sph_context *context, sorted *s) {
  forget_sort(context, s);
  for (int d = 0; d < 3; d++) free(s->x[d]);
  free(s->rank);
}

static sph_status sort_all(sph_context *context, sorted *s) {
  const bool periodic[3] = {s->periodic, false, s->periodic};
  const double lo[3] = {0, 0, 0}, hi[3] = {1, 1, 1}, radius = 0.04;
  sphi_frame_set(&s->frame, s->dim, lo, radius, periodic, lo, hi);
  sph_status status = sphi_columns_build(context, &s->columns, &s->frame, column_width, s->n, s->x,
                                         s->rank, "points");
  if (status == SPH_OK)
    status = sphi_clusters_build(context, &s->clusters, &s->columns, &s->frame, s->x, 8, radius);
  if (status == SPH_OK)
    status = sphi_list_build(context, &s->list, &s->frame, &s->clusters, &s->columns, radius);
  return status;
}

/* Everything in order of column, height and rank, and every column where it can be found. */
static int count_sort_faults(const sorted *s) {
  const sphi_columns *columns = &s->columns;
  int faults = columns->start[0] != 0 || columns->start[columns->columns] != s->n;
  int *times = calloc((size_t)s->n, sizeof *times);
  CU_ASSERT_FATAL(times != NULL);
  for (int c = 0; c < columns->columns; c++) {
    const int32_t *key = columns->key + 2 * c;
    faults += sphi_columns_find(columns, key[0], key[1]) != c;
    faults += columns->start[c] >= columns->start[c + 1];
    if (c > 0) faults += !(key[-2] < key[0] || (key[-2] == key[0] && key[-1] < key[1]));
    for (int k = columns->start[c]; k < columns->start[c + 1]; k++) {
      const int i = columns->order[k];
      times[i]++;
      for (int d = 0; d < s->dim - 1; d++)
        faults += (int)floor(sphi_frame_wrap(&s->frame, d, s->x[d][i]) / column_width) != key[d];
      for (int d = 0; d < s->dim; d++)
        faults += columns->fixed[d][k] != sphi_frame_fix(&s->frame, d, s->x[d][i]);
      faults += columns->z[k] != sphi_frame_wrap(&s->frame, s->dim - 1, s->x[s->dim - 1][i]);
      if (k == columns->start[c]) continue;
      const double below = columns->z[k - 1];
      faults += below > columns->z[k] ||
                (below == columns->z[k] && s->rank[columns->order[k - 1]] > s->rank[i]);
    }
  }
  for (int i = 0; i < s->n; i++) faults += times[i] != 1;
  free(times);
  faults += sphi_columns_find(columns, 123456, 0) != -1 || sphi_columns_find(columns, 0, -99) != -1;
  return faults;
}

static int count_differences(const sorted *a, const sorted *b) {
  int different = a->columns.columns != b->columns.columns || a->clusters.n != b->clusters.n ||
                  a->list.total != b->list.total;
  if (different) return different;
  const size_t n = (size_t)a->n, clusters = (size_t)a->clusters.n;
  different += !!memcmp(a->columns.order, b->columns.order, n * sizeof(int32_t));
  different += !!memcmp(a->columns.z, b->columns.z, n * sizeof(double));
  different += !!memcmp(a->clusters.first, b->clusters.first, clusters * sizeof(int32_t));
  different += !!memcmp(a->clusters.count, b->clusters.count, clusters * sizeof(int32_t));
  different += !!memcmp(a->clusters.lo, b->clusters.lo, clusters * (size_t)a->dim * sizeof(double));
  different += !!memcmp(a->clusters.hi, b->clusters.hi, clusters * (size_t)a->dim * sizeof(double));
  for (int c = 0; c < a->clusters.n; c++) {
    const sphi_list_entry ea = a->list.entry[c], eb = b->list.entry[c];
    different += ea.count != eb.count || memcmp(a->list.part[ea.part].source + ea.offset,
                                                b->list.part[eb.part].source + eb.offset,
                                                (size_t)ea.count * sizeof(uint32_t));
  }
  return different;
}

static void test_sort(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (int setting = 0; setting < 3; setting++) { /* open, periodic, with two points far away */
      sph_context *context = NULL;
      CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
      sorted one = new_sorted(dim, setting == 1), other = new_sorted(dim, setting == 1);
      for (int k = 0; k < 2 && setting == 2; k++)
        one.x[0][7 + k] = other.x[0][7 + k] = 9e5 - k * 3e6;
      for (int threads = 1; threads <= 3; threads++)
        for (sph_isa isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
          if (sph_context_set_isa(context, isa) != SPH_OK) continue;
          SPH_TEST_OK(context, sph_context_set_threads(context, 1));
          SPH_TEST_OK(context, sort_all(context, &one));
          CU_ASSERT_EQUAL(count_sort_faults(&one), 0);
          if (sph_context_set_threads(context, threads) != SPH_OK) continue;
          SPH_TEST_OK(context, sort_all(context, &other));
          CU_ASSERT_EQUAL(count_differences(&one, &other), 0);
        }
      free_sorted(context, &one);
      free_sorted(context, &other);
      sph_context_destroy(&context);
    }
}

/* Sorts over and over what moves, leaves for far away and comes back: as a first sort of the same. */
static void test_sort_again(void) {
  for (int dim = 2; dim <= 3; dim++) {
    sph_context *context = NULL;
    CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
    if (sph_context_set_threads(context, 2) != SPH_OK)
      SPH_TEST_OK(context, sph_context_set_threads(context, 1));
    sorted again = new_sorted(dim, false);
    for (int round = 0; round < 8; round++) {
      const double move[] = {0, 0.01, 0.3, 5, 1e6, 0, -2, 0};
      again.n = round == 5 ? 100 : round == 6 ? 0 : MANY;
      for (int i = 0; i < MANY; i += round % 2 ? 1 : 5) again.x[0][i] += move[round];
      if (round == 4) again.x[dim - 1][3] -= 2e6;
      SPH_TEST_OK(context, sort_all(context, &again));
      if (again.n == 0) {
        CU_ASSERT(again.columns.columns == 0 && sphi_columns_find(&again.columns, 0, 0) == -1);
        continue;
      }
      CU_ASSERT_EQUAL(count_sort_faults(&again), 0);
      sorted first = again;
      first.columns = (sphi_columns){0};
      first.clusters = (sphi_clusters){0};
      first.list = (sphi_list){0};
      SPH_TEST_OK(context, sort_all(context, &first));
      CU_ASSERT_EQUAL(count_differences(&first, &again), 0);
      forget_sort(context, &first);
    }
    free_sorted(context, &again);
    sph_context_destroy(&context);
  }
}

typedef struct purse {
  int left; /* allocations that succeed; negative: all */
  int held;
} purse;

static void *purse_allocate(size_t bytes, void *user) {
  purse *money = user;
  if (money->left == 0) return NULL;
  void *block = malloc(bytes);
  if (money->left > 0) money->left--;
  money->held += block != NULL;
  return block;
}

static void purse_release(void *block, void *user) {
  ((purse *)user)->held -= block != NULL;
  free(block);
}

/* Fails at the first, second ... allocation of a sort; the next sort, with memory, is right. */
static void test_no_memory(void) {
  for (int far = 0; far < 2; far++) {
    purse money = {-1, 0};
    const sph_allocator allocator = {purse_allocate, purse_release, &money};
    sph_context *context = NULL;
    CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &context) == SPH_OK);
    if (sph_context_set_threads(context, 2) != SPH_OK)
      SPH_TEST_OK(context, sph_context_set_threads(context, 1));
    const int before = money.held;
    sorted s = new_sorted(3, false);
    if (far) s.x[0][5] = 2e6; /* columns are found by hash */
    sph_status status = SPH_E_MEMORY;
    int failures = 0;
    while (status != SPH_OK && failures < 100) {
      money.left = failures;
      status = sort_all(context, &s);
      money.left = -1;
      if (status == SPH_OK) break;
      failures++;
      CU_ASSERT_EQUAL(status, SPH_E_MEMORY);
      CU_ASSERT(strstr(sph_context_message(context), "no memory") != NULL);
      SPH_TEST_OK(context, sort_all(context, &s));
      CU_ASSERT_EQUAL(count_sort_faults(&s), 0);
      forget_sort(context, &s);
      CU_ASSERT_EQUAL(money.held, before);
    }
    CU_ASSERT(failures > 12 && failures < 100);
    CU_ASSERT_EQUAL(count_sort_faults(&s), 0);
    free_sorted(context, &s);
    CU_ASSERT_EQUAL(money.held, before);
    sph_context_destroy(&context);
    CU_ASSERT_EQUAL(money.held, 0);
  }
}

/* Nothing moves, some particles change sides of the middle, everything does, with any threads; and
 * without memory for what threads take from one another. */
static void test_permute(void) {
  purse money = {-1, 0};
  const sph_allocator allocator = {purse_allocate, purse_release, &money};
  for (int threads = 1; threads <= 3; threads++)
    for (int kind = 0; kind < 4; kind++) {
      sph_context *context = NULL;
      CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &context) == SPH_OK);
      if (sph_context_set_threads(context, threads) == SPH_OK) {
        sph_particles *particles = NULL;
        SPH_TEST_OK(context, sph_particles_create(context, 2, 1e-3, &particles));
        double *x = new_numbers(2 * MANY);
        for (int i = 0; i < 2 * MANY; i++) x[i] = i;
        SPH_TEST_OK(context, sph_particles_add(particles, MANY, x, 1000, NULL));
        sph_index *order = calloc(MANY, sizeof *order);
        CU_ASSERT_FATAL(order != NULL);
        for (int k = 0; k < MANY; k++) {
          const int other = kind == 3 ? MANY - 1 - k : k % 50 == 0 ? MANY - 50 - k : k;
          order[k] = kind == 0 ? k : other;
        }
        if (kind == 2) money.left = 0;
        sphi_particles_permute(particles, order);
        money.left = -1;
        int wrong = 0;
        for (int k = 0; k < MANY; k++) {
          wrong += particles->id[k] != order[k] || particles->rank[k] != order[k];
          wrong += particles->slot[order[k]] != k;
          for (int d = 0; d < 2; d++)
            wrong += particles->field[SPHI_X].data[d][k] != x[2 * order[k] + d];
          wrong += particles->field[SPHI_RHO].data[0][k] != 1000;
        }
        CU_ASSERT_EQUAL(wrong, 0);
        free(order);
        free(x);
        sph_particles_destroy(&particles);
      }
      sph_context_destroy(&context);
      CU_ASSERT_EQUAL(money.held, 0);
    }
}

static void test_narrow_columns(void) {
  world w;
  CU_ASSERT_FATAL(open_world(&w, 3, SPH_KERNEL_WENDLAND_C2, OPEN));
  const double support = sph_kernel_get_support(w.kernel);
  sort_world(&w, support / 16);
  sphi_clusters clusters = {0};
  sphi_list list = {0};
  SPH_TEST_OK(w.context, sphi_clusters_build(w.context, &clusters, &w.columns, &w.frame,
                                             w.particles->field[SPHI_X].data, 8, support));
  SPH_TEST_STATUS(w.context,
                  sphi_list_build(w.context, &list, &w.frame, &clusters, &w.columns, 4 * support),
                  SPH_E_INTERNAL, "too narrow for neighbour lists");
  sphi_list_free(w.context, &list);
  sphi_clusters_free(w.context, &clusters);
  close_world(&w);
}

static void test_momentum(void) {
  for (int dim = 2; dim <= 3; dim++)
    for (int type = 1; type < SPH_KERNEL_USER; type++) {
      world w;
      CU_ASSERT_FATAL(open_world(&w, dim, type, OPEN));
      w.ghosts.n = 0;
      const sphi_variant *variant;
      for (int at = 0; (variant = next_variant(&w, &at));) {
        if (!variant->is_double) continue;
        results r = new_results(w.particles->n);
        run_world(&w, variant, &r);
        for (int q = PRESSURE; q <= TOTAL; q++)
          for (int d = 0; d < dim; d++) {
            double sum = 0, size = 0;
            for (int i = 0; i < r.n; i++) {
              const double force =
                  w.particles->field[SPHI_M].data[0][w.particles->slot[i]] * r.q[q][3 * i + d];
              sum += force;
              size += fabs(force);
            }
            SPH_TEST_BELOW(fabs(sum), 1e-14 * size);
            CU_ASSERT(size > 0);
          }
        free_results(&r);
      }
      close_world(&w);
    }
}

static void test_linear_density(void) {
  const double slope[3] = {120, -310, 55};
  for (int dim = 2; dim <= 3; dim++)
    for (int type = 1; type < SPH_KERNEL_USER; type++) {
      world w;
      CU_ASSERT_FATAL(open_world(&w, dim, type, OPEN));
      w.lambda_min = 1e-3; /* at corners too */
      results quadratic = new_results(w.particles->n);
      sphi_field *field = w.particles->field;
      const int n = w.particles->n;
      double *rho = field[SPHI_RHO].data[0];
      for (int power = 2; power >= 1;
           power--) { /* a curved density gives the scale of the diffusion */
        for (int i = 0; i < n; i++) {
          double at = 0;
          for (int d = 0; d < dim; d++) at += slope[d] * field[SPHI_X].data[d][i];
          rho[i] = rho0 + at + (power == 2 ? 0.01 * at * at : 0);
        }
        if (power == 2) run_world(&w, sphi_variant_reference(), &quadratic);
      }
      const sphi_variant *variant;
      for (int at = 0; (variant = next_variant(&w, &at));) {
        results r = new_results(n);
        run_world(&w, variant, &r);
        double error = 0, diffusion = 0, scale = 0, least = 1;
        for (int i = 0; i < n; i++) {
          least = fmin(least, r.q[LAMBDA][3 * i]);
          for (int d = 0; d < dim; d++)
            error = fmax(error, fabs(r.q[GRADIENT][3 * i + d] - slope[d]));
          diffusion = fmax(diffusion, fabs(r.q[DIFFUSION][3 * i]));
          scale = fmax(scale, fabs(quadratic.q[DIFFUSION][3 * i]));
        }
        CU_ASSERT(least > w.lambda_min); /* or gradients were set to zero on purpose */
        SPH_TEST_BELOW(error / 310, variant->is_double ? 1e-10 : 2e-5);
        SPH_TEST_BELOW(diffusion / scale, variant->is_double ? 1e-10 : 2e-4);
        free_results(&r);
      }
      free_results(&quadratic);
      close_world(&w);
    }
}

/* Largest errors of gradient and divergence on a lattice, everywhere and in the middle. */
static void lattice_errors(int dim, int side, double *edge_gradient, double *gradient,
                           double *divergence) {
  world w;
  memset(&w, 0, sizeof w);
  CU_ASSERT_FATAL(sph_context_create(&w.context) == SPH_OK);
  w.dim = dim;
  w.dx = 1.0 / side;
  CU_ASSERT_FATAL(make_kernel(&w, SPH_KERNEL_QUINTIC_SPLINE, 2 * w.dx));
  double *x = new_numbers(3 * (int64_t)side * side * (dim == 3 ? side : 1));
  const int n = lattice(dim, side, w.dx, 0, NULL, x);
  add_fluid(&w, n, x);
  for (int i = 0; i < n; i++) {
    const double *at = x + i * dim;
    w.particles->field[SPHI_RHO].data[0][i] = rho0 + exp(at[0]) * sin(2 * at[dim - 1]);
    w.particles->field[SPHI_VOL].data[0][i] = pow(w.dx, dim);
    w.particles->field[SPHI_V].data[0][i] = sin(2 * at[0]) + at[1];
    w.particles->field[SPHI_V].data[1][i] = cos(2 * at[1]) * at[0];
    if (dim == 3) w.particles->field[SPHI_V].data[2][i] = exp(at[2]);
  }
  sort_world(&w, 0.5 * sph_kernel_get_support(w.kernel));
  results r = new_results(n);
  run_world(&w, sphi_variant_find(w.context->isa, SPH_PRECISION_DOUBLE), &r);
  *edge_gradient = *gradient = *divergence = 0;
  for (int i = 0; i < n; i++) {
    const double *at = x + i * dim;
    double exact[3] = {exp(at[0]) * sin(2 * at[dim - 1]), 0, 0}, error = 0, middle = 0;
    exact[dim - 1] = 2 * exp(at[0]) * cos(2 * at[dim - 1]);
    for (int d = 0; d < dim; d++) {
      error = fmax(error, fabs(r.q[GRADIENT][3 * i + d] - exact[d]));
      middle = fmax(middle, fabs(at[d] - 0.5));
    }
    *edge_gradient = fmax(*edge_gradient, error);
    if (middle > 0.1) continue;
    const double exact_divergence =
        2 * cos(2 * at[0]) - 2 * sin(2 * at[1]) * at[0] + (dim == 3 ? exp(at[2]) : 0);
    *gradient = fmax(*gradient, error);
    *divergence = fmax(*divergence, fabs(r.q[DIVERGENCE][3 * i] - exact_divergence));
  }
  free_results(&r);
  free(x);
  close_world(&w);
}

static void test_convergence(void) {
  for (int dim = 2; dim <= 3; dim++) {
    double coarse[3], fine[3], order[3];
    lattice_errors(dim, 16, &coarse[0], &coarse[1], &coarse[2]);
    lattice_errors(dim, 32, &fine[0], &fine[1], &fine[2]);
    for (int k = 0; k < 3; k++) order[k] = log2(coarse[k] / fine[k]);
    if (getenv("SPH_TEST_SHOW"))
      printf("\n%dD orders: gradient near edges %.2f, inside %.2f, divergence %.2f", dim, order[0],
             order[1], order[2]);
    SPH_TEST_BELOW(0.9, order[0]);
    SPH_TEST_BELOW(1.85, order[1]);
    SPH_TEST_BELOW(1.85, order[2]);
  }
}

static void test_not_finite(void) {
  sph_context *context = NULL;
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  const double bad[] = {NAN, INFINITY, -INFINITY, 1e300, 2e9};
  const double lo[2] = {0, 0}, hi[2] = {4, 4}, origin[2] = {0, 0};
  for (int mask = 0; mask < 4; mask++)
    for (int axis = 0; axis < 2; axis++)
      for (int k = 0; k < 5; k++) {
        double x0[3] = {0.5, 1, 3}, x1[3] = {0.5, 1, 3};
        double *x[2] = {x0, x1};
        x[axis][1] = bad[k];
        const bool periodic[2] = {mask & 1, mask & 2};
        sphi_frame frame;
        sphi_columns columns = {0};
        sphi_frame_set(&frame, 2, origin, 1, periodic, lo, hi);
        SPH_TEST_STATUS(context,
                        sphi_columns_build(context, &columns, &frame, 1, 3, x, NULL, "fluid"),
                        SPH_E_DIVERGED, "fluid: point 1 at (");
        sphi_columns_free(context, &columns);
      }
  sph_context_destroy(&context);
}

static void test_wrap(void) {
  sphi_frame frame;
  const bool periodic[2] = {true, true};
  uint64_t state = 5;
  int outside = 0;
  for (int k = 0; k < 20000; k++) {
    const double lo[2] = {sph_test_random(&state) - 0.5, 0};
    const double hi[2] = {lo[0] + 0.1 + sph_test_random(&state), 1};
    sphi_frame_set(&frame, 2, lo, 0.05, periodic, lo, hi);
    double x = lo[0] + floor(7 * sph_test_random(&state) - 3) * frame.length[0];
    for (int step = 0; step < 3; step++, x = nextafter(x, -HUGE_VAL)) {
      const double y = sphi_frame_wrap(&frame, 0, x);
      outside += !(y >= lo[0] && y < lo[0] + frame.length[0]);
    }
  }
  CU_ASSERT_EQUAL(outside, 0);
}

static void test_search_after_sort(void) {
  world w;
  CU_ASSERT_FATAL(open_world(&w, 2, SPH_KERNEL_WENDLAND_C2, OPEN));
  sph_search *search = NULL;
  SPH_TEST_OK(w.context, sph_search_create(w.context, w.particles, 0.1, &search));
  SPH_TEST_OK(w.context, sph_search_update(search));
  sph_index before[64], after[64];
  double distance[64];
  int64_t count = 0, again = 0;
  SPH_TEST_OK(w.context, sph_search_find_near_particle(search, 40, 64, before, distance, &count));
  /* A sort is no change for the caller: ids keep their neighbours. */
  sph_index *order = calloc((size_t)w.particles->n, sizeof *order);
  CU_ASSERT_FATAL(order != NULL);
  for (int k = 0; k < w.particles->n; k++) order[k] = w.particles->n - 1 - k;
  sphi_particles_permute(w.particles, order);
  free(order);
  for (int update = 0; update < 2; update++) {
    if (update) SPH_TEST_OK(w.context, sph_search_update(search));
    SPH_TEST_OK(w.context, sph_search_find_near_particle(search, 40, 64, after, distance, &again));
    CU_ASSERT(count == again && count > 10 &&
              !memcmp(before, after, (size_t)count * sizeof *before));
  }
  /* A caller cannot write NaN, but a run that diverges can. */
  for (int method = 0; method < 2; method++) {
    SPH_TEST_OK(w.context, sph_search_set_method(search, (sph_search_method)method));
    double *x = &w.particles->field[SPHI_X].data[1][w.particles->slot[7]];
    const double old = *x;
    *x = NAN;
    SPH_TEST_STATUS(w.context, sph_search_update(search), SPH_E_DIVERGED, "particle 7 at (");
    SPH_TEST_STATUS(w.context, sph_search_update(search), SPH_E_DIVERGED, "is not finite");
    *x = old;
    SPH_TEST_OK(w.context, sph_search_update(search));
  }
  sph_search_destroy(&search);
  close_world(&w);
}

SPH_TEST_MAIN("sweep",
              {"lists hold every pair within the radius, once, periodic or not, from 2 columns on",
               test_lists},
              {"sorts and lists are the same with any number of threads", test_sort},
              {"a sort does not depend on sorts before", test_sort_again},
              {"a sort without memory says so, leaks nothing, and can be repeated", test_no_memory},
              {"permuting with any number of threads moves every value", test_permute},
              {"columns too narrow for a list are refused", test_narrow_columns},
              {"operators equal plain loops: free surface, every kernel and variant", test_open},
              {"operators equal plain loops: periodic, every kernel and variant", test_periodic},
              {"float errors do not grow far from the origin or far apart", test_far_away},
              {"1 and 2 threads give the same bits", test_threads},
              {"a subset of the clusters gets the same values, others nothing", test_subset},
              {"pruned lists give the same bits and lose nothing", test_pruning},
              {"internal forces sum to zero", test_momentum},
              {"a linear density has an exact gradient and does not diffuse", test_linear_density},
              {"gradient and divergence converge", test_convergence},
              {"points that are not finite or too far are named", test_not_finite},
              {"wrapped coordinates are inside the box", test_wrap},
              {"a search does not notice sorts, and names lost particles", test_search_after_sort})
