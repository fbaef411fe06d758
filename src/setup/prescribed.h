/* From a scene to what moves and flows in as it prescribes: the motions of walls, the emitters. */
#ifndef HC_PRESCRIBED_H
#define HC_PRESCRIBED_H

#include "rigid/movers.h"
#include "setup/populate.h"
#include "sources/emitters.h"

/* From a point to the farthest corner around a source's samples, m. Local. */
double hc_prescribed_reach(const hc_frame *frame, const hc_setup_source *source, const double centre[3]);

/* The walls that move, and the surfaces of bodies; `plan` is that of the same scene. Freed with
 * hc_movers_free. Local. */
hc_movers hc_prescribed_movers_make(const hc_scene *scene, const hc_setup_plan *plan);

/* Widens a box of positions, m, to where the motion brings it until a time. Local. */
void hc_prescribed_sweep(const hc_motion *motion, double until, double low[3], double high[3]);

/* The largest speed of a wall or of what comes in at a time or `ahead` later, m/s. Local. */
double hc_prescribed_speed(const hc_movers *motions, const hc_emitters *emitters, double time, double ahead);

/* What messages call an emitter: fluid.emitters[2]. */
hc_source_name hc_prescribed_emitter_name(int number);

/* The emitters of a scene; freed with hc_emitters_free, also after an error. HC_BAD_INPUT: an opening too
 * small for a particle or far too large, or too far away; more particles until the end than ids can name.
 * Local. */
hc_status hc_prescribed_emitters_make(const hc_scene *scene, const hc_frame *frame, hc_emitters *emitters,
                                      hc_error *error);

/* The smallest box around an emitter's samples, as its layers come in, m. Local. */
void hc_prescribed_emitter_bounds(const hc_emitter *emitter, double low[3], double high[3]);

#endif
