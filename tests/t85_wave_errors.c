/* Waves: warnings, wrong arguments, names, memory. */
#include "sph_test.h"
#include "wave/wave_impl.h"

static const double g = 9.81;
static sph_context *context;
static char heard[2048]; /* warnings */

static void listen(sph_log_level level, const char *message, void *user) {
  (void)user;
  if (level != SPH_LOG_WARNING || strlen(heard) + strlen(message) + 2 > sizeof heard) return;
  strcat(heard, message);
  strcat(heard, "\n");
}

static void start(void) {
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  CU_ASSERT_FATAL(sph_context_set_log(context, listen, NULL) == SPH_OK);
  heard[0] = 0;
}

static void stop(void) { sph_context_destroy(&context); }

static bool available(int theory) {
#ifdef SPHI_GSL
  return theory >= 1;
#else
  return theory != SPH_SOLITARY_EXACT;
#endif
}

/* Theories 1 to 6, then regular waves of order 1 and 2. */
enum { KINDS = 8 };
static sph_status create_any(sph_context *in, int kind, double ratio, sph_wave **out) {
  if (kind <= 6) return sph_wave_create_solitary(in, (sph_solitary_theory)kind, ratio, 1, g, out);
  return sph_wave_create_regular(in, kind - 6, ratio, 2, 1, g, out);
}

static sph_wave *any_wave(int kind, double ratio) {
  sph_wave *wave = NULL;
  SPH_TEST_OK(context, create_any(context, kind, ratio, &wave));
  return wave;
}

static void warned(const char *text) {
  const bool right = *text ? strstr(heard, text) != NULL : heard[0] == 0;
  if (!right) printf("\nexpected the warning \"%s\", heard \"%s\"", text, heard);
  CU_ASSERT(right);
  heard[0] = 0;
}

static void warnings(void) {
  start();
  const struct {
    sph_solitary_theory theory;
    double ratio;
    const char *text;
  } rows[] = {
      {SPH_SOLITARY_BOUSSINESQ, 0.4, ""},
      {SPH_SOLITARY_BOUSSINESQ, 0.41, "\"boussinesq\": H/d = 0.41 is above 0.4"},
      {SPH_SOLITARY_KDV, 0.5, "within 10 % of H; use \"exact\""},
      {SPH_SOLITARY_RAYLEIGH, 0.5, "H/d = 0.5 is above 0.4"},
      {SPH_SOLITARY_GRIMSHAW, 0.3, ""},
      {SPH_SOLITARY_GRIMSHAW, 0.35, "is above 0.3"},
      {SPH_SOLITARY_FENTON, 0.6, ""},
      {SPH_SOLITARY_FENTON, 0.65, "is above 0.6"},
      {SPH_SOLITARY_FENTON, 0.8, "is above 0.78, where a solitary wave breaks (McCowan 1894)"},
      {SPH_SOLITARY_RAYLEIGH, 1.5, "McCowan 1894"},
      {SPH_SOLITARY_EXACT, 0.75, ""},
      {SPH_SOLITARY_EXACT, 0.785, "McCowan 1894"}};
  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
    if (!available((int)rows[k].theory)) continue;
    sph_wave *wave = any_wave((int)rows[k].theory, rows[k].ratio);
    warned(rows[k].text);
    sph_wave_destroy(&wave);
  }
  const struct {
    int order;
    double height, period; /* depth and gravity 1 */
    const char *text;
  } regular[] = {{1, 0.1, 8, ""},
                 {2, 0.1, 8, ""},
                 {1, 0.4, 14, ""},
                 {2, 0.4, 14, "H L^2/d^3 = "},
                 {2, 0.4, 14, "is above 8 pi^2/3 = 26.3189"},
                 {1, 0.95, 8, "is above 0.142 tanh kd = "},
                 {2, 0.4, 3, "where a wave breaks (Miche 1944)"}};
  for (size_t k = 0; k < sizeof regular / sizeof regular[0]; k++) {
    sph_wave *wave = NULL;
    SPH_TEST_OK(context, sph_wave_create_regular(context, regular[k].order, regular[k].height,
                                                 regular[k].period, 1, 1, &wave));
    warned(regular[k].text);
    sph_wave_destroy(&wave);
  }
  stop();
}

