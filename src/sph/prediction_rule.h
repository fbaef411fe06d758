/* From a predicted density to the next pressure: the step that the PCISPH sweeps share. */
#ifndef HC_PREDICTION_RULE_H
#define HC_PREDICTION_RULE_H

#include "error_rule.h"

/* The pressure of a particle, raised by what it is too dense beyond what is left for later; no more is left
 * than there is. Or a share of what it is too dense beyond that is left for later, too. */
static inline void hc_raise_pressure(const hc_sweep *sweep, const hc_prediction *prediction,
                                     hc_particles *particles, int32_t i, float relative) {
  float *const late = &particles->late_compression[i];
  const float excess = relative - 1.0f;
  if (prediction->leaves > 0.0f && excess > *late) *late += prediction->leaves * (excess - *late);
  if (prediction->stiffness == 0.0f) return;
  const float above = excess > 0.0f ? excess : 0.0f, least = prediction->negative ? -INFINITY : 0.0f;
  *late = *late > excess ? above : *late; /* no branches: nobody could predict them */
  const float next = particles->pressure[i] + sweep->rest_density * prediction->stiffness * (excess - *late);
  particles->pressure[i] = next < least ? least : next;
}

/* p/(rho0 D^2), what eq. 6 weighs the kernel's gradient with; where walls mirror it p/rho0, so that the push
 * on a wall follows from the pressure alone, contact's share included. */
static inline float hc_pressure_scalar(const hc_sweep *sweep, float pressure, float relative) {
  if (sweep->walls_add == HC_WALLS_MIRRORED) return pressure / sweep->rest_density;
  return pressure / (sweep->rest_density * relative * relative);
}

/* Returns the relative error. */
static inline float hc_end_prediction(const hc_sweep *sweep, const hc_prediction *prediction, int32_t i,
                                      float relative) {
  hc_particles *fluid = sweep->fluid;
  fluid->density[i] = sweep->rest_density * relative;
  hc_raise_pressure(sweep, prediction, fluid, i, relative);
  fluid->place[i].scalar = hc_pressure_scalar(sweep, fluid->pressure[i], relative);
  return relative - 1.0f;
}

#endif
