/* Fixed ghost particles: creation, motion, and the assignment of mirrored values. */
#include "boundary/boundary_impl.h"

void sphi_boundary_retain(sph_boundary *boundary) { boundary->references++; }

static void free_arrays(sph_boundary *boundary) {
  sph_context *context = boundary->context;
  for (int d = 0; d < SPHI_MAX_DIM; d++) {
    sphi_free(context, boundary->x[d]);
    sphi_free(context, boundary->v[d]);
    boundary->x[d] = boundary->v[d] = NULL;
  }
  sphi_free(context, boundary->p);
  sphi_free(context, boundary->volume);
  sphi_free(context, boundary->drag);
  sphi_free(context, boundary->wall_pressure);
  sphi_free(context, boundary->rung);
  sphi_free(context, boundary->record);
  sphi_free(context, boundary->place);
  sphi_free(context, boundary->wet);
  boundary->place = boundary->wet = NULL;
  boundary->p = boundary->volume = boundary->drag = boundary->wall_pressure = NULL;
  boundary->rung = NULL;
  boundary->record = NULL;
}

void sph_boundary_destroy(sph_boundary **boundary) {
  if (!boundary || !*boundary) return;
  sph_boundary *dead = *boundary;
  *boundary = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  free_arrays(dead);
  sphi_free(context, dead->wall_of);
  sphi_ghost_points_free(context, &dead->points);
  sphi_gather_free(context, &dead->mirrors);
  sphi_columns_free(context, &dead->columns);
  for (int w = 0; w < dead->walls; w++) sph_wall_destroy(&dead->wall[w]);
  sph_interpolator_destroy(&dead->interpolator);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

/* Ghosts of one more wall at the end of the tables. */
static sph_status append_wall(sph_boundary *boundary, sph_wall *wall) {
  sph_context *context = boundary->context;
  SPH_CHECK(context, sphi_wall_dim(wall) == boundary->dim, SPH_E_ARGUMENT,
            "boundary: wall \"%s\" has dimension %d, the interpolator's kernel has %d",
            sphi_wall_name(wall), sphi_wall_dim(wall), boundary->dim);
  SPH_CHECK(context, boundary->walls < SPHI_MAX_WALLS, SPH_E_ARGUMENT,
            "boundary: at most %d walls, wall \"%s\" is one more", SPHI_MAX_WALLS,
            sphi_wall_name(wall));
  const int64_t before = boundary->points.n, skipped = boundary->points.skipped;
  sph_status status = sphi_wall_make_ghosts(
      wall, boundary->spacing, boundary->interpolator->kernel->support, &boundary->points);
  if (status == SPH_OK && boundary->points.n > INT32_MAX - 1024)
    status = SPHI_ERROR(context, SPH_E_ARGUMENT, "boundary: %lld ghosts are more than fit",
                        (long long)boundary->points.n);
  if (status == SPH_OK &&
      !sphi_reserve(context, (void **)&boundary->wall_of, &boundary->wall_of_capacity,
                    boundary->points.n, sizeof *boundary->wall_of))
    status = SPHI_ERROR(context, SPH_E_MEMORY, "boundary: no memory for %lld ghosts",
                        (long long)boundary->points.n);
  if (status != SPH_OK) {
    boundary->points.n = before;
    boundary->points.skipped = skipped;
    return status;
  }
  for (int64_t k = before; k < boundary->points.n; k++) boundary->wall_of[k] = boundary->walls;
  sphi_wall_retain(wall);
  boundary->wall[boundary->walls++] = wall;
  boundary->counts.ghosts = boundary->counts.inactive = boundary->points.n;
  boundary->counts.skipped = boundary->points.skipped;
  return SPH_OK;
}

sph_status sph_boundary_create(sph_context *context, sph_wall *wall, double spacing,
                               sph_interpolator *interpolator, sph_boundary **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, wall && interpolator && out, SPH_E_ARGUMENT, "boundary: %s is NULL",
            !wall           ? "wall"
            : !interpolator ? "interpolator"
                            : "out");
  SPH_CHECK(context, interpolator->context == context, SPH_E_ARGUMENT,
            "boundary: the interpolator is of another context");
  SPH_CHECK(context, isfinite(spacing) && spacing > 0, SPH_E_ARGUMENT,
            "boundary: spacing must be > 0 m, got %g", spacing);
  sph_boundary *boundary = SPHI_NEW(context, 1, sph_boundary);
  SPH_CHECK(context, boundary, SPH_E_MEMORY, "boundary: no memory");
  sphi_context_retain(context);
  boundary->context = context;
  boundary->references = 1;
  boundary->dim = interpolator->kernel->dim;
  boundary->spacing = spacing;
  boundary->interpolator = interpolator;
  sphi_interpolator_retain(interpolator);
  boundary->thin = 0.05;
  boundary->no_suction = true;
  const sph_status status = append_wall(boundary, wall);
  if (status != SPH_OK) {
    sph_boundary_destroy(&boundary);
    return status;
  }
  *out = boundary;
  return SPH_OK;
}

