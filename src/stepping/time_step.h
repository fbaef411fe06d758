/* The choice of the time step. */
#ifndef HC_TIME_STEP_H
#define HC_TIME_STEP_H

#include "solver/solver.h"

typedef enum hc_step_control { HC_STEP_CONSTANT, HC_STEP_CFL, HC_STEP_ADAPTIVE } hc_step_control;

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

/* Factors of sqrt(h/F) and h/v, bounds of the time step, and of eta_avg, bounds of the density errors. */
typedef struct hc_adaptive_bounds {
  double force, velocity, error_max, error_avg;
} hc_adaptive_bounds;

/* The constants of Ihmsen et al. 2010, section 3.3; in brackets its equations. See adaptive.h. */
typedef struct hc_adaptive_settings {
  double error_avg, error_max;            /* eta_avg, eta_max: fractions of the rest density */
  double change;                          /* share by which a step grows or shrinks */
  hc_adaptive_bounds grow, shrink;        /* (16) to (19), (20) to (23) */
  double shock_rise, shock_velocity;      /* delta_shock (25), a fraction of the rest density; factor (27) */
  double restart_force, restart_velocity; /* factors of (24) */
  double restart_share;                   /* of the step that failed: the replay begins with no more */
  int most_restarts;                      /* of one shock */
  double first_velocity, first_depth;     /* factors of h/v0 and spacing/sqrt(gravity depth) */
  double gravity, depth;                  /* m/s2; m: the fluid's height along gravity at the start */
} hc_adaptive_settings;

typedef struct hc_step_settings {
  hc_step_control control;
  double size, max, factor;       /* s, s, 1: constant; cfl and adaptive; cfl */
  double min;                     /* s: the floor; 0 = 1e-5 of the largest step */
  double spacing, support_radius; /* m */
  double viscosity;               /* m2/s, 0 = no viscous bound */
  double end_time;                /* s */
  hc_adaptive_settings adaptive;
} hc_step_settings;

/* The step from `time` on, given the last one (dt_before = 0 at the first) and what it reported: v_max and
 * force_max are read, adaptive: the density errors too. The same on every rank if the arguments are. Local.
 */
double hc_time_step_next(const hc_step_settings *settings, double time, double dt_before,
                         const hc_step_report *report, hc_step_bound *bound);

/* The same for a step that is chosen already: what the end of the run makes of it. Local. */
double hc_time_step_to_end(const hc_step_settings *settings, double time, double dt, hc_step_bound *bound);

/* The largest step that the viscosity allows, s; INFINITY without one. Local. */
double hc_time_step_viscous_bound(const hc_step_settings *settings);

/* The floor, s; and whether a step is below it, though the end of the run does not ask for one so short.
 * Local. */
double hc_time_step_floor(const hc_step_settings *settings);
bool hc_time_step_too_small(const hc_step_settings *settings, double time, double dt);

const char *hc_step_bound_name(hc_step_bound bound);

#endif
