/* Fixed ghost particles: creation, motion, and the assignment of mirrored values. */
#include "boundary/boundary_impl.h"

#include <stdlib.h>

/* Bits of a coordinate along the curve that orders mirror points; below so many of them starting threads
 * costs more than it gains. */
enum { CURVE_BITS = 20, SERIAL = 2048 };

/* In column widths: longest cluster of mirror points. */
static const double CLUSTER_EXTENT = 2;

void sphi_boundary_retain(sph_boundary *boundary) { boundary->references++; }

static void free_arrays(sph_boundary *boundary) {
  sph_context *context = boundary->context;
  for (int d = 0; d < SPHI_MAX_DIM; d++) {
    sphi_free(context, boundary->x[d]);
    boundary->x[d] = NULL;
  }
  sphi_free(context, boundary->order);
  sphi_free(context, boundary->place);
  sphi_free(context, boundary->near);
  boundary->order = boundary->place = NULL;
  boundary->near = NULL;
  boundary->ordered = 0;
}

void sph_boundary_destroy(sph_boundary **boundary) {
  if (!boundary || !*boundary) return;
  sph_boundary *dead = *boundary;
  *boundary = NULL;
  if (--dead->references > 0) return;
  sph_context *context = dead->context;
  free_arrays(dead);
  sphi_free(context, dead->chosen);
  sphi_free(context, dead->wet);
  sphi_free(context, dead->kept);
  sphi_free(context, dead->record);
  sphi_free(context, dead->wall_of);
  sphi_ghost_points_free(context, &dead->points);
  sphi_gather_free(context, &dead->mirrors);
  sphi_columns_free(context, &dead->columns);
  for (int w = 0; w < dead->walls; w++) sph_wall_destroy(&dead->wall[w]);
  sph_interpolator_destroy(&dead->interpolator);
  sphi_free(context, dead);
  sph_context_destroy(&context);
}

/* Ghosts of one more wall at the end of the tables. */
static sph_status append_wall(sph_boundary *boundary, sph_wall *wall) {
  sph_context *context = boundary->context;
  SPH_CHECK(context, sphi_wall_dim(wall) == boundary->dim, SPH_E_ARGUMENT,
            "boundary: wall \"%s\" has dimension %d, the interpolator's kernel has %d",
            sphi_wall_name(wall), sphi_wall_dim(wall), boundary->dim);
  SPH_CHECK(context, boundary->walls < SPHI_MAX_WALLS, SPH_E_ARGUMENT,
            "boundary: at most %d walls, wall \"%s\" is one more", SPHI_MAX_WALLS,
            sphi_wall_name(wall));
  const int64_t before = boundary->points.n, skipped = boundary->points.skipped;
  const int64_t gated = boundary->points.gated_count;
  sph_status status = sphi_wall_make_ghosts(
      wall, boundary->spacing, boundary->interpolator->kernel->support, &boundary->points);
  if (status == SPH_OK && boundary->points.n > INT32_MAX - 1024)
    status = SPHI_ERROR(context, SPH_E_ARGUMENT, "boundary: %lld ghosts are more than fit",
                        (long long)boundary->points.n);
  if (status == SPH_OK &&
      !sphi_reserve(context, (void **)&boundary->wall_of, &boundary->wall_of_capacity,
                    boundary->points.n, sizeof *boundary->wall_of))
    status = SPHI_ERROR(context, SPH_E_MEMORY, "boundary: no memory for %lld ghosts",
                        (long long)boundary->points.n);
  if (status != SPH_OK) {
    boundary->points.n = before;
    boundary->points.skipped = skipped;
    boundary->points.gated_count = gated;
    return status;
  }
  for (int64_t k = before; k < boundary->points.n; k++)
    boundary->wall_of[k] = (uint8_t)boundary->walls;
  sphi_wall_retain(wall);
  boundary->wall[boundary->walls++] = wall;
  boundary->counts.ghosts = boundary->counts.inactive = boundary->points.n;
  boundary->counts.skipped = boundary->points.skipped;
  return SPH_OK;
}

sph_status sph_boundary_create(sph_context *context, sph_wall *wall, double spacing,
                               sph_interpolator *interpolator, sph_boundary **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, wall && interpolator && out, SPH_E_ARGUMENT, "boundary: %s is NULL",
            !wall           ? "wall"
            : !interpolator ? "interpolator"
                            : "out");
  SPH_CHECK(context, interpolator->context == context, SPH_E_ARGUMENT,
            "boundary: the interpolator is of another context");
  SPH_CHECK(context, isfinite(spacing) && spacing > 0, SPH_E_ARGUMENT,
            "boundary: spacing must be > 0 m, got %g", spacing);
  sph_boundary *boundary = SPHI_NEW(context, 1, sph_boundary);
  SPH_CHECK(context, boundary, SPH_E_MEMORY, "boundary: no memory");
  sphi_context_retain(context);
  boundary->context = context;
  boundary->references = 1;
  boundary->dim = interpolator->kernel->dim;
  boundary->spacing = spacing;
  boundary->interpolator = interpolator;
  sphi_interpolator_retain(interpolator);
  boundary->thin = 0.05;
  boundary->no_suction = true;
  const sph_status status = append_wall(boundary, wall);
  if (status != SPH_OK) {
    sph_boundary_destroy(&boundary);
    return status;
  }
  *out = boundary;
  return SPH_OK;
}

