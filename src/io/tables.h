/* steps.csv and load.csv: a row a step; gauges.csv: a row a reading. Local, for rank 0; a zeroed hc_tables
 * (the other ranks') takes rows and drops them. Numbers are printed so that they read back as the same
 * doubles, and steps.csv has the same bytes on any number of ranks. A row is in the file when the call
 * returns. */
#ifndef HC_TABLES_H
#define HC_TABLES_H

#include "halocline/error.h"
#include "text.h"

#include <stdint.h>
#include <stdio.h>
#include <sys/types.h>

/* A row of steps.csv: the physics. */
typedef struct hc_step_row {
  int64_t step;
  double time, dt; /* s */
  int iterations_density, iterations_divergence;
  double density_error_avg, density_error_max; /* fractions of the rest density */
  double v_max, a_max;                         /* m/s, m/s2 */
  double force_max;                        /* m/s2: what the choice of the next step reads, see solver.h */
  double kinetic_energy, potential_energy; /* J */
  int64_t fluid_particles;
  double active_fraction, active_boundary_fraction; /* the first as a mean over sub-steps */
  int substeps;                                     /* of the step: 1 but with individual steps */
  const char *event; /* words joined by '+', or "" or null; no comma, quote or line end */
} hc_step_row;

/* A row of load.csv: the machine. The imbalance is that of the step: the largest over the mean processor time
 * that a rank worked, waiting for others excluded. */
typedef struct hc_load_row {
  int64_t step;
  double wall_seconds, imbalance;
  int64_t ghosts_max, bytes_sent_max;
  const char *event;
} hc_load_row;

typedef struct hc_table {
  FILE *stream;
  off_t rows; /* where they begin, behind the line of names */
  char path[HC_TEXT_PATH];
} hc_table;

typedef struct hc_tables {
  hc_table steps, load, gauges;
} hc_tables;

/* Opens them in `directory`; `gauge_names` is the list of gauges.csv's columns behind the time, each led by a
 * comma: empty for no gauges.csv. last_step < 0: new files. Else a run that goes on from that step and time:
 * later rows, and a last row cut short, are dropped, and rows are added behind; a missing table is started.
 * HC_IO_FAILED if one cannot be written or an existing one has other columns; then nothing stays open. */
hc_status hc_tables_open(hc_tables *tables, const char *directory, const char *gauge_names, int64_t last_step,
                         double last_time, hc_error *error);

/* Add a row. HC_IO_FAILED with the path and the system's reason, such as a full disk. */
hc_status hc_tables_add_step(hc_tables *tables, const hc_step_row *row, hc_error *error);
hc_status hc_tables_add_load(hc_tables *tables, const hc_load_row *row, hc_error *error);

hc_status hc_tables_add_gauges(hc_tables *tables, double time, const double *values, int count,
                               hc_error *error);

/* Takes rows back: those of steps after last_step, and those of gauges.csv after last_time; reads no more
 * than what is taken back and some 64 kB. HC_IO_FAILED as above. */
hc_status hc_tables_cut(hc_tables *tables, int64_t last_step, double last_time, hc_error *error);

/* Brings all rows to disk. */
hc_status hc_tables_sync(hc_tables *tables, hc_error *error);

/* Closes them, also after an error. */
hc_status hc_tables_close(hc_tables *tables, hc_error *error);

#endif
