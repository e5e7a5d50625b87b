/* Fields of a particle set: by name, in and out in id order, by copy or by lease. */
#include "particles/particles_impl.h"

enum { MAX_NAME = 63, MAX_UNIT = 31 };

void sphi_particles_free_field(sph_context *context, sphi_field *field) {
  for (int c = 0; c < field->components; c++) sphi_free(context, field->data[c]);
  sphi_free(context, field->name);
  sphi_free(context, field->unit);
}

sph_status sphi_particles_insert_field(sph_particles *particles, const char *name, int components,
                                       const char *unit) {
  sph_context *context = particles->context;
  sphi_field fresh = {.components = components};
  fresh.name = sphi_copy_text(context, name);
  fresh.unit = sphi_copy_text(context, unit);
  bool complete = fresh.name && fresh.unit;
  for (int c = 0; c < components && complete; c++) {
    fresh.data[c] = SPHI_NEW(context, particles->capacity, double);
    complete = fresh.data[c] != NULL;
  }
  void *fields = particles->field;
  if (complete)
    complete = sphi_reserve(context, &fields, &particles->field_capacity,
                            (int64_t)particles->fields + 1, sizeof(sphi_field));
  if (!complete) {
    sphi_particles_free_field(context, &fresh);
    return SPHI_ERROR(context, SPH_E_MEMORY, "particles \"%s\": no memory for field \"%s\"",
                      particles->name, name);
  }
  particles->field = fields;
  particles->field[particles->fields++] = fresh;
  return SPH_OK;
}

static const sphi_field *find(const sph_particles *particles, const char *name) {
  for (int f = 0; f < particles->fields; f++)
    if (strcmp(particles->field[f].name, name) == 0) return &particles->field[f];
  return NULL;
}

static bool is_name_character(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-' || c == '.';
}

/* Names and units end up in the headers of files, so they are kept plain. */
static sph_status check_texts(const sph_particles *particles, const char *name, const char *unit) {
  sph_context *context = particles->context;
  const size_t name_length = strlen(name), unit_length = strlen(unit);
  SPH_CHECK(context, name_length >= 1 && name_length <= MAX_NAME, SPH_E_ARGUMENT,
            "particles \"%s\": a field's name must be 1 to %d characters long, got %zu",
            particles->name, MAX_NAME, name_length);
  for (size_t k = 0; k < name_length; k++)
    SPH_CHECK(
        context, is_name_character(name[k]), SPH_E_ARGUMENT,
        "particles \"%s\": a field's name has letters, digits, '_', '-' and '.' only, got 0x%02x "
        "at byte %zu",
        particles->name, (unsigned)(unsigned char)name[k], k);
  SPH_CHECK(
      context, unit_length >= 1 && unit_length <= MAX_UNIT, SPH_E_ARGUMENT,
      "particles \"%s\": field \"%s\": unit must be 1 to %d bytes long, got %zu; \"1\" is a pure "
      "number",
      particles->name, name, MAX_UNIT, unit_length);
  for (size_t k = 0; k < unit_length; k++)
    SPH_CHECK(context,
              (unsigned char)unit[k] >= 0x20 && unit[k] != 0x7f && !strchr("\"<>&", unit[k]),
              SPH_E_ARGUMENT,
              "particles \"%s\": field \"%s\": unit must have no control characters and none of "
              "\" < > &, got 0x%02x at byte %zu",
              particles->name, name, (unsigned)(unsigned char)unit[k], k);
  return SPH_OK;
}

sph_status sph_particles_add_field(sph_particles *particles, const char *name, int components,
                                   const char *unit) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  SPH_CHECK(context, name, SPH_E_ARGUMENT, "particles \"%s\": a field's name must not be NULL",
            particles->name);
  SPH_CHECK(context, unit, SPH_E_ARGUMENT,
            "particles \"%s\": field \"%s\": unit must not be NULL; \"1\" is a pure number",
            particles->name, name);
  SPH_TRY(check_texts(particles, name, unit));
  SPH_CHECK(context, components >= 1 && components <= SPHI_MAX_COMPONENTS, SPH_E_ARGUMENT,
            "particles \"%s\": field \"%s\": components must be 1 to %d, got %d", particles->name,
            name, SPHI_MAX_COMPONENTS, components);
  SPH_CHECK(context, !find(particles, name), SPH_E_ARGUMENT,
            "particles \"%s\": field \"%s\" exists already; choose another name", particles->name,
            name);
  return sphi_particles_insert_field(particles, name, components, unit);
}

