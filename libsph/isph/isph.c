/* The handle of incompressible SPH: settings, energies. */
#include "isph/isph_impl.h"

static const sphi_method method;

#define SETTER(flow)                                      \
  SPH_TRY(sphi_integrator_check_method((flow), &method)); \
  sph_context *context = (flow)->context;                 \
  isph *s = isph_of(flow)

static void destroy(sph_integrator *flow) {
  isph *s = isph_of(flow);
  sph_context *context = flow->context;
  for (int k = 0; k < ISPH_ARRAYS; k++) sphi_free(context, s->array[k]);
  for (int d = 0; d < SPHI_MAX_DIM; d++) sphi_free(context, s->between[d]);
  for (int k = 0; k < 2; k++) {
    sphi_free(context, s->place[k]);
    sphi_free(context, s->entry[k]);
  }
  sphi_ghost_rows_free(context, &s->rows);
  sphi_isph_dummies_free(context, &s->dummies);
  sphi_free(context, s->open);
  sphi_free(context, s->row_start);
  sphi_free(context, s->columns);
  sphi_free(context, s->values);
  sphi_free(context, s->right);
  sphi_free(context, s->mark);
  sph_solver_destroy(&s->solver);
  sphi_free(context, s);
  flow->data = NULL;
}

/* Sums over the lattice of particles around one of them: of V W, also at its surface, and of a row's entries. */
static void sum_lattice(const sph_kernel *kernel, double spacing, isph *s) {
  const int most = (int)ceil(kernel->support / spacing), dim = kernel->dim;
  const double volume = pow(spacing, dim);
  s->filled = s->surface_filling = volume * sph_kernel_w(kernel, 0);
  s->full = 0;
  for (int i = -most; i <= most; i++)
    for (int j = -most; j <= most; j++)
      for (int k = dim == 3 ? -most : 0; k <= (dim == 3 ? most : 0); k++) {
        const double r = spacing * sqrt((double)(i * i + j * j + k * k));
        if (r == 0) continue;
        s->filled += volume * sph_kernel_w(kernel, r);
        s->surface_filling += i <= 0 ? volume * sph_kernel_w(kernel, r) : 0;
        s->full -= 2 * volume * sph_kernel_dw(kernel, r) / r;
      }
}

/* The kernel's integral over the plane at a distance: over a line in 2D. */
static double over_plane(const sph_kernel *kernel, double distance) {
  enum { STEPS = 200 };
  const double pi = 3.14159265358979323846, step = kernel->support / STEPS;
  double sum = 0;
  for (int k = 0; k < STEPS; k++) {
    const double r = (k + 0.5) * step, w = sph_kernel_w(kernel, hypot(r, distance));
    sum += step * (kernel->dim == 2 ? 2 : 2 * pi * r) * w;
  }
  return sum;
}

/* What the filling says about the depth below a surface; that of the lattice's surface is half a spacing. */
static void tabulate_depths(const sph_kernel *kernel, double spacing, isph *s) {
  enum { PARTS = 8 };
  const double cell = kernel->support / (ISPH_DEPTHS - 1), step = cell / PARTS;
  s->above[0] = 0;
  for (int k = 1; k < ISPH_DEPTHS; k++) {
    s->above[k] = s->above[k - 1];
    for (int part = 0; part < PARTS; part++)
      s->above[k] += step * over_plane(kernel, ((k - 1) * PARTS + part + 0.5) * step);
  }
  const int at = (int)fmin(0.5 * spacing / cell, ISPH_DEPTHS - 2);
  const double there =
      s->above[at] + (s->above[at + 1] - s->above[at]) * (0.5 * spacing / cell - at);
  for (int k = 0; k < ISPH_DEPTHS; k++) s->above[k] -= there;
}

static sph_status create_solver(sph_context *context, sph_solver_kind kind, sph_solver **out) {
  SPH_TRY(sph_solver_create(context, kind, out));
  SPH_TRY(sph_solver_set_tolerance(*out, 1e-6, 0));
  return sph_solver_set_reuse(*out, 3);
}

