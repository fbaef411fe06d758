#include "snapshot.h"

#include "atomic_file.h"
#include "base/memory.h"
#include "h5.h"
#include "series.h"
#include "snapshot_layout.h"
#include "text.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

typedef struct paths {
  char directory[HC_TEXT_PATH], temporary[HC_TEXT_PATH], final[HC_TEXT_PATH];
} paths;

/* A snapshot of the run's series, or of a fault. */
typedef struct place {
  const char *directory, *stem;
  int number;
  bool in_series;
} place;

static void name_paths(paths *names, const place *place, hc_error *problem) {
  const char *stem = place->stem;
  if (hc_text_path(names->directory, problem, "%s/snapshots", place->directory) != HC_OK) return;
  if (hc_text_path(names->temporary, problem, "%s/.%s_%06d.hdf.tmp", names->directory, stem, place->number) !=
      HC_OK)
    return;
  hc_text_path(names->final, problem, "%s/%s_%06d.hdf", names->directory, stem, place->number);
}

/* Every rank: a file larger than its limit would end the process with a signal. */
static void check_size_limit(const paths *names, int64_t bytes, hc_error *problem) {
  struct rlimit limit;
  if (getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  if ((rlim_t)bytes <= limit.rlim_cur) return;
  hc_error_set(problem, HC_IO_FAILED,
               "cannot write %s: it needs %lld bytes, the file size limit (ulimit -f) is %lld", names->final,
               (long long)bytes, (long long)limit.rlim_cur);
}

/* Every rank: HDF5 without memory on one of them leaves the others waiting. It takes far less. */
static void check_memory(const paths *names, hc_error *problem) {
  enum { ROOM = 64 << 20 };
  if (!hc_memory_has(ROOM))
    hc_error_set(problem, HC_FAILED, "out of memory: writing %s takes up to %d MiB more", names->final,
                 ROOM >> 20);
}

/* Rank 0, before HDF5 knows the file: the plain errors (no such directory, no permission) in plain words.
 * Returns a descriptor of the empty temporary, or -1. */
static int create_temporary(const paths *names, hc_error *problem) {
  if (mkdir(names->directory, 0777) != 0 && errno != EEXIST) {
    hc_error_set(problem, HC_IO_FAILED, "cannot create %s: %s", names->directory, strerror(errno));
    return -1;
  }
  const int file = open(names->temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) hc_error_set(problem, HC_IO_FAILED, "cannot write %s: %s", names->temporary, strerror(errno));
  return file;
}

/* Rank 0: blocks for the whole file before any data goes out. A disk that fills up in the middle of a
 * collective write can leave the ranks waiting for each other; one that is full now is an ordinary error.
 * Where the file system cannot reserve, its free space is compared. */
static void reserve(int file, const paths *names, int64_t bytes, hc_error *problem) {
  if (fallocate(file, FALLOC_FL_KEEP_SIZE, 0, bytes) == 0) return;
  if (errno != EOPNOTSUPP && errno != ENOSYS && errno != EINTR) {
    hc_error_set(problem, HC_IO_FAILED, "cannot write %s: it needs %lld bytes: %s", names->final,
                 (long long)bytes, strerror(errno));
    return;
  }
  struct statvfs disk;
  if (fstatvfs(file, &disk) != 0) return;
  const int64_t free_bytes = (int64_t)disk.f_bavail * (int64_t)disk.f_frsize;
  if (free_bytes < bytes)
    hc_error_set(problem, HC_IO_FAILED, "cannot write %s: it needs %lld bytes, %lld are free", names->final,
                 (long long)bytes, (long long)free_bytes);
}

static hid_t create_shared(hc_comm *comm, const char *path, hc_error *problem) {
  hid_t file = H5I_INVALID_HID;
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  if (access < 0 || H5Pset_fapl_mpio(access, comm->mpi, MPI_INFO_NULL) < 0)
    hc_h5_failed(problem, HC_IO_FAILED, "cannot set up parallel HDF5");
  else
    file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  if (file < 0) hc_h5_failed(problem, HC_IO_FAILED, "cannot create %s", path);
  if (access >= 0) H5Pclose(access);
  return file;
}

/* HDF5 writes its headers when it closes, and breaks for good if it cannot (1.10.8 crashes in MPI_Finalize).
 * So a failed file gives its blocks back first. */
static void make_closable(hc_comm *comm, int file) {
  hc_comm_barrier(comm);
  const int failed = comm->rank == 0 ? ftruncate(file, 0) : 0;
  (void)failed; /* then it closes as well as it can */
  hc_comm_barrier(comm);
}

/* From the empty temporary to the complete, closed one. Collective; afterwards `problem` is agreed. */
static void write_content(hc_snapshot_layout *layout, const paths *names, int reserved, hc_error *problem) {
  hc_comm *comm = layout->comm;
  layout->file = create_shared(comm, names->temporary, problem); /* empties it: reserve once more */
  if (comm->rank == 0 && problem->status == HC_OK)
    reserve(reserved, names, hc_snapshot_layout_bytes(layout), problem);
  if (hc_comm_agree(comm, problem) != HC_OK) {
    if (layout->file >= 0) H5Fclose(layout->file);
    return;
  }
  hc_snapshot_layout_define(layout);
  if (hc_comm_agree(comm, problem) == HC_OK) hc_snapshot_layout_fill(layout);
  if (problem->status != HC_OK) make_closable(comm, reserved);
  hc_snapshot_layout_close(layout);
  if (H5Fclose(layout->file) < 0) hc_h5_failed(problem, HC_IO_FAILED, "cannot complete the file");
  hc_comm_agree(comm, problem);
}

/* Rank 0: gives back the reserved blocks that were not needed, syncs and renames. */
static void publish(int file, const paths *names, const place *place, double time, hc_error *problem) {
  struct stat facts;
  if (fstat(file, &facts) != 0 || ftruncate(file, facts.st_size) != 0 || fsync(file) != 0) {
    hc_error_set(problem, HC_IO_FAILED, "cannot write %s: %s", names->final, strerror(errno));
    return;
  }
  if (hc_atomic_file_rename(names->temporary, names->final, problem) != HC_OK) return;
  if (place->in_series) hc_series_add(names->directory, place->number, time, problem);
}

static hc_status write_snapshot(hc_comm *comm, const hc_snapshot *snapshot, const place *place,
                                hc_error *error) {
  hc_error problem = {.status = HC_OK};
  hc_snapshot_layout layout;
  paths names;
  int file = -1;
  hc_h5_silence();
  hc_snapshot_layout_init(&layout, comm, snapshot, &problem);
  name_paths(&names, place, &problem);
  if (problem.status == HC_OK) check_size_limit(&names, hc_snapshot_layout_bytes(&layout), &problem);
  if (problem.status == HC_OK) check_memory(&names, &problem);
  if (problem.status == HC_OK && comm->rank == 0) {
    file = create_temporary(&names, &problem);
    if (file >= 0) reserve(file, &names, hc_snapshot_layout_bytes(&layout), &problem);
  }
  if (hc_comm_agree(comm, &problem) == HC_OK) write_content(&layout, &names, file, &problem);
  if (comm->rank == 0 && problem.status == HC_OK) publish(file, &names, place, snapshot->time, &problem);
  if (file >= 0) {
    close(file);
    if (problem.status != HC_OK) unlink(names.temporary);
  }
  hc_comm_agree(comm, &problem);
  H5garbage_collect(); /* HDF5 keeps its buffers for next time; the particles need the memory more */
  hc_snapshot_layout_free(&layout);
  if (problem.status != HC_OK) {
    char reason[HC_ERROR_TEXT - 192];
    snprintf(reason, sizeof reason, "%.*s", (int)sizeof reason - 1, problem.text);
    hc_error_set(error, problem.status, "snapshot %d: %s", place->number, reason);
  }
  return problem.status;
}

hc_status hc_snapshot_write(hc_comm *comm, const hc_snapshot *snapshot, const char *directory, int number,
                            hc_error *error) {
  const place place = {directory, "snap", number, true};
  return write_snapshot(comm, snapshot, &place, error);
}

hc_status hc_snapshot_write_fault(hc_comm *comm, const hc_snapshot *snapshot, const char *directory,
                                  hc_error *error) {
  const place place = {directory, "fault", (int)snapshot->step, false};
  return write_snapshot(comm, snapshot, &place, error);
}

hc_status hc_snapshot_bytes(const hc_scene *scene, int64_t particles, int64_t *bytes, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  *bytes = hc_snapshot_layout_estimate(scene, particles, &problem);
  if (problem.status != HC_OK && error) *error = problem;
  return problem.status;
}
