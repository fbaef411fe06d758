/* A simulation with its files, step by step. */
#include "base/memory.h"
#include "io/snapshot.h"
#include "job.h"
#include "setup/rest_states.h"
#include "simulation/step.h"
#include "state/copy.h"
#include "stop.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- what is due ---- */

/* Is one of the multiples of `every` in (before, now]? A function of the two times alone, so that a restart
 * need not remember what was due. */
static bool passes_multiple(double every, double before, double now) {
  return hc_time_step_multiples(every, now) > hc_time_step_multiples(every, before);
}

static bool snapshot_due(const hc_job *job, double before) {
  const double every = job->scene->output.snapshots_every;
  return every > 0.0 && passes_multiple(every, before, job->simulation.time);
}

static bool gauges_due(const hc_job *job, double before) {
  const double every = job->scene->output.gauges_every;
  return job->scene->output.gauge_count > 0 &&
         (every == 0.0 || passes_multiple(every, before, job->simulation.time));
}

/* ---- what is written ---- */

static hc_status write_snapshot(hc_job *job, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  hc_stopwatch_enter(&simulation->world.watch, HC_STAGE_OUTPUT);
  const hc_moment moment = hc_simulation_moment(simulation);
  return hc_snapshot_write(job->comm, job->scene, &moment, job->directory, (int)job->counts.snapshots, error);
}

/* After a step that failed: writes DIRECTORY/snapshots/fault_NNNNNN.hdf, NNNNNN the failed step, with all
 * fields, and adds to `error` where it is, or why it could not be written; the status stays. Collective. */
static hc_status write_fault(hc_job *job, hc_error *error) {
  const hc_simulation *simulation = &job->simulation;
  if (simulation->report.fault.kind == HC_FAULT_NONE) return error->status;
  hc_scene everything = *simulation->scene; /* shallow: only the list of fields is another */
  static const char *const fields[] = {"velocity", "density", "pressure", "acceleration"};
  everything.output.snapshot_field_count = sizeof fields / sizeof *fields;
  for (int k = 0; k < everything.output.snapshot_field_count; k++)
    snprintf(everything.output.snapshot_fields[k], sizeof everything.output.snapshot_fields[k], "%s",
             fields[k]);
  hc_moment moment = hc_simulation_moment(simulation);
  moment.step = simulation->step + 1;
  hc_error problem = {.status = HC_OK};
  const bool written =
      hc_snapshot_write_fault(job->comm, &everything, &moment, job->directory, &problem) == HC_OK;
  hc_error whole = {.status = HC_OK};
  if (written)
    hc_error_set(&whole, error->status, "%.4000s\n  the moment: %.3000s/snapshots/fault_%06lld.hdf",
                 error->text, job->directory, (long long)moment.step);
  else
    hc_error_set(&whole, error->status, "%.4000s\n  its snapshot could not be written: %.3000s", error->text,
                 problem.text);
  *error = whole;
  return error->status;
}

/* A row of gauges.csv; what goes wrong is rank 0's problem. Collective. */
static void read_gauges(hc_job *job) {
  hc_gauges_read(&job->gauges, job->simulation.world.fluid, job->gauge_values);
  if (job->problem.status == HC_OK)
    hc_tables_add_gauges(&job->tables, job->simulation.time, job->gauge_values, hc_gauges_columns(job->scene),
                         &job->problem);
}

/* The state at the start. */
static hc_status write_start(hc_job *job, hc_error *error) {
  if (write_snapshot(job, error) != HC_OK) return error->status;
  job->counts.snapshots++;
  if (job->scene->output.gauge_count > 0) {
    read_gauges(job);
    job->counts.gauge_time = job->simulation.time;
  }
  return HC_OK;
}

/* Snapshot and gauges of the last moment, if it was not their turn anyway. They leave no trace in the state,
 * so that a run that goes on from here takes them back. */
static hc_status write_end(hc_job *job, bool wrote_snapshot, bool wrote_gauges, hc_error *error) {
  if (!wrote_snapshot && write_snapshot(job, error) != HC_OK) return error->status;
  if (wrote_gauges || job->scene->output.gauge_count == 0) return HC_OK;
  hc_state_copy items = {.full = false};
  hc_state_remember(&items, &job->simulation.state, 0);
  read_gauges(job);
  hc_state_restore(&items, &job->simulation.state);
  hc_state_copy_free(&items);
  return HC_OK;
}

/* ---- the steps ---- */

