#include "rollback.h"

#include "base/check.h"
#include "simulation.h"

#include <string.h>

bool hc_rollback_is_on(const hc_simulation *simulation) {
  return simulation->step_settings.control == HC_STEP_ADAPTIVE;
}

void hc_rollback_register(hc_simulation *simulation) {
  hc_state *state = &simulation->state;
  hc_shock_guard *guard = &simulation->rollback.guard;
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.density_error_avg, "density_error_avg");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.density_error_max, "density_error_max");
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
  hc_state_add(state, HC_TYPE_i64, 1, &simulation->rollback.forced, "shocks_forced");
}

void hc_rollback_remember(hc_simulation *simulation) {
  simulation->rollback.back = 0;
  if (hc_rollback_is_on(simulation))
    hc_state_history_push(&simulation->rollback.history, &simulation->state, HC_FLUID);
}

double hc_rollback_next(const hc_simulation *simulation) {
  return hc_rollback_is_on(simulation) ? simulation->rollback.guard.next : 0.0;
}

bool hc_rollback_gave_up(const hc_simulation *simulation) {
  return hc_rollback_is_on(simulation) &&
         simulation->rollback.guard.restarts > simulation->step_settings.adaptive.most_restarts;
}

/* May a shorter step do better? */
static bool may_be_shock(hc_fault_kind kind) {
  return kind == HC_FAULT_START_SPEED || kind == HC_FAULT_VALUE || kind == HC_FAULT_SPEED ||
         kind == HC_FAULT_ERROR;
}

static hc_shock find_shock(hc_simulation *simulation, double dt, const hc_step_report *before,
                           const hc_error *error) {
  const double time = simulation->time + dt;
  const bool left = simulation->report.fault.kind == HC_FAULT_LEFT; /* behind the step, which is whole */
  if (error->status != HC_OK && !left)
    return (hc_shock){.kind = may_be_shock(simulation->report.fault.kind) ? HC_SHOCK_FAULT : HC_SHOCK_NONE,
                      .time = time,
                      .dt = dt};
  const int at = simulation->scene->faults.shock_at;
  if (at > 0 && at == simulation->step &&
      simulation->rollback.forced <= simulation->scene->faults.shock_again)
    return (hc_shock){.kind = HC_SHOCK_FORCED, .time = time, .dt = dt};
  const hc_step_report seen = hc_simulation_seen_by_control(simulation);
  return hc_shock_find(&simulation->step_settings, time, dt,
                       simulation->step > 0 ? before->density_error_max : -1.0, &seen);
}

/* All state goes back, what is known of shocks too; nothing of that is lost, because the states that are
 * remembered are all younger than the last rollback. */
static void go_back(hc_simulation *simulation, const hc_shock *shock) {
  hc_rollback *rollback = &simulation->rollback;
  const hc_step_report failed = hc_simulation_seen_by_control(simulation);
  const bool measured = shock->kind != HC_SHOCK_FAULT;
  const int back = rollback->history.count > 1 ? 1 : 0;
  memset(&simulation->report, 0, sizeof simulation->report); /* what of it is state comes back */
  const bool found = hc_state_history_return(&rollback->history, &simulation->state, back);
  HC_CHECK(found, "the state %d steps ago must be remembered", back);
  hc_shock_guard_hit(&rollback->guard, &simulation->step_settings, shock, &failed, back + 1);
  if (shock->kind == HC_SHOCK_FORCED) rollback->forced++;
  rollback->back = back + 1;
  rollback->v_max = measured ? failed.v_max : 0.0;
  rollback->force_max = measured ? failed.force_max : 0.0;
}

bool hc_rollback_if_shock(hc_simulation *simulation, double dt, const hc_step_report *before,
                          hc_error *error) {
  if (!hc_rollback_is_on(simulation)) return false;
  const hc_shock shock = find_shock(simulation, dt, before, error);
  if (shock.kind == HC_SHOCK_NONE) return false;
  *error = (hc_error){.status = HC_OK};
  go_back(simulation, &shock);
  hc_simulation_pose_walls(simulation);
  hc_world_update(&simulation->world);
  return true;
}

void hc_rollback_pass(hc_simulation *simulation) {
  simulation->rollback.before = hc_shock_guard_pass(&simulation->rollback.guard, simulation->time);
}

void hc_rollback_show_resumable(hc_simulation *simulation, hc_state_copy *now) {
  const hc_state_copy *begin = hc_state_history_get(&simulation->rollback.history, 0);
  if (!begin) return;
  hc_state_remember(now, &simulation->state, HC_FLUID);
  hc_state_restore(begin, &simulation->state);
  hc_simulation_pose_walls(simulation);
}

void hc_rollback_show_now(hc_simulation *simulation, hc_state_copy *now) {
  if (!now->full) return;
  hc_state_restore(now, &simulation->state);
  hc_state_copy_free(now);
  hc_simulation_pose_walls(simulation);
  hc_world_update(&simulation->world);
}
