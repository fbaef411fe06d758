/* Samplings of shapes that are not boxes along the axes: cylinders, spheres, turned boxes.
 *
 * All are made in the shape's own axes and turned into place, with positions rounded to units. Local; errors
 * and limits as in sampling.h: a count of INT64_MAX is too many, also where the list of rows would be. */
#ifndef HC_ROUND_H
#define HC_ROUND_H

#include "sampling.h"

/* The fluid lattice in a shape, along its own axes, all points at least half a spacing inside. A box: as
 * hc_sampling_block. A sphere: with a point at the centre. A cylinder: with a row on the axis, layers from
 * half a spacing above the base on, as many as whole spacings fit. Between the outermost points and a round
 * surface up to a spacing more stays free, so a round block holds less fluid than its volume: about
 * (1 - spacing / 2 radius)^2 or ^3 of it. Empty where the shape is thinner than a spacing. */
hc_sampling hc_round_fill(const hc_lattice *lattice, const hc_shape *shape);

/* The wall around a container (`solid` false) or the skin of a solid, 1 or 2 layers, on hc_shape_layer. A
 * box: as hc_sampling_container and hc_sampling_solid. Round surfaces are covered by rings of round(2 pi r /
 * spacing) samples: round(L / spacing) of them along a cylinder, its ends closed by concentric rings about
 * one sample and the rim; from pole to pole of a sphere. The second layer of a solid cylinder are the next
 * rings and rows. Open ends as those of boxes; thin solids as well. */
hc_sampling hc_round_wall(const hc_lattice *lattice, const hc_shape *shape, bool solid, int layers);

#endif
