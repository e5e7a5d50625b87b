/* What the examples share, see example.h. */
#define _XOPEN_SOURCE 700 /* getrusage */
#include "example.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const char *program = "example";

/* The attempt that the thread is in. */
static _Thread_local struct {
  bool on;
  jmp_buf back;
  sph_status status;
  char *message;
} attempt;

static void give_up(sph_status status, const char *text) {
  if (!attempt.on) return;
  attempt.status = status;
  snprintf(attempt.message, EXAMPLE_MESSAGE, "%s", text);
  longjmp(attempt.back, 1);
}

sph_status example_attempt(void (*work)(void *user), void *user, char message[EXAMPLE_MESSAGE]) {
  attempt.on = true;
  attempt.status = SPH_OK;
  attempt.message = message;
  message[0] = '\0';
  if (setjmp(attempt.back) == 0) work(user);
  attempt.on = false;
  return attempt.status;
}

void example_check(sph_status status, const sph_context *context, const char *call) {
  if (status == SPH_OK) return;
  give_up(status, sph_context_message(context));
  fflush(stdout);
  fprintf(stderr, "%s: %s: %s\n", program, sph_status_name(status), sph_context_message(context));
  fprintf(stderr, "%s: in %s\n", program, call);
  exit(1);
}

void *example_memory(int64_t n, size_t size) {
  void *memory = calloc(n > 0 ? (size_t)n : 1, size);
  if (memory == NULL) {
    give_up(SPH_E_MEMORY, "out of memory");
    fprintf(stderr, "%s: out of memory for %lld numbers\n", program, (long long)n);
    exit(1);
  }
  return memory;
}

double *example_numbers(int64_t n) { return example_memory(n, sizeof(double)); }

/* ------------------------------------------------------------------------------------ options */

void example_refuse(const char *option, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  fprintf(stderr, "%s: option %s: ", program, option);
  vfprintf(stderr, format, arguments);
  fprintf(stderr, "; --help lists the options\n");
  va_end(arguments);
  exit(2);
}

static void print_default(const example_option *option) {
  if (option->kind == EXAMPLE_NUMBER) printf(" (%g)", *(const double *)option->value);
  if (option->kind == EXAMPLE_INTEGER) printf(" (%d)", *(const int *)option->value);
  if (option->kind == EXAMPLE_TEXT && **(const char **)option->value != '\0')
    printf(" (%s)", *(const char **)option->value);
}

static void print_help(const char *purpose, int count, const example_option *options) {
  static const char *const arguments[] = {"NUMBER", "INTEGER", "TEXT", ""};
  printf("%s: %s\n\noptions, defaults in brackets:\n", program, purpose);
  for (int k = 0; k < count; k++) {
    char left[64];
    snprintf(left, sizeof left, "%s %s", options[k].name, arguments[options[k].kind]);
    printf("  %-24s %s", left, options[k].help);
    print_default(&options[k]);
    printf("\n");
  }
  printf("  %-24s this list\n", "--help");
}

static double parse_number(const example_option *option, const char *text) {
  char *rest = NULL;
  errno = 0;
  const double value = strtod(text, &rest);
  if (rest == text || *rest != '\0' || errno == ERANGE || !isfinite(value))
    example_refuse(option->name, "\"%s\" is not a number", text);
  if (value < option->lowest || value > option->highest)
    example_refuse(option->name, "must be %g to %g, got %s", option->lowest, option->highest, text);
  return value;
}

static int parse_integer(const example_option *option, const char *text) {
  char *rest = NULL;
  errno = 0;
  const long value = strtol(text, &rest, 10);
  if (rest == text || *rest != '\0' || errno == ERANGE || value < INT_MIN || value > INT_MAX)
    example_refuse(option->name, "\"%s\" is not an integer", text);
  if ((double)value < option->lowest || (double)value > option->highest)
    example_refuse(option->name, "must be %g to %g, got %s", option->lowest, option->highest, text);
  return (int)value;
}

void example_parse(int argc, char **argv, const char *purpose, int count,
                   const example_option *options) {
  const char *slash = argc > 0 ? strrchr(argv[0], '/') : NULL;
  if (argc > 0) program = slash != NULL ? slash + 1 : argv[0];
  for (int a = 1; a < argc; a++) {
    if (strcmp(argv[a], "--help") == 0) {
      print_help(purpose, count, options);
      exit(0);
    }
    const char *equals = strchr(argv[a], '=');
    const size_t length = equals != NULL ? (size_t)(equals - argv[a]) : strlen(argv[a]);
    const example_option *option = NULL;
    for (int k = 0; k < count; k++)
      if (strlen(options[k].name) == length && strncmp(options[k].name, argv[a], length) == 0)
        option = &options[k];
    if (option == NULL) example_refuse(argv[a], "unknown");
    if (option->kind == EXAMPLE_FLAG) {
      if (equals != NULL) example_refuse(option->name, "takes no value, got \"%s\"", equals + 1);
      *(bool *)option->value = true;
      continue;
    }
    const char *text = equals != NULL ? equals + 1 : a + 1 < argc ? argv[++a] : NULL;
    if (text == NULL || *text == '\0') example_refuse(option->name, "wants a value");
    if (option->kind == EXAMPLE_NUMBER) *(double *)option->value = parse_number(option, text);
    if (option->kind == EXAMPLE_INTEGER) *(int *)option->value = parse_integer(option, text);
    if (option->kind == EXAMPLE_TEXT) *(const char **)option->value = text;
  }
}

