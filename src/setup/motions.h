/* Tables of motion in files of their own, loaded with the scene that names them. */
#ifndef HC_SETUP_MOTIONS_H
#define HC_SETUP_MOTIONS_H

#include "scene/findings.h"
#include "scene/scene.h"

/* Reads the tables that walls of the scene file `name` keep in files, and holds them against the rules of
 * what stands in a scene. `context`: an hc_comm, whose rank 0 reads for all, collective; null: alone. */
void hc_setup_motions_load(void *context, hc_scene *scene, const char *name, hc_findings *findings);

#endif
