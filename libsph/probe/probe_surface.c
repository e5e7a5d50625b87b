/* Measures of where the fluid is: the surface along a line, the front along an axis. */
#include "probe/probe_impl.h"

enum { COLUMNS_NEAR = 128 };

typedef struct near_query {
  const sphi_frame *frame;
  const sphi_columns *columns;
  double *const *position; /* of the columns' points now */
  const double *x;
  double slack; /* how far a point may have moved since it was sorted */
  double radius;
} near_query;

/* Calls visit(r, point, data) for the points within the radius, until it returns false. */
static void for_each_near(const near_query *q, bool (*visit)(double r, int32_t point, void *data),
                          void *data) {
  const int dim = q->frame->dim;
  const double reach = q->radius + q->slack;
  double at[SPHI_MAX_DIM] = {0};
  for (int d = 0; d < dim; d++) at[d] = sphi_frame_wrap(q->frame, d, q->x[d]);
  sphi_window window;
  sphi_columns_window(q->columns, q->frame, at, at, reach, &window);
  int32_t found[COLUMNS_NEAR], ranges[3][2];
  int32_t count = sphi_columns_in(q->columns, &window, COLUMNS_NEAR, found);
  if (count > COLUMNS_NEAR) count = COLUMNS_NEAR;
  for (int32_t c = 0; c < count; c++) {
    const int pieces = sphi_columns_range(q->columns, q->frame, found[c], at[dim - 1] - reach,
                                          at[dim - 1] + reach, ranges);
    for (int piece = 0; piece < pieces; piece++) {
      for (int32_t k = ranges[piece][0]; k < ranges[piece][1]; k++) {
        const int32_t point = q->columns->order[k];
        double r2 = 0;
        for (int d = 0; d < dim; d++) {
          const double dx = sphi_frame_difference(q->frame, d, q->position[d][point], at[d]);
          r2 += dx * dx;
        }
        if (r2 < q->radius * q->radius && !visit(sqrt(r2), point, data)) return;
      }
    }
  }
}

/* ------------------------------------------------------------------------------- elevation */

typedef struct line_data {
  sphi_probe_points points;
  double step;         /* between samples */
  double *share;       /* [n] half of the ghosts' kernel sum at the samples */
  int64_t share_build; /* of the flow, that the share was taken for; -1: never */
  double *gamma;       /* [n] of the fluid, in order along the line */
} line_data;

static void release_line(sph_probe *probe) {
  line_data *data = probe->data;
  sphi_probe_points_free(probe->context, &data->points);
  sphi_free(probe->context, data->share);
  sphi_free(probe->context, data->gamma);
}

typedef struct share_sum {
  const sph_kernel *kernel;
  const sphi_frame *frame;
  const sph_boundary *boundary;
  const double *x;
  double sum;
} share_sum;

static bool add_share(double r, int32_t ghost, void *data) {
  share_sum *share = data;
  const sph_boundary *boundary = share->boundary;
  double from_ghost[SPHI_MAX_DIM];
  for (int d = 0; d < boundary->dim; d++) {
    from_ghost[d] = share->x[d] - boundary->x[d][ghost];
    const double length = share->frame->length[d];
    if (share->frame->periodic[d]) from_ghost[d] -= length * rint(from_ghost[d] / length);
  }
  double reference[SPHI_MAX_DIM];
  sphi_wall_turn_back(&boundary->state[boundary->wall_of[ghost]], boundary->dim, from_ghost,
                      reference);
  if (sphi_ghost_seen(&boundary->points, ghost, reference))
    share->sum += boundary->points.volume[ghost] * sphi_boundary_share(boundary, ghost) *
                  sph_kernel_w(share->kernel, r);
  return true;
}

/* Every ghost counts with the volume it stands for, also while it is inactive: what matters is the
 * room that the wall takes. A wall that takes the line along is where its ghosts are, which may be those of
 * the last evaluation. */
static void update_share(sph_probe *probe, const sph_boundary *boundary) {
  line_data *data = probe->data;
  const sphi_probe_points *points = &data->points;
  const sph_integrator *flow = probe->flow;
  const bool moves = sphi_boundary_moves(boundary);
  if (!moves && data->share_build == flow->stats.builds) return;
  data->share_build = flow->stats.builds;
  for (int32_t k = 0; k < points->gather.n; k++) {
    double x[SPHI_MAX_DIM] = {0};
    for (int d = 0; d < boundary->dim; d++) x[d] = points->gather.x[d][k];
    if (points->boundary)
      sphi_wall_place(&boundary->state[points->wall], boundary->dim,
                      points->reference + (int64_t)boundary->dim * k, x);
    share_sum share = {.kernel = flow->kernel, .frame = &flow->frame, .boundary = boundary, .x = x};
    const near_query query = {
        .frame = &flow->frame,
        .columns = &boundary->columns,
        .position = boundary->x,
        .x = x,
        .slack = moves ? 0.5 * (flow->list_radius - flow->kernel->support) : 0,
        .radius = flow->kernel->support};
    for_each_near(&query, add_share, &share);
    data->share[k] = 0.5 * share.sum;
  }
}

