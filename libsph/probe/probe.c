/* The handle: observing, the series, names, files. */
#include "probe/probe_impl.h"

#include "core/file.h"

static void release(sph_probe *probe) {
  sph_context *context = probe->context;
  if (probe->kind->release) probe->kind->release(probe);
  for (int c = 0; probe->column && c < probe->columns; c++) {
    sphi_free(context, probe->column[c].name);
    sphi_free(context, probe->column[c].unit);
  }
  sphi_free(context, probe->column);
  sphi_free(context, probe->data);
  sphi_free(context, probe->name);
  sphi_free(context, probe->row);
  sphi_free(context, probe->series);
  sph_integrator_destroy(&probe->flow);
  sphi_free(context, probe);
  sph_context_destroy(&context);
}

/* Of a probe whose data could not be allocated: there is nothing to release. */
static const sphi_probe_kind nothing = {.name = ""};

sph_status sphi_probe_new(sph_integrator *flow, const sphi_probe_kind *kind, int columns,
                          const char *const *names, const char *const *units, sph_probe **out) {
  sph_context *context = flow->context;
  *out = NULL;
  sph_probe *probe = SPHI_NEW(context, 1, sph_probe);
  SPH_CHECK(context, probe, SPH_E_MEMORY, "probe \"%s\": no memory", kind->name);
  sphi_context_retain(context);
  sphi_integrator_retain(flow);
  probe->context = context;
  probe->flow = flow;
  probe->kind = kind;
  probe->columns = columns;
  probe->data = sphi_alloc(context, 1, kind->size);
  probe->name = sphi_copy_text(context, kind->name);
  probe->row = SPHI_NEW(context, 1 + columns, double);
  probe->column = SPHI_NEW(context, columns, sphi_probe_column);
  bool ok = probe->data && probe->name && probe->row && probe->column;
  for (int c = 0; ok && c < columns; c++) {
    probe->column[c].name = sphi_copy_text(context, names[c]);
    probe->column[c].unit = sphi_copy_text(context, units && units[c] ? units[c] : "");
    ok = probe->column[c].name && probe->column[c].unit;
  }
  if (!ok) {
    if (!probe->data) probe->kind = &nothing;
    release(probe);
    return SPHI_ERROR(context, SPH_E_MEMORY, "probe \"%s\": no memory", kind->name);
  }
  *out = probe;
  return SPH_OK;
}

static sph_status take(sph_probe *probe) {
  const int width = 1 + probe->columns;
  probe->row[0] = probe->flow->stats.time;
  SPH_TRY(probe->kind->measure(probe, probe->row + 1));
  SPH_CHECK(probe->context,
            sphi_reserve(probe->context, (void **)&probe->series, &probe->capacity,
                         probe->count + 1, (size_t)width * sizeof(double)),
            SPH_E_MEMORY, "probe \"%s\": no memory for sample %lld", probe->name,
            (long long)probe->count);
  memcpy(probe->series + probe->count * width, probe->row, (size_t)width * sizeof(double));
  probe->count++;
  return SPH_OK;
}

static sph_status observe(void *observer, sph_integrator *flow) {
  sph_probe *probe = observer;
  if (probe->interval > 0) {
    /* Times are sums of steps: what is a rounding error early is in time. */
    const double passed = (flow->stats.time - probe->start) / probe->interval * (1 + 1e-12) + 1e-9;
    if (passed < (double)probe->due) return SPH_OK;
    probe->due = passed < 9e18 ? (int64_t)passed + 1 : INT64_MAX;
  }
  return take(probe);
}

sph_status sphi_probe_finish(sph_probe *probe, sph_status status, sph_probe **out) {
  if (status == SPH_OK) status = sphi_integrator_observe(probe->flow, observe, probe);
  if (status == SPH_OK)
    *out = probe;
  else
    release(probe);
  return status;
}

void sph_probe_destroy(sph_probe **probe) {
  if (!probe || !*probe) return;
  sphi_integrator_forget((*probe)->flow, *probe);
  release(*probe);
  *probe = NULL;
}

sph_status sph_probe_set_interval(sph_probe *probe, double seconds) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context, isfinite(seconds) && seconds >= 0, SPH_E_ARGUMENT,
            "probe \"%s\": interval must be >= 0 s, got %g", probe->name, seconds);
  probe->interval = seconds;
  probe->start = probe->flow->stats.time;
  probe->due = 1;
  return SPH_OK;
}

static bool has_control(const char *text) {
  for (; *text; text++)
    if ((unsigned char)*text < 0x20 || *text == 0x7f) return true;
  return false;
}

