/* Damped steps that let fluid come to rest: the solver's own, which lose a share of all velocity before
 * anything moves (Carensac et al. 2023, section 3.3). Bodies and walls stand still; so do particles whose ids
 * are of kind HC_ID_HELD, which keep their density and pressure. */
#ifndef HC_RELAX_H
#define HC_RELAX_H

#include "solver/solver.h"

/* A run's world and what advances it; the caller's. */
typedef struct hc_resting {
  hc_world *world;
  hc_bodies *bodies; /* stand still */
  const hc_solver_ops *solver;
  hc_solver_settings *settings;
  hc_step_report *report; /* of the last step, which `evaluate` may read */
  double spacing;         /* m */
} hc_resting;

typedef struct hc_relaxing {
  double dt;                         /* s */
  int steps;                         /* at most */
  double damping_start, damping_end; /* shares of the velocity that the first and the last step take */
  double speed_max, speed_avg;       /* half spacings a step: at rest none is faster, nor their mean */
  double density_error_avg;          /* the solver's meanwhile, where it has one; 0: as it is */
  int iterations;                    /* density iterations of a step at most, likewise */
} hc_relaxing;

/* What it came to. */
typedef struct hc_relaxed {
  int steps;
  double speed_max, speed_avg; /* half spacings a step: of the last one, before it was damped */
  bool at_rest;
} hc_relaxed;

/* Steps until the fluid is at rest, or so many are done; then all velocities are 0, and cells and lists
 * stale. Collective; HC_FAILED, agreed, where a step fails. */
hc_status hc_relax(const hc_resting *resting, const hc_relaxing *how, hc_relaxed *result, hc_error *error);

#endif