sph_status sph_boundary_add_wall(sph_boundary *boundary, sph_wall *wall) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, wall, SPH_E_ARGUMENT, "boundary: wall is NULL");
  SPH_CHECK(
      boundary->context, !boundary->in_use, SPH_E_ARGUMENT,
      "boundary: wall \"%s\" comes too late, an integrator uses the boundary; add walls first",
      sphi_wall_name(wall));
  return append_wall(boundary, wall);
}

sph_status sph_boundary_set_no_suction(sph_boundary *boundary, bool on) {
  if (!boundary) return SPH_E_ARGUMENT;
  boundary->no_suction = on;
  return SPH_OK;
}

sph_status sph_boundary_set_thin_threshold(sph_boundary *boundary, double threshold) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, threshold >= 0 && threshold < 0.5, SPH_E_ARGUMENT,
            "boundary: thin threshold must be 0 to 0.5, got %g", threshold);
  boundary->thin = threshold;
  return SPH_OK;
}

int64_t sph_boundary_count(const sph_boundary *boundary) {
  return boundary ? boundary->points.n : 0;
}

sph_status sph_boundary_get_counts(const sph_boundary *boundary, sph_boundary_counts *counts) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, counts, SPH_E_ARGUMENT, "boundary: counts is NULL");
  *counts = boundary->counts;
  return SPH_OK;
}

bool sphi_boundary_moves(const sph_boundary *boundary) {
  for (int w = 0; w < boundary->walls; w++)
    if (sphi_wall_moves(boundary->wall[w])) return true;
  return false;
}

sph_status sphi_boundary_prepare(sph_boundary *boundary, const sphi_variant *variant) {
  sph_context *context = boundary->context;
  const int32_t n = (int32_t)boundary->points.n;
  const int dim = boundary->dim;
  free_arrays(boundary);
  bool ok = true;
  for (int d = 0; d < dim; d++) {
    boundary->x[d] = SPHI_NEW(context, n, double);
    boundary->v[d] = SPHI_NEW(context, n, double);
    ok = ok && boundary->x[d] && boundary->v[d];
  }
  boundary->p = SPHI_NEW(context, n, double);
  boundary->volume = SPHI_NEW(context, n, double);
  boundary->drag = SPHI_NEW(context, n, double);
  boundary->wall_pressure = SPHI_NEW(context, n, double);
  boundary->rung = SPHI_NEW(context, n, uint8_t);
  boundary->place = SPHI_NEW(context, n, int32_t);
  boundary->wet = SPHI_NEW(context, n, int32_t);
  boundary->record =
      sphi_alloc(context, ((size_t)n + SPHI_PAD) * (size_t)SPHI_GHOST(dim), variant->real_size);
  ok = ok && boundary->p && boundary->volume && boundary->drag && boundary->wall_pressure &&
       boundary->rung && boundary->record && boundary->place && boundary->wet;
  if (!ok) {
    free_arrays(boundary);
    return SPHI_ERROR(context, SPH_E_MEMORY, "boundary: no memory for %d ghosts", n);
  }
  for (int32_t k = 0; k < n; k++)
    boundary->drag[k] = sphi_wall_no_slip(boundary->wall[boundary->wall_of[k]]) ? 1 : 0;
  SPH_TRY(sphi_gather_reserve(context, &boundary->mirrors, boundary->interpolator, dim, n,
                              variant->real_size));
  boundary->in_use = true;
  return SPH_OK;
}

