/* The state of a run: copies to go back to, across migration and rebalancing; checkpoints read back. */
#include "mpi_scene.h"

#include "io/checkpoint.h"
#include "io/seal.h"
#include "state/copy.h"

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
  return scene;
}

START_TEST(a_state_comes_back_across_a_rebalance) {
  hc_scene scene = dam();
  hc_simulation simulation;
  start(&simulation, &scene);
  do_steps(&simulation, 10);
  hc_state_history history = {.count = 0};
  uint64_t digests[6];
  for (int k = 0; k < 6; k++) {
    digests[k] = state_of(&simulation);
    hc_state_history_push(&history, &simulation.state, HC_FLUID);
    scene.parallel.rebalance_at = (int)simulation.step; /* every time, so that owners change in between */
    do_steps(&simulation, 1);
  }
  const uint64_t later = state_of(&simulation);
  for (int k = 1; k < 6; k++) ck_assert_uint_ne(digests[k], digests[k - 1]);

  /* the newest copy is the state before the last step; one more back, two steps ago */
  ck_assert(hc_state_history_return(&history, &simulation.state, 1));
  hc_simulation_disturb(&simulation);
  ck_assert_int_eq(simulation.step, 14);
  EXPECT(state_of(&simulation) == digests[4]);
  scene.parallel.rebalance_at = 14;
  do_steps(&simulation, 1);
  EXPECT(state_of(&simulation) == digests[5]);
  do_steps(&simulation, 1);
  EXPECT(state_of(&simulation) == later);

  /* what was gone back to is to be remembered anew, and older ones are gone */
  ck_assert(!hc_state_history_return(&history, &simulation.state, 0));
  hc_state_history_push(&history, &simulation.state, HC_FLUID);
  ck_assert(!hc_state_history_return(&history, &simulation.state, 1));
  ck_assert_int_eq(simulation.step, 16);
  do_steps(&simulation, 1);
  ck_assert(hc_state_history_return(&history, &simulation.state, 0));
  hc_simulation_disturb(&simulation);
  EXPECT(state_of(&simulation) == later);
  hc_state_history_free(&history);
  hc_simulation_free(&simulation);
}
END_TEST

START_TEST(particles_that_left_come_back_too) {
  hc_scene scene = dam();
  scene.domain.leaving = HC_LEAVING_REMOVE;
  hc_simulation simulation;
  start(&simulation, &scene);
  do_steps(&simulation, 3);
  const int64_t all = simulation.world.fluid_total;
  const uint64_t before = state_of(&simulation);
  hc_state_history history = {.count = 0};
  hc_state_history_push(&history, &simulation.state, HC_FLUID);
  hc_particles *fluid = simulation.world.fluid;
  for (int32_t k = 0; k < fluid->own; k++) /* every seventh is far away */
    if (fluid->id[k] % 7 == 0) fluid->position[3 * k + 2] -= 1000 * HC_CELL_UNITS;
  hc_simulation_disturb(&simulation);
  do_steps(&simulation, 1);
  ck_assert_int_lt(simulation.world.fluid_total, all);
  ck_assert(hc_state_history_return(&history, &simulation.state, 0));
  hc_simulation_disturb(&simulation);
  ck_assert_int_eq(simulation.world.fluid_total, all);
  EXPECT(state_of(&simulation) == before);
  do_steps(&simulation, 1);
  ck_assert_int_eq(simulation.world.fluid_total, all);
  hc_state_history_free(&history);
  hc_simulation_free(&simulation);
}
END_TEST

/* A folder that all ranks know. */
static void make_folder(char folder[64]) {
  strcpy(folder, "halocline_state_XXXXXX");
  if (comm.rank == 0) ck_assert_ptr_nonnull(mkdtemp(folder));
  hc_comm_broadcast(&comm, folder, 64, 0);
}

START_TEST(a_checkpoint_is_the_state) {
  const hc_scene scene = dam();
  hc_simulation simulation, other;
  hc_error error = {.status = HC_OK, .text = ""};
  char folder[64], path[HC_TEXT_PATH];
  int64_t bytes, step;
  make_folder(folder);
  start(&simulation, &scene);
  do_steps(&simulation, 12);
  const uint64_t before = state_of(&simulation);
  const hc_moment moment = hc_simulation_moment(&simulation);
  ck_assert_msg(hc_checkpoint_write(&comm, simulation.scene, &moment, &simulation.state, "test", folder, 2,
                                    &bytes, &error) == HC_OK,
                "%s", error.text);
  EXPECT(state_of(&simulation) == before); /* writing changes nothing */
  do_steps(&simulation, 5);
  const uint64_t after = state_of(&simulation);

  ck_assert(hc_checkpoint_find(&comm, folder, INT64_MAX, path, &step, &error) == HC_OK);
  ck_assert_int_eq(step, 12);
  ck_assert(hc_seal_check(&comm, path, &error) == HC_OK);
  ck_assert(hc_simulation_prepare(&other, &comm, &scene, &error) == HC_OK);
  ck_assert_msg(hc_checkpoint_read(&comm, path, &other.state, &error) == HC_OK, "%s", error.text);
  hc_simulation_adopt(&other);
  EXPECT(state_of(&other) == before);
  do_steps(&other, 5);
  EXPECT(state_of(&other) == after);

  /* an item that the file does not know is an error on every rank */
  double unknown = 0.0;
  hc_state_add(&other.state, HC_TYPE_f64, 1, &unknown, "unknown");
  ck_assert(hc_checkpoint_read(&comm, path, &other.state, &error) == HC_IO_FAILED);
  EXPECT(strstr(error.text, "attribute unknown is missing"));
  hc_comm_barrier(&comm);
  if (comm.rank == 0) {
    char below[HC_TEXT_PATH];
    snprintf(below, sizeof below, "%s/checkpoints", folder);
    ck_assert_int_eq(unlink(path), 0);
    ck_assert_int_eq(rmdir(below), 0);
    ck_assert_int_eq(rmdir(folder), 0);
  }
  hc_simulation_free(&simulation);
  hc_simulation_free(&other);
}
END_TEST

int main(void) {
  hc_comm_start(&comm, NULL, NULL);
  TCase *tests = tcase_create("state");
  tcase_add_test(tests, a_state_comes_back_across_a_rebalance);
  tcase_add_test(tests, particles_that_left_come_back_too);
  tcase_add_test(tests, a_checkpoint_is_the_state);
  return run_mpi_tests("state", tests);
}
