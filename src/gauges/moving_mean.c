#include "moving_mean.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* The newest share, and those of the time before it. */
enum { ROOM = HC_MOVING_MEAN_SHARES + 1 };

void hc_moving_mean_init(hc_moving_mean *mean, double time, int columns) {
  *mean = (hc_moving_mean){.share = fmax(time / HC_MOVING_MEAN_SHARES, DBL_MIN), /* none of length 0 */
                           .columns = columns,
                           .integrals = hc_alloc_zero((size_t)ROOM * (size_t)columns, sizeof(double))};
}

void hc_moving_mean_free(hc_moving_mean *mean) {
  hc_free(mean->integrals);
  memset(mean, 0, sizeof *mean);
}

void hc_moving_mean_register(hc_moving_mean *mean, hc_state *state, int gauge) {
  hc_state_add(state, HC_TYPE_f64, ROOM * mean->columns, mean->integrals, "gauges.%d.shares", gauge);
  hc_state_add(state, HC_TYPE_f64, 1, &mean->filled, "gauges.%d.filled", gauge);
  hc_state_add(state, HC_TYPE_i64, 1, &mean->newest, "gauges.%d.newest", gauge);
}

static double *integral_of(const hc_moving_mean *mean, int64_t share) {
  return mean->integrals + (size_t)(share % ROOM) * (size_t)mean->columns;
}

static void begin_share(hc_moving_mean *mean) {
  mean->newest++;
  mean->filled = 0.0;
  memset(integral_of(mean, mean->newest), 0, (size_t)mean->columns * sizeof(double));
}

void hc_moving_mean_add(hc_moving_mean *mean, double dt, const double *integral) {
  double rest = fmin(dt, 2 * ROOM * mean->share); /* what is earlier is forgotten anyway */
  while (rest > 0.0) {
    const double room = mean->share - mean->filled, part = fmin(rest, room);
    double *const to = integral_of(mean, mean->newest);
    for (int k = 0; k < mean->columns; k++) to[k] += part / dt * integral[k];
    mean->filled += part;
    rest -= part;
    if (part == room) begin_share(mean);
  }
}

void hc_moving_mean_read(const hc_moving_mean *mean, double *values) {
  const bool passed = mean->newest >= HC_MOVING_MEAN_SHARES; /* is the time less than the run's? */
  const int64_t oldest = passed ? mean->newest - HC_MOVING_MEAN_SHARES : 0;
  const double left = passed ? 1.0 - mean->filled / mean->share : 1.0; /* of the oldest share */
  const double time =
      passed ? HC_MOVING_MEAN_SHARES * mean->share : (double)mean->newest * mean->share + mean->filled;
  for (int k = 0; k < mean->columns; k++) {
    double sum = left * integral_of(mean, oldest)[k];
    for (int64_t share = oldest + 1; share <= mean->newest; share++) sum += integral_of(mean, share)[k];
    values[k] = time > 0.0 ? sum / time : 0.0;
  }
}
