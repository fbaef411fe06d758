/* Sample points of boxes and walls, by index: any rank can make any range of them, without making the others.
 *
 * Method: a sampling is either a lattice (along each axis a position for each integer index) and a list of
 * disjoint boxes of indices, or a list of runs: straight rows or rings of points, repeated at equal steps.
 * Its count is the sum over the list; point k is found through the entry that holds k. Nothing is stored per
 * point, and since the entries are disjoint no point comes twice. Both may be turned as a whole. Only the
 * walls of surfaces are lists of points.
 *
 * The surface of a wall is the wetted surface; boundary samples lie half a spacing on the far side of it and
 * fluid starts half a spacing on the near side, so the two are one spacing apart. Walls have `layers` of
 * samples, 1 or 2: the second lies a spacing further and is closed around edges and corners too.
 *
 * Known weakness: samplings know nothing of each other. Where two walls cross, both have samples (setup/
 * drops the later ones); a plane ends at its rectangle's rim, so two planes that meet leave the far side of
 * their common edge without samples (a box does not).
 *
 * All functions are local. Lengths and coordinates come in metres, finite and within 2^60 units of the
 * origin. */
#ifndef HC_SAMPLING_H
#define HC_SAMPLING_H

#include "shape.h"

#include <stddef.h>
#include <stdint.h>

/* How metres map to integer units: units = origin + round(metres / unit). Values of hc_frame, see
 * space/frame.h. */
typedef struct hc_lattice {
  double unit[3];     /* metres per unit */
  int64_t origin[3];  /* the scene's origin, in units */
  int64_t spacing[3]; /* particle spacing, in units, even */
} hc_lattice;

/* Positions of the indices along one axis: `first` + round(i span / steps) for i in [0, steps], `below` for
 * index -1 and `above` for steps + 1, `pitch` more for each index further out. */
typedef struct hc_sampling_axis {
  int64_t first, span, steps;
  int64_t below, above, pitch;
} hc_sampling_axis;

/* A box of indices: start[a] <= index < start[a] + count[a], x fastest; `first` points come before it. */
typedef struct hc_sampling_part {
  int64_t start[3], count[3];
  int64_t first;
} hc_sampling_part;

enum { HC_SAMPLING_MAX_PARTS = 45 }; /* two layers, those along axis 0 one by one */

/* Equal rows or rings, `rise` apart along the third own axis, in units of axis 0. A row: `count` points from
 * `at` on, one spacing apart along the first own axis. A ring: `count` points about the third own axis, at[0]
 * its radius, at[2] its height. */
typedef struct hc_sampling_run {
  double at[3], rise;
  int64_t count, repeat;
  int64_t first; /* points before it */
} hc_sampling_run;

/* Points that fill space by their images, in HC_TILE_UNIT parts of a spacing from a lower corner; somebody
 * else's. */
enum { HC_TILE_UNIT = 1 << 20 };
typedef struct hc_sampling_tile {
  const int32_t (*at)[3]; /* null: none */
  int64_t count, extent[3];
} hc_sampling_tile;

/* Read it through the functions below; freed with hc_sampling_free, which does nothing for one without runs:
 * boxes along the axes and planes are plain data. */
typedef struct hc_sampling {
  int64_t count;
  int part_count;
  hc_sampling_part parts[HC_SAMPLING_MAX_PARTS];
  hc_sampling_axis axis[3];
  bool turned;       /* positions are in a shape's own axes, in units of axis 0 from its centre */
  int64_t centre[3]; /* units */
  double turn[3][3]; /* turn[a][t]: units along a for each along own axis t */
  bool rings;        /* the runs are rings */
  double pitch;      /* between the points of a row */
  const struct hc_surface_sample *listed; /* the points held here, in own axes; somebody else's */
  int64_t listed_first, listed_end;       /* which they are */
  double listed_low[3], listed_high[3];   /* around all points */
  hc_sampling_tile tile;                  /* its images are the points, where it has any */
  int64_t images[3];                      /* how many along each axis, x fastest */
  int64_t tile_first[3], tile_step[3];    /* units: the lower corner of the first image, and between images */
  int64_t tile_spacing[3];                /* units */
  int64_t tile_low[3], tile_high[3];      /* units: the box that is asked for */
  hc_sampling_run *runs;
  int64_t run_count;
  size_t run_room;
} hc_sampling;