sph_status sphi_boundary_place_walls(sph_boundary *boundary, double t) {
  for (int w = 0; w < boundary->walls; w++)
    SPH_TRY(sphi_wall_motion_at(boundary->wall[w], t, boundary->state[w].displacement,
                                boundary->state[w].velocity, boundary->state[w].acceleration));
  return SPH_OK;
}

sph_status sphi_boundary_move(sph_boundary *boundary, double t) {
  const int dim = boundary->dim;
  SPH_TRY(sphi_boundary_place_walls(boundary, t));
  const int32_t n = (int32_t)boundary->points.n;
  boundary->mirrors.packed = false;
#pragma omp parallel for num_threads(boundary->context->threads) schedule(static)
  for (int32_t k = 0; k < n; k++) {
    const double *displacement = boundary->state[boundary->wall_of[k]].displacement;
    for (int d = 0; d < dim; d++) {
      boundary->x[d][k] = boundary->points.x[(int64_t)dim * k + d] + displacement[d];
      boundary->mirrors.x[d][k] = boundary->points.mirror[(int64_t)dim * k + d] + displacement[d];
    }
  }
  return SPH_OK;
}

sph_status sphi_boundary_sort(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant) {
  const double width = sphi_column_width(boundary->dim, variant->lanes, boundary->spacing);
  SPH_TRY(sphi_columns_build(boundary->context, &boundary->columns, frame, width,
                             (int32_t)boundary->points.n, boundary->x, NULL, "boundary"));
  return sphi_gather_sort(boundary->context, &boundary->mirrors, frame, variant, boundary->spacing,
                          boundary->interpolator->kernel->support);
}

/* Gates into the records: they do not change while a wall moves. */
static void pack_gates(sph_boundary *boundary, const sphi_variant *variant) {
  const int dim = boundary->dim, stride = SPHI_GHOST(dim), planes = SPHI_GATES(dim) * (dim + 1);
  const sphi_ghost_points *points = &boundary->points;
  for (int64_t k = 0; k < points->n; k++) {
    const int64_t ghost = boundary->columns.order[k], at = k * stride + SPHI_GHOST_GATES(dim);
    for (int c = 0; c <= planes; c++) {
      const double value = c == 0 ? points->gates[ghost] : points->gate[ghost * planes + c - 1];
      if (variant->is_double)
        ((double *)boundary->record)[at + c] = value;
      else
        ((float *)boundary->record)[at + c] = (float)value;
    }
  }
}

/* Records but for their gates, of all ghosts or of those in place[0..n-1]. */
static void pack_records(sph_boundary *boundary, const sphi_frame *frame,
                         const sphi_variant *variant, const int32_t *place, int32_t n) {
  const int dim = boundary->dim;
  sphi_pack pack = {.frame = frame,
                    .n = n,
                    .place = place,
                    .stride = SPHI_GHOST(dim),
                    .order = boundary->columns.order,
                    .columns = dim + 3,
                    .record = boundary->record};
  pack.value[0] = boundary->volume;
  pack.value[1] = boundary->p;
  for (int d = 0; d < dim; d++) {
    pack.x[d] = boundary->x[d];
    pack.value[2 + d] = boundary->v[d];
  }
  pack.value[2 + dim] = boundary->drag;
  sphi_pack_run(boundary->context, variant, &pack);
}

