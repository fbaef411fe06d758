/* Predictive-corrective incompressible SPH (Solenthaler and Pajarola 2009) as Ihmsen, Akinci, Gissler,
 * Teschner 2010 print it: algorithms 1 and 2, with the world collision inside the loop and any boundary
 * method.
 *
 * Positions are predicted from velocities, non-pressure forces and the pressures so far, moved out of walls,
 * and the densities there raise the pressures, three times or until the errors are small. Pressures start at
 * zero in every step. Densities and errors are fractions of the rest density; pressures divided by it have
 * the unit m2/s2. Neighbours stay those of the step's beginning, distances are those of the prediction, in
 * the kernel's gradient too (but that of walls which mirror the pressure, akinci2012). The errors reported
 * are those of the last prediction, before the last correction, as in the paper. */
#include "pcisph.h"

#include "sph/error_rule.h"
#include "wall_layer.h"
#include "yield.h"

#include "base/memory.h"
#include "particles/ids.h"

#include <math.h>
#include <string.h>

/* A step under way. */
typedef struct pcisph {
  hc_world *world;
  const hc_pcisph_settings *settings;
  double dt;
  hc_prediction prediction;
  hc_collision collision;
  hc_yield yield;
  int64_t held; /* particles in walls at the last prediction */
} pcisph;

static hc_prediction prediction_of(const hc_world *world, const hc_pcisph_settings *settings, double dt) {
  const double volume = world->sweep.volume;
  return (hc_prediction){
      .shepard = settings->shepard,
      .negative = settings->common.negative_pressure,
      .stiffness = dt > 0.0 ? (float)(0.5 / (volume * volume * dt * dt * settings->gradient_square)) : 0.0f,
      .dt = (float)dt,
      .weights = settings->wall_weights};
}

/* ---- predictions ---- */

/* Places of selected particles at the end of the step, out of walls. */
static void predict_places(pcisph *step, bool with_push, hc_selection selection) {
  hc_particles *fluid = step->world->fluid;
  const hc_frame *frame = &step->world->frame;
  double units[3];
  for (int axis = 0; axis < 3; axis++) units[axis] = step->dt / frame->unit[axis];
  for (int32_t row = selection.begin; row < selection.end; row++) {
    const int32_t i = hc_selected(selection, row);
    const size_t at = 3 * (size_t)i;
    for (size_t axis = 0; axis < 3; axis++) {
      const double velocity = fluid->velocity[at + axis] + (with_push ? (double)fluid->push[at + axis] : 0.0);
      fluid->place[i].x[axis] =
          (int32_t)(uint32_t)(uint64_t)(fluid->position[at + axis] + llrint(velocity * units[axis]));
    }
  }
  if (step->world->boundary_ops->collide)
    step->held += step->world->boundary_ops->collide(&step->collision, selection);
}

/* Densities, errors and pressures of selected particles. */
static void predict_densities(const pcisph *step, hc_selection selection, hc_error_total *total) {
  const hc_world *world = step->world;
  world->sweeps->predicted_density(&world->sweep, &step->prediction, selection, total);
}

/* The densities of a surface corrected by the kernel sum: a second sweep, which needs its neighbours' first.
 */
static void correct_densities(const pcisph *step, hc_error_total *total) {
  hc_world *world = step->world;
  hc_halo_begin(world->halo, HC_WHOLE(motion));
  world->sweeps->corrected_density(&world->sweep, &step->prediction,
                                   hc_select_interior(world->listed, world->fluid), total);
  hc_halo_end(world->halo);
  world->sweeps->corrected_density(&world->sweep, &step->prediction,
                                   hc_select_border(world->listed, world->fluid), total);
}

/* The pressure of walls that have one, of ghosts too. */
static void press_walls(const pcisph *step, hc_store *walls) {
  step->world->sweeps->boundary_density(&step->world->sweep, &step->prediction, &walls->particles,
                                        &walls->wetted, hc_select_all(&walls->particles));
  hc_halo_refresh(&walls->halo, HC_SCALAR(place));
}