sph_status sph_boundary_add_wall(sph_boundary *boundary, sph_wall *wall) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, wall, SPH_E_ARGUMENT, "boundary: wall is NULL");
  SPH_CHECK(
      boundary->context, !boundary->in_use, SPH_E_ARGUMENT,
      "boundary: wall \"%s\" comes too late, an integrator uses the boundary; add walls first",
      sphi_wall_name(wall));
  return append_wall(boundary, wall);
}

sph_status sph_boundary_set_no_suction(sph_boundary *boundary, bool on) {
  if (!boundary) return SPH_E_ARGUMENT;
  boundary->no_suction = on;
  return SPH_OK;
}

sph_status sph_boundary_set_thin_threshold(sph_boundary *boundary, double threshold) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, threshold >= 0 && threshold < 0.5, SPH_E_ARGUMENT,
            "boundary: thin threshold must be 0 to 0.5, got %g", threshold);
  boundary->thin = threshold;
  return SPH_OK;
}

int64_t sph_boundary_count(const sph_boundary *boundary) {
  return boundary ? boundary->points.n : 0;
}

sph_status sph_boundary_get_counts(const sph_boundary *boundary, sph_boundary_counts *counts) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, counts, SPH_E_ARGUMENT, "boundary: counts is NULL");
  *counts = boundary->counts;
  return SPH_OK;
}

bool sphi_boundary_moves(const sph_boundary *boundary) {
  for (int w = 0; w < boundary->walls; w++)
    if (sphi_wall_moves(boundary->wall[w])) return true;
  return false;
}

/* Place along Hilbert's curve through cells, by the transposed form of Skilling (2004). */
static uint64_t curve_place(const int dim, uint32_t *cell) {
  const uint32_t top = 1u << (CURVE_BITS - 1);
  for (uint32_t bit = top; bit > 1; bit >>= 1)
    for (int d = 0; d < dim; d++) {
      const uint32_t swapped = (cell[0] ^ cell[d]) & (bit - 1);
      if (cell[d] & bit) {
        cell[0] ^= bit - 1;
      } else {
        cell[0] ^= swapped;
        cell[d] ^= swapped;
      }
    }
  for (int d = 1; d < dim; d++) cell[d] ^= cell[d - 1];
  uint32_t flip = 0;
  for (uint32_t bit = top; bit > 1; bit >>= 1)
    if (cell[dim - 1] & bit) flip ^= bit - 1;
  uint64_t place = 0;
  for (uint32_t bit = top; bit > 0; bit >>= 1)
    for (int d = 0; d < dim; d++) place = place << 1 | ((cell[d] ^ flip) & bit ? 1 : 0);
  return place;
}

typedef struct curve_point {
  uint64_t place;
  int32_t ghost;
} curve_point;

static int compare_places(const void *a, const void *b) {
  const curve_point *p = a, *q = b;
  if (p->place != q->place) return p->place < q->place ? -1 : 1;
  return (p->ghost > q->ghost) - (p->ghost < q->ghost);
}

/* Ghosts whose mirror points follow each other closely, whichever of them are left out. */
static sph_status find_order(sph_boundary *boundary) {
  const sphi_ghost_points *points = &boundary->points;
  const int dim = boundary->dim;
  const int32_t n = (int32_t)points->n;
  curve_point *along = SPHI_NEW(boundary->context, n, curve_point);
  SPH_CHECK(boundary->context, along, SPH_E_MEMORY, "boundary: no memory for %d ghosts", n);
  double lo[SPHI_MAX_DIM] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
  for (int32_t k = 0; k < n; k++)
    for (int d = 0; d < dim; d++) lo[d] = fmin(lo[d], points->mirror[(int64_t)dim * k + d]);
  for (int32_t k = 0; k < n; k++) {
    uint32_t cell[SPHI_MAX_DIM];
    for (int d = 0; d < dim; d++) {
      /* Points that are a spacing apart from the first are in the middle of a fourth cell. */
      const double at =
          (points->mirror[(int64_t)dim * k + d] - lo[d]) / boundary->spacing * 4 + 0.5;
      cell[d] = at < (1u << CURVE_BITS) ? (uint32_t)at : (1u << CURVE_BITS) - 1;
    }
    along[k] = (curve_point){curve_place(dim, cell), k};
  }
  qsort(along, (size_t)n, sizeof *along, compare_places);
  for (int32_t k = 0; k < n; k++) boundary->order[k] = along[k].ghost;
  sphi_free(boundary->context, along);
  return SPH_OK;
}

