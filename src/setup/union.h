/* Walls that touch, cross or coincide, made one: no sample closer than half a spacing to one of an earlier
 * wall.
 *
 * Method: walls in the scene's order; a sample goes if a sample of an earlier wall that was kept lies closer
 * than half a spacing. What went thus has a neighbour at its place, so surfaces stay as closed as they were.
 * Walls that move keep all of theirs, and take none: what they leave must not have a hole.
 * Samples inside another wall's solid stay: they do no harm. Only samples near the surface of another wall
 * are looked at one by one (trace.h), and only those of earlier walls are stored, one wall's at a time.
 *
 * Every rank comes to the same result. Of a surface it looks at the samples that it holds, and the ranks tell
 * each other; what comes near to another wall, all hold for a moment. */
#ifndef HC_UNION_H
#define HC_UNION_H

#include "comm/comm.h"
#include "setup/source.h"

/* Fills `gaps` of all the walls, which must be empty. Collective; `comm` null: this process alone. */
void hc_union_drop(hc_comm *comm, const hc_frame *frame, hc_setup_source *walls, int count);

#endif
