/* Lists into two joined stores against lists into one that holds the same particles; and cells that hold far
 * too many. */
#include "neighbor_sets.h"

#include "particles/ids.h"

#include <time.h>

/* ---- two stores that are joined ---- */

enum { STANDING, MOVING, TOGETHER, KINDS_OF_WALLS };

/* Samples of many walls, some of which move: in two joined stores, and all in one. The head has some ghosts
 * without cells. */
static void scatter_walls(set walls[KINDS_OF_WALLS], int32_t count, const double size[3]) {
  enum { WALLS = 13, GHOSTS = 37 };
  set_init(&walls[STANDING], HC_BOUNDARY);
  set_init(&walls[MOVING], HC_BOUNDARY | HC_MOVED);
  set_init(&walls[TOGETHER], HC_BOUNDARY);
  hc_particles_join(&walls[STANDING].particles, &walls[MOVING].particles);
  scatter(&walls[TOGETHER], 11, count, size, nowhere, nowhere);
  hc_particles *all = &walls[TOGETHER].particles;
  int32_t counts[2] = {0, 0};
  for (int32_t k = 0; k < count; k++)
    all->id[k] = hc_id_make(HC_ID_BOUNDARY, mix((uint64_t)k) % WALLS, (uint64_t)(count - k));
  sort(&walls[TOGETHER]);
  for (int32_t k = 0; k < count; k++) counts[mix(hc_id_source_of(all->id[k])) & 1]++;
  for (int which = STANDING; which <= MOVING; which++) {
    hc_particles *part = &walls[which].particles;
    hc_particles_resize(part, counts[which]);
    for (int32_t k = 0, to = 0; k < count; k++) {
      if ((int)(mix(hc_id_source_of(all->id[k])) & 1) != which) continue;
      part->id[to] = all->id[k];
      memcpy(&part->position[3 * to++], &all->position[3 * k], 3 * sizeof *all->position);
    }
    sort(&walls[which]);
    if (which == STANDING) hc_particles_set_ghosts(part, GHOSTS);
  }
  for (int which = 0; which < KINDS_OF_WALLS; which++)
    for (int32_t k = 0; k < walls[which].particles.own; k++)
      walls[which].particles.motion[k].scalar = (float)hc_id_source_of(walls[which].particles.id[k]);
}

static uint64_t id_in_both(const set walls[KINDS_OF_WALLS], uint32_t offset) {
  const int32_t index = (int32_t)(offset / sizeof(hc_record));
  const int32_t first = hc_particles_first(&walls[MOVING].particles);
  return index < first ? walls[STANDING].particles.id[index] : walls[MOVING].particles.id[index - first];
}

/* The same rows, in the same order, by the samples' ids. */
static bool joined_agree(const hc_neighbors *joined, const hc_neighbors *one, const set *target,
                         const set walls[KINDS_OF_WALLS]) {
  bool good = joined->pairs == one->pairs;
  for (int32_t i = 0; i < target->particles.own; i++) {
    good &= joined->row[i] == one->row[i] && joined->row[i + 1] == one->row[i + 1];
    const uint32_t first = hc_list_begin(one, i);
    for (int32_t k = 0; k < hc_list_count(one, i) && good; k++)
      good &= id_in_both(walls, joined->offset[first + (uint32_t)k]) ==
              walls[TOGETHER].particles.id[one->offset[first + (uint32_t)k] / sizeof(hc_record)];
  }
  return good;
}

static void check_joined(const set *target, const set walls[KINDS_OF_WALLS]) {
  const hc_neighbor_source both[2] = {{&walls[STANDING].cells, &walls[STANDING].particles},
                                      {&walls[MOVING].cells, &walls[MOVING].particles}};
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    hc_neighbors one, joined;
    hc_neighbor_search search;
    build(&one, (hc_isa)isa, target, &walls[TOGETHER]);
    ck_assert_int_gt(one.pairs, 1000);
    hc_neighbor_search_init(&search, (hc_isa)isa);
    hc_neighbors_init(&joined);
    hc_neighbors_build(&joined, &search, &target->cells, &target->particles,
                       hc_select_all(&target->particles), both, 2);
    ck_assert_msg(joined_agree(&joined, &one, target, walls), "%s", hc_isa_name((hc_isa)isa));
    hc_neighbors_free(&one);
    hc_neighbors_free(&joined);
    hc_neighbor_search_free(&search);
  }
}

START_TEST(joined_stores_are_as_one) {
  static const double sizes[][3] = {{4, 4, 4}, {7, 1, 2}, {2, 2, 40}, {0.9, 0.9, 0.9}};
  for (int c = 0; c < 4; c++) {
    set fluid, walls[KINDS_OF_WALLS];
    set_init(&fluid, HC_FLUID);
    scatter(&fluid, 1, 600, sizes[c], nowhere, nowhere);
    scatter_walls(walls, 700, sizes[c]);
    check_joined(&fluid, walls);
    check_joined(&walls[MOVING], walls); /* as a target the tail goes by its own indices */
    check_joined(&walls[STANDING], walls);
    hc_neighbors list = checked_list(&walls[MOVING], &walls[MOVING]);
    hc_neighbors_free(&list);
    list = checked_list(&walls[MOVING], &fluid);
    hc_neighbors_free(&list);
    set_free(&fluid);
    for (int which = TOGETHER; which >= 0; which--) set_free(&walls[which]);
  }
}
END_TEST