sph_status sph_probe_set_name(sph_probe *probe, const char *name) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context, name && *name, SPH_E_ARGUMENT, "probe \"%s\": name is %s", probe->name,
            name ? "empty" : "NULL");
  SPH_CHECK(probe->context, !has_control(name), SPH_E_ARGUMENT,
            "probe \"%s\": the new name has a control character", probe->name);
  char *copy = sphi_copy_text(probe->context, name);
  SPH_CHECK(probe->context, copy, SPH_E_MEMORY, "probe \"%s\": no memory for a name", probe->name);
  sphi_free(probe->context, probe->name);
  probe->name = copy;
  return SPH_OK;
}

const char *sph_probe_name(const sph_probe *probe) { return probe ? probe->name : ""; }

sph_status sph_probe_sample(sph_probe *probe) { return probe ? take(probe) : SPH_E_ARGUMENT; }

sph_status sph_probe_reserve(sph_probe *probe, int64_t samples) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context, samples >= 0, SPH_E_ARGUMENT,
            "probe \"%s\": samples must be >= 0, got %lld", probe->name, (long long)samples);
  const size_t size = (size_t)(1 + probe->columns) * sizeof(double);
  SPH_CHECK(
      probe->context,
      (uint64_t)samples <= SIZE_MAX / 2 / size &&
          sphi_reserve(probe->context, (void **)&probe->series, &probe->capacity, samples, size),
      SPH_E_MEMORY, "probe \"%s\": no memory for %lld samples", probe->name, (long long)samples);
  return SPH_OK;
}

sph_status sph_probe_clear(sph_probe *probe) {
  if (!probe) return SPH_E_ARGUMENT;
  probe->count = 0;
  return SPH_OK;
}

int64_t sph_probe_count(const sph_probe *probe) { return probe ? probe->count : 0; }

int sph_probe_columns(const sph_probe *probe) { return probe ? probe->columns : 0; }

static const sphi_probe_column *column_at(const sph_probe *probe, int column) {
  static const sphi_probe_column none = {(char *)"", (char *)""};
  return probe && column >= 0 && column < probe->columns ? &probe->column[column] : &none;
}

const char *sph_probe_column_name(const sph_probe *probe, int column) {
  return column_at(probe, column)->name;
}

const char *sph_probe_column_unit(const sph_probe *probe, int column) {
  return column_at(probe, column)->unit;
}

sph_status sph_probe_read(const sph_probe *probe, int64_t from, int64_t count, double *times,
                          double *values) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context,
            from >= 0 && count >= 0 && from <= probe->count && count <= probe->count - from,
            SPH_E_ARGUMENT, "probe \"%s\": it has %lld samples, asked for %lld from %lld on",
            probe->name, (long long)probe->count, (long long)count, (long long)from);
  const int width = 1 + probe->columns;
  for (int64_t k = 0; k < count; k++) {
    const double *row = probe->series + (from + k) * width;
    if (times) times[k] = row[0];
    if (values)
      memcpy(values + k * probe->columns, row + 1, (size_t)probe->columns * sizeof *values);
  }
  return SPH_OK;
}

sph_status sph_probe_last(const sph_probe *probe, double *values) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context, values, SPH_E_ARGUMENT, "probe \"%s\": values is NULL", probe->name);
  SPH_CHECK(probe->context, probe->count > 0, SPH_E_ARGUMENT,
            "probe \"%s\": no sample yet; step the integrator or call sph_probe_sample",
            probe->name);
  return sph_probe_read(probe, probe->count - 1, 1, NULL, values);
}

sph_status sph_probe_write_csv(const sph_probe *probe, const char *path) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context, path && *path, SPH_E_ARGUMENT, "probe \"%s\": path is %s", probe->name,
            path ? "empty" : "NULL");
  sphi_file *file;
  SPH_TRY(sphi_file_open(probe->context, path, &file));
  sphi_file_printf(file, "# name: %s\n# units: s", probe->name);
  for (int c = 0; c < probe->columns; c++) sphi_file_printf(file, ",%s", probe->column[c].unit);
  sphi_file_printf(file, "\nt_s");
  for (int c = 0; c < probe->columns; c++) sphi_file_printf(file, ",%s", probe->column[c].name);
  sphi_file_printf(file, "\n");
  const int width = 1 + probe->columns;
  for (int64_t k = 0; k < probe->count; k++)
    for (int c = 0; c < width; c++)
      sphi_file_printf(file, "%.17g%s", probe->series[k * width + c], c < width - 1 ? "," : "\n");
  return sphi_file_commit(&file);
}

