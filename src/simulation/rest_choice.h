/* Which particles of a rest state stay where it meets walls, bodies and fluid that is there: the selection of
 * Carensac et al. 2023, section 3.1 and algorithm 1.
 *
 * Candidates are its particles with any of these in their support. In passes, each on the densities before
 * it, those go that are denser than a threshold, which falls until the mean density of those that are left is
 * the target. Nothing moves meanwhile. Readings: the threshold falls; the mean is one; a particle is
 * protected by a denser neighbour alone (section 3.1.1; the algorithm says any candidate); and the threshold
 * falls by half of what it is above the target at most, so that no pass takes all (not in the paper). */
#ifndef HC_REST_CHOICE_H
#define HC_REST_CHOICE_H

#include "relax.h"
#include "scene/scene.h"

/* What is near enough to those who move to have a say while they come to rest. */
typedef enum hc_rest_part {
  HC_REST_GONE,     /* chosen to go, or air */
  HC_REST_AWAY,     /* farther */
  HC_REST_BEHIND,   /* in the support of what is beside */
  HC_REST_BESIDE,   /* in the support of a candidate */
  HC_REST_CANDIDATE /* moves */
} hc_rest_part;

/* Which particles have just come. */
typedef struct hc_rest_fresh {
  const bool *source; /* those of blocks, by number, */
  int sources;
  uint64_t from, to; /* and those whose ids are in [from, to) */
  bool fitted;       /* they fit walls and bodies: only beside fluid that is here they may have to go */
} hc_rest_fresh;

typedef struct hc_rest_chosen {
  int64_t loaded, air;        /* particles of rest states, and of the air around them */
  int64_t before, candidates; /* candidates before the first pass, and those left */
  int iterations;             /* passes */
  double mean, deviation;     /* of the candidates' densities from the target, of the rest density */
} hc_rest_chosen;

/* Says of every own fluid particle which part it has. `part` has room for all of them. Collective. Before:
 * hc_world_place. After: lists are of few, and scalars of place and motion of the fluid are no more what
 * steps make of them. */
void hc_rest_choose(const hc_resting *resting, const hc_scene_rest *rules, const hc_rest_fresh *fresh,
                    hc_rest_part *part, hc_rest_chosen *chosen);

#endif
