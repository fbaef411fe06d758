/* halocline run: a simulation with its files. */
#include "base/memory.h"
#include "commands.h"
#include "explain.h"
#include "gauges/gauges.h"
#include "halocline/version.h"
#include "io/log.h"
#include "io/progress.h"
#include "io/run_dir.h"
#include "io/snapshot.h"
#include "io/tables.h"
#include "io/timings.h"
#include "scene/writer.h"
#include "scene_input.h"
#include "simulation.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* A run while it runs. Log, tables and progress write on rank 0 only; zeroed, they do nothing. */
typedef struct run {
  hc_comm *comm;
  const hc_options *options;
  const hc_scene *scene;
  const hc_warnings *warnings; /* of the scene */
  hc_simulation simulation;
  char directory[HC_TEXT_PATH];
  hc_log log;
  hc_tables tables;
  hc_progress progress;
  hc_explained explained;
  hc_gauges gauges;
  double *gauge_values;
  int snapshots;      /* written so far */
  int64_t gauge_rows; /* likewise */
  int64_t density_caps, divergence_caps, contacts, compressed_steps;
  double shortest_step, longest_step; /* s */
  double particle_steps;              /* fluid particles summed over the steps */
  double started;                     /* wall clock, when the steps began */
} run;

static hc_status write_snapshot(run *run, hc_error *error) {
  hc_simulation *simulation = &run->simulation;
  hc_stopwatch_enter(&simulation->world.watch, HC_STAGE_OUTPUT);
  const hc_snapshot snapshot = hc_simulation_snapshot(simulation);
  return hc_snapshot_write(run->comm, &snapshot, run->directory, run->snapshots++, error);
}

/* Is a snapshot due? The first and the last state always; in between the first step at or after each
 * multiple. */
static bool snapshot_due(const run *run, bool last) {
  const double every = run->scene->output.snapshots_every;
  if (last) return true;
  return every > 0.0 && run->simulation.time >= every * run->snapshots;
}

/* A row of gauges.csv: at the start and the end, in between the first step at or after each multiple.
 * Collective; only rank 0 can fail. */
static hc_status read_gauges(run *run, hc_error *error) {
  hc_gauges_read(&run->gauges, &run->simulation.world.fluid, run->gauge_values);
  run->gauge_rows++;
  return hc_tables_add_gauges(&run->tables, run->simulation.time, run->gauge_values,
                              hc_gauges_columns(run->scene), error);
}

static bool gauges_due(const run *run, bool last) {
  return run->scene->output.gauge_count > 0 &&
         (last || run->simulation.time >= run->scene->output.gauges_every * (double)run->gauge_rows);
}

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

static hc_status open_files(run *run, hc_error *error) {
  const hc_run_dir_mode mode = run->options->force ? HC_RUN_DIR_FORCE : HC_RUN_DIR_NEW;
  if (hc_run_dir_open(run->comm, run->directory, mode, error) != HC_OK) return error->status;
  if (run->comm->rank == 0) {
    char path[HC_TEXT_PATH + 16];
    snprintf(path, sizeof path, "%s/scene.yaml", run->directory);
    if (hc_scene_write(run->scene, path, error) == HC_OK &&
        hc_log_open(&run->log, run->directory, false, error) == HC_OK) {
      char *names = gauge_names(run->scene);
      hc_tables_open(&run->tables, run->directory, names, -1, 0.0, error);
      hc_free(names);
    }
  }
  return hc_comm_agree(run->comm, error);
}

static void log_start(run *run) {
  const hc_simulation *simulation = &run->simulation;
  const hc_world *world = &simulation->world;
  char host[256] = "unknown";
  gethostname(host, sizeof host - 1);
  hc_log_info(&run->log, "halocline %s on %d rank%s, first host %s", hc_version(), run->comm->size,
              run->comm->size == 1 ? "" : "s", host);
  hc_log_info(&run->log, "scene %s from %s", run->scene->name, run->options->files[0]);
  run->log.echo = NULL; /* said already */
  for (int k = 0; k < run->warnings->count; k++) hc_log_warn(&run->log, "%s", run->warnings->text[k]);
  run->log.echo = stderr;
  hc_log_info(&run->log, "instruction set of the pair loops: %s%s", hc_isa_name(simulation->isa),
              simulation->isa == HC_ISA_PORTABLE ? " (no fused multiply-add: other bits than avx2 and avx512)"
                                                 : "");
  for (int k = 0; k < run->options->override_count; k++)
    hc_log_info(&run->log, "--set %s", run->options->overrides[k]);
  static const char *const viscosities[] = {"none", "xsph", "artificial", "laminar"};
  hc_log_info(&run->log, "solver %s, boundary %s with volume factor %.6g, viscosity %s %g",
              simulation->solver->name, world->boundary_ops->name, world->volume_factor,
              viscosities[run->scene->fluid.viscosity.model], run->scene->fluid.viscosity.coefficient);
  hc_log_info(&run->log, "particles: %lld fluid of %.9g kg each (mass factor %g), %lld boundary",
              (long long)world->fluid_total, world->mass, run->scene->fluid.mass_factor,
              (long long)world->boundary_total);
  hc_log_info(&run->log, "%s (%s), %lld bricks of %d cells' edge, imbalance of fluid particles %.3f",
              world->division.divider == HC_DIVIDER_METIS ? "metis" : "slabs", world->division.way,
              (long long)world->division.bricks, 1 << world->division.bits, simulation->imbalance);
}

