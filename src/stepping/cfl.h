/* Steps as long as speeds, forces and viscosity allow: the Courant number of Bender and Koschier 2015, the
 * force bound of Monaghan 1992, the viscous one of Morris et al. 1997; growing by no more than a tenth. */
#ifndef HC_CFL_H
#define HC_CFL_H

#include "control.h"

typedef struct hc_cfl_settings {
  hc_step_settings common;
  double factor; /* of spacing / v_max */
} hc_cfl_settings;

extern const hc_control_ops hc_control_cfl;

#endif
