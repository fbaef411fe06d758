/* Shapes and their samplings: distances against other formulas, surfaces without gaps, doubles or crowds. */
#include "base/memory.h"
#include "base/turns.h"
#include "geometry/round.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>

#define DX 0.1 /* m */

/* 1000 units of 0.0001 m to the spacing; the origin is away from 0 and not a multiple. */
static const hc_lattice lattice = {{1e-4, 1e-4, 1e-4}, {123456789, -987654321, 7}, {1000, 1000, 1000}};

typedef struct point {
  double x[3];
} point;

typedef struct points {
  point *at;
  int64_t count;
} points;

static points all_points(const hc_sampling *sampling) {
  points set = {hc_alloc((size_t)hc_sampling_count(sampling), sizeof(point)), hc_sampling_count(sampling)};
  for (int64_t k = 0; k < set.count; k++) {
    int64_t units[3];
    hc_sampling_point(sampling, k, units);
    for (int a = 0; a < 3; a++) set.at[k].x[a] = 1e-4 * (double)(units[a] - lattice.origin[a]);
  }
  return set;
}

static double separation(const double a[3], const double b[3]) {
  return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

/* Distance to the nearest of the points, `self` aside. */
static double nearest(const points *set, const double x[3], int64_t self) {
  double least = INFINITY;
  for (int64_t k = 0; k < set->count; k++)
    if (k != self) least = fmin(least, separation(set->at[k].x, x));
  return least;
}

static double random_in(double low, double high) {
  static uint64_t state = 88172645463325252u;
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return low + (high - low) * (double)(state >> 11) / 9007199254740992.0;
}

static const double box_min[3] = {-0.4, 0.3, 1.0}, box_max[3] = {0.53, 1.0, 1.8}, diagonal[3] = {1, 2, -2};
static const double base[3] = {0.2, -0.3, 0.7}, upright[3] = {0, 0, 2}, slanted[3] = {1, -0.5, 3};

START_TEST(turns_agree_with_the_library) {
  for (int k = -1000; k <= 1000; k++) {
    const double t = 0.00371 * k, angle = 2 * acos(-1.0) * t;
    ck_assert_double_eq_tol(hc_turns_sine(t), sin(angle), 1e-14);
    ck_assert_double_eq_tol(hc_turns_cosine(t), cos(angle), 1e-14);
  }
}
END_TEST

START_TEST(distances_agree_with_plain_formulas) {
  const hc_shape sphere = hc_shape_sphere(base, 0.5);
  const hc_shape cylinder = hc_shape_cylinder(base, slanted, 0.4, 1.5, 0);
  const hc_shape box = hc_shape_box(box_min, box_max, diagonal, 0, 0);
  const double length = sqrt(1 + 0.25 + 9), unit[3] = {1 / length, -0.5 / length, 3 / length};
  for (int k = 0; k < 20000; k++) {
    const double x[3] = {random_in(-2, 3), random_in(-2, 3), random_in(-2, 3)};
    ck_assert_double_eq_tol(hc_shape_distance(&sphere, x), separation(x, base) - 0.5, 1e-12);
    ck_assert_double_eq_tol(hc_shape_surface_distance(&sphere, x), fabs(separation(x, base) - 0.5), 1e-12);
    double height = 0, square = 0;
    for (int a = 0; a < 3; a++) height += unit[a] * (x[a] - base[a]);
    for (int a = 0; a < 3; a++) square += pow(x[a] - base[a] - height * unit[a], 2);
    const double out = sqrt(square) - 0.4, above = fmax(height - 1.5, -height);
    const double expected = out > 0 && above > 0 ? sqrt(out * out + above * above) : fmax(out, above);
    ck_assert_double_eq_tol(hc_shape_distance(&cylinder, x), expected, 1e-12);
    double inside = INFINITY, outside = 0;
    for (int a = 0; a < 3; a++) {
      const double beyond = fmax(box_min[a] - x[a], x[a] - box_max[a]);
      inside = fmin(inside, -beyond);
      if (beyond > 0) outside += beyond * beyond;
    }
    const double to_box = outside > 0 ? sqrt(outside) : -inside;
    ck_assert_double_eq_tol(hc_shape_distance(&box, x), to_box, 1e-12);
    ck_assert_double_eq_tol(hc_shape_surface_distance(&box, x), fabs(to_box), 1e-12);
  }
}
END_TEST

START_TEST(open_faces_let_the_region_go_on) {
  const double inside[3] = {0, 0.9, 1.5}, above[3] = {0, 0.9, 9}, beside[3] = {9, 0.9, 1.5};
  const hc_shape tank = hc_shape_box(box_min, box_max, diagonal, 0, 1u << 5);
  ck_assert_double_lt(hc_shape_region_distance(&tank, inside), 0);
  ck_assert_double_lt(hc_shape_region_distance(&tank, above), 0);
  ck_assert_double_eq_tol(hc_shape_region_distance(&tank, beside), 9 - 0.53, 1e-12);
  ck_assert_double_eq_tol(hc_shape_distance(&tank, above), 9 - 1.8, 1e-12);
  ck_assert_double_eq_tol(hc_shape_surface_distance(&tank, above), sqrt(7.2 * 7.2 + 0.1 * 0.1), 1e-12);
  const hc_shape cup = hc_shape_cylinder(base, upright, 0.5, 1, 2);
  const double over[3] = {0.2, -0.3, 40}, under[3] = {0.2, -0.3, 0.6};
  ck_assert_double_lt(hc_shape_region_distance(&cup, over), 0);
  ck_assert_double_eq_tol(hc_shape_region_distance(&cup, under), 0.1, 1e-12);
  const double size[2] = {1, 1}, at[3] = {0, 0, 0};
  const hc_shape floor = hc_shape_rectangle(at, upright, size);
  ck_assert_double_lt(hc_shape_region_distance(&floor, above), 0);
  ck_assert_double_eq_tol(hc_shape_region_distance(&floor, (const double[3]){5, 5, -2}), 2, 1e-12);
  ck_assert_double_eq_tol(hc_shape_surface_distance(&floor, (const double[3]){3.5, 0, 4}), 5, 1e-12);
  double normal[3];
  hc_shape_face_normal(&cup, 3, normal);
  ck_assert_double_eq_tol(normal[2], 1, 1e-15);
  hc_shape_face_normal(&tank, 0, normal);
  ck_assert_double_eq_tol(normal[0], -1, 1e-15);
}
END_TEST

START_TEST(boxes_turn_right_handed_about_their_middle) {
  const double min[3] = {0, 0, 0}, max[3] = {4, 2, 2};
  const hc_shape box = hc_shape_box(min, max, upright, 0.125, 0);
  const double along[3] = {2 + 1.9 * sqrt(0.5), 1 + 1.9 * sqrt(0.5), 1};
  const double across[3] = {2 + 1.9 * sqrt(0.5), 1 - 1.9 * sqrt(0.5), 1};
  ck_assert_double_eq_tol(hc_shape_distance(&box, along), -0.1, 1e-12);
  ck_assert_double_eq_tol(hc_shape_distance(&box, across), 0.9, 1e-12);
  double low[3], high[3];
  hc_shape_bounds(&box, low, high);
  ck_assert_double_eq_tol(high[0], 2 + 3 * sqrt(0.5), 1e-12);
  ck_assert_double_eq_tol(low[1], 1 - 3 * sqrt(0.5), 1e-12);
  ck_assert_double_eq_tol(high[2], 2, 1e-12);
  ck_assert_double_eq_tol(hc_shape_reach(&box), sqrt(6), 1e-12);
  const hc_shape cylinder = hc_shape_cylinder(base, slanted, 0.4, 1.5, 0);
  hc_shape_bounds(&cylinder, low, high);
  const double tilt = sqrt(1 - 9 / 10.25);
  ck_assert_double_eq_tol(high[2] - low[2], 1.5 * 3 / sqrt(10.25) + 2 * 0.4 * tilt, 1e-12);
}
END_TEST

/* What the tracing of rows relies on. */
START_TEST(distances_change_no_faster_than_points_move) {
  const hc_shape shapes[] = {hc_shape_box(box_min, box_max, diagonal, 0.07, 9),
                             hc_shape_cylinder(base, slanted, 0.4, 1.5, 2), hc_shape_sphere(base, 0.5)};
  double (*const functions[])(const hc_shape *, const double[3]) = {
      hc_shape_distance, hc_shape_region_distance, hc_shape_surface_distance};
  for (int k = 0; k < 30000; k++) {
    const double x[3] = {random_in(-1, 2), random_in(-1, 2), random_in(-1, 2)};
    const double y[3] = {x[0] + random_in(-0.3, 0.3), x[1] + random_in(-0.3, 0.3),
                         x[2] + random_in(-0.3, 0.3)};
    const hc_shape *const shape = &shapes[k % 3];
    const double change = functions[k / 3 % 3](shape, x) - functions[k / 3 % 3](shape, y);
    ck_assert_double_le(fabs(change), separation(x, y) + 1e-12);
  }
}
END_TEST

typedef struct wall {
  hc_shape shape;
  bool solid;
  double area; /* of the layer, m2 */
} wall;

static double cylinder_area(double radius, double length, int ends) {
  return 2 * acos(-1.0) * radius * length + ends * acos(-1.0) * radius * radius;
}

static int make_walls(wall walls[12]) {
  const double pi = acos(-1.0);
  int n = 0;
  walls[n++] = (wall){hc_shape_cylinder(base, upright, 0.6, 1.0, 0), false, cylinder_area(0.65, 1.1, 2)};
  walls[n++] = (wall){hc_shape_cylinder(base, slanted, 0.73, 1.04, 2), false, cylinder_area(0.78, 1.09, 1)};
  walls[n++] = (wall){hc_shape_cylinder(base, slanted, 0.4, 2.0, 3), false, cylinder_area(0.45, 2.0, 0)};
  walls[n++] = (wall){hc_shape_cylinder(base, upright, 0.37, 0.85, 0), true, cylinder_area(0.32, 0.75, 2)};
  walls[n++] = (wall){hc_shape_cylinder(base, slanted, 0.52, 0.9, 1), true, cylinder_area(0.47, 0.8, 1)};
  walls[n++] = (wall){hc_shape_cylinder(base, slanted, 0.6, 0.12, 0), true, pi * 0.55 * 0.55};
  walls[n++] = (wall){hc_shape_sphere(base, 0.7), false, 4 * pi * 0.75 * 0.75};
  walls[n++] = (wall){hc_shape_sphere(base, 0.43), true, 4 * pi * 0.38 * 0.38};
  walls[n++] = (wall){hc_shape_box(box_min, box_max, diagonal, 0.1, 0), false,
                      2 * (1.03 * 0.8 + 1.03 * 0.9 + 0.8 * 0.9)};
  walls[n++] = (wall){hc_shape_box(box_min, box_max, diagonal, -0.31, 0), true,
                      2 * (0.83 * 0.6 + 0.83 * 0.7 + 0.6 * 0.7)};
  return n;
}

START_TEST(walls_are_one_even_layer) {
  wall walls[12];
  const int count = make_walls(walls);
  for (int w = 0; w < count; w++) {
    hc_sampling sampling = hc_round_wall(&lattice, &walls[w].shape, walls[w].solid, 1);
    const hc_shape layer = hc_shape_layer(&walls[w].shape, DX, walls[w].solid, 0);
    const points set = all_points(&sampling);
    ck_assert_msg(fabs((double)set.count * DX * DX / walls[w].area - 1) < 0.12, "wall %d: %lld on %g m2", w,
                  (long long)set.count, walls[w].area);
    for (int64_t k = 0; k < set.count; k++) {
      ck_assert_double_le(hc_shape_surface_distance(&layer, set.at[k].x), 3e-4);
      const double off = hc_shape_distance(&walls[w].shape, set.at[k].x) * (walls[w].solid ? -1 : 1);
      ck_assert_msg(off > 0.49 * DX && off < 0.87 * DX, "wall %d, sample %lld: %g m off", w, (long long)k,
                    off); /* farther only past the edges of a container */
      const double gap = nearest(&set, set.at[k].x, k) / DX;
      ck_assert_msg(gap > 0.7 && gap < 1.3, "wall %d, sample %lld: %g spacings", w, (long long)k, gap);
    }
    hc_free(set.at);
    hc_sampling_free(&sampling);
  }
}
END_TEST

/* Points thrown on the surface: none is far from all samples. */
START_TEST(walls_have_no_gaps) {
  wall walls[12];
  const int count = make_walls(walls);
  for (int w = 0; w < count; w++) {
    hc_sampling sampling = hc_round_wall(&lattice, &walls[w].shape, walls[w].solid, 1);
    const hc_shape layer = hc_shape_layer(&walls[w].shape, DX, walls[w].solid, 0);
    const points set = all_points(&sampling);
    const double reach = hc_shape_reach(&layer), *const c = layer.centre;
    int hits = 0;
    for (int k = 0; k < 100000; k++) {
      const double x[3] = {c[0] + random_in(-reach, reach), c[1] + random_in(-reach, reach),
                           c[2] + random_in(-reach, reach)};
      if (hc_shape_surface_distance(&layer, x) > 0.02 * DX) continue;
      hits++;
      const double gap = nearest(&set, x, -1) / DX;
      ck_assert_msg(gap < 0.75, "wall %d: no sample within %g spacings of (%g, %g, %g)", w, gap, x[0], x[1],
                    x[2]);
    }
    ck_assert_int_gt(hits, 100);
    hc_free(set.at);
    hc_sampling_free(&sampling);
  }
}
END_TEST

START_TEST(open_ends_are_open) {
  for (unsigned open = 0; open < 4; open++)
    for (int solid = 0; solid < 2; solid++) {
      const hc_shape cylinder = hc_shape_cylinder(base, upright, 0.6, 1.0, open);
      hc_sampling sampling = hc_round_wall(&lattice, &cylinder, solid, 1);
      const points set = all_points(&sampling);
      int64_t middles[2] = {0, 0}, beyond[2] = {0, 0}, rims[2] = {0, 0};
      for (int64_t k = 0; k < set.count; k++) {
        const double *const x = set.at[k].x;
        const int top = x[2] > 1.2;
        const double radius = hypot(x[0] - 0.2, x[1] + 0.3);
        middles[top] += radius < 0.3;
        beyond[top] += x[2] < 0.7 - 1e-3 || x[2] > 1.7 + 1e-3;
        rims[top] += radius > 0.54 && (x[2] < 0.76 || x[2] > 1.64);
      }
      for (int top = 0; top < 2; top++) {
        const bool closed = !(open >> top & 1);
        ck_assert_int_eq(middles[top] > 0, closed);
        ck_assert_int_eq(beyond[top] > 0, closed && !solid);
        ck_assert_int_gt(rims[top], 30);
      }
      hc_free(set.at);
      hc_sampling_free(&sampling);
    }
}
END_TEST

START_TEST(thin_solids_are_lines_and_points) {
  const hc_shape bead = hc_shape_sphere(base, 0.05), rod = hc_shape_cylinder(base, slanted, 0.05, 1.0, 0);
  hc_sampling sampling = hc_round_wall(&lattice, &bead, true, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), 1);
  hc_sampling_free(&sampling);
  sampling = hc_round_wall(&lattice, &rod, true, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), 10);
  const points set = all_points(&sampling);
  for (int64_t k = 1; k < 10; k++)
    ck_assert_double_eq_tol(separation(set.at[k].x, set.at[k - 1].x), DX, 3e-4);
  hc_free(set.at);
  hc_sampling_free(&sampling);
}
END_TEST

