/* Numbers and strings as text, for the CSV and JSON files. Local. */
#ifndef HC_TEXT_H
#define HC_TEXT_H

#include "halocline/error.h"

#include <stdbool.h>
#include <stdio.h>

enum { HC_TEXT_NUMBER = 32, HC_TEXT_PATH = 4096 };

/* The shortest %g form that reads back as the same double ("0.1", not "0.10000000000000001"); "nan", "inf"
 * and
 * "-inf" otherwise. Puts it into `out` and returns `out`. */
const char *hc_text_number(char out[HC_TEXT_NUMBER], double value);

/* The same, but "null" where JSON has no number for it. */
const char *hc_text_json_number(char out[HC_TEXT_NUMBER], double value);

/* Writes `text` as a JSON string with its quotes. Bytes above 127 pass as they are (UTF-8). */
void hc_text_json_string(FILE *stream, const char *text);

/* Further members of a JSON object: `,"name":` and a number or, for count > 0, a list of them; and
 * `BEFORE"name":{"low":[x,y,z],"high":[x,y,z]}`, null if there is none. */
void hc_text_json_numbers(FILE *stream, const char *name, int count, const double *values);
void hc_text_json_extent(FILE *stream, const char *before, const char *name, bool any, const double low[3],
                         const double high[3]);

/* A formatted path. HC_BAD_INPUT if it is longer than HC_TEXT_PATH - 1 bytes. */
hc_status hc_text_path(char out[HC_TEXT_PATH], hc_error *error, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
