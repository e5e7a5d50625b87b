/* A series of frames: its directory, its fields, its times. The format is in vtk.c. */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <sph/particles.h>
#include <stdio.h>
#include <sys/stat.h>

#include "mesh/mesh_impl.h"
#include "output/output_impl.h"

struct sph_output {
  sph_context *context;
  char *directory, *name;
  bool single;
  const char *extension; /* of the frames so far; they are all of one kind */
  char **chosen;         /* names of fields, [chosen_count] */
  int chosen_count;
  int64_t chosen_capacity;
  double *times; /* of the complete frames */
  int64_t frames, times_capacity;
  sphi_frame_field *field; /* of the frame being written */
  int64_t field_capacity;
  double *scratch;
  int64_t scratch_capacity;
  char *path;
  size_t path_bytes;
};

static sph_status make_directory(sph_context *context, const char *directory) {
  errno = 0;
  if (mkdir(directory, 0777) == 0) return SPH_OK;
  const int error = errno;
  struct stat about;
  if (stat(directory, &about) == 0) {
    SPH_CHECK(context, S_ISDIR(about.st_mode), SPH_E_IO,
              "output: \"%s\" exists and is not a directory", directory);
    return SPH_OK;
  }
  return SPHI_ERROR(context, SPH_E_IO, "output: directory \"%s\" cannot be created: %s%s",
                    directory, strerror(error), error == ENOENT ? "; create its parent first" : "");
}

static bool has_control_character(const char *text) {
  for (; *text; text++)
    if ((unsigned char)*text < 0x20 || *text == 0x7f) return true;
  return false;
}

sph_status sph_output_create_vtk(sph_context *context, const char *directory, const char *name,
                                 sph_output **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, directory && name && out, SPH_E_ARGUMENT, "output: %s is NULL",
            !directory ? "directory"
            : !name    ? "name"
                       : "out");
  SPH_CHECK(context, *directory, SPH_E_ARGUMENT, "output: directory is empty; \".\" is this one");
  SPH_CHECK(context, *name, SPH_E_ARGUMENT, "output: name is empty");
  SPH_CHECK(context, !strchr(name, '/'), SPH_E_ARGUMENT,
            "output: name \"%s\" must not contain '/'; it belongs into the directory", name);
  SPH_CHECK(context, !has_control_character(name), SPH_E_ARGUMENT,
            "output: name must not contain control characters");
  sph_output *output = SPHI_NEW(context, 1, sph_output);
  SPH_CHECK(context, output, SPH_E_MEMORY, "output \"%s\": out of memory", name);
  output->context = context;
  sphi_context_retain(context);
  output->single = true;
  output->extension = "vtp";
  output->directory = sphi_copy_text(context, directory);
  output->name = sphi_copy_text(context, name);
  output->path_bytes = strlen(directory) + strlen(name) + 32; /* and '/', number, ".vtp" */
  output->path = sphi_alloc(context, output->path_bytes, 1);
  sph_status status;
  if (output->directory && output->name && output->path)
    status = make_directory(context, directory);
  else
    status = SPHI_ERROR(context, SPH_E_MEMORY, "output \"%s\": out of memory", name);
  if (status != SPH_OK) sph_output_destroy(&output);
  *out = output;
  return status;
}

