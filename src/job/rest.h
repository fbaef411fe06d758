/* `halocline rest`: a relaxed fluid made and saved, for scenes to fill shapes with. */
#ifndef HC_JOB_REST_H
#define HC_JOB_REST_H

#include "comm/comm.h"
#include "scene/scene.h"

#include <stdbool.h>

/* Lets the fluid of a scene come to rest by damped steps, without gravity, and writes it to `path`; a
 * lattice is put into disorder first, half of it where it is too much for the solver. Where it finds no rest,
 * because the disorder makes it denser than a lattice of as many particles, some go, and it is tried again.
 * `quiet`: says nothing. Collective; errors are agreed: HC_FAILED, if it finds no rest, is denser than rest
 * or diverges; HC_BAD_INPUT, if the scene has bodies or emitters, no blocks, or any that come later. */
hc_status hc_job_rest(hc_comm *comm, const hc_scene *scene, const char *path, bool quiet, hc_error *error);

#endif
