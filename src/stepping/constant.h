/* Steps of one length, which heed nothing. */
#ifndef HC_CONSTANT_H
#define HC_CONSTANT_H

#include "control.h"

extern const hc_control_ops hc_control_constant; /* hc_step_settings: no settings of its own */

#endif
