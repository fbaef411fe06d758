#include "cfl.h"

#include <math.h>

static const double FIRST_STEP = 0.25; /* of the longest */
static const double GROWTH = 1.1;
static const double NEAR = 0.7, NEAR_GROWTH = 1.01; /* where a step comes so near to one that failed */
static const double FAR = 5.0;                      /* times the aim is far from it */
static const double JUMP = 2.0;                     /* times as fast as a step was made for */
static const double RESTART = 0.5;                  /* of the step that failed */
enum { MOST_RESTARTS = 5 };

static const hc_cfl_settings *settings_of(const hc_control *control) {
  return (const hc_cfl_settings *)control->settings;
}

/* The longest after one of dt_before. A run starts without pressure, which takes iterations to build up:
 * fewest from a short first step on. */
static double grown(const hc_control *control, double dt_before) {
  const hc_step_settings *common = control->settings;
  if (!(dt_before > 0.0)) return fmin(FIRST_STEP * common->longest, common->first);
  const double failed = control->guard.shock.dt;
  if (dt_before < failed && GROWTH * dt_before > NEAR * failed)
    return fmax(fmin(GROWTH * dt_before, NEAR * failed), NEAR_GROWTH * dt_before);
  return GROWTH * dt_before;
}

static double next(const hc_control *control, double dt_before, const hc_step_report *report,
                   hc_step_bound *bound) {
  const hc_cfl_settings *settings = settings_of(control);
  const hc_step_settings *common = &settings->common;
  *bound = HC_BOUND_SIZE;
  double dt = common->longest;
  if (report->v_max > 0.0)
    hc_time_step_shorten(&dt, settings->factor * common->spacing / report->v_max, HC_BOUND_VELOCITY, bound);
  if (report->force_max > 0.0)
    hc_time_step_shorten(&dt, 0.25 * sqrt(common->support_radius / report->force_max), HC_BOUND_FORCE, bound);
  hc_time_step_shorten(&dt, hc_time_step_viscous_bound(common), HC_BOUND_VISCOUS, bound);
  hc_time_step_shorten(&dt, grown(control, dt_before), HC_BOUND_GROWTH, bound);
  if (control->guard.next != 0.0) hc_time_step_shorten(&dt, control->guard.next, HC_BOUND_SHOCK, bound);
  return dt;
}

static hc_shock judge(const hc_control *control, const hc_step_tried *tried) {
  const hc_cfl_settings *settings = settings_of(control);
  const hc_step_report *report = tried->report;
  const double end = tried->time + tried->dt, allowed = FAR * settings->error_avg,
               longest = JUMP * settings->factor * settings->common.spacing / report->v_max;
  if (report->density_capped && !tried->capped_before && report->density_error_avg > allowed)
    return (hc_shock){HC_SHOCK_CAP, end, tried->dt, report->density_error_avg, allowed};
  if (tried->dt > longest) return (hc_shock){HC_SHOCK_JUMP, end, tried->dt, tried->dt, longest};
  return (hc_shock){.kind = HC_SHOCK_NONE};
}

static double restart(const hc_control *control, const hc_shock *shock, const hc_step_report *report) {
  (void)control;
  (void)report;
  return RESTART * shock->dt;
}

static int most_restarts(const hc_step_settings *settings) {
  (void)settings;
  return MOST_RESTARTS;
}

const hc_control_ops hc_control_cfl = {.name = "cfl",
                                       .when = HC_CONTROL_FROM_STATE,
                                       .speed_key = "factor",
                                       .longest_key = "max",
                                       .goes_back = 1,
                                       .goes_on = true,
                                       .next = next,
                                       .judge = judge,
                                       .restart = restart,
                                       .most_restarts = most_restarts};
