/* How samples of walls count for a particle in its wall density's gradient B = sum w_b V_b grad W: as in the
 * sweeps (sph/pairs.h), pair by pair. */
#ifndef HC_WALL_WEIGHT_H
#define HC_WALL_WEIGHT_H

#include "sph/kernel.h"
#include "sph/sweeps.h"

#include <math.h>

/* What weights of a sample's normal are times, m3: 0 where wall densities do not go with the square (see
 * hc_sweep.flat_wall). */
static inline double hc_wall_weight_scale(const hc_sweep *sweep) {
  return sweep->flat_wall > 0.0f ? (double)sweep->kernel / (double)sweep->flat_wall : 0.0;
}

/* Adds what sample b, at distance q in support radii, has in N/D_0. */
static inline void hc_wall_weight_add(const hc_sweep *sweep, double scale, int32_t b, double q,
                                      double normal[3]) {
  if (scale == 0.0) return;
  const hc_record *const n = &sweep->boundary->facing[b];
  const double weight =
      scale * hc_kernel_shape(q) * (double)sweep->boundary->place[b].scalar * fabs((double)n->scalar);
  for (int axis = 0; axis < 3; axis++) normal[axis] += weight * (double)n->v[axis];
}

/* N/D_0 of a particle; 0 where it does not count. */
static inline void hc_wall_weight_normal(const hc_sweep *sweep, int32_t i, double normal[3]) {
  const uint32_t *const row = hc_list_row(sweep->walls, i);
  const double scale = hc_wall_weight_scale(sweep);
  normal[0] = normal[1] = normal[2] = 0.0;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, i); k++) {
    const int32_t b = (int32_t)(row[k] / sizeof(hc_record));
    double d[3];
    hc_sweep_from_wall(sweep, i, b, d);
    hc_wall_weight_add(sweep, scale, b, sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]), normal);
  }
}

/* w_b, by that normal. */
static inline double hc_wall_weight(const hc_sweep *sweep, int32_t b, const double normal[3]) {
  const hc_record *const n = sweep->flat_wall > 0.0f ? &sweep->boundary->facing[b] : NULL;
  if (!n || n->scalar == 0.0f) return 1.0;
  return 2.0 * fabs((double)n->scalar) *
         ((double)n->v[0] * normal[0] + (double)n->v[1] * normal[1] + (double)n->v[2] * normal[2]);
}

#endif
