/* The adaptive time step of Ihmsen, Akinci, Gissler, Teschner 2010, section 3.3: a step is a fixed small
 * share longer or shorter than the one before, or as long, as forces, speeds and density errors say; where
 * they rise at once, a shock, the run goes back two steps and on with a shorter one.
 *
 * Numbers in brackets are the paper's equations; h is the support radius. Beyond the paper: the first step
 * heeds the fluid's depth, as a fluid at rest has no speed to bound it; and (24) alone can return the step
 * that has just failed, because at an impact forces grow as 1/dt2, so a replay begins with no more than a
 * share of it. All functions are local and the same on every rank if the arguments are. */
#ifndef HC_ADAPTIVE_H
#define HC_ADAPTIVE_H

#include "time_step.h"

/* The first step, s, given the largest speed at the start; and the step after one of dt_before that reported
 * v_max, force_max and density errors. Bounds that every control has are the caller's. */
double hc_adaptive_first(const hc_step_settings *settings, double v_max, hc_step_bound *bound);
double hc_adaptive_next(const hc_step_settings *settings, double dt_before, const hc_step_report *report,
                        hc_step_bound *bound);

typedef enum hc_shock_kind {
  HC_SHOCK_NONE,
  HC_SHOCK_RISE,     /* (25): the largest density error has risen by more than delta_shock */
  HC_SHOCK_ERROR,    /* (26): it is more than eta_max */
  HC_SHOCK_VELOCITY, /* (27): the step is too long for the largest speed */
  HC_SHOCK_FAULT,    /* the step has failed, as a shorter one might not have (not in the paper) */
  HC_SHOCK_FORCED    /* a test hook */
} hc_shock_kind;

/* A step that does not count. Eight bytes each, so that it can be state. */
typedef struct hc_shock {
  int64_t kind;
  double time, dt;     /* s: the step's end and length */
  double value, limit; /* what was too large: a density error, or its rise, fractions; or dt, s */
} hc_shock;

/* The first of (25), (26), (27) that holds for a step of dt that ended at `time` with this report;
 * error_before: the largest density error of the step before, negative if there was none. */
hc_shock hc_shock_find(const hc_step_settings *settings, double time, double dt, double error_before,
                       const hc_step_report *report);

/* What it was, in words. */
enum { HC_SHOCK_TEXT = 160 };
void hc_shock_text(const hc_shock *shock, char text[static HC_SHOCK_TEXT]);

/* What the control remembers of shocks. Zeroed at the start. State of the run: a rollback brings it back too,
 * and then adds itself. Accepted steps of a replay do not end the guard, only the time of the shock does. */
typedef struct hc_shock_guard {
  hc_shock shock;    /* the last; of no meaning behind it */
  double until;      /* s: a replay is under way until then; 0: none */
  double begun;      /* s: the step with which the replay began */
  double next;       /* s: the next step's length; 0: as the last one's report says */
  int64_t restarts;  /* of this replay */
  int64_t rollbacks; /* of the run */
  int64_t steps;     /* that they took back, the failed ones included */
  int64_t untold;    /* of these, those that no row of steps.csv has told of yet */
} hc_shock_guard;

/* A shock, by which `steps` steps were taken back: chooses the step to go on with. */
void hc_shock_guard_hit(hc_shock_guard *guard, const hc_step_settings *settings, const hc_shock *shock,
                        const hc_step_report *report, int steps);

/* A step that counts, and ends at `time`. Returns how many were taken back before it. */
int64_t hc_shock_guard_pass(hc_shock_guard *guard, double time);

#endif
