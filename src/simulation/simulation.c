#include "simulation.h"

#include "base/cgroup.h"
#include "base/memory.h"
#include "footprint.h"
#include "particles/ids.h"
#include "setup/absorptions.h"
#include "setup/bodies.h"
#include "setup/controls.h"
#include "setup/rest_lattice.h"
#include "setup/rest_states.h"
#include "setup/settings.h"
#include "setup/solvers.h"
#include "setup/world_frame.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static hc_isa agree_on_isa(hc_comm *comm) {
  int64_t isa = hc_isa_best();
  hc_comm_min_i64(comm, &isa, 1);
  return (hc_isa)isa;
}

/* Where memory is promised before it is there, running out of it kills: so what cannot fit is refused. */
static hc_status check_memory(hc_comm *comm, const hc_scene *scene, const hc_setup_plan *plan,
                              hc_error *error) {
  const double needed = hc_footprint_least(scene, plan, comm->size), gibibyte = 1 << 30;
  const hc_cgroup_limit limit = hc_cgroup_memory("");
  const int sharing = hc_comm_machine_ranks(comm, 0), grouped = hc_comm_machine_ranks(comm, limit.group);
  const double share = fmin((double)hc_memory_machine() / sharing, (double)limit.bytes / grouped);
  const double most = fmin(share, (double)hc_memory_allowed());
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

/* Puts moving walls where they stand now; `held`: without their speed. */
static void pose_walls(hc_simulation *simulation, bool held) {
  hc_bodies_pose(&simulation->bodies, simulation->time, &simulation->movers);
  hc_movers_pose(&simulation->movers, &simulation->world, simulation->time,
                 simulation->control.settings->longest, held);
  if (!simulation->window.there) return;
  hc_window_pose(&simulation->window, &simulation->world);
  hc_population_go(&simulation->population, &simulation->world.frame, simulation->window.shift);
}

void hc_simulation_pose_walls(hc_simulation *simulation) {
  pose_walls(simulation, false);
}

double hc_simulation_prescribed_speed(const hc_scene *scene, const hc_movers *movers,
                                      const hc_emitters *emitters) {
  return hc_prescribed_speed(movers, emitters, 0.0, hc_setup_control_longest(scene));
}

/* Lets the start come to rest: steps of gravity and pressure that forget all momentum; then every particle
 * gets the velocity of the place it has come to. The pressure stays. */
static hc_status settle(hc_simulation *simulation, hc_error *error) {
  hc_world *world = &simulation->world;
  hc_particles *fluid = world->fluid;
  hc_solver_settings *settings = simulation->solver_settings;
  const hc_viscous_force viscosity = settings->viscosity;
  const double dt = hc_setup_settle_step(simulation->scene);
  const hc_wall_friction *const friction = world->sweep.friction;
  settings->viscosity = HC_VISCOUS_NONE;
  world->sweep.friction = NULL;
  hc_status status = HC_OK;
  int step = 0;
  for (; status == HC_OK && step < simulation->scene->fluid.settle_steps; step++) {
    memset(fluid->velocity, 0, 3 * (size_t)fluid->own * sizeof *fluid->velocity);
    hc_world_update(world);
    if (simulation->solver->evaluate) simulation->solver->evaluate(world, settings, &simulation->report);
    status =
        simulation->solver->step(world, NULL, settings, dt, step > 0 ? dt : 0.0, &simulation->report, error);
  }
  settings->viscosity = viscosity;
  world->sweep.friction = friction;
  if (status != HC_OK) {
    const hc_error found = *error;
    return hc_error_set(error, HC_FAILED, "the simulation diverged while its start settled, step %d: %.4000s",
                        step, found.text);
  }
  hc_setup_velocities(&simulation->plan, fluid);
  pose_walls(simulation, false);
  simulation->dt = dt;
  return HC_OK;
}

hc_resting hc_simulation_resting(hc_simulation *simulation, hc_step_report *report) {
  return (hc_resting){.world = &simulation->world,
                      .bodies = &simulation->bodies,
                      .solver = simulation->solver,
                      .settings = simulation->solver_settings,
                      .report = report,
                      .spacing = simulation->scene->particle_spacing};
}

hc_status hc_simulation_fit(hc_simulation *simulation, const hc_scene_rest *rules, const hc_rest_fresh *fresh,
                            double dt, hc_error *error) {
  hc_step_report report = simulation->report;
  const hc_resting resting = hc_simulation_resting(simulation, &report);
  pose_walls(simulation, true); /* nothing moves meanwhile */
  hc_rest_fit(&resting, rules, dt, fresh, &simulation->rest, error);
  pose_walls(simulation, false);
  hc_simulation_disturb(simulation);
  return error->status;
}

/* Blocks of rest states fit themselves to the others and to walls. */
static hc_status fit_rest_states(hc_simulation *simulation, hc_error *error) {
  const hc_scene *const scene = simulation->scene;
  const double dt = hc_setup_calm_step(scene);
  bool *const fresh = hc_alloc_zero((size_t)scene->fluid.block_count, sizeof *fresh);
  for (int k = 0; k < scene->fluid.block_count; k++) fresh[k] = scene->fluid.blocks[k].rest_state[0] != '\0';
  hc_simulation_fit(simulation, &scene->fluid.rest,
                    &(hc_rest_fresh){.source = fresh, .sources = scene->fluid.block_count}, dt, error);
  hc_free(fresh);
  if (error->status != HC_OK) return error->status;
  hc_setup_velocities(&simulation->plan, simulation->world.fluid);
  pose_walls(simulation, scene->fluid.settle_steps > 0);
  simulation->dt = dt;
  hc_world_rebalance(&simulation->world, hc_balance_first_divider(scene), 0.0);
  return HC_OK;
}

/* The particles of the scene, at their owners. */
static hc_status fill_world(hc_simulation *simulation, hc_error *error) {
  hc_comm *comm = simulation->comm;
  hc_world *world = &simulation->world;
  hc_setup_generate(&simulation->plan, comm->rank, comm->size, world->fluid, world->boundary, world->moving,
                    error);
  if (hc_comm_agree(comm, error) != HC_OK) return error->status;
  hc_movers_start(world->moving);
  pose_walls(simulation, simulation->scene->fluid.settle_steps > 0);
  hc_world_start(world, hc_balance_first_divider(simulation->scene));
  hc_window_remember(&simulation->window, world, HC_ID_AIR);
  if (hc_setup_has_rest_states(simulation->scene) && fit_rest_states(simulation, error) != HC_OK)
    return error->status;
  if (simulation->scene->fluid.settle_steps > 0 && settle(simulation, error) != HC_OK) return error->status;
  hc_world_update(world);
  hc_bodies_touch(&simulation->bodies, world);
  hc_absorption_start(&simulation->population.absorption, world);
  hc_window_remember(&simulation->window, world, HC_ID_FLUID);
  hc_setup_plan_free(&simulation->plan);
  return HC_OK;
}

hc_particle_name hc_simulation_particle_name(const hc_scene *scene, int64_t id) {
  hc_particle_name name;
  const struct {
    const char *name;
    int count;
  } kinds[] = {{"fluid.blocks", scene->fluid.block_count},
               {"fluid.emitters", scene->fluid.emitter_count},
               {"absorption", scene->absorption_count},
               {"window", 1}};
  int64_t source = hc_id_source_of((uint64_t)id);
  int kind = 0;
  while (kind < 3 && source >= kinds[kind].count) source -= kinds[kind++].count;
  snprintf(name.text, sizeof name.text, "%lld (number %lld of %s[%lld])", (long long)id,
           (long long)hc_id_counter_of((uint64_t)id), kinds[kind].name, (long long)source);
  return name;
}

void hc_simulation_fill_derived(hc_simulation *simulation) {
  hc_particles *fluid = simulation->world.fluid;
  memset(fluid->pressure, 0, (size_t)fluid->own * sizeof *fluid->pressure);
  simulation->solver->densities(&simulation->world, simulation->solver_settings);
  memset(fluid->acceleration, 0, 3 * (size_t)fluid->own * sizeof *fluid->acceleration);
}

static void register_state(hc_simulation *simulation) {
  hc_state *state = &simulation->state;
  hc_state_init(state);
  for (int k = 0; k < HC_STORE_COUNT; k++) hc_state_add_store(state, &simulation->world.stores[k].particles);
  hc_state_add(state, HC_TYPE_i64, 1, &simulation->step, "step");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->time, "time");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->dt, "dt");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.v_max, "v_max");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.force_max, "force_max");
  hc_state_add(state, HC_TYPE_i64, 1, &simulation->capped_at, "capped_at");
  hc_state_add(state, HC_TYPE_i64, 1, &simulation->world.fluid_total, "fluid_total");
  hc_population_register(&simulation->population, state);
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->refilled, "refilled");
  hc_bodies_register(&simulation->bodies, state);
  hc_window_register(&simulation->window, state);
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.density_error_avg, "density_error_avg");
  hc_state_add(state, HC_TYPE_f64, 1, &simulation->report.density_error_max, "density_error_max");
  hc_control_register(&simulation->control, state);
}

