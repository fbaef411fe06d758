/* The step controls as scenes choose them: one row of a table each. All local. */
#ifndef HC_SETUP_CONTROLS_H
#define HC_SETUP_CONTROLS_H

#include "scene/findings.h"
#include "scene/scene.h"
#include "stepping/control.h"

const hc_control_ops *hc_setup_control_ops(const hc_scene *scene);

/* Defaults that hang on the control, and what of its keys contradicts itself. */
void hc_setup_control_complete(hc_scene *scene, hc_findings *findings);

/* A floor above all steps; once blocks are known to be sound. */
void hc_setup_control_review(const hc_scene *scene, hc_findings *findings);

/* The scene's word for the control of that name; false if there is none. */
bool hc_setup_control_named(const char *name, hc_time_control *control);

/* How many steps its run takes back at once: as its control does, or more where its solver needs it. */
int hc_setup_goes_back(const hc_scene *scene);

/* The control of a scene's run; freed with hc_control_free. */
hc_control hc_setup_control(const hc_scene *scene);

/* No step of its run is longer, s: how far ahead what is prescribed is looked at. */
double hc_setup_control_longest(const hc_scene *scene);

/* The time step with which what forgets its speed comes to rest, s; and that with which the start of a scene
 * settles, 0 if it does not. */
double hc_setup_calm_step(const hc_scene *scene);
double hc_setup_settle_step(const hc_scene *scene);

#endif
