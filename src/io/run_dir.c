#include "run_dir.h"

#include "base/memory.h"
#include "numbered.h"
#include "series.h"
#include "text.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
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

/* Files of a run with this number or a later one. */
static hc_status remove_numbered(const char *directory, const char *below, const char *prefix,
                                 const char *suffix, int64_t from, hc_error *error) {
  char folder[HC_TEXT_PATH];
  const hc_status status = hc_text_path(folder, error, "%s/%s", directory, below);
  if (status != HC_OK) return status;
  return hc_numbered_remove(&(hc_numbered){folder, prefix, suffix}, from, error);
}

static hc_status clear_run(const char *directory, hc_error *error) {
  /* Checkpoints first: without them nobody takes a half cleared directory for a run that can go on. */
  hc_status status = remove_numbered(directory, "checkpoints", "ckpt_", ".h5", 0, error);
  for (size_t k = 0; status == HC_OK && k < sizeof own_files / sizeof *own_files; k++)
    status = remove_file(directory, own_files[k], error);
  if (status == HC_OK) status = remove_numbered(directory, "snapshots", "snap_", ".hdf", 0, error);
  if (status == HC_OK) status = remove_numbered(directory, "snapshots", "fault_", ".hdf", 0, error);
  return status;
}

/* Alone in the directory? Only while no rank of another run holds it. */
static bool lock_alone(int file) {
  enum { TRIES = 200, PAUSE = 50 };
  for (int try = 0; try < TRIES; try++) {
    if (flock(file, LOCK_EX | LOCK_NB) == 0) return true;
    if (errno != EWOULDBLOCK && errno != EINTR) return true; /* no locks here: nothing to wait for */
    nanosleep(&(struct timespec){0, PAUSE * 1000000}, NULL);
  }
  return false;
}

hc_status hc_run_dir_lock(hc_comm *comm, const char *directory, int *lock, hc_error *error) {
  *lock = open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  /* Between giving up the one lock and getting the other somebody else may have come in. */
  if (comm->rank == 0 && *lock >= 0 &&
      (!lock_alone(*lock) || (flock(*lock, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK)))
    hc_error_set(error, HC_IO_FAILED,
                 "another run is at work in %s: wait for its end, or name another with -o", directory);
  if (hc_comm_agree(comm, error) == HC_OK) {
    if (*lock >= 0) flock(*lock, LOCK_SH); /* every rank; where it cannot be had there is none */
    hc_comm_barrier(comm);
    return HC_OK;
  }
  if (*lock >= 0) close(*lock);
  *lock = -1;
  return error->status;
}

hc_status hc_run_dir_cut(const char *directory, int64_t step, int64_t snapshots, hc_error *error) {
  char path[HC_TEXT_PATH];
  hc_status status = hc_text_path(path, error, "%s/snapshots", directory);
  if (status == HC_OK) status = remove_numbered(directory, "checkpoints", "ckpt_", ".h5", step + 1, error);
  if (status == HC_OK) status = remove_numbered(directory, "snapshots", "fault_", ".hdf", step + 1, error);
  if (status == HC_OK) status = remove_numbered(directory, "snapshots", "snap_", ".hdf", snapshots, error);
  if (status == HC_OK) status = hc_series_cut(path, (int)snapshots, error);
  return status;
}

static bool holds_checkpoint(const char *directory) {
  char folder[HC_TEXT_PATH];
  int64_t *steps;
  size_t count = 0;
  if (hc_text_path(folder, NULL, "%s/checkpoints", directory) != HC_OK) return false;
  if (hc_numbered_list(&(hc_numbered){folder, "ckpt_", ".h5"}, &steps, &count, NULL) == HC_OK) hc_free(steps);
  return count > 0;
}

hc_status hc_run_dir_open(hc_comm *comm, const char *directory, hc_run_dir_mode mode, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  if (comm->rank == 0 && make_directories(directory, &problem) == HC_OK) {
    const char *held = holds(directory, "steps.csv")    ? "steps.csv"
                       : holds(directory, "scene.yaml") ? "scene.yaml"
                       : holds_checkpoint(directory)    ? "checkpoints"
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
