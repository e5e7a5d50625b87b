/* Meshes: what is refused, and that nothing leaks. */
#include <unistd.h>

#include "sph_test.h"

static sph_context *new_context(void) {
  sph_context *context;
  CU_ASSERT_FATAL(sph_context_create(&context) == SPH_OK);
  return context;
}

static const double square[] = {0, 0, 1, 0, 1, 1, 0, 1};
static const char *const names[] = {"a", "b"};

/* Nodes of the square and more, with these triangles. */
static sph_status make(sph_context *context, int64_t cells, const int32_t *corners,
                       sph_mesh **out) {
  return sph_mesh_create(context, 4, square, cells, corners, 0, NULL, NULL, 0, NULL, out);
}

static void unsound_triangles_are_named(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = NULL;
  const int32_t inverted[] = {0, 1, 2, 0, 3, 2}, twice[] = {0, 1, 2, 0, 2, 3, 2, 0, 1};
  const int32_t flat[] = {0, 1, 2, 0, 2, 2}, far[] = {0, 1, 2, 0, 2, 4}, one[] = {0, 1, 2};
  SPH_TEST_STATUS(context, make(context, 2, inverted, &mesh), SPH_E_ARGUMENT, "cell 1 is inverted");
  SPH_TEST_STATUS(context, make(context, 3, twice, &mesh), SPH_E_ARGUMENT,
                  "cell 2 has the corners of cell 0");
  SPH_TEST_STATUS(context, make(context, 2, flat, &mesh), SPH_E_ARGUMENT, "cell 1 is degenerate");
  SPH_TEST_STATUS(context, make(context, 2, far, &mesh), SPH_E_ARGUMENT, "cell 1 has node 4");
  SPH_TEST_STATUS(context, make(context, 1, one, &mesh), SPH_E_ARGUMENT,
                  "node 3 at (0, 1) m is of no triangle");
  SPH_TEST_STATUS(context, make(context, 0, one, &mesh), SPH_E_ARGUMENT, "cells must be");
  const double nan[] = {0, 0, 1, 0, 1, NAN};
  SPH_TEST_STATUS(context, sph_mesh_create(context, 3, nan, 1, one, 0, NULL, NULL, 0, NULL, &mesh),
                  SPH_E_ARGUMENT, "node 2");
  const double fan[] = {0, 0, 1, 0, 0.3, 1, 0.5, -1, 0.6, 0.5};
  const int32_t three[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
  SPH_TEST_STATUS(context,
                  sph_mesh_create(context, 5, fan, 3, three, 0, NULL, NULL, 0, NULL, &mesh),
                  SPH_E_ARGUMENT, "belongs to cell 0, cell 1 and cell 2");
  const int32_t overlap[] = {0, 1, 2, 0, 1, 4};
  SPH_TEST_STATUS(context,
                  sph_mesh_create(context, 5, fan, 2, overlap, 0, NULL, NULL, 0, NULL, &mesh),
                  SPH_E_ARGUMENT, "cell 0 and cell 1 overlap");
  CU_ASSERT(mesh == NULL);
  sph_context_destroy(&context);
}

static void wrong_tags_are_refused(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = NULL;
  const int32_t cells[] = {0, 1, 2, 0, 2, 3}, no_edge[] = {1, 3}, ends[] = {0, 1, 1, 0};
  const int32_t tags[] = {1, 2}, beyond[] = {3};
  const char *const same[] = {"a", "a"};
  SPH_TEST_STATUS(context,
                  sph_mesh_create(context, 4, square, 2, cells, 1, no_edge, tags, 2, names, &mesh),
                  SPH_E_ARGUMENT, "is of no triangle");
  SPH_TEST_STATUS(context,
                  sph_mesh_create(context, 4, square, 2, cells, 2, ends, tags, 2, names, &mesh),
                  SPH_E_ARGUMENT, "two tags, \"a\" and \"b\"");
  SPH_TEST_STATUS(context,
                  sph_mesh_create(context, 4, square, 2, cells, 1, ends, beyond, 2, names, &mesh),
                  SPH_E_ARGUMENT, "must be 1 to 2");
  SPH_TEST_STATUS(context,
                  sph_mesh_create(context, 4, square, 2, cells, 1, ends, tags, 2, same, &mesh),
                  SPH_E_ARGUMENT, "one name");
  CU_ASSERT(mesh == NULL);
  sph_context_destroy(&context);
}

static double nowhere(double x, void *user) { return x > *(double *)user ? NAN : 0; }
static void bad_motion(double t, double *displacement, double *velocity, double *acceleration,
                       void *user) {
  (void)t, (void)acceleration;
  displacement[0] = *(double *)user;
  velocity[0] = 0;
}

static void flumes_and_calls_check_their_arguments(void) {
  sph_context *context = new_context();
  sph_mesh *mesh = NULL;
  double half = 0.5, wrong = NAN, x[2] = {NAN, 0};
  int32_t cell = -1;
  SPH_TEST_STATUS(context, sph_mesh_create_flume(context, 1, 1, 1, 2, 2, NULL, NULL, &mesh),
                  SPH_E_ARGUMENT, "from one place");
  SPH_TEST_STATUS(context, sph_mesh_create_flume(context, 0, 1, 1, 0, 2, NULL, NULL, &mesh),
                  SPH_E_ARGUMENT, "columns and rows");
  SPH_TEST_STATUS(
      context, sph_mesh_create_flume(context, 0, 1, 1, 2000000000, 2000000000, NULL, NULL, &mesh),
      SPH_E_ARGUMENT, "columns and rows");
  SPH_TEST_STATUS(context, sph_mesh_create_flume(context, 0, 1, 0, 4, 2, NULL, NULL, &mesh),
                  SPH_E_ARGUMENT, "below the top");
  SPH_TEST_STATUS(context, sph_mesh_create_flume(context, 0, 1, 1, 4, 2, nowhere, &half, &mesh),
                  SPH_E_ARGUMENT, "x = 0.75");
  const double back[] = {0, 0, 0.5, 0, 0.4, 0, 1, 0}, close[] = {0, 0, 0.5, 0, 0.55, 0, 1, 0};
  SPH_TEST_STATUS(context, sph_mesh_create_flume_polyline(context, 4, back, 1, 9, 2, &mesh),
                  SPH_E_ARGUMENT, "vertex 2");
  SPH_TEST_STATUS(context, sph_mesh_create_flume_polyline(context, 4, close, 1, 4, 2, &mesh),
                  SPH_E_ARGUMENT, "vertex 2");
  SPH_TEST_STATUS(context, sph_mesh_create_flume_polyline(context, 4, close, 1, 2, 2, &mesh),
                  SPH_E_ARGUMENT, "vertices");
  CU_ASSERT(mesh == NULL);
  SPH_TEST_OK(context, sph_mesh_create_flume(context, 0, 1, 1, 4, 2, NULL, NULL, &mesh));
  SPH_TEST_STATUS(context, sph_mesh_locate(mesh, 1, x, &cell), SPH_E_ARGUMENT, "not finite");
  SPH_TEST_STATUS(context, sph_mesh_read_areas(mesh, x, 2), SPH_E_ARGUMENT, "must be 16, got 2");
  SPH_TEST_STATUS(context, sph_mesh_set_paddle(mesh, bad_motion, &wrong, 0), SPH_E_ARGUMENT,
                  "reach");
  SPH_TEST_OK(context, sph_mesh_set_paddle(mesh, bad_motion, &wrong, 1));
  SPH_TEST_STATUS(context, sph_mesh_move(mesh, 0), SPH_E_ARGUMENT, "must be finite");
  const sph_mesh_field twice[] = {{"p", NULL, 1, x}, {"p", NULL, 1, x}}, many = {"p", NULL, 10, x};
  SPH_TEST_STATUS(context, sph_mesh_write_vtk(mesh, "/tmp/x.vtu", 0, 2, twice, 0, NULL),
                  SPH_E_ARGUMENT, "given twice");
  SPH_TEST_STATUS(context, sph_mesh_write_vtk(mesh, "/tmp/x.vtu", 0, 0, NULL, 1, &many),
                  SPH_E_ARGUMENT, "1 to 9 components");
  SPH_TEST_STATUS(context, sph_mesh_write_vtk(mesh, "/nowhere/x.vtu", 0, 0, NULL, 0, NULL),
                  SPH_E_IO, "cannot be created");
  CU_ASSERT(sph_mesh_move(NULL, 0) == SPH_E_ARGUMENT && sph_mesh_cell_count(NULL) == 0);
  sph_mesh_destroy(&mesh);
  sph_mesh_destroy(&mesh);
  sph_context_destroy(&context);
}

#define FORMAT "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define NODES "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 1 1 0\n$EndNodes\n"
#define FORMAT_4 "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"

static const struct {
  const char *text, *message;
  sph_status status;
} bad_files[] = {
    {"", "$MeshFormat", SPH_E_IO},
    {"$MeshFormat\n2.2 1 8\n", "line 2: the file is binary", SPH_E_IO},
    {"$MeshFormat\n4.0 0 8\n", "line 2: version must be 2.2 or 4.1, got \"4.0\"", SPH_E_IO},
    {FORMAT, "ends where $Nodes", SPH_E_IO},
    {FORMAT NODES, "ends where $Elements", SPH_E_IO},
    {FORMAT "$Nodes\n3\n1 0 0 0\n2 nan 0 0\n", "line 7: x of a node must be a finite", SPH_E_IO},
    {FORMAT "$Nodes\n3\n1 0 0 0\n2 1 x 0\n", "line 7: y of a node", SPH_E_IO},
    {FORMAT "$Nodes\n99999999999\n", "line 5: the number of nodes", SPH_E_IO},
    {FORMAT "$Nodes\n-1\n", "line 5: the number of nodes", SPH_E_IO},
    {FORMAT "$Nodes\n90000000\n1 0 0 0\n", "ends where the number of a node", SPH_E_IO},
    {FORMAT NODES NODES, "a second section of nodes", SPH_E_IO},
    {FORMAT NODES "$Elements\n1\n1 3 2 1 1 1 2 3 1\n", "line 12: elements must be triangles",
     SPH_E_UNSUPPORTED},
    {FORMAT NODES "$Elements\n1\n1 2 2 1 1 1 2 4\n$EndElements\n",
     "line 12: no node has the number 4", SPH_E_IO},
    {FORMAT NODES "$Elements\n2\n1 2 2 1 1 1 2 3\n$EndElements\n",
     "line 13: the number of an element", SPH_E_IO},
    {FORMAT NODES "$Elements\n1\n1 15 2 1 1 1\n$EndElements\n", "there are no triangles", SPH_E_IO},
    {FORMAT "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 2 0 0\n$EndNodes\n"
            "$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n",
     "cell 0 (line 12) is degenerate", SPH_E_ARGUMENT},
    {FORMAT NODES "$Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 1 1 2 3 1\n$EndElements\n",
     "cell 1 (line 13) has the corners of cell 0 (line 12)", SPH_E_ARGUMENT},
    {FORMAT NODES "$Elements\n2\n1 2 2 1 1 1 2 3\n2 1 2 5 1 2 7\n$EndElements\n",
     "a line ends at node 7", SPH_E_IO},
    {FORMAT "$Nodes\n3\n1 0 0 0\n1 1 0 0\n3 1 1 0\n$EndNodes\n"
            "$Elements\n1\n1 2 2 1 1 1 1 3\n$EndElements\n",
     "two nodes have the number 1", SPH_E_IO},
    {FORMAT "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 1 1 1\n$EndNodes\n"
            "$Elements\n1\n1 2 2 1 1 1 2 3\n$EndElements\n",
     "z is not the same", SPH_E_UNSUPPORTED},
    {FORMAT "$PhysicalNames\n1\n1 1 \"bed\n", "a name must end on its line", SPH_E_IO},
    {FORMAT "$Weather\nsunny\n", "ends where $EndWeather", SPH_E_IO},
    {FORMAT "Nodes\n", "a section should begin", SPH_E_IO},
    {FORMAT_4 "$Entities\n0 1 0 0\n1 0 0 0 1 0 0 99999999\n", "ends where the number of a group",
     SPH_E_IO},
    {FORMAT_4 "$Nodes\n1 3 1 3\n2 1 0 4\n",
     "line 6: the number of nodes in the block must be 0 to 3", SPH_E_IO},
    {FORMAT_4 "$Nodes\n1 3 1 3\n2 1 1 3\n", "0 for nodes without parameters", SPH_E_IO},
    {FORMAT_4 "$Nodes\n1 3 1 3\n2 1 0 2\n1\n2\n0 0 0\n1 0 0\n$EndNodes\n", "not the 3 that",
     SPH_E_IO}};

static void bad_files_are_refused_with_their_line(void) {
  sph_context *context = new_context();
  char path[64];
  snprintf(path, sizeof path, "/tmp/sph_t35e_%ld.msh", (long)getpid());
  sph_mesh *mesh = NULL;
  for (size_t k = 0; k < sizeof bad_files / sizeof bad_files[0]; k++) {
    FILE *file = fopen(path, "wb");
    CU_ASSERT_FATAL(file != NULL);
    fputs(bad_files[k].text, file);
    fclose(file);
    SPH_TEST_STATUS(context, sph_mesh_create_gmsh(context, path, &mesh), bad_files[k].status,
                    bad_files[k].message);
    CU_ASSERT(mesh == NULL);
  }
  SPH_TEST_STATUS(context, sph_mesh_create_gmsh(context, "/nowhere/x.msh", &mesh), SPH_E_IO,
                  "cannot be opened");
  remove(path);
  sph_context_destroy(&context);
}

static void no_memory_leaks_nothing(void) {
  char path[64];
  snprintf(path, sizeof path, "/tmp/sph_t35m_%ld.msh", (long)getpid());
  FILE *file = fopen(path, "wb");
  CU_ASSERT_FATAL(file != NULL);
  fputs(FORMAT NODES "$Elements\n2\n1 2 2 1 1 1 2 3\n2 1 2 5 1 1 2\n$EndElements\n", file);
  fclose(file);
  const double bed[] = {0, 0, 0.5, 0.1, 1, 0};
  int refused = 0;
  for (int allowed = 0; allowed < 80; allowed++)
    for (int kind = 0; kind < 2; kind++) {
      sph_test_memory memory = {allowed, 0};
      const sph_allocator allocator = {sph_test_allocate, sph_test_release, &memory};
      sph_context *context = NULL;
      sph_mesh *mesh = NULL;
      if (sph_context_create_with_allocator(&allocator, &context) != SPH_OK) continue;
      sph_status status = kind ? sph_mesh_create_gmsh(context, path, &mesh)
                               : sph_mesh_create_flume_polyline(context, 3, bed, 1, 4, 2, &mesh);
      CU_ASSERT((status == SPH_OK) == (mesh != NULL));
      const double x[2] = {0.7, 0.3};
      int32_t cell = -1;
      if (status == SPH_OK) {
        status = sph_mesh_locate(mesh, 1, x, &cell);
        CU_ASSERT(status != SPH_OK || cell >= 0);
      }
      CU_ASSERT(status == SPH_OK || status == SPH_E_MEMORY);
      refused += status != SPH_OK;
      sph_mesh_destroy(&mesh);
      sph_context_destroy(&context);
      CU_ASSERT(memory.live == 0);
    }
  CU_ASSERT(refused > 30 && refused < 150);
  remove(path);
}

SPH_TEST_MAIN("mesh errors", {"unsound triangles are named", unsound_triangles_are_named},
              {"wrong tags are refused", wrong_tags_are_refused},
              {"flumes and calls check their arguments", flumes_and_calls_check_their_arguments},
              {"bad files are refused with their line", bad_files_are_refused_with_their_line},
              {"no memory leaks nothing", no_memory_leaks_nothing})
