/* The choice of the time step: which bound governs, and how a run ends. */
#include "stepping/cfl.h"
#include "stepping/constant.h"
#include "stepping/global.h"
#include "stepping/individual.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const hc_cfl_settings usual = {.common = {.longest = 0.004,
                                                 .first = INFINITY,
                                                 .spare = 0.05,
                                                 .spacing = 0.02,
                                                 .support_radius = 0.04,
                                                 .end_time = 100.0},
                                      .factor = 0.4,
                                      .error_avg = 1e-4};
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
  settings.common.first = 0.0003;
  expect(&settings, 0, 0, moving(1, 9.81), HC_BOUND_GROWTH, 0.0003);
}
END_TEST

/* A length that failed is approached slowly, and then forgotten. */
START_TEST(steps_near_a_failed_one_grow_slowly) {
  hc_control control = of(&hc_control_cfl, &usual.common);
  control.guard.shock.dt = 0.002;
  const struct {
    double before, next;
  } cases[] = {{0.001, 0.0011},         {0.00135, 0.0014}, {0.0014, 0.0014 * 1.01},
               {0.0019, 0.0019 * 1.01}, {0.002, 0.0022},   {0.003, 0.0033}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
    expect_of(control, 0, cases[k].before, moving(0, 0), HC_BOUND_GROWTH, cases[k].next);
  control.guard.next = 0.0005;
  expect_of(control, 0, 0.002, moving(0, 0), HC_BOUND_SHOCK, 0.0005);
}
END_TEST

/* How a step of 0.004 s is judged that ends with such a speed, and, where its solve was at its cap, such an
 * error. */
static hc_shock_kind judged(double v_max, double error, bool capped_before, int restarts) {
  hc_control control = of(&hc_control_cfl, &usual.common);
  control.guard.restarts = restarts;
  const hc_step_report report = {
      .v_max = v_max, .density_error_avg = error, .density_capped = error > usual.error_avg};
  const hc_step_tried tried = {.dt = 0.004, .report = &report, .capped_before = capped_before};
  hc_shock shock;
  const hc_verdict verdict = hc_control_judge(&control, &tried, &shock);
  ck_assert_int_eq(verdict, shock.kind == HC_SHOCK_NONE ? HC_VERDICT_ACCEPT : HC_VERDICT_TAKE_BACK);
  ck_assert(shock.kind == HC_SHOCK_NONE || shock.value > shock.limit);
  if (shock.kind != HC_SHOCK_NONE) {
    hc_control_take_back(&control, &shock, &report, 1);
    ck_assert(control.guard.next == 0.002);
  }
  return (hc_shock_kind)shock.kind;
}

START_TEST(steps_that_were_too_long_are_taken_back) {
  ck_assert_int_eq(judged(1, 1e-5, false, 0), HC_SHOCK_NONE);
  ck_assert_int_eq(judged(0, 1e-5, false, 0), HC_SHOCK_NONE);
  ck_assert_int_eq(judged(1, 4e-4, false, 0), HC_SHOCK_NONE); /* at its cap, not far from its aim */
  ck_assert_int_eq(judged(1, 6e-4, false, 0), HC_SHOCK_CAP);
  ck_assert_int_eq(judged(1, 6e-4, true, 0), HC_SHOCK_NONE); /* shorter steps have not helped */
  ck_assert_int_eq(judged(3.9, 1e-5, false, 0), HC_SHOCK_NONE);
  ck_assert_int_eq(judged(4.1, 1e-5, false, 0), HC_SHOCK_JUMP); /* 2 0.4 0.02 / 0.004 */
  ck_assert_int_eq(judged(4.1, 6e-4, true, 4), HC_SHOCK_JUMP);
  ck_assert_int_eq(judged(4.1, 6e-4, false, 5), HC_SHOCK_NONE); /* enough */
}
END_TEST

/* A step that failed is tried again as often; then it is the run's end, as it is. */
START_TEST(failed_steps_are_tried_again) {
  hc_control control = of(&hc_control_cfl, &usual.common);
  hc_step_report report = {.fault = {.kind = HC_FAULT_SPEED}};
  const hc_step_tried tried = {.dt = 0.004, .report = &report, .status = HC_FAILED};
  hc_shock shock;
  ck_assert_int_eq(hc_control_judge(&control, &tried, &shock), HC_VERDICT_TAKE_BACK);
  ck_assert_int_eq(shock.kind, HC_SHOCK_FAULT);
  const hc_fault_kind lost[] = {HC_FAULT_TIME_STEP, HC_FAULT_START_VALUE, HC_FAULT_START_SPEED,
                                HC_FAULT_LEFT};
  for (int k = 0; k < 4; k++) {
    report.fault.kind = lost[k];
    ck_assert_int_eq(hc_control_judge(&control, &tried, &shock), HC_VERDICT_FAILED);
  }
  report.fault.kind = HC_FAULT_SPEED;
  control.guard.restarts = 5;
  ck_assert_int_eq(hc_control_judge(&control, &tried, &shock), HC_VERDICT_FAILED);
  ck_assert_int_eq(hc_control_permit(&control, 0.0, 1e-3), HC_VERDICT_ACCEPT);
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
      time = control.end;
      hc_control_accept(&control, dt);
    }
    ck_assert(good && time == 1.0);
    ck_assert_msg(steps == k, "%d steps of 1/%d", steps, k);
  }
}
END_TEST

