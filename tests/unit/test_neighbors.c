/* Neighbour lists against brute force, for every instruction set. */
#include "base/memory.h"
#include "space/neighbors.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* splitmix64's mixer. */
static uint64_t mix(uint64_t value) {
  value += 0x9e3779b97f4a7c15;
  value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9;
  value = (value ^ value >> 27) * 0x94d049bb133111eb;
  return value ^ value >> 31;
}

/* Particles, their cells and, for the source of a list, room for ghosts. */
typedef struct set {
  hc_particles particles;
  hc_cells cells;
} set;

static void set_init(set *set, unsigned kind) {
  hc_particles_init(&set->particles, kind, HC_FOR_ALL);
  hc_cells_init(&set->cells);
}

static void set_free(set *set) {
  hc_particles_free(&set->particles);
  hc_cells_free(&set->cells);
}

static void sort(set *set) {
  hc_cells_bin(&set->cells, &set->particles);
  hc_cells_order(&set->cells, &set->particles);
}

/* `count` particles at random in a box of edges `size` in cells from `corner`, in units; then all shifted by
 * whole cells. */
static void scatter(set *set, uint64_t seed, int32_t count, const double size[3], const int64_t corner[3],
                    const int64_t shift[3]) {
  hc_particles_resize(&set->particles, count);
  for (int32_t k = 0; k < count; k++) {
    set->particles.id[k] = mix(seed * 1000000 + (uint64_t)k) >> 8;
    for (int axis = 0; axis < 3; axis++) {
      const double fraction = (double)(mix(seed + 7 * (uint64_t)(3 * k + axis)) >> 11) * 0x1p-53;
      set->particles.position[3 * k + axis] = corner[axis] +
                                              (int64_t)(fraction * size[axis] * (double)HC_CELL_UNITS) +
                                              shift[axis] * HC_CELL_UNITS;
    }
  }
  sort(set);
}

static const int64_t nowhere[3] = {0, 0, 0};

static double distance(const hc_particles *a, int32_t i, const hc_particles *b, int32_t j) {
  double square = 0;
  for (int axis = 0; axis < 3; axis++) {
    const double d = (double)(a->position[3 * i + axis] - b->position[3 * j + axis]) / (double)HC_CELL_UNITS;
    square += d * d;
  }
  return sqrt(square);
}

/* A neighbour that a list may have, with what its place in the list depends on: x, z, y of its cell, id. */
typedef struct candidate {
  int64_t cell[3];
  uint64_t id;
  int32_t index;
  bool required;
} candidate;

static int in_list_order(const void *a, const void *b) {
  const candidate *p = a, *q = b;
  for (int k = 0; k < 3; k++)
    if (p->cell[k] != q->cell[k]) return p->cell[k] < q->cell[k] ? -1 : 1;
  return p->id < q->id ? -1 : p->id > q->id;
}

/* All particles of the source within 1.001 of the support radius, in the order of the list; those within the
 * radius are required. */
static int32_t find_candidates(const hc_particles *target, int32_t i, const hc_particles *source,
                               candidate *found) {
  int32_t count = 0;
  for (int32_t j = 0; j < source->own; j++) {
    if (target == source && i == j) continue;
    if (llabs(source->position[3 * j] - target->position[3 * i]) > 2 * HC_CELL_UNITS) continue;
    const double r = distance(target, i, source, j);
    if (r > 1.001) continue;
    candidate *next = &found[count++];
    static const int order[3] = {0, 2, 1};
    for (int k = 0; k < 3; k++) next->cell[k] = hc_frame_cell(source->position[3 * j + order[k]]);
    next->id = source->id[j];
    next->index = j;
    next->required = r < 1.0;
  }
  qsort(found, (size_t)count, sizeof *found, in_list_order);
  return count;
}

/* Is the row a part of the candidates, in their order, with all that are required? */
static bool row_agrees(const hc_neighbors *list, int32_t i, const candidate *candidates, int32_t count) {
  const uint32_t *row = list->offset + (size_t)list->start[i] * HC_LIST_GROUP;
  int32_t entry = 0;
  for (int32_t k = 0; k < count; k++) {
    if (entry < list->count[i] && row[entry] == (uint32_t)candidates[k].index * sizeof(hc_record))
      entry++;
    else if (candidates[k].required)
      return false;
  }
  return entry == list->count[i];
}

