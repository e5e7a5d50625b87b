/* Meshes of triangles: what belongs to what, geometry, where points are, paddles, files. */
#include <unistd.h>

#include "sph_test.h"

static double wavy_bed(double x, void *user) { return 0.1 * sin(3 * x) + *(const double *)user; }

static sph_context *new_context(void) {
  sph_context *context;
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  return context;
}

static sph_mesh *wavy(sph_context *context, int columns, int rows) {
  double low = -0.2;
  sph_mesh *mesh;
  SPH_TEST_OK(context,
              sph_mesh_create_flume(context, 1, 4, 0.7, columns, rows, wavy_bed, &low, &mesh));
  return mesh;
}

static void flume_covers_what_is_between_bed_and_top(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = wavy(context, 60, 20);
  CU_ASSERT(sph_mesh_node_count(mesh) == 61 * 21);
  CU_ASSERT(sph_mesh_cell_count(mesh) == 2400);
  CU_ASSERT(sph_mesh_edge_count(mesh) == 61 * 20 + 60 * 21 + 1200);
  static double area[2400], x[2 * 61 * 21];
  SPH_TEST_OK(context, sph_mesh_read_areas(mesh, area, 2400));
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, x, 2 * 61 * 21));
  double sum = 0, exact = 0;
  for (int c = 0; c < 2400; c++) sum += area[c];
  for (int i = 0; i < 60; i++) { /* trapezoids under the polyline of the nodes */
    double low = -0.2;
    const double a = 1 + 0.05 * i, b = 1 + 0.05 * (i + 1);
    exact += 0.05 * (0.7 - 0.5 * (wavy_bed(a, &low) + wavy_bed(b, &low)));
  }
  SPH_TEST_CLOSE(sum, exact, 1e-13, 0);
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

static void edges_and_neighbours_agree(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = wavy(context, 17, 9);
  const int64_t cells = sph_mesh_cell_count(mesh), edges = sph_mesh_edge_count(mesh);
  int32_t *corner = malloc(sizeof *corner * 3 * (size_t)cells);
  int32_t *beside = malloc(sizeof *beside * 3 * (size_t)cells);
  int32_t *ends = malloc(sizeof *ends * 2 * (size_t)edges);
  int32_t *side = malloc(sizeof *side * 2 * (size_t)edges);
  int32_t *tags = malloc(sizeof *tags * (size_t)edges);
  SPH_TEST_OK(context, sph_mesh_read_cells(mesh, corner, 3 * cells));
  SPH_TEST_OK(context, sph_mesh_read_neighbours(mesh, beside, 3 * cells));
  SPH_TEST_OK(context, sph_mesh_read_edges(mesh, ends, side, tags, edges));
  int on_boundary = 0, tagged[5] = {0};
  for (int64_t e = 0; e < edges; e++) {
    for (int s = 0; s < 2; s++) {
      const int32_t c = side[2 * e + s];
      if (c < 0) {
        CU_ASSERT(s == 1);
        continue;
      }
      bool found =
          false; /* the edge, from one end to the other or back, and beyond it the other cell */
      for (int k = 0; k < 3; k++)
        found = found || (corner[3 * c + (k + 1) % 3] == ends[2 * e + s] &&
                          corner[3 * c + (k + 2) % 3] == ends[2 * e + 1 - s] &&
                          beside[3 * c + k] == side[2 * e + 1 - s]);
      CU_ASSERT(found);
    }
    CU_ASSERT((side[2 * e + 1] < 0) == (tags[e] != 0));
    on_boundary += side[2 * e + 1] < 0;
    tagged[tags[e]]++;
  }
  CU_ASSERT(on_boundary == 2 * (17 + 9));
  CU_ASSERT(tagged[1] == 17 && tagged[2] == 9 && tagged[3] == 9 && tagged[4] == 17);
  CU_ASSERT(sph_mesh_tag_count(mesh) == 4);
  CU_ASSERT_STRING_EQUAL(sph_mesh_tag_name(mesh, 1), "bed");
  CU_ASSERT_STRING_EQUAL(sph_mesh_tag_name(mesh, 4), "top");
  CU_ASSERT_STRING_EQUAL(sph_mesh_tag_name(mesh, 5), "");
  int tag = 0;
  SPH_TEST_OK(context, sph_mesh_find_tag(mesh, "right", &tag));
  CU_ASSERT(tag == 3);
  SPH_TEST_STATUS(context, sph_mesh_find_tag(mesh, "lift", &tag), SPH_E_NAME, "\"left\"");
  free(corner);
  free(beside);
  free(ends);
  free(side);
  free(tags);
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

static void gradients_are_exact_for_straight_lines(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = wavy(context, 23, 7);
  const int64_t cells = sph_mesh_cell_count(mesh), nodes = sph_mesh_node_count(mesh);
  double *x = malloc(sizeof *x * 2 * (size_t)nodes), *g = malloc(sizeof *g * 6 * (size_t)cells);
  int32_t *corner = malloc(sizeof *corner * 3 * (size_t)cells);
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, x, 2 * nodes));
  SPH_TEST_OK(context, sph_mesh_read_gradients(mesh, g, 6 * cells));
  SPH_TEST_OK(context, sph_mesh_read_cells(mesh, corner, 3 * cells));
  double worst = 0;
  for (int64_t c = 0; c < cells; c++)
    for (int d = 0; d < 2; d++) {
      double slope = 0, sum = 0;
      for (int k = 0; k < 3; k++) {
        const double *at = x + 2 * corner[3 * c + k];
        slope += g[6 * c + 2 * k + d] * (0.3 + 2.25 * at[0] - 1.75 * at[1]);
        sum += g[6 * c + 2 * k + d];
      }
      worst = fmax(worst, fabs(slope - (d == 0 ? 2.25 : -1.75)));
      worst = fmax(worst, fabs(sum));
    }
  SPH_TEST_BELOW(worst, 1e-11);
  free(x);
  free(g);
  free(corner);
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

