#include "fringe.h"

#include "base/memory.h"
#include "brick_set.h"

#include <stdlib.h>

/* How far the fringe reaches, in cells, but at least one brick. */
enum { FRINGE_CELLS = 4 };

/* Owned bricks while the fringe grows. */
typedef struct fringe {
  hc_brick_set set;
  int32_t *owner;
  size_t capacity;
} fringe;

static void add(fringe *fringe, hc_brick brick, int32_t owner) {
  const int32_t before = fringe->set.count;
  if (hc_brick_set_add(&fringe->set, brick) < before) return; /* somebody's already */
  hc_reserve((void **)&fringe->owner, &fringe->capacity, (size_t)before + 1, (size_t)before,
             sizeof *fringe->owner);
  fringe->owner[before] = owner;
}

/* The empty neighbours of brick k that lie `axes` axes away. */
static void grow_brick(fringe *fringe, int32_t k, int axes) {
  const hc_brick brick = fringe->set.bricks[k];
  for (int way = 0; way < HC_ADJACENT; way++) {
    const int step[3] = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
    if (abs(step[0]) + abs(step[1]) + abs(step[2]) != axes) continue;
    hc_brick next = brick;
    bool inside = true;
    for (int axis = 0; axis < 3; axis++)
      inside &= !__builtin_add_overflow(next.x[axis], step[axis], &next.x[axis]);
    if (inside) add(fringe, next, fringe->owner[k]);
  }
}

/* Layer by layer, in each the nearest ways first. */
static void grow(fringe *fringe, const hc_bricks *bricks, int layers) {
  int32_t begin = 0;
  for (int layer = 0; layer < layers; layer++) {
    const int32_t end = fringe->set.count;
    for (int axes = 1; axes <= 3; axes++)
      for (int32_t k = begin; k < end; k++)
        if (layer > 0 || bricks->brick[k].fluid > 0) grow_brick(fringe, k, axes);
    begin = end;
  }
}

void hc_fringe_fill(hc_map *map, const hc_bricks *bricks, const int32_t *part) {
  fringe fringe = {.owner = NULL};
  hc_brick_set_init(&fringe.set);
  for (int32_t k = 0; k < bricks->count; k++) add(&fringe, bricks->brick[k].brick, part[k]);
  const int layers = FRINGE_CELLS >> map->bits;
  grow(&fringe, bricks, layers > 1 ? layers : 1);
  hc_interval *owned = hc_alloc((size_t)fringe.set.count, sizeof *owned);
  for (int32_t k = 0; k < fringe.set.count; k++)
    owned[k] = (hc_interval){fringe.set.bricks[k], fringe.owner[k]};
  qsort(owned, (size_t)fringe.set.count, sizeof *owned, hc_map_by(map->order));
  for (int32_t k = 0; k < fringe.set.count; k++) hc_map_add(map, owned[k].first, owned[k].rank);
  hc_free(owned);
  hc_free(fringe.owner);
  hc_brick_set_free(&fringe.set);
}
