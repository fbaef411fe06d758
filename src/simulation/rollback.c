#include "rollback.h"

#include "base/check.h"

void hc_rollback_free(hc_rollback *rollback) {
  hc_state_history_free(&rollback->history);
}

/* What steps change of walls, whatever rank holds them: it goes along with the particles. */
static void walls_remember(const hc_state *state) {
  for (int k = 0; k < state->store_count; k++) {
    const hc_particles *const walls = state->stores[k];
    if (!walls->late_before) continue;
    for (int32_t b = 0; b < walls->own; b++) {
      float *const before = &walls->late_before[2 * (size_t)b];
      before[1] = before[0];
      before[0] = walls->late_compression[b];
    }
  }
}

/* Exchanges the present for what was remembered `back` times before the last. */
static void walls_swap(const hc_state *state, int back) {
  for (int k = 0; k < state->store_count; k++) {
    const hc_particles *const walls = state->stores[k];
    if (!walls->late_before) continue;
    for (int32_t b = 0; b < walls->own; b++) {
      float *const before = &walls->late_before[2 * (size_t)b + (size_t)back],
                   now = walls->late_compression[b];
      walls->late_compression[b] = *before;
      *before = now;
    }
  }
}

void hc_rollback_remember(hc_rollback *rollback, const hc_state *state) {
  if (rollback->most == 0) return;
  if (rollback->most == 1) hc_state_history_forget(&rollback->history);
  hc_state_history_push(&rollback->history, state, HC_FLUID | HC_INFLOW);
  walls_remember(state);
}

int hc_rollback_return(hc_rollback *rollback, hc_state *state) {
  const int back = rollback->history.count > 1 ? 1 : 0;
  const bool found = hc_state_history_return(&rollback->history, state, back);
  HC_CHECK(found, "the state %d steps ago must be remembered", back);
  walls_swap(state, back);
  rollback->back = back + 1;
  return rollback->back;
}

bool hc_rollback_show_resumable(hc_rollback *rollback, hc_state *state, hc_state_copy *now) {
  const hc_state_copy *begin = hc_state_history_get(&rollback->history, 0);
  if (!begin || rollback->most < 2) return false;
  hc_state_remember(now, state, HC_FLUID | HC_INFLOW);
  hc_state_restore(begin, state);
  walls_swap(state, 0);
  return true;
}

bool hc_rollback_show_now(hc_state *state, hc_state_copy *now) {
  if (!now->full) return false;
  hc_state_restore(now, state);
  walls_swap(state, 0);
  hc_state_copy_free(now);
  return true;
}
