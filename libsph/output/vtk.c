/* VTK XML PolyData with appended raw data, and the ParaView collection of a series.
 *
 * Layout of the appended data: '_', then for each array its size in bytes as UInt64 and its values.
 * The header names each array with its offset after the '_'. */
#include <float.h>
#include <sph/particles.h>

#include "core/file.h"
#include "output/output_impl.h"

enum { CHUNK = 2048 };

typedef struct writer {
  sphi_file *file;
  const sphi_frame *frame;
  int64_t offset; /* of the next array, while the header is written */
} writer;

static const char *byte_order(void) {
  const uint16_t one = 1;
  unsigned char first;
  memcpy(&first, &one, 1);
  return first ? "LittleEndian" : "BigEndian";
}

/* Vectors of two components are written with a third, 0: ParaView wants three. */
static int written_components(int components) { return components == 2 ? 3 : components; }

static int64_t real_bytes(const sphi_frame *frame, int components) {
  return frame->count * written_components(components) * (frame->single ? 4 : 8);
}

/* The header's element of one array. */
static void declare(writer *w, const char *type, const char *name, const char *unit, int components,
                    int64_t bytes) {
  sphi_file_printf(w->file, "        <DataArray type=\"%s\" Name=\"", type);
  sphi_file_xml(w->file, name);
  sphi_file_printf(w->file,
                   "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%" PRId64 "\"",
                   components, w->offset);
  if (unit) {
    sphi_file_printf(w->file,
                     ">\n          <InformationKey name=\"UNITS_LABEL\" "
                     "location=\"vtkDataArray\">");
    sphi_file_xml(w->file, unit);
    sphi_file_printf(w->file, "</InformationKey>\n        </DataArray>\n");
  } else {
    sphi_file_printf(w->file, "/>\n");
  }
  w->offset += (int64_t)sizeof(uint64_t) + bytes;
}

static void declare_real(writer *w, const char *name, const char *unit, int components) {
  declare(w, w->frame->single ? "Float32" : "Float64", name, unit, written_components(components),
          real_bytes(w->frame, components));
}

static void write_header(writer *w) {
  const sphi_frame *frame = w->frame;
  const int64_t n = frame->count;
  sphi_file_printf(w->file,
                   "<?xml version=\"1.0\"?>\n"
                   "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"%s\" "
                   "header_type=\"UInt64\">\n"
                   "  <PolyData>\n"
                   "    <FieldData>\n"
                   "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
                   "format=\"ascii\">%.17g</DataArray>\n"
                   "    </FieldData>\n"
                   "    <Piece NumberOfPoints=\"%" PRId64 "\" NumberOfVerts=\"%" PRId64
                   "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
                   "      <PointData>\n",
                   byte_order(), frame->time, n, n);
  for (int k = 0; k < frame->fields; k++)
    declare_real(w, frame->field[k].name, frame->field[k].unit, frame->field[k].components);
  if (frame->particles) declare(w, "Int64", "id", NULL, 1, 8 * n);
  sphi_file_printf(w->file, "      </PointData>\n      <Points>\n");
  declare_real(w, "Points", NULL, frame->dim);
  sphi_file_printf(w->file, "      </Points>\n      <Verts>\n");
  declare(w, "Int32", "connectivity", NULL, 1, 4 * n);
  declare(w, "Int32", "offsets", NULL, 1, 4 * n);
  sphi_file_printf(
      w->file, "      </Verts>\n    </Piece>\n  </PolyData>\n  <AppendedData encoding=\"raw\">\n_");
}

static void write_size(writer *w, int64_t bytes) {
  const uint64_t size = (uint64_t)bytes;
  sphi_file_write(w->file, &size, sizeof size);
}

/* A double beyond the range of float has no defined conversion in C. */
static float to_single(double value) {
  if (value > FLT_MAX) return INFINITY;
  if (value < -FLT_MAX) return -INFINITY;
  return (float)value;
}