sph_status sphi_boundary_prepare(sph_boundary *boundary) {
  sph_context *context = boundary->context;
  const int32_t n = (int32_t)boundary->points.n;
  const int dim = boundary->dim;
  if (boundary->ordered != n) {
    boundary->wet_count = boundary->mirrors.n = 0;
    free_arrays(boundary);
    bool ok = true;
    for (int d = 0; d < dim; d++) {
      boundary->x[d] = SPHI_NEW(context, n, double);
      ok = ok && boundary->x[d];
    }
    boundary->order = SPHI_NEW(context, n, int32_t);
    boundary->place = SPHI_NEW(context, n, int32_t);
    boundary->near = SPHI_NEW(context, n, uint8_t);
    ok = ok && boundary->order && boundary->place && boundary->near;
    sph_status status = SPH_OK;
    if (!ok)
      status = SPHI_ERROR(context, SPH_E_MEMORY, "boundary: no memory for %d ghosts", n);
    else
      status = find_order(boundary);
    if (status != SPH_OK) {
      free_arrays(boundary);
      return status;
    }
    for (int32_t k = 0; k < n; k++) boundary->place[k] = -1;
    boundary->ordered = n;
  }
  for (int w = 0; w < boundary->walls; w++) boundary->arm[w] = 0;
  for (int32_t k = 0; k < n; k++) {
    const int wall = boundary->wall_of[k];
    double arm2 = 0;
    for (int d = 0; d < dim; d++)
      arm2 += pow(boundary->points.x[(int64_t)dim * k + d] - boundary->state[wall].pivot[d], 2);
    boundary->arm[wall] = fmax(boundary->arm[wall], sqrt(arm2));
  }
  boundary->in_use = true;
  boundary->known = false;
  return SPH_OK;
}

sph_status sphi_boundary_place_walls(sph_boundary *boundary, double t) {
  for (int w = 0; w < boundary->walls; w++)
    SPH_TRY(sphi_wall_state_at(boundary->wall[w], t, &boundary->state[w]));
  return SPH_OK;
}

bool sphi_boundary_is_driven(const sph_boundary *boundary) {
  for (int w = 0; w < boundary->walls; w++)
    if (sphi_wall_is_driven(boundary->wall[w])) return true;
  return false;
}

/* About the mass of a fluid of this density that moves with a wall: the wet length squared, times what a plate in
 * a long tank has (Westergaard 1933). */
static double added_mass(const sph_boundary *boundary, int wall, double density) {
  const double PLATE = 0.543;
  double area = 0;
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    const sphi_wet_ghost *wet = &boundary->wet[k];
    if (wet->wall == wall && wet->wall_pressure != 0) area += wet->area;
  }
  return PLATE * density * pow(area, boundary->dim / (boundary->dim - 1.0));
}

sph_status sphi_boundary_drive(sph_boundary *boundary, double t, double dt, double density) {
  const double now = boundary->evaluated, ago = now - boundary->before;
  const double ahead = density == 0 && boundary->known && ago > 0 ? (t + 0.5 * dt - now) / ago : 0;
  for (int w = 0; w < boundary->walls; w++) {
    double force[SPHI_MAX_DIM], middle[SPHI_MAX_DIM];
    if (!sphi_wall_is_driven(boundary->wall[w])) continue;
    SPH_TRY(sph_boundary_read_force(boundary, w, force));
    for (int d = 0; d < boundary->dim; d++) {
      middle[d] = force[d] + ahead * (force[d] - boundary->force[w][d]);
      boundary->force[w][d] = force[d];
    }
    boundary->known = false; /* until all have moved */
    if (density > 0) sphi_wall_add_mass(boundary->wall[w], added_mass(boundary, w, density));
    SPH_TRY(sphi_wall_drive(boundary->wall[w], t, dt, middle));
  }
  boundary->before = now;
  boundary->known = true;
  return SPH_OK;
}

double sphi_boundary_speed(const sph_boundary *boundary) {
  double most = 0;
  for (int w = 0; w < boundary->walls; w++) {
    const sphi_wall_state *state = &boundary->state[w];
    const double *v = state->velocity, *spin = state->spin;
    const double turning = sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]);
    most = fmax(most, sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + turning * boundary->arm[w]);
  }
  return most;
}

/* Where solids of several walls overlap, one has the place: a moving wall before one at rest, a later one
 * before an earlier one. */
static bool goes_before(const sph_boundary *boundary, int wall, int other) {
  const bool moves = sphi_wall_moves(boundary->wall[wall]);
  if (moves != sphi_wall_moves(boundary->wall[other])) return moves;
  return wall > other;
}

/* Share of a cell of one spacing around x that is outside the solid of a wall; the wall's nearest point. */
static double share_outside(const sph_boundary *boundary, int wall, const double *x, double *foot) {
  const double reach = 2 * boundary->interpolator->kernel->support;
  const double distance =
      sphi_wall_foot_now(boundary->wall[wall], &boundary->state[wall], x, reach, foot);
  return fmin(fmax(distance / boundary->spacing + 0.5, 0), 1);
}

/* Share of the volume of a ghost of `wall` at x that is its own where other walls have ghosts too. The one
 * whose foot is in the fluid has the place; where both feet are hidden behind the other wall, in the
 * wedge of a corner, the wall that goes before. */
static double own_share(const sph_boundary *boundary, int wall, const double *x,
                        const double *foot) {
  double share = 1;
  for (int other = 0; other < boundary->walls && share > 0; other++) {
    double other_foot[SPHI_MAX_DIM], unused[SPHI_MAX_DIM];
    if (other == wall) continue;
    const double outside = share_outside(boundary, other, x, other_foot);
    if (outside >= 1) continue;
    const double seen = share_outside(boundary, other, foot, unused);
    const double other_seen = share_outside(boundary, wall, other_foot, unused);
    share *= goes_before(boundary, wall, other) ? 1 - (1 - outside) * (1 - seen) * other_seen
                                                : fmax(outside, seen * (1 - other_seen));
  }
  return share;
}

