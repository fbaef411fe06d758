/* A run in memory, without its files: the scene turned into a world. See step.h for what it does then. */
#ifndef HC_SIMULATION_H
#define HC_SIMULATION_H

#include "balance.h"
#include "population.h"
#include "rest.h"
#include "rigid/contact.h"
#include "rollback.h"
#include "scene/scene.h"
#include "setup/populate.h"
#include "setup/prescribed.h"
#include "solver/solver.h"
#include "solver/yield.h"
#include "state/moment.h"
#include "state/state.h"
#include "stepping/control.h"
#include "window/window.h"

/* What a caller has added up over the ranks with each step, in the one reduction behind its move: `note` is
 * called on every rank once own particles have moved by dt, cells and lists as they were before; what it
 * notes is reduced when the step returns. Not called in a step that failed before it moved. */
typedef struct hc_company {
  void (*note)(void *caller, double dt, hc_tally *tally); /* local; null: nothing */
  void *caller;
} hc_company;

typedef struct hc_simulation {
  const hc_scene *scene; /* the caller's; outlives the simulation */
  hc_comm *comm;
  hc_isa isa;
  hc_world world;
  const hc_solver_ops *solver;
  hc_solver_settings *solver_settings; /* the solver's own, the common ones first */
  hc_control control;
  int64_t step; /* steps done */
  double time;  /* s */
  double dt;    /* the last step's, s; 0 before the first */
  hc_step_report report;
  hc_setup_plan plan; /* of the scene's particles; let go once they are there */
  hc_movers movers;
  hc_bodies bodies;
  hc_impulses loads; /* of the fluid on bodies, of the step under way */
  hc_population population;
  hc_rest_report rest; /* of the rest states that have come last */
  double refilled;     /* s: blocks that start until then have come */
  bool came;           /* some came as the last step began, blocks or what a window is filled with */
  hc_window window;
  bool displaced;    /* the window went along as the last step began */
  bool unsettled;    /* the caller sets it behind prepare: a start may be too dense */
  int64_t capped_at; /* the last step in which the density solver was at its cap; 0: none */
  double imbalance;  /* largest over mean number of own fluid particles at the start */
  hc_balance balance;
  hc_rollback rollback; /* of the last call, and what the next may go back to */
  hc_company company;   /* the caller's */
  hc_state state;       /* all that the next step reads; callers may add what is theirs */
} hc_simulation;

/* Makes the particles of a scene, spreads them over the ranks and finds their first neighbourhoods.
 * Collective; errors (HC_BAD_INPUT; HC_FAILED if the memory cannot suffice) are agreed. On failure nothing
 * needs freeing. */
hc_status hc_simulation_init(hc_simulation *simulation, hc_comm *comm, const hc_scene *scene,
                             hc_error *error);

/* The same in two halves, with a choice for the second. Prepare: everything but the particles. Then either
 * populate: the particles of the scene, at the start; or, after a visitor has filled simulation->state,
 * adopt: spreads the particles that came with it over the ranks, as they were in the midst of a run.
 * Collective; the simulation must be freed if one of the second fails. It must stay where it is: its state
 * knows its place. */
hc_status hc_simulation_prepare(hc_simulation *simulation, hc_comm *comm, const hc_scene *scene,
                                hc_error *error);
hc_status hc_simulation_populate(hc_simulation *simulation, hc_error *error);
void hc_simulation_adopt(hc_simulation *simulation);
void hc_simulation_free(hc_simulation *simulation);

/* Has the run reached its end time? */
bool hc_simulation_done(const hc_simulation *simulation);

/* Puts moving walls where they stand at simulation->time; hc_world_place must follow. Collective. */
void hc_simulation_pose_walls(hc_simulation *simulation);

/* What its damped steps work on, with a report of their own. Local. */
hc_resting hc_simulation_resting(hc_simulation *simulation, hc_step_report *report);

/* `fresh` particles, which have just been put into the fluid's store, fit themselves to what is there, see
 * rest.h; simulation->rest tells. hc_world_place must follow. Collective; HC_FAILED, agreed. */
hc_status hc_simulation_fit(hc_simulation *simulation, const hc_scene_rest *rules, const hc_rest_fresh *fresh,
                            double dt, hc_error *error);

/* Fluid particles have been moved, or their state gone back, by others than steps: what the last step found
 * out of their places does not hold. Local, on all ranks. */
void hc_simulation_disturb(hc_simulation *simulation);

/* The last report as the choice of the next step sees it: v_max counts all that moves, not only the fluid.
 * Local. */
hc_step_report hc_simulation_seen_by_control(const hc_simulation *simulation);

/* The moment to be written; borrows from the simulation. Local. */
hc_moment hc_simulation_moment(const hc_simulation *simulation);

/* Around the writing of a checkpoint: shows the state that it must hold (see rollback.h), and the present one
 * again, which `now` keeps meanwhile (zeroed; freed by the second). Moving walls follow, other boundary
 * particles stand still. Collective. */
void hc_simulation_show_resumable(hc_simulation *simulation, hc_state_copy *now);
void hc_simulation_show_now(hc_simulation *simulation, hc_state_copy *now);

/* Gives the fields that steps derive a meaning where no step has been: densities; no pressure, no
 * acceleration. Collective. */
void hc_simulation_fill_derived(hc_simulation *simulation);

/* What a user can find a fluid particle by: "959 (number 959 of fluid.blocks[0])". Local. */
typedef struct hc_particle_name {
  char text[96];
} hc_particle_name;
hc_particle_name hc_simulation_particle_name(const hc_scene *scene, int64_t id);

/* The largest speed that the scene prescribes for the start of a run, m/s: it counts as that of the fluid in
 * the choice of the time step. Local. */
double hc_simulation_prescribed_speed(const hc_scene *scene, const hc_movers *movers,
                                      const hc_emitters *emitters);

#endif
