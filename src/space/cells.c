#include "cells.h"

#include "base/check.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void hc_cells_init(hc_cells *cells) {
  memset(cells, 0, sizeof *cells);
  hc_brick_set_init(&cells->bricks);
}

void hc_cells_free(hc_cells *cells) {
  hc_brick_set_free(&cells->bricks);
  hc_free(cells->border);
  hc_free(cells->begin);
  hc_free(cells->count);
  hc_free(cells->own_cells);
  memset(cells, 0, sizeof *cells);
}

int32_t hc_cells_find(const hc_cells *cells, hc_brick brick) {
  return hc_brick_set_find(&cells->bricks, brick);
}

int32_t hc_cells_insert(hc_cells *cells, hc_brick brick) {
  const int32_t before = cells->bricks.count, index = hc_brick_set_add(&cells->bricks, brick);
  if (index < before) return index;
  const size_t old = (size_t)index, now = old + 1;
  size_t *capacity = cells->brick_capacity;
  hc_reserve((void **)&cells->border, &capacity[0], now, old, sizeof *cells->border);
  hc_reserve((void **)&cells->begin, &capacity[1], now, old, sizeof *cells->begin);
  hc_reserve((void **)&cells->count, &capacity[2], now, old, sizeof *cells->count);
  cells->border[index] = 0;
  memset(cells->count[index], 0, sizeof cells->count[index]);
  return index;
}

/* The sort's work space, in the particles' scratch: the new order of each, and its cell (brick * 64 + cell).
 */
static int32_t *order_of(hc_particles *particles) {
  return hc_particles_scratch(particles, 3 * sizeof(int32_t));
}
static int32_t *slots_of(hc_particles *particles) {
  return order_of(particles) + particles->own;
}

void hc_cells_bin(hc_cells *cells, hc_particles *particles) {
  const int32_t own = particles->own;
  hc_brick_set_clear(&cells->bricks);
  cells->own_cell_count = 0;
  int32_t *slot = slots_of(particles);
  hc_brick last = {{0, 0, 0}};
  int32_t index = -1;
  for (int32_t k = 0; k < own; k++) {
    hc_brick brick;
    const int cell = hc_cell_of(&particles->position[3 * (size_t)k], &brick);
    if (index < 0 || !hc_brick_equal(brick, last)) {
      index = hc_cells_insert(cells, brick);
      last = brick;
    }
    HC_CHECK(index < INT32_MAX / HC_BRICK_CELLS, "too many bricks on one rank: %d", index);
    slot[k] = index * HC_BRICK_CELLS + cell;
    cells->count[index][cell]++;
  }
}

typedef struct placed_brick {
  hc_brick brick;
  int32_t index;
} placed_brick;

static int by_row(const void *a, const void *b) {
  const int32_t *p = ((const placed_brick *)a)->brick.x, *q = ((const placed_brick *)b)->brick.x;
  for (int axis = 2; axis >= 0; axis--)
    if (p[axis] != q[axis]) return p[axis] < q[axis] ? -1 : 1;
  return 0;
}

/* Length of the run of bricks that share z (and y, if `rows`) with the first. */
static int32_t run_length(const placed_brick *sorted, int32_t count, bool rows) {
  int32_t length = 1;
  while (length < count && sorted[length].brick.x[2] == sorted[0].brick.x[2] &&
         (!rows || sorted[length].brick.x[1] == sorted[0].brick.x[1]))
    length++;
  return length;
}

/* Appends the occupied cells of one row of bricks at (y, z) within the bricks, of the wanted class, to
 * own_cells and gives them the next places. */
static int32_t place_row(hc_cells *cells, const placed_brick *row, int32_t length, int y, int z, bool border,
                         int32_t next) {
  for (int32_t k = 0; k < length; k++) {
    const int32_t index = row[k].index;
    const uint64_t wanted = border ? cells->border[index] : ~cells->border[index];
    for (int x = 0; x < HC_BRICK_EDGE; x++) {
      const int cell = hc_cell_in_brick(x, y, z);
      const int32_t count = cells->count[index][cell];
      if (count == 0 || !(wanted >> cell & 1)) continue;
      cells->begin[index][cell] = next;
      next += count;
      cells->own_cells[cells->own_cell_count++] = index * HC_BRICK_CELLS + cell;
    }
  }
  return next;
}

