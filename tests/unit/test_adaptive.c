/* The adaptive time step: each criterion in both directions, the first step, shocks, and the guard of a
 * replay.
 */
#include "stepping/adaptive.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>

static const double H = 0.04;

static hc_adaptive_settings usual(void) {
  return (hc_adaptive_settings){.common = {.longest = 0.1,
                                           .first = 0.002,
                                           .spare = 0.003,
                                           .spacing = 0.02,
                                           .support_radius = H,
                                           .end_time = 100.0},
                                .error_avg = 0.01,
                                .error_max = 0.1,
                                .change = 0.002,
                                .grow = {.force = 0.19, .velocity = 0.39, .error_max = 4.5, .error_avg = 0.9},
                                .shrink = {.force = 0.2, .velocity = 0.4, .error_max = 5.5, .error_avg = 1},
                                .shock_rise = 0.05,
                                .shock_velocity = 0.45,
                                .restart_force = 0.2,
                                .restart_velocity = 0.25,
                                .restart_share = 0.5,
                                .most_restarts = 10,
                                .first_velocity = 0.25};
}

static const double DT = 0.001;

static hc_control of(hc_adaptive_settings *settings) {
  return (hc_control){.ops = &hc_control_adaptive, .settings = &settings->common};
}

static double next_of(hc_adaptive_settings *settings, double time, double before, hc_step_report report,
                      hc_step_bound *bound) {
  hc_control control = of(settings);
  const double next = hc_control_next(&control, time, before, &report);
  *bound = control.bound;
  return next;
}

/* The force and speed at which a step of DT is `factor` of what they allow. */
static double force_at(double factor) {
  return H * factor * factor / (DT * DT);
}

static double speed_at(double factor) {
  return factor * H / DT;
}

static hc_step_report calm(void) {
  return (hc_step_report){
      .v_max = 0.1, .force_max = 9.81, .density_error_avg = 0.001, .density_error_max = 0.01};
}

/* `way`: -1, 0, 1: the step shrinks, stays, grows. */
static void expect(hc_step_report report, int way, hc_step_bound bound) {
  hc_adaptive_settings settings = usual();
  hc_step_bound found = HC_BOUND_END;
  const double next = next_of(&settings, 1.0, DT, report, &found);
  ck_assert_msg(found == bound, "%s governs, not %s", hc_step_bound_name(found), hc_step_bound_name(bound));
  ck_assert_double_eq(next, DT * (1.0 + way * 0.002));
}

START_TEST(each_criterion_holds_growth_back_or_shrinks) {
  expect(calm(), 1, HC_BOUND_GROWTH);
  expect((hc_step_report){.v_max = 0}, 1, HC_BOUND_GROWTH);
  const struct {
    double low, high; /* of the criteria for growing and shrinking */
    hc_step_bound bound;
  } rules[] = {{0.19, 0.2, HC_BOUND_FORCE},
               {0.39, 0.4, HC_BOUND_VELOCITY},
               {4.5, 5.5, HC_BOUND_ERROR_MAX},
               {0.9, 1.0, HC_BOUND_ERROR_AVG}};
  for (size_t k = 0; k < sizeof rules / sizeof *rules; k++) {
    const double between = 0.5 * (rules[k].low + rules[k].high);
    const double levels[] = {0.999 * rules[k].low, 1.001 * rules[k].low, between, 0.999 * rules[k].high,
                             1.001 * rules[k].high};
    for (int level = 0; level < 5; level++) {
      hc_step_report report = calm();
      if (rules[k].bound == HC_BOUND_FORCE) report.force_max = force_at(levels[level]);
      if (rules[k].bound == HC_BOUND_VELOCITY) report.v_max = speed_at(levels[level]);
      if (rules[k].bound == HC_BOUND_ERROR_MAX) report.density_error_max = 0.01 * levels[level];
      if (rules[k].bound == HC_BOUND_ERROR_AVG) report.density_error_avg = 0.01 * levels[level];
      const int way = level == 0 ? 1 : level == 4 ? -1 : 0;
      expect(report, way, way == 1 ? HC_BOUND_GROWTH : rules[k].bound);
    }
  }
}
END_TEST

