/* Kernels as handles: creation, names, evaluation of single points and arrays. */
#include "kernel/kernel_impl.h"
#include "kernel/kernel_list.h"

#define ROW_AGREES(id, enumerator, stem, name, ratio, summary, source) \
  _Static_assert(SPH_KERNEL_##enumerator == (id), "kernel.h and kernel_list.h disagree on " name);
SPHI_KERNEL_LIST(ROW_AGREES)
#undef ROW_AGREES

#define COUNT_ROW(id, enumerator, stem, name, ratio, summary, source) +1
#define ADD_ID(id, enumerator, stem, name, ratio, summary, source) +(id)
enum { KERNELS = 0 SPHI_KERNEL_LIST(COUNT_ROW), IDS = 0 SPHI_KERNEL_LIST(ADD_ID) };
#undef COUNT_ROW
#undef ADD_ID
_Static_assert(2 * IDS == KERNELS * (KERNELS + 1), "the ids run from 1 without gaps");

#define ROW_NAME(id, enumerator, stem, name, ratio, summary, source) name,
#define ROW_RATIO(id, enumerator, stem, name, ratio, summary, source) ratio,
#define ROW_SUMMARY(id, enumerator, stem, name, ratio, summary, source) summary,
#define ROW_SOURCE(id, enumerator, stem, name, ratio, summary, source) source,
static const char *const names[] = {SPHI_KERNEL_LIST(ROW_NAME)};
static const double ratios[] = {SPHI_KERNEL_LIST(ROW_RATIO)};
static const char *const summaries[] = {SPHI_KERNEL_LIST(ROW_SUMMARY)};
static const char *const sources[] = {SPHI_KERNEL_LIST(ROW_SOURCE)};

static bool known(int type) { return type >= 1 && type <= KERNELS; }

int sph_kernel_count(void) { return KERNELS; }

const char *sph_kernel_name(sph_kernel_type type) {
  return known((int)type) ? names[(int)type - 1] : "unknown";
}

const char *sph_kernel_summary(sph_kernel_type type) {
  return known((int)type) ? summaries[(int)type - 1] : "unknown";
}

const char *sph_kernel_source(sph_kernel_type type) {
  return known((int)type) ? sources[(int)type - 1] : "unknown";
}

sph_status sph_kernel_find(sph_context *context, const char *name, sph_kernel_type *type) {
  SPH_CHECK(context, context && name && type, SPH_E_ARGUMENT,
            "kernel: context, name and type must not be NULL");
  for (int k = 0; k < KERNELS; k++) {
    if (strcmp(name, names[k]) != 0) continue;
    *type = (sph_kernel_type)(k + 1);
    return SPH_OK;
  }
  const char *nearest = sphi_nearest_name(name, KERNELS, names);
  SPH_CHECK(context, nearest, SPH_E_NAME,
            "unknown kernel \"%.100s\"; sph_kernel_name() gives the known ones", name);
  return SPHI_ERROR(context, SPH_E_NAME, "unknown kernel \"%.100s\"; did you mean \"%s\"?", name,
                    nearest);
}

sph_status sphi_kernel_check(sph_context *context, const char *name, int dim, double h) {
  SPH_CHECK(context, dim >= 1 && dim <= SPHI_MAX_DIM, SPH_E_ARGUMENT,
            "kernel \"%s\": dim must be 1 to %d, got %d", name, SPHI_MAX_DIM, dim);
  SPH_CHECK(context, isfinite(h) && h > 0, SPH_E_ARGUMENT,
            "kernel \"%s\": smoothing length h must be finite and > 0 m, got %g", name, h);
  return SPH_OK;
}

static double slope_of(int type, int dim) {
  switch ((sph_kernel_type)type) {
#define SLOPE(id, enumerator, stem, name, ratio, summary, source) \
  case SPH_KERNEL_##enumerator: return sphi_##stem##_slope(dim);
    SPHI_KERNEL_LIST(SLOPE)
#undef SLOPE
  }
  return NAN;
}

sph_status sphi_kernel_new(sph_context *context, const sph_kernel *values, sph_kernel **out) {
  const char *name = sph_kernel_name((sph_kernel_type)values->type);
  const double norm_w = values->sigma / pow(values->h, values->dim);
  const double norm_g = slope_of(values->type, values->dim) * norm_w / (values->h * values->h);
  SPH_CHECK(context, isnormal(norm_w) && isnormal(norm_g) && isnormal(values->ratio * values->h),
            SPH_E_ARGUMENT, "kernel \"%s\": h = %g m overflows in h^-%d; use other units of length",
            name, values->h, values->dim + 2);
  sph_kernel *kernel = SPHI_NEW(context, 1, sph_kernel);
  SPH_CHECK(context, kernel, SPH_E_MEMORY, "kernel \"%s\": out of memory", name);
  *kernel = *values;
  kernel->references = 1;
  kernel->support = kernel->ratio * kernel->h;
  kernel->norm_w = norm_w;
  kernel->norm_g = norm_g;
  kernel->context = context;
  sphi_context_retain(context);
  *out = kernel;
  return SPH_OK;
}

static double sigma_of(int type, int dim) {
  switch ((sph_kernel_type)type) {
#define SIGMA(id, enumerator, stem, name, ratio, summary, source) \
  case SPH_KERNEL_##enumerator: return sphi_##stem##_sigma(dim);
    SPHI_KERNEL_LIST(SIGMA)
#undef SIGMA
  }
  return NAN;
}

sph_status sph_kernel_create(sph_context *context, sph_kernel_type type, int dim, double h,
                             sph_kernel **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "kernel: out must not be NULL");
  *out = NULL;
  SPH_CHECK(context, context, SPH_E_ARGUMENT, "kernel: context must not be NULL");
  SPH_CHECK(context, known((int)type), SPH_E_ARGUMENT,
            "kernel: type must be one of sph_kernel_type, 1 to %d, got %d", KERNELS, (int)type);
  SPH_CHECK(context, type != SPH_KERNEL_USER, SPH_E_ARGUMENT,
            "kernel \"user\": its functions are missing; call sph_kernel_create_user()");
  SPH_TRY(sphi_kernel_check(context, sph_kernel_name(type), dim, h));
  const sph_kernel values = {.type = (int)type,
                             .dim = dim,
                             .h = h,
                             .ratio = ratios[(int)type - 1],
                             .sigma = sigma_of((int)type, dim)};
  return sphi_kernel_new(context, &values, out);
}

