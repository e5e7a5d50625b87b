/* Checkpoints: the same bits after them, files that are damaged or of something else, no memory, full disks. */
#define _POSIX_C_SOURCE 200809L
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "flow_world.h"

static const double rho0 = 1000, depth = 0.2, length = 0.5;
static char path[64];

typedef enum surroundings { OPEN, FLUME, BOX, PERIODIC } surroundings;

/* What to compute; with method 'f' the mesh instead of walls. */
typedef struct plan {
  char method; /* w: weakly compressible, i: incompressible, f: with a mesh */
  int dim;
  surroundings around;
  sph_stepper stepper; /* 0: the method's own */
  bool is_double, tait, flap, no_field, dummies;
  int threads;
} plan;

typedef struct run {
  plan is;
  flow_world w;
  sph_wall *side[2];
  sph_body *body;
  sph_mesh *mesh;
  sph_probe *probe;
} run;

static void push(double t, double *displacement, double *velocity, double *acceleration,
                 void *user) {
  (void)user;
  displacement[0] = 0.02 * (1 - cos(9 * t));
  velocity[0] = 0.18 * sin(9 * t);
  acceleration[0] = 1.62 * cos(9 * t);
}

static void turn(double t, double *angle, double *rate, double *rate_change, void *user) {
  (void)user;
  *angle = -0.1 * (1 - cos(9 * t));
  *rate = -0.9 * sin(9 * t);
  *rate_change = -8.1 * cos(9 * t);
}

static double level(const double *x, void *user) {
  (void)user;
  return depth * (1 + 0.2 * (x[0] < 0.2));
}

/* A bed, a piston on the left and a wall on a spring on the right. */
static void make_flume(run *r) {
  sph_context *context = r->w.context;
  const double past = 0.15, along[2] = {1, 0};
  const double bed[] = {-past, 0, length + past, 0}, left[] = {0, 0.6, 0, -past},
               right[] = {length, -past, length, 0.6};
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, bed, false, &r->w.wall));
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, left, false, &r->side[0]));
  SPH_TEST_OK(context, sph_wall_create_polyline(context, 2, right, false, &r->side[1]));
  if (r->is.flap)
    SPH_TEST_OK(context,
                sph_wall_set_rotation(r->side[0], (const double[]){0, 0}, NULL, turn, NULL));
  else
    SPH_TEST_OK(context, sph_wall_set_motion(r->side[0], push, NULL));
  SPH_TEST_OK(context, sph_body_create(context, 40, &r->body));
  SPH_TEST_OK(context, sph_body_set_spring(r->body, 4000, 0));
  SPH_TEST_OK(context, sph_wall_set_body(r->side[1], r->body, along));
}

static void fill(run *r) {
  sph_context *context = r->w.context;
  const double lo[3] = {0, 0, 0}, hi[3] = {length, r->is.dim == 2 ? depth : 0.1, depth};
  const double all[3] = {length, length, length}, top[3] = {0.8, r->is.dim == 2 ? 0.5 : 0.1, 0.5};
  if (r->is.around == PERIODIC) {
    SPH_TEST_OK(context, sph_particles_fill_box(r->w.water, lo, all, rho0));
    flow_stir(&r->w, r->is.method == 'i' ? 0.05 : 0.5, 3);
    flow_jitter(&r->w, 0.1, 5);
    return;
  }
  SPH_TEST_OK(context, sph_particles_fill_box(r->w.water, lo, hi, rho0));
  if (r->is.around == FLUME) make_flume(r);
  if (r->is.around != BOX) return;
  SPH_TEST_OK(context, sph_wall_create_box(context, r->is.dim, lo, top, 0, &r->w.wall));
  SPH_TEST_OK(context, sph_wall_set_motion(r->w.wall, push, NULL));
}

/* Particles of two fluids in a mesh with an open top and a paddle, which come and go. */
static void make_mesh_run(run *r) {
  sph_context *context = r->w.context;
  SPH_TEST_OK(context, sph_mesh_create_flume(context, 0, 1, 0.5, 20, 10, NULL, NULL, &r->mesh));
  SPH_TEST_OK(context, sph_flip_fill(r->mesh, r->w.water, 3, level, NULL, 1000, 1));
  SPH_TEST_OK(context, sph_flip_create(context, r->mesh, r->w.water, &r->w.flow));
  SPH_TEST_OK(context, sph_flip_set_paddle(r->w.flow, push, NULL, 0.6));
  SPH_TEST_OK(context, sph_flip_set_reseeding(r->w.flow, 7, 14));
}

