#include "cgroup.h"

#include <inttypes.h>
#include <limits.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { PATH_ROOM = 2 * PATH_MAX };

/* FNV-1a, of Fowler, Noll and Vo; names a group by its path. */
static int number_of(const char *path) {
  uint32_t hash = 2166136261u;
  for (; *path; path++) hash = (hash ^ (unsigned char)*path) * 16777619u;
  return (int)(hash & INT_MAX);
}

/* No number ("max"): no limit. */
static size_t read_limit(const char *path) {
  FILE *file = fopen(path, "r");
  uint64_t bytes = 0;
  const bool limited = file && fscanf(file, "%" SCNu64, &bytes) == 1 && bytes < SIZE_MAX;
  if (file) fclose(file);
  return limited ? (size_t)bytes : SIZE_MAX;
}

/* Groups that are not there are passed over: within a container the path may be the machine's, and the mount
 * begins at the container's group. */
static void look_upward(const char *mount, char *group, const char *name, hc_cgroup_limit *limit) {
  char path[PATH_ROOM];
  for (;;) {
    const int length = snprintf(path, sizeof path, "%s%s/%s", mount, group, name);
    const size_t bytes = length < (int)sizeof path ? read_limit(path) : SIZE_MAX;
    if (bytes < limit->bytes) *limit = (hc_cgroup_limit){bytes, number_of(group)};
    char *last = strrchr(group, '/');
    if (!last) return;
    *last = '\0';
  }
}

/* Is "memory" one of these words between commas? */
static bool has_memory(char *controllers) {
  char *rest = NULL;
  for (char *word = strtok_r(controllers, ",", &rest); word; word = strtok_r(NULL, ",", &rest))
    if (strcmp(word, "memory") == 0) return true;
  return false;
}

/* A line is HIERARCHY:CONTROLLERS:GROUP; version 2 has no controllers there. */
hc_cgroup_limit hc_cgroup_memory(const char *root) {
  hc_cgroup_limit limit = {SIZE_MAX, 0};
  char path[PATH_ROOM], line[PATH_MAX];
  snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
  FILE *file = fopen(path, "r");
  while (file && fgets(line, sizeof line, file)) {
    line[strcspn(line, "\n")] = '\0';
    char *controllers = strchr(line, ':');
    char *group = controllers ? strchr(controllers + 1, ':') : NULL;
    if (!group) continue;
    *group++ = '\0';
    const bool second = *++controllers == '\0';
    if (!second && !has_memory(controllers)) continue;
    snprintf(path, sizeof path, "%s/sys/fs/cgroup%s", root, second ? "" : "/memory");
    look_upward(path, group, second ? "memory.max" : "memory.limit_in_bytes", &limit);
  }
  if (file) fclose(file);
  return limit;
}
