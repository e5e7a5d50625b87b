/* Meshes from files of Gmsh, MSH ASCII 2.2 and 4.1: numbers between blanks, in sections.
 *
 * Counts in the file are not believed: arrays grow as entries are read. */
#define _POSIX_C_SOURCE 200809L
#ifdef __APPLE__
#include <xlocale.h>
#endif
#include <errno.h>
#include <inttypes.h>
#include <locale.h>
#include <stdio.h>
#include <stdlib.h>

#include "mesh/mesh_impl.h"

enum { TOKEN_BYTES = 256, LINE_OF_2 = 1, TRIANGLE_OF_3 = 2, POINT = 15 };

typedef struct number_pair {
  int64_t key, value;
} number_pair;

/* Things that carry a number of the file's own. */
typedef struct number_list {
  int64_t count, capacity;
  number_pair *pair;
} number_list;

typedef struct reader {
  sph_context *context;
  const char *path;
  FILE *stream;
  int64_t line; /* of the token */
  bool newline; /* the token ended its line */
  char token[TOKEN_BYTES];
  int version; /* 22 or 41, 0: not known yet */
  int64_t z_capacity, x_capacity, corner_capacity, line_capacity, ends_capacity, group_capacity;
  int64_t cells, edges;
  double *x, *z;    /* [nodes, 2], [nodes] */
  number_list node; /* its number, its place */
  int64_t *corner;  /* [cells, 3] numbers of the file */
  int64_t *cell_line;
  int64_t *ends;     /* [edges, 2] numbers of the file */
  int64_t *group;    /* [edges] physical group, 0: none */
  number_list curve; /* of version 4.1: the group of a curve */
  int named;
  int64_t named_group[SPHI_MESH_TAGS];
  char name[SPHI_MESH_TAGS][SPHI_MESH_NAME + 1];
} reader;

#define MSH_CHECK(r, condition, code, ...) \
  SPH_CHECK((r)->context, condition, code, "mesh: file \"%.300s\", line %" PRId64 ": " __VA_ARGS__)
#define MSH_GROW(r, array, capacity, count)                                                       \
  MSH_CHECK(r,                                                                                    \
            sphi_reserve((r)->context, (void **)&(array), &(capacity), (count), sizeof *(array)), \
            SPH_E_MEMORY, "out of memory", (r)->path, (r)->line)

static int next_character(reader *r) {
  const int c = getc(r->stream);
  if (c == '\n') r->line++;
  return c;
}

/* The next run of characters that are no blanks. */
static sph_status next(reader *r, const char *wanted) {
  int c, length = 0;
  if (r->newline) r->line++;
  r->newline = false;
  do c = next_character(r);
  while (c == ' ' || c == '\t' || c == '\r' || c == '\n');
  for (; c != EOF && c != ' ' && c != '\t' && c != '\r' && c != '\n'; c = getc(r->stream)) {
    MSH_CHECK(r, c != 0 && length < TOKEN_BYTES - 1, SPH_E_IO,
              "a zero byte or a word longer than %d bytes; this is no text", r->path, r->line,
              TOKEN_BYTES - 1);
    r->token[length++] = (char)c;
  }
  r->newline = c == '\n';
  r->token[length] = 0;
  SPH_CHECK(r->context, !ferror(r->stream), SPH_E_IO, "mesh: file \"%.300s\": cannot be read: %s",
            r->path, errno ? strerror(errno) : "unknown reason");
  MSH_CHECK(r, length > 0, SPH_E_IO, "the file ends where %s should be", r->path, r->line, wanted);
  return SPH_OK;
}

static sph_status next_integer(reader *r, const char *what, int64_t lo, int64_t hi, int64_t *out) {
  SPH_TRY(next(r, what));
  char *end;
  errno = 0;
  const long long number = strtoll(r->token, &end, 10);
  MSH_CHECK(r, *end == 0 && errno == 0, SPH_E_IO, "%s must be a whole number, got \"%.40s\"",
            r->path, r->line, what, r->token);
  MSH_CHECK(r, number >= lo && number <= hi, SPH_E_IO,
            "%s must be %" PRId64 " to %" PRId64 ", got %lld", r->path, r->line, what, lo, hi,
            number);
  *out = number;
  return SPH_OK;
}