/* The length of heavier fluid along the line, of methods that answer themselves: by the shares of cells, which
 * are no smooth function of the place. Samples in the middle of the steps. */
static sph_status measure_length(sph_probe *probe, double *values) {
  line_data *data = probe->data;
  sph_integrator *flow = probe->flow;
  const int dim = flow->particles->dim;
  const int32_t n = data->points.gather.n - 1;
  const double *x = sphi_probe_places(&data->points, dim);
  for (int64_t k = 0; k < (int64_t)n * dim; k++) data->points.asked[k] = 0.5 * (x[k] + x[k + dim]);
  SPH_TRY(flow->method->evaluate(flow, n, x, NULL, NULL, data->points.answer));
  values[0] = 0;
  for (int32_t k = 0; k < n; k++) values[0] += data->points.answer[k] * data->step;
  return SPH_OK;
}

static sph_status measure_elevation(sph_probe *probe, double *values) {
  line_data *data = probe->data;
  if (probe->flow->method->evaluate) return measure_length(probe, values);
  const sphi_gather *gather = &data->points.gather;
  SPH_TRY(sphi_probe_gather(probe));
  sphi_surroundings around = {0};
  if (probe->flow->method->surroundings) probe->flow->method->surroundings(probe->flow, &around);
  if (around.boundary) update_share(probe, around.boundary);
  const int32_t n = gather->n;
  for (int32_t k = 0; k < n; k++) data->gamma[gather->columns.order[k]] = gather->work.gamma[k];
  values[0] = 0;
  int32_t top = n - 1;
  while (top >= 0 && data->gamma[top] + data->share[top] < 0.5) top--;
  if (top < 0) return SPH_OK;
  double s = top;
  if (top < n - 1) {
    const double below = data->gamma[top] + data->share[top] - 0.5;
    const double above = data->gamma[top + 1] + data->share[top + 1] - 0.5;
    s += below / (below - above);
  }
  values[0] = s * data->step;
  return SPH_OK;
}

static const sphi_probe_kind elevation_kind = {.name = "elevation",
                                               .size = sizeof(line_data),
                                               .has_points = true,
                                               .measure = measure_elevation,
                                               .release = release_line};

static sph_status fill_line(sph_probe *probe, const double *foot, const double *direction,
                            double length) {
  sph_integrator *flow = probe->flow;
  sph_context *context = probe->context;
  line_data *data = probe->data;
  sphi_probe_points *points = &data->points;
  const int dim = flow->particles->dim;
  const int32_t intervals = (int32_t)ceil(2 * length / flow->particles->spacing - 1e-9);
  const int32_t n = (intervals < 1 ? 1 : intervals) + 1;
  points->build = data->share_build = -1;
  data->step = length / (n - 1);
  data->share = SPHI_NEW(context, n, double);
  data->gamma = SPHI_NEW(context, n, double);
  SPH_CHECK(context, data->share && data->gamma, SPH_E_MEMORY,
            "probe \"%s\": no memory for %d points", probe->name, n);
  SPH_TRY(sph_interpolator_create(context, SPH_INTERPOLATOR_NORMALIZED, flow->kernel,
                                  &points->interpolator));
  SPH_TRY(sphi_gather_reserve(context, &points->gather, points->interpolator, dim, n,
                              flow->variant->real_size));
  for (int d = 0; d < dim; d++)
    for (int32_t k = 0; k < n; k++)
      points->gather.x[d][k] = foot[d] + k * data->step * direction[d];
  return sphi_probe_prepare(probe);
}