/* What is held is not pushed. */
static void hold_pushes(const pcisph *step) {
  hc_particles *const fluid = step->world->fluid;
  for (int32_t k = 0; k < fluid->own && step->world->holding; k++)
    if (hc_id_kind_of(fluid->id[k]) == HC_ID_HELD)
      memset(&fluid->push[3 * (size_t)k], 0, 3 * sizeof *fluid->push);
}

/* One prediction: where particles will be, how dense, and the pressures against that; ghosts' too. */
static hc_error_total predict(pcisph *step, bool with_push) {
  hc_world *world = step->world;
  const hc_selection border = hc_select_border(world->listed, world->fluid),
                     interior = hc_select_interior(world->listed, world->fluid);
  hc_error_total total;
  memset(&total, 0, sizeof total);
  step->held = 0;
  predict_places(step, with_push, border);
  hc_halo_begin(world->halo, HC_WHOLE(place));
  predict_places(step, with_push, interior);
  predict_densities(step, interior, &total);
  hc_halo_end(world->halo);
  predict_densities(step, border, &total);
  if (step->prediction.shepard) correct_densities(step, &total);

  hc_halo_begin(world->halo, HC_SCALAR(place));
  if (step->world->boundary_ops->walls == HC_WALLS_PRESSURE) {
    for (int k = HC_STORE_BOUNDARY; k <= HC_STORE_MOVING; k++) press_walls(step, &world->stores[k]);
  }
  world->sweeps->push(&world->sweep, &step->prediction, interior);
  hc_halo_end(world->halo);
  world->sweeps->push(&world->sweep, &step->prediction, border);
  hold_pushes(step);
  return total;
}

/* ---- what a shorter step leaves for later ---- */

/* In a steady state the iterations leave a compression e that holds the pressure, p = 3 stiffness e. A step
 * that is shorter by s reads the same e as p/s^2, a pulse through the whole fluid. So it takes s^2 of the
 * compression it finds for the pressure's and leaves the rest for later, when it is let go bit by bit. */
static const double SHORTER = 0.99; /* than the last step: else nothing is left */
static const float LEAST_LEFT = 1e-9f;

static void release(const pcisph *step, hc_particles *particles) {
  const float left = (float)(1.0 - 1.0 / step->settings->release_steps);
  for (int32_t i = 0; i < particles->own; i++) {
    float *const late = &particles->late_compression[i];
    *late = *late > LEAST_LEFT ? left * *late : 0.0f;
  }
}

/* Before the first prediction; places are those of the step's beginning. */
static void leave_for_later(const pcisph *step, double dt_before) {
  hc_world *world = step->world;
  if (step->settings->release_steps == 0) return;
  const bool walls_too = world->boundary_ops->walls == HC_WALLS_PRESSURE;
  release(step, world->fluid);
  for (int k = HC_STORE_BOUNDARY; k <= HC_STORE_MOVING && walls_too; k++)
    release(step, &world->stores[k].particles);
  if (!(step->dt < SHORTER * dt_before)) return;
  pcisph leaving = *step;
  hc_error_total unused;
  memset(&unused, 0, sizeof unused);
  leaving.prediction.stiffness = 0.0f;
  leaving.prediction.leaves = (float)(1.0 - step->dt / dt_before * (step->dt / dt_before));
  predict_densities(&leaving, world->listed, &unused);
  if (step->prediction.shepard) correct_densities(&leaving, &unused);
  for (int k = HC_STORE_BOUNDARY; k <= HC_STORE_MOVING && walls_too; k++)
    world->sweeps->boundary_density(&world->sweep, &leaving.prediction, &world->stores[k].particles,
                                    &world->stores[k].wetted, hc_select_all(&world->stores[k].particles));
}

/* ---- the step ---- */

static void start(pcisph *step) {
  hc_world *world = step->world;
  hc_particles *fluid = world->fluid;
  memset(fluid->pressure, 0, (size_t)fluid->own * sizeof *fluid->pressure);
  if (world->boundary_ops->walls == HC_WALLS_MIRRORED) world->sweeps->wall_sums(&world->sweep, world->listed);
  for (int k = HC_STORE_BOUNDARY; k <= HC_STORE_MOVING && world->boundary_ops->walls == HC_WALLS_PRESSURE;
       k++) {
    hc_particles *walls = &world->stores[k].particles;
    memset(walls->pressure, 0, (size_t)walls->own * sizeof *walls->pressure);
    for (int32_t b = 0; b < walls->own + walls->ghosts; b++) walls->place[b].scalar = 0.0f;
  }
}

