/* Meshes: reading the three kinds of files, welding, and what is said of broken ones. */
#include "meshes.h"

#include "base/memory.h"
#include "geometry/mesh_file.h"
#include "geometry/revolution.h"

#include <check.h>
#include <stdlib.h>
#include <unistd.h>

static const double low[3] = {0.1, -0.2, 0.3}, high[3] = {0.7, 0.123456, 2.3};

static char folder[] = "/tmp/halocline_mesh_XXXXXX";

static const char *write_file(const char *name, const void *bytes, size_t length) {
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *const file = fopen(path, "wb");
  ck_assert_ptr_nonnull(file);
  ck_assert_int_eq(fwrite(bytes, 1, length, file), length);
  ck_assert_int_eq(fclose(file), 0);
  return path;
}

static void make_folder(void) {
  ck_assert_ptr_nonnull(mkdtemp(folder));
}

static void remove_folder(void) {
  char command[128];
  snprintf(command, sizeof command, "rm -r %s", folder);
  ck_assert_int_eq(system(command), 0);
}

/* The box as a text, its faces as each kind has them. */
static size_t box_obj(char *to, size_t size) {
  size_t used = 0;
  for (int v = 0; v < 8; v++)
    used += (size_t)snprintf(to + used, size - used, "v %g %g %g\n", v & 1 ? high[0] : low[0],
                             v & 2 ? high[1] : low[1], v & 4 ? high[2] : low[2]);
  return used + (size_t)snprintf(to + used, size - used,
                                 "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n");
}

static size_t box_ply(char *to, size_t size) {
  size_t used =
      (size_t)snprintf(to, size,
                       "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n"
                       "property float z\nelement face 6\nproperty list uchar int vertex_indices\n"
                       "end_header\n");
  for (int v = 0; v < 8; v++)
    used += (size_t)snprintf(to + used, size - used, "%g %g %g\n", v & 1 ? high[0] : low[0],
                             v & 2 ? high[1] : low[1], v & 4 ? high[2] : low[2]);
  return used + (size_t)snprintf(to + used, size - used,
                                 "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n");
}

static size_t stl_text(const hc_mesh *mesh, char *to, size_t size) {
  size_t used = (size_t)snprintf(to, size, "solid box\n");
  for (int32_t t = 0; t < mesh->triangle_count; t++) {
    used += (size_t)snprintf(to + used, size - used, "facet normal 0 0 0\nouter loop\n");
    for (int c = 0; c < 3; c++) {
      const double *const x = mesh->vertex[mesh->triangle[t][c]];
      used += (size_t)snprintf(to + used, size - used, "vertex %g %g %g\n", x[0], x[1], x[2]);
    }
    used += (size_t)snprintf(to + used, size - used, "endloop\nendfacet\n");
  }
  return used + (size_t)snprintf(to + used, size - used, "endsolid box\n");
}

static size_t stl_binary(const hc_mesh *mesh, char *to) {
  memset(to, 0, 84);
  const uint32_t count = (uint32_t)mesh->triangle_count;
  memcpy(to + 80, &count, 4);
  for (uint32_t t = 0; t < count; t++) {
    float record[12] = {0};
    for (int k = 0; k < 9; k++) record[3 + k] = (float)mesh->vertex[mesh->triangle[t][k / 3]][k % 3];
    memcpy(to + 84 + 50 * t, record, 48);
    memset(to + 84 + 50 * t + 48, 0, 2);
  }
  return 84 + 50 * count;
}

static void assert_box(const char *path) {
  hc_mesh mesh;
  hc_error error = {0};
  uint64_t checksum;
  bool turned;
  ck_assert_msg(hc_mesh_file_read(path, &mesh, &checksum, &error) == HC_OK, "%s", error.text);
  ck_assert_int_eq(mesh.triangle_count, 12);
  hc_mesh_weld(&mesh);
  ck_assert_int_eq(mesh.vertex_count, 8);
  ck_assert_msg(hc_mesh_check(&mesh, false, &turned, &error) == HC_OK, "%s: %s", path, error.text);
  ck_assert(!turned);
  double found[2][3];
  hc_mesh_bounds(&mesh, found[0], found[1]);
  for (int a = 0; a < 3; a++) { /* single precision in the file, but the decimals that were meant */
    ck_assert(found[0][a] == low[a]);
    ck_assert(found[1][a] == high[a]);
  }
  ck_assert_double_eq_tol(hc_mesh_volume(&mesh), 0.6 * 0.323456 * 2, 1e-12);
  hc_mesh_free(&mesh);
}

