#include "individual.h"

static double next(const hc_control *control, double dt_before, const hc_step_report *report,
                   hc_step_bound *bound) {
  (void)dt_before;
  (void)report;
  *bound = HC_BOUND_SIZE;
  double dt = control->settings->longest;
  hc_time_step_shorten(&dt, hc_time_step_viscous_bound(control->settings), HC_BOUND_VISCOUS, bound);
  return dt;
}

const hc_control_ops hc_control_individual = {.name = "individual",
                                              .when = HC_CONTROL_FROM_STATE,
                                              .speed_key = "velocity",
                                              .longest_key = "max",
                                              .next = next};
