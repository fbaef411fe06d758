/* What those who read a scene are told from outside. */
#ifndef HC_SCENE_LIMITS_H
#define HC_SCENE_LIMITS_H

#include "findings.h"
#include "scene.h"

/* What scene/ cannot know. The arrays stay the caller's. */
typedef struct hc_scene_limits {
  const char *const *snapshot_fields; /* allowed in output.snapshots.fields */
  int snapshot_field_count;
  /* Completes a scene whose keys have been read with what its methods make of those that were not given, and
   * complains of methods and keys that do not go together, such as hc_setup_complete; null: nobody. Local. */
  void (*complete)(hc_scene *scene, hc_findings *findings);
  /* Looks at a scene whose keys are all in order, such as hc_setup_review; null: nobody. Local. */
  void (*check)(const hc_scene *scene, hc_findings *findings);
  /* Before that, loads the files that such a scene names, from the folder of the scene file `name`, such as
   * hc_setup_meshes_load; null: nobody. Collective if its context says so. */
  void (*load)(void *context, hc_scene *scene, const char *name, hc_findings *findings);
  void *context;
} hc_scene_limits;

#endif
