/* Why a run stops before its end: a signal. */
#ifndef HC_STOP_H
#define HC_STOP_H

/* From now on SIGTERM, SIGUSR1 and SIGUSR2 are remembered instead of ending the process. Local. */
void hc_stop_catch_signals(void);

/* The number of the first of them that has come, 0 if none has; and its name. Local. */
int hc_stop_signal(void);
const char *hc_stop_signal_name(int signal);

#endif
