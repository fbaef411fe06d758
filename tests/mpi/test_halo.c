/* The halo against brute force over all particles of all ranks: which ghosts there are, what a particle sees
 * of them, what refreshes bring, across ranks and periodic borders. */
#include "mpi_test.h"

#include "base/memory.h"
#include "domain/halo.h"
#include "space/neighbors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A set of particles in a box of cells, some axes of which may be periodic. */
typedef struct region {
  int64_t low[3], cells[3];
  bool periodic[3];
  int32_t count;
} region;

static const region regions[] = {
    {{0, 0, 0}, {18, 5, 4}, {0}, 700},
    {{-7, 2, -30}, {3, 4, 24}, {0}, 600},
    {{5, 5, 5}, {3, 3, 3}, {1, 1, 1}, 250},
    {{-2, 0, 1}, {13, 3, 4}, {1, 1, 1}, 500},
    {{0, -9, 3}, {3, 17, 3}, {1, 0, 1}, 500},
    {{3, 3, 3}, {5, 6, 3}, {0, 0, 1}, 300},
    {{-3, -1, -2}, {16, 4, 5}, {1, 0, 0}, 600},
    {{1 << 30, -(1 << 30), 12345}, {9, 5, 5}, {0, 1, 0}, 400},
    {{-4, 0, 0}, {12, 4, 5}, {1, 0, 0}, 400}, /* a whole number of bricks along x */
    {{-1, -1, -1}, {8, 8, 8}, {1, 1, 1}, 30}, /* mostly empty */
    {{2, 2, 2}, {1, 1, 1}, {0}, 20},          /* one cell */
    {{0, 0, 0}, {4, 4, 4}, {1, 0, 0}, 1},     /* one particle */
    {{0, 0, 0}, {4, 4, 4}, {1, 0, 0}, 0},
};
enum { REGIONS = sizeof regions / sizeof *regions };

/* A particle as all ranks know it. */
typedef struct known {
  uint64_t id;
  int64_t x[3];
} known;

typedef struct world {
  hc_frame frame;
  hc_domain domain;
  hc_particles particles;
  hc_cells cells;
  hc_halo halo;
  hc_neighbors list;
  hc_neighbor_search search;
  known *all; /* every particle of every rank */
  int32_t all_count;
} world;

static void world_init(world *w, const region *region, unsigned kind) {
  memset(w, 0, sizeof *w);
  for (int axis = 0; axis < 3; axis++) {
    w->frame.low[axis] = region->low[axis] * HC_CELL_UNITS;
    w->frame.period[axis] = region->periodic[axis] ? region->cells[axis] * HC_CELL_UNITS : 0;
  }
  hc_domain_init(&w->domain, &comm, &w->frame);
  hc_particles_init(&w->particles, kind, HC_FOR_ALL);
  hc_cells_init(&w->cells);
  hc_halo_init(&w->halo, &w->domain, &w->particles, 0);
  hc_neighbors_init(&w->list);
  hc_neighbor_search_init(&w->search, hc_isa_best());
}

static void world_free(world *w) {
  hc_free(w->all);
  hc_neighbors_free(&w->list);
  hc_neighbor_search_free(&w->search);
  hc_halo_free(&w->halo);
  hc_cells_free(&w->cells);
  hc_particles_free(&w->particles);
  hc_domain_free(&w->domain);
}

static void fill(world *w, const region *region) {
  hc_particles *p = &w->particles;
  for (int32_t id = 0; id < region->count; id++) {
    if ((int)(mix((uint64_t)id) % (uint64_t)comm.size) != comm.rank) continue;
    const int32_t k = p->own;
    hc_particles_resize(p, k + 1);
    p->id[k] = (uint64_t)id;
    for (int axis = 0; axis < 3; axis++)
      p->position[3 * k + axis] =
          w->frame.low[axis] +
          (int64_t)(mix((uint64_t)(3 * id + axis)) % (uint64_t)(region->cells[axis] * HC_CELL_UNITS));
  }
}

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