START_TEST(one_criterion_is_enough_to_shrink) {
  hc_step_report report = calm();
  report.force_max = force_at(0.195); /* keeps */
  report.density_error_avg = 0.011;   /* shrinks */
  expect(report, -1, HC_BOUND_ERROR_AVG);
  report.density_error_avg = 0.01; /* (22) is >=, */
  expect(report, -1, HC_BOUND_ERROR_AVG);
  report.density_error_avg = 0.009; /* (18) is < */
  expect(report, 0, HC_BOUND_FORCE);
}
END_TEST

START_TEST(the_largest_and_the_viscous_step_hold) {
  hc_adaptive_settings settings = usual();
  hc_step_report report = calm();
  hc_step_bound bound;
  settings.common.longest = DT;
  ck_assert_double_eq(next_of(&settings, 0, DT, report, &bound), DT);
  ck_assert_int_eq(bound, HC_BOUND_SIZE);
  settings.common.viscosity = 0.1; /* 0.125 (h/2)^2/nu */
  ck_assert_double_eq_tol(next_of(&settings, 0, DT, report, &bound), 5e-4, 1e-15);
  ck_assert_int_eq(bound, HC_BOUND_VISCOUS);
}
END_TEST

/* What is left is shared out anew in each step, also where they shrink: the end is reached. */
START_TEST(shrinking_steps_reach_the_end) {
  hc_adaptive_settings settings = usual();
  settings.common.end_time = 1.0;
  hc_step_report report = calm();
  report.density_error_avg = 0.02;
  double time = 0.9405, dt = DT, least = 1.0;
  hc_step_bound bound = HC_BOUND_SIZE;
  int steps = 0;
  for (; bound != HC_BOUND_END && steps < 100; steps++) {
    const double before = dt;
    dt = next_of(&settings, time, dt, report, &bound);
    time += dt;
    least = fmin(least, dt / before);
  }
  ck_assert(steps > 60 && steps < 70);
  ck_assert(least > 0.98);
  ck_assert(fabs(time - 1.0) < 1e-12);
}
END_TEST

START_TEST(the_first_step_heeds_speed_and_depth) {
  hc_adaptive_settings settings = usual();
  hc_step_report report = {.v_max = 0, .force_max = 9.81};
  hc_step_bound bound;
  ck_assert_double_eq(next_of(&settings, 0, 0, report, &bound), 0.002);
  ck_assert_int_eq(bound, HC_BOUND_DEPTH);
  report.v_max = 10;
  ck_assert_double_eq(next_of(&settings, 0, 0, report, &bound), 0.25 * H / 10);
  ck_assert_int_eq(bound, HC_BOUND_VELOCITY);
  settings.common.longest = 1e-4;
  ck_assert_double_eq(next_of(&settings, 0, 0, report, &bound), 1e-4);
  ck_assert_int_eq(bound, HC_BOUND_SIZE);
  settings.common.longest = 0.1;
  settings.common.first = INFINITY;
  report.v_max = 0;
  ck_assert_double_eq(next_of(&settings, 0, 0, report, &bound), 0.1);
  ck_assert_int_eq(bound, HC_BOUND_SIZE);
}
END_TEST

static hc_shock_kind shock_of(double error, double before, double v_max) {
  hc_adaptive_settings settings = usual();
  const hc_control control = of(&settings);
  const hc_step_report report = {.v_max = v_max, .density_error_max = error};
  const hc_step_tried tried = {.time = 2.0 - DT, .dt = DT, .report = &report, .error_before = before};
  hc_shock shock;
  const hc_verdict verdict = hc_control_judge(&control, &tried, &shock);
  ck_assert_int_eq(verdict, shock.kind == HC_SHOCK_NONE ? HC_VERDICT_ACCEPT : HC_VERDICT_TAKE_BACK);
  if (shock.kind != HC_SHOCK_NONE) {
    char text[HC_SHOCK_TEXT];
    hc_shock_text(&shock, text);
    ck_assert(text[0] && shock.time == 2.0 && shock.dt == DT && shock.value > shock.limit);
  }
  return (hc_shock_kind)shock.kind;
}

