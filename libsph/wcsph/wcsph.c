/* The handle of weakly compressible SPH: settings, start, energies. */
#include "wcsph/wcsph_impl.h"

static const sphi_method method;
static double stable_courant(const sph_integrator *flow, sph_stepper stepper);

#define SETTER(flow)                                      \
  SPH_TRY(sphi_integrator_check_method((flow), &method)); \
  sph_context *context = (flow)->context;                 \
  wcsph *w = wcsph_of(flow)

double sphi_wcsph_density(const sph_integrator *flow, double p) {
  const wcsph *w = wcsph_of(flow);
  const double rho0 = flow->cloud.rho0, stiffness = rho0 * w->c0 * w->c0;
  const double rho = w->equation == SPH_EOS_LINEAR
                         ? rho0 + p / (w->c0 * w->c0)
                         : rho0 * pow(1 + w->gamma * p / stiffness, 1 / w->gamma);
  return rho > 0 ? rho : NAN;
}

static void destroy(sph_integrator *flow) {
  wcsph *w = wcsph_of(flow);
  sph_context *context = flow->context;
  for (int k = 0; k < WCSPH_ARRAYS; k++) sphi_free(context, w->array[k]);
  sphi_free(context, w->block);
  sphi_free(context, w);
  flow->data = NULL;
}

sph_status sph_wcsph_create(sph_context *context, sph_kernel *kernel, sph_particles *particles,
                            sph_boundary *boundary, sph_integrator **out) {
  sph_integrator *flow;
  SPH_TRY(sphi_cloud_create(context, &method, kernel, particles, boundary, out));
  flow = *out;
  wcsph *w = SPHI_NEW(context, 1, wcsph);
  if (!w) {
    sph_integrator_destroy(out);
    return SPHI_ERROR(context, SPH_E_MEMORY, "wcsph: no memory");
  }
  flow->data = w;
  w->gamma = 7;
  w->equation = SPH_EOS_LINEAR;
  w->diffusion = SPH_DIFFUSION_DELTA;
  w->delta = 0.1;
  w->alpha = 0.02;
  return SPH_OK;
}

sph_status sph_wcsph_set_sound_speed(sph_integrator *integrator, double c0) {
  SETTER(integrator);
  SPH_CHECK(context, isfinite(c0) && c0 > 0, SPH_E_ARGUMENT,
            "wcsph: sound speed must be > 0 m/s, got %g", c0);
  const double before = w->c0;
  w->c0 = c0;
  const double limit = sph_integrator_stable_dt(integrator);
  if (integrator->fixed_dt > limit) {
    w->c0 = before;
    return SPHI_ERROR(
        context, SPH_E_ARGUMENT,
        "wcsph: with sound speed %g m/s the fixed time step %g s is beyond the stable "
        "%g s; call sph_integrator_set_dt first",
        c0, integrator->fixed_dt, limit);
  }
  integrator->revision = -1;
  return SPH_OK;
}

#define OF_CLOUD(flow, call)                              \
  SPH_TRY(sphi_integrator_check_method((flow), &method)); \
  wcsph_of(flow)->accelerated = false;                    \
  return call

sph_status sph_wcsph_set_reference_density(sph_integrator *integrator, double density) {
  OF_CLOUD(integrator, sphi_cloud_set_reference_density(integrator, density));
}

sph_status sph_wcsph_set_gravity(sph_integrator *integrator, const double *gravity) {
  OF_CLOUD(integrator, sphi_cloud_set_gravity(integrator, gravity));
}

sph_status sph_wcsph_set_body_force(sph_integrator *integrator, sph_body_force function,
                                    void *user) {
  OF_CLOUD(integrator, sphi_cloud_set_body_force(integrator, function, user));
}

sph_status sph_wcsph_set_periodic(sph_integrator *integrator, int axis, double lo, double hi) {
  OF_CLOUD(integrator, sphi_cloud_set_periodic(integrator, axis, lo, hi));
}

sph_status sph_wcsph_set_domain(sph_integrator *integrator, const double *lo, const double *hi) {
  OF_CLOUD(integrator, sphi_cloud_set_domain(integrator, lo, hi));
}

sph_status sph_wcsph_add_damping_zone(sph_integrator *integrator, int axis, double from, double to,
                                      double rate) {
  OF_CLOUD(integrator, sphi_cloud_add_damping_zone(integrator, axis, from, to, rate));
}

sph_status sph_wcsph_set_skin(sph_integrator *integrator, double skin) {
  OF_CLOUD(integrator, sphi_cloud_set_skin(integrator, skin));
}

sph_status sph_wcsph_read_reaction(sph_integrator *integrator, int wall, double *force) {
  SPH_TRY(sphi_integrator_check_method(integrator, &method));
  return sphi_cloud_read_reaction(integrator, wall, force);
}

