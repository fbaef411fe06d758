#include "control.h"

#include "base/check.h"
#include "base/memory.h"

#include <string.h>

static const double USUAL_SPACINGS = 0.4; /* a step */

void hc_control_init(hc_control *control, const hc_control_ops *ops, hc_step_settings *settings) {
  HC_CHECK(!ops->judge == !ops->restart && !ops->judge == !ops->most_restarts &&
               !ops->judge == !ops->goes_back,
           "%s must judge, go back, restart and give up, or do nothing of it", ops->name);
  memset(control, 0, sizeof *control);
  control->ops = ops;
  control->goes_back = ops->goes_back;
  control->settings = settings;
}

void hc_control_free(hc_control *control) {
  hc_free(control->settings);
  control->settings = NULL;
}

void hc_control_register(hc_control *control, hc_state *state) {
  hc_shock_guard_register(&control->guard, state);
  hc_state_add(state, HC_TYPE_f64, 3, &control->count.origin, "step_count");
}

bool hc_control_may_go_back(const hc_control *control) {
  return control->ops->judge != NULL;
}

/* Of the steps before, those that were as long as this one. */
static hc_step_count count_of(const hc_control *control, double time, double size) {
  return control->count.size == size ? control->count : (hc_step_count){time, size, 0.0};
}

double hc_control_next(hc_control *control, double time, double dt_before, const hc_step_report *report) {
  double dt = control->ops->next(control, dt_before, report, &control->bound);
  if (control->ops->foreseen) {
    const hc_step_count count = count_of(control, time, dt);
    control->end = hc_time_step_count(control->settings, count.origin, count.steps, &dt, &control->bound);
  } else {
    control->end = hc_time_step_land(control->settings, time, &dt, &control->bound);
  }
  return dt;
}

double hc_control_usual(const hc_control *control, double speed) {
  return control->ops->usual ? control->ops->usual(control->settings, speed)
                             : USUAL_SPACINGS * control->settings->spacing / speed;
}

double hc_control_still(const hc_control *control) {
  return control->ops->still ? control->ops->still(control) : control->settings->longest;
}

hc_verdict hc_control_permit(const hc_control *control, double time, double dt) {
  if (hc_control_may_go_back(control) && !control->ops->goes_on &&
      control->guard.restarts > control->ops->most_restarts(control->settings))
    return HC_VERDICT_GAVE_UP;
  return hc_time_step_too_small(control->settings, time, dt) ? HC_VERDICT_UNDER_FLOOR : HC_VERDICT_ACCEPT;
}

/* May a shorter step do better? Where the step begins with such a speed, only one before it. */
static bool may_be_shock(const hc_control *control, hc_fault_kind kind) {
  return kind == HC_FAULT_VALUE || kind == HC_FAULT_SPEED || kind == HC_FAULT_ERROR ||
         (kind == HC_FAULT_START_SPEED && control->goes_back > 1);
}

static bool may_take_back(const hc_control *control) {
  return hc_control_may_go_back(control) &&
         (!control->ops->goes_on || control->guard.restarts < control->ops->most_restarts(control->settings));
}

hc_verdict hc_control_judge(const hc_control *control, const hc_step_tried *tried, hc_shock *shock) {
  const bool failed = tried->status != HC_OK;
  const hc_fault_kind fault = tried->report->fault.kind;
  const bool whole = !failed || fault == HC_FAULT_LEFT; /* which is found behind the step */
  *shock = (hc_shock){.kind = HC_SHOCK_NONE};
  if (may_take_back(control)) {
    const double end = tried->time + tried->dt;
    if (!whole && may_be_shock(control, fault))
      *shock = (hc_shock){.kind = HC_SHOCK_FAULT, .time = end, .dt = tried->dt};
    else if (whole && tried->forced)
      *shock = (hc_shock){.kind = HC_SHOCK_FORCED, .time = end, .dt = tried->dt};
    else if (whole)
      *shock = control->ops->judge(control, tried);
  }
  if (shock->kind != HC_SHOCK_NONE) return HC_VERDICT_TAKE_BACK;
  return failed ? HC_VERDICT_FAILED : HC_VERDICT_ACCEPT;
}

void hc_control_take_back(hc_control *control, const hc_shock *shock, const hc_step_report *report,
                          int steps) {
  const bool measured = shock->kind != HC_SHOCK_FAULT;
  hc_shock_guard_hit(&control->guard, shock, control->ops->restart(control, shock, report), steps);
  control->v_max = measured ? report->v_max : 0.0;
  control->force_max = measured ? report->force_max : 0.0;
}

void hc_control_accept(hc_control *control, double dt) {
  control->count = count_of(control, control->end - dt, dt);
  control->count.steps++;
  control->before = hc_shock_guard_pass(&control->guard, control->end);
}