static hc_status check_start(const hc_simulation *simulation, hc_error *error) {
  /* of rest states single particles in corners may be too dense */
  if (!simulation->solver->check_start || simulation->unsettled ||
      hc_setup_has_rest_states(simulation->scene))
    return HC_OK;
  return simulation->solver->check_start(&simulation->world, simulation->solver_settings, error);
}

/* What is known of the particles before there are any. Agreed. */
static hc_status plan_particles(hc_simulation *simulation, hc_error *error) {
  hc_setup_plan *plan = &simulation->plan;
  const hc_scene *scene = simulation->scene;
  if (hc_prescribed_emitters_make(scene, &simulation->world.frame, &simulation->population.emitters, error) ==
          HC_OK &&
      hc_setup_plan_make(simulation->comm, scene, &simulation->world.frame, plan, error) == HC_OK &&
      hc_setup_limits(scene, plan, &simulation->population.emitters, &simulation->population.limits, error) ==
          HC_OK &&
      hc_setup_absorption(scene, plan, &simulation->population.absorption, error) == HC_OK)
    check_memory(simulation->comm, scene, plan, error);
  if (hc_comm_agree(simulation->comm, error) != HC_OK) return error->status;
  simulation->movers = hc_prescribed_movers_make(scene, plan);
  simulation->bodies = hc_setup_bodies_make(scene, plan, &simulation->world.frame);
  simulation->population.at_start = simulation->population.limits;
  hc_window_make(scene, plan, &simulation->bodies, &simulation->window, error);
  if (hc_comm_agree(simulation->comm, error) != HC_OK) return error->status;
  simulation->population.remove = scene->domain.leaving == HC_LEAVING_REMOVE;
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
  simulation->solver = hc_setup_solver_ops(scene);

  hc_frame frame;
  if (hc_setup_frame(scene, &frame, error) != HC_OK) return error->status;
  simulation->control = hc_setup_control(scene);
  simulation->rollback.most = simulation->control.goes_back;
  simulation->solver_settings = hc_setup_solver_settings(scene);
  const double ratio = scene->particle_spacing / scene->support_radius, h = frame.support_radius;
  const double volume_factor = hc_settings_wall_factor(scene);
  const hc_world_settings settings = {
      .frame = frame,
      .rest_density = scene->fluid.rest_density,
      .mass =
          scene->fluid.rest_density * scene->fluid.mass_factor * h * h * h / hc_setup_rest_lattice_sum(ratio),
      .volume_factor = volume_factor,
      .contact_limit = scene->boundary.contact ? hc_setup_contact_limit(ratio, volume_factor) : 0.0,
      .start_limit = hc_setup_start_limit(ratio, volume_factor),
      .flat_wall = hc_settings_flat_wall(scene),
      .friction = hc_settings_friction(scene),
      .friction_differs = hc_settings_friction_differs(scene),
      .no_slip = hc_settings_no_slip(scene),
      .compressible = simulation->solver->compressible,
      .drag = hc_solver_wall_drag(simulation->solver_settings, h),
      .boundary_ops = hc_settings_boundary(scene),
      .features = hc_settings_features(scene),
      .isa = simulation->isa,
      .ranks_per_host = scene->parallel.ranks_per_host};
  hc_world_init(&simulation->world, comm, &settings);
  if (plan_particles(simulation, error) != HC_OK) hc_simulation_free(simulation);
  return error->status;
}

