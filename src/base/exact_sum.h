/* Exact sums: a double-precision sum that does not depend on the order of its terms.
 *
 * A sum is a long integer in 32-bit limbs, each in an int64_t so that carries may wait (Kulisch's
 * accumulator). Adding a term, adding two sums limb by limb, in whatever order, gives the same integer; only
 * reading it rounds, once. Infinities and NaNs are counted and make the value NaN. */
#ifndef HC_EXACT_SUM_H
#define HC_EXACT_SUM_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Bit 0 of limb 0 weighs 2^-1074 (the smallest double); the largest double ends in limb 65; one more for
 * carries. */
enum { HC_SUM_LIMBS = 68, HC_SUM_NOT_FINITE = HC_SUM_LIMBS, HC_SUM_WORDS = HC_SUM_LIMBS + 1 };

typedef struct hc_sum {
  int64_t word[HC_SUM_WORDS]; /* limbs, then the count of terms that were not finite */
} hc_sum;

/* Adds a term. Up to 2^30 terms between two calls of hc_sum_carry. */
static inline void hc_sum_add(hc_sum *sum, double term) {
  uint64_t bits;
  memcpy(&bits, &term, sizeof bits);
  const unsigned exponent = (unsigned)(bits >> 52) & 0x7ff;
  if (__builtin_expect(exponent == 0x7ff, 0)) {
    sum->word[HC_SUM_NOT_FINITE]++;
    return;
  }
  const uint64_t fraction = bits & 0xfffffffffffffULL;
  const uint64_t mantissa = exponent ? fraction | 1ULL << 52 : fraction;
  const unsigned place = exponent ? exponent - 1 : 0;
  const unsigned limb = place >> 5, shift = place & 31;
  const unsigned __int128 wide = (unsigned __int128)mantissa << shift;
  const int64_t sign = -(int64_t)(bits >> 63);
  const int64_t low = (int64_t)((uint64_t)wide & 0xffffffff), middle = (int64_t)((uint64_t)wide >> 32),
                high = (int64_t)(wide >> 64);
  sum->word[limb] += (low ^ sign) - sign;
  sum->word[limb + 1] += (middle ^ sign) - sign;
  sum->word[limb + 2] += (high ^ sign) - sign;
}

/* Moves carries up, so that every limb but the last is in [0, 2^32): then 2^30 sums may be added word by
 * word. */
void hc_sum_carry(hc_sum *sum);

/* The nearest double (to within one unit in the last place, the same for the same integer). */
double hc_sum_value(const hc_sum *sum);

#endif
