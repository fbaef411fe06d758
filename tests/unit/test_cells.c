/* The cell grid: where a position lies, the canonical order, the hash table of bricks. */
#include "base/memory.h"
#include "space/cells.h"

#include <check.h>
#include <stdlib.h>
#include <string.h>

/* splitmix64's mixer. */
static uint64_t mix(uint64_t value) {
  value += 0x9e3779b97f4a7c15;
  value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9;
  value = (value ^ value >> 27) * 0x94d049bb133111eb;
  return value ^ value >> 31;
}

START_TEST(positions_round_down_to_their_cell) {
  static const int64_t coordinates[] = {0,
                                        1,
                                        HC_CELL_UNITS - 1,
                                        HC_CELL_UNITS,
                                        4 * HC_CELL_UNITS - 1,
                                        -1,
                                        4 * HC_CELL_UNITS,
                                        -HC_CELL_UNITS,
                                        -HC_CELL_UNITS - 1,
                                        -4 * HC_CELL_UNITS,
                                        -4 * HC_CELL_UNITS - 1,
                                        INT64_C(1) << 55,
                                        -(INT64_C(1) << 55),
                                        (INT64_C(1) << 58) - 1,
                                        -(INT64_C(1) << 58),
                                        (INT64_C(1) << 60),
                                        -(INT64_C(1) << 60)};
  enum { COUNT = sizeof coordinates / sizeof *coordinates };
  for (int k = 0; k < COUNT * COUNT; k++) {
    const int64_t position[3] = {coordinates[k % COUNT], coordinates[k / COUNT], coordinates[k * 7 % COUNT]};
    hc_brick brick;
    const int cell = hc_cell_of(position, &brick);
    ck_assert(cell >= 0 && cell < HC_BRICK_CELLS);
    for (int axis = 0; axis < 3; axis++) {
      const int64_t part = cell >> (2 * axis) & 3,
                    corner = (4 * (int64_t)brick.x[axis] + part) * HC_CELL_UNITS;
      ck_assert(position[axis] >= corner && position[axis] - corner < HC_CELL_UNITS);
    }
  }
  hc_brick brick;
  ck_assert_int_eq(hc_cell_of((const int64_t[]){-1, 0, 5 * HC_CELL_UNITS}, &brick), 3 | 0 << 2 | 1 << 4);
  ck_assert(hc_brick_equal(brick, (hc_brick){{-1, 0, 1}}));
}
END_TEST

/* A particle of a cloud around the origin; ids in no order. */
static void place_particle(hc_particles *particles, int32_t index, uint64_t which, int64_t cells) {
  particles->id[index] = mix(which) >> 8;
  for (int axis = 0; axis < 3; axis++) {
    const uint64_t bits = mix(3 * which + (uint64_t)axis + 1000003);
    particles->position[3 * index + axis] =
        (int64_t)(bits % (uint64_t)(2 * cells * HC_CELL_UNITS)) - cells * HC_CELL_UNITS;
    particles->velocity[3 * index + axis] = (double)(bits >> 20);
  }
}

/* `count` particles; `start` and `stride` choose the order in which they stand in memory. */
static void make_cloud(hc_particles *particles, int32_t count, int64_t cells, int32_t start, int32_t stride) {
  hc_particles_resize(particles, count);
  for (int32_t k = 0; k < count; k++)
    place_particle(particles, k, (uint64_t)(((int64_t)k * stride + start) % count), cells);
}

static bool is_border(const int64_t cell[3]) {
  return mix((uint64_t)(cell[0] * 1000000 + cell[1] * 1000 + cell[2])) % 3 == 0;
}

static void set_border_bits(hc_cells *cells) {
  for (int32_t k = 0; k < cells->bricks.count; k++)
    for (int bit = 0; bit < HC_BRICK_CELLS; bit++) {
      int64_t cell[3];
      for (int axis = 0; axis < 3; axis++)
        cell[axis] = 4 * (int64_t)cells->bricks.bricks[k].x[axis] + (bit >> (2 * axis) & 3);
      if (cells->count[k][bit] > 0 && is_border(cell)) cells->border[k] |= 1ULL << bit;
    }
}

