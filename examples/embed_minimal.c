/* The shortest program: half a second of a dam break inside somebody else's code.
 *
 * Physics    a column of 1.2 x 0.6 m collapses in a tank of 3.22 m and runs along its bed
 * Reference  Huang et al. (2019), section 4.2
 * Build      cc embed_minimal.c -o embed_minimal -lsph -lm
 * Run        ./embed_minimal
 * Expect     last line: "the front is at 2.69 m after 0.50 s", or near it
 *
 * TEST:
 */
#include <math.h>
#include <sph.h>
#include <stdio.h>

#define OK(call) \
  if ((call) != SPH_OK) return fprintf(stderr, "%s\n", sph_context_message(ctx)), 1

int main(void) {
  const double dx = 0.02, lo[] = {0, 0}, hi[] = {1.2, 0.6};
  const double corners[] = {0,    3, 0,    0,
                            3.22, 0, 3.22, 3}; /* the fluid is on the left of this walk */
  double x = 0;
  sph_context *ctx = NULL;
  sph_kernel *kernel = NULL;
  sph_particles *water = NULL;
  sph_wall *tank = NULL;
  sph_interpolator *interpolator = NULL;
  sph_boundary *ghosts = NULL;
  sph_integrator *flow = NULL;
  sph_probe *front = NULL;
  OK(sph_context_create(&ctx));
  OK(sph_kernel_create(ctx, SPH_KERNEL_GAUSSIAN, 2, 1.3 * dx, &kernel));
  OK(sph_particles_create(ctx, 2, dx, &water));
  OK(sph_particles_fill_box(water, lo, hi, 1000));
  OK(sph_wall_create_polyline(ctx, 4, corners, false, &tank));
  OK(sph_interpolator_create(ctx, SPH_INTERPOLATOR_IMPROVED_SHEPARD, kernel, &interpolator));
  OK(sph_boundary_create(ctx, tank, dx, interpolator, &ghosts));
  OK(sph_wcsph_create(ctx, kernel, water, ghosts, &flow));
  OK(sph_wcsph_set_sound_speed(flow, 20 * sqrt(9.81 * 0.6)));
  OK(sph_probe_create_front(flow, 0, 1, &front));
  while (sph_integrator_time(flow) < 0.5) OK(sph_integrator_step(flow));
  OK(sph_probe_last(front, &x));
  printf("the front is at %.2f m after %.2f s\n", x, sph_integrator_time(flow));
  sph_probe_destroy(&front);
  sph_integrator_destroy(&flow);
  sph_boundary_destroy(&ghosts);
  sph_interpolator_destroy(&interpolator);
  sph_wall_destroy(&tank);
  sph_particles_destroy(&water);
  sph_kernel_destroy(&kernel);
  sph_context_destroy(&ctx);
  return 0;
}
