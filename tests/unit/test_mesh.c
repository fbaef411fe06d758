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
  assert_unreadable(write_file("short.stl", text, length / 2), "cannot be understood");
  assert_unreadable(write_file("noise.ply", "what is this\n", 13), "cannot be understood");
  assert_unreadable(write_file("points.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\n", 24), "");
  assert_unreadable(write_file("line.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n", 32),
                    "must have triangles");
  assert_unreadable(write_file("noise.obj", "what is this\n", 13), "");
  hc_mesh_free(&mesh);
  hc_free(text);
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
