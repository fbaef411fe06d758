/* An HDF5 file that all ranks write together and that appears whole or not at all: made under a temporary
 * name, its disk space reserved before any data goes out, synced, renamed. Used by snapshots and checkpoints.
 *
 * Use: open, write the content, close, then seal if something is to be added to the finished file, publish.
 * Whatever happened before, hc_shared_file_end must be called; until it has been, `problem` keeps this rank's
 * first failure. Collective, all of it. Failures are HC_IO_FAILED, or
 * HC_FAILED if the memory that HDF5 takes is not there. */
#ifndef HC_SHARED_FILE_H
#define HC_SHARED_FILE_H

#include "comm/comm.h"
#include "h5.h"
#include "text.h"

typedef struct hc_shared_file {
  hc_comm *comm;
  char directory[HC_TEXT_PATH], temporary[HC_TEXT_PATH], final[HC_TEXT_PATH];
  hid_t handle; /* between open and close */
  int reserved; /* rank 0: a descriptor of the temporary, or -1 */
  hc_error *problem;
} hc_shared_file;

/* Creates DIRECTORY/BELOW (if need be) and in it .NAME.tmp with room for `bytes` and a user block of that
 * size (0: none). Afterwards `problem` is agreed; file->handle is open if it is HC_OK. */
hc_status hc_shared_file_open(hc_shared_file *file, hc_comm *comm, const char *directory, const char *below,
                              const char *name, int64_t bytes, int user_block, hc_error *problem);

/* Closes the HDF5 file; `problem` is agreed afterwards. All objects in it must be closed. */
hc_status hc_shared_file_close(hc_shared_file *file);

/* Rank 0 writes `bytes` at the beginning of the closed file, into its user block; agreed afterwards. */
hc_status hc_shared_file_seal(hc_shared_file *file, const void *data, size_t bytes);

/* Syncs the file and gives it its final name, if `problem` is HC_OK; else removes it. Agreed afterwards. */
hc_status hc_shared_file_end(hc_shared_file *file);

#endif