/* What is left is shared out among the last fifty steps. */
START_TEST(the_end_is_not_overstepped) {
  hc_cfl_settings settings = usual;
  settings.common.end_time = 0.5;
  expect(&settings, 0.4985, 1, moving(1, 1), HC_BOUND_END, 0.5 - 0.4985);
  expect(&settings, 0.496, 1, moving(1, 1), HC_BOUND_END, 0.5 - 0.496);
  expect(&settings, 0.4919, 1, moving(1, 1), HC_BOUND_SIZE, (0.5 - 0.4919) / 2.0);
  expect(&settings, 0.496 - 1e-13, 1, moving(1, 1), HC_BOUND_END,
         0.5 - (0.496 - 1e-13)); /* takes a sliver along */
  expect(&settings, 0.4957, 1, moving(1, 1), HC_BOUND_SIZE, 0.5 * (0.5 - 0.4957));
  expect(&settings, 0.493, 1, moving(1, 1), HC_BOUND_SIZE, 0.5 * (0.5 - 0.493));
  expect(&settings, 0.3015, 1, moving(1, 1), HC_BOUND_SIZE, (0.5 - 0.3015) / 48.0);
  expect(&settings, 0.2885, 1, moving(1, 1), HC_BOUND_SIZE, 0.004);
  expect(&settings, 0.4999, 1e-5, moving(1, 1), HC_BOUND_GROWTH, (0.5 - 0.4999) / 9.0);
}
END_TEST

/* So does a run with steps that change. */
START_TEST(changing_steps_come_to_the_end) {
  for (int k = 0; k < 40; k++) {
    hc_cfl_settings settings = usual;
    settings.common.end_time = 1.0 + 0.01 * k;
    hc_control control = of(&hc_control_cfl, &settings.common);
    double time = 0.0, dt = 0.004, least = 1.0;
    for (int step = 0; control.bound != HC_BOUND_END && step < 10000; step++) {
      const hc_step_report report = moving(2.0 + 0.05 * (step % 7) + 0.01 * k, 1);
      const double next = hc_control_next(&control, time, dt, &report);
      least = fmin(least, next / dt);
      dt = next;
      time = control.end;
      hc_control_accept(&control, dt);
    }
    ck_assert(time == settings.common.end_time);
    ck_assert_msg(least > 0.6, "%d: a step shrank to %g", k, least);
  }
}
END_TEST

/* Constant steps that divide the interval come to every multiple of it, none early, late or twice: times are
 * counted, and what rounding leaves is no matter. */
START_TEST(constant_steps_count_their_time) {
  static const double sizes[] = {0.01, 0.02,   0.005,     0.001, 0.003, 0.007,
                                 1e-4, 0.0003, 1.0 / 3.0, 0.1,   7e-6,  0.9};
  static const int each[] = {1, 2, 3, 7, 10, 100};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
    for (size_t e = 0; e < sizeof each / sizeof *each; e++) {
      const double every = sizes[s] * each[e];
      hc_step_settings settings = even;
      settings.longest = sizes[s];
      settings.end_time = 1e9;
      hc_control control = of(&hc_control_constant, &settings);
      double time = 0.0, dt = 0.0;
      int early = 0;
      for (int step = 1; step <= 3000; step++) {
        const hc_step_report report = moving(1, 1);
        dt = hc_control_next(&control, time, dt, &report);
        const bool due = hc_time_step_multiples(every, control.end) > hc_time_step_multiples(every, time);
        early += due != (step % each[e] == 0);
        time = control.end;
        hc_control_accept(&control, dt);
      }
      ck_assert_msg(early == 0, "steps of %g, every %g: %d off", sizes[s], every, early);
      ck_assert(fabs(time - 3000.0 * sizes[s]) <= 2e-16 * time);
    }
}
END_TEST

