/* Walls of dummy particles: the ghosts next to a wall's surface have pressures of their own, which the pressure
 * equation solves for with those of the fluid, and the ghosts behind follow them. See docs/theory/isph.md. */
#include "isph/isph_impl.h"

/* In spacings, how deep the layer next to the surface is, and how far beside its normal a ghost's is. */
static const double LAYER = 1, BESIDE = 1.5;
/* The sum of a row's entries, as part of that without tilt, below which less of the tilt is taken: wall particles
 * at the waterline see little, and would have diagonals below zero. */
static const double LEAST = 0.25;
/* Rows with less than this part of a full one, of wall particles that see the very edge of something, are made as
 * large. */
static const double FAINT = 1e-3;
/* Cosine of the angle between the normals of two ghosts on different sides of a thin wall. */
static const double OPPOSITE = -0.5;

enum { MOST_COLUMNS = 1024 };

void sphi_isph_dummies_free(sph_context *context, isph_dummies *s) {
  sphi_free(context, s->owner);
  sphi_free(context, s->kept);
  sphi_free(context, s->unknown);
  sphi_free(context, s->wet);
  sphi_free(context, s->start);
  sphi_free(context, s->fluid);
  sphi_free(context, s->room);
  sphi_free(context, s->count);
  sphi_free(context, s->column);
  sphi_free(context, s->value);
  sphi_free(context, s->p);
  memset(s, 0, sizeof *s);
}

/* Visits ghosts around a place, in the order of their columns. */
typedef struct visit {
  const sph_integrator *flow;
  int32_t found[MOST_COLUMNS];
  int32_t columns, column, piece, pieces, at;
  int32_t range[3][2];
  double lo, hi;
} visit;

/* Ghosts may have moved by the skin since they were sorted. */
static void visit_around(visit *v, const sph_integrator *flow, const double *x, double radius) {
  const sphi_columns *columns = &flow->cloud.boundary->columns;
  const double reach = radius * (1 + flow->cloud.skin);
  sphi_window window;
  double at[SPHI_MAX_DIM];
  for (int d = 0; d < columns->dim; d++) at[d] = sphi_frame_wrap(&flow->frame, d, x[d]);
  sphi_columns_window(columns, &flow->frame, at, at, reach, &window);
  v->flow = flow;
  v->columns = sphi_columns_in(columns, &window, MOST_COLUMNS, v->found);
  if (v->columns > MOST_COLUMNS) v->columns = MOST_COLUMNS;
  v->lo = at[columns->dim - 1] - reach;
  v->hi = at[columns->dim - 1] + reach;
  v->column = -1;
  v->piece = v->pieces = v->at = 0;
}

/* The next ghost, -1 after the last. */
static int32_t visit_next(visit *v) {
  const sphi_columns *columns = &v->flow->cloud.boundary->columns;
  while (v->piece >= v->pieces || v->at >= v->range[v->piece][1]) {
    if (v->piece + 1 < v->pieces) {
      v->piece++;
    } else {
      if (++v->column >= v->columns) return -1;
      v->piece = 0;
      v->pieces =
          sphi_columns_range(columns, &v->flow->frame, v->found[v->column], v->lo, v->hi, v->range);
    }
    if (v->piece < v->pieces) v->at = v->range[v->piece][0];
  }
  return columns->order[v->at++];
}

/* x_a - x_b and its square. */
static double between(const sph_integrator *flow, const double *a, const double *b, double *away) {
  double r2 = 0;
  for (int d = 0; d < flow->particles->dim; d++) {
    away[d] = sphi_frame_difference(&flow->frame, d, a[d], b[d]);
    r2 += away[d] * away[d];
  }
  return r2;
}

static void place_of(const sph_boundary *boundary, int64_t ghost, double *x) {
  for (int d = 0; d < boundary->dim; d++) x[d] = boundary->x[d][ghost];
}

static double depth_of(const sph_boundary *boundary, int64_t ghost) {
  const sphi_ghost_points *points = &boundary->points;
  double r2 = 0;
  for (int d = 0; d < points->dim; d++)
    r2 += pow(points->x[points->dim * ghost + d] - points->foot[points->dim * ghost + d], 2);
  return sqrt(r2) / boundary->spacing;
}

/* The wall particle that a ghost follows: itself in the first layer, else the nearest of its wall. Walls are
 * rigid, so it stays. */
