/* The mean over a fixed time up to now, of what steps add.
 *
 * Time since the start is cut into shares, 64 to that time. Of each the integral is kept, of a step across a
 * border in parts by time. So memory is bounded however short steps are, and the mean does not depend on when
 * it is asked for. It covers the time exactly; known weakness: of the oldest share, which leaves it bit by
 * bit, it takes the mean for all its parts. That is wrong by at most 1/256 of what the values in that share
 * differ. All of it is local; the same values give the same bits. */
#ifndef HC_MOVING_MEAN_H
#define HC_MOVING_MEAN_H

#include "state/state.h"

enum { HC_MOVING_MEAN_SHARES = 64 };

typedef struct hc_moving_mean {
  double share; /* s */
  int columns;
  double *integrals; /* of each column and share; a ring of one share more than the time has */
  double filled;     /* s, of the newest share */
  int64_t newest;    /* its number, 0 at the start */
} hc_moving_mean;

/* A mean over `time`, s, of several columns. Freed with hc_moving_mean_free. */
void hc_moving_mean_init(hc_moving_mean *mean, double time, int columns);
void hc_moving_mean_free(hc_moving_mean *mean);

/* Registers what is state, for the gauge of that number. */
void hc_moving_mean_register(hc_moving_mean *mean, hc_state *state, int gauge);

/* A step of dt, s, and the integral over it of each column. */
void hc_moving_mean_add(hc_moving_mean *mean, double dt, const double *integral);

/* The mean of each column over the time up to now, or since the start if that is less; 0 at the start. */
void hc_moving_mean_read(const hc_moving_mean *mean, double *values);

#endif
