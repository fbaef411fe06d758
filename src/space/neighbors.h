/* Neighbour lists: for each selected own particle the particles of some stores within the support radius.
 *
 * Compressed rows in groups of eight entries; the last group is filled up with any valid entry, and sweeps
 * mask those lanes by `count`, unless the particle itself, which fills up the lists of a set into itself,
 * adds nothing. Order: the 27 cells around with x outermost, then z, then y, ids ascending within a cell: the
 * canonical order of every sum over neighbours. */
#ifndef HC_NEIGHBORS_H
#define HC_NEIGHBORS_H

#include "base/isa.h"
#include "cells.h"
#include "selection.h"

enum {
  HC_LIST_GROUP = 8,
  HC_CUT_EDGE = 4096, /* a cell edge as the search measures */
  HC_NEIGHBOR_SLACK = 32,
  HC_NEIGHBOR_SOURCES = 2, /* stores that one list may lead to */
  HC_CELL_MOST = 4096      /* particles of a cell that get neighbours: at rest there are some ten */
};

typedef struct hc_neighbors {
  uint32_t *row; /* row r of the selection: where its entries begin, a multiple of HC_LIST_GROUP, and in the
                    bits below how many fill up its last group; one more behind the last row */
  uint32_t *
      offset; /* 16 * index: the place of the neighbour's record in bytes; sixteen readable ones at the end */
  int64_t pairs;   /* entries of all rows that do not fill up */
  int32_t crowded; /* a particle in a cell that holds more than HC_CELL_MOST, whose rows are left empty; -1:
                      none */
  size_t row_capacity, offset_capacity;
} hc_neighbors;

static inline uint32_t hc_list_begin(const hc_neighbors *list, int32_t row) {
  return list->row[row] & ~(uint32_t)(HC_LIST_GROUP - 1);
}

/* The entries of a row, how many they are with those that fill up the last group, and without. */
static inline const uint32_t *hc_list_row(const hc_neighbors *list, int32_t row) {
  return list->offset + hc_list_begin(list, row);
}
static inline int32_t hc_list_entries(const hc_neighbors *list, int32_t row) {
  return (int32_t)(hc_list_begin(list, row + 1) - hc_list_begin(list, row));
}
static inline int32_t hc_list_count(const hc_neighbors *list, int32_t row) {
  return hc_list_entries(list, row) - (int32_t)(list->row[row] & (HC_LIST_GROUP - 1));
}

/* Have the rows [begin, end) no entries? */
static inline bool hc_list_empty(const hc_neighbors *list, int32_t begin, int32_t end) {
  return hc_list_begin(list, begin) == hc_list_begin(list, end);
}

void hc_neighbors_init(hc_neighbors *list);
void hc_neighbors_free(hc_neighbors *list);

/* What a build works with, kept between builds for its memory. */
typedef struct hc_neighbor_search {
  hc_isa isa;
  int32_t reach;   /* of lists, HC_CUT_EDGE at most, which it is at first */
  int32_t *xy, *z; /* candidates, packed: positions cut to 16 bits, see neighbors_isa.c */
  uint32_t *offset;
  size_t candidate_capacity;
  int32_t (*adjacent)[HC_ADJACENT]; /* per source and target brick: the source's bricks around it, or -1 */
  char *known;                      /* of which target bricks */
  size_t adjacent_capacity, known_capacity;
} hc_neighbor_search;

void hc_neighbor_search_init(hc_neighbor_search *search, hc_isa isa);
void hc_neighbor_search_free(hc_neighbor_search *search);

/* Particles that a list leads to. */
typedef struct hc_neighbor_source {
  const hc_cells *cells;
  const hc_particles *particles;
} hc_neighbor_source;

/* Builds the list of selected own particles of `target` into all particles (own and ghosts) of the sources.
 * One source may be the target itself: then a particle is no neighbour of itself. Two are a store and the one
 * joined to it (hc_particles_join), offsets are then those among their common records, and within a cell both
 * stand together in the order of motion.scalar, the number of a wall: so the canonical order does not depend
 * on which store a wall is in. `place` of all, and that scalar of two, must be current. Local. Before: cells
 * ordered, ghosts entered. */
void hc_neighbors_build(hc_neighbors *list, hc_neighbor_search *search, const hc_cells *target_cells,
                        const hc_particles *target, hc_selection selection, const hc_neighbor_source *sources,
                        int source_count);

/* Makes the list of a selection by an index one that has a row for each of `own` particles, at its number:
 * those of others are empty. Local. */
void hc_neighbors_spread(hc_neighbors *list, hc_selection selection, int32_t own);

/* The loops that differ between instruction sets (neighbors_isa.c). */
typedef struct hc_neighbor_loops {
  /* Appends records [begin, begin + count) to the candidates at `end`. May read and write HC_NEIGHBOR_SLACK
   * further. */
  void (*append)(hc_neighbor_search *search, int32_t end, const hc_record *place, int32_t begin,
                 int32_t count);
  /* Writes the rows of a part of the selection from candidates [begin, end) at list->offset + used, where
   * there must be room for all candidates and HC_NEIGHBOR_SLACK more for each. `same`: a particle is not its
   * own neighbour. Returns the new `used`. */
  size_t (*rows)(hc_neighbors *list, const hc_neighbor_search *search, int32_t begin, int32_t end,
                 const hc_record *place, hc_selection rows, bool same, size_t used);
} hc_neighbor_loops;

const hc_neighbor_loops *hc_neighbor_loops_portable(void);
const hc_neighbor_loops *hc_neighbor_loops_avx2(void);
const hc_neighbor_loops *hc_neighbor_loops_avx512(void);

#endif
