#include "fringe.h"

#include "base/memory.h"

#include <stdlib.h>

/* How far the fringe reaches, in cells but at least in bricks: over faces alone, two steps lead to an edge.
 */
enum { FRINGE_CELLS = 4, LEAST_LAYERS = 2 };

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

/* Gives the empty bricks behind brick k's faces to its owner. */
static void grow_brick(fringe *fringe, int32_t k) {
  for (int face = 0; face < HC_GRAPH_FACES; face++) {
    hc_brick next = fringe->set.bricks[k];
    int32_t *x = &next.x[face / 2];
    if (!__builtin_add_overflow(*x, face % 2 ? 1 : -1, x)) add(fringe, next, fringe->owner[k]);
  }
}

static void grow(fringe *fringe, const hc_bricks *bricks, const hc_graph *graph, int layers) {
  for (idx_t v = 0; v < graph->count; v++)
    if (bricks->brick[graph->first[v]].fluid > 0 && graph->start[v + 1] - graph->start[v] < HC_GRAPH_FACES)
      grow_brick(fringe, graph->first[v]);
  int32_t begin = bricks->count;
  for (int layer = 1; layer < layers; layer++) {
    const int32_t end = fringe->set.count;
    for (int32_t k = begin; k < end; k++) grow_brick(fringe, k);
    begin = end;
  }
}

void hc_fringe_fill(hc_map *map, const hc_bricks *bricks, const hc_graph *graph, const int32_t *part) {
  fringe fringe = {.owner = NULL};
  hc_brick_set_init(&fringe.set);
  for (int32_t k = 0; k < bricks->count; k++) add(&fringe, bricks->brick[k].brick, part[k]);
  const int layers = FRINGE_CELLS >> map->bits;
  grow(&fringe, bricks, graph, layers > LEAST_LAYERS ? layers : LEAST_LAYERS);
  hc_interval *owned = hc_alloc((size_t)fringe.set.count, sizeof *owned);
  for (int32_t k = 0; k < fringe.set.count; k++)
    owned[k] = (hc_interval){fringe.set.bricks[k], fringe.owner[k]};
  qsort(owned, (size_t)fringe.set.count, sizeof *owned, hc_map_by(map->order));
  for (int32_t k = 0; k < fringe.set.count; k++) hc_map_add(map, owned[k].first, owned[k].rank);
  hc_free(owned);
  hc_free(fringe.owner);
  hc_brick_set_free(&fringe.set);
}
