/* The pair sweep: every sum over neighbours, in every method, is targets that gather from sources
 * inside a radius with a pair function. The loops exist once per instruction set and precision; the
 * variant is picked at run time. */
#ifndef SPHI_VARIANT_H
#define SPHI_VARIANT_H

#include "kernel/kernel_impl.h"
#include "sweep/columns.h"

enum { SPHI_KERNEL_ROWS = 7, SPHI_PAD = 16 };

/* One gather: targets in clusters, and up to two lists of sources with their packed records. */
typedef struct sphi_sweep {
  const sphi_frame *frame;
  const sph_kernel *kernel;
  const sphi_clusters *targets;
  const void *target; /* packed records of the targets; their positions come first */
  int target_stride;  /* reals a record */
  struct {
    const sphi_list *list; /* NULL: no second sources */
    const void *record;
  } source[2];
  double
      prune; /* [m] operators that prune lists leave in front what is within it of a target; 0: all */
  const int32_t *subset; /* NULL: all clusters; else the numbers of those to do */
  int32_t subset_count;
} sphi_sweep;

/* Does the clusters begin..end-1 (of the subset if there is one). */
typedef void (*sphi_loop)(const sphi_sweep *sweep, const void *arguments, int32_t begin,
                          int32_t end);

/* Fills records: position, then `columns` values less their shifts, in target or source order. */
typedef struct sphi_pack {
  const sphi_frame *frame;
  int32_t n;
  int stride;           /* reals a record; those past dim + columns are left alone */
  const int32_t *place; /* NULL: records 0..n-1; else records place[0..n-1] alone */
  const int32_t *order; /* NULL: record k is point k; else point order[k] */
  const double *x[SPHI_MAX_DIM];
  int columns;
  const double *value[8];
  double shift[8];
  void *record; /* (n + SPHI_PAD) * stride reals */
} sphi_pack;

typedef void (*sphi_pack_function)(const sphi_pack *pack, int32_t begin, int32_t end);

/* Appends, for clusters begin..end-1, the sources near each to one part of the list; part->used is -1
 * if more columns are near than there is room for. */
typedef void (*sphi_list_function)(sphi_list *list, int32_t part, const sphi_frame *frame,
                                   const sphi_clusters *targets, const sphi_columns *sources,
                                   double radius, int32_t begin, int32_t end);

/* Operators: a row here and a file op_<name>.c that stamps the loops, [kernel row][2D, 3D]. */
#define SPHI_OPERATOR_LIST(X) \
  X(gradient)                 \
  X(momentum)                 \
  X(rates)                    \
  X(reaction)                 \
  X(projection)               \
  X(laplacian)                \
  X(viscosity)                \
  X(shepard)                  \
  X(shepard_any)              \
  X(classic_shepard)          \
  X(normalized)               \
  X(nearest)                  \
  X(sfdi)                     \
  X(mls_linear)               \
  X(mls_quadratic)            \
  X(weights)

enum {
#define SPHI_OPERATOR_ENUM(name) SPHI_OPERATOR_##name,
  SPHI_OPERATOR_LIST(SPHI_OPERATOR_ENUM)
#undef SPHI_OPERATOR_ENUM
      SPHI_OPERATORS
};

/* Does the particles (or, `carry`, those of the cells) begin..end-1 without their neighbours; returns the first bad
 * one or INT32_MAX. */
typedef int32_t (*sphi_update)(const void *arguments, int32_t begin, int32_t end);

/* Updates: a row here and a function sphi_<name>_update_<variant> in one of the files op_*.c. */
#define SPHI_UPDATE_LIST(X) \
  X(initial_stage)          \
  X(middle_stage)           \
  X(final_stage)            \
  X(kick)                   \
  X(move)                   \
  X(carry)

enum {
#define SPHI_UPDATE_ENUM(name) SPHI_UPDATE_##name,
  SPHI_UPDATE_LIST(SPHI_UPDATE_ENUM)
#undef SPHI_UPDATE_ENUM
      SPHI_UPDATES
};

typedef struct sphi_variant {
  const char *name;
  sph_isa isa;
  int lanes;
  bool is_double;
  size_t real_size;
  const sphi_loop (*loops[SPHI_OPERATORS])[2];
  sphi_update updates[SPHI_UPDATES];
  sphi_pack_function pack;
  sphi_list_function list; /* NULL in double variants: lists are built by the float one */
} sphi_variant;

/* The variant for an instruction set and precision. */
const sphi_variant *sphi_variant_find(sph_isa isa, sph_precision precision);
/* One lane in double without relaxed arithmetic: the reference. */
const sphi_variant *sphi_variant_reference(void);

/* Runs an operator over all clusters with the context's threads. */
void sphi_sweep_run(sph_context *context, const sphi_variant *variant, int operator_index,
                    const sphi_sweep *sweep, const void *arguments);
/* Pairs of a target and a source that the sweep's lists hold. */
int64_t sphi_sweep_pairs(const sphi_sweep *sweep);
void sphi_pack_run(sph_context *context, const sphi_variant *variant, const sphi_pack *pack);

/* Layout of a fluid record, which every interpolator can read too: x[dim] V f0 f[dim] d g[dim], with
 * f0 the pressure, f the velocity, d = rho - rho0 and g the renormalised density gradient. */
#define SPHI_RECORD_V(dim) (dim)
#define SPHI_RECORD_F(dim) ((dim) + 1)
#define SPHI_RECORD_D(dim) (2 * (dim) + 2)
#define SPHI_RECORD_G(dim) (2 * (dim) + 3)
#define SPHI_RECORD(dim) (3 * (dim) + 3)
/* Layout of a ghost record: x[dim] V p v[dim] s k, with s = 1 where it drags (no slip) and an int32_t k
 * in the place of the last real: 0, or its gates are k records farther: their number, and that many
 * planes a[dim + 1] through which fluid at x_f sees the ghost, where a . (x_f - x) + a[dim] > 0. */
#define SPHI_GHOST_S(dim) (2 * (dim) + 2)
#define SPHI_GHOST_GATES(dim) (2 * (dim) + 3)
#define SPHI_GHOST(dim) (2 * (dim) + 4)
#define SPHI_GATES(dim) (2 * (dim)-1) /* at most */

#endif
