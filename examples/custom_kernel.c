/* A kernel of your own, given as two functions of q = r/h: here that of Lucy
 *
 *     f(q) = (1 + 3 s) (1 - s)^3,  f'(q) = -6 s (1 - s)^2,  s = q / 2,  0 <= q <= 2
 *
 * Physics    1. The library finds the normalisation by quadrature; in 2D it is known: sigma = 5 / (4 pi).
 *            2. Second order: sum_j W_ij V_j f(x_j) / sum_j W_ij V_j of f = sin(2 pi x) cos(2 pi y)
 *               at points inside the unit square, with a support of 3 dx while dx halves.
 *            3. A tank of water at rest for half a second, with Lucy's at a support of 2.6 dx and
 *               with built-in kernels at 3 dx. At 3 dx and more Lucy's lets neighbours pair: a kernel
 *               of good order is not yet a kernel for flows.
 * Reference  Lucy (1977), Astron. J. 82, 1013; the tank is that of Huang et al. (2019), section 4.1
 * Build      cc -O2 custom_kernel.c common/example.c -o custom_kernel -lsph -lm
 * Run        ./custom_kernel
 * Expect     last line: "custom_kernel: normalised, of second order, and keeping water at rest"
 *
 * TEST:
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/example.h"

static const double pi = 3.14159265358979323846;

static double lucy(double q, void *user) {
  (void)user;
  const double s = q / 2;
  return (1 + 3 * s) * (1 - s) * (1 - s) * (1 - s);
}

static double lucy_slope(double q, void *user) {
  (void)user;
  const double s = q / 2;
  return -6 * s * (1 - s) * (1 - s);
}

/* Type 0: Lucy's. `support` is a radius in m. */
static sph_kernel *make_kernel(sph_context *context, int type, double support) {
  sph_kernel *kernel = NULL;
  const double ratio = type == SPH_KERNEL_GAUSSIAN ? 3 : 2;
  if (type == 0)
    OK(sph_kernel_create_user(context, 2, support / 2, 2, lucy, lucy_slope, NULL, &kernel));
  else
    OK(sph_kernel_create(context, (sph_kernel_type)type, 2, support / ratio, &kernel));
  return kernel;
}

/* Largest error of the normalised sum at points off the lattice, two supports away from the edge. */
static double sum_error(sph_context *context, int type, double dx) {
  enum { POINTS = 400 };
  const char *const field = "wave";
  const double lo[2] = {0, 0}, hi[2] = {1, 1};
  double at[2 * POINTS], value[POINTS], worst = 0;
  sph_kernel *kernel = make_kernel(context, type, 3 * dx);
  sph_particles *lattice = NULL;
  sph_interpolator *sum = NULL;
  OK(sph_particles_create(context, 2, dx, &lattice));
  OK(sph_particles_fill_box(lattice, lo, hi, 1000));
  OK(sph_particles_add_field(lattice, "wave", 1, "1"));
  const int64_t n = sph_particles_count(lattice);
  double *x = example_numbers(3 * n), *wave = x + 2 * n;
  OK(sph_particles_read(lattice, SPH_POSITION, x, 2 * n));
  for (int64_t i = 0; i < n; i++) wave[i] = sin(2 * pi * x[2 * i]) * cos(2 * pi * x[2 * i + 1]);
  OK(sph_particles_write(lattice, "wave", wave, n));
  for (int k = 0; k < POINTS; k++) {
    at[2 * k] = 0.3 + 0.4 * fmod(0.618034 * (k + 1), 1);
    at[2 * k + 1] = 0.3 + 0.4 * (k + 0.5) / POINTS;
  }
  OK(sph_interpolator_create(context, SPH_INTERPOLATOR_NORMALIZED, kernel, &sum));
  OK(sph_interpolator_evaluate(sum, lattice, POINTS, at, 1, &field, value, NULL));
  for (int k = 0; k < POINTS; k++)
    worst = fmax(worst, fabs(value[k] - sin(2 * pi * at[2 * k]) * cos(2 * pi * at[2 * k + 1])));
  free(x);
  sph_interpolator_destroy(&sum);
  sph_particles_destroy(&lattice);
  sph_kernel_destroy(&kernel);
  return worst;
}

