#include "check.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static int process_rank = 0;
static void (*leave_program)(int exit_code) = NULL;

/* Memory for ending other processes, which takes some: given back before. */
enum { KEPT = 1 << 20 };
static void *kept = NULL;

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

void hc_check_set_leave(void (*leave)(int exit_code)) {
  leave_program = leave;
  free(kept);
  kept = leave ? malloc(KEPT) : NULL; /* without it, leaving may have to do with what there is */
}

void hc_check_give_up(int exit_code, const char *format, ...) {
  free(kept);
  kept = NULL;
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  fflush(NULL);
  fprintf(stderr, "halocline: error: rank %d: %s\n", process_rank, text);
  fflush(stderr);
  if (leave_program) leave_program(exit_code);
  _exit(exit_code);
}
