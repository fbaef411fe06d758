/* A part of a surface's tree, for many questions at about the same place.
 *
 * The nodes that overlap a box, those with a single child left away: walked in the same order as the whole
 * tree, so that what is found, ties too, is the same to the bit. Local. */
#ifndef HC_SURFACE_REGION_H
#define HC_SURFACE_REGION_H

#include "surface.h"

#include <stddef.h>

/* Zeroed: none, with room for nothing. */
typedef struct hc_surface_region {
  hc_surface_node *nodes;
  int32_t count;
  size_t room;
  double low[3], high[3];
} hc_surface_region;

/* Replaces the region by that of a box. */
void hc_surface_region_take(hc_surface_region *region, const hc_surface *surface, const double low[3],
                            const double high[3]);
void hc_surface_region_free(hc_surface_region *region);

/* Whether all within `reach` of x is in the region. */
bool hc_surface_region_holds(const hc_surface_region *region, const double x[3], double reach);

/* Whether any of the region's triangles faces a ray, see hc_surface_faces. */
bool hc_surface_region_faces(const hc_surface_region *region, const hc_surface *surface, const double ray[3],
                             double side);

#endif