static void make_particle_run(run *r) {
  sph_context *context = r->w.context;
  const double none[3] = {0, 0, 0};
  fill(r);
  if (r->w.wall)
    SPH_TEST_OK(context, sph_boundary_create(context, r->w.wall, r->w.dx, r->w.interpolator,
                                             &r->w.boundary));
  for (int k = 0; k < 2 && r->side[k]; k++)
    SPH_TEST_OK(context, sph_boundary_add_wall(r->w.boundary, r->side[k]));
  if (r->is.method == 'i') {
    SPH_TEST_OK(context,
                sph_isph_create(context, r->w.kernel, r->w.water, r->w.boundary, &r->w.flow));
    SPH_TEST_OK(context, sph_isph_set_laminar_viscosity(r->w.flow, 1e-5));
    if (r->is.dummies) SPH_TEST_OK(context, sph_isph_set_walls(r->w.flow, SPH_ISPH_WALLS_DUMMIES));
  } else {
    SPH_TEST_OK(context,
                sph_wcsph_create(context, r->w.kernel, r->w.water, r->w.boundary, &r->w.flow));
    SPH_TEST_OK(context, sph_wcsph_set_sound_speed(r->w.flow, 20));
    if (r->is.tait)
      SPH_TEST_OK(context, sph_wcsph_set_equation_of_state(r->w.flow, SPH_EOS_TAIT, 7));
    if (r->is.stepper) SPH_TEST_OK(context, sph_integrator_set_stepper(r->w.flow, r->is.stepper));
  }
  for (int d = 0; d < r->is.dim && r->is.around == PERIODIC; d++) {
    if (r->is.method == 'i') SPH_TEST_OK(context, sph_integrator_set_dt(r->w.flow, 1e-3));
    if (r->is.method == 'i') {
      SPH_TEST_OK(context, sph_isph_set_periodic(r->w.flow, d, 0, length));
      SPH_TEST_OK(context, sph_isph_set_gravity(r->w.flow, none));
    } else {
      SPH_TEST_OK(context, sph_wcsph_set_periodic(r->w.flow, d, 0, length));
      SPH_TEST_OK(context, sph_wcsph_set_gravity(r->w.flow, none));
    }
  }
}

static run make_with(plan is, const sph_allocator *allocator) {
  run r = {.is = is};
  if (r.is.dim == 0) r.is.dim = 2;
  const bool is_mesh = is.method == 'f';
  r.w =
      flow_open((flow_plan){.dim = r.is.dim,
                            .dx = is_mesh         ? 1.0 / 60
                                  : r.is.dim == 2 ? 0.02
                                                  : 0.025,
                            .kernel = SPH_KERNEL_WENDLAND_C2,
                            .ratio = r.is.dim == 2 ? 1.5 : 1.2,
                            .boundary = SPH_INTERPOLATOR_IMPROVED_SHEPARD,
                            .precision = is.is_double ? SPH_PRECISION_DOUBLE : SPH_PRECISION_SINGLE,
                            .threads = is.threads,
                            .allocator = allocator});
  if (is_mesh)
    make_mesh_run(&r);
  else
    make_particle_run(&r);
  if (!is.no_field)
    SPH_TEST_OK(r.w.context, sph_particles_add_field(r.w.water, "dye", 1, "kg/m^3"));
  const double point[3] = {0.3, 0.05, 0.05};
  SPH_TEST_OK(r.w.context, sph_probe_create_pressure(r.w.flow, point, &r.probe));
  return r;
}

static run make(plan is) { return make_with(is, NULL); }

static void end(run *r) {
  sph_probe_destroy(&r->probe);
  sph_integrator_destroy(&r->w.flow);
  sph_mesh_destroy(&r->mesh);
  for (int k = 0; k < 2; k++) sph_wall_destroy(&r->side[k]);
  sph_body_destroy(&r->body);
  flow_free(&r->w);
}

static void paint(run *r) {
  double *dye = flow_read(&r->w, "dye");
  uint64_t seed = 11;
  for (sph_index k = 0; k < sph_particles_count(r->w.water); k++) dye[k] = sph_test_random(&seed);
  flow_write(&r->w, "dye", dye);
  free(dye);
}

static void write_checkpoint(run *r) {
  SPH_TEST_OK(r->w.context, sph_integrator_write_checkpoint(r->w.flow, path));
}

static void read_checkpoint(run *r) {
  SPH_TEST_OK(r->w.context, sph_integrator_read_checkpoint(r->w.flow, path));
}

