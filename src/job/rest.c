#include "rest.h"

#include "base/memory.h"
#include "io/rest_file.h"
#include "particles/ids.h"
#include "setup/controls.h"
#include "setup/rest_states.h"
#include "simulation/simulation.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Steps of strong damping, then of weak; how often fewer particles are tried; and less disorder. */
enum { STRONG = 40, WEAK = 160, TRIES = 12, HALVINGS = 4 };
static const double DISORDER = 0.5;    /* spacings: at the start, where the scene has none */
static const double SLOWEST = 0.002;   /* half spacings a step: at rest none is faster */
static const double WILD = 0.5;        /* the same: this is not on its way to rest */
static const double FEWER = 0.001;     /* share of the particles that goes where there is no rest */
static const double DENSEST = 0.002;   /* above the rest density, at most; */
static const double COMPRESSED = 0.01; /* of fluid that is compressible */

typedef struct rest_job {
  hc_comm *comm;
  const hc_scene *scene;
  hc_simulation simulation;
  hc_rest_state state;
  int64_t started; /* particles of the lattice */
} rest_job;

static hc_status check_scene(const hc_scene *scene, hc_error *error) {
  if (scene->body_count > 0 || scene->fluid.emitter_count > 0)
    return hc_error_set(error, HC_BAD_INPUT, "a rest state is made of fluid and walls: %s must be left out",
                        scene->body_count > 0 ? "bodies" : "fluid.emitters");
  if (hc_setup_has_refills(scene) || scene->fluid.block_count == 0)
    return hc_error_set(error, HC_BAD_INPUT, "a rest state is made of fluid that is there at the start: %s",
                        scene->fluid.block_count > 0 ? "fluid.blocks must have no start > 0"
                                                     : "fluid.blocks must have one");
  return HC_OK;
}

/* ---- coming to rest ---- */

/* Takes every n-th particle of the lattice out, others in each try, so that `share` of them all goes. */
static void thin_out(rest_job *job, double share, int attempt) {
  hc_world *const world = &job->simulation.world;
  hc_particles *const fluid = world->fluid;
  const int64_t every = llrint(1.0 / share);
  int32_t *const indices = hc_alloc((size_t)fluid->own, sizeof *indices);
  int32_t found = 0;
  for (int32_t i = 0; i < fluid->own; i++)
    if (hc_id_counter_of(fluid->id[i]) % every == (attempt * (every / TRIES)) % every) indices[found++] = i;
  if (found) hc_particles_remove(fluid, indices, found);
  hc_free(indices);
  hc_world_count_fluid(world);
}

static hc_status relax(rest_job *job, double damping, int steps, hc_error *error) {
  hc_simulation *const simulation = &job->simulation;
  const hc_resting resting = hc_simulation_resting(simulation, &simulation->report);
  const bool compressible = simulation->solver->compressible; /* its steps are so short that all are slow */
  const hc_relaxing how = {.dt = hc_setup_calm_step(job->scene),
                           .steps = steps,
                           .damping_start = damping,
                           .damping_end = damping,
                           .speed_max = compressible ? 0.0 : SLOWEST,
                           .speed_avg = SLOWEST};
  hc_relaxed relaxed;
  hc_relax(&resting, &how, &relaxed, error);
  job->state.steps += relaxed.steps;
  job->state.speed_max = relaxed.speed_max;
  return error->status;
}

