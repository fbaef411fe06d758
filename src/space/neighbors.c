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
  hc_free(list->row);
  hc_free(list->offset);
  memset(list, 0, sizeof *list);
}

void hc_neighbor_search_init(hc_neighbor_search *search, hc_isa isa) {
  memset(search, 0, sizeof *search);
  search->isa = isa;
  search->reach = HC_CUT_EDGE;
}

void hc_neighbor_search_free(hc_neighbor_search *search) {
  hc_free(search->xy);
  hc_free(search->z);
  hc_free(search->offset);
  hc_free(search->adjacent);
  hc_free(search->known);
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

/* Makes room for the bricks around each target's; none is known. */
static void forget_adjacent(hc_neighbor_search *search, int32_t bricks, int source_count) {
  hc_reserve((void **)&search->adjacent, &search->adjacent_capacity, (size_t)bricks * (size_t)source_count, 0,
             sizeof *search->adjacent);
  hc_reserve((void **)&search->known, &search->known_capacity, (size_t)bricks, 0, 1);
  memset(search->known, 0, (size_t)bricks);
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
  const hc_neighbor_source *sources;
  int source_count;
  int32_t bricks;                     /* of the targets */
  int32_t first[HC_NEIGHBOR_SOURCES]; /* what indices of a source begin with */
  const hc_record *place;             /* of all sources */
  int32_t slab[4];                    /* where the three slabs begin, and the end */
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

/* Finds the bricks around a target's, if they are not known; false if there is none. */
static bool find_adjacent(const window *window, const hc_brick_set *targets, int32_t brick) {
  enum { UNKNOWN, NONE, SOME };
  char *const known = &window->search->known[brick];
  if (*known != UNKNOWN) return *known == SOME;
  *known = NONE;
  for (int s = 0; s < window->source_count; s++)
    if (hc_brick_set_around(&window->sources[s].cells->bricks, targets->bricks[brick],
                            window->search->adjacent[s * window->bricks + brick]))
      *known = SOME;
  return *known == SOME;
}

static void write_empty_rows(hc_neighbors *list, hc_selection rows, size_t used) {
  for (int32_t row = rows.begin; row < rows.end; row++) list->row[row] = (uint32_t)used;
}

/* Records [begin, end) of a source that lie in one cell. */
typedef struct stretch {
  int32_t begin, end;
} stretch;

/* The length of the run that begins a stretch of one wall's samples. */
static int32_t run_of(const hc_particles *particles, stretch stretch) {
  int32_t end = stretch.begin + 1;
  while (end < stretch.end && particles->motion[end].scalar == particles->motion[stretch.begin].scalar) end++;
  return end - stretch.begin;
}

static int32_t append(window *window, int32_t end, int source, int32_t begin, int32_t count) {
  make_room(window->search, end + count, end);
  window->loops->append(window->search, end, window->place, window->first[source] + begin, count);
  return end + count;
}

/* Appends one cell's particles of two sources in the order of their walls. */
static int32_t append_merged(window *window, int32_t end, stretch stretches[HC_NEIGHBOR_SOURCES]) {
  const hc_particles *a = window->sources[0].particles, *b = window->sources[1].particles;
  while (stretches[0].begin < stretches[0].end || stretches[1].begin < stretches[1].end) {
    const bool first = stretches[1].begin == stretches[1].end ||
                       (stretches[0].begin < stretches[0].end &&
                        a->motion[stretches[0].begin].scalar < b->motion[stretches[1].begin].scalar);
    stretch *from = &stretches[!first];
    const int32_t count = run_of(first ? a : b, *from);
    end = append(window, end, !first, from->begin, count);
    from->begin += count;
  }
  return end;
}

/* Appends a cell of several sources, `way` and `cell` as in append_slab. */
static int32_t append_joined(window *window, int32_t end, int32_t index, int way, int cell) {
  stretch stretches[HC_NEIGHBOR_SOURCES];
  int filled = 0, last = 0;
  for (int s = 0; s < window->source_count; s++) {
    const hc_cells *cells = window->sources[s].cells;
    const int32_t brick = window->search->adjacent[s * window->bricks + index][way];
    const int32_t count = brick < 0 ? 0 : cells->count[brick][cell];
    stretches[s].begin = count == 0 ? 0 : cells->begin[brick][cell];
    stretches[s].end = stretches[s].begin + count;
    if (count == 0) continue;
    filled++;
    last = s;
  }
  if (filled > 1) return append_merged(window, end, stretches);
  return filled == 0
             ? end
             : append(window, end, last, stretches[last].begin, stretches[last].end - stretches[last].begin);
}

/* Appends the nine cells around (x, y, z), which is relative to the target brick `index`. */
static void append_slab(window *window, int32_t index, int x, int y, int z) {
  const hc_cells *only = window->source_count == 1 ? window->sources[0].cells : NULL;
  const int32_t *adjacent = window->search->adjacent[index];
  int32_t end = window->slab[3];
  for (int dz = -1; dz <= 1; dz++) {
    for (int dy = -1; dy <= 1; dy++) {
      const int way = side(x) + 3 * side(y + dy) + 9 * side(z + dz);
      const int cell = hc_cell_in_brick(inside(x), inside(y + dy), inside(z + dz));
      if (!only) {
        end = append_joined(window, end, index, way, cell);
        continue;
      }
      const int32_t brick = adjacent[way], count = brick < 0 ? 0 : only->count[brick][cell];
      if (count > 0) end = append(window, end, 0, only->begin[brick][cell], count);
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

/* The rows of a selection whose particles are [first, end), given the row where the last one ended. */
static hc_selection rows_within(hc_selection selection, int32_t first, int32_t end, int32_t *row) {
  if (!selection.index) {
    selection.begin = first > selection.begin ? first : selection.begin;
    selection.end = end < selection.end ? end : selection.end;
    return selection;
  }
  const int32_t most = selection.end;
  selection.begin = *row;
  while (*row < most && selection.index[*row] < end) ++*row;
  selection.end = *row;
  return selection;
}

static void make_list_room(hc_neighbors *list, hc_selection selection, bool same) {
  const size_t rows = (size_t)selection.end;
  hc_reserve((void **)&list->row, &list->row_capacity, rows + 1, 0, sizeof *list->row);
  const size_t guess = (same ? rows * LIST_GUESS : 0) + HC_NEIGHBOR_SLACK;
  if (list->offset_capacity < guess)
    hc_reserve((void **)&list->offset, &list->offset_capacity, guess, 0, sizeof *list->offset);
  list->pairs = 0;
  list->crowded = -1;
}

/* Turns the window to a cell. */
static void look(window *window, const hc_cells *cells, int32_t place_in_order, bool open) {
  const int32_t slot = cells->own_cells[place_in_order], brick = slot / HC_BRICK_CELLS;
  const int cell = slot % HC_BRICK_CELLS;
  const int x = inside(cell), y = inside(cell >> HC_BRICK_BITS), z = cell >> (2 * HC_BRICK_BITS);
  if (open && window->slab[3] < WINDOW_RESTART && follows(cells, cells->own_cells[place_in_order - 1], slot))
    advance_window(window, brick, x, y, z);
  else
    start_window(window, brick, x, y, z);
}

void hc_neighbors_build(hc_neighbors *list, hc_neighbor_search *search, const hc_cells *target_cells,
                        const hc_particles *target, hc_selection selection, const hc_neighbor_source *sources,
                        int source_count) {
  const bool same = source_count == 1 && target == sources[0].particles;
  int64_t records = 0;
  for (int s = 0; s < source_count; s++)
    records += (int64_t)sources[s].particles->own + sources[s].particles->ghosts;
  HC_CHECK(source_count == 1 || (source_count == 2 && sources[1].particles->head == sources[0].particles),
           "a list leads to one store, or to two that are joined");
  HC_CHECK(records <= HC_RECORDS_MOST, "too many particles on one rank: %lld with ghosts",
           (long long)records);
  make_list_room(list, selection, same);
  forget_adjacent(search, target_cells->bricks.count, source_count);
  window window = {.search = search,
                   .loops = loops_of(search->isa),
                   .sources = sources,
                   .source_count = source_count,
                   .bricks = target_cells->bricks.count,
                   .place = sources[0].particles->place};
  if (source_count == 2) window.first[1] = hc_particles_first(sources[1].particles);
  make_room(search, 0, 0);
  size_t used = 0;
  int32_t last_brick = -1, row = selection.begin;
  bool any = false, open = false; /* bricks far from any source need no window */
  for (int32_t k = 0; k < target_cells->own_cell_count; k++) {
    const int32_t slot = target_cells->own_cells[k], brick = slot / HC_BRICK_CELLS;
    const int32_t first = target_cells->begin[brick][slot % HC_BRICK_CELLS];
    const int32_t count = target_cells->count[brick][slot % HC_BRICK_CELLS];
    const hc_selection rows = rows_within(selection, first, first + count, &row);
    if (rows.begin >= rows.end) {
      open = false;
      continue;
    }
    if (brick != last_brick) any = find_adjacent(&window, &target_cells->bricks, brick);
    last_brick = brick;
    const bool crowded = count > HC_CELL_MOST;
    if (crowded && (list->crowded < 0 || target->id[first] < target->id[list->crowded]))
      list->crowded = first;
    const bool was_open = open;
    open = any && !crowded;
    if (open) look(&window, target_cells, k, was_open);
    if (!open || window.slab[3] == window.slab[0]) {
      write_empty_rows(list, rows, used);
      continue;
    }
    const size_t most =
        (size_t)(rows.end - rows.begin) * (size_t)(window.slab[3] - window.slab[0] + HC_NEIGHBOR_SLACK);
    if (used + most + HC_NEIGHBOR_SLACK > list->offset_capacity)
      hc_reserve((void **)&list->offset, &list->offset_capacity, used + used / 4 + most + HC_NEIGHBOR_SLACK,
                 used, sizeof *list->offset);
    used = window.loops->rows(list, search, window.slab[0], window.slab[3], target->place, rows, same, used);
  }
  HC_CHECK(used <= UINT32_MAX, "neighbour list too long for one rank: %zu entries", used);
  list->row[selection.end] = (uint32_t)used;
  memset(list->offset + used, 0, 2 * HC_LIST_GROUP * sizeof *list->offset);
}

void hc_neighbors_spread(hc_neighbors *list, hc_selection selection, int32_t own) {
  const size_t rows = (size_t)selection.end + 1;
  hc_reserve((void **)&list->row, &list->row_capacity, (size_t)own + 1, rows, sizeof *list->row);
  int32_t row = selection.end;
  uint32_t next = list->row[row];
  for (int32_t i = own; i >= 0; i--) { /* never before what is still to be read */
    const bool selected = row > 0 && selection.index[row - 1] == i;
    list->row[i] = selected ? list->row[--row] : next;
    if (selected) next = list->row[i] & ~(uint32_t)(HC_LIST_GROUP - 1);
  }
}
