/* halocline rest: a relaxed fluid for scenes to fill shapes with. */
#include "job/rest.h"
#include "base/memory.h"
#include "commands.h"
#include "io/rest_file.h"
#include "setup/scene_input.h"

#include <unistd.h>

static hc_status read_and_rest(hc_comm *comm, const hc_options *options, hc_error *error) {
  hc_scene scene;
  hc_warnings warnings = {0};
  const hc_scene_input input = {options->files[0], NULL, options->overrides, options->override_count,
                                hc_rest_file_read};
  if (comm->rank == 0 && access(options->output, F_OK) == 0 && !options->force)
    hc_error_set(error, HC_BAD_INPUT, "%s is there already; --force overwrites it", options->output);
  if (hc_comm_agree(comm, error) != HC_OK) return error->status;
  if (hc_scene_input_read(comm, &input, &scene, &warnings, error) == HC_OK) {
    hc_job_rest(comm, &scene, options->output, options->quiet, error);
    hc_scene_free(&scene);
  }
  hc_warnings_print(&warnings, 0);
  hc_warnings_free(&warnings);
  return error->status;
}

int hc_command_rest(const hc_options *options) {
  hc_comm comm;
  hc_comm_start(&comm, NULL, NULL);
  hc_error *const error = hc_alloc_zero(1, sizeof *error);
  if (!options->output)
    hc_error_set(error, HC_BAD_INPUT, "rest needs -o FILE: where to save the fluid");
  else
    read_and_rest(&comm, options, error);
  const int code = error->status;
  if (code != HC_OK && comm.rank == 0) hc_command_fail(error);
  hc_free(error);
  hc_comm_finish(&comm);
  return code;
}
