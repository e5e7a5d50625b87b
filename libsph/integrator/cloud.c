/* What particle methods share: the fluid among its walls, and the settings that are not of one method. */
#include "integrator/integrator_impl.h"

/* The acceleration is a field, so that it is sorted with the particles and callers can read it. */
static sph_status acceleration_field(sph_particles *particles, int *number) {
  static const char *const name = "acceleration";
  for (int pass = 0; pass < 2; pass++) {
    for (int k = 0; k < particles->fields; k++) {
      if (strcmp(particles->field[k].name, name)) continue;
      SPH_CHECK(particles->context, particles->field[k].components == particles->dim,
                SPH_E_ARGUMENT,
                "particles \"%s\": field \"acceleration\" must have %d components, it has %d",
                particles->name, particles->dim, particles->field[k].components);
      *number = k;
      return SPH_OK;
    }
    SPH_TRY(sph_particles_add_field(particles, name, particles->dim, "m/s^2"));
  }
  return SPH_E_INTERNAL;
}

static sph_status check_boundary(const sphi_method *method, const sph_kernel *kernel,
                                 const sph_particles *particles, const sph_boundary *boundary) {
  sph_context *context = particles->context;
  if (!boundary) return SPH_OK;
  SPH_CHECK(context, boundary->dim == particles->dim, SPH_E_ARGUMENT,
            "%s: the boundary has dimension %d, particles \"%s\" have %d", method->name,
            boundary->dim, particles->name, particles->dim);
  SPH_CHECK(context, boundary->interpolator->kernel->support >= kernel->support * (1 - 1e-12),
            SPH_E_ARGUMENT,
            "%s: ghosts lie %g m deep, the kernel's support is %g m; give the interpolator a "
            "kernel of at least that support",
            method->name, boundary->interpolator->kernel->support, kernel->support);
  SPH_CHECK(context, !boundary->taken, SPH_E_ARGUMENT,
            "%s: another integrator has this boundary; create one more from the same walls",
            method->name);
  return SPH_OK;
}

sph_status sphi_cloud_create(sph_context *context, const sphi_method *method, sph_kernel *kernel,
                             sph_particles *particles, sph_boundary *boundary,
                             sph_integrator **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, kernel && particles && out, SPH_E_ARGUMENT, "%s: %s is NULL", method->name,
            !kernel      ? "kernel"
            : !particles ? "particles"
                         : "out");
  const char *stranger = kernel->context != context                 ? "kernel"
                         : particles->context != context            ? "particle set"
                         : boundary && boundary->context != context ? "boundary"
                                                                    : NULL;
  SPH_CHECK(context, !stranger, SPH_E_ARGUMENT, "%s: the %s is of another context", method->name,
            stranger);
  SPH_CHECK(context, kernel->dim == particles->dim, SPH_E_ARGUMENT,
            "%s: the kernel has dimension %d, particles \"%s\" have %d", method->name, kernel->dim,
            particles->name, particles->dim);
  SPH_CHECK(context, particles->n > 0, SPH_E_ARGUMENT,
            "%s: particles \"%s\" are none; fill the set first", method->name, particles->name);
  SPH_TRY(check_boundary(method, kernel, particles, boundary));
  int acceleration = 0;
  SPH_TRY(acceleration_field(particles, &acceleration));
  sph_integrator *flow;
  SPH_TRY(sphi_integrator_create(context, method, particles, kernel, &flow));
  sphi_cloud *c = &flow->cloud;
  c->acceleration = acceleration;
  c->boundary = boundary;
  if (boundary) {
    sphi_boundary_retain(boundary);
    boundary->taken = true;
  }
  c->rho0 = 1000;
  c->skin = 0.25;
  c->force.constant[particles->dim - 1] = -9.81;
  *out = flow;
  return SPH_OK;
}

void sphi_cloud_free(sph_integrator *flow) {
  sph_context *context = flow->context;
  sphi_cloud *c = &flow->cloud;
  if (c->boundary) c->boundary->taken = false;
  sph_boundary_destroy(&c->boundary);
  sphi_list_free(context, &c->ghost_list);
  sphi_free(context, c->ghost_record);
  for (int d = 0; d < SPHI_MAX_DIM; d++) sphi_free(context, c->reaction[d]);
  sphi_free(context, c->clear);
}

sph_status sphi_cloud_set_gravity(sph_integrator *flow, const double *gravity) {
  sph_context *context = flow->context;
  sphi_cloud *c = &flow->cloud;
  const int dim = flow->particles->dim;
  SPH_CHECK(context, gravity, SPH_E_ARGUMENT, "%s: gravity is NULL", flow->method->name);
  SPH_CHECK(context, sphi_finite(dim, gravity), SPH_E_ARGUMENT,
            "%s: gravity must be finite, got (%g, %g, %g)", flow->method->name, gravity[0],
            gravity[1], dim == 3 ? gravity[2] : 0.0);
  memcpy(c->force.constant, gravity, (size_t)dim * sizeof *gravity);
  return SPH_OK;
}

sph_status sphi_cloud_set_body_force(sph_integrator *flow, sph_body_force function, void *user) {
  sphi_cloud *c = &flow->cloud;
  c->force.function = function;
  c->force.user = user;
  return SPH_OK;
}

