#include "absorption.h"

#include "base/check.h"
#include "base/memory.h"
#include "particles/ids.h"
#include "sph/kernel.h"

#include <math.h>
#include <string.h>

void hc_absorption_free(hc_absorption *absorption) {
  if (absorption->count > 0) hc_places_free(&absorption->places);
  hc_free(absorption->absorbers);
  hc_free(absorption->current);
  hc_free(absorption->samples.first);
  memset(absorption, 0, sizeof *absorption);
}

void hc_absorption_register(hc_absorption *absorption, hc_state *state) {
  if (absorption->count == 0) return;
  hc_state_add_store(state, &absorption->places.store);
  hc_state_add(state, HC_TYPE_i64, 3, absorption->places.shift, "absorption.shift");
  for (int k = 0; k < absorption->count; k++) {
    hc_state_add(state, HC_TYPE_i64, 1, &absorption->absorbers[k].came, "absorption.%d.came", k);
    hc_state_add(state, HC_TYPE_i64, 1, &absorption->absorbers[k].went, "absorption.%d.went", k);
  }
}

/* ---- where ---- */

/* A position, m, where the scene has it: as if walls had not gone along with a window. */
static void to_scene(const hc_absorption *absorption, const hc_frame *frame, const int64_t position[3],
                     double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = hc_frame_to_metres(frame, a, position[a] - absorption->places.shift[a]);
}

static double height_of(const hc_absorption *absorption, const double x[3]) {
  return absorption->up[0] * x[0] + absorption->up[1] * x[1] + absorption->up[2] * x[2];
}

/* From x to the wetted surface through the nearest periodic image, m. */
static double distance_to(const hc_frame *frame, const hc_absorber *absorber, const double x[3]) {
  double period[3];
  for (int a = 0; a < 3; a++) period[a] = (double)frame->period[a] * frame->unit[a];
  return hc_shape_nearest_image(hc_shape_surface_distance, &absorber->shape, period, x);
}

/* ---- places ---- */

/* The absorber in front of which a particle of the start has its place; -1: none. */
static int claims(const hc_absorption *absorption, const hc_world *world, int32_t k) {
  double x[3];
  to_scene(absorption, &world->frame, &world->fluid->position[3 * (size_t)k], x);
  const double height = height_of(absorption, x);
  const double half_spacing = (double)world->sweep.wall_offset * world->frame.support_radius;
  for (int n = 0; n < absorption->count; n++) {
    const hc_absorber *const absorber = &absorption->absorbers[n];
    if (absorber->density > 0.0 && height <= absorber->height - half_spacing &&
        distance_to(&world->frame, absorber, x) <= world->frame.support_radius)
      return n;
  }
  return -1;
}

static int absorber_of(const hc_absorption *absorption, uint64_t id) {
  return (int)(hc_id_source_of(id) - (int64_t)absorption->absorbers[0].source);
}

void hc_absorption_count(hc_absorption *absorption, const hc_world *world) {
  if (absorption->count == 0) return;
  const hc_particles *const places = &absorption->places.store;
  int64_t *const counts = hc_alloc_zero((size_t)absorption->count, sizeof *counts);
  for (int32_t k = 0; k < places->own; k++) counts[absorber_of(absorption, places->id[k])]++;
  hc_comm_sum_i64(world->comm, counts, absorption->count);
  for (int n = 0; n < absorption->count; n++) absorption->absorbers[n].places = counts[n];
  hc_free(counts);
  absorption->places.moved = true;
}

void hc_absorption_start(hc_absorption *absorption, const hc_world *world) {
  const hc_particles *const fluid = world->fluid;
  hc_arrivals found = {.count = 0};
  if (absorption->count == 0) return;
  for (int32_t k = 0; k < fluid->own; k++) {
    const int n = claims(absorption, world, k);
    if (n < 0) continue;
    const int64_t number = hc_sample_number(&absorption->samples, fluid->id[k]);
    hc_arrivals_add(&found, hc_id_make(HC_ID_FLUID, absorption->absorbers[n].source, (uint64_t)number),
                    &fluid->position[3 * (size_t)k]);
  }
  hc_places_add(&absorption->places, &found);
  hc_arrivals_free(&found);
  hc_absorption_count(absorption, world);
}

/* ---- outflow ---- */

int hc_absorption_takes(const hc_absorption *absorption, const hc_world *world, int32_t k) {
  double x[3];
  to_scene(absorption, &world->frame, &world->fluid->position[3 * (size_t)k], x);
  const double height = height_of(absorption, x);
  for (int n = 0; n < absorption->count; n++) {
    const hc_absorber *const absorber = &absorption->absorbers[n];
    if (height > absorber->height && absorber->reach > 0.0 &&
        distance_to(&world->frame, absorber, x) <= absorber->reach)
      return n;
  }
  return -1;
}

