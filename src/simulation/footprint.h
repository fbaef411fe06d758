/* What a run takes of memory, told beforehand: from what its structures hold for a particle, and what single
 * ranks with fluid at rest took beyond that. Local. */
#ifndef HC_FOOTPRINT_H
#define HC_FOOTPRINT_H

#include "scene/scene.h"
#include "setup/populate.h"

/* Bytes: the program with its libraries; of a fluid particle, its neighbours and copies included; of a
 * boundary particle; of a ghost. */
enum { HC_FOOTPRINT_PROGRAM = 34 << 20, HC_FOOTPRINT_WALL = 198, HC_FOOTPRINT_GHOST = 80 };
double hc_footprint_fluid(const hc_scene *scene);

/* Bytes that each of so many ranks needs at least. */
double hc_footprint_least(const hc_scene *scene, const hc_setup_plan *plan, int64_t ranks);

#endif