/* Share of a piece of wall around its point `foot` that other walls leave open. */
static double open_share(const sph_boundary *boundary, int wall, const double *foot) {
  double share = 1, unused[SPHI_MAX_DIM];
  for (int other = 0; other < boundary->walls && share > 0; other++)
    if (other != wall) share *= share_outside(boundary, other, foot, unused);
  return share;
}

double sphi_boundary_share(const sph_boundary *boundary, int64_t k) {
  double x[SPHI_MAX_DIM], foot[SPHI_MAX_DIM];
  const int dim = boundary->dim, wall = boundary->wall_of[k];
  if (boundary->walls == 1) return 1;
  for (int d = 0; d < dim; d++) x[d] = boundary->x[d][k];
  sphi_wall_place(&boundary->state[wall], dim, boundary->points.foot + dim * k, foot);
  return own_share(boundary, wall, x, foot);
}

/* Whether another wall is near the ghost or its mirror point, or may come there before the next list. */
static bool meets_others(const sph_boundary *boundary, int64_t ghost) {
  const int dim = boundary->dim, wall = boundary->wall_of[ghost];
  double foot[SPHI_MAX_DIM], at[SPHI_MAX_DIM];
  sphi_wall_place(&boundary->state[wall], dim, boundary->points.foot + dim * ghost, at);
  for (int other = 0; other < boundary->walls; other++)
    if (other != wall &&
        sphi_wall_foot_now(boundary->wall[other], &boundary->state[other], at,
                           2 * boundary->interpolator->kernel->support, foot) < HUGE_VAL)
      return true;
  return false;
}

/* Everything about a wet ghost that depends on where walls are, and its mirror point. */
static void orient(const sph_boundary *boundary, sphi_wet_ghost *wet, double *mirror) {
  const sphi_ghost_points *points = &boundary->points;
  const int dim = boundary->dim;
  const int64_t ghost = wet->ghost;
  const sphi_wall_state *state = &boundary->state[wet->wall];
  double normal[SPHI_MAX_DIM], x[SPHI_MAX_DIM], foot[SPHI_MAX_DIM];
  sphi_ghost_normal(points, ghost, normal);
  sphi_wall_turn(state, dim, normal, wet->normal);
  sphi_wall_place(state, dim, points->x + dim * ghost, x);
  sphi_wall_place(state, dim, points->foot + dim * ghost, foot);
  sphi_wall_place(state, dim, points->mirror + dim * ghost, mirror);
  wet->second = -1;
  wet->volume = points->volume[ghost];
  wet->area = points->area[ghost];
  if (wet->live && boundary->walls > 1) {
    wet->volume *= own_share(boundary, wet->wall, x, foot);
    wet->area *= open_share(boundary, wet->wall, foot);
    double depth = 0, other_foot[SPHI_MAX_DIM] = {0};
    for (int other = 0; other < boundary->walls; other++) {
      if (other == wet->wall) continue;
      double at[SPHI_MAX_DIM];
      const double distance =
          sphi_wall_foot_now(boundary->wall[other], &boundary->state[other], mirror,
                             2 * boundary->interpolator->kernel->support, at);
      if (distance >= depth) continue; /* the deepest counts */
      depth = distance;
      wet->second = (int8_t)other;
      memcpy(other_foot, at, sizeof other_foot);
    }
    for (int d = 0; d < dim && wet->second >= 0; d++) {
      wet->across[d] = 2 * (mirror[d] - other_foot[d]);
      wet->second_normal[d] = wet->across[d] / (-2 * depth);
      mirror[d] -= wet->across[d];
    }
  }
  for (int d = 0; d < dim; d++) {
    wet->to_ghost[d] = x[d] - mirror[d];
    wet->to_foot[d] = foot[d] - mirror[d];
  }
}

/* A ghost as it is before its first evaluation. */
static sphi_wet_ghost new_wet(const sph_boundary *boundary, int64_t ghost) {
  const int wall = boundary->wall_of[ghost];
  return (sphi_wet_ghost){
      .ghost = (int32_t)ghost,
      .wall = (uint8_t)wall,
      .immersed = 1,
      .reflects = boundary->points.vertex[ghost] || sphi_wall_no_slip(boundary->wall[wall]),
      .live = boundary->state[wall].turns || meets_others(boundary, ghost)};
}

/* Present mirror points of all chosen ghosts. */
static void place_mirrors(sph_boundary *boundary) {
  const int dim = boundary->dim;
  sphi_gather *mirrors = &boundary->mirrors;
#pragma omp parallel for num_threads(boundary->context->threads) \
    schedule(static) if (mirrors->n > SERIAL)
  for (int32_t k = 0; k < mirrors->n; k++) {
    sphi_wet_ghost wet = new_wet(boundary, boundary->chosen[k]);
    double mirror[SPHI_MAX_DIM];
    orient(boundary, &wet, mirror);
    for (int d = 0; d < dim; d++) mirrors->x[d][k] = mirror[d];
  }
  mirrors->packed = false;
}

