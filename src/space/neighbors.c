#include "neighbors.h"

#include "base/check.h"
#include "base/memory.h"

#include <string.h>

enum {
  WINDOW_RESTART = 16384, /* candidates after which a long row starts a fresh window, to stay in cache */
  LIST_GUESS = 44 /* entries a particle that the first list has room for; untouched room costs nothing */
};

void hc_neighbors_init(hc_neighbors *list) {
  memset(list, 0, sizeof *list);
}

void hc_neighbors_free(hc_neighbors *list) {
  hc_free(list->start);
  hc_free(list->offset);
  hc_free(list->count);
  memset(list, 0, sizeof *list);
}

void hc_neighbor_search_init(hc_neighbor_search *search, hc_isa isa) {
  memset(search, 0, sizeof *search);
  search->isa = isa;
}

void hc_neighbor_search_free(hc_neighbor_search *search) {
  hc_free(search->xy);
  hc_free(search->z);
  hc_free(search->offset);
  hc_free(search->adjacent);
  memset(search, 0, sizeof *search);
}

static const hc_neighbor_loops *loops_of(hc_isa isa) {
#if defined(__x86_64__)
  if (isa == HC_ISA_AVX2) return hc_neighbor_loops_avx2();
  if (isa == HC_ISA_AVX512) return hc_neighbor_loops_avx512();
#endif
  HC_CHECK(isa == HC_ISA_PORTABLE, "instruction set %d is not for this processor", isa);
  return hc_neighbor_loops_portable();
}

static void find_adjacent(hc_neighbor_search *search, const hc_cells *target, const hc_cells *source) {
  hc_reserve((void **)&search->adjacent, &search->adjacent_capacity, (size_t)target->bricks.count, 0,
             sizeof *search->adjacent);
  for (int32_t k = 0; k < target->bricks.count; k++)
    hc_cells_around(source, target->bricks.bricks[k], search->adjacent[k]);
}

/* Splits a cell coordinate in [-1, HC_BRICK_EDGE] into the neighbouring brick (0, 1, 2) and the cell in it.
 */
static inline int side(int coordinate) {
  return coordinate < 0 ? 0 : coordinate < HC_BRICK_EDGE ? 1 : 2;
}
static inline int inside(int coordinate) {
  return coordinate & (HC_BRICK_EDGE - 1);
}

/* A build in progress: the candidates of three slabs of 3 x 3 cells, at x - 1, x and x + 1 around the current
 * cell, stand one behind the other. */
typedef struct window {
  hc_neighbor_search *search;
  const hc_neighbor_loops *loops;
  const hc_cells *source;
  const hc_record *place;
  int32_t slab[4]; /* where the three slabs begin, and the end */
} window;

/* Makes room for `count` candidates and the loops' slack, keeping the first `keep`. */
static void make_room(hc_neighbor_search *search, int32_t count, int32_t keep) {
  const size_t wanted = (size_t)count + HC_NEIGHBOR_SLACK;
  if (wanted <= search->candidate_capacity) return;
  size_t capacity[3] = {0, 0, 0};
  hc_reserve((void **)&search->xy, &capacity[0], wanted, (size_t)keep, sizeof *search->xy);
  hc_reserve((void **)&search->z, &capacity[1], wanted, (size_t)keep, sizeof *search->z);
  hc_reserve((void **)&search->offset, &capacity[2], wanted, (size_t)keep, sizeof *search->offset);
  search->candidate_capacity = capacity[0];
}

static bool any_adjacent(const hc_neighbor_search *search, int32_t brick) {
  for (int way = 0; way < HC_ADJACENT; way++)
    if (search->adjacent[brick][way] >= 0) return true;
  return false;
}

static void write_empty_rows(hc_neighbors *list, int32_t first, int32_t count, size_t used) {
  for (int32_t i = first; i < first + count; i++) list->start[i] = (uint32_t)(used / HC_LIST_GROUP);
  memset(list->count + first, 0, (size_t)count * sizeof *list->count);
}

/* Appends the nine cells around (x, y, z), which is relative to the target brick `index`. */
static void append_slab(window *window, int32_t index, int x, int y, int z) {
  const int32_t *adjacent = window->search->adjacent[index];
  int32_t end = window->slab[3];
  for (int dz = -1; dz <= 1; dz++) {
    for (int dy = -1; dy <= 1; dy++) {
      const int32_t brick = adjacent[side(x) + 3 * side(y + dy) + 9 * side(z + dz)];
      if (brick < 0) continue;
      const int cell = hc_cell_in_brick(inside(x), inside(y + dy), inside(z + dz));
      const int32_t count = window->source->count[brick][cell];
      if (count == 0) continue;
      make_room(window->search, end + count, end);
      window->loops->append(window->search, end, window->place, window->source->begin[brick][cell], count);
      end += count;
    }
  }
  window->slab[3] = end;
}

