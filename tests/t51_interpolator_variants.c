/* Interpolators from the inside: every variant of the pair loops against the scalar reference. */
#include "any_interpolator.h"
#include "interpolator/gather_impl.h"
#include "particles/particles_impl.h"

enum { POINTS = 200 };

typedef struct setup {
  sph_context *context;
  sph_particles *particles;
  sph_kernel *kernel;
  sph_interpolator *interpolator;
  int dim;
  double at[3 * POINTS], reference[POINTS], values[POINTS];
  int reference_rungs[POINTS], rungs[POINTS];
} setup;

static const double dx = 0.01;
static const double gradient[3] = {0, -9810, 0};

/* A jittered block with a pressure of 2 kPa or so; points inside, near its sides, and outside. */
static void set_up(setup *s, int dim) {
  memset(s, 0, sizeof *s);
  s->dim = dim;
  SPH_TEST_OK(NULL, sph_context_create(&s->context));
  SPH_TEST_OK(s->context, sph_particles_create(s->context, dim, dx, &s->particles));
  const int side = dim == 2 ? 40 : 14;
  const double lo[3] = {0, 0, 0}, hi[3] = {side * dx, side * dx, side * dx};
  SPH_TEST_OK(s->context, sph_particles_fill_box(s->particles, lo, hi, 1000));
  const int64_t n = sph_particles_count(s->particles);
  double *x, *p;
  uint64_t seed = 11;
  SPH_TEST_OK(s->context, sph_particles_lease_write(s->particles, SPH_POSITION, &x));
  SPH_TEST_OK(s->context, sph_particles_lease_write(s->particles, SPH_PRESSURE, &p));
  for (int64_t k = 0; k < n * dim; k++) x[k] += 0.4 * dx * (sph_test_random(&seed) - 0.5);
  for (int64_t k = 0; k < n; k++) p[k] = 3000 - 9810 * x[k * dim + 1] + 300 * sin(30 * x[k * dim]);
  SPH_TEST_OK(s->context, sph_particles_release(s->particles, x));
  SPH_TEST_OK(s->context, sph_particles_release(s->particles, p));
  for (int k = 0; k < POINTS * dim; k++)
    s->at[k] = side * dx * (1.4 * sph_test_random(&seed) - 0.2);
  SPH_TEST_OK(s->context,
              sph_kernel_create(s->context, SPH_KERNEL_GAUSSIAN, dim, 1.3 * dx, &s->kernel));
}

static void take_down(setup *s) {
  sph_interpolator_destroy(&s->interpolator);
  sph_kernel_destroy(&s->kernel);
  sph_particles_destroy(&s->particles);
  sph_context_destroy(&s->context);
}

static void evaluate(setup *s, const sphi_variant *variant, bool compensated, double *values,
                     int *rungs) {
  const char *const names[] = {SPH_PRESSURE};
  const sphi_evaluation evaluation = {.source = s->particles,
                                      .points = POINTS,
                                      .at = s->at,
                                      .fields = 1,
                                      .names = names,
                                      .gradient = compensated ? gradient : NULL,
                                      .values = values,
                                      .rungs = rungs};
  SPH_TEST_OK(s->context, sphi_interpolator_evaluate(s->interpolator, variant, &evaluation));
}

static void variants_agree_with_the_scalar_reference(void) {
  for (int dim = 2; dim <= 3; dim++) {
    setup s;
    set_up(&s, dim);
    for (int k = 0; k < 2 * sph_interpolator_count(); k++) {
      const bool compensated = k % 2;
      sph_interpolator_destroy(&s.interpolator);
      any_create(s.context, (int)sph_interpolator_at(k / 2), s.kernel, &s.interpolator);
      evaluate(&s, sphi_variant_reference(), compensated, s.reference, s.reference_rungs);
      for (int isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
        if (sph_context_set_isa(s.context, (sph_isa)isa) != SPH_OK) continue;
        for (int precision = SPH_PRECISION_SINGLE; precision <= SPH_PRECISION_DOUBLE; precision++) {
          /* The quadratic fit's matrix loses more, most of all outside the particles in 3D. */
          const double single =
              sph_interpolator_at(k / 2) == SPH_INTERPOLATOR_MLS_QUADRATIC ? 5e-5 : 1e-5;
          const double bound = precision == SPH_PRECISION_DOUBLE ? 1e-12 : single;
          evaluate(&s, sphi_variant_find((sph_isa)isa, (sph_precision)precision), compensated,
                   s.values, s.rungs);
          for (int p = 0; p < POINTS; p++) {
            CU_ASSERT_EQUAL(s.rungs[p], s.reference_rungs[p]);
            SPH_TEST_CLOSE(s.values[p], s.reference[p], 0, bound * 3000);
          }
        }
      }
    }
    take_down(&s);
  }
}

