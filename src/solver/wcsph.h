/* Weakly compressible SPH, see wcsph.c. */
#ifndef HC_WCSPH_H
#define HC_WCSPH_H

#include "solver.h"

typedef struct hc_wcsph_settings {
  hc_solver_settings common;
  hc_tait tait;
  double sound_speed; /* m/s */
  double fluctuation; /* permitted on average, a fraction of the rest density */
  double longest;     /* s: the longest step that is stable */
} hc_wcsph_settings;

extern const hc_solver_ops hc_solver_wcsph;

#endif