/* Mean, largest and deviation of the densities. */
static void measure(rest_job *job) {
  hc_simulation *const simulation = &job->simulation;
  hc_world *const world = &simulation->world;
  hc_sum sums[2];
  double most = 0.0;
  memset(sums, 0, sizeof sums);
  hc_simulation_disturb(simulation);
  hc_world_update(world);
  simulation->solver->densities(world, simulation->solver_settings);
  for (int32_t i = 0; i < world->fluid->own; i++) {
    const double density = (double)world->fluid->density[i] / job->scene->fluid.rest_density;
    hc_sum_add(&sums[0], density);
    hc_sum_add(&sums[1], density * density);
    most = fmax(most, density);
  }
  hc_tally tally = {.count = 0};
  hc_tally_sum_exact(&tally, sums, 2);
  hc_tally_max_f64(&tally, &most, 1);
  hc_tally_reduce(job->comm, &tally);
  const double count = (double)world->fluid_total, mean = hc_sum_value(&sums[0]) / count;
  job->state.density_mean = mean;
  job->state.density_deviation = sqrt(fmax(0.0, hc_sum_value(&sums[1]) / count - mean * mean));
  job->state.density_max = most;
}

static bool is_at_rest(const rest_job *job) {
  const double denser = job->simulation.solver->compressible ? COMPRESSED : DENSEST;
  return job->state.speed_max <= SLOWEST && job->state.density_max <= 1.0 + denser;
}

static hc_status find_rest(rest_job *job, bool quiet, bool *diverged, hc_error *error) {
  for (int attempt = 0; attempt < TRIES; attempt++) {
    if (attempt > 0) thin_out(job, FEWER, attempt);
    *diverged = relax(job, 0.2, STRONG, error) != HC_OK || relax(job, 0.05, WEAK, error) != HC_OK;
    if (*diverged) return error->status;
    measure(job);
    if (job->comm->rank == 0 && !quiet)
      fprintf(stderr,
              "%lld particles, %lld damped steps: density %.5f, deviation %.5f, at most %.5f; the fastest at "
              "%.2g half "
              "spacings a step\n",
              (long long)job->simulation.world.fluid_total, (long long)job->state.steps,
              job->state.density_mean, job->state.density_deviation, job->state.density_max,
              job->state.speed_max);
    if (is_at_rest(job)) return HC_OK;
    *diverged = job->state.speed_max > WILD;
    if (*diverged) break;
  }
  return hc_error_set(
      error, HC_FAILED,
      "the fluid finds no rest: after %lld damped steps and with %.2g %% fewer particles than the lattice "
      "its fastest particle moves by %.2g half spacings a step, its densest is at %.5f of the rest density",
      (long long)job->state.steps,
      100.0 * (1.0 - (double)job->simulation.world.fluid_total / (double)job->started), job->state.speed_max,
      job->state.density_max);
}

/* ---- the state ---- */

static int by_place(const void *a, const void *b) {
  const int32_t *const p = a, *const q = b;
  for (int axis = 0; axis < 3; axis++)
    if (p[axis] != q[axis]) return p[axis] < q[axis] ? -1 : 1;
  return 0;
}

/* What the fluid fills: along periodic axes a period, else from half a spacing below to half one above. */
static void find_extent(rest_job *job, double low[3]) {
  const hc_world *const world = &job->simulation.world;
  double ends[6] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY};
  for (int32_t i = 0; i < world->fluid->own; i++)
    for (int axis = 0; axis < 3; axis++) {
      const double x =
          hc_frame_to_metres(&world->frame, axis, world->fluid->position[3 * (size_t)i + (size_t)axis]);
      ends[axis] = fmax(ends[axis], -x);
      ends[3 + axis] = fmax(ends[3 + axis], x);
    }
  hc_comm_max_f64(job->comm, ends, 6);
  const double spacing = job->scene->particle_spacing;
  for (int axis = 0; axis < 3; axis++) {
    job->state.periodic[axis] = job->scene->domain.periodic[axis];
    low[axis] = job->state.periodic[axis] ? job->scene->domain.min[axis] : -ends[axis] - 0.5 * spacing;
    const double high =
        job->state.periodic[axis] ? job->scene->domain.max[axis] : ends[3 + axis] + 0.5 * spacing;
    job->state.extent[axis] = llrint((high - low[axis]) / spacing * HC_REST_PARTS);
  }
}

