#include "simulation.h"

#include "base/memory.h"
#include "estimate.h"
#include "failure.h"
#include "setup/rest_lattice.h"
#include "setup/world_frame.h"

#include <math.h>
#include <string.h>

static hc_isa agree_on_isa(hc_comm *comm) {
  int64_t isa = hc_isa_best();
  hc_comm_min_i64(comm, &isa, 1);
  return (hc_isa)isa;
}

static const hc_boundary_ops *boundary_of(hc_boundary_method method) {
  switch (method) {
  case HC_BOUNDARY_AKINCI2012:
    return &hc_boundary_akinci2012;
  case HC_BOUNDARY_IHMSEN2010:
    return &hc_boundary_ihmsen2010;
  case HC_BOUNDARY_BECKER2009:
    return &hc_boundary_becker2009;
  case HC_BOUNDARY_HARADA2007:
    return &hc_boundary_harada2007;
  }
  return NULL;
}

static const hc_solver_ops *solver_of(hc_solver_method method) {
  switch (method) {
  case HC_SOLVER_DFSPH:
    return &hc_solver_dfsph;
  case HC_SOLVER_PCISPH:
    return &hc_solver_pcisph;
  }
  return NULL;
}

static hc_viscous_force viscosity_of(hc_viscosity_model model) {
  switch (model) {
  case HC_VISCOSITY_NONE:
    return HC_VISCOUS_NONE;
  case HC_VISCOSITY_XSPH:
    return HC_VISCOUS_XSPH;
  case HC_VISCOSITY_ARTIFICIAL:
    return HC_VISCOUS_ARTIFICIAL;
  case HC_VISCOSITY_LAMINAR:
    return HC_VISCOUS_LAMINAR;
  }
  return HC_VISCOUS_NONE;
}

/* Sound speed of the artificial viscosity if the scene names none: ten times the speed of a fall over the
 * fluid's height, which keeps a weakly compressible fluid within 1 %. */
static double default_sound_speed(const hc_scene *scene) {
  double gravity = 0.0, height = 0.0;
  for (int axis = 0; axis < 3; axis++) gravity += scene->gravity[axis] * scene->gravity[axis];
  for (int block = 0; block < scene->fluid.block_count; block++) {
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[block]);
    double extent = 0.0;
    for (int axis = 0; axis < 3; axis++)
      extent += (box.max[axis] - box.min[axis]) *
                (gravity > 0.0 ? fabs(scene->gravity[axis]) / sqrt(gravity) : 1.0);
    height = fmax(height, extent);
  }
  return 10.0 * sqrt(2.0 * (gravity > 0.0 ? sqrt(gravity) : 1.0) * height);
}

/* Likewise of what emitters bring: ten times its speed. */
static double emitted_sound_speed(const hc_scene *scene) {
  double speed = 0.0;
  for (int k = 0; k < scene->fluid.emitter_count; k++) {
    const hc_scene_emitter *emitter = &scene->fluid.emitters[k];
    const double area = emitter->form == HC_EMITTER_DISC
                            ? 3.14159265358979323846 * emitter->radius * emitter->radius
                            : emitter->size[0] * emitter->size[1];
    speed = fmax(speed, fmax(emitter->speed, emitter->rate / area));
  }
  return 10.0 * speed;
}

static double sound_speed(const hc_scene *scene) {
  if (scene->fluid.viscosity.model != HC_VISCOSITY_ARTIFICIAL) return 0.0;
  return scene->fluid.viscosity.sound_speed > 0.0
             ? scene->fluid.viscosity.sound_speed
             : fmax(default_sound_speed(scene), emitted_sound_speed(scene));
}

/* Of all blocks together, along gravity, m; 0 without gravity. */
static double fluid_height(const hc_scene *scene, double gravity) {
  double low = INFINITY, high = -INFINITY;
  for (int block = 0; block < scene->fluid.block_count && gravity > 0.0; block++) {
    const hc_box box = hc_source_block_bounds(&scene->fluid.blocks[block]);
    double ends[2] = {0.0, 0.0};
    for (int axis = 0; axis < 3; axis++) {
      const double down = scene->gravity[axis] / gravity;
      ends[down < 0.0] += down * box.min[axis];
      ends[down >= 0.0] += down * box.max[axis];
    }
    low = fmin(low, ends[0]);
    high = fmax(high, ends[1]);
  }
  return high > low ? high - low : 0.0;
}

