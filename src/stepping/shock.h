/* Steps that do not count, and what a run remembers of them while it goes over their time again. */
#ifndef HC_SHOCK_H
#define HC_SHOCK_H

#include "state/state.h"

#include <stdint.h>

typedef enum hc_shock_kind {
  HC_SHOCK_NONE,
  HC_SHOCK_RISE,     /* (25): the largest density error has risen by more than delta_shock */
  HC_SHOCK_ERROR,    /* (26): it is more than eta_max */
  HC_SHOCK_VELOCITY, /* (27): the step is too long for the largest speed */
  HC_SHOCK_CAP,      /* cfl: the density solve stopped at its cap, far from its aim */
  HC_SHOCK_JUMP,     /* cfl: the step was much too long for the speed at its end */
  HC_SHOCK_FAULT,    /* the step has failed, as a shorter one might not have (not in the paper) */
  HC_SHOCK_FORCED    /* a test hook */
} hc_shock_kind;

/* A step that does not count; numbers in brackets are equations of Ihmsen et al. 2010, see adaptive.h. Eight
 * bytes each, so that it can be state. */
typedef struct hc_shock {
  int64_t kind;
  double time, dt;     /* s: the step's end and length */
  double value, limit; /* what was too large: a density error, or its rise, fractions; or dt, s */
} hc_shock;

/* What it was, in words. */
enum { HC_SHOCK_TEXT = 160 };
void hc_shock_text(const hc_shock *shock, char text[static HC_SHOCK_TEXT]);

/* What is remembered of shocks. Zeroed at the start. State of the run: a rollback brings it back too, and
 * then adds itself. Accepted steps of a replay do not end the guard, only the time of the shock does. */
typedef struct hc_shock_guard {
  hc_shock shock;    /* the last; of no meaning behind it */
  double until;      /* s: a replay is under way until then; 0: none */
  double begun;      /* s: the step with which the replay began */
  double next;       /* s: the next step's length; 0: as the last one's report says */
  int64_t restarts;  /* of this replay */
  int64_t rollbacks; /* of the run */
  int64_t steps;     /* that they took back, the failed ones included */
  int64_t untold;    /* of these, those that no row of steps.csv has told of yet */
  int64_t forced;    /* shocks by the test hook so far */
} hc_shock_guard;

/* Registers what is state. Local. */
void hc_shock_guard_register(hc_shock_guard *guard, hc_state *state);

/* A shock, by which `steps` steps were taken back: the run goes on with a step of `next`. Local. */
void hc_shock_guard_hit(hc_shock_guard *guard, const hc_shock *shock, double next, int steps);

/* A step that counts, and ends at `time`. Returns how many were taken back before it. Local. */
int64_t hc_shock_guard_pass(hc_shock_guard *guard, double time);

#endif