sph_status sph_wcsph_set_equation_of_state(sph_integrator *integrator,
                                           sph_equation_of_state equation, double gamma) {
  SETTER(integrator);
  SPH_CHECK(context, equation == SPH_EOS_LINEAR || equation == SPH_EOS_TAIT, SPH_E_ARGUMENT,
            "wcsph: equation of state must be one of sph_equation_of_state, got %d", (int)equation);
  SPH_CHECK(context, equation == SPH_EOS_LINEAR || (isfinite(gamma) && gamma > 0), SPH_E_ARGUMENT,
            "wcsph: gamma must be > 0, got %g", gamma);
  w->equation = equation;
  if (equation == SPH_EOS_TAIT) w->gamma = gamma;
  integrator->revision = -1;
  return SPH_OK;
}

sph_status sph_wcsph_set_diffusion(sph_integrator *integrator, sph_diffusion kind, double delta) {
  SETTER(integrator);
  SPH_CHECK(context, kind >= SPH_DIFFUSION_NONE && kind <= SPH_DIFFUSION_DELTA, SPH_E_ARGUMENT,
            "wcsph: diffusion must be one of sph_diffusion, got %d", (int)kind);
  SPH_CHECK(context, delta >= 0 && delta <= 1, SPH_E_ARGUMENT,
            "wcsph: delta must be 0 to 1, got %g", delta);
  const sph_diffusion kind_before = w->diffusion;
  const double delta_before = w->delta;
  w->diffusion = kind;
  w->delta = delta;
  const double limit = sph_integrator_stable_dt(integrator);
  const double most = stable_courant(integrator, integrator->stepper);
  const bool too_long = limit > 0 && integrator->fixed_dt > limit;
  if (too_long || integrator->courant > most) {
    w->diffusion = kind_before;
    w->delta = delta_before;
    SPH_CHECK(context, !too_long, SPH_E_ARGUMENT,
              "wcsph: with delta %g the fixed time step %g s is beyond the stable %g s; call "
              "sph_integrator_set_dt first",
              delta, integrator->fixed_dt, limit);
    return SPHI_ERROR(context, SPH_E_ARGUMENT,
                      "wcsph: with delta %g the courant number %g is beyond the stable %g; call "
                      "sph_integrator_set_courant first",
                      delta, integrator->courant, most);
  }
  integrator->revision = -1;
  return SPH_OK;
}

sph_status sph_wcsph_set_artificial_viscosity(sph_integrator *integrator, double alpha) {
  SETTER(integrator);
  SPH_CHECK(context, alpha >= 0 && alpha <= 1, SPH_E_ARGUMENT,
            "wcsph: alpha must be 0 to 1, got %g", alpha);
  w->alpha = alpha;
  return SPH_OK;
}

sph_status sph_wcsph_set_laminar_viscosity(sph_integrator *integrator, double nu) {
  SETTER(integrator);
  SPH_CHECK(context, isfinite(nu) && nu >= 0, SPH_E_ARGUMENT,
            "wcsph: viscosity must be >= 0 m^2/s, got %g", nu);
  w->nu = nu;
  return SPH_OK;
}

sph_status sph_wcsph_density_of_pressure(const sph_integrator *integrator, int64_t n,
                                         const double *pressure, double *density) {
  SETTER(integrator);
  SPH_CHECK(context, pressure && density, SPH_E_ARGUMENT, "wcsph: %s is NULL",
            pressure ? "density" : "pressure");
  SPH_CHECK(context, n >= 0, SPH_E_ARGUMENT, "wcsph: n must be >= 0, got %lld", (long long)n);
  SPH_CHECK(context, w->c0 > 0, SPH_E_ARGUMENT,
            "wcsph: the sound speed is not set; call sph_wcsph_set_sound_speed");
  for (int64_t i = 0; i < n; i++)
    SPH_CHECK(context, isfinite(sphi_wcsph_density(integrator, pressure[i])), SPH_E_ARGUMENT,
              "wcsph: no density gives pressure %g Pa (entry %lld)", pressure[i], (long long)i);
  for (int64_t i = 0; i < n; i++) density[i] = sphi_wcsph_density(integrator, pressure[i]);
  return SPH_OK;
}

sph_status sph_wcsph_start_from_pressure(sph_integrator *integrator, int64_t n,
                                         const double *pressure) {
  SETTER(integrator);
  sph_particles *particles = integrator->particles;
  SPH_CHECK(context, pressure, SPH_E_ARGUMENT, "wcsph: pressure is NULL");
  SPH_CHECK(context, n == particles->n, SPH_E_ARGUMENT, "wcsph: %lld pressures for %d particles",
            (long long)n, particles->n);
  SPH_CHECK(context, w->c0 > 0, SPH_E_ARGUMENT,
            "wcsph: the sound speed is not set; call sph_wcsph_set_sound_speed");
  for (int64_t i = 0; i < n; i++)
    SPH_CHECK(context, isfinite(sphi_wcsph_density(integrator, pressure[i])), SPH_E_ARGUMENT,
              "wcsph: no density gives pressure %g Pa (entry %lld)", pressure[i], (long long)i);
  double *rho = particles->field[SPHI_RHO].data[0], *m = particles->field[SPHI_M].data[0];
  double *p = particles->field[SPHI_P].data[0], *volume = particles->field[SPHI_VOL].data[0];
  for (int64_t k = 0; k < n; k++) {
    const sph_index i = particles->slot[k];
    rho[i] = sphi_wcsph_density(integrator, pressure[k]);
    m[i] = rho[i] * volume[i];
    p[i] = pressure[k];
  }
  particles->revision++;
  return SPH_OK;
}

