/* Neighbour lists against brute force, for every instruction set. */
#include "neighbor_sets.h"

START_TEST(lists_agree_with_brute_force) {
  static const struct {
    int32_t count;
    double size[3];
  } clouds[] = {{1, {1, 1, 1}},      {2, {0.5, 0.5, 0.5}},  {9, {1, 1, 1}},   {700, {5, 5, 4}},
                {900, {30, 2, 0.5}}, {900, {1.5, 1.5, 40}}, {400, {9, 9, 9}}, {400, {2, 2, 2}}};
  for (int k = 0; k < 8; k++) {
    set cloud;
    set_init(&cloud, HC_FLUID);
    const int64_t corner[3] = {-(2 << 20), -HC_CELL_UNITS - 12345, (k - 4) * HC_CELL_UNITS + k};
    scatter(&cloud, 11 + (uint64_t)k, clouds[k].count, clouds[k].size, corner, nowhere);
    hc_neighbors list = checked_list(&cloud, &cloud);
    hc_neighbors_free(&list);
    set_free(&cloud);
  }
}
END_TEST

/* Pairs at a hair below the radius, in all directions, are never missed. */
START_TEST(pairs_just_within_the_radius_are_found) {
  enum { PAIRS = 400 };
  set pairs;
  set_init(&pairs, HC_FLUID);
  hc_particles_resize(&pairs.particles, 2 * PAIRS);
  for (int k = 0; k < PAIRS; k++) {
    double way[3], square = 0;
    for (int axis = 0; axis < 3; axis++) {
      way[axis] = k < 6 ? (axis == k / 2) * (k % 2 ? 1.0 : -1.0)
                        : (double)(int64_t)mix((uint64_t)(3 * k + axis)) * 0x1p-63;
      square += way[axis] * way[axis];
    }
    for (int axis = 0; axis < 3; axis++) {
      const int64_t here = (axis == 0 ? 5 * (int64_t)k * HC_CELL_UNITS : 0) +
                           (int64_t)(mix((uint64_t)(5 * k + axis)) % (uint64_t)HC_CELL_UNITS);
      pairs.particles.position[6 * k + axis] = here;
      pairs.particles.position[6 * k + 3 + axis] =
          here + (int64_t)(way[axis] / sqrt(square) * ((double)HC_CELL_UNITS - 3.0));
    }
    pairs.particles.id[2 * k] = (uint64_t)(2 * k);
    pairs.particles.id[2 * k + 1] = (uint64_t)(2 * k + 1);
  }
  sort(&pairs);
  hc_neighbors list = checked_list(&pairs, &pairs);
  ck_assert_int_eq(list.pairs, 2 * PAIRS);
  hc_neighbors_free(&list);
  set_free(&pairs);
}
END_TEST

START_TEST(a_shift_by_whole_cells_changes_nothing) {
  static const double size[3] = {5, 3, 4};
  static const int64_t shifts[][3] = {
      {1000000, 1000000, 1000000}, {-1000003, 999999, 2}, {INT64_C(1) << 31, -(INT64_C(1) << 31) - 3, 1}};
  set here;
  set_init(&here, HC_FLUID);
  scatter(&here, 3, 600, size, nowhere, nowhere);
  hc_neighbors list = checked_list(&here, &here);
  for (int s = 0; s < 3; s++) {
    set there;
    set_init(&there, HC_FLUID);
    scatter(&there, 3, 600, size, nowhere, shifts[s]);
    hc_neighbors shifted = checked_list(&there, &there);
    ck_assert(same_list(&list, &shifted, 600));
    ck_assert(memcmp(here.particles.id, there.particles.id, 600 * sizeof *here.particles.id) == 0);
    hc_neighbors_free(&shifted);
    set_free(&there);
  }
  hc_neighbors_free(&list);
  set_free(&here);
}
END_TEST

