#include "carve.h"

#include "setup/trace.h"

#include <math.h>

static const double ROOM = 0.5;      /* spacings: as lattices keep from walls */
static const double rounding = 1e-3; /* spacings: what touches does not overlap */

double hc_carve_distance(const hc_frame *frame, const hc_setup_source *body, const double x[3]) {
  const hc_start *const start = &body->start;
  double nearest = INFINITY;
  for (int n = 0; n < 27; n++) {
    const int image[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    double arm[3], own[3];
    bool needed = true;
    for (int a = 0; a < 3; a++) {
      needed &= frame->period[a] > 0 || image[a] == 0;
      arm[a] = x[a] + image[a] * (double)frame->period[a] * frame->unit[a] - start->to[a];
    }
    if (!needed) continue;
    for (int a = 0; a < 3; a++) /* turned back */
      own[a] = start->from[a] + start->turn[0][a] * arm[0] + start->turn[1][a] * arm[1] +
               start->turn[2][a] * arm[2];
    nearest = fmin(nearest, hc_shape_distance(&body->shape, own));
  }
  return nearest;
}

/* A block before the bodies. */
typedef struct carving {
  const hc_frame *frame;
  const hc_setup_source *bodies;
  int count;
  double room; /* m */
  hc_setup_source *block;
} carving;

static double clearance(const void *context, const double x[3]) {
  const carving *const c = context;
  double nearest = INFINITY;
  for (int k = 0; k < c->count; k++) nearest = fmin(nearest, hc_carve_distance(c->frame, &c->bodies[k], x));
  return nearest - c->room;
}

static bool leave_out(void *context, int64_t k, const int64_t point[3], const double x[3]) {
  (void)point;
  (void)x;
  const carving *const c = context;
  hc_gaps_add(&c->block->gaps, k);
  return true;
}

void hc_setup_carve(const hc_frame *frame, hc_setup_source *blocks, int block_count,
                    const hc_setup_source *bodies, int body_count) {
  if (body_count == 0) return;
  carving c = {frame, bodies, body_count, (ROOM - rounding) * hc_trace_spacing(frame), NULL};
  for (int b = 0; b < block_count; b++) {
    c.block = &blocks[b];
    hc_trace_run(frame, &blocks[b].sampling, &(hc_trace){&c, clearance, leave_out});
  }
}