static int32_t find_owner(const sph_integrator *flow, int32_t ghost) {
  const sph_boundary *boundary = flow->cloud.boundary;
  const double depth = depth_of(boundary, ghost);
  double x[SPHI_MAX_DIM], other[SPHI_MAX_DIM], away[SPHI_MAX_DIM], nearest2 = HUGE_VAL;
  int32_t owner = -1;
  visit v;
  if (depth < LAYER) return ghost;
  place_of(boundary, ghost, x);
  visit_around(&v, flow, x, (depth + BESIDE) * boundary->spacing);
  for (int32_t g = visit_next(&v); g >= 0; g = visit_next(&v)) {
    if (boundary->wall_of[g] != boundary->wall_of[ghost] || depth_of(boundary, g) >= LAYER)
      continue;
    place_of(boundary, g, other);
    const double r2 = between(flow, other, x, away);
    const double same = 1e-9 * r2; /* among equals the first, whatever the walls' motion rounds */
    if (r2 > nearest2 + same || (r2 > nearest2 - same && g > owner)) continue;
    nearest2 = r2;
    owner = g;
  }
  return owner;
}

static sph_status reserve(sph_integrator *flow) {
  isph_dummies *s = &isph_of(flow)->dummies;
  const sph_boundary *boundary = flow->cloud.boundary;
  const int64_t ghosts = boundary->points.n, wet = boundary->wet_count;
  sph_context *context = flow->context;
  SPH_CHECK(
      context,
      sphi_reserve(context, (void **)&s->owner, &s->capacity[0], ghosts, sizeof *s->owner) &&
          sphi_reserve(context, (void **)&s->kept, &s->capacity[1], ghosts, sizeof *s->kept) &&
          sphi_reserve(context, (void **)&s->unknown, &s->capacity[2], wet, sizeof *s->unknown) &&
          sphi_reserve(context, (void **)&s->wet, &s->capacity[3], wet, sizeof *s->wet) &&
          sphi_reserve(context, (void **)&s->start, &s->capacity[4], wet + 1, sizeof *s->start) &&
          sphi_reserve(context, (void **)&s->room, &s->capacity[5], wet + 1, sizeof *s->room) &&
          sphi_reserve(context, (void **)&s->count, &s->capacity[6], wet + 1, sizeof *s->count) &&
          sphi_reserve(context, (void **)&s->p, &s->capacity[7], flow->particles->n + wet,
                       sizeof *s->p),
      SPH_E_MEMORY, "isph: no memory for %lld ghosts", (long long)ghosts);
  return SPH_OK;
}

/* Numbers the wall particles that take part. */
static void number(sph_integrator *flow) {
  isph_dummies *s = &isph_of(flow)->dummies;
  const sph_boundary *boundary = flow->cloud.boundary;
  const int32_t ghosts = (int32_t)boundary->points.n;
  if (s->ghosts != ghosts) {
#pragma omp parallel for num_threads(flow->context->threads) schedule(dynamic, 64)
    for (int32_t g = 0; g < ghosts; g++) s->owner[g] = find_owner(flow, g);
    memset(s->kept, 0, (size_t)ghosts * sizeof *s->kept);
    s->ghosts = ghosts;
  }
  s->n = 0;
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    const int32_t ghost = boundary->wet[k].ghost;
    s->unknown[k] = -1;
    if (s->owner[ghost] != ghost) continue;
    s->unknown[k] = s->n;
    s->wet[s->n++] = k;
  }
}

/* Whether wet ghost k, a wall particle, has fluid in reach and a row of the equation. */
static bool is_live(const sph_integrator *flow, int32_t k) {
  return flow->cloud.boundary->wet[k].immersed > 0 && isph_of(flow)->rows.count[k] > 0;
}

/* rho0 (f - a_w) at wet ghost k for walls that are consistent, 0 for those as printed. */
static void push_at(const sph_integrator *flow, int32_t k, double t, double *push) {
  memset(push, 0, SPHI_MAX_DIM * sizeof *push);
  if (isph_of(flow)->walls != SPH_ISPH_WALLS_DUMMIES) return;
  const sph_boundary *boundary = flow->cloud.boundary;
  const sphi_body_force *force = &flow->cloud.force;
  if (boundary->dim == 2)
    (void)sphi_wall_gradient(boundary, 2, k, force, t, flow->cloud.rho0, push);
  else
    (void)sphi_wall_gradient(boundary, 3, k, force, t, flow->cloud.rho0, push);
}