START_TEST(all_kinds_are_read) {
  char *const text = hc_alloc(1 << 16, 1);
  hc_mesh mesh = box_mesh(low, high);
  assert_box(write_file("box.obj", text, box_obj(text, 1 << 16)));
  assert_box(write_file("box.ply", text, box_ply(text, 1 << 16)));
  assert_box(write_file("text.stl", text, stl_text(&mesh, text, 1 << 16)));
  assert_box(write_file("BINARY.STL", text, stl_binary(&mesh, text)));
  hc_mesh_free(&mesh);
  hc_free(text);
}
END_TEST

static void assert_unreadable(const char *path, const char *word) {
  hc_mesh mesh;
  hc_error error = {0};
  uint64_t checksum;
  ck_assert_msg(hc_mesh_file_read(path, &mesh, &checksum, &error) == HC_BAD_INPUT, "%s was read", path);
  ck_assert_msg(strstr(error.text, word) && strstr(error.text, path), "no '%s' in: %s", word, error.text);
  ck_assert_ptr_null(mesh.vertex);
}

START_TEST(files_that_are_no_meshes_are_refused) {
  char *const text = hc_alloc(1 << 16, 1);
  hc_mesh mesh = box_mesh(low, high);
  const size_t length = stl_binary(&mesh, text);
  assert_unreadable("/nowhere/box.obj", "No such file");
  assert_unreadable(write_file("box.dae", "x", 1), ".obj, .stl or .ply");
  assert_unreadable(write_file("box", "x", 1), ".obj, .stl or .ply");
  assert_unreadable(write_file("empty.obj", "", 0), "empty");
  assert_unreadable(write_file("short.stl", text, length / 2), "is cut short");
  assert_unreadable(write_file("noise.ply", "what is this\n", 13), "its head has no end");
  assert_unreadable(write_file("points.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\n", 24), "");
  assert_unreadable(write_file("line.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n", 32),
                    "must have triangles");
  assert_unreadable(write_file("noise.obj", "what is this\n", 13), "");
  hc_mesh_free(&mesh);
  hc_free(text);
}
END_TEST

/* A mesh file of that text. */
static hc_mesh read_text(const char *name, const char *text) {
  hc_mesh mesh;
  hc_error error = {0};
  uint64_t checksum;
  const char *const path = write_file(name, text, strlen(text));
  ck_assert_msg(hc_mesh_file_read(path, &mesh, &checksum, &error) == HC_OK, "%s", error.text);
  return mesh;
}

/* What is far from the origin keeps all its digits: only a binary file of single numbers has lost them. */
START_TEST(coordinates_are_double) {
  const double far[3][3] = {
      {431207.35, -5432100.1, 0.1}, {431208.25, -5432100.1, 0.1}, {431208.25, -5432099.7, 0.30000000001}};
  hc_mesh mesh[3];
  mesh[0] = read_text("far.obj", "v 431207.35 -5432100.1 0.1\nv 431208.25 -5432100.1 .1\n"
                                 "v 431208.25 -5432099.7 0.30000000001\nf 1 2 3\n");
  mesh[1] = read_text(
      "far.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty double y\n"
                 "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
                 "431207.35 -5432100.1 0.1\n431208.25 -5432100.1 0.1\n431208.25 -5432099.7 0.30000000001\n"
                 "3 0 1 2\n");
  mesh[2] =
      read_text("far.stl", "solid far vertex\nfacet normal 0 0 1 outer loop vertex 431207.35 -5432100.1 0.1\n"
                           "vertex 431208.25 -5432100.1 0.1 vertex 431208.25 -5432099.7 0.30000000001\n"
                           "endloop endfacet\nendsolid");
  for (int k = 0; k < 3; k++) {
    ck_assert(mesh[k].vertex_count == 3 && mesh[k].triangle_count == 1);
    ck_assert_mem_eq(mesh[k].vertex, far, sizeof far);
    hc_mesh_free(&mesh[k]);
  }
}
END_TEST

