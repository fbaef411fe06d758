/* Sample points of boxes and walls, by index: any rank can make any range of them, without making the others.
 *
 * Method: a sampling is a lattice (along each axis a position for each integer index) and a list of disjoint
 * boxes of indices. Its count is the sum of their volumes; point k is found through the box that holds k.
 * Nothing is stored per point, and since the boxes are disjoint no point comes twice.
 *
 * The surface of a box or plane is the wetted surface; boundary samples lie half a spacing on the far side of
 * it and fluid starts half a spacing on the near side, so the two are one spacing apart.
 *
 * Known weakness: samplings know nothing of each other. Where two walls cross, both have samples; a plane
 * ends at its rectangle's rim, so two planes that meet leave the far side of their common edge without
 * samples (a box does not).
 *
 * All functions are local. Lengths and coordinates come in metres, finite and within 2^60 units of the
 * origin. */
#ifndef HC_SAMPLING_H
#define HC_SAMPLING_H

#include <stdbool.h>
#include <stdint.h>

/* How metres map to integer units: units = origin + round(metres / unit). Values of hc_frame, see
 * space/frame.h. */
typedef struct hc_lattice {
  double unit[3];     /* metres per unit */
  int64_t origin[3];  /* the scene's origin, in units */
  int64_t spacing[3]; /* particle spacing, in units, even */
} hc_lattice;

/* Positions of the indices along one axis: `first` + round(i span / steps) for i in [0, steps], `below` for a
 * lower index and `above` for a higher one. */
typedef struct hc_sampling_axis {
  int64_t first, span, steps;
  int64_t below, above;
} hc_sampling_axis;

/* A box of indices: start[a] <= index < start[a] + count[a], x fastest; `first` points come before it. */
typedef struct hc_sampling_part {
  int64_t start[3], count[3];
  int64_t first;
} hc_sampling_part;

enum { HC_SAMPLING_MAX_PARTS = 26 };

/* A sampling is plain data and owns nothing: copy and drop it freely. Read it through the functions below. */
typedef struct hc_sampling {
  int64_t count;
  int part_count;
  hc_sampling_part parts[HC_SAMPLING_MAX_PARTS];
  hc_sampling_axis axis[3];
  bool oblique;       /* a plane whose normal is not along an axis: positions come from the following */
  int64_t centre[3];  /* middle of the rectangle of samples, units */
  double edges[2][3]; /* edge vectors of the rectangle, units */
  int64_t cells[2];   /* samples along each edge */
} hc_sampling;

/* The fluid lattice in a box: floor(L / spacing) points along each axis, the first half a spacing from `min`,
 * each the next integer multiple of the spacing. A length is taken for a multiple if it is one to 1e-6. Empty
 * where the box is thinner than a spacing. */
hc_sampling hc_sampling_block(const hc_lattice *lattice, const double min[3], const double max[3]);

/* The wall around a container whose inner surface is the box: one layer, closed along edges and at corners.
 * Along each axis it has round(L / spacing) rows (at least 1), of the spacing where L is a multiple (then in
 * line with the fluid of a block at the same `min`), else of L / rows. Bit 2a of `open` takes away the lower
 * face along axis a, bit 2a + 1 the upper one: nothing is left beyond an open face, the other faces end
 * there. */
hc_sampling hc_sampling_container(const hc_lattice *lattice, const double min[3], const double max[3],
                                  unsigned open);

/* The skin of a solid whose outer surface is the box: one layer, half a spacing inside, closed along edges
 * and at corners; a box thinner than 1.5 spacings has a single layer in its middle. An open face keeps only
 * the rows that it shares with closed ones. */
hc_sampling hc_sampling_solid(const hc_lattice *lattice, const double min[3], const double max[3],
                              unsigned open);

/* A rectangle with its centre at `point`, `normal` into the fluid (any length but 0) and edge lengths `size`
 * along two tangents; round(size / spacing) samples (at least 1) along each, at (i + 1/2) size / n, so that a
 * plane as long as a period closes. Tangents: a is the axis along which the normal is longest (the lowest
 * such axis). Along an axis-aligned normal the tangents are axes a+1 and a+2 (cyclic: x y z x y); else the
 * first is axis a+1 made perpendicular to the normal, the second the cross product of normal and first. */
hc_sampling hc_sampling_plane(const hc_lattice *lattice, const double point[3], const double normal[3],
                              const double size[2]);

/* Number of points; INT64_MAX if there are more than 2^30 along an edge or 2^62 in all: too many to ask for
 * any. */
int64_t hc_sampling_count(const hc_sampling *sampling);

/* Point k of [0, count), in units. */
void hc_sampling_point(const hc_sampling *sampling, int64_t k, int64_t x[3]);

/* The smallest box that holds all points, in units; count must not be 0. */
void hc_sampling_bounds(const hc_sampling *sampling, int64_t low[3], int64_t high[3]);

#endif
