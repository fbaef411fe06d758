/* What the table's rows cannot say alone: defaults and constraints that involve several keys. */
#ifndef HC_RULES_H
#define HC_RULES_H

#include "given.h"
#include "scene.h"

/* Completes the filled `scene` and complains where keys contradict each other. `file_name` gives the default
 * name. */
void hc_rules_apply(hc_scene *scene, const hc_given *given, const char *file_name, hc_complaints *complaints);

/* Warns of keys that were given but that the modes chosen do not use, and sets them to their defaults. For a
 * scene without complaints. */
void hc_rules_drop_unused(hc_scene *scene, const hc_given *given, hc_complaints *warnings);

#endif