/* Shows walls that move where they will be, or with `way` -1 again where they are. */
static void predict_walls(const pcisph *step, int way) {
  hc_world *world = step->world;
  hc_particles *boundary = world->moving;
  if (!world->sweep.walls_move) return;
  for (int32_t b = 0; b < boundary->own + boundary->ghosts; b++)
    for (int axis = 0; axis < 3; axis++)
      boundary->place[b].x[axis] =
          (int32_t)((uint32_t)boundary->place[b].x[axis] +
                    (uint32_t)(way * (int32_t)llrint((double)boundary->motion[b].v[axis] * step->dt /
                                                     world->frame.unit[axis])));
  world->stores[HC_STORE_MOVING].moved = true; /* the next hc_world_place puts them right */
}

/* Inverse densities for the forces that read them. */
static void find_densities(const pcisph *step) {
  hc_world *world = step->world;
  if (step->settings->common.viscosity != HC_VISCOUS_XSPH) return;
  hc_prediction prediction = step->prediction;
  prediction.shepard = true; /* leaves 1/density in motion */
  hc_error_total none;
  world->sweeps->predicted_density(&world->sweep, &prediction, world->listed, &none);
  hc_halo_refresh(world->halo, HC_WHOLE(motion));
}

/* Bodies go on as these pressures push them, and their samples are predicted anew. False if that is beyond
 * all measure. */
static bool let_yield(pcisph *step) {
  const hc_world *const world = step->world;
  if (!step->yield.bodies || step->yield.bodies->count == 0) return true;
  const double volume = world->sweep.volume;
  hc_tally pushes = {.count = 0};
  hc_yield_note(&step->yield, step->dt, &pushes);
  hc_tally_reduce(world->comm, &pushes);
  predict_walls(step, -1);
  hc_yield_retry(&step->yield, 2.0 * volume * volume * step->settings->gradient_square);
  hc_yield_show(&step->yield);
  predict_walls(step, 1);
  return !step->yield.impulses.broken;
}

/* Predicts and corrects, density_min times or until the errors are small. Returns whether they are numbers.
 */
static bool iterate(pcisph *step, hc_step_report *report) {
  hc_world *world = step->world;
  const hc_pcisph_settings *settings = step->settings;
  const double particles = world->fluid_total > 0 ? (double)world->fluid_total : 1.0;
  for (;;) {
    const hc_error_total total = predict(step, report->density_iterations > 0);
    if (!let_yield(step)) return false;
    report->density_iterations++;
    if (report->density_iterations == 1) hc_fault_watch_density(world, &report->fault);
    if (report->density_iterations < settings->density_min) continue;
    report->density_error_avg =
        hc_reduce_errors(world->comm, &total, NULL, &report->density_error_max) / particles;
    if (!isfinite(report->density_error_avg)) return false;
    if (report->density_error_max <= settings->density_error_max &&
        report->density_error_avg <= settings->density_error_avg)
      return true;
    if (report->density_iterations < settings->density_max) continue;
    report->density_capped = settings->density_max > settings->density_min;
    return true;
  }
}

/* Where particles go in the end, and their velocities: (11) and (12). */
static hc_move_to finish(pcisph *step) {
  hc_world *world = step->world;
  hc_particles *fluid = world->fluid;
  for (size_t k = 0; k < 3 * (size_t)fluid->own; k++) fluid->velocity[k] += (double)fluid->push[k];
  step->collision.respond = true;
  step->held = 0;
  if (world->boundary_ops->collide) {
    predict_places(step, false, world->listed);
    return HC_MOVE_TO_PLACE;
  }
  predict_walls(step, -1); /* forces on these walls are measured where all stood as the step began */
  for (int32_t i = 0; i < fluid->own; i++)
    for (size_t axis = 0; axis < 3; axis++)
      fluid->place[i].x[axis] = (int32_t)(uint32_t)(uint64_t)fluid->position[3 * (size_t)i + axis];
  return HC_MOVE_BY_VELOCITY;
}

