/* Output from the inside: what a frame is, and the functions that write one format. */
#ifndef SPHI_OUTPUT_IMPL_H
#define SPHI_OUTPUT_IMPL_H

#include <inttypes.h>
#include <sph/output.h>

#include "core/internal.h"

#define SPHI_FRAME_COMPONENTS 9 /* of a field at most */

typedef struct sphi_frame_field {
  const char *name, *unit; /* unit NULL: none */
  int components;
  const double *values; /* [count, components]; NULL: read from the particles when its turn comes */
} sphi_frame_field;

typedef struct sphi_frame {
  const sph_particles *particles; /* NULL: points, without ids */
  int64_t count;
  int dim;
  const double *x; /* [count, dim]; NULL as in a field */
  int fields;
  const sphi_frame_field *field;
  double time;
  bool single;
  void *scratch; /* room for the largest array of the particles */
} sphi_frame;

/* Writes a complete file at `path` or leaves what was there. */
sph_status sphi_vtk_write_frame(sph_context *context, const char *path, const sphi_frame *frame);
sph_status sphi_vtk_write_series(sph_context *context, const char *path, const char *name,
                                 const char *extension, int64_t frames, const double *times);

/* Format of a frame's file name after that of the series: its number and extension. */
#define SPHI_FRAME_SUFFIX "_%06" PRId64 ".%s"

#endif
