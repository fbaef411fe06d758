/* A set of ownership bricks, numbered as they come in: what a decomposition counts and searches with. 20 to
 * 28 bytes a brick. Local. */
#ifndef HC_BRICK_SET_H
#define HC_BRICK_SET_H

#include "space/cells.h"

typedef struct hc_brick_set {
  hc_brick *bricks;
  int32_t count;
  size_t capacity;
  int32_t *table; /* open addressing: number or -1 */
  uint32_t mask;
} hc_brick_set;

void hc_brick_set_init(hc_brick_set *set);
void hc_brick_set_free(hc_brick_set *set);

/* The brick's number, or -1; the second form gives a new brick the next number. */
int32_t hc_brick_set_find(const hc_brick_set *set, hc_brick brick);
int32_t hc_brick_set_add(hc_brick_set *set, hc_brick brick);

#endif
