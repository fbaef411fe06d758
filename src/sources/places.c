#include "places.h"

#include "particles/ids.h"

#include <string.h>

int64_t hc_sample_number(const hc_sample_numbers *numbers, uint64_t id) {
  return numbers->first[hc_id_source_of(id)] + hc_id_counter_of(id);
}

void hc_places_init(hc_places *places, unsigned kind) {
  memset(places, 0, sizeof *places);
  hc_particles_init(&places->store, kind, 0);
  places->moved = true;
}

void hc_places_free(hc_places *places) {
  hc_particles_free(&places->store);
  memset(places, 0, sizeof *places);
}

void hc_places_add(hc_places *places, const hc_arrivals *added) {
  hc_particles *const store = &places->store;
  const size_t first = (size_t)store->own;
  hc_particles_resize(store, (int32_t)(first + added->count));
  for (size_t k = 0; k < added->count; k++) {
    store->id[first + k] = added->at[k].id;
    memcpy(&store->position[3 * (first + k)], added->at[k].x, sizeof added->at[k].x);
  }
  places->moved = true;
}

void hc_places_translate(hc_particles *store, const hc_frame *frame, const int64_t by[3]) {
  for (size_t k = 0; k < (size_t)store->own; k++)
    for (int a = 0; a < 3; a++)
      store->position[3 * k + (size_t)a] =
          hc_frame_wrap(frame, a, store->position[3 * k + (size_t)a] + by[a]);
}

void hc_places_go(hc_places *places, const hc_frame *frame, const int64_t shift[3]) {
  int64_t by[3];
  for (int a = 0; a < 3; a++) by[a] = shift[a] - places->shift[a];
  if (by[0] == 0 && by[1] == 0 && by[2] == 0) return;
  hc_places_translate(&places->store, frame, by);
  memcpy(places->shift, shift, sizeof places->shift);
  places->moved = true;
}

void hc_places_settle(hc_places *places, hc_domain *domain) {
  if (!places->moved && places->divisions == domain->divisions) return;
  hc_domain_migrate(domain, &places->store);
  places->divisions = domain->divisions;
  places->moved = false;
}
