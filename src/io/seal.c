#include "seal.h"

#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

enum { CHUNK = 4 << 20 };

static const char magic[] = "Halocline checkpoint, format ";

/* Without a communicator this process is all there is. */
static hc_status agree(hc_comm *comm, hc_error *error) {
  return comm ? hc_comm_agree(comm, error) : error->status;
}

/* Reads exactly `bytes` at `offset`; an end of file is an error too. */
static hc_status read_at(int file, const char *path, void *to, size_t bytes, int64_t offset,
                         hc_error *error) {
  size_t done = 0;
  while (done < bytes) {
    const ssize_t got = pread(file, (char *)to + done, bytes - done, (off_t)(offset + (int64_t)done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      return hc_error_set(error, HC_IO_FAILED, "%s: cannot be read at byte %lld: %s", path,
                          (long long)(offset + (int64_t)done), got < 0 ? strerror(errno) : "the file ends");
    done += (size_t)got;
  }
  return HC_OK;
}

/* This rank's share of the chunks' hashes. */
static XXH128_canonical_t *hash_share(int rank, int ranks, int file, const char *path, int64_t size,
                                      size_t *count, hc_error *error) {
  const int64_t body = size - HC_SEAL_BYTES, chunks = (body + CHUNK - 1) / CHUNK;
  const int64_t begin = chunks * rank / ranks, end = chunks * (rank + 1) / ranks;
  XXH128_canonical_t *hashes = hc_alloc_zero((size_t)(end - begin), sizeof *hashes);
  char *buffer = hc_alloc(end > begin ? CHUNK : 0, 1);
  for (int64_t chunk = begin; chunk < end && error->status == HC_OK; chunk++) {
    const int64_t left = body - chunk * CHUNK;
    const size_t bytes = left < CHUNK ? (size_t)left : CHUNK;
    if (read_at(file, path, buffer, bytes, HC_SEAL_BYTES + chunk * CHUNK, error) == HC_OK)
      XXH128_canonicalFromHash(&hashes[chunk - begin], XXH3_128bits(buffer, bytes));
  }
  hc_free(buffer);
  *count = (size_t)(end - begin);
  return hashes;
}

/* The seal that a file of this size must have. Collective; agreed. */
static hc_status compute(hc_comm *comm, int file, const char *path, int64_t size, char seal[HC_SEAL_BYTES],
                         hc_error *error) {
  size_t count, bytes;
  XXH128_canonical_t *mine =
      hash_share(comm ? comm->rank : 0, comm ? comm->size : 1, file, path, size, &count, error);
  void *all = mine;
  bytes = count * sizeof *mine;
  if (comm) hc_comm_gather_all(comm, mine, bytes, &all, &bytes);
  const XXH128_hash_t hash = XXH3_128bits_withSeed(all, bytes, (XXH64_hash_t)size);
  if (comm) hc_free(all);
  hc_free(mine);
  memset(seal, 0, HC_SEAL_BYTES);
  snprintf(seal, HC_SEAL_BYTES, "%s%d\nbytes %lld\nxxh3-128 %016llx%016llx\n", magic, HC_CHECKPOINT_FORMAT,
           (long long)size, (unsigned long long)hash.high64, (unsigned long long)hash.low64);
  return agree(comm, error);
}

/* Opens the file on every rank and agrees on its size. Returns a descriptor, or -1 with an agreed error. */
static int open_all(hc_comm *comm, const char *path, int64_t *size, hc_error *error) {
  struct stat facts;
  *size = 0;
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0 || fstat(file, &facts) != 0)
    hc_error_set(error, HC_IO_FAILED, "%s: cannot be opened: %s", path, strerror(errno));
  else if (!S_ISREG(facts.st_mode))
    hc_error_set(error, HC_IO_FAILED, "%s: not a file", path);
  else if (facts.st_size <= HC_SEAL_BYTES)
    hc_error_set(error, HC_IO_FAILED, "%s: cut short: only %lld bytes", path, (long long)facts.st_size);
  else
    *size = facts.st_size;
  if (comm) hc_comm_broadcast(comm, size, sizeof *size, 0);
  if (agree(comm, error) == HC_OK) return file;
  if (file >= 0) close(file);
  return -1;
}

hc_status hc_seal_make(hc_comm *comm, const char *path, char seal[HC_SEAL_BYTES], hc_error *error) {
  int64_t size;
  const int file = open_all(comm, path, &size, error);
  if (file < 0) return error->status;
  sync_file_range(file, 0, 0, SYNC_FILE_RANGE_WRITE); /* a hint: the sync that counts comes later */
  compute(comm, file, path, size, seal, error);
  close(file);
  return error->status;
}

/* Rank 0: what a seal that is not the expected one tells. */
static void judge(const char *path, const char *found, const char *expected, int64_t size, hc_error *error) {
  char text[HC_SEAL_BYTES + 1];
  int format = 0;
  long long bytes = 0;
  memcpy(text, found, HC_SEAL_BYTES);
  text[HC_SEAL_BYTES] = '\0';
  if (strncmp(text, magic, sizeof magic - 1) != 0 ||
      sscanf(text + sizeof magic - 1, "%d\nbytes %lld\n", &format, &bytes) != 2)
    hc_error_set(error, HC_IO_FAILED, "%s: not a Halocline checkpoint, or its beginning is damaged", path);
  else if (format != HC_CHECKPOINT_FORMAT)
    hc_error_set(error, HC_IO_FAILED, "%s: of format %d, this program reads format %d (or it is damaged)",
                 path, format, HC_CHECKPOINT_FORMAT);
  else if (bytes != size)
    hc_error_set(error, HC_IO_FAILED, "%s: has %lld bytes, but was written with %lld: cut short or damaged",
                 path, (long long)size, bytes);
  else if (memcmp(found, expected, HC_SEAL_BYTES) != 0)
    hc_error_set(error, HC_IO_FAILED, "%s: damaged: its checksum does not match its content", path);
}

bool hc_seal_is_there(const char *path) {
  char begin[sizeof magic - 1];
  const int file = open(path, O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  hc_error ignored = {.status = HC_OK};
  const bool there = read_at(file, path, begin, sizeof begin, 0, &ignored) == HC_OK &&
                     memcmp(begin, magic, sizeof begin) == 0;
  close(file);
  return there;
}

hc_status hc_seal_check(hc_comm *comm, const char *path, hc_error *error) {
  int64_t size;
  const int file = open_all(comm, path, &size, error);
  if (file < 0) return error->status;
  char found[HC_SEAL_BYTES], expected[HC_SEAL_BYTES];
  if (compute(comm, file, path, size, expected, error) == HC_OK && (!comm || comm->rank == 0) &&
      read_at(file, path, found, sizeof found, 0, error) == HC_OK)
    judge(path, found, expected, size, error);
  close(file);
  return agree(comm, error);
}
