/* The output directory of a run. */
#ifndef HC_RUN_DIR_H
#define HC_RUN_DIR_H

#include "comm/comm.h"
#include "halocline/error.h"

typedef enum hc_run_dir_mode {
  HC_RUN_DIR_NEW,    /* a directory that holds a run is refused */
  HC_RUN_DIR_FORCE,  /* the old run's own files are removed first, nothing else */
  HC_RUN_DIR_RESUME, /* the files stay: the run goes on in them */
} hc_run_dir_mode;

/* Makes `directory` (with its parents) ready for a run. A directory holds a run if it has steps.csv,
 * scene.yaml or a checkpoint. HC_RUN_DIR_FORCE removes scene.yaml, run.log, steps.csv, load.csv, gauges.csv,
 * timings.json, snapshots/snap_<digits>.hdf, snapshots/fault_<digits>.hdf, snapshots/run.hdf.series,
 * checkpoints/ckpt_<digits>.h5 and temporaries of these. Collective; rank 0 does the work, every rank returns
 * the same. HC_BAD_INPUT: it holds a run. HC_IO_FAILED: it cannot be created, read or cleared. */
hc_status hc_run_dir_open(hc_comm *comm, const char *directory, hc_run_dir_mode mode, hc_error *error);

/* Holds the directory for this run as long as `*lock`, a descriptor, is open: waits for a run that is just
 * ending there, ranks of it that were left over included. Collective. No directory: HC_OK and *lock = -1; on
 * a file system without locks, or whose locks other machines do not see, it holds nothing. HC_IO_FAILED:
 * another run is at work in it. */
hc_status hc_run_dir_lock(hc_comm *comm, const char *directory, int *lock, hc_error *error);

/* A run goes on from `step` with `snapshots` snapshots behind it: removes checkpoints and fault snapshots of
 * later steps, first of all, so that no restart takes one whose rows are gone; then snapshots from that
 * number on, and their entries in run.hdf.series; and temporaries of all these. Local, for rank 0.
 * HC_IO_FAILED if that cannot be done. */
hc_status hc_run_dir_cut(const char *directory, int64_t step, int64_t snapshots, hc_error *error);

#endif
