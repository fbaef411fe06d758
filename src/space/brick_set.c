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

static uint32_t hash(hc_brick brick) {
  uint64_t mixed = (uint64_t)(uint32_t)brick.x[0] * 0x9e3779b97f4a7c15ULL ^
                   (uint64_t)(uint32_t)brick.x[1] * 0xc2b2ae3d27d4eb4fULL ^
                   (uint64_t)(uint32_t)brick.x[2] * 0x165667b19e3779f9ULL;
  mixed ^= mixed >> 29;
  mixed *= 0xbf58476d1ce4e5b9ULL;
  return (uint32_t)(mixed >> 32);
}

/* The table entry that holds the brick, or the empty one where it would go. */
static uint32_t probe(const hc_brick_set *set, hc_brick brick) {
  uint32_t entry = hash(brick) & set->mask;
  while (set->table[entry] >= 0 && !hc_brick_equal(set->bricks[set->table[entry]], brick))
    entry = (entry + 1) & set->mask;
  return entry;
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
  set->table[entry] = set->count;
  return set->count++;
}