/* ---- overfull cells ---- */

/* Particles [begin, end) go to one cell. */
static void crowd_into(set *set, int32_t begin, int32_t end, int64_t cell) {
  for (int32_t k = begin; k < end; k++)
    for (int axis = 0; axis < 3; axis++)
      set->particles.position[3 * k + axis] =
          cell * HC_CELL_UNITS + (int64_t)(mix((uint64_t)(3 * k + axis)) >> (64 - HC_CELL_BITS));
}

static uint64_t least_in_cell(const set *set, int64_t cell) {
  uint64_t least = UINT64_MAX;
  for (int32_t k = 0; k < set->particles.own; k++) {
    const int64_t *x = &set->particles.position[3 * k];
    if (hc_frame_cell(x[0]) == cell && hc_frame_cell(x[1]) == cell && hc_frame_cell(x[2]) == cell &&
        set->particles.id[k] < least)
      least = set->particles.id[k];
  }
  return least;
}

START_TEST(overfull_cells_have_no_neighbours) {
  enum { FULL = 5000, OTHERS = 300, ALL = 2 * FULL + OTHERS };
  static const double size[3] = {4, 4, 4};
  set cloud;
  set_init(&cloud, HC_FLUID);
  scatter(&cloud, 3, ALL, size, nowhere, nowhere);
  crowd_into(&cloud, 0, FULL, 2);
  crowd_into(&cloud, FULL, 2 * FULL, 20);
  sort(&cloud);
  const uint64_t least[2] = {least_in_cell(&cloud, 2), least_in_cell(&cloud, 20)};
  for (int isa = HC_ISA_PORTABLE; isa <= (int)hc_isa_best(); isa++) {
    hc_neighbors list;
    build(&list, (hc_isa)isa, &cloud, &cloud);
    ck_assert_int_ge(list.crowded, 0);
    ck_assert_uint_eq(cloud.particles.id[list.crowded], least[0] < least[1] ? least[0] : least[1]);
    ck_assert(layout_is_right(&list, &cloud, &cloud));
    candidate *found = hc_alloc(ALL, sizeof *found);
    for (int32_t i = 0; i < ALL; i++) {
      const int64_t *x = &cloud.particles.position[3 * i];
      const int64_t cell = hc_frame_cell(x[0]);
      const bool full =
          (cell == 2 || cell == 20) && hc_frame_cell(x[1]) == cell && hc_frame_cell(x[2]) == cell;
      if (full)
        ck_assert_int_eq(hc_list_count(&list, i), 0);
      else if (isa == HC_ISA_PORTABLE) /* they may have the overfull cell's particles as neighbours */
        ck_assert(row_agrees(&list, i, found, find_candidates(&cloud.particles, i, &cloud.particles, found)));
    }
    hc_free(found);
    hc_neighbors_free(&list);
  }
  set_free(&cloud);
}
END_TEST

/* The most that a cell may hold, of which some are selected. */
START_TEST(full_cells_have_neighbours) {
  static const double size[3] = {1, 1, 1};
  set cloud;
  set_init(&cloud, HC_FLUID);
  for (int32_t more = 0; more < 2; more++) {
    scatter(&cloud, 3, HC_CELL_MOST + more, size, nowhere, nowhere);
    crowd_into(&cloud, 0, HC_CELL_MOST + more, 0);
    sort(&cloud);
    hc_neighbors list;
    hc_neighbor_search search;
    hc_neighbors_init(&list);
    hc_neighbor_search_init(&search, hc_isa_best());
    hc_neighbors_build(&list, &search, &cloud.cells, &cloud.particles, hc_select_range(0, 10),
                       &(hc_neighbor_source){&cloud.cells, &cloud.particles}, 1);
    ck_assert_int_eq(list.crowded, more ? 0 : -1);
    for (int32_t i = 0; i < 10; i++)
      ck_assert(more ? hc_list_count(&list, i) == 0 : hc_list_count(&list, i) > HC_CELL_MOST / 10);
    hc_neighbors_free(&list);
    hc_neighbor_search_free(&search);
  }
  set_free(&cloud);
}
END_TEST

/* A run that has broken down must not hang: its steps come to an end. */
START_TEST(overfull_cells_take_no_time) {
  enum { FULL = 150000 };
  static const double size[3] = {1, 1, 1};
  set cloud;
  set_init(&cloud, HC_FLUID);
  scatter(&cloud, 3, 0, size, nowhere, nowhere);
  hc_particles_resize(&cloud.particles, FULL);
  for (int32_t k = 0; k < FULL; k++) cloud.particles.id[k] = (uint64_t)(FULL - k);
  crowd_into(&cloud, 0, FULL, -3);
  const clock_t begin = clock();
  sort(&cloud);
  hc_neighbors list;
  build(&list, hc_isa_best(), &cloud, &cloud);
  const double seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
  ck_assert_msg(seconds < 1.0, "%g s", seconds);
  ck_assert(list.crowded == 0 && list.pairs == 0);
  hc_neighbors_free(&list);
  set_free(&cloud);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("neighbor_stores");
  TCase *const cases = tcase_create("lists");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, joined_stores_are_as_one);
  tcase_add_test(cases, overfull_cells_have_no_neighbours);
  tcase_add_test(cases, full_cells_have_neighbours);
  tcase_add_test(cases, overfull_cells_take_no_time);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