int example_threads(int asked) { return asked > 0 ? asked : sph_processor_count(); }

sph_isa example_isa(const char *name) {
  for (int isa = SPH_ISA_AUTO; isa <= SPH_ISA_AVX512; isa++)
    if (strcmp(name, sph_isa_name((sph_isa)isa)) == 0) return (sph_isa)isa;
  example_refuse("--isa", "\"%s\" is none of auto, baseline, avx2, avx512", name);
  return SPH_ISA_AUTO;
}

const char *example_path(const char *folder, const char *file) {
  static char path[4096];
  if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
    fprintf(stderr, "%s: folder %s: %s\n", program, folder, strerror(errno));
    exit(1);
  }
  if (snprintf(path, sizeof path, "%s/%s", folder, file) >= (int)sizeof path)
    example_refuse("--out", "the path is longer than %zu bytes", sizeof path - 1);
  return path;
}

/* ----------------------------------------------------------------------------------- progress */

double example_clock(void) {
  struct timespec now;
  timespec_get(&now, TIME_UTC);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double example_peak_memory(void) {
  struct rusage usage;
  return getrusage(RUSAGE_SELF, &usage) == 0 ? (double)usage.ru_maxrss / 1024 : NAN;
}

void example_progress_show(example_progress *progress, const sph_integrator *flow, double end) {
  const double now = example_clock();
  if (progress->start == 0) progress->start = progress->last = now;
  if (now - progress->last < 0.2 || !isatty(STDERR_FILENO)) return;
  progress->last = now;
  progress->shown = true;
  sph_integrator_stats stats;
  if (sph_integrator_get_stats(flow, &stats) != SPH_OK) return;
  const double seconds = now - progress->start;
  const double particles = (double)sph_particles_count(sph_integrator_particles(flow));
  fprintf(stderr,
          "\r%8.4f of %g s  step %lld  dt %.2e s  %.2f M particle steps/s  %.0f s left \033[K",
          stats.time, end, (long long)stats.steps, stats.dt,
          1e-6 * particles * (double)stats.steps / seconds,
          stats.time > 0 ? seconds * (end - stats.time) / stats.time : 0.0);
}

void example_progress_end(example_progress *progress) {
  if (progress->shown) fprintf(stderr, "\r\033[K");
}

/* ------------------------------------------------------------------------------------ summary */

static char *new_entry(example_summary *summary, const char *key) {
  const int room = (int)(sizeof summary->entries / sizeof summary->entries[0]);
  if (summary->count >= room) {
    fprintf(stderr, "%s: more than %d figures in the summary\n", program, room);
    exit(1);
  }
  summary->entries[summary->count].key = key;
  return summary->entries[summary->count++].value;
}

void example_summary_number(example_summary *summary, const char *key, double value) {
  snprintf(new_entry(summary, key), 64, isfinite(value) ? "%.9g" : "null", value);
}

void example_summary_integer(example_summary *summary, const char *key, int64_t value) {
  snprintf(new_entry(summary, key), 64, "%lld", (long long)value);
}

void example_summary_text(example_summary *summary, const char *key, const char *value) {
  char *entry = new_entry(summary, key);
  size_t n = 0;
  entry[n++] = '"';
  for (; *value != '\0' && n < 60; value++) {
    if (*value == '"' || *value == '\\') entry[n++] = '\\';
    if ((unsigned char)*value >= 32) entry[n++] = *value;
  }
  entry[n++] = '"';
  entry[n] = '\0';
}

void example_summary_write(const example_summary *summary, const char *path) {
  for (int k = 0; k < summary->count; k++)
    printf("%-34s %s\n", summary->entries[k].key, summary->entries[k].value);
  if (*path == '\0') return;
  FILE *file = fopen(path, "w");
  bool written = file != NULL && fputs("{\n", file) >= 0;
  for (int k = 0; written && k < summary->count; k++)
    written = fprintf(file, "  \"%s\": %s%s\n", summary->entries[k].key, summary->entries[k].value,
                      k + 1 < summary->count ? "," : "") > 0;
  written = written && fputs("}\n", file) >= 0;
  if (file != NULL && fclose(file) != 0) written = false;
  if (written) return;
  fprintf(stderr, "%s: option --summary: %s: %s\n", program, path, strerror(errno));
  exit(1);
}

/* ----------------------------------------------------------------------------------- pictures */

void example_picture_write(const sph_context *context, const sph_particles *particles,
                           const char *folder, int number, double t, double height, double gravity,
                           double density) {
  const int dim = sph_particles_dim(particles);
  const int64_t n = sph_particles_count(particles);
  double *x = example_numbers(n * (2 * dim + 1)), *v = x + n * dim, *p = v + n * dim;
  OK(sph_particles_read(particles, SPH_POSITION, x, n * dim));
  OK(sph_particles_read(particles, SPH_VELOCITY, v, n * dim));
  OK(sph_particles_read(particles, SPH_PRESSURE, p, n));
  char name[32];
  snprintf(name, sizeof name, "picture_%03d.txt", number);
  const char *path = example_path(folder, name);
  FILE *file = fopen(path, "w");
  if (file == NULL) example_refuse("--out", "%s: %s", path, strerror(errno));
  fprintf(file, "# t_star %.4f spacing_over_H %.9g\n", t * sqrt(gravity / height),
          sph_particles_spacing(particles) / height);
  fprintf(file, "# x_over_H y_over_H p_over_rho_g_H speed_over_sqrt_g_H\n");
  for (int64_t i = 0; i < n; i++) {
    double square = 0;
    for (int d = 0; d < dim; d++) square += v[i * dim + d] * v[i * dim + d];
    fprintf(file, "%.5f %.5f %.5f %.5f\n", x[i * dim] / height, x[i * dim + dim - 1] / height,
            p[i] / (density * gravity * height), sqrt(square / (gravity * height)));
  }
  if (fclose(file) != 0) example_refuse("--out", "%s: %s", path, strerror(errno));
  free(x);
}

/* ------------------------------------------------------------------------------------- series */

example_series example_series_read(const sph_context *context, const sph_probe *probe, int column) {
  const int64_t n = sph_probe_count(probe);
  const int columns = sph_probe_columns(probe);
  example_series series = {.n = n, .t = example_numbers(n * (2 + columns))};
  double *all = series.t + 2 * n;
  series.v = series.t + n;
  OK(sph_probe_read(probe, 0, n, series.t, all));
  for (int64_t k = 0; k < n; k++) series.v[k] = all[k * columns + column];
  return series;
}

double example_series_mean(const example_series *series, double lo, double hi) {
  double sum = 0, span = 0;
  if (series->n < 2 || !(series->t[series->n - 1] >= hi * (1 - 1e-6))) return NAN;
  for (int64_t k = 1; k < series->n; k++) {
    if (series->t[k - 1] < lo || series->t[k] > hi) continue;
    const double dt = series->t[k] - series->t[k - 1];
    sum += 0.5 * dt * (series->v[k] + series->v[k - 1]);
    span += dt;
  }
  return span > 0 ? sum / span : NAN;
}

double example_series_reach(const example_series *series, double level) {
  for (int64_t k = 0; k < series->n; k++) {
    if (!(series->v[k] >= level)) continue;
    if (k == 0) return series->t[0];
    const double rise = series->v[k] - series->v[k - 1];
    const double part = rise > 0 ? (level - series->v[k - 1]) / rise : 1;
    return series->t[k - 1] + part * (series->t[k] - series->t[k - 1]);
  }
  return NAN;
}

/* rest[k] = v[k] less the mean of v over a window around t[k]; at the ends less what there is of one. */
static void without_mean(const example_series *series, const double *v, double width,
                         double *rest) {
  const double *t = series->t;
  double sum = 0;
  for (int64_t k = 0, head = 0, tail = 0; k < series->n; k++) {
    while (head < series->n && t[head] <= t[k] + 0.5 * width) sum += v[head++];
    while (t[tail] < t[k] - 0.5 * width) sum -= v[tail++];
    rest[k] = v[k] - sum / (double)(head - tail);
  }
}

double example_series_noise(const example_series *series, double lo, double hi, double width) {
  double *once = example_numbers(2 * series->n), *twice = once + series->n, sum = 0;
  int64_t count = 0;
  without_mean(series, series->v, width, once);
  without_mean(series, once, width, twice);
  for (int64_t k = 0; k < series->n; k++) {
    if (!(series->t[k] >= lo && series->t[k] <= hi)) continue;
    sum += twice[k] * twice[k];
    count++;
  }
  free(once);
  return count > 0 ? sqrt(sum / (double)count) : NAN;
}

example_peak example_series_peak(const example_series *series, double lo, double hi, double width) {
  example_peak peak = {NAN, NAN};
  double sum = 0;
  for (int64_t head = 0, tail = 0; head < series->n; head++) {
    if (series->t[head] > hi) break;
    sum += series->v[head];
    while (series->t[head] - series->t[tail] > width) sum -= series->v[tail++];
    if (tail == 0 || series->t[tail] < lo) continue;
    const double mean = sum / (double)(head - tail + 1);
    if (!isnan(peak.v) && mean <= peak.v) continue;
    peak.v = mean;
    peak.t = 0.5 * (series->t[head] + series->t[tail]);
  }
  return peak;
}
