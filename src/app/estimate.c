#include "estimate.h"

#include "base/check.h"
#include "base/memory.h"
#include "setup/populate.h"
#include "setup/world_frame.h"
#include "simulation.h"

#include <math.h>

/* Bytes; see the head of estimate.h. */
enum {
  PROGRAM = 30 << 20,
  FLUID = 330,
  WALL = 110,
  GHOST = 80,
  WRITING = 30,
  WRITING_SLICE = 65536, /* particles */
  STEP_ROWS = 200,       /* of a step in steps.csv and load.csv */
  SERIES_ENTRY = 60,     /* of a snapshot in run.hdf.series */
  OTHER_FILES = 8192     /* scene.yaml, run.log, timings.json */
};

enum { AT_A_TIME = 1 << 18 }; /* particles made in one go */

/* ---- particles ---- */

static hc_estimate_set empty_set(void) {
  return (hc_estimate_set){0, {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

static void take_in(hc_estimate_set *set, const double x[3]) {
  set->count++;
  for (int axis = 0; axis < 3; axis++) {
    set->low[axis] = fmin(set->low[axis], x[axis]);
    set->high[axis] = fmax(set->high[axis], x[axis]);
  }
}

static void count_particles(const hc_frame *frame, const hc_particles *particles, hc_estimate_set *kind,
                            hc_estimate_set *sources, int source_count, hc_estimate_set *all) {
  for (int32_t k = 0; k < particles->own; k++) {
    const int64_t source = hc_id_source_of(particles->id[k]);
    HC_CHECK(source < source_count, "particle of source %lld of %d", (long long)source, source_count);
    double x[3];
    for (int axis = 0; axis < 3; axis++)
      x[axis] = hc_frame_to_metres(frame, axis, particles->position[3 * (size_t)k + axis]);
    take_in(kind, x);
    take_in(&sources[source], x);
    take_in(all, x);
  }
}

static hc_estimate_set *empty_sets(int count) {
  hc_estimate_set *sets = hc_alloc((size_t)count, sizeof *sets);
  for (int k = 0; k < count; k++) sets[k] = empty_set();
  return sets;
}

/* Makes all particles, part by part. */
static hc_status survey(const hc_scene *scene, const hc_setup_plan *plan, hc_estimate *estimate,
                        double *v2_max, hc_error *error) {
  const int64_t most = plan->fluid_count > plan->boundary_count ? plan->fluid_count : plan->boundary_count;
  const int parts = (int)(most / AT_A_TIME) + 1;
  hc_particles fluid, boundary;
  hc_particles_init(&fluid, HC_FLUID);
  hc_particles_init(&boundary, HC_BOUNDARY);
  hc_status status = HC_OK;
  *v2_max = 0.0;
  for (int part = 0; status == HC_OK && part < parts; part++) {
    status = hc_setup_generate(plan, part, parts, &fluid, &boundary, error);
    if (status != HC_OK) break;
    count_particles(&plan->frame, &fluid, &estimate->fluid, estimate->blocks, scene->fluid.block_count,
                    &estimate->all);
    count_particles(&plan->frame, &boundary, &estimate->boundary, estimate->walls, scene->boundary.wall_count,
                    &estimate->all);
    *v2_max = fmax(*v2_max, hc_simulation_fastest(&fluid));
  }
  hc_particles_free(&fluid);
  hc_particles_free(&boundary);
  return status;
}

/* ---- time ---- */

static void estimate_steps(const hc_scene *scene, double v2_max, hc_estimate *estimate) {
  const hc_step_settings step = hc_step_settings_of(scene);
  const hc_step_report start = hc_simulation_start_report(scene, v2_max);
  estimate->first_step = hc_time_step_next(&step, 0.0, 0.0, &start, &estimate->bound);
  const double longest = step.control == HC_STEP_CONSTANT ? step.size : step.max;
  estimate->steps = (int64_t)ceil(scene->end_time / longest * (1.0 - 1e-12));
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
  const double fluid = (double)estimate->fluid.count, boundary = (double)estimate->boundary.count;
  const double uneven = fmin(scene->parallel.rebalance_above, ranks);
  const double load = (HC_DOMAIN_FLUID_WEIGHT * fluid + HC_DOMAIN_BOUNDARY_WEIGHT * boundary) / ranks;
  const double own_fluid = fluid / ranks * uneven;
  const double own_boundary = fmin(boundary, load / HC_DOMAIN_BOUNDARY_WEIGHT);
  const int axis = longest_axis(&estimate->all);
  double ghosts = 0.0;
  if (fluid > 0) ghosts += own_fluid * ghost_share(scene, &estimate->fluid, axis, estimate->ranks);
  if (boundary > 0)
    ghosts += boundary / ranks * ghost_share(scene, &estimate->boundary, axis, estimate->ranks);
  estimate->memory_program = PROGRAM;
  estimate->memory_fluid = FLUID * own_fluid;
  estimate->memory_boundary = WALL * own_boundary;
  estimate->memory_ghosts = GHOST * ghosts;
  estimate->memory_writing = WRITING * fmin(own_fluid + own_boundary, WRITING_SLICE);
  estimate->memory = estimate->memory_program + estimate->memory_fluid + estimate->memory_boundary +
                     estimate->memory_ghosts + estimate->memory_writing;
}

/* ---- files ---- */

static hc_status estimate_output(const hc_scene *scene, hc_estimate *estimate, hc_error *error) {
  int64_t bytes;
  if (hc_snapshot_bytes(scene, estimate->all.count, &bytes, error) != HC_OK) return error->status;
  const double every = scene->output.snapshots_every;
  const double intervals = every > 0.0 ? ceil(scene->end_time / every * (1.0 - 1e-12)) : 1.0;
  estimate->snapshots = 1 + (int64_t)intervals;
  if (scene->time_step.control == HC_TIME_CONSTANT && estimate->snapshots > estimate->steps + 1)
    estimate->snapshots = estimate->steps + 1;
  estimate->snapshot_bytes = (double)bytes;
  estimate->output_bytes = (double)estimate->snapshots * ((double)bytes + SERIES_ENTRY) +
                           (double)estimate->steps * STEP_ROWS + OTHER_FILES;
  return HC_OK;
}

hc_status hc_estimate_make(const hc_scene *scene, int64_t ranks, hc_estimate *estimate, hc_error *error) {
  hc_frame frame;
  hc_setup_plan plan;
  if (hc_setup_frame(scene, &frame, error) != HC_OK) return error->status;
  if (hc_setup_plan_make(scene, &frame, &plan, error) != HC_OK) return error->status;
  *estimate = (hc_estimate){.fluid = empty_set(),
                            .boundary = empty_set(),
                            .all = empty_set(),
                            .blocks = empty_sets(scene->fluid.block_count),
                            .walls = empty_sets(scene->boundary.wall_count),
                            .ranks = ranks};
  double v2_max;
  hc_status status = survey(scene, &plan, estimate, &v2_max, error);
  hc_setup_plan_free(&plan);
  if (status == HC_OK) {
    estimate_steps(scene, v2_max, estimate);
    estimate_memory(scene, estimate);
    status = estimate_output(scene, estimate, error);
  }
  if (status != HC_OK) hc_estimate_free(estimate);
  return status;
}

void hc_estimate_free(hc_estimate *estimate) {
  hc_free(estimate->blocks);
  hc_free(estimate->walls);
  *estimate = (hc_estimate){.ranks = 0};
}