static void turn(char *bytes, size_t size) {
  for (size_t k = 0; k < size / 2; k++) {
    const char kept = bytes[k];
    bytes[k] = bytes[size - 1 - k];
    bytes[size - 1 - k] = kept;
  }
}

/* Of either byte order, with elements and properties that mean nothing here, and a line end of another
 * system. */
START_TEST(binary_plys_are_read) {
  for (int big = 0; big < 2; big++) {
    char bytes[1024];
    size_t used =
        (size_t)snprintf(bytes, sizeof bytes,
                         "ply\r\nformat binary_%s_endian 1.0\r\ncomment end of head\r\nelement camera 1\r\n"
                         "property list uchar short angles\r\nelement vertex 4\r\nproperty uchar red\r\n"
                         "property double x\r\nproperty double y\r\nproperty float z\r\nelement face 1\r\n"
                         "property list uchar uint vertex_indices\r\nproperty int flag\r\nend_header\r\n",
                         big ? "big" : "little");
#define PUT(type, value)                                                                                     \
  do {                                                                                                       \
    const type number = value;                                                                               \
    memcpy(bytes + used, &number, sizeof number);                                                            \
    if (big) turn(bytes + used, sizeof number);                                                              \
    used += sizeof number;                                                                                   \
  } while (0)
    PUT(uint8_t, 2);
    PUT(int16_t, -7);
    PUT(int16_t, 9);
    for (int v = 0; v < 4; v++) {
      PUT(uint8_t, 200);
      PUT(double, 431207.35 + (v == 1 || v == 2));
      PUT(double, v > 1 ? 0.7 : 0.1);
      PUT(float, 0.1f);
    }
    PUT(uint8_t, 4);
    for (uint32_t v = 0; v < 4; v++) PUT(uint32_t, v);
    PUT(int32_t, -1);
    hc_mesh mesh;
    hc_error error = {0};
    uint64_t checksum;
    ck_assert_msg(hc_mesh_file_read(write_file("b.ply", bytes, used), &mesh, &checksum, &error) == HC_OK,
                  "%s", error.text);
    ck_assert(mesh.vertex_count == 4 && mesh.triangle_count == 2);
    ck_assert(mesh.vertex[1][0] == 431208.35 && mesh.vertex[2][1] == 0.7 && mesh.vertex[3][2] == 0.1);
    hc_mesh_free(&mesh);
    ck_assert_int_eq(hc_mesh_file_read(write_file("b.ply", bytes, used - 1), &mesh, &checksum, &error),
                     HC_BAD_INPUT);
    ck_assert_ptr_nonnull(strstr(error.text, "is cut short"));
  }
}
END_TEST

/* A hollow polygon, from both sides, counted from the front and from the back, over several lines. */
START_TEST(polygons_are_cut) {
  static const char *const faces[] = {"f 1 2 3 4 5 6", "f 6/1/2 5//3 4/2 3 2 1", "f -6 -5 -4 \\\n-3 -2 -1"};
  for (int k = 0; k < 3; k++) {
    char text[512];
    snprintf(text, sizeof text,
             "\xef\xbb\xbf# an L\r\nv 0 0 0 1.0\r\nv 2 0 0\r\nv 2 1 0\r\nv 1 1 0\r\nv 1 2 0\r\nv 0 2 0\r\nvn "
             "0 0 1\r\ng l\r\n%s\r\n",
             faces[k]);
    hc_mesh mesh = read_text("l.obj", text);
    double area = 0;
    ck_assert_int_eq(mesh.triangle_count, 4);
    for (int t = 0; t < 4; t++) {
      const double *const a = mesh.vertex[mesh.triangle[t][0]], *const b = mesh.vertex[mesh.triangle[t][1]],
                          *const c = mesh.vertex[mesh.triangle[t][2]];
      const double part = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
      ck_assert(k == 1 ? part < 0 : part > 0); /* all of one sense: none lies beyond the outline */
      area += part;
    }
    ck_assert_double_eq_tol(area, k == 1 ? -3 : 3, 1e-12);
    hc_mesh_free(&mesh);
  }
}
END_TEST

/* Files as they are: upper case, spare bytes, a binary file that begins with "solid", vertices without a
 * face. */
