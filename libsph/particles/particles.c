/* Particle sets: life, storage, adding, removing, sorting. */
#include "particles/particles_impl.h"

enum { FIRST_CAPACITY = 64, MAX_NAME = 63 };

static sph_status create_fields(sph_particles *particles) {
  const bool plane = particles->dim == 2;
  const int dim = particles->dim;
  const struct {
    const char *name;
    int components;
    const char *unit;
  } fields[SPHI_FIELDS] = {
      [SPHI_X] = {SPH_POSITION, dim, "m"},
      [SPHI_V] = {SPH_VELOCITY, dim, "m/s"},
      [SPHI_RHO] = {SPH_DENSITY, 1, "kg/m^3"},
      [SPHI_P] = {SPH_PRESSURE, 1, "Pa"},
      [SPHI_M] = {SPH_MASS, 1, plane ? "kg/m" : "kg"},
      [SPHI_VOL] = {SPH_VOLUME, 1, plane ? "m^2" : "m^3"},
  };
  for (int k = 0; k < SPHI_FIELDS; k++)
    SPH_TRY(sphi_particles_insert_field(particles, fields[k].name, fields[k].components,
                                        fields[k].unit));
  return SPH_OK;
}

sph_status sph_particles_create(sph_context *context, int dim, double spacing,
                                sph_particles **out) {
  SPH_CHECK(context, out, SPH_E_ARGUMENT, "particles: out must not be NULL");
  *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, dim == 2 || dim == 3, SPH_E_ARGUMENT, "particles: dim must be 2 or 3, got %d",
            dim);
  SPH_CHECK(context, spacing >= 1e-100 && spacing <= 1e100, SPH_E_ARGUMENT,
            "particles: spacing must be > 0 m (1e-100 to 1e100), got %g", spacing);
  sph_particles *particles = SPHI_NEW(context, 1, sph_particles);
  SPH_CHECK(context, particles, SPH_E_MEMORY, "particles: no memory for a new set");
  sphi_context_retain(context);
  particles->context = context;
  particles->references = 1;
  particles->dim = dim;
  particles->spacing = spacing;
  particles->revision = 1;
  particles->name = sphi_copy_text(context, "particles");
  particles->leases = SPHI_NEW(context, 1, sphi_lease_list);
  sph_status status = SPH_E_MEMORY;
  if (particles->name && particles->leases && sphi_particles_reserve(particles, FIRST_CAPACITY))
    status = create_fields(particles);
  if (status != SPH_OK) {
    sph_particles_destroy(&particles);
    return SPHI_ERROR(context, status, "particles: no memory for a new set");
  }
  *out = particles;
  return SPH_OK;
}

void sphi_particles_retain(sph_particles *particles) { particles->references++; }

void sph_particles_destroy(sph_particles **particles) {
  if (!particles || !*particles) return;
  sph_particles *dead = *particles;
  *particles = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  if (dead->leases) {
    for (int64_t k = 0; k < dead->leases->count; k++)
      sphi_free(context, dead->leases->lease[k].values);
    sphi_free(context, dead->leases->lease);
  }
  sphi_free(context, dead->leases);
  for (int k = 0; k < dead->fields; k++) sphi_particles_free_field(context, &dead->field[k]);
  sphi_free(context, dead->field);
  sphi_free(context, dead->id);
  sphi_free(context, dead->rank);
  sphi_free(context, dead->slot);
  sphi_free(context, dead->scratch);
  sphi_free(context, dead->aside);
  sphi_free(context, dead->name);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

sph_status sph_particles_set_name(sph_particles *particles, const char *name) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  SPH_CHECK(context, name, SPH_E_ARGUMENT, "particles \"%s\": the new name must not be NULL",
            particles->name);
  const size_t length = strlen(name);
  SPH_CHECK(context, length >= 1 && length <= MAX_NAME, SPH_E_ARGUMENT,
            "particles \"%s\": the new name must be 1 to %d bytes long, got %zu", particles->name,
            MAX_NAME, length);
  for (size_t k = 0; k < length; k++)
    SPH_CHECK(
        context, (unsigned char)name[k] >= 0x20 && name[k] != 0x7f, SPH_E_ARGUMENT,
        "particles \"%s\": the new name must have no control characters, got 0x%02x at byte %zu",
        particles->name, (unsigned)(unsigned char)name[k], k);
  char *copy = sphi_copy_text(context, name);
  SPH_CHECK(context, copy, SPH_E_MEMORY, "particles \"%s\": no memory for a name", particles->name);
  sphi_free(context, particles->name);
  particles->name = copy;
  return SPH_OK;
}

