/* Interpolation alone: any particle set, any points, any fields, in groups of dim + 1 scalars. */
#include "interpolator/gather_impl.h"
#include "particles/particles_impl.h"

/* Everything one evaluation needs, freed at its end. */
typedef struct scratch {
  sphi_frame frame;
  double spacing;          /* that the columns suit */
  double lo[SPHI_MAX_DIM]; /* the box around the sources */
  double hi[SPHI_MAX_DIM];
  int64_t components;
  const double **component; /* [components][n] in storage order */
  int32_t *number;          /* points within the support of the box: their numbers */
  sphi_columns columns;
  void *record;
  sphi_gather gather; /* those points */
} scratch;

static void scratch_free(sph_context *context, scratch *s) {
  sphi_free(context, s->component);
  sphi_free(context, s->number);
  sphi_columns_free(context, &s->columns);
  sphi_free(context, s->record);
  sphi_gather_free(context, &s->gather);
}

static sph_status check(const sph_interpolator *interpolator, const sphi_evaluation *e) {
  sph_context *context = interpolator->context;
  const char *name = sph_interpolator_name(interpolator->type);
  const sph_particles *source = e->source;
  SPH_CHECK(context, source, SPH_E_ARGUMENT, "interpolator \"%s\": source must not be NULL", name);
  SPH_CHECK(context, source->context == context, SPH_E_ARGUMENT,
            "interpolator \"%s\": particles \"%s\" are of another context; create both from one",
            name, source->name);
  const int dim = source->dim;
  SPH_CHECK(
      context, interpolator->kernel->dim == dim, SPH_E_ARGUMENT,
      "interpolator \"%s\": its kernel is %dD, particles \"%s\" are %dD; create the kernel with "
      "dim = %d",
      name, interpolator->kernel->dim, source->name, dim, dim);
  SPH_CHECK(context, source->n > 0, SPH_E_ARGUMENT,
            "interpolator \"%s\": particles \"%s\" are empty; fill them first", name, source->name);
  SPH_CHECK(context, e->points >= 0 && e->points <= SPHI_MAX_PARTICLES, SPH_E_ARGUMENT,
            "interpolator \"%s\": points must be 0 to %lld, got %lld", name,
            (long long)SPHI_MAX_PARTICLES, (long long)e->points);
  SPH_CHECK(context, e->fields >= 1, SPH_E_ARGUMENT,
            "interpolator \"%s\": fields must be >= 1, got %d", name, e->fields);
  SPH_CHECK(context, e->names, SPH_E_ARGUMENT, "interpolator \"%s\": names must not be NULL", name);
  SPH_CHECK(context, e->at || e->points == 0, SPH_E_ARGUMENT,
            "interpolator \"%s\": at must not be NULL", name);
  SPH_CHECK(context, !e->gradient || sphi_finite(dim, e->gradient), SPH_E_ARGUMENT,
            "interpolator \"%s\": gradient must be finite, got (%g, %g, %g)", name, e->gradient[0],
            e->gradient[1], dim == 3 ? e->gradient[2] : 0.0);
  for (int64_t k = 0; k < e->points; k++)
    SPH_CHECK(context, sphi_finite(dim, e->at + k * dim), SPH_E_ARGUMENT,
              "interpolator \"%s\": point %lld must be finite, got (%g, %g, %g)", name,
              (long long)k, e->at[k * dim], e->at[k * dim + 1],
              dim == 3 ? e->at[k * dim + 2] : 0.0);
  return SPH_OK;
}

static sph_status check_source(const sph_particles *source, const char *field,
                               const double *values) {
  for (sph_index i = 0; i < source->n; i++)
    SPH_CHECK(source->context, isfinite(values[i]), SPH_E_ARGUMENT,
              "particles \"%s\": field \"%s\" of id %lld must be finite, got %g", source->name,
              field, (long long)source->id[i], values[i]);
  return SPH_OK;
}

