/* From a scene to YAML text. */
#ifndef HC_WRITER_H
#define HC_WRITER_H

#include "params.h"
#include "scene.h"

/* The scene with every default filled in, but without keys that its modes do not use; reading the text gives
 * the same scene, bit for bit. The caller's to free (hc_free). Local. */
char *hc_scene_text(const hc_scene *scene);

/* One key's value as it stands in the text, for keys that are no list of maps; and whether the scene has it
 * at all, in the modes that it chooses. For compare.c. Local. */
void hc_scene_write_value(FILE *out, const hc_param *param, const void *owner);
bool hc_scene_writes(const hc_param_table *table, const hc_param *param, const void *owner);

#endif
