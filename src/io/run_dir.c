#include "run_dir.h"

#include "text.h"

#include <dirent.h>
#include <errno.h>
#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const own_files[] = {"steps.csv",
                                        "load.csv",
                                        "run.log",
                                        "timings.json",
                                        "gauges.csv",
                                        "scene.yaml",
                                        ".timings.json.tmp",
                                        ".scene.yaml.tmp",
                                        "snapshots/run.hdf.series",
                                        "snapshots/.run.hdf.series.tmp"};

static hc_status make_directories(const char *directory, hc_error *error) {
  char path[HC_TEXT_PATH];
  if (!*directory)
    return hc_error_set(error, HC_BAD_INPUT, "the output directory must have a name, got \"\"");
  const hc_status status = hc_text_path(path, error, "%s", directory);
  if (status != HC_OK) return status;
  for (char *slash = path + 1;; slash++) {
    if (*slash != '/' && *slash != 0) continue;
    const char kept = *slash;
    *slash = 0;
    /* Errors on the way do not matter (EEXIST, EROFS, ...): what counts is whether the directory is there at
     * last. */
    const int reason = mkdir(path, 0777) == 0 ? 0 : errno;
    *slash = kept;
    if (kept) continue;
    struct stat facts;
    if (stat(path, &facts) == 0 && S_ISDIR(facts.st_mode)) return HC_OK;
    return hc_error_set(error, HC_IO_FAILED, "cannot create the output directory %s: %s", directory,
                        reason == EEXIST ? "a file of that name is in the way" : strerror(reason));
  }
}

static bool holds(const char *directory, const char *name) {
  char path[HC_TEXT_PATH];
  struct stat facts;
  return hc_text_path(path, NULL, "%s/%s", directory, name) == HC_OK && lstat(path, &facts) == 0;
}

static hc_status remove_file(const char *directory, const char *name, hc_error *error) {
  char path[HC_TEXT_PATH];
  const hc_status status = hc_text_path(path, error, "%s/%s", directory, name);
  if (status != HC_OK) return status;
  if (unlink(path) == 0 || errno == ENOENT || errno == ENOTDIR) return HC_OK;
  return hc_error_set(error, HC_IO_FAILED, "cannot remove %s of the old run: %s", path, strerror(errno));
}

/* prefix, digits, suffix; also with a dot before and ".tmp" behind. */
static bool is_numbered(const char *name, const char *prefix, const char *suffix) {
  const bool temporary = *name == '.';
  name += temporary;
  const size_t length = strlen(prefix);
  if (strncmp(name, prefix, length) != 0) return false;
  name += length;
  const size_t digits = strspn(name, "0123456789");
  name += digits;
  if (digits == 0 || strncmp(name, suffix, strlen(suffix)) != 0) return false;
  return strcmp(name + strlen(suffix), temporary ? ".tmp" : "") == 0;
}

/* Removes numbered files from a subdirectory. */
static hc_status remove_numbered(const char *directory, const char *below, const char *prefix,
                                 const char *suffix, hc_error *error) {
  char path[HC_TEXT_PATH];
  hc_status status = hc_text_path(path, error, "%s/%s", directory, below);
  if (status != HC_OK) return status;
  DIR *list = opendir(path);
  if (!list) {
    if (errno == ENOENT || errno == ENOTDIR) return HC_OK;
    return hc_error_set(error, HC_IO_FAILED, "cannot list %s: %s", path, strerror(errno));
  }
  for (;;) {
    errno = 0;
    const struct dirent *item = readdir(list);
    if (!item && errno)
      status = hc_error_set(error, HC_IO_FAILED, "cannot list %s: %s", path, strerror(errno));
    if (!item || status != HC_OK) break;
    if (is_numbered(item->d_name, prefix, suffix)) status = remove_file(path, item->d_name, error);
  }
  closedir(list);
  return status;
}

static hc_status clear_run(const char *directory, hc_error *error) {
  hc_status status = HC_OK;
  for (size_t k = 0; status == HC_OK && k < sizeof own_files / sizeof *own_files; k++)
    status = remove_file(directory, own_files[k], error);
  if (status == HC_OK) status = remove_numbered(directory, "snapshots", "snap_", ".hdf", error);
  if (status == HC_OK) status = remove_numbered(directory, "snapshots", "fault_", ".hdf", error);
  if (status == HC_OK) status = remove_numbered(directory, "checkpoints", "ckpt_", ".h5", error);
  return status;
}

hc_status hc_run_dir_open(hc_comm *comm, const char *directory, hc_run_dir_mode mode, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  if (comm->rank == 0 && make_directories(directory, &problem) == HC_OK) {
    const char *held = holds(directory, "steps.csv")    ? "steps.csv"
                       : holds(directory, "scene.yaml") ? "scene.yaml"
                                                        : NULL;
    if (mode == HC_RUN_DIR_NEW && held)
      hc_error_set(
          &problem, HC_BAD_INPUT,
          "the output directory %s already holds a run (%s); name another with -o or replace the run with "
          "--force",
          directory, held);
    if (mode == HC_RUN_DIR_FORCE) clear_run(directory, &problem);
    if (problem.status == HC_OK && access(directory, W_OK | X_OK) != 0)
      hc_error_set(&problem, HC_IO_FAILED, "cannot write into the output directory %s: %s", directory,
                   strerror(errno));
  }
  if (hc_comm_agree(comm, &problem) != HC_OK && error) *error = problem;
  return problem.status;
}
