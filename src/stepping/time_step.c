#include "time_step.h"

#include <math.h>

static const double FLOOR_SHARE = 1e-5;

void hc_time_step_shorten(double *dt, double limit, hc_step_bound reason, hc_step_bound *bound) {
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

double hc_time_step_to_end(const hc_step_settings *settings, double time, double dt, double slack, bool halve,
                           hc_step_bound *bound) {
  const double left = settings->end_time - time;
  if (dt * (1.0 + slack) >= left) {
    *bound = HC_BOUND_END;
    return left;
  }
  return halve ? fmin(dt, 0.5 * left) : dt;
}

double hc_time_step_floor(const hc_step_settings *settings) {
  return settings->min > 0.0 ? settings->min : FLOOR_SHARE * settings->longest;
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
