/* Two columns of a file of comma-separated values as a series. */
#define _POSIX_C_SOURCE 200809L
#ifdef __APPLE__
#include <xlocale.h>
#endif
#include <errno.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>

#include "paddle/paddle_impl.h"

enum { LINE_BYTES = 65536, MAX_COLUMNS = 4096 };

typedef struct reader {
  sph_context *context;
  const char *path;
  FILE *stream;
  char *line;       /* [LINE_BYTES] the present one, cut into fields */
  char **field;     /* [MAX_COLUMNS] */
  long long number; /* of the line, from 1 */
  int fields;
  const char *wanted[2]; /* names of the columns of time and displacement */
  int column[2], columns;
  double *value[2];
  int64_t capacity[2], rows;
} reader;

#define CSV_CHECK(r, condition, code, ...) \
  SPH_CHECK((r)->context, condition, code, "paddle: file \"%.300s\"" __VA_ARGS__)

/* Reads the next line that counts; *more is false at the end of the file. */
static sph_status next_line(reader *r, bool *more) {
  for (;;) {
    int length = 0, c;
    errno = 0;
    while ((c = getc(r->stream)) != EOF && c != '\n') {
      CSV_CHECK(r, c != 0, SPH_E_IO, ", line %lld: a zero byte; this is no text", r->path,
                r->number + 1);
      CSV_CHECK(r, length < LINE_BYTES - 1, SPH_E_IO, ", line %lld: longer than %d bytes", r->path,
                r->number + 1, LINE_BYTES - 1);
      r->line[length++] = (char)c;
    }
    CSV_CHECK(r, !ferror(r->stream), SPH_E_IO, ": cannot be read: %s", r->path,
              errno ? strerror(errno) : "unknown reason");
    if (c == EOF && length == 0) {
      *more = false;
      return SPH_OK;
    }
    r->number++;
    r->line[length] = 0;
    if (r->number == 1 && strncmp(r->line, "\xef\xbb\xbf", 3) == 0) /* UTF-8's byte order mark */
      memmove(r->line, r->line + 3, (size_t)length - 2);
    const size_t blanks = strspn(r->line, " \t\r");
    if (r->line[blanks] == 0 || r->line[blanks] == '#') continue;
    *more = true;
    return SPH_OK;
  }
}

/* The text without blanks around it, and without double quotes around that. */
static char *trimmed(char *text) {
  text += strspn(text, " \t\r");
  size_t length = strlen(text);
  while (length > 0 && strchr(" \t\r", text[length - 1])) length--;
  if (length >= 2 && text[0] == '"' && text[length - 1] == '"') {
    text++;
    length -= 2;
  }
  text[length] = 0;
  return text;
}

/* Commas within double quotes do not part fields. */
static sph_status cut_line(reader *r) {
  r->fields = 0;
  char *start = r->line;
  bool quoted = false, last = false;
  for (char *at = r->line; !last; at++) {
    if (*at == '"') quoted = !quoted;
    if (*at != 0 && (*at != ',' || quoted)) continue;
    last = *at == 0;
    *at = 0;
    CSV_CHECK(r, r->fields < MAX_COLUMNS, SPH_E_IO, ", line %lld: more than %d fields", r->path,
              r->number, MAX_COLUMNS);
    r->field[r->fields++] = trimmed(start);
    start = at + 1;
  }
  CSV_CHECK(r, !quoted, SPH_E_IO, ", line %lld: a quote does not end", r->path, r->number);
  return SPH_OK;
}

static sph_status read_header(reader *r) {
  bool more;
  SPH_TRY(next_line(r, &more));
  CSV_CHECK(r, more, SPH_E_IO, ": has no header line", r->path);
  SPH_TRY(cut_line(r));
  r->columns = r->fields;
  for (int w = 0; w < 2; w++) {
    r->column[w] = -1;
    for (int k = 0; k < r->columns; k++) {
      if (strcmp(r->field[k], r->wanted[w]) != 0) continue;
      CSV_CHECK(r, r->column[w] < 0, SPH_E_NAME, ", line %lld: two columns are named \"%.100s\"",
                r->path, r->number, r->wanted[w]);
      r->column[w] = k;
    }
    if (r->column[w] >= 0) continue;
    const char *nearest =
        sphi_nearest_name(r->wanted[w], r->columns, (const char *const *)r->field);
    CSV_CHECK(r, nearest, SPH_E_NAME, ", line %lld: no column is named \"%.100s\"", r->path,
              r->number, r->wanted[w]);
    CSV_CHECK(r, false, SPH_E_NAME,
              ", line %lld: no column is named \"%.100s\"; did you mean \"%.100s\"?", r->path,
              r->number, r->wanted[w], nearest);
  }
  return SPH_OK;
}

