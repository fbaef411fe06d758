/* Does a scene make sense as geometry? What no key alone can say. */
#ifndef HC_REVIEW_H
#define HC_REVIEW_H

#include "scene/findings.h"
#include "scene/scene.h"

/* Errors: no fluid at all; what hc_setup_frame and the sources refuse; a block too small for a particle,
 * inside an obstacle, reaching into a wall (closer than half a spacing to where its samples lie) or outside
 * of all containers, if there are any (a container goes on beyond its open faces, a plane is one for all that
 * is in front of it); blocks that overlap; gauges away from all fluid and walls, or from their wall.
 * Warnings: boxes of fluid that are no
 * whole number of spacings long, fluid at an open side or bottom of its container with no other wall behind
 * it. One finding for each pair, with a place; all in one go, as far as what is wrong lets it look. The cost
 * is that of the surfaces, not of the particles. Local: the same on every rank. For hc_scene_limits.check. */
void hc_setup_review(const hc_scene *scene, hc_findings *findings);

#endif
