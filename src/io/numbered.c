#include "numbered.h"

#include "base/memory.h"
#include "text.h"

#include <dirent.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The number in a name, -1 if it is not one of these files. */
static int64_t number_of(const hc_numbered *files, const char *name, bool *temporary) {
  *temporary = *name == '.';
  name += *temporary;
  const size_t length = strlen(files->prefix);
  if (strncmp(name, files->prefix, length) != 0) return -1;
  name += length;
  const int64_t number = strtoll(name, NULL, 10);
  const size_t digits = strspn(name, "0123456789");
  name += digits;
  if (digits == 0 || strncmp(name, files->suffix, strlen(files->suffix)) != 0) return -1;
  return strcmp(name + strlen(files->suffix), *temporary ? ".tmp" : "") == 0 ? number : -1;
}

/* What is done with each file; an error ends the visit. */
typedef void visit(const hc_numbered *files, const char *name, int64_t number, bool temporary, void *context,
                   hc_error *problem);

static hc_status visit_all(const hc_numbered *files, visit *each, void *context, hc_error *error) {
  hc_error problem = {.status = HC_OK};
  DIR *list = opendir(files->folder);
  if (!list) {
    if (errno == ENOENT || errno == ENOTDIR) return HC_OK;
    return hc_error_set(error, HC_IO_FAILED, "cannot list %s: %s", files->folder, strerror(errno));
  }
  while (problem.status == HC_OK) {
    errno = 0;
    const struct dirent *item = readdir(list);
    if (!item && errno)
      hc_error_set(&problem, HC_IO_FAILED, "cannot list %s: %s", files->folder, strerror(errno));
    if (!item) break;
    bool temporary;
    const int64_t number = number_of(files, item->d_name, &temporary);
    if (number >= 0) each(files, item->d_name, number, temporary, context, &problem);
  }
  closedir(list);
  if (problem.status != HC_OK && error) *error = problem;
  return problem.status;
}

/* The numbers found so far. */
typedef struct found {
  int64_t *numbers;
  size_t count, capacity;
} found;

static void add(const hc_numbered *files, const char *name, int64_t number, bool temporary, void *context,
                hc_error *problem) {
  (void)files, (void)name, (void)problem;
  found *found = context;
  if (temporary) return;
  hc_reserve((void **)&found->numbers, &found->capacity, found->count + 1, found->count,
             sizeof *found->numbers);
  found->numbers[found->count++] = number;
}

static int descending(const void *a, const void *b) {
  const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
  return p > q ? -1 : p < q;
}

hc_status hc_numbered_list(const hc_numbered *files, int64_t **numbers, size_t *count, hc_error *error) {
  found found = {NULL, 0, 0};
  const hc_status status = visit_all(files, add, &found, error);
  if (status != HC_OK) {
    hc_free(found.numbers);
    found.numbers = NULL;
    found.count = 0;
  }
  if (found.count) qsort(found.numbers, found.count, sizeof *found.numbers, descending);
  *numbers = found.numbers;
  *count = found.count;
  return status;
}

static void remove_late(const hc_numbered *files, const char *name, int64_t number, bool temporary,
                        void *context, hc_error *problem) {
  (void)temporary;
  char path[HC_TEXT_PATH];
  if (number < *(const int64_t *)context ||
      hc_text_path(path, problem, "%s/%s", files->folder, name) != HC_OK)
    return;
  if (unlink(path) != 0 && errno != ENOENT)
    hc_error_set(problem, HC_IO_FAILED, "cannot remove %s of the old run: %s", path, strerror(errno));
}

hc_status hc_numbered_remove(const hc_numbered *files, int64_t from, hc_error *error) {
  return visit_all(files, remove_late, &from, error);
}