/* Algorithms 1 and 2; the neighbourhoods are found by hc_world_update before. */
static hc_status advance(hc_world *world, hc_bodies *bodies, const hc_solver_settings *settings, double dt,
                         double dt_before, hc_step_report *report, hc_error *error) {
  const hc_pcisph_settings *own = (const hc_pcisph_settings *)settings;
  memset(report, 0, sizeof *report);
  hc_remember_velocities(world);
  hc_fault_watch_start(world, dt, &report->fault);
  pcisph step = {.world = world,
                 .settings = own,
                 .dt = dt,
                 .prediction = prediction_of(world, own, dt),
                 .collision = {.sweeps = world->sweeps,
                               .sweep = &world->sweep,
                               .unit = world->frame.unit,
                               .friction = own->friction,
                               .elasticity = own->elasticity,
                               .dt = dt}};
  hc_reserve((void **)&world->contacts, &world->contact_room, 2 * (size_t)world->fluid->own, 0,
             sizeof *world->contacts);
  step.collision.contacts = world->contacts;
  step.collision.velocities = world->sweep.walls_move ? world->contacts + world->fluid->own : NULL;
  world->sweep.contacts = world->boundary_ops->collide ? world->contacts : NULL;

  /* forces but pressure; v takes them in at once */
  hc_stopwatch_enter(&world->watch, HC_STAGE_FORCES);
  find_densities(&step);
  start(&step);
  leave_for_later(&step, dt_before);
  const float *change = hc_find_forces(world, settings, dt, NULL, world->listed);
  for (int32_t i = 0; i < world->fluid->own; i++) {
    double force[3];
    hc_body_force(world, settings, i, force);
    for (size_t axis = 0, at = 3 * (size_t)i; axis < 3; axis++, at++)
      world->fluid->velocity[at] += (double)change[at] + dt * force[axis];
  }
  hc_wall_layer_list(world, false);
  hc_wall_layer_act(world, settings, dt, 0, world->fluid->own);
  hc_hold_still(world, 0, world->fluid->own);
  hc_yield_begin(&step.yield, world, bodies, dt);
  hc_yield_measure(&step.yield);
  hc_yield_accelerate(&step.yield);
  hc_yield_show(&step.yield);
  predict_walls(&step, 1);

  /* predict, correct */
  hc_stopwatch_enter(&world->watch, HC_STAGE_PRESSURE);
  const bool sound = iterate(&step, report);
  report->force_max = hc_largest_force(world, settings, dt, change, world->fluid->push);

  /* v and x of the step's end, out of walls */
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
  const hc_move_to to = finish(&step);
  report->contacts = step.held;
  hc_yield_end(&step.yield);
  return hc_move(world, settings, dt, to, !sound, report, error);
}

static void densities(hc_world *world, const hc_solver_settings *settings) {
  const hc_prediction prediction = prediction_of(world, (const hc_pcisph_settings *)settings, 0.0);
  hc_error_total none;
  memset(&none, 0, sizeof none);
  const pcisph step = {.world = world, .prediction = prediction};
  predict_densities(&step, world->listed, &none);
  if (prediction.shepard) correct_densities(&step, &none);
}

static hc_status check_start(const hc_world *world, const hc_solver_settings *settings, hc_error *error) {
  return hc_solver_check_density(world, settings, ((const hc_pcisph_settings *)settings)->density_error_max,
                                 " (solver.density_error_max)", error);
}

static const char *const controls[] = {"adaptive", "cfl", "constant", NULL};

const hc_solver_ops hc_solver_pcisph = {.name = "pcisph",
                                        .features = HC_FOR_PCISPH,
                                        .walls = 1u << HC_WALLS_NOTHING | 1u << HC_WALLS_MIRRORED |
                                                 1u << HC_WALLS_PRESSURE | 1u << HC_WALLS_DISTANCE,
                                        .controls = controls,
                                        .steadier = "adaptive",
                                        .goes_back = 2,
                                        .step = advance,
                                        .densities = densities,
                                        .check_start = check_start,
                                        .summary = hc_solver_tell_caps};
