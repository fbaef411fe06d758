#include "checkpoint.h"

#include "base/memory.h"
#include "checkpoint_content.h"
#include "numbered.h"
#include "scene/writer.h"
#include "seal.h"
#include "shared_file.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- the folder ---- */

/* The steps of a run's checkpoints, newest first. */
static hc_status list_steps(const char *directory, int64_t **steps, size_t *count, hc_error *error) {
  char folder[HC_TEXT_PATH];
  *count = 0;
  const hc_status status = hc_text_path(folder, error, "%s/checkpoints", directory);
  if (status != HC_OK) return status;
  return hc_numbered_list(&(hc_numbered){folder, "ckpt_", ".h5"}, steps, count, error);
}

static hc_status name_of(char path[HC_TEXT_PATH], const char *directory, int64_t step, hc_error *error) {
  return hc_text_path(path, error, "%s/checkpoints/ckpt_%08" PRId64 ".h5", directory, step);
}

/* Rank 0, after a new one has appeared: what cannot be removed does no harm. */
static void prune(const char *directory, int keep) {
  int64_t *steps;
  size_t count;
  if (list_steps(directory, &steps, &count, NULL) != HC_OK) return;
  for (size_t k = (size_t)keep; k < count; k++) {
    char path[HC_TEXT_PATH];
    if (name_of(path, directory, steps[k], NULL) == HC_OK) unlink(path);
  }
  hc_free(steps);
}

hc_status hc_checkpoint_find(hc_comm *comm, const char *directory, int64_t below, char path[HC_TEXT_PATH],
                             int64_t *step, hc_error *error) {
  *step = -1;
  path[0] = '\0';
  int64_t *steps;
  size_t count;
  if (comm->rank == 0 && list_steps(directory, &steps, &count, error) == HC_OK) {
    for (size_t k = 0; k < count && *step < 0; k++)
      if (steps[k] < below) *step = steps[k];
    hc_free(steps);
    if (*step >= 0) name_of(path, directory, *step, error);
  }
  hc_comm_broadcast(comm, step, sizeof *step, 0);
  hc_comm_broadcast(comm, path, HC_TEXT_PATH, 0);
  return hc_comm_agree(comm, error);
}

/* ---- writing ---- */

/* The file's bytes, on disk and sealed. Collective; `problem` is agreed. */
static void write_file(hc_comm *comm, const hc_checkpoint_content *content, const char *directory,
                       const char *name, int64_t *bytes, hc_error *problem) {
  hc_shared_file file;
  char seal[HC_SEAL_BYTES];
  if (hc_shared_file_open(&file, comm, directory, "checkpoints", name, hc_checkpoint_content_bytes(content),
                          HC_SEAL_BYTES, problem) == HC_OK) {
    hc_checkpoint_content_write(content, file.handle, problem);
    if (hc_shared_file_close(&file) == HC_OK && hc_seal_make(comm, file.temporary, seal, problem) == HC_OK)
      hc_shared_file_seal(&file, seal, sizeof seal);
  }
  struct stat facts;
  if (file.reserved >= 0 && fstat(file.reserved, &facts) == 0) *bytes = facts.st_size;
  hc_shared_file_end(&file);
}

hc_status hc_checkpoint_write(hc_comm *comm, const hc_scene *scene, const hc_moment *moment,
                              const hc_state *state, const char *instruction_set, const char *directory,
                              int keep, int64_t *bytes, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  char name[64];
  snprintf(name, sizeof name, "ckpt_%08" PRId64 ".h5", moment->step);
  char *scene_text = hc_scene_text(scene);
  hc_checkpoint_content content = {.comm = comm,
                                   .scene = scene,
                                   .moment = moment,
                                   .state = state,
                                   .instruction_set = instruction_set,
                                   .scene_text = scene_text};
  hc_checkpoint_content_count(&content);
  *bytes = 0;
  write_file(comm, &content, directory, name, bytes, &problem);
  hc_comm_broadcast(comm, bytes, sizeof *bytes, 0);
  if (comm->rank == 0 && problem.status == HC_OK) prune(directory, keep);
  hc_free(scene_text);
  if (problem.status != HC_OK) {
    char reason[HC_ERROR_TEXT - 192];
    snprintf(reason, sizeof reason, "%.*s", (int)sizeof reason - 1, problem.text);
    hc_error_set(error, problem.status, "checkpoint of step %" PRId64 ": %s", moment->step, reason);
  }
  return problem.status;
}
