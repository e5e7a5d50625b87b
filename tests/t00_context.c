/* The context: versions, status codes, memory, log, threads, instruction sets, messages. By the public
 * interface alone, so that the shared library is tested by the same program. */
#define _POSIX_C_SOURCE 200809L
#include <pthread.h>

#include "sph_test.h"

/* An allocator that counts, can fail, and knows what has not come back. */
typedef struct purse {
  int64_t left; /* allocations until it fails; negative: never */
  int64_t taken, held;
} purse;

static void *purse_allocate(size_t bytes, void *user) {
  purse *from = user;
  if (from->left == 0) return NULL;
  if (from->left > 0) from->left--;
  from->taken++;
  from->held++;
  return malloc(bytes);
}

static void purse_release(void *memory, void *user) {
  purse *to = user;
  to->held--;
  free(memory);
}

static sph_allocator purse_allocator(purse *user) {
  return (sph_allocator){purse_allocate, purse_release, user};
}

static sph_context *context_new(void) {
  sph_context *context = NULL;
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  CU_ASSERT_FATAL(context != NULL);
  return context;
}

static void version_is_one(void) {
  char text[64];
  snprintf(text, sizeof text, "%d.%d.%d", SPH_VERSION_MAJOR, SPH_VERSION_MINOR, SPH_VERSION_PATCH);
  CU_ASSERT_STRING_EQUAL(sph_version(), text);
  CU_ASSERT(SPH_VERSION_GE(SPH_VERSION_MAJOR, SPH_VERSION_MINOR, SPH_VERSION_PATCH));
  CU_ASSERT(SPH_VERSION_GE(0, 0, 0));
  CU_ASSERT(!SPH_VERSION_GE(SPH_VERSION_MAJOR, SPH_VERSION_MINOR, SPH_VERSION_PATCH + 1));
  CU_ASSERT(!SPH_VERSION_GE(SPH_VERSION_MAJOR, SPH_VERSION_MINOR + 1, 0));
  CU_ASSERT(!SPH_VERSION_GE(SPH_VERSION_MAJOR + 1, 0, 0));
}

static void build_info_has_lines(void) {
  const char *info = sph_build_info();
  CU_ASSERT(strstr(info, sph_version()) != NULL);
  CU_ASSERT(strstr(info, "base_f32") != NULL);
  CU_ASSERT(strstr(info, "\npetsc ") != NULL);
  int lines = 0;
  for (const char *line = info; *line;) {
    const char *end = strchr(line, '\n');
    const size_t length = end ? (size_t)(end - line) : strlen(line);
    const char *space = memchr(line, ' ', length);
    CU_ASSERT(space != NULL && space != line && (size_t)(space - line) + 1 < length);
    lines++;
    if (!end) break;
    line = end + 1;
  }
  CU_ASSERT(lines >= 4);
}

static void statuses_have_names(void) {
  static const struct {
    sph_status status;
    int value;
    const char *name, *text;
  } row[] = {
#define ROW(name, value, text) {name, value, #name, text},
      SPH_STATUS_LIST(ROW)
#undef ROW
  };
  enum { ROWS = sizeof row / sizeof row[0] };
  for (int k = 0; k < ROWS; k++) {
    CU_ASSERT_EQUAL((int)row[k].status, row[k].value);
    CU_ASSERT_STRING_EQUAL(sph_status_name(row[k].status), row[k].name);
    CU_ASSERT_STRING_EQUAL(sph_status_text(row[k].status), row[k].text);
    for (int j = 0; j < k; j++) CU_ASSERT_NOT_EQUAL(row[k].value, row[j].value);
  }
  CU_ASSERT_EQUAL((int)SPH_OK, 0);
  CU_ASSERT((int)SPH_E_MEMORY < 0 && (int)SPH_E_DIVERGED < 0 && (int)SPH_E_INTERNAL < 0);
  CU_ASSERT((int)SPH_E_ARGUMENT > 0 && (int)SPH_E_NAME > 0 && (int)SPH_E_IO > 0);
  CU_ASSERT_STRING_EQUAL(sph_status_name((sph_status)77), "unknown");
  CU_ASSERT(strstr(sph_status_text((sph_status)-77), "unknown") != NULL);
}

