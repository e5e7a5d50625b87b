/* Water at rest in a tank stays at rest: what the ghost particles behind the walls are worth.
 *
 * Physics    a tank of 1 m with 0.3 m of water, c0 = 10 sqrt(g H), started from the exact pressure of
 *            the linear equation of state. Pressure at P0-P3 = (0, 0), (0, 0.1), (0, 0.2), (0, 0.25) m
 *            against rho g (H - y). --tank inclined leans the right wall outward (120 degrees inside);
 *            --tank step raises the bed by 0.1 m from x = 0.5 m on (a re-entrant corner).
 * Reference  Huang et al. (2019), section 4.1
 * Build      cc -O2 hydrostatic.c common/example.c common/flow.c -o hydrostatic -lsph -lm
 * Run        ./hydrostatic --end 2 --out hydrostatic.out --summary hydrostatic.json
 * Expect     last line: "hydrostatic: the water stayed in the tank"
 *
 * TEST: --quick
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/flow.h"

static const double length = 1, depth = 0.3, step_at = 0.5, step_height = 0.1, gravity = 9.81,
                    density = 1000;
static const double gauges[4] = {0, 0.1, 0.2, 0.25}; /* heights on the left wall */
enum { GAUGES = 4, ENERGY = GAUGES, FORCE, SURFACE, PROBES };
static const char *const files[PROBES] = {"p0.csv",     "p1.csv",    "p2.csv",     "p3.csv",
                                          "energy.csv", "force.csv", "surface.csv"};

typedef struct setup {
  double dx, end;
  int vtk;
  bool quick;
  example_scheme scheme;
  example_checkpoints checkpoints;
  const char *tank, *out, *summary;
} setup;

static void parse(int argc, char **argv, setup *s) {
  const example_option options[] = {
      OPTION_NUMBER("--dx", s->dx, 1e-4, 0.05, "spacing [m]"),
      OPTION_TEXT("--tank", s->tank, "box, inclined, step"),
      OPTION_NUMBER("--end", s->end, 1e-6, 1e4, "end [s]"),
      EXAMPLE_SCHEME_OPTIONS(s->scheme, "", ""),
      EXAMPLE_CHECKPOINT_OPTIONS(s->checkpoints),
      OPTION_TEXT("--out", s->out, "folder for CSV, picture and VTK; without it none"),
      OPTION_TEXT("--summary", s->summary, "file for the figures as JSON"),
      OPTION_INTEGER("--vtk", s->vtk, 0, 100000, "frames for ParaView"),
      OPTION_FLAG("--quick", s->quick, "coarse and short: a test that it runs")};
  example_parse(argc, argv, "water at rest between walls of fixed ghost particles",
                (int)(sizeof options / sizeof options[0]), options);
  if (strcmp(s->tank, "box") != 0 && strcmp(s->tank, "inclined") != 0 &&
      strcmp(s->tank, "step") != 0)
    example_refuse("--tank", "\"%s\" is none of box, inclined, step", s->tank);
  if (s->vtk > 0 && *s->out == '\0') example_refuse("--vtk", "wants a folder, --out");
  if (s->quick) s->end = fmin(s->end, 0.5);
  if (s->quick) s->dx = fmax(s->dx, 0.02);
}

/* The walls rise at least a kernel's support above the water. */
static void create_tank(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const double top = depth + fmax(0.1, 1.5 * sph_kernel_get_support(f->kernel)),
               slope = sqrt(1.0 / 3);
  const double box[] = {0, top, 0, 0, length, 0, length, top};
  const double inclined[] = {0, top, 0, 0, length, 0, length + slope * top, top};
  const double step[] = {0,       top,         0,      0,           step_at, 0,
                         step_at, step_height, length, step_height, length,  top};
  const bool corner = strcmp(s->tank, "step") == 0;
  OK(sph_wall_create_polyline(context, corner ? 6 : 4,
                              corner                        ? step
                              : strcmp(s->tank, "box") == 0 ? box
                                                            : inclined,
                              false, &f->tank));
}

/* Rows of particles, each stretched a little so that it ends half a spacing from its walls; volumes add
 * up to the water's. In the box and above the step this is the plain lattice. */