sph_status sphi_boundary_move(sph_boundary *boundary, double t) {
  const int dim = boundary->dim;
  SPH_TRY(sphi_boundary_place_walls(boundary, t));
  const int32_t n = (int32_t)boundary->points.n;
#pragma omp parallel for num_threads(boundary->context->threads) schedule(static) if (n > SERIAL)
  for (int32_t k = 0; k < n; k++) {
    double x[SPHI_MAX_DIM];
    sphi_wall_place(&boundary->state[boundary->wall_of[k]], dim,
                    boundary->points.x + (int64_t)dim * k, x);
    for (int d = 0; d < dim; d++) boundary->x[d][k] = x[d];
  }
#pragma omp parallel for num_threads(boundary->context->threads) \
    schedule(static) if (boundary->wet_count > SERIAL)
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    sphi_wet_ghost *wet = &boundary->wet[k];
    double mirror[SPHI_MAX_DIM];
    if (wet->live)
      orient(boundary, wet, mirror);
    else
      sphi_wall_place(&boundary->state[wet->wall], dim,
                      boundary->points.mirror + dim * (int64_t)wet->ghost, mirror);
    for (int d = 0; d < dim; d++) boundary->mirrors.x[d][k] = mirror[d];
  }
  boundary->mirrors.packed = false;
  boundary->moved = true;
  return SPH_OK;
}

sph_status sphi_boundary_sort(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant) {
  const double width = sphi_column_width(boundary->dim, variant->lanes, boundary->spacing);
  return sphi_columns_build(boundary->context, &boundary->columns, frame, width,
                            (int32_t)boundary->points.n, boundary->x, NULL, "boundary");
}

/* Chooses the ghosts that fluid lists, and those with a piece of wall to push on. */
static sph_status choose(sph_boundary *boundary, const sphi_list *list) {
  sph_context *context = boundary->context;
  const int32_t n = (int32_t)boundary->points.n;
  const int32_t *order = boundary->columns.order;
  const double *area = boundary->points.area;
  uint8_t *near = boundary->near;
  int32_t count = 0;
  boundary->wet_count = 0;
  for (int32_t k = 0; k < n; k++) {
    near[k] = area[k] > 0;
    boundary->place[k] = -1;
  }
#pragma omp parallel for num_threads(context->threads) \
    schedule(dynamic, 256) if (list->clusters > SERIAL)
  for (int32_t c = 0; c < list->clusters; c++) {
    const sphi_list_entry *entry = &list->entry[c];
    const uint32_t *source = list->part[entry->part].source + entry->offset;
    for (int32_t k = 0; k < entry->count; k++) {
#pragma omp atomic write
      near[order[source[k]]] = 1;
    }
  }
  for (int32_t k = 0; k < n; k++) count += near[k];
  SPH_CHECK(context,
            sphi_reserve(context, (void **)&boundary->chosen, &boundary->chosen_capacity, count,
                         sizeof *boundary->chosen),
            SPH_E_MEMORY, "boundary: no memory for %d ghosts", count);
  SPH_TRY(sphi_gather_reserve_points(context, &boundary->mirrors, boundary->dim, count));
  for (int32_t k = 0, at = 0; k < n; k++)
    if (near[boundary->order[k]]) boundary->chosen[at++] = boundary->order[k];
  return SPH_OK;
}

/* Leaves in the fluid's list what is wet, by the places of the records. */
static void list_wet(const sph_boundary *boundary, sphi_list *list) {
  const int32_t *order = boundary->columns.order, *place = boundary->place;
#pragma omp parallel for num_threads(boundary->context->threads) \
    schedule(dynamic, 256) if (list->clusters > SERIAL)
  for (int32_t c = 0; c < list->clusters; c++) {
    sphi_list_entry *entry = &list->entry[c];
    uint32_t *source = list->part[entry->part].source + entry->offset;
    int32_t count = 0;
    for (int32_t k = 0; k < entry->count; k++) {
      const int32_t wet = place[order[source[k]]];
      if (wet >= 0) source[count++] = (uint32_t)wet;
    }
    entry->count = entry->near = count;
  }
}

/* Records of the gates of a ghost. */
static int64_t gate_records(const sph_boundary *boundary, int64_t ghost) {
  const int dim = boundary->dim, gates = boundary->points.gates[ghost];
  return gates ? (gates * (dim + 1) + SPHI_GHOST(dim)) / SPHI_GHOST(dim) : 0;
}

void sphi_boundary_make_wet(sph_boundary *boundary, int32_t k, int32_t ghost) {
  sphi_wet_ghost *wet = &boundary->wet[k];
  double mirror[SPHI_MAX_DIM];
  *wet = new_wet(boundary, ghost);
  orient(boundary, wet, mirror);
  memcpy(wet->v, boundary->state[wet->wall].velocity, sizeof wet->v);
  boundary->place[ghost] = k;
}

