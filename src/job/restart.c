/* Checkpoints of a job: when, what, and going on from one. */
#include "base/memory.h"
#include "io/checkpoint.h"
#include "io/run_dir.h"
#include "io/seal.h"
#include "job.h"
#include "scene/compare.h"
#include "setup/scene_input.h"
#include "simulation/footprint.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* Before one has been written, checkpoints are taken to be this slow. */
static const double SLOW_DISK = 50e6; /* bytes/s */

void hc_job_register(hc_job *job) {
  hc_state *state = &job->simulation.state;
  hc_job_counts *counts = &job->counts;
  hc_gauges_register(&job->gauges, state);
  hc_state_add(state, HC_TYPE_i64, 1, &counts->snapshots, "snapshots");
  hc_state_add(state, HC_TYPE_i64, 1, &counts->departed, "departed");
  hc_state_add(state, HC_TYPE_i64, 1, &counts->blocked, "blocked");
  hc_state_add(state, HC_TYPE_i64, 1, &counts->density_caps, "density_caps");
  hc_state_add(state, HC_TYPE_i64, 1, &counts->divergence_caps, "divergence_caps");
  hc_state_add(state, HC_TYPE_i64, 1, &counts->contacts, "contacts");
  hc_state_add(state, HC_TYPE_i64, 1, &counts->compressed_steps, "compressed_steps");
  hc_state_add(state, HC_TYPE_i64, 1, &counts->doubts, "doubts");
  hc_state_add(state, HC_TYPE_f64, 1, &counts->shortest_step, "shortest_step");
  hc_state_add(state, HC_TYPE_f64, 1, &counts->longest_step, "longest_step");
  hc_state_add(state, HC_TYPE_f64, 1, &counts->gauge_time, "gauge_time");
}

/* ---- which checkpoint ---- */

/* Warnings are rank 0's, like the scene's. */
static hc_warnings *warnings_of(const hc_job *job) {
  return job->comm->rank == 0 ? job->warnings : NULL;
}

/* From the newest on, the first that is whole. */
static hc_status choose(hc_job *job, hc_error *error) {
  if (job->options->restart_file) {
    if (job->comm->rank == 0) hc_text_path(job->checkpoint, error, "%s", job->options->restart_file);
    if (hc_comm_agree(job->comm, error) != HC_OK) return error->status;
    hc_comm_broadcast(job->comm, job->checkpoint, sizeof job->checkpoint, 0);
    return hc_seal_check(job->comm, job->checkpoint, error);
  }
  int64_t step = INT64_MAX;
  int passed_over = 0;
  for (;;) {
    if (hc_checkpoint_find(job->comm, job->directory, step, job->checkpoint, &step, error) != HC_OK)
      return error->status;
    if (step < 0) break;
    hc_error reason = {.status = HC_OK};
    if (hc_seal_check(job->comm, job->checkpoint, &reason) == HC_OK) return HC_OK;
    hc_warnings_add(warnings_of(job), "checkpoint passed over: %s", reason.text);
    passed_over++;
  }
  job->checkpoint[0] = '\0';
  if (passed_over > 0)
    return hc_error_set(
        error, HC_IO_FAILED,
        "none of the %d checkpoints in %s/checkpoints is valid (the reasons are above); start over with "
        "--force",
        passed_over, job->directory);
  hc_warnings_add(warnings_of(job), "--restart: there is no checkpoint in %s: the run starts over",
                  job->directory);
  return HC_OK;
}

/* ---- under which scene ---- */

/* Holds the job's scene against the text of another, which `where` has. `harmless`: receives the keys that
 * differ and may (the caller's to free); null: nobody wants to know. */
static hc_status compare_scenes(const hc_job *job, const char *text, const char *where, char **harmless,
                                hc_error *error) {
  const char *names[HC_FIELD_COUNT];
  hc_scene_limits limits = hc_scene_input_limits(names, NULL);
  limits.check = NULL; /* it has run before */
  limits.load = NULL;
  hc_scene before;
  hc_error problem = {.status = HC_OK};
  if (hc_scene_read_text(&before, where, text, strlen(text), NULL, 0, &limits, NULL, &problem) != HC_OK) {
    char reason[HC_ERROR_TEXT / 2];
    snprintf(reason, sizeof reason, "%.*s", (int)sizeof reason - 1, problem.text);
    return hc_error_set(error, HC_IO_FAILED, "%s: its scene cannot be read: %s", where, reason);
  }
  hc_scene_changes changes = hc_scene_compare(&before, job->scene);
  if (*changes.refused)
    hc_error_set(
        error, HC_BAD_INPUT,
        "the run in %s cannot go on under a scene that has changed: %.2000s; give the old values, or "
        "start over with --force",
        where, changes.refused);
  if (harmless) *harmless = strdup(changes.harmless);
  hc_scene_changes_free(&changes);
  hc_scene_free(&before);
  return error->status;
}

