/* From a predicted density to the next pressure: the step that the PCISPH sweeps share. */
#ifndef HC_PREDICTION_RULE_H
#define HC_PREDICTION_RULE_H

#include "error_rule.h"

static inline float hc_next_pressure(const hc_sweep *sweep, const hc_prediction *prediction, float pressure,
                                     float relative) {
  const float next = pressure + sweep->rest_density * prediction->stiffness * (relative - 1.0f);
  return next < 0.0f && !prediction->negative ? 0.0f : next;
}

/* p/(rho0 D^2), what eq. 6 weighs the kernel's gradient with; where walls mirror it p/rho0, so that the push
 * on a wall follows from the pressure alone, contact's share included. */
static inline float hc_pressure_scalar(const hc_sweep *sweep, float pressure, float relative) {
  if (sweep->walls_add == HC_WALLS_MIRRORED) return pressure / sweep->rest_density;
  return pressure / (sweep->rest_density * relative * relative);
}

static inline void hc_end_prediction(const hc_sweep *sweep, const hc_prediction *prediction, int32_t i,
                                     float relative, hc_error_total *total) {
  hc_particles *fluid = sweep->fluid;
  fluid->density[i] = sweep->rest_density * relative;
  fluid->pressure[i] = hc_next_pressure(sweep, prediction, fluid->pressure[i], relative);
  fluid->place[i].scalar = hc_pressure_scalar(sweep, fluid->pressure[i], relative);
  hc_error_note(relative > 1.0f ? relative - 1.0f : relative != relative ? relative : 0.0f, total);
}

#endif