/* Everything that can be seen of a run, as one array; the caller frees it. */
static double *look(const run *r, size_t *size) {
  sph_context *context = r->w.context;
  const sph_index n = sph_particles_count(r->w.water);
  const int fields = sph_particles_field_count(r->w.water);
  const int64_t ghosts = sph_boundary_count(r->w.boundary);
  const int64_t nodes = sph_mesh_node_count(r->mesh), cells = sph_mesh_cell_count(r->mesh);
  double *all = flow_room((int64_t)n * (1 + 9 * fields) + (1 + r->is.dim) * ghosts + 3 * nodes +
                          3 * cells + 64),
         *at = all;
  int64_t *ids = calloc((size_t)n + 1, sizeof *ids);
  SPH_TEST_OK(context, sph_particles_read_ids(r->w.water, ids, n));
  for (sph_index k = 0; k < n; k++) *at++ = (double)ids[k];
  free(ids);
  for (int f = 0; f < fields; f++) {
    const char *name = sph_particles_field_name(r->w.water, f);
    int components;
    SPH_TEST_OK(context, sph_particles_field_components(r->w.water, name, &components));
    SPH_TEST_OK(context, sph_particles_read(r->w.water, name, at, (int64_t)n * components));
    at += (int64_t)n * components;
  }
  sph_integrator_stats stats;
  SPH_TEST_OK(context, sph_integrator_get_stats(r->w.flow, &stats));
  const double numbers[] = {stats.time,
                            stats.dt,
                            (double)stats.steps,
                            (double)stats.evaluations,
                            stats.max_speed,
                            stats.max_acceleration,
                            (double)stats.pairs,
                            (double)stats.contacts,
                            (double)n};
  memcpy(at, numbers, sizeof numbers);
  at += sizeof numbers / sizeof numbers[0];
  if (ghosts > 0) {
    SPH_TEST_OK(context, sph_boundary_read(r->w.boundary, SPH_GHOST_PRESSURE, at, ghosts));
    at += ghosts;
    SPH_TEST_OK(context,
                sph_boundary_read(r->w.boundary, SPH_GHOST_POSITION, at, ghosts * r->is.dim));
    at += ghosts * r->is.dim;
    SPH_TEST_OK(context, sph_boundary_read_force(r->w.boundary, 0, at));
    at += 3;
  }
  if (r->body) SPH_TEST_OK(context, sph_body_get_state(r->body, at, at + 1, at + 2, at + 3));
  at += 4;
  if (r->mesh) {
    sph_flip_stats flip;
    SPH_TEST_OK(context, sph_flip_get_stats(r->w.flow, &flip));
    const int64_t counts[] = {flip.mixed_cells, flip.empty_cells, flip.fewest, flip.most,
                              flip.entered,     flip.left,        flip.split,  flip.merged};
    for (int k = 0; k < 8; k++) *at++ = (double)counts[k];
    CU_ASSERT(stats.steps < 100 || counts[4] + counts[6] + counts[7] > 0);
    SPH_TEST_OK(context, sph_mesh_read_nodes(r->mesh, at, 2 * nodes));
    SPH_TEST_OK(context, sph_flip_read_pressure(r->w.flow, at + 2 * nodes, nodes));
    at += 3 * nodes;
    SPH_TEST_OK(context, sph_flip_read_cells(r->w.flow, at, at + cells, cells));
    at += 3 * cells;
  }
  *size = (size_t)(at - all) * sizeof *all;
  return all;
}

static double last_sample(const run *r) {
  double value = NAN;
  SPH_TEST_OK(r->w.context, sph_probe_last(r->probe, &value));
  return value;
}

static bool same(const double *a, size_t size_a, const double *b, size_t size_b) {
  return size_a == size_b && memcmp(a, b, size_a) == 0;
}

/* A run that goes on, one on new handles, and one that goes back give the same bits. */
static void goes_on(plan is, int before, int after) {
  size_t size[3], then[2];
  is.threads = 1;
  run a = make(is);
  paint(&a);
  flow_steps(&a.w, before);
  write_checkpoint(&a);
  double *written = look(&a, &then[0]);
  flow_steps(&a.w, after);
  double *expected = look(&a, &size[0]);
  const double sample = last_sample(&a);
  for (int threads = 1; threads <= 2; threads++) {
    is.threads = threads;
    run b = make(is);
    if (threads == 2) flow_steps(&b.w, 3); /* of something else */
    read_checkpoint(&b);
    double *read = look(&b, &then[1]);
    CU_ASSERT(same(written, then[0], read, then[1]));
    flow_steps(&b.w, after);
    double *found = look(&b, &size[1]);
    CU_ASSERT(same(expected, size[0], found, size[1]));
    CU_ASSERT_EQUAL(sample, last_sample(&b));
    free(read);
    free(found);
    end(&b);
  }
  flow_steps(&a.w, 7);
  read_checkpoint(&a);
  flow_steps(&a.w, after);
  double *again = look(&a, &size[2]);
  CU_ASSERT(same(expected, size[0], again, size[2]));
  CU_ASSERT_EQUAL(sample, last_sample(&a));
  free(written);
  free(expected);
  free(again);
  end(&a);
  remove(path);
}

