#include "limits.h"

#include <math.h>

static const double UPWARDS = 4.0; /* longest edges of room for splashes */

/* Units from the scene's origin; what is too far for a position is no limit. */
static int64_t units_of(const hc_frame *frame, int axis, double metres) {
  const double units = metres / frame->unit[axis];
  if (!(fabs(units) < 0x1p60)) return units < 0.0 ? INT64_MIN : INT64_MAX;
  return frame->origin[axis] + llrint(units);
}

typedef struct extent {
  double low[3], high[3]; /* m */
} extent;

static void widen(const hc_frame *frame, const hc_setup_source *sources, int count, extent *to) {
  for (int k = 0; k < count; k++) {
    int64_t low[3], high[3];
    if (hc_source_count(&sources[k]) == 0) continue;
    hc_sampling_bounds(&sources[k].sampling, low, high);
    for (int a = 0; a < 3; a++) {
      to->low[a] = fmin(to->low[a], hc_frame_to_metres(frame, a, low[a]));
      to->high[a] = fmax(to->high[a], hc_frame_to_metres(frame, a, high[a]));
    }
  }
}

/* The limits that a scene has by itself, m. */
static extent compute(const hc_scene *scene, const hc_setup_plan *plan) {
  extent all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  if (plan->boundary_count == 0) /* none */
    return (extent){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
  widen(&plan->frame, plan->fluid, plan->fluid_sources, &all);
  widen(&plan->frame, plan->boundary, plan->boundary_sources, &all);
  double edge = 0.0;
  for (int a = 0; a < 3; a++) edge = fmax(edge, all.high[a] - all.low[a]);
  for (int a = 0; a < 3; a++) {
    all.low[a] -= (scene->gravity[a] > 0.0 ? UPWARDS : 1.0) * edge;
    all.high[a] += (scene->gravity[a] < 0.0 ? UPWARDS : 1.0) * edge;
  }
  return all;
}

static hc_status check_blocks(const hc_setup_plan *plan, const hc_limits *limits, int axis, hc_error *error) {
  const hc_frame *frame = &plan->frame;
  for (int k = 0; k < plan->fluid_sources; k++) {
    int64_t low[3], high[3];
    if (hc_source_count(&plan->fluid[k]) == 0) continue;
    hc_sampling_bounds(&plan->fluid[k].sampling, low, high);
    if (low[axis] >= limits->low[axis] && high[axis] <= limits->high[axis]) continue;
    return hc_error_set(error, HC_BAD_INPUT,
                        "%s: must lie within domain.limits along %c, not with particles from %g to %g m",
                        hc_source_block_name(k).text, "xyz"[axis], hc_frame_to_metres(frame, axis, low[axis]),
                        hc_frame_to_metres(frame, axis, high[axis]));
  }
  return HC_OK;
}

hc_status hc_setup_limits(const hc_scene *scene, const hc_setup_plan *plan, hc_limits *limits,
                          hc_error *error) {
  const extent computed = compute(scene, plan);
  for (int axis = 0; axis < 3; axis++) {
    const double low = scene->domain.limits_min[axis], high = scene->domain.limits_max[axis];
    const bool given = high > low;
    limits->low[axis] = units_of(&plan->frame, axis, given ? low : computed.low[axis]);
    limits->high[axis] = units_of(&plan->frame, axis, given ? high : computed.high[axis]);
    if (scene->domain.periodic[axis]) {
      limits->low[axis] = INT64_MIN;
      limits->high[axis] = INT64_MAX;
    } else if (given && check_blocks(plan, limits, axis, error) != HC_OK) {
      return error->status;
    }
  }
  return HC_OK;
}

double hc_limits_low(const hc_limits *limits, const hc_frame *frame, int axis) {
  return limits->low[axis] == INT64_MIN ? -INFINITY : hc_frame_to_metres(frame, axis, limits->low[axis]);
}

double hc_limits_high(const hc_limits *limits, const hc_frame *frame, int axis) {
  return limits->high[axis] == INT64_MAX ? INFINITY : hc_frame_to_metres(frame, axis, limits->high[axis]);
}