/* The lowest cell with the point, by looking at all. */
static int32_t brute_force(int64_t cells, const int32_t *corner, const double *nodes,
                           const double *g, const double *x) {
  for (int32_t c = 0; c < cells; c++) {
    const double *first = nodes + 2 * corner[3 * c];
    double share[3];
    for (int k = 1; k < 3; k++)
      share[k] = g[6 * c + 2 * k] * (x[0] - first[0]) + g[6 * c + 2 * k + 1] * (x[1] - first[1]);
    share[0] = 1 - share[1] - share[2];
    if (share[0] >= -1e-12 && share[1] >= -1e-12 && share[2] >= -1e-12) return c;
  }
  return -1;
}

enum { POINTS = 3000 };

static void compare_with_brute_force(sph_context *context, sph_mesh *mesh, uint64_t seed) {
  const int64_t cells = sph_mesh_cell_count(mesh), nodes = sph_mesh_node_count(mesh);
  double *x = malloc(sizeof *x * 2 * (size_t)nodes), *g = malloc(sizeof *g * 6 * (size_t)cells);
  int32_t *corner = malloc(sizeof *corner * 3 * (size_t)cells);
  static double point[2 * POINTS];
  static int32_t fresh[POINTS], walked[POINTS];
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, x, 2 * nodes));
  SPH_TEST_OK(context, sph_mesh_read_gradients(mesh, g, 6 * cells));
  SPH_TEST_OK(context, sph_mesh_read_cells(mesh, corner, 3 * cells));
  for (int k = 0; k < POINTS; k++) {
    point[2 * k] = 0.8 + 3.4 * sph_test_random(&seed);
    point[2 * k + 1] = -0.5 + 1.4 * sph_test_random(&seed);
    const int64_t a = (int64_t)(sph_test_random(&seed) * (double)nodes);
    const int64_t c = (int64_t)(sph_test_random(&seed) * (double)cells);
    for (int d = 0; d < 2 && k % 5 < 2; d++) /* on nodes and in the middle of edges */
      point[2 * k + d] = k % 5 == 0
                             ? x[2 * a + d]
                             : 0.5 * (x[2 * corner[3 * c] + d] + x[2 * corner[3 * c + 1] + d]);
    fresh[k] = -1;
    walked[k] = (int32_t)(sph_test_random(&seed) * (double)cells);
  }
  SPH_TEST_OK(context, sph_mesh_locate(mesh, POINTS, point, fresh));
  SPH_TEST_OK(context, sph_mesh_locate(mesh, POINTS, point, walked));
  int wrong = 0, inside = 0;
  for (int k = 0; k < POINTS; k++) {
    const int32_t expected = brute_force(cells, corner, x, g, point + 2 * k);
    wrong += fresh[k] != expected || walked[k] != expected;
    inside += expected >= 0;
  }
  CU_ASSERT(wrong == 0);
  CU_ASSERT(inside > POINTS / 3 && inside < POINTS);
  free(x);
  free(g);
  free(corner);
}