int sph_particles_field_count(const sph_particles *particles) {
  return particles ? particles->fields : 0;
}

const char *sph_particles_field_name(const sph_particles *particles, int k) {
  return particles && k >= 0 && k < particles->fields ? particles->field[k].name : NULL;
}

sphi_field *sphi_particles_field(const sph_particles *particles, const char *name) {
  const sphi_field *field = find(particles, name);
  if (field) return &particles->field[field - particles->field];
  /* The nearest of all, two at a time: sets have any number of fields. */
  const char *nearest = NULL;
  for (int f = 0; f < particles->fields; f++) {
    const char *const pair[2] = {nearest ? nearest : particles->field[f].name,
                                 particles->field[f].name};
    const char *nearer = sphi_nearest_name(name, nearest ? 2 : 1, pair);
    if (nearer) nearest = nearer;
  }
  SPHI_ERROR(particles->context, SPH_E_NAME, "particles \"%s\": unknown field \"%s\"%s%s%s",
             particles->name, name, nearest ? "; did you mean \"" : "", nearest ? nearest : "",
             nearest ? "\"?" : "; call sph_particles_add_field first");
  return NULL;
}

/* Looks a caller's field name up; NULL is an error of its own. */
static sph_status look_up(const sph_particles *particles, const char *name, sphi_field **field) {
  if (!particles) return SPH_E_ARGUMENT;
  SPH_CHECK(particles->context, name, SPH_E_ARGUMENT,
            "particles \"%s\": the field's name must not be NULL", particles->name);
  *field = sphi_particles_field(particles, name);
  return *field ? SPH_OK : SPH_E_NAME;
}

sph_status sph_particles_field_components(const sph_particles *particles, const char *field,
                                          int *components) {
  sphi_field *found = NULL;
  SPH_TRY(look_up(particles, field, &found));
  SPH_CHECK(particles->context, components, SPH_E_ARGUMENT,
            "particles \"%s\": components must not be NULL", particles->name);
  *components = found->components;
  return SPH_OK;
}

sph_status sph_particles_field_unit(const sph_particles *particles, const char *field,
                                    const char **unit) {
  sphi_field *found = NULL;
  SPH_TRY(look_up(particles, field, &found));
  SPH_CHECK(particles->context, unit, SPH_E_ARGUMENT, "particles \"%s\": unit must not be NULL",
            particles->name);
  *unit = found->unit;
  return SPH_OK;
}

static void gather(const sph_particles *particles, const sphi_field *field, double *values) {
  const sph_index n = particles->n, *slot = particles->slot;
  const size_t components = (size_t)field->components;
#pragma omp parallel for num_threads( \
    particles->context->threads) if (n >= SPHI_PARTICLES_PARALLEL_FROM)
  for (sph_index r = 0; r < n; r++)
    for (size_t c = 0; c < components; c++)
      values[(size_t)r * components + c] = field->data[c][slot[r]];
}

static void scatter(const sph_particles *particles, const sphi_field *field, const double *values) {
  const sph_index n = particles->n, *slot = particles->slot;
  const size_t components = (size_t)field->components;
#pragma omp parallel for num_threads( \
    particles->context->threads) if (n >= SPHI_PARTICLES_PARALLEL_FROM)
  for (sph_index r = 0; r < n; r++)
    for (size_t c = 0; c < components; c++)
      field->data[c][slot[r]] = values[(size_t)r * components + c];
}

static sph_status check_values(const sph_particles *particles, const sphi_field *field,
                               const double *values) {
  const int64_t components = field->components, size = particles->n * components;
  const ptrdiff_t place = field - particles->field;
  const bool positive = place == SPHI_RHO || place == SPHI_M || place == SPHI_VOL;
  for (int64_t k = 0; k < size; k++) {
    const bool good = isfinite(values[k]) && (!positive || values[k] > 0);
    SPH_CHECK(
        particles->context, good, SPH_E_ARGUMENT,
        "particles \"%s\": %s of the particle with id %lld, component %lld, must be finite%s%s, "
        "got %g",
        particles->name, field->name, (long long)particles->id[particles->slot[k / components]],
        (long long)(k % components), positive ? " and > 0 " : "", positive ? field->unit : "",
        values[k]);
  }
  return SPH_OK;
}

