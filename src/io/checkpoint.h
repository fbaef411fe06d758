/* Checkpoints: one HDF5 file from which a run goes on bit for bit, on any number of ranks.
 *
 * Sealed (seal.h) in a user block of 512 bytes, then HDF5: /Halocline with the attributes of a snapshot (see
 * snapshot.h) and content = "checkpoint", instruction_set, ranks, and the dataset scene_text, the scene as
 * understood; /state: an attribute for each item of the state; /fluid, /boundary (walls that
 * stand still) and /moving: a dataset for each state field of fields.def that the run has, rows in the order
 * of the ranks that wrote it. */
#ifndef HC_CHECKPOINT_H
#define HC_CHECKPOINT_H

#include "checkpoint_content.h"
#include "text.h"

/* Writes DIRECTORY/checkpoints/ckpt_NNNNNNNN.h5 (NNNNNNNN = moment->step); the `keep` newest are kept.
 * Collective; every rank returns the
 * same. On failure (HC_IO_FAILED: the disk is full, ...; HC_FAILED: no memory) older checkpoints are as they
 * were. `bytes`: the size of the file. */
hc_status hc_checkpoint_write(hc_comm *comm, const hc_scene *scene, const hc_moment *moment,
                              const hc_state *state, const char *instruction_set, const char *directory,
                              int keep, int64_t *bytes, hc_error *error);

/* The checkpoint of DIRECTORY with the highest step below `below` (INT64_MAX: the newest) into `path`, and
 * its step; -1 if there is none. Temporaries do not count. Collective; HC_IO_FAILED, agreed, if the directory
 * cannot be read. */
hc_status hc_checkpoint_find(hc_comm *comm, const char *directory, int64_t below, char path[HC_TEXT_PATH],
                             int64_t *step, hc_error *error);

#endif
