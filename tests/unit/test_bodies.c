/* Rigid bodies by themselves: how they fall, turn, hang and are held. */
#include "rigid/bodies.h"

#include "base/memory.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const hc_frame frame = {
    .unit = {0.05 / (double)HC_CELL_UNITS, 0.05 / (double)HC_CELL_UNITS, 0.05 / (double)HC_CELL_UNITS},
    .support_radius = 0.05};

/* One body of 2 kg with these moments of inertia, far away, at rest. */
static hc_bodies make(double a, double b, double c) {
  hc_bodies bodies;
  hc_bodies_init(&bodies, 1, &frame);
  bodies.first = 3;
  hc_body *const body = bodies.body;
  *body = (hc_body){.wall = 3, .mass = 2.0, .reach = 0.5, .turn = {1.0, 0.0, 0.0, 0.0}};
  body->inertia[0][0] = a;
  body->inertia[1][1] = b;
  body->inertia[2][2] = c;
  for (int axis = 0; axis < 3; axis++) body->position[axis] = 1000000 * HC_CELL_UNITS;
  return bodies;
}

/* Poses, so that the compliance is that of where it stands. */
static void stand(hc_bodies *bodies, double time) {
  hc_movers movers;
  hc_movers_init(&movers, 1, 0);
  movers.walls[0].wall = 3;
  hc_bodies_pose(bodies, time, &movers);
  hc_movers_free(&movers);
}

static void step(hc_bodies *bodies, double time, double dt) {
  stand(bodies, time);
  hc_twist impulse = hc_body_pull(bodies, bodies->body);
  for (int axis = 0; axis < 3; axis++) {
    impulse.linear[axis] *= dt;
    impulse.angular[axis] *= dt;
  }
  hc_body_push(bodies->body, &impulse);
  hc_body_drift(bodies, bodies->body, dt);
}

static double energy(hc_bodies *bodies) {
  double spin[3], sum = 0.0;
  stand(bodies, 0.0);
  hc_body_spin(bodies->body, spin);
  for (int axis = 0; axis < 3; axis++) sum += 0.5 * spin[axis] * bodies->body->momentum[axis];
  return sum;
}

START_TEST(a_body_falls) {
  hc_bodies bodies = make(1, 1, 1);
  bodies.gravity[2] = -9.81;
  bodies.body->velocity[0] = 2.0;
  const int steps = 1000;
  const double dt = 1e-3, time = steps * dt;
  for (int k = 0; k < steps; k++) step(&bodies, k * dt, dt);
  const double fallen = (double)(bodies.body->position[2] - 1000000 * HC_CELL_UNITS) * frame.unit[2],
               gone = (double)(bodies.body->position[0] - 1000000 * HC_CELL_UNITS) * frame.unit[0];
  ck_assert_double_eq_tol(gone, 2.0, 1e-6);
  ck_assert_double_eq_tol(bodies.body->velocity[2], -9.81 * time, 1e-10);
  ck_assert_double_eq_tol(fallen, -0.5 * 9.81 * time * (time + dt), 1e-6); /* kick, then drift */
  ck_assert_double_eq(bodies.body->turn[0], 1.0);
  hc_bodies_free(&bodies);
}
END_TEST

/* The largest deviation of the energy over some turns about the middle axis, which tumbles. */
static double tumble(int steps, double time) {
  hc_bodies bodies = make(1.0, 2.0, 2.5);
  const double start[3] = {0.02, 12.0, 0.03};
  memcpy(bodies.body->momentum, start, sizeof start);
  const double before = energy(&bodies);
  double largest = 0.0;
  int flips = 0;
  double last = 1.0;
  for (int k = 0; k < steps; k++) {
    step(&bodies, 0.0, time / steps);
    largest = fmax(largest, fabs(energy(&bodies) / before - 1.0));
    double up[3];
    hc_body_turned(bodies.body, (const double[3]){0, 1, 0}, up);
    if (up[1] * last < 0.0) flips++;
    last = up[1];
  }
  ck_assert_int_ge(flips, 4); /* the middle axis is unstable */
  for (int axis = 0; axis < 3; axis++)
    ck_assert_double_eq(bodies.body->momentum[axis], start[axis]); /* kept exactly */
  hc_bodies_free(&bodies);
  return largest;
}

START_TEST(a_top_keeps_its_energy_to_second_order) {
  const double coarse = tumble(4000, 20.0), fine = tumble(8000, 20.0);
  ck_assert_double_lt(coarse, 1e-3);
  ck_assert_double_lt(fine, 0.3 * coarse);
}
END_TEST

