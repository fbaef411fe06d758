/* What is worth saying but does not fail: texts, collected where they arise and printed by the caller. */
#ifndef HC_WARNINGS_H
#define HC_WARNINGS_H

#include <stddef.h>

/* Zeroed: none yet. */
typedef struct hc_warnings {
  char **text; /* `count` texts without a newline at their ends; they may hold several lines */
  int count;
  size_t room;
} hc_warnings;

/* Appends a formatted text; does nothing if `warnings` is null, for callers whom nobody listens to. Local. */
void hc_warnings_add(hc_warnings *warnings, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Says "halocline: warning: TEXT" on stderr for each, from the one with index `first` on. Local. */
void hc_warnings_print(const hc_warnings *warnings, int first);

/* Frees the texts; none are left. */
void hc_warnings_free(hc_warnings *warnings);

#endif
