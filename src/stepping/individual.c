#include "individual.h"

static double next(const hc_control *control, double dt_before, const hc_step_report *report,
                   hc_step_bound *bound) {
  const hc_individual_control *settings = (const hc_individual_control *)control->settings;
  (void)dt_before;
  *bound = HC_BOUND_SIZE;
  double step = settings->stable, dt;
  hc_time_step_shorten(&step, hc_time_step_viscous_bound(control->settings), HC_BOUND_VISCOUS, bound);
  const double most = step * (control->settings->longest / settings->stable);
  for (dt = step; 2.0 * dt <= most && 2.0 * dt * report->v_max <= settings->reach;) dt *= 2.0;
  return dt;
}

const hc_control_ops hc_control_individual = {.name = "individual",
                                              .when = HC_CONTROL_FROM_STATE,
                                              .speed_key = "velocity",
                                              .longest_key = "max",
                                              .in_blocks = true,
                                              .next = next};
