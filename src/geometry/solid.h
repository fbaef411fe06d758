/* What a closed shape weighs per unit of density: volume, centre of mass, inertia.
 *
 * Method: both follow from the second moments of the volume, the integrals of x_i x_j. Boxes, cylinders and
 * spheres have them in closed form along their own axes. A surface is the sum of the tetrahedra that its
 * triangles make with a point (Kallay 2006, "Computing the moment of inertia of a solid defined by a triangle
 * mesh"): with a, b, c from there and s = a + b + c, each has the volume V = a . (b x c) / 6, the first
 * moments V s / 4 and the second moments V (a a + b b + c c + s s) / 20. Those whose triangle looks at the
 * point count as negative, so that what is outside cancels, hollows too. The point is the middle of the box
 * around the surface, for a shape far from the origin would lose its digits there.
 *
 * Known weakness: the sums ask nothing. What is inside out has a negative volume and inertia about the right
 * centre; parts that lie in each other count twice; an open surface counts as if the middle of the box were
 * joined to its border.
 *
 * Local; plain sums in the order of the triangles with + - * / only: the same bits everywhere. */
#ifndef HC_SOLID_H
#define HC_SOLID_H

#include "shape.h"

/* Volume, centre and inertia of what a closed shape holds, at density 1. */
typedef struct hc_solid {
  double volume;        /* m3 */
  double centre[3];     /* m, of mass */
  double inertia[3][3]; /* m5: of the volume about the centre, along the coordinate axes; symmetric */
} hc_solid;

/* Of the shape with all of its faces, the open ones too; of a layer of a surface (hc_shape_layer), of the
 * surface itself. What has no volume, as a rectangle, has no inertia, and the middle of the shape as its
 * centre. */
hc_solid hc_solid_of(const hc_shape *shape);

#endif