static void start_window(window *window, int32_t index, int x, int y, int z) {
  window->slab[3] = 0;
  for (int slab = 0; slab < 3; slab++) {
    window->slab[slab] = window->slab[3];
    append_slab(window, index, x + slab - 1, y, z);
  }
}

static void advance_window(window *window, int32_t index, int x, int y, int z) {
  window->slab[0] = window->slab[1];
  window->slab[1] = window->slab[2];
  window->slab[2] = window->slab[3];
  append_slab(window, index, x + 1, y, z);
}

static bool follows(const hc_cells *cells, int32_t slot, int32_t next) {
  const int cell = slot % HC_BRICK_CELLS, next_cell = next % HC_BRICK_CELLS;
  if (slot / HC_BRICK_CELLS == next / HC_BRICK_CELLS) return next_cell == cell + 1 && inside(next_cell) != 0;
  const int32_t *a = cells->bricks.bricks[slot / HC_BRICK_CELLS].x,
                *b = cells->bricks.bricks[next / HC_BRICK_CELLS].x;
  return inside(cell) == HC_BRICK_EDGE - 1 && next_cell == cell - (HC_BRICK_EDGE - 1) && b[0] == a[0] + 1 &&
         b[1] == a[1] && b[2] == a[2];
}

void hc_neighbors_build(hc_neighbors *list, hc_neighbor_search *search, const hc_cells *target_cells,
                        const hc_particles *target, const hc_cells *source_cells,
                        const hc_particles *source) {
  const size_t own = (size_t)target->own;
  const bool same = target == source;
  hc_reserve((void **)&list->start, &list->start_capacity, own + 1, 0, sizeof *list->start);
  hc_reserve((void **)&list->count, &list->count_capacity, own, 0, sizeof *list->count);
  const size_t guess = (same ? own * LIST_GUESS : 0) + HC_NEIGHBOR_SLACK;
  if (list->offset_capacity < guess)
    hc_reserve((void **)&list->offset, &list->offset_capacity, guess, 0, sizeof *list->offset);
  find_adjacent(search, target_cells, source_cells);
  HC_CHECK(source->own + (int64_t)source->ghosts < (int64_t)UINT32_MAX / (int64_t)sizeof(hc_record),
           "too many particles on one rank: %d and %d ghosts", source->own, source->ghosts);

  window window = {search, loops_of(search->isa), source_cells, source->place, {0, 0, 0, 0}};
  make_room(search, 0, 0);
  size_t used = 0;
  list->pairs = 0;
  int32_t last_brick = -1;
  bool any = false, window_open = false; /* bricks far from any source need no window */
  for (int32_t k = 0; k < target_cells->own_cell_count; k++) {
    const int32_t slot = target_cells->own_cells[k];
    const int32_t brick = slot / HC_BRICK_CELLS;
    const int cell = slot % HC_BRICK_CELLS;
    const int x = inside(cell), y = inside(cell >> HC_BRICK_BITS), z = cell >> (2 * HC_BRICK_BITS);
    const int32_t first = target_cells->begin[brick][cell], count = target_cells->count[brick][cell];
    if (brick != last_brick) any = any_adjacent(search, brick);
    last_brick = brick;
    if (!any) {
      write_empty_rows(list, first, count, used);
      window_open = false;
      continue;
    }
    if (window_open && window.slab[3] < WINDOW_RESTART &&
        follows(target_cells, target_cells->own_cells[k - 1], slot))
      advance_window(&window, brick, x, y, z);
    else
      start_window(&window, brick, x, y, z);
    window_open = true;
    if (window.slab[3] == window.slab[0]) {
      write_empty_rows(list, first, count, used);
      continue;
    }
    const size_t most = (size_t)count * (size_t)(window.slab[3] - window.slab[0] + HC_NEIGHBOR_SLACK);
    if (used + most + HC_NEIGHBOR_SLACK > list->offset_capacity)
      hc_reserve((void **)&list->offset, &list->offset_capacity, used + used / 4 + most + HC_NEIGHBOR_SLACK,
                 used, sizeof *list->offset);
    used = window.loops->rows(list, search, window.slab[0], window.slab[3], target->place, first, count, same,
                              used);
  }
  HC_CHECK(used / HC_LIST_GROUP < UINT32_MAX, "neighbour list too long for one rank: %zu entries", used);
  list->start[own] = (uint32_t)(used / HC_LIST_GROUP);
  memset(list->offset + used, 0, 2 * HC_LIST_GROUP * sizeof *list->offset);
}