/* What of the wet ghosts and their records does not change; the rest is as of dry ones. */
static sph_status fill_wet(sph_boundary *boundary, const sphi_variant *variant) {
  sph_context *context = boundary->context;
  const sphi_ghost_points *points = &boundary->points;
  const int dim = boundary->dim, stride = SPHI_GHOST(dim);
  const int32_t n = boundary->mirrors.n;
  int64_t records = (int64_t)n + SPHI_PAD;
  for (int32_t k = 0; k < n; k++) records += gate_records(boundary, boundary->chosen[k]);
  SPH_CHECK(context,
            sphi_reserve(context, (void **)&boundary->wet, &boundary->wet_capacity,
                         n <= boundary->wet_capacity ? n : (int64_t)n + n / 8 + 16,
                         sizeof *boundary->wet) &&
                sphi_reserve(context, &boundary->record, &boundary->record_capacity,
                             records * stride <= boundary->record_capacity
                                 ? records * stride
                                 : (records + records / 8) * stride,
                             variant->real_size),
            SPH_E_MEMORY, "boundary: no memory for %d ghosts", n);
  memset(boundary->record, 0, (size_t)boundary->record_capacity * variant->real_size);
#pragma omp parallel for num_threads(context->threads) schedule(static) if (n > SERIAL)
  for (int32_t k = 0; k < n; k++) {
    sphi_boundary_make_wet(boundary, k, boundary->chosen[k]);
    const bool drags = sphi_wall_no_slip(boundary->wall[boundary->wet[k].wall]);
    sphi_put_real(boundary->record, variant->is_double, (int64_t)k * stride + SPHI_GHOST_S(dim),
                  drags);
  }
  int64_t next = (int64_t)n + SPHI_PAD;
  for (int32_t k = 0; k < n; k++) {
    const int64_t ghost = boundary->chosen[k];
    const int gates = points->gates[ghost];
    if (!gates) continue;
    const int32_t away = (int32_t)(next - k);
    memcpy((char *)boundary->record +
               (size_t)((int64_t)k * stride + SPHI_GHOST_GATES(dim)) * variant->real_size,
           &away, sizeof away);
    sphi_put_real(boundary->record, variant->is_double, next * stride, gates);
    for (int g = 0; g < gates; g++) {
      const double *plane = sphi_ghost_gates(points, ghost) + g * (dim + 1);
      double now[SPHI_MAX_DIM];
      sphi_wall_turn(&boundary->state[boundary->wall_of[ghost]], dim, plane, now);
      for (int d = 0; d <= dim; d++)
        sphi_put_real(boundary->record, variant->is_double, next * stride + 1 + g * (dim + 1) + d,
                      d < dim ? now[d] : plane[dim]);
    }
    next += gate_records(boundary, ghost);
  }
  boundary->wet_count = n;
  boundary->moved = true;
  return SPH_OK;
}

/* Keeps the values of wet ghosts apart; returns SPH_E_MEMORY if there is no room. */
static sph_status keep_values(sph_boundary *boundary, int32_t *count) {
  SPH_CHECK(boundary->context,
            sphi_reserve(boundary->context, (void **)&boundary->kept, &boundary->kept_capacity,
                         boundary->wet_capacity, sizeof *boundary->kept),
            SPH_E_MEMORY, "boundary: no memory for %d ghosts", boundary->wet_count);
  *count = boundary->wet_count;
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    const sphi_wet_ghost *wet = &boundary->wet[k];
    sphi_ghost_values *kept = &boundary->kept[k];
    *kept = (sphi_ghost_values){wet->ghost, wet->rung, wet->p, wet->wall_pressure, {0}};
    memcpy(kept->v, wet->v, sizeof kept->v);
  }
  return SPH_OK;
}

/* Gives them back: what is asked of the last evaluation outlives new lists. */
static void restore_values(sph_boundary *boundary, int32_t count) {
  for (int32_t k = 0; k < count; k++) {
    const sphi_ghost_values *kept = &boundary->kept[k];
    const int32_t place = boundary->place[kept->ghost];
    if (place < 0) continue;
    sphi_wet_ghost *wet = &boundary->wet[place];
    wet->rung = kept->rung;
    wet->p = kept->p;
    wet->wall_pressure = kept->wall_pressure;
    memcpy(wet->v, kept->v, sizeof wet->v);
  }
}

sph_status sphi_boundary_list(sph_boundary *boundary, const sphi_frame *frame,
                              const sphi_variant *variant, const sphi_columns *fluid, double radius,
                              sphi_list *near) {
  sph_context *context = boundary->context;
  int32_t kept = 0;
  SPH_TRY(keep_values(boundary, &kept));
  SPH_TRY(choose(boundary, near));
  place_mirrors(boundary);
  SPH_TRY(sphi_gather_cut(
      context, &boundary->mirrors, frame, variant,
      CLUSTER_EXTENT * sphi_column_width(boundary->dim, variant->lanes, boundary->spacing)));
  SPH_TRY(sphi_gather_list_wet(context, &boundary->mirrors, frame, boundary->interpolator, fluid,
                               radius, variant, boundary->chosen));
  SPH_TRY(fill_wet(boundary, variant));
  restore_values(boundary, kept);
  list_wet(boundary, near);
  return SPH_OK;
}

/* u less twice what of it goes into the wall. */
static inline void reflect(int dim, double *u, const double *wall_velocity, const double *normal) {
  double across = 0;
  for (int d = 0; d < dim; d++) across += (u[d] - wall_velocity[d]) * normal[d];
  for (int d = 0; d < dim; d++) u[d] -= 2 * across * normal[d];
}

