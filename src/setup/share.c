#include "share.h"

/* floor(count part / size) without the product, which may exceed 64 bits. */
static int64_t share_start(int64_t count, int part, int size) {
  return count / size * part + count % size * part / size;
}

void hc_setup_share(int64_t count, int rank, int size, int64_t *first, int64_t *last) {
  *first = share_start(count, rank, size);
  *last = share_start(count, rank + 1, size);
}
