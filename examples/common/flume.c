/* What the examples of waves share, see flume.h. */
#include "flume.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static bool by_paddle(const example_flume *s) { return strcmp(s->start, "paddle") == 0; }

example_scheme example_flume_scheme(void) {
  example_scheme scheme = EXAMPLE_SCHEME;
  scheme.kernel = "wendland-c2";
  scheme.h_ratio = 2;
  scheme.alpha = 0.01;
  return scheme;
}

void example_flume_complete(example_flume *s) {
  if (!by_paddle(s) && strcmp(s->start, "theory") != 0)
    example_refuse("--start", "\"%s\" is neither paddle nor theory", s->start);
  if (*s->motion != '\0' && !by_paddle(s)) example_refuse("--motion", "wants --start paddle");
  if (s->paddle_middle > 0 && (s->paddle_start > 0 || *s->motion != '\0' || !by_paddle(s)))
    example_refuse("--paddle-middle", "goes without --paddle-start, --motion, --start theory");
  if (s->crest == 0) s->crest = fmin(20 * s->depth, 0.5 * s->length);
  if (!by_paddle(s) && s->crest > s->length)
    example_refuse("--crest", "must be in the flume of %g m, got %g", s->length, s->crest);
  if (s->angle < 45 || s->angle > 135)
    example_refuse("--angle", "must be 45 to 135 degrees, got %g", s->angle);
}

void example_flume_on_wall(const example_flume *s, double height, double *point) {
  point[0] = s->length - height / tan(s->angle * pi / 180);
  point[1] = height;
}

/* Bed and a fixed right wall are one line, with a corner. Walls of their own reach past each other by more
 * than the kernel's support, so that corners are filled wherever they stand. Sides end high above any
 * run-up. */
static void create_walls(const example_flume *s, const example_waves *w, sph_body *body,
                         example_flow *f) {
  sph_context *context = f->context;
  const double past = sph_kernel_get_support(f->kernel) + 2 * s->dx, top = 5 * s->depth;
  double rim[2];
  example_flume_on_wall(s, top, rim);
  const double bed_end = body ? 3 * s->length + past : s->length; /* with room for it to go */
  const double bed[] = {-past - s->depth, 0, bed_end, 0, rim[0], rim[1]};
  const double left[] = {0, top, 0, -past}, right[] = {s->length, -past, s->length, top};
  const double along[] = {1, 0};
  OK(sph_wall_create_polyline(context, body ? 2 : 3, bed, false, &f->tank));
  OK(sph_wall_set_name(f->tank, body ? "bed" : "bed and seawall"));
  OK(sph_wall_create_polyline(context, 2, left, false, &f->more[FLUME_LEFT - 1]));
  sph_wall *side = f->more[FLUME_LEFT - 1];
  OK(sph_wall_set_name(side, !w->paddle ? "left side" : w->flap ? "flap" : "piston"));
  if (w->flap)
    OK(sph_wall_set_rotation(side, (const double[]){0, 0}, NULL, sph_paddle_rotation, w->paddle));
  else if (w->paddle)
    OK(sph_wall_set_motion(side, sph_paddle_motion, w->paddle));
  if (!body) return;
  OK(sph_wall_create_polyline(context, 2, right, false, &f->more[FLUME_RIGHT - 1]));
  OK(sph_wall_set_name(f->more[FLUME_RIGHT - 1], "seawall"));
  OK(sph_wall_set_body(f->more[FLUME_RIGHT - 1], body, along));
}

typedef struct surface {
  const sph_wave *wave; /* NULL: still water */
  double depth;
} surface;

static double surface_level(const double *x, void *user) {
  const surface *of = user;
  double elevation = 0;
  if (of->wave && sph_wave_elevation(of->wave, 0, 1, x, &elevation) != SPH_OK) return NAN;
  return of->depth + elevation;
}

