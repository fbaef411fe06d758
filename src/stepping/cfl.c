#include "cfl.h"

#include <math.h>

static const double FIRST_STEP = 0.25;

static double next(const hc_control *control, double time, double dt_before, const hc_step_report *report,
                   hc_step_bound *bound) {
  const hc_cfl_settings *settings = (const hc_cfl_settings *)control->settings;
  const hc_step_settings *common = &settings->common;
  *bound = HC_BOUND_SIZE;
  double dt = common->longest;
  if (report->v_max > 0.0)
    hc_time_step_shorten(&dt, settings->factor * common->spacing / report->v_max, HC_BOUND_VELOCITY, bound);
  if (report->force_max > 0.0)
    hc_time_step_shorten(&dt, 0.25 * sqrt(common->support_radius / report->force_max), HC_BOUND_FORCE, bound);
  hc_time_step_shorten(&dt, hc_time_step_viscous_bound(common), HC_BOUND_VISCOUS, bound);
  /* A run starts without pressure, which takes iterations to build up: fewest from a short first step on. */
  hc_time_step_shorten(&dt, dt_before > 0.0 ? 1.1 * dt_before : FIRST_STEP * common->longest, HC_BOUND_GROWTH,
                       bound);
  return hc_time_step_to_end(common, time, dt, HC_TIME_STEP_SLIVER, true, bound);
}

const hc_control_ops hc_control_cfl = {
    .name = "cfl", .when = HC_CONTROL_FROM_STATE, .speed_key = "factor", .longest_key = "max", .next = next};
