/* Exact sums: the same integer whatever the order, split and carries; read to within one unit in the last
 * place. */
#include "base/exact_sum.h"

#include <check.h>
#include <float.h>
#include <stdbool.h>
#include <stdlib.h>

/* Random bits: splitmix64. */
static uint64_t state;
static uint64_t next_bits(void) {
  uint64_t value = state += 0x9e3779b97f4a7c15;
  value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9;
  value = (value ^ value >> 27) * 0x94d049bb133111eb;
  return value ^ value >> 31;
}

/* A finite double of any sign and exponent, a denormal now and then. */
static double any_double(void) {
  uint64_t bits = next_bits();
  if ((bits >> 52 & 0x7ff) == 0x7ff) bits ^= (uint64_t)0x400 << 52;
  if (next_bits() % 16 == 0) bits &= 0x800fffffffffffffULL;
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static void shuffle(double *terms, int count) {
  for (int k = count - 1; k > 0; k--) {
    const int other = (int)(next_bits() % (uint64_t)(k + 1));
    const double moved = terms[k];
    terms[k] = terms[other];
    terms[other] = moved;
  }
}

static hc_sum sum_of(const double *terms, int count) {
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  for (int k = 0; k < count; k++) hc_sum_add(&sum, terms[k]);
  return sum;
}

static void merge(hc_sum *sum, const hc_sum *part) {
  for (int k = 0; k < HC_SUM_WORDS; k++) sum->word[k] += part->word[k];
}

/* The sum as several ranks would make it: in pieces, some of them carried before they are added. */
static hc_sum sum_in_pieces(const double *terms, int count) {
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  for (int k = 0; k < count;) {
    const int left = count - k, length = (int)(next_bits() % (uint64_t)(left < 300 ? left + 1 : 300));
    hc_sum part = sum_of(terms + k, length);
    if (next_bits() & 1) hc_sum_carry(&part);
    merge(&sum, &part);
    if (next_bits() & 1) hc_sum_carry(&sum);
    k += length;
  }
  return sum;
}

static bool words_equal(const hc_sum *a, const hc_sum *b) {
  return memcmp(a->word, b->word, sizeof a->word) == 0;
}

static bool same_double(double a, double b) {
  return memcmp(&a, &b, sizeof a) == 0;
}

START_TEST(order_and_splits_make_no_difference) {
  enum { TERMS = 2000 };
  double terms[TERMS];
  state = 1;
  for (int round = 0; round < 20; round++) {
    for (int k = 0; k < TERMS; k++) terms[k] = any_double();
    hc_sum whole = sum_of(terms, TERMS);
    const double open = hc_sum_value(&whole);
    hc_sum_carry(&whole);
    ck_assert(same_double(hc_sum_value(&whole), open)); /* reading needs no carry */
    for (int order = 0; order < 10; order++) {
      shuffle(terms, TERMS);
      hc_sum pieces = sum_in_pieces(terms, TERMS);
      ck_assert(same_double(hc_sum_value(&pieces), open));
      hc_sum_carry(&pieces);
      ck_assert(words_equal(&pieces, &whole));
    }
  }
}
END_TEST

/* Every term meets its negative; one is left over. */
START_TEST(what_cancels_leaves_nothing_behind) {
  enum { PAIRS = 500, TERMS = 2 * PAIRS + 1 };
  double terms[TERMS];
  state = 2;
  for (int round = 0; round < 200; round++) {
    for (int k = 0; k < PAIRS; k++) {
      terms[2 * k] = any_double();
      terms[2 * k + 1] = -terms[2 * k];
    }
    const double left = round == 0 ? 0.0 : round == 1 ? DBL_MAX : round == 2 ? -0x1p-1074 : any_double();
    terms[TERMS - 1] = left;
    shuffle(terms, TERMS);
    hc_sum sum = sum_of(terms, TERMS);
    ck_assert(hc_sum_value(&sum) == left);
    hc_sum_carry(&sum);
    hc_sum alone = sum_of(&left, 1);
    hc_sum_carry(&alone);
    ck_assert(words_equal(&sum, &alone));
  }
}
END_TEST

START_TEST(smallest_and_largest_numbers_are_exact) {
  const double cases[] = {0.0,           0x1p-1074,
                          -0x1p-1074,    0x1p-1022,
                          -0x1p-1022,    0x0.fffffffffffffp-1022,
                          0x1p-1021,     DBL_MAX,
                          -DBL_MAX,      1.0,
                          -1.0,          0x1.fffffffffffffp-1000,
                          0x1p-1074 * 3, 0x1.fffffffffffffp31};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    const hc_sum sum = sum_of(&cases[k], 1);
    ck_assert(hc_sum_value(&sum) == cases[k]);
  }
  const double tiny[] = {0x1p-1074, 0x1p-1022, -0x1p-1073}; /* denormal + normal - denormal */
  const hc_sum small = sum_of(tiny, 3);
  ck_assert(hc_sum_value(&small) == 0x1p-1022 - 0x1p-1074);
  const double lost[] = {1e300, 1.0, 0x1p-1074, -1e300, -1.0}; /* plain addition loses all but the end */
  const hc_sum kept = sum_of(lost, 5);
  ck_assert(hc_sum_value(&kept) == 0x1p-1074);
  const double much[] = {DBL_MAX, DBL_MAX, -DBL_MAX};
  hc_sum back = sum_of(much, 3);
  ck_assert(hc_sum_value(&back) == DBL_MAX);
  back = sum_of(much, 2);
  ck_assert(hc_sum_value(&back) == INFINITY);
}
END_TEST

