/* What artificial and laminar viscosity do between a particle and the samples of walls, as in the sweeps
 * (sph/forces_isa.c, weak_isa.c), pair by pair: for the forces that walls feel. */
#ifndef HC_WALL_DRAG_H
#define HC_WALL_DRAG_H

#include "sph/sweeps.h"

/* A particle that drags at walls. */
typedef struct hc_dragger {
  double factor;      /* kg/(m3 s), but for what is the pair's; 0: no drag */
  double velocity[3]; /* at the step's beginning, m/s */
  double normal[3];   /* of the wall by the volumes around; 0: there are none */
  double distance;    /* from walls of frozen fluid, support radii */
} hc_dragger;

/* The particle, behind the step of `dt` that has just moved it. Local. */
hc_dragger hc_wall_drag_by(const hc_sweep *sweep, int32_t i, double dt);

/* The force on sample b, N; d from there to the particle, and its length q, in support radii. Local. */
void hc_wall_drag_on(const hc_sweep *sweep, const hc_dragger *dragger, int32_t b, const double d[3], double q,
                     double force[3]);

#endif
