/* The pressure equation: free surface, rows, solution. */
#include "isph/isph_impl.h"

/* One-sided support makes scales of the Laplacian that mean nothing; tilts stay within what keeps entries
 * positive; a particle whose divergence of positions is that much of the full one has neighbours all round. */
static const double SCALE_MAX = 3, TILT_MAX = 0.9, FULL = 0.97;
/* In spacings, how far a particle looks for what covers it. */
static const double COVER = 2;
/* Neighbours within 1.5 spacings: fewer than a corner of the fluid has make a thread. */
static const double NEXT = 1.5;
#define FEW(dim) ((dim) == 2 ? 3 : 5)

/* Inverse of the symmetric M, {xx yy xy} or {xx yy zz xy xz yz}, in place; false if it is not positive. */
static bool invert(int dim, double *m) {
  if (dim == 2) {
    const double xx = m[0], det = m[0] * m[1] - m[2] * m[2];
    if (!(m[0] > 0 && det > 0)) return false;
    m[0] = m[1] / det;
    m[1] = xx / det;
    m[2] = -m[2] / det;
    return true;
  }
  const double c00 = m[1] * m[2] - m[5] * m[5], c01 = m[4] * m[5] - m[3] * m[2];
  const double c02 = m[3] * m[5] - m[1] * m[4], c11 = m[0] * m[2] - m[4] * m[4];
  const double c12 = m[3] * m[4] - m[0] * m[5], c22 = m[0] * m[1] - m[3] * m[3];
  const double det = m[0] * c00 + m[3] * c01 + m[4] * c02;
  if (!(m[0] > 0 && c22 > 0 && det > 0)) return false;
  const double inverse[6] = {c00 / det, c11 / det, c22 / det, c01 / det, c02 / det, c12 / det};
  memcpy(m, inverse, sizeof inverse);
  return true;
}

/* Whether something `away` from a particle is above it, within 45 degrees of the outward normal. */
static inline bool covers(int dim, const double *away, const double *normal, double size2,
                          double reach2) {
  double r2 = 0, up = 0;
  for (int d = 0; d < dim; d++) {
    r2 += away[d] * away[d];
    up += away[d] * normal[d];
  }
  return r2 > 0 && r2 < reach2 && up > 0 && 2 * up * up > r2 * size2;
}

/* What is covered by fluid or wall is not at the surface, however few neighbours it has. */
static bool is_covered(const sph_integrator *flow, int32_t cluster, int32_t i) {
  const int dim = flow->particles->dim;
  const sphi_frame *frame = &flow->frame;
  const double reach2 = pow(COVER * flow->particles->spacing, 2);
  double normal[SPHI_MAX_DIM], at[SPHI_MAX_DIM], away[SPHI_MAX_DIM], size2 = 0;
  double *const *x = flow->particles->field[SPHI_X].data;
  for (int d = 0; d < dim; d++) {
    at[d] = x[d][i];
    normal[d] = -isph_get(flow, ISPH_NORMAL + d, i);
    size2 += normal[d] * normal[d];
  }
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  for (int32_t k = 0; k < near->near; k++) {
    for (int d = 0; d < dim; d++) away[d] = sphi_frame_difference(frame, d, x[d][source[k]], at[d]);
    if (covers(dim, away, normal, size2, reach2)) return true;
  }
  const sph_boundary *boundary = flow->cloud.boundary;
  if (!boundary) return false;
  near = &flow->cloud.ghost_list.entry[cluster];
  source = flow->cloud.ghost_list.part[near->part].source + near->offset;
  for (int32_t k = 0; k < near->near; k++) {
    const sphi_wet_ghost *ghost = &boundary->wet[source[k]];
    if (ghost->immersed < 1 || ghost->volume == 0) continue;
    for (int d = 0; d < dim; d++)
      away[d] = sphi_frame_difference(frame, d, boundary->x[d][ghost->ghost], at[d]);
    if (covers(dim, away, normal, size2, reach2)) return true;
  }
  return false;
}

/* Drops and threads at a wall, whose ghosts make up for the neighbours that they lack: nothing holds the
 * pressure of their rows. */
static bool is_thread(const sph_integrator *flow, int32_t cluster, int32_t i) {
  const int dim = flow->particles->dim;
  double *const *x = flow->particles->field[SPHI_X].data;
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  const double reach2 = pow(NEXT * flow->particles->spacing, 2);
  int next = -1; /* itself */
  if (!flow->cloud.boundary || flow->cloud.ghost_list.entry[cluster].near == 0) return false;
  for (int32_t k = 0; k < near->near && next < FEW(dim); k++) {
    double r2 = 0;
    for (int d = 0; d < dim; d++) {
      const double away = sphi_frame_difference(&flow->frame, d, x[d][source[k]], x[d][i]);
      r2 += away * away;
    }
    next += r2 < reach2;
  }
  return next < FEW(dim);
}

