/* How bodies yield to the fluid, while a solver looks for pressures and behind its step.
 *
 * Within: what a pressure pushes a particle with, B = sum w_b V_b grad W, pushes the bodies the other way:
 * with G_k and T_k the parts of B, and of its moment about the centre of mass, that the samples of body k
 * make, a multiplier kappa takes weight kappa G_k from the particle's velocity and gives the body the impulse
 * m weight kappa (G_k, T_k). What the body then moves by changes the particle's density by G_k.v + T_k.spin:
 * the same numbers, so that the whole stays symmetric (Akinci et al. 2012 couple explicitly, which is
 * unstable for bodies lighter than about half the fluid). The parts are found once a step.
 *
 * Behind: a body's momentum changes by what its particles really felt, pair by pair (wall_force.h), friction
 * and contact included. What that is more than the solver reckoned with, contacts too, the next step expects
 * (hc_body.held).
 *
 * Impulses are added up as integers, so that they are the same on any number of ranks. */
#ifndef HC_YIELD_H
#define HC_YIELD_H

#include "rigid/bodies.h"

#include "comm/tally.h"

/* A particle next to a body. */
typedef struct hc_yield_pair {
  int32_t particle, body;
  double linear[3], angular[3]; /* G, 1/m; T, 1 */
} hc_yield_pair;

/* Sums of impulses under way, of this rank, then of all: six a body, in units of its mass, the speed of a
 * support radius a step, and its reach. */
typedef struct hc_impulses {
  int64_t *sum, broken; /* broken: some were no numbers, or beyond all measure */
  double speed;         /* m/s of a unit */
  int bodies;
} hc_impulses;

/* A body without the impulse of pressures that are tried: its velocity, and what it has got otherwise. */
typedef struct hc_yield_base {
  hc_twist shown, pushed;
} hc_yield_base;

typedef struct hc_yield {
  hc_world *world;
  hc_bodies *bodies; /* null or none: nothing yields, all functions do nothing */
  double dt;
  hc_yield_pair *pairs; /* by ascending particle */
  size_t count, room;
  double *softness;    /* of each body: the trace of what its yielding adds to the pressure's matrix, 1/m2 */
  hc_yield_base *base; /* hc_yield_retry: of each body */
  hc_impulses impulses;
} hc_yield;

/* As a step of dt begins: finds who is next to what. Freed with hc_yield_end. Local. */
void hc_yield_begin(hc_yield *yield, hc_world *world, hc_bodies *bodies, double dt);
void hc_yield_end(hc_yield *yield);

/* Finds how soft bodies are; and makes the factors alpha of particles next to them smaller, as a diagonal
 * step must take into account how far these yield together. Collective; soften: local. */
void hc_yield_measure(hc_yield *yield);
void hc_yield_soften(hc_yield *yield);

/* Gravity, pulls and what is expected of contacts act on the velocities shown. Local. */
void hc_yield_accelerate(hc_yield *yield);

/* Adds up what the multipliers in place.scalar would push bodies with; once the tally, or whatever took it
 * over, is reduced, lets them yield: wall rates of particles next to them follow. Local. */
void hc_yield_note(hc_yield *yield, double weight, hc_tally *tally);
void hc_yield_act(hc_yield *yield);

/* In place of act where the multipliers are whole each time, not what is added to them: the velocity shown
 * goes towards what it would be with this impulse alone, the slower the softer the body is beside `diagonal`,
 * 1/m2, of the pressure's matrix. The first call finds the velocities without an impulse. Local. */
void hc_yield_retry(hc_yield *yield, double diagonal);

/* Gives samples the velocities shown, as sweeps see them, ghosts too. Collective. */
void hc_yield_show(hc_yield *yield);

/* Behind a step of dt: notes in a tally what the fluid pushed bodies with in it, as wall_force.h sees it; and
 * once that is reduced, adds it and all other forces to the bodies' momenta. Local; take: HC_FAILED, the same
 * on every rank, if a force is beyond all measure. */
void hc_yield_note_loads(hc_impulses *loads, const hc_world *world, hc_bodies *bodies, double dt,
                         hc_tally *tally);
hc_status hc_yield_take_loads(hc_impulses *loads, hc_bodies *bodies, double dt, hc_error *error);
void hc_impulses_free(hc_impulses *impulses);

#endif
