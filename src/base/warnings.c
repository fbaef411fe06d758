#include "warnings.h"

#include "memory.h"

#include <stdarg.h>
#include <stdio.h>

void hc_warnings_add(hc_warnings *warnings, const char *format, ...) {
  if (!warnings) return;
  enum { LONGEST = 4096 };
  char *text = hc_alloc(LONGEST, 1);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, LONGEST, format, arguments);
  va_end(arguments);
  const size_t count = (size_t)warnings->count;
  hc_reserve((void **)&warnings->text, &warnings->room, count + 1, count, sizeof *warnings->text);
  warnings->text[warnings->count++] = text;
}

void hc_warnings_print(const hc_warnings *warnings, int first) {
  for (int k = first; k < warnings->count; k++)
    fprintf(stderr, "halocline: warning: %s\n", warnings->text[k]);
}

void hc_warnings_free(hc_warnings *warnings) {
  for (int k = 0; k < warnings->count; k++) hc_free(warnings->text[k]);
  hc_free(warnings->text);
  *warnings = (hc_warnings){0};
}
