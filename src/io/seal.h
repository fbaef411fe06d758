/* The seal of a checkpoint: its size and a checksum of all that follows, in the first 512 bytes of the file,
 * which HDF5 leaves to its users (a user block). A file is only handed to HDF5 once the seal is found whole:
 * HDF5 1.10 may crash on damaged files.
 *
 * The seal is text: a line with the format, one with the size in bytes, one with the checksum, then zeros.
 * The checksum is XXH3-128 (xxHash) of the size and of the XXH3-128s of the chunks behind the seal; chunks
 * are hashed by all ranks, each its share. */
#ifndef HC_SEAL_H
#define HC_SEAL_H

#include "comm/comm.h"
#include "halocline/error.h"

enum { HC_SEAL_BYTES = 512, HC_CHECKPOINT_FORMAT = 2 };

/* Reads the file at `path` (the same on every rank), whose way to disk is begun meanwhile, and makes its
 * seal. Collective; HC_IO_FAILED, agreed, if it cannot be read. */
hc_status hc_seal_make(hc_comm *comm, const char *path, char seal[HC_SEAL_BYTES], hc_error *error);

/* Does the file begin like a sealed one? Local. */
bool hc_seal_is_there(const char *path);

/* Compares the file with its seal; `comm` null: by this process alone. Collective; HC_IO_FAILED, agreed, with
 * the reason: cannot be read, cut short, of another format, damaged. */
hc_status hc_seal_check(hc_comm *comm, const char *path, hc_error *error);

#endif
