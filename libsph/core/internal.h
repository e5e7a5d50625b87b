/* What every file of the library may use: errors, memory, threads, small helpers. */
#ifndef SPHI_INTERNAL_H
#define SPHI_INTERNAL_H

#include <math.h>
#include <sph/context.h>
#include <string.h>

#define SPHI_MAX_DIM 3
#define SPHI_ALIGN 64
#define SPHI_MAX_THREADS 1024

struct sph_context {
  sph_allocator allocator;
  int references;
  sph_log_function log;
  void *log_user;
  sph_status status;
  int threads;
  sph_isa isa;
  sph_precision precision;
  int64_t allocations; /* calls of the allocator so far: tests count them over a step */
  char message[768];
};

void sphi_context_retain(sph_context *context);

/* Records the error in the context (which may be NULL), tells the log, returns the code. */
sph_status sphi_error(sph_context *context, sph_status code, const char *file, int line,
                      const char *format, ...) __attribute__((format(printf, 5, 6)));
void sphi_log(sph_context *context, sph_log_level level, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#define SPHI_ERROR(context, code, ...) \
  sphi_error((context), (code), __FILE__, __LINE__, __VA_ARGS__)
/* Leaves the function with an error unless the condition holds. Never compiled out. */
#define SPH_CHECK(context, condition, code, ...)                         \
  do {                                                                   \
    if (!(condition)) return SPHI_ERROR((context), (code), __VA_ARGS__); \
  } while (0)
#define SPH_TRY(call)                              \
  do {                                             \
    sph_status sphi_status = (call);               \
    if (sphi_status != SPH_OK) return sphi_status; \
  } while (0)
/* For functions that clean up: sets the local `status` and jumps to `fail`. */
#define SPH_TRY_GOTO(call)           \
  do {                               \
    status = (call);                 \
    if (status != SPH_OK) goto fail; \
  } while (0)

/* Zeroed memory aligned to SPHI_ALIGN, or NULL (also when bytes overflow). bytes 0 gives one block. */
void *sphi_alloc(sph_context *context, size_t count, size_t size);
void sphi_free(sph_context *context, void *memory);
/* Makes *array hold at least `count` elements, doubling *capacity and keeping the old elements;
 * on failure nothing changes and false is returned. */
bool sphi_reserve(sph_context *context, void **array, int64_t *capacity, int64_t count,
                  size_t size);
char *sphi_copy_text(sph_context *context, const char *text);

#define SPHI_NEW(context, count, type) \
  ((type *)sphi_alloc((context), (size_t)(count), sizeof(type)))

/* The name nearest to `name` by edit distance, or NULL when none is near. */
const char *sphi_nearest_name(const char *name, int count, const char *const names[]);

static inline bool sphi_finite(int count, const double *values) {
  for (int k = 0; k < count; k++)
    if (!isfinite(values[k])) return false;
  return true;
}

#ifdef _OPENMP
#include <omp.h>
static inline int sphi_thread(void) { return omp_get_thread_num(); }
#else
static inline int sphi_thread(void) { return 0; }
#endif

/* Seconds of a monotonic clock. */
double sphi_seconds(void);

#endif
