#include "adaptive.h"

#include <math.h>

static const hc_adaptive_settings *settings_of(const hc_control *control) {
  return (const hc_adaptive_settings *)control->settings;
}

static double by_force(const hc_adaptive_settings *adaptive, double factor, const hc_step_report *report) {
  return report->force_max > 0.0 ? factor * sqrt(adaptive->common.support_radius / report->force_max)
                                 : INFINITY;
}

static double by_velocity(const hc_adaptive_settings *adaptive, double factor, const hc_step_report *report) {
  return report->v_max > 0.0 ? factor * adaptive->common.support_radius / report->v_max : INFINITY;
}

static double first_step(const hc_adaptive_settings *adaptive, const hc_step_report *report,
                         hc_step_bound *bound) {
  double first = by_velocity(adaptive, adaptive->first_velocity, report);
  *bound = HC_BOUND_VELOCITY;
  hc_time_step_shorten(&first, adaptive->common.first, HC_BOUND_DEPTH, bound);
  return first;
}

/* The step after one of dt_before. */
static double next_step(const hc_adaptive_settings *adaptive, double dt_before, const hc_step_report *report,
                        hc_step_bound *bound) {
  const hc_adaptive_bounds *grow = &adaptive->grow, *shrink = &adaptive->shrink;
  const double max = report->density_error_max, avg = report->density_error_avg, eta = adaptive->error_avg;
  const struct {
    hc_step_bound bound;
    bool may_grow, must_shrink;
  } rules[] = {
      /* (16) and (20); (17) and (21); (18) and (22); (19) and (23) */
      {HC_BOUND_FORCE, by_force(adaptive, grow->force, report) > dt_before,
       by_force(adaptive, shrink->force, report) < dt_before},
      {HC_BOUND_ERROR_MAX, max<grow->error_max * eta, max> shrink->error_max * eta},
      {HC_BOUND_ERROR_AVG, avg < grow->error_avg * eta, avg >= shrink->error_avg * eta},
      {HC_BOUND_VELOCITY, by_velocity(adaptive, grow->velocity, report) > dt_before,
       by_velocity(adaptive, shrink->velocity, report) <= dt_before},
  };
  const int count = sizeof rules / sizeof *rules;
  for (int k = 0; k < count; k++) {
    if (!rules[k].must_shrink) continue;
    *bound = rules[k].bound;
    return dt_before * (1.0 - adaptive->change);
  }
  for (int k = 0; k < count; k++) {
    if (rules[k].may_grow) continue;
    *bound = rules[k].bound;
    return dt_before;
  }
  *bound = HC_BOUND_GROWTH;
  return dt_before * (1.0 + adaptive->change);
}

static double next(const hc_control *control, double dt_before, const hc_step_report *report,
                   hc_step_bound *bound) {
  const hc_adaptive_settings *adaptive = settings_of(control);
  if (control->guard.next != 0.0) {
    *bound = HC_BOUND_SHOCK;
    return control->guard.next;
  }
  double dt =
      dt_before > 0.0 ? next_step(adaptive, dt_before, report, bound) : first_step(adaptive, report, bound);
  hc_time_step_shorten(&dt, hc_time_step_viscous_bound(&adaptive->common), HC_BOUND_VISCOUS, bound);
  hc_time_step_shorten(&dt, adaptive->common.longest, HC_BOUND_SIZE, bound);
  return dt;
}

static double usual(const hc_step_settings *settings, double speed) {
  const hc_adaptive_settings *adaptive = (const hc_adaptive_settings *)settings;
  return adaptive->shrink.velocity * settings->support_radius / speed;
}

static double still(const hc_control *control) {
  const hc_step_report rest = {.v_max = 0.0};
  hc_step_bound unused;
  return next(control, 0.0, &rest, &unused);
}

/* The first of (25), (26), (27) that holds. */
static hc_shock judge(const hc_control *control, const hc_step_tried *tried) {
  const hc_adaptive_settings *adaptive = settings_of(control);
  const double time = tried->time + tried->dt, dt = tried->dt, error = tried->report->density_error_max,
               rise = tried->error_before < 0.0 ? 0.0 : error - tried->error_before,
               longest = by_velocity(adaptive, adaptive->shock_velocity, tried->report);
  if (rise > adaptive->shock_rise) return (hc_shock){HC_SHOCK_RISE, time, dt, rise, adaptive->shock_rise};
  if (error > adaptive->error_max) return (hc_shock){HC_SHOCK_ERROR, time, dt, error, adaptive->error_max};
  if (longest < dt) return (hc_shock){HC_SHOCK_VELOCITY, time, dt, dt, longest};
  return (hc_shock){.kind = HC_SHOCK_NONE};
}

static double restart(const hc_control *control, const hc_shock *shock, const hc_step_report *report) {
  const hc_adaptive_settings *adaptive = settings_of(control);
  const hc_shock_guard *guard = &control->guard;
  const double failed = guard->until > 0.0 ? fmin(shock->dt, guard->begun) : shock->dt;
  const double share = adaptive->restart_share * failed;
  if (shock->kind == HC_SHOCK_FAULT) return share; /* which leaves no speeds and forces to go by */
  return fmin(share, fmin(by_force(adaptive, adaptive->restart_force, report), /* (24) */
                          by_velocity(adaptive, adaptive->restart_velocity, report)));
}

static int most_restarts(const hc_step_settings *settings) {
  return ((const hc_adaptive_settings *)settings)->most_restarts;
}

const hc_control_ops hc_control_adaptive = {.name = "adaptive",
                                            .when = HC_CONTROL_FROM_STATE,
                                            .speed_key = "max",
                                            .longest_key = "max",
                                            .by_errors = true,
                                            .goes_back = 2,
                                            .next = next,
                                            .usual = usual,
                                            .still = still,
                                            .judge = judge,
                                            .restart = restart,
                                            .most_restarts = most_restarts};
