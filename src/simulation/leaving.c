#include "leaving.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void hc_leaving_watch(const hc_world *world, const hc_limits *limits, hc_fault *fault) {
  const hc_particles *fluid = &world->fluid;
  for (int32_t k = 0; k < fluid->own; k++)
    if (!hc_limits_hold(limits, &fluid->position[3 * (size_t)k]))
      hc_fault_note(fault, HC_FAULT_LEFT, 0.0, fluid->id[k]);
}

static int by_id(const void *a, const void *b) {
  const hc_departure *p = a, *q = b;
  return (p->id > q->id) - (p->id < q->id);
}

/* The first by id, of all ranks: each sends the first of its own. */
static void name_first(hc_world *world, hc_departure *own, size_t count, hc_departures *departures) {
  if (count) qsort(own, count, sizeof *own, by_id);
  void *gathered;
  size_t bytes;
  hc_comm_gather_all(world->comm, own, (count < HC_LEAVING_NAMED ? count : HC_LEAVING_NAMED) * sizeof *own,
                     &gathered, &bytes);
  const size_t all = bytes / sizeof *own;
  qsort(gathered, all, sizeof *own, by_id);
  departures->named = all < HC_LEAVING_NAMED ? (int)all : HC_LEAVING_NAMED;
  memcpy(departures->first, gathered, (size_t)departures->named * sizeof *own);
  hc_free(gathered);
}

void hc_leaving_remove(hc_world *world, const hc_limits *limits, hc_departures *departures) {
  hc_particles *fluid = &world->fluid;
  int32_t *indices = NULL;
  size_t capacity = 0, count = 0;
  for (int32_t k = 0; k < fluid->own; k++) {
    if (hc_limits_hold(limits, &fluid->position[3 * (size_t)k])) continue;
    hc_reserve((void **)&indices, &capacity, count + 1, count, sizeof *indices);
    indices[count++] = k;
  }
  memset(departures, 0, sizeof *departures);
  departures->count = (int64_t)count;
  hc_comm_sum_i64(world->comm, &departures->count, 1);
  if (departures->count > 0) {
    hc_departure *own = hc_alloc_zero(count, sizeof *own);
    for (size_t k = 0; k < count; k++) {
      own[k].id = fluid->id[indices[k]];
      for (int axis = 0; axis < 3; axis++)
        own[k].at[axis] =
            hc_frame_to_metres(&world->frame, axis, fluid->position[3 * (size_t)indices[k] + (size_t)axis]);
    }
    name_first(world, own, count, departures);
    hc_particles_remove(fluid, indices, (int32_t)count);
    world->fluid_total -= departures->count;
    hc_free(own);
  }
  hc_free(indices);
}
