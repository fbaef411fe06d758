/* The occupied part of the unbounded cell grid, as one rank sees it.
 *
 * Cells are grouped in bricks of 4 x 4 x 4; only bricks that hold a particle (own or ghost) exist, found
 * through a hash table, so memory follows the particles and not the extent of the world. A cell's own
 * particles are one range of the particle arrays, ids ascending; so are a ghost cell's. */
#ifndef HC_CELLS_H
#define HC_CELLS_H

#include "brick_set.h"
#include "frame.h"
#include "particles/particles.h"

enum {
  HC_BRICK_BITS = 2,
  HC_BRICK_EDGE = 1 << HC_BRICK_BITS,
  HC_BRICK_CELLS = HC_BRICK_EDGE * HC_BRICK_EDGE * HC_BRICK_EDGE /* a 64-bit mask has a bit for each */
};

typedef struct hc_cells {
  hc_brick_set bricks;              /* by number, which is the index of what follows */
  uint64_t *border;                 /* bit per cell: own cells next to another rank's or an image's */
  int32_t (*begin)[HC_BRICK_CELLS]; /* first particle of each cell, */
  int32_t (*count)[HC_BRICK_CELLS]; /* and how many */
  int32_t *own_cells;               /* occupied own cells as brick * 64 + cell, in memory order */
  int32_t own_cell_count;
  size_t brick_capacity[3], own_cells_capacity;
} hc_cells;

static inline int hc_cell_in_brick(int x, int y, int z) {
  return x | y << HC_BRICK_BITS | z << (2 * HC_BRICK_BITS);
}

/* The brick and the cell in it that hold a position. */
static inline int hc_cell_of(const int64_t position[3], hc_brick *brick) {
  int part[3];
  for (int axis = 0; axis < 3; axis++) {
    const int64_t cell = hc_frame_cell(position[axis]);
    brick->x[axis] = (int32_t)(cell >> HC_BRICK_BITS);
    part[axis] = (int)(cell & (HC_BRICK_EDGE - 1));
  }
  return hc_cell_in_brick(part[0], part[1], part[2]);
}

void hc_cells_init(hc_cells *cells);
void hc_cells_free(hc_cells *cells);

/* The brick's index, or -1; the second form adds the brick with empty cells if it is new. Local. */
int32_t hc_cells_find(const hc_cells *cells, hc_brick brick);
int32_t hc_cells_insert(hc_cells *cells, hc_brick brick);

/* The cell that lies in direction `way` (x fastest) of cell `cell` of the brick that `adjacent` is around:
 * its brick's index, or -1, and its number there. */
static inline int32_t hc_cells_next(const int32_t adjacent[HC_ADJACENT], int cell, int way, int *there) {
  const int next[3] = {(cell & 3) + way % 3 - 1, (cell >> HC_BRICK_BITS & 3) + way / 3 % 3 - 1,
                       (cell >> (2 * HC_BRICK_BITS)) + way / 9 - 1};
  *there = hc_cell_in_brick(next[0] & 3, next[1] & 3, next[2] & 3);
  return adjacent[(next[0] + HC_BRICK_EDGE) / HC_BRICK_EDGE +
                  3 * ((next[1] + HC_BRICK_EDGE) / HC_BRICK_EDGE) +
                  9 * ((next[2] + HC_BRICK_EDGE) / HC_BRICK_EDGE)];
}

/* Has a cell, or one around it, any particles? `adjacent`: of the bricks around the cell's. */
static inline bool hc_cells_any_around(const hc_cells *cells, const int32_t adjacent[HC_ADJACENT], int cell) {
  for (int way = 0; way < HC_ADJACENT; way++) {
    int there;
    const int32_t brick = hc_cells_next(adjacent, cell, way, &there);
    if (brick >= 0 && cells->count[brick][there] > 0) return true;
  }
  return false;
}

/* The sort, in two halves, between which the caller may set border bits of the occupied cells. Local.
 * Bin: forgets everything and finds each own particle's cell. Order: permutes the particles into border cells
 * first, then the others, each row-major (z, y, x), ids ascending in a cell; sets begin, count, own_cells,
 * particles->border; fills particles->place. No ghosts afterwards. Between the two the particles' scratch is
 * taken. */
void hc_cells_bin(hc_cells *cells, hc_particles *particles);
void hc_cells_order(hc_cells *cells, hc_particles *particles);

/* Fills `place` of own particles from their positions, scalar 0. Local. */
void hc_place_refresh(hc_particles *particles);

#endif