sph_status sph_isph_create(sph_context *context, sph_kernel *kernel, sph_particles *particles,
                           sph_boundary *boundary, sph_integrator **out) {
  SPH_TRY(sphi_cloud_create(context, &method, kernel, particles, boundary, out));
  isph *s = SPHI_NEW(context, 1, isph);
  if (!s) {
    sph_integrator_destroy(out);
    return SPHI_ERROR(context, SPH_E_MEMORY, "isph: no memory");
  }
  (*out)->data = s;
  const sph_status status = create_solver(context, SPH_SOLVER_GMRES, &s->solver);
  if (status != SPH_OK) {
    sph_integrator_destroy(out);
    return status;
  }
  sum_lattice(kernel, particles->spacing, s);
  tabulate_depths(kernel, particles->spacing, s);
  s->threshold = particles->dim == 2 ? 1.75 : 2.7;
  s->gradient = SPH_ISPH_GRADIENT_CORRECTED;
  s->laplacian = SPH_ISPH_LAPLACIAN_CORRECTED;
  s->walls = SPH_ISPH_WALLS_GHOSTS;
  s->theta = 0.02;
  s->shifting = 0.5;
  s->collisions = 1;
  return SPH_OK;
}

sph_status sph_isph_set_laminar_viscosity(sph_integrator *integrator, double nu) {
  SETTER(integrator);
  SPH_CHECK(context, isfinite(nu) && nu >= 0, SPH_E_ARGUMENT,
            "isph: viscosity must be >= 0 m^2/s, got %g", nu);
  s->nu = nu;
  return SPH_OK;
}

sph_status sph_isph_set_gradient(sph_integrator *integrator, sph_isph_gradient kind) {
  SETTER(integrator);
  SPH_CHECK(context, kind == SPH_ISPH_GRADIENT_CORRECTED || kind == SPH_ISPH_GRADIENT_CONSERVATIVE,
            SPH_E_ARGUMENT, "isph: gradient must be one of sph_isph_gradient, got %d", (int)kind);
  s->gradient = kind;
  return SPH_OK;
}

sph_status sph_isph_set_laplacian(sph_integrator *integrator, sph_isph_laplacian kind) {
  SETTER(integrator);
  SPH_CHECK(context, kind == SPH_ISPH_LAPLACIAN_CORRECTED || kind == SPH_ISPH_LAPLACIAN_SIMPLE,
            SPH_E_ARGUMENT, "isph: Laplacian must be one of sph_isph_laplacian, got %d", (int)kind);
  s->laplacian = kind;
  return SPH_OK;
}

sph_status sph_isph_set_walls(sph_integrator *integrator, sph_isph_walls kind) {
  SETTER(integrator);
  SPH_CHECK(context, kind >= SPH_ISPH_WALLS_GHOSTS && kind <= SPH_ISPH_WALLS_DUMMIES_AS_PRINTED,
            SPH_E_ARGUMENT, "isph: walls must be one of sph_isph_walls, got %d", (int)kind);
  if (kind != s->walls) sphi_solver_renumbered(s->solver);
  s->walls = kind;
  s->dummies.n = 0;
  return SPH_OK;
}

sph_status sph_isph_set_surface_threshold(sph_integrator *integrator, double threshold) {
  SETTER(integrator);
  SPH_CHECK(context, threshold >= 0 && threshold < integrator->particles->dim, SPH_E_ARGUMENT,
            "isph: the threshold of the surface must be >= 0 and below %d, got %g",
            integrator->particles->dim, threshold);
  s->threshold = threshold;
  return SPH_OK;
}

sph_status sph_isph_set_density_correction(sph_integrator *integrator, double theta) {
  SETTER(integrator);
  SPH_CHECK(context, theta >= 0 && theta <= 1, SPH_E_ARGUMENT,
            "isph: the density correction must be 0 to 1, got %g", theta);
  s->theta = theta;
  return SPH_OK;
}

sph_status sph_isph_set_shifting(sph_integrator *integrator, double factor) {
  SETTER(integrator);
  SPH_CHECK(context, factor >= 0 && factor <= 0.5, SPH_E_ARGUMENT,
            "isph: the factor of shifting must be 0 to 0.5, got %g", factor);
  s->shifting = factor;
  return SPH_OK;
}

sph_status sph_isph_set_collisions(sph_integrator *integrator, double share) {
  SETTER(integrator);
  SPH_CHECK(context, share >= 0 && share <= 1, SPH_E_ARGUMENT,
            "isph: the share of collisions must be 0 to 1, got %g", share);
  s->collisions = share;
  return SPH_OK;
}

sph_status sph_isph_set_solver(sph_integrator *integrator, sph_solver_kind kind) {
  SETTER(integrator);
  sph_solver *solver;
  SPH_TRY(create_solver(context, kind, &solver));
  sph_solver_destroy(&s->solver);
  s->solver = solver;
  return SPH_OK;
}

