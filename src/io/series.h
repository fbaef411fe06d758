/* snapshots/run.hdf.series: the times of the snapshots, for ParaView. */
#ifndef HC_SERIES_H
#define HC_SERIES_H

#include "halocline/error.h"

#include <stdbool.h>

/* Rewrites DIRECTORY/run.hdf.series with one more entry, snap_NNNNNN.hdf at `time` [s]. Entries with this
 * number or a later one are dropped: they belong to a run that was taken back by a restart. Local, for rank
 * 0; the file appears whole. HC_IO_FAILED if it cannot be written. A series that is missing or not ours
 * counts as empty. */
hc_status hc_series_add(const char *directory, int number, double time, hc_error *error);

/* Where DIRECTORY holds snapshots but no series, makes one of those with numbers before `number`, by the
 * times that stand in them; *made says whether. Snapshots that cannot be read are passed over. Local, for
 * rank 0. */
hc_status hc_series_restore(const char *directory, int number, bool *made, hc_error *error);

/* Drops the entries with this number or a later one; a series that is missing stays so. Local, for rank 0. */
hc_status hc_series_cut(const char *directory, int number, hc_error *error);

#endif
