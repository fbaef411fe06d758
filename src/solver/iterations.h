/* DFSPH's iterations for multipliers: the paper's (diagonal.c) and ones along conjugate directions
 * (conjugate.c). */
#ifndef HC_ITERATIONS_H
#define HC_ITERATIONS_H

#include "world/world.h"
#include "yield.h"

/* One of a step's two solves. */
typedef struct hc_solve {
  hc_world *world;
  hc_yield *yield;
  hc_error_rule rule;
  float weight;                  /* of velocity corrections: 1 or 1/dt */
  float *multiplier;             /* K or k; with the last step's to start from */
  float warm;                    /* share of these */
  bool rates_known;              /* dD/dt of all are there, from the density sweep */
  double threshold;              /* of the average error */
  int min, max;                  /* iterations */
  const hc_smoothing *smoothing; /* diagonal: what is found along with the errors; null: nothing */
} hc_solve;

typedef struct hc_solved {
  int iterations;
  bool capped;
  bool broken; /* the errors are no numbers, or beyond 2^30: stopped at once */
  double average, max;
  double follow; /* conjugate: share by which the next start follows what pressed */
} hc_solved;

/* Algorithms 3 and 4 of Carensac et al. 2023: each multiplier grows by alpha times its particle's error,
 * until the average error is below the threshold. Collective. */
hc_solved hc_solve_diagonal(const hc_solve *solve);

/* The density solve in fewer iterations, see conjugate.c: of densities a step of dt ahead. `alpha`, m2: of a
 * particle with a full support at rest. The multipliers are those that press now. Collective. */
hc_solved hc_solve_conjugate(const hc_solve *solve, double dt, double alpha);

/* Then makes them those that the next step starts from. Local; nothing may have used hc_particles_scratch of
 * the fluid in between. */
void hc_solve_remember(const hc_solve *solve, const hc_solved *solved);

#endif