/* Particles with few neighbours that nothing covers are the surface, and those with next to none. */
static void find_surface(sph_integrator *flow) {
  isph *s = isph_of(flow);
  int64_t surface = 0;
#pragma omp parallel for num_threads(flow->context->threads) schedule(dynamic, 16) reduction(+ : surface)
  for (int32_t c = 0; c < flow->clusters.n; c++)
    for (int32_t l = 0; l < flow->clusters.count[c]; l++) {
      const int32_t i = flow->clusters.first[c] + l;
      double trace = 0;
      for (int d = 0; d < flow->particles->dim; d++) trace += isph_get(flow, ISPH_MOMENT + d, i);
      isph_put(flow, ISPH_TRACE, i, trace);
      s->surface[i] = trace < s->threshold ? trace < 0.5 * s->threshold || !is_covered(flow, c, i)
                                           : is_thread(flow, c, i);
      surface += s->surface[i];
    }
  s->surface_count = surface;
}

/* What the entries of each row need. */
static void prepare_rows(sph_integrator *flow) {
  isph *s = isph_of(flow);
  const int dim = flow->particles->dim, terms = dim == 2 ? 3 : 6;
  const int32_t n = flow->particles->n;
  const double reach = flow->kernel->support;
#pragma omp parallel for num_threads(flow->context->threads) schedule(static) if (n > 1024)
  for (int32_t i = 0; i < n; i++) {
    double m[6], normal[SPHI_MAX_DIM], tilt[SPHI_MAX_DIM], size2 = 0, scale = 0;
    for (int k = 0; k < terms; k++) m[k] = isph_get(flow, ISPH_MOMENT + k, i);
    const bool regular = invert(dim, m);
    for (int d = 0; d < dim; d++) scale += m[d] / dim;
    const bool correct = regular && scale <= SCALE_MAX;
    for (int k = 0; k < terms; k++) isph_put(flow, ISPH_MOMENT + k, i, correct ? m[k] : k < dim);
    const bool plain = !correct || s->laplacian == SPH_ISPH_LAPLACIAN_SIMPLE || s->surface[i] != 0;
    for (int d = 0; d < dim; d++) normal[d] = plain ? 0 : isph_get(flow, ISPH_NORMAL + d, i);
    isph_times_moment(flow, i, normal, tilt);
    for (int d = 0; d < dim; d++) size2 += tilt[d] * tilt[d];
    const double most = TILT_MAX / reach, size = sqrt(size2);
    isph_put(flow, ISPH_SCALE, i, plain ? 1 : scale);
    for (int d = 0; d < dim; d++)
      isph_put(flow, ISPH_TILT + d, i, size > most ? tilt[d] * most / size : tilt[d]);
  }
}

/* Where clusters leave their entries, and the entries. */
static sph_status make_entries(sph_integrator *flow) {
  isph *s = isph_of(flow);
  sph_context *context = flow->context;
  const sphi_list *list[2] = {&flow->list, flow->cloud.boundary ? &flow->cloud.ghost_list : NULL};
  const int64_t lanes = flow->variant->lanes;
  for (int k = 0; k < 2; k++) {
    int64_t used = 0;
    SPH_CHECK(context,
              sphi_reserve(context, (void **)&s->place[k], &s->place_capacity[k],
                           flow->particles->n + 1, sizeof *s->place[k]),
              SPH_E_MEMORY, "isph: no memory for %d rows", flow->particles->n);
    for (int32_t c = 0; c < flow->clusters.n; c++) {
      s->place[k][flow->clusters.first[c]] = used;
      used += list[k] ? lanes * list[k]->entry[c].near : 0;
    }
    const int64_t room = used <= s->entry_capacity[k] ? used : used + used / 8;
    SPH_CHECK(context,
              sphi_reserve(context, &s->entry[k], &s->entry_capacity[k], room + SPHI_PAD,
                           flow->variant->real_size),
              SPH_E_MEMORY, "isph: no memory for %lld entries of the pressure equation",
              (long long)used);
  }
  sphi_laplacian_arguments a = {.scale = s->array[ISPH_SCALE],
                                .place = {s->place[0], s->place[1]},
                                .entry = {s->entry[0], s->entry[1]}};
  for (int d = 0; d < flow->particles->dim; d++) a.q[d] = s->array[ISPH_TILT + d];
  sphi_cloud_sweep(flow, SPHI_OPERATOR_laplacian, &a);
  return SPH_OK;
}

static inline double entry_of(const sph_integrator *flow, int list, int64_t at) {
  const void *entry = isph_of(flow)->entry[list];
  return flow->variant->is_double ? ((const double *)entry)[at]
                                  : (double)((const float *)entry)[at];
}

