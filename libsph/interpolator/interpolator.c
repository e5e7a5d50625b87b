/* Interpolators as handles: creation, names, settings. */
#include "interpolator/interpolator_impl.h"
#include "interpolator/interpolator_list.h"

#define ROW_AGREES(id, enumerator, operator_name, below, name, summary, source) \
  _Static_assert(SPH_INTERPOLATOR_##enumerator == (id),                         \
                 "interpolator.h and interpolator_list.h disagree on " name);
SPHI_INTERPOLATOR_LIST(ROW_AGREES)
#undef ROW_AGREES

#define COUNT_ROW(id, enumerator, operator_name, below, name, summary, source) +1
#define ADD_ID(id, enumerator, operator_name, below, name, summary, source) +(id)
enum {
  INTERPOLATORS = 0 SPHI_INTERPOLATOR_LIST(COUNT_ROW),
  IDS = 0 SPHI_INTERPOLATOR_LIST(ADD_ID)
};
#undef COUNT_ROW
#undef ADD_ID
_Static_assert(2 * IDS == INTERPOLATORS * (INTERPOLATORS + 1), "the ids run from 1 without gaps");

#define ROW_NAME(id, enumerator, operator_name, below, name, summary, source) name,
#define ROW_SUMMARY(id, enumerator, operator_name, below, name, summary, source) summary,
#define ROW_SOURCE(id, enumerator, operator_name, below, name, summary, source) source,
static const char *const names[] = {SPHI_INTERPOLATOR_LIST(ROW_NAME)};
static const char *const summaries[] = {SPHI_INTERPOLATOR_LIST(ROW_SUMMARY)};
static const char *const sources[] = {SPHI_INTERPOLATOR_LIST(ROW_SOURCE)};

static bool known(int type) { return type >= 1 && type <= INTERPOLATORS; }

int sph_interpolator_count(void) { return INTERPOLATORS; }

sph_interpolator_type sph_interpolator_at(int k) {
  return k >= 0 && k < INTERPOLATORS ? (sph_interpolator_type)(k + 1) : (sph_interpolator_type)0;
}

const char *sph_interpolator_name(sph_interpolator_type type) {
  return known((int)type) ? names[(int)type - 1] : (int)type == 0 ? "none" : "unknown";
}

const char *sph_interpolator_summary(sph_interpolator_type type) {
  return known((int)type) ? summaries[(int)type - 1] : "unknown";
}

const char *sph_interpolator_source(sph_interpolator_type type) {
  return known((int)type) ? sources[(int)type - 1] : "unknown";
}

sph_status sph_interpolator_find(sph_context *context, const char *name,
                                 sph_interpolator_type *type) {
  SPH_CHECK(context, context && name && type, SPH_E_ARGUMENT,
            "interpolator: context, name and type must not be NULL");
  for (int k = 0; k < INTERPOLATORS; k++) {
    if (strcmp(name, names[k]) != 0) continue;
    *type = sph_interpolator_at(k);
    return SPH_OK;
  }
  const char *nearest = sphi_nearest_name(name, INTERPOLATORS, names);
  SPH_CHECK(context, nearest, SPH_E_NAME,
            "unknown interpolator \"%.100s\"; sph_interpolator_name() gives the known ones", name);
  return SPHI_ERROR(context, SPH_E_NAME, "unknown interpolator \"%.100s\"; did you mean \"%s\"?",
                    name, nearest);
}