static void wcsph_goes_on(void) {
  for (int stepper = SPH_STEPPER_SYMPLECTIC; stepper <= SPH_STEPPER_RK4; stepper++) {
    goes_on((plan){.method = 'w', .around = FLUME, .stepper = (sph_stepper)stepper}, 150, 150);
    goes_on((plan){.method = 'w', .around = PERIODIC, .stepper = (sph_stepper)stepper}, 40, 60);
    goes_on((plan){.method = 'w', .dim = 3, .around = BOX, .stepper = (sph_stepper)stepper}, 30,
            30);
  }
  goes_on((plan){.method = 'w', .around = FLUME, .is_double = true, .tait = true}, 60, 60);
  goes_on((plan){.method = 'w', .around = FLUME, .flap = true}, 100, 100);
  goes_on((plan){.method = 'w', .around = FLUME, .stepper = SPH_STEPPER_VERLET}, 0, 40);
}

static void isph_goes_on(void) {
  goes_on((plan){.method = 'i', .around = FLUME}, 60, 60);
  goes_on((plan){.method = 'i', .around = FLUME, .is_double = true}, 1, 30);
  goes_on((plan){.method = 'i', .around = FLUME, .flap = true}, 30, 30);
  goes_on((plan){.method = 'i', .around = FLUME, .dummies = true}, 30, 30);
  goes_on((plan){.method = 'i', .around = PERIODIC}, 20, 20);
  goes_on((plan){.method = 'i', .dim = 3, .around = BOX}, 10, 15);
}

static void flip_goes_on(void) {
  goes_on((plan){.method = 'f'}, 80, 80);
  goes_on((plan){.method = 'f'}, 0, 20);
}

/* ---- files that are not what they should be ---- */

static unsigned char *load(size_t *size) {
  FILE *file = fopen(path, "rb");
  CU_ASSERT_FATAL(file != NULL);
  fseek(file, 0, SEEK_END);
  *size = (size_t)ftell(file);
  rewind(file);
  unsigned char *data = malloc(*size + 8);
  CU_ASSERT_FATAL(data != NULL && fread(data, 1, *size, file) == *size);
  fclose(file);
  return data;
}

static void store(const unsigned char *data, size_t size) {
  FILE *file = fopen(path, "wb");
  CU_ASSERT_FATAL(file != NULL && fwrite(data, 1, size, file) == size);
  fclose(file);
}

/* With a checksum that is right. */
static void store_summed(unsigned char *data, size_t size) {
  uint64_t sum = 0xcbf29ce484222325u, word;
  for (size_t at = 0; at + 8 < size; at += 8) {
    memcpy(&word, data + at, 8);
    sum = (sum ^ word) * 0x100000001b3u;
    sum ^= sum >> 32;
  }
  memcpy(data + size - 8, &sum, 8);
  store(data, size);
}

/* Where a section begins: its name, then at 80 its type, at 88 its count, at 96 its numbers. */
static size_t find(const unsigned char *data, size_t size, const char *name) {
  for (size_t at = 24; at + 96 < size; at += 8)
    if (memcmp(data + at, name, strlen(name) + 1) == 0) return at;
  printf("\nno section %s", name);
  CU_FAIL_FATAL("section");
  return 0;
}

static run small_run(void) {
  run r = make((plan){.method = 'w', .dim = 3, .around = BOX, .threads = 1});
  const int64_t n = sph_particles_count(r.w.water) - 12;
  int64_t *ids = calloc((size_t)n, sizeof *ids);
  for (int64_t k = 0; k < n; k++) ids[k] = k < 6 ? k : k + 6;
  SPH_TEST_OK(r.w.context, sph_particles_remove(r.w.water, n, ids));
  free(ids);
  flow_steps(&r.w, 2);
  return r;
}

