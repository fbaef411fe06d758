#include "particles.h"

#include "base/check.h"
#include "base/memory.h"

#include <string.h>

const hc_field_info hc_fields[HC_FIELD_COUNT] = {
#define HC_FIELD(name, type, components, flags, needs, unit, sentence)                                       \
  {#name, HC_TYPE_##type, components, (components) * sizeof(hc_field_##type), flags, needs, unit, sentence},
#include "fields.def"
#undef HC_FIELD
};

static bool has(const hc_particles *particles, int field) {
  return hc_field_is_there(&hc_fields[field], particles->kind, particles->features);
}

static bool is_carried(const hc_particles *particles, int field) {
  return has(particles, field) && (hc_fields[field].flags & HC_CARRIED);
}

/* Records of joined stores stand in the arrays of the first. */
static bool is_record(int field) {
  return hc_fields[field].type == HC_TYPE_record;
}

/* Elements an array must hold: own particles, or ghosts and the spare elements too. */
static size_t extent(const hc_particles *particles, int field) {
  const size_t own = (size_t)particles->own;
  return hc_field_has_ghosts(&hc_fields[field], particles->features)
             ? own + (size_t)particles->ghosts + HC_SPARE
             : own;
}

void hc_particles_init(hc_particles *particles, unsigned kind, unsigned features) {
  HC_CHECK(kind == HC_FLUID || kind == HC_BOUNDARY || kind == (HC_BOUNDARY | HC_MOVED) || kind == HC_INFLOW ||
               kind == HC_WINDOW,
           "a store holds one kind, got %u", kind);
  memset(particles, 0, sizeof *particles);
  particles->kind = kind;
  particles->features = features;
  hc_particles_resize(particles, 0);
}

void hc_particles_free(hc_particles *particles) {
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if (!particles->head || !is_record(field)) hc_free(particles->data[field]);
  hc_free(particles->scratch);
  memset(particles, 0, sizeof *particles);
}

/* Makes room for the records of a store, and of the one that shares them, keeping the first `keep`. */
static void fit_records(hc_particles *particles, size_t keep) {
  hc_particles *holder = particles->head ? particles->head : particles, *tail = holder->tail;
  const size_t first = (size_t)holder->own + (size_t)holder->ghosts;
  const size_t all = first + (tail ? (size_t)tail->own + (size_t)tail->ghosts : 0);
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_record(field) || !has(holder, field)) continue;
    hc_reserve(&holder->data[field], &holder->capacity[field], all + HC_SPARE, keep, sizeof(hc_record));
    hc_record *records = holder->data[field];
    memset(records + all, 0, HC_SPARE * sizeof *records);
    if (tail) tail->data[field] = records + first;
  }
}

void hc_particles_join(hc_particles *head, hc_particles *tail) {
  HC_CHECK(head->own == 0 && tail->own == 0 && !head->head && !tail->tail, "only empty stores can be joined");
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_record(field)) continue;
    HC_CHECK(has(head, field) == has(tail, field), "joined stores must have the same records");
    hc_free(tail->data[field]);
    tail->data[field] = NULL;
    tail->capacity[field] = 0;
  }
  head->tail = tail;
  tail->head = head;
  fit_records(head, 0);
}

void hc_particles_resize(hc_particles *particles, int32_t own) {
  HC_CHECK(own >= 0, "particle count must not be negative, got %d", own);
  HC_CHECK(!particles->under_way, "a store's size must not change while its ghosts are refreshed");
  const size_t old = (size_t)particles->own, now = (size_t)own;
  particles->own = own;
  particles->border = particles->ghosts = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!has(particles, field) || is_record(field)) continue;
    const size_t bytes = hc_fields[field].bytes;
    const bool carried = is_carried(particles, field);
    const size_t keep = !carried ? 0 : old < now ? old : now;
    hc_reserve(&particles->data[field], &particles->capacity[field], extent(particles, field), keep, bytes);
    if (carried && now > old) memset((char *)particles->data[field] + old * bytes, 0, (now - old) * bytes);
  }
  fit_records(particles, (size_t)hc_particles_first(particles));
}

void hc_particles_set_ghosts(hc_particles *particles, int32_t ghosts) {
  HC_CHECK(ghosts >= 0, "ghost count must not be negative, got %d", ghosts);
  const size_t own = (size_t)particles->own;
  particles->ghosts = ghosts;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!has(particles, field) || !hc_field_has_ghosts(&hc_fields[field], particles->features) ||
        is_record(field))
      continue;
    const size_t bytes = hc_fields[field].bytes, all = extent(particles, field);
    hc_reserve(&particles->data[field], &particles->capacity[field], all, own, bytes);
    memset((char *)particles->data[field] + (all - HC_SPARE) * bytes, 0, HC_SPARE * bytes);
  }
  fit_records(particles, (size_t)hc_particles_first(particles) + own);
}

