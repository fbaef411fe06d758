#include "copy.h"

#include "base/check.h"
#include "base/memory.h"

#include <string.h>

void hc_state_copy_free(hc_state_copy *copy) {
  hc_free(copy->bytes);
  memset(copy, 0, sizeof *copy);
}

static void count_item(void *bytes, const hc_state_item *item) {
  *(size_t *)bytes += 8 * (size_t)item->count;
}

static void count_field(void *bytes, hc_particles *particles, hc_field_id field) {
  *(size_t *)bytes += (size_t)particles->own * hc_fields[field].bytes;
}

static void remember(hc_state_copy *copy, const void *data, size_t bytes) {
  memcpy(copy->bytes + copy->used, data, bytes);
  copy->used += bytes;
}

static void remember_item(void *context, const hc_state_item *item) {
  remember(context, item->data, 8 * (size_t)item->count);
}

static void remember_field(void *context, hc_particles *particles, hc_field_id field) {
  remember(context, particles->data[field], (size_t)particles->own * hc_fields[field].bytes);
}

void hc_state_remember(hc_state_copy *copy, const hc_state *state, unsigned kinds) {
  copy->full = true;
  copy->kinds = kinds;
  for (int k = 0; k < state->store_count; k++) copy->own[k] = state->stores[k]->own;
  copy->used = 0;
  size_t bytes = 0; /* room at once: a buffer that grows is there twice for a while */
  hc_state_visit(state, kinds, &(hc_state_visitor){&bytes, count_item, count_field});
  hc_reserve((void **)&copy->bytes, &copy->capacity, bytes, 0, 1);
  hc_state_visit(state, kinds, &(hc_state_visitor){copy, remember_item, remember_field});
}

/* A copy being read. */
typedef struct reading {
  const hc_state_copy *copy;
  size_t used;
} reading;

static void read_back(reading *reading, void *data, size_t bytes) {
  HC_CHECK(reading->used + bytes <= reading->copy->used, "the copy has %zu bytes, %zu are asked for",
           reading->copy->used, reading->used + bytes);
  memcpy(data, reading->copy->bytes + reading->used, bytes);
  reading->used += bytes;
}

static void restore_item(void *context, const hc_state_item *item) {
  read_back(context, item->data, 8 * (size_t)item->count);
}

static void restore_field(void *context, hc_particles *particles, hc_field_id field) {
  read_back(context, particles->data[field], (size_t)particles->own * hc_fields[field].bytes);
}

void hc_state_restore(const hc_state_copy *copy, hc_state *state) {
  HC_CHECK(copy->full, "only a state that was remembered can be restored");
  for (int k = 0; k < state->store_count; k++)
    if (hc_state_names(copy->kinds, state->stores[k])) hc_particles_resize(state->stores[k], copy->own[k]);
  reading reading = {copy, 0};
  hc_state_visit(state, copy->kinds, &(hc_state_visitor){&reading, restore_item, restore_field});
  HC_CHECK(reading.used == copy->used, "of a copy of %zu bytes %zu were used: other items are registered",
           copy->used, reading.used);
}

void hc_state_history_free(hc_state_history *history) {
  for (int k = 0; k < HC_STATE_HISTORY; k++) hc_state_copy_free(&history->copies[k]);
  memset(history, 0, sizeof *history);
}

void hc_state_history_push(hc_state_history *history, const hc_state *state, unsigned kinds) {
  history->newest = (history->newest + 1) % HC_STATE_HISTORY;
  if (history->count < HC_STATE_HISTORY) history->count++;
  hc_state_remember(&history->copies[history->newest], state, kinds);
}

void hc_state_history_forget(hc_state_history *history) {
  history->count = 0;
  history->newest = HC_STATE_HISTORY - 1; /* of which the first comes next */
}

const hc_state_copy *hc_state_history_get(const hc_state_history *history, int back) {
  if (back < 0 || back >= history->count) return NULL;
  return &history->copies[(history->newest - back + HC_STATE_HISTORY) % HC_STATE_HISTORY];
}

bool hc_state_history_return(hc_state_history *history, hc_state *state, int back) {
  const hc_state_copy *copy = hc_state_history_get(history, back);
  if (!copy) return false;
  hc_state_restore(copy, state);
  history->newest = (history->newest - back - 1 + 2 * HC_STATE_HISTORY) % HC_STATE_HISTORY;
  history->count -= back + 1;
  return true;
}