static void storage_order_does_not_matter(void) {
  for (int k = 0; k < sph_interpolator_count(); k++) {
    setup s;
    set_up(&s, 2);
    any_create(s.context, (int)sph_interpolator_at(k), s.kernel, &s.interpolator);
    const sphi_variant *variant = sphi_variant_find(s.context->isa, SPH_PRECISION_SINGLE);
    evaluate(&s, variant, false, s.reference, s.reference_rungs);
    const sph_index n = s.particles->n;
    sph_index *order = malloc((size_t)n * sizeof *order);
    for (sph_index i = 0; i < n; i++) order[i] = (sph_index)((int64_t)i * 7 % n);
    CU_ASSERT_FATAL(n % 7 != 0);
    sphi_particles_permute(s.particles, order);
    free(order);
    evaluate(&s, variant, false, s.values, s.rungs);
    CU_ASSERT(memcmp(s.values, s.reference, sizeof s.values) == 0);
    CU_ASSERT(memcmp(s.rungs, s.reference_rungs, sizeof s.rungs) == 0);
    take_down(&s);
  }
}

/* Through a gather: what the boundary sees. */
static void moments_and_allocations_are_as_promised(void) {
  setup s;
  set_up(&s, 2);
  const sphi_variant *variant = sphi_variant_find(s.context->isa, SPH_PRECISION_SINGLE);
  const double support = s.kernel->support, origin[2] = {0, 0};
  double *const *x = s.particles->field[SPHI_X].data;
  sphi_frame frame;
  sphi_columns columns = {0};
  sphi_gather gather = {0};
  sphi_frame_set(&frame, 2, origin, support, NULL, NULL, NULL);
  SPH_TEST_OK(s.context, sphi_columns_build(s.context, &columns, &frame,
                                            sphi_column_width(2, variant->lanes, dx),
                                            s.particles->n, x, s.particles->rank, "test"));
  const int64_t room = (int64_t)s.particles->n + SPHI_PAD;
  float *record = calloc((size_t)(room * SPHI_RECORD(2)), sizeof *record);
  sphi_pack pack = {.frame = &frame,
                    .n = s.particles->n,
                    .stride = SPHI_RECORD(2),
                    .order = columns.order,
                    .x = {x[0], x[1]},
                    .columns = 2,
                    .record = record};
  pack.value[0] = s.particles->field[SPHI_VOL].data[0];
  pack.value[1] = s.particles->field[SPHI_P].data[0];
  sphi_pack_run(s.context, variant, &pack);
  for (int k = 0; k < 2 * sph_interpolator_count(); k++) {
    const int type = (int)sph_interpolator_at(k / 2);
    sph_interpolator_destroy(&s.interpolator);
    any_create(s.context, type, s.kernel, &s.interpolator);
    SPH_TEST_OK(s.context, sph_interpolator_set_compensation(s.interpolator, k % 2));
    SPH_TEST_OK(s.context, sphi_gather_reserve(s.context, &gather, s.interpolator, 2, POINTS,
                                               variant->real_size));
    for (int p = 0; p < POINTS; p++)
      for (int d = 0; d < 2; d++) gather.x[d][p] = s.at[2 * p + d];
    SPH_TEST_OK(s.context, sphi_gather_sort(s.context, &gather, &frame, variant, dx, support));
    SPH_TEST_OK(s.context, sphi_gather_list(s.context, &gather, &frame, s.interpolator, &columns,
                                            support * (1 + 1e-6)));
    const int64_t allocations = s.context->allocations;
    sphi_gather_evaluate(s.context, &gather, &frame, s.interpolator, variant, record);
    CU_ASSERT_EQUAL(s.context->allocations, allocations);
    evaluate(&s, sphi_variant_reference(), k % 2, s.reference, s.reference_rungs);
    const sphi_interpolation *work = &gather.work;
    int moments = 0, lower = 0;
    for (int q = 0; q < POINTS; q++) {
      const int p = gather.columns.order[q];
      double gamma = 0, value = work->value[q];
      int neighbours = 0;
      for (sph_index i = 0; i < s.particles->n; i++) {
        const double r = hypot(x[0][i] - s.at[2 * p], x[1][i] - s.at[2 * p + 1]);
        neighbours += r < support;
        gamma += dx * dx * sph_kernel_w(s.kernel, r);
      }
      for (int d = 0; d < 2; d++) value -= gradient[d] * work->moment[d * work->n + q];
      const bool moment = work->moment[q] != 0 || work->moment[work->n + q] != 0;
      CU_ASSERT_EQUAL(work->neighbours[q], neighbours);
      SPH_TEST_CLOSE(work->gamma[q], gamma, 0, 1e-6);
      CU_ASSERT_EQUAL(work->rung[q], s.reference_rungs[p]);
      SPH_TEST_CLOSE(value, s.reference[p], 0, 0.03);
      const int rung = work->rung[q];
      if (rung == SPH_INTERPOLATOR_SFDI) /* zero to rounding */
        SPH_TEST_CLOSE(hypot(work->moment[q], work->moment[work->n + q]), 0, 0, 1e-6 * support);
      else
        CU_ASSERT_EQUAL(moment, k % 2 && !any_mls(rung) && rung != 0);
      moments += moment;
      lower += rung != 0 && rung != type;
    }
    if (any_mls(type) || any_sfdi(type)) CU_ASSERT(lower > 0); /* retried */
    CU_ASSERT((moments > 0) == k % 2);
  }
  free(record);
  sphi_columns_free(s.context, &columns);
  sphi_gather_free(s.context, &gather);
  take_down(&s);
}

