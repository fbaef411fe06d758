/* The commands that run nothing and read no scene: info, diff, keys; what commands share. */
#include "commands.h"
#include "io/diff.h"
#include "io/info.h"
#include "scene/params.h"

#include <stdio.h>

int hc_command_fail(const hc_error *error) {
  fflush(stdout);
  fprintf(stderr, "halocline: error: %s\n", error->text);
  return error->status;
}

int hc_command_finish_output(void) {
  if (fflush(stdout) == 0 && !ferror(stdout)) return HC_OK;
  fprintf(stderr, "halocline: error: standard output could not be written\n");
  return HC_IO_FAILED;
}

int hc_command_info(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  if (hc_info_print(options->files[0], options->json, stdout, &error) != HC_OK)
    return hc_command_fail(&error);
  return hc_command_finish_output();
}

int hc_command_diff(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  const hc_diff_options how = {options->tolerance, options->json};
  const int code = hc_diff_run(options->files[0], options->files[1], &how, stdout, &error);
  if (code == 2) hc_command_fail(&error);
  const int written = hc_command_finish_output();
  return code < 2 && written != HC_OK ? 2 : code;
}

int hc_command_keys(const hc_options *options) {
  hc_error error = {.status = HC_OK};
  if (hc_params_print(stdout, options->solver, &error) != HC_OK) return hc_command_fail(&error);
  return hc_command_finish_output();
}
