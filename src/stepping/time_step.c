#include "time_step.h"

#include "adaptive.h"

#include <math.h>

static const double FIRST_STEP = 0.25;
static const double FLOOR_SHARE = 1e-5;

static void shrink(double *dt, double limit, hc_step_bound reason, hc_step_bound *bound) {
  if (limit < *dt) {
    *dt = limit;
    *bound = reason;
  }
}

double hc_time_step_viscous_bound(const hc_step_settings *settings) {
  const double smoothing_length = 0.5 * settings->support_radius;
  if (!(settings->viscosity > 0.0)) return INFINITY;
  return 0.125 * smoothing_length * smoothing_length / settings->viscosity;
}

double hc_time_step_to_end(const hc_step_settings *settings, double time, double dt, hc_step_bound *bound) {
  /* The last step ends the run on time; a sliver that rounding would leave behind is taken along. A much
   * shorter last step would turn what density error is left into velocity, so the last two share the time.
   * An adaptive step follows from the one before: where it would shrink in the last of the two, it does not.
   */
  const double left = settings->end_time - time;
  const bool adaptive = settings->control == HC_STEP_ADAPTIVE && left <= settings->max;
  const double slack = adaptive ? 2.0 * settings->adaptive.change : 1e-9;
  if (dt * (1.0 + slack) >= left) {
    *bound = HC_BOUND_END;
    return left;
  }
  return settings->control == HC_STEP_CONSTANT ? dt : fmin(dt, 0.5 * left);
}

double hc_time_step_next(const hc_step_settings *settings, double time, double dt_before,
                         const hc_step_report *report, hc_step_bound *bound) {
  *bound = HC_BOUND_SIZE;
  double dt = settings->control == HC_STEP_CONSTANT ? settings->size : settings->max;
  if (settings->control == HC_STEP_CFL) {
    if (report->v_max > 0.0)
      shrink(&dt, settings->factor * settings->spacing / report->v_max, HC_BOUND_VELOCITY, bound);
    if (report->force_max > 0.0)
      shrink(&dt, 0.25 * sqrt(settings->support_radius / report->force_max), HC_BOUND_FORCE, bound);
    shrink(&dt, hc_time_step_viscous_bound(settings), HC_BOUND_VISCOUS, bound);
    /* A run starts without pressure, which takes iterations to build up: fewest from a short first step on.
     */
    shrink(&dt, dt_before > 0.0 ? 1.1 * dt_before : FIRST_STEP * settings->max, HC_BOUND_GROWTH, bound);
  } else if (settings->control == HC_STEP_ADAPTIVE) {
    dt = dt_before > 0.0 ? hc_adaptive_next(settings, dt_before, report, bound)
                         : hc_adaptive_first(settings, report->v_max, bound);
    shrink(&dt, hc_time_step_viscous_bound(settings), HC_BOUND_VISCOUS, bound);
    shrink(&dt, settings->max, HC_BOUND_SIZE, bound);
  }
  return hc_time_step_to_end(settings, time, dt, bound);
}

double hc_time_step_floor(const hc_step_settings *settings) {
  if (settings->min > 0.0) return settings->min;
  return FLOOR_SHARE * (settings->control == HC_STEP_CONSTANT ? settings->size : settings->max);
}

bool hc_time_step_too_small(const hc_step_settings *settings, double time, double dt) {
  if (!(time + dt > time && isfinite(1.0 / (dt * dt)))) return true; /* no step at all */
  return dt < hc_time_step_floor(settings) && dt < 0.5 * (settings->end_time - time);
}

const char *hc_step_bound_name(hc_step_bound bound) {
  static const char *const names[] = {[HC_BOUND_SIZE] = "largest step",
                                      [HC_BOUND_VELOCITY] = "velocity",
                                      [HC_BOUND_FORCE] = "force",
                                      [HC_BOUND_VISCOUS] = "viscosity",
                                      [HC_BOUND_GROWTH] = "growth",
                                      [HC_BOUND_ERROR_AVG] = "average density error",
                                      [HC_BOUND_ERROR_MAX] = "largest density error",
                                      [HC_BOUND_DEPTH] = "depth of the fluid",
                                      [HC_BOUND_SHOCK] = "shock",
                                      [HC_BOUND_END] = "end of run"};
  return names[bound];
}
