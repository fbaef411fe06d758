/* Seconds on a monotonic clock, for timings only: nothing that a simulation computes depends on it. */
#ifndef HC_TIMER_H
#define HC_TIMER_H

double hc_seconds(void);

/* Processor time of the calling thread. */
double hc_work_seconds(void);

#endif
