/* The files of a job: log, tables, timings. */
#include "base/memory.h"
#include "halocline/version.h"
#include "io/atomic_file.h"
#include "io/run_dir.h"
#include "io/series.h"
#include "io/text.h"
#include "io/timings.h"
#include "job.h"
#include "scene/writer.h"
#include "setup/absorptions.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* The columns of gauges.csv, each led by a comma; the caller's to free. */
static char *gauge_names(const hc_scene *scene) {
  const int columns = hc_gauges_columns(scene);
  char *names = hc_alloc_zero((size_t)columns * (HC_NAME_LENGTH + 16) + 1, 1), *end = names;
  for (int column = 0; column < columns; column++) {
    *end++ = ',';
    hc_gauges_column_name(scene, column, end, HC_NAME_LENGTH + 15);
    end += strlen(end);
  }
  return names;
}

/* What of a run that goes on is there no more: told, and made anew where that can be. */
static void mind_losses(hc_job *job, hc_error *error) {
  const char *const tables[] = {"steps.csv", "load.csv", "gauges.csv"};
  const int count = job->scene->output.gauge_count > 0 ? 3 : 2;
  char path[HC_TEXT_PATH];
  for (int k = 0; k < count && error->status == HC_OK; k++)
    if (hc_text_path(path, error, "%s/%s", job->directory, tables[k]) == HC_OK && access(path, F_OK) != 0)
      hc_log_warn(&job->log, "%s is not there: it begins anew behind step %lld", path,
                  (long long)job->simulation.step);
  bool made = false;
  if (error->status == HC_OK && hc_text_path(path, error, "%s/snapshots", job->directory) == HC_OK)
    hc_series_restore(path, (int)job->counts.snapshots, &made, error);
  if (made) hc_log_warn(&job->log, "%s/run.hdf.series was not there: made anew from the snapshots", path);
}

hc_status hc_job_open_files(hc_job *job, hc_error *error) {
  const bool resumed = *job->checkpoint != '\0';
  const bool cut = resumed && (job->taken_back || !hc_job_is_over(job)); /* else the end's files stay */
  const hc_run_dir_mode mode = resumed                                        ? HC_RUN_DIR_RESUME
                               : job->options->force || job->options->restart ? HC_RUN_DIR_FORCE
                                                                              : HC_RUN_DIR_NEW;
  if (job->lock < 0 && hc_run_dir_lock(job->comm, job->directory, &job->lock, error) != HC_OK)
    return error->status;
  if (hc_run_dir_open(job->comm, job->directory, mode, error) != HC_OK) return error->status;
  if (job->lock < 0 && /* it is new; perhaps not to us alone */
      (hc_run_dir_lock(job->comm, job->directory, &job->lock, error) != HC_OK ||
       hc_run_dir_open(job->comm, job->directory, mode, error) != HC_OK))
    return error->status;
  if (job->comm->rank == 0 && hc_log_open(&job->log, job->directory, resumed, error) == HC_OK) {
    if (resumed) mind_losses(job, error);
    if (cut) hc_run_dir_cut(job->directory, job->simulation.step, job->counts.snapshots, error);
    char *names = gauge_names(job->scene), *scene = hc_scene_text(job->scene);
    if (error->status == HC_OK)
      hc_tables_open(&job->tables, job->directory, names, resumed ? job->simulation.step : -1,
                     cut ? job->counts.gauge_time : INFINITY, error);
    if (error->status == HC_OK) hc_atomic_file_write(job->directory, "scene.yaml", scene, error);
    hc_free(names);
    hc_free(scene);
  }
  return hc_comm_agree(job->comm, error);
}

void hc_job_log_rest(hc_job *job) {
  const hc_rest_report *const rest = &job->simulation.rest;
  const hc_rest_chosen *const chosen = &rest->chosen;
  if (chosen->loaded == 0) return;
  hc_log_info(
      &job->log,
      "rest states: %lld particles, of which %lld stay; %lld of %lld candidates after %d passes, density "
      "%.5f of the rest density in the mean, deviation %.4f; %.3f s",
      (long long)chosen->loaded, (long long)(chosen->loaded - rest->removed), (long long)chosen->candidates,
      (long long)chosen->before, chosen->iterations, chosen->mean, chosen->deviation, rest->choosing);
  if (rest->relaxed.steps == 0) return;
  hc_log_info(
      &job->log,
      "they came to rest in %d damped steps%s, the fastest at %.3g, the mean at %.3g half spacings a step; "
      "%.3f s",
      rest->relaxed.steps, rest->relaxed.at_rest ? "" : ", the most there may be", rest->relaxed.speed_max,
      rest->relaxed.speed_avg, rest->relaxing);
}

