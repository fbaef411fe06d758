#include "rollback.h"

#include "base/check.h"

void hc_rollback_free(hc_rollback *rollback) {
  hc_state_history_free(&rollback->history);
}

void hc_rollback_remember(hc_rollback *rollback, const hc_state *state) {
  if (rollback->most == 0) return;
  if (rollback->most == 1) hc_state_history_forget(&rollback->history);
  hc_state_history_push(&rollback->history, state, HC_FLUID);
}

int hc_rollback_return(hc_rollback *rollback, hc_state *state) {
  const int back = rollback->history.count > 1 ? 1 : 0;
  const bool found = hc_state_history_return(&rollback->history, state, back);
  HC_CHECK(found, "the state %d steps ago must be remembered", back);
  rollback->back = back + 1;
  return rollback->back;
}

bool hc_rollback_show_resumable(hc_rollback *rollback, hc_state *state, hc_state_copy *now) {
  const hc_state_copy *begin = hc_state_history_get(&rollback->history, 0);
  if (!begin || rollback->most < 2) return false;
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
