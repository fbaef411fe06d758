#include "measures.h"

#include "base/memory.h"
#include "solver/wall_force.h"
#include "sph/kernel.h"

#include <math.h>

static double length(const double v[3]) {
  return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

hc_point hc_measure_point(const hc_frame *frame, const double metres[3]) {
  hc_point point;
  for (int axis = 0; axis < 3; axis++) point.x[axis] = hc_frame_to_units(frame, axis, metres[axis]);
  return point;
}

void hc_measure_offset(const hc_frame *frame, const int64_t position[3], const hc_point *point,
                       double offset[3]) {
  for (int axis = 0; axis < 3; axis++) {
    int64_t units = position[axis] - point->x[axis];
    const int64_t period = frame->period[axis];
    if (period > 0) {
      units %= period;
      if (units > period / 2) units -= period;
      if (units < -period / 2) units += period;
    }
    offset[axis] = (double)units * frame->unit[axis];
  }
}

/* A length along an axis within [0, period), where it repeats. */
static double wrap(const hc_frame *frame, int axis, double metres) {
  const double period = (double)frame->period[axis] * frame->unit[axis];
  return period > 0.0 ? metres - period * floor(metres / period) : metres;
}

/* A box's edge covers a whole period. */
static bool is_whole(const hc_frame *frame, int axis, double edge) {
  const double period = (double)frame->period[axis] * frame->unit[axis];
  return period > 0.0 && edge >= (1.0 - 1e-9) * period;
}

bool hc_measure_in_box(const hc_scene_gauge *gauge, const hc_frame *frame, const int64_t position[3],
                       double x[3]) {
  for (int axis = 0; axis < 3; axis++) {
    const double low = gauge->box.min[axis], edge = gauge->box.max[axis] - low;
    x[axis] = hc_frame_to_metres(frame, axis, position[axis]);
    if (is_whole(frame, axis, edge)) continue;
    if (frame->period[axis] > 0) x[axis] = low + wrap(frame, axis, x[axis] - low);
    if (!(x[axis] >= low && x[axis] <= gauge->box.max[axis])) return false;
  }
  return true;
}

void hc_measure_point_pressure(const hc_gauges *gauges, int number, const hc_particles *fluid,
                               hc_sum sums[2]) {
  const double radius = gauges->state[number].radius;
  const hc_point at = hc_measure_point(gauges->frame, gauges->scene->output.gauges[number].at);
  for (int32_t i = 0; i < fluid->own; i++) {
    double offset[3];
    hc_measure_offset(gauges->frame, &fluid->position[3 * (size_t)i], &at, offset);
    if (fabs(offset[0]) >= radius) continue;
    const double weight = hc_kernel_shape(length(offset) / radius);
    if (weight == 0.0) continue;
    hc_sum_add(&sums[0], weight * (double)fluid->pressure[i]);
    hc_sum_add(&sums[1], weight);
  }
}

int hc_measure_axis(const hc_scene_gauge *gauge, int *sign) {
  for (int axis = 0; axis < 3; axis++) {
    *sign = gauge->axis & (unsigned)HC_FACE_PLUS_X << (2 * axis) ? 1 : -1;
    if (gauge->axis & (unsigned)(HC_FACE_MINUS_X | HC_FACE_PLUS_X) << (2 * axis)) return axis;
  }
  return -1;
}

void hc_measure_stand(const hc_scene *scene, const hc_scene_gauge *gauge, double at[3], double direction[3]) {
  int sign;
  const int axis = hc_measure_axis(gauge, &sign);
  for (int a = 0; a < 3; a++) {
    at[a] = gauge->at[a];
    direction[a] = a == axis ? sign : 0.0;
  }
  if (axis >= 0 || gauge->type != HC_GAUGE_HEIGHT) return;
  const double gravity = length(scene->gravity);
  direction[2] = 1.0;
  for (int a = 0; a < 3 && gravity > 0.0; a++) direction[a] = -scene->gravity[a] / gravity;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The weight of a wall's sample, `offset` from the gauge's point: those of a face lie half a spacing behind
 * it. */
static double patch_weight(const hc_gauges *gauges, int number, const double direction[3],
                           const double offset[3]) {
  if (fabs(dot(offset, direction)) > 0.75 * gauges->scene->particle_spacing) return 0.0;
  return hc_kernel_shape(length(offset) / gauges->state[number].radius);
}

/* Those that stand still, or those that move: these are measured where the scene puts them. */
static void add_area(const hc_gauges *gauges, int number, const hc_particles *boundary, hc_sum *sum) {
  const double spacing = gauges->scene->particle_spacing;
  double stand[3], direction[3];
  hc_measure_stand(gauges->scene, &gauges->scene->output.gauges[number], stand, direction);
  const hc_point at = hc_measure_point(gauges->frame, stand);
  const int64_t *places = boundary->reference ? boundary->reference : boundary->position;
  for (int32_t k = 0; k < boundary->own; k++) {
    if ((int)boundary->motion[k].scalar != gauges->state[number].wall) continue;
    if (boundary->faces && signbit(boundary->faces[k])) continue; /* an inner edge */
    double offset[3];
    hc_measure_offset(gauges->frame, &places[3 * (size_t)k], &at, offset);
    hc_sum_add(sum, spacing * spacing * patch_weight(gauges, number, direction, offset));
  }
}

void hc_measure_patch_area(const hc_gauges *gauges, int number, const hc_particles *boundary, hc_sum *sum) {
  add_area(gauges, number, boundary, sum);
  if (boundary->tail) add_area(gauges, number, boundary->tail, sum);
}

int64_t hc_measure_crossings(const hc_gauges *gauges, const hc_scene_gauge *gauge, const hc_particles *fluid,
                             double dt) {
  const hc_frame *frame = gauges->frame;
  int sign;
  const int normal = hc_measure_axis(gauge, &sign);
  const hc_point corner = hc_measure_point(frame, gauge->box.min);
  int64_t crossings = 0;
  for (int32_t i = 0; i < fluid->own; i++) {
    const double *velocity = &fluid->velocity[3 * (size_t)i];
    double offset[3];
    hc_measure_offset(frame, &fluid->position[3 * (size_t)i], &corner, offset);
    const double after = offset[normal], before = after - velocity[normal] * dt;
    if ((after >= 0.0) == (before >= 0.0)) continue;
    const double back = after / (after - before); /* share of the step since the crossing */
    bool within = true;
    for (int axis = 0; axis < 3; axis++) {
      const double edge = gauge->box.max[axis] - gauge->box.min[axis];
      if (axis == normal || is_whole(frame, axis, edge)) continue;
      const double at = wrap(frame, axis, offset[axis] - back * dt * velocity[axis]);
      within &= at >= 0.0 && at < edge;
    }
    if (within) crossings += after >= 0.0 ? sign : -sign;
  }
  return crossings;
}

/* Does a push on a face come from fluid that is not in front of it? Such pairs push the samples of an edge
 * out of their face. */
static bool is_round_corner(const hc_gauges *gauges, const double direction[3], const hc_wall_push *push) {
  static const double LEAST = 0.45; /* spacings */
  if (direction[0] == 0.0 && direction[1] == 0.0 && direction[2] == 0.0) return false;
  return dot(push->from, direction) > -LEAST * gauges->scene->particle_spacing;
}

/* The gauges that take pushes, and where. */
typedef struct taking {
  const hc_gauges *gauges;
  hc_sum *sums;
} taking;

/* Force and moment, or the force weighted around the gauge's point. */
static void add_push(void *context, const hc_wall_push *push) {
  const taking *taking = context;
  const hc_gauges *gauges = taking->gauges;
  const hc_scene *scene = gauges->scene;
  for (int g = 0; g < scene->output.gauge_count; g++) {
    const hc_scene_gauge *gauge = &scene->output.gauges[g];
    if (gauges->state[g].wall != push->wall) continue;
    hc_sum *to = taking->sums + gauges->state[g].first_sum;
    const hc_gauge_state *const state = &gauges->state[g];
    double arm[3];
    for (int axis = 0; axis < 3; axis++) { /* to the nearest image */
      const double period = (double)gauges->frame->period[axis] * gauges->frame->unit[axis];
      arm[axis] = push->by[axis] - push->from[axis] - state->at[axis];
      if (period > 0.0) arm[axis] -= period * rint(arm[axis] / period);
    }
    const double *f = push->force;
    const bool force = gauge->type == HC_GAUGE_FORCE;
    const double weight = force ? 1.0 : patch_weight(gauges, g, state->direction, arm);
    if (weight == 0.0 || (!force && is_round_corner(gauges, state->direction, push))) continue;
    for (int axis = 0; axis < 3; axis++) {
      hc_sum_add(&to[axis], weight * f[axis]);
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      if (force) hc_sum_add(&to[3 + axis], arm[b] * f[c] - arm[c] * f[b]);
    }
  }
}

void hc_measure_wall_push(const hc_gauges *gauges, const hc_sweep *sweep, double dt, hc_sum *sums) {
  const hc_scene *const scene = gauges->scene;
  bool *const wanted = hc_alloc_zero((size_t)hc_scene_surfaces(scene) + 1, sizeof *wanted);
  for (int g = 0; g < scene->output.gauge_count; g++)
    if (gauges->state[g].wall >= 0) wanted[gauges->state[g].wall] = true;
  hc_wall_force_each(sweep, gauges->frame, dt, wanted, false, add_push, &(taking){gauges, sums});
  hc_free(wanted);
}
