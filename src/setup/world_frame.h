/* From a scene to its frame: the edge of the cells, the integer particle spacing, the periods. */
#ifndef HC_WORLD_FRAME_H
#define HC_WORLD_FRAME_H

#include "halocline/error.h"
#include "scene/scene.h"
#include "space/frame.h"

/* Fills `frame` from the scene's spacing, support radius, domain and origin_cells.
 *
 * Open axes: the cell edge is the support radius, the scene's origin is the corner of cell `origin_cells`.
 * Periodic axes: floor(period / h) cells, at least 3, stretched by at most 10 %; the spacing is the even
 * number of units for which the period holds a whole number of spacings, to one unit each. The lower end of
 * the domain is a cell corner; if domain.min is not a whole number of cells from the scene's origin, the
 * origin is moved by at most half a cell to make it so, and is then no corner itself. frame->support_radius
 * is the scene's, or, if a period falls short of whole cells by less than 1e-9, smaller by that much, so that
 * it never exceeds an edge.
 *
 * Adding whole numbers to origin_cells moves origin and low by that many cells and changes nothing else.
 *
 * Errors (HC_BAD_INPUT, with the constraint, the value and the nearest values that fit): a spacing or support
 * radius out of range, a period that fits no cells or no whole number of spacings, an origin more than 2^31
 * cells away. Local: every rank computes the same. */
hc_status hc_setup_frame(const hc_scene *scene, hc_frame *frame, hc_error *error);

#endif