/* Velocity of a wall at x, put on by what force and wall do to each other over `ahead`. */
static inline void wall_velocity_ahead(const sph_boundary *boundary, int wall, const double *x,
                                       const double *push, double rho0, double ahead,
                                       double *velocity) {
  sphi_wall_velocity_at(&boundary->state[wall], boundary->dim, x, velocity, NULL);
  for (int d = 0; d < boundary->dim && ahead != 0; d++) velocity[d] += ahead * push[d] / rho0;
}

/* Velocity and pressure of wet ghost k from the values at its mirror point. */
static inline __attribute__((always_inline)) void assign(sph_boundary *boundary, const int dim,
                                                         int32_t k, const sphi_body_force *force,
                                                         double t, double rho0, double ahead) {
  const sphi_interpolation *work = &boundary->mirrors.work;
  sphi_wet_ghost *ghost = &boundary->wet[k];
  const bool dry = work->rung[k] == 0, thin = work->gamma[k] < boundary->thin;
  double push[SPHI_MAX_DIM], at[SPHI_MAX_DIM], wall_velocity[SPHI_MAX_DIM], u[SPHI_MAX_DIM];
  const double more = sphi_wall_gradient(boundary, dim, k, force, t, rho0, push);
  double p = work->value[k], p_wall = p;
  for (int d = 0; d < dim; d++) {
    /* The interpolated values belong to the point that the weights average: x_m + I[x - x_m]. */
    const double from = work->moment[(int64_t)d * work->n + k];
    p += push[d] * (ghost->to_ghost[d] - from);
    p_wall += push[d] * (ghost->to_foot[d] - from);
    at[d] = boundary->mirrors.x[d][k] + ghost->to_foot[d];
    u[d] = work->value[(int64_t)(1 + d) * work->n + k];
  }
  wall_velocity_ahead(boundary, ghost->wall, at, push, rho0, ahead, wall_velocity);
  if (ghost->second >= 0) {
    double second_velocity[SPHI_MAX_DIM];
    p += more;
    p_wall += more;
    for (int d = 0; d < dim; d++) at[d] = boundary->mirrors.x[d][k] + 0.5 * ghost->across[d];
    wall_velocity_ahead(boundary, ghost->second, at, push, rho0, ahead, second_velocity);
    reflect(dim, u, second_velocity, ghost->second_normal);
  }
  if (thin || dry) p = p_wall = 0;
  if (boundary->no_suction && p < 0) p = 0;
  if (boundary->no_suction && p_wall < 0) p_wall = 0;
  ghost->rung = work->rung[k];
  ghost->p = p;
  ghost->wall_pressure = p_wall;
  if (!ghost->reflects) reflect(dim, u, wall_velocity, ghost->normal);
  for (int d = 0; d < dim; d++)
    ghost->v[d] = thin || dry       ? wall_velocity[d]
                  : ghost->reflects ? 2 * wall_velocity[d] - u[d]
                                    : u[d];
}

static inline void put_place(void *record, bool is_double, const sphi_frame *frame, int d,
                             int64_t at, double x) {
  const uint32_t fixed = is_double ? 0 : sphi_frame_fix(frame, d, x);
  if (is_double)
    ((double *)record)[at] = x;
  else
    memcpy((float *)record + at, &fixed, sizeof fixed);
}

/* The record of wet ghost k but for what does not change. */
static inline __attribute__((always_inline)) void pack(const sph_boundary *boundary, const int dim,
                                                       const bool is_double,
                                                       const sphi_frame *frame, int32_t k) {
  const sphi_wet_ghost *ghost = &boundary->wet[k];
  const double volume = ghost->rung ? ghost->immersed * ghost->volume : 0;
  const int64_t at = (int64_t)k * SPHI_GHOST(dim);
  for (int d = 0; d < dim && boundary->moved; d++)
    put_place(boundary->record, is_double, frame, d, at + d, boundary->x[d][ghost->ghost]);
  sphi_put_real(boundary->record, is_double, at + dim, volume);
  sphi_put_real(boundary->record, is_double, at + dim + 1, ghost->p);
  for (int d = 0; d < dim; d++)
    sphi_put_real(boundary->record, is_double, at + dim + 2 + d, ghost->v[d]);
}

void sphi_boundary_update(sph_boundary *boundary, const sphi_frame *frame,
                          const sphi_variant *variant, const void *record,
                          const sphi_body_force *force, double t, double rho0, double ahead) {
  sph_context *context = boundary->context;
  sphi_gather_evaluate(context, &boundary->mirrors, frame, boundary->interpolator, variant, record);
  const sphi_interpolation *work = &boundary->mirrors.work;
  const int32_t n = boundary->wet_count;
  int64_t by_type[SPH_BOUNDARY_TYPES] = {0}, thin = 0;
#pragma omp parallel for num_threads(context->threads) \
    schedule(static) if (n > SERIAL) reduction(+ : by_type, thin)
  for (int32_t k = 0; k < n; k++) {
    if (boundary->dim == 2) {
      assign(boundary, 2, k, force, t, rho0, ahead);
      if (variant->is_double)
        pack(boundary, 2, true, frame, k);
      else
        pack(boundary, 2, false, frame, k);
    } else {
      assign(boundary, 3, k, force, t, rho0, ahead);
      if (variant->is_double)
        pack(boundary, 3, true, frame, k);
      else
        pack(boundary, 3, false, frame, k);
    }
    by_type[work->rung[k]]++;
    thin += work->rung[k] != 0 && work->gamma[k] < boundary->thin;
  }
  boundary->moved = false;
  boundary->evaluated = t;
  sph_boundary_counts *counts = &boundary->counts;
  *counts = (sph_boundary_counts){.ghosts = boundary->points.n,
                                  .active = n - by_type[0],
                                  .thin = thin,
                                  .skipped = boundary->points.skipped};
  memcpy(counts->by_type, by_type, sizeof by_type);
  counts->by_type[0] = counts->inactive = counts->ghosts - counts->active;
  counts->fallback = counts->active - counts->by_type[boundary->interpolator->type];
}

