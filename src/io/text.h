/* Numbers and paths as text. Local. */
#ifndef HC_TEXT_H
#define HC_TEXT_H

#include "halocline/error.h"

#include <stdio.h>

enum { HC_TEXT_NUMBER = 32, HC_TEXT_PATH = 4096 };

/* The shortest %g form that reads back as the same double ("0.1", not "0.10000000000000001"); "nan", "inf"
 * and
 * "-inf" otherwise. Puts it into `out` and returns `out`. */
const char *hc_text_number(char out[HC_TEXT_NUMBER], double value);

/* A formatted path. HC_BAD_INPUT if it is longer than HC_TEXT_PATH - 1 bytes. */
hc_status hc_text_path(char out[HC_TEXT_PATH], hc_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
