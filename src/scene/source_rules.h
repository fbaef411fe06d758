/* Rules between the keys of what moves and flows in: moving walls, emitters, bodies. Local. */
#ifndef HC_SOURCE_RULES_H
#define HC_SOURCE_RULES_H

#include "complaints.h"
#include "given.h"
#include "scene.h"

/* What the keys of one wall's motion, of one emitter, must have to do with each other. */
void hc_source_rules_motion(const hc_wall *wall, const hc_given *given, hc_complaints *complaints);
/* The same for a table that has come from a file. */
void hc_source_rules_loaded(const hc_wall *wall, const hc_given *given, hc_complaints *complaints);
void hc_source_rules_emitter(const hc_scene_emitter *emitter, const hc_given *given,
                             hc_complaints *complaints);

/* Of one body but its shape. */
void hc_source_rules_body(const hc_scene_body *body, const hc_given *given, hc_complaints *complaints);

#endif
