/* The pressure equation: its pattern, its rows by cells around nodes, its solution.
 *
 * Each row gathers from the cells that touch its node, in their order: no thread adds to another's row. */
#include "flip/flip_impl.h"

enum { PARALLEL_FROM = 2048 };

/* Sine of the angle between walls from which on a corner keeps to both. */
static const double CORNER = 0.5;

/* Share of the area beyond which a surplus of volume counts no more. */
static const double MOST_SURPLUS = 0.5;

/* Places of node a's neighbours, a itself included, into columns from `at` on, unless it is NULL; their
 * number. mark[b] is a + 1 for those found. */
static int32_t find_row(const sph_mesh *mesh, int32_t a, int32_t *mark, int32_t *at) {
  int32_t count = 0;
  for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++)
    for (int l = 0; l < 3; l++) {
      const int32_t b = mesh->corner[3 * (int64_t)(mesh->touch[t] / 3) + l];
      if (mark[b] == a + 1) continue;
      mark[b] = a + 1;
      if (at) at[count] = b;
      count++;
    }
  return count;
}

static void find_slots(const sph_mesh *mesh, flip *s) {
  for (int32_t a = 0; a < mesh->nodes; a++)
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++)
      for (int l = 0; l < 3; l++) {
        const int32_t b = mesh->corner[3 * (int64_t)(mesh->touch[t] / 3) + l];
        int64_t k = s->row_start[a];
        while (s->columns[k] != b) k++;
        s->slot[3 * t + l] = (int32_t)(k - s->row_start[a]);
      }
}

sph_status sphi_flip_make_matrix(sph_integrator *flow) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  const sph_mesh *mesh = s->mesh;
  int32_t *mark = SPHI_NEW(context, mesh->nodes, int32_t);
  s->row_start = SPHI_NEW(context, (int64_t)mesh->nodes + 1, int64_t);
  s->slot = SPHI_NEW(context, 9 * (int64_t)mesh->cells, int32_t);
  if (mark && s->row_start) {
    for (int32_t a = 0; a < mesh->nodes; a++)
      s->row_start[a + 1] = s->row_start[a] + find_row(mesh, a, mark, NULL);
    s->columns = SPHI_NEW(context, s->row_start[mesh->nodes], int32_t);
    s->values = SPHI_NEW(context, s->row_start[mesh->nodes], double);
    memset(mark, 0, (size_t)mesh->nodes * sizeof *mark);
    for (int32_t a = 0; a < mesh->nodes && s->columns; a++)
      find_row(mesh, a, mark, s->columns + s->row_start[a]);
  }
  sphi_free(context, mark);
  SPH_CHECK(context, s->row_start && s->slot && s->columns && s->values, SPH_E_MEMORY,
            "flip: no memory for the pressure equation of %d nodes", mesh->nodes);
  find_slots(mesh, s);
  return SPH_OK;
}

/* ---- walls ---- */

static bool is_open(const flip *s, int32_t edge) {
  return s->open && s->mesh->tag[edge] == s->open;
}

/* Velocity along x of a node that follows the paddle. */
static double node_speed(const sph_mesh *mesh, int32_t a) {
  if (!mesh->motion) return 0;
  const double share = 1 - (mesh->rest[2 * (int64_t)a] - mesh->first) / mesh->reach;
  return share > 0 ? share * mesh->velocity : 0;
}

/* Outward normal of an edge of the boundary times its length. */
static void outward(const sph_mesh *mesh, int32_t edge, double *n) {
  const double *a = mesh->x + 2 * (int64_t)mesh->ends[2 * (int64_t)edge];
  const double *b = mesh->x + 2 * (int64_t)mesh->ends[2 * (int64_t)edge + 1];
  n[0] = b[1] - a[1];
  n[1] = a[0] - b[0];
}

