/* Rollbacks of the adaptive time step: the state two steps ago to the bit, whatever moved in between, shocks
 * one after the other, and the state that a checkpoint holds. */
#include "mpi_scene.h"

#include "base/memory.h"
#include "io/checkpoint.h"
#include "io/seal.h"
#include "stepping/adaptive.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* A column that collapses in a tank, on few iterations. */
static hc_scene dam(void) {
  hc_scene scene = make_scene(0.24, 0.12, 0.12);
  strcpy(scene.name, "dam");
  add_wall(&scene, 0.6, 0.12, 0.3, 0);
  scene.gravity[0] = 5.0;
  block.velocity[0] = 1.5;
  scene.time_step.control = HC_TIME_ADAPTIVE;
  scene.solver.density_error_avg = 0.01;
  scene.solver.density_error_max = 10.0; /* only the hook makes shocks */
  scene.time_step.adaptive = (hc_time_adaptive){.change = 0.002,
                                                .grow = {0.19, 0.39, 4.5, 0.9},
                                                .shrink = {0.2, 0.4, 5.5, 1.0},
                                                .shock = {5.0, 0.45},
                                                .restart = {0.2, 0.25, 0.5, 10},
                                                .first = {0.25, 0.2}};
  return scene;
}

START_TEST(a_shock_goes_back_two_steps) {
  hc_scene scene = dam();
  scene.faults.shock_at = 12;
  hc_simulation simulation;
  start(&simulation, &scene);
  uint64_t digests[13] = {0};
  double times[13] = {0};
  hc_step_report reports[13];
  for (int step = 0; step <= 12; step++) {
    ck_assert_int_eq(simulation.step, step);
    digests[step] = particles_of(&simulation);
    times[step] = simulation.time;
    reports[step] = simulation.report;
    /* owners change in each of the two steps; the hook looks at the step as it begins */
    scene.parallel.rebalance = step % 2 ? HC_REBALANCE_METIS : HC_REBALANCE_SLABS;
    scene.parallel.rebalance_at = step;
    do_steps(&simulation, 1);
  }
  ck_assert_int_eq(simulation.rollback.back, 2);
  ck_assert_int_eq(simulation.step, 11);
  ck_assert(simulation.time == times[11]);
  EXPECT(particles_of(&simulation) == digests[11]);
  /* what the choice of the step and the next shock go by has come back too */
  ck_assert(simulation.dt == times[11] - times[10] || fabs(simulation.dt - (times[11] - times[10])) < 1e-15);
  ck_assert(simulation.report.v_max == reports[11].v_max);
  ck_assert(simulation.report.force_max == reports[11].force_max);
  ck_assert(simulation.report.density_error_avg == reports[11].density_error_avg);
  ck_assert(simulation.report.density_error_max == reports[11].density_error_max);
  const double next = simulation.control.guard.next;
  ck_assert(next > 0.0 && next <= 0.5 * (times[12] - times[11]) * 1.003);
  do_steps(&simulation, 1);
  ck_assert(simulation.step == 12 && simulation.dt == next && simulation.control.before == 2);
  do_steps(&simulation, 1); /* the hook strikes once */
  ck_assert(simulation.step == 13 && simulation.control.before == 0);
  ck_assert_int_eq(simulation.control.guard.rollbacks, 1);
  hc_simulation_free(&simulation);
}
END_TEST

/* The replay does not hide in the division of the world, nor in which rank remembered what. */
START_TEST(rebalances_do_not_matter) {
  uint64_t ends[2];
  for (int forced = 0; forced < 2; forced++) {
    hc_scene scene = dam();
    scene.faults.shock_at = 6;
    scene.faults.shock_again = 2;
    scene.parallel.rebalance = forced ? HC_REBALANCE_METIS : HC_REBALANCE_NONE;
    scene.parallel.rebalance_every = forced;
    hc_simulation simulation;
    start(&simulation, &scene);
    while (simulation.step < 14) do_steps(&simulation, 1);
    ck_assert_int_eq(simulation.control.guard.rollbacks, 3);
    ends[forced] = state_of(&simulation);
    hc_simulation_free(&simulation);
  }
  EXPECT(ends[0] == ends[1]);
}
END_TEST

START_TEST(where_nothing_older_is_known_one_step_goes_back) {
  hc_scene scene = dam();
  scene.solver.density_error_max = 1e-6; /* every step is a shock */
  scene.time_step.adaptive.restart.most = 3;
  hc_simulation simulation;
  hc_error error = {.status = HC_OK, .text = ""};
  start(&simulation, &scene);
  const uint64_t begin = particles_of(&simulation);
  double last = INFINITY;
  for (int k = 1; k <= 4; k++) {
    do_steps(&simulation, 1);
    ck_assert(simulation.rollback.back == 1 && simulation.step == 0 && simulation.time == 0.0);
    EXPECT(particles_of(&simulation) == begin);
    const hc_shock_guard *guard = &simulation.control.guard;
    ck_assert(guard->next <= 0.5 * last && guard->restarts == k && guard->untold == k);
    last = guard->next;
  }
  ck_assert_int_eq(hc_simulation_step(&simulation, &error), HC_FAILED);
  EXPECT(strstr(error.text, "a shock came again in each of 3 replays") && strstr(error.text, "(26)"));
  ck_assert_int_eq(simulation.report.fault.kind, HC_FAULT_TIME_STEP);
  hc_simulation_free(&simulation);
}
END_TEST

