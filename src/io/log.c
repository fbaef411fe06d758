#include "log.h"

#include "base/timer.h"

#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <string.h>
#include <unistd.h>

enum { LINE = 4096 };

hc_status hc_log_open(hc_log *log, const char *directory, bool append, hc_error *error) {
  memset(log, 0, sizeof *log);
  const hc_status status = hc_text_path(log->path, error, "%s/run.log", directory);
  if (status != HC_OK) return status;
  log->file = fopen(log->path, append ? "a" : "w");
  if (!log->file) return hc_error_set(error, HC_IO_FAILED, "cannot write %s: %s", log->path, strerror(errno));
  setvbuf(log->file, NULL, _IOLBF, 0); /* a run that is killed leaves its last words */
  log->echo = stderr;
  log->start = hc_seconds();
  return HC_OK;
}

static void put_line(hc_log *log, const char *level, const char *text) {
  fprintf(log->file, "%10.3f %s ", hc_seconds() - log->start, level);
  for (const char *c = text; *c; c++) {
    fputc(*c, log->file);
    if (*c == '\n') fprintf(log->file, "%10s %s ", "", level);
  }
  fputc('\n', log->file);
}

/* FNV-1a of the format: equal formats are one kind, wherever the compiler keeps them. */
static bool first_of_kind(hc_log *log, const char *format) {
  uint64_t hash = 0xcbf29ce484222325;
  for (const char *c = format; *c; c++) hash = (hash ^ (unsigned char)*c) * 0x100000001b3;
  for (int k = 0; k < log->shown_count; k++)
    if (log->shown[k] == hash) return false;
  if (log->shown_count == HC_LOG_KINDS) return false;
  log->shown[log->shown_count++] = hash;
  return true;
}

void hc_log_info(hc_log *log, const char *format, ...) {
  if (!log->file) return;
  char text[LINE];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  put_line(log, "info", text);
}

static void warn(hc_log *log, const char *format, const char *text) {
  put_line(log, "warning", text);
  if (!log->echo || !first_of_kind(log, format)) return;
  const bool terminal = isatty(fileno(log->echo)) != 0;
  /* On a terminal a progress line may stand there: clear it. */
  fprintf(log->echo, "%shalocline: warning: %s\n", terminal ? "\r\033[K" : "", text);
  fflush(log->echo);
}

void hc_log_warn(hc_log *log, const char *format, ...) {
  if (!log->file) return;
  char text[LINE];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  warn(log, format, text);
}

enum { TOLD = 10 }; /* warnings of a kind, before only powers of ten are */

static bool is_told(int64_t number) {
  if (number <= TOLD) return true;
  while (number % 10 == 0) number /= 10;
  return number == 1;
}

void hc_log_warn_counted(hc_log *log, int64_t number, const char *format, ...) {
  if (!log->file || !is_told(number)) return;
  char text[LINE];
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  const size_t used = length < LINE ? (size_t)length : sizeof text - 1;
  if (number == TOLD)
    snprintf(text + used, sizeof text - used, "; further ones are counted, and told at 100, 1000 and so on");
  if (number > TOLD) snprintf(text + used, sizeof text - used, "; the %lldth of its kind", (long long)number);
  warn(log, format, text);
}

hc_status hc_log_close(hc_log *log, hc_error *error) {
  if (!log->file) return HC_OK;
  errno = 0;
  const bool broken = ferror(log->file) != 0, closed = fclose(log->file) == 0;
  const int reason = errno ? errno : EIO;
  log->file = NULL;
  if (closed && !broken) return HC_OK;
  return hc_error_set(error, HC_IO_FAILED, "cannot write %s: %s", log->path, strerror(reason));
}