/* Another length begins another count. */
START_TEST(a_new_length_is_counted_anew) {
  hc_step_settings settings = even;
  settings.longest = 0.1;
  hc_control control = of(&hc_control_constant, &settings);
  const hc_step_report report = moving(1, 1);
  for (int step = 0; step < 3; step++)
    hc_control_accept(&control, hc_control_next(&control, 0.1 * step, 0.1, &report));
  ck_assert(control.end == 3.0 * 0.1 && control.count.steps == 3.0);
  settings.longest = 0.07;
  hc_control_accept(&control, hc_control_next(&control, control.end, 0.1, &report));
  ck_assert(control.count.origin == 3.0 * 0.1 && control.count.steps == 1.0);
  ck_assert(control.end == 3.0 * 0.1 + 0.07);
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
  ck_assert_int_eq(hc_control_judge(&constant, &tried, &shock), HC_VERDICT_ACCEPT);
  tried.status = HC_FAILED;
  ck_assert_int_eq(hc_control_judge(&constant, &tried, &shock), HC_VERDICT_FAILED);
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

/* He et al. 2015, eq. 6 to 8, and sound. */
START_TEST(global_steps_follow_speeds_and_forces) {
  const hc_global_settings settings = {
      {.longest = 0.001, .support_radius = 0.04, .end_time = 100.0}, 0.1, 0.05};
  const hc_control control = of(&hc_control_global, &settings.common);
  expect_of(control, 0, 1, moving(0, 0), HC_BOUND_SIZE, 0.001);
  expect_of(control, 0, 1, moving(8, 20), HC_BOUND_VELOCITY, 0.1 * 0.04 / 8);
  expect_of(control, 0, 1, moving(8, 4e4), HC_BOUND_FORCE, 0.05 * sqrt(0.04 / 4e4));
  ck_assert(fabs(hc_control_usual(&control, 8.0) - 0.0005) < 1e-15 &&
            hc_control_usual(&control, 0.1) == 0.001);
}
END_TEST

/* A block is of one longest step, or of two or four where nothing moves farther in it than lists reach. */
START_TEST(blocks_are_longer_in_calm_water) {
  hc_individual_control settings = {
      {.longest = 0.004, .support_radius = 0.04, .end_time = 100.0}, 0.001, 0.004};
  const hc_control control = of(&hc_control_individual, &settings.common);
  expect_of(control, 0, 1, moving(0, 0), HC_BOUND_SIZE, 0.004);
  expect_of(control, 0, 1, moving(0.99, 1e9), HC_BOUND_SIZE, 0.004);
  expect_of(control, 0, 1, moving(1.01, 0), HC_BOUND_SIZE, 0.002);
  expect_of(control, 0, 1, moving(2.01, 0), HC_BOUND_SIZE, 0.001);
  expect_of(control, 0, 1, moving(100, 0), HC_BOUND_SIZE, 0.001);
  settings.common.viscosity = 0.0625;
  expect_of(control, 0, 1, moving(0, 0), HC_BOUND_VISCOUS, 0.0032);
  settings.common.viscosity = 1.25; /* four of its own, not as many as fit into those of sound */
  expect_of(control, 0, 1, moving(0, 0), HC_BOUND_VISCOUS, 4 * 0.125 * 0.02 * 0.02 / 1.25);
  settings.common.viscosity = 0.125;
  expect_of(control, 0, 1, moving(100, 0), HC_BOUND_VISCOUS, 0.125 * 0.02 * 0.02 / 0.125);
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
  tcase_add_test(cases, steps_near_a_failed_one_grow_slowly);
  tcase_add_test(cases, steps_that_were_too_long_are_taken_back);
  tcase_add_test(cases, failed_steps_are_tried_again);
  tcase_add_test(cases, a_run_ends_on_time);
  tcase_add_test(cases, changing_steps_come_to_the_end);
  tcase_add_test(cases, constant_steps_count_their_time);
  tcase_add_test(cases, a_new_length_is_counted_anew);
  tcase_add_test(cases, the_end_is_not_overstepped);
  tcase_add_test(cases, steps_have_a_floor);
  tcase_add_test(cases, defaults_of_a_control);
  tcase_add_test(cases, every_bound_has_a_name);
  tcase_add_test(cases, global_steps_follow_speeds_and_forces);
  tcase_add_test(cases, blocks_are_longer_in_calm_water);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
