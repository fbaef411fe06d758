/* What a run takes of memory, told beforehand from what its structures hold for a particle. Local. */
#ifndef HC_FOOTPRINT_H
#define HC_FOOTPRINT_H

#include "scene/scene.h"
#include "setup/populate.h"

/* Bytes of the program with its libraries, of a rank: what single ranks took. */
enum { HC_FOOTPRINT_PROGRAM = 26 << 20 };

/* Bytes of a particle, its lists and copies included: fluid, boundary, ghost. */
double hc_footprint_fluid(const hc_scene *scene);
double hc_footprint_wall(const hc_scene *scene);
double hc_footprint_ghost(const hc_scene *scene);

/* Bytes of a particle in a checkpoint. */
double hc_footprint_fluid_state(const hc_scene *scene);
double hc_footprint_wall_state(const hc_scene *scene);

/* Bytes of the place that a window remembers for each particle of the start, in memory and in a checkpoint;
 * counted in hc_footprint_fluid. */
double hc_footprint_places(const hc_scene *scene);

/* Bytes that each of so many ranks needs at least. */
double hc_footprint_least(const hc_scene *scene, const hc_setup_plan *plan, int64_t ranks);

#endif