static void places_are_those_of_brute_force_from_any_start(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = wavy(context, 41, 13);
  compare_with_brute_force(context, mesh, 7);
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

static void push_left_end(double t, double *displacement, double *velocity, double *acceleration,
                          void *user) {
  (void)user;
  displacement[0] = 0.3 * t;
  velocity[0] = 0.3;
  acceleration[0] = 0;
}

static void places_follow_a_paddle(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = wavy(context, 41, 13);
  SPH_TEST_OK(context, sph_mesh_set_paddle(mesh, push_left_end, NULL, 1.234));
  for (int k = -2; k <= 2; k++) {
    SPH_TEST_OK(context, sph_mesh_move(mesh, k));
    compare_with_brute_force(context, mesh, (uint64_t)(11 + k));
  }
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

static void nodes_follow_a_paddle_as_far_as_it_reaches(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = wavy(context, 30, 4);
  static double rest[2 * 31 * 5], now[2 * 31 * 5], area[240];
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, rest, 2 * 31 * 5));
  SPH_TEST_OK(context, sph_mesh_set_paddle(mesh, push_left_end, NULL, 1.5));
  SPH_TEST_OK(context, sph_mesh_move(mesh, 2));
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, now, 2 * 31 * 5));
  for (int a = 0; a < 31 * 5; a++) {
    const double share = 1 - (rest[2 * a] - 1) / 1.5;
    SPH_TEST_CLOSE(now[2 * a], rest[2 * a] + (share > 0 ? 0.6 * share : 0), 1e-15, 0);
    CU_ASSERT(now[2 * a + 1] == rest[2 * a + 1]);
  }
  SPH_TEST_OK(context, sph_mesh_read_areas(mesh, area, 240));
  for (int c = 0; c < 240; c++) CU_ASSERT(area[c] > 0);
  SPH_TEST_STATUS(context, sph_mesh_move(mesh, 5.1), SPH_E_ARGUMENT, "folds cell");
  static double after[2 * 31 * 5];
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, after, 2 * 31 * 5));
  CU_ASSERT(memcmp(now, after, sizeof now) == 0);
  SPH_TEST_OK(context, sph_mesh_set_paddle(mesh, NULL, NULL, 0));
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, after, 2 * 31 * 5));
  CU_ASSERT(memcmp(rest, after, sizeof rest) == 0);
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

