#include "nearest.h"

#include <limits.h>
#include <string.h>

static int least(int a, int b) {
  return a < b ? a : b;
}

/* Edits (insert, delete, replace, swap of neighbours) that turn `a` into `b`: optimal string alignment. */
static int edit_distance(const char *a, const char *b) {
  enum { LONGEST = 63 };
  const int na = (int)strnlen(a, LONGEST + 1), nb = (int)strnlen(b, LONGEST + 1);
  if (na > LONGEST || nb > LONGEST) return INT_MAX;
  int row[3][LONGEST + 1]; /* the last three rows of the matrix of prefixes */
  for (int j = 0; j <= nb; j++) row[0][j] = j;
  for (int i = 1; i <= na; i++) {
    int *now = row[i % 3];
    const int *before = row[(i + 2) % 3], *before_that = row[(i + 1) % 3];
    now[0] = i;
    for (int j = 1; j <= nb; j++) {
      const int replace = before[j - 1] + (a[i - 1] != b[j - 1]);
      now[j] = least(replace, least(before[j], now[j - 1]) + 1);
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = least(now[j], before_that[j - 2] + 1);
    }
  }
  return row[na % 3][nb];
}

/* More edits than this and the suggestion would be a guess. */
static int edits_allowed(const char *name) {
  return 1 + (int)strlen(name) / 4;
}

const char *hc_nearest_name(const char *const *names, int count, const char *name) {
  const char *nearest = NULL;
  int fewest = edits_allowed(name) + 1;
  for (int k = 0; k < count; k++) {
    const int edits = edit_distance(name, names[k]);
    if (edits < fewest && edits < (int)strlen(names[k])) {
      fewest = edits;
      nearest = names[k];
    }
  }
  return nearest;
}

static const char *last_segment(const char *path) {
  const char *dot = strrchr(path, '.');
  return dot ? dot + 1 : path;
}

bool hc_nearest_key(const hc_param_table *table, const char *path, char nearest[static HC_PARAM_PATH]) {
  const char *last = last_segment(path);
  int fewest = edits_allowed(last) + 1;
  bool found = false;
  for (int k = 0; k < table->count; k++) {
    const hc_param *param = &table->params[k];
    if (param->hidden) continue;
    /* The key itself, and each map on the way to it. */
    for (const char *end = param->path; *end;) {
      end += 1 + strcspn(end + 1, ".");
      char known[HC_PARAM_PATH];
      const size_t length = (size_t)(end - param->path);
      memcpy(known, param->path, length);
      known[length] = '\0';
      int edits = edit_distance(path, known);
      /* The right name in the wrong map. */
      if (strcmp(last, last_segment(known)) == 0) edits = least(edits, 1);
      if (edits < fewest && edits < (int)strlen(last_segment(known))) {
        fewest = edits;
        strcpy(nearest, known);
        found = true;
      }
    }
  }
  return found;
}