sph_status sphi_boundary_list(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant, const sphi_columns *fluid,
                              double radius) {
  SPH_TRY(sphi_gather_list(boundary->context, &boundary->mirrors, frame, boundary->interpolator,
                           fluid, radius));
  const int32_t n = (int32_t)boundary->points.n;
  for (int32_t k = 0; k < n; k++) {
    boundary->place[boundary->columns.order[k]] = k;
    boundary->p[k] = boundary->wall_pressure[k] = boundary->volume[k] = 0;
    boundary->rung[k] = 0;
    for (int d = 0; d < boundary->dim; d++)
      boundary->v[d][k] = boundary->state[boundary->wall_of[k]].velocity[d];
  }
  pack_records(boundary, frame, variant, NULL, n);
  pack_gates(boundary, variant);
  const sphi_clusters *wet = &boundary->mirrors.wet;
  boundary->wet_count = 0;
  for (int32_t c = 0; c < wet->n; c++)
    for (int32_t k = wet->first[c]; k < wet->first[c] + wet->count[c]; k++)
      boundary->wet[boundary->wet_count++] = boundary->place[boundary->mirrors.columns.order[k]];
  return SPH_OK;
}

/* Velocity and pressure of one ghost from the values at its mirror point, place k in their order. */
static inline __attribute__((always_inline)) void assign(sph_boundary *boundary, const int dim,
                                                         int32_t ghost, int32_t k,
                                                         const sphi_body_force *force, double t,
                                                         double rho0) {
  const sphi_interpolation *work = &boundary->mirrors.work;
  const sphi_wall_state *wall = &boundary->state[boundary->wall_of[ghost]];
  const double *foot = boundary->points.foot + (int64_t)dim * ghost;
  const double *normal = boundary->points.normal + (int64_t)dim * ghost;
  const bool dry = work->rung[k] == 0, thin = work->gamma[k] < boundary->thin;
  boundary->rung[ghost] = work->rung[k];
  boundary->volume[ghost] = dry ? 0 : boundary->points.volume[ghost];
  double at[SPHI_MAX_DIM], f[SPHI_MAX_DIM] = {0};
  for (int d = 0; d < dim; d++) at[d] = foot[d] + wall->displacement[d];
  if (force->function) force->function(t, at, f, force->user);
  double p = work->value[k], p_wall = p, across = 0;
  for (int d = 0; d < dim; d++) {
    const double push = rho0 * (force->constant[d] + f[d] - wall->acceleration[d]);
    /* The interpolated values belong to the point that the weights average: x_m + I[x - x_m]. */
    const double from = boundary->mirrors.x[d][ghost] + work->moment[(int64_t)d * work->n + k];
    p += push * (boundary->x[d][ghost] - from);
    p_wall += push * (at[d] - from);
    across += (work->value[(int64_t)(1 + d) * work->n + k] - wall->velocity[d]) * normal[d];
  }
  if (thin || dry) p = p_wall = 0;
  if (boundary->no_suction && p < 0) p = 0;
  if (boundary->no_suction && p_wall < 0) p_wall = 0;
  boundary->p[ghost] = p;
  boundary->wall_pressure[ghost] = p_wall;
  const bool both = boundary->points.vertex[ghost] || boundary->drag[ghost] > 0;
  for (int d = 0; d < dim; d++) {
    const double u = work->value[(int64_t)(1 + d) * work->n + k];
    boundary->v[d][ghost] = thin || dry ? wall->velocity[d]
                            : both      ? 2 * wall->velocity[d] - u
                                        : u - 2 * across * normal[d];
  }
}

static void count_rungs(sph_boundary *boundary) {
  sph_boundary_counts counts = {.ghosts = boundary->points.n, .skipped = boundary->points.skipped};
  const sphi_interpolation *work = &boundary->mirrors.work;
  const sphi_clusters *wet = &boundary->mirrors.wet;
  for (int32_t c = 0; c < wet->n; c++) {
    for (int32_t k = wet->first[c]; k < wet->first[c] + wet->count[c]; k++) {
      counts.by_type[work->rung[k]]++;
      counts.active += work->rung[k] != 0;
      counts.thin += work->rung[k] != 0 && work->gamma[k] < boundary->thin;
    }
  }
  counts.by_type[0] = counts.inactive = counts.ghosts - counts.active;
  counts.fallback = counts.active - counts.by_type[boundary->interpolator->type];
  boundary->counts = counts;
}