/* What the node between two edges keeps to; one of them, or both, may be open (-1). */
static void hold_node(const flip *s, const double *normal_velocity, int32_t before, int32_t after,
                      flip_hold *hold) {
  double n[2][2], length[2], h[2];
  int walls = 0;
  for (int k = 0; k < 2; k++) {
    const int32_t edge = k == 0 ? before : after;
    if (edge < 0) continue;
    outward(s->mesh, edge, n[walls]);
    length[walls] = hypot(n[walls][0], n[walls][1]);
    for (int d = 0; d < 2; d++) n[walls][d] /= length[walls];
    h[walls++] = normal_velocity[edge];
  }
  hold->normals = walls;
  if (walls == 2 && fabs(n[0][0] * n[1][1] - n[0][1] * n[1][0]) < CORNER) {
    const double share = length[0] / (length[0] + length[1]);
    double mean[2];
    for (int d = 0; d < 2; d++) mean[d] = share * n[0][d] + (1 - share) * n[1][d];
    const double size = hypot(mean[0], mean[1]);
    for (int d = 0; d < 2; d++) n[0][d] = size > 0 ? mean[d] / size : n[0][d];
    h[0] = share * h[0] + (1 - share) * h[1];
    hold->normals = 1;
  }
  memcpy(hold->n, n, sizeof n);
  memcpy(hold->h, h, sizeof h);
}

void sphi_flip_measure(sph_integrator *flow, int when) {
  flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  double *h = s->normal_velocity[when];
  for (int32_t e = 0; e < mesh->boundary; e++) {
    double n[2];
    outward(mesh, e, n);
    const int32_t *ends = mesh->ends + 2 * (int64_t)e;
    h[e] = is_open(s, e) ? 0
                         : 0.5 * (node_speed(mesh, ends[0]) + node_speed(mesh, ends[1])) * n[0] /
                               hypot(n[0], n[1]);
  }
  memset(s->held, 0, (size_t)mesh->nodes);
  for (int32_t e = 0; e < mesh->boundary; e++)
    for (int k = 0; k < 2 && is_open(s, e); k++) s->held[mesh->ends[2 * (int64_t)e + k]] = 1;
  s->holds = 0;
  for (int32_t e = 0; e < mesh->boundary; e++) {
    const int32_t before = is_open(s, mesh->last[e]) ? -1 : mesh->last[e];
    const int32_t after = is_open(s, e) ? -1 : e;
    if (before < 0 && after < 0) continue;
    flip_hold *hold = &s->hold[when][s->holds++];
    hold->node = mesh->ends[2 * (int64_t)e];
    hold_node(s, h, before, after, hold);
  }
  s->shortest = HUGE_VAL;
  for (int32_t c = 0; c < mesh->cells; c++)
    s->shortest = fmin(s->shortest, sqrt(2 * mesh->area[c]));
  for (int32_t a = 0; a < mesh->nodes; a++) {
    double area = 0;
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++)
      area += mesh->area[mesh->touch[t] / 3];
    s->mass[a] = area / 3;
  }
}

/* ---- (3) ---- */

/* The weak divergence of velocities u at node a: sum_K A_K grad N_a . u_K, without walls. */
static double divergence_at(const sph_mesh *mesh, double *const *u, int32_t a) {
  double sum = 0;
  for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++) {
    const int32_t c = mesh->touch[t] / 3;
    const double *g = mesh->gradient + 2 * (int64_t)mesh->touch[t];
    sum += mesh->area[c] * (g[0] * u[0][c] + g[1] * u[1][c]);
  }
  return sum;
}

static void make_rows(const sph_integrator *flow) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->nodes > PARALLEL_FROM)
  for (int32_t a = 0; a < mesh->nodes; a++) {
    const int64_t first = s->row_start[a], end = s->row_start[a + 1];
    for (int64_t k = first; k < end; k++) s->values[k] = 0;
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++) {
      const int32_t c = mesh->touch[t] / 3;
      const double *all = mesh->gradient + 6 * (int64_t)c;
      const double *g = mesh->gradient + 2 * (int64_t)mesh->touch[t];
      const double weight = mesh->area[c] / s->rho[c];
      for (int l = 0; l < 3; l++)
        s->values[first + s->slot[3 * t + l]] +=
            weight * (g[0] * all[2 * l] + g[1] * all[2 * l + 1]);
    }
    for (int64_t k = first; k < end; k++)
      if (s->columns[k] != a && (s->held[a] || s->held[s->columns[k]])) s->values[k] = 0;
  }
}

/* What divergence brings volumes of particles around nodes back to the areas there: theta sqrt(|g|/l) times
 * what they are too much, or too little. */
