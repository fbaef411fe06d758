/* Steps of a run whose particles have steps of their own, which the solver finds (solver/individual.h): each
 * is a block of those, at least as long as sound and viscosity are stable with, and where the fluid is slow
 * up to four times that, while nothing moves farther than lists reach. */
#ifndef HC_STEPPING_INDIVIDUAL_H
#define HC_STEPPING_INDIVIDUAL_H

#include "control.h"

typedef struct hc_individual_control {
  hc_step_settings common; /* longest: of a block */
  double stable;           /* s: no particle's step is longer */
  double reach;            /* m: half the margin of lists */
} hc_individual_control;

extern const hc_control_ops hc_control_individual;

#endif