void hc_job_log_start(hc_job *job) {
  const hc_simulation *simulation = &job->simulation;
  const hc_world *world = &simulation->world;
  char host[256] = "unknown";
  gethostname(host, sizeof host - 1);
  hc_log_info(&job->log, "halocline %s on %d rank%s, first host %s", hc_version(), job->comm->size,
              job->comm->size == 1 ? "" : "s", host);
  hc_log_info(&job->log, "scene %s from %s", job->scene->name, job->options->scene_file);
  job->log.echo = NULL; /* said already */
  for (int k = 0; k < job->warnings->count; k++) hc_log_warn(&job->log, "%s", job->warnings->text[k]);
  job->log.echo = stderr;
  hc_log_info(&job->log, "instruction set of the pair loops: %s%s", hc_isa_name(simulation->isa),
              simulation->isa == HC_ISA_PORTABLE ? " (no fused multiply-add: other bits than avx2 and avx512)"
                                                 : "");
  for (int k = 0; k < job->options->override_count; k++)
    hc_log_info(&job->log, "--set %s", job->options->overrides[k]);
  if (*job->checkpoint)
    hc_log_info(&job->log, "goes on from %s, written by %lld ranks: step %lld, t = %g s", job->checkpoint,
                (long long)job->written.ranks, (long long)simulation->step, simulation->time);
  const char *then = job->written.instruction_set, *now = hc_isa_name(simulation->isa),
             *portable = hc_isa_name(HC_ISA_PORTABLE);
  if (*job->checkpoint && strcmp(then, now) != 0 &&
      (strcmp(then, portable) == 0 || strcmp(now, portable) == 0))
    hc_log_warn(&job->log,
                "the checkpoint was written by pair loops for %s, these are for %s: the run goes on, but not "
                "to the same bits",
                then, now);
  if (job->changed && *job->changed) hc_log_info(&job->log, "changed since then: %s", job->changed);
  static const char *const viscosities[] = {"none", "xsph", "artificial", "laminar", "smagorinsky"};
  char factor[48] = "";
  if (world->boundary_ops->walls == HC_WALLS_MIRRORED)
    snprintf(factor, sizeof factor, " with volume factor %.6g", world->volume_factor);
  hc_log_info(&job->log, "solver %s, boundary %s%s, viscosity %s %g", simulation->solver->name,
              world->boundary_ops->name, factor, viscosities[job->scene->fluid.viscosity.model],
              job->scene->fluid.viscosity.coefficient);
  if (simulation->solver->describe) {
    char text[256];
    simulation->solver->describe(simulation->solver_settings, text, sizeof text);
    hc_log_info(&job->log, "%s", text);
  }
  hc_log_info(&job->log, "particles: %lld fluid of %.9g kg each (mass factor %g), %lld boundary",
              (long long)world->fluid_total, world->mass, job->scene->fluid.mass_factor,
              (long long)world->boundary_total);
  hc_job_log_rest(job);
  hc_log_info(&job->log, "%s (%s), %lld bricks of %d cells' edge, imbalance of fluid particles %.3f",
              world->division.divider == HC_DIVIDER_METIS ? "metis" : "slabs", world->division.way,
              (long long)world->division.bricks, 1 << world->division.bits, simulation->imbalance);
}

void hc_job_add_step_row(hc_job *job, const char *event) {
  const hc_simulation *simulation = &job->simulation;
  const int64_t boundary = simulation->world.boundary_total;
  const hc_step_report *report = &simulation->report;
  const hc_step_row step = {
      .step = simulation->step,
      .time = simulation->time,
      .dt = simulation->dt,
      .iterations_density = report->density_iterations,
      .iterations_divergence = report->divergence_iterations,
      .density_error_avg = report->density_error_avg,
      .density_error_max = report->density_error_max,
      .v_max = report->v_max,
      .a_max = report->a_max,
      .force_max = report->force_max,
      .kinetic_energy = report->kinetic_energy,
      .potential_energy = report->potential_energy,
      .fluid_particles = job->load.fluid,
      .active_fraction = report->substeps > 0 ? (double)report->evaluated /
                                                    ((double)report->substeps * (double)job->load.fluid)
                                              : 1.0,
      .substeps = report->substeps > 0 ? report->substeps : 1,
      .active_boundary_fraction = boundary > 0 ? (double)job->load.active_boundary / (double)boundary : 0.0,
      .event = event};
  if (job->problem.status == HC_OK) hc_tables_add_step(&job->tables, &step, &job->problem);
}

