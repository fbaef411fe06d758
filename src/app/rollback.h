/* Steps that are taken back: what the adaptive time step (stepping/adaptive.h) does to a run.
 *
 * The state at the beginning of each step is remembered. A step that turns out to be a shock is taken back
 * together with the one before it; where that is not remembered, as in the first step of a replay, it is
 * taken back alone. The call that met the shock ends there, the next one goes on with a shorter step.
 *
 * Since a shock in the next step would go back behind the state of now, a checkpoint of this state would not
 * go on to the same bits. So the checkpoint of a run with adaptive steps holds the state at the beginning of
 * its last step: a restart does that step again, as it was, and then remembers what the run remembered. It
 * follows that a checkpoint is never of a step that is taken back later, and that a session must do two steps
 * to get on. */
#ifndef HC_ROLLBACK_H
#define HC_ROLLBACK_H

#include "halocline/error.h"
#include "state/copy.h"
#include "stepping/adaptive.h"

typedef struct hc_simulation hc_simulation;

typedef struct hc_rollback {
  hc_state_history history;
  hc_shock_guard guard;
  int64_t forced; /* shocks by the test hook so far */
  int back;       /* steps that the last call took back, its own included; 0: its step counts */
  int64_t before; /* steps that were taken back since the last step that counts, seen from this one */
  double v_max, force_max; /* m/s, m/s2: of the step that was the shock; 0 if it diverged */
} hc_rollback;

/* Does the scene's time step ever go back? */
bool hc_rollback_is_on(const hc_simulation *simulation);

/* Registers what is state. Local. */
void hc_rollback_register(hc_simulation *simulation);

/* As a step begins: remembers. Local. */
void hc_rollback_remember(hc_simulation *simulation);

/* The next step's length after a rollback, s; 0: to be chosen as ever. Local. */
double hc_rollback_next(const hc_simulation *simulation);

/* Has the run gone back as often as it may for one shock? */
bool hc_rollback_gave_up(const hc_simulation *simulation);

/* After the solver's step of dt, with its report and perhaps a failure in `error`; `before`: the report of
 * the step before. True if it was a shock: then the run is where it was, `error` is taken back, and the world
 * updated. Collective; the same on every rank. */
bool hc_rollback_if_shock(hc_simulation *simulation, double dt, const hc_step_report *before,
                          hc_error *error);

/* A step counts: simulation->time is its end. Local. */
void hc_rollback_pass(hc_simulation *simulation);

/* Around the writing of a checkpoint: shows the state that it must hold, and the present one again, which
 * `now` keeps meanwhile (zeroed; freed by the second). Moving walls follow, other boundary particles stand
 * still. Collective. */
void hc_rollback_show_resumable(hc_simulation *simulation, hc_state_copy *now);
void hc_rollback_show_now(hc_simulation *simulation, hc_state_copy *now);

#endif
