/* Finding the few samples of a source that are near something, without looking at all of them.
 *
 * Method: a clearance says how far a point may move before it can be near; along a row of samples, as many
 * are passed over. A source of n samples costs about its rows and what is found, not n. Local. */
#ifndef HC_TRACE_H
#define HC_TRACE_H

#include "geometry/sampling.h"
#include "space/frame.h"

typedef struct hc_trace {
  void *context;
  /* Metres that `x` may move before it is near; <= 0: it is. */
  double (*clearance)(const void *context, const double x[3]);
  /* Called for each sample that is near, ascending: its index, place in units and in metres. False ends. */
  bool (*found)(void *context, int64_t k, const int64_t point[3], const double x[3]);
} hc_trace;

/* All samples, or those from `first` to before `end`. */
void hc_trace_part(const hc_frame *frame, const hc_sampling *sampling, int64_t first, int64_t end,
                   const hc_trace *trace);
void hc_trace_run(const hc_frame *frame, const hc_sampling *sampling, const hc_trace *trace);

/* The particle spacing, m. */
double hc_trace_spacing(const hc_frame *frame);

/* The smallest value of a distance to `shape` over `x` and its periodic images. */
double hc_trace_distance(const hc_frame *frame, double (*distance)(const hc_shape *shape, const double x[3]),
                         const hc_shape *shape, const double x[3]);

#endif
