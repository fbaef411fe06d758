/* Work that several processes divide among each other, each with a part of it: how geometry asks for the
 * others' without knowing how they talk. */
#ifndef HC_PARTS_H
#define HC_PARTS_H

#include "base/memory.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct hc_parts {
  int part, count; /* which of how many */
  void *context;
  /* Everybody's blocks one after the other, in the order of the parts, with what is ours among them; to be
   * freed with hc_free. Collective over the parts. */
  void (*gather)(void *context, const void *mine, size_t bytes, void **all, size_t *total);
} hc_parts;

/* All of it is ours. */
static const hc_parts hc_parts_alone = {0, 1, NULL, NULL};

/* floor(count part / parts) without the product, which may exceed 64 bits. */
static inline int64_t hc_parts_start(int64_t count, int part, int parts) {
  return count / parts * part + count % parts * part / parts;
}

/* The range [first, last) of `count` things that falls to us. Local. */
static inline void hc_parts_share(const hc_parts *parts, int64_t count, int64_t *first, int64_t *last) {
  *first = hc_parts_start(count, parts->part, parts->count);
  *last = hc_parts_start(count, parts->part + 1, parts->count);
}

/* Replaces `*mine`, `*count` things of `size` bytes, by those of all. */
static inline void hc_parts_gather(const hc_parts *parts, void **mine, size_t *count, size_t size) {
  if (parts->count == 1) return;
  void *all;
  size_t bytes;
  parts->gather(parts->context, *mine, *count * size, &all, &bytes);
  hc_free(*mine);
  *mine = all;
  *count = bytes / size;
}

#endif