static void damage_is_found(void) {
  run a = small_run();
  size_t size, looked[2];
  write_checkpoint(&a);
  unsigned char *data = load(&size);
  flow_steps(&a.w, 3);
  double *before = look(&a, &looked[0]);
  int wrong = 0;
  for (size_t at = 0; at < size; at++) {
    store(data, at);
    wrong += sph_integrator_read_checkpoint(a.w.flow, path) != SPH_E_IO;
  }
  CU_ASSERT_EQUAL(wrong, 0);
  for (size_t at = 0; at < size; at++) {
    data[at] ^= (unsigned char)(1u << at % 8);
    store(data, size);
    wrong += sph_integrator_read_checkpoint(a.w.flow, path) != SPH_E_IO;
    data[at] ^= (unsigned char)(1u << at % 8);
  }
  CU_ASSERT_EQUAL(wrong, 0);
  CU_ASSERT(strstr(sph_context_message(a.w.context), "checksum") != NULL);
  double *after = look(&a, &looked[1]);
  CU_ASSERT(same(before, looked[0], after, looked[1]));
  free(after);
  flow_steps(&a.w, 3);
  after = look(&a, &looked[1]);
  /* Another run that nobody asked to read anything. */
  run b = small_run();
  write_checkpoint(&b);
  flow_steps(&b.w, 6);
  free(before);
  before = look(&b, &looked[0]);
  CU_ASSERT(same(before, looked[0], after, looked[1]));
  free(before);
  free(after);
  free(data);
  end(&a);
  end(&b);
}

/* A file with 8 bytes changed, and its checksum with them, is refused with this text. */
static void refuse(run *r, const unsigned char *data, size_t size, size_t at, const void *bytes,
                   sph_status status, const char *text) {
  unsigned char *copy = malloc(size);
  memcpy(copy, data, size);
  memcpy(copy + at, bytes, 8);
  store_summed(copy, size);
  free(copy);
  SPH_TEST_STATUS(r->w.context, sph_integrator_read_checkpoint(r->w.flow, path), status, text);
}

static void refuse_whole(run *r, const unsigned char *data, size_t size, size_t at, int64_t value,
                         sph_status status, const char *text) {
  refuse(r, data, size, at, &value, status, text);
}

static void refuse_real(run *r, const unsigned char *data, size_t size, size_t at, double value,
                        sph_status status, const char *text) {
  refuse(r, data, size, at, &value, status, text);
}

static void forgeries_are_refused(void) {
  run a = small_run();
  size_t size, looked[2];
  write_checkpoint(&a);
  unsigned char *d = load(&size);
  double *before = look(&a, &looked[0]);
  refuse(&a, d, size, 0, "SPHKEEQ", SPH_E_IO, "does not begin as one");
  refuse(&a, d, size, 8, "\0\0\0\0\0\0\0\1", SPH_E_IO, "other byte order");
  refuse_whole(&a, d, size, 8, 7, SPH_E_IO, "mark of the byte order is 7");
  refuse_whole(&a, d, size, 16, 2, SPH_E_IO, "has version 2, this library reads 1");
  refuse(&a, d, size, 24, "\0\0\0\0\0\0\0\0", SPH_E_IO, "section 0, at byte 24, has no name");
  refuse(&a, d, size, 24, "method/x", SPH_E_ARGUMENT, "no section \"method/wcsph\"");
  const size_t counts = find(d, size, "particles/counts"), v = find(d, size, "field/velocity/0");
  refuse_whole(&a, d, size, v + 80, 9, SPH_E_IO, "\"field/velocity/0\" has the unknown type 9");
  refuse_whole(&a, d, size, v + 80, 2, SPH_E_ARGUMENT, "no section \"field/velocity/0\"");
  static const int64_t many[] = {INT64_MAX, INT64_MIN, -1,        1 << 30,
                                 1ll << 61, 1ll << 32, 1ll << 62, 100000};
  for (size_t k = 0; k < sizeof many / sizeof many[0]; k++)
    refuse_whole(&a, d, size, v + 88, many[k], SPH_E_IO, "goes beyond the end of the file");
  refuse_whole(&a, d, size, v + 88, 0, SPH_E_IO, "no name");
  refuse_real(&a, d, size, v + 96, NAN, SPH_E_IO, "\"field/velocity/0\": number 0 is not finite");
  refuse_whole(&a, d, size, counts + 96, 11, SPH_E_ARGUMENT, "has 12 numbers, the flow wants 11");
  refuse_whole(&a, d, size, counts + 96, 0, SPH_E_ARGUMENT, "\"particles/counts\": 0 particles");
  refuse_whole(&a, d, size, counts + 96, INT64_MAX, SPH_E_ARGUMENT, "particles");
  refuse_whole(&a, d, size, counts + 104, 3, SPH_E_ARGUMENT, "\"particles/id\"");
  const size_t rank = find(d, size, "particles/rank"), id = find(d, size, "particles/id");
  refuse_whole(&a, d, size, rank + 96, 0, SPH_E_ARGUMENT, "\"particles/rank\"");
  refuse_whole(&a, d, size, rank + 96, -1, SPH_E_ARGUMENT, "\"particles/rank\": -1 at 0");
  refuse_whole(&a, d, size, id + 96, 1 << 20, SPH_E_ARGUMENT, "\"particles/id\"");
  refuse_real(&a, d, size, find(d, size, "field/density") + 96, 0, SPH_E_ARGUMENT,
              "\"field/density\": 0 at 0 must be > 0");
  refuse_real(&a, d, size, find(d, size, "particles/spacing") + 96, 0.5, SPH_E_ARGUMENT,
              "\"particles/spacing\" is 0.5, that of the flow is 0.025");
  refuse_real(&a, d, size, find(d, size, "boundary/walls") + 96, 4, SPH_E_ARGUMENT,
              "\"boundary/walls\" is 4, that of the flow is 1");
  const size_t which = find(d, size, "ghosts/which");
  refuse_whole(&a, d, size, which + 96, -1, SPH_E_ARGUMENT, "\"ghosts/which\": ghost -1");
  refuse_whole(&a, d, size, which + 96, INT32_MAX, SPH_E_ARGUMENT, "\"ghosts/which\": ghost 2147");
  double *after = look(&a, &looked[1]);
  CU_ASSERT(same(before, looked[0], after, looked[1]));
  store(d, size);
  read_checkpoint(&a);
  free(before);
  free(after);
  free(d);
  end(&a);
}

