/* From a scene to the walls that absorb waves. */
#ifndef HC_ABSORPTIONS_H
#define HC_ABSORPTIONS_H

#include "setup/populate.h"
#include "sources/absorption.h"

/* What messages call one: absorption[0] at "end". */
hc_source_name hc_setup_absorption_name(const hc_scene *scene, int number);

/* `plan` is that of the same scene. Freed with hc_absorption_free. HC_BAD_INPUT: more sources than ids have
 * room for, or more samples of the start. Local. */
hc_status hc_setup_absorption(const hc_scene *scene, const hc_setup_plan *plan, hc_absorption *absorption,
                              hc_error *error);

#endif