/* Columns up to the toe, and rows beyond it or cut off by a wall that leans inward. */
static void fill(const example_flume *s, const example_waves *w, example_flow *f) {
  sph_context *context = f->context;
  double shore[2];
  example_flume_on_wall(s, s->depth, shore);
  surface under = {w->paddle ? NULL : w->wave, s->depth};
  const double columns_end = s->dx * floor(fmin(s->length, shore[0]) / s->dx + 1e-6);
  const double lo[2] = {0, 0}, hi[2] = {columns_end, 4 * s->depth};
  OK(sph_particles_fill_surface(f->water, lo, hi, surface_level, &under, s->density));
  const int64_t first = sph_particles_count(f->water);
  const int rows = (int)floor(s->depth / s->dx + 0.5);
  const int widest = (int)(fabs(shore[0] - s->length) / s->dx) + 3;
  double *x = example_numbers(2 * (int64_t)rows * widest);
  double *volume = example_numbers(first + (int64_t)rows * widest);
  int64_t n = 0;
  OK(sph_particles_read(f->water, SPH_VOLUME, volume, first));
  for (int j = 0; j < rows; j++) {
    double at[2];
    const double high = s->depth / rows, y = (j + 0.5) * high;
    example_flume_on_wall(s, y, at);
    const double width = at[0] - columns_end;
    const int count = (int)floor(width / s->dx + 0.5);
    for (int i = 0; i < count; i++, n++) {
      x[2 * n] = columns_end + (i + 0.5) * width / count;
      x[2 * n + 1] = y;
      volume[first + n] = high * width / count;
    }
  }
  OK(sph_particles_add(f->water, n, x, s->density, NULL));
  OK(sph_particles_write(f->water, SPH_VOLUME, volume, first + n));
  free(x);
  free(volume);
}

/* Still water, or velocity and pressure of the wave. */
static void start(const example_flume *s, const example_scheme *scheme, const example_waves *w,
                  double c0, example_flow *f) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  double *x = example_flow_read(f, SPH_POSITION, 2), *v = example_numbers(2 * n),
         *p = example_numbers(n);
  if (w->paddle) {
    for (int64_t i = 0; i < n; i++) p[i] = x[2 * i + 1];
    OK(sph_initial_hydrostatic(context, s->depth, s->gravity, s->density, c0, n, p, p));
  } else {
    OK(sph_wave_velocity(w->wave, 0, n, x, v));
    OK(sph_wave_pressure(w->wave, s->density, 0, n, x, p));
    OK(sph_particles_write(f->water, SPH_VELOCITY, v, 2 * n));
  }
  example_flow_start(scheme, f, p);
  free(x);
  free(v);
  free(p);
}

void example_flume_build(const example_flume *s, const example_scheme *scheme, sph_body *body,
                         example_flow *f, const example_waves *w) {
  const double c0 = scheme->c0_factor * sqrt(s->gravity * s->depth * (1 + s->height_ratio));
  fill(s, w, f);
  create_walls(s, w, body, f);
  example_flow_solve(scheme, c0, f);
  start(s, scheme, w, c0, f);
}

static double time_to_middle(const sph_paddle *paddle) {
  return 0.5 * (sph_paddle_end(paddle) - sph_paddle_start(paddle));
}

/* Moves the law so that the middle of the stroke is at the time asked for. Where half of it takes longer, the
 * pieces that bring the paddle to rest at both ends get more of the stroke, up to what they may have. */
static void time_the_middle(const example_flume *s, const sph_context *context,
                            sph_paddle *paddle) {
  double lo = 1e-6, hi = 0.1;
  for (int k = 0; k < 40 && (k > 0 || time_to_middle(paddle) > s->paddle_middle); k++) {
    const double fraction = 0.5 * (lo + hi);
    OK(sph_paddle_set_ends(paddle, fraction, 0));
    *(time_to_middle(paddle) > s->paddle_middle ? &lo : &hi) = fraction;
  }
  OK(sph_paddle_set_start(paddle, fmax(0, s->paddle_middle - time_to_middle(paddle))));
}

