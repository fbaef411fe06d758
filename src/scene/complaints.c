#include "complaints.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Characters of a source line that are shown, and how many of them stand before the place when it lies far
 * right. */
enum { SHOWN = 120, SHOWN_BEFORE = 80 };

void hc_complaints_add(hc_complaints *complaints, hc_place place, const char *format, ...) {
  if (complaints->total < HC_COMPLAINTS_MOST) {
    hc_complaint *added = &complaints->kept[complaints->total];
    added->place = place;
    added->sequence = complaints->total;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(added->text, sizeof added->text, format, arguments);
    va_end(arguments);
  }
  complaints->total++;
}

int hc_complaints_character(const char *text, size_t length) {
  const unsigned char *c = (const unsigned char *)text;
  if (c[0] < 0x80)
    return (c[0] < 0x20 && c[0] != '\t' && c[0] != '\n' && c[0] != '\r') || c[0] == 0x7f ? -1 : 1;
  const int bytes = c[0] < 0xc2 ? 0 : c[0] < 0xe0 ? 2 : c[0] < 0xf0 ? 3 : c[0] < 0xf5 ? 4 : 0;
  if (bytes == 0 || length < (size_t)bytes) return 0;
  for (int k = 1; k < bytes; k++)
    if ((c[k] & 0xc0) != 0x80) return 0;
  /* Longer than needed, surrogates, beyond Unicode. */
  if ((c[0] == 0xe0 && c[1] < 0xa0) || (c[0] == 0xed && c[1] > 0x9f) || (c[0] == 0xf0 && c[1] < 0x90) ||
      (c[0] == 0xf4 && c[1] > 0x8f))
    return 0;
  return c[0] == 0xc2 && c[1] < 0xa0 ? -1 : bytes;
}

static int compare(const void *left, const void *right) {
  const hc_complaint *a = left, *b = right;
  const int order_a = a->place.source->override, order_b = b->place.source->override;
  if (order_a != order_b) return order_a < order_b ? -1 : 1;
  if (a->place.line != b->place.line) return a->place.line < b->place.line ? -1 : 1;
  if (a->place.column != b->place.column) return a->place.column < b->place.column ? -1 : 1;
  return a->sequence < b->sequence ? -1 : 1;
}

/* The bytes of a line, without its end; false if the source has no such line. */
static bool find_line(const hc_source *source, int line, const char **start, size_t *length) {
  const char *at = source->text, *end = source->text + source->length;
  for (int k = 1; k < line; k++) {
    while (at < end && *at != '\n' && *at != '\r') at++;
    if (at == end) return false;
    at += at + 1 < end && at[0] == '\r' && at[1] == '\n' ? 2 : 1;
  }
  *start = at;
  while (at < end && *at != '\n' && *at != '\r') at++;
  *length = (size_t)(at - *start);
  return true;
}

/* The source line, cut around the place, and a caret under the place. */
static void show_line(hc_place place, char *text, size_t size) {
  const char *line = NULL;
  size_t length = 0;
  text[0] = '\0';
  if (!find_line(place.source, place.line, &line, &length) || length == 0) return;
  const int first = place.column > SHOWN - 10 ? place.column - SHOWN_BEFORE : 1;
  char shown[4 * SHOWN + 1], caret[SHOWN + 1];
  size_t shown_used = 0, caret_used = 0;
  int column = 1;
  for (size_t k = 0; k < length && column < first + SHOWN; column++) {
    const int found = hc_complaints_character(line + k, length - k);
    const size_t bytes = found > 0 ? (size_t)found : 1;
    if (column >= first) {
      if (found > 0)
        memcpy(shown + shown_used, line + k, bytes);
      else
        shown[shown_used] = '?';
      shown_used += bytes;
      /* A tab above stays a tab below. */
      if (column < place.column) caret[caret_used++] = line[k] == '\t' ? '\t' : ' ';
    }
    k += bytes;
  }
  shown[shown_used] = caret[caret_used] = '\0';
  snprintf(text, size, "\n%s\n%s^", shown, caret);
}

enum { ENTRY = 4096 };

/* One complaint with its place and, in a file, the line. */
static void write_entry(const hc_complaint *complaint, char entry[static ENTRY]) {
  const hc_place place = complaint->place;
  char line[5 * SHOWN + 8] = "";
  if (place.source->override || place.line == 0) {
    snprintf(entry, ENTRY, "%.1000s: %s", place.source->name, complaint->text);
    return;
  }
  show_line(place, line, sizeof line);
  snprintf(entry, ENTRY, "%.1000s:%d:%d: %s%s", place.source->name, place.line, place.column, complaint->text,
           line);
}

/* Returns how many are kept. */
static int sort(hc_complaints *complaints) {
  const int kept = complaints->total < HC_COMPLAINTS_MOST ? complaints->total : HC_COMPLAINTS_MOST;
  qsort(complaints->kept, (size_t)kept, sizeof complaints->kept[0], compare);
  return kept;
}

void hc_complaints_warn(hc_complaints *complaints, hc_warnings *warnings) {
  const int kept = sort(complaints);
  for (int k = 0; k < kept; k++) {
    char entry[ENTRY];
    write_entry(&complaints->kept[k], entry);
    hc_warnings_add(warnings, "%s", entry);
  }
  if (kept < complaints->total)
    hc_warnings_add(warnings, "and %d more warnings of this scene", complaints->total - kept);
}

void hc_complaints_text(hc_complaints *complaints, char *text, size_t size) {
  const int kept = sort(complaints);
  static const char more[] = "\nand more";
  size_t used = 0;
  int written = 0;
  text[0] = '\0';
  for (; written < kept; written++) {
    char entry[ENTRY];
    write_entry(&complaints->kept[written], entry);
    const size_t length = strlen(entry) + (used > 0);
    if (used + length + sizeof more > size) break;
    used += (size_t)snprintf(text + used, size - used, "%s%s", used ? "\n" : "", entry);
  }
  if (written < complaints->total) snprintf(text + used, size - used, "%s", more);
}
