/* Moving walls and emitters in whole runs: back in time, across rebalances, full openings, limits. */
#include "mpi_scene.h"

#include "base/memory.h"
#include "state/copy.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static hc_wall walls[2];
static hc_scene_emitter emitter;

/* Water in a tank and a plate that swings into it. */
static hc_scene paddle(void) {
  hc_scene scene = make_scene(0.3, 0.12, 0.12);
  add_wall(&scene, 0.4, 0.12, 0.3, 0);
  memset(walls, 0, sizeof walls);
  walls[0] = wall;
  walls[1].box = (hc_box){{0.32, 0, 0.02}, {0.36, 0.12, 0.2}};
  walls[1].inside = HC_INSIDE_SOLID;
  walls[1].motion = (hc_wall_motion){.type = HC_WALL_COSINE,
                                     .direction = {1, 0, 0},
                                     .speed = 0.5,
                                     .axis = {0, 1, 0},
                                     .center = {0.34, 0, 0.3},
                                     .angle = 5,
                                     .frequency = 3,
                                     .phase = 60};
  scene.boundary.walls = walls;
  scene.boundary.wall_count = 2;
  scene.fluid.viscosity.model = HC_VISCOSITY_ARTIFICIAL;
  scene.fluid.viscosity.coefficient = 0.05;
  scene.parallel.rebalance = HC_REBALANCE_METIS;
  return scene;
}

/* An opening above the water, or wherever. */
static void add_emitter(hc_scene *scene, double z, double speed) {
  memset(&emitter, 0, sizeof emitter);
  emitter = (hc_scene_emitter){.form = HC_EMITTER_RECTANGLE,
                               .position = {0.15, 0.06, z},
                               .direction = {0, 0, -1},
                               .size = {0.08, 0.06},
                               .speed = speed,
                               .clearance = 0.7};
  scene->fluid.emitters = &emitter;
  scene->fluid.emitter_count = 1;
}

/* Only the fluid is copied: walls follow from the time. */
START_TEST(walls_and_emitters_go_back_in_time) {
  hc_scene scene = paddle();
  add_emitter(&scene, 0.25, 2.0);
  hc_simulation simulation;
  start(&simulation, &scene);
  do_steps(&simulation, 8);
  hc_state_copy copy = {.full = false};
  hc_state_remember(&copy, &simulation.state, HC_FLUID);
  const uint64_t before = state_of(&simulation);
  const int64_t total = simulation.world.fluid_total;
  scene.parallel.rebalance_at = 10;
  do_steps(&simulation, 12);
  const uint64_t later = state_of(&simulation);
  ck_assert_uint_ne(before, later);
  ck_assert_int_gt(simulation.world.fluid_total, total);
  hc_state_restore(&copy, &simulation.state);
  ck_assert_int_eq(simulation.world.fluid_total, total);
  scene.parallel.rebalance_at = 15;
  do_steps(&simulation, 12);
  EXPECT(state_of(&simulation) == later);
  ck_assert_int_eq(fluid_in(&simulation), simulation.world.fluid_total);
  hc_state_copy_free(&copy);
  hc_simulation_free(&simulation);
}
END_TEST

/* The sum of all boundary volumes of a wall. */
static double volume_of(const hc_simulation *simulation, int number) {
  const hc_particles *const stores[] = {simulation->world.boundary, simulation->world.moving};
  hc_sum sum;
  memset(&sum, 0, sizeof sum);
  for (int s = 0; s < 2; s++)
    for (int32_t k = 0; k < stores[s]->own; k++)
      if (hc_id_source_of(stores[s]->id[k]) == number) hc_sum_add(&sum, (double)stores[s]->volume[k]);
  hc_comm_sum_exact(&comm, &sum, 1);
  return hc_sum_value(&sum);
}

START_TEST(volumes_are_a_wall_s_own_and_stay) {
  hc_scene scene = paddle();
  walls[1].box.min[2] = 0.0;            /* it stands on the floor, a spacing from the floor's samples */
  scene.parallel.rebalance_above = 1e9; /* the clock of a busy machine starts none beside the forced one */
  hc_simulation simulation;
  start(&simulation, &scene);
  const double tank = volume_of(&simulation, 0), plate = volume_of(&simulation, 1);
  scene.parallel.rebalance_at = 3;
  do_steps(&simulation, 25);
  ck_assert_double_eq(volume_of(&simulation, 0), tank);
  ck_assert_double_eq(volume_of(&simulation, 1), plate);
  ck_assert_int_eq(simulation.balance.count, 1);
  hc_simulation_free(&simulation);

  scene.boundary.wall_count = 1; /* the tank alone */
  start(&simulation, &scene);
  ck_assert_double_eq(volume_of(&simulation, 0), tank);
  hc_simulation_free(&simulation);

  walls[0] = walls[1]; /* the plate alone */
  start(&simulation, &scene);
  ck_assert_double_eq(volume_of(&simulation, 0), plate);
  hc_simulation_free(&simulation);
}
END_TEST

