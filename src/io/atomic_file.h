/* Files that appear whole or not at all: written under a temporary name beside the final one, synced,
 * renamed. Local; every error is HC_IO_FAILED with the path and the system's reason. */
#ifndef HC_ATOMIC_FILE_H
#define HC_ATOMIC_FILE_H

#include "halocline/error.h"
#include "text.h"

#include <stdio.h>

typedef struct hc_atomic_file {
  FILE *stream; /* write here between begin and commit */
  char path[HC_TEXT_PATH], temporary[HC_TEXT_PATH];
} hc_atomic_file;

/* Opens the temporary of DIRECTORY/NAME, which is ".NAME.tmp" in the same directory. */
hc_status hc_atomic_file_begin(hc_atomic_file *file, const char *directory, const char *name,
                               hc_error *error);

/* Checks all that was written, syncs it and gives it its final name. On failure the temporary is removed. */
hc_status hc_atomic_file_commit(hc_atomic_file *file, hc_error *error);

/* All three in one, for a text that is there already. */
hc_status hc_atomic_file_write(const char *directory, const char *name, const char *text, hc_error *error);

/* Drops the temporary instead. */
void hc_atomic_file_abandon(hc_atomic_file *file);

/* Renames a complete, synced file and makes the new name durable. */
hc_status hc_atomic_file_rename(const char *from, const char *to, hc_error *error);

#endif
