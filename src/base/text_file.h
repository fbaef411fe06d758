/* Text files, read in one way whatever they hold: whole, with or without a byte order mark, with line ends of
 * any system, with blanks around a line. Local. */
#ifndef HC_TEXT_FILE_H
#define HC_TEXT_FILE_H

#include "halocline/error.h"

#include <locale.h>
#include <stdbool.h>
#include <stddef.h>

/* All bytes of a file into `*bytes`, zero-terminated beyond `*length`, freed with hc_free. HC_BAD_INPUT, with
 * the path: no such file, a folder, not readable, empty, or larger than `most` bytes; `what` it should be,
 * such as "a scene file". */
hc_status hc_file_load(const char *path, size_t most, const char *what, char **bytes, size_t *length,
                       hc_error *error);

/* Passes over the byte order mark of UTF-8. */
void hc_text_skip_mark(const char **text, size_t *length);

/* The lines of a text, one after the other. */
typedef struct hc_lines {
  const char *at, *end;
  char *line; /* a copy of the last */
  size_t room;
  int number; /* of the last, from 1 on */
  locale_t plain;
} hc_lines;

/* The text stays the caller's. Freed with hc_lines_free. HC_BAD_INPUT, with the path, if it is no text of
 * bytes, as UTF-16 is none. */
hc_status hc_lines_start(hc_lines *lines, const char *path, const char *text, size_t length, hc_error *error);
void hc_lines_free(hc_lines *lines);

/* The next line, without its end and the blanks around it, the caller's to change until the next call; null
 * behind the last. */
char *hc_lines_next(hc_lines *lines);

/* The next word of a line between blanks, from *at on, which moves behind it; null if there is none. */
char *hc_lines_word(char **at);

/* Is all of a word a finite number, with a decimal point whatever the locale? */
bool hc_lines_number(const hc_lines *lines, const char *word, double *number);

#endif
