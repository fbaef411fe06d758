#include "state.h"

#include "base/check.h"
#include "base/memory.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

void hc_state_init(hc_state *state, hc_particles *fluid, hc_particles *boundary) {
  *state = (hc_state){.fluid = fluid, .boundary = boundary};
}

void hc_state_free(hc_state *state) {
  hc_free(state->items);
  memset(state, 0, sizeof *state);
}

void hc_state_add(hc_state *state, hc_field_type type, int count, void *data, const char *name, ...) {
  HC_CHECK(type == HC_TYPE_i64 || type == HC_TYPE_u64 || type == HC_TYPE_f64,
           "an item of the state has numbers of 64 bits, type %d has not", type);
  hc_state_item item = {.type = type, .count = count, .data = data};
  va_list arguments;
  va_start(arguments, name);
  const int length = vsnprintf(item.name, sizeof item.name, name, arguments);
  va_end(arguments);
  HC_CHECK(length < HC_STATE_NAME, "the name of an item must be shorter than %d bytes, got %s", HC_STATE_NAME,
           item.name);
  for (int k = 0; k < state->item_count; k++)
    HC_CHECK(strcmp(state->items[k].name, item.name) != 0, "item %s is registered twice", item.name);
  const size_t old = (size_t)state->item_count;
  hc_reserve((void **)&state->items, &state->item_capacity, old + 1, old, sizeof *state->items);
  state->items[state->item_count++] = item;
}

void hc_state_visit(const hc_state *state, unsigned kinds, const hc_state_visitor *visitor) {
  for (int k = 0; visitor->item && k < state->item_count; k++)
    visitor->item(visitor->context, &state->items[k]);
  hc_particles *const stores[] = {state->fluid, state->boundary};
  for (int store = 0; visitor->field && store < 2; store++) {
    if (!(stores[store]->kind & kinds)) continue;
    for (int field = 0; field < HC_FIELD_COUNT; field++)
      if ((hc_fields[field].flags & stores[store]->kind) && (hc_fields[field].flags & HC_STATE))
        visitor->field(visitor->context, stores[store], (hc_field_id)field);
  }
}

static void digest_item(void *context, const hc_state_item *item) {
  uint64_t *digest = context;
  *digest = XXH3_64bits_withSeed(item->name, strlen(item->name), *digest);
  *digest = XXH3_64bits_withSeed(item->data, 8 * (size_t)item->count, *digest);
}

uint64_t hc_state_digest_items(const hc_state *state) {
  uint64_t digest = 0;
  hc_state_visit(state, 0, &(hc_state_visitor){.context = &digest, .item = digest_item});
  return digest;
}

uint64_t hc_state_digest_particles(const hc_state *state, unsigned kinds) {
  const hc_particles *const stores[] = {state->fluid, state->boundary};
  uint64_t digest = 0;
  for (int store = 0; store < 2; store++) {
    if (!(stores[store]->kind & kinds)) continue;
    const size_t bytes = hc_particles_state_bytes(stores[store]->kind);
    char *block = hc_alloc(bytes, 1);
    for (int32_t k = 0; k < stores[store]->own; k++) {
      hc_particles_pack(stores[store], k, block);
      digest += XXH3_64bits_withSeed(block, bytes, stores[store]->kind);
    }
    hc_free(block);
  }
  return digest;
}
