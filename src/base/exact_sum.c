#include "exact_sum.h"

void hc_sum_carry(hc_sum *sum) {
  int64_t carry = 0;
  for (int k = 0; k < HC_SUM_LIMBS - 1; k++) {
    const int64_t value = sum->word[k] + carry;
    carry = value >> 32;
    sum->word[k] = value & 0xffffffff;
  }
  sum->word[HC_SUM_LIMBS - 1] += carry;
}

double hc_sum_value(const hc_sum *sum) {
  if (sum->word[HC_SUM_NOT_FINITE]) return NAN;
  hc_sum magnitude = *sum;
  hc_sum_carry(&magnitude);
  const int negative = magnitude.word[HC_SUM_LIMBS - 1] < 0;
  if (negative) {
    for (int k = 0; k < HC_SUM_LIMBS; k++) magnitude.word[k] = -magnitude.word[k];
    hc_sum_carry(&magnitude);
  }
  int top = HC_SUM_LIMBS - 1;
  while (top > 0 && magnitude.word[top] == 0) top--;
  /* Three limbs hold at least 65 bits from the leading one on: more than a double keeps. */
  double value = 0.0;
  for (int k = top; k >= 0 && k > top - 3; k--) value += ldexp((double)magnitude.word[k], 32 * k - 1074);
  return negative ? -value : value;
}
