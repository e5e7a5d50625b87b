/* The handle of the hybrid particle-mesh method: creation, settings, a step. */
#include <inttypes.h>

#include "flip/flip_impl.h"

static const sphi_method method;

sph_status sphi_flip_check(const sph_integrator *flow) {
  return sphi_integrator_check_method(flow, &method);
}

#define SETTER(flow)                      \
  SPH_TRY(sphi_flip_check(flow));         \
  sph_context *context = (flow)->context; \
  flip *s = flip_of(flow)

/* Time steps over sqrt(l / |g|): the surface is moved with the new velocity, which is stable up to 2/sqrt(pi)
 * for waves of two l; heights are sound up to a tenth of that. */
static const double FALL = 0.12;

/* PIC's share of the velocity in the time sqrt(l / |g|), docs/flip.md, and in a step without gravity. */
static const double DAMPING = 1, SHARE = 0.02;

static void destroy(sph_integrator *flow) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  void *const arrays[] = {s->cell,
                          s->order,
                          s->left,
                          s->start,
                          s->rho,
                          s->u[0],
                          s->u[1],
                          s->star[0],
                          s->star[1],
                          s->next[0],
                          s->next[1],
                          s->mixed,
                          s->smooth,
                          s->filled,
                          s->record,
                          s->stress[0],
                          s->stress[1],
                          s->stress[2],
                          s->pressure,
                          s->right,
                          s->push[0],
                          s->push[1],
                          s->mass,
                          s->velocity[0],
                          s->velocity[1],
                          s->before[0],
                          s->before[1],
                          s->after[0],
                          s->after[1],
                          s->held,
                          s->near,
                          s->normal_velocity[0],
                          s->normal_velocity[1],
                          s->hold[0],
                          s->hold[1],
                          s->row_start,
                          s->columns,
                          s->slot,
                          s->values,
                          s->mass_values,
                          s->fresh,
                          s->now_rho,
                          s->now_count,
                          s->volume,
                          s->spread,
                          s->weight,
                          s->partner,
                          s->source};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) sphi_free(context, arrays[k]);
  sph_solver_destroy(&s->solver);
  sph_solver_destroy(&s->mass_solver);
  sph_mesh_destroy(&s->mesh);
  sphi_free(context, s);
  flow->data = NULL;
}

static sph_status make_arrays(sph_integrator *flow) {
  flip *s = flip_of(flow);
  sph_context *context = flow->context;
  const int64_t nodes = s->mesh->nodes, cells = s->mesh->cells, boundary = s->mesh->boundary;
  double **const of_cells[] = {&s->now_rho, &s->now_count, &s->spread, &s->weight,
                               &s->rho,     &s->u[0],      &s->u[1],   &s->star[0],
                               &s->star[1], &s->next[0],   &s->next[1]};
  double **const at_nodes[] = {&s->stress[0], &s->stress[1],   &s->stress[2],  &s->pressure,
                               &s->source,    &s->right,       &s->push[0],    &s->push[1],
                               &s->mass,      &s->before[0],   &s->before[1],  &s->after[0],
                               &s->after[1],  &s->velocity[0], &s->velocity[1]};
  uint8_t **const flags[] = {&s->mixed, &s->smooth, &s->filled, &s->held, &s->near};
  bool ok = true;
  for (size_t k = 0; k < sizeof of_cells / sizeof of_cells[0]; k++)
    ok = ok && (*of_cells[k] = SPHI_NEW(context, cells, double));
  for (size_t k = 0; k < sizeof at_nodes / sizeof at_nodes[0]; k++)
    ok = ok && (*at_nodes[k] = SPHI_NEW(context, nodes, double));
  for (size_t k = 0; k < sizeof flags / sizeof flags[0]; k++)
    ok = ok && (*flags[k] = SPHI_NEW(context, k < 3 ? cells : nodes, uint8_t));
  for (int k = 0; k < 2; k++) {
    ok = ok && (s->normal_velocity[k] = SPHI_NEW(context, boundary, double));
    ok = ok && (s->hold[k] = SPHI_NEW(context, boundary, flip_hold));
  }
  ok = ok && (s->volume = SPHI_NEW(context, 3 * cells, double));
  ok = ok && (s->partner = SPHI_NEW(context, cells, int32_t));
  ok = ok && (s->start = SPHI_NEW(context, cells + 1, int64_t));
  ok = ok && (s->record = SPHI_NEW(context, cells, flip_record));
  SPH_CHECK(context, ok, SPH_E_MEMORY, "flip: no memory for %" PRId64 " cells", cells);
  sphi_flip_pair_cells(s);
  return sphi_flip_make_matrix(flow);
}