/* A checkpoint from elsewhere must not take over the directory of another run. */
static hc_status compare_with_directory(const hc_job *job, hc_error *error) {
  char path[HC_TEXT_PATH + 16], *text = NULL;
  size_t length = 0;
  snprintf(path, sizeof path, "%s/scene.yaml", job->directory);
  if (job->comm->rank == 0 && access(path, F_OK) == 0 && hc_scene_load(path, &text, &length, error) == HC_OK)
    compare_scenes(job, text, path, NULL, error);
  hc_free(text);
  return hc_comm_agree(job->comm, error);
}

hc_status hc_job_find_checkpoint(hc_job *job, hc_error *error) {
  if (hc_run_dir_lock(job->comm, job->directory, &job->lock, error) != HC_OK) return error->status;
  if (choose(job, error) != HC_OK || !*job->checkpoint) return error->status;
  if (hc_checkpoint_facts_read(job->comm, job->checkpoint, &job->written, error) != HC_OK)
    return error->status;
  compare_scenes(job, job->written.scene_text, job->checkpoint, &job->changed, error);
  if (hc_comm_agree(job->comm, error) != HC_OK || !job->options->restart_file) return error->status;
  return compare_with_directory(job, error);
}

hc_status hc_job_read_checkpoint(hc_job *job, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  if (hc_checkpoint_read(job->comm, job->checkpoint, &simulation->state, error) != HC_OK)
    return error->status;
  hc_simulation_adopt(simulation);
  job->first_step = simulation->step;
  job->first_time = simulation->time;
  char newest[HC_TEXT_PATH];
  int64_t step;
  hc_checkpoint_find(job->comm, job->directory, INT64_MAX, newest, &step, error);
  job->taken_back = step > simulation->step;
  return error->status;
}

/* ---- writing ---- */

bool hc_job_checkpoint_time(const hc_job *job) {
  const double every = job->scene->output.checkpoints_every_wall;
  return every > 0.0 && hc_seconds() - job->last_checkpoint >= every;
}

/* Time must be left for a checkpoint, a last step and the end, each perhaps twice as slow as the slowest. */
bool hc_job_out_of_time(const hc_job *job) {
  if (job->options->walltime <= 0.0) return false;
  const hc_world *world = &job->simulation.world;
  double checkpoint = job->checkpoint_seconds;
  if (checkpoint == 0.0)
    checkpoint = ((double)world->fluid_total * hc_footprint_fluid_state(job->scene) +
                  (double)world->boundary_total * hc_footprint_wall_state(job->scene)) /
                 SLOW_DISK;
  const double needed = 2.0 * (checkpoint + job->slowest_step) + 1.0;
  return hc_seconds() - job->launched + needed >= job->options->walltime;
}

hc_status hc_job_write_checkpoint(hc_job *job, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  hc_stopwatch_enter(&simulation->world.watch, HC_STAGE_OUTPUT);
  const double begin = hc_seconds();
  int64_t bytes = 0;
  *error = job->problem;
  if (error->status == HC_OK)
    hc_tables_sync(&job->tables,
                   error); /* rows of steps that the checkpoint has done must be there with it */
  if (hc_comm_agree(job->comm, error) != HC_OK) return error->status;
  hc_state_copy now = {.full = false};
  hc_simulation_show_resumable(simulation, &now);
  const hc_moment moment = hc_simulation_moment(simulation);
  hc_checkpoint_write(job->comm, job->scene, &moment, &simulation->state, hc_isa_name(simulation->isa),
                      job->directory, job->scene->output.checkpoints_keep, &bytes, error);
  hc_simulation_show_now(simulation, &now);
  if (error->status != HC_OK) return error->status;
  job->last_checkpoint = hc_seconds();
  job->checkpoint_seconds = job->last_checkpoint - begin;
  hc_log_info(&job->log, "step %" PRId64 ", t = %g s: checkpoint of %.4g MB in %.3g s (%.3g MB/s)",
              moment.step, moment.time, 1e-6 * (double)bytes, job->checkpoint_seconds,
              1e-6 * (double)bytes / job->checkpoint_seconds);
  return HC_OK;
}
