/* Samplings against brute force: nothing missing, nothing double, everything in its place. */
#include "base/memory.h"
#include "geometry/sampling.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct point {
  int64_t x[3];
} point;

typedef struct points {
  point *at;
  int64_t count;
} points;

#define DX INT64_C(1000)

/* 1000 units of 0.0001 m to the spacing, so dx = 0.1 m; the origin is away from 0 and not a multiple. */
static const hc_lattice lattice = {{1e-4, 1e-4, 1e-4}, {123456789, -987654321, 7}, {DX, DX, DX}};

static int compare(const void *a, const void *b) {
  const point *const p = a, *const q = b;
  for (int i = 2; i >= 0; i--)
    if (p->x[i] != q->x[i]) return p->x[i] < q->x[i] ? -1 : 1;
  return 0;
}

static void sort(points *set) {
  qsort(set->at, (size_t)set->count, sizeof *set->at, compare);
}

static points empty(int64_t room) {
  return (points){hc_alloc((size_t)room, sizeof(point)), 0};
}

/* All points in order of their index. */
static points all_points(const hc_sampling *sampling) {
  points set = empty(hc_sampling_count(sampling));
  for (; set.count < hc_sampling_count(sampling); set.count++)
    hc_sampling_point(sampling, set.count, set.at[set.count].x);
  return set;
}

static void assert_no_doubles(const points *sorted) {
  for (int64_t k = 1; k < sorted->count; k++)
    ck_assert_msg(compare(&sorted->at[k - 1], &sorted->at[k]) != 0, "point %lld comes twice", (long long)k);
}

static void assert_same(const points *a, const points *b) {
  ck_assert_int_eq(a->count, b->count);
  for (int64_t k = 0; k < a->count; k++)
    for (int i = 0; i < 3; i++) ck_assert_int_eq(a->at[k].x[i], b->at[k].x[i]);
}

/* A sampling must be the set `expected` (which is sorted and freed). */
static void assert_is(const hc_sampling *sampling, points *expected) {
  points got = all_points(sampling);
  sort(&got);
  sort(expected);
  assert_no_doubles(&got);
  assert_same(&got, expected);
  hc_free(got.at);
  hc_free(expected->at);
}

/* Lattice points half a spacing off the corner `min` (in spacings) whose indices satisfy `wanted`. */
typedef bool (*choice)(const int64_t i[3], const int64_t n[3], unsigned open);

static points brute_force(const double min[3], const int64_t n[3], unsigned open, choice wanted) {
  points set = empty((n[0] + 2) * (n[1] + 2) * (n[2] + 2));
  int64_t i[3];
  for (i[0] = -1; i[0] <= n[0]; i[0]++)
    for (i[1] = -1; i[1] <= n[1]; i[1]++)
      for (i[2] = -1; i[2] <= n[2]; i[2]++) {
        if (!wanted(i, n, open)) continue;
        for (int a = 0; a < 3; a++)
          set.at[set.count].x[a] = lattice.origin[a] + llrint(min[a] / 1e-4) + DX / 2 + i[a] * DX;
        set.count++;
      }
  return set;
}

static bool within(const int64_t i[3], const int64_t n[3], unsigned open) {
  (void)open;
  for (int a = 0; a < 3; a++)
    if (i[a] < 0 || i[a] >= n[a]) return false;
  return true;
}

static bool around(const int64_t i[3], const int64_t n[3], unsigned open) {
  bool on_face = false;
  for (int a = 0; a < 3; a++) {
    const bool low = i[a] == -1, high = i[a] == n[a];
    if ((low && (open >> (2 * a) & 1)) || (high && (open >> (2 * a + 1) & 1))) return false;
    on_face |= low || high;
  }
  return on_face;
}

static bool skin(const int64_t i[3], const int64_t n[3], unsigned open) {
  if (!within(i, n, 0)) return false;
  for (int a = 0; a < 3; a++) {
    if (i[a] == 0 && !(open >> (2 * a) & 1)) return true;
    if (i[a] == n[a] - 1 && !(open >> (2 * a + 1) & 1)) return true;
  }
  return false;
}

