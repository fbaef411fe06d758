/* Tallies: many sums and maxima in one reduction, against what every rank works out alone. */
#include "mpi_test.h"

#include "comm/tally.h"

#include <math.h>
#include <string.h>

/* What rank r brings: any bits of sign, size, zeros of both signs. */
static int64_t integer_of(uint64_t r, uint64_t k) {
  return (int64_t)mix(977 * r + k);
}

static double number_of(uint64_t r, uint64_t k) {
  const uint64_t bits = mix(31 * r + 7 * k);
  if (bits % 5 == 0) return bits & 64 ? 0.0 : -0.0;
  return ldexp((double)(int64_t)bits, (int)(bits % 200) - 150);
}

enum { VALUES = 5, SUMS = 11 };

/* All kinds, several times, of several counts. */
typedef struct bundle {
  int64_t sum[VALUES], one, most[VALUES];
  double largest[VALUES], last;
  hc_sum exact[SUMS];
} bundle;

static void fill(bundle *b, uint64_t seed, uint64_t rank) {
  memset(b, 0, sizeof *b);
  for (uint64_t k = 0; k < VALUES; k++) {
    b->sum[k] = integer_of(rank, seed + k) >> 4;
    b->most[k] = integer_of(rank, seed + 2 * k);
    b->largest[k] = number_of(rank, seed + k);
  }
  b->one = (int64_t)rank;
  b->last = -(double)rank;
  for (uint64_t k = 0; k < SUMS; k++)
    for (uint64_t term = 0; term < 3; term++) hc_sum_add(&b->exact[k], number_of(rank, seed + 3 * k + term));
}

static bool above(double a, double b) {
  return a > b || (a == b && signbit(b) && !signbit(a));
}

/* Adds rank's bundle to `all`. */
static void join(bundle *all, const bundle *b) {
  for (int k = 0; k < VALUES; k++) {
    all->sum[k] += b->sum[k];
    if (b->most[k] > all->most[k]) all->most[k] = b->most[k];
    if (above(b->largest[k], all->largest[k])) all->largest[k] = b->largest[k];
  }
  all->one += b->one;
  if (b->last > all->last) all->last = b->last;
  for (int k = 0; k < SUMS; k++)
    for (int w = 0; w < HC_SUM_WORDS; w++) all->exact[k].word[w] += b->exact[k].word[w];
}

static void carry(bundle *b) {
  for (int k = 0; k < SUMS; k++) hc_sum_carry(&b->exact[k]);
}

START_TEST(a_tally_is_what_ranks_work_out_alone) {
  bool good = true;
  for (uint64_t seed = 0; seed < 50; seed++) {
    bundle mine, all;
    fill(&all, seed, 0);
    for (int rank = 1; rank < comm.size; rank++) {
      fill(&mine, seed, (uint64_t)rank);
      join(&all, &mine);
    }
    fill(&mine, seed, (uint64_t)comm.rank);
    hc_tally tally = {.count = 0};
    hc_tally_max_f64(&tally, mine.largest, VALUES);
    hc_tally_sum_i64(&tally, mine.sum, VALUES);
    hc_tally_max_i64(&tally, mine.most, VALUES);
    hc_tally_sum_exact(&tally, mine.exact, SUMS);
    hc_tally_sum_i64(&tally, &mine.one, 1);
    hc_tally_max_f64(&tally, &mine.last, 1);
    hc_tally_max_f64(&tally, NULL, 0);
    hc_tally_reduce(&comm, &tally);
    carry(&mine);
    carry(&all);
    good &= tally.count == 0 && memcmp(&mine, &all, sizeof all) == 0;
  }
  EXPECT(good);
}
END_TEST

START_TEST(extremes_are_kept) {
  const bool odd = comm.rank == comm.size - 1;
  double values[3] = {odd ? INFINITY : 1e308, odd ? -INFINITY : -1e308, -INFINITY};
  int64_t most[2] = {INT64_MIN, odd ? INT64_MAX : INT64_MIN};
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  hc_sum_add(&sum, odd ? NAN : 1.0);
  hc_tally tally = {.count = 0};
  hc_tally_max_f64(&tally, values, 3);
  hc_tally_max_i64(&tally, most, 2);
  hc_tally_sum_exact(&tally, &sum, 1);
  hc_tally_reduce(&comm, &tally);
  EXPECT(values[0] == INFINITY && values[1] == (comm.size > 1 ? -1e308 : -INFINITY));
  EXPECT(values[2] == -INFINITY);
  EXPECT(most[0] == INT64_MIN && most[1] == INT64_MAX && isnan(hc_sum_value(&sum)));
}
END_TEST

START_TEST(a_tally_is_one_reduction) {
  const int64_t before = comm.reductions;
  bundle b;
  fill(&b, 3, (uint64_t)comm.rank);
  hc_tally tally = {.count = 0};
  hc_tally_reduce(&comm, &tally);
  const int64_t none = comm.reductions - before;
  hc_tally_sum_exact(&tally, b.exact, SUMS);
  hc_tally_max_i64(&tally, b.most, VALUES);
  hc_tally_max_f64(&tally, b.largest, VALUES);
  hc_tally_reduce(&comm, &tally);
  const int64_t more = comm.reductions - before;
  EXPECT(none == 0 && more == (comm.size > 1));
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("tally");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, a_tally_is_what_ranks_work_out_alone);
  tcase_add_test(tests, extremes_are_kept);
  tcase_add_test(tests, a_tally_is_one_reduction);
  return run_mpi_tests("tally", tests);
}