static hc_adaptive_settings adaptive_settings_of(const hc_scene *scene) {
  const hc_time_adaptive *a = &scene->time_step.adaptive;
  const double error_avg = scene->solver.density_error_avg, error_max = scene->solver.density_error_max,
               gravity = hc_simulation_start_report(scene, 0.0).force_max;
  return (hc_adaptive_settings){
      .error_avg = error_avg,
      .error_max = error_max > 0.0 ? error_max : 10.0 * error_avg,
      .change = a->change,
      .grow = {a->grow.force, a->grow.velocity, a->grow.error_max, a->grow.error_avg},
      .shrink = {a->shrink.force, a->shrink.velocity, a->shrink.error_max, a->shrink.error_avg},
      .shock_rise = a->shock.error_rise > 0.0 ? a->shock.error_rise : 5.0 * error_avg,
      .shock_velocity = a->shock.velocity,
      .restart_force = a->restart.force,
      .restart_velocity = a->restart.velocity,
      .restart_share = a->restart.share,
      .most_restarts = a->restart.most,
      .first_velocity = a->first.velocity,
      .first_depth = a->first.depth,
      .gravity = gravity,
      .depth = fluid_height(scene, gravity)};
}

static hc_step_control control_of(hc_time_control control) {
  switch (control) {
  case HC_TIME_CONSTANT:
    return HC_STEP_CONSTANT;
  case HC_TIME_CFL:
    return HC_STEP_CFL;
  case HC_TIME_ADAPTIVE:
    return HC_STEP_ADAPTIVE;
  }
  return HC_STEP_CFL;
}

hc_step_settings hc_step_settings_of(const hc_scene *scene) {
  const bool laminar = scene->fluid.viscosity.model == HC_VISCOSITY_LAMINAR;
  const double coefficient = scene->fluid.viscosity.coefficient;
  return (hc_step_settings){
      .control = control_of(scene->time_step.control),
      .size = scene->time_step.size,
      .max = scene->time_step.max,
      .min = scene->time_step.min,
      .factor = scene->time_step.factor,
      .spacing = scene->particle_spacing,
      .support_radius = scene->support_radius,
      /* artificial: the kinematic viscosity it amounts to in three dimensions, alpha h c / 10 (Monaghan 2005)
       */
      .viscosity = laminar ? coefficient : 0.1 * coefficient * scene->support_radius * sound_speed(scene),
      .end_time = scene->end_time,
      .adaptive = adaptive_settings_of(scene)};
}

/* What PCISPH reads besides. */
static void choose_prediction(const hc_scene *scene, hc_solver_settings *solver) {
  const double h = scene->support_radius, ratio = scene->particle_spacing / h;
  solver->density_error_max = scene->solver.density_error_max > 0.0 ? scene->solver.density_error_max
                                                                    : 10.0 * scene->solver.density_error_avg;
  solver->gradient_square = hc_setup_rest_lattice_gradient(ratio) / pow(h, 8.0);
  solver->shepard = scene->solver.density_correction == HC_CORRECTION_SHEPARD;
  solver->friction = scene->boundary.friction;
  solver->elasticity = scene->boundary.elasticity;
  const double volume = scene->fluid.mass_factor / hc_setup_rest_lattice_sum(ratio); /* in h3 */
  for (int k = 0; k <= HC_WALL_WEIGHTS; k++)
    solver->wall_weights[k] = (float)(volume * hc_setup_half_space(ratio, (double)k / HC_WALL_WEIGHTS));
}

static void choose_settings(hc_simulation *simulation) {
  const hc_scene *scene = simulation->scene;
  hc_solver_settings *solver = &simulation->solver_settings;
  *solver = (hc_solver_settings){.rest_density = scene->fluid.rest_density,
                                 .viscosity = viscosity_of(scene->fluid.viscosity.model),
                                 .viscosity_coefficient = scene->fluid.viscosity.coefficient,
                                 .sound_speed = sound_speed(scene),
                                 .density_error_avg = scene->solver.density_error_avg,
                                 .divergence_error = scene->solver.divergence_error,
                                 .density_min = scene->solver.density_iterations.min,
                                 .density_max = scene->solver.density_iterations.max,
                                 .divergence_min = scene->solver.divergence_iterations.min,
                                 .divergence_max = scene->solver.divergence_iterations.max,
                                 .warm_start = scene->solver.warm_start,
                                 .relaxation = scene->solver.relaxation,
                                 .min_divergence_neighbors = scene->solver.min_divergence_neighbors,
                                 .negative_pressure = scene->solver.negative_pressure};
  memcpy(solver->gravity, scene->gravity, sizeof solver->gravity);
  if (scene->fluid.surface_tension.model == HC_TENSION_BECKER2007)
    solver->surface_tension = scene->fluid.surface_tension.coefficient;
  if (scene->solver.method == HC_SOLVER_PCISPH) choose_prediction(scene, solver);
  simulation->solver = solver_of(scene->solver.method);

  simulation->step_settings = hc_step_settings_of(scene);
}

