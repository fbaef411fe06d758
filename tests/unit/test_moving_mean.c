/* The moving mean of gauges, against the mean of the same steps taken straight. */
#include "gauges/moving_mean.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = 2, STEPS = 3000 };

/* Steps one behind the other, and what was measured in each. */
typedef struct signal {
  double dt[STEPS], value[STEPS];
  int count;
} signal;

/* The mean over `time` before the end, or over all if that is less. */
static double straight_mean(const signal *signal, double time) {
  double sum = 0.0, left = time;
  for (int k = signal->count - 1; k >= 0 && left > 0.0; k--) {
    const double part = fmin(left, signal->dt[k]);
    sum += part * signal->value[k];
    left -= part;
  }
  return sum / (time - left);
}

static void take(hc_moving_mean *mean, signal *signal, double dt, double value) {
  signal->dt[signal->count] = dt;
  signal->value[signal->count++] = value;
  hc_moving_mean_add(mean, dt, (double[COLUMNS]){dt * value, -2.0 * dt * value});
}

static void expect_near(const hc_moving_mean *mean, double wanted, double most) {
  double found[COLUMNS];
  hc_moving_mean_read(mean, found);
  ck_assert_msg(fabs(found[0] - wanted) <= most, "the mean is %.17g, not %.17g", found[0], wanted);
  ck_assert_msg(fabs(found[1] + 2.0 * wanted) <= 2.0 * most, "the second column has %.17g", found[1]);
}

/* A random number in (0, 1). */
static double chance(void) {
  return (rand() + 0.5) / (RAND_MAX + 1.0);
}

START_TEST(it_is_the_mean_over_its_time) {
  const double lengths[] = {1e-3, 0.01, 0.02, 0.064, 0.5, 1.0, 4.0};
  for (size_t n = 0; n < sizeof lengths / sizeof *lengths; n++) {
    const double time = lengths[n];
    signal signal = {.count = 0};
    hc_moving_mean mean;
    hc_moving_mean_init(&mean, time, COLUMNS);
    expect_near(&mean, 0.0, 0.0);
    srand(7);
    for (int k = 0; k < 700; k++) { /* values of [-1, 1] */
      take(&mean, &signal, 0.01 * chance(), 2.0 * chance() - 1.0);
      if (k % 3 == 0) expect_near(&mean, straight_mean(&signal, time), 2.0 / 256 + 1e-9);
    }
    hc_moving_mean_free(&mean);
  }
}
END_TEST

START_TEST(steps_of_shares_are_exact) {
  signal signal = {.count = 0};
  hc_moving_mean mean;
  hc_moving_mean_init(&mean, 1.0, COLUMNS);
  for (int k = 0; k < 500; k++) { /* borders of shares are borders of steps, or within steps */
    take(&mean, &signal, 1.0 / 32, (double)(k * k % 17));
    expect_near(&mean, straight_mean(&signal, 1.0), 1e-12);
  }
  hc_moving_mean_free(&mean);
}
END_TEST

START_TEST(before_its_time_it_is_the_mean_since_the_start) {
  signal signal = {.count = 0};
  hc_moving_mean mean;
  hc_moving_mean_init(&mean, 100.0, COLUMNS);
  srand(3);
  for (int k = 0; k < STEPS; k++) { /* 30 of the 100 s */
    take(&mean, &signal, 0.02 * chance(), chance());
    if (k % 50 == 0) expect_near(&mean, straight_mean(&signal, 100.0), 1e-12);
  }
  hc_moving_mean_free(&mean);
}
END_TEST

START_TEST(long_steps_are_all_there_is) {
  const double lengths[] = {1e-3, 1e-300, 4.9e-324};
  for (size_t n = 0; n < sizeof lengths / sizeof *lengths; n++) {
    signal signal = {.count = 0};
    hc_moving_mean mean;
    hc_moving_mean_init(&mean, lengths[n], COLUMNS);
    for (int k = 1; k < 20; k++) {
      take(&mean, &signal, 1e-3 * k, 3.0 * k);
      expect_near(&mean, 3.0 * k, 1e-12 * k);
    }
    hc_moving_mean_free(&mean);
  }
}
END_TEST

/* A mean that gets the items of another goes on as that one does. */
START_TEST(its_state_is_all_it_needs) {
  hc_moving_mean whole, resumed;
  hc_moving_mean_init(&whole, 0.3, COLUMNS);
  hc_moving_mean_init(&resumed, 0.3, COLUMNS);
  hc_state states[2];
  hc_moving_mean *const means[] = {&whole, &resumed};
  for (int side = 0; side < 2; side++) {
    hc_state_init(&states[side]);
    hc_moving_mean_register(means[side], &states[side], 4);
  }
  srand(5);
  for (int k = 0; k < 300; k++) {
    if (k == 20 || k == 211) /* a window half full, and one that has gone round */
      for (int item = 0; item < states[0].item_count; item++) {
        const hc_state_item *const from = &states[0].items[item];
        memcpy(states[1].items[item].data, from->data, 8 * (size_t)from->count);
      }
    const double dt = 0.01 * chance(), value = chance();
    for (int side = 0; side < (k < 20 ? 1 : 2); side++)
      hc_moving_mean_add(means[side], dt, (double[COLUMNS]){dt * value, value});
    if (k >= 20) ck_assert_uint_eq(hc_state_digest_items(&states[0]), hc_state_digest_items(&states[1]));
  }
  double found[2][COLUMNS];
  for (int side = 0; side < 2; side++) {
    hc_moving_mean_read(means[side], found[side]);
    hc_moving_mean_free(means[side]);
    hc_state_free(&states[side]);
  }
  ck_assert_mem_eq(found[0], found[1], sizeof found[0]);
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("moving mean");
  TCase *const cases = tcase_create("moving mean");
  tcase_add_test(cases, it_is_the_mean_over_its_time);
  tcase_add_test(cases, steps_of_shares_are_exact);
  tcase_add_test(cases, before_its_time_it_is_the_mean_since_the_start);
  tcase_add_test(cases, long_steps_are_all_there_is);
  tcase_add_test(cases, its_state_is_all_it_needs);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
