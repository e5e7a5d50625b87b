/* Points at which fields are interpolated again and again: mirror points, probes, gauges. They keep
 * their clusters while they do not move among themselves, and their list while the fluid's holds. */
#ifndef SPHI_GATHER_IMPL_H
#define SPHI_GATHER_IMPL_H

#include "interpolator/interpolator_impl.h"

typedef struct sphi_gather {
  int32_t n;
  double *x[SPHI_MAX_DIM]; /* [n] in the order the owner gave */
  int64_t capacity;
  sphi_columns columns; /* columns.order: place in cluster order -> point; unused after a cut */
  const int32_t *order; /* columns.order, or NULL: points are in cluster order */
  sphi_clusters clusters;
  sphi_clusters wet; /* those with sources near, without boxes: the others are not evaluated */
  sphi_list list;    /* of the wet clusters */
  void *record;      /* packed positions in cluster order */
  bool packed;       /* record holds the present places; the owner of x says when it does not */
  int64_t record_capacity;
  sphi_interpolation work; /* results in cluster order */
} sphi_gather;

void sphi_gather_free(sph_context *context, sphi_gather *gather);
/* Makes room for n points; x[d] can then be filled in. */
sph_status sphi_gather_reserve(sph_context *context, sphi_gather *gather,
                               const sph_interpolator *interpolator, int dim, int32_t n,
                               size_t real_size);
/* For points to cut, of which only the wet ones will need room for results. */
sph_status sphi_gather_reserve_points(sph_context *context, sphi_gather *gather, int dim,
                                      int32_t n);
/* Sorts the points at their present places into clusters. */
sph_status sphi_gather_sort(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                            const sphi_variant *variant, double spacing, double radius);
/* Instead of sorting them, cuts points that are in a good order already into clusters, none longer than
 * `extent` in any direction. */
sph_status sphi_gather_cut(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                           const sphi_variant *variant, double extent);
/* Lists the sources within `radius` of every cluster; points of clusters without any get the rung
 * 0 and zeros, here and until the next list. */
sph_status sphi_gather_list(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                            const sph_interpolator *interpolator, const sphi_columns *sources,
                            double radius);
/* The same after a cut, which clusters without any sources leave: the points of the others move up, and
 * so do their numbers point[0..n-1]. Their results are not valid until they are evaluated. */
sph_status sphi_gather_list_wet(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                                const sph_interpolator *interpolator, const sphi_columns *sources,
                                double radius, const sphi_variant *variant, int32_t *point);
/* Packs the points' places unless they are, and interpolates the fields of the fluid records there. */
void sphi_gather_evaluate(sph_context *context, sphi_gather *gather, const sphi_frame *frame,
                          const sph_interpolator *interpolator, const sphi_variant *variant,
                          const void *record);

/* Side of the columns that makes clusters of `lanes` particles compact. */
double sphi_column_width(int dim, int lanes, double spacing);

#endif
