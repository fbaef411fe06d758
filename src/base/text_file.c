#include "text_file.h"

#include "base/memory.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static const char blanks[] = " \t\r\n\v\f";

hc_status hc_file_load(const char *path, size_t most, const char *what, char **bytes, size_t *length,
                       hc_error *error) {
  *bytes = NULL;
  *length = 0;
  FILE *const file = fopen(path, "rb");
  if (!file) return hc_error_set(error, HC_BAD_INPUT, "%s: cannot be opened: %s", path, strerror(errno));
  struct stat status;
  if (fstat(fileno(file), &status) == 0 && S_ISDIR(status.st_mode)) {
    fclose(file);
    return hc_error_set(error, HC_BAD_INPUT, "%s: a folder, not %s", path, what);
  }
  char *read = NULL;
  size_t used = 0, room = 0;
  bool more = true;
  while (more && used <= most) { /* a pipe has no length to go by */
    hc_reserve((void **)&read, &room, 2 * used + 4096, used, 1);
    const size_t count = fread(read + used, 1, room - used - 1, file);
    more = count > 0;
    used += count;
  }
  const int failure = ferror(file) ? errno : 0;
  fclose(file);
  hc_status result = HC_OK;
  if (failure)
    result = hc_error_set(error, HC_BAD_INPUT, "%s: cannot be read: %s", path, strerror(failure));
  else if (used == 0)
    result = hc_error_set(error, HC_BAD_INPUT, "%s: the file is empty", path);
  else if (used > most)
    result = hc_error_set(error, HC_BAD_INPUT, "%s: larger than %zu MiB: not %s", path, most >> 20, what);
  if (result != HC_OK) {
    hc_free(read);
    return result;
  }
  read[used] = '\0';
  *bytes = read;
  *length = used;
  return HC_OK;
}

void hc_text_skip_mark(const char **text, size_t *length) {
  if (*length < 3 || memcmp(*text, "\xef\xbb\xbf", 3) != 0) return;
  *text += 3;
  *length -= 3;
}

hc_status hc_lines_start(hc_lines *lines, const char *path, const char *text, size_t length,
                         hc_error *error) {
  hc_text_skip_mark(&text, &length);
  *lines = (hc_lines){.at = text, .end = text + length};
  if (memchr(text, '\0', length))
    return hc_error_set(error, HC_BAD_INPUT,
                        "%s: must be a text in UTF-8, and has zeros in it (is it UTF-16?)", path);
  lines->plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  return HC_OK;
}

void hc_lines_free(hc_lines *lines) {
  if (lines->plain) freelocale(lines->plain);
  hc_free(lines->line);
  *lines = (hc_lines){.at = NULL};
}

char *hc_lines_next(hc_lines *lines) {
  if (lines->at >= lines->end) return NULL;
  const char *stop = lines->at;
  while (stop < lines->end && *stop != '\n' && *stop != '\r') stop++;
  const size_t length = (size_t)(stop - lines->at);
  hc_reserve((void **)&lines->line, &lines->room, length + 1, 0, 1);
  memcpy(lines->line, lines->at, length);
  lines->line[length] = '\0';
  lines->at = stop + 1;
  if (stop < lines->end && *stop == '\r' && lines->at < lines->end && *lines->at == '\n') lines->at++;
  lines->number++;
  char *line = lines->line + strspn(lines->line, blanks);
  size_t left = strlen(line);
  while (left > 0 && strchr(blanks, line[left - 1])) line[--left] = '\0';
  return line;
}

char *hc_lines_word(char **at) {
  char *word = *at + strspn(*at, blanks);
  if (!*word) return NULL;
  char *end = word + strcspn(word, blanks);
  *at = *end ? end + 1 : end;
  *end = '\0';
  return word;
}

bool hc_lines_number(const hc_lines *lines, const char *word, double *number) {
  char *end;
  *number = strtod_l(word, &end, lines->plain);
  return end != word && !*end && isfinite(*number);
}
