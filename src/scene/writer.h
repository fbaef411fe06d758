/* From a scene to YAML text. */
#ifndef HC_WRITER_H
#define HC_WRITER_H

#include "scene.h"

#include "halocline/error.h"

/* Writes the scene with every default filled in, but without keys that its modes do not use; reading the file
 * gives the same scene, bit for bit. The file appears whole or not at all: it is written as PATH.tmp, synced
 * and renamed. HC_IO_FAILED if that fails. Local. */
hc_status hc_scene_write(const hc_scene *scene, const char *path, hc_error *error);

#endif