START_TEST(another_set_may_be_the_source) {
  static const double size[3] = {4, 4, 4}, flat[3] = {6, 6, 0.1}, far[3] = {2, 2, 2};
  set fluid, walls;
  set_init(&fluid, HC_FLUID);
  set_init(&walls, HC_BOUNDARY);
  scatter(&fluid, 1, 500, size, nowhere, nowhere);
  scatter(&walls, 2, 700, flat, (const int64_t[]){-HC_CELL_UNITS, -HC_CELL_UNITS, -HC_CELL_UNITS / 2},
          nowhere);
  hc_neighbors list = checked_list(&fluid, &walls);
  ck_assert_int_gt(list.pairs, 1000);
  int32_t without = 0;
  for (int32_t k = 0; k < 500; k++) without += hc_list_count(&list, k) == 0;
  ck_assert_int_gt(without, 100);
  hc_neighbors_free(&list);
  list = checked_list(&walls, &fluid);
  hc_neighbors_free(&list);
  /* A particle at the very place of another is its neighbour, unlike a particle of itself. */
  memcpy(walls.particles.position, fluid.particles.position, 3 * 500 * sizeof *walls.particles.position);
  hc_particles_resize(&walls.particles, 500);
  sort(&walls);
  list = checked_list(&fluid, &walls);
  for (int32_t k = 0; k < 500; k++) ck_assert_int_ge(hc_list_count(&list, k), 1);
  hc_neighbors_free(&list);
  scatter(&walls, 2, 50, far, nowhere, (const int64_t[]){1000, 0, 0});
  list = checked_list(&fluid, &walls);
  ck_assert_int_eq(list.pairs, 0);
  hc_neighbors_free(&list);
  set_free(&fluid);
  set_free(&walls);
}
END_TEST

START_TEST(cells_may_be_crowded) {
  static const double one[3] = {1, 1, 1}, tiny[3] = {1e-3, 1e-3, 1e-3}, row[3] = {3, 1, 1};
  set cloud;
  set_init(&cloud, HC_FLUID);
  scatter(&cloud, 5, 100, one, nowhere, nowhere);
  hc_neighbors list = checked_list(&cloud, &cloud);
  hc_neighbors_free(&list);
  scatter(&cloud, 6, 300, tiny, (const int64_t[]){-1000, -1000, -1000}, nowhere); /* across a corner */
  list = checked_list(&cloud, &cloud);
  for (int32_t k = 0; k < 300; k++) ck_assert_int_eq(hc_list_count(&list, k), 299);
  hc_neighbors_free(&list);
  scatter(&cloud, 7, 500, row, nowhere, nowhere);
  list = checked_list(&cloud, &cloud);
  hc_neighbors_free(&list);
  set_free(&cloud);
}
END_TEST

/* A row of cells, none of them empty, with more candidates than the search keeps together. */
START_TEST(rows_may_be_long) {
  static const double row[3] = {150, 0.9, 0.9};
  set targets, sources;
  set_init(&targets, HC_FLUID);
  set_init(&sources, HC_FLUID);
  scatter(&targets, 8, 1200, row, nowhere, nowhere);
  scatter(&sources, 9, 25000, row, nowhere, nowhere);
  hc_neighbors list = checked_list(&targets, &sources);
  ck_assert_int_gt(list.pairs, 200000);
  hc_neighbors_free(&list);
  set_free(&targets);
  set_free(&sources);
}
END_TEST

START_TEST(sets_may_be_empty) {
  static const double size[3] = {2, 2, 2};
  set none, some;
  set_init(&none, HC_FLUID);
  set_init(&some, HC_BOUNDARY);
  sort(&none);
  scatter(&some, 4, 100, size, nowhere, nowhere);
  hc_neighbors list = checked_list(&none, &none);
  ck_assert(list.pairs == 0 && list.row[0] == 0);
  hc_neighbors_free(&list);
  list = checked_list(&none, &some);
  ck_assert(list.pairs == 0 && list.row[0] == 0);
  hc_neighbors_free(&list);
  list = checked_list(&some, &none);
  ck_assert(list.pairs == 0 && list.row[100] == 0);
  hc_neighbors_free(&list);
  set_free(&none);
  set_free(&some);
}
END_TEST