bool hc_job_is_over(const hc_job *job) {
  return hc_simulation_done(&job->simulation) ||
         (job->options->steps >= 0 && job->simulation.step >= job->options->steps);
}

/* This rank's load, and where it is to be added up. */
static void note_load(hc_job *job, hc_tally *tally) {
  const hc_world *world = &job->simulation.world;
  const int64_t work = (int64_t)(1e9 * job->simulation.balance.step_work);
  const bool first = job->comm->rank == 0;
  hc_job_load *load = &job->load;
  *load = (hc_job_load){.fluid = world->fluid->own,
                        .active_boundary = hc_world_active_boundary(world),
                        .work = work,
                        .work_max = work,
                        .ghosts_max = world->fluid->ghosts + world->boundary->ghosts + world->moving->ghosts,
                        .bytes_max = job->comm->bytes_sent - job->bytes_before,
                        .signal = hc_stop_signal(),
                        .out_of_time = first && hc_job_out_of_time(job),
                        .checkpoint_time = first && hc_job_checkpoint_time(job),
                        .tables_failed = job->problem.status != HC_OK};
  int64_t *const sums[] = {&load->fluid, &load->active_boundary, &load->work};
  int64_t *const maxima[] = {&load->work_max,    &load->ghosts_max,      &load->bytes_max,    &load->signal,
                             &load->out_of_time, &load->checkpoint_time, &load->tables_failed};
  for (size_t k = 0; k < sizeof sums / sizeof *sums; k++) hc_tally_sum_i64(tally, sums[k], 1);
  for (size_t k = 0; k < sizeof maxima / sizeof *maxima; k++) hc_tally_max_i64(tally, maxima[k], 1);
}

/* Once it is added up. */
static void judge_load(hc_job *job) {
  hc_job_load *load = &job->load;
  load->imbalance = hc_balance_note(&job->simulation.balance, 1e-9 * (double)load->work_max,
                                    1e-9 * (double)load->work / job->comm->size);
}

/* Behind a step's move: what of it is the job's, see hc_company. */
static void note_step(void *caller, double dt, hc_tally *tally) {
  hc_job *job = caller;
  hc_world *world = &job->simulation.world;
  hc_stopwatch_enter(&world->watch, HC_STAGE_OUTPUT);
  hc_gauges_note(&job->gauges, &world->sweep, dt, tally);
  note_load(job, tally);
  hc_stopwatch_enter(&world->watch, HC_STAGE_MOVE);
}

/* Blocks that came as the last step began, or a window that went along: the first time in full. */
static void tell_refill(hc_job *job, char *event, size_t size) {
  const hc_simulation *const simulation = &job->simulation;
  if (!simulation->came) return;
  if (!simulation->displaced || simulation->window.count == 1) hc_job_log_rest(job);
  snprintf(event + strlen(event), size - strlen(event), "%s%s", event[0] ? "+" : "",
           simulation->displaced ? "window" : "refill");
}

/* Particles that were taken out: the first ten of a run one by one, then how many in a step. */
static void tell_departures(hc_job *job, char *event, size_t size) {
  const hc_departures *departures = &job->simulation.population.departures;
  const long long step = (long long)job->simulation.step;
  if (departures->count == 0) return;
  int64_t told = 0;
  for (; told < departures->named && job->counts.departed < HC_LEAVING_NAMED; told++, job->counts.departed++)
    hc_log_warn(&job->log, "step %lld: particle %s has left the world at (%.6g, %.6g, %.6g) m; removed", step,
                hc_simulation_particle_name(job->scene, (int64_t)departures->first[told].id).text,
                departures->first[told].at[0], departures->first[told].at[1], departures->first[told].at[2]);
  if (told < departures->count)
    hc_log_warn_counted(&job->log, ++job->counts.departed - HC_LEAVING_NAMED,
                        "step %lld: %lld particles have left the world; removed", step,
                        (long long)departures->count);
  snprintf(event + strlen(event), size - strlen(event), "%sremoved:%lld", event[0] ? "+" : "",
           (long long)departures->count);
}

/* Emitters' samples that found their place taken. */
static void tell_blocked(hc_job *job, char *event, size_t size) {
  const hc_simulation *simulation = &job->simulation;
  if (simulation->population.blocked == 0) return;
  if (!job->counts.blocked)
    hc_log_warn(&job->log,
                "step %lld: %lld particles of emitters found fluid in their places and are left out; see the "
                "event blocked in steps.csv, and the summary",
                (long long)simulation->step, (long long)simulation->population.blocked);
  job->counts.blocked += simulation->population.blocked;
  snprintf(event + strlen(event), size - strlen(event), "%sblocked:%lld", event[0] ? "+" : "",
           (long long)simulation->population.blocked);
}

