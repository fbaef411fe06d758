#include "adaptive.h"

#include <math.h>
#include <stdio.h>

static double by_force(const hc_step_settings *settings, double factor, const hc_step_report *report) {
  return report->force_max > 0.0 ? factor * sqrt(settings->support_radius / report->force_max) : INFINITY;
}

static double by_velocity(const hc_step_settings *settings, double factor, const hc_step_report *report) {
  return report->v_max > 0.0 ? factor * settings->support_radius / report->v_max : INFINITY;
}

double hc_adaptive_first(const hc_step_settings *settings, double v_max, hc_step_bound *bound) {
  const hc_adaptive_settings *adaptive = &settings->adaptive;
  const hc_step_report start = {.v_max = v_max};
  const double velocity = by_velocity(settings, adaptive->first_velocity, &start);
  const double fall = sqrt(adaptive->gravity * adaptive->depth);
  const double depth = fall > 0.0 ? adaptive->first_depth * settings->spacing / fall : INFINITY;
  *bound = velocity < depth ? HC_BOUND_VELOCITY : HC_BOUND_DEPTH;
  return fmin(velocity, depth);
}

double hc_adaptive_next(const hc_step_settings *settings, double dt_before, const hc_step_report *report,
                        hc_step_bound *bound) {
  const hc_adaptive_settings *adaptive = &settings->adaptive;
  const hc_adaptive_bounds *grow = &adaptive->grow, *shrink = &adaptive->shrink;
  const double max = report->density_error_max, avg = report->density_error_avg, eta = adaptive->error_avg;
  const struct {
    hc_step_bound bound;
    bool may_grow, must_shrink;
  } rules[] = {
      /* (16) and (20); (17) and (21); (18) and (22); (19) and (23) */
      {HC_BOUND_FORCE, by_force(settings, grow->force, report) > dt_before,
       by_force(settings, shrink->force, report) < dt_before},
      {HC_BOUND_ERROR_MAX, max<grow->error_max * eta, max> shrink->error_max * eta},
      {HC_BOUND_ERROR_AVG, avg < grow->error_avg * eta, avg >= shrink->error_avg * eta},
      {HC_BOUND_VELOCITY, by_velocity(settings, grow->velocity, report) > dt_before,
       by_velocity(settings, shrink->velocity, report) <= dt_before},
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

hc_shock hc_shock_find(const hc_step_settings *settings, double time, double dt, double error_before,
                       const hc_step_report *report) {
  const hc_adaptive_settings *adaptive = &settings->adaptive;
  const double error = report->density_error_max, rise = error_before < 0.0 ? 0.0 : error - error_before,
               longest = by_velocity(settings, adaptive->shock_velocity, report);
  if (rise > adaptive->shock_rise) return (hc_shock){HC_SHOCK_RISE, time, dt, rise, adaptive->shock_rise};
  if (error > adaptive->error_max) return (hc_shock){HC_SHOCK_ERROR, time, dt, error, adaptive->error_max};
  if (longest < dt) return (hc_shock){HC_SHOCK_VELOCITY, time, dt, dt, longest};
  return (hc_shock){.kind = HC_SHOCK_NONE};
}

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
  case HC_SHOCK_FAULT:
    snprintf(text, HC_SHOCK_TEXT, "the step of %.4g s diverged", shock->dt);
    break;
  case HC_SHOCK_FORCED:
    snprintf(text, HC_SHOCK_TEXT, "forced by the test hook faults.shock_at");
    break;
  }
}

void hc_shock_guard_hit(hc_shock_guard *guard, const hc_step_settings *settings, const hc_shock *shock,
                        const hc_step_report *report, int steps) {
  const hc_adaptive_settings *adaptive = &settings->adaptive;
  const bool again = guard->until > 0.0;
  double next = adaptive->restart_share * (again ? fmin(shock->dt, guard->begun) : shock->dt);
  if (shock->kind != HC_SHOCK_FAULT) /* which leaves no speeds and forces to go by */
    next = fmin(next, fmin(by_force(settings, adaptive->restart_force, report), /* (24) */
                           by_velocity(settings, adaptive->restart_velocity, report)));
  guard->shock = *shock;
  guard->until = again ? fmax(guard->until, shock->time) : shock->time;
  guard->begun = guard->next = next;
  guard->restarts = again ? guard->restarts + 1 : 1;
  guard->rollbacks++;
  guard->steps += steps;
  guard->untold += steps;
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
