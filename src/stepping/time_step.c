#include "time_step.h"

#include <float.h>
#include <math.h>

static const double FLOOR_SHARE = 1e-5;
static const double SLIVER = 1e-9; /* of a step or an interval: what is rounding's */
static const double MANY = 50.0;   /* steps: see hc_time_step_land */

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

double hc_time_step_multiples(double every, double time) {
  const double passed = time / every;
  return floor(passed + SLIVER + 4.0 * DBL_EPSILON * passed);
}

double hc_time_step_land(const hc_step_settings *settings, double time, double *dt, hc_step_bound *bound) {
  const double left = settings->end_time - time;
  const double steps = ceil(left / *dt * (1.0 - settings->spare - SLIVER));
  if (!(steps <= MANY)) return time + *dt; /* no number, too: the step is refused for what it is */
  *dt = left / fmax(1.0, steps);
  if (steps > 1.0) return time + *dt;
  *bound = HC_BOUND_END;
  return settings->end_time;
}

double hc_time_step_count(const hc_step_settings *settings, double origin, double steps, double *dt,
                          hc_step_bound *bound) {
  const double begin = origin + steps * *dt, end = origin + (steps + 1.0) * *dt;
  if (end < settings->end_time - SLIVER * *dt) return end;
  *dt = settings->end_time - begin;
  *bound = HC_BOUND_END;
  return settings->end_time;
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