/* What came in and went out in front of walls that absorb. */
static void tell_absorbed(const hc_population *population, char *event, size_t size) {
  if (population->came > 0)
    snprintf(event + strlen(event), size - strlen(event), "%sinflow:%lld", event[0] ? "+" : "",
             (long long)population->came);
  if (population->went > 0)
    snprintf(event + strlen(event), size - strlen(event), "%soutflow:%lld", event[0] ? "+" : "",
             (long long)population->went);
}

/* Counts and logs what went wrong in a step; the event words of its row. */
static void judge_step(hc_job *job, char *event, size_t size) {
  const hc_simulation *simulation = &job->simulation;
  const hc_step_report *report = &simulation->report;
  event[0] = '\0';
  if (report->density_capped) {
    job->counts.density_caps++;
    snprintf(event, size, "density_cap");
    hc_log_warn_counted(
        &job->log, job->counts.density_caps,
        "step %lld: density solver at its cap of %d iterations, average error %.3g, allowed %.3g",
        (long long)simulation->step, report->density_iterations, report->density_error_avg,
        job->scene->solver.density_error_avg);
  }
  if (report->divergence_capped) {
    job->counts.divergence_caps++;
    snprintf(event + strlen(event), size - strlen(event), "%sdivergence_cap", event[0] ? "+" : "");
    hc_log_warn_counted(&job->log, job->counts.divergence_caps,
                        "step %lld: divergence solver at its cap of %d iterations",
                        (long long)simulation->step, report->divergence_iterations);
  }
  if (report->density_error_max > HC_JOB_MOST_COMPRESSION) {
    job->counts.compressed_steps++;
    hc_log_warn_counted(&job->log, job->counts.compressed_steps,
                        "step %lld: a particle's density is off by %.3g %%, more than %g %%",
                        (long long)simulation->step, 100.0 * report->density_error_max,
                        100.0 * HC_JOB_MOST_COMPRESSION);
  }
  char text[256];
  if (simulation->solver->doubt &&
      simulation->solver->doubt(simulation->solver_settings, report, text, sizeof text))
    hc_log_warn_counted(&job->log, ++job->counts.doubts, "step %lld: %s", (long long)simulation->step, text);
  tell_departures(job, event, size);
  tell_refill(job, event, size);
  if (simulation->control.before > 0)
    snprintf(event + strlen(event), size - strlen(event), "%srollback:%lld", event[0] ? "+" : "",
             (long long)simulation->control.before);
  tell_blocked(job, event, size);
  tell_absorbed(&simulation->population, event, size);
  if (job->counts.shortest_step == 0.0 || simulation->dt < job->counts.shortest_step)
    job->counts.shortest_step = simulation->dt;
  if (simulation->dt > job->counts.longest_step) job->counts.longest_step = simulation->dt;
  job->counts.contacts += report->contacts;
}

static void tell_rebalance(hc_job *job) {
  hc_balance *balance = &job->simulation.balance;
  const hc_division *division = &job->simulation.world.division;
  balance->ghosts = job->simulation.world.fluid->ghosts;
  hc_comm_sum_i64(job->comm, &balance->ghosts, 1);
  hc_log_info(
      &job->log,
      "step %lld: rebalanced by %s (%s), %lld bricks of %d cells' edge in %d intervals: imbalance of work "
      "%.3f, of load %.3f before and %.3f after; %lld particles moved, cut of %lld ghosts, %.4f s",
      (long long)job->simulation.step, division->divider == HC_DIVIDER_METIS ? "metis" : "slabs",
      division->way, (long long)division->bricks, 1 << division->bits, division->intervals,
      balance->imbalance, division->before, division->after, (long long)division->moving,
      (long long)balance->ghosts, balance->last_seconds);
}

static hc_progress_sample progress_sample(const hc_job *job) {
  const hc_simulation *simulation = &job->simulation;
  return (hc_progress_sample){simulation->step,
                              simulation->time,
                              simulation->dt,
                              simulation->report.density_iterations,
                              simulation->report.divergence_iterations,
                              simulation->report.density_error_avg,
                              job->load.fluid,
                              job->load.imbalance};
}