START_TEST(energy_does_not_drift) {
  const double early = tumble(20000, 20.0), late = tumble(200000, 200.0);
  ck_assert_double_lt(late, 2.0 * early + 1e-12);
}
END_TEST

START_TEST(what_is_locked_stays) {
  hc_bodies bodies = make(1, 2, 3);
  bodies.gravity[0] = 1.0;
  bodies.gravity[2] = -9.81;
  bodies.body->inertia[0][1] = bodies.body->inertia[1][0] = 0.3;
  bodies.body->locked = 4 | 8; /* z, roll */
  bodies.body->pulls = hc_alloc_zero(1, sizeof *bodies.body->pulls);
  bodies.body->pull_count = 1;
  bodies.body->pulls[0] = (hc_pull){.force = {0, 3, 1}, .arm = {0.3, 0.2, 0.1}, .stop = INFINITY};
  for (int k = 0; k < 200; k++) step(&bodies, 0.0, 1e-2);
  stand(&bodies, 0.0);
  double spin[3];
  hc_body_spin(bodies.body, spin);
  ck_assert(bodies.body->position[2] == 1000000 * HC_CELL_UNITS);
  ck_assert(bodies.body->position[0] > 1000000 * HC_CELL_UNITS);
  ck_assert_double_eq(spin[0], 0.0);
  ck_assert_double_gt(fabs(spin[2]), 0.1);
  hc_bodies_free(&bodies);
}
END_TEST

START_TEST(pulls_last_from_start_to_stop_and_turn_with_the_body) {
  hc_bodies bodies = make(1, 1, 1);
  hc_body *const body = bodies.body;
  body->pulls = hc_alloc_zero(1, sizeof *body->pulls);
  body->pull_count = 1;
  body->pulls[0] =
      (hc_pull){.force = {4, 0, 0}, .arm = {0, 0.5, 0}, .turns = true, .start = 1.0, .stop = 2.0};
  body->turn[0] = body->turn[3] = sqrt(0.5); /* a quarter about z */
  const double times[] = {0.999, 1.0, 1.999, 2.0};
  for (int k = 0; k < 4; k++) {
    stand(&bodies, times[k]);
    const hc_twist pull = hc_body_pull(&bodies, body);
    const bool pulls = k == 1 || k == 2;
    ck_assert_double_eq_tol(pull.linear[0], 0.0, 1e-12);
    ck_assert_double_eq_tol(pull.linear[1], pulls ? 4.0 : 0.0, 1e-12);
    ck_assert_double_eq_tol(pull.angular[2], pulls ? -2.0 : 0.0, 1e-12); /* arm (-0.5, 0) x (0, 4) */
  }
  hc_bodies_free(&bodies);
}
END_TEST

START_TEST(a_line_only_pulls_and_a_spring_swings) {
  hc_bodies bodies = make(1, 1, 1);
  hc_body *const body = bodies.body;
  for (int axis = 0; axis < 3; axis++) body->position[axis] = 0;
  body->moorings = hc_alloc_zero(1, sizeof *body->moorings);
  body->mooring_count = 1;
  body->moorings[0] = (hc_mooring){.anchor = {1, 0, 0}, .length = 1.5, .stiffness = 50.0};
  stand(&bodies, 0.0);
  ck_assert_double_eq(hc_body_pull(&bodies, body).linear[0], 0.0);
  ck_assert_double_eq(hc_body_tension(&bodies, body, 0), 0.0);
  body->moorings[0].pushes = true;
  ck_assert_double_eq_tol(hc_body_pull(&bodies, body).linear[0], -25.0, 1e-12);
  body->moorings[0].length = 0.9; /* swings by 0.1 m at sqrt(k/m) = 5 rad/s */
  double farthest = 0.0;
  int crossings = 0, steps = 0;
  double last = -0.1;
  for (; crossings < 4; steps++) {
    step(&bodies, 0.0, 1e-3);
    const double x = (double)body->position[0] * frame.unit[0] - 0.1;
    farthest = fmax(farthest, x);
    crossings += x * last < 0.0;
    last = x;
  }
  ck_assert_double_eq_tol(farthest, 0.1, 1e-3);
  ck_assert_double_eq_tol(steps * 1e-3, 1.75 * 2 * 3.14159265358979 / 5.0, 0.005);
  hc_bodies_free(&bodies);
}
END_TEST

