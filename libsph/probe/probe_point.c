/* Measures at points: pressure, its means, velocity. */
#include "probe/probe_impl.h"

typedef struct points_data {
  sphi_probe_points points;
  double *weight; /* [n] of the points, in the order given */
} points_data;

static void release_points(sph_probe *probe) {
  points_data *data = probe->data;
  sphi_probe_points_free(probe->context, &data->points);
  sphi_free(probe->context, data->weight);
}

/* Pressure of the point in place k of the gather's order. Next to a wall fluid accelerates as that does. */
static double pressure_at(const sph_integrator *flow, const sphi_probe_points *points, int32_t k) {
  const sphi_gather *gather = &points->gather;
  const sphi_interpolation *work = &gather->work;
  if (work->rung[k] == 0 || work->gamma[k] < SPHI_PROBE_THIN) return 0;
  double x[SPHI_MAX_DIM] = {0}, gradient[SPHI_MAX_DIM] = {0};
  double velocity[SPHI_MAX_DIM] = {0}, acceleration[SPHI_MAX_DIM] = {0};
  const int dim = flow->particles->dim;
  for (int d = 0; d < dim; d++) x[d] = gather->x[d][gather->columns.order[k]];
  if (points->boundary) sphi_wall_velocity_at(&points->now, dim, x, velocity, acceleration);
  if (flow->method->pressure_gradient)
    flow->method->pressure_gradient(flow, x, acceleration, gradient);
  double p = work->value[k];
  for (int d = 0; d < dim; d++) p -= gradient[d] * work->moment[(int64_t)d * work->n + k];
  return p;
}

static sph_status measure_pressure(sph_probe *probe, double *values) {
  points_data *data = probe->data;
  sph_integrator *flow = probe->flow;
  const sphi_gather *gather = &data->points.gather;
  double sum = 0;
  if (flow->method->evaluate) {
    const double *x = sphi_probe_places(&data->points, flow->particles->dim);
    SPH_TRY(flow->method->evaluate(flow, gather->n, x, data->points.answer, NULL, NULL));
    for (int32_t k = 0; k < gather->n; k++) sum += data->weight[k] * data->points.answer[k];
    values[0] = sum;
    return SPH_OK;
  }
  SPH_TRY(sphi_probe_gather(probe));
  for (int32_t k = 0; k < gather->n; k++)
    sum += data->weight[gather->columns.order[k]] * pressure_at(flow, &data->points, k);
  values[0] = sum;
  return SPH_OK;
}

static sph_status measure_velocity(sph_probe *probe, double *values) {
  sphi_probe_points *points = &((points_data *)probe->data)->points;
  if (probe->flow->method->evaluate)
    return probe->flow->method->evaluate(probe->flow, 1, sphi_probe_places(points, probe->columns),
                                         NULL, values, NULL);
  SPH_TRY(sphi_probe_gather(probe));
  const sphi_interpolation *work = &points->gather.work;
  const bool thin = work->rung[0] == 0 || work->gamma[0] < SPHI_PROBE_THIN;
  for (int d = 0; d < probe->columns; d++)
    values[d] = thin ? 0 : work->value[(int64_t)(1 + d) * work->n];
  return SPH_OK;
}

static const sphi_probe_kind pressure_kind = {.name = "pressure",
                                              .size = sizeof(points_data),
                                              .has_points = true,
                                              .measure = measure_pressure,
                                              .release = release_points};
static const sphi_probe_kind velocity_kind = {.name = "velocity",
                                              .size = sizeof(points_data),
                                              .has_points = true,
                                              .measure = measure_velocity,
                                              .release = release_points};

static const char *const pressure_names[] = {"p"}, *const pressure_units[] = {"Pa"};
static const char *const velocity_names[] = {"v_x", "v_y", "v_z"};
static const char *const velocity_units[] = {"m/s", "m/s", "m/s"};

/* Point k of n and its weight. */
typedef struct places {
  int n;
  const double *a, *b; /* ends of a segment; a disc: centre and direction */
  double radius;       /* > 0: a disc */
} places;

static double place(const places *from, int dim, int k, double *x) {
  if (from->radius > 0) {
    const double angle = 3.14159265358979323846 * (k + 1) / (from->n + 1);
    for (int d = 0; d < dim; d++) x[d] = from->a[d] + from->radius * cos(angle) * from->b[d];
    return 2 * sin(angle) * sin(angle) / (from->n + 1);
  }
  for (int d = 0; d < dim; d++) x[d] = from->a[d] + (k + 0.5) / from->n * (from->b[d] - from->a[d]);
  return 1.0 / from->n;
}