static void forged_cells_are_refused(void) {
  run a = make((plan){.method = 'f', .threads = 1});
  size_t size;
  flow_steps(&a.w, 2);
  write_checkpoint(&a);
  unsigned char *d = load(&size);
  const size_t cell = find(d, size, "field/cell") + 96, paddle = find(d, size, "mesh/paddle") + 96;
  static const double wrong[] = {-1, 0.5, 1e9};
  for (int k = 0; k < 3; k++)
    refuse_real(&a, d, size, cell, wrong[k], SPH_E_ARGUMENT, "\"field/cell\"");
  refuse_real(&a, d, size, paddle, 5, SPH_E_ARGUMENT, "the paddle at 5 m folds cells");
  store(d, size);
  read_checkpoint(&a);
  flow_steps(&a.w, 2);
  free(d);
  end(&a);
}

static void other_flows_are_refused(void) {
  const struct {
    plan of;
    const char *text;
  } others[] = {
      {{.method = 'i', .around = FLUME}, "no section \"method/isph\""},
      {{.method = 'f'}, "no section \"method/flip\""},
      {{.method = 'w', .dim = 3, .around = BOX}, "\"particles/dim\" is 2, that of the flow is 3"},
      {{.method = 'w', .around = BOX}, "\"boundary/walls\" is 3, that of the flow is 1"},
      {{.method = 'w', .around = PERIODIC}, "number 0 of \"cloud/periods\" is 0"},
      {{.method = 'w', .around = OPEN}, "\"cloud/boundaries\" is 1"},
      {{.method = 'w', .around = FLUME, .no_field = true}, "section \"field/dye\""}};
  run a = make((plan){.method = 'w', .around = FLUME, .threads = 1});
  flow_steps(&a.w, 2);
  write_checkpoint(&a);
  for (size_t k = 0; k < sizeof others / sizeof others[0]; k++) {
    run b = make(others[k].of);
    SPH_TEST_STATUS(b.w.context, sph_integrator_read_checkpoint(b.w.flow, path), SPH_E_ARGUMENT,
                    others[k].text);
    CU_ASSERT(sph_integrator_steps(b.w.flow) == 0);
    flow_steps(&b.w, 1);
    end(&b);
  }
  run b = make((plan){.method = 'w', .around = FLUME, .no_field = true});
  SPH_TEST_OK(b.w.context, sph_particles_add_field(b.w.water, "dye", 2, "1"));
  SPH_TEST_STATUS(b.w.context, sph_integrator_read_checkpoint(b.w.flow, path), SPH_E_ARGUMENT,
                  "no section \"field/dye/0\"");
  end(&b);
  end(&a);
}