const char *sph_particles_name(const sph_particles *particles) {
  return particles ? particles->name : "";
}

sph_index sph_particles_count(const sph_particles *particles) {
  return particles ? particles->n : 0;
}

int sph_particles_dim(const sph_particles *particles) { return particles ? particles->dim : 0; }

double sph_particles_spacing(const sph_particles *particles) {
  return particles ? particles->spacing : 0;
}

int64_t sph_particles_revision(const sph_particles *particles) {
  return particles ? particles->revision : 0;
}

static void *move_array(sph_context *context, void *old, void *fresh, int64_t count, size_t size) {
  if (count) memcpy(fresh, old, (size_t)count * size);
  sphi_free(context, old);
  return fresh;
}

bool sphi_particles_reserve(sph_particles *particles, int64_t count) {
  if (count <= particles->capacity) return true;
  sph_context *context = particles->context;
  int64_t wanted = particles->capacity + particles->capacity / 2;
  if (wanted > SPHI_MAX_PARTICLES) wanted = SPHI_MAX_PARTICLES;
  if (wanted < count) wanted = count;
  /* The arrays of all components, then id, rank, slot, scratch. */
  size_t components = 0;
  for (int f = 0; f < particles->fields; f++) components += (size_t)particles->field[f].components;
  const size_t arrays = components + 4;
  void **fresh = SPHI_NEW(context, arrays, void *);
  if (!fresh) return false;
  bool complete = true;
  for (size_t a = 0; a < arrays && complete; a++) {
    const bool index = a == components + 1 || a == components + 2;
    fresh[a] = sphi_alloc(context, (size_t)wanted, index ? sizeof(sph_index) : 8);
    complete = fresh[a] != NULL;
  }
  if (!complete) {
    for (size_t a = 0; a < arrays; a++) sphi_free(context, fresh[a]);
    sphi_free(context, fresh);
    return false;
  }
  const int64_t n = particles->n;
  size_t a = 0;
  for (int f = 0; f < particles->fields; f++)
    for (int c = 0; c < particles->field[f].components; c++) {
      double **data = &particles->field[f].data[c];
      *data = move_array(context, *data, fresh[a++], n, sizeof(double));
    }
  particles->id = move_array(context, particles->id, fresh[a++], n, sizeof(int64_t));
  particles->rank = move_array(context, particles->rank, fresh[a++], n, sizeof(sph_index));
  particles->slot = move_array(context, particles->slot, fresh[a++], n, sizeof(sph_index));
  particles->scratch = move_array(context, particles->scratch, fresh[a++], 0, 1);
  particles->capacity = wanted;
  sphi_free(context, fresh);
  return true;
}

static sph_status check_no_lease(const sph_particles *particles) {
  SPH_CHECK(particles->context, particles->leases->count == 0, SPH_E_ARGUMENT,
            "particles \"%s\": %lld leases are open, so particles cannot be added or removed; call "
            "sph_particles_release first",
            particles->name, (long long)particles->leases->count);
  return SPH_OK;
}

sph_status sphi_particles_check_room(const sph_particles *particles, double count) {
  SPH_TRY(check_no_lease(particles));
  const double total = (double)particles->n + count;
  SPH_CHECK(
      particles->context, total <= (double)SPHI_MAX_PARTICLES, SPH_E_ARGUMENT,
      "particles \"%s\": a set holds at most %lld particles, got %.15g; use a larger spacing or "
      "a smaller region",
      particles->name, (long long)SPHI_MAX_PARTICLES, total);
  return SPH_OK;
}

