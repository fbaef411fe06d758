/* The choice of the time step. */
#ifndef HC_TIME_STEP_H
#define HC_TIME_STEP_H

#include "solver/solver.h"

typedef enum hc_step_control { HC_STEP_CONSTANT, HC_STEP_CFL } hc_step_control;

/* What bounded a step. */
typedef enum hc_step_bound {
  HC_BOUND_SIZE,     /* constant, or the largest allowed */
  HC_BOUND_VELOCITY, /* factor * spacing / v_max (Bender and Koschier 2015) */
  HC_BOUND_FORCE,    /* 0.25 sqrt(h / F) with F the largest non-pressure acceleration (Monaghan 1992) */
  HC_BOUND_VISCOUS,  /* 0.125 (h/2)^2 / nu (Morris et al. 1997, whose h is half the support radius) */
  HC_BOUND_GROWTH,   /* a tenth more than the last step, a quarter of the largest at first */
  HC_BOUND_END       /* the end of the run */
} hc_step_bound;

typedef struct hc_step_settings {
  hc_step_control control;
  double size, max, factor;       /* s, s, 1 */
  double min;                     /* s: the floor; 0 = 1e-5 of the largest step */
  double spacing, support_radius; /* m */
  double viscosity;               /* m2/s, 0 = no viscous bound */
  double end_time;                /* s */
} hc_step_settings;

/* The step from `time` on, given the last one (dt_before = 0 at the first) and what it reported: v_max and
 * force_max are read. The same on every rank if the arguments are. Local. */
double hc_time_step_next(const hc_step_settings *settings, double time, double dt_before,
                         const hc_step_report *report, hc_step_bound *bound);

/* The largest step that the viscosity allows, s; INFINITY without one. Local. */
double hc_time_step_viscous_bound(const hc_step_settings *settings);

/* The floor, s; and whether a step is below it, though the end of the run does not ask for one so short.
 * Local. */
double hc_time_step_floor(const hc_step_settings *settings);
bool hc_time_step_too_small(const hc_step_settings *settings, double time, double dt);

const char *hc_step_bound_name(hc_step_bound bound);

#endif