/* Cells are a field, so that they are sorted with the particles and callers can read them. */
static sph_status cell_field(sph_particles *particles, int *number) {
  static const char *const name = "cell";
  for (int k = 0; k < particles->fields; k++) {
    if (strcmp(particles->field[k].name, name) != 0) continue;
    SPH_CHECK(particles->context, particles->field[k].components == 1, SPH_E_ARGUMENT,
              "particles \"%s\": field \"cell\" must have 1 component, it has %d", particles->name,
              particles->field[k].components);
    *number = k;
    return SPH_OK;
  }
  *number = particles->fields;
  return sph_particles_add_field(particles, name, 1, "1");
}

static sph_status set_up(sph_integrator *flow, sph_mesh *mesh) {
  flip *s = flip_of(flow);
  sphi_mesh_retain(mesh);
  s->mesh = mesh;
  s->gravity[1] = -9.81;
  s->density[0] = 1;
  s->density[1] = 1000;
  s->alpha = -1;
  s->theta = 0.05;
  s->mass_weighted = s->spreads = true;
  s->smoothing = SPH_FLIP_SMOOTHING_INTERFACE;
  s->lumped = true;
  s->fewest = 4;
  s->most = 50;
  s->revision = s->now_revision = -1;
  for (int k = 0; k < mesh->tags; k++)
    if (strcmp(mesh->name[k], "top") == 0) s->open = k + 1;
  SPH_TRY(cell_field(flow->particles, &s->field));
  SPH_TRY(sph_solver_create(flow->context, SPH_SOLVER_GMRES, &s->solver));
  SPH_TRY(sph_solver_set_tolerance(s->solver, 1e-8, 0));
  SPH_TRY(make_arrays(flow));
  sphi_flip_measure(flow, 1);
  return SPH_OK;
}

sph_status sph_flip_create(sph_context *context, sph_mesh *mesh, sph_particles *particles,
                           sph_integrator **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, mesh && particles && out, SPH_E_ARGUMENT, "flip: %s is NULL",
            !mesh        ? "mesh"
            : !particles ? "particles"
                         : "out");
  SPH_CHECK(context, mesh->context == context && particles->context == context, SPH_E_ARGUMENT,
            "flip: the %s of another context",
            mesh->context == context ? "particles are" : "mesh is");
  SPH_CHECK(context, particles->dim == 2, SPH_E_ARGUMENT,
            "flip: particles \"%s\" must be 2D, they are %dD", particles->name, particles->dim);
  SPH_CHECK(context, particles->n > 0, SPH_E_ARGUMENT,
            "flip: particles \"%s\" are none; call sph_flip_fill first", particles->name);
  sph_kernel *kernel; /* measures ask for the support of one */
  SPH_TRY(sph_kernel_create(context, SPH_KERNEL_WENDLAND_C2, 2, 1.5 * particles->spacing, &kernel));
  sph_status status = sphi_integrator_create(context, &method, particles, kernel, out);
  sph_kernel_destroy(&kernel);
  SPH_TRY(status);
  (*out)->data = SPHI_NEW(context, 1, flip);
  if ((*out)->data)
    status = set_up(*out, mesh);
  else
    status = SPHI_ERROR(context, SPH_E_MEMORY, "flip: no memory");
  if (status != SPH_OK) sph_integrator_destroy(out);
  return status;
}

/* ---- settings ---- */

sph_status sph_flip_set_gravity(sph_integrator *integrator, const double *gravity) {
  SETTER(integrator);
  SPH_CHECK(context, gravity && sphi_finite(2, gravity), SPH_E_ARGUMENT,
            "flip: gravity must be given and finite");
  memcpy(s->gravity, gravity, sizeof s->gravity);
  return SPH_OK;
}

sph_status sph_flip_set_densities(sph_integrator *integrator, double light, double heavy) {
  SETTER(integrator);
  SPH_CHECK(context, isfinite(heavy) && light > 0 && light <= heavy, SPH_E_ARGUMENT,
            "flip: densities must be 0 < light <= heavy kg/m^3, got %g and %g", light, heavy);
  s->density[0] = light;
  s->density[1] = heavy;
  s->revision = -1;
  return SPH_OK;
}

sph_status sph_flip_set_viscosities(sph_integrator *integrator, double light, double heavy) {
  SETTER(integrator);
  SPH_CHECK(context, isfinite(light) && isfinite(heavy) && light >= 0 && heavy >= 0, SPH_E_ARGUMENT,
            "flip: viscosities must be >= 0 Pa s, got %g and %g", light, heavy);
  s->viscosity[0] = light;
  s->viscosity[1] = heavy;
  return SPH_OK;
}

sph_status sph_flip_set_no_slip(sph_integrator *integrator, bool no_slip) {
  SPH_TRY(sphi_flip_check(integrator));
  flip_of(integrator)->no_slip = no_slip;
  return SPH_OK;
}

