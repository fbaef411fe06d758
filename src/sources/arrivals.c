#include "arrivals.h"

#include "base/check.h"
#include "base/memory.h"

#include <string.h>

hc_arrival *hc_arrivals_add(hc_arrivals *arrivals, uint64_t id, const int64_t x[3]) {
  hc_reserve((void **)&arrivals->at, &arrivals->room, 2 * arrivals->count + 64, arrivals->count,
             sizeof *arrivals->at);
  hc_arrival *const to = &arrivals->at[arrivals->count++];
  *to = (hc_arrival){.id = id};
  memcpy(to->x, x, sizeof to->x);
  return to;
}

void hc_arrivals_append(const hc_arrivals *arrivals, hc_particles *fluid) {
  const int32_t first = fluid->own;
  HC_CHECK(arrivals->count < (size_t)(INT32_MAX - first), "a rank cannot hold %zu particles more than %d",
           arrivals->count, first);
  hc_particles_resize(fluid, first + (int32_t)arrivals->count);
  for (size_t k = 0; k < arrivals->count; k++) {
    const size_t i = (size_t)first + k;
    fluid->id[i] = arrivals->at[k].id;
    memcpy(&fluid->position[3 * i], arrivals->at[k].x, sizeof arrivals->at[k].x);
    memcpy(&fluid->velocity[3 * i], arrivals->at[k].velocity, sizeof arrivals->at[k].velocity);
  }
}

void hc_arrivals_free(hc_arrivals *arrivals) {
  hc_free(arrivals->at);
  memset(arrivals, 0, sizeof *arrivals);
}

double hc_arrivals_square(const hc_frame *frame, const hc_particles *particles, int32_t particle,
                          const int64_t x[3]) {
  const int32_t *const other = particles->place[particle].x;
  double square = 0.0;
  for (int a = 0; a < 3; a++) {
    const double d = (double)(int32_t)((uint32_t)(uint64_t)x[a] - (uint32_t)other[a]) * frame->unit[a];
    square += d * d;
  }
  return square;
}

bool hc_vicinity_find(hc_vicinity *vicinity, const hc_cells *cells, const int64_t x[3], int *cell) {
  hc_brick brick;
  *cell = hc_cell_of(x, &brick);
  if (!vicinity->known || !hc_brick_equal(brick, vicinity->brick)) {
    vicinity->any = hc_brick_set_around(&cells->bricks, brick, vicinity->adjacent);
    vicinity->brick = brick;
    vicinity->known = true;
  }
  return vicinity->any;
}

bool hc_arrivals_blocked(const hc_frame *frame, const hc_cells *cells, const hc_particles *particles,
                         hc_vicinity *vicinity, const int64_t x[3], double clearance) {
  int cell;
  if (!hc_vicinity_find(vicinity, cells, x, &cell)) return false;
  for (int k = 0; k < HC_ADJACENT; k++) {
    int there;
    const int way = (k + HC_ADJACENT_SELF) % HC_ADJACENT; /* who blocks is mostly in the place's own cell */
    const int32_t found = hc_cells_next(vicinity->adjacent, cell, way, &there);
    if (found < 0) continue;
    const int32_t begin = cells->begin[found][there], end = begin + cells->count[found][there];
    for (int32_t j = begin; j < end; j++)
      if (hc_arrivals_square(frame, particles, j, x) < clearance * clearance) return true;
  }
  return false;
}