/* Positions of all ranks on rank 0, in an order of their own. */
static void gather(rest_job *job, const double low[3]) {
  const hc_world *const world = &job->simulation.world;
  const hc_particles *const fluid = world->fluid;
  const double spacing = job->scene->particle_spacing;
  int32_t(*const own)[3] = hc_alloc((size_t)fluid->own, sizeof *own);
  for (int32_t i = 0; i < fluid->own; i++)
    for (int axis = 0; axis < 3; axis++) {
      const double x =
          hc_frame_to_metres(&world->frame, axis, fluid->position[3 * (size_t)i + (size_t)axis]) - low[axis];
      const int64_t parts = llrint(x / spacing * HC_REST_PARTS), extent = job->state.extent[axis];
      own[i][axis] = (int32_t)(((parts % extent) + extent) % extent);
    }
  void *all = NULL;
  size_t bytes = 0;
  hc_comm_gather(job->comm, own, (size_t)fluid->own * sizeof *own, 0, &all, &bytes);
  job->state.position = all;
  job->state.count = (int64_t)(bytes / sizeof *own);
  if (all) qsort(all, (size_t)job->state.count, sizeof *own, by_place);
  hc_free(own);
}

static void fill_facts(rest_job *job) {
  const hc_scene *const scene = job->scene;
  job->state.particle_spacing = scene->particle_spacing;
  job->state.support_radius = scene->support_radius;
  job->state.rest_density = scene->fluid.rest_density;
  job->state.mass_factor = scene->fluid.mass_factor;
  snprintf(job->state.solver, sizeof job->state.solver, "%s", job->simulation.solver->name);
}

static void make(rest_job *job, const hc_scene *scene, const char *path, bool quiet, bool *diverged,
                 hc_error *error) {
  job->started = job->simulation.world.fluid_total;
  if (find_rest(job, quiet, diverged, error) != HC_OK) return;
  double low[3];
  find_extent(job, low);
  gather(job, low);
  fill_facts(job);
  hc_rest_file_write(job->comm, scene, path, &job->state, error);
  hc_free(job->state.position);
}

/* From a lattice in disorder to a file; `diverged`: the disorder was too much. */
static hc_status try_disorder(hc_comm *comm, const hc_scene *scene, double disorder, const char *path,
                              bool quiet, bool *diverged, hc_error *error) {
  hc_scene start = *scene;
  start.fluid.settle_steps = 0;
  start.fluid.disorder = disorder;
  rest_job *const job = hc_alloc_zero(1, sizeof *job);
  job->comm = comm;
  job->scene = &start;
  *diverged = false;
  if (hc_simulation_prepare(&job->simulation, comm, &start, error) == HC_OK) {
    hc_solver_settings *const settings = job->simulation.solver_settings; /* no force but pressure acts */
    memset(settings->gravity, 0, sizeof settings->gravity);
    settings->central_rate = 0.0;
    job->simulation.unsettled = true;
    if (hc_simulation_populate(&job->simulation, error) == HC_OK)
      make(job, scene, path, quiet, diverged, error);
    hc_simulation_free(&job->simulation);
  }
  hc_free(job);
  return error->status;
}

hc_status hc_job_rest(hc_comm *comm, const hc_scene *scene, const char *path, bool quiet, hc_error *error) {
  if (check_scene(scene, error) != HC_OK) return error->status;
  const bool given = scene->fluid.disorder > 0.0;
  double disorder = given ? scene->fluid.disorder : DISORDER;
  for (int attempt = 0;; attempt++, disorder *= 0.5) {
    bool diverged;
    *error = (hc_error){.status = HC_OK};
    if (try_disorder(comm, scene, disorder, path, quiet, &diverged, error) == HC_OK || !diverged || given ||
        attempt == HALVINGS)
      return error->status;
    if (comm->rank == 0 && !quiet)
      fprintf(stderr, "a disorder of %g spacings is too much for the solver: half of it is tried\n",
              disorder);
  }
}
