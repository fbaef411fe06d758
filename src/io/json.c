#include "json.h"

#include "base/check.h"
#include "text.h"

#include <inttypes.h>
#include <math.h>

static void put_text(FILE *stream, const char *text) {
  fputc('"', stream);
  for (const char *c = text; *c; c++) {
    if (*c == '"' || *c == '\\')
      fprintf(stream, "\\%c", *c);
    else if ((unsigned char)*c < 0x20 || *c == 0x7f)
      fprintf(stream, "\\u%04x", (unsigned)*c);
    else
      fputc(*c, stream);
  }
  fputc('"', stream);
}

static void new_line(const hc_json *json) {
  fprintf(json->stream, "\n%*s", 2 * json->indent, "");
}

/* What stands before a value. */
static void lead(hc_json *json, const char *name) {
  if (json->depth > 0) {
    const int last = json->depth - 1;
    const bool lines = json->open[last].layout == HC_JSON_LINES;
    HC_CHECK((json->open[last].closing == '}') == (name != NULL), "JSON: members have a name, items none");
    if (json->open[last].any) fputs(json->spaced && !lines ? ", " : ",", json->stream);
    if (lines) new_line(json);
    json->open[last].any = true;
  }
  if (!name) return;
  put_text(json->stream, name);
  fputs(json->spaced ? ": " : ":", json->stream);
}

static void open_one(hc_json *json, const char *name, const char *brackets, hc_json_layout layout) {
  HC_CHECK(json->depth < HC_JSON_DEPTH, "JSON goes at most %d levels deep", HC_JSON_DEPTH);
  lead(json, name);
  fputc(brackets[0], json->stream);
  json->open[json->depth].closing = brackets[1];
  json->open[json->depth].any = false;
  json->open[json->depth].layout = layout;
  json->depth++;
  json->indent += layout == HC_JSON_LINES;
}

void hc_json_begin(hc_json *json, FILE *stream, bool spaced) {
  *json = (hc_json){.stream = stream, .spaced = spaced};
}

void hc_json_object(hc_json *json, const char *name, hc_json_layout layout) {
  open_one(json, name, "{}", layout);
}

void hc_json_list(hc_json *json, const char *name, hc_json_layout layout) {
  open_one(json, name, "[]", layout);
}

void hc_json_end(hc_json *json) {
  HC_CHECK(json->depth > 0, "JSON: no object or list is open at depth %d", json->depth);
  json->depth--;
  if (json->open[json->depth].layout == HC_JSON_LINES) {
    json->indent--;
    new_line(json);
  }
  fputc(json->open[json->depth].closing, json->stream);
  if (json->depth == 0) fputc('\n', json->stream);
}

void hc_json_string(hc_json *json, const char *name, const char *text) {
  lead(json, name);
  put_text(json->stream, text);
}

void hc_json_bool(hc_json *json, const char *name, bool value) {
  lead(json, name);
  fputs(value ? "true" : "false", json->stream);
}

void hc_json_integer(hc_json *json, const char *name, int64_t value) {
  lead(json, name);
  fprintf(json->stream, "%" PRId64, value);
}

void hc_json_id(hc_json *json, const char *name, uint64_t value) {
  lead(json, name);
  fprintf(json->stream, "%" PRIu64, value);
}

void hc_json_number(hc_json *json, const char *name, double value) {
  char text[HC_TEXT_NUMBER];
  lead(json, name);
  fputs(isfinite(value) ? hc_text_number(text, value) : "null", json->stream);
}

void hc_json_null(hc_json *json, const char *name) {
  lead(json, name);
  fputs("null", json->stream);
}

void hc_json_numbers(hc_json *json, const char *name, int count, const double *values) {
  hc_json_list(json, name, HC_JSON_DENSE);
  for (int k = 0; k < count; k++) hc_json_number(json, NULL, values[k]);
  hc_json_end(json);
}

void hc_json_extent(hc_json *json, const char *name, bool any, const double low[3], const double high[3]) {
  if (!any) {
    hc_json_null(json, name);
    return;
  }
  hc_json_object(json, name, HC_JSON_DENSE);
  hc_json_numbers(json, "low", 3, low);
  hc_json_numbers(json, "high", 3, high);
  hc_json_end(json);
}
