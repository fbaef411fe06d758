/* Writes JSON: commas, quotes and escapes. Local. Each call writes one value, with its name if it is a member
 * of an object, and null for the name if it is an item of a list or the whole. */
#ifndef HC_JSON_H
#define HC_JSON_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

enum { HC_JSON_DEPTH = 8 };

typedef enum hc_json_layout { HC_JSON_DENSE, HC_JSON_LINES } hc_json_layout;

typedef struct hc_json {
  FILE *stream;
  bool spaced; /* a space behind commas and colons */
  int depth, indent;
  struct {
    char closing;
    bool any;
    hc_json_layout layout;
  } open[HC_JSON_DEPTH];
} hc_json;

void hc_json_begin(hc_json *json, FILE *stream, bool spaced);

/* An object or a list, up to the end that belongs to it; HC_JSON_LINES: each member on a line of its own. The
 * end of the whole is followed by a line end. */
void hc_json_object(hc_json *json, const char *name, hc_json_layout layout);
void hc_json_list(hc_json *json, const char *name, hc_json_layout layout);
void hc_json_end(hc_json *json);

/* Bytes of text above 127 pass as they are (UTF-8). Numbers read back as the same doubles; what is none is
 * null. */
void hc_json_string(hc_json *json, const char *name, const char *text);
void hc_json_bool(hc_json *json, const char *name, bool value);
void hc_json_integer(hc_json *json, const char *name, int64_t value);
void hc_json_id(hc_json *json, const char *name, uint64_t value);
void hc_json_number(hc_json *json, const char *name, double value);
void hc_json_null(hc_json *json, const char *name);

/* A list of numbers, and {"low":[x,y,z],"high":[x,y,z]} or, unless there is `any`, null. */
void hc_json_numbers(hc_json *json, const char *name, int count, const double *values);
void hc_json_extent(hc_json *json, const char *name, bool any, const double low[3], const double high[3]);

#endif