static void wrong_calls_are_refused(void) {
  run a = make((plan){.method = 'w', .around = FLUME, .threads = 1});
  sph_context *context = a.w.context;
  sph_integrator *flow = a.w.flow;
  const double *lease;
  remove(path);
  CU_ASSERT(sph_integrator_write_checkpoint(NULL, path) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_integrator_read_checkpoint(NULL, path) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(context, sph_integrator_write_checkpoint(flow, NULL), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_integrator_write_checkpoint(flow, ""), SPH_E_ARGUMENT, "empty");
  SPH_TEST_STATUS(context, sph_integrator_read_checkpoint(flow, NULL), SPH_E_ARGUMENT, "NULL");
  SPH_TEST_STATUS(context, sph_integrator_read_checkpoint(flow, ""), SPH_E_ARGUMENT, "empty");
  SPH_TEST_STATUS(context, sph_integrator_read_checkpoint(flow, path), SPH_E_IO, "No such file");
  SPH_TEST_STATUS(context, sph_integrator_read_checkpoint(flow, "/tmp"), SPH_E_IO,
                  "is no plain file");
  SPH_TEST_STATUS(context, sph_integrator_write_checkpoint(flow, "/tmp/no/such/folder/file"),
                  SPH_E_IO, "No such file");
  write_checkpoint(&a);
  SPH_TEST_OK(context, sph_particles_lease_read(a.w.water, SPH_POSITION, &lease));
  SPH_TEST_STATUS(context, sph_integrator_read_checkpoint(flow, path), SPH_E_ARGUMENT,
                  "1 leases are open");
  write_checkpoint(&a); /* nobody minds */
  SPH_TEST_OK(context, sph_particles_release(a.w.water, lease));
  read_checkpoint(&a);
  end(&a);
}

/* What cannot be written leaves the checkpoint before, and nothing else. */
static void full_disks_leave_the_old_file(void) {
  run a = make((plan){.method = 'w', .around = FLUME, .threads = 1});
  char temporary[80];
  size_t size, then;
  struct rlimit limit, before;
  snprintf(temporary, sizeof temporary, "%s.tmp", path);
  write_checkpoint(&a);
  unsigned char *old = load(&size);
  flow_steps(&a.w, 5);
  CU_ASSERT_FATAL(getrlimit(RLIMIT_FSIZE, &before) == 0);
  limit = before;
  limit.rlim_cur = size / 2;
  void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
  CU_ASSERT_FATAL(setrlimit(RLIMIT_FSIZE, &limit) == 0);
  const sph_status status = sph_integrator_write_checkpoint(a.w.flow, path);
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, handler);
  CU_ASSERT_EQUAL(status, SPH_E_IO);
  CU_ASSERT(access(temporary, F_OK) != 0);
  unsigned char *now = load(&then);
  CU_ASSERT(then == size && memcmp(old, now, size) == 0);
  write_checkpoint(&a);
  CU_ASSERT(access(temporary, F_OK) != 0);
  free(old);
  free(now);
  end(&a);
}

/* Reading and writing without memory changes nothing, and leaks nothing. */
static void no_memory_changes_nothing(void) {
  static const plan plans[] = {
      {.method = 'w', .around = FLUME}, {.method = 'i', .around = FLUME}, {.method = 'f'}};
  for (int p = 0; p < 3; p++) {
    plan is = plans[p];
    is.threads = 1;
    run a = make(is);
    size_t size[2];
    flow_steps(&a.w, 3);
    write_checkpoint(&a);
    flow_steps(&a.w, 3);
    double *expected = look(&a, &size[0]);
    end(&a);
    bool done = false;
    for (int allowed = 0; allowed < 400 && !done; allowed++) {
      sph_test_memory memory = {1 << 30, 0};
      const sph_allocator allocator = {sph_test_allocate, sph_test_release, &memory};
      run b = make_with(is, &allocator);
      memory.allowed = allowed;
      sph_status status = sph_integrator_read_checkpoint(b.w.flow, path);
      memory.allowed = 1 << 30;
      CU_ASSERT(status == SPH_OK || status == SPH_E_MEMORY);
      CU_ASSERT(status == SPH_OK || sph_integrator_steps(b.w.flow) == 0);
      done = status == SPH_OK;
      if (!done) read_checkpoint(&b);
      if (done || allowed % 16 == 0) {
        flow_steps(&b.w, 3);
        double *found = look(&b, &size[1]);
        CU_ASSERT(same(expected, size[0], found, size[1]));
        free(found);
        char elsewhere[80];
        snprintf(elsewhere, sizeof elsewhere, "%s_b", path);
        memory.allowed = 2;
        status = sph_integrator_write_checkpoint(b.w.flow, elsewhere);
        memory.allowed = 1 << 30;
        CU_ASSERT_EQUAL(status, SPH_E_MEMORY);
        CU_ASSERT(access(elsewhere, F_OK) != 0);
      }
      end(&b);
      CU_ASSERT_EQUAL(memory.live, 0);
    }
    CU_ASSERT(done);
    free(expected);
  }
}