START_TEST(the_floor_ends_it) {
  hc_scene scene = dam();
  scene.faults.shock_at = 4;
  scene.faults.shock_again = 1000;
  hc_simulation simulation;
  hc_error error = {.status = HC_OK, .text = ""};
  start(&simulation, &scene);
  while (simulation.step < 3) do_steps(&simulation, 1);
  scene.time_step.adaptive.restart.most = 1000;
  ((hc_adaptive_settings *)simulation.control.settings)->most_restarts = 1000;
  simulation.control.settings->min = simulation.dt / 100;
  int calls = 0;
  while (hc_simulation_step(&simulation, &error) == HC_OK && calls < 100) calls++;
  ck_assert_int_lt(calls, 25); /* 7 halvings */
  EXPECT(strstr(error.text, "is under its floor") && strstr(error.text, "a shock at ") &&
         strstr(error.text, "faults.shock_at"));
  hc_simulation_free(&simulation);
}
END_TEST

/* A shorter step may bear what this one did not; what was no number before it began, none will. */
START_TEST(a_step_that_diverges_is_a_shock) {
  hc_scene scene = dam();
  hc_simulation simulation;
  hc_error error = {.status = HC_OK, .text = ""};
  start(&simulation, &scene);
  do_steps(&simulation, 5);
  const uint64_t before = particles_of(&simulation);
  do_steps(&simulation, 1);
  const double dt = simulation.dt;
  scene.faults.kick_at = 6;
  do_steps(&simulation, 1);
  ck_assert(simulation.rollback.back == 2 && simulation.step == 5);
  EXPECT(particles_of(&simulation) == before);
  ck_assert_int_eq(simulation.control.guard.shock.kind, HC_SHOCK_FAULT);
  ck_assert(simulation.control.guard.next < 0.6 * dt && simulation.control.guard.next > 0.4 * dt);
  scene.faults.kick_at = 0;
  do_steps(&simulation, 2);
  ck_assert_int_eq(simulation.step, 7);
  scene.faults.nan_at = 7;
  ck_assert_int_eq(hc_simulation_step(&simulation, &error), HC_FAILED);
  EXPECT(strstr(error.text, "was no number as the step began"));
  hc_simulation_free(&simulation);
}
END_TEST

/* A folder that all ranks know. */
static void make_folder(char folder[64]) {
  strcpy(folder, "halocline_rollback_XXXXXX");
  if (comm.rank == 0) ck_assert_ptr_nonnull(mkdtemp(folder));
  hc_comm_broadcast(&comm, folder, 64, 0);
}

static void remove_checkpoint(const char *folder, const char *path) {
  hc_comm_barrier(&comm);
  if (comm.rank != 0) return;
  char below[HC_TEXT_PATH];
  snprintf(below, sizeof below, "%s/checkpoints", folder);
  ck_assert_int_eq(unlink(path), 0);
  ck_assert_int_eq(rmdir(below), 0);
  ck_assert_int_eq(rmdir(folder), 0);
}

/* Written just before the shock, in its replay, which meets it again, and behind. */
START_TEST(a_checkpoint_rolls_back_as_far) {
  for (int calls = 8; calls <= 13; calls++) {
    if (calls == 9 || calls == 11 || calls == 12)
      continue; /* 9, 11 meet the shock, and runs write none after it */
    hc_scene scene = dam();
    scene.faults.shock_at = 8;
    scene.faults.shock_again = 1;
    scene.parallel.rebalance_every = 3;
    hc_simulation simulation, other;
    hc_error error = {.status = HC_OK, .text = ""};
    char folder[64], path[HC_TEXT_PATH];
    int64_t bytes, step;
    make_folder(folder);
    start(&simulation, &scene);
    do_steps(&simulation, calls);
    const uint64_t now = state_of(&simulation);
    const int64_t at = simulation.step;
    hc_state_copy kept = {.full = false};
    hc_simulation_show_resumable(&simulation, &kept);
    ck_assert_int_eq(simulation.step, at - 1);
    const hc_moment moment = hc_simulation_moment(&simulation);
    ck_assert(hc_checkpoint_write(&comm, simulation.scene, &moment, &simulation.state, "test", folder, 2,
                                  &bytes, &error) == HC_OK);
    hc_simulation_show_now(&simulation, &kept);
    ck_assert_int_eq(simulation.step, at);
    EXPECT(state_of(&simulation) == now);

    ck_assert(hc_checkpoint_find(&comm, folder, INT64_MAX, path, &step, &error) == HC_OK);
    ck_assert_int_eq(step, at - 1);
    ck_assert(hc_simulation_prepare(&other, &comm, &scene, &error) == HC_OK);
    ck_assert_msg(hc_checkpoint_read(&comm, path, &other.state, &error) == HC_OK, "%s", error.text);
    hc_simulation_adopt(&other);
    do_steps(&other, 1);
    EXPECT(state_of(&other) == now);
    for (int k = 0; k < 6; k++) {
      do_steps(&simulation, 1);
      do_steps(&other, 1);
      ck_assert_int_eq(simulation.rollback.back, other.rollback.back);
      EXPECT(state_of(&other) == state_of(&simulation));
    }
    ck_assert_int_eq(other.control.guard.rollbacks, 2);
    remove_checkpoint(folder, path);
    hc_simulation_free(&simulation);
    hc_simulation_free(&other);
  }
}
END_TEST

int main(void) {
  hc_comm_start(&comm, NULL, NULL);
  TCase *tests = tcase_create("rollback");
  tcase_add_test(tests, a_shock_goes_back_two_steps);
  tcase_add_test(tests, rebalances_do_not_matter);
  tcase_add_test(tests, where_nothing_older_is_known_one_step_goes_back);
  tcase_add_test(tests, the_floor_ends_it);
  tcase_add_test(tests, a_step_that_diverges_is_a_shock);
  tcase_add_test(tests, a_checkpoint_rolls_back_as_far);
  return run_mpi_tests("rollback", tests);
}
