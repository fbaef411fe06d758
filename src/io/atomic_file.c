#include "atomic_file.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdbool.h>
#include <string.h>
#include <unistd.h>

hc_status hc_atomic_file_begin(hc_atomic_file *file, const char *directory, const char *name,
                               hc_error *error) {
  file->stream = NULL;
  hc_status status = hc_text_path(file->path, error, "%s/%s", directory, name);
  if (status == HC_OK) status = hc_text_path(file->temporary, error, "%s/.%s.tmp", directory, name);
  if (status != HC_OK) return status;
  file->stream = fopen(file->temporary, "w");
  if (file->stream) return HC_OK;
  return hc_error_set(error, HC_IO_FAILED, "cannot write %s: %s", file->temporary, strerror(errno));
}

void hc_atomic_file_abandon(hc_atomic_file *file) {
  if (!file->stream) return;
  fclose(file->stream); /* nothing of it is kept: its result does not matter */
  file->stream = NULL;
  unlink(file->temporary);
}

hc_status hc_atomic_file_commit(hc_atomic_file *file, hc_error *error) {
  errno = 0;
  const bool written = fflush(file->stream) == 0 && !ferror(file->stream) && fsync(fileno(file->stream)) == 0;
  int reason = errno;
  const bool closed = fclose(file->stream) == 0;
  file->stream = NULL;
  if (written && !closed) reason = errno;
  if (!written || !closed) {
    unlink(file->temporary);
    return hc_error_set(error, HC_IO_FAILED, "cannot write %s: %s", file->path,
                        reason ? strerror(reason) : "write error");
  }
  const hc_status status = hc_atomic_file_rename(file->temporary, file->path, error);
  if (status != HC_OK) unlink(file->temporary);
  return status;
}

hc_status hc_atomic_file_write(const char *directory, const char *name, const char *text, hc_error *error) {
  hc_atomic_file file;
  const hc_status status = hc_atomic_file_begin(&file, directory, name, error);
  if (status != HC_OK) return status;
  fputs(text, file.stream);
  return hc_atomic_file_commit(&file, error);
}

/* A rename lasts through a power cut once its directory is synced. File systems that cannot sync a directory
 * say EINVAL or EBADF; nothing more can be done there. */
static int sync_directory_of(const char *path) {
  char copy[HC_TEXT_PATH];
  snprintf(copy, sizeof copy, "%s", path);
  const int directory = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return errno;
  const int reason = fsync(directory) == 0 || errno == EINVAL || errno == EBADF ? 0 : errno;
  close(directory);
  return reason;
}

hc_status hc_atomic_file_rename(const char *from, const char *to, hc_error *error) {
  if (rename(from, to) != 0)
    return hc_error_set(error, HC_IO_FAILED, "cannot rename %s to %s: %s", from, to, strerror(errno));
  const int reason = sync_directory_of(to);
  if (reason)
    return hc_error_set(error, HC_IO_FAILED, "cannot sync the directory of %s: %s", to, strerror(reason));
  return HC_OK;
}