void sphi_boundary_update(sph_boundary *boundary, const sphi_frame *frame,
                          const sphi_variant *variant, const void *record,
                          const sphi_body_force *force, double t, double rho0) {
  sph_context *context = boundary->context;
  sphi_gather_evaluate(context, &boundary->mirrors, frame, boundary->interpolator, variant, record);
  const int32_t *order = boundary->mirrors.columns.order;
  const sphi_clusters *wet = &boundary->mirrors.wet;
#pragma omp parallel for num_threads(context->threads) schedule(static)
  for (int32_t c = 0; c < wet->n; c++)
    for (int32_t k = wet->first[c]; k < wet->first[c] + wet->count[c]; k++)
      if (boundary->dim == 2)
        assign(boundary, 2, order[k], k, force, t, rho0);
      else
        assign(boundary, 3, order[k], k, force, t, rho0);
  count_rungs(boundary);
  pack_records(boundary, frame, variant, boundary->wet, boundary->wet_count);
}

sph_status sph_boundary_read(const sph_boundary *boundary, sph_ghost_value what, double *values,
                             int64_t size) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, values, SPH_E_ARGUMENT, "boundary: values is NULL");
  SPH_CHECK(boundary->context, what >= SPH_GHOST_POSITION && what <= SPH_GHOST_RUNG, SPH_E_ARGUMENT,
            "boundary: value must be one of sph_ghost_value, got %d", (int)what);
  const int dim = boundary->dim, components = what <= SPH_GHOST_VELOCITY ? dim : 1;
  const int64_t n = boundary->points.n;
  SPH_CHECK(boundary->context, size == n * components, SPH_E_ARGUMENT,
            "boundary: size must be %lld doubles (%lld ghosts of %d), got %lld",
            (long long)(n * components), (long long)n, components, (long long)size);
  const double *reference[] = {boundary->points.x, boundary->points.mirror, boundary->points.foot,
                               boundary->points.normal};
  for (int64_t k = 0; k < n; k++) {
    const double *displacement = boundary->state[boundary->wall_of[k]].displacement;
    for (int d = 0; d < dim && what <= SPH_GHOST_FOOT; d++)
      values[dim * k + d] = reference[what][dim * k + d] + displacement[d];
    for (int d = 0; d < dim && what == SPH_GHOST_NORMAL; d++)
      values[dim * k + d] = -reference[what][dim * k + d];
    /* Before the first evaluation the arrays of values do not exist: everything is zero. */
    for (int d = 0; d < dim && what == SPH_GHOST_VELOCITY; d++)
      values[dim * k + d] = boundary->v[d] ? boundary->v[d][k] : 0;
    if (what == SPH_GHOST_PRESSURE) values[k] = boundary->p ? boundary->p[k] : 0;
    if (what == SPH_GHOST_VOLUME) values[k] = boundary->volume ? boundary->volume[k] : 0;
    if (what == SPH_GHOST_RUNG) values[k] = boundary->rung ? boundary->rung[k] : 0;
  }
  return SPH_OK;
}

sph_status sph_boundary_read_force(const sph_boundary *boundary, int wall, double *force) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, force, SPH_E_ARGUMENT, "boundary: force is NULL");
  SPH_CHECK(boundary->context, wall >= 0 && wall < boundary->walls, SPH_E_ARGUMENT,
            "boundary: wall must be 0 to %d, got %d", boundary->walls - 1, wall);
  for (int d = 0; d < boundary->dim; d++) force[d] = 0;
  for (int64_t k = 0; boundary->wall_pressure && k < boundary->points.n; k++) {
    if (boundary->wall_of[k] != wall) continue;
    const double push = boundary->wall_pressure[k] * boundary->points.area[k];
    for (int d = 0; d < boundary->dim; d++)
      force[d] += push * boundary->points.normal[boundary->dim * k + d];
  }
  return SPH_OK;
}
