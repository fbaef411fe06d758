#include "partners.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Cells around a brick that decide who has to do with it, and those whose bricks are in reach of it. */
enum { BESIDE = 1, REACH = HC_BRICK_EDGE, MOST_AROUND = HC_BRICK_EDGE + 2 * REACH };

void hc_partners_init(hc_partners *partners) {
  memset(partners, 0, sizeof *partners);
  hc_brick_set_init(&partners->covered);
}

void hc_partners_free(hc_partners *partners) {
  hc_free(partners->ranks);
  hc_brick_set_free(&partners->covered);
  memset(partners, 0, sizeof *partners);
}

/* ---- around a brick ---- */

/* The cells from `margin` before to `margin` behind a brick, along each axis, through periodic borders. */
typedef struct around {
  int64_t cell[3][MOST_AROUND];
  int count;    /* along each axis */
  bool wrapped; /* some are beyond a periodic border */
} around;

static around look_around(const hc_frame *frame, hc_brick brick, int margin) {
  around a = {.count = HC_BRICK_EDGE + 2 * margin};
  for (int axis = 0; axis < 3; axis++) {
    const int64_t first = hc_frame_cell(frame->low[axis]), period = hc_frame_cell(frame->period[axis]);
    for (int k = 0; k < a.count; k++) {
      int64_t cell = (int64_t)brick.x[axis] * HC_BRICK_EDGE + k - margin;
      if (period > 0 && (cell < first || cell >= first + period)) {
        const int64_t offset = (cell - first) % period;
        cell = first + (offset < 0 ? offset + period : offset);
        a.wrapped = true;
      }
      a.cell[axis][k] = cell;
    }
  }
  return a;
}

/* A set of ranks, ascending. */
typedef struct crowd {
  int32_t *ranks;
  int32_t count;
  size_t room;
} crowd;

static bool is_in(const int32_t *ranks, int32_t count, int32_t rank, int32_t *place) {
  int32_t low = 0, high = count;
  while (low < high) {
    const int32_t middle = low + (high - low) / 2;
    if (ranks[middle] < rank)
      low = middle + 1;
    else
      high = middle;
  }
  *place = low;
  return low < count && ranks[low] == rank;
}

static void join(crowd *crowd, int32_t rank) {
  int32_t place;
  if (is_in(crowd->ranks, crowd->count, rank, &place)) return;
  hc_reserve((void **)&crowd->ranks, &crowd->room, (size_t)crowd->count + 1, (size_t)crowd->count,
             sizeof *crowd->ranks);
  memmove(crowd->ranks + place + 1, crowd->ranks + place,
          (size_t)(crowd->count - place) * sizeof *crowd->ranks);
  crowd->ranks[place] = rank;
  crowd->count++;
}

/* Who owns a cell of or beside the brick. */
static void find_owners(const hc_partners_of *of, hc_brick brick, crowd *owners) {
  const around a = look_around(of->frame, brick, BESIDE);
  owners->count = 0;
  if (!a.wrapped) {
    const int last = a.count - 1;
    const int64_t low[3] = {a.cell[0][0], a.cell[1][0], a.cell[2][0]},
                  high[3] = {a.cell[0][last], a.cell[1][last], a.cell[2][last]};
    const int owner = hc_map_owner_of_box(of->map, low, high);
    if (owner != HC_MAP_MIXED) {
      join(owners, owner);
      return;
    }
  }
  int before = -1;
  for (int k = 0; k < a.count * a.count * a.count; k++) {
    const int64_t cell[3] = {a.cell[0][k % a.count], a.cell[1][k / a.count % a.count],
                             a.cell[2][k / a.count / a.count]};
    const int owner = hc_map_owner(of->map, hc_map_brick(of->map, of->map->bits, cell));
    if (owner != before) join(owners, owner);
    before = owner;
  }
}

/* The bricks along an axis that hold any of the cells. */
static int bricks_along(const around *a, int axis, int32_t bricks[MOST_AROUND]) {
  int count = 0;
  for (int k = 0; k < a->count; k++) {
    const int32_t brick = (int32_t)(a->cell[axis][k] >> HC_BRICK_BITS);
    bool found = false;
    for (int n = 0; n < count; n++) found |= bricks[n] == brick;
    if (!found) bricks[count++] = brick;
  }
  return count;
}

static void add_reach(const hc_frame *frame, hc_brick brick, hc_brick_set *reach) {
  const around a = look_around(frame, brick, REACH);
  int32_t x[MOST_AROUND], y[MOST_AROUND], z[MOST_AROUND];
  const int nx = bricks_along(&a, 0, x), ny = bricks_along(&a, 1, y), nz = bricks_along(&a, 2, z);
  for (int k = 0; k < nx * ny * nz; k++)
    hc_brick_set_add(reach, (hc_brick){{x[k % nx], y[k / nx % ny], z[k / nx / ny]}});
}

/* ---- learning ---- */

/* A brick in reach, for a rank that has to do with it. */
typedef struct notice {
  hc_brick brick;
  int32_t rank;
} notice;

