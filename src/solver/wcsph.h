/* Weakly compressible SPH, see wcsph.c. */
#ifndef HC_WCSPH_H
#define HC_WCSPH_H

#include "individual.h"

typedef struct hc_wcsph_settings {
  hc_weak_settings weak;
  hc_individual_settings individual; /* where steps are the particles' own */
} hc_wcsph_settings;

extern const hc_solver_ops hc_solver_wcsph;

#endif
