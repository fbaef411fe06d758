#include "flow.h"

#include "base/check.h"
#include "base/turns.h"

#include <math.h>

/* e^x, to about 1e-15: the series of a small share of x, squared as often as needed. */
static double exponential(double x) {
  int halvings = 0;
  while (fabs(x) > 0.25) {
    x /= 2;
    halvings++;
  }
  double series = 1;
  for (int k = 14; k >= 1; k--) series = 1 + series * x / k;
  for (; halvings > 0; halvings--) series *= series;
  return series;
}

void hc_flow_add(const hc_flow *flow, const double x[3], double velocity[3]) {
  switch (flow->type) {
  case HC_FLOW_NONE:
    return;
  case HC_FLOW_TAYLOR_GREEN: {
    const double at_x = x[0] / flow->length, at_y = x[1] / flow->length;
    velocity[0] -= flow->speed * hc_turns_cosine(at_x) * hc_turns_sine(at_y);
    velocity[1] += flow->speed * hc_turns_sine(at_x) * hc_turns_cosine(at_y);
    return;
  }
  case HC_FLOW_STANDING_WAVE: {
    const double k = 2 * 3.14159265358979323846 / flow->length, at_x = x[0] / flow->length;
    const double rise = exponential(k * x[2]), bottom = exponential(k * flow->depth);
    const double scale = flow->speed / (bottom - 1 / bottom);
    velocity[0] += scale * (rise + 1 / rise) * hc_turns_sine(at_x);
    velocity[2] -= scale * (rise - 1 / rise) * hc_turns_cosine(at_x);
    return;
  }
  }
  HC_CHECK(false, "unknown flow %d", (int)flow->type);
}
