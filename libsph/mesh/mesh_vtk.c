/* Meshes as VTK XML UnstructuredGrid with appended raw data, as libsph/output/vtk.c has it. */
#include <inttypes.h>

#include "core/file.h"
#include "mesh/mesh_impl.h"

enum { MOST_COMPONENTS = 9, CHUNK = 2048 };

typedef struct writer {
  sphi_file *file;
  const sph_mesh *mesh;
  int64_t offset; /* of the next array, while the header is written */
} writer;

static const char *byte_order(void) {
  const uint16_t one = 1;
  unsigned char first;
  memcpy(&first, &one, 1);
  return first ? "LittleEndian" : "BigEndian";
}

static int64_t cells_of(const writer *w) { return (int64_t)w->mesh->cells + w->mesh->boundary; }
/* Vectors of two components are written with a third, 0: ParaView wants three. */
static int written_components(int components) { return components == 2 ? 3 : components; }

static void declare(writer *w, const char *type, const char *name, const char *unit, int components,
                    int64_t bytes) {
  sphi_file_printf(w->file, "        <DataArray type=\"%s\" Name=\"", type);
  sphi_file_xml(w->file, name);
  sphi_file_printf(w->file,
                   "\" NumberOfComponents=\"%d\" format=\"appended\" offset=\"%" PRId64 "\"",
                   components, w->offset);
  if (unit) {
    sphi_file_printf(
        w->file, ">\n          <InformationKey name=\"UNITS_LABEL\" location=\"vtkDataArray\">");
    sphi_file_xml(w->file, unit);
    sphi_file_printf(w->file, "</InformationKey>\n        </DataArray>\n");
  } else {
    sphi_file_printf(w->file, "/>\n");
  }
  w->offset += (int64_t)sizeof(uint64_t) + bytes;
}

static void declare_fields(writer *w, int64_t count, int fields, const sph_mesh_field *field) {
  for (int k = 0; k < fields; k++) {
    const int components = written_components(field[k].components);
    declare(w, "Float64", field[k].name, field[k].unit, components, 8 * count * components);
  }
}

static void write_header(writer *w, double time, int node_fields, const sph_mesh_field *at_nodes,
                         int cell_fields, const sph_mesh_field *of_cells) {
  const sph_mesh *mesh = w->mesh;
  const int64_t cells = cells_of(w);
  sphi_file_printf(w->file,
                   "<?xml version=\"1.0\"?>\n"
                   "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"%s\" "
                   "header_type=\"UInt64\">\n"
                   "  <UnstructuredGrid>\n"
                   "    <FieldData>\n"
                   "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
                   "format=\"ascii\">%.17g</DataArray>\n"
                   "    </FieldData>\n"
                   "    <Piece NumberOfPoints=\"%d\" NumberOfCells=\"%" PRId64
                   "\">\n"
                   "      <PointData>\n",
                   byte_order(), time, mesh->nodes, cells);
  declare_fields(w, mesh->nodes, node_fields, at_nodes);
  sphi_file_printf(w->file, "      </PointData>\n      <CellData>\n");
  declare_fields(w, cells, cell_fields, of_cells);
  declare(w, "Int32", "tag", NULL, 1, 4 * cells);
  sphi_file_printf(w->file, "      </CellData>\n      <Points>\n");
  declare(w, "Float64", "Points", NULL, 3, 24 * (int64_t)mesh->nodes);
  sphi_file_printf(w->file, "      </Points>\n      <Cells>\n");
  declare(w, "Int32", "connectivity", NULL, 1,
          4 * (3 * (int64_t)mesh->cells + 2 * (int64_t)mesh->boundary));
  declare(w, "Int64", "offsets", NULL, 1, 8 * cells);
  declare(w, "UInt8", "types", NULL, 1, cells);
  sphi_file_printf(w->file,
                   "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n"
                   "  <AppendedData encoding=\"raw\">\n_");
}

static void write_size(writer *w, int64_t bytes) {
  const uint64_t size = (uint64_t)bytes;
  sphi_file_write(w->file, &size, sizeof size);
}