void sph_output_destroy(sph_output **output) {
  if (!output || !*output) return;
  sph_output *dead = *output;
  sph_context *context = dead->context;
  *output = NULL;
  for (int k = 0; k < dead->chosen_count; k++) sphi_free(context, dead->chosen[k]);
  sphi_free(context, dead->chosen);
  sphi_free(context, dead->directory);
  sphi_free(context, dead->name);
  sphi_free(context, dead->times);
  sphi_free(context, dead->field);
  sphi_free(context, dead->scratch);
  sphi_free(context, dead->path);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sph_output_add_field(sph_output *output, const char *field) {
  if (!output) return SPH_E_ARGUMENT;
  sph_context *context = output->context;
  SPH_CHECK(context, field && *field, SPH_E_ARGUMENT, "output \"%s\": field is %s", output->name,
            field ? "empty" : "NULL");
  for (int k = 0; k < output->chosen_count; k++)
    SPH_CHECK(context, strcmp(field, output->chosen[k]) != 0, SPH_E_ARGUMENT,
              "output \"%s\": field \"%s\" was chosen before", output->name, field);
  char *copy = sphi_copy_text(context, field);
  void *chosen = output->chosen;
  if (!copy || !sphi_reserve(context, &chosen, &output->chosen_capacity, output->chosen_count + 1,
                             sizeof *output->chosen)) {
    sphi_free(context, copy);
    return SPHI_ERROR(context, SPH_E_MEMORY, "output \"%s\": out of memory", output->name);
  }
  output->chosen = chosen;
  output->chosen[output->chosen_count++] = copy;
  return SPH_OK;
}

sph_status sph_output_set_single(sph_output *output, bool single) {
  if (!output) return SPH_E_ARGUMENT;
  output->single = single;
  return SPH_OK;
}

int64_t sph_output_frame_count(const sph_output *output) { return output ? output->frames : 0; }

static sph_status check_time(const sph_output *output, double time) {
  SPH_CHECK(output->context, isfinite(time), SPH_E_ARGUMENT,
            "output \"%s\": time must be finite, got %g", output->name, time);
  SPH_CHECK(output->context, output->frames == 0 || time > output->times[output->frames - 1],
            SPH_E_ARGUMENT, "output \"%s\": time must be > %.9g s of the frame before, got %.9g",
            output->name, output->times[output->frames - 1], time);
  return SPH_OK;
}

static sph_status reserve(sph_output *output, int64_t fields, int64_t numbers) {
  sph_context *context = output->context;
  void *times = output->times, *field = output->field, *scratch = output->scratch;
  const bool enough =
      sphi_reserve(context, &times, &output->times_capacity, output->frames + 1, sizeof(double)) &&
      sphi_reserve(context, &field, &output->field_capacity, fields, sizeof(sphi_frame_field)) &&
      sphi_reserve(context, &scratch, &output->scratch_capacity, numbers, sizeof(double));
  output->times = times;
  output->field = field;
  output->scratch = scratch;
  SPH_CHECK(context, enough, SPH_E_MEMORY, "output \"%s\": out of memory", output->name);
  return SPH_OK;
}

/* The path of the next frame's file. */
static const char *frame_path(sph_output *output, const char *extension) {
  snprintf(output->path, output->path_bytes, "%s/%s" SPHI_FRAME_SUFFIX, output->directory,
           output->name, output->frames, extension);
  return output->path;
}

static sph_status check_kind(const sph_output *output, const char *extension) {
  SPH_CHECK(output->context, output->frames == 0 || strcmp(output->extension, extension) == 0,
            SPH_E_ARGUMENT, "output \"%s\": its frames are .%s files, so that no .%s can follow",
            output->name, output->extension, extension);
  return SPH_OK;
}

/* The list that names the frame which has been written last: it never names what is not there. */
static sph_status list_frame(sph_output *output, const char *extension, double time) {
  output->times[output->frames] = time;
  snprintf(output->path, output->path_bytes, "%s/%s.pvd", output->directory, output->name);
  const sph_status status = sphi_vtk_write_series(output->context, output->path, output->name,
                                                  extension, output->frames + 1, output->times);
  if (status != SPH_OK) {
    remove(frame_path(output, extension));
    return status;
  }
  output->extension = extension;
  output->frames++;
  return SPH_OK;
}

static sph_status write_frame(sph_output *output, const sphi_frame *frame) {
  SPH_TRY(check_kind(output, "vtp"));
  SPH_TRY(sphi_vtk_write_frame(output->context, frame_path(output, "vtp"), frame));
  return list_frame(output, "vtp", frame->time);
}

sph_status sph_output_write_mesh(sph_output *output, const sph_mesh *mesh, int node_fields,
                                 const sph_mesh_field *at_nodes, int cell_fields,
                                 const sph_mesh_field *of_cells, double time) {
  if (!output) return SPH_E_ARGUMENT;
  SPH_CHECK(output->context, mesh && mesh->context == output->context, SPH_E_ARGUMENT,
            "output \"%s\": mesh is %s", output->name, mesh ? "of another context" : "NULL");
  SPH_TRY(check_time(output, time));
  SPH_TRY(check_kind(output, "vtu"));
  SPH_TRY(reserve(output, 0, 0));
  SPH_TRY(sph_mesh_write_vtk(mesh, frame_path(output, "vtu"), time, node_fields, at_nodes,
                             cell_fields, of_cells));
  return list_frame(output, "vtu", time);
}

static sph_status describe(const sph_particles *particles, const char *name,
                           sphi_frame_field *field) {
  field->name = name;
  field->values = NULL;
  SPH_TRY(sph_particles_field_components(particles, name, &field->components));
  return sph_particles_field_unit(particles, name, &field->unit);
}

sph_status sph_output_write(sph_output *output, const sph_particles *particles, double time) {
  if (!output) return SPH_E_ARGUMENT;
  SPH_CHECK(output->context, particles, SPH_E_ARGUMENT, "output \"%s\": particles is NULL",
            output->name);
  SPH_TRY(check_time(output, time));
  const int available = sph_particles_field_count(particles);
  const int64_t n = sph_particles_count(particles);
  const int candidates = output->chosen_count ? output->chosen_count : available;
  SPH_TRY(reserve(output, candidates, 0));
  int fields = 0, widest = sph_particles_dim(particles);
  for (int k = 0; k < candidates; k++) {
    const char *name =
        output->chosen_count ? output->chosen[k] : sph_particles_field_name(particles, k);
    if (!output->chosen_count && strcmp(name, SPH_POSITION) == 0) continue;
    sphi_frame_field *field = &output->field[fields++];
    SPH_TRY(describe(particles, name, field));
    if (field->components > widest) widest = field->components;
  }
  SPH_TRY(reserve(output, candidates, n * widest));
  const sphi_frame frame = {.particles = particles,
                            .count = n,
                            .dim = sph_particles_dim(particles),
                            .fields = fields,
                            .field = output->field,
                            .time = time,
                            .single = output->single,
                            .scratch = output->scratch};
  return write_frame(output, &frame);
}

static sph_status check_points(const sph_output *output, int64_t count, int dim, const double *x) {
  sph_context *context = output->context;
  SPH_CHECK(context, count >= 0 && count <= INT32_MAX, SPH_E_ARGUMENT,
            "output \"%s\": number of points must be 0 to %d, got %" PRId64, output->name,
            INT32_MAX, count);
  SPH_CHECK(context, dim == 2 || dim == 3, SPH_E_ARGUMENT,
            "output \"%s\": dimension must be 2 or 3, got %d", output->name, dim);
  SPH_CHECK(context, x || count == 0, SPH_E_ARGUMENT, "output \"%s\": x is NULL", output->name);
  for (int64_t i = 0; i < count; i++)
    SPH_CHECK(context, sphi_finite(dim, &x[i * dim]), SPH_E_ARGUMENT,
              "output \"%s\": position of point %" PRId64 " is not finite", output->name, i);
  return SPH_OK;
}

sph_status sph_output_write_points(sph_output *output, int64_t count, int dim, const double *x,
                                   int fields, const char *const *names, const int *components,
                                   const double *const *values, double time) {
  if (!output) return SPH_E_ARGUMENT;
  sph_context *context = output->context;
  SPH_TRY(check_time(output, time));
  SPH_TRY(check_points(output, count, dim, x));
  SPH_CHECK(context, fields >= 0, SPH_E_ARGUMENT,
            "output \"%s\": number of fields must be >= 0, got %d", output->name, fields);
  SPH_CHECK(context, fields == 0 || (names && components && (values || count == 0)), SPH_E_ARGUMENT,
            "output \"%s\": %s is NULL", output->name,
            !names        ? "names"
            : !components ? "components"
                          : "values");
  SPH_TRY(reserve(output, fields, 0));
  for (int k = 0; k < fields; k++) {
    SPH_CHECK(context, names[k] && *names[k], SPH_E_ARGUMENT,
              "output \"%s\": name of field %d is %s", output->name, k,
              names[k] ? "empty" : "NULL");
    for (int j = 0; j < k; j++)
      SPH_CHECK(context, strcmp(names[j], names[k]) != 0, SPH_E_ARGUMENT,
                "output \"%s\": field \"%s\" is given twice", output->name, names[k]);
    SPH_CHECK(context, components[k] >= 1 && components[k] <= SPHI_FRAME_COMPONENTS, SPH_E_ARGUMENT,
              "output \"%s\": field \"%s\" must have 1 to %d components, got %d", output->name,
              names[k], SPHI_FRAME_COMPONENTS, components[k]);
    SPH_CHECK(context, count == 0 || values[k], SPH_E_ARGUMENT,
              "output \"%s\": values of field \"%s\" is NULL", output->name, names[k]);
    output->field[k] = (sphi_frame_field){
        .name = names[k], .components = components[k], .values = count ? values[k] : NULL};
  }
  const sphi_frame frame = {.count = count,
                            .dim = dim,
                            .x = x,
                            .fields = fields,
                            .field = output->field,
                            .time = time,
                            .single = output->single};
  return write_frame(output, &frame);
}
