/* The pressure equation: rows, solution. */
#include "isph/isph_impl.h"

/* One-sided support makes scales of the Laplacian that mean nothing; tilts stay within what keeps entries
 * positive; a particle whose divergence of positions is that much of the full one has neighbours all round. */
static const double SCALE_MAX = 3, TILT_MAX = 0.9, FULL = 0.97;
/* The share of the entries that air takes away which holds the pressure of drops, where sums over neighbours
 * cancel. */
static const double MISSING = 0.9;

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

double sphi_isph_tilt(const sph_integrator *flow, const double *moment, const double *normal,
                      const double *shear, double *tilt, double *divergence) {
  static const int at[2][3][3] = {{{0, 2}, {2, 1}}, {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}}};
  const int dim = flow->particles->dim, terms = dim == 2 ? 3 : 6;
  double m[6], scale = 0;
  memcpy(m, moment, sizeof m);
  bool correct = invert(dim, m);
  for (int d = 0; d < dim; d++) scale += m[d] / dim;
  correct = correct && scale <= SCALE_MAX;
  for (int k = 0; k < terms && !correct; k++) m[k] = k < dim;
  const bool plain = !correct || isph_of(flow)->laplacian == SPH_ISPH_LAPLACIAN_SIMPLE;
  *divergence = 0;
  for (int d = 0; d < dim; d++) {
    tilt[d] = 0;
    for (int e = 0; e < dim; e++) {
      tilt[d] += plain ? 0 : m[at[dim - 2][d][e]] * normal[e];
      *divergence += m[at[dim - 2][d][e]] * shear[d * SPHI_MAX_DIM + e];
    }
  }
  return plain ? 1 : scale;
}

/* What the entries of row i need, with tilts for those that are not open:
 *
 *   s = tr L / dim,   q = (1 - o) L N,   L = M^-1                                             (1)
 *
 * and the air's share of the pressure gradient: the part of M that is missing sees a straight line from p_i
 * to 0 at the surface,
 *
 *   o (I - M) p_i N / (|N| d)                                                                 (2) */
static void prepare_row(sph_integrator *flow, int32_t i) {
  isph *s = isph_of(flow);
  const int dim = flow->particles->dim, terms = dim == 2 ? 3 : 6;
  double m[6], normal[SPHI_MAX_DIM], tilt[SPHI_MAX_DIM], size2 = 0, scale = 0, divergence = 0;
  for (int k = 0; k < terms; k++) m[k] = isph_get(flow, ISPH_MOMENT + k, i);
  for (int d = 0; d < dim; d++) {
    normal[d] = isph_get(flow, ISPH_NORMAL + d, i);
    size2 += normal[d] * normal[d];
  }
  isph_times_moment(flow, i, normal, tilt);
  const double air = s->open[i] / (sqrt(size2) * isph_get(flow, ISPH_DEPTH, i));
  for (int d = 0; d < dim; d++)
    isph_put(flow, ISPH_AIR + d, i, size2 > 0 ? air * (normal[d] - tilt[d]) : 0);
  const bool regular = invert(dim, m);
  for (int d = 0; d < dim; d++) scale += m[d] / dim;
  const bool correct = regular && scale <= SCALE_MAX;
  for (int k = 0; k < terms; k++) isph_put(flow, ISPH_MOMENT + k, i, correct ? m[k] : k < dim);
  const bool plain = !correct || s->laplacian == SPH_ISPH_LAPLACIAN_SIMPLE;
  for (int d = 0; d < dim; d++) normal[d] *= plain ? 0 : 1 - s->open[i];
  isph_times_moment(flow, i, normal, tilt);
  size2 = 0;
  for (int d = 0; d < dim; d++) size2 += tilt[d] * tilt[d];
  const double most = TILT_MAX / flow->kernel->support, size = sqrt(size2);
  for (int d = 0; d < dim; d++)
    isph_put(flow, ISPH_TILT + d, i, size > most ? tilt[d] * most / size : tilt[d]);
  isph_put(flow, ISPH_SCALE, i, plain ? 1 : scale);
  for (int d = 0; d < dim; d++) {
    double gradient[SPHI_MAX_DIM], corrected[SPHI_MAX_DIM];
    for (int e = 0; e < dim; e++) gradient[e] = isph_get(flow, ISPH_SHEAR + d * dim + e, i);
    isph_times_moment(flow, i, gradient, corrected);
    divergence += corrected[d];
  }
  isph_put(flow, ISPH_DIVERGENCE, i, divergence);
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
                                .entry = {s->entry[0], s->entry[1]},
                                .sum = s->array[ISPH_SUM],
                                .count = s->array[ISPH_COUNT],
                                .spacing = flow->particles->spacing};
  for (int d = 0; d < flow->particles->dim; d++) {
    a.q[d] = s->array[ISPH_TILT + d];
    a.up[d] = s->array[ISPH_UP + d];
    a.collision[d] = s->array[ISPH_COLLISION + d];
  }
  sphi_isph_pack(flow, s->between, s->open);
  sphi_cloud_sweep(flow, SPHI_OPERATOR_laplacian, &a);
  return SPH_OK;
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

