#include "halo.h"

#include "base/check.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void hc_halo_init(hc_halo *halo, hc_domain *domain, hc_particles *particles, int tag) {
  memset(halo, 0, sizeof *halo);
  halo->tag = tag;
  halo->domain = domain;
  halo->particles = particles;
}

void hc_halo_free(hc_halo *halo) {
  HC_CHECK(!halo->fields, "a refresh must end before the halo is freed");
  hc_free(halo->cells);
  hc_free(halo->send);
  hc_free(halo->receive);
  hc_free(halo->send_begin);
  hc_free(halo->copies);
  hc_free(halo->ghost_begin);
  hc_free(halo->send_buffer);
  hc_free(halo->receive_buffer);
  hc_free(halo->requests);
  memset(halo, 0, sizeof *halo);
}

/* ---- which cells go where ---- */

enum { AROUND = HC_BRICK_EDGE + 2 }; /* a brick's cells and those around it, along an edge */

/* One brick while its cells are being marked. */
typedef struct marking {
  const hc_domain *domain;
  hc_brick brick;
  int32_t owner[AROUND][AROUND][AROUND]; /* [z][y][x] of these cells, as they are without periods */
  uint64_t border;                       /* bit per cell: it may need a copy */
  bool near_period; /* a cell of the brick may have a neighbour beyond a periodic border */
} marking;

static void look_for_periods(marking *marking) {
  const hc_frame *frame = marking->domain->frame;
  marking->near_period = false;
  for (int axis = 0; axis < 3; axis++) {
    if (frame->period[axis] == 0) continue;
    const int64_t first = hc_frame_cell(frame->low[axis]), count = hc_frame_cell(frame->period[axis]);
    const int64_t begin = (int64_t)marking->brick.x[axis] * HC_BRICK_EDGE;
    if (begin - 1 < first || begin + HC_BRICK_EDGE >= first + count) marking->near_period = true;
  }
}

/* Finds the owners of the cells [low, high] relative to the brick: of all at once, or of the halves. */
static void find_owners(marking *marking, const int low[3], const int high[3]) {
  int64_t first[3], last[3];
  int longest = 0;
  for (int axis = 0; axis < 3; axis++) {
    const int64_t begin = (int64_t)marking->brick.x[axis] * HC_BRICK_EDGE;
    first[axis] = begin + low[axis];
    last[axis] = begin + high[axis];
    if (high[axis] - low[axis] >= high[longest] - low[longest]) longest = axis;
  }
  const int owner = hc_map_owner_of_box(&marking->domain->map, first, last);
  if (owner == HC_MAP_MIXED) {
    int middle[3] = {high[0], high[1], high[2]}, behind[3] = {low[0], low[1], low[2]};
    middle[longest] = (low[longest] + high[longest]) / 2;
    behind[longest] = middle[longest] + 1;
    find_owners(marking, low, middle);
    find_owners(marking, behind, high);
    return;
  }
  for (int z = low[2]; z <= high[2]; z++)
    for (int y = low[1]; y <= high[1]; y++)
      for (int x = low[0]; x <= high[0]; x++) marking->owner[z + 1][y + 1][x + 1] = owner;
}

/* The cells of the brick that lie beside another rank's: rows of bits, spread by one cell each way. */
static uint64_t find_border(const marking *marking, int32_t rank) {
  unsigned foreign[AROUND][AROUND] = {{0}};
  for (int z = 0; z < AROUND; z++)
    for (int y = 0; y < AROUND; y++)
      for (int x = 0; x < AROUND; x++) foreign[z][y] |= (unsigned)(marking->owner[z][y][x] != rank) << x;
  uint64_t border = 0;
  for (int z = 0; z < HC_BRICK_EDGE; z++)
    for (int y = 0; y < HC_BRICK_EDGE; y++) {
      unsigned row = 0;
      for (int way = 0; way < 9; way++) row |= foreign[z + way / 3][y + way % 3];
      row = (row | row >> 1 | row >> 2) & ((1u << HC_BRICK_EDGE) - 1);
      border |= (uint64_t)row << hc_cell_in_brick(0, y, z);
    }
  return border;
}