sph_status sphi_particles_check_density(const sph_particles *particles, double density) {
  SPH_CHECK(particles->context, isfinite(density) && density > 0, SPH_E_ARGUMENT,
            "particles \"%s\": density must be finite and > 0 kg/m^3, got %g", particles->name,
            density);
  const double mass = density * sphi_particles_cell(particles);
  SPH_CHECK(
      particles->context, isfinite(mass) && mass > 0, SPH_E_ARGUMENT,
      "particles \"%s\": density %g kg/m^3 and spacing %g m give a mass of %g; it must be finite "
      "and > 0",
      particles->name, density, particles->spacing, mass);
  return SPH_OK;
}

sph_status sphi_particles_append(sph_particles *particles, int64_t count, const double *x,
                                 double density) {
  const int64_t first = particles->n, total = first + count;
  SPH_CHECK(particles->context, sphi_particles_reserve(particles, total), SPH_E_MEMORY,
            "particles \"%s\": no memory for %lld particles", particles->name, (long long)total);
  const int dim = particles->dim;
  const double volume = sphi_particles_cell(particles), mass = density * volume;
  for (int f = 0; f < particles->fields; f++)
    for (int c = 0; c < particles->field[f].components; c++)
      memset(particles->field[f].data[c] + first, 0, (size_t)count * sizeof(double));
  for (int64_t k = first; k < total; k++) {
    for (int d = 0; d < dim; d++) particles->field[SPHI_X].data[d][k] = x[(k - first) * dim + d];
    particles->field[SPHI_RHO].data[0][k] = density;
    particles->field[SPHI_M].data[0][k] = mass;
    particles->field[SPHI_VOL].data[0][k] = volume;
    particles->id[k] = particles->next_id++;
    particles->rank[k] = (sph_index)k;
    particles->slot[k] = (sph_index)k;
  }
  particles->n = (sph_index)total;
  particles->revision++;
  return SPH_OK;
}

sph_status sph_particles_add(sph_particles *particles, int64_t count, const double *x,
                             double density, int64_t *ids) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  const char *name = particles->name;
  SPH_CHECK(context, count >= 0, SPH_E_ARGUMENT, "particles \"%s\": count must be >= 0, got %lld",
            name, (long long)count);
  SPH_CHECK(context, x || count == 0, SPH_E_ARGUMENT, "particles \"%s\": x must not be NULL", name);
  SPH_TRY(sphi_particles_check_density(particles, density));
  SPH_TRY(sphi_particles_check_room(particles, (double)count));
  if (count == 0) return SPH_OK;
  const int dim = particles->dim;
  for (int64_t k = 0; k < count * dim; k++)
    SPH_CHECK(
        context, isfinite(x[k]), SPH_E_ARGUMENT,
        "particles \"%s\": position of new particle %lld, component %d, must be finite, got %g",
        name, (long long)(k / dim), (int)(k % dim), x[k]);
  SPH_TRY(sphi_particles_check_distance(particles, count, x, 0.1 * particles->spacing, true));
  SPH_TRY(sphi_particles_append(particles, count, x, density));
  for (int64_t k = 0; ids && k < count; k++) ids[k] = particles->next_id - count + k;
  return SPH_OK;
}

/* The rank of the particle with this id, or -1. Ids ascend with the rank. */
static sph_index find_rank(const sph_particles *particles, int64_t id) {
  sph_index first = 0, last = particles->n;
  while (first < last) {
    const sph_index middle = first + (last - first) / 2;
    const int64_t found = particles->id[particles->slot[middle]];
    if (found == id) return middle;
    if (found < id)
      first = middle + 1;
    else
      last = middle;
  }
  return -1;
}

