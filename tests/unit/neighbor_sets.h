/* Sets of particles in cells, and their lists against brute force: what tests of neighbour lists are made
 * with. Included by one test each. */
#ifndef HC_NEIGHBOR_SETS_H
#define HC_NEIGHBOR_SETS_H

#include "base/memory.h"
#include "space/neighbors.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* splitmix64's mixer. */
static inline uint64_t mix(uint64_t value) {
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

static inline void set_init(set *set, unsigned kind) {
  hc_particles_init(&set->particles, kind, HC_FOR_ALL);
  hc_cells_init(&set->cells);
}

static inline void set_free(set *set) {
  hc_particles_free(&set->particles);
  hc_cells_free(&set->cells);
}

static inline void sort(set *set) {
  hc_cells_bin(&set->cells, &set->particles);
  hc_cells_order(&set->cells, &set->particles);
}

/* `count` particles at random in a box of edges `size` in cells from `corner`, in units; then all shifted by
 * whole cells. */
static inline void scatter(set *set, uint64_t seed, int32_t count, const double size[3],
                           const int64_t corner[3], const int64_t shift[3]) {
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

static inline double distance(const hc_particles *a, int32_t i, const hc_particles *b, int32_t j) {
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

static inline int in_list_order(const void *a, const void *b) {
  const candidate *p = a, *q = b;
  for (int k = 0; k < 3; k++)
    if (p->cell[k] != q->cell[k]) return p->cell[k] < q->cell[k] ? -1 : 1;
  return p->id < q->id ? -1 : p->id > q->id;
}

/* All particles of the source within 1.001 of the support radius, in the order of the list; those within the
 * radius are required. */
static inline int32_t find_candidates(const hc_particles *target, int32_t i, const hc_particles *source,
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
static inline bool row_agrees(const hc_neighbors *list, int32_t i, const candidate *candidates,
                              int32_t count) {
  const uint32_t *row = hc_list_row(list, i);
  int32_t entry = 0;
  for (int32_t k = 0; k < count; k++) {
    if (entry < hc_list_count(list, i) && row[entry] == (uint32_t)candidates[k].index * sizeof(hc_record))
      entry++;
    else if (candidates[k].required)
      return false;
  }
  return entry == hc_list_count(list, i);
}

/* Entries that fill up groups are the particle itself, or a neighbour; rows stand one behind the other. */
static inline bool layout_is_right(const hc_neighbors *list, const set *target, const set *source) {
  const int32_t own = target->particles.own;
  bool good = own == 0 || list->row[0] < HC_LIST_GROUP;
  int64_t pairs = 0;
  for (int32_t i = 0; i < own; i++) {
    const uint32_t *row = hc_list_row(list, i);
    const int32_t entries = hc_list_entries(list, i);
    good &= entries >= hc_list_count(list, i) && entries < hc_list_count(list, i) + HC_LIST_GROUP;
    for (int32_t k = hc_list_count(list, i); k < entries; k++)
      good &= row[k] == (target == source ? (uint32_t)i * sizeof(hc_record) : row[0]);
    pairs += hc_list_count(list, i);
  }
  for (int k = 0; k < 16; k++) /* what a vector may load behind the last row */
    good &= list->offset[hc_list_begin(list, own) + (uint32_t)k] <
            (uint32_t)(source->particles.own + HC_SPARE) * sizeof(hc_record);
  return good && pairs == list->pairs;
}

static inline void check_list(const hc_neighbors *list, const set *target, const set *source,
                              const char *isa) {
  candidate *const found = hc_alloc((size_t)source->particles.own, sizeof *found);
  for (int32_t i = 0; i < target->particles.own; i++) {
    const int32_t count = find_candidates(&target->particles, i, &source->particles, found);
    if (!row_agrees(list, i, found, count))
      ck_abort_msg("%s: the %d neighbours of particle %d are not among the %d expected, in order", isa,
                   hc_list_count(list, i), i, count);
  }
  ck_assert_msg(layout_is_right(list, target, source), "%s", isa);
  hc_free(found);
}

static inline bool same_list(const hc_neighbors *a, const hc_neighbors *b, int32_t own) {
  return a->pairs == b->pairs && memcmp(a->row, b->row, ((size_t)own + 1) * sizeof *a->row) == 0 &&
         memcmp(a->offset, b->offset, hc_list_begin(a, own) * sizeof *a->offset) == 0;
}

static inline void build(hc_neighbors *list, hc_isa isa, const set *target, const set *source) {
  hc_neighbor_search search;
  hc_neighbor_search_init(&search, isa);
  hc_neighbors_init(list);
  hc_neighbors_build(list, &search, &target->cells, &target->particles, hc_select_all(&target->particles),
                     &(hc_neighbor_source){&source->cells, &source->particles}, 1);
  hc_neighbor_search_free(&search);
}

/* Builds the list with all instruction sets: one agrees with brute force, the others with it. */
static inline hc_neighbors checked_list(const set *target, const set *source) {
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

#endif