void sphi_boundary_read_records(const sph_boundary *boundary, int wall,
                                const sphi_wall_state *state, const sphi_frame *frame,
                                const sphi_variant *variant, void *record) {
  const int dim = boundary->dim;
  const bool is_double = variant->is_double;
  memcpy(record, boundary->record, (size_t)boundary->record_capacity * variant->real_size);
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    const sphi_wet_ghost *wet = &boundary->wet[k];
    const int64_t at = (int64_t)k * SPHI_GHOST(dim);
    double x[SPHI_MAX_DIM];
    sphi_wall_place(state, dim, boundary->points.x + dim * (int64_t)wet->ghost, x);
    for (int d = 0; d < dim; d++) put_place(record, is_double, frame, d, at + d, x[d]);
    sphi_put_real(record, is_double, at + dim, wet->wall == wall && wet->rung ? wet->volume : 0);
    sphi_put_real(record, is_double, at + dim + 1, wet->p);
  }
}

sph_status sph_boundary_read(const sph_boundary *boundary, sph_ghost_value what, double *values,
                             int64_t size) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, values, SPH_E_ARGUMENT, "boundary: values is NULL");
  SPH_CHECK(boundary->context, what >= SPH_GHOST_POSITION && what <= SPH_GHOST_RUNG, SPH_E_ARGUMENT,
            "boundary: value must be one of sph_ghost_value, got %d", (int)what);
  const int dim = boundary->dim, components = what <= SPH_GHOST_VELOCITY ? dim : 1;
  const int64_t n = boundary->points.n;
  SPH_CHECK(boundary->context, size == n * components, SPH_E_ARGUMENT,
            "boundary: size must be %lld doubles (%lld ghosts of %d), got %lld",
            (long long)(n * components), (long long)n, components, (long long)size);
  const double *reference[] = {boundary->points.x, boundary->points.mirror, boundary->points.foot};
  for (int64_t k = 0; k < n; k++) {
    const sphi_wall_state *wall = &boundary->state[boundary->wall_of[k]];
    if (what <= SPH_GHOST_FOOT)
      sphi_wall_place(wall, dim, reference[what] + dim * k, values + dim * k);
    if (what == SPH_GHOST_NORMAL) {
      double normal[SPHI_MAX_DIM];
      sphi_ghost_normal(&boundary->points, k, normal);
      sphi_wall_turn(wall, dim, normal, values + dim * k);
      for (int d = 0; d < dim; d++) values[dim * k + d] = -values[dim * k + d];
    }
    /* Before the first evaluation there are no values: everything is zero. */
    const int32_t place = boundary->place ? boundary->place[k] : -1;
    const sphi_wet_ghost *wet = place < 0 ? NULL : &boundary->wet[place];
    if (what == SPH_GHOST_MIRROR && wet && wet->second >= 0)
      for (int d = 0; d < dim; d++) values[dim * k + d] -= wet->across[d];
    for (int d = 0; d < dim && what == SPH_GHOST_VELOCITY; d++)
      values[dim * k + d] = wet ? wet->v[d] : boundary->place ? wall->velocity[d] : 0;
    if (what == SPH_GHOST_PRESSURE) values[k] = wet ? wet->p : 0;
    if (what == SPH_GHOST_VOLUME) values[k] = wet && wet->rung ? wet->volume : 0;
    if (what == SPH_GHOST_RUNG) values[k] = wet ? wet->rung : 0;
  }
  return SPH_OK;
}

sph_status sph_boundary_read_force(const sph_boundary *boundary, int wall, double *force) {
  if (!boundary) return SPH_E_ARGUMENT;
  SPH_CHECK(boundary->context, force, SPH_E_ARGUMENT, "boundary: force is NULL");
  SPH_CHECK(boundary->context, wall >= 0 && wall < boundary->walls, SPH_E_ARGUMENT,
            "boundary: wall must be 0 to %d, got %d", boundary->walls - 1, wall);
  for (int d = 0; d < boundary->dim; d++) force[d] = 0;
  for (int32_t k = 0; k < boundary->wet_count; k++) {
    const sphi_wet_ghost *wet = &boundary->wet[k];
    if (wet->wall != wall) continue;
    const double push = wet->wall_pressure * wet->area;
    for (int d = 0; d < boundary->dim; d++) force[d] += push * wet->normal[d];
  }
  return SPH_OK;
}
