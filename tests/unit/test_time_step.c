/* The choice of the time step: which bound governs, and how a run ends. */
#include "stepping/cfl.h"
#include "stepping/constant.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const hc_cfl_settings usual = {
    .common = {.longest = 0.004, .spacing = 0.02, .support_radius = 0.04, .end_time = 100.0}, .factor = 0.4};
static const hc_step_settings even = {
    .longest = 0.007, .spacing = 0.02, .support_radius = 0.04, .end_time = 100.0};

static hc_step_report moving(double v_max, double force_max) {
  hc_step_report report;
  memset(&report, 0, sizeof report);
  report.v_max = v_max;
  report.force_max = force_max;
  return report;
}

static hc_control of(const hc_control_ops *ops, const hc_step_settings *settings) {
  return (hc_control){.ops = ops, .settings = (hc_step_settings *)settings, .bound = (hc_step_bound)-1};
}

static void expect_of(hc_control control, double time, double before, hc_step_report report,
                      hc_step_bound bound, double dt) {
  const double step = hc_control_next(&control, time, before, &report);
  const hc_step_bound found = control.bound;
  ck_assert_msg(found == bound, "%s governs, not %s", hc_step_bound_name(found), hc_step_bound_name(bound));
  ck_assert_msg(fabs(step - dt) <= 1e-15 * dt, "a step of %.17g, expected %.17g", step, dt);
}

static void expect(const hc_cfl_settings *settings, double time, double before, hc_step_report report,
                   hc_step_bound bound, double dt) {
  expect_of(of(&hc_control_cfl, &settings->common), time, before, report, bound, dt);
}

START_TEST(each_bound_governs_when_it_is_the_least) {
  hc_cfl_settings settings = usual;
  expect(&settings, 0, 1, moving(0, 0), HC_BOUND_SIZE, 0.004);
  expect(&settings, 0, 1, moving(1, 1), HC_BOUND_SIZE, 0.004);
  expect(&settings, 0, 1, moving(4, 1), HC_BOUND_VELOCITY, 0.4 * 0.02 / 4);
  expect(&settings, 0, 1, moving(4, 4000), HC_BOUND_FORCE, 0.25 * sqrt(0.04 / 4000));
  expect(&settings, 0, 1, moving(40, 4000), HC_BOUND_VELOCITY, 0.4 * 0.02 / 40);
  settings.common.viscosity = 0.05;
  expect(&settings, 0, 1, moving(4, 1), HC_BOUND_VISCOUS, 0.125 * 0.02 * 0.02 / 0.05);
  expect(&settings, 0, 1, moving(10, 1), HC_BOUND_VELOCITY, 0.4 * 0.02 / 10);
  expect(&settings, 0, 0.0005, moving(10, 1), HC_BOUND_GROWTH, 0.00055);
  expect(&settings, 0, 0.0005, moving(20, 1), HC_BOUND_VELOCITY, 0.4 * 0.02 / 20);
  settings.factor = 0.04;
  expect(&settings, 0, 1, moving(10, 1), HC_BOUND_VELOCITY, 0.04 * 0.02 / 10);
}
END_TEST

START_TEST(constant_steps_heed_nothing_but_the_end) {
  hc_step_settings settings = even;
  settings.viscosity = 1e6;
  expect_of(of(&hc_control_constant, &settings), 0, 1e-9, moving(1e9, 1e9), HC_BOUND_SIZE, 0.007);
  expect_of(of(&hc_control_constant, &settings), 99.999, 1e-9, moving(1e9, 1e9), HC_BOUND_END,
            100.0 - 99.999);
}
END_TEST

START_TEST(steps_grow_by_a_tenth) {
  hc_control control = of(&hc_control_cfl, &usual.common);
  control.bound = HC_BOUND_GROWTH;
  double dt = 1e-4, time = 0;
  int steps = 0;
  for (; control.bound == HC_BOUND_GROWTH && steps < 100; steps++) {
    const hc_step_report report = moving(0.1, 1);
    const double next = hc_control_next(&control, time, dt, &report);
    ck_assert(next <= 1.1 * dt);
    time += next;
    dt = next;
  }
  ck_assert(control.bound == HC_BOUND_SIZE && dt == 0.004);
  ck_assert_int_eq(steps, 39); /* 1.1^38 < 40 < 1.1^39 */
}
END_TEST

/* Nothing is known of the pressure at first. */
START_TEST(the_first_step_is_short) {
  hc_cfl_settings settings = usual;
  expect(&settings, 0, 0, moving(0, 0), HC_BOUND_GROWTH, 0.001);
  expect(&settings, 0, 0, moving(1, 9.81), HC_BOUND_GROWTH, 0.001);
  expect(&settings, 0, 0, moving(16, 9.81), HC_BOUND_VELOCITY, 0.4 * 0.02 / 16);
  expect_of(of(&hc_control_constant, &even), 0, 0, moving(16, 9.81), HC_BOUND_SIZE, 0.007);
}
END_TEST

