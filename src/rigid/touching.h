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

typedef struct hc_touching {
  hc_neighbors list; /* own moving samples -> all samples */
  hc_neighbors near; /* chosen samples that stand still -> moving ones */
  int32_t *index;    /* those chosen, ascending */
  int32_t count;
  size_t room;
} hc_touching;

void hc_touching_init(hc_touching *touching);
void hc_touching_free(hc_touching *touching);

/* Once all walls are placed: finds who is near, and what volumes count. `first`: the number of the first
 * body's surface. Collective. */
void hc_touching_refresh(hc_touching *touching, hc_world *world, int first);

#endif
