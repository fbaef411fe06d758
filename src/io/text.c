#include "text.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

const char *hc_text_number(char out[HC_TEXT_NUMBER], double value) {
  if (isnan(value)) {
    snprintf(out, HC_TEXT_NUMBER, "nan");
    return out;
  }
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(out, HC_TEXT_NUMBER, "%.*g", digits, value);
    if (strtod(out, NULL) == value) break;
  }
  return out;
}

const char *hc_text_json_number(char out[HC_TEXT_NUMBER], double value) {
  if (!isfinite(value)) {
    snprintf(out, HC_TEXT_NUMBER, "null");
    return out;
  }
  return hc_text_number(out, value);
}

void hc_text_json_string(FILE *stream, const char *text) {
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

static void put_list(FILE *stream, int count, const double *values) {
  char text[HC_TEXT_NUMBER];
  fputc('[', stream);
  for (int k = 0; k < count; k++) fprintf(stream, "%s%s", k ? "," : "", hc_text_json_number(text, values[k]));
  fputc(']', stream);
}

void hc_text_json_numbers(FILE *stream, const char *name, int count, const double *values) {
  char text[HC_TEXT_NUMBER];
  fprintf(stream, ",\"%s\":", name);
  if (count)
    put_list(stream, count, values);
  else
    fputs(hc_text_json_number(text, *values), stream);
}

void hc_text_json_extent(FILE *stream, const char *before, const char *name, bool any, const double low[3],
                         const double high[3]) {
  fprintf(stream, "%s\"%s\":", before, name);
  if (!any) {
    fputs("null", stream);
    return;
  }
  fputs("{\"low\":", stream);
  put_list(stream, 3, low);
  fputs(",\"high\":", stream);
  put_list(stream, 3, high);
  fputc('}', stream);
}

hc_status hc_text_path(char out[HC_TEXT_PATH], hc_error *error, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(out, HC_TEXT_PATH, format, arguments);
  va_end(arguments);
  if (length >= 0 && length < HC_TEXT_PATH) return HC_OK;
  return hc_error_set(error, HC_BAD_INPUT, "a path must have fewer than %d bytes, got %d: %.200s...",
                      HC_TEXT_PATH, length, out);
}
