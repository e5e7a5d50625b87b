/* A mass on a spring, exact for a constant force between the events of its motion. */
#include "body/body_impl.h"

struct sph_body {
  sph_context *context;
  int references;
  bool moves_wall;
  double mass, stiffness, rest, damping, friction_at_rest, friction;
  double threshold, lower, upper;
  sph_threshold kind;
  sph_body_rule rule;
  double x, v, a, force;
  double added, carried; /* mass of the fluid that it moves, and the force on that [N] */
};

sph_status sph_body_create(sph_context *context, double mass, sph_body **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "body: out is NULL");
  SPH_CHECK(context, isfinite(mass) && mass > 0, SPH_E_ARGUMENT,
            "body: mass must be > 0 kg, got %g", mass);
  sph_body *body = SPHI_NEW(context, 1, sph_body);
  SPH_CHECK(context, body, SPH_E_MEMORY, "body: no memory");
  sphi_context_retain(context);
  body->context = context;
  body->references = 1;
  body->mass = mass;
  body->lower = -HUGE_VAL;
  body->upper = HUGE_VAL;
  *out = body;
  return SPH_OK;
}

void sph_body_destroy(sph_body **body) {
  if (!body || !*body) return;
  sph_body *dead = *body;
  *body = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sphi_body_take(sph_body *body, const sph_context *context, const char *wall) {
  SPH_CHECK(body->context, body->context == context, SPH_E_ARGUMENT,
            "wall \"%s\": the body is of another context", wall);
  SPH_CHECK(body->context, !body->moves_wall, SPH_E_ARGUMENT,
            "wall \"%s\": the body moves another wall already", wall);
  body->moves_wall = true;
  body->references++;
  return SPH_OK;
}

static sph_status check_size(const sph_body *body, const char *what, const char *unit,
                             double value) {
  SPH_CHECK(body->context, isfinite(value) && value >= 0, SPH_E_ARGUMENT,
            "body: %s must be >= 0 %s, got %g", what, unit, value);
  return SPH_OK;
}

static sph_status check_number(const sph_body *body, const char *what, double value) {
  SPH_CHECK(body->context, isfinite(value), SPH_E_ARGUMENT, "body: %s must be finite, got %g", what,
            value);
  return SPH_OK;
}

sph_status sph_body_set_spring(sph_body *body, double stiffness, double rest) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_TRY(check_size(body, "stiffness", "N/m", stiffness));
  SPH_TRY(check_number(body, "rest", rest));
  body->stiffness = stiffness;
  body->rest = rest;
  return SPH_OK;
}

sph_status sph_body_set_damping(sph_body *body, double damping) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_TRY(check_size(body, "damping", "N s/m", damping));
  body->damping = damping;
  return SPH_OK;
}

sph_status sph_body_set_friction(sph_body *body, double at_rest, double kinetic) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_TRY(check_size(body, "kinetic friction", "N", kinetic));
  SPH_TRY(check_number(body, "friction at rest", at_rest));
  SPH_CHECK(body->context, at_rest >= kinetic, SPH_E_ARGUMENT,
            "body: friction at rest must be at least the kinetic %g N, got %g", kinetic, at_rest);
  body->friction_at_rest = at_rest;
  body->friction = kinetic;
  return SPH_OK;
}

sph_status sph_body_set_threshold(sph_body *body, double force, sph_threshold kind) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_TRY(check_size(body, "threshold", "N", force));
  SPH_CHECK(body->context, kind == SPH_THRESHOLD_PRELOAD || kind == SPH_THRESHOLD_RELEASE,
            SPH_E_ARGUMENT,
            "body: threshold must be SPH_THRESHOLD_PRELOAD (0) or _RELEASE (1), got %d", (int)kind);
  body->threshold = force;
  body->kind = kind;
  return SPH_OK;
}

sph_status sph_body_set_stops(sph_body *body, double lower, double upper) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_CHECK(body->context, lower < upper, SPH_E_ARGUMENT,
            "body: lower stop must be below the upper, got %g and %g m", lower, upper);
  SPH_CHECK(body->context, body->x >= lower && body->x <= upper, SPH_E_ARGUMENT,
            "body: it is at %g m, not between stops at %g and %g m", body->x, lower, upper);
  body->lower = lower;
  body->upper = upper;
  return SPH_OK;
}

