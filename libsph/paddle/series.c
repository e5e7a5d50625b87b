/* Displacements at given times: a cubic spline with velocity zero at both ends. */
#include "paddle/paddle_impl.h"

typedef struct point {
  double t, x, v;
} point;

typedef struct series_data {
  int64_t n;
  point *points; /* [n], t from the first one's on */
} series_data;

/* The last interval that starts at or before t. */
static int64_t interval_of(const series_data *data, double t) {
  int64_t low = 0, high = data->n - 1;
  while (high - low > 1) {
    const int64_t middle = low + (high - low) / 2;
    if (data->points[middle].t <= t)
      low = middle;
    else
      high = middle;
  }
  return low;
}

/* Hermite's cubic on [a, b]. */
static void cubic_at(const point *a, const point *b, double t, double *motion) {
  const double h = b->t - a->t, s = (t - a->t) / h, slope = (b->x - a->x) / h;
  const double c2 = 3 * slope - 2 * a->v - b->v, c3 = a->v + b->v - 2 * slope;
  motion[0] = a->x + h * s * (a->v + s * (c2 + s * c3));
  motion[1] = a->v + s * (2 * c2 + s * 3 * c3);
  motion[2] = (2 * c2 + s * 6 * c3) / h;
}

static void spline_at(const sph_paddle *paddle, double since, double *motion) {
  const series_data *data = paddle->data;
  const int64_t k = interval_of(data, since);
  cubic_at(&data->points[k], &data->points[k + 1], since, motion);
}

static void release(sph_paddle *paddle) {
  sphi_free(paddle->context, ((series_data *)paddle->data)->points);
}

static const sphi_paddle_law series_law = {
    .type = SPH_PADDLE_SERIES, .size = sizeof(series_data), .at = spline_at, .release = release};

/* Continuous acceleration at the inner points, with h, s the intervals and slopes before and after:
 * h1 v0 + 2 (h0 + h1) v1 + h0 v2 = 3 (h1 s0 + h0 s1). Diagonally dominant: no pivots. */
static sph_status solve_velocities(sph_paddle *paddle) {
  const series_data *data = paddle->data;
  point *p = data->points;
  const int64_t n = data->n;
  double *upper = SPHI_NEW(paddle->context, n, double);
  SPH_CHECK(paddle->context, upper, SPH_E_MEMORY, "paddle \"series\": out of memory");
  for (int64_t k = 1; k < n - 1; k++) {
    const double h0 = p[k].t - p[k - 1].t, h1 = p[k + 1].t - p[k].t;
    const double left = h1 / (h0 + h1), right = h0 / (h0 + h1);
    const double slopes =
        left * ((p[k].x - p[k - 1].x) / h0) + right * ((p[k + 1].x - p[k].x) / h1);
    const double pivot = 2 - left * upper[k - 1];
    upper[k] = right / pivot;
    p[k].v = (3 * slopes - left * p[k - 1].v) / pivot;
  }
  for (int64_t k = n - 2; k > 0; k--) p[k].v -= upper[k] * p[k + 1].v;
  sphi_free(paddle->context, upper);
  return SPH_OK;
}

/* Stroke, and the largest acceleration at the points, between which it is linear. */
static sph_status survey(sph_paddle *paddle) {
  const series_data *data = paddle->data;
  double low = data->points[0].x, high = low, largest = 0, first = 0, last = 0;
  for (int64_t k = 0; k < data->n - 1; k++) {
    const point *a = &data->points[k], *b = a + 1;
    double begin[3], end[3], at[3];
    cubic_at(a, b, a->t, begin);
    cubic_at(a, b, b->t, end);
    SPH_CHECK(paddle->context, sphi_finite(3, begin) && sphi_finite(3, end), SPH_E_ARGUMENT,
              "paddle \"series\": velocity or acceleration overflows after point %lld",
              (long long)k);
    low = fmin(low, b->x);
    high = fmax(high, b->x);
    /* Where velocity is zero within, by the stable form of the quadratic's roots. */
    const double h = b->t - a->t, A = 0.5 * (end[2] - begin[2]) * h, B = begin[2] * h, C = a->v;
    const double q = -0.5 * (B + copysign(sqrt(fmax(0, B * B - 4 * A * C)), B));
    for (int j = 0; j < 2; j++) {
      const double s = j ? C / q : q / A;
      if (!(s > 0 && s < 1)) continue;
      cubic_at(a, b, a->t + s * h, at);
      low = fmin(low, at[0]);
      high = fmax(high, at[0]);
    }
    if (k == 0)
      first = fabs(begin[2]);
    else
      largest = fmax(largest, fabs(begin[2]));
    last = fabs(end[2]);
  }
  paddle->stroke = high - low;
  if (fmax(first, last) > 0.5 * largest && fmax(first, last) > 0)
    sphi_log(
        paddle->context, SPH_LOG_WARNING,
        "paddle \"series\": acceleration jumps by %g m/s^2 at the start and %g m/s^2 at the end; "
        "a series that starts and ends at rest has none",
        first, last);
  return SPH_OK;
}

static sph_status fill(sph_paddle *paddle, int64_t n, const double *t, const double *displacement) {
  series_data *data = paddle->data;
  data->points = SPHI_NEW(paddle->context, n, point);
  SPH_CHECK(paddle->context, data->points, SPH_E_MEMORY,
            "paddle \"series\": no memory for %lld points", (long long)n);
  data->n = n;
  for (int64_t k = 0; k < n; k++) data->points[k] = (point){t[k] - t[0], displacement[k], 0};
  paddle->start = t[0];
  paddle->duration = data->points[n - 1].t;
  paddle->before = displacement[0];
  paddle->after = displacement[n - 1];
  SPH_TRY(solve_velocities(paddle));
  return survey(paddle);
}

sph_status sph_paddle_create_series(sph_context *context, int64_t n, const double *t,
                                    const double *displacement, sph_paddle **out) {
  SPHI_PADDLE_BEGIN(context, series_law, out);
  SPH_CHECK(context, t && displacement, SPH_E_ARGUMENT, "paddle \"series\": %s is NULL",
            t ? "displacement" : "t");
  SPH_CHECK(context, n >= 2, SPH_E_ARGUMENT,
            "paddle \"series\": a series needs at least 2 points, got %lld", (long long)n);
  for (int64_t k = 0; k < n; k++) {
    SPH_CHECK(context, isfinite(t[k]), SPH_E_ARGUMENT,
              "paddle \"series\": time %lld must be finite, got %g s", (long long)k, t[k]);
    SPH_CHECK(context, isfinite(displacement[k]), SPH_E_ARGUMENT,
              "paddle \"series\": displacement %lld must be finite, got %g m", (long long)k,
              displacement[k]);
    SPH_CHECK(context, k == 0 || t[k] > t[k - 1], SPH_E_ARGUMENT,
              "paddle \"series\": time %lld, %.17g s, must be after time %lld, %.17g s",
              (long long)k, t[k], (long long)k - 1, k ? t[k - 1] : 0.0);
  }
  sph_paddle *paddle = NULL;
  SPH_TRY(sphi_paddle_new(context, &series_law, &paddle));
  const sph_status status = fill(paddle, n, t, displacement);
  if (status == SPH_OK)
    *out = paddle;
  else
    sph_paddle_destroy(&paddle);
  return status;
}
