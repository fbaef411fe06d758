/* Totals of errors. */
#ifndef HC_ERROR_RULE_H
#define HC_ERROR_RULE_H

#include "sweeps.h"

#include <math.h>

static const double HC_ERROR_UNITS = 0x1p30;

/* Adds an error, which is not negative, to a total. */
static inline void hc_error_note(float size, hc_error_total *total) {
  if (!(size < 0x1p30f)) { /* a NaN too */
    total->not_finite = true;
    return;
  }
  total->sum += (int64_t)llrint((double)size * HC_ERROR_UNITS);
  if (size > total->max) total->max = size;
}

/* The nearest integer of a number below 2^51 in size, of halves the even one, in vectors of any kind: the sum
 * has the integer in its last bits. */
static inline uint64_t hc_to_integer(double value) {
  static const double SHIFT = 0x1.8p52;
  const double sum = value + SHIFT;
  uint64_t bits, zero;
  memcpy(&bits, &sum, sizeof bits);
  memcpy(&zero, &SHIFT, sizeof zero);
  return bits - zero;
}

/* Adds a block's errors to a total as hc_error_note does, those that are positive or the sizes of all: all at
 * once where all are small. */
static inline void hc_errors_note(bool both_ways, const float *errors, int32_t count, hc_error_total *total) {
  static const float SMALL = 0x1p20f;
  const float sign = both_ways ? -1.0f : 0.0f;
  float most = 0.0f;
  int32_t large = 0;
  uint64_t sum = 0;
  for (int32_t k = 0; k < count; k++) {
    const float other = sign * errors[k], size = errors[k] > other ? errors[k] : other;
    large |= !(errors[k] < SMALL && errors[k] > -SMALL);
    most = size > most ? size : most;
    sum += hc_to_integer((double)size * HC_ERROR_UNITS);
  }
  if (!large) {
    total->sum += (__int128)sum;
    total->max = most > total->max ? most : total->max;
    return;
  }
  for (int32_t k = 0; k < count; k++)
    hc_error_note(errors[k] > 0.0f || !(errors[k] <= 0.0f) ? errors[k] : sign * errors[k], total);
}

/* The sum as an exact sum, NaN if an error was not finite. */
hc_sum hc_error_sum(const hc_error_total *total);

#endif