START_TEST(a_wall_s_samples_move_with_it) {
  const hc_scene scene = paddle();
  hc_simulation simulation;
  start(&simulation, &scene);
  do_steps(&simulation, 15);
  const hc_pose pose = hc_motion_pose(&simulation.movers.walls[0].motion, simulation.time);
  ck_assert_double_gt(fabs(pose.shift[0]), 0.005);
  const hc_particles *boundary = simulation.world.moving;
  const hc_frame *frame = &simulation.world.frame;
  bool good = true;
  int64_t found = boundary->own;
  for (int32_t k = 0; k < boundary->own; k++) {
    good &= hc_id_source_of(boundary->id[k]) == 1;
    double arm[3];
    for (int a = 0; a < 3; a++)
      arm[a] = hc_frame_to_metres(frame, a, boundary->reference[3 * k + a]) - walls[1].motion.center[a];
    for (int a = 0; a < 3; a++) {
      double x = hc_frame_to_metres(frame, a, boundary->reference[3 * k + a]);
      for (int b = 0; b < 3; b++) x += pose.turn[a][b] * arm[b];
      x += pose.shift[a];
      good &= fabs(hc_frame_to_metres(frame, a, boundary->position[3 * k + a]) - x) < 1e-9;
    }
  }
  EXPECT(good);
  hc_comm_sum_i64(&comm, &found, 1);
  ck_assert_int_gt(found, 50);
  hc_simulation_free(&simulation);
}
END_TEST

/* All in the water: nothing fits in, nothing overlaps, the run goes on. */
START_TEST(a_full_place_takes_nothing) {
  hc_scene scene = make_scene(0.3, 0.12, 0.2);
  add_wall(&scene, 0.3, 0.12, 0.24, 0);
  add_emitter(&scene, 0.105, 0.5);
  emitter.position[0] = 0.155; /* the middle of the lattice's cells would have room */
  hc_simulation simulation;
  start(&simulation, &scene);
  const int64_t before = simulation.world.fluid_total;
  do_steps(&simulation, 30);
  const hc_emitter *counts = &simulation.population.emitters.emitters[0];
  ck_assert_int_eq(counts->emitted, 0);
  ck_assert_int_ge(counts->layers, 2);
  ck_assert_int_eq(counts->blocked, counts->layers * 12);
  ck_assert_int_eq(simulation.world.fluid_total, before);
  ck_assert_int_eq(fluid_in(&simulation), before);
  hc_simulation_free(&simulation);
}
END_TEST

static int ascending(const void *a, const void *b) {
  const uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
  return p < q ? -1 : p > q;
}

/* Free fall from an opening: layer by layer, up to the limit in the midst of one. */
START_TEST(an_emitter_keeps_time_and_its_limit) {
  hc_scene scene = make_scene(0.04, 0.04, 0.04);
  for (int a = 0; a < 3; a++) block.box.min[a] += 1.0, block.box.max[a] += 1.0;
  add_emitter(&scene, 0.5, 1.0);
  scene.time_step.max = 0.02;
  scene.time_step.factor = 0.9;
  emitter.max_particles = 100; /* 12 a layer */
  emitter.start = 0.011;
  hc_simulation simulation;
  start(&simulation, &scene);
  hc_error error = {.status = HC_OK, .text = ""};
  while (simulation.time < 0.25) {
    const double time = simulation.time;
    if (hc_simulation_step(&simulation, &error) != HC_OK) ck_abort_msg("%s", error.text);
    const double layers = time < 0.011 ? 0 : floor((time - 0.011) / 0.02) + 1;
    const double expected = fmin(12 * layers, 100);
    ck_assert_msg(fabs((double)(simulation.world.fluid_total - 8) - expected) < 0.5,
                  "%lld at %g s, expected %g", (long long)simulation.world.fluid_total - 8, time, expected);
  }
  ck_assert_int_eq(fluid_in(&simulation), 108);
  const hc_particles *fluid = simulation.world.fluid;
  bool good = true;
  for (int32_t k = 0; k < fluid->own; k++) {
    if (hc_id_source_of(fluid->id[k]) == 0) continue;
    const int64_t layer = (int64_t)(fluid->id[k] & (HC_ID_MAX_COUNTER - 1)) / 12;
    const double z = hc_frame_to_metres(&simulation.world.frame, 2, fluid->position[3 * k + 2]);
    good &= fabs(z - (0.5 - (simulation.time - 0.011 - 0.02 * (double)layer))) < 1e-3;
  }
  EXPECT(good);
  void *all;
  size_t bytes;
  hc_comm_gather_all(&comm, fluid->id, (size_t)fluid->own * sizeof *fluid->id, &all, &bytes);
  uint64_t *ids = all;
  qsort(ids, bytes / sizeof *ids, sizeof *ids, ascending);
  for (size_t k = 1; k < bytes / sizeof *ids; k++) ck_assert_uint_gt(ids[k], ids[k - 1]);
  hc_free(all);
  hc_simulation_free(&simulation);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("prescribed");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, walls_and_emitters_go_back_in_time);
  tcase_add_test(tests, volumes_are_a_wall_s_own_and_stay);
  tcase_add_test(tests, a_wall_s_samples_move_with_it);
  tcase_add_test(tests, a_full_place_takes_nothing);
  tcase_add_test(tests, an_emitter_keeps_time_and_its_limit);
  return run_mpi_tests("prescribed", tests);
}
