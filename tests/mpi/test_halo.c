/* The halo against brute force over all particles of all ranks: which ghosts there are, what a particle sees
 * of them, across ranks and periodic borders. */
#include "halo_world.h"

#include <math.h>
#include <stdlib.h>

/* Everybody moves by up to a cell, some much further; periodic axes wrap. */
static void move(world *w, int round) {
  for (int32_t k = 0; k < w->particles.own; k++) {
    const uint64_t id = w->particles.id[k];
    for (int axis = 0; axis < 3; axis++) {
      const int64_t reach = (id % 16 == 0 ? 9 : 1) * HC_CELL_UNITS;
      const int64_t step =
          (int64_t)(mix(id * 8 + (uint64_t)(round * 100000 + axis)) % (uint64_t)(2 * reach)) - reach;
      int64_t *x = &w->particles.position[3 * k + axis];
      *x = hc_frame_wrap(&w->frame, axis, *x + step);
    }
  }
}

/* ---- brute force ---- */

static int owner_of(const world *w, const int64_t cell[3]) {
  return hc_domain_owner(&w->domain, cell);
}

static bool in_domain(const world *w, const int64_t cell[3]) {
  bool inside = true;
  for (int axis = 0; axis < 3; axis++) {
    const int64_t low = cell_along(w->frame.low[axis]), count = cell_along(w->frame.period[axis]);
    inside &= count == 0 || (cell[axis] >= low && cell[axis] < low + count);
  }
  return inside;
}

/* Is one of the 27 cells around `cell` a real cell of this rank? */
static bool touches_us(const world *w, const int64_t cell[3]) {
  for (int way = 0; way < 27; way++) {
    const int64_t next[3] = {cell[0] + way % 3 - 1, cell[1] + way / 3 % 3 - 1, cell[2] + way / 9 - 1};
    if (in_domain(w, next) && owner_of(w, next) == comm.rank) return true;
  }
  return false;
}

/* Is one of the cells around a particle of ours another rank's, or beyond a periodic border? */
static bool is_at_border(const world *w, const int64_t x[3]) {
  for (int way = 0; way < 27; way++) {
    const int offset[3] = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
    int64_t next[3];
    bool beyond = false;
    for (int axis = 0; axis < 3; axis++) {
      const int64_t units = x[axis] + offset[axis] * HC_CELL_UNITS,
                    wrapped = hc_frame_wrap(&w->frame, axis, units);
      beyond |= wrapped != units;
      next[axis] = cell_along(wrapped);
    }
    if (beyond || owner_of(w, next) != comm.rank) return true;
  }
  return false;
}

/* A particle or image of one, and where it belongs in a list: x, z, y of its cell, id. */
typedef struct image {
  int64_t x[3], key[3];
  uint64_t id;
  bool required;
} image;

static int in_list_order(const void *a, const void *b) {
  const image *p = a, *q = b;
  for (int k = 0; k < 3; k++)
    if (p->key[k] != q->key[k]) return p->key[k] < q->key[k] ? -1 : 1;
  return p->id < q->id ? -1 : p->id > q->id;
}

/* What own particle i may see: all that is within 1.001 of the radius, itself excepted. */
static int32_t find_images(const world *w, int32_t i, image *found) {
  int32_t count = 0;
  const int64_t *own = &w->particles.position[3 * i];
  for (int32_t k = 0; k < w->all_count; k++) {
    if (w->all[k].id == w->particles.id[i]) continue;
    image *next = &found[count];
    double square = 0;
    for (int axis = 0; axis < 3; axis++) {
      const int64_t period = w->frame.period[axis];
      int64_t d = w->all[k].x[axis] - own[axis];
      if (period && d > period / 2) d -= period;
      if (period && d < -period / 2) d += period;
      next->x[axis] = own[axis] + d;
      square += (double)d * (double)d / ((double)HC_CELL_UNITS * (double)HC_CELL_UNITS);
    }
    if (square > 1.001 * 1.001) continue;
    static const int order[3] = {0, 2, 1};
    for (int a = 0; a < 3; a++) next->key[a] = cell_along(next->x[order[a]]);
    next->id = w->all[k].id;
    next->required = square < 1.0;
    count++;
  }
  qsort(found, (size_t)count, sizeof *found, in_list_order);
  return count;
}

static bool is_image(const world *w, int32_t index, const image *image) {
  bool good = id_of(w, index) == image->id;
  for (int axis = 0; axis < 3; axis++)
    good &= (uint32_t)w->particles.place[index].x[axis] == (uint32_t)(uint64_t)image->x[axis];
  return good;
}