START_TEST(shocks_are_found) {
  ck_assert_int_eq(shock_of(0.06, 0.02, 1), HC_SHOCK_NONE);
  ck_assert_int_eq(shock_of(0.071, 0.02, 1), HC_SHOCK_RISE);
  ck_assert_int_eq(shock_of(0.02, 0.09, 1), HC_SHOCK_NONE);
  ck_assert_int_eq(shock_of(0.099, 0.06, 1), HC_SHOCK_NONE);
  ck_assert_int_eq(shock_of(0.101, 0.06, 1), HC_SHOCK_ERROR);
  ck_assert_int_eq(shock_of(0.01, 0.01, speed_at(0.449)), HC_SHOCK_NONE);
  ck_assert_int_eq(shock_of(0.01, 0.01, speed_at(0.451)), HC_SHOCK_VELOCITY);
  /* at the first step nothing is known of the one before */
  ck_assert_int_eq(shock_of(0.099, -1, 1), HC_SHOCK_NONE);
  ck_assert_int_eq(shock_of(0.101, -1, 1), HC_SHOCK_ERROR);
}
END_TEST

/* What failed may do better when shorter, but for what was wrong before it began. */
START_TEST(failed_steps_are_judged) {
  hc_adaptive_settings settings = usual();
  hc_control control = of(&settings);
  hc_step_report report = {.fault = {.kind = HC_FAULT_SPEED}};
  const hc_step_tried tried = {.dt = DT, .report = &report, .error_before = -1, .status = HC_FAILED};
  hc_shock shock;
  ck_assert_int_eq(hc_control_judge(&control, &tried, &shock), HC_VERDICT_TAKE_BACK);
  ck_assert_int_eq(shock.kind, HC_SHOCK_FAULT);
  const hc_fault_kind lost[] = {HC_FAULT_TIME_STEP, HC_FAULT_START_VALUE, HC_FAULT_LEFT};
  for (int k = 0; k < 3; k++) {
    report.fault.kind = lost[k];
    ck_assert_int_eq(hc_control_judge(&control, &tried, &shock), HC_VERDICT_FAILED);
  }
  const hc_step_report fast = {.v_max = speed_at(0.5), .fault = {.kind = HC_FAULT_LEFT}};
  const hc_step_tried thrown = {.dt = DT, .report = &fast, .error_before = -1, .status = HC_FAILED};
  ck_assert_int_eq(hc_control_judge(&control, &thrown, &shock), HC_VERDICT_TAKE_BACK);
  control.guard.restarts = 10;
  ck_assert_int_eq(hc_control_permit(&control, 1.0, DT), HC_VERDICT_ACCEPT);
  control.guard.restarts = 11;
  ck_assert_int_eq(hc_control_permit(&control, 1.0, DT), HC_VERDICT_GAVE_UP);
}
END_TEST

START_TEST(a_replay_begins_with_a_shorter_step) {
  hc_adaptive_settings settings = usual();
  const hc_shock shock = {.kind = HC_SHOCK_RISE, .time = 1.0, .dt = DT};
  hc_step_report report = calm();
  hc_control control = of(&settings);
  hc_shock_guard *guard = &control.guard;
  hc_control_take_back(&control, &shock, &report, 2); /* calm: half of what failed */
  ck_assert_double_eq(guard->next, 0.5 * DT);
  report.force_max = force_at(0.8); /* 0.2/0.8 of the step */
  *guard = (hc_shock_guard){.until = 0};
  hc_control_take_back(&control, &shock, &report, 2);
  ck_assert_double_eq_tol(guard->next, 0.25 * DT, 1e-18);
  report = calm();
  report.v_max = speed_at(2.0); /* 0.25/2 */
  *guard = (hc_shock_guard){.until = 0};
  hc_control_take_back(&control, &shock, &report, 2);
  ck_assert_double_eq_tol(guard->next, 0.125 * DT, 1e-18);
  /* a step that diverged leaves nothing to go by */
  const hc_shock diverged = {.kind = HC_SHOCK_FAULT, .time = 1.0, .dt = DT};
  report.force_max = 1e30;
  *guard = (hc_shock_guard){.until = 0};
  hc_control_take_back(&control, &diverged, &report, 2);
  ck_assert_double_eq(guard->next, 0.5 * DT);
}
END_TEST