START_TEST(arms_go_to_the_nearest_image) {
  hc_frame periodic = frame;
  periodic.period[0] = 20 * HC_CELL_UNITS;
  hc_bodies bodies = make(1, 1, 1);
  bodies.frame = &periodic;
  double arm[3];
  bodies.body->position[0] = -41 * HC_CELL_UNITS; /* = 19 */
  const int64_t at[3] = {HC_CELL_UNITS, 1000000 * HC_CELL_UNITS, 1000002 * HC_CELL_UNITS};
  hc_body_arm(&bodies, bodies.body, at, arm);
  ck_assert_double_eq_tol(arm[0], 0.1, 1e-12);
  ck_assert_double_eq(arm[1], 0.0);
  ck_assert_double_eq_tol(arm[2], 0.1, 1e-12);
  hc_bodies_free(&bodies);
}
END_TEST

START_TEST(angles_are_those_of_turns) {
  hc_bodies bodies = make(1, 1, 1);
  double angles[3];
  const double half = 3.14159265358979323846 / 360.0; /* of a degree, rad */
  for (int axis = 0; axis < 3; axis++) {
    const double turn[4] = {cos(20 * half), axis == 0 ? sin(20 * half) : 0, axis == 1 ? sin(20 * half) : 0,
                            axis == 2 ? sin(20 * half) : 0};
    memcpy(bodies.body->turn, turn, sizeof turn);
    hc_body_angles(bodies.body, angles);
    for (int k = 0; k < 3; k++) ck_assert_double_eq_tol(angles[k], k == axis ? 20.0 : 0.0, 1e-10);
  }
  hc_bodies_free(&bodies);
}
END_TEST

/* What came in beyond what the solver reckoned with is expected of the next step. */
START_TEST(the_next_step_expects_what_was_beyond) {
  hc_bodies bodies = make(1, 1, 1);
  hc_body *const body = bodies.body;
  bodies.reckons = true;
  stand(&bodies, 0.0);
  const hc_twist before = hc_body_momentum(body), impulse = {{3, 0, 0}, {0, 0, 0.5}};
  body->pushed.linear[0] = 1.0;
  hc_body_push(body, &impulse);
  hc_twist pushed = hc_body_momentum(body);
  hc_body_expect(&bodies, body, &before, &pushed, 0.1);
  ck_assert_double_eq_tol(body->held[0], 20.0, 1e-12);
  ck_assert_double_eq_tol(body->held[5], 5.0, 1e-12);
  /* a contact that bears it is expected, one that has thrown it back is not */
  const hc_twist falls = hc_body_momentum(body);
  memset(&body->pushed, 0, sizeof body->pushed);
  memset(body->held, 0, sizeof body->held);
  pushed = falls;
  pushed.linear[2] -= 0.5;
  hc_body_expect(&bodies, body, &falls, &pushed, 0.1);
  ck_assert_double_eq_tol(body->held[2], 0.0, 1e-12); /* -0.5 came, 0.5 bore it */
  memset(body->held, 0, sizeof body->held);
  pushed = falls;
  pushed.linear[0] -= 6.0; /* it came in at that, and was thrown back */
  hc_twist came = pushed;
  hc_body_expect(&bodies, body, &came, &pushed, 0.1);
  ck_assert_double_eq_tol(body->held[0], 0.0, 1e-12);
  hc_bodies_free(&bodies);
}
END_TEST

int main(void) {
  Suite *suite = suite_create("bodies");
  TCase *tests = tcase_create("bodies");
  tcase_set_timeout(tests, 60);
  tcase_add_test(tests, a_body_falls);
  tcase_add_test(tests, a_top_keeps_its_energy_to_second_order);
  tcase_add_test(tests, energy_does_not_drift);
  tcase_add_test(tests, what_is_locked_stays);
  tcase_add_test(tests, pulls_last_from_start_to_stop_and_turn_with_the_body);
  tcase_add_test(tests, a_line_only_pulls_and_a_spring_swings);
  tcase_add_test(tests, arms_go_to_the_nearest_image);
  tcase_add_test(tests, angles_are_those_of_turns);
  tcase_add_test(tests, the_next_step_expects_what_was_beyond);
  suite_add_tcase(suite, tests);
  SRunner *runner = srunner_create(suite);
  srunner_run_all(runner, CK_NORMAL);
  const int failed = srunner_ntests_failed(runner);
  srunner_free(runner);
  return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