/* Steps of any size reach the end exactly, and the last one is no sliver. */
START_TEST(a_run_ends_on_time) {
  for (int k = 1; k <= 1500; k++) {
    hc_step_settings settings = even;
    settings.longest = 1.0 / k; /* 1/k adds up to just below or above 1 */
    settings.end_time = 1.0;
    double time = 0, dt = 0;
    hc_control control = of(&hc_control_constant, &settings);
    int steps = 0;
    bool good = true; /* a ck_assert costs a system call */
    for (; control.bound != HC_BOUND_END && steps <= k + 2; steps++) {
      const hc_step_report report = moving(1, 1);
      dt = hc_control_next(&control, time, dt, &report);
      good &= dt > 0.5 * settings.longest && dt <= settings.longest * (1 + 2e-9);
      time += dt;
    }
    ck_assert(good && fabs(time - 1.0) <= 0x1p-53);
    ck_assert_msg(steps == k, "%d steps of 1/%d", steps, k);
  }
}
END_TEST

START_TEST(the_end_is_not_overstepped) {
  hc_cfl_settings settings = usual;
  settings.common.end_time = 0.5;
  expect(&settings, 0.4985, 1, moving(1, 1), HC_BOUND_END, 0.5 - 0.4985);
  expect(&settings, 0.496, 1, moving(1, 1), HC_BOUND_END, 0.5 - 0.496);
  expect(&settings, 0.4919, 1, moving(1, 1), HC_BOUND_SIZE, 0.004);
  expect(&settings, 0.496 - 1e-13, 1, moving(1, 1), HC_BOUND_END,
         0.5 - (0.496 - 1e-13)); /* takes a sliver along */
  expect(&settings, 0.496 - 1e-10, 1, moving(1, 1), HC_BOUND_SIZE, 0.5 * (0.5 - (0.496 - 1e-10)));
  expect(&settings, 0.493, 1, moving(1, 1), HC_BOUND_SIZE, 0.5 * (0.5 - 0.493)); /* the last two share */
  expect(&settings, 0.4999, 1e-5, moving(1, 1), HC_BOUND_GROWTH, 1.1e-5);        /* the others still bind */
}
END_TEST

START_TEST(steps_have_a_floor) {
  hc_step_settings settings = usual.common;
  ck_assert(hc_time_step_floor(&settings) == 1e-5 * 0.004);
  ck_assert(!hc_time_step_too_small(&settings, 0.0, 4.1e-8) &&
            hc_time_step_too_small(&settings, 0.0, 3.9e-8));
  ck_assert(!hc_time_step_too_small(&settings, 100.0 - 1e-9, 1e-9)); /* the end asks for it */
  ck_assert(!hc_time_step_too_small(&settings, 100.0 - 2e-9, 0.5 * (100.0 - (100.0 - 2e-9))));
  ck_assert(hc_time_step_too_small(&settings, 0.0, 0.0) && hc_time_step_too_small(&settings, 0.0, NAN));
  settings.longest = 0.007;
  ck_assert(hc_time_step_floor(&settings) == 1e-5 * 0.007);
  settings.min = 1e-3;
  ck_assert(hc_time_step_too_small(&settings, 0.0, 0.9e-3) && !hc_time_step_too_small(&settings, 0.0, 1e-3));
}
END_TEST

/* What a control does not give has its default; a step is tried unless it is under the floor. */
START_TEST(defaults_of_a_control) {
  const hc_control cfl = of(&hc_control_cfl, &usual.common), constant = of(&hc_control_constant, &even);
  ck_assert(hc_control_usual(&cfl, 2.0) == 0.4 * 0.02 / 2.0 && hc_control_still(&cfl) == 0.004);
  ck_assert(hc_control_still(&constant) == 0.007 && !hc_control_may_go_back(&constant));
  ck_assert_int_eq(hc_control_permit(&cfl, 0.0, 1e-3), HC_VERDICT_ACCEPT);
  ck_assert_int_eq(hc_control_permit(&cfl, 0.0, 1e-9), HC_VERDICT_UNDER_FLOOR);
  const hc_step_report wild = {.v_max = 1e9, .density_error_max = 1e9};
  hc_step_tried tried = {.dt = 1.0, .report = &wild, .forced = true};
  hc_shock shock;
  ck_assert_int_eq(hc_control_judge(&cfl, &tried, &shock), HC_VERDICT_ACCEPT);
  tried.status = HC_FAILED;
  ck_assert_int_eq(hc_control_judge(&cfl, &tried, &shock), HC_VERDICT_FAILED);
}
END_TEST

START_TEST(every_bound_has_a_name) {
  for (int bound = HC_BOUND_SIZE; bound <= HC_BOUND_END; bound++) {
    ck_assert(hc_step_bound_name((hc_step_bound)bound)[0] != 0);
    for (int other = 0; other < bound; other++)
      ck_assert_str_ne(hc_step_bound_name((hc_step_bound)bound), hc_step_bound_name((hc_step_bound)other));
  }
  ck_assert_str_eq(hc_step_bound_name(HC_BOUND_VELOCITY), "velocity");
  ck_assert_str_eq(hc_step_bound_name(HC_BOUND_END), "end of run");
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("time_step");
  TCase *const cases = tcase_create("bounds");
  tcase_set_timeout(cases, 60);
  tcase_add_test(cases, each_bound_governs_when_it_is_the_least);
  tcase_add_test(cases, constant_steps_heed_nothing_but_the_end);
  tcase_add_test(cases, steps_grow_by_a_tenth);
  tcase_add_test(cases, the_first_step_is_short);
  tcase_add_test(cases, a_run_ends_on_time);
  tcase_add_test(cases, the_end_is_not_overstepped);
  tcase_add_test(cases, steps_have_a_floor);
  tcase_add_test(cases, defaults_of_a_control);
  tcase_add_test(cases, every_bound_has_a_name);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
