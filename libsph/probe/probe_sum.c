/* Measures of the whole: force on a wall, energies, mass, and the caller's own. */
#include "probe/probe_impl.h"

#include <sph/wcsph.h>

typedef struct force_data {
  sph_boundary *boundary;
  int wall;
} force_data;

static void release_force(sph_probe *probe) {
  sph_boundary_destroy(&((force_data *)probe->data)->boundary);
}

static sph_status measure_force(sph_probe *probe, double *values) {
  const force_data *data = probe->data;
  return sph_boundary_read_force(data->boundary, data->wall, values);
}

static const sphi_probe_kind force_kind = {.name = "force",
                                           .size = sizeof(force_data),
                                           .measure = measure_force,
                                           .release = release_force};

static sph_status measure_reaction(sph_probe *probe, double *values) {
  return probe->flow->method->reaction(probe->flow, ((const force_data *)probe->data)->wall,
                                       values);
}

static const sphi_probe_kind reaction_kind = {.name = "reaction",
                                              .size = sizeof(force_data),
                                              .measure = measure_reaction,
                                              .release = release_force};

static sph_status create_force(sph_integrator *flow, const sphi_probe_kind *kind,
                               sph_boundary *boundary, int wall, sph_probe **out) {
  SPH_TRY(sphi_probe_check_wall(flow, kind->name, boundary, wall));
  static const char *const names[] = {"f_x", "f_y", "f_z"};
  static const char *const units[] = {"N", "N", "N"}, *const units_2d[] = {"N/m", "N/m"};
  const int dim = boundary->dim;
  sph_probe *probe;
  SPH_TRY(sphi_probe_new(flow, kind, dim, names, dim == 2 ? units_2d : units, &probe));
  *(force_data *)probe->data = (force_data){.boundary = boundary, .wall = wall};
  sphi_boundary_retain(boundary);
  return sphi_probe_finish(probe, SPH_OK, out);
}

sph_status sph_probe_create_force(sph_integrator *flow, sph_boundary *boundary, int wall,
                                  sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, force_kind, out);
  return create_force(flow, &force_kind, boundary, wall, out);
}

sph_status sph_probe_create_reaction(sph_integrator *flow, sph_boundary *boundary, int wall,
                                     sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, reaction_kind, out);
  SPH_CHECK(context, flow->method->reaction, SPH_E_TYPE,
            "probe \"reaction\": the method \"%s\" has none", flow->method->name);
  return create_force(flow, &reaction_kind, boundary, wall, out);
}

static sph_status measure_energy(sph_probe *probe, double *values) {
  sph_energy energy;
  SPH_TRY(probe->flow->method->energy(probe->flow, &energy));
  values[0] = energy.kinetic;
  values[1] = energy.potential;
  values[2] = energy.compressible;
  values[3] = energy.total;
  return SPH_OK;
}

static const sphi_probe_kind energy_kind = {.name = "energy", .measure = measure_energy};

sph_status sph_probe_create_energy(sph_integrator *flow, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, energy_kind, out);
  SPH_CHECK(context, flow->method->energy, SPH_E_TYPE,
            "probe \"energy\": the method \"%s\" gives no energies", flow->method->name);
  static const char *const names[] = {"kinetic", "potential", "compressible", "total"};
  static const char *const units[] = {"J", "J", "J", "J"};
  static const char *const units_2d[] = {"J/m", "J/m", "J/m", "J/m"};
  sph_probe *probe;
  SPH_TRY(sphi_probe_new(flow, &energy_kind, 4, names, flow->particles->dim == 2 ? units_2d : units,
                         &probe));
  return sphi_probe_finish(probe, SPH_OK, out);
}

/* In id order, so that a sort of the particles does not change the rounding. */
static sph_status measure_mass(sph_probe *probe, double *values) {
  const sph_particles *particles = probe->flow->particles;
  const double *m = particles->field[SPHI_M].data[0];
  double sum = 0;
  for (sph_index k = 0; k < particles->n; k++) sum += m[particles->slot[k]];
  values[0] = sum;
  values[1] = particles->n;
  return SPH_OK;
}

static const sphi_probe_kind mass_kind = {.name = "mass", .measure = measure_mass};

sph_status sph_probe_create_mass(sph_integrator *flow, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, mass_kind, out);
  (void)context;
  static const char *const names[] = {"mass", "particles"};
  static const char *const units[] = {"kg", ""}, *const units_2d[] = {"kg/m", ""};
  sph_probe *probe;
  SPH_TRY(sphi_probe_new(flow, &mass_kind, 2, names, flow->particles->dim == 2 ? units_2d : units,
                         &probe));
  return sphi_probe_finish(probe, SPH_OK, out);
}

typedef struct function_data {
  sph_probe_function function;
  void *user;
} function_data;

/* The function sees pressures of now. */
static sph_status measure_function(sph_probe *probe, double *values) {
  const function_data *data = probe->data;
  SPH_TRY(probe->flow->method->refresh(probe->flow));
  for (int c = 0; c < probe->columns; c++) values[c] = 0;
  data->function(probe->flow, values, data->user);
  return SPH_OK;
}

static const sphi_probe_kind function_kind = {
    .name = "function", .size = sizeof(function_data), .measure = measure_function};

/* Fit for a line of comma-separated text. */
static bool plain(const char *text) {
  for (; *text; text++)
    if ((unsigned char)*text < 0x20 || *text == 0x7f || *text == ',' || *text == '"') return false;
  return true;
}

sph_status sph_probe_create_function(sph_integrator *flow, int columns, const char *const *names,
                                     const char *const *units, sph_probe_function function,
                                     void *user, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, function_kind, out);
  SPH_CHECK(context, names && function, SPH_E_ARGUMENT, "probe \"function\": %s is NULL",
            names ? "function" : "names");
  SPH_CHECK(context, columns >= 1 && columns <= SPHI_PROBE_COLUMNS, SPH_E_ARGUMENT,
            "probe \"function\": columns must be 1 to %d, got %d", (int)SPHI_PROBE_COLUMNS,
            columns);
  for (int c = 0; c < columns; c++) {
    SPH_CHECK(context, names[c] && *names[c], SPH_E_ARGUMENT,
              "probe \"function\": name of column %d is %s", c, names[c] ? "empty" : "NULL");
    SPH_CHECK(context, !units || units[c], SPH_E_ARGUMENT,
              "probe \"function\": unit of column %d is NULL", c);
    SPH_CHECK(
        context, plain(names[c]) && (!units || plain(units[c])), SPH_E_ARGUMENT,
        "probe \"function\": name or unit of column %d has a comma, a quote or a control character",
        c);
  }
  sph_probe *probe;
  SPH_TRY(sphi_probe_new(flow, &function_kind, columns, names, units, &probe));
  *(function_data *)probe->data = (function_data){.function = function, .user = user};
  return sphi_probe_finish(probe, SPH_OK, out);
}