static void new_context_is_quiet(void) {
  sph_context *context = context_new();
  CU_ASSERT_EQUAL(sph_context_status(context), SPH_OK);
  CU_ASSERT_STRING_EQUAL(sph_context_message(context), "");
  CU_ASSERT_EQUAL(sph_context_get_threads(context), 1);
  CU_ASSERT_NOT_EQUAL(sph_context_get_isa(context), SPH_ISA_AUTO);
  sph_context_destroy(&context);
  CU_ASSERT_PTR_NULL(context);
  sph_context_destroy(&context);
  sph_context_destroy(NULL);
}

static void creation_errors(void) {
  CU_ASSERT_EQUAL(sph_context_create(NULL), SPH_E_ARGUMENT);
  purse money = {-1, 0, 0};
  sph_allocator allocator = purse_allocator(&money);
  CU_ASSERT_EQUAL(sph_context_create_with_allocator(&allocator, NULL), SPH_E_ARGUMENT);
  char place;
  sph_context *context = (sph_context *)&place;
  allocator.allocate = NULL;
  CU_ASSERT_EQUAL(sph_context_create_with_allocator(&allocator, &context), SPH_E_ARGUMENT);
  CU_ASSERT_PTR_NULL(context);
  allocator = purse_allocator(&money);
  allocator.release = NULL;
  context = (sph_context *)&place;
  CU_ASSERT_EQUAL(sph_context_create_with_allocator(&allocator, &context), SPH_E_ARGUMENT);
  CU_ASSERT_PTR_NULL(context);
  allocator = purse_allocator(&money);
  money.left = 0;
  context = (sph_context *)&place;
  CU_ASSERT_EQUAL(sph_context_create_with_allocator(&allocator, &context), SPH_E_MEMORY);
  CU_ASSERT_PTR_NULL(context);
  CU_ASSERT_EQUAL(money.taken, 0);
  CU_ASSERT_EQUAL(sph_context_create_with_allocator(NULL, &context), SPH_OK);
  CU_ASSERT_PTR_NOT_NULL(context);
  sph_context_destroy(&context);
}

static void settings_refuse(void) {
  sph_context *context = context_new();
  CU_ASSERT_EQUAL(sph_context_set_log(NULL, NULL, NULL), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_context_set_threads(NULL, 1), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_context_set_isa(NULL, SPH_ISA_AUTO), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_context_set_precision(NULL, SPH_PRECISION_DOUBLE), SPH_E_ARGUMENT);
  CU_ASSERT_EQUAL(sph_context_get_threads(NULL), 0);
  CU_ASSERT_EQUAL(sph_context_get_isa(NULL), SPH_ISA_AUTO);
  CU_ASSERT_EQUAL(sph_context_status(NULL), SPH_OK);
  CU_ASSERT_STRING_EQUAL(sph_context_message(NULL), "");
  static const int threads[] = {0, -1, 1025, INT32_MIN, INT32_MAX};
  for (int k = 0; k < 5; k++) {
    char text[32];
    snprintf(text, sizeof text, "got %d", threads[k]);
    SPH_TEST_STATUS(context, sph_context_set_threads(context, threads[k]), SPH_E_ARGUMENT, text);
  }
  CU_ASSERT_EQUAL(sph_context_get_threads(context), 1);
  const sph_isa isa = sph_context_get_isa(context);
  SPH_TEST_STATUS(context, sph_context_set_isa(context, (sph_isa)4), SPH_E_ARGUMENT, "got 4");
  SPH_TEST_STATUS(context, sph_context_set_isa(context, (sph_isa)-1), SPH_E_ARGUMENT, "got -1");
  CU_ASSERT_EQUAL(sph_context_get_isa(context), isa);
  SPH_TEST_STATUS(context, sph_context_set_precision(context, (sph_precision)2), SPH_E_ARGUMENT,
                  "got 2");
  SPH_TEST_STATUS(context, sph_context_set_precision(context, (sph_precision)-1), SPH_E_ARGUMENT,
                  "got -1");
  SPH_TEST_OK(context, sph_context_set_precision(context, SPH_PRECISION_DOUBLE));
  SPH_TEST_OK(context, sph_context_set_precision(context, SPH_PRECISION_SINGLE));
  sph_context_destroy(&context);
}

