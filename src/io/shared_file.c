#include "shared_file.h"

#include "atomic_file.h"
#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

/* Every rank: a file larger than its limit would end the process with a signal. */
static void check_size_limit(const hc_shared_file *file, int64_t bytes) {
  struct rlimit limit;
  if (getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  if ((rlim_t)bytes <= limit.rlim_cur) return;
  hc_error_set(file->problem, HC_IO_FAILED,
               "cannot write %s: it needs %lld bytes, the file size limit (ulimit -f) is %lld", file->final,
               (long long)bytes, (long long)limit.rlim_cur);
}

/* Every rank: HDF5 without memory on one of them leaves the others waiting. It takes far less. */
static void check_memory(const hc_shared_file *file) {
  if (!hc_memory_has(HC_H5_MEMORY))
    hc_error_set(file->problem, HC_FAILED, "out of memory: writing %s takes up to %d MiB more", file->final,
                 HC_H5_MEMORY >> 20);
}

/* Rank 0, before HDF5 knows the file: the plain errors (no such directory, no permission) in plain words. */
static void create_temporary(hc_shared_file *file) {
  if (mkdir(file->directory, 0777) != 0 && errno != EEXIST) {
    hc_error_set(file->problem, HC_IO_FAILED, "cannot create %s: %s", file->directory, strerror(errno));
    return;
  }
  file->reserved = open(file->temporary, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file->reserved < 0)
    hc_error_set(file->problem, HC_IO_FAILED, "cannot write %s: %s", file->temporary, strerror(errno));
}

/* Rank 0: blocks for the whole file before any data goes out. A disk that fills up in the middle of a
 * collective write can leave the ranks waiting for each other; one that is full now is an ordinary error.
 * Where the file system cannot reserve, its free space is compared. */
static void reserve(hc_shared_file *file, int64_t bytes) {
  if (fallocate(file->reserved, FALLOC_FL_KEEP_SIZE, 0, bytes) == 0) return;
  if (errno != EOPNOTSUPP && errno != ENOSYS && errno != EINTR) {
    hc_error_set(file->problem, HC_IO_FAILED, "cannot write %s: it needs %lld bytes: %s", file->final,
                 (long long)bytes, strerror(errno));
    return;
  }
  struct statvfs disk;
  if (fstatvfs(file->reserved, &disk) != 0) return;
  const int64_t free_bytes = (int64_t)disk.f_bavail * (int64_t)disk.f_frsize;
  if (free_bytes < bytes)
    hc_error_set(file->problem, HC_IO_FAILED, "cannot write %s: it needs %lld bytes, %lld are free",
                 file->final, (long long)bytes, (long long)free_bytes);
}

/* Every rank: the file that rank 0 has made must be there for all before they open it together. */
static void check_shared(const hc_shared_file *file) {
  char host[256] = "this machine";
  if (access(file->temporary, W_OK) == 0) return;
  gethostname(host, sizeof host - 1);
  hc_error_set(
      file->problem, HC_IO_FAILED,
      "rank %d on %s cannot write %s, which rank 0 has made: %s; the output directory must be on a file "
      "system that all machines share",
      file->comm->rank, host, file->temporary, strerror(errno));
}

/* All ranks make the same metadata: they are written together, not by each rank some. */
static void create_shared(hc_shared_file *file, int user_block) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS), creation = H5Pcreate(H5P_FILE_CREATE);
  if (access < 0 || creation < 0 || H5Pset_fapl_mpio(access, file->comm->mpi, MPI_INFO_NULL) < 0 ||
      H5Pset_coll_metadata_write(access, true) < 0 || H5Pset_userblock(creation, (hsize_t)user_block) < 0)
    hc_h5_failed(file->problem, HC_IO_FAILED, "cannot set up parallel HDF5");
  else
    file->handle = H5Fcreate(file->temporary, H5F_ACC_TRUNC, creation, access);
  if (file->handle < 0) hc_h5_failed(file->problem, HC_IO_FAILED, "cannot create %s", file->temporary);
  if (creation >= 0) H5Pclose(creation);
  if (access >= 0) H5Pclose(access);
}