START_TEST(only_the_time_of_the_shock_ends_the_guard) {
  hc_adaptive_settings settings = usual();
  hc_shock shock = {.kind = HC_SHOCK_ERROR, .time = 1.0, .dt = DT};
  const hc_step_report report = calm();
  hc_control control = of(&settings);
  hc_shock_guard *guard = &control.guard;
  ck_assert_int_eq(hc_shock_guard_pass(guard, 0.999), 0);
  hc_control_take_back(&control, &shock, &report, 2);
  ck_assert(guard->until == 1.0 && guard->restarts == 1);
  ck_assert_int_eq(hc_shock_guard_pass(guard, 0.9985), 2); /* the first row tells of both steps */
  ck_assert_int_eq(hc_shock_guard_pass(guard, 0.999), 0);
  ck_assert(guard->until == 1.0 && guard->begun == 0.5 * DT && guard->next == 0.0);
  /* a second shock before its time: half of what the replay began with, though steps have grown since */
  shock.time = 0.9995;
  shock.dt = 0.7 * DT;
  hc_control_take_back(&control, &shock, &report, 2);
  ck_assert_double_eq(guard->next, 0.25 * DT);
  ck_assert(guard->until == 1.0 && guard->restarts == 2 && guard->rollbacks == 2 && guard->steps == 4);
  /* a third, of a shorter step that ended later */
  shock.time = 1.001;
  shock.dt = 0.1 * DT;
  hc_control_take_back(&control, &shock, &report, 1);
  ck_assert_double_eq(guard->next, 0.05 * DT);
  ck_assert(guard->until == 1.001 && guard->restarts == 3 && guard->untold == 3);
  ck_assert_int_eq(hc_shock_guard_pass(guard, 1.0), 3);
  ck_assert_int_eq(guard->restarts, 3);
  hc_shock_guard_pass(guard, 1.001);
  ck_assert(guard->until == 0.0 && guard->restarts == 0 && guard->rollbacks == 3 && guard->steps == 5);
  /* the next is a shock of its own */
  hc_control_take_back(&control, &shock, &report, 2);
  ck_assert(guard->restarts == 1 && guard->next == 0.05 * DT);
  /* which the next step has, whatever the report says */
  ck_assert(hc_control_next(&control, 0.5, DT, &report) == 0.05 * DT && control.bound == HC_BOUND_SHOCK);
}
END_TEST

START_TEST(replays_reach_the_floor) {
  hc_adaptive_settings settings = usual();
  const hc_step_report report = calm();
  hc_control control = of(&settings);
  hc_shock_guard *guard = &control.guard;
  double dt = DT;
  int count = 0;
  for (; !hc_time_step_too_small(&settings.common, 1.0, dt) && count < 100; count++) {
    const hc_shock shock = {.kind = HC_SHOCK_ERROR, .time = 1.0 + dt, .dt = dt};
    hc_control_take_back(&control, &shock, &report, 1);
    dt = guard->next;
  }
  ck_assert_int_eq(count, 10); /* 1e-3 / 2^10 < 1e-5 * 0.1 */
}
END_TEST

int main(void) {
  Suite *const suite = suite_create("adaptive");
  TCase *const cases = tcase_create("control");
  tcase_add_test(cases, each_criterion_holds_growth_back_or_shrinks);
  tcase_add_test(cases, one_criterion_is_enough_to_shrink);
  tcase_add_test(cases, the_largest_and_the_viscous_step_hold);
  tcase_add_test(cases, shrinking_steps_reach_the_end);
  tcase_add_test(cases, the_first_step_heeds_speed_and_depth);
  tcase_add_test(cases, shocks_are_found);
  tcase_add_test(cases, failed_steps_are_judged);
  tcase_add_test(cases, a_replay_begins_with_a_shorter_step);
  tcase_add_test(cases, only_the_time_of_the_shock_ends_the_guard);
  tcase_add_test(cases, replays_reach_the_floor);
  suite_add_tcase(suite, cases);
  SRunner *const runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
