/* Tables of motion in files of their own: CSV beside the scene.
 *
 * The first line that is neither empty nor a comment (#) names the columns: time, x, y, z and, if the wall
 * turns, angle, in any order and no others. Then a row of numbers a line, times ascending. Cells are
 * separated by commas, or by semicolons if the first line has one, and may be quoted. */
#ifndef HC_MOTION_FILE_H
#define HC_MOTION_FILE_H

#include "halocline/error.h"
#include "scene.h"

/* Does a wall's table still stand in a file? Local. */
bool hc_motion_file_pending(const hc_wall *wall);

/* Reads the table of a wall that names a file, number `number` of its scene, into its points, as if they
 * stood in the scene, and takes the name away. `scene_path`: a file that is no absolute path is looked for
 * beside it. HC_BAD_INPUT with the wall, the file, the line and what is wrong. Local. */
hc_status hc_motion_file_read(hc_wall *wall, int number, const char *scene_path, hc_error *error);

#endif
