/* Initial velocity fields. */
#ifndef HC_FLOW_H
#define HC_FLOW_H

#include "scene/scene.h"

/* Adds the flow's velocity (m/s) at the scene coordinates `x` (m) to `velocity`. Uses + - * / and
 * rounding only, so that ranks on unlike machines agree to the last bit. Local; no errors. */
void hc_flow_add(const hc_flow *flow, const double x[3], double velocity[3]);

#endif