/* Where memory is promised before it is there, running out of it kills: so what cannot fit is refused. */
static hc_status check_memory(hc_comm *comm, const hc_scene *scene, const hc_setup_plan *plan,
                              hc_error *error) {
  const double needed = hc_estimate_least_memory(scene, plan, comm->size), gibibyte = 1 << 30;
  const int sharing = hc_comm_machine_ranks(comm);
  const double share = (double)hc_memory_machine() / sharing, allowed = (double)hc_memory_allowed();
  const double most = share < allowed ? share : allowed;
  if (needed > most)
    hc_error_set(
        error, HC_FAILED,
        "out of memory: %lld fluid and %lld boundary particles on %d rank%s need about %.3g GiB on a "
        "rank, which may have %.3g GiB (%d rank%s on its machine): use more machines or a larger "
        "particle_spacing",
        (long long)plan->fluid_count, (long long)plan->boundary_count, comm->size, comm->size == 1 ? "" : "s",
        needed / gibibyte, most / gibibyte, sharing, sharing == 1 ? "" : "s");
  return hc_comm_agree(comm, error);
}

double hc_simulation_settle_step(const hc_scene *scene) {
  if (scene->fluid.settle_steps == 0) return 0.0;
  if (scene->time_step.control == HC_TIME_CONSTANT) return scene->time_step.size;
  if (scene->time_step.control == HC_TIME_CFL) return scene->time_step.max;
  const hc_step_settings settings = hc_step_settings_of(scene);
  const hc_step_report still = {.v_max = 0.0};
  hc_step_bound unused;
  return hc_time_step_next(&settings, 0.0, 0.0, &still, &unused);
}

/* How far ahead what is prescribed is looked at: no step is longer. */
static double longest_step(const hc_scene *scene) {
  return fmax(scene->time_step.max, scene->time_step.size);
}

/* Puts moving walls where they stand now. */
static void pose_walls(hc_simulation *simulation, bool held) {
  hc_world_pose_walls(&simulation->world, simulation->time, longest_step(simulation->scene), held);
}

void hc_simulation_pose_walls(hc_simulation *simulation) {
  pose_walls(simulation, false);
}

double hc_simulation_prescribed_speed(const hc_scene *scene, const hc_prescribed_motions *motions,
                                      const hc_emitters *emitters) {
  return hc_prescribed_speed(motions, emitters, 0.0, longest_step(scene));
}

/* Lets the start come to rest: steps of gravity and pressure that forget all momentum; then every particle
 * gets the velocity of the place it has come to. The pressure stays. */
static hc_status settle(hc_simulation *simulation, hc_error *error) {
  hc_world *world = &simulation->world;
  hc_particles *fluid = &world->fluid;
  hc_solver_settings settings = simulation->solver_settings;
  settings.viscosity = HC_VISCOUS_NONE;
  const double dt = hc_simulation_settle_step(simulation->scene);
  for (int step = 0; step < simulation->scene->fluid.settle_steps; step++) {
    memset(fluid->velocity, 0, 3 * (size_t)fluid->own * sizeof *fluid->velocity);
    hc_world_update(world);
    if (simulation->solver->step(world, &settings, dt, step > 0 ? dt : 0.0, &simulation->report, error) ==
        HC_OK)
      continue;
    const hc_error found = *error;
    return hc_error_set(error, HC_FAILED, "the simulation diverged while its start settled, step %d: %.4000s",
                        step + 1, found.text);
  }
  hc_setup_velocities(&simulation->plan, fluid);
  pose_walls(simulation, false);
  simulation->dt = dt;
  return HC_OK;
}

