#include "limits.h"

#include "setup/prescribed.h"

#include <math.h>

/* Units from the scene's origin; what is too far for a position is no limit. */
static int64_t units_of(const hc_frame *frame, int axis, double metres) {
  const double units = metres / frame->unit[axis];
  if (!(fabs(units) < 0x1p60)) return units < 0.0 ? INT64_MIN : INT64_MAX;
  return frame->origin[axis] + llrint(units);
}

typedef struct extent {
  double low[3], high[3]; /* m */
} extent;

static const extent nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void merge(const extent *extent, struct extent *to) {
  for (int a = 0; a < 3; a++) {
    to->low[a] = fmin(to->low[a], extent->low[a]);
    to->high[a] = fmax(to->high[a], extent->high[a]);
  }
}

static void widen(const hc_frame *frame, const hc_setup_source *sources, int count, extent *to) {
  for (int k = 0; k < count; k++) {
    int64_t low[3], high[3];
    if (hc_source_count(&sources[k]) == 0 || sources[k].start.moved) continue;
    hc_sampling_bounds(&sources[k].sampling, low, high);
    extent source;
    for (int a = 0; a < 3; a++) {
      source.low[a] = hc_frame_to_metres(frame, a, low[a]);
      source.high[a] = hc_frame_to_metres(frame, a, high[a]);
    }
    merge(&source, to);
  }
}

/* Blocks that come later. */
static void widen_by_refills(const hc_scene *scene, extent *to) {
  for (int k = 0; k < scene->fluid.block_count; k++) {
    if (!(scene->fluid.blocks[k].start > 0.0)) continue;
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[k]);
    extent block;
    for (int a = 0; a < 3; a++) {
      block.low[a] = box.min[a];
      block.high[a] = box.max[a];
    }
    merge(&block, to);
  }
}

/* Where a moving wall comes to until the end; nowhere if it has no samples. */
static extent sweep(const hc_scene *scene, const hc_setup_plan *plan, const hc_mover *wall) {
  extent swept = nothing;
  if (wall->motion.law == HC_MOTION_BODY) { /* as it starts */
    for (int a = 0; a < 3; a++) {
      swept.low[a] = wall->motion.centre[a] - wall->reach;
      swept.high[a] = wall->motion.centre[a] + wall->reach;
    }
    return swept;
  }
  widen(&plan->frame, &plan->boundary[wall->wall], 1, &swept);
  if (swept.low[0] <= swept.high[0])
    hc_prescribed_sweep(&wall->motion, scene->end_time, swept.low, swept.high);
  return swept;
}

static void widen_by_motions(const hc_scene *scene, const hc_setup_plan *plan, const hc_movers *motions,
                             extent *to) {
  for (int k = 0; k < motions->count; k++) {
    const extent swept = sweep(scene, plan, &motions->walls[k]);
    merge(&swept, to);
  }
}

/* Where fluid comes in. */
static void widen_by_emitters(const hc_emitters *emitters, extent *to) {
  for (int k = 0; k < emitters->count; k++) {
    extent opening;
    hc_prescribed_emitter_bounds(&emitters->emitters[k], opening.low, opening.high);
    merge(&opening, to);
  }
}

/* The limits that a scene has by itself, m. */
static extent compute(const hc_scene *scene, const hc_setup_plan *plan, const hc_movers *motions,
                      const hc_emitters *emitters) {
  extent all = nothing;
  if (plan->boundary_count == 0) /* none */
    return (extent){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
  widen(&plan->frame, plan->fluid, plan->fluid_sources, &all);
  widen_by_refills(scene, &all);
  widen(&plan->frame, plan->boundary, plan->boundary_sources, &all);
  widen_by_motions(scene, plan, motions, &all);
  widen_by_emitters(emitters, &all);
  double edge = 0.0;
  for (int a = 0; a < 3; a++) edge = fmax(edge, all.high[a] - all.low[a]);
  for (int a = 0; a < 3; a++) {
    all.low[a] -= (scene->gravity[a] > 0.0 ? HC_LIMITS_ROOM : 1.0) * edge;
    all.high[a] += (scene->gravity[a] < 0.0 ? HC_LIMITS_ROOM : 1.0) * edge;
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

/* Positions end 2^31 cells from the origin. */
static hc_status check_motions(const hc_scene *scene, const hc_setup_plan *plan, const hc_movers *motions,
                               hc_error *error) {
  const double farthest = 0x1p31 * plan->frame.support_radius;
  for (int k = 0; k < motions->count; k++) {
    const int number = motions->walls[k].wall;
    const extent swept = sweep(scene, plan, &motions->walls[k]);
    for (int a = 0; a < 3; a++)
      if (swept.low[a] <= swept.high[a] && !(swept.low[a] >= -farthest && swept.high[a] <= farthest))
        return hc_error_set(error, HC_BAD_INPUT,
                            "%s: must stay within 2^31 support radii of the origin until end_time, not move "
                            "from %g to %g m along %c",
                            hc_source_surface_name(scene, number).text, swept.low[a], swept.high[a],
                            "xyz"[a]);
  }
  return HC_OK;
}

static hc_status check_emitters(const hc_frame *frame, const hc_emitters *emitters, const hc_limits *limits,
                                int axis, hc_error *error) {
  for (int k = 0; k < emitters->count; k++) {
    double low[3], high[3];
    hc_prescribed_emitter_bounds(&emitters->emitters[k], low, high);
    if (low[axis] >= hc_limits_low(limits, frame, axis) && high[axis] <= hc_limits_high(limits, frame, axis))
      continue;
    return hc_error_set(error, HC_BAD_INPUT,
                        "%s: must lie within domain.limits along %c, not with particles from %g to %g m",
                        hc_prescribed_emitter_name(k).text, "xyz"[axis], low[axis], high[axis]);
  }
  return HC_OK;
}

hc_status hc_setup_limits(const hc_scene *scene, const hc_setup_plan *plan, const hc_emitters *emitters,
                          hc_limits *limits, hc_error *error) {
  hc_movers motions = hc_prescribed_movers_make(scene, plan);
  const hc_status status = check_motions(scene, plan, &motions, error);
  const extent computed = compute(scene, plan, &motions, emitters);
  hc_movers_free(&motions);
  if (status != HC_OK) return status;
  for (int axis = 0; axis < 3; axis++) {
    const double low = scene->domain.limits_min[axis], high = scene->domain.limits_max[axis];
    const bool given = high > low;
    limits->low[axis] = units_of(&plan->frame, axis, given ? low : computed.low[axis]);
    limits->high[axis] = units_of(&plan->frame, axis, given ? high : computed.high[axis]);
    if (scene->domain.periodic[axis]) {
      limits->low[axis] = INT64_MIN;
      limits->high[axis] = INT64_MAX;
    } else if (given && (check_blocks(plan, limits, axis, error) != HC_OK ||
                         check_emitters(&plan->frame, emitters, limits, axis, error) != HC_OK)) {
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
