/* Rest states on disk: one small HDF5 file, sealed like a checkpoint (seal.h).
 *
 * /Halocline has the attributes content = "rest state", rest_format, program_version, scene, solver,
 * particle_spacing, support_radius (m), rest_density (kg/m3), mass_factor, extent [3] (m), periodic [3] (0 or
 * 1), particles, steps, density_mean, density_max, density_deviation (of the rest density), speed_max (half
 * spacings a step), and the datasets scene_text, the scene that made it, and position [particles][3], in
 * 2^-20 spacings from the lower corner, by x, y, z. */
#ifndef HC_REST_FILE_H
#define HC_REST_FILE_H

#include "comm/comm.h"
#include "scene/scene.h"
#include "state/rest_state.h"

#include <stdio.h>

/* Writes rank 0's state to `path`, whole or not at all. Collective; HC_IO_FAILED, agreed, as for a
 * checkpoint.
 */
hc_status hc_rest_file_write(hc_comm *comm, const hc_scene *scene, const char *path,
                             const hc_rest_state *state, hc_error *error);

/* Reads a file. Local; HC_BAD_INPUT, with the path: not there, not a rest state, cut short, damaged. The
 * state is freed with hc_rest_state_free. */
hc_status hc_rest_file_read(const char *path, hc_rest_state **state, hc_error *error);

/* Is the sealed file at `path` a rest state? And what it holds, for people or as a JSON object with the keys
 * file and, as the attributes, content, solver, particle_spacing, support_radius, rest_density, mass_factor,
 * extent, periodic, particles, steps, density_mean, density_max, density_deviation, speed_max. Local. */
bool hc_rest_file_is(const char *path);
hc_status hc_rest_file_print(const char *path, bool json, FILE *out, hc_error *error);

#endif
