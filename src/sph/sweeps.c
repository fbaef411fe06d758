#include "sweeps.h"

#include "base/check.h"

#include <math.h>

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

hc_eddies hc_eddies_of(double viscosity, double mixing_length, double support_radius, double dt) {
  static const double MOST = 1.0 / 25.0;
  const double h = support_radius, molecular = viscosity * dt / (h * h), length = mixing_length / h;
  return (hc_eddies){.molecular = (float)molecular,
                     .scale = (float)(length * length * dt / h),
                     .most = (float)fmax(0.0, MOST - molecular)};
}