static sph_status next_real(reader *r, const char *what, double *out) {
  SPH_TRY(next(r, what));
  char *end;
  *out = strtod(r->token, &end);
  MSH_CHECK(r, *end == 0 && fabs(*out) <= 1e100, SPH_E_IO,
            "%s must be a finite number, got \"%.40s\"", r->path, r->line, what, r->token);
  return SPH_OK;
}

static sph_status expect(reader *r, const char *word) {
  SPH_TRY(next(r, word));
  MSH_CHECK(r, strcmp(r->token, word) == 0, SPH_E_IO, "%s should be here, got \"%.40s\"", r->path,
            r->line, word, r->token);
  return SPH_OK;
}

static sph_status skip(reader *r, const char *what, int64_t count) {
  double unused;
  for (int64_t k = 0; k < count; k++) SPH_TRY(next_real(r, what, &unused));
  return SPH_OK;
}

static sph_status append(reader *r, number_list *list, int64_t key, int64_t value) {
  MSH_GROW(r, list->pair, list->capacity, list->count + 1);
  list->pair[list->count++] = (number_pair){key, value};
  return SPH_OK;
}

static int by_key(const void *a, const void *b) {
  const int64_t p = ((const number_pair *)a)->key, q = ((const number_pair *)b)->key;
  return (p > q) - (p < q);
}

/* What goes with this number in a list sorted by numbers, or -1. */
static int64_t place_of(const number_list *list, int64_t key) {
  int64_t first = 0, last = list->count;
  while (first < last) {
    const int64_t middle = first + (last - first) / 2;
    if (list->pair[middle].key == key) return list->pair[middle].value;
    if (list->pair[middle].key < key)
      first = middle + 1;
    else
      last = middle;
  }
  return -1;
}

/* ---- sections ---- */

static sph_status read_format(reader *r) {
  SPH_TRY(next(r, "the version"));
  const bool v2 = strcmp(r->token, "2.2") == 0, v4 = strcmp(r->token, "4.1") == 0;
  MSH_CHECK(r, v2 || v4, SPH_E_IO, "version must be 2.2 or 4.1, got \"%.40s\"", r->path, r->line,
            r->token);
  int64_t binary, unused;
  SPH_TRY(next_integer(r, "the file type", 0, 1, &binary));
  MSH_CHECK(r, binary == 0, SPH_E_IO, "the file is binary; save it as ASCII", r->path, r->line);
  SPH_TRY(next_integer(r, "the size of data", 0, 64, &unused));
  r->version = v2 ? 22 : 41;
  return expect(r, "$EndMeshFormat");
}

/* A name between double quotes. */
static sph_status read_quoted(reader *r, char *name) {
  int c, length = 0;
  if (r->newline) r->line++;
  r->newline = false;
  do c = next_character(r);
  while (c == ' ' || c == '\t');
  MSH_CHECK(r, c == '"', SPH_E_IO, "a name in double quotes should be here", r->path, r->line);
  while ((c = next_character(r)) != '"') {
    MSH_CHECK(r, c != EOF && c >= ' ' && length < SPHI_MESH_NAME, SPH_E_IO,
              "a name must end on its line and have 1 to %d bytes", r->path, r->line,
              SPHI_MESH_NAME);
    name[length++] = (char)c;
  }
  MSH_CHECK(r, length > 0, SPH_E_IO, "a name must have 1 to %d bytes", r->path, r->line,
            SPHI_MESH_NAME);
  name[length] = 0;
  return SPH_OK;
}

static sph_status read_names(reader *r) {
  int64_t count, dim, group;
  SPH_TRY(next_integer(r, "the number of names", 0, SPHI_MESH_MAX, &count));
  for (int64_t k = 0; k < count; k++) {
    char name[SPHI_MESH_NAME + 1];
    SPH_TRY(next_integer(r, "the dimension of a group", 0, 3, &dim));
    SPH_TRY(next_integer(r, "the number of a group", 0, INT32_MAX, &group));
    SPH_TRY(read_quoted(r, name));
    if (dim != 1) continue;
    MSH_CHECK(r, r->named < SPHI_MESH_TAGS, SPH_E_IO, "more than %d groups of lines", r->path,
              r->line, SPHI_MESH_TAGS);
    memcpy(r->name[r->named], name, strlen(name) + 1);
    r->named_group[r->named++] = group;
  }
  return expect(r, "$EndPhysicalNames");
}

