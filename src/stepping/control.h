/* The step controls behind one table of operations, chosen by name: how long a step is, and whether it
 * counts.
 *
 * A control gives in its hc_control_ops:
 *   required   name, when, speed_key, longest_key, next
 *   optional   usual    default: 0.4 spacings at that speed
 *              still    default: the longest step
 *              foreseen, in_blocks, by_errors  default: false
 *              goes_on     default: false
 *   all or none  goes_back, judge, restart, most_restarts: steps may be taken back. Without them every step
 * that did not fail counts, and one that failed ends the run. Its settings begin with the common ones. All
 * functions are local, and the same on every rank if what they are told is. */
#ifndef HC_CONTROL_H
#define HC_CONTROL_H

#include "shock.h"
#include "solver/solver.h"
#include "time_step.h"

typedef struct hc_control hc_control;

/* Where a step's length comes from. */
typedef enum hc_control_when {
  HC_CONTROL_FROM_STATE, /* known as the step begins, before neighbour lists */
  HC_CONTROL_FROM_FORCES /* of the step itself, between its forces and its move */
} hc_control_when;

/* A step just tried. */
typedef struct hc_step_tried {
  double time, dt;              /* s: at its beginning; its length */
  const hc_step_report *report; /* v_max is that of all that moves */
  double error_before;          /* the largest density error of the step before; negative: there was none */
  bool capped_before;           /* the solver was at its cap in the step before */
  hc_status status;             /* of the step */
  bool forced;                  /* a test hook wants it taken back */
} hc_step_tried;

typedef enum hc_verdict {
  HC_VERDICT_ACCEPT,
  HC_VERDICT_TAKE_BACK,
  HC_VERDICT_FAILED,     /* as the step's error says */
  HC_VERDICT_GAVE_UP,    /* a shock came again in every replay allowed */
  HC_VERDICT_UNDER_FLOOR /* the step is shorter than the floor */
} hc_verdict;

typedef struct hc_control_ops {
  const char *name;
  hc_control_when when;
  const char *speed_key, *longest_key; /* what a user lowers in time_step, for high speeds and in general */
  bool foreseen;                       /* the number of steps is known beforehand */
  bool in_blocks;                      /* a step of the run is a block of steps of particles */
  bool by_errors; /* steps follow the density errors: a solver need not iterate until they are small */
  int goes_back;  /* how many steps are taken back at once, at least: 1 or 2; 0: none ever */
  bool goes_on;   /* once the replays allowed are used up: steps count, and one that fails is the run's end as
                     it is; else it has given up */

  /* The next step, given the last one (dt_before = 0 at the first) and what it reported: v_max, force_max and
   * density errors; and what bounds it. Where the run ends it is the control's to heed, not the table's. */
  double (*next)(const hc_control *control, double dt_before, const hc_step_report *report,
                 hc_step_bound *bound);

  /* The longest step usual at that speed, m/s; and one with which fluid at rest settles. */
  double (*usual)(const hc_step_settings *settings, double speed);
  double (*still)(const hc_control *control);

  /* The shock that a step was, of kind NONE if it was none, that did not fail or may do better when shorter;
   * the step with which to go on after a shock, from what it reported; how many replays it may cost. */
  hc_shock (*judge)(const hc_control *control, const hc_step_tried *tried);
  double (*restart)(const hc_control *control, const hc_shock *shock, const hc_step_report *report);
  int (*most_restarts)(const hc_step_settings *settings);
} hc_control_ops;

/* Steps of one length that have passed since a time, so that times are counted and not summed. State. */
typedef struct hc_step_count {
  double origin, size, steps; /* s, s, 1 */
} hc_step_count;

struct hc_control {
  const hc_control_ops *ops;
  hc_step_settings *settings; /* the control's own, the common ones first; owned */
  int goes_back;              /* as in the table, or more where the solver needs it */
  hc_step_bound bound;        /* of the last step chosen */
  double end;                 /* s: when that ends */
  hc_shock_guard guard;
  hc_step_count count;
  int64_t before; /* steps that were taken back since the last step that counts, seen from this one */
  double v_max, force_max; /* m/s, m/s2: of the step that was the last shock; 0 if it diverged */
};

/* Takes over settings from hc_alloc. */
void hc_control_init(hc_control *control, const hc_control_ops *ops, hc_step_settings *settings);
void hc_control_free(hc_control *control);

/* Registers what is state, whatever the control: a restart may have another. */
void hc_control_register(hc_control *control, hc_state *state);

bool hc_control_may_go_back(const hc_control *control);

/* The step from `time` on, as hc_control_ops.next says and the end of the run allows; its
 * bound and its end stay in the control. */
double hc_control_next(hc_control *control, double time, double dt_before, const hc_step_report *report);

double hc_control_usual(const hc_control *control, double speed);
double hc_control_still(const hc_control *control);

/* May a step of dt be tried? ACCEPT, GAVE_UP or UNDER_FLOOR. */
hc_verdict hc_control_permit(const hc_control *control, double time, double dt);

/* Does the step count? ACCEPT, TAKE_BACK with the shock that it was, or FAILED. */
hc_verdict hc_control_judge(const hc_control *control, const hc_step_tried *tried, hc_shock *shock);

/* The state is back by `steps` steps: chooses the step to go on with, from what the shock reported. */
void hc_control_take_back(hc_control *control, const hc_shock *shock, const hc_step_report *report,
                          int steps);

/* The step of dt chosen last counts. */
void hc_control_accept(hc_control *control, double dt);

#endif