sph_status sph_body_set_rule(sph_body *body, sph_body_rule rule) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_CHECK(body->context, rule == SPH_BODY_CONSISTENT || rule == SPH_BODY_AS_PRINTED,
            SPH_E_ARGUMENT, "body: rule must be SPH_BODY_CONSISTENT (0) or _AS_PRINTED (1), got %d",
            (int)rule);
  body->rule = rule;
  return SPH_OK;
}

sph_status sph_body_set_state(sph_body *body, double displacement, double velocity) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_CHECK(body->context, !body->moves_wall, SPH_E_ARGUMENT,
            "body: it moves a wall, put it somewhere before");
  SPH_TRY(check_number(body, "displacement", displacement));
  SPH_TRY(check_number(body, "velocity", velocity));
  SPH_CHECK(body->context, displacement >= body->lower && displacement <= body->upper,
            SPH_E_ARGUMENT, "body: displacement %g m is not between its stops at %g and %g m",
            displacement, body->lower, body->upper);
  body->x = displacement;
  body->v = velocity;
  body->a = 0;
  return SPH_OK;
}

sph_status sph_body_get_state(const sph_body *body, double *displacement, double *velocity,
                              double *acceleration, double *force) {
  if (!body) return SPH_E_ARGUMENT;
  if (displacement) *displacement = body->x;
  if (velocity) *velocity = body->v;
  if (acceleration) *acceleration = body->a;
  if (force) *force = body->force;
  return SPH_OK;
}

/* The force that counts, (2)-(3) of sph/body.h, for a body that moves or is at rest. */
static double counted(const sph_body *body, double force, bool at_rest) {
  const double excess = force - body->threshold;
  if (body->kind == SPH_THRESHOLD_PRELOAD) /* without a threshold suction counts too */
    return body->threshold > 0 && excess < 0 ? 0 : excess;
  const double hold = body->stiffness * (body->lower - body->rest);
  return at_rest && body->x <= body->lower && excess <= hold ? fmin(force, hold) : force;
}

/* Whether a body without velocity stays where it is under the sum of all forces but friction. */
static bool is_held(const sph_body *body, double sum) {
  return (body->x <= body->lower && sum <= 0) || (body->x >= body->upper && sum >= 0) ||
         fabs(sum) <= body->friction_at_rest;
}

/* A free piece of motion from x, v with acceleration a0 = x''(0) + 2 gamma v under a constant force:
 *
 *   x(t) = x + v G(t) + a0 int_0^t G,   v(t) = v G'(t) + a0 G(t)
 *   G'' = -2 gamma G' - omega2 G,  G(0) = 0,  G'(0) = 1,  by its power series. */
typedef struct piece {
  double x, v, a0, two_gamma, omega2;
} piece;

static void piece_at(const piece *p, double t, double *x, double *v) {
  double before = 0, term = 1; /* coefficients of t^n and t^(n+1) in G times those powers over t */
  double g = 0, slope = 0, integral = 0;
  for (int n = 0; n < 40; n++) {
    g += term * t;
    slope += (n + 1) * term;
    integral += term * t * t / (n + 2);
    const double next = -(p->two_gamma * t * (n + 1) * term + p->omega2 * t * t * before) /
                        ((double)(n + 1) * (n + 2));
    before = term;
    term = next;
    if (fabs(term) + fabs(before) < 1e-18) break;
  }
  *x = p->x + p->v * g + p->a0 * integral;
  *v = p->v * slope + p->a0 * g;
}

/* Time in (0, t] at which the velocity (or x - stop) has changed its sign. */
static double find_event(const piece *p, double t, bool of_place, double stop) {
  double lo = 0, hi = t, x, v;
  piece_at(p, t, &x, &v);
  const bool end = (of_place ? x - stop : v) > 0;
  for (int k = 0; k < 80 && lo < hi; k++) {
    const double middle = 0.5 * (lo + hi);
    if (middle <= lo || middle >= hi) break;
    piece_at(p, middle, &x, &v);
    if (((of_place ? x - stop : v) > 0) == end)
      hi = middle;
    else
      lo = middle;
  }
  return hi;
}

