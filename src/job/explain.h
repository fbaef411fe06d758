/* What run.log says of a step that goes another way than the one before. */
#ifndef HC_EXPLAIN_H
#define HC_EXPLAIN_H

#include "io/log.h"
#include "simulation/simulation.h"

/* The step that was last explained. */
typedef struct hc_explained {
  double dt; /* s; 0: none yet */
  hc_step_bound bound;
} hc_explained;

/* Logs why the time step is what it is when its bound has changed or it has halved or doubled since the last
 * time: the bound, and the particle behind it with its place. Collective. */
void hc_explain_time_step(hc_explained *explained, const hc_simulation *simulation, hc_log *log);

#endif