/* NaN is not worth keeping: the checkpoint before stays. */
static void diverged_runs_are_not_written(void) {
  run a = make((plan){.method = 'w', .around = FLUME, .threads = 1});
  flow_steps(&a.w, 2);
  write_checkpoint(&a);
  double *v = flow_read(&a.w, SPH_VELOCITY);
  v[8] = 1e200;
  flow_write(&a.w, SPH_VELOCITY, v);
  CU_ASSERT(sph_integrator_step(a.w.flow) == SPH_E_DIVERGED);
  CU_ASSERT(sph_integrator_write_checkpoint(a.w.flow, path) != SPH_OK);
  read_checkpoint(&a);
  flow_steps(&a.w, 5);
  CU_ASSERT_EQUAL(sph_integrator_steps(a.w.flow), 7);
  free(v);
  end(&a);
}

/* Probes go on at the first time that is due; series keep what they have. */
static void probes_go_on(void) {
  run a = make((plan){.method = 'w', .around = FLUME, .threads = 1});
  double times[64];
  SPH_TEST_OK(a.w.context, sph_integrator_set_dt(a.w.flow, 1e-4));
  SPH_TEST_OK(a.w.context, sph_probe_set_interval(a.probe, 5e-4));
  flow_steps(&a.w, 10);
  write_checkpoint(&a);
  flow_steps(&a.w, 20);
  CU_ASSERT_EQUAL(sph_probe_count(a.probe), 6);
  read_checkpoint(&a);
  flow_steps(&a.w, 20); /* up to where it was before */
  CU_ASSERT_EQUAL(sph_probe_count(a.probe), 6);
  flow_steps(&a.w, 5);
  CU_ASSERT_EQUAL(sph_probe_count(a.probe), 7);
  SPH_TEST_OK(a.w.context, sph_probe_read(a.probe, 0, 7, times, NULL));
  for (int k = 0; k < 7; k++) SPH_TEST_CLOSE(times[k], 5e-4 * (k + 1), 1e-9, 0);
  end(&a);
  run b = make((plan){.method = 'w', .around = FLUME, .threads = 1});
  SPH_TEST_OK(b.w.context, sph_integrator_set_dt(b.w.flow, 1e-4));
  SPH_TEST_OK(b.w.context, sph_probe_set_interval(b.probe, 5e-4));
  read_checkpoint(&b);
  flow_steps(&b.w, 5);
  CU_ASSERT_EQUAL(sph_probe_count(b.probe), 2);
  SPH_TEST_OK(b.w.context, sph_probe_read(b.probe, 0, 2, times, NULL));
  SPH_TEST_CLOSE(times[0], 1.1e-3, 1e-9, 0); /* the first one after, then as due */
  SPH_TEST_CLOSE(times[1], 1.5e-3, 1e-9, 0);
  end(&b);
}

int main(void) {
  const sph_test tests[] = {{"wcsph goes on with the same bits", wcsph_goes_on},
                            {"isph goes on with the same bits", isph_goes_on},
                            {"particles with a mesh go on with the same bits", flip_goes_on},
                            {"every byte that lacks or is another is found", damage_is_found},
                            {"forged files are refused", forgeries_are_refused},
                            {"forged cells are refused", forged_cells_are_refused},
                            {"files of other flows are refused", other_flows_are_refused},
                            {"wrong calls are refused", wrong_calls_are_refused},
                            {"full disks leave the old file", full_disks_leave_the_old_file},
                            {"no memory changes nothing", no_memory_changes_nothing},
                            {"diverged runs are not written", diverged_runs_are_not_written},
                            {"probes go on", probes_go_on}};
  snprintf(path, sizeof path, "/tmp/sph_t69_%ld", (long)getpid());
  const int failed = sph_test_main("checkpoint", (int)(sizeof tests / sizeof tests[0]), tests);
  remove(path);
  return failed;
}