static sph_status read_row(reader *r) {
  SPH_TRY(cut_line(r));
  CSV_CHECK(r, r->fields == r->columns, SPH_E_IO, ", line %lld: %d fields, the header has %d",
            r->path, r->number, r->fields, r->columns);
  for (int w = 0; w < 2; w++) {
    const char *text = r->field[r->column[w]];
    char *end;
    const double number = strtod(text, &end);
    CSV_CHECK(r, end != text && *end == 0, SPH_E_IO,
              ", line %lld: column \"%.100s\" has \"%.40s\", which is no number", r->path,
              r->number, r->wanted[w], text);
    CSV_CHECK(r, isfinite(number), SPH_E_ARGUMENT,
              ", line %lld: column \"%.100s\" must be finite, got \"%.40s\"", r->path, r->number,
              r->wanted[w], text);
    CSV_CHECK(r,
              sphi_reserve(r->context, (void **)&r->value[w], &r->capacity[w], r->rows + 1,
                           sizeof(double)),
              SPH_E_MEMORY, ", line %lld: out of memory", r->path, r->number);
    r->value[w][r->rows] = number;
  }
  const double *t = r->value[0];
  CSV_CHECK(r, r->rows == 0 || t[r->rows] > t[r->rows - 1], SPH_E_ARGUMENT,
            ", line %lld: time %.17g s must be after the one before, %.17g s", r->path, r->number,
            t[r->rows], r->rows ? t[r->rows - 1] : 0.0);
  r->rows++;
  return SPH_OK;
}

static sph_status read_file(reader *r) {
  r->line = sphi_alloc(r->context, LINE_BYTES, 1);
  r->field = SPHI_NEW(r->context, MAX_COLUMNS, char *);
  CSV_CHECK(r, r->line && r->field, SPH_E_MEMORY, ": out of memory", r->path);
  errno = 0;
  r->stream = fopen(r->path, "rb");
  CSV_CHECK(r, r->stream, SPH_E_IO, ": cannot be opened: %s", r->path,
            errno ? strerror(errno) : "unknown reason");
  SPH_TRY(read_header(r));
  for (;;) {
    bool more;
    SPH_TRY(next_line(r, &more));
    if (!more) break;
    SPH_TRY(read_row(r));
  }
  CSV_CHECK(r, r->rows >= 2, SPH_E_ARGUMENT, ": a series needs at least 2 rows, got %lld", r->path,
            (long long)r->rows);
  return SPH_OK;
}

sph_status sph_paddle_create_csv(sph_context *context, const char *path, const char *time_column,
                                 const char *displacement_column, sph_paddle **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "paddle \"series\": out is NULL");
  SPH_CHECK(context, path && time_column && displacement_column, SPH_E_ARGUMENT,
            "paddle \"series\": path and names of columns must not be NULL");
  reader r = {.context = context, .path = path, .wanted = {time_column, displacement_column}};
  /* Of this thread only: the caller's other threads and its own locale stay as they are. */
  const locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  SPH_CHECK(context, plain, SPH_E_MEMORY, "paddle \"series\": out of memory");
  const locale_t before = uselocale(plain);
  sph_status status = read_file(&r);
  uselocale(before);
  freelocale(plain);
  if (r.stream) fclose(r.stream);
  sphi_free(context, r.field);
  sphi_free(context, r.line);
  if (status == SPH_OK)
    status = sph_paddle_create_series(context, r.rows, r.value[0], r.value[1], out);
  for (int w = 0; w < 2; w++) sphi_free(context, r.value[w]);
  return status;
}