/* One list and one search, as a run uses them: growing, shrinking, growing. */
START_TEST(a_list_may_be_built_anew) {
  static const int32_t counts[] = {10, 800, 0, 300, 1500};
  static const double size[3] = {5, 5, 5};
  set cloud;
  set_init(&cloud, HC_FLUID);
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    hc_neighbors list;
    hc_neighbor_search search;
    hc_neighbors_init(&list);
    hc_neighbor_search_init(&search, (hc_isa)isa);
    for (int k = 0; k < 5; k++) {
      scatter(&cloud, (uint64_t)k, counts[k], size, nowhere, nowhere);
      hc_neighbors_build(&list, &search, &cloud.cells, &cloud.particles, hc_select_all(&cloud.particles),
                         &(hc_neighbor_source){&cloud.cells, &cloud.particles}, 1);
      check_list(&list, &cloud, &cloud, hc_isa_name((hc_isa)isa));
    }
    hc_neighbors_free(&list);
    hc_neighbor_search_free(&search);
  }
  set_free(&cloud);
}
END_TEST

/* Rows of a selection at their particles' numbers, for every n-th particle. */
START_TEST(rows_may_be_spread) {
  enum { COUNT = 700 };
  static const double size[3] = {5, 5, 5};
  static const int32_t strides[] = {1, 2, 7, 300, COUNT};
  set cloud;
  set_init(&cloud, HC_FLUID);
  scatter(&cloud, 9, COUNT, size, nowhere, nowhere);
  const hc_neighbor_source source = {&cloud.cells, &cloud.particles};
  hc_neighbors all, some;
  hc_neighbor_search search;
  hc_neighbors_init(&all);
  hc_neighbors_init(&some);
  hc_neighbor_search_init(&search, hc_isa_best());
  hc_neighbors_build(&all, &search, &cloud.cells, &cloud.particles, hc_select_all(&cloud.particles), &source,
                     1);
  for (size_t k = 0; k < sizeof strides / sizeof *strides; k++) {
    int32_t index[COUNT], count = 0;
    for (int32_t i = strides[k] - 1; i < COUNT; i += strides[k]) index[count++] = i;
    const hc_selection selection = {index, 0, count, false};
    hc_neighbors_build(&some, &search, &cloud.cells, &cloud.particles, selection, &source, 1);
    hc_neighbors_spread(&some, selection, COUNT);
    for (int32_t i = 0; i < COUNT; i++) {
      const bool selected = (i + 1) % strides[k] == 0;
      ck_assert_int_eq(hc_list_count(&some, i), selected ? hc_list_count(&all, i) : 0);
      ck_assert_int_eq(hc_list_entries(&some, i), selected ? hc_list_entries(&all, i) : 0);
      if (selected)
        ck_assert_mem_eq(hc_list_row(&some, i), hc_list_row(&all, i),
                         (size_t)hc_list_count(&all, i) * sizeof(uint32_t));
    }
  }
  hc_neighbors_free(&all);
  hc_neighbors_free(&some);
  hc_neighbor_search_free(&search);
  set_free(&cloud);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("neighbors");
  TCase *const cases = tcase_create("lists");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, lists_agree_with_brute_force);
  tcase_add_test(cases, pairs_just_within_the_radius_are_found);
  tcase_add_test(cases, a_shift_by_whole_cells_changes_nothing);
  tcase_add_test(cases, another_set_may_be_the_source);
  tcase_add_test(cases, cells_may_be_crowded);
  tcase_add_test(cases, rows_may_be_long);
  tcase_add_test(cases, sets_may_be_empty);
  tcase_add_test(cases, a_list_may_be_built_anew);
  tcase_add_test(cases, rows_may_be_spread);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
