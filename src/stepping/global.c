#include "global.h"

#include <math.h>

static const hc_global_settings *settings_of(const hc_step_settings *settings) {
  return (const hc_global_settings *)settings;
}

static double usual(const hc_step_settings *settings, double speed) {
  return fmin(settings->longest, settings_of(settings)->velocity * settings->support_radius / speed);
}

static double next(const hc_control *control, double dt_before, const hc_step_report *report,
                   hc_step_bound *bound) {
  (void)dt_before;
  const hc_step_settings *common = control->settings;
  *bound = HC_BOUND_SIZE;
  double dt = common->longest;
  if (report->v_max > 0.0)
    hc_time_step_shorten(&dt, settings_of(common)->velocity * common->support_radius / report->v_max,
                         HC_BOUND_VELOCITY, bound);
  if (report->force_max > 0.0)
    hc_time_step_shorten(&dt, settings_of(common)->force * sqrt(common->support_radius / report->force_max),
                         HC_BOUND_FORCE, bound);
  hc_time_step_shorten(&dt, hc_time_step_viscous_bound(common), HC_BOUND_VISCOUS, bound);
  return dt;
}

const hc_control_ops hc_control_global = {.name = "global",
                                          .when = HC_CONTROL_FROM_FORCES,
                                          .speed_key = "velocity",
                                          .longest_key = "max",
                                          .usual = usual,
                                          .next = next};
