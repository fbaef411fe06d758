/* The normals of boundary particles where walls meet, bend or are thin: what squared wall densities go by. */
#ifndef HC_BOUNDARY_NORMALS_H
#define HC_BOUNDARY_NORMALS_H

#include "sph/sweeps.h"

/* Of own boundary particles: `normal` loses what of it looks at another wall with no room for fluid between,
 * and `faces` becomes its weight in N = sum V_b W n_b: 1 on a face, more where faces meet, 0 where a wall is
 * too thin; `facing` holds both then. All follows from what the neighbours in `list` were before. The normals
 * of walls that move turn with them, and stay as they are; whom their edges meet changes, so these count by
 * their volumes. Local; the caller refreshes the ghosts. */
void hc_boundary_look_at_normals(const hc_sweep *sweep, hc_particles *boundary, const hc_neighbors *list);

#endif