static void share_knowledge(world *w) {
  known *mine = hc_alloc((size_t)w->particles.own, sizeof *mine);
  for (int32_t k = 0; k < w->particles.own; k++) {
    mine[k].id = w->particles.id[k];
    memcpy(mine[k].x, &w->particles.position[3 * k], sizeof mine[k].x);
  }
  void *all;
  size_t bytes;
  hc_comm_gather_all(&comm, mine, (size_t)w->particles.own * sizeof *mine, &all, &bytes);
  hc_free(mine);
  hc_free(w->all);
  w->all = all;
  w->all_count = (int32_t)(bytes / sizeof *mine);
}

static void balance(world *w, hc_divider divider) {
  hc_domain_balance(&w->domain, divider, &(hc_work){.fluid = &w->particles, .boundary = &w->particles}, NULL);
}

static void build(world *w) {
  hc_domain_migrate(&w->domain, &w->particles);
  hc_cells_bin(&w->cells, &w->particles);
  hc_halo_mark(&w->halo, &w->cells);
  hc_cells_order(&w->cells, &w->particles);
  hc_halo_build(&w->halo, &w->cells);
  for (int32_t k = 0; k < w->particles.own; k++) w->particles.place[k].scalar = (float)w->particles.id[k];
  hc_halo_refresh(&w->halo, HC_SCALAR(place)); /* from here on a ghost's id is known */
  hc_neighbors_build(&w->list, &w->search, &w->cells, &w->particles, hc_select_all(&w->particles),
                     &(hc_neighbor_source){&w->cells, &w->particles}, 1);
  share_knowledge(w);
}

static uint64_t id_of(const world *w, int32_t index) {
  return (uint64_t)w->particles.place[index].scalar;
}

/* ---- brute force ---- */

static int64_t cell_along(int64_t units) {
  return units >> HC_CELL_BITS;
}

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
  const uint32_t *row = w->list.offset + (size_t)w->list.start[i] * HC_LIST_GROUP;
  int32_t entry = 0;
  for (int32_t k = 0; k < count; k++) {
    if (entry < w->list.count[i] && is_image(w, (int32_t)(row[entry] / sizeof(hc_record)), &found[k]))
      entry++;
    else if (found[k].required)
      return false;
  }
  return entry == w->list.count[i];
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
    const uint32_t *row = w->list.offset + (size_t)w->list.start[i] * HC_LIST_GROUP;
    for (int32_t k = 0; k < w->list.count[i]; k++)
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

/* A map that no balance would make: each of 10^3 bricks of some size has any owner. */
static void divide_wildly(world *w, int bits) {
  enum { EDGE = 10 };
  hc_map *map = &w->domain.map;
  hc_interval intervals[EDGE * EDGE * EDGE];
  for (int k = 0; k < EDGE * EDGE * EDGE; k++) {
    int64_t cell[3] = {k % EDGE, k / EDGE % EDGE, k / (EDGE * EDGE)};
    for (int axis = 0; axis < 3; axis++)
      cell[axis] = cell_along(w->frame.low[axis]) + (cell[axis] - 2) * (1 << bits);
    intervals[k].first = hc_map_brick(map, bits, cell);
    intervals[k].rank = (int32_t)(mix((uint64_t)k) % (uint64_t)comm.size);
  }
  qsort(intervals, EDGE * EDGE * EDGE, sizeof *intervals, hc_map_by(HC_ORDER_MORTON));
  hc_map_start(map, HC_ORDER_MORTON, bits);
  for (int k = 0; k < EDGE * EDGE * EDGE; k++) hc_map_add(map, intervals[k].first, intervals[k].rank);
}