static const double corner[3] = {-0.3, 0.7, 1.2345};

static void max_of(const int64_t n[3], double max[3]) {
  for (int a = 0; a < 3; a++) max[a] = corner[a] + 0.1 * (double)n[a];
}

START_TEST(block_is_the_lattice_in_the_box) {
  const int64_t n[3] = {5, 3, 7};
  double max[3];
  max_of(n, max);
  const hc_sampling sampling = hc_sampling_block(&lattice, corner, max);
  ck_assert_int_eq(hc_sampling_count(&sampling), 5 * 3 * 7);
  points expected = brute_force(corner, n, 0, within);
  assert_is(&sampling, &expected);
}
END_TEST

START_TEST(block_counts_whole_spacings_only) {
  const double min[3] = {0, 0, 0};
  const struct {
    double length;
    int64_t n;
  } cases[] = {{0.3, 3}, {0.3999, 3}, {0.29999, 2}, {0.29999999, 3}, {0.099, 0}, {0.1, 1}, {0, 0}, {-1, 0}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    const double max[3] = {cases[k].length, 0.2, 0.1};
    const hc_sampling sampling = hc_sampling_block(&lattice, min, max);
    ck_assert_msg(hc_sampling_count(&sampling) == 2 * cases[k].n, "length %g: %lld", cases[k].length,
                  (long long)hc_sampling_count(&sampling));
  }
}
END_TEST

/* A long block must neither lose its last layer to the rounding of the spacing nor run off the lattice. */
START_TEST(long_block_keeps_its_count) {
  const hc_lattice rounded = {{1e-10 / 3, 1e-10 / 3, 1e-10 / 3}, {0, 0, 0}, {30000002, 30000002, 30000002}};
  const double min[3] = {0, 0, 0}, max[3] = {20, 0.001, 0.001};
  const hc_sampling sampling = hc_sampling_block(&rounded, min, max);
  ck_assert_int_eq(hc_sampling_count(&sampling), 20000);
  int64_t x[3];
  hc_sampling_point(&sampling, 19999, x);
  ck_assert_int_eq(x[0], 15000001 + 19999 * INT64_C(30000002));
}
END_TEST

START_TEST(container_is_the_shell_for_all_open_faces) {
  const int64_t sizes[][3] = {{4, 3, 5}, {1, 1, 1}, {1, 4, 2}, {2, 2, 1}};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
    for (unsigned open = 0; open < 64; open++) {
      double max[3];
      max_of(sizes[s], max);
      const hc_sampling sampling = hc_sampling_container(&lattice, corner, max, open, 1);
      points expected = brute_force(corner, sizes[s], open, around);
      assert_is(&sampling, &expected);
    }
}
END_TEST

START_TEST(solid_is_the_skin_for_all_open_faces) {
  const int64_t sizes[][3] = {{4, 3, 5}, {1, 1, 1}, {1, 4, 3}, {2, 2, 2}, {1, 1, 6}, {2, 5, 1}};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
    for (unsigned open = 0; open < 64; open++) {
      double max[3];
      max_of(sizes[s], max);
      const hc_sampling sampling = hc_sampling_solid(&lattice, corner, max, open, 1);
      points expected = brute_force(corner, sizes[s], open, skin);
      assert_is(&sampling, &expected);
    }
}
END_TEST

/* On a closed surface of lattice points every point has four neighbours one spacing away, a corner three. */
START_TEST(container_has_no_gaps_at_edges_and_corners) {
  const int64_t n[3] = {4, 3, 5};
  double max[3];
  max_of(n, max);
  const hc_sampling sampling = hc_sampling_container(&lattice, corner, max, 0, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), 6 * 5 * 7 - 4 * 3 * 5);
  points set = all_points(&sampling);
  sort(&set);
  int64_t corners = 0;
  for (int64_t k = 0; k < set.count; k++) {
    int neighbors = 0;
    for (int step = 0; step < 6; step++) {
      point near = set.at[k];
      near.x[step / 2] += step % 2 ? DX : -DX;
      neighbors += bsearch(&near, set.at, (size_t)set.count, sizeof near, compare) != NULL;
    }
    ck_assert(neighbors == 4 || neighbors == 3);
    corners += neighbors == 3;
  }
  ck_assert_int_eq(corners, 8);
  hc_free(set.at);
}
END_TEST

