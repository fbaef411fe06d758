/* The globally adaptive time step of He, Ban, Liu, Wang 2015, section 2.2: one step for all particles, as
 * long as their speeds and the forces of this very step allow, eq. 6 to 8, and no longer than sound is stable
 * with, which the paper does not say. For solvers whose forces do not hang on the step. */
#ifndef HC_GLOBAL_H
#define HC_GLOBAL_H

#include "control.h"

typedef struct hc_global_settings {
  hc_step_settings common;
  double velocity, force; /* lambda_v, lambda_f: of h/v, sqrt(h/F) with the support radius h */
} hc_global_settings;

extern const hc_control_ops hc_control_global;

#endif
