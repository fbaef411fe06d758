/* From YAML text to a scene.
 *
 * All functions are local: rank 0 loads the file's bytes (hc_scene_load), broadcasts them, and every rank
 * reads the same text. The result depends on the arguments alone, not on the locale or the number of ranks.
 */
#ifndef HC_READER_H
#define HC_READER_H

#include "scene.h"
#include "scene_limits.h"

#include "base/warnings.h"
#include "halocline/error.h"

#include <stddef.h>

/* Reads the bytes of a scene file into `*text` (zero-terminated beyond `*length`, freed with hc_free).
 * HC_BAD_INPUT if there is no such file, or it is a folder, empty or far too large for a scene. */
hc_status hc_scene_load(const char *path, char **text, size_t *length, hc_error *error);

/* Reads a scene from the `length` bytes of `text`; `name` stands for the file in messages and gives the
 * default scene name. `overrides` are "path.to.key=value", the value in YAML, applied over the text in their
 * order. `limits` may be null: any names are taken, and methods
 * complete nothing. On HC_OK `scene` is complete and checked, to be freed
 * with hc_scene_free, and what is valid but doubtful was added to `warnings` (which may be null); otherwise
 * it is empty and `error` tells all that is wrong (HC_BAD_INPUT). */
hc_status hc_scene_read_text(hc_scene *scene, const char *name, const char *text, size_t length,
                             const char *const *overrides, int override_count, const hc_scene_limits *limits,
                             hc_warnings *warnings, hc_error *error);

/* hc_scene_load and hc_scene_read_text in one. */
hc_status hc_scene_read(hc_scene *scene, const char *path, const char *const *overrides, int override_count,
                        const hc_scene_limits *limits, hc_warnings *warnings, hc_error *error);

#endif
