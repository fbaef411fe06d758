/* The map of a division by METIS: its bricks, and what is to become of the empty ones around them. Local. */
#ifndef HC_FRINGE_H
#define HC_FRINGE_H

#include "graph.h"

/* Adds the intervals of the occupied bricks, brick k owned by part[k], to a map just started in Morton order.
 * Empty bricks near fluid go to the owner of the nearest brick: else a free surface would lie beside other
 * ranks' cells, which need ghosts, and a front would run into them. */
void hc_fringe_fill(hc_map *map, const hc_bricks *bricks, const hc_graph *graph, const int32_t *part);

#endif
