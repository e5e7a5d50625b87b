/* What makes discontinuous things continuous: grad p / rho near the interface, stresses at nodes. */
#include "flip/flip_impl.h"

enum { PARALLEL_FROM = 2048 };

/* Weights of cells in r are their areas times this power of their density. With areas alone waves are 2 % too fast,
 * since cells with little water accelerate too much; with masses they stick to rows of the mesh. */
static const double DENSER = 0.3;

/* Weights of cells in means at nodes. */
static void weigh_cells(const sph_integrator *flow) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  const bool denser = s->spreads && s->lumped;
  const double light = pow(s->density[0] / s->density[1], DENSER);
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->cells > PARALLEL_FROM)
  for (int32_t c = 0; c < mesh->cells; c++) {
    double factor = 1;
    if (denser && s->rho[c] == s->density[0])
      factor = light;
    else if (denser && s->rho[c] != s->density[1])
      factor = pow(s->rho[c] / s->density[1], DENSER);
    s->weight[c] = mesh->area[c] * factor;
  }
}

/* grad p / rho at nodes: means of what acted, (u* - u^(n+1))/dt. */
static void lump(const sph_integrator *flow, double dt) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->nodes > PARALLEL_FROM)
  for (int32_t a = 0; a < mesh->nodes; a++) {
    double sum[2] = {0}, all = 0;
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++) {
      const int32_t c = mesh->touch[t] / 3;
      all += s->weight[c];
      for (int d = 0; d < 2; d++) sum[d] += s->weight[c] * ((s->star[d][c] - s->next[d][c]) / dt);
    }
    for (int d = 0; d < 2; d++) s->push[d][a] = sum[d] / all;
  }
}

/* The same with the consistent mass matrix, from the lumped result. */
static sph_status solve_mass(sph_integrator *flow) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  const sph_mesh *mesh = s->mesh;
  if (!s->mass_solver) {
    SPH_TRY(sph_solver_create(context, SPH_SOLVER_CG, &s->mass_solver));
    SPH_TRY(sph_solver_set_preconditioner(s->mass_solver, SPH_PRECONDITIONER_JACOBI));
    SPH_TRY(sph_solver_set_tolerance(s->mass_solver, 1e-12, 0));
  }
  if (!s->mass_values) {
    s->mass_values = SPHI_NEW(context, s->row_start[mesh->nodes], double);
    SPH_CHECK(context, s->mass_values, SPH_E_MEMORY, "flip: no memory for the mass matrix");
  }
  for (int32_t a = 0; a < mesh->nodes; a++) {
    double *row = s->mass_values + s->row_start[a];
    memset(row, 0, (size_t)(s->row_start[a + 1] - s->row_start[a]) * sizeof *row);
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++)
      for (int l = 0; l < 3; l++)
        row[s->slot[3 * t + l]] +=
            mesh->area[mesh->touch[t] / 3] / (l == mesh->touch[t] % 3 ? 6 : 12);
  }
  const sph_matrix matrix = {
      .n = mesh->nodes, .row_start = s->row_start, .columns = s->columns, .values = s->mass_values};
  for (int d = 0; d < 2; d++) {
    for (int32_t a = 0; a < mesh->nodes; a++) s->right[a] = s->mass[a] * s->push[d][a];
    SPH_TRY(sph_solver_solve(s->mass_solver, &matrix, s->right, s->push[d]));
  }
  return SPH_OK;
}

sph_status sphi_flip_push(sph_integrator *flow, double dt) {
  flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  const bool everywhere = s->smoothing == SPH_FLIP_SMOOTHING_GLOBAL;
  if (!everywhere && s->stats.mixed_cells == 0) return SPH_OK;
  weigh_cells(flow);
  lump(flow, dt);
  if (!s->lumped) SPH_TRY(solve_mass(flow));
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->cells > PARALLEL_FROM)
  for (int32_t c = 0; c < mesh->cells; c++) {
    if (!everywhere && !s->smooth[c]) continue;
    const int32_t *corner = mesh->corner + 3 * (int64_t)c;
    for (int d = 0; d < 2; d++)
      s->next[d][c] =
          s->star[d][c] -
          dt * (s->push[d][corner[0]] + s->push[d][corner[1]] + s->push[d][corner[2]]) / 3;
  }
  return SPH_OK;
}

/* ---- viscosity ---- */

