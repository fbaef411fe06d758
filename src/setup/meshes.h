/* The surfaces of a scene: meshes from their files, revolutions from their profiles, checked and sampled. */
#ifndef HC_MESHES_H
#define HC_MESHES_H

#include "comm/comm.h"
#include "geometry/parts.h"
#include "scene/findings.h"
#include "scene/scene.h"

/* How the ranks divide the sampling of a surface; null: one process alone. */
hc_parts hc_setup_parts(hc_comm *comm);

/* Makes the surface of every block and wall that has one; walls with their samples. Meshes are read by rank 0
 * and sent; sampled by all together, to the same bits on any number of ranks. `context`: an
 * hc_comm, over which the call is collective, or null: this process alone. `name`: the scene file, in whose
 * folder the meshes lie. Files' paths become whole and their checksums are filled in. A scene without a frame
 * is left alone (the review tells).
 *
 * Errors, as findings: what hc_mesh_file_read, hc_mesh_check, hc_revolution_mesh and hc_surface_samples_make
 * refuse, a file that has another checksum, a surface smaller than a particle spacing or beyond 2^31 support
 * radii. Warning: a closed mesh that was inside out and is turned around. For hc_scene_limits.load. */
void hc_setup_meshes_load(void *context, hc_scene *scene, const char *name, hc_findings *findings);

#endif
