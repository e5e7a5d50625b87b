/* The file of a checkpoint:
 *
 *   "SPHKEEP" 0     8 bytes
 *   1               int64_t, by which a machine of the other byte order knows that it is
 *   version         int64_t
 *   sections        name [SPHI_KEEP_NAME], int64_t type, int64_t count, values, zeros up to a multiple of 8 bytes
 *   checksum        uint64_t, of everything before
 *
 * in the byte order of the machine. */
#define _POSIX_C_SOURCE 200809L
#include "core/keep.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <sys/stat.h>

#include "core/file.h"

enum { VERSION = 1, HEADER = 24, HEAD = SPHI_KEEP_NAME + 16, SUM = 8, MOST_APART = 32 };

static const char magic[8] = "SPHKEEP";

/* FNV-1a of words of 8 bytes, folded, so that high bits count everywhere. */
static uint64_t add_to_sum(uint64_t sum, const void *data, size_t bytes) {
  uint64_t word;
  for (size_t at = 0; at < bytes; at += sizeof word) {
    memcpy(&word, (const char *)data + at, sizeof word);
    sum = (sum ^ word) * UINT64_C(0x100000001b3);
    sum ^= sum >> 32;
  }
  return sum;
}

static const uint64_t first_sum = UINT64_C(0xcbf29ce484222325);

static size_t size_of(int64_t type) { return type == SPHI_KEEP_INDICES ? 4 : 8; }

static size_t padded(size_t bytes) { return (bytes + 7) / 8 * 8; }

/* ---- writing ---- */

static void put(sphi_keep *keep, const void *data, size_t bytes) {
  keep->sum = add_to_sum(keep->sum, data, bytes);
  sphi_file_write(keep->file, data, bytes);
}

sph_status sphi_keep_create(sph_context *context, const char *path, sphi_keep *keep) {
  *keep = (sphi_keep){.context = context, .path = path, .act = SPHI_KEEP_WRITE, .sum = first_sum};
  const int64_t numbers[2] = {1, VERSION};
  SPH_TRY(sphi_file_open(context, path, &keep->file));
  put(keep, magic, sizeof magic);
  put(keep, numbers, sizeof numbers);
  return SPH_OK;
}

sph_status sphi_keep_finish(sphi_keep *keep) {
  sphi_file_write(keep->file, &keep->sum, sizeof keep->sum);
  return sphi_file_commit(&keep->file);
}

static void put_section(sphi_keep *keep, const char *name, sphi_keep_type type, int64_t count,
                        const void *values) {
  char words[SPHI_KEEP_NAME] = {0};
  const int64_t numbers[2] = {type, count};
  const size_t bytes = (size_t)count * size_of(type), whole = bytes / 8 * 8;
  snprintf(words, sizeof words, "%s", name);
  put(keep, words, sizeof words);
  put(keep, numbers, sizeof numbers);
  put(keep, values, whole);
  char rest[8] = {0};
  memcpy(rest, (const char *)values + whole, bytes - whole);
  if (bytes > whole) put(keep, rest, sizeof rest);
}

/* ---- reading ---- */

static const char *name_at(const sphi_keep *keep, size_t at) {
  return (const char *)keep->data + at;
}

static void numbers_at(const sphi_keep *keep, size_t at, int64_t *type, int64_t *count) {
  memcpy(type, keep->data + at + SPHI_KEEP_NAME, sizeof *type);
  memcpy(count, keep->data + at + SPHI_KEEP_NAME + 8, sizeof *count);
}

/* Where the section after a sound one begins. */
static size_t next_of(const sphi_keep *keep, size_t at) {
  int64_t type, count;
  numbers_at(keep, at, &type, &count);
  return at + HEAD + padded((size_t)count * size_of(type));
}

static bool is_end(const sphi_keep *keep, size_t at) { return at + SUM == keep->bytes; }

#define BROKEN(keep, condition, ...) \
  SPH_CHECK((keep)->context, condition, SPH_E_IO, "checkpoint \"%s\": " __VA_ARGS__)

static sph_status check_header(const sphi_keep *keep) {
  int64_t numbers[2];
  BROKEN(keep, keep->bytes >= HEADER + SUM && memcmp(keep->data, magic, sizeof magic) == 0,
         "is none: the file of %zu bytes does not begin as one", keep->path, keep->bytes);
  memcpy(numbers, keep->data + sizeof magic, sizeof numbers);
  BROKEN(keep, numbers[0] != INT64_C(0x0100000000000000),
         "is from a machine of the other byte order; numbers are in the writer's", keep->path);
  BROKEN(keep, numbers[0] == 1, "the mark of the byte order is %" PRId64 ", it must be 1",
         keep->path, numbers[0]);
  BROKEN(keep, numbers[1] == VERSION, "has version %" PRId64 ", this library reads %d", keep->path,
         numbers[1], VERSION);
  BROKEN(keep, keep->bytes % 8 == 0, "ends in the middle of a number, at byte %zu", keep->path,
         keep->bytes);
  return SPH_OK;
}