static void creation_refusals(void) {
  start();
  const struct {
    int theory;
    double height, depth, gravity;
    const char *text;
  } bad[] = {{0, 0.1, 1, g, "one of sph_solitary_theory, 1 to 6, got 0"},
             {7, 0.1, 1, g, "one of sph_solitary_theory, 1 to 6, got 7"},
             {1, 0, 1, g, "wave \"boussinesq\": height must be > 0 m, got 0"},
             {2, -0.1, 1, g, "wave \"kdv\": height must be > 0 m, got -0.1"},
             {3, NAN, 1, g, "height must be > 0 m, got nan"},
             {3, 0.1, 0, g, "wave \"rayleigh\": depth must be > 0 m, got 0"},
             {4, 0.1, INFINITY, g, "depth must be > 0 m, got inf"},
             {5, 0.1, 1, -g, "gravity must be > 0 m/s^2, got -9.81"},
             {6, 0.1, 1, NAN, "gravity must be > 0 m/s^2, got nan"},
             {1, 0.1, 1e200, g, "overflow; use other units"},
             {1, 0.1, 1e-200, g, "overflow; use other units"},
             {1, 1e-9, 1, g, "H/d must be finite and >= 1e-08"},
             {1, 1e300, 1e-100, g, "H/d must be finite"},
             {4, 0.84, 1, g, "H/d must be at most 0.8332, got 0.84"},
             {5, 0.84, 1, g, "H/d must be at most 0.8332, got 0.84"},
             {6, 0.791, 1, g, "H/d must be at most 0.79, got 0.791"}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    sph_wave *wave = (sph_wave *)&wave;
    SPH_TEST_STATUS(context,
                    sph_wave_create_solitary(context, (sph_solitary_theory)bad[k].theory,
                                             bad[k].height, bad[k].depth, bad[k].gravity, &wave),
                    SPH_E_ARGUMENT, bad[k].text);
    CU_ASSERT(wave == NULL);
  }
  const struct {
    int order;
    double height, period, depth, gravity;
    const char *text;
  } wrong[] = {{0, 0.1, 2, 1, g, "order of a regular wave must be 1 to 2, got 0"},
               {3, 0.1, 2, 1, g, "order of a regular wave must be 1 to 2, got 3"},
               {1, 0, 2, 1, g, "wave \"airy\": height must be > 0 m, got 0"},
               {2, NAN, 2, 1, g, "wave \"stokes\": height must be > 0 m, got nan"},
               {1, 0.1, 0, 1, g, "period must be > 0 s, got 0"},
               {1, 0.1, INFINITY, 1, g, "period must be > 0 s, got inf"},
               {1, 0.1, 2, -1, g, "depth must be > 0 m, got -1"},
               {1, 0.1, 2, 1, 0, "gravity must be > 0 m/s^2, got 0"},
               {1, 0.1, 1e-20, 1, g, "do not go together"},
               {1, 0.1, 1e20, 1, g, "do not go together"},
               {1, 2, 2, 1, g, "must be < 2 depths"},
               {2, 0.5, 60, 1, g, "troughs reach the bed"}};
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
    sph_wave *wave = (sph_wave *)&wave;
    SPH_TEST_STATUS(
        context,
        sph_wave_create_regular(context, wrong[k].order, wrong[k].height, wrong[k].period,
                                wrong[k].depth, wrong[k].gravity, &wave),
        SPH_E_ARGUMENT, wrong[k].text);
    CU_ASSERT(wave == NULL);
  }
  SPH_TEST_STATUS(context, sph_wave_create_solitary(context, SPH_SOLITARY_KDV, 0.1, 1, g, NULL),
                  SPH_E_ARGUMENT, "out must not be NULL");
  SPH_TEST_STATUS(context, sph_wave_create_regular(context, 1, 0.1, 2, 1, g, NULL), SPH_E_ARGUMENT,
                  "out must not be NULL");
  sph_wave *wave = NULL;
  CU_ASSERT(sph_wave_create_solitary(NULL, SPH_SOLITARY_KDV, 0.1, 1, g, &wave) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wave_create_regular(NULL, 1, 0.1, 2, 1, g, &wave) == SPH_E_ARGUMENT);
  double k = -7;
  CU_ASSERT(sph_wave_dispersion(NULL, 1, 1, g, &k) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(context, sph_wave_dispersion(context, 1, 1, g, NULL), SPH_E_ARGUMENT,
                  "wave_number must not be NULL");
  SPH_TEST_STATUS(context, sph_wave_dispersion(context, 0, 1, g, &k), SPH_E_ARGUMENT,
                  "period must be > 0 s, got 0");
  SPH_TEST_STATUS(context, sph_wave_dispersion(context, 1, NAN, g, &k), SPH_E_ARGUMENT,
                  "depth must be > 0 m, got nan");
  SPH_TEST_STATUS(context, sph_wave_dispersion(context, 1, 1, -g, &k), SPH_E_ARGUMENT,
                  "gravity must be > 0 m/s^2");
  SPH_TEST_STATUS(context, sph_wave_dispersion(context, 1e-30, 1, g, &k), SPH_E_ARGUMENT,
                  "do not go together");
  CU_ASSERT(k == -7);
  stop();
}

