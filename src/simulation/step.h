/* A step of a run. */
#ifndef HC_STEP_H
#define HC_STEP_H

#include "simulation.h"

/* One step. Particles that have left the world are taken out first, if the scene says so. With adaptive steps
 * it may take a step or two back instead: rollback.back says how many, and step, time and all state are those
 * of then. Collective.
 * HC_FAILED (agreed) if the simulation diverged or a particle left the world: the message names the particle,
 * its place and the likely cause, report.fault the fault; nothing but a snapshot of the moment makes sense
 * afterwards. */
hc_status hc_simulation_step(hc_simulation *simulation, hc_error *error);

#endif