void hc_job_add_load_row(hc_job *job, double wall_seconds, const char *event) {
  const hc_job_load *load = &job->load;
  const hc_load_row row = {job->simulation.step, wall_seconds,    load->imbalance,
                           load->ghosts_max,     load->bytes_max, event};
  if (job->problem.status == HC_OK) hc_tables_add_load(&job->tables, &row, &job->problem);
}

hc_status hc_job_take_back(hc_job *job, hc_error *error) {
  const hc_simulation *simulation = &job->simulation;
  const hc_control *control = &simulation->control;
  const hc_shock_guard *guard = &control->guard;
  const int back = simulation->rollback.back;
  char what[HC_SHOCK_TEXT], measured[64] = "";
  hc_shock_text(&guard->shock, what);
  if (guard->shock.kind != HC_SHOCK_FAULT)
    snprintf(measured, sizeof measured, " v_max %.4g m/s, force_max %.4g m/s2;", control->v_max,
             control->force_max);
  hc_log_info(&job->log,
              "step %lld, t = %g s: shock: %s;%s back %d step%s to step "
              "%lld, t = %g s, restart %lld: time step %.4g s -> %.4g s",
              (long long)simulation->step + back, guard->shock.time, what, measured, back,
              back == 1 ? "" : "s", (long long)simulation->step, simulation->time, (long long)guard->restarts,
              guard->shock.dt, guard->next);
  *error = job->problem;
  if (job->comm->rank == 0 && error->status == HC_OK &&
      hc_run_dir_cut(job->directory, simulation->step, job->counts.snapshots, error) == HC_OK)
    hc_tables_cut(&job->tables, simulation->step, job->counts.gauge_time, error);
  return hc_comm_agree(job->comm, error);
}

static hc_timings_spread spread(hc_comm *comm, double value) {
  double *all = hc_alloc((size_t)comm->size, sizeof *all);
  hc_comm_gather_all_f64(comm, &value, 1, all);
  hc_timings_spread result = {all[0], 0.0, all[0]};
  for (int rank = 0; rank < comm->size; rank++) {
    if (all[rank] < result.min) result.min = all[rank];
    if (all[rank] > result.max) result.max = all[rank];
    result.mean += all[rank] / comm->size;
  }
  hc_free(all);
  return result;
}