/* How far particle j is below surface particle i, of which `outward` is the normal. */
static double depth_below(const sph_integrator *flow, const double *outward, int32_t i, int32_t j) {
  double depth = 0;
  for (int d = 0; d < flow->particles->dim; d++) {
    const double *x = flow->particles->field[SPHI_X].data[d];
    depth += outward[d] * sphi_frame_difference(&flow->frame, d, x[i], x[j]);
  }
  return depth;
}

/* A surface particle is half a spacing below the surface, where the pressure is 0: what it has follows from
 * those below it, by straight lines,
 *
 *     p_i = sum_j b_j p_j,   b_j = a_ij / sum_k a_ik (dx/2) / (dx/2 + depth of j below i)
 *
 * over neighbours in the bulk. Without any its pressure is 0. */
static int64_t make_surface_row(sph_integrator *flow, int32_t cluster, int32_t lane, bool fill) {
  isph *s = isph_of(flow);
  const int32_t first = flow->clusters.first[cluster], i = first + lane;
  const int64_t lanes = flow->variant->lanes, begin = fill ? s->row_start[i] : 0;
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  const double half = 0.5 * flow->particles->spacing;
  double outward[SPHI_MAX_DIM], size = 0, sum = 0;
  int64_t used = begin + 1;
  for (int d = 0; d < flow->particles->dim; d++) {
    outward[d] = -isph_get(flow, ISPH_NORMAL + d, i);
    size += outward[d] * outward[d];
  }
  for (int d = 0; d < flow->particles->dim && size > 0; d++) outward[d] /= sqrt(size);
  for (int32_t k = 0; k < near->near; k++) {
    const double a = entry_of(flow, 0, s->place[0][first] + k * lanes + lane);
    const int32_t j = (int32_t)source[k];
    if (a == 0 || s->surface[j]) continue;
    const double depth = depth_below(flow, outward, i, j);
    if (depth < half) continue;
    sum += a;
    if (fill) {
      s->columns[used] = j;
      s->values[used] = -a * half / (half + depth);
    }
    used++;
  }
  if (fill) {
    s->columns[begin] = i;
    s->values[begin] = sum > 0 ? sum : 1;
    s->right[i] = 0;
  }
  return used - begin;
}

/* Adds to column j of the row of i that starts at `begin` and goes on to *used; see make_row for `mark`. */
static void add_entry(isph *s, int32_t i, int32_t j, double value, bool fill, int64_t begin,
                      int64_t *used, int32_t *mark) {
  if (!fill) {
    *used += mark[j] != i + 1;
    mark[j] = i + 1;
    return;
  }
  const int64_t at = begin + mark[j];
  if (mark[j] > 0 && at < *used && s->columns[at] == j) {
    s->values[at] += value;
    return;
  }
  mark[j] = (int32_t)(*used - begin);
  s->columns[*used] = j;
  s->values[(*used)++] = value;
}

/* One row at a time: counted if `fill` is not set, into the matrix if it is. `mark` tells for a column whether
 * the row has it: counting leaves i + 1 there, filling the place. */
static int64_t make_row(sph_integrator *flow, int32_t cluster, int32_t lane, bool fill,
                        int32_t *mark) {
  isph *s = isph_of(flow);
  const int32_t first = flow->clusters.first[cluster], i = first + lane;
  const int64_t lanes = flow->variant->lanes, begin = fill ? s->row_start[i] : 0;
  if (s->surface[i]) return make_surface_row(flow, cluster, lane, fill);
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  int64_t used = begin + 1; /* the diagonal leads */
  double diagonal = 0, known = 0;
  for (int32_t k = 0; k < near->near; k++) {
    const double a = entry_of(flow, 0, s->place[0][first] + k * lanes + lane);
    const int32_t j = (int32_t)source[k];
    if (a == 0 || j == i) continue;
    diagonal += a;
    add_entry(s, i, j, -a, fill, begin, &used, mark);
  }
  const sphi_ghost_rows *rows = &s->rows;
  if (flow->cloud.boundary) {
    near = &flow->cloud.ghost_list.entry[cluster];
    source = flow->cloud.ghost_list.part[near->part].source + near->offset;
  }
  for (int32_t k = 0; k < (flow->cloud.boundary ? near->near : 0); k++) {
    const double a = entry_of(flow, 1, s->place[1][first] + k * lanes + lane);
    const int32_t g = (int32_t)source[k];
    if (a == 0) continue;
    diagonal += a;
    known += a * rows->at_ghost[g];
    for (int64_t e = rows->first[g]; e < rows->first[g] + rows->count[g]; e++) {
      const int32_t j = rows->column[e];
      if (j == i)
        diagonal -= a * rows->weight[e];
      else
        add_entry(s, i, j, -a * rows->weight[e], fill, begin, &used, mark);
    }
  }
  if (fill) {
    s->columns[begin] = i;
    s->values[begin] = diagonal;
    s->right[i] = known;
  }
  return used - begin;
}

