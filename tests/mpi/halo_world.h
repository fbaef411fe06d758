/* Particles of all ranks in a box of cells, with their halo and their list: what the tests of the halo are
 * made with. */
#ifndef HC_HALO_WORLD_H
#define HC_HALO_WORLD_H

#include "mpi_test.h"

#include "base/memory.h"
#include "domain/halo.h"
#include "space/neighbors.h"

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

static inline void world_init(world *w, const region *region, unsigned kind, int tag) {
  memset(w, 0, sizeof *w);
  for (int axis = 0; axis < 3; axis++) {
    w->frame.low[axis] = region->low[axis] * HC_CELL_UNITS;
    w->frame.period[axis] = region->periodic[axis] ? region->cells[axis] * HC_CELL_UNITS : 0;
  }
  hc_domain_init(&w->domain, &comm, &w->frame, 0);
  hc_particles_init(&w->particles, kind, HC_FOR_ALL);
  hc_cells_init(&w->cells);
  hc_halo_init(&w->halo, &w->domain, &w->particles, tag);
  hc_neighbors_init(&w->list);
  hc_neighbor_search_init(&w->search, hc_isa_best());
}

static inline void world_free(world *w) {
  hc_free(w->all);
  hc_neighbors_free(&w->list);
  hc_neighbor_search_free(&w->search);
  hc_halo_free(&w->halo);
  hc_cells_free(&w->cells);
  hc_particles_free(&w->particles);
  hc_domain_free(&w->domain);
}

static inline void fill(world *w, const region *region) {
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

static inline void share_knowledge(world *w) {
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

static inline void balance(world *w, hc_divider divider) {
  hc_domain_balance(&w->domain, divider, &(hc_work){.fluid = &w->particles, .boundary = &w->particles}, NULL);
}

static inline void build(world *w) {
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

static inline uint64_t id_of(const world *w, int32_t index) {
  return (uint64_t)w->particles.place[index].scalar;
}

static inline int64_t cell_along(int64_t units) {
  return units >> HC_CELL_BITS;
}

/* A map that no balance would make: each of 10^3 bricks of some size has any owner. */
static inline void divide_wildly(world *w, int bits) {
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

#endif
