/* What shapes weigh: against plain formulas, a published tetrahedron, each other, and far away. */
#include "meshes.h"

#include "geometry/revolution.h"
#include "geometry/solid.h"
#include "geometry/surface_sampling.h"

#include <check.h>
#include <stdlib.h>

static const double box_low[3] = {-0.4, 0.3, 1.0}, box_high[3] = {0.53, 1.5, 1.8}, odd[3] = {1, 2, -3};
static const double none[3] = {0, 0, 0}, far_away[3] = {1e6, -1e6, 1e6};

/* Takes the mesh over. */
static hc_solid solid_of(hc_mesh mesh, bool closed, bool inside_out) {
  hc_error error = {0};
  bool turned;
  hc_mesh_weld(&mesh);
  ck_assert_msg(hc_mesh_check(&mesh, !closed, &turned, &error) == HC_OK, "%s", error.text);
  ck_assert(!turned);
  if (inside_out) hc_mesh_turn_around(&mesh);
  hc_surface *const surface = hc_surface_make(&mesh, closed);
  const hc_shape shape = hc_surface_sampling_shape(surface);
  const hc_solid solid = hc_solid_of(&shape);
  hc_surface_free(surface);
  return solid;
}

static double largest(const double inertia[3][3]) {
  double most = 0;
  for (int k = 0; k < 9; k++) most = fmax(most, fabs(inertia[k / 3][k % 3]));
  return most;
}

/* Relative to the volume, the largest component of inertia, and for the centre to 1 m. */
static void assert_alike(const hc_solid *found, const hc_solid *expected, double tolerance) {
  ck_assert_double_eq_tol(found->volume, expected->volume, tolerance * fabs(expected->volume));
  for (int i = 0; i < 3; i++) {
    ck_assert_double_eq_tol(found->centre[i], expected->centre[i], tolerance);
    for (int j = 0; j < 3; j++) {
      ck_assert_double_eq_tol(found->inertia[i][j], expected->inertia[i][j],
                              tolerance * largest(expected->inertia));
      ck_assert(found->inertia[i][j] == found->inertia[j][i]);
    }
  }
}

/* With moments across and along a unit axis. */
static hc_solid round_solid(double volume, const double centre[3], double across, double along,
                            const double axis[3]) {
  hc_solid solid = {.volume = volume};
  for (int i = 0; i < 3; i++) {
    solid.centre[i] = centre[i];
    for (int j = 0; j < 3; j++)
      solid.inertia[i][j] = across * (i == j) + (along - across) * axis[i] * axis[j];
  }
  return solid;
}

/* Both together, by the parallel axis theorem; `sign` -1: one without the other. */
static hc_solid joined(const hc_solid *a, const hc_solid *b, double sign) {
  hc_solid solid = {.volume = a->volume + sign * b->volume};
  for (int i = 0; i < 3; i++)
    solid.centre[i] = (a->volume * a->centre[i] + sign * b->volume * b->centre[i]) / solid.volume;
  const hc_solid *const part[2] = {a, b};
  for (int p = 0; p < 2; p++) {
    double arm[3], square = 0;
    for (int i = 0; i < 3; i++) arm[i] = part[p]->centre[i] - solid.centre[i];
    for (int i = 0; i < 3; i++) square += arm[i] * arm[i];
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < 3; j++)
        solid.inertia[i][j] += (p ? sign : 1) * (part[p]->inertia[i][j] +
                                                 part[p]->volume * (square * (i == j) - arm[i] * arm[j]));
  }
  return solid;
}

static hc_solid box_solid(const double low[3], const double high[3]) {
  const hc_shape box = hc_shape_box(low, high, odd, 0, 0);
  return hc_solid_of(&box);
}

/* The box turned about its middle: R I R^T, by Rodrigues's formula and the mathematics library. */
static hc_solid turned_box(double turns) {
  const double angle = 2 * acos(-1.0) * turns, length = sqrt(14.0);
  const double u[3] = {odd[0] / length, odd[1] / length, odd[2] / length};
  const double across[3][3] = {{0, -u[2], u[1]}, {u[2], 0, -u[0]}, {-u[1], u[0], 0}};
  double side[3], square = 0, turn[3][3];
  hc_solid solid = {.volume = 1};
  for (int a = 0; a < 3; a++) {
    side[a] = box_high[a] - box_low[a];
    square += side[a] * side[a];
    solid.volume *= side[a];
    solid.centre[a] = 0.5 * (box_low[a] + box_high[a]);
    for (int b = 0; b < 3; b++)
      turn[a][b] = cos(angle) * (a == b) + sin(angle) * across[a][b] + (1 - cos(angle)) * u[a] * u[b];
  }
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      for (int k = 0; k < 3; k++)
        solid.inertia[i][j] += turn[i][k] * solid.volume * (square - side[k] * side[k]) / 12 * turn[j][k];
  return solid;
}