/* Timings by stage into timings.json and the log. Collective. */
hc_status hc_job_summarize(hc_job *job, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  hc_world *world = &simulation->world;
  const double wall = hc_seconds() - job->started;
  hc_stopwatch_enter(&world->watch, HC_STAGE_OUTPUT);
  const double waited = job->comm->wait_seconds;
  int64_t sums[2] = {job->comm->bytes_sent, job->comm->messages_sent};
  const hc_comm counts = *job->comm; /* before what follows adds to them */
  hc_timings_stage stages[HC_STAGE_COUNT + 1];
  for (int stage = 0; stage < HC_STAGE_COUNT; stage++)
    stages[stage] =
        (hc_timings_stage){hc_stage_name((hc_stage)stage), spread(job->comm, world->watch.seconds[stage])};
  stages[HC_STAGE_COUNT] = (hc_timings_stage){"communication", spread(job->comm, waited)};
  hc_comm_sum_i64(job->comm, sums, 2);
  const hc_timings timings = {
      .ranks = job->comm->size,
      .steps = simulation->step - job->first_step,
      .fluid_particles = world->fluid_total,
      .boundary_particles = world->boundary_total,
      .particle_steps = job->particle_steps,
      .wall_seconds = wall,
      .simulated_seconds = simulation->time - job->first_time,
      .halo_bytes = sums[0],
      .messages = sums[1],
      .sparse_exchanges = counts.sparse_exchanges,
      .reductions = counts.reductions,
      .other_collectives = counts.other_collectives,
      .gathered_bytes = counts.gathered_bytes,
      .rebalances = simulation->balance.count,
      .rebalance_seconds = simulation->balance.seconds,
      .moved_particles = simulation->balance.moved,
      .imbalance = hc_balance_mean_imbalance(&simulation->balance),
      .rollbacks = simulation->control.guard.rollbacks,
      .rollback_steps = simulation->control.guard.steps,
      .ghosts = spread(job->comm, world->fluid->ghosts + world->boundary->ghosts + world->moving->ghosts),
      .private_bytes = spread(job->comm, (double)hc_memory_private()),
      .memory_bytes = spread(job->comm, (double)hc_memory_peak()),
      .stages = stages,
      .stage_count = HC_STAGE_COUNT + 1};
  for (int k = 0; k <= HC_STAGE_COUNT; k++)
    hc_log_info(&job->log, "time in %-13s %9.3f s (mean of ranks; %.3f to %.3f)", stages[k].name,
                stages[k].seconds.mean, stages[k].seconds.min, stages[k].seconds.max);
  hc_log_info(&job->log, "time steps from %.4g to %.4g s; steps with a density off by more than %g %%: %lld",
              job->counts.shortest_step, job->counts.longest_step, 100.0 * HC_JOB_MOST_COMPRESSION,
              (long long)job->counts.compressed_steps);
  if (simulation->solver->summary) {
    const hc_solver_caps caps = {job->counts.density_caps, job->counts.divergence_caps, simulation->step};
    char text[256];
    simulation->solver->summary(&caps, text, sizeof text);
    hc_log_info(&job->log, "%s", text);
  }
  if (hc_control_may_go_back(&simulation->control))
    hc_log_info(&job->log, "rollbacks: %lld, which took back %lld steps",
                (long long)simulation->control.guard.rollbacks, (long long)simulation->control.guard.steps);
  for (int k = 0; k < simulation->population.emitters.count; k++) {
    const hc_emitter *emitter = &simulation->population.emitters.emitters[k];
    hc_log_info(&job->log, "%s: %lld particles in %lld layers, %lld left out for want of room",
                hc_prescribed_emitter_name(k).text, (long long)emitter->emitted, (long long)emitter->layers,
                (long long)emitter->blocked);
  }
  for (int k = 0; k < simulation->population.absorption.count; k++) {
    const hc_absorber *absorber = &simulation->population.absorption.absorbers[k];
    hc_log_info(&job->log, "%s: %lld places; %lld particles came in, %lld went out",
                hc_setup_absorption_name(job->scene, k).text, (long long)absorber->places,
                (long long)absorber->came, (long long)absorber->went);
  }
  int64_t digest = (int64_t)hc_state_digest_particles(&simulation->state, ~0u);
  hc_comm_sum_i64(job->comm, &digest, 1);
  hc_log_info(&job->log, "digest of the last state, the same on any number of ranks: %016llx",
              (unsigned long long)((uint64_t)digest + hc_state_digest_items(&simulation->state)));
  hc_log_info(&job->log, "particles held by wall contacts: %.3g a step on average",
              simulation->step > 0 ? (double)job->counts.contacts / (double)simulation->step : 0.0);
  hc_log_info(&job->log,
              "rebalances: %lld in %.3f s, %lld particles moved; imbalance of work over the run: %.3f",
              (long long)simulation->balance.count, simulation->balance.seconds,
              (long long)simulation->balance.moved, hc_balance_mean_imbalance(&simulation->balance));
  hc_log_info(&job->log, "communication %.1f %% of the time; memory at its highest %.1f MiB on a rank",
              wall > 0.0 ? 100.0 * stages[HC_STAGE_COUNT].seconds.mean / wall : 0.0,
              timings.memory_bytes.max / 1048576.0);
  if (job->particle_steps > 0.0)
    hc_log_info(&job->log, "%lld steps in %.3f s: %.4g particles*steps/s, %.1f ns per particle and step",
                (long long)(simulation->step - job->first_step), wall, job->particle_steps / wall,
                1e9 * wall / job->particle_steps);
  if (job->comm->rank == 0) hc_timings_write(&timings, job->directory, error);
  return hc_comm_agree(job->comm, error);
}

/* Of the whole run, restarts included: the log tells not all of them. */
static void tell_warnings(hc_job *job) {
  const hc_job_counts *counts = &job->counts;
  if (counts->density_caps + counts->divergence_caps + counts->compressed_steps + counts->departed == 0)
    return;
  hc_log_info(
      &job->log,
      "warnings in all: density solver at its cap %lld, divergence solver at its cap %lld, density off "
      "%lld, particles that left %lld",
      (long long)counts->density_caps, (long long)counts->divergence_caps,
      (long long)counts->compressed_steps, (long long)counts->departed);
}

void hc_job_close_files(hc_job *job, hc_error *error) {
  hc_error closing = {.status = HC_OK};
  if (job->comm->rank == 0) {
    hc_tables_close(&job->tables, &closing);
    tell_warnings(job);
    job->log.echo = NULL; /* the program says it at its end */
    if (error->status != HC_OK) hc_log_warn(&job->log, "the run failed: %s", error->text);
    hc_log_close(&job->log, closing.status == HC_OK ? &closing : NULL);
  }
  hc_comm_agree(job->comm, &closing);
  if (job->lock >= 0) close(job->lock);
  if (error->status == HC_OK) *error = closing;
}