sph_status sph_isph_get_solver(const sph_integrator *integrator, sph_solver **solver) {
  SETTER(integrator);
  SPH_CHECK(context, solver, SPH_E_ARGUMENT, "isph: solver is NULL");
  *solver = s->solver;
  return SPH_OK;
}

sph_status sph_isph_count_surface(const sph_integrator *integrator, int64_t *count) {
  SETTER(integrator);
  SPH_CHECK(context, count, SPH_E_ARGUMENT, "isph: count is NULL");
  *count = s->surface_count;
  return SPH_OK;
}

#define OF_CLOUD(flow, call)                              \
  SPH_TRY(sphi_integrator_check_method((flow), &method)); \
  return call

sph_status sph_isph_set_reference_density(sph_integrator *integrator, double density) {
  OF_CLOUD(integrator, sphi_cloud_set_reference_density(integrator, density));
}

sph_status sph_isph_set_gravity(sph_integrator *integrator, const double *gravity) {
  OF_CLOUD(integrator, sphi_cloud_set_gravity(integrator, gravity));
}

sph_status sph_isph_set_body_force(sph_integrator *integrator, sph_body_force function,
                                   void *user) {
  OF_CLOUD(integrator, sphi_cloud_set_body_force(integrator, function, user));
}

sph_status sph_isph_set_periodic(sph_integrator *integrator, int axis, double lo, double hi) {
  OF_CLOUD(integrator, sphi_cloud_set_periodic(integrator, axis, lo, hi));
}

sph_status sph_isph_set_domain(sph_integrator *integrator, const double *lo, const double *hi) {
  OF_CLOUD(integrator, sphi_cloud_set_domain(integrator, lo, hi));
}

sph_status sph_isph_add_damping_zone(sph_integrator *integrator, int axis, double from, double to,
                                     double rate) {
  OF_CLOUD(integrator, sphi_cloud_add_damping_zone(integrator, axis, from, to, rate));
}

sph_status sph_isph_set_skin(sph_integrator *integrator, double skin) {
  OF_CLOUD(integrator, sphi_cloud_set_skin(integrator, skin));
}

sph_status sph_isph_read_reaction(sph_integrator *integrator, int wall, double *force) {
  OF_CLOUD(integrator, sphi_cloud_read_reaction(integrator, wall, force));
}

sph_status sph_isph_get_energy(const sph_integrator *integrator, sph_energy *out) {
  SPH_TRY(sphi_integrator_check_method(integrator, &method));
  SPH_CHECK(integrator->context, out, SPH_E_ARGUMENT, "isph: energy is NULL");
  const sph_particles *particles = integrator->particles;
  double **x = particles->field[SPHI_X].data, **v = particles->field[SPHI_V].data;
  const double *m = particles->field[SPHI_M].data[0];
  sph_energy sum = {0};
  for (int32_t i = 0; i < particles->n; i++) {
    double v2 = 0, gx = 0;
    for (int d = 0; d < particles->dim; d++) {
      v2 += v[d][i] * v[d][i];
      gx += integrator->cloud.force.constant[d] * x[d][i];
    }
    sum.kinetic += 0.5 * m[i] * v2;
    sum.potential -= m[i] * gx;
  }
  sum.total = sum.kinetic + sum.potential;
  *out = sum;
  return SPH_OK;
}

/* Courant number |u| dt / h: Lee et al. (2008), and any number at which particles do not overtake. */
static double stable_courant(const sph_integrator *flow, sph_stepper stepper) {
  (void)flow, (void)stepper;
  return 0.5;
}

/* Sound has no say, and how fast the flow will be is not known. */
static double stable_dt(const sph_integrator *flow, double courant) {
  (void)flow, (void)courant;
  return 0;
}

static const sphi_method method = {
    .name = "isph",
    .refresh = sphi_isph_refresh,
    .limit = sphi_isph_limit,
    .step = sphi_isph_step,
    .courant = 0.25,
    .stable_courant = stable_courant,
    .stable_dt = stable_dt,
    .destroy = destroy,
    .pressure_gradient = sphi_cloud_pressure_gradient,
    .surroundings = sphi_cloud_surroundings,
    .energy = sph_isph_get_energy,
    .reaction = sph_isph_read_reaction,
    .keep = sphi_isph_keep,
};
