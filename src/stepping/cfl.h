/* Steps as long as speeds, forces and viscosity allow: the Courant number of Bender and Koschier 2015, the
 * force bound of Monaghan 1992, the viscous one of Morris et al. 1997; growing by no more than a tenth.
 *
 * A step that was too long runs away where it counts: the density error that its solve has left is taken back
 * by the next ones in ever shorter times, so at ever higher speeds. So a step whose solve stops at its cap
 * far from its aim, or at whose end something is so fast that it was twice too long for it, is taken back and
 * tried at half its length, a few times; after that it counts as it is, and steps at their cap are no more
 * judged until one was not. Steps approach a length that failed slowly. */
#ifndef HC_CFL_H
#define HC_CFL_H

#include "control.h"

typedef struct hc_cfl_settings {
  hc_step_settings common;
  double factor;    /* of spacing / v_max */
  double error_avg; /* where the density solve stops before its cap, a fraction of the rest density */
} hc_cfl_settings;

extern const hc_control_ops hc_control_cfl;

#endif
