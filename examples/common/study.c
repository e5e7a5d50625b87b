/* What studies of many runs share, see study.h. */
#define _POSIX_C_SOURCE 200809L
#include "study.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { LINE = 2048, MOST_ROWS = 10000 };

study_list study_list_parse(const char *option, const char *text, double lowest, double highest) {
  study_list list = {0};
  const char *rest = text;
  for (;;) {
    char *after = NULL;
    double value = strtod(rest, &after);
    if (after == rest || (*after != ',' && *after != '\0'))
      example_refuse(option, "\"%s\" is no list of numbers as 0.3,0.5", text);
    if (!(value >= lowest && value <= highest))
      example_refuse(option, "must be %g to %g, got %g", lowest, highest, value);
    char nine_digits[32]; /* as many as a row keeps */
    snprintf(nine_digits, sizeof nine_digits, "%.9g", value);
    value = strtod(nine_digits, NULL);
    for (int k = 0; k < list.count; k++)
      if (list.values[k] == value) example_refuse(option, "has %g twice", value);
    if (list.count == STUDY_LIST) example_refuse(option, "has more than %d numbers", STUDY_LIST);
    list.values[list.count++] = value;
    if (*after == '\0') return list;
    rest = after + 1;
  }
}

/* -------------------------------------------------------------------------------------- table */

static void stop(const study_table *table, const char *what) {
  fflush(stdout);
  fprintf(stderr, "%s: %s: %s\n", table->path, what, strerror(errno));
  exit(1);
}

const study_row *study_find(const study_table *table, const double *keys) {
  for (int k = 0; k < table->count; k++)
    if (memcmp(table->rows[k].keys, keys, sizeof table->rows[k].keys) == 0) return &table->rows[k];
  return NULL;
}

bool study_failed(const study_row *row) { return strcmp(row->status, "SPH_OK") != 0; }

static void keep(study_table *table, const study_row *row) {
  if (table->count == table->room) {
    table->room = table->room > 0 ? 2 * table->room : 64;
    study_row *rows = example_memory(table->room, sizeof *rows);
    if (table->count > 0) memcpy(rows, table->rows, (size_t)table->count * sizeof *rows);
    free(table->rows);
    table->rows = rows;
  }
  table->rows[table->count++] = *row;
}

/* A text in quotes, with what would end it or the row left out. */
static void write_row(FILE *file, const study_row *row, int figures) {
  for (int k = 0; k < STUDY_KEYS; k++) fprintf(file, "%.9g,", row->keys[k]);
  for (int k = 0; k < figures; k++)
    fprintf(file, isfinite(row->figures[k]) ? "%.9g," : "nan,", row->figures[k]);
  fprintf(file, "%s,\"", row->status);
  for (const char *at = row->message; *at != '\0'; at++)
    fputc((unsigned char)*at < ' ' ? ' ' : *at == '"' ? '\'' : *at, file);
  fputs("\"\n", file);
}

static bool read_number(const char **at, double *value) {
  char *after = NULL;
  *value = strtod(*at, &after);
  const bool good = after != *at && *after == ',';
  *at = after + good;
  return good;
}

static bool read_row(const char *line, int figures, study_row *row) {
  bool good = true;
  for (int k = 0; k < STUDY_KEYS && good; k++)
    good = read_number(&line, &row->keys[k]) && isfinite(row->keys[k]);
  for (int k = 0; k < figures && good; k++) good = read_number(&line, &row->figures[k]);
  if (!good) return false;
  const size_t status = strspn(line, "ABCDEFGHIJKLMNOPQRSTUVWXYZ_");
  if (status == 0 || status >= sizeof row->status || strncmp(line + status, ",\"", 2) != 0)
    return false;
  snprintf(row->status, sizeof row->status, "%.*s", (int)status, line);
  line += status + 2;
  const size_t message = strcspn(line, "\"");
  if (message >= sizeof row->message || strcmp(line + message, "\"\n") != 0) return false;
  snprintf(row->message, sizeof row->message, "%.*s", (int)message, line);
  return true;
}

/* Whether the file begins with the header; one that ends in the middle of it has nothing yet. */
static bool read_header(const study_table *table) {
  const size_t length = strlen(table->header);
  char *text = example_memory((int64_t)length + 1, 1);
  const size_t got = fread(text, 1, length, table->file);
  size_t same = 0;
  while (same < got && text[same] == table->header[same]) same++;
  if (same < got) {
    while (same > 0 && table->header[same - 1] != '\n') same--;
    example_refuse("--out", "%s is not of this study: it has \"%.*s\" instead of \"%.*s\"",
                   table->path, (int)strcspn(text + same, "\n"), text + same,
                   (int)strcspn(table->header + same, "\n"), table->header + same);
  }
  free(text);
  return got == length;
}