static bool is_name(const char *text) {
  size_t n = 0;
  while (n < SPHI_KEEP_NAME && text[n] > ' ' && text[n] < 127) n++;
  return n > 0 && n < SPHI_KEEP_NAME && text[n] == '\0';
}

/* Sections follow each other up to the checksum, and no number is NaN or infinite. */
static sph_status check_sections(const sphi_keep *keep) {
  int number = 0;
  for (size_t at = HEADER; !is_end(keep, at); at = next_of(keep, at), number++) {
    const size_t left = keep->bytes - SUM - at;
    int64_t type, count;
    BROKEN(keep, number < SPHI_KEEP_SECTIONS, "has more than %d sections", keep->path,
           SPHI_KEEP_SECTIONS);
    BROKEN(keep, left >= HEAD, "ends in the head of section %d, at byte %zu", keep->path, number,
           keep->bytes);
    const char *name = name_at(keep, at);
    BROKEN(keep, is_name(name), "section %d, at byte %zu, has no name", keep->path, number, at);
    numbers_at(keep, at, &type, &count);
    BROKEN(keep, type >= SPHI_KEEP_REALS && type <= SPHI_KEEP_INDICES,
           "section \"%s\" has the unknown type %" PRId64, keep->path, name, type);
    BROKEN(keep,
           count >= 0 && (uint64_t)count <= left &&
               padded((size_t)count * size_of(type)) <= left - HEAD,
           "section \"%s\" of %" PRId64 " numbers goes beyond the end of the file", keep->path,
           name, count);
  }
  return SPH_OK;
}

static sph_status check_numbers(const sphi_keep *keep) {
  for (size_t at = HEADER; !is_end(keep, at); at = next_of(keep, at)) {
    int64_t type, count;
    numbers_at(keep, at, &type, &count);
    const double *values = (const void *)(keep->data + at + HEAD);
    for (int64_t k = 0; k < count && type == SPHI_KEEP_REALS; k++)
      BROKEN(keep, isfinite(values[k]), "section \"%s\": number %" PRId64 " is not finite",
             keep->path, name_at(keep, at), k);
  }
  return SPH_OK;
}

static sph_status read_whole(sph_context *context, const char *path, sphi_keep *keep) {
  struct stat about;
  errno = 0;
  FILE *stream = fopen(path, "rb");
  SPH_CHECK(context, stream, SPH_E_IO, "checkpoint \"%s\": cannot be opened: %s", path,
            strerror(errno));
  sph_status status = SPH_OK;
  errno = 0;
  if (fstat(fileno(stream), &about) != 0 || !S_ISREG(about.st_mode)) {
    status = SPHI_ERROR(context, SPH_E_IO, "checkpoint \"%s\": is no plain file", path);
  } else {
    keep->bytes = (size_t)about.st_size;
    keep->data = sphi_alloc(context, keep->bytes + 8, 1);
    if (!keep->data)
      status = SPHI_ERROR(context, SPH_E_MEMORY, "checkpoint \"%s\": no memory for %zu bytes", path,
                          keep->bytes);
    else if (fread(keep->data, 1, keep->bytes, stream) != keep->bytes)
      status = SPHI_ERROR(context, SPH_E_IO, "checkpoint \"%s\": cannot be read: %s", path,
                          errno ? strerror(errno) : "it became shorter");
  }
  fclose(stream);
  return status;
}

static sph_status check_file(const sphi_keep *keep) {
  uint64_t sum;
  SPH_TRY(check_header(keep));
  SPH_TRY(check_sections(keep));
  memcpy(&sum, keep->data + keep->bytes - SUM, SUM);
  const uint64_t found = add_to_sum(first_sum, keep->data, keep->bytes - SUM);
  BROKEN(keep, found == sum, "is damaged: its checksum is %016" PRIx64 ", it should be %016" PRIx64,
         keep->path, found, sum);
  return check_numbers(keep);
}

sph_status sphi_keep_open(sph_context *context, const char *path, sphi_keep *keep) {
  *keep = (sphi_keep){.context = context, .path = path, .act = SPHI_KEEP_CHECK};
  sph_status status = read_whole(context, path, keep);
  if (status == SPH_OK) status = check_file(keep);
  if (status != SPH_OK) sphi_keep_close(keep);
  return status;
}

