/* Questions about axis-aligned boxes, in metres. A box is closed: its faces belong to it. Local. */
#ifndef HC_BOX_H
#define HC_BOX_H

#include <stdbool.h>

/* Whether `x` lies in the box grown by `margin` on all sides (negative: shrunk; a box shrunk to nothing holds
 * nothing). False for coordinates that are not numbers. */
bool hc_box_contains(const double min[3], const double max[3], double margin, const double x[3]);

/* Whether box a lies wholly in box b grown by `margin`. */
bool hc_box_inside(const double a_min[3], const double a_max[3], const double b_min[3], const double b_max[3],
                   double margin);

/* Whether the boxes share more than `margin` along every axis; 0: boxes that only touch do not overlap. */
bool hc_box_overlaps(const double a_min[3], const double a_max[3], const double b_min[3],
                     const double b_max[3], double margin);

#endif
