/* The limit of memory that a container or a batch job puts on its processes: Linux's control groups. Local.
 */
#ifndef HC_CGROUP_H
#define HC_CGROUP_H

#include <stddef.h>

typedef struct hc_cgroup_limit {
  size_t bytes; /* SIZE_MAX: there is none */
  int group;    /* not negative; the same for processes of a machine that share this limit */
} hc_cgroup_limit;

/* The lowest limit of the groups of this process, from its own up to the root, of version 2 or 1. `root`:
 * where proc and sys are, "" but for tests. */
hc_cgroup_limit hc_cgroup_memory(const char *root);

#endif
