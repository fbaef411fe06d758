/* Bounds without a call of the mathematics library, which loops over particles would make each time. */
#ifndef HC_CLAMP_H
#define HC_CLAMP_H

/* x, but at least low and at most high; low if x is no number. */
static inline double hc_clamp(double x, double low, double high) {
  const double raised = x > low ? x : low;
  return raised < high ? raised : high;
}

#endif