/* Gives all cells of one class their places, row-major over the whole grid. */
static int32_t place_cells(hc_cells *cells, const placed_brick *sorted, bool border, int32_t next) {
  for (int32_t plane = 0; plane < cells->bricks.count;) {
    const int32_t plane_length = run_length(sorted + plane, cells->bricks.count - plane, false);
    for (int z = 0; z < HC_BRICK_EDGE; z++) {
      for (int32_t row = plane; row < plane + plane_length;) {
        const int32_t length = run_length(sorted + row, plane + plane_length - row, true);
        for (int y = 0; y < HC_BRICK_EDGE; y++)
          next = place_row(cells, sorted + row, length, y, z, border, next);
        row += length;
      }
    }
    plane += plane_length;
  }
  return next;
}

/* Insertion is the fastest for what a cell holds at rest; an overfull one is halved and merged. */
static void sort_by_id(int32_t *order, int32_t count, const uint64_t *id) {
  enum { FEW = 64 };
  if (count > FEW) {
    const int32_t half = count / 2;
    sort_by_id(order, half, id);
    sort_by_id(order + half, count - half, id);
    int32_t *left = hc_alloc((size_t)half, sizeof *left);
    memcpy(left, order, (size_t)half * sizeof *left);
    for (int32_t a = 0, b = half, to = 0; a < half; to++)
      order[to] = b < count && id[order[b]] < id[left[a]] ? order[b++] : left[a++];
    hc_free(left);
    return;
  }
  for (int32_t k = 1; k < count; k++) {
    const int32_t moving = order[k];
    int32_t hole = k;
    for (; hole > 0 && id[order[hole - 1]] > id[moving]; hole--) order[hole] = order[hole - 1];
    order[hole] = moving;
  }
}

void hc_place_refresh(hc_particles *particles) {
  const int64_t *restrict position = particles->position;
  hc_record *restrict place = particles->place;
  for (int32_t k = 0; k < particles->own; k++) {
    for (int axis = 0; axis < 3; axis++) place[k].x[axis] = (int32_t)(uint32_t)position[3 * (size_t)k + axis];
    place[k].scalar = 0.0f;
  }
}

void hc_cells_order(hc_cells *cells, hc_particles *particles) {
  const int32_t own = particles->own;
  placed_brick *sorted = hc_alloc((size_t)cells->bricks.count, sizeof *sorted);
  size_t occupied = 0;
  for (int32_t k = 0; k < cells->bricks.count; k++) {
    sorted[k] = (placed_brick){cells->bricks.bricks[k], k};
    for (int cell = 0; cell < HC_BRICK_CELLS; cell++) occupied += cells->count[k][cell] > 0;
  }
  qsort(sorted, (size_t)cells->bricks.count, sizeof *sorted, by_row);

  cells->own_cell_count = 0;
  hc_reserve((void **)&cells->own_cells, &cells->own_cells_capacity, occupied, 0, sizeof *cells->own_cells);
  const int32_t border = place_cells(cells, sorted, true, 0);
  const int32_t end = place_cells(cells, sorted, false, border);
  HC_CHECK(end == own, "every own particle must have a cell: %d of %d", end, own);
  hc_free(sorted);

  int32_t *order = order_of(particles);
  const int32_t *slots = slots_of(particles);
  int32_t *begin = (int32_t *)cells->begin, *count = (int32_t *)cells->count; /* by slot */
  for (int32_t k = 0; k < own; k++) order[begin[slots[k]]++] = k;
  for (int32_t k = 0; k < cells->own_cell_count; k++) {
    const int32_t slot = cells->own_cells[k];
    begin[slot] -= count[slot];
    sort_by_id(order + begin[slot], count[slot], particles->id);
  }
  hc_particles_permute(particles, order, own);
  hc_particles_resize(particles, own);
  particles->border = border;
  hc_place_refresh(particles);
}