sphi_surroundings sphi_probe_surroundings(const sph_integrator *flow) {
  sphi_surroundings around = {0};
  if (flow->method->surroundings) flow->method->surroundings(flow, &around);
  const sph_particles *particles = flow->particles;
  for (int d = 0; d < particles->dim && !around.bounded; d++) {
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    for (int32_t i = 0; i < particles->n; i++) {
      lo = fmin(lo, particles->field[SPHI_X].data[d][i]);
      hi = fmax(hi, particles->field[SPHI_X].data[d][i]);
    }
    for (int64_t k = 0; around.boundary && k < around.boundary->points.n; k++) {
      double at[SPHI_MAX_DIM];
      sphi_wall_place(&around.boundary->state[around.boundary->wall_of[k]], particles->dim,
                      around.boundary->points.x + particles->dim * k, at);
      lo = fmin(lo, at[d]);
      hi = fmax(hi, at[d]);
    }
    const double size = fmax(hi - lo, flow->kernel->support);
    around.lo[d] = lo - size;
    around.hi[d] = hi + size;
  }
  around.bounded = true;
  return around;
}

/* Number of the nearest wall that has the point deep inside, or -1. */
static int wall_around(const sph_integrator *flow, const sph_boundary *boundary, const double *x,
                       double *depth) {
  int nearest = -1;
  double distance = HUGE_VAL;
  for (int w = 0; w < boundary->walls; w++) {
    double foot[SPHI_MAX_DIM];
    const double to = sphi_wall_foot_now(boundary->wall[w], &boundary->state[w], x, HUGE_VAL, foot);
    if (fabs(to) >= fabs(distance)) continue;
    distance = to;
    nearest = w;
  }
  *depth = -distance;
  return *depth > flow->kernel->support ? nearest : -1;
}

sph_status sphi_probe_check_point(const sph_integrator *flow, const sphi_surroundings *around,
                                  const char *kind, const double *x) {
  sph_context *context = flow->context;
  const int dim = flow->particles->dim;
  const double z = dim == 3 ? x[2] : 0;
  SPH_CHECK(context, sphi_finite(dim, x), SPH_E_ARGUMENT,
            "probe \"%s\": point (%g, %g, %g) m is not finite", kind, x[0], x[1], z);
  for (int d = 0; d < dim; d++)
    SPH_CHECK(context, around->periodic[d] || (x[d] >= around->lo[d] && x[d] <= around->hi[d]),
              SPH_E_ARGUMENT,
              "probe \"%s\": probe outside the domain: point (%g, %g, %g) m is not in %g to %g m "
              "along axis %d",
              kind, x[0], x[1], z, around->lo[d], around->hi[d], d);
  if (!around->boundary) return SPH_OK;
  double depth = 0;
  const int wall = wall_around(flow, around->boundary, x, &depth);
  SPH_CHECK(
      context, wall < 0, SPH_E_ARGUMENT,
      "probe \"%s\": probe outside the domain: point (%g, %g, %g) m is %g m inside wall \"%s\", "
      "more than the support %g m",
      kind, x[0], x[1], z, depth, sphi_wall_name(around->boundary->wall[wall]),
      flow->kernel->support);
  return SPH_OK;
}

sph_status sphi_probe_check_wall(const sph_integrator *flow, const char *kind,
                                 const sph_boundary *boundary, int wall) {
  sph_context *context = flow->context;
  SPH_CHECK(context, boundary, SPH_E_ARGUMENT, "probe \"%s\": boundary is NULL", kind);
  sphi_surroundings around = {0};
  if (flow->method->surroundings) flow->method->surroundings(flow, &around);
  SPH_CHECK(context, around.boundary == boundary, SPH_E_ARGUMENT,
            "probe \"%s\": the boundary is not the one that the integrator was created with", kind);
  SPH_CHECK(context, wall >= 0 && wall < boundary->walls, SPH_E_ARGUMENT,
            "probe \"%s\": wall must be 0 to %d, got %d", kind, boundary->walls - 1, wall);
  return SPH_OK;
}

sph_status sphi_probe_check_direction(const sph_integrator *flow, const char *kind,
                                      const char *what, const double *direction) {
  double length2 = 0;
  for (int d = 0; d < flow->particles->dim; d++) length2 += direction[d] * direction[d];
  SPH_CHECK(flow->context, fabs(sqrt(length2) - 1) <= 1e-6, SPH_E_ARGUMENT,
            "probe \"%s\": %s must be a unit vector, its length is %g", kind, what, sqrt(length2));
  return SPH_OK;
}