static void threads_are_set(void) {
  sph_context *context = context_new();
  CU_ASSERT(sph_processor_count() >= 1);
#ifdef _OPENMP
  SPH_TEST_OK(context, sph_context_set_threads(context, 2));
  CU_ASSERT_EQUAL(sph_context_get_threads(context), 2);
  SPH_TEST_OK(context, sph_context_set_threads(context, 1024));
  CU_ASSERT_EQUAL(sph_context_get_threads(context), 1024);
#else
  SPH_TEST_STATUS(context, sph_context_set_threads(context, 2), SPH_E_UNAVAILABLE, "OPENMP=1");
#endif
  SPH_TEST_OK(context, sph_context_set_threads(context, 1));
  CU_ASSERT_EQUAL(sph_context_get_threads(context), 1);
  sph_context_destroy(&context);
}

static void instruction_sets(void) {
  sph_context *context = context_new();
  const sph_isa widest = sph_context_get_isa(context);
  for (int isa = SPH_ISA_BASELINE; isa <= SPH_ISA_AVX512; isa++) {
    if (isa <= (int)widest) {
      SPH_TEST_OK(context, sph_context_set_isa(context, (sph_isa)isa));
      CU_ASSERT_EQUAL((int)sph_context_get_isa(context), isa);
    } else {
      SPH_TEST_STATUS(context, sph_context_set_isa(context, (sph_isa)isa), SPH_E_UNAVAILABLE,
                      sph_isa_name((sph_isa)isa));
      CU_ASSERT_EQUAL(sph_context_get_isa(context), widest);
    }
  }
  SPH_TEST_OK(context, sph_context_set_isa(context, SPH_ISA_AUTO));
  CU_ASSERT_EQUAL(sph_context_get_isa(context), widest);
  CU_ASSERT_STRING_EQUAL(sph_isa_name(SPH_ISA_AUTO), "auto");
  CU_ASSERT_STRING_EQUAL(sph_isa_name(SPH_ISA_BASELINE), "baseline");
  CU_ASSERT_STRING_EQUAL(sph_isa_name(SPH_ISA_AVX2), "avx2");
  CU_ASSERT_STRING_EQUAL(sph_isa_name(SPH_ISA_AVX512), "avx512");
  CU_ASSERT_STRING_EQUAL(sph_isa_name((sph_isa)9), "unknown");
  sph_context_destroy(&context);
}

typedef struct heard {
  int count;
  sph_log_level level;
  char message[1024];
} heard;

static void hear(sph_log_level level, const char *message, void *user) {
  heard *ear = user;
  ear->count++;
  ear->level = level;
  snprintf(ear->message, sizeof ear->message, "%s", message);
}

static void log_hears_errors(void) {
  sph_context *context = context_new();
  heard ear = {0};
  SPH_TEST_OK(context, sph_context_set_log(context, hear, &ear));
  CU_ASSERT_EQUAL(ear.count, 0);
  SPH_TEST_STATUS(context, sph_context_set_threads(context, -5), SPH_E_ARGUMENT, "-5");
  CU_ASSERT_EQUAL(ear.count, 1);
  CU_ASSERT_EQUAL(ear.level, SPH_LOG_ERROR);
  CU_ASSERT_STRING_EQUAL(ear.message, sph_context_message(context));
  CU_ASSERT_PTR_NULL(strchr(ear.message, '\n'));
  SPH_TEST_OK(context, sph_context_set_log(context, NULL, NULL));
  SPH_TEST_STATUS(context, sph_context_set_threads(context, -6), SPH_E_ARGUMENT, "-6");
  CU_ASSERT_EQUAL(ear.count, 1);
  sph_context_destroy(&context);
}

