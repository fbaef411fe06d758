/* Predictive-corrective incompressible SPH, see pcisph.c. */
#ifndef HC_PCISPH_H
#define HC_PCISPH_H

#include "solver.h"

typedef struct hc_pcisph_settings {
  hc_solver_settings common;
  double density_error_avg, density_error_max; /* fractions of the rest density */
  int density_min, density_max;                /* iterations */
  double gradient_square;                      /* sum |grad W|^2 over the rest lattice, 1/m8 */
  bool shepard;                                /* correct densities at the surface */
  int release_steps;                           /* that take the compression left by a longer one; 0: one */
  double friction, elasticity;                 /* of contacts with walls, see hc_collision */
  float wall_weights[HC_WALL_WEIGHTS + 1];     /* see hc_prediction */
} hc_pcisph_settings;

extern const hc_solver_ops hc_solver_pcisph;

#endif