sph_status sph_flip_set_pic_share(sph_integrator *integrator, double alpha) {
  SETTER(integrator);
  SPH_CHECK(context, alpha <= 1, SPH_E_ARGUMENT,
            "flip: the share of PIC must be 0 to 1, or < 0 for the default, got %g", alpha);
  s->alpha = alpha;
  return SPH_OK;
}

sph_status sph_flip_set_volume_correction(sph_integrator *integrator, double theta) {
  SETTER(integrator);
  SPH_CHECK(context, theta >= 0 && theta <= 1, SPH_E_ARGUMENT,
            "flip: the volume's correction must be 0 to 1, got %g", theta);
  s->theta = theta;
  return SPH_OK;
}

sph_status sph_flip_set_smoothing(sph_integrator *integrator, sph_flip_smoothing where,
                                  bool lumped) {
  SETTER(integrator);
  SPH_CHECK(context, where >= SPH_FLIP_SMOOTHING_NONE && where <= SPH_FLIP_SMOOTHING_GLOBAL,
            SPH_E_ARGUMENT, "flip: smoothing must be one of sph_flip_smoothing, got %d",
            (int)where);
  s->smoothing = where;
  s->lumped = lumped;
  return SPH_OK;
}

sph_status sph_flip_set_mass_weighted(sph_integrator *integrator, bool weighted) {
  SPH_TRY(sphi_flip_check(integrator));
  flip_of(integrator)->mass_weighted = weighted;
  return SPH_OK;
}

sph_status sph_flip_set_spread_density(sph_integrator *integrator, bool spread) {
  SPH_TRY(sphi_flip_check(integrator));
  flip_of(integrator)->spreads = spread;
  return SPH_OK;
}

sph_status sph_flip_set_open(sph_integrator *integrator, const char *tag) {
  SPH_TRY(sphi_flip_check(integrator));
  flip *s = flip_of(integrator);
  int number = 0;
  if (tag) SPH_TRY(sph_mesh_find_tag(s->mesh, tag, &number));
  s->open = number;
  sphi_flip_measure(integrator, 1);
  return SPH_OK;
}

sph_status sph_flip_set_paddle(sph_integrator *integrator, sph_wall_motion motion, void *user,
                               double reach) {
  SPH_TRY(sphi_flip_check(integrator));
  flip *s = flip_of(integrator);
  SPH_TRY(sph_mesh_set_paddle(s->mesh, motion, user, reach));
  s->revision = -1;
  return sph_mesh_move(s->mesh, integrator->stats.time);
}

sph_status sph_flip_set_reseeding(sph_integrator *integrator, int fewest, int most) {
  SETTER(integrator);
  SPH_CHECK(
      context, fewest >= 0 && fewest <= 100 && (most == 0 || most >= 2 * fewest) && most >= 0,
      SPH_E_ARGUMENT,
      "flip: particles of cells must be 0 to 100 at least and 0 or twice as many at most, got "
      "%d and %d",
      fewest, most);
  s->fewest = fewest;
  s->most = most;
  return SPH_OK;
}

/* ---- readers ---- */

sph_status sph_flip_get_solver(const sph_integrator *integrator, sph_solver **solver) {
  SETTER(integrator);
  SPH_CHECK(context, solver, SPH_E_ARGUMENT, "flip: solver is NULL");
  *solver = s->solver;
  return SPH_OK;
}

sph_status sph_flip_get_stats(const sph_integrator *integrator, sph_flip_stats *stats) {
  SETTER(integrator);
  SPH_CHECK(context, stats, SPH_E_ARGUMENT, "flip: stats is NULL");
  *stats = s->stats;
  return SPH_OK;
}

sph_status sph_flip_read_pressure(const sph_integrator *integrator, double *pressure,
                                  int64_t size) {
  SETTER(integrator);
  SPH_CHECK(context, pressure, SPH_E_ARGUMENT, "flip: pressure is NULL");
  SPH_CHECK(context, size == s->mesh->nodes, SPH_E_ARGUMENT,
            "flip: size of pressure must be %d, got %" PRId64, s->mesh->nodes, size);
  memcpy(pressure, s->pressure, (size_t)size * sizeof *pressure);
  return SPH_OK;
}

sph_status sph_flip_read_cells(const sph_integrator *integrator, double *density, double *velocity,
                               int64_t size) {
  SETTER(integrator);
  SPH_CHECK(context, size == s->mesh->cells, SPH_E_ARGUMENT,
            "flip: size must be the number of cells, %d, got %" PRId64, s->mesh->cells, size);
  if (density) memcpy(density, s->rho, (size_t)size * sizeof *density);
  for (int64_t c = 0; velocity && c < size; c++)
    for (int d = 0; d < 2; d++) velocity[2 * c + d] = s->next[d][c];
  return SPH_OK;
}

