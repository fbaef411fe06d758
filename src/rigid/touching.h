/* Samples of bodies that touch walls or each other.
 *
 * A sample stands for the volume V = factor/sum W over its own wall's samples (Akinci et al. 2012). Where a
 * body comes within a support radius of another thing, what both have there would count twice; so both count
 * less: V/(1 + V sum W/factor), the sum over samples of the other things, which is factor over the sum of
 * all. Only what sweeps see changes, the volumes of the state stay. The list of who is near is kept for
 * contacts. */
#ifndef HC_TOUCHING_H
#define HC_TOUCHING_H

#include "world/world.h"

/* Own samples of a store that may touch something, ascending, each a row of the list of what is around. */
typedef struct hc_touching_side {
  hc_neighbors list;
  int32_t *index;
  int32_t count;
  uint64_t *marks; /* of each brick, a bit for each cell with such samples */
  size_t index_room, marks_room;
} hc_touching_side;

typedef struct hc_touching {
  hc_touching_side moving; /* -> all samples */
  hc_touching_side still;  /* -> moving samples */
  int64_t any; /* there are such moving samples here; once the solver has asked all ranks, on any */
} hc_touching;

void hc_touching_init(hc_touching *touching);
void hc_touching_free(hc_touching *touching);

/* Once all walls are placed: finds who is near, and what volumes count. `first`: the number of the first
 * body's surface. Collective. */
void hc_touching_refresh(hc_touching *touching, hc_world *world, int first);

#endif