typedef struct notices {
  notice *list;
  size_t count, room;
} notices;

static int by_rank(const void *a, const void *b) {
  const notice *p = a, *q = b;
  return (p->rank > q->rank) - (p->rank < q->rank);
}

static void find_reach(const hc_frame *frame, const hc_particles *particles, hc_brick_set *reach) {
  hc_brick_set occupied;
  hc_brick_set_init(&occupied);
  for (int32_t k = 0; k < particles->own; k++) {
    hc_brick brick;
    hc_cell_of(&particles->position[3 * (size_t)k], &brick);
    const int32_t before = occupied.count;
    if (hc_brick_set_add(&occupied, brick) == before) add_reach(frame, brick, reach);
  }
  hc_brick_set_free(&occupied);
}

/* Covers what is in reach, and writes notices for all others who have to do with it. */
static void cover_reach(hc_partners *partners, const hc_partners_of *of, crowd *all, notices *notices) {
  hc_brick_set reach;
  crowd owners = {.ranks = NULL};
  hc_brick_set_init(&reach);
  find_reach(of->frame, partners->particles, &reach);
  for (int32_t k = 0; k < reach.count; k++) {
    find_owners(of, reach.bricks[k], &owners);
    for (int32_t n = 0; n < owners.count; n++) {
      if (owners.ranks[n] == of->comm->rank) continue;
      hc_brick_set_add(&partners->covered, reach.bricks[k]);
      join(all, owners.ranks[n]);
      hc_reserve((void **)&notices->list, &notices->room, notices->count + 1, notices->count,
                 sizeof *notices->list);
      notices->list[notices->count++] = (notice){reach.bricks[k], owners.ranks[n]};
    }
  }
  hc_free(owners.ranks);
  hc_brick_set_free(&reach);
}

/* Covers bricks in another's reach that we have to do with. */
static void take_notices(hc_partners *partners, const hc_partners_of *of, const hc_message *message,
                         crowd *all) {
  crowd owners = {.ranks = NULL};
  join(all, message->rank);
  for (size_t at = 0; at < message->bytes; at += sizeof(notice)) {
    notice notice;
    memcpy(&notice, (const char *)message->data + at, sizeof notice);
    hc_brick_set_add(&partners->covered, notice.brick);
    find_owners(of, notice.brick, &owners);
    for (int32_t n = 0; n < owners.count; n++)
      if (owners.ranks[n] != of->comm->rank) join(all, owners.ranks[n]);
  }
  hc_free(owners.ranks);
}

void hc_partners_learn(hc_partners *partners, const hc_partners_of *of, const hc_particles *particles) {
  crowd all = {partners->ranks, 0, partners->room};
  notices notices = {.list = NULL};
  partners->particles = particles;
  hc_brick_set_clear(&partners->covered);
  cover_reach(partners, of, &all, &notices);
  if (notices.count) qsort(notices.list, notices.count, sizeof *notices.list, by_rank);
  hc_message *out = hc_alloc((size_t)all.count, sizeof *out), *in;
  int messages = 0, in_count;
  for (size_t k = 0; k < notices.count; k++) {
    if (k == 0 || notices.list[k].rank != notices.list[k - 1].rank)
      out[messages++] = (hc_message){notices.list[k].rank, 0, &notices.list[k]};
    out[messages - 1].bytes += sizeof *notices.list;
  }
  hc_comm_sparse(of->comm, out, messages, &in, &in_count);
  for (int m = 0; m < in_count; m++) take_notices(partners, of, &in[m], &all);
  hc_messages_free(in, in_count);
  hc_free(out);
  hc_free(notices.list);
  partners->ranks = all.ranks;
  partners->count = all.count;
  partners->room = all.room;
  partners->known = true;
}

/* ---- watching ---- */

/* A brick that only one other rank has to do with needs no notice, if that is a partner. */
static bool covers(hc_partners *partners, const hc_partners_of *of, hc_brick brick, crowd *owners) {
  if (hc_brick_set_find(&partners->covered, brick) >= 0) return true;
  find_owners(of, brick, owners);
  int others = 0;
  for (int32_t n = 0; n < owners->count; n++) {
    int32_t place;
    if (owners->ranks[n] == of->comm->rank) continue;
    if (++others > 1 || !is_in(partners->ranks, partners->count, owners->ranks[n], &place)) return false;
  }
  hc_brick_set_add(&partners->covered, brick);
  return true;
}

bool hc_partners_cover(hc_partners *partners, const hc_partners_of *of) {
  const hc_particles *particles = partners->particles;
  crowd owners = {.ranks = NULL};
  hc_brick last = {{0, 0, 0}};
  bool covered = true;
  for (int32_t k = 0; k < particles->own && covered; k++) {
    hc_brick brick;
    hc_cell_of(&particles->position[3 * (size_t)k], &brick);
    if (k > 0 && hc_brick_equal(brick, last)) continue;
    covered = covers(partners, of, brick, &owners);
    last = brick;
  }
  hc_free(owners.ranks);
  return covered;
}