hc_status hc_shared_file_open(hc_shared_file *file, hc_comm *comm, const char *directory, const char *below,
                              const char *name, int64_t bytes, int user_block, hc_error *problem) {
  hc_h5_silence();
  *file = (hc_shared_file){.comm = comm, .handle = H5I_INVALID_HID, .reserved = -1, .problem = problem};
  if (hc_text_path(file->directory, problem, "%s/%s", directory, below) == HC_OK &&
      hc_text_path(file->temporary, problem, "%s/.%s.tmp", file->directory, name) == HC_OK &&
      hc_text_path(file->final, problem, "%s/%s", file->directory, name) == HC_OK)
    check_size_limit(file, bytes);
  if (problem->status == HC_OK) check_memory(file);
  if (problem->status == HC_OK && comm->rank == 0) create_temporary(file);
  if (file->reserved >= 0) reserve(file, bytes);
  if (hc_comm_agree(comm, problem) != HC_OK) return problem->status;
  check_shared(file);
  if (hc_comm_agree(comm, problem) != HC_OK) return problem->status;
  create_shared(file, user_block); /* empties it: reserve once more */
  if (hc_comm_agree(comm, problem) != HC_OK) {
    hc_h5_close_alone(file->handle, problem);
    return problem->status;
  }
  if (comm->rank == 0) reserve(file, bytes);
  if (hc_comm_agree(comm, problem) != HC_OK) {
    H5Fclose(file->handle);
    file->handle = H5I_INVALID_HID;
  }
  return problem->status;
}

/* HDF5 writes its headers when it closes, and breaks for good if it cannot (1.10.8 crashes in MPI_Finalize).
 * So a failed file gives its blocks back first. */
static void make_closable(hc_shared_file *file) {
  hc_comm_barrier(file->comm);
  const int failed = file->comm->rank == 0 ? ftruncate(file->reserved, 0) : 0;
  (void)failed; /* then it closes as well as it can */
  hc_comm_barrier(file->comm);
}

hc_status hc_shared_file_close(hc_shared_file *file) {
  if (file->handle < 0) return file->problem->status;
  if (hc_comm_agree(file->comm, file->problem) != HC_OK) make_closable(file);
  if (H5Fclose(file->handle) < 0)
    hc_h5_failed(file->problem, HC_IO_FAILED, "cannot complete %s", file->final);
  file->handle = H5I_INVALID_HID;
  H5garbage_collect(); /* HDF5 keeps its buffers for next time; the particles need the memory more */
  return hc_comm_agree(file->comm, file->problem);
}

hc_status hc_shared_file_seal(hc_shared_file *file, const void *data, size_t bytes) {
  const char *from = data;
  size_t done = 0;
  while (file->comm->rank == 0 && file->problem->status == HC_OK && done < bytes) {
    const ssize_t written = pwrite(file->reserved, from + done, bytes - done, (off_t)done);
    if (written > 0)
      done += (size_t)written;
    else if (errno != EINTR)
      hc_error_set(file->problem, HC_IO_FAILED, "cannot write %s: %s", file->final, strerror(errno));
  }
  return hc_comm_agree(file->comm, file->problem);
}

/* Every rank but the first: what it wrote goes to disk from its own machine. */
static void sync_share(const hc_shared_file *file) {
  const int share = open(file->temporary, O_RDONLY | O_CLOEXEC);
  if (share < 0 || fsync(share) != 0)
    hc_error_set(file->problem, HC_IO_FAILED, "cannot sync %s: %s", file->final, strerror(errno));
  if (share >= 0) close(share);
}

/* Rank 0: gives back the reserved blocks that were not needed, syncs and renames. */
static void publish(hc_shared_file *file) {
  struct stat facts;
  if (fstat(file->reserved, &facts) != 0 || ftruncate(file->reserved, facts.st_size) != 0 ||
      fsync(file->reserved) != 0)
    hc_error_set(file->problem, HC_IO_FAILED, "cannot write %s: %s", file->final, strerror(errno));
  else
    hc_atomic_file_rename(file->temporary, file->final, file->problem);
}

hc_status hc_shared_file_end(hc_shared_file *file) {
  if (file->problem->status == HC_OK && file->comm->rank > 0) sync_share(file);
  hc_comm_agree(file->comm, file->problem);
  if (file->reserved >= 0) {
    if (file->problem->status == HC_OK) publish(file);
    close(file->reserved);
    if (file->problem->status != HC_OK) unlink(file->temporary);
  }
  return hc_comm_agree(file->comm, file->problem);
}