/* Fills the marking; false if all around is this rank's and no copy can be needed. */
static bool look_around(marking *marking) {
  look_for_periods(marking);
  const hc_map *map = &marking->domain->map;
  int64_t low[3], high[3];
  for (int axis = 0; axis < 3; axis++) {
    low[axis] = (int64_t)marking->brick.x[axis] * HC_BRICK_EDGE - 1;
    high[axis] = low[axis] + AROUND - 1;
  }
  const int32_t rank = marking->domain->comm->rank;
  if (!marking->near_period && hc_map_owner_of_box(map, low, high) == rank) return false;
  static const int begin[3] = {-1, 0, HC_BRICK_EDGE}, end[3] = {-1, HC_BRICK_EDGE - 1, HC_BRICK_EDGE};
  for (int way = 0; way < HC_ADJACENT; way++) {
    const int part[3] = {way % 3, way / 3 % 3, way / 9};
    const int first[3] = {begin[part[0]], begin[part[1]], begin[part[2]]};
    const int last[3] = {end[part[0]], end[part[1]], end[part[2]]};
    find_owners(marking, first, last);
  }
  marking->border = marking->near_period ? ~0ULL : find_border(marking, rank);
  return marking->border != 0;
}

/* Who owns the cell at `cell` (relative to the brick), and by how many periods ours must be shifted to lie
 * beside it as that owner sees it. */
static int owner_of_cell(const marking *marking, const int cell[3], int8_t shift[3]) {
  const hc_frame *frame = marking->domain->frame;
  shift[0] = shift[1] = shift[2] = 0;
  if (!marking->near_period) return marking->owner[cell[2] + 1][cell[1] + 1][cell[0] + 1];
  int64_t global[3];
  bool wrapped = false;
  for (int axis = 0; axis < 3; axis++) {
    global[axis] = (int64_t)marking->brick.x[axis] * HC_BRICK_EDGE + cell[axis];
    if (frame->period[axis] == 0) continue;
    const int64_t first = hc_frame_cell(frame->low[axis]), count = hc_frame_cell(frame->period[axis]);
    if (global[axis] < first) shift[axis] = 1;
    if (global[axis] >= first + count) shift[axis] = -1;
    global[axis] += shift[axis] * count;
    wrapped |= shift[axis] != 0;
  }
  return wrapped ? hc_domain_owner(marking->domain, global)
                 : marking->owner[cell[2] + 1][cell[1] + 1][cell[0] + 1];
}

static bool listed(const hc_halo_cell *cells, int count, const hc_halo_cell *wanted) {
  for (int k = 0; k < count; k++)
    if (cells[k].rank == wanted->rank && memcmp(cells[k].shift, wanted->shift, sizeof wanted->shift) == 0)
      return true;
  return false;
}

/* The partners of one cell, each once. */
static int partners_of(const marking *marking, int32_t slot, hc_halo_cell found[HC_ADJACENT]) {
  const int cell = slot % HC_BRICK_CELLS;
  const int part[3] = {cell & 3, cell >> HC_BRICK_BITS & 3, cell >> (2 * HC_BRICK_BITS)};
  int count = 0;
  for (int way = 0; way < HC_ADJACENT; way++) {
    if (way == HC_ADJACENT_SELF) continue;
    const int next[3] = {part[0] + way % 3 - 1, part[1] + way / 3 % 3 - 1, part[2] + way / 9 - 1};
    hc_halo_cell partner = {.slot = slot};
    partner.rank = owner_of_cell(marking, next, partner.shift);
    const bool shifted = partner.shift[0] || partner.shift[1] || partner.shift[2];
    if ((partner.rank != marking->domain->comm->rank || shifted) && !listed(found, count, &partner))
      found[count++] = partner;
  }
  return count;
}