static double viscosity_of(const flip *s, double rho) {
  const double share =
      s->density[1] > s->density[0] ? (rho - s->density[0]) / (s->density[1] - s->density[0]) : 1;
  const double clamped = share < 0 ? 0 : share > 1 ? 1 : share;
  return s->viscosity[0] + clamped * (s->viscosity[1] - s->viscosity[0]);
}

/* The velocity at an edge of the boundary as its cell's flow sees it: the wall's, where that slips its
 * normal part alone, and nothing on the open one. */
static void wall_velocity(const sph_integrator *flow, int32_t edge, const double *n, double *u) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  const int32_t c = mesh->side[2 * (int64_t)edge];
  for (int d = 0; d < 2; d++) u[d] = s->u[d][c];
  if (s->open && mesh->tag[edge] == s->open) return;
  const double h = s->normal_velocity[0][edge];
  const double through = s->no_slip ? 0 : u[0] * n[0] + u[1] * n[1] - h;
  for (int d = 0; d < 2; d++) u[d] = s->no_slip ? h * n[d] : u[d] - through * n[d];
}

/* sigma at nodes: sum_K -mu_K A_K (u_i d_j N_a + u_j d_i N_a) + edges mu |e|/2 (u_i n_j + u_j n_i), over the
 * lumped mass. */
static void make_stress(const sph_integrator *flow) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->nodes > PARALLEL_FROM)
  for (int32_t a = 0; a < mesh->nodes; a++) {
    double sum[3] = {0};
    for (int64_t t = mesh->touch_start[a]; t < mesh->touch_start[a + 1]; t++) {
      const int32_t c = mesh->touch[t] / 3;
      const double *g = mesh->gradient + 2 * (int64_t)mesh->touch[t];
      const double weight = viscosity_of(s, s->rho[c]) * mesh->area[c];
      sum[0] -= weight * 2 * s->u[0][c] * g[0];
      sum[1] -= weight * 2 * s->u[1][c] * g[1];
      sum[2] -= weight * (s->u[0][c] * g[1] + s->u[1][c] * g[0]);
    }
    for (int k = 0; k < 3; k++) s->stress[k][a] = sum[k];
  }
  for (int32_t e = 0; e < mesh->boundary; e++) {
    const int32_t *ends = mesh->ends + 2 * (int64_t)e;
    const double *p = mesh->x + 2 * (int64_t)ends[0], *q = mesh->x + 2 * (int64_t)ends[1];
    const double length = hypot(q[0] - p[0], q[1] - p[1]);
    const double n[2] = {(q[1] - p[1]) / length, (p[0] - q[0]) / length};
    const double weight = 0.5 * length * viscosity_of(s, s->rho[mesh->side[2 * (int64_t)e]]);
    double u[2];
    wall_velocity(flow, e, n, u);
    for (int k = 0; k < 2; k++) {
      s->stress[0][ends[k]] += weight * 2 * u[0] * n[0];
      s->stress[1][ends[k]] += weight * 2 * u[1] * n[1];
      s->stress[2][ends[k]] += weight * (u[0] * n[1] + u[1] * n[0]);
    }
  }
  for (int k = 0; k < 3; k++)
    for (int32_t a = 0; a < mesh->nodes; a++) s->stress[k][a] /= s->mass[a];
}

static void add_viscosity(const sph_integrator *flow, double dt) {
  const flip *s = flip_of(flow);
  const sph_mesh *mesh = s->mesh;
  make_stress(flow);
#pragma omp parallel for num_threads(flow->context->threads) \
    schedule(static) if (mesh->cells > PARALLEL_FROM)
  for (int32_t c = 0; c < mesh->cells; c++) {
    double force[2] = {0};
    for (int k = 0; k < 3; k++) {
      const int32_t a = mesh->corner[3 * (int64_t)c + k];
      const double *g = mesh->gradient + 6 * (int64_t)c + 2 * k;
      force[0] += s->stress[0][a] * g[0] + s->stress[2][a] * g[1];
      force[1] += s->stress[2][a] * g[0] + s->stress[1][a] * g[1];
    }
    for (int d = 0; d < 2; d++) s->star[d][c] += dt * force[d] / s->rho[c];
  }
}

void sphi_flip_predict(sph_integrator *flow, double dt) {
  const flip *s = flip_of(flow);
  for (int d = 0; d < 2; d++)
    for (int32_t c = 0; c < s->mesh->cells; c++) s->star[d][c] = s->u[d][c] + dt * s->gravity[d];
  if (s->viscosity[0] > 0 || s->viscosity[1] > 0) add_viscosity(flow, dt);
}
