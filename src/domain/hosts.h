/* Which ranks share a host: messages between them need no network. */
#ifndef HC_HOSTS_H
#define HC_HOSTS_H

#include "comm/comm.h"

typedef struct hc_hosts {
  int count;      /* of hosts */
  int32_t *of;    /* the host of each rank; numbered as their first ranks are */
  int32_t *size;  /* ranks of each host */
  int32_t *order; /* the ranks, host by host */
} hc_hosts;

/* From the host of each rank, in any numbers. Local. */
void hc_hosts_make(hc_hosts *hosts, const int32_t *host, int ranks);

/* As the machines say; or, for tests, as if so many ranks that follow each other shared one. Collective. */
void hc_hosts_find(hc_hosts *hosts, hc_comm *comm, int together);
void hc_hosts_free(hc_hosts *hosts);

#endif