static sph_status create(sph_context *context, sph_interpolator_type type, sph_kernel *kernel,
                         sph_interpolator **out) {
  const char *name = sph_interpolator_name(type);
  SPH_CHECK(context, context && kernel, SPH_E_ARGUMENT,
            "interpolator: context and kernel must not be NULL");
  SPH_CHECK(context, kernel->context == context, SPH_E_ARGUMENT,
            "interpolator \"%s\": its kernel is of another context; create both from one", name);
  SPH_CHECK(context, kernel->dim == 2 || kernel->dim == 3, SPH_E_ARGUMENT,
            "interpolator \"%s\": dim of the kernel must be 2 or 3, got %d", name, kernel->dim);
  sph_interpolator *interpolator = SPHI_NEW(context, 1, sph_interpolator);
  SPH_CHECK(context, interpolator, SPH_E_MEMORY, "interpolator \"%s\": out of memory", name);
  *interpolator = (sph_interpolator){.context = context,
                                     .references = 1,
                                     .type = type,
                                     .kernel = kernel,
                                     .compensation = true,
                                     .mu = 4,
                                     .lambda = 2,
                                     .scale = 1};
  if (type == SPH_INTERPOLATOR_TUNED_SHEPARD) {
    interpolator->mu = 2;
    interpolator->scale = 2 * kernel->h / kernel->support;
  }
  sphi_context_retain(context);
  sphi_kernel_retain(kernel);
  *out = interpolator;
  return SPH_OK;
}

sph_status sph_interpolator_create(sph_context *context, sph_interpolator_type type,
                                   sph_kernel *kernel, sph_interpolator **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "interpolator: out must not be NULL");
  *out = NULL;
  SPH_CHECK(context, known((int)type), SPH_E_ARGUMENT,
            "interpolator: type must be one of sph_interpolator_type, 1 to %d, got %d",
            INTERPOLATORS, (int)type);
  SPH_CHECK(context, type != SPH_INTERPOLATOR_USER, SPH_E_ARGUMENT,
            "interpolator: type \"user\" has no weights; use sph_interpolator_create_user");
  return create(context, type, kernel, out);
}

sph_status sph_interpolator_create_user(sph_context *context, sph_kernel *kernel,
                                        sph_interpolator_weights weights, void *user,
                                        sph_interpolator **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "interpolator: out must not be NULL");
  *out = NULL;
  SPH_CHECK(context, weights, SPH_E_ARGUMENT, "interpolator \"user\": weights must not be NULL");
  SPH_TRY(create(context, SPH_INTERPOLATOR_USER, kernel, out));
  (*out)->weights = weights;
  (*out)->user = user;
  return SPH_OK;
}

void sphi_interpolator_retain(sph_interpolator *interpolator) { interpolator->references++; }

void sph_interpolator_destroy(sph_interpolator **interpolator) {
  if (!interpolator || !*interpolator) return;
  sph_interpolator *dead = *interpolator;
  *interpolator = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  sph_kernel_destroy(&dead->kernel);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

int sph_interpolator_get_type(const sph_interpolator *interpolator) {
  return interpolator ? (int)interpolator->type : 0;
}

sph_status sph_interpolator_set_compensation(sph_interpolator *interpolator, bool compensation) {
  if (!interpolator) return SPH_E_ARGUMENT;
  interpolator->compensation = compensation;
  return SPH_OK;
}

sph_status sph_interpolator_set_shepard(sph_interpolator *interpolator, double mu, double scale,
                                        double lambda) {
  if (!interpolator) return SPH_E_ARGUMENT;
  sph_context *context = interpolator->context;
  const char *name = sph_interpolator_name(interpolator->type);
  SPH_CHECK(context, mu >= 1 && mu <= 16, SPH_E_ARGUMENT,
            "interpolator \"%s\": Shepard's mu must be 1 to 16, got %g", name, mu);
  SPH_CHECK(context, scale >= 0.05 && scale <= 1e6, SPH_E_ARGUMENT,
            "interpolator \"%s\": Shepard's scale a/R must be 0.05 to 1e6, got %g", name, scale);
  SPH_CHECK(context, lambda >= 0.5 && lambda <= 16, SPH_E_ARGUMENT,
            "interpolator \"%s\": Shepard's lambda must be 0.5 to 16, got %g", name, lambda);
  interpolator->mu = mu;
  interpolator->scale = scale;
  interpolator->lambda = lambda;
  return SPH_OK;
}