/* Closes the gaps in storage; rank_after[old rank] is the new rank, or -1 for the removed. */
static void compact(sph_particles *particles, const sph_index *rank_after) {
  sph_index kept = 0;
  for (sph_index k = 0; k < particles->n; k++) {
    const sph_index rank = rank_after[particles->rank[k]];
    if (rank < 0) continue;
    for (int f = 0; f < particles->fields; f++) {
      const sphi_field *field = &particles->field[f];
      for (int c = 0; c < field->components; c++) field->data[c][kept] = field->data[c][k];
    }
    particles->id[kept] = particles->id[k];
    particles->rank[kept] = rank;
    particles->slot[rank] = kept;
    kept++;
  }
  particles->n = kept;
}

sph_status sph_particles_remove(sph_particles *particles, int64_t count, const int64_t *ids) {
  if (!particles) return SPH_E_ARGUMENT;
  sph_context *context = particles->context;
  const char *name = particles->name;
  SPH_CHECK(context, count >= 0, SPH_E_ARGUMENT, "particles \"%s\": count must be >= 0, got %lld",
            name, (long long)count);
  SPH_CHECK(context, ids || count == 0, SPH_E_ARGUMENT, "particles \"%s\": ids must not be NULL",
            name);
  SPH_TRY(check_no_lease(particles));
  if (count == 0) return SPH_OK;
  sph_index *rank_after = particles->scratch;
  memset(rank_after, 0, (size_t)particles->n * sizeof *rank_after);
  for (int64_t k = 0; k < count; k++) {
    const sph_index rank = find_rank(particles, ids[k]);
    SPH_CHECK(context, rank >= 0, SPH_E_ARGUMENT, "particles \"%s\": no particle has id %lld", name,
              (long long)ids[k]);
    SPH_CHECK(context, !rank_after[rank], SPH_E_ARGUMENT,
              "particles \"%s\": id %lld is given twice; each particle can be removed once", name,
              (long long)ids[k]);
    rank_after[rank] = 1;
  }
  sph_index kept = 0;
  for (sph_index r = 0; r < particles->n; r++) rank_after[r] = rank_after[r] ? -1 : kept++;
  compact(particles, rank_after);
  particles->revision++;
  return SPH_OK;
}

/* ------------------------------------------------------------------------------------- permuting */

/* Each part of the places is permuted by one thread: it copies its new values to its part of `scratch`
 * and back. Values from other parts, few if the particles were nearly in order, are kept aside first,
 * before anybody writes. */
typedef struct permutation {
  sph_particles *particles;
  const sph_index *order;
  int parts;
  sph_index comers;                      /* places that take values from another part */
  const sph_index *coming;               /* [comers] those places, in order */
  char *aside;                           /* [array][comers] their values, 8 bytes each */
  sph_index first[SPHI_MAX_THREADS + 1]; /* a part's first comer */
} permutation;

static sph_index part_begin(const permutation *p, int part) {
  return (sph_index)((int64_t)p->particles->n * part / p->parts);
}

/* Copies of values of 8 or 4 bytes: every call has a literal size. */
static inline __attribute__((always_inline)) void copy_value(void *to, sph_index k,
                                                             const void *from, sph_index j,
                                                             size_t size) {
  memcpy((char *)to + (size_t)k * size, (const char *)from + (size_t)j * size, size);
}

static inline __attribute__((always_inline)) void keep_array(const permutation *p, int part, int at,
                                                             const void *array, size_t size) {
  char *aside = p->aside + (size_t)at * (size_t)p->comers * 8;
  for (sph_index j = p->first[part]; j < p->first[part + 1]; j++)
    copy_value(aside, j, array, p->order[p->coming[j]], size);
}

