#include "population.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

void hc_population_free(hc_population *population) {
  hc_emitters_free(&population->emitters);
  hc_absorption_free(&population->absorption);
}

void hc_population_register(hc_population *population, hc_state *state) {
  hc_emitters_register(&population->emitters, state);
  hc_absorption_register(&population->absorption, state);
}

/* What is no limit stays none. */
static int64_t go(int64_t limit, int64_t shift) {
  return limit == INT64_MIN || limit == INT64_MAX ? limit : limit + shift;
}

void hc_population_go(hc_population *population, const hc_frame *frame, const int64_t shift[3]) {
  for (int a = 0; a < 3; a++) {
    population->limits.low[a] = go(population->at_start.low[a], shift[a]);
    population->limits.high[a] = go(population->at_start.high[a], shift[a]);
  }
  if (population->absorption.count > 0) hc_places_go(&population->absorption.places, frame, shift);
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

/* Own particles that go, ascending. */
typedef struct leavers {
  int32_t *indices;
  size_t count, room;
} leavers;

static void add_leaver(leavers *leavers, int32_t index) {
  hc_reserve((void **)&leavers->indices, &leavers->room, 2 * leavers->count + 64, leavers->count,
             sizeof *leavers->indices);
  leavers->indices[leavers->count++] = index;
}

/* Those beyond the limits. */
static void find_leavers(hc_population *population, hc_world *world, double time, leavers *leavers) {
  const hc_particles *fluid = world->fluid;
  memset(&population->departures, 0, sizeof population->departures);
  if (!population->remove) return;
  const bool counted = population->counted && population->beyond_time == time;
  if (counted && population->beyond == 0) return;
  for (int32_t k = 0; k < fluid->own; k++)
    if (!hc_limits_hold(&population->limits, &fluid->position[3 * (size_t)k])) add_leaver(leavers, k);
  population->departures.count = counted ? population->beyond : (int64_t)leavers->count;
  if (!counted) hc_comm_sum_i64(world->comm, &population->departures.count, 1);
}

/* Remembers where the first ones were. */
static void name_leavers(hc_population *population, hc_world *world, const leavers *leavers) {
  const hc_particles *fluid = world->fluid;
  hc_departure *own = hc_alloc_zero(leavers->count, sizeof *own);
  for (size_t k = 0; k < leavers->count; k++) {
    const size_t index = (size_t)leavers->indices[k];
    own[k].id = fluid->id[index];
    for (int axis = 0; axis < 3; axis++)
      own[k].at[axis] = hc_frame_to_metres(&world->frame, axis, fluid->position[3 * index + (size_t)axis]);
  }
  name_first(world, own, leavers->count, &population->departures);
  hc_free(own);
}

/* ---- walls that absorb ---- */

/* Those that walls take out, but for who leaves anyway. */
static void find_absorbed(hc_population *population, const hc_world *world, const leavers *gone,
                          leavers *leavers) {
  hc_absorption *const absorption = &population->absorption;
  size_t next = 0;
  for (int32_t k = 0; k < world->fluid->own; k++) {
    if (next < gone->count && gone->indices[next] == k) {
      next++;
      continue;
    }
    const int absorber = hc_absorption_takes(absorption, world, k);
    if (absorber < 0) continue;
    add_leaver(leavers, k);
    absorption->absorbers[absorber].leaving++;
  }
}

/* Adds up over the ranks what comes and goes at walls. */
static void count_absorbed(hc_population *population, hc_world *world) {
  hc_absorption *const absorption = &population->absorption;
  int64_t *const counts = hc_alloc((size_t)absorption->count, 2 * sizeof *counts);
  for (int n = 0; n < absorption->count; n++) {
    hc_absorber *const absorber = &absorption->absorbers[n];
    counts[2 * n] = absorber->coming;
    counts[2 * n + 1] = absorber->leaving;
    absorber->coming = absorber->leaving = 0;
  }
  hc_comm_sum_i64(world->comm, counts, 2 * absorption->count);
  for (int n = 0; n < absorption->count; n++) {
    absorption->absorbers[n].came += counts[2 * n];
    absorption->absorbers[n].went += counts[2 * n + 1];
    population->came += counts[2 * n];
    population->went += counts[2 * n + 1];
  }
  hc_free(counts);
}

static void absorb(hc_population *population, hc_world *world, const leavers *gone, leavers *absorbed,
                   hc_arrivals *arrivals) {
  if (population->absorption.count == 0) return;
  hc_absorption_look(&population->absorption, world, arrivals);
  find_absorbed(population, world, gone, absorbed);
  count_absorbed(population, world);
  if (population->came > 0) hc_absorption_let_in(&population->absorption, world, arrivals);
}

/* ---- applied ---- */

static void remove_all(hc_world *world, const leavers *gone, const leavers *absorbed) {
  const size_t count = gone->count + absorbed->count;
  int32_t *const all = hc_alloc(count, sizeof *all);
  for (size_t k = 0, g = 0, a = 0; k < count; k++) {
    const bool next_gone =
        a == absorbed->count || (g < gone->count && gone->indices[g] < absorbed->indices[a]);
    all[k] = next_gone ? gone->indices[g++] : absorbed->indices[a++];
  }
  if (count > 0) hc_particles_remove(world->fluid, all, (int32_t)count);
  hc_free(all);
}

/* ---- all together ---- */

static int64_t count_blocked(const hc_emitters *emitters) {
  int64_t blocked = 0;
  for (int k = 0; k < emitters->count; k++) blocked += emitters->emitters[k].blocked;
  return blocked;
}

bool hc_population_change(hc_population *population, hc_world *world, double time, bool absorbs) {
  hc_emitters *emitters = &population->emitters;
  leavers gone = {.indices = NULL}, absorbed = {.indices = NULL};
  hc_arrivals arrivals = {.count = 0};
  population->came = population->went = 0;
  find_leavers(population, world, time, &gone);
  if (absorbs) absorb(population, world, &gone, &absorbed, &arrivals);
  const int64_t blocked = count_blocked(emitters);
  population->emitted = hc_emitters_release(emitters, &world->domain, world->cells, world->fluid, time);
  population->blocked = count_blocked(emitters) - blocked;
  const int64_t departed = population->departures.count;
  const int64_t came = population->emitted + population->came, went = departed + population->went;
  if (departed > 0) name_leavers(population, world, &gone);
  if (population->came > 0) hc_arrivals_append(&arrivals, world->fluid);
  if (went > 0) remove_all(world, &gone, &absorbed);
  hc_free(gone.indices);
  hc_free(absorbed.indices);
  hc_arrivals_free(&arrivals);
  world->fluid_total += came - went;
  return came > 0 || went > 0;
}
