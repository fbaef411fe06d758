/* A set of bricks, numbered as they come in, found through a hash table; 20 to 28 bytes a brick. Local. */
#ifndef HC_BRICK_SET_H
#define HC_BRICK_SET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A brick's integer coordinates: cell coordinates >> HC_BRICK_BITS in cells.h, other shifts elsewhere. The
 * world ends where these do, 2^31 bricks from the origin. */
typedef struct hc_brick {
  int32_t x[3];
} hc_brick;

static inline bool hc_brick_equal(hc_brick a, hc_brick b) {
  return a.x[0] == b.x[0] && a.x[1] == b.x[1] && a.x[2] == b.x[2];
}

typedef struct hc_brick_set {
  hc_brick *bricks;
  int32_t count;
  size_t capacity;
  int32_t *table; /* open addressing: number or -1 */
  uint32_t mask;
  hc_brick low, high; /* of all bricks, where there are any */
} hc_brick_set;

void hc_brick_set_init(hc_brick_set *set);
void hc_brick_set_free(hc_brick_set *set);

/* Forgets all bricks, keeps the memory. */
void hc_brick_set_clear(hc_brick_set *set);

/* The brick's number, or -1; the second form gives a new brick the next number. */
int32_t hc_brick_set_find(const hc_brick_set *set, hc_brick brick);
int32_t hc_brick_set_add(hc_brick_set *set, hc_brick brick);

/* The numbers of the 27 bricks around `brick` and itself (x fastest), -1 where there is none; false if all
 * are. */
enum { HC_ADJACENT = 27, HC_ADJACENT_SELF = 13 };
bool hc_brick_set_around(const hc_brick_set *set, hc_brick brick, int32_t adjacent[HC_ADJACENT]);

#endif