/* Lengths that are no multiples: rows spread evenly, faces still half a spacing behind the wetted surface. */
START_TEST(container_of_other_lengths_spreads_its_rows) {
  const double min[3] = {0, 0, 0}, max[3] = {10.0333, 0.27, 0.04};
  const int64_t n[3] = {100, 3, 1}, length[3] = {100333, 2700, 400};
  const hc_sampling sampling = hc_sampling_container(&lattice, min, max, 0, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), 102 * 5 * 3 - 100 * 3 * 1);
  points set = all_points(&sampling);
  sort(&set);
  assert_no_doubles(&set);
  int64_t low_face[3] = {0}, high_face[3] = {0};
  for (int64_t k = 0; k < set.count; k++)
    for (int a = 0; a < 3; a++) {
      const int64_t x = set.at[k].x[a] - lattice.origin[a];
      low_face[a] += x == -DX / 2;
      high_face[a] += x == length[a] + DX / 2;
      if (x == -DX / 2 || x == length[a] + DX / 2) continue;
      const double index = (double)x * (double)n[a] / (double)length[a] - 0.5;
      ck_assert_double_le(fabs(index - rint(index)) * (double)length[a] / (double)n[a], 1.0);
      ck_assert(rint(index) >= 0 && rint(index) < (double)n[a]);
    }
  for (int a = 0; a < 3; a++) {
    const int64_t face = (n[(a + 1) % 3] + 2) * (n[(a + 2) % 3] + 2);
    ck_assert_int_eq(low_face[a], face);
    ck_assert_int_eq(high_face[a], face);
  }
  hc_free(set.at);
}
END_TEST

START_TEST(thin_solids_are_single_layers) {
  const double min[3] = {0, 0, 0};
  const struct {
    double length;
    int64_t low, high;
  } cases[] = {{0.01, 50, 50}, {0.1, 500, 500}, {0.14, 700, 700}, {0.16, 500, 1100}, {0.2, 500, 1500}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    const double max[3] = {0.3, 0.3, cases[k].length};
    const hc_sampling sampling = hc_sampling_solid(&lattice, min, max, 0, 1);
    const int64_t layers = cases[k].low == cases[k].high ? 1 : 2;
    ck_assert_int_eq(hc_sampling_count(&sampling), 9 * layers);
    int64_t low[3], high[3];
    hc_sampling_bounds(&sampling, low, high);
    ck_assert_int_eq(low[2] - lattice.origin[2], cases[k].low);
    ck_assert_int_eq(high[2] - lattice.origin[2], cases[k].high);
    points set = all_points(&sampling);
    sort(&set);
    assert_no_doubles(&set);
    hc_free(set.at);
  }
}
END_TEST

START_TEST(planes_lie_behind_their_surface_and_close_periods) {
  for (int axis = 0; axis < 3; axis++)
    for (int sign = -1; sign <= 1; sign += 2) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      double at[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
      at[axis] = 0.25;
      at[u] = 0.4;
      at[v] = 0.3;
      normal[axis] = sign * 2.5;
      const double size[2] = {0.8, 0.6};
      const hc_sampling sampling = hc_sampling_plane(&lattice, at, normal, size, 1);
      ck_assert_int_eq(hc_sampling_count(&sampling), 48);
      points expected = empty(48);
      for (int64_t i = 0; i < 8; i++)
        for (int64_t j = 0; j < 6; j++) {
          int64_t *const x = expected.at[expected.count++].x;
          x[axis] = lattice.origin[axis] + 2500 - sign * DX / 2;
          x[u] = lattice.origin[u] + DX / 2 + i * DX; /* a period of 8000 closes with the same step */
          x[v] = lattice.origin[v] + DX / 2 + j * DX;
        }
      assert_is(&sampling, &expected);
    }
}
END_TEST

