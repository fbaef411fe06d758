/* The adaptive time step of Ihmsen, Akinci, Gissler, Teschner 2010, section 3.3: a step is a fixed small
 * share longer or shorter than the one before, or as long, as forces, speeds and density errors say; where
 * they rise at once, a shock, the run goes back two steps and on with a shorter one.
 *
 * Numbers in brackets are the paper's equations; h is the support radius. Beyond the paper: the first step
 * heeds the fluid's depth, as a fluid at rest has no speed to bound it; and (24) alone can return the step
 * that has just failed, because at an impact forces grow as 1/dt2, so a replay begins with no more than a
 * share of it. */
#ifndef HC_ADAPTIVE_H
#define HC_ADAPTIVE_H

#include "control.h"

/* Factors of sqrt(h/F) and h/v, bounds of the time step, and of eta_avg, bounds of the density errors. */
typedef struct hc_adaptive_bounds {
  double force, velocity, error_max, error_avg;
} hc_adaptive_bounds;

typedef struct hc_adaptive_settings {
  hc_step_settings common;
  double error_avg, error_max;            /* eta_avg, eta_max: fractions of the rest density */
  double change;                          /* share by which a step grows or shrinks */
  hc_adaptive_bounds grow, shrink;        /* (16) to (19), (20) to (23) */
  double shock_rise, shock_velocity;      /* delta_shock (25), a fraction of the rest density; factor (27) */
  double restart_force, restart_velocity; /* factors of (24) */
  double restart_share;                   /* of the step that failed: the replay begins with no more */
  int most_restarts;                      /* of one shock */
  double first_velocity;                  /* factor of h/v0 */
} hc_adaptive_settings;

extern const hc_control_ops hc_control_adaptive;

#endif
