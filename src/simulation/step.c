#include "step.h"

#include "displace.h"
#include "failure.h"
#include "move_bodies.h"
#include "refill.h"

#include <string.h>

/* There is no step to try: the control's refusal as a fault, of the fastest particle. */
static hc_status refuse(hc_simulation *simulation, double dt, hc_verdict why, hc_error *error) {
  hc_world *world = &simulation->world;
  hc_fault *fault = &simulation->report.fault;
  hc_simulation_fill_derived(simulation);
  hc_fault_note(fault, HC_FAULT_TIME_STEP, -1.0, INT64_MAX); /* also where no particle is left */
  hc_fault_watch_fastest(world, HC_FAULT_TIME_STEP, fault);
  hc_tally tally = {.count = 0};
  hc_fault_agree(world->comm, dt, &tally, fault, error);
  if (why == HC_VERDICT_GAVE_UP)
    hc_error_set(error, HC_FAILED, "a shock came again in each of %d replays",
                 simulation->control.ops->most_restarts(simulation->control.settings));
  return error->status;
}

/* The step itself: the solver's, behind the watch over its length. */
static hc_status advance(hc_simulation *simulation, double dt, hc_error *error) {
  const hc_verdict permitted = hc_control_permit(&simulation->control, simulation->time, dt);
  if (permitted != HC_VERDICT_ACCEPT) return refuse(simulation, dt, permitted, error);
  return simulation->solver->step(&simulation->world, &simulation->bodies, simulation->solver_settings, dt,
                                  simulation->dt, &simulation->report, error);
}

/* Behind the move: adds up over the ranks, in one reduction, what all have to say of the step; it fails if
 * something has left the world. */
static hc_status add_up(hc_simulation *simulation, double dt, hc_error *error) {
  hc_step_report *report = &simulation->report;
  hc_tally tally = {.count = 0};
  hc_move_note(report, &tally);
  hc_population_watch(&simulation->population, &simulation->world, simulation->control.end, &report->fault,
                      &tally);
  hc_yield_note_loads(&simulation->loads, &simulation->world, &simulation->bodies, dt, &tally);
  if (simulation->company.note) simulation->company.note(simulation->company.caller, dt, &tally);
  int64_t outside = hc_domain_watch_partners(&simulation->world.domain);
  hc_tally_max_i64(&tally, &outside, 1);
  hc_fault_agree(simulation->comm, dt, &tally, &report->fault, error);
  hc_domain_agree_partners(&simulation->world.domain, outside != 0);
  hc_move_report(&simulation->world, report);
  if (error->status == HC_OK) hc_simulation_move_bodies(simulation, dt, error);
  return error->status;
}

/* Does the test hook want this step taken back? */
static bool is_forced(const hc_simulation *simulation) {
  const int at = simulation->scene->faults.shock_at;
  return at > 0 && at == simulation->step &&
         simulation->control.guard.forced <= simulation->scene->faults.shock_again;
}

/* Does the step of dt just done count, that perhaps failed with `error`? */
static hc_verdict judge(const hc_simulation *simulation, double dt, const hc_step_report *before,
                        const hc_error *error, hc_shock *shock) {
  const hc_step_report seen = hc_simulation_seen_by_control(simulation);
  const hc_step_tried tried = {.time = simulation->time,
                               .dt = dt,
                               .report = &seen,
                               .error_before = simulation->step > 0 ? before->density_error_max : -1.0,
                               .capped_before =
                                   simulation->step > 0 && simulation->capped_at == simulation->step,
                               .status = error->status,
                               .forced = is_forced(simulation)};
  return hc_control_judge(&simulation->control, &tried, shock);
}

/* Takes the step back, and perhaps the one before it. */
static void go_back(hc_simulation *simulation, const hc_shock *shock) {
  const hc_step_report failed = hc_simulation_seen_by_control(simulation);
  memset(&simulation->report, 0, sizeof simulation->report); /* what of it is state comes back */
  const int back = hc_rollback_return(&simulation->rollback, &simulation->state);
  hc_control_take_back(&simulation->control, shock, &failed, back);
  hc_simulation_disturb(simulation);
  hc_simulation_pose_walls(simulation);
  hc_world_update(&simulation->world);
}

static double next_step(hc_simulation *simulation) {
  const hc_step_report seen = hc_simulation_seen_by_control(simulation);
  return hc_control_next(&simulation->control, simulation->time, simulation->dt, &seen);
}

hc_status hc_simulation_step(hc_simulation *simulation, hc_error *error) {
  hc_world *world = &simulation->world;
  hc_control *control = &simulation->control;
  const hc_step_report before = simulation->report;
  simulation->rollback.back = 0;
  hc_rollback_remember(&simulation->rollback, &simulation->state);
  if (simulation->step > 0) {
    hc_failure_inject(simulation);
    hc_balance_look(&simulation->balance, world, simulation->step);
  }
  hc_balance_start(&simulation->balance, simulation->comm);
  hc_simulation_pose_walls(simulation);
  if (hc_simulation_displace(simulation, error) != HC_OK) return error->status;
  hc_world_place(world);
  hc_stopwatch_enter(&world->watch, HC_STAGE_BIRTHS);
  if (hc_population_change(&simulation->population, world, simulation->time, !simulation->displaced))
    hc_world_place(world);
  if (hc_simulation_refill(simulation, error) != HC_OK) return error->status;
  if (hc_simulation_renew(simulation, error) != HC_OK) return error->status;
  if (simulation->came) hc_world_place(world);
  hc_bodies_touch(&simulation->bodies, world);
  double dt = control->ops->when == HC_CONTROL_FROM_STATE ? next_step(simulation) : 0.0;
  const hc_step_report seen = hc_simulation_seen_by_control(simulation);
  if (simulation->solver->reach)
    hc_world_reach(world, simulation->solver->reach(simulation->solver_settings, &seen, dt));
  hc_world_list(world, NULL);
  if (simulation->solver->evaluate)
    simulation->solver->evaluate(world, simulation->solver_settings, &simulation->report);
  if (control->ops->when == HC_CONTROL_FROM_FORCES) dt = next_step(simulation);
  advance(simulation, dt, error);
  hc_balance_stop(&simulation->balance, simulation->comm);
  if (error->status == HC_OK) add_up(simulation, dt, error);
  hc_shock shock;
  const hc_verdict verdict = judge(simulation, dt, &before, error, &shock);
  if (verdict == HC_VERDICT_TAKE_BACK) {
    *error = (hc_error){.status = HC_OK};
    go_back(simulation, &shock);
    return HC_OK;
  }
  if (verdict != HC_VERDICT_ACCEPT) {
    hc_failure_explain(simulation, dt, &before, error);
    return error->status;
  }
  simulation->dt = dt;
  simulation->step++;
  simulation->time = control->end;
  if (simulation->report.density_capped) simulation->capped_at = simulation->step;
  hc_control_accept(control, dt);
  hc_simulation_pose_walls(simulation);
  return HC_OK;
}
