/* halocline run: a scene with its files. */
#include "base/memory.h"
#include "base/timer.h"
#include "commands.h"
#include "io/rest_file.h"
#include "job/job.h"
#include "job/stop.h"
#include "setup/scene_input.h"

/* "Run again with --restart" (sysexits.h: EX_TEMPFAIL). */
enum { EXIT_STOPPED = 75 };

/* Returns true if the run stopped early. */
static bool read_and_run(hc_comm *comm, const hc_options *options, double launched, hc_error *error) {
  hc_scene scene;
  const hc_scene_input input = {options->files[0], NULL, options->overrides, options->override_count,
                                hc_rest_file_read};
  const hc_job_options job = {.scene_file = options->files[0],
                              .overrides = options->overrides,
                              .override_count = options->override_count,
                              .output = options->output,
                              .steps = options->steps,
                              .walltime = options->walltime,
                              .restart = options->restart,
                              .restart_file = options->restart_file,
                              .force = options->force,
                              .quiet = options->quiet};
  hc_warnings warnings = {0};
  bool stopped = false;
  hc_scene_input_read(comm, &input, &scene, &warnings, error);
  hc_warnings_print(&warnings, 0);
  if (error->status == HC_OK) {
    stopped = hc_job_run(comm, &scene, &job, &warnings, launched, error);
    hc_scene_free(&scene);
  }
  hc_warnings_free(&warnings);
  return stopped;
}

int hc_command_run(const hc_options *options) {
  const double launched = hc_seconds();
  hc_comm comm;
  hc_comm_start(&comm, NULL, NULL);
  hc_stop_catch_signals();
  hc_error *error = hc_alloc_zero(1, sizeof *error);
  const bool stopped = read_and_run(&comm, options, launched, error);
  const int code = error->status;
  if (code != HC_OK && comm.rank == 0) hc_command_fail(error);
  hc_free(error);
  hc_comm_finish(&comm);
  return code == HC_OK && stopped ? EXIT_STOPPED : code;
}
