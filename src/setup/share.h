/* How things are shared out among ranks. Local. */
#ifndef HC_SHARE_H
#define HC_SHARE_H

#include <stdint.h>

/* The range [first, last) of `count` things that falls to a rank. */
void hc_setup_share(int64_t count, int rank, int size, int64_t *first, int64_t *last);

#endif