/* Finds the fields, checks them, and lists their components. */
static sph_status find_components(const sph_interpolator *interpolator, const sphi_evaluation *e,
                                  scratch *s) {
  sph_context *context = interpolator->context;
  const char *name = sph_interpolator_name(interpolator->type);
  const sph_particles *source = e->source;
  for (int f = 0; f < e->fields; f++) {
    SPH_CHECK(context, e->names[f], SPH_E_ARGUMENT,
              "interpolator \"%s\": names[%d] must not be NULL", name, f);
    const sphi_field *field = sphi_particles_field(source, e->names[f]);
    if (!field) return SPH_E_NAME;
    SPH_CHECK(
        context, !e->gradient || field->components == 1, SPH_E_ARGUMENT,
        "interpolator \"%s\": a field with a gradient must be scalar, \"%s\" has %d components",
        name, e->names[f], field->components);
    s->components += field->components;
  }
  s->component = SPHI_NEW(context, s->components, const double *);
  SPH_CHECK(context, s->component, SPH_E_MEMORY,
            "interpolator \"%s\": no memory for %lld components", name, (long long)s->components);
  int64_t component = 0;
  for (int f = 0; f < e->fields; f++) {
    const sphi_field *field = sphi_particles_field(source, e->names[f]);
    for (int c = 0; c < field->components; c++) {
      SPH_TRY(check_source(source, e->names[f], field->data[c]));
      s->component[component++] = field->data[c];
    }
  }
  for (int d = 0; d < source->dim; d++)
    SPH_TRY(check_source(source, SPH_POSITION, source->field[SPHI_X].data[d]));
  const double *volume = source->field[SPHI_VOL].data[0];
  for (sph_index i = 0; i < source->n; i++)
    SPH_CHECK(context, volume[i] > 0 && isfinite(volume[i]), SPH_E_ARGUMENT,
              "particles \"%s\": volume of id %lld must be finite and > 0, got %g", source->name,
              (long long)source->id[i], volume[i]);
  return SPH_OK;
}

/* Boxes the sources, chooses frame and columns, sorts the sources. */
static sph_status sort_sources(const sph_interpolator *interpolator, const sphi_variant *variant,
                               const sph_particles *source, scratch *s) {
  sph_context *context = interpolator->context;
  const char *name = sph_interpolator_name(interpolator->type);
  const double support = interpolator->kernel->support;
  double *const *x = source->field[SPHI_X].data;
  /* A support of hundreds of spacings must not meet as many columns, and a cluster must not be longer
   * than the fixed-point range of 256 supports. */
  s->spacing = fmin(fmax(source->spacing, support / 8), 8 * support);
  const double width = sphi_column_width(source->dim, variant->lanes, s->spacing);
  for (int d = 0; d < source->dim; d++) {
    s->lo[d] = s->hi[d] = x[d][0];
    for (sph_index i = 1; i < source->n; i++) {
      if (x[d][i] < s->lo[d]) s->lo[d] = x[d][i];
      if (x[d][i] > s->hi[d]) s->hi[d] = x[d][i];
    }
    SPH_CHECK(
        context, s->hi[d] - s->lo[d] < 5e8 * width, SPH_E_ARGUMENT,
        "interpolator \"%s\": particles \"%s\" extend over %g m, too far for a support of %g m",
        name, source->name, s->hi[d] - s->lo[d], support);
  }
  sphi_frame_set(&s->frame, source->dim, s->lo, support, NULL, NULL, NULL);
  SPH_TRY(
      sphi_columns_build(context, &s->columns, &s->frame, width, source->n, x, source->rank, name));
  s->record = sphi_alloc(context,
                         (size_t)((int64_t)source->n + SPHI_PAD) * (size_t)SPHI_RECORD(source->dim),
                         variant->real_size);
  SPH_CHECK(context, s->record, SPH_E_MEMORY,
            "interpolator \"%s\": no memory for the records of %d particles", name, source->n);
  return SPH_OK;
}