START_TEST(odd_files_are_read) {
  char *const text = hc_alloc(1 << 16, 1);
  hc_mesh mesh = box_mesh(low, high);
  size_t length = stl_text(&mesh, text, 1 << 16);
  for (size_t k = 0; k < length; k++)
    text[k] = (char)(text[k] >= 'a' && text[k] <= 'z' ? text[k] - 32 : text[k]);
  assert_box(write_file("upper.stl", text, length));
  length = stl_binary(&mesh, text);
  memcpy(text + length, "spare", 5);
  assert_box(write_file("spare.stl", text, length + 5));
  memcpy(text, "solid box", 9);
  assert_box(write_file("solid.stl", text, length));
  assert_box(write_file("both.stl", text, length + 5));
  length = box_obj(text, 1 << 16);
  length += (size_t)sprintf(text + length, "v 1e6 -1e6 1e6\n");
  assert_box(write_file("unused.obj", text, length));
  hc_mesh_free(&mesh);
  hc_free(text);
}
END_TEST

START_TEST(mistakes_are_told_with_their_line) {
  static const char *const cases[][3] = {
      {"a.obj", "v 0 0\n", ":1: a vertex must have three numbers, not ''"},
      {"b.obj", "v 0 0 x\n", ":1: a vertex must have three numbers, not 'x'"},
      {"c.obj", "v 0 0 0\nf 1 2 3\n", ":2: a face names vertex 2, of 1 before it"},
      {"d.obj", "v 0 0 0\nv 1 0 0\nf 1 -2\n", ":3: a face must have three corners at least, not 2"},
      {"e.obj", "v 0 0 0\nf a b c\n", ":2: a corner of a face must be a vertex's number, not 'a'"},
      {"f.stl", "solid x\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n",
       ":6: a facet must have three vertices, not 2"},
      {"g.stl", "solid x\nfacet\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", ":5: is cut short"},
      {"h.stl", "solid x\nfacet\nouter loop\nvertex 0 0 0,5\n",
       ":4: a vertex must have three numbers, not '0,5'"},
      {"i.ply", "ply\nformat text 1.0\nend_header\n", ":2: format must be one of ascii"},
      {"j.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n",
       "must have the properties x, y and z"},
      {"k.ply",
       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
       "z\nend_header\n0 0\n",
       "is cut short"},
      {"l.ply", "ply\nformat ascii 1.0\nelement vertex -1\nend_header\n",
       ":3: an element must have a name and a count"},
      {"m.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty list float int vertex_indices\nend_header\n",
       ":4: a list must have a whole"},
      {"n.ply", "PLY\nend_header\n", ":1: must begin with ply"},
      {"o.ply",
       "ply\nformat ascii 1.0\nelement face 1\nproperty list char int vertex_indices\nend_header\n-3 0 1 2\n",
       "a list must have a whole number of items, not -3"},
      {"p.ply",
       "ply\nformat ascii 1.0\nelement face 1\nproperty list char int vertex_indices\nend_header\n2.5 0 1 "
       "2\n",
       "a list must have a whole number of items, not 2.5"}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
    assert_unreadable(write_file(cases[k][0], cases[k][1], strlen(cases[k][1])), cases[k][2]);
  assert_unreadable(write_file("utf16.obj", "\xff\xfev\0 \0", 6), "is it UTF-16?");
}
END_TEST

/* Frees the mesh. */
static void assert_broken(hc_mesh mesh, bool may_be_open, const char *word) {
  hc_error error = {0};
  bool turned;
  hc_mesh_weld(&mesh);
  const hc_status status = hc_mesh_check(&mesh, may_be_open, &turned, &error);
  ck_assert_msg(status == HC_BAD_INPUT, "no error '%s'", word);
  ck_assert_msg(strstr(error.text, word), "no '%s' in: %s", word, error.text);
  hc_mesh_free(&mesh);
}

START_TEST(broken_meshes_are_refused) {
  hc_mesh mesh = box_mesh(low, high);
  mesh.triangle_count--;
  assert_broken(mesh, false, "3 of its edges belong to one triangle only");
  mesh = box_mesh(low, high);
  mesh.vertex[5][1] = NAN;
  assert_broken(mesh, true, "vertex 5 has nan along y");
  mesh = box_mesh(low, high);
  mesh.triangle_count = 0;
  assert_broken(mesh, true, "must have triangles");
  mesh = box_mesh(low, high);
  memcpy(mesh.triangle[1], (int32_t[]){mesh.triangle[1][1], mesh.triangle[1][0], mesh.triangle[1][2]}, 12);
  assert_broken(mesh, true, "turned against each other");
  mesh = empty_mesh(72, 24); /* two boxes that share an edge */
  add_box(&mesh, (double[]){0, 0, 0}, (double[]){1, 1, 1});
  add_box(&mesh, (double[]){1, 1, 0}, (double[]){2, 2, 1});
  assert_broken(mesh, false, "1 of its edges belong to more than two triangles");
  mesh = box_mesh(low, high);
  memcpy(mesh.vertex[2],
         (double[]){0.5 * (mesh.vertex[0][0] + mesh.vertex[1][0]),
                    0.5 * (mesh.vertex[0][1] + mesh.vertex[1][1]),
                    0.5 * (mesh.vertex[0][2] + mesh.vertex[1][2])},
         24);
  assert_broken(mesh, true, "1 of its triangles have no area");
  mesh = empty_mesh(72, 24); /* two boxes, one inside out */
  add_box(&mesh, (double[]){0, 0, 0}, (double[]){2, 2, 2});
  add_box(&mesh, (double[]){3, 0, 0}, (double[]){4, 1, 1});
  for (int32_t t = 12; t < 24; t++) {
    const int32_t second = mesh.triangle[t][1];
    mesh.triangle[t][1] = mesh.triangle[t][2];
    mesh.triangle[t][2] = second;
  }
  assert_broken(mesh, false, "is inside out and lies in no other");
  const int many = HC_MESH_MOST_SHELLS + 1;
  mesh = empty_mesh(36 * many, 12 * many);
  for (int k = 0; k < many; k++) add_box(&mesh, (double[]){2 * k, 0, 0}, (double[]){2 * k + 1, 1, 1});
  assert_broken(mesh, false, "1001 separate shells");
}
END_TEST

START_TEST(what_is_close_is_welded) {
  hc_mesh mesh = sphere_mesh(low, 0.3, 3);
  for (int32_t v = 0; v < mesh.vertex_count; v++) /* by less than the tolerance, each otherwise */
    for (int a = 0; a < 3; a++) mesh.vertex[v][a] += 1e-8 * ((v * 7 + a) % 11 - 5);
  const int32_t triangles = mesh.triangle_count;
  hc_error error;
  bool turned;
  hc_mesh_weld(&mesh);
  ck_assert_int_eq(mesh.vertex_count, triangles / 2 + 2); /* Euler */
  ck_assert_int_eq(hc_mesh_check(&mesh, false, &turned, &error), HC_OK);
  hc_mesh_free(&mesh);
  mesh = box_mesh(low, high);
  mesh.vertex[0][0] += 1e-4; /* far more than the tolerance */
  assert_broken(mesh, false, "not closed");
}
END_TEST

START_TEST(inside_out_is_turned_and_hollows_stay) {
  for (int hollow = 0; hollow < 2; hollow++) {
    hc_mesh mesh = empty_mesh(72, 24);
    add_box(&mesh, (double[]){0, 0, 0}, (double[]){2, 2, 2});
    if (hollow) {
      add_box(&mesh, (double[]){0.5, 0.5, 0.5}, (double[]){1.5, 1.5, 1.5});
      hc_mesh inner = mesh;
      inner.triangle += 12;
      inner.triangle_count = 12;
      hc_mesh_turn_around(&inner);
    }
    hc_mesh_turn_around(&mesh);
    hc_error error = {0};
    bool turned;
    hc_mesh_weld(&mesh);
    ck_assert_msg(hc_mesh_check(&mesh, false, &turned, &error) == HC_OK, "%s", error.text);
    ck_assert(turned);
    ck_assert_double_eq_tol(hc_mesh_volume(&mesh), hollow ? 7 : 8, 1e-12);
    hc_mesh_free(&mesh);
  }
}
END_TEST

START_TEST(meshes_are_placed) {
  hc_mesh mesh = box_mesh((double[]){0, 0, 0}, (double[]){1, 2, 3});
  double found[2][3];
  hc_mesh_place(&mesh, 0.5, (double[]){0, 0, 3}, 0.25, (double[]){10, 20, 30});
  hc_mesh_bounds(&mesh, found[0], found[1]);
  const double expected[2][3] = {{9, 20, 30}, {10, 20.5, 31.5}};
  for (int k = 0; k < 6; k++) ck_assert_double_eq_tol(found[k / 3][k % 3], expected[k / 3][k % 3], 1e-12);
  hc_mesh_free(&mesh);
}
END_TEST

static const double base[3] = {0.2, -0.3, 0.7}, axis[3] = {1, -0.5, 3};

/* A cone, a tube and a cone the other way round, against their volumes. */
START_TEST(profiles_make_volumes) {
  const double pi = acos(-1.0);
  const double cone[][2] = {{0, 0}, {1, 0}, {0, 2}}, tube[][2] = {{1, 0}, {1.5, 0}, {1.5, 1}, {1, 1}, {1, 0}},
               back[][2] = {{0, 2}, {1, 0}, {1, 0}, {0, 0}};
  const struct {
    const double (*profile)[2];
    int count;
    double volume;
  } cases[] = {{cone, 3, pi * 2 / 3}, {tube, 5, pi * 1.25}, {back, 4, pi * 2 / 3}};
  for (int k = 0; k < 3; k++) {
    hc_mesh mesh;
    hc_error error = {0};
    bool turned;
    ck_assert_int_eq(
        hc_revolution_mesh(base, axis, cases[k].profile, cases[k].count, true, 0.05, &mesh, &error), HC_OK);
    ck_assert_msg(hc_mesh_check(&mesh, false, &turned, &error) == HC_OK, "%s", error.text);
    ck_assert(!turned);
    ck_assert_double_eq_tol(hc_mesh_volume(&mesh) / cases[k].volume, 1, 2e-3);
    hc_mesh_free(&mesh);
  }
}
END_TEST

static void assert_no_profile(const double (*profile)[2], int count, bool closed, const char *word) {
  hc_mesh mesh;
  hc_error error = {0};
  ck_assert_int_eq(hc_revolution_mesh(base, axis, profile, count, closed, 0.05, &mesh, &error), HC_BAD_INPUT);
  ck_assert_msg(strstr(error.text, word), "no '%s' in: %s", word, error.text);
  ck_assert_ptr_null(mesh.vertex);
}

START_TEST(profiles_that_make_nothing_are_refused) {
  const double line[][2] = {{0, 0}, {0, 1}, {0, 2}}, two[][2] = {{0, 0}, {1, 1}, {1, 1}, {0, 0}},
               across[][2] = {{0, 0}, {-1, 1}, {1, 1}}, vast[][2] = {{0, 0}, {1e15, 0}, {0, 1}};
  assert_no_profile(line, 3, true, "must leave the axis");
  assert_no_profile(two, 4, true, "at least 3 different points, and has 2");
  assert_no_profile(two, 1, false, "at least 2 different points, and has 1");
  assert_no_profile(NULL, 0, true, "at least 3");
  assert_no_profile(across, 3, true, "profile[1] must have a radius >= 0, not [-1, 1]");
  assert_no_profile(vast, 3, true, "is its unit m?");
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("mesh");
  TCase *const tests = tcase_create("mesh");
  tcase_set_timeout(tests, 120);
  tcase_add_unchecked_fixture(tests, make_folder, remove_folder);
  tcase_add_test(tests, all_kinds_are_read);
  tcase_add_test(tests, files_that_are_no_meshes_are_refused);
  tcase_add_test(tests, coordinates_are_double);
  tcase_add_test(tests, binary_plys_are_read);
  tcase_add_test(tests, polygons_are_cut);
  tcase_add_test(tests, odd_files_are_read);
  tcase_add_test(tests, mistakes_are_told_with_their_line);
  tcase_add_test(tests, broken_meshes_are_refused);
  tcase_add_test(tests, what_is_close_is_welded);
  tcase_add_test(tests, inside_out_is_turned_and_hollows_stay);
  tcase_add_test(tests, meshes_are_placed);
  tcase_add_test(tests, profiles_make_volumes);
  tcase_add_test(tests, profiles_that_make_nothing_are_refused);
  suite_add_tcase(suite, tests);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? 1 : 0;
}
