#include "estimate.h"

#include "base/check.h"
#include "base/memory.h"
#include "gauges/gauges.h"
#include "io/snapshot.h"
#include "setup/bodies.h"
#include "setup/controls.h"
#include "setup/settings.h"
#include "setup/world_frame.h"
#include "simulation/footprint.h"
#include "simulation/simulation.h"
#include "window/window.h"

#include <limits.h>
#include <math.h>

/* Bytes; see the head of estimate.h. */
enum {
  WRITING = 30,
  WRITING_SLICE = 65536, /* particles */
  STEP_ROWS = 200,       /* of a step in steps.csv and load.csv */
  GAUGE_VALUE = 20,      /* in gauges.csv */
  SERIES_ENTRY = 60,     /* of a snapshot in run.hdf.series */
  CHECKPOINT_HEADERS = 20480,
  OTHER_FILES = 8192 /* scene.yaml, run.log, timings.json */
};

enum { AT_A_TIME = 1 << 18 }; /* particles made in one go */

/* ---- particles ---- */

/* A set while it is counted, in units. */
typedef struct tally {
  int64_t count, low[3], high[3];
} tally;

static tally *no_tallies(int count) {
  tally *tallies = hc_alloc((size_t)count, sizeof *tallies);
  for (int k = 0; k < count; k++)
    tallies[k] = (tally){0, {INT64_MAX, INT64_MAX, INT64_MAX}, {INT64_MIN, INT64_MIN, INT64_MIN}};
  return tallies;
}

static void count_particles(const hc_particles *particles, tally *sources, int source_count) {
  for (int32_t k = 0; k < particles->own; k++) {
    const int64_t source = hc_id_source_of(particles->id[k]);
    if (hc_id_kind_of(particles->id[k]) == HC_ID_AIR)
      continue; /* around rest states: it goes before the start */
    HC_CHECK(source < source_count, "particle of source %lld of %d", (long long)source, source_count);
    const int64_t *position = &particles->position[3 * (size_t)k];
    tally *into = &sources[source];
    into->count++;
    for (int axis = 0; axis < 3; axis++) {
      if (position[axis] < into->low[axis]) into->low[axis] = position[axis];
      if (position[axis] > into->high[axis]) into->high[axis] = position[axis];
    }
  }
}

static void merge(hc_estimate_set *into, const hc_estimate_set *set) {
  into->count += set->count;
  for (int axis = 0; axis < 3; axis++) {
    into->low[axis] = fmin(into->low[axis], set->low[axis]);
    into->high[axis] = fmax(into->high[axis], set->high[axis]);
  }
}