/* A double's neighbours are one unit in the last place away. */
static bool within_one_unit(double value, double exact) {
  return value == exact || value == nextafter(exact, INFINITY) || value == nextafter(exact, -INFINITY);
}

/* Integers of 53 bits times powers of two: their sum is known exactly, and may be put anywhere in the range.
 */
START_TEST(value_is_within_one_unit_in_the_last_place) {
  enum { TERMS = 3000 };
  static const int places[] = {-1074, -1063, -1000, -700, -33, -32, -31, 0, 1, 500, 850};
  state = 3;
  for (int round = 0; round < 220; round++) {
    const int place = places[round % 11], terms = round < 110 ? TERMS : 1 + round % 7;
    __int128 exact = 0;
    hc_sum sum;
    memset(&sum, 0, sizeof sum);
    for (int k = 0; k < terms; k++) {
      const int64_t integer = (int64_t)next_bits() >> 11;
      const int shift = (int)(next_bits() % 51);
      exact += (__int128)integer * ((__int128)1 << shift);
      hc_sum_add(&sum, ldexp((double)integer, shift + place));
    }
    if (round % 3 == 0 && exact > 0) { /* totals below zero too */
      for (int k = 0; k < HC_SUM_LIMBS; k++) sum.word[k] = -sum.word[k];
      exact = -exact;
    }
    const double nearest = ldexp((double)exact, place); /* the conversion rounds to nearest */
    ck_assert_msg(within_one_unit(hc_sum_value(&sum), nearest), "%.17g is not %.17g", hc_sum_value(&sum),
                  nearest);
  }
}
END_TEST

START_TEST(tame_data_agree_with_compensated_sums) {
  enum { TERMS = 10000 };
  state = 4;
  for (int round = 0; round < 20; round++) {
    hc_sum sum;
    memset(&sum, 0, sizeof sum);
    long double total = 0, lost = 0, magnitude = 0; /* Kahan */
    for (int k = 0; k < TERMS; k++) {
      const double term = (double)(int64_t)next_bits() * 0x1p-63 * (round - 10);
      hc_sum_add(&sum, term);
      magnitude += fabsl(term);
      const long double corrected = term - lost, after = total + corrected;
      lost = (after - total) - corrected;
      total = after;
    }
    const double value = hc_sum_value(&sum);
    ck_assert_msg(fabsl(value - total) <= DBL_EPSILON * fabsl(total) + 1e-18L * magnitude, "%.17g, %.17Lg",
                  value, total);
  }
}
END_TEST