/* One point, curve, surface or volume; the first group of a curve is what counts. */
static sph_status read_entity(reader *r, int dim) {
  int64_t tag, groups, group = 0, first = 0, bounds;
  SPH_TRY(next_integer(r, "the number of an entity", -INT32_MAX, INT32_MAX, &tag));
  SPH_TRY(skip(r, "a coordinate of an entity", dim == 0 ? 3 : 6));
  SPH_TRY(next_integer(r, "the number of groups", 0, SPHI_MESH_MAX, &groups));
  for (int64_t k = 0; k < groups; k++) {
    SPH_TRY(next_integer(r, "the number of a group", -INT32_MAX, INT32_MAX, &group));
    if (k == 0) first = group < 0 ? -group : group;
  }
  if (dim == 1) SPH_TRY(append(r, &r->curve, tag, first));
  if (dim == 0) return SPH_OK;
  SPH_TRY(next_integer(r, "the number of bounding entities", 0, SPHI_MESH_MAX, &bounds));
  return skip(r, "a bounding entity", bounds);
}

static sph_status read_entities(reader *r) {
  int64_t count[4];
  for (int dim = 0; dim < 4; dim++)
    SPH_TRY(next_integer(r, "the number of entities", 0, SPHI_MESH_MAX, &count[dim]));
  for (int dim = 0; dim < 4; dim++)
    for (int64_t k = 0; k < count[dim]; k++) SPH_TRY(read_entity(r, dim));
  if (r->curve.count > 1)
    qsort(r->curve.pair, (size_t)r->curve.count, sizeof *r->curve.pair, by_key);
  return expect(r, "$EndEntities");
}

static sph_status read_place(reader *r, int64_t place) {
  MSH_GROW(r, r->x, r->x_capacity, 2 * (place + 1));
  MSH_GROW(r, r->z, r->z_capacity, place + 1);
  SPH_TRY(next_real(r, "x of a node", &r->x[2 * place]));
  SPH_TRY(next_real(r, "y of a node", &r->x[2 * place + 1]));
  return next_real(r, "z of a node", &r->z[place]);
}

static sph_status read_nodes(reader *r) {
  int64_t count, blocks = 1, number, entity, parametric;
  MSH_CHECK(r, r->node.count == 0, SPH_E_IO, "a second section of nodes", r->path, r->line);
  if (r->version == 41) SPH_TRY(next_integer(r, "the number of blocks", 0, SPHI_MESH_MAX, &blocks));
  SPH_TRY(next_integer(r, "the number of nodes", 0, SPHI_MESH_MAX, &count));
  if (r->version == 22)
    for (int64_t k = 0; k < count; k++) {
      SPH_TRY(next_integer(r, "the number of a node", 1, INT64_MAX, &number));
      SPH_TRY(append(r, &r->node, number, k));
      SPH_TRY(read_place(r, k));
    }
  else
    SPH_TRY(skip(r, "the smallest or largest number", 2));
  for (int64_t b = 0, first = 0, inside; b < blocks && r->version == 41; b++, first += inside) {
    SPH_TRY(next_integer(r, "the dimension of an entity", 0, 3, &entity));
    SPH_TRY(next_integer(r, "the number of an entity", -INT32_MAX, INT32_MAX, &entity));
    SPH_TRY(next_integer(r, "0 for nodes without parameters", 0, 0, &parametric));
    SPH_TRY(next_integer(r, "the number of nodes in the block", 0, count - first, &inside));
    for (int64_t k = 0; k < inside; k++) {
      SPH_TRY(next_integer(r, "the number of a node", 1, INT64_MAX, &number));
      SPH_TRY(append(r, &r->node, number, first + k));
    }
    for (int64_t k = 0; k < inside; k++) SPH_TRY(read_place(r, first + k));
  }
  SPH_TRY(expect(r, "$EndNodes"));
  MSH_CHECK(r, r->node.count == count, SPH_E_IO,
            "the blocks have %" PRId64 " nodes, not the %" PRId64 " that the section says", r->path,
            r->line, r->node.count, count);
  return SPH_OK;
}

