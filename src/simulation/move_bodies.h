/* How bodies go on behind a step's move. */
#ifndef HC_MOVE_BODIES_H
#define HC_MOVE_BODIES_H

#include "simulation.h"

/* By what the fluid has pushed them with (simulation->loads, reduced) and all else that pulls, but not into
 * walls and each other. HC_FAILED, the same on every rank, for one that leaves the world or is moved beyond
 * all places. Collective. */
hc_status hc_simulation_move_bodies(hc_simulation *simulation, double dt, hc_error *error);

#endif
