/* The progress of a run, for people: on a terminal one line that is rewritten a few times a second, elsewhere
 * a line every five seconds. Local, for rank 0; a zeroed hc_progress (the other ranks') shows nothing. */
#ifndef HC_PROGRESS_H
#define HC_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

typedef struct hc_progress {
  FILE *stream; /* null: quiet */
  bool terminal;
  double interval;                         /* s between two lines */
  double start, shown;                     /* wall clock: of the run, of the last line */
  double start_time, shown_time, end_time; /* simulated, s */
  double work, total_work;                 /* particles times steps: since the last line, of the run */
  double rate;                             /* simulated seconds per wall second, smoothed */
} hc_progress;

/* What is known after a step. */
typedef struct hc_progress_sample {
  int64_t step;
  double time, dt; /* s */
  int iterations_density, iterations_divergence;
  double density_error; /* average, fraction of the rest density */
  int64_t particles;    /* fluid, all ranks */
  double imbalance;     /* largest over mean load */
} hc_progress_sample;

/* True if the stream ends at a terminal. mpirun gives its children a pseudo-terminal on standard output
 * wherever its own output goes, so under mpirun it is mpirun's output that counts. */
bool hc_progress_on_terminal(FILE *stream);

/* Begins at simulated time `time` of `end_time`. `stream` null: quiet. */
void hc_progress_start(hc_progress *progress, FILE *stream, bool terminal, double time, double end_time);

/* To be called after every step; writes when it is time to. */
void hc_progress_step(hc_progress *progress, const hc_progress_sample *sample);

/* Writes the last state and ends the line. */
void hc_progress_finish(hc_progress *progress, const hc_progress_sample *sample);

#endif
