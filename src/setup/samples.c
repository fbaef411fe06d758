#include "samples.h"

#include "base/memory.h"

#include <math.h>

hc_status hc_setup_sample_numbers(const hc_setup_plan *plan, hc_sample_numbers *numbers, hc_error *error) {
  numbers->first = hc_alloc_zero((size_t)plan->fluid_sources + 1, sizeof *numbers->first);
  double all = 0.0;
  for (int k = 0; k < plan->fluid_sources; k++) {
    numbers->first[k] = (int64_t)all;
    all += (double)hc_sampling_count(&plan->fluid[k].sampling);
    if (!(all < (double)HC_ID_MAX_COUNTER))
      return hc_error_set(
          error, HC_BAD_INPUT,
          "fluid.blocks must have fewer than 2^%d samples together where walls absorb or a window "
          "goes along",
          HC_ID_COUNTER_BITS);
  }
  numbers->count = (int64_t)fmax(all, 1.0);
  return HC_OK;
}
