#include "graph.h"

#include "base/memory.h"
#include "brick_set.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* METIS adds weights up in its own integers: all of them together stay below this. */
static const double LARGEST_TOTAL = 1 << 30;

/* A ghost of a fluid particle is refreshed many times a step, one of a boundary particle never. */
enum { FLUID_GHOST = 16, BOUNDARY_GHOST = 1 };

/* Builds the rows of one brick. */
typedef struct building {
  const hc_bricks *bricks;
  const hc_brick_set *set; /* numbered like the bricks */
  bool periodic[3];
  hc_brick low, high; /* bricks at the ends of periodic axes */
  double share[4]; /* of a brick's particles that lie at a face, an edge, a corner: by how many axes differ */
  int most_axes;
} building;

static double ghosts_of(const hc_loaded_brick *brick) {
  return (double)(FLUID_GHOST * brick->fluid + BOUNDARY_GHOST * brick->boundary);
}

/* The neighbour's number or -1, and how many axes lead there. */
static int32_t neighbor_of(const building *building, hc_brick brick, int way, int *axes) {
  const int step[3] = {way % 3 - 1, way / 3 % 3 - 1, way / 9 - 1};
  *axes = abs(step[0]) + abs(step[1]) + abs(step[2]);
  if (*axes == 0 || *axes > building->most_axes) return -1;
  for (int axis = 0; axis < 3; axis++) {
    int32_t *x = &brick.x[axis];
    if (step[axis] == 0) continue;
    if (building->periodic[axis] && *x == (step[axis] > 0 ? building->high : building->low).x[axis])
      *x = (step[axis] > 0 ? building->low : building->high).x[axis];
    else if (*x == (step[axis] > 0 ? INT32_MAX : INT32_MIN))
      return -1;
    else
      *x += step[axis];
  }
  return hc_brick_set_find(building->set, brick);
}

/* Writes the row of brick k behind `used` entries; returns where it ends. Two bricks may meet in several ways
 * across a periodic border: one edge. */
static idx_t write_row(hc_graph *graph, const building *building, int32_t k, idx_t used) {
  const hc_loaded_brick *brick = &building->bricks->brick[k];
  const idx_t begin = used;
  for (int way = 0; way < HC_ADJACENT; way++) {
    int axes;
    const int32_t other = neighbor_of(building, brick->brick, way, &axes);
    if (other < 0 || other == k) continue;
    const double ghosts =
        building->share[axes] * (ghosts_of(brick) + ghosts_of(&building->bricks->brick[other]));
    const idx_t weight = (idx_t)fmax(1.0, ghosts + 0.5);
    idx_t entry = begin;
    while (entry < used && graph->adjacent[entry] != other) entry++;
    if (entry == used) {
      graph->adjacent[used] = other;
      graph->edge_weight[used++] = 0;
    }
    graph->edge_weight[entry] += weight;
  }
  return used;
}

static void write_rows(hc_graph *graph, const building *building) {
  size_t capacity = 0, weight_capacity = 0;
  idx_t used = 0;
  for (int32_t k = 0; k < building->bricks->count; k++) {
    const size_t wanted = (size_t)used + HC_ADJACENT;
    hc_reserve((void **)&graph->adjacent, &capacity, wanted, (size_t)used, sizeof(idx_t));
    hc_reserve((void **)&graph->edge_weight, &weight_capacity, wanted, (size_t)used, sizeof(idx_t));
    graph->start[k] = used;
    used = write_row(graph, building, k, used);
  }
  graph->start[building->bricks->count] = used;
}

void hc_graph_init(hc_graph *graph, const hc_bricks *bricks, const hc_map *map, const hc_frame *frame,
                   int neighborhood) {
  *graph = (hc_graph){.count = bricks->count,
                      .start = hc_alloc((size_t)bricks->count + 1, sizeof(idx_t)),
                      .vertex_weight = hc_alloc((size_t)bricks->count, sizeof(idx_t))};
  const double scale = fmin(1.0, LARGEST_TOTAL / fmax(1.0, bricks->weight));
  hc_brick_set set;
  hc_brick_set_init(&set);
  double ghosts = 1.0;
  for (int32_t k = 0; k < bricks->count; k++) {
    graph->vertex_weight[k] = (idx_t)(scale * bricks->brick[k].weight + 0.5);
    hc_brick_set_add(&set, bricks->brick[k].brick);
    ghosts += HC_ADJACENT * ghosts_of(&bricks->brick[k]);
  }
  building building = {.bricks = bricks,
                       .set = &set,
                       .most_axes = neighborhood == 6    ? 1
                                    : neighborhood == 18 ? 2
                                                         : 3};
  const double layer = 1.0 / (double)(1 << map->bits);
  building.share[0] = fmin(1.0, LARGEST_TOTAL / ghosts);
  for (int axes = 1; axes <= 3; axes++) building.share[axes] = layer * building.share[axes - 1];
  int64_t first[3], last[3];
  for (int axis = 0; axis < 3; axis++) {
    building.periodic[axis] = frame->period[axis] > 0;
    first[axis] = hc_frame_cell(frame->low[axis]);
    last[axis] = first[axis] + hc_frame_cell(frame->period[axis]) - 1;
  }
  building.low = hc_map_brick(map, map->bits, first);
  building.high = hc_map_brick(map, map->bits, last);
  write_rows(graph, &building);
  hc_brick_set_free(&set);
}

void hc_graph_free(hc_graph *graph) {
  hc_free(graph->start);
  hc_free(graph->adjacent);
  hc_free(graph->vertex_weight);
  hc_free(graph->edge_weight);
  memset(graph, 0, sizeof *graph);
}

int64_t hc_graph_edge_cut(const hc_graph *graph, const int32_t *part) {
  int64_t cut = 0;
  for (idx_t k = 0; k < graph->count; k++)
    for (idx_t entry = graph->start[k]; entry < graph->start[k + 1]; entry++)
      if (part[k] != part[graph->adjacent[entry]]) cut += graph->edge_weight[entry];
  return cut / 2;
}
