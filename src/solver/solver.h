/* The solvers: one step of a run each, behind one table of operations, chosen by name. */
#ifndef HC_SOLVER_H
#define HC_SOLVER_H

#include "fault.h"

typedef enum hc_viscous_force {
  HC_VISCOUS_NONE,
  HC_VISCOUS_XSPH,
  HC_VISCOUS_ARTIFICIAL,
  HC_VISCOUS_LAMINAR
} hc_viscous_force;

typedef struct hc_solver_settings {
  double gravity[3];
  double rest_density;
  hc_viscous_force viscosity;
  double viscosity_coefficient; /* xsph: share; artificial: alpha; laminar: m2/s */
  double sound_speed;           /* artificial: m/s */
  /* DFSPH */
  double density_error_avg;                                     /* fraction of the rest density */
  double divergence_error;                                      /* fraction of the rest density per step */
  int density_min, density_max, divergence_min, divergence_max; /* iterations */
  double warm_start, relaxation;
  int min_divergence_neighbors;
  bool negative_pressure;
} hc_solver_settings;

/* What a step says of itself; the same on every rank. */
typedef struct hc_step_report {
  int density_iterations, divergence_iterations;
  bool density_capped, divergence_capped;
  double density_error_avg,
      density_error_max;                   /* fractions of the rest density, predicted for the step's end */
  double v_max, a_max;                     /* m/s, m/s2: at the end of, and averaged over, the step */
  double force_max;                        /* m/s2: non-pressure forces, for the choice of the next step */
  double kinetic_energy, potential_energy; /* J; potential about the scene's origin */
  int64_t contacts;                        /* particles that a wall's contact held */
  hc_fault fault;                          /* why the step failed */
} hc_step_report;

typedef struct hc_solver_ops {
  const char *name;
  /* Advances own particles by dt; dt_before is the last step's, 0 at the first. Collective.
   * Before: hc_world_update. After: positions, velocities, pressures new; cells and lists stale.
   * HC_FAILED, agreed, as fault.h says; the fault is in the report then, and velocities, densities, pressures
   * and accelerations are those it was found with, positions those of the step's beginning. */
  hc_status (*step)(hc_world *world, const hc_solver_settings *settings, double dt, double dt_before,
                    hc_step_report *report, hc_error *error);
} hc_solver_ops;

extern const hc_solver_ops hc_solver_dfsph;

/* Shared by the solvers (motion.c). */

/* Non-pressure forces: v += dt (gravity + viscosity), ghosts refreshed. Ghost velocities and, for xsph,
 * inverse densities must be current. Collective. */
void hc_apply_forces(hc_world *world, const hc_solver_settings *settings, double dt, hc_step_report *report);

/* Remembers velocities, so that hc_move can tell accelerations. Local. */
void hc_remember_velocities(hc_world *world);

/* Wall contacts, then x += dt v for own particles, periodic axes wrapped; velocities, accelerations, energies
 * into the report. `broken`, the same on every rank: the pressure found no end, and the step fails.
 * Collective; HC_FAILED as hc_solver_ops.step says. */
hc_status hc_move(hc_world *world, const hc_solver_settings *settings, double dt, bool broken,
                  hc_step_report *report, hc_error *error);

#endif
