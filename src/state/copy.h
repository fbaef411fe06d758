/* Copies of a state in memory, to go back to: the state a step or two ago, bit for bit.
 *
 * A copy holds the items and the own particles of this rank as they were. Restoring brings them back to the
 * rank that remembered them, whoever owns their bricks by then: migrate and sort afterwards
 * (hc_world_update), and the canonical order makes the state the same to the bit, whatever migration or
 * rebalance came in between. Particles that stand still between remember and restore need not be copied:
 * leave their kind out. All local. */
#ifndef HC_STATE_COPY_H
#define HC_STATE_COPY_H

#include "state.h"

/* Zeroed: empty. Memory is kept from one use to the next. */
typedef struct hc_state_copy {
  bool full;
  unsigned kinds;
  int32_t own[HC_STATE_MOST_STORES];
  char *bytes;
  size_t used, capacity;
} hc_state_copy;

void hc_state_copy_free(hc_state_copy *copy);

/* Overwrites the copy with the state as it is, particles of `kinds` (hc_state_names). */
void hc_state_remember(hc_state_copy *copy, const hc_state *state, unsigned kinds);

/* Puts the copy's state back. The same items must be registered as when it was remembered. Ghosts and all
 * that is not state are gone. The copy stays full. */
void hc_state_restore(const hc_state_copy *copy, hc_state *state);

/* The last states, the newest at 0. */
enum { HC_STATE_HISTORY = 2 };

typedef struct hc_state_history {
  hc_state_copy copies[HC_STATE_HISTORY];
  int newest, count;
} hc_state_history;

void hc_state_history_free(hc_state_history *history);

/* Remembers the state as the newest; the oldest is forgotten once there are HC_STATE_HISTORY. */
void hc_state_history_push(hc_state_history *history, const hc_state *state, unsigned kinds);

/* Forgets all; the next push takes the memory of the one it replaces. */
void hc_state_history_forget(hc_state_history *history);

/* The state remembered `back` pushes before the newest (0: the newest itself); null if there is none so old.
 * It stays the history's. */
const hc_state_copy *hc_state_history_get(const hc_state_history *history, int back);

/* Goes back to that state, and forgets it and those after it: who goes on from there pushes it anew. Returns
 * false, changing nothing, if there is none so old. */
bool hc_state_history_return(hc_state_history *history, hc_state *state, int back);

#endif
