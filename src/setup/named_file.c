#include "named_file.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

hc_status hc_named_file_find(const char *scene_name, const char *file, char path[static HC_FILE_LENGTH],
                             hc_error *error) {
  const char *const slash = strrchr(scene_name, '/');
  const int folder = slash && file[0] != '/' ? (int)(slash + 1 - scene_name) : 0;
  char joined[PATH_MAX + HC_FILE_LENGTH], whole[PATH_MAX];
  snprintf(joined, sizeof joined, "%.*s%s", folder < PATH_MAX ? folder : PATH_MAX, scene_name, file);
  const char *const found = realpath(joined, whole) ? whole : joined;
  if (strlen(found) >= HC_FILE_LENGTH)
    return hc_error_set(error, HC_BAD_INPUT, "%s: the path must be at most %d bytes long", found,
                        HC_FILE_LENGTH - 1);
  strcpy(path, found);
  return HC_OK;
}
