/* Steps that are taken back, where the step control asks for it: what is remembered, and how a run returns.
 *
 * The state at the beginning of each step is remembered. A step that turns out to be a shock is taken back
 * alone, or together with the one before it, as the control has it; where that one is not remembered, as in
 * the first step of a replay, alone. The call that met the shock ends there, the next one goes on with a
 * shorter step.
 *
 * Where two steps go back, a shock in the next step would go back behind the state of now, and a checkpoint
 * of this state would not go on to the same bits. So the checkpoint of such a run holds the state at the
 * beginning of its last step: a restart does that step again, as it was, and then remembers what the run
 * remembered. It follows that a checkpoint is never of a step that is taken back later, and that a session
 * must do two steps to get on. */
#ifndef HC_ROLLBACK_H
#define HC_ROLLBACK_H

#include "halocline/error.h"
#include "state/copy.h"

typedef struct hc_rollback {
  hc_state_history history;
  int most; /* steps that go back together: 0: none, 1 or 2 */
  int back; /* steps that the last call took back, its own included; 0: its step counts */
} hc_rollback;

void hc_rollback_free(hc_rollback *rollback);

/* As a step begins: remembers the state, if it may be taken back. Local. */
void hc_rollback_remember(hc_rollback *rollback, const hc_state *state);

/* All state goes back by `most` steps, or one if no more is remembered; fluid particles are at who owned them
 * then. Returns how many, as `back` says then. What is known of shocks goes back too; nothing of that is
 * lost, because the states that are remembered are all younger than the last rollback. Local. */
int hc_rollback_return(hc_rollback *rollback, hc_state *state);

/* Around the writing of a checkpoint: puts the state there that it must hold, and the present one again,
 * which `now` keeps meanwhile (zeroed; freed by the second). Of boundary particles late_compression alone
 * is touched. False if there is nothing to do. Local. */
bool hc_rollback_show_resumable(hc_rollback *rollback, hc_state *state, hc_state_copy *now);
bool hc_rollback_show_now(hc_state *state, hc_state_copy *now);

#endif