START_TEST(totals_may_be_negative) {
  const double terms[] = {-3.5, 1.25, -0x1p-60, 0x1p40, -0x1p41};
  hc_sum sum = sum_of(terms, 5);
  ck_assert(hc_sum_value(&sum) == -0x1p40 - 2.25);
  hc_sum_carry(&sum);
  for (int k = 0; k < HC_SUM_LIMBS - 1; k++) ck_assert(sum.word[k] >= 0 && sum.word[k] <= 0xffffffff);
  ck_assert(sum.word[HC_SUM_LIMBS - 1] < 0);
  ck_assert(hc_sum_value(&sum) == -0x1p40 - 2.25);
  hc_sum positive = sum_of((const double[]){0x1p40 + 2.25, 0x1p-60}, 2);
  merge(&positive, &sum);
  ck_assert(hc_sum_value(&positive) == 0.0);
  hc_sum_carry(&positive);
  for (int k = 0; k < HC_SUM_WORDS; k++) ck_assert_int_eq(positive.word[k], 0);
}
END_TEST

START_TEST(what_is_not_finite_is_flagged) {
  static const double bad[] = {NAN, INFINITY, -INFINITY};
  for (int k = 0; k < 3; k++) {
    const double terms[] = {1.0, bad[k], -1.0};
    hc_sum sum = sum_of(terms, 3);
    ck_assert(isnan(hc_sum_value(&sum)));
    ck_assert_int_eq(sum.word[HC_SUM_NOT_FINITE], 1);
    hc_sum_carry(&sum);
    ck_assert_int_eq(sum.word[HC_SUM_NOT_FINITE], 1);
    hc_sum good = sum_of(terms, 1);
    ck_assert(hc_sum_value(&good) == 1.0);
    merge(&good, &sum);
    ck_assert(isnan(hc_sum_value(&good)));
  }
  const hc_sum all = sum_of(bad, 3); /* infinities do not cancel */
  ck_assert(isnan(hc_sum_value(&all)));
  ck_assert_int_eq(all.word[HC_SUM_NOT_FINITE], 3);
}
END_TEST

START_TEST(a_million_terms_carry) {
  enum { TERMS = 1000000 };
  static const double terms[] = {0.1, -0.1, 0x1.fffffffffffffp200, -0x1.fffffffffffffp-1000, 1e308};
  for (int t = 0; t < 5; t++) {
    hc_sum sum;
    memset(&sum, 0, sizeof sum);
    for (int k = 0; k < TERMS; k++) hc_sum_add(&sum, terms[t]);
    int exponent;
    const __int128 mantissa = (__int128)ldexp(frexp(terms[t], &exponent), 53) * TERMS;
    const double nearest = ldexp((double)mantissa, exponent - 53);
    ck_assert(within_one_unit(hc_sum_value(&sum), nearest));
    hc_sum_carry(&sum);
    for (int k = 0; k < HC_SUM_LIMBS - 1; k++) ck_assert(sum.word[k] >= 0 && sum.word[k] <= 0xffffffff);
    ck_assert(within_one_unit(hc_sum_value(&sum), nearest));
  }
}
END_TEST

/* What 2^30 equal terms, or 2^30 carried sums, amount to in the words, without adding that often. */
START_TEST(carries_may_wait_as_long_as_promised) {
  state = 5;
  for (int round = 0; round < 1000; round++) {
    double term = any_double();
    while (fabs(term) > 0x1p990) term = any_double();
    hc_sum sum = sum_of(&term, 1);
    for (int twice = 0; twice < 2; twice++) {
      const double before = hc_sum_value(&sum);
      for (int k = 0; k < HC_SUM_LIMBS; k++) {
        ck_assert(llabs(sum.word[k]) <= (int64_t)1 << 32);
        sum.word[k] *= (int64_t)1 << 30;
      }
      ck_assert(hc_sum_value(&sum) == ldexp(before, 30) || !isfinite(ldexp(before, 30)));
      hc_sum_carry(&sum);
    }
  }
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("exact_sum");
  TCase *const cases = tcase_create("sums");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, order_and_splits_make_no_difference);
  tcase_add_test(cases, what_cancels_leaves_nothing_behind);
  tcase_add_test(cases, smallest_and_largest_numbers_are_exact);
  tcase_add_test(cases, value_is_within_one_unit_in_the_last_place);
  tcase_add_test(cases, tame_data_agree_with_compensated_sums);
  tcase_add_test(cases, totals_may_be_negative);
  tcase_add_test(cases, what_is_not_finite_is_flagged);
  tcase_add_test(cases, a_million_terms_carry);
  tcase_add_test(cases, carries_may_wait_as_long_as_promised);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
