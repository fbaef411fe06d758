/* Blocks of rest states that come in the midst of a run: into what room walls, bodies and the fluid leave
 * then, or in place of the fluid there. */
#ifndef HC_REFILL_H
#define HC_REFILL_H

#include "simulation.h"

/* Lets those come that are due at simulation->time. If any did (simulation->came) the world must be placed
 * again. Collective; HC_BAD_INPUT or HC_FAILED, agreed. Before: hc_world_place; lists not built yet. */
hc_status hc_simulation_refill(hc_simulation *simulation, hc_error *error);

#endif
