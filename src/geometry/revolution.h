/* Surfaces of revolution, as meshes. Local; the same bits everywhere. */
#ifndef HC_REVOLUTION_H
#define HC_REVOLUTION_H

#include "mesh.h"

/* The surface that a profile of `count` points (r, z) makes about an axis: z along `axis` (of any length but
 * 0) from `base` on, r >= 0 away from it, m. `closed`: the profile bounds a volume, its ends being joined
 * unless both lie on the axis; which way round it goes does not matter. Else the fluid is on the left of it
 * (r to the right, z upwards). As many segments around as keep the faces within 0.01 `spacing` of the round
 * surface, at least 24. Points of the profile that repeat the one before are left away. HC_BAD_INPUT: fewer
 * than 2 points (closed: 3 with the axis), r below 0, all of it on the axis, more than HC_MESH_MOST
 * triangles. The mesh is still to be checked. */
hc_status hc_revolution_mesh(const double base[3], const double axis[3], const double (*profile)[2],
                             int count, bool closed, double spacing, hc_mesh *mesh, hc_error *error);

#endif