static sph_status read_corners(reader *r, int64_t type, int64_t group) {
  if (type == TRIANGLE_OF_3) {
    MSH_GROW(r, r->corner, r->corner_capacity, 3 * (r->cells + 1));
    MSH_GROW(r, r->cell_line, r->line_capacity, r->cells + 1);
    r->cell_line[r->cells] = r->line;
    for (int k = 0; k < 3; k++)
      SPH_TRY(next_integer(r, "a corner", 1, INT64_MAX, &r->corner[3 * r->cells + k]));
    r->cells++;
    return SPH_OK;
  }
  if (type == LINE_OF_2) {
    MSH_GROW(r, r->ends, r->ends_capacity, 2 * (r->edges + 1));
    MSH_GROW(r, r->group, r->group_capacity, r->edges + 1);
    r->group[r->edges] = group;
    for (int k = 0; k < 2; k++)
      SPH_TRY(next_integer(r, "an end of a line", 1, INT64_MAX, &r->ends[2 * r->edges + k]));
    r->edges += group != 0;
    return SPH_OK;
  }
  int64_t unused;
  MSH_CHECK(r, type == POINT, SPH_E_UNSUPPORTED,
            "elements must be triangles of 3 nodes, lines of 2 or points (types 2, 1 and 15), got "
            "type %" PRId64,
            r->path, r->line, type);
  return next_integer(r, "the node of a point", 1, INT64_MAX, &unused);
}

static sph_status read_element_2(reader *r) {
  int64_t unused, type, tags, group = 0, tag;
  SPH_TRY(next_integer(r, "the number of an element", 1, INT64_MAX, &unused));
  SPH_TRY(next_integer(r, "the type of an element", 1, 1000, &type));
  SPH_TRY(next_integer(r, "the number of tags", 0, 1000, &tags));
  for (int64_t k = 0; k < tags; k++) {
    SPH_TRY(next_integer(r, "a tag", -INT32_MAX, INT32_MAX, &tag));
    if (k == 0) group = tag < 0 ? -tag : tag;
  }
  return read_corners(r, type, group);
}

static sph_status read_elements(reader *r) {
  int64_t count, blocks = 1, done = 0, dim, entity, type, inside, unused;
  MSH_CHECK(r, r->cells == 0 && r->edges == 0, SPH_E_IO, "a second section of elements", r->path,
            r->line);
  if (r->version == 41) SPH_TRY(next_integer(r, "the number of blocks", 0, SPHI_MESH_MAX, &blocks));
  SPH_TRY(next_integer(r, "the number of elements", 0, SPHI_MESH_MAX, &count));
  if (r->version == 22)
    for (; done < count; done++) SPH_TRY(read_element_2(r));
  else
    SPH_TRY(skip(r, "the smallest or largest number", 2));
  for (int64_t b = 0; b < blocks && r->version == 41; b++, done += inside) {
    SPH_TRY(next_integer(r, "the dimension of an entity", 0, 3, &dim));
    SPH_TRY(next_integer(r, "the number of an entity", -INT32_MAX, INT32_MAX, &entity));
    SPH_TRY(next_integer(r, "the type of elements", 1, 1000, &type));
    SPH_TRY(next_integer(r, "the number of elements in the block", 0, count - done, &inside));
    const int64_t found = dim == 1 ? place_of(&r->curve, entity) : 0;
    const int64_t group = found > 0 ? found : 0;
    for (int64_t k = 0; k < inside; k++) {
      SPH_TRY(next_integer(r, "the number of an element", 1, INT64_MAX, &unused));
      SPH_TRY(read_corners(r, type, group));
    }
  }
  SPH_TRY(expect(r, "$EndElements"));
  MSH_CHECK(r, done == count, SPH_E_IO,
            "the blocks have %" PRId64 " elements, not the %" PRId64 " that the section says",
            r->path, r->line, done, count);
  return SPH_OK;
}

static sph_status read_sections(reader *r) {
  static const struct {
    const char *name;
    sph_status (*read)(reader *r);
  } sections[] = {{"$PhysicalNames", read_names},
                  {"$Entities", read_entities},
                  {"$Nodes", read_nodes},
                  {"$Elements", read_elements}};
  SPH_TRY(expect(r, "$MeshFormat"));
  SPH_TRY(read_format(r));
  while (r->cells == 0) {
    SPH_TRY(next(r, r->node.count ? "$Elements" : "$Nodes"));
    MSH_CHECK(r, r->token[0] == '$', SPH_E_IO, "a section should begin here, got \"%.40s\"",
              r->path, r->line, r->token);
    size_t k = 0;
    while (k < 4 && strcmp(r->token, sections[k].name) != 0) k++;
    if (k < 4) {
      SPH_TRY(sections[k].read(r));
      MSH_CHECK(r, k < 3 || r->cells > 0, SPH_E_IO, "there are no triangles", r->path, r->line);
      continue;
    }
    char end[TOKEN_BYTES + 4];
    snprintf(end, sizeof end, "$End%s", r->token + 1);
    do SPH_TRY(next(r, end));
    while (strcmp(r->token, end) != 0);
  }
  MSH_CHECK(r, r->node.count > 0, SPH_E_IO, "there are elements before any nodes", r->path,
            r->line);
  return SPH_OK;
}

