/* Births and deaths of one step are judged on what was there before any of them; the step places the world
 * once more where there were any, and builds its lists once. */
#include "mpi_scene.h"

#include "space/frame.h"

#include <math.h>

/* ---- counters: the linker sends the step's calls here ---- */

void __real_hc_world_place(hc_world *world);
void __real_hc_world_list(hc_world *world, const hc_selection *selection);
void __wrap_hc_world_place(hc_world *world);
void __wrap_hc_world_list(hc_world *world, const hc_selection *selection);

static int placed, listed, placed_before_list;

void __wrap_hc_world_place(hc_world *world) {
  placed++;
  __real_hc_world_place(world);
}

void __wrap_hc_world_list(hc_world *world, const hc_selection *selection) {
  listed++;
  placed_before_list = placed;
  __real_hc_world_list(world, selection);
}

/* ---- a block at rest, and an emitter that lies beyond the world's limits ---- */

enum { BLOCK_PARTICLES = 8 * 4 * 4, LAYER = 16, STEPS = 18, PLANTED = 5 };
static hc_scene_emitter emitter;

static hc_scene spring(void) {
  hc_scene scene = make_scene(0.16, 0.08, 0.08);
  emitter = (hc_scene_emitter){.form = HC_EMITTER_RECTANGLE,
                               .position = {-0.2, 0.04, 0.04},
                               .direction = {-1, 0, 0},
                               .size = {0.08, 0.08},
                               .speed = 1.0,
                               .start = 0.01,
                               .clearance = 0.8};
  scene.fluid.emitters = &emitter;
  scene.fluid.emitter_count = 1;
  scene.domain.leaving = HC_LEAVING_REMOVE;
  return scene;
}

/* What a step did. */
typedef struct told {
  bool due;
  int64_t emitted, blocked, left, total, counted;
  uint64_t first_left; /* of those that left the smallest id */
  int placed, listed, placed_before_list;
  uint64_t state;
} told;

/* Puts a particle of the block where a sample of the layer is going to be. */
static void plant(hc_simulation *simulation) {
  hc_particles *fluid = simulation->world.fluid;
  const hc_emitter *from = &simulation->population.emitters.emitters[0];
  hc_simulation_disturb(simulation); /* behind the last step nobody saw it */
  double x[3];
  hc_emitter_point(from, LAYER / 2, 0.001, x);
  for (int32_t k = 0; k < fluid->own; k++) {
    if (fluid->id[k] != PLANTED) continue;
    for (int axis = 0; axis < 3; axis++)
      fluid->position[3 * k + axis] = hc_frame_to_units(&simulation->world.frame, axis, x[axis]);
  }
}

/* Steps of the spring, before the first layer of which a particle is planted. */
static void run(hc_comm *ranks, told *all) {
  const hc_scene scene = spring();
  hc_simulation simulation;
  start_on(&simulation, ranks, &scene);
  hc_population *population = &simulation.population;
  population->limits.low[0] = hc_frame_to_units(&simulation.world.frame, 0, -0.1);
  memset(all, 0, STEPS * sizeof *all);
  for (int step = 0; step < STEPS; step++) {
    told *told = &all[step];
    told->due = hc_emitters_due(&population->emitters, simulation.time);
    if (told->due && population->emitters.emitters[0].layers == 0) plant(&simulation);
    placed = listed = 0;
    do_steps(&simulation, 1);
    told->placed = placed;
    told->listed = listed;
    told->placed_before_list = placed_before_list;
    told->emitted = population->emitted;
    told->blocked = population->blocked;
    told->left = population->departures.count;
    told->first_left = told->left ? population->departures.first[0].id : UINT64_MAX;
    told->total = simulation.world.fluid_total;
    told->counted = fluid_in(&simulation);
    told->state = state_of(&simulation);
  }
  hc_simulation_free(&simulation);
}

/* The first step in which a layer, and then another one, is due. */
static int due_step(const told *all, int after) {
  int step = after + 1;
  while (step < STEPS && !all[step].due) step++;
  ck_assert_int_lt(step + 1, STEPS);
  return step;
}

/* The planted particle leaves in the step in which it still blocks a sample; what comes in beyond the limits
 * leaves a step later. */
START_TEST(all_are_judged_on_the_state_before) {
  told all[STEPS];
  run(&comm, all);
  const int first = due_step(all, -1);
  ck_assert(all[first].left == 1 && all[first].first_left == PLANTED);
  ck_assert(all[first].blocked == 1 && all[first].emitted == LAYER - 1);
  ck_assert_int_eq(all[first].total, BLOCK_PARTICLES - 1 + LAYER - 1);
  ck_assert(all[first + 1].left == LAYER - 1 && all[first + 1].emitted == 0);
  ck_assert_int_eq(all[first + 1].total, BLOCK_PARTICLES - 1);
  const int second = due_step(all, first);
  ck_assert(all[second].left == 0 && all[second].blocked == 0 && all[second].emitted == LAYER);
  ck_assert(all[second + 1].left == LAYER);
  for (int step = 0; step < STEPS; step++) ck_assert_int_eq(all[step].total, all[step].counted);
}
END_TEST

START_TEST(a_step_places_twice_at_most_and_lists_once) {
  told all[STEPS];
  run(&comm, all);
  int changed = 0;
  for (int step = 0; step < STEPS; step++) {
    const bool change = all[step].emitted > 0 || all[step].left > 0;
    ck_assert_int_eq(all[step].placed, change ? 2 : 1);
    ck_assert_int_eq(all[step].listed, 1);
    ck_assert_int_eq(all[step].placed_before_list, all[step].placed);
    changed += change;
  }
  ck_assert(changed >= 4 && changed < STEPS); /* both, one of them, none */
}
END_TEST

START_TEST(any_number_of_ranks_does_the_same) {
  told all[STEPS], alone[STEPS];
  run(&comm, all);
  if (comm.rank == 0) {
    hc_comm self;
    memset(&self, 0, sizeof self);
    MPI_Comm_dup(MPI_COMM_SELF, &self.mpi);
    self.size = 1;
    run(&self, alone);
    hc_comm_finish(&self);
  }
  hc_comm_broadcast(&comm, alone, sizeof alone, 0);
  EXPECT(memcmp(all, alone, sizeof all) == 0);
}
END_TEST

int main(int argc, char **argv) {
  hc_comm_start(&comm, &argc, &argv);
  TCase *tests = tcase_create("population");
  tcase_set_timeout(tests, 100);
  tcase_add_test(tests, all_are_judged_on_the_state_before);
  tcase_add_test(tests, a_step_places_twice_at_most_and_lists_once);
  tcase_add_test(tests, any_number_of_ranks_does_the_same);
  return run_mpi_tests("population", tests);
}
