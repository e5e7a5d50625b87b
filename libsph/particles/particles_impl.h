/* Particle sets from the inside: storage order changes with every sort, ids and ranks do not. */
#ifndef SPHI_PARTICLES_IMPL_H
#define SPHI_PARTICLES_IMPL_H

#include <sph/particles.h>

#include "core/keep.h"

#define SPHI_MAX_COMPONENTS 9
/* Leaves room to round counts up without leaving sph_index. */
#define SPHI_MAX_PARTICLES ((int64_t)INT32_MAX - 1024)

typedef struct sphi_field {
  char *name;
  char *unit;
  int components;
  double *data[SPHI_MAX_COMPONENTS]; /* [capacity] a component, in storage order */
} sphi_field;

/* The fields that every set has, in this order. */
enum { SPHI_X, SPHI_V, SPHI_RHO, SPHI_P, SPHI_M, SPHI_VOL, SPHI_FIELDS };

typedef struct sphi_lease {
  double *values;
  int field;
  sph_particles *writer; /* the set as the writer got it; NULL for a read lease */
} sphi_lease;

/* Apart from the set, so that reading a const set can open a lease. */
typedef struct sphi_lease_list {
  int64_t count, capacity;
  sphi_lease *lease;
} sphi_lease_list;

struct sph_particles {
  sph_context *context;
  int references;
  char *name;
  int dim;
  double spacing;
  int64_t revision; /* changes whenever the caller changes anything; sorts leave it */
  sph_index n;
  int64_t capacity; /* of every per-particle array */
  int64_t next_id;
  int64_t *id;     /* [n] in storage order */
  sph_index *rank; /* storage index -> position in id order */
  sph_index *slot; /* position in id order -> storage index */
  int64_t field_capacity;
  int fields;
  sphi_field *field; /* moves when a field is added, its arrays when the capacity grows */
  void *scratch;     /* capacity * 8 bytes: permutations need no allocation */
  void *aside;       /* what permuting threads take from one another; they can do without */
  int64_t aside_capacity;
  sphi_lease_list *leases;
};

void sphi_particles_retain(sph_particles *particles);
/* Storage place k takes what was at order[k]; order is a permutation of 0..n-1, not in `scratch`.
 * Never fails. Arrays stay where they are; `revision` stays as it is. */
void sphi_particles_permute(sph_particles *particles, const sph_index *order);
/* The field called `name`, or NULL with SPH_E_NAME and a suggestion recorded. */
sphi_field *sphi_particles_field(const sph_particles *particles, const char *name);
/* What a checkpoint keeps: everything, in storage order. Loading counts as a change by the caller. */
sph_status sphi_particles_keep(sph_particles *particles, sphi_keep *keep);

/* For libsph/particles only. */

/* Below this many particles starting threads costs more than it gains. */
enum { SPHI_PARTICLES_PARALLEL_FROM = 16384 };

/* dx^dim */
static inline double sphi_particles_cell(const sph_particles *particles) {
  const double dx = particles->spacing;
  return particles->dim == 2 ? dx * dx : dx * dx * dx;
}

/* Makes every array hold `count` particles; on failure nothing changes and false is returned. */
bool sphi_particles_reserve(sph_particles *particles, int64_t count);
sph_status sphi_particles_insert_field(sph_particles *particles, const char *name, int components,
                                       const char *unit);
void sphi_particles_free_field(sph_context *context, sphi_field *field);
/* Refuses `count` more particles if a lease is open or the set would get too large. */
sph_status sphi_particles_check_room(const sph_particles *particles, double count);
sph_status sphi_particles_check_density(const sph_particles *particles, double density);
/* Refuses points [count, dim] closer than `minimum` to a particle or, if `among`, to one another. */
sph_status sphi_particles_check_distance(const sph_particles *particles, int64_t count,
                                         const double *x, double minimum, bool among);
/* Adds particles at rest at the points x [count, dim], which have been checked. */
sph_status sphi_particles_append(sph_particles *particles, int64_t count, const double *x,
                                 double density);

#endif
