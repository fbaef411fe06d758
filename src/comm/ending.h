/* One rank that dies ends all: mpirun sees to it, other launchers need not, and a program that embeds a run
 * may wait elsewhere. While a session of several processes lives, broken invariants, lack of memory and the
 * signals of a crash end all processes of MPI_COMM_WORLD by MPI_Abort, whatever the session's own
 * communicator. Local. */
#ifndef HC_ENDING_H
#define HC_ENDING_H

/* Begins to watch; calls nest. MPI must run. Handlers of signals that were there are let speak first; those
 * of SIGSEGV and its like that stay for more than one signal are not taken over, as they may mend what
 * happened. */
void hc_ending_watch(void);

/* Ends to watch, before MPI ends. */
void hc_ending_unwatch(void);

#endif
