#include "halocline/error.h"

#include <stdarg.h>
#include <stdio.h>

hc_status hc_error_set(hc_error *error, hc_status status, const char *format, ...) {
  if (error) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    error->status = status;
  }
  return status;
}