static inline __attribute__((always_inline)) void permute_array(const permutation *p, int part,
                                                                int at, void *array, size_t size) {
  const sph_index begin = part_begin(p, part), end = part_begin(p, part + 1);
  const size_t bytes = (size_t)(end - begin) * size;
  char *values = (char *)p->particles->scratch + (size_t)begin * 8;
  const char *aside = p->aside + (size_t)at * (size_t)p->comers * 8;
  if (p->comers == 0) {
    for (sph_index k = begin; k < end; k++) copy_value(values, k - begin, array, p->order[k], size);
  } else {
    for (sph_index k = begin; k < end; k++) {
      const sph_index from = p->order[k];
      copy_value(values, k - begin, array, from >= begin && from < end ? from : begin, size);
    }
    for (sph_index j = p->first[part]; j < p->first[part + 1]; j++)
      copy_value(values, p->coming[j] - begin, aside, j, size);
  }
  memcpy((char *)array + (size_t)begin * size, values, bytes);
}

static void keep_part(const permutation *p, int part) {
  const sph_particles *particles = p->particles;
  int at = 0;
  for (int f = 0; f < particles->fields; f++)
    for (int c = 0; c < particles->field[f].components; c++)
      keep_array(p, part, at++, particles->field[f].data[c], 8);
  keep_array(p, part, at++, particles->id, 8);
  keep_array(p, part, at, particles->rank, 4);
}

static void permute_part(const permutation *p, int part) {
  sph_particles *particles = p->particles;
  int at = 0;
  for (int f = 0; f < particles->fields; f++)
    for (int c = 0; c < particles->field[f].components; c++)
      permute_array(p, part, at++, particles->field[f].data[c], 8);
  permute_array(p, part, at++, particles->id, 8);
  permute_array(p, part, at, particles->rank, 4);
  const sph_index end = part_begin(p, part + 1);
  for (sph_index k = part_begin(p, part); k < end; k++) particles->slot[particles->rank[k]] = k;
}

/* Finds what comes from other parts and makes room for it; false if that is much, or too much. */
static bool find_comers(permutation *p) {
  sph_particles *particles = p->particles;
  const sph_index most = particles->n / 16;
  size_t arrays = 2;
  for (int f = 0; f < particles->fields; f++) arrays += (size_t)particles->field[f].components;
  sph_index *coming = particles->scratch; /* until it is clear how many they are */
  p->comers = 0;
  for (int part = 0; part < p->parts; part++) {
    const sph_index begin = part_begin(p, part), end = part_begin(p, part + 1);
    p->first[part] = p->comers;
    for (sph_index k = begin; k < end && p->comers < most; k++) {
      coming[p->comers] = k;
      p->comers += p->order[k] < begin || p->order[k] >= end;
    }
  }
  p->first[p->parts] = p->comers;
  if (p->comers >= most) return false;
  const size_t row = (size_t)p->comers;
  /* Head room, since how many they are varies from sort to sort. */
  const sph_index usual = particles->n / 256;
  const int64_t wanted = (int64_t)(arrays + 1) * (p->comers > usual ? p->comers : usual);
  if (!sphi_reserve(particles->context, &particles->aside, &particles->aside_capacity, wanted, 8))
    return false;
  p->aside = particles->aside;
  p->coming = (sph_index *)(void *)(p->aside + 8 * arrays * row);
  if (row) memcpy(p->aside + 8 * arrays * row, coming, row * sizeof *coming);
  return true;
}

void sphi_particles_permute(sph_particles *particles, const sph_index *order) {
  const sph_index n = particles->n;
  sph_index in_place = 0;
  while (in_place < n && order[in_place] == in_place) in_place++;
  if (in_place == n) return;
  permutation p = {.particles = particles, .order = order, .parts = 1};
  if (n >= SPHI_PARTICLES_PARALLEL_FROM && particles->context->threads > 1) {
    p.parts = particles->context->threads;
    if (!find_comers(&p)) p = (permutation){.particles = particles, .order = order, .parts = 1};
  }
#pragma omp parallel num_threads(p.parts) if (p.parts > 1)
  {
    if (p.comers > 0) {
#pragma omp for schedule(static, 1)
      for (int part = 0; part < p.parts; part++) keep_part(&p, part);
    }
#pragma omp for schedule(static, 1) nowait
    for (int part = 0; part < p.parts; part++) permute_part(&p, part);
  }
}
