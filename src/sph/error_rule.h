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

/* The sum as an exact sum, NaN if an error was not finite. */
hc_sum hc_error_sum(const hc_error_total *total);

#endif
