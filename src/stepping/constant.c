#include "constant.h"

static double next(const hc_control *control, double dt_before, const hc_step_report *report,
                   hc_step_bound *bound) {
  (void)dt_before;
  (void)report;
  *bound = HC_BOUND_SIZE;
  return control->settings->longest;
}

const hc_control_ops hc_control_constant = {.name = "constant",
                                            .when = HC_CONTROL_FROM_STATE,
                                            .speed_key = "size",
                                            .longest_key = "size",
                                            .foreseen = true,
                                            .next = next};