sph_status sph_probe_create_elevation(sph_integrator *flow, const double *foot,
                                      const double *direction, double length, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, elevation_kind, out);
  const char *kind = elevation_kind.name;
  SPH_CHECK(context, foot && direction, SPH_E_ARGUMENT, "probe \"%s\": %s is NULL", kind,
            foot ? "direction" : "foot");
  const double longest = 0.5 * SPHI_PROBE_LINE * flow->particles->spacing;
  SPH_CHECK(context, length > 0 && length <= longest, SPH_E_ARGUMENT,
            "probe \"%s\": length must be > 0 and at most %g m, got %g", kind, longest, length);
  SPH_TRY(sphi_probe_check_direction(flow, kind, "direction", direction));
  const sphi_surroundings around = sphi_probe_surroundings(flow);
  SPH_TRY(sphi_probe_check_point(flow, &around, kind, foot));
  static const char *const names[] = {"elevation"}, *const units[] = {"m"};
  sph_probe *probe;
  SPH_TRY(sphi_probe_new(flow, &elevation_kind, 1, names, units, &probe));
  return sphi_probe_finish(probe, fill_line(probe, foot, direction, length), out);
}

/* ----------------------------------------------------------------------------------- front */

typedef struct front_data {
  int axis;
  double sign;
  int min_neighbours;
} front_data;

static bool count_one(double r, int32_t point, void *data) {
  (void)r, (void)point;
  return --*(int *)data > 0;
}

/* The particle itself is found too. */
static bool has_company(const sph_integrator *flow, int32_t i, int others) {
  const sph_particles *particles = flow->particles;
  double x[SPHI_MAX_DIM] = {0};
  for (int d = 0; d < particles->dim; d++) x[d] = particles->field[SPHI_X].data[d][i];
  const near_query query = {.frame = &flow->frame,
                            .columns = &flow->columns,
                            .position = particles->field[SPHI_X].data,
                            .x = x,
                            .slack = 0.5 * (flow->list_radius - flow->kernel->support),
                            .radius = 2 * particles->spacing * (1 + 1e-9)};
  int missing = others + 1;
  for_each_near(&query, count_one, &missing);
  return missing <= 0;
}

static sph_status measure_front(sph_probe *probe, double *values) {
  const front_data *data = probe->data;
  sph_integrator *flow = probe->flow;
  SPH_TRY(flow->method->refresh(flow));
  const sph_particles *particles = flow->particles;
  const double *x = particles->field[SPHI_X].data[data->axis];
  const int32_t n = particles->n;
  double front = -HUGE_VAL;
  /* Storage runs up the first axis: from the front's end on few particles are ahead of the best. */
  for (int32_t k = 0; k < n; k++) {
    const int32_t i = data->sign > 0 ? n - 1 - k : k;
    const double ahead = data->sign * x[i];
    if (ahead > front && has_company(flow, i, data->min_neighbours)) front = ahead;
  }
  values[0] = front > -HUGE_VAL ? front + 0.5 * particles->spacing : NAN;
  return SPH_OK;
}

static const sphi_probe_kind front_kind = {
    .name = "front", .size = sizeof(front_data), .measure = measure_front};

sph_status sph_probe_create_front(sph_integrator *flow, int axis, double sign, sph_probe **out) {
  SPHI_PROBE_BEGIN(flow, front_kind, out);
  const int dim = flow->particles->dim;
  SPH_CHECK(context, axis >= 0 && axis < dim, SPH_E_ARGUMENT,
            "probe \"front\": axis must be 0 to %d, got %d", dim - 1, axis);
  SPH_CHECK(context, fabs(sign) == 1, SPH_E_ARGUMENT,
            "probe \"front\": sign must be +1 or -1, got %g", sign);
  SPH_CHECK(context, !flow->method->evaluate, SPH_E_TYPE,
            "probe \"front\": particles of the method \"%s\" have no neighbours to count",
            flow->method->name);
  static const char *const names[] = {"front"}, *const units[] = {"m"};
  sph_probe *probe;
  SPH_TRY(sphi_probe_new(flow, &front_kind, 1, names, units, &probe));
  *(front_data *)probe->data = (front_data){.axis = axis, .sign = sign, .min_neighbours = 3};
  return sphi_probe_finish(probe, SPH_OK, out);
}

sph_status sph_probe_set_min_neighbours(sph_probe *probe, int count) {
  if (!probe) return SPH_E_ARGUMENT;
  SPH_CHECK(probe->context, probe->kind == &front_kind, SPH_E_TYPE,
            "probe \"%s\": this setting is of \"front\", the probe is \"%s\"", probe->name,
            probe->kind->name);
  SPH_CHECK(probe->context, count >= 0 && count <= 1000, SPH_E_ARGUMENT,
            "probe \"%s\": neighbours must be 0 to 1000, got %d", probe->name, count);
  ((front_data *)probe->data)->min_neighbours = count;
  return SPH_OK;
}