/* values [count, components], then zeros up to `total` rows. */
static void write_real(writer *w, int64_t count, int64_t total, int components,
                       const double *values) {
  const int written = written_components(components);
  double chunk[CHUNK];
  size_t filled = 0;
  write_size(w, 8 * total * written);
  for (int64_t i = 0; i < total; i++) {
    for (int d = 0; d < written; d++)
      chunk[filled++] = i < count && d < components ? values[i * components + d] : 0;
    if (filled <= CHUNK - MOST_COMPONENTS && i + 1 < total) continue;
    sphi_file_write(w->file, chunk, filled * sizeof *chunk);
    filled = 0;
  }
}

static void write_cells(writer *w) {
  const sph_mesh *mesh = w->mesh;
  const int64_t cells = cells_of(w);
  const int32_t none = 0;
  const uint8_t line = 3, triangle = 5;
  write_size(w, 4 * cells);
  for (int32_t c = 0; c < mesh->cells; c++) sphi_file_write(w->file, &none, sizeof none);
  sphi_file_write(w->file, mesh->tag, (size_t)mesh->boundary * sizeof *mesh->tag);
  write_real(w, mesh->nodes, mesh->nodes, 2, mesh->x);
  write_size(w, 4 * (3 * (int64_t)mesh->cells + 2 * (int64_t)mesh->boundary));
  sphi_file_write(w->file, mesh->corner, 3 * (size_t)mesh->cells * sizeof *mesh->corner);
  sphi_file_write(w->file, mesh->ends, 2 * (size_t)mesh->boundary * sizeof *mesh->ends);
  write_size(w, 8 * cells);
  for (int64_t k = 0, end = 0; k < cells; k++) {
    end += k < mesh->cells ? 3 : 2;
    sphi_file_write(w->file, &end, sizeof end);
  }
  write_size(w, cells);
  for (int64_t k = 0; k < cells; k++)
    sphi_file_write(w->file, k < mesh->cells ? &triangle : &line, 1);
}

static sph_status check_fields(sph_context *context, const char *where, int fields,
                               const sph_mesh_field *field) {
  SPH_CHECK(context, fields >= 0 && (fields == 0 || field), SPH_E_ARGUMENT,
            "mesh: fields %s must be >= 0 and not NULL, got %d", where, fields);
  for (int k = 0; k < fields; k++) {
    SPH_CHECK(context, field[k].name && *field[k].name, SPH_E_ARGUMENT,
              "mesh: field %d %s has no name", k, where);
    for (int j = 0; j < k; j++)
      SPH_CHECK(context, strcmp(field[j].name, field[k].name) != 0, SPH_E_ARGUMENT,
                "mesh: field \"%s\" %s is given twice", field[k].name, where);
    SPH_CHECK(context, field[k].components >= 1 && field[k].components <= MOST_COMPONENTS,
              SPH_E_ARGUMENT, "mesh: field \"%s\" %s must have 1 to %d components, got %d",
              field[k].name, where, MOST_COMPONENTS, field[k].components);
    SPH_CHECK(context, field[k].values, SPH_E_ARGUMENT, "mesh: values of field \"%s\" %s are NULL",
              field[k].name, where);
  }
  return SPH_OK;
}

sph_status sph_mesh_write_vtk(const sph_mesh *mesh, const char *path, double time, int node_fields,
                              const sph_mesh_field *at_nodes, int cell_fields,
                              const sph_mesh_field *of_cells) {
  if (!mesh) return SPH_E_ARGUMENT;
  sph_context *context = mesh->context;
  SPH_CHECK(context, path && *path, SPH_E_ARGUMENT, "mesh: path is %s", path ? "empty" : "NULL");
  SPH_CHECK(context, isfinite(time), SPH_E_ARGUMENT, "mesh: time must be finite, got %g", time);
  SPH_TRY(check_fields(context, "at nodes", node_fields, at_nodes));
  SPH_TRY(check_fields(context, "of cells", cell_fields, of_cells));
  writer w = {.mesh = mesh};
  SPH_TRY(sphi_file_open(context, path, &w.file));
  write_header(&w, time, node_fields, at_nodes, cell_fields, of_cells);
  for (int k = 0; k < node_fields; k++)
    write_real(&w, mesh->nodes, mesh->nodes, at_nodes[k].components, at_nodes[k].values);
  for (int k = 0; k < cell_fields; k++)
    write_real(&w, mesh->cells, cells_of(&w), of_cells[k].components, of_cells[k].values);
  write_cells(&w);
  sphi_file_printf(w.file, "\n  </AppendedData>\n</VTKFile>\n");
  return sphi_file_commit(&w.file);
}
