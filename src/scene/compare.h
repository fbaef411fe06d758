/* How two scenes differ, key by key: what decides whether a run may go on under a changed scene. */
#ifndef HC_COMPARE_H
#define HC_COMPARE_H

#include "scene.h"

/* Keys that differ, as text: "end_time: was 2, is 3", joined by "; ". */
typedef struct hc_scene_changes {
  char *harmless, *refused; /* hc_free both; empty: none */
} hc_scene_changes;

/* Compares what is written of the scenes (writer.h): `before` and `now`. Harmless are keys that the table
 * marks as such, because the state of a run does not depend on them: its end, its output, the division among
 * ranks. Local. */
hc_scene_changes hc_scene_compare(const hc_scene *before, const hc_scene *now);

void hc_scene_changes_free(hc_scene_changes *changes);

#endif