/* Takes the points that can have neighbours, sorts them, and lists their sources. */
static sph_status sort_points(const sph_interpolator *interpolator, const sphi_variant *variant,
                              const sphi_evaluation *e, scratch *s) {
  sph_context *context = interpolator->context;
  const double support = interpolator->kernel->support;
  const int dim = e->source->dim;
  s->number = SPHI_NEW(context, e->points, int32_t);
  SPH_CHECK(context, s->number, SPH_E_MEMORY, "interpolator \"%s\": no memory for %lld points",
            sph_interpolator_name(interpolator->type), (long long)e->points);
  int32_t near = 0;
  for (int64_t k = 0; k < e->points; k++) {
    const double *at = e->at + k * dim;
    bool inside = true;
    for (int d = 0; d < dim; d++)
      inside = inside && at[d] - s->hi[d] < support && s->lo[d] - at[d] < support;
    if (inside) s->number[near++] = (int32_t)k;
  }
  SPH_TRY(sphi_gather_reserve(context, &s->gather, interpolator, dim, near, variant->real_size));
  for (int32_t k = 0; k < near; k++)
    for (int d = 0; d < dim; d++) s->gather.x[d][k] = e->at[(int64_t)s->number[k] * dim + d];
  SPH_TRY(sphi_gather_sort(context, &s->gather, &s->frame, variant, s->spacing, support));
  /* The list works in fixed point and float: a little more than the support is sure to hold all. */
  return sphi_gather_list(context, &s->gather, &s->frame, interpolator, &s->columns,
                          support * (1 + 1e-6));
}

/* Evaluates up to dim + 1 components from `first` on and writes them out. */
static void evaluate_group(const sph_interpolator *interpolator, const sphi_variant *variant,
                           const sphi_evaluation *e, scratch *s, int64_t first) {
  sph_context *context = interpolator->context;
  const int dim = e->source->dim;
  const int64_t left = s->components - first;
  const int group = left < dim + 1 ? (int)left : dim + 1;
  sphi_pack pack = {.frame = &s->frame,
                    .n = e->source->n,
                    .stride = SPHI_RECORD(dim),
                    .order = s->columns.order,
                    .columns = 1 + group,
                    .record = s->record};
  for (int d = 0; d < dim; d++) pack.x[d] = e->source->field[SPHI_X].data[d];
  pack.value[0] = e->source->field[SPHI_VOL].data[0];
  for (int c = 0; c < group; c++) pack.value[1 + c] = s->component[first + c];
  sphi_pack_run(context, variant, &pack);
  sphi_gather_evaluate(context, &s->gather, &s->frame, interpolator, variant, s->record);
  const sphi_interpolation *work = &s->gather.work;
  for (int32_t k = 0; k < work->n; k++) {
    const int64_t point = s->number[s->gather.columns.order[k]];
    for (int c = 0; c < group; c++) {
      double value = work->value[(int64_t)c * work->n + k];
      if (e->gradient)
        for (int d = 0; d < dim; d++)
          value -= e->gradient[d] * work->moment[(int64_t)d * work->n + k];
      const int64_t out = point * s->components + first + c;
      if (e->values) e->values[out] = value;
      for (int d = 0; d < dim && e->gradients; d++)
        e->gradients[out * dim + d] = work->gradient[((int64_t)c * dim + d) * work->n + k];
    }
    if (e->rungs) e->rungs[point] = work->rung[k];
  }
}

sph_status sphi_interpolator_evaluate(const sph_interpolator *interpolator,
                                      const sphi_variant *variant, const sphi_evaluation *e) {
  sph_context *context = interpolator->context;
  scratch s;
  memset(&s, 0, sizeof s);
  s.gather.work.gradients = e->gradients != NULL;
  /* What the caller knows about the gradient counts, whatever the handle's setting. */
  sph_interpolator compensated = *interpolator;
  compensated.compensation = e->gradient != NULL;
  SPH_TRY(check(interpolator, e));
  sph_status status;
  SPH_TRY_GOTO(find_components(interpolator, e, &s));
  if (e->points == 0) goto fail;
  SPH_TRY_GOTO(sort_sources(interpolator, variant, e->source, &s));
  SPH_TRY_GOTO(sort_points(interpolator, variant, e, &s));
  /* Nothing fails from here on: the outputs may be written. */
  const size_t numbers = (size_t)e->points * (size_t)s.components;
  if (e->values) memset(e->values, 0, numbers * sizeof *e->values);
  if (e->gradients) memset(e->gradients, 0, numbers * (size_t)e->source->dim * sizeof *e->values);
  if (e->rungs)
    for (int64_t k = 0; k < e->points; k++) e->rungs[k] = 0;
  for (int64_t first = 0; first < s.components; first += e->source->dim + 1)
    evaluate_group(&compensated, variant, e, &s, first);
fail:
  scratch_free(context, &s);
  return status;
}

