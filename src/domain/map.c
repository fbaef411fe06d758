#include "map.h"

#include "base/check.h"
#include "base/memory.h"

#include <string.h>

void hc_map_init(hc_map *map, const int64_t cell[3]) {
  memset(map, 0, sizeof *map);
  for (int axis = 0; axis < 3; axis++)
    map->origin[axis] = (int64_t)((uint64_t)cell[axis] >> HC_MAP_MOST_BITS << HC_MAP_MOST_BITS);
}

void hc_map_free(hc_map *map) {
  hc_free(map->intervals);
  memset(map, 0, sizeof *map);
}

void hc_map_start(hc_map *map, hc_map_order order, int bits) {
  HC_CHECK(bits >= 0 && bits <= HC_MAP_MOST_BITS, "a brick has 2^0 to 2^%d cells along an edge, got 2^%d",
           HC_MAP_MOST_BITS, bits);
  map->order = order;
  map->bits = bits;
  map->count = 0;
}

void hc_map_add(hc_map *map, hc_brick first, int rank) {
  const size_t old = (size_t)map->count;
  if (old > 0) {
    const hc_interval *last = &map->intervals[old - 1];
    HC_CHECK(hc_map_compare(map->order, &last->first, &first) < 0, "interval %zu does not ascend", old);
    if (last->rank == rank) return;
  }
  hc_reserve((void **)&map->intervals, &map->capacity, old + 1, old, sizeof *map->intervals);
  map->intervals[old] = (hc_interval){first, rank};
  map->count++;
}

/* Along one axis first, then the two that follow it. */
static int compare_along(int axis, const hc_brick *a, const hc_brick *b) {
  for (int k = 0; k < 3; k++, axis = axis == 2 ? 0 : axis + 1)
    if (a->x[axis] != b->x[axis]) return a->x[axis] < b->x[axis] ? -1 : 1;
  return 0;
}

/* Morton's order without its interleaved bits: the coordinate decides that differs in the highest bit
 * (Chan 2002, "Closest-point problems simplified on the RAM"). */
static int compare_morton(const hc_brick *a, const hc_brick *b) {
  int decides = 2;
  uint32_t highest = 0;
  for (int axis = 2; axis >= 0; axis--) {
    const uint32_t differing = (uint32_t)a->x[axis] ^ (uint32_t)b->x[axis];
    if (highest < differing && highest < (highest ^ differing)) {
      decides = axis;
      highest = differing;
    }
  }
  const int32_t p = a->x[decides], q = b->x[decides];
  return p < q ? -1 : p > q;
}

int hc_map_compare(hc_map_order order, const hc_brick *a, const hc_brick *b) {
  return order == HC_ORDER_MORTON ? compare_morton(a, b) : compare_along((int)order, a, b);
}

/* qsort has no room for the order: one comparison for each. */
static int by_x(const void *a, const void *b) {
  return compare_along(0, a, b);
}
static int by_y(const void *a, const void *b) {
  return compare_along(1, a, b);
}
static int by_z(const void *a, const void *b) {
  return compare_along(2, a, b);
}
static int by_morton(const void *a, const void *b) {
  return compare_morton(a, b);
}

hc_map_comparison hc_map_by(hc_map_order order) {
  static const hc_map_comparison comparisons[] = {by_x, by_y, by_z, by_morton};
  return comparisons[order];
}

/* The last interval that starts at or before the brick; the first one owns what comes before it too. */
static int32_t interval_of(const hc_map *map, hc_brick brick) {
  int32_t low = 0, high = map->count - 1; /* the interval is in [low, high] */
  while (low < high) {
    const int32_t middle = low + (high - low + 1) / 2;
    if (hc_map_compare(map->order, &map->intervals[middle].first, &brick) <= 0)
      low = middle;
    else
      high = middle - 1;
  }
  return low;
}

int hc_map_owner(const hc_map *map, hc_brick brick) {
  return map->count == 0 ? 0 : map->intervals[interval_of(map, brick)].rank;
}

int hc_map_owner_of_box(const hc_map *map, const int64_t low[3], const int64_t high[3]) {
  if (map->count == 0) return 0;
  const int32_t interval = interval_of(map, hc_map_brick(map, map->bits, low));
  const hc_brick last = hc_map_brick(map, map->bits, high);
  const bool next = interval + 1 < map->count &&
                    hc_map_compare(map->order, &map->intervals[interval + 1].first, &last) <= 0;
  return next ? HC_MAP_MIXED : map->intervals[interval].rank;
}