/* What the ranks know of a step only together. */
typedef struct load {
  double imbalance;
  int64_t ghosts_max, bytes_max, fluid;
} load;

static load measure_load(run *run, int64_t bytes_before) {
  const hc_world *world = &run->simulation.world;
  hc_balance *balance = &run->simulation.balance;
  const int64_t work = (int64_t)(1e9 * balance->step_work);
  int64_t largest[3] = {work, world->fluid.ghosts + world->boundary.ghosts,
                        run->comm->bytes_sent - bytes_before};
  int64_t totals[2] = {world->fluid.own, work};
  hc_comm_max_i64(run->comm, largest, 3);
  hc_comm_sum_i64(run->comm, totals, 2);
  const double imbalance =
      hc_balance_note(balance, 1e-9 * (double)largest[0], 1e-9 * (double)totals[1] / run->comm->size);
  return (load){imbalance, largest[1], largest[2], totals[0]};
}

/* Single particles of a healthy run stay within this share of the rest density. */
static const double MOST_COMPRESSION = 0.05;

/* Counts and logs what went wrong in a step; the event words of its row. */
static void judge_step(run *run, char *event, size_t size) {
  const hc_simulation *simulation = &run->simulation;
  const hc_step_report *report = &simulation->report;
  event[0] = '\0';
  if (report->density_capped) {
    run->density_caps++;
    snprintf(event, size, "density_cap");
    hc_log_warn(&run->log,
                "step %lld: density solver at its cap of %d iterations, average error %.3g, allowed %.3g",
                (long long)simulation->step, report->density_iterations, report->density_error_avg,
                simulation->solver_settings.density_error_avg);
  }
  if (report->divergence_capped) {
    run->divergence_caps++;
    snprintf(event + strlen(event), size - strlen(event), "%sdivergence_cap", event[0] ? "+" : "");
    hc_log_warn(&run->log, "step %lld: divergence solver at its cap of %d iterations",
                (long long)simulation->step, report->divergence_iterations);
  }
  if (report->density_error_max > MOST_COMPRESSION) {
    run->compressed_steps++;
    hc_log_warn(&run->log, "step %lld: a particle's density is off by %.3g %%, more than %g %%",
                (long long)simulation->step, 100.0 * report->density_error_max, 100.0 * MOST_COMPRESSION);
  }
  if (run->shortest_step == 0.0 || simulation->dt < run->shortest_step) run->shortest_step = simulation->dt;
  if (simulation->dt > run->longest_step) run->longest_step = simulation->dt;
  run->contacts += report->contacts;
}

static hc_status add_rows(run *run, const load *load, double wall_seconds, bool wrote_snapshot,
                          const char *event, double active_boundary, hc_error *error) {
  const hc_simulation *simulation = &run->simulation;
  const hc_step_report *report = &simulation->report;
  const hc_step_row step = {.step = simulation->step,
                            .time = simulation->time,
                            .dt = simulation->dt,
                            .iterations_density = report->density_iterations,
                            .iterations_divergence = report->divergence_iterations,
                            .density_error_avg = report->density_error_avg,
                            .density_error_max = report->density_error_max,
                            .v_max = report->v_max,
                            .a_max = report->a_max,
                            .kinetic_energy = report->kinetic_energy,
                            .potential_energy = report->potential_energy,
                            .fluid_particles = load->fluid,
                            .active_fraction = 1.0,
                            .active_boundary_fraction = active_boundary,
                            .event = event};
  const char *machine_event = simulation->rebalanced && wrote_snapshot ? "rebalance+snapshot"
                              : simulation->rebalanced                 ? "rebalance"
                              : wrote_snapshot                         ? "snapshot"
                                                                       : "";
  const hc_load_row row = {simulation->step, wall_seconds,    load->imbalance,
                           load->ghosts_max, load->bytes_max, machine_event};
  if (hc_tables_add_step(&run->tables, &step, error) == HC_OK) hc_tables_add_load(&run->tables, &row, error);
  return error->status;
}

