/* What belongs to what: edges, neighbours, cells at nodes, and whether triangles make a mesh. */
#include <inttypes.h>
#include <stdio.h>

#include "mesh/mesh_impl.h"

/* Edges by their ends: open addressing, at most half full. */
typedef struct edge_table {
  int32_t *at; /* [size] 1 + edge, 0: free */
  uint64_t mask;
} edge_table;

static uint64_t place_of(const edge_table *table, int32_t a, int32_t b) {
  const uint64_t low = (uint64_t)(a < b ? a : b), high = (uint64_t)(a < b ? b : a);
  uint64_t z = (low << 32 | high) + 0x9e3779b97f4a7c15ull;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return (z ^ (z >> 31)) & table->mask;
}

/* The place of the edge between a and b, or the free place where it goes. */
static uint64_t find(const edge_table *table, const int32_t *ends, int32_t a, int32_t b) {
  uint64_t k = place_of(table, a, b);
  for (; table->at[k]; k = (k + 1) & table->mask) {
    const int32_t *e = ends + 2 * (int64_t)(table->at[k] - 1);
    if ((e[0] == a && e[1] == b) || (e[0] == b && e[1] == a)) break;
  }
  return k;
}

sphi_mesh_words sphi_mesh_cell_words(const sphi_mesh_source *source, int64_t cell) {
  sphi_mesh_words words;
  if (source->line)
    snprintf(words.text, sizeof words.text, "cell %" PRId64 " (line %" PRId64 ")", cell,
             source->line[cell]);
  else
    snprintf(words.text, sizeof words.text, "cell %" PRId64, cell);
  return words;
}

static bool same_corners(const int32_t *a, const int32_t *b) {
  for (int k = 0; k < 3; k++)
    if (a[k] != b[0] && a[k] != b[1] && a[k] != b[2]) return false;
  return true;
}

/* Says what is wrong with a cell one of whose edges has a cell on that side, or two, before. */
static sph_status refuse(const sph_mesh *mesh, const sphi_mesh_source *source, int32_t edge,
                         int32_t cell) {
  sph_context *context = mesh->context;
  const int32_t *side = mesh->side + 2 * (int64_t)edge, *ends = mesh->ends + 2 * (int64_t)edge;
  const sphi_mesh_words words = sphi_mesh_cell_words(source, cell);
  for (int k = 0; k < 2; k++)
    SPH_CHECK(context,
              side[k] < 0 || !same_corners(mesh->corner + 3 * (int64_t)side[k],
                                           mesh->corner + 3 * (int64_t)cell),
              SPH_E_ARGUMENT, "%s: %s has the corners of %s", source->what, words.text,
              sphi_mesh_cell_words(source, side[k]).text);
  if (side[1] >= 0)
    return SPHI_ERROR(context, SPH_E_ARGUMENT,
                      "%s: the edge between nodes %d and %d belongs to %s, %s and %s; an edge has "
                      "two at most",
                      source->what, ends[0], ends[1], sphi_mesh_cell_words(source, side[0]).text,
                      sphi_mesh_cell_words(source, side[1]).text, words.text);
  return SPHI_ERROR(context, SPH_E_ARGUMENT,
                    "%s: %s and %s overlap: both are on the same side of the edge from node %d to "
                    "%d",
                    source->what, sphi_mesh_cell_words(source, side[0]).text, words.text, ends[0],
                    ends[1]);
}

/* Finds edges and the cells beside them. mesh->neighbour holds numbers of edges afterwards. */
static sph_status find_edges(sph_mesh *mesh, const sphi_mesh_source *source,
                             const edge_table *table) {
  for (int32_t c = 0; c < mesh->cells; c++)
    for (int k = 0; k < 3; k++) {
      const int32_t *corner = mesh->corner + 3 * (int64_t)c;
      const int32_t a = corner[(k + 1) % 3], b = corner[(k + 2) % 3];
      const uint64_t place = find(table, mesh->ends, a, b);
      int32_t edge = table->at[place] - 1;
      if (edge < 0) {
        edge = mesh->edges++;
        table->at[place] = edge + 1;
        mesh->ends[2 * (int64_t)edge] = a;
        mesh->ends[2 * (int64_t)edge + 1] = b;
        mesh->side[2 * (int64_t)edge] = c;
        mesh->side[2 * (int64_t)edge + 1] = -1;
      } else {
        if (mesh->side[2 * (int64_t)edge + 1] >= 0 || mesh->ends[2 * (int64_t)edge] == a)
          return refuse(mesh, source, edge, c);
        mesh->side[2 * (int64_t)edge + 1] = c;
      }
      mesh->neighbour[3 * (int64_t)c + k] = edge;
    }
  return SPH_OK;
}

static sph_status set_tags(sph_mesh *mesh, const sphi_mesh_source *source, const edge_table *table,
                           int64_t edges, const int32_t *ends, const int32_t *tags) {
  sph_context *context = mesh->context;
  for (int64_t k = 0; k < edges; k++) {
    const int32_t a = ends[2 * k], b = ends[2 * k + 1];
    const bool nodes = a >= 0 && b >= 0 && a < mesh->nodes && b < mesh->nodes;
    const int32_t edge = nodes ? table->at[find(table, mesh->ends, a, b)] - 1 : -1;
    SPH_CHECK(context, edge >= 0, SPH_E_ARGUMENT,
              "%s: the tagged edge %" PRId64 ", between nodes %d and %d, is of no triangle",
              source->what, k, a, b);
    SPH_CHECK(context, tags[k] >= 1 && tags[k] <= mesh->tags, SPH_E_ARGUMENT,
              "%s: the tag of edge %" PRId64 " must be 1 to %d, got %d", source->what, k,
              mesh->tags, tags[k]);
    SPH_CHECK(context, mesh->tag[edge] == 0 || mesh->tag[edge] == tags[k], SPH_E_ARGUMENT,
              "%s: the edge between nodes %d and %d has two tags, \"%s\" and \"%s\"", source->what,
              a, b, mesh->name[mesh->tag[edge] - 1], mesh->name[tags[k] - 1]);
    mesh->tag[edge] = tags[k];
  }
  return SPH_OK;
}