void *hc_particles_scratch(hc_particles *particles, size_t bytes) {
  hc_reserve(&particles->scratch, &particles->scratch_capacity, (size_t)particles->own * bytes, 0, 1);
  return particles->scratch;
}

/* Permutes elements of `bytes`, by way of room for 16 bytes of each particle, and for 8 more. */
static void permute(char *restrict data, size_t bytes, const int32_t *restrict order, int32_t count,
                    char *restrict room, char *restrict more) {
  switch (bytes) {
  case 4:
    for (int32_t k = 0; k < count; k++) memcpy(room + 4 * (size_t)k, data + 4 * (size_t)order[k], 4);
    break;
  case 8:
    for (int32_t k = 0; k < count; k++) memcpy(room + 8 * (size_t)k, data + 8 * (size_t)order[k], 8);
    break;
  case 12:
    for (int32_t k = 0; k < count; k++) memcpy(room + 12 * (size_t)k, data + 12 * (size_t)order[k], 12);
    break;
  case 24:
    for (int32_t k = 0; k < count; k++) {
      memcpy(room + 16 * (size_t)k, data + 24 * (size_t)order[k], 16);
      memcpy(more + 8 * (size_t)k, data + 24 * (size_t)order[k] + 16, 8);
    }
    for (int32_t k = 0; k < count; k++) {
      memcpy(data + 24 * (size_t)k, room + 16 * (size_t)k, 16);
      memcpy(data + 24 * (size_t)k + 16, more + 8 * (size_t)k, 8);
    }
    return;
  default:
    HC_CHECK(false, "a carried field has 4, 8, 12 or 24 bytes, got %zu", bytes);
  }
  memcpy(data, room, (size_t)count * bytes);
}

void hc_particles_permute(hc_particles *particles, const int32_t *order, int32_t count) {
  /* Records are packed anew after a sort, so they lend their room; the order may stand first in the scratch.
   */
  char *more =
      (char *)hc_particles_scratch(particles, sizeof *order + sizeof(double)) + (size_t)count * sizeof *order;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if (is_carried(particles, field))
      permute(particles->data[field], hc_fields[field].bytes, order, count, (char *)particles->place, more);
  particles->own = count;
}

void hc_particles_trim(hc_particles *particles) {
  hc_free(particles->scratch);
  particles->scratch = NULL;
  particles->scratch_capacity = 0;
}

size_t hc_particles_block_bytes(const hc_particles *particles) {
  size_t bytes = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if (is_carried(particles, field)) bytes += hc_fields[field].bytes;
  return bytes;
}

void hc_particles_pack(const hc_particles *particles, int32_t index, void *block) {
  char *to = block;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_carried(particles, field)) continue;
    const size_t bytes = hc_fields[field].bytes;
    memcpy(to, (const char *)particles->data[field] + (size_t)index * bytes, bytes);
    to += bytes;
  }
}

void hc_particles_unpack(hc_particles *particles, int32_t index, const void *block) {
  const char *from = block;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_carried(particles, field)) continue;
    const size_t bytes = hc_fields[field].bytes;
    memcpy((char *)particles->data[field] + (size_t)index * bytes, from, bytes);
    from += bytes;
  }
}

size_t hc_particles_state_bytes(unsigned kind, unsigned features) {
  size_t bytes = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if (hc_field_is_there(&hc_fields[field], kind, features) && hc_field_is_state(&hc_fields[field]))
      bytes += hc_fields[field].bytes;
  return bytes;
}

size_t hc_particles_bytes(unsigned kind, unsigned features) {
  size_t bytes = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if (hc_field_is_there(&hc_fields[field], kind, features)) bytes += hc_fields[field].bytes;
  return bytes;
}

void hc_particles_remove(hc_particles *particles, const int32_t *indices, int32_t count) {
  if (count == 0) return;
  void *block = hc_alloc(1, hc_particles_block_bytes(particles));
  int32_t end = particles->own, last = count - 1;
  for (int32_t k = 0; k < count; k++) {
    while (last >= 0 && indices[last] == end - 1) {
      last--;
      end--;
    }
    if (indices[k] >= end) break;
    hc_particles_pack(particles, --end, block);
    hc_particles_unpack(particles, indices[k], block);
  }
  hc_particles_resize(particles, particles->own - count);
  hc_free(block);
}
