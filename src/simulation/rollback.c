#include "rollback.h"

#include "base/check.h"

void hc_rollback_register(hc_rollback *rollback, hc_state *state) {
  hc_shock_guard *guard = &rollback->guard;
  hc_state_add(state, HC_TYPE_i64, 1, &guard->shock.kind, "shock.kind");
  hc_state_add(state, HC_TYPE_f64, 1, &guard->shock.time, "shock.time");
  hc_state_add(state, HC_TYPE_f64, 1, &guard->shock.dt, "shock.dt");
  hc_state_add(state, HC_TYPE_f64, 1, &guard->shock.value, "shock.value");
  hc_state_add(state, HC_TYPE_f64, 1, &guard->shock.limit, "shock.limit");
  hc_state_add(state, HC_TYPE_f64, 1, &guard->until, "replay.until");
  hc_state_add(state, HC_TYPE_f64, 1, &guard->begun, "replay.begun");
  hc_state_add(state, HC_TYPE_f64, 1, &guard->next, "replay.next");
  hc_state_add(state, HC_TYPE_i64, 1, &guard->restarts, "replay.restarts");
  hc_state_add(state, HC_TYPE_i64, 1, &guard->rollbacks, "rollbacks");
  hc_state_add(state, HC_TYPE_i64, 1, &guard->steps, "rollback_steps");
  hc_state_add(state, HC_TYPE_i64, 1, &guard->untold, "rollback_steps_untold");
  hc_state_add(state, HC_TYPE_i64, 1, &rollback->forced, "shocks_forced");
}

void hc_rollback_free(hc_rollback *rollback) {
  hc_state_history_free(&rollback->history);
}

void hc_rollback_remember(hc_rollback *rollback, const hc_state *state) {
  hc_state_history_push(&rollback->history, state, HC_FLUID);
}

int hc_rollback_return(hc_rollback *rollback, hc_state *state) {
  const int back = rollback->history.count > 1 ? 1 : 0;
  const bool found = hc_state_history_return(&rollback->history, state, back);
  HC_CHECK(found, "the state %d steps ago must be remembered", back);
  return back + 1;
}

bool hc_rollback_show_resumable(hc_rollback *rollback, hc_state *state, hc_state_copy *now) {
  const hc_state_copy *begin = hc_state_history_get(&rollback->history, 0);
  if (!begin) return false;
  hc_state_remember(now, state, HC_FLUID);
  hc_state_restore(begin, state);
  return true;
}

bool hc_rollback_show_now(hc_state *state, hc_state_copy *now) {
  if (!now->full) return false;
  hc_state_restore(now, state);
  hc_state_copy_free(now);
  return true;
}
