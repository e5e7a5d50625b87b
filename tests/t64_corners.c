/* Flows at sharp solid corners: water stays at rest around them, and flow past them gains no energy. */
#include "flow_world.h"

static const double rho0 = 1000, g = 9.81;

static double total_mass(const flow_world *w) {
  double *m = flow_read(w, SPH_MASS), sum = 0;
  for (sph_index i = 0; i < sph_particles_count(w->water); i++) sum += m[i];
  free(m);
  return sum;
}

static void start_at_rest(flow_world *w, double H) {
  SPH_TEST_OK(w->context, sph_wcsph_set_sound_speed(w->flow, 10 * sqrt(g * H)));
  const double slope[3] = {0, w->dim == 2 ? -rho0 * g : 0, w->dim == 3 ? -rho0 * g : 0};
  flow_linear_pressure(w, rho0 * g * H, slope);
}

/* Advances to `end`: the total energy keeps within a thousandth of what water of depth H could give
 * away, and at the end the rms speed is below 0.3 % of sqrt(gH). */
static void expect_rest(flow_world *w, double H, double end) {
  const double mass = total_mass(w);
  sph_energy energy;
  double first = 0;
  for (int k = 0; k <= 10; k++) {
    if (k > 0) SPH_TEST_OK(w->context, sph_integrator_advance(w->flow, end * k / 10));
    SPH_TEST_OK(w->context, sph_wcsph_get_energy(w->flow, &energy));
    if (k == 0) first = energy.total;
    SPH_TEST_CLOSE(energy.total, first, 0, 1e-3 * mass * g * H);
  }
  SPH_TEST_BELOW(sqrt(2 * energy.kinetic / mass), 3e-3 * sqrt(g * H));
}

static void rest_in_a_tank_with_a_step(void) {
  const double H = 0.3, dx = 0.02;
  const double tank[] = {0, 0.5, 0, 0, 0.5, 0, 0.5, 0.1, 1, 0.1, 1, 0.5};
  const double water[] = {0, 0, 0.5, 0, 0.5, 0.1, 1, 0.1, 1, H, 0, H};
  for (int k = 0; k < 2; k++) {
    flow_world w = flow_open((flow_plan){
        .dx = dx, .boundary = k ? SPH_INTERPOLATOR_MLS_LINEAR : SPH_INTERPOLATOR_IMPROVED_SHEPARD});
    SPH_TEST_OK(w.context, sph_particles_fill_polygon(w.water, 6, water, rho0));
    SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 6, tank, false, &w.wall));
    flow_build(&w);
    start_at_rest(&w, H);
    expect_rest(&w, H, 3);
    flow_free(&w);
  }
}

static bool around_block(const double *x, void *user) {
  const double *block = user;
  for (int d = 0; d < 3; d++)
    if (x[d] < block[d] || x[d] > block[3 + d]) return true;
  return false;
}

static void rest_around_a_block(void) {
  /* 5 by 4 spacings, all of it under water. */
  const double H = 0.4, dx = 0.02, lo[] = {0, 0}, hi[] = {0.6, H}, top[] = {0.6, 0.6};
  double block[6] = {0.24, 0.16, -1, 0.34, 0.24, 1};
  const double corners[] = {0.24, 0.16, 0.24, 0.24, 0.34, 0.24, 0.34, 0.16};
  flow_world w = flow_open((flow_plan){.dx = dx});
  SPH_TEST_OK(w.context, sph_particles_fill_predicate(w.water, lo, hi, around_block, block, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 2, lo, top, SPH_SIDE_HI(1), &w.wall));
  sph_wall *obstacle = NULL;
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 4, corners, true, &obstacle));
  SPH_TEST_OK(w.context, sph_boundary_create(w.context, w.wall, dx, w.interpolator, &w.boundary));
  SPH_TEST_OK(w.context, sph_boundary_add_wall(w.boundary, obstacle));
  SPH_TEST_OK(w.context, sph_wcsph_create(w.context, w.kernel, w.water, w.boundary, &w.flow));
  start_at_rest(&w, H);
  expect_rest(&w, H, 3);
  double force[2];
  SPH_TEST_OK(w.context, sph_boundary_read_force(w.boundary, 1, force));
  SPH_TEST_CLOSE(force[1], rho0 * g * 0.1 * 0.08, 0.05, 0); /* buoyancy */
  SPH_TEST_CLOSE(force[0], 0, 0, 0.05 * rho0 * g * 0.1 * 0.08);
  sph_wall_destroy(&obstacle);
  flow_free(&w);
}

