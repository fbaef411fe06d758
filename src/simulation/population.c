#include "population.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void hc_population_free(hc_population *population) {
  hc_emitters_free(&population->emitters);
}

void hc_population_register(hc_population *population, hc_state *state) {
  hc_emitters_register(&population->emitters, state);
}

double hc_population_speed(const hc_population *population, double time, double ahead) {
  return hc_emitters_speed(&population->emitters, time, ahead);
}

void hc_population_watch(hc_population *population, const hc_world *world, double time, hc_fault *fault,
                         hc_tally *tally) {
  const hc_particles *fluid = world->fluid;
  population->beyond = 0;
  for (int32_t k = 0; k < fluid->own; k++) {
    if (hc_limits_hold(&population->limits, &fluid->position[3 * (size_t)k])) continue;
    population->beyond++;
    if (!population->remove) hc_fault_note(fault, HC_FAULT_LEFT, 0.0, fluid->id[k]);
  }
  hc_tally_sum_i64(tally, &population->beyond, 1);
  population->beyond_time = time;
  population->counted = true;
}

/* ---- deaths ---- */

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

/* Own particles beyond the limits, ascending. */
typedef struct leavers {
  int32_t *indices;
  size_t count, room;
} leavers;

static void find_leavers(hc_population *population, hc_world *world, double time, leavers *leavers) {
  const hc_particles *fluid = world->fluid;
  memset(&population->departures, 0, sizeof population->departures);
  if (!population->remove) return;
  const bool counted = population->counted && population->beyond_time == time;
  if (counted && population->beyond == 0) return;
  for (int32_t k = 0; k < fluid->own; k++) {
    if (hc_limits_hold(&population->limits, &fluid->position[3 * (size_t)k])) continue;
    hc_reserve((void **)&leavers->indices, &leavers->room, leavers->count + 1, leavers->count,
               sizeof *leavers->indices);
    leavers->indices[leavers->count++] = k;
  }
  population->departures.count = counted ? population->beyond : (int64_t)leavers->count;
  if (!counted) hc_comm_sum_i64(world->comm, &population->departures.count, 1);
}

static void remove_leavers(hc_population *population, hc_world *world, const leavers *leavers) {
  hc_particles *fluid = world->fluid;
  hc_departure *own = hc_alloc_zero(leavers->count, sizeof *own);
  for (size_t k = 0; k < leavers->count; k++) {
    const size_t index = (size_t)leavers->indices[k];
    own[k].id = fluid->id[index];
    for (int axis = 0; axis < 3; axis++)
      own[k].at[axis] = hc_frame_to_metres(&world->frame, axis, fluid->position[3 * index + (size_t)axis]);
  }
  name_first(world, own, leavers->count, &population->departures);
  hc_particles_remove(fluid, leavers->indices, (int32_t)leavers->count);
  hc_free(own);
}

/* ---- all together ---- */

static int64_t count_blocked(const hc_emitters *emitters) {
  int64_t blocked = 0;
  for (int k = 0; k < emitters->count; k++) blocked += emitters->emitters[k].blocked;
  return blocked;
}

bool hc_population_change(hc_population *population, hc_world *world, double time) {
  hc_emitters *emitters = &population->emitters;
  leavers leavers = {.indices = NULL};
  find_leavers(population, world, time, &leavers);
  const int64_t blocked = count_blocked(emitters);
  population->emitted = hc_emitters_release(emitters, &world->domain, world->cells, world->fluid, time);
  population->blocked = count_blocked(emitters) - blocked;
  if (population->departures.count > 0) remove_leavers(population, world, &leavers);
  hc_free(leavers.indices);
  world->fluid_total += population->emitted - population->departures.count;
  return population->emitted > 0 || population->departures.count > 0;
}