static void message_names_all(void) {
  sph_context *context = context_new();
  sph_particles *particles = NULL;
  SPH_TEST_STATUS(context, sph_particles_create(context, 2, -0.01, &particles), SPH_E_ARGUMENT,
                  "-0.01");
  const char *message = sph_context_message(context);
  CU_ASSERT(strstr(message, "spacing") != NULL); /* constraint */
  CU_ASSERT(strstr(message, "[particles.c:") != NULL);
  /* A success leaves the last error where it is. */
  SPH_TEST_OK(context, sph_context_set_threads(context, 1));
  CU_ASSERT_EQUAL(sph_context_status(context), SPH_E_ARGUMENT);
  /* A message longer than its place is cut, not overrun. */
  char name[2000];
  memset(name, 'x', sizeof name - 1);
  name[sizeof name - 1] = 0;
  sph_kernel_type kernel;
  CU_ASSERT_EQUAL(sph_kernel_find(context, name, &kernel), SPH_E_NAME);
  CU_ASSERT(strlen(sph_context_message(context)) < 1000);
  /* The last message may be part of the next. */
  CU_ASSERT_EQUAL(sph_kernel_find(context, sph_context_message(context), &kernel), SPH_E_NAME);
  CU_ASSERT(strstr(sph_context_message(context), "xxx") != NULL);
  sph_context_destroy(&context);
}

static void names_are_suggested(void) {
  sph_context *context = context_new();
  sph_kernel_type kernel = SPH_KERNEL_USER;
  SPH_TEST_STATUS(context, sph_kernel_find(context, "wendland-c3", &kernel), SPH_E_NAME,
                  "unknown kernel \"wendland-c3\"; did you mean \"wendland-c");
  CU_ASSERT_EQUAL(kernel, SPH_KERNEL_USER);
  SPH_TEST_STATUS(context, sph_kernel_find(context, "gausian", &kernel), SPH_E_NAME,
                  "did you mean \"gaussian\"?");
  SPH_TEST_STATUS(context, sph_kernel_find(context, "quintic_spline", &kernel), SPH_E_NAME,
                  "did you mean \"quintic-spline\"?");
  sph_interpolator_type interpolator;
  SPH_TEST_STATUS(context, sph_interpolator_find(context, "mls-liner", &interpolator), SPH_E_NAME,
                  "did you mean \"mls-linear\"?");
  sph_stepper stepper = SPH_STEPPER_RK4;
  SPH_TEST_STATUS(context, sph_stepper_find(context, "verlt", &stepper), SPH_E_NAME,
                  "unknown stepper \"verlt\"; did you mean \"verlet\"?");
  CU_ASSERT_EQUAL(stepper, SPH_STEPPER_RK4);
  sph_particles *particles = NULL;
  SPH_TEST_OK(context, sph_particles_create(context, 2, 0.1, &particles));
  double value = 0;
  SPH_TEST_STATUS(context, sph_particles_read(particles, "presure", &value, 0), SPH_E_NAME,
                  "\"pressure\"");
  sph_particles_destroy(&particles);
  sph_context_destroy(&context);
}

/* Kernel, particles, wall, interpolator, boundary and flow, created in this order. */
enum { HANDLES = 7 };
typedef struct chain {
  sph_context *context;
  sph_kernel *kernel;
  sph_particles *particles;
  sph_wall *wall;
  sph_interpolator *interpolator;
  sph_boundary *boundary;
  sph_integrator *flow;
} chain;