/* Entries that fill up groups are the particle itself, or a neighbour; rows stand one behind the other. */
static bool layout_is_right(const hc_neighbors *list, const set *target, const set *source) {
  const int32_t own = target->particles.own;
  bool good = own == 0 || list->start[0] == 0;
  int64_t pairs = 0;
  for (int32_t i = 0; i < own; i++) {
    const uint32_t *row = list->offset + (size_t)list->start[i] * HC_LIST_GROUP;
    const int32_t entries = (int32_t)(list->start[i + 1] - list->start[i]) * HC_LIST_GROUP;
    good &= entries >= list->count[i] && entries < list->count[i] + HC_LIST_GROUP;
    for (int32_t k = list->count[i]; k < entries; k++)
      good &= row[k] == (target == source ? (uint32_t)i * sizeof(hc_record) : row[0]);
    pairs += list->count[i];
  }
  for (int k = 0; k < 16; k++) /* what a vector may load behind the last row */
    good &= list->offset[(size_t)list->start[own] * HC_LIST_GROUP + (size_t)k] <
            (uint32_t)(source->particles.own + HC_SPARE) * sizeof(hc_record);
  return good && pairs == list->pairs;
}

static void check_list(const hc_neighbors *list, const set *target, const set *source, const char *isa) {
  candidate *const found = hc_alloc((size_t)source->particles.own, sizeof *found);
  for (int32_t i = 0; i < target->particles.own; i++) {
    const int32_t count = find_candidates(&target->particles, i, &source->particles, found);
    if (!row_agrees(list, i, found, count))
      ck_abort_msg("%s: the %d neighbours of particle %d are not among the %d expected, in order", isa,
                   list->count[i], i, count);
  }
  ck_assert_msg(layout_is_right(list, target, source), "%s", isa);
  hc_free(found);
}

static bool same_list(const hc_neighbors *a, const hc_neighbors *b, int32_t own) {
  return a->pairs == b->pairs && memcmp(a->start, b->start, ((size_t)own + 1) * sizeof *a->start) == 0 &&
         memcmp(a->count, b->count, (size_t)own * sizeof *a->count) == 0 &&
         memcmp(a->offset, b->offset, (size_t)a->start[own] * HC_LIST_GROUP * sizeof *a->offset) == 0;
}

static void build(hc_neighbors *list, hc_isa isa, const set *target, const set *source) {
  hc_neighbor_search search;
  hc_neighbor_search_init(&search, isa);
  hc_neighbors_init(list);
  hc_neighbors_build(list, &search, &target->cells, &target->particles, hc_select_all(&target->particles),
                     &(hc_neighbor_source){&source->cells, &source->particles}, 1);
  hc_neighbor_search_free(&search);
}

/* Builds the list with all instruction sets: one agrees with brute force, the others with it. */
static hc_neighbors checked_list(const set *target, const set *source) {
  hc_neighbors first;
  build(&first, HC_ISA_PORTABLE, target, source);
  check_list(&first, target, source, hc_isa_name(HC_ISA_PORTABLE));
  for (int isa = HC_ISA_PORTABLE + 1; isa <= (int)hc_isa_best(); isa++) {
    hc_neighbors list;
    build(&list, (hc_isa)isa, target, source);
    ck_assert_msg(same_list(&first, &list, target->particles.own), "%s", hc_isa_name((hc_isa)isa));
    ck_assert_msg(layout_is_right(&list, target, source), "%s", hc_isa_name((hc_isa)isa));
    hc_neighbors_free(&list);
  }
  return first;
}

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
  for (int32_t k = 0; k < 500; k++) without += list.count[k] == 0;
  ck_assert_int_gt(without, 100);
  hc_neighbors_free(&list);
  list = checked_list(&walls, &fluid);
  hc_neighbors_free(&list);
  /* A particle at the very place of another is its neighbour, unlike a particle of itself. */
  memcpy(walls.particles.position, fluid.particles.position, 3 * 500 * sizeof *walls.particles.position);
  hc_particles_resize(&walls.particles, 500);
  sort(&walls);
  list = checked_list(&fluid, &walls);
  for (int32_t k = 0; k < 500; k++) ck_assert_int_ge(list.count[k], 1);
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
  for (int32_t k = 0; k < 300; k++) ck_assert_int_eq(list.count[k], 299);
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
  ck_assert(list.pairs == 0 && list.start[0] == 0);
  hc_neighbors_free(&list);
  list = checked_list(&none, &some);
  ck_assert(list.pairs == 0 && list.start[0] == 0);
  hc_neighbors_free(&list);
  list = checked_list(&some, &none);
  ck_assert(list.pairs == 0 && list.start[100] == 0);
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
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
