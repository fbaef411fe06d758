/* Sets of numbers as bits: k is bit k % 64 of word k / 64. */
#ifndef HC_BITS_H
#define HC_BITS_H

#include <stdbool.h>
#include <stdint.h>

static inline bool hc_bits_have(const uint64_t *bits, int32_t k) {
  return bits[k / 64] >> (k % 64) & 1;
}

static inline void hc_bits_add(uint64_t *bits, int32_t k) {
  bits[k / 64] |= (uint64_t)1 << (k % 64);
}

#endif