/* Rows of all particles, counted into row_start[i + 1] or filled. */
static void make_rows(sph_integrator *flow, bool fill) {
  isph *s = isph_of(flow);
  const int32_t n = flow->particles->n;
#pragma omp parallel num_threads(flow->context->threads) if (n > 1024)
  {
    int32_t *mark = s->mark + (int64_t)n * sphi_thread();
#pragma omp for schedule(dynamic, 16)
    for (int32_t c = 0; c < flow->clusters.n; c++)
      for (int32_t l = 0; l < flow->clusters.count[c]; l++) {
        const int64_t count = make_row(flow, c, l, fill, mark);
        if (!fill) s->row_start[flow->clusters.first[c] + l + 1] = count;
      }
  }
}

/* The sources of the equation: what has to go of the divergence, and of a density that has drifted. A particle
 * with neighbours all round may be too full or too empty; near the surface only too full is known. */
static void add_sources(sph_integrator *flow, double dt) {
  isph *s = isph_of(flow);
  const double rho0 = flow->cloud.rho0;
  const int32_t n = flow->particles->n;
  for (int32_t i = 0; i < n; i++) {
    if (s->surface[i]) continue;
    double drift = 1 - isph_get(flow, ISPH_FILLING, i) / s->filled;
    if (drift > 0 && isph_get(flow, ISPH_TRACE, i) < FULL * flow->particles->dim) drift = 0;
    double speed2 = 0;
    for (int d = 0; d < flow->particles->dim; d++)
      speed2 += pow(flow->particles->field[SPHI_V].data[d][i], 2);
    const double source =
        isph_get(flow, ISPH_DIVERGENCE, i) + s->theta * drift * sqrt(speed2) / flow->kernel->h;
    s->right[i] -= rho0 / dt * source;
  }
}

static sph_status reserve(sph_integrator *flow) {
  isph *s = isph_of(flow);
  sph_context *context = flow->context;
  const int64_t n = flow->particles->n;
  SPH_CHECK(
      context,
      sphi_reserve(context, (void **)&s->row_start, &s->row_capacity, n + 1,
                   sizeof *s->row_start) &&
          sphi_reserve(context, (void **)&s->right, &s->right_capacity, n, sizeof *s->right) &&
          sphi_reserve(context, (void **)&s->mark, &s->mark_capacity, n * flow->context->threads,
                       sizeof *s->mark),
      SPH_E_MEMORY, "isph: no memory for %lld rows", (long long)n);
  return SPH_OK;
}

static sph_status make_matrix(sph_integrator *flow, double dt) {
  isph *s = isph_of(flow);
  sph_context *context = flow->context;
  const int32_t n = flow->particles->n;
  SPH_TRY(reserve(flow));
  find_surface(flow);
  prepare_rows(flow);
  SPH_TRY(make_entries(flow));
  memset(s->mark, 0, (size_t)n * (size_t)context->threads * sizeof *s->mark);
  make_rows(flow, false);
  s->row_start[0] = 0;
  for (int32_t i = 0; i < n; i++) s->row_start[i + 1] += s->row_start[i];
  const int64_t entries = s->row_start[n];
  const int64_t room = entries <= s->value_capacity ? entries : entries + entries / 8;
  SPH_CHECK(
      context,
      sphi_reserve(context, (void **)&s->columns, &s->column_capacity, room, sizeof *s->columns) &&
          sphi_reserve(context, (void **)&s->values, &s->value_capacity, room, sizeof *s->values),
      SPH_E_MEMORY, "isph: no memory for %lld entries of the pressure equation",
      (long long)entries);
  make_rows(flow, true);
  add_sources(flow, dt);
  return SPH_OK;
}

sph_status sphi_isph_solve(sph_integrator *flow, double dt) {
  isph *s = isph_of(flow);
  const double begin = sphi_seconds(), pairs = flow->stats.seconds_pairs;
  const int32_t n = flow->particles->n;
  double *p = flow->particles->field[SPHI_P].data[0];
  SPH_TRY(make_matrix(flow, dt));
  const sph_matrix matrix = {
      .n = n, .row_start = s->row_start, .columns = s->columns, .values = s->values};
  SPH_TRY(sph_solver_set_null_space(s->solver, s->surface_count == 0));
  const sph_status status = sph_solver_solve(s->solver, &matrix, s->right, p);
  if (flow->cloud.boundary)
    sphi_boundary_set_pressures(flow->cloud.boundary, flow->variant, &s->rows, p);
  flow->stats.seconds_solver += sphi_seconds() - begin - (flow->stats.seconds_pairs - pairs);
  return status;
}