static sph_status fill_points(sph_probe *probe, const places *from) {
  sph_integrator *flow = probe->flow;
  points_data *data = probe->data;
  sphi_probe_points *points = &data->points;
  const int dim = flow->particles->dim;
  points->build = -1;
  data->weight = SPHI_NEW(probe->context, from->n, double);
  SPH_CHECK(probe->context, data->weight, SPH_E_MEMORY, "probe \"%s\": no memory for %d points",
            probe->name, from->n);
  /* At a wall the pressure gradient along the normal is the body force's, which is what compensation
   * assumes, and single particles count less than in an extrapolation by least squares. */
  const sph_interpolator_type type =
      probe->kind == &velocity_kind ? SPH_INTERPOLATOR_MLS_LINEAR : SPH_INTERPOLATOR_NORMALIZED;
  SPH_TRY(sph_interpolator_create(probe->context, type, flow->kernel, &points->interpolator));
  SPH_TRY(sphi_gather_reserve(probe->context, &points->gather, points->interpolator, dim, from->n,
                              flow->variant->real_size));
  for (int k = 0; k < from->n; k++) {
    double x[SPHI_MAX_DIM] = {0};
    data->weight[k] = place(from, dim, k, x);
    for (int d = 0; d < dim; d++) points->gather.x[d][k] = x[d];
  }
  return sphi_probe_prepare(probe);
}

/* Arguments other than the places are checked. */
static sph_status create_at(sph_integrator *flow, const sphi_probe_kind *kind, const places *from,
                            sph_probe **out) {
  const int dim = flow->particles->dim;
  SPH_CHECK(flow->context, from->n >= 1 && from->n <= SPHI_PROBE_POINTS, SPH_E_ARGUMENT,
            "probe \"%s\": points must be 1 to %d, got %d", kind->name, (int)SPHI_PROBE_POINTS,
            from->n);
  const sphi_surroundings around = sphi_probe_surroundings(flow);
  for (int k = 0; k < from->n; k++) {
    double x[SPHI_MAX_DIM] = {0};
    place(from, dim, k, x);
    SPH_TRY(sphi_probe_check_point(flow, &around, kind->name, x));
  }
  const bool velocity = kind == &velocity_kind;
  sph_probe *probe;
  SPH_TRY(sphi_probe_new(flow, kind, velocity ? dim : 1, velocity ? velocity_names : pressure_names,
                         velocity ? velocity_units : pressure_units, &probe));
  return sphi_probe_finish(probe, fill_points(probe, from), out);
}

sph_status sph_probe_set_interpolator(sph_probe *probe, sph_interpolator_type type) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context, probe->kind == &pressure_kind || probe->kind == &velocity_kind,
            SPH_E_TYPE, "probe \"%s\": only pressure and velocity are interpolated", probe->name);
  SPH_CHECK(probe->context, !probe->flow->method->evaluate, SPH_E_TYPE,
            "probe \"%s\": the method \"%s\" has no neighbours to interpolate from", probe->name,
            probe->flow->method->name);
  sph_integrator *flow = probe->flow;
  sphi_probe_points *points = &((points_data *)probe->data)->points;
  sph_interpolator *interpolator;
  SPH_TRY(sph_interpolator_create(probe->context, type, flow->kernel, &interpolator));
  const sph_status status =
      sphi_gather_reserve(probe->context, &points->gather, interpolator, flow->particles->dim,
                          points->gather.n, flow->variant->real_size);
  sph_interpolator *unused = status == SPH_OK ? points->interpolator : interpolator;
  if (status == SPH_OK) points->interpolator = interpolator;
  points->build = -1;
  sph_interpolator_destroy(&unused);
  return status;
}

sph_status sph_probe_create_pressure(sph_integrator *flow, const double *x, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, pressure_kind, out);
  SPH_CHECK(context, x, SPH_E_ARGUMENT, "probe \"pressure\": x is NULL");
  const places from = {.n = 1, .a = x, .b = x};
  return create_at(flow, &pressure_kind, &from, out);
}

sph_status sph_probe_create_pressure_average(sph_integrator *flow, const double *a, const double *b,
                                             int points, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, pressure_kind, out);
  SPH_CHECK(context, a && b, SPH_E_ARGUMENT, "probe \"pressure\": %s is NULL", a ? "b" : "a");
  const places from = {.n = points, .a = a, .b = b};
  return create_at(flow, &pressure_kind, &from, out);
}

sph_status sph_probe_create_pressure_disc(sph_integrator *flow, const double *centre,
                                          const double *along, double diameter, int points,
                                          sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, pressure_kind, out);
  SPH_CHECK(context, centre && along, SPH_E_ARGUMENT, "probe \"pressure\": %s is NULL",
            centre ? "along" : "centre");
  SPH_CHECK(context, flow->particles->dim == 2, SPH_E_UNSUPPORTED,
            "probe \"pressure\": a disc is a line of 2D flows only; average over points in 3D");
  SPH_CHECK(context, isfinite(diameter) && diameter > 0, SPH_E_ARGUMENT,
            "probe \"pressure\": diameter must be > 0 m, got %g", diameter);
  SPH_TRY(sphi_probe_check_direction(flow, "pressure", "along", along));
  const places from = {.n = points, .a = centre, .b = along, .radius = diameter / 2};
  return create_at(flow, &pressure_kind, &from, out);
}

sph_status sph_probe_create_velocity(sph_integrator *flow, const double *x, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, velocity_kind, out);
  SPH_CHECK(context, x, SPH_E_ARGUMENT, "probe \"velocity\": x is NULL");
  const places from = {.n = 1, .a = x, .b = x};
  return create_at(flow, &velocity_kind, &from, out);
}