/* values [count, components] as Float32 or Float64. */
static void write_real(writer *w, int components, const double *values) {
  const sphi_frame *frame = w->frame;
  const int written = written_components(components);
  union {
    float single[CHUNK];
    double full[CHUNK];
  } chunk;
  const size_t size = frame->single ? sizeof(float) : sizeof(double);
  size_t filled = 0;
  write_size(w, real_bytes(frame, components));
  for (int64_t i = 0; i < frame->count; i++) {
    for (int d = 0; d < written; d++) {
      const double value = d < components ? values[i * components + d] : 0.0;
      if (frame->single)
        chunk.single[filled++] = to_single(value);
      else
        chunk.full[filled++] = value;
    }
    if (filled > CHUNK - SPHI_FRAME_COMPONENTS || i + 1 == frame->count) {
      sphi_file_write(w->file, &chunk, filled * size);
      filled = 0;
    }
  }
}

/* first, first + 1 ... as Int32. */
static void write_count_up(writer *w, int32_t first) {
  int32_t chunk[CHUNK];
  write_size(w, 4 * w->frame->count);
  for (int64_t i = 0; i < w->frame->count;) {
    size_t filled = 0;
    for (; filled < CHUNK && i < w->frame->count; i++) chunk[filled++] = first + (int32_t)i;
    sphi_file_write(w->file, chunk, filled * sizeof *chunk);
  }
}

static sph_status write_field(writer *w, const char *name, int components, const double *values) {
  const sphi_frame *frame = w->frame;
  if (!values && frame->particles) {
    SPH_TRY(sph_particles_read(frame->particles, name, frame->scratch, frame->count * components));
    values = frame->scratch;
  }
  write_real(w, components, values);
  return SPH_OK;
}

static sph_status write_arrays(writer *w) {
  const sphi_frame *frame = w->frame;
  for (int k = 0; k < frame->fields; k++)
    SPH_TRY(
        write_field(w, frame->field[k].name, frame->field[k].components, frame->field[k].values));
  if (frame->particles) {
    SPH_TRY(sph_particles_read_ids(frame->particles, frame->scratch, frame->count));
    write_size(w, 8 * frame->count);
    sphi_file_write(w->file, frame->scratch, (size_t)frame->count * sizeof(int64_t));
  }
  SPH_TRY(write_field(w, SPH_POSITION, frame->dim, frame->x));
  write_count_up(w, 0);
  write_count_up(w, 1);
  return SPH_OK;
}

sph_status sphi_vtk_write_frame(sph_context *context, const char *path, const sphi_frame *frame) {
  writer w = {.frame = frame};
  SPH_TRY(sphi_file_open(context, path, &w.file));
  write_header(&w);
  const sph_status status = write_arrays(&w);
  if (status != SPH_OK) {
    sphi_file_abandon(&w.file);
    return status;
  }
  sphi_file_printf(w.file, "\n  </AppendedData>\n</VTKFile>\n");
  return sphi_file_commit(&w.file);
}

sph_status sphi_vtk_write_series(sph_context *context, const char *path, const char *name,
                                 const char *extension, int64_t frames, const double *times) {
  sphi_file *file;
  SPH_TRY(sphi_file_open(context, path, &file));
  sphi_file_printf(file,
                   "<?xml version=\"1.0\"?>\n"
                   "<VTKFile type=\"Collection\" version=\"0.1\">\n"
                   "  <Collection>\n");
  for (int64_t k = 0; k < frames; k++) {
    sphi_file_printf(file, "    <DataSet timestep=\"%.17g\" part=\"0\" file=\"", times[k]);
    sphi_file_xml(file, name);
    sphi_file_printf(file, SPHI_FRAME_SUFFIX "\"/>\n", k, extension);
  }
  sphi_file_printf(file, "  </Collection>\n</VTKFile>\n");
  return sphi_file_commit(&file);
}
