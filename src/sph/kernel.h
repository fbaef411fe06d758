/* The cubic spline of sweeps.h in double precision, for what is found once or a few times a step: of
 * q = r/h, W = 8/(pi h^3) shape, grad W = 8/(pi h^4) slope_over_q (x/h). */
#ifndef HC_KERNEL_H
#define HC_KERNEL_H

#include <math.h>

static inline double hc_kernel_shape(double q) {
  const double outer = fmax(1.0 - q, 0.0), inner = fmax(0.5 - q, 0.0);
  return 2.0 * outer * outer * outer - 8.0 * inner * inner * inner;
}

/* (d shape/dq)/q, never positive. */
static inline double hc_kernel_slope_over_q(double q) {
  if (q >= 1.0) return 0.0;
  return q <= 0.5 ? -12.0 + 18.0 * q : -6.0 * (1.0 - q) * (1.0 - q) / q;
}

#endif
