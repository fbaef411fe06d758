/* What bounds every time step, however it is chosen: its length, the viscosity, the end of the run, a floor.
 */
#ifndef HC_TIME_STEP_H
#define HC_TIME_STEP_H

#include <stdbool.h>

/* What bounded a step; adaptive: what made it shrink or kept it from growing. */
typedef enum hc_step_bound {
  HC_BOUND_SIZE,     /* constant, or the largest allowed */
  HC_BOUND_VELOCITY, /* factor * spacing / v_max (Bender and Koschier 2015) */
  HC_BOUND_FORCE,    /* 0.25 sqrt(h / F) with F the largest non-pressure acceleration (Monaghan 1992) */
  HC_BOUND_VISCOUS,  /* 0.125 (h/2)^2 / nu (Morris et al. 1997, whose h is half the support radius) */
  HC_BOUND_GROWTH,   /* a tenth more than the last step, a quarter of the largest at first; adaptive: 0.2 % */
  HC_BOUND_ERROR_AVG, /* adaptive: the average density error */
  HC_BOUND_ERROR_MAX, /* adaptive: the largest density error */
  HC_BOUND_DEPTH,     /* adaptive, first step: what gravity makes of the fluid's height */
  HC_BOUND_SHOCK,     /* adaptive: the first step after a rollback */
  HC_BOUND_END        /* the end of the run */
} hc_step_bound;

const char *hc_step_bound_name(hc_step_bound bound);

/* What every control heeds; the first member of its own settings. */
typedef struct hc_step_settings {
  double longest;                 /* s: no step is longer; constant: all are as long */
  double min;                     /* s: the floor; 0 = 1e-5 of the longest step */
  double spacing, support_radius; /* m */
  double viscosity;               /* m2/s, 0 = no viscous bound */
  double end_time;                /* s */
} hc_step_settings;

/* Makes *dt no longer than `limit`; *bound becomes the reason if that shortens it. Local. */
void hc_time_step_shorten(double *dt, double limit, hc_step_bound reason, hc_step_bound *bound);

/* The largest step that the viscosity allows, s; INFINITY without one. Local. */
double hc_time_step_viscous_bound(const hc_step_settings *settings);

/* What the end of the run makes of a step from `time` on: one that comes to it within the share `slack` of
 * dt ends there, so that no sliver is left; `halve`: the last two steps share the time, since a much shorter
 * last step would turn what density error is left into velocity. Local. */
double hc_time_step_to_end(const hc_step_settings *settings, double time, double dt, double slack, bool halve,
                           hc_step_bound *bound);

/* The slack that is rounding's. */
#define HC_TIME_STEP_SLIVER 1e-9

/* The floor, s; and whether a step is below it, though the end of the run does not ask for one so short.
 * Local. */
double hc_time_step_floor(const hc_step_settings *settings);
bool hc_time_step_too_small(const hc_step_settings *settings, double time, double dt);

#endif
