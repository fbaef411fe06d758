/* Migration: own particles whose cell belongs to another rank go there, however far away it is. */
#include "domain.h"

#include "base/memory.h"

#include <stdlib.h>

typedef struct leaver {
  int rank;
  int32_t index;
} leaver;

static int by_rank(const void *a, const void *b) {
  const leaver *p = a, *q = b;
  if (p->rank != q->rank) return p->rank < q->rank ? -1 : 1;
  return p->index < q->index ? -1 : p->index > q->index;
}

static int32_t find_leavers(const hc_domain *domain, const hc_particles *particles, leaver **leavers) {
  const hc_map *map = &domain->map;
  *leavers = NULL;
  size_t capacity = 0;
  int32_t count = 0;
  hc_brick last = {{0, 0, 0}};
  int owner = -1;
  for (int32_t k = 0; k < particles->own; k++) {
    int64_t cell[3];
    for (int axis = 0; axis < 3; axis++)
      cell[axis] = hc_frame_cell(particles->position[3 * (size_t)k + axis]);
    const hc_brick brick = hc_map_brick(map, map->bits, cell);
    if (owner < 0 || !hc_brick_equal(brick, last)) {
      owner = hc_map_owner(map, brick);
      last = brick;
    }
    if (owner == domain->comm->rank) continue;
    hc_reserve((void **)leavers, &capacity, (size_t)count + 1, (size_t)count, sizeof **leavers);
    (*leavers)[count++] = (leaver){owner, k};
  }
  return count;
}

static int ascending(const void *a, const void *b) {
  const int32_t p = *(const int32_t *)a, q = *(const int32_t *)b;
  return p < q ? -1 : p > q;
}

int32_t hc_domain_migrate(hc_domain *domain, hc_particles *particles) {
  hc_particles_resize(particles, particles->own); /* ghosts go */
  if (domain->comm->size == 1) return 0;
  leaver *leavers;
  const int32_t count = find_leavers(domain, particles, &leavers);
  if (count) qsort(leavers, (size_t)count, sizeof *leavers, by_rank);

  const size_t bytes = hc_particles_block_bytes(particles);
  char *buffer = hc_alloc((size_t)count, bytes);
  int32_t *holes = hc_alloc((size_t)count, sizeof *holes);
  hc_message *out = hc_alloc((size_t)count, sizeof *out);
  int messages = 0;
  for (int32_t k = 0; k < count; k++) {
    char *block = buffer + (size_t)k * bytes;
    hc_particles_pack(particles, leavers[k].index, block);
    holes[k] = leavers[k].index;
    if (k == 0 || leavers[k].rank != leavers[k - 1].rank)
      out[messages++] = (hc_message){leavers[k].rank, 0, block};
    out[messages - 1].bytes += bytes;
  }
  if (count) {
    qsort(holes, (size_t)count, sizeof *holes, ascending);
    hc_particles_remove(particles, holes, count);
  }

  hc_message *in;
  int in_count;
  hc_domain_exchange(domain, particles, out, messages, &in, &in_count);
  for (int m = 0; m < in_count; m++) {
    const int32_t first = particles->own, arrivals = (int32_t)(in[m].bytes / bytes);
    hc_particles_resize(particles, first + arrivals);
    for (int32_t k = 0; k < arrivals; k++)
      hc_particles_unpack(particles, first + k, (const char *)in[m].data + (size_t)k * bytes);
  }
  hc_messages_free(in, in_count);
  hc_free(out);
  hc_free(holes);
  hc_free(buffer);
  hc_free(leavers);
  return count;
}
