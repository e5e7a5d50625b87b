/* Checkpoints: named sections of numbers, written to a file, compared with a run, or taken over by it.
 *
 * A part of a run has one function that hands its numbers to `sphi_keep_...` one section after the other. It is
 * called to write them; then, with what a file has, to check that all fits and to get all memory, which must leave
 * the run as it is; then to load, which cannot fail. */
#ifndef SPHI_KEEP_H
#define SPHI_KEEP_H

#include "core/internal.h"

typedef enum sphi_keep_act { SPHI_KEEP_WRITE, SPHI_KEEP_CHECK, SPHI_KEEP_LOAD } sphi_keep_act;

/* Types of sections: double, int64_t, int32_t. */
typedef enum sphi_keep_type {
  SPHI_KEEP_REALS = 1,
  SPHI_KEEP_WHOLES = 2,
  SPHI_KEEP_INDICES = 3
} sphi_keep_type;

/* Bytes of a section's name with its end; sections of a file. */
enum { SPHI_KEEP_NAME = 80, SPHI_KEEP_SECTIONS = 4096 };

typedef struct sphi_keep {
  sph_context *context;
  const char *path; /* for messages */
  sphi_keep_act act;
  int32_t n; /* particles in the file, once their section has been checked */
  struct sphi_file *file;
  uint64_t sum;
  unsigned char *data; /* of a whole file that has been read */
  size_t bytes;
  uint64_t asked[SPHI_KEEP_SECTIONS / 64]; /* bits: sections that were asked for */
} sphi_keep;

/* Starts to write; sphi_keep_finish gives the file its name. */
sph_status sphi_keep_create(sph_context *context, const char *path, sphi_keep *keep);
sph_status sphi_keep_finish(sphi_keep *keep);
/* Reads a whole file and makes sure that it is a sound one; then `act` is SPHI_KEEP_CHECK. */
sph_status sphi_keep_open(sph_context *context, const char *path, sphi_keep *keep);
/* Nothing is left of a file that has not been finished. */
void sphi_keep_close(sphi_keep *keep);

/* A section of `count` numbers from or to `values`. Real ones must be finite: SPH_E_DIVERGED when they are written,
 * SPH_E_IO in a file. A file without it, or with another count, is SPH_E_ARGUMENT. */
sph_status sphi_keep_section(sphi_keep *keep, const char *name, sphi_keep_type type, int64_t count,
                             void *values);
/* The same for numbers that are not together, 32 at most. */
sph_status sphi_keep_reals(sphi_keep *keep, const char *name, int count, double *const *values);
sph_status sphi_keep_wholes(sphi_keep *keep, const char *name, int count, int64_t *const *values);
/* Settings that the file and the run must have in common; to 12 digits, 32 at most. */
sph_status sphi_keep_common(sphi_keep *keep, const char *name, int count, const double *values);
/* The numbers of a section of the file, or NULL; they count as asked for. */
const void *sphi_keep_find(sphi_keep *keep, const char *name, sphi_keep_type type, int64_t *count);
/* SPH_E_ARGUMENT if the file has sections that nobody asked for. */
sph_status sphi_keep_all_asked(const sphi_keep *keep);

#endif