/* The particles of the scene, at their owners. */
static hc_status fill_world(hc_simulation *simulation, hc_error *error) {
  hc_comm *comm = simulation->comm;
  hc_world *world = &simulation->world;
  hc_setup_generate(&simulation->plan, comm->rank, comm->size, &world->fluid, &world->boundary, error);
  if (hc_comm_agree(comm, error) != HC_OK) return error->status;
  hc_moving_walls_start(&world->boundary);
  pose_walls(simulation, simulation->scene->fluid.settle_steps > 0);
  hc_world_start(world, hc_balance_first_divider(simulation->scene));
  if (simulation->scene->fluid.settle_steps > 0 && settle(simulation, error) != HC_OK) return error->status;
  hc_world_update(world);
  hc_setup_plan_free(&simulation->plan);
  return HC_OK;
}

double hc_simulation_fastest(const hc_particles *fluid) {
  double largest = 0.0;
  for (int32_t k = 0; k < fluid->own; k++) {
    const double *v = &fluid->velocity[3 * (size_t)k];
    largest = fmax(largest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return largest;
}

hc_step_report hc_simulation_start_report(const hc_scene *scene, double v2_max) {
  double force = 0.0;
  for (int axis = 0; axis < 3; axis++) force += scene->gravity[axis] * scene->gravity[axis];
  return (hc_step_report){.v_max = sqrt(v2_max), .force_max = sqrt(force)};
}

/* Gives the fields that steps derive a meaning in the first snapshot too. */
static void fill_derived(hc_simulation *simulation) {
  hc_particles *fluid = &simulation->world.fluid;
  simulation->solver->densities(&simulation->world, &simulation->solver_settings);
  memset(fluid->pressure, 0, (size_t)fluid->own * sizeof *fluid->pressure);
  memset(fluid->acceleration, 0, 3 * (size_t)fluid->own * sizeof *fluid->acceleration);
}

static void register_state(hc_simulation *simulation) {
  hc_state *state = &simulation->state;
  hc_state_init(state, &simulation->world.fluid, &simulation->world.boundary);
  hc_state_add(state, HC_TYPE_i64, 1, &simulation->step, "step");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->time, "time");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->dt, "dt");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.v_max, "v_max");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.force_max, "force_max");
  hc_state_add(state, HC_TYPE_i64, 1, &simulation->capped_at, "capped_at");
  hc_state_add(state, HC_TYPE_i64, 1, &simulation->world.fluid_total, "fluid_total");
  hc_emitters_register(&simulation->emitters, state);
  hc_rollback_register(simulation);
}

/* Fluid that is squeezed from the start, as too near to a wall, explodes: the pressure that pushes it apart
 * in one step knows no bounds. PCISPH is told how much it may be. Collective. */
static hc_status refuse_dense_start(hc_simulation *simulation, hc_error *error) {
  const hc_particles *fluid = &simulation->world.fluid;
  const hc_frame *frame = &simulation->world.frame;
  if (simulation->scene->solver.method != HC_SOLVER_PCISPH) return HC_OK;
  int32_t worst = 0;
  for (int32_t k = 1; k < fluid->own; k++)
    if (fluid->density[k] > fluid->density[worst]) worst = k;
  double density = fluid->own > 0 ? (double)fluid->density[worst] : 0.0;
  const double most = simulation->solver_settings.density_error_max;
  const double own = density / simulation->scene->fluid.rest_density - 1.0;
  hc_comm_max_f64(simulation->comm, &density, 1);
  if (own > most && density == (double)fluid->density[worst])
    hc_error_set(error, HC_BAD_INPUT,
                 "the fluid at (%.6g, %.6g, %.6g) m is %.3g %% too dense at the start, "
                 "solver.density_error_max allows "
                 "%.3g %%: fluid lattices must not overlap, and keep half a spacing from walls",
                 hc_frame_to_metres(frame, 0, fluid->position[3 * (size_t)worst]),
                 hc_frame_to_metres(frame, 1, fluid->position[3 * (size_t)worst + 1]),
                 hc_frame_to_metres(frame, 2, fluid->position[3 * (size_t)worst + 2]), 100.0 * own,
                 100.0 * most);
  return hc_comm_agree(simulation->comm, error);
}

/* What is known of the particles before there are any. Agreed. */
static hc_status plan_particles(hc_simulation *simulation, hc_error *error) {
  hc_setup_plan *plan = &simulation->plan;
  const hc_scene *scene = simulation->scene;
  if (hc_prescribed_emitters_make(scene, &simulation->world.frame, &simulation->emitters, error) == HC_OK &&
      hc_setup_plan_make(scene, &simulation->world.frame, plan, error) == HC_OK &&
      hc_setup_limits(scene, plan, &simulation->emitters, &simulation->limits, error) == HC_OK)
    check_memory(simulation->comm, scene, plan, error);
  if (hc_comm_agree(simulation->comm, error) != HC_OK) return error->status;
  simulation->motions = hc_prescribed_motions_make(scene, plan);
  hc_moving_walls_init(&simulation->world.moving, simulation->motions.walls, simulation->motions.count);
  register_state(simulation);
  return HC_OK;
}