/* Root mean square velocity over sqrt(g H) after half a second at rest. */
static double unrest(sph_context *context, int type) {
  const double dx = 0.02, depth = 0.3, c0 = 10 * sqrt(9.81 * depth), lo[2] = {0, 0},
               hi[2] = {1, depth};
  const double top[2] = {1, 0.5};
  sph_kernel *kernel = make_kernel(context, type, (type == 0 ? 2.6 : 3) * dx);
  sph_particles *water = NULL;
  sph_wall *tank = NULL;
  sph_interpolator *interpolator = NULL;
  sph_boundary *ghosts = NULL;
  sph_integrator *flow = NULL;
  sph_energy energy;
  OK(sph_particles_create(context, 2, dx, &water));
  OK(sph_particles_fill_box(water, lo, hi, 1000));
  OK(sph_wall_create_box(context, 2, lo, top, SPH_SIDE_HI(1), &tank));
  OK(sph_interpolator_create(context, SPH_INTERPOLATOR_IMPROVED_SHEPARD, kernel, &interpolator));
  OK(sph_boundary_create(context, tank, dx, interpolator, &ghosts));
  OK(sph_wcsph_create(context, kernel, water, ghosts, &flow));
  OK(sph_wcsph_set_sound_speed(flow, c0));
  const int64_t n = sph_particles_count(water);
  double *x = example_numbers(3 * n), *p = x + 2 * n;
  OK(sph_particles_read(water, SPH_POSITION, x, 2 * n));
  for (int64_t i = 0; i < n; i++) p[i] = x[2 * i + 1];
  OK(sph_initial_hydrostatic(context, depth, 9.81, 1000, c0, n, p, p));
  OK(sph_wcsph_start_from_pressure(flow, n, p));
  OK(sph_integrator_advance(flow, 0.5));
  OK(sph_wcsph_get_energy(flow, &energy));
  free(x);
  sph_integrator_destroy(&flow);
  sph_boundary_destroy(&ghosts);
  sph_interpolator_destroy(&interpolator);
  sph_wall_destroy(&tank);
  sph_particles_destroy(&water);
  sph_kernel_destroy(&kernel);
  return sqrt(2 * energy.kinetic / (1000 * depth)) / sqrt(9.81 * depth);
}

int main(int argc, char **argv) {
  int threads = 1;
  const char *path = "";
  const example_option options[] = {
      OPTION_INTEGER("--threads", threads, 0, 1024, "0: one for each processor"),
      OPTION_TEXT("--summary", path, "file for the figures as JSON")};
  example_parse(argc, argv, "a kernel given as functions", 2, options);
  sph_context *context = NULL;
  if (sph_context_create(&context) != SPH_OK) return 1;
  OK(sph_context_set_threads(context, example_threads(threads)));
  example_summary summary = {0};

  sph_kernel *kernel = make_kernel(context, 0, 1);
  const double exact = 5 / (4 * pi);
  const double error = fabs(sph_kernel_get_normalization(kernel) / exact - 1);
  sph_kernel_destroy(&kernel);
  example_summary_number(&summary, "normalization_error_rel", error);

  const int types[] = {0, SPH_KERNEL_WENDLAND_C2, SPH_KERNEL_GAUSSIAN};
  printf("%-14s %12s %12s %12s %8s %22s\n", "kernel", "dx 1/25", "dx 1/50", "dx 1/100", "order",
         "rms velocity/sqrt(gH)");
  double order = 0, motion = 0;
  for (int k = 0; k < 3; k++) {
    const double coarse = sum_error(context, types[k], 0.04),
                 middle = sum_error(context, types[k], 0.02);
    const double fine = sum_error(context, types[k], 0.01), rest = unrest(context, types[k]);
    const double slope = log2(middle / fine);
    printf("%-14s %12.3e %12.3e %12.3e %8.2f %22.2e\n",
           k == 0 ? "lucy, by user" : sph_kernel_name((sph_kernel_type)types[k]), coarse, middle,
           fine, slope, rest);
    if (k == 0) order = slope;
    if (k == 0) motion = rest;
  }
  example_summary_number(&summary, "order_of_normalized_sum", order);
  example_summary_number(&summary, "velocity_rms_over_sqrt_gh", motion);
  example_summary_write(&summary, path);
  sph_context_destroy(&context);
  const bool good = error < 1e-9 && order > 1.8 && motion < 0.01;
  printf("custom_kernel: %s\n", good ? "normalised, of second order, and keeping water at rest"
                                     : "NOT as expected, see above");
  return !good;
}