/* The fluid's entries of row i into the matrix, from *used on. What is 0 is left out without a branch. */
static void add_fluid(sph_integrator *flow, int32_t cluster, int32_t lane, int64_t *used) {
  enum { CHUNK = 256 };
  isph *s = isph_of(flow);
  int32_t column[CHUNK];
  double value[CHUNK];
  const int64_t lanes = flow->variant->lanes;
  const int64_t place = s->place[0][flow->clusters.first[cluster]] + lane;
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  for (int32_t begin = 0; begin < near->near; begin += CHUNK) {
    const int32_t end = near->near - begin < CHUNK ? near->near : begin + CHUNK;
    int kept = 0;
    for (int32_t k = begin; k < end; k++) {
      const double a = isph_entry(flow, 0, place + k * lanes);
      column[kept] = (int32_t)source[k];
      value[kept] = -a;
      kept += a != 0;
    }
    memcpy(s->columns + *used, column, (size_t)kept * sizeof *column);
    memcpy(s->values + *used, value, (size_t)kept * sizeof *value);
    *used += kept;
  }
}

/* The ghosts' entries of row i, which go to the particles of their rows. `mark` tells for a column whether
 * the row has it: counting leaves i + 1 there, filling the place. */
static void add_ghosts(sph_integrator *flow, int32_t cluster, int32_t lane, bool fill,
                       int64_t begin, int64_t *used, int32_t *mark, double *diagonal) {
  isph *s = isph_of(flow);
  const int32_t first = flow->clusters.first[cluster], i = first + lane;
  const int64_t lanes = flow->variant->lanes;
  const sphi_list_entry *near = &flow->cloud.ghost_list.entry[cluster];
  const uint32_t *source = flow->cloud.ghost_list.part[near->part].source + near->offset;
  const sphi_ghost_rows *rows = &s->rows;
  for (int32_t k = 0; k < near->near; k++) {
    const double a = isph_entry(flow, 1, s->place[1][first] + k * lanes + lane);
    const int32_t g = (int32_t)source[k];
    if (a == 0) continue;
    if (fill) {
      *diagonal += a;
      s->right[i] += a * rows->at_ghost[g];
    }
    for (int64_t e = rows->first[g]; e < rows->first[g] + rows->count[g]; e++) {
      const int32_t j = rows->column[e];
      if (j != i)
        add_entry(s, i, j, -a * rows->weight[e], fill, begin, used, mark);
      else if (fill)
        *diagonal -= a * rows->weight[e];
    }
  }
}

static bool has_ghosts(const sph_integrator *flow, int32_t cluster) {
  return flow->cloud.boundary && flow->cloud.ghost_list.entry[cluster].near > 0;
}

/* The columns of a row, counted. */
static int64_t count_row(sph_integrator *flow, int32_t cluster, int32_t lane, int32_t *mark) {
  isph *s = isph_of(flow);
  const int32_t first = flow->clusters.first[cluster], i = first + lane;
  int64_t used = 1; /* the diagonal */
  if (!has_ghosts(flow, cluster)) return used + (int64_t)isph_get(flow, ISPH_COUNT, i);
  const sphi_list_entry *near = &flow->list.entry[cluster];
  const uint32_t *source = flow->list.part[near->part].source + near->offset;
  for (int32_t k = 0; k < near->near; k++)
    if (isph_entry(flow, 0, s->place[0][first] + k * flow->variant->lanes + lane) != 0)
      add_entry(s, i, (int32_t)source[k], 0, false, 0, &used, mark);
  add_ghosts(flow, cluster, lane, false, 0, &used, mark, NULL);
  return used;
}

/* Row i of
 *
 *   sum_j a_ij (p_j - p_i) - o_i c_i p_i = (source),   c_i = s 2 |N_i| / d_i,                 (3)
 *
 * with the ghosts' pressures as sums over those of the fluid. Air takes the place of the tilt at the surface:
 * both stand for 2 N . grad p, see docs/theory/isph.md. */
static void fill_row(sph_integrator *flow, int32_t cluster, int32_t lane, int32_t *mark) {
  isph *s = isph_of(flow);
  const int32_t i = flow->clusters.first[cluster] + lane;
  const int64_t begin = s->row_start[i];
  int64_t used = begin + 1;
  double diagonal = isph_get(flow, ISPH_SUM, i);
  s->right[i] = 0;
  add_fluid(flow, cluster, lane, &used);
  if (has_ghosts(flow, cluster)) {
    for (int64_t at = begin + 1; at < used; at++) mark[s->columns[at]] = (int32_t)(at - begin);
    add_ghosts(flow, cluster, lane, true, begin, &used, mark, &diagonal);
  }
  if (s->open[i] > 0) {
    const double scale = isph_get(flow, ISPH_SCALE, i);
    double size2 = 0;
    for (int d = 0; d < flow->particles->dim; d++)
      size2 += pow(isph_get(flow, ISPH_NORMAL + d, i), 2);
    const double air = 2 * scale * sqrt(size2) / isph_get(flow, ISPH_DEPTH, i);
    diagonal += s->open[i] * fmax(air, MISSING * (scale * s->full - diagonal));
  }
  s->columns[begin] = i;
  s->values[begin] = diagonal > 0 ? diagonal : 1;
}

