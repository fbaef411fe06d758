/* The frame: how metres map to the unbounded cell grid.
 *
 * A position is three int64_t in units of 2^-28 cell edges; a cell edge is the support radius and a margin
 * or, along a periodic axis, stretched (at most 10 %) so that the period is a whole number of cells. Scene
 * coordinates are metres from the corner of cell `origin_cells`; along periodic axes positions lie in [low,
 * low + period). */
#ifndef HC_FRAME_H
#define HC_FRAME_H

#include <stdbool.h>
#include <stdint.h>

enum { HC_CELL_BITS = 28 };
#define HC_CELL_UNITS ((int64_t)1 << HC_CELL_BITS)

typedef struct hc_frame {
  double unit[3];        /* metres per unit along each axis */
  double support_radius; /* m; never above a cell edge */
  double margin;         /* m: by which cells are wider than that, at least; lists reach as far */
  int64_t spacing[3];    /* the particle spacing in units, even */
  int64_t origin[3];     /* the scene's origin, in units: a cell corner along open axes */
  int64_t period[3];     /* periodic length in units, a whole number of cells; 0 = open */
  int64_t low[3];        /* periodic axes: lower end of the domain, in units: a cell corner */
} hc_frame;

/* Nearest unit of a scene coordinate. */
static inline int64_t hc_frame_to_units(const hc_frame *frame, int axis, double metres) {
  return frame->origin[axis] + (int64_t)__builtin_llrint(metres / frame->unit[axis]);
}

static inline double hc_frame_to_metres(const hc_frame *frame, int axis, int64_t units) {
  return (double)(units - frame->origin[axis]) * frame->unit[axis];
}

/* The cell that holds a coordinate (rounds down, also below zero). */
static inline int64_t hc_frame_cell(int64_t units) {
  return units >> HC_CELL_BITS;
}

/* Brings a coordinate into [low, low + period) along a periodic axis. */
static inline int64_t hc_frame_wrap(const hc_frame *frame, int axis, int64_t units) {
  const int64_t period = frame->period[axis];
  if (period == 0) return units;
  const int64_t offset = (units - frame->low[axis]) % period;
  return frame->low[axis] + (offset < 0 ? offset + period : offset);
}

#endif