static sph_status check_array(const sph_particles *particles, const char *what, int components,
                              const void *values, int64_t size) {
  const int64_t needed = (int64_t)particles->n * components;
  SPH_CHECK(
      particles->context, size == needed, SPH_E_ARGUMENT,
      "particles \"%s\": %s of %lld particles with %d components has %lld values, got size %lld",
      particles->name, what, (long long)particles->n, components, (long long)needed,
      (long long)size);
  SPH_CHECK(particles->context, values || size == 0, SPH_E_ARGUMENT,
            "particles \"%s\": the array for %s must not be NULL", particles->name, what);
  return SPH_OK;
}

sph_status sph_particles_read_ids(const sph_particles *particles, int64_t *ids, int64_t size) {
  if (!particles) return SPH_E_ARGUMENT;
  SPH_TRY(check_array(particles, "id", 1, ids, size));
  for (sph_index r = 0; r < particles->n; r++) ids[r] = particles->id[particles->slot[r]];
  return SPH_OK;
}

sph_status sph_particles_read(const sph_particles *particles, const char *field, double *values,
                              int64_t size) {
  sphi_field *found = NULL;
  SPH_TRY(look_up(particles, field, &found));
  SPH_TRY(check_array(particles, found->name, found->components, values, size));
  gather(particles, found, values);
  return SPH_OK;
}

sph_status sph_particles_write(sph_particles *particles, const char *field, const double *values,
                               int64_t size) {
  sphi_field *found = NULL;
  SPH_TRY(look_up(particles, field, &found));
  SPH_TRY(check_array(particles, found->name, found->components, values, size));
  SPH_TRY(check_values(particles, found, values));
  scatter(particles, found, values);
  particles->revision++;
  return SPH_OK;
}

static sph_status open_lease(const sph_particles *particles, sph_particles *writer,
                             const char *field, double **values) {
  sph_context *context = particles->context;
  sphi_field *found = NULL;
  SPH_TRY(look_up(particles, field, &found));
  sphi_lease_list *leases = particles->leases;
  void *list = leases->lease;
  double *copy = SPHI_NEW(context, (size_t)particles->n * (size_t)found->components, double);
  if (!copy ||
      !sphi_reserve(context, &list, &leases->capacity, leases->count + 1, sizeof(sphi_lease))) {
    sphi_free(context, copy);
    return SPHI_ERROR(context, SPH_E_MEMORY, "particles \"%s\": no memory for a lease of \"%s\"",
                      particles->name, field);
  }
  leases->lease = list;
  gather(particles, found, copy);
  leases->lease[leases->count++] =
      (sphi_lease){.values = copy, .field = (int)(found - particles->field), .writer = writer};
  *values = copy;
  return SPH_OK;
}

sph_status sph_particles_lease_read(const sph_particles *particles, const char *field,
                                    const double **values) {
  if (values) *values = NULL;
  if (!particles) return SPH_E_ARGUMENT;
  SPH_CHECK(particles->context, values, SPH_E_ARGUMENT, "particles \"%s\": values must not be NULL",
            particles->name);
  double *copy = NULL;
  SPH_TRY(open_lease(particles, NULL, field, &copy));
  *values = copy;
  return SPH_OK;
}

sph_status sph_particles_lease_write(sph_particles *particles, const char *field, double **values) {
  if (values) *values = NULL;
  if (!particles) return SPH_E_ARGUMENT;
  SPH_CHECK(particles->context, values, SPH_E_ARGUMENT, "particles \"%s\": values must not be NULL",
            particles->name);
  return open_lease(particles, particles, field, values);
}

sph_status sph_particles_release(const sph_particles *particles, const double *values) {
  if (!particles) return SPH_E_ARGUMENT;
  sphi_lease_list *leases = particles->leases;
  int64_t k = 0;
  while (k < leases->count && leases->lease[k].values != values) k++;
  SPH_CHECK(particles->context, k < leases->count, SPH_E_ARGUMENT,
            "particles \"%s\": %p is none of the %lld open leases", particles->name,
            (const void *)values, (long long)leases->count);
  const sphi_lease lease = leases->lease[k];
  leases->lease[k] = leases->lease[--leases->count];
  sph_status status = SPH_OK;
  if (lease.writer) {
    const sphi_field *field = &particles->field[lease.field];
    status = check_values(particles, field, lease.values);
    if (status == SPH_OK) {
      scatter(particles, field, lease.values);
      lease.writer->revision++;
    }
  }
  sphi_free(particles->context, lease.values);
  return status;
}