void hc_halo_mark(hc_halo *halo, hc_cells *cells) {
  const hc_frame *frame = halo->domain->frame;
  halo->cell_count = 0;
  if (halo->domain->comm->size == 1 && !frame->period[0] && !frame->period[1] && !frame->period[2]) return;
  marking marking = {.domain = halo->domain};
  for (int32_t k = 0; k < cells->bricks.count; k++) {
    marking.brick = cells->bricks.bricks[k];
    if (!look_around(&marking)) continue;
    for (int cell = 0; cell < HC_BRICK_CELLS; cell++) {
      if (cells->count[k][cell] == 0 || !(marking.border >> cell & 1)) continue;
      hc_halo_cell found[HC_ADJACENT];
      const int count = partners_of(&marking, k * HC_BRICK_CELLS + cell, found);
      if (count == 0) continue;
      cells->border[k] |= 1ULL << cell;
      const size_t old = (size_t)halo->cell_count;
      hc_reserve((void **)&halo->cells, &halo->cell_capacity, old + (size_t)count, old, sizeof *halo->cells);
      memcpy(halo->cells + old, found, (size_t)count * sizeof *found);
      halo->cell_count += count;
    }
  }
}

/* ---- sending the cells, entering the ghosts ---- */

/* A cell's header in the message that creates ghosts; its particles' places (12 bytes each) follow. */
typedef struct cell_header {
  hc_brick brick;
  int32_t cell, count;
} cell_header;

enum { PLACE_BYTES = 12 };

/* Sort key: rank, then the cell's place in memory, then the shift: the order in which a receiver stores
 * ghosts. */
static int compare_halo_cells(const void *a, const void *b) {
  const hc_halo_cell *p = a, *q = b;
  if (p->rank != q->rank) return p->rank < q->rank ? -1 : 1;
  if (p->slot != q->slot) return p->slot < q->slot ? -1 : 1;
  return memcmp(p->shift, q->shift, sizeof p->shift);
}

static char *write_cell(const hc_halo *halo, const hc_cells *cells, const hc_halo_cell *cell, char *to) {
  const hc_frame *frame = halo->domain->frame;
  const int32_t brick = cell->slot / HC_BRICK_CELLS;
  const int part = cell->slot % HC_BRICK_CELLS;
  const int parts[3] = {part & 3, part >> HC_BRICK_BITS & 3, part >> (2 * HC_BRICK_BITS)};
  cell_header header = {.count = cells->count[brick][part]};
  uint32_t shift[3];
  hc_halo_shift(halo, cell, shift);
  for (int axis = 0; axis < 3; axis++) {
    const int64_t units = cell->shift[axis] * frame->period[axis];
    const int64_t global =
        (int64_t)cells->bricks.bricks[brick].x[axis] * HC_BRICK_EDGE + parts[axis] + hc_frame_cell(units);
    header.brick.x[axis] = (int32_t)(global >> HC_BRICK_BITS);
    header.cell |= (int32_t)(global & (HC_BRICK_EDGE - 1)) << (axis * HC_BRICK_BITS);
  }
  memcpy(to, &header, sizeof header);
  to += sizeof header;
  const hc_record *place = halo->particles->place + cells->begin[brick][part];
  for (int32_t k = 0; k < header.count; k++) {
    uint32_t x[3];
    for (int axis = 0; axis < 3; axis++) x[axis] = (uint32_t)place[k].x[axis] + shift[axis];
    memcpy(to, x, PLACE_BYTES);
    to += PLACE_BYTES;
  }
  return to;
}

static void find_partners(hc_halo *halo) {
  halo->send_count = 0;
  for (int32_t k = 0; k < halo->cell_count; k++) {
    if (k > 0 && halo->cells[k].rank == halo->cells[k - 1].rank) continue;
    const size_t old = (size_t)halo->send_count;
    hc_reserve((void **)&halo->send, &halo->capacity[0], old + 1, old, sizeof *halo->send);
    hc_reserve((void **)&halo->send_begin, &halo->capacity[1], old + 2, old, sizeof *halo->send_begin);
    halo->send[old].rank = halo->cells[k].rank;
    halo->send_begin[old] = k;
    halo->send_begin[old + 1] = halo->cell_count;
    halo->send_count++;
  }
}

/* How many copies each partner gets of our particles. */
static void count_copies(hc_halo *halo, const hc_cells *cells) {
  hc_reserve((void **)&halo->copies, &halo->capacity[4], (size_t)halo->send_count, 0, sizeof *halo->copies);
  for (int partner = 0; partner < halo->send_count; partner++) {
    halo->copies[partner] = 0;
    for (int32_t k = halo->send_begin[partner]; k < halo->send_begin[partner + 1]; k++)
      halo->copies[partner] +=
          cells->count[halo->cells[k].slot / HC_BRICK_CELLS][halo->cells[k].slot % HC_BRICK_CELLS];
  }
}

