/* A step that fails: the message that names the particle, its place and the likely cause. And faults on
 * demand, for tests. */
#ifndef HC_FAILURE_H
#define HC_FAILURE_H

#include "simulation.h"

/* Adds to `error`, which holds what happened, when, where and why: step, time, place, speed, density,
 * neighbours, likely cause, from what the failed step of length dt left. `before` is the report of the step
 * before it. Collective; the same text on every rank and on any number of them. */
void hc_failure_explain(hc_simulation *simulation, double dt, const hc_step_report *before, hc_error *error);

/* Makes the faults that the scene asks for at this step (keys faults.*); hc_world_update must follow.
 * Collective. */
void hc_failure_inject(hc_simulation *simulation);

#endif
