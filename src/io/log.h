/* run.log: lines of elapsed seconds, level and text. Rank 0's log writes; a zeroed hc_log (the other ranks')
 * takes every call and does nothing. Local. */
#ifndef HC_LOG_H
#define HC_LOG_H

#include "halocline/error.h"
#include "text.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum { HC_LOG_KINDS = 64 };

typedef struct hc_log {
  FILE *file; /* null: nothing is written */
  FILE *echo; /* where warnings are shown, stderr unless changed; null: nowhere */
  double start;
  uint64_t shown[HC_LOG_KINDS]; /* kinds of warnings that were echoed, by the hash of their format */
  int shown_count;
  char path[HC_TEXT_PATH];
} hc_log;

/* Opens DIRECTORY/run.log, new or (`append`) behind what is there. HC_IO_FAILED if it cannot be written. */
hc_status hc_log_open(hc_log *log, const char *directory, bool append, hc_error *error);

/* One entry; a text of several lines gets the level on each. A warning goes to the log every time, and to
 * `echo` once per kind (format string), so that a particle that misbehaves at every step does not flood a
 * terminal. */
void hc_log_info(hc_log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));
void hc_log_warn(hc_log *log, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* The warning of its kind with this number, from 1: the first ten are told, then the 100th, the 1000th and so
 * on, so that what happens in every step does not fill the log either. The caller counts. */
void hc_log_warn_counted(hc_log *log, int64_t number, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* HC_IO_FAILED if a line could not be written. A run goes on without its log; this is where it learns. */
hc_status hc_log_close(hc_log *log, hc_error *error);

#endif
