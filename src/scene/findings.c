#include "findings.h"

#include "base/check.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

static hc_place place_of(const hc_given *given, const char *path) {
  const char *bracket = strchr(path, '[');
  if (!bracket) return *path ? hc_given_place_of(given, path) : given->place;
  char list[HC_PARAM_PATH], *end = NULL;
  snprintf(list, sizeof list, "%.*s", (int)(bracket - path), path);
  const hc_given_value *value = hc_given_value_of(given, list);
  const long index = strtol(bracket + 1, &end, 10);
  HC_CHECK(index >= 0 && index < value->item_count && *end == ']', "a scene has no '%s'", path);
  return place_of(&value->items[index], end[1] == '.' ? end + 2 : end + 1);
}

static void add(hc_complaints *complaints, hc_place place, const char *format, va_list arguments) {
  char text[HC_COMPLAINT_TEXT];
  vsnprintf(text, sizeof text, format, arguments);
  hc_complaints_add(complaints, place, "%s", text);
}

void hc_findings_error(hc_findings *findings, const char *path, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  add(findings->errors, place_of(findings->given, path), format, arguments);
  va_end(arguments);
}

void hc_findings_warning(hc_findings *findings, const char *path, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  add(findings->warnings, place_of(findings->given, path), format, arguments);
  va_end(arguments);
}