/* Edges on the boundary first, in the order they have; then numbers of edges become those of neighbours. */
static void sort_edges(sph_mesh *mesh, int32_t *number, int32_t *scratch) {
  for (int pass = 0; pass < 2; pass++) {
    int32_t count = pass == 0 ? 0 : mesh->boundary;
    for (int32_t e = 0; e < mesh->edges; e++)
      if ((mesh->side[2 * (int64_t)e + 1] >= 0) == (pass == 1)) number[e] = count++;
    if (pass == 0) mesh->boundary = count;
  }
  int32_t *arrays[5] = {mesh->ends, mesh->ends + 1, mesh->side, mesh->side + 1, mesh->tag};
  for (int a = 0; a < 5; a++) {
    const int64_t stride = a == 4 ? 1 : 2;
    for (int32_t e = 0; e < mesh->edges; e++) scratch[number[e]] = arrays[a][stride * e];
    for (int32_t e = 0; e < mesh->edges; e++) arrays[a][stride * e] = scratch[e];
  }
  for (int32_t c = 0; c < mesh->cells; c++)
    for (int k = 0; k < 3; k++) {
      int32_t *at = &mesh->neighbour[3 * (int64_t)c + k];
      const int32_t edge = number[*at], *side = mesh->side + 2 * (int64_t)edge;
      *at = edge < mesh->boundary ? -1 - edge : side[0] == c ? side[1] : side[0];
    }
}

/* Cells at nodes, and edges along the boundary, which has the mesh on its left. */
static void find_touching(sph_mesh *mesh, int32_t *scratch) {
  memset(mesh->touch_start, 0, ((size_t)mesh->nodes + 1) * sizeof *mesh->touch_start);
  for (int64_t k = 0; k < 3 * (int64_t)mesh->cells; k++) mesh->touch_start[mesh->corner[k] + 1]++;
  for (int32_t a = 0; a < mesh->nodes; a++) mesh->touch_start[a + 1] += mesh->touch_start[a];
  memset(scratch, 0, (size_t)mesh->nodes * sizeof *scratch);
  for (int64_t k = 0; k < 3 * (int64_t)mesh->cells; k++) {
    const int32_t a = mesh->corner[k];
    mesh->touch[mesh->touch_start[a] + scratch[a]++] = (int32_t)k;
  }
  for (int32_t e = 0; e < mesh->boundary; e++) scratch[mesh->ends[2 * (int64_t)e]] = e;
  for (int32_t e = 0; e < mesh->boundary; e++)
    mesh->next[e] = scratch[mesh->ends[2 * (int64_t)e + 1]];
  for (int32_t e = 0; e < mesh->boundary; e++) scratch[mesh->ends[2 * (int64_t)e + 1]] = e;
  for (int32_t e = 0; e < mesh->boundary; e++) mesh->last[e] = scratch[mesh->ends[2 * (int64_t)e]];
}

sph_status sphi_mesh_connect(sph_mesh *mesh, const sphi_mesh_source *source, int64_t edges,
                             const int32_t *ends, const int32_t *tags) {
  sph_context *context = mesh->context;
  const size_t most = 3 * (size_t)mesh->cells;
  size_t size = 8;
  while (size < 2 * most) size *= 2;
  const edge_table table = {.at = SPHI_NEW(context, size, int32_t), .mask = size - 1};
  int32_t *number = SPHI_NEW(context, most, int32_t);
  int32_t *scratch =
      SPHI_NEW(context, most > (size_t)mesh->nodes ? most : (size_t)mesh->nodes, int32_t);
  mesh->ends = SPHI_NEW(context, 2 * most, int32_t);
  mesh->side = SPHI_NEW(context, 2 * most, int32_t);
  mesh->tag = SPHI_NEW(context, most, int32_t);
  mesh->neighbour = SPHI_NEW(context, most, int32_t);
  mesh->touch = SPHI_NEW(context, most, int32_t);
  mesh->touch_start = SPHI_NEW(context, (size_t)mesh->nodes + 1, int64_t);
  sph_status status = SPH_OK;
  if (!table.at || !number || !scratch || !mesh->ends || !mesh->side || !mesh->tag ||
      !mesh->neighbour || !mesh->touch || !mesh->touch_start)
    status = SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory for the edges of %d cells",
                        source->what, mesh->cells);
  if (status == SPH_OK) status = find_edges(mesh, source, &table);
  if (status == SPH_OK) status = set_tags(mesh, source, &table, edges, ends, tags);
  if (status == SPH_OK) {
    sort_edges(mesh, number, scratch);
    mesh->next = SPHI_NEW(context, mesh->boundary, int32_t);
    mesh->last = SPHI_NEW(context, mesh->boundary, int32_t);
    if (mesh->next && mesh->last)
      find_touching(mesh, scratch);
    else
      status = SPHI_ERROR(context, SPH_E_MEMORY, "%s: no memory for %d edges of the boundary",
                          source->what, mesh->boundary);
  }
  sphi_free(context, table.at);
  sphi_free(context, number);
  sphi_free(context, scratch);
  return status;
}