/* ---- what was read as a mesh ---- */

/* Numbers of the file become places; nodes of no triangle go, and those behind them move up. */
static sph_status number_nodes(reader *r, int32_t *corner, int32_t *ends, int32_t *kept,
                               int64_t *nodes) {
  sph_context *context = r->context;
  number_list *list = &r->node;
  bool sorted = true;
  for (int64_t k = 1; k < list->count && sorted; k++)
    sorted = list->pair[k].key > list->pair[k - 1].key;
  if (!sorted) qsort(list->pair, (size_t)list->count, sizeof *list->pair, by_key);
  for (int64_t k = 1; k < list->count; k++)
    SPH_CHECK(context, list->pair[k].key != list->pair[k - 1].key, SPH_E_IO,
              "mesh: file \"%.300s\": two nodes have the number %" PRId64, r->path,
              list->pair[k].key);
  for (int64_t k = 0; k < 3 * r->cells; k++) {
    const int64_t place = place_of(list, r->corner[k]);
    SPH_CHECK(context, place >= 0, SPH_E_IO,
              "mesh: file \"%.300s\", line %" PRId64 ": no node has the number %" PRId64, r->path,
              r->cell_line[k / 3], r->corner[k]);
    corner[k] = (int32_t)place;
    kept[place] = 1;
  }
  *nodes = 0;
  for (int64_t a = 0; a < list->count; a++) {
    const bool keep = kept[a];
    kept[a] = keep ? (int32_t)*nodes : -1;
    if (!keep) continue;
    memcpy(r->x + 2 * *nodes, r->x + 2 * a, 2 * sizeof *r->x);
    r->z[*nodes] = r->z[a];
    ++*nodes;
  }
  for (int64_t k = 0; k < 3 * r->cells; k++) corner[k] = kept[corner[k]];
  for (int64_t k = 0; k < 2 * r->edges; k++) {
    const int64_t place = place_of(list, r->ends[k]);
    SPH_CHECK(context, place >= 0 && kept[place] >= 0, SPH_E_IO,
              "mesh: file \"%.300s\": a line ends at node %" PRId64 ", which no triangle has",
              r->path, r->ends[k]);
    ends[k] = kept[place];
  }
  return SPH_OK;
}

/* All triangles clockwise: the surface was drawn that way round. */
static void turn_round(const reader *r, int32_t *corner) {
  for (int64_t c = 0; c < r->cells; c++) {
    const double *p[3];
    for (int k = 0; k < 3; k++) p[k] = r->x + 2 * (int64_t)corner[3 * c + k];
    if ((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]) >= 0)
      return;
  }
  for (int64_t c = 0; c < r->cells; c++) {
    const int32_t swap = corner[3 * c + 1];
    corner[3 * c + 1] = corner[3 * c + 2];
    corner[3 * c + 2] = swap;
  }
}

static sph_status check_plane(const reader *r, int64_t nodes) {
  double size = 0;
  for (int64_t k = 0; k < 2 * nodes; k++) size = fmax(size, fabs(r->x[k]));
  for (int64_t a = 0; a < nodes; a++)
    SPH_CHECK(r->context, fabs(r->z[a] - r->z[0]) <= 1e-9 * size, SPH_E_UNSUPPORTED,
              "mesh: file \"%.300s\": z is not the same everywhere: %g m at (%g, %g) m, %g m "
              "elsewhere",
              r->path, r->z[a], r->x[2 * a], r->x[2 * a + 1], r->z[0]);
  return SPH_OK;
}

