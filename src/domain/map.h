/* The map from cells to ranks: ownership bricks in some order, cut into intervals.
 *
 * An ownership brick is a cube of 2^bits cells along each edge, whatever the bricks of hc_cells are; `bits`
 * is chosen anew with each decomposition. Bricks stand in one of four orders: row by row with x, y or z
 * outermost (slabs), or Morton's (parts of any shape). A sorted list names the brick with which an interval
 * begins and the rank that owns it: so every cell of the unbounded world has an owner, also one that has
 * never held a particle, by a rule that every rank evaluates alone, and the memory follows the number of
 * intervals. All functions are local. */
#ifndef HC_MAP_H
#define HC_MAP_H

#include "space/cells.h"

enum { HC_MAP_MOST_BITS = 5, HC_MAP_MIXED = -1 };

typedef enum hc_map_order { HC_ORDER_X, HC_ORDER_Y, HC_ORDER_Z, HC_ORDER_MORTON } hc_map_order;

/* From this brick on, up to the next interval's, `rank` owns. */
typedef struct hc_interval {
  hc_brick first; /* ownership brick */
  int32_t rank;
} hc_interval;

typedef struct hc_map {
  int64_t origin[3]; /* cell from which ownership bricks count, a multiple of the largest edge */
  int32_t bits;
  hc_map_order order;
  hc_interval *intervals; /* ascending */
  int32_t count;          /* 0: rank 0 owns all */
  size_t capacity;
} hc_map;

/* Counts bricks from near this cell, so that they do not depend on where in the world a scene lies. */
void hc_map_init(hc_map *map, const int64_t cell[3]);
void hc_map_free(hc_map *map);

/* Forgets the intervals; then intervals are added in ascending order. One that continues the last one's rank
 * adds nothing. */
void hc_map_start(hc_map *map, hc_map_order order, int bits);
void hc_map_add(hc_map *map, hc_brick first, int rank);

/* < 0, 0, > 0 as a stands before, at or behind b. */
int hc_map_compare(hc_map_order order, const hc_brick *a, const hc_brick *b);

/* For qsort over structures that begin with an hc_brick. */
typedef int (*hc_map_comparison)(const void *, const void *);
hc_map_comparison hc_map_by(hc_map_order order);

/* The ownership brick of a cell for bricks of some size; bricks beyond 2^31 of them from the origin count as
 * the last one there. */
static inline hc_brick hc_map_brick(const hc_map *map, int bits, const int64_t cell[3]) {
  hc_brick brick;
  for (int axis = 0; axis < 3; axis++) {
    const int64_t x = (cell[axis] - map->origin[axis]) >> bits;
    brick.x[axis] = (int32_t)(x < INT32_MIN ? INT32_MIN : x > INT32_MAX ? INT32_MAX : x);
  }
  return brick;
}

/* The rank that owns an ownership brick. */
int hc_map_owner(const hc_map *map, hc_brick brick);

/* The rank that owns all cells of a box, both corners included; HC_MAP_MIXED if that is not plain to see:
 * every order is monotonous, so that a box lies between its corners. */
int hc_map_owner_of_box(const hc_map *map, const int64_t low[3], const int64_t high[3]);

#endif
