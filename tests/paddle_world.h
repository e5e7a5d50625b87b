/* What the tests of paddles share: a context that keeps its warnings, evaluation, one of each law. */
#ifndef SPH_PADDLE_WORLD_H
#define SPH_PADDLE_WORLD_H

#include "sph_test.h"

#ifndef SPH_TEST_DATA
#define SPH_TEST_DATA "tests/data"
#endif

static const double g = 9.81, pi = 3.14159265358979323846;
static sph_context *context;
static char warning[1024]; /* the last one */

static inline void keep_warning(sph_log_level level, const char *message, void *user) {
  (void)user;
  if (level == SPH_LOG_WARNING) snprintf(warning, sizeof warning, "%s", message);
}

static inline void start(void) {
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  CU_ASSERT_FATAL(sph_context_set_log(context, keep_warning, NULL) == SPH_OK);
  warning[0] = 0;
}
static inline void stop(void) { sph_context_destroy(&context); }

/* The last call warned of this, or, with NULL, of nothing. */
#define WARNED(text)                                                              \
  do {                                                                            \
    const char *t_w = (text);                                                     \
    const int t_ok = t_w ? strstr(warning, t_w) != NULL : warning[0] == 0;        \
    if (!t_ok) printf("\n%s:%d: warning is \"%s\"", __FILE__, __LINE__, warning); \
    CU_ASSERT(t_ok);                                                              \
    warning[0] = 0;                                                               \
  } while (0)

typedef struct motion {
  double x, v, a;
} motion;

static inline motion at(const sph_paddle *paddle, double t) {
  motion m = {NAN, NAN, NAN};
  SPH_TEST_OK(context, sph_paddle_at(paddle, t, &m.x, &m.v, &m.a));
  return m;
}

/* x = 0.1 (1 - cos t) */
static inline void swing(double t, double *x, double *v, double *a, void *user) {
  *x = 0.1 * (1 - cos(t));
  *v = 0.1 * sin(t);
  *a = 0.1 * cos(t);
  if (user) *(double *)user += 1;
}

/* One of each law, number 1 to sph_paddle_type_count(). */
static inline sph_status create_any(sph_context *where, int type, sph_paddle **out) {
  *out = NULL;
  if (type == SPH_PADDLE_SOLITARY || type == SPH_PADDLE_SOLITARY_CLOSED) {
    sph_wave *wave;
    sph_status status = sph_wave_create_solitary(where, SPH_SOLITARY_RAYLEIGH, 0.1, 0.2, g, &wave);
    if (status != SPH_OK) return status;
    status = type == SPH_PADDLE_SOLITARY
                 ? sph_paddle_create_solitary(where, wave, 0.25, out)
                 : sph_paddle_create_solitary_closed(where, wave, 0.25, out);
    sph_wave_destroy(&wave);
    return status;
  }
  const double t[] = {0.5, 0.7, 1.2, 2, 2.1, 3}, x[] = {0, 0.01, 0.08, 0.15, 0.16, 0.16};
  switch ((sph_paddle_type)type) {
    case SPH_PADDLE_REGULAR:
      return sph_paddle_create_regular(where, 2, 0.05, 1.6, 0.4, g, 0.3, out);
    case SPH_PADDLE_IRREGULAR:
      return sph_paddle_create_spectrum(where, SPH_SPECTRUM_JONSWAP, 0.05, 1.5, 3.3, 0.4, g, 40, 7,
                                        out);
    case SPH_PADDLE_FOCUSED:
      return sph_paddle_create_focused(where, SPH_SPECTRUM_JONSWAP, 1.5, 3.3, 0.4, g, 200, 5, 12,
                                       0.05, out);
    case SPH_PADDLE_SERIES: return sph_paddle_create_series(where, 6, t, x, out);
    default: return sph_paddle_create_function(where, swing, NULL, out);
  }
}

#endif