sph_status sphi_cloud_set_periodic(sph_integrator *flow, int axis, double lo, double hi) {
  sph_context *context = flow->context;
  sphi_cloud *c = &flow->cloud;
  const int dim = flow->particles->dim;
  SPH_CHECK(context, axis >= 0 && axis < dim, SPH_E_ARGUMENT, "%s: axis must be 0 to %d, got %d",
            flow->method->name, dim - 1, axis);
  SPH_CHECK(context, isfinite(lo) && isfinite(hi) && lo < hi, SPH_E_ARGUMENT,
            "%s: periodic box needs lo < hi, got %g and %g m", flow->method->name, lo, hi);
  const double reach = flow->kernel->support * (1 + c->skin);
  SPH_CHECK(context, 2 * reach <= hi - lo, SPH_E_ARGUMENT,
            "%s: periodic box of %g m is shorter than twice the support with its skin, %g m",
            flow->method->name, hi - lo, 2 * reach);
  c->periodic[axis] = true;
  c->periodic_lo[axis] = lo;
  c->periodic_hi[axis] = hi;
  flow->revision = -1;
  return SPH_OK;
}

sph_status sphi_cloud_set_domain(sph_integrator *flow, const double *lo, const double *hi) {
  sph_context *context = flow->context;
  sphi_cloud *c = &flow->cloud;
  const int dim = flow->particles->dim;
  SPH_CHECK(context, lo && hi, SPH_E_ARGUMENT, "%s: domain %s is NULL", flow->method->name,
            lo ? "hi" : "lo");
  for (int d = 0; d < dim; d++)
    SPH_CHECK(context, isfinite(lo[d]) && isfinite(hi[d]) && lo[d] < hi[d], SPH_E_ARGUMENT,
              "%s: domain needs lo < hi in direction %d, got %g and %g m", flow->method->name, d,
              lo[d], hi[d]);
  memcpy(c->domain_lo, lo, (size_t)dim * sizeof *lo);
  memcpy(c->domain_hi, hi, (size_t)dim * sizeof *hi);
  c->domain_given = true;
  return SPH_OK;
}

sph_status sphi_cloud_add_damping_zone(sph_integrator *flow, int axis, double from, double to,
                                       double rate) {
  sph_context *context = flow->context;
  sphi_cloud *c = &flow->cloud;
  const int dim = flow->particles->dim;
  SPH_CHECK(context, axis >= 0 && axis < dim, SPH_E_ARGUMENT, "%s: axis must be 0 to %d, got %d",
            flow->method->name, dim - 1, axis);
  SPH_CHECK(context, isfinite(from) && isfinite(to) && isfinite(to - from) && from != to,
            SPH_E_ARGUMENT, "%s: a damping zone needs two ends, got %g and %g m",
            flow->method->name, from, to);
  SPH_CHECK(context, isfinite(rate) && rate > 0, SPH_E_ARGUMENT,
            "%s: the rate of a damping zone must be > 0 1/s, got %g", flow->method->name, rate);
  SPH_CHECK(context, c->zones < SPHI_ZONES, SPH_E_ARGUMENT,
            "%s: at most %d damping zones, this is one more", flow->method->name, (int)SPHI_ZONES);
  c->zone[c->zones++] = (sphi_damping_zone){axis, from, to, rate};
  return SPH_OK;
}

sph_status sphi_cloud_set_skin(sph_integrator *flow, double skin) {
  sph_context *context = flow->context;
  sphi_cloud *c = &flow->cloud;
  SPH_CHECK(context, skin >= 0.001 && skin <= 0.5, SPH_E_ARGUMENT,
            "%s: skin must be 0.001 to 0.5 of the support, got %g", flow->method->name, skin);
  for (int d = 0; d < flow->particles->dim; d++) {
    const double length = c->periodic_hi[d] - c->periodic_lo[d];
    const double reach = flow->kernel->support * (1 + skin);
    SPH_CHECK(context, !c->periodic[d] || 2 * reach <= length, SPH_E_ARGUMENT,
              "%s: periodic box of %g m is shorter than twice the support with its skin, %g m",
              flow->method->name, length, 2 * reach);
  }
  c->skin = skin;
  flow->revision = -1;
  return SPH_OK;
}

sph_status sphi_cloud_set_reference_density(sph_integrator *flow, double density) {
  sph_context *context = flow->context;
  SPH_CHECK(context, isfinite(density) && density > 0, SPH_E_ARGUMENT,
            "%s: reference density must be > 0 kg/m^3, got %g", flow->method->name, density);
  flow->cloud.rho0 = density;
  flow->revision = -1;
  return SPH_OK;
}

void sphi_cloud_pressure_gradient(const sph_integrator *flow, const double *x,
                                  const double *acceleration, double *gradient) {
  const sphi_cloud *c = &flow->cloud;
  double f[SPHI_MAX_DIM] = {0};
  if (c->force.function) c->force.function(flow->stats.time, x, f, c->force.user);
  for (int d = 0; d < flow->particles->dim; d++)
    gradient[d] = c->rho0 * (c->force.constant[d] + f[d] - acceleration[d]);
}

void sphi_cloud_surroundings(const sph_integrator *flow, sphi_surroundings *out) {
  const sphi_cloud *c = &flow->cloud;
  out->boundary = c->boundary;
  out->bounded = c->domain_given;
  for (int d = 0; d < flow->particles->dim; d++) {
    out->periodic[d] = c->periodic[d];
    out->lo[d] = c->domain_lo[d];
    out->hi[d] = c->domain_hi[d];
  }
}