/* ---- inflow ---- */

/* What a place has around it: its density without a particle there, of the rest density; the velocities,
 * weighted by their shares of it. */
typedef struct around {
  double density, velocity[3];
} around;

/* Adds what a store gives. Its particles count by their own volumes where they have some, else by the
 * fluid's. */
static void add_store(const hc_absorption *absorption, const hc_world *world, hc_store_id id,
                      hc_vicinity *vicinity, const int64_t x[3], around *sum) {
  const hc_store *const store = &world->stores[id];
  const hc_particles *const particles = &store->particles;
  const bool walls = id != HC_STORE_FLUID, own_volumes = walls && world->sweep.walls_add == HC_WALLS_MIRRORED;
  const double volume = (double)world->sweep.volume, inverse = 1.0 / world->frame.support_radius;
  int cell;
  if (!hc_vicinity_find(vicinity, &store->cells, x, &cell)) return;
  for (int way = 0; way < HC_ADJACENT; way++) {
    int there;
    const int32_t found = hc_cells_next(vicinity->adjacent, cell, way, &there);
    if (found < 0) continue;
    const int32_t begin = store->cells.begin[found][there], end = begin + store->cells.count[found][there];
    for (int32_t j = begin; j < end; j++) {
      const double q = sqrt(hc_arrivals_square(&world->frame, particles, j, x)) * inverse;
      if (!(q < 1.0)) continue;
      const hc_record *const motion = &particles->motion[j];
      const double share = (own_volumes ? (double)particles->place[j].scalar : volume) *
                           (double)world->sweep.kernel * hc_kernel_shape(q);
      const double *const current =
          walls && absorption->current ? absorption->current[(int)motion->scalar] : NULL;
      sum->density += share;
      for (int a = 0; a < 3; a++)
        sum->velocity[a] += share * ((double)motion->v[a] + (current ? current[a] : 0.0));
    }
  }
}

/* `vicinities`: of each store. */
static around look_around(const hc_absorption *absorption, const hc_world *world, hc_vicinity *vicinities,
                          const int64_t x[3]) {
  around sum = {.density = 0.0};
  for (int id = 0; id < HC_STORE_COUNT; id++)
    add_store(absorption, world, (hc_store_id)id, &vicinities[id], x, &sum);
  return sum;
}

void hc_absorption_look(hc_absorption *absorption, hc_world *world, hc_arrivals *arrivals) {
  if (absorption->count == 0) return;
  hc_places_settle(&absorption->places, &world->domain);
  const hc_particles *const places = &absorption->places.store;
  const double itself = (double)world->sweep.volume * (double)world->sweep.kernel * hc_kernel_shape(0.0);
  hc_vicinity vicinities[HC_STORE_COUNT] = {{.known = false}};
  for (int32_t k = 0; k < places->own; k++) {
    hc_absorber *const absorber = &absorption->absorbers[absorber_of(absorption, places->id[k])];
    const int64_t *const x = &places->position[3 * (size_t)k];
    if (hc_arrivals_blocked(&world->frame, world->cells, world->fluid, &vicinities[HC_STORE_FLUID], x,
                            absorber->nearest) ||
        itself + look_around(absorption, world, vicinities, x).density >= absorber->density)
      continue;
    hc_arrivals_add(arrivals, places->id[k], x);
    absorber->coming++;
  }
}

void hc_absorption_let_in(hc_absorption *absorption, hc_world *world, hc_arrivals *arrivals) {
  hc_particles *const places = &absorption->places.store;
  hc_vicinity vicinities[HC_STORE_COUNT] = {{.known = false}};
  hc_halo_refresh(world->halo, HC_WHOLE(motion));
  size_t next = 0;
  for (int32_t k = 0; k < places->own && next < arrivals->count; k++) {
    hc_arrival *const arrival = &arrivals->at[next];
    if (places->id[k] != arrival->id) continue;
    const around found = look_around(absorption, world, vicinities, arrival->x);
    for (int a = 0; a < 3; a++)
      arrival->velocity[a] = found.density > 0.0 ? found.velocity[a] / found.density : 0.0;
    HC_CHECK(hc_id_counter_of(places->id[k]) + absorption->samples.count < HC_ID_MAX_COUNTER,
             "the ids of place %lld are used up", (long long)hc_id_counter_of(places->id[k]));
    places->id[k] += (uint64_t)absorption->samples.count;
    next++;
  }
}