/* Lattice points half a spacing inside, all of them: against all indices around the middle. */
START_TEST(fills_are_all_lattice_points_inside) {
  const hc_shape shapes[] = {hc_shape_sphere(base, 0.55),
                             hc_shape_sphere(base, 0.05),
                             hc_shape_sphere(base, 0.049),
                             hc_shape_cylinder(base, upright, 0.45, 0.7, 0),
                             hc_shape_cylinder(base, slanted, 0.37, 0.69, 0),
                             hc_shape_cylinder(base, slanted, 0.05, 0.1, 0),
                             hc_shape_cylinder(base, slanted, 1, 0.09, 0),
                             hc_shape_box(box_min, box_max, diagonal, 0.2, 0)};
  for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
    const hc_shape *const shape = &shapes[s];
    hc_sampling sampling = hc_round_fill(&lattice, shape);
    const points set = all_points(&sampling);
    int64_t expected = 0;
    const int layers = (int)((shape->high[1] - shape->low[1]) / DX + 1e-6);
    for (int k = -12; k <= 12; k++)
      for (int j = -12; j <= 12; j++)
        for (int i = -12; i <= 12; i++) {
          const int z = shape->round == 3 ? k : 0;
          expected += (shape->round == 3 || (k >= 0 && k < layers)) &&
                      sqrt(i * i + j * j + z * z) * DX <= shape->high[0] - 0.5 * DX + 1e-6;
        }
    if (shape->round == 1) expected = 9 * 7 * 8;
    ck_assert_msg(set.count == expected, "shape %zu: %lld of %lld", s, (long long)set.count,
                  (long long)expected);
    for (int64_t k = 0; k < set.count; k++) {
      ck_assert_double_le(hc_shape_distance(shape, set.at[k].x), -0.5 * DX + 3e-4);
      if (set.count > 1) ck_assert_double_eq_tol(nearest(&set, set.at[k].x, k), DX, 3e-4);
    }
    hc_free(set.at);
    hc_sampling_free(&sampling);
  }
}
END_TEST

