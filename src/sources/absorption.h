/* Absorption: walls in front of which water comes in and goes out, as if it went on behind them (Carensac et
 * al. 2023, section 4.2). The water outside is at rest, or goes along with the wall's current, and stands at
 * a given height.
 *
 * Outflow: a particle that is higher, and near the wall, is taken out. Inflow: where fluid stood near the
 * wall at the start, lower than that height by half a spacing at least, are places; where there is none
 * within a distance now, and a particle's density would be below a limit, one comes in, with the mean
 * velocity of what is around it, weighted by what each gives to the density, samples of walls as well. Places
 * are as far from each other as fluid at rest, so that all of them may be filled at once. (The half spacing
 * is not in the paper: the uppermost layer has its centres there; places above it are filled again and again
 * while what comes up goes out, which stirs still water.)
 *
 * All is judged by the owner of a place on the particles before any change, in canonical order: ranks do not
 * matter. The id of what comes in counts how often its place was filled. */
#ifndef HC_ABSORPTION_H
#define HC_ABSORPTION_H

#include "arrivals.h"
#include "geometry/shape.h"
#include "places.h"
#include "state/state.h"
#include "world/world.h"

typedef struct hc_absorber {
  hc_shape shape;          /* the wall's wetted surface, where the scene puts it */
  double height;           /* m, of the water outside, against gravity from the scene's origin */
  double nearest;          /* m: no fluid may be nearer to what comes in */
  double density;          /* of the rest density: what comes in has less */
  double reach;            /* m: what is higher goes out within this distance of the wall */
  uint64_t source;         /* in ids */
  int64_t places;          /* of all ranks together */
  int64_t came, went;      /* so far, state; */
  int64_t coming, leaving; /* in the step under way */
} hc_absorber;

/* Zeroed: none. */
typedef struct hc_absorption {
  hc_absorber *absorbers;
  int count;
  double up[3];              /* unit vector against gravity */
  double (*current)[3];      /* m/s: of each wall's surface; null: none has any */
  hc_places places;          /* ids: those of what comes in next */
  hc_sample_numbers samples; /* of the start */
} hc_absorption;

void hc_absorption_free(hc_absorption *absorption);

/* Registers what is state. Local. */
void hc_absorption_register(hc_absorption *absorption, hc_state *state);

/* Makes places of the fluid as it is, at the start of a run, and counts them. Collective. */
void hc_absorption_start(hc_absorption *absorption, const hc_world *world);

/* After a restart, for what is read of them. Collective. */
void hc_absorption_count(hc_absorption *absorption, const hc_world *world);

/* Which absorber takes own particle `k` out? -1: none. Local. */
int hc_absorption_takes(const hc_absorption *absorption, const hc_world *world, int32_t k);

/* Finds where particles come in, of this rank; their velocities are not known yet. Behind hc_world_place.
 * Collective where the places must be settled. */
void hc_absorption_look(hc_absorption *absorption, hc_world *world, hc_arrivals *arrivals);

/* Gives them their velocities, and their places the next ids. Collective: if any rank has found some. */
void hc_absorption_let_in(hc_absorption *absorption, hc_world *world, hc_arrivals *arrivals);

#endif
