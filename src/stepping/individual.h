/* Steps of a run whose particles have steps of their own, which the solver finds (solver/individual.h): each
 * is a block of those, as long as sound and viscosity are stable with. */
#ifndef HC_STEPPING_INDIVIDUAL_H
#define HC_STEPPING_INDIVIDUAL_H

#include "control.h"

/* Its settings are the common ones. */
extern const hc_control_ops hc_control_individual;

#endif