hc_status hc_simulation_prepare(hc_simulation *simulation, hc_comm *comm, const hc_scene *scene,
                                hc_error *error) {
  memset(simulation, 0, sizeof *simulation);
  simulation->scene = scene;
  simulation->comm = comm;
  simulation->isa = agree_on_isa(comm);
  hc_balance_init(&simulation->balance, scene);
  choose_settings(simulation);

  hc_frame frame;
  if (hc_setup_frame(scene, &frame, error) != HC_OK) return error->status;
  const double ratio = scene->particle_spacing / scene->support_radius, h = frame.support_radius;
  const double volume_factor = scene->boundary.method != HC_BOUNDARY_AKINCI2012 ? hc_setup_wall_share(ratio)
                               : scene->boundary.volume_factor > 0.0 ? scene->boundary.volume_factor
                                                                     : hc_setup_wall_factor(ratio);
  const hc_world_settings settings = {
      .frame = frame,
      .rest_density = scene->fluid.rest_density,
      .mass =
          scene->fluid.rest_density * scene->fluid.mass_factor * h * h * h / hc_setup_rest_lattice_sum(ratio),
      .volume_factor = volume_factor,
      .contact_limit = scene->boundary.contact ? hc_setup_contact_limit(ratio, volume_factor) : 0.0,
      .boundary_ops = boundary_of(scene->boundary.method),
      .isa = simulation->isa};
  hc_world_init(&simulation->world, comm, &settings);
  if (plan_particles(simulation, error) != HC_OK) hc_simulation_free(simulation);
  return error->status;
}

hc_status hc_simulation_populate(hc_simulation *simulation, hc_error *error) {
  hc_world *world = &simulation->world;
  if (fill_world(simulation, error) != HC_OK) return error->status;
  fill_derived(simulation);
  if (refuse_dense_start(simulation, error) != HC_OK) return error->status;
  simulation->imbalance = hc_domain_imbalance(&world->domain, &world->fluid);
  double v2_max = hc_simulation_fastest(&world->fluid);
  hc_comm_max_f64(simulation->comm, &v2_max, 1);
  simulation->report = hc_simulation_start_report(simulation->scene, v2_max);
  return HC_OK;
}

void hc_simulation_adopt(hc_simulation *simulation) {
  hc_world *world = &simulation->world;
  pose_walls(simulation, false);
  hc_world_distribute(world, hc_balance_first_divider(simulation->scene));
  hc_world_update(world);
  simulation->imbalance = hc_domain_imbalance(&world->domain, &world->fluid);
  hc_balance_go_on(&simulation->balance, simulation->step);
  hc_setup_plan_free(&simulation->plan);
}

hc_status hc_simulation_init(hc_simulation *simulation, hc_comm *comm, const hc_scene *scene,
                             hc_error *error) {
  if (hc_simulation_prepare(simulation, comm, scene, error) != HC_OK) return error->status;
  if (hc_simulation_populate(simulation, error) != HC_OK) hc_simulation_free(simulation);
  return error->status;
}

void hc_simulation_free(hc_simulation *simulation) {
  hc_setup_plan_free(&simulation->plan);
  hc_state_history_free(&simulation->rollback.history);
  hc_prescribed_motions_free(&simulation->motions);
  hc_emitters_free(&simulation->emitters);
  hc_state_free(&simulation->state);
  hc_world_free(&simulation->world);
}

bool hc_simulation_done(const hc_simulation *simulation) {
  return simulation->time >= simulation->scene->end_time;
}

/* Bodies will raise v_max here too. */
hc_step_report hc_simulation_seen_by_control(const hc_simulation *simulation) {
  hc_step_report report = simulation->report;
  report.v_max = fmax(report.v_max, simulation->world.moving.speed);
  report.v_max = fmax(report.v_max, hc_emitters_speed(&simulation->emitters, simulation->time,
                                                      longest_step(simulation->scene)));
  return report;
}

