/* Text and binary files that appear under their name only when they are complete. */
#ifndef SPHI_FILE_H
#define SPHI_FILE_H

#include "core/internal.h"

typedef struct sphi_file sphi_file;

/* Starts writing `path`; the data go to path.tmp until the commit. SPH_E_IO names the file and the
 * system's reason. The file keeps the context's pointer, not a reference. */
sph_status sphi_file_open(sph_context *context, const char *path, sphi_file **out);

/* These remember the first failure for the commit and write nothing more after it. */
void sphi_file_write(sphi_file *file, const void *data, size_t bytes);
/* As printf, but with '.' for the decimal point whatever the caller's locale is. */
void sphi_file_printf(sphi_file *file, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* The text with <, >, &, " and ' as XML entities, and '?' for characters that XML forbids. */
void sphi_file_xml(sphi_file *file, const char *text);

/* Closes the file, gives it its name, frees *file and sets it to NULL. On failure the temporary file is
 * gone, what was under the name before is still there, and SPH_E_IO tells the system's reason. */
sph_status sphi_file_commit(sphi_file **file);
/* Closes and removes the temporary file, frees *file and sets it to NULL. NULL is allowed. */
void sphi_file_abandon(sphi_file **file);

#endif