static void evaluation_refusals(void) {
  start();
  sph_wave *wave = any_wave(SPH_SOLITARY_RAYLEIGH, 0.2);
  double xy[4] = {0, 0.5, 1, 0.5}, r[4] = {-7, -7, -7, -7};
  SPH_TEST_STATUS(context, sph_wave_set_origin(wave, NAN, 0, 1), SPH_E_ARGUMENT,
                  "x0 must be finite");
  SPH_TEST_STATUS(context, sph_wave_set_origin(wave, 0, INFINITY, 1), SPH_E_ARGUMENT,
                  "t0 must be finite, got inf");
  SPH_TEST_STATUS(context, sph_wave_set_origin(wave, 0, 0, 0), SPH_E_ARGUMENT,
                  "direction must be +1 or -1, got 0");
  CU_ASSERT(sph_wave_set_origin(NULL, 0, 0, 1) == SPH_E_ARGUMENT);
  SPH_TEST_STATUS(context, sph_wave_elevation(wave, NAN, 2, xy, r), SPH_E_ARGUMENT,
                  "wave \"rayleigh\": time must be finite, got nan");
  SPH_TEST_STATUS(context, sph_wave_elevation(wave, 0, -1, xy, r), SPH_E_ARGUMENT,
                  "number of points must be >= 0, got -1");
  SPH_TEST_STATUS(context, sph_wave_elevation(wave, 0, 2, NULL, r), SPH_E_ARGUMENT,
                  "x must not be NULL");
  SPH_TEST_STATUS(context, sph_wave_elevation(wave, 0, 2, xy, NULL), SPH_E_ARGUMENT,
                  "the array of results must not be NULL");
  SPH_TEST_STATUS(context, sph_wave_velocity(wave, 0, 2, NULL, r), SPH_E_ARGUMENT,
                  "xy must not be NULL");
  SPH_TEST_STATUS(context, sph_wave_pressure(wave, 1, 0, 2, xy, NULL), SPH_E_ARGUMENT,
                  "the array of results must not be NULL");
  SPH_TEST_STATUS(context, sph_wave_pressure(wave, 0, 0, 2, xy, r), SPH_E_ARGUMENT,
                  "density must be > 0 kg/m^3");
  SPH_TEST_STATUS(context, sph_wave_pressure(wave, NAN, 0, 2, xy, r), SPH_E_ARGUMENT,
                  "density must be > 0 kg/m^3");
  xy[3] = -0.5;
  SPH_TEST_STATUS(context, sph_wave_velocity(wave, 0, 2, xy, r), SPH_E_ARGUMENT,
                  "y of point 1 must be >= 0, counted from the bed, got -0.5");
  SPH_TEST_STATUS(context, sph_wave_pressure(wave, 1, 0, 2, xy, r), SPH_E_ARGUMENT, "y of point 1");
  xy[3] = NAN;
  SPH_TEST_STATUS(context, sph_wave_velocity(wave, 0, 2, xy, r), SPH_E_ARGUMENT, "y of point 1");
  xy[2] = NAN;
  SPH_TEST_STATUS(context, sph_wave_velocity(wave, 0, 2, xy, r), SPH_E_ARGUMENT,
                  "x of point 1 must be finite");
  SPH_TEST_STATUS(context, sph_wave_elevation(wave, 0, 3, xy, r), SPH_E_ARGUMENT,
                  "x of point 2 must be finite and not too far away, got nan");
  CU_ASSERT(sph_wave_elevation(NULL, 0, 2, xy, r) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wave_velocity(NULL, 0, 2, xy, r) == SPH_E_ARGUMENT);
  CU_ASSERT(sph_wave_pressure(NULL, 1, 0, 2, xy, r) == SPH_E_ARGUMENT);
  SPH_TEST_OK(context, sph_wave_elevation(wave, 0, 0, NULL, NULL));
  CU_ASSERT(r[0] == -7 && r[1] == -7 && r[2] == -7 && r[3] == -7);
  sph_wave_destroy(&wave);
  stop();
}