/* Physical groups become tags, in the order of their numbers. */
static sph_status make_tags(const reader *r, int32_t *tags, char names[][SPHI_MESH_NAME + 1],
                            int *count) {
  int64_t groups[SPHI_MESH_TAGS];
  int n = 0;
  for (int64_t k = 0; k < r->edges; k++) {
    int at = 0;
    while (at < n && groups[at] < r->group[k]) at++;
    if (at < n && groups[at] == r->group[k]) continue;
    SPH_CHECK(r->context, n < SPHI_MESH_TAGS, SPH_E_IO,
              "mesh: file \"%.300s\": more than %d groups of lines", r->path, SPHI_MESH_TAGS);
    memmove(groups + at + 1, groups + at, (size_t)(n - at) * sizeof *groups);
    groups[at] = r->group[k];
    n++;
  }
  for (int64_t k = 0; k < r->edges; k++)
    for (int at = 0; at < n; at++)
      if (groups[at] == r->group[k]) tags[k] = at + 1;
  for (int at = 0; at < n; at++) {
    snprintf(names[at], SPHI_MESH_NAME + 1, "%" PRId64, groups[at]);
    for (int k = 0; k < r->named; k++)
      if (r->named_group[k] == groups[at]) memcpy(names[at], r->name[k], sizeof r->name[k]);
  }
  *count = n;
  return SPH_OK;
}

static sph_status make(reader *r, sph_mesh **out) {
  sph_context *context = r->context;
  char names[SPHI_MESH_TAGS][SPHI_MESH_NAME + 1], what[340];
  const char *name[SPHI_MESH_TAGS];
  int64_t nodes = 0;
  int count = 0;
  int32_t *corner = SPHI_NEW(context, 3 * r->cells, int32_t);
  int32_t *ends = SPHI_NEW(context, 2 * r->edges, int32_t);
  int32_t *tags = SPHI_NEW(context, r->edges, int32_t);
  int32_t *kept = SPHI_NEW(context, r->node.count, int32_t);
  sph_status status = SPH_OK;
  snprintf(what, sizeof what, "mesh: file \"%.300s\"", r->path);
  for (int k = 0; k < SPHI_MESH_TAGS; k++) name[k] = names[k];
  if (!corner || !ends || !tags || !kept)
    status = SPHI_ERROR(context, SPH_E_MEMORY, "%s: out of memory", what);
  if (status == SPH_OK) status = number_nodes(r, corner, ends, kept, &nodes);
  if (status == SPH_OK) status = check_plane(r, nodes);
  if (status == SPH_OK) status = make_tags(r, tags, names, &count);
  if (status == SPH_OK) {
    turn_round(r, corner);
    const sphi_mesh_source source = {.what = what, .line = r->cell_line};
    status = sphi_mesh_make(context, &source, nodes, r->x, r->cells, corner, r->edges, ends, tags,
                            count, name, out);
  }
  sphi_free(context, corner);
  sphi_free(context, ends);
  sphi_free(context, tags);
  sphi_free(context, kept);
  return status;
}

static sph_status read_file(reader *r) {
  errno = 0;
  r->stream = fopen(r->path, "rb");
  SPH_CHECK(r->context, r->stream, SPH_E_IO, "mesh: file \"%.300s\": cannot be opened: %s", r->path,
            errno ? strerror(errno) : "unknown reason");
  return read_sections(r);
}

sph_status sph_mesh_create_gmsh(sph_context *context, const char *path, sph_mesh **out) {
  if (out) *out = NULL;
  if (!context) return SPH_E_ARGUMENT;
  SPH_CHECK(context, path && out, SPH_E_ARGUMENT, "mesh: %s is NULL", path ? "out" : "path");
  reader *r = SPHI_NEW(context, 1, reader);
  SPH_CHECK(context, r, SPH_E_MEMORY, "mesh: file \"%.300s\": out of memory", path);
  r->context = context;
  r->path = path;
  r->line = 1;
  /* Of this thread only: the caller's other threads and its own locale stay as they are. */
  const locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  sph_status status = SPH_OK;
  if (plain) {
    const locale_t before = uselocale(plain);
    status = read_file(r);
    uselocale(before);
    freelocale(plain);
  } else {
    status = SPHI_ERROR(context, SPH_E_MEMORY, "mesh: file \"%.300s\": out of memory", path);
  }
  if (r->stream) fclose(r->stream);
  if (status == SPH_OK) status = make(r, out);
  void *const arrays[] = {r->x,         r->z,    r->node.pair, r->corner,
                          r->cell_line, r->ends, r->group,     r->curve.pair};
  for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++) sphi_free(context, arrays[k]);
  sphi_free(context, r);
  return status;
}