void sphi_keep_close(sphi_keep *keep) {
  sphi_file_abandon(&keep->file);
  sphi_free(keep->context, keep->data);
  keep->data = NULL;
}

/* ---- sections ---- */

const void *sphi_keep_find(sphi_keep *keep, const char *name, sphi_keep_type type, int64_t *count) {
  int number = 0;
  for (size_t at = HEADER; !is_end(keep, at); at = next_of(keep, at), number++) {
    int64_t kind;
    if (strcmp(name_at(keep, at), name) != 0) continue;
    numbers_at(keep, at, &kind, count);
    if (kind != (int64_t)type) return NULL;
    keep->asked[number / 64] |= UINT64_C(1) << number % 64;
    return keep->data + at + HEAD;
  }
  return NULL;
}

sph_status sphi_keep_all_asked(const sphi_keep *keep) {
  int number = 0;
  for (size_t at = HEADER; !is_end(keep, at); at = next_of(keep, at), number++)
    SPH_CHECK(keep->context, keep->asked[number / 64] >> number % 64 & 1, SPH_E_ARGUMENT,
              "checkpoint \"%s\": section \"%s\" is of something that the flow does not have",
              keep->path, name_at(keep, at));
  return SPH_OK;
}

static sph_status check_section(sphi_keep *keep, const char *name, sphi_keep_type type,
                                int64_t count) {
  int64_t found;
  SPH_CHECK(keep->context, sphi_keep_find(keep, name, type, &found), SPH_E_ARGUMENT,
            "checkpoint \"%s\": it has no section \"%s\", which the flow wants", keep->path, name);
  SPH_CHECK(keep->context, found == count, SPH_E_ARGUMENT,
            "checkpoint \"%s\": section \"%s\" has %" PRId64 " numbers, the flow wants %" PRId64,
            keep->path, name, found, count);
  return SPH_OK;
}

sph_status sphi_keep_section(sphi_keep *keep, const char *name, sphi_keep_type type, int64_t count,
                             void *values) {
  int64_t found;
  if (keep->act == SPHI_KEEP_CHECK) return check_section(keep, name, type, count);
  if (keep->act == SPHI_KEEP_LOAD) {
    const void *from = sphi_keep_find(keep, name, type, &found);
    if (count > 0) memcpy(values, from, (size_t)count * size_of(type));
    return SPH_OK;
  }
  for (int64_t k = 0; k < count && type == SPHI_KEEP_REALS; k++)
    SPH_CHECK(keep->context, isfinite(((const double *)values)[k]), SPH_E_DIVERGED,
              "checkpoint \"%s\": number %" PRId64 " of \"%s\" is not finite", keep->path, k, name);
  put_section(keep, name, type, count, values);
  return SPH_OK;
}

sph_status sphi_keep_reals(sphi_keep *keep, const char *name, int count, double *const *values) {
  double together[MOST_APART];
  for (int k = 0; k < count; k++) together[k] = *values[k];
  SPH_TRY(sphi_keep_section(keep, name, SPHI_KEEP_REALS, count, together));
  for (int k = 0; k < count && keep->act == SPHI_KEEP_LOAD; k++) *values[k] = together[k];
  return SPH_OK;
}

sph_status sphi_keep_wholes(sphi_keep *keep, const char *name, int count, int64_t *const *values) {
  int64_t together[MOST_APART];
  for (int k = 0; k < count; k++) together[k] = *values[k];
  SPH_TRY(sphi_keep_section(keep, name, SPHI_KEEP_WHOLES, count, together));
  for (int k = 0; k < count && keep->act == SPHI_KEEP_LOAD; k++) *values[k] = together[k];
  return SPH_OK;
}

sph_status sphi_keep_common(sphi_keep *keep, const char *name, int count, const double *values) {
  double together[MOST_APART];
  memcpy(together, values, (size_t)count * sizeof *values);
  SPH_TRY(sphi_keep_section(keep, name, SPHI_KEEP_REALS, count, together));
  int64_t found;
  const double *there =
      keep->act == SPHI_KEEP_CHECK ? sphi_keep_find(keep, name, SPHI_KEEP_REALS, &found) : NULL;
  for (int k = 0; k < count && there; k++)
    SPH_CHECK(keep->context, fabs(there[k] - values[k]) <= 1e-12 * fabs(values[k]), SPH_E_ARGUMENT,
              "checkpoint \"%s\": number %d of \"%s\" is %.15g, that of the flow is %.15g",
              keep->path, k, name, there[k], values[k]);
  return SPH_OK;
}