static sph_status chain_make(chain *c) {
  static const double lo[2] = {0, 0}, hi[2] = {0.5, 0.5}, top[2] = {0.5, 1};
  const double dx = 0.05;
  sph_status status =
      sph_kernel_create(c->context, SPH_KERNEL_WENDLAND_C2, 2, 1.5 * dx, &c->kernel);
  if (!status) status = sph_particles_create(c->context, 2, dx, &c->particles);
  if (!status) status = sph_particles_fill_box(c->particles, lo, hi, 1000);
  if (!status) status = sph_wall_create_box(c->context, 2, lo, top, SPH_SIDE_HI(1), &c->wall);
  if (!status)
    status = sph_interpolator_create(c->context, SPH_INTERPOLATOR_MLS_LINEAR, c->kernel,
                                     &c->interpolator);
  if (!status) status = sph_boundary_create(c->context, c->wall, dx, c->interpolator, &c->boundary);
  if (!status)
    status = sph_wcsph_create(c->context, c->kernel, c->particles, c->boundary, &c->flow);
  if (!status) status = sph_wcsph_set_sound_speed(c->flow, 30);
  for (int k = 0; k < 3 && !status; k++) status = sph_integrator_step(c->flow);
  return status;
}

static void chain_drop(chain *c, int which) {
  switch (which) {
    case 0: sph_context_destroy(&c->context); break;
    case 1: sph_kernel_destroy(&c->kernel); break;
    case 2: sph_particles_destroy(&c->particles); break;
    case 3: sph_wall_destroy(&c->wall); break;
    case 4: sph_interpolator_destroy(&c->interpolator); break;
    case 5: sph_boundary_destroy(&c->boundary); break;
    default: sph_integrator_destroy(&c->flow); break;
  }
}

static void destroyed_in_any_order(void) {
  uint64_t seed = 4;
  for (int round = 0; round < 24; round++) {
    purse money = {-1, 0, 0};
    const sph_allocator allocator = purse_allocator(&money);
    chain c = {0};
    CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &c.context) == SPH_OK);
    SPH_TEST_OK(c.context, chain_make(&c));
    int order[HANDLES] = {0, 1, 2, 3, 4, 5, 6};
    for (int k = HANDLES - 1; k > 0; k--) {
      const int j = round == 0 ? k : (int)(sph_test_random(&seed) * (k + 1));
      const int keep = order[k];
      order[k] = order[j];
      order[j] = keep;
    }
    for (int k = 0; k < HANDLES; k++) {
      CU_ASSERT(money.held > 0);
      chain_drop(&c, order[k]);
      /* What is left works on what was given up. */
      if (c.flow) CU_ASSERT_EQUAL(sph_integrator_step(c.flow), SPH_OK);
    }
    CU_ASSERT(money.taken > 10);
    CU_ASSERT_EQUAL(money.held, 0);
  }
}

static void memory_runs_out(void) {
  purse money = {-1, 0, 0};
  const sph_allocator allocator = purse_allocator(&money);
  bool done = false;
  int64_t failures = 0;
  for (int64_t allowed = 1; !done && allowed < 2000; allowed++) {
    chain c = {0};
    money = (purse){allowed, 0, 0};
    CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &c.context) == SPH_OK);
    const sph_status status = chain_make(&c);
    done = status == SPH_OK;
    failures += !done;
    if (!done && status != SPH_E_MEMORY)
      printf("\n%lld allocations: %s", (long long)allowed, sph_context_message(c.context));
    CU_ASSERT(done || status == SPH_E_MEMORY);
    if (!done) CU_ASSERT(strstr(sph_context_message(c.context), "memory") != NULL);
    for (int k = HANDLES - 1; k >= 0; k--) chain_drop(&c, k);
    CU_ASSERT_EQUAL(money.held, 0);
  }
  CU_ASSERT(done);
  CU_ASSERT(failures > 20);
}

