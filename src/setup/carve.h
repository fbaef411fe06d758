/* Fluid makes room for bodies: what of blocks lies within half a spacing of a body as it starts is left out,
 * and within a spacing where the body is so thin that its samples lie nearer to the surface than half a
 * spacing. */
#ifndef HC_CARVE_H
#define HC_CARVE_H

#include "setup/source.h"

/* From x to the surface of a body as it starts, negative inside, over all periodic images, m. Local. */
double hc_carve_distance(const hc_frame *frame, const hc_setup_source *body, const double x[3]);

/* Leaves out samples of blocks. Local. */
void hc_setup_carve(const hc_frame *frame, hc_setup_source *blocks, int block_count,
                    const hc_setup_source *bodies, int body_count);

#endif