/* Moves on to the next event, or by dt; returns the time that took. */
static double move_on(sph_body *body, double force, double dt) {
  const bool at_rest = body->v == 0;
  const double pull =
      counted(body, force, at_rest) + body->carried - body->stiffness * (body->x - body->rest);
  const double mass = body->mass + body->added;
  double sum = pull;
  if (at_rest && is_held(body, pull)) {
    body->a = 0;
    return dt;
  }
  const double way = at_rest ? pull : body->v;
  sum -= way > 0 ? body->friction : -body->friction;
  const piece p = {body->x, body->v, sum / mass, body->damping / mass, body->stiffness / mass};
  double x, v, stop = HUGE_VAL;
  bool turns = false;
  piece_at(&p, dt, &x, &v);
  if (!at_rest && v * body->v <= 0) { /* up to there it moves one way */
    dt = find_event(&p, dt, false, 0);
    piece_at(&p, dt, &x, &v);
    turns = true;
  }
  if (x < body->lower) stop = body->lower;
  if (x > body->upper) stop = body->upper;
  if (stop < HUGE_VAL) {
    dt = body->x == stop ? 0 : find_event(&p, dt, true, stop);
    x = stop;
  }
  body->x = x;
  body->v = turns || stop < HUGE_VAL ? 0 : v;
  body->a = stop < HUGE_VAL ? 0 : p.a0 - p.two_gamma * v - p.omega2 * (x - p.x);
  return dt;
}

static void step_as_printed(sph_body *body, double force, double dt) {
  const double sum = counted(body, force, body->x <= body->lower) -
                     body->stiffness * (body->x - body->rest) - body->damping * body->v +
                     body->carried;
  body->a = sum / (body->mass + body->added);
  body->v += dt * body->a;
  body->x = fmax(body->x + dt * body->v, body->lower);
}

void sphi_body_add_mass(sph_body *body, double mass) { body->added = mass; }

sph_status sph_body_advance(sph_body *body, double force, double dt) {
  if (!body) return SPH_E_ARGUMENT;
  SPH_TRY(check_number(body, "force", force));
  SPH_TRY(check_size(body, "dt", "s", dt));
  SPH_CHECK(body->context, body->kind != SPH_THRESHOLD_RELEASE || isfinite(body->lower),
            SPH_E_ARGUMENT, "body: a threshold that releases it wants a lower stop");
  const double fast =
      fmax(sqrt(body->stiffness / body->mass), body->damping / body->mass); /* 1/s */
  SPH_CHECK(body->context, dt * fast <= 1e6, SPH_E_ARGUMENT,
            "body: dt %g s is more than 10^6 times its own time of %g s", dt, 1 / fast);
  const sph_body before = *body;
  body->carried = body->added * body->a;
  if (body->rule == SPH_BODY_AS_PRINTED) {
    step_as_printed(body, force, dt);
  } else {
    /* Pieces of half a radian at most have one turn at most. Two events that take no time leave a body
     * that chatters at a stop where it is. */
    double left = dt;
    for (int idle = 0; left > 0 && idle < 3;) {
      const double part = fast > 0 ? fmin(left, 0.5 / fast) : left;
      const double took = move_on(body, force, part);
      idle = took > 0 ? 0 : idle + 1;
      left = took < left ? left - took : 0;
    }
  }
  body->force = force;
  if (isfinite(body->x) && isfinite(body->v) && isfinite(body->a)) return SPH_OK;
  const double x = body->x;
  *body = before;
  return SPHI_ERROR(body->context, SPH_E_DIVERGED,
                    "body: a force of %g N for %g s takes it from %g to %g m", force, dt, before.x,
                    x);
}

sph_status sphi_body_keep(sph_body *body, const char *name, sphi_keep *keep) {
  double *const state[] = {&body->x,     &body->v,     &body->a,
                           &body->force, &body->added, &body->carried};
  return sphi_keep_reals(keep, name, sizeof state / sizeof state[0], state);
}