/* Fills the messages that create ghosts. */
static void write_cells(hc_halo *halo, const hc_cells *cells) {
  size_t bytes = 0;
  for (int32_t k = 0; k < halo->cell_count; k++) {
    const int32_t slot = halo->cells[k].slot;
    const size_t count = (size_t)cells->count[slot / HC_BRICK_CELLS][slot % HC_BRICK_CELLS];
    bytes += sizeof(cell_header) + count * PLACE_BYTES;
  }
  hc_reserve((void **)&halo->send_buffer, &halo->send_capacity, bytes, 0, 1);
  char *to = halo->send_buffer;
  for (int partner = 0; partner < halo->send_count; partner++) {
    halo->send[partner].data = to;
    for (int32_t k = halo->send_begin[partner]; k < halo->send_begin[partner + 1]; k++)
      to = write_cell(halo, cells, &halo->cells[k], to);
    halo->send[partner].bytes = (size_t)(to - (char *)halo->send[partner].data);
  }
}

static int32_t count_ghosts(const hc_message *message) {
  int32_t ghosts = 0;
  const char *from = message->data, *end = from + message->bytes;
  while (from < end) {
    cell_header header;
    memcpy(&header, from, sizeof header);
    ghosts += header.count;
    from += sizeof header + (size_t)header.count * PLACE_BYTES;
  }
  HC_CHECK(from == end, "halo message of rank %d is damaged", message->rank);
  return ghosts;
}

static int32_t enter_ghosts(hc_particles *particles, hc_cells *cells, const hc_message *message,
                            int32_t next) {
  const char *from = message->data, *end = from + message->bytes;
  while (from < end) {
    cell_header header;
    memcpy(&header, from, sizeof header);
    from += sizeof header;
    const int32_t brick = hc_cells_insert(cells, header.brick);
    HC_CHECK(cells->count[brick][header.cell] == 0, "rank %d sent a cell that is not its own", message->rank);
    cells->begin[brick][header.cell] = next;
    cells->count[brick][header.cell] = header.count;
    for (int32_t k = 0; k < header.count; k++, next++, from += PLACE_BYTES) {
      memcpy(particles->place[next].x, from, PLACE_BYTES);
      particles->place[next].scalar = 0.0f;
    }
  }
  return next;
}

void hc_halo_build(hc_halo *halo, hc_cells *cells) {
  HC_CHECK(!halo->fields, "a refresh is still under way");
  halo->source = cells;
  if (halo->cell_count) qsort(halo->cells, (size_t)halo->cell_count, sizeof *halo->cells, compare_halo_cells);
  find_partners(halo);
  count_copies(halo, cells);
  write_cells(halo, cells);

  hc_message *in;
  int in_count;
  hc_domain_exchange(halo->domain, halo->particles, halo->send, halo->send_count, &in, &in_count);
  hc_reserve((void **)&halo->receive, &halo->capacity[2], (size_t)in_count, 0, sizeof *halo->receive);
  hc_reserve((void **)&halo->ghost_begin, &halo->capacity[3], (size_t)in_count + 1, 0,
             sizeof *halo->ghost_begin);
  halo->receive_count = in_count;
  int32_t ghosts = 0;
  for (int m = 0; m < in_count; m++) {
    halo->receive[m].rank = in[m].rank;
    halo->ghost_begin[m] = ghosts;
    ghosts += count_ghosts(&in[m]);
  }
  halo->ghost_begin[in_count] = ghosts;
  hc_particles_set_ghosts(halo->particles, ghosts);
  int32_t next = halo->particles->own;
  for (int m = 0; m < in_count; m++) next = enter_ghosts(halo->particles, cells, &in[m], next);
  hc_messages_free(in, in_count);
  hc_reserve((void **)&halo->requests, &halo->requests_capacity, (size_t)(halo->send_count + in_count), 0,
             sizeof *halo->requests);
}
