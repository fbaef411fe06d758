/* Status codes and error messages.
 *
 * A function that can fail for reasons outside the program (a bad scene, a full disk) returns a status and
 * puts one message into an hc_error. Broken invariants never come back: they abort (see src/base/check.h). */
#ifndef HALOCLINE_ERROR_H
#define HALOCLINE_ERROR_H

#include "halocline/export.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The values are the program's exit codes. */
typedef enum hc_status {
  HC_OK = 0,        /* done */
  HC_FAILED = 1,    /* the simulation failed: diverged, particles lost */
  HC_BAD_INPUT = 2, /* bad usage, bad scene, or an input of the scene missing or broken */
  HC_IO_FAILED = 3, /* an output could not be written or read */
} hc_status;

enum { HC_ERROR_TEXT = 8192 };

/* What went wrong, for people. `text` has no newline at its end; it may hold several lines. */
typedef struct hc_error {
  hc_status status;
  char text[HC_ERROR_TEXT];
} hc_error;

/* Puts a formatted message into `error` (which may be null) and returns `status`. Local; never fails. */
HC_PUBLIC hc_status hc_error_set(hc_error *error, hc_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#ifdef __cplusplus
}
#endif
#endif