static void fill(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const int rows = (int)(depth / s->dx + 1e-6);
  const int longest = (int)((length + depth) / s->dx) + 2;
  double *x = example_numbers(2 * (int64_t)rows * longest);
  double *volume = example_numbers((int64_t)rows * longest);
  int64_t n = 0;
  for (int j = 0; j < rows; j++) {
    const double y = (j + 0.5) * s->dx;
    double width = length;
    if (strcmp(s->tank, "inclined") == 0) width += y / sqrt(3.0);
    if (strcmp(s->tank, "step") == 0 && y < step_height) width = step_at;
    const int columns = (int)floor(width / s->dx + 0.5);
    for (int i = 0; i < columns; i++, n++) {
      x[2 * n] = (i + 0.5) * width / columns;
      x[2 * n + 1] = y;
      volume[n] = s->dx * width / columns;
    }
  }
  OK(sph_particles_add(f->water, n, x, density, NULL));
  OK(sph_particles_write(f->water, SPH_VOLUME, volume, n));
  free(x);
  free(volume);
}

static void start_at_rest(const setup *s, example_flow *f, double c0) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  double *x = example_numbers(3 * n), *pressure = x + 2 * n;
  OK(sph_particles_read(f->water, SPH_POSITION, x, 2 * n));
  for (int64_t i = 0; i < n; i++) pressure[i] = x[2 * i + 1];
  OK(sph_initial_hydrostatic(context, floor(depth / s->dx + 1e-6) * s->dx, gravity, density, c0, n,
                             pressure, pressure));
  example_flow_start(&s->scheme, f, pressure);
  free(x);
}

static void create_flow(const setup *s, example_flow *f) {
  const double c0 = s->scheme.c0_factor * sqrt(gravity * depth);
  example_flow_open(&s->scheme, 2, s->dx, f);
  fill(s, f);
  create_tank(s, f);
  example_flow_solve(&s->scheme, c0, f);
  start_at_rest(s, f, c0);
}

static void create_probes(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  const double middle[2] = {length / 4, 0}, up[2] = {0, 1};
  for (int k = 0; k < GAUGES; k++) {
    const double at[2] = {0, gauges[k]};
    OK(sph_probe_create_pressure(f->integrator, at, &f->probes[k]));
  }
  OK(sph_probe_create_energy(f->integrator, &f->probes[ENERGY]));
  OK(sph_probe_create_force(f->integrator, f->ghosts, 0, &f->probes[FORCE]));
  OK(sph_probe_create_elevation(f->integrator, middle, up, depth + 0.05, &f->probes[SURFACE]));
  for (int k = 0; k < PROBES; k++) OK(sph_probe_set_interval(f->probes[k], 0.005));
  for (int k = 0; k <= ENERGY; k++) OK(sph_probe_sample(f->probes[k]));
  if (s->vtk > 0)
    OK(sph_output_create_vtk(context, example_flow_path(f, s->out, "vtk"), "water", &f->vtk));
}

static sph_status run(const setup *s, example_flow *f) {
  sph_context *context = f->context;
  example_progress progress = {0};
  sph_status status = SPH_OK;
  int frame = example_frames_before(f, s->end, s->vtk);
  for (;;) {
    const double t = sph_integrator_time(f->integrator);
    if (example_frame_due(t, s->end, s->vtk, frame)) {
      OK(sph_output_write(f->vtk, f->water, t));
      frame++;
    }
    if (t >= s->end) break;
    status = sph_integrator_step(f->integrator);
    if (status != SPH_OK) break;
    example_flow_checkpoint(f);
    example_progress_show(&progress, f->integrator, s->end);
  }
  example_progress_end(&progress);
  return status;
}

/* Errors relative to rho g H, over the whole run: against rho g (H - y), and `exact` against the
 * compressible fluid's pressure. Drift: last fifth of the run against the first. */