static void dam_break_over_a_sill(void) {
  const double dx = 0.02, H = 0.4, lo[] = {0, 0}, hi[] = {0.4, H};
  const double tank[] = {0, 2, 0, 0, 0.7, 0, 0.7, 0.1, 0.8, 0.1, 0.8, 0, 1.4, 0, 1.4, 2};
  flow_world w = flow_open((flow_plan){.dx = dx});
  SPH_TEST_OK(w.context, sph_particles_fill_box(w.water, lo, hi, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_polyline(w.context, 8, tank, false, &w.wall));
  flow_build(&w);
  start_at_rest(&w, H);
  sph_energy energy;
  SPH_TEST_OK(w.context, sph_wcsph_get_energy(w.flow, &energy));
  double least = energy.total;
  const double allowed = 0.01 * energy.total;
  for (int k = 1; k <= 24; k++) {
    SPH_TEST_OK(w.context, sph_integrator_advance(w.flow, 0.05 * k));
    SPH_TEST_OK(w.context, sph_wcsph_get_energy(w.flow, &energy));
    SPH_TEST_BELOW(energy.total, least + allowed);
    least = fmin(least, energy.total);
  }
  double *x = flow_read(&w, SPH_POSITION), beyond = 0;
  const sph_index n = sph_particles_count(w.water);
  for (sph_index i = 0; i < n; i++) beyond += x[2 * i] > 0.8;
  CU_ASSERT(beyond > 0.1 * n); /* much of the water has gone over */
  free(x);
  flow_free(&w);
}

/* On the lattice the sums around a block are those of the lattice without one, wherever all places in
 * the solid are seen once: the forces balance as well at its corners as anywhere. */
static void forces_balance_around_a_block_in_3d(void) {
  const double H = 1.2, dx = 0.1, lo[] = {0, 0, 0}, hi[] = {1.2, 1.2, H}, top[] = {1.2, 1.2, 2};
  const double a = 0.4, b = 0.8;
  double block[6] = {a, a, a, b, b, b};
  /* Counterclockwise as the water sees them. */
  const double faces[6][4][3] = {
      {{a, a, a}, {a, b, a}, {b, b, a}, {b, a, a}}, {{a, a, b}, {b, a, b}, {b, b, b}, {a, b, b}},
      {{a, a, a}, {b, a, a}, {b, a, b}, {a, a, b}}, {{b, b, a}, {a, b, a}, {a, b, b}, {b, b, b}},
      {{b, a, a}, {b, b, a}, {b, b, b}, {b, a, b}}, {{a, b, a}, {a, a, a}, {a, a, b}, {a, b, b}}};
  flow_world w = flow_open((flow_plan){.dim = 3, .dx = dx, .precision = SPH_PRECISION_DOUBLE});
  SPH_TEST_OK(w.context, sph_particles_fill_predicate(w.water, lo, hi, around_block, block, rho0));
  SPH_TEST_OK(w.context, sph_wall_create_box(w.context, 3, lo, top, SPH_SIDE_HI(2), &w.wall));
  sph_wall *obstacle = NULL;
  SPH_TEST_OK(w.context, sph_wall_create_facets(w.context, 6, faces[0][0], &obstacle));
  SPH_TEST_OK(w.context, sph_boundary_create(w.context, w.wall, dx, w.interpolator, &w.boundary));
  SPH_TEST_OK(w.context, sph_boundary_add_wall(w.boundary, obstacle));
  SPH_TEST_OK(w.context, sph_wcsph_create(w.context, w.kernel, w.water, w.boundary, &w.flow));
  start_at_rest(&w, H);
  flow_evaluate(&w);
  double *x = flow_read(&w, SPH_POSITION), *f = flow_read(&w, "acceleration"), most = 0;
  int near = 0;
  for (sph_index i = 0; i < sph_particles_count(w.water); i++) {
    if (x[3 * i + 2] > H - w.support) continue;
    for (int d = 0; d < 3; d++) most = fmax(most, fabs(f[3 * i + d]));
    near++;
  }
  CU_ASSERT(near > 500);
  SPH_TEST_BELOW(most, 0.02 * g);
  free(x);
  free(f);
  sph_wall_destroy(&obstacle);
  flow_free(&w);
}

SPH_TEST_MAIN("corners", {"water rests in a tank with a step", rest_in_a_tank_with_a_step},
              {"water rests around a block narrower than two supports", rest_around_a_block},
              {"a dam break over a sill gains no energy", dam_break_over_a_sill},
              {"forces balance around a block in 3D", forces_balance_around_a_block_in_3d})