hc_status hc_simulation_populate(hc_simulation *simulation, hc_error *error) {
  hc_world *world = &simulation->world;
  if (fill_world(simulation, error) != HC_OK) return error->status;
  hc_simulation_fill_derived(simulation);
  if (check_start(simulation, error) != HC_OK) return error->status;
  simulation->imbalance = hc_domain_imbalance(&world->domain, world->fluid);
  double v2_max = hc_fastest(world->fluid);
  hc_comm_max_f64(simulation->comm, &v2_max, 1);
  simulation->report = hc_settings_start_report(simulation->scene, v2_max);
  return HC_OK;
}

void hc_simulation_adopt(hc_simulation *simulation) {
  hc_world *world = &simulation->world;
  hc_window_adopt(&simulation->window);
  pose_walls(simulation, false);
  hc_world_distribute(world, hc_balance_first_divider(simulation->scene));
  hc_world_update(world);
  hc_bodies_touch(&simulation->bodies, world);
  hc_absorption_count(&simulation->population.absorption, world);
  simulation->imbalance = hc_domain_imbalance(&world->domain, world->fluid);
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
  hc_control_free(&simulation->control);
  hc_free(simulation->solver_settings);
  hc_rollback_free(&simulation->rollback);
  hc_movers_free(&simulation->movers);
  hc_bodies_free(&simulation->bodies);
  hc_window_free(&simulation->window);
  hc_impulses_free(&simulation->loads);
  hc_population_free(&simulation->population);
  hc_state_free(&simulation->state);
  hc_world_free(&simulation->world);
}