static double choose_step(hc_simulation *simulation) {
  const hc_step_settings *settings = &simulation->step_settings;
  const double replay = hc_rollback_next(simulation);
  const hc_step_report seen = hc_simulation_seen_by_control(simulation);
  if (replay == 0.0)
    return hc_time_step_next(settings, simulation->time, simulation->dt, &seen, &simulation->bound);
  simulation->bound = HC_BOUND_SHOCK;
  return hc_time_step_to_end(settings, simulation->time, replay, &simulation->bound);
}

/* The step itself: the solver's, between the watches over its length and over the world's limits. */
static hc_status advance(hc_simulation *simulation, double dt, hc_error *error) {
  hc_world *world = &simulation->world;
  hc_fault *fault = &simulation->report.fault;
  const bool gave_up = hc_rollback_gave_up(simulation);
  if (gave_up || hc_time_step_too_small(&simulation->step_settings, simulation->time, dt)) {
    fill_derived(simulation);
    hc_fault_note(fault, HC_FAULT_TIME_STEP, -1.0, INT64_MAX); /* also where no particle is left */
    hc_fault_watch_fastest(world, HC_FAULT_TIME_STEP, fault);
    hc_fault_agree(world->comm, dt, fault, error);
    if (gave_up)
      hc_error_set(error, HC_FAILED, "a shock came again in each of %d replays",
                   simulation->step_settings.adaptive.most_restarts);
    return error->status;
  }
  if (simulation->solver->step(world, &simulation->solver_settings, dt, simulation->dt, &simulation->report,
                               error) != HC_OK)
    return error->status;
  if (simulation->scene->domain.leaving == HC_LEAVING_REMOVE) return HC_OK;
  hc_leaving_watch(world, &simulation->limits, fault);
  return hc_fault_agree(world->comm, dt, fault, error);
}

/* The neighbourhoods of the moment, with what the emitters bring in: a place is free or not among the
 * particles as they are before. */
static void meet(hc_simulation *simulation) {
  hc_world *world = &simulation->world;
  hc_emitters *emitters = &simulation->emitters;
  pose_walls(simulation, false);
  if (simulation->step > 0 || world->walls_moved) hc_world_update(world);
  int64_t blocked = 0;
  for (int k = 0; k < emitters->count; k++) blocked -= emitters->emitters[k].blocked;
  simulation->emitted =
      hc_emitters_release(emitters, &world->domain, &world->cells, &world->fluid, simulation->time);
  for (int k = 0; k < emitters->count; k++) blocked += emitters->emitters[k].blocked;
  simulation->blocked = blocked;
  if (simulation->emitted == 0) return;
  world->fluid_total += simulation->emitted;
  hc_world_update(world);
}

hc_status hc_simulation_step(hc_simulation *simulation, hc_error *error) {
  hc_world *world = &simulation->world;
  const hc_step_report before = simulation->report;
  hc_rollback_remember(simulation);
  simulation->departures.count = 0;
  if (simulation->step > 0) {
    if (simulation->scene->domain.leaving == HC_LEAVING_REMOVE)
      hc_leaving_remove(world, &simulation->limits, &simulation->departures);
    hc_failure_inject(simulation);
    simulation->rebalanced = hc_balance_look(&simulation->balance, world, simulation->step);
  }
  hc_balance_start(&simulation->balance, simulation->comm);
  meet(simulation);
  const double dt = choose_step(simulation);
  advance(simulation, dt, error);
  hc_balance_stop(&simulation->balance, simulation->comm);
  if (hc_rollback_if_shock(simulation, dt, &before, error)) return HC_OK;
  if (error->status != HC_OK) {
    hc_failure_explain(simulation, dt, &before, error);
    return error->status;
  }
  simulation->dt = dt;
  simulation->step++;
  simulation->time = simulation->bound == HC_BOUND_END ? simulation->scene->end_time : simulation->time + dt;
  if (simulation->report.density_capped) simulation->capped_at = simulation->step;
  hc_rollback_pass(simulation);
  pose_walls(simulation, false);
  return HC_OK;
}

hc_snapshot hc_simulation_snapshot(const hc_simulation *simulation) {
  const hc_world *world = &simulation->world;
  return (hc_snapshot){.scene = simulation->scene,
                       .frame = &world->frame,
                       .fluid = &world->fluid,
                       .boundary = &world->boundary,
                       .step = simulation->step,
                       .time = simulation->time,
                       .dt = simulation->dt,
                       .particle_mass = world->mass};
}
