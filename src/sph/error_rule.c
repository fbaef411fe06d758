#include "error_rule.h"

#include <string.h>

hc_sum hc_error_sum(const hc_error_total *total) {
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  const int64_t mask = 0xffffffff;
  hc_sum_add(&sum, (double)(int64_t)(total->sum >> 64) * (0x1p64 / HC_ERROR_UNITS));
  hc_sum_add(&sum, (double)((int64_t)(total->sum >> 32) & mask) * (0x1p32 / HC_ERROR_UNITS));
  hc_sum_add(&sum, (double)((int64_t)total->sum & mask) / HC_ERROR_UNITS);
  if (total->not_finite) hc_sum_add(&sum, NAN);
  return sum;
}
