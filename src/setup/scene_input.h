/* A scene that all ranks read alike, from rank 0's file or text. */
#ifndef HC_SCENE_INPUT_H
#define HC_SCENE_INPUT_H

#include "comm/comm.h"
#include "particles/particles.h"
#include "scene/reader.h"
#include "setup/rest_states.h"

/* Where a scene comes from; what rank 0 says counts, other ranks may leave all of it zero. */
typedef struct hc_scene_input {
  const char *name;             /* the file, or what messages call the text */
  const char *text;             /* null: the file is read */
  const char *const *overrides; /* "key=value", over the file in their order */
  int override_count;
  hc_rest_reader read_rest; /* on every rank; null: there must be no rest states */
} hc_scene_input;

/* What the reader cannot know: names that output.snapshots.fields may hold, and how a scene is reviewed
 * and its files are loaded.
 * `names` has room for HC_FIELD_COUNT; `files` (null: this process alone, no rest states) stays the caller's.
 * Local. */
hc_scene_limits hc_scene_input_limits(const char **names, hc_scene_files *files);

/* Rank 0 loads the input, every rank reads it. Collective; HC_BAD_INPUT is agreed, the scene then empty.
 * Warnings come on rank 0 only; `warnings` may be null. */
hc_status hc_scene_input_read(hc_comm *comm, const hc_scene_input *input, hc_scene *scene,
                              hc_warnings *warnings, hc_error *error);

#endif