static void contexts_share_nothing(void) {
  sph_context *a = context_new(), *b = context_new();
  heard ear = {0};
  SPH_TEST_OK(a, sph_context_set_log(a, hear, &ear));
  SPH_TEST_OK(a, sph_context_set_isa(a, SPH_ISA_BASELINE));
  SPH_TEST_STATUS(b, sph_context_set_threads(b, 0), SPH_E_ARGUMENT, "threads");
  CU_ASSERT_EQUAL(ear.count, 0);
  CU_ASSERT_EQUAL(sph_context_status(a), SPH_OK);
  CU_ASSERT_STRING_EQUAL(sph_context_message(a), "");
  SPH_TEST_OK(b, sph_context_set_isa(b, SPH_ISA_AUTO));
  CU_ASSERT_EQUAL(sph_context_get_isa(a), SPH_ISA_BASELINE);
  sph_context_destroy(&a);
  CU_ASSERT_EQUAL(sph_context_status(b), SPH_E_ARGUMENT);
  sph_context_destroy(&b);
}

typedef struct run {
  int errors; /* provoked on the way */
  sph_status status;
  double x[200];
} run;

/* Plain work and errors; CUnit is kept out, as it knows one thread. */
static void *run_alone(void *user) {
  run *r = user;
  chain c = {0};
  r->status = sph_context_create(&c.context);
  if (!r->status) r->status = chain_make(&c);
  for (int k = 0; k < 40 && !r->status; k++) {
    for (int j = 0; j < r->errors; j++) {
      char text[32];
      snprintf(text, sizeof text, "got %d ", -1 - j);
      if (sph_context_set_threads(c.context, -1 - j) != SPH_E_ARGUMENT ||
          !strstr(sph_context_message(c.context), text))
        r->status = SPH_E_INTERNAL;
    }
    if (!r->status) r->status = sph_integrator_step(c.flow);
  }
  if (!r->status) r->status = sph_particles_read(c.particles, SPH_POSITION, r->x, 200);
  for (int k = HANDLES - 1; k >= 0; k--) chain_drop(&c, k);
  return NULL;
}

static void contexts_in_two_threads(void) {
  static run alone, pair[2];
  alone.errors = 0;
  run_alone(&alone);
  CU_ASSERT_EQUAL_FATAL(alone.status, SPH_OK);
  pthread_t thread[2];
  for (int k = 0; k < 2; k++) {
    pair[k].errors = 3 * k;
    CU_ASSERT_EQUAL_FATAL(pthread_create(&thread[k], NULL, run_alone, &pair[k]), 0);
  }
  for (int k = 0; k < 2; k++) pthread_join(thread[k], NULL);
  for (int k = 0; k < 2; k++) {
    CU_ASSERT_EQUAL(pair[k].status, SPH_OK);
    CU_ASSERT_EQUAL(memcmp(pair[k].x, alone.x, sizeof alone.x), 0);
  }
}

SPH_TEST_MAIN("context", {"the linked version is that of the headers", version_is_one},
              {"build info is lines of name and value", build_info_has_lines},
              {"every status has its name, text and sign", statuses_have_names},
              {"a new context has no error and one thread", new_context_is_quiet},
              {"creation errors are told and leave NULL", creation_errors},
              {"settings out of range are refused and change nothing", settings_refuse},
              {"threads are set from 1 to 1024", threads_are_set},
              {"instruction sets beyond the processor are unavailable", instruction_sets},
              {"the log hears every error", log_hears_errors},
              {"messages name constraint, value and place", message_names_all},
              {"unknown names bring the nearest one", names_are_suggested},
              {"handles are destroyed in any order without a leak", destroyed_in_any_order},
              {"any allocation may fail without a leak", memory_runs_out},
              {"two contexts share nothing", contexts_share_nothing},
              {"two threads with a context each get the same bits", contexts_in_two_threads})