/* A mesh of the box about the origin, turned and moved to where hc_shape_box turns it. */
static hc_mesh turned_box_mesh(double turns, const double to[3]) {
  double low[3], high[3], middle[3];
  for (int a = 0; a < 3; a++) {
    high[a] = 0.5 * (box_high[a] - box_low[a]);
    low[a] = -high[a];
    middle[a] = 0.5 * (box_low[a] + box_high[a]) + to[a];
  }
  hc_mesh mesh = box_mesh(low, high);
  hc_mesh_place(&mesh, 1, odd, turns, middle);
  return mesh;
}

START_TEST(boxes_turn_their_inertia) {
  for (int k = 0; k < 5; k++) {
    const double turns = 0.137 * k;
    const hc_solid expected = turned_box(turns);
    const hc_shape box = hc_shape_box(box_low, box_high, odd, turns, 0);
    const hc_solid found = hc_solid_of(&box);
    assert_alike(&found, &expected, 1e-14);
    ck_assert(memcmp(found.centre, box.centre, sizeof box.centre) == 0);
    const hc_solid mesh = solid_of(turned_box_mesh(turns, none), true, false);
    assert_alike(&mesh, &expected, 1e-13);
  }
}
END_TEST

START_TEST(spheres_and_cylinders_agree_with_plain_formulas) {
  const double pi = acos(-1.0), centre[3] = {0.2, -0.3, 0.7}, radius = 0.6, height = 1.7;
  const double diagonal[3] = {1 / sqrt(3.0), -1 / sqrt(3.0), 1 / sqrt(3.0)};
  const hc_shape sphere = hc_shape_sphere(centre, radius);
  const double ball = 4.0 / 3 * pi * pow(radius, 3), about = 0.4 * ball * radius * radius;
  const hc_solid of_sphere = hc_solid_of(&sphere), round = round_solid(ball, centre, about, about, diagonal);
  assert_alike(&of_sphere, &round, 1e-14);
  double base[3];
  for (int a = 0; a < 3; a++) base[a] = centre[a] - 0.5 * height * diagonal[a];
  const hc_shape cylinder = hc_shape_cylinder(base, (double[]){2, -2, 2}, radius, height, 0);
  const double volume = pi * radius * radius * height, along = 0.5 * volume * radius * radius;
  const hc_solid of_cylinder = hc_solid_of(&cylinder),
                 expected = round_solid(volume, centre, 0.5 * along + volume * height * height / 12, along,
                                        diagonal);
  assert_alike(&of_cylinder, &expected, 1e-14);
}
END_TEST

/* Open faces count as faces; a component need not lie about the shape's centre. */
START_TEST(open_shapes_and_layers_have_all_their_faces) {
  const hc_shape closed = hc_shape_box(box_low, box_high, odd, 0.1, 0),
                 open = hc_shape_box(box_low, box_high, odd, 0.1, 0x21);
  const hc_solid all = hc_solid_of(&closed), some = hc_solid_of(&open);
  assert_alike(&some, &all, 1e-15);
  const hc_shape tube = hc_shape_cylinder(none, (double[]){0, 0, 3}, 1, 2, 2),
                 around = hc_shape_layer(&tube, 1, false, 0),
                 larger = hc_shape_cylinder((double[]){0, 0, -0.5}, (double[]){0, 0, 3}, 1.5, 2.5, 2);
  const hc_solid layer = hc_solid_of(&around), expected = hc_solid_of(&larger);
  assert_alike(&layer, &expected, 1e-14);
}
END_TEST

/* The example of Tonon 2004, "Explicit exact formulas for the 3-D tetrahedron inertia tensor in terms of its
 * vertex coordinates". */
