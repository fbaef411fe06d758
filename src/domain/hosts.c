#include "hosts.h"

#include "base/memory.h"

#include <string.h>

void hc_hosts_make(hc_hosts *hosts, const int32_t *host, int ranks) {
  *hosts = (hc_hosts){.of = hc_alloc((size_t)ranks, sizeof *hosts->of),
                      .size = hc_alloc_zero((size_t)ranks, sizeof *hosts->size),
                      .order = hc_alloc((size_t)ranks, sizeof *hosts->order)};
  int32_t largest = 0;
  for (int r = 0; r < ranks; r++)
    if (host[r] > largest) largest = host[r];
  int32_t *number = hc_alloc((size_t)largest + 1, sizeof *number);
  memset(number, -1, ((size_t)largest + 1) * sizeof *number);
  for (int r = 0; r < ranks; r++) {
    if (number[host[r]] < 0) number[host[r]] = hosts->count++;
    hosts->of[r] = number[host[r]];
    hosts->size[hosts->of[r]]++;
  }
  hc_free(number);
  int32_t placed = 0;
  for (int32_t h = 0; h < hosts->count; h++)
    for (int32_t r = 0, left = hosts->size[h]; left > 0; r++) {
      if (hosts->of[r] != h) continue;
      hosts->order[placed++] = r;
      left--;
    }
}

void hc_hosts_find(hc_hosts *hosts, hc_comm *comm, int together) {
  const int32_t mine = together > 0 ? comm->rank / together : hc_comm_machine_first(comm);
  int32_t *all = NULL;
  size_t bytes;
  hc_comm_gather_all(comm, &mine, sizeof mine, (void **)&all, &bytes);
  hc_hosts_make(hosts, all, comm->size);
  hc_free(all);
}

void hc_hosts_free(hc_hosts *hosts) {
  hc_free(hosts->of);
  hc_free(hosts->size);
  hc_free(hosts->order);
  *hosts = (hc_hosts){0};
}