/* ---- steps ---- */

/* Places of particles that the caller gave or changed. */
sph_status sphi_flip_refresh(sph_integrator *flow) {
  flip *s = flip_of(flow);
  const sph_particles *particles = flow->particles;
  if (s->revision == particles->revision && s->mesh_moves == s->mesh->revision) return SPH_OK;
  SPH_TRY(sphi_flip_locate(flow, false));
  sphi_flip_measure(flow, 1);
  double speed2 = 0;
  double **v = flip_field(flow, SPHI_V);
  for (int32_t i = 0; i < particles->n; i++)
    speed2 = fmax(speed2, v[0][i] * v[0][i] + v[1][i] * v[1][i]);
  s->rate = sqrt(speed2) / s->shortest;
  if (s->usual == 0) s->usual = fmax(1, (double)particles->n / s->mesh->cells);
  s->revision = particles->revision;
  s->mesh_moves = s->mesh->revision;
  return SPH_OK;
}

static double limit(const sph_integrator *flow, sph_limiter *limiter) {
  const flip *s = flip_of(flow);
  const double paddle = fabs(s->mesh->motion ? s->mesh->velocity : 0) / s->shortest;
  const double push = hypot(s->gravity[0], s->gravity[1]), l2 = s->shortest * s->shortest;
  const double rate = fmax(s->rate, paddle);
  double dt = rate > 0 ? sphi_integrator_courant(flow) / rate : HUGE_VAL;
  *limiter = SPH_LIMITER_VELOCITY;
  if (push > 0 && FALL * sqrt(s->shortest / push) < dt) {
    dt = FALL * sqrt(s->shortest / push);
    *limiter = SPH_LIMITER_ACCELERATION;
  }
  for (int k = 0; k < 2; k++) {
    const double most = s->viscosity[k] > 0 ? s->density[k] * l2 / (8 * s->viscosity[k]) : dt;
    if (most >= dt) continue;
    dt = most;
    *limiter = SPH_LIMITER_VISCOSITY;
  }
  return isfinite(dt) ? dt : 0;
}

/* Everything of a step that leaves particles as they are, but for those that cells lack or have too many
 * of. */
static sph_status prepare(sph_integrator *flow, double dt) {
  flip *s = flip_of(flow);
  sphi_flip_measure(flow, 0);
  if (s->mesh->motion) {
    const double begin = sphi_seconds();
    SPH_TRY(sph_mesh_move(s->mesh, flow->stats.time + dt));
    flow->stats.seconds_search += sphi_seconds() - begin;
    SPH_TRY(sphi_flip_locate(flow, true));
    s->mesh_moves = s->mesh->revision;
  }
  sphi_flip_measure(flow, 1);
  SPH_TRY(sphi_flip_sort(flow));
  SPH_TRY(sphi_flip_reseed(flow));
  sphi_flip_gather(flow);
  sphi_flip_predict(flow, dt);
  return sphi_flip_project(flow, dt);
}

static sph_status step(sph_integrator *flow, double dt) {
  flip *s = flip_of(flow);
  const sph_particles *particles = flow->particles;
  SPH_CHECK(flow->context, particles->leases->count == 0, SPH_E_ARGUMENT,
            "flip: %" PRId64
            " leases of particles \"%s\" are open, so that none can come or go; "
            "call sph_particles_release first",
            particles->leases->count, particles->name);
  const double push = hypot(s->gravity[0], s->gravity[1]);
  s->share = s->alpha >= 0 ? s->alpha : push > 0 ? DAMPING * dt * sqrt(push / s->shortest) : SHARE;
  s->share = fmin(s->share, 1);
  const sph_status status = prepare(flow, dt);
  if (status != SPH_OK) { /* the mesh goes back to where the particles are */
    s->revision = -1;
    if (s->mesh->motion) SPH_TRY(sph_mesh_move(s->mesh, flow->stats.time));
    return status;
  }
  sphi_flip_reconstruct(flow);
  return sphi_flip_advance(flow, dt);
}

/* |u| dt / l, with which a particle stays within the neighbours of its cell. */
static double stable_courant(const sph_integrator *flow, sph_stepper stepper) {
  (void)flow, (void)stepper;
  return 1;
}

/* Sound has no say, and how fast the flow will be is not known. */
static double stable_dt(const sph_integrator *flow, double courant) {
  (void)flow, (void)courant;
  return 0;
}

static const sphi_method method = {
    .name = "flip",
    .refresh = sphi_flip_refresh,
    .limit = limit,
    .step = step,
    .courant = 0.5,
    .stable_courant = stable_courant,
    .stable_dt = stable_dt,
    .destroy = destroy,
    .energy = sph_flip_get_energy,
    .evaluate = sphi_flip_evaluate,
    .keep = sphi_flip_keep,
};
