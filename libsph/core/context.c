/* Context, errors, memory. */
#define _POSIX_C_SOURCE 200809L
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "core/internal.h"

static void *system_allocate(size_t bytes, void *user) {
  (void)user;
  return malloc(bytes);
}

static void system_release(void *memory, void *user) {
  (void)user;
  free(memory);
}

static sph_isa widest_isa(void) {
#if defined(__x86_64__) && !defined(SPHI_NO_X86_VARIANTS)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
    return SPH_ISA_AVX512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return SPH_ISA_AVX2;
#endif
  return SPH_ISA_BASELINE;
}

sph_status sph_context_create_with_allocator(const sph_allocator *allocator, sph_context **out) {
  if (!out) return SPH_E_ARGUMENT;
  *out = NULL;
  const sph_allocator used =
      allocator ? *allocator : (sph_allocator){system_allocate, system_release, NULL};
  if (!used.allocate || !used.release) return SPH_E_ARGUMENT;
  sph_context *context = used.allocate(sizeof *context, used.user);
  if (!context) return SPH_E_MEMORY;
  memset(context, 0, sizeof *context);
  context->allocator = used;
  context->references = 1;
  context->threads = 1;
  context->isa = widest_isa();
  *out = context;
  return SPH_OK;
}

sph_status sph_context_create(sph_context **out) {
  return sph_context_create_with_allocator(NULL, out);
}

void sphi_context_retain(sph_context *context) { context->references++; }

void sph_context_destroy(sph_context **context) {
  if (!context || !*context) return;
  sph_context *dead = *context;
  *context = NULL;
  if (--dead->references > 0) return;
  const sph_allocator used = dead->allocator;
  used.release(dead, used.user);
}

sph_status sph_context_set_log(sph_context *context, sph_log_function log, void *user) {
  if (!context) return SPH_E_ARGUMENT;
  context->log = log;
  context->log_user = user;
  return SPH_OK;
}

sph_status sph_context_set_threads(sph_context *context, int threads) {
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, threads >= 1 && threads <= SPHI_MAX_THREADS, SPH_E_ARGUMENT,
            "context: threads must be 1 to %d, got %d", SPHI_MAX_THREADS, threads);
#ifndef _OPENMP
  SPH_CHECK(context, threads == 1, SPH_E_UNAVAILABLE,
            "context: %d threads need a build with OpenMP; make configure OPENMP=1", threads);
#endif
  context->threads = threads;
  return SPH_OK;
}

int sph_context_get_threads(const sph_context *context) { return context ? context->threads : 0; }

int sph_processor_count(void) {
#ifdef _OPENMP
  return omp_get_num_procs();
#else
  return 1;
#endif
}

sph_status sph_context_set_isa(sph_context *context, sph_isa isa) {
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, isa >= SPH_ISA_AUTO && isa <= SPH_ISA_AVX512, SPH_E_ARGUMENT,
            "context: instruction set must be one of sph_isa, got %d", (int)isa);
  const sph_isa widest = widest_isa();
  SPH_CHECK(context, isa <= widest, SPH_E_UNAVAILABLE,
            "context: instruction set \"%s\" is not available here; the widest is \"%s\"",
            sph_isa_name(isa), sph_isa_name(widest));
  context->isa = isa == SPH_ISA_AUTO ? widest : isa;
  return SPH_OK;
}

sph_isa sph_context_get_isa(const sph_context *context) {
  return context ? context->isa : SPH_ISA_AUTO;
}

const char *sph_isa_name(sph_isa isa) {
  static const char *const names[] = {"auto", "baseline", "avx2", "avx512"};
  return isa >= SPH_ISA_AUTO && isa <= SPH_ISA_AVX512 ? names[isa] : "unknown";
}

sph_status sph_context_set_precision(sph_context *context, sph_precision precision) {
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, precision == SPH_PRECISION_SINGLE || precision == SPH_PRECISION_DOUBLE,
            SPH_E_ARGUMENT, "context: precision must be one of sph_precision, got %d",
            (int)precision);
  context->precision = precision;
  return SPH_OK;
}

sph_status sph_context_status(const sph_context *context) {
  return context ? context->status : SPH_OK;
}

const char *sph_context_message(const sph_context *context) {
  return context ? context->message : "";
}

const char *sph_status_name(sph_status status) {
  switch (status) {
#define STATUS_NAME(name, value, text) \
  case name: return #name;
    SPH_STATUS_LIST(STATUS_NAME)
#undef STATUS_NAME
  }
  return "unknown";
}

const char *sph_status_text(sph_status status) {
  switch (status) {
#define STATUS_TEXT(name, value, text) \
  case name: return text;
    SPH_STATUS_LIST(STATUS_TEXT)
#undef STATUS_TEXT
  }
  return "unknown status";
}