static const sphi_variant *double_variant(const sph_interpolator *interpolator) {
  return sphi_variant_find(interpolator->context->isa, SPH_PRECISION_DOUBLE);
}

static sph_status check_output(const sph_interpolator *interpolator, const char *name,
                               const double *output, int64_t points) {
  SPH_CHECK(interpolator->context, output || points == 0, SPH_E_ARGUMENT,
            "interpolator \"%s\": %s must not be NULL", sph_interpolator_name(interpolator->type),
            name);
  return SPH_OK;
}

sph_status sph_interpolator_evaluate(const sph_interpolator *interpolator,
                                     const sph_particles *source, int64_t points, const double *at,
                                     int fields, const char *const *names, double *values,
                                     int *rungs) {
  if (!interpolator) return SPH_E_ARGUMENT;
  SPH_TRY(check_output(interpolator, "values", values, points));
  const sphi_evaluation evaluation = {.source = source,
                                      .points = points,
                                      .at = at,
                                      .fields = fields,
                                      .names = names,
                                      .values = values,
                                      .rungs = rungs};
  return sphi_interpolator_evaluate(interpolator, double_variant(interpolator), &evaluation);
}

sph_status sph_interpolator_evaluate_compensated(const sph_interpolator *interpolator,
                                                 const sph_particles *source, int64_t points,
                                                 const double *at, const char *name,
                                                 const double *gradient, double *values,
                                                 int *rungs) {
  if (!interpolator) return SPH_E_ARGUMENT;
  SPH_CHECK(interpolator->context, name && gradient, SPH_E_ARGUMENT,
            "interpolator \"%s\": name and gradient must not be NULL",
            sph_interpolator_name(interpolator->type));
  SPH_TRY(check_output(interpolator, "values", values, points));
  const sphi_evaluation evaluation = {.source = source,
                                      .points = points,
                                      .at = at,
                                      .fields = 1,
                                      .names = &name,
                                      .gradient = gradient,
                                      .values = values,
                                      .rungs = rungs};
  return sphi_interpolator_evaluate(interpolator, double_variant(interpolator), &evaluation);
}

static bool has_gradients(sph_interpolator_type type) {
  return type == SPH_INTERPOLATOR_MLS_LINEAR || type == SPH_INTERPOLATOR_MLS_QUADRATIC ||
         type == SPH_INTERPOLATOR_SFDI || type == SPH_INTERPOLATOR_SFDI_PRINTED;
}

sph_status sph_interpolator_evaluate_gradient(const sph_interpolator *interpolator,
                                              const sph_particles *source, int64_t points,
                                              const double *at, int fields,
                                              const char *const *names, double *values,
                                              double *gradients, int *rungs) {
  if (!interpolator) return SPH_E_ARGUMENT;
  SPH_CHECK(interpolator->context, has_gradients(interpolator->type), SPH_E_UNSUPPORTED,
            "interpolator \"%s\" has no gradients; sfdi, mls-linear and mls-quadratic have",
            sph_interpolator_name(interpolator->type));
  SPH_TRY(check_output(interpolator, "gradients", gradients, points));
  const sphi_evaluation evaluation = {.source = source,
                                      .points = points,
                                      .at = at,
                                      .fields = fields,
                                      .names = names,
                                      .values = values,
                                      .gradients = gradients,
                                      .rungs = rungs};
  return sphi_interpolator_evaluate(interpolator, double_variant(interpolator), &evaluation);
}