static hc_progress_sample progress_sample(const run *run, const load *load) {
  const hc_simulation *simulation = &run->simulation;
  return (hc_progress_sample){simulation->step,
                              simulation->time,
                              simulation->dt,
                              simulation->report.density_iterations,
                              simulation->report.divergence_iterations,
                              simulation->report.density_error_avg,
                              load->fluid,
                              load->imbalance};
}

/* Steps until the end. The last state is written as a snapshot also if it ends early by --steps. */
static hc_status run_steps(run *run, hc_error *error) {
  hc_simulation *simulation = &run->simulation;
  run->started = hc_seconds();
  load load = measure_load(run, run->comm->bytes_sent);
  while (!hc_simulation_done(simulation) &&
         (run->options->steps < 0 || simulation->step < run->options->steps)) {
    const double start = hc_seconds();
    const int64_t bytes_before = run->comm->bytes_sent;
    if (hc_simulation_step(simulation, error) != HC_OK) return error->status;
    hc_stopwatch_enter(&simulation->world.watch, HC_STAGE_OUTPUT);
    hc_gauges_step(&run->gauges, &simulation->world.sweep, simulation->dt);
    const double active_boundary = hc_world_active_boundary(&simulation->world);
    load = measure_load(run, bytes_before);
    if (load.fluid != simulation->world.fluid_total)
      return hc_error_set(error, HC_FAILED, "step %lld: %lld of %lld fluid particles are left",
                          (long long)simulation->step, (long long)load.fluid,
                          (long long)simulation->world.fluid_total);
    run->particle_steps += (double)load.fluid;
    char event[64];
    judge_step(run, event, sizeof event);
    hc_explain_time_step(&run->explained, simulation, &run->log);
    if (simulation->rebalanced)
      hc_balance_log(&simulation->balance, &simulation->world, simulation->step, &run->log);
    const bool last = hc_simulation_done(simulation) || simulation->step == run->options->steps;
    const bool snapshot = snapshot_due(run, last);
    if (snapshot && write_snapshot(run, error) != HC_OK) return error->status;
    hc_stopwatch_enter(&simulation->world.watch, HC_STAGE_OUTPUT);
    if (gauges_due(run, last)) read_gauges(run, error);
    if (error->status == HC_OK)
      add_rows(run, &load, hc_seconds() - start, snapshot, event, active_boundary, error);
    if (hc_comm_agree(run->comm, error) != HC_OK) return error->status;
    const hc_progress_sample sample = progress_sample(run, &load);
    hc_progress_step(&run->progress, &sample);
  }
  const hc_progress_sample sample = progress_sample(run, &load);
  hc_progress_finish(&run->progress, &sample);
  if (run->comm->rank == 0 && !run->options->quiet)
    printf("%s after %lld steps at %g s; files in %s\n",
           hc_simulation_done(simulation) ? "done" : "stopped by --steps", (long long)simulation->step,
           simulation->time, run->directory);
  return HC_OK;
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
static hc_status summarize(run *run, hc_error *error) {
  hc_simulation *simulation = &run->simulation;
  hc_world *world = &simulation->world;
  const double wall = hc_seconds() - run->started;
  hc_stopwatch_enter(&world->watch, HC_STAGE_OUTPUT);
  const double waited = run->comm->wait_seconds;
  int64_t sums[2] = {run->comm->bytes_sent, run->comm->messages_sent};
  const int64_t reductions = run->comm->reductions;
  hc_timings_stage stages[HC_STAGE_COUNT + 1];
  for (int stage = 0; stage < HC_STAGE_COUNT; stage++)
    stages[stage] =
        (hc_timings_stage){hc_stage_name((hc_stage)stage), spread(run->comm, world->watch.seconds[stage])};
  stages[HC_STAGE_COUNT] = (hc_timings_stage){"communication", spread(run->comm, waited)};
  hc_comm_sum_i64(run->comm, sums, 2);
  const hc_timings timings = {.ranks = run->comm->size,
                              .steps = simulation->step,
                              .fluid_particles = world->fluid_total,
                              .boundary_particles = world->boundary_total,
                              .particle_steps = run->particle_steps,
                              .wall_seconds = wall,
                              .simulated_seconds = simulation->time,
                              .halo_bytes = sums[0],
                              .messages = sums[1],
                              .reductions = reductions,
                              .rebalances = simulation->balance.count,
                              .rebalance_seconds = simulation->balance.seconds,
                              .moved_particles = simulation->balance.moved,
                              .imbalance = hc_balance_mean_imbalance(&simulation->balance),
                              .memory_bytes = spread(run->comm, (double)hc_memory_peak()),
                              .stages = stages,
                              .stage_count = HC_STAGE_COUNT + 1};
  for (int k = 0; k <= HC_STAGE_COUNT; k++)
    hc_log_info(&run->log, "time in %-13s %9.3f s (mean of ranks; %.3f to %.3f)", stages[k].name,
                stages[k].seconds.mean, stages[k].seconds.min, stages[k].seconds.max);
  hc_log_info(&run->log, "time steps from %.4g to %.4g s; steps with a density off by more than %g %%: %lld",
              run->shortest_step, run->longest_step, 100.0 * MOST_COMPRESSION,
              (long long)run->compressed_steps);
  hc_log_info(&run->log, "iteration caps hit: density solver %lld, divergence solver %lld of %lld steps",
              (long long)run->density_caps, (long long)run->divergence_caps, (long long)simulation->step);
  hc_log_info(&run->log, "particles held by wall contacts: %.3g a step on average",
              simulation->step > 0 ? (double)run->contacts / (double)simulation->step : 0.0);
  hc_balance_summarize(&simulation->balance, &run->log);
  hc_log_info(&run->log, "communication %.1f %% of the time; memory at its highest %.1f MiB on a rank",
              wall > 0.0 ? 100.0 * stages[HC_STAGE_COUNT].seconds.mean / wall : 0.0,
              timings.memory_bytes.max / 1048576.0);
  if (run->particle_steps > 0.0)
    hc_log_info(&run->log, "%lld steps in %.3f s: %.4g particles*steps/s, %.1f ns per particle and step",
                (long long)simulation->step, wall, run->particle_steps / wall,
                1e9 * wall / run->particle_steps);
  if (run->comm->rank == 0) hc_timings_write(&timings, run->directory, error);
  return hc_comm_agree(run->comm, error);
}

static hc_status run_with_files(run *run, hc_error *error) {
  if (open_files(run, error) != HC_OK) return error->status;
  log_start(run);
  const bool show = run->comm->rank == 0 && !run->options->quiet;
  hc_progress_start(&run->progress, show ? stdout : NULL, show && hc_progress_on_terminal(stdout), 0.0,
                    run->scene->end_time);
  if (write_snapshot(run, error) != HC_OK) return error->status;
  if (gauges_due(run, false)) read_gauges(run, error);
  if (hc_comm_agree(run->comm, error) != HC_OK) return error->status;
  if (run_steps(run, error) != HC_OK) return error->status;
  return summarize(run, error);
}

/* Closes what open_files opened; its errors count if the run itself went well. */
static void close_files(run *run, hc_error *error) {
  hc_error closing = {.status = HC_OK};
  if (run->comm->rank == 0) {
    hc_tables_close(&run->tables, &closing);
    run->log.echo = NULL; /* the program says it at its end */
    if (error->status != HC_OK) hc_log_warn(&run->log, "the run failed: %s", error->text);
    hc_log_close(&run->log, closing.status == HC_OK ? &closing : NULL);
  }
  hc_comm_agree(run->comm, &closing);
  if (error->status == HC_OK) *error = closing;
}

static void simulate(hc_comm *comm, const hc_options *options, hc_error *error) {
  hc_scene scene;
  const hc_scene_input input = {options->files[0], NULL, options->overrides, options->override_count};
  hc_warnings warnings = {0};
  hc_scene_input_read(comm, &input, &scene, &warnings, error);
  hc_command_warn(&warnings);
  if (error->status != HC_OK) {
    hc_warnings_free(&warnings);
    return;
  }
  run *run = hc_alloc_zero(1, sizeof *run);
  run->comm = comm;
  run->options = options;
  run->scene = &scene;
  run->warnings = &warnings;
  const int length = options->output ? snprintf(run->directory, sizeof run->directory, "%s", options->output)
                                     : snprintf(run->directory, sizeof run->directory, "out/%s", scene.name);
  if (length >= (int)sizeof run->directory) {
    hc_error_set(error, HC_BAD_INPUT, "the output directory's name has %d bytes, more than %d", length,
                 HC_TEXT_PATH);
  } else if (hc_simulation_init(&run->simulation, comm, &scene, error) == HC_OK) {
    const hc_world *world = &run->simulation.world;
    if (hc_gauges_init(&run->gauges, comm, &scene, &world->frame, world->mass, &world->boundary, error) ==
        HC_OK) {
      run->gauge_values = hc_alloc((size_t)hc_gauges_columns(&scene), sizeof *run->gauge_values);
      run_with_files(run, error);
      close_files(run, error);
    }
    hc_free(run->gauge_values);
    hc_gauges_free(&run->gauges);
    hc_simulation_free(&run->simulation);
  }
  hc_free(run);
  hc_warnings_free(&warnings);
  hc_scene_free(&scene);
}

int hc_command_run(const hc_options *options) {
  hc_comm comm;
  hc_comm_start(&comm, NULL, NULL);
  hc_error *error = hc_alloc_zero(1, sizeof *error);
  simulate(&comm, options, error);
  const int code = error->status;
  if (code != HC_OK && comm.rank == 0) hc_command_fail(error);
  hc_free(error);
  hc_comm_finish(&comm);
  return code;
}