static void polyline_has_its_vertices_at_nodes(void) {
  sph_context *context = new_context();
  const double bar[] = {0, 0, 3.03, 0, 4.01, 0.25, 6.02, 0.25, 7.17, 0, 10, 0};
  sph_mesh *mesh;
  SPH_TEST_OK(context, sph_mesh_create_flume_polyline(context, 6, bar, 0.8, 100, 6, &mesh));
  static double x[2 * 101 * 7];
  SPH_TEST_OK(context, sph_mesh_read_nodes(mesh, x, 2 * 101 * 7));
  for (int v = 0; v < 6; v++) {
    bool found = false;
    for (int i = 0; i <= 100; i++)
      found = found || (x[14 * i] == bar[2 * v] && x[14 * i + 1] == bar[2 * v + 1]);
    CU_ASSERT(found);
  }
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

static void write_text(const char *path, const char *text) {
  FILE *file = fopen(path, "wb");
  CU_ASSERT_FATAL(file != NULL);
  fputs(text, file);
  fclose(file);
}

/* A unit square of two triangles, clockwise as Gmsh writes surfaces drawn that way round, with a node that
 * is only a point of the geometry. */
static const char *const square_2 =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n3\n1 7 \"bed\"\n1 9 \"open top\"\n2 1 \"water\"\n$EndPhysicalNames\n"
    "$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n9 0.5 0.5 0\n$EndNodes\n"
    "$Elements\n6\n1 15 2 0 1 9\n2 1 2 9 3 3 4\n3 1 2 7 1 1 2\n4 1 2 3 2 2 3\n"
    "5 2 2 1 6 1 3 2\n6 2 2 1 6 1 4 3\n$EndElements\n";
static const char *const square_4 =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n3\n1 7 \"bed\"\n1 9 \"open top\"\n2 1 \"water\"\n$EndPhysicalNames\n"
    "$Entities\n1 4 1 0\n1 0 0 0 0\n"
    "1 0 0 0 1 0 0 1 7 2 1 -2\n2 1 0 0 1 1 0 1 3 2 2 -3\n3 0 1 0 1 1 0 1 9 2 3 -4\n"
    "4 0 0 0 0 1 0 0 2 4 -1\n1 0 0 0 1 1 0 1 1 4 1 2 3 4\n$EndEntities\n"
    "$Nodes\n2 4 1 12\n0 1 0 1\n1\n0 0 0\n2 1 0 3\n12\n3\n4\n1 0 0\n1 1 0\n0 1 0\n$EndNodes\n"
    "$Comments\nanything 1 2 3\n$EndComments\n"
    "$Elements\n4 5 1 6\n1 1 1 1\n1 1 12\n1 2 1 1\n2 12 3\n1 3 1 1\n3 3 4\n"
    "2 1 2 2\n5 1 12 3\n6 1 3 4\n$EndElements\n";

static void both_versions_of_gmsh_are_read(void) {
  sph_context *context = new_context();
  char path[64];
  snprintf(path, sizeof path, "/tmp/sph_t35_%ld.msh", (long)getpid());
  for (int version = 0; version < 2; version++) {
    sph_mesh *mesh;
    write_text(path, version ? square_4 : square_2);
    SPH_TEST_OK(context, sph_mesh_create_gmsh(context, path, &mesh));
    CU_ASSERT(sph_mesh_node_count(mesh) == 4);
    CU_ASSERT(sph_mesh_cell_count(mesh) == 2);
    CU_ASSERT(sph_mesh_edge_count(mesh) == 5);
    CU_ASSERT_FATAL(sph_mesh_tag_count(mesh) == 3);
    CU_ASSERT_STRING_EQUAL(sph_mesh_tag_name(mesh, 1), "3");
    CU_ASSERT_STRING_EQUAL(sph_mesh_tag_name(mesh, 2), "bed");
    CU_ASSERT_STRING_EQUAL(sph_mesh_tag_name(mesh, 3), "open top");
    double area[2];
    int32_t ends[10], cells[10], tags[5], count[4] = {0};
    SPH_TEST_OK(context, sph_mesh_read_areas(mesh, area, 2));
    SPH_TEST_CLOSE(area[0], 0.5, 1e-15, 0);
    SPH_TEST_CLOSE(area[1], 0.5, 1e-15, 0);
    SPH_TEST_OK(context, sph_mesh_read_edges(mesh, ends, cells, tags, 5));
    for (int e = 0; e < 5; e++) count[tags[e]]++;
    CU_ASSERT(count[0] == 2 && count[1] == 1 && count[2] == 1 && count[3] == 1);
    sph_mesh_destroy(&mesh);
  }
  remove(path);
  sph_context_destroy(&context);
}

static long size_of(const char *path) {
  FILE *file = fopen(path, "rb");
  if (!file) return -1;
  fseek(file, 0, SEEK_END);
  const long size = ftell(file);
  fclose(file);
  return size;
}

static void file_for_paraview_has_what_its_header_says(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = wavy(context, 5, 3);
  char path[64], temporary[80];
  snprintf(path, sizeof path, "/tmp/sph_t35_%ld.vtu", (long)getpid());
  snprintf(temporary, sizeof temporary, "%s.tmp", path);
  double at_nodes[2 * 24], of_cells[30];
  for (int k = 0; k < 48; k++) at_nodes[k] = k;
  for (int k = 0; k < 30; k++) of_cells[k] = 100 + k;
  const sph_mesh_field node = {"velocity", "m/s", 2, at_nodes}, cell = {"p<0>", NULL, 1, of_cells};
  SPH_TEST_OK(context, sph_mesh_write_vtk(mesh, path, 1.5, 1, &node, 1, &cell));
  CU_ASSERT(size_of(temporary) < 0);
  const long bytes = size_of(path);
  char *text = calloc((size_t)bytes + 1, 1);
  FILE *file = fopen(path, "rb");
  CU_ASSERT(fread(text, 1, (size_t)bytes, file) == (size_t)bytes);
  fclose(file);
  CU_ASSERT(strstr(text, "NumberOfPoints=\"24\" NumberOfCells=\"46\"") != NULL);
  CU_ASSERT(strstr(text, "Name=\"p&lt;0&gt;\"") != NULL);
  CU_ASSERT(strstr(text, ">1.5</DataArray>") != NULL);
  const char *const raw = strstr(text, "encoding=\"raw\">\n_") + strlen("encoding=\"raw\">\n_");
  const char *const end = text + bytes - strlen("\n  </AppendedData>\n</VTKFile>\n");
  static const uint64_t sizes[] = {24 * 24, 46 * 8, 46 * 4, 24 * 24, 4 * (90 + 32), 46 * 8, 46};
  const char *at = raw;
  for (int k = 0; k < 7; k++) { /* every array is where its header says and as long */
    uint64_t size;
    char offset[32];
    memcpy(&size, at, sizeof size);
    CU_ASSERT(size == sizes[k]);
    snprintf(offset, sizeof offset, "offset=\"%ld\"", (long)(at - raw));
    CU_ASSERT(strstr(text, offset) != NULL);
    if (k == 1) {
      double value;
      memcpy(&value, at + 8 + 29 * 8, sizeof value);
      CU_ASSERT(value == 129);
      memcpy(&value, at + 8 + 30 * 8, sizeof value);
      CU_ASSERT(value == 0);
    }
    at += 8 + size;
  }
  CU_ASSERT(at == end);
  free(text);
  remove(path);
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

SPH_TEST_MAIN(
    "mesh", {"flume covers what is between bed and top", flume_covers_what_is_between_bed_and_top},
    {"edges and neighbours agree", edges_and_neighbours_agree},
    {"gradients are exact for straight lines", gradients_are_exact_for_straight_lines},
    {"places are those of brute force from any start",
     places_are_those_of_brute_force_from_any_start},
    {"places follow a paddle", places_follow_a_paddle},
    {"nodes follow a paddle as far as it reaches", nodes_follow_a_paddle_as_far_as_it_reaches},
    {"polyline has its vertices at nodes", polyline_has_its_vertices_at_nodes},
    {"both versions of Gmsh's files are read", both_versions_of_gmsh_are_read},
    {"file for ParaView has what its header says", file_for_paraview_has_what_its_header_says})
