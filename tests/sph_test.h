/* Small helpers over CUnit: values in failure messages, status checks, one main. */
#ifndef SPH_TEST_H
#define SPH_TEST_H

#include <CUnit/Basic.h>
#include <math.h>
#include <sph.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Memory of which there are so many more blocks, for tests of what happens without: sph_test_allocate and
 * sph_test_release are an allocator, `live` counts blocks in use. */
typedef struct sph_test_memory {
  int allowed, live;
} sph_test_memory;

static inline void *sph_test_allocate(size_t bytes, void *user) {
  sph_test_memory *m = user;
  if (m->allowed-- <= 0) return NULL;
  m->live++;
  return malloc(bytes);
}

static inline void sph_test_release(void *block, void *user) {
  ((sph_test_memory *)user)->live--;
  free(block);
}

/* |actual - expected| <= rtol |expected| + atol; prints both, the error and the bound if not. */
#define SPH_TEST_CLOSE(actual, expected, rtol, atol)                                       \
  do {                                                                                     \
    const double t_a = (actual), t_e = (expected), t_b = (rtol)*fabs(t_e) + (atol);        \
    const int t_ok = fabs(t_a - t_e) <= t_b;                                               \
    if (!t_ok)                                                                             \
      printf("\n%s:%d: %s = %.17g, expected %.17g, error %.3g > %.3g", __FILE__, __LINE__, \
             #actual, t_a, t_e, fabs(t_a - t_e), t_b);                                     \
    CU_ASSERT(t_ok);                                                                       \
  } while (0)

/* actual < bound (false for NaN); prints both if not. */
#define SPH_TEST_BELOW(actual, bound)                                                      \
  do {                                                                                     \
    const double t_a = (actual), t_b = (bound);                                            \
    if (!(t_a < t_b))                                                                      \
      printf("\n%s:%d: %s = %.6g, not below %.6g", __FILE__, __LINE__, #actual, t_a, t_b); \
    CU_ASSERT(t_a < t_b);                                                                  \
  } while (0)

/* The call returns SPH_OK; prints the context's message if not. */
#define SPH_TEST_OK(context, call)                                                   \
  do {                                                                               \
    const sph_status t_s = (call);                                                   \
    if (t_s != SPH_OK)                                                               \
      printf("\n%s:%d: %s: %s: %s", __FILE__, __LINE__, #call, sph_status_name(t_s), \
             sph_context_message(context));                                          \
    CU_ASSERT_FATAL(t_s == SPH_OK);                                                  \
  } while (0)

/* The call returns `code`, and the context stored a message that contains `text`. */
#define SPH_TEST_STATUS(context, call, code, text)                                                \
  do {                                                                                            \
    const sph_status t_s = (call);                                                                \
    const char *t_m = sph_context_message(context);                                               \
    const int t_ok = t_s == (code) && sph_context_status(context) == (code) && strstr(t_m, text); \
    if (!t_ok)                                                                                    \
      printf("\n%s:%d: %s: %s, expected %s with \"%s\", message: %s", __FILE__, __LINE__, #call,  \
             sph_status_name(t_s), sph_status_name(code), text, t_m);                             \
    CU_ASSERT(t_ok);                                                                              \
  } while (0)

/* Uniform in [0, 1): a fixed-seed generator of high-entropy inputs (splitmix64). */
static inline double sph_test_random(uint64_t *state) {
  uint64_t z = (*state += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

typedef struct sph_test {
  const char *claim;
  void (*run)(void);
} sph_test;

static inline int sph_test_main(const char *suite_name, int count, const sph_test *tests) {
  if (CU_initialize_registry() != CUE_SUCCESS) return 2;
  CU_pSuite suite = CU_add_suite(suite_name, NULL, NULL);
  for (int k = 0; k < count; k++)
    if (!CU_add_test(suite, tests[k].claim, tests[k].run)) return 2;
  CU_basic_set_mode(CU_BRM_VERBOSE);
  CU_basic_run_tests();
  const unsigned failed = CU_get_number_of_tests_failed() + CU_get_number_of_suites_failed();
  const unsigned ran = CU_get_number_of_tests_run();
  printf("tests %s: %u run, %u failed\n", suite_name, ran, failed);
  CU_cleanup_registry();
  return failed != 0 || ran != (unsigned)count;
}

/* SPH_TEST_MAIN("suite", {"claim", function}, ...) */
#define SPH_TEST_MAIN(suite, ...)                                              \
  int main(void) {                                                             \
    const sph_test tests[] = {__VA_ARGS__};                                    \
    return sph_test_main(suite, (int)(sizeof tests / sizeof tests[0]), tests); \
  }

#endif