sph_status sphi_error(sph_context *context, sph_status code, const char *file, int line,
                      const char *format, ...) {
  if (!context) return code;
  const char *base = strrchr(file, '/');
  char text[sizeof context->message]; /* the arguments may point into the old message */
  va_list arguments;
  va_start(arguments, format);
  int length = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  const int room = (int)sizeof text - 1;
  if (length < 0) length = 0;
  if (length > room) length = room;
  snprintf(text + length, sizeof text - (size_t)length, " [%s:%d]", base ? base + 1 : file, line);
  memcpy(context->message, text, sizeof text);
  context->status = code;
  if (context->log) context->log(SPH_LOG_ERROR, context->message, context->log_user);
  return code;
}

void sphi_log(sph_context *context, sph_log_level level, const char *format, ...) {
  if (!context->log) return;
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  context->log(level, text, context->log_user);
}

/* The address the caller's allocator gave is kept in front of the aligned block. */
/* Zeroes a block. A page lies in the memory of the processor that writes it first: the threads share
 * large blocks as loops with a static schedule do. */
static void clear(const sph_context *context, char *block, size_t bytes) {
  (void)context; /* without OpenMP */
  const size_t chunk = (size_t)1 << 16;
  const int64_t chunks = (int64_t)((bytes + chunk - 1) / chunk);
#pragma omp parallel for num_threads(context->threads) schedule(static) if (chunks >= 16)
  for (int64_t k = 0; k < chunks; k++) {
    const size_t first = (size_t)k * chunk;
    memset(block + first, 0, bytes - first < chunk ? bytes - first : chunk);
  }
}

void *sphi_alloc(sph_context *context, size_t count, size_t size) {
  const size_t overhead = SPHI_ALIGN + sizeof(void *);
  if (size && count > (SIZE_MAX - overhead) / size) return NULL;
  const size_t bytes = count * size;
  char *raw = context->allocator.allocate(bytes + overhead, context->allocator.user);
  if (!raw) return NULL;
  context->allocations++;
  const uintptr_t start = ((uintptr_t)raw + overhead) & ~(uintptr_t)(SPHI_ALIGN - 1);
  char *block = raw + (start - (uintptr_t)raw);
  memcpy(block - sizeof raw, &raw, sizeof raw);
  clear(context, block, bytes);
  return block;
}

void sphi_free(sph_context *context, void *memory) {
  if (!memory) return;
  char *raw;
  memcpy(&raw, (char *)memory - sizeof raw, sizeof raw);
  context->allocator.release(raw, context->allocator.user);
}

bool sphi_reserve(sph_context *context, void **array, int64_t *capacity, int64_t count,
                  size_t size) {
  if (count <= *capacity) return true;
  int64_t wanted = *capacity + *capacity / 2;
  if (wanted < count) wanted = count;
  if (wanted < 16) wanted = 16;
  void *larger = sphi_alloc(context, (size_t)wanted, size);
  if (!larger) return false;
  if (*array && *capacity) memcpy(larger, *array, (size_t)*capacity * size);
  sphi_free(context, *array);
  *array = larger;
  *capacity = wanted;
  return true;
}

char *sphi_copy_text(sph_context *context, const char *text) {
  const size_t bytes = strlen(text) + 1;
  char *copy = sphi_alloc(context, bytes, 1);
  if (copy) memcpy(copy, text, bytes);
  return copy;
}

static int edit_distance(const char *a, const char *b) {
  enum { LIMIT = 64 };
  int row[LIMIT + 1];
  const int na = (int)strlen(a), nb = (int)strlen(b);
  if (na > LIMIT || nb > LIMIT) return INT_MAX;
  for (int j = 0; j <= nb; j++) row[j] = j;
  for (int i = 1; i <= na; i++) {
    int diagonal = row[0];
    row[0] = i;
    for (int j = 1; j <= nb; j++) {
      const int above = row[j];
      int best = diagonal + (a[i - 1] != b[j - 1]);
      if (above + 1 < best) best = above + 1;
      if (row[j - 1] + 1 < best) best = row[j - 1] + 1;
      row[j] = best;
      diagonal = above;
    }
  }
  return row[nb];
}

const char *sphi_nearest_name(const char *name, int count, const char *const names[]) {
  const char *nearest = NULL;
  int best = (int)strlen(name) / 2 + 2;
  for (int k = 0; k < count; k++) {
    const int distance = edit_distance(name, names[k]);
    if (distance < best) {
      best = distance;
      nearest = names[k];
    }
  }
  return nearest;
}

double sphi_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