/* One step with its due outputs: rows, snapshot, gauges. */
typedef struct done {
  double wall_seconds;   /* what was taken back before it not counted */
  bool taken_back;       /* there is no step */
  bool snapshot, gauges; /* written */
} done;

/* Rank 0's problem becomes everybody's. */
static hc_status agree_on_problem(hc_job *job, hc_error *error) {
  *error = job->problem;
  return hc_comm_agree(job->comm, error);
}

static hc_status step_and_report(hc_job *job, done *done, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  const double start = hc_seconds(), before = simulation->time;
  job->bytes_before = job->comm->bytes_sent;
  if (hc_simulation_step(simulation, error) != HC_OK) return write_fault(job, error);
  done->taken_back = simulation->rollback.back > 0;
  if (done->taken_back) return hc_job_take_back(job, error);
  if (job->load.tables_failed) return agree_on_problem(job, error);
  hc_stopwatch_enter(&simulation->world.watch, HC_STAGE_OUTPUT);
  hc_gauges_step(&job->gauges, simulation->dt);
  judge_load(job);
  if (job->load.fluid != simulation->world.fluid_total)
    return hc_error_set(error, HC_FAILED, "step %lld: %lld of %lld fluid particles are left",
                        (long long)simulation->step, (long long)job->load.fluid,
                        (long long)simulation->world.fluid_total);
  job->particle_steps += (double)job->load.fluid;
  char event[256];
  judge_step(job, event, sizeof event);
  hc_explain_time_step(&job->explained, simulation, &job->log);
  if (hc_balance_divided_in(&simulation->balance, simulation->step)) tell_rebalance(job);
  done->snapshot = snapshot_due(job, before);
  done->gauges = gauges_due(job, before);
  if (done->snapshot && write_snapshot(job, error) != HC_OK) return error->status;
  if (done->snapshot) job->counts.snapshots++;
  hc_stopwatch_enter(&simulation->world.watch, HC_STAGE_OUTPUT);
  if (done->gauges) read_gauges(job);
  if (done->gauges) job->counts.gauge_time = simulation->time;
  hc_job_add_step_row(job, event);
  done->wall_seconds = hc_seconds() - start;
  job->slowest_step = fmax(job->slowest_step, done->wall_seconds);
  return HC_OK;
}

static bool checkpoint_due(const hc_job *job) {
  const int every = job->scene->output.checkpoints_every_steps;
  return job->load.checkpoint_time || (every > 0 && job->simulation.step % every == 0);
}

static void join_events(const hc_simulation *simulation, bool snapshot, bool checkpoint, char *event,
                        size_t size) {
  snprintf(event, size, "%s%s%s",
           hc_balance_divided_in(&simulation->balance, simulation->step) ? "+rebalance" : "",
           snapshot ? "+snapshot" : "", checkpoint ? "+checkpoint" : "");
  if (*event) memmove(event, event + 1, strlen(event));
}

static void say_end(const hc_job *job) {
  const hc_simulation *simulation = &job->simulation;
  if (job->comm->rank != 0 || job->options->quiet) return;
  const char *why = hc_simulation_done(simulation) ? "done"
                    : !job->stopped                ? "stopped by --steps"
                    : job->load.signal             ? hc_stop_signal_name((int)job->load.signal)
                                                   : "--walltime";
  printf("%s%s after %lld steps at %g s; files in %s%s\n", job->stopped ? "stopped by " : "", why,
         (long long)simulation->step, simulation->time, job->directory,
         job->stopped ? "; go on with --restart" : "");
}

/* Steps until the end, or until a signal, --walltime or --steps ask for a stop; at least one step more than
 * checkpoints lag behind, so that restarts get on. The last state is in a checkpoint too, which comes after
 * all other files of its moment. */