START_TEST(particles_see_what_brute_force_finds) {
  for (int r = 0; r < REGIONS; r++) {
    world w;
    world_init(&w, &regions[r], r % 2 ? HC_BOUNDARY : HC_FLUID);
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
  world_init(&w, &regions[0], HC_FLUID);
  fill(&w, &regions[0]);
  build(&w);
  ck_assert(w.particles.ghosts == 0 && w.particles.border == 0);
  world_free(&w);
}
END_TEST

/* ---- refreshes ---- */

static float value_of(uint64_t id, int round, int word) {
  return (float)(mix(id * 64 + (uint64_t)(round * 4 + word)) >> 40);
}

static bool record_is(const hc_record *record, uint64_t id, int round) {
  bool good = record->scalar == value_of(id, round, 3);
  for (int axis = 0; axis < 3; axis++) good &= record->v[axis] == value_of(id, round, axis);
  return good;
}

static void set_motion(hc_particles *p, int32_t begin, int32_t end, int round) {
  for (int32_t k = begin; k < end; k++)
    p->motion[k] = (hc_record){
        .v = {value_of(p->id[k], round, 0), value_of(p->id[k], round, 1), value_of(p->id[k], round, 2)},
        .scalar = value_of(p->id[k], round, 3)};
}

/* What ghosts hold before a refresh. */
static void spoil_ghosts(hc_particles *p) {
  for (int32_t k = p->own; k < p->own + p->ghosts; k++)
    p->motion[k] = (hc_record){.v = {-1, -2, -3}, .scalar = -4};
}

START_TEST(refreshes_bring_the_owners_values) {
  for (int r = 0; r < REGIONS; r++) {
    world w;
    world_init(&w, &regions[r], HC_FLUID);
    fill(&w, &regions[r]);
    balance(&w, HC_DIVIDER_METIS);
    build(&w);
    hc_particles *p = &w.particles;
    const int32_t own = p->own, all = own + p->ghosts;
    uint64_t *id = hc_alloc((size_t)all, sizeof *id);
    hc_record *places = hc_alloc((size_t)all, sizeof *places);
    for (int32_t k = 0; k < all; k++) id[k] = id_of(&w, k);
    memcpy(places, p->place, (size_t)all * sizeof *places);
    bool good = true;

    set_motion(p, 0, own, 1);
    spoil_ghosts(p);
    hc_halo_refresh(&w.halo, HC_WHOLE(motion));
    for (int32_t k = 0; k < all; k++) good &= record_is(&p->motion[k], id[k], 1);
    EXPECT(good);

    for (int32_t k = 0; k < own; k++) p->place[k].scalar = value_of(id[k], 3, 3);
    hc_halo_refresh(&w.halo, HC_SCALAR(place));
    for (int32_t k = 0; k < all; k++) {
      good &= p->place[k].scalar == value_of(id[k], 3, 3);
      good &= memcmp(p->place[k].x, places[k].x, sizeof places[k].x) == 0;
    }
    EXPECT(good);

    /* Interior values may change under way. */
    set_motion(p, 0, p->border, 4);
    spoil_ghosts(p);
    hc_halo_begin(&w.halo, HC_WHOLE(motion));
    set_motion(p, p->border, own, 4);
    hc_halo_end(&w.halo);
    for (int32_t k = 0; k < all; k++) good &= record_is(&p->motion[k], id[k], 4);
    EXPECT(good);
    hc_free(id);
    hc_free(places);
    world_free(&w);
  }
}
END_TEST

/* Many refreshes of different fields with nothing between them. */
START_TEST(refreshes_keep_their_order) {
  world w;
  world_init(&w, &regions[3], HC_FLUID);
  fill(&w, &regions[3]);
  balance(&w, HC_DIVIDER_METIS);
  build(&w);
  hc_particles *p = &w.particles;
  uint64_t *id = hc_alloc((size_t)p->ghosts, sizeof *id);
  for (int32_t k = 0; k < p->ghosts; k++) id[k] = id_of(&w, p->own + k);
  bool good = true;
  for (int round = 0; round < 60; round++) {
    const hc_field_set field = mix((uint64_t)round) % 2 ? HC_WHOLE(motion) : HC_SCALAR(place);
    set_motion(p, 0, p->own, round);
    for (int32_t k = 0; k < p->own; k++) p->place[k].scalar = value_of(p->id[k], round, 3);
    hc_halo_refresh(&w.halo, field);
    for (int32_t k = 0; k < p->ghosts; k++) {
      const hc_record *motion = &p->motion[p->own + k];
      if (field == HC_SCALAR(place)) good &= p->place[p->own + k].scalar == value_of(id[k], round, 3);
      if (field == HC_WHOLE(motion)) good &= record_is(motion, id[k], round);
    }
  }
  EXPECT(good);
  hc_free(id);
  world_free(&w);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("halo");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, particles_see_what_brute_force_finds);
  tcase_add_test(tests, one_rank_alone_has_no_ghosts);
  tcase_add_test(tests, refreshes_bring_the_owners_values);
  tcase_add_test(tests, refreshes_keep_their_order);
  return run_mpi_tests("halo", tests);
}
