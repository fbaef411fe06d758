#include "fit.h"

#include "setup/carve.h"
#include "setup/trace.h"

#include <math.h>

/* How far inside the fluid's side of everything x is, m; negative: behind something. Changes by no more than
 * x moves. */
static double room_at(const hc_fit *fit, const double x[3]) {
  const double half = 0.5 * hc_trace_spacing(fit->frame);
  double room = INFINITY, contained = -INFINITY;
  bool containers = false;
  for (int k = 0; k < fit->walls; k++) {
    const hc_setup_source *const wall = &fit->surfaces[k];
    if (hc_sampling_count(&wall->sampling) == 0) continue;
    room = fmin(room, hc_source_layer_distance(fit->frame, wall, x) - half);
    if (wall->solid) {
      room = fmin(room, hc_trace_distance(fit->frame, hc_shape_distance, &wall->shape, x));
      continue;
    }
    containers = true;
    contained = fmax(contained, -hc_trace_distance(fit->frame, hc_shape_region_distance, &wall->shape, x));
  }
  if (containers) room = fmin(room, contained);
  for (int k = fit->walls; k < fit->walls + fit->bodies; k++)
    room = fmin(room, hc_carve_distance(fit->frame, &fit->surfaces[k], x));
  return room - fit->distance;
}

typedef struct fitting {
  const hc_fit *fit;
  hc_setup_source *block, *air;
  double margin;           /* m: of air around the block */
  bool whole[3];           /* the block fills that axis' period */
  int64_t low[3], high[3]; /* units: then it ends so */
} fitting;

static void leave_out(hc_setup_source *source, int64_t first, int64_t end) {
  for (int64_t k = first; k < end; k++) hc_gaps_add(&source->gaps, k);
}

static void to_metres(const hc_frame *frame, const int64_t point[3], double x[3]) {
  for (int a = 0; a < 3; a++) x[a] = hc_frame_to_metres(frame, a, point[a]);
}

/* From x to the block itself, not to its images, so that no place is filled twice; along an axis that it
 * fills all around there are no ends. */
static double off_block(const fitting *f, const double x[3]) {
  const hc_shape *const shape = &f->block->shape;
  double at[3];
  for (int a = 0; a < 3; a++) at[a] = f->whole[a] ? shape->centre[a] : x[a];
  return hc_shape_distance(shape, at);
}

static bool within_period(const fitting *f, const int64_t point[3]) {
  bool within = true;
  for (int a = 0; a < 3; a++) within &= !f->whole[a] || (point[a] >= f->low[a] && point[a] < f->high[a]);
  return within;
}

/* Is x nearer to the block than to its next image? Air that is not lies on the other side's fluid or air. */
static bool is_on_this_side(const fitting *f, const double x[3]) {
  bool here = true;
  for (int a = 0; a < 3; a++) {
    const double half = 0.5 * (double)f->fit->frame->period[a] * f->fit->frame->unit[a],
                 off = x[a] - f->block->shape.centre[a];
    here &= half == 0.0 || f->whole[a] || (off >= -half && off < half);
  }
  return here;
}

static void look_at(fitting *f, int64_t k) {
  int64_t point[3];
  double x[3];
  hc_sampling_point(&f->block->sampling, k, point);
  to_metres(f->fit->frame, point, x);
  const double off = off_block(f, x), room = room_at(f->fit, x);
  const bool stays = within_period(f, point) && off <= f->margin && room >= 0.0;
  /* a block that ends at a wall reaches behind its surface, where that is allowed */
  const bool fluid = off <= (room + f->fit->distance < 0.0 ? -f->fit->distance : 0.0);
  if (!stays || !fluid) hc_gaps_add(&f->block->gaps, k);
  if (!stays || fluid || !is_on_this_side(f, x)) hc_gaps_add(&f->air->gaps, k);
}

/* The points of an image: all, none, or some. */
static void look_at_image(fitting *f, int64_t first, int64_t end, const double middle[3], double reach) {
  const double off = off_block(f, middle);
  bool ends = false; /* a period ends within it */
  for (int a = 0; a < 3; a++) {
    const double unit = f->fit->frame->unit[a];
    const double from_low = middle[a] - hc_frame_to_metres(f->fit->frame, a, f->low[a]),
                 to_high = hc_frame_to_metres(f->fit->frame, a, f->high[a]) - middle[a];
    ends |= f->whole[a] && !(from_low > reach + unit && to_high > reach + unit);
  }
  if (off > f->margin + reach) {
    leave_out(f->block, first, end);
    leave_out(f->air, first, end);
  } else if (!ends && off < -reach && room_at(f->fit, middle) > reach) {
    leave_out(f->air, first, end);
  } else {
    for (int64_t k = first; k < end; k++) look_at(f, k);
  }
}

hc_fit hc_setup_fit_of(const hc_scene *scene, const hc_frame *frame, const hc_setup_source *surfaces) {
  return (hc_fit){.frame = frame,
                  .surfaces = surfaces,
                  .walls = scene->boundary.wall_count,
                  .bodies = scene->body_count,
                  .distance = scene->fluid.rest.distance * scene->particle_spacing};
}

void hc_setup_fit(const hc_fit *fit, hc_setup_source *block, hc_setup_source *air) {
  const hc_sampling *const sampling = &block->sampling;
  const hc_frame *const frame = fit->frame;
  *air = *block;
  air->kind = HC_ID_AIR;
  fitting f = {.fit = fit, .block = block, .air = air, .margin = frame->support_radius};
  double square = 0.0;
  for (int a = 0; a < 3; a++) {
    const double half = 0.5 * (double)sampling->tile_step[a] * frame->unit[a];
    square += half * half;
    f.low[a] = sampling->tile_low[a];
    f.high[a] = f.low[a] + frame->period[a];
    f.whole[a] = hc_source_fills_period(frame, block, a);
  }
  const double reach = sqrt(square) + hc_trace_spacing(frame);
  for (int64_t k = 0, end; k < sampling->count; k = end) {
    double middle[3];
    hc_sampling_image(sampling, k, middle, &end);
    for (int a = 0; a < 3; a++) middle[a] = (middle[a] - (double)frame->origin[a]) * frame->unit[a];
    look_at_image(&f, k, end, middle, reach);
  }
}