static hc_status run_steps(hc_job *job, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  job->started = job->last_checkpoint = hc_seconds();
  job->bytes_before = job->comm->bytes_sent;
  simulation->company = (hc_company){note_step, job};
  hc_tally start = {.count = 0};
  note_load(job, &start);
  hc_tally_reduce(job->comm, &start);
  judge_load(job);
  done done = {.taken_back = false};
  bool last = hc_job_is_over(job);
  int owed = simulation->rollback.most == 2 ? 2 : 1;
  while (!last) {
    if (step_and_report(job, &done, error) != HC_OK) return error->status;
    if (done.taken_back) continue;
    owed -= owed > 0;
    const bool over = hc_job_is_over(job);
    job->stopped = !over && owed == 0 && (job->load.signal || job->load.out_of_time);
    last = over || job->stopped;
    const bool checkpoint = last || checkpoint_due(job);
    const double begin = hc_seconds();
    if (over && write_end(job, done.snapshot, done.gauges, error) != HC_OK) return error->status;
    if (checkpoint && hc_job_write_checkpoint(job, error) != HC_OK) return error->status;
    char event[64];
    join_events(simulation, done.snapshot || over, checkpoint, event, sizeof event);
    hc_job_add_load_row(job, done.wall_seconds + (hc_seconds() - begin), event);
    const hc_progress_sample sample = progress_sample(job);
    hc_progress_step(&job->progress, &sample);
  }
  if (agree_on_problem(job, error) != HC_OK) return error->status;
  const hc_progress_sample sample = progress_sample(job);
  hc_progress_finish(&job->progress, &sample);
  if (job->stopped)
    hc_log_info(&job->log, "stopped by %s; go on with --restart",
                job->load.signal ? hc_stop_signal_name((int)job->load.signal) : "--walltime");
  say_end(job);
  return HC_OK;
}

/* ---- from the command line to the end ---- */

static hc_status run_with_files(hc_job *job, hc_error *error) {
  const double begin = job->simulation.time;
  if (hc_job_open_files(job, error) != HC_OK) return error->status;
  hc_job_log_start(job);
  if (begin > job->scene->end_time)
    hc_log_warn(&job->log, "the checkpoint is at %g s, past end_time (%g s): there is nothing left to do",
                begin, job->scene->end_time);
  const bool show = job->comm->rank == 0 && !job->options->quiet;
  hc_progress_start(&job->progress, show ? stdout : NULL, show && hc_progress_on_terminal(stdout), begin,
                    job->scene->end_time);
  if (!*job->checkpoint && write_start(job, error) != HC_OK) return error->status;
  if (run_steps(job, error) != HC_OK) return error->status;
  const bool idle = *job->checkpoint && job->simulation.step == job->first_step;
  return idle ? HC_OK : hc_job_summarize(job, error); /* what was said of the run's end holds */
}

/* The particles, from the scene or from a checkpoint, and the gauges among them. */
static hc_status fill(hc_job *job, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  const hc_status status =
      *job->checkpoint ? hc_job_read_checkpoint(job, error) : hc_simulation_populate(simulation, error);
  if (status != HC_OK) return status;
  return hc_gauges_find_walls(&job->gauges, simulation->world.boundary, error);
}

static void run_scene(hc_job *job, hc_scene *scene, hc_error *error) {
  hc_simulation *simulation = &job->simulation;
  if (job->options->restart) {
    const int said = job->warnings->count;
    hc_job_find_checkpoint(job, error);
    hc_warnings_print(job->warnings, said);
    if (error->status != HC_OK) return;
  }
  if (hc_simulation_prepare(simulation, job->comm, job->scene, error) != HC_OK) return;
  hc_gauges_init(&job->gauges, job->comm, job->scene, &simulation->world.frame, &simulation->movers,
                 &simulation->bodies, simulation->world.mass);
  job->gauge_values = hc_alloc((size_t)hc_gauges_columns(job->scene), sizeof *job->gauge_values);
  hc_job_register(job);
  if (fill(job, error) == HC_OK) {
    hc_setup_free_start(scene);
    run_with_files(job, error);
    hc_job_close_files(job, error);
  }
  hc_free(job->gauge_values);
  hc_gauges_free(&job->gauges);
  hc_simulation_free(simulation);
}

bool hc_job_run(hc_comm *comm, hc_scene *scene, const hc_job_options *options, hc_warnings *warnings,
                double launched, hc_error *error) {
  hc_job *job = hc_alloc_zero(1, sizeof *job);
  *job = (hc_job){.comm = comm,
                  .options = options,
                  .scene = scene,
                  .warnings = warnings,
                  .lock = -1,
                  .launched = launched};
  job->counts.gauge_time = -1.0;
  const int length = options->output ? snprintf(job->directory, sizeof job->directory, "%s", options->output)
                                     : snprintf(job->directory, sizeof job->directory, "out/%s", scene->name);
  if (length >= (int)sizeof job->directory)
    hc_error_set(error, HC_BAD_INPUT, "the output directory's name has %d bytes, more than %d", length,
                 HC_TEXT_PATH);
  else
    run_scene(job, scene, error);
  const bool stopped = job->stopped;
  hc_free(job->changed);
  hc_free(job->written.scene_text);
  hc_free(job);
  return stopped;
}