static bool sees_what_it_should(const world *w, int32_t i, image *found) {
  const int32_t count = find_images(w, i, found);
  const uint32_t *row = hc_list_row(&w->list, i);
  int32_t entry = 0;
  for (int32_t k = 0; k < count; k++) {
    if (entry < hc_list_count(&w->list, i) &&
        is_image(w, (int32_t)(row[entry] / sizeof(hc_record)), &found[k]))
      entry++;
    else if (found[k].required)
      return false;
  }
  return entry == hc_list_count(&w->list, i);
}

static bool lists_are_right(const world *w) {
  image *found = hc_alloc((size_t)w->all_count, sizeof *found);
  bool good = true;
  for (int32_t i = 0; i < w->particles.own; i++) good &= sees_what_it_should(w, i, found);
  hc_free(found);
  return good;
}

/* Exactly the copies that lie next to a cell of ours. */
static bool ghosts_are_right(const world *w) {
  int32_t expected = 0;
  for (int32_t k = 0; k < w->all_count; k++) {
    int64_t home[3];
    for (int axis = 0; axis < 3; axis++) home[axis] = cell_along(w->all[k].x[axis]);
    const int owner = owner_of(w, home);
    for (int way = 0; way < 27; way++) {
      const int shift[3] = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
      int64_t cell[3];
      bool possible = true, shifted = false;
      for (int axis = 0; axis < 3; axis++) {
        possible &= shift[axis] == 0 || w->frame.period[axis] > 0;
        shifted |= shift[axis] != 0;
        cell[axis] = home[axis] + shift[axis] * cell_along(w->frame.period[axis]);
      }
      if (possible && (shifted || owner != comm.rank) && touches_us(w, cell)) expected++;
    }
  }
  return w->particles.ghosts == expected;
}

/* Border particles first, each part row-major by cell, ids ascending. */
static bool order_is_right(const world *w) {
  bool good = true;
  for (int32_t k = 0; k < w->particles.own; k++) {
    const int64_t *x = &w->particles.position[3 * k];
    good &= is_at_border(w, x) == (k < w->particles.border);
    if (k == 0 || k == w->particles.border) continue;
    int way = 0;
    for (int axis = 2; axis >= 0 && way == 0; axis--) {
      const int64_t before = cell_along(x[axis - 3]), here = cell_along(x[axis]);
      way = here > before ? 1 : here < before ? -1 : 0;
    }
    good &= way > 0 || (way == 0 && w->particles.id[k] > w->particles.id[k - 1]);
  }
  for (int32_t i = w->particles.border; i < w->particles.own; i++) { /* the interior sees no ghosts */
    const uint32_t *row = hc_list_row(&w->list, i);
    for (int32_t k = 0; k < hc_list_count(&w->list, i); k++)
      good &= row[k] < (uint32_t)w->particles.own * (uint32_t)sizeof(hc_record);
  }
  return good;
}

static void check_world(const world *w, int32_t count) {
  EXPECT(w->all_count == count);
  EXPECT(lists_are_right(w));
  EXPECT(ghosts_are_right(w));
  EXPECT(order_is_right(w));
}

START_TEST(particles_see_what_brute_force_finds) {
  for (int r = 0; r < REGIONS; r++) {
    world w;
    world_init(&w, &regions[r], r % 2 ? HC_BOUNDARY : HC_FLUID, 0);
    fill(&w, &regions[r]);
    balance(&w, HC_DIVIDER_SLABS);
    build(&w);
    check_world(&w, regions[r].count);
    for (int round = 0; round < 4; round++) { /* the same halo again; every other time the division too */
      move(&w, round);
      if (round == 1) balance(&w, HC_DIVIDER_METIS);
      if (round == 3) divide_wildly(&w, r % (HC_MAP_MOST_BITS + 1));
      build(&w);
      check_world(&w, regions[r].count);
    }
    world_free(&w);
  }
}
END_TEST

/* On one rank and without periods there is nothing to copy. */
START_TEST(one_rank_alone_has_no_ghosts) {
  if (comm.size > 1) return;
  world w;
  world_init(&w, &regions[0], HC_FLUID, 0);
  fill(&w, &regions[0]);
  build(&w);
  ck_assert(w.particles.ghosts == 0 && w.particles.border == 0);
  world_free(&w);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("halo");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, particles_see_what_brute_force_finds);
  tcase_add_test(tests, one_rank_alone_has_no_ghosts);
  return run_mpi_tests("halo", tests);
}