static hc_estimate_set empty_set(void) {
  return (hc_estimate_set){0, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

/* The tallies in metres, and all of them together. */
static hc_estimate_set *sets_of(const hc_frame *frame, const tally *tallies, int count,
                                hc_estimate_set *together) {
  hc_estimate_set *sets = hc_alloc((size_t)count, sizeof *sets);
  *together = empty_set();
  for (int k = 0; k < count; k++) {
    sets[k] = empty_set();
    sets[k].count = tallies[k].count;
    for (int axis = 0; axis < 3 && tallies[k].count > 0; axis++) {
      sets[k].low[axis] = hc_frame_to_metres(frame, axis, tallies[k].low[axis]);
      sets[k].high[axis] = hc_frame_to_metres(frame, axis, tallies[k].high[axis]);
    }
    merge(together, &sets[k]);
  }
  return sets;
}

/* Makes all particles, part by part. */
static hc_status survey(const hc_setup_plan *plan, tally *blocks, tally *walls, double *v2_max,
                        hc_error *error) {
  const int64_t most = plan->fluid_count > plan->boundary_count ? plan->fluid_count : plan->boundary_count;
  const int parts = (int)(most / AT_A_TIME) + 1;
  hc_particles fluid, boundary, moving;
  hc_particles_init(&fluid, HC_FLUID, 0);
  hc_particles_init(&boundary, HC_BOUNDARY, 0);
  hc_particles_init(&moving, HC_BOUNDARY | HC_MOVED, 0);
  hc_status status = HC_OK;
  *v2_max = 0.0;
  for (int part = 0; status == HC_OK && part < parts; part++) {
    status = hc_setup_generate(plan, part, parts, &fluid, &boundary, &moving, error);
    if (status != HC_OK) break;
    count_particles(&fluid, blocks, plan->fluid_sources);
    count_particles(&boundary, walls, plan->boundary_sources);
    count_particles(&moving, walls, plan->boundary_sources);
    *v2_max = fmax(*v2_max, hc_fastest(&fluid));
  }
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  hc_particles_free(&moving);
  return status;
}

static hc_status estimate_particles(const hc_setup_plan *plan, hc_estimate *estimate, double *v2_max,
                                    hc_error *error) {
  tally *blocks = no_tallies(plan->fluid_sources), *walls = no_tallies(plan->boundary_sources);
  const hc_status status = survey(plan, blocks, walls, v2_max, error);
  if (status == HC_OK) {
    estimate->blocks = sets_of(&plan->frame, blocks, plan->fluid_sources, &estimate->fluid);
    estimate->walls = sets_of(&plan->frame, walls, plan->boundary_sources, &estimate->boundary);
    estimate->all = estimate->fluid;
    merge(&estimate->all, &estimate->boundary);
  }
  hc_free(blocks);
  hc_free(walls);
  return status;
}

/* ---- time ---- */

static void estimate_steps(const hc_scene *scene, double v2_max, double prescribed, hc_estimate *estimate) {
  hc_control control = hc_setup_control(scene);
  const hc_step_report start = hc_settings_start_report(scene, fmax(v2_max, prescribed * prescribed));
  estimate->first_step = hc_control_next(&control, 0.0, hc_setup_settle_step(scene), &start);
  estimate->bound = control.bound;
  const hc_step_report still = {.v_max = 0.0};
  const double longest = hc_control_next(&control, 0.0, INFINITY, &still);
  estimate->steps = (int64_t)ceil(scene->end_time / longest * (1.0 - 1e-12));
  estimate->steps_exact = control.ops->foreseen;
  hc_control_free(&control);
}

/* ---- memory ---- */

/* Ghosts beside each of `count` particles that fill the box of a set, cut into slabs along `slab_axis`. */
static double ghost_share(const hc_scene *scene, const hc_estimate_set *set, int slab_axis, int64_t ranks) {
  double with_ghosts = 1.0;
  for (int axis = 0; axis < 3; axis++) {
    double length = set->high[axis] - set->low[axis] + scene->particle_spacing;
    const bool cut = axis == slab_axis && ranks > 1;
    if (cut) length /= (double)ranks;
    if (cut || scene->domain.periodic[axis]) with_ghosts *= 1.0 + 2.0 * scene->support_radius / length;
  }
  return with_ghosts - 1.0;
}

static int longest_axis(const hc_estimate_set *set) {
  int longest = 0;
  for (int axis = 1; axis < 3; axis++)
    if (set->high[axis] - set->low[axis] > set->high[longest] - set->low[longest]) longest = axis;
  return longest;
}

static void estimate_memory(const hc_scene *scene, hc_estimate *estimate) {
  const double ranks = (double)estimate->ranks;
  const double fluid = (double)estimate->fluid_most, boundary = (double)estimate->boundary.count;
  const double uneven = fmin(scene->parallel.rebalance_above, ranks);
  const double load = (HC_COST_FLUID * fluid + HC_COST_BOUNDARY * boundary) / ranks * uneven;
  const double own_boundary = fmin(boundary, load / HC_COST_BOUNDARY);
  const double own_fluid = (load - HC_COST_BOUNDARY * own_boundary) / HC_COST_FLUID;
  const int axis = longest_axis(&estimate->all);
  double ghosts = 0.0;
  if (estimate->fluid.count > 0)
    ghosts += fluid / ranks * ghost_share(scene, &estimate->fluid, axis, estimate->ranks);
  if (boundary > 0)
    ghosts += boundary / ranks * ghost_share(scene, &estimate->boundary, axis, estimate->ranks);
  estimate->memory_program = HC_FOOTPRINT_PROGRAM;
  estimate->memory_fluid = hc_footprint_fluid(scene) * own_fluid;
  estimate->memory_boundary = hc_footprint_wall(scene) * own_boundary;
  estimate->memory_ghosts = hc_footprint_ghost(scene) * ghosts;
  estimate->memory_writing = WRITING * fmin(own_fluid + own_boundary, WRITING_SLICE);
  estimate->memory = estimate->memory_program + estimate->memory_fluid + estimate->memory_boundary +
                     estimate->memory_ghosts + estimate->memory_writing;
}

/* ---- files ---- */

static hc_status estimate_output(const hc_scene *scene, hc_estimate *estimate, hc_error *error) {
  int64_t bytes;
  if (hc_snapshot_bytes(scene, estimate->fluid_most + estimate->boundary.count, &bytes, error) != HC_OK)
    return error->status;
  const double every = scene->output.snapshots_every;
  const double intervals = every > 0.0 ? ceil(scene->end_time / every * (1.0 - 1e-12)) : 1.0;
  estimate->snapshots = 1 + (int64_t)intervals;
  if (estimate->steps_exact && estimate->snapshots > estimate->steps + 1)
    estimate->snapshots = estimate->steps + 1;
  estimate->snapshot_bytes = (double)bytes;
  estimate->checkpoint_bytes =
      (double)estimate->fluid_most * (hc_footprint_fluid_state(scene) + hc_footprint_places(scene)) +
      (double)estimate->boundary.count * hc_footprint_wall_state(scene) + CHECKPOINT_HEADERS;
  const int every_steps = scene->output.checkpoints_every_steps;
  const bool many = every_steps > 0 && estimate->steps > every_steps;
  double readings = (double)estimate->steps;
  if (scene->output.gauges_every > 0.0)
    readings = fmin(readings, scene->end_time / scene->output.gauges_every);
  estimate->output_bytes = (double)estimate->snapshots * ((double)bytes + SERIES_ENTRY) +
                           (many ? scene->output.checkpoints_keep : 1) * estimate->checkpoint_bytes +
                           (double)estimate->steps * STEP_ROWS +
                           readings * GAUGE_VALUE * (1 + hc_gauges_columns(scene)) + OTHER_FILES;
  return HC_OK;
}

/* ---- what is prescribed ---- */

static void estimate_emitters(const hc_scene *scene, const hc_emitters *emitters, hc_estimate *estimate) {
  estimate->emitters = hc_alloc((size_t)emitters->count, sizeof *estimate->emitters);
  estimate->fluid_most = estimate->fluid.count;
  for (int k = 0; k < emitters->count; k++) {
    const hc_emitter *emitter = &emitters->emitters[k];
    hc_estimate_emitter *into = &estimate->emitters[k];
    *into = (hc_estimate_emitter){.samples = emitter->sample_count,
                                  .most = (int64_t)hc_emitter_most(emitter, scene->end_time),
                                  .speed = emitter->speed,
                                  .rate = emitter->speed * (double)emitter->sample_count * emitter->spacing *
                                          emitter->spacing};
    hc_prescribed_emitter_bounds(emitter, into->low, into->high);
    estimate->fluid_most += into->most;
  }
}

static void estimate_motions(const hc_scene *scene, const hc_movers *motions, hc_estimate *estimate) {
  estimate->swept = hc_alloc((size_t)hc_scene_surfaces(scene), sizeof *estimate->swept);
  for (int k = 0; k < hc_scene_surfaces(scene); k++) estimate->swept[k] = empty_set();
  for (int k = 0; k < motions->count; k++) {
    hc_estimate_set *swept = &estimate->swept[motions->walls[k].wall];
    if (motions->walls[k].motion.law == HC_MOTION_BODY) continue;
    *swept = estimate->walls[motions->walls[k].wall];
    if (swept->count > 0)
      hc_prescribed_sweep(&motions->walls[k].motion, scene->end_time, swept->low, swept->high);
  }
}

static hc_status estimate_limits(const hc_scene *scene, const hc_setup_plan *plan,
                                 const hc_emitters *emitters, hc_estimate *estimate, hc_error *error) {
  hc_limits limits;
  if (hc_setup_limits(scene, plan, emitters, &limits, error) != HC_OK) return error->status;
  for (int axis = 0; axis < 3; axis++) {
    estimate->limits_low[axis] = hc_limits_low(&limits, &plan->frame, axis);
    estimate->limits_high[axis] = hc_limits_high(&limits, &plan->frame, axis);
  }
  return HC_OK;
}

/* Whether a window can go along. */
static hc_status check_window(const hc_scene *scene, const hc_setup_plan *plan, hc_error *error) {
  hc_bodies bodies = hc_setup_bodies_make(scene, plan, &plan->frame);
  hc_window window;
  const hc_status status = hc_window_make(scene, plan, &bodies, &window, error);
  hc_window_free(&window);
  hc_bodies_free(&bodies);
  return status;
}

/* Everything that is told apart from the plan, which is the scene's. */
static hc_status estimate_from_plan(const hc_scene *scene, const hc_setup_plan *plan, hc_estimate *estimate,
                                    hc_error *error) {
  double v2_max;
  hc_emitters emitters;
  const int size = estimate->ranks < INT_MAX ? (int)estimate->ranks : INT_MAX;
  hc_status status = hc_prescribed_emitters_make(scene, &plan->frame, &emitters, error);
  if (status == HC_OK)
    status = hc_setup_check_share(plan, size - 1, size, error); /* the largest is the last */
  if (status == HC_OK) status = estimate_limits(scene, plan, &emitters, estimate, error);
  if (status == HC_OK) status = check_window(scene, plan, error);
  if (status == HC_OK) status = estimate_particles(plan, estimate, &v2_max, error);
  if (status == HC_OK) {
    hc_movers motions = hc_prescribed_movers_make(scene, plan);
    estimate_emitters(scene, &emitters, estimate);
    estimate_motions(scene, &motions, estimate);
    estimate_steps(scene, v2_max, hc_simulation_prescribed_speed(scene, &motions, &emitters), estimate);
    hc_movers_free(&motions);
  }
  hc_emitters_free(&emitters);
  return status;
}

hc_status hc_estimate_make(const hc_scene *scene, int64_t ranks, hc_estimate *estimate, hc_error *error) {
  hc_frame frame;
  hc_setup_plan plan;
  *estimate = (hc_estimate){.ranks = ranks};
  if (hc_setup_frame(scene, &frame, error) != HC_OK) return error->status;
  if (hc_setup_plan_make(NULL, scene, &frame, &plan, error) != HC_OK) return error->status;
  hc_status status = estimate_from_plan(scene, &plan, estimate, error);
  hc_setup_plan_free(&plan);
  if (status != HC_OK) return status;
  estimate_memory(scene, estimate);
  status = estimate_output(scene, estimate, error);
  if (status != HC_OK) hc_estimate_free(estimate);
  return status;
}

void hc_estimate_free(hc_estimate *estimate) {
  hc_free(estimate->blocks);
  hc_free(estimate->walls);
  hc_free(estimate->emitters);
  hc_free(estimate->swept);
  *estimate = (hc_estimate){.ranks = 0};
}
