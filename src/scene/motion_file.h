/* Tables of motion in files of their own: CSV beside the scene.
 *
 * The first line that is neither empty nor a comment (#) names the columns: time, x, y, z and, if the wall
 * turns, angle, in any order; others are passed over. Then a row of numbers a line, times ascending. */
#ifndef HC_MOTION_FILE_H
#define HC_MOTION_FILE_H

#include "halocline/error.h"
#include "scene.h"

/* Does a wall's table still stand in a file? Local. */
bool hc_motion_file_pending(const hc_wall *wall);

/* Reads the tables of all walls that name a file into the walls' points, as if they stood in the scene, and
 * takes the names away. `scene_path`: files that are no absolute paths are looked for beside it. HC_BAD_INPUT
 * with the wall, the file, the line and what is wrong. Local. */
hc_status hc_motion_file_read_all(hc_scene *scene, const char *scene_path, hc_error *error);

#endif
