#include "graph.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

/* METIS adds weights up in its own integers: all of them together stay below this. */
static const double LARGEST_TOTAL = 1 << 30;

/* A ghost of a fluid particle is refreshed many times a step, one of a boundary particle never. */
enum { FLUID_GHOST = 16, BOUNDARY_GHOST = 1 };

/* What the rows are built from. */
typedef struct building {
  const hc_bricks *bricks;
  hc_brick_set set; /* numbered like the bricks */
  int32_t *vertex;  /* of each brick */
  bool periodic[3];
  hc_brick low, high; /* bricks at the ends of periodic axes */
  double
      layer; /* the share of a brick's particles that lie at a face, scaled so that METIS can add them up */
} building;

static double ghosts_of(const hc_loaded_brick *brick) {
  return (double)(FLUID_GHOST * brick->fluid + BOUNDARY_GHOST * brick->boundary);
}

/* The number of the brick behind a face, or -1. */
static int32_t neighbor_of(const building *building, hc_brick brick, int face) {
  const int axis = face / 2, step = face % 2 ? 1 : -1;
  int32_t *x = &brick.x[axis];
  const int32_t end = (step > 0 ? &building->high : &building->low)->x[axis];
  if (building->periodic[axis] && *x == end)
    *x = (step > 0 ? &building->low : &building->high)->x[axis];
  else if (__builtin_add_overflow(*x, step, x))
    return -1;
  return hc_brick_set_find(&building->set, brick);
}

/* Adds the faces of brick k to the row of its vertex, which begins at `begin` and has come to `used`; returns
 * where it ends. Two vertices may share several faces: one edge. */
static idx_t add_faces(hc_graph *graph, const building *building, int32_t k, idx_t begin, idx_t used) {
  const hc_loaded_brick *brick = &building->bricks->brick[k];
  for (int face = 0; face < HC_GRAPH_FACES; face++) {
    const int32_t there = neighbor_of(building, brick->brick, face);
    if (there < 0 || building->vertex[there] == building->vertex[k]) continue;
    const int32_t other = building->vertex[there];
    const double ghosts = building->layer * (ghosts_of(brick) + ghosts_of(&building->bricks->brick[there]));
    idx_t entry = begin;
    while (entry < used && graph->adjacent[entry] != other) entry++;
    if (entry == used) {
      graph->adjacent[used] = other;
      graph->edge_weight[used++] = 0;
    }
    graph->edge_weight[entry] += (idx_t)fmax(1.0, ghosts + 0.5);
  }
  return used;
}

/* Is there no fluid in brick k nor behind its faces? */
static bool is_dry(const building *building, int32_t k) {
  const hc_loaded_brick *brick = building->bricks->brick;
  bool dry = brick[k].fluid == 0;
  for (int face = 0; face < HC_GRAPH_FACES && dry; face++) {
    const int32_t there = neighbor_of(building, brick[k].brick, face);
    dry = there < 0 || brick[there].fluid == 0;
  }
  return dry;
}

static bool in_one_cube(const hc_brick *a, const hc_brick *b) {
  bool one = true;
  for (int axis = 0; axis < 3; axis++)
    one &= a->x[axis] >> HC_GRAPH_MERGED_BITS == b->x[axis] >> HC_GRAPH_MERGED_BITS;
  return one;
}

static void find_vertices(hc_graph *graph, const building *building) {
  const hc_bricks *bricks = building->bricks;
  bool before = false;
  for (int32_t k = 0; k < bricks->count; k++) {
    const bool dry = is_dry(building, k);
    if (!dry || !before || !in_one_cube(&bricks->brick[k].brick, &bricks->brick[k - 1].brick))
      graph->first[graph->count++] = k;
    building->vertex[k] = (int32_t)graph->count - 1;
    before = dry;
  }
  graph->first[graph->count] = bricks->count;
}

static void find_ends(building *building, const hc_map *map, const hc_frame *frame) {
  int64_t first[3], last[3];
  for (int axis = 0; axis < 3; axis++) {
    building->periodic[axis] = frame->period[axis] > 0;
    first[axis] = hc_frame_cell(frame->low[axis]);
    last[axis] = first[axis] + hc_frame_cell(frame->period[axis]) - 1;
  }
  building->low = hc_map_brick(map, map->bits, first);
  building->high = hc_map_brick(map, map->bits, last);
}

void hc_graph_init(hc_graph *graph, const hc_bricks *bricks, const hc_map *map, const hc_frame *frame) {
  const size_t count = (size_t)bricks->count;
  building building = {.bricks = bricks, .vertex = hc_alloc(count, sizeof *building.vertex)};
  hc_brick_set_init(&building.set);
  double ghosts = 0.0;
  for (int32_t k = 0; k < bricks->count; k++) {
    hc_brick_set_add(&building.set, bricks->brick[k].brick);
    ghosts += HC_GRAPH_FACES * ghosts_of(&bricks->brick[k]);
  }
  building.layer = fmin(1.0, LARGEST_TOTAL / fmax(1.0, ghosts)) / (double)(1 << map->bits);
  find_ends(&building, map, frame);
  *graph = (hc_graph){.first = hc_alloc(count + 1, sizeof *graph->first)};
  find_vertices(graph, &building);
  const size_t vertices = (size_t)graph->count;
  graph->start = hc_alloc(vertices + 1, sizeof(idx_t));
  graph->adjacent = hc_alloc(HC_GRAPH_FACES * count, sizeof(idx_t));
  graph->edge_weight = hc_alloc(HC_GRAPH_FACES * count, sizeof(idx_t));
  graph->vertex_weight = hc_alloc(vertices, sizeof(idx_t));
  const double scale = fmin(1.0, LARGEST_TOTAL / fmax(1.0, bricks->weight));
  idx_t used = 0;
  for (idx_t v = 0; v < graph->count; v++) {
    const idx_t begin = graph->start[v] = used;
    double weight = 0.0;
    for (int32_t k = graph->first[v]; k < graph->first[v + 1]; k++) {
      weight += bricks->brick[k].weight;
      used = add_faces(graph, &building, k, begin, used);
    }
    graph->vertex_weight[v] = (idx_t)(scale * weight + 0.5);
  }
  graph->start[graph->count] = used;
  hc_brick_set_free(&building.set);
  hc_free(building.vertex);
}

void hc_graph_free(hc_graph *graph) {
  hc_free(graph->first);
  hc_free(graph->start);
  hc_free(graph->adjacent);
  hc_free(graph->vertex_weight);
  hc_free(graph->edge_weight);
  memset(graph, 0, sizeof *graph);
}

int64_t hc_graph_edge_cut(const hc_graph *graph, const int32_t *part) {
  int64_t cut = 0;
  for (idx_t v = 0; v < graph->count; v++)
    for (idx_t entry = graph->start[v]; entry < graph->start[v + 1]; entry++)
      if (part[graph->first[v]] != part[graph->first[graph->adjacent[entry]]])
        cut += graph->edge_weight[entry];
  return cut / 2;
}