/* Fluid in a container of the same shape starts a spacing from the samples. */
START_TEST(fluid_fits_its_container) {
  const hc_shape shape = hc_shape_cylinder(base, slanted, 0.55, 1.2, 0);
  hc_sampling fluid = hc_round_fill(&lattice, &shape), around = hc_round_wall(&lattice, &shape, false, 1);
  const points inner = all_points(&fluid), outer = all_points(&around);
  double least = INFINITY;
  for (int64_t k = 0; k < inner.count; k++) least = fmin(least, nearest(&outer, inner.at[k].x, -1));
  ck_assert_double_ge(least, 0.995 * DX);
  ck_assert_double_le(least, 1.05 * DX);
  hc_free(inner.at);
  hc_free(outer.at);
  hc_sampling_free(&fluid);
  hc_sampling_free(&around);
}
END_TEST

/* Rows end where they must, steps in them are short, bounds hold all, an origin shifts all. */
START_TEST(rows_bounds_and_origins) {
  wall walls[12];
  const int count = make_walls(walls);
  hc_lattice moved = lattice;
  moved.origin[1] += INT64_C(1) << 52;
  for (int w = 0; w < 2 * count; w++) {
    const hc_shape *const shape = &walls[w / 2].shape;
    const bool solid = walls[w / 2].solid;
    hc_sampling here = w % 2 ? hc_round_fill(&lattice, shape) : hc_round_wall(&lattice, shape, solid, 1);
    hc_sampling there = w % 2 ? hc_round_fill(&moved, shape) : hc_round_wall(&moved, shape, solid, 1);
    const points set = all_points(&here);
    int64_t low[3], high[3], rows = 0;
    hc_sampling_bounds(&here, low, high);
    for (int64_t k = 0; k < set.count; rows++) {
      const int64_t end = hc_sampling_row_end(&here, k);
      ck_assert(end > k && end <= set.count);
      for (; k + 1 < end; k++) ck_assert_double_le(separation(set.at[k].x, set.at[k + 1].x), 1.5 * DX + 3e-4);
      ck_assert_int_eq(hc_sampling_row_end(&here, k), end);
      k = end;
    }
    ck_assert_int_le(rows, set.count / 2);
    for (int64_t k = 0; k < set.count; k++) {
      int64_t x[3], y[3];
      hc_sampling_point(&here, k, x);
      hc_sampling_point(&there, k, y);
      for (int a = 0; a < 3; a++) {
        ck_assert(x[a] >= low[a] && x[a] <= high[a]);
        ck_assert_int_eq(y[a] - x[a], a == 1 ? INT64_C(1) << 52 : 0);
      }
    }
    hc_free(set.at);
    hc_sampling_free(&here);
    hc_sampling_free(&there);
  }
}
END_TEST