/* Energy stored per mass between rho0 and rho: the integral of p / rho^2. */
static double stored_energy(const sph_integrator *flow, double rho) {
  const wcsph *w = wcsph_of(flow);
  const double ratio = rho / flow->cloud.rho0, c2 = w->c0 * w->c0;
  if (w->equation == SPH_EOS_LINEAR || fabs(w->gamma - 1) < 1e-12)
    return c2 * (log(ratio) + 1 / ratio - 1);
  const double g = w->gamma;
  return c2 / g * ((pow(ratio, g - 1) - 1) / (g - 1) + 1 / ratio - 1);
}

sph_status sph_wcsph_get_energy(const sph_integrator *integrator, sph_energy *energy) {
  SETTER(integrator);
  SPH_CHECK(context, energy, SPH_E_ARGUMENT, "wcsph: energy is NULL");
  SPH_CHECK(context, w->c0 > 0, SPH_E_ARGUMENT,
            "wcsph: the sound speed is not set; call sph_wcsph_set_sound_speed");
  const sph_particles *particles = integrator->particles;
  double **x = particles->field[SPHI_X].data, **v = particles->field[SPHI_V].data;
  const double *m = particles->field[SPHI_M].data[0], *rho = particles->field[SPHI_RHO].data[0];
  sph_energy sum = {0};
  for (int32_t i = 0; i < particles->n; i++) {
    double v2 = 0, gx = 0;
    for (int d = 0; d < particles->dim; d++) {
      v2 += v[d][i] * v[d][i];
      gx += integrator->cloud.force.constant[d] * x[d][i];
    }
    sum.kinetic += 0.5 * m[i] * v2;
    sum.potential -= m[i] * gx;
    sum.compressible += m[i] * stored_energy(integrator, rho[i]);
  }
  sum.total = sum.kinetic + sum.potential + sum.compressible;
  *energy = sum;
  return SPH_OK;
}

/* Second moment of the kernel per direction over h^2: its square root is the width that sets how
 * short a wave the lattice feels. */
static double second_moment(const sph_kernel *kernel) {
  enum { INTERVALS = 400 };
  double sum = 0;
  for (int k = 0; k < INTERVALS; k++) { /* midpoint rule: ample for a stability limit */
    const double q = kernel->ratio * (k + 0.5) / INTERVALS;
    sum += pow(q, kernel->dim + 1) * sph_kernel_w(kernel, q * kernel->h);
  }
  static const double sphere[] = {0, 2, 6.283185307179586, 12.566370614359172};
  return sphere[kernel->dim] / kernel->dim * sum * kernel->ratio / INTERVALS *
         pow(kernel->h, kernel->dim);
}

/* Fits below the limits of a von Neumann analysis for the built-in kernels, docs/theory/time_stepping.md:
 * sound waves feel the width of the kernel. Symplectic and Verlet steps take the density diffusion in
 * one step late, which halves their limit; in any step the diffusion itself has a limit. */
static double stable_courant(const sph_integrator *flow, sph_stepper stepper) {
  const wcsph *w = wcsph_of(flow);
  const double moment = second_moment(flow->kernel);
  const bool diffuses = w && w->diffusion != SPH_DIFFUSION_NONE && w->delta > 0;
  const double factor = stepper == SPH_STEPPER_RK4 ? 4.36 : diffuses ? 1.75 : 2.99;
  const double courant = factor * sqrt(moment);
  return diffuses ? fmin(courant, moment / w->delta) : courant;
}

static double stable_dt(const sph_integrator *flow, double courant) {
  const wcsph *w = wcsph_of(flow);
  return w && w->c0 > 0 ? courant * flow->kernel->h / w->c0 : 0;
}

static const sphi_method method = {
    .name = "wcsph",
    .refresh = sphi_wcsph_refresh,
    .limit = sphi_wcsph_limit,
    .step = sphi_wcsph_step,
    .stable_courant = stable_courant,
    .stable_dt = stable_dt,
    .destroy = destroy,
    .pressure_gradient = sphi_cloud_pressure_gradient,
    .surroundings = sphi_cloud_surroundings,
    .energy = sph_wcsph_get_energy,
    .reaction = sph_wcsph_read_reaction,
    .keep = sphi_wcsph_keep,
};