static void make_source(const sph_integrator *flow) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  const double rate = s->theta * sqrt(hypot(s->gravity[0], s->gravity[1]) / s->shortest);
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->nodes > PARALLEL_FROM)
  for (int32_t a = 0; a < mesh->nodes; a++) {
    double volume = 0;
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++)
      volume += s->volume[mesh->touch[t]];
    const double surplus = volume / s->mass[a] - 1;
    s->source[a] = s->mass[a] * rate * (surplus > MOST_SURPLUS ? MOST_SURPLUS : surplus);
  }
}

/* The right-hand side times dt, for velocities u. */
static void make_right(const sph_integrator *flow, double *const *u) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->nodes > PARALLEL_FROM)
  for (int32_t a = 0; a < mesh->nodes; a++) s->right[a] = divergence_at(mesh, u, a) + s->source[a];
  for (int32_t e = 0; e < mesh->boundary; e++) {
    double n[2];
    if (s->normal_velocity[1][e] == 0) continue;
    outward(mesh, e, n);
    for (int k = 0; k < 2; k++)
      s->right[mesh->ends[2 * (int64_t)e + k]] -=
          0.5 * s->normal_velocity[1][e] * hypot(n[0], n[1]);
  }
  for (int32_t a = 0; a < mesh->nodes; a++)
    if (s->held[a]) s->right[a] = 0;
}

static double largest_divergence(const sph_integrator *flow, double *const *u) {
  const flip *s = flip_of(flow);
  double most = 0;
  make_right(flow, u);
  for (int32_t a = 0; a < s->mesh->nodes; a++) most = fmax(most, fabs(s->right[a]) / s->mass[a]);
  return most;
}

/* A closed mesh keeps its area. */
static sph_status check_closed(const sph_integrator *flow) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  double flux = 0, sizes = 0;
  for (int32_t e = 0; e < mesh->boundary; e++) {
    double n[2];
    outward(mesh, e, n);
    if (is_open(s, e)) return SPH_OK;
    flux += s->normal_velocity[1][e] * hypot(n[0], n[1]);
    sizes += fabs(s->normal_velocity[1][e]) * hypot(n[0], n[1]);
  }
  SPH_CHECK(flow->context, fabs(flux) <= 1e-9 * sizes, SPH_E_ARGUMENT,
            "flip: the mesh has no open boundary, so that its paddle cannot move; call "
            "sph_flip_set_open");
  return SPH_OK;
}

static sph_status solve(sph_integrator *flow, double dt) {
  flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  bool open = false;
  for (int32_t a = 0; a < mesh->nodes && !open; a++) open = s->held[a];
  SPH_TRY(check_closed(flow));
  SPH_TRY(sph_solver_set_null_space(s->solver, !open));
  make_rows(flow);
  make_source(flow);
  make_right(flow, s->star);
  for (int32_t a = 0; a < mesh->nodes; a++) {
    s->right[a] /= dt;
    if (s->held[a]) s->pressure[a] = 0;
  }
  const sph_matrix matrix = {
      .n = mesh->nodes, .row_start = s->row_start, .columns = s->columns, .values = s->values};
  return sph_solver_solve(s->solver, &matrix, s->right, s->pressure);
}

sph_status sphi_flip_project(sph_integrator *flow, double dt) {
  flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  const double begin = sphi_seconds();
  SPH_TRY(solve(flow, dt));
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->cells > PARALLEL_FROM)
  for (int32_t c = 0; c < mesh->cells; c++) {
    double slope[2] = {0};
    for (int k = 0; k < 3; k++)
      for (int d = 0; d < 2; d++)
        slope[d] += s->pressure[mesh->corner[3 * (int64_t)c + k]] *
                    mesh->gradient[6 * (int64_t)c + 2 * k + d];
    for (int d = 0; d < 2; d++) s->next[d][c] = s->star[d][c] - dt * slope[d] / s->rho[c];
  }
  s->stats.divergence = s->stats.divergence_left = largest_divergence(flow, s->next);
  if (s->smoothing != SPH_FLIP_SMOOTHING_NONE) {
    SPH_TRY(sphi_flip_push(flow, dt));
    s->stats.divergence = largest_divergence(flow, s->next);
  }
  flow->stats.evaluations++;
  flow->stats.seconds_solver += sphi_seconds() - begin;
  return SPH_OK;
}
