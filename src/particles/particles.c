#include "particles.h"

#include "base/check.h"
#include "base/memory.h"

#include <string.h>

const hc_field_info hc_fields[HC_FIELD_COUNT] = {
#define HC_FIELD(name, type, components, flags, unit, sentence)                                              \
  {#name, HC_TYPE_##type, components, (components) * sizeof(hc_field_##type), flags, unit, sentence},
#include "fields.def"
#undef HC_FIELD
};

static bool has(const hc_particles *particles, int field) {
  return (hc_fields[field].flags & particles->kind) != 0;
}

static bool is_state(const hc_particles *particles, int field) {
  return has(particles, field) && (hc_fields[field].flags & HC_STATE);
}

/* Elements an array must hold: own particles, or ghosts and the spare elements too. */
static size_t extent(const hc_particles *particles, int field) {
  const size_t own = (size_t)particles->own;
  return (hc_fields[field].flags & HC_GHOST) ? own + (size_t)particles->ghosts + HC_SPARE : own;
}

void hc_particles_init(hc_particles *particles, unsigned kind) {
  HC_CHECK(kind == HC_FLUID || kind == HC_BOUNDARY, "a store holds one kind, got %u", kind);
  memset(particles, 0, sizeof *particles);
  particles->kind = kind;
  hc_particles_resize(particles, 0);
}

void hc_particles_free(hc_particles *particles) {
  for (int field = 0; field < HC_FIELD_COUNT; field++) hc_free(particles->data[field]);
  hc_free(particles->scratch);
  memset(particles, 0, sizeof *particles);
}

static void make_room(hc_particles *particles, size_t keep) {
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!has(particles, field)) continue;
    hc_reserve(&particles->data[field], &particles->capacity[field], extent(particles, field), keep,
               hc_fields[field].bytes);
  }
}

void hc_particles_resize(hc_particles *particles, int32_t own) {
  HC_CHECK(own >= 0, "particle count must not be negative, got %d", own);
  const size_t old = (size_t)particles->own, now = (size_t)own;
  particles->own = own;
  particles->border = particles->ghosts = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!has(particles, field)) continue;
    const size_t bytes = hc_fields[field].bytes;
    const bool state = is_state(particles, field);
    const size_t keep = !state ? 0 : old < now ? old : now;
    hc_reserve(&particles->data[field], &particles->capacity[field], extent(particles, field), keep, bytes);
    if (state && now > old) memset((char *)particles->data[field] + old * bytes, 0, (now - old) * bytes);
  }
}

void hc_particles_set_ghosts(hc_particles *particles, int32_t ghosts) {
  HC_CHECK(ghosts >= 0, "ghost count must not be negative, got %d", ghosts);
  particles->ghosts = ghosts;
  make_room(particles, (size_t)particles->own);
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!has(particles, field) || !(hc_fields[field].flags & HC_GHOST)) continue;
    const size_t bytes = hc_fields[field].bytes;
    memset((char *)particles->data[field] + (extent(particles, field) - HC_SPARE) * bytes, 0,
           HC_SPARE * bytes);
  }
}

void hc_particles_permute(hc_particles *particles, const int32_t *order, int32_t count) {
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_state(particles, field)) continue;
    const size_t bytes = hc_fields[field].bytes;
    hc_reserve(&particles->scratch, &particles->scratch_capacity, (size_t)count * bytes, 0, 1);
    const char *restrict from = particles->data[field];
    char *restrict to = particles->scratch;
    switch (bytes) {
    case 4:
      for (int32_t k = 0; k < count; k++) memcpy(to + 4 * (size_t)k, from + 4 * (size_t)order[k], 4);
      break;
    case 8:
      for (int32_t k = 0; k < count; k++) memcpy(to + 8 * (size_t)k, from + 8 * (size_t)order[k], 8);
      break;
    case 24:
      for (int32_t k = 0; k < count; k++) memcpy(to + 24 * (size_t)k, from + 24 * (size_t)order[k], 24);
      break;
    default:
      for (int32_t k = 0; k < count; k++)
        memcpy(to + bytes * (size_t)k, from + bytes * (size_t)order[k], bytes);
    }
    memcpy(particles->data[field], to, (size_t)count * bytes);
  }
  particles->own = count;
}

void *hc_particles_scratch(hc_particles *particles, size_t bytes) {
  hc_reserve(&particles->scratch, &particles->scratch_capacity, (size_t)particles->own * bytes, 0, 1);
  return particles->scratch;
}

size_t hc_particles_state_bytes(unsigned kind) {
  size_t bytes = 0;
  for (int field = 0; field < HC_FIELD_COUNT; field++)
    if ((hc_fields[field].flags & kind) && (hc_fields[field].flags & HC_STATE))
      bytes += hc_fields[field].bytes;
  return bytes;
}

void hc_particles_pack(const hc_particles *particles, int32_t index, void *block) {
  char *to = block;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_state(particles, field)) continue;
    const size_t bytes = hc_fields[field].bytes;
    memcpy(to, (const char *)particles->data[field] + (size_t)index * bytes, bytes);
    to += bytes;
  }
}

void hc_particles_unpack(hc_particles *particles, int32_t index, const void *block) {
  const char *from = block;
  for (int field = 0; field < HC_FIELD_COUNT; field++) {
    if (!is_state(particles, field)) continue;
    const size_t bytes = hc_fields[field].bytes;
    memcpy((char *)particles->data[field] + (size_t)index * bytes, from, bytes);
    from += bytes;
  }
}

void hc_particles_remove(hc_particles *particles, const int32_t *indices, int32_t count) {
  if (count == 0) return;
  void *block = hc_alloc(1, hc_particles_state_bytes(particles->kind));
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