sph_status sphi_isph_dummies_rows(sph_integrator *flow, double t) {
  isph *s = isph_of(flow);
  isph_dummies *a = &s->dummies;
  sph_boundary *boundary = flow->cloud.boundary;
  sphi_ghost_rows *rows = &s->rows;
  SPH_TRY(reserve(flow));
  number(flow);
  /* Owners' counts tell below whether they are live: those who follow come first, from the interpolated rows. */
  for (int turn = 0; turn < 2; turn++)
    for (int32_t k = 0; k < boundary->wet_count; k++) {
      const sphi_wet_ghost *ghost = &boundary->wet[k];
      const int32_t owner = a->owner[ghost->ghost];
      const int32_t leader = owner >= 0 ? boundary->place[owner] : -1;
      if ((a->unknown[k] >= 0) != (turn == 1)) continue;
      const bool follows = is_live(flow, k) && leader >= 0 && is_live(flow, leader);
      rows->at_ghost[k] = rows->at_foot[k] = 0;
      rows->count[k] = follows;
      if (!follows) continue;
      double x[SPHI_MAX_DIM], from[SPHI_MAX_DIM], away[SPHI_MAX_DIM], push[SPHI_MAX_DIM];
      place_of(boundary, ghost->ghost, x);
      place_of(boundary, owner, from);
      (void)between(flow, x, from, away);
      push_at(flow, k, t, push);
      rows->column[rows->first[k]] = flow->particles->n + a->unknown[leader];
      rows->weight[rows->first[k]] = 1;
      for (int d = 0; d < boundary->dim; d++) {
        rows->at_ghost[k] += push[d] * away[d];
        rows->at_foot[k] += push[d] * (away[d] + ghost->to_foot[d] - ghost->to_ghost[d]);
      }
    }
  return SPH_OK;
}

void sphi_isph_dummies_velocities(sph_integrator *flow, double t, double dt) {
  sph_boundary *boundary = flow->cloud.boundary;
  const int dim = boundary->dim;
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    const sphi_wet_ghost *ghost = &boundary->wet[k];
    double foot[SPHI_MAX_DIM], v[SPHI_MAX_DIM], push[SPHI_MAX_DIM];
    for (int d = 0; d < dim; d++) foot[d] = boundary->mirrors.x[d][k] + ghost->to_foot[d];
    sphi_wall_velocity_at(&boundary->state[ghost->wall], dim, foot, v, NULL);
    push_at(flow, k, t, push);
    for (int d = 0; d < dim; d++)
      sphi_put_real(boundary->record, flow->variant->is_double,
                    (int64_t)k * SPHI_GHOST(dim) + dim + 2 + d,
                    v[d] + dt * push[d] / flow->cloud.rho0);
  }
}

/* The fluid's entries of ghosts, turned round: who lists wall particle w. Counts them if `fluid` is NULL. */
static void turn_lists(const sph_integrator *flow, int64_t *at, int32_t *fluid) {
  const isph *s = isph_of(flow);
  const int64_t lanes = flow->variant->lanes;
  const sphi_list *list = &flow->cloud.ghost_list;
  for (int32_t c = 0; c < flow->clusters.n; c++) {
    const sphi_list_entry *near = &list->entry[c];
    const uint32_t *source = list->part[near->part].source + near->offset;
    const int32_t first = flow->clusters.first[c];
    for (int32_t k = 0; k < near->near; k++) {
      const int32_t w = s->dummies.unknown[source[k]];
      for (int32_t l = 0; l < flow->clusters.count[c] && w >= 0; l++)
        if (isph_entry(flow, 1, s->place[1][first] + k * lanes + l) != 0) {
          if (fluid) fluid[at[w]] = first + l;
          at[w]++;
        }
    }
  }
}

/* What a wall particle sees: fluid j, or wet ghost k. */
typedef struct seen {
  double away[SPHI_MAX_DIM], slope; /* x_w - x_j; V_j (dW/dr)/r */
} seen;

static bool see(const sph_integrator *flow, const double *x, const double *other, double volume,
                seen *out) {
  const double r2 = between(flow, x, other, out->away), r = sqrt(r2);
  if (r >= flow->kernel->support || r2 == 0) return false;
  out->slope = volume * sph_kernel_dw(flow->kernel, r) / r;
  return out->slope != 0;
}

/* The next wet ghost that wet ghost k sees, -1 after the last. Ghosts too deep for fluid at the wall to list
 * come and go with the lists, and are left out. */