/* A plane whose length is no multiple still meets its periodic image with its own step. */
START_TEST(stretched_plane_closes_its_period) {
  const double at[3] = {0.17, 0.17, 0}, normal[3] = {0, 0, 1}, size[2] = {0.34, 0.34};
  const hc_sampling sampling = hc_sampling_plane(&lattice, at, normal, size, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), 9);
  int64_t first[3], second[3], last[3];
  hc_sampling_point(&sampling, 0, first);
  hc_sampling_point(&sampling, 1, second);
  hc_sampling_point(&sampling, 2, last);
  const int64_t across = first[0] + 3400 - last[0], step = second[0] - first[0];
  ck_assert_int_le(llabs(across - step), 2);
  ck_assert_int_le(llabs(step - 1133), 1);
}
END_TEST

START_TEST(oblique_plane_is_a_flat_square_lattice) {
  const double at[3] = {0.1, -0.2, 0.3}, normal[3] = {1, -2, 2}, size[2] = {0.5, 0.3};
  const double unit[3] = {1.0 / 3, -2.0 / 3, 2.0 / 3};
  const hc_sampling sampling = hc_sampling_plane(&lattice, at, normal, size, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), 15);
  points set = all_points(&sampling);
  double mean[3] = {0, 0, 0};
  for (int64_t k = 0; k < 15; k++) {
    double height = 0;
    for (int a = 0; a < 3; a++) {
      const double x = (double)(set.at[k].x[a] - lattice.origin[a]) - 1e4 * at[a];
      height += unit[a] * x;
      mean[a] += x / 15;
    }
    ck_assert_double_eq_tol(height, -(double)DX / 2, 2); /* behind the surface, to rounding */
    if (k % 5 == 0) continue;
    double square = 0;
    for (int a = 0; a < 3; a++) square += pow((double)(set.at[k].x[a] - set.at[k - 1].x[a]), 2);
    ck_assert_double_eq_tol(sqrt(square), (double)DX, 2);
  }
  for (int a = 0; a < 3; a++) ck_assert_double_eq_tol(mean[a], -unit[a] * (double)DX / 2, 1);
  for (int64_t k = 5; k < 15; k++) { /* rows: perpendicular to the first tangent, one spacing apart */
    double square = 0, along = 0;
    for (int a = 0; a < 3; a++) {
      const double step = (double)(set.at[k].x[a] - set.at[k - 5].x[a]);
      square += step * step;
      along += step * (double)(set.at[1].x[a] - set.at[0].x[a]);
    }
    ck_assert_double_eq_tol(sqrt(square), (double)DX, 2);
    ck_assert_double_le(fabs(along) / (double)(DX * DX), 0.005);
  }
  hc_free(set.at);
}
END_TEST

static void sample_kinds(const hc_lattice *on, hc_sampling kinds[5]) {
  const double max[3] = {0.52, 1.23, 1.77}, normal[3] = {0, -1, 0}, oblique[3] = {1, 1, 3};
  const double size[2] = {0.7, 0.55};
  kinds[0] = hc_sampling_block(on, corner, max);
  kinds[1] = hc_sampling_container(on, corner, max, 32, 1);
  kinds[2] = hc_sampling_solid(on, corner, max, 0, 1);
  kinds[3] = hc_sampling_plane(on, corner, normal, size, 1);
  kinds[4] = hc_sampling_plane(on, corner, oblique, size, 1);
}

START_TEST(any_order_of_access_gives_the_same_points) {
  hc_sampling kinds[5];
  sample_kinds(&lattice, kinds);
  for (int kind = 0; kind < 5; kind++) {
    points forward = all_points(&kinds[kind]);
    ck_assert_int_gt(forward.count, 20);
    const hc_sampling copy = kinds[kind];
    for (int64_t k = forward.count - 1; k >= 0; k--) {
      point p;
      hc_sampling_point(&copy, k, p.x);
      ck_assert_int_eq(compare(&p, &forward.at[k]), 0);
    }
    sort(&forward);
    assert_no_doubles(&forward);
    hc_free(forward.at);
  }
}
END_TEST

