/* Files that a scene names. */
#ifndef HC_NAMED_FILE_H
#define HC_NAMED_FILE_H

#include "halocline/error.h"
#include "scene/scene.h"

/* The whole path of a file, which is named from the folder of the scene file `scene_name` on; what is wrong
 * with it, reading tells. HC_BAD_INPUT: longer than a path may be. Local. */
hc_status hc_named_file_find(const char *scene_name, const char *file, char path[static HC_FILE_LENGTH],
                             hc_error *error);

#endif