static int32_t next_ghost(visit *v, int32_t k, const double *x, seen *out) {
  const sph_boundary *boundary = v->flow->cloud.boundary;
  const sphi_wet_ghost *wet = boundary->wet;
  const double most = v->flow->kernel->support / boundary->spacing - 0.5;
  for (int32_t g = visit_next(v); g >= 0; g = visit_next(v)) {
    const int32_t other = boundary->place[g];
    double at[SPHI_MAX_DIM], cosine = 0;
    if (other < 0 || isph_of(v->flow)->rows.count[other] == 0 || depth_of(boundary, g) > most)
      continue;
    for (int d = 0; d < boundary->dim; d++) cosine += wet[k].normal[d] * wet[other].normal[d];
    place_of(boundary, g, at);
    if (cosine > OPPOSITE && see(v->flow, x, at, wet[other].immersed * wet[other].volume, out))
      return other;
  }
  return -1;
}

static void velocity_of(const sph_integrator *flow, int32_t k, double *v) {
  const sph_boundary *boundary = flow->cloud.boundary;
  const int64_t at = (int64_t)k * SPHI_GHOST(boundary->dim) + boundary->dim + 2;
  for (int d = 0; d < boundary->dim; d++)
    v[d] = flow->variant->is_double ? ((const double *)boundary->record)[at + d]
                                    : (double)((const float *)boundary->record)[at + d];
}

/* Sums over what a wall particle sees, as those of op_projection. */
typedef struct sums {
  double m[6], all, normal[SPHI_MAX_DIM], shear[SPHI_MAX_DIM][SPHI_MAX_DIM];
} sums;

static void sum_up(int dim, const seen *by, const double *v, const double *other, sums *s) {
  static const int at[2][3][3] = {{{0, 2}, {2, 1}}, {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}}};
  s->all += by->slope;
  for (int d = 0; d < dim; d++) {
    s->normal[d] += by->slope * by->away[d];
    for (int e = 0; e < dim; e++) s->shear[d][e] += (other[d] - v[d]) * by->slope * by->away[e];
    for (int e = 0; e <= d; e++) s->m[at[dim - 2][d][e]] -= by->slope * by->away[d] * by->away[e];
  }
}

/* Adds to the row of w at `begin`, which has *used columns; `mark` tells where a wall's column may be. */
static void add(isph_dummies *s, int64_t begin, int32_t *used, int32_t *mark, int32_t column,
                double value) {
  const int32_t at = mark[column];
  if (at >= 0 && at < *used && s->column[begin + at] == column) {
    s->value[begin + at] += value;
    return;
  }
  mark[column] = *used;
  s->column[begin + *used] = column;
  s->value[begin + (*used)++] = value;
}

