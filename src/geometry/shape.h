/* Boxes, cylinders, spheres, rectangles and surfaces anywhere in space, and how far a point is from them.
 * Metres, in the scene's frame.
 *
 * Method: a shape is a box of components. In its own axes, the first `round` coordinates of a point stand
 * together as one radius (none in a box, two in a cylinder, three in a sphere); the others are components of
 * their own. What holds for a box along its axes then holds for all shapes: each component lies between a
 * lower and an upper face, a radius has no lower one.
 *
 * A surface of triangles (surface.h) is a shape without components: it is asked itself, and its layers are
 * the points at one distance from it.
 *
 * All distances change by no more than the point moves, so that what is far from one point is known to be
 * away from all points around it. All functions are local. */
#ifndef HC_SHAPE_H
#define HC_SHAPE_H

#include <stdbool.h>

typedef struct hc_shape {
  double centre[3];
  double axes[3][3];      /* axes[t]: the shape's own axis t, of unit length; right-handed */
  int round;              /* 1: box, rectangle; 2: cylinder, along axes[2]; 3: sphere; HC_SHAPE_SURFACE */
  double low[3], high[3]; /* of each component, from the centre */
  unsigned open;          /* bit 2c: component c has no lower face, bit 2c + 1: no upper one */
  const struct hc_surface *surface; /* low and high: the box around it */
  double level;                     /* of a surface's layer: m behind it, */
  bool outside;                     /* on the outside of a closed one */
} hc_shape;

enum { HC_SHAPE_SURFACE = 4 };

/* A box from `min` to `max`, turned about its centre by `turns` whole turns, right-handed about `axis` (of
 * any length but 0; without a turn it is not looked at). Bits of `open` as in hc_shape. */
hc_shape hc_shape_box(const double min[3], const double max[3], const double axis[3], double turns,
                      unsigned open);

/* A cylinder whose bottom has its middle at `base`, its top `length` further along `axis` (of any length but
 * 0). `open`: 1 no bottom, 2 no top. */
hc_shape hc_shape_cylinder(const double base[3], const double axis[3], double radius, double length,
                           unsigned open);

hc_shape hc_shape_sphere(const double centre[3], double radius);

/* A rectangle about `point` with `normal` into the fluid (of any length but 0) and edge lengths `size` along
 * its tangents, axes 0 and 1; axis 2 is the normal. It has one face only: what is in front of it counts as
 * inside. The tangents: a is the axis along which the normal is longest (the lowest such axis). Along an
 * axis-aligned normal they are axes a+1 and a+2 (cyclic: x y z x y); else the first is axis a+1 made
 * perpendicular to the normal, the second the cross product of normal and first. */
hc_shape hc_shape_rectangle(const double point[3], const double normal[3], const double size[2]);

/* Number of components: 3, 2 or 1; 0 of a surface. */
int hc_shape_components(const hc_shape *shape);

/* The surface on which boundary samples of this spacing lie: half a spacing outside the closed faces of a
 * container (`solid` false), half a spacing inside those of a solid, in the middle of a component less than
 * 1.5 spacings thick. `layer` 1 is the second surface, a spacing further (samples of solids are shifted off
 * it by up to a quarter of a spacing). Use it with hc_shape_surface_distance. */
hc_shape hc_shape_layer(const hc_shape *shape, double spacing, bool solid, int layer);

/* The unit normal into the fluid at a boundary sample `x`: that of the face it lies behind, the normalised
 * mean of the faces of an edge or corner that it belongs to. Not for surfaces, whose samples have normals. Of
 * a solid's faces those count whose layer is the sample's own, and opposite ones cancel: 0 in the middle of a
 * solid, which has fluid on both sides. */
void hc_shape_sample_normal(const hc_shape *shape, double spacing, bool solid, const double x[3],
                            double normal[3]);

/* From `x` to the surface, negative inside; open faces count as faces. */
double hc_shape_distance(const hc_shape *shape, const double x[3]);

/* The same of the shape continued without end through its open faces; -INFINITY if no face is closed. */
double hc_shape_region_distance(const hc_shape *shape, const double x[3]);

/* From `x` to the nearest point of the closed faces, from either side; INFINITY if there are none. */
double hc_shape_surface_distance(const hc_shape *shape, const double x[3]);

/* Outward normal of a face: bit 2c or 2c + 1 of component c. Straight faces only (c of a coordinate). */
void hc_shape_face_normal(const hc_shape *shape, int face, double normal[3]);

/* The radius of the smallest sphere about the centre that holds the shape. */
double hc_shape_reach(const hc_shape *shape);

/* The smallest box that holds a box, cylinder, sphere or surface. */
void hc_shape_bounds(const hc_shape *shape, double min[3], double max[3]);

/* The least of one of these distances over the images of x, which repeat at `period`, m (0: they do not). */
double hc_shape_nearest_image(double (*distance)(const hc_shape *shape, const double x[3]),
                              const hc_shape *shape, const double period[3], const double x[3]);

#endif