void sphi_kernel_retain(sph_kernel *kernel) { kernel->references++; }

void sph_kernel_destroy(sph_kernel **kernel) {
  if (!kernel || !*kernel) return;
  sph_kernel *dead = *kernel;
  *kernel = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  sphi_free(context, dead->table);
  sphi_free(context, dead->table_single);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

int sph_kernel_get_type(const sph_kernel *kernel) { return kernel ? kernel->type : 0; }

int sph_kernel_get_dim(const sph_kernel *kernel) { return kernel ? kernel->dim : 0; }

double sph_kernel_get_h(const sph_kernel *kernel) { return kernel ? kernel->h : NAN; }

double sph_kernel_get_support(const sph_kernel *kernel) { return kernel ? kernel->support : NAN; }

double sph_kernel_get_normalization(const sph_kernel *kernel) {
  return kernel ? kernel->sigma : NAN;
}

/* f(q), or g(q): the text of the pair loops with one lane of double. */
static double formula(const sph_kernel *kernel, double q2, bool derivative) {
  const sphi_kernel_lanes lanes = sphi_kernel_lanes_of(kernel);
  const vreal x = v_set(q2);
  switch ((sph_kernel_type)kernel->type) {
#define IN_DIM(stem, dim) \
  (derivative ? sphi_##stem##_g(x, dim, &lanes)[0] : sphi_##stem##_f(x, dim, &lanes)[0])
#define FORMULA(id, enumerator, stem, name, ratio, summary, source) \
  case SPH_KERNEL_##enumerator:                                     \
    return kernel->dim == 1   ? IN_DIM(stem, 1)                     \
           : kernel->dim == 2 ? IN_DIM(stem, 2)                     \
                              : IN_DIM(stem, 3);
    SPHI_KERNEL_LIST(FORMULA)
#undef FORMULA
#undef IN_DIM
  }
  return NAN;
}

/* W = sigma h^-dim f(q) */
static double value(const sph_kernel *kernel, double r) {
  if (r >= kernel->support) return 0;
  const double q = r / kernel->h;
  if (kernel->type == SPH_KERNEL_USER) return kernel->norm_w * kernel->w(q, kernel->user);
  return kernel->norm_w * formula(kernel, q * q, false);
}

/* dW/dr = sigma h^-(dim+1) f'(q) = norm_g r g(q) */
static double slope(const sph_kernel *kernel, double r) {
  if (r >= kernel->support) return 0;
  const double q = r / kernel->h;
  if (kernel->type == SPH_KERNEL_USER)
    return kernel->norm_g * kernel->h * kernel->dw(q, kernel->user);
  return kernel->norm_g * r * formula(kernel, q * q, true);
}

double sph_kernel_w(const sph_kernel *kernel, double r) {
  return kernel && r >= 0 ? value(kernel, r) : NAN;
}

double sph_kernel_dw(const sph_kernel *kernel, double r) {
  return kernel && r >= 0 ? slope(kernel, r) : NAN;
}

sph_status sph_kernel_evaluate(const sph_kernel *kernel, int64_t n, const double *r, double *w,
                               double *dw) {
  if (!kernel) return SPH_E_ARGUMENT;
  sph_context *context = kernel->context;
  const char *name = sph_kernel_name((sph_kernel_type)kernel->type);
  SPH_CHECK(context, n >= 0, SPH_E_ARGUMENT, "kernel \"%s\": n must be >= 0, got %lld", name,
            (long long)n);
  SPH_CHECK(context, r || n == 0, SPH_E_ARGUMENT, "kernel \"%s\": r must not be NULL", name);
  SPH_CHECK(context, w || dw, SPH_E_ARGUMENT, "kernel \"%s\": w and dw must not both be NULL",
            name);
  for (int64_t k = 0; k < n; k++)
    SPH_CHECK(context, r[k] >= 0, SPH_E_ARGUMENT,
              "kernel \"%s\": distance r[%lld] must be >= 0 m, got %g", name, (long long)k, r[k]);
  for (int64_t k = 0; k < n; k++) {
    const double distance = r[k]; /* the results may go into the same array */
    if (w) w[k] = value(kernel, distance);
    if (dw) dw[k] = slope(kernel, distance);
  }
  return SPH_OK;
}