/* The fluid lattice in a box: floor(L / spacing) points along each axis, the first half a spacing from `min`,
 * each the next integer multiple of the spacing. A length is taken for a multiple if it is one to 1e-6. Empty
 * where the box is thinner than a spacing. */
hc_sampling hc_sampling_block(const hc_lattice *lattice, const double min[3], const double max[3]);

/* The wall around a container whose inner surface is the box, closed along edges and at corners.
 * Along each axis it has round(L / spacing) rows (at least 1), of the spacing where L is a multiple (then in
 * line with the fluid of a block at the same `min`), else of L / rows. Bit 2a of `open` takes away the lower
 * face along axis a, bit 2a + 1 the upper one: nothing is left beyond an open face, the other faces end
 * there. */
hc_sampling hc_sampling_container(const hc_lattice *lattice, const double min[3], const double max[3],
                                  unsigned open, int layers);

/* The skin of a solid whose outer surface is the box, from half a spacing inside, closed along edges and at
 * corners. Along each axis it has round(L / spacing) rows, the outermost half a spacing from the faces, at
 * equal distances; a box thinner than 1.5 spacings has a single layer in its middle, one thinner than 3 a
 * single layer behind each face. An open face keeps only the rows that it shares with closed ones. */
hc_sampling hc_sampling_solid(const hc_lattice *lattice, const double min[3], const double max[3],
                              unsigned open, int layers);

/* The images of a tile that reach into a box: all their points, also those beyond it. Images lie at whole
 * multiples of its extent from `origin`, m, so that tilings with the same origin fit each other. */
hc_sampling hc_sampling_tiled(const hc_lattice *lattice, const hc_sampling_tile *tile, const double origin[3],
                              const double min[3], const double max[3]);

/* Of a tiling: the middle of the image that holds point k, in units, and the first point behind it. */
void hc_sampling_image(const hc_sampling *sampling, int64_t k, double middle[3], int64_t *end);

/* A rectangle, see hc_shape_rectangle; round(size / spacing) samples (at least 1) along each tangent, at
 * (i + 1/2) size / n, so that a plane as long as a period closes. */
hc_sampling hc_sampling_plane(const hc_lattice *lattice, const double point[3], const double normal[3],
                              const double size[2], int layers);

/* How many of `layers` a solid so many spacings thick has behind each of two faces. */
int hc_sampling_layers_within(double thickness, int layers);

/* How many whole spacings fit into `ratio` spacings, the tolerance for decimal fractions included. */
double hc_sampling_whole(double ratio);

/* The lattice of a shape's own axes: its centre is the origin, all axes have the units of axis 0. */
hc_lattice hc_sampling_own_lattice(const hc_lattice *lattice);

/* Brings a sampling from the shape's own lattice into place. */
void hc_sampling_turn(hc_sampling *sampling, const hc_lattice *lattice, const hc_shape *shape);

/* Appends a run (its `first` is set here); none of no points. */
void hc_sampling_add_run(hc_sampling *sampling, const hc_sampling_run *run);

void hc_sampling_free(hc_sampling *sampling);

/* Number of points; INT64_MAX if there are more than 2^30 along an edge or 2^62 in all: too many to ask for
 * any. */
int64_t hc_sampling_count(const hc_sampling *sampling);

/* Point k of [0, count), in units. */
void hc_sampling_point(const hc_sampling *sampling, int64_t k, int64_t x[3]);

/* The end of the straight row or ring that holds point k: of the points in [k, end) each is at most 1.5
 * spacings from the one before. */
int64_t hc_sampling_row_end(const hc_sampling *sampling, int64_t k);

/* The smallest box that holds all points, or the circles on which the points of rings lie, in units; count
 * must not be 0. */
void hc_sampling_bounds(const hc_sampling *sampling, int64_t low[3], int64_t high[3]);

#endif
