/* From a particle's density rate to its error and multiplier: the step that the sweeps share. */
#ifndef HC_ERROR_RULE_H
#define HC_ERROR_RULE_H

#include "sweeps.h"

#include <math.h>

static const double HC_ERROR_UNITS = 0x1p30;

/* Adds an error, which is not negative, to a total. */
static inline void hc_error_note(float size, hc_error_total *total) {
  if (!(size < 0x1p30f)) { /* a NaN too */
    total->not_finite = true;
    return;
  }
  total->sum += (int64_t)llrint((double)size * HC_ERROR_UNITS);
  if (size > total->max) total->max = size;
}

/* A particle's error by the rule; its multiplier goes to place.scalar. */
static inline float hc_error_apply(const hc_sweep *sweep, const hc_error_rule *rule, float per_density,
                                   int32_t row, int32_t i, float rate) {
  hc_particles *fluid = sweep->fluid;
  const float excess = fluid->density[i] * per_density - 1.0f;
  float e = rule->of_density * excess + rule->of_rate * rate;
  if (excess < 0.0f) e += rule->of_gap * excess;
  if (rule->min_neighbors > 0 &&
      hc_list_count(sweep->list, row) + hc_list_count(sweep->walls, row) < rule->min_neighbors)
    e = 0.0f;
  if (e < 0.0f && !rule->signed_error) e = 0.0f;
  fluid->place[i].scalar = rule->relaxation * fluid->alpha[i] * e;
  return e;
}

/* The end of an error sweep for particles whose place.scalar already holds dD/dt; nothing is added up. */
void hc_error_from_rate(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection);

/* The sum as an exact sum, NaN if an error was not finite. */
hc_sum hc_error_sum(const hc_error_total *total);

#endif
