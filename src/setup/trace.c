#include "trace.h"

#include <math.h>

/* Of spacings, between neighbours in a row: see hc_sampling_row_end. */
static const double longest_step = 1.5 * (1 + 1e-6);

double hc_trace_spacing(const hc_frame *frame) {
  return (double)frame->spacing[0] * frame->unit[0];
}

void hc_trace_part(const hc_frame *frame, const hc_sampling *sampling, int64_t first, int64_t end,
                   const hc_trace *trace) {
  const double step = longest_step * hc_trace_spacing(frame);
  for (int64_t k = first; k < end;) {
    int64_t point[3];
    double x[3];
    hc_sampling_point(sampling, k, point);
    for (int a = 0; a < 3; a++) x[a] = hc_frame_to_metres(frame, a, point[a]);
    const double clear = trace->clearance(trace->context, x);
    if (clear <= 0 && !trace->found(trace->context, k, point, x)) return;
    const int64_t row_end = hc_sampling_row_end(sampling, k);
    const double passed = fmax(1, ceil(clear / step));
    k = passed < (double)(row_end - k) ? k + (int64_t)passed : row_end;
  }
}

void hc_trace_run(const hc_frame *frame, const hc_sampling *sampling, const hc_trace *trace) {
  hc_trace_part(frame, sampling, 0, hc_sampling_count(sampling), trace);
}

double hc_trace_distance(const hc_frame *frame, double (*distance)(const hc_shape *shape, const double x[3]),
                         const hc_shape *shape, const double x[3]) {
  double period[3];
  for (int a = 0; a < 3; a++) period[a] = (double)frame->period[a] * frame->unit[a];
  return hc_shape_nearest_image(distance, shape, period, x);
}