/* Points at a distance of R to rounding from a particle that is far off in value: Shepard's weight is
 * nothing there, on whichever side of R the arithmetic puts it. */
static void particles_at_the_rim_do_not_count(void) {
  enum { RING = 24 };
  static const sph_interpolator_type kinds[] = {SPH_INTERPOLATOR_IMPROVED_SHEPARD,
                                                SPH_INTERPOLATOR_TUNED_SHEPARD};
  setup s = {.dim = 2};
  SPH_TEST_OK(NULL, sph_context_create(&s.context));
  SPH_TEST_OK(s.context, sph_particles_create(s.context, 2, dx, &s.particles));
  SPH_TEST_OK(s.context, sph_kernel_create(s.context, SPH_KERNEL_GAUSSIAN, 2, 1.3 * dx, &s.kernel));
  double x[2 * (RING + 1)] = {0}, p[RING + 1] = {1e6};
  for (int k = 0; k < RING; k++) {
    const double angle = 2 * 3.14159265358979323846 * k / RING;
    x[2 * k + 2] = 1.4 * s.kernel->support * cos(angle);
    x[2 * k + 3] = 1.4 * s.kernel->support * sin(angle);
    p[k + 1] = 1;
  }
  SPH_TEST_OK(s.context, sph_particles_add(s.particles, RING + 1, x, 1000, NULL));
  SPH_TEST_OK(s.context, sph_particles_write(s.particles, SPH_PRESSURE, p, RING + 1));
  for (int k = 0; k < 2; k++) {
    sph_interpolator_destroy(&s.interpolator);
    any_create(s.context, (int)kinds[k], s.kernel, &s.interpolator);
    for (int turn = 0; turn < 20; turn++) {
      for (int q = 0; q < POINTS; q++) {
        const double angle = turn + 2.4 * q;
        const double r = s.kernel->support * (1 + 3e-8 * (q % 9 - 6));
        s.at[2 * q] = r * cos(angle);
        s.at[2 * q + 1] = r * sin(angle);
      }
      for (int isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
        if (sph_context_set_isa(s.context, (sph_isa)isa) != SPH_OK) continue;
        for (int precision = SPH_PRECISION_SINGLE; precision <= SPH_PRECISION_DOUBLE; precision++) {
          evaluate(&s, sphi_variant_find((sph_isa)isa, (sph_precision)precision), false, s.values,
                   s.rungs);
          for (int q = 0; q < POINTS; q++) SPH_TEST_CLOSE(s.values[q], 1, 1e-6, 0);
        }
      }
    }
  }
  take_down(&s);
}

SPH_TEST_MAIN(
    "interpolator_variants",
    {"variants agree with the scalar reference: 1e-12 in double, 1e-5 (quadratic 5e-5) in single",
     variants_agree_with_the_scalar_reference},
    {"particles at the rim of the support do not count for Shepard",
     particles_at_the_rim_do_not_count},
    {"storage order does not matter", storage_order_does_not_matter},
    {"moments, neighbours and gamma are as promised, and nothing is allocated",
     moments_and_allocations_are_as_promised})
