/* Paddles as handles: creation, settings, evaluation. */
#include "paddle/paddle_impl.h"
#include "paddle/paddle_list.h"

#define ROW_AGREES(id, enumerator, stem, name, summary, source) \
  _Static_assert(SPH_PADDLE_##enumerator == (id), "paddle.h and paddle_list.h disagree on " name);
SPHI_PADDLE_LIST(ROW_AGREES)
#undef ROW_AGREES

#define COUNT_ROW(id, enumerator, stem, name, summary, source) +1
#define ADD_ID(id, enumerator, stem, name, summary, source) +(id)
enum { LAWS = 0 SPHI_PADDLE_LIST(COUNT_ROW), IDS = 0 SPHI_PADDLE_LIST(ADD_ID) };
#undef COUNT_ROW
#undef ADD_ID
_Static_assert(2 * IDS == LAWS * (LAWS + 1), "the ids run from 1 without gaps");

#define ROW_NAME(id, enumerator, stem, name, summary, source) name,
#define ROW_SUMMARY(id, enumerator, stem, name, summary, source) summary,
#define ROW_SOURCE(id, enumerator, stem, name, summary, source) source,
static const char *const names[] = {SPHI_PADDLE_LIST(ROW_NAME)};
static const char *const summaries[] = {SPHI_PADDLE_LIST(ROW_SUMMARY)};
static const char *const sources[] = {SPHI_PADDLE_LIST(ROW_SOURCE)};

static bool known(int type) { return type >= 1 && type <= LAWS; }

int sph_paddle_type_count(void) { return LAWS; }

const char *sph_paddle_type_name(sph_paddle_type type) {
  return known((int)type) ? names[(int)type - 1] : "unknown";
}

const char *sph_paddle_type_summary(sph_paddle_type type) {
  return known((int)type) ? summaries[(int)type - 1] : "unknown";
}

const char *sph_paddle_type_source(sph_paddle_type type) {
  return known((int)type) ? sources[(int)type - 1] : "unknown";
}

const char *sphi_paddle_name(const sphi_paddle_law *law) { return sph_paddle_type_name(law->type); }

static const char *name_of(const sph_paddle *paddle) { return sphi_paddle_name(paddle->law); }

sph_status sphi_paddle_new(sph_context *context, const sphi_paddle_law *law, sph_paddle **out) {
  sph_paddle *paddle = SPHI_NEW(context, 1, sph_paddle);
  void *data = paddle ? sphi_alloc(context, 1, law->size) : NULL;
  if (!data) {
    sphi_free(context, paddle);
    return SPHI_ERROR(context, SPH_E_MEMORY, "paddle \"%s\": out of memory", sphi_paddle_name(law));
  }
  *paddle = (sph_paddle){.context = context, .law = law, .data = data, .duration = INFINITY};
  sphi_context_retain(context);
  *out = paddle;
  return SPH_OK;
}

void sph_paddle_destroy(sph_paddle **paddle) {
  if (!paddle || !*paddle) return;
  sph_paddle *dead = *paddle;
  *paddle = NULL;
  sph_context *context = dead->context;
  if (dead->law->release) dead->law->release(dead);
  sphi_free(context, dead->data);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sphi_paddle_check_positive(sph_context *context, const sphi_paddle_law *law, int count,
                                      const sphi_paddle_value *values) {
  for (int k = 0; k < count; k++)
    SPH_CHECK(context, isfinite(values[k].value) && values[k].value > 0, SPH_E_ARGUMENT,
              "paddle \"%s\": %s must be > 0 %s, got %g", sphi_paddle_name(law), values[k].name,
              values[k].unit, values[k].value);
  return SPH_OK;
}

/* ---------------------------------------------------------------------------------- settings */

sph_status sph_paddle_set_start(sph_paddle *paddle, double start_time) {
  if (!paddle) return SPH_E_ARGUMENT;
  SPH_CHECK(paddle->context, isfinite(paddle->start), SPH_E_TYPE,
            "paddle \"%s\": the caller's function has no start to be set", name_of(paddle));
  SPH_CHECK(paddle->context, isfinite(start_time), SPH_E_ARGUMENT,
            "paddle \"%s\": start time must be finite, got %g s", name_of(paddle), start_time);
  paddle->start = start_time;
  return SPH_OK;
}

sph_status sph_paddle_set_ramp(sph_paddle *paddle, double duration) {
  if (!paddle) return SPH_E_ARGUMENT;
  sphi_sum *sum = sphi_sum_of(paddle);
  SPH_CHECK(paddle->context, sum, SPH_E_TYPE,
            "paddle \"%s\": only regular, irregular and focused waves have a ramp",
            name_of(paddle));
  SPH_CHECK(paddle->context, isfinite(duration) && duration > 0, SPH_E_ARGUMENT,
            "paddle \"%s\": ramp must be > 0 s, got %g", name_of(paddle), duration);
  sum->ramp = duration;
  return SPH_OK;
}

sph_status sph_paddle_set_depth(sph_paddle *paddle, double depth) {
  if (!paddle) return SPH_E_ARGUMENT;
  SPH_CHECK(paddle->context, !paddle->law->reshape, SPH_E_TYPE,
            "paddle \"%s\": its waves have a depth already, %g m", name_of(paddle), paddle->depth);
  const sphi_paddle_value value = {"depth", "m", depth};
  SPH_TRY(sphi_paddle_check_positive(paddle->context, paddle->law, 1, &value));
  SPH_CHECK(paddle->context, !paddle->flap || depth > paddle->hinge, SPH_E_ARGUMENT,
            "paddle \"%s\": depth must be above the flap's hinge at %g m, got %g m",
            name_of(paddle), paddle->hinge, depth);
  paddle->depth = depth;
  return SPH_OK;
}

sph_status sph_paddle_set_flap(sph_paddle *paddle, double hinge_height) {
  if (!paddle) return SPH_E_ARGUMENT;
  SPH_CHECK(paddle->context, paddle->depth > 0, SPH_E_ARGUMENT,
            "paddle \"%s\": a flap needs the depth; call sph_paddle_set_depth() first",
            name_of(paddle));
  SPH_CHECK(paddle->context, isfinite(hinge_height) && hinge_height < paddle->depth, SPH_E_ARGUMENT,
            "paddle \"%s\": hinge height must be below the depth of %g m, got %g m",
            name_of(paddle), paddle->depth, hinge_height);
  if (paddle->law->reshape) SPH_TRY(paddle->law->reshape(paddle, hinge_height));
  paddle->flap = true;
  paddle->hinge = hinge_height;
  return SPH_OK;
}

/* -------------------------------------------------------------------------------- evaluation */

static void motion_at(const sph_paddle *paddle, double t, double *motion) {
  const double since = isfinite(paddle->start) ? t - paddle->start : t;
  motion[0] = motion[1] = motion[2] = 0;
  if (isfinite(paddle->start) && since <= 0)
    motion[0] = paddle->before;
  else if (since >= paddle->duration)
    motion[0] = paddle->after;
  else
    paddle->law->at(paddle, since, motion);
}

static sph_status checked_motion(const sph_paddle *paddle, double t, double *motion) {
  SPH_CHECK(paddle->context, isfinite(t), SPH_E_ARGUMENT,
            "paddle \"%s\": t must be finite, got %g s", name_of(paddle), t);
  motion_at(paddle, t, motion);
  static const char *const rates[] = {"displacement", "velocity", "acceleration"};
  for (int k = 0; k < 3; k++)
    SPH_CHECK(paddle->context, isfinite(motion[k]), SPH_E_ARGUMENT,
              "paddle \"%s\": %s must be finite, got %g at t = %g s", name_of(paddle), rates[k],
              motion[k], t);
  return SPH_OK;
}

sph_status sph_paddle_at(const sph_paddle *paddle, double t, double *displacement, double *velocity,
                         double *acceleration) {
  if (!paddle) return SPH_E_ARGUMENT;
  double motion[3];
  SPH_TRY(checked_motion(paddle, t, motion));
  if (displacement) *displacement = motion[0];
  if (velocity) *velocity = motion[1];
  if (acceleration) *acceleration = motion[2];
  return SPH_OK;
}

/* A flap's displacement at still water level and its rates into angles: tan(angle) = q, differentiated
 * twice. */
static void turn_motion(const sph_paddle *paddle, double *motion) {
  double q[3];
  for (int k = 0; k < 3; k++) q[k] = motion[k] / (paddle->depth - paddle->hinge);
  const double w = 1 / (1 + q[0] * q[0]);
  motion[0] = atan(q[0]);
  motion[1] = q[1] * w;
  motion[2] = (q[2] - 2 * q[0] * q[1] * q[1] * w) * w;
}

sph_status sph_paddle_angle_at(const sph_paddle *paddle, double t, double *angle, double *rate,
                               double *acceleration) {
  if (!paddle) return SPH_E_ARGUMENT;
  SPH_CHECK(paddle->context, paddle->flap, SPH_E_TYPE,
            "paddle \"%s\": a piston has no angle; call sph_paddle_set_flap() for a flap",
            name_of(paddle));
  double motion[3];
  SPH_TRY(checked_motion(paddle, t, motion));
  turn_motion(paddle, motion);
  if (angle) *angle = motion[0];
  if (rate) *rate = motion[1];
  if (acceleration) *acceleration = motion[2];
  return SPH_OK;
}

void sph_paddle_rotation(double t, double *angle, double *rate, double *acceleration, void *user) {
  const sph_paddle *paddle = user;
  double motion[3] = {NAN, NAN, NAN};
  if (paddle && paddle->flap) {
    motion_at(paddle, t, motion);
    turn_motion(paddle, motion);
  }
  *angle = -motion[0];
  *rate = -motion[1];
  *acceleration = -motion[2];
}

void sph_paddle_motion(double t, double *displacement, double *velocity, double *acceleration,
                       void *user) {
  const sph_paddle *paddle = user;
  double motion[3] = {NAN, NAN, NAN};
  if (paddle && !paddle->flap) motion_at(paddle, t, motion);
  displacement[0] = motion[0];
  velocity[0] = motion[1];
  acceleration[0] = motion[2];
}

double sph_paddle_stroke(const sph_paddle *paddle) { return paddle ? paddle->stroke : NAN; }
double sph_paddle_start(const sph_paddle *paddle) { return paddle ? paddle->start : NAN; }

double sph_paddle_end(const sph_paddle *paddle) {
  if (!paddle) return NAN;
  return isfinite(paddle->duration) ? paddle->start + paddle->duration : INFINITY;
}

int sph_paddle_get_type(const sph_paddle *paddle) { return paddle ? (int)paddle->law->type : 0; }

int sph_paddle_component_count(const sph_paddle *paddle) {
  const sphi_sum *sum = paddle ? sphi_sum_of(paddle) : NULL;
  return sum ? sum->components : 0;
}

sph_status sph_paddle_get_component(const sph_paddle *paddle, int component, double *frequency,
                                    double *wave_number, double *amplitude, double *phase,
                                    double *stroke) {
  if (!paddle) return SPH_E_ARGUMENT;
  const int count = sph_paddle_component_count(paddle);
  SPH_CHECK(paddle->context, component >= 0 && component < count, SPH_E_ARGUMENT,
            "paddle \"%s\": component must be 0 to %d, got %d", name_of(paddle), count - 1,
            component);
  const sphi_component *it = &sphi_sum_of(paddle)->component[component];
  if (frequency) *frequency = it->frequency;
  if (wave_number) *wave_number = it->wave_number;
  if (amplitude) *amplitude = it->amplitude;
  if (phase) *phase = it->phase;
  if (stroke) *stroke = it->stroke;
  return SPH_OK;
}
