#include "isa.h"

#include <stdlib.h>
#include <string.h>

static const char *const names[HC_ISA_COUNT] = {"portable", "avx2", "avx512"};

hc_isa hc_isa_best(void) {
  hc_isa best = HC_ISA_PORTABLE;
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) best = HC_ISA_AVX2;
  if (best == HC_ISA_AVX2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw"))
    best = HC_ISA_AVX512;
#endif
  const char *wish = getenv("HALOCLINE_ISA");
  for (int isa = 0; wish && isa < (int)best; isa++)
    if (strcmp(wish, names[isa]) == 0) best = (hc_isa)isa;
  return best;
}

const char *hc_isa_name(hc_isa isa) {
  return names[isa];
}
