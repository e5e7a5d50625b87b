/* Files that appear under their name only when they are complete. */
#define _POSIX_C_SOURCE 200809L
#ifdef __APPLE__
#include <xlocale.h>
#endif
#include <errno.h>
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>

#include "core/file.h"

#define BUFFER_BYTES 65536

struct sphi_file {
  sph_context *context;
  FILE *stream;
  char *path, *temporary; /* one block: path.tmp follows path */
  char *buffer;
  locale_t plain; /* numbers as in C */
  int error;      /* errno of the first failure, 0 as long as there was none */
};

static void release(sphi_file *file) {
  if (file->plain) freelocale(file->plain);
  sphi_free(file->context, file->buffer);
  sphi_free(file->context, file->path);
  sphi_free(file->context, file);
}

static const char *reason(int error) { return error ? strerror(error) : "unknown reason"; }

sph_status sphi_file_open(sph_context *context, const char *path, sphi_file **out) {
  *out = NULL;
  static const char suffix[] = ".tmp";
  const size_t length = strlen(path);
  sph_status status = SPH_OK;
  sphi_file *file = SPHI_NEW(context, 1, sphi_file);
  SPH_CHECK(context, file, SPH_E_MEMORY, "file \"%s\": out of memory", path);
  file->context = context;
  file->path = sphi_alloc(context, 2 * length + 1 + sizeof suffix, 1);
  file->buffer = sphi_alloc(context, BUFFER_BYTES, 1);
  file->plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  if (!file->path || !file->buffer || !file->plain) {
    status = SPHI_ERROR(context, SPH_E_MEMORY, "file \"%s\": out of memory", path);
    goto fail;
  }
  memcpy(file->path, path, length + 1);
  file->temporary = file->path + length + 1;
  memcpy(file->temporary, path, length);
  memcpy(file->temporary + length, suffix, sizeof suffix);
  errno = 0;
  file->stream = fopen(file->temporary, "wb");
  if (!file->stream) {
    status = SPHI_ERROR(context, SPH_E_IO, "file \"%s\": cannot be created: %s", file->temporary,
                        reason(errno));
    goto fail;
  }
  setvbuf(file->stream, file->buffer, _IOFBF, BUFFER_BYTES);
  *out = file;
  return SPH_OK;
fail:
  release(file);
  return status;
}

static void remember(sphi_file *file) {
  if (!file->error) file->error = errno ? errno : EIO;
}

void sphi_file_write(sphi_file *file, const void *data, size_t bytes) {
  if (file->error || bytes == 0) return;
  errno = 0;
  if (fwrite(data, 1, bytes, file->stream) != bytes) remember(file);
}

void sphi_file_printf(sphi_file *file, const char *format, ...) {
  if (file->error) return;
  va_list arguments;
  va_start(arguments, format);
  /* Of this thread only: the caller's other threads and its own locale stay as they are. */
  const locale_t before = uselocale(file->plain);
  errno = 0;
  if (vfprintf(file->stream, format, arguments) < 0) remember(file);
  uselocale(before);
  va_end(arguments);
}

void sphi_file_xml(sphi_file *file, const char *text) {
  for (; *text; text++) {
    const unsigned char c = (unsigned char)*text;
    const char *entity = c == '<'                ? "&lt;"
                         : c == '>'              ? "&gt;"
                         : c == '&'              ? "&amp;"
                         : c == '"'              ? "&quot;"
                         : c == '\''             ? "&apos;"
                         : c < 0x20 || c == 0x7f ? "?"
                                                 : NULL;
    if (entity)
      sphi_file_write(file, entity, strlen(entity));
    else
      sphi_file_write(file, text, 1);
  }
}

sph_status sphi_file_commit(sphi_file **file) {
  sphi_file *done = *file;
  sph_context *context = done->context;
  *file = NULL;
  errno = 0;
  if (fflush(done->stream) != 0 || ferror(done->stream)) remember(done);
  errno = 0;
  if (fclose(done->stream) != 0) remember(done);
  errno = 0;
  if (!done->error && rename(done->temporary, done->path) != 0) remember(done);
  sph_status status = SPH_OK;
  if (done->error) {
    remove(done->temporary);
    status = SPHI_ERROR(context, SPH_E_IO, "file \"%s\": cannot be written: %s", done->path,
                        reason(done->error));
  }
  release(done);
  return status;
}

void sphi_file_abandon(sphi_file **file) {
  if (!file || !*file) return;
  fclose((*file)->stream);
  remove((*file)->temporary);
  release(*file);
  *file = NULL;
}
