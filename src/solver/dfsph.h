/* Divergence-free SPH, see dfsph.c. */
#ifndef HC_DFSPH_H
#define HC_DFSPH_H

#include "solver.h"

typedef struct hc_dfsph_settings {
  hc_solver_settings common;
  double density_error_avg;                                     /* fraction of the rest density */
  double divergence_error;                                      /* fraction of the rest density per step */
  int density_min, density_max, divergence_min, divergence_max; /* iterations */
  double warm_start, relaxation;
  int min_divergence_neighbors;
  bool gap_rule;          /* see dfsph.c */
  bool fast;              /* the density solve goes along conjugate directions */
  double gradient_square; /* 1/m8: sum of |grad W|^2 in a full support at rest */
} hc_dfsph_settings;

extern const hc_solver_ops hc_solver_dfsph;

#endif