/* The row of wall particle w: that of fluid without air, with sums in double. */
static void make_row(sph_integrator *flow, int32_t w, double dt, int32_t *mark) {
  isph *all = isph_of(flow);
  isph_dummies *s = &all->dummies;
  const sph_boundary *boundary = flow->cloud.boundary;
  const int dim = boundary->dim;
  const int32_t n = flow->particles->n, k = s->wet[w];
  const int64_t begin = s->room[w];
  double *const *x = flow->particles->field[SPHI_X].data;
  const double *volume = flow->particles->field[SPHI_VOL].data[0];
  double at[SPHI_MAX_DIM], v[SPHI_MAX_DIM], other[SPHI_MAX_DIM], v_other[SPHI_MAX_DIM];
  int32_t used = 0;
  double *right = &all->right[n + w];
  sums sum = {0};
  seen by;
  visit ghosts;
  *right = 0;
  add(s, begin, &used, mark, n + w, 0);
  if (!is_live(flow,
               k)) { /* nobody sees it; a singular system stays one with constants in its kernel */
    s->value[begin] = 1;
    if (!all->has_surface) add(s, begin, &used, mark, 0, -1);
    s->count[w] = used;
    return;
  }
  place_of(boundary, boundary->wet[k].ghost, at);
  velocity_of(flow, k, v);
  for (int64_t e = s->start[w]; e < s->start[w + 1]; e++) {
    const int32_t j = s->fluid[e];
    for (int d = 0; d < dim; d++) {
      other[d] = x[d][j];
      v_other[d] = all->between[d][j];
    }
    if (see(flow, at, other, volume[j], &by)) sum_up(dim, &by, v, v_other, &sum);
  }
  visit_around(&ghosts, flow, at, flow->kernel->support);
  for (int32_t g = next_ghost(&ghosts, k, at, &by); g >= 0; g = next_ghost(&ghosts, k, at, &by)) {
    velocity_of(flow, g, v_other);
    sum_up(dim, &by, v, v_other, &sum);
  }
  double tilt[SPHI_MAX_DIM], divergence;
  const double scale = sphi_isph_tilt(flow, sum.m, sum.normal, &sum.shear[0][0], tilt, &divergence);
  double more = 0;
  for (int d = 0; d < dim; d++) more += tilt[d] * sum.normal[d];
  if (more / sum.all < LEAST - 1)
    for (int d = 0; d < dim; d++) tilt[d] *= (LEAST - 1) * sum.all / more;
  for (int64_t e = s->start[w]; e < s->start[w + 1]; e++) {
    const int32_t j = s->fluid[e];
    for (int d = 0; d < dim; d++) other[d] = x[d][j];
    if (!see(flow, at, other, volume[j], &by)) continue;
    double a = 1;
    for (int d = 0; d < dim; d++) a += tilt[d] * by.away[d];
    a *= -2 * scale * by.slope;
    s->value[begin] += a;
    add(s, begin, &used, mark, j, -a);
  }
  visit_around(&ghosts, flow, at, flow->kernel->support);
  for (int32_t g = next_ghost(&ghosts, k, at, &by); g >= 0; g = next_ghost(&ghosts, k, at, &by)) {
    double a = 1;
    for (int d = 0; d < dim; d++) a += tilt[d] * by.away[d];
    a *= -2 * scale * by.slope;
    s->value[begin] += a;
    *right += a * all->rows.at_ghost[g];
    add(s, begin, &used, mark, all->rows.column[all->rows.first[g]], -a);
  }
  *right -= flow->cloud.rho0 / dt * divergence;
  if (!(s->value[begin] > 0)) s->value[begin] = 1;
  const double larger = FAINT * all->full / s->value[begin];
  for (int32_t e = 0; e < used && larger > 1; e++) s->value[begin + e] *= larger;
  if (larger > 1) *right *= larger;
  s->count[w] = used;
}

/* How many ghosts wall particle w may see. */
static int32_t count_ghosts(const sph_integrator *flow, int32_t w) {
  const sph_boundary *boundary = flow->cloud.boundary;
  const int32_t k = isph_of(flow)->dummies.wet[w];
  double at[SPHI_MAX_DIM];
  int32_t count = 0;
  seen by;
  visit v;
  place_of(boundary, boundary->wet[k].ghost, at);
  visit_around(&v, flow, at, flow->kernel->support);
  while (next_ghost(&v, k, at, &by) >= 0) count++;
  return count;
}

sph_status sphi_isph_dummies_matrix(sph_integrator *flow, double dt) {
  isph *all = isph_of(flow);
  isph_dummies *s = &all->dummies;
  sph_context *context = flow->context;
  const int64_t unknowns = flow->particles->n + s->n;
  memset(s->start, 0, (size_t)(s->n + 1) * sizeof *s->start);
  turn_lists(flow, s->start, NULL);
  int64_t listed = 0;
  for (int32_t w = 0; w <= s->n; w++) {
    const int64_t count = w < s->n ? s->start[w] : 0;
    s->start[w] = s->room[w] = listed;
    listed += count;
  }
  SPH_CHECK(context,
            sphi_reserve(context, (void **)&s->fluid, &s->capacity[8], listed, sizeof *s->fluid),
            SPH_E_MEMORY, "isph: no memory for %lld neighbours of walls", (long long)listed);
  turn_lists(flow, s->room, s->fluid);
#pragma omp parallel for num_threads(context->threads) schedule(dynamic, 16) if (s->n > 64)
  for (int32_t w = 0; w < s->n; w++) s->count[w] = count_ghosts(flow, w);
  int64_t room = 0;
  for (int32_t w = 0; w < s->n; w++) {
    s->room[w] = room;
    room += 2 + s->count[w] + s->start[w + 1] - s->start[w];
  }
  SPH_CHECK(context,
            sphi_reserve(context, (void **)&s->column, &s->capacity[9], room, sizeof *s->column) &&
                sphi_reserve(context, (void **)&s->value, &s->capacity[10], room, sizeof *s->value),
            SPH_E_MEMORY, "isph: no memory for %lld entries of walls", (long long)room);
#pragma omp parallel for num_threads(context->threads) schedule(dynamic, 16) if (s->n > 64)
  for (int32_t w = 0; w < s->n; w++) make_row(flow, w, dt, all->mark + unknowns * sphi_thread());
  return SPH_OK;
}
