/* Particles that leave the world: beyond the limits that the scene has (setup/limits.h). */
#ifndef HC_LEAVING_H
#define HC_LEAVING_H

#include "comm/comm.h"
#include "setup/limits.h"
#include "solver/fault.h"

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

/* Takes note of own particles beyond the limits as faults. Local. */
void hc_leaving_watch(const hc_world *world, const hc_limits *limits, hc_fault *fault);

/* Takes them out instead; hc_world_update must follow. Collective: one reduction where there are none. */
void hc_leaving_remove(hc_world *world, const hc_limits *limits, hc_departures *departures);

#endif