START_TEST(a_published_tetrahedron_is_met) {
  static const double corner[4][3] = {{8.33220, -11.86875, 0.93355},
                                      {0.75523, 5.00000, 16.37072},
                                      {52.61236, 5.00000, -5.38580},
                                      {2.00000, 5.00000, 3.00000}};
  static const int face[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  hc_mesh mesh = hc_mesh_make(4, 4);
  for (int k = 0; k < 4; k++) {
    memcpy(mesh.vertex[k], corner[k], sizeof corner[k]);
    for (int c = 0; c < 3; c++) mesh.triangle[k][c] = face[k][c];
  }
  if (hc_mesh_volume(&mesh) < 0) hc_mesh_turn_around(&mesh);
  const hc_solid found = solid_of(mesh, true, false);
  const double centre[3] = {15.92492, 0.78281, 3.72962},
               inertia[3][3] = {{43520.33257, -11996.20119, 46343.16662},
                                {-11996.20119, 194711.28938, -4417.66150},
                                {46343.16662, -4417.66150, 191168.76173}};
  for (int k = 0; k < 9; k++) {
    ck_assert_double_eq_tol(found.centre[k % 3], centre[k % 3], 1e-4);
    ck_assert_double_eq_tol(found.inertia[k / 3][k % 3], inertia[k / 3][k % 3], 0.05);
  }
}
END_TEST

/* The middle of its box is not the centre of an L; one box lies off another's axes. */
START_TEST(parts_join_by_parallel_axes) {
  const hc_solid foot = box_solid((double[]){0, 0, 0}, (double[]){2, 1, 1}),
                 leg = box_solid((double[]){0, 0, 1}, (double[]){1, 1, 2}), l = joined(&foot, &leg, 1),
                 of_mesh = solid_of(l_mesh(1), true, false);
  assert_alike(&of_mesh, &l, 1e-14);
  const double low[2][3] = {{0, 0, 0}, {3, -2, 5}}, high[2][3] = {{1, 1, 1}, {5, 0, 7}};
  const hc_solid cube = box_solid(low[0], high[0]), other = box_solid(low[1], high[1]),
                 both = joined(&cube, &other, 1);
  hc_mesh mesh = empty_mesh(72, 24);
  for (int k = 0; k < 2; k++) add_box(&mesh, low[k], high[k]);
  const hc_solid cubes = solid_of(mesh, true, false);
  assert_alike(&cubes, &both, 1e-14);
  ck_assert(fabs(cubes.inertia[0][1]) > 1 && fabs(cubes.inertia[0][2]) > 1 && fabs(cubes.inertia[1][2]) > 1);
}
END_TEST

START_TEST(hollows_are_left_out) {
  const double low[2][3] = {{0, 0, 0}, {0.5, 0.25, 1}}, high[2][3] = {{2, 2, 2}, {1, 1.5, 1.75}};
  const hc_solid outer = box_solid(low[0], high[0]), inner = box_solid(low[1], high[1]),
                 expected = joined(&outer, &inner, -1);
  hc_mesh mesh = empty_mesh(72, 24);
  for (int k = 0; k < 2; k++) add_box(&mesh, low[k], high[k]);
  hc_mesh hollow = mesh;
  hollow.triangle += 12;
  hollow.triangle_count = 12;
  hc_mesh_turn_around(&hollow);
  const hc_solid found = solid_of(mesh, true, false);
  assert_alike(&found, &expected, 1e-14);
}
END_TEST

/* A profile of a half circle from pole to pole, or an icosahedron cut ever finer: corners on the sphere. */
static hc_mesh ball_mesh(bool turned_profile, const double centre[3], double radius, int cuts) {
  if (!turned_profile) return sphere_mesh(centre, radius, cuts);
  const int count = (8 << cuts) + 1;
  double profile[129][2];
  for (int k = 0; k < count; k++) {
    const double angle = acos(-1.0) * k / (count - 1);
    profile[k][0] = k == 0 || k == count - 1 ? 0 : radius * sin(angle);
    profile[k][1] = radius * (1 - cos(angle));
  }
  const double axis[3] = {odd[0] / sqrt(14.0), odd[1] / sqrt(14.0), odd[2] / sqrt(14.0)};
  double pole[3];
  for (int a = 0; a < 3; a++) pole[a] = centre[a] - radius * axis[a];
  hc_mesh mesh;
  hc_error error = {0};
  const double spacing = radius * pow(0.25, cuts); /* half the length of faces each time */
  ck_assert_msg(hc_revolution_mesh(pole, axis, (const double(*)[2])profile, count, true, spacing, &mesh,
                                   &error) == HC_OK,
                "%s", error.text);
  return mesh;
}

START_TEST(meshes_of_a_sphere_converge) {
  const double centre[3] = {0.2, -0.3, 0.7}, radius = 0.6;
  const hc_shape sphere = hc_shape_sphere(centre, radius);
  const hc_solid expected = hc_solid_of(&sphere);
  for (int turned = 0; turned < 2; turned++) {
    double before = 0;
    for (int cuts = 2; cuts < 5; cuts++) {
      const hc_solid found = solid_of(ball_mesh(turned, centre, radius, cuts), true, false);
      const double missing = 1 - found.inertia[2][2] / expected.inertia[2][2];
      ck_assert(missing > 0);
      if (cuts > 2) ck_assert_msg(before / missing > 3.5, "%g after %g", missing, before);
      if (cuts == 4) assert_alike(&found, &expected, 1e-2);
      before = missing;
      for (int a = 0; a < 3; a++) ck_assert_double_eq_tol(found.centre[a], centre[a], 1e-13);
    }
  }
}
END_TEST

/* Corners that are integers have all their digits there; others are rounded to 1e-10 m. */
START_TEST(far_away_keeps_digits) {
  hc_solid expected = solid_of(l_mesh(1), true, false);
  hc_mesh mesh = l_mesh(1);
  hc_mesh_place(&mesh, 1, odd, 0, far_away);
  const hc_solid l = solid_of(mesh, true, false);
  for (int a = 0; a < 3; a++) expected.centre[a] += far_away[a];
  ck_assert_double_eq_tol(l.volume, 3, 1e-14);
  for (int k = 0; k < 9; k++)
    ck_assert_double_eq_tol(l.inertia[k / 3][k % 3], expected.inertia[k / 3][k % 3], 1e-14);
  for (int a = 0; a < 3; a++) ck_assert_double_eq_tol(l.centre[a], expected.centre[a], 1e-9);
  expected = turned_box(0.137);
  double low[3], high[3];
  for (int a = 0; a < 3; a++) {
    low[a] = box_low[a] + far_away[a];
    high[a] = box_high[a] + far_away[a];
    expected.centre[a] += far_away[a];
  }
  const hc_shape box = hc_shape_box(low, high, odd, 0.137, 0);
  const hc_solid of_box = hc_solid_of(&box),
                 of_mesh = solid_of(turned_box_mesh(0.137, far_away), true, false);
  assert_alike(&of_box, &expected, 1e-9);
  assert_alike(&of_mesh, &expected, 1e-9);
}
END_TEST

/* What the sums give: no more is promised. */
START_TEST(inside_out_is_negative_and_flat_is_nothing) {
  const hc_solid l = solid_of(l_mesh(1), true, false), turned = solid_of(l_mesh(1), true, true);
  hc_solid expected = l;
  expected.volume = -l.volume;
  for (int k = 0; k < 9; k++) expected.inertia[k / 3][k % 3] = -l.inertia[k / 3][k % 3];
  assert_alike(&turned, &expected, 1e-14);
  hc_mesh square = empty_mesh(6, 2);
  add_face(&square, (const double[4][3]){{0, 0, 3}, {2, 0, 3}, {2, 4, 3}, {0, 4, 3}});
  const hc_shape rectangle = hc_shape_rectangle((double[]){1, 2, 3}, (double[]){0, 0, 1}, (double[]){2, 4});
  const hc_solid flat[2] = {solid_of(square, false, false), hc_solid_of(&rectangle)};
  for (int k = 0; k < 2; k++) {
    ck_assert(flat[k].volume == 0 && largest(flat[k].inertia) == 0);
    for (int a = 0; a < 3; a++) ck_assert(flat[k].centre[a] == 1 + a);
  }
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("solid");
  TCase *const tests = tcase_create("solid");
  tcase_set_timeout(tests, 60);
  tcase_add_test(tests, boxes_turn_their_inertia);
  tcase_add_test(tests, spheres_and_cylinders_agree_with_plain_formulas);
  tcase_add_test(tests, open_shapes_and_layers_have_all_their_faces);
  tcase_add_test(tests, a_published_tetrahedron_is_met);
  tcase_add_test(tests, parts_join_by_parallel_axes);
  tcase_add_test(tests, hollows_are_left_out);
  tcase_add_test(tests, meshes_of_a_sphere_converge);
  tcase_add_test(tests, far_away_keeps_digits);
  tcase_add_test(tests, inside_out_is_negative_and_flat_is_nothing);
  suite_add_tcase(suite, tests);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
