#include "brick_set.h"

#include "base/memory.h"

#include <string.h>

enum { SMALLEST_TABLE = 64 };

static void make_table(hc_brick_set *set, uint32_t size) {
  hc_free(set->table);
  set->table = hc_alloc(size, sizeof *set->table);
  set->mask = size - 1;
  memset(set->table, -1, size * sizeof *set->table);
}

void hc_brick_set_init(hc_brick_set *set) {
  memset(set, 0, sizeof *set);
  make_table(set, SMALLEST_TABLE);
}

void hc_brick_set_free(hc_brick_set *set) {
  hc_free(set->bricks);
  hc_free(set->table);
  memset(set, 0, sizeof *set);
}

void hc_brick_set_clear(hc_brick_set *set) {
  set->count = 0;
  memset(set->table, -1, ((size_t)set->mask + 1) * sizeof *set->table);
}

/* The share of a coordinate in a brick's hash. */
static uint64_t spread(int axis, int32_t x) {
  static const uint64_t odd[3] = {0x9e3779b97f4a7c15ULL, 0xc2b2ae3d27d4eb4fULL, 0x165667b19e3779f9ULL};
  return (uint64_t)(uint32_t)x * odd[axis];
}

static uint32_t hash(uint64_t spread) {
  spread ^= spread >> 29;
  spread *= 0xbf58476d1ce4e5b9ULL;
  return (uint32_t)(spread >> 32);
}

/* The table entry that holds the brick of such a hash, or the empty one where it would go. */
static uint32_t probe_from(const hc_brick_set *set, hc_brick brick, uint32_t entry) {
  entry &= set->mask;
  while (set->table[entry] >= 0 && !hc_brick_equal(set->bricks[set->table[entry]], brick))
    entry = (entry + 1) & set->mask;
  return entry;
}

static uint32_t probe(const hc_brick_set *set, hc_brick brick) {
  return probe_from(set, brick, hash(spread(0, brick.x[0]) ^ spread(1, brick.x[1]) ^ spread(2, brick.x[2])));
}

int32_t hc_brick_set_find(const hc_brick_set *set, hc_brick brick) {
  return set->table[probe(set, brick)];
}

int32_t hc_brick_set_add(hc_brick_set *set, hc_brick brick) {
  uint32_t entry = probe(set, brick);
  if (set->table[entry] >= 0) return set->table[entry];
  if (2 * (uint32_t)(set->count + 1) > set->mask) {
    make_table(set, 2 * (set->mask + 1));
    for (int32_t k = 0; k < set->count; k++) set->table[probe(set, set->bricks[k])] = k;
    entry = probe(set, brick);
  }
  const size_t old = (size_t)set->count;
  hc_reserve((void **)&set->bricks, &set->capacity, old + 1, old, sizeof *set->bricks);
  set->bricks[old] = brick;
  for (int axis = 0; axis < 3; axis++) {
    if (old == 0 || brick.x[axis] < set->low.x[axis]) set->low.x[axis] = brick.x[axis];
    if (old == 0 || brick.x[axis] > set->high.x[axis]) set->high.x[axis] = brick.x[axis];
  }
  set->table[entry] = set->count;
  return set->count++;
}

static bool within(const hc_brick_set *set, int axis, int32_t x) {
  return x >= set->low.x[axis] && x <= set->high.x[axis];
}

bool hc_brick_set_around(const hc_brick_set *set, hc_brick brick, int32_t adjacent[HC_ADJACENT]) {
  bool any = false, in[3][3];
  uint64_t share[3][3];
  memset(adjacent, -1, HC_ADJACENT * sizeof *adjacent);
  if (set->count == 0) return false;
  for (int axis = 0; axis < 3; axis++)
    for (int step = 0; step < 3; step++) {
      const int32_t x = brick.x[axis] + step - 1;
      in[axis][step] = within(set, axis, x);
      share[axis][step] = spread(axis, x);
    }
  for (int way = 0; way < HC_ADJACENT; way++) {
    const int x = way % 3, y = way / 3 % 3, z = way / 9;
    if (!(in[0][x] && in[1][y] && in[2][z])) continue;
    const hc_brick next = {{brick.x[0] + x - 1, brick.x[1] + y - 1, brick.x[2] + z - 1}};
    adjacent[way] = set->table[probe_from(set, next, hash(share[0][x] ^ share[1][y] ^ share[2][z]))];
    any |= adjacent[way] >= 0;
  }
  return any;
}
