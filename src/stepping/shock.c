#include "shock.h"

#include <math.h>
#include <stdio.h>

void hc_shock_text(const hc_shock *shock, char text[static HC_SHOCK_TEXT]) {
  switch ((hc_shock_kind)shock->kind) {
  case HC_SHOCK_NONE:
    snprintf(text, HC_SHOCK_TEXT, "none");
    break;
  case HC_SHOCK_RISE:
    snprintf(text, HC_SHOCK_TEXT, "the largest density error rose by %.3g %%, more than %.3g %% (25)",
             100.0 * shock->value, 100.0 * shock->limit);
    break;
  case HC_SHOCK_ERROR:
    snprintf(text, HC_SHOCK_TEXT, "the largest density error was %.3g %%, more than %.3g %% (26)",
             100.0 * shock->value, 100.0 * shock->limit);
    break;
  case HC_SHOCK_VELOCITY:
    snprintf(text, HC_SHOCK_TEXT, "the step, %.4g s, was longer than the largest speed allows, %.4g s (27)",
             shock->value, shock->limit);
    break;
  case HC_SHOCK_CAP:
    snprintf(text, HC_SHOCK_TEXT,
             "the density solve was at its cap with an average error of %.3g %%, more than %.3g %%",
             100.0 * shock->value, 100.0 * shock->limit);
    break;
  case HC_SHOCK_JUMP:
    snprintf(text, HC_SHOCK_TEXT, "the step, %.4g s, was longer than the speed at its end allows, %.4g s",
             shock->value, shock->limit);
    break;
  case HC_SHOCK_FAULT:
    snprintf(text, HC_SHOCK_TEXT, "the step of %.4g s diverged", shock->dt);
    break;
  case HC_SHOCK_FORCED:
    snprintf(text, HC_SHOCK_TEXT, "forced by the test hook faults.shock_at");
    break;
  }
}

void hc_shock_guard_register(hc_shock_guard *guard, hc_state *state) {
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
  hc_state_add(state, HC_TYPE_i64, 1, &guard->forced, "shocks_forced");
}

void hc_shock_guard_hit(hc_shock_guard *guard, const hc_shock *shock, double next, int steps) {
  const bool again = guard->until > 0.0;
  guard->shock = *shock;
  guard->until = again ? fmax(guard->until, shock->time) : shock->time;
  guard->begun = guard->next = next;
  guard->restarts = again ? guard->restarts + 1 : 1;
  guard->rollbacks++;
  guard->steps += steps;
  guard->untold += steps;
  if (shock->kind == HC_SHOCK_FORCED) guard->forced++;
}

int64_t hc_shock_guard_pass(hc_shock_guard *guard, double time) {
  const int64_t told = guard->untold;
  guard->untold = 0;
  guard->next = 0.0;
  if (time >= guard->until) {
    guard->until = guard->begun = 0.0;
    guard->restarts = 0;
  }
  return told;
}
