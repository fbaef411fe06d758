#include "surface_region.h"

#include "base/memory.h"

#include <math.h>

static const hc_surface_node nothing = {
    {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0, 1};

static bool overlaps(const hc_surface_region *region, const hc_surface_node *node) {
  for (int a = 0; a < 3; a++)
    if (node->low[a] > region->high[a] || node->high[a] < region->low[a]) return false;
  return true;
}

static int32_t append(hc_surface_region *region, const hc_surface_node *node) {
  const size_t count = (size_t)region->count;
  hc_reserve((void **)&region->nodes, &region->room, 2 * count + 1, count, sizeof *node);
  region->nodes[region->count] = *node;
  return region->count++;
}

/* Appends what of a node overlaps the region; nothing if nothing does. */
static void take(hc_surface_region *region, const hc_surface *surface, int32_t at) {
  const hc_surface_node *node = &surface->nodes[at];
  while (node->count == 0) { /* down to a leaf, or to where both children overlap */
    const bool first = overlaps(region, node + 1), second = overlaps(region, &surface->nodes[node->first]);
    if (!first && !second) return;
    if (first && second) break;
    node = first ? node + 1 : &surface->nodes[node->first];
  }
  const int32_t mine = append(region, node);
  if (node->count > 0) return;
  take(region, surface, (int32_t)(node + 1 - surface->nodes));
  if (region->count == mine + 1) {
    region->count = mine;
    take(region, surface, node->first);
    return;
  }
  const int32_t second = region->count;
  take(region, surface, node->first);
  if (region->count == second) append(region, &nothing);
  region->nodes[mine].first = second;
}

void hc_surface_region_take(hc_surface_region *region, const hc_surface *surface, const double low[3],
                            const double high[3]) {
  region->count = 0;
  for (int a = 0; a < 3; a++) {
    region->low[a] = low[a];
    region->high[a] = high[a];
  }
  if (overlaps(region, &surface->nodes[0])) take(region, surface, 0);
  if (region->count == 0) append(region, &nothing);
}

void hc_surface_region_free(hc_surface_region *region) {
  hc_free(region->nodes);
  *region = (hc_surface_region){0};
}

bool hc_surface_region_holds(const hc_surface_region *region, const double x[3], double reach) {
  for (int a = 0; a < 3; a++)
    if (x[a] - reach < region->low[a] || x[a] + reach > region->high[a]) return false;
  return true;
}

bool hc_surface_region_faces(const hc_surface_region *region, const hc_surface *surface, const double ray[3],
                             double side) {
  for (int32_t k = 0; k < region->count; k++) {
    const hc_surface_node *const node = &region->nodes[k];
    for (int32_t t = node->first;
         node->count > 0 && node->low[0] <= node->high[0] && t < node->first + node->count; t++)
      if (hc_surface_faces(surface, surface->order[t], ray, side)) return true;
  }
  return false;
}
