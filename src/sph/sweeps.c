#include "sweeps.h"

#include "base/check.h"
#include "error_rule.h"

const hc_sweeps *hc_sweeps_of(hc_isa isa) {
#if defined(__x86_64__)
  if (isa == HC_ISA_AVX2) return hc_sweeps_avx2();
  if (isa == HC_ISA_AVX512) return hc_sweeps_avx512();
#endif
  HC_CHECK(isa == HC_ISA_PORTABLE, "instruction set %d is not for this processor", isa);
  return hc_sweeps_portable();
}

hc_sweep hc_sweep_make(const hc_frame *frame, double volume, double rest_density) {
  const double h = frame->support_radius;
  const double sigma = 8.0 / 3.14159265358979323846;
  hc_sweep sweep = {.support = (float)h,
                    .volume = (float)volume,
                    .kernel = (float)(sigma / (h * h * h)),
                    .gradient = (float)(sigma / (h * h * h * h)),
                    .rest_density = (float)rest_density,
                    .wall_offset = (float)(0.5 * (double)frame->spacing[0] * frame->unit[0] / h)};
  for (int axis = 0; axis < 3; axis++) sweep.scale[axis] = (float)(frame->unit[axis] / h);
  return sweep;
}

void hc_error_from_rate(const hc_sweep *sweep, const hc_error_rule *rule, hc_selection selection,
                        hc_error_total *total) {
  const float per_density = 1.0f / sweep->rest_density;
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    hc_error_apply(sweep, rule, per_density, row, i, sweep->fluid->place[i].scalar, total);
  }
}

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
