/* What bounds every time step, however it is chosen: its length, the viscosity, the end of the run, a floor.
 */
#ifndef HC_TIME_STEP_H
#define HC_TIME_STEP_H

#include <stdbool.h>

/* What bounded a step; adaptive: what made it shrink or kept it from growing. */
typedef enum hc_step_bound {
  HC_BOUND_SIZE,     /* constant, or the largest allowed */
  HC_BOUND_VELOCITY, /* factor * spacing / v_max (Bender and Koschier 2015) */
  HC_BOUND_FORCE,    /* 0.25 sqrt(h / F) with F the largest non-pressure acceleration (Monaghan 1992); global:
                        0.05 with F of all (He et al. 2015) */
  HC_BOUND_VISCOUS,  /* 0.125 (h/2)^2 / nu (Morris et al. 1997, whose h is half the support radius) */
  HC_BOUND_GROWTH,   /* a tenth more than the last step, a quarter of the largest at first; adaptive: 0.2 % */
  HC_BOUND_ERROR_AVG, /* adaptive: the average density error */
  HC_BOUND_ERROR_MAX, /* adaptive: the largest density error */
  HC_BOUND_DEPTH,     /* first step: what gravity makes of the fluid's height */
  HC_BOUND_SHOCK,     /* the first step after a rollback */
  HC_BOUND_END        /* the end of the run */
} hc_step_bound;

const char *hc_step_bound_name(hc_step_bound bound);

/* What every control heeds; the first member of its own settings. */
typedef struct hc_step_settings {
  double longest;                 /* s: no step is longer; constant: all are as long */
  double min;                     /* s: the floor; 0 = 1e-5 of the longest step */
  double spacing, support_radius; /* m */
  double viscosity;               /* m2/s, 0 = no viscous bound */
  double first;                   /* s: a run that starts at rest begins with no more */
  double end_time;                /* s */
  double spare;                   /* share by which the last steps before that may be longer, so that steps
                                     which shrink by less each time come to it */
} hc_step_settings;

/* Makes *dt no longer than `limit`; *bound becomes the reason if that shortens it. Local. */
void hc_time_step_shorten(double *dt, double limit, hc_step_bound reason, hc_step_bound *bound);

/* The largest step that the viscosity allows, s; INFINITY without one. Local. */
double hc_time_step_viscous_bound(const hc_step_settings *settings);

/* How many multiples of `every` above 0 a run has come to by `time`: one that is missed by rounding counts. A
 * function of the time alone, which a restart need not remember. Local. */
double hc_time_step_multiples(double every, double time);

/* Where a step of *dt from `time` on ends, s: what is left to the end of the run is shared out among the
 * steps of that length that still fit, so that the last of them is none that is much shorter, which would
 * turn what density error is left into velocity. Shortens *dt, or makes it longer by settings->spare at most;
 * *bound becomes HC_BOUND_END for the step that reaches the end. Local. */
double hc_time_step_land(const hc_step_settings *settings, double time, double *dt, hc_step_bound *bound);

/* The same for steps of one length: the last one alone is shorter. `steps` of it have passed since `origin`,
 * so that times are counted and not summed. Local. */
double hc_time_step_count(const hc_step_settings *settings, double origin, double steps, double *dt,
                          hc_step_bound *bound);

/* The floor, s; and whether a step is below it, though the end of the run does not ask for one so short.
 * Local. */
double hc_time_step_floor(const hc_step_settings *settings);
bool hc_time_step_too_small(const hc_step_settings *settings, double time, double dt);

#endif