START_TEST(bounds_are_the_extremes) {
  hc_sampling kinds[5];
  sample_kinds(&lattice, kinds);
  for (int kind = 0; kind < 5; kind++) {
    int64_t low[3], high[3], min[3], max[3];
    hc_sampling_bounds(&kinds[kind], low, high);
    points set = all_points(&kinds[kind]);
    for (int a = 0; a < 3; a++) {
      min[a] = max[a] = set.at[0].x[a];
      for (int64_t k = 1; k < set.count; k++) {
        if (set.at[k].x[a] < min[a]) min[a] = set.at[k].x[a];
        if (set.at[k].x[a] > max[a]) max[a] = set.at[k].x[a];
      }
      ck_assert_int_eq(low[a], min[a]);
      ck_assert_int_eq(high[a], max[a]);
    }
    hc_free(set.at);
  }
}
END_TEST

START_TEST(a_shifted_origin_shifts_every_point_exactly) {
  const int64_t shift[3] = {INT64_C(1) << 52, -(INT64_C(7) << 50), INT64_C(1) << 28};
  hc_lattice moved = lattice;
  for (int a = 0; a < 3; a++) moved.origin[a] += shift[a];
  hc_sampling here[5], there[5];
  sample_kinds(&lattice, here);
  sample_kinds(&moved, there);
  for (int kind = 0; kind < 5; kind++) {
    ck_assert_int_eq(hc_sampling_count(&here[kind]), hc_sampling_count(&there[kind]));
    for (int64_t k = 0; k < hc_sampling_count(&here[kind]); k++) {
      point p, q;
      hc_sampling_point(&here[kind], k, p.x);
      hc_sampling_point(&there[kind], k, q.x);
      for (int a = 0; a < 3; a++) ck_assert_int_eq(q.x[a] - p.x[a], shift[a]);
    }
  }
}
END_TEST

START_TEST(huge_samplings_are_counted_or_refused) {
  const double min[3] = {0, 0, 0}, large[3] = {1e5, 1e5, 1e5}, long_one[3] = {1e5, 0.1, 0.1},
               too_long[3] = {1e9, 0.1, 0.1};
  hc_sampling sampling = hc_sampling_block(&lattice, min, large);
  ck_assert_int_eq(hc_sampling_count(&sampling), INT64_C(1000000) * 1000000 * 1000000);
  sampling = hc_sampling_container(&lattice, min, long_one, 3, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), 8000000);
  sampling = hc_sampling_container(&lattice, min, too_long, 3, 1);
  ck_assert_int_eq(hc_sampling_count(&sampling), INT64_MAX);
  sampling = hc_sampling_block(&lattice, min, (const double[3]){1e7, 1e7, 1e7});
  ck_assert_int_eq(hc_sampling_count(&sampling), INT64_MAX);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("geometry");
  TCase *const cases = tcase_create("samplings");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, block_is_the_lattice_in_the_box);
  tcase_add_test(cases, block_counts_whole_spacings_only);
  tcase_add_test(cases, long_block_keeps_its_count);
  tcase_add_test(cases, container_is_the_shell_for_all_open_faces);
  tcase_add_test(cases, solid_is_the_skin_for_all_open_faces);
  tcase_add_test(cases, container_has_no_gaps_at_edges_and_corners);
  tcase_add_test(cases, container_of_other_lengths_spreads_its_rows);
  tcase_add_test(cases, thin_solids_are_single_layers);
  tcase_add_test(cases, planes_lie_behind_their_surface_and_close_periods);
  tcase_add_test(cases, stretched_plane_closes_its_period);
  tcase_add_test(cases, oblique_plane_is_a_flat_square_lattice);
  tcase_add_test(cases, any_order_of_access_gives_the_same_points);
  tcase_add_test(cases, bounds_are_the_extremes);
  tcase_add_test(cases, a_shifted_origin_shifts_every_point_exactly);
  tcase_add_test(cases, huge_samplings_are_counted_or_refused);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