static void summarise(const setup *s, example_flow *f, example_summary *summary) {
  static const char *const worst_keys[] = {"p0_error_max_rel", "p1_error_max_rel",
                                           "p2_error_max_rel", "p3_error_max_rel"};
  static const char *const exact_keys[] = {"p0_error_exact_max_rel", "p1_error_exact_max_rel",
                                           "p2_error_exact_max_rel", "p3_error_exact_max_rel"};
  static const char *const drift_keys[] = {"p0_drift_rel", "p1_drift_rel", "p2_drift_rel",
                                           "p3_drift_rel"};
  sph_context *context = f->context;
  const double bar = density * gravity * depth;
  example_summary_text(summary, "tank", s->tank);
  example_summary_text(summary, "interpolator", s->scheme.interpolator);
  example_summary_number(summary, "dx_m", s->dx);
  for (int k = 0; k < GAUGES; k++) {
    example_series p = example_series_read(context, f->probes[k], 0);
    double worst = 0, worst_exact = 0, exact;
    OK(sph_initial_hydrostatic(context, depth, gravity, density,
                               s->scheme.c0_factor * sqrt(gravity * depth), 1, &gauges[k], &exact));
    for (int64_t i = 0; i < p.n; i++) {
      worst = fmax(worst, fabs(p.v[i] - density * gravity * (depth - gauges[k])));
      worst_exact = fmax(worst_exact, fabs(p.v[i] - exact));
    }
    example_summary_number(summary, worst_keys[k], worst / bar);
    example_summary_number(summary, exact_keys[k], worst_exact / bar);
    example_summary_number(
        summary, drift_keys[k],
        (example_series_mean(&p, 0.8 * s->end, s->end) - example_series_mean(&p, 0, 0.2 * s->end)) /
            bar);
    free(p.t);
  }
  example_series kinetic = example_series_read(context, f->probes[ENERGY], 0);
  const int64_t n = sph_particles_count(f->water);
  double *mass = example_numbers(n), total = 0;
  OK(sph_particles_read(f->water, SPH_MASS, mass, n));
  for (int64_t i = 0; i < n; i++) total += mass[i];
  const double last = kinetic.v[kinetic.n - 1];
  example_summary_number(summary, "velocity_rms_over_sqrt_gh",
                         sqrt(2 * last / total / (gravity * depth)));
  example_summary_number(summary, "kinetic_energy_end_j", last);
  example_summary_number(summary, "kinetic_energy_mean_first_fifth_j",
                         example_series_mean(&kinetic, 0, 0.2 * s->end));
  example_summary_number(summary, "kinetic_energy_mean_last_fifth_j",
                         example_series_mean(&kinetic, 0.8 * s->end, s->end));
  free(mass);
  free(kinetic.t);
}

/* Particles behind the wall, by the wall's own distance. */
static int64_t count_lost(example_flow *f) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  double *x = example_numbers(2 * n), distance;
  int64_t lost = 0;
  OK(sph_particles_read(f->water, SPH_POSITION, x, 2 * n));
  for (int64_t i = 0; i < n; i++) {
    OK(sph_wall_distance(f->tank, 0, x + 2 * i, &distance));
    lost += distance < 0;
  }
  free(x);
  return lost;
}

int main(int argc, char **argv) {
  setup s = {
      .dx = 0.01, .end = 35, .scheme = EXAMPLE_SCHEME, .tank = "box", .out = "", .summary = ""};
  example_flow f = {0};
  example_summary summary = {0};
  parse(argc, argv, &s);
  create_flow(&s, &f);
  example_flow_resume(&s.checkpoints, s.out, &f);
  create_probes(&s, &f);
  const double start = example_clock();
  const sph_status status = run(&s, &f);
  const double seconds = example_clock() - start;

  summarise(&s, &f, &summary);
  const int64_t lost = count_lost(&f);
  example_summary_integer(&summary, "particles_lost", lost);
  example_summary_flow(&summary, &f, seconds);
  if (*s.out != '\0') {
    example_flow_write_series(&f, s.out, PROBES, files);
    example_picture_write(f.context, f.water, s.out, 0, sph_integrator_time(f.integrator), depth,
                          gravity, density);
  }
  example_summary_write(&summary, s.summary);
  example_check(status, f.context, "sph_integrator_step(flow)");
  example_flow_destroy(&f);
  if (lost > 0) printf("hydrostatic: %lld particles left the tank\n", (long long)lost);
  if (lost == 0) printf("hydrostatic: the water stayed in the tank\n");
  return lost > 0;
}