static void read_rows(study_table *table, bool retry) {
  char line[LINE];
  int number = 0;
  for (const char *at = table->header; *at != '\0'; at++) number += *at == '\n';
  while (fgets(line, sizeof line, table->file) != NULL) {
    study_row row = {0};
    const bool whole = strchr(line, '\n') != NULL;
    if (!whole && feof(table->file)) return;
    number++;
    if (!whole || !read_row(line, table->figures, &row))
      example_refuse("--out", "%s: line %d is no row of a study", table->path, number);
    if (study_find(table, row.keys))
      example_refuse("--out", "%s: line %d has a run for the second time", table->path, number);
    if (table->count == MOST_ROWS)
      example_refuse("--out", "%s has more than %d rows", table->path, MOST_ROWS);
    if (!retry || !study_failed(&row)) keep(table, &row);
  }
  if (ferror(table->file)) stop(table, "cannot be read");
}

/* Two studies must not write to one file. File systems without locks go without. */
static void lock(const study_table *table, FILE *file) {
  struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
  if (fcntl(fileno(file), F_SETLK, &whole) != 0 && (errno == EACCES || errno == EAGAIN))
    example_refuse("--out", "%s is in use by another study", table->path);
}

static int by_keys(const void *a, const void *b) {
  const study_row *one = a, *two = b;
  for (int k = 0; k < STUDY_KEYS; k++)
    if (one->keys[k] != two->keys[k]) return one->keys[k] < two->keys[k] ? -1 : 1;
  return 0;
}

/* Puts a new file in the place of the old one, whole at any time, and goes on with it. */
static void rewrite(study_table *table) {
  const size_t length = strlen(table->path) + 5;
  char *path = example_memory((int64_t)length, 1);
  snprintf(path, length, "%s.new", table->path);
  FILE *file = fopen(path, "w");
  if (file == NULL) example_refuse("--out", "%s: %s", path, strerror(errno));
  lock(table, file);
  if (table->count > 0) qsort(table->rows, (size_t)table->count, sizeof *table->rows, by_keys);
  fputs(table->header, file);
  for (int k = 0; k < table->count; k++) write_row(file, &table->rows[k], table->figures);
  if (fflush(file) != 0 || ferror(file) || rename(path, table->path) != 0)
    stop(table, "cannot be written anew");
  free(path);
  fclose(table->file);
  table->file = file;
}

void study_open(study_table *table, bool retry) {
  struct stat about;
  if (stat(table->path, &about) == 0 && !S_ISREG(about.st_mode))
    example_refuse("--out", "%s is no plain file", table->path);
  const int descriptor = open(table->path, O_RDWR | O_CREAT, 0666);
  table->file = descriptor >= 0 ? fdopen(descriptor, "r+") : NULL;
  if (table->file == NULL) example_refuse("--out", "%s: %s", table->path, strerror(errno));
  lock(table, table->file);
  if (read_header(table)) read_rows(table, retry);
  rewrite(table);
}

void study_add(study_table *table, const study_row *row) {
  keep(table, row);
  write_row(table->file, row, table->figures);
  if (fflush(table->file) != 0 || ferror(table->file)) stop(table, "cannot take a row");
}

void study_close(study_table *table) {
  rewrite(table);
  fclose(table->file);
  free(table->rows);
}

/* --------------------------------------------------------------------------------------- runs */

typedef struct queue {
  pthread_mutex_t mutex;
  study_table *table;
  study_row *rows;
  int count, next, done, failed;
  double start;
  void (*compute)(study_row *row, void *user);
  void *user;
} queue;

static void tell(const queue *q, const study_row *row) {
  const double seconds = example_clock() - q->start;
  printf("%d of %d: %g, %g, %g: %s%s%s; %d failed, %.0f s left\n", q->done, q->count, row->keys[0],
         row->keys[1], row->keys[2], row->status, *row->message != '\0' ? ": " : "", row->message,
         q->failed, seconds * (q->count - q->done) / q->done);
  fflush(stdout);
}

static void *take_jobs(void *user) {
  queue *q = user;
  pthread_mutex_lock(&q->mutex);
  while (q->next < q->count) {
    study_row *row = &q->rows[q->next++];
    pthread_mutex_unlock(&q->mutex);
    for (int k = 0; k < STUDY_FIGURES; k++) row->figures[k] = NAN;
    q->compute(row, q->user);
    pthread_mutex_lock(&q->mutex);
    study_add(q->table, row);
    q->done++;
    q->failed += study_failed(row);
    tell(q, row);
  }
  pthread_mutex_unlock(&q->mutex);
  return NULL;
}

void study_run(study_table *table, int count, study_row *rows, int processors,
               void (*compute)(study_row *row, void *user), void *user) {
  queue q = {.mutex = PTHREAD_MUTEX_INITIALIZER,
             .table = table,
             .rows = rows,
             .count = count,
             .start = example_clock(),
             .compute = compute,
             .user = user};
  const int threads = processors < count ? processors : count;
  pthread_t *others = example_memory(threads, sizeof *others);
  int started = 0;
  /* This thread works too; where no more are to be had, it and those there are do all. */
  while (started < threads - 1 && pthread_create(&others[started], NULL, take_jobs, &q) == 0)
    started++;
  take_jobs(&q);
  for (int k = 0; k < started; k++) pthread_join(others[k], NULL);
  free(others);
}