static void cell_of(const hc_particles *particles, int32_t index, int64_t cell[3]) {
  for (int axis = 0; axis < 3; axis++) cell[axis] = hc_frame_cell(particles->position[3 * index + axis]);
}

/* Below zero if particle a stands before b in the canonical order. */
static int compare(const hc_particles *particles, int32_t a, int32_t b) {
  int64_t p[3], q[3];
  cell_of(particles, a, p);
  cell_of(particles, b, q);
  for (int axis = 2; axis >= 0; axis--)
    if (p[axis] != q[axis]) return p[axis] < q[axis] ? -1 : 1;
  return particles->id[a] < particles->id[b] ? -1 : particles->id[a] > particles->id[b];
}

static void check_order(const hc_cells *cells, const hc_particles *particles, bool with_border) {
  bool good = true;
  int32_t border = 0;
  for (int32_t k = 0; k < particles->own; k++) {
    int64_t cell[3];
    cell_of(particles, k, cell);
    if (with_border && is_border(cell)) {
      good &= border == k;
      border++;
    }
    if (k > 0 && k != particles->border) good &= compare(particles, k - 1, k) < 0;
    for (int axis = 0; axis < 3; axis++)
      good &= (uint32_t)particles->place[k].x[axis] == (uint32_t)particles->position[3 * k + axis];
    good &= particles->place[k].scalar == 0.0f;
  }
  ck_assert_int_eq(particles->border, border);
  ck_assert_int_eq(particles->ghosts, 0);
  /* Cells tile the particles in memory order and hold what lies in them. */
  int32_t next = 0;
  for (int32_t k = 0; k < cells->own_cell_count; k++) {
    const int32_t brick = cells->own_cells[k] / HC_BRICK_CELLS, bit = cells->own_cells[k] % HC_BRICK_CELLS;
    good &= cells->begin[brick][bit] == next && cells->count[brick][bit] > 0;
    for (int32_t end = next + cells->count[brick][bit]; next < end && next < particles->own; next++) {
      hc_brick own;
      good &= hc_cell_of(&particles->position[3 * next], &own) == bit;
      good &= hc_brick_equal(own, cells->bricks.bricks[brick]);
    }
  }
  ck_assert_int_eq(next, particles->own);
  ck_assert(good);
}

static bool same_particles(const hc_particles *a, const hc_particles *b) {
  const size_t own = (size_t)a->own;
  return a->own == b->own && a->border == b->border && memcmp(a->id, b->id, own * sizeof *a->id) == 0 &&
         memcmp(a->position, b->position, 3 * own * sizeof *a->position) == 0 &&
         memcmp(a->velocity, b->velocity, 3 * own * sizeof *a->velocity) == 0;
}

START_TEST(order_is_canonical) {
  enum { COUNT = 4001 };
  hc_cells cells;
  hc_particles particles, first;
  hc_cells_init(&cells);
  hc_particles_init(&particles, HC_FLUID, HC_FOR_ALL);
  hc_particles_init(&first, HC_FLUID, HC_FOR_ALL);
  for (int with_border = 0; with_border < 2; with_border++) {
    const int32_t strides[] = {1, 17, 2000, COUNT - 1};
    for (int s = 0; s < 4; s++) {
      hc_particles *to = s == 0 ? &first : &particles;
      make_cloud(to, COUNT, 6, 97 * s, strides[s]);
      hc_cells_bin(&cells, to);
      if (with_border) set_border_bits(&cells);
      hc_cells_order(&cells, to);
      check_order(&cells, to, with_border);
      if (s > 0) ck_assert(same_particles(&first, &particles));
    }
  }
  hc_particles_free(&first);
  hc_particles_free(&particles);
  hc_cells_free(&cells);
}
END_TEST