void example_flume_create(const example_flume *s, const example_scheme *scheme, sph_body *body,
                          example_flow *f, example_waves *w) {
  sph_context *context = f->context;
  sph_solitary_theory theory;
  OK(sph_solitary_theory_find(context, s->theory, &theory));
  OK(sph_wave_create_solitary(context, theory, s->height_ratio * s->depth, s->depth, s->gravity,
                              &w->wave));
  OK(sph_wave_set_origin(w->wave, s->length - s->crest, 0, 1));
  if (*s->motion != '\0')
    OK(sph_paddle_create_csv(context, s->motion, "t_s", "x_piston_m", &w->paddle));
  else if (by_paddle(s))
    OK(sph_paddle_create_solitary(context, w->wave, s->paddle_start, &w->paddle));
  if (by_paddle(s) && s->paddle_middle > 0) time_the_middle(s, context, w->paddle);
  example_flume_build(s, scheme, body, f, w);
}

void example_waves_destroy(example_waves *w) {
  sph_paddle_destroy(&w->paddle);
  sph_wave_destroy(&w->wave);
}

double example_flume_arrival(const example_flume *s, const example_waves *w) {
  const double c = sph_wave_celerity(w->wave);
  if (!w->paddle) return s->crest / c;
  /* The crest passes the piston at the middle of its stroke. */
  const double middle = 0.5 * (sph_paddle_start(w->paddle) + sph_paddle_end(w->paddle));
  return middle + (s->length - 0.5 * sph_paddle_stroke(w->paddle)) / c;
}

void example_flume_watch(const example_flume *flume, example_flow *f, int count, int force, int vtk,
                         const char *folder) {
  sph_context *context = f->context;
  for (int k = 0; k < count; k++) {
    OK(sph_probe_set_interval(f->probes[k], 0.02 * sqrt(flume->depth / flume->gravity)));
    if (k != force) OK(sph_probe_sample(f->probes[k]));
  }
  if (vtk == 0) return;
  OK(sph_output_create_vtk(context, example_flow_path(f, folder, "vtk"), "water", &f->vtk));
  OK(sph_output_add_field(f->vtk, SPH_VELOCITY));
  OK(sph_output_add_field(f->vtk, SPH_PRESSURE));
}

sph_status example_flume_run(const example_flume *flume, example_flow *f, double end, int vtk,
                             int pictures, const char *folder) {
  sph_context *context = f->context;
  example_progress progress = {0};
  sph_status status = SPH_OK;
  int frame = example_frames_before(f, end, vtk);
  int picture = example_frames_before(f, end, pictures);
  for (;;) {
    const double t = sph_integrator_time(f->integrator);
    if (example_frame_due(t, end, vtk, frame)) {
      OK(sph_output_write(f->vtk, f->water, t));
      frame++;
    }
    if (example_frame_due(t, end, pictures, picture))
      example_picture_write(context, f->water, folder, picture++, t, flume->depth, flume->gravity,
                            flume->density);
    if (t >= end) break;
    status = sph_integrator_step(f->integrator);
    if (status != SPH_OK) break;
    example_flow_checkpoint(f);
    example_progress_show(&progress, f->integrator, end);
  }
  example_progress_end(&progress);
  return status;
}

int64_t example_flume_count_lost(const example_flow *f) {
  sph_context *context = f->context;
  const int64_t n = sph_particles_count(f->water);
  const double t = sph_integrator_time(f->integrator);
  const sph_wall *walls[] = {f->tank, f->more[0], f->more[1]};
  double *x = example_flow_read(f, SPH_POSITION, 2);
  int64_t lost = 0;
  for (int64_t i = 0; i < n; i++) {
    bool inside = false;
    for (int k = 0; k < 3 && walls[k]; k++) {
      double distance;
      OK(sph_wall_distance(walls[k], t, x + 2 * i, &distance));
      inside = inside || distance < 0;
    }
    lost += inside;
  }
  free(x);
  return lost;
}