START_TEST(huge_shapes_are_counted_or_refused) {
  const hc_shape pipe = hc_shape_cylinder(base, upright, 0.5, 1e6, 3);
  hc_sampling sampling = hc_round_wall(&lattice, &pipe, false, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), INT64_C(10000000) * 35);
  hc_sampling_free(&sampling);
  sampling = hc_round_fill(&lattice, &pipe);
  ck_assert_int_eq(hc_sampling_count(&sampling), INT64_C(10000000) * 69);
  hc_sampling_free(&sampling);
  for (double radius = 1e7; radius < 1e13; radius *= 1e5) {
    const hc_shape ball = hc_shape_sphere(base, radius);
    const hc_shape drum = hc_shape_cylinder(base, upright, radius, radius, 0);
    const hc_shape *const shapes[2] = {&ball, &drum};
    for (int s = 0; s < 4; s++) {
      sampling =
          s % 2 ? hc_round_wall(&lattice, shapes[s / 2], false, 1) : hc_round_fill(&lattice, shapes[s / 2]);
      ck_assert_int_eq(hc_sampling_count(&sampling), INT64_MAX);
      hc_sampling_free(&sampling);
    }
  }
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("shapes");
  TCase *const cases = tcase_create("shapes and their samplings");
  tcase_set_timeout(cases, 120);
  tcase_add_test(cases, turns_agree_with_the_library);
  tcase_add_test(cases, distances_agree_with_plain_formulas);
  tcase_add_test(cases, open_faces_let_the_region_go_on);
  tcase_add_test(cases, boxes_turn_right_handed_about_their_middle);
  tcase_add_test(cases, distances_change_no_faster_than_points_move);
  tcase_add_test(cases, walls_are_one_even_layer);
  tcase_add_test(cases, walls_have_no_gaps);
  tcase_add_test(cases, open_ends_are_open);
  tcase_add_test(cases, thin_solids_are_lines_and_points);
  tcase_add_test(cases, fills_are_all_lattice_points_inside);
  tcase_add_test(cases, fluid_fits_its_container);
  tcase_add_test(cases, rows_bounds_and_origins);
  tcase_add_test(cases, huge_shapes_are_counted_or_refused);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
