/* What ends a run, found in the step it happens and by the particle it began with. Own particles are looked
 * at as a step begins, behind the density sweep, and before anything moves, because a value that is no number
 * spreads by a support radius in every iteration, and maxima over particles do not see it. */
#ifndef HC_FAULT_H
#define HC_FAULT_H

#include "comm/tally.h"
#include "halocline/error.h"
#include "world/world.h"

/* In the order in which a step can find them. */
typedef enum hc_fault_kind {
  HC_FAULT_NONE,
  HC_FAULT_TIME_STEP,   /* the time step fell under its floor */
  HC_FAULT_START_VALUE, /* a velocity or pressure multiplier is no number as the step begins */
  HC_FAULT_START_SPEED, /* a particle is too fast as the step begins */
  HC_FAULT_CROWDED,     /* far too many particles lie in one cell */
  HC_FAULT_DENSITY,     /* a density is no number */
  HC_FAULT_OWN_STEP,    /* a particle's own time step fell under the floor */
  HC_FAULT_VALUE,       /* a velocity or pressure is no number at the end of the step */
  HC_FAULT_POSITION,    /* a position is none */
  HC_FAULT_SPEED,       /* a particle would move by more than a support radius */
  HC_FAULT_ERROR,       /* density errors are no numbers, or beyond all bounds: the fastest particle */
  HC_FAULT_LEFT         /* a particle is outside the world's limits */
} hc_fault_kind;

/* The earliest kind; of that the largest value, if it has one; of these the smallest id. */
typedef struct hc_fault {
  hc_fault_kind kind;
  double value; /* speed, m/s; one over the own step, 1/s; 0 for other kinds */
  uint64_t id;  /* of the fluid particle */
} hc_fault;

/* Takes note of a fault if it comes before what is noted. Local. */
void hc_fault_note(hc_fault *fault, hc_fault_kind kind, double value, uint64_t id);

/* Look at the own particles: as a step of dt begins; behind the density sweep; before the move. Local. */
void hc_fault_watch_start(const hc_world *world, double dt, hc_fault *fault);
void hc_fault_watch_density(const hc_world *world, hc_fault *fault);
void hc_fault_watch_end(const hc_world *world, double dt, hc_fault *fault);

/* Takes note of the fastest particle, where something is known to be wrong but not where. Local. */
void hc_fault_watch_fastest(const hc_world *world, hc_fault_kind kind, hc_fault *fault);

/* Makes the first fault of all ranks everybody's, and reduces what else is in the tally with it. Collective:
 * one reduction where there is none. HC_FAILED with what happened to which particle. */
hc_status hc_fault_agree(hc_comm *comm, double dt, hc_tally *tally, hc_fault *fault, hc_error *error);

#endif
