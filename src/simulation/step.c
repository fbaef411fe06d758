#include "step.h"

#include "failure.h"

#include <string.h>

static double choose_step(hc_simulation *simulation) {
  const hc_step_settings *settings = &simulation->step_settings;
  const double replay = hc_simulation_may_go_back(simulation) ? simulation->rollback.guard.next : 0.0;
  const hc_step_report seen = hc_simulation_seen_by_control(simulation);
  if (replay == 0.0)
    return hc_time_step_next(settings, simulation->time, simulation->dt, &seen, &simulation->bound);
  simulation->bound = HC_BOUND_SHOCK;
  return hc_time_step_to_end(settings, simulation->time, replay, &simulation->bound);
}

/* The step itself: the solver's, behind the watch over its length. */
static hc_status advance(hc_simulation *simulation, double dt, hc_error *error) {
  hc_world *world = &simulation->world;
  hc_fault *fault = &simulation->report.fault;
  const bool gave_up = hc_simulation_may_go_back(simulation) &&
                       simulation->rollback.guard.restarts > simulation->step_settings.adaptive.most_restarts;
  if (gave_up || hc_time_step_too_small(&simulation->step_settings, simulation->time, dt)) {
    hc_simulation_fill_derived(simulation);
    hc_fault_note(fault, HC_FAULT_TIME_STEP, -1.0, INT64_MAX); /* also where no particle is left */
    hc_fault_watch_fastest(world, HC_FAULT_TIME_STEP, fault);
    hc_tally tally = {.count = 0};
    hc_fault_agree(world->comm, dt, &tally, fault, error);
    if (gave_up)
      hc_error_set(error, HC_FAILED, "a shock came again in each of %d replays",
                   simulation->step_settings.adaptive.most_restarts);
    return error->status;
  }
  return simulation->solver->step(world, &simulation->solver_settings, dt, simulation->dt,
                                  &simulation->report, error);
}

/* The time at the end of a step of dt. */
static double time_behind(const hc_simulation *simulation, double dt) {
  return simulation->bound == HC_BOUND_END ? simulation->scene->end_time : simulation->time + dt;
}

/* Behind the move: adds up over the ranks, in one reduction, what all have to say of the step; it fails if
 * something has left the world. */
static hc_status add_up(hc_simulation *simulation, double dt, hc_error *error) {
  hc_step_report *report = &simulation->report;
  hc_tally tally = {.count = 0};
  hc_move_note(report, &tally);
  hc_population_watch(&simulation->population, &simulation->world, time_behind(simulation, dt),
                      &report->fault, &tally);
  if (simulation->company.note) simulation->company.note(simulation->company.caller, dt, &tally);
  hc_fault_agree(simulation->comm, dt, &tally, &report->fault, error);
  hc_move_report(&simulation->world, report);
  return error->status;
}

/* May a shorter step do better? */
static bool may_be_shock(hc_fault_kind kind) {
  return kind == HC_FAULT_START_SPEED || kind == HC_FAULT_VALUE || kind == HC_FAULT_SPEED ||
         kind == HC_FAULT_ERROR;
}

/* What the step of dt just done was, that perhaps failed with `error`. */
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

/* Takes the step back, and the one before it. */
static void go_back(hc_simulation *simulation, const hc_shock *shock) {
  hc_rollback *rollback = &simulation->rollback;
  const hc_step_report failed = hc_simulation_seen_by_control(simulation);
  const bool measured = shock->kind != HC_SHOCK_FAULT;
  memset(&simulation->report, 0, sizeof simulation->report); /* what of it is state comes back */
  const int back = hc_rollback_return(rollback, &simulation->state);
  hc_shock_guard_hit(&rollback->guard, &simulation->step_settings, shock, &failed, back);
  if (shock->kind == HC_SHOCK_FORCED) rollback->forced++;
  rollback->back = back;
  rollback->v_max = measured ? failed.v_max : 0.0;
  rollback->force_max = measured ? failed.force_max : 0.0;
  hc_simulation_pose_walls(simulation);
  hc_world_update(&simulation->world);
}

hc_status hc_simulation_step(hc_simulation *simulation, hc_error *error) {
  hc_world *world = &simulation->world;
  const hc_step_report before = simulation->report;
  simulation->rollback.back = 0;
  if (hc_simulation_may_go_back(simulation)) hc_rollback_remember(&simulation->rollback, &simulation->state);
  if (simulation->step > 0) {
    hc_failure_inject(simulation);
    hc_balance_look(&simulation->balance, world, simulation->step);
  }
  hc_balance_start(&simulation->balance, simulation->comm);
  hc_simulation_pose_walls(simulation);
  hc_world_place(world);
  if (hc_population_change(&simulation->population, world, simulation->time)) hc_world_place(world);
  const double dt = choose_step(simulation);
  hc_world_list(world, NULL);
  advance(simulation, dt, error);
  hc_balance_stop(&simulation->balance, simulation->comm);
  if (error->status == HC_OK) add_up(simulation, dt, error);
  if (hc_simulation_may_go_back(simulation)) {
    const hc_shock shock = find_shock(simulation, dt, &before, error);
    if (shock.kind != HC_SHOCK_NONE) {
      *error = (hc_error){.status = HC_OK};
      go_back(simulation, &shock);
      return HC_OK;
    }
  }
  if (error->status != HC_OK) {
    hc_failure_explain(simulation, dt, &before, error);
    return error->status;
  }
  simulation->dt = dt;
  simulation->step++;
  simulation->time = time_behind(simulation, dt);
  if (simulation->report.density_capped) simulation->capped_at = simulation->step;
  simulation->rollback.before = hc_shock_guard_pass(&simulation->rollback.guard, simulation->time);
  hc_simulation_pose_walls(simulation);
  return HC_OK;
}
