/* The forces that water puts on walls: what a step's changes of velocity took from the fluid, pair by pair,
 * so that it is what the particles felt. */
#ifndef HC_WALL_FORCE_H
#define HC_WALL_FORCE_H

#include "space/frame.h"
#include "sph/sweeps.h"

/* What one particle puts on one sample of a wall, or on all its samples at once. */
typedef struct hc_wall_push {
  int wall;         /* its number in the scene */
  int32_t particle; /* its pushes come one after another */
  double force[3];  /* N */
  double moment[3]; /* N m, about the particle */
  double by[3];     /* the particle's place, m, scene coordinates */
  double from[3];   /* m: from the sample, its image that is nearest, to the particle; at once: 0 */
} hc_wall_push;

/* How long after the beginning of a step of dt its pushes are where they are, s: 0, or dt where walls are
 * rigid, whose records are those of the step's end. Local. */
double hc_wall_force_later(const hc_sweep *sweep, double dt);

typedef void (*hc_wall_push_taker)(void *context, const hc_wall_push *push);

/* Shows every push on all walls of own fluid particles near a wall that is `wanted` (by its number), of the
 * step of `dt` that has just moved them: pressure, m/rho0 p V_b grad W a pair by how the walls take part;
 * viscosity (wall_drag.h), with the velocities of the step's beginning (dfsph takes those behind its
 * divergence solve: half a percent of the weight); and the momentum that contacts and friction took, shared
 * out among the samples that are near. `at_once`: what goes to one wall only comes in one push, without that
 * sharing among its samples. Lists and records are the step's. Local. */
void hc_wall_force_each(const hc_sweep *sweep, const hc_frame *frame, double dt, const bool *wanted,
                        bool at_once, hc_wall_push_taker take, void *context);

#endif
