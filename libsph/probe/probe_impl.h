/* Probes from the inside: a kind measures one row of values, the handle keeps the series. */
#ifndef SPHI_PROBE_IMPL_H
#define SPHI_PROBE_IMPL_H

#include <sph/probe.h>

#include "boundary/boundary_impl.h"
#include "integrator/integrator_impl.h"

/* Kernel sum below which a point has too little fluid for a value. */
#define SPHI_PROBE_THIN 0.05

enum { SPHI_PROBE_POINTS = 100000, SPHI_PROBE_LINE = 1000000, SPHI_PROBE_COLUMNS = 256 };

/* Points at which a probe interpolates: where they were put, or taken along by a wall. */
typedef struct sphi_probe_points {
  sph_interpolator *interpolator;
  sphi_gather gather;     /* x in the order given */
  int64_t build;          /* of the flow, that the gather was listed for; -1: none */
  sph_boundary *boundary; /* NULL: the points stay where they are */
  int wall;
  double *reference;           /* [n, dim] where they are when the wall is where it was created */
  sphi_wall_state now, listed; /* of the wall: at the last sample, and when the gather was listed */
  double *asked;  /* [n, dim] the points, for methods that answer themselves; else NULL */
  double *answer; /* [n, dim] room for what they answer */
} sphi_probe_points;

/* A kind of probe: one table at the end of its part. */
typedef struct sphi_probe_kind {
  const char *name;
  size_t size;     /* bytes of probe->data, zeroed at creation */
  bool has_points; /* data begins with sphi_probe_points */
  sph_status (*measure)(sph_probe *probe, double *values);
  void (*release)(sph_probe *probe); /* what data holds; NULL: nothing */
} sphi_probe_kind;

typedef struct sphi_probe_column {
  char *name, *unit;
} sphi_probe_column;

struct sph_probe {
  sph_context *context;
  sph_integrator *flow;
  const sphi_probe_kind *kind;
  void *data; /* the kind's own */
  char *name;
  int columns;
  sphi_probe_column *column;
  double interval, start; /* samples are due at start + k interval */
  int64_t due;            /* the next k */
  double *row;            /* [1 + columns] the sample that is being taken */
  int64_t count, capacity;
  double *series; /* [capacity][1 + columns]: time, values */
};

/* A probe of `kind` that does not observe yet. units NULL: none. */
sph_status sphi_probe_new(sph_integrator *flow, const sphi_probe_kind *kind, int columns,
                          const char *const *names, const char *const *units, sph_probe **out);
/* The last act of a creation, which began with sphi_probe_new and whose status so far is given:
 * observes and hands the probe over, or frees it and returns the error. */
sph_status sphi_probe_finish(sph_probe *probe, sph_status status, sph_probe **out);
/* Walls and domain; the bounds are always known. */
sphi_surroundings sphi_probe_surroundings(const sph_integrator *flow);
/* Refuses a point that is not finite, deep inside a wall or outside the domain. */
sph_status sphi_probe_check_point(const sph_integrator *flow, const sphi_surroundings *around,
                                  const char *kind, const double *x);
/* Room for points of a method that answers itself; nothing for others. */
sph_status sphi_probe_prepare(sph_probe *probe);
/* The points for such a method, in the order given. */
const double *sphi_probe_places(sphi_probe_points *points, int dim);
/* Interpolates at the points of a kind that has them, for now. */
sph_status sphi_probe_gather(sph_probe *probe);
void sphi_probe_points_free(sph_context *context, sphi_probe_points *points);
/* Refuses a boundary that is not the flow's, and a wall that it has not. */
sph_status sphi_probe_check_wall(const sph_integrator *flow, const char *kind,
                                 const sph_boundary *boundary, int wall);
/* Refuses a vector that is not of length 1. */
sph_status sphi_probe_check_direction(const sph_integrator *flow, const char *kind,
                                      const char *what, const double *direction);

#define SPHI_PROBE_BEGIN(flow, kind, out) \
  if (out) *(out) = NULL;                 \
  if (!(flow)) return SPH_E_ARGUMENT;     \
  sph_context *context = (flow)->context; \
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "probe \"%s\": out is NULL", (kind).name)

#endif