static void names_and_getters(void) {
  start();
  const char *const names[] = {"boussinesq", "kdv", "rayleigh", "grimshaw", "fenton", "exact"};
  CU_ASSERT_EQUAL(sph_solitary_theory_count(), 6);
  for (int k = 1; k <= 6; k++) {
    sph_solitary_theory theory = (sph_solitary_theory)0;
    CU_ASSERT_STRING_EQUAL(sph_solitary_theory_name((sph_solitary_theory)k), names[k - 1]);
    CU_ASSERT(strlen(sph_solitary_theory_summary((sph_solitary_theory)k)) > 10);
    CU_ASSERT(strlen(sph_solitary_theory_source((sph_solitary_theory)k)) > 10);
    SPH_TEST_OK(context, sph_solitary_theory_find(context, names[k - 1], &theory));
    CU_ASSERT(theory == (sph_solitary_theory)k);
  }
  CU_ASSERT_STRING_EQUAL(sph_solitary_theory_name((sph_solitary_theory)0), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_solitary_theory_summary((sph_solitary_theory)7), "unknown");
  CU_ASSERT_STRING_EQUAL(sph_solitary_theory_source((sph_solitary_theory)-1), "unknown");
  sph_solitary_theory theory = SPH_SOLITARY_KDV;
  SPH_TEST_STATUS(context, sph_solitary_theory_find(context, "raleigh", &theory), SPH_E_NAME,
                  "did you mean \"rayleigh\"");
  SPH_TEST_STATUS(context, sph_solitary_theory_find(context, "something else", &theory), SPH_E_NAME,
                  "gives the known ones");
  SPH_TEST_STATUS(context, sph_solitary_theory_find(context, NULL, &theory), SPH_E_ARGUMENT,
                  "NULL");
  SPH_TEST_STATUS(context, sph_solitary_theory_find(context, "kdv", NULL), SPH_E_ARGUMENT, "NULL");
  CU_ASSERT(sph_solitary_theory_find(NULL, "kdv", &theory) == SPH_E_ARGUMENT);
  CU_ASSERT(theory == SPH_SOLITARY_KDV);
  sph_wave *wave = NULL, *regular = any_wave(8, 0.05);
  SPH_TEST_OK(context,
              sph_wave_create_solitary(context, SPH_SOLITARY_RAYLEIGH, 0.1, 0.4, g, &wave));
  CU_ASSERT(sph_wave_height(wave) == 0.1 && sph_wave_depth(wave) == 0.4);
  CU_ASSERT(sph_wave_gravity(wave) == g);
  CU_ASSERT_STRING_EQUAL(sph_wave_name(wave), "rayleigh");
  CU_ASSERT_STRING_EQUAL(sph_wave_name(regular), "stokes");
  SPH_TEST_CLOSE(sph_wave_celerity(wave), sqrt(g * 0.5), 1e-15, 0);
  SPH_TEST_CLOSE(sph_wave_decay(wave), sqrt(0.3 / (4 * 0.16 * 0.5)), 1e-14, 0);
  SPH_TEST_CLOSE(sph_wave_stroke(wave), sqrt(16 * 0.1 * 0.5 / 3), 1e-14, 0);
  CU_ASSERT(isnan(sph_wave_length(wave)) && isnan(sph_wave_period(wave)));
  CU_ASSERT(isnan(sph_wave_number(wave)) && isnan(sph_wave_decay(regular)));
  CU_ASSERT(isnan(sph_wave_volume(regular)) && isnan(sph_wave_stroke(regular)));
  double (*const getters[])(const sph_wave *) = {
      sph_wave_height, sph_wave_depth,  sph_wave_gravity, sph_wave_celerity, sph_wave_decay,
      sph_wave_volume, sph_wave_stroke, sph_wave_length,  sph_wave_period,   sph_wave_number};
  for (size_t k = 0; k < sizeof getters / sizeof getters[0]; k++)
    CU_ASSERT(isnan(getters[k](NULL)));
  CU_ASSERT_STRING_EQUAL(sph_wave_name(NULL), "");
  sph_wave_destroy(&wave);
  CU_ASSERT(wave == NULL);
  sph_wave_destroy(&wave);
  sph_wave_destroy(NULL);
  sph_wave_destroy(&regular);
  stop();
}

