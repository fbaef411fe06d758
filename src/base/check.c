#include "check.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

static int process_rank = 0;

void hc_check_set_rank(int rank) {
  process_rank = rank;
}

void hc_check_failed(const char *file, int line, const char *format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  fflush(stdout);
  fprintf(stderr, "halocline: rank %d: %s:%d: %s\n", process_rank, file, line, text);
  fflush(stderr);
  abort();
}
