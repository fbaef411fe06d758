/* A mesh that can be asked: how far is a point, on which side, what does a ray meet.
 *
 * Method: a tree of boxes around the triangles, halved at the median along the longest axis; the nearest
 * point of a triangle after Ericson 2005 (Real-Time Collision Detection, 5.1.5). The side is that of the
 * normal at the nearest point: of the face, the mean of both at an edge, the mean weighted by angles at a
 * vertex (Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted pseudonormal"),
 * which is exact for closed meshes that do not cut through themselves.
 *
 * Embree and GTS do this too, but Embree works in single precision with the instructions of the chip at hand,
 * and GTS walks hash tables in the order of addresses; here every rank must come to the same bits. Only + - *
 * / and square roots, ties to what the tree holds first.
 *
 * All functions are local. Metres. */
#ifndef HC_SURFACE_H
#define HC_SURFACE_H

#include "mesh.h"

/* A node of the tree: two children, the first behind it, or up to four triangles. */
typedef struct hc_surface_node {
  double low[3], high[3];
  int32_t first; /* of `order`, or the second child */
  int32_t count; /* triangles; 0: an inner node */
} hc_surface_node;

/* Samples of boundary particles, see surface_samples.h. */
typedef struct hc_surface_sample {
  double x[3], normal[3];
} hc_surface_sample;

typedef struct hc_surface {
  hc_mesh mesh;
  bool closed; /* else one-sided: the fluid is on the side that the triangles look at */
  double low[3], high[3];
  double (*face_normal)[3], (*vertex_normal)[3];
  hc_surface_node *nodes;
  int32_t *order;             /* of the triangles, as the leaves hold them */
  hc_surface_sample *samples; /* from first_sample on as many as are held here */
  int64_t sample_count, first_sample, samples_held;
  double samples_low[3], samples_high[3]; /* of all */
} hc_surface;

/* The point of a surface that is nearest to another. */
typedef struct hc_surface_point {
  double x[3], distance;
  int32_t triangle;
  double share[3]; /* of the triangle's corners in it */
} hc_surface_point;

/* Takes over a mesh that was checked; freed with hc_surface_free. */
hc_surface *hc_surface_make(hc_mesh *mesh, bool closed);
void hc_surface_free(hc_surface *surface);

hc_surface_point hc_surface_nearest(const hc_surface *surface, const double x[3]);

/* The same among the triangles of `nodes`, those of the surface or of a region of it (surface_region.h), and
 * no farther than the square root of `within`: triangle -1 if there is none. */
hc_surface_point hc_surface_nearest_among(const hc_surface *surface, const hc_surface_node *nodes,
                                          const double x[3], double within);

/* The square of the distance to a triangle. */
double hc_surface_square(const hc_surface *surface, int32_t triangle, const double x[3]);

/* The distance, negative behind the surface: inside a closed one. `nearest` may be null. */
double hc_surface_signed_distance(const hc_surface *surface, const double x[3], hc_surface_point *nearest);

/* The same if the nearest point is known. */
double hc_surface_signed(const hc_surface *surface, const double x[3], const hc_surface_point *nearest);

/* Whether a ray along the unit vector `ray` comes out through a triangle that it meets: `side` ray . normal >
 * 0.7, with `side` 1 or -1. */
bool hc_surface_faces(const hc_surface *surface, int32_t triangle, const double ray[3], double side);

/* How far from `x` a ray comes out through a triangle of `nodes`, `most` if that is farther. */
double hc_surface_ray(const hc_surface *surface, const hc_surface_node *nodes, const double x[3],
                      const double ray[3], double side, double most);

/* The normal at a point of a triangle, given by the shares of its corners: smooth where the faces around are
 * turned against each other by less than hc_surface_crease, that of the face along creases. */
void hc_surface_smooth_normal(const hc_surface *surface, int32_t triangle, const double share[3],
                              double normal[3]);

/* The shares of a triangle's corners in its point nearest to x, exactly 0 for those without one. */
void hc_surface_shares(const hc_surface *surface, int32_t triangle, const double x[3], double share[3]);

/* Whether side `side` of a triangle is a crease, more than 40 degrees sharp, or a border. */
bool hc_surface_crease(const hc_surface *surface, int32_t triangle, int side);

#endif