static void failed_allocations_leave_nothing(void) {
  sph_test_memory m = {1, 0};
  const sph_allocator allocator = {sph_test_allocate, sph_test_release, &m};
  sph_context *poor = NULL;
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &poor) == SPH_OK);
  for (int kind = 1; kind <= KINDS; kind++) {
    if (!available(kind)) continue;
    sph_status status = SPH_E_MEMORY;
    for (int allowed = 0; status == SPH_E_MEMORY; allowed++) {
      sph_wave *wave = NULL;
      m.allowed = allowed;
      status = create_any(poor, kind, 0.6, &wave);
      CU_ASSERT((status == SPH_OK) == (wave != NULL));
      if (status != SPH_OK) {
        CU_ASSERT(strstr(sph_context_message(poor), "out of memory") != NULL);
      } else {
        CU_ASSERT(allowed >= (kind == SPH_SOLITARY_EXACT ? 20 : 1));
      }
      sph_wave_destroy(&wave);
      CU_ASSERT(m.live == 1);
    }
    CU_ASSERT(status == SPH_OK);
  }
  sph_context_destroy(&poor);
  CU_ASSERT(m.live == 0);
}

static void wave_outlives_its_handles(void) {
  sph_test_memory m = {100, 0};
  const sph_allocator allocator = {sph_test_allocate, sph_test_release, &m};
  sph_context *own = NULL;
  sph_wave *wave = NULL;
  CU_ASSERT_FATAL(sph_context_create_with_allocator(&allocator, &own) == SPH_OK);
  CU_ASSERT_FATAL(sph_wave_create_solitary(own, SPH_SOLITARY_FENTON, 0.2, 1, 1, &wave) == SPH_OK);
  sph_context_destroy(&own);
  sph_wave *held = wave;
  sphi_wave_retain(held);
  sph_wave_destroy(&wave);
  SPH_TEST_CLOSE(sphi_wave_celerity(held), 1.0943445, 0, 1e-7);
  sph_wave_destroy(&held);
  CU_ASSERT(m.live == 0);
}

#ifndef SPHI_GSL
static void exact_needs_gsl(void) {
  start();
  sph_wave *wave = (sph_wave *)&wave;
  SPH_TEST_STATUS(context, sph_wave_create_solitary(context, SPH_SOLITARY_EXACT, 0.3, 1, 1, &wave),
                  SPH_E_UNAVAILABLE, "need a build with GSL");
  CU_ASSERT(wave == NULL);
  stop();
}

#define EXACT_TESTS {"the exact wave is unavailable without GSL", exact_needs_gsl},
#else
#define EXACT_TESTS
#endif

SPH_TEST_MAIN("wave_errors", EXACT_TESTS{"warnings cite their criterion", warnings},
              {"wrong arguments of creation are refused", creation_refusals},
              {"wrong arguments of evaluation are refused", evaluation_refusals},
              {"names, list and getters", names_and_getters},
              {"failed allocations are reported and leak nothing",
               failed_allocations_leave_nothing},
              {"a wave holds its context and counts its references", wave_outlives_its_handles})
