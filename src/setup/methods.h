/* Which of a scene's methods go together, and what they make of keys that were not given. Local. */
#ifndef HC_SETUP_METHODS_H
#define HC_SETUP_METHODS_H

#include "scene/findings.h"
#include "scene/scene.h"

/* For hc_scene_limits.complete. */
void hc_setup_complete(hc_scene *scene, hc_findings *findings);

#endif