/* Many particles in one cell, ids descending. */
START_TEST(crowded_cells_are_in_order_of_ids) {
  hc_cells cells;
  hc_particles particles;
  hc_cells_init(&cells);
  hc_particles_init(&particles, HC_FLUID, HC_FOR_ALL);
  hc_particles_resize(&particles, 700);
  for (int k = 0; k < 700; k++) {
    particles.id[k] = (uint64_t)(700 - k) << 40;
    for (int axis = 0; axis < 3; axis++) particles.position[3 * k + axis] = -5 - k;
  }
  hc_cells_bin(&cells, &particles);
  hc_cells_order(&cells, &particles);
  check_order(&cells, &particles, false);
  ck_assert_int_eq(cells.own_cell_count, 1);
  hc_particles_free(&particles);
  hc_cells_free(&cells);
}
END_TEST

/* Binning forgets bricks, counts and border bits of before. */
START_TEST(binning_starts_afresh) {
  hc_cells cells;
  hc_particles particles;
  hc_cells_init(&cells);
  hc_particles_init(&particles, HC_FLUID, HC_FOR_ALL);
  for (int round = 0; round < 3; round++) {
    make_cloud(&particles, 500, 3 + 20 * round, 0, 1);
    hc_cells_bin(&cells, &particles);
    if (round == 1) set_border_bits(&cells);
    hc_cells_order(&cells, &particles);
    check_order(&cells, &particles, round == 1);
    hc_cells_insert(&cells, (hc_brick){{1000, 1000, 1000}}); /* as a ghost would be */
    hc_particles_set_ghosts(&particles, 10);
  }
  hc_particles_resize(&particles, 1);
  memset(particles.position, 0, 3 * sizeof *particles.position);
  hc_cells_bin(&cells, &particles);
  ck_assert_int_eq(cells.bricks.count, 1);
  ck_assert_int_eq(hc_cells_find(&cells, (hc_brick){{1000, 1000, 1000}}), -1);
  ck_assert_int_eq(hc_cells_find(&cells, (hc_brick){{0, 0, 0}}), 0);
  hc_cells_order(&cells, &particles);
  hc_particles_resize(&particles, 0);
  hc_cells_bin(&cells, &particles);
  hc_cells_order(&cells, &particles);
  ck_assert(cells.bricks.count == 0 && cells.own_cell_count == 0 && particles.border == 0);
  hc_particles_free(&particles);
  hc_cells_free(&cells);
}
END_TEST

static hc_brick brick_number(int32_t k) {
  const uint64_t bits = mix((uint64_t)k);
  return (hc_brick){{(int32_t)(bits % 40) - 20, (int32_t)(bits / 40 % 40) - 20, k / 3 - 700}};
}

START_TEST(the_table_grows_and_finds_everything) {
  enum { BRICKS = 5000 };
  hc_cells cells;
  hc_cells_init(&cells);
  static int32_t index[BRICKS];
  for (int32_t k = 0; k < BRICKS; k++) {
    const hc_brick brick = brick_number(k);
    const int32_t before = hc_cells_find(&cells, brick), count = cells.bricks.count;
    index[k] = hc_cells_insert(&cells, brick);
    ck_assert_int_eq(index[k], before >= 0 ? before : count);
    if (before >= 0) continue;
    cells.count[index[k]][5] = k + 1;
    ck_assert(cells.border[index[k]] == 0 && cells.count[index[k]][4] == 0);
  }
  bool good = true;
  for (int32_t k = 0; k < BRICKS; k++) {
    good &= hc_cells_find(&cells, brick_number(k)) == index[k];
    good &= hc_cells_insert(&cells, brick_number(k)) == index[k];
    good &= hc_brick_equal(cells.bricks.bricks[index[k]], brick_number(k));
    good &= hc_brick_equal(brick_number(cells.count[index[k]][5] - 1), brick_number(k));
    const hc_brick absent = {{brick_number(k).x[0] + 100, k, -k}};
    good &= hc_cells_find(&cells, absent) == -1;
  }
  ck_assert(good);
  ck_assert((uint32_t)cells.bricks.count <= cells.bricks.mask / 2 + 1);
  hc_cells_free(&cells);
}
END_TEST

