/* From a scene to its rigid bodies. */
#ifndef HC_SETUP_BODIES_H
#define HC_SETUP_BODIES_H

#include "rigid/bodies.h"
#include "scene/findings.h"
#include "setup/populate.h"

/* Completes what follows from shapes once they are made: where bodies start, where pulls and moorings hold
 * them, the lengths of moorings. Local. */
void hc_setup_bodies_complete(hc_scene *scene, hc_findings *findings);

/* Complains of bodies without a volume or too thin for samples, of those that start in a wall, in one
 * another, or outside of the containers. Local. */
void hc_setup_bodies_review(const hc_scene *scene, const hc_frame *frame, hc_findings *findings);

/* The bodies of a scene as they start; `plan` is that of the same scene, the frame must outlive them. Freed
 * with hc_bodies_free. Local. */
hc_bodies hc_setup_bodies_make(const hc_scene *scene, const hc_setup_plan *plan, const hc_frame *frame);

#endif
