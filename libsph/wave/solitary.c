/* Solitary waves: creation, the list of theories, series in sech^2, reflection at a wall. */
#include "wave/wave_list.h"

#define ROW_AGREES(id, enumerator, stem) \
  _Static_assert(SPH_SOLITARY_##enumerator == (id), "wave.h and wave_list.h disagree on " #stem);
SPHI_SOLITARY_LIST(ROW_AGREES)
#undef ROW_AGREES

#define COUNT_ROW(id, enumerator, stem) +1
#define ADD_ID(id, enumerator, stem) +(id)
enum { THEORIES = 0 SPHI_SOLITARY_LIST(COUNT_ROW), IDS = 0 SPHI_SOLITARY_LIST(ADD_ID) };
#undef COUNT_ROW
#undef ADD_ID
_Static_assert(2 * IDS == THEORIES * (THEORIES + 1), "the ids run from 1 without gaps");

#define ROW_TABLE(id, enumerator, stem) &sphi_wave_##stem,
static const sphi_wave_theory *const theories[] = {SPHI_SOLITARY_LIST(ROW_TABLE)};
#undef ROW_TABLE

static const double least_ratio = 1e-8;    /* H/d: below, c^2 - g d has lost its digits */
static const double breaking_ratio = 0.78; /* McCowan (1894) */

static bool known(sph_solitary_theory theory) {
  return (int)theory >= 1 && (int)theory <= THEORIES;
}

int sph_solitary_theory_count(void) { return THEORIES; }

const char *sph_solitary_theory_name(sph_solitary_theory theory) {
  return known(theory) ? theories[(int)theory - 1]->name : "unknown";
}

const char *sph_solitary_theory_summary(sph_solitary_theory theory) {
  return known(theory) ? theories[(int)theory - 1]->summary : "unknown";
}

const char *sph_solitary_theory_source(sph_solitary_theory theory) {
  return known(theory) ? theories[(int)theory - 1]->source : "unknown";
}

sph_status sph_solitary_theory_find(sph_context *context, const char *name,
                                    sph_solitary_theory *theory) {
  SPH_CHECK(context, context && name && theory, SPH_E_ARGUMENT,
            "solitary wave: context, name and theory must not be NULL");
  const char *names[THEORIES];
  for (int k = 0; k < THEORIES; k++) names[k] = theories[k]->name;
  for (int k = 0; k < THEORIES; k++) {
    if (strcmp(name, names[k]) != 0) continue;
    *theory = (sph_solitary_theory)(k + 1);
    return SPH_OK;
  }
  const char *nearest = sphi_nearest_name(name, THEORIES, names);
  SPH_CHECK(context, nearest, SPH_E_NAME,
            "unknown theory \"%.100s\"; sph_solitary_theory_name() gives the known ones", name);
  return SPHI_ERROR(context, SPH_E_NAME, "unknown theory \"%.100s\"; did you mean \"%s\"?", name,
                    nearest);
}

static sph_status check(sph_context *context, const char *name, double height, double depth,
                        double gravity) {
  const struct {
    const char *name, *unit;
    double value;
  } positive[] = {{"height", "m", height}, {"depth", "m", depth}, {"gravity", "m/s^2", gravity}};
  for (int k = 0; k < 3; k++)
    SPH_CHECK(context, isfinite(positive[k].value) && positive[k].value > 0, SPH_E_ARGUMENT,
              "wave \"%s\": %s must be > 0 %s, got %g", name, positive[k].name, positive[k].unit,
              positive[k].value);
  SPH_CHECK(
      context, isfinite(depth * depth) && isnormal(depth * depth) && isfinite(gravity * depth),
      SPH_E_ARGUMENT, "wave \"%s\": depth %g m and gravity %g m/s^2 overflow; use other units",
      name, depth, gravity);
  return SPH_OK;
}

sph_status sph_wave_create_solitary(sph_context *context, sph_solitary_theory theory, double height,
                                    double depth, double gravity, sph_wave **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "wave: out must not be NULL");
  *out = NULL;
  SPH_CHECK(context, context, SPH_E_ARGUMENT, "wave: context must not be NULL");
  SPH_CHECK(context, known(theory), SPH_E_ARGUMENT,
            "wave: theory must be one of sph_solitary_theory, 1 to %d, got %d", THEORIES,
            (int)theory);
  const sphi_wave_theory *table = theories[(int)theory - 1];
  SPH_TRY(check(context, table->name, height, depth, gravity));
  const double ratio = height / depth;
  SPH_CHECK(context, isfinite(ratio) && ratio >= least_ratio, SPH_E_ARGUMENT,
            "wave \"%s\": H/d must be finite and >= %g, got %g m / %g m", table->name, least_ratio,
            height, depth);
  SPH_CHECK(
      context, ratio <= table->known_to, SPH_E_ARGUMENT,
      "wave \"%s\": H/d must be at most %g, got %g: there is no such wave, or its crest is too "
      "sharp for this theory",
      table->name, table->known_to, ratio);
  if (ratio > breaking_ratio)
    sphi_log(context, SPH_LOG_WARNING,
             "wave \"%s\": H/d = %g is above %g, where a solitary wave breaks (McCowan 1894)",
             table->name, ratio, breaking_ratio);
  else if (ratio > table->good_to)
    sphi_log(
        context, SPH_LOG_WARNING,
        "wave \"%s\": H/d = %g is above %g, up to which surface and flow of this theory are within "
        "10 %% of H; use \"%s\"",
        table->name, ratio, table->good_to, sphi_wave_exact.name);
  const sph_wave values = {.height = height,
                           .depth = depth,
                           .gravity = gravity,
                           .speed = sqrt(gravity * depth),
                           .ratio = ratio,
                           .wave_number = NAN};
  return sphi_wave_new(context, table, &values, out);
}

/* sum_m e_m S^m and its derivative, S = sech^2(kappa X), dS/dX = -2 kappa S T. */
void sphi_wave_series_profile(const sph_wave *wave, double X, double *elevation, double *slope) {
  const double C = cosh(wave->decay * X), S = 1 / (C * C), T = tanh(wave->decay * X);
  double sum = 0, derivative = 0;
  for (int m = SPHI_WAVE_TERMS; m >= 1; m--) {
    sum = (sum + wave->elevation[m - 1]) * S;
    derivative = derivative * S + m * wave->elevation[m - 1];
  }
  *elevation = sum;
  *slope = -2 * wave->decay * S * T * derivative;
}

/* integral of S^m = (2/kappa) (2/3) (4/5) ... (2m - 2)/(2m - 1) */
double sphi_wave_series_volume(const sph_wave *wave) {
  double sum = 0, integral = 2 / wave->decay;
  for (int m = 1; m <= SPHI_WAVE_TERMS; m++) {
    sum += wave->elevation[m - 1] * integral;
    integral *= 2.0 * m / (2 * m + 1);
  }
  return sum;
}

double sph_wave_runup(const sph_wave *wave, int order) {
  if (!wave || !sphi_wave_is_solitary(wave) || order < 1 || order > 3) return NAN;
  const double e = wave->ratio;
  const double terms[] = {2 * e, e * e / 2, 3 * e * e * e / 4};
  double sum = 0;
  for (int k = 0; k < order; k++) sum += terms[k];
  return sum * wave->depth;
}

double sph_wave_wall_force(const sph_wave *wave, double density) {
  if (!wave || !sphi_wave_is_solitary(wave)) return NAN;
  const double e = wave->ratio;
  return 0.5 * density * wave->gravity * wave->depth * wave->depth *
         (1 + e * (4 + e * (3 - 6 * e)));
}
