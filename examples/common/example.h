/* What the examples share: options, the summary as JSON, the progress line. No part of the library. */
#ifndef EXAMPLE_H
#define EXAMPLE_H

#include <sph.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Checks a call of the library; on failure says what the library says and ends with status 1. Wants a
 * variable `context`. */
#define OK(call) example_check((call), context, #call)
void example_check(sph_status status, const sph_context *context, const char *call);

/* Calls work(user) so that a failed OK or example_memory below it ends the call instead of the program: for programs
 * of many runs. Returns that failure's code, and what it said as text. Each thread has its own; what functions
 * in between took by example_memory is lost. */
enum { EXAMPLE_MESSAGE = 400 };
sph_status example_attempt(void (*work)(void *user), void *user, char message[EXAMPLE_MESSAGE]);

/* Zeroed memory for n things or numbers, or the end of the program. */
void *example_memory(int64_t n, size_t size);
double *example_numbers(int64_t n);

/* Options of the command line. The value that the variable has beforehand is the default. */
typedef enum example_kind {
  EXAMPLE_NUMBER,
  EXAMPLE_INTEGER,
  EXAMPLE_TEXT,
  EXAMPLE_FLAG
} example_kind;
typedef struct example_option {
  const char *name; /* with its dashes */
  example_kind kind;
  void *value; /* double, int, const char * or bool */
  double lowest, highest;
  const char *help;
} example_option;
#define OPTION_NUMBER(name, variable, lowest, highest, help) \
  { name, EXAMPLE_NUMBER, &(variable), lowest, highest, help }
#define OPTION_INTEGER(name, variable, lowest, highest, help) \
  { name, EXAMPLE_INTEGER, &(variable), lowest, highest, help }
#define OPTION_TEXT(name, variable, help) \
  { name, EXAMPLE_TEXT, &(variable), 0, 0, help }
#define OPTION_FLAG(name, variable, help) \
  { name, EXAMPLE_FLAG, &(variable), 0, 0, help }

/* Reads the command line; a wrong option ends the program with status 2, --help with status 0. */
void example_parse(int argc, char **argv, const char *purpose, int count,
                   const example_option *options);

/* Ends the program with status 2 and "program: option --dx: " before the text. */
void example_refuse(const char *option, const char *format, ...)
#ifdef __GNUC__
    __attribute__((format(printf, 2, 3)))
#endif
    ;

/* Threads as asked for; 0 means one for each processor. */
int example_threads(int asked);

/* Instruction set by name: "auto", "baseline", "avx2", "avx512". */
sph_isa example_isa(const char *name);

/* Makes a folder unless it exists and returns "folder/file" in a buffer that the next call reuses. */
const char *example_path(const char *folder, const char *file);

/* Seconds since some moment. */
double example_clock(void);

/* The most memory that the program had so far [MB of 2^20 bytes]. */
double example_peak_memory(void);

/* A line on the terminal while a run goes on; nothing where standard error is a file. */
typedef struct example_progress {
  double start, last;
  bool shown;
} example_progress;
void example_progress_show(example_progress *progress, const sph_integrator *flow, double end);
void example_progress_end(example_progress *progress);

/* Figures of a run, printed as a list and written as one flat JSON object. */
typedef struct example_summary {
  int count;
  struct {
    const char *key;
    char value[64];
  } entries[64];
} example_summary;
void example_summary_number(example_summary *summary, const char *key, double value);
void example_summary_integer(example_summary *summary, const char *key, int64_t value);
void example_summary_text(example_summary *summary, const char *key, const char *value);
/* Prints the list, and writes the JSON unless path is "". */
void example_summary_write(const example_summary *summary, const char *path);

/* One frame as text, folder/picture_000.txt ...: of every particle its place / H, p / (rho g H) and
 * speed / sqrt(g H). In 3D the second coordinate is left out: the view from the side. */
void example_picture_write(const sph_context *context, const sph_particles *particles,
                           const char *folder, int number, double t, double height, double gravity,
                           double density);

/* Samples of one column of a probe: t and v point into memory that the caller frees by free(t). */
typedef struct example_series {
  int64_t n;
  double *t, *v;
} example_series;
example_series example_series_read(const sph_context *context, const sph_probe *probe, int column);
/* Mean over lo <= t <= hi by the trapezoidal rule; NaN unless the samples reach that far. */
double example_series_mean(const example_series *series, double lo, double hi);
/* First time at which the value reaches level, between samples by a straight line; NaN if never. */
double example_series_reach(const example_series *series, double level);
/* Root mean square over lo <= t <= hi of what a running mean over windows of a given width takes away twice:
 * of the rest r = v - mean(v), r - mean(r). A smooth curve leaves the fourth power of the width. */
double example_series_noise(const example_series *series, double lo, double hi, double width);
/* Where the mean over windows of a given width is largest between lo and hi; NaN without a whole window.
 * A gauge sees no single step of a weakly compressible flow either. */
typedef struct example_peak {
  double t, v;
} example_peak;
example_peak example_series_peak(const example_series *series, double lo, double hi, double width);

#endif