/* Rows of all particles, counted into row_start[i + 1] or filled. */
static void make_rows(sph_integrator *flow, bool fill) {
  isph *s = isph_of(flow);
  const int32_t n = flow->particles->n;
#pragma omp parallel num_threads(flow->context->threads) if (n > 1024)
  {
    int32_t *mark = s->mark + (int64_t)(n + s->dummies.n) * sphi_thread();
#pragma omp for schedule(dynamic, 16)
    for (int32_t c = 0; c < flow->clusters.n; c++)
      for (int32_t l = 0; l < flow->clusters.count[c]; l++) {
        if (fill)
          fill_row(flow, c, l, mark);
        else
          s->row_start[flow->clusters.first[c] + l + 1] = count_row(flow, c, l, mark);
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
  const int64_t n = flow->particles->n + s->dummies.n;
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
  const int32_t n = flow->particles->n, all = n + s->dummies.n;
  SPH_TRY(reserve(flow));
  sphi_isph_find_surface(flow);
#pragma omp parallel for num_threads(context->threads) schedule(static) if (n > 1024)
  for (int32_t i = 0; i < n; i++) prepare_row(flow, i);
  SPH_TRY(make_entries(flow));
  memset(s->mark, 0, (size_t)all * (size_t)context->threads * sizeof *s->mark);
  make_rows(flow, false);
  if (s->dummies.n > 0) SPH_TRY(sphi_isph_dummies_matrix(flow, dt));
  for (int32_t w = 0; w < s->dummies.n; w++) s->row_start[n + w + 1] = s->dummies.count[w];
  s->row_start[0] = 0;
  for (int32_t i = 0; i < all; i++) s->row_start[i + 1] += s->row_start[i];
  const int64_t entries = s->row_start[all];
  const int64_t room = entries <= s->value_capacity ? entries : entries + entries / 8;
  SPH_CHECK(
      context,
      sphi_reserve(context, (void **)&s->columns, &s->column_capacity, room, sizeof *s->columns) &&
          sphi_reserve(context, (void **)&s->values, &s->value_capacity, room, sizeof *s->values),
      SPH_E_MEMORY, "isph: no memory for %lld entries of the pressure equation",
      (long long)entries);
  make_rows(flow, true);
  for (int32_t w = 0; w < s->dummies.n; w++) {
    const size_t count = (size_t)s->dummies.count[w];
    memcpy(s->columns + s->row_start[n + w], s->dummies.column + s->dummies.room[w],
           count * sizeof *s->columns);
    memcpy(s->values + s->row_start[n + w], s->dummies.value + s->dummies.room[w],
           count * sizeof *s->values);
  }
  add_sources(flow, dt);
  return SPH_OK;
}

sph_status sphi_isph_solve(sph_integrator *flow, double dt) {
  isph *s = isph_of(flow);
  const double begin = sphi_seconds(), pairs = flow->stats.seconds_pairs;
  const int32_t n = flow->particles->n;
  double *fluid = flow->particles->field[SPHI_P].data[0], *p = fluid;
  SPH_TRY(make_matrix(flow, dt));
  const isph_dummies *dummies = &s->dummies;
  if (dummies->n > 0) {
    p = dummies->p;
    memcpy(p, fluid, (size_t)n * sizeof *p);
    for (int32_t w = 0; w < dummies->n; w++)
      p[n + w] = dummies->kept[flow->cloud.boundary->wet[dummies->wet[w]].ghost];
  }
  const sph_matrix matrix = {
      .n = n + dummies->n, .row_start = s->row_start, .columns = s->columns, .values = s->values};
  SPH_TRY(sph_solver_set_null_space(s->solver, !s->has_surface));
  const sph_status status = sph_solver_solve(s->solver, &matrix, s->right, p);
  if (dummies->n > 0) {
    memcpy(fluid, p, (size_t)n * sizeof *p);
    for (int32_t w = 0; w < dummies->n; w++)
      dummies->kept[flow->cloud.boundary->wet[dummies->wet[w]].ghost] = p[n + w];
  }
  if (flow->cloud.boundary)
    sphi_boundary_set_pressures(flow->cloud.boundary, flow->variant, &s->rows, p);
  flow->stats.seconds_solver += sphi_seconds() - begin - (flow->stats.seconds_pairs - pairs);
  return status;
}
