/* Births and deaths of fluid particles: what leaves the world (setup/limits.h) and is taken out, what
 * emitters bring in, what walls absorb and let in. All are judged on the particles as they are placed before
 * any change, then applied together. */
#ifndef HC_POPULATION_H
#define HC_POPULATION_H

#include "setup/limits.h"
#include "solver/fault.h"
#include "sources/absorption.h"
#include "sources/emitters.h"

enum { HC_LEAVING_NAMED = 10 };

/* Where a particle was. */
typedef struct hc_departure {
  uint64_t id;
  double at[3]; /* m */
} hc_departure;

/* Those that were taken out together; the same on every rank. */
typedef struct hc_departures {
  int64_t count;
  int named; /* the first of them, by id */
  hc_departure first[HC_LEAVING_NAMED];
} hc_departures;

typedef struct hc_population {
  hc_limits limits, at_start; /* of the world: now, and before a window went along */
  bool remove;                /* what leaves is taken out; else it is a fault */
  int64_t beyond;             /* particles on all ranks that are beyond the limits at beyond_time, */
  double beyond_time;
  bool counted; /* if this is set */
  hc_emitters emitters;
  hc_absorption absorption;
  /* as the last step began: */
  hc_departures departures;
  int64_t emitted, blocked; /* particles that emitters brought in, and left out */
  int64_t came, went;       /* that walls let in, and took out */
} hc_population;

void hc_population_free(hc_population *population);

/* Registers what is state. Local. */
void hc_population_register(hc_population *population, hc_state *state);

/* Limits and places go along with a window, by units. Local. */
void hc_population_go(hc_population *population, const hc_frame *frame, const int64_t shift[3]);

/* The largest speed that comes in between a time and `ahead` later, m/s. Local. */
double hc_population_speed(const hc_population *population, double time, double ahead);

/* Lets leave and come in what is due at a time, behind hc_world_place; `absorb`: walls may, too. True, on
 * every rank, if any particle did: then place the world again; lists must not have been built. Collective:
 * some reductions where a layer is due, one where walls absorb, and one where leaving is looked for and has
 * not been counted for this time. */
bool hc_population_change(hc_population *population, hc_world *world, double time, bool absorb);

/* Behind the step that leads to `time`: takes note of own particles beyond the limits, as faults, or in the
 * tally where they are to be removed. Local. */
void hc_population_watch(hc_population *population, const hc_world *world, double time, hc_fault *fault,
                         hc_tally *tally);

#endif
