#include "flow.h"

#include "base/check.h"

#include <math.h>

/* sin(2 pi t), to about 1e-16: t is reduced to a quarter turn, where the series needs ten terms. */
static double sine_of_turns(double t) {
  const double turn = t - rint(t); /* in [-1/2, 1/2] */
  const double quarter = turn > 0.25 ? 0.5 - turn : turn < -0.25 ? -0.5 - turn : turn;
  const double angle = 2 * 3.14159265358979323846 * quarter;
  double series = 1;
  for (int k = 10; k >= 1; k--) series = 1 - series * angle * angle / (2 * k * (2 * k + 1));
  return angle * series;
}

static double cosine_of_turns(double t) {
  return sine_of_turns(t - rint(t) + 0.25);
}

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
    velocity[0] -= flow->speed * cosine_of_turns(at_x) * sine_of_turns(at_y);
    velocity[1] += flow->speed * sine_of_turns(at_x) * cosine_of_turns(at_y);
    return;
  }
  case HC_FLOW_STANDING_WAVE: {
    const double k = 2 * 3.14159265358979323846 / flow->length, at_x = x[0] / flow->length;
    const double rise = exponential(k * x[2]), bottom = exponential(k * flow->depth);
    const double scale = flow->speed / (bottom - 1 / bottom);
    velocity[0] += scale * (rise + 1 / rise) * sine_of_turns(at_x);
    velocity[2] -= scale * (rise - 1 / rise) * cosine_of_turns(at_x);
    return;
  }
  }
  HC_CHECK(false, "unknown flow %d", (int)flow->type);
}
