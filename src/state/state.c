#include "state.h"

#include "base/check.h"
#include "base/memory.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

void hc_state_init(hc_state *state) {
  memset(state, 0, sizeof *state);
}

void hc_state_add_store(hc_state *state, hc_particles *store) {
  HC_CHECK(state->store_count < HC_STATE_MOST_STORES, "a state has at most %d stores", HC_STATE_MOST_STORES);
  state->stores[state->store_count++] = store;
}

bool hc_state_names(unsigned kinds, const hc_particles *store) {
  return kinds & (store->kind & HC_MOVED ? HC_MOVED : store->kind);
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
  for (int k = 0; visitor->field && k < state->store_count; k++) {
    hc_particles *store = state->stores[k];
    if (!hc_state_names(kinds, store)) continue;
    for (int field = 0; field < HC_FIELD_COUNT; field++)
      if (store->data[field] && hc_field_is_state(&hc_fields[field]))
        visitor->field(visitor->context, store, (hc_field_id)field);
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
  uint64_t digest = 0;
  for (int s = 0; s < state->store_count; s++) {
    const hc_particles *store = state->stores[s];
    if (!hc_state_names(kinds, store)) continue;
    char *block = hc_alloc(1, hc_particles_state_bytes(store->kind, store->features));
    for (int32_t k = 0; k < store->own; k++) {
      char *to = block;
      for (int field = 0; field < HC_FIELD_COUNT; field++) {
        if (!store->data[field] || !hc_field_is_state(&hc_fields[field])) continue;
        const size_t bytes = hc_fields[field].bytes;
        memcpy(to, (const char *)store->data[field] + (size_t)k * bytes, bytes);
        to += bytes;
      }
      digest += XXH3_64bits_withSeed(block, (size_t)(to - block), store->kind);
    }
    hc_free(block);
  }
  return digest;
}
