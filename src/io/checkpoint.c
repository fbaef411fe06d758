#include "checkpoint.h"

#include "base/memory.h"
#include "checkpoint_content.h"
#include "scene/writer.h"
#include "seal.h"
#include "shared_file.h"

#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- the folder ---- */

/* The step in a checkpoint's name; -1 if the name is not one. */
static int64_t step_of(const char *name) {
  int64_t step;
  int end = 0;
  if (sscanf(name, "ckpt_%" SCNd64 ".h5%n", &step, &end) != 1 || end == 0 || name[end] || step < 0) return -1;
  return step;
}

static int descending(const void *a, const void *b) {
  const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
  return p > q ? -1 : p < q;
}

/* The steps of all checkpoints in a folder, newest first; null with `problem` set if it cannot be read. A
 * folder that is not there is empty. */
static int64_t *list_steps(const char *folder, size_t *count, hc_error *problem) {
  size_t room = 0;
  int64_t *steps = NULL;
  *count = 0;
  hc_reserve((void **)&steps, &room, 16, 0, sizeof *steps);
  DIR *list = opendir(folder);
  if (!list && errno != ENOENT)
    hc_error_set(problem, HC_IO_FAILED, "cannot list %s: %s", folder, strerror(errno));
  while (list) {
    errno = 0;
    const struct dirent *item = readdir(list);
    if (!item && errno) hc_error_set(problem, HC_IO_FAILED, "cannot list %s: %s", folder, strerror(errno));
    if (!item) break;
    const int64_t step = step_of(item->d_name);
    if (step < 0) continue;
    hc_reserve((void **)&steps, &room, *count + 1, *count, sizeof *steps);
    steps[(*count)++] = step;
  }
  if (list) closedir(list);
  if (*count) qsort(steps, *count, sizeof *steps, descending);
  return steps;
}

static void remove_file(const char *folder, const char *name) {
  char path[HC_TEXT_PATH];
  if (hc_text_path(path, NULL, "%s/%s", folder, name) == HC_OK) unlink(path);
}

/* Temporaries of runs that were killed. */
static void remove_temporaries(const char *folder) {
  DIR *list = opendir(folder);
  if (!list) return;
  for (const struct dirent *item = readdir(list); item; item = readdir(list)) {
    const size_t length = strlen(item->d_name);
    if (strncmp(item->d_name, ".ckpt_", 6) == 0 && length > 4 &&
        strcmp(item->d_name + length - 4, ".tmp") == 0)
      remove_file(folder, item->d_name);
  }
  closedir(list);
}

/* Rank 0, after a new one has appeared: what cannot be removed does no harm. */
static void prune(const char *folder, int64_t newest, int keep) {
  hc_error ignored = {.status = HC_OK};
  size_t count;
  int64_t *steps = list_steps(folder, &count, &ignored);
  int kept = 0;
  for (size_t k = 0; k < count; k++) {
    if (steps[k] <= newest && kept++ < keep) continue;
    char name[64];
    snprintf(name, sizeof name, "ckpt_%08" PRId64 ".h5", steps[k]);
    remove_file(folder, name);
  }
  hc_free(steps);
  remove_temporaries(folder);
}

hc_status hc_checkpoint_find(hc_comm *comm, const char *directory, int64_t below, char path[HC_TEXT_PATH],
                             int64_t *step, hc_error *error) {
  *step = -1;
  path[0] = '\0';
  if (comm->rank == 0 && hc_text_path(path, error, "%s/checkpoints", directory) == HC_OK) {
    size_t count;
    int64_t *steps = list_steps(path, &count, error);
    for (size_t k = 0; k < count && *step < 0; k++)
      if (steps[k] < below) *step = steps[k];
    hc_free(steps);
    if (*step >= 0) hc_text_path(path, error, "%s/checkpoints/ckpt_%08" PRId64 ".h5", directory, *step);
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

hc_status hc_checkpoint_write(hc_comm *comm, const hc_snapshot *moment, const hc_state *state,
                              const char *instruction_set, const char *directory, int keep, int64_t *bytes,
                              hc_error *error) {
  hc_error problem = {.status = HC_OK};
  char name[64], folder[HC_TEXT_PATH];
  snprintf(name, sizeof name, "ckpt_%08" PRId64 ".h5", moment->step);
  char *scene_text = hc_scene_text(moment->scene);
  hc_checkpoint_content content = {.comm = comm,
                                   .moment = moment,
                                   .state = state,
                                   .instruction_set = instruction_set,
                                   .scene_text = scene_text};
  hc_checkpoint_content_count(&content);
  *bytes = 0;
  write_file(comm, &content, directory, name, bytes, &problem);
  hc_comm_broadcast(comm, bytes, sizeof *bytes, 0);
  if (comm->rank == 0 && problem.status == HC_OK &&
      hc_text_path(folder, &problem, "%s/checkpoints", directory) == HC_OK)
    prune(folder, moment->step, keep);
  hc_free(scene_text);
  if (problem.status != HC_OK) {
    char reason[HC_ERROR_TEXT - 192];
    snprintf(reason, sizeof reason, "%.*s", (int)sizeof reason - 1, problem.text);
    hc_error_set(error, problem.status, "checkpoint of step %" PRId64 ": %s", moment->step, reason);
  }
  return problem.status;
}
