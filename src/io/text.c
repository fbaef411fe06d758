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

hc_status hc_text_path(char out[HC_TEXT_PATH], hc_error *error, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(out, HC_TEXT_PATH, format, arguments);
  va_end(arguments);
  if (length >= 0 && length < HC_TEXT_PATH) return HC_OK;
  return hc_error_set(error, HC_BAD_INPUT, "a path must have fewer than %d bytes, got %d: %.200s...",
                      HC_TEXT_PATH, length, out);
}