START_TEST(bricks_around_are_named_x_fastest) {
  hc_cells cells;
  hc_cells_init(&cells);
  int32_t adjacent[HC_ADJACENT];
  ck_assert(!hc_brick_set_around(&cells.bricks, (hc_brick){{0, 0, 0}}, adjacent));
  for (int way = 0; way < HC_ADJACENT; way++) ck_assert_int_eq(adjacent[way], -1);
  const hc_brick centre = {{-1, 0, 1}};
  for (int z = -1; z <= 1; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++)
        if ((x + y + z) % 2 == 0)
          hc_cells_insert(&cells, (hc_brick){{centre.x[0] + x, centre.x[1] + y, centre.x[2] + z}});
  hc_cells_insert(&cells, (hc_brick){{centre.x[0] + 2, centre.x[1], centre.x[2]}});
  ck_assert(hc_brick_set_around(&cells.bricks, centre, adjacent));
  int way = 0, inserted = 0;
  for (int z = -1; z <= 1; z++)
    for (int y = -1; y <= 1; y++)
      for (int x = -1; x <= 1; x++, way++)
        ck_assert_int_eq(adjacent[way], (x + y + z) % 2 == 0 ? inserted++ : -1);
  ck_assert(!hc_brick_set_around(&cells.bricks, (hc_brick){{9, 9, 9}}, adjacent));
  hc_cells_free(&cells);
}
END_TEST

/* A thousand million cells apart. */
START_TEST(distance_costs_no_memory) {
  hc_cells cells;
  hc_particles particles;
  hc_cells_init(&cells);
  hc_particles_init(&particles, HC_FLUID, HC_FOR_ALL);
  hc_particles_resize(&particles, 8);
  const size_t before = hc_memory_now();
  for (int k = 0; k < 8; k++) {
    particles.id[k] = (uint64_t)k;
    for (int axis = 0; axis < 3; axis++)
      particles.position[3 * k + axis] = (k >> axis & 1 ? 1 : -1) * 1000000000 * HC_CELL_UNITS + 7;
  }
  hc_cells_bin(&cells, &particles);
  hc_cells_order(&cells, &particles);
  ck_assert_int_eq(cells.bricks.count, 8);
  ck_assert_uint_lt(cells.bricks.mask, 256);
  ck_assert_uint_le(hc_memory_now(), before + (1 << 20));
  for (int k = 0; k < 8; k++) ck_assert_uint_eq(particles.id[k], k); /* z, y, x is the order of the bits */
  int32_t adjacent[HC_ADJACENT];
  for (int k = 0; k < 8; k++) {
    ck_assert(hc_brick_set_around(&cells.bricks, cells.bricks.bricks[k], adjacent));
    for (int way = 0; way < HC_ADJACENT; way++)
      ck_assert_int_eq(adjacent[way], way == HC_ADJACENT_SELF ? k : -1);
  }
  hc_particles_free(&particles);
  hc_cells_free(&cells);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("cells");
  TCase *const cases = tcase_create("grid");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, positions_round_down_to_their_cell);
  tcase_add_test(cases, order_is_canonical);
  tcase_add_test(cases, crowded_cells_are_in_order_of_ids);
  tcase_add_test(cases, binning_starts_afresh);
  tcase_add_test(cases, the_table_grows_and_finds_everything);
  tcase_add_test(cases, bricks_around_are_named_x_fastest);
  tcase_add_test(cases, distance_costs_no_memory);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
