#include "wall_drag.h"

#include "sph/kernel.h"

#include <math.h>
#include <string.h>

/* Walls of frozen fluid, whose samples stand for as much as its particles. */
static bool is_frozen(const hc_sweep *sweep) {
  return sweep->walls_add == HC_WALLS_PRESSURE;
}

static bool takes_part(const hc_sweep *sweep) {
  switch (sweep->drag.kind) {
  case HC_DRAG_NONE:
    break;
  case HC_DRAG_ARTIFICIAL:
    return sweep->walls_add == HC_WALLS_MIRRORED;
  case HC_DRAG_LAMINAR:
    return sweep->no_slip && (sweep->walls_add == HC_WALLS_MIRRORED || is_frozen(sweep));
  }
  return false;
}

static double distance_from_walls(const hc_sweep *sweep, int32_t i) {
  const uint32_t *const row = hc_list_row(sweep->walls, i);
  double least = 1.0;
  for (int32_t k = 0; k < hc_list_count(sweep->walls, i); k++) {
    double d[3];
    const int32_t b = (int32_t)(row[k] / sizeof(hc_record));
    hc_sweep_from_wall(sweep, i, b, d);
    const double height = hc_sweep_over_wall(sweep, b, d);
    if (height > 0.0 && height < least) least = height;
  }
  return least - (double)sweep->wall_offset;
}

hc_dragger hc_wall_drag_by(const hc_sweep *sweep, int32_t i, double dt) {
  const hc_particles *const fluid = sweep->fluid;
  hc_dragger dragger = {.factor = 0.0};
  if (!takes_part(sweep)) return dragger;
  dragger.factor = (sweep->drag.kind == HC_DRAG_LAMINAR ? 2.0 : 1.0) * (double)sweep->rest_density *
                   (double)sweep->volume * sweep->drag.coefficient * (double)sweep->gradient /
                   (double)sweep->support;
  for (int axis = 0; axis < 3; axis++) {
    const size_t at = 3 * (size_t)i + (size_t)axis;
    dragger.velocity[axis] = fluid->velocity[at] - dt * (double)fluid->acceleration[at];
  }
  if (is_frozen(sweep)) {
    dragger.distance = distance_from_walls(sweep, i);
    return dragger;
  }
  const float *const gradient = &fluid->wall_gradient[3 * (size_t)i];
  const double x = gradient[0], y = gradient[1], z = gradient[2], length = sqrt(x * x + y * y + z * z);
  for (int axis = 0; axis < 3 && length > 0.0; axis++) dragger.normal[axis] = (double)gradient[axis] / length;
  return dragger;
}

/* From the velocity relative to the wall to that relative to its sample, with which the wetted surface rests.
 */
static double slip(const hc_sweep *sweep, const hc_dragger *dragger, int32_t b, const double d[3]) {
  const double behind = (double)sweep->wall_offset, *const n = dragger->normal;
  if (!is_frozen(sweep)) {
    const double distance = fabs(n[0] * d[0] + n[1] * d[1] + n[2] * d[2]);
    return 1.0 + behind / fmax(distance - behind, behind);
  }
  const double depth = hc_sweep_over_wall(sweep, b, d) - dragger->distance;
  return 1.0 + fmin(fmax(depth, behind) / fmax(dragger->distance, behind), 3.0);
}

void hc_wall_drag_on(const hc_sweep *sweep, const hc_dragger *dragger, int32_t b, const double d[3], double q,
                     double force[3]) {
  memset(force, 0, 3 * sizeof *force);
  if (dragger->factor == 0.0 || !(q < 1.0)) return;
  const float *const wall = sweep->boundary->motion[b].v;
  const double volume = (double)(is_frozen(sweep) ? sweep->volume : sweep->boundary->place[b].scalar);
  const double factor = -dragger->factor * volume * hc_kernel_slope_over_q(q) / (q * q + (double)HC_GUARD);
  double relative[3], approach = 0.0;
  for (int axis = 0; axis < 3; axis++) {
    relative[axis] = dragger->velocity[axis] - (double)wall[axis];
    approach += relative[axis] * d[axis];
  }
  if (sweep->drag.kind == HC_DRAG_LAMINAR) {
    const double slipping = factor * q * q * slip(sweep, dragger, b, d);
    for (int axis = 0; axis < 3; axis++) force[axis] = slipping * relative[axis];
  } else if (approach < 0.0) {
    for (int axis = 0; axis < 3; axis++) force[axis] = factor * approach * d[axis];
  }
}