bool hc_simulation_done(const hc_simulation *simulation) {
  return simulation->time >= simulation->scene->end_time;
}

/* Bodies are among the movers. */
hc_step_report hc_simulation_seen_by_control(const hc_simulation *simulation) {
  hc_step_report report = simulation->report;
  report.v_max = fmax(report.v_max, simulation->movers.speed);
  report.v_max = fmax(report.v_max, hc_population_speed(&simulation->population, simulation->time,
                                                        simulation->control.settings->longest));
  return report;
}

hc_moment hc_simulation_moment(const hc_simulation *simulation) {
  const hc_world *world = &simulation->world;
  return (hc_moment){.frame = &world->frame,
                     .fluid = world->fluid,
                     .boundary = world->boundary,
                     .moving = world->moving,
                     .step = simulation->step,
                     .time = simulation->time,
                     .dt = simulation->dt,
                     .particle_mass = world->mass};
}

void hc_simulation_disturb(hc_simulation *simulation) {
  hc_domain_forget_partners(&simulation->world.domain);
  simulation->population.counted = false;
  simulation->population.absorption.places.moved = true;
  simulation->window.places.moved = true;
}

void hc_simulation_show_resumable(hc_simulation *simulation, hc_state_copy *now) {
  if (!hc_rollback_show_resumable(&simulation->rollback, &simulation->state, now)) return;
  hc_simulation_disturb(simulation);
  hc_simulation_pose_walls(simulation);
}

void hc_simulation_show_now(hc_simulation *simulation, hc_state_copy *now) {
  if (!hc_rollback_show_now(&simulation->state, now)) return;
  hc_simulation_disturb(simulation);
  hc_simulation_pose_walls(simulation);
  hc_world_update(&simulation->world);
  hc_bodies_touch(&simulation->bodies, &simulation->world);
}
