/* The solvers: one step of a run each, behind one table of operations, chosen by name.
 *
 * A solver gives in its hc_solver_ops:
 *   required   name, walls, step, densities
 *   optional   features    default: no fields but those that all have
 *              walls_why   with walls that leave out any
 *              compressible  default: it is not
 *              squared_walls  default: wall densities are plain sums
 *              controls    default: any step control, and the scene's default one
 *              steadier    default: none
 *              goes_back   default: as many as the step control does
 *              check_start default: any start will do
 *              reach       default: as far as the frame's margin
 *              evaluate    default: what acts hangs on the step
 *              effort      default: none that others may change
 *              describe, doubt, summary  default: nothing to say
 * Its settings begin with the common ones. */
#ifndef HC_SOLVER_H
#define HC_SOLVER_H

#include "fault.h"
#include "rigid/bodies.h"

typedef enum hc_viscous_force {
  HC_VISCOUS_NONE,
  HC_VISCOUS_XSPH,
  HC_VISCOUS_ARTIFICIAL,
  HC_VISCOUS_LAMINAR,
  HC_VISCOUS_SMAGORINSKY
} hc_viscous_force;

/* What every solver heeds; the first member of its own settings. */
typedef struct hc_solver_settings {
  double gravity[3];
  double centre[3], central_rate; /* m, rad/s: beside gravity rate^2 (centre - x); 0: nothing */
  double rest_density;
  hc_viscous_force viscosity;
  double viscosity_coefficient; /* xsph: share; artificial: alpha; laminar: m2/s */
  double sound_speed;           /* artificial: m/s */
  double mixing_length;         /* smagorinsky: C_s times the spacing, m */
  double kinematic_viscosity;   /* m2/s: of friction at walls, and of smagorinsky beside its eddies */
  bool depth_pressure;          /* see wall_layer.h */
  double surface_tension;       /* kappa of Becker and Teschner 2007, m3/s2; 0: none */
  bool negative_pressure;
} hc_solver_settings;

/* How that viscosity acts at walls; see hc_sweep. Local. */
hc_wall_drag hc_solver_wall_drag(const hc_solver_settings *settings, double support_radius);

/* What moving adds up: on one rank, until hc_move_note's tally is reduced. */
typedef struct hc_moved {
  hc_sum energy[2];                 /* sums of v^2, and of minus the potential */
  double v2_max, a2_max, force_max; /* force_max as in the report */
} hc_moved;

/* What a step says of itself; the same on every rank. */
typedef struct hc_step_report {
  int density_iterations, divergence_iterations;
  bool density_capped, divergence_capped;
  double density_error_avg,
      density_error_max;                   /* fractions of the rest density, predicted for the step's end */
  double v_max, a_max;                     /* m/s, m/s2: at the end of, and averaged over, the step */
  double force_max;                        /* m/s2: for the choice of the next step: non-pressure forces;
                                              PCISPH: all but contacts */
  double kinetic_energy, potential_energy; /* J; potential about the scene's origin */
  int64_t contacts;                        /* particles that a wall's contact held */
  int substeps;                            /* with individual steps: of this one, else 0; and */
  int64_t evaluated;                       /* how often particles were active in them, all together */
  hc_fault fault;                          /* why the step failed */
  hc_moved moved;
} hc_step_report;

/* Steps of a run in which a pressure solver was at its cap of iterations. */
typedef struct hc_solver_caps {
  int64_t density, divergence, steps; /* of so many */
} hc_solver_caps;

/* When density iterations end: below an average error, or after so many. */
typedef struct hc_solver_effort {
  double *error_avg;
  int *most;
} hc_solver_effort;

typedef struct hc_solver_ops {
  const char *name;
  unsigned features;     /* HC_FOR_*: the fields it needs */
  unsigned walls;        /* 1u << HC_WALLS_*: the boundary methods it works with */
  const char *walls_why; /* it does not with others, for messages */
  bool compressible;     /* see hc_sweep */
  bool squared_walls;    /* it works where wall densities go with the square, too */
  const char *const
      *controls;        /* names of the step controls it works with, null-ended; the first by default */
  const char *steadier; /* the one to advise where the pressure does not converge */
  int goes_back; /* steps taken back at once, at least, where the control takes back any: 2 where the step
                    before the one that diverges may have spoilt the state */

  /* How far lists must reach beyond the support in a step of dt, m, given what the last one reported. Local.
   */
  double (*reach)(const hc_solver_settings *settings, const hc_step_report *report, double dt);
  /* Finds what acts as a step begins, of whatever length: densities, accelerations; into the report, the same
   * on every rank, v_max, force_max, the largest acceleration, and the density errors. Collective. Before:
   * hc_world_update. */
  void (*evaluate)(hc_world *world, const hc_solver_settings *settings, hc_step_report *report);
  /* Advances own particles by dt; dt_before is the last step's, 0 at the first. `bodies` (null: all stand
   * still) show the velocities with which they yield meanwhile; they are moved by others. Collective.
   * Before: hc_world_update, and evaluate where there is one. After: positions, velocities, pressures new;
   * cells and lists stale; speeds, forces and energies are in the report behind hc_move_report. HC_FAILED,
   * agreed, as fault.h says; the fault is in the report then, and velocities, densities, pressures and
   * accelerations are those it was found with, positions those of the step's beginning. */
  hc_status (*step)(hc_world *world, hc_bodies *bodies, const hc_solver_settings *settings, double dt,
                    double dt_before, hc_step_report *report, hc_error *error);
  /* Fills densities (and what goes with them) at the present positions, as steps do. Collective. Before:
   * hc_world_update. */
  void (*densities)(hc_world *world, const hc_solver_settings *settings);

  /* Where it says when its density iterations end, for others to change. Local. */
  hc_solver_effort (*effort)(hc_solver_settings *settings);

  /* Refuses a start that it cannot go on from. Collective. Before: `densities`. HC_BAD_INPUT, agreed. */
  hc_status (*check_start)(const hc_world *world, const hc_solver_settings *settings, hc_error *error);

  /* A line for the log at the start of a run; a warning behind a step, if there is something to warn of; and
   * a line at the end. Local. */
  void (*describe)(const hc_solver_settings *settings, char *text, size_t size);
  bool (*doubt)(const hc_solver_settings *settings, const hc_step_report *report, char *text, size_t size);
  void (*summary)(const hc_solver_caps *caps, char *text, size_t size);
} hc_solver_ops;

