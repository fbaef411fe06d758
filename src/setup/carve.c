#include "carve.h"

#include "setup/trace.h"

#include <math.h>

static const double ROOM = 0.5;      /* spacings: as lattices keep from walls */
static const double AT_THIN = 1.0;   /* spacings: from what is thin */
static const double THICK = 0.4;     /* spacings inside: where samples are of what is not */
static const double rounding = 1e-3; /* spacings: what touches does not overlap */

double hc_carve_distance(const hc_frame *frame, const hc_setup_source *body, const double x[3]) {
  const hc_start *const start = &body->start;
  double nearest = INFINITY, first[3];
  for (int a = 0; a < 3; a++) { /* from the nearest image on */
    const double period = (double)frame->period[a] * frame->unit[a];
    first[a] = x[a] - start->to[a];
    if (period > 0.0) first[a] -= period * rint(first[a] / period);
  }
  for (int n = 0; n < 27; n++) {
    const int image[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    double arm[3], own[3];
    bool needed = true;
    for (int a = 0; a < 3; a++) {
      needed &= frame->period[a] > 0 || image[a] == 0;
      arm[a] = first[a] + image[a] * (double)frame->period[a] * frame->unit[a];
    }
    if (!needed) continue;
    for (int a = 0; a < 3; a++) /* turned back */
      own[a] = start->from[a] + start->turn[0][a] * arm[0] + start->turn[1][a] * arm[1] +
               start->turn[2][a] * arm[2];
    nearest = fmin(nearest, hc_shape_distance(&body->shape, own));
  }
  return nearest;
}

/* Is the body thin there? Where samples should be, half a spacing inside the surface nearest to x, which is
 * `off` outside. */
static bool is_thin(const hc_frame *frame, const hc_setup_source *body, const double x[3], double off) {
  const double spacing = hc_trace_spacing(frame), step = 0.01 * spacing;
  double slope[3], inside[3], length = 0.0;
  for (int a = 0; a < 3; a++) {
    double ahead[3] = {x[0], x[1], x[2]}, back[3] = {x[0], x[1], x[2]};
    ahead[a] += step;
    back[a] -= step;
    slope[a] = hc_carve_distance(frame, body, ahead) - hc_carve_distance(frame, body, back);
    length += slope[a] * slope[a];
  }
  length = sqrt(length);
  if (length == 0.0) return true;
  for (int a = 0; a < 3; a++) inside[a] = x[a] - (off + ROOM * spacing) * slope[a] / length;
  return hc_carve_distance(frame, body, inside) > -THICK * spacing;
}

/* A block before the bodies. */
typedef struct carving {
  const hc_frame *frame;
  const hc_setup_source *bodies;
  int count;
  double room, at_thin; /* m */
  hc_setup_source *block;
} carving;

static double clearance(const void *context, const double x[3]) {
  const carving *const c = context;
  double nearest = INFINITY;
  for (int k = 0; k < c->count; k++) nearest = fmin(nearest, hc_carve_distance(c->frame, &c->bodies[k], x));
  return nearest - c->at_thin;
}

static bool leave_out(void *context, int64_t k, const int64_t point[3], const double x[3]) {
  (void)point;
  const carving *const c = context;
  for (int b = 0; b < c->count; b++) {
    const double off = hc_carve_distance(c->frame, &c->bodies[b], x);
    if (off >= c->at_thin || (off >= c->room && !is_thin(c->frame, &c->bodies[b], x, off))) continue;
    hc_gaps_add(&c->block->gaps, k);
    break;
  }
  return true;
}

void hc_setup_carve(const hc_frame *frame, hc_setup_source *blocks, int block_count,
                    const hc_setup_source *bodies, int body_count) {
  if (body_count == 0) return;
  const double spacing = hc_trace_spacing(frame);
  carving c = {frame, bodies, body_count, (ROOM - rounding) * spacing, (AT_THIN - rounding) * spacing, NULL};
  for (int b = 0; b < block_count; b++) {
    c.block = &blocks[b];
    if (c.block->sampling.tile.at) continue; /* it fits itself, see fit.h */
    hc_trace_run(frame, &blocks[b].sampling, &(hc_trace){&c, clearance, leave_out});
  }
}
