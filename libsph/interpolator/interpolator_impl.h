/* Interpolators from the inside: evaluation at clustered target points with the pair sweep. */
#ifndef SPHI_INTERPOLATOR_IMPL_H
#define SPHI_INTERPOLATOR_IMPL_H

#include <sph/interpolator.h>

#include "sweep/variant.h"

struct sph_interpolator {
  sph_context *context;
  int references;
  sph_interpolator_type type;
  sph_kernel *kernel;
  bool compensation;                /* hydrostatic compensation (HC), on by default */
  sph_interpolator_weights weights; /* the caller's */
  void *user;
  double mu; /* improved Shepard: w = r^-mu exp(-mu (r/a)^2 / (1 - (r/R)^lambda)) */
  double lambda;
  double scale; /* a / R */
};

void sphi_interpolator_retain(sph_interpolator *interpolator);

/* Results and scratch of one evaluation at n targets, in the targets' cluster order. */
typedef struct sphi_interpolation {
  int dim;
  int32_t n;
  double *value;  /* [dim + 1][n] pressure, velocity: field f of target k at value[f * n + k] */
  double *moment; /* [dim][n] sum_j phi_j (x_j - x_k) [m]; zero where linear fields are exact, and
                     without compensation. I[f] - gradient . moment is exact for linear f */
  double *
      gradient; /* [dim + 1][dim][n] of the fields, where asked for and the method has it; or NULL */
  double *gamma;       /* [n] sum_j W V_j over the sources: 1 with full support */
  int32_t *neighbours; /* [n] sources inside the support */
  uint8_t *rung;       /* [n] sph_interpolator_type that gave the value, 0 for none */
  int32_t *retry;      /* [n] scratch: clusters that go down the ladder */
  double *nearest; /* SFDI: [dim + dim + 1][n] x_k - x_i and the fields of the nearest particle i */
  int64_t capacity;  /* of n, for the arrays above */
  bool compensation; /* whether moments are wanted */
  bool gradients;    /* whether gradients are, set before the room is made */
  int64_t room;      /* user: neighbours that a target can have */
  double *collected; /* user: [threads][lanes][SPHI_COLLECTED][room] neighbours and weights */
  int64_t collected_capacity;
  int threads; /* user: that there is room for */
} sphi_interpolation;

/* Doubles of a collected neighbour: place, W, V, fields, weight. */
#define SPHI_COLLECTED(dim) (2 * (dim) + 4)

void sphi_interpolation_free(sph_context *context, sphi_interpolation *work);
/* Makes room for n targets; evaluations of at most n targets then allocate nothing. */
sph_status sphi_interpolation_reserve(const sph_interpolator *interpolator, int dim, int32_t n,
                                      sphi_interpolation *work);
/* Makes room for the neighbours in a new list; nothing to do but for the caller's weights. */
sph_status sphi_interpolation_reserve_list(const sph_interpolator *interpolator, int lanes,
                                           const sphi_list *list, sphi_interpolation *work);
/* Evaluates f0..f[dim] of the sources' records (sweep->source[0]) at the targets of the sweep's
 * clusters; work->n, set by the caller, is the number of places. sweep->kernel is set by the callee to
 * the interpolator's kernel. Never fails: every target gets a rung. */
void sphi_interpolate(const sph_interpolator *interpolator, const sphi_variant *variant,
                      sphi_sweep *sweep, sphi_interpolation *work);

/* What the public evaluations do, with any variant. */
typedef struct sphi_evaluation {
  const sph_particles *source;
  int64_t points;
  const double *at; /* [points, dim] */
  int fields;
  const char *const *names;
  const double *gradient; /* [dim] known gradient of the one scalar field, or NULL */
  double *values;         /* [points, components] or NULL if gradients are wanted */
  double *gradients;      /* [points, components, dim] or NULL */
  int *rungs;             /* [points] or NULL */
} sphi_evaluation;

sph_status sphi_interpolator_evaluate(const sph_interpolator *interpolator,
                                      const sphi_variant *variant,
                                      const sphi_evaluation *evaluation);

#endif