/* Does it work with the step control of that name? Local. */
bool hc_solver_works_with(const hc_solver_ops *solver, const char *control);

/* For hc_solver_ops.check_start: refuses a free surface where pressures may be negative, and fluid that is
 * squeezed from the start by more than the share `most` of its rest density, as where it is too near to a
 * wall: the pressure that pushes it apart in one step knows no bounds. `key`: the scene key that allows so
 * much, for the message, or "". Collective; HC_BAD_INPUT, agreed. */
hc_status hc_solver_check_density(const hc_world *world, const hc_solver_settings *settings, double most,
                                  const char *key, hc_error *error);

/* What both ask of a start on walls with volumes: settled fluid is within a percent of the rest density, also
 * beside irregular walls; the paper's boundary, which counts walls in full, has 0.15 too much in corners. */
hc_status hc_solver_check_settled(const hc_world *world, const hc_solver_settings *settings, hc_error *error);

/* The same as check_density for fluid that starts behind a wetted surface, by the wall densities that contact
 * goes by. */
hc_status hc_solver_check_walls(const hc_world *world, hc_error *error);

/* For hc_solver_ops.summary: how often the caps were hit. Local. */
void hc_solver_tell_caps(const hc_solver_caps *caps, char *text, size_t size);

/* Shared by the solvers (motion.c). */

/* Velocity changes of selected own particles by non-pressure forces but gravity over dt, three a particle, in
 * the store's scratch. Ghost velocities and, for xsph, inverse densities must be current. `smoothed`: xsph of
 * these velocities is there, null: nothing is. Local. */
float *hc_find_forces(hc_world *world, const hc_solver_settings *settings, double dt,
                      const hc_smoothing *smoothed, hc_selection selection);

/* For a sweep that finds xsph before hc_find_forces is called: where; change is null where there is none. */
hc_smoothing hc_find_forces_ahead(hc_world *world, const hc_solver_settings *settings);

/* The acceleration of own particle i by gravity and the central force. Local. */
void hc_body_force(const hc_world *world, const hc_solver_settings *settings, int32_t i, double force[3]);

/* v += change + dt body force for own particles [begin, end), motion too. Local. */
void hc_accelerate(hc_world *world, const hc_solver_settings *settings, const float *change, double dt,
                   int32_t begin, int32_t end);

/* The largest acceleration of gravity, those changes and `push` (m/s, three a particle; may be null) among
 * own particles, m/s2. XSPH is left out unless surface tension acts: it smooths velocities, it is not a
 * force. Local. */
double hc_largest_force(const hc_world *world, const hc_solver_settings *settings, double dt,
                        const float *change, const float *push);

/* Where the world is holding, takes the velocity from own particles [begin, end) that are held. Local. */
void hc_hold_still(hc_world *world, int32_t begin, int32_t end);

/* The largest squared speed of own particles, m2/s2. Local. */
double hc_fastest(const hc_particles *fluid);

/* Remembers velocities, so that hc_move can tell accelerations. Local. */
void hc_remember_velocities(hc_world *world);

/* Adds up the errors of all ranks: the sum, NaN if one was not finite, and the largest; and what else is in
 * the tally (null: nothing). Collective: one reduction. */
double hc_reduce_errors(hc_comm *comm, const hc_error_total *total, hc_tally *more, double *max);

/* Wall contacts at velocities, where particles move by dt v; then own particles move, by that or to what
 * place predicts; periodic axes wrapped; velocities, accelerations, energies of own particles into
 * report->moved. `broken`, the same on every rank: the pressure found no end, and the step fails. Collective;
 * HC_FAILED as hc_solver_ops.step says. */
typedef enum hc_move_to { HC_MOVE_BY_VELOCITY, HC_MOVE_TO_PLACE } hc_move_to;
hc_status hc_move(hc_world *world, const hc_solver_settings *settings, double dt, hc_move_to to, bool broken,
                  hc_step_report *report, hc_error *error);

/* Behind a solver's step: notes what it has moved in a tally; and once that is reduced, speeds, forces and
 * energies into the report. Local. */
void hc_move_note(hc_step_report *report, hc_tally *tally);
void hc_move_report(const hc_world *world, hc_step_report *report);

#endif
